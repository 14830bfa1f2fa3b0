//! Every write, sync, rename and flush of every verb fails once: the exit code is right, what
//! was there is as it was or whole and new, nothing is left behind, one message. And a machine
//! that loses its power in the middle of a sweep loses no finished point.
//!
//! A library stands between the program and the system (`faults/shim.c`, Linux); the C compiler
//! that the program needs builds it.
#![cfg(all(feature = "cli", target_os = "linux"))]

mod verbs;

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
    sync::OnceLock,
    time::Instant,
};

use tempfile::TempDir;
use verbs::{CASES, Case, files};

fn shim() -> &'static Path {
    static SHIM: OnceLock<PathBuf> = OnceLock::new();
    SHIM.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
        let library = folder.join(format!("shim-{}.so", std::process::id()));
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/faults/shim.c");
        let built = Command::new("cc")
            .args(["-O1", "-shared", "-fPIC", "-o"])
            .arg(&library)
            .arg(source)
            .arg("-lpthread")
            .status();
        assert!(built.unwrap().success(), "cc did not build the shim");
        library
    })
}

/// One operation of those that can fail.
#[derive(Clone, Debug)]
struct Operation {
    number: usize,
    name: String,
    path: String,
    fails: bool,
}

struct Bench {
    folder: TempDir,
}

/// What a run left.
struct Ran {
    said: Output,
    operations: Vec<Operation>,
    /// What is in the folder, by name.
    left: BTreeMap<String, Vec<u8>>,
    litter: BTreeSet<String>,
}

impl Bench {
    fn new() -> Self {
        let folder = TempDir::new().unwrap();
        verbs::inputs(folder.path());
        Self { folder }
    }

    fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Runs a case where old outputs are, or none; fails as it is told.
    fn run(&self, case: &Case, old: bool, shim_says: &[(&str, &str)]) -> Ran {
        let (work, temporary, log) = (self.at("work"), self.at("tmp"), self.at("log"));
        for folder in [&work, &temporary] {
            let _ = fs::remove_dir_all(folder);
            fs::create_dir(folder).unwrap();
        }
        let _ = fs::remove_file(&log);
        if old {
            for name in case.writes() {
                let path = work.join(name);
                fs::create_dir_all(path.parent().unwrap()).unwrap();
                fs::write(path, "old").unwrap();
            }
        }
        let mut command = case.command(&work);
        let under = format!("{}:{}", work.display(), temporary.display());
        command
            .env("LD_PRELOAD", shim())
            .env("TMPDIR", &temporary)
            .env("SHIM_UNDER", under)
            .env("SHIM_LOG", &log)
            .envs(shim_says.iter().copied());
        let said = command.output().unwrap();
        let text = fs::read_to_string(&log).unwrap_or_default();
        let operations = text.lines().map(|line| {
            let parts: Vec<_> = line.split('\t').collect();
            Operation {
                number: parts[0].parse().unwrap(),
                name: parts[1].to_owned(),
                path: parts[2].to_owned(),
                fails: parts.len() > 3,
            }
        });
        let left = files(&work).into_iter();
        Ran {
            said,
            operations: operations.collect(),
            left: left
                .map(|name| (name.clone(), fs::read(work.join(name)).unwrap()))
                .collect(),
            litter: files(&temporary),
        }
    }
}

fn message(said: &Output) -> String {
    String::from_utf8_lossy(&said.stderr).into_owned()
}

/// Sweeps take an old folder for theirs, and their rows have times in them.
fn keeps_old(case: &Case) -> bool {
    !["sweep", "merge"].contains(&case.verb())
}

/// All of a few; of many some, the first and the last among them.
fn chosen(case: &Case, operations: usize) -> Vec<usize> {
    let most = if case.slow { 6 } else { 40 };
    let step = operations.div_ceil(most).max(1);
    let mut all: Vec<usize> = (1..=operations).step_by(step).collect();
    if operations > 0 && all.last() != Some(&operations) {
        all.push(operations);
    }
    all
}

#[test]
fn the_table_has_every_verb() {
    let folder = TempDir::new().unwrap();
    let known: BTreeSet<String> = CASES.iter().map(|case| case.verb().to_owned()).collect();
    assert_eq!(verbs::verbs(folder.path()), known, "add it to tests/verbs");
}

