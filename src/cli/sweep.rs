//! `amacrine sweep`: the points of a study, computed once each.

use std::{
    fmt::Write as _,
    io::{self, BufRead as _, Read as _},
    ops::ControlFlow,
    path::{Path, PathBuf},
    sync::OnceLock,
    time::Instant,
};

use miette::miette;
use serde_json::json;

use super::{
    arguments::{budget, heading, light},
    list::{bundled, meant},
    output::{
        command_line::quoted,
        content::Content,
        files::{Input, Output},
        progress::Progress,
        thread_clock::thread_seconds,
    },
};
use crate::{
    bundled::Kind,
    limit::POINT_BYTES,
    memory::Need,
    source,
    study::sweep::{
        Asked, Limits, Override, Plan, Request, Shard, Study,
        ask::{self, PointError},
        damage::{listed, set_aside},
        request::Swept,
        run::{Did, Failed},
        schema,
        search::{Rung, Searched},
        store::Tables,
        verify::{Share, Verified},
    },
    unit::counted,
};

/// What `sweep` is asked to do.
#[expect(clippy::struct_excessive_bools, reason = "each is a flag of its own")]
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  amacrine sweep formats --output out/formats\n  amacrine sweep formats --output out/shard-0 --shard 0/4\n  amacrine sweep formats --output out/formats --verify 5%\n  amacrine sweep formats format=f32,q8.8 array.domain=silicon --output out/other\n  amacrine sweep formats --space\n  amacrine sweep formats --point '{\"side\": \"reference\", \"format\": \"q8.8\"}'\n\nA sweep into a folder that exists goes on where it stopped: finished points are not computed again. Damaged files are named, set aside and computed again. docs/sweeps.md lists every key and every column."
)]
pub struct Arguments {
    /// Study file, or a name that `amacrine list studies` prints
    #[arg(required_unless_present = "schema")]
    study: Option<Input>,
    /// Key of the study to set; may be repeated
    ///
    /// Such as format=f32,q8.8, sample.points=64 or array.domain=exact.
    #[arg(value_name = "KEY=VALUE", value_parser = set)]
    sets: Vec<Override>,
    /// Folder of the results
    ///
    /// Default: the name of the study without its ending; if keys are set, with eight letters of the
    /// hash of the study behind it.
    #[arg(short, long, value_name = "DIR", value_parser = Content::Folder)]
    output: Option<Output>,
    /// Shard to compute: the points whose number leaves a remainder of i when divided by n
    #[arg(long, value_name = "i/n", value_parser = shard)]
    shard: Option<Shard>,
    /// Number of points at a time, each on one thread [default: as many as there are cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// Seconds that a sensor may take to watch its scene
    ///
    /// A point that takes longer is given up. It becomes a row with its reason, and the next run
    /// computes it again.
    #[arg(long, value_name = "S", value_parser = seconds)]
    max_seconds_per_point: Option<f64>,
    /// Compute a share of the finished points again, and compare the bits
    ///
    /// Nothing is written. Excludes --parquet.
    #[arg(long, value_name = "N%", value_parser = share, conflicts_with = "parquet")]
    verify: Option<Share>,
    /// Seed of the choice of points for --verify
    #[arg(long, value_name = "N", default_value_t = 0, requires = "verify")]
    verify_seed: u64,
    /// Write results.parquet, too
    #[arg(long)]
    parquet: bool,
    /// Print the space of the study as JSON, and do nothing else
    ///
    /// This is for the search of another tool.
    #[arg(long, conflicts_with_all = ["output", "shard", "verify", "parquet"], help_heading = heading::POINTS)]
    space: bool,
    /// Compute this point of the space, and print its row as a JSON line; may be repeated
    ///
    /// No folder is written.
    #[arg(long = "point", value_name = "JSON", conflicts_with_all = ["output", "shard", "verify", "parquet", "space"], help_heading = heading::POINTS)]
    points: Vec<PointText>,
    /// Compute each point of standard input, a JSON line each, and answer each at once
    #[arg(long, conflicts_with_all = ["output", "shard", "verify", "parquet", "space", "points"], help_heading = heading::POINTS)]
    tell: bool,
    /// Print the JSON Schema of study files, and do nothing else
    #[arg(long, conflicts_with_all = ["study", "sets", "output", "shard", "jobs", "max_seconds_per_point", "verify", "parquet", "space", "points", "tell"])]
    schema: bool,
    /// Print JSON in place of text
    #[arg(long)]
    json: bool,
}

/// A point of a study, as JSON.
#[derive(Clone, Debug)]
struct PointText(String);

impl From<String> for PointText {
    fn from(text: String) -> Self {
        Self(text)
    }
}

