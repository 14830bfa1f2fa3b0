//! Several kinds of cells in one point of a study: an array of kernels is one sensor on the float
//! side and one program on the array, and what is told of it is what the other studies tell.
#![cfg(feature = "cli")]

mod common;

use std::{fs, path::Path};

use amacrine::{
    compile::{DriveMemory, Effort},
    isa::Device,
    kernel::{
        Kernel,
        quantise::{Quantiser, Sum},
    },
    rig::guard::Guard,
    scene::{OpenOptions, Scene, open},
    study::{
        design::Design,
        equivalent::{Ladder, Likeness},
        joint::{Joint, JointKind, JointOutcome},
        together::{SceneRun, Together, description, judge},
    },
    unit::Micros,
};
use common::{good, json, refused};
use serde_json::{Value, json as value};
use tempfile::TempDir;

const SCENE: &str = "pattern:noise?width=48&height=40&frames=10&fps=100&grain=4&speed=100";
const WITHIN: Micros = Micros(20_000);
const EFFORT: f64 = 0.05;

/// What studies without an array begin with.
fn floats() -> String {
    format!("scene = \"{SCENE}\"\nwithin = \"20ms\"\n")
}

/// What studies with one begin with.
fn head() -> String {
    floats() + &format!("effort = {EFFORT}\n")
}

/// What a study with this side begins with, on as many lines.
fn head_of(side: &str) -> String {
    if side.contains("array") {
        head()
    } else {
        floats() + "# no array\n"
    }
}

/// Kernels as the rows of one array.
type Rows = Vec<Vec<Vec<f64>>>;

fn two() -> Rows {
    let rows = |rows: [[f64; 3]; 3]| rows.map(|row| row.map(|w| w / 4.0).to_vec()).to_vec();
    vec![
        rows([[0.0, -1.0, 0.0], [-1.0, 4.0, -1.0], [0.0, -1.0, 0.0]]),
        rows([[-1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]]),
    ]
}

fn four() -> Rows {
    let line = [-1.0, 0.0, 2.0, 0.0, -1.0];
    let edge = [-1.0, -1.0, 0.0, 1.0, 1.0];
    let at = |weight: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
        let row = |y| (0..5).map(|x| weight(y, x) / 4.0).collect();
        (0..5).map(row).collect()
    };
    vec![
        at(&|y, x| if y == 2 { line[x] } else { 0.0 }),
        at(&|y, x| if x == 2 { line[y] } else { 0.0 }),
        at(&|y, x| if y == 2 { edge[x] } else { 0.0 }),
        at(&|y, x| if x == 2 { edge[y] } else { 0.0 }),
    ]
}

/// A `.npy` of shape (K,k,k), or (K,1,k,k) as `PyTorch` has it.
fn write(at: &Path, name: &str, kernels: &Rows, torch: bool) {
    let one = if torch { "1, " } else { "" };
    let (k, rows, columns) = (kernels.len(), kernels[0].len(), kernels[0][0].len());
    let mut header = format!(
        "{{'descr': '<f8', 'fortran_order': False, 'shape': ({k}, {one}{rows}, {columns}), }}"
    );
    while (header.len() + 11) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    let weights = kernels.iter().flatten().flatten();
    bytes.extend(weights.flat_map(|weight| weight.to_le_bytes()));
    fs::write(at.join(name), bytes).unwrap();
}

/// A folder with both arrays.
fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    write(folder.path(), "two.npy", &two(), false);
    write(folder.path(), "four.npy", &four(), true);
    folder
}

/// The rows of a study.
fn rows(at: &Path, study: &str, output: &str) -> Vec<Value> {
    let file = format!("{output}.toml");
    fs::write(at.join(&file), study).unwrap();
    good(at, &["sweep", &file, "--output", output]);
    results(at, output)
}

fn results(at: &Path, output: &str) -> Vec<Value> {
    let text = fs::read_to_string(at.join(output).join("results.jsonl")).unwrap();
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

/// The one row that has these words.
#[track_caller]
fn row<'a>(rows: &'a [Value], words: &[(&str, &str)]) -> &'a Value {
    let has = |row: &&Value| words.iter().all(|(key, word)| row[*key] == *word);
    let found: Vec<&Value> = rows.iter().filter(has).collect();
    let [one] = found[..] else {
        panic!("{} rows have {words:?}", found.len());
    };
    one
}

