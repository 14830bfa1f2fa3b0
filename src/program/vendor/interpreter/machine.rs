//! The micro-controller: its variables, and what it has asked of the array so far.

use std::{
    cell::Cell,
    collections::{BTreeMap, BTreeSet},
    rc::Rc,
};

use super::{
    layout::Layout,
    reason::Reason,
    value::{Slot, Value},
};
use crate::{
    config::{Fault, Place, Severity, enough},
    isa::Device,
    limit::{CHAIN, NESTING, VENDOR_VALUES, VENDOR_WORK},
    program::{
        Overrides,
        syntax::Item,
        vendor::{
            frame::beside::Companion,
            lexer::source_map::Files,
            syntax::tree::{Function, Kind, Read, Recorded, TemplateArgument, Word, Words},
        },
    },
};

/// A statement takes about as long as copying so many values.
const STATEMENT: usize = 32;

/// Statements and values inside each other, in all functions that run, for which there is room on the
/// stack: one chain of calls, and what stands around it.
const LEVELS: usize = CHAIN + 4 * NESTING;

/// How many values all variables hold, as a multiple of what one may hold.
const VARIABLES: usize = 4;

/// After how many values that were put into variables those are counted.
const COUNTED: usize = VENDOR_VALUES / 4;

/// A part of the text that is looked at takes about as long as copying so many values.
const PART: usize = 4;

/// The slider of the gain, which every program has.
pub(in crate::program::vendor) const GAIN: Slot = 0;

/// Where a value lies: a variable, and the way to an element of it.
pub(in crate::program::vendor) type Location = (Slot, Vec<usize>);

/// How control goes on.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::program::vendor) enum Flow {
    Next,
    Break,
    Continue,
    Return(Value),
    /// The frames have been run: nothing comes after them.
    End,
}

/// A kernel whose words are being recorded.
pub(in crate::program::vendor) struct Recording {
    /// Where it begins.
    pub place: Place,
    /// The words so far.
    pub words: Vec<Item>,
    /// Whether they go to the memory of the micro-controller.
    pub heap: bool,
}

#[expect(clippy::struct_excessive_bools, reason = "each is a flag of its own")]
pub(in crate::program::vendor) struct Machine<'a> {
    pub text: &'a str,
    pub files: &'a Files,
    pub device: &'a Device,
    pub overrides: &'a Overrides,
    pub faults: Vec<Fault>,
    /// Files that are asked for and are not there.
    pub missing: Vec<String>,
    /// What only the run decides: faults where the program has to be known before.
    pub undecided: Vec<Fault>,
    /// The array, where the host runs beside it.
    pub companion: Option<Companion<'a>>,
    /// What can be set from outside, with its value.
    pub constants: BTreeMap<String, f64>,
    pub functions: BTreeMap<Word, Vec<Rc<Function>>>,
    /// Functions of classes.
    pub members: BTreeMap<Word, Vec<Rc<Function>>>,
    /// Functions as they are declared, for their default arguments.
    pub prototypes: BTreeMap<Word, Vec<Rc<Function>>>,
    /// Where variables of the file are declared.
    pub homes: BTreeMap<Word, Place>,
    pub slots: Vec<Value>,
    /// Variables that were given up.
    pub free: Vec<Slot>,
    /// The types of the variables, or of their elements.
    pub kinds: Vec<Kind>,
    /// Arrays that are copied with their name, as those of the language's library.
    pub copied: BTreeSet<Slot>,
    /// The classes of the elements of arrays.
    pub classes: BTreeMap<Slot, Word>,
    /// Bodies that a template has for some of what it is given.
    pub specials: BTreeMap<Word, Vec<Rc<Function>>>,
    /// Classes whose members are known.
    pub layouts: BTreeMap<Word, Rc<Layout>>,
    /// Enumerations, with the type of their numbers.
    pub enumerations: BTreeMap<Word, Kind>,
    /// Classes that are not supported: what they are, and where.
    pub unread: BTreeMap<Word, String>,
    /// Variables of types that are not supported: why nothing is known of them.
    pub not_followed: BTreeMap<Slot, Reason>,
    /// Whether the function that runs gives back a variable itself.
    pub refers: bool,
    /// How many calls are being worked out, one in the arguments of another.
    pub calls: usize,
    /// The variable that a call gave back, with how many there were around it. Places do not tell calls
    /// apart: all those of a macro have one.
    pub referred: Option<(usize, Location)>,
    /// The types that the template which runs was given, by position.
    pub types: Vec<Kind>,
    /// What the template that runs is made for; nothing where that is not known.
    pub made: Option<String>,
    /// What stands in `<…>` before the call that comes next.
    pub angles: Option<Vec<TemplateArgument>>,
    /// Variables that change from frame to frame, and were given one value for good.
    pub fixed: BTreeSet<Slot>,
    /// Scopes of names; those below `base` belong to callers, but for the first, the file's.
    pub scopes: Vec<BTreeMap<Word, Slot>>,
    pub base: usize,
    /// The namespace that is worked in.
    pub space: Word,
    /// Names of variables that are declared in several namespaces.
    pub ambiguous: BTreeSet<Word>,
    /// The file that is worked in: nothing for the program's own.
    pub file: Option<&'a str>,
    /// Variables that a file has for itself under a name that another file has too.
    pub apart: BTreeMap<(Option<&'a str>, Word), Slot>,
    /// Variables that are made once, by the place of their declaration, and by what the template is
    /// made for that they stand in.
    pub lasting: BTreeMap<(usize, String), Slot>,
    /// What was asked of the array since the last frame began.
    pub items: Vec<Item>,
    /// What was asked in earlier frames.
    pub frames: Vec<Vec<Item>>,
    pub recording: Option<Recording>,
    /// Whether there was one so far.
    pub kernels: bool,
    /// Kernels that ran, and functions, by where they begin.
    pub ran: BTreeSet<(usize, usize)>,
    pub entered: BTreeSet<usize>,
    /// Places at which texts were posted that nobody was shown.
    pub unshown: BTreeSet<usize>,
    /// Kernels that are `static` and were launched.
    pub recorded: BTreeMap<Recorded, Words>,
    /// What was read of variables while kernels were recorded, with the values that it had.
    pub read: Vec<Rc<[(Read, Value)]>>,
    /// Whether some earlier statement may have ended this block: why.
    pub maybe: Option<Reason>,
    /// How often a statement may have ended a loop or a function.
    pub left: usize,
    pub depth: usize,
    /// How many statements, values and calls are worked out, one inside the other.
    levels: usize,
    /// The slider that was read last.
    pub slider: String,
    /// The variable that is being declared.
    pub naming: Option<Word>,
    /// What is shown, by its line: the display's title.
    pub titles: BTreeMap<String, BTreeSet<String>>,
    /// Buffers that events were read into, by the names that programs have for them.
    pub scanned: BTreeMap<String, String>,
    /// The row and the column that were selected last, which masks go with.
    pub selected: [Option<Value>; 2],
    /// The display that a stack of bits goes to.
    pub stack: Option<Value>,
    /// Whether a statement has reset the photodiodes in the frame that is worked on.
    pub dark: bool,
    /// Whether the loop over the frames was run.
    pub looped: bool,
    /// Whether something in an iteration of it may end it.
    pub ends: bool,
    /// Whether every frame does the same, the first one too.
    pub bare: bool,
    /// What was worked on, in values that are copied.
    work: Cell<usize>,
    /// Where the last statement or call was worked on.
    worked: Place,
    /// How many values were put into variables since those were counted.
    grown: usize,
    /// How many statements were asked since what was asked ran.
    pub asked: usize,
    /// Whether a limit was met.
    pub full: bool,
}

