//! The walk-throughs of the pages: their blocks, and a copy of the sources in which they are
//! followed to the letter.

#![allow(dead_code)] // Each test takes what it needs.

use std::{fs, path::Path};

/// The repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Copies what the program is built from.
pub fn copy(from: &Path, to: &Path) {
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

/// A block of a page: the file, before which words it goes (`None`: at the end), and its text.
pub struct Block {
    pub file: String,
    pub before: Option<String>,
    pub text: String,
}

/// The blocks of a page behind its heading.
pub fn blocks(page: &str, heading: &str) -> Vec<Block> {
    let page = fs::read_to_string(root().join(page)).unwrap();
    let (_, walk) = page.split_once(heading).unwrap();
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

impl Block {
    /// Puts it where the page says, in a copy of the sources.
    pub fn follow(&self, tree: &Path) {
        let path = tree.join(&self.file);
        let old = fs::read_to_string(&path).unwrap_or_default();
        let new = match &self.before {
            None if old.is_empty() => self.text.clone(),
            None => format!("{old}\n{}", self.text),
            Some(words) => {
                let at = old.find(words.as_str());
                let at = at.unwrap_or_else(|| panic!("{}: no {words}", self.file));
                let line = old[..at].rfind('\n').unwrap() + 1;
                format!("{}{}{}", &old[..line], self.text, &old[line..])
            }
        };
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, new).unwrap();
    }
}
