//! `fidelity = "auto"` in a study, and `exec --fidelity auto`, from outside: what stands for a point
//! is recorded, holds the tolerance, and is the same on every run.

mod common;

use std::{fmt::Write as _, fs, path::Path};

use serde_json::Value;

const STUDY: &str = r#"
scene = "pattern:noise?width=96&height=80&frames=16&fps=100&speed=40"
kernel = "csdvs-3"
threshold = [12, 24]
within = "5ms"
threshold-equivalent = false
readout = "all"
sum = "free"
effort = 0.01
[[side]]
side = "reference"
format = ["f64", "f32", "q16.16", "q8.8", "bf16"]
memory = "filtered-step"
[[side]]
side = "array"
quantise = "ternary"
domain = ["exact", "q8.8", "silicon"]
schedule = ["plain", "tiled"]
"#;

/// Float sensors alone, on a scene that is long enough for f32 to stand for f64.
fn of_floats() -> String {
    let head = r#"
fidelity = "auto"
tolerance = "2%"
scene = "pattern:noise?width=192&height=160&frames=40&fps=100&speed=40"
kernel = "csdvs-3"
threshold = [12, 24]
within = "5ms"
threshold-equivalent = false
"#;
    let sides = STUDY.split("[[side]]").nth(1).unwrap();
    format!("{head}[[side]]{sides}")
}

fn rows(folder: &Path, study: &str, output: &str) -> Vec<Value> {
    let file = format!("{output}.toml");
    fs::write(folder.join(&file), study).unwrap();
    common::good(folder, &["sweep", &file, "--output", output]);
    let text = fs::read_to_string(folder.join(output).join("results.jsonl")).unwrap();
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

#[test]
fn plain_models_stand_for_points() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let full = rows(here, STUDY, "full");
    let auto = rows(
        here,
        &format!("fidelity = \"auto\"\ntolerance = \"2%\"{STUDY}"),
        "auto",
    );
    assert_eq!(full.len(), auto.len());
    let (mut stood, mut itself) = (0, 0);
    for (full, auto) in full.iter().zip(&auto) {
        assert!(full.get("left_out").is_none());
        for key in [
            "format",
            "domain",
            "schedule",
            "threshold_on",
            "words",
            "state_memory_bytes",
        ] {
            assert_eq!(full[key], auto[key], "{key}");
        }
        let name = format!("{} {} {}", auto["format"], auto["domain"], auto["schedule"]);
        let number = |row: &Value, key: &str| row[key].as_f64().unwrap();
        let off = (number(full, "events") - number(auto, "events")).abs();
        assert!(
            off <= 0.02 * number(full, "events") + 1.0,
            "{name}: {off} events"
        );
        let left_out = auto["left_out"].as_str().unwrap_or_default();
        if left_out.is_empty() || left_out.starts_with("schedule") {
            itself += 1;
            assert_eq!(full["error"], auto["error"], "{name}");
            assert_eq!(full["events"], auto["events"], "{name}");
        } else {
            stood += 1;
            assert!(number(auto, "left_out_limit") <= 0.02, "{name}");
            assert!(
                (number(full, "error") - number(auto, "error")).abs() < 0.02,
                "{name}"
            );
        }
    }
    assert!(stood >= 2 && itself >= 4, "{stood} {itself}");
    // A format of few digits changes much, and is computed as it is.
    let coarse = auto.iter().filter(|row| row["format"] == "bf16");
    assert!(coarse.clone().count() == 2);
    let pilots = || fs::read_dir(here.join("auto/pilots")).unwrap().count();
    // One for each sensor of the float model, and one for each program.
    assert!((2..=4).contains(&pilots()), "{}", pilots());
    let said = common::good(
        here,
        &["sweep", "auto.toml", "--output", "auto", "--verify", "100%"],
    );
    assert!(said.contains("the same bits"), "{said}");
    plain_models_are_told(here);
    for wrong in [
        "fidelity = \"some\"\n",
        "fidelity = \"auto\"\ntolerance = 2\n",
        "tolerance = 0.02\n",
        "victor-purpura = \"5ms\"\n",
    ] {
        fs::write(here.join("wrong.toml"), format!("{wrong}{STUDY}")).unwrap();
        common::refused(
            here,
            &["sweep", "wrong.toml", "--output", "wrong"],
            &[wrong.split(' ').next().unwrap()],
        );
    }
}

