//! A folder of results: `sweep.json` says of which study, `points/` holds one file a point,
//! `ledger.txt` a line for each computation that was begun, `results.*` the tables.
//!
//! A point's file gets its name when it is complete, so a kill at any moment loses at most the
//! points in flight. It carries a checksum, so that what has changed since is not believed; what
//! is damaged is set aside in `damaged/`. One process works in a folder at a time: it holds a
//! lock on `lock`, which the system takes back however the process ends.

use std::{
    collections::{BTreeMap, HashMap},
    ffi::{OsStr, OsString},
    fs::{self, File, OpenOptions},
    io::{self, Write},
    path::{Path, PathBuf},
};

use serde::Serialize;

use super::{
    damage::Damage,
    error::{Kept, StoreError},
    manifest::{self, Manifest, is_identity},
    provenance::Provenance,
    record::{LONGEST, Record, Wrong},
    regular_file::{self, FILE, FOLDER, Unusable},
};
#[cfg(feature = "parquet")]
use crate::study::sweep::tables::parquet;
use crate::{
    rig::guard::Warning,
    save::{self, make_folder_durably, save_durably, sweep_up},
    study::sweep::tables::{
        left_out, report,
        table::{self, Row},
    },
};

/// An open folder of results, held by this process alone.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    manifest: Manifest,
    /// The number of each point.
    indices: HashMap<String, usize>,
    ledger: File,
    /// Held as long as it is open.
    lock: File,
}

impl Drop for Store {
    fn drop(&mut self) {
        // A fork of this process may have the file open, too.
        let _ = self.lock.unlock();
    }
}

/// What a folder holds of its study.
#[derive(Debug, Default)]
pub struct Held {
    /// The points that are there, by identity.
    pub records: HashMap<String, Record>,
    /// Files that cannot be believed, in the order of their points.
    pub damaged: Vec<Damage>,
}

/// What stands in the tables.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tables {
    /// Points that are done, and points that cannot be.
    pub finished: usize,
    /// Points that failed.
    pub failed: usize,
    /// Numbers of the points that are not there.
    pub missing: Vec<usize>,
    /// Who computed them.
    pub computed_by: Vec<ComputedBy>,
    /// Points among them that cannot be.
    pub refused: usize,
    /// Points among them that a plainer model stands for.
    pub left_out: usize,
    /// What makes their figures mean something else than they seem to.
    pub warnings: Vec<Warning>,
}

/// Points that were computed by one build on one kind of processor.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ComputedBy {
    /// The build and the processor.
    #[serde(flatten)]
    pub provenance: Provenance,
    /// How many points.
    pub points: usize,
}

/// The files of a folder of results, `sweep.json` left out.
const FILES: [&str; 5] = [
    "lock",
    "ledger.txt",
    "results.csv",
    "results.jsonl",
    "results.parquet",
];

/// Its folders.
const FOLDERS: [&str; 3] = ["points", "damaged", "pilots"];

