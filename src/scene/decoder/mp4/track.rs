//! The video track of a file: its samples, H.264 parameter sets and timescale.

use std::io::{Read, Seek, SeekFrom};

use super::{
    boxes::{BoxHeader, Boxes, Name, Wrong, u32_at},
    colour::Colour,
    edit::{Edit, Edits},
    fragment::{Defaults, FragmentReader},
    table::{self, Sample},
    turn::Turn,
};
use crate::{
    limit::{BOXES, MP4_TABLES},
    scene::observation::playback::Unlike,
};

/// A video track.
pub(super) struct Track {
    /// Samples in decoding order, which is the order of the tables.
    pub samples: Vec<Sample>,
    /// Timescale: units of time in a second.
    pub timescale: u32,
    /// Length of the size field before each NAL unit, in bytes (1 to 4).
    pub length_bytes: usize,
    /// Sequence and picture parameter sets (SPS, PPS), in the order of `avcC`.
    pub parameters: Vec<Vec<u8>>,
    /// Of the box `colr`.
    pub colour: Colour,
    /// How its pictures are turned when they are shown.
    pub turn: Turn,
    /// How players show it otherwise.
    pub unlike: Option<Unlike>,
    /// The part of it that is shown; none: all.
    pub edit: Option<Edit>,
}

/// Why a file has no usable video track.
pub(super) enum NoTrack {
    /// The file cannot be read.
    Unreadable(std::io::Error),
    /// It ends inside a box.
    CutOff(CutOff),
    /// It is not a well-formed mp4.
    Damaged(Wrong),
    /// It is an mp4 without H.264 video.
    Unusable(Wrong),
}

/// A box at the top level whose end is not in the file.
pub(super) struct CutOff {
    /// Its type; none where the file ends before it.
    pub name: Option<Name>,
    /// Where it begins.
    pub start: u64,
    /// Where it would end, at least.
    pub end: u64,
}

impl From<std::io::Error> for NoTrack {
    fn from(cause: std::io::Error) -> Self {
        Self::Unreadable(cause)
    }
}

impl From<Wrong> for NoTrack {
    fn from(wrong: Wrong) -> Self {
        Self::Damaged(wrong)
    }
}

impl Track {
    /// Reads the track of a file of `length` bytes: the tables of `moov`, then those of all
    /// fragments.
    pub fn read(file: &mut (impl Read + Seek), length: u64) -> Result<Self, NoTrack> {
        let (boxes, cut) = top_level_boxes(file, length)?;
        let Some(moov) = boxes.iter().find(|found| found.header.name == *b"moov") else {
            if let Some(cut) = cut {
                return Err(NoTrack::CutOff(cut));
            }
            return Err("it has no box moov, the table of what is in it"
                .to_owned()
                .into());
        };
        let moov = moov.content(file)?;
        let (mut track, id) = Self::from_moov(&moov, length)?;
        let mut fragments = FragmentReader {
            track: id,
            defaults: Defaults::from_moov(&moov, id)?,
            length,
            now: 0,
            samples: &mut track.samples,
        };
        for moof in boxes.iter().filter(|found| found.header.name == *b"moof") {
            fragments.read(&moof.content(file)?, moof.start)?;
        }
        Ok(track)
    }

    /// The video track with the lowest track number, and that number.
    fn from_moov(moov: &[u8], length: u64) -> Result<(Self, u32), NoTrack> {
        let mut video: Option<(u32, &[u8], &[u8])> = None;
        for found in Boxes(moov) {
            let (name, trak) = found?;
            if name != *b"trak" {
                continue;
            }
            // Version 1 of `tkhd` and `mdhd` has 64-bit times before these fields.
            let tkhd = Boxes(trak).get(*b"tkhd")?;
            let id = u32_at(tkhd, if tkhd.first() == Some(&1) { 20 } else { 12 });
            let id = id.ok_or_else(|| short(*b"tkhd"))?;
            let mdia = Boxes(trak).get(*b"mdia")?;
            let hdlr = Boxes(mdia).get(*b"hdlr")?;
            let is_video = hdlr.get(8..12) == Some(b"vide");
            if is_video && video.is_none_or(|(first, ..)| id < first) {
                video = Some((id, trak, tkhd));
            }
        }
        let Some((id, trak, tkhd)) = video else {
            return Err(NoTrack::Unusable("it has no video track".into()));
        };
        let edit = match Edits::read(trak, moov)? {
            Edits::All => None,
            Edits::One(edit) => Some(edit),
            Edits::Other(why) => return Err(NoTrack::Unusable(why)),
        };
        let mdia = Boxes(trak).get(*b"mdia")?;
        let mdhd = Boxes(mdia).get(*b"mdhd")?;
        let timescale = u32_at(mdhd, if mdhd.first() == Some(&1) { 20 } else { 12 });
        let stbl = Boxes(Boxes(mdia).get(*b"minf")?).get(*b"stbl")?;
        // Version, flags and entry count come before the sample entries.
        let stsd = Boxes(stbl).get(*b"stsd")?.get(8..).unwrap_or_default();
        let (codec, entry) = Boxes(stsd).next().ok_or_else(|| short(*b"stsd"))??;
        if !matches!(&codec, b"avc1" | b"avc3") {
            let codec = Name(codec);
            return Err(NoTrack::Unusable(format!(
                "its video is {codec}, not H.264"
            )));
        }
        // The fields of a visual sample entry have 78 bytes; boxes follow.
        let boxes = entry.get(78..).ok_or_else(|| short(codec))?;
        let avcc = Boxes(boxes).get(*b"avcC")?;
        let (length_bytes, parameters) = parameters(avcc).ok_or_else(|| short(*b"avcC"))?;
        let track = Self {
            samples: table::samples(stbl, length)?,
            timescale: timescale.ok_or_else(|| short(*b"mdhd"))?,
            length_bytes,
            parameters,
            // Of boxes behind the parameters, damaged or not, nothing else is taken.
            colour: colour(boxes),
            turn: Turn::from_tkhd(tkhd),
            unlike: unlike(boxes, tkhd),
            edit,
        };
        Ok((track, id))
    }
}

