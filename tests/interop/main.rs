//! The field's own readers read what we write and agree event by event, and what their
//! writers write we read: `readers.py` and `writers.py`, with the packages of
//! `requirements.txt`. Cases: twenty thousand events with ties and vectors, none, one, turns
//! of every clock, and ten million where the reader is fast. The lines of Python that
//! `docs/formats.md` has are run as well.

use std::{fmt::Write, fs, path::Path, process::Command};

use amacrine::{
    event::{
        Event, Packet, Polarity,
        file::{self, Compression, Format, Opening},
        tensor::{Container, Layers, Precision, TensorFile},
    },
    plane::Size,
    unit::Micros,
};

const SIZE: Size = Size::new(260, 346);

fn event(t: u64, h: u64) -> Event {
    Event {
        t: Micros(t),
        x: (h % 346) as u16,
        y: (h / 346 % 260) as u16,
        polarity: if h >> 40 & 1 == 1 {
            Polarity::On
        } else {
            Polarity::Off
        },
        channel: 0,
    }
}

fn hash(i: u64) -> u64 {
    (i ^ i >> 7).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 20
}

fn packet(events: Vec<Event>) -> Packet {
    let mut packet = Packet::new(SIZE, 1);
    packet.span = (Micros(0), events.last().map_or(Micros(1), |e| e.t));
    packet.events = events;
    packet
}

/// Single events and runs along rows, `count` in all.
fn mixed(count: u64) -> Vec<Event> {
    let mut t = 5;
    let mut events = Vec::new();
    while (events.len() as u64) < count {
        let h = hash(events.len() as u64);
        t += h >> 30 & 0xFF;
        let first = event(t, h);
        let run = if h.is_multiple_of(4) { 1 } else { 2 + h % 19 };
        for i in 0..run.min(count - events.len() as u64) {
            let x = u64::from(first.x) + i * (1 + (h >> 50 & 1));
            if x < SIZE.width as u64 {
                events.push(Event {
                    x: x as u16,
                    ..first
                });
            }
        }
    }
    events
}

/// Events around each turn of the clocks that `format` has.
fn turning(format: Format) -> Option<Vec<Event>> {
    let bits: &[u32] = match format {
        Format::Evt2 | Format::Evt21 => &[24, 34],
        Format::Evt3 | Format::Es => &[24],
        Format::Dat => &[31],
        Format::Aedat3 => &[31, 33],
        Format::Aedat4 | Format::Npz => &[31, 32, 40],
        _ => return None,
    };
    let around = bits.iter().flat_map(|bits| {
        let turn = 1_u64 << bits;
        [
            turn - 4097,
            turn - 65,
            turn - 1,
            turn,
            turn + 1,
            turn + 64,
            turn + 5000,
        ]
    });
    let mut times: Vec<u64> = around.collect();
    if format == Format::Evt3 {
        // Twice around, and a long silence.
        times.extend([
            (2 << 24) - 1,
            2 << 24,
            (2 << 24) + 17,
            (9 << 24) + 4095,
            10 << 24,
        ]);
    }
    times.sort_unstable();
    Some(
        times
            .into_iter()
            .enumerate()
            .map(|(i, t)| event(t, hash(i as u64)))
            .collect(),
    )
}

/// `a.evt3.raw`, since some readers go by the extension.
fn name(format: Format) -> String {
    match format.extension() {
        extension if extension == format.name() => format!("a.{format}"),
        extension => format!("a.{format}.{extension}"),
    }
}

fn python(script: &str, folder: &Path) -> String {
    let out = Command::new("python3")
        .arg(Path::new("tests/interop").join(script))
        .arg(folder)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .output()
        .unwrap();
    let (said, error) = (
        String::from_utf8_lossy(&out.stdout),
        String::from_utf8_lossy(&out.stderr),
    );
    assert!(out.status.success(), "{said}{error}");
    said.into_owned()
}

