//! A chip of one's own: what is said of programs and scenes goes by its data, not by SCAMP-5's.

#![cfg(feature = "cli")]

mod common;

use std::{fs, path::Path};

use common::{amacrine, chip, good, json, line, refused};
use ndarray::Array2;
use ndarray_npy::{read_npy, write_npy};
use tempfile::TempDir;

/// A line of `device.toml`.
fn figure(key: &str, value: f64, unit: &str, evidence: &str) -> String {
    format!(
        "{key} = {{ value = {value:?}, unit = \"{unit}\", source = \"test\", evidence = \"{evidence}\" }}\n"
    )
}

/// Chips whose registers hold from `low` to `high` LSB, without headroom, their photodiodes within
/// it.
fn ranged(folder: &Path, name: &str, low: f64, high: f64) {
    let lsb = |key, value| figure(key, value, "LSB", "measured");
    let lines = [
        "[figure.range]\n".to_owned(),
        lsb("low", low),
        lsb("high", high),
        "[figure.error]\n".to_owned(),
        lsb("headroom", 0.0),
        lsb("transfer", 1.0),
        "[figure.light]\n".to_owned(),
        lsb("reset", -high),
    ];
    chip(folder, name, &lines.concat());
}

#[test]
fn what_saturates_goes_by_the_chip_s_range() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    ranged(folder, "narrow", -32.0, 31.0);
    let on = |arguments: &[&str]| good(folder, &[arguments, &["--chip", "narrow"]].concat());
    let whole = on(&[
        "compile",
        "sobel-x",
        "--threshold",
        "40",
        "--objective",
        "exact",
        "--effort",
        "0.1",
    ]);
    assert!(
        whole.contains("nothing saturates for light up to 62 of 255"),
        "{whole}"
    );
    assert!(
        whole.contains("no sum leaves the range for\n//! # light up to 62 of 255"),
        "{whole}"
    );
    // Eight inputs in a sum.
    let filter = ["compile", "sobel-x", "--filter-only", "--effort", "0.1"];
    assert!(
        on(&filter).contains("inputs within ±3.88 LSB"),
        "{}",
        on(&filter)
    );
    let told = json(folder, &[&filter[..], &["--chip", "narrow"]].concat());
    assert_eq!(told["largest_input_lsb"], 31.0 / 8.0);
    fs::write(folder.join("two.scamp"), "bus(B, A);\nbus(C, B);\n").unwrap();
    let asm = on(&["asm", "two.scamp", "--input=0..100"]);
    assert!(
        asm.contains("line 1 can saturate: B from -100 to 0 LSB"),
        "{asm}"
    );
    let asm = on(&["asm", "two.scamp", "--input=0..31"]);
    assert!(asm.contains("no store can saturate"), "{asm}");
}

#[test]
fn a_capture_that_saturates_is_named() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let lsb = |key, value| figure(key, value, "LSB", "measured");
    let lines = ["[figure.range]\n", &lsb("low", -32.0), &lsb("high", 31.0)].concat();
    chip(folder, "dark", &lines);
    let asked = [
        "compile",
        "csdvs-3",
        "--threshold",
        "10",
        "--objective",
        "exact",
    ];
    let told = good(
        folder,
        &[&asked[..], &["--effort", "0.1", "--chip", "dark"]].concat(),
    );
    assert!(!told.contains("nothing saturates"), "{told}");
    assert!(told.contains("saturates: the capture stores"), "{told}");
    // Nor is anything predicted of its events.
    let asked = [&asked[..4], &["--effort", "0.1", "--chip", "dark"]].concat();
    let told = good(folder, &asked);
    assert!(told.contains("saturates: the capture stores"), "{told}");
    assert!(!told.contains("F1"), "{told}");
    let told = json(folder, &asked);
    assert!(told["decided"].is_null(), "{told}");
    assert!(told["notes"].to_string().contains("light.reset"), "{told}");
}

/// A cell between two levels of its memory is as far from what is remembered as half a step.
#[test]
fn thresholds_clear_of_a_memory_in_bits_by_noise() {
    let folder = TempDir::new().unwrap();
    let asked = |threshold| {
        let told = json(
            folder.path(),
            &[
                "compile",
                "csdvs-3",
                "--threshold",
                threshold,
                "--memory",
                "bits:4",
                "--effort",
                "0.1",
            ],
        );
        told["notes"].to_string()
    };
    let near = asked("16");
    assert!(near.contains("fires again and again"), "{near}");
    let from = near.split("thresholds from ").nth(1).unwrap();
    let from: f64 = from.split(' ').next().unwrap().parse().unwrap();
    assert!((16.1..40.0).contains(&from), "{near}");
    assert_eq!(asked(&format!("{:.1}", from + 0.2)), "[]");
}

/// Events of a picture that stays, on the chip.
fn still(folder: &Path, program: &str) -> u64 {
    let picture = "pattern:static?width=128&height=128&frames=20";
    let run = [
        "exec", program, "--image", picture, "--domain", "silicon", "--json",
    ];
    let done = amacrine(folder, &run).assert().success();
    let told: serde_json::Value = serde_json::from_slice(&done.get_output().stdout).unwrap();
    told["events"].as_u64().unwrap()
}

