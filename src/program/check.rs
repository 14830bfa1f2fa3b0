//! Static checks of a program: FLAG, values destroyed as scratch, and the size of the kernel store.

use std::collections::{BTreeMap, BTreeSet};

use super::{
    effect::FlagState,
    expand::{Entry, Expanded, Expansion, for_each},
};
use crate::{
    config::{Fault, Place},
    isa::{Bit, Cell, Device, Figure, Source, Value},
    limit::FAULTS,
};

/// Adds the faults of an expanded program.
pub(super) fn check(expansion: &Expansion, device: &Device, faults: &mut Vec<Fault>) {
    let mut walk = Walk {
        device,
        partial: None,
        destroyed: BTreeMap::new(),
        faults: Vec::new(),
    };
    walk.entries(&expansion.init, true);
    walk.entries(&expansion.frame, true);
    walk.carried(&expansion.frame);
    if !expansion.bare {
        // The next frame starts with the state that this one leaves.
        walk.entries(&expansion.frame, false);
    }
    faults.append(&mut walk.faults);
    store(expansion, device, faults);
}

/// Warns of registers that are read and that nothing in the program writes: masks and directions that
/// are 0 everywhere make an instruction do nothing, in silence, and so does a picture that nobody took.
pub(super) fn unwritten(
    expansion: &Expansion,
    device: &Device,
    told: impl Fn(&Cell) -> bool,
) -> Vec<Fault> {
    let mut faults = Vec::new();
    let (mut read, mut written) = (BTreeMap::new(), BTreeSet::new());
    let mut see = |statement: &Expanded| {
        for cell in &statement.effect.reads {
            read.entry(*cell)
                .or_insert_with(|| (Spot::new(statement), named(statement, *cell, device)));
        }
        written.extend(statement.effect.writes.iter().copied());
    };
    for_each(&expansion.init, &mut see);
    for_each(&expansion.frame, &mut see);
    for (cell, (spot, name)) in read {
        let way = match cell {
            Cell::Digital(_) => format!("`SET({name});`"),
            Cell::Analog(_) => format!("`get_image({name}, F);`, or `scamp5_in({name}, 0);`"),
            Cell::Flag => continue,
        };
        if written.contains(&cell) || !told(&cell) {
            continue;
        }
        let message = format!("nothing in this program writes {name}: it is 0 everywhere");
        let label = format!("`{}` reads {name}", spot.name);
        let help = format!("write it first, as by {way}");
        let fault = Fault::warning(spot.place, message, label).help(help);
        faults.push(fault.written(spot.origin.as_deref()));
    }
    faults
}

impl Expansion {
    /// Drops the warnings that nothing writes a register, of those that are set before the program runs.
    pub fn drop_unwritten(&mut self, device: &Device, is_set: impl Fn(&Cell) -> bool) {
        let of_these = unwritten(self, device, is_set);
        self.warnings.retain(|it| !of_these.contains(it));
    }
}

/// The name that a statement has for what it reads.
fn named(statement: &Expanded, cell: Cell, device: &Device) -> String {
    let words = statement
        .text
        .split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
    let is_it = |word: &&str| match device.value_of(word) {
        Some(Value::Source(Source::Register(it))) => cell == Cell::Analog(it),
        Some(Value::Bit(Bit::Register(it))) => cell == Cell::Digital(it),
        _ => false,
    };
    let found = { words }.find(is_it);
    found.map_or_else(|| cell.name(device), str::to_owned)
}

/// A statement, for messages.
#[derive(Clone, Debug)]
struct Spot {
    name: String,
    place: Place,
    /// Its line, in words.
    stands: String,
    /// Where it is written, if that is another file.
    origin: Option<String>,
}

impl Spot {
    fn new(statement: &Expanded) -> Self {
        Self {
            name: statement.name.clone(),
            place: statement.place,
            stands: statement.stands(),
            origin: statement.origin.clone(),
        }
    }
}

struct Walk<'a> {
    device: &'a Device,
    /// The statement after which FLAG may be 0 somewhere.
    partial: Option<Spot>,
    /// The statement that overwrote each cell as scratch.
    destroyed: BTreeMap<Cell, Spot>,
    faults: Vec<Fault>,
}

