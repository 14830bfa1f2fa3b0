//! `amacrine convert`: an event file into another format, a slice of it, one kind of cell.

use std::{
    ffi::{OsStr, OsString},
    fs,
    path::{Path, PathBuf},
};

use miette::miette;
use serde_json::json;

use super::{
    arguments::{
        flip::Flip,
        heading,
        recording::{self, Recording},
    },
    input::event_stream::Events,
    output::{
        content::Content,
        files::{self, Input, Output},
        progress::Progress,
    },
};
use crate::{
    event::{
        Dropped, Event,
        file::{Compression, FileError, Format, Head, Writer},
    },
    plane::Size,
    unit::{Micros, counted, exact_seconds},
};

/// What `convert` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  amacrine convert out/reference.npy out/reference.evt3\n  amacrine convert recording.raw part.aedat4 --slice 1s..2.5s\n  amacrine convert rgc.npy rgc.evt2 --each-kind\n  amacrine convert shuffled.csv sorted.npy --sort\n\ndocs/formats.md has what each format holds and who reads it."
)]
#[expect(clippy::struct_excessive_bools, reason = "each is a flag of its own")]
pub struct Arguments {
    /// Event file to read
    a: Input,
    /// Event file to write
    #[arg(value_parser = Content::Converted)]
    b: Output,
    /// Format of A, if its name and its first bytes do not say it
    #[arg(long, value_name = "NAME", help_heading = heading::INPUT)]
    from: Option<Format>,
    #[arg(long, help = format!("Format of B, if its extension does not say it: {}", Format::names()), value_name = "NAME")]
    format: Option<Format>,
    /// Compression of the packets of an aedat4 file [default: lz4]
    #[arg(long, value_name = "lz4|zstd|none", value_parser = compression)]
    compression: Option<Compression>,
    #[command(flatten)]
    recording: Recording,
    /// Events to keep: those from FROM on and before TO, such as 1s..2.5s
    ///
    /// Each time has its unit; either may be left out. (A window of `voxels` or `show` has the
    /// events after its start and up to its end.)
    #[arg(long, value_name = "FROM..TO", value_parser = slice)]
    slice: Option<(Micros, Micros)>,
    /// Count times from the start of the recording, or of the slice
    ///
    /// This is for formats that cannot hold the time of day.
    #[arg(long)]
    from_zero: bool,
    /// Kind of cell to keep, a number from 0 (which ganglion cell of a pixel)
    ///
    /// Excludes --each-kind.
    #[arg(long, value_name = "N", conflicts_with = "each_kind")]
    kind: Option<u8>,
    /// Write one file for each kind of cell: B.kind0.EXT, B.kind1.EXT, …
    ///
    /// Excludes --kind.
    #[arg(long)]
    each_kind: bool,
    /// Flip columns (x), rows (y) or both (xy, half a turn)
    ///
    /// The size of the sensor comes from the file or from --size. Files of jAER and v2e (.aedat)
    /// count rows from the bottom and columns from the right.
    #[arg(long, value_name = "x|y|xy")]
    flip: Option<Flip>,
    /// Sort the events by time
    ///
    /// All of them must fit into memory at once.
    #[arg(long)]
    sort: bool,
    /// Keep the events before the first damage, and print what the damage is
    #[arg(long, help_heading = heading::INPUT)]
    salvage: bool,
    /// Print JSON in place of text
    #[arg(long)]
    json: bool,
}

fn compression(text: &str) -> Result<Compression, String> {
    [Compression::Lz4, Compression::Zstd, Compression::None]
        .into_iter()
        .find(|c| c.name() == text)
        .ok_or_else(|| "give lz4, zstd or none".into())
}

