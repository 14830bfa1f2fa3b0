//! Expansion: names are looked up, constants are computed, macros are replaced by their bodies.

mod call;
mod expansion;
mod order;
mod rules;
mod values;

pub use self::expansion::{Entry, Expanded, Expansion, Overrides, Stored, for_each};

use std::{collections::BTreeMap, sync::Arc};

use self::{expansion::line_of, order::Order};
use super::{
    Action, Code, Step, check,
    effect::CellEffect,
    host,
    syntax::{Item, Kept, Kernel, Node, Syntax},
};
use crate::config::{Fault, Lines, Place, Severity, enough, thin};
use crate::isa::{
    Bit, Callable, Cell, Device, Digital, HostKind, Macro, Source, Value, macros,
    operands::Unit,
    row,
    signature::{Bound, Mode, Signature},
    text::Statement,
};
use crate::limit::{EXPANDED_STEPS, FRAME_STEPS, STATEMENT_WORDS};

/// A program, statement by statement, and what is wrong with single statements.
fn lowered(
    syntax: &Syntax,
    text: &str,
    settings: &BTreeMap<String, f64>,
    device: &Device,
    overrides: &Overrides,
) -> (Expansion, Vec<Fault>) {
    let mut lowering = Lowering {
        device,
        lines: Lines::new(text),
        scratch: BTreeMap::new(),
        left: EXPANDED_STEPS,
        full: false,
        constants: BTreeMap::new(),
        drawing: None,
        idle: false,
        kernels: BTreeMap::new(),
        launches: 0,
        faults: Vec::new(),
    };
    lowering.constants(syntax, settings, overrides);
    let mut expansion = Expansion::default();
    lowering.sections(syntax, &mut expansion);
    lowering.frame_runs(&expansion);
    let constants = lowering.constants.iter();
    expansion.constants = constants
        .filter_map(|(name, value)| Some((name.clone(), value.number()?)))
        .collect();
    expansion.code = Code {
        init: steps_of(&expansion.init),
        frame: steps_of(&expansion.frame),
    };
    (expansion, lowering.faults)
}

/// The first statement that the chip does not take, and why.
pub(super) fn refused(
    syntax: &Syntax,
    text: &str,
    settings: &BTreeMap<String, f64>,
    device: &Device,
) -> Option<Fault> {
    let (_, faults) = lowered(syntax, text, settings, device, &Overrides::new());
    let errors = faults.into_iter().filter(Fault::is_error);
    errors.min_by_key(|fault| fault.place.start)
}

pub(super) fn expand(
    syntax: &Syntax,
    text: &str,
    settings: &BTreeMap<String, f64>,
    device: &Device,
    overrides: &Overrides,
) -> (Expansion, Vec<Fault>) {
    let (mut expansion, mut faults) = lowered(syntax, text, settings, device, overrides);
    check::check(&expansion, device, &mut faults);
    thin(&mut faults);
    expansion.warnings = faults
        .iter()
        .filter(|f| f.severity == Severity::Warning)
        .cloned()
        .collect();
    (expansion, faults)
}

fn steps_of(entries: &[Entry]) -> Vec<Step> {
    let mut steps = Vec::new();
    for entry in entries {
        match entry {
            Entry::Statement(statement) => steps.extend(statement.steps.iter().cloned()),
            Entry::Repeat { times, body, line } => steps.push(Step {
                action: Action::Repeat {
                    times: *times,
                    body: steps_of(body),
                },
                line: *line,
                origin: None,
            }),
        }
    }
    steps
}

struct Lowering<'a> {
    device: &'a Device,
    lines: Lines,
    /// Scratch registers of macros, by file and place of their heading (a cache).
    scratch: BTreeMap<(&'a str, usize), Vec<Cell>>,
    /// Words, host operations and calls that may still be expanded (a limit on the work).
    left: usize,
    /// Whether that limit was reported; the rest of the text is then skipped.
    full: bool,
    constants: BTreeMap<String, Value>,
    /// The register of the last `scamp5_draw_begin`.
    drawing: Option<Digital>,
    /// Whether the statement before is a word that does nothing.
    idle: bool,
    /// Kernels that are stored, by where they begin.
    kernels: BTreeMap<(usize, usize), Vec<Vec<Item>>>,
    /// Launches of kernels so far that give their room in the store back.
    launches: usize,
    faults: Vec<Fault>,
}

