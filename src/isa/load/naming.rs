//! What a chip of one's own is called: as its folder, and as no shipped chip.

use std::path::Path;

use crate::config::{Fault, Faults};

use super::{
    error::LoadError,
    layers::{Layer, SHIPPED, disk_folder},
};

/// Refuses a chip on disk that has another name than its folder, or that of a shipped chip: programs
/// name the chip that they are for.
pub(super) fn check(layers: &[Layer]) -> Result<(), Faults> {
    for layer in layers {
        let Some(path) = &layer.folder.path else {
            continue;
        };
        let name = &layer.device.name;
        // Of `.` and `..` too.
        let full = path.canonicalize().unwrap_or_else(|_| path.clone());
        let folder = full.file_name().map(|it| it.to_string_lossy().into_owned());
        let folder = folder.unwrap_or_default();
        let fault = if name.value != folder {
            let what = format!(
                "the chip is called `{}`, and its folder `{folder}`",
                name.value
            );
            Fault::error(name.place, what, "this name")
                .help("give both one name: a program finds its chip by the name of the folder")
        } else if is_shipped(&name.value) && !is_as_shipped(layer) {
            let what = format!("`{folder}` is the name of a shipped chip");
            Fault::error(name.place, what, "this name").help(
                "give the folder and `name` another one: a program that says this name is for the shipped chip",
            )
        } else {
            continue;
        };
        layer.wrong("device.toml", vec![fault])?;
    }
    Ok(())
}

/// Refuses the name of a shipped chip where a folder of that name here is another chip.
pub(super) fn check_no_other(name: &str, folder: &Path) -> Result<(), LoadError> {
    if !folder.join("device.toml").is_file() {
        return Ok(());
    }
    let texts = disk_folder(folder)?;
    let found = SHIPPED.iter().find(|(shipped, ..)| *shipped == name);
    if found.is_none_or(|it| (it.1, it.2, it.3) == texts.all()) {
        return Ok(());
    }
    Err(LoadError::Twice {
        name: name.to_owned(),
        folder: folder.display().to_string(),
    })
}

fn is_shipped(name: &str) -> bool {
    SHIPPED.iter().any(|(shipped, ..)| *shipped == name)
}

/// Whether it is a shipped chip word for word, as in a copy of the sources.
fn is_as_shipped(layer: &Layer) -> bool {
    let name = &layer.device.name.value;
    let found = SHIPPED.iter().find(|(shipped, ..)| shipped == name);
    found.is_some_and(|it| (it.1, it.2, it.3) == layer.folder.all())
}
