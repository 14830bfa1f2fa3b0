//! The float model backwards: light and parameters in, voxels and counts out, and back.

use std::sync::{LazyLock, Mutex, PoisonError};

use amacrine::{
    gradient::{Ask, Clips, Float, Forward, GradientError, Model, Rule, Slope},
    kernel::Kernel,
    plane::{Plane, Size},
    reference::Description,
};
use numpy::{
    Element, PyArray1, PyArray2, PyArray4, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2,
    PyReadonlyArray3, PyReadonlyArray4, PyUntypedArrayMethods,
};
use pyo3::prelude::*;

use crate::{
    chip::plane,
    error::{not_finite, raised, refused},
    pool,
    sensor::Sensor,
};

/// A format with room for one batch: what the last result held, so that a step of training needs no
/// fresh memory.
trait Spare: Float {
    fn spare() -> &'static Mutex<Forward<Self>>;
}

impl Spare for f32 {
    fn spare() -> &'static Mutex<Forward<Self>> {
        static ROOM: LazyLock<Mutex<Forward<f32>>> = LazyLock::new(Mutex::default);
        &ROOM
    }
}

impl Spare for f64 {
    fn spare() -> &'static Mutex<Forward<Self>> {
        static ROOM: LazyLock<Mutex<Forward<f64>>> = LazyLock::new(Mutex::default);
        &ROOM
    }
}

/// What a sensor made of a batch of clips, and the sensor.
struct Pass<R: Spare> {
    model: Model<R>,
    seen: Forward<R>,
}

impl<R: Spare> Drop for Pass<R> {
    fn drop(&mut self) {
        let mut room = R::spare().lock().unwrap_or_else(PoisonError::into_inner);
        std::mem::swap(&mut *room, &mut self.seen);
    }
}

enum Either {
    Narrow(Box<Pass<f32>>),
    Wide(Box<Pass<f64>>),
}

/// What a sensor made of a batch of clips, in f32 or f64, ready for the way back.
#[pyclass(frozen, module = "amacrine._amacrine")]
pub struct Seen(Either);

/// Kernels (K,k,k), and for each of them the ON and the OFF threshold and the deviation of their
/// mismatch.
type Learned<'py> = (PyReadonlyArray3<'py, f64>, PyReadonlyArray2<'py, f64>);

/// A kind's gradient: its kernels, its ON and its OFF thresholds, the deviation of their mismatch, and
/// the gains of the released code.
type OfKind<'py> = (
    Vec<Bound<'py, PyArray2<f64>>>,
    Vec<f64>,
    Vec<f64>,
    Vec<f64>,
    [f64; 2],
);

/// The description with kernels and thresholds of arrays.
fn learned(description: &Description, (kernels, limits): &Learned<'_>) -> PyResult<Description> {
    let (kernels, limits) = (kernels.as_array(), limits.as_array());
    let (count, height, width) = kernels.dim();
    let mut description = description.clone();
    let kinds = description.channels.len();
    let plain = description.channels.iter().all(|channel| {
        channel.kernels.len() == 1 && channel.thresholds.len() == 1 && channel.surrounds.is_none()
    });
    if count != kinds || limits.dim() != (count, 3) || !plain {
        return Err(refused(
            format!(
                "kernels of shape {:?} and thresholds of shape {:?} for {kinds} kinds of cells",
                kernels.shape(),
                limits.shape()
            ),
            "give every kind of cell one kernel and one pair of thresholds",
        ));
    }
    for (k, channel) in description.channels.iter_mut().enumerate() {
        let mut weights = Plane::zeros((height, width));
        for ((y, x), weight) in weights.indexed_iter_mut() {
            *weight = kernels[[k, y, x]];
        }
        let kernel = Kernel::new(weights).map_err(|error| {
            refused(
                format!("kernels[{k}]: {error}"),
                "kernels must be finite; where they are learned, take a smaller learning rate",
            )
        })?;
        channel.kernels = vec![kernel];
        for threshold in &mut channel.thresholds {
            threshold.on = limits[[k, 0]];
            threshold.off = limits[[k, 1]];
            threshold.sigma = limits[[k, 2]];
            let good = [threshold.on, threshold.off]
                .iter()
                .all(|theta| *theta > 0.0 && theta.is_finite());
            if !(good && threshold.sigma >= 0.0 && threshold.sigma.is_finite()) {
                return Err(refused(
                    format!(
                        "thresholds[{k}] are {} (ON) and {} (OFF), sigma {}",
                        threshold.on, threshold.off, threshold.sigma
                    ),
                    "thresholds must be finite and above 0, and sigma 0 or above; where they are learned, take a smaller learning rate",
                ));
            }
        }
    }
    Ok(description)
}

