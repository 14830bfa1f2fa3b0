//! The memory of a host that runs beside the array: what is read goes there, and what nothing leads
//! to is given up.

use crate::{
    config::Place,
    limit::VENDOR_VALUES,
    program::vendor::{
        frame::beside::HELD,
        interpreter::{
            machine::{GAIN, Location, Machine},
            reason::Reason,
            shape,
            value::{Slot, Value},
        },
        syntax::tree::{Expr, ExprNode, Kind, Word},
    },
};

impl Machine<'_> {
    /// Writes what was read to where the host wanted it.
    pub(in crate::program::vendor) fn fill(
        &mut self,
        (slot, path): &Location,
        memory: &[i64],
        name: &str,
        place: Place,
    ) {
        let single = memory.len() == 1;
        if let (Value::Unknown(_), true, false) = (&self.slots[*slot], path.is_empty(), single) {
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
                format!(
                    "`{name}` writes {}, but the buffer has room for {room}",
                    crate::unit::counted(wants, "number")
                ),
                "this call",
                "give it a larger array, or read less",
            );
            return;
        }
        for (cell, number) in cells.iter().zip(memory) {
            let kind = self.kind_at(*slot, cell);
            self.put(*slot, cell, Value::Whole(*number).converted(kind));
        }
    }

    /// Memory as numbers of another type. What those are is not worked out: where the types differ,
    /// neither is known from then on.
    pub(in crate::program::vendor) fn recast(&mut self, kind: Kind, of: &Expr) -> Value {
        let (slot, name, ..) = match self.seen(kind, of) {
            Ok(seen) => seen,
            Err(value) => return value,
        };
        let why = Reason::Never(
            format!("`{name}`, which is read through a pointer to another type").into(),
        );
        self.forget(slot, &[], &why);
        self.fixed.insert(slot);
        Value::Unknown(why)
    }

    /// A variable that is seen as numbers of this type, with its name, the type of those that it holds
    /// and a pointer to the first; what it is where there is no question of types.
    fn seen(&mut self, kind: Kind, of: &Expr) -> Result<(Slot, Word, Kind, Value), Value> {
        let Value::Pointer(slot, path, name) = self.value(of) else {
            let why = Reason::never("memory that is read through a pointer to another type");
            return Err(Value::Unknown(why));
        };
        let mut first = Vec::new();
        leaves(&self.slots[slot], &path, &mut Vec::new(), 1, &mut first);
        let Some(first) = first.pop() else {
            return Err(Value::Pointer(slot, path, name));
        };
        let held = self.kind_at(slot, &first);
        let value = Value::Pointer(slot, first, name.clone());
        if held == Kind::Any || held == self.resolved(kind) {
            return Err(value);
        }
        Ok((slot, name, held, value))
    }

    /// Memory that what is read from the array is written into, seen as numbers as large as those
    /// that it holds; `None` where they are others, which is told.
    pub(in crate::program::vendor) fn buffer(&mut self, name: &str, it: &Expr) -> Option<Value> {
        let ExprNode::Recast(kind, of) = &it.node else {
            return Some(self.value(it));
        };
        let (slot, array, held, value) = match self.seen(*kind, of) {
            Ok(seen) => seen,
            Err(value) => return Some(value),
        };
        let kind = self.resolved(*kind);
        let whole = |kind| matches!(kind, Kind::Bits(..));
        if whole(held) && whole(kind) && held.bytes() == kind.bytes() {
            return Some(value);
        }
        // So that nothing is told of what it decides.
        let mut all = Vec::new();
        let values = &self.slots[slot];
        leaves(values, &[], &mut Vec::new(), VENDOR_VALUES, &mut all);
        for cell in &all {
            self.put(slot, cell, Value::Whole(0));
        }
        let (writes, write) = match kind {
            Kind::Bits(8, _) => ("bytes", "`uint8_t`"),
            _ => ("numbers of the type in this cast", "that type"),
        };
        let message =
            format!("`{name}` writes {writes}, but the elements of `{array}` have another size");
        let help = format!(
            "declare `{array}` as an array of {write}, and combine its elements into larger numbers"
        );
        self.error(
            it.place,
            message,
            "cast to a pointer to another type",
            &help,
        );
        None
    }

    /// A value that is given to what reads or writes memory, whatever type it is seen as.
    pub(in crate::program::vendor) fn raw(&mut self, it: &Expr) -> Value {
        match &it.node {
            ExprNode::Recast(_, of) => self.raw(of),
            _ => self.value(it),
        }
    }

    /// `memset`, `memcpy` and `memmove`; nothing where not all is known of them.
    pub(super) fn memory(&mut self, name: &str, values: &[Value]) -> Option<Value> {
        let [Value::Pointer(slot, path, _), from, bytes] = values else {
            return None;
        };
        let cells = self.cells(*slot, path, bytes.whole()?)?;
        let kinds = cells.iter().map(|it| self.kind_at(*slot, it));
        let written: Option<Vec<Value>> = match (name, from) {
            ("memset", byte) => {
                let byte = byte.whole()? as u8;
                kinds.map(|kind| repeated(byte, kind)).collect()
            }
            (_, Value::Pointer(source, path, _)) => {
                let sources = self.cells(*source, path, bytes.whole()?)?;
                let same = kinds.eq(sources.iter().map(|it| self.kind_at(*source, it)));
                let values = sources.iter().map(|it| self.at(*source, it));
                same.then(|| values.collect())
            }
            _ => None,
        };
        for (cell, value) in cells.iter().zip(written?) {
            self.put(*slot, cell, value);
        }
        Some(values[0].clone())
    }

    /// The numbers that so many bytes hold from a place on.
    fn cells(&self, slot: Slot, path: &[usize], bytes: i64) -> Option<Vec<Vec<usize>>> {
        let most = usize::try_from(bytes).ok()?.min(VENDOR_VALUES);
        let mut all = Vec::new();
        leaves(&self.slots[slot], path, &mut Vec::new(), most, &mut all);
        self.passes(2 * all.len());
        // A whole object, or a whole array of them: between its members may lie unused bytes.
        let held = self.at(slot, path);
        if shape::size(&held, self.kind_at(slot, path)).map(|it| it.0) == Some(bytes) {
            let mut own = Vec::new();
            leaves(&held, &[], &mut Vec::new(), most, &mut own);
            all.truncate(own.len());
            return Some(all);
        }
        let (mut left, mut count) = (bytes, 0);
        while left > 0 {
            let (value, kind) = (
                self.at(slot, all.get(count)?),
                self.kind_at(slot, &all[count]),
            );
            left -= shape::size(&value, kind)?.0;
            count += 1;
        }
        all.truncate(count);
        (left == 0).then_some(all)
    }

    /// Which variables a name, a pointer or a lambda leads to.
    pub(in crate::program::vendor) fn alive(&self) -> Vec<bool> {
        let mut alive = vec![false; self.slots.len()];
        let mut open: Vec<Slot> = self
            .scopes
            .iter()
            .flat_map(|it| it.values().copied())
            .collect();
        open.push(GAIN);
        open.extend(self.lasting.values());
        if let Some(stack) = &self.stack {
            leads_to(stack, &mut open);
        }
        while let Some(slot) = open.pop() {
            // Frames are run anew with fewer variables: a pointer may lead to none.
            if let Some(it @ false) = alive.get_mut(slot) {
                *it = true;
                leads_to(&self.slots[slot], &mut open);
            }
        }
        alive
    }

    /// Gives up variables that no name, no pointer and no lambda leads to.
    pub(in crate::program::vendor) fn give_up(&mut self) {
        let Some(companion) = self.companion.as_mut() else {
            return;
        };
        if self.slots.len() - self.free.len() < companion.enough {
            return;
        }
        let alive = self.alive();
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

/// A number all of whose bytes are this one; nothing for real ones, but 0.
fn repeated(byte: u8, kind: Kind) -> Option<Value> {
    match kind {
        Kind::Float | Kind::Real => (byte == 0).then_some(Value::Real(0.0).converted(kind)),
        Kind::Any if byte > 0 => None,
        _ => Some(Value::Whole(i64::from_ne_bytes([byte; 8])).converted(kind)),
    }
}

/// The variables that a value leads to.
fn leads_to(value: &Value, all: &mut Vec<Slot>) {
    match value {
        Value::Pointer(slot, ..) | Value::Back(slot, ..) | Value::Reference(slot, _) => {
            all.push(*slot);
        }
        Value::List(values) | Value::Record(_, values) => {
            for value in values {
                leads_to(value, all);
            }
        }
        Value::Lambda(function) => all.extend(function.held.iter().map(|it| it.1)),
        Value::Whole(_)
        | Value::Wide(..)
        | Value::Real(_)
        | Value::Single(_)
        | Value::Unknown(_)
        | Value::Symbol(_)
        | Value::Symbols(_)
        | Value::Text(_)
        | Value::Random(..) => {}
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
