//! The micro-controller: its variables, and what it has asked of the array so far.

use std::{
    cell::Cell,
    collections::{BTreeMap, BTreeSet},
    rc::Rc,
    sync::Arc,
};

use super::{
    beside::Companion,
    files::Files,
    look,
    tree::{Expr, Function, Kind, TemplateArgument, Word, last, qualifier},
    value::{Layout, Slot, Value},
};
use crate::{
    config::{Fault, Place, Severity, enough},
    isa::{
        Callable, Device,
        text::{Argument, Expression, Statement, Term},
    },
    limit::{VENDOR_VALUES, VENDOR_WORK},
    program::{
        Overrides,
        syntax::{Item, Node},
    },
};

/// A statement takes about as long as copying so many values.
const STATEMENT: usize = 32;

/// A part of the text that is looked at takes about as long as copying so many values.
const PART: usize = 4;

/// Frames that are laid out one after the other, where no loop over the frames is.
const FRAMES: usize = 64;

/// Statements that may be asked of the array.
const ASKED: usize = crate::limit::EXPANDED_STEPS;

/// The slider of the gain, which every program has.
pub(super) const GAIN: Slot = 0;

/// Where a value lies: a variable, and the way to an element of it.
pub(super) type Spot = (Slot, Vec<usize>);

/// How control goes on.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Flow {
    Next,
    Break,
    Continue,
    Return(Value),
    /// The frames have been run: nothing comes after them.
    End,
}

/// A kernel that is being written.
pub(super) struct Kernel {
    /// Where it begins.
    pub place: Place,
    /// Which of those it is that begin there, as those of a macro do.
    pub ordinal: i64,
    /// Whether its words are kept from the first launch.
    pub fixed: bool,
    /// How many items there were when it began.
    pub start: usize,
}

#[expect(clippy::struct_excessive_bools, reason = "each is a flag of its own")]
pub(super) struct Machine<'a> {
    pub text: &'a str,
    pub files: &'a Files,
    pub device: &'a Device,
    pub overrides: &'a Overrides,
    pub faults: Vec<Fault>,
    /// What only the run decides: faults where the program has to be known before.
    pub undecided: Vec<Fault>,
    /// The array, where the host runs beside it.
    pub companion: Option<Companion<'a>>,
    /// What can be set from outside, with its value.
    pub constants: BTreeMap<String, f64>,
    pub functions: BTreeMap<Word, Vec<Rc<Function>>>,
    /// Functions of classes.
    pub members: BTreeMap<Word, Vec<Rc<Function>>>,
    /// Functions as they are announced, for their default arguments.
    pub prototypes: BTreeMap<Word, Vec<Rc<Function>>>,
    /// Where variables of the file are stated.
    pub homes: BTreeMap<Word, Place>,
    pub slots: Vec<Value>,
    /// Variables that were given up.
    pub free: Vec<Slot>,
    /// The types of the variables, or of their elements.
    pub kinds: Vec<Kind>,
    /// Arrays that are copied with their name, as those of the language's library.
    pub copied: BTreeSet<Slot>,
    /// Classes whose members are known.
    pub layouts: BTreeMap<Word, Rc<Layout>>,
    /// The types that the template which runs was given, by position.
    pub types: Vec<Kind>,
    /// What stands in `<…>` before the call that comes next.
    pub angles: Option<Vec<TemplateArgument>>,
    /// Variables that change from frame to frame, and were given one value for good.
    pub fixed: BTreeSet<Slot>,
    /// Scopes of names; those below `base` belong to callers, but for the first, the file's.
    pub scopes: Vec<BTreeMap<Word, Slot>>,
    pub base: usize,
    /// The namespace that is worked in.
    pub space: Word,
    /// Names of variables that are stated in several namespaces.
    pub ambiguous: BTreeSet<Word>,
    /// Variables that are made once, by the place of their declaration.
    pub lasting: BTreeMap<usize, Slot>,
    /// What was asked of the array since the last frame began.
    pub items: Vec<Item>,
    /// What was asked in earlier frames.
    pub frames: Vec<Vec<Item>>,
    pub kernel: Option<Kernel>,
    /// The words that kernels had, by where they begin.
    pub stored: BTreeMap<(usize, i64), Vec<Vec<Item>>>,
    /// Whether some earlier statement may have ended this block: why.
    pub maybe: Option<Arc<str>>,
    pub depth: usize,
    /// The variable that is being declared.
    pub naming: Option<Word>,
    /// What is shown, by its line: the display's title.
    pub titles: BTreeMap<u32, BTreeSet<String>>,
    /// Buffers that events were read into, by the names that programs have for them.
    pub scanned: BTreeMap<String, String>,
    /// The display that a stack of bits goes to.
    pub stack: Option<Value>,
    /// Whether light was captured, or the photodiodes were reset, in the frame that is worked on.
    pub dark: bool,
    /// Whether the loop over the frames was run.
    pub looped: bool,
    /// Whether every frame does the same, the first one too.
    pub bare: bool,
    /// What was worked on, in values that are copied.
    work: Cell<usize>,
    asked: usize,
    /// Whether a limit was met.
    pub full: bool,
}

