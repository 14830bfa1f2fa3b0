//! A clip being decoded: samples are read one by one, frames given in the order in which they are
//! shown.

use std::{
    collections::VecDeque,
    fs::File,
    io::{BufReader, Read, Seek, SeekFrom},
    path::{Path, PathBuf},
};

use rust_h264::{
    decoder::{self, OrderedDecoder},
    nal::parse_annex_b,
};

use super::{
    colour::Colour,
    parameters::Pictures,
    table::Sample,
    track::{CutOff, NoTrack, Track},
    turn::Turn,
};
use crate::{
    catch_panic,
    limit::SAMPLE_BYTES,
    plane::Size,
    scene::{
        checks::{self, MemoryLimit},
        decoder::frame_spacing,
        error::SceneError,
        frame::{Frame, Outline, Scene},
        light::{
            conversion::Source,
            image::{Image, Levels},
        },
        observation::playback::Unlike,
        options::OpenOptions,
        time::frame_rate::Rate,
    },
};

/// What is said where the decoder panics: such video is damaged.
const PANIC: &str = "it is damaged";

/// A clip being decoded.
pub(super) struct H264 {
    path: PathBuf,
    file: BufReader<File>,
    decoder: OrderedDecoder,
    /// Samples still to be read, in decoding order.
    samples: std::vec::IntoIter<Sample>,
    /// Number of samples read so far.
    samples_read: u64,
    /// The memory limit, and the bytes that the decoder needs (`held`).
    room: MemoryLimit,
    held: u128,
    /// What the container says, and the first parameter set that says anything.
    colour: Colour,
    /// Bits of a sample, once a picture was decoded, and what samples stand for.
    depth: Option<(u8, Levels)>,
    turn: Turn,
    unlike: Option<Unlike>,
    /// Length of the size field before each NAL unit, in bytes.
    length_bytes: usize,
    /// Decoded luma planes not yet given, in the order in which they are shown.
    ready: VecDeque<Image>,
    flushed: bool,
    size: Size,
    rate: Rate,
    /// Decoded frames that come before those that are shown.
    passed_over: u64,
    count: u64,
    next: u64,
}

impl H264 {
    pub fn new(path: &Path, options: OpenOptions) -> Result<Self, SceneError> {
        let wrong = |what: String| SceneError::Mp4 {
            path: path.into(),
            what,
        };
        let asked = options.fps;
        let mut file = checks::open_file(path)?;
        let length = checks::length(path, &file)?;
        let track = Track::read(file.get_mut(), length).map_err(|error| match error {
            NoTrack::Unreadable(cause) => SceneError::unreadable(path, cause),
            NoTrack::CutOff(CutOff { name, start, end }) => SceneError::EndsEarly {
                path: path.into(),
                length,
                end,
                start,
                what: name.map_or("a box".to_owned(), |name| format!("box {name}")),
            },
            NoTrack::Damaged(what) => wrong(format!("its tables are damaged: {what}")),
            NoTrack::Unusable(what) => wrong(what),
        })?;
        let samples = track.samples;
        let mut times: Vec<i64> = samples.iter().map(|s| s.shown).collect();
        times.sort_unstable();
        let shown = match track.edit {
            Some(edit) => edit.shown(&times, track.timescale),
            None => 0..times.len(),
        };
        if shown.is_empty() && !times.is_empty() {
            return Err(wrong("its edit list shows none of its frames".into()));
        }
        let found = match asked {
            Some(_) => None,
            None => even_rate(path, &times[shown.clone()], track.timescale)?,
        };
        let count = shown.len() as u64;
        let rate = match count {
            0 => {
                return Err(SceneError::Empty {
                    path: path.into(),
                    missing: "frame",
                });
            }
            1 => Rate::asked_or_assumed(asked),
            _ => Rate::asked_or_found(asked, found, path)?,
        };
        let room = MemoryLimit::new(options);
        let mut parameters = Vec::new();
        let mut held = 0;
        let mut colour = track.colour;
        for unit in &track.parameters {
            check_set(path, unit, room, &mut held, &mut colour)?;
            push_unit(&mut parameters, unit);
        }
        let mut clip = Self {
            path: path.into(),
            file,
            decoder: OrderedDecoder::new(),
            samples: samples.into_iter(),
            samples_read: 0,
            room,
            held,
            colour,
            depth: None,
            turn: track.turn,
            unlike: track.unlike,
            length_bytes: track.length_bytes,
            ready: VecDeque::new(),
            flushed: false,
            size: Size::new(0, 0),
            rate,
            passed_over: shown.start as u64,
            count,
            next: 0,
        };
        clip.decode(&parameters)
            .map_err(|e| wrong(format!("its H.264 parameters cannot be used: {e}")))?;
        // The size is that of the first decoded picture: the one in the container may be of a
        // scaled display.
        clip.fill()?;
        let Some(first) = clip.ready.front() else {
            return Err(clip.wrong("no picture could be decoded"));
        };
        clip.size = first.size();
        Ok(clip)
    }