impl<'a> Machine<'a> {
    pub(in crate::program::vendor) fn new(
        text: &'a str,
        files: &'a Files,
        device: &'a Device,
        overrides: &'a Overrides,
    ) -> Self {
        Self {
            text,
            files,
            device,
            overrides,
            faults: Vec::new(),
            missing: Vec::new(),
            undecided: Vec::new(),
            companion: None,
            constants: BTreeMap::new(),
            functions: BTreeMap::new(),
            members: BTreeMap::new(),
            prototypes: BTreeMap::new(),
            fixed: BTreeSet::new(),
            homes: BTreeMap::new(),
            slots: vec![Value::Whole(1)],
            free: Vec::new(),
            kinds: vec![Kind::INT],
            copied: BTreeSet::new(),
            classes: BTreeMap::new(),
            specials: BTreeMap::new(),
            layouts: BTreeMap::new(),
            enumerations: BTreeMap::new(),
            unread: BTreeMap::new(),
            not_followed: BTreeMap::new(),
            refers: false,
            calls: 0,
            referred: None,
            types: Vec::new(),
            made: Some(String::new()),
            angles: None,
            scopes: vec![BTreeMap::new()],
            base: 0,
            space: "".into(),
            ambiguous: BTreeSet::new(),
            file: None,
            apart: BTreeMap::new(),
            lasting: BTreeMap::new(),
            items: Vec::new(),
            frames: Vec::new(),
            recording: None,
            kernels: false,
            ran: BTreeSet::new(),
            entered: BTreeSet::new(),
            unshown: BTreeSet::new(),
            recorded: BTreeMap::new(),
            read: Vec::new(),
            maybe: None,
            left: 0,
            depth: 0,
            levels: 0,
            slider: String::new(),
            naming: None,
            titles: BTreeMap::new(),
            scanned: BTreeMap::new(),
            selected: [None, None],
            stack: None,
            dark: false,
            looped: false,
            ends: false,
            bare: false,
            work: Cell::new(0),
            worked: Place::default(),
            grown: 0,
            asked: 0,
            full: false,
        }
    }

