//! Two sensors on random scenes: a program on the array against a sensor of the float model, or any
//! other two.

use std::cell::RefCell;

use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestError, TestRng, TestRunner};

use super::{Clip, clips};
use crate::{
    array::{Arithmetic, Settings},
    compare::{compare, equality::Side},
    event::Packet,
    isa::Device,
    number::Format,
    plane::Size,
    program::{Overrides, Program},
    reference::{Description, Reference},
    sensor::{Sensor, SensorError},
    unit::Micros,
};

/// What counts as agreement, and how it is looked for.
#[derive(Clone, Debug)]
pub struct Tolerance {
    /// Matched events, as F1, on every scene; 1 for the same events.
    pub least_f1: f64,
    /// Events of one pixel and sign that are closer than this match.
    pub within: Micros,
    /// Fewer events than this on both sides together are not judged.
    pub least_events: usize,
    /// What the array computes in.
    pub arithmetic: Arithmetic,
    /// The chip.
    pub device: Device,
    /// Constants of the program.
    pub constants: Overrides,
    /// Size of the scenes.
    pub size: Size,
    /// Random scenes.
    pub cases: u32,
    /// Chooses the scenes: the same seed shows the same ones.
    pub seed: u64,
}

impl Default for Tolerance {
    /// The same events, in exact arithmetic, on 64 scenes of 12 x 9 pixels.
    fn default() -> Self {
        Self {
            least_f1: 1.0,
            within: Micros(0),
            least_events: 0,
            arithmetic: Arithmetic::Number(Format::F64),
            device: Device::scamp5(),
            constants: Overrides::default(),
            size: Size::new(9, 12),
            cases: 64,
            seed: 0,
        }
    }
}

/// Why a program and a sensor do not agree.
#[derive(Clone, Debug, PartialEq, thiserror::Error, miette::Diagnostic)]
pub enum Disagreement {
    /// The one or the other does not run.
    #[error("{what}: {why}")]
    #[diagnostic(help("mend the program or the sensor first; both must run on the scenes' size"))]
    Broken {
        /// Name of the program or the sensor.
        what: String,
        /// What it says.
        why: String,
    },
    /// They say different things.
    #[error(
        "F1 is {f1:.4}, not {least} or more: {reference} events of the float model, {judged} of the program; {first}"
    )]
    #[diagnostic(help("look at the first event that only one of them has"))]
    Events {
        /// Matched events.
        f1: f64,
        /// What was asked.
        least: f64,
        /// Events of the float model.
        reference: u64,
        /// Events of the program.
        judged: u64,
        /// Where they part.
        first: String,
    },
}

/// Shows one clip to both.
///
/// # Errors
/// When one of them cannot be made or cannot go on, or they do not agree.
pub fn agree(
    program: &Program,
    reference: &Description,
    clip: &Clip,
    tolerance: &Tolerance,
) -> Result<(), Disagreement> {
    let broken = |what: &str, why: &dyn std::fmt::Display| Disagreement::Broken {
        what: what.to_owned(),
        why: why.to_string(),
    };
    let Some(first) = clip.frames.first() else {
        return Ok(());
    };
    let (device, size) = (&tolerance.device, Size::of(first));
    let file = &program.file;
    let expansion = program.expand(device, &tolerance.constants);
    let code = expansion.map_err(|e| broken(file, &e))?.code;
    let settings = Settings {
        clip: true,
        ..Settings::from_device(device)
    };
    let chip = (tolerance.arithmetic).chip(file, &code, device, size, settings);
    let mut chip = chip.map_err(|e| broken(file, &e))?;
    let float = Reference::new(reference.clone(), size, 0);
    let mut float = float.map_err(|e| broken(&reference.name, &e))?;
    agree_sensors(&mut float, &mut *chip, clip, tolerance)
}

