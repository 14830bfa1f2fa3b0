//! Proves that `amacrine exec` does what programs written for the chip do, from text to files:
//! against results worked out by hand and with plain arithmetic on planes, in several domains,
//! and that every bad input gets its message, exit code 2, and leaves nothing behind.

mod common;

use std::{fs, path::Path};

use amacrine::plane::Plane;
use assert_cmd::Command;
use common::{amacrine, good, json, line};
use ndarray_npy::{read_npy, write_npy};
use tempfile::TempDir;

struct Bench {
    folder: TempDir,
}

impl Bench {
    fn new(program: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("p.scamp"), program).unwrap();
        Self { folder }
    }

    fn set(self, name: &str, plane: &Plane<f64>) -> Self {
        write_npy(self.path(&format!("{name}.in.npy")), plane).unwrap();
        self
    }

    fn path(&self, name: &str) -> std::path::PathBuf {
        self.folder.path().join(name)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let all = [&["exec", "p.scamp"], arguments].concat();
        amacrine(self.folder.path(), &all)
    }

    fn run(&self, arguments: &[&str]) -> &Self {
        let mut all = arguments.to_vec();
        all.extend(["--dump", "out"]);
        self.command(&all).assert().success();
        self
    }

    fn analog(&self, name: &str) -> Plane<f64> {
        read_npy(self.path(&format!("out/{name}.npy"))).unwrap()
    }

    fn bits(&self, name: &str) -> Plane<u8> {
        read_npy(self.path(&format!("out/{name}.npy"))).unwrap()
    }

    /// The message of a run that must fail with exit code 2 and write nothing.
    fn refused(&self, arguments: &[&str]) -> String {
        let mut all = arguments.to_vec();
        all.extend(["--dump", "out", "--events", "e.csv"]);
        self.refused_alone(&all)
    }

    fn refused_alone(&self, all: &[&str]) -> String {
        let output = self.command(all).assert().code(2).get_output().clone();
        assert!(!self.path("out").exists() && !self.path("e.csv").exists());
        assert!(output.stdout.is_empty());
        line(&output.stderr)
    }
}

fn ramp() -> Plane<f64> {
    Plane::from_shape_fn((5, 7), |(y, x)| (y * 7 + x) as f64 - 10.0)
}

#[test]
fn a_sobel_in_vendor_text_is_the_sobel() {
    let text = "// vertical edges\nmovx(B, A, west); movx(C, A, east);\nsub(D, C, B);\n\
                movx(E, D, north); movx(F, D, south); add(E, E, F);\nadd(E, E, D); add(E, E, D); /* 1 2 1 */";
    let a = ramp().mapv(|v| (v * 7.0).rem_euclid(23.0));
    let bench = Bench::new(text).set("A", &a);
    for domain in ["exact", "f32", "f16", "q8.8"] {
        bench.run(&["--set", "A=A.in.npy", "--domain", domain]);
        let at = |y: isize, x: isize| {
            let inside = usize::try_from(y).ok().zip(usize::try_from(x).ok());
            inside.and_then(|at| a.get(at)).copied().unwrap_or(0.0)
        };
        let expected = Plane::from_shape_fn((5, 7), |(y, x)| {
            let (y, x) = (y as isize, x as isize);
            // What is not on the array has no difference either.
            let row = |y: isize| {
                if (0..5).contains(&y) {
                    at(y, x + 1) - at(y, x - 1)
                } else {
                    0.0
                }
            };
            row(y - 1) + 2.0 * row(y) + row(y + 1)
        });
        assert_eq!(bench.analog("E"), expected, "{domain}");
        assert_eq!(bench.analog("A"), a);
    }
    let names = ["A", "F", "NEWS", "R0", "R12", "FLAG"];
    for name in names {
        assert!(bench.path(&format!("out/{name}.png")).exists());
    }
    assert_eq!(bench.bits("FLAG"), Plane::from_elem((5, 7), 1));
    assert_eq!(bench.bits("R12"), Plane::from_elem((5, 7), 0));
}

#[test]
fn flag_masks_and_logic_follows() {
    let text = "where(A); MOV(R5, FLAG); scamp5_in(B, 9); all(); MOV(R6, R7); XORX(R8, R6, R5);";
    let bits = Plane::from_shape_fn((5, 7), |(y, x)| f64::from((x + y) as u8 % 2));
    let bench = Bench::new(text).set("A", &ramp()).set("R7", &bits);
    bench.run(&["--set", "A=A.in.npy", "--set", "R7=R7.in.npy"]);
    let above = ramp().mapv(|v| u8::from(v > 0.0));
    assert_eq!(bench.bits("R5"), above);
    assert_eq!(bench.analog("B"), above.mapv(|b| f64::from(b) * 9.0));
    let expected = Plane::from_shape_fn((5, 7), |at| above[at] ^ bits[at] as u8);
    assert_eq!(bench.bits("R8"), expected);
}

