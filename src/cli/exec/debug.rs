//! `exec --debug`: a program step by step, its registers on the terminal.

use std::{
    collections::BTreeSet,
    fmt::Write as _,
    io::{IsTerminal, Write},
    ops::ControlFlow,
    path::Path,
};

use miette::{Diagnostic, miette};

use super::{bench::Bench, moment::Moment, reading};
use crate::{
    array::{Array, Register},
    cli::{
        input::opened_program::Opened,
        output::{content::Content, files::Output, print::say},
    },
    event::Packet,
    picture::{panel, write_png},
    plane::{Plane, Size},
    program::{Action, Step},
    source,
    unit::{Lsb, Micros, counted},
};

const HELP: &str = "\
  step [N]            run one instruction, or N                          (s, an empty line)
  next frame          run on to the first instruction of the next frame  (n)
  continue            run on to the next break                           (c)
  break LINE          stop before this line; without LINE: list them     (b)
  clear LINE          do not stop there any more
  print REG           a register as a picture                            (p)
  print REG X Y       what it holds at column X, row Y, from the top left
  dump REG FILE.png   a register as a file
  where am I          the lines around                                   (w)
  help                this list                                          (h)
  quit                no further; the end of the input does the same     (q)
";

/// Why it runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    /// So many instructions more.
    Step(u64),
    /// To the next frame.
    Frame,
    /// To the next break.
    Continue,
    /// Nothing more is to run.
    Quit,
}

/// A program that is stepped through.
pub struct Debugger<'a> {
    opened: &'a Opened,
    /// Lines on which an instruction begins.
    lines: BTreeSet<u32>,
    mode: Mode,
    breaks: BTreeSet<u32>,
    /// The line of the instruction before.
    last: Option<u32>,
    frame: u64,
    t: Micros,
    /// The instruction that comes next.
    next: Option<(u32, String)>,
    /// Registers as ink, not as letters.
    colour: bool,
    columns: usize,
}

impl<'a> Debugger<'a> {
    pub fn new(bench: &'a Bench<'_>) -> Self {
        let mut lines = BTreeSet::new();
        for steps in bench.codes() {
            collect(steps, &mut lines);
        }
        let plain = std::env::var_os("NO_COLOR").is_some_and(|v| !v.is_empty());
        let columns = std::env::var("COLUMNS").ok().and_then(|c| c.parse().ok());
        Self {
            opened: &bench.opened,
            lines,
            mode: Mode::Step(0),
            breaks: BTreeSet::new(),
            last: None,
            frame: 0,
            t: Micros(0),
            next: None,
            colour: std::io::stdout().is_terminal() && !plain,
            columns: columns.unwrap_or(80usize).clamp(8, 1000),
        }
    }

    /// Runs a frame as it is told.
    pub fn frame(
        &mut self,
        chip: &mut dyn Array,
        moment: &Moment<'_>,
        packet: &mut Packet,
    ) -> miette::Result<ControlFlow<()>> {
        (self.frame, self.t, self.last) = (moment.index, moment.t, None);
        if self.mode == Mode::Frame {
            self.mode = Mode::Step(0);
        }
        self.steps(moment.steps, chip, packet)
    }

    /// After the last frame: a last look.
    pub fn end(&mut self, chip: &dyn Array) -> miette::Result<()> {
        if self.mode != Mode::Quit {
            self.next = None;
            say("the program has ended\n");
            while self.mode != Mode::Quit {
                self.ask(chip)?;
                if self.mode != Mode::Quit {
                    say("the program has ended; `quit` leaves\n");
                }
            }
        }
        Ok(())
    }

    fn steps(
        &mut self,
        steps: &[Step],
        chip: &mut dyn Array,
        packet: &mut Packet,
    ) -> miette::Result<ControlFlow<()>> {
        for step in steps {
            let flow = match &step.action {
                Action::Repeat { times, body } => {
                    let mut flow = ControlFlow::Continue(());
                    for _ in 0..*times {
                        self.last = None;
                        flow = self.steps(body, chip, packet)?;
                        if flow.is_break() {
                            break;
                        }
                    }
                    flow
                }
                Action::Word(word) => {
                    let text = word.text(&self.opened.device);
                    self.one(step, text, chip, packet)?
                }
                Action::Host(host) => {
                    let text = host.text(&self.opened.device);
                    self.one(step, text, chip, packet)?
                }
            };
            if flow.is_break() {
                return Ok(flow);
            }
        }
        Ok(ControlFlow::Continue(()))
    }

