//! `amacrine list`: what comes with the program, by name, and the text of each.

use std::path::Path;

use clap::ValueEnum as _;
use miette::miette;

use crate::{
    bundled::{self, File, Kind},
    isa::Device,
    scene::{
        self,
        pattern::{PATTERNS, told},
    },
};

/// What `list` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  amacrine list sensors\n  amacrine list sensors rgc-4 > mine.toml\n  amacrine list patterns bar\n  amacrine run --scene bundled --sensor rgc-4\n\nA name can stand wherever a file of that kind is read; a file of that name is taken first."
)]
pub struct Arguments {
    /// Kind to list
    of: Of,
    /// Name of one of them, to print its text
    name: Option<String>,
}

/// A kind of thing that comes with the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Of {
    /// Float sensors: `run --sensor NAME`
    Sensors,
    /// Programs of the array: `exec NAME`
    Programs,
    /// Kernels: `compile NAME`
    Kernels,
    /// Studies: `sweep NAME`
    Studies,
    /// Readouts: `run --readout NAME`
    Readouts,
    /// Chips: `exec PROGRAM --chip NAME`
    Chips,
    /// Scenes that are drawn, with their parameters: `run --scene pattern:NAME`
    Patterns,
}

impl Of {
    /// The files; chips are folders, and patterns are none.
    const fn kind(self) -> Option<Kind> {
        match self {
            Self::Sensors => Some(Kind::Sensor),
            Self::Programs => Some(Kind::Program),
            Self::Kernels => Some(Kind::Kernel),
            Self::Studies => Some(Kind::Study),
            Self::Readouts => Some(Kind::Readout),
            Self::Chips | Self::Patterns => None,
        }
    }
}

impl Of {
    /// The names of all.
    fn names(self) -> Vec<&'static str> {
        match (self, self.kind()) {
            (_, Some(kind)) => bundled::all(kind).map(|file| file.name).collect(),
            (Self::Patterns, None) => PATTERNS.iter().map(|(name, _)| *name).collect(),
            (_, None) => Device::shipped().collect(),
        }
    }

    /// The text of one; of chips, which are folders, that of its numbers.
    fn text(self, name: &str) -> miette::Result<String> {
        match (self, self.kind()) {
            (_, Some(kind)) => { bundled::find(kind, name) }
                .map(|file| file.text.to_owned())
                .ok_or_else(|| nothing(kind, name)),
            (Self::Patterns, None) => Ok(told::one(name)?),
            (_, None) => { Device::shipped_text(name) }
                .map(str::to_owned)
                .ok_or_else(|| no_chip(name)),
        }
    }

    /// The word for one of them.
    fn one(self, plural: &str) -> Option<&str> {
        match self {
            Self::Studies => Some("study"),
            _ => plural.strip_suffix('s'),
        }
    }
}

/// What comes with the program under the name that stands for a file; one that is there goes first,
/// and a folder is none.
pub(super) fn bundled(kind: Kind, path: &Path) -> Option<File> {
    let name = path.to_str().filter(|_| !path.exists() || path.is_dir())?;
    bundled::find(kind, name)
}

/// What to give instead of a path that is not there: how what has this name is given, where it is of
/// another kind; else a name that is near, if any; and `otherwise`.
pub(super) fn meant(kind: Kind, path: &Path, otherwise: &str) -> String {
    let Some(name) = path.to_str().filter(|_| !path.exists()) else {
        return otherwise.to_owned();
    };
    match of_another_kind(name) {
        Some(other) => format!("{other}; here {otherwise}"),
        None => bundled::meant(kind, name, otherwise),
    }
}

/// What comes with the program under this name, and how it is given.
pub(super) fn of_another_kind(name: &str) -> Option<String> {
    let kind = kind_with(name)?;
    let how = match &*kind {
        "sensor" => format!("given as --sensor {name}"),
        "program" => format!("run by `amacrine exec {name}`"),
        "kernel" => {
            format!("given as --kernel {name} beside a sensor, or to `amacrine compile {name}`")
        }
        "study" => format!("computed by `amacrine sweep {name}`"),
        "readout" => format!("given as --readout {name}"),
        "pattern" => format!("given as --scene pattern:{name}"),
        _ => format!("given as --chip {name}"),
    };
    Some(format!("{name} is a {kind}, {how}"))
}

/// Nothing of this kind has this name.
pub(super) fn nothing(kind: Kind, name: &str) -> miette::Report {
    let known: Vec<&str> = bundled::all(kind).map(|file| file.name).collect();
    let known = format!("there are {}", known.join(", "));
    miette!(
        help = bundled::meant(kind, name, &known),
        "there is no {name} in {}",
        kind.folder()
    )
}