fn slice(text: &str) -> Result<(Micros, Micros), String> {
    let (from, to) = text
        .split_once("..")
        .ok_or("give FROM..TO, such as 1s..2.5s or ..500ms")?;
    let time = |text: &str, absent| match text {
        "" => Ok(absent),
        text => text.parse().map_err(|e| format!("{e}")),
    };
    let (from, to) = (time(from, Micros(0))?, time(to, Micros(u64::MAX))?);
    if from > to {
        return Err("FROM is after TO".into());
    }
    Ok((from, to))
}

/// What was found out about A.
struct Seen {
    format: Format,
    size: Size,
    size_known: bool,
    channels: u8,
    skipped: u64,
    /// Events that came earlier than the one before them, and were sorted.
    out_of_order: u64,
    note: Option<String>,
    damage: Option<FileError>,
    /// Where the recording begins, where that is asked for.
    start: Micros,
    /// The first and the last event that was read.
    ends: Option<(Micros, Micros)>,
}

/// A file that was written.
struct Written {
    path: PathBuf,
    events: u64,
    ends: Option<(Micros, Micros)>,
}

/// Runs the verb.
///
/// # Errors
/// When A cannot be read or is damaged, or B cannot hold its events or cannot be written.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let format = format(arguments)?;
    if let Some(compression) = arguments.compression {
        format.check_compression(&arguments.b, compression)?;
    }
    if !arguments.each_kind {
        files::writes([&*arguments.b])?;
    }
    let is_pipe = |it: fs::Metadata| !it.is_file() && !it.is_dir();
    if &*arguments.a == Path::new("-") || fs::metadata(&arguments.a).is_ok_and(is_pipe) {
        return Err(miette!(
            help = "write the events to a file first, and give its name",
            "{} is no file: `convert` reads what it converts twice",
            arguments.a.display()
        ));
    }
    let mut seen = look(arguments)?;
    if let Some(kind) = arguments.kind.filter(|kind| *kind >= seen.channels) {
        return Err(miette!(
            help = "kinds count from 0",
            "{}: there is no kind {kind}: it has {}",
            arguments.a.display(),
            counted(seen.channels, "kind")
        ));
    }
    if arguments.flip.is_some() && !seen.size_known {
        return Err(miette!(
            help = "give --size WxH",
            "--flip: {} does not say how large its sensor is",
            arguments.a.display()
        ));
    }
    let targets = targets(arguments, &seen);
    if arguments.each_kind {
        files::writes(targets.iter().map(|(path, _)| path))?;
    }
    let written = pass(arguments, format, &targets, &mut seen)?;
    if arguments.json {
        let files: Vec<_> = written.iter().map(|w| file_json(format, w)).collect();
        let json = json!({
            "read": {
                "file": arguments.a,
                "format": seen.format.name(),
                "width": seen.size.width,
                "height": seen.size.height,
                "size_known": seen.size_known,
                "kinds": seen.channels,
                "left_out": seen.skipped,
                "out_of_order": seen.out_of_order,
                "note": seen.note,
                "damage": seen.damage.as_ref().map(ToString::to_string),
            },
            "written": files,
        });
        super::say(&format!("{json}\n"));
    } else {
        super::say(&table(arguments, format, &seen, &written));
    }
    Ok(())
}

/// The format of B, which its name must not contradict.
fn format(arguments: &Arguments) -> miette::Result<Format> {
    let b = &arguments.b;
    if arguments.each_kind && b.is_node() {
        return Err(miette!(
            help = "give B a name that is no device",
            "{}: --each-kind writes several files, named after B",
            b.display()
        ));
    }
    let Some(asked) = arguments.format else {
        return Ok(b.format()?);
    };
    match b.says() {
        Some(said) if !b.is_node() && !said.contains(&asked) => {
            let said: Vec<_> = said.iter().map(|format| format.name()).collect();
            Err(miette!(
                help = "give another name, or leave --format out",
                "{} is the name of {}, and --format says {asked}",
                b.display(),
                said.join(" or ")
            ))
        }
        _ => Ok(asked),
    }
}

