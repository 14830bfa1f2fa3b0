//! Proves that `amacrine exec` does what programs written for the chip do, from text to files:
//! against results worked out by hand and with plain arithmetic on planes, in several domains,
//! and that every bad input gets its message, exit code 2, and leaves nothing behind.

use std::{fs, path::Path};

use amacrine::plane::Plane;
use assert_cmd::Command;
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
        let mut command = Command::cargo_bin("amacrine").unwrap();
        command
            .current_dir(self.folder.path())
            .env("NO_COLOR", "1")
            .args(["exec", "p.scamp"])
            .args(arguments);
        command
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
        let output = self.command(&all).assert().code(2).get_output().clone();
        assert!(!self.path("out").exists() && !self.path("e.csv").exists());
        assert!(output.stdout.is_empty());
        let text = String::from_utf8(output.stderr).unwrap();
        // Long messages are wrapped and framed.
        text.replace('│', " ")
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ")
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
    says(&["--frames", "0"], &["--frames 0"]);
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
    assert!(!Path::new("out").exists());
}