/// The number in the advice behind these words.
fn advised(told: &str, words: &str) -> String {
    let (_, number) = told.split_once(words).unwrap_or_else(|| panic!("{told}"));
    number.split(' ').next().unwrap().to_owned()
}

/// `compile` with a memory of so many bits into a program: whether it is made, and what it says on
/// stderr.
fn in_bits(folder: &Path, kernel: &str, threshold: &str, memory: &str) -> (bool, String) {
    let asked = [
        "compile",
        kernel,
        "--threshold",
        threshold,
        "--memory",
        memory,
        "--effort",
        "0.05",
        "-o",
        "bits.scamp",
    ];
    let done = amacrine(folder, &asked).output().unwrap();
    (done.status.success(), line(&done.stderr))
}

/// The threshold that counts is that of the chip's converter, in whole LSB.
#[test]
fn memories_in_bits_are_warned_of_by_the_threshold_that_the_chip_sets() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let told = |threshold: &str| {
        let (made, told) = in_bits(folder, "sobel-x", threshold, "bits:4");
        assert!(made, "{told}");
        (told, still(folder, "bits.scamp"))
    };
    for threshold in ["64", "69.4", "72", "80"] {
        let (told, events) = told(threshold);
        let warned = "warning: threshold of kind 0: half a step of its memory is 4.00 LSB, its threshold on the chip ";
        assert!(told.contains(warned), "{threshold}: {told}");
        assert!(events > 300, "{threshold}: {events} events");
        // No other number is advised to those who are nearer.
        assert_eq!(advised(&told, "thresholds from "), "88", "{told}");
    }
    let (silent, events) = told("88");
    assert_eq!(silent, "");
    assert!(events < 20, "{events} events");
    // A little less is another whole LSB.
    assert!(told("87.9").0.contains("fires again and again"));
    // With --json it is on stderr, too.
    let asked = [
        "compile",
        "sobel-x",
        "--threshold",
        "64",
        "--memory",
        "bits:4",
    ];
    let asked = [&asked[..], &["--effort", "0.05", "--json"]].concat();
    let done = amacrine(folder, &asked).assert().success();
    let told = line(&done.get_output().stderr);
    assert!(told.contains("fires again and again"), "{told}");
}

/// Bits and factors that a refusal advises serve on the chip: more bits alone may not, since what the
/// stores of each err by adds up.
#[test]
fn what_a_refused_memory_in_bits_is_advised_serves_on_the_chip() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let (made, told) = in_bits(folder, "sobel-x", "64", "bits:2");
    assert!(!made);
    let none = "on the chip no number of bits is enough for this threshold";
    assert!(
        told.contains(none) && !told.contains("--memory bits:"),
        "{told}"
    );
    let times: f64 = advised(&told, "take higher thresholds: ").parse().unwrap();
    let (made, told) = in_bits(folder, "sobel-x", &(64.0 * times).to_string(), "bits:2");
    assert!(made && told.is_empty(), "{told}");
    assert!(still(folder, "bits.scamp") < 20);
    let (_, told) = in_bits(folder, "sobel-x", "100", "bits:2");
    let bits = advised(&told, "--memory bits:");
    let bits = format!("bits:{}", bits.trim_end_matches([')', ';']));
    let (made, told) = in_bits(folder, "sobel-x", "100", &bits);
    assert!(made && told.is_empty(), "{bits}: {told}");
    assert!(still(folder, "bits.scamp") < 20);
}

/// Without errors half a step is enough.
#[test]
fn a_chip_without_errors_needs_half_a_step() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let none = [
        ("transfer", "LSB"),
        ("loss", "1"),
        ("division", "LSB"),
        ("gain_mismatch", "1"),
        ("offset_mismatch", "LSB"),
        ("division_mismatch", "1"),
        ("noise", "LSB"),
    ];
    let none = none.map(|(key, unit)| figure(key, 0.0, unit, "measured"));
    chip(
        folder,
        "exact",
        &format!("[figure.error]\n{}", none.concat()),
    );
    let compile = |threshold: &str| {
        let asked = [
            "compile",
            "sobel-x",
            "--memory",
            "bits:4",
            "--effort",
            "0.05",
            "--chip",
            "exact",
            "-o",
            "bits.scamp",
            "--threshold",
            threshold,
        ];
        let done = amacrine(folder, &asked).output().unwrap();
        (done.status.success(), line(&done.stderr))
    };
    assert_eq!(compile("64"), (true, String::new()));
    assert_eq!(still(folder, "bits.scamp"), 0);
    let (made, told) = compile("50");
    assert!(!made && told.contains("5 bits are needed"), "{told}");
}

#[test]
fn a_wide_range_is_used() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    ranged(folder, "wide", -512.0, 511.0);
    let wide = ["--chip", "wide"];
    let filter = [
        "compile",
        "sobel-x",
        "--filter-only",
        "--input=-60..60",
        "--effort",
        "0.1",
    ];
    let told = good(folder, &[&filter[..], &wide].concat());
    assert!(told.contains("nothing saturates"), "{told}");
    fs::write(
        folder.join("sum.scamp"),
        "bus(B, A);\nbus(D, A);\nbus(E, B, D);\n",
    )
    .unwrap();
    let asm = ["asm", "sum.scamp", "--input=-200..200"];
    let told = good(folder, &[&asm[..], &wide].concat());
    assert!(told.contains("no store can saturate"), "{told}");
}

