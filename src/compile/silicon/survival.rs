//! The plan of which most comes out of the silicon.
//!
//! The search proposes plans by their words; each is tried as it is and with its constant errors
//! taken out ([`offset_cancellation`](super::offset_cancellation)), and the one whose predicted
//! signal-to-noise ratio ([`forecast`](super::forecast)) is highest is taken, in few more words than
//! the shortest.
//! Where a range of the input is given, each is tried behind as many halvings as it needs, and
//! plans that halve on the way are searched as well. Without one, a filter keeps the kernel's scale
//! where enough of it comes out; else plans that halve on the way are searched there too.
//!
//! Where it is known with what one result is compared, the plan is taken that decides best on the chip
//! ([`selection`](crate::compile::decision::selection)).

use std::sync::Arc;

use super::{
    forecast::{Forecast, Signal, best, forecasts, worst},
    offset_cancellation::{Reads, greedy, room, steadied},
};
use crate::{
    compile::{
        codegen::{filter::Filter, instruction_set::Buses, register_allocation::allocate},
        construction::separable::compose,
        decision::{f1_score::Decided, trial::Compared},
        error::CompileError,
        intermediate::{
            linear_form::LinearForm,
            plan::{Plan, StoreErrors, Word},
        },
        request::{Border, Effort, Objective, Request},
        search::{
            memo::{Found, found},
            solve::{FINE, Problem, Solved, slack},
        },
    },
    isa::{Analog, Figure, Primitive},
    order::Order,
};

/// Plans that are looked at closely.
const CLOSELY: usize = 6;

/// Changes of single words that are tried in all.
const TRIES: usize = 200;

/// The most halvings of an input.
pub(in crate::compile) const HALVINGS: u32 = 14;

/// The most halvings in all, so that weights stay far from overflow.
pub(in crate::compile) const HALVINGS_IN_ALL: u32 = 22;

/// Signal-to-noise ratios within this are equal, dB.
const EQUAL_DB: f64 = 0.25;

/// What is right at the border may cost so much of the signal more than the rim that is lost
/// without, dB.
const DEAR_DB: f64 = 1.0;

/// Below this correlation a plan is worth more words than [`slack`] allows.
const ENOUGH: f64 = 0.95;

/// What a run at the best amplitude may fall short of its prediction by.
const UNSURE: f64 = 0.004;

/// A request as the choice sees it.
pub(in crate::compile) struct Choice<'a> {
    pub(in crate::compile) request: &'a Request<'a>,
    pub(super) goals: &'a [LinearForm],
    pub(super) unit: i64,
    pub(in crate::compile) all: &'a [Analog],
    pub(in crate::compile) effort: Effort,
    /// Whether nothing may saturate with the chip's errors either, where nothing may without.
    pub(super) strict: bool,
}

/// A plan with its registers and what is predicted of it.
#[derive(Clone)]
pub(in crate::compile) struct Candidate {
    pub(in crate::compile) solved: Solved,
    /// The plan before its constant errors were taken out.
    plain: Plan,
    reads: Reads,
    /// Halvings of the input in it.
    pub(in crate::compile) bits: u32,
    forecasts: Vec<Forecast>,
    pub(in crate::compile) decided: Option<Decided>,
}

impl Candidate {
    pub(in crate::compile) fn words(&self) -> usize {
        self.solved.allocated.words.len()
    }

    fn correlation(&self) -> f64 {
        worst(&self.forecasts)
    }

    /// Steps of signal-to-noise ratio.
    fn quality(&self) -> i64 {
        steps_of_db(self.signal(0.0))
    }

    /// The least signal-to-noise ratio, in decibels, where in a part of the cells nothing of the
    /// signal is right.
    fn signal(&self, lost: f64) -> f64 {
        let all = self.forecasts.iter();
        all.map(|forecast| forecast.snr_db_without(lost))
            .fold(90.0, f64::min)
    }
}

