//! Event files, and two packets compared.

use std::{
    fs,
    path::{Path, PathBuf},
};

use amacrine::{
    event::{
        Dropped,
        file::{self, Compression, Format, FormatError, Head, Loaded, Opening, Reader, Writer},
    },
    plane::Size,
    save::save as save_file,
    stop::Stop,
    study::comparison::{self, Asked, Frames},
    unit::Micros,
};
use miette::{Report, miette};
use numpy::PyArray1;
use pyo3::prelude::*;
use serde::Serialize;

use crate::{
    error::{raised, refused},
    events::{Borrowed, Events, Given},
    pool, record,
    remade::{By, Maker},
    stop::Flag,
};

/// What a file, or an array, says of its events.
#[derive(Serialize)]
struct About {
    height: usize,
    width: usize,
    size_known: bool,
    channels: u8,
    channels_known: bool,
    names: Vec<String>,
    span_us: [u64; 2],
    /// Nothing where nobody says it.
    dropped: Option<Dropped>,
    skipped: u64,
}

impl About {
    fn new(loaded: &Loaded) -> Self {
        let packet = &loaded.packet;
        Self {
            height: packet.size.height,
            width: packet.size.width,
            size_known: loaded.size_known,
            channels: packet.channels,
            channels_known: loaded.channels_known,
            names: packet.names.clone(),
            span_us: [packet.span.0.0, packet.span.1.0],
            dropped: loaded.dropped_known.then_some(packet.dropped),
            skipped: loaded.skipped,
        }
    }
}

fn format(name: Option<&str>) -> PyResult<Option<Format>> {
    let parsed = name.map(str::parse).transpose();
    parsed.map_err(|e: FormatError| raised(e))
}

/// Height and width.
pub fn size(of: Option<(usize, usize)>) -> Option<Size> {
    of.map(|(height, width)| Size::new(height, width))
}

/// The events of a file as records, and what else it says.
fn records(path: &Path, how: &Opening) -> Result<(Vec<u8>, Loaded), Report> {
    let mut reader = Reader::open(path, how)?;
    let (mut block, mut kinds) = (Vec::new(), 1);
    let mut bytes = Vec::new();
    // What the file says of itself may be wrong: no format has more than eight events a byte.
    let most = fs::metadata(path).map_or(0, |about| about.len().saturating_mul(8));
    let said = reader.about();
    let expected = said.events.unwrap_or(0).min(most) as usize;
    let width = record::width(said.channels.unwrap_or(1));
    let _ = bytes.try_reserve_exact(expected.saturating_mul(width));
    while reader.next_block(&mut block)? {
        let known = reader.about().channels.unwrap_or(reader.kinds());
        if known > 1 && kinds == 1 {
            record::widen(&mut bytes);
        }
        kinds = known;
        record::append(&block, kinds, &mut bytes);
    }
    bytes.shrink_to_fit();
    let loaded = reader.loaded(Vec::new());
    if loaded.packet.channels > 1 && kinds == 1 {
        record::widen(&mut bytes);
    }
    Ok((bytes, loaded))
}

/// The events of a file as the bytes of their records, the number of kinds, and about them in
/// JSON.
#[pyfunction]
pub fn read<'py>(
    py: Python<'py>,
    path: PathBuf,
    kind: Option<&str>,
    of: Option<(usize, usize)>,
    stream: Option<i32>,
) -> PyResult<(Bound<'py, PyArray1<u8>>, u8, String)> {
    let how = Opening {
        format: format(kind)?,
        size: size(of),
        stream,
    };
    let read = pool::work(py, || records(&path, &how))?;
    let (bytes, loaded) = read.map_err(|report: Report| raised(report))?;
    let about = json(&About::new(&loaded))?;
    Ok((PyArray1::from_vec(py, bytes), loaded.packet.channels, about))
}

/// A format that was asked for, which the name of the file must not contradict.
fn unless_contradicted(path: &Path, asked: Format) -> PyResult<Format> {
    let said = Format::named(path);
    if said.is_empty() || said.contains(&asked) {
        return Ok(asked);
    }
    let said: Vec<_> = said.iter().map(|format| format.name()).collect();
    Err(refused(
        format!(
            "{} is the name of {}, and format is {asked}",
            path.display(),
            said.join(" or ")
        ),
        "give another name, or leave format out",
    ))
}

/// Events that found no place, as Python counts them: without a slot, over the limit, at a full
/// queue, merged, in rows that are not scanned.
type Lost = (u64, u64, u64, u64, u64);

fn dropped((no_slot, over_limit, queue_full, merged, unscanned): Lost) -> Dropped {
    Dropped {
        no_slot,
        over_limit,
        queue_full,
        merged,
        unscanned,
    }
}