fn pass<R: Spare>(
    description: Description,
    light: &[R],
    (times, size): (&[f64], Size),
    (seed, phase): (u64, Option<f64>),
) -> Result<Box<Pass<R>>, GradientError> {
    let mut model = Model::new(description, size, seed)?;
    if let Some(shift) = phase {
        model = model.with_phase(seed, shift);
    }
    let room = R::spare().lock();
    let mut seen = std::mem::take(&mut *room.unwrap_or_else(PoisonError::into_inner));
    model.forward_into(Clips::new(light, times, size)?, &mut seen)?;
    Ok(Box::new(Pass { model, seen }))
}

fn scattered(what: &str) -> PyErr {
    refused(
        format!("{what} does not lie row by row"),
        "give a copy of it",
    )
}

/// The events of a batch of clips: light (B,T,H,W) of float32 or float64, in which all is computed,
/// and the time of each frame in seconds.
#[pyfunction]
pub fn forward(
    py: Python<'_>,
    sensor: &Bound<'_, Sensor>,
    parameters: Option<Learned<'_>>,
    light: &Bound<'_, PyAny>,
    times: Vec<f64>,
    seed: u64,
    phase: Option<f64>,
) -> PyResult<Seen> {
    let description = &sensor.get().description;
    let description = match &parameters {
        Some(given) => learned(description, given)?,
        None => description.clone(),
    };
    let size = |shape: &[usize]| match *shape {
        [_, _, height, width] => Size::new(height, width),
        _ => Size::new(0, 0),
    };
    let how = (seed, phase);
    if let Ok(array) = light.cast::<PyArray4<f32>>() {
        let array: PyReadonlyArray4<'_, f32> = array.readonly();
        let size = size(array.shape());
        let light = array.as_slice().map_err(|_| scattered("the light"))?;
        let made = pool::work(py, || pass(description, light, (&times, size), how))?;
        return Ok(Seen(Either::Narrow(made.map_err(raised)?)));
    }
    if let Ok(array) = light.cast::<PyArray4<f64>>() {
        let array: PyReadonlyArray4<'_, f64> = array.readonly();
        let size = size(array.shape());
        let light = array.as_slice().map_err(|_| scattered("the light"))?;
        let made = pool::work(py, || pass(description, light, (&times, size), how))?;
        return Ok(Seen(Either::Wide(made.map_err(raised)?)));
    }
    Err(refused(
        "the light is no array (B,T,H,W) of float32 or float64",
        "give an array of shape (B,T,H,W)",
    ))
}

/// The text of the sensor that has these kernels and thresholds, (K,k,k) and (K,3).
///
/// # Errors
/// When a sensor cannot have them.
#[pyfunction]
pub fn learned_text(
    sensor: &Bound<'_, Sensor>,
    parameters: Learned<'_>,
    name: Option<String>,
) -> PyResult<String> {
    let mut description = learned(&sensor.get().description, &parameters)?;
    description.name = name.unwrap_or(description.name);
    Ok(description.to_toml())
}

/// The rule of this name; that which suits the sensor's memory where there is none.
fn rule<R: Float>(name: Option<&str>, model: &Model<R>) -> PyResult<Rule> {
    match name {
        None => Ok(model.rule()),
        Some("authors") => Ok(Rule::Authors),
        Some("reset") => Ok(Rule::Reset),
        Some("through") => Ok(Rule::Through),
        Some("mean") => Ok(Rule::Mean),
        Some(other) => Err(refused(
            format!("`{other}` is no rule of the gradient"),
            "give through, reset, authors or mean; docs/learning.md derives each",
        )),
    }
}

fn slope(name: &str) -> PyResult<Slope> {
    match name {
        "all" => Ok(Slope::All),
        "fired" => Ok(Slope::Fired),
        _ => Err(refused(
            format!("`{name}` is no slope"),
            "give all (every cell feels the number of events) or fired (those that did)",
        )),
    }
}

