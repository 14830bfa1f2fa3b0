//! Whole sensors as programs: capture, filters, thresholds, events, memory, readout.
//!
//! - [`program`]: a sensor whose kinds remember one by one; [`shared_memory`]: one memory for all.
//! - [`cell_kind`]: a kind of cell, and where it remembers; [`bit_memory`]: memories in one-bit
//!   registers.
//! - [`comparison`]: a drive and its two thresholds; [`event_readout`]: how events are read out.
//! - [`register_need`]: what a program needs of a pixel's registers; [`one_bit_registers`]: those of
//!   one bit.

pub(super) mod bit_memory;
pub(super) mod cell_kind;
mod comparison;
pub(super) mod event_readout;
mod one_bit_registers;
pub(super) mod program;
pub(super) mod register_need;
mod shared_memory;