#[test]
fn stores_clip_at_the_chip_s_range() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    ranged(folder, "narrow", -32.0, 31.0);
    ranged(folder, "wide", -512.0, 511.0);
    fs::write(folder.join("set.scamp"), "bus(B, A);\nbus(C, B);\n").unwrap();
    for (name, domain, least, most) in [
        ("narrow", "exact", -32.0, 31.0),
        ("narrow", "q8.8", -32.0, 31.0),
        ("narrow", "f16", -32.0, 31.0),
        ("wide", "exact", -300.0, 300.0),
        ("wide", "f32", -300.0, 300.0),
    ] {
        let picture = ndarray::arr2(&[[300.0, -300.0]]);
        ndarray_npy::write_npy(folder.join("a.npy"), &picture).unwrap();
        let asked = ["exec", "set.scamp", "--set", "A=a.npy", "--clip", "on"];
        good(
            folder,
            &[
                &asked[..],
                &["--chip", name, "--domain", domain, "--dump", "out"],
            ]
            .concat(),
        );
        let b: ndarray::Array2<f64> = ndarray_npy::read_npy(folder.join("out/B.npy")).unwrap();
        assert_eq!(b, ndarray::arr2(&[[least, most]]), "{name} {domain}");
    }
}

/// Every figure on which time, energy and the model of the chip rest, measured: 4 MHz, 5 us for a
/// launch, 2 W.
fn measured(folder: &Path) {
    let stated = |key, value, unit| figure(key, value, unit, "measured");
    let lines = [
        "[figure.clock]\n".to_owned(),
        stated("rate", 4.0, "MHz"),
        stated("launch", 5.0, "us"),
        stated("power", 2.0, "W"),
        "[figure.range]\n".to_owned(),
        stated("low", -128.0, "LSB"),
        stated("high", 127.0, "LSB"),
        "[figure.error]\n".to_owned(),
        stated("transfer", 20.0, "LSB"),
        stated("loss", 0.007, "1"),
        stated("division", 2.0, "LSB"),
        stated("gain_mismatch", 0.003, "1"),
        stated("offset_mismatch", 0.1, "LSB"),
        stated("mismatch_correlation", 0.0, "1"),
        stated("division_mismatch", 0.01, "1"),
        stated("noise", 0.05, "LSB"),
        stated("headroom", 20.0, "LSB"),
    ];
    chip(folder, "measured", &lines.concat());
}

/// A word takes full power over the highest clock, whatever its launch takes.
#[test]
fn numbers_are_as_well_known_as_the_chip_s_figures() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    measured(folder);
    let asked = ["compile", "csdvs-3", "--threshold", "16", "--effort", "0.1"];
    let own = [&asked[..], &["--chip", "measured"]].concat();
    let told = json(folder, &own);
    let words = told["words"].as_f64().unwrap();
    let energy = told["energy_uj"].as_f64().unwrap();
    assert!(
        (energy - 0.5 * words).abs() < 1e-9,
        "{energy} uJ, {words} words"
    );
    assert_eq!(told["evidence"]["on_chip"], "measured");
    let text = good(folder, &own);
    let us = told["array_us_range"][1].as_f64().unwrap();
    for line in [
        format!(
            "time      {us:.1} us on the array (highest clock, to a launch with every word: quoted)"
        ),
        format!(
            "energy    {energy:.2} uJ a frame for its words, each at full power over the highest clock (modelled)"
        ),
        "(run in the model of the chip: measured)".to_owned(),
        "(modelled; at 64 LSB, saturation left out)".to_owned(),
    ] {
        assert!(text.contains(&line), "no {line:?} in {text}");
    }
    // Of SCAMP-5 the launch and the noise are guesses, and the power is an interval.
    let text = good(folder, &asked);
    for part in [
        "(highest clock, to a launch with every word: guess)",
        "(run in the model of the chip: guess)",
        "(guess; at 64 LSB, saturation left out)",
    ] {
        assert!(text.contains(part), "no {part:?} in {text}");
    }
    let told = json(folder, &asked);
    let words = told["words"].as_f64().unwrap();
    let [least, most] = [0, 1].map(|k| told["energy_uj_range"][k].as_f64().unwrap());
    assert!((least - 0.12 * words).abs() < 1e-9 && (most - 0.158 * words).abs() < 1e-9);
    let front = [
        "compile",
        "sobel-x",
        "--filter-only",
        "--front",
        "--effort",
        "0.1",
    ];
    let text = good(folder, &[&front[..], &["--chip", "measured"]].concat());
    assert!(
        text.contains("run in the model of the chip: measured"),
        "{text}"
    );
}

/// Asks `feasibility` of a disc that moves, on a chip.
fn feasibility(folder: &Path, chip: &str) -> serde_json::Value {
    let scene = "pattern:disc?width=32&height=24&frames=100&speed=60";
    let asked = [
        "feasibility",
        "sobel-x",
        "--threshold",
        "40",
        "--to",
        "ternary",
        "--candidates",
        "ternary",
    ];
    let more = ["--scene", scene, "--within", "5ms", "--chips", "4"];
    let written = ["--effort", "0.1", "-o", "r.html", "--chip", chip];
    json(folder, &[&asked[..], &more, &written].concat())
}

