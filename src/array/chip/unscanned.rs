//! Set pixels that a frame's scans leave behind, where these read some rows only.
//!
//! What a scan leaves is counted at once, since nobody says which scan of a frame is the last; a later
//! scan of the same frame that reads it takes it back.

use std::ops::RangeInclusive;

use super::super::BitPlane;
use crate::{event::Polarity, isa::Digital, plane::Size};

/// Which bits a scan reads, and as what.
pub(super) type Scan = (Digital, Polarity, u8);

/// The bits that the scans of this frame have left so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Unscanned(Vec<Left>);

/// What scans of one kind have left.
#[derive(Clone, Debug)]
struct Left {
    scan: Scan,
    bits: BitPlane,
    /// Rows that were not read.
    rows: Vec<usize>,
}

/// How a scan changes what is left.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Change {
    /// Set pixels in rows that it does not read.
    pub more: u64,
    /// Set pixels that an earlier scan of the frame left, and this one reads.
    pub read: u64,
}

impl Unscanned {
    /// The next frame.
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// A scan of these rows of `bits`.
    pub fn see(
        &mut self,
        scan: Scan,
        bits: &BitPlane,
        size: Size,
        rows: &RangeInclusive<usize>,
    ) -> Change {
        let same = self
            .0
            .iter()
            .position(|it| it.scan == scan && it.holds(bits));
        if let Some(left) = same.and_then(|at| self.0.get_mut(at)) {
            let (read, rest): (Vec<usize>, Vec<usize>) =
                { left.rows.iter() }.partition(|y| rows.contains(*y));
            left.rows = rest;
            return Change {
                more: 0,
                read: count(bits, &read),
            };
        }
        let rows: Vec<usize> = (0..size.height).filter(|y| !rows.contains(y)).collect();
        let more = count(bits, &rows);
        // Of other bits none come back.
        self.0.retain(|it| it.scan != scan);
        self.0.push(Left {
            scan,
            bits: bits.clone(),
            rows,
        });
        Change { more, read: 0 }
    }
}

impl Left {
    /// Whether these bits are those that it was counted of.
    fn holds(&self, bits: &BitPlane) -> bool {
        self.bits.words() == bits.words()
    }
}

/// Set pixels in these rows.
fn count(bits: &BitPlane, rows: &[usize]) -> u64 {
    let rows = rows.iter().map(|y| bits.row(*y).iter());
    rows.flatten()
        .map(|word| u64::from(word.count_ones()))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_later_scan_of_the_frame_reads_is_not_left() {
        let size = Size::new(4, 70);
        let mut bits = BitPlane::zeros(size);
        for (y, x) in [(0, 3), (1, 2), (1, 69), (3, 0)] {
            bits.set(y, x, true);
        }
        let on = (Digital(5), Polarity::On, 0);
        let mut all = Unscanned::default();
        let mut see = |scan, bits: &BitPlane, rows| {
            let Change { more, read } = all.see(scan, bits, size, &rows);
            (more, read)
        };
        assert_eq!(see(on, &bits, 0..=0), (3, 0));
        assert_eq!(see(on, &bits, 0..=1), (0, 2));
        assert_eq!(see(on, &bits, 2..=255), (0, 1));
        // As another kind, or of other bits, it is another scan.
        assert_eq!(see((Digital(5), Polarity::Off, 0), &bits, 3..=3), (3, 0));
        // All that is set was read before.
        let off = (Digital(6), Polarity::Off, 1);
        assert_eq!(see(off, &bits, 0..=3), (0, 0));
        assert_eq!(see(off, &bits, 0..=0), (0, 0));
        bits.set(2, 2, true);
        assert_eq!(see(on, &bits, 0..=1), (2, 0));
        all.clear();
        let Change { more, read } = all.see(on, &bits, size, &(0..=255));
        assert_eq!((more, read), (0, 0));
    }
}