/// What the library says of kernels in one program, as `quantise` asks it.
struct Told {
    kinds: Vec<JointKind>,
    shown: SceneRun,
    all: Likeness,
}

impl Told {
    fn new(kernels: &Rows, thresholds: &[f64], to: &str, memory: DriveMemory) -> Self {
        let device = Device::scamp5();
        let kernels = kernels.iter().map(|rows| Kernel::from_rows(rows).unwrap());
        let kernels: Vec<Kernel> = kernels.collect();
        let floats: Vec<Design<'_>> = { kernels.iter().zip(thresholds) }
            .map(|(kernel, threshold)| Design {
                kernel,
                threshold: *threshold,
                device: &device,
                effort: Effort::seconds(EFFORT),
                seed: 0,
            })
            .collect();
        let to: Quantiser = to.parse().unwrap();
        let scene = || open(SCENE, &OpenOptions::default()).unwrap();
        let names: Vec<String> = (0..kernels.len()).map(|kind| kind.to_string()).collect();
        let joint = Joint::new(
            &names,
            &floats,
            (to, Sum::Kept, Some(memory)),
            (WITHIN, &mut *scene()),
            &mut Guard::new(),
            || (),
        );
        let JointOutcome::OnChip(chip) = joint.unwrap().outcome else {
            panic!("no program");
        };
        let levels = floats.iter().map(|float| float.quantise(to, Sum::Kept));
        let levels: Vec<_> = levels.map(Result::unwrap).collect();
        let levels: Vec<Design<'_>> = { floats.iter().zip(&levels) }
            .map(|(float, levels)| float.in_levels(levels))
            .collect();
        let together = Together::compile(&levels, "together", Some(memory));
        let together = together.unwrap().unwrap();
        let float = description(together.memory, &floats).unwrap();
        let programs = [&together.compiled];
        let shown = judge(&programs, &float, (WITHIN, 0, 1), &mut *scene(), |_| ()).unwrap();
        let fps = scene().fps();
        let ladder = Ladder::bare(shown.float.clone(), WITHIN, fps, 0).unwrap();
        Self {
            kinds: chip.kinds,
            all: ladder.judge(&shown.packets[0]).unwrap(),
            shown,
        }
    }

    /// That the rows of this memory say so, and those of the float sensor it stands for are its.
    fn holds_for(&self, all: &[Value], memory: &str, float: &[(&str, &str)]) {
        let of = |domain, readout| {
            let words = [("kept_in", memory), ("domain", domain)];
            row(all, &[&words[..], &[("readout", readout)]].concat())
        };
        let events = |row: &Value| row["events"].as_u64().unwrap() as usize;
        let silicon = of("silicon", "chip");
        let (chip, reference) = (&self.shown.packets[0].events, &self.shown.float.events);
        assert!(chip.len() > 100 && reference.len() > 100, "{memory}");
        assert_eq!(events(silicon), chip.len(), "{memory}");
        assert_eq!(silicon["reference_events"], reference.len());
        assert_eq!(silicon["kept"], value!(self.all.kept), "{memory}");
        assert_eq!(silicon["f1_20ms"], self.all.f1);
        assert_eq!(silicon["kinds"], self.kinds.len());
        // All of its events, in exact arithmetic: those of its kinds.
        let exact = of("exact", "chip");
        let own = |kind: usize| {
            let own = reference.iter().filter(|e| usize::from(e.channel) == kind);
            own.count() as f64
        };
        let ratio = |(kind, it): (usize, &JointKind)| own(kind) * it.exact.event_ratio.unwrap();
        let sum: f64 = self.kinds.iter().enumerate().map(ratio).sum();
        assert_eq!(events(exact), sum.round() as usize, "{memory}");
        // `quantise` reads every event.
        for (domain, of_kind) in [
            ("exact", (|kind| kind.exact) as fn(&JointKind) -> Likeness),
            ("silicon", |kind| kind.silicon),
        ] {
            let kept: Vec<_> = { self.kinds.iter() }
                .map(|kind| of_kind(kind).kept)
                .collect();
            let row = of(domain, "all");
            assert_eq!(
                row["kept_of_kinds"],
                value!(kept).to_string(),
                "{memory} {domain}"
            );
        }
        let float = row(all, float);
        assert_eq!(float["task"], silicon["task"], "{memory}");
        assert_eq!(
            (&float["error"], events(float)),
            (&value!(0.0), reference.len())
        );
    }
}

