//! The threshold equivalent of a comparison: the reference's sensor, run again at other
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
    number::Format,
    photoreceptor::Response,
    reference::{Description, Reference},
    rig::{self, guard::Warning},
    scene::{Observation, Scene, upsample},
    sensor::Sensor,
    study::equivalent::{self, Ladder, RUNGS},
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
        [reference, judged]: [&Packet; 2],
        window: Micros,
    ) -> miette::Result<Equivalent> {
        let description = read_sensor(sensor)?;
        let mut parts = vec![1.0];
        parts.extend(RUNGS);
        let (own, rungs) = self.at_parts(&description, &parts)?;
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
        // The frame rate is the headline's own.
        let ladder = Ladder::new(own, &rungs, window, 0.0, self.seed)?;
        let mut likeness = ladder.judge(judged)?;
        if let Some(part) = ladder.part_of(judged.events.len() as u64) {
            let (tuned, _) = self.at_parts(&description, &[part])?;
            ladder.tune(&mut likeness, judged, (part, &tuned))?;
        }
        Ok(Equivalent {
            percent: likeness.threshold_equivalent_percent,
            is_least: likeness.threshold_equivalent_is_least,
            tuned: likeness.tuned,
        })
    }

    /// What the sensor says of the scene at these parts of its thresholds: the first, and the
    /// others.
    fn at_parts(
        &self,
        description: &Description,
        parts: &[f64],
    ) -> miette::Result<(Packet, Vec<Packet>)> {
        let observation = Observation::new();
        let mut scene = self.shown(&observation)?;
        let size = scene.size();
        let mut sensors = Vec::new();
        for part in parts {
            let description = equivalent::at_part(description, *part);
            let format = Format::F64;
            sensors.push(Reference::in_format(format, description, size, self.seed)?);
        }
        budget::check_study(&*scene, sensors.len())?;
        let mut watching: Vec<&mut (dyn Sensor + Send)> = Vec::new();
        for sensor in &mut sensors {
            watching.push(&mut **sensor);
        }
        let progress = Progress::new("watching", scene.frames());
        let packets = rig::watch(&mut *scene, &mut watching, |_| progress.tick());
        progress.finish();
        if parts.len() > 1 {
            light::warn(&Warning::of_scene(&observation, Response::IDENTITY));
            light::warn(Warning::assumed_rate(&observation, "--fps").as_slice());
        }
        let mut packets = packets?.into_iter();
        let first = packets.next().unwrap_or_else(|| Packet::new(size, 1));
        Ok((first, packets.collect()))
    }
}
