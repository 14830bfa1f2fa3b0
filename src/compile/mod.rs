//! From kernels to instruction words.
//!
//! A filter is found backwards, from the kernels to the input: each step removes the last bus word
//! and replaces the value that it stored by those that it read. Everything that a bus does in one
//! word is a step: up to four sources, neighbours among them, the negation by every store, halving
//! by two targets. So symmetry, separability, running sums and common subexpressions of several
//! kernels are found without being special cases. A `walk` over the kernel is the plan to beat; for
//! dense kernels, which have nothing of that, a `tour` with copies of the input is often
//! shorter, and is tried last.
//!
//! - `request`: what is asked of the compiler; `error`: why there is no program.
//! - `intermediate`: linear forms, and plans before they have registers.
//! - `construction`: plans built forwards: walks, single weights, separable kernels, and tours, which
//!   are searched for.
//! - `search`: beam search, lower bounds, the exhaustive search.
//! - `codegen`: registers, the words of a chip, the filter that comes out.
//! - `silicon`: what constant errors, mismatch and noise do to a result, and plans that lose least.
//! - `decision`: events on silicon, tried on moving light.
//! - `sensor`: whole sensors: memories, thresholds, readout.
//!
//! ```
//! use amacrine::{compile::{Effort, Request}, isa::Device, kernel::Kernel};
//!
//! let device = Device::scamp5();
//! let kernels = [Kernel::builtin("sobel-x").unwrap()];
//! let mut request = Request::new(&kernels, &device)?;
//! request.effort = Effort::states(20_000);
//! let filter = request.filter()?;
//! assert!(filter.words.len() <= 10);
//! # Ok::<(), amacrine::compile::CompileError>(())
//! ```

mod codegen;
mod construction;
mod decision;
mod error;
mod intermediate;
mod request;
mod search;
mod sensor;
mod silicon;

pub use self::{
    codegen::{filter::Filter, instruction_set::check_words},
    construction::naive_cost::naive_cost,
    decision::{
        dead_leaves as leaves,
        f1_score::Decided,
        trial::{Compared, Decision},
    },
    error::{CompileError, four_digits, largest_of_both_signs},
    request::{Border, Effort, Objective, Request},
    search::bound,
    sensor::{
        bit_memory::{BitMemory, Restless},
        cell_kind::{CellKind, DriveMemory, FRAMES},
        event_readout::EventReadout,
        program::{SensorProgram, brightest},
        register_need::{MEMORY_BITS, Need, carried, like_these},
    },
    silicon::{
        forecast::{Forecast, Signal},
        noise::FilterNoise,
    },
};
