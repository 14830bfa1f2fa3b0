//! Proves that the readout of a compiled program is the one that was planned: the cheapest that
//! loses nothing, at what the chip's data say it costs; that every way to read runs, and gives the
//! same events as slots do; and that what is not known is said.

#![cfg(feature = "cli")]

mod common;

use std::{fs, path::Path};

use common::{amacrine, good, json, line, refused};
use ndarray::Array3;
use ndarray_npy::write_npy;
use serde_json::Value;
use tempfile::TempDir;

const SCENE: &str = "pattern:disc?width=48&height=40&frames=8";

fn compile<'a>(more: &[&'a str]) -> Vec<&'a str> {
    let mut all = vec![
        "compile",
        "csdvs-3",
        "--to",
        "ternary",
        "--threshold",
        "24",
        "--effort",
        "0.02",
    ];
    all.extend(more);
    all
}

fn plan<'a>(all: &'a Value, way: &str) -> &'a Value {
    let plans = all["readout"]["plans"].as_array().unwrap();
    let found = plans.iter().find(|plan| plan["plan"] == way);
    found.unwrap_or_else(|| panic!("no {way}"))
}

fn ends(value: &Value) -> [f64; 2] {
    [0, 1].map(|at| value[at].as_f64().unwrap())
}

#[track_caller]
fn near(got: f64, want: f64) {
    assert!((got / want - 1.0).abs() < 1e-9, "{got}, not {want}");
}

#[test]
fn slots_are_taken_for_few_events_and_bits_for_many() {
    let folder = TempDir::new().unwrap();
    let asked = |events: &str| json(folder.path(), &compile(&["--events-per-frame", events]));
    let few = asked("100");
    assert_eq!(few["readout"]["chosen"], "busiest_frame");
    assert!(few["text"].as_str().unwrap().contains("const slots = 100;"));
    // 2 scans of slots of 0.3 to 0.91 us, and 0 to 13 us for the value that the host sets.
    let [least, most] = ends(&plan(&few, "busiest_frame")["us"]);
    near(least, 2.0 * 100.0 * 0.3);
    near(most, 2.0 * 100.0 * 0.91 + 13.0);
    assert_eq!(ends(&few["host_us_range"]), [least, most]);
    near(few["host_us"].as_f64().unwrap(), 182.0 + 1.0);
    let rest = 13.0;
    near(
        ends(&plan(&few, "bit_planes")["us"])[1],
        rest + 2.0 * 256.0 * 4.0,
    );
    near(ends(&plan(&few, "bounding_box")["us"])[1], rest + 2.0 * 4.0);
    near(ends(&plan(&few, "sums")["us"])[1], rest + 14.0);
    let array = ends(&few["array_us_range"]);
    near(
        ends(&plan(&few, "busiest_frame")["frames_s"])[0],
        1e6 / (array[1] + most),
    );
    // From 1126 slots on all bits take less.
    assert_eq!(asked("1125")["readout"]["chosen"], "busiest_frame");
    let many = asked("1126");
    assert_eq!(many["readout"]["chosen"], "bit_planes");
    let text = many["text"].as_str().unwrap();
    assert!(text.contains("scamp5_scan_dreg(R5, on, 0, 255);"), "{text}");
    // More than the host's list holds would be lost; a summary loses all.
    let share = |plan: &Value| plan["lost"].as_f64().unwrap();
    near(share(plan(&asked("8000"), "busiest_frame")), 0.5);
    near(share(plan(&few, "any_event")), 1.0);
}

#[test]
fn what_nobody_says_is_not_guessed() {
    let folder = TempDir::new().unwrap();
    let all = json(folder.path(), &compile(&[]));
    assert_eq!(all["readout"]["chosen"], "as_programmed");
    assert!(all["readout"]["busiest"].is_null());
    assert!(plan(&all, "as_programmed")["lost"].is_null());
    let said = all["readout"]["not_known"].to_string();
    assert!(said.contains("--events-per-frame"), "{said}");
    let plans = all["readout"]["plans"].as_array().unwrap();
    for unknown in ["busiest_frame", "ninety_nine_percent", "region"] {
        assert!(plans.iter().all(|plan| plan["plan"] != unknown));
    }
    refused(
        folder.path(),
        &compile(&["--readout", "region"]),
        &["rows", "--scene"],
    );
    // The scene is opened before the search, and so before any fault of the program.
    refused(
        folder.path(),
        &[
            "compile",
            "csdvs-3",
            "--threshold",
            "1e9",
            "--scene",
            "missing.mp4",
        ],
        &["missing.mp4"],
    );
    refused(
        folder.path(),
        &["compile", "csdvs-3", "--filter-only", "--readout", "planes"],
        &["--filter-only"],
    );
    refused(
        folder.path(),
        &compile(&["--events-per-frame", "65537"]),
        &["of 1 kind on 256 x 256 pixels", "give at most 65536"],
    );
    let table = good(folder.path(), &compile(&["--events-per-frame", "100"]));
    assert!(table.contains("* slots for the busiest frame"), "{table}");
    // The frame rate that stands above is that of the readout that is marked.
    let row = |begins: &str| {
        // Behind the program they are its comments.
        let mut lines = table
            .lines()
            .map(|line| line.trim_start_matches("//").trim_start());
        lines
            .find(|row| row.starts_with(begins))
            .unwrap()
            .to_owned()
    };
    let (time, marked) = (row("time"), row("* "));
    let (_, rate) = time.split_once("busiest frame: ").unwrap();
    let (rate, _) = rate.split_once(" frames/s").unwrap();
    assert!(marked.contains(&format!(" {rate} ")), "{time}\n{marked}");
    assert!(table.contains("not known: "), "{table}");
}

