//! Random numbers as the library draws them: a hash of what they are drawn for.

use amacrine::rng::Hash;
use pyo3::prelude::*;

/// A number in [0, 1) for a seed and the words that say what it is drawn for.
#[pyfunction]
pub fn uniform(seed: u64, words: Vec<u64>) -> f64 {
    let hash = words.into_iter().fold(Hash::new(seed), Hash::with);
    hash.uniform()
}
