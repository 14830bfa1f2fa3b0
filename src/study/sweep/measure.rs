//! One point: its sensor is made, watches its scene, and is measured.

use std::{
    collections::VecDeque,
    sync::{Arc, Mutex, OnceLock, PoisonError},
};

use miette::Diagnostic;
use serde_json::json;

use super::{
    key::Side,
    plan::{Entry, Plan},
    sensor,
    study::Settings,
    table::{self, Row},
};
use crate::{
    array::{Arithmetic, Array, Schedule},
    compare::{Pair, counts, intervals, matching, rates, ruler::Metric, van_rossum, victor_purpura, voxel},
    compile::{Effort, Kind, Memory, Request, SensorProgram},
    event::{Packet, Polarity, address},
    kernel::{
        Kernel,
        quantise::{Quantiser, Sum},
    },
    number::{Format, Number, Visitor},
    plane::Size,
    program::{Cost, Overrides, Program},
    reference::{Description, MemoryRule, Reference},
    scene::SceneError,
    sensor::{Sensor, SensorError},
    study::design::Compiled,
};

/// Seconds since some moment.
pub type Clock<'a> = &'a (dyn Fn() -> f64 + Sync);

/// Why a point cannot be.
#[derive(Debug)]
struct Refusal(String);

impl<E: Diagnostic> From<E> for Refusal {
    fn from(error: E) -> Self {
        let help = error.help().map(|help| format!(" ({help})"));
        Self(format!("{error}{}", help.unwrap_or_default()))
    }
}

/// What several points need, made once.
#[derive(Debug, Default)]
pub(super) struct Shared {
    references: Mutex<VecDeque<(String, Arc<OnceLock<Result<Packet, String>>>)>>,
    programs: Mutex<Vec<(String, Made)>>,
}

type Made = Arc<OnceLock<Result<(Compiled, f64, f64), String>>>;

/// Reference packets that are kept: points come task by task.
const KEPT: usize = 8;

impl Shared {
    fn reference(
        &self,
        task: &str,
        make: impl FnOnce() -> Result<Packet, String>,
    ) -> Arc<OnceLock<Result<Packet, String>>> {
        let slot = {
            let mut all = self.references.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some((_, slot)) = all.iter().find(|(known, _)| known == task) {
                Arc::clone(slot)
            } else {
                let slot = Arc::new(OnceLock::new());
                all.push_back((task.to_owned(), Arc::clone(&slot)));
                if all.len() > KEPT {
                    all.pop_front();
                }
                slot
            }
        };
        slot.get_or_init(make);
        slot
    }

    fn program(
        &self,
        key: &str,
        make: impl FnOnce() -> Result<(Compiled, f64, f64), String>,
    ) -> Made {
        let slot = {
            let mut all = self.programs.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some((_, slot)) = all.iter().find(|(known, _)| known == key) {
                Arc::clone(slot)
            } else {
                let slot = Made::default();
                all.push((key.to_owned(), Arc::clone(&slot)));
                slot
            }
        };
        slot.get_or_init(make);
        slot
    }
}

/// Computes a point; what came of it, as a row.
pub(super) fn measure(plan: &Plan, entry: &Entry, shared: &Shared, clock: Clock<'_>) -> Row {
    let settings = &plan.study.settings;
    let mut row = entry.point.columns();
    row.insert("id".to_owned(), json!(entry.id));
    row.insert("task".to_owned(), json!(entry.task));
    row.insert("against".to_owned(), json!(settings.against));
    let Size { height, width } = entry.scene.size;
    row.insert("width".to_owned(), json!(width));
    row.insert("height".to_owned(), json!(height));
    row.insert("frames_seen".to_owned(), json!(entry.scene.frames));
    let outcome = match run(settings, entry, shared, clock, &mut row) {
        Ok(()) => "done",
        Err(Refusal(why)) => {
            row.insert("reason".to_owned(), json!(why));
            "refused"
        }
    };
    row.insert("outcome".to_owned(), json!(outcome));
    row
}

fn run(
    settings: &Settings,
    entry: &Entry,
    shared: &Shared,
    clock: Clock<'_>,
    row: &mut Row,
) -> Result<(), Refusal> {
    let mut sensor = match entry.point.side() {
        Side::Reference | Side::Mesh => float(entry, row)?,
        Side::Array => array(settings, entry, shared, row)?,
    };
    let (packet, seconds) = watch(entry, &mut *sensor, clock)?;
    let made = shared.reference(&entry.task, || ideal(settings, entry, clock));
    let truth = match made.get() {
        Some(Ok(packet)) => packet,
        Some(Err(why)) => return Err(Refusal(format!("the f64 sensor: {why}"))),
        None => return Err(Refusal("the f64 sensor was not made".to_owned())),
    };
    let pair = Pair::of(truth, &packet)?;
    let frames = entry.scene.frames as f64;
    let on = packet.events.iter().filter(|e| e.polarity == Polarity::On).count();
    let mut put = |name: &str, value: serde_json::Value| row.insert(name.to_owned(), value);
    put("events", json!(packet.events.len()));
    put("on", json!(on));
    put("off", json!(packet.events.len() - on));
    put("dropped", json!(packet.dropped.total()));
    put("bits", json!(address::bits(&packet)));
    put("reference_events", json!(truth.events.len()));
    let first = settings.within.first().copied().unwrap_or_default();
    put("error", json!(1.0 - matching::matches(&pair, first).f1()));
    for metric in table::metrics(settings) {
        put(&metric.key(), json!(value(metric, &pair)));
    }
    put("seconds_per_frame", json!(seconds / frames));
    put("frames_per_s", json!(frames / seconds));
    put("events_per_s", json!(packet.events.len() as f64 / seconds));
    Ok(())
}

