//! Finding a chip: the shipped ones by name, any other by its folder.

use std::{
    path::{Path, PathBuf},
    sync::LazyLock,
};

use crate::isa::Device;

use super::{
    assemble::assemble,
    error::LoadError,
    layers::{SHIPPED, disk_folder, layers, shipped_folder, unknown},
    naming,
};

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

    /// The text of a shipped chip's `device.toml`.
    #[must_use]
    pub fn shipped_text(name: &str) -> Option<&'static str> {
        let found = SHIPPED.iter().find(|(shipped, ..)| *shipped == name);
        found.map(|(_, device, ..)| *device)
    }

    /// A shipped chip by name, or any other from its folder.
    ///
    /// # Errors
    /// When there is no such chip, its files are wrong, or a folder has the name of a shipped one.
    pub fn find(name: &str) -> Result<Self, LoadError> {
        let folder = Path::new(name);
        if SHIPPED.iter().any(|(shipped, ..)| *shipped == name) {
            naming::check_no_other(name, folder)?;
            return if name == "scamp5" {
                Ok(Self::scamp5())
            } else {
                shipped(name)
            };
        }
        if folder.is_dir() {
            return Self::load(folder);
        }
        Err(unknown(name))
    }

    /// The chip that a program's settings name: as [`Device::find`], and else a folder beside the
    /// program, which is in `folder`.
    ///
    /// # Errors
    /// When there is no such chip, or its files are wrong.
    pub fn find_for(name: &str, program: &str, folder: &Path) -> Result<Self, LoadError> {
        let found = Self::find(name);
        if found.is_ok() && SHIPPED.iter().any(|(shipped, ..)| *shipped == name) {
            naming::check_no_other(name, &folder.join(name))?;
        }
        match found {
            Err(LoadError::Unknown { name, shipped, .. }) => {
                let beside = folder.join(&name);
                if beside.is_dir() {
                    return Self::load(&beside);
                }
                Err(LoadError::OfProgram {
                    name,
                    program: program.to_owned(),
                    shipped,
                })
            }
            found => found,
        }
    }

    /// A chip from its folder, which has its name. What it `extends` is a folder beside it, or a
    /// shipped chip.
    ///
    /// # Errors
    /// When its files cannot be read or are wrong.
    pub fn load(folder: &Path) -> Result<Self, LoadError> {
        let layers = layers(disk_folder(folder)?, folder.parent())?;
        let device = assemble(&layers)?;
        naming::check(&layers)?;
        Ok(device)
    }

    /// The folders on disk of the chips that the chip in this folder extends. None where there
    /// is no chip, or one that [`Device::load`] refuses.
    #[must_use]
    pub fn folders_extended(folder: &Path) -> Vec<PathBuf> {
        if !folder.join("device.toml").is_file() {
            return Vec::new();
        }
        let layers = disk_folder(folder).and_then(|top| layers(top, folder.parent()));
        let mut folders: Vec<PathBuf> = layers
            .unwrap_or_default()
            .into_iter()
            .filter_map(|layer| layer.folder.path)
            .collect();
        // The innermost comes first, the chip itself last.
        folders.pop();
        folders
    }
}

fn shipped(name: &str) -> Result<Device, LoadError> {
    assemble(&layers(shipped_folder(name)?, None)?)
}
