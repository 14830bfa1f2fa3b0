//! The verb `run` from outside: bad input gets one message that names what is wrong and what
//! to do, exit code 2, and leaves no file behind.
#![cfg(feature = "cli")]

mod common;

use std::{fs, path::Path, process::Output};

use common::{amacrine, line};
use ndarray::Array3;
use ndarray_npy::write_npy;
use tempfile::TempDir;

const SCENE: &str = "pattern:disc?width=24&height=20&frames=6&radius=6";

/// Runs `amacrine run` in an empty folder.
fn run(folder: &Path, scene: &str, sensor: &str, more: &[&str]) -> Output {
    let sensor = Path::new(env!("CARGO_MANIFEST_DIR")).join(sensor);
    let mut command = amacrine(folder, &["run", "--scene", scene, "--sensor"]);
    command.arg(sensor).args(more).output().unwrap()
}

/// The message, on one line; nothing else was said, and nothing written.
#[track_caller]
fn refused(scene: &str, sensor: &str, more: &[&str]) -> String {
    let folder = TempDir::new().unwrap();
    let said = run(folder.path(), scene, sensor, more);
    left_alone(&said, folder.path(), 0)
}

#[track_caller]
fn left_alone(said: &Output, folder: &Path, files: usize) -> String {
    let message = line(&said.stderr);
    assert_eq!(said.status.code(), Some(2), "{message}");
    assert!(said.stdout.is_empty());
    assert!(!message.contains("panicked"), "{message}");
    let begun = message.matches('×').count() + message.matches("error:").count();
    assert_eq!(begun, 1, "one message: {message}");
    assert_eq!(folder.read_dir().unwrap().count(), files, "files were left");
    message
}

#[track_caller]
fn says(message: &str, words: &[&str]) {
    for word in words {
        assert!(message.contains(word), "no {word:?} in: {message}");
    }
}

const SENSOR: &str = "sensors/csdvs.toml";

#[test]
fn a_good_run_leaves_what_was_asked_for() {
    let folder = TempDir::new().unwrap();
    let more = [
        "--events", "e.npy", "--counts", "c.npy", "--voxels", "v.npy", "--json",
    ];
    let said = run(folder.path(), SCENE, SENSOR, &more);
    assert!(
        said.status.success(),
        "{}",
        String::from_utf8_lossy(&said.stderr)
    );
    assert_eq!(folder.path().read_dir().unwrap().count(), 3);
    let summary: serde_json::Value = serde_json::from_slice(&said.stdout).unwrap();
    assert!(summary["events"].as_u64().unwrap() > 0);
}

#[test]
fn scenes() {
    says(
        &refused("nowhere.y4m", SENSOR, &[]),
        &["nowhere.y4m", "help"],
    );
    says(&refused("pattern:moon", SENSOR, &[]), &["moon", "known"]);
    says(
        &refused("pattern:bar?colour=red", SENSOR, &[]),
        &["colour", "known"],
    );
    for fps in ["0", "-5", "nan", "inf"] {
        says(
            &refused(SCENE, SENSOR, &[&format!("--fps={fps}")]),
            &["frames per second", "--fps 240"],
        );
    }
    says(
        &refused(SCENE, SENSOR, &["--fps", "fast"]),
        &["fast", "--fps"],
    );
    says(
        &refused(SCENE, SENSOR, &["--upsample", "0"]),
        &["'0' for '--upsample", "above 0"],
    );
}

#[test]
fn light_that_the_response_is_not_defined_for() {
    let folder = TempDir::new().unwrap();
    let mut light = Array3::<f32>::ones((3, 5, 4));
    light[[1, 2, 3]] = -1.0;
    write_npy(folder.path().join("dark.npy"), &light).unwrap();
    let more = [
        "--events", "e.npy", "--counts", "c.npy", "--voxels", "v.npy",
    ];
    let said = run(folder.path(), "dark.npy", SENSOR, &more);
    let message = left_alone(&said, folder.path(), 1);
    says(
        &message,
        &["dark.npy", "frame 1", "x = 3, y = 2", "-1", "identity"],
    );
}

