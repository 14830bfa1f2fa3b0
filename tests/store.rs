//! A folder of results from outside: what was damaged, by whatever and however, is found, named
//! and computed again, and is never a number; folders that disagree are not joined; nothing is
//! read or written through a symlink; a point that is given up is a row.
#![cfg(all(feature = "cli", unix))]

mod common;

use std::{
    collections::BTreeMap,
    fmt::Write as _,
    fs,
    os::unix::fs::symlink,
    path::{Path, PathBuf},
    process::Command as Process,
    sync::OnceLock,
};

use common::{amacrine, json as said, refusal, refused};
use proptest::prelude::*;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use tempfile::TempDir;

/// A reference in three formats, a chip, a point that cannot be; sixteen points.
const STUDY: &str = "scene = \"pattern:disc?width=24&height=16&frames=5&radius=5\"\nthreshold = [12, 20, 28, 36]\neffort = 0\n\
    [[side]]\nside = \"reference\"\nkernel = \"laplacian\"\nformat = [\"f64\", \"f32\", \"f16\"]\n\
    [[side]]\nside = \"array\"\nkernel = \"csdvs-5\"\n";
const POINTS: usize = 16;

#[track_caller]
fn sweep(at: &Path, folder: &str) -> Value {
    said(at, &["sweep", "study.toml", "--output", folder])
}

/// A study and its results in `out`, computed once for all tests; a copy of them.
fn swept() -> TempDir {
    static ONCE: OnceLock<TempDir> = OnceLock::new();
    let once = ONCE.get_or_init(|| {
        let folder = TempDir::new().unwrap();
        fs::write(folder.path().join("study.toml"), STUDY).unwrap();
        assert_eq!(sweep(folder.path(), "out")["finished"], POINTS);
        folder
    });
    let own = TempDir::new().unwrap();
    copy(once.path(), own.path());
    own
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in from.read_dir().unwrap() {
        let entry = entry.unwrap();
        let to = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &to);
        } else {
            fs::copy(entry.path(), to).unwrap();
        }
    }
}

/// Every row without its times.
fn rows(folder: &Path) -> Vec<BTreeMap<String, Value>> {
    let text = fs::read_to_string(folder.join("results.jsonl")).unwrap();
    let row = |line: &str| {
        let mut row: BTreeMap<String, Value> = serde_json::from_str(line).unwrap();
        for time in ["seconds_per_frame", "frames_per_s", "events_per_s"] {
            row.remove(time).unwrap();
        }
        row
    };
    text.lines().map(row).collect()
}

/// The files of the points, in the order of the study.
fn points(folder: &Path) -> Vec<PathBuf> {
    let said: Value = read(&folder.join("sweep.json"));
    let ids = said["points"].as_array().unwrap();
    let path = |id: &Value| folder.join(format!("points/{}.json", id.as_str().unwrap()));
    ids.iter().map(path).collect()
}

