//! Metrics: how two packets differ.
//!
//! One is the reference, the other is judged against it. A cell is one pixel, kind and sign;
//! every metric works cell by cell, so an event at the wrong pixel, of the wrong kind or of
//! the wrong sign is never half right. Streams are compared as multisets: the order of events
//! at one time carries nothing.
//!
//! A metric is a file here, with its definition, a function of a [`Pair`], and a line of the list
//! in [`metric`]. No single number will do: event rates are blind to wrong pixels, and counts are
//! blind to delay. [`compare`] gives the plain ones, [`window`] the headline, [`score::scores`]
//! every metric, each with its value for the identical packet, for a redraw and for a permutation
//! of the reference. The *floor* of a metric is what a redraw scores, its *ceiling* what the
//! identical packet does.
//!
//! | metric | file | identical | nothing in common |
//! |---|---|---|---|
//! | equality, first divergence | [`equality`] | equal | the earliest event |
//! | fate: kept, mistimed, wrong sign, lost, extra | [`fate`] | all kept | all lost, all extra |
//! | counts, Pearson, L1 | [`counts`] | 1, 0 | near 0, all events |
//! | precision, recall, F1, time error | [`matching`] | 1, 1, 1, 0 | 0, 0, 0, none |
//! | F1 over the window, and what of it is kept above the floor | [`window`] | 1, 1 | the floor, 0 |
//! | van Rossum's distance per event | [`van_rossum`] | 0 | about 1 |
//! | Victor and Purpura's distance per event | [`victor_purpura`] | 0 | at most 2 |
//! | voxel L1 per event, RMSE | [`voxel`] | 0, 0 | at most 1, no bound |
//! | rate maps, Pearson, L1 per event | [`rates`] | 1, 0 | near 0, at most 1 |
//! | divergence of intervals | [`intervals`] | 0 | no bound |

pub mod baseline;
mod bins;
pub mod counts;
mod entry;
pub mod equality;
pub mod fate;
pub mod intervals;
pub mod matching;
pub mod metric;
mod pair;
mod pearson;
pub mod rates;
pub mod score;
mod trains;
pub mod van_rossum;
pub mod victor_purpura;
pub mod voxel;
pub mod window;

pub use pair::{CompareError, Pair, Signed, Sorted, Times};
pub use trains::Cell;

use crate::{
    event::{Packet, address::AddressWord, file::Loaded},
    unit::Micros,
};
use counts::{Cells, Kind};
use equality::Divergence;
use matching::Quantiles;

/// All that `compare` measures. Pairs of numbers are [reference, judged].
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Comparison {
    /// Both hold the same events.
    pub equal: bool,
    /// Where they part, when they do.
    pub first_divergence: Option<Divergence>,
    /// Events.
    pub events: [u64; 2],
    /// ON events.
    pub on: [u64; 2],
    /// OFF events.
    pub off: [u64; 2],
    /// The same by kind of cell.
    pub kinds: Vec<Kind>,
    /// Counts cell by cell.
    pub cells: Cells,
    /// Window of the matches, in microseconds.
    pub within_us: Micros,
    /// Events matched.
    pub matched: u64,
    /// Matched share of the judged events; none when only the reference has events.
    pub precision: Option<f64>,
    /// Matched share of the reference's events; none when only the judged packet has events.
    pub recall: Option<f64>,
    /// Harmonic mean of the two.
    pub f1: f64,
    /// Time of the judged event minus time of its match, in microseconds; none without matches.
    pub time_error_us: Option<Quantiles>,
    /// Bits of all events as fixed address words.
    pub bits: [u64; 2],
    /// Bits of one event.
    pub bits_per_event: u32,
    /// Events that each sensor made and could not deliver; nothing where that is not known.
    pub dropped: [Option<u64>; 2],
}

/// Judges `judged` against `reference`; events match within `within`.
///
/// # Errors
/// When the packets are not of the same size and number of channels, or hold events outside
/// of them.
pub fn compare(
    reference: &Packet,
    judged: &Packet,
    within: Micros,
) -> Result<Comparison, CompareError> {
    Ok(Comparison::from_pair(
        &Pair::new(reference, judged)?,
        within,
    ))
}

impl Comparison {
    /// As [`compare`], of packets that are sorted already.
    #[must_use]
    pub fn from_pair(pair: &Pair, within: Micros) -> Self {
        let first_divergence = equality::first_divergence(pair);
        let kinds = counts::kinds(pair);
        let both = |count: fn(&Kind) -> [u64; 2]| {
            kinds
                .iter()
                .map(count)
                .fold([0, 0], |[a, b], [c, d]| [a + c, b + d])
        };
        let bits_per_event = AddressWord::new(pair.size(), pair.channels()).bits();
        let matches = matching::matches(pair, within);
        Self {
            equal: first_divergence.is_none(),
            first_divergence,
            events: pair.events(),
            on: both(|kind| kind.on),
            off: both(|kind| kind.off),
            cells: counts::cells(pair),
            kinds,
            within_us: within,
            matched: matches.matched(),
            precision: matches.precision(),
            recall: matches.recall(),
            f1: matches.f1(),
            time_error_us: matches.time_error(),
            bits: pair
                .events()
                .map(|events| events * u64::from(bits_per_event)),
            bits_per_event,
            dropped: pair.dropped().map(Some),
        }
    }

    /// As [`Comparison::from_pair`], of packets that were read from files, which need not say what was
    /// dropped.
    #[must_use]
    pub fn of_loaded(pair: &Pair, within: Micros, [reference, judged]: [&Loaded; 2]) -> Self {
        let mut comparison = Self::from_pair(pair, within);
        for (dropped, loaded) in comparison.dropped.iter_mut().zip([reference, judged]) {
            *dropped = dropped.filter(|_| loaded.dropped_known);
        }
        comparison
    }
}
