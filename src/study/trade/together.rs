//! What is left out together: first what changes least, then one thing more at a time.

use super::Point;
use crate::{order::Order, study::pilot::family::Family};

/// What changes more by itself is not left out with others.
const MUCH: f64 = 1.0;

/// A format that changes more is not the one that others go with.
const COARSE: f64 = 0.2;

/// Models that leave several things out, of what is known of those that leave out one: the effects
/// in the order of what they change, one more at a time, in the full model's numbers and in the
/// quickest numbers that are close to them.
pub fn together<F: Family>(
    family: &F,
    points: &[Point<F::Model>],
    alternative: &dyn Fn(&F::Model) -> bool,
) -> Vec<F::Model> {
    let full = family.full();
    let error = |point: &Point<F::Model>| point.error().unwrap_or(f64::INFINITY);
    let (formats, mut effects): (Vec<_>, Vec<_>) = { points.iter() }
        .filter(|point| point.model != full && error(point) <= MUCH)
        .partition(|point| alternative(&point.model));
    // Equal ones stay in the order of their list.
    effects.order_by(|a, b| error(a).total_cmp(&error(b)));
    let seconds = |point: &Point<F::Model>| point.seconds().unwrap_or(f64::INFINITY);
    let whole = points.iter().find(|point| point.model == full).map(seconds);
    let best = { formats.into_iter() }
        .filter(|point| error(point) <= COARSE && Some(seconds(point)) < whole)
        .min_by(|a, b| seconds(a).total_cmp(&seconds(b)));
    let mut all = Vec::new();
    for count in 1..=effects.len() {
        let some = effects.iter().take(count);
        let mut some: Vec<F::Model> = some.map(|point| point.model.clone()).collect();
        if count > 1 {
            all.extend(family.together(&some));
        }
        if let Some(best) = best {
            some.push(best.model.clone());
            all.extend(family.together(&some));
        }
    }
    all
}
