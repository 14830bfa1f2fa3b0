//! Every verb with small inputs, and what it writes: for tests that hold for all of them.

#![allow(dead_code)] // Each test takes what it needs.

use std::{collections::BTreeSet, fs, path::Path, process::Command};

use amacrine::{
    event::{Event, Packet, Polarity, file},
    plane::Size,
    unit::Micros,
};
use ndarray::Array3;
use ndarray_npy::write_npy;

/// A command of a verb, in a folder beside `in`.
pub struct Case {
    /// The command line behind `amacrine`.
    pub line: &'static str,
    /// Files that it writes, with commas between.
    pub writes: &'static str,
    /// It takes longer than a moment.
    pub slow: bool,
}

const fn case(line: &'static str, writes: &'static str) -> Case {
    let slow = false;
    Case { line, writes, slow }
}

const fn slow(line: &'static str, writes: &'static str) -> Case {
    let slow = true;
    Case { line, writes, slow }
}

/// At least one for each verb; `..` leads to the inputs.
pub const CASES: &[Case] = &[
    slow(
        "demo --output o",
        "o/reference.csv,o/reference.npy,o/exact.csv,o/exact.npy,o/q8.8.csv,o/q8.8.npy,o/silicon.csv,o/silicon.npy,o/row.png,o/sheet.png,o/watch.gif",
    ),
    case(
        "run --scene ../in/clip.npy --sensor ../in/sensor.toml --events e.npy --counts c.npy --voxels v.npy",
        "e.npy,c.npy,v.npy",
    ),
    slow(
        "exec ../in/words.scamp --image ../in/clip.npy --events e.csv --strip s.png",
        "e.csv,s.png",
    ),
    slow(
        "exec ../in/words.scamp --image ../in/clip.npy --dump d",
        "d/A.npy,d/A.png,d/FLAG.npy,d/FLAG.png",
    ),
    case("asm ../in/words.scamp", ""),
    case("disasm ../in/words.scamp", ""),
    case(
        "quantise ../in/k.toml --to ternary --output q.toml --picture q.png",
        "q.toml,q.png",
    ),
    case(
        "compile ../in/k.toml --threshold 16 --effort 0 -o c.scamp",
        "c.scamp",
    ),
    slow(
        "waterfall csdvs-3 --threshold 20 --to int-5 --effort 0 --scene pattern:disc?width=16&height=12&frames=4&radius=4 -o w.svg",
        "w.svg",
    ),
    case(
        "mesh solve --lambda 2 --input ../in/plane.npy --output h.npy",
        "h.npy",
    ),
    case(
        "mesh solve --lambda 2 --input ../in/plane.npy --output h.png",
        "h.png",
    ),
    case(
        "mesh step --lambda 2 --tau 1ms --scene ../in/clip.npy --output s.npy",
        "s.npy",
    ),
    case("mesh fit ../in/k.toml", ""),
    slow("mesh show --lambda 3 --output m.png", "m.png"),
    slow(
        "feasibility csdvs-3 --threshold 20 --to ternary --candidates ternary --effort 0 --scene pattern:disc?width=16&height=12&frames=4&radius=4 -o f.html",
        "f.html",
    ),
    slow(
        "design csdvs-3 --threshold 20 --to ternary --effort 0 --chips 1 --scene pattern:disc?width=16&height=12&frames=4&radius=4 -o d",
        "d/sensor.toml,d/program.scamp,d/report.html",
    ),
    case("compare ../in/events.npy ../in/events.csv", ""),
    case("convert ../in/events.npy c.csv", "c.csv"),
    case("convert ../in/events.csv c.npy", "c.npy"),
    case("convert ../in/events.npy c.npz", "c.npz"),
    case("convert ../in/events.npy c.aedat4 --kind 0", "c.aedat4"),
    case("convert ../in/events.npy c.evt3 --kind 1", "c.evt3"),
    #[cfg(feature = "hdf5")]
    case("convert ../in/events.npy c.hdf5", "c.hdf5"),
    #[cfg(feature = "parquet")]
    case("convert ../in/events.npy c.parquet", "c.parquet"),
    case(
        "convert ../in/events.npy k.csv --each-kind",
        "k.kind0.csv,k.kind1.csv",
    ),
    case(
        "packets ../in/events.npy --readout arbiter -o p.npy",
        "p.npy",
    ),
    case("plan --scene ../in/clip.npy --sensor ../in/sensor.toml", ""),
    // Its picture has times in it.
    case(
        "trade --scene ../in/clip.npy --sensor ../in/sensor.toml",
        "",
    ),
    case("voxels ../in/events.npy -o v.npy --window 50us", "v.npy"),
    case("voxels ../in/events.npy -o v.npz --window 50us", "v.npz"),
    case(
        "voxels ../in/events.npy -o s.h5 --as surfaces --every 50us --tau 80us",
        "s.h5",
    ),
    case(
        "voxels ../in/events.npy -o f.npy --as frames --count 7",
        "f.npy",
    ),
    case("show ../in/events.npy -o s.svg --view rate", "s.svg"),
    case(
        "show ../in/events.npy -o s.gif --view frame --window 50us",
        "s.gif",
    ),
    #[cfg(feature = "mcap")]
    case("show ../in/events.npy -o s.mcap --window 50us", "s.mcap"),
    slow(
        "show ../in/events.npy -o s.apng --view frame --window 50us",
        "s.apng",
    ),
    case(
        "sweep ../in/study.toml --output w --jobs 1",
        "w/sweep.json,w/results.csv,w/results.jsonl",
    ),
    case(
        "merge ../in/results --output w",
        "w/sweep.json,w/results.csv,w/results.jsonl",
    ),
    // What it hands over to is another package.
    case("learn --help", ""),
    case("report ../in/results -o r.svg", "r.svg"),
    case("schema sensor -o s.json", "s.json"),
    case("list sensors", ""),
    // It writes over nothing.
    case("new program p", ""),
    case("completions bash", ""),
    // A page for each verb.
    case("man -o m", ""),
];

