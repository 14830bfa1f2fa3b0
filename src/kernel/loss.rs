//! What a number format that holds a kernel's weights takes from it.

use std::fmt;

use super::Kernel;
use crate::{
    number::{Format, Number, Visitor},
    unit::five_digits,
};

/// A kernel is another one where its weights, held, add up to so much less or more in size.
const OTHER: f64 = 0.5;

/// What a kernel is no more where a number format holds its weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loss {
    /// The format.
    pub format: Format,
    /// What it is.
    pub kind: LossKind,
    /// Weights that are 0 there, and were not.
    pub zero: usize,
    /// All weights.
    pub of: usize,
}

/// What is lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LossKind {
    /// Weights lie beyond the ends of the format.
    Clipped {
        /// How many do.
        weights: usize,
        /// The one that is farthest from 0.
        largest: f64,
    },
    /// No weight is left.
    Nothing {
        /// The largest that there was.
        largest: f64,
    },
    /// The sizes of the weights add up to another number by more than half of it.
    Size {
        /// What they add up to.
        size: f64,
        /// What they add up to as they are held.
        held: f64,
    },
    /// The weights add up to another number, so that a threshold is reached where all pixels change
    /// alike.
    Sum {
        /// What they add up to.
        sum: f64,
        /// What they add up to as they are held.
        held: f64,
        /// By how much light from 0 to 255 then moves the drive more than it should, or less.
        moves: f64,
        /// The threshold that is least.
        threshold: f64,
    },
}

impl Loss {
    /// Whether hardly any kernel is left.
    #[must_use]
    pub fn leaves_little(&self) -> bool {
        match self.kind {
            LossKind::Nothing { .. } => true,
            LossKind::Size { size, held } => held < size,
            LossKind::Clipped { .. } | LossKind::Sum { .. } => false,
        }
    }

    /// What takes it.
    #[must_use]
    pub const fn why(&self) -> &'static str {
        match self.kind {
            LossKind::Clipped { .. } => {
                "the weights exceed the range of the format, which has no scale of its own"
            }
            LossKind::Nothing { .. } | LossKind::Size { .. } | LossKind::Sum { .. } => {
                "the weights are small compared with the step of the format, to which each is rounded"
            }
        }
    }

    /// What to change.
    #[must_use]
    pub const fn change(&self) -> &'static str {
        match self.kind {
            LossKind::Clipped { .. } => {
                "use more bits before the point, or scale weights (gain) and thresholds down together"
            }
            LossKind::Nothing { .. } | LossKind::Size { .. } | LossKind::Sum { .. } => {
                "use more bits after the point, or scale weights (gain) and thresholds up together"
            }
        }
    }
}

impl fmt::Display for Loss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            format, zero, of, ..
        } = *self;
        let step = five_digits(2.0 * format.half_step());
        let (low, high) = format.limits();
        let rounded = if zero > 0 {
            format!("in {format} {zero} of {of} weights are 0")
        } else {
            format!("in {format} its weights are rounded")
        };
        match self.kind {
            LossKind::Clipped { largest, .. } if of == 1 => write!(
                f,
                "its weight, {}, lies beyond the range of {format}, {low} to {high}",
                five_digits(largest)
            ),
            LossKind::Clipped { weights, largest } => write!(
                f,
                "{weights} of {of} weights lie beyond the range of {format}, {low} to {high}: the farthest is {}",
                five_digits(largest)
            ),
            LossKind::Nothing { largest } => {
                let all = if of == 1 {
                    "its weight is".to_owned()
                } else {
                    format!("all of its {of} weights are")
                };
                let largest = five_digits(largest);
                write!(
                    f,
                    "in {format} {all} 0: the largest is {largest}, the smallest step {step}"
                )
            }
            LossKind::Size { size, held } if of == 1 => write!(
                f,
                "in {format} the size of its weight is {} instead of {}: the smallest step is {step}",
                five_digits(held),
                five_digits(size)
            ),
            LossKind::Size { size, held } => write!(
                f,
                "{rounded}, and their sizes add up to {} instead of {}: the smallest step is {step}",
                five_digits(held),
                five_digits(size)
            ),
            LossKind::Sum {
                sum,
                held,
                moves,
                threshold,
            } => write!(
                f,
                "{rounded}, and they add up to {} instead of {}: a uniform change of light from 0 to 255 moves the drive by {}, against a threshold of {}",
                five_digits(held),
                five_digits(sum),
                five_digits(moves.abs()),
                five_digits(threshold)
            ),
        }
    }
}