#[test]
#[ignore = "needs Python with the packages of tests/interop/requirements.txt; run by name in .ci/run"]
fn they_read_what_we_write() {
    let folder = tempfile::tempdir().unwrap();
    let mut cases = vec![
        ("mixed", packet(mixed(20_000)), None),
        ("empty", packet(Vec::new()), None),
        ("one", packet(mixed(1)), None),
    ];
    for &format in Format::ALL {
        if let Some(events) = turning(format) {
            cases.push(("wrap", packet(events), Some(format)));
        }
    }
    // A recording that begins after some seconds, and one with times of the day.
    for (case, begins) in [("begun", 5_012_345), ("late", 1_700_000_000_000_000)] {
        let mut events = mixed(20_000);
        for event in &mut events {
            event.t.0 += begins;
        }
        cases.push((case, packet(events), Some(Format::Hdf5)));
    }
    for format in [Format::Evt2, Format::Evt3, Format::Dat, Format::Aedat4] {
        cases.push(("many", packet(mixed(10_000_000)), Some(format)));
    }
    let mut lines = String::new();
    let mut wanted = Vec::new();
    for (case, packet, only) in &cases {
        let inside = match only {
            Some(format) => folder.path().join(format!("{case}-{format}")),
            None => folder.path().join(case),
        };
        fs::create_dir_all(&inside).unwrap();
        file::write(&inside.join("reference.npy"), packet).unwrap();
        for &format in Format::ALL.iter().filter(|f| f.is_built()) {
            if only.is_some_and(|only| only != format) {
                continue;
            }
            let path = inside.join(name(format));
            file::write_as(&path, format, Compression::Lz4, packet).unwrap();
            wanted.push(format!("agrees {format} "));
            if *case == "mixed" {
                let _ = writeln!(lines, "{}", format.opened_by(&path));
            }
        }
        if only.is_none() {
            for kind in [Compression::Zstd, Compression::None] {
                let path = inside.join(format!("a.aedat4-{}.aedat4", kind.name()));
                file::write_as(&path, Format::Aedat4, kind, packet).unwrap();
            }
        }
    }
    fs::write(folder.path().join("lines.txt"), lines).unwrap();
    let said = python("readers.py", folder.path());
    println!("{said}");
    for agrees in wanted {
        assert!(said.contains(&agrees), "nobody said `{agrees}`");
    }
    let opened = said.lines().filter(|l| l.starts_with("opens ")).count();
    assert_eq!(opened, Format::ALL.iter().filter(|f| f.is_built()).count());
}

#[cfg(feature = "mcap")]
#[test]
#[ignore = "needs Python with the packages of tests/interop/requirements.txt; run by name in .ci/run"]
fn viewers_read_our_recordings() {
    let folder = tempfile::tempdir().unwrap();
    let mut all = packet(mixed(20_000));
    all.channels = 2;
    all.names = vec!["centre on".to_owned(), "edges".to_owned()];
    for (i, event) in all.events.iter_mut().enumerate() {
        event.channel = u8::from(i % 3 == 0);
    }
    file::write(&folder.path().join("reference.npy"), &all).unwrap();
    let path = folder.path().join("a.mcap");
    let window = Micros(100_000);
    amacrine::picture::view::mcap::write(&path, &all, window).unwrap();
    let said = python("recording.py", folder.path());
    assert_eq!(said.matches("agrees").count(), 2, "{said}");
}

/// Voxels in HDF5, which are laid out by hand, by the reference library: more windows than a page
/// of its own index has, numbers of 32 and of 16 bits.
#[test]
#[ignore = "needs Python with the packages of tests/interop/requirements.txt; run by name in .ci/run"]
fn h5py_reads_our_voxels() {
    let folder = tempfile::tempdir().unwrap();
    let shape = vec![2, 1, 3, 4, 70];
    let each: usize = shape.iter().product();
    for (name, precision) in [("a", Precision::Single), ("b", Precision::Half)] {
        let of = |name: String| folder.path().join(name);
        let files = [("npy", Container::Npy), ("h5", Container::Hdf5)];
        for (ending, container) in files {
            let layers = Layers {
                name: "voxels",
                shape: shape.clone(),
                precision,
                kinds: vec!["centre-on".to_owned(), "kind é".to_owned()],
            };
            let path = of(format!("{name}.{ending}"));
            let mut file = TensorFile::create(&path, container, layers).unwrap();
            for n in 0..1_500_u64 {
                let layer: Vec<f32> = (0..each as u64)
                    .map(|i| (hash(n * each as u64 + i) % 64) as f32 / 8.0)
                    .collect();
                file.push(&layer).unwrap();
            }
            file.finish().unwrap();
        }
    }
    let said = python("voxels.py", folder.path());
    assert_eq!(said.matches("agrees").count(), 2, "{said}");
}