/// A key that is set, for the command line.
fn set(text: &str) -> Result<Override, String> {
    let help = "give key=value or key=a,b, such as format=f32,q8.8, sample.points=64 or array.domain=exact";
    text.parse().map_err(|error| format!("{error}: {help}"))
}

/// A shard, for the command line, which shows no help beside a message.
fn shard(text: &str) -> Result<Shard, String> {
    text.parse()
        .map_err(|e| format!("{e}: give i/n with i from 0 to n - 1, such as 0/4, 1/4, 2/4 and 3/4"))
}

/// A share, for the command line.
fn share(text: &str) -> Result<Share, String> {
    text.parse()
        .map_err(|e| format!("{e}: give percent, above 0 and up to 100, such as 5%"))
}

/// Seconds above zero.
fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|s| *s > 0.0 && *s < f64::INFINITY);
    seconds.ok_or_else(|| format!("`{text}` is no time: give seconds above 0, such as 60"))
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
/// When the study is not what it should be, the folder does not take its results, or what was
/// computed again is not what the folder says.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let Some(path) = arguments.study.as_ref().filter(|_| !arguments.schema) else {
        let text = serde_json::to_string_pretty(&schema::json_schema());
        super::say(&format!("{}\n", text.unwrap_or_default()));
        return Ok(());
    };
    check_parquet(arguments.parquet)?;
    let shown = path.display().to_string();
    let help = "give a study file, or a name that `amacrine list studies` prints";
    let study = if let Some(file) = bundled(Kind::Study, path) {
        Study::parse_with(&file.path(), file.text, &arguments.sets)?
    } else {
        let text = source::text(path, &meant(Kind::Study, path, help))?;
        Study::parse_with(&shown, &text, &arguments.sets)?
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    if arguments.space {
        super::say(&format!("{}\n", ask::space(&study)));
        return Ok(());
    }
    if arguments.tell || !arguments.points.is_empty() {
        return tell(arguments, &study, folder);
    }
    let start = Instant::now();
    let jobs = arguments
        .jobs
        .map_or_else(rayon::current_num_threads, usize::from);
    let request = Request {
        shard: arguments.shard,
        jobs,
        seconds: arguments.max_seconds_per_point,
        budget: budget::budget(),
        clock: &thread_seconds,
    };
    let plan = request.plan(study, folder)?;
    light::warn(&plan.warnings());
    let run = request.run(&plan)?;
    let output = match &arguments.output {
        Some(output) => output.to_path_buf(),
        None => named(path, arguments, &plan),
    };
    let progress = Bar::default();
    if let Some(share) = arguments.verify {
        let seed = arguments.verify_seed;
        let begin = |left| progress.begin("verifying", left);
        let verified = run.verify(&output, share, seed, begin, || progress.tick())?;
        progress.finish();
        return say_verified(&verified, &output, arguments);
    }
    let begin = |left| progress.begin("sweeping", left);
    let done = || {
        progress.tick();
        ControlFlow::Continue(())
    };
    let Swept { did, tables } = run.sweep(&output, arguments.parquet, begin, done)?;
    progress.finish();
    light::warn(&tables.warnings);
    let said = Said {
        plan: &plan,
        output: &output,
        did,
        tables,
        jobs,
        seconds: start.elapsed().as_secs_f64(),
        shard: arguments.shard,
    };
    super::say(&if arguments.json {
        said.json()
    } else {
        said.table()
    });
    Ok(())
}

/// The folder where none is named: that of the study, and of what was set.
fn named(path: &Path, arguments: &Arguments, plan: &Plan) -> PathBuf {
    let mut name = path.file_stem().unwrap_or(path.as_os_str()).to_owned();
    if !arguments.sets.is_empty() {
        name.push(format!("-{:.8}", plan.manifest().study));
    }
    PathBuf::from(name)
}

