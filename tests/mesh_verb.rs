//! The verb `mesh`: its contract (float64 planes in and out, settled to the last digits), what
//! it refuses and how, and that nothing is left behind by a refusal.

mod common;

use std::{fs, path::Path};

use amacrine::{
    mesh::{Between, Flow, Laterals, Mismatch, Network, Sheet, Steady},
    plane::{Plane, Size},
};
use common::amacrine;
use ndarray::Array3;
use ndarray_npy::{read_npy, write_npy};

fn mesh(arguments: &[&str], folder: &Path) -> std::process::Output {
    let all = [&["mesh"], arguments].concat();
    amacrine(folder, &all).output().unwrap()
}

#[track_caller]
fn refused(arguments: &[&str], folder: &Path) -> String {
    common::refused(folder, &[&["mesh"], arguments].concat(), &[])
}

fn scene(height: usize, width: usize) -> Plane<f64> {
    Plane::from_shape_fn((height, width), |(y, x)| {
        ((3 * y + 5 * x) % 17) as f64 + 0.1 * x as f64
    })
}

#[test]
fn solve_keeps_its_contract() {
    let folder = tempfile::tempdir().unwrap();
    let signal = scene(13, 29);
    write_npy(folder.path().join("P.npy"), &signal).unwrap();
    for lambda in ["0", "1e-6", "0.5", "10", "1e4", "1e6"] {
        let out = mesh(
            &[
                "solve", "--lambda", lambda, "--input", "P.npy", "--output", "H.npy",
            ],
            folder.path(),
        );
        assert!(
            out.status.success(),
            "{}",
            String::from_utf8_lossy(&out.stderr)
        );
        let got: Plane<f64> = read_npy(folder.path().join("H.npy")).unwrap();
        let sheet = Sheet::new(lambda.parse().unwrap()).unwrap();
        let want = Steady::new(sheet, Size::of(&signal))
            .unwrap()
            .solve(&signal)
            .unwrap();
        assert_eq!(got, want, "{lambda}");
    }
    // Other numbers, other outputs.
    write_npy(folder.path().join("bytes.npy"), &signal.mapv(|v| v as u8)).unwrap();
    let out = mesh(
        &[
            "solve",
            "--lambda",
            "3",
            "--lambda-y",
            "1",
            "--input",
            "bytes.npy",
            "--output",
            "D.npy",
            "--show",
            "difference",
            "--json",
        ],
        folder.path(),
    );
    let said: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    assert_eq!(
        (&said["lambda_x"], &said["lambda_y"]),
        (&3.0.into(), &1.0.into())
    );
    let got: Plane<f64> = read_npy(folder.path().join("D.npy")).unwrap();
    assert!(got.sum().abs() < 1e-9);
    // A picture in, a picture out.
    let out = mesh(
        &[
            "solve", "--lambda", "3", "--input", "P.npy", "--output", "H.png",
        ],
        folder.path(),
    );
    assert!(out.status.success());
    let out = mesh(
        &[
            "solve", "--lambda", "0", "--input", "H.png", "--output", "P.npy",
        ],
        folder.path(),
    );
    assert!(out.status.success());
    let gray: Plane<f64> = read_npy(folder.path().join("P.npy")).unwrap();
    assert!(gray.iter().any(|v| *v == 255.0) && gray.iter().any(|v| *v == 0.0));
}