impl Kernel {
    /// What it loses in a format, where that makes it another kernel: for signals that move by
    /// `signal` at most, and events from `threshold` on.
    #[must_use]
    pub fn loss(&self, format: Format, signal: f64, threshold: f64) -> Option<Loss> {
        let held = format.visit(HeldWeights(self));
        let weights: Vec<f64> = self.weights().iter().copied().collect();
        let pairs = || weights.iter().zip(&held);
        let ((low, high), step) = (format.limits(), format.half_step());
        let is_beyond = |weight: &f64| *weight > high + step || *weight < low - step;
        let farthest = |most: f64, weight: &f64| {
            if weight.abs() > most.abs() {
                *weight
            } else {
                most
            }
        };
        let clipped = weights.iter().filter(|weight| is_beyond(weight));
        let loss = |kind| Loss {
            format,
            kind,
            zero: pairs()
                .filter(|(w, held)| **w != 0.0 && **held == 0.0)
                .count(),
            of: weights.len(),
        };
        if clipped.clone().next().is_some() {
            return Some(loss(LossKind::Clipped {
                weights: clipped.clone().count(),
                largest: clipped.fold(0.0, farthest),
            }));
        }
        let added = |all: &[f64]| {
            (
                all.iter().sum::<f64>(),
                all.iter().map(|w| w.abs()).sum::<f64>(),
            )
        };
        let ((sum, size), (held_sum, held_size)) = (added(&weights), added(&held));
        if size > 0.0 && held_size == 0.0 {
            let largest = weights.iter().fold(0.0, farthest);
            return Some(loss(LossKind::Nothing { largest }));
        }
        if (held_size - size).abs() > OTHER * size {
            let held = held_size;
            return Some(loss(LossKind::Size { size, held }));
        }
        // What is left of weights that cancel is rounding alone.
        let sum = if self.cancels() { 0.0 } else { sum };
        let moves = (held_sum - sum) * signal;
        (moves.abs() >= threshold).then(|| {
            let held = held_sum;
            loss(LossKind::Sum {
                sum,
                held,
                moves,
                threshold,
            })
        })
    }
}

/// The weights of a kernel as they are held.
struct HeldWeights<'a>(&'a Kernel);

impl Visitor for HeldWeights<'_> {
    type Output = Vec<f64>;
    fn visit<N: Number>(self, number: N) -> Vec<f64> {
        let weights = self.0.weights().iter();
        weights
            .map(|weight| number.value(number.hold(*weight)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn loss(rows: &[Vec<f64>], format: &str, (signal, threshold): (f64, f64)) -> Option<LossKind> {
        let kernel = Kernel::from_rows(rows).unwrap();
        let loss = kernel.loss(format.parse().unwrap(), signal, threshold);
        loss.map(|loss| loss.kind)
    }

    #[test]
    fn a_kernel_loses_its_weights_its_size_its_sum_or_its_ends() {
        let one = |weight: f64| [vec![weight]];
        let all = (255.0, 10.0);
        assert_eq!(loss(&one(0.25), "q8.8", all), None);
        let nothing = LossKind::Nothing { largest: 0.001 };
        assert_eq!(loss(&one(0.001), "q8.8", all), Some(nothing));
        assert_eq!(loss(&one(0.001), "q8.24", all), None);
        assert_eq!(
            loss(&one(1e-9), "f16", all),
            Some(LossKind::Nothing { largest: 1e-9 })
        );
        let size = LossKind::Size {
            size: 0.002,
            held: 0.003_906_25,
        };
        assert_eq!(loss(&one(0.002), "q8.8", all), Some(size));
        let clipped = LossKind::Clipped {
            weights: 1,
            largest: -200.0,
        };
        for format in ["q8.8", "q8.8-wrap"] {
            assert_eq!(loss(&one(-200.0), format, all), Some(clipped));
        }
        // The last that is held, and what rounds to it.
        assert_eq!(loss(&one(127.997), "q8.8", all), None);
        // Eight weights that lose as much each, and one that loses other than eight times that.
        let w = 0.013;
        let ring = [vec![w; 3], vec![w, -8.0 * w, w], vec![w; 3]];
        assert_eq!(loss(&ring, "q8.8", all), None);
        let lost = LossKind::Sum {
            sum: 0.0,
            held: -0.011_718_75,
            moves: -2.988_281_25,
            threshold: 1.0,
        };
        assert_eq!(loss(&ring, "q8.8", (255.0, 1.0)), Some(lost));
        assert_eq!(loss(&ring, "q8.24", (255.0, 1.0)), None);
    }
}
