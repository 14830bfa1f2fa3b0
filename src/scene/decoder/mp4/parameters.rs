//! The picture size of an H.264 stream, read before the decoder allocates pictures, and what their
//! samples mean.
//!
//! Parses a sequence parameter set (SPS; ITU-T H.264, 7.3.2.1.1) as far as the picture size and the
//! description of the video signal (E.1.1).

use bitstream_io::{BigEndian, BitRead, BitReader};

use super::colour::Colour;

/// How colour is sampled beside luma (`chroma_format_idc`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Chroma {
    /// 4:2:0, or none.
    #[default]
    Quarter,
    /// 4:2:2.
    Half,
    /// 4:4:4.
    Full,
}

impl Chroma {
    const fn of(format: u64) -> Self {
        match format {
            2 => Self::Half,
            3 => Self::Full,
            _ => Self::Quarter,
        }
    }
}

/// The pictures that a decoder must hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Pictures {
    /// Height in pixels, a multiple of a macroblock's 16.
    pub height: u64,
    /// Width in pixels, a multiple of 16.
    pub width: u64,
    /// Number of reference frames (`max_num_ref_frames`).
    pub references: u64,
    /// How its colour is sampled.
    pub chroma: Chroma,
    /// Bits of a sample of luma.
    pub bits: u64,
    /// Whether pictures may be of fields, half a frame each.
    pub has_fields: bool,
    /// Whether it may be coded without loss, past the transform.
    pub is_lossless: bool,
    /// What the set says about range and transfer.
    pub colour: Colour,
}

impl Pictures {
    /// Why they are not read, where they are not.
    pub fn refusal(self) -> Option<String> {
        if self.chroma == Chroma::Full {
            return Some("its colour is coded in 4:4:4, which is not read".to_owned());
        }
        if ![8, 10].contains(&self.bits) {
            return Some(format!("its samples have {} bits, not 8 or 10", self.bits));
        }
        if self.has_fields {
            return Some(
                "it is coded as interlaced video: the lines of a frame are from two moments"
                    .to_owned(),
            );
        }
        self.is_lossless.then(|| {
            "it is coded without loss (a high 4:4:4 profile), which is not read".to_owned()
        })
    }

    /// Reads a NAL unit that is a sequence parameter set; `None` for all other units, and for one
    /// that ends too early.
    pub fn from_unit(unit: &[u8]) -> Option<Self> {
        let (head, set) = unit.split_first()?;
        // nal_unit_type 7: a sequence parameter set
        if head & 0x1f != 7 {
            return None;
        }
        let bytes = unescaped(set.get(..set.len().min(LONGEST))?);
        Bits(BitReader::new(bytes.as_slice())).parameter_set()
    }

    /// Upper bound on the decoder's memory in bytes: frames with borders and their motion, the
    /// reference frames, those that wait for their turn, and four more that are in work.
    pub fn bytes(self) -> u128 {
        let border = 64;
        let pixels = u128::from(self.height + border) * u128::from(self.width + border);
        let halves = if self.chroma == Chroma::Half { 4 } else { 3 };
        let sample = self.bits.div_ceil(8);
        let frame = pixels * u128::from(halves * sample + 2) / 2;
        frame * u128::from(self.references + WAITING + 4)
    }
}

/// Frames that the decoder holds back at most, until those before them are decoded.
const WAITING: u64 = 16;

/// Bytes of a parameter set that are looked at; its largest scaling lists take fewer.
const LONGEST: usize = 4096;

/// Removes emulation prevention bytes: a 3 that follows two zeros (H.264, 7.4.1).
fn unescaped(set: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(set.len());
    let mut zeros = 0;
    for byte in set {
        if zeros >= 2 && *byte == 3 {
            zeros = 0;
            continue;
        }
        zeros = if *byte == 0 { zeros + 1 } else { 0 };
        bytes.push(*byte);
    }
    bytes
}

struct Bits<'a>(BitReader<&'a [u8], BigEndian>);

