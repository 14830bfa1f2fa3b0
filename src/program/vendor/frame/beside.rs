//! A program whose host decides as it goes: it runs beside the array, so that what it reads is
//! known, and each frame has words of its own.

use std::{collections::BTreeMap, sync::Arc};

use super::light::{capture, light};
use crate::{
    config::{Fault, Severity},
    program::{
        Overrides, Step,
        expand::expand,
        syntax::{Item, Node, Syntax},
        vendor::{
            interpreter::{
                machine::Machine,
                value::{Slot, Value},
            },
            syntax::tree::Width,
        },
    },
};

/// The array, as a host has it that runs beside.
pub trait Beside {
    /// Ends the frame, and lets the light of the next one fall; false where there is none, which
    /// ends the program. The first call begins the first frame.
    fn frame(&mut self) -> bool;

    /// Runs these steps in the frame; what the last of them gave the host to read. `None` ends the
    /// program.
    fn run(&mut self, steps: &[Step]) -> Option<Answer>;

    /// The time since power-on, in microseconds, as far as the array and its readouts take any.
    fn micros(&self) -> f64;

    /// Takes a text that the host writes for people.
    fn post(&mut self, text: String);
}

/// What a host reads from the array.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Answer {
    /// What the call gives back.
    pub value: Option<i64>,
    /// What it writes into memory, from where its pointer leads.
    pub memory: Option<Vec<i64>>,
}

/// Pieces of a program whose steps are kept.
const KEPT: usize = 1024;

/// Variables above which those that nothing leads to any more are given up.
pub(in crate::program::vendor) const HELD: usize = 1 << 16;

/// What was asked in the frame that runs.
#[derive(Default)]
struct Now {
    /// Whether anything was.
    any: bool,
    /// Whether its light was captured, or its photodiodes were reset.
    light: bool,
}

/// The array, and what the host knows of its frames.
pub(in crate::program::vendor) struct Companion<'a> {
    pub array: &'a mut dyn Beside,
    /// Steps of what was asked before.
    known: Vec<(Vec<Item>, Arc<[Step]>)>,
    /// The last `scamp5_draw_begin`.
    drawing: Option<Item>,
    now: Now,
    /// How often the array ran what was asked.
    ran: u64,
    /// Whether the program has waited for a frame.
    waited: bool,
    /// The frames so far.
    pub frames: u64,
    /// The loop's counter, which `vs_frame_loop_control` adds to.
    pub counted: u64,
    /// Whether no frame comes any more.
    pub over: bool,
    /// Faults of the steps, in places of the file itself.
    pub faults: Vec<Fault>,
    /// When stopwatches were set back, by their variables.
    pub clocks: BTreeMap<Slot, f64>,
    /// The array's time when a stopwatch was asked last, how often it has been asked since, and the
    /// microseconds that were waited in all.
    asked: f64,
    waits: u64,
    waited_us: f64,
    /// How far the triggers of frames are apart, in microseconds, whether they are waited for, and
    /// when the last one came.
    pub period_us: f64,
    pub triggers: bool,
    triggered_us: f64,
    /// Random numbers that were drawn.
    drawn: u64,
    /// Variables at which the next ones are given up.
    pub enough: usize,
}

impl<'a> Companion<'a> {
    /// Waits for the trigger of the next frame, as stopwatches see it.
    fn awaits_trigger(&mut self) {
        let now = self.array.micros() + self.waited_us;
        let due = self.triggered_us + self.period_us;
        let wait = if self.triggers { due - now } else { 0.0 };
        self.waited_us += wait.max(0.0);
        self.triggered_us = now + wait.max(0.0);
    }

    pub(in crate::program::vendor) fn new(array: &'a mut dyn Beside) -> Self {
        let over = !array.frame();
        Self {
            array,
            known: Vec::new(),
            drawing: None,
            now: Now::default(),
            ran: 0,
            waited: false,
            frames: 1,
            counted: 0,
            over,
            faults: Vec::new(),
            clocks: BTreeMap::new(),
            asked: 0.0,
            waits: 0,
            waited_us: 0.0,
            period_us: 0.0,
            triggers: true,
            triggered_us: 0.0,
            drawn: 0,
            enough: HELD,
        }
    }