/// Answers points with their rows, one JSON object a line.
fn tell(arguments: &Arguments, study: &Study, folder: &Path) -> miette::Result<()> {
    if study.settings.tolerance.is_some() {
        super::complain(
            "warning: fidelity = \"auto\" is of whole sweeps: a point that is told is computed in full\n",
        );
    }
    let study = study.clone().in_full();
    let mut asked = Asked::new(&study, folder);
    let limits = Limits {
        clock: &thread_seconds,
        seconds: arguments.max_seconds_per_point,
        bytes: Some(Need::new().left(budget::budget())),
    };
    for PointText(text) in &arguments.points {
        let row = asked.tell(text, limits)?;
        super::say(&format!("{}\n", json!(row)));
    }
    if arguments.tell {
        let mut lines = io::stdin().lock();
        let mut line = Vec::new();
        for number in 1_u64.. {
            line.clear();
            let most = POINT_BYTES + 1;
            let read = (&mut lines).take(most).read_until(b'\n', &mut line);
            match read {
                Err(error) => {
                    return Err(miette!(
                        help = "give points as lines of JSON",
                        "standard input cannot be read: {error}"
                    ));
                }
                Ok(0) => break,
                Ok(read) if read as u64 == most => {
                    return Err(miette!(
                        help = "give points as lines of JSON",
                        "line {number} of standard input is longer than {POINT_BYTES} bytes"
                    ));
                }
                Ok(_) => {}
            }
            // Every line has an answer; who asks can go on after a point that is none.
            let said = match point_text(&line).and_then(|text| asked.tell(text, limits)) {
                Ok(row) => json!(row),
                Err(PointError { what, help }) => {
                    let reason = format!("line {number}: {what}");
                    json!({"outcome": "wrong", "line": number, "reason": reason, "help": help})
                }
            };
            super::say(&format!("{said}\n"));
        }
    }
    light::warn(&asked.warnings());
    Ok(())
}

/// A line as the text of a point.
fn point_text(line: &[u8]) -> Result<&str, PointError> {
    let wrong = |what: &str| {
        PointError {
        what: what.to_owned(),
        help: "give one point a line as a JSON object, such as {\"side\": \"reference\", \"format\": \"q8.8\"}".to_owned(),
    }
    };
    let text = std::str::from_utf8(line).map_err(|_| wrong("it is not UTF-8"))?;
    if text.trim().is_empty() {
        return Err(wrong("it is empty"));
    }
    Ok(text)
}

/// A bar that begins when it is known how long it is.
#[derive(Default)]
struct Bar(OnceLock<Progress>);

impl Bar {
    fn begin(&self, what: &'static str, left: u64) {
        self.0.get_or_init(|| Progress::new(what, Some(left)));
    }

    fn tick(&self) {
        if let Some(bar) = self.0.get() {
            bar.tick();
        }
    }

    fn finish(&self) {
        if let Some(bar) = self.0.get() {
            bar.finish();
        }
    }
}

/// Says what was compared; what is not the same is an error.
fn say_verified(verified: &Verified, output: &Path, arguments: &Arguments) -> miette::Result<()> {
    let Verified {
        compared,
        finished,
        differences,
        pilots,
    } = verified;
    if arguments.json {
        let said = json!({
            "output": output,
            "finished": finished,
            "compared": compared,
            "seed": arguments.verify_seed,
            "differences": differences,
            "pilots": pilots,
        });
        super::say(&format!("{said}\n"));
    } else if differences.is_empty() && pilots.is_empty() {
        super::say(&format!(
            "verified {compared} of {finished} finished points (seed {}): the same bits in every column but the times\n",
            arguments.verify_seed
        ));
    }
    if differences.is_empty() && pilots.is_empty() {
        return Ok(());
    }
    let mut points: Vec<usize> = differences.iter().map(|d| d.point).collect();
    points.dedup();
    let mut said = Vec::new();
    if !points.is_empty() {
        said.push(format!(
            "{} of {compared} points that were computed again (of {finished} finished) are not what {} says:{}",
            points.len(),
            output.display(),
            listed(differences.iter().map(ToString::to_string))
        ));
    }
    if !pilots.is_empty() {
        said.push(format!(
            "{} of pilots that were measured again do not say what was measured:{}",
            counted(pilots.len(), "file"),
            listed(pilots.iter().map(|path| path.display().to_string()))
        ));
    }
    Err(miette!(
        help = "nothing was overwritten: to have these points computed again, delete their files in points/, and those of pilots that are named, and sweep again; amacrine report --json says which build and which processor computed them",
        "{}",
        said.join("\n")
    ))
}

/// Where the points of a rung of so many looked.
fn looked_at(rung: &Rung, is_last: bool) -> String {
    match rung.whole {
        _ if is_last => "on the whole scene".to_owned(),
        0 => "on a part of the scene".to_owned(),
        whole => format!(
            "on a part of the scene, {whole} of them on the whole of a scene too small for parts"
        ),
    }
}

