//! Code generation: from plans to the words of a chip.
//!
//! - [`register_allocation`]: a register for each value.
//! - [`instruction_set`]: which words a chip has.
//! - [`filter`]: what comes out, the words and their properties; [`bus_word`]: its words as the cells
//!   that they store and read.

pub(super) mod bus_word;
pub(super) mod filter;
pub(super) mod instruction_set;
pub(super) mod register_allocation;