const SNAP: [(&str, &str); 2] = [("side", "reference"), ("rule", "filtered-snap")];
const SHARED: [(&str, &str); 2] = [("side", "reference"), ("shared", "true")];

#[test]
fn two_kinds_are_one_sensor_and_one_program() {
    let folder = folder();
    let study = format!(
        "{}kernel = \"two.npy\"\nthreshold = {{ on = [24, 30], off = [24, 30] }}\nmetrics = \"f1\"\n\
         [[side]]\nside = \"reference\"\n[[side]]\nside = \"reference\"\nmemory = \"raw-snap\"\nshared = [false, true]\n\
         [[side]]\nside = \"array\"\nquantise = \"ternary\"\nmemory = [\"analogue\", \"shared\", \"bits:4\"]\ndomain = [\"exact\", \"silicon\"]\nreadout = [\"chip\", \"all\"]\n",
        head()
    );
    let all = rows(folder.path(), &study, "out");
    assert_eq!(all.len(), 3 + 3 * 4);
    let told = |memory| Told::new(&two(), &[24.0, 30.0], "ternary", memory);
    told(DriveMemory::Analogue).holds_for(&all, "analogue", &SNAP);
    told(DriveMemory::Bits(4)).holds_for(&all, "bits:4", &SNAP);
    told(DriveMemory::Shared).holds_for(&all, "shared", &SHARED);
    // A memory of each kind is another sensor.
    let own = [("rule", "raw-snap"), ("side", "reference")];
    let own: Vec<&Value> = { all.iter() }
        .filter(|row| own.iter().all(|(key, word)| row[*key] == *word))
        .collect();
    assert_eq!(own.len(), 2);
    assert_ne!(own[0]["task"], own[1]["task"]);
    assert_ne!(own[0]["events"], own[1]["events"]);
    let bytes = |row: &Value| row["state_memory_bytes"].as_u64().unwrap();
    assert_eq!(bytes(own[0]), 2 * bytes(own[1]));
    // Other thresholds on one column of numbers, and all of them as text.
    for row in &all {
        assert_eq!(
            (&row["threshold_on"], &row["threshold_off"]),
            (&Value::Null, &Value::Null)
        );
        assert_eq!(row["threshold_sigma"], 0.0);
        let words = "{ on = [24.0, 30.0], off = [24.0, 30.0], sigma = 0.0 }";
        assert_eq!(row["thresholds"], words);
    }
    let report = json(folder.path(), &["report", "out"]);
    let names = report["groups"].to_string();
    assert!(names.contains("reference raw-snap shared f64"), "{names}");
}

/// The pixel's own sign is one more signal that a cell keeps beside a memory of drives; ON and OFF
/// steps of two sizes are counted apart.
#[test]
fn what_rules_keep_is_memory() {
    let folder = folder();
    let study = format!(
        "{}kernel = \"two.npy\"\nmetrics = \"f1\"\n\
         [[side]]\nside = \"reference\"\nthreshold = 24\nmemory = [\"filtered-snap\", \"raw-snap\"]\npolarity = [\"filtered\", \"pixel\"]\n\
         [[side]]\nside = \"reference\"\nthreshold = [24, {{ on = 24, off = 30 }}]\nmemory = \"filtered-step\"\n",
        floats()
    );
    let all = rows(folder.path(), &study, "out");
    let bytes = |rule: &str, polarity: &str, off: f64| {
        let is = |row: &&Value| {
            row["rule"] == rule && row["polarity"] == polarity && row["threshold_off"] == off
        };
        let row = all.iter().find(is).unwrap();
        row["state_memory_bytes"].as_u64().unwrap()
    };
    let kinds = 2 * 48 * 40;
    assert_eq!(bytes("filtered-snap", "filtered", 24.0), 8 * kinds);
    assert_eq!(bytes("filtered-snap", "pixel", 24.0), 16 * kinds);
    assert_eq!(bytes("raw-snap", "filtered", 24.0), 8 * kinds);
    assert_eq!(bytes("raw-snap", "pixel", 24.0), 8 * kinds);
    assert_eq!(bytes("filtered-step", "filtered", 24.0), 20 * kinds);
    assert_eq!(bytes("filtered-step", "filtered", 30.0), 28 * kinds);
}

