//! Files that are written through one closure, whole or not at all.

use std::{
    io::{self, Write},
    path::Path,
};

use super::{atomic_file::AtomicFile, error::SaveError};

/// Writes `path` through `fill`, whole or not at all.
///
/// # Errors
/// When the file cannot be created, filled or renamed; whatever was at `path` is then as it was.
pub fn save<F>(path: &Path, fill: F) -> Result<(), SaveError>
where
    F: FnOnce(&mut dyn Write) -> io::Result<()>,
{
    filled(path, fill)?.keep()
}

/// As [`save`]; when it returns, the file and its name are on the disk.
///
/// # Errors
/// As [`save`]; when only the last step fails, the new file is in place and may not outlive the
/// machine.
pub fn save_durably<F>(path: &Path, fill: F) -> Result<(), SaveError>
where
    F: FnOnce(&mut dyn Write) -> io::Result<()>,
{
    filled(path, fill)?.keep_durably()
}

/// A file that was written through `fill`, still without its name.
pub(super) fn filled<F>(path: &Path, fill: F) -> Result<AtomicFile, SaveError>
where
    F: FnOnce(&mut dyn Write) -> io::Result<()>,
{
    let mut file = AtomicFile::stream(path)?;
    fill(&mut file).map_err(|cause| file.failed(cause))?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_failure_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        save(&path, |w| w.write_all(b"old")).unwrap();
        for durably in [false, true] {
            let fill = |w: &mut dyn Write| {
                w.write_all(b"half of the new")?;
                Err(io::Error::other("no more"))
            };
            let failed = if durably {
                save_durably(&path, fill)
            } else {
                save(&path, fill)
            };
            assert!(failed.unwrap_err().to_string().contains("a.txt"));
            assert_eq!(fs::read(&path).unwrap(), b"old");
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        }
    }

    #[test]
    fn missing_folders_are_made_and_go_with_a_failure() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b/c.txt");
        save(&path, |_| Err(io::Error::other("no more"))).unwrap_err();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        save_durably(&path, |w| w.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        let names = fs::read_dir(path.parent().unwrap()).unwrap();
        assert_eq!(names.count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_and_its_target_is_replaced() {
        use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("far")).unwrap();
        fs::write(at("far/real"), "old").unwrap();
        fs::set_permissions(at("far/real"), fs::Permissions::from_mode(0o640)).unwrap();
        symlink("far/real", at("one")).unwrap();
        symlink("one", at("two")).unwrap();
        save(&at("two"), |w| w.write_all(b"new")).unwrap();
        assert_eq!(fs::read_link(at("two")).unwrap(), Path::new("one"));
        assert_eq!(fs::read_link(at("one")).unwrap(), Path::new("far/real"));
        assert_eq!(fs::read(at("far/real")).unwrap(), b"new");
        let mode = fs::metadata(at("far/real")).unwrap().mode();
        assert_eq!(mode & 0o7777, 0o640, "a file keeps its mode");
        symlink("nothing/yet", at("dangling")).unwrap();
        save(&at("dangling"), |w| w.write_all(b"made")).unwrap();
        assert_eq!(fs::read(at("nothing/yet")).unwrap(), b"made");
        symlink("loop", at("loop")).unwrap();
        let error = save(&at("loop"), |w| w.write_all(b"new")).unwrap_err();
        assert!(error.to_string().contains("symbolic links"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn a_device_stays_a_device() {
        use std::os::unix::fs::FileTypeExt;
        let null = Path::new("/dev/null");
        save(null, |w| w.write_all(b"gone")).unwrap();
        let mut file = AtomicFile::create(null).unwrap();
        file.write_all(b"gone").unwrap();
        file.keep().unwrap();
        assert!(fs::metadata(null).unwrap().file_type().is_char_device());
    }
}
