//! What a search finds of a study's front, and at what share of the cost of all its points.
//!
//! ```text
//! cargo run --release --example search [STUDY.toml [COST...]]
//! ```
//!
//! Computes the whole study once, then searches it anew for each cost, a column of the report, with
//! three seeds. `studies/thousand.toml` where no study is named.

use std::{env, error::Error, fs, path::Path, time::Instant};

use amacrine::{
    memory::Budget,
    study::{
        front::Cost,
        sweep::{Request, Study, run::Did, survivors::hypervolume},
    },
};
use serde_json::Value;

type Done<T> = Result<T, Box<dyn Error>>;

const SEEDS: u64 = 3;

fn main() -> Done<()> {
    let mut words = env::args().skip(1);
    let study = words.next();
    let study = study.as_deref().unwrap_or("studies/thousand.toml");
    let mut costs: Vec<String> = words.collect();
    if costs.is_empty() {
        costs = ["bits", "state_memory_bytes", "seconds_per_frame"]
            .map(str::to_owned)
            .into();
    }
    let work = tempfile::tempdir()?;
    let grid = Swept::new(study, &[], &work.path().join("grid"))?;
    println!(
        "{study}: {} points in {:.0} s\n",
        grid.rows.len(),
        grid.seconds
    );
    println!("| cost | seed | points seen whole | point-frames | seconds | hypervolume |");
    println!("|---|---|---|---|---|---|");
    for cost in &costs {
        for seed in 0..SEEDS {
            let sets = [
                r#"sample.method="search""#.to_owned(),
                "sample.points=65536".to_owned(),
                format!("sample.cost={cost:?}"),
                format!("sample.seed={seed}"),
            ];
            let output = work.path().join(format!("{cost}-{seed}"));
            let found = Swept::new(study, &sets, &output)?;
            let search = found.did.search.as_ref().ok_or("no search was made")?;
            println!(
                "| {cost} | {seed} | {} | {:.1} % | {:.1} % | {:.1} % |",
                found.rows.len(),
                100.0 * search.point_frames / search.of,
                100.0 * found.seconds / grid.seconds,
                100.0 * share(&found.rows, &grid.rows, cost),
            );
        }
    }
    Ok(())
}

/// A folder of results, and how long it took.
struct Swept {
    did: Did,
    rows: Vec<Value>,
    seconds: f64,
}

impl Swept {
    fn new(path: &str, sets: &[String], output: &Path) -> Done<Self> {
        let text = fs::read_to_string(path).map_err(|cause| format!("{path}: {cause}"))?;
        let sets = sets
            .iter()
            .map(|set| set.parse())
            .collect::<Result<Vec<_>, _>>()?;
        let study = Study::parse_with(path, &text, &sets)?;
        let begin = Instant::now();
        let clock = move || begin.elapsed().as_secs_f64();
        let request = Request {
            shard: None,
            jobs: std::thread::available_parallelism()?.get(),
            seconds: None,
            budget: Budget::from_machine(),
            clock: &clock,
        };
        let plan = request.plan(study, Path::new(path).parent().unwrap_or(Path::new("")))?;
        let run = request.run(&plan)?;
        let swept = run.sweep(
            output,
            false,
            |_| {},
            || std::ops::ControlFlow::Continue(()),
        )?;
        let seconds = begin.elapsed().as_secs_f64();
        let lines = fs::read_to_string(output.join("results.jsonl"))?;
        let rows = lines
            .lines()
            .map(serde_json::from_str)
            .collect::<Result<_, _>>()?;
        Ok(Self {
            did: swept.did,
            rows,
            seconds,
        })
    }
}

/// The share of the hypervolume of all points that those found have: in the report's error and the
/// same measurement of the cost, that of the whole study.
fn share(found: &[Value], all: &[Value], cost: &str) -> f64 {
    let of = |row: &Value| {
        let (x, y) = (row[cost].as_f64()?, row["error"].as_f64()?);
        Some(Cost { x, y })
    };
    let is_found = |row: &&Value| found.iter().any(|other| other["id"] == row["id"]);
    let grid: Vec<Cost> = all.iter().filter_map(of).collect();
    let found: Vec<Cost> = all.iter().filter(is_found).filter_map(of).collect();
    let corner = grid
        .iter()
        .fold(Cost { x: 0.0, y: 0.0 }, |corner, cost| Cost {
            x: corner.x.max(1.05 * cost.x),
            y: corner.y.max(1.05 * cost.y),
        });
    hypervolume(&found, corner) / hypervolume(&grid, corner)
}