#[test]
fn four_kinds_share_a_chip_or_are_refused() {
    let folder = folder();
    let study = format!(
        "{}kernel = \"four.npy\"\nthreshold = {{ on = [40, 44, 48, 52], off = [40, 44, 48, 52] }}\nmetrics = \"f1\"\n\
         [[side]]\nside = \"reference\"\n[[side]]\nside = \"reference\"\nmemory = \"raw-snap\"\nshared = true\n\
         [[side]]\nside = \"array\"\nquantise = \"ternary\"\nmemory = \"shared\"\ndomain = [\"exact\", \"silicon\"]\nreadout = [\"chip\", \"all\"]\n\
         [[side]]\nside = \"array\"\nquantise = \"ternary\"\nmemory = [\"analogue\", \"bits:3\"]\n",
        head()
    );
    let all = rows(folder.path(), &study, "out");
    let told = |memory| Told::new(&four(), &[40.0, 44.0, 48.0, 52.0], "ternary", memory);
    told(DriveMemory::Shared).holds_for(&all, "shared", &SHARED);
    for memory in ["analogue", "bits:3"] {
        let none = row(&all, &[("kept_in", memory)]);
        assert_eq!(none["outcome"], "refused");
        let why = none["reason"].as_str().unwrap();
        assert!(
            why.contains("4 kinds") && why.contains("6 are free"),
            "{why}"
        );
    }
    // The largest error of the four, as `quantise` tells them one by one.
    let said = json(folder.path(), &["quantise", "four.npy", "--to", "ternary"]);
    let kernels = said["kernels"].as_array().unwrap().iter();
    let errors = kernels.map(|kernel| kernel["quantised"][0]["relative_error"].as_f64().unwrap());
    let largest = errors.fold(0.0, f64::max);
    let shared = row(
        &all,
        &[
            ("kept_in", "shared"),
            ("domain", "exact"),
            ("readout", "all"),
        ],
    );
    assert_eq!(shared["quantisation_error"], largest);
}

/// Kinds with a memory each are sensors of their own: their events are those of points with one.
#[test]
fn each_kind_has_its_own_threshold() {
    let folder = folder();
    let at = folder.path();
    for (kind, kernel) in two().iter().enumerate() {
        let text = format!("name = \"k\"\nsource = \"test\"\nweights = {kernel:?}\n");
        fs::write(at.join(format!("k{kind}.toml")), text).unwrap();
    }
    let study = |kernel: &str, threshold: &str| {
        let side = "[[side]]\nside = \"reference\"\n";
        format!(
            "{}kernel = \"{kernel}\"\nthreshold = {threshold}\n{side}",
            floats()
        )
    };
    let events = |row: &Value| row["events"].as_u64().unwrap();
    let alone = [
        ("k0.toml", "{ on = 24, off = 20 }"),
        ("k1.toml", "{ on = 40, off = 50 }"),
    ];
    let alone = alone.map(|(kernel, threshold)| {
        let rows = rows(
            at,
            &study(kernel, threshold),
            &format!("alone-{}", &kernel[..2]),
        );
        assert_eq!(
            (&rows[0]["kinds"], &rows[0]["thresholds"]),
            (&value!(1), &Value::Null)
        );
        assert_eq!(rows[0]["kept_of_kinds"], Value::Null);
        events(&rows[0])
    });
    let several = "[{ on = [24, 40], off = [20, 50] }, { on = 24, off = [24, 24], sigma = [0, 0.0] }, 24, { on = [24, 24], off = 24, sigma = [0, 9] }]";
    let both = rows(at, &study("two.npy", several), "both");
    // Three that are written in two ways, or are the same.
    assert_eq!(both.len(), 3);
    assert!(alone.iter().all(|events| *events > 100), "{alone:?}");
    assert_eq!(events(&both[0]), alone[0] + alone[1]);
    assert_eq!(both[1]["threshold_on"], 24.0);
    let [same, mismatched] = [&both[1], &both[2]];
    assert_eq!(
        (&same["thresholds"], &same["seed"]),
        (&Value::Null, &Value::Null)
    );
    assert_eq!(
        (&mismatched["threshold_sigma"], &mismatched["seed"]),
        (&Value::Null, &value!(0))
    );
    let words = "{ on = 24.0, off = 24.0, sigma = [0.0, 9.0] }";
    assert_eq!(mismatched["thresholds"], words);
    // Mismatch is no other task, and another sensor of the report.
    assert_eq!(same["task"], mismatched["task"]);
    let told = good(at, &["report", "both"]);
    assert!(told.contains("sigma [0.0, 9.0]"), "{told}");
}

