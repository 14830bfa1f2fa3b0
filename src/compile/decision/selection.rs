//! The plan that decides best on the chip, where it is known with what its result is compared.
//!
//! A result that is halved until nothing saturates for any input leaves thresholds that are hardly
//! above what cells differ by. What saturates is far above its threshold, so that it decides as it
//! should, but where a partial sum does, or where it is compared with an earlier one and both are at
//! the end of the range. So each plan is tried behind every number of halvings up to that, with as
//! little of a constant in its result as its words and a few more can leave, and all are tried on the
//! same light ([`trial`](super::trial)). Unless events on the chip are all that counts, a plan
//! must keep nearly all of them in exact arithmetic, of every kind of light.

use rayon::prelude::*;

use super::{
    f1_score::Decided,
    trial::{Compared, Decision, Trials},
};
use crate::{
    compile::{
        codegen::filter::Filter,
        construction::separable::compose,
        error::CompileError,
        intermediate::plan::Plan,
        request::{Border, Effort, Objective},
        search::solve::Problem,
        silicon::{
            border_offset::Rim,
            offset_cancellation::{Reads, balanced, steadied, trimmed},
            survival::{Candidate, Choice, HALVINGS, HALVINGS_IN_ALL, halvings},
        },
    },
    elementary,
    isa::Figure,
};

/// What a plan keeps at least in exact arithmetic, as F1, of the kind of light that suits it least.
const EXACT_F1: f64 = 0.985;

/// A threshold that is well above what cells differ by, LSB.
const THRESHOLD: f64 = 32.0;

/// No more halvings are tried below this threshold, LSB.
const LOWEST_THRESHOLD: f64 = 1.0;

/// The part of the effort that a search has, in eighths.
const EIGHTHS: u64 = 2;