pub const STUDY: &str = "scene = \"pattern:disc?width=16&height=12&frames=4&radius=4\"\nkernel = \"csdvs-5\"\nthreshold = [20, 30]\n[[side]]\nside = \"reference\"\nformat = [\"f32\", \"f64\"]\n";

pub fn amacrine(folder: &Path) -> Command {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin("amacrine"));
    command.current_dir(folder).env("NO_COLOR", "1");
    command
}

/// Two kinds of cells, so that all formats that can have something to say.
pub fn packet(channels: u8) -> Packet {
    let mut packet = Packet::new(Size::new(6, 8), channels);
    packet.span = (Micros(0), Micros(400));
    packet.events = (0..40)
        .map(|i| Event {
            t: Micros(10 * i),
            x: (i * 3 % 8) as u16,
            y: (i * 5 % 6) as u16,
            polarity: if i % 3 == 0 {
                Polarity::On
            } else {
                Polarity::Off
            },
            channel: (i % u64::from(channels)) as u8,
        })
        .collect();
    packet
}

/// Makes the folder `in` with all that the cases read.
pub fn inputs(at: &Path) {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = at.join("in");
    fs::create_dir(&folder).unwrap();
    for name in ["events.npy", "events.csv"] {
        file::write(&folder.join(name), &packet(2)).unwrap();
    }
    fs::copy(own.join("sensors/dvs.toml"), folder.join("sensor.toml")).unwrap();
    let light = |(t, y, x)| {
        if (x + 2 * t) % 8 > 3 {
            200.0
        } else {
            20.0 + y as f32
        }
    };
    write_npy(
        folder.join("clip.npy"),
        &Array3::from_shape_fn((4, 6, 8), light),
    )
    .unwrap();
    let plane = ndarray::Array2::from_shape_fn((5, 7), |(y, x)| (y * 7 + x) as f64);
    write_npy(folder.join("plane.npy"), &plane).unwrap();
    fs::write(
        folder.join("k.toml"),
        "weights = [[0.0, -1.0, 0.0], [-1.0, 4.0, -1.0], [0.0, -1.0, 0.0]]\nname = \"k\"\nsource = \"test\"\n",
    )
    .unwrap();
    let program = fs::read(own.join("programs/dvs/snap.scamp")).unwrap();
    fs::write(folder.join("words.scamp"), program).unwrap();
    fs::write(folder.join("study.toml"), STUDY).unwrap();
    let swept = amacrine(&folder)
        .args(["sweep", "study.toml", "--output", "results"])
        .output()
        .unwrap();
    assert!(swept.status.success(), "{swept:?}");
}

/// The verbs that `amacrine help` lists.
pub fn verbs(at: &Path) -> BTreeSet<String> {
    let said = amacrine(at).arg("--help").output().unwrap();
    let text = String::from_utf8(said.stdout).unwrap();
    let list = text.split("Commands:").nth(1).unwrap();
    let list = list.split("Options:").next().unwrap();
    let names = list
        .lines()
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let names = names.filter_map(|line| line.split_whitespace().next());
    names
        .filter(|name| *name != "help")
        .map(str::to_owned)
        .collect()
}

/// Every file below a folder, by its name from there.
pub fn files(folder: &Path) -> BTreeSet<String> {
    fn walk(top: &Path, at: &Path, all: &mut BTreeSet<String>) {
        for entry in fs::read_dir(at).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(top, &path, all);
            } else {
                let name = path.strip_prefix(top).unwrap();
                all.insert(name.to_string_lossy().into_owned());
            }
        }
    }
    let mut all = BTreeSet::new();
    walk(folder, folder, &mut all);
    all
}

impl Case {
    pub fn verb(&self) -> &str {
        self.line.split_whitespace().next().unwrap()
    }

    pub fn writes(&self) -> impl Iterator<Item = &'static str> {
        self.writes.split(',').filter(|name| !name.is_empty())
    }

    pub fn command(&self, folder: &Path) -> Command {
        let mut command = amacrine(folder);
        command.args(self.line.split_whitespace());
        command
    }
}
