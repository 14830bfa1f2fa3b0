//! The verbs `sweep`, `merge` and `report` from outside: a sweep killed again and again ends
//! with the results of one left alone; shards and any number of threads give the same; no point
//! is computed twice; each bad input has one message that points into the file; the schema and
//! the documentation are the table of keys that the code reads by.
#![cfg(feature = "cli")]

mod common;

use std::{
    collections::{HashMap, HashSet},
    fmt::Write as _,
    fs,
    path::Path,
    process::{Child, Command as Process, Stdio},
    thread,
    time::{Duration, SystemTime},
};

use amacrine::study::sweep::{
    SCHEMA, Study,
    key::{Absent, Key, Side},
    schema,
    study::{METRICS, SETTINGS},
    table,
};
use common::{amacrine, good, json, refused};
use serde_json::Value;
use tempfile::TempDir;

const SCENE: &str = "pattern:disc?width=32&height=24&frames=8&radius=6";

/// Both sides, a chip with chance, a point that cannot be (a kernel that is not dyadic), and
/// one that is named twice.
fn study() -> String {
    format!(
        "scene = \"{SCENE}\"\nkernel = [\"csdvs-5\", \"laplacian\"]\nthreshold = [20, {{ on = 30, off = 24 }}]\neffort = 0.01\nwithin = [\"1ms\", \"40ms\"]\n\
         [[side]]\nside = \"reference\"\nformat = [\"f64\", \"f16\", \"exact\"]\nmemory = [\"filtered-snap\", \"filtered-step\"]\n\
         [[side]]\nside = \"array\"\nquantise = [\"none\", \"ternary\"]\ndomain = [\"exact\", \"silicon\"]\nseed = [1, 2]\n\
         [[side]]\nside = \"mesh\"\nlambda = {{ from = 1, to = 4, steps = 2, log = true }}\nsolver = [\"ramp\", \"v2e\"]\ntau-us = 500\n"
    )
}

/// 2 kernels, 2 thresholds: 2 formats and 2 memories; exact once and silicon twice of 2
/// quantisers; 2 solvers of 2 meshes.
const POINTS: usize = 2 * 2 * (2 * 2 + 2 * (1 + 2)) + 2 * 2 * 2;

fn folder(text: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("study.toml"), text).unwrap();
    folder
}

/// The table without the columns that differ between machines.
fn results(folder: &Path) -> Vec<Vec<String>> {
    let mut csv = csv_reader(&folder.join("results.csv"));
    let names = csv.remove(0);
    let kept: Vec<usize> = (0..names.len())
        .filter(|i| !table::machine(&names[*i]))
        .collect();
    assert!(kept.len() + 3 < names.len());
    let row = |row: &Vec<String>| kept.iter().map(|i| row[*i].clone()).collect();
    std::iter::once(&names).chain(&csv).map(row).collect()
}

/// Rows of a CSV file, quotes and all (RFC 4180), by the shortest program.
fn csv_reader(path: &Path) -> Vec<Vec<String>> {
    let text = fs::read_to_string(path).unwrap();
    let (mut rows, mut row, mut cell, mut quoted) = (Vec::new(), Vec::new(), String::new(), false);
    for c in text.chars() {
        match c {
            // A quote in quotes is doubled; it opens and closes, and is one.
            '"' => {
                quoted = !quoted;
                if quoted && !cell.is_empty() {
                    cell.push('"');
                }
            }
            ',' if !quoted => row.push(std::mem::take(&mut cell)),
            '\n' if !quoted => {
                row.push(std::mem::take(&mut cell));
                rows.push(std::mem::take(&mut row));
            }
            c => cell.push(c),
        }
    }
    rows
}

/// How often the computation of each point was begun.
fn ledger(folder: &Path) -> HashMap<String, usize> {
    let mut begun = HashMap::new();
    for line in fs::read_to_string(folder.join("ledger.txt"))
        .unwrap()
        .lines()
    {
        *begun.entry(line.to_owned()).or_default() += 1;
    }
    begun
}

