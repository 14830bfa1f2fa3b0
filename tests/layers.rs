//! The code keeps to the floors of `docs/architecture.md`: rooms import downward only, rooms
//! of one floor do not know each other (but for the pairs that the table names), and only the
//! rooms that may do so touch the disk, print, exit or read the clock.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

struct Room {
    floor: usize,
    disk: bool,
    /// Rooms of the same floor that it may know.
    also: Vec<String>,
}

/// The import table: rows `| floor | room | what it holds | also knows | disk |`.
fn table() -> BTreeMap<String, Room> {
    let text = fs::read_to_string(root().join("docs/architecture.md")).unwrap();
    let rows = text.lines().filter_map(|line| {
        let cells: Vec<_> = line
            .trim()
            .strip_prefix('|')?
            .split('|')
            .map(str::trim)
            .collect();
        let floor = cells.first()?.parse().ok()?;
        let names = |cell: &str| -> Vec<String> {
            cell.split('`')
                .skip(1)
                .step_by(2)
                .map(str::to_owned)
                .collect()
        };
        let room = names(cells.get(1)?).first()?.clone();
        Some((
            room,
            Room {
                floor,
                also: names(cells.get(3)?),
                disk: cells.get(4)? == &"yes",
            },
        ))
    });
    rows.collect()
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn sources(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, files);
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
}

/// Every source file, the room it is in, and its code without comments and tests.
fn code() -> Vec<(PathBuf, String, String)> {
    let src = root().join("src");
    let mut files = Vec::new();
    sources(&src, &mut files);
    files.sort();
    let read = |path: PathBuf| {
        let inside = path.strip_prefix(&src).unwrap().to_owned();
        let first = inside
            .components()
            .next()
            .unwrap()
            .as_os_str()
            .to_str()
            .unwrap();
        let room = first.trim_end_matches(".rs").to_owned();
        let text = fs::read_to_string(&path).unwrap();
        let tests = text.find("#[cfg(test)]\nmod tests").unwrap_or(text.len());
        let kept = text[..tests]
            .lines()
            .filter(|line| !line.trim_start().starts_with("//"));
        (inside, room, kept.collect::<Vec<_>>().join("\n"))
    };
    files
        .into_iter()
        .map(read)
        .filter(|(_, room, _)| room != "lib" && room != "main")
        .collect()
}

/// The rooms that code names: `crate::room::…` and `crate::{room::…, room::…}`.
fn imports(code: &str) -> Vec<String> {
    let mut found = Vec::new();
    let word = |text: &str| {
        text.chars()
            .take_while(|c| c.is_alphanumeric() || *c == '_')
            .collect::<String>()
    };
    for (at, _) in code.match_indices("crate::") {
        let rest = &code[at + "crate::".len()..];
        let Some(group) = rest.strip_prefix('{') else {
            found.push(word(rest));
            continue;
        };
        let mut depth = 0;
        let mut start = true;
        for (i, c) in group.char_indices() {
            match c {
                '}' if depth == 0 => break,
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 0 => start = true,
                _ if start && c.is_alphanumeric() => {
                    found.push(word(&group[i..]));
                    start = false;
                }
                _ => {}
            }
        }
    }
    found
}

#[test]
fn groups_of_imports_are_read() {
    let text = "use crate::{event::{Event, Packet}, plane::Size};\nlet x = crate::unit::Micros(1);\nuse crate::{\n    scene,\n};";
    assert_eq!(imports(text), ["event", "plane", "unit", "scene"]);
}

#[test]
fn imports_run_downward() {
    let table = table();
    assert!(
        table.len() > 10,
        "the table of docs/architecture.md was not found"
    );
    let mut wrong = Vec::new();
    for (file, room, code) in code() {
        let Some(own) = table.get(&room) else {
            wrong.push(format!(
                "{}: room `{room}` is not in the table",
                file.display()
            ));
            continue;
        };
        for other in imports(&code).into_iter().filter(|other| *other != room) {
            let Some(theirs) = table.get(&other) else {
                wrong.push(format!(
                    "{}: imports `{other}`, which is not in the table",
                    file.display()
                ));
                continue;
            };
            if theirs.floor > own.floor || (theirs.floor == own.floor && !own.also.contains(&other))
            {
                wrong.push(format!(
                    "{} (floor {}) imports {other} (floor {})",
                    file.display(),
                    own.floor,
                    theirs.floor
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_room_of_the_table_exists() {
    for room in table().keys() {
        let file = root().join(format!("src/{room}.rs"));
        assert!(
            file.exists() || root().join("src").join(room).join("mod.rs").exists(),
            "no room `{room}`"
        );
    }
}

#[test]
fn only_some_rooms_touch_the_world() {
    let table = table();
    let mut wrong = Vec::new();
    for (file, room, code) in code() {
        let disk = table.get(&room).is_some_and(|room| room.disk);
        let forbid = |what: &str, allowed: bool, wrong: &mut Vec<String>| {
            if !allowed && code.contains(what) {
                wrong.push(format!("{} has {what}", file.display()));
            }
        };
        for what in [
            "std::fs",
            "fs::",
            "File::open",
            "File::create",
            "Stack::create",
        ] {
            forbid(what, disk, &mut wrong);
        }
        for what in [
            "println!",
            "print!(",
            "eprintln!",
            "Instant::now",
            "SystemTime",
        ] {
            forbid(what, room == "cli", &mut wrong);
        }
        // The library has concrete types of errors.
        for what in [
            "miette!(",
            "bail!(",
            "ensure!(",
            "miette::Re",
            "WrapErr",
            "IntoDiagnostic",
        ] {
            forbid(what, room == "cli", &mut wrong);
        }
        let used = code.split("use miette::{").skip(1);
        let used = used.filter_map(|it| it.split_once('}'));
        let mut names = used.flat_map(|(names, _)| names.split(',').map(str::trim));
        if room != "cli" && names.any(|it| matches!(it, "Report" | "Result")) {
            wrong.push(format!(
                "{} takes Report or Result of miette",
                file.display()
            ));
        }
        // `main` alone ends the program: what holds temporaries is dropped before.
        forbid("process::exit", false, &mut wrong);
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A width that is wider than another has to name what the other has: `target_cfg_f!` asks for what
/// is named, not for what that brings with it, and would take the loop of CPUs without it.
#[test]
fn wide_vectors_are_not_taken_for_narrow_ones() {
    let mut wide = 0;
    for (file, _, code) in code() {
        for target in code
            .split('"')
            .filter(|it| it.starts_with("x86_64+") && it.contains("avx512"))
        {
            assert!(
                target.split('+').any(|it| it == "avx2"),
                "{}: {target}",
                file.display()
            );
            wide += 1;
        }
    }
    assert!(wide > 10, "{wide}");
}

/// `rig::play` is the one loop over the frames of a scene.
#[test]
fn one_loop_shows_frames() {
    let mut loops = Vec::new();
    for (file, room, code) in code() {
        let read = code.lines().filter(|line| line.contains("next_frame()"));
        if room != "scene" && read.into_iter().any(|line| line.contains("while")) {
            loops.push(file);
        }
    }
    assert_eq!(loops, [Path::new("rig.rs")]);
}