/// Writes events, whole or not at all.
#[pyfunction]
pub fn write(
    py: Python<'_>,
    path: PathBuf,
    events: &Events,
    of: Option<(usize, usize)>,
    channels: Option<u8>,
    names: Vec<String>,
    span_us: Option<(u64, u64)>,
    lost: Option<Lost>,
    to: Option<&str>,
    compression: &str,
) -> PyResult<()> {
    let to = match format(to)? {
        Some(format) => unless_contradicted(&path, format)?,
        None => Format::from_path(&path).map_err(raised)?,
    };
    let all = [Compression::Lz4, Compression::Zstd, Compression::None];
    let compression = all.into_iter().find(|it| it.name() == compression);
    let compression =
        compression.ok_or_else(|| refused("unknown compression", "give lz4, zstd or none"))?;
    let events = events.borrowed(py)?;
    let given = events.given()?;
    let stated = channels.map_or(names.len(), usize::from);
    let mut packet = given.head(size(of), stated.min(255) as u8);
    if !names.is_empty() && names.len() != usize::from(packet.channels) {
        let kinds = packet.channels;
        return Err(refused(
            format!("{} names for {kinds} kinds of cells", names.len()),
            "give one name for each kind, or names=[] for none",
        ));
    }
    packet.names = names;
    if let Some((first, last)) = span_us {
        // Nothing happened before or after.
        let (least, most) = match given.events() {
            0 => (Micros(first), Micros(last)),
            _ => packet.span,
        };
        packet.span = (Micros(first).min(least), Micros(last).max(most));
    }
    let head = Head {
        dropped: lost.map(dropped),
        ..Head::from_packet(&packet)
    };
    let written = pool::work(py, || {
        let mut writer = Writer::create(&path, to, compression, &head)?;
        for events in given.blocks() {
            writer.put(&events)?;
        }
        writer.finish()?;
        Ok(())
    })?;
    written.map_err(|report: Report| raised(report))
}

/// Writes a text, whole or not at all; a folder that is missing is made.
#[pyfunction]
pub fn save(path: PathBuf, text: &str) -> PyResult<()> {
    save_file(&path, |file| file.write_all(text.as_bytes())).map_err(raised)
}

/// One of the two: a file, or the events of an array, and what it is called; the size of its sensor
/// where it is known, and what an array knows: how many kinds of cells there are, their names, and
/// what is missing of them.
type Side = (
    PathBuf,
    Option<Py<Events>>,
    Option<(usize, usize)>,
    (Option<u8>, Vec<String>, Option<Lost>),
);

fn side(
    (path, _, of, (kinds, names, lost)): &Side,
    events: Option<Given<'_>>,
) -> Result<Loaded, Report> {
    let Some(events) = events else {
        let how = Opening {
            size: size(*of),
            ..Opening::default()
        };
        return Ok(file::read_as(path, &how)?);
    };
    let mut loaded = events.load(size(*of), *kinds);
    loaded.packet.names.clone_from(names);
    loaded.dropped_known = lost.is_some();
    loaded.packet.dropped = lost.map(dropped).unwrap_or_default();
    Ok(loaded)
}

/// The events of an array, where it is none of a file.
fn array<'py>(py: Python<'py>, (_, events, ..): &Side) -> PyResult<Option<Borrowed<'py>>> {
    events.as_ref().map(|it| it.get().borrowed(py)).transpose()
}

/// The error is not shown: what the signal raised is.
fn check(stop: Stop) -> Result<(), Report> {
    if stop.is_asked() {
        return Err(miette!("nobody waits for it"));
    }
    Ok(())
}

/// Judges one packet against another, as `amacrine compare --json` does. On Ctrl-C it ends with the
/// metric that it is at.
#[pyfunction]
pub fn compare(
    py: Python<'_>,
    a: Side,
    b: Side,
    within_us: Option<u64>,
    fps: Option<f64>,
    bins: usize,
    seed: u64,
    by: Option<By<'_>>,
) -> PyResult<String> {
    if !(1..=1000).contains(&bins) {
        return Err(refused(format!("{bins} bins"), "give 1 to 1000"));
    }
    let (one, other) = (array(py, &a)?, array(py, &b)?);
    let one = one.as_ref().map(Borrowed::given).transpose()?;
    let other = other.as_ref().map(Borrowed::given).transpose()?;
    let maker = by.map(By::maker).transpose()?;
    let own = Flag::new();
    let shown = maker.as_ref().map(|maker| &maker.source);
    let (flag, stop) = shown.map_or((own.flag(), own.stop()), |it| (it.flag(), it.stop()));
    let judge = || {
        let mut reference = side(&a, one)?;
        check(stop)?;
        let mut judged = side(&b, other)?;
        check(stop)?;
        reference.widen_to(&judged.packet);
        judged.widen_to(&reference.packet);
        let frames = match (&maker, fps) {
            (Some(maker), _) => Frames::Shown(maker.fps()?),
            (None, Some(fps)) => Frames::Said(fps),
            (None, None) => Frames::Unknown,
        };
        let asked = Asked {
            within: within_us.map(Micros),
            frames,
            bins,
            seed,
            stop,
        };
        let called = a.0.display().to_string();
        let sides = [(a.0.as_path(), &reference), (b.0.as_path(), &judged)];
        let answer = comparison::answer(sides, asked, |packets, within| {
            let equivalent = |it: &Maker| it.equivalent(&called, packets, (within, seed));
            maker.as_ref().map(equivalent).transpose()
        })?;
        Ok(json(&answer))
    };
    let pool = pool::pool()?;
    let compared = pool::watched(py, flag, || pool.install(judge))?;
    let compared = compared.map_err(|report: Report| raised(report))??;
    if let Some(maker) = &maker {
        maker.warn(py)?;
    }
    Ok(compared)
}

/// A result as text.
pub fn json<T: Serialize>(answer: &T) -> PyResult<String> {
    serde_json::to_string(answer)
        .map_err(|cause| refused(format!("the answer cannot be told: {cause}"), "report this"))
}
