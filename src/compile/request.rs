//! What is asked of the compiler. Its entry is [`Request::filter`], in
//! [`register_count`](super::search::register_count).

use super::{
    codegen::{
        filter::Filter,
        instruction_set::{Buses, check_words},
        register_allocation::{RegisterFile, ordinary_registers},
    },
    construction::walk,
    decision::trial::{Compared, Decision},
    error::{CompileError, most_threshold},
    intermediate::{goals::goals, linear_form::LinearForm, plan::StoreErrors},
    search::solve::{FINE, Limits, Problem, Solved},
    silicon::survival::Choice,
};
use crate::{
    config::listed,
    isa::{Analog, Device, Primitive, Source, Target},
    kernel::Kernel,
    order::Order,
    stop::Stop,
    unit::counted,
};

/// How long to search, in states looked at: the result does not depend on the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    /// States that the search may look at; 0 leaves the plan that needs no search.
    pub states: u64,
    /// Whether to give up before.
    pub stop: Stop,
}

impl Effort {
    /// Seconds where nobody says how long, in every verb: the same question gets the same
    /// program.
    pub const SECONDS: f64 = 1.0;

    /// So many states.
    #[must_use]
    pub const fn states(states: u64) -> Self {
        Self {
            states,
            stop: Stop::NEVER,
        }
    }

    /// About as many states as two cores of 2024 look at in `seconds`.
    #[must_use]
    pub fn seconds(seconds: f64) -> Self {
        Self::states((seconds.clamp(0.0, 1e6) * 400_000.0) as u64)
    }

    /// So many states, given up by the same.
    #[must_use]
    pub const fn with_states(self, states: u64) -> Self {
        Self { states, ..self }
    }
}

impl Default for Effort {
    fn default() -> Self {
        Self::seconds(Self::SECONDS)
    }
}

/// What the border of the array counts for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Border {
    /// Nothing.
    #[default]
    Any,
    /// What is lost in the cells near it: plans that are right there come first, unless less of the
    /// signal comes out of them than of others, whose results near the border are worth nothing.
    Worth,
    /// More than all else: where there is a plan that is right there, it is taken.
    Right,
}

listed! {
/// What a program is to be best at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Objective = "objective" {
    /// The events that are kept on the chip, as predicted ([`Decided`](super::Decided)), with nearly
    /// all of them kept in exact arithmetic too: large inputs may saturate where that changes hardly
    /// a decision. With a memory of the pixel for all kinds as `Events`, since its filters have nothing
    /// that takes a chip's mismatch out. Where it is not known with what one result is compared, as
    /// `Exact`.
    #[default]
    Silicon = "silicon",
    /// The events that are kept on the chip, whatever saturates; among equals what is nearer to exact,
    /// then the fewest words.
    Events = "events",
    /// The signal-to-noise ratio that is predicted on the chip, and no input of the range saturates:
    /// in exact arithmetic a program decides as the kernel itself does, whatever it is shown. Where it
    /// is known with what one result is compared, the plan of these that decides best. Among equals,
    /// the fewest words.
    Exact = "exact",
    /// The fewest words.
    Words = "words",
}
}

/// Kernels, and what may be used for them.
#[derive(Clone, Debug)]
pub struct Request<'a> {
    /// One kernel for each result; weights are whole numbers of 2^-12, at most 4096 in size.
    pub kernels: &'a [Kernel],
    /// The chip whose words, registers and figures are used.
    pub device: &'a Device,
    /// The register in which the input begins.
    pub input: Analog,
    /// The register of each result.
    pub into: Vec<Analog>,
    /// Registers that stay as they are.
    pub keep: Vec<Analog>,
    /// Whether the results should be right up to the border of the array, with zeros beyond it.
    pub border: Border,
    /// What the input can be, in LSB; with it, the input is halved first as often as nothing
    /// then saturates.
    pub range: Option<(f64, f64)>,
    /// Whether what the chip makes of no input counts as noise: where a result is compared with a
    /// constant, and not with an earlier result, which has the same in it.
    pub zero_counts: bool,
    /// What the result is for, where it is compared with a threshold.
    pub decision: Option<Decision>,
    /// How long to search.
    pub effort: Effort,
    /// Seed of the search heuristics: another seed may find another program.
    pub seed: u64,
    /// What the program is to be best at.
    pub objective: Objective,
}

