//! The rig: one light, several sensors, their packets.

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

/// Shows every frame of a scene to every sensor, in turn; one packet for each sensor.
///
/// `seen` is called after each frame, for whoever keeps pictures or shows progress.
///
/// # Errors
/// When the scene or a sensor cannot go on.
pub fn watch(
    scene: &mut dyn Scene,
    sensors: &mut [&mut dyn Sensor],
    mut seen: impl FnMut(&Frame),
) -> Result<Vec<Packet>, RigError> {
    let empty = |sensor: &&mut dyn Sensor| Packet::new(sensor.size(), sensor.channels());
    let mut packets: Vec<_> = sensors.iter().map(empty).collect();
    while let Some(frame) = scene.next_frame()? {
        for (sensor, packet) in sensors.iter_mut().zip(&mut packets) {
            sensor
                .watch(&frame, packet)
                .map_err(|cause| RigError::Sensor {
                    name: sensor.name().to_owned(),
                    cause,
                })?;
        }
        seen(&frame);
    }
    Ok(packets)
}
