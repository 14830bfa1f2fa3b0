//! What the points of a task are measured against: the f64 sensor, and the same at higher thresholds.
//!
//! A point is compared with as many rungs of the ladder as it needs: one that is hardly off with the
//! first. So a rung watches the scene when a point first asks for it.

use std::sync::OnceLock;

use super::refusal::Refusal;
use crate::{
    compare::CompareError,
    event::Packet,
    reference::Description,
    study::{
        equivalent::{self, Ladder},
        sweep::{points::plan::Entry, sensor::description, study_file::study::Settings},
        together::own,
    },
};

/// Seed of the redraws: a floor is that of the task, whatever the point.
const REDRAWS: u64 = 0;

/// Shows the scene of the task to a float sensor in f64.
pub(super) type Watched<'a> = &'a dyn Fn(&Description) -> Result<Packet, Refusal>;

/// What points of one task are measured against.
#[derive(Debug)]
pub(in crate::study::sweep) struct Truth {
    ideal: Description,
    /// Without rungs.
    ladder: Ladder,
    /// Those of each kind of cells alone, where there are several.
    kinds: Vec<Ladder>,
    /// Parts of the threshold, and F1 there, in the order of the ladder.
    rungs: Vec<(f64, OnceLock<Result<f64, Refusal>>)>,
}

impl Truth {
    /// The f64 sensor of a task on its scene.
    ///
    /// # Errors
    /// Why there is none.
    pub fn new(settings: &Settings, entry: &Entry, watched: Watched<'_>) -> Result<Self, Refusal> {
        let make = || -> Result<Self, Refusal> {
            let ideal = description::ideal(&entry.point, &entry.kernels, settings.against)?;
            let fps = entry.scene.fps;
            let packet = watched(&ideal)?;
            let ladder = |packet| Ladder::bare(packet, settings.headline(fps), fps, REDRAWS);
            let kinds = 0..ideal.channels.len();
            let several = kinds.filter(|_| ideal.channels.len() > 1);
            Ok(Self {
                kinds: several
                    .map(|kind| ladder(own(&packet, kind)))
                    .collect::<Result<_, _>>()?,
                ladder: ladder(packet)?,
                rungs: { equivalent::higher() }
                    .map(|part| (part, OnceLock::new()))
                    .collect(),
                ideal,
            })
        };
        make().map_err(of_the_f64_sensor)
    }

    /// Its packet, and what is made of it.
    pub const fn ladder(&self) -> &Ladder {
        &self.ladder
    }

    /// What each kind of several keeps, none where it cannot be told; each is judged by its own
    /// events, as `study::together` does.
    ///
    /// # Errors
    /// When the packet is of another sensor.
    pub fn kept_of_kinds(&self, packet: &Packet) -> Result<Vec<Option<f64>>, CompareError> {
        let kinds = self.kinds.iter().enumerate();
        kinds
            .map(|(kind, ladder)| Ok(ladder.judge(&own(packet, kind))?.kept))
            .collect()
    }

    /// The change of its threshold, in per cent, that costs as much as this F1, and whether it is
    /// at least that.
    ///
    /// # Errors
    /// Why a rung cannot watch the scene.
    pub fn equivalent(&self, f1: f64, watched: Watched<'_>) -> Result<(f64, bool), Refusal> {
        // What is not off at all needs no rung.
        if f1 >= 1.0 {
            return Ok((0.0, false));
        }
        let rungs = self.rungs.iter().map(|(part, known)| {
            let f1 = known.get_or_init(|| {
                let other = equivalent::at_part(&self.ideal, *part);
                let packet = watched(&other).map_err(of_the_f64_sensor)?;
                Ok(self.ladder.f1(&packet)?)
            });
            f1.clone().map(|f1| (*part, f1))
        });
        equivalent::equivalent(f1, rungs)
    }
}

fn of_the_f64_sensor(refusal: Refusal) -> Refusal {
    match refusal {
        Refusal::Cannot(why) => Refusal::Cannot(format!("the f64 sensor: {why}")),
        Refusal::GivenUp(why) => Refusal::GivenUp(format!("the f64 sensor: {why}")),
    }
}
