//! Edit lists (ISO/IEC 14496-12, 8.6.6): which part of a track is shown. A clip that was cut without
//! being coded anew (`ffmpeg -ss 0.5 -c copy`) holds frames before the cut that decoding needs and
//! nobody is to see.

use std::ops::Range;

use super::boxes::{Boxes, Wrong, u32_at, u64_at};

/// The one part of a track that is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Edit {
    /// Where it begins, in units of the track's timescale.
    start: i64,
    /// How long it is, in units of the movie's timescale; none: to the end.
    length: Option<u64>,
    /// Units of the movie's time in a second.
    movie: u32,
}

/// What an edit list says.
pub(super) enum Edits {
    /// All of the track is shown.
    All,
    /// One part of it.
    One(Edit),
    /// Parts one after another, or one at another speed: why it is not shown.
    Other(Wrong),
}

/// An entry of the list.
struct Entry {
    length: u64,
    /// Negative: nothing is shown for so long.
    start: i64,
    is_plain: bool,
}

impl Edits {
    /// The edit list of a track `trak` in the movie `moov`.
    pub fn read(trak: &[u8], moov: &[u8]) -> Result<Self, Wrong> {
        let list = match Boxes(trak).find(*b"edts")? {
            Some(edts) => Boxes(edts).find(*b"elst")?,
            None => None,
        };
        let Some(list) = list else {
            return Ok(Self::All);
        };
        let mut entries = entries(list).ok_or("box elst is too short")?;
        // An empty edit moves the whole track to a later time: a scene begins with its first frame.
        entries.retain(|entry| entry.start >= 0);
        let [entry] = entries.as_slice() else {
            return Ok(match entries.len() {
                0 => Self::All,
                parts => Self::Other(format!(
                    "its edit list shows {parts} parts of it one after another"
                )),
            });
        };
        if !entry.is_plain {
            return Ok(Self::Other(
                "its edit list shows it at another speed".into(),
            ));
        }
        let mvhd = Boxes(moov).get(*b"mvhd")?;
        let movie = u32_at(mvhd, if mvhd.first() == Some(&1) { 20 } else { 12 });
        let movie = movie.filter(|units| *units > 0);
        Ok(Self::One(Edit {
            start: entry.start,
            // A movie of fragments does not know its length yet.
            length: Some(entry.length).filter(|length| *length > 0),
            movie: movie.ok_or("box mvhd is too short, or its timescale is 0")?,
        }))
    }
}

fn entries(list: &[u8]) -> Option<Vec<Entry>> {
    let is_wide = list.first() == Some(&1);
    let width = if is_wide { 20 } else { 12 };
    let count = u32_at(list, 4)? as usize;
    let table = list.get(8..)?.get(..count.checked_mul(width)?)?;
    let entry = |bytes: &[u8]| {
        Some(Entry {
            length: if is_wide {
                u64_at(bytes, 0)?
            } else {
                u32_at(bytes, 0)?.into()
            },
            start: if is_wide {
                u64_at(bytes, 8)?.cast_signed()
            } else {
                u32_at(bytes, 4)?.cast_signed().into()
            },
            is_plain: u32_at(bytes, width - 4)? == 1 << 16,
        })
    };
    table.chunks_exact(width).map(entry).collect()
}

impl Edit {
    /// Which frames are shown of those at these times, in units of the track's timescale and in
    /// their order.
    pub fn shown(&self, times: &[i64], timescale: u32) -> Range<usize> {
        // Writers that know nothing of the delay of reordered frames begin at 0.
        let first = times.first().map_or(self.start, |t| self.start.max(*t));
        let from = times.partition_point(|time| *time < first);
        let Some(length) = self.length else {
            return from..times.len();
        };
        let units = |movie: u64| i128::from(movie) * i128::from(timescale) / i128::from(self.movie);
        // The length is rounded: a frame that would be shown for one unit of it is not meant.
        let end = i128::from(first) + units(length) - units(1);
        let to = times.partition_point(|time| i128::from(*time) <= end);
        from..to.max(from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames of 512 units of 15,360 a second, two of them late for reordering.
    fn shown(start: i64, length: Option<u64>) -> Range<usize> {
        let times: Vec<i64> = (0..10).map(|n| 1024 + 512 * n).collect();
        let movie = 1000;
        let edit = Edit {
            start,
            length,
            movie,
        };
        edit.shown(&times, 15_360)
    }

    #[test]
    fn frames_of_the_part_are_shown() {
        // 333.3 ms are 10 frames, rounded either way.
        assert_eq!(shown(1024, Some(333)), 0..10);
        assert_eq!(shown(1024, Some(334)), 0..10);
        assert_eq!(shown(0, Some(333)), 0..10);
        assert_eq!(shown(1024, None), 0..10);
        assert_eq!(shown(1024 + 512 * 4, Some(200)), 4..10);
        assert_eq!(shown(1024 + 512 * 4, Some(100)), 4..7);
        assert_eq!(shown(1024 + 512 * 4 - 100, Some(100)), 4..7);
        assert_eq!(shown(1 << 40, Some(100)), 10..10);
    }
}
