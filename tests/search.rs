//! Proves that a search finds the front of a study at a fraction of its cost, and goes on where it
//! was; that keys set on the command line are the study's own; and that points told one by one are
//! those of a sweep. Against: the whole grid, computed.
#![cfg(feature = "cli")]

mod common;

use std::{fs, path::Path};

use amacrine::{
    rng::Hash,
    study::{front::Cost, sweep::survivors::hypervolume},
};
use common::{amacrine, good, json, line, refused, refused_untouched};
use ndarray::Array3;
use ndarray_npy::write_npy;
use serde_json::{Value, json};
use tempfile::TempDir;

/// Formats with few and many bits, on kernels and thresholds that need them.
const STUDY: &str = r#"
scene = "pattern:noise?width=56&height=48&frames=36&fps=100&speed=40"
kernel = ["csdvs-3", "dvs"]
threshold = [8, 16, 32]
threshold-equivalent = false
metrics = "f1"
[[side]]
side = "reference"
format = ["f64", "f32", "f16", "bf16", "q8.8", "q12.4", "q4.12", "q16.16", "q24.8", "q10.6", "q6.2", "q8.24"]
memory = ["filtered-snap", "filtered-step"]
"#;
const POINTS: usize = 2 * 3 * 12 * 2;

fn folder(study: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("study.toml"), study).unwrap();
    folder
}