impl Store {
    /// Makes the folder, or goes on with it.
    ///
    /// # Errors
    /// When another process works there, or it holds something else.
    pub fn open(folder: &Path, manifest: &Manifest) -> Kept<Self> {
        check_kinds(folder)?;
        let said = manifest::file(folder);
        if folder.exists()
            && !said.exists()
            && let Some(found) = foreign(folder)?
        {
            return Err(StoreError::Foreign {
                folder: folder.to_owned(),
                found: Some(found),
            });
        }
        make_folder_durably(folder)?;
        let path = folder.join("lock");
        let lock = open_own(&path, OpenOptions::new().create(true).write(true))?;
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
            Manifest::read(folder)?.check_same(folder, manifest)?;
        } else {
            manifest.write(folder)?;
        }
        let points = folder.join("points");
        make_folder_durably(&points)?;
        let pilots = folder.join("pilots");
        let made = [&*points, &pilots, folder];
        for folder in made.into_iter().filter(|folder| folder.is_dir()) {
            sweep_up(folder).map_err(|cause| StoreError::Unreadable {
                path: folder.to_owned(),
                cause,
            })?;
        }
        let path = folder.join("ledger.txt");
        let ledger = open_own(&path, OpenOptions::new().create(true).append(true))?;
        let indices = manifest.indices().into_iter();
        Ok(Self {
            folder: folder.to_owned(),
            manifest: manifest.clone(),
            indices: indices.map(|(id, index)| (id.to_owned(), index)).collect(),
            ledger,
            lock,
        })
    }

    /// The folder of pilots, made where it is missing.
    ///
    /// # Errors
    /// When the disk does not do it.
    pub(in crate::study::sweep) fn pilots(&self) -> Kept<PathBuf> {
        let folder = self.folder.join("pilots");
        make_folder_durably(&folder)?;
        Ok(folder)
    }

    /// What is there.
    ///
    /// # Errors
    /// When the folder cannot be read, or holds points of another build.
    pub fn held(&self) -> Kept<Held> {
        held(&self.folder, &self.manifest)
    }

    /// Moves damaged files to where they are not in the way and not lost.
    ///
    /// # Errors
    /// When the disk does not do it.
    pub fn set_aside(&self, damaged: &[Damage]) -> Kept<()> {
        if damaged.is_empty() {
            return Ok(());
        }
        let aside = self.folder.join("damaged");
        make_folder_durably(&aside)?;
        for Damage { path, .. } in damaged {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let names = (1..=1000).map(|n| match n {
                1 => name.to_string(),
                n => format!("{name}.{n}"),
            });
            let mut free = names
                .map(|name| aside.join(name))
                .filter(|to| matches!(regular_file::kind(to), Ok(None)));
            let to = free.next().unwrap_or_else(|| aside.join(&*name));
            fs::rename(path, &to).map_err(|cause| StoreError::Save { path: to, cause })?;
        }
        Ok(())
    }

    /// Takes a point away that is to be as if it had not been computed.
    ///
    /// # Errors
    /// When the disk does not do it.
    pub(in crate::study::sweep) fn forget(&self, id: &str) -> Kept<()> {
        let path = file_of(&self.folder, id);
        fs::remove_file(&path).map_err(|cause| StoreError::Save { path, cause })
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

    /// Keeps a point that was computed.
    ///
    /// # Errors
    /// When the disk does not take it; then there is nothing of it.
    pub fn keep(&self, id: &str, record: &Record) -> Kept<()> {
        let path = file_of(&self.folder, id);
        let index = self.indices.get(id).copied().unwrap_or_default();
        let text = record.text(index, &self.manifest.columns);
        if text.len() as u64 > LONGEST {
            let cause = io::Error::other(format!(
                "the point takes {} bytes, the most are {LONGEST}",
                text.len()
            ));
            return Err(StoreError::Save { path, cause });
        }
        Ok(save_durably(&path, |out| out.write_all(text.as_bytes()))?)
    }

    /// Writes the tables of all points that are there.
    ///
    /// # Errors
    /// When a file cannot be read or written.
    pub fn write_tables(&self, parquet: bool) -> Kept<Tables> {
        let (rows, tables) = believed(&self.folder, &self.manifest)?;
        save_durably(&self.folder.join("results.csv"), |out| {
            let mut csv = csv::Writer::from_writer(out);
            csv.write_record(&self.manifest.columns)?;
            for row in &rows {
                let cells = self.manifest.columns.iter();
                csv.write_record(cells.map(|column| table::cell(row, column)))?;
            }
            csv.flush()
        })?;
        save_durably(&self.folder.join("results.jsonl"), |out| {
            for row in &rows {
                serde_json::to_writer(&mut *out, row)?;
                out.write_all(b"\n")?;
            }
            Ok(())
        })?;
        #[cfg(feature = "parquet")]
        if parquet {
            let columns = &self.manifest.columns;
            save_durably(&self.folder.join("results.parquet"), |out| {
                parquet::write(out, columns, &rows)
            })?;
        }
        #[cfg(not(feature = "parquet"))]
        let _ = parquet;
        save::sync(&self.ledger).map_err(|cause| StoreError::Save {
            path: self.folder.join("ledger.txt"),
            cause,
        })?;
        Ok(tables)
    }

    /// What the folder says about itself.
    #[must_use]
    pub const fn manifest(&self) -> &Manifest {
        &self.manifest
    }
}

/// A folder's study and its points in their order, for whoever only looks.
///
/// # Errors
/// When it is no folder of results, of another version, or damaged.
pub fn read(folder: &Path) -> Kept<(Manifest, Vec<Row>, Tables)> {
    let manifest = Manifest::read(folder)?;
    let (rows, tables) = believed(folder, &manifest)?;
    Ok((manifest, rows, tables))
}

/// All points of a folder in their order; none of them may be damaged.
fn believed(folder: &Path, manifest: &Manifest) -> Kept<(Vec<Row>, Tables)> {
    let Held {
        mut records,
        damaged,
    } = held(folder, manifest)?;
    if !damaged.is_empty() {
        return Err(StoreError::Points { damaged });
    }
    let mut rows = Vec::new();
    let (mut failed, mut missing) = (0, Vec::new());
    let mut computed_by: BTreeMap<Provenance, usize> = BTreeMap::new();
    for (index, id) in manifest.points.iter().enumerate() {
        let Some(record) = records.remove(id) else {
            missing.push(index);
            continue;
        };
        failed += usize::from(!record.is_final());
        *computed_by.entry(record.provenance).or_default() += 1;
        rows.push(record.row);
    }
    let computed_by = computed_by.into_iter();
    let tables = Tables {
        refused: { rows.iter() }
            .filter(|row| table::cell(row, "outcome") == "refused")
            .count(),
        left_out: rows.iter().filter(|row| left_out::stands_for(row)).count(),
        warnings: report::warnings(&rows),
        finished: rows.len() - failed,
        failed,
        missing,
        computed_by: computed_by
            .map(|(provenance, points)| ComputedBy { provenance, points })
            .collect(),
    };
    Ok((rows, tables))
}