/// Weights times a scale of light that is no power of two are read back as what they are.
#[test]
fn any_scale_of_light_is_read_back() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let kernel = |chip: &str| {
        let ask = ["compile", "rgc-5x5", "--to", "int-5", "--threshold", "128"];
        let rest = ["--effort", "0.01", "--chip", chip];
        json(folder, &[&ask[..], &rest].concat())["kernel"].take()
    };
    let usual = kernel("scamp5");
    for scale in [0.495, 0.37] {
        let name = format!("scale{scale}");
        let light = figure("scale", scale, "LSB/level", "quoted");
        chip(folder, &name, &format!("[figure.light]\n{light}"));
        assert_eq!(kernel(&name), usual, "{scale}");
        let text = "get_image(A);\nmov(B, A);\nadd(C, A, B);\nadd(D, C, A);\n";
        fs::write(folder.join("light.scamp"), text).unwrap();
        let said = good(
            folder,
            &["asm", "light.scamp", "--chip", &name, "--input", "0..100"],
        );
        assert!(said.contains(&format!("= {scale} light")), "{said}");
        let times = |n: f64| format!("= {} light", (n * scale * 1e6).round() / 1e6);
        assert!(
            said.contains(&times(2.0)) && said.contains(&times(3.0)),
            "{said}"
        );
    }
}

/// A guess of one value: no other is drawn, so that all chips agree.
#[test]
fn a_verdict_names_the_guesses_that_it_rests_on() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let noise = figure("noise", 0.01, "LSB", "guess");
    chip(folder, "guessed", &format!("[figure.error]\n{noise}"));
    let told = feasibility(folder, "guessed");
    let headline = told["verdict"]["headline"].as_str().unwrap();
    assert!(
        headline.starts_with("Not known: it rests on guesses (error.noise)"),
        "{headline}"
    );
    assert_eq!(
        told["chip"]["guessed_values"],
        serde_json::json!(["error.noise"])
    );
    let findings = told["verdict"]["findings"].as_array().unwrap();
    let says = findings.iter().find(|it| it["about"] == "guesses").unwrap();
    assert!(
        says["says"]
            .as_str()
            .unwrap()
            .contains("error.noise is guessed"),
        "{says}"
    );
    // With an interval, others are drawn.
    let interval = noise.replace(" }", ", low = 0, high = 0.02, why = \"test\" }");
    chip(folder, "bounded", &format!("[figure.error]\n{interval}"));
    let told = feasibility(folder, "bounded");
    let headline = told["verdict"]["headline"].as_str().unwrap();
    assert!(headline.starts_with("Feasible"), "{headline}");
    assert_eq!(told["chips_evidence"], "guess");
}

/// The time of a call is a number like others: a guess leaves the verdict open, an interval is drawn
/// from, and both are in the time of every readout.
#[test]
fn a_call_of_the_host_is_known_as_well_as_its_data_say() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let call = |name: &str, rest: &str| {
        let call = format!(
            "{{ value = 9000, unit = \"us\", source = \"test\", evidence = \"guess\"{rest} }}"
        );
        let row = "[[host]]\nname = \"load_in\"\nforms = [\"scamp5_in(v: lsb[-128..127])\"]\nmeaning = \"IN := v\"\n";
        chip(folder, name, &format!("{row}call = {call}\n"));
        feasibility(folder, name)
    };
    let bare = call("bare", "");
    assert_eq!(
        bare["chip"]["guessed_values"],
        serde_json::json!(["load_in.call"])
    );
    let known = call("known", ", low = 20, high = 9000, why = \"test\"");
    assert_eq!(known["chip"]["guessed_values"], serde_json::json!([]));
    for plan in known["fit"]["on_chip"]["time"]["plans"].as_array().unwrap() {
        let [low, high] = ["low", "high"].map(|end| plan["time"][end].as_f64().unwrap());
        assert!(low >= 20.0 && high >= 9000.0, "{plan}");
        let inputs = plan["time"]["inputs"].to_string();
        assert!(inputs.contains("load_in.call"), "{plan}");
        assert_eq!(plan["time"]["evidence"], "guess", "{plan}");
    }
    let drawn = known["drawn"].as_array().unwrap();
    let calls = drawn.iter().map(|chip| {
        let values = chip["values"].as_array().unwrap().iter();
        let mut calls = values.filter(|it| it["figure"] == "load_in.call");
        calls.next().unwrap()["value"].as_f64().unwrap()
    });
    let calls: Vec<f64> = calls.collect();
    let [least, most] = [f64::min, f64::max].map(|of| calls.iter().copied().reduce(of).unwrap());
    assert!(20.0 <= least && least < most && most <= 9000.0, "{calls:?}");
}

/// SCAMP-5 with every number measured, and so without intervals.
#[test]
fn what_is_made_of_measurements_is_no_guess() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("isa/scamp5");
    fs::create_dir(folder.join("known")).unwrap();
    for file in ["macros.scamp", "primitives.toml"] {
        fs::copy(shipped.join(file), folder.join("known").join(file)).unwrap();
    }
    let text = fs::read_to_string(shipped.join("device.toml")).unwrap();
    let mut known = String::new();
    for line in text.lines() {
        let line = match line.find(", low = ") {
            Some(at) => format!("{} }}", &line[..at]),
            None => line.to_owned(),
        };
        known += &line.replace("name = \"scamp5\"", "name = \"known\"");
        known.push('\n');
    }
    for word in ["quoted", "modelled", "guess"] {
        known = known.replace(&format!("evidence = \"{word}\""), "evidence = \"measured\"");
    }
    fs::write(folder.join("known/device.toml"), known).unwrap();
    let told = feasibility(folder, "known");
    assert_eq!(told["chips_evidence"], "measured");
    assert_eq!(told["chip"]["guessed_values"], serde_json::json!([]));
}

