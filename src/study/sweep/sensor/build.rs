//! From a point to a sensor that can watch: a float model in its number format, or a chip with
//! its program.

use std::sync::Arc;

use serde_json::json;

use super::{
    description,
    level_program::{LevelProgram, ProgramSpec},
};
use crate::{
    array::{self, Arithmetic, Schedule, Unheld},
    isa::Device,
    kernel::Kernel,
    number::Format,
    plane::Size,
    reference::{Description, StateBytes},
    rig::Larger,
    sensor::Sensor,
    study::{
        design::Compiled,
        sweep::{
            measurement::{memo::Shared, refusal::Refusal},
            points::{plan::Entry, point::Point},
            study_file::study::Settings,
            tables::table::Row,
        },
    },
};

/// All that makes a float point, besides its scene.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::study::sweep) struct Float {
    pub description: Description,
    pub format: Format,
    pub seed: u64,
}

/// What a float point says; the memory of its sensor goes into the row.
pub(in crate::study::sweep) fn float(entry: &Entry, row: &mut Row) -> Result<Float, Refusal> {
    let float = Float::of(&entry.point, &entry.kernels)?;
    let state = StateBytes::of(&float.description, float.format.bytes() as usize).sum();
    let bytes = state as u64 * entry.scene.size.pixels() as u64;
    row.insert("state_memory_bytes".to_owned(), json!(bytes));
    Ok(float)
}

impl Float {
    pub(super) fn of(point: &Point, kernels: &[Kernel]) -> Result<Self, Refusal> {
        Ok(Self {
            description: description::description(point, kernels)?,
            format: point.word("format").unwrap_or("f64").parse()?,
            seed: point.whole("seed").unwrap_or(0),
        })
    }
}

/// All that makes an array point, besides its scene.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ArraySpec {
    program: ProgramSpec,
    /// That of its cells, of the point's own chip.
    arithmetic: Arithmetic,
    schedule: Schedule,
    /// Whether every event is read.
    all: bool,
}

impl ArraySpec {
    pub(super) fn of(
        point: &Point,
        kernels: &[Kernel],
        (chip, effort): (&Arc<Device>, u64),
    ) -> Result<Self, Refusal> {
        let word = |key: &str| point.word(key).unwrap_or_default();
        let arithmetic: Arithmetic = word("domain").parse()?;
        Ok(Self {
            program: ProgramSpec::of(point, kernels, chip, effort)?,
            arithmetic: arithmetic.with_seed(point.whole("seed").unwrap_or(0)),
            schedule: word("schedule").parse()?,
            all: word("readout") == "all",
        })
    }
}

/// The program of an array point, and how its array is worked on.
pub(in crate::study::sweep) struct Programmed {
    pub compiled: Compiled,
    pub settings: array::Settings,
    /// That of its cells, of the point's own chip.
    pub arithmetic: Arithmetic,
    /// Whether every event is read.
    pub all: bool,
}

impl Programmed {
    /// The program on an array of this arithmetic.
    pub fn sensor(
        &self,
        arithmetic: Arithmetic,
        size: Size,
    ) -> Result<Box<dyn Sensor + Send>, Refusal> {
        let chip = self.compiled.chip(arithmetic, size, self.settings)?;
        Ok(if self.all {
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
    let device = entry
        .chip
        .as_ref()
        .ok_or_else(|| Refusal::Cannot("there is no chip".to_owned()))?;
    let scene = point.word("scene").unwrap_or_default();
    Larger::check(scene, entry.scene.size, device)?;
    let ArraySpec {
        program,
        arithmetic,
        schedule,
        all,
    } = ArraySpec::of(point, &entry.kernels, (device, settings.effort))?;
    let made = shared.program(&program);
    let LevelProgram {
        compiled,
        quantisation_error,
        erased,
    } = match made.get() {
        Some(Ok(made)) => made.clone(),
        Some(Err(refusal)) => return Err(refusal.clone()),
        None => return Err(Refusal::Cannot("the program was not made".to_owned())),
    };
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
        Arithmetic::Number(format) => format.bytes(),
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
        schedule: Some(schedule),
        threads: Some(1),
        ..compiled.settings()
    };
    Ok(Programmed {
        compiled,
        settings,
        arithmetic,
        all,
    })
}