    /// One instruction; stops before it if it is told to.
    fn one(
        &mut self,
        step: &Step,
        text: String,
        chip: &mut dyn Array,
        packet: &mut Packet,
    ) -> miette::Result<ControlFlow<()>> {
        let text = match &step.origin {
            Some(origin) => format!("{text} ({origin})"),
            None => text,
        };
        self.next = Some((step.line, text));
        let arrives = self.last != Some(step.line);
        let breaks = arrives && self.breaks.contains(&step.line);
        if self.mode == Mode::Step(0) || breaks {
            self.show_next();
            self.ask(chip)?;
        }
        if self.mode == Mode::Quit {
            return Ok(ControlFlow::Break(()));
        }
        let (events, readings) = (packet.events.len(), chip.readings().len());
        chip.run_steps(std::slice::from_ref(step), self.t, packet)?;
        if let Mode::Step(left) = &mut self.mode {
            *left -= 1;
            let new = packet.events.len() - events;
            if matches!(step.action, Action::Host(_)) && new > 0 {
                say(&format!("  {} read out\n", counted(new, "event")));
            }
            for reading in chip.readings().get(readings..).unwrap_or_default() {
                say(&format!("  read {}\n", reading::line(reading)));
            }
        }
        self.last = Some(step.line);
        Ok(ControlFlow::Continue(()))
    }

    fn show_next(&self) {
        if let Some((line, text)) = &self.next {
            say(&format!("frame {}, line {line}: {text}\n", self.frame));
        }
    }

    /// Takes commands until one of them lets the program run on.
    fn ask(&mut self, chip: &dyn Array) -> miette::Result<()> {
        loop {
            if std::io::stdin().is_terminal() {
                say("> ");
                // A prompt that does not show is no reason to stop.
                let _ = std::io::stdout().flush();
            }
            let read = source::line(std::io::stdin().lock()).map_err(|cause| {
                miette!(
                    help = "commands are lines of text",
                    "cannot read a command: {cause}"
                )
            })?;
            let Some(line) = read else {
                self.mode = Mode::Quit;
                return Ok(());
            };
            let words: Vec<&str> = line.split_whitespace().collect();
            match self.obey(&words, chip) {
                Ok(Some(mode)) => {
                    self.mode = mode;
                    return Ok(());
                }
                Ok(None) => {}
                Err(message) => say(&format!("{message}\n")),
            }
        }
    }

    /// One command: how to run on, if it says so.
    fn obey(&mut self, words: &[&str], chip: &dyn Array) -> Result<Option<Mode>, String> {
        Ok(Some(match words {
            [] | ["step" | "s"] => Mode::Step(1),
            ["step" | "s", n] => match n.parse() {
                Ok(n @ 1..) => Mode::Step(n),
                _ => return Err(format!("`{n}` is not a number of instructions")),
            },
            ["next", "frame"] | ["next" | "n"] => Mode::Frame,
            ["continue" | "c"] => Mode::Continue,
            ["quit" | "q" | "exit"] => Mode::Quit,
            _ => {
                self.look(words, chip)?;
                return Ok(None);
            }
        }))
    }

    /// The commands that run nothing.
    fn look(&mut self, words: &[&str], chip: &dyn Array) -> Result<(), String> {
        match words {
            ["help" | "h" | "?"] => say(HELP),
            ["where" | "w", ..] => say(&self.around()),
            ["break" | "b"] => {
                let lines: Vec<String> = self.breaks.iter().map(ToString::to_string).collect();
                say(&match lines.as_slice() {
                    [] => "no breaks\n".to_owned(),
                    lines => format!("breaks at line {}\n", lines.join(", ")),
                });
            }
            ["break" | "b", line] => {
                let line = self.line(line)?;
                self.breaks.insert(line);
                say(&format!("stops before line {line}\n"));
            }
            ["clear", line] => {
                let number = line
                    .parse()
                    .map_err(|_| format!("`{line}` is not a line"))?;
                if !self.breaks.remove(&number) {
                    return Err(format!("there is no break at line {number}"));
                }
                say(&format!("no longer stops before line {number}\n"));
            }
            ["print" | "p", name] => {
                let register = self.register(name)?;
                say(&self.picture(name, register, chip));
            }
            ["print" | "p", name, x, y] => {
                let register = self.register(name)?;
                let values = register.values(chip);
                let place = x.parse().ok().zip(y.parse().ok());
                let value = place.and_then(|(x, y): (usize, usize)| values.get((y, x)));
                let value = value.ok_or_else(|| {
                    let size = Size::of(&values);
                    format!("there is no pixel ({x}, {y}) on an array of {size}")
                })?;
                let unit = if register.is_bit() { "" } else { " LSB" };
                say(&format!("{name} at ({x}, {y}) is {value}{unit}\n"));
            }
            ["dump", name, file] => {
                let register = self.register(name)?;
                let (black, white) = self.scale(register);
                let picture = panel::frame(&register.values(chip), black, white);
                let output = Output::late(Path::new(file), Content::Picture);
                let output = output.map_err(|e| e.to_string())?;
                write_png(&output, &picture).map_err(|e| e.to_string())?;
                say(&format!("{name} is in {file}\n"));
            }
            ["print" | "p" | "dump", ..] => {
                return Err("write `print REG`, `print REG X Y` or `dump REG FILE.png`".to_owned());
            }
            other => {
                return Err(format!(
                    "`{}` is no command; `help` lists them",
                    other.join(" ")
                ));
            }
        }
        Ok(())
    }

    fn register(&self, name: &str) -> Result<Register, String> {
        Register::named(&self.opened.device, name).map_err(|unknown| {
            let help = Diagnostic::help(&unknown).map(|help| format!("; {help}"));
            format!("{unknown}{}", help.unwrap_or_default())
        })
    }

