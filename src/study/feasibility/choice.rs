//! The table of candidates, and which of them is taken.

use super::{FeasibilityError, Question};
use crate::{
    event::Packet,
    kernel::quantise::{Quantised, Quantiser},
    scene::{Frame, Reopen},
    study::{
        design::{Design, DesignError},
        equivalent::Likeness,
        quantisation::{self, Outcome, Ran, Row},
    },
};

/// F1 of candidates closer than this are a tie: then fewer words win.
pub const ALIKE: f64 = 0.005;

/// The table of candidates.
pub(super) struct Table {
    /// A row for each.
    pub rows: Vec<(Quantiser, Row)>,
    /// What the float sensors said that all were judged by: the reference, and the ladder's.
    pub floats: Vec<Packet>,
    /// The program of each row that has one, and what it said.
    ran: Vec<Option<Ran>>,
}

impl Table {
    /// The program of these few values, which has run; or why there is none.
    pub fn take(&mut self, to: Quantiser) -> Result<Ran, String> {
        let none = || format!("{to} was not tried");
        let at = self.rows.iter().position(|(own, _)| *own == to);
        let at = at.ok_or_else(none)?;
        match (self.ran[at].take(), &self.rows[at].1.outcome) {
            (Some(ran), _) => Ok(ran),
            (None, Outcome::Refused(why)) => Err(why.clone()),
            (None, Outcome::OnChip(_)) => Err(none()),
        }
    }

    /// How well it was judged to do, in exact arithmetic and as silicon.
    pub fn judged(&self, to: Quantiser) -> Option<[Likeness; 2]> {
        let row = self.rows.iter().find(|(own, _)| *own == to);
        match &row?.1.outcome {
            Outcome::OnChip(chip) => Some([chip.exact, chip.silicon]),
            Outcome::Refused(_) => None,
        }
    }
}

impl Question<'_> {
    /// What was asked for, else the first candidate that the kernel is to be had in.
    ///
    /// # Errors
    /// When there is none.
    pub(super) fn first(&self, design: &Design<'_>) -> Result<Few, DesignError> {
        let few = |to: Quantiser| Few::new(to, self, design);
        if let Some(to) = self.to {
            return few(to);
        }
        let mut all = self.candidates.iter().map(|to| few(*to));
        let first = all.next().unwrap_or_else(|| few(Quantiser::TERNARY));
        first.or_else(|error| all.find_map(Result::ok).ok_or(error))
    }

    /// A row for each candidate and for what was asked for, also for those that the kernel is
    /// not to be had in.
    pub(super) fn table(
        &self,
        open: &Reopen<'_>,
        seen: &mut dyn FnMut(&Frame),
    ) -> Result<Table, FeasibilityError> {
        let mut all = self.candidates.to_vec();
        all.extend(self.to.filter(|to| !all.contains(to)));
        if all.is_empty() {
            all.push(Quantiser::TERNARY);
        }
        let table = quantisation::Question {
            design: self.design(),
            quantisers: &all,
            sum: self.sum,
            within: self.within,
        };
        let (answer, kept) = quantisation::ask_keeping(&table, open, seen)?;
        Ok(Table {
            rows: all.into_iter().zip(answer.rows).collect(),
            floats: kept.floats,
            ran: kept.ran,
        })
    }

    /// The row that keeps most with the chip's errors, of those that score alike the one with
    /// the fewest words; none where no row has a program.
    #[must_use]
    pub fn best(rows: &[(Quantiser, Row)]) -> Option<Quantiser> {
        let programs = || {
            rows.iter().filter_map(|(to, row)| match &row.outcome {
                Outcome::OnChip(chip) => Some((*to, chip)),
                Outcome::Refused(_) => None,
            })
        };
        // What is kept rises with F1, and F1 tells rows apart also where chance scores 1.
        let f1 = programs().map(|(_, chip)| chip.silicon.f1);
        let best = f1.fold(0.0, f64::max);
        let alike = programs().filter(|(_, chip)| chip.silicon.f1 > best - ALIKE);
        alike.min_by_key(|(_, chip)| chip.words).map(|(to, _)| to)
    }
}

/// The kernel in few values.
pub(super) struct Few {
    pub to: Quantiser,
    pub quantised: Quantised,
}

impl Few {
    pub fn new(
        to: Quantiser,
        question: &Question<'_>,
        design: &Design<'_>,
    ) -> Result<Self, DesignError> {
        let quantised = design.quantise(to, question.sum)?;
        Ok(Self { to, quantised })
    }
}
