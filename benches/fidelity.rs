//! What `--fidelity auto` is worth in whole commands, `run` and `exec`: the full model beside what a
//! pilot chooses. `examples/fidelity.rs` asks the library the same.
//!
//! ```text
//! cargo bench --bench fidelity            # all of it, a quarter of an hour
//! cargo bench --bench fidelity -- dvs     # commands with this word
//! ```
//!
//! Times are those of the wall, from the program's start to its end, each the median of some runs,
//! the full and the chosen model in turn. The last column says whether the chosen one is slower than
//! 1.05 times the full one and a tenth of a second. `AMACRINE_BENCH=quick` runs each once.

#[allow(dead_code)] // Full and chosen models are timed in turn.
#[path = "common/timed.rs"]
mod timed;

use std::{error::Error, path::Path, process::Command, time::Instant};

use amacrine::{
    event::{Packet, file},
    study::pilot::Change,
    unit::Micros,
};
use serde_json::Value;

use crate::timed::Timed;

const PATTERN: &str = "pattern:noise?width=256&height=256&frames=400&fps=1000&speed=300";
const SENSORS: [&str; 8] = [
    "dvs",
    "dvs-v2e",
    "csdvs",
    "dog",
    "rgc",
    "rgc-4",
    "orientation",
    "csdvs-mesh",
];
/// Of three sensors with inserted frames: two of a linear response, one of another.
const UPSAMPLED: [&str; 3] = ["laplacian", "csdvs", "dvs-v2e"];
const PROGRAMS: [&str; 2] = ["dvs/snap", "rgc/centre_surround"];
const DOMAINS: [&str; 3] = ["silicon", "f16", "q8.8"];

type Done<T> = Result<T, Box<dyn Error>>;

/// A command without `--fidelity`, its name in the table, and how often it is timed.
struct Case {
    words: Vec<String>,
    name: String,
    pairs: usize,
}

impl Case {
    fn new(words: &[&str], name: String) -> Self {
        let words = words.iter().map(|word| (*word).to_owned()).collect();
        let pairs = match std::env::var("AMACRINE_BENCH").as_deref() {
            Ok("quick") => 1,
            _ => 5,
        };
        Self { words, name, pairs }
    }

    /// Runs it, and gives what it prints as JSON.
    fn run(&self, auto: bool, events: Option<&Path>) -> Done<Value> {
        let mut command = Command::new(env!("CARGO_BIN_EXE_amacrine"));
        command.args(&self.words).arg("--json");
        if auto {
            command.args(["--fidelity", "auto", "--tolerance", "1%"]);
        }
        if let Some(path) = events {
            command.arg("--events").arg(path);
        }
        let out = command.output()?;
        if !out.status.success() {
            return Err(format!("{}: {}", self.name, String::from_utf8_lossy(&out.stderr)).into());
        }
        Ok(serde_json::from_slice(&out.stdout)?)
    }

    /// The seconds of a run.
    fn seconds(&self, auto: bool) -> Done<f64> {
        let start = Instant::now();
        self.run(auto, None)?;
        Ok(start.elapsed().as_secs_f64())
    }

    fn row(&self, folder: &Path) -> Done<()> {
        let (mut full_s, mut auto_s) = (Vec::new(), Vec::new());
        for _ in 0..self.pairs {
            full_s.push(self.seconds(false)?);
            auto_s.push(self.seconds(true)?);
        }
        let (full_s, auto_s) = (Timed::from_seconds(full_s), Timed::from_seconds(auto_s));
        let [full, plain] = ["full.npy", "auto.npy"].map(|name| folder.join(name));
        self.run(false, Some(&full))?;
        let fidelity = self.run(true, Some(&plain))?["fidelity"].take();
        let change = Change::between(&packet(&full)?, &packet(&plain)?, Micros(100))?;
        let is_held = auto_s.median <= 1.05 * full_s.median + 0.1;
        println!(
            "| {} | {:.2} s {} | {:.2} s {} | {:.2} | {:.4} % | {} | {} | {} |",
            self.name,
            full_s.median,
            full_s.plus_minus(),
            auto_s.median,
            auto_s.plus_minus(),
            full_s.median / auto_s.median,
            100.0 * change.share,
            limit(&fidelity),
            ran(&fidelity),
            if is_held { "held" } else { "slower" }
        );
        Ok(())
    }
}

fn packet(path: &Path) -> Done<Packet> {
    Ok(file::read(path)?.packet)
}

/// The limit that allowed the choice.
fn limit(fidelity: &Value) -> String {
    let is_free = fidelity["free"]
        .as_array()
        .is_some_and(|free| !free.is_empty());
    match fidelity["change"]["limit"].as_f64() {
        Some(limit) if is_plainer(fidelity) => format!("{:.3} %", 100.0 * limit),
        _ if is_free => "free".to_owned(),
        _ => "-".to_owned(),
    }
}

/// Whether anything but what is free was left out.
fn is_plainer(fidelity: &Value) -> bool {
    let offers = fidelity["offers"].as_array();
    offers.is_some_and(|offers| offers.iter().any(|offer| offer["left_out"] == true))
}

/// The model that ran.
fn ran(fidelity: &Value) -> String {
    let choice = &fidelity["choice"];
    let format = choice["format"].as_str().unwrap_or("silicon");
    let without = choice["without"].as_array();
    let without = without.into_iter().flatten().filter_map(Value::as_str);
    let without: Vec<&str> = without.collect();
    if without.is_empty() {
        format.to_owned()
    } else {
        format!("{format}, without {}", without.join(", "))
    }
}

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let short = |clip: &str| clip.split('?').next().unwrap_or(clip).to_owned();
    for clip in ["bundled", PATTERN] {
        for sensor in SENSORS {
            let words = ["run", "--scene", clip, "--sensor", sensor];
            cases.push(Case::new(&words, format!("{} | {sensor}", short(clip))));
        }
    }
    for sensor in UPSAMPLED {
        let words = [
            "run",
            "--scene",
            "bundled",
            "--sensor",
            sensor,
            "--upsample",
            "0.2",
        ];
        cases.push(Case::new(&words, format!("bundled, upsampled | {sensor}")));
    }
    for clip in ["bundled", PATTERN] {
        for program in PROGRAMS {
            for domain in DOMAINS {
                let words = ["exec", program, "--scene", clip, "--domain", domain];
                cases.push(Case::new(
                    &words,
                    format!("{} | {program}, {domain}", short(clip)),
                ));
            }
        }
    }
    cases
}

fn main() -> Done<()> {
    let asked: Vec<String> = std::env::args()
        .skip(1)
        .filter(|word| !word.starts_with('-'))
        .collect();
    let folder = tempfile::tempdir()?;
    println!("{}\n", timed::cpu());
    println!(
        "| scene | sensor | full | auto | times as fast | change | limit | what ran | 1.05 times |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for case in cases() {
        let is_asked = |word: &String| case.words.contains(word);
        if asked.is_empty() || asked.iter().any(is_asked) {
            case.row(folder.path())?;
        }
    }
    Ok(())
}
