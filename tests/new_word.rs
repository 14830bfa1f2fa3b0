//! Proves that the walk-through of `isa/README.md` adds an instruction: followed to the letter in a
//! copy of the sources, it builds, and stores obey the FLAG that the new word clears.

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

/// Copies what the program is built from.
fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let (path, name) = (entry.path(), entry.file_name());
        if path.is_file() {
            fs::copy(&path, to.join(name)).unwrap();
        } else if path.is_dir() && name != "target" && name != ".git" {
            copy(&path, &to.join(name));
        }
    }
}

/// A block of the page: the file, before which words it goes (`None`: at the end), and its text.
struct Block {
    file: String,
    before: Option<String>,
    text: String,
}

fn blocks(page: &str) -> Vec<Block> {
    let (_, walk) = page
        .split_once("### From the row to the last schedule")
        .unwrap();
    let mut blocks = Vec::new();
    for block in walk.split("```").skip(1).step_by(2) {
        let (head, text) = block.split_once('\n').unwrap();
        let (_, head) = head.split_once(' ').unwrap();
        let (file, place) = head.split_once(' ').unwrap();
        let before = place
            .strip_prefix("before \"")
            .map(|p| p.trim_end_matches('"'));
        assert!(before.is_some() || place == "at the end", "{head}");
        blocks.push(Block {
            file: file.to_owned(),
            before: before.map(str::to_owned),
            text: text.to_owned(),
        });
    }
    blocks
}

#[test]
#[ignore = "builds the program once more"]
fn the_walk_through_adds_a_word_that_clears_flag() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(root.join("isa/README.md")).unwrap();
    // In one place, so that what was built before is found again.
    let tree = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("new-word");
    let _ = fs::remove_dir_all(&tree);
    copy(root, &tree);
    let blocks = blocks(&page);
    assert_eq!(blocks.len(), 12);
    for block in &blocks {
        let path = tree.join(&block.file);
        let old = fs::read_to_string(&path).unwrap_or_default();
        let new = match &block.before {
            None if old.is_empty() => block.text.clone(),
            None => format!("{old}\n{}", block.text),
            Some(words) => {
                let at = old.find(words.as_str());
                let at = at.unwrap_or_else(|| panic!("{}: no {words}", block.file));
                let line = old[..at].rfind('\n').unwrap() + 1;
                format!("{}{}{}", &old[..line], block.text, &old[line..])
            }
        };
        fs::write(path, new).unwrap();
    }
    // The dependencies are those of the tests; an example needs no program besides. As it is
    // compiled once and runs for a moment, it is not optimised.
    let ran = Command::new(env!("CARGO"))
        .args(["run", "--release", "--all-features", "--offline"])
        .args(["--config", "profile.release.package.amacrine.opt-level=0"])
        .args(["--example", "nowhere"])
        .current_dir(&tree)
        .env("CARGO_TARGET_DIR", root.join("target"))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.success(), "{said}");
}
