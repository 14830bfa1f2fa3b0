//! What verbs read.
//!
//! - [`opened_program`]: programs, with chip and constants; [`kernels`]: kernels by name or file.
//! - [`event_stream`]: the events of a file; [`npy`]: planes in `.npy` files, which are written, too.

pub(super) mod event_stream;
pub(super) mod kernels;
pub(super) mod npy;
pub(super) mod opened_program;