/// No chip that comes with the program has this name.
pub(super) fn no_chip(name: &str) -> miette::Report {
    let known: Vec<&str> = Device::shipped().collect();
    let known = format!("there are {}", known.join(", "));
    // A chip of one's own lies where its folder does.
    let is_own = Path::new(name).join("device.toml").is_file();
    let help = if is_own {
        format!(
            "{name} is a folder here, and its numbers are in {name}/device.toml: verbs take it as --chip {name}; of those that come with the program, {known}"
        )
    } else {
        known
    };
    miette!(help = help, "there is no {name} in isa")
}

/// Runs the verb.
///
/// # Errors
/// When there is nothing of this name.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let of = arguments.of;
    let text = match &arguments.name {
        Some(name) => of.text(name)?,
        None if of == Of::Patterns => told::all(),
        None => of.names().join("\n") + "\n",
    };
    super::say(&text);
    Ok(())
}

/// The kind of thing that this word, singular or plural, stands for, and its plural.
fn kind_of(word: &str) -> Option<(Of, String)> {
    Of::value_variants().iter().find_map(|of| {
        let plural = of.to_possible_value()?.get_name().to_owned();
        let is_meant = word == plural || Some(word) == of.one(&plural);
        is_meant.then_some((*of, plural))
    })
}

/// The kind, in the singular, of what comes with the program under this name; files go first.
pub(super) fn kind_with(name: &str) -> Option<String> {
    if Path::new(name).exists() {
        return None;
    }
    Of::value_variants().iter().find_map(|of| {
        let plural = of.to_possible_value()?.get_name().to_owned();
        let is_there = match of.kind() {
            Some(kind) => bundled::find(kind, name).is_some(),
            None => of.names().contains(&name),
        };
        let one = of.one(&plural)?.to_owned();
        is_there.then_some(one)
    })
}

/// Refuses a kind of thing of which no name was given, where an event file is wanted; a file of
/// that name goes first.
pub(super) fn check_no_kind(word: &str) -> miette::Result<()> {
    if SCENES.contains(&word) && !Path::new(word).exists() {
        return Err(miette!(
            help = "give bundled, or pattern:NAME",
            "show {word}: which one is not said"
        ));
    }
    match kind_of(word).filter(|_| !Path::new(word).exists()) {
        Some((_, plural)) => Err(miette!(
            help = format!("give a name that `amacrine list {plural}` prints"),
            "show {word}: which one is not said"
        )),
        None => Ok(()),
    }
}

/// The words for a scene: none is a file, so that `list` has no kind for them.
const SCENES: [&str; 2] = ["scene", "scenes"];

/// What is known of a scene by name.
fn scene(name: &str) -> miette::Result<String> {
    if let Some(pattern) = name.strip_prefix("pattern:") {
        return Ok(told::one(pattern)?);
    }
    if name != "bundled" {
        return Err(miette!(
            help = "there are bundled and, drawn, pattern:NAME (`amacrine list patterns`)",
            "no scene that comes with the program is called {name}"
        ));
    }
    let outline = scene::bundled()?.outline();
    let (size, fps, coding) = (outline.size, outline.fps, outline.coding);
    let (frames, seconds) = match outline.frames {
        Some(frames) => (
            format!("{frames} of "),
            format!(", {} s", frames as f64 / fps),
        ),
        None => (String::new(), String::new()),
    };
    Ok(format!(
        "bundled: people walking past a still camera, gray\n\n\
         frames   {frames}{size} at {fps} frames/s{seconds}\n\
         light    {coding}\n\
         source   a crop of vtest.avi, of OpenCV's examples (Apache-2.0 and BSD-3-Clause)\n\
         given    as --scene bundled\n"
    ))
}

/// `amacrine show sensor NAME`: as `list sensors NAME`; `show scene NAME` too.
///
/// # Errors
/// When there is no such kind of thing, or nothing of this name.
pub(super) fn show(of: &str, name: &str) -> miette::Result<()> {
    if SCENES.contains(&of) {
        super::say(&scene(name)?);
        return Ok(());
    }
    match kind_of(of) {
        Some((found, _)) => {
            super::say(&found.text(name)?);
            Ok(())
        }
        None => Err(miette!(
            help = "give sensor, program, kernel, study, readout, chip, pattern or scene before the name; or one event file, and -o PICTURE",
            "{of} {name}: {of} is no kind of thing that comes with the program"
        )),
    }
}
