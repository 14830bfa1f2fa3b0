//! `amacrine sweep`: the points of a study, computed once each.

use std::{
    fmt::Write as _,
    path::{Path, PathBuf},
    thread,
    time::Instant,
};

use miette::miette;
use serde_json::json;

use super::progress::Progress;
use crate::source;
use crate::study::sweep::{Plan, Shard, Store, Study, run as run_points, run::Did, schema};

/// What `sweep` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  amacrine sweep studies/formats.toml --output out/formats\n  amacrine sweep studies/formats.toml --output out/shard-0 --shard 0/4\n\nA folder that exists is gone on with: what is finished is not computed again. docs/sweeps.md lists every key and every column."
)]
pub struct Arguments {
    /// The study file
    #[arg(required_unless_present = "schema")]
    study: Option<PathBuf>,
    /// The folder of results; the study's name without its ending when left out
    #[arg(long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Compute only the points whose number leaves i when divided by n
    #[arg(long, value_name = "i/n", value_parser = shard)]
    shard: Option<Shard>,
    /// How many points at a time, each on one thread; as many as there are cores when left out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// Also write results.parquet
    #[arg(long)]
    parquet: bool,
    /// Print the JSON Schema of study files, and do nothing else
    #[arg(long)]
    schema: bool,
    /// Print one JSON object instead of the table
    #[arg(long)]
    json: bool,
}

/// A shard, for the command line, which shows no help beside a message.
fn shard(text: &str) -> Result<Shard, String> {
    text.parse()
        .map_err(|e| format!("{e}: give i/n with i from 0 to n - 1, such as 0/4, 1/4, 2/4 and 3/4"))
}

/// `--parquet` without the feature is refused before anything is computed.
pub(super) fn check_parquet(asked: bool) -> miette::Result<()> {
    if asked && cfg!(not(feature = "parquet")) {
        return Err(miette!(
            help = "build with --features parquet, or take results.csv or results.jsonl",
            "this amacrine was built without Parquet"
        ));
    }
    Ok(())
}

/// Runs the verb.
///
/// # Errors
/// When the study is not what it should be, or the folder does not take its results.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let Some(path) = arguments.study.as_ref().filter(|_| !arguments.schema) else {
        let text = serde_json::to_string_pretty(&schema::json_schema());
        super::say(&format!("{}\n", text.unwrap_or_default()));
        return Ok(());
    };
    check_parquet(arguments.parquet)?;
    let shown = path.display().to_string();
    let text = source::text(path, "give a study file; studies/ has some to start from")?;
    let study = Study::parse(&shown, &text)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let plan = Plan::new(study, folder)?;
    let output = match &arguments.output {
        Some(output) => output.clone(),
        None => PathBuf::from(path.file_stem().unwrap_or(path.as_os_str())),
    };
    let manifest = plan.manifest();
    let store = Store::open(&output, &manifest)?;
    let jobs = match arguments.jobs {
        Some(jobs) => jobs.into(),
        None => thread::available_parallelism().map_or(1, usize::from),
    };
    let start = Instant::now();
    let clock = || start.elapsed().as_secs_f64();
    let progress = std::sync::OnceLock::new();
    let did = run_points(
        &plan,
        &store,
        arguments.shard,
        jobs,
        &clock,
        |left| {
            progress.get_or_init(|| Progress::new("sweeping", Some(left)));
        },
        || {
            if let Some(progress) = progress.get() {
                progress.tick();
            }
        },
    )?;
    if let Some(progress) = progress.get() {
        progress.finish();
    }
    let finished = store.write_tables(arguments.parquet)?;
    let said = Said {
        plan: &plan,
        output: &output,
        did,
        finished,
        jobs,
        seconds: clock(),
        shard: arguments.shard,
    };
    super::say(&if arguments.json {
        said.json()
    } else {
        said.table()
    });
    Ok(())
}

struct Said<'a> {
    plan: &'a Plan,
    output: &'a Path,
    did: Did,
    finished: usize,
    jobs: usize,
    seconds: f64,
    shard: Option<Shard>,
}

impl Said<'_> {
    fn json(&self) -> String {
        let all = self.plan.entries.len();
        let said = json!({
            "study": self.plan.study.title,
            "output": self.output,
            "named": self.plan.named,
            "points": all,
            "computed": self.did.computed,
            "found": self.did.found,
            "finished": self.finished,
            "missing": all - self.finished,
            "jobs": self.jobs,
            "seconds": self.seconds,
        });
        format!("{said}\n")
    }

    fn table(&self) -> String {
        let all = self.plan.entries.len();
        let same = match self.plan.named - all as u64 {
            0 => String::new(),
            1 => ", of which one is named twice and computed once".to_owned(),
            same => format!(", {same} more that are the same as others"),
        };
        let mut text = format!("study    {}\npoints   {all}{same}\n", self.plan.study.title);
        if let Some(Shard { index, of }) = self.shard {
            let _ = writeln!(
                text,
                "shard    {index}/{of}: {} of them",
                self.did.computed + self.did.found
            );
        }
        let _ = writeln!(
            text,
            "computed {} in {:.1} s on {} threads, {} were there already",
            self.did.computed, self.seconds, self.jobs, self.did.found
        );
        if self.finished < all {
            let _ = writeln!(
                text,
                "missing  {} of {all}: the other shards, or run again",
                all - self.finished
            );
        }
        let output = self.output.display();
        let _ = write!(
            text,
            "wrote    {output}/results.csv and results.jsonl, {} rows\nnext     amacrine report {output}\n",
            self.finished
        );
        text
    }
}
