//! Huffman codes for kinds of cells: short code words for frequent kinds.
//!
//! Lengths are Huffman's (1952), so no code of whole bits a kind is shorter in the mean; the
//! mean lies from the entropy `H = -sum p log2 p` up to `H + 1`. Words are canonical: in order
//! of length, then of kind, each the last plus one, so that the lengths alone are the book.
//!
//! As bytes: the number of kinds, the length of each kind's word (255 for a kind without one),
//! and the CRC-32 of all that, most significant byte first.

use std::{cmp::Reverse, collections::BinaryHeap};

use super::{BookFault, CodecError, wire::Reader};
use crate::elementary;

/// Stands for "no code word" in the list of lengths.
const NONE: u8 = u8::MAX;
/// The longest code word, in bits. Counts of 64 bits lead to at most 91.
const LONGEST: u8 = 127;

/// A canonical Huffman code for kinds of cells.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CodeBook {
    /// Length of each kind's code word in bits; `None` for a kind that never comes.
    lengths: Vec<Option<u8>>,
    /// Code word of each kind, in the lowest bits.
    words: Vec<u128>,
    /// Kinds in the order of their words.
    order: Vec<u8>,
}

impl CodeBook {
    /// The best code for kinds that come this often. A kind that never comes gets no word; when
    /// none comes, all get words as if equally frequent. A single kind gets the empty word.
    ///
    /// Kinds beyond 255 are left out: a packet has no more.
    #[must_use]
    pub fn from_counts(counts: &[u64]) -> Self {
        let counts = counts.get(..255).unwrap_or(counts);
        let equal = vec![1; counts.len()];
        let counts = if counts.iter().all(|c| *c == 0) {
            &equal
        } else {
            counts
        };
        Self::with_lengths(lengths(counts))
    }

    /// The canonical words of these lengths.
    fn with_lengths(lengths: Vec<Option<u8>>) -> Self {
        let mut order: Vec<u8> = (0..=u8::MAX)
            .zip(&lengths)
            .filter_map(|(kind, length)| length.map(|_| kind))
            .collect();
        let length = |kind: u8| lengths.get(usize::from(kind)).copied().flatten();
        order.sort_by_key(|kind| (length(*kind), *kind));
        let mut words = vec![0; lengths.len()];
        let (mut next, mut last) = (0_u128, 0);
        for kind in &order {
            let length = length(*kind).unwrap_or(last);
            next <<= length - last;
            if let Some(word) = words.get_mut(usize::from(*kind)) {
                *word = next;
            }
            next += 1;
            last = length;
        }
        Self {
            lengths,
            words,
            order,
        }
    }

    /// Length in bits and word of a kind; `None` when it has none.
    #[must_use]
    pub fn word(&self, kind: u8) -> Option<(u32, u128)> {
        let length = self.lengths.get(usize::from(kind)).copied().flatten()?;
        Some((length.into(), *self.words.get(usize::from(kind))?))
    }

    /// Number of kinds, with a word or without.
    #[must_use]
    pub fn kinds(&self) -> usize {
        self.lengths.len()
    }

    /// Mean length of a word for kinds that come this often; `None` when one comes that has no
    /// word, or none comes.
    #[must_use]
    pub fn mean_length(&self, counts: &[u64]) -> Option<f64> {
        let (mut bits, mut all) = (0_u128, 0_u128);
        for (kind, count) in (0..).zip(counts).filter(|(_, count)| **count > 0) {
            bits += u128::from(*count) * u128::from(self.word(kind)?.0);
            all += u128::from(*count);
        }
        (all > 0).then(|| bits as f64 / all as f64)
    }