#[test]
fn every_operation_of_every_verb_fails_once() {
    let bench = Bench::new();
    let mut tried = 0;
    let writes = |case: &&Case| case.writes().count() > 0 && case.verb() != "demo";
    for case in CASES.iter().filter(writes) {
        let line = case.line;
        let begun = Instant::now();
        let old = keeps_old(case);
        let good = bench.run(case, old, &[]);
        assert!(
            good.said.status.success(),
            "{line}: {}",
            message(&good.said)
        );
        assert!(good.litter.is_empty(), "{line}: {:?}", good.litter);
        for name in case.writes() {
            let new = good
                .left
                .get(name)
                .unwrap_or_else(|| panic!("{line} did not write {name}"));
            assert!(new != b"old", "{line}: {name} is old");
        }
        for name in ["write", "open", "rename"] {
            let has = good.operations.iter().any(|o| o.name == name);
            assert!(has, "{line}: the shim sees no {name}");
        }
        for number in chosen(case, good.operations.len()) {
            let operation = &good.operations[number - 1];
            let mut ways = vec!["enospc", "eio"];
            if operation.name == "write" {
                ways.extend(["short", "epipe"]);
            }
            if case.slow {
                ways = vec![ways[number % ways.len()]];
            }
            for how in ways {
                let at = number.to_string();
                let ran = bench.run(case, old, &[("SHIM_AT", &at), ("SHIM_HOW", how)]);
                let Operation {
                    number, name, path, ..
                } = operation;
                let what = format!(
                    "{line}: {how} of {number}, {name} {path}\n{}",
                    message(&ran.said)
                );
                // Where threads share the work the order may be another.
                if !ran.operations.iter().any(|o| o.fails) {
                    continue;
                }
                tried += 1;
                assert_eq!(ran.said.status.code(), Some(2), "{what}");
                let text = message(&ran.said);
                assert_eq!(text.matches('×').count(), 1, "one message: {what}");
                assert!(!text.contains("panicked"), "{what}");
                assert!(ran.litter.is_empty(), "{:?} left: {what}", ran.litter);
                for (name, bytes) in &ran.left {
                    if !old {
                        assert!(!name.contains(".amacrine-"), "{name} left: {what}");
                        continue;
                    }
                    let new = good.left.get(name);
                    assert!(new.is_some(), "{name} was left: {what}");
                    let whole = bytes == b"old" || Some(bytes) == new;
                    assert!(whole, "{name} is neither old nor new: {what}");
                }
                if !old && how != "eio" {
                    // Without the fault it goes on, and ends as it should.
                    let again = case.command(&bench.at("work")).output().unwrap();
                    assert!(again.status.success(), "again: {what}{}", message(&again));
                }
            }
        }
        eprintln!("{:>6.1} s  {line}", begun.elapsed().as_secs_f64());
    }
    assert!(tried > 300, "only {tried} faults were tried");
}

/// What was finished before the fault is new; what failed, and what would have come after it, is
/// as it was. The demo takes too long for a fault in each of its operations.
#[test]
fn the_demo_fails_once() {
    let bench = Bench::new();
    let demo = CASES.iter().find(|case| case.verb() == "demo").unwrap();
    let good = bench.run(demo, true, &[]);
    assert!(good.said.status.success(), "{}", message(&good.said));
    let renamed = |operations: &[Operation]| -> Vec<String> {
        let renames = operations.iter().filter(|o| o.name == "rename" && !o.fails);
        renames.map(|o| o.path.clone()).collect()
    };
    let first = good.operations.iter().find(|o| o.name == "rename").unwrap();
    let at = (first.number + 3).to_string();
    let ran = bench.run(demo, true, &[("SHIM_AT", &at), ("SHIM_HOW", "short")]);
    let text = message(&ran.said);
    assert!(ran.operations.iter().any(|o| o.fails), "{text}");
    assert_eq!(ran.said.status.code(), Some(2), "{text}");
    assert_eq!(text.matches('×').count(), 1, "{text}");
    assert!(ran.litter.is_empty());
    let names: BTreeSet<&str> = ran.left.keys().map(String::as_str).collect();
    assert_eq!(names, demo.writes().collect(), "{text}");
    let finished = renamed(&ran.operations);
    assert!(!finished.is_empty() && finished.len() < renamed(&good.operations).len());
    let work = bench.at("work");
    for name in demo.writes() {
        let is_new = finished.contains(&work.join(name).display().to_string());
        let wanted = if is_new {
            &good.left[name]
        } else {
            &b"old".to_vec()
        };
        assert!(ran.left[name] == *wanted, "{name}, new: {is_new}");
    }
}

