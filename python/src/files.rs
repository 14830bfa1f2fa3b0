//! Event files, and two packets compared.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use amacrine::{
    compare::{
        Comparison, Pair,
        score::{Scales, scores_beside},
        window::{self, Point, Redraws},
    },
    event::{
        Dropped,
        file::{self, Compression, Format, FormatError, Loaded, Opening, Reader},
    },
    plane::Size,
    rig::guard::Warning,
    unit::Micros,
};
use miette::{Report, miette};
use numpy::PyArray1;
use pyo3::prelude::*;
use serde::Serialize;

use crate::{
    error::{raised, refused},
    pool, record,
};

/// What a file, or an array, says of its events.
#[derive(Serialize)]
struct About {
    height: usize,
    width: usize,
    size_known: bool,
    channels: u8,
    names: Vec<String>,
    span_us: [u64; 2],
    dropped: Dropped,
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
            names: packet.names.clone(),
            span_us: [packet.span.0.0, packet.span.1.0],
            dropped: packet.dropped,
            skipped: loaded.skipped,
        }
    }
}

fn format(name: Option<&str>) -> PyResult<Option<Format>> {
    let parsed = name.map(str::parse).transpose();
    parsed.map_err(|e: FormatError| raised(e))
}

fn size(of: Option<(usize, usize)>) -> Option<Size> {
    of.map(|(height, width)| Size::new(height, width))
}

