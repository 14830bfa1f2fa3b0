//! A sensor of a point, and what it is shown.

use std::sync::Arc;

use super::{
    limits::{Limits, Stop},
    memo::Shared,
    refusal::Refusal,
};
use crate::{
    array::{Arithmetic, Unheld},
    event::Packet,
    number::Format,
    photoreceptor::Response,
    reference::Description,
    rig::{
        Overflow,
        guard::{Guard, Warning},
    },
    sensor::Sensor,
    study::{
        design, saturation,
        sweep::{
            points::plan::Entry,
            scene::{cached_scene::CachedScene, drive::driven},
            sensor::build::Programmed,
        },
    },
};

/// A sensor, and what it is shown.
pub(super) struct Seen {
    pub sensor: Box<dyn Sensor + Send>,
    /// The scene, or the drive of resistor sheets.
    pub scene: Arc<CachedScene>,
    /// Seconds that the drive took.
    pub seconds: f64,
    /// Signals that its numbers cannot hold.
    pub overflow: Overflow,
    /// Numbers of its program that its cells do not hold.
    pub unheld: Option<Unheld>,
}

impl Seen {
    /// A sensor whose numbers hold all signals.
    pub fn plain(sensor: Box<dyn Sensor + Send>, scene: Arc<CachedScene>, seconds: f64) -> Self {
        Self {
            sensor,
            scene,
            seconds,
            overflow: Overflow::new(Format::F64, Response::IDENTITY),
            unheld: None,
        }
    }

    /// A float sensor; behind resistor sheets its cells, which are shown their drive.
    pub fn float(
        entry: &Entry,
        (description, seed, format): (&Description, u64, Format),
        shared: &Shared,
        limits: Limits<'_>,
    ) -> Result<Self, Refusal> {
        let size = entry.scene.size;
        let driven = driven(&entry.scene, (description, seed, format), shared, limits);
        let (description, scene, seconds) = match driven {
            Some(driven) => (driven.description, driven.scene, driven.seconds),
            None => (description.clone(), Arc::clone(&entry.scene), 0.0),
        };
        Ok(Self {
            overflow: Overflow::new(format, description.response),
            sensor: design::float(description, size, seed, format)?,
            scene,
            seconds,
            unheld: None,
        })
    }

    /// A chip with its program.
    pub fn chip(
        made: &Programmed,
        arithmetic: Arithmetic,
        scene: Arc<CachedScene>,
    ) -> Result<Self, Refusal> {
        Ok(Self {
            overflow: saturation::of_light(arithmetic, &made.settings),
            unheld: made.unheld(arithmetic),
            ..Self::plain(made.sensor(arithmetic, scene.size)?, scene, 0.0)
        })
    }
}

/// Shows a sensor what it sees; the packet, the seconds that the sensor took, and what there is to warn of.
pub(super) fn watch(
    Seen {
        sensor,
        scene,
        seconds,
        overflow,
        unheld,
    }: &mut Seen,
    limits: Limits<'_>,
) -> Result<(Packet, f64, Vec<Warning>), Refusal> {
    let begin = (limits.clock)();
    let mut packet = Packet::new(sensor.size(), sensor.channels());
    let (mut spent, mut guard) = (*seconds, Guard::new());
    let played = scene.play(|frame| {
        let start = (limits.clock)();
        sensor.watch(frame, &mut packet)?;
        guard.frame(frame);
        let now = (limits.clock)();
        spent += now - start;
        overflow.see(frame);
        let held = (scene.size, usize::from(sensor.channels()));
        limits.hold(now - begin, held, packet.events.len())?;
        Ok::<(), Stop>(())
    });
    match played {
        Err(Stop::Exhausted(exhausted)) => return Err(exhausted.given_up()),
        // It was seen to its end before: with the files that it was made of it is again.
        Err(Stop::Scene(error)) => return Err(Refusal::given_up(&error)),
        played => played?,
    }
    guard.packet_of(sensor.name(), &packet, &sensor.silence());
    if let Some(unheld) = unheld {
        saturation::warn_unheld(&mut guard, sensor.name(), unheld);
    } else {
        guard.extend(overflow.warning(sensor.name(), sensor.overflowed()));
    }
    // A clock may be too coarse for a small scene.
    Ok((packet, f64::max(spent, 1e-9), guard.warnings()))
}