/// A chip of so many rows and columns.
fn sized(folder: &Path, name: &str, [rows, columns]: [f64; 2]) {
    let px = |key, value| figure(key, value, "px", "quoted");
    let lines = [px("height", rows), px("width", columns)].concat();
    chip(folder, name, &format!("[figure.array]\n{lines}"));
}

/// A column too many is one that no chip has.
#[test]
fn a_scene_larger_than_the_array_is_refused() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    sized(folder, "small", [24.0, 32.0]);
    let scene = "pattern:spot?width=33&height=24&frames=6";
    let more = ["--scene", scene, "--chip", "small", "--effort", "0"];
    for verb in [
        &["design", "csdvs-3", "--threshold", "20"][..],
        &[
            "quantise",
            "csdvs-3",
            "--threshold",
            "20",
            "--to",
            "ternary",
        ],
        &["waterfall", "csdvs-3", "--threshold", "20"],
        &["compile", "csdvs-3", "--threshold", "20"],
    ] {
        refused(
            folder,
            &[verb, &more].concat(),
            &[
                "is 33x24, and small has 32x24 processors",
                "--crop 32x24, --resize 32x23",
            ],
        );
    }
    // A program of the chip, and not a sensor beside it.
    let program = ["trade", "--program", "dvs/snap"];
    refused(
        folder,
        &[&program[..], &more[..4]].concat(),
        &["is 33x24, and small has 32x24 processors"],
    );
    let study = "scene = \"pattern:spot?width=33&height=24&frames=6\"\nkernel = \"csdvs-3\"\nthreshold = 20\neffort = 0\n[[side]]\nside = \"array\"\nchip = [\"small\", \"scamp5\"]\nquantise = \"ternary\"\n";
    fs::write(folder.join("study.toml"), study).unwrap();
    let told = json(folder, &["sweep", "study.toml", "--json"]);
    assert_eq!(told["finished"], 2, "{told}");
    let rows = fs::read_to_string(folder.join("study/results.csv")).unwrap();
    let sizes = "is 33x24, and small has 32x24 processors";
    assert_eq!(rows.matches(sizes).count(), 1, "{rows}");
    assert_eq!(rows.matches("refused").count(), 1, "{rows}");
    fs::write(folder.join("p.scamp"), "get_image(A);\n").unwrap();
    let exec = |scene: &str| {
        let asked = ["exec", "p.scamp", "--chip", "small", "--scene", scene];
        let said = amacrine(folder, &asked).output().unwrap();
        assert!(said.status.success());
        line(&said.stderr)
    };
    let told = exec(scene);
    let sizes = "an array of 33x24, but small has 32x24 processors";
    assert_eq!(told.matches(sizes).count(), 1, "{told}");
    let told = exec("pattern:spot?width=32&height=24&frames=6");
    assert!(!told.contains("processors"), "{told}");
}

/// Whole bit planes are as many rows as the array that is spoken of.
#[test]
fn a_rate_is_that_of_the_array_that_it_is_told_of() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    sized(folder, "low", [4.0, 32.0]);
    sized(folder, "high", [24.0, 32.0]);
    let rate = |chip| {
        let told = feasibility(folder, chip);
        let plans = told["fit"]["on_chip"]["time"]["plans"].as_array().unwrap();
        let planes = plans.iter().find(|it| it["plan"] == "bit_planes").unwrap();
        planes["frames_s"].to_string()
    };
    assert_eq!(rate("low"), rate("high"));
}

#[test]
fn a_chip_s_folder_is_named_where_its_file_or_its_name_was_given() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    sized(folder, "c9", [24.0, 32.0]);
    for asked in [
        &["list", "chips", "c9"][..],
        &["show", "chip", "c9"],
        &["new", "chip", "d", "--from", "c9"],
    ] {
        refused(folder, asked, &["verbs take it as --chip c9"]);
    }
    fs::write(folder.join("p.scamp"), "bus(B, A);\n").unwrap();
    let asked = ["asm", "p.scamp", "--chip", "c9/device.toml"];
    refused(folder, &asked, &["give its folder c9"]);
}

/// A row of `primitives.toml` in these forms.
fn row(folder: &Path, chip: &str, name: &str, forms: &[&str]) {
    let rest = "equation = \"test\"\nwords = 1\nclock = \"analog\"\nsource = \"test\"\nevidence = \"guess\"\n";
    let text = format!("[[primitive]]\nname = \"{name}\"\nforms = {forms:?}\n{rest}");
    fs::write(folder.join(chip).join("primitives.toml"), text).unwrap();
}

