//! The reference of a comparison, made again by the sensor that it came from at other thresholds:
//! the threshold equivalent of what the judged packet lacks.

use miette::Diagnostic;
use serde::Serialize;
use thiserror::Error;

use super::equivalent::{self, Ladder, RUNGS, Tuned};
use crate::{
    compare::{
        CompareError, Pair,
        equality::{self, Divergence},
    },
    event::Packet,
    number::Format,
    reference::{Description, Reference},
    rig::{self, RigError},
    scene::Scene,
    sensor::{Sensor, SensorError},
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

/// Why the reference could not be made again.
#[derive(Debug, Error, Diagnostic)]
pub enum RemadeError {
    /// What the sensor says of the scene has nothing in common with the reference.
    #[error("{scene} seen by {sensor}")]
    #[diagnostic(forward(cause))]
    Unlike {
        /// The scene.
        scene: String,
        /// The sensor.
        sensor: String,
        /// Why they cannot be compared.
        #[source]
        cause: CompareError,
    },
    /// The reference is not what the sensor says of the scene.
    #[error("{reference} is not what {sensor} says of {scene}: they part at {}, x {} y {} channel {}", at.t, at.x, at.y, at.channel)]
    #[diagnostic(help(
        "give the scene, --fps, --upsample and --seed with which the reference was made, or leave --sensor out"
    ))]
    Parted {
        /// The reference.
        reference: String,
        /// The sensor.
        sensor: String,
        /// The scene.
        scene: String,
        /// The first event that only one of them has.
        at: Divergence,
    },
    /// The packets cannot be compared.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Compare(#[from] CompareError),
    /// The sensor cannot be made.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Sensor(#[from] SensorError),
    /// Scene or sensor cannot go on.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Rig(#[from] RigError),
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
    pub fn equivalent<E: From<RemadeError>>(
        &self,
        [reference, judged]: [&Packet; 2],
        (window, seed): (Micros, u64),
        mut at: impl FnMut(&[f64]) -> Result<Vec<Packet>, E>,
    ) -> Result<Equivalent, E> {
        let mut parts = vec![1.0];
        parts.extend(RUNGS);
        let mut rungs = at(&parts)?;
        let own = rungs.remove(0);
        self.check(reference, &own)?;
        // The frame rate is the headline's own.
        let ladder = Ladder::new(own, &rungs, window, 0.0, seed).map_err(RemadeError::from)?;
        let mut likeness = ladder.judge(judged).map_err(RemadeError::from)?;
        if let Some(part) = ladder.part_of(judged.events.len() as u64)
            && let [tuned] = &at(&[part])?[..]
        {
            let found = ladder.tune(&mut likeness, judged, (part, tuned));
            found.map_err(RemadeError::from)?;
        }
        Ok(Equivalent {
            percent: likeness.threshold_equivalent_percent,
            is_least: likeness.threshold_equivalent_is_least,
            tuned: likeness.tuned,
        })
    }

    /// Whether the reference is what the sensor says of the scene.
    fn check(&self, reference: &Packet, own: &Packet) -> Result<(), RemadeError> {
        let [sensor, scene] = [self.sensor, self.scene].map(str::to_owned);
        let pair = match Pair::new(reference, own) {
            Ok(pair) => pair,
            Err(cause) => {
                return Err(RemadeError::Unlike {
                    scene,
                    sensor,
                    cause,
                });
            }
        };
        match equality::first_divergence(&pair) {
            None => Ok(()),
            Some(at) => Err(RemadeError::Parted {
                reference: self.reference.to_owned(),
                sensor,
                scene,
                at,
            }),
        }
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
    ) -> Result<Vec<Packet>, RemadeError> {
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
