//! The heuristic: estimated words between a state and the input alone. It orders the beam.

use std::{cell::OnceCell, rc::Rc};

use super::{Item, Search, State};
use crate::{
    compile::intermediate::linear_form::{LinearForm, NEWS_CELLS, Tap},
    number::signed_digits,
};

impl Search<'_> {
    #[expect(clippy::unused_self, reason = "as find, which does look")]
    pub(super) fn item(&self, form: LinearForm) -> Rc<Item> {
        Rc::new(Item {
            hash: form.fingerprint(),
            cost: OnceCell::new(),
            form,
        })
    }

    pub(super) fn cost(&self, item: &Item) -> f32 {
        *item.cost.get_or_init(|| self.cost_alone(&item.form))
    }

    /// The item of a form: the one that is already live, or a new one.
    pub(super) fn find(&self, state: &State, form: LinearForm) -> Rc<Item> {
        if form == self.input.form {
            return self.input.clone();
        }
        let known = state.live.iter().find(|item| item.form == form);
        known.cloned().unwrap_or_else(|| self.item(form))
    }

    /// Estimated words to make a value from the input alone.
    fn cost_alone(&self, form: &LinearForm) -> f32 {
        let taps = form.taps();
        if taps.is_empty() {
            return 1.0;
        }
        let unit = self.task.unit;
        if let [only] = taps
            && (only.y, only.x) == (0, 0)
            && only.weight.abs() == unit
        {
            return if only.weight == unit { 0.0 } else { 1.0 };
        }
        let digits: u32 = taps
            .iter()
            .map(|tap| signed_digits(tap.weight).saturating_sub(1))
            .sum();
        // All weights are made together: halvings from the unit down, doublings up.
        let one = i64::from(unit.trailing_zeros());
        let low = taps.iter().map(|tap| tap.weight.trailing_zeros()).min();
        let high = taps
            .iter()
            .map(|tap| tap.weight.unsigned_abs().ilog2())
            .max();
        let down = (one - i64::from(low.unwrap_or(0))).max(0);
        let up = (i64::from(high.unwrap_or(0)) - one).max(0);
        let levels = down as f32 + 2.5 * up as f32;
        self.heuristic.value
            + self.heuristic.digit * digits as f32
            + self.heuristic.place * spread(taps)
            + self.heuristic.level * levels
    }

    /// The estimate for a state: each value is made from the cheapest of those made before it.
    pub(super) fn score(&self, state: &State) -> f32 {
        let mut items: Vec<(f32, &Rc<Item>)> = state
            .live
            .iter()
            .map(|item| (self.cost(item), item))
            .collect();
        items.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.hash.cmp(&b.1.hash)));
        let mut total = 0.0;
        let mut base: Vec<&LinearForm> = vec![&self.input.form];
        for (own, item) in items {
            let mut cost = own;
            if cost > 1.0 {
                for other in &base {
                    cost = cost.min(self.cost_given(&item.form, other));
                }
            }
            total += cost;
            if item.hash != self.input.hash {
                base.push(&item.form);
            }
        }
        if let Some(news) = &state.news {
            let stored = |other: &&&LinearForm| {
                NEWS_CELLS
                    .iter()
                    .any(|place| news.form.is_shifted(other, *place, -1))
            };
            let mut least = if base.iter().any(|other| stored(&other)) {
                0.0
            } else {
                self.cost(news)
            };
            if least > 1.0 && self.heuristic.related {
                for other in &base[1..] {
                    least = least.min(self.cost_given(&news.form, other));
                }
            }
            total += 1.0 + least;
        }
        total
    }

    /// Estimated words to make a value once another is there.
    fn cost_given(&self, form: &LinearForm, other: &LinearForm) -> f32 {
        for place in NEWS_CELLS {
            let own = place == (0, 0);
            if form.is_shifted(other, place, -1) {
                return if own { 1.0 } else { 2.0 };
            }
            if form.is_shifted(other, place, 1) {
                return 2.0;
            }
        }
        if form.is_shifted(other, (0, 0), 2) || form.is_shifted(other, (0, 0), -2) {
            return 3.0;
        }
        let mut least = f32::INFINITY;
        if self.heuristic.related && other.taps().len() > 1 {
            for times in [1, -1] {
                let rest = form.plus(other, times);
                least = least.min(1.5 + self.cost_alone(&rest));
            }
        }
        least
    }
}

/// The sum of the magnitudes of all weights.
pub(super) fn weight(form: &LinearForm) -> i64 {
    form.taps().iter().map(|tap| tap.weight.abs()).sum()
}

/// A lower bound on the moves that visit all places, starting at the pixel: the length of the
/// minimum spanning tree.
pub(super) fn spread(taps: &[Tap]) -> f32 {
    let apart = |a: &Tap, b: &Tap| (a.y - b.y).abs() + (a.x - b.x).abs();
    if taps.len() > 40 {
        let near = taps.iter().map(|tap| tap.y.abs() + tap.x.abs()).min();
        return taps.len() as f32 + f32::from(near.unwrap_or(0));
    }
    let mut far: [i16; 40] = [0; 40];
    for (far, tap) in far.iter_mut().zip(taps) {
        *far = tap.y.abs() + tap.x.abs();
    }
    let mut left: Vec<usize> = (0..taps.len()).collect();
    let mut total = 0;
    while let Some((at, &i)) = left.iter().enumerate().min_by_key(|(_, i)| far[**i]) {
        total += far[i];
        left.swap_remove(at);
        for &j in &left {
            far[j] = far[j].min(apart(&taps[i], &taps[j]));
        }
    }
    f32::from(total)
}

/// Parts of a sum that may be worth a value of their own (common subexpressions).
pub(super) fn parts(sum: &LinearForm) -> Vec<LinearForm> {
    let some = |keep: &dyn Fn(&Tap) -> bool| {
        LinearForm::new(sum.taps().iter().copied().filter(|tap| keep(tap)).collect())
    };
    let mut parts = vec![
        some(&|tap| tap.weight > 0),
        some(&|tap| tap.y == 0),
        some(&|tap| tap.x == 0),
        some(&|tap| tap.y < 0),
        some(&|tap| tap.x < 0),
    ];
    // The same weight everywhere, under what is left: a box and the difference to it.
    let least = sum.taps().iter().map(|tap| tap.weight.abs()).min();
    if let Some(least) = least {
        let flat = sum.taps().iter().map(|tap| Tap {
            weight: least * tap.weight.signum(),
            ..*tap
        });
        parts.push(LinearForm::new(flat.collect()));
        for sign in [1, -1] {
            let rows = sum.taps().iter().map(|tap| tap.y.abs()).max().unwrap_or(0);
            let columns = sum.taps().iter().map(|tap| tap.x.abs()).max().unwrap_or(0);
            if (rows.max(columns)) <= 5 {
                let places = (-rows..=rows).flat_map(|y| (-columns..=columns).map(move |x| (y, x)));
                let commonest = places
                    .clone()
                    .map(|p| sum.at(p) * i64::from(sign))
                    .filter(|w| *w > 0);
                let mut weights: Vec<i64> = commonest.collect();
                weights.sort_unstable();
                if let Some(&middle) = weights.get(weights.len() / 2) {
                    let whole = places.map(|(y, x)| Tap {
                        y,
                        x,
                        weight: middle * i64::from(sign),
                    });
                    parts.push(LinearForm::new(whole.collect()));
                }
            }
        }
    }
    parts.sort_unstable();
    parts.dedup();
    parts
}