/// The events of a file, or of the bytes of a `.npy`.
pub fn load(path: &Path, npy: Option<Vec<u8>>, how: &Opening) -> Result<Loaded, Report> {
    let Some(bytes) = npy else {
        return Ok(file::read_as(path, how)?);
    };
    let how = Opening {
        format: Some(Format::Npy),
        ..*how
    };
    match file::all(Reader::of_bytes(path, bytes, &how)?) {
        (loaded, None) => Ok(loaded),
        (_, Some(damage)) => Err(damage.into()),
    }
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
    let read = pool::work(py, || {
        let loaded = load(&path, None, &how)?;
        let mut bytes = Vec::new();
        record::append(&loaded.packet.events, loaded.packet.channels, &mut bytes);
        Ok((bytes, loaded))
    })?;
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

/// Writes events, the bytes of a `.npy`, whole or not at all.
#[pyfunction]
pub fn write(
    py: Python<'_>,
    path: PathBuf,
    npy: Vec<u8>,
    of: Option<(usize, usize)>,
    channels: Option<u8>,
    names: Vec<String>,
    span_us: Option<(u64, u64)>,
    dropped: (u64, u64, u64, u64, u64),
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
    let how = Opening {
        size: size(of),
        ..Opening::default()
    };
    let written = pool::work(py, || {
        let mut loaded = load(Path::new("events"), Some(npy), &how)?;
        let packet = &mut loaded.packet;
        let stated = channels.map_or(names.len(), usize::from);
        packet.channels = packet.channels.max(stated.min(255) as u8);
        if !names.is_empty() && names.len() != usize::from(packet.channels) {
            return Err(miette!(
                help = "give one name for each kind, or names=[] for none",
                "{} names for {} kinds of cells",
                names.len(),
                packet.channels
            ));
        }
        packet.names = names;
        if let Some((first, last)) = span_us {
            // Nothing happened before or after.
            let (least, most) = packet
                .events
                .first()
                .zip(packet.events.last())
                .map_or((Micros(first), Micros(last)), |(first, last)| {
                    (first.t, last.t)
                });
            packet.span = (Micros(first).min(least), Micros(last).max(most));
        }
        let (no_slot, over_limit, queue_full, merged, unscanned) = dropped;
        packet.dropped = Dropped {
            no_slot,
            over_limit,
            queue_full,
            merged,
            unscanned,
        };
        file::write_as(&path, to, compression, &loaded.packet)?;
        Ok(())
    })?;
    written.map_err(|report: Report| raised(report))
}

/// All that is said of a pair.
#[derive(Serialize)]
struct Compared {
    headline: Headline,
    curve: Vec<Point>,
    #[serde(flatten)]
    comparison: Comparison,
    ruler: BTreeMap<String, Ruled>,
    reference: About,
    judged: About,
    warnings: Vec<Warning>,
}

#[derive(Serialize)]
struct Headline {
    #[serde(flatten)]
    point: Point,
    frame_interval_us: Option<Micros>,
    fps: Option<f64>,
}

/// One metric beside the identical packet and accident.
#[derive(Serialize)]
struct Ruled {
    value: Option<f64>,
    identical: Option<f64>,
    redraw: Option<f64>,
    permuted: Option<f64>,
    lost: Option<f64>,
}

/// One of the two: a file, or the bytes of a `.npy`; the size of its sensor where it is known, and
/// what an array knows of its kinds of cells: how many there are, and their names.
type Side = (
    PathBuf,
    Option<Vec<u8>>,
    Option<(usize, usize)>,
    (Option<u8>, Vec<String>),
);

fn side((path, npy, of, (kinds, names)): Side) -> Result<Loaded, Report> {
    let how = Opening {
        size: size(of),
        ..Opening::default()
    };
    let mut loaded = load(&path, npy, &how)?;
    if let Some(kinds) = kinds {
        loaded.packet.channels = loaded.packet.channels.max(kinds);
        loaded.channels_known = true;
    }
    if !names.is_empty() {
        loaded.packet.names = names;
    }
    Ok(loaded)
}

/// Judges one packet against another, as `amacrine compare --json` does.
#[pyfunction]
pub fn compare(
    py: Python<'_>,
    a: Side,
    b: Side,
    within_us: Option<u64>,
    fps: Option<f64>,
    bins: usize,
    seed: u64,
) -> PyResult<String> {
    if !(1..=1000).contains(&bins) {
        return Err(refused(format!("{bins} bins"), "give 1 to 1000"));
    }
    if let Some(fps) = fps.filter(|fps| !(*fps > 0.0 && fps.is_finite())) {
        return Err(raised(amacrine::scene::SceneError::BadRate { fps }));
    }
    let compared = pool::work(py, || {
        let mut reference = side(a)?;
        let mut judged = side(b)?;
        reference.widen_to(&judged.packet);
        judged.widen_to(&reference.packet);
        let pair = Pair::new(&reference.packet, &judged.packet)?;
        let redraws = Redraws::new(&pair, seed);
        let interval = match fps {
            Some(fps) => Some(window::interval(fps)),
            None => window::frame_interval(&pair),
        };
        let within = within_us.map_or_else(|| window::headline_of(interval), Micros);
        let mut scales = Scales {
            bins,
            seed,
            ..Scales::default()
        };
        scales.within.push(within);
        scales.within.sort_unstable();
        scales.within.dedup();
        let scores = scores_beside(&pair, &scales, &redraws).into_iter();
        let ruler = scores.map(|score| {
            let ruled = Ruled {
                value: score.value,
                identical: score.identical,
                redraw: score.redraw,
                permuted: score.permuted,
                lost: score.lost(),
            };
            (score.metric.key(), ruled)
        });
        let point = Point::new(&pair, &redraws, within);
        let packets = [&reference.packet, &judged.packet];
        let warnings = Warning::of_comparison(packets, within, point.floor);
        Ok(Compared {
            headline: Headline {
                point,
                frame_interval_us: interval,
                fps,
            },
            curve: window::curve(&pair, &redraws),
            comparison: Comparison::from_pair(&pair, within),
            ruler: ruler.collect(),
            reference: About::new(&reference),
            judged: About::new(&judged),
            warnings,
        })
    })?;
    json(&compared.map_err(|report: Report| raised(report))?)
}

/// A result as text.
pub fn json<T: Serialize>(answer: &T) -> PyResult<String> {
    serde_json::to_string(answer)
        .map_err(|cause| refused(format!("the answer cannot be told: {cause}"), "report this"))
}
