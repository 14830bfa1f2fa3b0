//! What `compile` says of its program is what the program does: how much of the filter comes out of
//! other chips, how far in from the border events differ, and that nothing comes out of some.

#![cfg(feature = "cli")]

mod common;

use std::{collections::BTreeSet, fmt::Write as _, fs, path::Path};

use common::{amacrine, good, json, line, refused};
use ndarray::{Array2, Array3};
use serde_json::Value;
use tempfile::TempDir;

fn kernel(folder: &Path, name: &str, rows: &[&[f64]]) {
    let flat: Vec<f64> = rows.concat();
    let kernel = Array2::from_shape_vec((rows.len(), rows[0].len()), flat).unwrap();
    ndarray_npy::write_npy(folder.join(name), &kernel).unwrap();
}

/// Sums that reach the end of the range with a chip's errors on top, weights of two digits, a filter
/// of many words, few values of a learned centre-surround.
#[test]
fn noise_is_that_of_other_chips() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    kernel(folder, "slope.npy", &[&[1.0, 2.0, 3.0]]);
    let spot: [&[f64]; 3] = [&[1.0, 2.0, 1.0], &[2.0, -12.0, 2.0], &[1.0, 2.0, 1.0]];
    kernel(folder, "spot.npy", &spot);
    let binomial = [1.0, 6.0, 15.0, 20.0, 15.0, 6.0, 1.0];
    let rows = binomial.map(|a| binomial.map(|b| a * b / 4096.0));
    let rows: Vec<&[f64]> = rows.iter().map(|row| &row[..]).collect();
    kernel(folder, "blur.npy", &rows);
    kernel(folder, "box.npy", &[&[1.0; 3][..]; 3]);
    for asked in [
        &["slope.npy", "--objective", "words"][..],
        &["spot.npy"],
        &["blur.npy"],
        &["csdvs-5", "--to", "int-5"],
        &["box.npy", "--objective", "words", "--input=-20..20"],
    ] {
        let more = ["--filter-only", "--effort", "0.1", "-o", "f.scamp"];
        let told = json(folder, &[&["compile"], asked, &more].concat());
        let it = &told["on_chip"][0];
        let [amplitude, noise, correlation] =
            ["amplitude", "noise", "correlation"].map(|key| it[key].as_f64().unwrap());
        let into = told["into"][0].as_str().unwrap();
        for seed in ["1", "2"] {
            let range = format!("--input={}..{amplitude}", -amplitude);
            let ran = json(folder, &["asm", "f.scamp", &range, "--seed", seed]);
            let all = ran["proof"]["registers"].as_array().unwrap();
            let own = all.iter().find(|it| it["register"] == into).unwrap();
            let got = own["noise_lsb"].as_f64().unwrap();
            assert!(
                (noise / got - 1.0).abs() < 0.05,
                "{asked:?}: {noise} LSB of noise, chip {seed} has {got}"
            );
            let got = own["correlation"].as_f64().unwrap();
            assert!(
                (correlation - got).abs() < 0.01,
                "{asked:?}: {correlation} {got}"
            );
        }
    }
}

/// Two kernels that leave no room for the border: events of the float model and of the exact array
/// differ as far in as is told, and no farther.
#[test]
fn events_differ_as_near_to_the_border_as_is_told() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let weight =
        |(k, y, x): (usize, usize, usize)| (((7 * k + 3 * y + 5 * x + y * x) % 3) as f64) - 1.0;
    ndarray_npy::write_npy(
        folder.join("two.npy"),
        &Array3::from_shape_fn((2, 5, 5), weight),
    )
    .unwrap();
    let sensor = "response = \"identity\"\nmemory = \"filtered-snap\"\nborder = \"zero\"\n\
                  [[channel]]\nkernel = \"two.npy\"\nthreshold = { on = 63, off = 63 }\n";
    fs::write(folder.join("two.toml"), sensor).unwrap();
    let asked = [
        "compile",
        "--sensor",
        "two.toml",
        "--objective",
        "exact",
        "--effort",
        "0.05",
    ];
    let told = json(folder, &[&asked[..], &["-o", "two.scamp"]].concat());
    let far = told["wrong_from_border_px"].as_u64().unwrap();
    assert!(far > 0, "it is right at the border");
    refused(
        folder,
        &[&asked[..], &["--border"]].concat(),
        &["right up to the border", "--effort"],
    );
    let scene = "pattern:bar?width=40&height=32&frames=8&angle=30";
    good(
        folder,
        &[
            "run",
            "--scene",
            scene,
            "--sensor",
            "two.toml",
            "--events",
            "float.csv",
        ],
    );
    let exact = [
        "--image",
        scene,
        "--domain",
        "exact",
        "--events",
        "array.csv",
    ];
    good(
        folder,
        &[&["exec", "two.scamp", "--const", "slots=2000"], &exact[..]].concat(),
    );
    let events = |file: &str| -> BTreeSet<String> {
        let text = fs::read_to_string(folder.join(file)).unwrap();
        text.lines().map(str::to_owned).collect()
    };
    let (float, array) = (events("float.csv"), events("array.csv"));
    assert!(float.len() > 500, "{} events", float.len());
    let mut farthest = 0;
    for line in float.symmetric_difference(&array) {
        let fields: Vec<u64> = line.split(',').map(|it| it.parse().unwrap()).collect();
        let (x, y) = (fields[1], fields[2]);
        farthest = farthest.max([x, 39 - x, y, 31 - y].into_iter().min().unwrap() + 1);
    }
    assert!(
        (1..=far).contains(&farthest),
        "{farthest} px in, {far} told"
    );
}

