//! Arrays of numbers as numpy writes them, `.npy`: their headers, the types of their numbers, and
//! whole arrays that fit in memory.
//!
//! Format: numpy's NEP 1, versions 1 to 3,
//! <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>. Scenes are read frame
//! by frame (`scene`), stacks of planes written plane by plane (`save::Stack`), and arrays of events
//! have records (`event::file`): all with the headers and numbers of this room.

mod array;
mod element;
mod header;
mod number;

pub use array::{Array, ArrayError, write};
pub use element::Element;
pub use header::{Header, HeaderError, MAGIC, framed};
pub use number::{Kind, Number, Value};
