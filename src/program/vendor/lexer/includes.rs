//! The files that vendor C++ asks for.

use std::path::Path;

use super::{
    preprocessor::asked,
    prototype::undefined,
    source_map::{Includes, Lying, bodies, named, plain},
};
use crate::{limit::FAULTS, source};

/// The files that a text asks for by `#include "…"`, which lie beside it, and those that hold the
/// bodies of what headers and the text itself declare, if they are there.
#[must_use]
pub fn included(text: &str) -> Vec<String> {
    let headers = asked(text);
    let mut all: Vec<String> = headers.iter().flat_map(|it| bodies(it)).collect();
    for (name, _) in undefined(text) {
        all.extend(named(&name));
    }
    [headers, all].concat()
}

/// The files that a text of vendor C++ in this folder asks for, and those that they ask for, by the
/// names with which they are asked for. One that is not there is told of by whoever needs it.
#[must_use]
pub fn included_files(text: &str, folder: &Path) -> Includes {
    let mut all = Includes::new();
    include(text, [folder, folder], &mut all);
    all
}

/// Paths are written for Windows as well, and relative to whoever asks, or to the program; the names
/// alone are tried, too.
fn include(text: &str, places: [&Path; 2], all: &mut Includes) {
    for name in included(text) {
        if all.contains_key(&name) || all.len() > FAULTS {
            continue;
        }
        let path = name.replace('\\', "/");
        let tried = places.into_iter().flat_map(|folder| {
            let names = [path.as_str(), plain(&path)];
            names.map(|path| folder.join(path))
        });
        let mut there = tried.filter(|path| path.is_file());
        let Some(path) = there.next() else { continue };
        let Ok(text) = source::code(&path, "") else {
            continue;
        };
        all.insert(name, Lying::read(&text, &shown(&path, places[1])));
        include(&text, [path.parent().unwrap_or(places[1]), places[1]], all);
    }
}

/// A file as messages name it, beside the program.
fn shown(path: &Path, folder: &Path) -> String {
    let path = path.strip_prefix(folder).unwrap_or(path);
    path.display().to_string().replace('\\', "/")
}