    pub(in crate::program::vendor) fn fault(&mut self, fault: Fault) {
        once(&mut self.faults, fault);
    }

    /// Tells what only the run decides: a fault of a program that has to be known before.
    pub(in crate::program::vendor) fn undecided(&mut self, fault: Fault) {
        match &self.companion {
            None => once(&mut self.undecided, fault),
            // What follows from an end is none.
            Some(companion) if companion.over => {}
            Some(_) => self.fault(fault),
        }
    }

    pub(in crate::program::vendor) fn error(
        &mut self,
        place: Place,
        message: String,
        label: &str,
        help: &str,
    ) {
        self.fault(Fault::error(place, message, label).help(help));
    }

    /// Whether there is no use in going on.
    pub(in crate::program::vendor) fn done(&self) -> bool {
        let is_error = |it: &Fault| it.severity == Severity::Error;
        // Beside the array, what is wrong in a frame ends the run there.
        let over = |it: &Companion<'_>| it.over || self.faults.iter().any(is_error);
        let over = self.companion.as_ref().is_some_and(over);
        over || self.full || enough(&self.faults) || enough(&self.undecided)
    }

    /// What was asked runs: as much may be asked again.
    pub(in crate::program::vendor) const fn asks_anew(&mut self) {
        self.asked = 0;
    }

    /// A frame may be as much work as the one before.
    pub(in crate::program::vendor) fn works_anew(&mut self) {
        self.work.set(0);
    }

    /// So many values are copied or looked through; the next statement tells where that is too
    /// much.
    pub(in crate::program::vendor) fn passes(&self, values: usize) {
        self.work.set(self.work.get().saturating_add(values));
    }

    /// So many parts of the text are looked at, without running them.
    pub(in crate::program::vendor) fn looks(&self, parts: usize) {
        self.passes(PART.saturating_mul(parts));
    }

    /// One more statement or call is worked on.
    pub(in crate::program::vendor) fn work(&mut self, place: Place) {
        self.passes(STATEMENT);
        self.worked = place;
        if self.work.get() > STATEMENT * VENDOR_WORK && !self.full {
            self.full = true;
            let before = match self.companion {
                Some(_) => "run in one frame",
                None => "run before the program is known",
            };
            let slider = match &*self.slider {
                "" => "NAME",
                name => name,
            };
            let help = format!(
                "loop bounds must be known before the run, and a copy of a large array counts as many statements; `--const {slider}=VALUE` ends a loop that waits for the GUI"
            );
            self.error(
                place,
                format!("more than {VENDOR_WORK} statements {before}"),
                "the limit is reached here",
                &help,
            );
        }
    }

    /// Does what is one level deeper; nothing, and tells of it, where there are too many.
    pub(super) fn deeper<T>(
        &mut self,
        place: Place,
        inner: impl FnOnce(&mut Self) -> T,
    ) -> Option<T> {
        if self.levels == LEVELS {
            if !self.full {
                self.full = true;
                self.error(
                    place,
                    format!("more than {LEVELS} nested statements and expressions, calls included"),
                    "too deep",
                    "if a function calls itself, write a loop instead; otherwise split it up",
                );
            }
            return None;
        }
        self.levels += 1;
        let done = inner(self);
        self.levels -= 1;
        Some(done)
    }

    /// So many values were put into variables; tells where there are too many.
    pub(in crate::program::vendor) fn grows(&mut self, values: usize) {
        self.grown = self.grown.saturating_add(values);
        if self.grown < COUNTED || self.full {
            return;
        }
        self.grown = 0;
        let most = VARIABLES * VENDOR_VALUES;
        let (mut one, mut all) = (0, 0);
        // What nothing leads to any more is nobody's.
        let alive = self.slots.iter().zip(self.alive()).filter(|it| it.1);
        for (value, _) in alive {
            let held = value.held();
            one = held.max(one);
            all += held;
        }
        let message = if one > VENDOR_VALUES {
            format!("more than {VENDOR_VALUES} values in one variable")
        } else if all > most {
            format!("more than {most} values in all variables")
        } else {
            return;
        };
        self.full = true;
        self.error(
            self.worked,
            message,
            "here it grows",
            "keep fewer of them: no chip reads out as many",
        );
    }

    /// Whether so many values may be held in one variable; tells where they may not.
    pub(in crate::program::vendor) fn fits(&mut self, values: usize, place: Place) -> bool {
        if values > VENDOR_VALUES {
            self.error(
                place,
                format!("more than {VENDOR_VALUES} values in one variable"),
                "this declaration",
                "give it fewer elements: no chip reads out as many",
            );
        }
        values <= VENDOR_VALUES
    }
}

/// Adds a fault, once: a loop would tell it in every iteration.
fn once(faults: &mut Vec<Fault>, fault: Fault) {
    let known = |it: &Fault| it.message == fault.message && it.place.start == fault.place.start;
    if !faults.iter().any(known) {
        faults.push(fault);
    }
}
