//! The kernels that a verb is given, by file or by name.

use std::fmt;

use crate::cli::{complain, input::kernels::Kinds, output::files::Named};

/// Which kernels, by file or by name.
#[derive(Clone, Debug, clap::Args)]
pub struct KernelNames {
    /// Kernels, one for each kind of cell: files, names of built-in ones, or sensor files
    ///
    /// Files are .toml, or .npy of shape (k,k), (K,k,k) or (K,1,k,k). A sensor file has thresholds,
    /// too.
    #[arg(
        required_unless_present = "by_option",
        conflicts_with = "by_option",
        value_delimiter = ',',
        value_name = "KERNELS"
    )]
    kernels: Vec<Named>,
    /// The same, as `run` has it
    #[arg(
        long = "kernel",
        hide = true,
        value_delimiter = ',',
        value_name = "KERNELS"
    )]
    by_option: Vec<Named>,
}

impl KernelNames {
    fn names(&self) -> &[Named] {
        if self.kernels.is_empty() {
            &self.by_option
        } else {
            &self.kernels
        }
    }

    /// Reads them, and tells in what programs cannot follow a sensor that they stand in.
    ///
    /// # Errors
    /// As [`Kinds::of_all`].
    pub(in crate::cli) fn kinds(&self) -> miette::Result<Kinds> {
        let kinds = Kinds::of_all(self.names())?;
        for note in &kinds.notes {
            complain(&format!("note: {note}\n"));
        }
        Ok(kinds)
    }
}

/// As they were given, with commas between.
impl fmt::Display for KernelNames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.names().iter().map(|name| &**name).collect();
        f.write_str(&names.join(","))
    }
}