/// A kernel of which nothing is left in the chip's range is compiled for its words with a warning.
#[test]
fn nothing_that_comes_out_is_warned_of() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    kernel(folder, "large.npy", &[&[1.0; 7][..]; 7]);
    let asked = [
        "compile",
        "large.npy",
        "--filter-only",
        "--objective",
        "words",
        "--effort",
        "0.1",
    ];
    let ran = common::amacrine(folder, &asked).output().unwrap();
    let said = common::line(&ran.stderr);
    assert!(
        ran.status.success() && said.contains("the chip's errors hide the kernel"),
        "{said}"
    );
    // Weights of one size have no digit to spare.
    assert!(!said.contains("digits"), "{said}");
    assert!(said.contains("leave --objective out"), "{said}");
    let asked = [
        "compile",
        "csdvs-3",
        "--to",
        "ternary",
        "--filter-only",
        "--effort",
        "0.02",
    ];
    let ran = common::amacrine(folder, &asked).output().unwrap();
    assert!(ran.status.success());
    let said = common::line(&ran.stderr);
    assert!(!said.contains("errors hide the kernel") && !said.contains("more noise than signal"));
    // A thousandth of the input is a fifth of what the chip adds.
    kernel(folder, "tiny.npy", &[&[1.0 / 1024.0]]);
    let tiny = ["compile", "tiny.npy", "--filter-only", "--effort", "0.02"];
    let ran = common::amacrine(folder, &tiny).output().unwrap();
    let said = common::line(&ran.stderr);
    assert!(
        ran.status.success() && said.contains("more noise than signal"),
        "{said}"
    );
    kernel(folder, "zero.npy", &[&[0.0; 3]]);
    let zero = ["compile", "zero.npy", "--filter-only"];
    refused(folder, &zero, &["no weight but 0", "nothing comes of it"]);
    // What needs no word takes no time.
    kernel(folder, "one.npy", &[&[1.0]]);
    let said = good(folder, &["compile", "one.npy", "--filter-only"]);
    assert!(
        said.contains("time      none: the result is the input"),
        "{said}"
    );
    assert!(said.contains("optimal: no word is needed"), "{said}");
    assert!(!said.contains("inf") && !said.contains("-0.00"), "{said}");
}

/// Without a file to write to, the program is printed, and what is said of it as its comments.
#[test]
fn what_is_printed_is_a_program() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let compile = [
        "compile",
        "sobel-x",
        "--threshold",
        "100",
        "--effort",
        "0.1",
    ];
    for (more, file) in [("scamp", "p.scamp"), ("cpp", "p.cpp")] {
        let said = good(folder, &[&compile[..], &["--as", more]].concat());
        assert!(said.contains("\n// words "), "{said}");
        fs::write(folder.join(file), said).unwrap();
        good(folder, &["asm", file]);
    }
}

/// Without light a program is said to have been in the dark.
#[test]
fn a_program_without_light_is_told_so() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let asked = [
        "compile",
        "csdvs-3",
        "--to",
        "ternary",
        "--threshold",
        "24",
        "--effort",
        "0.02",
    ];
    good(folder, &[&asked[..], &["-o", "p.cpp"]].concat());
    let ran = ["exec", "p.cpp", "--frames", "3", "--events", "e.csv"];
    let ran = common::amacrine(folder, &ran).output().unwrap();
    let said = common::line(&ran.stderr);
    assert!(ran.status.success() && said.contains("--image"), "{said}");
}