/// Another second kernel is another point; another shape of the array is not.
#[test]
fn every_kernel_of_an_array_counts() {
    let folder = folder();
    let at = folder.path();
    write(at, "torch.npy", &two(), true);
    let mut other = two();
    other[1][0][0] = 0.5;
    write(at, "other.npy", &other, false);
    let side = "[[side]]\nside = \"reference\"\n[[side]]\nside = \"array\"\nquantise = \"po2-3\"\n";
    let study = format!(
        "{}kernel = [\"two.npy\", \"torch.npy\", \"other.npy\"]\nthreshold = 24\n{side}",
        head()
    );
    let all = rows(at, &study, "out");
    let names: Vec<&str> = { all.iter() }
        .map(|row| row["kernel"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["two.npy", "other.npy", "two.npy", "other.npy"]);
    assert_ne!(all[0]["events"], all[1]["events"]);
    assert_ne!(all[2]["events"], all[3]["events"]);
}

#[test]
fn what_does_not_fit_the_kinds_is_refused_in_its_place() {
    let folder = folder();
    let at = folder.path();
    write(at, "many.npy", &vec![two()[0].clone(); 17], false);
    write(at, "even.npy", &vec![vec![vec![1.0; 4]; 4]; 2], false);
    let array = "[[side]]\nside = \"array\"\n";
    let reference = "[[side]]\nside = \"reference\"\n";
    let mut flat = fs::read(at.join("two.npy")).unwrap();
    let shape = flat.windows(9).position(|it| it == b"(2, 3, 3)").unwrap();
    flat[shape..shape + 9].copy_from_slice(b"(18,)    ");
    fs::write(at.join("flat.npy"), flat).unwrap();
    let cases: [(&str, &str, String, &[&str]); 9] = [
        (
            "flat.npy",
            "8",
            array.to_owned(),
            &["wrong.toml:4:10", "it has shape (18)", "(K,k,k)"],
        ),
        (
            "four.npy",
            "[8, { on = [8, 9, 7], off = 8 }]",
            array.to_owned(),
            &[
                "wrong.toml:5:17",
                "`threshold.on` has 3 numbers for 4 kinds",
                "one for each kernel",
            ],
        ),
        (
            "four.npy",
            "{ on = 8, off = 8, sigma = [1] }",
            reference.to_owned(),
            &[
                "wrong.toml:5:13",
                "`threshold.sigma` has 1 number for 4 kinds",
            ],
        ),
        (
            "dvs",
            "{ on = 8, off = [8, 8] }",
            reference.to_owned(),
            &[
                "wrong.toml:5:13",
                "`threshold.off` has 2 numbers for 1 kind",
            ],
        ),
        (
            "two.npy",
            "{ on = [8, -1], off = 8 }",
            reference.to_owned(),
            &["wrong.toml:5:24", "`threshold.on` is -1"],
        ),
        (
            "many.npy",
            "8",
            array.to_owned(),
            &[
                "wrong.toml:4:10",
                "17 kernels; 1 to 16 kernels",
                "as many as that",
            ],
        ),
        (
            "even.npy",
            "8",
            array.to_owned(),
            &["wrong.toml:4:10", "even.npy, kernel 0", "odd"],
        ),
        (
            "two.npy",
            "8",
            format!("{reference}memory = [\"raw-snap\", \"filtered-snap\"]\nshared = true\n"),
            &[
                "wrong.toml:9:10",
                "shared = true is for memory = \"raw-snap\"",
                "[[side]] of their own",
            ],
        ),
        (
            "two.npy",
            "8",
            format!("{array}memory = \"bits:9\"\n"),
            &[
                "wrong.toml:8:10",
                "`bits:9` is no memory of the array",
                "shared",
            ],
        ),
    ];
    for (kernel, threshold, side, words) in &cases {
        let text = format!(
            "{}kernel = \"{kernel}\"\nthreshold = {threshold}\n{side}",
            head_of(side)
        );
        fs::write(at.join("wrong.toml"), text).unwrap();
        refused(at, &["sweep", "wrong.toml", "--output", "out"], words);
        assert!(!at.join("out").exists(), "{words:?} left a folder");
    }
}

/// Shards, merging, verifying, and points that are asked for one by one.
#[test]
fn all_ways_to_a_point_agree() {
    let folder = folder();
    let at = folder.path();
    let study = format!(
        "{}kernel = [\"two.npy\", \"csdvs-3\"]\nthreshold = [20, 24]\n\
         [[side]]\nside = \"reference\"\nmemory = \"raw-snap\"\nshared = [false, true]\n\
         [[side]]\nside = \"array\"\nquantise = \"ternary\"\nmemory = [\"analogue\", \"shared\"]\n",
        head()
    );
    let all = rows(at, &study, "out");
    for shard in ["0/2", "1/2"] {
        let output = format!("s{}", &shard[..1]);
        good(
            at,
            &["sweep", "out.toml", "--output", &output, "--shard", shard],
        );
    }
    good(at, &["merge", "s0", "s1", "--output", "merged"]);
    let timed = ["seconds_per_frame", "frames_per_s", "events_per_s", "index"];
    let bare = |rows: Vec<Value>| -> Vec<Value> {
        let without = |mut row: Value| {
            for name in timed {
                row.as_object_mut().unwrap().remove(name);
            }
            row
        };
        rows.into_iter().map(without).collect()
    };
    let all = bare(all);
    // A program is for its thresholds.
    let programs = [("kernel", "two.npy"), ("kept_in", "analogue")];
    let programs = all
        .iter()
        .filter(|row| programs.iter().all(|(key, word)| row[*key] == *word));
    let programs: Vec<&Value> = programs.collect();
    assert_eq!(programs.len(), 2);
    assert_ne!(programs[0]["events"], programs[1]["events"]);
    assert_eq!(bare(results(at, "merged")), all);
    let written = || fs::metadata(at.join("out")).unwrap().modified().unwrap();
    let before = written();
    let said = good(
        at,
        &["sweep", "out.toml", "--output", "out", "--verify", "100%"],
    );
    assert!(said.contains("the same bits"), "{said}");
    // Not even to see whether that could be.
    assert_eq!(written(), before);
    // As the space says it.
    let space = json(at, &["sweep", "out.toml", "--space"]);
    let shared = space["sides"][0]["axes"].as_array().unwrap();
    let shared = shared.iter().find(|axis| axis["name"] == "shared").unwrap();
    assert_eq!(shared["values"], value!([false, true]));
    let tell = |point: Value| {
        let point = point.to_string();
        let mut told = bare(vec![json(at, &["sweep", "out.toml", "--point", &point])]);
        told.remove(0)
    };
    let same = |told: &Value| {
        let known = all.iter().find(|row| row["id"] == told["id"]).unwrap();
        { told.as_object().unwrap().iter() }.all(|(key, told)| known[key] == *told)
    };
    let float = value!({"side": "reference", "kernel": "two.npy", "threshold": {"on": [24, 24], "off": 24}, "shared": true});
    assert!(same(&tell(float)));
    let array = value!({"side": "array", "kernel": "two.npy", "threshold": 20, "memory": "shared"});
    assert!(same(&tell(array)));
    // One that the study does not list.
    let other = tell(
        value!({"side": "array", "kernel": "two.npy", "memory": "shared",
        "threshold": {"on": [20, 30], "off": [20, 30]}}),
    );
    let program = |row: &Value| (row["outcome"].clone(), row["events"].clone());
    assert_eq!(program(&other).0, "done");
    assert!(all.iter().all(|row| program(row) != program(&other)));
    // As it is set on the command line.
    let sets = [
        "kernel=two.npy",
        "reference.threshold={ on = [24, 24], off = 24 }",
        "reference.shared=true",
    ];
    good(
        at,
        &[&["sweep", "out.toml", "--output", "set"][..], &sets].concat(),
    );
    let set = results(at, "set");
    let mut floats = set.iter().filter(|row| row["side"] == "reference");
    assert!(floats.all(|row| all.iter().any(|known| known["id"] == row["id"])));
}

/// A plainer model stands for points of several kinds, within its limit.
#[test]
fn plain_models_stand_for_several_kinds() {
    let folder = folder();
    let at = folder.path();
    let study = "scene = \"pattern:noise?width=96&height=80&frames=16&fps=100&speed=40\"\nkernel = \"two.npy\"\nthreshold = { on = [12, 24], off = [16, 24] }\nwithin = \"5ms\"\nthreshold-equivalent = false\nreadout = \"all\"\neffort = 0.01\n\
        [[side]]\nside = \"reference\"\nformat = [\"f64\", \"f32\", \"q16.16\", \"bf16\"]\n\
        [[side]]\nside = \"array\"\nquantise = \"ternary\"\nmemory = [\"analogue\", \"shared\"]\ndomain = [\"exact\", \"q8.8\", \"silicon\"]\n";
    let full = rows(at, study, "full");
    let auto = format!("fidelity = \"auto\"\ntolerance = \"2%\"\n{study}");
    let auto = rows(at, &auto, "auto");
    assert_eq!(full.len(), auto.len());
    let (mut stood, mut itself) = (0, 0);
    for (full, auto) in full.iter().zip(&auto) {
        let name = format!("{} {} {}", auto["format"], auto["domain"], auto["kept_in"]);
        let number = |row: &Value, key: &str| row[key].as_f64().unwrap();
        assert!(number(full, "events") > 1000.0, "{name}");
        let off = (number(full, "events") - number(auto, "events")).abs();
        assert!(off <= 0.02 * number(full, "events"), "{name}: {off}");
        assert_eq!(auto["kinds"], 2);
        let left_out = auto["left_out"].as_str().unwrap_or_default();
        if left_out.is_empty() || left_out.starts_with("schedule") {
            itself += 1;
            assert_eq!(full["kept_of_kinds"], auto["kept_of_kinds"], "{name}");
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
}

/// Large kernels that differ in the middle alone are different sensors, each with a pilot.
#[test]
fn pilots_are_of_all_weights() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let kernel = |centre: f64| {
        let mut rows = vec![vec![0.0; 25]; 25];
        (rows[12][12], rows[12][13]) = (centre, -1.0);
        rows
    };
    for (name, centre) in [("a.npy", 1.0), ("b.npy", 2.0)] {
        write(at, name, &vec![kernel(centre)], false);
    }
    let side = "[[side]]\nside = \"reference\"\nformat = [\"f64\", \"f32\"]\n";
    let study = format!(
        "{}fidelity = \"auto\"\nkernel = [\"a.npy\", \"b.npy\"]\nthreshold = 20\n{side}",
        floats()
    );
    assert_eq!(rows(at, &study, "auto").len(), 4);
    assert_eq!(fs::read_dir(at.join("auto/pilots")).unwrap().count(), 2);
}

/// The example of the documentation is a study that runs.
#[test]
fn the_documented_study_of_several_kinds_runs() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/sweeps.md");
    let docs = fs::read_to_string(docs).unwrap();
    let (_, part) = docs.split_once("### Several kinds of cells").unwrap();
    let (_, study) = part.split_once("```toml\n").unwrap();
    let (study, _) = study.split_once("```").unwrap();
    let folder = folder();
    let all = rows(folder.path(), study, "kinds");
    assert!(
        part.contains(&format!("{} points", all.len())),
        "{}",
        all.len()
    );
    assert!(
        all.iter()
            .all(|row| row["kinds"] == 4 && row["outcome"] == "done")
    );
}
