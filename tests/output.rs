//! The door of everything that is written, from outside, for every verb: files are replaced
//! whole, links are followed, devices are written through, inputs are never outputs, names say
//! what is in them, signals leave nothing, and what is printed is printed or the exit code says
//! so.
#![cfg(all(feature = "cli", unix))]

mod common;
mod verbs;

use std::{
    ffi::OsStr,
    fs::{self, File},
    io::Read,
    os::unix::{
        ffi::OsStrExt,
        fs::{FileTypeExt, MetadataExt, PermissionsExt, symlink},
        process::ExitStatusExt,
    },
    path::{Path, PathBuf},
    process::{Child, Command, Output, Stdio},
    thread,
    time::{Duration, Instant},
};

use common::line as text;
use tempfile::TempDir;
use verbs::{CASES, Case, files};

struct Bench {
    folder: TempDir,
}

impl Bench {
    fn new() -> Self {
        let folder = TempDir::new().unwrap();
        verbs::inputs(folder.path());
        Self { folder }
    }

    fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// An empty folder to work in.
    fn work(&self) -> PathBuf {
        let work = self.at("work");
        let _ = fs::remove_dir_all(&work);
        fs::create_dir(&work).unwrap();
        work
    }
}

/// Cases that write files of their own, not folders.
fn plain() -> impl Iterator<Item = &'static Case> {
    let folders = ["demo", "design", "sweep", "merge"];
    let all = CASES
        .iter()
        .filter(move |case| !folders.contains(&case.verb()));
    all.filter(|case| case.writes().count() > 0 && !case.line.contains("--dump"))
}

/// The case with another name for one of its outputs.
fn renamed(case: &Case, output: &str, name: &str) -> Option<Vec<String>> {
    let words = case.line.split_whitespace();
    let mut words: Vec<String> = words.map(str::to_owned).collect();
    let word = words.iter_mut().find(|word| *word == output)?;
    name.clone_into(word);
    Some(words)
}

fn ran<S: AsRef<OsStr>>(folder: &Path, words: &[S]) -> Output {
    verbs::amacrine(folder).args(words).output().unwrap()
}

#[track_caller]
fn good(said: &Output, what: &str) {
    assert!(said.status.success(), "{what}: {}", text(&said.stderr));
}

/// Exit code 2, one message that has these words, no table.
#[track_caller]
fn refused(said: &Output, what: &str, words: &[&str]) {
    let message = text(&said.stderr);
    assert_eq!(said.status.code(), Some(2), "{what}: {message}");
    assert!(said.stdout.is_empty(), "{what}");
    assert!(!message.contains("panicked"), "{what}: {message}");
    let usage = usize::from(message.starts_with("error:"));
    let messages = message.matches('×').count() + usage;
    assert_eq!(messages, 1, "{what}: {message}");
    for word in words {
        assert!(message.contains(word), "{what}: no {word:?} in: {message}");
    }
}

/// What each output of a case is when nothing is in the way.
fn wanted(bench: &Bench, case: &Case) -> Vec<(&'static str, Vec<u8>)> {
    let work = bench.work();
    good(&case.command(&work).output().unwrap(), case.line);
    let names = case.writes();
    names
        .map(|name| (name, fs::read(work.join(name)).unwrap()))
        .collect()
}

