//! The memory of a host that runs beside the array: what is read goes there, and what nothing leads
//! to is given up.

use super::{
    beside::HELD,
    machine::{Machine, Spot},
    tree::Kind,
    value::{Slot, Value},
};
use crate::config::Place;

impl Machine<'_> {
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

/// The variables that a value leads to.
fn leads_to(value: &Value, all: &mut Vec<Slot>) {
    match value {
        Value::Pointer(slot, ..) | Value::Reference(slot, _) => all.push(*slot),
        Value::List(values) | Value::Record(_, values) => {
            for value in values {
                leads_to(value, all);
            }
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