fn read(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// The checksum as the documentation states it, of an object without one.
fn checksum(fields: &BTreeMap<String, Value>) -> String {
    let text = serde_json::to_string(fields).unwrap();
    let mut hex = String::new();
    for byte in Sha256::digest(text.as_bytes()) {
        write!(hex, "{byte:02x}").unwrap();
    }
    hex
}

/// Changes an object and gives it the checksum of what it then is: what no accident does.
fn forge(path: &Path, change: impl FnOnce(&mut BTreeMap<String, Value>)) {
    let mut fields: BTreeMap<String, Value> =
        serde_json::from_slice(&fs::read(path).unwrap()).unwrap();
    assert_eq!(fields.remove("checksum"), Some(checksum(&fields).into()));
    change(&mut fields);
    fields.insert("checksum".to_owned(), checksum(&fields).into());
    fs::write(path, serde_json::to_string_pretty(&fields).unwrap()).unwrap();
}

fn provenance(point: &mut BTreeMap<String, Value>) -> &mut Value {
    point.get_mut("provenance").unwrap()
}

#[test]
fn a_point_carries_all_its_columns_and_who_computed_them() {
    let folder = swept();
    let out = folder.path().join("out");
    let said = read(&out.join("sweep.json"));
    for (index, path) in points(&out).iter().enumerate() {
        let Value::Object(mut point) = read(path) else {
            panic!("no object");
        };
        assert_eq!(point["index"], index);
        let who = point.remove("provenance").unwrap();
        for key in ["amacrine", "build", "compiler", "cpu", "target"] {
            assert!(!who[key].as_str().unwrap().is_empty(), "{key}");
        }
        assert_eq!(who["numerics"], amacrine::study::sweep::NUMERICS);
        point.remove("checksum").unwrap();
        let mut names: Vec<&String> = point.keys().collect();
        let mut columns: Vec<&str> = said["columns"]
            .as_array()
            .unwrap()
            .iter()
            .map(|name| name.as_str().unwrap())
            .collect();
        names.sort_unstable();
        columns.sort_unstable();
        assert_eq!(names, columns);
        // Its checksum is the documented one.
        forge(path, |_| {});
    }
    assert_eq!(sweep(folder.path(), "out")["computed"], 0);
}

/// Everything that can stand in the place of a point's file.
#[test]
fn damage_of_every_kind_is_listed_at_once_and_computed_again() {
    let folder = swept();
    let (at, out) = (folder.path(), folder.path().join("out"));
    let before = rows(&out);
    let files = points(&out);
    let text = |index: usize| fs::read_to_string(&files[index]).unwrap();
    let whole: Vec<String> = (0..POINTS).map(text).collect();
    let id = |index: usize| files[index].file_stem().unwrap().to_str().unwrap();
    let events = read(&files[1])["events"].clone();

    fs::write(&files[0], format!("{{\"id\":\"{}\"}}", id(0))).unwrap();
    let changed = whole[1].replace(&format!("\"events\":{events}"), "\"events\":9");
    assert_ne!(changed, whole[1]);
    fs::write(&files[1], changed).unwrap();
    forge(&files[2], |point| {
        point.remove("error");
    });
    fs::write(&files[3], &whole[4]).unwrap();
    fs::write(&files[5], &whole[5][..whole[5].len() / 2]).unwrap();
    fs::write(&files[6], "").unwrap();
    fs::write(&files[7], [0xff; 100]).unwrap();
    let huge = fs::File::create(&files[8]).unwrap();
    huge.set_len(1 << 33).unwrap();
    fs::remove_file(&files[9]).unwrap();
    fs::create_dir_all(files[9].join("mine")).unwrap();
    fs::remove_file(&files[10]).unwrap();
    symlink("/nowhere/at/all", &files[10]).unwrap();
    fs::remove_file(&files[11]).unwrap();
    let fifo = Process::new("mkfifo").arg(&files[11]).status();
    assert!(fifo.unwrap().success());
    // The right point, through a symlink.
    let aside = at.join("elsewhere.json");
    fs::rename(&files[12], &aside).unwrap();
    symlink(&aside, &files[12]).unwrap();
    forge(&files[13], |point| {
        point.insert("more".to_owned(), json!(1));
    });
    forge(&files[14], |point| {
        point.remove("provenance");
    });
    fs::write(&files[15], "[".repeat(100_000)).unwrap();
    let damaged: Vec<usize> = (0..POINTS).filter(|index| *index != 4).collect();

    for arguments in [&["report", "out"][..], &["merge", "out", "--output", "all"]] {
        let message = refused(at, arguments, &["15 files of points are damaged"]);
        let close = message.replace(' ', "");
        for index in &damaged {
            assert!(close.contains(id(*index)), "{index}: {message}");
        }
        assert!(!close.contains(id(4)));
    }
    assert!(!at.join("all").exists());
    // Nothing is computed or set aside by those who only look.
    assert!(files[9].join("mine").is_dir() && !out.join("damaged").exists());

    let said = sweep(at, "out");
    assert_eq!(said["computed"], damaged.len());
    let named = said["damaged"].as_array().unwrap().iter();
    let named: Vec<_> = named.map(|damage| damage["point"].clone()).collect();
    assert_eq!(json!(named), json!(damaged));
    assert_eq!(rows(&out), before);
    assert_eq!(
        out.join("damaged").read_dir().unwrap().count(),
        damaged.len()
    );
    assert!(
        out.join("damaged")
            .join(files[9].file_name().unwrap())
            .join("mine")
            .is_dir()
    );
    assert_eq!(
        fs::read_to_string(&aside).unwrap(),
        whole[12],
        "nothing is written through it"
    );
    assert_eq!(sweep(at, "out")["computed"], 0);

    // Damaged again: the first is not lost.
    fs::write(&files[6], "{}").unwrap();
    let text = amacrine(at, &["sweep", "study.toml", "--output", "out"])
        .assert()
        .success();
    let text = String::from_utf8_lossy(&text.get_output().stdout).into_owned();
    assert!(
        text.contains("damaged  1 file of points, set aside in out/damaged"),
        "{text}"
    );
    assert!(
        text.contains(&format!("{}.json: it has no column", id(6))),
        "{text}"
    );
    assert_eq!(
        out.join("damaged").read_dir().unwrap().count(),
        damaged.len() + 1
    );
    assert_eq!(rows(&out), before);
}

#[test]
fn what_a_killed_process_left_half_written_is_removed() {
    let folder = swept();
    let at = folder.path();
    let pilots = at.join("out/pilots");
    fs::create_dir_all(&pilots).unwrap();
    let left = [&pilots, &at.join("out"), &at.join("out/points")]
        .map(|folder| folder.join(".amacrine-4194304-1.tmp"));
    for file in &left {
        fs::write(file, "{").unwrap();
    }
    fs::write(pilots.join("other.json"), "{}").unwrap();
    sweep(at, "out");
    for file in left {
        assert!(!file.exists(), "{}", file.display());
    }
    assert!(pilots.join("other.json").exists());
}

#[test]
fn a_damaged_manifest_is_named_and_can_be_made_again_around_its_points() {
    let folder = swept();
    let (at, out) = (folder.path(), folder.path().join("out"));
    let path = out.join("sweep.json");
    let whole = fs::read_to_string(&path).unwrap();
    let first = points(&out)[0]
        .file_stem()
        .unwrap()
        .to_str()
        .unwrap()
        .to_owned();
    let other = points(&out)[1]
        .file_stem()
        .unwrap()
        .to_str()
        .unwrap()
        .to_owned();
    fs::create_dir_all(at.join("x")).unwrap();
    let many = vec![format!("\"{first}\""); 100_001].join(",");
    for (damage, words) in [
        (
            whole.replace(&first, "../../x"),
            "the identity of point 0 is \"../../x\"",
        ),
        (
            whole.replace(&first, &first.to_uppercase()),
            "lower-case hexadecimal",
        ),
        (whole.replace(&first, &other), "twice"),
        (
            whole.replace(&format!("\"{first}\""), &many),
            "the most are 100000",
        ),
        (whole.replace("\"error\"", "\"terror\""), "checksum"),
        (
            whole.replace("\"title\": \"study\"", "\"title\": \"studs\""),
            "checksum",
        ),
        (whole[..whole.len() / 2].to_owned(), "not a JSON object"),
        (String::new(), "empty"),
        ("{}".to_owned(), "which version"),
        ("[".repeat(1 << 20), "not a JSON object"),
    ] {
        assert_ne!(damage, whole);
        fs::write(&path, &damage).unwrap();
        for arguments in [
            &["sweep", "study.toml", "--output", "out"][..],
            &["report", "out"],
            &["merge", "out", "--output", "all"],
        ] {
            refused(
                at,
                arguments,
                &["sweep.json is damaged", words, "delete it"],
            );
        }
        assert_eq!(fs::read_to_string(&path).unwrap(), damage);
    }
    let huge = fs::File::create(&path).unwrap();
    huge.set_len(1 << 34).unwrap();
    refused(
        at,
        &["report", "out"],
        &["sweep.json is damaged", "17179869184 bytes"],
    );
    // As the message says.
    fs::remove_file(&path).unwrap();
    let said = sweep(at, "out");
    assert_eq!(
        (&said["computed"], &said["found"]),
        (&json!(0), &json!(POINTS))
    );
    assert_eq!(fs::read_to_string(&path).unwrap(), whole);
}

/// A chart of one's own in the folder is no reason to lose its points; what else is in a folder that
/// is not of a sweep is named.
#[test]
fn a_folder_without_its_manifest_is_known_by_its_points() {
    let folder = swept();
    let (at, out) = (folder.path(), folder.path().join("out"));
    said(at, &["report", "out", "-o", "out/front.svg"]);
    let whole = fs::read_to_string(out.join("sweep.json")).unwrap();
    fs::remove_file(out.join("sweep.json")).unwrap();
    let again = sweep(at, "out");
    assert_eq!(
        (&again["computed"], &again["found"]),
        (&json!(0), &json!(POINTS))
    );
    assert_eq!(fs::read_to_string(out.join("sweep.json")).unwrap(), whole);
    assert!(out.join("front.svg").exists());

    fs::remove_file(out.join("sweep.json")).unwrap();
    // Systems leave hidden files of their own in any folder that somebody has looked at.
    for folder in [&out, &out.join("points")] {
        fs::write(folder.join(".DS_Store"), "").unwrap();
    }
    fs::write(out.join("points/mine.txt"), "mine").unwrap();
    let arguments = ["sweep", "study.toml", "--output", "out"];
    refused(at, &arguments, &["no sweep.json", "out/points/mine.txt"]);
    fs::remove_file(out.join("points/mine.txt")).unwrap();
    fs::remove_file(out.join("ledger.txt")).unwrap();
    refused(at, &arguments, &["no sweep.json", "out/front.svg"]);
    assert!(!out.join("sweep.json").exists());
}

/// In a study with fewer points those that are kept have other numbers.
#[test]
fn points_are_known_by_their_identity_whatever_their_number() {
    let folder = swept();
    let (at, out) = (folder.path(), folder.path().join("out"));
    fs::remove_file(out.join("sweep.json")).unwrap();
    let fewer = STUDY.replace("[12, 20, 28, 36]", "[28, 12]");
    fs::write(at.join("study.toml"), fewer).unwrap();
    let again = sweep(at, "out");
    let found = (&again["computed"], &again["found"], &again["damaged"]);
    assert_eq!(found, (&json!(0), &json!(POINTS / 2), &json!([])));
    let lines = fs::read_to_string(out.join("results.jsonl")).unwrap();
    for (index, line) in lines.lines().enumerate() {
        let row: Value = serde_json::from_str(line).unwrap();
        assert_eq!(row["index"], index);
    }
}

/// A chip's folder is the same one from wherever the study is named.
#[test]
fn a_study_with_a_chip_of_its_own_is_gone_on_with_from_another_folder() {
    let folder = TempDir::new().unwrap();
    let (at, inner) = (folder.path(), folder.path().join("inner"));
    fs::create_dir_all(inner.join("own")).unwrap();
    let device = "name = \"own\"\ntitle = \"Own\"\nextends = \"scamp5\"\n";
    fs::write(inner.join("own/device.toml"), device).unwrap();
    let macros = "/// y := x\nmacro copied(out y: areg, x: areg) {\n    mov(y, x);\n}\n";
    fs::write(inner.join("own/macros.scamp"), macros).unwrap();
    let study = "scene = \"pattern:disc?width=24&height=16&frames=5&radius=5\"\nthreshold = 20\neffort = 0\n\
        [[side]]\nside = \"array\"\nkernel = \"dvs\"\nchip = \"own\"\n";
    fs::write(inner.join("study.toml"), study).unwrap();
    assert_eq!(sweep(&inner, "out")["computed"], 1);
    let arguments = ["sweep", "inner/study.toml", "--output", "inner/out"];
    assert_eq!(said(at, &arguments)["found"], 1);
}

/// The files of a study are looked for by names that are text.
#[test]
#[cfg(target_os = "linux")]
fn a_folder_whose_name_is_no_text_is_told_of() {
    use std::{ffi::OsStr, os::unix::ffi::OsStrExt as _};

    let folder = TempDir::new().unwrap();
    let odd = folder.path().join(OsStr::from_bytes(b"o\xffdd"));
    fs::create_dir(&odd).unwrap();
    fs::write(odd.join("clip.npy"), "light").unwrap();
    let study = STUDY.replace(
        "pattern:disc?width=24&height=16&frames=5&radius=5",
        "clip.npy",
    );
    fs::write(odd.join("study.toml"), study).unwrap();
    let mut sweep = amacrine(folder.path(), &["sweep"]);
    let told = sweep.arg(odd.join("study.toml")).output().unwrap();
    refusal(&told, &["no UTF-8", "rename the file, or link to it"]);
}

#[test]
fn results_of_other_numerics_are_refused_and_those_of_other_builds_are_told_apart() {
    let folder = swept();
    let (at, out) = (folder.path(), folder.path().join("out"));
    let files = points(&out);
    forge(&files[3], |point| {
        provenance(point)["build"] = json!("0123456789abcdef");
        provenance(point)["cpu"] = json!("abacus");
    });
    assert_eq!(sweep(at, "out")["computed"], 0);
    let by = said(at, &["report", "out"])["computed_by"].clone();
    let by = by.as_array().unwrap();
    assert_eq!(by.len(), 2);
    let abacus = by.iter().find(|by| by["cpu"] == "abacus").unwrap();
    assert_eq!(abacus["points"], 1);

    let before = fs::read(&files[4]).unwrap();
    let sweep = ["sweep", "study.toml", "--output", "out"];
    let merge = ["merge", "out", "--output", "all"];
    forge(&files[5], |point| {
        provenance(point)["numerics"] = json!(77);
    });
    for arguments in [&sweep[..], &merge, &["report", "out"]] {
        refused(
            at,
            arguments,
            &["1 points in out", "numerics version 77", "another --output"],
        );
    }
    forge(&files[5], |point| {
        provenance(point)["numerics"] = json!(amacrine::study::sweep::NUMERICS);
    });
    forge(&out.join("sweep.json"), |said| {
        said.insert("numerics".to_owned(), json!(77));
    });
    for arguments in [&sweep[..], &merge, &["report", "out"]] {
        refused(
            at,
            arguments,
            &[
                "out was made by amacrine",
                "numerics version 77",
                "another --output",
                "nothing was changed",
            ],
        );
    }
    // A folder that does not say is of the first kind.
    forge(&out.join("sweep.json"), |said| {
        said.remove("numerics");
    });
    refused(at, &sweep, &["numerics version 0"]);
    assert_eq!(fs::read(&files[4]).unwrap(), before);
    assert!(!at.join("all").exists());
}

#[test]
fn folders_that_disagree_are_not_joined() {
    let folder = swept();
    let at = folder.path();
    copy(&at.join("out"), &at.join("two"));
    let files = points(&at.join("two"));
    let held = read(&files[0])["error"].clone();
    forge(&files[0], |point| {
        point.insert("error".to_owned(), json!(0.123));
        // Times and names are no disagreement.
        point.insert("seconds_per_frame".to_owned(), json!(77.0));
        point.insert("kernel".to_owned(), json!("other-name"));
    });
    forge(&files[7], |point| {
        point.insert("on".to_owned(), json!(123_456));
        point.insert("off".to_owned(), json!(654_321));
    });
    let id = |index: usize| files[index].file_stem().unwrap().to_str().unwrap();
    let words = [
        "the folders disagree on 2 points",
        &format!("point 0 ({}), error: {held} in out, 0.123 in two", id(0)),
        &format!("point 7 ({}), off:", id(7)),
        "654321 in two",
        "123456 in two",
        "no result was written",
    ];
    let message = refused(at, &["merge", "out", "two", "--output", "all"], &words);
    assert!(!message.contains("seconds") && !message.contains("other-name"));
    assert!(!at.join("all").exists());
    // What is in the output already is asked as well.
    said(at, &["merge", "out", "--output", "all"]);
    let before = fs::read(at.join("all/results.csv")).unwrap();
    refused(at, &["merge", "two", "--output", "all"], &words[..1]);
    assert_eq!(fs::read(at.join("all/results.csv")).unwrap(), before);
    assert_eq!(rows(&at.join("all")), rows(&at.join("out")));
    // A failed point gives way to one that did not fail, whichever comes first.
    copy(&at.join("out"), &at.join("three"));
    let files = points(&at.join("three"));
    forge(&files[2], |point| {
        point.insert("outcome".to_owned(), json!("failed"));
        point.insert("error".to_owned(), Value::Null);
    });
    for (folders, into) in [(["three", "out"], "a"), (["out", "three"], "b")] {
        let said = said(at, &["merge", folders[0], folders[1], "--output", into]);
        assert_eq!(
            (&said["finished"], &said["failed"]),
            (&json!(POINTS), &json!(0))
        );
        assert_eq!(rows(&at.join(into)), rows(&at.join("out")));
    }
    let said = said(at, &["merge", "three", "--output", "c"]);
    assert_eq!(
        (&said["finished"], &said["failed"]),
        (&json!(POINTS - 1), &json!(1))
    );
}

#[test]
fn a_folder_named_twice_counts_once_and_is_never_the_output() {
    let folder = swept();
    let at = folder.path();
    symlink("out", at.join("link")).unwrap();
    let said = said(at, &["merge", "out", "./out", "link", "--output", "all"]);
    assert_eq!(said["finished"], POINTS);
    for output in ["out", "./out", "link"] {
        let before = fs::read(at.join("out/results.csv")).unwrap();
        refused(at, &["merge", "out", "all", "--output", output], &["out"]);
        assert_eq!(fs::read(at.join("out/results.csv")).unwrap(), before);
    }
}

#[test]
fn nothing_is_read_or_written_through_a_symlink() {
    let names = [
        "lock",
        "ledger.txt",
        "sweep.json",
        "results.csv",
        "results.jsonl",
        "results.parquet",
        "points",
        "damaged",
    ];
    for name in names {
        for dangling in [false, true] {
            let folder = swept();
            let at = folder.path();
            let (path, aside) = (at.join("out").join(name), at.join("aside"));
            if dangling {
                let _ = fs::remove_dir_all(&path).or_else(|_| fs::remove_file(&path));
            } else if path.exists() {
                fs::rename(&path, &aside).unwrap();
            } else if name == "damaged" {
                fs::create_dir(&aside).unwrap();
            } else {
                fs::write(&aside, "mine").unwrap();
            }
            symlink(&aside, &path).unwrap();
            let listing = |aside: &Path| -> Vec<(PathBuf, Vec<u8>)> {
                let Ok(entries) = aside.read_dir() else {
                    return vec![(aside.to_owned(), fs::read(aside).unwrap_or_default())];
                };
                let entries = entries.map(|entry| entry.unwrap().path());
                entries
                    .map(|path| (path.clone(), fs::read(path).unwrap()))
                    .collect()
            };
            let before = listing(&aside);
            let sweep = ["sweep", "study.toml", "--output", "out"];
            refused(
                at,
                &sweep,
                &[&format!("out/{name} is a symlink"), "nothing was changed"],
            );
            assert_eq!(listing(&aside), before, "{name}");
            assert!(path.is_symlink(), "{name}");
        }
    }
    // A FIFO does not hold anybody up.
    let folder = swept();
    for name in ["lock", "sweep.json"] {
        let path = folder.path().join("out").join(name);
        fs::remove_file(&path).unwrap();
        assert!(
            Process::new("mkfifo")
                .arg(&path)
                .status()
                .unwrap()
                .success()
        );
        let sweep = ["sweep", "study.toml", "--output", "out"];
        refused(folder.path(), &sweep, &["is a FIFO"]);
        fs::remove_file(&path).unwrap();
        fs::write(&path, "").unwrap();
    }
    // The folder itself may be where its user wants it.
    let folder = swept();
    fs::rename(folder.path().join("out"), folder.path().join("far")).unwrap();
    symlink("far", folder.path().join("out")).unwrap();
    assert_eq!(sweep(folder.path(), "out")["found"], POINTS);
}

#[test]
fn a_point_that_is_given_up_is_a_row_and_is_computed_by_the_next_run() {
    let folder = swept();
    let at = folder.path();
    let limited = [
        "sweep",
        "study.toml",
        "--output",
        "short",
        "--max-seconds-per-point",
    ];
    let short = said(at, &[&limited[..], &["1e-9"]].concat());
    // What cannot be is not watched.
    let failed = short["failed"].as_array().unwrap();
    assert_eq!(failed.len(), 12);
    assert_eq!(
        (&short["finished"], &short["missing"]),
        (&json!(4), &json!(0))
    );
    assert!(
        failed[0]["reason"]
            .as_str()
            .unwrap()
            .contains("more than 0.000000001 s")
    );
    let found = rows(&at.join("short"));
    assert_eq!(found.len(), POINTS);
    assert_eq!(
        (&found[0]["outcome"], &found[0]["error"]),
        (&json!("failed"), &Value::Null)
    );
    assert_eq!(found[0]["threshold_on"], 12.0);
    let report = said(at, &["report", "short"]);
    assert_eq!(report["failed"][0]["points"], 4);
    let text = amacrine(at, &[&limited[..], &["1e-9"]].concat())
        .assert()
        .success();
    let text = String::from_utf8_lossy(&text.get_output().stdout).into_owned();
    assert!(
        text.contains("failed   12 points, computed again by the next run"),
        "{text}"
    );

    let again = sweep(at, "short");
    assert_eq!(
        (&again["computed"], &again["found"]),
        (&json!(12), &json!(4))
    );
    assert_eq!(rows(&at.join("short")), rows(&at.join("out")));
    let long = said(
        at,
        &[
            "sweep",
            "study.toml",
            "--output",
            "long",
            "--max-seconds-per-point",
            "600",
        ],
    );
    assert_eq!(long["failed"], json!([]));
    for wrong in ["0", "-1", "nan", "inf", "x"] {
        refused(
            at,
            &[
                &limited[..4],
                &[&format!("--max-seconds-per-point={wrong}")],
            ]
            .concat(),
            &["seconds above 0"],
        );
    }
}

/// 256 x 192 pixels do not fit, 24 x 16 do: one sweep of both.
#[test]
fn a_point_that_does_not_fit_in_memory_is_a_row_beside_those_that_do() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let scene = |size: &str| format!("\"pattern:disc?{size}&frames=3&radius=5\"");
    let scenes = [scene("width=24&height=16"), scene("width=256&height=192")].join(", ");
    let study = format!(
        "scene = [{scenes}]\nkernel = \"dvs\"\nthreshold = 20\n[[side]]\nside = \"reference\"\n"
    );
    fs::write(at.join("study.toml"), study).unwrap();
    let arguments = [
        "--max-memory",
        "26M",
        "sweep",
        "study.toml",
        "--output",
        "out",
        "--jobs",
        "1",
    ];
    let little = said(at, &arguments);
    assert_eq!(
        (&little["computed"], &little["finished"]),
        (&json!(2), &json!(1))
    );
    let reason = little["failed"][0]["reason"].as_str().unwrap();
    assert!(reason.contains("--max-memory"), "{reason}");
    let found = rows(&at.join("out"));
    assert_eq!(
        (&found[0]["outcome"], &found[1]["outcome"]),
        (&json!("done"), &json!("failed"))
    );
    assert_eq!(found[1]["width"], 256);
    let again = sweep(at, "out");
    assert_eq!(
        (&again["computed"], &again["finished"]),
        (&json!(1), &json!(2))
    );
}