impl<R: Spare + Element> Pass<R> {
    fn voxels<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        PyArray1::from_slice(py, self.seen.voxels()).into_any()
    }

    fn backward<'py>(
        &self,
        py: Python<'py>,
        (voxels, counts, events): (Option<&Bound<'py, PyAny>>, Option<&Bound<'py, PyAny>>, f64),
        (rule_name, slope): (Option<&str>, Slope),
        light: bool,
    ) -> PyResult<(Vec<OfKind<'py>>, Option<Bound<'py, PyAny>>)> {
        let rule = rule(rule_name, &self.model)?;
        let flat = |given: Option<&Bound<'py, PyAny>>| {
            given
                .map(|array| {
                    let array = array.cast::<PyArray1<R>>().map_err(|_| {
                        refused(
                            "a gradient is of another type than the light was",
                            "give gradients of the dtype of voxels and counts",
                        )
                    })?;
                    Ok::<PyReadonlyArray1<'py, R>, PyErr>(array.readonly())
                })
                .transpose()
        };
        let (voxels, counts) = (flat(voxels)?, flat(counts)?);
        let slice = |array: &'_ Option<PyReadonlyArray1<'py, R>>| match array {
            Some(array) => Ok(Some(
                array
                    .as_slice()
                    .map_err(|_| scattered("a gradient"))?
                    .to_vec(),
            )),
            None => Ok::<_, PyErr>(None),
        };
        let (voxels, counts) = (slice(&voxels)?, slice(&counts)?);
        let gradient = pool::work(py, || {
            let ask = Ask {
                voxels: voxels.as_deref(),
                counts: counts.as_deref(),
                events,
                slope,
                light,
            };
            self.model.backward(&self.seen, &ask, rule)
        })?;
        let gradient = gradient.map_err(|error| match error {
            GradientError::NotFinite { .. } => not_finite(error),
            other => raised(other),
        })?;
        let kinds = gradient.channels.iter().map(|kind| {
            let kernels = kind.kernels.iter().map(|it| plane(py, it));
            let kernels = kernels.collect::<PyResult<_>>()?;
            let (on, off, sigma) = (kind.on.clone(), kind.off.clone(), kind.sigma.clone());
            Ok((kernels, on, off, sigma, kind.gains))
        });
        let light = gradient
            .light
            .map(|all| PyArray1::from_vec(py, all).into_any());
        Ok((kinds.collect::<PyResult<_>>()?, light))
    }
}

#[pymethods]
impl Seen {
    /// The voxels, flat; (B,T,K,H,W).
    #[getter]
    fn voxels<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        match &self.0 {
            Either::Narrow(pass) => pass.voxels(py),
            Either::Wide(pass) => pass.voxels(py),
        }
    }

    /// The signed counts, flat; (B,T-1,K,H,W).
    #[getter]
    fn counts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i32>> {
        match &self.0 {
            Either::Narrow(pass) => PyArray1::from_slice(py, pass.seen.counts()),
            Either::Wide(pass) => PyArray1::from_slice(py, pass.seen.counts()),
        }
    }

    /// The shape of the voxels.
    #[getter]
    fn shape(&self) -> [usize; 5] {
        match &self.0 {
            Either::Narrow(pass) => pass.seen.shape(),
            Either::Wide(pass) => pass.seen.shape(),
        }
    }

    /// The number of events.
    #[getter]
    fn events(&self) -> u64 {
        match &self.0 {
            Either::Narrow(pass) => pass.seen.events(),
            Either::Wide(pass) => pass.seen.events(),
        }
    }

    /// The gradient of a loss, from its gradients of voxels and counts, flat, and of the number of
    /// events: of each kind, and of the light, flat, where it is asked for.
    fn backward<'py>(
        &self,
        py: Python<'py>,
        voxels: Option<Bound<'py, PyAny>>,
        counts: Option<Bound<'py, PyAny>>,
        events: f64,
        rule: Option<&str>,
        slope: &str,
        light: bool,
    ) -> PyResult<(Vec<OfKind<'py>>, Option<Bound<'py, PyAny>>)> {
        let ask = (voxels.as_ref(), counts.as_ref(), events);
        let how = (rule, self::slope(slope)?);
        match &self.0 {
            Either::Narrow(pass) => pass.backward(py, ask, how, light),
            Either::Wide(pass) => pass.backward(py, ask, how, light),
        }
    }
}