/// A filter that halves nothing needs no word that splits; where light has to be halved, there is no
/// program.
#[test]
fn filters_are_made_of_the_words_that_the_chip_has() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    chip(folder, "whole", "");
    row(
        folder,
        "whole",
        "bus",
        &["bus(out y: target, x: source * 0..4)"],
    );
    chip(folder, "pairs", "");
    let pairs = ["bus(out y: target, x: source * 0..2)"];
    row(
        folder,
        "pairs",
        "bus",
        &[
            &pairs[..],
            &["bus2(out y: target, out z: target, x: source * 0..2)"],
        ]
        .concat(),
    );
    for objective in ["words", "silicon", "exact"] {
        let filter = ["compile", "sobel-x", "--filter-only", "--effort", "0.1"];
        let on = |chip: &str, more: &[&str]| {
            let asked = ["--chip", chip, "--objective", objective];
            good(folder, &[&filter[..], &asked, more].concat())
        };
        let told = on("whole", &[]);
        assert!(!told.contains("bus2"), "{told}");
        let told = on("pairs", &["--input=0..127"]);
        let most = told
            .lines()
            .filter(|it| it.starts_with("bus("))
            .map(|it| it.matches(',').count());
        assert!(most.max() <= Some(2), "{told}");
    }
    let light = [
        "compile",
        "sobel-x",
        "--filter-only",
        "--input=0..127",
        "--effort",
        "0.1",
    ];
    refused(
        folder,
        &[&light[..], &["--chip", "whole"]].concat(),
        &[
            "no program for whole: whole has no `bus2(out y: target, out z: target, x: source)`",
            "its input must be halved",
        ],
    );
    // Sums that leave the range decide as they should: nothing is halved.
    let events = ["sobel-x", "--threshold", "16", "--objective", "events"];
    let told = good(
        folder,
        &[
            &["compile"],
            &events[..],
            &["--chip", "whole", "--effort", "0.1"],
        ]
        .concat(),
    );
    assert!(!told.contains("bus2"), "{told}");
    // A chip that splits, and not to a neighbour; and one without what the comparison needs.
    chip(folder, "own", "");
    let own = [
        "bus(out y: target, x: source * 0..4)",
        "bus2(out y: areg, out z: areg, x: source * 0..2)",
    ];
    row(folder, "own", "bus", &own);
    refused(
        folder,
        &[&light[..], &["--chip", "own"]].concat(),
        &["own has no `bus2(out y: target, out z: target, x: source)`"],
    );
    refused(
        folder,
        &["compile", "dvs", "--threshold", "16", "--chip", "pairs"],
        &["scamp5 has this `bus`, and pairs does not: the program needs `bus(B, NEWS, A, F)`"],
    );
}

/// The search of a chip of few registers takes what is stated, as any other.
#[test]
fn the_effort_holds_on_chips_of_few_registers() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let registers = "analogue = [\"A\", \"B\", \"C\", \"D\", \"NEWS\"]";
    chip(folder, "four", &format!("[registers]\n{registers}\n"));
    let asked = ["compile", "sobel-x", "--to", "ternary", "--threshold", "16"];
    let states = |chip: &str| {
        let more = ["--effort", "0.2", "--chip", chip, "--json"];
        let told = json(folder, &[&asked[..], &more].concat());
        told["states"].as_u64().unwrap()
    };
    assert!(states("four") <= states("scamp5"));
}

/// A readout of fewer slots, by the chip's own row.
fn slots(folder: &Path, name: &str) {
    let cost = "{ value = 1, unit = \"us\", source = \"test\", evidence = \"guess\" }";
    let form = "scamp5_scan_events(d: dreg, buffer: word, slots: int[1..100] = 50, h_dir: int[0..0] = 0, v_dir: int[0..0] = 0)";
    let lines = format!(
        "[[host]]\nname = \"scan_events\"\nforms = [\"{form}\"]\nmeaning = \"events\"\ncall = {cost}\nitem = {cost}\n"
    );
    chip(folder, name, &lines);
}

#[test]
fn a_program_asks_for_as_many_slots_as_the_chip_has() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    slots(folder, "slow");
    let asked = ["compile", "dvs", "--threshold", "16", "--chip", "slow"];
    for memory in ["analogue", "shared"] {
        let more = ["--memory", memory, "-o", "dvs.scamp", "--effort", "0"];
        good(folder, &[&asked[..], &more].concat());
        let text = fs::read_to_string(folder.join("dvs.scamp")).unwrap();
        assert!(text.contains("const slots = 100; // the most"), "{text}");
    }
    fs::write(folder.join("x.scamp"), "scamp5_scan_events(R5, on, 4000);").unwrap();
    refused(
        folder,
        &["asm", "x.scamp", "--chip", "slow"],
        &[
            "x.scamp:1:28",
            "4000 is not a whole number between 1 and 100",
        ],
    );
}

/// From wherever it is run.
#[test]
fn a_program_is_run_on_the_chip_beside_it() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    for part in ["chips", "elsewhere"] {
        fs::create_dir(folder.join(part)).unwrap();
    }
    slots(&folder.join("chips"), "slow");
    let text = "//! chip = \"slow\"\n\nnop();\n";
    fs::write(folder.join("chips/x.scamp"), text).unwrap();
    fs::write(folder.join("elsewhere/x.scamp"), text).unwrap();
    good(folder, &["asm", "chips/x.scamp"]);
    good(
        folder,
        &["asm", "elsewhere/x.scamp", "--chip", "chips/slow"],
    );
    refused(
        folder,
        &["asm", "elsewhere/x.scamp"],
        &["elsewhere/x.scamp is for the chip `slow`", "--chip PATH"],
    );
}

