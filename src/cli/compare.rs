//! `amacrine compare`: two event files, one judged against the other.

use std::path::{Path, PathBuf};

use crate::{
    compare::{Comparison, compare, equality::Side},
    event::file::{self, Loaded},
    plane::Size,
    unit::Micros,
};

/// What `compare` is asked to do.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: amacrine compare out/reference.npy out/device.npy --within 1ms")]
pub struct Arguments {
    /// The reference: an event file of any format
    a: PathBuf,
    /// What is judged against it
    b: PathBuf,
    /// Events of one pixel, kind and sign match when their times differ by at most this
    #[arg(long, default_value = "1ms", value_name = "TIME")]
    within: Micros,
    /// Print one JSON object instead of the table
    #[arg(long)]
    json: bool,
}

/// Runs the verb.
///
/// # Errors
/// When a file cannot be read, or the two are of different sensors.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let mut reference = file::read(&arguments.a)?;
    let mut judged = file::read(&arguments.b)?;
    reference.widen_to(&judged.packet);
    judged.widen_to(&reference.packet);
    let comparison = compare(&reference.packet, &judged.packet, arguments.within)?;
    if arguments.json {
        let json = Json {
            reference: Input::of(&arguments.a, &reference),
            judged: Input::of(&arguments.b, &judged),
            comparison: &comparison,
        };
        let json = serde_json::to_string(&json).map_err(|e| miette::miette!("{e}"))?;
        super::say(&format!("{json}\n"));
    } else {
        super::say(&head(arguments, &reference, &judged));
        super::say(&table(&comparison));
    }
    Ok(())
}

/// The comparison for machines.
#[derive(serde::Serialize)]
struct Json<'a> {
    reference: Input<'a>,
    judged: Input<'a>,
    #[serde(flatten)]
    comparison: &'a Comparison,
}

/// One of the two files.
#[derive(serde::Serialize)]
struct Input<'a> {
    file: &'a Path,
    size: Size,
    /// Otherwise the size is the smallest that holds the events of both files.
    size_known: bool,
}

impl<'a> Input<'a> {
    const fn of(file: &'a Path, loaded: &Loaded) -> Self {
        Self {
            file,
            size: loaded.packet.size,
            size_known: loaded.size_known,
        }
    }
}

/// Who is compared with whom.
fn head(arguments: &Arguments, reference: &Loaded, judged: &Loaded) -> String {
    let line = |role: &str, path: &Path, loaded: &Loaded| {
        let note = if loaded.size_known {
            ""
        } else {
            " (the file does not say; the smallest that holds all events)"
        };
        let size = loaded.packet.size;
        let skipped = match loaded.skipped {
            0 => String::new(),
            n => format!("; {n} records that are no events of a pixel were left out"),
        };
        format!("{role:<10} {}, {size}{note}{skipped}\n", path.display())
    };
    line("reference", &arguments.a, reference) + &line("judged", &arguments.b, judged) + "\n"
}

/// The comparison for people.
fn table(c: &Comparison) -> String {
    let mut rows = vec![format!("{:<22}{:>14}{:>14}", "", "reference", "judged")];
    let mut both = |name: &str, [a, b]: [u64; 2]| rows.push(format!("{name:<22}{a:>14}{b:>14}"));
    both("events", c.events);
    both("  ON", c.on);
    both("  OFF", c.off);
    if c.kinds.len() > 1 {
        for kind in &c.kinds {
            both(&format!("  channel {} ON", kind.channel), kind.on);
            both(&format!("  channel {} OFF", kind.channel), kind.off);
        }
    }
    both("dropped", c.dropped);
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
    rows.push(format!(
        "matched within {}: {}   precision {:.4}   recall {:.4}   F1 {:.4}",
        c.within_us, c.matched, c.precision, c.recall, c.f1
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