fn rows(folder: &Path) -> Vec<Value> {
    let text = fs::read_to_string(folder.join("results.jsonl")).unwrap();
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

/// Of the points that have an error.
fn costs(rows: &[Value], cost: &str) -> Vec<Cost> {
    let of = |row: &Value| {
        Some(Cost {
            x: row[cost].as_f64()?,
            y: row["error"].as_f64()?,
        })
    };
    rows.iter().filter_map(of).collect()
}

/// The share of the hypervolume of all points that these have.
fn share(found: &[Value], all: &[Value], cost: &str) -> f64 {
    let grid = costs(all, cost);
    let corner = grid
        .iter()
        .fold(Cost { x: 0.0, y: 0.0 }, |corner, cost| Cost {
            x: corner.x.max(1.05 * cost.x),
            y: corner.y.max(1.05 * cost.y),
        });
    hypervolume(&costs(found, cost), corner) / hypervolume(&grid, corner)
}

/// What a search cost, as a share of what all points cost.
fn cost_of(did: &Value) -> f64 {
    let number = |key: &str| did["search"][key].as_f64().unwrap();
    number("point_frames") / number("of")
}

#[test]
fn a_search_finds_the_front_at_a_fraction_of_its_cost() {
    let searched = format!(
        "sample = {{ method = \"search\", points = 1000, cost = \"state_memory_bytes\" }}\n{STUDY}"
    );
    let folder = folder(&searched);
    let at = folder.path();
    fs::write(at.join("grid.toml"), STUDY).unwrap();
    good(at, &["sweep", "grid.toml", "--output", "grid"]);
    let did = json(at, &["sweep", "study.toml", "--output", "search"]);
    let (all, found) = (rows(&at.join("grid")), rows(&at.join("search")));
    assert_eq!((all.len(), found.len()), (POINTS, 8));
    // What was found is what the grid has.
    for row in &found {
        let same = all.iter().find(|other| other["id"] == row["id"]).unwrap();
        assert_eq!(row["error"], same["error"]);
    }
    let share = share(&found, &all, "state_memory_bytes");
    assert!(share >= 0.95, "{share} of the hypervolume");
    // In frames of the whole sensor that points saw, parts of it counted as parts.
    assert_eq!(did["search"]["of"], (POINTS * 36) as f64);
    let cost = cost_of(&did);
    assert!(cost < 0.2, "{cost} of the cost");
    println!("{share} of the hypervolume for {cost} of the point-frames");

    // Gone on with, nothing is computed again; in another folder it is chosen alike.
    let again = json(at, &["sweep", "study.toml", "--output", "search"]);
    assert_eq!(
        (&again["computed"], &again["found"]),
        (&json!(0), &json!(8))
    );
    let rungs = again["search"]["rungs"].as_array().unwrap();
    assert!(rungs.iter().all(|rung| rung["tried"] == 0), "{rungs:?}");
    json(
        at,
        &["sweep", "study.toml", "--output", "other", "--jobs", "1"],
    );
    let ids = |folder: &str| -> Vec<Value> {
        rows(&at.join(folder))
            .iter()
            .map(|row| row["id"].clone())
            .collect()
    };
    assert_eq!(ids("search"), ids("other"));
    let other = json(
        at,
        &["sweep", "study.toml", "sample.seed=5", "--output", "seeded"],
    );
    assert_eq!(other["computed"], 8);

    let said = good(at, &["sweep", "study.toml", "--output", "search"]);
    assert!(
        said.contains("point-frames") && !said.contains("missing"),
        "{said}"
    );
    let next = "next     amacrine report search --pool --cost state_memory_bytes\n";
    assert!(said.ends_with(next), "{said}");
    assert!(said.contains("nor compiling programs is counted"), "{said}");
    // The report and the rest of the grid take the same folder.
    assert_eq!(json(at, &["report", "search"])["finished"], 8);
    let rest = json(at, &["sweep", "grid.toml", "--output", "search"]);
    assert_eq!(rest["found"], 8);
    refused(
        at,
        &["sweep", "study.toml", "--output", "x", "--shard", "0/2"],
        &["--shard of a search"],
    );
    refused(
        at,
        &[
            "sweep",
            "study.toml",
            "sample.method=sobol",
            "--output",
            "x",
        ],
        &["`sample.cost` is of a search"],
    );
}

/// A search over a study whose parts are likely to show little finds its front, with several seeds.
fn is_found(study: &str, clip: Option<&Array3<u8>>, name: &str) {
    let folder = folder(&format!(
        "sample = {{ method = \"search\", points = 1000, cost = \"bits\" }}\n{study}"
    ));
    let at = folder.path();
    if let Some(clip) = clip {
        write_npy(at.join("clip.npy"), clip).unwrap();
    }
    fs::write(at.join("grid.toml"), study).unwrap();
    good(at, &["sweep", "grid.toml", "-o", "grid"]);
    let all = rows(&at.join("grid"));
    for seed in 0..3 {
        let output = format!("search{seed}");
        let seed = format!("sample.seed={seed}");
        let did = json(at, &["sweep", "study.toml", &seed, "-o", &output]);
        assert_eq!(did["search"]["computed_all"], false);
        assert_eq!(
            (&did["finished"], &did["search"]["nothing"]),
            (&json!(8), &json!([]))
        );
        let (share, cost) = (share(&rows(&at.join(&output)), &all, "bits"), cost_of(&did));
        println!("{name}, {seed}: {share} of the hypervolume for {cost} of the point-frames");
        assert!(share >= 0.95, "{name}, {seed}: {share} of the hypervolume");
        assert!(cost < 0.15, "{name}, {seed}: {cost} of the cost");
    }
}

const OFTEN: &str = r#"
kernel = ["csdvs-3", "dvs"]
threshold = 16
threshold-equivalent = false
metrics = "f1"
[[side]]
side = "reference"
format = ["f64", "f16", "q8.8", "q12.4", "q10.6", "bf16", "q4.12", "q16.16"]
memory = ["filtered-snap", "filtered-step"]
refractory = [{ us = 0 }, { us = 5000 }, { us = 30000 }, { us = 60000 }]
"#;

/// A clip that is still but for ten of its 96 frames; what moves is as far as `side` from the corner.
fn burst(side: usize) -> Array3<u8> {
    let draw =
        |t: usize, y: usize, x: usize| Hash::new(5).with(((t * 96 + y) * 96 + x) as u64).uniform();
    Array3::from_shape_fn((96, 96, 96), |(t, y, x)| {
        let moves = y < side && x < side;
        let steps = if moves { t.clamp(69, 79) - 69 } else { 0 };
        let start = 40.0 + 170.0 * draw(0, y, x);
        (1..=steps).fold(start, |light, step| {
            (light + 60.0 * (draw(step, y, x) - 0.5)).clamp(0.0, 255.0)
        }) as u8
    })
}

#[test]
fn a_burst_in_a_still_clip_is_found() {
    let study = format!("scene = \"clip.npy\"\nfps = 100\nwithin = [\"10ms\"]\n{OFTEN}");
    is_found(&study, Some(&burst(96)), "a burst");
}

#[test]
fn what_moves_in_a_corner_alone_is_found() {
    let study = format!("scene = \"clip.npy\"\nfps = 100\nwithin = [\"10ms\"]\n{OFTEN}");
    is_found(&study, Some(&burst(16)), "a corner");
}

/// Where the part is shorter than the window of matches, chance scores as much as anything.
#[test]
fn a_scene_that_is_hardly_longer_than_the_window_is_searched() {
    let scene = "pattern:noise?width=128&height=128&frames=48&fps=240&speed=60&grain=6";
    is_found(
        &format!("scene = \"{scene}\"\n{OFTEN}"),
        None,
        "240 frames a second",
    );
}

/// The study as a search whose cost no clock decides.
fn searched() -> TempDir {
    folder(&format!(
        "sample = {{ method = \"search\", points = 1000, cost = \"bits\" }}\n{STUDY}"
    ))
}

#[test]
fn what_a_search_gives_up_is_a_row_and_is_tried_again() {
    let folder = searched();
    let at = folder.path();
    let sweep = ["sweep", "study.toml", "-o", "out"];
    let limited = [&sweep[..], &["--max-seconds-per-point", "1e-9"]].concat();
    let said = good(at, &limited);
    for words in [
        "failed   144 points, computed again by the next run:",
        "point 0 and 143 more: on a part of the scene: it took more than 0.000000001 s",
        "144 rows",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    assert!(!said.contains("-0"), "{said}");
    let given_up = rows(&at.join("out"));
    assert!(given_up.iter().all(|row| row["outcome"] == "failed"));
    let said = good(at, &["merge", "out", "-o", "all of it"]);
    let words =
        "failed   144 points: compute again with `amacrine sweep STUDY --output 'all of it'`\n";
    assert!(said.contains(words), "{said}");
    let again = json(at, &sweep);
    assert_eq!(again["search"]["rungs"][0]["tried"], POINTS);
    assert_eq!(again["failed"], json!([]));
    let found = rows(&at.join("out"));
    assert_eq!(found.len(), 8);
    assert!(found.iter().all(|row| row["outcome"] == "done"));
    // What a search leaves out is not computed by another run.
    let said = good(at, &["merge", "out", "-o", "joined"]);
    let words = "missing  136 points: left out by the search, or not computed yet\n";
    assert!(said.contains(words), "{said}");
    // As if nothing had been given up.
    json(at, &["sweep", "study.toml", "-o", "other"]);
    let figures = |folder: &str| {
        rows(&at.join(folder))
            .iter()
            .map(figures)
            .collect::<Vec<_>>()
    };
    assert_eq!(figures("out"), figures("other"));
}

#[test]
fn a_search_names_the_points_that_come_to_nothing() {
    let folder = searched();
    let at = folder.path();
    let sweep = [
        "sweep",
        "study.toml",
        "threshold=5000,6000,7000",
        "-o",
        "out",
    ];
    let said = good(at, &sweep);
    let why = "neither the float sensor nor this one has an event";
    for words in [
        "rung 1   144 points on a part of the scene: ",
        ", 0 were known, 144 could not be ranked\n",
        "unranked 136 points, left out behind the others since the parts that were tried do not show",
        &format!(" and 135 more: on a part of the scene: {why}"),
        "8 rows",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    assert!(!said.contains("-0") && !said.contains("nothing"), "{said}");
    // Those that are computed are not the first of the grid.
    let places = |folder: &str| -> Vec<u64> {
        let rows = rows(&at.join(folder));
        rows.iter()
            .filter_map(|row| row["index"].as_u64())
            .collect()
    };
    let chosen = places("out");
    assert!(chosen.iter().max() > Some(&64), "{chosen:?}");
    // What was tried is not tried again, and is told again.
    let again = json(at, &sweep);
    let search = &again["search"];
    assert_eq!(search["rungs"][0]["tried"], 0);
    assert_eq!(search["rungs"][0]["unranked"], POINTS);
    assert_eq!(search["rungs"][1]["points"], POINTS);
    assert_eq!(search["unranked"].as_array().unwrap().len(), POINTS - 8);
    assert_eq!(search["nothing"], json!([]));
    assert_eq!(places("out"), chosen);
    let other = ["sample.seed=1", "threshold=5000,6000,7000", "-o", "other"];
    json(at, &[&["sweep", "study.toml"], &other[..]].concat());
    assert_ne!(places("other"), chosen);

    // What no other part can change is known: a float sensor has no words.
    let array = "[[side]]\nside = \"array\"\nquantise = \"ternary\"\nreadout = \"all\"\n";
    let search =
        "sample = { method = \"search\", points = 1000, cost = \"words\" }\neffort = 0.01\n";
    fs::write(at.join("words.toml"), format!("{search}{STUDY}{array}")).unwrap();
    let said = good(
        at,
        &[
            "sweep",
            "words.toml",
            "kernel=csdvs-3",
            "threshold=16",
            "-o",
            "words",
        ],
    );
    for words in [
        "nothing  comes of 24 points, which the search left out:",
        "point 0 and 23 more: on a part of the scene: it has no words",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

/// A scene of sixty frames, and one that is too small for parts.
const UNEQUAL: &str = r#"
scene = ["pattern:disc?frames=60", "pattern:disc?width=24&height=24&frames=6&radius=5"]
kernel = "dvs"
threshold = 20
threshold-equivalent = false
metrics = "f1"
[[side]]
side = "reference"
format = ["q4.4", "q2.6", "q6.2", "q4.12", "q8.8", "q10.6", "q12.4", "q16.16", "bf16", "f16", "f32", "f64"]
memory = ["filtered-snap", "filtered-step"]
"#;

#[test]
fn a_scene_too_small_for_parts_takes_no_rung_from_the_others() {
    let search = "sample = { method = \"search\", points = 400, cost = \"bits\" }\n";
    let folder = folder(&format!("{search}{UNEQUAL}"));
    let at = folder.path();
    fs::write(at.join("grid.toml"), UNEQUAL).unwrap();
    good(at, &["sweep", "grid.toml", "-o", "grid"]);
    let did = json(at, &["sweep", "study.toml", "-o", "out"]);
    let search = &did["search"];
    let rung = &search["rungs"][0];
    let numbers = ["points", "tried", "whole"].map(|key| rung[key].as_u64().unwrap());
    assert_eq!(numbers, [48, 48, 24]);
    assert_eq!(search["computed_all"], false);
    let found = rows(&at.join("out"));
    assert_eq!(found.len(), 8);
    let best = |rows: &[Value]| {
        let errors = rows.iter().filter_map(|row| row["error"].as_f64());
        errors.fold(f64::INFINITY, f64::min)
    };
    assert_eq!(best(&found), best(&rows(&at.join("grid"))));
    // Not the first of the grid: they were ranked.
    let places = found.iter().filter_map(|row| row["index"].as_u64());
    assert!(places.max() >= Some(8), "{found:?}");
    let said = good(at, &["sweep", "study.toml", "-o", "out"]);
    assert!(
        said.contains("48 points on a part of the scene, 24 of them on the whole of a scene"),
        "{said}"
    );
}

/// Of a still scene that was looked at whole nothing more is to be seen; of a part of one there is.
#[test]
fn a_still_scene_beside_another_takes_nothing_from_it() {
    let search = "sample = { method = \"search\", points = 400, cost = \"bits\" }\n";
    let study = format!("{search}{UNEQUAL}");
    let small = "radius=5";
    let folder = folder(&study.replace(small, "radius=5&speed=0"));
    let at = folder.path();
    let did = json(at, &["sweep", "study.toml", "-o", "out"]);
    let nothing = did["search"]["nothing"].as_array().unwrap();
    assert_eq!(nothing.len(), 24);
    let why = "in a rung of the search: neither the float sensor nor this one has an event";
    assert!(nothing.iter().all(|it| it["reason"] == why), "{nothing:?}");
    assert_eq!(did["search"]["unranked"], json!([]));
    let found = rows(&at.join("out"));
    assert_eq!(costs(&found, "bits").len(), 8);
    let small = "width=24&height=24&frames=6&radius=5";
    let large = study.replace(small, "frames=60&speed=0");
    fs::write(at.join("large.toml"), large).unwrap();
    let did = json(at, &["sweep", "large.toml", "-o", "large"]);
    let search = &did["search"];
    assert_eq!(search["nothing"], json!([]));
    assert_eq!(search["unranked"].as_array().unwrap().len(), 24);
    assert_eq!(costs(&rows(&at.join("large")), "bits").len(), 8);
}

/// What no rung has ranked is not cut.
#[test]
fn where_no_part_is_small_enough_all_points_are_computed() {
    let search = "sample = { method = \"search\", points = 400, cost = \"bits\" }\n";
    let text = format!("{search}{UNEQUAL}");
    let large = "\"pattern:disc?frames=60\", ";
    let folder = folder(&text.replace(large, ""));
    let at = folder.path();
    let did = json(at, &["sweep", "study.toml", "-o", "out"]);
    assert_eq!(did["search"]["computed_all"], true);
    assert_eq!(did["search"]["point_frames"], did["search"]["of"]);
    assert_eq!((&did["computed"], &did["missing"]), (&json!(24), &json!(0)));
    let said = good(at, &["sweep", "study.toml", "-o", "out"]);
    for words in [
        "search   left out no point: parts of these scenes are too much of them",
        "rung 1   24 points on the whole scene",
        "100.0 % of the",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

const SMALL: &str = r#"
scene = "pattern:disc?width=32&height=24&frames=6&radius=6"
kernel = "csdvs-3"
threshold = [20, 30]
threshold-equivalent = false
effort = 0.01
[[side]]
side = "reference"
format = ["f64", "f16"]
[[side]]
side = "array"
quantise = "ternary"
domain = ["exact", "silicon"]
"#;

/// What the tables say of each point, but for times.
fn figures(row: &Value) -> Value {
    let mut row = row.clone();
    let own = row.as_object_mut().unwrap();
    own.retain(|name, value| {
        !name.contains("second") && !name.contains("per_s") && !value.is_null()
    });
    for name in ["index", "provenance"] {
        own.remove(name);
    }
    row
}

#[test]
fn keys_set_on_the_command_line_are_the_study_s_own() {
    let folder = folder(SMALL);
    let at = folder.path();
    let written = SMALL
        .replace("[20, 30]", "25")
        .replace("[\"exact\", \"silicon\"]", "\"q8.8\"");
    fs::write(at.join("written.toml"), written).unwrap();
    json(at, &["sweep", "written.toml"]);
    let set = ["sweep", "study.toml", "threshold=25", "array.domain=q8.8"];
    let did = json(at, &set);
    // Another study has another folder.
    let output = did["output"].as_str().unwrap();
    assert!(output.starts_with("study-"), "{output}");
    let (set, written) = (rows(&at.join(output)), rows(&at.join("written")));
    assert_eq!(set.len(), 3);
    for (set, written) in set.iter().zip(&written) {
        assert_eq!(figures(set), figures(written));
    }
    // Folders of the same study are the same, however it was said.
    let on = json(
        at,
        &[
            "sweep",
            "study.toml",
            "threshold=25",
            "array.domain=q8.8",
            "--output",
            "written",
        ],
    );
    assert_eq!(on["computed"], 0);
    let cases: [(&[&str], &[&str]); 8] = [
        (
            &["fromat=f32"],
            &["no key `fromat`", "did you mean `format`?"],
        ),
        (
            &["refrence.format=f32"],
            &["no key `refrence`", "did you mean `reference`?"],
        ),
        (&["mesh.lambda=2"], &["no side `mesh`"]),
        (&["array=2"], &["`array` is a side", "array.threshold=16"]),
        (
            &["array.domian=exact"],
            &["domian", "did you mean `domain`?"],
        ),
        (
            &["threshold.on=2"],
            &["`threshold` is a list", "threshold='{ on = 2 }'"],
        ),
        (&["format=f31"], &["study.toml with format=f31", "f31"]),
        (&["format"], &["is no key=value", "format=f32,q8.8"]),
    ];
    for (set, words) in cases {
        let all = [&["sweep", "study.toml"], set].concat();
        refused_untouched(at, &all, words);
    }
}

#[test]
fn the_space_has_sides_and_axes() {
    let folder = folder(SMALL);
    let at = folder.path();
    let space: Value =
        serde_json::from_str(&good(at, &["sweep", "study.toml", "--space"])).unwrap();
    let sides = space["sides"].as_array().unwrap();
    let axis = |side: usize, name: &str| {
        let axes = sides[side]["axes"].as_array().unwrap();
        axes.iter()
            .find(|axis| axis["name"] == name)
            .unwrap()
            .clone()
    };
    assert_eq!(sides[1]["side"], "array");
    assert_eq!(axis(0, "format")["values"], json!(["f64", "f16"]));
    assert_eq!(axis(0, "threshold")["values"], json!([20.0, 30.0]));
    let ranged = [
        "sweep",
        "study.toml",
        "--space",
        "sample.points=4",
        "sample.method=sobol",
        "threshold={from=8,to=32,log=true}",
    ];
    let ranged: Value = serde_json::from_str(&good(at, &ranged)).unwrap();
    let threshold = &ranged["sides"][0]["axes"];
    let threshold = threshold
        .as_array()
        .unwrap()
        .iter()
        .find(|it| it["name"] == "threshold");
    assert_eq!(threshold.unwrap()["log"], true);
}

#[test]
fn points_told_one_by_one_are_those_of_a_sweep() {
    let folder = folder(SMALL);
    let at = folder.path();
    json(at, &["sweep", "study.toml"]);
    let swept = rows(&at.join("study"));
    let mut lines = String::new();
    for format in ["f64", "f16"] {
        for threshold in [20, 30] {
            let point = json!({"side": "reference", "threshold": threshold, "format": format});
            lines.extend([point.to_string(), "\n".to_owned()]);
        }
    }
    lines += "{\"side\": 1, \"threshold\": 20, \"domain\": \"exact\"}\n";
    // A value that the study does not list is a point too.
    lines += "{\"side\": 0, \"threshold\": {\"on\": 25, \"off\": 24}, \"format\": \"q8.8\"}\n";
    let wrong = [
        ("{\"side\": 0, \"threshold\": 20}", "does not say `format`"),
        (
            "{\"side\": 0, \"treshold\": 20, \"format\": \"f64\"}",
            "no key `treshold`",
        ),
        ("{\"side\": 7}", "no side 7"),
        ("{\"threshold\": 20}", "does not say its `side`"),
        (
            "{\"side\": 0, \"threshold\": [1, 2], \"format\": \"f64\"}",
            "`threshold` is [1,2]",
        ),
        (
            "{\"side\": 0, \"threshold\": -2, \"format\": \"f64\"}",
            "threshold",
        ),
        ("{", "not JSON"),
        ("3", "no JSON object"),
        ("", "line 15: it is empty"),
    ];
    for (line, _) in wrong {
        lines += line;
        lines += "\n";
    }
    let said = amacrine(at, &["sweep", "study.toml", "--tell"])
        .write_stdin(lines)
        .output()
        .unwrap();
    assert!(said.status.success());
    let said = String::from_utf8(said.stdout).unwrap();
    let told: Vec<Value> = { said.lines() }
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(told.len(), 6 + wrong.len());
    for row in &told[..5] {
        let same = swept.iter().find(|other| other["id"] == row["id"]);
        let same = same.expect("a point of the sweep");
        assert_eq!(figures(row), figures(same));
        // A column without a value is there as well.
        let columns = |row: &Value| row.as_object().unwrap().keys().cloned().collect::<Vec<_>>();
        assert_eq!(columns(row), columns(same));
    }
    assert_eq!(told[5]["outcome"], "done");
    assert!(!swept.iter().any(|other| other["id"] == told[5]["id"]));
    for (row, (line, words)) in told[6..].iter().zip(wrong) {
        assert_eq!(row["outcome"], "wrong", "{line}");
        assert!(row["reason"].as_str().unwrap().contains(words), "{row}");
        assert!(!row["help"].as_str().unwrap().is_empty(), "{row}");
    }
    let point = "{\"side\": \"reference\", \"threshold\": 20, \"format\": \"f64\"}";
    let one = good(at, &["sweep", "study.toml", "--point", point]);
    let one: Value = serde_json::from_str(&one).unwrap();
    assert_eq!(figures(&one), figures(&told[0]));
    refused_untouched(
        at,
        &[
            "sweep",
            "study.toml",
            "--point",
            "{\"side\": 0, \"format\": \"f63\", \"threshold\": 20}",
        ],
        &["f63"],
    );
}

/// What would change nothing is refused, with what to do.
#[test]
fn keys_that_no_side_takes_are_told() {
    let side =
        "kernel = \"dvs\"\nthreshold = 8\n[[side]]\nside = \"reference\"\nformat = \"f32\"\n";
    let scene = "scene = \"pattern:disc?width=16&height=16&frames=4\"\n";
    let at = folder(&format!("{scene}format = \"zzz\"\n{side}"));
    refused_untouched(
        at.path(),
        &["sweep", "study.toml", "-o", "out"],
        &["study.toml:2:1", "every side that has it sets its own"],
    );
    let search = "sample = { method = \"search\", points = 200, cost = \"words\" }\n";
    let at = folder(&format!("{scene}{search}{side}"));
    refused_untouched(
        at.path(),
        &["sweep", "study.toml", "-o", "out"],
        &["no point has `words`", "[[side]]"],
    );
    // Of a list of tables each is set.
    let list = "refractory = [{ us = 0 }, { us = 2000 }]\n";
    let at = folder(&format!("{scene}{list}{side}"));
    let said = refused_untouched(
        at.path(),
        &["sweep", "study.toml", "refractory.us=0,3000", "--space"],
        &["set all of it: refractory='{ us = 0 },{ us = 3000 }'"],
    );
    assert!(!said.is_empty());
    good(
        at.path(),
        &[
            "sweep",
            "study.toml",
            "refractory={ us = 0 },{ us = 3000 }",
            "--space",
        ],
    );
}

/// Each value of the space is one that a point may have.
#[test]
fn values_of_the_space_are_taken_again() {
    let at = folder(
        r#"
        scene = "pattern:noise?width=24&height=24&frames=6"
        kernel = "dvs"
        threshold = 8
        fidelity = "auto"
        [[side]]
        side = "reference"
        response = ["identity", { linear = 255 }]
        noise = ["none", "noisy"]
        "#,
    );
    let space: Value =
        serde_json::from_str(&good(at.path(), &["sweep", "study.toml", "--space"])).unwrap();
    let axes = space["sides"][0]["axes"].as_array().unwrap();
    let values = |name: &str| {
        let axis = axes.iter().find(|axis| axis["name"] == name).unwrap();
        axis["values"].as_array().unwrap().clone()
    };
    let mut ids = Vec::new();
    for response in values("response") {
        for noise in values("noise") {
            let point = json!({"side": 0, "response": response, "noise": noise}).to_string();
            let said = good(at.path(), &["sweep", "study.toml", "--point", &point]);
            let row: Value = serde_json::from_str(&said).unwrap();
            assert_ne!(row["outcome"], "wrong", "{row}");
            ids.push(row["id"].clone());
        }
    }
    assert_eq!(ids.len(), 4);
    let mut told = amacrine(
        at.path(),
        &["sweep", "study.toml", "--point", "{\"side\": 0}"],
    );
    let said = line(&told.output().unwrap().stderr);
    assert!(
        said.contains("a point that is told is computed in full"),
        "{said}"
    );
    // A point that is told is computed in full, and is another than the one of the sweep.
    good(at.path(), &["sweep", "study.toml", "-o", "out"]);
    let swept = rows(&at.path().join("out"));
    assert!(swept.iter().all(|row| !ids.contains(&row["id"])));
}
