//! Where a path leads: to a file that is replaced, or to something that is written through.

use std::{
    fs::{self, File, Metadata, OpenOptions},
    io,
    path::{Path, PathBuf},
};

/// Standard output, as a path of something that is written.
pub const STDOUT: &str = "/dev/stdout";

/// What is written to when a path is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum OutputKind {
    /// A file, there or not: it is replaced whole.
    File {
        /// Its own name, behind all links.
        target: PathBuf,
    },
    /// A device, a FIFO, a socket or an open descriptor: it is written through.
    Node,
    /// Standard output.
    Stdout,
}

/// What is written when this path is.
///
/// # Errors
/// When it leads to a folder, round in a circle, or nowhere that can be looked at.
pub fn output_kind(path: &Path) -> io::Result<OutputKind> {
    Ok(match Destination::from_path(path)? {
        Destination::File { target, .. } => OutputKind::File { target },
        Destination::Descriptor(1, _) => OutputKind::Stdout,
        Destination::Descriptor(..) | Destination::Node { .. } => OutputKind::Node,
    })
}

/// The most links that are followed one after the other, as Linux has it.
const LINKS: usize = 40;

/// Where a path leads.
#[derive(Debug)]
pub(super) enum Destination {
    /// To this name, behind all links; and what is there now.
    File {
        target: PathBuf,
        old: Option<Metadata>,
    },
    /// To a device, a FIFO or a socket.
    Node {
        path: PathBuf,
        #[cfg_attr(not(unix), expect(dead_code))]
        socket: bool,
    },
    /// To a descriptor that is open already.
    Descriptor(u32, PathBuf),
}

impl Destination {
    pub(super) fn from_path(path: &Path) -> io::Result<Self> {
        let mut at = path.to_owned();
        for _ in 0..LINKS {
            if let Some(number) = descriptor(&at) {
                return Ok(Self::Descriptor(number, at));
            }
            let found = match fs::symlink_metadata(&at) {
                Err(e) if e.kind() == io::ErrorKind::NotFound => {
                    return Ok(Self::File {
                        target: at,
                        old: None,
                    });
                }
                found => found?,
            };
            if found.is_symlink() {
                let to = fs::read_link(&at)?;
                at = at.parent().unwrap_or(Path::new("")).join(to);
            } else if found.is_dir() {
                return Err(io::ErrorKind::IsADirectory.into());
            } else if found.is_file() {
                return Ok(Self::File {
                    target: at,
                    old: Some(found),
                });
            } else {
                return Ok(Self::Node {
                    socket: is_socket(&found),
                    path: at,
                });
            }
        }
        // The system's own words for it.
        let cause = fs::metadata(path).err();
        Err(cause.unwrap_or_else(|| io::Error::other("too many levels of symbolic links")))
    }
}

/// The number of the descriptor that a path names.
fn descriptor(path: &Path) -> Option<u32> {
    match path.to_str() {
        Some(STDOUT) => return Some(1),
        Some("/dev/stderr") => return Some(2),
        _ => {}
    }
    let number = path.file_name()?.to_str()?.parse().ok()?;
    let folder = fs::canonicalize(path.parent()?).ok()?;
    let own = format!("/proc/{}/fd", std::process::id());
    (folder == Path::new(&own) || folder == Path::new("/dev/fd")).then_some(number)
}

#[cfg(unix)]
fn is_socket(found: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    found.file_type().is_socket()
}

#[cfg(not(unix))]
fn is_socket(_: &Metadata) -> bool {
    false
}

/// Opens what is written through.
#[cfg(unix)]
pub(super) fn open(destination: &Destination) -> io::Result<File> {
    use std::os::{
        fd::{AsFd, OwnedFd},
        unix::net::UnixStream,
    };
    // Standard output must not be opened anew: it would have a position of its own.
    let again = |fd: std::os::fd::BorrowedFd<'_>| fd.try_clone_to_owned().map(File::from);
    match destination {
        Destination::Descriptor(0, _) => again(io::stdin().as_fd()),
        Destination::Descriptor(1, _) => again(io::stdout().as_fd()),
        Destination::Descriptor(2, _) => again(io::stderr().as_fd()),
        // What is there already stays, where it is a file.
        Destination::Descriptor(_, path) => OpenOptions::new().append(true).open(path),
        Destination::Node { path, socket: true } => {
            UnixStream::connect(path).map(|stream| File::from(OwnedFd::from(stream)))
        }
        Destination::Node { path, .. } | Destination::File { target: path, .. } => {
            OpenOptions::new().write(true).open(path)
        }
    }
}

#[cfg(windows)]
pub(super) fn open(destination: &Destination) -> io::Result<File> {
    use std::os::windows::io::AsHandle as _;
    match destination {
        Destination::Descriptor(1, _) => io::stdout()
            .as_handle()
            .try_clone_to_owned()
            .map(File::from),
        Destination::Descriptor(_, path)
        | Destination::Node { path, .. }
        | Destination::File { target: path, .. } => OpenOptions::new().write(true).open(path),
    }
}