/// Where no plan keeps enough events in exact arithmetic, and the one in range is halved until its
/// threshold is 0, the one that decides best on the chip is taken.
#[test]
fn a_threshold_is_set_where_any_plan_has_one() {
    let folder = tempfile::tempdir().unwrap();
    let asked = [
        "compile",
        "rgc-5x5",
        "--to",
        "int-3",
        "--threshold",
        "13.13",
        "--effort",
        "0.1",
    ];
    let words = |objective: &[&str]| {
        let said = json(
            folder.path(),
            &[&asked[..], objective, &["--json"]].concat(),
        );
        said["words"].clone()
    };
    assert_eq!(words(&[]), words(&["--objective", "events"]));
    let said = good(folder.path(), &asked);
    assert!(!said.contains("any change fires"), "{said}");
}

/// A threshold that no light reaches is told, one within reach is not; an input that is its own result
/// is not taken for nothing.
#[test]
fn thresholds_that_nothing_reaches_are_told() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    kernel(folder, "id.npy", &[&[1.0]]);
    let said = |threshold: &str| {
        let asked = [
            "compile",
            "id.npy",
            "--threshold",
            threshold,
            "-o",
            "p.scamp",
        ];
        let ran = common::amacrine(folder, &asked).output().unwrap();
        common::line(&ran.stderr)
    };
    assert!(said("300").contains("no light gives an event: kind 0 has a threshold of"));
    assert_eq!(said("100"), "");
}

/// Results lie in registers that are not kept, wherever others are free.
#[test]
fn results_stay_out_of_what_is_kept() {
    let folder = TempDir::new().unwrap();
    let asked = [
        "compile",
        "sobel-x",
        "sobel-y",
        "--filter-only",
        "--effort",
        "0.1",
        "--keep",
        "B",
    ];
    let told = json(folder.path(), &asked);
    assert_eq!(told["into"], serde_json::json!(["A", "C"]));
    let words = told["text"].as_str().unwrap();
    assert!(
        !words.contains("bus(B") && !words.contains(", B"),
        "{words}"
    );
}

/// What `compile` says of its program is what `asm` says of it, and what it says of its range holds.
#[test]
fn two_verbs_say_the_same_of_a_program() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    kernel(
        folder,
        "k.npy",
        &[
            &[2.0, 1.0, 0.0, -2.0, -1.0],
            &[-3.0, -3.0, -3.0, -2.0, 2.0],
            &[1.0, 3.0, 0.0, 1.0, 3.0],
            &[2.0, 1.0, 0.0, 0.0, 3.0],
            &[-2.0, 2.0, 1.0, -3.0, -1.0],
        ],
    );
    for objective in ["exact", "silicon"] {
        let arguments = [
            "compile",
            "k.npy",
            "--threshold",
            "640",
            "--objective",
            objective,
            "--effort",
            "0.3",
        ];
        let said = json(
            folder,
            &[&arguments[..], &["-o", "k.scamp", "--json"]].concat(),
        );
        let asm = json(folder, &["asm", "k.scamp", "--json"]);
        assert_eq!(
            good(folder, &["asm", "k.scamp"])
                .lines()
                .find(|line| line.starts_with("store"))
                .and_then(|line| line.split_whitespace().nth(1)),
            asm["stored_words"]
                .as_u64()
                .map(|n| n.to_string())
                .as_deref()
        );
        let text = good(folder, &[&arguments[..], &["-o", "k.scamp"]].concat());
        let store = format!("store     {} words", asm["stored_words"]);
        assert!(text.contains(&store), "{store}: {text}");
        if objective == "silicon" {
            // Behind the filter, memory less drive may be twice as large.
            assert!(
                text.contains("no store of a filter saturates for light of at most")
                    && !text.contains("nothing saturates"),
                "{text}"
            );
        }
        if objective == "exact" {
            assert!(
                text.contains(
                    "nothing saturates for light up to 254 of 255, but the difference from the memory may"
                ),
                "{text}"
            );
            assert_eq!(said["saturating_stores"], 0);
            let within = said["exact_within_lsb"][0].as_f64().unwrap();
            assert!(within > 60.0, "{within}");
            assert!(
                said["on_chip"][0]["correlation"].as_f64().unwrap() > 0.5,
                "{text}"
            );
        }
    }
}

