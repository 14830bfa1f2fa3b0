//! The reference of a comparison, made again by the sensor that it came from at other thresholds:
//! the threshold equivalent of what the judged packet lacks.

use miette::{Report, WrapErr, miette};
use serde::Serialize;

use super::equivalent::{self, Ladder, RUNGS, Tuned};
use crate::{
    compare::{Pair, equality},
    event::Packet,
    number::Format,
    reference::{Description, Reference},
    rig,
    scene::Scene,
    sensor::Sensor,
    unit::Micros,
};

/// The change of the reference sensor's threshold that costs as much.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Equivalent {
    /// In per cent; none where it is not known.
    #[serde(rename = "threshold_equivalent_percent")]
    pub percent: Option<f64>,
    /// Whether it is at least that.
    #[serde(rename = "threshold_equivalent_is_least")]
    pub is_least: bool,
    /// Against the sensor that says as many events; none where no threshold does.
    pub tuned: Option<Tuned>,
}

/// Who made the reference, and what each is called.
#[derive(Clone, Copy, Debug)]
pub struct Remade<'a> {
    /// The sensor.
    pub description: &'a Description,
    /// Its number format.
    pub format: Format,
    /// Of its mismatch and noise.
    pub seed: u64,
    /// What the reference is called.
    pub reference: &'a str,
    /// What the sensor is called.
    pub sensor: &'a str,
    /// What the scene is called.
    pub scene: &'a str,
}

impl Remade<'_> {
    /// The change of the threshold that costs as much as what the judged packet lacks within a
    /// window, redrawn under this seed; beside it the same against the sensor of as many events. `at`
    /// gives the packet of the sensor at each of these parts of its thresholds, as [`Self::at`] does.
    ///
    /// # Errors
    /// When the reference is not what this sensor says of the scene, or sensor or scene cannot go on.
    ///
    /// # Panics
    /// When `at` gives no packet.
    pub fn equivalent(
        &self,
        [reference, judged]: [&Packet; 2],
        (window, seed): (Micros, u64),
        mut at: impl FnMut(&[f64]) -> Result<Vec<Packet>, Report>,
    ) -> Result<Equivalent, Report> {
        let mut parts = vec![1.0];
        parts.extend(RUNGS);
        let mut rungs = at(&parts)?;
        let own = rungs.remove(0);
        let seen = || format!("{} seen by {}", self.scene, self.sensor);
        let pair = Pair::new(reference, &own).wrap_err_with(seen)?;
        if let Some(first) = equality::first_divergence(&pair) {
            return Err(miette!(
                help = "give the scene, --fps, --upsample and --seed with which the reference was made, or leave --sensor out",
                "{} is not what {} says of {}: they part at {}, x {} y {} channel {}",
                self.reference,
                self.sensor,
                self.scene,
                first.t,
                first.x,
                first.y,
                first.channel
            ));
        }
        // The frame rate is the headline's own.
        let ladder = Ladder::new(own, &rungs, window, 0.0, seed)?;
        let mut likeness = ladder.judge(judged)?;
        if let Some(part) = ladder.part_of(judged.events.len() as u64)
            && let [tuned] = &at(&[part])?[..]
        {
            ladder.tune(&mut likeness, judged, (part, tuned))?;
        }
        Ok(Equivalent {
            percent: likeness.threshold_equivalent_percent,
            is_least: likeness.threshold_equivalent_is_least,
            tuned: likeness.tuned,
        })
    }

    /// What the sensor says of a scene at each of these parts of its thresholds.
    ///
    /// # Errors
    /// When sensor or scene cannot go on.
    pub fn at(
        &self,
        parts: &[f64],
        scene: &mut dyn Scene,
        mut watched: impl FnMut(),
    ) -> Result<Vec<Packet>, Report> {
        let mut sensors = Vec::new();
        for part in parts {
            let description = equivalent::at_part(self.description, *part);
            let size = scene.size();
            sensors.push(Reference::in_format(
                self.format,
                description,
                size,
                self.seed,
            )?);
        }
        let mut watching: Vec<&mut (dyn Sensor + Send)> = Vec::new();
        for sensor in &mut sensors {
            watching.push(&mut **sensor);
        }
        Ok(rig::watch(scene, &mut watching, |_| watched())?)
    }
}
