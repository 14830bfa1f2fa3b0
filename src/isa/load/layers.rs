//! The folders that a chip is made of, one over the other.

use std::path::{Path, PathBuf};

use crate::{
    config::{Fault, Faults, asked, suggestion_or},
    isa::Device,
    source,
};

use super::{
    error::LoadError,
    file::{self, DeviceFile, RowFile},
};

/// The texts of one folder.
pub(super) struct Folder {
    pub(super) name: String,
    /// Where it is, if it is not part of the program.
    pub(super) path: Option<PathBuf>,
    pub(super) device: String,
    pub(super) primitives: Option<String>,
    pub(super) macros: Option<String>,
}

impl Folder {
    /// Its texts: `device.toml`, `primitives.toml`, `macros.scamp`.
    pub(super) fn all(&self) -> (&str, Option<&str>, Option<&str>) {
        let Self {
            device,
            primitives,
            macros,
            ..
        } = self;
        (device, primitives.as_deref(), macros.as_deref())
    }
}

/// One folder, read as TOML.
pub(super) struct Layer {
    pub(super) folder: Folder,
    pub(super) device: DeviceFile,
    pub(super) primitives: Vec<RowFile>,
}

/// A shipped chip: name, `device.toml`, `primitives.toml`, `macros.scamp`.
type Shipped = (
    &'static str,
    &'static str,
    Option<&'static str>,
    Option<&'static str>,
);

// Every folder of `isa/` that has a `device.toml`, in order of names: `build.rs` lists them.
pub(super) const SHIPPED: &[Shipped] = include!(concat!(env!("OUT_DIR"), "/chips.rs"));

/// The longest chain of `extends`.
const CHAIN: usize = 8;

/// What a chip's folder holds.
const FILES: &str = "a chip is a folder with device.toml, primitives.toml and macros.scamp; one that extends another needs device.toml alone";

impl Layer {
    pub(super) fn wrong(&self, file: &str, faults: Vec<Fault>) -> Result<(), Faults> {
        let text = match file {
            "device.toml" => Some(&self.folder.device),
            "primitives.toml" => self.folder.primitives.as_ref(),
            _ => self.folder.macros.as_ref(),
        };
        let text = text.map_or("", String::as_str);
        Faults::check(&format!("{}/{file}", self.folder.name), text, faults)
    }
}

pub(super) fn shipped_folder(name: &str) -> Result<Folder, LoadError> {
    let found = SHIPPED.iter().find(|(shipped, ..)| *shipped == name);
    let (name, device, primitives, macros) = found.ok_or_else(|| unknown(name))?;
    Ok(Folder {
        name: format!("isa/{name}"),
        path: None,
        device: (*device).to_owned(),
        primitives: primitives.map(str::to_owned),
        macros: macros.map(str::to_owned),
    })
}

pub(super) fn disk_folder(folder: &Path) -> Result<Folder, LoadError> {
    let read = |file: &str| source::text(&folder.join(file), FILES);
    let maybe = |file: &str| -> Result<_, source::SourceError> {
        if folder.join(file).exists() {
            read(file).map(Some)
        } else {
            Ok(None)
        }
    };
    Ok(Folder {
        name: folder.display().to_string(),
        path: Some(folder.to_owned()),
        device: read("device.toml")?,
        primitives: maybe("primitives.toml")?,
        macros: maybe("macros.scamp")?,
    })
}

/// The chip's folder and those that it extends, the innermost first.
pub(super) fn layers(top: Folder, beside: Option<&Path>) -> Result<Vec<Layer>, LoadError> {
    let mut layers = vec![layer(top)?];
    let mut beside = beside.map(Path::to_owned);
    loop {
        let last = &layers[layers.len() - 1];
        let Some(base) = last.device.extends.clone() else {
            break;
        };
        let name = &base.value;
        if layers.len() == CHAIN || layers.iter().any(|l| l.device.name.value == *name) {
            let fault = Fault::error(
                base.place,
                format!("`{name}` comes back to itself"),
                "this chip extends itself",
            )
            .help("a chip extends one that is complete without it");
            last.wrong("device.toml", vec![fault])?;
        }
        let on_disk = beside.as_ref().map(|b| b.join(name));
        let folder = match on_disk {
            Some(path) if path.join("device.toml").exists() => disk_folder(&path)?,
            _ if Device::shipped().any(|s| s == name) => {
                beside = None;
                shipped_folder(name)?
            }
            _ => {
                let fault = Fault::error(
                    base.place,
                    format!("there is no chip `{name}` to extend"),
                    "neither a shipped chip nor a folder beside this one",
                )
                .help(suggestion_or(
                    name,
                    Device::shipped(),
                    "name a shipped chip, or a folder beside this one",
                ));
                last.wrong("device.toml", vec![fault])?;
                break;
            }
        };
        layers.push(layer(folder)?);
    }
    layers.reverse();
    Ok(layers)
}

pub(super) fn layer(folder: Folder) -> Result<Layer, LoadError> {
    let device = file::device(&format!("{}/device.toml", folder.name), &folder.device)?;
    let primitives = match &folder.primitives {
        Some(text) => file::primitives(&format!("{}/primitives.toml", folder.name), text)?,
        None => Vec::new(),
    };
    Ok(Layer {
        folder,
        device,
        primitives,
    })
}

pub(super) fn unknown(name: &str) -> LoadError {
    LoadError::Unknown {
        name: name.to_owned(),
        shipped: Device::shipped().collect::<Vec<_>>().join(", "),
        near: folder_of(name).unwrap_or_else(|| asked(name, Device::shipped())),
    }
}

/// What to give instead of a file of a chip: its folder.
fn folder_of(name: &str) -> Option<String> {
    let path = Path::new(name);
    let folder = path.parent().filter(|_| path.is_file())?;
    let folder = if folder.as_os_str().is_empty() {
        ".".to_owned()
    } else {
        folder.display().to_string()
    };
    Some(format!("a chip is a folder: give its folder {folder}; or "))
}