/// Light up to what is told has the same events whether registers are limited or not: that of a result
/// that saturates does not pass for exact.
#[test]
fn what_is_said_to_be_exact_is() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let compile = ["compile", "oblique-45", "--threshold", "60", "--json"];
    let said = json(folder, &[&compile[..], &["-o", "p.scamp"]].concat());
    let within = said["exact_within_lsb"][0].as_f64().unwrap();
    // Three weights of 1, halved once.
    assert!(within > 40.0 && within <= 63.5, "{within}");
    // The kernel's bright side, then 1.4 times as bright.
    let brightest = (2.0 * within).floor();
    let light = Array3::from_shape_fn((3, 7, 7), |(t, y, x)| {
        let is_lit = [(2, 3), (2, 4), (3, 4)].contains(&(y, x));
        let level = if t == 0 {
            (brightest / 1.4).floor()
        } else {
            brightest
        };
        if is_lit { level } else { 0.0 }
    });
    ndarray_npy::write_npy(folder.join("l.npy"), &light).unwrap();
    let events = |clip: &str| {
        let exec = [
            "exec", "p.scamp", "--image", "l.npy", "--fps", "100", "--frames", "3",
        ];
        good(
            folder,
            &[&exec[..], &["--clip", clip, "--events", "e.csv"]].concat(),
        );
        fs::read_to_string(folder.join("e.csv")).unwrap()
    };
    let clipped = events("on");
    assert!(clipped.lines().count() > 1, "{clipped}");
    assert_eq!(clipped, events("off"));
}

/// Where a threshold becomes 0 on the chip, the light is not halved for it, and what to take instead is
/// what the program of the fewest halvings needs.
#[test]
fn no_halving_is_chosen_that_loses_a_threshold() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let compiled = |threshold: &str| {
        let compile = [
            "compile",
            "dvs",
            "--threshold",
            threshold,
            "--effort",
            "0.02",
        ];
        json(folder, &[&compile[..], &["--json"]].concat())
    };
    let low = compiled("0.9");
    assert_eq!(low["prescale_bits"], 0);
    let note = low["notes"][0].as_str().unwrap();
    assert!(
        note.contains("any change fires; use thresholds from 2.0 on"),
        "{note}"
    );
    for threshold in ["1.2", "2.0"] {
        let said = compiled(threshold);
        assert_eq!(said["thresholds_on_chip_lsb"][0][0], 1.0, "{threshold}");
        assert_eq!(said["notes"], serde_json::json!([]), "{threshold}");
    }
}

/// Weights that are kept as they are keep their sum, and a kernel of zeros is told by its number.
#[test]
fn kernels_that_cannot_be_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    kernel(
        folder,
        "a.npy",
        &[&[1.0, 2.0, 1.0], &[2.0, 4.0, 2.0], &[1.0, 2.0, 1.0]],
    );
    kernel(folder, "zero.npy", &[&[0.0; 3], &[0.0; 3], &[0.0; 3]]);
    refused(
        folder,
        &["compile", "a.npy", "--filter-only", "--sum", "zero"],
        &["exact weights keep the sum", "--to"],
    );
    refused(
        folder,
        &[
            "compile",
            "a.npy",
            "zero.npy",
            "--filter-only",
            "--into",
            "A,B",
        ],
        &["zero.npy has no weight but 0"],
    );

    // Not by each key that a kernel file does not have.
    let text = "response = \"identity\"\nmemory = \"filtered-snap\"\n[[channel]]\nkernel = \"dvs\"\nthreshold = { on = 9, off = 9 }\n";
    fs::write(folder.join("own.toml"), text).unwrap();
    refused(
        folder,
        &["compile", "own.toml", "--threshold", "9"],
        &[
            "own.toml is a sensor file, not a kernel file",
            "--sensor own.toml",
        ],
    );
    refused(
        folder,
        &["compile", "a.npy", "--filter-only", "--input", "0..256"],
        &["a register holds -128 to 127 LSB"],
    );
    // Names with commas between, as the other verbs take them.
    let arguments = [
        "compile",
        "sobel-x,sobel-y",
        "--filter-only",
        "--into",
        "A,B",
        "--json",
    ];
    let said = json(folder, &[&arguments[..], &["--effort", "0.1"]].concat());
    assert_eq!(said["into"].as_array().unwrap().len(), 2);
}