/// Shows the scene; the packet, and the seconds that the sensor took.
fn watch(
    entry: &Entry,
    sensor: &mut (dyn Sensor + Send),
    clock: Clock<'_>,
) -> Result<(Packet, f64), Refusal> {
    let mut packet = Packet::new(sensor.size(), sensor.channels());
    let mut spent = 0.0;
    entry.scene.play(|frame| {
        let start = clock();
        sensor.watch(frame, &mut packet)?;
        spent += clock() - start;
        Ok::<(), Stop>(())
    })?;
    // A clock may be too coarse for a small scene.
    Ok((packet, f64::max(spent, 1e-9)))
}

/// A scene or a sensor stopped.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
enum Stop {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Sensor(#[from] SensorError),
}

/// The packet that points of this task are measured against.
fn ideal(settings: &Settings, entry: &Entry, clock: Clock<'_>) -> Result<Packet, String> {
    let make = || -> Result<Packet, Refusal> {
        let description = sensor::ideal(&entry.point, &entry.kernel, settings.against)?;
        let mut sensor = Reference::new(description, entry.scene.size, 0)?;
        Ok(watch(entry, &mut sensor, clock)?.0)
    };
    make().map_err(|Refusal(why)| why)
}

/// The sensor of a float point.
fn float(entry: &Entry, row: &mut Row) -> Result<Box<dyn Sensor + Send>, Refusal> {
    struct Make(Description, Size, u64);
    impl Visitor for Make {
        type Output = Result<Box<dyn Sensor + Send>, SensorError>;
        fn visit<N: Number>(self, number: N) -> Self::Output {
            let made = Reference::with_number(number, self.0, self.1, self.2)?;
            Ok(Box::new(made))
        }
    }
    let point = &entry.point;
    let format: Format = point.word("format").unwrap_or("f64").parse()?;
    let description = sensor::description(point, &entry.kernel)?;
    let size = entry.scene.size;
    let bytes = float_state(&description, format) * size.pixels() as u64;
    row.insert("state_memory_bytes".to_owned(), json!(bytes));
    let seed = point.whole("seed").unwrap_or(0);
    Ok(format.visit(Make(description, size, seed))?)
}

/// Bytes of one value.
const fn bytes(format: Format) -> u64 {
    match format {
        Format::F64 => 8,
        Format::F32 => 4,
        Format::F16 | Format::Bf16 => 2,
        Format::Fixed(fixed) => fixed.bits() as u64 / 8,
    }
}

/// Bytes of a cell that must last from one frame to the next: its memory, for a memory that
/// steps a count and the drive of the frame before, the time of its last event under a dead
/// time, its share of a low-pass and of a sheet.
fn float_state(description: &Description, format: Format) -> u64 {
    let held = bytes(format);
    let channel = description.channels.first();
    let step = description.memory == MemoryRule::FilteredStep;
    let sheets = channel.and_then(|channel| channel.surrounds.as_ref());
    let moving = sheets.map_or(0, |s| s.sheets.iter().filter(|sheet| sheet.tau > 0.0).count());
    held + if step { 4 + held } else { 0 }
        + if description.refractory.us > 0.0 { 8 } else { 0 }
        + if description.noise.cutoff_hz > 0.0 { 8 } else { 0 }
        + 8 * moving as u64
}

/// The chip of an array point.
fn array(
    settings: &Settings,
    entry: &Entry,
    shared: &Shared,
    row: &mut Row,
) -> Result<Box<dyn Array + Send>, Refusal> {
    let point = &entry.point;
    let word = |key: &str| point.word(key).unwrap_or_default().to_owned();
    let [on, off, _] = point.thresholds().unwrap_or([1.0; 3]);
    let seed = point.whole("seed").unwrap_or(0);
    let device = entry
        .chip
        .as_ref()
        .ok_or_else(|| Refusal("there is no chip".to_owned()))?;
    let weights: Vec<f64> = entry.kernel.weights().iter().copied().collect();
    let rounding = if word("quantise").ends_with(":stochastic") { seed } else { 0 };
    // A program does not depend on its thresholds, but on whether they are one or two.
    let key = format!(
        "{weights:?} {:?} {} {} {} {} {rounding} {}",
        entry.kernel.weights().dim(),
        word("chip"),
        word("quantise"),
        word("sum"),
        word("memory"),
        on == off,
    );
    let made = shared.program(&key, || {
        let made = compiled(settings, &entry.kernel, entry, rounding, on == off);
        made.map_err(|Refusal(why)| why)
    });
    let (compiled, scale, lost) = match made.get() {
        Some(Ok(made)) => made,
        Some(Err(why)) => return Err(Refusal(why.clone())),
        None => return Err(Refusal("the program was not made".to_owned())),
    };
    let unit = compiled.program.scale / scale;
    let constants: &[(&str, f64)] = if on == off {
        &[("threshold", on)]
    } else {
        &[("on_threshold", on), ("off_threshold", off)]
    };
    let overrides: Overrides = constants
        .iter()
        .map(|(name, light)| ((*name).to_owned(), light * unit))
        .collect();
    let text = Program::parse(&compiled.title, &compiled.program.text)?;
    let code = text.expand(device, &overrides)?.code;
    let slots = point.whole("slots").unwrap_or(4000).min(u32::MAX.into()) as u32;
    let compiled = Compiled {
        code,
        ..compiled.clone()
    }
    .with_slots(slots);
    let cost = Cost::of(&compiled.code.frame, device);
    let arithmetic: Arithmetic = word("domain").parse()?;
    let size = entry.scene.size;
    let mut put = |name: &str, value: serde_json::Value| row.insert(name.to_owned(), value);
    put("words", json!(cost.words.0));
    put("array_us", json!(cost.array_us));
    put("registers", json!(compiled.registers()));
    put("prescale_bits", json!(compiled.program.filter.prescale));
    put("quantisation_error", json!(lost));
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
    let mut chip = compiled.chip(arithmetic.with_seed(seed), size, compiled.settings())?;
    let schedule: Schedule = word("schedule").parse()?;
    chip.set_schedule(schedule, 1);
    Ok(chip)
}

/// The program of a kernel with thresholds of 1; the scale of its levels, and what they lose.
fn compiled(
    settings: &Settings,
    kernel: &Kernel,
    entry: &Entry,
    seed: u64,
    one_threshold: bool,
) -> Result<(Compiled, f64, f64), Refusal> {
    let point = &entry.point;
    let device = entry
        .chip
        .as_ref()
        .ok_or_else(|| Refusal("there is no chip".to_owned()))?;
    let name = point.word("quantise").unwrap_or("none");
    let (levels, scale, lost) = if name == "none" {
        (kernel.clone(), 1.0, 0.0)
    } else {
        let to: Quantiser = name.parse()?;
        let sum = match point.word("sum") {
            Some("zero") => Sum::Zero,
            Some("kept") => Sum::Kept,
            _ => Sum::Free,
        };
        let quantised = to.quantise(kernel, sum, seed)?.within_one();
        let lost = quantised.relative_error(kernel);
        (quantised.levels, quantised.scale, lost)
    };
    let kernels = [levels.clone()];
    let mut request = Request::new(&kernels, device)?;
    request.effort = Effort {
        states: settings.effort,
    };
    let kind = Kind {
        kernel: levels,
        on: 1.0,
        off: if one_threshold { 1.0 } else { 0.5 },
    };
    let memory = point.word("memory").and_then(|word| word.strip_prefix("bits:"));
    let memory = memory.and_then(|bits| bits.parse().ok());
    let memory = memory.map_or(Memory::Analogue, Memory::Bits);
    let title = format!("{} as {name}", point.word("kernel").unwrap_or_default());
    let program = SensorProgram::new(&[kind], memory, &title, &request)?;
    let compiled = Compiled {
        cost: Cost::default(),
        code: crate::program::Code::default(),
        device: device.as_ref().clone(),
        title,
        program,
    };
    Ok((compiled, scale, lost))
}

/// One metric; none where it has no value.
fn value(metric: Metric, pair: &Pair) -> Option<f64> {
    let bins = || voxel::voxels(pair, voxel::Bins::over(pair, 8));
    match metric {
        Metric::F1(within) => Some(matching::matches(pair, within).f1()),
        Metric::Precision(within) => Some(matching::matches(pair, within).precision()),
        Metric::Recall(within) => Some(matching::matches(pair, within).recall()),
        Metric::VanRossum(tau) => Some(van_rossum::distance(pair, tau)),
        Metric::VictorPurpura(shift) => Some(victor_purpura::distance(pair, shift)),
        Metric::VoxelL1 => Some(bins().l1),
        Metric::VoxelL1SignsApart => Some(bins().l1_signs_apart),
        Metric::VoxelRmse => Some(bins().rmse),
        Metric::CountPearson => counts::cells(pair).pearson,
        Metric::CountL1 => Some(pair.per_event(counts::cells(pair).l1 as f64 / 2.0)),
        Metric::RatePearson => rates::rates(pair).unsigned.pearson,
        Metric::RateL1 => Some(rates::rates(pair).unsigned.l1),
        Metric::SignedRatePearson => rates::rates(pair).signed.pearson,
        Metric::SignedRateL1 => Some(rates::rates(pair).signed.l1),
        Metric::Intervals => intervals::divergence(pair).map(|d| d.forward),
        Metric::IntervalsBack => intervals::divergence(pair).map(|d| d.back),
        Metric::Events | Metric::Bits => None,
    }
}