impl Choice<'_> {
    /// The filter of one goal that decides best. `None` where events in exact arithmetic count as
    /// well and no plan keeps enough of them: of weights of many digits, nothing may be in range.
    pub(in crate::compile) fn deciding(
        &self,
        range: (f64, f64),
        decision: Decision,
    ) -> Result<Option<Filter>, CompileError> {
        let request = self.request;
        let mut seen = 0;
        let least = decision.on.min(decision.off).max(LOWEST_THRESHOLD);
        let mut searches = vec![(false, 0), (true, 0)];
        searches.extend(self.inner().map(|inner| (false, inner)));
        // Halvings wherever they are cheap, as many as the threshold allows.
        let inner = elementary::log2(least / THRESHOLD).floor().max(0.0) as u32;
        searches.push((false, inner.min(HALVINGS)));
        searches.sort_unstable();
        searches.dedup();
        // What exact arithmetic says counts as well, so that plans in range are sought as for it.
        let in_range = decision.compared == Compared::Drives;
        let (mut all, mut fitting) = (Vec::new(), Vec::new());
        for asked in searches {
            let eighths = match asked {
                (false, 0) if in_range => 2 * EIGHTHS,
                _ => EIGHTHS,
            };
            let plans = match asked {
                (false, 0) => self.searched(asked, eighths, &mut seen)?,
                _ => self.beside(asked, eighths, &mut seen),
            };
            for plan in plans.iter() {
                if in_range {
                    fitting.extend(self.halved(plan, asked, range).0);
                }
                all.extend(self.scaled(plan, asked, range, (least, decision.compared)));
            }
        }
        all.extend(self.best(fitting));
        if request.objective == Objective::Exact {
            self.keep_in_range(&mut all, range);
        }
        self.keep_usable(&mut all);
        let (Some(result), Some(kernel)) = (request.into.first(), request.kernels.first()) else {
            return Err(self.none_found());
        };
        let trials = Trials::new(request.device, range.1.max(-range.0), decision.compared);
        let truth = trials.truth(kernel, decision);
        let lost = match all.first() {
            Some(first) if request.border != Border::Any && !first.solved.border => self.rim(),
            _ => 0.0,
        };
        let least = match (request.objective, decision.compared) {
            (Objective::Silicon, Compared::Drives) => EXACT_F1 - lost,
            _ => 0.0,
        };
        let decided = |candidate: &Candidate| {
            if self.effort.stop.is_asked() {
                return None;
            }
            let scale = 2f64.powi(-(candidate.bits as i32));
            trials.decided(
                &candidate.solved.allocated.words,
                request.device,
                (request.input, *result),
                (decision, scale),
                (&truth, least),
            )
        };
        let judged: Vec<Option<Decided>> = all.par_iter().map(decided).collect();
        let kept = { all.into_iter().zip(judged) }.filter_map(|(it, decided)| Some((it, decided?)));
        let best = kept.min_by_key(|(candidate, decided)| {
            let [silicon, exact] = decided.steps();
            (-silicon, -exact, candidate.words())
        });
        let Some((mut best, decided)) = best else {
            return Ok(None);
        };
        // Of what nothing saturates no more is said than that.
        best.decided = Some(decided).filter(|_| request.objective != Objective::Exact);
        best.solved.holds = self.fits(&best.solved.plan, best.bits, range);
        Ok(Some(self.built(best, seen)))
    }

    /// Keeps the candidates in which nothing saturates: with the chip's errors where there are such,
    /// else without them.
    fn keep_in_range(&self, all: &mut Vec<Candidate>, range: (f64, f64)) {
        let lenient = self.lenient();
        let fits = |who: &Self, it: &Candidate| who.fits(&it.solved.plan, it.bits, range);
        let strictly = all.iter().any(|it| fits(self, it));
        all.retain(|it| fits(if strictly { self } else { &lenient }, it));
    }

    /// A plan behind each number of halvings, up to the first with which nothing saturates and the
    /// threshold can be set, or the threshold is lost.
    fn scaled(
        &self,
        plan: &Plan,
        (negated, inner): (bool, u32),
        range: (f64, f64),
        (least, compared): (f64, Compared),
    ) -> Vec<Candidate> {
        let errors = self.request.store_errors();
        let registers = self.all.len();
        let rim = Rim::new(
            self.reach(),
            errors,
            self.request.device.value(Figure::Edge),
        );
        let mut all = Vec::new();
        for outer in (u32::from(negated)..HALVINGS.min(HALVINGS_IN_ALL - inner)).step_by(2) {
            let bits = outer + inner;
            if outer > 1 && least * 2f64.powi(-(bits as i32)) < LOWEST_THRESHOLD {
                break;
            }
            let Some(whole) = compose(&halvings(outer), plan) else {
                continue;
            };
            let problem = self.problem(bits, Effort::states(0));
            all.extend(self.tried(&problem, &whole, &Reads::new(), bits));
            match compared {
                Compared::Drives => {
                    let reads = balanced(&whole, errors, registers);
                    all.extend(self.without_constants(&problem, &whole, &reads, bits));
                }
                Compared::Difference => {
                    // What is left of halving would be moved across the border, too.
                    let first = halvings(outer);
                    let first = steadied(&first, &balanced(&first, errors, registers), registers)
                        .unwrap_or(first);
                    let level = trimmed(&first, errors).and_then(|first| compose(&first, plan));
                    for whole in level.iter().chain([&whole]) {
                        let reads = rim.levelled(whole, registers);
                        all.extend(self.without_constants(&problem, whole, &reads, bits));
                    }
                }
            }
            if !self.request.is_beyond_converter(bits) && self.fits(&whole, bits, range) {
                break;
            }
        }
        all
    }

    /// A plan in which these words read the constant, as it is and with what then is left in the result
    /// taken out.
    fn without_constants(
        &self,
        problem: &Problem,
        whole: &Plan,
        reads: &Reads,
        bits: u32,
    ) -> Vec<Candidate> {
        let registers = self.all.len();
        let steady = steadied(whole, reads, registers);
        let mut all = Vec::new();
        if steady.is_some() {
            all.extend(self.tried(problem, whole, reads, bits));
        }
        let errors = self.request.store_errors();
        if let Some(trimmed) = trimmed(steady.as_ref().unwrap_or(whole), errors) {
            all.extend(self.tried(problem, &trimmed, &Reads::new(), bits));
        }
        all
    }
}