/// Shows one clip to two sensors of any make, as they are: the first is the reference.
///
/// # Errors
/// When one of them cannot go on, or they do not agree. Of the tolerance what is said of events
/// counts.
pub fn agree_sensors(
    reference: &mut dyn Sensor,
    judged: &mut dyn Sensor,
    clip: &Clip,
    tolerance: &Tolerance,
) -> Result<(), Disagreement> {
    let names = [reference.name().to_owned(), judged.name().to_owned()];
    let broken = |what: &str, why: &dyn std::fmt::Display| Disagreement::Broken {
        what: what.to_owned(),
        why: why.to_string(),
    };
    let said = watch(reference, clip).map_err(|e| broken(&names[0], &e))?;
    let judged = watch(judged, clip).map_err(|e| broken(&names[1], &e))?;
    let comparison =
        compare(&said, &judged, tolerance.within).map_err(|e| broken(&names[1], &e))?;
    let events = comparison.events;
    let few = events.iter().sum::<u64>() < tolerance.least_events as u64;
    if few || comparison.f1 >= tolerance.least_f1 {
        return Ok(());
    }
    Err(Disagreement::Events {
        f1: comparison.f1,
        least: tolerance.least_f1,
        reference: events[0],
        judged: events[1],
        first: comparison.first_divergence.map_or_else(
            || "the events are the same but for their times".to_owned(),
            |divergence| {
                let who = match divergence.only_in {
                    Side::Reference => &names[0],
                    Side::Judged => &names[1],
                };
                let sign = if divergence.p == 1 { "ON" } else { "OFF" };
                format!(
                    "the first that only one has: {who}, {sign} at {} us, x {}, y {}",
                    divergence.t.0, divergence.x, divergence.y
                )
            },
        ),
    })
}

fn watch(sensor: &mut dyn Sensor, clip: &Clip) -> Result<Packet, SensorError> {
    let mut packet = Packet::new(sensor.size(), sensor.channels());
    for frame in clip.scene().all() {
        sensor.watch(frame, &mut packet)?;
    }
    Ok(packet)
}

/// Looks for a scene on which a program and a sensor do not agree.
///
/// # Panics
/// With the smallest such scene that was found, and how they part on it.
pub fn assert_agrees(program: &Program, reference: &Description, tolerance: &Tolerance) {
    let names = [&reference.name, &program.file].map(String::as_str);
    assert_on_scenes(names, tolerance, |clip| {
        agree(program, reference, clip, tolerance)
    });
}

/// Looks for a scene on which two sensors do not agree. Both are made anew for each scene, of the
/// tolerance's size: the first is the reference.
///
/// # Panics
/// With the smallest such scene that was found, and how they part on it; when a sensor cannot be
/// made.
pub fn assert_sensors_agree<R: Sensor, J: Sensor>(
    mut reference: impl FnMut(Size) -> Result<R, SensorError>,
    mut judged: impl FnMut(Size) -> Result<J, SensorError>,
    tolerance: &Tolerance,
) {
    let mut make = || Ok::<_, SensorError>((reference(tolerance.size)?, judged(tolerance.size)?));
    let names = match make() {
        Ok((reference, judged)) => [reference.name().to_owned(), judged.name().to_owned()],
        Err(error) => panic!("{error}"),
    };
    let make = RefCell::new(make);
    assert_on_scenes(names.each_ref().map(String::as_str), tolerance, |clip| {
        let made = (make.borrow_mut())();
        let (mut reference, mut judged) = made.map_err(|error| Disagreement::Broken {
            what: names.join(" and "),
            why: error.to_string(),
        })?;
        agree_sensors(&mut reference, &mut judged, clip, tolerance)
    });
}

/// Looks for a scene on which something does not hold.
fn assert_on_scenes(
    [reference, judged]: [&str; 2],
    tolerance: &Tolerance,
    holds: impl Fn(&Clip) -> Result<(), Disagreement>,
) {
    let config = Config {
        cases: tolerance.cases,
        failure_persistence: None,
        // The smallest scene, however long that takes: it is what people look at.
        max_shrink_iters: 100_000,
        ..Config::default()
    };
    let mut seed = [0; 32];
    seed[..8].copy_from_slice(&tolerance.seed.to_le_bytes());
    let scenes = TestRng::from_seed(RngAlgorithm::ChaCha, &seed);
    let found = TestRunner::new_with_rng(config, scenes)
        .run(&clips(tolerance.size, 2..=6), |clip| {
            holds(&clip).map_err(|e| TestCaseError::fail(e.to_string()))
        });
    match found {
        Ok(()) => {}
        Err(TestError::Fail(why, clip)) => {
            panic!("{judged} does not agree with {reference}: {why}\non the scene {clip:?}")
        }
        Err(TestError::Abort(why)) => panic!("no scene could be made: {why}"),
    }
}