    /// The next number of `rand()`: of the chip's own library, nobody says which they are.
    pub(in crate::program::vendor) fn random(&mut self) -> i64 {
        self.drawn += 1;
        (crate::rng::Hash::new(0).with(self.drawn).bits() >> 33) as i64
    }

    /// The next random number, even from 0 up to 1.
    pub(in crate::program::vendor) fn even(&mut self) -> f64 {
        self.random() as f64 / f64::from(1_u32 << 31)
    }
}

/// Questions to stopwatches, one after the other, that take no time.
const PATIENCE: u64 = 16;

impl Machine<'_> {
    /// How many frames were waited for before this one, where that is known: the vendor's counter
    /// of the loop.
    pub(in crate::program::vendor) fn loop_counter(&self) -> Value {
        match &self.companion {
            Some(companion) => Value::Wide(companion.counted as i64, Width::Unsigned),
            None => Value::Unknown("how many frames have passed".into()),
        }
    }

    /// Another turn of the loop over the frames.
    pub(in crate::program::vendor) fn count_turn(&mut self) {
        if let Some(companion) = &mut self.companion {
            companion.counted += 1;
        }
    }

    /// The trigger of frames: `vs_frame_trigger_set(1, frames_in_a_second)`, and whether it is on.
    pub(in crate::program::vendor) fn triggers(&mut self, name: &str, given: &[Value]) {
        let Some(companion) = &mut self.companion else {
            return;
        };
        match name {
            "vs_enable_frame_trigger" => companion.triggers = true,
            "vs_disable_frame_trigger" => companion.triggers = false,
            _ => {
                let numbers: Vec<f64> = given.iter().filter_map(Value::number).collect();
                if let [part, of] = numbers[..]
                    && of > 0.0
                {
                    companion.period_us = (1e6 * part / of).max(0.0);
                }
            }
        }
    }

    /// `vs_wait(microseconds)`, which stopwatches see.
    pub(in crate::program::vendor) fn waits(&mut self, given: &[Value]) {
        let time = given.first().and_then(Value::number);
        if let (Some(companion), Some(time)) = (&mut self.companion, time) {
            companion.waited_us += time.max(0.0);
        }
    }

    /// A stopwatch (`vs_stopwatch`): the host's own work takes no time in it.
    pub(in crate::program::vendor) fn stopwatch(
        &mut self,
        slot: Slot,
        member: &str,
    ) -> Option<Value> {
        self.companion.as_ref()?;
        // What was asked before has taken its time.
        self.run_asked();
        let companion = self.companion.as_mut()?;
        let array = companion.array.micros();
        // A host that asks on and on waits: each question then takes a microsecond.
        companion.waits = if array > companion.asked {
            0
        } else {
            companion.waits + 1
        };
        companion.asked = array;
        if companion.waits > PATIENCE {
            companion.waited_us += 1.0;
        }
        let now = array + companion.waited_us;
        match member {
            "reset" => {
                companion.clocks.insert(slot, now);
                Some(Value::Whole(0))
            }
            "get_usec" => {
                let start = companion.clocks.get(&slot).copied().unwrap_or_default();
                // Programs divide by this.
                let passed = (now - start).ceil().max(1.0);
                Some(Value::Wide(passed as i64, Width::Unsigned))
            }
            _ => None,
        }
    }

    /// Runs what was asked of the array; what its last statement gave. The words of a kernel that is
    /// being recorded run when it is launched.
    pub(in crate::program::vendor) fn run_asked(&mut self) -> Option<Answer> {
        let companion = self.companion.as_mut().filter(|it| !it.over)?;
        let items = std::mem::take(&mut self.items);
        if items.is_empty() {
            return None;
        }
        companion.now.any = true;
        companion.ran += 1;
        companion.now.light |= capture(&items).is_some() || light(&items);
        let steps = self.steps(items)?;
        self.asks_anew();
        let companion = self.companion.as_mut()?;
        let answer = companion.array.run(&steps);
        companion.over |= answer.is_none();
        answer
    }

    /// The steps that these statements are; `None` where they are wrong.
    fn steps(&mut self, mut items: Vec<Item>) -> Option<Arc<[Step]>> {
        let companion = self.companion.as_mut()?;
        let mut drawn = Vec::new();
        for (at, it) in items.iter().enumerate() {
            drawing(it, at, &mut drawn);
        }
        if let Some(&(at, first)) = drawn.first() {
            let begins = |it: &Item| names(it, "scamp5_draw_begin");
            let ends = |it: &Item| names(it, "scamp5_draw_end");
            let goes_on = !begins(first);
            let last = drawn.iter().map(|it| it.1);
            let last = { last }.rfind(|it| begins(it) || ends(it)).cloned();
            let before = companion.drawing.take();
            companion.drawing = match last {
                Some(last) => Some(last).filter(begins),
                None => before.clone(),
            };
            if let (Some(begin), true) = (before, goes_on) {
                items.insert(at, begin);
            }
        }
        let here = |(known, _): &&(Vec<Item>, _)| {
            let places = known.iter().zip(&items);
            *known == items && { places }.all(|(a, b)| a.place.is(b.place))
        };
        if let Some((_, steps)) = companion.known.iter().find(here) {
            return Some(Arc::clone(steps));
        }
        let syntax = Syntax {
            items,
            ..Syntax::default()
        };
        let none = Overrides::new();
        let (expansion, faults) = expand(&syntax, self.text, &none, self.device, &none);
        // What is wrong with pieces of it, such as that nothing uses what they leave, is no fault.
        let errors = faults
            .into_iter()
            .filter(|it| it.severity == Severity::Error);
        let errors: Vec<Fault> = errors.map(in_cpp).collect();
        if !errors.is_empty() {
            companion.faults.extend(errors);
            companion.over = true;
            return None;
        }
        let steps: Arc<[Step]> = expansion.code.frame.into();
        if companion.known.len() == KEPT {
            companion.known.clear();
        }
        companion.known.push((syntax.items, Arc::clone(&steps)));
        Some(steps)
    }

    /// The host waits for a frame. The first one is there from the beginning, and its own until it
    /// captures the light.
    pub(in crate::program::vendor) fn next_frame(&mut self) {
        self.run_asked();
        self.dark = false;
        let Some(companion) = self.companion.as_mut().filter(|it| !it.over) else {
            return;
        };
        let first = !std::mem::replace(&mut companion.waited, true);
        if first && !companion.now.light {
            return;
        }
        companion.awaits_trigger();
        companion.now = Now::default();
        companion.over = !companion.array.frame();
        companion.frames += 1;
        self.works_anew();
    }

    /// How often the array ran what was asked; 0 where none is there.
    pub(in crate::program::vendor) fn ran_beside(&self) -> u64 {
        self.companion.as_ref().map_or(0, |it| it.ran)
    }

    /// Whether anything was asked of the array in this frame.
    pub(in crate::program::vendor) fn has_run(&self) -> bool {
        self.companion.as_ref().is_some_and(|it| it.now.any)
    }

    /// Begins another frame; whether there is one.
    pub(in crate::program::vendor) fn another_frame(&mut self) -> bool {
        if let Some(companion) = &mut self.companion {
            companion.waited = true;
        }
        self.next_frame();
        self.give_up();
        !self.done()
    }
}

/// What is wrong with statements, as whoever writes C++ mends it.
pub(in crate::program) fn in_cpp(fault: Fault) -> Fault {
    let repeats = fault.help.as_deref().unwrap_or_default();
    if !repeats.contains("`repeat N { … }`") {
        return fault;
    }
    fault.help("loop less often; a loop outside of kernels counts as one pass where its passes ask the same: give its passes the same body")
}

/// Adds the statements that draw, in loops too, with the place of the item that they stand in.
fn drawing<'a>(it: &'a Item, at: usize, all: &mut Vec<(usize, &'a Item)>) {
    match &it.node {
        Node::Repeat { body, .. } => body.iter().for_each(|it| drawing(it, at, all)),
        _ if names(it, "scamp5_draw_") => all.push((at, it)),
        _ => {}
    }
}

/// Whether a statement's name begins so.
fn names(it: &Item, begin: &str) -> bool {
    matches!(&it.node, Node::Statement(statement) if statement.name.starts_with(begin))
}
