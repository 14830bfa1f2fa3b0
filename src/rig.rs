//! The rig: one light, several sensors, their packets.

use rayon::prelude::*;

use crate::{
    event::Packet,
    scene::{Frame, Scene, SceneError},
    sensor::{Sensor, SensorError},
};

/// Why a rig stopped.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum RigError {
    /// The scene could not go on.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// A sensor could not go on.
    #[error("sensor {name}: {cause}")]
    Sensor {
        /// Which.
        name: String,
        /// Why.
        #[source]
        #[diagnostic_source]
        cause: SensorError,
    },
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
    let mut packets: Vec<_> = sensors
        .iter()
        .map(|s| Packet::new(s.size(), s.channels()))
        .collect();
    while let Some(frame) = scene.next_frame()? {
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
    }
    Ok(packets)
}
