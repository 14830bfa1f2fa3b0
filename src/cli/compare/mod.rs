//! `amacrine compare`: two event files, one judged against the other.

mod headline;
mod ladder;

use std::{cell::RefCell, path::Path};

use miette::{Report, miette};

use super::{
    arguments::{
        clip::Clip,
        heading, light,
        recording::{self, Recording},
        window::Window,
    },
    output::{content::Content, files, progress::Progress},
};
use crate::{
    compare::{Comparison, counts::Kind, equality::Side},
    event::file::Loaded,
    scene::{Observation, Scene as _},
    stop::Stop,
    study::comparison::{self, Asked, Frames, Ruler},
    unit::fixed,
};

/// What `compare` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  amacrine compare out/reference.npy out/silicon.npy -o curve.svg\n  amacrine compare a.npy b.npy --sensor rgc --scene clip.mp4\n\nkept is the part of F1 above chance, (F1 - floor) / (1 - floor). The floor is F1 of a redraw: each cell has as many events as in the reference, at times drawn from those of the other cells. The ceiling is F1 of the reference itself, 1. Within a window below the frame interval, a match says which frame an event is in, not when it is."
)]
pub struct Arguments {
    /// Reference: an event file of any format
    a: files::Input,
    /// Event file that is judged against the reference
    b: files::Input,
    #[command(flatten)]
    recording: Recording,
    #[command(flatten)]
    window: Window,
    /// Sensor file that made the reference
    ///
    /// It is run on the scene at other thresholds. This tells which change of its threshold costs
    /// as much, and which has as many events. The options under Scene need it,
    /// but for --fps, which without it says how far apart the frames of the events are.
    #[arg(long)]
    sensor: Option<files::Input>,
    #[command(flatten)]
    clip: Clip,
    /// Insert frames, as `amacrine run` does
    #[arg(long, value_name = "CONTRAST", requires = "sensor", help_heading = heading::SCENE)]
    upsample: Option<f64>,
    /// Number of bins of the voxel grids
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u16).range(1..=1000), help_heading = heading::COMPARISON)]
    bins: u16,
    /// Seed of the redraw and the permutation, to which every metric is compared
    ///
    /// With --sensor it is the seed of the sensor's mismatch and noise, too.
    #[arg(long, default_value_t = 0, help_heading = heading::COMPARISON)]
    seed: u64,
    /// Draw F1 over the window, between its floor and its ceiling
    #[arg(short, long, value_name = "FILE.svg|FILE.png", value_parser = Content::Drawing)]
    output: Option<files::Output>,
    /// Print JSON in place of text
    #[arg(long)]
    json: bool,
}

/// Bytes of an event: as it was read, sorted by cell, and drawn anew or moved elsewhere, one after
/// the other; `tests/budget.rs` measures it.
const EACH: u128 = 88;

/// Runs the verb.
///
/// # Errors
/// When a file cannot be read, or the two are of different sensors.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    arguments.check()?;
    let [of_a, of_b] = { arguments.recording }.of_each([&arguments.a, &arguments.b])?;
    let mut reference = of_a.read(&arguments.a, 0, EACH)?;
    let held = EACH * reference.packet.events.len() as u128;
    let mut judged = of_b.read(&arguments.b, held, EACH)?;
    reference.widen_to(&judged.packet);
    judged.widen_to(&reference.packet);
    let asked = Asked {
        within: arguments.window.within,
        frames: arguments.frames()?,
        bins: arguments.bins.into(),
        seed: arguments.seed,
        stop: Stop::NEVER,
    };
    let progress = RefCell::new(Progress::spinner("comparing"));
    let sides = [
        (arguments.a.as_ref(), &reference),
        (arguments.b.as_ref(), &judged),
    ];
    let answer = comparison::answer(sides, asked, |packets, window| {
        let Some(sensor) = &arguments.sensor else {
            return Ok(None);
        };
        progress.borrow().finish();
        let equivalent = arguments.equivalent(sensor, packets, window)?;
        progress.replace(Progress::spinner("comparing"));
        Ok::<_, Report>(Some(equivalent))
    })?;
    progress.borrow().finish();
    light::warn(&answer.warnings);
    if let Some(path) = &arguments.output {
        path.draw(&headline::drawing(&answer, arguments))?;
    }
    if arguments.json {
        let json = serde_json::to_value(&answer).map_err(|e| miette!("{e}"))?;
        super::say(&format!("{json}\n"));
    } else {
        super::say(&headline::line(&answer.headline));
        super::say(&headline::tuned(&answer.headline));
        super::say(&headline::table(&answer.curve));
        super::say(&head(arguments, &reference, &judged));
        super::say(&table(&answer.comparison, &reference));
        super::say(&metrics(&answer.ruler));
    }
    Ok(())
}

impl Arguments {
    /// Refuses options that would be of no use.
    fn check(&self) -> miette::Result<()> {
        if self.sensor.is_some() {
            return Ok(());
        }
        // A rate alone says how far frames are apart.
        let mut shown = self.clip.written().into_iter().map(|(name, _)| name);
        match shown.find(|name| *name != "fps") {
            None => Ok(()),
            Some(name) => Err(miette!(
                help = "give the sensor file that made the reference, too: then it is run at higher thresholds",
                "--{name} needs --sensor"
            )),
        }
    }

