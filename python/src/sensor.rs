//! A float sensor: what a sensor file states.

use std::{collections::BTreeMap, io, path::PathBuf};

use amacrine::{
    number::{Format, FormatError},
    plane::Size,
    reference::{Description, Effect},
    rig::guard::Warning,
    scene::Samples,
    source,
    study::{
        cells::studied,
        pilot::{UnknownPart, left_out},
        rate,
        run_guard::RunGuard,
    },
};
use numpy::PyArray2;
use pyo3::prelude::*;

use crate::{
    chip::{self, Chip, plane},
    error::raised,
    options::{caution, in_python},
    pool,
    run::Run,
    source::Source,
    stop::Flag,
    study, watcher,
};

/// The kernels of a kind of cell, each `(k, k)`.
type Kernels<'py> = Vec<Bound<'py, PyArray2<f64>>>;

/// The kinds of cells for a study: name, kernel and threshold of each, what a program of several must
/// remember, and in what programs cannot follow the sensor.
type Studied<'py> = (
    Vec<String>,
    Kernels<'py>,
    Vec<f64>,
    Option<String>,
    Vec<String>,
);

/// A float sensor, checked.
#[pyclass(frozen, module = "amacrine._amacrine")]
pub struct Sensor {
    pub description: Description,
}

#[pymethods]
impl Sensor {
    /// The text of a sensor file called `file`. What it names is in `arrays`, as the bytes of a
    /// `.npy`, or a file in `folder`.
    #[new]
    fn new(
        file: &str,
        text: &str,
        arrays: BTreeMap<String, Vec<u8>>,
        folder: Option<PathBuf>,
    ) -> PyResult<Self> {
        let read = |name: &str| match (arrays.get(name), &folder) {
            (Some(bytes), _) => Ok(bytes.clone()),
            (None, Some(folder)) => Ok(source::bytes(&folder.join(name), "")?),
            (None, None) => Err(io::Error::from(io::ErrorKind::NotFound)),
        };
        let description = Description::parse(file, text, &read).map_err(raised)?;
        Ok(Self { description })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.description.name
    }

    /// The names of the kinds of cells, where they have one.
    #[getter]
    fn channels(&self) -> Vec<Option<String>> {
        let channels = self.description.channels.iter();
        channels.map(|channel| channel.name.clone()).collect()
    }

