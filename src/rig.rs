//! The rig: one light, several sensors, their packets.
//!
//! [`play`] is the one loop over the frames of a scene; whoever shows light to anything goes
//! through it, but for a host that runs beside an array and takes its frames itself
//! ([`Beside`](crate::program::Beside)). What is inserted between frames or left out is a
//! scene of its own (`scene::upsample`, `scene::part`), so that the loop need not know.

mod few;
pub mod guard;
mod larger;
mod overflow;
mod rounded;
mod saturation;
mod silent;

use std::ops::ControlFlow;

use rayon::prelude::*;

use crate::{
    event::Packet,
    scene::{Frame, Scene, SceneError},
    sensor::{Sensor, SensorError},
    unit::Micros,
};

pub use larger::Larger;
pub use overflow::Overflow;

/// Why a rig stopped.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum RigError {
    /// The scene could not go on.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// A sensor could not go on.
    #[error("sensor {name}: {cause}")]
    #[diagnostic(help("{}", cause.help().map_or_else(String::new, |help| help.to_string())))]
    Sensor {
        /// Name of the sensor.
        name: String,
        /// Why.
        #[source]
        cause: SensorError,
    },
}

/// Gives every frame of a scene to `see`, one at a time and in order, until it breaks off or the
/// scene ends; how many it was given.
///
/// # Errors
/// When the scene cannot go on, and what `see` says.
pub fn play<E: From<SceneError>>(
    scene: &mut dyn Scene,
    mut see: impl FnMut(Frame) -> Result<ControlFlow<()>, E>,
) -> Result<u64, E> {
    let mut frames = 0;
    while let Some(frame) = scene.next_frame()? {
        frames += 1;
        if see(frame)?.is_break() {
            break;
        }
    }
    Ok(frames)
}

/// Several sensors of one type as [`watch`] takes them.
pub fn each<S: Sensor + Send>(sensors: &mut [S]) -> Vec<&mut (dyn Sensor + Send)> {
    let mut all: Vec<&mut (dyn Sensor + Send)> = Vec::with_capacity(sensors.len());
    for sensor in sensors {
        all.push(sensor);
    }
    all
}

/// Shows every frame of a scene to every sensor, all sensors at the same time; one packet for
/// each sensor.
///
/// `seen` is called after each frame, for whoever keeps pictures or shows progress.
///
/// # Errors
/// When the scene or a sensor cannot go on.
pub fn watch(
    scene: &mut dyn Scene,
    sensors: &mut [&mut (dyn Sensor + Send)],
    mut seen: impl FnMut(&Frame),
) -> Result<Vec<Packet>, RigError> {
    watch_all(scene, sensors, &mut seen)
}

/// The same, compiled once.
fn watch_all(
    scene: &mut dyn Scene,
    sensors: &mut [&mut (dyn Sensor + Send)],
    seen: &mut dyn FnMut(&Frame),
) -> Result<Vec<Packet>, RigError> {
    let mut packets: Vec<_> = sensors
        .iter()
        .map(|s| Packet {
            names: s.names(),
            ..Packet::new(s.size(), s.channels())
        })
        .collect();
    let mut watched: Option<(f64, f64)> = None;
    play(scene, |frame| {
        let (first, _) = *watched.get_or_insert((frame.seconds, 0.0));
        watched = Some((first, frame.seconds));
        sensors
            .par_iter_mut()
            .zip(&mut packets)
            .try_for_each(|(sensor, packet)| {
                sensor
                    .watch(&frame, packet)
                    .map_err(|cause| RigError::Sensor {
                        name: sensor.name().to_owned(),
                        cause,
                    })
            })?;
        seen(&frame);
        Ok::<_, RigError>(ControlFlow::Continue(()))
    })?;
    let span = watched.map(|(from, to)| [from, to].map(Micros::from_seconds));
    for packet in &mut packets {
        if let (Some([from, to]), (Micros(0), Micros(0))) = (span, packet.span) {
            packet.span = (from, to);
        }
    }
    Ok(packets)
}
