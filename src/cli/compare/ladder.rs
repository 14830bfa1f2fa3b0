//! The threshold equivalent of a comparison: the reference's sensor, run again at higher
//! thresholds.

use miette::{WrapErr, miette};

use super::{
    super::{budget, files::Input, light, progress::Progress, run::read_sensor},
    Arguments,
    headline::Equivalent,
};
use crate::{
    compare::{Pair, equality},
    event::Packet,
    reference::Reference,
    rig::{self, guard::Warning},
    scene::{Observation, Scene, upsample},
    sensor::Sensor,
    study::equivalent::{self, Ladder},
    unit::Micros,
};

impl Arguments {
    /// The scene that the reference's sensor watches.
    ///
    /// # Errors
    /// When it cannot be opened.
    pub(super) fn shown(&self, observation: &Observation) -> miette::Result<Box<dyn Scene>> {
        let scene = self.clip.open(observation)?;
        Ok(upsample::by_contrast(scene, self.upsample)?)
    }

    /// The change of the sensor's threshold that costs as much as this F1 within a window.
    ///
    /// # Errors
    /// When the reference is not what this sensor says of the scene, or sensor or scene cannot go
    /// on.
    pub(super) fn equivalent(
        &self,
        sensor: &Input,
        reference: &Packet,
        (f1, window): (f64, Micros),
    ) -> miette::Result<Equivalent> {
        let description = read_sensor(sensor)?;
        let observation = Observation::new();
        let mut scene = self.shown(&observation)?;
        let (size, fps) = (scene.size(), scene.fps());
        let parts: Vec<f64> = equivalent::higher().collect();
        let mut sensors = Vec::new();
        for part in [1.0].iter().chain(&parts) {
            let description = equivalent::at_part(&description, *part);
            sensors.push(Reference::new(description, size, self.seed)?);
        }
        budget::check_study(&*scene, sensors.len())?;
        let mut watching: Vec<&mut (dyn Sensor + Send)> = Vec::new();
        for sensor in &mut sensors {
            watching.push(sensor);
        }
        let progress = Progress::new("watching", scene.frames());
        let packets = rig::watch(&mut *scene, &mut watching, |_| progress.tick());
        progress.finish();
        light::warn(&Warning::of_scene(&observation, 255.0));
        let mut packets = packets?.into_iter();
        let own = packets.next().unwrap_or_else(|| Packet::new(size, 1));
        let seen = || format!("{} seen by {}", self.clip.name(), sensor.display());
        let pair = Pair::new(reference, &own).wrap_err_with(seen)?;
        if let Some(first) = equality::first_divergence(&pair) {
            return Err(miette!(
                help = "give the scene, --fps, --upsample and --seed with which the reference was made, or leave --sensor out",
                "{} is not what {} says of {}: they part at {}, x {} y {} channel {}",
                self.a.display(),
                sensor.display(),
                self.clip.name(),
                first.t,
                first.x,
                first.y,
                first.channel
            ));
        }
        let mut ladder = Ladder::bare(own, window, fps, self.seed)?;
        for (part, packet) in parts.into_iter().zip(packets) {
            ladder.add(part, &packet)?;
        }
        let (percent, is_least) = ladder.equivalent(f1);
        Ok(Equivalent { percent, is_least })
    }
}
