//! The estimate: what share of the events is changed, from tiles that stand for others, and its
//! upper confidence limit.
//!
//! A tile `i` was drawn with probability `p_i`, has `x_i` events in the full model, and `y_i`
//! events of either model without a partner in the other. With `w_i = 1 / p_i` the totals are
//! about `X = Σ w_i x_i` and `Y = Σ w_i y_i`, and the share is `Y / X`.
//!
//! A **jump** is what one tile adds to a total: `w_i y_i`. A tile is **certain** that was drawn with
//! probability 1. **Unseen** is a change of which the sample has none: how large it would be is
//! said by what changes at once ([`History`]).
//!
//! **Changes.** They come in jumps, so their total is taken for a compound Poisson number. Its upper
//! limit is that of Fay & Feuer for weighted sums of Poisson numbers (Statistics in Medicine 16:791,
//! 1997), with the variance of tiles that were drawn independently and with one jump more that has
//! not been seen:
//!
//! ```text
//! V = Σ (1 - p_i) (w_i y_i)²          M = the largest jump
//! upper = quantile of the gamma distribution of mean Y + M and variance V + M²
//! ```
//!
//! The largest jump is the largest `w_i y_i`, and at least what one cell's whole history would
//! count: its events as a cell has them that an event picked at random belongs to; or those of all
//! cells of its tile that have the same events, or of the whole tile ([`Unseen`]). So a sample in
//! which nothing changed still has a limit: `-ln(risk) M / X`. Tiles that were taken for certain
//! are known, and are added as they are; but what changed in one of them may change in a tile like
//! it that was not drawn, so it is a jump as well, of the mean weight.
//!
//! **Events.** `X` is known from the same tiles. Its error is taken for normal, and both errors are
//! added as if they did not know each other, although tiles of many events have many changes.

use std::fmt;

use serde::Serialize;

use crate::elementary;

/// What a tile that was run showed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tile {
    /// The probability with which it was drawn; 1 for certain.
    pub probability: f64,
    /// Events of the full model.
    pub events: u64,
    /// Squares of the events of each of its cells, added up.
    pub squares: u64,
    /// The same of its cells that have the same events at the same times, taken together.
    pub alike: u64,
    /// Events of either model that have no partner in the other.
    pub changes: u64,
}

/// All limits of a pilot or a survey hold together but for one case in so many.
pub(super) const RISK: f64 = 0.05;

/// What is known of the share of changed events.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ChangeEstimate {
    /// Changed events for each event of the full model, about.
    pub share: f64,
    /// The upper confidence limit of the share (95 %).
    pub limit: Option<f64>,
    /// Why there is none.
    pub no_limit: Option<NoLimit>,
    /// Tiles that were run.
    pub tiles: u64,
    /// Events of the full model in them.
    pub events: u64,
    /// Changes in them.
    pub changes: u64,
}

/// Why a change has no limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoLimit {
    /// Hardly anything fired in the sample.
    FewEvents,
    /// One tile says nothing of how tiles differ.
    OneTile,
    /// Changes are no share of no events.
    NoEvents,
}

impl NoLimit {
    /// Whether more tiles may give one.
    #[must_use]
    pub const fn is_of_sample(self) -> bool {
        matches!(self, Self::FewEvents | Self::OneTile)
    }
}

impl fmt::Display for NoLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::FewEvents => "too few events to say anything",
            Self::OneTile => "one tile says nothing of how tiles differ",
            Self::NoEvents => "the full model has no event, so that changes are no share of any",
        })
    }
}

impl Serialize for NoLimit {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// A change that nobody has seen yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unseen {
    /// What changes at once.
    pub history: History,
    /// Events at least, of a cell of which there may be none in the sample.
    pub at_least: u64,
}

/// What changes at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum History {
    /// A cell: what changes one says nothing of the next.
    Cell,
    /// The cells of a tile that are alike: what changes one changes those that see the same.
    Alike,
    /// A tile: what changes one cell is the scene's, and changes its neighbours too.
    Tile,
}

impl From<History> for Unseen {
    fn from(history: History) -> Self {
        Self {
            history,
            at_least: 0,
        }
    }
}

/// The fewest events that say anything of a share.
const LEAST_EVENTS: u64 = 100;

