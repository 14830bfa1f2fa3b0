//! The table of candidates, and which of them is taken.

use super::{FeasibilityError, Question};
use crate::{
    kernel::quantise::{Quantised, Quantiser},
    scene::{Frame, Scene},
    study::{
        design::{Design, DesignError},
        quantisation::{self, Outcome, Row},
    },
};

/// Two scores that are closer than this are one: then fewer words win.
const ALIKE: f64 = 0.005;

impl Question<'_> {
    /// A row for each candidate, also for those that the kernel is not to be had in.
    pub(super) fn table(
        &self,
        design: &Design<'_>,
        scene: &mut dyn Scene,
        seen: &mut dyn FnMut(&Frame),
    ) -> Result<Vec<Row>, FeasibilityError> {
        let why_not = |to: &Quantiser| design.quantise(*to, self.sum).err();
        let usable: Vec<Quantiser> = self
            .candidates
            .iter()
            .copied()
            .filter(|to| why_not(to).is_none())
            .collect();
        let table = quantisation::Question {
            kernel: self.kernel,
            threshold: self.threshold,
            quantisers: &usable,
            sum: self.sum,
            device: self.device,
            effort: self.effort,
            seed: self.seed,
            within: self.within,
        };
        let mut rows = quantisation::ask(&table, scene, seen)?.rows.into_iter();
        let row = |to: &Quantiser| match why_not(to) {
            None => rows.next(),
            Some(error) => Some(Row {
                to: to.to_string(),
                relative_error: 1.0,
                outcome: Outcome::Refused(error.to_string()),
            }),
        };
        Ok(self.candidates.iter().filter_map(row).collect())
    }

    /// What was asked for; else the candidate that scores best with the chip's errors, of those
    /// that score alike the one with the fewest words; else, where none has a program, the first
    /// that there is.
    pub(super) fn choose(
        &self,
        design: &Design<'_>,
        rows: &[Row],
    ) -> Result<(Quantiser, Quantised), DesignError> {
        let quantised = |to: Quantiser| Ok((to, design.quantise(to, self.sum)?));
        if let Some(to) = self.to {
            return quantised(to);
        }
        let programs = || {
            let both = self.candidates.iter().zip(rows);
            both.filter_map(|(to, row)| match &row.outcome {
                Outcome::OnChip(chip) => Some((*to, chip)),
                Outcome::Refused(_) => None,
            })
        };
        let best = programs()
            .map(|(_, chip)| chip.silicon.f1)
            .fold(0.0, f64::max);
        let alike = programs().filter(|(_, chip)| chip.silicon.f1 > best - ALIKE);
        if let Some((to, _)) = alike.min_by_key(|(_, chip)| chip.words) {
            return quantised(to);
        }
        let mut all = self.candidates.iter().map(|to| quantised(*to));
        let first = all.next().unwrap_or_else(|| quantised(Quantiser::Ternary));
        first.or_else(|error| all.find_map(Result::ok).ok_or(error))
    }
}