#[test]
fn clip_and_edge_are_as_asked() {
    let bench = Bench::new("add(B, A, A0);");
    assert!(bench.refused(&[]).contains("A0"));
    let bench = Bench::new("movx(C, A, north); add(B, A, C);").set("A", &ramp().mapv(|v| v * 10.0));
    bench.run(&["--set", "A=A.in.npy", "--edge", "-40"]);
    assert_eq!(bench.analog("C").row(0).to_vec(), [-40.0; 7]);
    let free = bench.analog("B");
    bench.run(&["--set", "A=A.in.npy", "--edge=-40", "--clip", "on"]);
    assert!(free.iter().any(|v| *v > 127.0));
    // The bus inverts: what is clipped first is -(sum), so 128 is never stored in the end.
    let limited = |v: f64| -((-v).clamp(-128.0, 127.0));
    let clipped = ramp().mapv(|v| limited(v * 10.0).clamp(-128.0, 127.0));
    assert_eq!(bench.analog("C").row(1), clipped.row(0));
    assert_eq!(
        bench.analog("A"),
        ramp().mapv(|v| v * 10.0),
        "what is set is not clipped"
    );
}

#[test]
fn light_and_events_go_through() {
    let text = "init { get_image(C); }\nframe {\n get_image(D); sub(E, D, C); scamp5_in(F, 5); sub(E, E, F);\n\
                where(E); MOV(R5, FLAG); all(); scamp5_scan_events(R5, on0, 100); mov(C, D); }";
    let mut clip = ndarray::Array3::<f64>::zeros((3, 4, 5));
    clip[[1, 2, 3]] = 20.0; // +10 LSB at frame 1
    clip[[2, 2, 3]] = 20.0;
    clip[[2, 0, 4]] = 100.0; // frame 2, the chip's (0,0)
    let bench = Bench::new(text);
    write_npy(bench.path("clip.npy"), &clip).unwrap();
    let output = bench
        .command(&[
            "--image", "clip.npy", "--fps", "100", "--events", "e.csv", "--json",
        ])
        .assert()
        .success()
        .get_output()
        .clone();
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["events"], 2);
    assert_eq!(json["ambiguous"], 1);
    assert_eq!(json["frames"], 3);
    assert_eq!(json["slots"], 200);
    let packet = amacrine::event::file::read(&bench.path("e.csv"))
        .unwrap()
        .packet;
    let events: Vec<_> = packet.events.iter().map(|e| (e.t.0, e.x, e.y)).collect();
    assert_eq!(events, [(10_000, 3, 2), (20_000, 4, 0)]);
}

#[test]
fn silicon_is_a_seed() {
    let bench = Bench::new("mov(B, A);").set("A", &Plane::from_elem((16, 16), 50.0));
    let of = |seed: &str| {
        bench.run(&["--set", "A=A.in.npy", "--domain", "silicon", "--seed", seed]);
        bench.analog("B")
    };
    let (one, again, two) = (of("1"), of("1"), of("2"));
    assert_eq!(one, again);
    assert_ne!(one, two);
    assert!((one.mean().unwrap() - 50.0).abs() < 1.0);
}

#[test]
fn bad_input_has_its_message() {
    let bench = Bench::new("mov(B, A);").set("A", &ramp());
    let says = |arguments: &[&str], parts: &[&str]| {
        let text = bench.refused(arguments);
        for part in parts {
            assert!(text.contains(part), "{part:?} in {text}");
        }
    };
    says(&["--set", "A=none.npy"], &["none.npy", "numpy.save"]);
    says(
        &["--set", "Q=A.in.npy"],
        &["Q: no such register", "NEWS", "R12"],
    );
    says(&["--set", "A=p.scamp"], &["p.scamp", "numpy.save"]);
    says(&["--domain", "f128"], &["f128", "exact", "silicon", "q8.8"]);
    says(
        &["--frames", "0"],
        &["--frames", "a whole number from 1 on"],
    );
    says(&["--scale", "2"], &["--scale 2", "no scene"]);
    says(&["--edge", "NaN"], &["--edge is NaN"]);
    says(&["--set", "R3=A.in.npy"], &["-10 at [0, 0]", "0 or 1"]);
    says(&["--chip", "none"], &["none", "scamp5"]);
    let write = |name: &str, plane: &Plane<f64>| write_npy(bench.path(name), plane).unwrap();
    write("small.npy", &Plane::zeros((2, 2)));
    write("empty.npy", &Plane::zeros((0, 2)));
    write("nan.npy", &Plane::from_elem((2, 2), f64::NAN));
    says(
        &["--set", "A=A.in.npy", "--set", "B=small.npy"],
        &["A.in.npy is 7x5", "small.npy is 2x2", "one size"],
    );
    says(
        &["--set", "A=empty.npy"],
        &["empty.npy", "at least one pixel"],
    );
    says(&["--set", "A=nan.npy"], &["NaN at [0, 0]", "finite"]);
    let cut = fs::read(bench.path("A.in.npy")).unwrap();
    fs::write(bench.path("cut.npy"), &cut[..cut.len() - 9]).unwrap();
    says(&["--set", "A=cut.npy"], &["cut.npy"]);
    write_npy(
        bench.path("cube.npy"),
        &ndarray::Array3::<f64>::zeros((1, 2, 2)),
    )
    .unwrap();
    says(&["--set", "A=cube.npy"], &["cube.npy", "(H,W)"]);
    assert!(!bench.path("out").exists());
}