#[test]
#[ignore = "needs Python with the packages of tests/interop/requirements.txt; run by name in .ci/run"]
fn we_read_what_they_write() {
    let folder = tempfile::tempdir().unwrap();
    let packet = packet(mixed(20_000));
    file::write(&folder.path().join("reference.npy"), &packet).unwrap();
    python("writers.py", folder.path());
    let mut read = 0;
    for entry in fs::read_dir(folder.path().join("theirs")).unwrap() {
        let path = entry.unwrap().path();
        let stream = path.ends_with("mvsec.h5").then_some(0);
        let how = Opening {
            stream,
            ..Opening::default()
        };
        let loaded = file::read_as(&path, &how)
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let mut wanted = packet.events.clone();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if name == "faery.es" {
            // Rows from the bottom.
            for e in &mut wanted {
                e.y = 259 - e.y;
            }
        }
        assert_eq!(loaded.packet.events.len(), wanted.len(), "{name}");
        let mut pairs = loaded.packet.events.iter().zip(&wanted);
        assert_eq!(pairs.find(|(a, b)| a != b), None, "{name}");
        read += 1;
    }
    assert_eq!(read, 17, "files of others");
}

/// The example of ask and tell runs with Optuna, and its front is one of rows of a sweep.
#[cfg(feature = "cli")]
#[test]
#[ignore = "needs Python with the packages of tests/interop/requirements.txt; run by name in .ci/run"]
fn optuna_searches_a_study() {
    let folder = tempfile::tempdir().unwrap();
    let study = "scene = \"pattern:noise?width=48&height=40&frames=8&fps=100&speed=40\"\nkernel = \"csdvs-3\"\nthreshold = { from = 8, to = 32 }\nthreshold-equivalent = false\n[[side]]\nside = \"reference\"\nformat = [\"f64\", \"f32\", \"q8.8\"]\nrefractory = [{ us = 0 }, { us = 2000 }]\n";
    let study = format!("sample = {{ method = \"sobol\", points = 4 }}\n{study}");
    fs::write(folder.path().join("study.toml"), study).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/optuna/search.py");
    let said = Command::new("python3")
        .arg(&script)
        .args(["study.toml", "--trials", "12", "--program"])
        .arg(assert_cmd::cargo::cargo_bin("amacrine"))
        .current_dir(folder.path())
        .output()
        .unwrap();
    let errors = String::from_utf8_lossy(&said.stderr);
    assert!(said.status.success(), "{errors}");
    let nowhere = Command::new("python3")
        .arg(script)
        .args(["study.toml", "--program", "nowhere/amacrine"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let errors = String::from_utf8(nowhere.stderr).unwrap();
    assert!(!nowhere.status.success());
    assert_eq!(errors.lines().count(), 1, "{errors}");
    assert!(errors.contains("nowhere/amacrine") && errors.contains("give --program PATH"));
    let text = String::from_utf8(said.stdout).unwrap();
    let front: Vec<[f64; 2]> = { text.lines().skip(1) }
        .map(|line| {
            let mut numbers = line.split_whitespace().map(|word| word.parse().unwrap());
            [numbers.next().unwrap(), numbers.next().unwrap()]
        })
        .collect();
    assert!(!front.is_empty(), "{text}");
    for pair in front.windows(2) {
        assert!(
            pair[0][0] <= pair[1][0] && pair[0][1] >= pair[1][1],
            "{text}"
        );
    }
}
