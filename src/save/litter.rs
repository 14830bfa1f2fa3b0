//! What processes of this program that were killed have left in a folder.

use std::{ffi::OsStr, fs, io, path::Path};

use super::temporary::{PREFIX, SUFFIX};

/// Whether a name in a folder is one that this program gives to what has no name yet.
fn is_temporary(name: &OsStr) -> bool {
    let parts = name.to_str().and_then(|name| {
        name.strip_prefix(PREFIX)?
            .strip_suffix(SUFFIX)?
            .split_once('-')
    });
    let number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    parts.is_some_and(|(process, count)| number(process) && number(count))
}

/// Removes from a folder what processes of this program have left that are no more; how many
/// files those were.
///
/// A process locks what it writes, and the system takes the lock back however it ends: what is
/// locked belongs to somebody who lives, here or on another machine, and stays. So does what has
/// another name, and what may not be opened or removed.
///
/// # Errors
/// When the folder cannot be read.
pub fn sweep_up(folder: &Path) -> io::Result<usize> {
    let mut removed = 0;
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if !is_file || !is_temporary(&entry.file_name()) {
            continue;
        }
        let path = entry.path();
        let Ok(file) = fs::OpenOptions::new().read(true).write(true).open(&path) else {
            continue;
        };
        // The lock is held while the name goes: its maker sees that, and begins anew.
        if file.try_lock().is_ok() && fs::remove_file(&path).is_ok() {
            removed += 1;
        }
    }
    Ok(removed)
}

#[cfg(test)]
mod tests {
    use super::{super::atomic_file::AtomicFile, *};

    #[test]
    fn only_what_is_dead_and_ours_goes() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let alive = AtomicFile::create(&at("a.txt")).unwrap();
        let others = [
            ".tmpAbC123",
            ".amacrine-1-2.tmp.txt",
            ".amacrine-x-2.tmp",
            ".amacrine-1.tmp",
            "amacrine-1-2.tmp",
        ];
        for name in others {
            fs::write(at(name), "not ours").unwrap();
        }
        fs::create_dir(at(".amacrine-3-4.tmp")).unwrap();
        fs::write(at(".amacrine-4000000-17.tmp"), "half").unwrap();
        assert_eq!(sweep_up(folder.path()).unwrap(), 1);
        assert!(!at(".amacrine-4000000-17.tmp").exists());
        assert!(others.iter().all(|name| at(name).exists()));
        alive.keep().unwrap();
        assert!(at("a.txt").exists(), "what is being written was left alone");
        assert_eq!(sweep_up(folder.path()).unwrap(), 0);
    }
}