#[test]
fn an_event_at_the_chip_s_origin_is_kept_and_flagged() {
    let bench = Bench::new("scamp5_load_point(R5, 0, 0); scamp5_scan_events(R5, on, 10);");
    let output = bench.command(&["--json"]).assert().success();
    let json: serde_json::Value = serde_json::from_slice(&output.get_output().stdout).unwrap();
    assert_eq!(
        (&json["events"], &json["ambiguous"]),
        (&1.into(), &1.into())
    );
    let output = bench.command(&["--events", "e.csv"]).assert().success();
    let text = String::from_utf8(output.get_output().stdout.clone()).unwrap();
    assert!(
        text.contains("1 event at the chip's (0,0)") && text.contains("would lose it"),
        "{text}"
    );
    let packet = amacrine::event::file::read(&bench.path("e.csv"))
        .unwrap()
        .packet;
    assert_eq!(
        (packet.events[0].x, packet.events[0].y),
        (255, 0),
        "top right"
    );
    let elsewhere = Bench::new("scamp5_load_point(R5, 0, 1); scamp5_scan_events(R5, on, 10);");
    let output = elsewhere.command(&[]).assert().success();
    let text = String::from_utf8(output.get_output().stdout.clone()).unwrap();
    assert!(
        text.contains("events   1 ") && !text.contains("(0,0)"),
        "{text}"
    );
}

#[test]
fn every_shipped_program_runs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for folder in fs::read_dir(root.join("programs")).unwrap() {
        for file in fs::read_dir(folder.unwrap().path()).unwrap() {
            let file = file.unwrap().path().display().to_string();
            for domain in ["exact", "q8.8", "silicon"] {
                good(root, &["exec", &file, "--domain", domain]);
            }
        }
    }
}

/// What `words` and `array_us` are in a sweep has keys of its own beside those of the whole run.
#[test]
fn costs_of_a_frame_have_their_own_keys() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let run = |frames: &str| {
        let said = ["exec", "dvs/snap", "--image", "bundled", "--frames", frames];
        json(root, &said)
    };
    let (two, four) = (run("2"), run("4"));
    let of = |said: &serde_json::Value, key: &str| said[key].as_f64().unwrap();
    let each = (of(&four, "words") - of(&two, "words")) / 2.0;
    assert_eq!(of(&four, "words_per_frame"), each);
    let each = (of(&four, "array_us") - of(&two, "array_us")) / 2.0;
    assert!((of(&four, "array_us_per_frame") - each).abs() < 1e-9);
}

#[test]
fn numbers_of_the_chip_can_be_set() {
    let bench = Bench::new("mov(B, A);").set("A", &Plane::from_elem((16, 16), 50.0));
    let perfect = [
        "--set",
        "A=A.in.npy",
        "--domain",
        "silicon",
        "--set",
        "error.loss=0",
        "--set",
        "error.gain_mismatch=0",
        "--set",
        "error.offset_mismatch=0",
        "--set",
        "error.noise=0",
    ];
    bench.run(&perfect);
    assert!(bench.analog("B").iter().all(|v| (v - 50.0).abs() < 1e-4));
    let bench = Bench::new("mov(B, A);").set("A", &ramp());
    let says = |arguments: &[&str], parts: &[&str]| {
        let text = bench.refused(arguments);
        for part in parts {
            assert!(text.contains(part), "{part:?} in {text}");
        }
    };
    says(&["--set", "error.los=0"], &["error.los", "error.loss"]);
    says(
        &["--set", "error.loss=much"],
        &["much", "from 0 to below 1"],
    );
    says(
        &["--set", "error.loss=1"],
        &["error.loss cannot be 1", "from 0 to below 1"],
    );
    says(&["--set", "PIX=A.in.npy"], &["PIX", "--image"]);
}