/// With one memory for all kinds a wrong event at the border is remembered, and its neighbours see
/// that in the next frame: how far in events may differ is not one number.
#[test]
fn what_is_wrong_at_the_border_spreads_by_a_shared_memory() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let chip = folder.join("edge");
    fs::create_dir(&chip).unwrap();
    let text = "name = \"edge\"\ntitle = \"t\"\nextends = \"scamp5\"\n[figure.edge]\nanalogue = { value = -3, unit = \"LSB\", source = \"test\", evidence = \"guess\" }\n";
    fs::write(chip.join("device.toml"), text).unwrap();
    let ask = |memory| {
        let line = "compile sobel-x --threshold 80 --chip edge --effort 0.02 --memory";
        let words: Vec<&str> = line.split(' ').chain([memory]).collect();
        let text = good(folder, &words);
        (text, json(folder, &[&words[..], &["--json"]].concat()))
    };
    let (text, told) = ask("shared");
    assert!(text.contains("further with each frame"), "{text}");
    assert_eq!(told["border"], false);
    assert!(told["wrong_from_border_px"].is_null(), "{told}");
    let (text, told) = ask("analogue");
    assert!(text.contains("within 1 pixel of it"), "{text}");
    assert_eq!(told["wrong_from_border_px"], 1);
}

/// Of five registers, what is right at the border takes twice the words and loses events on the chip:
/// the border of 256x256 cells is not worth that, unless it is asked for.
#[test]
fn the_border_costs_no_more_than_it_is_worth() {
    let folder = TempDir::new().unwrap();
    let chip = folder.path().join("five");
    fs::create_dir(&chip).unwrap();
    let text = "name = \"five\"\ntitle = \"five\"\nextends = \"scamp5\"\n[registers]\nanalogue = [\"A\", \"B\", \"C\", \"D\", \"E\", \"NEWS\"]\n";
    fs::write(chip.join("device.toml"), text).unwrap();
    let words = [
        "compile",
        "rgc-5x5",
        "--to",
        "ternary",
        "--threshold",
        "128",
        "--chip",
        "five",
        "--json",
    ];
    let compiled = |more: &[&str]| json(folder.path(), &[&words[..], more].concat());
    let said = compiled(&["--effort", "0.1"]);
    let f1 = |said: &Value| said["decided"][0]["silicon"].as_f64();
    let right = compiled(&["--border"]);
    assert_eq!(said["border"], false);
    assert_eq!(right["border"], true);
    assert!(f1(&said) > f1(&right));
}

/// A kernel of one weight of 1 takes no word: its input is the result, and nothing is lost.
#[test]
fn a_filter_without_words_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let said = common::json(folder.path(), &["compile", "dvs", "--filter-only"]);
    let on_chip = &said["on_chip"][0];
    assert_eq!(
        (&on_chip["correlation"], &on_chip["noise"]),
        (&1.0.into(), &0.0.into())
    );
    assert!(on_chip["signal"].as_f64().unwrap() > 0.5, "{on_chip}");
}

/// Two kinds as a sensor file, with these lines at its head and each of these in a kind.
fn two_kinds(folder: &Path, name: &str, head: &str, kinds: [&str; 2]) {
    let mut text = format!("response = \"identity\"\nborder = \"zero\"\n{head}\n");
    for (kind, name) in kinds.into_iter().zip(["spot", "edge"]) {
        let _ = writeln!(text, "[[channel]]\nname = \"{name}\"\n{kind}");
    }
    fs::write(folder.join(name), text).unwrap();
}

const SPOT: &str = "kernel = [[0, 0, 0], [0, 1, 0], [0, 0, 0]]\nthreshold = ";

/// What of a sensor no program follows is refused by every verb that makes one, with the reason.
#[test]
fn what_no_program_follows_is_refused_by_every_verb() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let laplacian = "kernel = \"laplacian\"\nthreshold = { on = 60, off = 60 }";
    let log = format!("{laplacian}\nlog-temporal = true");
    let snap = "memory = \"filtered-snap\"";
    two_kinds(folder, "log.toml", snap, [laplacian, &log]);
    two_kinds(folder, "own.toml", "memory = \"raw-snap\"", [laplacian; 2]);
    for verb in [
        &["compile", "--sensor", "log.toml"][..],
        &["quantise", "log.toml", "--to", "ternary"],
        &["feasibility", "log.toml"],
        &["waterfall", "log.toml"],
        &["design", "log.toml"],
    ] {
        let words = [
            "log.toml, channel 1: log-temporal cannot run on the chip, which takes no logarithm",
            "without `log-temporal = true`",
        ];
        refused(folder, verb, &words);
    }
    let words = [
        "own.toml: each kind has its own memory of the pixel, which the compiler supports on no chip",
    ];
    refused(folder, &["compile", "--sensor", "own.toml"], &words);
}

