//! How a store errs on silicon: the one formula, for whoever runs or predicts it.
//!
//! ```text
//! cell := -(1 - loss + m_g) · share · sum + Δ + m_o + noise       limited to the range
//!         and for a bus that splits:  + division error
//! ```
//!
//! - The transfer error Δ is nearly the same for all cells, so two stores cancel it
//!   (`T = -x + Δ`, `y = -T + Δ = x`): why every macro of the vendor stores twice.
//! - The loss of each store, and how Δ of a splitting bus differs, are fitted to the chip's
//!   only public measurement: `diva(A,E,F); mov(F,A); add(A,A,F)`, an identity, repeated. A map
//!   that is affine in the signal explains it, inputs that were left out of the fit too; a curve
//!   explains no more (`docs/silicon.md`).
//! - Mismatch `m_g`, `m_o` belongs to one cell of one pixel; noise is drawn anew for every word.
//! - A bus that splits between two cells does so unevenly: what one gets more the other gets
//!   less, so that `diva`, which adds them again, corrects it to first order.
//!
//! All numbers but the step of the inputs (1 LSB) are the device's, each with its source:
//! `[figure.error]` of `device.toml`.

// What is not inlined is not compiled for the wide vectors.
#![allow(clippy::inline_always)]

use std::{
    cmp::Ordering,
    ops::{Add, Mul},
};

use super::{Device, Evidence, Figure, Role};

/// How a chip errs. Analogue values are in LSB, the ADC's steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Δ of every store, LSB.
    pub transfer: f64,
    /// Part of the signal that one store loses.
    pub loss: f64,
    /// How much more than Δ a splitting bus adds, LSB.
    pub division: f64,
    /// Spread of the gain of cells.
    pub gain_mismatch: f64,
    /// Spread of Δ of cells, LSB.
    pub offset_mismatch: f64,
    /// Correlation of the two.
    pub mismatch_correlation: f64,
    /// Spread of how unevenly a bus splits.
    pub division_mismatch: f64,
    /// Noise of every store, LSB.
    pub noise: f64,
    /// Step of the converter that sets the global input, LSB; 0 sets any value.
    pub input_step: f64,
    /// Lowest and highest value of a cell, LSB.
    pub range: (f64, f64),
    /// What a cell that nothing was put on holds, LSB.
    pub reset_level: f64,
    /// How fast every cell goes there, LSB/s.
    pub decay: f64,
    /// How long a one-bit cell holds at least without being written, s.
    pub retention: f64,
    /// Spread of how much longer it holds, as a part of that.
    pub retention_spread: f64,
}

/// What a store errs by. Who writes a store's structure again takes it apart without `..`: a new term
/// is then an error of the compiler there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StoreTerms {
    /// Δ of every store, LSB.
    pub transfer: f64,
    /// Part of the signal that one store loses.
    pub loss: f64,
    /// How much more than Δ a splitting bus adds, LSB.
    pub division: f64,
    /// Spread of the gain of cells.
    pub gain_mismatch: f64,
    /// Spread of Δ of cells, LSB.
    pub offset_mismatch: f64,
    /// Correlation of the two.
    pub mismatch_correlation: f64,
    /// Spread of how unevenly a bus splits.
    pub division_mismatch: f64,
    /// Noise of every store, LSB.
    pub noise: f64,
}

impl Errors {
    /// How well it is known by what a store errs: as well as the weakest of the chip's figures.
    #[must_use]
    pub fn evidence(device: &Device) -> Evidence {
        Evidence::weakest(Figure::of_a_store().map(|figure| device.figure(figure).evidence))
    }

    /// The same with the range within which it saturates.
    #[must_use]
    pub fn evidence_with_range(device: &Device) -> Evidence {
        let of_the_range = Figure::in_role(Role::Range);
        let of_the_range = of_the_range.map(|figure| device.figure(figure).evidence);
        Evidence::weakest([Self::evidence(device)].into_iter().chain(of_the_range))
    }

