//! Static checks of a program: FLAG, values destroyed as scratch, and the size of the kernel store.

use std::collections::{BTreeMap, BTreeSet};

use super::{
    cost,
    effect::FlagState,
    expand::{Entry, Expanded, Expansion, for_each},
};
use crate::{
    config::{Fault, Place},
    isa::{Cell, Device, Figure},
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
    if !expansion.bare {
        faults.extend(unwritten(expansion, device));
    }
    store(expansion, device, faults);
}

/// Warns of one-bit registers that are read and that nothing in the program writes: masks and
/// directions that are 0 everywhere make an instruction do nothing, in silence.
pub(super) fn unwritten(expansion: &Expansion, device: &Device) -> Vec<Fault> {
    let mut faults = Vec::new();
    let (mut read, mut written) = (BTreeMap::new(), BTreeSet::new());
    let mut see = |statement: &Expanded| {
        for cell in &statement.effect.reads {
            read.entry(*cell).or_insert_with(|| Spot::new(statement));
        }
        written.extend(statement.effect.writes.iter().copied());
    };
    for_each(&expansion.init, &mut see);
    for_each(&expansion.frame, &mut see);
    for (cell, spot) in read {
        if matches!(cell, Cell::Digital(_)) && !written.contains(&cell) {
            let register = cell.name(device);
            let message = format!("nothing in this program writes {register}: it is 0 everywhere");
            let label = format!("`{}` reads {register}", spot.name);
            let help = format!("write it first, as by `SET({register});`");
            faults.push(Fault::warning(spot.place, message, label).help(help));
        }
    }
    faults
}

/// A statement, for messages.
#[derive(Clone, Debug)]
struct Spot {
    name: String,
    place: Place,
    line: u32,
}

impl Spot {
    fn new(statement: &Expanded) -> Self {
        Self {
            name: statement.name.clone(),
            place: statement.place,
            line: statement.line,
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
                stores = Some(statement.place);
            }
            // Where FLAG must be 1 everywhere, the next frame is an error.
            is_set |= statement.effect.flag.is_some() || statement.whole_flag;
        });
        if let Some(place) = stores {
            let message = format!(
                "FLAG may be 0 somewhere when the frame ends, since `{}` in line {}, and the next one stores only where it is 1",
                spot.name, spot.line
            );
            let fault = Fault::warning(place, message, "in later frames this skips pixels");
            let fault = fault.also(spot.place, "FLAG may be 0 after this");
            self.report(fault.help("end the frame with `all();`"));
        }
    }

    fn flag(&mut self, statement: &Expanded) {
        let Some(spot) = self.partial.clone() else {
            return;
        };
        let (name, line) = (&statement.name, statement.line);
        let since = format!("since `{}` in line {}", spot.name, spot.line);
        if statement.whole_flag {
            let fault = Fault::error(
                statement.place,
                format!("`{name}` needs FLAG to be 1 everywhere, which it may not be {since}"),
                "in two steps a value passes a pixel that may be off",
            )
            .also(spot.place, "FLAG may be 0 after this")
            .help("call `all();` first, or use two one-step transfers");
            self.report(fault);
        }
        let destroys_flag = statement.destroys().any(|cell| cell == Cell::Flag);
        if destroys_flag {
            let fault = Fault::warning(
                statement.place,
                format!(
                    "`{name}` in line {line} overwrites the FLAG that `{}` in line {} set",
                    spot.name, spot.line
                ),
                "it sets FLAG itself and leaves it 1 everywhere",
            )
            .also(spot.place, "this FLAG is lost")
            .help("put it before the `where`, into a register that the region then uses");
            self.report(fault);
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
            "line {} needs {register}, which `{}` in line {} overwrote as scratch",
            reader.line, spot.name, spot.line
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
    let (mut words, mut over) = (0, None);
    let mut add = |statement: &Expanded| {
        // The host's own kernels are not the program's.
        if !statement.host {
            words += cost::stored(&statement.steps, device).0;
            if words > room {
                over.get_or_insert(statement.place);
            }
        }
    };
    for_each(&expansion.init, &mut add);
    for_each(&expansion.frame, &mut add);
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
