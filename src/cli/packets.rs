//! `amacrine packets`: what a packet costs on a link, and what a readout makes of it.

use miette::miette;
use serde_json::{Value, json};

use super::{
    arguments::{
        light, readout,
        recording::{self, Recording},
    },
    output::{
        content::Content,
        files::{Input, Output},
        progress::Progress,
    },
};
use crate::{
    elementary,
    event::{
        Packet, Polarity,
        codec::{self, CodeBook, Coding, Layout, Rate, entropy},
        file::Loaded,
        readout::{Frame, ReadOut, settings::Description},
    },
    rig::guard::{Guard, Warning},
    unit::{Micros, counted},
};

/// What `packets` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example: amacrine packets out/events.npy --readout arbiter --with fifo=64 -o out/read.npy"
)]
pub struct Arguments {
    /// Event file
    file: Input,
    #[command(flatten)]
    recording: Recording,
    /// Length of the frame of a bit map, and of the window in which peaks are measured
    #[arg(long, default_value = "10ms", value_name = "TIME")]
    window: Micros,
    /// Frequencies of kinds (ganglion cells of a pixel) for the code book
    ///
    /// Default: those of the packet.
    #[arg(long, value_name = "N,N,…", value_delimiter = ',')]
    frequencies: Vec<u64>,
    #[command(flatten)]
    readout: readout::Choice,
    /// Write the packet behind the readout: the events that arrive
    ///
    /// Requires --readout.
    #[arg(short, long, value_name = "FILE", requires = "readout", value_parser = Content::Events)]
    output: Option<Output>,
    /// Print JSON in place of text
    #[arg(long)]
    json: bool,
}

/// Bytes of an event: as it was read, and what its word costs.
const EACH: u128 = 24;

/// Bytes of an event in a readout: its requests, its way through the queues, its delay.
const READ: u128 = 80;

/// Runs the verb.
///
/// # Errors
/// When the file cannot be read, a setting is not what it should be, or the output cannot be
/// written.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    if arguments.window.0 == 0 {
        return Err(miette!(
            help = "give a time such as 10ms",
            "--window 0: a frame needs some time"
        ));
    }
    arguments.readout.open()?.map(|d| d.readout()).transpose()?;
    let each = EACH + READ * u128::from(arguments.readout.is_asked());
    let loaded = arguments.recording.read(&arguments.file, 0, each)?;
    let progress = Progress::spinner("counting");
    let read = arguments.readout.apply(&loaded.packet)?;
    let packet = read.as_ref().map_or(&loaded.packet, |(_, r)| &r.packet);
    let counted = Counted::new(packet, arguments)?;
    progress.finish();
    if let Some(output) = &arguments.output {
        output.write(packet)?;
    }
    let mut lost = Guard::new();
    lost.lost("the readout", packet.dropped, packet.events.len() as u64);
    let warnings = lost.warnings();
    light::warn(&warnings);
    let shown = Shown {
        arguments,
        loaded: &loaded,
        read: read.as_ref(),
        packet,
        counted,
        warnings,
    };
    if arguments.json {
        super::say(&format!("{}\n", shown.json()));
    } else {
        super::say(&shown.table());
    }
    Ok(())
}

/// What was counted in a packet.
struct Counted {
    /// Events of each kind.
    kinds: Vec<u64>,
    on: u64,
    book: CodeBook,
    codings: Vec<(&'static str, Rate)>,
}

impl Counted {
    fn new(packet: &Packet, arguments: &Arguments) -> miette::Result<Self> {
        let mut kinds = vec![0; packet.channels.into()];
        for e in &packet.events {
            if let Some(count) = kinds.get_mut(usize::from(e.channel)) {
                *count += 1;
            }
        }
        let given = &arguments.frequencies;
        if !given.is_empty() && given.len() != kinds.len() {
            return Err(miette!(
                help = "give one number for each kind, 0 for a kind that never comes",
                "--frequencies has {}; the packet has {}",
                counted(given.len(), "number"),
                counted(kinds.len(), "kind")
            ));
        }
        if !given.is_empty() && given.iter().all(|frequency| *frequency == 0) {
            return Err(miette!(
                help =
                    "give how often each kind comes, or leave --frequencies out: they are counted",
                "--frequencies says of every kind that it never comes"
            ));
        }
        let book = CodeBook::from_counts(if given.is_empty() { &kinds } else { given });
        let mut codings = Vec::new();
        for (name, layout, huffman) in [
            ("fixed words", Layout::Single, false),
            ("bursts of a row", Layout::Burst, false),
            ("Huffman kinds", Layout::Single, true),
            ("bursts, Huffman kinds", Layout::Burst, true),
        ] {
            // With one kind both are the same.
            if huffman && packet.channels < 2 {
                continue;
            }
            let book = huffman.then(|| book.clone());
            let costs = Coding { layout, book }.costs(packet)?;
            codings.push((name, Rate::from_packet(packet, &costs, arguments.window)));
        }
        let on = packet.events.iter().filter(|e| e.polarity == Polarity::On);
        Ok(Self {
            kinds,
            on: on.count() as u64,
            book,
            codings,
        })
    }
}

/// All that there is to show.
struct Shown<'a> {
    arguments: &'a Arguments,
    loaded: &'a Loaded,
    read: Option<&'a (Description, ReadOut)>,
    packet: &'a Packet,
    counted: Counted,
    warnings: Vec<Warning>,
}