#[test]
fn sensors() {
    says(
        &refused(SCENE, "sensors/nothing.toml", &[]),
        &["nothing.toml", "sensors/"],
    );
    says(&refused(SCENE, "sensors", &[]), &["sensors", "directory"]);
    let message = refused(SCENE, "tests/bad/sensor/negative_threshold.toml", &[]);
    says(
        &message,
        &[
            "negative_threshold.toml:6:31",
            "`threshold.off` is -0.2",
            "positive magnitude",
        ],
    );
    says(
        &refused(SCENE, "tests/bad/sensor/truncated.npy", &[]),
        &["truncated.npy", "UTF-8"],
    );
}

#[test]
fn options() {
    says(
        &refused(SCENE, SENSOR, &["--format", "q99.1"]),
        &["q99.1", "8, 16 or 32"],
    );
    for fps in ["0", "-3", "nan", "1e300", "1e-400"] {
        says(
            &refused(SCENE, SENSOR, &["--fps", fps]),
            &["frames per second is no rate", "at most 1000000000"],
        );
    }
    says(&refused(SCENE, SENSOR, &["--seed", "-1"]), &["--seed"]);
    says(
        &refused(SCENE, SENSOR, &["--upsample", "-0.1"]),
        &["'-0.1' for '--upsample", "above 0"],
    );
    says(
        &refused(SCENE, SENSOR, &["--upsample", "1e-9"]),
        &["larger contrast per step (`--upsample`"],
    );
    says(
        &refused(SCENE, SENSOR, &["--max-events", "10"]),
        &["--max-events 10 needs --events", "add --events FILE"],
    );
    says(
        &refused(SCENE, SENSOR, &["--when-full", "drop"]),
        &["--when-full needs --events", "add --events FILE"],
    );
    says(
        &refused(SCENE, SENSOR, &["--fidelity", "full", "--tolerance", "5%"]),
        &[
            "--tolerance 5.000 % with --fidelity full",
            "--fidelity auto",
        ],
    );
    says(
        &refused(SCENE, SENSOR, &["--upsample", "0"]),
        &["for '--upsample", "above 0"],
    );
    says(
        &refused(SCENE, SENSOR, &["--when-full", "wait"]),
        &["wait", "stop", "drop"],
    );
    says(&refused(SCENE, SENSOR, &["--seed=-1"]), &["--seed"]);
    says(&refused(SCENE, SENSOR, &["--speed", "fast"]), &["--speed"]);
}

#[test]
fn outputs() {
    for (option, name) in [
        ("--events", "e.csv"),
        ("--counts", "c.npy"),
        ("--voxels", "v.npy"),
    ] {
        let sensor = Path::new(env!("CARGO_MANIFEST_DIR")).join(SENSOR);
        let path = format!("{}/{name}", sensor.display());
        let message = refused(SCENE, SENSOR, &[option, &path]);
        says(&message, &["cannot write", name, "Not a directory"]);
    }
    says(
        &refused(SCENE, SENSOR, &["--events", "e.xyz"]),
        &["xyz", "csv"],
    );
    says(&refused(SCENE, SENSOR, &["--events", "e"]), &["csv"]);
    says(
        &refused(SCENE, SENSOR, &["--events", "e.aedat"]),
        &[
            "such as `.aedat2`",
            "`amacrine convert` also takes --format",
        ],
    );
    says(
        &refused(SCENE, SENSOR, &["--counts", "c.csv"]),
        &["c.csv", ".npy"],
    );
    says(
        &refused(SCENE, SENSOR, &["--voxels", "v"]),
        &["v has no ending", ".npy"],
    );
    let twice = ["--counts", "a.npy", "--voxels", "a.npy"];
    says(
        &refused(SCENE, SENSOR, &twice),
        &["a.npy is asked for twice"],
    );
    let full = [
        "--max-events",
        "3",
        "--events",
        "e.npy",
        "--counts",
        "c.npy",
    ];
    says(
        &refused(SCENE, SENSOR, &full),
        &["more than 3 events", "--max-events", "--when-full drop"],
    );
}

#[test]
fn what_was_there_before_is_left_as_it_was() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("e.npy"), "old").unwrap();
    let more = [
        "--max-events",
        "3",
        "--events",
        "e.npy",
        "--voxels",
        "v.npy",
    ];
    let said = run(folder.path(), SCENE, SENSOR, &more);
    left_alone(&said, folder.path(), 1);
    assert_eq!(fs::read(folder.path().join("e.npy")).unwrap(), b"old");
}