/// The events of a program on the scene, in one order.
fn events(folder: &Path, program: &str) -> Vec<String> {
    let out = format!("{program}.csv");
    let exec = [
        "exec", program, "--image", SCENE, "--frames", "8", "--events", &out,
    ];
    good(folder, &exec);
    let text = fs::read_to_string(folder.join(out)).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    lines.sort_unstable();
    lines
}

/// An array of light between 0 and 1 is warned of, and `--scale`, which the warning names, is taken.
#[test]
fn a_scene_has_the_options_that_it_has_everywhere() {
    let folder = TempDir::new().unwrap();
    let light = Array3::from_shape_fn(
        (6, 16, 16),
        |(t, y, x)| {
            if (x + y + t) % 6 < 3 { 0.9_f32 } else { 0.1 }
        },
    );
    write_npy(folder.path().join("unit.npy"), &light).unwrap();
    let asked = |more: &[&str]| {
        let mut all = compile(&[
            "--scene",
            "unit.npy",
            "--readout",
            "planes",
            "-o",
            "c.scamp",
        ]);
        all.extend(more);
        amacrine(folder.path(), &all).output().unwrap()
    };
    let dark = asked(&[]);
    let said = line(&dark.stderr);
    assert!(
        dark.status.success() && said.contains("give --scale 255"),
        "{said}"
    );
    let scaled = asked(&[
        "--scale",
        "255",
        "--fps",
        "50",
        "--range",
        "full",
        "--transfer",
        "linear",
    ]);
    let said = line(&scaled.stderr);
    assert!(
        scaled.status.success() && !said.contains("--scale"),
        "{said}"
    );
    let none = compile(&["--scale", "255"]);
    refused(folder.path(), &none, &["--scale", "give --scene too"]);
}

#[test]
fn every_way_runs_and_bits_are_the_same_events() {
    let folder = TempDir::new().unwrap();
    let written = |name: &str, more: &[&str]| {
        let mut all = compile(more);
        all.extend(["-o", name]);
        json(folder.path(), &all)
    };
    written("slots.scamp", &[]);
    let slots = events(folder.path(), "slots.scamp");
    assert!(slots.len() > 50, "{} events", slots.len());
    written("planes.scamp", &["--readout", "planes"]);
    assert_eq!(events(folder.path(), "planes.scamp"), slots);
    // A scene has fewer rows than the chip, which reads all of its own.
    let whole = written("whole.scamp", &["--scene", SCENE, "--readout", "planes"]);
    let text = whole["text"].as_str().unwrap();
    assert!(text.contains("scamp5_scan_dreg(R5, on, 0, 255);"), "{text}");
    // On a scene the rows are counted, with the chip's errors; they hold the events without them.
    let region = written("region.scamp", &["--scene", SCENE, "--readout", "region"]);
    let rows = ends(&plan(&region, "region")["rows"]);
    assert!(rows[0] >= 0.0 && rows[1] < 40.0, "{rows:?}");
    assert_eq!(events(folder.path(), "region.scamp"), slots);
    let chosen = written("chosen.scamp", &["--scene", SCENE]);
    let lossless = chosen["readout"]["plans"].as_array().unwrap().iter();
    let cheapest = lossless
        .filter(|plan| plan["lost"] == 0.0)
        .map(|plan| ends(&plan["us"])[1])
        .fold(f64::INFINITY, f64::min);
    near(chosen["host_us"].as_f64().unwrap(), {
        // The time of the program is at the values of the chip's data, not at their ends.
        let own = plan(&chosen, chosen["readout"]["chosen"].as_str().unwrap());
        near(ends(&own["us"])[1], cheapest);
        chosen["host_us"].as_f64().unwrap()
    });
    assert_eq!(events(folder.path(), "chosen.scamp"), slots);
    for (way, statement) in [
        ("box", "scamp5_scan_boundingbox(R5, on);"),
        ("counts", "scamp5_global_count(R6, "),
        ("sums", "scamp5_global_sum_16(A);"),
        ("any", "scamp5_global_or(R6);"),
    ] {
        let name = format!("{way}.scamp");
        let all = written(&name, &["--readout", way]);
        assert!(all["text"].as_str().unwrap().contains(statement), "{way}");
        let exec = ["exec", &name, "--image", SCENE, "--frames", "8"];
        good(folder.path(), &exec);
        good(folder.path(), &["asm", &name]);
    }
}