impl Bits<'_> {
    fn parameter_set(&mut self) -> Option<Pictures> {
        let profile = self.bits(8)?; // profile_idc
        self.bits(16)?; // constraint flags, level_idc
        self.number()?; // seq_parameter_set_id
        // The high profiles have fields for chroma, bit depth and scaling lists.
        let (mut chroma, mut bits, mut is_lossless) = (Chroma::default(), 8, false);
        if matches!(
            profile,
            100 | 110 | 122 | 244 | 44 | 83 | 86 | 118 | 128 | 134 | 135 | 138 | 139
        ) {
            let format = self.number()?; // chroma_format_idc
            chroma = Chroma::of(format);
            if chroma == Chroma::Full {
                self.bits(1)?; // separate_colour_plane_flag
            }
            bits += self.number()?; // bit_depth_luma_minus8
            self.number()?; // bit_depth_chroma_minus8
            is_lossless = self.bits(1)? == 1; // qpprime_y_zero_transform_bypass_flag
            if self.bits(1)? == 1 {
                self.skip_scaling_lists(if chroma == Chroma::Full { 12 } else { 8 })?;
            }
        }
        self.number()?; // log2_max_frame_num_minus4
        // pic_order_cnt_type, and the fields of each type
        match self.number()? {
            0 => {
                self.number()?;
            }
            1 => {
                self.bits(1)?;
                self.number()?;
                self.number()?;
                for _ in 0..self.number()?.min(255) {
                    self.number()?;
                }
            }
            _ => {}
        }
        let references = self.number()?; // max_num_ref_frames
        self.bits(1)?; // gaps_in_frame_num_value_allowed_flag
        let width = self.number()? + 1; // in macroblocks
        let rows = self.number()? + 1;
        // Without frame_mbs_only_flag the height is counted in fields, half a frame each.
        let fields = 2 - u64::from(self.bits(1)?);
        Some(Pictures {
            height: 16 * rows * fields,
            width: 16 * width,
            references,
            chroma,
            bits,
            has_fields: fields == 2,
            is_lossless,
            // A set that ends here has said enough to be decoded.
            colour: self.colour(fields == 2).unwrap_or_default(),
        })
    }

    /// The rest of a set, up to the description of the video signal.
    fn colour(&mut self, has_fields: bool) -> Option<Colour> {
        self.bits(if has_fields { 2 } else { 1 })?;
        // The part that is shown.
        if self.bits(1)? == 1 {
            for _ in 0..4 {
                self.number()?;
            }
        }
        let mut colour = Colour::default();
        if self.bits(1)? == 0 {
            return Some(colour);
        }
        // The shape of a pixel: 255 says it in numbers.
        if self.bits(1)? == 1 && self.bits(8)? == 255 {
            self.bits(32)?;
        }
        // Whether overscan may be shown.
        if self.bits(1)? == 1 {
            self.bits(1)?;
        }
        if self.bits(1)? == 1 {
            self.bits(3)?;
            colour.is_full = Some(self.bits(1)? == 1);
            if self.bits(1)? == 1 {
                self.bits(8)?;
                colour.transfer = self.bits(8)?.try_into().ok();
                self.bits(8)?;
            }
        }
        Some(colour)
    }

    /// Skips scaling lists (7.3.2.1.1.1), whose length depends on what is in them.
    fn skip_scaling_lists(&mut self, lists: usize) -> Option<()> {
        for list in 0..lists {
            if self.bits(1)? == 0 {
                continue;
            }
            let (mut last, mut next) = (8_i64, 8_i64);
            for _ in 0..if list < 6 { 16 } else { 64 } {
                if next != 0 {
                    // A signed Exp-Golomb code: k stands for 0, 1, -1, 2, -2, …
                    let k = self.number()? as i64;
                    let delta = if k % 2 == 1 { k / 2 + 1 } else { -(k / 2) };
                    next = (last + delta).rem_euclid(256);
                }
                last = if next == 0 { last } else { next };
            }
        }
        Some(())
    }

    fn bits(&mut self, n: u32) -> Option<u32> {
        self.0.read_var(n).ok()
    }

    /// An unsigned Exp-Golomb code (`ue(v)`) of at most 32 bits.
    fn number(&mut self) -> Option<u64> {
        let zeros = self.0.read_unary::<1>().ok().filter(|zeros| *zeros <= 32)?;
        let rest: u64 = self.0.read_var(zeros).ok()?;
        Some((1 << zeros) - 1 + rest)
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use proptest::prelude::*;

    use super::*;

    /// The sets of `tests/data/scene/baseline.mp4` and `bframes.mp4`, as x264 wrote them.
    #[test]
    fn the_size_of_a_clip_is_read() {
        for (set, references) in [
            ("6742c00ad90d6840000003004000000503c48992", 3),
            ("6764000aacd94d6840000003004000000503c4896580", 4),
        ] {
            let byte = |at| u8::from_str_radix(&set[at..at + 2], 16).unwrap();
            let set: Vec<u8> = (0..set.len()).step_by(2).map(byte).collect();
            let pictures = Pictures::from_unit(&set).unwrap();
            let want = Pictures {
                height: 32,
                width: 48,
                references,
                chroma: Chroma::Quarter,
                bits: 8,
                has_fields: false,
                is_lossless: false,
                colour: Colour::default(),
            };
            assert_eq!(pictures, want);
            // The last bit that counts, whether frames or fields are coded, is in the seventh
            // byte of the shorter set.
            for end in 0..set.len() {
                let part = Pictures::from_unit(&set[..end]);
                assert!(part.is_none_or(|part| end > 6 && part == want), "{end}");
            }
            assert_eq!(Pictures::from_unit(&[0x68, 1, 2]), None);
        }
    }

    /// Sets that x264 wrote of 10 bits, of interlaced video, and without loss.
    #[test]
    fn what_is_not_read_is_named() {
        for (set, words) in [
            ("676e000aa6cd9447a1000003000100000300140f122596", None),
            (
                "67640015acd9444fcb08000003000800000300a0f8a14cb0",
                Some("interlaced"),
            ),
            (
                "67f4000aaeb208f4d9000003000100000300140f122648",
                Some("without loss"),
            ),
        ] {
            let byte = |at| u8::from_str_radix(&set[at..at + 2], 16).unwrap();
            let set: Vec<u8> = (0..set.len()).step_by(2).map(byte).collect();
            let told = Pictures::from_unit(&set).unwrap().refusal();
            let as_told = told.clone().zip(words).map(|(told, it)| told.contains(it));
            assert_eq!(as_told, words.map(|_| true), "{told:?}");
            assert_eq!(told.is_some(), words.is_some(), "{told:?}");
        }
    }

    /// A set with a description of the video signal, written bit by bit.
    fn described(is_full: bool, transfer: Option<u8>) -> Vec<u8> {
        // Baseline, level 1; six numbers of 0 (a bit of 1 each) but for the widths.
        let mut bits = String::from("01100111");
        for byte in [66_u8, 0, 10] {
            let _ = write!(bits, "{byte:08b}");
        }
        // Set 0; frame numbers and order 0 with its length; 1 picture kept; no gaps.
        bits += "1";
        bits += "1";
        bits += "1";
        bits += "1";
        bits += "010";
        bits += "0";
        // 3 macroblocks wide, 2 high; frames only; one more bit; no cropping.
        bits += "011";
        bits += "010";
        bits += "1";
        bits += "1";
        bits += "0";
        // VUI: no shape, no overscan, a signal of format 5.
        bits += "1001101";
        bits += if is_full { "1" } else { "0" };
        match transfer {
            Some(transfer) => {
                bits += &["1", "00000001", &format!("{transfer:08b}"), "00000001"].concat();
            }
            None => bits += "0",
        }
        bits += "1";
        while bits.len() % 8 != 0 {
            bits += "0";
        }
        let byte = |at: usize| u8::from_str_radix(&bits[at..at + 8], 2).unwrap();
        (0..bits.len()).step_by(8).map(byte).collect()
    }

    #[test]
    fn range_and_transfer_are_read() {
        for is_full in [false, true] {
            for transfer in [None, Some(1), Some(13)] {
                let set = described(is_full, transfer);
                let pictures = Pictures::from_unit(&set).unwrap();
                assert_eq!((pictures.width, pictures.height), (48, 32));
                let want = Colour {
                    is_full: Some(is_full),
                    transfer,
                };
                assert_eq!(pictures.colour, want);
            }
        }
    }

    proptest! {
        #[test]
        fn any_bytes_are_a_set_or_none(mut bytes: Vec<u8>) {
            bytes.insert(0, 0x67);
            if let Some(pictures) = Pictures::from_unit(&bytes) {
                prop_assert!(pictures.height >= 16 && pictures.width >= 16);
            }
        }
    }
}
