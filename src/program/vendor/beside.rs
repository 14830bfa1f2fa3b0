//! A program whose host decides as it goes: it runs beside the array, so that what it reads is
//! known, and each frame has words of its own.

use std::{collections::BTreeMap, sync::Arc};

use sprintf::{ConversionSpecifier, Printf};

use super::{
    light::{capture, light},
    machine::{Machine, Spot},
    tree::{Kind, Width},
    value::{Slot, Value},
};
use crate::{
    config::{Fault, Place, Severity},
    program::{
        Overrides, Step,
        expand::expand,
        syntax::{Item, Node, Syntax},
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
const HELD: usize = 1 << 16;

/// The array, and what the host knows of the frame that runs.
pub(super) struct Companion<'a> {
    array: &'a mut dyn Beside,
    /// Steps of what was asked before.
    known: Vec<(Vec<Item>, Arc<[Step]>)>,
    /// The last `scamp5_draw_begin`.
    drawing: Option<Item>,
    /// Whether this frame's light was captured, or its photodiodes were reset.
    captured: bool,
    /// Whether anything was asked of the array in this frame.
    ran: bool,
    /// Whether the program has waited for a frame.
    waited: bool,
    /// The frames so far.
    pub frames: u64,
    /// Whether no frame comes any more.
    pub over: bool,
    /// Faults of the steps, in places of the file itself.
    pub faults: Vec<Fault>,
    /// When stopwatches were set back, by their variables.
    clocks: BTreeMap<Slot, f64>,
    /// Random numbers that were drawn.
    drawn: u64,
    /// Variables at which the next ones are given up.
    enough: usize,
}

impl<'a> Companion<'a> {
    pub(super) fn new(array: &'a mut dyn Beside) -> Self {
        let over = !array.frame();
        Self {
            array,
            known: Vec::new(),
            drawing: None,
            captured: false,
            ran: false,
            waited: false,
            frames: 1,
            over,
            faults: Vec::new(),
            clocks: BTreeMap::new(),
            drawn: 0,
            enough: HELD,
        }
    }

    /// The next number of `rand()`: of the chip's own library, nobody states which they are.
    pub(super) fn random(&mut self) -> i64 {
        self.drawn += 1;
        (crate::rng::Hash::new(0).with(self.drawn).bits() >> 33) as i64
    }
}

impl Machine<'_> {
    /// A stopwatch (`vs_stopwatch`): the host's own work takes no time in it.
    pub(super) fn stopwatch(&mut self, slot: Slot, member: &str) -> Option<Value> {
        self.companion.as_ref()?;
        // What was asked before has taken its time.
        self.run_asked();
        let companion = self.companion.as_mut()?;
        let now = companion.array.micros();
        match member {
            "reset" => {
                companion.clocks.insert(slot, now);
                Some(Value::Whole(0))
            }
            "get_usec" => {
                let start = companion.clocks.get(&slot).copied().unwrap_or_default();
                Some(Value::Wide((now - start).ceil() as i64, Width::Unsigned))
            }
            _ => None,
        }
    }

    /// Runs what was asked of the array; what its last statement gave. Nothing while a kernel is
    /// being written: its words run when it is whole.
    pub(super) fn run_asked(&mut self) -> Option<Answer> {
        if self.kernel.is_some() {
            return None;
        }
        let companion = self.companion.as_mut().filter(|it| !it.over)?;
        let items = std::mem::take(&mut self.items);
        if items.is_empty() {
            return None;
        }
        companion.ran = true;
        companion.captured |= capture(&items).is_some() || light(&items);
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
        if let Some(draws) = items.iter().position(|it| names(it, "scamp5_draw_")) {
            let begins = |it: &Item| names(it, "scamp5_draw_begin");
            if let (Some(begin), false) = (&companion.drawing, begins(&items[draws])) {
                items.insert(draws, begin.clone());
            }
            companion.drawing = items.iter().rfind(|it| begins(it)).cloned();
        }
        if let Some((_, steps)) = companion.known.iter().find(|it| it.0 == items) {
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
        let errors: Vec<Fault> = errors.collect();
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
    pub(super) fn next_frame(&mut self) {
        self.run_asked();
        let Some(companion) = self.companion.as_mut().filter(|it| !it.over) else {
            return;
        };
        let first = !std::mem::replace(&mut companion.waited, true);
        if first && !companion.captured {
            return;
        }
        (companion.captured, companion.ran) = (false, false);
        companion.over = !companion.array.frame();
        companion.frames += 1;
        self.works_anew();
    }

    /// `printf(format, …)`, with what is known of its values.
    pub(super) fn post(&mut self, values: &[Value]) {
        let (Some(companion), Some((Value::Text(format), values))) =
            (self.companion.as_mut(), values.split_first())
        else {
            return;
        };
        let given: Vec<Printed<'_>> = values.iter().map(Printed).collect();
        let given: Vec<&dyn Printf> = given.iter().map(|it| it as &dyn Printf).collect();
        // A format that does not fit its values is shown as it stands.
        let text = sprintf::vsprintf(format, &given).unwrap_or_else(|_| format.to_string());
        companion.array.post(text);
    }

    /// Whether anything was asked of the array in this frame.
    pub(super) fn has_run(&self) -> bool {
        self.companion.as_ref().is_some_and(|it| it.ran)
    }

    /// Begins another frame; whether there is one.
    pub(super) fn another_frame(&mut self) -> bool {
        if let Some(companion) = &mut self.companion {
            companion.waited = true;
        }
        self.next_frame();
        self.give_up();
        !self.done()
    }

    /// Writes what was read to where the host wanted it.
    pub(super) fn fill(&mut self, (slot, path): &Spot, memory: &[i64], name: &str, place: Place) {
        if let (Value::Unknown(_), true) = (&self.slots[*slot], path.is_empty()) {
            let all = memory.iter().map(|it| Value::Whole(*it)).collect();
            self.put(*slot, path, Value::List(all));
            return;
        }
        let mut cells = Vec::new();
        leaves(
            &self.slots[*slot],
            path,
            &mut Vec::new(),
            memory.len(),
            &mut cells,
        );
        if cells.len() < memory.len() {
            let (wants, room) = (memory.len(), cells.len());
            self.error(
                place,
                format!("`{name}` writes {wants} numbers, and there is room for {room}"),
                "this call",
                "give it a larger array, or let it read less",
            );
            return;
        }
        for (cell, number) in cells.iter().zip(memory) {
            self.put(*slot, cell, Value::Whole(*number));
        }
    }

    /// Gives up variables that no name, no pointer and no lambda leads to.
    pub(super) fn give_up(&mut self) {
        let Some(companion) = self.companion.as_mut() else {
            return;
        };
        if self.slots.len() - self.free.len() < companion.enough {
            return;
        }
        let mut alive = vec![false; self.slots.len()];
        let mut open: Vec<Slot> = self
            .scopes
            .iter()
            .flat_map(|it| it.values().copied())
            .collect();
        open.extend(self.lasting.values());
        if let Some(stack) = &self.stack {
            leads_to(stack, &mut open);
        }
        while let Some(slot) = open.pop() {
            if !std::mem::replace(&mut alive[slot], true) {
                leads_to(&self.slots[slot], &mut open);
            }
        }
        self.free = (0..alive.len()).filter(|slot| !alive[*slot]).collect();
        for slot in self.free.clone() {
            self.slots[slot] = Value::Whole(0);
            self.kinds[slot] = Kind::Any;
        }
        let left = self.slots.len() - self.free.len();
        if let Some(companion) = &mut self.companion {
            companion.enough = HELD.max(2 * left);
            companion.clocks.retain(|slot, _| alive[*slot]);
        }
    }
}

/// A value as `printf` takes it, whatever its type is; `?` where it is not known.
struct Printed<'a>(&'a Value);

impl Printf for Printed<'_> {
    fn format(&self, spec: &ConversionSpecifier) -> sprintf::Result<String> {
        match *self.0 {
            Value::Whole(number) => {
                let narrow = number as i32;
                let character = || (narrow as u32).format(spec);
                let real = || (number as f64).format(spec);
                narrow
                    .format(spec)
                    .or_else(|_| character())
                    .or_else(|_| real())
            }
            Value::Wide(number, Width::Long) if number != i64::MIN => number.format(spec),
            Value::Wide(number, _) => (number as u64).format(spec),
            Value::Real(number) => {
                let whole = || (number as i32).format(spec);
                number.format(spec).or_else(|_| whole())
            }
            Value::Text(ref text) | Value::Symbol(ref text) => (&**text).format(spec),
            _ => Ok("?".to_owned()),
        }
    }

    fn as_int(&self) -> Option<i32> {
        self.0.whole().and_then(|it| it.try_into().ok())
    }
}