#[test]
fn solve_refuses_what_it_cannot_answer() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for (bad, name) in [
        (f64::NAN, "NaN"),
        (f64::INFINITY, "inf"),
        (-1e300, "-1e300"),
    ] {
        let mut signal = scene(7, 9);
        signal[[4, 6]] = bad;
        write_npy(here.join("P.npy"), &signal).unwrap();
        let said = refused(
            &[
                "solve", "--lambda", "2", "--input", "P.npy", "--output", "H.npy",
            ],
            here,
        );
        assert!(
            said.contains("P.npy")
                && said.contains("the pixel at x = 6, y = 4 is")
                && said.contains(name),
            "{said}"
        );
    }
    write_npy(here.join("P.npy"), &scene(7, 9)).unwrap();
    for lambda in ["-1", "nan", "inf", "1e200"] {
        let said = refused(
            &[
                "solve", "--lambda", lambda, "--input", "P.npy", "--output", "H.npy",
            ],
            here,
        );
        assert!(said.contains("the space constant is"), "{said}");
    }
    refused(
        &[
            "solve", "--lambda", "ten", "--input", "P.npy", "--output", "H.npy",
        ],
        here,
    );
    refused(
        &[
            "solve", "--lambda", "1", "--input", "none.npy", "--output", "H.npy",
        ],
        here,
    );
    write_npy(here.join("cube.npy"), &Array3::<f64>::zeros((2, 3, 4))).unwrap();
    refused(
        &[
            "solve", "--lambda", "1", "--input", "cube.npy", "--output", "H.npy",
        ],
        here,
    );
    fs::write(
        here.join("half.npy"),
        &fs::read(here.join("P.npy")).unwrap()[..200],
    )
    .unwrap();
    refused(
        &[
            "solve", "--lambda", "1", "--input", "half.npy", "--output", "H.npy",
        ],
        here,
    );
    assert!(!here.join("H.npy").exists());
}

#[test]
fn step_is_the_exact_flow() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let frames: Vec<_> = (0..4)
        .map(|n| scene(6, 8).mapv(|v| v * f64::from(n) + 1.0))
        .collect();
    let stack = Array3::from_shape_fn((4, 6, 8), |(t, y, x)| frames[t][[y, x]]);
    write_npy(here.join("scene.npy"), &stack).unwrap();
    let run = |rule: &str| -> Array3<f64> {
        let out = mesh(
            &[
                "step",
                "--lambda",
                "2",
                "--tau",
                "1ms",
                "--scene",
                "scene.npy",
                "--fps",
                "500",
                "--rule",
                rule,
                "--output",
                "H.npy",
            ],
            here,
        );
        assert!(
            out.status.success(),
            "{}",
            String::from_utf8_lossy(&out.stderr)
        );
        read_npy(here.join("H.npy")).unwrap()
    };
    for (rule, between) in [("ramp", Between::Ramp), ("step", Between::Step)] {
        let got = run(rule);
        let mut flow = Flow::settled(Sheet::new(2.0).unwrap(), 1e-3, &frames[0]).unwrap();
        for (n, frame) in frames.iter().enumerate() {
            if n > 0 {
                flow.advance(frame, 1.0 / 500.0, between).unwrap();
            }
            let layer = got.index_axis(ndarray::Axis(0), n);
            let error = layer
                .iter()
                .zip(flow.surround())
                .map(|(a, b)| (a - b).abs());
            assert!(error.fold(0.0, f64::max) < 1e-12, "{rule} {n}");
        }
    }
    // v2e's own start: the first frame itself.
    assert_eq!(run("v2e").index_axis(ndarray::Axis(0), 0), frames[0]);
    let mut bad = stack.clone();
    bad[[2, 5, 7]] = f64::NAN;
    write_npy(here.join("bad.npy"), &bad).unwrap();
    let said = refused(
        &[
            "step", "--lambda", "2", "--tau", "1ms", "--scene", "bad.npy", "--output", "no.npy",
        ],
        here,
    );
    assert!(said.contains("frame 2, y 5, x 7"), "{said}");
    assert!(!here.join("no.npy").exists());
}