#[test]
fn devices_and_pipes_are_written_through() {
    let bench = Bench::new();
    for case in plain() {
        let wanted = wanted(&bench, case);
        let work = bench.work();
        let mut readers = Vec::new();
        for (name, bytes) in &wanted {
            let path = work.join(name);
            let made = Command::new("mkfifo").arg(&path).status();
            assert!(made.unwrap().success());
            let reader = thread::spawn(move || {
                let mut read = Vec::new();
                File::open(path).unwrap().read_to_end(&mut read).unwrap();
                read
            });
            readers.push((*name, bytes, reader));
        }
        good(&case.command(&work).output().unwrap(), case.line);
        for (name, bytes, reader) in readers {
            assert!(reader.join().unwrap() == *bytes, "{}: {name}", case.line);
            let kind = fs::symlink_metadata(work.join(name)).unwrap().file_type();
            assert!(kind.is_fifo(), "{}: {name} is no pipe any more", case.line);
        }
        let work = bench.work();
        for (name, _) in &wanted {
            symlink("/dev/null", work.join(name)).unwrap();
        }
        good(&case.command(&work).output().unwrap(), case.line);
        let null = fs::metadata("/dev/null").unwrap().file_type();
        assert!(
            null.is_char_device(),
            "{} replaced the null device",
            case.line
        );
        assert_eq!(files(&work).len(), wanted.len(), "{}", case.line);
        for (name, _) in &wanted {
            assert!(fs::symlink_metadata(work.join(name)).unwrap().is_symlink());
        }
    }
}

#[test]
fn a_full_device_is_an_error() {
    let bench = Bench::new();
    for case in plain() {
        for name in case.writes() {
            let work = bench.work();
            symlink("/dev/full", work.join(name)).unwrap();
            let said = case.command(&work).output().unwrap();
            refused(&said, case.line, &["No space left", name]);
            assert!(
                fs::metadata("/dev/full")
                    .unwrap()
                    .file_type()
                    .is_char_device()
            );
        }
    }
}

#[test]
fn links_stay_and_their_targets_are_replaced() {
    let bench = Bench::new();
    for case in plain() {
        let wanted = wanted(&bench, case);
        let work = bench.work();
        fs::create_dir(work.join("far")).unwrap();
        for (i, (name, _)) in wanted.iter().enumerate() {
            // Every other one leads to nothing yet.
            if i % 2 == 0 {
                fs::write(work.join(format!("far/{i}")), "old").unwrap();
            }
            symlink(format!("far/{i}"), work.join(name)).unwrap();
        }
        good(&case.command(&work).output().unwrap(), case.line);
        for (i, (name, bytes)) in wanted.iter().enumerate() {
            let link = fs::read_link(work.join(name)).unwrap();
            assert_eq!(link, Path::new(&format!("far/{i}")), "{}", case.line);
            assert!(
                fs::read(work.join(link)).unwrap() == *bytes,
                "{}",
                case.line
            );
        }
        assert_eq!(files(&work).len(), 2 * wanted.len(), "{}", case.line);
        // In a circle.
        let work = bench.work();
        let name = wanted[0].0;
        symlink(name, work.join(name)).unwrap();
        let said = case.command(&work).output().unwrap();
        refused(&said, case.line, &[name, "symbolic links"]);
    }
}

#[test]
fn an_output_is_never_an_input() {
    let bench = Bench::new();
    let mut pairs = 0;
    for case in CASES
        .iter()
        .filter(|case| !["sweep", "merge"].contains(&case.verb()))
    {
        let inputs = case.line.split_whitespace();
        let inputs = inputs.filter_map(|word| word.strip_prefix("../in/"));
        for input in inputs {
            let input = match input {
                // A file in the folder that is read.
                "results" => "results/results.csv",
                file => file,
            };
            let path = bench.at("in").join(input);
            let before = fs::read(&path).unwrap();
            for output in case.writes() {
                for how in ["hard link", "link", "link to a link"] {
                    let work = bench.work();
                    let place = work.join(output);
                    fs::create_dir_all(place.parent().unwrap()).unwrap();
                    match how {
                        "hard link" => fs::hard_link(&path, &place).unwrap(),
                        "link" => symlink(&path, &place).unwrap(),
                        _ => {
                            symlink(&path, work.join("between")).unwrap();
                            symlink(work.join("between"), &place).unwrap();
                        }
                    }
                    let there = files(&work);
                    let said = case.command(&work).output().unwrap();
                    let what = format!("{}: {output} is a {how} of {input}", case.line);
                    refused(&said, &what, &["to be read", output]);
                    assert!(fs::read(&path).unwrap() == before, "{what}");
                    assert_eq!(files(&work), there, "{what}");
                    pairs += 1;
                }
            }
        }
    }
    assert!(pairs > 60, "only {pairs}");
    // By the same name, and by another way to it.
    let at = bench.at("in");
    let before = fs::read(at.join("events.npy")).unwrap();
    for line in [
        "convert events.npy events.npy --kind 0",
        "convert events.npy ../in/events.npy --kind 0",
        "convert events.npy ../work/../in/events.npy",
        "packets events.npy --readout ideal -o ./events.npy",
        "run --scene clip.npy --sensor sensor.toml --counts clip.npy",
        "run --scene clip.npy --sensor sensor.toml --events clip.npy",
        "mesh solve --lambda 1 --input plane.npy --output plane.npy",
        "mesh step --lambda 1 --tau 1ms --scene clip.npy --output clip.npy",
        "quantise k.toml --to ternary -o k.toml",
        "compile k.toml --threshold 3 -o words.scamp --sensor sensor.toml",
        "exec words.scamp --set A=plane.npy --events plane.npy",
    ] {
        bench.work();
        let words: Vec<&str> = line.split_whitespace().collect();
        if line.starts_with("compile") {
            // Another mistake; here only for the files, which are as they were.
            ran(&at, &words);
            continue;
        }
        refused(&ran(&at, &words), line, &["to be read"]);
    }
    assert!(fs::read(at.join("events.npy")).unwrap() == before);
}

