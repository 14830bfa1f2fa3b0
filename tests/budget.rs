//! No count from outside is believed before it has a budget: every verb ends at once and in
//! little memory, with a message and exit code 2, or does what its prediction said.

#![cfg(target_os = "linux")]

use std::{
    fmt::Write as _,
    fs,
    io::{Read as _, Write as _},
    path::{Path, PathBuf},
    process::{Command, Stdio},
    thread,
    time::{Duration, Instant},
};

/// What a refusal may hold at most, in KiB.
const MOST_KIB: u64 = 300 << 10;

/// How long a refusal may take: it takes some ten milliseconds; machines may be busy.
const LONGEST: Duration = Duration::from_secs(20);

/// How long a run that is measured may take.
const PATIENCE: Duration = Duration::from_mins(5);

/// What a run of the program gave.
struct Ran {
    code: Option<i32>,
    /// The most that it held, in KiB.
    peak: u64,
    out: String,
    errors: String,
}

fn root(path: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    root.join(path).display().to_string()
}

/// Runs the program and watches what it holds.
fn amacrine(arguments: &[&str], most: Duration) -> Ran {
    let mut child = Command::new(env!("CARGO_BIN_EXE_amacrine"))
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut pipes = (child.stdout.take().unwrap(), child.stderr.take().unwrap());
    let out = thread::spawn(move || {
        let mut text = String::new();
        let _ = pipes.0.read_to_string(&mut text);
        text
    });
    let errors = thread::spawn(move || {
        let mut text = String::new();
        let _ = pipes.1.read_to_string(&mut text);
        text
    });
    let status = format!("/proc/{}/status", child.id());
    let (start, mut peak) = (Instant::now(), 0);
    let code = loop {
        if let Some(held) = fs::read_to_string(&status)
            .ok()
            .and_then(|text| held(&text))
        {
            peak = peak.max(held);
        }
        if let Some(ended) = child.try_wait().unwrap() {
            break ended.code();
        }
        if start.elapsed() > most {
            let _ = child.kill();
            panic!("{arguments:?} takes longer than {most:?}");
        }
        thread::sleep(Duration::from_millis(1));
    };
    Ran {
        code,
        peak,
        out: out.join().unwrap(),
        errors: errors.join().unwrap(),
    }
}

/// The most that was held so far, in KiB.
fn held(status: &str) -> Option<u64> {
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse().ok()
}

/// Words of an error without its frame and line breaks.
fn words(errors: &str) -> String {
    let plain = errors.replace(['│', '×', '╰', '╭', '─', '▶', '·', '\n'], " ");
    plain.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Runs what must be refused: exit code 2, a message with these words, at once, in little memory.
fn refused(arguments: &[&str], says: &[&str]) {
    let ran = amacrine(arguments, LONGEST);
    let message = words(&ran.errors);
    assert_eq!(ran.code, Some(2), "{arguments:?}: {} {message}", ran.out);
    for word in says {
        assert!(
            message.contains(word),
            "{arguments:?}: {word:?} is not in: {message}"
        );
    }
    assert!(ran.peak < MOST_KIB, "{arguments:?}: held {} KiB", ran.peak);
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, bytes: &[u8]) -> String {
        fs::write(self.path(name), bytes).unwrap();
        self.path(name).display().to_string()
    }
}

