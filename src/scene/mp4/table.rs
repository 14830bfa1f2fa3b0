//! The tables of a track: where its samples are, how large, and when they are shown.

use super::boxes::{Boxes, Name, Wrong, u32_at, u64_at};
use crate::limit::SAMPLES;

/// One coded picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Sample {
    /// First byte in the file.
    pub offset: u64,
    /// Length in bytes.
    pub size: u64,
    /// When it is shown, in units of the track.
    pub shown: i64,
}

/// A table whose entries are all in their box.
struct Table<'a> {
    entries: &'a [u8],
    width: usize,
}

impl<'a> Table<'a> {
    /// The table in box `name`, whose number of entries stands after `before` bytes.
    fn new(name: [u8; 4], content: &'a [u8], before: usize, width: usize) -> Result<Self, Wrong> {
        let says = u32_at(content, before);
        let there = content.get(before + 4..).unwrap_or_default();
        let says = says.ok_or_else(|| format!("box {} is too short", Name(name)))?;
        let bytes = (says as usize).checked_mul(width);
        match bytes.and_then(|bytes| there.get(..bytes)) {
            Some(entries) => Ok(Self { entries, width }),
            None => Err(format!(
                "box {} says it has {says} entries, but {} are there",
                Name(name),
                there.len() / width
            )),
        }
    }

    fn len(&self) -> usize {
        self.entries.len() / self.width
    }

    /// The entries, each as its words of four bytes.
    fn words(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        let word = |entry: &[u8], at: usize| u32_at(entry, 4 * at).unwrap_or(0);
        self.entries
            .chunks_exact(self.width)
            .map(move |entry| [0, 1, 2].map(|at| word(entry, at)))
    }
}

/// The samples that the tables in an `stbl` list, of a file of `length` bytes.
pub(super) fn samples(stbl: &[u8], length: u64) -> Result<Vec<Sample>, Wrong> {
    let sizes = Sizes::read(Boxes(stbl).get(*b"stsz")?, length)?;
    let mut samples: Vec<Sample> = Vec::new();
    if sizes.count > 0 {
        lay_out(stbl, &sizes, &mut samples)?;
    }
    let times = Boxes(stbl).get(*b"stts")?;
    let times = Table::new(*b"stts", times, 4, 8)?;
    same(*b"stts", &times, samples.len())?;
    let mut now = 0_i64;
    let runs = times
        .words()
        .flat_map(|[n, step, _]| (0..n).map(move |_| step));
    for (sample, step) in samples.iter_mut().zip(runs) {
        sample.shown = now;
        // At most 2^22 samples of 2^32 units.
        now += i64::from(step);
    }
    if let Some(shifts) = Boxes(stbl).find(*b"ctts")? {
        let shifts = Table::new(*b"ctts", shifts, 4, 8)?;
        same(*b"ctts", &shifts, samples.len())?;
        let runs = shifts
            .words()
            .flat_map(|[n, by, _]| (0..n).map(move |_| by));
        for (sample, by) in samples.iter_mut().zip(runs) {
            sample.shown += i64::from(by.cast_signed());
        }
    }
    Ok(samples)
}

/// Whether a table of runs is about as many samples as there are.
fn same(name: [u8; 4], runs: &Table<'_>, samples: usize) -> Result<(), Wrong> {
    let all: u64 = runs.words().map(|[n, ..]| u64::from(n)).sum();
    if all == samples as u64 {
        return Ok(());
    }
    let name = Name(name);
    Err(format!(
        "box {name} is about {all} samples, box stsz about {samples}"
    ))
}

/// How large the samples are.
struct Sizes<'a> {
    count: u64,
    /// The size of all of them, or 0.
    one: u32,
    each: Option<Table<'a>>,
}

impl<'a> Sizes<'a> {
    fn read(content: &'a [u8], length: u64) -> Result<Self, Wrong> {
        let short = || "box stsz is too short".to_owned();
        let one = u32_at(content, 4).ok_or_else(short)?;
        let count = u64::from(u32_at(content, 8).ok_or_else(short)?);
        check_count(count, length)?;
        let each = match one {
            0 => Some(Table::new(*b"stsz", content, 8, 4)?),
            _ => None,
        };
        if count * u64::from(one) > length {
            return Err(format!(
                "box stsz says {count} samples of {one} bytes; the whole file has {length} bytes"
            ));
        }
        Ok(Self { count, one, each })
    }

    fn all(&self) -> impl Iterator<Item = u64> + '_ {
        let each = self.each.iter().flat_map(Table::words);
        let each = each.map(|[size, ..]| u64::from(size));
        let alike = if self.each.is_none() { self.count } else { 0 };
        each.chain((0..alike).map(|_| u64::from(self.one)))
    }
}

/// Whether there can be so many samples in a file of `length` bytes.
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

/// Samples lie one after another in chunks.
fn lay_out(stbl: &[u8], sizes: &Sizes<'_>, samples: &mut Vec<Sample>) -> Result<(), Wrong> {
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
