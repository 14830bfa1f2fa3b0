//! Atomic writes: all files of the program are written here.
//!
//! A regular file is replaced whole or not at all: it is written under a name of its own in the
//! same folder and renamed at the end, so that an error, a full disk or a kill leaves what was
//! there. A symlink leads to the file that is replaced. A device, a FIFO, a socket or an open
//! descriptor (`/dev/stdout`) is written through, and stays what it is. A folder that is missing
//! is made.
//!
//! [`Together`] is for several files: all of them are written before the first has its name.
//!
//! [`save_durably`] and [`AtomicFile::keep_durably`] also wait until the disk has the file and its
//! name, so that both outlive the machine; the others leave that to the system.

mod atomic_file;
mod destination;
mod error;
mod folder;
mod litter;
mod spool;
mod stack;
mod temporary;
mod together;
mod whole;
mod writable;

pub use atomic_file::{AtomicFile, reader_is_gone};
pub use destination::{OutputKind, STDOUT, output_kind};
pub use error::SaveError;
pub use folder::{make_folder, make_folder_durably, sync};
pub use litter::sweep_up;
pub use spool::Spool;
pub use stack::Stack;
pub use temporary::remove_all;
pub use together::{Together, TogetherError};
pub use whole::{save, save_durably};
pub use writable::{check_folder_writable, check_writable, free_space};
