//! The threshold equivalent of a comparison: the reference's sensor, run again at other
//! thresholds.

use super::Arguments;
use crate::{
    cli::{
        arguments::{budget, light},
        output::{files::Input, progress::Progress},
        run::read_sensor,
    },
    event::Packet,
    number::Format,
    photoreceptor::Response,
    rig::guard::Warning,
    scene::{Observation, Scene, upsample},
    study::remade::{Equivalent, Remade},
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

    /// The change of the sensor's threshold that costs as much as what the judged packet lacks
    /// within a window; beside it the same against the sensor of as many events.
    ///
    /// # Errors
    /// When the reference is not what this sensor says of the scene, or sensor or scene cannot go
    /// on.
    pub(super) fn equivalent(
        &self,
        sensor: &Input,
        packets: [&Packet; 2],
        window: Micros,
    ) -> miette::Result<Equivalent> {
        let remade = Remade {
            description: &read_sensor(sensor)?,
            format: Format::F64,
            seed: self.seed,
            reference: &self.a.display().to_string(),
            sensor: &sensor.display().to_string(),
            scene: self.clip.name(),
        };
        remade.equivalent(packets, (window, self.seed), |parts| {
            self.at_parts(&remade, parts)
        })
    }

    /// What the sensor says of the scene at these parts of its thresholds.
    fn at_parts(&self, remade: &Remade<'_>, parts: &[f64]) -> miette::Result<Vec<Packet>> {
        let observation = Observation::new();
        let mut scene = self.shown(&observation)?;
        budget::check_study(&*scene, parts.len())?;
        let progress = Progress::new("watching", scene.frames());
        let packets = remade.at(parts, &mut *scene, || progress.tick());
        progress.finish();
        if parts.len() > 1 {
            light::warn(&Warning::of_scene(&observation, Response::IDENTITY));
            light::warn(Warning::assumed_rate(&observation, "--fps").as_slice());
        }
        Ok(packets?)
    }
}
