//! Follow: every cell of the full model, and beside it what may become of the plainer ones.
//!
//! The drives are those of the reference itself: a sensor of the same kernels, photoreceptors
//! and sheets whose memory snaps at every change holds nothing but its drive. What is done with
//! them is written down here a second time, event by event, and `tests/fidelity.rs` holds it to
//! the reference's own events.

use std::ops::ControlFlow;

use rayon::prelude::*;

use crate::{
    plane::Plane,
    reference::{Description, MemoryRule, Noise, PolarityRule, Reference, Refractory, Tally},
    rig,
    scene::Scene,
};

use super::{
    PlanError,
    cell::Pair,
    perturbation::Perturbation,
    row::{Row, Rules},
    survey::Light,
};

/// What all cells together did, and may have done.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Followed {
    /// Crossings of thresholds.
    pub crossings: u64,
    /// Those that no dead time took: the events of the scene.
    pub events: u64,
    /// Squares of the events of a cell in a pair of frames, added up.
    pub squares: f64,
    /// The most of them.
    pub longest: u64,
    /// For each crossing the seconds in which a stray event of an earlier pair of frames could
    /// have changed whether it is an event, added up; and the most crossings that one stray
    /// event can do that to.
    pub chains: (f64, u64),
    /// Squares of the crossings of a cell, added up, and the most.
    pub cells: (f64, u64),
    /// Seconds between two events of one cell, at least.
    pub closest: f64,
    /// For each plainer model what it may change, with the dead time and without.
    pub changes: Vec<Change>,
    /// Most events of the full model in each pair of frames, with its time in seconds.
    pub pairs: Vec<(f64, u64)>,
}

/// What a plainer model may change.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Change {
    /// Events without a partner, if there is no dead time in either model.
    pub free: f64,
    /// Events without a partner, if both have their dead time.
    pub dead: f64,
}

impl Followed {
    /// Nothing yet.
    pub(super) fn new() -> Self {
        Self {
            closest: f64::INFINITY,
            ..Self::default()
        }
    }
}

/// Follows a scene through the full model.
///
/// # Errors
/// When the scene or the sensor cannot go on.
pub fn follow(
    scene: &mut dyn Scene,
    description: &Description,
    seed: u64,
    light: &Light,
    models: &[Perturbation],
    within: f64,
    mut seen: impl FnMut(),
) -> Result<Followed, PlanError> {
    let mut probe = Reference::new(probe(description), light.size, seed)?;
    let mut own = Reference::new(description.clone(), light.size, seed)?;
    let channels = description.channels.len();
    let mut nothing = Tally::new(channels);
    let mut rows: Vec<Row> = Vec::new();
    let mut followed = Followed::new();
    let (mut start, mut last) = (0.0, 0.0);
    rig::play(scene, |frame| {
        probe.watch_into(&frame, &mut nothing)?;
        let drives: Vec<Plane<f64>> = (0..channels).filter_map(|c| probe.memory(c)).collect();
        if rows.is_empty() {
            own.watch_into(&frame, &mut nothing)?;
            rows = begin(&own, &drives, description, models, within);
            (start, last) = (frame.seconds, frame.seconds);
        } else {
            let pair = Pair {
                from: last,
                to: frame.seconds,
                elapsed: (last - start, frame.seconds - start),
            };
            let advance = |(n, row): (usize, &mut Row)| {
                let (channel, y) = (n / light.size.height, n % light.size.height);
                let drive = drives[channel].row(y);
                row.advance(pair, drive.as_slice().unwrap_or_default(), channel)
            };
            let events: u64 = rows.par_iter_mut().enumerate().map(advance).sum();
            followed.pairs.push((pair.to - pair.from, events));
            last = frame.seconds;
        }
        seen();
        Ok::<_, PlanError>(ControlFlow::Continue(()))
    })?;
    followed.changes = vec![Change::default(); models.len()];
    for row in &rows {
        row.add_to(&mut followed);
    }
    Ok(followed)
}

/// A sensor whose memory is its drive.
fn probe(description: &Description) -> Description {
    let mut probe = description.clone();
    probe.memory = MemoryRule::FilteredSnap;
    probe.polarity = PolarityRule::Filtered;
    probe.refractory = Refractory {
        us: 0.0,
        ..probe.refractory
    };
    probe.refractory.rule = crate::reference::RefractoryRule::DeadTime;
    probe.noise = Noise {
        cutoff_hz: description.noise.cutoff_hz,
        ..Noise::NONE
    };
    for channel in &mut probe.channels {
        for threshold in &mut channel.thresholds {
            threshold.on = f64::MIN_POSITIVE;
            threshold.off = f64::MIN_POSITIVE;
            threshold.sigma = 0.0;
        }
    }
    probe
}

/// The cells at the first frame, channel by channel, row by row.
fn begin(
    own: &Reference,
    drives: &[Plane<f64>],
    description: &Description,
    models: &[Perturbation],
    within: f64,
) -> Vec<Row> {
    let rules = Rules::of(description, models, within);
    let mut rows = Vec::new();
    for (channel, drive) in drives.iter().enumerate() {
        let (Some(base), Some([on, off]), Some(leak)) = (
            own.memory(channel),
            own.thresholds(channel),
            own.leak(channel),
        ) else {
            continue;
        };
        let equal = on == off;
        for y in 0..base.nrows() {
            let row = |plane: &Plane<f64>| plane.row(y).to_vec();
            rows.push(Row::new(
                &rules,
                [row(&base), row(drive), row(&on), row(&off), row(&leak)],
                equal,
            ));
        }
    }
    rows
}
