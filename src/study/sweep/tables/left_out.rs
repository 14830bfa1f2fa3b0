//! What plainer models leave out of a sensor whose figures they stand for, under
//! `fidelity = "auto"`, and how far its figures may be off for that.

use std::collections::BTreeSet;

use serde::Serialize;
use serde_json::Value as Json;

use super::table::{self, Row};
use crate::study::front::{Between, Cost};

/// What is left out of a sensor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LeftOut {
    /// What, at each of its points.
    pub what: BTreeSet<String>,
    /// Points with the figures of a plainer model.
    pub points: usize,
    /// The largest upper limit, over the points, of the share of events that this changes.
    pub limit: f64,
    /// By how much the mean error may be off: limits as parts of what chance leaves.
    pub error_off: f64,
    /// By what share a mean count may be off.
    pub count_off: f64,
}

/// Whether a plainer model stands for a point.
pub(in crate::study::sweep) fn stands_for(row: &Row) -> bool {
    !table::cell(row, "left_out").is_empty()
}

impl LeftOut {
    /// Of a sensor with these points; none where all were computed as they are.
    pub(super) fn of(rows: &[&Row]) -> Option<Self> {
        let number = |row: &Row, name: &str| row.get(name).and_then(Json::as_f64).unwrap_or(0.0);
        let left: Vec<&Row> = { rows.iter().copied() }
            .filter(|row| stands_for(row))
            .collect();
        let limits = || left.iter().map(|row| number(row, "left_out_limit"));
        // What is kept is told as a part of what chance leaves.
        let errors = { left.iter() }
            .map(|row| number(row, "left_out_limit") / (1.0 - number(row, "floor")).max(1e-9));
        let all = rows.len() as f64;
        (!left.is_empty()).then(|| Self {
            what: left
                .iter()
                .map(|row| table::cell(row, "left_out"))
                .collect(),
            points: left.len(),
            limit: limits().fold(0.0, f64::max),
            error_off: errors.sum::<f64>() / all,
            count_off: limits().sum::<f64>() / all,
        })
    }

    /// Between which costs a sensor lies. Its words and its bytes of state are its own, its time is
    /// another model's.
    pub(super) fn between(&self, cost: &str, Cost { x, y }: Cost) -> Between {
        let (low, high) = match cost {
            "seconds_per_frame" => (0.0, f64::INFINITY),
            "bits" => (x * (1.0 - self.count_off), x * (1.0 + self.count_off)),
            _ => (x, x),
        };
        Between {
            low: Cost {
                x: low,
                y: y - self.error_off,
            },
            high: Cost {
                x: high,
                y: y + self.error_off,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn limits_are_parts_of_what_chance_leaves() {
        let row = |row: Json| row.as_object().unwrap().clone();
        let own = row(json!({"left_out": "", "left_out_limit": 0.0, "floor": 0.5}));
        let plain = row(json!({"left_out": "f16", "left_out_limit": 0.1, "floor": 0.5}));
        assert_eq!(LeftOut::of(&[&own]), None);
        let left = LeftOut::of(&[&own, &plain]).unwrap();
        assert_eq!((left.points, left.limit), (1, 0.1));
        assert_eq!((left.error_off, left.count_off), (0.1, 0.05));
        let at = |cost: &str| left.between(cost, Cost { x: 100.0, y: 0.3 });
        assert_eq!((at("bits").low.x, at("bits").high.x), (95.0, 105.0));
        assert_eq!(at("words").low.x, 100.0);
        assert_eq!(at("seconds_per_frame").high.x, f64::INFINITY);
    }
}