fn file_json(format: Format, written: &Written) -> serde_json::Value {
    json!({
        "file": written.path,
        "format": format.name(),
        "events": written.events,
        "first_us": written.ends.map(|(first, _)| first),
        "last_us": written.ends.map(|(_, last)| last),
        "python": format.opened_by(&written.path),
    })
}

fn open(arguments: &Arguments) -> miette::Result<Events> {
    let opening = arguments.recording.opening(arguments.from);
    let mut events = Events::streamed(&arguments.a, &opening).map_err(|error| {
        let is_bad = matches!(error, FileError::Bad { .. });
        if arguments.salvage && is_bad && is_damage(&error) {
            return miette!(
                help = "nothing is kept of it: what is damaged is needed to read the first event",
                "{error}"
            );
        }
        error.into()
    })?;
    if arguments.sort {
        events.sort(&arguments.a)?;
    }
    Ok(events)
}

/// Whether an error says that the file is damaged; else it is whole, and nothing of it is to be
/// saved.
const fn is_damage(error: &FileError) -> bool {
    !matches!(error, FileError::Bad { fault, .. } if fault.is_foreign())
}

/// The size and the kinds: from the file, else from all of its events.
fn look(arguments: &Arguments) -> miette::Result<Seen> {
    let mut reader = open(arguments)?;
    let format = reader.format();
    let mut seen = Seen {
        format,
        size: Size::new(0, 0),
        size_known: true,
        channels: 1,
        skipped: 0,
        out_of_order: reader.out_of_order,
        note: None,
        damage: None,
        start: Micros(0),
        ends: None,
    };
    let mut events = Vec::new();
    let mut start = match (arguments.from_zero, arguments.slice) {
        (false, _) => Some(Micros(0)),
        (true, Some((from, _))) => Some(from),
        (true, None) => None,
    };
    let progress = Progress::new("looking at events", reader.about().events);
    let mut count = 0;
    loop {
        let about = reader.about();
        let channels = about.channels.or((!format.limits().channels).then_some(1));
        if let (Some(size), Some(channels), Some(_)) = (about.size, channels, start) {
            (seen.size, seen.channels) = (size, channels);
            seen.size_known = true;
            break;
        }
        let more = match reader.next_block(&mut events) {
            Ok(more) => more,
            Err(error) if arguments.salvage && is_damage(&error) => break,
            Err(error) => return Err(error.into()),
        };
        // Text says what it is with its first events.
        let about = reader.about();
        let channels = about.channels.or((!format.limits().channels).then_some(1));
        // A span may be stated that begins after the first event.
        let stated = || reader.about().span.map(|(from, _)| from);
        let first = events.first().map(|event: &Event| event.t);
        start = start.or_else(|| first.map(|first| stated().map_or(first, |it| it.min(first))));
        seen.size_known = about.size.is_some();
        (seen.size, seen.channels) = (
            about.size.unwrap_or(reader.reach()),
            channels.unwrap_or(reader.kinds()),
        );
        if !more {
            break;
        }
        count += events.len() as u64;
        progress.at(count);
    }
    progress.finish();
    if seen.size.pixels() == 0 && !arguments.salvage {
        return Err(recording::sizeless(&arguments.a));
    }
    let stated = reader.about().span.map(|(from, _)| from);
    seen.start = start.or(stated).unwrap_or_default();
    Ok(seen)
}