/// The slots for a scene serve the chips that it was tried on, and arithmetic without their errors.
#[test]
fn slots_for_a_scene_lose_nothing_on_the_chips_that_were_tried() {
    let folder = TempDir::new().unwrap();
    let scene = "pattern:grating?width=64&height=48&frames=20";
    let said = json(
        folder.path(),
        &compile(&["--scene", scene, "--readout", "slots", "-o", "s.scamp"]),
    );
    let basis = said["readout"]["expected_by"].as_str().unwrap();
    assert!(
        basis.contains("on 4 chips of the model and without"),
        "{basis}"
    );
    let text = fs::read_to_string(folder.path().join("s.scamp")).unwrap();
    assert!(
        text.contains("simulated has: what is beyond is lost"),
        "{text}"
    );
    let exec = [
        "exec", "s.scamp", "--image", scene, "--frames", "20", "--json",
    ];
    for more in [
        &["--domain", "exact"][..],
        &["--domain", "silicon"],
        &["--domain", "silicon", "--seed", "1"],
        &["--domain", "silicon", "--seed", "2"],
        &["--domain", "silicon", "--seed", "3"],
    ] {
        let ran = json(folder.path(), &[&exec[..], more].concat());
        assert!(ran["events"].as_u64().unwrap() > 100, "{ran}");
        assert_eq!(ran["dropped"]["no_slot"], 0, "{more:?}");
    }
}

/// Memories in bits, and several kinds: each kind is read in turn.
#[test]
fn kinds_with_memories_in_bits_are_read_as_bits() {
    let folder = TempDir::new().unwrap();
    let kinds = |name: &str, way: &str| {
        let all = [
            "compile",
            "csdvs-3",
            "sobel-x",
            "--to",
            "ternary",
            "--threshold",
            "70",
            "--effort",
            "0.02",
            "--memory",
            "bits:4",
            "--readout",
            way,
            "-o",
            name,
        ];
        json(folder.path(), &all)
    };
    kinds("slots.scamp", "slots");
    let all = kinds("planes.scamp", "planes");
    assert_eq!(plan(&all, "bit_planes")["calls"], 4);
    assert!(
        all["text"]
            .as_str()
            .unwrap()
            .contains("scamp5_scan_dreg(R6, off1, 0, 255);")
    );
    assert_eq!(
        events(folder.path(), "planes.scamp"),
        events(folder.path(), "slots.scamp")
    );
}

/// A kernel far below one LSB leaves nothing; in whole numbers it does.
#[test]
fn what_leaves_nothing_names_what_works() {
    let folder = TempDir::new().unwrap();
    let zero = "name = \"zero\"\nweights = [[0, 0, 0]]\n";
    fs::write(folder.path().join("zero.toml"), zero).unwrap();
    refused(
        folder.path(),
        &["compile", "zero.toml", "--threshold", "1"],
        &["zero.toml has no weight but 0", "nothing comes of it"],
    );
    let faint = "name = \"faint\"\nweights = [[0.000244140625, 0, -0.000244140625]]\n";
    fs::write(folder.path().join("faint.toml"), faint).unwrap();
    let compile = [
        "compile",
        "faint.toml",
        "--filter-only",
        "--input",
        "0..1",
        "--effort",
        "0.02",
    ];
    let words = ["hide the kernel", "the nearest that works: --to "];
    let said = refused(folder.path(), &compile, &words);
    let name = said.split("--to ").nth(1).unwrap();
    let name = name.split(',').next().unwrap();
    let mut again = compile.to_vec();
    again.extend(["--to", name]);
    let worst = &json(folder.path(), &again)["on_chip"][0]["correlation"];
    assert!(worst.as_f64().unwrap() > 0.1, "{worst}");
    let input = "--input=-0..0.01";
    let nothing = [
        "compile",
        "sobel-x",
        "--filter-only",
        input,
        "--effort",
        "0.02",
    ];
    let said = refused(folder.path(), &nothing, &["or --input 0.."]);
    assert!(!said.contains("-0.."), "{said}");
}

