//! Folders of one study, joined into another.

use std::{
    collections::{BTreeSet, HashMap},
    fs,
    path::{Path, PathBuf},
};

pub use super::difference::Disagreement;

use crate::order::Order;

use super::{
    difference::differences,
    error::{Kept, StoreError},
    manifest::{self, Manifest},
    record::Record,
    store::{Held, Store, Tables, held},
};

/// Joins folders of one study into another. A folder that is named twice counts once; a point
/// that failed gives way to one that did not.
///
/// # Errors
/// When the folders are of different studies or builds, one cannot be read or is damaged, they
/// disagree on a point, or the output is one of them, is in use or cannot be written. Only in
/// the last case may some points have been written; they are whole.
pub fn merge(folders: &[PathBuf], into: &Path, parquet: bool) -> Kept<(Manifest, Tables)> {
    let folders = once(folders, into)?;
    let (first, others) = folders.split_first().ok_or(StoreError::Nothing)?;
    let manifest = Manifest::read(first)?;
    for other in others {
        Manifest::read(other)?.check_same(other, &manifest)?;
    }
    let mut read = Vec::new();
    // What is there already is judged with the others; nobody adds to it meanwhile.
    let mut there = None;
    if manifest::file(into).symlink_metadata().is_ok() {
        Manifest::read(into)?.check_same(into, &manifest)?;
        there = Some(Store::open(into, &manifest)?);
        read.push((into, held(into, &manifest)?));
    }
    for folder in &folders {
        read.push((folder.as_path(), held(folder, &manifest)?));
    }
    let damaged: Vec<_> = read
        .iter()
        .flat_map(|(_, held)| held.damaged.clone())
        .collect();
    if !damaged.is_empty() {
        return Err(StoreError::Points { damaged });
    }
    let joined = joined(&manifest, &read)?;
    let store = match there {
        Some(store) => store,
        None => Store::open(into, &manifest)?,
    };
    for (id, (folder, record)) in &joined {
        if *folder != into {
            store.keep(id, record)?;
        }
    }
    let tables = store.write_tables(parquet)?;
    Ok((manifest, tables))
}

/// Each folder once, whatever its name; none of them the output.
fn once(folders: &[PathBuf], into: &Path) -> Kept<Vec<PathBuf>> {
    let own = fs::canonicalize(into).ok();
    let (mut seen, mut kept) = (BTreeSet::new(), Vec::new());
    for folder in folders {
        let real = fs::canonicalize(folder).map_err(|cause| StoreError::Unreadable {
            path: folder.clone(),
            cause,
        })?;
        if own.as_ref() == Some(&real) {
            return Err(StoreError::Input {
                folder: folder.clone(),
            });
        }
        if seen.insert(real) {
            kept.push(folder.clone());
        }
    }
    Ok(kept)
}

type Joined<'a> = HashMap<&'a str, (&'a Path, &'a Record)>;

/// The first result of every point, all others agreeing with it.
fn joined<'a>(manifest: &Manifest, read: &'a [(&'a Path, Held)]) -> Kept<Joined<'a>> {
    let mut all: Joined<'_> = HashMap::new();
    let mut disagreements = Vec::new();
    for (folder, held) in read {
        for (id, record) in &held.records {
            let Some((known_in, known)) = all.get(id.as_str()) else {
                all.insert(id, (folder, record));
                continue;
            };
            if !record.is_final() {
                continue;
            }
            if !known.is_final() {
                all.insert(id, (folder, record));
                continue;
            }
            let found = differences(&manifest.columns, &known.row, &record.row);
            disagreements.extend(found.map(|(column, one, other)| Disagreement {
                point: 0,
                id: id.clone(),
                column: column.to_owned(),
                values: [
                    (known_in.to_path_buf(), one.clone()),
                    (folder.to_path_buf(), other.clone()),
                ],
            }));
        }
    }
    if disagreements.is_empty() {
        return Ok(all);
    }
    let indices = manifest.indices();
    for disagreement in &mut disagreements {
        disagreement.point = indices.get(&*disagreement.id).copied().unwrap_or_default();
    }
    disagreements.order_by(|a, b| (a.point, &a.column).cmp(&(b.point, &b.column)));
    let points: BTreeSet<usize> = disagreements.iter().map(|d| d.point).collect();
    Err(StoreError::Disagree {
        points: points.len(),
        disagreements,
    })
}