/// Which kinds go to which file.
fn targets(arguments: &Arguments, seen: &Seen) -> Vec<(PathBuf, Option<u8>)> {
    if !arguments.each_kind {
        return vec![(arguments.b.to_path_buf(), arguments.kind)];
    }
    let whole: &Path = &arguments.b;
    let stem = whole.with_extension("");
    // `b.evt2.1` ends in `.1` as far as the system is concerned.
    let (before, own) = match (stem.extension(), whole.extension()) {
        (Some(first), Some(last)) if first.eq_ignore_ascii_case("evt2") && last == "1" => {
            let mut own = first.to_owned();
            own.push(".1");
            (stem.as_path(), Some(own))
        }
        (_, own) => (whole, own.map(OsStr::to_owned)),
    };
    let name = |kind: u8| {
        let mut extension = OsString::from(format!("kind{kind}"));
        if let Some(own) = &own {
            extension.push(".");
            extension.push(own);
        }
        before.with_extension(extension)
    };
    (0..seen.channels)
        .map(|kind| (name(kind), Some(kind)))
        .collect()
}

/// Goes through A once and writes every file.
fn pass(
    arguments: &Arguments,
    format: Format,
    targets: &[(PathBuf, Option<u8>)],
    seen: &mut Seen,
) -> miette::Result<Vec<Written>> {
    let mut reader = open(arguments)?;
    let about = reader.about();
    let (from, to) = arguments.slice.unwrap_or((Micros(0), Micros(u64::MAX)));
    let zero = seen.start;
    let since = |t: Micros| Micros(t.0.saturating_sub(zero.0));
    let mut writers = Vec::new();
    for (path, kind) in targets {
        let head = Head {
            size: seen.size,
            channels: if kind.is_some() { 1 } else { seen.channels },
            names: match kind {
                Some(kind) => about
                    .names
                    .get(usize::from(*kind))
                    .cloned()
                    .into_iter()
                    .collect(),
                None if about.names.len() == usize::from(seen.channels) => about.names.clone(),
                None => Vec::new(),
            },
            span: about
                .span
                .map(|(first, last)| (since(first.clamp(from, to)), since(last.clamp(from, to)))),
            // What is missing is missing of all kinds and all times together.
            dropped: about
                .dropped
                .filter(|_| kind.is_none() && arguments.slice.is_none()),
        };
        let compression = arguments.compression.unwrap_or_default();
        let writer = Writer::create(path, format, compression, &head)?;
        writers.push((writer, *kind, None::<(Micros, Micros)>));
    }
    let progress = Progress::new("converting events", about.events);
    let mut count = 0;
    let (mut events, mut chosen) = (Vec::new(), Vec::new());
    loop {
        match reader.next_block(&mut events) {
            Ok(true) => (),
            Ok(false) => break,
            Err(error) if arguments.salvage && is_damage(&error) => {
                seen.damage = Some(error);
                break;
            }
            Err(error) => return Err(error.into()),
        }
        count += events.len() as u64;
        if let (Some(first), Some(last)) = (events.first(), events.last()) {
            seen.ends = Some((seen.ends.map_or(first.t, |(first, _)| first), last.t));
        }
        if let Some(flip) = arguments.flip {
            for event in &mut events {
                *event = flip.of(*event, seen.size);
            }
        }
        for (writer, kind, ends) in &mut writers {
            let part = choose(&events, &mut chosen, (from, to), zero, *kind);
            writer.put(part)?;
            if let (Some(first), Some(last)) = (part.first(), part.last()) {
                *ends = Some((ends.map_or(first.t, |(first, _)| first), last.t));
            }
        }
        progress.at(count);
        if events.last().is_some_and(|e| e.t >= to) {
            break;
        }
    }
    progress.finish();
    seen.skipped = reader.skipped();
    let dropped = about.dropped.unwrap_or_default();
    // That of aedat2 is of the sides from which pixels are counted.
    let is_told = arguments.flip.is_none() || seen.format != Format::Aedat2;
    let read = reader.note().filter(|_| is_told);
    seen.note = note(arguments, format, read, dropped, seen.ends);
    let mut written = Vec::new();
    for ((writer, _, ends), (path, _)) in writers.into_iter().zip(targets) {
        written.push(Written {
            path: path.clone(),
            events: writer.finish()?,
            ends,
        });
    }
    Ok(written)
}