/// Files that are named by files.
#[test]
fn an_output_is_no_input_of_an_input() {
    let bench = Bench::new();
    let at = bench.at("in");
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    let weights = ndarray::arr2(&[[0.0, -1.0, 0.0], [-1.0, 4.0, -1.0], [0.0, -1.0, 0.0]]);
    ndarray_npy::write_npy(at.join("kernel.npy"), &weights).unwrap();
    let sensor = fs::read_to_string(at.join("sensor.toml")).unwrap();
    let named: String = sensor
        .lines()
        .map(|line| match line.split_once('=') {
            Some((key, _)) if key.trim() == "kernel" => "kernel = \"kernel.npy\"\n".to_owned(),
            _ => format!("{line}\n"),
        })
        .collect();
    assert_ne!(named, sensor);
    fs::write(at.join("named.toml"), named).unwrap();
    let chip = at.join("chip");
    let base = at.join("base");
    for folder in [&chip, &base] {
        fs::create_dir(folder).unwrap();
    }
    for name in ["device.toml", "primitives.toml", "macros.scamp"] {
        let text = fs::read_to_string(own.join("isa/scamp5").join(name)).unwrap();
        let text = text.replace("name = \"scamp5\"", "name = \"base\"");
        fs::write(base.join(name), text).unwrap();
    }
    fs::write(
        chip.join("device.toml"),
        "name = \"chip\"\ntitle = \"mine\"\nextends = \"base\"\n",
    )
    .unwrap();
    // A picture inside a pattern, and a folder of them.
    let pictures = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/scene/");
    fs::copy(format!("{pictures}still16.png"), at.join("photo.png")).unwrap();
    let own = "//! image = \"pattern:pan?image=photo.png&frames=4\"\nframe { get_image(A); }\n";
    fs::write(at.join("own.scamp"), own).unwrap();
    fs::create_dir(at.join("pictures")).unwrap();
    for name in ["a.png", "b.png"] {
        fs::copy(at.join("photo.png"), at.join("pictures").join(name)).unwrap();
    }
    let before: Vec<_> = files(&at)
        .into_iter()
        .map(|n| (fs::read(at.join(&n)).unwrap(), n))
        .collect();
    for line in [
        "exec dvs/snap --image pictures --fps 9 --strip pictures/c.png",
        "exec dvs/snap --image ./pictures --fps 9 --dump pictures/../pictures",
    ] {
        let words: Vec<&str> = line.split_whitespace().collect();
        refused(&ran(&at, &words), line, &["whose pictures are the scene"]);
    }
    for line in [
        "exec dvs/snap --image pattern:pan?image=photo.png&frames=4 --strip photo.png",
        "exec own.scamp --strip photo.png",
        "run --scene clip.npy --sensor named.toml --counts kernel.npy",
        "quantise k.toml --to ternary --threshold 5 --effort 0 --chip chip -o chip/device.toml",
        "quantise k.toml --to ternary --threshold 5 --effort 0 --chip chip -o base/primitives.toml",
        "compile k.toml --threshold 5 --effort 0 --chip chip -o base/macros.scamp",
    ] {
        let words: Vec<&str> = line.split_whitespace().collect();
        refused(&ran(&at, &words), line, &["to be read"]);
    }
    for (bytes, name) in before {
        assert!(fs::read(at.join(&name)).unwrap() == bytes, "{name}");
    }
}

