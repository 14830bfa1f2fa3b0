//! The sample tables of a track (ISO/IEC 14496-12, 8.6 and 8.7): where its samples are, how large,
//! and when they are shown.
//!
//! | box | what it is |
//! |---|---|
//! | `stsz` | sample sizes |
//! | `stco`, `co64` | chunk offsets in the file, 32 or 64 bits |
//! | `stsc` | runs of chunks with the same number of samples |
//! | `stts` | decoding times, as runs of equal durations |
//! | `ctts` | composition offsets: from decoding time to the time at which a sample is shown |

use super::boxes::{Boxes, Name, Wrong, u32_at, u64_at};
use crate::limit::SAMPLES;

/// One coded picture ("sample").
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Sample {
    /// Offset of its first byte in the file.
    pub offset: u64,
    /// Size in bytes.
    pub size: u64,
    /// Composition time, at which it is shown, in units of the track's timescale.
    pub shown: i64,
}

/// A table whose entries lie within their box.
struct Table<'a> {
    entries: &'a [u8],
    width: usize,
}

impl<'a> Table<'a> {
    /// The table in box `name`: its entry count is at byte `before`, its entries of `width` bytes
    /// follow.
    fn new(name: [u8; 4], content: &'a [u8], before: usize, width: usize) -> Result<Self, Wrong> {
        let count = u32_at(content, before);
        let rest = content.get(before + 4..).unwrap_or_default();
        let count = count.ok_or_else(|| format!("box {} is too short", Name(name)))?;
        let bytes = (count as usize).checked_mul(width);
        match bytes.and_then(|bytes| rest.get(..bytes)) {
            Some(entries) => Ok(Self { entries, width }),
            None => Err(format!(
                "box {} says it has {count} entries, but {} are there",
                Name(name),
                rest.len() / width
            )),
        }
    }

    fn len(&self) -> usize {
        self.entries.len() / self.width
    }

    /// The entries, each as three big-endian 32-bit words; an entry of fewer is filled up with
    /// zeros.
    fn words(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        let word = |entry: &[u8], at: usize| u32_at(entry, 4 * at).unwrap_or(0);
        self.entries
            .chunks_exact(self.width)
            .map(move |entry| [0, 1, 2].map(|at| word(entry, at)))
    }
}

/// The samples of a track's sample table box `stbl`, in a file of `length` bytes.
pub(super) fn samples(stbl: &[u8], length: u64) -> Result<Vec<Sample>, Wrong> {
    let sizes = Sizes::read(Boxes(stbl).get(*b"stsz")?, length)?;
    let mut samples: Vec<Sample> = Vec::new();
    if sizes.count > 0 {
        place_in_chunks(stbl, &sizes, &mut samples)?;
    }
    // Decoding times: durations are run-length coded, and summed up from 0.
    let times = Boxes(stbl).get(*b"stts")?;
    let times = Table::new(*b"stts", times, 4, 8)?;
    check_total(*b"stts", &times, samples.len())?;
    let mut now = 0_i64;
    let runs = times
        .words()
        .flat_map(|[n, step, _]| (0..n).map(move |_| step));
    for (sample, step) in samples.iter_mut().zip(runs) {
        sample.shown = now;
        // No overflow: at most 2^22 samples of 2^32 units.
        now += i64::from(step);
    }
    // Composition offsets: how much later than decoded a sample is shown. Version 1 has signed
    // ones; writers of version 0 use them as well.
    if let Some(shifts) = Boxes(stbl).find(*b"ctts")? {
        let shifts = Table::new(*b"ctts", shifts, 4, 8)?;
        check_total(*b"ctts", &shifts, samples.len())?;
        let runs = shifts
            .words()
            .flat_map(|[n, by, _]| (0..n).map(move |_| by));
        for (sample, by) in samples.iter_mut().zip(runs) {
            sample.shown += i64::from(by.cast_signed());
        }
    }
    Ok(samples)
}