#[test]
fn a_share_is_computed_again_and_compared_to_the_bit() {
    let folder = swept();
    let (at, out) = (folder.path(), folder.path().join("out"));
    let verify = |more: &[&str]| {
        said(
            at,
            &[&["sweep", "study.toml", "--output", "out"], more].concat(),
        )
    };
    let some = verify(&["--verify", "5%"]);
    assert_eq!(
        (&some["compared"], &some["finished"]),
        (&json!(1), &json!(POINTS))
    );
    let all = verify(&["--verify", "100%"]);
    assert_eq!(
        (&all["compared"], &all["differences"]),
        (&json!(POINTS), &json!([]))
    );

    // The last bit of one number, with a checksum that is right.
    let files = points(&out);
    let number = read(&files[9])["van_rossum_5ms"].as_f64().unwrap();
    let next = f64::from_bits(number.to_bits() + 1);
    forge(&files[9], |point| {
        point.insert("van_rossum_5ms".to_owned(), json!(next));
    });
    let before = fs::read(&files[9]).unwrap();
    let arguments = ["sweep", "study.toml", "--output", "out", "--verify", "100%"];
    refused(
        at,
        &arguments,
        &[
            "1 of 16 points that were computed again",
            &format!(
                "van_rossum_5ms: {} in the folder, {} now",
                json!(next),
                json!(number)
            ),
            "nothing was overwritten",
        ],
    );
    let done = amacrine(at, &arguments).arg("--json").assert().code(2);
    let said: Value = serde_json::from_slice(&done.get_output().stdout).unwrap();
    assert_eq!(said["differences"][0]["point"], 9);
    assert_eq!(said["differences"].as_array().unwrap().len(), 1);
    assert_eq!(fs::read(&files[9]).unwrap(), before);
    // Which points a share is of is the seed's choice, and always the same.
    let caught = |seed: u32| {
        let mut command = amacrine(at, &arguments[..5]);
        command.args(["25%", "--verify-seed", &seed.to_string()]);
        command.assert().get_output().status.code() == Some(2)
    };
    let found: Vec<bool> = (0..12).map(caught).collect();
    assert!(found.contains(&true) && found.contains(&false), "{found:?}");
    assert_eq!(caught(0), found[0]);
    for wrong in ["5", "0%", "101%", "x%"] {
        refused(
            at,
            &[&arguments[..5], &[wrong]].concat(),
            &["is no share", "such as 5%"],
        );
    }
    refused(
        at,
        &["sweep", "study.toml", "--output", "none", "--verify", "5%"],
        &["none"],
    );
    fs::write(&files[1], "").unwrap();
    refused(at, &arguments, &["1 file of points is damaged"]);
    assert_eq!(fs::read(&files[1]).unwrap(), b"");
}