/// What can never fit is said alone; of what can be mended, all.
#[test]
fn all_that_is_to_be_mended_is_said_at_once() {
    let folder = TempDir::new().unwrap();
    let told = |sensor: &str| {
        let asked = ["compile", "--sensor", sensor];
        let done = amacrine(folder.path(), &asked).assert().failure();
        line(&done.get_output().stderr)
    };
    for (sensor, never) in [
        (
            "csdvs-mesh",
            "has a resistor mesh, which cannot be compiled to a program",
        ),
        ("mosaic", "has a pattern of kernels"),
    ] {
        let told = told(sensor);
        assert!(told.contains(never), "{told}");
        assert!(!told.contains("its memory steps"), "{told}");
    }
    let mended = told("raw-snap");
    for words in [
        "its events have the pixel's sign",
        "`polarity = \"filtered\"`",
        "is not a multiple of 1/4096",
        "quantise the kernel with --to",
    ] {
        assert!(mended.contains(words), "{mended}");
    }
    let mended = told("dvs");
    for words in ["its response is not linear", "its memory steps"] {
        assert!(mended.contains(words), "{mended}");
    }
}

/// With a memory of the pixel a result is the change itself: half of what a drive changes by. A kind
/// without an event has none to keep.
#[test]
fn a_kind_that_never_fires_is_told_by_its_name() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let edge = "kernel = \"laplacian\"\nthreshold = { on = 100, off = 100 }";
    let asked = ["compile", "--sensor", "s.toml", "--effort", "0.05"];
    let told = |spot: &str| {
        let spot = format!("{SPOT}{spot}");
        let head = "memory = \"raw-snap\"\nshared = true";
        two_kinds(folder, "s.toml", head, [&spot, edge]);
        let ran = common::amacrine(folder, &asked).output().unwrap();
        let said = String::from_utf8(ran.stdout).unwrap();
        let decided = json(folder, &[&asked[..], &["--json"]].concat())["decided"].clone();
        (common::line(&ran.stderr), said, decided)
    };
    let (warned, said, decided) = told("{ on = 300, off = 300 }");
    assert!(
        warned.contains("no light gives an event: kind 0 (spot) has a threshold of"),
        "{warned}"
    );
    assert!(decided[0].is_null(), "{decided}");
    assert!(decided[1]["silicon"].as_f64().unwrap() > 0.8, "{decided}");
    assert!(said.contains("events    F1 -, 0."), "{said}");
    let (warned, _, decided) = told("{ on = 300, off = 100 }");
    assert!(
        warned.contains("no light gives an event of one sign: ON: kind 0 (spot)"),
        "{warned}"
    );
    assert!(decided[0]["silicon"].is_number(), "{decided}");
    assert_eq!(told("{ on = 100, off = 100 }").0, "");
}

/// A program has so many kinds as it says that the chip carries, and no more: what is there once is not
/// counted for each.
#[test]
fn so_many_kinds_are_carried_as_have_a_program() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let registers = "[registers]\nanalogue = [\"A\", \"B\", \"C\", \"D\", \"NEWS\"]\n";
    common::chip(folder, "four", registers);
    let store = "[figure.store]\nwords = { value = 95, unit = \"words\", source = \"test\", evidence = \"guess\" }\n";
    common::chip(folder, "small", store);
    let compiled = |kinds: usize, chip: &str| {
        let kernels = vec!["sobel-x"; kinds].join(",");
        let asked = [
            "compile",
            &kernels,
            "--threshold",
            "20",
            "--memory",
            "shared",
        ];
        let more = ["--chip", chip, "--effort", "0.3", "--json"];
        let ran = common::amacrine(folder, &[&asked[..], &more].concat())
            .output()
            .unwrap();
        serde_json::from_slice::<Value>(&ran.stdout).ok()
    };
    for (chip, most) in [("scamp5", 16), ("four", 5)] {
        for kinds in [1, 5] {
            let told = compiled(kinds, chip).unwrap();
            assert_eq!(told["carried"], most, "{kinds} on {chip}");
        }
    }
    let told = compiled(1, "scamp5").unwrap();
    let memory = told["memory"].as_str().unwrap();
    assert!(
        memory.ends_with("16 kinds like these, the most of one program"),
        "{memory}"
    );
    let most = compiled(1, "small").unwrap()["carried"].as_u64().unwrap();
    let most = usize::try_from(most).unwrap();
    assert!((3..=5).contains(&most), "{most}");
    assert!(compiled(most, "small").is_some());
    assert!(compiled(most + 1, "small").is_none());
}