impl<'a> Request<'a> {
    /// From the first register into the first ones, everything else free to use.
    ///
    /// # Errors
    /// When there are more kernels than registers.
    pub fn new(kernels: &'a [Kernel], device: &'a Device) -> Result<Self, CompileError> {
        let all = ordinary_registers(device);
        let (Some(into), Some(input)) = (all.get(..kernels.len()), all.first().copied()) else {
            return Err(CompileError::Registers {
                kernels: kernels.len(),
                needed: kernels.len(),
                free: all.len(),
                are_kept: false,
            });
        };
        Ok(Self {
            kernels,
            device,
            input,
            into: into.to_vec(),
            keep: Vec::new(),
            border: Border::Any,
            range: None,
            zero_counts: false,
            decision: None,
            effort: Effort::default(),
            seed: 0,
            objective: Objective::default(),
        })
    }

    /// Moves results out of registers that are kept, into others where there are enough.
    pub fn into_free(&mut self) {
        let free = |register: &Analog| !self.keep.contains(register);
        let all = ordinary_registers(self.device).into_iter().filter(free);
        let into: Vec<Analog> = all.take(self.kernels.len()).collect();
        if into.len() == self.kernels.len() {
            self.into = into;
        }
    }

    /// Whether its fields fit each other and the chip.
    pub(super) fn check(&self) -> Result<(), CompileError> {
        let wrong = |field, what: String, help| Err(CompileError::Field { field, what, help });
        let all = ordinary_registers(self.device);
        let name = |register: &Analog| self.device.analog_name(*register);
        let is_there = |register: &&Analog| all.contains(register);
        let registers =
            "give registers of this chip but NEWS: Device::analog finds one by its name";
        for (field, own) in [
            ("input", std::slice::from_ref(&self.input)),
            ("into", &self.into[..]),
        ] {
            if let Some(register) = own.iter().find(|register| !is_there(register)) {
                let what = format!("{} is no register for values", name(register));
                return wrong(field, what, registers);
            }
        }
        let (kernels, into) = (self.kernels.len(), self.into.len());
        if kernels != into {
            let what = format!(
                "{} for {}",
                counted(into, "register"),
                counted(kernels, "kernel")
            );
            return wrong("into", what, "give one register for each kernel");
        }
        let twice = |(n, register): &(usize, &Analog)| self.into[..*n].contains(register);
        if let Some((_, register)) = self.into.iter().enumerate().find(twice) {
            let what = format!("{} twice", name(register));
            return wrong("into", what, "give each result a register of its own");
        }
        let kept = |register: &&Analog| self.keep.contains(register);
        let free = all.iter().filter(|register| !kept(register));
        // Where there are too few, that is what is said.
        if free.count() >= kernels {
            if let Some(register) = self.into.iter().find(kept) {
                let what = format!("{} is kept, and a result goes into it", name(register));
                let help = "keep another register, or move the result: Request::into_free";
                return wrong("keep", what, help);
            }
            if kept(&&self.input) {
                let what = format!("{} is kept, and the input is in it", name(&self.input));
                let help = "keep other registers; copy the input first where it is needed later";
                return wrong("keep", what, help);
            }
        }
        match self.range {
            Some((low, high)) if low.is_nan() || high.is_nan() || low > high => {
                let what = format!("from {low} to {high} LSB");
                wrong("range", what, "give the lowest input, then the highest")
            }
            _ => Ok(()),
        }
    }

    /// Filters none of which has both fewer words and more signal over noise than another, the
    /// shortest first.
    ///
    /// # Errors
    /// When a field cannot be, a weight is not dyadic, or the registers do not suffice.
    pub fn front(&self) -> Result<Vec<Filter>, CompileError> {
        self.check()?;
        let (goals, unit) = goals(self.kernels)?;
        let all = self.free_registers();
        let mut found = Choice::new(self, &goals, unit, (&all, self.effort)).front()?;
        let shortest = Self {
            objective: Objective::Words,
            ..self.clone()
        };
        found.push(shortest.filter()?);
        // What is taken where no front is asked for.
        found.push(self.filter()?);
        found.order_by_key(|filter| (filter.words.len(), self.quality(filter).map(|it| -it)));
        let mut best = None;
        found.retain(|filter| {
            let own = Some(self.quality(filter));
            let is_better = own > best;
            best = best.max(own);
            is_better
        });
        // Those that the chip stores; where there is none, why the shortest does not fit.
        let mut front = Vec::new();
        let mut refused = None;
        for filter in found {
            let long = CompileError::of_store(filter.word_count(self.device), self.device);
            let checked = match long {
                Some(error) => Err(error),
                None => check_words(&filter.text(self.device, 0), self.device),
            };
            match checked {
                Ok(()) => front.push(filter),
                Err(error) => refused = refused.or(Some(error)),
            }
        }
        match refused {
            Some(error) if front.is_empty() => Err(error),
            _ => Ok(front),
        }
    }

