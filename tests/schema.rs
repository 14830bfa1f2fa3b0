//! JSON Schema of every kind of file, against a validator that knows nothing of this program:
//! every shipped file is valid, broken ones are not, and what the readers take the schemas take.

use std::{
    fs,
    path::{Path, PathBuf},
};

use amacrine::{
    config::schema,
    event::readout::settings,
    isa,
    kernel::{self, Kernel},
    program,
    reference::{self, Description},
    study::sweep::{self, Study},
};
use jsonschema::Validator;
use serde_json::Value as Json;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every file below a folder that ends like this.
fn files(folder: &str, ending: &str) -> Vec<PathBuf> {
    let (mut found, mut left) = (Vec::new(), vec![root().join(folder)]);
    while let Some(path) = left.pop() {
        if path.is_dir() {
            left.extend(fs::read_dir(&path).unwrap().map(|e| e.unwrap().path()));
        } else if path.to_string_lossy().ends_with(ending) {
            found.push(path);
        }
    }
    assert!(!found.is_empty(), "no {ending} in {folder}");
    found
}

fn validator(schema: &Json) -> Validator {
    assert!(jsonschema::meta::is_valid(schema), "no schema: {schema:#}");
    jsonschema::validator_for(schema).unwrap()
}

/// A text of TOML as JSON.
fn json(text: &str) -> Json {
    serde_json::to_value(text.parse::<toml::Table>().unwrap()).unwrap()
}

fn all_valid(schema: &Json, texts: impl IntoIterator<Item = (PathBuf, String)>) {
    let validator = validator(schema);
    for (path, text) in texts {
        let wrong: Vec<String> = validator
            .iter_errors(&json(&text))
            .map(|e| format!("{} at {}", e, e.instance_path()))
            .collect();
        assert!(wrong.is_empty(), "{}: {wrong:#?}", path.display());
    }
}

fn texts(folder: &str, ending: &str) -> Vec<(PathBuf, String)> {
    let read = |path: PathBuf| (path.clone(), fs::read_to_string(path).unwrap());
    files(folder, ending).into_iter().map(read).collect()
}

/// The comment lines of a program that begin with a mark.
fn comments(text: &str, mark: &str) -> String {
    let lines = text.lines().filter_map(|line| line.strip_prefix(mark));
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn every_shipped_file_is_valid() {
    let sensor = schema::file(&reference::keys::FILE);
    all_valid(&sensor, texts("sensors", ".toml"));
    all_valid(&schema::file(&kernel::FILE), texts("kernels", ".toml"));
    all_valid(&schema::file(&settings::FILE), texts("readouts", ".toml"));
    all_valid(&sweep::schema::json_schema(), texts("studies", ".toml"));
    let chip = isa::keys::json_schema();
    all_valid(&chip, texts("isa", "device.toml"));
    all_valid(
        &chip["$defs"]["primitives"],
        texts("isa", "primitives.toml"),
    );
    let program = program::json_schema();
    let parts = |mark: &'static str| {
        let programs = texts("programs", ".scamp").into_iter();
        programs.map(move |(path, text)| (path, comments(&text, mark)))
    };
    all_valid(&program, parts("//!"));
    all_valid(&program["$defs"]["expectation"], parts("//="));
}

/// Bad sensors that are wrong in what keys say together, in a file that they name, or in a
/// number of JSON that is none.
const BEYOND: [&str; 23] = [
    "authors_refractory_that_snaps",
    "damaged_array",
    "damaged_kernel_file",
    "dead_time_for_pixel_step",
    "deep_array",
    "empty_kernel",
    "even_kernel",
    "huge_gain",
    "kernels_without_pattern",
    "leak_of_pixels",
    "leak_under_the_authors_rule",
    "log_temporal_of_pixels",
    "memory_kernel_without_pixel_step",
    "pattern_without_four_kernels",
    "pattern_without_four_thresholds",
    "pixel_polarity_that_steps",
    "pixel_step_that_runs_away",
    "pixel_step_with_its_sign_turned",
    "pixel_step_without_memory_kernel",
    "ragged_kernel",
    "shared_filtered_memory",
    "thresholds_without_pattern",
    "unknown_kernel",
];

#[test]
fn bad_sensors_are_not_valid() {
    let validator = validator(&schema::file(&reference::keys::FILE));
    for (path, text) in texts("tests/bad/sensor", ".toml") {
        let name = path.file_stem().unwrap().to_str().unwrap();
        let Ok(table) = text.parse::<toml::Table>() else {
            continue;
        };
        let valid = validator.is_valid(&serde_json::to_value(table).unwrap());
        assert_eq!(valid, BEYOND.contains(&name), "{name}");
    }
}

/// Every value of a document, set to something else: the document, and where.
fn changed(whole: &toml::Value) -> Vec<toml::Value> {
    let others = [
        toml::Value::from(-7),
        toml::Value::from(0),
        toml::Value::from(1e9),
        toml::Value::from(0.5),
        toml::Value::from(true),
        toml::Value::from(""),
        toml::Value::from("word"),
        toml::Value::Array(Vec::new()),
        toml::Value::Table(toml::Table::new()),
    ];
    let mut all = others.to_vec();
    match whole {
        toml::Value::Table(table) => {
            for (key, value) in table {
                let mut less = table.clone();
                less.remove(key);
                all.push(less.into());
                for other in changed(value) {
                    let mut with = table.clone();
                    with.insert(key.clone(), other);
                    all.push(with.into());
                }
            }
            let mut more = table.clone();
            more.insert("no-key".to_owned(), 1.into());
            all.push(more.into());
        }
        toml::Value::Array(list) => {
            for (at, value) in list.iter().enumerate().take(2) {
                for other in changed(value) {
                    let mut with = list.clone();
                    with[at] = other;
                    all.push(with.into());
                }
            }
        }
        _ => {}
    }
    all
}