impl Request<'_> {
    /// What comes out of a filter, in steps of what is told apart: of its events where it is known with
    /// what it is compared, else of its signal-to-noise ratio.
    pub(in crate::compile) fn quality(&self, filter: &Filter) -> [i64; 2] {
        if let Some(decided) = filter.decided {
            return decided.steps();
        }
        let all = self.predicted(&filter.words, None).into_iter();
        let least = all.map(|forecast| forecast.snr_db()).fold(90.0, f64::min);
        [steps_of_db(least), 0]
    }

    /// The forecasts at the amplitude given, that of the range, or the best.
    fn predicted(&self, words: &[Primitive], amplitude: Option<f64>) -> Vec<Forecast> {
        let at = |signal| {
            let mut all = forecasts(
                words,
                self.device,
                (self.input, &self.into),
                self.kernels,
                signal,
            );
            if self.zero_counts {
                for forecast in &mut all {
                    forecast.count_offset();
                }
            }
            all
        };
        if let Some(range) = self.range {
            return at(Signal::from_range(range));
        }
        if let Some(amplitude) = amplitude {
            return at(Signal::around_zero(amplitude));
        }
        best(at)
    }
}

impl<'a> Choice<'a> {
    /// Of these registers, with this effort; nothing may saturate.
    pub(in crate::compile) const fn new(
        request: &'a Request<'a>,
        goals: &'a [LinearForm],
        unit: i64,
        (all, effort): (&'a [Analog], Effort),
    ) -> Self {
        Self {
            request,
            goals,
            unit,
            all,
            effort,
            strict: true,
        }
    }

    /// The same, where nothing may saturate without the chip's errors, whatever does with them.
    pub(in crate::compile) const fn lenient(&self) -> Self {
        Self {
            strict: false,
            ..*self
        }
    }

    /// The filter that decides best on the chip, whatever saturates, where its threshold can be set; of
    /// a request for events on silicon.
    fn whatever_saturates(&self) -> Result<Option<Filter>, CompileError> {
        let (Some(range), Some(decision), [_], Objective::Silicon) = (
            self.request.range,
            self.request.decision,
            self.goals,
            self.request.objective,
        ) else {
            return Ok(None);
        };
        let request = Request {
            objective: Objective::Events,
            ..self.request.clone()
        };
        let anyhow = Choice {
            request: &request,
            ..*self
        };
        let found = anyhow.deciding(range, decision)?;
        Ok(found.filter(|it| request.sets_threshold(it.prescale)))
    }

    /// The filter of which most comes out.
    pub(in crate::compile) fn filter(&self) -> Result<Filter, CompileError> {
        if let (Some(range), Some(decision), [_]) =
            (self.request.range, self.request.decision, self.goals)
        {
            let decides = match self.request.objective {
                Objective::Silicon | Objective::Events => self.deciding(range, decision)?,
                Objective::Exact if decision.compared == Compared::Drives => {
                    self.deciding(range, decision)?
                }
                Objective::Exact | Objective::Words => None,
            };
            if let Some(filter) = decides {
                return Ok(filter);
            }
        }
        let (candidates, seen) = self.candidates()?;
        let best = self.best(candidates);
        // Where nothing stays in range with the errors: what does without them.
        let best = match (best, self.request.range) {
            (None, Some(range)) => {
                let lenient = self.lenient();
                lenient.best(lenient.within(range)?.0)
            }
            (best, _) => best,
        };
        let Some(best) = best else {
            return self
                .request
                .shortest(self.goals, self.unit, (self.all, self.effort));
        };
        if !self.request.sets_threshold(best.bits) {
            // The plan of the fewest words may need fewer halvings.
            let file = (self.all, self.effort);
            let other = self.request.shortest(self.goals, self.unit, file)?;
            if self.request.sets_threshold(other.prescale) {
                return Ok(other);
            }
            if let Some(filter) = self.whatever_saturates()? {
                return Ok(filter);
            }
        }
        if best.correlation() < Forecast::NOTHING && self.goals.iter().any(|goal| !goal.is_zero()) {
            let first = best.forecasts.first().copied().unwrap_or_default();
            return Err(CompileError::Nothing {
                correlation: best.correlation(),
                offset: first.offset,
                noise: first.noise,
            });
        }
        Ok(self.built(best, seen))
    }

    /// The shortest of the candidates.
    pub(in crate::compile) fn shortest(&self) -> Result<Option<Filter>, CompileError> {
        let (mut all, seen) = self.candidates()?;
        self.keep_usable(&mut all);
        let shortest = all.into_iter().min_by_key(|c| (c.words(), -c.quality()));
        Ok(shortest.map(|candidate| self.built(candidate, seen)))
    }

    /// Keeps the candidates that are right at the border, if that is asked and does not cost more than
    /// the border is worth, and those whose threshold can be set; where it is too low for all of them,
    /// those of the fewest halvings.
    pub(in crate::compile) fn keep_usable(&self, all: &mut Vec<Candidate>) {
        let most = |border: bool, rim: f64| {
            let own = all.iter().filter(|c| c.solved.border == border);
            own.map(|c| c.signal(rim)).max_by(f64::total_cmp)
        };
        if self.request.border != Border::Any
            && let Some(right) = most(true, 0.0)
        {
            let rim = self.rim();
            let is_free =
                self.request.border == Border::Right || self.request.objective == Objective::Exact;
            let is_dear = !is_free && most(false, rim).is_some_and(|other| other > right + DEAR_DB);
            all.retain(|c| c.solved.border != is_dear);
        }
        if all.iter().any(|c| self.request.sets_threshold(c.bits)) {
            all.retain(|c| self.request.sets_threshold(c.bits));
            return;
        }
        // Where all of them lose it, what loses the least of it.
        let in_range = |c: &&Candidate| !self.request.is_beyond_converter(c.bits);
        if let Some(least) = all.iter().filter(in_range).map(|c| c.bits).min() {
            all.retain(|c| c.bits == least);
        }
    }

    /// The part of the chip's cells that a filter of this reach reads beyond the border from.
    pub(in crate::compile) fn rim(&self) -> f64 {
        let inner = |side: Figure| {
            let side = self.request.device.value(side);
            (side - 2.0 * self.reach() as f64).max(0.0) / side
        };
        1.0 - inner(Figure::Height) * inner(Figure::Width)
    }

    /// How far from a pixel the farthest weight lies, in pixels.
    pub(in crate::compile) fn reach(&self) -> usize {
        let taps = self.goals.iter().flat_map(LinearForm::taps);
        let reach = taps.map(|tap| tap.y.unsigned_abs().max(tap.x.unsigned_abs()));
        usize::from(reach.max().unwrap_or(0))
    }

    /// Filters none of which is worse in words and in signal than another.
    pub(in crate::compile) fn front(&self) -> Result<Vec<Filter>, CompileError> {
        let (mut all, seen) = self.candidates()?;
        self.keep_usable(&mut all);
        all.extend(self.best(all.clone()));
        all.order_by_key(|c| (c.words(), -c.quality()));
        let mut front: Vec<Candidate> = Vec::new();
        for candidate in all {
            let better = |last: &Candidate| last.quality() < candidate.quality();
            if front.last().is_none_or(better) {
                front.push(candidate);
            }
        }
        Ok(front.into_iter().map(|c| self.built(c, seen)).collect())
    }

    /// A candidate as a filter.
    pub(in crate::compile) fn built(&self, best: Candidate, seen: u64) -> Filter {
        let solved = Solved {
            seen,
            ..best.solved
        };
        let request = self.request;
        let filter = Filter::from_solved(
            (request.device, request.input, &request.into),
            (request.range, request.compares_differences()),
            &solved,
            self.unit << best.bits,
            best.bits,
            Vec::new(),
        );
        Filter {
            decided: best.decided,
            ..filter
        }
    }

    /// The candidates, and how many states were looked at for them. One scale is free where signal is
    /// sought: where too little comes out of those that have the kernel's, others halve on the way.
    fn candidates(&self) -> Result<(Vec<Candidate>, u64), CompileError> {
        let (mut all, mut seen) = match self.request.range {
            None => self.anywhere()?,
            Some(range) => self.within(range)?,
        };
        if self.request.objective != Objective::Exact
            && let Some(bits) = self.below_two()
            && !self.survives(&all)
        {
            for plan in self.beside((false, bits), 8, &mut seen).iter() {
                all.extend(match self.request.range {
                    None => self.as_it_is(plan, bits),
                    Some(range) => self.halved(plan, (false, bits), range).0,
                });
            }
        }
        Ok((all, seen))
    }

    /// Halvings that leave the largest weight below 2, so that its first digit is the input itself:
    /// there plans are the shortest, and no sum is larger than it must be.
    fn below_two(&self) -> Option<u32> {
        let taps = self.goals.iter().flat_map(LinearForm::taps);
        let largest = taps.map(|tap| tap.weight.unsigned_abs()).max()?;
        let bits = (largest / self.unit.unsigned_abs()).checked_ilog2();
        bits.filter(|bits| *bits > 0)
    }

    /// Whether enough is sure to come out of one of those that are hardly longer than the shortest.
    fn survives(&self, all: &[Candidate]) -> bool {
        let mut usable = all.to_vec();
        self.keep_usable(&mut usable);
        let shortest = usable.iter().map(Candidate::words).min().unwrap_or(0);
        let cap = shortest + slack(shortest);
        let enough = |c: &Candidate| c.words() <= cap && c.correlation() >= ENOUGH + UNSURE;
        usable.iter().any(enough) || self.best_of(&usable, cap).is_some_and(|best| enough(&best))
    }

    /// Candidates for an input of any amplitude.
    fn anywhere(&self) -> Result<(Vec<Candidate>, u64), CompileError> {
        let (mut out, mut seen) = (Vec::new(), 0);
        for plan in self.searched((false, 0), 8, &mut seen)?.iter() {
            out.extend(self.as_it_is(plan, 0));
        }
        Ok((out, seen))
    }

    /// A plan that halves `bits` times, and the same with its constant errors taken out.
    fn as_it_is(&self, plan: &Plan, bits: u32) -> Vec<Candidate> {
        let problem = self.problem(bits, Effort::states(0));
        let reads = [Reads::new(), greedy(plan, self.request.store_errors())];
        let tried = reads
            .iter()
            .filter_map(|reads| self.tried(&problem, plan, reads, bits));
        tried.collect()
    }

    /// Candidates for an input in a range: none of them saturates.
    fn within(&self, range: (f64, f64)) -> Result<(Vec<Candidate>, u64), CompileError> {
        let (mut out, mut seen) = (Vec::new(), 0);
        let mut odd = false;
        for plan in self.searched((false, 0), 4, &mut seen)?.iter() {
            let (found, less) = self.halved(plan, (false, 0), range);
            out.extend(found);
            odd |= less;
        }
        if odd {
            for plan in self.beside((true, 0), 3, &mut seen).iter() {
                out.extend(self.halved(plan, (true, 0), range).0);
            }
        }
        if let Some(inner) = self.inner() {
            for plan in self.beside((false, inner), 2, &mut seen).iter() {
                out.extend(self.halved(plan, (false, inner), range).0);
            }
        }
        Ok((out, seen))
    }

    /// Halvings wherever the search finds them cheap: as many as make a result as large as the
    /// input.
    pub(in crate::compile) fn inner(&self) -> Option<u32> {
        let size = |goal: &LinearForm| goal.bounds(-1.0, 1.0).1;
        let largest = self.goals.iter().map(size).fold(0.0, f64::max) / self.unit as f64;
        let inner = (0..HALVINGS).find(|bits| largest <= f64::from(1 << *bits));
        inner.filter(|inner| *inner > 0)
    }

    /// The shorter plans of the goals, negated or halved `inner` times, found with so many eighths
    /// of the effort.
    pub(in crate::compile) fn searched(
        &self,
        (negated, inner): (bool, u32),
        eighths: u64,
        seen: &mut u64,
    ) -> Result<Arc<[Plan]>, CompileError> {
        let effort = self
            .effort
            .with_states(self.effort.states.saturating_mul(eighths) / 8);
        let mut problem = self.problem(inner, effort);
        if negated {
            problem.goals = self.goals.iter().map(|goal| goal.times(-1)).collect();
        }
        let found = found(problem, |problem| {
            let (best, all) = problem.solve_all();
            // What was given up is not kept.
            if problem.stop.is_asked() {
                return None;
            }
            Some(Found {
                seen: best?.seen,
                plans: self
                    .short(all)
                    .into_iter()
                    .map(|solved| solved.plan)
                    .collect(),
            })
        });
        let found = found.ok_or_else(|| self.none_found())?;
        *seen += found.seen;
        Ok(found.plans)
    }

    /// The shorter plans that the chip stores, each once: those first that are right at the border, and
    /// beside them some of the others, which may be shorter by far.
    fn short(&self, mut all: Vec<Solved>) -> Vec<Solved> {
        let words = |solved: &Solved| solved.allocated.words.len();
        let store = self.request.device.value(Figure::Store) as usize;
        all.retain(|solved| words(solved) <= store);
        all.order_by_key(|solved| (!solved.border, words(solved)));
        all.dedup_by(|a, b| a.plan == b.plan);
        let fewest = all.iter().map(words).min();
        let most = fewest.map_or(0, |words| 2 * words + 8);
        all.retain(|solved| words(solved) <= most);
        let mut rest = all.split_off(all.len().min(3 * CLOSELY));
        let kept = all.iter().filter(|solved| !solved.border).count();
        rest.retain(|solved| !solved.border);
        rest.truncate(CLOSELY.saturating_sub(kept));
        all.extend(rest);
        all
    }

    /// The plans of a search that is made beside the one for the goals as they are: none where the
    /// chip cannot halve, which they all do.
    pub(in crate::compile) fn beside(
        &self,
        asked: (bool, u32),
        eighths: u64,
        seen: &mut u64,
    ) -> Arc<[Plan]> {
        if !Buses::from_device(self.request.device).split() {
            return Arc::default();
        }
        self.searched(asked, eighths, seen).unwrap_or_default()
    }

    /// That no plan was found.
    pub(in crate::compile) fn none_found(&self) -> CompileError {
        self.request.none_found(self.goals.len(), self.all.len())
    }

    /// The search for the goals, `bits` times halved.
    pub(in crate::compile) fn problem(&self, bits: u32, effort: Effort) -> Problem {
        let request = self.request;
        let file = (request.input, self.all, effort);
        let limits = request.range.map(|range| request.limits(range));
        request.problem(self.goals, self.unit << bits, file, limits)
    }

    /// A plan behind the fewest halvings with which nothing saturates, as it is and with its
    /// constant errors taken out. And whether one halving less would do. `negated`: a plan of the
    /// negated goals, for which the number is odd; `inner`: halvings in the plan itself.
    pub(in crate::compile) fn halved(
        &self,
        plan: &Plan,
        (negated, inner): (bool, u32),
        range: (f64, f64),
    ) -> (Vec<Candidate>, bool) {
        let registers = self.all.len();
        let variants = |bits: u32| {
            let whole = compose(&halvings(bits), plan)?;
            let reads = greedy(&whole, self.request.store_errors());
            let steady = steadied(&whole, &reads, registers);
            let mut all = vec![(Reads::new(), whole.clone())];
            all.extend(steady.map(|steady| (reads, steady)));
            let bits = inner + bits;
            all.retain(|(_, plan)| {
                !self.request.is_beyond_converter(bits) && self.fits(plan, bits, range)
            });
            Some((whole, all))
        };
        let most = HALVINGS.min(HALVINGS_IN_ALL - inner);
        for bits in (u32::from(negated)..most).step_by(2) {
            let Some((whole, fitting)) = variants(bits) else {
                continue;
            };
            let bits_in_all = inner + bits;
            let problem = self.problem(bits_in_all, Effort::states(0));
            let tried = fitting
                .iter()
                .filter_map(|(reads, _)| self.tried(&problem, &whole, reads, bits_in_all));
            let out: Vec<Candidate> = tried.collect();
            if !out.is_empty() {
                let less = bits > 0 && variants(bits - 1).is_some_and(|(_, all)| !all.is_empty());
                return (out, less);
            }
        }
        (Vec::new(), false)
    }

    /// Whether nothing saturates, with the errors and without.
    pub(in crate::compile) fn fits(&self, plan: &Plan, bits: u32, range: (f64, f64)) -> bool {
        let unit = self.unit << bits;
        let Some(trace) = unit.checked_mul(FINE).and_then(|_| plan.trace(unit * FINE)) else {
            return false;
        };
        let mut limits = self.request.limits(range);
        if !self.strict {
            limits.errors = StoreErrors::default();
        }
        limits.fits(plan, &trace, unit)
    }

    /// A plan with registers, and what is predicted of it.
    pub(in crate::compile) fn tried(
        &self,
        problem: &Problem,
        plain: &Plan,
        reads: &Reads,
        bits: u32,
    ) -> Option<Candidate> {
        let steady = steadied(plain, reads, self.all.len());
        if steady.is_none() && !reads.is_empty() {
            return None;
        }
        let solved = problem.finish(steady.unwrap_or_else(|| plain.clone()))?;
        let forecasts = self.request.predicted(&solved.allocated.words, None);
        Some(Candidate {
            plain: plain.clone(),
            reads: reads.clone(),
            bits,
            forecasts,
            decided: None,
            solved: Solved {
                holds: true,
                ..solved
            },
        })
    }

    /// The best of the candidates, after each of the most promising was improved word by word.
    pub(in crate::compile) fn best(&self, mut all: Vec<Candidate>) -> Option<Candidate> {
        self.keep_usable(&mut all);
        let shortest = all.iter().map(Candidate::words).min()?;
        for cap in [shortest + slack(shortest), 2 * shortest + 8, usize::MAX] {
            let best = self.best_of(&all, cap);
            if best.as_ref().is_some_and(|c| c.correlation() >= ENOUGH) || cap == usize::MAX {
                return best;
            }
        }
        None
    }

    /// The same of those of at most so many words.
    fn best_of(&self, all: &[Candidate], cap: usize) -> Option<Candidate> {
        let mut own: Vec<Candidate> = { all.iter().filter(|c| c.words() <= cap) }
            .cloned()
            .collect();
        own.order_by_key(|c| (-c.quality(), c.words()));
        own.truncate(CLOSELY);
        let mut left = TRIES;
        let improved = own
            .into_iter()
            .map(|c| self.improved(c, cap, &mut left))
            .collect::<Vec<_>>()
            .into_iter();
        improved.min_by_key(|c| (-c.quality(), c.words()))
    }

    /// Single words made to read the constant or not, as long as that helps.
    fn improved(&self, mut best: Candidate, cap: usize, left: &mut usize) -> Candidate {
        let first = best.clone();
        let words = best.plain.words.len();
        best.reads.resize(words, false);
        let problem = self.problem(best.bits, Effort::states(0));
        for _ in 0..2 {
            let mut better = false;
            for at in 0..words {
                if *left == 0 || !best.plain.words.get(at).is_some_and(room) {
                    continue;
                }
                *left -= 1;
                let mut reads = best.reads.clone();
                reads[at] = !reads[at];
                let steady = steadied(&best.plain, &reads, self.all.len());
                let plan = steady.unwrap_or_else(|| best.plain.clone());
                if let Some(range) = self.request.range
                    && !self.fits(&plan, best.bits, range)
                {
                    continue;
                }
                if plan.words.len() > cap {
                    continue;
                }
                let Some(allocated) = allocate(&plan, &problem.registers) else {
                    continue;
                };
                let solved = Solved {
                    plan,
                    allocated,
                    ..best.solved.clone()
                };
                let amplitude = best.forecasts.first().map(|f| f.amplitude);
                let forecasts = self.request.predicted(&solved.allocated.words, amplitude);
                let next = Candidate {
                    solved,
                    plain: best.plain.clone(),
                    reads,
                    bits: best.bits,
                    forecasts,
                    decided: None,
                };
                if (-next.quality(), next.words()) < (-best.quality(), best.words()) {
                    best = next;
                    better = true;
                }
            }
            if !better {
                break;
            }
            best.forecasts = self.request.predicted(&best.solved.allocated.words, None);
        }
        // Verified once more, by its trace.
        match problem.finish(best.solved.plan.clone()) {
            Some(_) => best,
            None => first,
        }
    }
}

/// Signal-to-noise ratio in steps of [`EQUAL_DB`].
fn steps_of_db(db: f64) -> i64 {
    (db / EQUAL_DB).round() as i64
}

/// Halvings of the input, one after the other.
pub(in crate::compile) fn halvings(bits: u32) -> Plan {
    let half = |value| Word::register(vec![value], true);
    Plan {
        words: (0..bits as usize).map(half).collect(),
        goals: vec![bits as usize],
    }
}