/// A sweep on two threads that says nothing.
fn killable(at: &Path, output: &str) -> Child {
    Process::new(assert_cmd::cargo::cargo_bin("amacrine"))
        .current_dir(at)
        .args(["sweep", "study.toml", "--output", output, "--jobs", "2"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

#[test]
fn a_sweep_killed_ten_times_ends_like_one_left_alone() {
    let folder = folder(&study());
    let at = folder.path();
    let alone = json(at, &["sweep", "study.toml", "--output", "alone", "--json"]);
    assert_eq!(alone["points"], POINTS);
    assert_eq!(alone["computed"], POINTS);
    assert!(alone["named"].as_u64().unwrap() > POINTS as u64);

    let seconds = alone["seconds"].as_f64().unwrap();
    let mut kept = HashSet::new();
    for kill in 0..10 {
        let mut child = killable(at, "killed");
        // Somewhere in the run: long before its end, and sometimes right at its start.
        let share = f64::from((kill * 37 + 5) % 100) / 100.0;
        thread::sleep(Duration::from_secs_f64(
            0.02 + share * (seconds / 4.0).min(0.5),
        ));
        child.kill().unwrap();
        child.wait().unwrap();
        // What was finished once stays so.
        let now: HashSet<_> = at
            .join("killed/points")
            .read_dir()
            .into_iter()
            .flatten()
            .collect_names();
        assert!(kept.is_subset(&now), "a finished point was lost");
        kept = now;
    }
    // Ctrl-C is no worse.
    let mut child = killable(at, "killed");
    thread::sleep(Duration::from_millis(50));
    let interrupt = Process::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(interrupt.unwrap().success());
    child.wait().unwrap();

    let said = json(at, &["sweep", "study.toml", "--output", "killed", "--json"]);
    assert_eq!(said["finished"], POINTS);
    assert!(said["found"].as_u64().unwrap() >= kept.len() as u64);
    assert_eq!(results(&at.join("killed")), results(&at.join("alone")));
    // Two threads lose at most two points a kill.
    let begun: usize = ledger(&at.join("killed")).values().sum();
    assert!(begun <= POINTS + 2 * 11, "{begun}");
    assert!(ledger(&at.join("alone")).values().all(|n| *n == 1));
    let again = json(at, &["sweep", "study.toml", "--output", "killed", "--json"]);
    assert_eq!(again["computed"], 0);
    let names = at
        .join("killed/points")
        .read_dir()
        .into_iter()
        .flatten()
        .collect_names();
    assert_eq!(names.len(), POINTS, "half-written files were swept up");
}

trait Names {
    fn collect_names(self) -> HashSet<String>;
}

impl<I: Iterator<Item = std::io::Result<fs::DirEntry>>> Names for I {
    fn collect_names(self) -> HashSet<String> {
        self.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .filter(|name| Path::new(name).extension().is_some_and(|e| e == "json"))
            .collect()
    }
}

#[test]
fn shards_and_threads_change_nothing() {
    let folder = folder(&study());
    let at = folder.path();
    let run = |output: &str, more: &[&str]| {
        let arguments = [&["sweep", "study.toml", "--output", output, "--json"], more].concat();
        json(at, &arguments)
    };
    run("one", &["--jobs", "1"]);
    run("four", &["--jobs", "4"]);
    assert_eq!(results(&at.join("one")), results(&at.join("four")));

    let sizes: Vec<u64> = ["0/3", "1/3", "2/3"]
        .iter()
        .map(|shard| {
            let said = run(&format!("s{}", &shard[..1]), &["--shard", shard]);
            said["computed"].as_u64().unwrap()
        })
        .collect();
    assert_eq!(sizes.iter().sum::<u64>(), POINTS as u64);
    assert!(sizes.iter().all(|size| *size >= POINTS as u64 / 3));
    // One is missing: it is said which.
    let part = json(at, &["merge", "s0", "s2", "--output", "part", "--json"]);
    assert_eq!(part["missing"].as_array().unwrap().len() as u64, sizes[1]);
    assert_eq!(part["missing"][0], 1);
    let all = json(
        at,
        &["merge", "s0", "s1", "s2", "--output", "all", "--json"],
    );
    assert_eq!(all["missing"], serde_json::json!([]));
    assert_eq!(results(&at.join("all")), results(&at.join("one")));
    // Merged results are a folder like any other.
    assert_eq!(run("all", &[])["computed"], 0);

    // Shards that share a folder, one after the other.
    run("shared", &["--shard", "0/2"]);
    run("shared", &["--shard", "1/2"]);
    assert_eq!(results(&at.join("shared")), results(&at.join("one")));
    assert!(ledger(&at.join("shared")).values().all(|n| *n == 1));
}

#[test]
fn a_point_named_twice_is_computed_once() {
    let text = format!(
        "scene = \"{SCENE}\"\nkernel = [\"csdvs-3\", \"copy.toml\"]\nthreshold = [20, 20.0, {{ on = 20, off = 20 }}]\nseed = [0, 1, 2]\n[[side]]\nside = \"reference\"\nformat = [\"f64\", \"exact\"]\nnoise = [\"none\", {{ shot-hz = 0 }}]\n"
    );
    let folder = folder(&text);
    let at = folder.path();
    let kernel = "name = \"copy\"\nsource = \"test\"\ncentre-surround = 3\n";
    fs::write(at.join("copy.toml"), kernel).unwrap();
    let said = json(at, &["sweep", "study.toml", "--output", "out", "--json"]);
    assert_eq!(said["named"], 2 * 3 * 3 * 2 * 2);
    assert_eq!(said["points"], 1);
    assert_eq!(ledger(&at.join("out")).values().sum::<usize>(), 1);
    // Another content under the same name is another point.
    fs::write(at.join("copy.toml"), kernel.replace("= 3", "= 5")).unwrap();
    let said = json(at, &["sweep", "study.toml", "--output", "other", "--json"]);
    assert_eq!(said["points"], 2);
    refused(
        at,
        &["sweep", "study.toml", "--output", "out"],
        &[
            "out holds the study \"study\" (1 point), not \"study\" (2 points)",
            "the content of a scene, a kernel or a chip",
            "another --output",
        ],
    );
    refused(
        at,
        &["merge", "out", "other", "--output", "both"],
        &["other holds the study", "their keys are the same"],
    );
    assert!(!at.join("both").exists());
}

#[test]
fn what_differs_from_the_folder_s_study_is_told() {
    let text = format!(
        "scene = \"{SCENE}\"\nkernel = \"dvs\"\nthreshold = 20\n[[side]]\nside = \"reference\"\n[[side]]\nside = \"mesh\"\nlambda = 2\n"
    );
    let folder = folder(&text);
    let at = folder.path();
    amacrine(at, &["sweep", "study.toml", "--output", "out"])
        .assert()
        .success();
    for (set, told) in [
        (
            "threshold=24",
            "`threshold` (side 1, reference; side 2, mesh) is 20 there, 24 here",
        ),
        (
            "reference.format=f32,q8.8",
            "`format` (side 1, reference) is f64 there, f32, q8.8 here",
        ),
        (
            "frames=3",
            "`frames` (side 1, reference; side 2, mesh) is left out there, 3 here",
        ),
        ("within=2ms", "`within` is left out there, 2000 us here"),
        (
            "sample={method=sobol,points=2}",
            "`sample` is left out there, sobol, 2 points",
        ),
    ] {
        let set = set.replace("method=sobol", "method=\"sobol\"");
        refused(
            at,
            &["sweep", "study.toml", &set, "--output", "out"],
            &[told],
        );
    }
}

#[test]
fn a_part_of_a_scene_is_a_point_of_its_own() {
    let text = "scene = \"pattern:disc?width=32&height=24&frames=8&radius=6\"\nkernel = \"dvs\"\nthreshold = 20\n[[side]]\nside = \"reference\"\n";
    let folder = folder(text);
    let at = folder.path();
    let rows = |sets: &[&str], name: &str| {
        let sweep = [
            &["sweep", "study.toml"],
            sets,
            &["--output", name, "--json"],
        ]
        .concat();
        json(at, &sweep);
        let lines = fs::read_to_string(at.join(name).join("results.jsonl")).unwrap();
        let rows = lines
            .lines()
            .map(|line| serde_json::from_str(line).unwrap());
        rows.collect::<Vec<Value>>()
    };
    let whole = rows(&["slice=.."], "whole");
    assert_eq!((&whole[0]["slice"], whole.len()), (&Value::Null, 1));
    assert_eq!(rows(&[], "plain")[0]["id"], whole[0]["id"]);
    let parts = rows(
        &["slice=..,2..7", "crop=20x16+4+2", "resize=10x8", "frames=4"],
        "parts",
    );
    assert_eq!(parts.len(), 2);
    for (row, slice) in parts.iter().zip([Value::Null, "2..7".into()]) {
        let seen = ["width", "height", "frames_seen"].map(|name| row[name].as_u64());
        assert_eq!(seen, [Some(10), Some(8), Some(4)]);
        assert_eq!(row["slice"], slice);
        assert_eq!(
            (&row["crop"], &row["resize"]),
            (&"20x16+4+2".into(), &"10x8".into())
        );
        assert_ne!(row["id"], whole[0]["id"]);
    }
    // As the verb shows it.
    let how = ["--slice", "2..7", "--crop", "20x16+4+2", "--resize", "10x8"];
    let sensor = "memory = \"filtered-snap\"\n[[channel]]\nkernel = \"dvs\"\nthreshold = { on = 20, off = 20 }\n";
    fs::write(
        at.join("sensor.toml"),
        format!("response = \"identity\"\n{sensor}"),
    )
    .unwrap();
    let scene = "pattern:disc?width=32&height=24&frames=8&radius=6";
    let run = ["run", "--scene", scene, "--sensor", "sensor.toml", "--json"];
    let own = rows(&how_of(&how)[..], "own");
    assert_eq!(
        own[0]["events"],
        json(at, &[&run[..], &how].concat())["events"]
    );
    for (set, words) in [
        ("slice=x", "`slice` is `x`"),
        (
            "crop=40x40",
            "the crop 40x40 does not lie within pictures of 32x24",
        ),
        ("resize=64x64", "cannot be enlarged to 64x64"),
        ("resize=x", "`resize` is `x`"),
        ("slice=9..", "the slice 9.. holds no frame"),
    ] {
        let key = set.split_once('=').unwrap().0;
        let line = format!("{key} =");
        refused(
            at,
            &["sweep", "study.toml", set, "--output", "no"],
            &[words, &line],
        );
    }
}

/// Options of a verb as keys of a study.
fn how_of<'a>(options: &[&'a str]) -> Vec<&'a str> {
    let pairs = options.chunks(2);
    let keys = pairs.map(|pair| format!("{}={}", pair[0].trim_start_matches('-'), pair[1]));
    keys.map(|key| &*key.leak()).collect()
}