    /// What its samples are.
    pub fn source(&self) -> Source {
        let bits = self.depth.as_ref().map_or(8, |(bits, _)| *bits);
        self.colour.source(bits.into())
    }

    /// How its pictures are turned when they are shown.
    pub const fn turn(&self) -> Turn {
        self.turn
    }

    fn wrong(&self, what: impl Into<String>) -> SceneError {
        SceneError::Mp4 {
            path: self.path.clone(),
            what: what.into(),
        }
    }

    /// Decodes samples until a picture is ready or the clip is over.
    fn fill(&mut self) -> Result<(), SceneError> {
        while self.ready.is_empty() && !self.flushed {
            if let Some(sample) = self.samples.next() {
                let coded = self.read(sample)?;
                self.samples_read += 1;
                if let Err(e) = self.decode(&coded) {
                    let id = self.samples_read - 1;
                    return Err(self.wrong(format!("sample {id} cannot be decoded: {e}")));
                }
            } else {
                self.flushed = true;
                let last = catch_panic::catch_ok(|| self.decoder.flush());
                let last = last.map_or(Err(PANIC.to_owned()), |pictures| self.keep(pictures));
                last.map_err(|e| self.wrong(format!("its last frames cannot be decoded: {e}")))?;
            }
        }
        Ok(())
    }

    /// Gives units, each behind a start code, to the decoder, which puts pictures in the order in
    /// which they are shown.
    fn decode(&mut self, units: &[u8]) -> Result<(), String> {
        for unit in &parse_annex_b(units) {
            let decoded = catch_panic::catch_ok(|| self.decoder.decode_nal(unit));
            let pictures = decoded.ok_or(PANIC)?.map_err(|e| e.to_string())?;
            self.keep(pictures)?;
        }
        Ok(())
    }

    fn keep(&mut self, pictures: Vec<decoder::Frame>) -> Result<(), String> {
        for picture in pictures {
            let of_it = picture.bit_depth;
            let depth = || (of_it, Levels::of_bits(of_it.into()));
            let (bits, levels) = self.depth.get_or_insert_with(depth);
            if *bits != of_it {
                return Err(format!("its samples have {bits} bits, and then {of_it}"));
            }
            let light = luma(picture, levels);
            self.ready.push_back(light.ok_or("too few pixels")?);
        }
        Ok(())
    }

    /// Reads a sample and converts it to Annex B: start codes in place of the size fields.
    fn read(&mut self, sample: Sample) -> Result<Vec<u8>, SceneError> {
        if sample.size > SAMPLE_BYTES {
            return Err(self.wrong(format!(
                "sample {} has {} bytes, expected at most {SAMPLE_BYTES}",
                self.samples_read, sample.size
            )));
        }
        let mut bytes = Vec::new();
        self.file
            .seek(SeekFrom::Start(sample.offset))
            .and_then(|_| (&mut self.file).take(sample.size).read_to_end(&mut bytes))
            .map_err(|cause| SceneError::unreadable(&self.path, cause))?;
        if (bytes.len() as u64) < sample.size {
            return Err(SceneError::Truncated {
                path: self.path.clone(),
                frame: self.samples_read,
                got: bytes.len() as u64,
                want: sample.size,
            });
        }
        let mut coded = Vec::with_capacity(bytes.len() + 16);
        let mut rest = bytes.as_slice();
        while !rest.is_empty() {
            let unit = rest
                .split_at_checked(self.length_bytes)
                .map(|(length, after)| {
                    let length = length.iter().fold(0, |all, b| all << 8 | usize::from(*b));
                    after.split_at_checked(length)
                });
            let Some(Some((unit, after))) = unit else {
                return Err(self.wrong(format!("sample {} has a damaged unit", self.samples_read)));
            };
            check_set(
                &self.path,
                unit,
                self.room,
                &mut self.held,
                &mut self.colour,
            )?;
            push_unit(&mut coded, unit);
            rest = after;
        }
        Ok(coded)
    }
}

