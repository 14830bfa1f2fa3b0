//! `--readout`: what stands between the cells and the packet, chosen on the command line.

use std::path::Path;

use miette::miette;

use super::heading;
use crate::{
    cli::output::files::Named,
    event::{
        Packet,
        readout::{Latency, ReadOut, Stage, Statistics, settings::Description},
    },
    source,
    unit::{Picos, counted},
};

/// Which readout, and with which settings.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Choice {
    /// Readout of the packet: ideal, scan, arbiter, frame, or a file
    ///
    /// Files are like those in readouts/.
    #[arg(long, value_name = "NAME|FILE.toml", help_heading = heading::READOUT)]
    readout: Option<Named>,
    /// Setting of the readout, such as fifo=64 or link=1us; may be repeated
    #[arg(long = "with", value_name = "KEY=VALUE", value_parser = setting, requires = "readout", help_heading = heading::READOUT)]
    settings: Vec<(String, String)>,
}

/// `key=value`, for the command line.
fn setting(text: &str) -> Result<(String, String), String> {
    text.split_once('=')
        .map(|(key, value)| (key.trim().to_owned(), value.trim().to_owned()))
        .ok_or_else(|| format!("`{text}` is not KEY=VALUE"))
}

impl Choice {
    /// Whether one was chosen.
    pub const fn is_asked(&self) -> bool {
        self.readout.is_some()
    }

    /// The readout that was chosen, if any.
    pub fn open(&self) -> miette::Result<Option<Description>> {
        let Some(name) = &self.readout else {
            return Ok(None);
        };
        let mut description = if Path::new(&**name).extension().is_some_and(|e| e == "toml") {
            let help = "give a file like those in readouts/, or the name of a readout";
            let text = source::text(Path::new(&**name), help)?;
            Description::parse(name, &text)?
        } else {
            Description::shipped(name)?
        };
        for (n, (key, value)) in self.settings.iter().enumerate() {
            if self.settings[..n].iter().any(|(other, _)| other == key) {
                return Err(miette!(
                    help = "give each setting once",
                    "--with {key} is given twice"
                ));
            }
            description.set(key, value)?;
        }
        Ok(Some(description))
    }

    /// As [`Choice::open`]; else the scan that a compiled program asks for.
    pub fn open_compiled(&self) -> miette::Result<Description> {
        match self.open()? {
            Some(description) => Ok(description),
            None => Ok(Description::of_compiled()?),
        }
    }

    /// Reads a packet out, if that was asked for.
    pub fn apply(&self, packet: &Packet) -> miette::Result<Option<(Description, ReadOut)>> {
        let Some(description) = self.open()? else {
            return Ok(None);
        };
        let read = description.readout()?.read(packet);
        Ok(Some((description, read)))
    }
}

/// What a readout did, for people.
pub fn lines(description: &Description, statistics: &Statistics) -> Vec<String> {
    let [before, behind] = statistics.events;
    let mut lines = vec![format!(
        "readout  {}: {} fired, {behind} arrived",
        description.name(),
        counted(before, "event")
    )];
    for (key, setting) in description.settings() {
        let evidence = setting.evidence.map_or(String::new(), |e| {
            format!(" ({})", format!("{e:?}").to_lowercase())
        });
        lines.push(format!(
            "  {key:<9} {}   {}{evidence}",
            setting.value, setting.source
        ));
    }
    for (reason, count) in statistics.dropped.reasons() {
        if count > 0 {
            let part = 100.0 * count as f64 / before as f64;
            lines.push(format!("lost     {count} ({part:.2} %) {reason}"));
        }
    }
    if let Some(l) = &statistics.latency {
        lines.push(format!(
            "latency  mean {}   half {}   90 % {}   99 % {}   longest {}",
            if l.mean_s.is_finite() {
                short(l.mean_s * 1e12)
            } else {
                "unknown".to_owned()
            },
            time(l.p50),
            time(l.p90),
            time(l.p99),
            time(l.max),
        ));
    }
    for stage in &statistics.stages {
        lines.push(format!(
            "busy     {:<8} {:.3} % of the time, at most {} waiting",
            stage.name,
            100.0 * stage.busy,
            stage.most
        ));
        lines.extend(late(description, statistics, stage).map(|note| noted(&note)));
    }
    lines.extend(ambiguous(statistics).map(|note| noted(&note)));
    lines
}

/// What is to be said of it beside its figures.
pub fn notes(description: &Description, statistics: &Statistics) -> Vec<String> {
    let stages = statistics.stages.iter();
    let late = stages.filter_map(|stage| late(description, statistics, stage));
    late.chain(ambiguous(statistics)).collect()
}

fn noted(note: &str) -> String {
    format!("note     {note}")
}

/// That a stage cannot keep up, and why.
fn late(description: &Description, statistics: &Statistics, stage: &Stage) -> Option<String> {
    let mut settings = description.settings();
    let frames_of_stamps = settings.any(|(key, setting)| {
        key == "period" && setting.value.trim_end_matches(char::is_alphabetic).trim() == "0"
    });
    let name = stage.name;
    stage.falls_behind.then(|| if frames_of_stamps && statistics.lone {
        format!(
            "the {name} is late because each time stamp is a frame of its own (period=0us), and these are crossing times: give --with period=TIME, from one frame to the next"
        )
    } else {
        format!(
            "the {name} cannot keep up: it is busy all the time, and events are lost or wait longer and longer"
        )
    })
}

/// That a host may take an event for the end of the list.
fn ambiguous(statistics: &Statistics) -> Option<String> {
    (statistics.ambiguous > 0).then(|| {
        format!(
            "{} at the chip's (0,0): a host that takes (0,0) for the end of the list loses what comes from there on",
            counted(statistics.ambiguous, "event")
        )
    })
}

/// A latency.
fn time(time: Picos) -> String {
    if time == Latency::BEYOND {
        return "more than 213 days".to_owned();
    }
    short(time.0 as f64)
}

/// A time of so many picoseconds, with three figures.
fn short(picos: f64) -> String {
    let scaled = [("s", 1e12), ("ms", 1e9), ("us", 1e6), ("ns", 1e3)]
        .into_iter()
        .find(|(_, one)| picos >= *one);
    let (unit, one) = scaled.unwrap_or(("ns", 1e3));
    let value = picos / one;
    let decimals = if value < 10.0 {
        2
    } else {
        usize::from(value < 100.0)
    };
    format!("{value:.decimals$} {unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_three_figures() {
        assert_eq!(short(1_234_567.0), "1.23 us");
        assert_eq!(short(36_000.0), "36.0 ns");
        assert_eq!(short(123.4e9), "123 ms");
        assert_eq!(short(0.0), "0.00 ns");
    }
}