impl Shown<'_> {
    fn seconds(&self) -> f64 {
        let (from, to) = self.packet.span;
        Micros(to.0.saturating_sub(from.0)).seconds()
    }

    /// Frames of the window's length in the time watched.
    fn frames(&self) -> u64 {
        codec::frames(self.packet, self.arguments.window)
    }

    fn json(&self) -> Value {
        let Self {
            arguments: a,
            packet: p,
            counted: c,
            ..
        } = self;
        let map = Frame::bits(p.size, p.channels);
        let mut kinds = Vec::new();
        for (kind, events) in (0..).zip(&c.kinds) {
            let word = c.book.word(kind);
            kinds.push(json!({
                "channel": kind,
                "name": p.names.get(usize::from(kind)),
                "events": events,
                "bits": word.map(|(bits, _)| bits),
                "word": word.map(text),
            }));
        }
        let codings: Vec<_> = c
            .codings
            .iter()
            .map(|(name, rate)| json!({"coding": name, "rate": rate}))
            .collect();
        json!({
            "file": a.file,
            "width": p.size.width,
            "height": p.size.height,
            "size_known": self.loaded.size_known,
            "channels": p.channels,
            "seconds": self.seconds(),
            "events": p.events.len(),
            "arrived": p.events.len(),
            "on": c.on,
            "off": p.events.len() as u64 - c.on,
            "dropped": self.dropped(),
            "dropped_known": self.loaded.dropped_known,
            "window_us": a.window.0,
            "windows": self.frames(),
            "bit_map_bits": map,
            "codings": codings,
            "kinds": kinds,
            "entropy_bits": entropy(&c.kinds),
            "mean_word_bits": c.book.mean_length(&c.kinds),
            "book_hex": hex(&c.book.to_bytes()),
            "readout": self.read.map(|(d, r)| json!({"settings": d, "statistics": r.statistics})),
            "notes": self.read.map_or_else(Vec::new, |(d, r)| readout::notes(d, &r.statistics)),
            "warnings": self.warnings,
            "output": a.output,
        })
    }

    /// What was lost, by reason: nothing is known of it where the file does not say.
    fn dropped(&self) -> Value {
        let mut dropped = json!(self.packet.dropped);
        if !self.loaded.dropped_known
            && let Some(reasons) = dropped.as_object_mut()
        {
            for count in reasons.values_mut() {
                *count = Value::Null;
            }
        }
        dropped
    }

    fn table(&self) -> String {
        let Self {
            arguments: a,
            packet: p,
            counted: c,
            ..
        } = self;
        let events = p.events.len() as u64;
        let note = recording::guessed(self.loaded.size_known);
        let mut lines = vec![format!(
            "packet   {}, {}{note}, {}, {:.6} s",
            a.file.display(),
            p.size,
            counted(p.channels, "kind"),
            self.seconds()
        )];
        if let Some((description, read)) = self.read {
            lines.extend(readout::lines(description, &read.statistics));
        }
        let rate = if self.seconds() > 0.0 {
            format!(", {}ev/s", large(events as f64 / self.seconds()))
        } else {
            String::new()
        };
        lines.push(format!(
            "events   {events} ({} ON, {} OFF){rate}",
            c.on,
            events - c.on
        ));
        for (reason, count) in p.dropped.reasons() {
            if count > 0 {
                lines.push(format!("dropped  {count} {reason}"));
            }
        }
        lines.push(String::new());
        lines.push(self.heading());
        for (name, rate) in &c.codings {
            lines.push(row(name, rate, self.frames()));
        }
        let map = Frame::bits(p.size, p.channels);
        let rate = map as f64 / a.window.seconds();
        lines.push(format!(
            "{:<22}{:>11}{:>12}{:>15}{:>15}",
            "bit map",
            per_event(map * self.frames(), events),
            large(map as f64 * self.frames() as f64) + "b",
            large(rate) + "b/s",
            large(rate) + "b/s",
        ));
        if p.channels > 1 {
            lines.push(String::new());
            lines.extend(self.book());
        }
        if let Some(output) = &a.output {
            lines.push(format!("wrote    {}", output.display()));
        }
        lines.join("\n") + "\n"
    }

    fn heading(&self) -> String {
        let window = window(self.arguments.window);
        format!(
            "{:<22}{:>11}{:>12}{:>15}{:>15}   {:<30}frames above",
            "coding",
            "bits/event",
            "bits",
            "mean link",
            format!("peak, {window}"),
            format!("pays below, {window} frames"),
        )
    }

    fn book(&self) -> Vec<String> {
        let c = &self.counted;
        let all: u64 = c.kinds.iter().sum();
        let called: Vec<String> = (0..self.packet.channels)
            .map(|kind| self.packet.called(kind))
            .collect();
        let longest = called.iter().map(|name| name.chars().count()).max();
        let width = longest.unwrap_or(0).max(7) + 1;
        let mut lines = vec![format!(
            "{:<width$}{:>12}{:>10}{:>10}   word",
            "channel", "events", "share", "-log2"
        )];
        for ((kind, events), called) in (0..).zip(&c.kinds).zip(&called) {
            let share = *events as f64 / all.max(1) as f64;
            let ideal = if *events > 0 {
                format!("{:.2}", -elementary::log2(share).min(0.0))
            } else {
                "-".into()
            };
            lines.push(format!(
                "{called:<width$}{events:>12}{:>8.2} %{ideal:>10}   {}",
                100.0 * share,
                match c.book.word(kind) {
                    Some((0, _)) => "(empty)".into(),
                    Some(word) => text(word),
                    None => "none".into(),
                }
            ));
        }
        let mean = c.book.mean_length(&c.kinds);
        lines.push(format!(
            "entropy {:.3} bits a kind, mean word {}; the book is {} bytes: {}",
            entropy(&c.kinds),
            mean.map_or("none".into(), |m| format!("{m:.3} bits")),
            c.book.to_bytes().len(),
            hex(&c.book.to_bytes()),
        ));
        lines
    }
}