/// Spread over runs against the formula: noise of two stores, and mismatch that is another on
/// every chip.
#[test]
fn many_runs_are_summed_up() {
    let bench =
        Bench::new("where(A); MOV(R5, FLAG); all(); mov(B, A); scamp5_scan_events(R5, on, 3000);")
            .set(
                "A",
                &Plane::from_shape_fn((40, 50), |(_, x)| x as f64 - 25.0),
            );
    let run = |domain: &str, arguments: &[&str]| -> serde_json::Value {
        let mut all = vec!["--set", "A=A.in.npy", "--domain", domain, "--json"];
        all.extend(arguments);
        let output = bench.command(&all).assert().success().get_output().clone();
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let of = |arguments: &[&str]| run("silicon", arguments);
    let quiet = [
        "--set",
        "error.gain_mismatch=0",
        "--set",
        "error.offset_mismatch=0",
        "--set",
        "error.noise=2",
        "--set",
        "error.loss=0",
        "--repeat",
        "40",
    ];
    let json = of(&quiet);
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let b = &json["registers"]["B"];
    assert!(
        (number(&b["temporal_sd"]) - 2.0 * 2f64.sqrt()).abs() < 0.05,
        "{b}"
    );
    // A ramp of 50 steps: (50² - 1) / 12, and the noise.
    let spatial = ((2499.0 / 12.0) + 8.0f64).sqrt();
    assert!((number(&b["spatial_sd"]) - spatial).abs() < 0.1, "{b}");
    assert!((number(&b["mean"]) + 0.5).abs() < 0.05, "{b}");
    // Pixels of 1 and more: 24 columns of 40.
    assert_eq!(number(&json["events"]["mean"]), 960.0);
    assert_eq!(number(&json["events"]["sd"]), 0.0);
    assert_eq!(json["runs"], 40);
    // One run has no deviation from run to run; the exact one has none at all.
    assert!(of(&["--repeat", "1"])["registers"]["B"]["temporal_sd"].is_null());
    let exact = run("exact", &["--repeat", "3"]);
    assert_eq!(exact["registers"]["B"]["temporal_sd"], 0.0);
    let first = of(&["--repeat", "2", "--seed", "5"]);
    assert_ne!(
        first["registers"],
        of(&["--repeat", "2", "--seed", "6"])["registers"]
    );
    assert!(
        bench
            .refused_alone(&["--repeat", "0"])
            .contains("a whole number from 1 on")
    );
    let output = bench
        .command(&["--set", "A=A.in.npy", "--repeat", "2"])
        .assert()
        .success();
    let text = String::from_utf8(output.get_output().stdout.clone()).unwrap();
    assert!(
        text.contains("spatial sd") && text.contains("seeds 0 to 1"),
        "{text}"
    );
}

#[test]
fn a_strip_has_a_row_for_each_register_and_a_column_for_each_line() {
    let bench =
        Bench::new("mov(B, A);\n// nothing\nwhere(B);\nMOV(R5, FLAG);\nall();\n").set("A", &ramp());
    bench
        .command(&["--set", "A=A.in.npy", "--strip", "strip.png"])
        .assert()
        .success();
    let strip = image::open(bench.path("strip.png")).unwrap().to_rgb8();
    // B, NEWS, R5, FLAG of 7x5 pixels, 16 times as large, under four lines of text; four lines.
    let (width, height) = strip.dimensions();
    assert_eq!(width, 16 + 56 + 4 * (112 + 8) + 8);
    assert_eq!(height, 16 + 4 * 20 + 8 + 4 * (80 + 8) + 8);
    // The first cell is B behind `mov(B, A)`, framed: A's own values as gray.
    let cell = |i: u32, j: u32, y: u32, x: u32| {
        let (left, top) = (72 + i * 120, 104 + j * 88);
        strip.get_pixel(left + 16 * x + 8, top + 16 * y + 8).0[0]
    };
    for ((y, x), value) in ramp().indexed_iter() {
        let gray = (value + 128.0).round() as u8;
        assert_eq!(cell(0, 0, y as u32, x as u32), gray);
        assert_eq!(
            cell(1, 0, y as u32, x as u32),
            176 + gray / 4,
            "pale: not written"
        );
        let flag = if *value > 0.0 { 255 } else { 0 };
        assert_eq!(cell(1, 3, y as u32, x as u32), flag, "FLAG behind `where`");
        assert_eq!(cell(2, 2, y as u32, x as u32), flag, "R5 behind `MOV`");
    }
    let empty = Bench::new("scamp5_load_in(3);");
    let text = empty.refused_alone(&["--strip", "s.png", "--dump", "out"]);
    assert!(text.contains("nothing"), "{text}");
    assert!(!empty.path("s.png").exists());
}

/// A dump that fails half-way leaves what was there, and no file of its own.
#[cfg(target_os = "linux")]
#[test]
fn registers_are_dumped_all_or_none() {
    let bench = Bench::new("frame { get_image(A); }").set("A", &ramp());
    fs::create_dir(bench.path("out")).unwrap();
    fs::write(bench.path("out/A.npy"), "old").unwrap();
    std::os::unix::fs::symlink("/dev/full", bench.path("out/F.png")).unwrap();
    let said = bench.command(&["--set", "A=A.in.npy", "--dump", "out"]);
    let said = { said }.assert().code(2).get_output().clone();
    let said = line(&said.stderr);
    assert!(
        said.contains("out/F.png") && said.contains("No space left"),
        "{said}"
    );
    assert_eq!(fs::read(bench.path("out/A.npy")).unwrap(), b"old");
    assert_eq!(fs::read_dir(bench.path("out")).unwrap().count(), 2);
}

#[test]
fn a_clip_is_run_whole_and_its_end_is_told() {
    let text = "//! frames = 2\n\ninit { get_image(C); }\nframe { get_image(D); }";
    let bench = Bench::new(text);
    let clip = ndarray::Array3::<f64>::zeros((5, 4, 5));
    write_npy(bench.path("clip.npy"), &clip).unwrap();
    let said = |more: &[&str]| {
        let all = [&["--image", "clip.npy", "--fps", "100", "--json"], more].concat();
        let output = bench.command(&all).assert().success().get_output().clone();
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        (json["frames"].as_u64().unwrap(), json["notes"].to_string())
    };
    let (frames, notes) = said(&[]);
    assert!(
        frames == 5 && notes.contains("frames = 2") && notes.contains("--frames 2"),
        "{notes}"
    );
    assert_eq!(said(&["--frames", "2"]), (2, "[]".to_owned()));
    let (frames, notes) = said(&["--frames", "8"]);
    assert!(
        frames == 8 && notes.contains("ends after 5 frames") && notes.contains("3 more"),
        "{notes}"
    );
    // A shorter one is not drawn out, either.
    let long = text.replace("= 2", "= 20");
    fs::write(bench.path("long.scamp"), long).unwrap();
    let all = ["exec", "long.scamp", "--image", "clip.npy", "--fps", "100"];
    let json = json(bench.folder.path(), &all);
    assert_eq!(json["frames"], 5);
    // A pattern that says how many frames it has is a clip; others go on.
    let pattern = |more: &str| {
        let image = format!("pattern:noise?width=5&height=4{more}");
        let all = ["--image", &image, "--json"];
        let output = bench.command(&all).assert().success().get_output().clone();
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        json["frames"].as_u64().unwrap()
    };
    assert_eq!((pattern("&frames=5"), pattern("")), (5, 2));
    // One picture is one frame; nobody is told of it where nothing more was asked for.
    let one = ndarray::Array3::<f64>::zeros((1, 4, 5));
    write_npy(bench.path("clip.npy"), &one).unwrap();
    let (frames, notes) = said(&["--frames", "8"]);
    assert!(
        frames == 8 && notes.contains("ends after 1 frame;") && notes.contains("7 more"),
        "{notes}"
    );
    let plain = Bench::new("init { get_image(C); }\nframe { get_image(D); }");
    write_npy(plain.path("one.npy"), &one).unwrap();
    let all = ["--image", "one.npy", "--json"];
    let output = plain.command(&all).assert().success().get_output().clone();
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        (&json["frames"], &json["notes"]),
        (&2.into(), &serde_json::json!([]))
    );
}

