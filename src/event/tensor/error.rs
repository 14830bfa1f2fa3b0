//! What no tensor can be made of.

use crate::{
    event::Outside,
    memory::{Budget, Bytes},
};

/// The most bins of a window.
pub const MOST_BINS: usize = 1000;

/// Why there are no voxels, surfaces or frames of this kind.
#[derive(Clone, Debug, PartialEq, thiserror::Error, miette::Diagnostic)]
pub enum TensorError {
    /// A number of bins that is none.
    #[error("{bins} bins in a window")]
    #[diagnostic(help("give 1 to {}", MOST_BINS))]
    Bins {
        /// How many.
        bins: usize,
    },
    /// A length that is none.
    #[error("{what} is {seconds} s")]
    #[diagnostic(help("give a time of at least 1 us and at most 10^9 s"))]
    Time {
        /// What it is the length of.
        what: &'static str,
        /// Its length.
        seconds: f64,
    },
    /// An event that its own packet has no cell for.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Outside(#[from] Outside),
    /// More values than this machine's memory holds.
    #[error("{parts} {what} take {}, more than the {} that may be held here", Bytes(*bytes), Bytes((*most).into()))]
    #[diagnostic(help(
        "take fewer of them, or a part of the events; recordings with times of the day begin with years of nothing: begin the windows at the first event"
    ))]
    Room {
        /// How many parts.
        parts: u64,
        /// What they are.
        what: &'static str,
        /// Bytes of all of them.
        bytes: u128,
        /// Bytes that may be held.
        most: u64,
    },
    /// A name that is none.
    #[error("`{text}` is no {what}")]
    #[diagnostic(help("give one of {known}"))]
    Name {
        /// What was given.
        text: String,
        /// What it was to name.
        what: &'static str,
        /// The names.
        known: String,
    },
}

/// What has a name, of a list of these.
pub(super) fn named<T: Copy>(
    all: &[(&'static str, T)],
    what: &'static str,
    text: &str,
) -> Result<T, TensorError> {
    let found = all.iter().find(|(name, _)| *name == text);
    found.map(|(_, it)| *it).ok_or_else(|| {
        let names: Vec<_> = all.iter().map(|(name, _)| *name).collect();
        TensorError::Name {
            text: text.to_owned(),
            what,
            known: names.join(", "),
        }
    })
}

/// How many values so many parts of `each` have, of four bytes, where this machine holds them.
pub(super) fn room(parts: u64, what: &'static str, each: usize) -> Result<usize, TensorError> {
    let values = u128::from(parts) * each as u128;
    check_room(parts, what, values.saturating_mul(4))?;
    Ok(values as usize)
}

/// Refuses so many bytes for so many parts where this machine does not hold them.
pub(super) fn check_room(parts: u64, what: &'static str, bytes: u128) -> Result<(), TensorError> {
    // What is as small as this is never asked for.
    if bytes > SMALL {
        let most = Budget::from_machine().bytes;
        if bytes > u128::from(most) {
            return Err(TensorError::Room {
                parts,
                what,
                bytes,
                most,
            });
        }
    }
    Ok(())
}

/// Bytes that every machine has.
const SMALL: u128 = 64 << 20;

/// A time that windows can have.
pub(super) fn time(what: &'static str, seconds: f64) -> Result<f64, TensorError> {
    if (1e-6..=1e9).contains(&seconds) {
        return Ok(seconds);
    }
    Err(TensorError::Time { what, seconds })
}