    /// The filter in these registers.
    pub(super) fn filter_in(&self, all: &[Analog], effort: Effort) -> Result<Filter, CompileError> {
        let (goals, unit) = goals(self.kernels)?;
        match self.objective {
            Objective::Words => self.fewest(&goals, unit, (all, effort)),
            Objective::Silicon | Objective::Events | Objective::Exact => {
                Choice::new(self, &goals, unit, (all, effort)).filter()
            }
        }
    }

    /// Whether the chip's converter can set the thresholds behind so many halvings: it has whole LSB,
    /// so that a low one becomes 0 and any change fires, and a range.
    pub(super) fn sets_threshold(&self, bits: u32) -> bool {
        let sets = |least: f64| (least * 2f64.powi(-(bits as i32))).round_ties_even() >= 1.0;
        let least = self.decision.map(|decision| decision.on.min(decision.off));
        least.is_none_or(sets) && !self.is_beyond_converter(bits)
    }

    /// Whether the result is a difference that is compared with a threshold.
    pub(super) fn compares_differences(&self) -> bool {
        let compared = self.decision.map(|decision| decision.compared);
        compared == Some(Compared::Difference)
    }

    /// Whether a threshold is higher than the converter goes.
    pub(super) fn is_beyond_converter(&self, bits: u32) -> bool {
        self.decision.is_some_and(|decision| {
            decision.on.max(decision.off) * 2f64.powi(-(bits as i32)) > most_threshold(self.device)
        })
    }

    /// The filter of the fewest words that any search finds: with halvings in a plan there may be
    /// fewer than with all of them in front of it.
    fn fewest(
        &self,
        goals: &[LinearForm],
        unit: i64,
        (all, effort): (&[Analog], Effort),
    ) -> Result<Filter, CompileError> {
        let front = self.shortest(goals, unit, (all, effort));
        if front.as_ref().is_ok_and(|filter| self.is_least(filter)) {
            return front;
        }
        let request = &Self {
            objective: Objective::Exact,
            ..self.clone()
        };
        let other = Choice::new(request, goals, unit, (all, effort));
        let Ok(Some(other)) = other.shortest() else {
            return front;
        };
        Ok(match front {
            Ok(front) => self.shorter(front, other),
            Err(_) => other,
        })
    }

    /// Of two filters the one of fewer words, the first where they are equal; what both cost to find.
    pub(super) fn shorter(&self, one: Filter, other: Filter) -> Filter {
        let states = one.states + other.states;
        let fewest = if self.key(&other) < self.key(&one) {
            other
        } else {
            one
        };
        Filter { states, ..fewest }
    }

    /// The filter of the fewest words, with all halvings in front of it.
    pub(super) fn shortest(
        &self,
        goals: &[LinearForm],
        unit: i64,
        (all, effort): (&[Analog], Effort),
    ) -> Result<Filter, CompileError> {
        let built = |solved: &Solved, bits, first| {
            let place = (self.device, self.input, &self.into[..]);
            let range = (self.range, self.compares_differences());
            Filter::from_solved(place, range, solved, unit, bits, first)
        };
        let Some((low, high)) = self.range else {
            let plus = self.solve(goals, unit, (self.input, all, effort), None)?;
            return Ok(built(&plus, 0, Vec::new()));
        };
        let mut limits = self.limits((low, high));
        let plus = self.solve(goals, unit, (self.input, all, effort), Some(limits))?;
        if !plus.holds {
            // On a chip without errors, at least.
            limits.errors = StoreErrors {
                transfer: 0.0,
                division: 0.0,
            };
        }
        let other = all.iter().copied().find(|r| *r != self.input);
        let (Some(bits), Some(other)) = (halvings(&plus, unit, limits), other) else {
            return Err(self.no_halving((low, high)));
        };
        if bits.is_multiple_of(2) {
            let first = self.prescaled(other, bits)?;
            return Ok(built(&plus, bits, first));
        }
        // Every store negates, so an odd number of halvings gives the negated input, in the other
        // register.
        let goals: Vec<LinearForm> = goals.iter().map(|goal| goal.times(-1)).collect();
        limits.input = (-high, -low);
        limits.odd = true;
        let mut minus = self.solve(&goals, unit, (other, all, effort), Some(limits))?;
        minus.holds &= plus.holds;
        let Some(bits) = halvings(&minus, unit, limits) else {
            return Err(self.no_halving((low, high)));
        };
        let first = self.prescaled(other, bits)?;
        Ok(built(&minus, bits, first))
    }