#[test]
fn rows_say_what_was_measured() {
    let folder = folder(&study());
    let at = folder.path();
    json(at, &["sweep", "study.toml", "--output", "out", "--json"]);
    let lines = fs::read_to_string(at.join("out/results.jsonl")).unwrap();
    let rows: Vec<Value> = lines
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(rows.len(), POINTS);
    let csv = csv_reader(&at.join("out/results.csv"));
    let schema = Study::parse("study.toml", &study()).unwrap().settings;
    assert_eq!(csv[0], table::names(&schema));
    for (index, (row, cells)) in rows.iter().zip(&csv[1..]).enumerate() {
        assert_eq!(row["index"], index);
        for (name, cell) in csv[0].iter().zip(cells) {
            let same = match &row[name] {
                Value::Null => cell.is_empty(),
                Value::String(text) => text == cell,
                other => *cell == format!("{other}"),
            };
            assert!(same, "{name}: {} and {cell}", row[name]);
        }
    }
    let find = |wanted: &[(&str, Value)]| {
        let has = |row: &&Value| wanted.iter().all(|(name, value)| row[*name] == *value);
        rows.iter()
            .find(has)
            .unwrap_or_else(|| panic!("{wanted:?}"))
            .clone()
    };
    let word = |word: &str| Value::from(word);
    // The f64 sensor against itself.
    for rule in ["filtered-snap", "filtered-step"] {
        let own = find(&[
            ("format", word("f64")),
            ("rule", word(rule)),
            ("kernel", word("laplacian")),
        ]);
        assert_eq!(
            (&own["error"], &own["f1_1ms"]),
            (&Value::from(0.0), &Value::from(1.0))
        );
        assert_eq!(own["events"], own["reference_events"]);
        assert!(own["events"].as_u64().unwrap() > 50);
        assert_eq!(own["bits"], own["events"].as_u64().unwrap() * 11);
        assert!(own["events_per_s"].as_f64().unwrap() > 0.0);
    }
    // The program of a dyadic kernel in exact arithmetic: the float sensor's own events.
    let exact = [("kernel", word("laplacian")), ("quantise", word("none"))];
    let exact = find(&[&exact[..], &[("domain", word("exact"))]].concat());
    assert_eq!(exact["error"], 0.0);
    for row in rows.iter().filter(|row| row["outcome"] == "done") {
        let number = |name: &str| row[name].as_f64().unwrap();
        // The first window of the study.
        assert_eq!(row["window_us"], 1_000);
        assert!(row["fps"].as_f64().unwrap() > 0.0);
        let kept = (number("f1_1ms") - number("floor")) / (1.0 - number("floor"));
        assert!((number("kept") - kept).abs() < 1e-12, "{row}");
        assert_eq!(number("error"), 1.0 - number("kept"));
        let percent = number("threshold_equivalent_percent");
        assert_eq!(percent == 0.0, number("kept") == 1.0, "{row}");
    }
    // Seven analogue registers and PIX of 8 bytes, thirteen bits and FLAG.
    assert_eq!(
        exact["state_memory_bytes"],
        32 * 24 * (8 * 8) + 32 * 24 * 14 / 8
    );
    assert!(exact["words"].as_u64().unwrap() > 10);
    let silicon = [("kernel", word("laplacian")), ("domain", word("silicon"))];
    let seeds = [1, 2].map(|seed| find(&[&silicon[..], &[("seed", Value::from(seed))]].concat()));
    assert!(seeds[0]["error"].as_f64().unwrap() > 0.0);
    assert_ne!(seeds[0]["error"], seeds[1]["error"]);
    // Sums and halves do not make twenty-fourths.
    let cannot = find(&[("kernel", word("csdvs-5")), ("quantise", word("none"))]);
    let why = cannot["reason"].as_str().unwrap();
    assert!(why.contains("multiple of 1/4096"), "{why}");
    assert_eq!(
        (&cannot["outcome"], &cannot["events"]),
        (&word("refused"), &Value::Null)
    );
    // v2e's mesh is not the exact one.
    let mesh = |solver: &str| find(&[("solver", word(solver)), ("lambda", Value::from(4.0))]);
    assert_eq!(mesh("ramp")["error"], 0.0);
    assert!(mesh("v2e")["error"].as_f64().unwrap() > 0.0);
}