    /// The book as bytes.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = vec![self.lengths.len() as u8];
        bytes.extend(self.lengths.iter().map(|length| length.unwrap_or(NONE)));
        let sum = crc32fast::hash(&bytes);
        bytes.extend(sum.to_be_bytes());
        bytes
    }

    /// A book from bytes, all of them.
    ///
    /// # Errors
    /// When the bytes are no book, or one for another number of kinds.
    pub fn from_bytes(bytes: &[u8], kinds: u8) -> Result<Self, CodecError> {
        let mut input = Reader::new(bytes, 8 * bytes.len() as u64)?;
        let book = Self::read(&mut input, kinds)?;
        input.finish()?;
        Ok(book)
    }

    /// Reads a book from the beginning of a coded packet.
    pub(super) fn read(input: &mut Reader<'_>, kinds: u8) -> Result<Self, CodecError> {
        let bad = |byte, fault| CodecError::Book { byte, fault };
        let mut bytes = Vec::new();
        let mut next = |bytes: &mut Vec<u8>| match input.byte() {
            Some(byte) => {
                bytes.push(byte);
                Ok(byte)
            }
            None => Err(bad(bytes.len(), BookFault::Short)),
        };
        let found = next(&mut bytes)?;
        if found != kinds {
            return Err(bad(0, BookFault::Kinds { found, want: kinds }));
        }
        for _ in 0..kinds {
            next(&mut bytes)?;
        }
        let want = crc32fast::hash(&bytes);
        let end = bytes.len();
        let mut sum = [0; 4];
        for byte in &mut sum {
            *byte = next(&mut bytes)?;
        }
        let found = u32::from_be_bytes(sum);
        if found != want {
            return Err(bad(end, BookFault::Checksum { found, want }));
        }
        let lengths = bytes.get(1..end).unwrap_or_default();
        // Kraft's sum, in units of 2^-127.
        let mut room = 1_u128 << LONGEST;
        for (byte, length) in (1..).zip(lengths).filter(|(_, length)| **length != NONE) {
            if *length > LONGEST {
                return Err(bad(byte, BookFault::Length { length: *length }));
            }
            let Some(rest) = room.checked_sub(1 << (LONGEST - length)) else {
                return Err(bad(byte, BookFault::Kraft { over: true }));
            };
            room = rest;
        }
        if room > 0 {
            return Err(bad(end, BookFault::Kraft { over: false }));
        }
        let lengths = lengths.iter().map(|l| (*l != NONE).then_some(*l)).collect();
        Ok(Self::with_lengths(lengths))
    }

    /// Decodes one kind, bit by bit. A book is complete, so every sequence of bits begins with a
    /// code word.
    pub(super) fn decode<E>(&self, mut bit: impl FnMut() -> Result<bool, E>) -> Result<u8, E> {
        let (mut word, mut length) = (0_u128, 0);
        let mut at = 0;
        loop {
            // The code words of one length are consecutive numbers.
            let kind = self.order.get(at).copied();
            match kind.and_then(|kind| Some((kind, self.word(kind)?))) {
                Some((kind, (long, code))) if long == length => {
                    if code == word {
                        return Ok(kind);
                    }
                    at += 1;
                }
                Some(_) => {
                    word = word << 1 | u128::from(bit()?);
                    length += 1;
                }
                // A complete book does not get here.
                None => return Ok(self.order.last().copied().unwrap_or(0)),
            }
        }
    }
}

/// Huffman's algorithm: the two rarest groups are merged again and again, which makes the code
/// words of all kinds in them one bit longer. Ties go to the earlier group, so that equal counts
/// give the same book everywhere.
fn lengths(counts: &[u64]) -> Vec<Option<u8>> {
    let mut lengths: Vec<Option<u8>> = counts.iter().map(|c| (*c > 0).then_some(0)).collect();
    let mut heap: BinaryHeap<_> = counts
        .iter()
        .enumerate()
        .filter(|(_, count)| **count > 0)
        .map(|(kind, count)| Reverse((u128::from(*count), kind, vec![kind])))
        .collect();
    let mut number = counts.len();
    while let (Some(Reverse((a, _, mut kinds))), Some(Reverse((b, _, others)))) =
        (heap.pop(), heap.pop())
    {
        kinds.extend(others);
        for kind in &kinds {
            if let Some(Some(length)) = lengths.get_mut(*kind) {
                *length += 1;
            }
        }
        heap.push(Reverse((a + b, number, kinds)));
        number += 1;
        if heap.len() == 1 {
            break;
        }
    }
    lengths
}