/// What the reader takes, the schema takes: whatever is done to one value of a file.
fn holds(schema: &Json, text: &str, reads: impl Fn(&str) -> bool) {
    let validator = validator(schema);
    let whole = toml::Value::Table(text.parse().unwrap());
    let (mut read, mut refused) = (0, 0);
    for other in changed(&whole) {
        let toml::Value::Table(table) = other else {
            continue;
        };
        let text = toml::to_string(&table).unwrap();
        let valid = validator.is_valid(&serde_json::to_value(&table).unwrap());
        if reads(&text) {
            read += 1;
            assert!(valid, "read, and not valid:\n{text}");
        } else {
            refused += usize::from(!valid);
        }
    }
    assert!(read > 0 && refused > 20, "{read} read, {refused} refused");
}

#[test]
fn what_is_read_is_valid() {
    let sensor = schema::file(&reference::keys::FILE);
    let reads = |text: &str| {
        let none = |_: &str| Err(std::io::Error::other("none"));
        Description::parse("s.toml", text, &none).is_ok()
    };
    for name in ["dvs-noisy", "mosaic", "csdvs-mesh", "surrounds"] {
        let text = fs::read_to_string(root().join(format!("sensors/{name}.toml"))).unwrap();
        holds(&sensor, &text, reads);
    }
    let kernels = schema::file(&kernel::FILE);
    for name in ["rgc-5x5", "dog", "csdvs-5"] {
        let text = fs::read_to_string(root().join(format!("kernels/{name}.toml"))).unwrap();
        holds(&kernels, &text, |text| Kernel::from_toml("k", text).is_ok());
    }
    let readout = schema::file(&settings::FILE);
    for name in ["scan", "arbiter", "frame"] {
        let text = fs::read_to_string(root().join(format!("readouts/{name}.toml"))).unwrap();
        holds(&readout, &text, |text| {
            settings::Description::parse("r.toml", text).is_ok()
        });
    }
    let study = sweep::schema::json_schema();
    let text = fs::read_to_string(root().join("studies/thousand.toml")).unwrap();
    let text = format!("{text}\nnoise = {{ shot-hz = 5 }}\nresponse = {{ linear = 255 }}\n");
    holds(&study, &text, |text| Study::parse("s.toml", text).is_ok());
}

#[cfg(feature = "cli")]
#[test]
fn the_verb_prints_the_schema_that_the_library_makes() {
    let folder = tempfile::tempdir().unwrap();
    for (kind, schema) in [
        ("sensor", schema::file(&reference::keys::FILE)),
        ("kernel", schema::file(&kernel::FILE)),
        ("study", sweep::schema::json_schema()),
        ("readout", schema::file(&settings::FILE)),
        ("program", program::json_schema()),
        ("chip", isa::keys::json_schema()),
    ] {
        let amacrine = || {
            let mut command = assert_cmd::Command::cargo_bin("amacrine").unwrap();
            command.current_dir(folder.path()).args(["schema", kind]);
            command
        };
        let printed = amacrine().assert().success().get_output().stdout.clone();
        assert_eq!(serde_json::from_slice::<Json>(&printed).unwrap(), schema);
        amacrine().args(["-o", "it.json"]).assert().success();
        assert_eq!(fs::read(folder.path().join("it.json")).unwrap(), printed);
    }
}

/// Names in studies: the schema takes what the reader takes, and refuses what it refuses.
#[test]
fn names_of_formats_are_those_that_are_read() {
    let validator = validator(&sweep::schema::json_schema());
    let mut read = 0;
    let mut agrees = |side: &str, kernel: &str, line: &str| {
        let text =
            format!("[[side]]\nside = \"{side}\"\nscene = \"a\"\n{kernel}threshold = 4\n{line}\n");
        let reads = Study::parse("s.toml", &text);
        assert_eq!(
            validator.is_valid(&json(&text)),
            reads.is_ok(),
            "{line}: {:?}",
            reads.err()
        );
        read += u64::from(reads.is_ok());
    };
    let kernel = "kernel = \"dvs\"\n";
    for integer in 0..=34 {
        for fraction in 0..=34 {
            for wrap in ["", "-wrap", "-saturate"] {
                let line = format!("format = \"q{integer}.{fraction}{wrap}\"");
                agrees("reference", kernel, &line);
            }
        }
    }
    for name in [
        "f64", "exact", "f32", "f16", "bf16", "F32", "f8", "", "q8.8x", "xq8.8", "q08.08",
        "silicon",
    ] {
        agrees("reference", kernel, &format!("format = \"{name}\""));
        agrees("array", kernel, &format!("domain = \"{name}\""));
    }
    for name in [
        "none",
        "exact",
        "binary",
        "ternary",
        "ternary-0.7",
        "ternary-split",
        "int-5",
        "po2-2",
        "csd-3",
        "q2.6",
        "x",
        "int",
        "ternary5",
        "analogue",
    ] {
        agrees("array", kernel, &format!("quantise = \"{name}\""));
    }
    for name in ["analogue", "bits:1", "bits:8", "bits:9", "bits:0", "shared"] {
        agrees("array", kernel, &format!("memory = \"{name}\""));
    }
    assert!(read > 120, "{read}");
}
