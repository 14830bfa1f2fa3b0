//! One question, asked through each verb that can answer it, has one answer: the same share kept,
//! the same window, the same frame rate, the same threshold equivalent, to the digit. The last
//! way is by hand: `compile`, `exec`, `run` and `compare`, each on the file of the one before.
#![cfg(feature = "cli")]

mod common;

use std::{fs, path::Path};

use amacrine::{compare::window::can_judge, rig::guard::Warning, unit::Micros};
use common::{amacrine, good, json, refused};
use ndarray::{Array3, Array4};
use ndarray_npy::{read_npy, write_npy};
use serde_json::Value;
use tempfile::TempDir;

/// Slow enough that the window is the time from frame to frame.
const FPS: &str = "5";
const SCENE: &str = "pattern:noise?width=64&height=48&frames=10&grain=3&speed=20";
const KERNEL: &str = "csdvs-3";
const TO: &str = "po2-4";
const THRESHOLD: &str = "24";
const EFFORT: &str = "0.05";

/// The options that say the question; no other default is told.
const ASKED: [&str; 8] = [
    "--scene",
    SCENE,
    "--fps",
    FPS,
    "--threshold",
    THRESHOLD,
    "--effort",
    EFFORT,
];

/// What is asked.
#[derive(Debug, PartialEq)]
struct Answer {
    kept: f64,
    window_us: u64,
    fps: f64,
    threshold_equivalent_percent: f64,
}

#[track_caller]
fn answer(row: &Value) -> Answer {
    let number = |key: &str| {
        row[key]
            .as_f64()
            .unwrap_or_else(|| panic!("no {key}: {row}"))
    };
    Answer {
        kept: number("kept"),
        window_us: row["window_us"].as_u64().unwrap(),
        fps: number("fps"),
        threshold_equivalent_percent: number("threshold_equivalent_percent"),
    }
}

fn asked(folder: &Path, verb: &[&str]) -> Value {
    json(folder, &[verb, &ASKED].concat())
}

/// The row of a quantiser.
fn of(rows: &Value) -> &Value {
    let mut rows = rows.as_array().unwrap().iter();
    rows.find(|row| row["to"] == TO).unwrap()
}

fn quantise(folder: &Path) -> Value {
    asked(folder, &["quantise", KERNEL, "--to", TO])
}

fn sweep(folder: &Path) -> Value {
    swept(folder, KERNEL, TO, "kept")
}

/// The one row of a study.
fn swept(folder: &Path, kernel: &str, to: &str, sum: &str) -> Value {
    let study = format!(
        "scene = \"{SCENE}\"\nfps = {FPS}\nkernel = \"{kernel}\"\nthreshold = {THRESHOLD}\neffort = {EFFORT}\nsum = \"{sum}\"\n\
         [[side]]\nside = \"array\"\nquantise = \"{to}\"\ndomain = \"silicon\"\n"
    );
    fs::write(folder.join("study.toml"), study).unwrap();
    json(folder, &["sweep", "study.toml", "--output", "swept"]);
    let rows = fs::read_to_string(folder.join("swept/results.jsonl")).unwrap();
    serde_json::from_str(rows.trim()).unwrap()
}

/// The same by hand.
fn by_hand(folder: &Path) -> Value {
    let sensor = format!(
        "response = \"identity\"\nmemory = \"filtered-snap\"\nborder = \"zero\"\n[[channel]]\nkernel = \"{KERNEL}\"\nthreshold = {{ on = {THRESHOLD}, off = {THRESHOLD} }}\n"
    );
    fs::write(folder.join("float.toml"), sensor).unwrap();
    let compile = ["compile", KERNEL, "--to", TO, "--threshold", THRESHOLD];
    good(
        folder,
        &[&compile[..], &["--effort", EFFORT, "-o", "p.scamp"]].concat(),
    );
    let exec = ["exec", "p.scamp", "--domain", "silicon", "--image", SCENE];
    let frames = ["--fps", FPS, "--frames", "10", "--events", "chip.npy"];
    good(folder, &[&exec[..], &frames].concat());
    let run = [
        "run",
        "--sensor",
        "float.toml",
        "--scene",
        SCENE,
        "--fps",
        FPS,
    ];
    good(folder, &[&run[..], &["--events", "float.npy"]].concat());
    let compare = ["compare", "float.npy", "chip.npy", "--sensor", "float.toml"];
    let shown = ["--scene", SCENE, "--fps", FPS];
    json(folder, &[&compare[..], &shown].concat())
}

