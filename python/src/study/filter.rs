//! Filters alone, as bare statements.

use amacrine::{
    compile::{Border, Request},
    isa::{Device, Figure},
};
use pyo3::prelude::*;

use super::{Named, Search, device, kernel};
use crate::{
    chip::{effort, named, quantiser},
    error::{raised, refused},
    pool,
    stop::Flag,
};

/// Its text, and of each result the register and what it is of kernel times input.
type Found = (String, Vec<(String, f64)>);

/// Kernels as statements that filter what register A holds; `how`: the few values, the range of the
/// input, whether they are to be right up to the border, and what they are to be best at.
#[pyfunction]
pub fn compile_filter(
    py: Python<'_>,
    of: Vec<Named>,
    how: (&str, Option<(f64, f64)>, bool, &str),
    search: Search<'_>,
) -> PyResult<Found> {
    let (to, input, border, aim) = how;
    let (sum_to, chip, seconds, seed) = search;
    let stop = Flag::new();
    let (effort, device) = (effort(seconds, stop.stop())?, device(chip)?);
    check(input, &device)?;
    let sum = named(sum_to)?;
    let mut kernels = of.iter().map(kernel).collect::<PyResult<Vec<_>>>()?;
    let mut scales = vec![1.0; kernels.len()];
    let to = match to {
        "exact" | "none" => None,
        name => Some(quantiser(name)?),
    };
    for (kernel, scale) in kernels.iter_mut().zip(&mut scales) {
        let Some(to) = to else { continue };
        let few = to.quantise(kernel, sum, seed).map_err(raised)?;
        (*kernel, *scale) = (few.levels, few.scale);
    }
    for (kernel, (name, _)) in kernels.iter().zip(&of) {
        if kernel.is_zero() {
            return Err(refused(
                format!("{name} has no weight but 0: nothing comes of it"),
                "give it a weight; few values can round all of them to 0",
            ));
        }
    }
    let mut request = Request::new(&kernels, &device).map_err(raised)?;
    (request.effort, request.seed) = (effort, seed);
    request.range = input;
    if border {
        request.border = Border::Right;
    }
    request.objective = named(aim)?;
    let pool = pool::pool()?;
    let found = pool::watched(py, stop.flag(), || pool.install(|| request.filter()))?;
    let filter = found.map_err(raised)?;
    let named = request
        .into
        .iter()
        .map(|register| device.analog_name(*register));
    let results = named.zip(scales.iter().map(|scale| filter.scale() / scale));
    Ok((filter.alone(&device), results.collect()))
}

/// Refuses an input that a register does not hold.
fn check(input: Option<(f64, f64)>, device: &Device) -> PyResult<()> {
    let [lowest, highest] = [Figure::Lowest, Figure::Highest].map(|end| device.value(end));
    // Half a level beyond is what light has at most.
    let is_held = |(low, high): &(f64, f64)| *low >= lowest && *high <= highest + 0.5 && low < high;
    match input.filter(|input| !is_held(input)) {
        Some((low, high)) => Err(refused(
            format!("input = ({low}, {high}): a register holds {lowest} to {highest} LSB"),
            "give the least and the most, such as input=(0, 127)",
        )),
        None => Ok(()),
    }
}