    /// As a chip's data has them.
    #[must_use]
    pub fn from_device(device: &Device) -> Self {
        let value = |figure| device.value(figure);
        let headroom = value(Figure::Headroom);
        let (lowest, highest) = device.register_range();
        Self {
            transfer: value(Figure::TransferError),
            loss: value(Figure::StoreLoss),
            division: value(Figure::DivisionError),
            gain_mismatch: value(Figure::GainMismatch),
            offset_mismatch: value(Figure::OffsetMismatch),
            mismatch_correlation: value(Figure::MismatchCorrelation),
            division_mismatch: value(Figure::DivisionMismatch),
            noise: value(Figure::StoreNoise),
            // The host's table has an entry for each LSB.
            input_step: 1.0,
            range: (lowest - headroom, highest + headroom),
            reset_level: value(Figure::ResetLevel),
            decay: value(Figure::AnalogueDecay),
            retention: value(Figure::Retention),
            retention_spread: value(Figure::RetentionSpread),
        }
    }

    /// What of them a store errs by.
    #[must_use]
    pub const fn of_a_store(&self) -> StoreTerms {
        let Self {
            transfer,
            loss,
            division,
            gain_mismatch,
            offset_mismatch,
            mismatch_correlation,
            division_mismatch,
            noise,
            input_step: _,
            range: _,
            reset_level: _,
            decay: _,
            retention: _,
            retention_spread: _,
        } = *self;
        StoreTerms {
            transfer,
            loss,
            division,
            gain_mismatch,
            offset_mismatch,
            mismatch_correlation,
            division_mismatch,
            noise,
        }
    }

    /// What the converter that sets the global input makes of a value, LSB.
    #[must_use]
    pub fn held(&self, lsb: f64) -> f64 {
        match self.input_step {
            0.0 => lsb,
            step => (lsb / step).round_ties_even() * step,
        }
    }

    /// What the host's calibrated table puts on the bus for a value, so that it arrives right after
    /// two stores of an average cell.
    #[must_use]
    pub fn calibrated(&self, lsb: f64) -> f64 {
        let gain = 1.0 - self.loss;
        (lsb - (1.0 - gain) * self.transfer) / (gain * gain)
    }

    /// The gain of a cell, with its mismatch: `-(1 - loss + m_g)`; `own` is the cell's normal
    /// number.
    #[must_use]
    pub fn gain(&self, own: f64) -> f64 {
        -(1.0 - self.loss + self.gain_mismatch * own)
    }

    /// The offset of a cell, with its mismatch: `Δ + m_o`; the cell's normal numbers are that of
    /// its gain, with which this correlates, and one of its own.
    #[must_use]
    pub fn offset(&self, gain: f64, own: f64) -> f64 {
        let together = self.mismatch_correlation;
        let mismatch = together * gain + self.apart() * own;
        self.transfer + self.offset_mismatch * mismatch
    }

    /// What the number that a cell has for its gain adds to a store, one unit of it: by its gain,
    /// and by the part of its offset that goes with it. `current` is the cell's share of the sum.
    #[must_use]
    pub fn of_gain(&self, current: f64) -> f64 {
        self.offset_mismatch * self.mismatch_correlation - current * self.gain_mismatch
    }

    /// The part of the mismatch of offsets that does not go with that of gains.
    #[must_use]
    pub fn apart(&self) -> f64 {
        let together = self.mismatch_correlation;
        (1.0 - together * together).max(0.0).sqrt()
    }
}

/// How much more than its share a target of a bus that splits gets: so often the pixel's split of
/// this number, of which a bus to so many targets has one fewer than targets. These are the corners
/// of a regular simplex: each target has the same spread, and all together get what there is.
#[must_use]
pub fn uneven(part: usize, targets: usize, split: usize) -> f32 {
    // Targets behind the one that this split favours, which have less of it alike.
    let Some(behind) = targets.checked_sub(split + 1).filter(|it| *it > 0) else {
        return 0.0;
    };
    let favoured = (targets * behind) as f64 / ((targets - 1) * (behind + 1)) as f64;
    match part.cmp(&split) {
        Ordering::Less => 0.0,
        Ordering::Equal => favoured.sqrt() as f32,
        Ordering::Greater => -(favoured.sqrt() / behind as f64) as f32,
    }
}