    /// A range of the input, and the errors of the chip.
    pub(super) fn limits(&self, input: (f64, f64)) -> Limits {
        Limits {
            input,
            odd: false,
            register: self.device.register_range(),
            errors: self.store_errors(),
        }
    }

    /// No program for an input of this range.
    fn no_halving(&self, (low, high): (f64, f64)) -> CompileError {
        let (lowest, highest) = self.device.register_range();
        CompileError::Range {
            low,
            high,
            lowest,
            highest,
        }
    }

    /// The constant errors of the chip's stores.
    pub(super) fn store_errors(&self) -> StoreErrors {
        StoreErrors::from_device(self.device)
    }

    /// The problem of the search.
    pub(super) fn problem(
        &self,
        goals: &[LinearForm],
        unit: i64,
        (input, all, effort): (Analog, &[Analog], Effort),
        limits: Option<Limits>,
    ) -> Problem {
        Problem {
            goals: goals.to_vec(),
            unit,
            registers: RegisterFile {
                news: self.device.news(),
                input,
                into: self.into.clone(),
                all: all.to_vec(),
            },
            buses: Buses::from_device(self.device),
            border: self.border != Border::Any,
            seed: self.seed,
            // Of kernels of zeros there is nothing to look for.
            states: if goals.iter().all(LinearForm::is_zero) {
                0
            } else {
                effort.states
            },
            limits,
            shortest: self.objective == Objective::Words,
            stop: effort.stop,
        }
    }

    fn solve(
        &self,
        goals: &[LinearForm],
        unit: i64,
        file: (Analog, &[Analog], Effort),
        limits: Option<Limits>,
    ) -> Result<Solved, CompileError> {
        let found = self.problem(goals, unit, file, limits).solve();
        found.ok_or_else(|| self.none_found(goals.len(), file.1.len()))
    }

    /// Registers do not suffice, or words are missing that plans in so many need.
    pub(super) fn none_found(&self, goals: usize, free: usize) -> CompileError {
        let needed = goals + walk::FEWEST_REGISTERS - 1;
        match Buses::from_device(self.device).missing() {
            Some(form) if free >= needed => self.missing(form, "no filter without it was found"),
            _ => CompileError::Registers {
                kernels: goals,
                needed,
                free,
                are_kept: !self.keep.is_empty(),
            },
        }
    }

    /// No program without a word of this form, and what it is for.
    fn missing(&self, form: &str, why: &str) -> CompileError {
        let chip = self.device.name();
        CompileError::Missing {
            chip: chip.to_owned(),
            why: format!("{chip} has no `{form}`, and {why}"),
        }
    }

    /// Words that halve the input so often, if the chip has them.
    fn prescaled(&self, other: Analog, bits: u32) -> Result<Vec<Primitive>, CompileError> {
        if bits > 0 && !Buses::from_device(self.device).halve() {
            let form = "bus2(out y: target, out z: target, x: source)";
            let times = counted(bits, "time");
            let why = format!("its input must be halved {times} for every sum to stay in range");
            return Err(self.missing(form, &why));
        }
        Ok(prescale(self.device, self.input, other, bits))
    }
}

/// Words that halve the input `bits` times, alternating between two registers.
fn prescale(device: &Device, from: Analog, other: Analog, bits: u32) -> Vec<Primitive> {
    let ends = [from, other];
    let half = |i: u32| Primitive::Bus {
        targets: vec![
            Target::Register(ends[(i as usize + 1) % 2]),
            Target::Register(device.news()),
        ],
        sources: vec![Source::Register(ends[i as usize % 2])],
    };
    (0..bits).map(half).collect()
}

/// How often the input must be halved for nothing to saturate.
fn halvings(solved: &Solved, unit: i64, limits: Limits) -> Option<u32> {
    let trace = solved.plan.trace(unit * FINE)?;
    limits.halvings(&solved.plan, &trace, unit)
}
