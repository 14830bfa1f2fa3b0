//! The files that come with the program, compiled in: whoever has no checkout finds sensors,
//! programs, kernels, studies and readouts by name.
//!
//! ```
//! use amacrine::bundled::{self, Kind};
//!
//! let sensor = bundled::find(Kind::Sensor, "rgc-4").unwrap();
//! assert!(sensor.text.contains("memory = "));
//! assert_eq!(bundled::find(Kind::Program, "snap"), bundled::find(Kind::Program, "dvs/snap"));
//! ```

use std::path::Path;

use crate::config::nearest;

/// A kind of file that comes with the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A float sensor, of `sensors/`.
    Sensor,
    /// A program of the array, of `programs/`.
    Program,
    /// A kernel, of `kernels/`.
    Kernel,
    /// A study, of `studies/`.
    Study,
    /// A readout, of `readouts/`.
    Readout,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Sensor,
        Self::Program,
        Self::Kernel,
        Self::Study,
        Self::Readout,
    ];

    /// The folder of such files in the sources.
    #[must_use]
    pub const fn folder(self) -> &'static str {
        match self {
            Self::Sensor => "sensors",
            Self::Program => "programs",
            Self::Kernel => "kernels",
            Self::Study => "studies",
            Self::Readout => "readouts",
        }
    }

    /// What their names end in.
    #[must_use]
    pub const fn extension(self) -> &'static str {
        match self {
            Self::Program => "scamp",
            Self::Sensor | Self::Kernel | Self::Study | Self::Readout => "toml",
        }
    }
}

/// A file that comes with the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct File {
    /// What it is.
    pub kind: Kind,
    /// Its name: its path in the folder of its kind, without the ending.
    pub name: &'static str,
    /// All of it.
    pub text: &'static str,
}

impl File {
    /// Where it lies in the sources, for messages: `sensors/rgc-4.toml`.
    #[must_use]
    pub fn path(&self) -> String {
        let (folder, ending) = (self.kind.folder(), self.kind.extension());
        format!("{folder}/{}.{ending}", self.name)
    }
}

/// Folder, name and text of each.
const FILES: &[(&str, &str, &str)] = include!(concat!(env!("OUT_DIR"), "/bundled.rs"));

/// All files of a kind, by name.
pub fn all(kind: Kind) -> impl Iterator<Item = File> {
    FILES
        .iter()
        .filter(move |(folder, ..)| *folder == kind.folder())
        .map(move |(_, name, text)| File { kind, name, text })
}

/// The file of this kind and name. Without its folder a name will do where only one has it:
/// `snap` is `dvs/snap`. A path as in the sources, `sensors/rgc-4.toml`, is one too.
#[must_use]
pub fn find(kind: Kind, name: &str) -> Option<File> {
    let inside = name
        .strip_prefix(kind.folder())
        .and_then(|it| it.strip_prefix('/'));
    let plain = inside.and_then(|it| it.strip_suffix(kind.extension())?.strip_suffix('.'));
    let name = plain.unwrap_or(name);
    if let Some(file) = all(kind).find(|file| file.name == name) {
        return Some(file);
    }
    let is_last = |file: &File| file.name.rsplit('/').next() == Some(name);
    let mut alike = all(kind).filter(is_last);
    let found = alike.next()?;
    alike.next().is_none().then_some(found)
}

/// The file that was meant, if it is there with its ending, or the name, if one of this kind is
/// near, and what else can be given: for messages about a name that is not there.
#[must_use]
pub fn meant(kind: Kind, name: &str, otherwise: &str) -> String {
    let beside = format!("{name}.{}", kind.extension());
    if Path::new(&beside).is_file() {
        return format!("there is {beside}: give its whole name; else {otherwise}");
    }
    let last = |file: File| file.name.rsplit('/').next().unwrap_or(file.name);
    let near = nearest(name, all(kind).map(|file| file.name));
    // A last part will do where only one file has it.
    let near = near.or_else(|| {
        let near = nearest(name, all(kind).map(last))?;
        find(kind, near).map(|file| file.name)
    });
    match near {
        Some(near) => format!("did you mean `{near}`? {otherwise}"),
        None => otherwise.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_of_the_sources_is_a_name() {
        let found = |name| find(Kind::Program, name).map(|file| file.name);
        assert_eq!(found("programs/dvs/snap.scamp"), Some("dvs/snap"));
        assert_eq!(found("programs/snap.scamp"), Some("dvs/snap"));
        for name in [
            "programs/dvs/snap",
            "sensors/rgc.toml",
            "snap.scamp",
            "programs/",
        ] {
            assert_eq!(found(name), None, "{name}");
        }
    }

    #[test]
    fn every_file_of_the_folders_is_there() {
        for kind in Kind::ALL {
            assert!(all(kind).next().is_some(), "{kind:?}");
            for file in all(kind) {
                let path = concat!(env!("CARGO_MANIFEST_DIR"), "/").to_owned() + &file.path();
                assert_eq!(std::fs::read_to_string(&path).unwrap(), file.text, "{path}");
                assert_eq!(find(kind, file.name), Some(file));
            }
        }
        assert_eq!(all(Kind::Kernel).count(), 18);
    }

    #[test]
    fn a_name_that_two_files_end_in_is_that_of_the_shorter_path() {
        let dvs = find(Kind::Sensor, "dvs").map(|file| file.name);
        assert_eq!(dvs, Some("dvs"));
        let other = find(Kind::Sensor, "authors/dvs").map(|file| file.name);
        assert_eq!(other, Some("authors/dvs"));
        assert_eq!(find(Kind::Program, "nothing"), None);
    }

    #[test]
    fn a_slip_of_the_pen_is_understood() {
        let meant = |kind, name| meant(kind, name, "else");
        assert_eq!(
            meant(Kind::Sensor, "dsv-clean"),
            "did you mean `dvs-clean`? else"
        );
        assert_eq!(
            meant(Kind::Program, "dvs/snp"),
            "did you mean `dvs/snap`? else"
        );
        assert_eq!(
            meant(Kind::Program, "snapp"),
            "did you mean `dvs/snap`? else"
        );
        assert_eq!(meant(Kind::Sensor, "clip.mp4"), "else");
    }
}
