//! The search over numbers of registers: a chip with more of them is never given a longer program.
//!
//! A search with more registers looks at other states, and may come out worse than one with fewer.
//! With the words as the objective, what every smaller number of registers gives is therefore
//! tried as well, with an effort that depends on that number alone: a chip is then given the best
//! of all that its smaller sisters are given, and of a search of its own. Where the best has as few
//! words as any program can have ([`bound`](super::bound)), no more is tried.
//!
//! What comes out of the chip is found by one search of the whole effort. For a filter alone others
//! follow, in all numbers of registers but the fewest, where a search is short: what they give is
//! taken where it has fewer words and no less comes out of it. On chips of fewer registers all smaller
//! numbers are tried, the fewest with a part of the effort. The words as the objective are sought with
//! the same effort in each number, so that who asks for the fewest gets no more than who does not.

use super::bound::LowerBound;
use crate::{
    compile::{
        codegen::{
            filter::Filter, instruction_set::check_words, register_allocation::ordinary_registers,
        },
        construction::walk::FEWEST_REGISTERS,
        error::CompileError,
        request::{Border, Effort, Objective, Request},
    },
    isa::Analog,
    order::Order,
};

/// The registers of the narrowest shipped chip: the search that has the whole effort.
const USUAL: usize = 6;

/// The most registers that a search is given.
const MOST: usize = 12;

/// What fewer words come after: whether it is right at the border where that is asked, whether
/// nothing saturates, and whether its threshold can be set.
pub(super) type Key = (bool, bool, bool, usize, u32);

impl Request<'_> {
    /// Searches for the filter.
    ///
    /// # Errors
    /// When a field cannot be, a weight is not dyadic, or the registers do not suffice.
    pub fn filter(&self) -> Result<Filter, CompileError> {
        self.check()?;
        let is_narrow = ordinary_registers(self.device).len() < USUAL;
        let all = self.free_registers();
        let pinned = |r: &&Analog| **r == self.input || self.into.contains(*r);
        let fewest = all.iter().filter(pinned).count().max(1);
        let usual = all.len().min(USUAL);
        let mut levels = vec![usual];
        match self.objective {
            Objective::Words => {
                levels.extend((fewest..usual).rev());
                levels.extend(usual + 1..=all.len().min(MOST));
            }
            // The fewest words are not what is sought: of a wider chip's two the shorter is taken.
            Objective::Silicon | Objective::Events | Objective::Exact => {
                let least = match self.border {
                    _ if is_narrow => fewest,
                    Border::Any => fewest.max(FEWEST_REGISTERS + 1),
                    // Programs, whose memories leave fewer.
                    Border::Worth | Border::Right => usual,
                };
                levels.extend((least..usual).rev());
                levels.extend((all.len() > USUAL).then(|| all.len().min(MOST)));
            }
        }
        let mut best: Option<Filter> = None;
        let mut states = 0;
        let mut failed = None;
        for count in levels {
            let better = |new: &Filter| {
                best.as_ref().is_none_or(|old| {
                    if self.objective == Objective::Words || count > usual {
                        self.key(new) < self.key(old)
                    } else {
                        self.is_as_good(new, old)
                    }
                })
            };
            // Where fewer do not suffice, the first that do have the whole effort.
            let effort = match &best {
                None if count > USUAL => self.effort,
                // In the registers that memories leave, one search has the whole effort.
                _ if count == usual && !is_narrow && self.objective != Objective::Words => {
                    self.effort
                }
                _ => self.share(count),
            };
            match self.filter_in(&all[..count], effort) {
                Ok(filter) => {
                    states += filter.states;
                    if better(&filter) {
                        best = Some(filter);
                    }
                }
                Err(error) if failed.is_none() || count == all.len() => failed = Some(error),
                Err(_) => {}
            }
            if self.objective == Objective::Words
                && best.as_ref().is_some_and(|it| self.is_least(it))
            {
                break;
            }
        }
        if self.effort.stop.is_asked() {
            return Err(CompileError::GivenUp);
        }
        match (best, failed) {
            (Some(best), _) => {
                check_words(&best.text(self.device, 0), self.device)?;
                Ok(Filter { states, ..best })
            }
            (None, Some(error)) => Err(error),
            (None, None) => Err(self.none_found(self.into.len(), all.len())),
        }
    }

    /// The filter of a whole program. In the few registers that its memories leave, a search for signal
    /// has more of the effort than one for the fewest words, and may know a shorter plan in which
    /// nothing saturates either.
    pub(in crate::compile) fn filter_of_program(&self) -> Result<Filter, CompileError> {
        let own = self.filter()?;
        if self.objective != Objective::Words || self.effort.states == 0 {
            return Ok(own);
        }
        let exact = Self {
            objective: Objective::Exact,
            ..self.clone()
        };
        Ok(match exact.filter() {
            Ok(other) => self.shorter(own, other),
            Err(_) => own,
        })
    }

    /// The registers that may be used; those that cannot be chosen come first.
    pub(in crate::compile) fn free_registers(&self) -> Vec<Analog> {
        let mut all = ordinary_registers(self.device);
        all.retain(|register| !self.keep.contains(register));
        all.order_by_key(|r| *r != self.input && !self.into.contains(r));
        all
    }

    /// The effort of one of several searches, in so many registers, the same on every chip. A search in
    /// few registers refuses most of what it makes, which takes time and is not counted.
    fn share(&self, registers: usize) -> Effort {
        let part = match registers {
            ..FEWEST_REGISTERS => 32,
            FEWEST_REGISTERS => 2,
            MOST.. => 5,
            _ if registers <= USUAL => 1,
            // The plans that need no search.
            _ => return self.effort.with_states(0),
        };
        self.effort.with_states(self.effort.states / part)
    }

    /// Whether a filter is shorter than another, and no worse in what comes out of it.
    fn is_as_good(&self, new: &Filter, old: &Filter) -> bool {
        if new.words.len() >= old.words.len() || new.decided.is_some() != old.decided.is_some() {
            return false;
        }
        let [(border, holds, unset, ..), before] = [new, old].map(|it| self.key(it));
        let is_sound = border <= before.0 && holds <= before.1 && unset <= before.2;
        let [new, old] = [new, old].map(|it| self.quality(it));
        is_sound && new[0] >= old[0] && new[1] >= old[1]
    }

    pub(in crate::compile) fn key(&self, filter: &Filter) -> Key {
        (
            self.border != Border::Any && !filter.border,
            !filter.holds,
            !self.sets_threshold(filter.prescale),
            filter.words.len(),
            filter.prescale,
        )
    }

    /// Whether no program can be preferred to this one.
    pub(in crate::compile) fn is_least(&self, filter: &Filter) -> bool {
        let (is_short_of_border, is_beyond_range, is_unset, words, bits) = self.key(filter);
        let is_sound = !is_short_of_border && !is_beyond_range && !is_unset && bits == 0;
        is_sound && words <= usize::from(LowerBound::new(self.kernels).words)
    }
}