/// The arguments of a macro by parameter name.
type Scope<'a> = &'a [(&'a str, Value)];

/// Where the words of one statement are collected.
struct Sink {
    steps: Vec<Step>,
    line: u32,
    origin: Option<Arc<str>>,
    place: Place,
    /// Words so far, in all repetitions.
    length: usize,
}

impl<'d> Lowering<'d> {
    fn sections(&mut self, syntax: &Syntax, expansion: &mut Expansion) {
        let (mut init, mut frame) = (None, None);
        let mut bare: Vec<&Item> = Vec::new();
        for item in &syntax.items {
            let (seen, body, what) = match &item.node {
                Node::Init(body) => (&mut init, body, "init"),
                Node::Frame(body) => (&mut frame, body, "frame"),
                Node::Statement(_) | Node::Repeat { .. } | Node::Kernel(_) => {
                    bare.push(item);
                    continue;
                }
                Node::Comment(_) | Node::Const { .. } => continue,
            };
            if let Some((place, _)) = seen {
                self.faults.push(
                    Fault::error(item.place, format!("a second `{what}`"), "again here")
                        .also(*place, "the first")
                        .help("put all statements into one"),
                );
            } else {
                let heading = Place::new(item.place.start, item.place.start + what.len());
                *seen = Some((heading, body));
            }
        }
        if init.is_none() && frame.is_none() {
            expansion.bare = true;
            expansion.frame = self.block(bare);
            return;
        }
        if let Some(item) = bare.first() {
            self.faults.push(
                Fault::error(
                    item.place,
                    "a statement outside `init` and `frame`",
                    "this one",
                )
                .help("put it into one of them; a program without both is bare statements"),
            );
        }
        expansion.init = init.map_or_else(Vec::new, |(_, body)| self.block(body));
        expansion.frame = frame.map_or_else(Vec::new, |(_, body)| self.block(body));
    }

    fn block<'i>(&mut self, items: impl IntoIterator<Item = &'i Item>) -> Vec<Entry> {
        let mut entries = Vec::new();
        for item in items {
            thin(&mut self.faults);
            if self.full || enough(&self.faults) {
                break;
            }
            match &item.node {
                Node::Statement(statement) => match self.statement(statement) {
                    Ok(expanded) => entries.push(Entry::Statement(expanded)),
                    Err(fault) => self.faults.push(statement.told(fault)),
                },
                Node::Repeat { times, body } => {
                    let heading = times.place;
                    let times = match self.times(times) {
                        Ok(times) => times,
                        Err(fault) => {
                            self.faults.push(fault);
                            1
                        }
                    };
                    let mut repeat = Entry::Repeat {
                        times,
                        body: self.block(body),
                        line: self.lines.line(item.place.start),
                    };
                    if let (None, Entry::Repeat { times, .. }) =
                        (runs(std::slice::from_ref(&repeat)), &mut repeat)
                    {
                        self.faults.push(runs_too_long("this `repeat`", heading));
                        // So that uses of the constant are no faults of their own.
                        *times = 1;
                    }
                    entries.push(repeat);
                }
                Node::Kernel(kernel) => {
                    let mut inner = self.block(&kernel.body);
                    let stored = self.stored(kernel);
                    for entry in &mut inner {
                        if let Entry::Statement(statement) = entry
                            && statement.stored == Stored::Kept
                        {
                            statement.stored = stored;
                        }
                    }
                    entries.extend(inner);
                }
                // The parser has reported these, where they do not belong.
                Node::Comment(_) | Node::Const { .. } | Node::Init(_) | Node::Frame(_) => {}
            }
        }
        entries
    }

    /// Where the words of a kernel lie that is launched.
    fn stored(&mut self, kernel: &Kernel) -> Stored {
        match kernel.kept {
            Kept::Heap => Stored::Elsewhere,
            Kept::Launch => {
                self.launches += 1;
                Stored::Launch(self.launches)
            }
            Kept::Store => {
                let known = self.kernels.entry(kernel.begins).or_default();
                if known.contains(&kernel.body) {
                    return Stored::Elsewhere;
                }
                known.push(kernel.body.clone());
                Stored::Kept
            }
        }
    }

    fn statement(&mut self, statement: &Statement) -> Result<Expanded, Fault> {
        let mut sink = Sink {
            steps: Vec::new(),
            line: self.lines.line(statement.place.start),
            origin: statement.origin.as_deref().map(|it| line_of(it).into()),
            place: statement.place,
            length: 0,
        };
        let (callable, bound) = self.call(statement, &[])?;
        self.warn_of_scratch(statement, callable, &bound);
        self.lower(statement, callable, &bound, &mut sink, None)?;
        if steps_run(&sink.steps).is_none() {
            return Err(runs_too_long("this statement", statement.place));
        }
        self.idle = match &sink.steps[..] {
            [step] => match &step.action {
                Action::Word(word) => self.device.operands(word).unit == Unit::Idle,
                Action::Host(_) | Action::Repeat { .. } => false,
            },
            _ => false,
        };
        let effect = CellEffect::of(&sink.steps, self.device);
        let (results, whole_flag, host) = match callable {
            Callable::Primitive(..) => (effect.writes.iter().copied().collect(), false, false),
            Callable::Macro(it) => (self.results(it, &bound), it.whole_flag, it.host),
            Callable::Host(kind, signature) => {
                let mut cells = results(signature, &bound);
                if kind == HostKind::Draw {
                    cells.extend(self.drawing.map(Cell::Digital));
                }
                (cells, false, true)
            }
        };
        Ok(Expanded {
            text: statement.to_string(),
            name: statement.name.clone(),
            place: statement.place,
            line: sink.line,
            origin: statement.origin.clone(),
            steps: sink.steps,
            effect,
            results,
            whole_flag,
            stored: if host {
                Stored::Elsewhere
            } else {
                Stored::Kept
            },
        })
    }

    fn results(&self, it: &Macro, bound: &[Bound]) -> Vec<Cell> {
        let mut cells = results(&it.signature, bound);
        cells.extend(
            it.gives
                .iter()
                .filter_map(|name| match self.device.value_of(name) {
                    Some(value) => cell(&value),
                    None => None,
                }),
        );
        // What is given by name can also be FLAG.
        cells
    }

    /// Adds the words of a call, of the program itself or in the body of a macro (`outer`). Faults
    /// inside a macro are shown at the statement that a person wrote.
    fn lower(
        &mut self,
        statement: &Statement,
        callable: Callable<'d>,
        bound: &[Bound],
        sink: &mut Sink,
        outer: Option<&'d Macro>,
    ) -> Result<(), Fault> {
        match callable {
            Callable::Primitive(kind, form) => {
                let built = row::build(kind, &form.name, bound);
                let Some(word) = built else {
                    return Err(Fault::error(
                        sink.place,
                        format!("`{}` cannot be built from these arguments", statement.name),
                        "here",
                    )
                    .help(format!("it is written {form}")));
                };
                self.reject_twice(&word, statement, sink, outer)?;
                if outer.is_none() {
                    self.warn_in_place(&word, sink);
                }
                self.push(sink, Action::Word(word), 1)
            }
            Callable::Host(kind, form) => {
                let operation = host::build((kind, &form.name), bound, self.drawing, self.device)
                    .map_err(|message| {
                    Fault::error(sink.place, message, "this statement")
                        .help(format!("it is written {form}"))
                })?;
                match &operation {
                    super::Host::DrawBegin { target } => self.drawing = Some(*target),
                    super::Host::DrawEnd => self.drawing = None,
                    _ => {}
                }
                self.push(sink, Action::Host(operation), 1)
            }
            Callable::Macro(it) => {
                self.spend(sink)?;
                self.reject_aliases((statement, it), bound, sink, outer)?;
                let scope: Vec<(&str, Value)> = it
                    .signature
                    .parameters
                    .iter()
                    .zip(bound)
                    .filter_map(|(p, values)| Some((p.name.as_str(), values.first()?.clone())))
                    .collect();
                self.body(it, &it.body, &scope, sink)
            }
        }
    }

    fn body(
        &mut self,
        it: &'d Macro,
        body: &'d [macros::Item],
        scope: Scope<'_>,
        sink: &mut Sink,
    ) -> Result<(), Fault> {
        let outside = |fault: Fault, place: Place| Fault {
            place,
            label: format!("{}, in its body: {}", named(it), fault.label),
            also: None,
            ..fault
        };
        let mut order = Order::new(it, scope, sink);
        for item in body {
            match item {
                macros::Item::Statement(inner) => {
                    let (callable, bound) = self
                        .call(inner, scope)
                        .map_err(|fault| outside(fault, sink.place))?;
                    let from = sink.steps.len();
                    self.lower(inner, callable, &bound, sink, Some(it))?;
                    if let Some(order) = &mut order {
                        let lost = order.see(inner, (sink, from), self.device);
                        self.faults.extend(lost);
                    }
                }
                macros::Item::Repeat { times, body } => {
                    let place = sink.place;
                    let times = match self.value(times, scope).map_err(|f| outside(f, place))? {
                        // Rounded down, and none below zero: macros count halves with it.
                        Value::Number(n) => {
                            n.floor().clamp(0.0, (STATEMENT_WORDS + 1) as f64) as usize
                        }
                        _ => 0,
                    };
                    let mut inner = Sink {
                        steps: Vec::new(),
                        origin: sink.origin.clone(),
                        ..*sink
                    };
                    if times > 0 {
                        self.body(it, body, scope, &mut inner)?;
                    }
                    if it.host && times > 1 {
                        sink.length = inner.length;
                        let body = inner.steps;
                        let times = times as u32;
                        self.push(sink, Action::Repeat { times, body }, 0)?;
                        continue;
                    }
                    if inner.steps.is_empty() {
                        continue;
                    }
                    for _ in 0..times {
                        for step in &inner.steps {
                            self.push(sink, step.action.clone(), 1)?;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    fn push(&mut self, sink: &mut Sink, action: Action, length: usize) -> Result<(), Fault> {
        self.spend(sink)?;
        sink.length += length;
        if sink.length > STATEMENT_WORDS {
            return Err(Fault::error(
                sink.place,
                format!("this statement is longer than {STATEMENT_WORDS} words"),
                "no kernel store holds it",
            )
            .help("repeat less often, or use `repeat N { … }`, which is stored once"));
        }
        sink.steps.push(Step {
            action,
            line: sink.line,
            origin: sink.origin.clone(),
        });
        Ok(())
    }

    /// One more word, host operation or call.
    fn spend(&mut self, sink: &Sink) -> Result<(), Fault> {
        if let Some(left) = self.left.checked_sub(1) {
            self.left = left;
            return Ok(());
        }
        self.full = true;
        Err(Fault::error(
            sink.place,
            format!("the program expands to more than {EXPANDED_STEPS} steps: words, host operations and macro calls"),
            "the limit is reached here",
        )
        .help("use `repeat N { … }`, whose body counts once"))
    }

    /// Checks that the steps that run in `init`, and in a frame, are within the limit.
    fn frame_runs(&mut self, expansion: &Expansion) {
        let whole = if expansion.bare {
            "the program"
        } else {
            "`frame`"
        };
        for (what, entries) in [("`init`", &expansion.init), (whole, &expansion.frame)] {
            if runs(entries).is_none() {
                self.faults.push(runs_too_long(what, Place::default()));
            }
        }
    }
}

/// A macro by its name and where it is written.
fn named(it: &Macro) -> String {
    format!("`{}` ({})", it.signature.name, it.origin)
}

/// How many steps run: words, host operations, iterations of `repeat`; `None` beyond the limit.
fn runs(entries: &[Entry]) -> Option<u64> {
    entries.iter().try_fold(0, |sum, entry| {
        let one = match entry {
            Entry::Statement(statement) => steps_run(&statement.steps)?,
            Entry::Repeat { times, body, .. } => turns(*times, runs(body)?)?,
        };
        within(one + sum)
    })
}

/// The same for steps.
fn steps_run(steps: &[Step]) -> Option<u64> {
    steps.iter().try_fold(0, |sum, step| {
        let one = match &step.action {
            Action::Word(_) | Action::Host(_) => 1,
            Action::Repeat { times, body } => turns(*times, steps_run(body)?)?,
        };
        within(one + sum)
    })
}

/// Iterations times the steps of a body; an empty iteration counts as one step.
fn turns(times: u32, body: u64) -> Option<u64> {
    u64::from(times).checked_mul(body.max(1)).and_then(within)
}

fn within(steps: u64) -> Option<u64> {
    (steps <= FRAME_STEPS).then_some(steps)
}

fn runs_too_long(what: &str, place: Place) -> Fault {
    Fault::error(
        place,
        format!("{what} runs more than {FRAME_STEPS} steps: words, host operations and iterations of `repeat`"),
        "this would run too long",
    )
    .help("repeat less often: nested repeats multiply")
}

/// The cell that a value names.
fn cell(value: &Value) -> Option<Cell> {
    match value {
        Value::Source(Source::Register(register)) => Some(Cell::Analog(*register)),
        Value::Bit(Bit::Register(register)) => Some(Cell::Digital(*register)),
        Value::Bit(Bit::Flag) => Some(Cell::Flag),
        _ => None,
    }
}

/// The cells that parameters give as results.
fn results(signature: &Signature, bound: &[Bound]) -> Vec<Cell> {
    signature
        .parameters
        .iter()
        .zip(bound)
        .filter(|(p, _)| matches!(p.mode, Mode::Out | Mode::InOut))
        .flat_map(|(_, values)| values.iter().filter_map(cell))
        .collect()
}
