//! Studies: what a kernel loses on a chip. Answers are the library's own, as JSON.

mod exploration;
mod fall;
mod few;
mod filter;
mod front;
mod page;

pub use exploration::design;
pub use fall::waterfall;
pub use few::{on_chip, quantise};
pub use filter::compile_filter;
pub use front::{trade, trade_program};
pub use page::feasibility;

use amacrine::{
    compare::window,
    event::readout::{
        Readout,
        settings::{Description as ReadoutDescription, ReadoutError},
    },
    isa::Device,
    kernel::{Kernel, quantise::Quantiser},
    rig::Larger,
    scene::Scene,
    unit::Micros,
};
use miette::Report;
use pyo3::prelude::*;

use crate::{
    chip::quantiser,
    error::{raised, refused},
    source::Source,
};

/// A kernel by name, or the bytes of its file.
pub type Named = (String, Option<Vec<u8>>);

/// The kernel, which must be one that can be worked with.
pub fn kernel((name, bytes): &Named) -> PyResult<Kernel> {
    let kernel = match bytes {
        Some(bytes) => Kernel::from_bytes(name, bytes).map_err(|error| {
            use amacrine::kernel::KernelFileError::Wrong;
            match error {
                Wrong(faults) => raised(faults),
                other => refused(
                    format!("{name}: {other}"),
                    "give an array of shape (k,k), (K,k,k) or (K,1,k,k), k odd, of floats or integers",
                ),
            }
        })?,
        None => Kernel::builtin(name).ok_or_else(|| {
            let known: Vec<_> = Kernel::builtin_names().collect();
            refused(
                format!("cannot read the kernel {name}: no such file"),
                format!(
                    "give a kernel file (.toml, .npy) or one of {}",
                    known.join(", ")
                ),
            )
        })?,
    };
    kernel.workable().map_err(|error| {
        refused(
            format!("{name}: {error}"),
            "multiply the kernel by a number, and the threshold with it",
        )
    })?;
    Ok(kernel)
}

/// The kernel of a sensor: one that sees something.
fn sighted(named: &Named) -> PyResult<Kernel> {
    let kernel = kernel(named)?;
    if kernel.is_zero() {
        return Err(refused(
            format!("{}: all weights are 0", named.0),
            "give a kernel that sees something: no threshold makes events of this one",
        ));
    }
    Ok(kernel)
}

fn quantisers(names: Vec<String>) -> PyResult<Vec<Quantiser>> {
    names.iter().map(|name| quantiser(name)).collect()
}

fn device(name: &str) -> PyResult<Device> {
    Device::find(name).map_err(raised)
}

/// The scan that a compiled program asks for.
fn scan() -> Result<Readout, ReadoutError> {
    ReadoutDescription::of_compiled()?.readout()
}

/// How long to search, on which chip, with which seed.
pub type Search<'a> = (&'a str, &'a str, f64, u64);

fn within(asked: Option<u64>, fps: f64) -> Micros {
    asked.map_or_else(|| window::headline(fps), Micros)
}

/// What is shown: a name, or frames; frames a second, and the scale.
#[derive(FromPyObject)]
pub struct Shown<'py>(
    Option<String>,
    Option<Bound<'py, PyAny>>,
    Option<f64>,
    Option<f64>,
);

/// Opens a scene that the chip's array must hold.
fn open_on(source: &Source, device: &Device) -> Result<Box<dyn Scene>, Report> {
    let scene = source.open()?;
    Larger::check(source.name(), scene.size(), device)?;
    Ok(scene)
}

impl Shown<'_> {
    /// The scene.
    pub fn source(&self) -> PyResult<Source> {
        Source::new(self.0.clone(), self.1.as_ref(), self.2, self.3)
    }
}
