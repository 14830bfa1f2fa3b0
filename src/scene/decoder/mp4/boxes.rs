//! The boxes of ISO base media files (ISO/IEC 14496-12, 4.2): a header of size and type, then the
//! content, which may be boxes again.

use std::fmt;

/// A box type: four characters, such as `moov`.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct Name(pub [u8; 4]);

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0.escape_ascii())
    }
}

/// What is wrong with a file, for the error message.
pub(super) type Wrong = String;

/// A box header: size and type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct BoxHeader {
    pub name: [u8; 4],
    /// Length of the header, in bytes: 8, or 16 with a 64-bit size.
    pub length: u64,
    /// Size of the whole box in bytes, header included; at least that of the header.
    pub whole: u64,
}

impl BoxHeader {
    /// Length of the longest header, in bytes.
    pub const LONGEST: usize = 16;

    /// Reads the header at the start of `bytes`, of a box that has `room` bytes to lie in.
    ///
    /// `to_the_end`: whether a size of 0, which means "to the end of the file", is allowed.
    pub fn read(bytes: &[u8], room: u64, to_the_end: bool) -> Result<Self, Wrong> {
        let short = || "a box is cut off inside its head".to_owned();
        let stated = u64::from(u32_at(bytes, 0).ok_or_else(short)?);
        let name: [u8; 4] = *bytes
            .get(4..)
            .and_then(<[u8]>::first_chunk)
            .ok_or_else(short)?;
        // A size of 1 stands for a 64-bit size after the type.
        let (head, whole) = match stated {
            0 if to_the_end => (8, room),
            1 => (16, u64_at(bytes, 8).ok_or_else(short)?),
            size => (8, size),
        };
        if whole < head {
            let name = Name(name);
            return Err(format!(
                "box {name} says it has {whole} bytes, less than its head"
            ));
        }
        if whole > room {
            let name = Name(name);
            return Err(format!(
                "box {name} says it has {whole} bytes, but only {room} are there"
            ));
        }
        Ok(Self {
            name,
            length: head,
            whole,
        })
    }
}

/// Iterates over the boxes in the content of a box. Each step consumes at least the 8 bytes of a
/// header, so it ends.
pub(super) struct Boxes<'a>(pub &'a [u8]);

impl<'a> Boxes<'a> {
    /// Content of the first box of this type; `None` where there is none.
    pub fn find(self, name: [u8; 4]) -> Result<Option<&'a [u8]>, Wrong> {
        for found in self {
            let (its, content) = found?;
            if its == name {
                return Ok(Some(content));
            }
        }
        Ok(None)
    }

    /// Content of the first box of this type, which must be there.
    pub fn get(self, name: [u8; 4]) -> Result<&'a [u8], Wrong> {
        self.find(name)?
            .ok_or_else(|| format!("it has no box {}", Name(name)))
    }
}

impl<'a> Iterator for Boxes<'a> {
    type Item = Result<([u8; 4], &'a [u8]), Wrong>;

    fn next(&mut self) -> Option<Self::Item> {
        // Some writers end a list of boxes with a 32-bit zero (QuickTime's terminator).
        if self.0.len() < 8 && self.0.iter().all(|byte| *byte == 0) {
            return None;
        }
        let found = BoxHeader::read(self.0, self.0.len() as u64, false).map(|head| {
            // `read` has checked both lengths against the bytes that are there.
            let (whole, rest) = self.0.split_at(head.whole as usize);
            self.0 = rest;
            (head.name, &whole[head.length as usize..])
        });
        if found.is_err() {
            self.0 = &[];
        }
        Some(found)
    }
}

/// The big-endian 32-bit number at byte `at`.
pub(super) fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    let four = bytes.get(at..)?.first_chunk()?;
    Some(u32::from_be_bytes(*four))
}

/// The big-endian 64-bit number at byte `at`.
pub(super) fn u64_at(bytes: &[u8], at: usize) -> Option<u64> {
    let eight = bytes.get(at..)?.first_chunk()?;
    Some(u64::from_be_bytes(*eight))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn lengths_that_lie_are_refused() {
        let head = |bytes: &[u8], room| BoxHeader::read(bytes, room, false);
        for (bytes, room, words) in [
            (&b"\0\0\0\x07free"[..], 99, "less than its head"),
            (b"\0\0\0\0free", 99, "less than its head"),
            (b"\0\0\0\x10free", 15, "only 15 are there"),
            (b"\xff\xff\xff\xfffree", 99, "only 99 are there"),
            (
                b"\0\0\0\x01free\0\0\0\0\0\0\0\x0f",
                99,
                "less than its head",
            ),
            (
                b"\0\0\0\x01free\xff\xff\xff\xff\xff\xff\xff\xff",
                99,
                "only 99",
            ),
            (b"\0\0\0\x01free\0\0", 99, "cut off"),
            (b"\0\0\0\x08fre", 99, "cut off"),
        ] {
            let message = head(bytes, room).unwrap_err();
            assert!(message.contains(words), "{message}");
        }
        let wide = head(b"\0\0\0\x01free\0\0\0\0\0\0\0\x10", 16).unwrap();
        assert_eq!((wide.length, wide.whole), (16, 16));
        let last = BoxHeader::read(b"\0\0\0\0mdat", 77, true).unwrap();
        assert_eq!(last.whole, 77);
    }

    proptest! {
        #[test]
        fn any_bytes_are_at_most_one_box_for_eight(bytes: Vec<u8>) {
            prop_assert!(Boxes(&bytes).count() <= bytes.len() / 8 + 1);
        }

        /// Boxes come out as they were put in, with what stands between them.
        #[test]
        fn boxes_are_found(contents in prop::collection::vec(prop::collection::vec(0_u8.., 0..20), 0..6)) {
            let mut bytes = Vec::new();
            for content in &contents {
                bytes.extend((content.len() as u32 + 8).to_be_bytes());
                bytes.extend(b"abcd");
                bytes.extend(content);
            }
            let found: Result<Vec<_>, _> = Boxes(&bytes).map(|b| b.map(|(_, c)| c.to_vec())).collect();
            prop_assert_eq!(found.unwrap(), contents);
        }
    }
}