#[test]
fn sweeps_and_compare_say_what_quantise_says() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let said = quantise(at);
    let row = of(&said["chip"]["rows"]);
    let first = answer(row);
    assert_eq!((first.fps, first.window_us), (5.0, 200_000));
    assert!(0.05 < first.kept && first.kept < 0.99, "{first:?}");
    assert_eq!(answer(&row["on_chip"]["silicon"]), first);
    assert_eq!(answer(&sweep(at)), first);
    let compared = by_hand(at);
    assert_eq!(answer(&compared["headline"]), first);
    assert_eq!(compared["within_us"], first.window_us);
}

#[test]
fn waterfall_says_what_quantise_says() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let first = answer(of(&quantise(at)["chip"]["rows"]));
    let waterfall = asked(at, &["waterfall", KERNEL, "--to", TO]);
    assert_eq!(answer(&waterfall), first);
}

#[test]
fn feasibility_says_what_quantise_says() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let quantised = quantise(at);
    let row = of(&quantised["chip"]["rows"]);
    let feasibility = asked(at, &["feasibility", "--kernel", KERNEL, "--to", TO]);
    assert_eq!(answer(of(&feasibility["quantisation"])), answer(row));
    let streams = &feasibility["streams"];
    assert_eq!(answer(&streams["silicon"]["judged"]), answer(row));
    let exact = answer(&row["on_chip"]["exact"]);
    assert_eq!(answer(&streams["exact"]["judged"]), exact);
    assert!(answer(&streams["dvs"]["judged"]).kept < exact.kept);
}

/// The sum has one default, too: what is left of the kernel is the same in each verb.
#[test]
fn sums_are_kept_in_every_verb() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let levels = |more: &[&str]| {
        let quantise = ["quantise", "rgc-5x5", "--to", "ternary"];
        json(at, &[&quantise[..], more].concat())["quantised"][0].clone()
    };
    let kept = levels(&["--sum", "kept"]);
    assert_eq!(levels(&[]), kept);
    assert!(kept["sum"].as_f64().unwrap().abs() < 1e-9);
    let compile = ["compile", "rgc-5x5", "--to", "ternary", "--filter-only"];
    let compile = [&compile[..], &["--effort", "0.01"]].concat();
    assert_eq!(json(at, &compile)["kernel"], kept["levels"]);
    for verb in ["quantise", "compile", "waterfall", "feasibility"] {
        let help = good(at, &[verb, "--help"]);
        let sum = help.split("--sum").nth(1).unwrap();
        assert!(sum.contains("[default: kept]"), "{verb}: {sum}");
        if verb != "compile" {
            for option in ["--fps <", "--within <", "--scene <"] {
                assert!(help.contains(option), "{verb} has no {option}");
            }
        }
    }
    let schema: Value = serde_json::from_str(&good(at, &["schema", "study"])).unwrap();
    assert_eq!(schema["properties"]["sum"]["default"], "kept");
}

/// A surround that few values erase is told by each verb, beside its output.
#[test]
fn what_few_values_erase_is_told_beside_the_answer() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let first = |arguments: &[&str]| {
        let said = amacrine(at, arguments).assert().success();
        let said = said.get_output();
        let answer = String::from_utf8_lossy(&said.stdout);
        assert!(!answer.contains("warning:"), "{arguments:?}: {answer}");
        let told = String::from_utf8_lossy(&said.stderr).into_owned();
        let about_kernel = |line: &&str| line.contains("warning: ") && line.contains("ternary");
        let line = told.lines().find(about_kernel);
        line.unwrap_or_else(|| answer.lines().next().unwrap())
            .to_owned()
    };
    let abouts = |said: &Value| -> Vec<String> {
        let all = said["warnings"].as_array().unwrap().iter();
        all.map(|warning| warning["about"].as_str().unwrap().to_owned())
            .collect()
    };
    let plain = ["quantise", "csdvs-3", "--to", "ternary", "--sum", "free"];
    assert!(first(&plain).contains("plain DVS"), "{}", first(&plain));
    assert_eq!(abouts(&json(at, &plain)), ["surround"]);
    let corner = ["quantise", "csdvs-5", "--to", "ternary", "--sum", "zero"];
    assert!(first(&corner).contains("lopsided"), "{}", first(&corner));
    assert_eq!(abouts(&json(at, &corner)), ["lopsided"]);

    let compile = ["compile", "csdvs-3", "--filter-only", "--effort", "0.01"];
    let compile = [&compile[..], &["--to", "ternary", "--sum", "free"]].concat();
    assert!(first(&compile).contains("plain DVS"), "{}", first(&compile));
    assert_eq!(abouts(&json(at, &compile)), ["surround"]);
    let few = ["--to", "ternary", "--sum", "free"];
    for verb in [
        &["waterfall", "csdvs-3"][..],
        &["feasibility", "--kernel", "csdvs-3"],
        &["quantise", "csdvs-3"],
    ] {
        let ask = [verb, &ASKED, &few].concat();
        assert!(
            first(&ask).contains("plain DVS"),
            "{verb:?}: {}",
            first(&ask)
        );
        let told = abouts(&json(at, &ask));
        assert!(told.contains(&"surround".to_owned()), "{verb:?}: {told:?}");
    }
    let row = swept(at, "csdvs-3", "ternary", "free");
    assert!(
        row["warnings"].as_str().unwrap().contains("surround"),
        "{row}"
    );
    let fine = ["quantise", "rgc-5x5", "--to", "int-5"];
    assert!(first(&fine).starts_with("rgc-5x5"));
    assert!(abouts(&json(at, &fine)).is_empty());
}