#[test]
fn two_outputs_are_two_files() {
    let bench = Bench::new();
    let work = bench.work();
    let run = [
        "run",
        "--scene",
        "../in/clip.npy",
        "--sensor",
        "../in/sensor.toml",
    ];
    let two = |a: &str, b: &str| ran(&work, &[&run[..], &["--counts", a, "--voxels", b]].concat());
    refused(
        &two("a.npy", "a.npy"),
        "twice",
        &["a.npy is asked for twice"],
    );
    refused(&two("a.npy", "./a.npy"), "twice", &["the same"]);
    refused(&two("a.npy", "../work/a.npy"), "twice", &["the same"]);
    refused(
        &two("new/a.npy", "new/../new/a.npy"),
        "twice",
        &["the same"],
    );
    refused(&two("-", "/dev/stdout"), "twice", &["twice"]);
    symlink("a.npy", work.join("b.npy")).unwrap();
    refused(&two("a.npy", "b.npy"), "a link", &["the same"]);
    good(&two("/dev/null", "/dev/null"), "the null device takes all");
    // What is printed goes to a file that is written.
    let out = File::create(work.join("s.svg")).unwrap();
    let mut show = verbs::amacrine(&work);
    show.args(["show", "../in/events.npy", "-o", "s.svg"])
        .stdout(out);
    refused(
        &show.output().unwrap(),
        "stdout",
        &["s.svg", "standard output"],
    );
    // Of a name that another output's name is made of.
    fs::hard_link(bench.at("in/events.csv"), work.join("k.kind1.csv")).unwrap();
    let each = ["convert", "../in/events.csv", "k.csv", "--each-kind"];
    refused(&ran(&work, &each), "kinds", &["k.kind1.csv", "to be read"]);
    assert!(!work.join("k.kind0.csv").exists());
}

#[test]
fn names_say_what_is_in_them() {
    let bench = Bench::new();
    let mut tried = 0;
    for case in plain() {
        for output in case.writes() {
            for wrong in ["r.pdf", "r.jpg", "r", "r.txt.bak"] {
                let work = bench.work();
                let Some(words) = renamed(case, output, wrong) else {
                    continue;
                };
                let what = words.join(" ");
                refused(&ran(&work, &words), &what, &[wrong]);
                assert!(files(&work).is_empty(), "{what}");
                tried += 1;
            }
        }
    }
    assert!(tried > 60, "only {tried}");
    let work = bench.work();
    let named = |b: &str, format: &str| {
        ran(
            &work,
            &["convert", "../in/events.csv", b, "--format", format],
        )
    };
    refused(
        &named("e.csv", "npy"),
        "contradiction",
        &["e.csv", "csv", "npy"],
    );
    refused(&named("e.raw", "npy"), "contradiction", &["evt2", "npy"]);
    let one = [
        "convert",
        "../in/events.csv",
        "e.raw",
        "--format",
        "evt3",
        "--kind",
        "0",
    ];
    good(&ran(&work, &one), "one of several");
    good(&named("e.anything", "npy"), "a name that says nothing");
}