#[test]
fn fit_and_show_say_what_a_mesh_can_do() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let out = mesh(&["fit", "csdvs-5", "sobel-x", "--json"], here);
    let rows: Vec<serde_json::Value> = serde_json::from_slice(&out.stdout).unwrap();
    assert_eq!(rows.len(), 4);
    assert!(
        (rows[0]["error"].as_f64().unwrap() - 0.109).abs() < 0.002,
        "{}",
        rows[0]
    );
    assert_eq!(rows[2]["odd"], 1.0);
    let out = mesh(&["fit", "csdvs-5", "sobel-x"], here);
    let text = String::from_utf8(out.stdout).unwrap();
    assert!(
        text.contains("nothing: it is all unreachable") && text.contains("H(1.8"),
        "{text}"
    );
    // A pixel alone needs no sheet, and is said once.
    let out = mesh(&["fit", "dvs", "csdvs-5"], here);
    let text = String::from_utf8(out.stdout).unwrap();
    assert_eq!(text.matches("1.000 P: a pixel alone, no sheet").count(), 1);
    assert_eq!(text.matches("H(").count(), 3, "{text}");
    // Without a ridge the gains of two sheets would grow for ever.
    let out = mesh(&["fit", "dog", "--ridge", "0"], here);
    let text = String::from_utf8(out.stdout).unwrap();
    assert!(text.contains("with a ridge of 1e-"), "{text}");
    refused(&["fit", "no-such-kernel"], here);
    refused(&["fit", "dvs", "--sheets", "4"], here);
    refused(&["fit", "dvs", "--ridge", "-1"], here);
    for arguments in [
        &["show", "--lambda", "3", "--output", "a.png"][..],
        &["show", "--kernel", "dog", "--output", "b.png"][..],
    ] {
        assert!(mesh(arguments, here).status.success(), "{arguments:?}");
    }
    assert!(here.join("a.png").exists() && here.join("b.png").exists());
    refused(&["show", "--lambda", "-3", "--output", "c.png"], here);
    assert!(!here.join("c.png").exists());
}

#[test]
fn step_takes_short_times_and_names_and_answers_machines() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let stack = Array3::from_shape_fn((3, 4, 5), |(t, y, x)| (t * (x + 2 * y)) as f64);
    write_npy(here.join("scene.npy"), &stack).unwrap();
    let step = |more: &[&str]| {
        let always = ["step", "--lambda", "2", "--scene", "scene.npy", "--json"];
        let output = ["--fps", "500", "--output", "H.npy"];
        let out = mesh(&[&always[..], &output, more].concat(), here);
        let told = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(out.status.success(), "{told}");
        let said: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
        (
            said,
            read_npy::<_, Array3<f64>>(here.join("H.npy")).unwrap(),
        )
    };
    let (said, quoted) = step(&["--tau", "0.5us", "--response", "\"identity\""]);
    assert_eq!(said["frames"], 3);
    assert_eq!(said["size"], serde_json::json!({ "height": 4, "width": 5 }));
    assert!((said["tau_s"].as_f64().unwrap() - 0.5e-6).abs() < 1e-18);
    assert!(said["euler_steps"].is_null() && said["light"]["most"].as_f64() == Some(20.0));
    let (_, named) = step(&["--tau", "500ns", "--response", "identity"]);
    assert_eq!(quoted, named);
    let (said, _) = step(&[
        "--tau",
        "20ns",
        "--response",
        "{ linear = 255 }",
        "--rule",
        "v2e",
    ]);
    assert!(said["euler_steps"].as_u64() > Some(0));
    let refusal = |option: &str, value: &str| {
        let always = ["step", "--lambda", "2", "--scene", "scene.npy"];
        let more = ["--output", "no.npy", option, value];
        let tau: &[&str] = if option == "--tau" {
            &[]
        } else {
            &["--tau", "1ms"]
        };
        refused(&[&always[..], &more, tau].concat(), here)
    };
    for response in ["cubic", "linear = 255", "3"] {
        let said = refusal("--response", response);
        assert!(
            said.contains("identity") && said.contains("{ linear = 255 }"),
            "{said}"
        );
    }
    assert!(refusal("--tau", "20").contains("such as 36ns"));
}