/// Whole bit planes are read without slots, and their events are counted all the same.
#[test]
fn events_of_bit_planes_are_told() {
    let text = "init { get_image(C); }\nframe {\n get_image(D); sub(E, D, C); scamp5_in(F, 5); sub(E, E, F);\n\
                where(E); MOV(R5, FLAG); all(); scamp5_scan_dreg(R5, on0, 0, 3); mov(C, D); }";
    let mut clip = ndarray::Array3::<f64>::zeros((3, 4, 5));
    clip[[1, 2, 3]] = 20.0;
    clip[[2, 2, 3]] = 20.0;
    clip[[2, 1, 2]] = 100.0;
    let bench = Bench::new(text);
    write_npy(bench.path("clip.npy"), &clip).unwrap();
    let said = |more: &[&str]| {
        let all = [&["--image", "clip.npy", "--fps", "100"], more].concat();
        let output = bench.command(&all).assert().success().get_output().clone();
        String::from_utf8(output.stdout).unwrap()
    };
    assert!(
        said(&[]).contains("events   2 (2 ON, 0 OFF)\n"),
        "{}",
        said(&[])
    );
    let written = said(&["-o", "e.csv"]);
    assert!(written.contains("events   2 (2 ON, 0 OFF)\n"), "{written}");
}

/// Only analogue cells err.
#[test]
fn an_error_that_is_set_where_none_is_made_is_told() {
    let bench = Bench::new("mov(B, A);").set("A", &ramp());
    let said = |more: &[&str]| {
        let all = [&["--set", "A=A.in.npy", "--set", "error.noise=50"], more].concat();
        let output = bench.command(&all).assert().success().get_output().clone();
        line(&output.stdout)
    };
    let note = "note error.noise changes nothing in the domain exact";
    assert!(said(&[]).contains(note), "{}", said(&[]));
    let silicon = said(&["--domain", "silicon", "--seed", "3"]);
    assert!(!silicon.contains("changes nothing"), "{silicon}");
    let seed = bench.command(&["--set", "A=A.in.npy", "--seed", "3"]);
    let seed = line(&{ seed }.assert().success().get_output().stdout);
    let note = "note --seed changes nothing in the domain exact";
    assert!(seed.contains(note), "{seed}");
}

#[test]
fn events_of_a_program_without_a_readout_are_refused() {
    let bench = Bench::new("mov(B, A);");
    let text = bench.refused_alone(&["--events", "e.csv"]);
    assert!(
        text.contains("reads no events out") && text.contains("scamp5_scan_events"),
        "{text}"
    );
}

