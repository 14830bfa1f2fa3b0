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
        let part = Hash::new(5).with(n).uniform();
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
    assert!(end.trim_end().ends_with("ended 1"), "{end}");
}
