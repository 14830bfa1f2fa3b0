//! A folder of results: `sweep.json` says of which study, `points/` holds one file a point,
//! `ledger.txt` a line for each computation that was begun, `results.*` the tables.
//!
//! A point's file gets its name when it is complete, so a kill at any moment loses at most the
//! points in flight. One process works in a folder at a time: it holds a lock on `lock`, which
//! the system takes back however the process ends.

use std::{
    collections::HashMap,
    fs::{self, File, OpenOptions},
    io::{self, Write},
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};

use super::{
    SCHEMA,
    error::StoreError,
    table::{self, Row},
};
use crate::save::save;

/// What a folder of results says about itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    /// The version that made it.
    pub amacrine: String,
    /// The version of its results.
    pub schema: u32,
    /// Identity of the study: a hash of its points.
    pub study: String,
    /// What the study is called.
    pub title: String,
    /// The columns of the tables.
    pub columns: Vec<String>,
    /// Identities of all points, in their fixed order.
    pub points: Vec<String>,
}

type Kept<T> = Result<T, StoreError>;

/// An open folder of results, held by this process alone.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    manifest: Manifest,
    ledger: File,
    /// Held as long as it is open.
    _lock: File,
}

impl Store {
    /// Makes the folder, or goes on with it.
    ///
    /// # Errors
    /// When another process works there, or it holds something else.
    pub fn open(folder: &Path, manifest: &Manifest) -> Kept<Self> {
        let cannot = |path: &Path| {
            let path = path.to_owned();
            move |cause| StoreError::Save { path, cause }
        };
        let said = folder.join("sweep.json");
        if folder.exists() && !said.exists() && !is_fresh(folder)? {
            return Err(StoreError::Foreign {
                folder: folder.to_owned(),
            });
        }
        fs::create_dir_all(folder).map_err(cannot(folder))?;
        let path = folder.join("lock");
        let lock = File::create(&path).map_err(cannot(&path))?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(fs::TryLockError::WouldBlock) => {
                return Err(StoreError::Busy {
                    folder: folder.to_owned(),
                });
            }
            Err(fs::TryLockError::Error(cause)) => return Err(StoreError::Save { path, cause }),
        }
        if said.exists() {
            same(folder, &read_manifest(folder)?, manifest)?;
        } else {
            save(&said, |out| {
                serde_json::to_writer_pretty(&mut *out, manifest)?;
                out.write_all(b"\n")
            })?;
        }
        let points = folder.join("points");
        fs::create_dir_all(&points).map_err(cannot(&points))?;
        sweep_up(&points)?;
        sweep_up(folder)?;
        let path = folder.join("ledger.txt");
        let ledger = OpenOptions::new().create(true).append(true).open(&path);
        Ok(Self {
            folder: folder.to_owned(),
            manifest: manifest.clone(),
            ledger: ledger.map_err(cannot(&path))?,
            _lock: lock,
        })
    }

    /// The points that are finished, by identity.
    ///
    /// # Errors
    /// When a file cannot be read or is damaged.
    pub fn finished(&self) -> Kept<HashMap<String, Row>> {
        finished(&self.folder, &self.manifest)
    }

    /// Notes that the computation of a point begins.
    ///
    /// # Errors
    /// When the disk does not take it.
    pub fn begin(&self, id: &str) -> Kept<()> {
        let line = format!("{id}\n");
        let written = (&self.ledger).write_all(line.as_bytes());
        written.map_err(|cause| StoreError::Save {
            path: self.folder.join("ledger.txt"),
            cause,
        })
    }

    /// Keeps a finished point.
    ///
    /// # Errors
    /// When the disk does not take it; then there is nothing of it.
    pub fn keep(&self, id: &str, row: &Row) -> Kept<()> {
        Ok(save(&file_of(&self.folder, id), |out| {
            serde_json::to_writer(&mut *out, row)?;
            out.write_all(b"\n")
        })?)
    }

    /// Writes the tables of all points that are finished; how many those are.
    ///
    /// # Errors
    /// When a file cannot be read or written.
    pub fn write_tables(&self, parquet: bool) -> Kept<usize> {
        let finished = self.finished()?;
        let rows = ordered(&self.manifest, &finished);
        save(&self.folder.join("results.csv"), |out| {
            let mut csv = csv::Writer::from_writer(out);
            csv.write_record(&self.manifest.columns)?;
            for row in &rows {
                let cells = self.manifest.columns.iter();
                csv.write_record(cells.map(|column| table::cell(row, column)))?;
            }
            csv.flush()
        })?;
        save(&self.folder.join("results.jsonl"), |out| {
            for row in &rows {
                let cells = self.manifest.columns.iter();
                let all: Row = cells
                    .map(|name| (name.clone(), row.get(name).cloned().unwrap_or_default()))
                    .collect();
                serde_json::to_writer(&mut *out, &all)?;
                out.write_all(b"\n")?;
            }
            Ok(())
        })?;
        #[cfg(feature = "parquet")]
        if parquet {
            let columns = &self.manifest.columns;
            save(&self.folder.join("results.parquet"), |out| {
                super::parquet::write(out, columns, &rows)
            })?;
        }
        #[cfg(not(feature = "parquet"))]
        let _ = parquet;
        Ok(rows.len())
    }

    /// What the folder says about itself.
    #[must_use]
    pub const fn manifest(&self) -> &Manifest {
        &self.manifest
    }
}

