//! What a clip says about range and transfer: the box `colr`, else the VUI of its H.264.

use crate::scene::light::{coding::Range, conversion::Source};

/// Range and transfer, as far as they are stated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Colour {
    pub is_full: Option<bool>,
    /// A number of ITU-T H.273, table 3.
    pub transfer: Option<u8>,
}

impl Colour {
    /// What a box `colr` states.
    pub fn from_colr(content: &[u8]) -> Self {
        let transfer = content.get(6..8).and_then(<[u8]>::first_chunk);
        let transfer = transfer.and_then(|two| u8::try_from(u16::from_be_bytes(*two)).ok());
        match content.first_chunk::<4>() {
            Some(b"nclx") => Self {
                is_full: content.get(10).map(|byte| byte & 0x80 != 0),
                transfer,
            },
            // QuickTime's has no range.
            Some(b"nclc") => Self {
                is_full: None,
                transfer,
            },
            _ => Self::default(),
        }
    }

    /// This, and what another says where this says nothing.
    pub fn or(self, other: Self) -> Self {
        Self {
            is_full: self.is_full.or(other.is_full),
            transfer: self.transfer.or(other.transfer),
        }
    }

    /// The samples of the clip, of so many bits. Where nothing is stated the range is limited, as `FFmpeg`
    /// and `OpenCV` take it.
    pub fn source(self, bits: u32) -> Source {
        let range = |is_full| if is_full { Range::Full } else { Range::Limited };
        Source {
            range: self.is_full.map(range),
            ..Source::video(bits, Range::Limited).stating(self.transfer)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_box_is_read() {
        let box_of = |kind: &[u8], rest: &[u8]| Colour::from_colr(&[kind, rest].concat());
        let full = box_of(b"nclx", &[0, 1, 0, 13, 0, 1, 0x80]);
        assert_eq!((full.is_full, full.transfer), (Some(true), Some(13)));
        let limited = box_of(b"nclx", &[0, 1, 0, 1, 0, 1, 0x7f]);
        assert_eq!((limited.is_full, limited.transfer), (Some(false), Some(1)));
        let old = box_of(b"nclc", &[0, 1, 0, 1, 0, 1]);
        assert_eq!((old.is_full, old.transfer), (None, Some(1)));
        assert_eq!(box_of(b"prof", &[0; 20]), Colour::default());
        assert_eq!(Colour::from_colr(b"ncl"), Colour::default());
        // What the box leaves open, the video says.
        assert_eq!(old.or(full).is_full, Some(true));
        assert_eq!(limited.or(full), limited);
    }
}