/// The window follows the frame rate of each scene; metrics that are asked for have one of their
/// own; the ladder can be left out.
#[test]
fn the_headline_s_window_is_that_of_the_scene() {
    let text = "scene = \"pattern:disc?width=32&height=24&frames=8&radius=6\"\nfps = [5, 40]\nkernel = \"laplacian\"\nthreshold = 20\nmetrics = [\"kept\", \"f1\"]\nthreshold-equivalent = false\n[[side]]\nside = \"reference\"\nformat = \"f16\"\n";
    let folder = folder(text);
    let at = folder.path();
    json(at, &["sweep", "study.toml", "--output", "out", "--json"]);
    let lines = fs::read_to_string(at.join("out/results.jsonl")).unwrap();
    let windows: Vec<_> = { lines.lines() }
        .map(|line| {
            let row: Value = serde_json::from_str(line).unwrap();
            assert!(row["threshold_equivalent_percent"].is_null());
            assert!(row["f1_100ms"].is_number() && row["kept_100ms"].is_number());
            (
                row["fps"].as_f64().unwrap(),
                row["window_us"].as_u64().unwrap(),
            )
        })
        .collect();
    assert_eq!(windows, [(5.0, 200_000), (40.0, 100_000)]);
    let report = json(at, &["report", "out", "--json"]);
    let sensor = &report["groups"][0]["sensors"][0];
    assert!(sensor["threshold_equivalent_percent"].is_null());
}

#[test]
fn a_kernel_that_does_not_fit_the_chip_is_a_row() {
    let folder = folder(&format!(
        "scene = \"{SCENE}\"\nkernel = [\"large.toml\", \"other.toml\"]\nthreshold = 20\neffort = 0\n[[side]]\nside = \"array\"\nquantise = \"q1.11\"\n[[side]]\nside = \"reference\"\n"
    ));
    for (name, by) in [("large", 7), ("other", 11)] {
        let row = |y: i32| -> Vec<f64> {
            (0..15)
                .map(|x| f64::from((x * x * by + y * 13 + x * y * 5) % 2039) / 2039.0)
                .collect()
        };
        let rows: Vec<_> = (0..15).map(row).collect();
        let text = format!("name = \"{name}\"\nsource = \"test\"\nweights = {rows:?}\n");
        fs::write(folder.path().join(format!("{name}.toml")), text).unwrap();
    }
    let said = json(
        folder.path(),
        &["sweep", "study.toml", "--output", "out", "--json"],
    );
    assert_eq!(said["finished"], 4);
    let report = json(folder.path(), &["report", "out", "--json"]);
    assert_eq!(report["refused"][0]["reasons"], 2, "{report}");
    let told = good(folder.path(), &["report", "out"]);
    assert!(told.contains("(2 points): the first of them: "), "{told}");
    let why = report["refused"][0]["reason"].as_str().unwrap();
    assert!(
        why.contains("more than the 1024 that scamp5 holds"),
        "{why}"
    );
    assert_eq!(report["groups"][0]["sensors"][0]["name"], "reference f64");
}

#[test]
fn samples_are_reproducible_and_differ_by_seed() {
    let text = |method: &str, seed: u64| {
        format!(
            "scene = \"{SCENE}\"\nkernel = [\"csdvs-3\", \"laplacian\", \"dvs\"]\nthreshold = {{ from = 8, to = 64, log = true }}\nsample = {{ method = \"{method}\", points = 40, seed = {seed} }}\n[[side]]\nside = \"reference\"\nformat = [\"f64\", \"f16\"]\n[[side]]\nside = \"mesh\"\nlambda = {{ from = 1, to = 9 }}\n"
        )
    };
    let points = |method, seed| {
        let study = Study::parse("s.toml", &text(method, seed)).unwrap();
        study.points().unwrap()
    };
    for method in ["random", "sobol"] {
        assert_eq!(points(method, 1), points(method, 1));
        assert_ne!(points(method, 1), points(method, 2));
        assert_eq!(points(method, 1).len(), 40);
        for point in points(method, 3) {
            let [on, off, _] = point.thresholds().unwrap().of(0);
            assert!((8.0..=64.0).contains(&on) && on == off);
        }
    }
    // Sobol's first 32 points have each side half of the time.
    let sides = points("sobol", 5);
    let reference = sides[..32].iter().filter(|p| p.side() == Side::Reference);
    assert_eq!(reference.count(), 16);
}

#[test]
fn the_report_names_what_is_beaten_and_draws_it() {
    let folder = folder(&study());
    let at = folder.path();
    json(at, &["sweep", "study.toml", "--output", "out", "--json"]);
    let report = json(at, &["report", "out", "--cost", "words", "--json"]);
    let all = |group: &Value| group["sensors"].as_array().unwrap().clone();
    let groups = report["groups"].as_array().unwrap();
    // Only arrays have words; by the definition, slowly.
    let sensors: Vec<Value> = groups.iter().flat_map(all).collect();
    assert!(sensors.iter().all(|s| s["side"] == "array"));
    for group in groups {
        for a in &all(group) {
            let cost = |s: &Value| (s["cost"].as_f64().unwrap(), s["error"].as_f64().unwrap());
            let beaten = all(group).iter().any(|b| {
                let ((x, y), (bx, by)) = (cost(a), cost(b));
                bx <= x && by <= y && (bx < x || by < y)
            });
            assert_eq!(beaten, !a["dominated_by"].is_null(), "{a}");
        }
    }
    // What error is weighed against is printed once.
    for (cost, column) in [
        ("bits", "bits"),
        ("words", "words"),
        ("seconds_per_frame", "bits"),
    ] {
        let text = good(at, &["report", "out", "--cost", cost]);
        let heading = text
            .lines()
            .find(|line| line.starts_with("  sensor "))
            .unwrap();
        assert_eq!(heading.matches(column).count(), 1, "{text}");
    }
    for file in ["front.svg", "front.png"] {
        amacrine(at, &["report", "out", "-o", file])
            .assert()
            .success();
    }
    let svg = fs::read_to_string(at.join("front.svg")).unwrap();
    for words in [
        "reference filtered-snap f64",
        "array as is exact",
        "time per frame",
    ] {
        assert!(svg.contains(words), "no {words}");
    }
    assert!(image::open(at.join("front.png")).unwrap().width() > 1000);
    refused(
        at,
        &["report", "out", "-o", "front.pdf"],
        &["front.pdf", ".svg or .png"],
    );
    refused(at, &["report", "nowhere"], &["nowhere"]);
}