#[test]
fn standard_output_fails_for_every_verb() {
    let bench = Bench::new();
    for case in CASES.iter().filter(|case| case.verb() != "demo") {
        let line = case.line;
        for (how, code) in [("enospc", 1), ("eio", 1), ("short", 1), ("epipe", 0)] {
            let says = [("SHIM_STDOUT", "1"), ("SHIM_AT", "1"), ("SHIM_HOW", how)];
            let ran = bench.run(case, false, &says);
            let text = message(&ran.said);
            let what = format!("{line}: {how}\n{text}");
            assert!(
                ran.operations.iter().any(|o| o.fails),
                "nothing said: {what}"
            );
            assert_eq!(ran.said.status.code(), Some(code), "{what}");
            assert!(!text.contains("panicked"), "{what}");
            let messages = text.matches('×').count();
            assert_eq!(messages, usize::from(code == 1), "{what}");
            assert!(ran.litter.is_empty(), "{what}");
            let left = |name: &str| ran.left.get(name).is_some_and(|bytes| !bytes.is_empty());
            assert!(case.writes().all(left), "outputs stay: {what}");
            if case.slow {
                break;
            }
        }
    }
}

#[test]
fn a_file_system_that_syncs_nothing_is_written_to() {
    let bench = Bench::new();
    let case = CASES.iter().find(|case| case.verb() == "sweep").unwrap();
    let ran = bench.run(case, false, &[("SHIM_NOSYNC", "1")]);
    assert!(ran.operations.iter().any(|o| o.name == "sync"));
    assert_eq!(ran.said.status.code(), Some(0), "{}", message(&ran.said));
    assert!(case.writes().all(|name| ran.left.contains_key(name)));
}

/// The disk of a machine that can lose its power: what has been written, and what of it would
/// still be there.
#[derive(Clone, Default)]
struct Disk {
    files: Vec<Written>,
    /// Names now, each of a file or (none) of a folder.
    names: BTreeMap<String, Option<usize>>,
    /// Names that are on the disk.
    kept: BTreeMap<String, Option<usize>>,
}

#[derive(Clone, Default)]
struct Written {
    now: Vec<u8>,
    kept: Vec<u8>,
}

fn above(path: &str) -> &str {
    path.rsplit_once('/').map_or("", |(folder, _)| folder)
}

impl Disk {
    /// Does an operation of the log.
    fn replay(&mut self, line: &str) {
        let parts: Vec<&str> = line.split('\t').collect();
        let file = |disk: &Self| disk.names.get(parts[1]).copied().flatten();
        match parts[0] {
            "create" => {
                self.files.push(Written::default());
                let new = self.files.len() - 1;
                self.names.insert(parts[1].to_owned(), Some(new));
            }
            "mkdir" => {
                self.names.insert(parts[1].to_owned(), None);
            }
            "write" => {
                let at: usize = parts[2].parse().unwrap();
                let bytes = parts[3].as_bytes().chunks(2);
                let bytes = bytes
                    .map(|two| u8::from_str_radix(std::str::from_utf8(two).unwrap(), 16).unwrap());
                let Some(file) = file(self) else { return };
                let now = &mut self.files[file].now;
                now.truncate(now.len().max(at));
                for (i, byte) in bytes.enumerate() {
                    match now.get_mut(at + i) {
                        Some(old) => *old = byte,
                        None => now.push(byte),
                    }
                }
            }
            "truncate" => {
                let length: usize = parts[2].parse().unwrap();
                if let Some(file) = file(self) {
                    self.files[file].now.resize(length, 0);
                }
            }
            "rename" => {
                if let Some(what) = self.names.remove(parts[1]) {
                    self.names.insert(parts[2].to_owned(), what);
                }
            }
            "unlink" | "rmdir" => {
                self.names.remove(parts[1]);
            }
            "sync" => {
                if let Some(file) = file(self) {
                    let file = &mut self.files[file];
                    file.kept.clone_from(&file.now);
                } else {
                    let folder = parts[1];
                    self.kept.retain(|name, _| above(name) != folder);
                    let inside = self.names.iter().filter(|(name, _)| above(name) == folder);
                    let inside = inside.map(|(name, what)| (name.clone(), *what));
                    self.kept.extend(inside.collect::<Vec<_>>());
                }
            }
            other => panic!("{other}"),
        }
    }

    /// What may be found when the power is back: names that were not kept are there or not, and
    /// so is what was not synced, or a part of it.
    fn after_a_cut(&self) -> Vec<BTreeMap<String, Option<Vec<u8>>>> {
        let mut all = Vec::new();
        for names in [&self.kept, &self.names] {
            for data in 0..3 {
                let content = |file: &Written| match data {
                    0 => file.kept.clone(),
                    1 => file.now.clone(),
                    _ => file.now[..usize::midpoint(file.kept.len(), file.now.len())].to_vec(),
                };
                let found = names.iter().map(|(name, what)| {
                    (name.clone(), what.map(|file| content(&self.files[file])))
                });
                all.push(found.collect());
            }
        }
        all
    }