    /// Frames a second, where they are said or a scene is shown.
    fn frames(&self) -> miette::Result<Frames> {
        Ok(match (&self.sensor, self.clip.fps()) {
            (Some(_), _) => Frames::Shown(self.shown(&Observation::new())?.fps()),
            (None, Some(fps)) => Frames::Said(fps),
            (None, None) => Frames::Unknown,
        })
    }
}

/// The scores for people, one a row.
fn metrics(ruler: &Ruler) -> String {
    let mut rows = vec![format!(
        "\n{:<26}{:>11}{:>11}{:>11}{:>11}{:>7}  blind to",
        "metric", "judged", "identical", "redraw", "permuted", "lost"
    )];
    for score in &ruler.scores {
        let values = [score.value, score.identical, score.redraw, score.permuted];
        let [value, identical, redraw, permuted] = values.map(number);
        let lost =
            { score.lost() }.map_or_else(|| "-".into(), |lost| fixed(100.0 * lost, 0) + " %");
        let name = score.metric.to_string();
        let blind = score.metric.entry().blind_to;
        let row = format!(
            "{name:<26}{value:>11}{identical:>11}{redraw:>11}{permuted:>11}{lost:>7}  {blind}"
        );
        rows.push(row.trim_end().to_owned());
    }
    rows.push(format!(
        "\nidentical: the reference against itself. redraw: the same counts in every cell, at\n\
             times of other cells. permuted: the same times at wrong pixels. lost: the way from\n\
             identical to redraw. Distances are per event; voxels have {} bins. The interval\n\
             divergence is blind to wrong pixels: never use it alone.",
        ruler.scales.bins
    ));
    rows.join("\n") + "\n"
}

/// A value in at most ten characters.
fn number(value: Option<f64>) -> String {
    match value {
        None => "-".into(),
        // Sums that cancel but for their rounding.
        Some(v) if v.abs() < 1e-14 => "0".into(),
        Some(v) if v.fract() == 0.0 && v.abs() < 1e10 => format!("{v:.0}"),
        Some(v) if (1e-3..1e5).contains(&v.abs()) => format!("{v:.4}"),
        Some(v) => format!("{v:.2e}"),
    }
}

/// Who is compared with whom.
fn head(arguments: &Arguments, reference: &Loaded, judged: &Loaded) -> String {
    let line = |role: &str, path: &Path, loaded: &Loaded| {
        let note = recording::guessed(loaded.size_known);
        let size = loaded.packet.size;
        let skipped = match loaded.skipped {
            0 => String::new(),
            n => format!("; {n} records that are no events of a pixel were left out"),
        };
        format!("{role:<10} {}, {size}{note}{skipped}\n", path.display())
    };
    line("reference", &arguments.a, reference) + &line("judged", &arguments.b, judged) + "\n"
}

/// The plain comparison for people.
fn table(c: &Comparison, reference: &Loaded) -> String {
    let called = |kind: &Kind, sign: &str| {
        format!("  channel {} {sign}", reference.packet.called(kind.channel))
    };
    let longest = { c.kinds.iter() }.map(|kind| called(kind, "OFF").chars().count());
    let width = longest.max().unwrap_or(0).max(21) + 1;
    let mut rows = vec![format!("{:<width$}{:>14}{:>14}", "", "reference", "judged")];
    let mut both =
        |name: &str, [a, b]: [u64; 2]| rows.push(format!("{name:<width$}{a:>14}{b:>14}"));
    both("events", c.events);
    both("  ON", c.on);
    both("  OFF", c.off);
    if c.kinds.len() > 1 {
        for kind in &c.kinds {
            both(&called(kind, "ON"), kind.on);
            both(&called(kind, "OFF"), kind.off);
        }
    }
    let told = |count: Option<u64>| count.map_or_else(|| "not known".to_owned(), |n| n.to_string());
    let [a, b] = c.dropped.map(told);
    rows.push(format!("{:<width$}{a:>14}{b:>14}", "dropped"));
    let mut both =
        |name: &str, [a, b]: [u64; 2]| rows.push(format!("{name:<width$}{a:>14}{b:>14}"));
    both(&format!("bits, {} an event", c.bits_per_event), c.bits);
    both("cells that spoke", c.cells.active);
    both("busiest cell", c.cells.max);
    rows.push(String::new());
    rows.push(match c.first_divergence {
        None => "identical: the same events".into(),
        Some(d) => format!(
            "first divergence: {} at {} x {} y {} channel {} only in the {}",
            if d.p == 1 { "ON" } else { "OFF" },
            d.t,
            d.x,
            d.y,
            d.channel,
            match d.only_in {
                Side::Reference => "reference",
                Side::Judged => "judged file",
            }
        ),
    });
    let share = |share: Option<f64>| share.map_or("-".into(), |share| format!("{share:.4}"));
    rows.push(format!(
        "matched within {}: {}   precision {}   recall {}   F1 {:.4}",
        c.within_us,
        c.matched,
        share(c.precision),
        share(c.recall),
        c.f1
    ));
    if let Some(q) = c.time_error_us {
        rows.push(format!(
            "time error, judged - reference, us: min {}  5% {}  25% {}  50% {}  75% {}  95% {}  max {}",
            q.min, q.p05, q.p25, q.p50, q.p75, q.p95, q.max
        ));
    }
    let pearson = c.cells.pearson.map_or("none".into(), |r| format!("{r:.4}"));
    rows.push(format!(
        "counts per pixel, kind and sign: Pearson {pearson}   L1 {}",
        c.cells.l1
    ));
    rows.join("\n") + "\n"
}
