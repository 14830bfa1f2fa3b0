//! `amacrine schema`: the keys of a kind of file as JSON Schema, for editors and checkers.

use serde_json::Value as Json;

use super::output::{content::Content, files::Output};
use crate::{
    bundled, config::schema, event::readout, isa, kernel, program, reference, save::save,
    study::sweep,
};

/// What `schema` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  amacrine schema sensor\n  amacrine schema study -o study.schema.json\n\nThe schema describes the file read as JSON (draft 2020-12). Editors that know TOML take it as it is, for example with `#:schema study.schema.json` in the first line of a file. For a program it describes the lines that begin with //!, and $defs/expectation those that begin with //=. For a chip it describes device.toml, and $defs/primitives describes primitives.toml."
)]
pub struct Arguments {
    /// Kind of file
    kind: Kind,
    /// Write the schema to this file, in place of printing it
    #[arg(short, long, value_name = "FILE.json", value_parser = Content::Schema)]
    output: Option<Output>,
}

/// A kind of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Kind {
    /// Float sensor (sensors/*.toml)
    Sensor,
    /// Kernel (kernels/*.toml)
    Kernel,
    /// Study for `sweep` (studies/*.toml)
    Study,
    /// Readout (readouts/*.toml)
    Readout,
    /// Program of the array (programs/**/*.scamp)
    Program,
    /// Chip (isa/*/device.toml and primitives.toml)
    Chip,
}

/// The schema of a kind of file.
pub(super) fn schema_for(kind: Kind) -> Json {
    match kind {
        Kind::Sensor => schema::file(&reference::keys::FILE),
        Kind::Kernel => schema::file(&kernel::FILE),
        Kind::Study => sweep::schema::json_schema(),
        Kind::Readout => schema::file(&readout::settings::FILE),
        Kind::Program => program::json_schema(),
        Kind::Chip => isa::keys::json_schema(),
    }
}

impl Kind {
    /// What comes with the program of this kind; chips are folders.
    pub(super) const fn bundled(self) -> Option<bundled::Kind> {
        match self {
            Self::Sensor => Some(bundled::Kind::Sensor),
            Self::Kernel => Some(bundled::Kind::Kernel),
            Self::Study => Some(bundled::Kind::Study),
            Self::Readout => Some(bundled::Kind::Readout),
            Self::Program => Some(bundled::Kind::Program),
            Self::Chip => None,
        }
    }
}

/// Runs the verb.
///
/// # Errors
/// When the file cannot be written.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let text = format!("{:#}\n", schema_for(arguments.kind));
    let Some(path) = &arguments.output else {
        super::say(&text);
        return Ok(());
    };
    save(path, |file| file.write_all(text.as_bytes()))?;
    super::say(&format!("wrote    {}\n", path.display()));
    Ok(())
}