/// What a folder holds of a study, every file checked.
pub(super) fn held(folder: &Path, manifest: &Manifest) -> Kept<Held> {
    let points = folder.join("points");
    // The folder itself may be reached through a symlink that its user made; what is in it not.
    check_kind(&points, FOLDER)?;
    let mut held = Held::default();
    let (mut others, mut first) = (0, None);
    for (point, id) in manifest.points.iter().enumerate() {
        let path = file_of(folder, id);
        let read = match regular_file::read(&path, LONGEST) {
            Ok(bytes) => Record::read(&bytes, (point, id), &manifest.columns),
            Err(Unusable::Absent) => continue,
            Err(Unusable::Kind(found)) => Err(Wrong::Damaged(format!("{found} stands there"))),
            Err(Unusable::Long(bytes)) => Err(Wrong::Damaged(format!(
                "it has {bytes} bytes, the most are {LONGEST}"
            ))),
            Err(Unusable::System(cause)) => return Err(StoreError::Unreadable { path, cause }),
        };
        match read {
            Ok(record) => {
                held.records.insert(id.clone(), record);
            }
            Err(Wrong::Damaged(why)) => held.damaged.push(Damage {
                point: Some(point),
                path,
                why,
            }),
            Err(Wrong::Other(made)) => {
                others += 1;
                first.get_or_insert((path, made));
            }
        }
    }
    match first {
        None => Ok(held),
        Some((first, made)) => Err(StoreError::OtherBuild {
            folder: folder.to_owned(),
            points: others,
            first,
            made,
        }),
    }
}

fn file_of(folder: &Path, id: &str) -> PathBuf {
    folder.join("points").join(format!("{id}.json"))
}

/// Opens a file of the folder for writing, never through a symlink.
fn open_own(path: &Path, options: &mut OpenOptions) -> Kept<File> {
    let path = path.to_owned();
    regular_file::open(&path, options).map_err(|unusable| match unusable {
        Unusable::Kind(found) => StoreError::Kind { path, found },
        Unusable::System(cause) => StoreError::Save { path, cause },
        Unusable::Absent | Unusable::Long(_) => StoreError::Save {
            path,
            cause: io::ErrorKind::NotFound.into(),
        },
    })
}

/// Whether what stands at a path, if anything does, is of a kind.
fn check_kind(path: &Path, want: &'static str) -> Kept<()> {
    let path = path.to_owned();
    match regular_file::kind(&path) {
        Ok(None) => Ok(()),
        Ok(Some(found)) if found == want => Ok(()),
        Ok(Some(found)) => Err(StoreError::Kind { path, found }),
        Err(cause) => Err(StoreError::Unreadable { path, cause }),
    }
}

/// Whether files are files and folders folders, before anything is written.
fn check_kinds(folder: &Path) -> Kept<()> {
    if !folder.is_dir() {
        return Ok(());
    }
    check_kind(&manifest::file(folder), FILE)?;
    for name in FILES {
        check_kind(&folder.join(name), FILE)?;
    }
    for name in FOLDERS {
        check_kind(&folder.join(name), FOLDER)?;
    }
    Ok(())
}

/// Names in a folder, one at a time: there may be any number of them.
fn names(folder: &Path) -> Kept<impl Iterator<Item = Kept<OsString>>> {
    let cannot = |cause| StoreError::Unreadable {
        path: folder.to_owned(),
        cause,
    };
    let entries = fs::read_dir(folder).map_err(cannot)?;
    Ok(entries.map(move |entry| Ok(entry.map_err(cannot)?.file_name())))
}

/// What is in a folder without `sweep.json` that no sweep writes; nothing in one that was killed
/// right away, or whose `sweep.json` was damaged and deleted. Beside a sweep's lock, ledger and
/// points its user may keep files, such as charts.
fn foreign(folder: &Path) -> Kept<Option<PathBuf>> {
    let points = folder.join("points");
    if points.exists() {
        let is_point = |name: &OsStr| {
            let id = name.to_str().and_then(|name| name.strip_suffix(".json"));
            id.is_some_and(is_identity)
        };
        if let Some(found) = first_but(&points, is_point)? {
            return Ok(Some(found));
        }
        let own = ["lock", "ledger.txt"];
        if own.iter().all(|name| folder.join(name).exists()) {
            return Ok(None);
        }
    }
    first_but(folder, |name| {
        let mut known = FILES.iter().chain(&FOLDERS);
        known.any(|known| name == *known)
    })
}

/// The first file of a folder, by name, that is neither known, hidden nor half-written: systems put
/// hidden files of their own beside, such as `.DS_Store`.
fn first_but(folder: &Path, known: impl Fn(&OsStr) -> bool) -> Kept<Option<PathBuf>> {
    let mut first: Option<OsString> = None;
    for name in names(folder)? {
        let name = name?;
        let is_first = first.as_ref().is_none_or(|first| name < *first);
        let hidden = name.as_encoded_bytes().starts_with(b".");
        if is_first && !known(&name) && !hidden {
            first = Some(name);
        }
    }
    Ok(first.map(|name| folder.join(name)))
}
