//! The verb `quantise` from outside: levels and scale, files that the other verbs read, the
//! table of what each costs on the chip and loses there, and what it refuses.
#![cfg(feature = "cli")]

mod common;

use std::fs;

use common::{amacrine, json, line, refused};
use ndarray::Array3;
use ndarray_npy::write_npy;
use serde_json::Value;
use tempfile::TempDir;

const KERNEL: &str = "weights = [[0.0, -0.5, 0.0], [-0.5, 2.0, -0.5], [0.0, -0.5, 0.0]]\nname = \"k\"\nsource = \"test\"\n";

const SCENE: &str = "pattern:disc?width=32&height=24&frames=8&radius=6";

fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("k.toml"), KERNEL).unwrap();
    folder
}

/// Worked out by hand: the largest weight alone explains most; what is left is 1 of 5.
#[test]
fn levels_and_scale_are_the_best() {
    let folder = folder();
    let said = json(
        folder.path(),
        &[
            "quantise", "k.toml", "--to", "ternary", "--sum", "free", "--json",
        ],
    );
    let row = &said["quantised"][0];
    assert_eq!(row["scale"], 2.0);
    assert_eq!(row["levels"][1], serde_json::json!([0.0, 1.0, 0.0]));
    assert_eq!(row["taps"], 1);
    let error = row["relative_error"].as_f64().unwrap();
    assert!((error - 0.2f64.sqrt()).abs() < 1e-12);
    assert!(said.get("chip").is_none());
}

/// What is written is read by `compile`, to the same levels.
#[test]
fn the_written_kernel_compiles() {
    let folder = folder();
    let write = [
        "quantise",
        "k.toml",
        "--to",
        "q3.1",
        "-o",
        "out.toml",
        "--picture",
        "out.png",
    ];
    amacrine(folder.path(), &write).assert().success();
    let compile = [
        "compile",
        "out.toml",
        "--filter-only",
        "--effort",
        "0.01",
        "--json",
    ];
    let said = json(folder.path(), &compile);
    let levels = json(
        folder.path(),
        &["quantise", "k.toml", "--to", "q3.1", "--json"],
    );
    assert_eq!(said["kernel"], levels["quantised"][0]["levels"]);
    let picture = image::open(folder.path().join("out.png")).unwrap();
    // Two kernels of 3 by 3 cells side by side.
    assert!(picture.width() > 2 * 3 * 24 && picture.height() < 2 * 3 * 24);
}

/// The scale goes into the thresholds: times the levels it is the kernel's own.
#[test]
fn compiled_thresholds_are_divided_by_the_scale() {
    let folder = folder();
    let compile = [
        "compile",
        "k.toml",
        "--threshold",
        "24",
        "--effort",
        "0.01",
        "--json",
    ];
    let ternary = json(
        folder.path(),
        &[&compile[..], &["--to", "ternary", "--sum", "free"]].concat(),
    );
    assert_eq!(ternary["quantised_scales"][0], 2.0);
    assert_eq!(ternary["kernel"][1], serde_json::json!([0.0, 1.0, 0.0]));
    let scale = ternary["scale"].as_f64().unwrap();
    let threshold = format!("const threshold = {:?};", 12.0 * scale);
    let text = ternary["text"].as_str().unwrap();
    assert!(text.contains(&threshold), "no {threshold} in {text}");
    assert_eq!(ternary["thresholds_lsb"][0][0], 12.0 * scale);
}

/// A threshold that the chip's converter rounds away is told of.
#[test]
fn a_threshold_of_nothing_is_told_of() {
    let folder = folder();
    let said = |threshold| {
        let compile = [
            "compile",
            "k.toml",
            "--effort",
            "0.01",
            "-o",
            "out.scamp",
            "--threshold",
            threshold,
        ];
        let done = amacrine(folder.path(), &compile).assert().success();
        String::from_utf8_lossy(&done.get_output().stdout).into_owned()
    };
    let fires = "any change fires; use thresholds from ";
    assert!(said("0.1").contains(fires), "{}", said("0.1"));
    assert!(!said("200").contains(fires), "{}", said("200"));
    for threshold in ["-3", "0"] {
        let words = [&*format!("threshold is {threshold}"), "a positive number"];
        let compile = ["compile", "k.toml", "--threshold", threshold];
        refused(folder.path(), &compile, &words);
    }
}

/// Where no sensor has an event nothing is kept, and no threshold costs as much.
#[test]
fn a_silent_scene_has_no_scores() {
    let folder = TempDir::new().unwrap();
    let ask = [
        "quantise",
        "csdvs-3",
        "--to",
        "ternary",
        "--threshold",
        "5000",
        "--scene",
        "pattern:disc?width=32&height=24&frames=6",
        "--effort",
        "0.01",
    ];
    let said = json(folder.path(), &[&ask[..], &["--json"]].concat());
    let row = &said["chip"]["rows"][0];
    assert!(row["threshold_equivalent_percent"].is_null(), "{row}");
    for side in ["exact", "silicon"] {
        let score = &row["on_chip"][side];
        assert!(
            score["kept"].is_null()
                && score["tuned"].is_null()
                && score["threshold_equivalent_percent"].is_null(),
            "{score}"
        );
    }
    let table = amacrine(folder.path(), &ask).assert().success();
    let table = String::from_utf8_lossy(&table.get_output().stdout).into_owned();
    assert!(
        !table.contains("1.000") && !table.contains(" 0.0 %"),
        "{table}"
    );
}

