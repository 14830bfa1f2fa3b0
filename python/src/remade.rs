//! The sensor that made the reference of a comparison, on its scene.

use amacrine::{
    event::Packet,
    number::{Format, FormatError},
    photoreceptor::Response,
    rig::guard::Warning,
    scene::{Scene, upsample},
    study::remade::{Equivalent, Remade},
    unit::Micros,
};
use miette::Report;
use pyo3::prelude::*;

use crate::{error::raised, options::caution, sensor::Sensor, source::Source, study::Shown};

/// The sensor, what it is called, its number format and its seed; the scene, and the contrast that
/// frames are put in for.
#[derive(FromPyObject)]
pub struct By<'py>(Py<Sensor>, String, (String, u64), Shown<'py>, Option<f64>);

/// The same, checked.
pub struct Maker {
    sensor: Py<Sensor>,
    called: String,
    format: Format,
    seed: u64,
    pub source: Source,
    contrast: Option<f64>,
}

impl By<'_> {
    pub fn maker(self) -> PyResult<Maker> {
        let Self(sensor, called, (format, seed), scene, contrast) = self;
        Ok(Maker {
            sensor,
            called,
            format: format.parse().map_err(|e: FormatError| raised(e))?,
            seed,
            source: scene.source()?,
            contrast,
        })
    }
}

impl Maker {
    fn open(&self) -> Result<Box<dyn Scene + '_>, Report> {
        Ok(upsample::by_contrast(self.source.open()?, self.contrast)?)
    }

    /// Frames a second of the scene.
    pub fn fps(&self) -> Result<f64, Report> {
        Ok(self.open()?.fps())
    }

    /// The change of the threshold that costs as much as what is judged lacks.
    pub fn equivalent(
        &self,
        reference: &str,
        packets: [&Packet; 2],
        window: (Micros, u64),
    ) -> Result<Equivalent, Report> {
        let remade = Remade {
            description: &self.sensor.get().description,
            format: self.format,
            seed: self.seed,
            reference,
            sensor: &self.called,
            scene: self.source.name(),
        };
        remade.equivalent(packets, window, |parts| {
            Ok(remade.at(parts, &mut *self.open()?, || ())?)
        })
    }

    /// Warns whoever called of what there is to warn of in the scene.
    pub fn warn(&self, py: Python<'_>) -> PyResult<()> {
        let observation = self.source.observation();
        let rate = Warning::assumed_rate(observation, "fps");
        for warning in Warning::of_scene(observation, Response::IDENTITY)
            .iter()
            .chain(&rate)
        {
            caution(py, warning)?;
        }
        Ok(())
    }
}