/// One candidate that is not to be had does not hide the others.
#[test]
fn an_impossible_candidate_is_a_row() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let both = ["quantise", "csdvs-5", "--to", "binary,int-5"];
    let rows = json(at, &both)["quantised"].clone();
    let why = rows[0]["refused"].as_str().unwrap();
    assert!(why.contains("sums to 0 over 25 weights"), "{why}");
    assert!(rows[0].get("levels").is_none());
    assert!(rows[1]["relative_error"].is_number());
    let table = good(at, &both);
    assert!(
        table.contains("binary           no choice of levels"),
        "{table}"
    );
    assert!(table.contains("\nint-5  "), "{table}");
    let picture = [&both[..], &["--picture", "k.png"]].concat();
    amacrine(at, &picture).assert().success();
    // Two kernels of 5 by 5 cells, and not three.
    let width = image::open(at.join("k.png")).unwrap().width();
    assert!(width < 3 * 5 * 24, "{width}");
    let ran = asked(at, &["quantise", "csdvs-5", "--to", "binary,int-5"]);
    assert!(ran["chip"]["rows"][0]["refused"].is_string());
    assert!(ran["chip"]["rows"][1]["kept"].is_number());
    refused(
        at,
        &["quantise", "csdvs-5", "--to", "binary"],
        &["csdvs-5 cannot be binary", "no choice of levels"],
    );
}

/// What verbs warn of is what `feasibility` does not judge.
#[test]
fn chance_scores_too_much_from_one_limit() {
    for floor in [0.0, 0.85, 0.9, 0.92, 0.97, 1.0] {
        let warned = Warning::window(Micros(100_000), floor).is_some();
        assert_eq!(warned, !can_judge(floor), "{floor}");
        assert_eq!(warned, floor > 0.9, "{floor}");
    }
}

/// In few bits a memory may begin a pair of frames beyond its next threshold. Its events are where the
/// list has them, in the voxels too, also those that a dead time leaves.
#[test]
fn voxels_in_few_bits_are_those_of_the_list() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let light = Array3::from_shape_vec((5, 1, 1), vec![139_u8, 161, 168, 179, 180]).unwrap();
    write_npy(folder.join("c.npy"), &light).unwrap();
    for dead_time in [
        "",
        "refractory = { us = 1500 }\n",
        "refractory = { us = 9500 }\n",
    ] {
        let sensor = format!(
            "response = \"identity\"\nmemory = \"filtered-step\"\n{dead_time}[[channel]]\nkernel = \"dvs\"\nthreshold = {{ on = 0.263, off = 0.263 }}\n"
        );
        fs::write(folder.join("s.toml"), sensor).unwrap();
        let run =
            "run --scene c.npy --fps 100 --sensor s.toml --format bf16 --voxels v.npy -o e.csv";
        good(folder, &run.split(' ').collect::<Vec<_>>());
        let voxels: Array4<f32> = read_npy(folder.join("v.npy")).unwrap();
        let mut wanted = [0.0; 5];
        let list = fs::read_to_string(folder.join("e.csv")).unwrap();
        for line in list.lines().skip(1) {
            // In frames; an event is shared between the two nearest.
            let at = line.split(',').next().unwrap().parse::<f64>().unwrap() / 10_000.0;
            let frame = at.floor();
            wanted[frame as usize] += 1.0 - (at - frame);
            if at > frame {
                wanted[frame as usize + 1] += at - frame;
            }
        }
        for (got, wanted) in voxels.iter().zip(wanted) {
            assert!((f64::from(*got) - wanted).abs() < 0.02, "{voxels} {wanted}");
        }
    }
}