/// Entropy of kinds that come this often, in bits: no code has fewer in the mean.
#[must_use]
pub fn entropy(counts: &[u64]) -> f64 {
    let all: f64 = counts.iter().map(|c| *c as f64).sum();
    let bits = |c: &u64| {
        let p = *c as f64 / all;
        -p * elementary::log2(p)
    };
    // Adding 0 turns -0 to 0.
    counts.iter().filter(|c| **c > 0).map(bits).sum::<f64>() + 0.0
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The least sum of `count * length` over all lengths whose Kraft sum is at most 1, with
    /// no length above `most`.
    fn brute_force(counts: &[u64], most: u32) -> u64 {
        fn go(counts: &[u64], most: u32, room: u64) -> Option<u64> {
            let Some((count, rest)) = counts.split_first() else {
                return Some(0);
            };
            (0..=most)
                .filter_map(|length| {
                    let room = room.checked_sub(1 << (most - length))?;
                    Some(count * u64::from(length) + go(rest, most, room)?)
                })
                .min()
        }
        go(counts, most, 1 << most).unwrap()
    }

    fn bits(book: &CodeBook, counts: &[u64]) -> u64 {
        (0..)
            .zip(counts)
            .map(|(kind, count)| count * u64::from(book.word(kind).unwrap().0))
            .sum()
    }

    fn kraft(book: &CodeBook) -> u128 {
        let part = |kind| {
            book.word(kind)
                .map_or(0, |(length, _)| 1_u128 << (127 - length))
        };
        (0..book.kinds() as u8).map(part).sum()
    }

    proptest! {
        #[test]
        fn no_code_is_shorter(counts in prop::collection::vec(1..60_u64, 1..6)) {
            // The longest word that a best code for this many kinds can need.
            let most = counts.len() as u32 - 1;
            prop_assert_eq!(bits(&CodeBook::from_counts(&counts), &counts), brute_force(&counts, most));
        }

        #[test]
        fn words_fill_their_space_and_none_begins_another(
            counts in prop::collection::vec(prop_oneof![0..3_u64, 0..u64::MAX], 1..255)
        ) {
            let book = CodeBook::from_counts(&counts);
            prop_assert_eq!(kraft(&book), 1 << 127);
            let words: Vec<_> = (0..counts.len() as u8).filter_map(|k| book.word(k)).collect();
            for (i, (length, word)) in words.iter().enumerate() {
                for (other, long) in words.iter().skip(i + 1) {
                    let shorter = *length.min(other);
                    prop_assert_ne!(word >> (length - shorter), long >> (other - shorter));
                }
            }
            for (kind, count) in (0..).zip(&counts) {
                let unseen = *count == 0 && counts.iter().any(|c| *c > 0);
                prop_assert_eq!(book.word(kind).is_none(), unseen);
            }
        }

        #[test]
        fn the_mean_is_within_a_bit_of_the_entropy(
            counts in prop::collection::vec(0..1_000_000_u64, 2..40)
        ) {
            prop_assume!(counts.iter().filter(|c| **c > 0).count() > 1);
            let mean = CodeBook::from_counts(&counts).mean_length(&counts).unwrap();
            let h = entropy(&counts);
            prop_assert!(h <= mean + 1e-9 && mean < h + 1.0, "{h} {mean}");
        }

        #[test]
        fn books_come_back(counts in prop::collection::vec(0..9_u64, 1..255)) {
            let book = CodeBook::from_counts(&counts);
            let back = CodeBook::from_bytes(&book.to_bytes(), counts.len() as u8);
            prop_assert_eq!(back, Ok(book));
        }

        /// Any byte changed, added or taken away is noticed.
        #[test]
        fn damaged_books_are_refused(
            counts in prop::collection::vec(0..9_u64, 1..20),
            at: prop::sample::Index,
            change in 1..=u8::MAX,
        ) {
            let kinds = counts.len() as u8;
            let whole = CodeBook::from_counts(&counts).to_bytes();
            let mut bytes = whole.clone();
            bytes[at.index(whole.len())] ^= change;
            prop_assert!(CodeBook::from_bytes(&bytes, kinds).is_err());
            prop_assert!(CodeBook::from_bytes(&whole[..at.index(whole.len())], kinds).is_err());
            let longer = [whole.as_slice(), &[0]].concat();
            prop_assert!(CodeBook::from_bytes(&longer, kinds).is_err());
        }
    }

    #[test]
    fn powers_of_two_meet_the_entropy() {
        let counts = [8, 1, 4, 2, 1];
        let book = CodeBook::from_counts(&counts);
        let words: Vec<_> = (0..5).map(|k| book.word(k).unwrap()).collect();
        assert_eq!(
            words,
            [(1, 0b0), (4, 0b1110), (2, 0b10), (3, 0b110), (4, 0b1111)]
        );
        assert_eq!(book.mean_length(&counts), Some(1.875));
        assert_eq!(entropy(&counts), 1.875);
        // Not -0, which would be printed.
        assert_eq!(
            [&[7][..], &[0, 0]].map(|counts| entropy(counts).to_bits()),
            [0; 2]
        );
    }

    #[test]
    fn one_kind_needs_no_bits() {
        for counts in [&[7][..], &[0, 7, 0], &[0]] {
            let book = CodeBook::from_counts(counts);
            let kind = counts.iter().position(|c| *c > 0).unwrap_or(0) as u8;
            assert_eq!(book.word(kind), Some((0, 0)));
            let decoded = book.decode(|| -> Result<bool, ()> { Err(()) });
            assert_eq!(decoded, Ok(kind));
        }
        assert_eq!(CodeBook::from_counts(&[0, 0]).word(1), Some((1, 1)));
    }

    #[test]
    fn the_longest_words_of_64_bit_counts_fit() {
        let (mut a, mut b) = (1_u64, 1_u64);
        let mut counts = vec![1];
        while let Some(next) = a.checked_add(b) {
            counts.push(b);
            (a, b) = (b, next);
        }
        let book = CodeBook::from_counts(&counts);
        assert_eq!(kraft(&book), 1 << 127);
        assert_eq!(book.word(0).unwrap().0, 91);
    }

    /// A book with these lengths and the right checksum.
    fn forged(lengths: &[u8]) -> Vec<u8> {
        let mut bytes = vec![lengths.len() as u8];
        bytes.extend(lengths);
        let sum = crc32fast::hash(&bytes).to_be_bytes();
        bytes.extend(sum);
        bytes
    }

    #[test]
    fn books_that_are_no_codes_are_refused() {
        let said = |bytes: &[u8], kinds| {
            let refused = CodeBook::from_bytes(bytes, kinds);
            refused.unwrap_err().to_string()
        };
        assert_eq!(
            said(&forged(&[1, 2]), 2),
            "code book, byte 3: its words are fewer than lengths like these need"
        );
        assert_eq!(
            said(&forged(&[1, 1, 1]), 3),
            "code book, byte 3: its words are more than lengths like these allow"
        );
        assert!(said(&forged(&[0; 255]), 255).contains("more than"));
        assert!(said(&forged(&[255; 3]), 3).contains("fewer than"));
        assert_eq!(
            said(&forged(&[1, 200, 1]), 3),
            "code book, byte 2: a word of 200 bits; the longest has 127"
        );
        assert_eq!(
            said(&forged(&[1, 1]), 3),
            "code book, byte 0: it is for 2 kinds; the sensor has 3"
        );
        assert_eq!(said(&[], 3), "code book, byte 0: it ends here");
        assert_eq!(said(&[3, 1, 2], 3), "code book, byte 3: it ends here");
        let mut bytes = forged(&[1, 2, 2]);
        bytes[7] ^= 1;
        assert!(said(&bytes, 3).starts_with("code book, byte 4: checksum "));
    }
}