/// A coding's line.
fn row(name: &str, rate: &Rate, frames: u64) -> String {
    let bits = |value: f64, unit: &str| large(value) + unit;
    let pays = rate.crossover.zip(rate.mean).map(|(events, _)| events);
    format!(
        "{name:<22}{:>11}{:>12}{:>15}{:>15}   {:<30}{} of {frames}",
        rate.bits_per_event
            .map_or("-".into(), |b| format!("{b:.2}")),
        bits(rate.bits as f64, "b"),
        rate.mean.map_or("-".into(), |m| bits(m, "b/s")),
        bits(rate.peak, "b/s"),
        pays.map_or("-".into(), |events| format!("{events:.0} events a frame")),
        rate.above,
    )
}

fn per_event(bits: u64, events: u64) -> String {
    if events == 0 {
        "-".into()
    } else {
        format!("{:.2}", bits as f64 / events as f64)
    }
}

/// A large number with four figures and a prefix: `1.235 M`.
fn large(value: f64) -> String {
    let scaled = [("G", 1e9), ("M", 1e6), ("k", 1e3)]
        .into_iter()
        .find(|(_, one)| value >= *one);
    match scaled {
        Some((prefix, one)) => format!("{:.3} {prefix}", value / one),
        None => format!("{value:.0} "),
    }
}

/// A window in the largest unit that leaves a whole number.
fn window(window: Micros) -> String {
    match window.0 {
        us if us % 1_000_000 == 0 => format!("{} s", us / 1_000_000),
        us if us % 1000 == 0 => format!("{} ms", us / 1000),
        us => format!("{us} us"),
    }
}

/// A word as 0s and 1s.
fn text((bits, word): (u32, u128)) -> String {
    (0..bits)
        .rev()
        .map(|bit| if word >> bit & 1 == 1 { '1' } else { '0' })
        .collect()
}

fn hex(bytes: &[u8]) -> String {
    let digit = |d: u8| char::from_digit(d.into(), 16).unwrap_or('?');
    let two = |b: &u8| [digit(b >> 4), digit(b & 15)];
    bytes.iter().flat_map(two).collect()
}