/// What a study begins with, and its only side.
fn head() -> (String, &'static str) {
    let head = format!("scene = \"{SCENE}\"\nkernel = \"dvs\"\nthreshold = 20\n");
    (head, "[[side]]\nside = \"reference\"\n")
}

/// Every message names the file, line and column, and what to do, before anything is computed.
#[track_caller]
fn all_refused(cases: &[(String, &[&str])]) {
    for (text, words) in cases {
        let folder = folder(text);
        refused(
            folder.path(),
            &["sweep", "study.toml", "--output", "out"],
            words,
        );
        assert!(
            !folder.path().join("out").exists(),
            "{words:?} left a folder"
        );
    }
}

#[test]
fn wrong_keys_and_contradictions_are_refused_in_one_message() {
    let (head, side) = head();
    all_refused(&[
        (
            format!("{head}kernle = \"dvs\"\n{side}"),
            &[
                "study.toml:4:1",
                "unknown key `kernle`",
                "did you mean `kernel`",
            ],
        ),
        (
            format!("{head}{side}formt = \"f64\"\n"),
            &[
                "study.toml:6:1",
                "unknown key `formt`",
                "did you mean `format`",
            ],
        ),
        (
            format!("{head}{side}format = []\n"),
            &[
                "study.toml:6:10",
                "`format` has no values: the grid is empty",
            ],
        ),
        (head.clone(), &["study.toml:1:1", "there is no [[side]]"]),
        (
            format!("{head}{side}seed = {{ from = 0, to = 999999999 }}\nnoise = \"noisy\"\n"),
            &[
                "study.toml:6:8",
                "1000000000 points",
                "1000000000 seed",
                "sample = ",
            ],
        ),
        (
            format!("{head}{side}domain = \"exact\"\n"),
            &[
                "study.toml:6:1",
                "side = \"reference\" has no `domain`",
                "`format` in place",
            ],
        ),
        (
            format!(
                "{head}{side}memory = [\"filtered-step\", \"raw-snap\"]\nnoise = [\"none\", \"noisy\"]\n"
            ),
            &[
                "study.toml:7:18",
                "this memory holds pixels",
                "a [[side]] of their own",
            ],
        ),
        (
            format!("{head}{side}memory = \"filtered-step\"\npolarity = \"pixel\"\n"),
            &["study.toml:7:12", "polarity = \"pixel\" needs"],
        ),
        (
            format!(
                "scene = \"{SCENE}\"\nthreshold = 9\nagainst = \"raw-snap\"\n[[side]]\nside = \"mesh\"\nlambda = 3\n"
            ),
            &["study.toml:4:1", "a mesh stands in place of a kernel"],
        ),
        (
            format!("{head}lambda = 3\n{side}"),
            &[
                "study.toml:4:1",
                "`lambda` is set, and no side of this study has it",
                "\"mesh\"",
            ],
        ),
        (
            format!("{head}effort = 2\n{side}"),
            &[
                "study.toml:4:10",
                "`effort` is of programs, and no side of this study searches for one",
                "side = \"array\"",
            ],
        ),
        (
            format!("{head}threshold = 3\n{side}"),
            &["study.toml:4:1", "duplicate key"],
        ),
    ]);
}

#[test]
fn wrong_values_and_names_are_refused_in_one_message() {
    let (head, side) = head();
    all_refused(&[
        (
            head.replace("20", "{ from = 1, to = 9 }") + side,
            &["study.toml:3:13", "a range without `steps`", "steps = 5"],
        ),
        (
            head.replace("20", "[20, -1]") + side,
            &["study.toml:3:18", "`threshold` is -1", "above 0"],
        ),
        (
            head.replace(SCENE, "none.npy") + side,
            &["study.toml:1:9", "none.npy"],
        ),
        (
            head.replace(SCENE, "pattern:dics") + side,
            &["study.toml:1:9", "dics", "disc"],
        ),
        (
            head.replace(SCENE, "pattern:disc?frames=1&width=8&height=8") + side,
            &["study.toml:1:9", "has 1 frame"],
        ),
        // What is to be said is a key of the study, not an option of the command line.
        (
            head.replace(
                SCENE,
                concat!(env!("CARGO_MANIFEST_DIR"), "/tests/bad/scene/no_rate.y4m"),
            ) + side,
            &["study.toml:1:9", "no_rate.y4m", "say it: fps = N"],
        ),
        (
            head.replace("\"dvs\"", "[\"dvs\", \"dvd\"]") + side,
            &["study.toml:2:18", "cannot read the kernel dvd", "csdvs-5"],
        ),
        (
            format!("{head}[[side]]\nside = \"array\"\nchip = \"scamp6\"\n"),
            &["study.toml:6:8", "scamp6", "scamp5"],
        ),
        (
            format!("{head}[[side]]\nside = \"array\"\nquantise = \"ternery\"\n"),
            &["study.toml:6:12", "ternery", "po2-N"],
        ),
        (
            format!("{head}[[side]]\nside = \"chip\"\n"),
            &["study.toml:5:8", "unknown value `chip`", "array"],
        ),
        (
            format!("{head}metrics = [\"f1\", \"f2\"]\n{side}"),
            &["study.toml:4:18", "unknown value `f2`", "did you mean `f1`"],
        ),
        (
            format!("{head}sample = {{ method = \"sobol\", points = 0 }}\n{side}"),
            &["study.toml:4:39", "`sample.points` is 0"],
        ),
        ("scene = ".to_owned(), &["study.toml:1:", "not TOML"]),
    ]);
    let folder = folder(&(head + side));
    refused(
        folder.path(),
        &["sweep", "no.toml"],
        &["no.toml", "list studies"],
    );
    for shard in ["2/2", "x", "1"] {
        refused(
            folder.path(),
            &["sweep", "study.toml", "--shard", shard],
            &["is no shard", "0/4"],
        );
    }
}

