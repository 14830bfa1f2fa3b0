//! The grid: every combination of the values of every axis, in a fixed order.

use super::{
    point::Point,
    thresholds::Thresholds,
    value::{Ramp, Value, Values},
};
use crate::{
    config::{Fault, Place},
    study::sweep::study_file::key::{Key, Kind, Side},
};

/// The most points that a study may name.
pub const MOST_POINTS: u64 = crate::limit::STUDY_POINTS;

/// One axis of one side.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// The key of the study that it varies.
    pub key: &'static Key,
    /// What it runs through.
    pub values: Values,
    /// Where it stands in the study; the side, when it is left out.
    pub place: Place,
}

impl PartialEq for Key {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name && self.sides == other.sides
    }
}

/// All axes of one side.
#[derive(Clone, Debug, PartialEq)]
pub struct Axes {
    /// Which sensor.
    pub side: Side,
    /// In the order of the table of keys, the last running fastest.
    pub axes: Vec<Axis>,
    /// Where the side stands.
    pub place: Place,
}

impl Axis {
    /// How many values there are; a range without steps has any number.
    #[must_use]
    pub fn count(&self) -> Option<u64> {
        match &self.values {
            Values::List(list) => Some(list.len() as u64),
            Values::Ramp(ramp) => ramp.steps,
        }
    }

    /// One of its values, from 0.
    #[must_use]
    pub fn at(&self, index: u64) -> Option<Value> {
        match &self.values {
            Values::List(list) => list
                .get(usize::try_from(index).ok()?)
                .map(|(value, _)| value.clone()),
            Values::Ramp(ramp) => Some(self.on(ramp, ramp.part(index))),
        }
    }

    /// The value at a number in [0, 1): each value of a list has an equal share.
    #[must_use]
    pub fn draw(&self, part: f64) -> Option<Value> {
        match (&self.values, self.count()) {
            (Values::Ramp(ramp), None) => Some(self.on(ramp, part)),
            (_, Some(count)) => self.at(((part * count as f64) as u64).min(count.checked_sub(1)?)),
            (Values::List(_), None) => None,
        }
    }

    fn on(&self, ramp: &Ramp, part: f64) -> Value {
        let number = ramp.at(part);
        match self.key.kind {
            Kind::Whole { .. } => Value::Whole(number.round() as u64),
            Kind::Threshold => Value::Threshold(Thresholds::both(number)),
            _ => Value::Number(number),
        }
    }

    /// Where a value stands.
    #[must_use]
    pub fn place_of(&self, value: &Value) -> Place {
        match &self.values {
            Values::List(list) => {
                let found = list.iter().find(|(listed, _)| listed == value);
                found.map_or(self.place, |(_, place)| *place)
            }
            Values::Ramp(_) => self.place,
        }
    }
}

impl Axes {
    /// Points of this side; `None` where 128 bits do not hold their number.
    #[must_use]
    pub fn count(&self) -> Option<u128> {
        let mut counts = self.axes.iter().map(|axis| axis.count().unwrap_or(1));
        counts.try_fold(1, |all: u128, one| all.checked_mul(one.into()))
    }

    /// A point of the grid, from 0.
    fn at(&self, mut index: u64) -> Point {
        let mut values = Vec::new();
        for axis in self.axes.iter().rev() {
            let count = axis.count().unwrap_or(1).max(1);
            values.extend(axis.at(index % count).map(|value| (axis.key.name, value)));
            index /= count;
        }
        Point::new(self.side, values)
    }
}

/// Every point, side after side.
///
/// # Errors
/// When there are too many.
pub fn points(sides: &[Axes]) -> Result<Vec<Point>, Fault> {
    let all = sides
        .iter()
        .try_fold(0_u128, |all, axes| all.checked_add(axes.count()?));
    if all.is_none_or(|all| all > u128::from(MOST_POINTS)) {
        return Err(too_many(sides, all));
    }
    let mut points = Vec::new();
    for axes in sides {
        // Checked above.
        let count = axes
            .count()
            .and_then(|n| u64::try_from(n).ok())
            .unwrap_or(0);
        points.extend((0..count).map(|index| axes.at(index)));
    }
    Ok(points)
}

/// Points at the longest axis of the largest side.
fn too_many(sides: &[Axes], all: Option<u128>) -> Fault {
    let largest = sides
        .iter()
        .max_by_key(|axes| axes.count().unwrap_or(u128::MAX));
    let all = all.map_or("more points than can be counted".to_owned(), |all| {
        format!("{all} points")
    });
    let longest = largest.and_then(|axes| axes.axes.iter().max_by_key(|axis| axis.count()));
    let factors: Vec<String> = largest
        .iter()
        .flat_map(|axes| &axes.axes)
        .filter(|axis| axis.count() != Some(1))
        .map(|axis| format!("{} {}", axis.count().unwrap_or(0), axis.key.name))
        .collect();
    let place = longest.map_or(Place::new(0, 0), |axis| axis.place);
    Fault::error(
        place,
        format!("the grid has {all} ({}), more than {MOST_POINTS}", factors.join(" x ")),
        "the longest axis",
    )
    .help("take fewer values, several studies, or draw points from the grid with sample = { method = \"sobol\", points = 1024 } above the first [[side]]")
}