    /// Points that were promised to be there: name and content are on the disk.
    fn promised(&self) -> usize {
        let point = |(name, what): &(&String, &Option<usize>)| {
            let file = what.map(|file| &self.files[file]);
            Path::new(name.as_str())
                .extension()
                .is_some_and(|e| e == "json")
                && above(name).ends_with("/points")
                && file.is_some_and(|file| !file.kept.is_empty() && file.kept == file.now)
        };
        self.kept.iter().filter(point).count()
    }
}

/// The rows of a sweep without what the machine has measured.
fn rows(folder: &Path) -> Vec<serde_json::Value> {
    let text = fs::read_to_string(folder.join("results.jsonl")).unwrap();
    let row = |line: &str| {
        let mut row: serde_json::Value = serde_json::from_str(line).unwrap();
        let columns = row.as_object_mut().unwrap();
        columns.retain(|name, _| !amacrine::study::sweep::table::machine(name));
        row
    };
    text.lines().map(row).collect()
}

#[test]
fn a_power_cut_loses_no_finished_point() {
    let bench = Bench::new();
    let sweep = CASES.iter().find(|case| case.verb() == "sweep").unwrap();
    let ran = {
        let (work, log) = (bench.at("work"), bench.at("log"));
        fs::create_dir(&work).unwrap();
        let mut command = sweep.command(&work);
        command.env("LD_PRELOAD", shim()).env("SHIM_DATA", "1");
        command.env("SHIM_UNDER", &work).env("SHIM_LOG", &log);
        let said = command.output().unwrap();
        assert!(said.status.success(), "{}", message(&said));
        fs::read_to_string(log).unwrap()
    };
    let work = bench.at("work");
    let wanted = rows(&work.join("w"));
    assert_eq!(wanted.len(), 4);
    assert_eq!(
        in_order(&ran),
        wanted.len(),
        "each point is synced, named, and its name synced"
    );
    let mut disk = Disk::default();
    let mut tried = BTreeSet::new();
    let top = work.to_str().unwrap().to_owned();
    for (at, line) in ran.lines().enumerate() {
        disk.replay(line);
        for (variant, found) in disk.after_a_cut().into_iter().enumerate() {
            // What lies in a folder that is not there is not there.
            let reachable = |name: &str| {
                let folder = above(name);
                folder == top || found.contains_key(folder)
            };
            let state: BTreeMap<_, _> = found.iter().filter(|(name, _)| reachable(name)).collect();
            if !tried.insert(format!("{state:?}")) {
                continue;
            }
            fs::remove_dir_all(&work).unwrap();
            fs::create_dir(&work).unwrap();
            for (name, content) in state {
                match content {
                    None => fs::create_dir_all(name).unwrap(),
                    Some(bytes) => {
                        fs::create_dir_all(above(name)).unwrap();
                        fs::write(name, bytes).unwrap();
                    }
                }
            }
            let mut again = sweep.command(&work);
            let said = again.arg("--json").output().unwrap();
            let what = format!(
                "cut after {at}, {line:.200}, variant {variant}: {}",
                message(&said)
            );
            assert!(said.status.success(), "{what}");
            assert!(rows(&work.join("w")) == wanted, "{what}");
            let json: serde_json::Value = serde_json::from_slice(&said.stdout).unwrap();
            let found = json["found"].as_u64().unwrap() as usize;
            assert!(
                found >= disk.promised(),
                "{found} points were found: {what}"
            );
            let left = files(&work);
            let litter = left.iter().find(|name| name.contains(".amacrine-"));
            assert!(litter.is_none(), "{litter:?}: {what}");
        }
    }
    assert!(tried.len() > 30, "only {} states", tried.len());
}

/// Points whose file was synced before it was named, and whose folder after.
fn in_order(log: &str) -> usize {
    let lines: Vec<Vec<&str>> = log.lines().map(|line| line.split('\t').collect()).collect();
    let named = lines
        .iter()
        .enumerate()
        .filter(|(_, line)| line[0] == "rename" && above(line[2]).ends_with("/points"));
    let ordered = named.filter(|(at, line)| {
        let last = lines[..*at]
            .iter()
            .rev()
            .find(|before| before[1] == line[1]);
        let folder = above(line[2]);
        let mut after = lines[*at..].iter();
        last.is_some_and(|last| last[0] == "sync")
            && after.any(|after| after[0] == "sync" && after[1] == folder)
    });
    ordered.count()
}