#[test]
fn a_dash_is_standard_output() {
    let bench = Bench::new();
    let mut tried = 0;
    for case in plain() {
        let wanted = wanted(&bench, case);
        for (output, bytes) in &wanted {
            let ending = output.rsplit('.').next().unwrap();
            // What is written where there is no name.
            let first = match case.verb() {
                "run" | "exec" | "packets"
                    if ["--events", "packets"]
                        .iter()
                        .any(|w| case.line.contains(w))
                        && output.starts_with(['e', 'p']) =>
                {
                    "csv"
                }
                _ => ending,
            };
            let Some(mut words) = renamed(case, output, "-") else {
                continue;
            };
            if case.verb() == "convert" {
                words.extend(["--format".to_owned(), ending.to_owned()]);
            }
            let pictures = case.verb() == "show" && ending != "png";
            let archives = case.verb() == "voxels" && ending != "npy";
            if pictures || archives || output == &"h.png" {
                continue;
            }
            let what = words.join(" ");
            let said = ran(&bench.work(), &words);
            good(&said, &what);
            if case.verb() == "quantise" && ending == "toml" {
                // It says its own name.
                assert!(said.stdout.starts_with(b"name = "), "{what}");
            } else if first == ending {
                assert!(said.stdout == *bytes, "{what}");
            } else {
                assert!(said.stdout.starts_with(b"t,x,y,p"), "{what}");
            }
            assert!(!said.stderr.is_empty(), "{what}: the table is beside it");
            words.push("--json".to_owned());
            if !case.line.starts_with("mesh s") || case.line.contains("solve") {
                refused(&ran(&bench.work(), &words), &what, &["--json"]);
            }
            tried += 1;
        }
    }
    assert!(tried > 12, "only {tried}");
    // It goes on where standard output is, and does not begin anew.
    let work = bench.work();
    let script = format!(
        "(echo first; {} convert ../in/events.npy - --format csv; echo last) > all 2> table",
        assert_cmd::cargo::cargo_bin("amacrine").display()
    );
    let said = Command::new("sh")
        .args(["-c", &script])
        .current_dir(&work)
        .status();
    assert!(said.unwrap().success());
    let all = fs::read_to_string(work.join("all")).unwrap();
    assert!(all.starts_with("first\nt,x,y,p"), "{all}");
    assert!(all.ends_with("\nlast\n"), "{all}");
    assert!(all.lines().count() > 40);
}

#[test]
fn missing_folders_are_made() {
    let bench = Bench::new();
    for case in plain() {
        for output in case.writes() {
            let Some(words) = renamed(case, output, &format!("a/b/{output}")) else {
                continue;
            };
            let work = bench.work();
            let what = words.join(" ");
            good(&ran(&work, &words), &what);
            assert!(work.join("a/b").join(output).is_file(), "{what}");
            let Some(words) = renamed(case, output, &format!("a/{output}")) else {
                continue;
            };
            let work = bench.work();
            fs::write(work.join("a"), "in the way").unwrap();
            let said = ran(&work, &words);
            let name = format!("a/{output}");
            refused(&said, &what, &[&name]);
            assert_eq!(
                text(&said.stderr).matches(&name).count(),
                1,
                "{}",
                text(&said.stderr)
            );
            assert_eq!(files(&work).len(), 1, "{what}");
        }
    }
}

#[test]
fn files_have_the_mode_that_the_user_wants() {
    let bench = Bench::new();
    let program = assert_cmd::cargo::cargo_bin("amacrine");
    for case in plain() {
        for (umask, mode) in [("022", 0o644), ("077", 0o600), ("002", 0o664)] {
            let work = bench.work();
            let script = format!(
                "umask {umask}; exec {} {}",
                program.display(),
                case.line.replace('&', "\\&")
            );
            let said = Command::new("sh")
                .args(["-c", &script])
                .current_dir(&work)
                .output();
            good(&said.unwrap(), case.line);
            for name in case.writes() {
                let is = fs::metadata(work.join(name)).unwrap().mode() & 0o7777;
                assert_eq!(is, mode, "{}: {name} under {umask}", case.line);
            }
            if case.slow {
                break;
            }
        }
        if case.slow {
            continue;
        }
        // A file that is replaced keeps its own.
        let work = bench.work();
        for name in case.writes() {
            fs::write(work.join(name), "old").unwrap();
            fs::set_permissions(work.join(name), fs::Permissions::from_mode(0o604)).unwrap();
        }
        good(&case.command(&work).output().unwrap(), case.line);
        for name in case.writes() {
            let is = fs::metadata(work.join(name)).unwrap().mode() & 0o7777;
            assert_eq!(is, 0o604, "{}: {name}", case.line);
        }
    }
}