#[test]
fn what_was_written_is_listed_and_saturation_is_told() {
    let bench = Bench::new("add(B, A, C);\nadd(D, B, A);")
        .set("A", &ramp().mapv(|v| 4.0 * v))
        .set("C", &ramp().mapv(|v| 3.0 * v));
    let sets = ["--set", "A=A.in.npy", "--set", "C=C.in.npy"];
    let run = |more: &[&str]| {
        bench
            .command(&[&sets, more].concat())
            .assert()
            .success()
            .get_output()
            .clone()
    };
    let output = run(&["--dump", "out", "--strip", "s.png"]);
    let (said, warned) = (line(&output.stdout), line(&output.stderr));
    assert!(
        said.contains("wrote s.png") && said.contains("wrote out (42 files)"),
        "{said}"
    );
    let told = run(&["--dump", "out", "--strip", "s.png", "--json"]);
    let told: serde_json::Value = serde_json::from_slice(&told.stdout).unwrap();
    assert_eq!(told["written"], serde_json::json!(["s.png", "out"]));
    assert!(
        warned
            .contains("in B after the last frame lie beyond the range of a register, -128 to 127"),
        "{warned}"
    );
    let warned = line(&run(&["--clip", "on"]).stderr);
    assert!(
        warned.contains("lie at the end of its range") && !warned.contains("beyond"),
        "{warned}"
    );
    // A picture of which every pixel is cut off, beside constants that are loaded.
    let bench = Bench::new(
        "init { scamp5_in(E, 127); }\nframe { mov(C, A); add(B, A, C); scamp5_in(F, -128); }",
    )
    .set("A", &ramp().mapv(|_| 100.0));
    let output = bench.command(&["--set", "A=A.in.npy", "--clip", "on"]);
    let warned = line(&{ output }.assert().success().get_output().stderr);
    assert!(
        warned.contains("(100 %) in B after")
            && !warned.contains(" in E ")
            && !warned.contains(" in F "),
        "{warned}"
    );
    // A number sets a constant of the program.
    let bench = Bench::new("const t = 3;\nscamp5_in(A, t);");
    bench.run(&["--set", "t=7", "--image", "pattern:spot?width=4&height=4"]);
    assert!(bench.analog("A").iter().all(|v| *v == 7.0));
}

/// A format that does not hold where the photodiodes begin, or a constant of the program, is told
/// once with the one thing that helps; what comes of it is not blamed on light or thresholds.
#[test]
fn a_format_that_does_not_hold_a_program_s_numbers_is_told() {
    let warned = |program: &str, more: &[&str]| {
        let bench = Bench::new(program);
        let scene = "pattern:disc?width=16&height=12&frames=4";
        let all = [&["--image", scene][..], more].concat();
        let output = bench.command(&all).assert().success().get_output().clone();
        line(&output.stderr)
    };
    let snap = "init { get_image(A); }\nframe {\nget_image(B); sub(C, B, A); mov(A, B);\nscamp5_in(D, 10);\nsub(E, C, D); where(E); MOV(R5, FLAG); all();\nscamp5_scan_events(R5, on, 100); }";
    let light =
        "-64 to 63.998 LSB, and not the -127 LSB at which the photodiodes begin (light.reset)";
    let change = "take a format of 8 bits or more before the point, such as";
    for (program, more, parts) in [
        (
            snap,
            &["--domain", "q7.9"][..],
            [light, "clipped", change, "q8.8"],
        ),
        (
            snap,
            &["--domain", "q7.9", "--clip", "on"],
            [light, "clipped", change, "q8.8"],
        ),
        (
            snap,
            &["--domain", "q7.9", "--repeat", "2"],
            [light, "clipped", change, "q8.8"],
        ),
        (
            snap,
            &["--domain", "q4.4-wrap"],
            [
                "q4.4-wrap holds -8 to 7.938 LSB, and not the -127 LSB",
                ", nor the 10 LSB that line 4 loads",
                "wrap around",
                "q8.8",
            ],
        ),
        (
            snap,
            &["--domain", "q0.8"],
            [
                "q0.8 holds -0.5 to 0.496 LSB",
                ", nor the 10 LSB that line 4 loads",
                change,
                "q8.8",
            ],
        ),
        (
            "get_image(A);",
            &["--domain", "q7.25"],
            ["-64 to 64 LSB", "clipped", change, "q8.24"],
        ),
        (
            "const t = 3;\nscamp5_in(A, t);",
            &["--domain", "q7.9", "--set", "t=100"],
            [
                "q7.9 holds -64 to 63.998 LSB",
                ", and not the 100 LSB that line 2 loads",
                change,
                "q8.8",
            ],
        ),
    ] {
        let text = warned(program, more);
        for part in parts {
            assert!(text.contains(part), "{more:?}: {part:?} in {text}");
        }
        assert_eq!(text.matches("warning: ").count(), 1, "{more:?}: {text}");
        for wrong in ["lower the threshold", "reduce light", "changes too little"] {
            assert!(!text.contains(wrong), "{more:?}: {wrong} in {text}");
        }
    }
    for domain in ["q8.8", "q8.0", "q9.7", "exact", "silicon"] {
        let text = warned(snap, &["--domain", domain]);
        assert!(!text.contains("LSB at which"), "{domain}: {text}");
    }
    // What reads no light needs no room for it.
    let text = warned("scamp5_in(A, 60);\nmov(B, A);", &["--domain", "q7.9"]);
    assert!(!text.contains("warning"), "{text}");
}