#[test]
fn folders_of_others_are_left_alone() {
    let text = format!(
        "scene = \"{SCENE}\"\nkernel = \"dvs\"\nthreshold = 20\n[[side]]\nside = \"reference\"\n"
    );
    let folder = folder(&text);
    let at = folder.path();
    let sweep = ["sweep", "study.toml", "--output", "out"];
    fs::create_dir(at.join("out")).unwrap();
    fs::write(at.join("out/thesis.txt"), "mine").unwrap();
    refused(at, &sweep, &["out is not a folder of results", "--output"]);
    assert_eq!(fs::read(at.join("out/thesis.txt")).unwrap(), b"mine");
    fs::remove_dir_all(at.join("out")).unwrap();

    amacrine(at, &sweep).assert().success();
    // Another process works there.
    let lock = fs::File::open(at.join("out/lock")).unwrap();
    lock.try_lock().unwrap();
    refused(at, &sweep, &["out is in use by another amacrine", "merge"]);
    let into = ["merge", "other", "--output", "out"];
    fs::create_dir(at.join("other")).unwrap();
    fs::copy(at.join("out/sweep.json"), at.join("other/sweep.json")).unwrap();
    refused(at, &into, &["out is in use by another amacrine"]);
    fs::remove_dir_all(at.join("other")).unwrap();
    drop(lock);

    // A point that was damaged is named, and made again.
    let point = at
        .join("out/points")
        .read_dir()
        .unwrap()
        .next()
        .unwrap()
        .unwrap()
        .path();
    fs::write(&point, "{\"id\":").unwrap();
    refused(
        at,
        &["report", "out"],
        &[
            "1 file of points is damaged",
            "sets the damaged files aside",
        ],
    );
    let said = json(at, &[&sweep[..], &["--json"]].concat());
    assert_eq!(
        (&said["computed"], &said["damaged"][0]["point"]),
        (&1.into(), &0.into())
    );

    let said = fs::read_to_string(at.join("out/sweep.json")).unwrap();
    let before = fs::read(&point).unwrap();
    let version = format!("\"amacrine\": \"{}\"", env!("CARGO_PKG_VERSION"));
    assert!(said.contains(&version));
    fs::write(
        at.join("out/sweep.json"),
        said.replace(&version, "\"amacrine\": \"0.0.1\""),
    )
    .unwrap();
    refused(
        at,
        &sweep,
        &["out was made by amacrine 0.0.1", "nothing was changed"],
    );
    let schema = format!("\"schema\": {SCHEMA}");
    assert!(said.contains(&schema));
    fs::write(
        at.join("out/sweep.json"),
        said.replace(&schema, "\"schema\": 99"),
    )
    .unwrap();
    refused(at, &sweep, &["results version 99"]);
    assert_eq!(fs::read(&point).unwrap(), before);
}

/// A limit on the size of files stands for a disk that is full: a write fails half way.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_loses_nothing() {
    let folder = folder(&study());
    let at = folder.path();
    let program = assert_cmd::cargo::cargo_bin("amacrine");
    // A point and sweep.json take less than 12 KiB, the table of all more.
    let limited = |blocks: u32| {
        let script = format!(
            "trap '' XFSZ; ulimit -f {blocks}; exec {} sweep study.toml --output out",
            program.display()
        );
        let mut bash = Process::new("bash");
        bash.args(["-c", &script])
            .current_dir(at)
            .env("NO_COLOR", "1");
        let said = bash.output().unwrap();
        let message = String::from_utf8_lossy(&said.stderr).into_owned();
        assert_eq!(said.status.code(), Some(2), "{message}");
        assert!(message.contains("cannot write"), "{message}");
        assert!(message.contains("are kept"), "{message}");
        assert_eq!(message.matches("×").count(), 1, "one message: {message}");
    };
    limited(12);
    assert!(!at.join("out/results.csv").exists());
    let said = json(at, &["sweep", "study.toml", "--output", "out", "--json"]);
    assert_eq!(
        (&said["computed"], &said["found"]),
        (&Value::from(0), &Value::from(POINTS))
    );
    // Nothing at all can be written: nothing is there, and nothing is in the way.
    fs::remove_dir_all(at.join("out")).unwrap();
    limited(0);
    let said = json(at, &["sweep", "study.toml", "--output", "out", "--json"]);
    assert_eq!(said["computed"], POINTS);
}

#[test]
fn the_schema_is_what_is_read() {
    let printed = json(Path::new("."), &["sweep", "--schema"]);
    assert_eq!(printed, schema::json_schema());
    let names = |value: &Value| -> HashSet<String> {
        value["properties"]
            .as_object()
            .unwrap()
            .keys()
            .cloned()
            .collect()
    };
    let mut top: HashSet<String> = SETTINGS.iter().map(|key| key.name.to_owned()).collect();
    top.insert("side".to_owned());
    for (side, own) in Side::ALL.iter().zip(
        printed["properties"]["side"]["items"]["oneOf"]
            .as_array()
            .unwrap(),
    ) {
        let mut keys: HashSet<String> =
            Key::on_side(*side).map(|key| key.name.to_owned()).collect();
        top.extend(keys.iter().cloned());
        keys.insert("side".to_owned());
        assert_eq!(names(own), keys);
        // What the schema names is read, each at the value that it has when it is left out.
        let mut text = String::new();
        for key in Key::on_side(*side) {
            match (key.default, key.name) {
                (Absent::Is(value), name) => writeln!(text, "{name} = {value}").unwrap(),
                (_, "scene") => writeln!(text, "scene = \"{SCENE}\"").unwrap(),
                (_, "kernel") => text += "kernel = \"dvs\"\n",
                (_, "frames") => text += "frames = 3\n",
                (_, "slice") => text += "slice = \"2..7\"\n",
                (_, "crop" | "resize") => writeln!(text, "{} = \"8x6\"", key.name).unwrap(),
                (_, name) => writeln!(text, "{name} = 10").unwrap(),
            }
        }
        let study =
            Study::parse("s.toml", &format!("[[side]]\nside = \"{side}\"\n{text}")).unwrap();
        assert_eq!(study.points().unwrap().len(), 1);
        let above =
            Study::parse("s.toml", &format!("{text}[[side]]\nside = \"{side}\"\n")).unwrap();
        assert_eq!(above.points().unwrap(), study.points().unwrap());
    }
    assert_eq!(names(&printed), top);
}