impl<'a> Machine<'a> {
    pub(super) fn new(
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
            layouts: BTreeMap::new(),
            types: Vec::new(),
            angles: None,
            scopes: vec![BTreeMap::new()],
            base: 0,
            space: "".into(),
            ambiguous: BTreeSet::new(),
            lasting: BTreeMap::new(),
            items: Vec::new(),
            frames: Vec::new(),
            kernel: None,
            stored: BTreeMap::new(),
            maybe: None,
            depth: 0,
            naming: None,
            titles: BTreeMap::new(),
            scanned: BTreeMap::new(),
            stack: None,
            dark: false,
            looped: false,
            bare: false,
            work: Cell::new(0),
            asked: 0,
            full: false,
        }
    }

    pub(super) fn fault(&mut self, fault: Fault) {
        once(&mut self.faults, fault);
    }

    /// Tells what only the run decides: a fault of a program that has to be known before.
    pub(super) fn undecided(&mut self, fault: Fault) {
        match &self.companion {
            None => once(&mut self.undecided, fault),
            // What follows from an end is none.
            Some(companion) if companion.over => {}
            Some(_) => self.fault(fault),
        }
    }

    pub(super) fn error(&mut self, place: Place, message: String, label: &str, help: &str) {
        self.fault(Fault::error(place, message, label).help(help));
    }

    /// Whether there is no use in going on.
    pub(super) fn done(&self) -> bool {
        let is_error = |it: &Fault| it.severity == Severity::Error;
        // Beside the array, what is wrong in a frame ends the run there.
        let over = |it: &Companion<'_>| it.over || self.faults.iter().any(is_error);
        let over = self.companion.as_ref().is_some_and(over);
        over || self.full || enough(&self.faults) || enough(&self.undecided)
    }

    /// What was asked runs: as much may be asked again.
    pub(super) const fn asks_anew(&mut self) {
        self.asked = 0;
    }

    /// A frame may be as much work as the one before.
    pub(super) fn works_anew(&mut self) {
        self.work.set(0);
    }

    /// So many values are copied or looked through; the next statement tells where that is too
    /// much.
    pub(super) fn passes(&self, values: usize) {
        self.work.set(self.work.get().saturating_add(values));
    }

    /// So many parts of the text are looked at, without running them.
    pub(super) fn looks(&self, parts: usize) {
        self.passes(PART.saturating_mul(parts));
    }

    /// One more statement or call is worked on.
    pub(super) fn work(&mut self, place: Place) {
        self.passes(STATEMENT);
        if self.work.get() > STATEMENT * VENDOR_WORK && !self.full {
            self.full = true;
            let before = match self.companion {
                Some(_) => "run in one frame",
                None => "run before the program is known",
            };
            self.error(
                place,
                format!("more than {VENDOR_WORK} statements {before}"),
                "here there is no end in sight",
                "loops need bounds that are known before the run, and copies of large arrays count as many statements; a loop that waits for somebody at the GUI ends by `--const NAME=VALUE`",
            );
        }
    }

    /// Whether so many values may be held in one variable; tells where they may not.
    pub(super) fn fits(&mut self, values: usize, place: Place) -> bool {
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

    // ---- names ------------------------------------------------------------------------------

    pub(super) fn find(&self, name: &str) -> Option<Slot> {
        let file = self.scopes.first()?;
        match qualifier(name) {
            Some("") => return file.get(last(name)).copied(),
            Some(_) if foreign(name) => return None,
            Some(_) => {
                let own = self.scopes.get(self.base.max(1)..).unwrap_or_default();
                if let Some(slot) = own.iter().rev().find_map(|scope| scope.get(name)) {
                    return Some(*slot);
                }
                let spaces = self.spaces().map(|space| format!("{space}::{name}"));
                let found = spaces
                    .chain([name.to_owned()])
                    .find_map(|it| file.get(&*it));
                // A class or an enumeration, whose names are the file's.
                return found.copied().or_else(|| self.find(last(name)));
            }
            None => {}
        }
        let own = self.scopes.get(self.base.max(1)..).unwrap_or_default();
        let found = own.iter().rev().find_map(|scope| scope.get(name));
        let space = || {
            let mut spaces = self.spaces().map(|space| format!("{space}::{name}"));
            spaces.find_map(|it| file.get(&*it))
        };
        found.or_else(space).or_else(|| file.get(name)).copied()
    }

    /// The namespace that is worked in, and those around it.
    pub(super) fn spaces(&self) -> impl Iterator<Item = &str> {
        let first = Some(&*self.space).filter(|it| !it.is_empty());
        std::iter::successors(first, |it| qualifier(it))
    }

    /// The variables that a name means here or in some function.
    pub(super) fn find_all(&self, name: &str) -> BTreeSet<Slot> {
        let plain = last(name);
        let file = self.scopes.first().into_iter().flatten();
        let file = file.filter(|(it, _)| last(it) == plain);
        self.find(name)
            .into_iter()
            .chain(file.map(|it| *it.1))
            .collect()
    }

    pub(super) fn make(&mut self, name: &Word, value: Value, kind: Kind) -> Slot {
        let slot = self.hold(value, kind);
        self.bind(name, slot);
        slot
    }

    /// A new variable, without a name.
    pub(super) fn hold(&mut self, value: Value, kind: Kind) -> Slot {
        self.passes(value.size());
        let slot = self.free.pop().unwrap_or(self.slots.len());
        if slot == self.slots.len() {
            self.slots.push(value);
            self.kinds.push(kind);
        } else {
            self.slots[slot] = value;
            self.kinds[slot] = kind;
        }
        self.copied.remove(&slot);
        self.fixed.remove(&slot);
        slot
    }

    /// Binds a name to a variable, or to an element of one.
    pub(super) fn refer(&mut self, name: &Word, (slot, path): Spot) {
        if path.is_empty() {
            self.bind(name, slot);
        } else {
            self.make(name, Value::Reference(slot, path), Kind::Any);
        }
    }

    /// A type, with what a template is given in place of its parameter.
    pub(super) fn resolved(&self, kind: Kind) -> Kind {
        match kind {
            Kind::Parameter(at) => self.types.get(at).copied().unwrap_or(Kind::Any),
            kind => kind,
        }
    }

    /// The type of a variable, or of an element.
    pub(super) fn kind_at(&self, slot: Slot, path: &[usize]) -> Kind {
        let mut kind = self.kinds.get(slot).copied().unwrap_or(Kind::Any);
        let mut value = self.slots.get(slot);
        for index in path {
            value = match value {
                Some(Value::List(all)) => all.get(*index),
                Some(Value::Record(layout, all)) => {
                    kind = layout.members.get(*index).map_or(Kind::Any, |it| it.kind);
                    all.get(*index)
                }
                other => other,
            };
        }
        kind
    }

    pub(super) fn bind(&mut self, name: &Word, slot: Slot) {
        if let ([file], false) = (&mut self.scopes[..], self.space.is_empty()) {
            file.insert(format!("{}::{name}", self.space).into(), slot);
            // Others may mean it without its namespace, unless there are several.
            if self.ambiguous.contains(name) {
                return;
            }
            match file.get(name).copied() {
                None => {
                    file.insert(name.clone(), slot);
                }
                Some(known) => {
                    let spaced = |it: &(&Word, &Slot)| *it.1 == known && qualifier(it.0).is_some();
                    // One of the file itself keeps its name.
                    if file.iter().any(|it| spaced(&it)) {
                        file.remove(name);
                        self.ambiguous.insert(name.clone());
                    }
                }
            }
            return;
        }
        if let Some(scope) = self.scopes.last_mut() {
            scope.insert(name.clone(), slot);
        }
    }

    /// The value that is set from outside for this name, if it is.
    pub(super) fn set(&mut self, name: &str) -> Option<Value> {
        let value = *self.overrides.get(name)?;
        self.constants.insert(name.to_owned(), value);
        Some(Value::from_number(value))
    }

    /// What is set from outside must be a number that its variable can hold.
    pub(super) fn set_within(&mut self, name: &str, (set, kind): (&Value, Kind), place: Place) {
        let made = set.clone().converted(kind).number();
        if let (Some(asked), Some(made)) = (set.number(), made)
            && asked != made
            && !matches!(kind, Kind::Float)
        {
            self.error(
                place,
                format!("`{name}` is set to {asked}, of which its type makes {made}"),
                "its declaration",
                "give a number that this type holds",
            );
        }
    }

    pub(super) fn at(&self, slot: Slot, path: &[usize]) -> Value {
        let beyond = || Value::Unknown("what lies beyond an array".into());
        let value = self.peek(slot, path).cloned().unwrap_or_else(beyond);
        self.passes(value.size());
        value
    }

    /// The value that lies somewhere; `None` beyond an array or a variable.
    pub(super) fn peek(&self, slot: Slot, path: &[usize]) -> Option<&Value> {
        let mut value = &self.slots[slot];
        for index in path {
            value = match value {
                Value::List(all) | Value::Record(_, all) => all.get(*index)?,
                Value::Unknown(_) => return Some(value),
                // A pointer to one value.
                _ if *index == 0 => value,
                _ => return None,
            };
        }
        Some(value)
    }

    pub(super) fn put(&mut self, slot: Slot, path: &[usize], value: Value) {
        self.passes(value.size());
        if let Some(target) = self.target(slot, path) {
            *target = value;
        }
    }

    /// Where something can be written; `None` beyond an array, or where nothing is known for good.
    pub(super) fn target(&mut self, slot: Slot, path: &[usize]) -> Option<&mut Value> {
        if self.fixed.contains(&slot) {
            return None;
        }
        let mut target = &mut self.slots[slot];
        for index in path {
            match target {
                Value::List(all) | Value::Record(_, all) => target = all.get_mut(*index)?,
                Value::Unknown(_) => return None,
                _ => break,
            }
        }
        Some(target)
    }

    /// The array that a pointer leads into, the element that it leads to, and the array's length.
    pub(super) fn array_of<'p>(
        &self,
        slot: Slot,
        path: &'p [usize],
    ) -> Option<(&'p [usize], usize, usize)> {
        let (first, array) = path
            .split_last()
            .map_or((0, path), |(at, array)| (*at, array));
        match self.peek(slot, array) {
            Some(Value::List(all)) => Some((array, first, all.len())),
            _ => None,
        }
    }

    /// Forgets what lies where a pointer leads, and in its array behind that.
    pub(super) fn forget_from(&mut self, slot: Slot, path: &[usize], why: &Arc<str>) {
        let Some((array, first, length)) = self.array_of(slot, path) else {
            self.forget(slot, path, why);
            return;
        };
        for at in first..length {
            self.forget(slot, &[array, &[at]].concat(), why);
        }
    }

    /// Makes a value, and all that is in it, one that only the run knows.
    pub(super) fn forget(&mut self, slot: Slot, path: &[usize], why: &Arc<str>) {
        let value = self.at(slot, path);
        let value = blurred(value, why);
        self.put(slot, path, value);
    }

    /// Whether the host does this, outside of kernels.
    pub(super) fn is_host(&self, name: &str) -> bool {
        let all = self.device.callables(name);
        all.iter().any(|it| match it {
            Callable::Host(..) => true,
            Callable::Macro(it) => it.host,
            Callable::Primitive(..) => false,
        })
    }

    // ---- the array --------------------------------------------------------------------------

    pub(super) fn line(&self, place: Place) -> String {
        self.files.line(self.text, place)
    }

    /// Asks something of the array.
    pub(super) fn ask(&mut self, name: &str, arguments: Vec<Term>, place: Place) {
        if let Some(why) = self.maybe.clone() {
            let message = format!("whether `{name}` runs, {why} decides");
            self.unknown(place, message, None);
        }
        self.asked += 1;
        if self.asked > ASKED {
            if !self.full {
                self.full = true;
                self.error(
                    place,
                    format!("the program becomes more than {ASKED} statements"),
                    "here there is no room left",
                    "loop less often, or give loops outside of kernels the same body in every turn",
                );
            }
            return;
        }
        let origin = self.files.origin(place);
        let place = self.files.own(place);
        let arguments = arguments
            .into_iter()
            .map(|term| Argument::One(Expression { term, place }));
        self.push(
            Node::Statement(Statement {
                name: name.to_owned(),
                name_place: place,
                arguments: arguments.collect(),
                place,
                origin,
            }),
            place,
        );
    }

    /// Asks something whose arguments stand in braces.
    pub(super) fn ask_groups(&mut self, name: &str, groups: Vec<Vec<Term>>, place: Place) {
        let origin = self.files.origin(place);
        let place = self.files.own(place);
        let groups = groups.into_iter().map(|terms| Argument::Group {
            items: terms
                .into_iter()
                .map(|term| Expression { term, place })
                .collect(),
            place,
        });
        self.push(
            Node::Statement(Statement {
                name: name.to_owned(),
                name_place: place,
                arguments: groups.collect(),
                place,
                origin,
            }),
            place,
        );
    }

    pub(super) fn push(&mut self, node: Node, place: Place) {
        self.items.push(item(node, place));
    }

    /// A fault that something depends on what only the run knows.
    pub(super) fn unknown(&mut self, place: Place, message: String, of: Option<&Expr>) {
        let name = of.and_then(|it| look::unknown(self, it));
        let name = name.as_deref().map_or("NAME", last);
        let (label, help) = match self.companion {
            Some(_) => (
                "not known here",
                format!("give the value with `--const {name}=VALUE`, or take this out"),
            ),
            None => (
                "only the run knows",
                format!(
                    "`exec` runs it, with the host beside the array. Here a program is the same words in every frame: give the value with `--const {name}=VALUE`, or take this out"
                ),
            ),
        };
        self.undecided(Fault::error(place, message, label).help(help));
    }

    /// Warns of a readout of which only the run knows: a program that has to be known before goes
    /// without it.
    pub(super) fn unread(&mut self, place: Place, what: &str, why: &str) {
        if self.companion.is_some() {
            return;
        }
        let message = format!("{what}, {why} decides: here it is left out");
        self.undecided(
            Fault::warning(place, message, "only the run knows")
                .help("`exec` runs it, with the host beside the array"),
        );
    }

    /// A new frame begins.
    pub(super) fn sync(&mut self, place: Place) {
        self.dark = false;
        if self.companion.is_some() {
            self.next_frame();
            return;
        }
        if self.frames.len() == FRAMES && !self.full {
            self.full = true;
            let message = format!("more than {FRAMES} frames, one after the other");
            self.undecided(Fault::error(place, message, "here another one").help(
                "`exec` runs it, with the host beside the array. Here a program is the same in every frame: its loop is `while (1)`",
            ));
        }
        let items = std::mem::take(&mut self.items);
        self.frames.push(items);
    }

    pub(super) fn begin_kernel(&mut self, place: Place, ordinal: i64, fixed: bool) {
        if self.kernel.is_some() {
            self.error(
                place,
                "a kernel inside a kernel".to_owned(),
                "begins here",
                "end the first one with `scamp5_kernel_end();`",
            );
        }
        self.kernel = Some(Kernel {
            place,
            ordinal,
            fixed,
            start: self.items.len(),
        });
    }

    pub(super) fn end_kernel(&mut self, place: Place) {
        let Some(kernel) = self.kernel.take() else {
            self.error(
                place,
                "this ends no kernel".to_owned(),
                "none is open",
                "begin it with `scamp5_kernel_begin();`",
            );
            return;
        };
        let start = kernel.start.min(self.items.len());
        let body = self.items.split_off(start);
        if body.is_empty() {
            return;
        }
        let at = self.files.own(kernel.place);
        self.push(Node::Kernel(body.clone()), at);
        let key = (kernel.place.start, kernel.ordinal);
        let known = self.stored.entry(key).or_default();
        if known.contains(&body) {
            return;
        }
        let first = known.is_empty();
        known.push(body);
        if kernel.fixed && !first {
            self.fault(
                Fault::warning(
                    kernel.place,
                    "this kernel has other words than at its first launch",
                    "the chip keeps those of the first",
                )
                .help("begin it with `scamp5_dynamic_kernel_begin();`"),
            );
        }
    }
}

