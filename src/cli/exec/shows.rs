//! `exec --displays`: what the program shows, as pictures.

use std::path::{Path, PathBuf};

use super::report::Written;
use crate::{
    array::{Array, Readings},
    cli::input::opened_program::Opened,
    picture::{panel, write_png},
    plane::Plane,
};

/// The pictures of a run.
pub struct Shows<'a> {
    opened: &'a Opened,
    folder: Option<&'a Path>,
    written: Vec<PathBuf>,
}

impl<'a> Shows<'a> {
    pub const fn new(opened: &'a Opened, folder: Option<&'a Path>) -> Self {
        Self {
            opened,
            folder,
            written: Vec::new(),
        }
    }

    /// Writes what the last frame showed: whole registers, as they were read.
    pub fn frame(&mut self, chip: &dyn Array, index: u64) -> miette::Result<()> {
        let Some(folder) = self.folder else {
            return Ok(());
        };
        let mut lines: Vec<String> = Vec::new();
        for reading in chip.readings() {
            let Some(picture) = picture(&reading.values, chip) else {
                continue;
            };
            let line = plain(&reading.stands());
            let again = lines.iter().filter(|it| **it == line).count();
            lines.push(line.clone());
            let again = match again {
                0 => String::new(),
                again => format!("-{}", again + 1),
            };
            let title = self.opened.program.titles.get(&reading.stands());
            let title = title.map_or_else(String::new, |title| format!("-{}", plain(title)));
            let name = format!("{line}{again}{title}-frame-{index:04}.png");
            let path = folder.join(name);
            write_png(&path, &picture)?;
            self.written.push(path);
        }
        Ok(())
    }

    /// What was written.
    pub fn written(&self) -> Option<Written> {
        let folder = self.folder.filter(|_| !self.written.is_empty())?;
        Some(Written {
            path: folder.to_path_buf(),
            files: Some(self.written.len()),
        })
    }

    /// What is said where there was nothing to write.
    pub fn note(&self) -> Option<String> {
        let folder = self.folder.filter(|_| self.written.is_empty())?;
        Some(format!(
            "--displays {}: nothing was written, since the program showed no register (scamp5_output_image does)",
            folder.display()
        ))
    }
}

/// The picture of a reading of a whole register; none of anything else.
fn picture(values: &Readings, chip: &dyn Array) -> Option<image::RgbImage> {
    let size = chip.size();
    let at = |columns: usize, length: usize| columns == size.width && length == size.pixels();
    // Rows come from the right.
    let plane = |value: &dyn Fn(usize) -> f64| {
        Plane::from_shape_fn(size.shape(), |(y, x)| {
            value(y * size.width + size.width - 1 - x)
        })
    };
    match values {
        Readings::Analog { columns, values } if at(*columns, values.len()) => {
            let plane = plane(&|i| f64::from(values[i]));
            Some(panel::frame(&plane, 0.0, 255.0))
        }
        Readings::Digital { columns, values } if at(*columns, values.len()) => {
            let plane = plane(&|i| f64::from(u8::from(values[i])));
            Some(panel::frame(&plane, 0.0, 1.0))
        }
        _ => None,
    }
}

/// A title as a part of a file's name.
fn plain(title: &str) -> String {
    let plain = title
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' });
    plain.take(40).collect()
}