impl ChangeEstimate {
    /// From the tiles of a sample. The limit fails with a probability of `risk`.
    #[must_use]
    pub fn new(tiles: &[Tile], unseen: Unseen, risk: f64) -> Self {
        let weight = |tile: &Tile| 1.0 / tile.probability;
        let sum = |of: &dyn Fn(&Tile) -> f64| tiles.iter().map(of).sum::<f64>();
        let total = sum(&|tile| weight(tile) * tile.events as f64);
        let changed = sum(&|tile| weight(tile) * tile.changes as f64);
        let share = if changed > 0.0 { changed / total } else { 0.0 };
        let whole = |of: fn(&Tile) -> u64| tiles.iter().map(of).sum::<u64>();
        let (events, changes) = (whole(|tile| tile.events), whole(|tile| tile.changes));
        let drawn: Vec<Tile> = { tiles.iter() }
            .filter(|tile| tile.probability < 1.0)
            .copied()
            .collect();
        let limit = if drawn.is_empty() {
            // All of it was run.
            if events > 0 || changes == 0 {
                Ok(share)
            } else {
                Err(NoLimit::NoEvents)
            }
        } else if events < LEAST_EVENTS {
            Err(NoLimit::FewEvents)
        } else if drawn.len() == 1 {
            Err(NoLimit::OneTile)
        } else {
            let known = changed - { drawn.iter() }
                .map(|tile| weight(tile) * tile.changes as f64)
                .sum::<f64>();
            let certain = tiles.iter().filter(|tile| tile.probability >= 1.0);
            let most = certain.map(|tile| tile.changes).max().unwrap_or(0);
            let upper = known + upper(&drawn, unseen, most, risk);
            let error = share * spread(&drawn) / total * deviations(risk);
            let more = upper / total - share;
            Ok(share + (more * more + error * error).sqrt())
        };
        Self {
            share,
            limit: limit.ok(),
            no_limit: limit.err(),
            tiles: tiles.len() as u64,
            events,
            changes,
        }
    }

    /// The same of what a readout delivers whose slots the plainer model never fills. An event that
    /// the full model loses there is one that it has more of, a change: each counts once more, and
    /// there are as many events fewer.
    #[must_use]
    pub fn behind_slots(self) -> Self {
        let twice = |limit: f64| {
            if limit < 1.0 {
                2.0 * limit / (1.0 - limit)
            } else {
                f64::INFINITY
            }
        };
        Self {
            limit: self.limit.map(twice),
            ..self
        }
    }

    /// Whether the limit allows it.
    #[must_use]
    pub fn is_within(&self, tolerance: f64) -> bool {
        self.limit.is_some_and(|limit| limit <= tolerance)
    }
}

/// The upper limit of the changes that drawn tiles stand for; a tile that was not has `certain`.
fn upper(drawn: &[Tile], unseen: Unseen, certain: u64, risk: f64) -> f64 {
    let jump = |tile: &Tile| tile.changes as f64 / tile.probability;
    let sum = |of: &dyn Fn(&Tile) -> f64| drawn.iter().map(of).sum::<f64>();
    let mean = sum(&jump);
    let variance = sum(&|tile| (1.0 - tile.probability) * jump(tile).powi(2));
    // An event picked at random belongs to a cell, or a tile, of so many events, weighted.
    let events = sum(&|tile| tile.events as f64 / tile.probability);
    let squares = sum(&|tile| {
        let squares = match unseen.history {
            History::Cell => tile.squares as f64,
            History::Alike => tile.alike as f64,
            History::Tile => (tile.events as f64).powi(2),
        };
        squares / tile.probability.powi(2)
    });
    let history = if events > 0.0 { squares / events } else { 0.0 };
    let stands = |tile: &Tile| 1.0 / tile.probability;
    let widest = drawn.iter().map(stands).fold(0.0, f64::max);
    let like_certain = certain as f64 * sum(&stands) / drawn.len().max(1) as f64;
    let least = { history.max(unseen.at_least as f64 * widest) }.max(like_certain);
    let most = drawn.iter().map(jump).fold(least, f64::max);
    if most <= 0.0 {
        return 0.0;
    }
    let (mean, variance) = (mean + most, variance + most * most);
    let shape = mean * mean / variance;
    // Wilson & Hilferty 1931: the cube root of a gamma number is nearly normal. Its error at the
    // shapes that can be here, from 1 on, is below 1 %.
    let root = 1.0 - 1.0 / (9.0 * shape) + deviations(risk) / (3.0 * shape.sqrt());
    mean * root.powi(3)
}

/// The standard deviation of the number of events that drawn tiles stand for.
fn spread(drawn: &[Tile]) -> f64 {
    let count = drawn.len() as f64;
    if count < 2.0 {
        return f64::INFINITY;
    }
    let stands = |tile: &Tile| tile.events as f64 / tile.probability;
    let mean = drawn.iter().map(stands).sum::<f64>() / count;
    let square = |tile: &Tile| (1.0 - tile.probability) * (stands(tile) - mean).powi(2);
    let squares: f64 = drawn.iter().map(square).sum();
    (squares * count / (count - 1.0)).sqrt()
}