/// Whether a statement's name begins so.
fn names(it: &Item, begin: &str) -> bool {
    matches!(&it.node, Node::Statement(statement) if statement.name.starts_with(begin))
}

/// The variables that a value leads to.
fn leads_to(value: &Value, all: &mut Vec<Slot>) {
    match value {
        Value::Pointer(slot, ..) | Value::Reference(slot, _) => all.push(*slot),
        Value::List(values) | Value::Record(_, values) => {
            values.iter().for_each(|it| leads_to(it, all));
        }
        Value::Lambda(function) => all.extend(function.held.iter().map(|it| it.1)),
        Value::Whole(_)
        | Value::Wide(..)
        | Value::Real(_)
        | Value::Unknown(_)
        | Value::Symbol(_)
        | Value::Symbols(_)
        | Value::Text(_) => {}
    }
}

/// The ways to the numbers of a variable, in the order of memory, from a place on.
fn leaves(
    value: &Value,
    from: &[usize],
    way: &mut Vec<usize>,
    most: usize,
    found: &mut Vec<Vec<usize>>,
) {
    match value {
        Value::List(all) | Value::Record(_, all) => {
            let first = from.first().copied().unwrap_or_default();
            for (i, inner) in all.iter().enumerate().skip(first) {
                if found.len() == most {
                    return;
                }
                let from = if i == first { from.get(1..) } else { None };
                way.push(i);
                leaves(inner, from.unwrap_or_default(), way, most, found);
                way.pop();
            }
        }
        _ if found.len() < most => found.push(way.clone()),
        _ => {}
    }
}
