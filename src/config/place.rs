//! Where something stands in a text.

/// Where something stands in a text, in bytes.
///
/// Two places are always equal: where a node stands is no part of what it says, so syntax
/// trees of differently laid out texts compare equal.
#[derive(Clone, Copy, Debug, Default)]
pub struct Place {
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

impl PartialEq for Place {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for Place {}

impl Place {
    /// The place from `start` up to `end`.
    #[must_use]
    pub const fn new(start: usize, end: usize) -> Self {
        Self { start, end }
    }

    /// Whether it is the very same place.
    #[must_use]
    pub const fn is(self, other: Self) -> bool {
        self.start == other.start && self.end == other.end
    }

    /// From the start of this place to the end of the other.
    #[must_use]
    pub const fn to(self, other: Self) -> Self {
        Self::new(self.start, other.end)
    }
}

impl From<std::ops::Range<usize>> for Place {
    fn from(range: std::ops::Range<usize>) -> Self {
        Self::new(range.start, range.end)
    }
}

/// Line and column, both from 1, of a byte of a text; columns count characters.
#[must_use]
pub fn line_column(text: &str, byte: usize) -> (u32, u32) {
    // A place inside a character is the character's.
    let before = &text[..text.floor_char_boundary(byte)];
    let line = before.matches('\n').count() as u32 + 1;
    let start = before.rfind('\n').map_or(0, |at| at + 1);
    (line, before[start..].chars().count() as u32 + 1)
}

/// The lines of a text, for looking up many places.
#[derive(Clone, Debug)]
pub struct Lines {
    /// The byte at which each line but the first begins.
    starts: Vec<usize>,
}

impl Lines {
    /// The lines of a text.
    #[must_use]
    pub fn new(text: &str) -> Self {
        let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        Self {
            starts: ends.map(|(at, _)| at + 1).collect(),
        }
    }

    /// The line of a byte, from 1.
    #[must_use]
    pub fn line(&self, byte: usize) -> u32 {
        self.starts.partition_point(|start| *start <= byte) as u32 + 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_count_characters() {
        let text = "ab\nµx = 1";
        assert_eq!(line_column(text, 0), (1, 1));
        assert_eq!(line_column(text, 3), (2, 1));
        assert_eq!(line_column(text, 5), (2, 2), "µ has two bytes");
        assert_eq!(line_column(text, 999), (2, 7), "past the end is the end");
        let lines = Lines::new(text);
        assert!((0..9).all(|byte| lines.line(byte) == line_column(text, byte).0));
    }
}