impl Scene for H264 {
    fn outline(&self) -> Outline {
        let light = checks::PIXEL_BYTES_HELD * self.size.pixels() as u128;
        Outline {
            frames: Some(self.count),
            unlike: self.unlike,
            bytes: self.held + light + self.samples.len() as u128 * size_of::<Sample>() as u128,
            ..Outline::at(self.rate, self.size)
        }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        let index = self.next;
        if index == self.count {
            return Ok(None);
        }
        self.fill()?;
        while self.passed_over > 0 && self.ready.pop_front().is_some() {
            self.passed_over -= 1;
            self.fill()?;
        }
        let Some(light) = self.ready.pop_front() else {
            let count = self.count;
            return Err(self.wrong(format!(
                "only {index} of its {count} frames could be decoded"
            )));
        };
        if light.size() != self.size {
            return Err(SceneError::OddSize {
                path: self.path.clone(),
                frame: index,
                got: light.size(),
                want: self.size,
            });
        }
        self.next += 1;
        Ok(Some(Frame {
            index,
            seconds: self.rate.seconds(index),
            light,
        }))
    }
}

/// Where a NAL unit is a sequence parameter set, refuses pictures that are too large, before the
/// decoder allocates them, and notes what their samples mean.
fn check_set(
    path: &Path,
    unit: &[u8],
    room: MemoryLimit,
    held: &mut u128,
    colour: &mut Colour,
) -> Result<(), SceneError> {
    let Some(pictures) = Pictures::from_unit(unit) else {
        return Ok(());
    };
    if let Some(what) = pictures.refusal() {
        return Err(SceneError::Mp4 {
            path: path.into(),
            what,
        });
    }
    *colour = colour.or(pictures.colour);
    let side = |n: u64| usize::try_from(n).unwrap_or(usize::MAX);
    let size = checks::checked_size(path, side(pictures.height), side(pictures.width))?;
    *held = (*held).max(pictures.bytes());
    room.check(
        path,
        size,
        *held + checks::PIXEL_BYTES * size.pixels() as u128,
    )
}

fn push_unit(coded: &mut Vec<u8>, unit: &[u8]) {
    coded.extend([0, 0, 0, 1]);
    coded.extend(unit);
}

/// The luma plane of a decoded picture, as coded.
fn luma(picture: decoder::Frame, levels: &Levels) -> Option<Image> {
    let side = |n: u32| usize::try_from(n).ok();
    let size = Size::new(side(picture.height)?, side(picture.width)?);
    if picture.bytes_per_sample() == 1 {
        return Image::of_bytes(size, picture.y, levels.clone());
    }
    let (pairs, _) = picture.y.as_chunks();
    let codes = pairs.iter().map(|&pair| u16::from_le_bytes(pair)).collect();
    Image::of_words(size, codes, levels.clone())
}

/// The frame rate, from the composition times in their order; an error where they are not evenly
/// spaced.
fn even_rate(path: &Path, times: &[i64], unit: u32) -> Result<Option<f64>, SceneError> {
    let (Some(&first), Some(&last)) = (times.first(), times.last()) else {
        return Ok(None);
    };
    let (unit, steps) = (f64::from(unit), times.len() - 1);
    if steps == 0 || unit == 0.0 || first == last {
        return Ok(None);
    }
    let after = |time: i64| (i128::from(time) - i128::from(first)) as f64;
    let seconds: Vec<f64> = times.iter().map(|time| after(*time) / unit).collect();
    let rounded = frame_spacing::check(path, &seconds, unit.recip())?;
    Ok(Some(rounded.unwrap_or(unit * steps as f64 / after(last))))
}
