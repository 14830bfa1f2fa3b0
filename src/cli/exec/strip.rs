//! `exec --strip`: what each register holds after each line, side by side.

use image::RgbImage;
use miette::miette;

use super::moment::Moment;
use crate::{
    array::{Array, Register},
    cli::input::opened_program::Opened,
    event::Packet,
    picture::{StripCell, panel, strip},
    plane::Plane,
    program::{Action, CellEffect, Step},
};

/// The lines of one frame, with what registers held behind each.
pub struct Strip {
    /// Those that the program writes.
    registers: Vec<Register>,
    columns: Vec<Column>,
}

struct Column {
    line: u32,
    /// Of each register: what it holds, and whether this line wrote.
    cells: Vec<(Plane<f64>, bool)>,
}

impl Strip {
    pub const fn new(registers: Vec<Register>) -> Self {
        Self {
            registers,
            columns: Vec::new(),
        }
    }

    /// Runs a frame line by line; what an earlier frame left is forgotten.
    pub fn frame(
        &mut self,
        opened: &Opened,
        chip: &mut dyn Array,
        moment: &Moment<'_>,
        packet: &mut Packet,
    ) -> miette::Result<()> {
        self.columns.clear();
        for line in lines(moment.steps) {
            chip.run_steps(line, moment.t, packet)?;
            let written = CellEffect::of(line, &opened.device).writes;
            let number = line.first().map_or(0, |step| step.line);
            if written.is_empty() {
                continue;
            }
            let names: Vec<String> = written.iter().map(|c| c.name(&opened.device)).collect();
            let cells = self.registers.iter().map(|register| {
                let wrote = names.contains(&register.name(&opened.device));
                (register.values(chip), wrote)
            });
            self.columns.push(Column {
                line: number,
                cells: cells.collect(),
            });
        }
        Ok(())
    }

    /// What is written in the picture, besides the names of registers.
    pub fn texts<'a>(&'a self, opened: &'a Opened) -> impl Iterator<Item = &'a str> {
        let text: Vec<&str> = opened.program.text.lines().collect();
        let sources = self.columns.iter().map(move |column| column.source(&text));
        [title(opened)].into_iter().chain(sources)
    }

    /// The picture: a row for each register, a column for each line that writes.
    pub fn picture(&self, opened: &Opened) -> miette::Result<RgbImage> {
        let device = &opened.device;
        let registers = &self.registers;
        let (low, high) = device.register_range();
        let text: Vec<&str> = opened.program.text.lines().collect();
        let columns = self.columns.iter().map(|column| {
            let source = column.source(&text);
            let cells = registers.iter().zip(&column.cells);
            let cells = cells.map(|(register, (values, written))| {
                let (black, white) = if register.is_bit() {
                    (0.0, 1.0)
                } else {
                    (low, high)
                };
                StripCell {
                    picture: panel::frame(values, black, white),
                    written: *written,
                }
            });
            (format!("{} {source}", column.line), cells.collect())
        });
        if self.columns.is_empty() {
            return Err(miette!(
                help = "a strip shows registers that the last frame writes",
                "{} has nothing to show: no line of it writes a register",
                opened.program.file
            ));
        }
        let rows: Vec<String> = registers.iter().map(|r| r.name(device)).collect();
        Ok(strip(title(opened), &rows, &columns.collect::<Vec<_>>())?)
    }
}

impl Column {
    /// Its line in the text of the program.
    fn source<'a>(&self, text: &[&'a str]) -> &'a str {
        let at = (self.line as usize).saturating_sub(1);
        text.get(at).map_or("", |line| line.trim())
    }
}

fn title(opened: &Opened) -> &str {
    let title = opened.program.settings.title.as_ref();
    title.unwrap_or(&opened.program.file)
}

/// The most columns of a strip of this program.
pub fn columns(parts: &[&[Step]]) -> usize {
    parts
        .iter()
        .map(|steps| lines(steps).count())
        .max()
        .unwrap_or(0)
}

/// The steps, cut where the line changes.
fn lines(steps: &[Step]) -> impl Iterator<Item = &[Step]> {
    // A `repeat` of the program stays one column: its last turn is what is seen.
    steps.chunk_by(|a, b| {
        let whole = |step: &Step| !matches!(step.action, Action::Repeat { .. });
        a.line == b.line && whole(a) == whole(b)
    })
}