/// A kernel that loses nothing by being quantised loses no event in exact arithmetic, and one
/// that does loses some; both cost what the programs say.
#[test]
fn the_chip_table_says_what_is_lost() {
    let folder = folder();
    let ask = [
        "quantise",
        "k.toml",
        "--to",
        "q3.1,binary",
        "--sum",
        "free",
        "--threshold",
        "20",
        "--scene",
        "pattern:disc?width=32&height=24&frames=8&radius=5",
    ];
    let ask = [&ask[..], &["--effort", "0.01", "--within", "5ms"]].concat();
    let said = json(folder.path(), &[&ask[..], &["--json"]].concat());
    let (rows, all) = (&said["chip"]["rows"], &said["chip"]["reference_events"]);
    assert!(all.as_u64().unwrap() > 100, "{all}");
    let exact = |row: usize| rows[row]["on_chip"]["exact"]["kept"].as_f64().unwrap();
    assert_eq!(exact(0), 1.0);
    assert_eq!(rows[0]["on_chip"]["exact"]["event_ratio"], 1.0);
    assert!(exact(1) < 0.9, "{}", exact(1));
    let silicon = &rows[0]["on_chip"]["silicon"];
    let kept = silicon["kept"].as_f64().unwrap();
    assert!((-0.5..0.9).contains(&kept), "{silicon}");
    for key in ["kept", "window_us", "fps", "threshold_equivalent_percent"] {
        assert_eq!(rows[0][key], silicon[key], "{key}");
        assert!(rows[0][key].is_number(), "{key}");
    }
    assert_eq!(
        rows[0]["on_chip"]["exact"]["threshold_equivalent_percent"],
        0.0
    );
    // As many events as the float kernel itself: there is no gain to tell from shape.
    let tuned = &rows[0]["on_chip"]["exact"]["tuned"];
    assert_eq!(
        (tuned["kept"].as_f64(), tuned["threshold_percent"].as_f64()),
        (Some(1.0), Some(0.0))
    );
    for row in 0..2 {
        let chip = &rows[row]["on_chip"];
        assert!(chip["words"].as_u64() > chip["filter_words"].as_u64());
        assert!(chip["array_us"].as_f64().unwrap() > 0.09 * chip["words"].as_f64().unwrap());
        assert!((1..=6).contains(&chip["registers"].as_u64().unwrap()));
    }
    let table = amacrine(folder.path(), &ask).assert().success();
    let table = String::from_utf8_lossy(&table.get_output().stdout).into_owned();
    assert!(
        table.contains("on scamp5, against the float kernel's"),
        "{table}"
    );
    assert!(table.contains("1.000     0.0 %   1.000"), "{table}");
}

/// Events matched within a window of less than no table are not asked for.
#[test]
fn a_window_without_a_table_is_refused() {
    let folder = folder();
    refused(
        folder.path(),
        &["quantise", "k.toml", "--to", "ternary", "--within", "9ms"],
        &["--within", "--threshold"],
    );
}

/// A kernel with more words than the chip stores has a row that says so.
#[test]
fn what_does_not_fit_has_a_row() {
    let folder = folder();
    let row = |y: i32| -> Vec<f64> {
        (0..15)
            .map(|x| f64::from((x * x * 7 + y * 13 + x * y * 5) % 2039) / 2039.0)
            .collect()
    };
    let rows: Vec<_> = (0..15).map(row).collect();
    let text = format!("name = \"large\"\nsource = \"test\"\nweights = {rows:?}\n");
    fs::write(folder.path().join("large.toml"), text).unwrap();
    let ask = [
        "quantise",
        "large.toml",
        "--to",
        "q1.11",
        "--threshold",
        "20",
        "--scene",
        SCENE,
    ];
    let ask = [&ask[..], &["--effort", "0", "--json"]].concat();
    let said = json(folder.path(), &ask);
    let why = said["chip"]["rows"][0]["refused"].as_str().unwrap();
    assert!(
        why.contains("more than the 1024 that scamp5 holds"),
        "{why}"
    );
}

/// What is wrong with a kernel is told with its file, and its number where that holds several.
#[test]
fn kernels_are_told_by_their_files() {
    let folder = folder();
    let at = folder.path();
    let mut stack = Array3::<f32>::zeros((3, 3, 3));
    stack[[0, 1, 1]] = 1.0;
    stack[[1, 1, 1]] = 0.5;
    stack[[2, 1, 0]] = 0.3;
    write_npy(at.join("stack.npy"), &stack).unwrap();
    let compile = ["compile", "k.toml,stack.npy", "--effort", "0"];
    for more in [
        &["--threshold", "8"][..],
        &["--threshold", "8", "--memory", "shared"],
        &["--filter-only"],
    ] {
        let all = [&compile[..], more].concat();
        refused(at, &all, &["stack.npy[2], row 1, column 0: 0.3", "--to"]);
    }
    stack[[2, 1, 0]] = 0.0;
    write_npy(at.join("stack.npy"), &stack).unwrap();
    let all = [&compile[..], &["--filter-only"]].concat();
    refused(at, &all, &["stack.npy[2] has no weight but 0"]);
}

