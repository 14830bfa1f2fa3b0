//! Programs of the array: text in, instruction words out.
//!
//! ```
//! use amacrine::{isa::Device, program::{Cost, Program}};
//!
//! let program = Program::parse("copy.scamp", "mov(A, B); // through NEWS")?;
//! let expansion = program.expand(&Device::scamp5(), &Default::default())?;
//! assert_eq!(Cost::of(&expansion.code.frame, &Device::scamp5()).words.0, 2);
//! # Ok::<(), amacrine::config::Faults>(())
//! ```

mod check;
mod code;
mod cost;
mod effect;
mod expand;
mod exposure;
mod host;
mod host_calls;
mod operation;
mod parse;
mod print;
pub mod readout;
mod reference;
mod sample;
mod settings;
mod source;
pub mod syntax;
mod vendor;
mod words;

pub use code::{Action, Code, Step};
pub use cost::{Cost, array_us, host_us, stored};
pub use effect::{CellEffect, FlagState};
pub use expand::{Entry, Expanded, Expansion, Overrides, Stored, for_each};
pub use exposure::Exposure;
pub use host::buffer;
pub use host_calls::{HostCalls, HostTimes};
pub use operation::{Area, Host, Pattern, Shape, SumOver, Window};
pub use reference::reference;
pub use sample::{Sample, samples};
pub use settings::{
    Computes, Expectation, ExpectedEvents, ExpectedWords, Settings, Summary, json_schema,
};
pub use source::{NamesError, Program, Runnable};
pub use syntax::Syntax;
pub use vendor::{
    Answer, Beside, Includes, Lying, WriteError, cpp, included, included_files, is_cpp,
};
pub use words::vendor_text;