/// What the command line says of a number that is none is what it expects, whatever the verb.
#[test]
fn numbers_that_are_none_are_told_what_is_expected() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, words) in [
        (
            &["exec", "x.scamp", "--seed", "-1"][..],
            "give a whole number, from 0 on",
        ),
        (
            &["exec", "x.scamp", "--fps", "fast"],
            "give a number, such as 0.5",
        ),
        (
            &["exec", "x.scamp", "--frames", "99999999999999999999"],
            "give a smaller number",
        ),
        // Where 0 is refused, nobody is told to give it.
        (
            &["exec", "x.scamp", "--frames", "-1"],
            "give a whole number from 1 on",
        ),
        (
            &["mesh", "step", "--frames", "0"],
            "give a whole number from 1 on",
        ),
        (
            &["compile", "sobel-x", "--events-per-frame", "-1"],
            "give a whole number from 1 to 1000000000000",
        ),
        (
            &["compile", "sobel-x", "--events-per-frame=x"],
            "give a whole number from 1 to 1000000000000",
        ),
        (
            &["compare", "a.npy", "b.npy", "--bins", "0"],
            "give a whole number from 1 to 1000",
        ),
        (
            &[
                "voxels", "a.npy", "-o", "v.npy", "--window", "1s", "--bins", "0",
            ],
            "give a whole number from 1 to 1000",
        ),
        (
            &[
                "voxels", "a.npy", "-o", "v.npy", "--window", "1s", "--bins", "-1",
            ],
            "give a whole number from 1 to 1000",
        ),
        (
            &["mesh", "show", "--output", "m.png"],
            "<--lambda <L>|--kernel <KERNEL>>",
        ),
    ] {
        common::refused(folder.path(), arguments, &[words]);
    }
}

/// A third sheet on top of the second is none.
#[test]
fn fit_shows_no_sheet_twice() {
    let folder = tempfile::tempdir().unwrap();
    let out = mesh(
        &["fit", "laplacian", "csdvs-7", "--sheets", "3", "--json"],
        folder.path(),
    );
    let rows: Vec<serde_json::Value> = serde_json::from_slice(&out.stdout).unwrap();
    let sheets: Vec<_> = rows
        .iter()
        .map(|row| row["sheets"].as_array().unwrap().len())
        .collect();
    assert_eq!(sheets, [1, 2, 1, 2], "{rows:?}");
}

#[test]
fn show_draws_both_directions_and_ignores_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let picture = |name: &str| image::open(here.join(name)).unwrap().into_rgb8();
    for (name, more) in [("a.png", &[][..]), ("b.png", &["--lambda-y", "0.5"])] {
        let all = [&["show", "--lambda", "4", "--output", name], more].concat();
        assert!(mesh(&all, here).status.success());
    }
    // Besides a spot and an edge across, an edge along a row.
    assert!(picture("b.png").width() > picture("a.png").width());
    let out = mesh(&["show", "--kernel", "csdvs-5", "--output", "c.png"], here);
    let said = String::from_utf8(out.stdout).unwrap();
    assert!(
        said.contains("P - ") && said.matches("H(").count() == 2,
        "{said}"
    );
    refused(
        &["show", "--kernel", "dog", "--lambda-y", "3", "-o", "d.png"],
        here,
    );
    refused(
        &["show", "--lambda", "3", "--sheets", "3", "-o", "d.png"],
        here,
    );
}

/// Steps, and signals in volts, are what a sheet is tried with.
#[test]
fn step_takes_any_signal() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let steps = Array3::from_shape_fn((3, 5, 4), |(t, _, _)| 0.18 * f64::from(u8::from(t > 0)));
    write_npy(here.join("s.npy"), &steps).unwrap();
    let all = [
        "step", "--lambda", "2", "--tau", "1ms", "--fps", "100", "--scene", "s.npy", "-o", "H.npy",
    ];
    let out = mesh(&all, here);
    assert!(out.status.success() && out.stderr.is_empty(), "{out:?}");
    refused(&[&all[..], &["--frames", "0"]].concat(), here);
}

