//! What no tensor can be made of.

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

/// A time that windows can have.
pub(super) fn time(what: &'static str, seconds: f64) -> Result<f64, TensorError> {
    if (1e-6..=1e9).contains(&seconds) {
        return Ok(seconds);
    }
    Err(TensorError::Time { what, seconds })
}
