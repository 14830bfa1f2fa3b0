//! A program on the array against a sensor of the float model.

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
    scene::Frame,
    sensor::Sensor,
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
        /// Which.
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
    let mut float =
        Reference::new(reference.clone(), size, 0).map_err(|e| broken(&reference.name, &e))?;
    let said = watch(&mut float, clip).map_err(|e| broken(&reference.name, &e))?;
    let judged = watch(&mut chip, clip).map_err(|e| broken(file, &e))?;
    let comparison = compare(&said, &judged, tolerance.within).map_err(|e| broken(file, &e))?;
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
                    Side::Reference => &reference.name,
                    Side::Judged => file,
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

fn watch(sensor: &mut dyn Sensor, clip: &Clip) -> Result<Packet, crate::sensor::SensorError> {
    let mut packet = Packet::new(sensor.size(), sensor.channels());
    for (index, light) in clip.frames.iter().enumerate() {
        let frame = Frame {
            index: index as u64,
            seconds: index as f64 / clip.fps,
            light: light.clone().into(),
        };
        sensor.watch(&frame, &mut packet)?;
    }
    Ok(packet)
}

/// Looks for a scene on which a program and a sensor do not agree.
///
/// # Panics
/// With the smallest such scene that was found, and how they part on it.
pub fn assert_agrees(program: &Program, reference: &Description, tolerance: &Tolerance) {
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
    let found =
        TestRunner::new_with_rng(config, scenes).run(&clips(tolerance.size, 2..=6), |clip| {
            agree(program, reference, &clip, tolerance)
                .map_err(|e| TestCaseError::fail(e.to_string()))
        });
    match found {
        Ok(()) => {}
        Err(TestError::Fail(why, clip)) => panic!(
            "{} does not agree with {}: {why}\non the scene {clip:?}",
            program.file, reference.name
        ),
        Err(TestError::Abort(why)) => panic!("no scene could be made: {why}"),
    }
}
