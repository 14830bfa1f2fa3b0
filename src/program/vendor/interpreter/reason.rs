//! Why a value is not known.

use std::{fmt, sync::Arc};

/// What a value depends on, in words that stand behind "depends on", without a comma at the end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::program::vendor) enum Reason {
    /// Something that a run knows.
    Run(Arc<str>),
    /// Something of the text that no run makes known: what is not supported, or is not there.
    Never(Arc<str>),
    /// A number that `main` is started with, by its name.
    Started(Arc<str>),
}

impl Reason {
    /// What no run makes known.
    pub(in crate::program::vendor) fn never(says: &str) -> Self {
        Self::Never(says.into())
    }
}

impl From<&str> for Reason {
    fn from(says: &str) -> Self {
        Self::Run(says.into())
    }
}

impl From<String> for Reason {
    fn from(says: String) -> Self {
        Self::Run(says.into())
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Run(says) | Self::Never(says) => f.write_str(says),
            Self::Started(name) => write!(f, "`{name}`"),
        }
    }
}