/// Checks that the runs of a table (`stts`, `ctts`) cover all samples.
fn check_total(name: [u8; 4], runs: &Table<'_>, samples: usize) -> Result<(), Wrong> {
    let all: u64 = runs.words().map(|[n, ..]| u64::from(n)).sum();
    if all == samples as u64 {
        return Ok(());
    }
    let name = Name(name);
    Err(format!(
        "box {name} is about {all} samples, box stsz about {samples}"
    ))
}

/// The sample sizes of `stsz`.
struct Sizes<'a> {
    count: u64,
    /// The common size of all samples, or 0 where each has its own.
    common: u32,
    each: Option<Table<'a>>,
}

impl<'a> Sizes<'a> {
    fn read(content: &'a [u8], length: u64) -> Result<Self, Wrong> {
        let short = || "box stsz is too short".to_owned();
        let common = u32_at(content, 4).ok_or_else(short)?;
        let count = u64::from(u32_at(content, 8).ok_or_else(short)?);
        check_count(count, length)?;
        let each = match common {
            0 => Some(Table::new(*b"stsz", content, 8, 4)?),
            _ => None,
        };
        if count * u64::from(common) > length {
            return Err(format!(
                "box stsz says {count} samples of {common} bytes; the whole file has {length} bytes"
            ));
        }
        Ok(Self {
            count,
            common,
            each,
        })
    }

    fn all(&self) -> impl Iterator<Item = u64> + '_ {
        let each = self.each.iter().flat_map(Table::words);
        let each = each.map(|[size, ..]| u64::from(size));
        let alike = if self.each.is_none() { self.count } else { 0 };
        each.chain((0..alike).map(|_| u64::from(self.common)))
    }
}

/// Checks that a file of `length` bytes can have `count` samples.
pub(super) fn check_count(count: u64, length: u64) -> Result<(), Wrong> {
    if count > length {
        return Err(format!(
            "it says it has {count} samples, more than its {length} bytes"
        ));
    }
    if count > SAMPLES {
        return Err(format!("it has {count} samples, more than {SAMPLES}"));
    }
    Ok(())
}

/// Adds the samples with their offsets: `stco` or `co64` has the offset of each chunk, `stsc` how
/// many samples are in it, and the samples of a chunk follow each other.
fn place_in_chunks(stbl: &[u8], sizes: &Sizes<'_>, samples: &mut Vec<Sample>) -> Result<(), Wrong> {
    let chunks = match Boxes(stbl).find(*b"stco")? {
        Some(near) => Table::new(*b"stco", near, 4, 4)?,
        None => Table::new(*b"co64", Boxes(stbl).get(*b"co64")?, 4, 8)?,
    };
    let runs = Table::new(*b"stsc", Boxes(stbl).get(*b"stsc")?, 4, 12)?;
    let mut runs = runs.words().peekable();
    let mut sizes_left = sizes.all();
    let mut in_chunk = None;
    samples.reserve(sizes.count as usize);
    for chunk in 0..chunks.len() {
        // A run starts at the chunk that it names, counted from 1, and lasts until the next.
        while let Some([_, count, _]) = runs.next_if(|[first, ..]| *first == chunk as u32 + 1) {
            in_chunk = Some(count);
        }
        let count = in_chunk.ok_or("box stsc does not begin with the first chunk")?;
        let entry = chunks
            .entries
            .get(chunk * chunks.width..)
            .unwrap_or_default();
        let mut offset = match chunks.width {
            4 => u32_at(entry, 0).map(u64::from),
            _ => u64_at(entry, 0),
        }
        .unwrap_or(0);
        for size in sizes_left.by_ref().take(count as usize) {
            samples.push(Sample {
                offset,
                size,
                shown: 0,
            });
            offset = offset
                .checked_add(size)
                .ok_or("a chunk lies beyond any file")?;
        }
    }
    if let Some([first, ..]) = runs.next() {
        let chunks = chunks.len();
        return Err(format!(
            "box stsc speaks of chunk {first}; there are {chunks}, in order"
        ));
    }
    if samples.len() as u64 != sizes.count {
        return Err(format!(
            "its chunks hold {} samples, box stsz says {}",
            samples.len(),
            sizes.count
        ));
    }
    Ok(())
}