/// One message, which names the word.
#[test]
fn a_chip_without_a_word_is_given_no_program_that_has_it() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    chip(folder, "blind", "");
    row(folder, "blind", "where", &[]);
    let scene = ["--scene", "pattern:spot?width=32&height=24&frames=6"];
    let why = "no program for blind: scamp5 has this `where`, and blind does not";
    for verb in [
        &["compile", "csdvs-3", "--threshold", "20"][..],
        &[
            "quantise",
            "csdvs-3",
            "--threshold",
            "20",
            "--to",
            "ternary",
        ],
        &[
            "waterfall",
            "csdvs-3",
            "--threshold",
            "20",
            "--to",
            "ternary",
        ],
        &["design", "csdvs-3", "--threshold", "20", "--to", "ternary"],
        &[
            "feasibility",
            "csdvs-3",
            "--threshold",
            "20",
            "--to",
            "ternary",
            "-o",
            "r.html",
        ],
    ] {
        let more = ["--chip", "blind", "--effort", "0"];
        let said = amacrine(folder, &[verb, &scene, &more].concat())
            .output()
            .unwrap();
        let told = line(&said.stderr) + &line(&said.stdout);
        assert!(told.contains(why), "{verb:?}: {told}");
    }
}

/// Whole thousandths, as everywhere.
#[test]
fn ranges_are_told_in_few_digits() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    ranged(folder, "narrow", -32.0, 31.0);
    fs::write(folder.join("two.scamp"), "bus2(B, C, A);\nbus(D, B);\n").unwrap();
    let asked = [
        "asm",
        "two.scamp",
        "--chip",
        "narrow",
        "--input=-0.1..100.123456",
    ];
    let told = good(folder, &asked);
    assert!(told.contains("  D    from -0.05 to 50.062 LSB"), "{told}");
    assert!(told.contains("B from -50.062 to 0.05 LSB"), "{told}");
}

/// A chip of another scale of light runs what is written for SCAMP-5, and the other way round; what
/// is false stays false.
#[test]
fn a_kernel_is_true_of_a_chip_of_another_scale_of_light() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let scale = figure("scale", 0.495, "LSB/level", "quoted");
    chip(folder, "dim", &format!("[figure.light]\n{scale}"));
    let on = |program: &str, chip: &str| good(folder, &["asm", program, "--chip", chip]);
    let told = on("convolve/sobel", "dim");
    let says = "times 0.495/0.5: that is said for scamp5, where light.scale is 0.5 LSB/level; here it is 0.495";
    assert!(told.contains(says), "{told}");
    assert!(!on("convolve/sobel", "scamp5").contains("that is said for"));
    let compile = [
        "compile",
        "csdvs-3",
        "--threshold",
        "16",
        "--chip",
        "dim",
        "--effort",
        "0.1",
        "-o",
        "p.scamp",
    ];
    good(folder, &compile);
    assert!(!on("p.scamp", "dim").contains("that is said for"));
    let told = on("p.scamp", "scamp5");
    let says = "times 0.5/0.495: that is said for dim, where light.scale is 0.495 LSB/level; here it is 0.5";
    assert!(told.contains(says), "{told}");
    let whole = json(folder, &["asm", "p.scamp", "--chip", "scamp5"]);
    assert_eq!(whole["proof"]["stated_for"]["chip"], "dim");
    // Any other factor is a fault.
    let text = fs::read_to_string(folder.join("p.scamp")).unwrap();
    let line = text
        .lines()
        .find(|line| line.starts_with("//! scale = "))
        .unwrap();
    let value: f64 = line.trim_start_matches("//! scale = ").parse().unwrap();
    let text = text.replace(line, &format!("//! scale = {:?}", 1.01 * value));
    fs::write(folder.join("q.scamp"), text).unwrap();
    for chip in ["dim", "scamp5"] {
        refused(
            folder,
            &["asm", "q.scamp", "--chip", chip],
            &["[computes] is false"],
        );
    }
}

/// What is said of a scene that is larger than the array can be done, whichever side is too long.
#[test]
fn advice_for_a_larger_scene_can_be_followed() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let scene = "pattern:disc?width=320&height=240&frames=2";
    let exec = ["exec", "dvs/snap", "--image", scene];
    let said = |more: &[&str]| json(folder, &[&exec[..], more].concat())["warnings"].to_string();
    let advice = ["--crop 256x240", "--resize 256x192"];
    let told = said(&[]);
    assert!(told.contains(&advice.join(", ")), "{told}");
    for way in advice {
        let words: Vec<&str> = way.split(' ').collect();
        let told = said(&words);
        assert!(!told.contains("processors"), "{told}");
    }
}