/// What is to be said of what was read and chosen.
fn note(
    arguments: &Arguments,
    format: Format,
    read: Option<&str>,
    dropped: Dropped,
    ends: Option<(Micros, Micros)>,
) -> Option<String> {
    let mut notes: Vec<String> = read.into_iter().map(str::to_owned).collect();
    if let (Some((from, to)), Some((first, last))) = (arguments.slice, ends)
        && (first >= to || last < from)
    {
        notes.push(format!(
            "no event is in the slice: those read are from {first} to {last}, and slices are in the recording's own times"
        ));
    }
    let part = arguments.slice.is_some() || arguments.kind.is_some() || arguments.each_kind;
    notes.extend(files::untold(dropped, format).filter(|_| !part));
    let dropped = dropped.total();
    if dropped > 0 && part {
        notes.push(format!(
            "{} lost on the way to the recording: of a part it is not known how many",
            counted(dropped, "event")
        ));
    }
    (!notes.is_empty()).then(|| notes.join("; "))
}

/// The events of a slice and a kind, in times from `zero` on; a kind of its own is kind 0.
fn choose<'a>(
    events: &'a [Event],
    chosen: &'a mut Vec<Event>,
    (from, to): (Micros, Micros),
    zero: Micros,
    kind: Option<u8>,
) -> &'a [Event] {
    let start = events.partition_point(|e| e.t < from);
    let end = events.partition_point(|e| e.t < to);
    let part = &events[start..end];
    if kind.is_none() && zero == Micros(0) {
        return part;
    }
    let of_kind = part
        .iter()
        .filter(|e| kind.is_none_or(|kind| e.channel == kind));
    chosen.clear();
    chosen.extend(of_kind.map(|e| Event {
        t: Micros(e.t.0 - zero.0),
        channel: if kind.is_some() { 0 } else { e.channel },
        ..*e
    }));
    chosen
}

/// The table for people, ending with how to open what was written.
fn table(arguments: &Arguments, format: Format, seen: &Seen, written: &[Written]) -> String {
    let kinds = match seen.channels {
        1 => String::new(),
        n => format!(", {n} kinds"),
    };
    let mut lines = vec![format!(
        "read     {}, {}, {}{kinds}",
        arguments.a.display(),
        seen.format,
        seen.size
    )];
    if !seen.size_known {
        lines.push(
            "note     the file does not say its size: the smallest that holds all events is taken (give --size WxH)"
                .into(),
        );
    }
    if seen.skipped > 0 {
        lines.push(format!(
            "note     left out: {} of other things than events of a pixel (triggers, frames, motion, or before the first time)",
            counted(seen.skipped, "record")
        ));
    }
    if seen.out_of_order > 0 {
        let number = counted(seen.out_of_order, "event");
        lines.push(format!(
            "note     sorted by time: {number} came earlier than the one before"
        ));
    }
    if let Some(note) = &seen.note {
        lines.push(format!("note     {note}"));
    }
    if let Some(damage) = &seen.damage {
        lines.push(format!("damage   {damage}"));
        lines.push("         the events before it were kept".into());
    }
    for Written { path, events, ends } in written {
        let when = ends.map_or(String::new(), |(first, last)| {
            format!(
                ", {} to {} s",
                exact_seconds(first.0),
                exact_seconds(last.0)
            )
        });
        lines.push(format!(
            "wrote    {}, {format}, {}{when}",
            path.display(),
            counted(*events, "event")
        ));
    }
    for Written { path, .. } in written.iter().filter(|_| !arguments.b.is_node()) {
        lines.push(format!("open     {}", format.opened_by(path)));
    }
    lines.join("\n") + "\n"
}

/// How to open an event file that a verb has written, as the last line of its table.
#[must_use]
pub fn opened(path: &Path) -> String {
    let line = Format::from_path(path).map(|format| format.opened_by(path));
    line.map_or(String::new(), |line| format!("open     {line}\n"))
}