/// A number for a name of the chip is refused, and what the refusal says to write can be written.
#[test]
fn the_way_to_set_a_name_of_the_chip_can_be_gone() {
    let said = |name: &str, value: &str| {
        let set = format!("{name}={value}");
        Bench::new("mov(B, A);").refused(&["--set", &set])
    };
    for (name, value) in [
        ("A", "100"),
        ("F", "-128"),
        ("IN", "7"),
        ("R5", "1"),
        ("R12", "0"),
        ("RP", "1"),
    ] {
        let text = said(name, value);
        let (_, write) = text.split_once("write `").unwrap();
        let (statement, _) = write.split_once('`').unwrap();
        let program = format!("{statement}\nmov(B, A);");
        Bench::new(&program).run(&["--image", "pattern:spot?width=4&height=4"]);
    }
    assert!(said("R12", "1").contains("where R0 is 1"));
    // A value that no statement takes, or a name that none writes: files, where there are such.
    let zero = Plane::zeros((3, 4));
    for (name, value) in [("A", "500"), ("NEWS", "0"), ("FLAG", "0"), ("R5", "2")] {
        let text = said(name, value);
        let file = format!("exec --set {name}=FILE.npy");
        assert!(text.contains(&file) && !text.contains("write"), "{text}");
        let set = format!("{name}={name}.in.npy");
        Bench::new("mov(B, A);")
            .set(name, &zero)
            .run(&["--set", &set]);
    }
    let light = said("PIX", "0");
    assert!(
        light.contains("exec --image SCENE") && !light.contains("FILE"),
        "{light}"
    );
    for name in ["XE", "east"] {
        let text = said(name, "0");
        assert!(
            !text.contains("FILE") && !text.contains("scamp5_in"),
            "{text}"
        );
    }
    let bench = Bench::new("mov(B, A);").set("A", &zero);
    let unknown = bench.refused(&["--set", "XE=A.in.npy"]);
    assert!(
        unknown.contains("R12 and FLAG") && !unknown.contains("PIX"),
        "{unknown}"
    );
}

/// Over either grid, half of the array is half of the scale (the vendor's: 0 to 4095).
#[test]
fn both_grids_count_on_one_scale() {
    let bench = Bench::new(
        "scamp5_load_rect(R5, 0, 0, 255, 127);\nscamp5_global_count(R5, A);\nscamp5_global_count(R5, A, 1);",
    );
    let told = json(bench.folder.path(), &["exec", "p.scamp"]);
    let readings = told["readings"].as_array().unwrap();
    assert_eq!(readings.len(), 2, "{told}");
    for reading in readings {
        assert_eq!(reading["value"]["sum"], 2048, "{reading}");
    }
}

/// A program that shows nothing makes no folder, and that is said.
#[test]
fn nothing_shown_is_no_folder() {
    let bench = Bench::new("frame { mov(B, A); }");
    let arguments = ["exec", "p.scamp", "--frames", "2", "--displays", "shown"];
    let said = json(bench.folder.path(), &arguments);
    assert!(!bench.path("shown").exists());
    assert_eq!(said["written"].as_array().unwrap().len(), 0, "{said}");
    let notes = said["notes"].to_string();
    assert!(
        notes.contains("--displays shown: nothing was written"),
        "{notes}"
    );
}

/// A program of no statement runs, and is told.
#[test]
fn a_program_of_nothing_is_told() {
    let bench = Bench::new("// nothing yet\n").set("A", &ramp());
    let output = bench.command(&["--set", "A=A.in.npy", "--json"]);
    let output = { output }.assert().success().get_output().clone();
    let told = "no statement is in it, and no word runs";
    assert!(line(&output.stderr).contains(told), "{output:?}");
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(json["source_warnings"].to_string().contains(told), "{json}");
}

/// Light that nothing captures, and registers that nothing has written, are told.
#[test]
fn light_that_nothing_captures_is_told() {
    let scene = "pattern:disc?width=7&height=5&frames=2";
    let said = |text: &str, arguments: &[&str]| {
        let bench = Bench::new(text).set("A", &ramp());
        let output = bench.command(&[arguments, &["--json"]].concat());
        let output = { output }.assert().success().get_output().clone();
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let told = json["source_warnings"].to_string();
        let shown = line(&output.stderr).contains("no word captures it");
        assert_eq!(shown, told.contains("no word captures it"), "{told}");
        told
    };
    let image = ["--image", scene];
    let text = "movx(B, A, south);\nadd(A, B, A);\nWHERE(R5); sub(A, A, C); ALL();\n";
    let told = said(text, &image);
    assert!(
        told.contains("light is given, and no word captures it")
            && told.contains("nothing has written A, C and R5 before they are read")
            && told.contains("give --set A=FILE.npy, or begin with `get_image(A);`"),
        "{told}"
    );
    // What is set is an input.
    let some = said(text, &[&image[..], &["--set", "A=A.in.npy"]].concat());
    assert!(some.contains("nothing has written C and R5"), "{some}");
    for (text, arguments) in [
        (
            "movx(B, A, south);\n",
            &["--image", scene, "--set", "A=A.in.npy"][..],
        ),
        ("movx(B, A, south);\n", &["--set", "A=A.in.npy"]),
        ("get_image(C); movx(B, A, south);\n", &image),
        ("scamp5_in(A, 3); movx(B, A, south);\n", &image),
        ("init { res(A); } frame { movx(B, A, south); }\n", &image),
    ] {
        assert!(!said(text, arguments).contains("captures"), "{text}");
    }
}