/// Beyond the border of a chip whose registers hold something there, results are not the kernel's as
/// far in as is told.
#[test]
fn a_border_that_holds_something_is_told_of() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let edge = [
        "[figure.edge]\n".to_owned(),
        figure("analogue", 15.0, "LSB", "guess"),
    ];
    chip(folder, "lit", &edge.concat());
    fs::write(
        folder.join("k.toml"),
        "weights = [[1, 1, 1], [1, 1, 1], [1, 1, 1]]\nname = \"k\"\nsource = \"test\"\n",
    )
    .unwrap();
    let of = |chip: &str| {
        let ask = [
            "compile",
            "k.toml",
            "--filter-only",
            "--effort",
            "0.05",
            "--chip",
            chip,
        ];
        let told = good(folder, &ask);
        (told, json(folder, &[&ask[..], &["--json"]].concat()))
    };
    let (told, numbers) = of("scamp5");
    assert!(
        told.contains("right up to the border, zeros beyond it"),
        "{told}"
    );
    assert_eq!(
        (&numbers["border"], &numbers["wrong_from_border_px"]),
        (&true.into(), &0.into())
    );
    let (told, numbers) = of("lit");
    assert!(
        told.contains("beyond it registers of lit hold 15 LSB"),
        "{told}"
    );
    assert_eq!(numbers["border"], false);
    let far = numbers["wrong_from_border_px"].as_u64().unwrap() as usize;
    fs::write(folder.join("k.scamp"), numbers["text"].as_str().unwrap()).unwrap();
    let zeros = Array2::<f64>::zeros((16, 16));
    write_npy(folder.join("z.npy"), &zeros).unwrap();
    let run = [
        "exec", "k.scamp", "--chip", "lit", "--set", "A=z.npy", "--dump", "dump",
    ];
    good(folder, &run);
    let result: Array2<f64> = read_npy(folder.join("dump/A.npy")).unwrap();
    let wrong = result.indexed_iter().filter(|(_, value)| **value != 0.0);
    let wrong: Vec<usize> = wrong
        .map(|((y, x), _)| y.min(x).min(15 - y).min(15 - x))
        .collect();
    assert!(
        !wrong.is_empty() && wrong.iter().all(|at| *at < far),
        "{wrong:?} {far}"
    );
}

/// Where the best filter is too long for the store, the shortest is taken, and a front has what fits.
#[test]
fn a_filter_that_does_not_fit_gives_way_to_the_shortest() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    fs::write(
        folder.join("k.toml"),
        // Of one digit each: no scale makes them shorter.
        "weights = [[1, 1, -1], [-1, 1, 1], [1, -1, 0]]\nname = \"k\"\nsource = \"test\"\n",
    )
    .unwrap();
    let words = |more: &[&str]| {
        let ask = [
            "compile",
            "k.toml",
            "--filter-only",
            "--effort",
            "0.1",
            "--json",
        ];
        let json = json(folder, &[&ask[..], more].concat());
        json["words"].as_u64().unwrap()
    };
    let (best, fewest) = (words(&[]), words(&["--objective", "words"]));
    let ask = [
        "compile",
        "k.toml",
        "--filter-only",
        "--effort",
        "0.1",
        "--front",
        "--json",
    ];
    let front = json(folder, &ask);
    assert_eq!(front[0]["words"], fewest);
    assert!(fewest < best, "{fewest} {best}: this kernel tries nothing");
    for (name, room) in [("small", fewest), ("tiny", fewest - 1)] {
        let words = figure("words", room as f64, "words", "guess");
        chip(folder, name, &format!("[figure.store]\n{words}"));
    }
    assert_eq!(words(&["--chip", "small"]), fewest);
    let front = json(folder, &[&ask[..], &["--chip", "small"]].concat());
    assert_eq!(front.as_array().unwrap().len(), 1);
    let ask = [
        "compile",
        "k.toml",
        "--filter-only",
        "--effort",
        "0.1",
        "--chip",
        "tiny",
    ];
    let why = format!("the program has {fewest} instruction words, 1 more than the");
    refused(folder, &ask, &[&why, "--to"]);
}

/// The first register need not be the one in which the input begins.
#[test]
fn figures_do_not_go_by_the_order_of_registers() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let registers = r#"["NEWS", "A", "B", "C", "D", "E", "F"]"#;
    chip(
        folder,
        "first",
        &format!("[registers]\nanalogue = {registers}\n"),
    );
    let both = |asked: &[&str]| {
        ["scamp5", "first"].map(|chip| json(folder, &[asked, &["--chip", chip]].concat()))
    };
    let filter = [
        "compile",
        "sobel-x",
        "--filter-only",
        "--objective",
        "exact",
    ];
    let compile = ["--effort", "0.1", "--json"];
    let [usual, first] = both(&[&filter[..], &compile].concat());
    assert_eq!(usual["text"], first["text"]);
    for of in [
        "noise_lsb",
        "offset_stores",
        "results_lsb",
        "largest_input_lsb",
    ] {
        assert_eq!(usual[of], first[of], "{of}");
    }
    assert!(usual["noise_lsb"][0]["fixed"].as_f64().unwrap() > 0.0);
    let scene = "pattern:disc?width=32&height=24&frames=20&speed=60";
    let feasibility = [
        "feasibility",
        "sobel-x",
        "--threshold",
        "40",
        "--to",
        "ternary",
    ];
    let more = ["--scene", scene, "--effort", "0", "-o", "r.html"];
    let told = both(&[&feasibility[..], &more].concat());
    let [usual, first] = told.map(|told| told["fit"]["on_chip"].clone());
    assert!(usual["noise"]["fixed"].is_object(), "{usual}");
    for of in ["filter_words", "noise"] {
        assert_eq!(usual[of], first[of], "{of}");
    }
}
