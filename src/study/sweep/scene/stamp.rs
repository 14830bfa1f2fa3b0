//! Stamps of the files of a scene: whether what is read again is still what was read first.

use std::{
    collections::BTreeMap,
    fs::{self, Metadata},
    path::{Path, PathBuf},
    time::{Duration, UNIX_EPOCH},
};

use crate::scene::{SceneError, image_of_pattern};

/// What tells the files of a scene from others in their places.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Stamp(BTreeMap<PathBuf, Option<File>>);

/// What tells a file from another in its place.
#[derive(Clone, Debug, PartialEq, Eq)]
struct File {
    bytes: u64,
    /// When it was last written, since 1970.
    written: Option<Duration>,
    /// Its device and its number there, where the system tells them.
    number: Option<(u64, u64)>,
}

impl Stamp {
    /// Of a scene under the name that it is opened by; nothing where that is no file. What cannot
    /// be looked at is as if it were not there: opening it says why.
    pub fn of(spec: &str) -> Self {
        let path = match image_of_pattern(spec) {
            Some(image) => image,
            None if spec == "bundled" || spec.starts_with("pattern:") => return Self::default(),
            None => spec,
        };
        let path = PathBuf::from(path);
        let files: Vec<PathBuf> = match fs::read_dir(&path) {
            Ok(entries) => { entries.flatten().map(|entry| entry.path()) }
                .filter(|path| !is_hidden(path))
                .collect(),
            Err(_) => vec![path],
        };
        let stamped = |path: PathBuf| {
            let file = file(&path);
            (path, file)
        };
        Self(files.into_iter().map(stamped).collect())
    }

    /// Refuses a scene whose files are no longer those of the stamp.
    pub fn check(&self, spec: &str) -> Result<(), SceneError> {
        let now = Self::of(spec);
        let mut all = self.0.keys().chain(now.0.keys());
        match all.find(|path| self.0.get(*path) != now.0.get(*path)) {
            None => Ok(()),
            Some(path) => Err(SceneError::Changed { path: path.clone() }),
        }
    }
}

/// A hidden file is no picture of a folder.
fn is_hidden(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default();
    name.as_encoded_bytes().starts_with(b".")
}

fn file(path: &Path) -> Option<File> {
    let data = path.metadata().ok()?;
    let written = data.modified().ok();
    Some(File {
        bytes: data.len(),
        written: written.and_then(|moment| moment.duration_since(UNIX_EPOCH).ok()),
        number: number(&data),
    })
}

#[cfg(unix)]
#[expect(clippy::unnecessary_wraps, reason = "other systems tell none")]
fn number(data: &Metadata) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt as _;
    Some((data.dev(), data.ino()))
}

#[cfg(not(unix))]
const fn number(_: &Metadata) -> Option<(u64, u64)> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changed(stamp: &Stamp, spec: &Path) -> Option<PathBuf> {
        match stamp.check(spec.to_str().unwrap()) {
            Ok(()) => None,
            Err(SceneError::Changed { path }) => Some(path),
            Err(other) => panic!("{other}"),
        }
    }

    #[test]
    fn a_file_that_is_replaced_written_or_gone_is_changed() {
        let folder = tempfile::tempdir().unwrap();
        let (clip, other) = (folder.path().join("clip.npy"), folder.path().join("other"));
        fs::write(&clip, "light").unwrap();
        let stamp = Stamp::of(clip.to_str().unwrap());
        assert_eq!(changed(&stamp, &clip), None);
        fs::write(&clip, "lights").unwrap();
        assert_eq!(changed(&stamp, &clip).as_ref(), Some(&clip));
        let stamp = Stamp::of(clip.to_str().unwrap());
        // As long, and written at the same moment.
        fs::write(&other, "lumens").unwrap();
        let moment = fs::metadata(&clip).unwrap().modified().unwrap();
        let times = fs::FileTimes::new().set_modified(moment);
        let opened = fs::File::options().write(true).open(&other).unwrap();
        opened.set_times(times).unwrap();
        if cfg!(unix) {
            fs::rename(&other, &clip).unwrap();
            assert_eq!(changed(&stamp, &clip).as_ref(), Some(&clip));
        }
        fs::remove_file(&clip).unwrap();
        assert_eq!(changed(&stamp, &clip).as_ref(), Some(&clip));
    }

    #[test]
    fn a_folder_is_its_pictures() {
        let folder = tempfile::tempdir().unwrap();
        let clip = folder.path().join("clip");
        fs::create_dir(&clip).unwrap();
        fs::write(clip.join("0.pgm"), "dark").unwrap();
        fs::write(clip.join("1.pgm"), "light").unwrap();
        let stamp = Stamp::of(clip.to_str().unwrap());
        fs::write(clip.join(".hidden"), "nothing").unwrap();
        assert_eq!(changed(&stamp, &clip), None);
        fs::write(clip.join("2.pgm"), "more").unwrap();
        assert_eq!(changed(&stamp, &clip), Some(clip.join("2.pgm")));
        fs::remove_file(clip.join("2.pgm")).unwrap();
        assert_eq!(changed(&stamp, &clip), None);
        fs::remove_file(clip.join("0.pgm")).unwrap();
        assert_eq!(changed(&stamp, &clip), Some(clip.join("0.pgm")));
    }

    #[test]
    fn a_pattern_is_the_picture_that_it_shows() {
        let folder = tempfile::tempdir().unwrap();
        let picture = folder.path().join("still.pgm");
        fs::write(&picture, "light").unwrap();
        let spec = format!("pattern:pan?frames=9&image={}&speed=3", picture.display());
        let stamp = Stamp::of(&spec);
        assert_eq!(changed(&stamp, Path::new(&spec)), None);
        fs::write(&picture, "lights").unwrap();
        assert_eq!(changed(&stamp, Path::new(&spec)).as_ref(), Some(&picture));
    }

    #[test]
    fn what_is_no_file_does_not_change() {
        for spec in ["bundled", "pattern:disc"] {
            assert_eq!(Stamp::of(spec), Stamp::default());
        }
    }
}