    /// The kernels of each kind of cell: one, or four of a 2x2 pattern; none where it sees through a
    /// mesh.
    #[getter]
    fn kernels<'py>(&self, py: Python<'py>) -> PyResult<Vec<Option<Kernels<'py>>>> {
        let channels = self.description.channels.iter();
        channels
            .map(|channel| {
                if channel.surrounds.is_some() {
                    return Ok(None);
                }
                let kernels = channel.kernels.iter();
                let kernels = kernels.map(|kernel| plane(py, kernel.weights()));
                kernels.collect::<PyResult<_>>().map(Some)
            })
            .collect()
    }

    /// The thresholds of each kind of cell, one or four: ON, OFF, and the deviation of their mismatch.
    #[getter]
    fn thresholds(&self) -> Vec<Vec<(f64, f64, f64)>> {
        let channels = self.description.channels.iter();
        channels
            .map(|channel| {
                let thresholds = channel.thresholds.iter();
                thresholds.map(|it| (it.on, it.off, it.sigma)).collect()
            })
            .collect()
    }

    /// Whether each kind of cell is a kernel and thresholds, and nothing else.
    #[getter]
    fn plain(&self) -> bool {
        self.description.channels.iter().all(|channel| {
            channel.kernels.len() == 1
                && channel.thresholds.len() == 1
                && channel.surrounds.is_none()
                && channel.memory_kernel.is_none()
                && !channel.log_temporal
        })
    }

    /// Its kinds of cells for a study, in which it is called so; thresholds in kernel times light, 0 to
    /// 255.
    fn studied<'py>(&self, py: Python<'py>, called: &str) -> PyResult<Studied<'py>> {
        let of = studied(called, &self.description).map_err(raised)?;
        let kernels = of.kernels.iter().map(|kernel| plane(py, kernel.weights()));
        let notes = of.notes.iter().map(|note| in_python(note));
        Ok((
            of.names,
            kernels.collect::<PyResult<_>>()?,
            of.thresholds,
            of.memory.map(|memory| memory.to_string()),
            notes.collect(),
        ))
    }

    /// A sensor of this size as switched on.
    fn watch(
        &self,
        py: Python<'_>,
        size: (usize, usize),
        fps: f64,
        scale: f64,
        seed: u64,
        format: &str,
        max_events: Option<usize>,
    ) -> PyResult<Run> {
        let format: Format = format.parse().map_err(|e: FormatError| raised(e))?;
        let size = Size::new(size.0, size.1);
        let description = self.description.clone();
        let channels = description.channels.len() as u8;
        let guard = RunGuard::new(&description, size, format);
        let watcher = pool::work(py, || watcher::float(description, size, seed, format))?;
        let watcher = watcher.map_err(raised)?;
        Run::new(watcher, (size, channels), guard, fps, scale, max_events)
    }

    /// What there is to warn of in numbers of light from `low` to `high` that this sensor is shown, in
    /// the words of a run.
    fn warning_of_light(&self, subject: &str, low: f64, high: f64) -> Option<String> {
        let extent = Some((low, high));
        let response = self.description.response;
        let mut warning = Warning::scale(Samples::Floats, extent, response)?;
        warning.subjects = vec![subject.to_owned()];
        Some(in_python(&warning.to_string()))
    }

    /// The text of the sensor without these effects.
    fn without(&self, effects: Vec<String>) -> PyResult<String> {
        let effects = effects.iter().map(|name| name.parse());
        let effects: Vec<Effect> = effects
            .collect::<Result<_, UnknownPart>>()
            .map_err(raised)?;
        let sensor = &self.description;
        let plain = left_out::sensor_without(&sensor.name, sensor, &effects).map_err(raised)?;
        Ok(plain.to_toml())
    }

    /// The text of the sensor with these kernels, threshold and spread in place of its own; `called` is
    /// what the kernels are called.
    fn changed(
        &self,
        kernels: Option<(Vec<study::Named>, String)>,
        threshold: Option<(f64, f64)>,
        sigma: Option<f64>,
    ) -> PyResult<String> {
        let mut sensor = self.description.clone();
        if let Some((kernels, called)) = kernels {
            let each = kernels
                .iter()
                .map(|named| Ok((named.0.clone(), study::kernel(named)?)));
            let each = each.collect::<PyResult<_>>()?;
            sensor = sensor.with_kernels(each, &called).map_err(raised)?;
        }
        let threshold = threshold.map(|(on, off)| [on, off]);
        let sensor = sensor.with_thresholds(threshold, sigma).map_err(raised)?;
        Ok(sensor.to_toml())
    }

    /// The text of the sensor with all thresholds times the factor at which it says `rate` events per
    /// pixel and second of these frames.
    fn for_rate(
        &self,
        py: Python<'_>,
        frames: &Bound<'_, PyAny>,
        fps: f64,
        scale: f64,
        rate: f64,
        seed: u64,
    ) -> PyResult<String> {
        let source = Source::new(None, Some(frames), Some(fps), Some(scale))?;
        let found = source.study(py, self.description.response, || {
            rate::factor(&self.description, rate, seed, &|| source.open())
        })?;
        let found = found.map_err(raised)?;
        if let Some(warning) = Warning::rate(&self.description.name, rate, found.rate) {
            caution(py, &warning)?;
        }
        Ok(rate::times(&self.description, found.factor).to_toml())
    }

    /// Its cells as one program of a chip.
    #[expect(clippy::too_many_arguments, reason = "as Python has them")]
    fn on_chip(
        &self,
        py: Python<'_>,
        to: &str,
        sum: &str,
        memory: Option<&str>,
        chip: &str,
        aim: (&str, bool),
        events: Option<u64>,
        effort: f64,
        seed: u64,
    ) -> PyResult<Chip> {
        let (objective, border) = aim;
        let stop = Flag::new();
        let asked = chip::Asked {
            to,
            sum,
            memory,
            chip,
            objective,
            border,
            events,
            effort,
            seed,
            stop: stop.stop(),
        };
        let pool = pool::pool()?;
        pool::watched(py, stop.flag(), || {
            pool.install(|| Chip::new(&self.description, &asked))
        })?
    }
}