/// The current that a target gets which gets so much more than its share.
#[inline(always)]
#[must_use]
pub const fn split(share: f32, more: f32) -> f32 {
    share * (1.0 + more)
}

/// What is stored of a current by a cell of this [gain](Errors::gain); the error is its
/// [offset](Errors::offset), what noise and division add. The range limits it.
#[inline(always)]
#[must_use]
pub fn stored<T: Mul<Output = T> + Add<Output = T>>(current: T, gain: T, error: T) -> T {
    gain * current + error
}

/// What every store adds: the transfer error, and the division error where the bus splits.
#[must_use]
pub const fn added(transfer: f64, division: f64, splits: bool) -> f64 {
    if splits {
        transfer + division
    } else {
        transfer
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_of_a_bus_are_alike_and_get_what_there_is() {
        for targets in 2..=11 {
            let splits = 0..targets - 1;
            let more = |part| {
                splits
                    .clone()
                    .map(move |split| uneven(part, targets, split))
            };
            for part in 0..targets {
                let spread: f32 = more(part).map(|it| it * it).sum();
                assert!((spread - 1.0).abs() < 1e-6, "{part} of {targets}: {spread}");
            }
            for split in splits.clone() {
                let sum: f32 = (0..targets).map(|it| uneven(it, targets, split)).sum();
                assert!(sum.abs() < 1e-6, "{split} of {targets}: {sum}");
            }
        }
        assert_eq!([0, 1].map(|part| uneven(part, 2, 0)), [1.0, -1.0]);
        // Nothing is split, and there is no such split.
        assert_eq!([uneven(0, 1, 0), uneven(1, 2, 1)], [0.0; 2]);
    }

    /// Each figure changes the part of the errors that its role says, and no other.
    #[test]
    fn figures_have_the_part_in_errors_that_their_role_says() {
        let device = Device::scamp5();
        let usual = Errors::from_device(&device);
        let of = |role: Role| {
            let store = role.is_of_a_store();
            [store, role == Role::Range, role == Role::Decay]
        };
        for figure in Figure::ALL {
            // Halves may be refused of whole numbers and of limits.
            let value = device.value(*figure);
            let tried = [value / 2.0, value + 0.5, value + 1.0];
            let other = { tried.into_iter().filter(|tried| *tried != value) }
                .find_map(|tried| device.clone().what_if(*figure, tried).ok());
            let Some(other) = other else {
                assert_eq!(figure.role(), Role::None, "{figure}");
                continue;
            };
            let other = Errors::from_device(&other);
            let fades = |errors: &Errors| {
                (
                    errors.reset_level,
                    errors.decay,
                    errors.retention,
                    errors.retention_spread,
                )
            };
            let changes = [
                usual.of_a_store() != other.of_a_store(),
                usual.range != other.range,
                fades(&usual) != fades(&other),
            ];
            assert_eq!(of(figure.role()), changes, "{figure}");
        }
    }

    /// `T = -x + Δ`, `y = -T + Δ = x` without loss.
    #[test]
    fn two_stores_cancel_the_transfer_error() {
        let errors = Errors {
            loss: 0.0,
            ..Errors::from_device(&Device::find("scamp5").unwrap())
        };
        assert!(errors.transfer != 0.0);
        let (gain, offset) = (errors.gain(0.0) as f32, errors.offset(0.0, 0.0) as f32);
        let twice = stored(stored(40.0, gain, offset), gain, offset);
        assert!((twice - 40.0).abs() < 1e-5, "{twice}");
    }
}