/// Where no memory is found on the chip, one that another chip has is named.
#[test]
fn another_chip_with_another_memory_is_advised() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let registers = "[registers]\nanalogue = [\"A\", \"B\", \"C\", \"NEWS\"]\n";
    common::chip(folder, "three", registers);
    let seven = ["sobel-x"; 7].join(",");
    let asked = ["compile", &seven, "--threshold", "20", "--memory", "bits:8"];
    let said = refused(
        folder,
        &[&asked[..], &["--chip", "three"]].concat(),
        &["try --chip scamp5", "--memory shared"],
    );
    assert!(!said.contains("no memory was found"), "{said}");
}

/// The fewest words are never more than those of a program that saturates no more.
#[test]
fn the_fewest_words_are_no_more_than_those_of_an_exact_program() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let of = |objective: &str| {
        let kernels = "sobel-x,laplacian,csdvs-3,sobel-y";
        let asked = ["compile", kernels, "--to", "int-5", "--threshold", "60"];
        let more = ["--memory", "shared", "--effort", "0.05", "--objective"];
        let told = json(
            folder,
            &[&asked[..], &more, &[objective, "--json"]].concat(),
        );
        told["words"].as_u64().unwrap()
    };
    let (fewest, exact) = (of("words"), of("exact"));
    assert!(fewest <= exact, "{fewest} and {exact}");
    // Of many digits, halved so often that the search for the fewest words alone takes half as many more.
    let rows: [&[f64]; 3] = [
        &[-94.0, 26.0, -57.0],
        &[-117.0, 67.0, -65.0],
        &[-16.0, -49.0, -74.0],
    ];
    kernel(folder, "digits.npy", &rows);
    let of = |objective: &str| {
        let asked = ["compile", "digits.npy", "--threshold", "4096", "--json"];
        let more = ["--effort", "0.02", "--objective", objective];
        json(folder, &[&asked[..], &more].concat())["words"].as_u64()
    };
    let (fewest, exact) = (of("words"), of("exact"));
    assert!(fewest <= exact, "{fewest:?} and {exact:?}");
}

/// A filter of large weights is halved on the way without a range too, and says by how much its
/// result is less than its kernel's; one of which enough comes out keeps its scale.
#[test]
fn a_filter_of_large_weights_says_its_scale() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let eight: [&[f64]; 3] = [
        &[90.0, -13.0, 44.0],
        &[58.0, -105.0, 31.0],
        &[-27.0, 71.0, 119.0],
    ];
    kernel(folder, "eight.npy", &eight);
    let compile = ["compile", "eight.npy", "--filter-only"];
    let compile = [&compile[..], &["--effort", "0.05"]].concat();
    let told = json(
        folder,
        &[&compile[..], &["--json", "-o", "f.scamp"]].concat(),
    );
    assert_eq!(
        (&told["prescale_bits"], &told["scale"]),
        (&Value::from(6), &Value::from(0.015_625))
    );
    let correlation = told["on_chip"][0]["correlation"].as_f64().unwrap();
    assert!(correlation > 0.99, "{correlation}");
    // With larger inputs a store saturates; what is told is the input, not what is left of it.
    let largest = told["largest_input_lsb"].as_f64().unwrap();
    let range = |most: f64| format!("--input=-{most}..{most}");
    let saturates = |most: f64| {
        let said = good(folder, &["asm", "f.scamp", &range(most)]);
        said.contains("can saturate:")
    };
    assert!(
        !saturates(largest - 0.02) && saturates(largest + 0.02),
        "{largest}"
    );
    let head = "// the results are those of the kernels over 64: 6 halvings on the way";
    let text = fs::read_to_string(folder.join("f.scamp")).unwrap();
    assert_eq!(text.lines().next(), Some(head));
    let said = good(folder, &compile);
    assert!(said.starts_with(head), "{said}");
    assert!(
        said.contains(" LSB, the kernel's result over 64\n"),
        "{said}"
    );
    assert!(
        said.contains("// range     the input is halved 6 times on the way"),
        "{said}"
    );
    let read = good(folder, &["asm", "f.scamp"]);
    assert!(read.contains("= 1/64 A under"), "{read}");
    let front = [&compile[..], &["--front", "--json"]].concat();
    let front = json(folder, &front);
    let words = told["filter_words"].as_u64();
    for row in front.as_array().unwrap() {
        let dominates = row["words"].as_u64() <= words
            && row["on_chip"]["correlation"].as_f64() > Some(correlation);
        assert!(!dominates, "{row} and {words:?} words of {correlation}");
    }
    let sobel = ["compile", "sobel-x", "--filter-only", "--effort", "0.05"];
    let told = json(folder, &[&sobel[..], &["--json"]].concat());
    assert_eq!(told["prescale_bits"], 0);
    assert!(!told["text"].as_str().unwrap().contains("//"));
}