/// What the sweep and its report say of plainer models.
fn plain_models_are_told(here: &Path) {
    fs::write(here.join("told.toml"), of_floats()).unwrap();
    let said = common::good(here, &["sweep", "told.toml", "--output", "told"]);
    assert!(said.contains("plainer  models stand for "), "{said}");
    let report = ["report", "told", "--cost", "state_memory_bytes"];
    let text = common::good(here, &[&report[..], &["-o", "front.svg"]].concat());
    let note = "with figures of a plainer model (fidelity = \"auto\")";
    for words in [
        "reference f32 *",
        note,
        "f32: at most ",
        "open, reference f32 may be better",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let picture = fs::read_to_string(here.join("front.svg")).unwrap();
    assert!(picture.contains("of a plainer model"));
    let told = common::json(here, &report);
    let sensors = told["groups"][0]["sensors"].as_array().unwrap();
    let named = |name: &str| sensors.iter().find(|s| s["name"] == name).unwrap();
    let (f32, f64) = (named("reference f32"), named("reference f64"));
    assert_eq!(f32["left_out"]["what"], serde_json::json!(["f32"]));
    assert!(f64["left_out"].is_null());
    // Half the bytes with the figures of f64 are no victory over it.
    assert!(f64["dominated_by"].is_null());
    assert_eq!(f64["undecided_with"], "reference f32");
}

/// A pilot's file is checked as a point's is.
#[test]
fn pilots_are_checked() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let before = rows(here, &of_floats(), "out");
    let sweep = ["sweep", "out.toml", "--output", "out"];
    let pilots: Vec<_> = { fs::read_dir(here.join("out/pilots")).unwrap() }
        .map(|entry| entry.unwrap().path())
        .collect();
    let (first, name) = (&pilots[0], pilots[0].file_name().unwrap().to_str().unwrap());
    let whole = fs::read_to_string(first).unwrap();

    // One digit by accident: it is set aside and measured again.
    let mut fields: std::collections::BTreeMap<String, Value> =
        serde_json::from_str(&whole).unwrap();
    fields.get_mut("figures").unwrap()["f32"] = 0.5.into();
    fs::write(first, serde_json::to_string(&fields).unwrap()).unwrap();
    fs::remove_dir_all(here.join("out/points")).unwrap();
    let said = common::good(here, &sweep);
    let words = [
        "damaged  1 file of pilots, set aside in out/damaged:",
        name,
        "its checksum is not",
    ];
    assert!(words.iter().all(|words| said.contains(words)), "{said}");
    assert!(said.contains("pilot measured in"), "{said}");
    assert_eq!(fs::read_to_string(first).unwrap(), whole);
    assert!(here.join("out/damaged").join(name).exists());

    // With a checksum that is right it is believed, and --verify names it.
    fields.remove("checksum");
    let text = serde_json::to_string(&fields).unwrap();
    let checksum = <sha2::Sha256 as sha2::Digest>::digest(text.as_bytes());
    let checksum = checksum.iter().fold(String::new(), |mut hex, byte| {
        let _ = write!(hex, "{byte:02x}");
        hex
    });
    fields.insert("checksum".to_owned(), checksum.into());
    fs::write(first, serde_json::to_string(&fields).unwrap()).unwrap();
    fs::remove_dir_all(here.join("out/points")).unwrap();
    common::good(here, &sweep);
    let verify = [&sweep[..], &["--verify", "100%"]].concat();
    let said = common::refused(here, &verify, &["1 file of pilots"]);
    let close = said.replace(' ', "");
    assert!(
        close.contains(name) && close.contains("andthoseofpilotsthatarenamed"),
        "{said}"
    );
    // What it says to do helps.
    fs::remove_dir_all(here.join("out/points")).unwrap();
    fs::remove_file(first).unwrap();
    let again = rows(here, &of_floats(), "out");
    common::good(here, &verify);
    let errors = |rows: &[Value]| {
        rows.iter()
            .map(|row| row["error"].clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(errors(&again), errors(&before));
}

const MESHES: &str = r#"
scene = "bundled"           # its light is whole numbers, which f32 and bf16 hold
frames = 10
threshold = 8
within = "100ms"
[[side]]
side = "mesh"
lambda = 2
tau-us = 500
solver = ["ramp", "step"]
format = ["f64", "f32", "bf16", "q8.8"]
"#;

/// Sheets run whole, once, and a pilot's tiles are of their drive: what is computed as it is has the
/// bits of a study without pilots, and what stands for a point holds the tolerance.
#[test]
fn cells_behind_sheets_have_pilots() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let full = rows(here, MESHES, "full");
    let auto = rows(
        here,
        &format!("fidelity = \"auto\"\ntolerance = \"5%\"{MESHES}"),
        "auto",
    );
    let mut stood = 0;
    for (full, auto) in full.iter().zip(&auto) {
        let name = format!("{} {}", auto["solver"], auto["format"]);
        let number = |row: &Value, key: &str| row[key].as_f64().unwrap();
        assert!(number(full, "events") > 1000.0, "{name}");
        if auto["left_out"].as_str().unwrap_or_default().is_empty() {
            for key in [
                "events",
                "error",
                "f1_100ms",
                "threshold_equivalent_percent",
            ] {
                assert_eq!(full[key], auto[key], "{name} {key}");
            }
        } else {
            stood += 1;
            assert!(number(auto, "left_out_limit") <= 0.05, "{name}");
            let off = (number(full, "events") - number(auto, "events")).abs();
            assert!(off <= 0.05 * number(full, "events"), "{name}: {off}");
        }
        // Light of 255 is beyond it: its cells see the sheets of what it holds.
        assert!(auto["format"] != "q8.8" || auto["left_out"].is_null());
    }
    assert!(stood >= 2, "{stood}");
    let said = common::good(
        here,
        &["sweep", "auto.toml", "--output", "auto", "--verify", "100%"],
    );
    assert!(said.contains("the same bits"), "{said}");
}

#[test]
fn an_array_says_what_it_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let program = "//! channels = 1\ninit { get_image(A); neg(C, A); }\nframe { get_image(A); scamp5_in(D, -12); bus(NEWS); bus(B, NEWS, A, C); where(B, D); MOV(R6, FLAG); all(); where(A, C, D); MOV(R5, FLAG); WHERE(R5, R6); neg(C, A); all(); scamp5_scan_events(R5, on, 4000); scamp5_scan_events(R6, off, 4000); }\n";
    fs::write(here.join("dvs.scamp"), program).unwrap();
    let image = "pattern:disc?width=64&height=64&frames=12&fps=100&speed=200&low=20&high=220";
    let run = [
        "exec",
        "dvs.scamp",
        "--image",
        image,
        "--frames",
        "12",
        "--domain",
        "silicon",
    ];
    let full = common::json(here, &run);
    let auto = common::json(
        here,
        &[&run[..], &["--fidelity", "auto", "--tolerance", "5%"]].concat(),
    );
    assert!(full.get("fidelity").is_none());
    assert_eq!(auto["fidelity"]["tolerance"], 0.05);
    let events = |json: &Value| json["events"].as_f64().unwrap();
    assert!((events(&full) - events(&auto)).abs() <= 0.05 * events(&full));
    assert!(auto["fidelity"]["why"].is_string());
    let text = common::good(here, &[&run[..], &["--fidelity", "auto"]].concat());
    assert!(text.contains("plan "), "{text}");
    common::refused(
        here,
        &[&run[..], &["--fidelity", "auto", "--dump", "out"]].concat(),
        &["--fidelity auto keeps events"],
    );
    let bare = ["exec", "convolve/sobel", "--image", image];
    common::refused(
        here,
        &[&bare[..], &["--fidelity", "auto"]].concat(),
        &["convolve/sobel", "is bare statements: it says no events"],
    );
    // Slots that are full lose events for others: then the full model runs.
    let few = program.replace("4000", "3");
    fs::write(here.join("few.scamp"), few).unwrap();
    let run = ["exec", "few.scamp", "--image", image, "--frames", "12"];
    let full = common::json(here, &[&run[..], &["-o", "full.npy"]].concat());
    assert!(full["dropped"]["no_slot"].as_u64().unwrap() > 0, "{full}");
    for tolerance in ["0%", "1%", "100%"] {
        let auto = ["--fidelity", "auto", "--tolerance", tolerance];
        let auto = [&run[..], &auto, &["-o", "auto.npy"]].concat();
        let auto = common::json(here, &auto);
        assert_eq!(auto["fidelity"]["choice"]["format"], "f64");
        let read = |name| fs::read(here.join(name)).unwrap();
        assert!(read("full.npy") == read("auto.npy"), "{tolerance}");
    }
}
