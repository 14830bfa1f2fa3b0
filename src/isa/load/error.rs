//! Why a chip cannot be read.

use crate::{config::Faults, source::SourceError};

/// Why a chip cannot be read.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum LoadError {
    /// No such chip.
    #[error("there is no chip `{name}`")]
    #[diagnostic(help(
        "{near}give the name of a shipped chip ({shipped}) or a folder that holds a device.toml"
    ))]
    Unknown {
        /// What was asked for.
        name: String,
        /// What there is.
        shipped: String,
        /// Which of them was meant, if one is near: a question.
        near: String,
    },
    /// No such chip, as a program says.
    #[error(
        "{program} is for the chip `{name}`, which is neither shipped nor a folder here or beside the program"
    )]
    #[diagnostic(help(
        "give the chip's folder (--chip PATH), or put it beside the program; shipped are {shipped}"
    ))]
    OfProgram {
        /// What the program asks for.
        name: String,
        /// The program's file.
        program: String,
        /// What there is.
        shipped: String,
    },
    /// A shipped chip, and another in a folder of that name.
    #[error("`{name}` is a shipped chip, and {folder} is another one of that name")]
    #[diagnostic(help(
        "give the folder, and `name` in its device.toml, another name; programs and --chip then name either"
    ))]
    Twice {
        /// What was asked for.
        name: String,
        /// The folder.
        folder: String,
    },
    /// A file cannot be read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Unreadable(#[from] SourceError),
    /// A file says something wrong.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Wrong(#[from] Faults),
}