/// Levels of a memory in bits are absolute: what transfer errors leave in a drive, in the middle or near
/// the border, moves none beyond the last of them, or that is told with what serves.
#[test]
fn a_memory_in_bits_is_quiet_or_says_so() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let digits: [&[f64]; 5] = [
        &[21.0, -9.0, 30.0, 4.0, -17.0],
        &[25.0, 18.0, -6.0, 29.0, 11.0],
        &[-14.0, -27.0, -22.0, -31.0, -3.0],
        &[-28.0, -12.0, -19.0, 15.0, -16.0],
        &[23.0, -20.0, 27.0, 2.0, -13.0],
    ];
    kernel(folder, "digits.npy", &digits);
    let fired = |asked: &[&str]| {
        let compile = ["--effort", "0.02", "--json", "-o", "f.scamp"];
        let told = json(folder, &[&["compile"], asked, &compile].concat());
        let exec = ["exec", "f.scamp", "--frames", "6", "--domain", "silicon"];
        let still = [
            "--seed",
            "1",
            "--image",
            "pattern:static?width=128&height=128",
        ];
        let ran = json(folder, &[&exec[..], &still, &["--json"]].concat());
        let notes = told["notes"].as_array().unwrap().clone();
        (ran["events"].as_u64().unwrap(), notes)
    };
    let (events, notes) = fired(&["digits.npy", "--threshold", "40000", "--memory", "bits:3"]);
    assert!(notes.is_empty() && events < 100, "{events}: {notes:?}");
    let surround = [
        "rgc-5x5",
        "--to",
        "int-5",
        "--threshold",
        "460.6",
        "--memory",
    ];
    let (events, notes) = fired(&[&surround[..], &["bits:3"]].concat());
    assert!(events > 1000, "{events}");
    let note = notes[0].as_str().unwrap();
    assert!(
        note.contains("beyond the last") && note.contains("use --memory bits:4"),
        "{note}"
    );
    let (events, notes) = fired(&[&surround[..], &["bits:4"]].concat());
    assert!(notes.is_empty() && events < 100, "{events}: {notes:?}");
}

/// What kinds are called stays with a program as C++ and as words.
#[test]
fn kinds_keep_their_names_in_other_languages() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let spot = format!("{SPOT}{{ on = 30, off = 30 }}");
    let head = "memory = \"raw-snap\"\nshared = true";
    two_kinds(folder, "s.toml", head, [&spot, &spot]);
    let asked = ["compile", "--sensor", "s.toml", "--effort", "0.01", "-o"];
    for file in ["q.scamp", "q.cpp"] {
        good(folder, &[&asked[..], &[file]].concat());
    }
    fs::write(folder.join("d.scamp"), good(folder, &["disasm", "q.scamp"])).unwrap();
    let light = "pattern:disc?width=16&height=16&frames=4";
    for file in ["q.scamp", "q.cpp", "d.scamp"] {
        let told = json(folder, &["exec", file, "--image", light, "--json"]);
        let kinds = told["kinds"].as_array().unwrap();
        let names: Vec<_> = kinds.iter().map(|kind| kind["name"].as_str()).collect();
        assert_eq!(names, [Some("spot"), Some("edge")], "{file}");
    }
}
