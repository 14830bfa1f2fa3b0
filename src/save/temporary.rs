//! Files that have no name of their own yet, and the list of them.

use std::{
    fs::{self, File, OpenOptions},
    io,
    path::{Path, PathBuf},
    sync::{
        Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
};

use super::folder;

/// What their names begin and end with; between are the process and a number.
pub(super) const PREFIX: &str = ".amacrine-";
pub(super) const SUFFIX: &str = ".tmp";

/// Of those that are not locked, which nobody sweeps up.
const SPOOL: &str = ".amacrine-spool-";

/// What this process would leave behind if it ended now.
static ALL: Mutex<Vec<Entry>> = Mutex::new(Vec::new());

struct Entry {
    path: PathBuf,
    /// Folders that were made for it, the outermost first.
    made: Vec<PathBuf>,
}

fn all() -> MutexGuard<'static, Vec<Entry>> {
    ALL.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes every temporary of this process, and lets none be made any more: whoever tries waits
/// for ever. For a process that is about to end.
pub fn remove_all() {
    let list = all();
    for Entry { path, .. } in &*list {
        let _ = fs::remove_file(path);
    }
    // A folder may have held several of them.
    for Entry { made, .. } in &*list {
        folder::unmake(made);
    }
    std::mem::forget(list);
}

/// A file that goes when this does, unless it is [kept](Self::keep).
#[derive(Debug)]
pub(super) struct Temporary {
    path: PathBuf,
    kept: bool,
}

impl Temporary {
    /// A new, empty file in the folder where `target` is to be, which is made if it is missing.
    pub(super) fn beside(target: &Path) -> io::Result<(Self, File)> {
        let folder = match target.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let made = folder::make(folder)?;
        Self::inside(made, || create(folder, PREFIX, 0o666))
    }

    /// A new, empty file in the system's folder for such, for nobody else to read; its writer
    /// may lock it.
    pub(super) fn elsewhere() -> io::Result<(Self, File)> {
        Self::inside(Vec::new(), || {
            let (path, file) = create(&std::env::temp_dir(), SPOOL, 0o600)?;
            let _ = file.unlock();
            Ok((path, file))
        })
    }

    fn inside(
        made: Vec<PathBuf>,
        create: impl FnOnce() -> io::Result<(PathBuf, File)>,
    ) -> io::Result<(Self, File)> {
        // Held while the file is made: nobody is to end between that and its entry.
        let mut list = all();
        match create() {
            Ok((path, file)) => {
                list.push(Entry {
                    path: path.clone(),
                    made,
                });
                Ok((Self { path, kept: false }, file))
            }
            Err(cause) => {
                folder::unmake(&made);
                Err(cause)
            }
        }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Gives the file its name. Returns the folders that were made for it.
    pub(super) fn keep(mut self, target: &Path) -> io::Result<Vec<PathBuf>> {
        fs::rename(&self.path, target)?;
        self.kept = true;
        Ok(self.forget())
    }

    fn forget(&self) -> Vec<PathBuf> {
        let mut list = all();
        let at = list.iter().position(|entry| entry.path == self.path);
        at.map_or(Vec::new(), |at| list.swap_remove(at).made)
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.kept {
            let _ = fs::remove_file(&self.path);
            folder::unmake(&self.forget());
        }
    }
}

/// A file that was not there, locked as long as it is open: so others can tell that it is in use.
fn create(folder: &Path, prefix: &str, mode: u32) -> io::Result<(PathBuf, File)> {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    let process = std::process::id();
    for _ in 0..1000 {
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let path = folder.join(format!("{prefix}{process}-{number}{SUFFIX}"));
        let mut options = OpenOptions::new();
        options.read(true).write(true).create_new(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, mode);
        #[cfg(not(unix))]
        let _ = mode;
        let file = match options.open(&path) {
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => continue,
            file => file?,
        };
        // Where there are no locks nobody sweeps up either.
        let _ = file.try_lock();
        if is_there(&file) {
            return Ok((path, file));
        }
        // Swept up between its making and its lock.
    }
    Err(io::ErrorKind::AlreadyExists.into())
}

#[cfg(unix)]
fn is_there(file: &File) -> bool {
    use std::os::unix::fs::MetadataExt;
    file.metadata().is_ok_and(|found| found.nlink() > 0)
}

#[cfg(not(unix))]
fn is_there(_: &File) -> bool {
    true
}
