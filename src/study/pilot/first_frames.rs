//! The first frames of a scene on the whole sensor, by the clock.

use crate::{
    event::Packet,
    scene::{Scene as _, kept::Kept},
    sensor::{Sensor, SensorError},
};

/// Seconds of each of so many frames behind the first, which is another body; none where the scene
/// has fewer. `clock`: seconds since any moment.
///
/// # Errors
/// When the sensor cannot go on.
pub(super) fn clocked(
    mut sensor: Box<dyn Sensor + Send>,
    kept: &Kept,
    frames: usize,
    clock: &(dyn Fn() -> f64 + Sync),
) -> Result<Option<Vec<f64>>, SensorError> {
    let mut packet = Packet::new(sensor.size(), sensor.channels());
    let mut scene = kept.scene();
    let mut seconds = Vec::with_capacity(frames);
    for n in 0..=frames {
        // What is kept can be read.
        let Ok(Some(frame)) = scene.next_frame() else {
            return Ok(None);
        };
        let start = clock();
        sensor.watch(&frame, &mut packet)?;
        if n > 0 {
            seconds.push(clock() - start);
        }
    }
    Ok(Some(seconds))
}
