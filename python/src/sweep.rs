//! Sweeps: the points of a study, computed once each, in a folder of results.

use std::{
    ops::ControlFlow,
    path::{Path, PathBuf},
    sync::atomic::{AtomicBool, Ordering},
    thread,
};

use amacrine::{
    memory::Budget,
    rig::guard::Warning,
    study::sweep::{
        Override, Plan, Request, Shard, Study,
        damage::set_aside,
        merge as merge_folders,
        overrides::OverrideError,
        request::Swept,
        run::ShardError,
        store::{self, Tables},
    },
};
use miette::Report;
use pyo3::prelude::*;
use serde_json::json;

use crate::{clock::thread_seconds, error::raised, files::json, pool};

/// What stands in a folder of results.
fn told(title: &str, points: usize, tables: &Tables) -> serde_json::Value {
    json!({
        "study": title,
        "points": points,
        "finished": tables.finished,
        "failed": tables.failed,
        "missing": tables.missing,
        "warnings": texts(&tables.warnings),
    })
}

fn texts(warnings: &[Warning]) -> Vec<String> {
    warnings.iter().map(ToString::to_string).collect()
}

/// Computes what is missing of a study, or of a shard of it, in a folder; the answer in JSON.
#[pyfunction]
pub fn sweep(
    py: Python<'_>,
    study: (String, String, PathBuf),
    sets: Vec<String>,
    output: PathBuf,
    shard: Option<String>,
    jobs: usize,
    max_seconds: Option<f64>,
) -> PyResult<String> {
    let (file, text, folder) = study;
    let sets = overrides(&sets)?;
    let shard: Option<Shard> = { shard.as_deref() }
        .map(|text| text.parse().map_err(|e: ShardError| raised(e)))
        .transpose()?;
    let stop = AtomicBool::new(false);
    let swept = pool::watched(py, &stop, || {
        let study = Study::parse_with(&file, &text, &sets)?;
        let how = (shard, jobs, max_seconds);
        complete(study, &folder, &output, how, &stop)
    })?;
    swept.map_err(raised).and_then(|answer| json(&answer))
}

fn complete(
    study: Study,
    folder: &Path,
    output: &Path,
    (shard, jobs, seconds): (Option<Shard>, usize, Option<f64>),
    stop: &AtomicBool,
) -> Result<serde_json::Value, Report> {
    let request = Request {
        shard,
        jobs: match jobs {
            0 => thread::available_parallelism().map_or(1, usize::from),
            jobs => jobs,
        },
        seconds,
        budget: Budget::from_machine(),
        clock: &thread_seconds,
    };
    let plan = request.plan(study, folder)?;
    let run = request.run(&plan)?;
    let done = || {
        if stop.load(Ordering::Relaxed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let Swept { did, tables } = run.sweep(output, false, |_| {}, done)?;
    let mut answer = told(&plan.manifest().title, plan.entries.len(), &tables);
    answer["computed"] = json!(did.computed);
    answer["found"] = json!(did.found);
    answer["damaged"] = json!(did.damaged);
    answer["set_aside"] = if did.damaged.is_empty() {
        json!(null)
    } else {
        json!(format!("damaged {}", set_aside(&did.damaged, output)))
    };
    answer["scene_warnings"] = json!(texts(&plan.warnings()));
    Ok(answer)
}

/// What tells a study with keys set from the file's own, in the name of its folder: the first of its
/// hash, as on the command line.
#[pyfunction]
pub fn sweep_hash(
    py: Python<'_>,
    study: (String, String, PathBuf),
    sets: Vec<String>,
) -> PyResult<String> {
    let (file, text, folder) = study;
    let sets = overrides(&sets)?;
    let hash = pool::work(py, || {
        let study = Study::parse_with(&file, &text, &sets)?;
        let plan = Plan::new(study, &folder)?;
        Ok(format!("{:.8}", plan.manifest().study))
    })?;
    hash.map_err(|report: Report| raised(report))
}

/// Keys that are set.
fn overrides(sets: &[String]) -> PyResult<Vec<Override>> {
    sets.iter()
        .map(|set| set.parse().map_err(|e: OverrideError| raised(e)))
        .collect()
}

/// What stands in a folder of results, finished or not; the answer in JSON.
#[pyfunction]
pub fn sweep_rows(py: Python<'_>, folder: PathBuf) -> PyResult<String> {
    let read = pool::work(py, || store::read(&folder))?;
    let (manifest, rows, tables) = read.map_err(raised)?;
    let mut answer = told(&manifest.title, manifest.points.len(), &tables);
    answer["columns"] = json!(manifest.columns);
    answer["rows"] = json!(rows);
    json(&answer)
}

/// Joins folders of one study into another; the answer in JSON.
#[pyfunction]
pub fn merge(py: Python<'_>, folders: Vec<PathBuf>, output: PathBuf) -> PyResult<String> {
    let merged = pool::work(py, || merge_folders(&folders, &output, false))?;
    let (manifest, tables) = merged.map_err(raised)?;
    json(&told(&manifest.title, manifest.points.len(), &tables))
}
