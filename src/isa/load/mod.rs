//! Reading a chip: `device.toml`, `primitives.toml`, `macros.scamp`, and what it extends.
//!
//! The shipped chips are part of the program text, so that it runs anywhere; a folder on disk
//! is read when it is asked for. Every check says which file, which place, and what to do.

mod figures;
mod file;
pub mod keys;
mod layers;
mod rows;

use std::{
    path::Path,
    sync::{Arc, LazyLock},
};

use self::{
    figures::{figures, registers},
    file::{DeviceFile, RowFile},
    layers::{disk_folder, layers, shipped_folder},
    rows::{all_macros, host_rows, primitive_rows},
};
use crate::{config::Faults, limit::FAULTS};

use super::{Device, macros};

/// Why a chip cannot be read.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum LoadError {
    /// No such chip.
    #[error("there is no chip `{name}`")]
    #[diagnostic(help(
        "give the name of a shipped chip ({shipped}) or a folder that holds a device.toml"
    ))]
    Unknown {
        /// What was asked for.
        name: String,
        /// What there is.
        shipped: String,
    },
    /// A file cannot be read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Unreadable(#[from] crate::source::SourceError),
    /// A file says something wrong.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Wrong(#[from] Faults),
}

/// The texts of one folder.
struct Folder {
    name: String,
    device: String,
    primitives: Option<String>,
    macros: Option<String>,
}

/// A shipped chip: name, `device.toml`, `primitives.toml`, `macros.scamp`.
type Shipped = (
    &'static str,
    &'static str,
    Option<&'static str>,
    Option<&'static str>,
);

// Every folder of `isa/` that has a `device.toml`, in order of names: `build.rs` lists them.
const SHIPPED: &[Shipped] = include!(concat!(env!("OUT_DIR"), "/chips.rs"));

/// `a` extends `b` extends `c` …, at most.
const CHAIN: usize = 8;

impl Device {
    /// The chip itself: SCAMP-5.
    ///
    /// # Panics
    /// Never: a test loads every shipped chip.
    #[must_use]
    pub fn scamp5() -> Self {
        // Its files are parsed once.
        static SCAMP5: LazyLock<Device> =
            LazyLock::new(|| shipped("scamp5").expect("the shipped chip is checked by a test"));
        SCAMP5.clone()
    }

    /// Names of the shipped chips.
    pub fn shipped() -> impl Iterator<Item = &'static str> {
        SHIPPED.iter().map(|(name, ..)| *name)
    }

    /// A shipped chip by name, or any other from its folder.
    ///
    /// # Errors
    /// When there is no such chip, or its files are wrong.
    pub fn find(name: &str) -> Result<Self, LoadError> {
        if name == "scamp5" {
            return Ok(Self::scamp5());
        }
        if SHIPPED.iter().any(|(shipped, ..)| *shipped == name) {
            return shipped(name);
        }
        let folder = Path::new(name);
        if folder.is_dir() {
            return Self::load(folder);
        }
        Err(unknown(name))
    }

    /// A chip from its folder. What it `extends` is a folder beside it, or a shipped chip.
    ///
    /// # Errors
    /// When its files cannot be read or are wrong.
    pub fn load(folder: &Path) -> Result<Self, LoadError> {
        assemble(&layers(disk_folder(folder)?, folder.parent())?)
    }
}

fn shipped(name: &str) -> Result<Device, LoadError> {
    assemble(&layers(shipped_folder(name)?, None)?)
}

fn unknown(name: &str) -> LoadError {
    LoadError::Unknown {
        name: name.to_owned(),
        shipped: Device::shipped().collect::<Vec<_>>().join(", "),
    }
}

/// One folder, read as TOML.
struct Layer {
    folder: Folder,
    device: DeviceFile,
    primitives: Vec<RowFile>,
}

/// All checks, one after the other; each can rely on those before it.
fn assemble(layers: &[Layer]) -> Result<Device, LoadError> {
    let figures = figures(layers)?;
    let registers = registers(layers)?;
    let primitives = primitive_rows(layers)?;
    let hosts = host_rows(layers)?;
    let (macros, owners) = all_macros(layers)?;
    let (top, below) = (&layers[layers.len() - 1], &layers[..layers.len() - 1]);
    let base = if below.is_empty() {
        None
    } else {
        Some(Arc::new(assemble(below)?))
    };
    let device = Device {
        name: top.device.name.value.clone(),
        title: top.device.title.clone(),
        registers,
        figures,
        primitives,
        hosts,
        macros,
        base,
    };
    let calls = macros::check_calls(&device);
    for (at, layer) in layers.iter().enumerate() {
        let own = device.macros.iter().zip(&owners).filter(|(_, o)| **o == at);
        let mut faults = Vec::new();
        for (it, _) in own {
            faults.extend(macros::check(&device, it));
            if faults.len() > FAULTS {
                break;
            }
        }
        let circles = calls.iter().filter(|(number, _)| owners[*number] == at);
        faults.extend(circles.map(|(_, fault)| fault.clone()));
        layer.wrong("macros.scamp", faults)?;
    }
    Ok(device)
}