#[test]
fn solve_says_what_it_wrote_and_what_it_takes() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let said = refused(
        &[
            "solve", "--lambda", "3", "--input", "gone.png", "--output", "H.npy",
        ],
        here,
    );
    let flat = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        flat.contains("give a picture or a .npy of shape (H,W)")
            && !flat.contains("clip that comes"),
        "{said}"
    );
    write_npy(here.join("P.npy"), &scene(7, 9)).unwrap();
    let solve = |show: &str, output: &str| {
        let asked = [
            "solve", "--lambda", "3", "--input", "P.npy", "--show", show, "--output", output,
        ];
        let out = mesh(&asked, here);
        assert!(out.status.success());
        String::from_utf8(out.stdout).unwrap()
    };
    // The sheet keeps the mean: what is left of the difference is rounding, and no minus zero.
    let line = solve("difference", "D.npy");
    assert!(line.contains("mean 0.0"), "{line}");
    assert!(line.len() < 80 && !line.contains("black"), "{line}");
    let line = solve("surround", "H.png");
    assert!(
        line.contains("; black is ") && line.contains(", white "),
        "{line}"
    );
}

/// A chip's parts are those of the library's network; its distance from equal parts is told.
#[test]
fn solve_takes_parts_that_differ() {
    let folder = tempfile::tempdir().unwrap();
    let signal = scene(13, 29);
    write_npy(folder.path().join("P.npy"), &signal).unwrap();
    let of = |more: &[&str]| {
        let files = ["--input", "P.npy", "--output", "H.npy", "--json"];
        let out = mesh(
            &[&["solve", "--lambda", "2"], &files[..], more].concat(),
            folder.path(),
        );
        let said: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
        let surround: Plane<f64> = read_npy(folder.path().join("H.npy")).unwrap();
        (surround, said["chip"].clone())
    };
    let uniform = || Network::uniform(Sheet::new(2.0).unwrap(), Size::of(&signal)).unwrap();
    let equal = of(&[]);
    assert_eq!(equal.1, serde_json::Value::Null);

    let drawn = |seed: &str| {
        let parts = ["--lateral-mismatch", "1%", "--transverse-mismatch", "10%"];
        of(&[&parts[..], &["--seed", seed]].concat())
    };
    let (chip, said) = drawn("7");
    let mismatch = Mismatch {
        lateral: 0.01,
        transverse: 0.1,
        capacitance: 0.0,
    };
    let own = uniform().with_mismatch(mismatch, 7);
    assert_eq!(chip, own.settle(&signal).unwrap().surround);
    let apart = &chip - &equal.0;
    let rms = (apart.mapv(|v| v * v).sum() / apart.len() as f64).sqrt();
    let told = said["differs_rms"].as_f64().unwrap();
    assert!((told - rms).abs() <= 1e-12 * rms && rms > 0.01, "{told}");
    assert_ne!(drawn("8").0, chip);

    let (bent, said) = of(&["--laterals", "saturating:3"]);
    let law = &said["laterals"];
    let own = uniform().with_laterals(Laterals::Saturating { scale: 3.0 });
    assert_eq!(bent, own.unwrap().settle(&signal).unwrap().surround);
    assert_eq!(law, "saturating:3");

    let solve = ["solve", "--lambda", "2", "--input", "P.npy", "--output"];
    let idle = refused(
        &[&solve[..], &["n.npy", "--seed", "3"]].concat(),
        folder.path(),
    );
    assert!(idle.contains("--seed draws the parts of a chip"), "{idle}");
    for mismatch in ["10", "101%", "-1%"] {
        let more = ["n.npy", "--lateral-mismatch", mismatch];
        let said = refused(&[&solve[..], &more].concat(), folder.path());
        assert!(said.contains("is no mismatch: give 0% to 100%"), "{said}");
    }
    let law = ["n.npy", "--laterals", "saturating:-1"];
    let law = refused(&[&solve[..], &law].concat(), folder.path());
    assert!(law.contains("give saturating:V or opening:V"), "{law}");
}
