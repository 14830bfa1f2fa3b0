//! `amacrine new`: a file to start from, with what else may stand in it.

use std::{
    io,
    path::{Path, PathBuf},
};

use clap::ValueEnum;
use miette::miette;

use super::{
    list::{no_chip, nothing},
    output::files,
    schema,
};
use crate::{
    bundled::{self, Kind},
    config::{self, Faults},
    isa::Device,
    reference::Description,
    save::save,
    study::sweep::Study,
};

/// What `new` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  amacrine new sensor mine\n  amacrine new program edges --from convolve/sobel\n  amacrine new chip wide\n\nA sensor, kernel, study or readout is NAME.toml. A copy of its JSON Schema stands beside it, with which editors complete and check it; optional keys are in comments. A program is NAME.scamp. A chip is a folder whose device.toml says only where it differs from another; it has its schema in it."
)]
pub struct Arguments {
    /// Kind of file
    kind: schema::Kind,
    /// Path of the file, without its ending
    name: String,
    /// Name in `amacrine list` to start from; a chip extends it [default: a plain one]
    #[arg(long, value_name = "NAME")]
    from: Option<String>,
}

/// A chip that differs from another in a few numbers.
const CHIP: &str = include_str!("../../isa/scamp5-wide/device.toml");

/// Of each kind, the one that is copied where none is asked for.
const fn plain(kind: Kind) -> &'static str {
    match kind {
        Kind::Sensor => "rgc",
        Kind::Program => "dvs/snap",
        Kind::Kernel => "rgc-5x5",
        Kind::Study => "formats",
        Kind::Readout => "arbiter",
    }
}

/// Runs the verb.
///
/// # Errors
/// When there is nothing of the name to begin with, when a file of the new name is there already,
/// or cannot be written.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let name = Path::new(&arguments.name);
    if name.file_name().is_none() || arguments.name.ends_with('/') {
        return Err(miette!(
            help = "give the path of what is to be begun, without the ending, such as `mine`",
            "`{}` is no name of a file",
            arguments.name
        ));
    }
    let written = match arguments.kind.bundled() {
        None => {
            let own = name.file_name().unwrap_or_default();
            if Device::shipped().any(|chip| own == chip) {
                return Err(miette!(
                    help = "give it a name of its own: chips extend each other by name",
                    "`{}` is a shipped chip",
                    own.display()
                ));
            }
            let text = match &arguments.from {
                Some(from) if Device::shipped().all(|chip| chip != from.as_str()) => {
                    return Err(no_chip(from));
                }
                Some(from) => extending(from),
                None => CHIP.to_owned(),
            };
            let text = titled(&text, "name", name);
            let schema = schema::schema_for(arguments.kind);
            with_schema(arguments.kind, &schema, name.join("device.toml"), &text)
        }
        Some(kind) => begun(kind, arguments, name)?,
    };
    let first = written.first().map(|(path, _)| path);
    if let Some(path) = first.filter(|path| path.exists()) {
        return Err(miette!(
            help = "give another name; nothing was written",
            "{} is there already",
            path.display()
        ));
    }
    files::writes(written.iter().map(|(path, _)| path))?;
    // All of it first: who reads the lines may have gone.
    for (path, text) in &written {
        save(path, |file| file.write_all(text.as_bytes()))?;
    }
    for (path, _) in &written {
        super::say(&format!("wrote    {}\n", path.display()));
    }
    Ok(())
}

/// A chip that is as another until it says something else.
fn extending(chip: &str) -> String {
    format!(
        "# What is not stated here is as on {chip}.

name = \"{chip}\"
title = \"what if {chip} were another\"
extends = \"{chip}\"

# What differs, for example:
# [registers] # of fewer, macros that need another are left out
# analogue = [\"A\", \"B\", \"C\", \"D\", \"NEWS\"]
#
# [figure.array]
# height = {{ value = 512, unit = \"px\", source = \"what if\", evidence = \"guess\" }}
# width = {{ value = 512, unit = \"px\", source = \"what if\", evidence = \"guess\" }}
"
    )
}

/// The file, and its schema where editors know what to do with one.
fn begun(kind: Kind, arguments: &Arguments, name: &Path) -> miette::Result<Vec<(PathBuf, String)>> {
    let from = arguments.from.as_deref().unwrap_or(plain(kind));
    let file = bundled::find(kind, from).ok_or_else(|| nothing(kind, from))?;
    let path = named(name, kind.extension());
    if kind == Kind::Program {
        return Ok(vec![(path, file.text.to_owned())]);
    }
    let schema = schema::schema_for(arguments.kind);
    let title = if kind == Kind::Study { "title" } else { "name" };
    let text = config::with_keys(file.text, &schema);
    let text = config::that_hold(&text, &|text| read(kind, text));
    let text = titled(&text, title, &path);
    Ok(with_schema(arguments.kind, &schema, path, &text))
}

/// A file that names its schema in its first line, and the schema beside it.
fn with_schema(
    kind: schema::Kind,
    schema: &serde_json::Value,
    path: PathBuf,
    text: &str,
) -> Vec<(PathBuf, String)> {
    // As it was typed.
    let word = kind.to_possible_value();
    let word = word.as_ref().map_or("file", |value| value.get_name());
    let beside = format!("{word}.schema.json");
    let text = format!("#:schema ./{beside}\n{text}");
    let beside = path.with_file_name(beside);
    let mut written = vec![(path, text)];
    // All of a kind have the same: one that is there was written by a version of its own.
    if !beside.exists() {
        written.push((beside, format!("{schema:#}\n")));
    }
    written
}

/// Reads a text that stands beside no other file.
fn read(kind: Kind, text: &str) -> Result<(), Faults> {
    let none = |_: &str| Err(io::ErrorKind::NotFound.into());
    match kind {
        Kind::Sensor => Description::parse("new", text, &none).map(drop),
        Kind::Study => Study::parse("new", text).map(drop),
        Kind::Kernel | Kind::Readout | Kind::Program => Ok(()),
    }
}

/// A text whose first line of this key says what the file or folder is called.
fn titled(text: &str, key: &str, path: &Path) -> String {
    let key = format!("{key} = ");
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let own = toml::Value::from(stem.into_owned());
    let mut is_said = false;
    let lines = text.split_inclusive('\n').map(|line| {
        // Keys behind a table are the table's.
        if is_said || line.starts_with('[') || !line.starts_with(&key) {
            is_said |= line.starts_with('[');
            return line.to_owned();
        }
        is_said = true;
        format!("{key}{own}\n")
    });
    lines.collect()
}

/// A path with an ending, if it has not got it.
fn named(name: &Path, ending: &str) -> PathBuf {
    if name.extension().is_some_and(|own| own == ending) {
        return name.to_owned();
    }
    let mut path = name.as_os_str().to_owned();
    path.push(format!(".{ending}"));
    path.into()
}
