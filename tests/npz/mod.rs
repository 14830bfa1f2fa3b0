//! Arrays out of the authors' `.npz` archives.

#![allow(dead_code)] // Each test takes what it needs.

pub mod oracle;

use std::{fs::File, path::Path};

use ndarray::{Array, Dimension};
use ndarray_npy::{ReadNpyExt, ReadableElement};
use zip::ZipArchive;

/// An archive that is open.
pub struct Npz(ZipArchive<File>);

impl Npz {
    pub fn open(path: &Path) -> Self {
        let file = File::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        Self(ZipArchive::new(file).unwrap_or_else(|e| panic!("{}: {e}", path.display())))
    }

    pub fn has(&self, key: &str) -> bool {
        self.0.index_for_name(&format!("{key}.npy")).is_some()
    }

    pub fn array<A: ReadableElement, D: Dimension>(&mut self, key: &str) -> Array<A, D> {
        let entry = self.0.by_name(&format!("{key}.npy"));
        let entry = entry.unwrap_or_else(|e| panic!("{key}: {e}"));
        Array::read_npy(entry).unwrap_or_else(|e| panic!("{key}: {e}"))
    }
}
