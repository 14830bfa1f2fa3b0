//! `amacrine-learn new` and `schema`: a task to start from, each of whose comments is a key, and the
//! keys as JSON Schema. Against: the reader of tasks, and a validator that knows nothing of them.

use std::{fs, path::Path, process::Command};

use amacrine_learn::task::Task;

fn amacrine_learn(folder: &Path, arguments: &[&str]) -> (bool, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_amacrine-learn"));
    let output = command
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap();
    let [said, errors] =
        [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    (output.status.success(), said, errors)
}

/// The text with the comments that are keys or tables no comments any more, but for these keys.
fn all_said(text: &str, but: &[&str]) -> String {
    let said = |line: &str| -> String {
        let own = line.strip_prefix("# ").unwrap_or(line);
        let key = own.split(' ').next().unwrap_or_default();
        let is_key = own.starts_with('[') || own[key.len()..].starts_with(" = ");
        let own = if is_key && !but.contains(&key) {
            own
        } else {
            line
        };
        format!("{own}\n")
    };
    text.lines().map(said).collect()
}

#[test]
fn a_task_to_start_from_has_every_key() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let (is_good, said, errors) = amacrine_learn(folder, &["new", "mine"]);
    assert!(is_good && said.contains("mine.toml"), "{errors}");
    let path = folder.join("mine.toml");
    let begun = Task::open(&path).unwrap();
    assert_eq!(begun.name, "mine");
    // What is in comments is what holds without it; photographs and a video exclude each other.
    let text = fs::read_to_string(&path).unwrap();
    let all = all_said(&text, &["photographs", "video", "weight", "[sparsity]"]);
    assert_ne!(all, text);
    let all = Task::parse("mine.toml", &all).unwrap_or_else(|faults| panic!("{faults}\n{all}"));
    let same = |task: &Task| {
        let (network, scenes) = ((&task.widths, task.convolutions), &task.scenes);
        format!(
            "{network:?} {scenes:?} {:?} {:?} {:?}",
            task.sensor, task.rates, task.loss
        )
    };
    assert_eq!(same(&all), same(&begun));
    assert_eq!(
        (all.test, all.batch, all.checkpoint),
        (begun.test, begun.batch, begun.checkpoint)
    );
    let schema = fs::read_to_string(folder.join("task.schema.json")).unwrap();
    for key in ["sparsity", "retrain", "occluded", "survival"] {
        assert!(schema.contains(key) && text.contains(key), "{key}");
    }
    assert_eq!(amacrine_learn(folder, &["schema"]).1, schema);
    // Nothing is written over.
    let (is_good, _, errors) = amacrine_learn(folder, &["new", "mine.toml"]);
    assert!(!is_good && errors.contains("is there already"), "{errors}");
}

/// What the usage says can be done.
#[test]
fn a_verb_takes_no_task() {
    let here = Path::new(".");
    let (is_good, said, _) = amacrine_learn(here, &["--help"]);
    let usage = "Usage: amacrine-learn [OPTIONS] --output <RUN> <TASK.toml>\n       amacrine-learn [OPTIONS] <COMMAND>\n";
    assert!(is_good && said.contains(usage), "{said}");
    assert!(amacrine_learn(here, &["--threads", "1", "schema"]).0);
    let (is_good, _, errors) = amacrine_learn(here, &["own.toml", "schema"]);
    assert!(!is_good && errors.contains(usage), "{errors}");
}

#[test]
fn every_shipped_task_is_valid() {
    let schema = amacrine_learn(Path::new("."), &["schema"]).1;
    let schema = serde_json::from_str(&schema).unwrap();
    let validator = jsonschema::validator_for(&schema).unwrap();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tasks");
    let mut count = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let text = fs::read_to_string(&path).unwrap();
        let json = serde_json::to_value(text.parse::<toml::Table>().unwrap()).unwrap();
        let wrong: Vec<String> = validator
            .iter_errors(&json)
            .map(|e| e.to_string())
            .collect();
        assert!(wrong.is_empty(), "{}: {wrong:?}", path.display());
        Task::open(&path).unwrap_or_else(|error| panic!("{error}"));
        count += 1;
    }
    assert!(count >= 4);
    let broken = serde_json::json!({ "goal": "interpolation", "loss": "l2" });
    assert!(!validator.is_valid(&broken));
}