/// How many standard deviations a normal number exceeds with this probability, below a half
/// (Abramowitz & Stegun 26.2.23, off by less than 4.5e-4).
fn deviations(risk: f64) -> f64 {
    let t = (-2.0 * elementary::ln(risk.clamp(1e-12, 0.5))).sqrt();
    let above = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let below = 1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308));
    t - above / below
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tile(probability: f64, events: u64, changes: u64) -> Tile {
        Tile {
            probability,
            events,
            squares: 4 * events,
            alike: 8 * events,
            changes,
        }
    }

    #[test]
    fn deviations_are_those_of_tables() {
        for (risk, want) in [
            (0.5, 0.0),
            (0.05, 1.6449),
            (0.0125, 2.2414),
            (0.001, 3.0902),
        ] {
            assert!(
                (deviations(risk) - want).abs() < 1e-3,
                "{risk}: {}",
                deviations(risk)
            );
        }
    }

    #[test]
    fn nothing_that_fired_says_nothing() {
        let silent = [tile(0.1, 0, 0); 20];
        assert_eq!(
            ChangeEstimate::new(&silent, History::Cell.into(), 0.05).limit,
            None
        );
        let few = [tile(0.1, 4, 0); 20];
        assert_eq!(
            ChangeEstimate::new(&few, History::Cell.into(), 0.05).limit,
            None
        );
    }

    /// The rule of three: without a change, at most three histories of a cell.
    #[test]
    fn no_change_has_a_limit() {
        let tiles = [tile(0.1, 100, 0); 20];
        let estimate = ChangeEstimate::new(&tiles, History::Cell.into(), 0.05);
        // A history counts 4 events, ten times over, of 20000.
        let want = 2.9957 * 40.0 / 20_000.0;
        let limit = estimate.limit.unwrap();
        assert!((limit / want - 1.0).abs() < 0.02, "{limit} {want}");
        assert_eq!(estimate.share, 0.0);
        let limit = |unseen: Unseen| ChangeEstimate::new(&tiles, unseen, 0.05).limit.unwrap();
        let events = |at_least| Unseen {
            history: History::Cell,
            at_least,
        };
        assert!((limit(History::Alike.into()) / (2.0 * want) - 1.0).abs() < 0.02);
        // A cell of 50 events that is not in the sample stands for ten.
        assert!((limit(events(50)) / (12.5 * want) - 1.0).abs() < 0.02);
        assert_eq!(limit(events(2)), estimate.limit.unwrap());
        let wide = limit(History::Tile.into());
        assert!((wide / (2.9957 / 20.0) - 1.0).abs() < 0.02, "{wide}");
    }

    /// Of twenty tiles that change alike: a Poisson number of 20 has the limit 29.06.
    #[test]
    fn equal_jumps_are_a_poisson_number() {
        let tiles = [tile(0.001, 1000, 50); 20];
        let estimate = ChangeEstimate::new(&tiles, History::Cell.into(), 0.05);
        assert!((estimate.share - 0.05).abs() < 1e-12);
        let limit = estimate.limit.unwrap();
        assert!((limit - 0.05 * 29.06 / 20.0).abs() < 2e-4, "{limit}");
    }

    /// What is only seen in a tile taken for certain may be in one that was not drawn.
    #[test]
    fn changes_of_certain_tiles_are_jumps_too() {
        let limit = |changes| {
            let mut tiles = [tile(0.1, 100, 0); 21];
            tiles[20] = tile(1.0, 100, changes);
            ChangeEstimate::new(&tiles, History::Cell.into(), 0.05).limit
        };
        // Of 20,100 events ten times 40 changes, three times over, and the 40 themselves.
        let want = (2.9957 * 400.0 + 40.0) / 20_100.0;
        assert!((limit(40).unwrap() / want - 1.0).abs() < 0.02);
        // A cell's history is more.
        assert!(limit(3) < limit(0).map(|none| none + 0.001));
    }

    #[test]
    fn what_was_run_whole_is_known() {
        let tiles = [tile(1.0, 100, 3), tile(1.0, 0, 1)];
        let estimate = ChangeEstimate::new(&tiles, History::Tile.into(), 0.01);
        assert_eq!((estimate.share, estimate.limit), (0.04, Some(0.04)));
        assert!(estimate.is_within(0.04) && !estimate.is_within(0.039));
        let of_none = ChangeEstimate::new(&[tile(1.0, 0, 1)], History::Tile.into(), 0.01);
        assert_eq!(of_none.limit, None);
        assert_eq!(of_none.no_limit, Some(NoLimit::NoEvents));
        let silent = ChangeEstimate::new(&[tile(1.0, 0, 0)], History::Tile.into(), 0.01);
        assert_eq!((silent.share, silent.limit), (0.0, Some(0.0)));
    }
}
