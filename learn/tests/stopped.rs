//! The program itself, stopped from outside: killed, and without room on the disk.

use std::{
    fs,
    path::Path,
    process::{Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use amacrine::rng::Hash;

const PROGRAM: &str = env!("CARGO_BIN_EXE_amacrine-learn");

const TASK: &str = "goal = \"interpolation\"\narms = [\"none\", \"rgc\", \"mesh\"]\nsteps = 20\nbatch = 2\n\
    crop = 16\ntargets = [0.05]\nseeds = [1]\ncheckpoint = 3\n[network]\nwidths = [4, 6]\n\
    convolutions = 1\n[test]\nclips = 4\ncrop = 24\n[scenes]\npan = 1\n";

fn command(task: &Path, run: &Path) -> Command {
    let mut command = Command::new(PROGRAM);
    command.arg(task).arg("-o").arg(run).arg("--resume");
    command.args(["--threads", "1"]);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    command
}

/// Everything in a folder, by its place.
fn files(folder: &Path, at: &str, all: &mut Vec<(String, Vec<u8>)>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = format!("{at}/{}", path.file_name().unwrap().to_string_lossy());
        if path.is_dir() {
            files(&path, &name, all);
        } else {
            all.push((name, fs::read(path).unwrap()));
        }
    }
    all.sort();
}

fn all(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    files(folder, "", &mut found);
    found
}

/// SIGKILL at ten moments, each somewhere in what a run that is left alone takes.
#[test]
#[cfg(unix)]
fn ten_kills_end_as_none() {
    let folder = tempfile::tempdir().unwrap();
    let task = folder.path().join("task.toml");
    fs::write(&task, TASK).unwrap();
    let straight = folder.path().join("straight");
    let start = Instant::now();
    assert!(command(&task, &straight).status().unwrap().success());
    let whole = start.elapsed();
    let killed = folder.path().join("killed");
    let mut caught = 0;
    for n in 0..10 {
        let mut child = command(&task, &killed).spawn().unwrap();
        // Earlier at first: one that ends by itself leaves the others nothing to do.
        let part = Hash::new(5).with(n).uniform() * (n + 1) as f64 / 10.0;
        thread::sleep(whole.mul_f64(0.7 * part).max(Duration::from_millis(2)));
        child.kill().unwrap();
        // What ended by itself was not caught.
        caught += u32::from(child.wait().unwrap().code().is_none());
    }
    assert!(caught > 0, "nothing was killed");
    assert!(command(&task, &killed).status().unwrap().success());
    let (a, b) = (all(&straight), all(&killed));
    let names = |files: &[(String, Vec<u8>)]| files.iter().map(|f| f.0.clone()).collect::<Vec<_>>();
    assert_eq!(names(&a), names(&b));
    for ((name, a), (_, b)) in a.iter().zip(&b) {
        assert!(a == b, "{name} differs");
    }
}

fn told(output: &std::process::Output) -> String {
    String::from_utf8_lossy(&output.stderr).replace(['\n', '│', ' '], "")
}

/// A file that may not grow: the sentence names the file, nothing half written stays, and the run goes
/// on once there is room.
#[test]
#[cfg(target_os = "linux")]
fn a_checkpoint_without_room_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let task = folder.path().join("task.toml");
    fs::write(&task, TASK).unwrap();
    let run = folder.path().join("run");
    let script = format!(
        "trap '' XFSZ; ulimit -f 2; exec {PROGRAM} {} -o {} --threads 1",
        task.display(),
        run.display()
    );
    let output = Command::new("sh").arg("-c").arg(script).output().unwrap();
    assert!(!output.status.success());
    let text = told(&output);
    assert!(
        text.contains("checkpoint") && text.contains("toolarge"),
        "{text}"
    );
    assert!(!text.contains("panicked"), "{text}");
    assert!(
        all(&run).iter().all(|(name, _)| !name.contains(".tmp")),
        "{:?}",
        all(&run)
    );
    assert!(command(&task, &run).status().unwrap().success());
}

/// Arms that are quick, and a task file of them.
fn small(folder: &Path, from: &str, to: &str) -> std::path::PathBuf {
    let task = folder.join("task.toml");
    let text = TASK.replace("arms = [\"none\", \"rgc\", \"mesh\"]", "arms = [\"dvs\"]");
    fs::write(&task, text.replace(from, to)).unwrap();
    task
}