fn npy(shape: &str, kind: &str, numbers: &[u8]) -> Vec<u8> {
    let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    while !(header.len() + 11).is_multiple_of(64) {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\0".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.bytes());
    bytes.extend(numbers);
    bytes
}

/// A PNG that promises `side` x `side` pixels and holds `rows` of zeros.
fn png(side: u32, rows: usize) -> Vec<u8> {
    let chunk = |kind: &[u8; 4], content: &[u8], out: &mut Vec<u8>| {
        out.extend((content.len() as u32).to_be_bytes());
        let mut summed = kind.to_vec();
        summed.extend(content);
        out.extend(&summed);
        out.extend(crc32fast::hash(&summed).to_be_bytes());
    };
    let mut header = side.to_be_bytes().to_vec();
    header.extend(side.to_be_bytes());
    header.extend([8, 0, 0, 0, 0]);
    let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    let row = vec![0; side as usize + 1];
    for _ in 0..rows {
        packed.write_all(&row).unwrap();
    }
    let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
    chunk(b"IHDR", &header, &mut bytes);
    chunk(b"IDAT", &packed.finish().unwrap(), &mut bytes);
    chunk(b"IEND", &[], &mut bytes);
    bytes
}

/// A GIF of `side` x `side` whose frames have one pixel: 89 bytes with three frames.
fn gif(side: u16, frames: usize) -> Vec<u8> {
    let mut bytes = b"GIF89a".to_vec();
    bytes.extend(side.to_le_bytes());
    bytes.extend(side.to_le_bytes());
    bytes.extend([0x80, 0, 0, 0, 0, 0, 255, 255, 255]);
    for _ in 0..frames {
        bytes.extend([0x21, 0xf9, 4, 0, 3, 0, 0, 0]);
        bytes.extend([0x2c, 0, 0, 0, 0, 1, 0, 1, 0, 0]);
        bytes.extend([2, 2, 0x44, 1, 0]);
    }
    bytes.push(0x3b);
    bytes
}

#[test]
fn scenes_that_promise_too_much_are_refused() {
    let folder = Folder::new();
    let dvs = root("sensors/dvs.toml");
    let scenes = [
        folder.write("small.gif", &gif(8190, 3)),
        folder.write("large.gif", &gif(65535, 3)),
        folder.write("head.png", &png(65535, 1)),
        folder.write("bomb.png", &png(30000, 3000)),
        folder.write("a.pgm", b"P5\n100000 100000\n255\n\0\0"),
        folder.write("b.pgm", b"P5\n4294967295 4294967295\n65535\n"),
        folder.write("c.ppm", b"P6\n70000 2\n255\n"),
        folder.write("a.y4m", b"YUV4MPEG2 W65536 H65536 F1:1 C444p16\nFRAME\n"),
        folder.write("b.y4m", b"YUV4MPEG2 W4096 H4096 F1:1 C444p16\nFRAME\n"),
        folder.write("a.npy", &npy("(1, 65536, 65536)", "<f8", &[0; 8])),
        folder.write("b.npy", &npy("(4611686018427387904, 1, 4)", "<f8", &[0; 8])),
        folder.write("c.npy", &npy("(99999999, 16, 16)", "<f8", &[0; 8])),
        "pattern:bar?width=65536&height=65536&frames=1000000000000".to_owned(),
        "pattern:bar?width=65536&height=65536".to_owned(),
        "pattern:bar?frames=1e12".to_owned(),
        "pattern:bar?frames=16777217".to_owned(),
        "pattern:bar?width=4096&height=4096&frames=16777216".to_owned(),
        "pattern:bar?width=18446744073709551616".to_owned(),
        "/dev/zero".to_owned(),
    ];
    for scene in &scenes {
        refused(&["run", "--scene", scene, "--sensor", &dvs], &[]);
    }
    let sobel = root("programs/convolve/sobel.scamp");
    for scene in &scenes[..6] {
        refused(&["exec", &sobel, "--image", scene], &[]);
    }
}

/// A device, a pipe and a link to a device are no scenes: they may never end, and are not there a
/// second time.
#[test]
fn scenes_that_are_no_files_are_refused() {
    let folder = Folder::new();
    let dvs = root("sensors/dvs.toml");
    let link = folder.path("endless.y4m");
    std::os::unix::fs::symlink("/dev/zero", &link).unwrap();
    let pipe = folder.path("pipe.y4m");
    assert!(
        Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .unwrap()
            .success()
    );
    for scene in [link, pipe] {
        let scene = scene.display().to_string();
        refused(
            &["run", "--scene", &scene, "--sensor", &dvs],
            &["neither a file nor a folder"],
        );
    }
}

#[test]
fn planes_that_promise_too_much_are_refused() {
    let folder = Folder::new();
    let sobel = root("programs/convolve/sobel.scamp");
    let out = folder.path("out.npy").display().to_string();
    let link = folder.path("endless.npy");
    std::os::unix::fs::symlink("/dev/zero", &link).unwrap();
    let planes = [
        folder.write("a.npy", &npy("(65536, 65536)", "<f8", &[0; 8])),
        folder.write("b.npy", &npy("(4294967296, 4294967296)", "<f8", &[0; 8])),
        folder.write("c.npy", &npy("(4096, 4096)", "|b1", &[0; 8])),
        folder.write("d.npy", &npy("(4096, 4096)", "<i8", &[0; 8])),
        link.display().to_string(),
    ];
    for plane in &planes {
        let set = format!("A={plane}");
        refused(&["exec", &sobel, "--set", &set], &[]);
        refused(
            &["mesh", "solve", "--lambda", "3", "-i", plane, "-o", &out],
            &[],
        );
    }
}

/// Steps without end are refused at the first pair that would take them.
#[test]
fn options_without_end_are_refused() {
    let dvs = root("sensors/dvs.toml");
    let clip = root("clips/vtest_256x256.apng");
    let run = ["run", "--scene", &clip, "--sensor", &dvs];
    let more = |more: &[&'static str]| [&run[..], more].concat();
    for contrast in ["1e-12", "1e-300", "1e-5"] {
        let refusal = [&run[..], &["--upsample", contrast]].concat();
        refused(&refusal, &["more than 1000 steps"]);
    }
    refused(&more(&["--fps", "1e-300"]), &[]);
    let sobel = root("programs/convolve/sobel.scamp");
    refused(
        &["exec", &sobel, "--frames", "1000000000000"],
        &["16777216"],
    );
    refused(
        &["exec", &sobel, "--repeat", "1000000000000"],
        &["1000000 runs"],
    );
    for size in ["0", "4X", "-1", "1e99G", ""] {
        let given = format!("--max-memory={size}");
        refused(&["asm", &sobel, &given], &["not a size"]);
    }
}

/// One refusal for each verb that computes: what would be held, part by part, what there is, and
/// what to change.
#[test]
#[expect(clippy::too_many_lines, reason = "a table of verbs")]
fn what_is_beyond_the_budget_is_refused_before_the_work() {
    let folder = Folder::new();
    let dvs = root("sensors/dvs.toml");
    let sobel = root("programs/convolve/sobel.scamp");
    let scene = "pattern:bar?width=2048&height=2048&frames=50";
    let out = folder.path("o.npy").display().to_string();
    let strip = folder.path("s.png").display().to_string();
    let rows = (0..400_000).map(|t| format!("\n{t},{},{},{}", t % 64, t % 48, t % 2));
    let csv = format!("t,x,y,p{}\n", rows.collect::<String>());
    let events = folder.write("events.csv", csv.as_bytes());
    let cases: &[&[&str]] = &[
        &["run", "--scene", scene, "--sensor", &dvs],
        &["run", "--scene", scene, "--sensor", &dvs, "--events", &out],
        &[
            "run",
            "--scene",
            "pattern:bar",
            "--sensor",
            &dvs,
            "--events",
            &out,
            "--readout",
            "ideal",
            "--max-events",
            "99999999999",
        ],
        &["exec", &sobel, "--image", scene],
        &["exec", &sobel, "--image", scene, "--domain", "silicon"],
        &[
            "exec",
            &sobel,
            "--image",
            "pattern:bar?width=512&height=512",
            "--strip",
            &strip,
        ],
        &["plan", "--scene", scene, "--sensor", &dvs],
        &["trade", "--scene", scene, "--sensor", &dvs],
        &[
            "mesh", "step", "--lambda", "3", "--tau", "1ms", "--scene", scene, "-o", &out,
        ],
        &[
            "waterfall",
            "rgc-5x5",
            "--to",
            "int-5",
            "--threshold",
            "128",
            "--scene",
            scene,
        ],
        &[
            "quantise",
            "rgc-5x5",
            "--to",
            "ternary",
            "--threshold",
            "128",
            "--scene",
            scene,
        ],
        &[
            "feasibility",
            "--kernel",
            "rgc-5x5",
            "--threshold",
            "128",
            "--scene",
            scene,
        ],
        &["compare", &events, &events],
        &["packets", &events],
        &["show", &events, "-o", &strip],
    ];
    for case in cases {
        let arguments = [*case, &["--max-memory", "32M"]].concat();
        refused(&arguments, &["--max-memory"]);
        assert!(
            !Path::new(&out).exists() && !Path::new(&strip).exists(),
            "{case:?}"
        );
    }
    let ran = amacrine(
        &[
            "run",
            "--scene",
            scene,
            "--sensor",
            &dvs,
            "--max-memory",
            "100M",
        ],
        LONGEST,
    );
    let message = words(&ran.errors);
    for part in [
        "a run of 2048x2048 with 1 kind of cells in f64 would hold",
        "the sensor's cells",
        "frames of the scene",
        "--max-memory allows 100 MiB",
        "take a smaller scene, fewer kinds of cells or a narrower --format",
        "such as --max-memory",
    ] {
        assert!(message.contains(part), "{part:?} is not in: {message}");
    }
}

/// A budget that is less than the program itself takes: the message says both, and the least
/// that is enough.
#[test]
fn a_budget_below_the_program_itself_says_what_is_enough() {
    let folder = Folder::new();
    let out = folder.path("o.npy").display().to_string();
    let [dvs, sobel] = ["sensors/dvs.toml", "programs/convolve/sobel.scamp"].map(root);
    for case in [
        &[
            "run",
            "--scene",
            "pattern:bar",
            "--sensor",
            &dvs,
            "--events",
            &out,
        ][..],
        &["exec", &sobel, "--image", "pattern:bar"],
    ] {
        let ran = amacrine(&[case, &["--max-memory", "20M"]].concat(), LONGEST);
        let message = words(&ran.errors);
        for part in [
            "the program itself 24.0 MiB",
            "--max-memory allows 20.0 MiB",
        ] {
            assert!(message.contains(part), "{part:?} is not in: {message}");
        }
        let (_, enough) = message.split_once("such as --max-memory ").unwrap();
        let enough = enough.split_whitespace().next().unwrap();
        let ran = amacrine(&[case, &["--max-memory", enough]].concat(), LONGEST);
        let message = words(&ran.errors);
        assert!(!message.contains("would hold"), "{enough}: {message}");
    }
}

/// A pilot keeps a scene within a quarter of what may be held, and not twice; else it says that it
/// measured nothing, and the full model runs.
#[test]
fn a_pilot_holds_no_more_of_a_scene_than_it_may() {
    let snap = root("programs/dvs/snap.scamp");
    let light = "pattern:disc?width=128&height=128&frames=600";
    let case = ["exec", &snap, "--image", light, "--domain", "silicon"];
    let auto = |most: &str| {
        let more = ["--fidelity", "auto", "--max-memory", most];
        let ran = amacrine(&[&case[..], &more].concat(), PATIENCE);
        assert_eq!(ran.code, Some(0), "{}", ran.errors);
        ran
    };
    let ran = auto("60M");
    let said = words(&ran.out);
    assert!(
        said.contains("too long to be kept, so nothing was measured"),
        "{said}"
    );
    assert!(ran.peak < 60 << 10, "held {} KiB", ran.peak);
    // Once, 8 bytes a pixel: 75 MiB, beside what the pilot's tiles take.
    let ran = auto("900M");
    assert!(!words(&ran.out).contains("too long"));
    assert!(ran.peak < 150 << 10, "held {} KiB", ran.peak);
}

/// A list that a readout wants is as long as there is room for, where nobody says how long it may
/// be. Without a readout events go to the file as they come, however many there are.
#[test]
fn lists_end_where_the_memory_does() {
    let folder = Folder::new();
    let out = folder.path("o.npy").display().to_string();
    let dvs = root("sensors/dvs.toml");
    let scene = "pattern:noise?width=256&height=256&speed=2000&low=0&high=255&frames=200";
    let run = ["run", "--scene", scene, "--sensor", &dvs, "--events", &out];
    let little = [&run[..], &["--max-memory", "40M"]].concat();
    refused(
        &[&little[..], &["--readout", "ideal"]].concat(),
        &["the event list is full", "--max-memory"],
    );
    assert!(!Path::new(&out).exists());
    let ran = amacrine(&little, PATIENCE);
    assert_eq!(ran.code, Some(0), "{}", ran.errors);
    let written = fs::metadata(&out).unwrap().len();
    // Of 13 bytes each in the file, 16 in a packet.
    assert!(written > 40 << 20, "{written} bytes do not try it");
    assert!(ran.peak < 40 << 10, "held {} KiB", ran.peak);
    fs::remove_file(&out).unwrap();
    // A single pair has to fit.
    refused(
        &[&little[..], &["--threshold", "0.001"]].concat(),
        &["one pair of frames has more than", "--max-memory"],
    );
    assert!(!Path::new(&out).exists());
    // And no more than were asked for.
    refused(
        &[&little[..], &["--max-events", "2000000"]].concat(),
        &["more than 2000000 events", "--when-full drop"],
    );
    assert!(!Path::new(&out).exists());
}

/// Verbs that hold all events of a file say how much memory that takes, and it does.
#[test]
fn what_a_refusal_of_a_file_advises_is_enough() {
    let folder = Folder::new();
    let (events, other) = (folder.path("a.npy"), folder.path("b.csv"));
    let (events, other) = (events.display().to_string(), other.display().to_string());
    let scene = "pattern:noise?width=64&height=64&speed=2000&low=0&high=255&frames=200";
    let dvs = root("sensors/dvs.toml");
    let made = [
        "run", "--scene", scene, "--sensor", &dvs, "--events", &events,
    ];
    assert_eq!(amacrine(&made, PATIENCE).code, Some(0));
    // What says how many events it has, and what does not.
    let told = amacrine(&["convert", &events, &other], PATIENCE);
    assert_eq!(told.code, Some(0), "{}", told.errors);
    let sorted = folder.path("s.npy").display().to_string();
    let size = ["--size", "64x64"];
    for verb in [
        vec!["packets", &events],
        vec!["packets", &other, size[0], size[1]],
        vec!["compare", &events, &other, size[0], size[1]],
        vec!["convert", &other, &sorted, "--sort", size[0], size[1]],
    ] {
        let little = [&verb[..], &["--max-memory", "27M"]].concat();
        let ran = amacrine(&little, PATIENCE);
        let errors = words(&ran.errors);
        assert_eq!(ran.code, Some(2), "{verb:?}: {errors}");
        assert_eq!(errors.matches("--max-memory SIZE").count(), 1, "{errors}");
        let enough = format!("{}K", enough(&verb));
        let ran = amacrine(&[&verb[..], &["--max-memory", &enough]].concat(), PATIENCE);
        assert_eq!(ran.code, Some(0), "{verb:?}: {}", ran.errors);
    }
}

/// The prediction in a refusal, in KiB.
fn predicted(arguments: &[&str]) -> u64 {
    // As much as lets the scene be opened, and no more: where it is not, that is another refusal.
    let messages = ["40M", "80M", "120M", "160M"].map(|most| {
        let ran = amacrine(&[arguments, &["--max-memory", most]].concat(), LONGEST);
        words(&ran.errors)
    });
    let after = messages
        .iter()
        .filter(|m| !m.contains("the scene alone"))
        .find_map(|m| Some(m.split_once("would hold ")?.1));
    let after = after.unwrap_or_else(|| panic!("{arguments:?} was not refused: {messages:?}"));
    let mut words = after.split_whitespace();
    let number: f64 = words.next().unwrap().parse().unwrap();
    let unit = words.next().unwrap().trim_end_matches([':', ',']);
    let kib = match unit {
        "MiB" => 1024.0,
        "GiB" => 1024.0 * 1024.0,
        other => panic!("{other}"),
    };
    (number * kib) as u64
}

/// What is said of each run, in KiB, it holds, within a factor of two.
fn within_two(cases: &[&[&str]], said: fn(&[&str]) -> u64) {
    let mut wrong = Vec::new();
    for case in cases {
        let said = said(case);
        let ran = amacrine(case, PATIENCE);
        assert_eq!(ran.code, Some(0), "{case:?}: {}", ran.errors);
        eprintln!("{case:?}: predicted {said} KiB, held {} KiB", ran.peak);
        if said < ran.peak || said > 2 * ran.peak.max(50 << 10) {
            wrong.push(format!(
                "{case:?}: predicted {said} KiB, held {} KiB",
                ran.peak
            ));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// What is predicted is held, within a factor of two, and never much more.
#[test]
fn predictions_are_what_is_measured() {
    let folder = Folder::new();
    let [dvs, noisy, kinds] = ["dvs", "dvs-v2e", "rgc"].map(|n| root(&format!("sensors/{n}.toml")));
    let sobel = root("programs/convolve/sobel.scamp");
    let [out, counts, voxels] =
        ["o.npy", "c.npy", "v.npy"].map(|name| folder.path(name).display().to_string());
    let scene = "pattern:bar?width=1536&height=1024&frames=3";
    let still = folder.write("big.png", &png(1024, 1024));
    let plane = folder.write(
        "p.npy",
        &npy("(1200, 1500)", "<f8", &vec![0; 8 * 1200 * 1500]),
    );
    let moving = folder.write("big.gif", &gif(1400, 3));
    let cases: &[&[&str]] = &[
        &["run", "--scene", scene, "--sensor", &dvs],
        &[
            "run",
            "--scene",
            scene,
            "--sensor",
            &dvs,
            "--upsample",
            "0.5",
        ],
        &["run", "--scene", scene, "--sensor", &noisy],
        &[
            "run", "--scene", scene, "--sensor", &kinds, "--format", "f32",
        ],
        &[
            "run", "--scene", scene, "--sensor", &kinds, "--counts", &counts, "--voxels", &voxels,
        ],
        &["run", "--scene", &moving, "--sensor", &dvs],
        &["exec", &sobel, "--image", scene],
        &["exec", &sobel, "--image", scene, "--domain", "q8.8"],
        &["exec", &sobel, "--image", &still, "--domain", "silicon"],
        &["mesh", "solve", "--lambda", "3", "-i", &plane, "-o", &out],
        &[
            "mesh", "step", "--lambda", "3", "--tau", "1ms", "--scene", scene, "-o", &out,
        ],
    ];
    within_two(cases, predicted);
}

/// What verbs that hold all events of a file say that they need, they need, within a factor of two:
/// of a file that says how many it has, and of one that does not.
#[test]
fn predictions_of_events_are_what_is_measured() {
    let folder = Folder::new();
    let path = |name: &str| folder.path(name).display().to_string();
    let (events, other, bare, out) = (path("a.npy"), path("b.npy"), path("a.csv"), path("o.npy"));
    let (picture, moving) = (path("p.png"), path("p.gif"));
    let scene = "pattern:noise?width=256&height=256&speed=2000&low=0&high=255&frames=16";
    let dvs = root("sensors/dvs.toml");
    for (seed, file) in [("1", &events), ("2", &other)] {
        let run = [
            "run", "--scene", scene, "--sensor", &dvs, "--seed", seed, "--events", file,
        ];
        let made = amacrine(&run, PATIENCE);
        assert_eq!(made.code, Some(0), "{}", made.errors);
    }
    let told = amacrine(&["convert", &events, &bare], PATIENCE);
    assert_eq!(told.code, Some(0), "{}", told.errors);
    let cases: &[&[&str]] = &[
        &["compare", &events, &other],
        &["compare", &events, &bare, "--size", "256x256"],
        &["packets", &events],
        &["packets", &bare, "--size", "256x256"],
        &["convert", &bare, &out, "--sort", "--size", "256x256"],
        &["show", &events, "-o", &picture],
        &["show", &events, "-o", &picture, "--view", "surface"],
        &["show", &events, "-o", &picture, "--view", "rate"],
        &["show", &events, "-o", &moving],
    ];
    within_two(cases, enough);
}

/// The memory that refusals advise in the end, in KiB.
fn enough(arguments: &[&str]) -> u64 {
    let mut most = "30M".to_owned();
    // A file that is read later may be the first for which there is no room.
    for _ in 0..3 {
        let ran = amacrine(&[arguments, &["--max-memory", &most]].concat(), PATIENCE);
        if ran.code == Some(0) {
            break;
        }
        let errors = words(&ran.errors);
        let advised = errors.rsplit("such as --max-memory ").next().unwrap();
        most = advised.split_whitespace().next().unwrap().into();
    }
    let (number, unit) = most.split_at(most.len() - 1);
    let kib = if unit == "G" { 1024.0 * 1024.0 } else { 1024.0 };
    (number.parse::<f64>().unwrap() * kib) as u64
}

/// Voxels are written window by window, into any container, however far apart events are:
/// 191 windows of 1.2 MB, most of them silent.
#[test]
fn voxels_hold_the_windows_that_overlap() {
    let folder = Folder::new();
    let mut text = String::from("t,x,y,p\n");
    for n in 0..20 {
        let _ = writeln!(
            text,
            "{},{},{},{}",
            1 + n * 100_000,
            n % 320,
            n % 240,
            n & 1
        );
    }
    let events = folder.write("events.csv", text.as_bytes());
    for name in ["v.npy", "v.npz", "v.h5"] {
        let path = folder.path(name).display().to_string();
        let arguments = ["voxels", &events, "--size", "320x240", "--window", "10ms"];
        let ran = amacrine(
            &[&arguments[..], &["--bins", "4", "-o", &path]].concat(),
            PATIENCE,
        );
        assert_eq!(ran.code, Some(0), "{name}: {}", ran.errors);
        assert!(ran.out.contains("(191, 1, 1, 4, 240, 320)"), "{}", ran.out);
        // The program alone takes about 20 MiB.
        assert!(ran.peak < 60 << 10, "{name}: {} KiB", ran.peak);
    }
    // 381 surfaces of 0.6 MB.
    let path = folder.path("s.npy").display().to_string();
    let arguments = ["voxels", &events, "--size", "320x240", "-o", &path];
    let how = ["--as", "surfaces", "--every", "5ms", "--tau", "20ms"];
    let ran = amacrine(&[&arguments[..], &how].concat(), PATIENCE);
    assert_eq!(ran.code, Some(0), "{}", ran.errors);
    assert!(ran.out.contains("(381, 1, 2, 240, 320)"), "{}", ran.out);
    assert!(ran.peak < 60 << 10, "{} KiB", ran.peak);
}

#[test]
fn arrays_beyond_the_disk_are_refused_before_the_work() {
    let folder = Folder::new();
    let events = folder.write("far.csv", b"t,x,y,p\n0,0,0,1\n1000000000000,9,9,1\n");
    for name in ["v.npy", "v.npz"] {
        let out = folder.path(name).display().to_string();
        let asked = ["voxels", &events, "-o", &out, "--size", "64x48"];
        let asked = [&asked[..], &["--window", "1us", "--bins", "1000"]].concat();
        refused(
            &asked,
            &["windows of 11.7 MiB would take", "are free", "--every"],
        );
    }
}

/// What `learn` may hold is handed over, wherever it is said; `amacrine-learn` obeys it.
#[test]
fn learning_is_handed_what_it_may_hold() {
    let built = Path::new(env!("CARGO_BIN_EXE_amacrine"));
    let folder = tempfile::tempdir_in(built.parent().unwrap()).unwrap();
    let program = folder.path().join("amacrine");
    fs::hard_link(built, &program).unwrap();
    // It tells what it is given. Written by another process: this one would hold it open for others.
    let script = "printf '#!/bin/sh\\necho \"$@\"\\n' > amacrine-learn && chmod +x amacrine-learn";
    let mut shell = Command::new("sh");
    shell.current_dir(&folder).args(["-c", script]);
    assert!(shell.status().unwrap().success());
    for (arguments, given) in [
        (
            "--max-memory 2G learn t.toml -o r",
            "--max-memory=2147483648 t.toml -o r\n",
        ),
        (
            "learn --max-memory 2G report r",
            "--max-memory=2147483648 report r\n",
        ),
        ("learn t.toml -o r", "t.toml -o r\n"),
    ] {
        let output = Command::new(&program)
            .args(arguments.split(' '))
            .output()
            .unwrap();
        assert_eq!(
            String::from_utf8_lossy(&output.stdout),
            given,
            "{arguments}"
        );
    }
}