/// Of a register that is set nobody says that nothing writes it.
#[test]
fn registers_that_are_set_are_written() {
    let of_p = "init { res(A); }\nframe { MOV(R6, R5); MOV(R7, R8); }";
    let bench = Bench::new(of_p).set("R5", &Plane::from_elem((5, 7), 1.0));
    let of_cpp = "int main() { while (1) { vs_frame_loop_control(); MOV(R6, R5); MOV(R7, R8); } }";
    fs::write(bench.path("p.cpp"), of_cpp).unwrap();
    for file in ["p.scamp", "p.cpp"] {
        for (set, told) in [
            (&["--set", "R5=R5.in.npy"][..], &["R8"][..]),
            (&[], &["R5", "R8"]),
        ] {
            let run = [&["exec", file, "--frames", "1", "--json"], set].concat();
            let output = amacrine(bench.folder.path(), &run);
            let output = { output }.assert().success().get_output().clone();
            let said = line(&output.stderr);
            let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
            for name in ["R5", "R8"] {
                let message = format!("nothing in this program writes {name}");
                let told = told.contains(&name);
                assert_eq!(said.contains(&message), told, "{file}: {said}");
                let source = json["source_warnings"].to_string();
                assert_eq!(source.contains(&message), told, "{file}: {source}");
            }
        }
    }
}

/// Each of several kinds is told by its name, and one that says nothing where another speaks is warned
/// of, by `run` too.
#[test]
fn kinds_are_told_and_a_silent_one_is_warned_of() {
    let scan = |kind: usize| format!("scamp5_scan_events(R5, on{kind}, 100);");
    let program = format!(
        "//! names = [\"spot\", \"dead\"]\ninit {{ get_image(C); }}\nframe {{\n get_image(D); sub(E, D, C); scamp5_in(F, 5); sub(E, E, F);\n where(E); MOV(R5, FLAG); all(); {}\n CLR(R5); {}\n mov(C, D); }}",
        scan(0),
        scan(1)
    );
    let bench = Bench::new(&program);
    let mut clip = ndarray::Array3::<f64>::zeros((3, 4, 5));
    clip[[1, 2, 3]] = 200.0;
    write_npy(bench.path("clip.npy"), &clip).unwrap();
    let shown = ["--image", "clip.npy", "--fps", "100"];
    let ran = bench.command(&shown).output().unwrap();
    let said = String::from_utf8(ran.stdout).unwrap();
    assert!(said.contains("  channel 0 spot: 1 ON, 0 OFF\n"), "{said}");
    assert!(said.contains("  channel 1 dead: 0 ON, 0 OFF\n"), "{said}");
    let warned = line(&ran.stderr);
    assert!(
        warned.contains("p.scamp, dead: no event at all in 3 frames"),
        "{warned}"
    );
    let told = json(
        bench.folder.path(),
        &[&["exec", "p.scamp"], &shown[..], &["--json"]].concat(),
    );
    assert_eq!(told["kinds"][0]["name"], "spot");
    assert_eq!(told["kinds"][0]["on"], 1);
    assert_eq!(told["kinds"][1]["on"], 0);
    let sensor = "response = \"identity\"\nmemory = \"filtered-snap\"\nborder = \"zero\"\n[[channel]]\nname = \"spot\"\nkernel = [[1]]\nthreshold = { on = 20, off = 20 }\n[[channel]]\nname = \"dead\"\nkernel = [[1]]\nthreshold = { on = 900, off = 900 }\n";
    fs::write(bench.path("s.toml"), sensor).unwrap();
    let shown = [
        "run", "--scene", "clip.npy", "--fps", "100", "--sensor", "s.toml",
    ];
    let warned = amacrine(bench.folder.path(), &shown).output().unwrap();
    let warned = line(&warned.stderr);
    assert!(
        warned.contains("s, dead: no event at all in 3 frames"),
        "{warned}"
    );
    // Two thresholds are those of both signs.
    let both = [&shown[..], &["--threshold", "20,30"]].concat();
    let said = good(bench.folder.path(), &both);
    assert!(
        said.contains("threshold 20 for ON and 30 for OFF, of all 2 kinds\n"),
        "{said}"
    );
}
