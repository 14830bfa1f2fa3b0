//! Movie fragments (ISO/IEC 14496-12, 8.8): a `moof` box lists the samples of the piece of the file
//! that follows it.

use super::{
    boxes::{Boxes, Wrong, u32_at, u64_at},
    table::{Sample, check_count},
};

/// Values of samples for which a fragment gives none of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Defaults {
    duration: u32,
    size: u32,
}

impl Defaults {
    /// The defaults of a track, from `mvex`/`trex` in `moov`.
    pub fn from_moov(moov: &[u8], track: u32) -> Result<Self, Wrong> {
        let Some(mvex) = Boxes(moov).find(*b"mvex")? else {
            return Ok(Self::default());
        };
        for found in Boxes(mvex) {
            let (name, trex) = found?;
            if name == *b"trex" && u32_at(trex, 4) == Some(track) {
                let word = |at| u32_at(trex, at).ok_or("box trex is too short");
                return Ok(Self {
                    duration: word(12)?,
                    size: word(16)?,
                });
            }
        }
        Ok(Self::default())
    }
}

/// Collects the samples of one track from fragment after fragment.
pub(super) struct FragmentReader<'a> {
    pub track: u32,
    pub defaults: Defaults,
    /// Length of the file in bytes.
    pub length: u64,
    /// Decoding time of the next sample, in units of the track's timescale.
    pub now: i64,
    pub samples: &'a mut Vec<Sample>,
}

impl FragmentReader<'_> {
    /// Adds the samples of one `moof` box, which begins at byte `start` of the file.
    pub fn read(&mut self, moof: &[u8], start: u64) -> Result<(), Wrong> {
        for found in Boxes(moof) {
            let (name, traf) = found?;
            if name != *b"traf" {
                continue;
            }
            let tfhd = Boxes(traf).get(*b"tfhd")?;
            if u32_at(tfhd, 4) == Some(self.track) {
                self.track_fragment(traf, tfhd, start)?;
            }
        }
        Ok(())
    }

    /// Adds the samples of a track fragment `traf`; `tfhd` is its header, and `start` the first
    /// byte of the `moof`, from which offsets count by default.
    fn track_fragment(&mut self, traf: &[u8], tfhd: &[u8], start: u64) -> Result<(), Wrong> {
        // The flags of `tfhd` (8.8.7) say which optional fields are there, in this order: base
        // offset, sample description, default duration, default size.
        let mut fields = Words { bytes: tfhd, at: 8 };
        let flags = u32_at(tfhd, 0).unwrap_or(0);
        let has = |bit: u32| flags & bit != 0;
        let base = if has(0x1) { fields.long()? } else { start };
        if has(0x2) {
            fields.word()?;
        }
        let mut defaults = self.defaults;
        if has(0x8) {
            defaults.duration = fields.word()?;
        }
        if has(0x10) {
            defaults.size = fields.word()?;
        }
        if let Some(tfdt) = Boxes(traf).find(*b"tfdt")? {
            let wide = tfdt.first() == Some(&1);
            let time = if wide {
                u64_at(tfdt, 4)
            } else {
                u32_at(tfdt, 4).map(u64::from)
            };
            let time = time.ok_or("box tfdt is too short")?;
            self.now = i64::try_from(time).map_err(|_| beyond())?;
        }
        let mut offset = base;
        for found in Boxes(traf) {
            let (name, trun) = found?;
            if name == *b"trun" {
                self.samples(trun, base, &mut offset, defaults)?;
            }
        }
        Ok(())
    }

    /// Adds the samples of a track run `trun`. `base` is where offsets count from; `offset` is where
    /// the samples begin if the run does not say it, and is moved behind them.
    fn samples(
        &mut self,
        trun: &[u8],
        base: u64,
        offset: &mut u64,
        defaults: Defaults,
    ) -> Result<(), Wrong> {
        // The flags of `trun` (8.8.8) say what stands once (data offset, flags of the first sample)
        // and what for each sample (duration, size, flags, composition offset).
        let mut fields = Words { bytes: trun, at: 0 };
        let flags = fields.word()?;
        let has = |bit: u32| flags & bit != 0;
        let count = u64::from(fields.word()?);
        check_count(self.samples.len() as u64 + count, self.length)?;
        if has(0x1) {
            let by = fields.word()?.cast_signed();
            let place = base.checked_add_signed(by.into());
            *offset = place.ok_or("a run of samples begins before the file")?;
        }
        if has(0x4) {
            fields.word()?;
        }
        for _ in 0..count {
            let or = |given: bool, fields: &mut Words<'_>, default| {
                if given { fields.word() } else { Ok(default) }
            };
            let duration = or(has(0x100), &mut fields, defaults.duration)?;
            let size = u64::from(or(has(0x200), &mut fields, defaults.size)?);
            or(has(0x400), &mut fields, 0)?;
            let shift = or(has(0x800), &mut fields, 0)?.cast_signed();
            let shown = self.now.checked_add(shift.into()).ok_or_else(beyond)?;
            self.samples.push(Sample {
                offset: *offset,
                size,
                shown,
            });
            *offset = offset.checked_add(size).ok_or_else(beyond)?;
            self.now = self.now.checked_add(duration.into()).ok_or_else(beyond)?;
        }
        Ok(())
    }
}

fn beyond() -> Wrong {
    "a fragment lies beyond any file, or any time".into()
}

/// A cursor over big-endian words.
struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Words<'_> {
    fn word(&mut self) -> Result<u32, Wrong> {
        let word = u32_at(self.bytes, self.at).ok_or("a fragment's table is cut off")?;
        self.at += 4;
        Ok(word)
    }

    fn long(&mut self) -> Result<u64, Wrong> {
        let long = u64_at(self.bytes, self.at).ok_or("a fragment's table is cut off")?;
        self.at += 8;
        Ok(long)
    }
}
