//! The error terms of a chip, each of which can be left out by itself.

use std::fmt;

use crate::{
    config::listed,
    isa::{Errors, Role},
};

listed! {
/// A kind of error of analogue cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ErrorTerm {
    /// The host sets values in steps of its converter.
    Converter = "converter",
    /// Registers have a range.
    Saturation = "saturation",
    /// Every store errs and loses a part, and a bus that splits errs more.
    Transfer = "transfer",
    /// No two cells are alike.
    Mismatch = "mismatch",
    /// Every store is noisy.
    Noise = "noise",
    /// Registers forget.
    Decay = "decay",
}
}

impl ErrorTerm {
    /// The one that a figure of the chip belongs to.
    #[must_use]
    pub const fn of(role: Role) -> Option<Self> {
        match role {
            Role::Systematic => Some(Self::Transfer),
            Role::Mismatch => Some(Self::Mismatch),
            Role::Noise => Some(Self::Noise),
            Role::Range => Some(Self::Saturation),
            Role::Decay => Some(Self::Decay),
            Role::None => None,
        }
    }

    /// The errors without it.
    pub const fn leave_out(self, errors: &mut Errors) {
        match self {
            Self::Converter => errors.input_step = 0.0,
            Self::Saturation => errors.range = (f64::NEG_INFINITY, f64::INFINITY),
            Self::Transfer => {
                (errors.transfer, errors.loss, errors.division) = (0.0, 0.0, 0.0);
            }
            Self::Mismatch => {
                (errors.gain_mismatch, errors.offset_mismatch) = (0.0, 0.0);
                (errors.mismatch_correlation, errors.division_mismatch) = (0.0, 0.0);
            }
            Self::Noise => errors.noise = 0.0,
            Self::Decay => (errors.decay, errors.retention) = (0.0, f64::INFINITY),
        }
    }

    /// What it is called.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Converter => "steps of the converter",
            Self::Saturation => "saturation",
            Self::Transfer => "transfer and division",
            Self::Mismatch => "mismatch",
            Self::Noise => "temporal noise",
            Self::Decay => "decay",
        }
    }
}

impl fmt::Display for ErrorTerm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::isa::{Device, Figure};

    #[test]
    fn without_all_terms_nothing_errs() {
        let mut errors = Errors::from_device(&Device::scamp5());
        for term in ErrorTerm::ALL {
            term.leave_out(&mut errors);
        }
        // A field that is added belongs to a term.
        let Errors {
            transfer,
            loss,
            division,
            gain_mismatch,
            offset_mismatch,
            mismatch_correlation,
            division_mismatch,
            noise,
            input_step,
            range,
            decay,
            retention,
            // Of no effect where the others are 0.
            reset_level: _,
            retention_spread: _,
        } = errors;
        let of_a_store = [transfer, loss, division, noise, input_step, decay];
        let mismatch = [
            gain_mismatch,
            offset_mismatch,
            mismatch_correlation,
            division_mismatch,
        ];
        assert_eq!((of_a_store, mismatch), ([0.0; 6], [0.0; 4]));
        let infinite = f64::INFINITY;
        assert_eq!((range, retention), ((-infinite, infinite), infinite));
    }
    /// What a term leaves out has all figures of its role in it.
    #[test]
    fn each_figure_of_a_store_is_left_out_with_its_term() {
        for figure in Figure::of_a_store() {
            let term = ErrorTerm::of(figure.role()).unwrap();
            let without = [0.5, 0.25].map(|value| {
                let device = Device::scamp5().what_if(figure, value).unwrap();
                let mut errors = Errors::from_device(&device);
                term.leave_out(&mut errors);
                errors
            });
            assert_eq!(without[0], without[1], "{figure} stays without {term}");
        }
    }
}