/// A folder's study and its finished points in their order, for whoever only looks.
///
/// # Errors
/// When it is no folder of results, of another version, or damaged.
pub fn read(folder: &Path) -> Kept<(Manifest, Vec<Row>)> {
    let manifest = read_manifest(folder)?;
    let finished = finished(folder, &manifest)?;
    let rows = ordered(&manifest, &finished);
    Ok((manifest, rows))
}

/// Joins folders of one study into another; how many of its points are there.
///
/// # Errors
/// When the folders are of different studies, or one cannot be read or written.
pub fn merge(folders: &[PathBuf], into: &Path, parquet: bool) -> Kept<(Manifest, usize)> {
    let (first, others) = folders.split_first().ok_or(StoreError::Nothing)?;
    let manifest = read_manifest(first)?;
    for other in others {
        same(other, &read_manifest(other)?, &manifest)?;
    }
    let mut all = HashMap::new();
    for folder in folders {
        all.extend(finished(folder, &manifest)?);
    }
    let store = Store::open(into, &manifest)?;
    let there = store.finished()?;
    for (id, row) in &all {
        if !there.contains_key(id) {
            store.keep(id, row)?;
        }
    }
    let rows = store.write_tables(parquet)?;
    Ok((manifest, rows))
}

/// The finished points in the order of the study, each with its number.
fn ordered(manifest: &Manifest, finished: &HashMap<String, Row>) -> Vec<Row> {
    let points = manifest.points.iter().enumerate();
    let row = |(index, id): (usize, &String)| {
        let mut row = finished.get(id)?.clone();
        row.insert("index".to_owned(), index.into());
        Some(row)
    };
    points.filter_map(row).collect()
}

fn read_manifest(folder: &Path) -> Kept<Manifest> {
    let path = folder.join("sweep.json");
    let text = fs::read_to_string(&path).map_err(|cause| {
        if cause.kind() == io::ErrorKind::NotFound && folder.exists() {
            StoreError::Foreign {
                folder: folder.to_owned(),
            }
        } else {
            StoreError::Unreadable {
                path: path.clone(),
                cause,
            }
        }
    })?;
    let damaged = |why: String| StoreError::Damaged {
        path: path.clone(),
        why,
    };
    let said: serde_json::Value =
        serde_json::from_str(&text).map_err(|e| damaged(e.to_string()))?;
    let made = said.get("amacrine").and_then(|made| made.as_str());
    let schema = said.get("schema").and_then(serde_json::Value::as_u64);
    let (Some(made), Some(schema)) = (made, schema) else {
        return Err(damaged("it does not say which version made it".to_owned()));
    };
    if made != env!("CARGO_PKG_VERSION") || schema != u64::from(SCHEMA) {
        return Err(StoreError::Version {
            folder: folder.to_owned(),
            made: made.to_owned(),
            schema,
        });
    }
    serde_json::from_value(said).map_err(|e| damaged(e.to_string()))
}

/// Refuses results of another study.
fn same(folder: &Path, held: &Manifest, asked: &Manifest) -> Kept<()> {
    if held.study == asked.study && held.columns == asked.columns {
        return Ok(());
    }
    Err(StoreError::Study {
        folder: folder.to_owned(),
        held: held.title.clone(),
        held_points: held.points.len(),
        asked: asked.title.clone(),
        asked_points: asked.points.len(),
    })
}

fn file_of(folder: &Path, id: &str) -> PathBuf {
    folder.join("points").join(format!("{id}.json"))
}

fn finished(folder: &Path, manifest: &Manifest) -> Kept<HashMap<String, Row>> {
    let mut all = HashMap::new();
    for id in &manifest.points {
        let path = file_of(folder, id);
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(cause) if cause.kind() == io::ErrorKind::NotFound => continue,
            Err(cause) => return Err(StoreError::Unreadable { path, cause }),
        };
        let row: Result<Row, _> = serde_json::from_str(&text);
        let damaged = |why: String| StoreError::Damaged {
            path: path.clone(),
            why,
        };
        let row = row.map_err(|e| damaged(e.to_string()))?;
        if row.get("id").and_then(|own| own.as_str()) != Some(id) {
            return Err(damaged("it is of another point".to_owned()));
        }
        all.insert(id.clone(), row);
    }
    Ok(all)
}

/// What a killed process left half-written.
fn leftover(name: &str) -> bool {
    name.starts_with(".tmp")
}

fn names(folder: &Path) -> Kept<Vec<String>> {
    let cannot = |cause| StoreError::Unreadable {
        path: folder.to_owned(),
        cause,
    };
    let entries = fs::read_dir(folder).map_err(cannot)?;
    let mut all = Vec::new();
    for entry in entries {
        let name = entry.map_err(cannot)?.file_name();
        all.push(name.to_string_lossy().into_owned());
    }
    Ok(all)
}

/// Whether nothing is in a folder but what a process that was killed right away has left.
fn is_fresh(folder: &Path) -> Kept<bool> {
    let names = names(folder)?;
    Ok(names.iter().all(|name| name == "lock" || leftover(name)))
}

fn sweep_up(folder: &Path) -> Kept<()> {
    for name in names(folder)?.into_iter().filter(|name| leftover(name)) {
        let path = folder.join(name);
        fs::remove_file(&path).map_err(|cause| StoreError::Save { path, cause })?;
    }
    Ok(())
}