/// A run that takes minutes and little of the disk, with two files half-written in a folder that is
/// new.
fn endless(work: &Path, shell: &str) -> Child {
    let script = format!(
        "{shell} exec {} run --scene 'pattern:disc?width=64&height=48&frames=5000&radius=6' --upsample 0.0001 --sensor ../in/sensor.toml --counts new/c.npy --voxels new/v.npy",
        assert_cmd::cargo::cargo_bin("amacrine").display()
    );
    let mut child = Command::new("bash")
        .args(["-c", &script])
        .current_dir(work)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while files(work).len() < 2 {
        assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        assert!(
            begun.elapsed() < Duration::from_secs(30),
            "nothing was begun"
        );
        thread::sleep(Duration::from_millis(10));
    }
    child
}

fn kill(child: &Child, signal: &str) {
    let sent = Command::new("kill")
        .args(["-s", signal, &child.id().to_string()])
        .status();
    assert!(sent.unwrap().success());
}

#[test]
fn signals_leave_nothing_behind() {
    let bench = Bench::new();
    for (signal, number) in [("INT", 2), ("TERM", 15), ("HUP", 1), ("QUIT", 3)] {
        let work = bench.work();
        let mut child = endless(&work, "ulimit -c 0;");
        kill(&child, signal);
        let status = child.wait().unwrap();
        assert_eq!(
            status.signal(),
            Some(number),
            "as if by {signal}: {status:?}"
        );
        assert_eq!(fs::read_dir(&work).unwrap().count(), 0, "after {signal}");
    }
    // What is ignored stays ignored.
    let work = bench.work();
    let mut child = endless(&work, "trap '' HUP INT;");
    kill(&child, "HUP");
    kill(&child, "INT");
    thread::sleep(Duration::from_millis(300));
    assert!(child.try_wait().unwrap().is_none(), "it was to ignore that");
    kill(&child, "TERM");
    assert_eq!(child.wait().unwrap().signal(), Some(15));
    assert_eq!(fs::read_dir(&work).unwrap().count(), 0);
}