fn short(name: [u8; 4]) -> Wrong {
    format!("box {} is too short", Name(name))
}

/// What the first box `colr` that states a colour says.
fn colour(boxes: &[u8]) -> Colour {
    let found = Boxes(boxes).map_while(Result::ok);
    let found = found.filter(|(name, _)| name == b"colr");
    let mut stated = found.map(|(_, content)| Colour::from_colr(content));
    stated.find(|c| *c != Colour::default()).unwrap_or_default()
}

/// What is not done of how it is to be shown: pixels that are not square (`pasp`), another angle.
fn unlike(boxes: &[u8], tkhd: &[u8]) -> Option<Unlike> {
    if Turn::is_other(tkhd) {
        return Some(Unlike::Angle);
    }
    let mut found = Boxes(boxes).map_while(Result::ok);
    let (_, pasp) = found.find(|(name, _)| name == b"pasp")?;
    Unlike::pixels(u32_at(pasp, 0)?, u32_at(pasp, 4)?)
}

/// The content of `avcC` (ISO/IEC 14496-15, 5.3.3): the length of the size field, and the parameter
/// sets.
fn parameters(avcc: &[u8]) -> Option<(usize, Vec<Vec<u8>>)> {
    let length_bytes = usize::from(avcc.get(4)? & 3) + 1;
    let mut sets = Vec::new();
    let mut at = 5;
    // The count of sequence parameter sets has 5 bits, that of picture parameter sets 8.
    for mask in [0x1f, 0xff] {
        let count = avcc.get(at)? & mask;
        at += 1;
        for _ in 0..count {
            let length = usize::from(u16::from_be_bytes(*avcc.get(at..)?.first_chunk()?));
            at += 2;
            sets.push(avcc.get(at..at + length)?.to_vec());
            at += length;
        }
    }
    Some((length_bytes, sets))
}

/// A box at the top level of a file.
struct TopLevelBox {
    start: u64,
    header: BoxHeader,
}

impl TopLevelBox {
    fn content(&self, file: &mut (impl Read + Seek)) -> Result<Vec<u8>, NoTrack> {
        let size = self.header.whole - self.header.length;
        if size > MP4_TABLES {
            let name = Name(self.header.name);
            let most = MP4_TABLES;
            return Err(format!("box {name} has {size} bytes, expected at most {most}").into());
        }
        let mut content = Vec::new();
        file.seek(SeekFrom::Start(self.start + self.header.length))?;
        file.take(size).read_to_end(&mut content)?;
        if (content.len() as u64) < size {
            return Err(format!("box {} is cut off", Name(self.header.name)).into());
        }
        Ok(content)
    }
}

/// Types of boxes at the top level (ISO/IEC 14496-12, table 1, and those of `QuickTime`): anything else is
/// no box, and says no length.
const TOP_LEVEL: [&[u8; 4]; 14] = [
    b"ftyp", b"pdin", b"moov", b"moof", b"mfra", b"mdat", b"free", b"skip", b"meta", b"styp",
    b"sidx", b"uuid", b"wide", b"udta",
];

impl CutOff {
    /// The box at `start`, of which these are the first bytes, where a file of `length` bytes ends
    /// inside it.
    fn of(bytes: &[u8], start: u64, length: u64) -> Option<Self> {
        if bytes.len() < 8 {
            return Some(Self {
                name: None,
                start,
                end: start + 8,
            });
        }
        let header = BoxHeader::read(bytes, u64::MAX, true).ok()?;
        let end = start.checked_add(header.whole)?;
        (TOP_LEVEL.contains(&&header.name) && end > length).then_some(Self {
            name: Some(Name(header.name)),
            start,
            end,
        })
    }
}

/// The `moov` and `moof` boxes at the top level of a file, in order, and the `mdat` inside which it
/// ends.
fn top_level_boxes(
    file: &mut (impl Read + Seek),
    length: u64,
) -> Result<(Vec<TopLevelBox>, Option<CutOff>), NoTrack> {
    let (mut found, mut start, mut count) = (Vec::new(), 0, 0);
    while start < length {
        count += 1;
        if count > BOXES {
            return Err(format!("it has more than {BOXES} boxes").into());
        }
        file.seek(SeekFrom::Start(start))?;
        let mut bytes = Vec::with_capacity(BoxHeader::LONGEST);
        file.take(BoxHeader::LONGEST as u64)
            .read_to_end(&mut bytes)?;
        let header = match BoxHeader::read(&bytes, length - start, true) {
            Ok(header) => header,
            // A cut-off `mdat` is no reason to refuse the file: its missing samples are noticed
            // when they are read, and those before are there.
            Err(_) if bytes.get(4..8) == Some(b"mdat") => {
                return Ok((found, CutOff::of(&bytes, start, length)));
            }
            Err(wrong) => {
                let cut = CutOff::of(&bytes, start, length);
                return Err(cut.map_or(NoTrack::Damaged(wrong), NoTrack::CutOff));
            }
        };
        let whole = header.whole;
        if matches!(&header.name, b"moov" | b"moof") {
            found.push(TopLevelBox { start, header });
        }
        start += whole;
    }
    Ok((found, None))
}
