//! From a point to a sensor that can watch: a float model in its number format, or a chip with
//! its program.

use serde_json::json;

use super::{description, level_program::LevelProgram};
use crate::{
    array::{self, Arithmetic, Unheld},
    number::Format,
    plane::Size,
    reference::{Description, MemoryRule},
    rig::Larger,
    sensor::Sensor,
    study::{
        design::Compiled,
        sweep::{
            measurement::{memo::Shared, refusal::Refusal},
            points::plan::Entry,
            study_file::study::Settings,
            tables::table::Row,
        },
    },
};

/// A float point.
pub(in crate::study::sweep) struct Float {
    pub description: Description,
    pub format: Format,
    pub seed: u64,
}

/// What a float point says; the memory of its sensor goes into the row.
pub(in crate::study::sweep) fn float(entry: &Entry, row: &mut Row) -> Result<Float, Refusal> {
    let point = &entry.point;
    let format: Format = point.word("format").unwrap_or("f64").parse()?;
    let description = description::description(point, &entry.kernels)?;
    let bytes = float_state(&description, format) * entry.scene.size.pixels() as u64;
    row.insert("state_memory_bytes".to_owned(), json!(bytes));
    Ok(Float {
        description,
        format,
        seed: point.whole("seed").unwrap_or(0),
    })
}

/// Bytes of one value.
const fn bytes(format: Format) -> u64 {
    format.bytes()
}

/// Bytes of a pixel that must last from one frame to the next: the memory of each of its cells,
/// or one for all, for a memory that steps a count and the drive of the frame before, the time of a
/// cell's last event under a dead time, its share of a low-pass and of a sheet.
fn float_state(description: &Description, format: Format) -> u64 {
    let held = bytes(format);
    let cells = description.channels.len() as u64;
    let memories = if description.shared { 1 } else { cells };
    let step = description.memory == MemoryRule::FilteredStep;
    let sheets = { description.channels.iter() }
        .filter_map(|channel| channel.surrounds.as_ref())
        .flat_map(|surrounds| &surrounds.sheets);
    let moving = sheets.filter(|sheet| sheet.tau > 0.0).count();
    memories * held
        + if step { cells * (4 + held) } else { 0 }
        + if description.refractory.us > 0.0 {
            cells * 8
        } else {
            0
        }
        + if description.noise.cutoff_hz > 0.0 {
            8
        } else {
            0
        }
        + 8 * moving as u64
}

/// The program of an array point, and how its array is worked on.
pub(in crate::study::sweep) struct Programmed {
    pub compiled: Compiled,
    pub settings: array::Settings,
}

impl Programmed {
    /// The program on an array of this arithmetic.
    pub fn sensor(
        &self,
        arithmetic: Arithmetic,
        size: Size,
        all: bool,
    ) -> Result<Box<dyn Sensor + Send>, Refusal> {
        let chip = self.compiled.chip(arithmetic, size, self.settings)?;
        Ok(if all {
            Box::new(self.compiled.all_events(chip))
        } else {
            chip
        })
    }

    /// Which of the program's numbers cells of this arithmetic do not hold.
    pub fn unheld(&self, arithmetic: Arithmetic) -> Option<Unheld> {
        let code = &self.compiled.code;
        let parts = [&code.init[..], &code.frame];
        Unheld::of_program(arithmetic, &parts, &self.compiled.device, &self.settings)
    }
}

/// The program of an array point; what it costs goes into the row.
pub(in crate::study::sweep) fn array_of(
    settings: &Settings,
    entry: &Entry,
    shared: &Shared,
    row: &mut Row,
) -> Result<Programmed, Refusal> {
    let point = &entry.point;
    let word = |key: &str| point.word(key).unwrap_or_default().to_owned();
    let seed = point.whole("seed").unwrap_or(0);
    let device = entry
        .chip
        .as_ref()
        .ok_or_else(|| Refusal::Cannot("there is no chip".to_owned()))?;
    Larger::check(&word("scene"), entry.scene.size, device)?;
    let kinds = (0..).zip(&*entry.kernels).map(|(kind, kernel)| {
        let [on, off, _] = point.threshold(kind);
        (description::rows(kernel), on, off)
    });
    let kinds: Vec<_> = kinds.collect();
    let rounding = if word("quantise").ends_with(":stochastic") {
        seed
    } else {
        0
    };
    // What a program is best at is to decide at its threshold.
    let key = format!(
        "{kinds:?} {} {} {} {} {rounding}",
        word("chip"),
        word("quantise"),
        word("sum"),
        word("memory"),
    );
    let made = shared.program(&key, || LevelProgram::new(settings, entry, rounding));
    let LevelProgram {
        compiled,
        quantisation_error,
        erased,
    } = match made.get() {
        Some(Ok(made)) => made.clone(),
        Some(Err(refusal)) => return Err(refusal.clone()),
        None => return Err(Refusal::Cannot("the program was not made".to_owned())),
    };
    let arithmetic: Arithmetic = word("domain").parse()?;
    let size = entry.scene.size;
    let mut put = |name: &str, value: serde_json::Value| row.insert(name.to_owned(), value);
    put("words", json!(compiled.cost.words.0));
    put("array_us", json!(compiled.cost.array_us));
    put("registers", json!(compiled.registers()));
    put("prescale_bits", json!(compiled.program.filter.prescale));
    put("quantisation_error", json!(quantisation_error));
    if !erased.is_empty() {
        put("warnings", json!(erased.join(" ")));
    }
    let cell = match arithmetic {
        Arithmetic::Number(format) => bytes(format),
        Arithmetic::Silicon { .. } => size_of::<f32>() as u64,
    };
    // Every analogue register and PIX, every one-bit register and FLAG.
    let analog = device.registers().analog.len() as u64 + 1;
    let digital = device.registers().digital.len() as u64 + 1;
    let pixels = size.pixels() as u64;
    put(
        "state_memory_bytes",
        json!(analog * cell * pixels + (digital * pixels).div_ceil(8)),
    );
    // Points run side by side, so that one thread each is enough.
    let settings = array::Settings {
        schedule: Some(word("schedule").parse()?),
        threads: Some(1),
        ..compiled.settings()
    };
    Ok(Programmed { compiled, settings })
}
