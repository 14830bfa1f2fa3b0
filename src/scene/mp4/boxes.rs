//! Boxes: a length, a name of four letters, and what is in them.

use std::fmt;

/// The name of a box.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct Name(pub [u8; 4]);

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0.escape_ascii())
    }
}

/// What is wrong with a file, in words.
pub(super) type Wrong = String;

/// The length and name at the head of a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Head {
    pub name: [u8; 4],
    /// Bytes of the head itself.
    pub length: u64,
    /// Bytes of the whole box, head included; at least those of the head.
    pub whole: u64,
}

impl Head {
    /// Most bytes that a head has.
    pub const LONGEST: usize = 16;

    /// The head at the start of `bytes`, of a box that has `room` bytes to lie in.
    ///
    /// `to_the_end`: whether a length of 0, "to the end of the file", may stand there.
    pub fn read(bytes: &[u8], room: u64, to_the_end: bool) -> Result<Self, Wrong> {
        let short = || "a box is cut off inside its head".to_owned();
        let says = u64::from(u32_at(bytes, 0).ok_or_else(short)?);
        let name: [u8; 4] = *bytes
            .get(4..)
            .and_then(<[u8]>::first_chunk)
            .ok_or_else(short)?;
        let (head, whole) = match says {
            0 if to_the_end => (8, room),
            1 => (16, u64_at(bytes, 8).ok_or_else(short)?),
            says => (8, says),
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

/// The boxes in a box, one after another. Each step takes at least the 8 bytes of a head.
pub(super) struct Boxes<'a>(pub &'a [u8]);

impl<'a> Boxes<'a> {
    /// The first box of this name; `None` where there is none.
    pub fn find(self, name: [u8; 4]) -> Result<Option<&'a [u8]>, Wrong> {
        for found in self {
            let (its, content) = found?;
            if its == name {
                return Ok(Some(content));
            }
        }
        Ok(None)
    }

    /// The first box of this name, which must be there.
    pub fn get(self, name: [u8; 4]) -> Result<&'a [u8], Wrong> {
        self.find(name)?
            .ok_or_else(|| format!("it has no box {}", Name(name)))
    }
}

impl<'a> Iterator for Boxes<'a> {
    type Item = Result<([u8; 4], &'a [u8]), Wrong>;

    fn next(&mut self) -> Option<Self::Item> {
        // Some writers end a list of boxes with a word of zeros.
        if self.0.len() < 8 && self.0.iter().all(|byte| *byte == 0) {
            return None;
        }
        let found = Head::read(self.0, self.0.len() as u64, false).map(|head| {
            // `read` has held both against the room.
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

/// Four bytes at a place, the big end first.
pub(super) fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    let four = bytes.get(at..)?.first_chunk()?;
    Some(u32::from_be_bytes(*four))
}

/// Eight bytes at a place, the big end first.
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
        let head = |bytes: &[u8], room| Head::read(bytes, room, false);
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
        let last = Head::read(b"\0\0\0\0mdat", 77, true).unwrap();
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