/// The tables of docs/sweeps.md are those of the code.
#[test]
fn the_documentation_lists_every_key_and_column() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let docs = fs::read_to_string(root.join("docs/sweeps.md")).unwrap();
    let keys = schema::key_table();
    assert!(docs.contains(&keys), "docs/sweeps.md should have:\n{keys}");
    for (name, what) in METRICS {
        assert!(
            docs.contains(&format!("| `{name}` | {what} |\n")),
            "{name}: {what}"
        );
    }
    let formats = fs::read_to_string(root.join("studies/formats.toml")).unwrap();
    assert!(
        docs.contains(&formats),
        "the worked example is studies/formats.toml"
    );
    let columns = table::column_table(&Study::parse("formats.toml", &formats).unwrap().settings);
    assert!(
        docs.contains(&columns),
        "docs/sweeps.md should have:\n{columns}"
    );
}

#[test]
fn the_shipped_studies_have_the_points_they_say() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies");
    let files = root.read_dir().unwrap().map(|entry| entry.unwrap().path());
    let studies: Vec<_> = files
        .filter(|path| path.extension().is_some_and(|ending| ending == "toml"))
        .collect();
    assert!(!studies.is_empty(), "no study in {}", root.display());
    for path in studies {
        let text = fs::read_to_string(&path).unwrap();
        let study = Study::parse(&path.display().to_string(), &text).unwrap();
        let points = study.points().unwrap().len();
        // The whole number: "1100 points" does not say 100.
        let said = text.split_once(" points").unwrap_or_default().0;
        let said = said.rsplit(|c: char| !c.is_ascii_digit()).next();
        assert_eq!(
            said,
            Some(&*points.to_string()),
            "{} has {points}",
            path.display()
        );
    }
}

/// Points of a shard that are kept, with the times at which they were written.
type Kept = HashSet<(String, SystemTime)>;

fn kept_points(shard: &Path) -> Kept {
    let points = shard.join("points").read_dir().into_iter();
    let written = points.flatten().filter_map(|entry| {
        let entry = entry.ok()?;
        let name = entry.file_name().into_string().ok()?;
        // What is half-written has another name.
        let is_whole = name.len() == "00000000000000000000000000000000.json".len();
        is_whole.then_some((name, entry.metadata().ok()?.modified().ok()?))
    });
    written.collect()
}

/// Waits until some points of a shard are kept, or the process is over.
fn wait_for_points(shard: &Path, process: &mut Child) {
    while kept_points(shard).len() < 2 && process.try_wait().unwrap().is_none() {
        thread::sleep(Duration::from_millis(2));
    }
}

/// The points that are kept of the first of three shards when its computation is killed in the
/// middle: where it was over before, it is begun anew.
fn killed_midway(shard: &Path, mut kill: impl FnMut() -> Kept) -> Kept {
    let midway = |kept: &Kept| (2..POINTS / 3).contains(&kept.len());
    let mut tries = (0..20).map(|_| {
        let _ = fs::remove_dir_all(shard);
        kill()
    });
    tries.find(midway).expect("it is killed in the middle")
}

/// What a killed shard had kept is there as it was, and was not computed again: at most the point in
/// flight was begun twice.
fn went_on(shard: &Path, kept: &Kept) {
    assert!(
        kept.is_subset(&kept_points(shard)),
        "a point was lost or written again"
    );
    let begun = ledger(shard);
    assert_eq!(begun.len(), POINTS / 3);
    let total: usize = begun.values().sum();
    assert!(total <= begun.len() + 1, "{begun:?}");
}

/// The number of the process that runs this program with this argument.
fn process_of(program: &Path, argument: &str) -> Option<String> {
    let processes = Path::new("/proc").read_dir().unwrap().flatten();
    let mut names = processes.map(|entry| entry.file_name().to_string_lossy().into_owned());
    names.find(|name| {
        let line = fs::read(format!("/proc/{name}/cmdline")).unwrap_or_default();
        let mut words = line.split(|byte| *byte == 0);
        words.next() == Some(program.as_os_str().as_encoded_bytes())
            && words.any(|word| word == argument.as_bytes())
    })
}

