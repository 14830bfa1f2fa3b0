//! The language's own library, as far as programs for the chip use it.
//!
//! - [`function`]: its functions by name; [`method`]: those of its objects, vectors and arrays too.
//! - [`algorithm`], [`elementwise`]: `<algorithm>` and `<numeric>`.
//! - [`map`], [`map_entry`]: maps and their elements.
//! - [`string`]: `std::string`; [`c_string`]: texts that end with a 0.
//! - [`memory`]: `memcpy` and its kin, and values that nothing leads to any more.
//! - [`random`]: random numbers of `<random>`.

mod algorithm;
mod c_string;
mod elementwise;
mod function;
mod map;
pub(super) mod map_entry;
mod memory;
mod method;
mod random;
mod string;