    /// A line on which an instruction begins.
    fn line(&self, text: &str) -> Result<u32, String> {
        let number: u32 = text
            .parse()
            .map_err(|_| format!("`{text}` is not a line"))?;
        if self.lines.contains(&number) {
            return Ok(number);
        }
        Err(match self.lines.range(number..).next() {
            Some(next) => format!("no instruction is on line {number}; the next is on line {next}"),
            None => format!("no instruction is on line {number} or below"),
        })
    }

    /// The lines of the text around the next instruction.
    fn around(&self) -> String {
        let Some((line, text)) = &self.next else {
            return "behind the last instruction\n".to_owned();
        };
        let mut shown = format!("frame {} at {} us, before {text}\n", self.frame, self.t.0);
        let lines = (1u32..).zip(self.opened.program.text.lines());
        for (number, source) in lines.filter(|(number, _)| number.abs_diff(*line) <= 2) {
            let mark = if number == *line { ">" } else { " " };
            // Writing to a string cannot fail.
            let _ = writeln!(shown, "{mark}{number:>4}  {source}");
        }
        shown
    }

    /// What is black and what is white in a file.
    fn scale(&self, register: Register) -> (f64, f64) {
        if register.is_bit() {
            return (0.0, 1.0);
        }
        self.opened.device.register_range()
    }

    /// A register in half blocks, as wide as the terminal allows.
    fn picture(&self, name: &str, register: Register, chip: &dyn Array) -> String {
        let values = register.values(chip);
        let fold = |from: f64, of: fn(f64, f64) -> f64| values.iter().copied().fold(from, of);
        let (low, high) = (
            fold(f64::INFINITY, f64::min),
            fold(f64::NEG_INFINITY, f64::max),
        );
        let mean = values.mean().unwrap_or(0.0);
        let mut shown = if register.is_bit() {
            let set = values.iter().filter(|v| **v == 1.0).count();
            format!("{name}: {set} of {} pixels are 1\n", values.len())
        } else {
            format!(
                "{name}: {:.2} (black) to {:.2} (white), mean {:.2}\n",
                Lsb(low),
                Lsb(high),
                Lsb(mean)
            )
        };
        let (black, white) = if register.is_bit() {
            (0.0, 1.0)
        } else {
            (low, high)
        };
        let small = shrunk(&values, self.columns);
        let gray = small.mapv(|v| {
            let part = (v - black) / (white - black);
            // One level everywhere is neither black nor white.
            if part.is_finite() {
                part.clamp(0.0, 1.0)
            } else {
                0.5
            }
        });
        let (height, width) = gray.dim();
        for y in (0..height).step_by(2) {
            for x in 0..width {
                let upper = gray[(y, x)];
                let lower = gray.get((y + 1, x)).copied();
                shown.push_str(&self.half_blocks(upper, lower));
            }
            if self.colour {
                shown.push_str("\x1b[0m");
            }
            shown.push('\n');
        }
        shown
    }

    /// Two pixels above each other.
    fn half_blocks(&self, upper: f64, lower: Option<f64>) -> String {
        if !self.colour {
            const SHADES: [&str; 5] = [" ", "░", "▒", "▓", "█"];
            let both = f64::midpoint(upper, lower.unwrap_or(upper));
            let shade = (both * 4.0).round() as usize;
            return SHADES.get(shade).copied().unwrap_or("█").to_owned();
        }
        let level = |part: f64| (part * 255.0).round() as u8;
        let upper = level(upper);
        let ink = format!("\x1b[38;2;{upper};{upper};{upper}m");
        match lower.map(level) {
            Some(lower) => format!("{ink}\x1b[48;2;{lower};{lower};{lower}m▀"),
            None => format!("{ink}\x1b[49m▀"),
        }
    }
}

fn collect(steps: &[Step], lines: &mut BTreeSet<u32>) {
    for step in steps {
        match &step.action {
            Action::Repeat { body, .. } => collect(body, lines),
            Action::Word(_) | Action::Host(_) => {
                lines.insert(step.line);
            }
        }
    }
}

/// No wider than so many columns: means of squares of pixels.
fn shrunk(values: &Plane<f64>, columns: usize) -> Plane<f64> {
    let (height, width) = values.dim();
    let by = width.div_ceil(columns.max(1)).max(1);
    if by == 1 {
        return values.clone();
    }
    Plane::from_shape_fn((height.div_ceil(by), width.div_ceil(by)), |(y, x)| {
        let part = |i: usize, n: usize| i * by..((i + 1) * by).min(n);
        let part = values.slice(ndarray::s![part(y, height), part(x, width)]);
        part.mean().unwrap_or(0.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wide_picture_becomes_means() {
        let plane = Plane::from_shape_fn((3, 5), |(y, x)| (y * 5 + x) as f64);
        assert_eq!(shrunk(&plane, 5), plane);
        let small = shrunk(&plane, 3);
        assert_eq!(small.dim(), (2, 3));
        assert_eq!(small[(0, 0)], 3.0);
        assert_eq!(small[(1, 2)], 14.0);
    }
}