impl Walk<'_> {
    /// Checks entries in order. The body of a repeat is walked twice, so that what one pass leaves
    /// to the next is seen, but only on the first visit: what a body leaves of earlier state does
    /// not depend on how often it runs, so a later visit brings nothing that its first pass does
    /// not show. So nested repeats cost the sum of their passes, not the product.
    fn entries(&mut self, entries: &[Entry], first: bool) {
        for entry in entries {
            match entry {
                Entry::Statement(statement) => self.statement(statement),
                Entry::Repeat { times: 0, .. } => {}
                Entry::Repeat { times, body, .. } => {
                    self.entries(body, first);
                    if first && *times > 1 {
                        self.entries(body, false);
                    }
                }
            }
        }
    }

    fn statement(&mut self, statement: &Expanded) {
        self.flag(statement);
        for cell in &statement.effect.reads {
            if let Some(spot) = self.destroyed.get(cell) {
                let fault = lost(&cell.name(self.device), spot, statement);
                self.report(fault);
            }
        }
        match statement.effect.flag {
            Some(FlagState::Whole) => self.partial = None,
            Some(FlagState::Partial) => self.partial = Some(Spot::new(statement)),
            None => {}
        }
        for cell in statement.destroys().filter(|cell| *cell != Cell::Flag) {
            self.destroyed.insert(cell, Spot::new(statement));
        }
        for cell in &statement.results {
            if statement.effect.writes.contains(cell) {
                self.destroyed.remove(cell);
            }
        }
    }

    /// Warns of a frame that leaves FLAG 0 somewhere to the next, which stores before it sets FLAG.
    fn carried(&mut self, frame: &[Entry]) {
        let Some(spot) = self.partial.clone() else {
            return;
        };
        let (mut is_set, mut stores) = (false, None);
        for_each(frame, &mut |statement: &Expanded| {
            let masked = statement
                .effect
                .writes
                .iter()
                .any(|cell| matches!(cell, Cell::Analog(_)));
            if masked && !is_set && !statement.whole_flag && stores.is_none() {
                stores = Some((statement.place, statement.origin.clone()));
            }
            // Where FLAG must be 1 everywhere, that is told of the statement itself.
            is_set |= statement.effect.flag.is_some() || statement.whole_flag;
        });
        if let Some((place, origin)) = stores {
            let message = format!(
                "FLAG may still be 0 in some pixels at the end of the frame, since `{}` in {}, and the next frame stores only where it is 1",
                spot.name, spot.stands
            );
            let fault = Fault::warning(place, message, "in later frames this skips pixels");
            let fault = fault.also(spot.place, "FLAG may be 0 after this");
            let fault = fault.help("end the frame with `all();`");
            self.report(fault.written(origin.as_deref()));
        }
    }

    fn flag(&mut self, statement: &Expanded) {
        let Some(spot) = self.partial.clone() else {
            return;
        };
        let (name, stands) = (&statement.name, statement.stands());
        let since = format!("since `{}` in {}", spot.name, spot.stands);
        if statement.whole_flag {
            let fault = Fault::warning(
                statement.place,
                format!(
                    "`{name}` needs FLAG to be 1 in all pixels, but it may be 0 in some, {since}"
                ),
                "in two steps a value passes a pixel that may be off",
            )
            .also(spot.place, "FLAG may be 0 after this")
            .help("call `all();` first, or use two one-step transfers");
            self.report(statement.told(fault));
        }
        let destroys_flag = statement.destroys().any(|cell| cell == Cell::Flag);
        if destroys_flag {
            let fault = Fault::warning(
                statement.place,
                format!(
                    "`{name}` in {stands} overwrites the FLAG that `{}` in {} set",
                    spot.name, spot.stands
                ),
                "it sets FLAG itself and leaves it 1 everywhere",
            )
            .also(spot.place, "this FLAG is lost")
            .help("put it before the `where`, into a register that the region then uses");
            self.report(statement.told(fault));
        }
    }

    /// Reports a fault once; the second pass would report it again.
    fn report(&mut self, fault: Fault) {
        let alike = self.faults.iter().filter(|f| f.severity == fault.severity);
        if alike.count() > FAULTS {
            return;
        }
        let known = |f: &Fault| f.message == fault.message && f.place.start == fault.place.start;
        if !self.faults.iter().any(known) {
            self.faults.push(fault);
        }
    }
}

fn lost(register: &str, spot: &Spot, reader: &Expanded) -> Fault {
    Fault::warning(
        reader.place,
        format!(
            "{} needs {register}, which `{}` in {} overwrote as scratch",
            reader.stands(),
            spot.name,
            spot.stands
        ),
        format!("reads {register}"),
    )
    .also(spot.place, format!("overwrites {register}"))
    .help(format!(
        "keep the value in another register, or set {register} again in between"
    ))
}

/// The words of all kernels together must fit into the chip's store.
fn store(expansion: &Expansion, device: &Device, faults: &mut Vec<Fault>) {
    let room = device.value(Figure::Store) as u64;
    let (words, over) = expansion.fills(device, room);
    if let Some(place) = over {
        faults.push(
            Fault::error(
                place,
                format!(
                    "the program has {words} instruction words, {} more than the {room} that {} holds",
                    words - room,
                    device.name()
                ),
                "from here on it does not fit",
            )
            .help("`repeat N { … }` stores its body once; a wider chip can be tried with --chip"),
        );
    }
}