/// The thresholds that are suggested for a memory in bits are the least that work on the chip, of all
/// kinds together and of quantised weights.
#[test]
fn suggested_thresholds_work() {
    let folder = TempDir::new().unwrap();
    let compiled = |request: &str, thresholds: &str| {
        let mut all = vec!["compile", "--effort", "0", "--threshold", thresholds];
        all.extend(request.split(' '));
        amacrine(folder.path(), &all).output().unwrap()
    };
    for (request, own) in [
        ("rgc-5x5 --to ternary --memory bits:3", &[1.0][..]),
        ("rgc-5x5 --to int-5 --memory bits:3", &[3.0]),
        ("csdvs-3,sobel-x --memory bits:2", &[1.0, 2.0]),
    ] {
        let times = |factor: f64| {
            let all = own.iter().map(|own| (own * factor).to_string());
            all.collect::<Vec<_>>().join(",")
        };
        let refused = compiled(request, &times(1.0));
        let said = line(&refused.stderr);
        let (_, advice) = said.split_once("take higher thresholds: ").expect(&said);
        let factor: f64 = advice.split(' ').next().unwrap().parse().unwrap();
        // Refused, or taken with a warning.
        let works = |thresholds: &str| {
            let done = compiled(request, thresholds);
            done.status.success() && !line(&done.stderr).contains("fires again and again")
        };
        assert!(works(&times(factor)), "{said}");
        assert!(!works(&times(factor * 0.998)), "{said}");
    }
}

#[test]
fn bad_input_is_named() {
    let folder = folder();
    let at = folder.path();
    refused(
        at,
        &["quantise", "k.toml", "--to", "ternery"],
        &["ternery", "po2-N"],
    );
    for verb in [&["compile"][..], &["quantise", "--to", "ternary"]] {
        let asked = [verb, &["k.toml", "--rate", "2"]].concat();
        refused(at, &asked, &["--rate", "`amacrine design`", "feasibility"]);
    }
    refused(
        at,
        &["quantise", "none.toml", "--to", "binary"],
        &["none.toml", "rgc-5x5"],
    );
    refused(
        at,
        &["quantise", "k.toml", "--to", "q3.1,ternary", "-o", "x.toml"],
        &["2 were asked for", "give one quantiser"],
    );
    for (threshold, said) in [("0", "threshold is 0"), ("-3", "threshold is -3")] {
        refused(
            at,
            &[
                "quantise",
                "k.toml",
                "--to",
                "ternary",
                "--threshold",
                threshold,
            ],
            &[said, "positive"],
        );
    }
    refused(
        at,
        &["quantise", "k.toml", "--to", "ternary", "--scene", SCENE],
        &["--threshold"],
    );
    refused(
        at,
        &[
            "quantise",
            "k.toml",
            "--to",
            "ternary",
            "--threshold",
            "9",
            "--chip",
            "scamp9",
        ],
        &["scamp9", "scamp5"],
    );
    assert_eq!(at.read_dir().unwrap().count(), 1, "files were left");
}

/// Every verb that takes kernels takes them alike: with spaces, with commas, and as `run` has them;
/// with one threshold for all or one for each.
#[test]
fn kernels_and_thresholds_are_given_alike() {
    let folder = folder();
    let at = folder.path();
    let rest = ["--to", "ternary", "--json"];
    let quantised = |kernels: &[&str]| json(at, &[&["quantise"], kernels, &rest[..]].concat());
    let apart = quantised(&["sobel-x", "dog"]);
    assert_eq!(apart, quantised(&["sobel-x,dog"]));
    assert_eq!(apart, quantised(&["--kernel", "sobel-x,dog"]));
    for verb in ["quantise", "waterfall", "feasibility", "design", "compile"] {
        let asked = [verb, "sobel-x", "dog", "--threshold", "20,30,40"];
        let quantiser = ["--to", "ternary"];
        refused(
            at,
            &[&asked[..], &quantiser].concat(),
            &["3 thresholds for 2 kernels", "one for each"],
        );
    }
    let line = [
        "compile",
        "sobel-x",
        "dog",
        "--threshold",
        "200,100",
        "--effort",
        "0.01",
    ];
    let compiled = json(at, &[&line[..], &rest].concat());
    let [sobel, dog] = [0, 1].map(|kind| {
        let number = |what: &Value| what.as_f64().unwrap();
        let lsb = number(&compiled["thresholds_lsb"][kind][0]);
        let unit = number(&compiled["quantised_scales"][kind]) / number(&compiled["scales"][kind]);
        lsb * unit
    });
    assert!((sobel / dog - 2.0).abs() < 1e-9, "{compiled}");
}