/// The rows that `feasibility` plans to read for several kernels have the events of all of them, not
/// only of the one with the busiest frame.
#[test]
fn a_region_has_the_events_of_every_kernel() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    // An edge that moves at the top, for the Sobel; a spot that blinks at the bottom, for the DVS.
    let light = Array3::from_shape_fn((24, 64, 64), |(t, y, x)| {
        let stripes = if y < 14 && (x + 3 * t) % 12 < 6 {
            50
        } else {
            0
        };
        let spot = (52..56).contains(&y) && (30..34).contains(&x) && t % 2 == 1;
        100 + stripes + if spot { 90 } else { 0 }
    });
    write_npy(folder.join("s.npy"), &light.mapv(|level| level as u8)).unwrap();
    let rest = [
        "--threshold",
        "70,100",
        "--to",
        "int-3",
        "--candidates",
        "int-3",
        "--chips",
        "1",
        "--within",
        "10ms",
        "--scene",
        "s.npy",
        "--fps",
        "100",
        "--effort",
        "0.03",
        "-o",
        "r.html",
    ];
    let told = json(
        folder,
        &[&["feasibility", "dvs", "sobel-x"][..], &rest].concat(),
    );
    let rows = |fit: &Value| {
        let plans = fit["time"]["plans"].as_array().unwrap().iter();
        let mut regions = plans.filter(|plan| plan["plan"] == "region");
        ends(&regions.next().unwrap()["rows"])
    };
    let both = rows(&told["together"]["fit"]["on_chip"]);
    for kernel in told["kernels"].as_array().unwrap() {
        let [top, end] = rows(&kernel["fit"]["on_chip"]);
        assert!(both[0] <= top && end <= both[1], "{both:?}: {top} to {end}");
    }
    assert!(both[0] < 20.0 && both[1] > 50.0, "{both:?}");
}

/// The bounds of a filter: proved, or between two numbers.
#[test]
fn the_fewest_words_are_bounded() {
    let folder = TempDir::new().unwrap();
    let rows = |name: &str, text: &str| {
        fs::write(
            folder.path().join(name),
            format!("name = \"{name}\"\nweights = {text}\n"),
        )
        .unwrap();
    };
    rows("box.toml", "[[1, 1, 1], [1, 1, 1], [1, 1, 1]]");
    rows("hard.toml", "[[1, -1, 1], [-1, 1, 1], [0, 1, -1]]");
    rows("odd.toml", "[[1, -2, 1], [-1, 1, 1], [0, 1, -1]]");
    let found = |kernel: &str| {
        let compile = [
            "compile",
            kernel,
            "--filter-only",
            "--objective",
            "words",
            "--effort",
            "0.1",
        ];
        let said = good(folder.path(), &compile);
        let numbers = json(folder.path(), &compile);
        (numbers["bounds"].clone(), said)
    };
    let (box3, said) = found("box.toml");
    assert_eq!((&box3["lower"], &box3["upper"]), (&4.into(), &4.into()));
    assert_eq!(
        (&box3["is_optimal"], &box3["proof"]),
        (&true.into(), &"exhaustive".into())
    );
    assert!(
        said.contains("optimal: no program of fewer words"),
        "{said}"
    );
    let (odd, said) = found("odd.toml");
    assert!(odd["lower"].as_u64() < odd["upper"].as_u64());
    assert_eq!(odd["is_optimal"], false);
    assert!(said.contains("between "), "{said}");
    // Halved on the way, it is another kernel, which has bounds of its own.
    let halved = [
        "compile",
        "hard.toml",
        "--filter-only",
        "--input",
        "0..40",
        "--effort",
        "0.02",
    ];
    let said = good(folder.path(), &halved);
    let halved = json(folder.path(), &halved);
    assert_eq!(halved["prescale_bits"], 1);
    let (bounds, words) = (&halved["bounds"], halved["filter_words"].as_u64());
    assert_eq!(
        (&bounds["lower"], bounds["upper"].as_u64()),
        (&4.into(), words)
    );
    assert_eq!(
        (
            &bounds["is_optimal"],
            &bounds["proof"],
            &bounds["of_halved_input"]
        ),
        (&false.into(), &"doubled".into(), &true.into())
    );
    assert!(halved["no_bounds"].is_null());
    assert!(said.contains("computes 1/2 of this kernel"), "{said}");
}

/// Where each kernel has a filter of its own, it is said that nothing is bounded.
#[test]
fn a_bound_that_is_not_known_is_told() {
    let folder = TempDir::new().unwrap();
    let shared = [
        "compile",
        "sobel-x,laplacian",
        "--memory",
        "shared",
        "--threshold",
        "16",
        "--effort",
        "0.02",
    ];
    let said = good(folder.path(), &shared);
    assert!(
        said.contains("bound     none: each kind has a filter"),
        "{said}"
    );
    let shared = json(folder.path(), &shared);
    assert!(shared["bounds"].is_null());
    assert!(
        shared["no_bounds"]
            .as_str()
            .unwrap()
            .starts_with("each kind")
    );
}
