//! A file that is being written: under a temporary name, renamed at the end.

use std::{
    fs::{self, File, Metadata},
    io::{self, BufWriter, Seek, SeekFrom, Write},
    path::{Path, PathBuf},
    sync::atomic::{AtomicBool, Ordering},
};

use super::{
    SaveError,
    destination::{self, Destination},
    folder,
    temporary::Temporary,
};

/// Whether a reader of something that is written through has gone.
static GONE: AtomicBool = AtomicBool::new(false);

/// Whether something was written through, to a reader that had gone: then whoever asked for it
/// does not want more.
#[must_use]
pub fn reader_is_gone() -> bool {
    GONE.load(Ordering::Relaxed)
}

/// A file that appears at its path when it is [kept](Self::keep), and not before.
///
/// For writers that live longer than one closure; [`save`](super::save) is simpler.
#[derive(Debug)]
pub struct AtomicFile {
    path: PathBuf,
    file: BufWriter<File>,
    end: End,
}

/// What is left to do with what was written.
#[derive(Debug)]
enum End {
    /// It takes the place of what is there.
    Rename {
        temporary: Temporary,
        target: PathBuf,
        old: Option<Box<Metadata>>,
    },
    /// It is copied to where nobody can go back.
    Copy(File),
    /// It has gone through already.
    Nothing,
}

impl AtomicFile {
    /// An empty file that will be at `path`. Where that is no file, all of it waits in a
    /// temporary file, so that the writer can seek.
    ///
    /// # Errors
    /// When no file can be made in that folder.
    pub fn create(path: &Path) -> Result<Self, SaveError> {
        Self::new(path, true).map_err(SaveError::at(path))
    }

    /// As [`AtomicFile::create`], for writers that do not seek: a device or a FIFO gets each part as
    /// it comes.
    ///
    /// # Errors
    /// As [`AtomicFile::create`].
    pub fn stream(path: &Path) -> Result<Self, SaveError> {
        Self::new(path, false).map_err(SaveError::at(path))
    }

    fn new(path: &Path, seeks: bool) -> io::Result<Self> {
        let (file, end) = match Destination::from_path(path)? {
            Destination::File { target, old } => {
                let (temporary, file) = Temporary::beside(&target)?;
                let end = End::Rename {
                    temporary,
                    target,
                    old: old.map(Box::new),
                };
                (file, end)
            }
            node if seeks => (tempfile::tempfile()?, End::Copy(destination::open(&node)?)),
            node => (destination::open(&node)?, End::Nothing),
        };
        Ok(Self {
            path: path.to_owned(),
            file: BufWriter::with_capacity(1 << 16, file),
            end,
        })
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// When the disk does not take it; whatever was at the path is then as it was.
    pub fn keep(self) -> Result<(), SaveError> {
        self.finish(false)
    }

    /// Gives the file its name, and waits until the disk has both.
    ///
    /// # Errors
    /// As [`AtomicFile::keep`]; when only the last step fails, the file is in place and may not
    /// outlive the machine.
    pub fn keep_durably(self) -> Result<(), SaveError> {
        self.finish(true)
    }

    fn finish(self, durably: bool) -> Result<(), SaveError> {
        let Self { path, file, end } = self;
        let hears = end.hears();
        let finish = || -> io::Result<()> {
            let mut file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
            match end {
                End::Rename {
                    temporary,
                    target,
                    old,
                } => {
                    if let Some(old) = &old {
                        take_after(&file, old)?;
                    }
                    if durably {
                        folder::sync(&file)?;
                    }
                    let made = temporary.keep(&target)?;
                    if durably {
                        folder::sync_name(&target)?;
                        folder::sync_names(&made)?;
                    }
                }
                End::Copy(mut node) => {
                    file.seek(SeekFrom::Start(0))?;
                    io::copy(&mut file, &mut node)?;
                }
                End::Nothing => {}
            }
            Ok(())
        };
        finish().map_err(hears).map_err(SaveError::at(&path))
    }

    /// The file.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Whether what is written is no file that is replaced.
    pub(super) const fn is_written_through(&self) -> bool {
        self.end.is_written_through()
    }

    /// An error of the system, with the name of this file.
    #[must_use]
    pub fn failed(&self, cause: io::Error) -> SaveError {
        SaveError::at(&self.path)(cause)
    }
}

impl End {
    const fn is_written_through(&self) -> bool {
        !matches!(self, Self::Rename { .. })
    }

    /// Notes that a reader has gone. A file has none.
    const fn hears(&self) -> impl Fn(io::Error) -> io::Error + use<> {
        let through = self.is_written_through();
        move |cause| {
            if through && cause.kind() == io::ErrorKind::BrokenPipe {
                GONE.store(true, Ordering::Relaxed);
            }
            cause
        }
    }
}

/// A file that takes the place of another has its mode and, where that is allowed, its owner.
#[cfg(unix)]
fn take_after(file: &File, old: &Metadata) -> io::Result<()> {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, fchown};
    let new = file.metadata()?;
    if (new.uid(), new.gid()) != (old.uid(), old.gid()) {
        let _ = fchown(file, Some(old.uid()), Some(old.gid()));
    }
    // Who may run it as whom was said of other content.
    let mode = old.mode() & 0o777;
    if new.mode() & 0o7777 != mode {
        file.set_permissions(fs::Permissions::from_mode(mode))?;
    }
    Ok(())
}

#[cfg(not(unix))]
fn take_after(file: &File, old: &Metadata) -> io::Result<()> {
    let permissions: fs::Permissions = old.permissions();
    file.set_permissions(permissions)
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes);
        written.map_err(self.end.hears())
    }

    fn flush(&mut self) -> io::Result<()> {
        let flushed = self.file.flush();
        flushed.map_err(self.end.hears())
    }
}

impl Seek for AtomicFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        // Standard output may be a file in which more than this is.
        if matches!(self.end, End::Nothing) {
            return Err(io::ErrorKind::NotSeekable.into());
        }
        self.file.seek(to)
    }
}