/// With standard output closed by whoever reads it, before anything is said.
fn unread(folder: &Path, words: &[&str]) -> (Option<i32>, String) {
    let script = format!(
        "sleep 0.1; exec {} \"$@\"",
        assert_cmd::cargo::cargo_bin("amacrine").display()
    );
    let mut child = Command::new("sh")
        .args(["-c", &script, "sh"])
        .args(words)
        .current_dir(folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let said = child.wait_with_output().unwrap();
    (said.status.code(), text(&said.stderr))
}

#[test]
fn a_reader_that_has_gone_is_no_error() {
    let bench = Bench::new();
    let work = bench.work();
    for words in [
        &["asm", "../in/words.scamp"][..],
        &["--help"],
        &["--version"],
        &["run", "--help"],
        &["convert", "../in/events.npy", "-", "--format", "csv"],
        &["convert", "../in/events.npy", "-", "--format", "npy"],
        &["show", "../in/events.npy", "-o", "-"],
    ] {
        let (code, message) = unread(&work, words);
        assert_eq!(code, Some(0), "{words:?}: {message}");
        assert_eq!(message, "", "{words:?}");
    }
    assert!(files(&work).is_empty());
}

/// A script that goes on would take a file of another run for this one's.
#[test]
fn a_reader_that_has_gone_leaves_no_file_out_in_silence() {
    let bench = Bench::new();
    let work = bench.work();
    let case = "run --scene ../in/clip.npy --sensor ../in/sensor.toml --events - --counts c.npy";
    let case: Vec<&str> = case.split(' ').collect();
    for before in [None, Some("of another run")] {
        if let Some(before) = before {
            fs::write(work.join("c.npy"), before).unwrap();
        }
        let (code, message) = unread(&work, &case);
        let now = fs::read_to_string(work.join("c.npy")).ok();
        assert_eq!(now.as_deref(), before);
        assert_eq!(code, Some(2), "{message}");
        let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(
            message.contains("c.npy: not written, since the reader of another output has gone"),
            "{message}"
        );
    }
}

#[test]
fn what_cannot_be_printed_is_an_error() {
    let bench = Bench::new();
    let work = bench.work();
    let full = || {
        Stdio::from(
            fs::OpenOptions::new()
                .write(true)
                .open("/dev/full")
                .unwrap(),
        )
    };
    for words in [
        &["asm", "../in/words.scamp"][..],
        &["asm", "../in/words.scamp", "--json"],
        &["--help"],
        &["--version"],
        &["sweep", "--schema"],
        &["convert", "../in/events.npy", "c.csv"],
    ] {
        let mut command = verbs::amacrine(&work);
        let said = command.args(words).stdout(full()).output().unwrap();
        let message = text(&said.stderr);
        assert_eq!(said.status.code(), Some(1), "{words:?}: {message}");
        assert!(message.contains("No space left"), "{words:?}: {message}");
    }
    assert!(work.join("c.csv").is_file(), "what was written stays");
    let said = verbs::amacrine(&work)
        .args(["convert", "../in/events.npy", "-", "--format", "csv"])
        .stdout(full())
        .output()
        .unwrap();
    assert_eq!(said.status.code(), Some(2), "{}", text(&said.stderr));
    // Standard error that takes nothing: the exit code is all there is.
    for (words, code) in [
        (&["asm", "none.scamp"][..], 2),
        (&["asm"], 2),
        (&["nothing"], 2),
        (&["convert", "../in/events.npy", "d.csv"], 0),
        (&["compile", "--sensor", "../in/sensor.toml"], 2),
    ] {
        let mut command = verbs::amacrine(&work);
        let said = command.args(words).stderr(full()).output().unwrap();
        assert_eq!(said.status.code(), Some(code), "{words:?}");
    }
}

/// Descriptors that are closed are not taken for something else.
#[test]
fn closed_descriptors_harm_nothing() {
    let bench = Bench::new();
    let program = assert_cmd::cargo::cargo_bin("amacrine");
    for (closed, code) in [(">&-", 0), ("2>&-", 0), ("<&-", 0), (">&- 2>&- <&-", 0)] {
        for case in plain().filter(|case| !case.slow) {
            let wanted = wanted(&bench, case);
            let work = bench.work();
            let script = format!(
                "exec {} {} {closed}",
                program.display(),
                case.line.replace('&', "\\&")
            );
            let said = Command::new("sh")
                .args(["-c", &script])
                .current_dir(&work)
                .output();
            assert_eq!(
                said.unwrap().status.code(),
                Some(code),
                "{} {closed}",
                case.line
            );
            for (name, bytes) in &wanted {
                assert!(
                    fs::read(work.join(name)).unwrap() == *bytes,
                    "{} {closed}",
                    case.line
                );
            }
            if case.verb() != "convert" && closed != ">&- 2>&- <&-" {
                break;
            }
        }
    }
}

#[test]
fn names_that_are_no_utf8() {
    let bench = Bench::new();
    let work = bench.work();
    let name = |text: &[u8]| work.join(OsStr::from_bytes(text));
    let events = name(b"e\xff.csv");
    fs::copy(bench.at("in/events.csv"), &events).unwrap();
    let words = |words: &[&OsStr]| ran(&work, words);
    let o = OsStr::new;
    let out = name(b"o\xfe.npy");
    good(
        &words(&[o("convert"), events.as_os_str(), out.as_os_str()]),
        "in and out",
    );
    assert!(out.is_file());
    let kinds = name(b"k\xfe.csv");
    good(
        &words(&[
            o("convert"),
            events.as_os_str(),
            kinds.as_os_str(),
            o("--each-kind"),
        ]),
        "kinds",
    );
    assert!(name(b"k\xfe.kind0.csv").is_file());
    let picture = name(b"p\xfe.png");
    good(
        &words(&[o("show"), out.as_os_str(), o("-o"), picture.as_os_str()]),
        "show",
    );
    good(
        &words(&[o("compare"), out.as_os_str(), events.as_os_str()]),
        "compare",
    );
    good(&words(&[o("packets"), out.as_os_str()]), "packets");
    let program = name(b"w\xff.scamp");
    fs::copy(bench.at("in/words.scamp"), &program).unwrap();
    good(&words(&[o("asm"), program.as_os_str()]), "asm");
    let sensor = name(b"s\xff.toml");
    fs::copy(bench.at("in/sensor.toml"), &sensor).unwrap();
    let run = [
        o("run"),
        o("--scene"),
        o("../in/clip.npy"),
        o("--sensor"),
        sensor.as_os_str(),
    ];
    good(&words(&run), "run");
    let before = files(&work);
    for line in [
        vec![o("convert"), events.as_os_str(), o("x.npy")],
        vec![o("convert"), o("../in/events.csv"), kinds.as_os_str()],
        vec![
            o("show"),
            o("../in/events.csv"),
            o("-o"),
            picture.as_os_str(),
        ],
        vec![o("compare"), out.as_os_str(), events.as_os_str()],
        vec![o("packets"), out.as_os_str()],
        vec![o("asm"), program.as_os_str()],
        run.to_vec(),
    ] {
        let line = [line, vec![o("--json")]].concat();
        refused(&words(&line), &format!("{line:?}"), &["UTF-8"]);
    }
    let scene = name(b"c\xff.npy");
    fs::copy(bench.at("in/clip.npy"), &scene).unwrap();
    let sensor = o("../in/sensor.toml");
    for line in [
        vec![
            o("run"),
            o("--sensor"),
            sensor,
            o("--scene"),
            scene.as_os_str(),
        ],
        vec![
            o("mesh"),
            o("solve"),
            o("--lambda"),
            o("1"),
            o("-o"),
            o("h.npy"),
            o("-i"),
            scene.as_os_str(),
        ],
        vec![o("quantise"), scene.as_os_str(), o("--to"), o("ternary")],
    ] {
        refused(&words(&line), &format!("{line:?}"), &["UTF-8"]);
    }
    fs::remove_file(scene).unwrap();
    assert_eq!(files(&work), before);
}

/// No input is looked at before the places of the outputs: what is not there is not complained of.
#[cfg(target_os = "linux")]
#[test]
fn places_are_tried_before_the_work() {
    let bench = Bench::new();
    let work = bench.work();
    for line in [
        "run --scene none.npy --sensor none --events /proc/none/e.npy",
        "run --scene none.npy --sensor none --counts /proc/none.npy",
        "exec none --dump /proc/none",
        "exec none --trace /proc/none.html",
        "design none --rate 2 -o /proc/none",
        "feasibility none --threshold 1 -o /proc/none.html",
        "waterfall none --threshold 1 -o /proc/none.svg",
        "trade --scene none --sensor none -o /proc/none.svg",
        "quantise none --to ternary --picture /proc/none.png",
        "compile none -o /proc/none.scamp",
        "sweep none --output /proc/none",
        "merge none -o /proc/none",
        "voxels none.npy --window 1s -o /proc/none.npy",
        "show none.npy -o /proc/none.png",
        "demo -o /proc/none",
    ] {
        let words: Vec<&str> = line.split_whitespace().collect();
        refused(&ran(&work, &words), line, &["cannot write /proc/none"]);
    }
    assert!(files(&work).is_empty());
}
