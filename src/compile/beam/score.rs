//! How far a state is from done: what orders the beam.

use std::{cell::OnceCell, rc::Rc};

use super::{
    super::field::{Field, Tap, VIEWS},
    Item, Search, State,
};
use crate::number::signed_digits;

impl Search<'_> {
    #[expect(clippy::unused_self, reason = "as find, which does look")]
    pub(super) fn item(&self, field: Field) -> Rc<Item> {
        Rc::new(Item {
            hash: field.fingerprint(),
            cost: OnceCell::new(),
            field,
        })
    }

    pub(super) fn cost(&self, item: &Item) -> f32 {
        *item.cost.get_or_init(|| self.own(&item.field))
    }

    /// The item of a field: the one that is already live, or a new one.
    pub(super) fn find(&self, state: &State, field: Field) -> Rc<Item> {
        if field == self.input.field {
            return self.input.clone();
        }
        let known = state.live.iter().find(|item| item.field == field);
        known.cloned().unwrap_or_else(|| self.item(field))
    }

    /// What a value is thought to cost by itself.
    pub(super) fn own(&self, field: &Field) -> f32 {
        let taps = field.taps();
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
        // From the unit down by halves, up by doubles, all weights of a value together.
        let one = i64::from(unit.trailing_zeros());
        let low = taps.iter().map(|tap| tap.weight.trailing_zeros()).min();
        let high = taps
            .iter()
            .map(|tap| tap.weight.unsigned_abs().ilog2())
            .max();
        let down = (one - i64::from(low.unwrap_or(0))).max(0);
        let up = (i64::from(high.unwrap_or(0)) - one).max(0);
        let levels = down as f32 + 2.5 * up as f32;
        self.taste.value
            + self.taste.digit * digits as f32
            + self.taste.place * spread(taps)
            + self.taste.level * levels
    }

    pub(super) fn score(&self, state: &State) -> f32 {
        let mut items: Vec<(f32, &Rc<Item>)> = state
            .live
            .iter()
            .map(|item| (self.cost(item), item))
            .collect();
        items.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.hash.cmp(&b.1.hash)));
        let mut total = 0.0;
        let mut base: Vec<&Field> = vec![&self.input.field];
        for (own, item) in items {
            let mut cost = own;
            if cost > 1.0 {
                for other in &base {
                    cost = cost.min(self.from(&item.field, other));
                }
            }
            total += cost;
            if item.hash != self.input.hash {
                base.push(&item.field);
            }
        }
        if let Some(news) = &state.news {
            let stored = |other: &&&Field| {
                VIEWS
                    .iter()
                    .any(|place| news.field.is_seen(other, *place, -1))
            };
            let mut least = if base.iter().any(|other| stored(&other)) {
                0.0
            } else {
                self.cost(news)
            };
            if least > 1.0 && self.taste.related {
                for other in &base[1..] {
                    least = least.min(self.from(&news.field, other));
                }
            }
            total += 1.0 + least;
        }
        total
    }

    /// What a value is thought to cost once another is there.
    pub(super) fn from(&self, field: &Field, other: &Field) -> f32 {
        for place in VIEWS {
            let own = place == (0, 0);
            if field.is_seen(other, place, -1) {
                return if own { 1.0 } else { 2.0 };
            }
            if field.is_seen(other, place, 1) {
                return 2.0;
            }
        }
        if field.is_seen(other, (0, 0), 2) || field.is_seen(other, (0, 0), -2) {
            return 3.0;
        }
        let mut least = f32::INFINITY;
        if self.taste.related && other.taps().len() > 1 {
            for times in [1, -1] {
                let rest = field.plus(other, times);
                least = least.min(1.5 + self.own(&rest));
            }
        }
        least
    }
}

pub(super) fn weight(field: &Field) -> i64 {
    field.taps().iter().map(|tap| tap.weight.abs()).sum()
}

/// How far one has to walk from the pixel to see all places, about: the shortest tree.
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

/// Parts of a sum that may be worth a value of their own.
pub(super) fn parts(sum: &Field) -> Vec<Field> {
    let some = |keep: &dyn Fn(&Tap) -> bool| {
        Field::of(sum.taps().iter().copied().filter(|tap| keep(tap)).collect())
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
        parts.push(Field::of(flat.collect()));
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
                    parts.push(Field::of(whole.collect()));
                }
            }
        }
    }
    parts.sort_unstable();
    parts.dedup();
    parts
}