/// What can happen to a file.
#[derive(Clone, Debug)]
enum Accident {
    Flip(f64, u8),
    Cut(f64),
    Zeros(f64, usize),
    Doubled,
    Gone,
    Other(f64),
}

fn accident() -> impl Strategy<Value = Accident> {
    prop_oneof![
        6 => (0.0..1.0, 0..8_u8).prop_map(|(at, bit)| Accident::Flip(at, bit)),
        2 => (0.0..1.0).prop_map(Accident::Cut),
        1 => (0.0..1.0, 1..600_usize).prop_map(|(at, long)| Accident::Zeros(at, long)),
        1 => Just(Accident::Doubled),
        1 => Just(Accident::Gone),
        1 => (0.0..1.0).prop_map(Accident::Other),
    ]
}

fn happen(accident: &Accident, file: &Path, all: &[PathBuf]) {
    let mut bytes = fs::read(file).unwrap();
    let place = |part: f64| (part * bytes.len() as f64) as usize;
    match *accident {
        _ if bytes.is_empty() => bytes.push(b'{'),
        Accident::Flip(at, bit) => {
            let at = place(at);
            bytes[at] ^= 1 << bit;
        }
        Accident::Cut(at) => bytes.truncate(place(at)),
        Accident::Zeros(at, long) => {
            let at = place(at);
            let end = (at + long).min(bytes.len());
            bytes[at..end].fill(0);
        }
        Accident::Doubled => bytes.extend_from_within(..),
        Accident::Gone => return fs::remove_file(file).unwrap(),
        Accident::Other(part) => {
            bytes = fs::read(&all[(part * all.len() as f64) as usize]).unwrap();
        }
    }
    fs::write(file, bytes).unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    /// Accidents to any files of the folder: the same tables, or a message.
    #[test]
    fn no_accident_is_a_number(accidents in proptest::collection::vec((accident(), 0.0..1.0), 1..4)) {
        let folder = swept();
        let (at, out) = (folder.path(), folder.path().join("out"));
        let before = rows(&out);
        let mut files = points(&out);
        for name in ["sweep.json", "ledger.txt", "lock", "results.csv", "results.jsonl"] {
            files.push(out.join(name));
        }
        for (accident, part) in &accidents {
            let file = &files[(part * files.len() as f64) as usize];
            if file.exists() {
                let there: Vec<PathBuf> = files.iter().filter(|f| f.exists()).cloned().collect();
                happen(accident, file, &there);
            }
        }
        let done = amacrine(at, &["sweep", "study.toml", "--output", "out", "--jobs", "1"])
            .output()
            .unwrap();
        let message = String::from_utf8_lossy(&done.stderr).into_owned();
        prop_assert!(!message.contains("panicked"), "{}", message);
        match done.status.code() {
            Some(0) => prop_assert_eq!(rows(&out), before),
            Some(2) => prop_assert!(message.contains("sweep.json") || message.contains("was made by"), "{}", message),
            other => prop_assert!(false, "{:?}: {}", other, message),
        }
    }
}