/// A reader that goes ends the program quietly; a full disk behind standard output is told.
#[test]
#[cfg(target_os = "linux")]
fn a_reader_that_has_gone_is_no_error() {
    let folder = tempfile::tempdir().unwrap();
    let task = small(folder.path(), "", "");
    let run = folder.path().join("run");
    assert!(command(&task, &run).status().unwrap().success());
    let other = folder.path().join("other");
    let train = [task.as_os_str(), "-o".as_ref(), other.as_os_str()];
    let report = ["report".as_ref(), run.as_os_str()];
    for arguments in [&train[..], &report[..]] {
        let program = || {
            let mut program = Command::new(PROGRAM);
            program.args(arguments).stderr(Stdio::piped());
            program
        };
        let mut child = program().stdout(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", told(&output));
        assert_eq!(told(&output), "");
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let output = program().stdout(full).output().unwrap();
        assert_eq!(output.status.code(), Some(1));
        let text = told(&output);
        assert!(text.contains("cannotwritetostandardoutput"), "{text}");
        assert!(!text.contains("panicked"), "{text}");
    }
}

/// A target that an arm cannot reach stops neither the others nor, told first, all of them.
#[test]
fn what_cannot_be_trained_leaves_the_rest_whatever_the_order() {
    let folder = tempfile::tempdir().unwrap();
    // Half of it stands still, and with such a dead time no other cell makes more than one event a pair.
    let film = ndarray::Array3::from_shape_fn((60, 32, 32), |(t, y, x)| {
        let place = Hash::new(1).with(y as u64).with(x as u64);
        let moving = place.with(if x < 16 { t as u64 } else { 0 });
        (200.0 * moving.uniform()) as u8
    });
    ndarray_npy::write_npy(folder.path().join("film.npy"), &film).unwrap();
    for (targets, name) in [("[1.0, 0.05]", "first"), ("[0.05, 1.0]", "last")] {
        let task = small(folder.path(), "[0.05]", targets);
        let text = fs::read_to_string(&task).unwrap();
        let text = text.replace("pan = 1", "video = \"film.npy\"");
        let sensor = "[sensor]\nrefractory-us = 4100\nlight-noise = 0\n";
        fs::write(&task, format!("{text}{sensor}")).unwrap();
        let run = folder.path().join(name);
        let output = Command::new(PROGRAM)
            .args([task.as_os_str(), "-o".as_ref(), run.as_os_str()])
            .output()
            .unwrap();
        let errors = told(&output);
        assert_eq!(output.status.code(), Some(2), "{errors}");
        assert!(errors.contains("1of2armscouldnotbetrained"), "{errors}");
        assert!(errors.contains("task.toml:6:`targets`"), "{errors}");
        assert!(
            run.join("arms/dvs-0.05-1/finished.json").exists(),
            "{errors}"
        );
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(said.contains("dvs-0.05-1: done"), "{said}");
    }
}

/// What is done is not told of as still to be trained, and what a price costs is told.
#[test]
fn a_dry_run_tells_what_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let task = small(folder.path(), "", "");
    let run = folder.path().join("run");
    assert!(command(&task, &run).status().unwrap().success());
    let dry = |more: &[&str]| {
        let mut program = Command::new(PROGRAM);
        program.args([task.as_os_str(), "-o".as_ref(), run.as_os_str()]);
        let output = program.args(more).arg("--dry-run").output().unwrap();
        assert!(output.status.success(), "{}", told(&output));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let said = dry(&["--resume"]);
    assert!(
        said.contains(": 0 arms of 20 steps") && said.contains("; 1 more are done"),
        "{said}"
    );
    assert!(!said.contains("ms a step"), "{said}");
    let text = fs::read_to_string(&task).unwrap();
    let text = text.replace("\"dvs\"", "\"ternary\"");
    fs::write(&task, format!("{text}[price]\nwords = 1e-6\n")).unwrap();
    let said = dry(&[]);
    assert!(said.contains("for [price] at most"), "{said}");
}

/// The same on a file system that is full. It is mounted, which asks for rights of its own.
#[test]
#[ignore = "mounts a file system: needs root"]
#[cfg(target_os = "linux")]
fn a_full_disk_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let task = folder.path().join("task.toml");
    fs::write(&task, TASK).unwrap();
    let run = folder.path().join("disk");
    fs::create_dir(&run).unwrap();
    let script = format!(
        "mount -t tmpfs -o size=16k none {run} && {PROGRAM} {task} -o {run}/run --threads 1; \
         echo \"ended $?\"; find {run}/run -name '*.tmp'",
        run = run.display(),
        task = task.display(),
    );
    let output = Command::new("unshare")
        .args(["-m", "sh", "-c", &script])
        .output()
        .unwrap();
    let text = told(&output);
    assert!(
        text.contains("checkpoint") && text.contains("Nospaceleft"),
        "{text}"
    );
    let end = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(end.trim_end().ends_with("ended 2"), "{end}");
}
