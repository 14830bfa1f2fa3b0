//! Macros: short sequences of primitives, as text.
//!
//! ```text
//! /// y := x0 - x1
//! macro sub(out y: areg, x0: source, x1: source)
//!     distinct y, x1 "the second store would read the register that it writes"
//! {
//!     bus(NEWS, x0);
//!     bus(y, NEWS, x1);
//! }
//! ```
//!
//! What a macro destroys is not written down: it is what its body writes and its heading does
//! not give as a result.

mod calls;
mod check;
mod definition;
mod parse;
mod possible;
mod reach;
mod roles;
mod scratch;

pub use self::{
    check::{check, check_calls, lacks, without_defaults},
    definition::{Distinct, Item, Macro},
    parse::parse,
};
