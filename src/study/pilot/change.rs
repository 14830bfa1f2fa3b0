//! Change: by how many events two models differ, and where.

use std::{
    collections::{HashMap, hash_map::DefaultHasher},
    hash::{Hash as _, Hasher as _},
};

use super::estimate::Tile;
use crate::{
    compare::{CompareError, Pair, matching},
    event::{Packet, Polarity},
    mosaic::Mosaic,
    unit::Micros,
};

/// What two models' events differ by.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Change {
    /// Events of the full model.
    pub events: u64,
    /// Those without a partner in the plainer one.
    pub missing: u64,
    /// Events of the plainer one without a partner.
    pub extra: u64,
    /// Both, for each event of the full model; 0 where neither has any.
    pub share: f64,
}

impl Change {
    /// What `plain` changes of `full`: events without a partner of their cell and sign within
    /// the window, found as [`matching`] finds them.
    ///
    /// # Errors
    /// When the packets are not of one size.
    pub fn between(full: &Packet, plain: &Packet, within: Micros) -> Result<Self, CompareError> {
        Ok(Self::of_pair(&Pair::new(full, plain)?, within))
    }

    /// The same of a pair: the full model, and a plainer one.
    #[must_use]
    pub fn of_pair(pair: &Pair, within: Micros) -> Self {
        let matched = matching::matched(pair, within);
        let [events, plain] = pair.events();
        let (missing, extra) = (events - matched, plain - matched);
        let alone = (missing + extra) as f64;
        Self {
            events,
            missing,
            extra,
            share: if alone > 0.0 {
                alone / events as f64
            } else {
                0.0
            },
        }
    }
}

/// What each tile of a mosaic shows of a pair, the full model and a plainer one; `probabilities` are
/// those with which the tiles were drawn.
#[must_use]
pub fn of_pair(mosaic: &Mosaic, probabilities: &[f64], pair: &Pair, within: Micros) -> Vec<Tile> {
    let mut tiles: Vec<Tile> = { probabilities.iter() }
        .map(|probability| Tile {
            probability: *probability,
            ..Tile::default()
        })
        .collect();
    // Both signs of a cell are one history: its events, and a number for when they are.
    let mut histories: HashMap<(usize, u16, u16, u8), (u64, u64)> = HashMap::new();
    for (cell, reference, judged) in pair.cells() {
        let Some(number) = mosaic.tile(cell.y().into(), cell.x().into()) else {
            continue;
        };
        let Some(tile) = tiles.get_mut(number) else {
            continue;
        };
        let events = [reference.len(), judged.len()].map(|n| n as u64);
        let matched = matching::matched_of_cell(reference, judged, within);
        tile.events += events[0];
        tile.changes += events[0] + events[1] - 2 * matched;
        let at = (number, cell.y(), cell.x(), cell.channel());
        let history = histories.entry(at).or_default();
        history.0 += events[0];
        let mut when = DefaultHasher::new();
        (history.1, cell.polarity() == Polarity::On).hash(&mut when);
        reference.iter().for_each(|t| t.hash(&mut when));
        history.1 = when.finish();
    }
    let mut alike: HashMap<(usize, u8, u64), u64> = HashMap::new();
    for ((number, _, _, channel), (events, when)) in histories {
        if let Some(tile) = tiles.get_mut(number) {
            tile.squares += events * events;
            *alike.entry((number, channel, when)).or_default() += events;
        }
    }
    for ((number, ..), events) in alike {
        if let Some(tile) = tiles.get_mut(number) {
            tile.alike += events * events;
        }
    }
    tiles
}

/// A share in percent, with three figures.
#[must_use]
pub fn share(share: f64) -> String {
    let percent = 100.0 * share;
    if percent == 0.0 {
        "0 %".to_owned()
    } else if percent > 1000.0 || percent.is_nan() {
        "over 1000 %".to_owned()
    } else if percent < 0.01 {
        format!("{percent:.1e} %")
    } else if percent < 10.0 {
        format!("{percent:.3} %")
    } else {
        format!("{percent:.1} %")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_have_three_figures() {
        let shown = [0.0, 1e-7, 0.000_447, 0.0123, 0.5, 1.5, f64::INFINITY].map(share);
        let want = [
            "0 %",
            "1.0e-5 %",
            "0.045 %",
            "1.230 %",
            "50.0 %",
            "150.0 %",
            "over 1000 %",
        ];
        assert_eq!(shown, want);
    }
}
