//! Exact equality and the first divergence.
//!
//! Two packets are equal when they hold the same events, each as often: the order among
//! events of one time is the readout's, not the sensor's. The first divergence is the earliest
//! event that one packet holds more often than the other; among several of one time the first
//! in the canonical order (row, column, channel, OFF before ON).

use super::{Cell, Pair};
use crate::unit::Micros;

/// One of the two packets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// What is judged against.
    Reference,
    /// What is judged.
    Judged,
}

/// An event that only one side has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Divergence {
    /// When, in microseconds.
    pub t: Micros,
    /// Column.
    pub x: u16,
    /// Row.
    pub y: u16,
    /// 1 for ON, 0 for OFF.
    pub p: u8,
    /// Kind of cell.
    pub channel: u8,
    /// Who has it; the other has it not, or less often.
    pub only_in: Side,
}

/// The first divergence; none when the packets are equal.
#[must_use]
pub fn first_divergence(pair: &Pair) -> Option<Divergence> {
    pair.cells()
        .filter_map(|(cell, reference, judged)| {
            let (t, only_in) = first_in_cell(reference.iter(), judged.iter())?;
            Some(divergence(cell, t, only_in))
        })
        .min_by_key(|d| (d.t, d.y, d.x, d.channel, d.p))
}

/// Both lists ascend, so where they first differ the earlier time is missing from the other.
fn first_in_cell(
    mut reference: impl Iterator<Item = u64>,
    mut judged: impl Iterator<Item = u64>,
) -> Option<(u64, Side)> {
    loop {
        match (reference.next(), judged.next()) {
            (Some(a), Some(b)) if a == b => (),
            (Some(a), Some(b)) if a > b => return Some((b, Side::Judged)),
            (Some(a), _) => return Some((a, Side::Reference)),
            (None, Some(b)) => return Some((b, Side::Judged)),
            (None, None) => return None,
        }
    }
}

const fn divergence(cell: Cell, t: u64, only_in: Side) -> Divergence {
    Divergence {
        t: Micros(t),
        x: cell.x(),
        y: cell.y(),
        p: cell.polarity().bit(),
        channel: cell.channel(),
        only_in,
    }
}