/// The cluster examples run: the array job's script as SLURM would start it, Dask, Ray and Snakemake as
/// themselves; a job of SLURM's script and one of Snakemake are killed in the middle. Needs `python3`
/// with `examples/cluster/requirements.txt`; `AMACRINE_PYTHON` names another.
#[test]
#[ignore = "needs Dask, Ray and Snakemake; CI runs it by name"]
fn the_cluster_examples_run() {
    let folder = folder(&study());
    let at = folder.path();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/cluster");
    let program = assert_cmd::cargo::cargo_bin("amacrine");
    let slurm = |index: u32| {
        let mut bash = Process::new("bash");
        bash.arg(root.join("slurm.sh"))
            .args(["study.toml", "slurm"])
            .current_dir(at)
            .env("AMACRINE", &program)
            .env("SLURM_ARRAY_TASK_ID", index.to_string())
            .env("SLURM_ARRAY_TASK_COUNT", "3")
            .env("SLURM_CPUS_PER_TASK", "1");
        bash
    };
    // A task that is killed goes on when it is submitted again.
    let shard = at.join("slurm/shard-0");
    let kept = killed_midway(&shard, || {
        let mut task = slurm(0).stdout(Stdio::null()).spawn().unwrap();
        wait_for_points(&shard, &mut task);
        task.kill().unwrap();
        task.wait().unwrap();
        kept_points(&shard)
    });
    for index in 0..3 {
        assert!(slurm(index).status().unwrap().success());
    }
    went_on(&shard, &kept);
    let shards = ["slurm/shard-0", "slurm/shard-1", "slurm/shard-2"];
    let merge = [
        &["merge"],
        &shards[..],
        &["--output", "slurm/all", "--json"],
    ]
    .concat();
    assert_eq!(json(at, &merge)["finished"], POINTS);
    let python = std::env::var("AMACRINE_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let dask = Process::new(&python)
        .arg(root.join("dask_sweep.py"))
        .args(["study.toml", "dask", "--shards", "3", "--program"])
        .arg(&program)
        .current_dir(at)
        .status();
    assert!(dask.unwrap().success());
    // Its raylet has 30 seconds to start, which a busy machine may not give it.
    let ray = || {
        Process::new(&python)
            .arg(root.join("ray_sweep.py"))
            .args(["study.toml", "ray", "--shards", "3", "--program"])
            .arg(&program)
            .current_dir(at)
            .status()
            .unwrap()
            .success()
    };
    assert!(ray() || ray());
    // A job that is killed goes on where it was; a second run has nothing to do.
    let snakemake = || {
        let mut run = Process::new(&python);
        run.args(["-m", "snakemake", "--cores", "2", "--quiet", "all"])
            .arg("--snakefile")
            .arg(root.join("Snakefile"))
            .args([
                "--config",
                "study=study.toml",
                "output=snakemake",
                "shards=3",
            ])
            .arg(format!("program={}", program.display()))
            .current_dir(at);
        run
    };
    let shard = at.join("snakemake/shard-0");
    let kept = killed_midway(&shard, || {
        // With all of its results there is nothing to do.
        let _ = fs::remove_dir_all(at.join("snakemake"));
        let mut run = snakemake().spawn().unwrap();
        wait_for_points(&shard, &mut run);
        // It may be over by now: what was kept says whether it was killed in time.
        if let Some(job) = process_of(&program, "snakemake/shard-0") {
            let kill = format!("kill -KILL {job}");
            let _ = Process::new("bash").args(["-c", &kill]).status().unwrap();
        }
        let kept = kept_points(&shard);
        // It tries the job again itself.
        assert!(run.wait().unwrap().success());
        kept
    });
    went_on(&shard, &kept);
    let begun = ledger(&shard);
    assert!(snakemake().status().unwrap().success());
    assert_eq!(ledger(&shard), begun);
    for engine in ["dask", "ray", "snakemake"] {
        assert_eq!(
            results(&at.join(engine).join("all")),
            results(&at.join("slurm/all")),
            "{engine}"
        );
    }
}

/// Without an event there is no error either, and a point that cannot be is not silent.
#[test]
fn points_that_say_nothing_are_told() {
    let text = format!(
        "scene = \"{SCENE}\"\nkernel = \"csdvs-5\"\nthreshold = [2000, 20]\n[[side]]\nside = \"reference\"\nformat = \"f32\"\n\
         [[side]]\nside = \"array\"\nquantise = \"ternary\"\n"
    );
    let folder = folder(&text);
    let sweep = ["sweep", "study.toml", "--output", "out", "--threads", "1"];
    let said = json(folder.path(), &sweep);
    assert_eq!(said["jobs"], 1);
    let rows = csv_reader(&folder.path().join("out/results.csv"));
    let outcome = rows[0].iter().position(|name| name == "outcome").unwrap();
    let refused = rows.iter().filter(|row| row[outcome] == "refused").count();
    assert_eq!(said["refused"], refused);
    let warned = |said: &Value| {
        let warnings = said["warnings"].as_array().unwrap().clone();
        warnings.iter().any(|it| {
            it["about"] == "no-events" && it["subjects"].to_string().contains("of 4 points")
        })
    };
    assert!(warned(&said), "{said}");
    let report = json(folder.path(), &["report", "out"]);
    assert!(warned(&report));
    // The silent point is no perfect one.
    let text = fs::read_to_string(folder.path().join("out/results.jsonl")).unwrap();
    let rows = text
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).unwrap());
    let silent: Vec<Value> = rows.filter(|row| row["events"] == 0).collect();
    assert!(!silent.is_empty());
    for row in &silent {
        for column in ["kept", "error", "threshold_equivalent_percent"] {
            assert!(row[column].is_null(), "{column}: {row}");
        }
    }
    let why = report["without"][0]["no_error"].as_str().unwrap();
    assert!(
        why.contains("neither the float sensor nor this one has an event"),
        "{why}"
    );
}

/// A key that two sides have is listed once.
#[test]
fn keys_that_are_known_are_listed_once() {
    let (head, side) = head();
    let folder = folder(&format!("{head}shape = 3\n{side}"));
    let run = ["sweep", "study.toml", "-o", "out"];
    let said = refused(folder.path(), &run, &["unknown key `shape`"]);
    let list = said.split("expected").nth(1).unwrap();
    assert_eq!(list.matches("`memory`").count(), 1, "{said}");
}

/// What a table of errors against bits must say: numbers that cannot hold the light, or what a
/// program puts into cells, and events that found no slot.
#[test]
fn saturated_formats_and_full_slots_are_told() {
    let text = "scene = \"bundled\"\nframes = 3\nkernel = \"rgc-5x5\"\nthreshold = 8\nsum = \"free\"\n\
                [[side]]\nside = \"reference\"\nformat = [\"f64\", \"q4.4\"]\n\
                [[side]]\nside = \"array\"\nquantise = \"ternary\"\ndomain = \"exact\"\nreadout = [\"chip\", \"all\"]\n\
                [[side]]\nside = \"array\"\nquantise = \"ternary\"\ndomain = \"q7.9\"\nreadout = \"all\"\n";
    let folder = folder(text);
    let run = ["sweep", "study.toml", "-o", "out"];
    let out = amacrine(folder.path(), &run).output().unwrap();
    assert!(out.status.success(), "{out:?}");
    let said = common::line(&out.stderr);
    for words in [
        "1 of 5 points (here the worst): the readout's slots were full",
        "2 of 5 points: signals or drives lie beyond the range of their number format",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let again = amacrine(folder.path(), &["report", "out"])
        .output()
        .unwrap();
    assert!(common::line(&again.stderr).contains("slots were full"));
}