/// Adds a fault, once: a loop would tell it in every turn.
fn once(faults: &mut Vec<Fault>, fault: Fault) {
    let known = |it: &Fault| it.message == fault.message && it.place.start == fault.place.start;
    if !faults.iter().any(known) {
        faults.push(fault);
    }
}

/// Whether a name is written as the vendor's or the language's own.
pub(super) fn foreign(name: &str) -> bool {
    let space = qualifier(name).unwrap_or_default();
    matches!(space.trim_start_matches("::"), "std" | "SCAMP5_PE")
}

pub(super) const fn item(node: Node, place: Place) -> Item {
    Item {
        node,
        blank_before: false,
        trailing: None,
        place,
    }
}

fn blurred(value: Value, why: &Arc<str>) -> Value {
    match value {
        Value::List(all) => Value::List(all.into_iter().map(|it| blurred(it, why)).collect()),
        Value::Record(layout, all) => {
            Value::Record(layout, all.into_iter().map(|it| blurred(it, why)).collect())
        }
        _ => Value::Unknown(Arc::clone(why)),
    }
}

/// A value as an argument of a statement; `None` where it is none.
pub(super) fn term(value: &Value) -> Option<Term> {
    let place = Place::default();
    Some(match value {
        Value::Whole(_) | Value::Wide(..) | Value::Real(_) => {
            let number = value.number()?;
            if number < 0.0 {
                let term = Term::Number(-number);
                Term::Negate(Box::new(Expression { term, place }))
            } else {
                Term::Number(number)
            }
        }
        Value::Symbol(name) => Term::Name(name.to_string()),
        _ => return None,
    })
}