/// What a search saw, rung by rung.
fn searched(search: &Searched, all: usize) -> String {
    let mut text = String::new();
    if search.computed_all {
        text += "search   left out no point: parts of these scenes are too much of them to try points on\n";
    }
    for (number, rung) in (1..).zip(&search.rungs) {
        let is_last = number == search.rungs.len();
        let _ = writeln!(
            text,
            "rung {number}   {} {}: {:.0} point-frames{}",
            counted(rung.points, "point"),
            looked_at(rung, is_last),
            rung.point_frames,
            if is_last {
                String::new()
            } else {
                format!(
                    ", {} were known, {} could not be ranked",
                    rung.points - rung.tried,
                    rung.unranked
                )
            }
        );
    }
    let _ = writeln!(
        text,
        "search   {:.0} point-frames, {:.1} % of the {:.0} of all {all} points (neither what points are measured against nor compiling programs is counted)",
        search.point_frames,
        100.0 * search.point_frames / search.of.max(1.0),
        search.of
    );
    let nothing = &search.nothing;
    if !nothing.is_empty() {
        let _ = writeln!(
            text,
            "nothing  comes of {}, which the search left out:{}",
            counted(nothing.len(), "point"),
            reasons(nothing)
        );
    }
    let unranked = &search.unranked;
    if !unranked.is_empty() {
        let _ = writeln!(
            text,
            "unranked {}, left out behind the others since the parts that were tried do not show what they are worth:{}",
            counted(unranked.len(), "point"),
            reasons(unranked)
        );
    }
    text
}

/// Points with their reasons, for people; those of one reason together.
fn reasons(points: &[Failed]) -> String {
    let mut each: Vec<(usize, usize, &str)> = Vec::new();
    for Failed { point, reason } in points {
        match each.iter_mut().find(|(.., other)| other == reason) {
            Some((_, more, _)) => *more += 1,
            None => each.push((*point, 0, reason)),
        }
    }
    let lines = each.iter();
    listed(lines.map(|(point, more, reason)| match more {
        0 => format!("point {point}: {reason}"),
        more => format!("point {point} and {more} more: {reason}"),
    }))
}

struct Said<'a> {
    plan: &'a Plan,
    output: &'a Path,
    did: Did,
    tables: Tables,
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
            "finished": self.tables.finished,
            "failed": self.did.failed,
            "damaged": self.did.damaged,
            "missing": self.tables.missing.len(),
            "computed_by": self.tables.computed_by,
            "refused": self.tables.refused,
            "warnings": self.tables.warnings,
            "search": self.did.search,
            "left_out": self.tables.left_out,
            "pilots": {"measured": self.did.pilots, "seconds": self.did.pilot_seconds},
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
            "computed {} in {:.1} s on {}, {} were there already",
            self.did.computed,
            self.seconds,
            counted(self.jobs, "thread"),
            self.did.found
        );
        let output = self.output.display();
        let damaged = &self.did.damaged;
        if !damaged.is_empty() {
            let _ = writeln!(text, "damaged  {}", set_aside(damaged, self.output));
        }
        if self.tables.failed > 0 {
            let _ = writeln!(
                text,
                "failed   {}, computed again by the next run:{}",
                counted(self.tables.failed, "point"),
                reasons(&self.did.failed)
            );
        }
        if self.tables.refused > 0 {
            let _ = writeln!(
                text,
                "refused  {} of {}: the report says why",
                self.tables.refused,
                counted(self.tables.finished, "point")
            );
        }
        text += &self.left_out();
        if let Some(search) = &self.did.search {
            text += &searched(search, all);
        }
        let missing = self.tables.missing.len();
        if missing > 0 && self.did.search.is_none() {
            let _ = writeln!(
                text,
                "missing  {missing} of {all}: the other shards, or run again"
            );
        }
        // A search keeps few points of a task: its front is that of all together.
        let search = self.plan.study.sample.and_then(|sample| sample.search);
        let more = search.map_or_else(String::new, |search| {
            format!(" --pool --cost {}", search.cost)
        });
        let rows = self.tables.finished + self.tables.failed;
        let next = if rows == 0 && search.is_some() {
            "nothing to report, for the reasons above".to_owned()
        } else {
            format!("amacrine report {}{more}", quoted(&output.to_string()))
        };
        let _ = write!(
            text,
            "wrote    {output}/results.csv and results.jsonl, {}\nnext     {next}\n",
            counted(rows, "row")
        );
        text
    }

    /// Points that a plainer model stands for, and what was spent to know which.
    fn left_out(&self) -> String {
        let mut text = String::new();
        let points = self.tables.left_out;
        if points > 0 {
            let _ = writeln!(
                text,
                "plainer  models stand for {points} of {} (fidelity = \"auto\"): the report marks them",
                counted(self.tables.finished, "point")
            );
        }
        let Did {
            pilots,
            pilot_seconds,
            ..
        } = &self.did;
        if *pilots > 0 {
            let _ = writeln!(
                text,
                "cost     {} measured in {pilot_seconds:.1} s of one thread; what they saved is not measured",
                counted(*pilots, "pilot")
            );
        }
        text
    }
}
