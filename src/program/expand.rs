//! From tree to words: names are looked up, constants computed, macros replaced by what they
//! stand for.

use std::collections::BTreeMap;

use super::{
    Action, Code, Step, check,
    effect::{Cell, Effect},
    host,
    syntax::{Item, Node, Syntax},
};
use crate::isa::{
    Bit, Callable, Device, Digital, Direction, Macro, Operand, Primitive, Source, Target, Value,
    macros, row,
    signature::{Bound, Given, Mismatch, Mode, Signature},
    text::{
        Argument, Expression, Fault, Place, Severity, Statement, Term, line_column, suggestion,
    },
};

/// Constants that are set from outside, by name.
pub type Overrides = BTreeMap<String, f64>;

/// One statement may become so many words; more would fill any kernel store.
const LONGEST: usize = 100_000;

/// A program, expanded.
#[derive(Clone, Debug, Default)]
pub struct Expansion {
    /// What runs.
    pub code: Code,
    /// Whether the text is bare statements: a whole program, to be run once. Its code is
    /// `code.frame`.
    pub bare: bool,
    /// The statements of `init`, with what each became.
    pub init: Vec<Entry>,
    /// The statements of a frame, with what each became.
    pub frame: Vec<Entry>,
    /// The value of every constant that is a number.
    pub constants: BTreeMap<String, f64>,
    /// What may not be meant.
    pub warnings: Vec<Fault>,
}

/// A statement and what it became.
#[derive(Clone, Debug)]
pub enum Entry {
    /// One statement.
    Statement(Expanded),
    /// A block, several times.
    Repeat {
        /// How often.
        times: u32,
        /// What.
        body: Vec<Entry>,
        /// Line of its heading, from 1.
        line: u32,
    },
}

/// One statement, expanded.
#[derive(Clone, Debug)]
pub struct Expanded {
    /// As it is printed.
    pub text: String,
    /// Its name.
    pub name: String,
    /// Where it stands.
    pub place: Place,
    /// Line, from 1.
    pub line: u32,
    /// What it became.
    pub steps: Vec<Step>,
    /// What it reads and writes.
    pub effect: Effect,
    /// What it gives as a result; the rest of what it writes is destroyed.
    pub results: Vec<Cell>,
    /// Whether it needs FLAG to be 1 everywhere.
    pub whole_flag: bool,
    /// Whether it was written by the host as kernels of its own, outside the program's store.
    pub host: bool,
}

impl Expanded {
    /// The cells that it writes and does not give as a result.
    pub fn destroys(&self) -> impl Iterator<Item = Cell> {
        let writes = self.effect.writes.iter().copied();
        writes.filter(|cell| !self.results.contains(cell))
    }
}

pub(super) fn expand(
    syntax: &Syntax,
    text: &str,
    settings: &BTreeMap<String, f64>,
    device: &Device,
    overrides: &Overrides,
) -> (Expansion, Vec<Fault>) {
    let mut lowering = Lowering {
        device,
        text,
        constants: BTreeMap::new(),
        drawing: None,
        faults: Vec::new(),
    };
    lowering.constants(syntax, settings, overrides);
    let mut expansion = Expansion::default();
    lowering.sections(syntax, &mut expansion);
    let constants = lowering.constants.iter();
    expansion.constants = constants
        .filter_map(|(name, value)| Some((name.clone(), value.number()?)))
        .collect();
    expansion.code = Code {
        init: steps_of(&expansion.init),
        frame: steps_of(&expansion.frame),
    };
    let mut faults = lowering.faults;
    check::check(&expansion, device, &mut faults);
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
            }),
        }
    }
    steps
}

struct Lowering<'a> {
    device: &'a Device,
    text: &'a str,
    constants: BTreeMap<String, Value>,
    /// The register of the last `scamp5_draw_begin`.
    drawing: Option<Digital>,
    faults: Vec<Fault>,
}

/// What the parameters of a macro stand for.
type Scope<'a> = &'a [(&'a str, Value)];

/// One statement of the program on its way to words.
struct Sink {
    steps: Vec<Step>,
    line: u32,
    place: Place,
    /// Words so far, in all repetitions.
    length: usize,
}

impl<'d> Lowering<'d> {
    fn constants(
        &mut self,
        syntax: &Syntax,
        settings: &BTreeMap<String, f64>,
        overrides: &Overrides,
    ) {
        for (name, value) in settings {
            let value = overrides.get(name).unwrap_or(value);
            self.constants.insert(name.clone(), Value::Number(*value));
        }
        for item in &syntax.items {
            let Node::Const {
                name,
                name_place,
                value,
            } = &item.node
            else {
                continue;
            };
            if self.device.value_of(name).is_some() {
                self.faults.push(
                    Fault::error(
                        *name_place,
                        format!("`{name}` is a name of the chip"),
                        "here",
                    )
                    .help("give the constant another name"),
                );
            }
            if self.constants.contains_key(name) {
                self.faults.push(
                    Fault::error(
                        *name_place,
                        format!("`{name}` is stated twice"),
                        "again here",
                    )
                    .help("keep one of the two"),
                );
                continue;
            }
            let value = match overrides.get(name) {
                Some(value) => Ok(Value::Number(*value)),
                None => self.known_value(value),
            };
            match value {
                Ok(value) => {
                    self.constants.insert(name.clone(), value);
                }
                Err(fault) => {
                    // So that each use of it is not a fault of its own.
                    self.constants.insert(name.clone(), Value::Number(0.0));
                    self.faults.push(fault);
                }
            }
        }
        for (name, value) in overrides {
            if !self.constants.contains_key(name) {
                let known = self.constants.keys().map(String::as_str);
                let near = suggestion(name, known);
                let all: Vec<&str> = self.constants.keys().map(String::as_str).collect();
                self.faults.push(
                    Fault::error(
                        Place::default(),
                        format!("there is no constant `{name}` to set"),
                        "this program",
                    )
                    .help(near.unwrap_or_else(|| {
                        if all.is_empty() {
                            "it states none; write `const name = value;`".to_owned()
                        } else {
                            format!("it states {}", all.join(", "))
                        }
                    })),
                );
            } else if !value.is_finite() {
                self.faults.push(
                    Fault::error(
                        Place::default(),
                        format!("the constant `{name}` cannot be {value}"),
                        "this program",
                    )
                    .help("give a finite number"),
                );
            }
        }
    }

    /// The value of an expression in which every name must mean something.
    fn known_value(&self, expression: &Expression) -> Result<Value, Fault> {
        match self.value(expression, &[])? {
            Value::Word(name) => Err(self.unknown_name(&name, expression.place)),
            value => Ok(value),
        }
    }

    fn sections(&mut self, syntax: &Syntax, expansion: &mut Expansion) {
        let (mut init, mut frame) = (None, None);
        let mut bare: Vec<&Item> = Vec::new();
        for item in &syntax.items {
            let (seen, body, what) = match &item.node {
                Node::Init(body) => (&mut init, body, "init"),
                Node::Frame(body) => (&mut frame, body, "frame"),
                Node::Statement(_) | Node::Repeat { .. } => {
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
            match &item.node {
                Node::Statement(statement) => match self.statement(statement) {
                    Ok(expanded) => entries.push(Entry::Statement(expanded)),
                    Err(fault) => self.faults.push(fault),
                },
                Node::Repeat { times, body } => {
                    let times = match self.times(times) {
                        Ok(times) => times,
                        Err(fault) => {
                            self.faults.push(fault);
                            1
                        }
                    };
                    entries.push(Entry::Repeat {
                        times,
                        body: self.block(body),
                        line: line_column(self.text, item.place.start).0,
                    });
                }
                // Found by the parser, where they do not belong.
                Node::Comment(_) | Node::Const { .. } | Node::Init(_) | Node::Frame(_) => {}
            }
        }
        entries
    }

    fn times(&self, expression: &Expression) -> Result<u32, Fault> {
        let wrong = |found: String| {
            Fault::error(
                expression.place,
                format!("`repeat` takes a whole number of zero or more, not {found}"),
                "this number",
            )
            .help("write `repeat 10 { … }`, or a constant")
        };
        match self.known_value(expression)? {
            Value::Number(n) if n.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&n) => {
                Ok(n as u32)
            }
            Value::Number(n) => Err(wrong(n.to_string())),
            other => Err(wrong(other.describe().to_owned())),
        }
    }

    fn statement(&mut self, statement: &Statement) -> Result<Expanded, Fault> {
        let mut sink = Sink {
            steps: Vec::new(),
            line: line_column(self.text, statement.place.start).0,
            place: statement.place,
            length: 0,
        };
        let (callable, bound) = self.call(statement, &[])?;
        self.warn_of_scratch(statement, callable, &bound);
        self.lower(statement, callable, &bound, &mut sink, 0)?;
        let effect = Effect::of(&sink.steps, self.device);
        let (results, whole_flag, host) = match callable {
            Callable::Primitive(..) => (effect.writes.iter().copied().collect(), false, false),
            Callable::Macro(it) => (self.results(it, &bound), it.whole_flag, it.host),
            Callable::Host(_, signature) => (results(signature, &bound), false, true),
        };
        Ok(Expanded {
            text: statement.to_string(),
            name: statement.name.clone(),
            place: statement.place,
            line: sink.line,
            steps: sink.steps,
            effect,
            results,
            whole_flag,
            host,
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

    /// What a statement means, and the values of its parameters.
    fn call(
        &self,
        statement: &Statement,
        scope: Scope<'_>,
    ) -> Result<(Callable<'d>, Vec<Bound>), Fault> {
        let device: &'d Device = self.device;
        let callables = device.callables(&statement.name);
        if callables.is_empty() {
            let names = self
                .device
                .all_callables()
                .map(|c| c.signature().name.as_str());
            return Err(Fault::error(
                statement.name_place,
                format!("unknown statement `{}`", statement.name),
                "the chip has no such statement",
            )
            .help(suggestion(&statement.name, names).unwrap_or_else(|| {
                format!(
                    "`amacrine asm` knows the statements of isa/{}",
                    self.device.name()
                )
            })));
        }
        let given = self.given(&statement.arguments, scope)?;
        let mut furthest = None;
        for callable in &callables {
            match callable.signature().bind(&given) {
                Ok(bound) => {
                    return Ok((*callable, self.with_defaults(callable.signature(), bound)?));
                }
                Err(Mismatch::Shape) => {}
                Err(Mismatch::Argument { index, message }) => {
                    // The form that fits the longest is most likely the one that was meant.
                    if furthest.as_ref().is_none_or(|(far, _)| index > *far) {
                        furthest = Some((index, message));
                    }
                }
            }
        }
        match furthest {
            Some((index, message)) => Err(self.wrong_argument(statement, &given, index, &message)),
            None => Err(Self::wrong_shape(statement, &callables)),
        }
    }

    fn wrong_argument(
        &self,
        statement: &Statement,
        given: &[Given],
        index: usize,
        message: &str,
    ) -> Fault {
        let argument = given.get(index);
        let place = argument.map_or(statement.place, |g| g.place);
        if let Some(Value::Word(name)) = argument.and_then(|g| g.values.first()) {
            let mut fault = self.unknown_name(name, place);
            fault.label = format!("argument {} of `{}`: {message}", index + 1, statement.name);
            return fault;
        }
        let forms = self.device.callables(&statement.name);
        let forms: Vec<String> = forms.iter().map(|c| c.signature().to_string()).collect();
        // `where(R5)` is `WHERE(R5)`.
        let other = self.device.all_callables().find(|c| {
            let name = &c.signature().name;
            *name != statement.name
                && name.eq_ignore_ascii_case(&statement.name)
                && c.signature().bind(given).is_ok()
        });
        Fault::error(
            place,
            format!("argument {} of `{}`: {message}", index + 1, statement.name),
            "this argument",
        )
        .help(match other {
            Some(other) => format!("did you mean `{}`?", other.signature().name),
            None => format!("it is written {}", forms.join(" or ")),
        })
    }

    fn wrong_shape(statement: &Statement, callables: &[Callable<'_>]) -> Fault {
        let forms: Vec<String> = callables
            .iter()
            .map(|c| c.signature().to_string())
            .collect();
        let braces = statement
            .arguments
            .iter()
            .any(|a| matches!(a, Argument::Group { .. }));
        let count = statement.arguments.len();
        let message = if braces {
            format!(
                "`{}` does not take these arguments in braces",
                statement.name
            )
        } else {
            let plural = if count == 1 { "" } else { "s" };
            format!(
                "`{}` does not take {count} argument{plural} like these",
                statement.name
            )
        };
        Fault::error(statement.place, message, "this statement")
            .help(format!("it is written {}", forms.join(" or ")))
    }

    fn unknown_name(&self, name: &str, place: Place) -> Fault {
        let constants = self.constants.keys().map(String::as_str);
        let near = suggestion(name, self.device.names().chain(constants));
        Fault::error(
            place,
            format!("unknown name `{name}`"),
            "no register, direction or constant",
        )
        .help(near.unwrap_or_else(|| {
            let registers = self.device.registers();
            format!(
                "registers are {} and {}; constants are stated as `const {name} = …;`",
                registers.analog.join(" "),
                registers.digital.join(" ")
            )
        }))
    }

    fn given(&self, arguments: &[Argument], scope: Scope<'_>) -> Result<Vec<Given>, Fault> {
        let mut given = Vec::new();
        for argument in arguments {
            match argument {
                Argument::One(expression) => {
                    for value in self.values(expression, scope)? {
                        given.push(Given {
                            values: vec![value],
                            group: false,
                            place: expression.place,
                        });
                    }
                }
                Argument::Group { items, place } => {
                    let mut values = Vec::new();
                    for item in items {
                        values.extend(self.values(item, scope)?);
                    }
                    given.push(Given {
                        values,
                        group: true,
                        place: *place,
                    });
                }
            }
        }
        Ok(given)
    }

    /// The values of an expression: one, except for `R[dir]`.
    fn values(&self, expression: &Expression, scope: Scope<'_>) -> Result<Vec<Value>, Fault> {
        let Term::Of {
            base,
            opposite,
            direction,
        } = &expression.term
        else {
            return Ok(vec![self.value(expression, scope)?]);
        };
        let directions = match self.name(direction, scope) {
            Value::Directions(directions) => directions,
            other => {
                return Err(Fault::error(
                    expression.place,
                    format!("`{direction}` is {}, not a direction", other.describe()),
                    "here",
                )
                .help("`X[dir]` and `R[dir]` take a direction"));
            }
        };
        let of = |direction: Direction| {
            if *opposite {
                direction.opposite()
            } else {
                direction
            }
        };
        let directions = directions.into_iter().map(of);
        match base.as_str() {
            "X" => Ok(directions
                .map(|d| Value::Source(Source::Neighbour(d)))
                .collect()),
            "R" => {
                let roles = self.device.registers().roles;
                let register = |d| Value::Bit(Bit::Register(roles.enables(d)));
                Ok(directions.map(register).collect())
            }
            _ => Err(Fault::error(
                expression.place,
                format!("`{base}[…]` means nothing"),
                "here",
            )
            .help("`X[dir]` is a neighbour's cell, `R[dir]` the register that enables it")),
        }
    }

    fn name(&self, name: &str, scope: Scope<'_>) -> Value {
        if let Some((_, value)) = scope.iter().find(|(parameter, _)| *parameter == name) {
            return value.clone();
        }
        self.device
            .value_of(name)
            .or_else(|| self.constants.get(name).cloned())
            .unwrap_or_else(|| Value::Word(name.to_owned()))
    }

    fn value(&self, expression: &Expression, scope: Scope<'_>) -> Result<Value, Fault> {
        let number = |inner: &Expression| -> Result<f64, Fault> {
            match self.value(inner, scope)? {
                Value::Number(value) => Ok(value),
                Value::Word(name) => Err(self.unknown_name(&name, inner.place)),
                other => Err(Fault::error(
                    inner.place,
                    format!("expected a number, found {}", other.describe()),
                    "arithmetic is for numbers",
                )
                .help("registers are added by `add(y, x0, x1);`")),
            }
        };
        let value = match &expression.term {
            Term::Number(value) => *value,
            Term::Name(name) => return Ok(self.name(name, scope)),
            Term::Negate(inner) => -number(inner)?,
            Term::Binary {
                operator,
                left,
                right,
            } => operator.apply(number(left)?, number(right)?),
            Term::Of { .. } => match self.values(expression, scope)?.as_slice() {
                [one] => return Ok(one.clone()),
                _ => {
                    return Err(Fault::error(
                        expression.place,
                        "several registers where one is expected",
                        "here",
                    )
                    .help("`R[dir]` of several directions is for SET and CLR"));
                }
            },
        };
        if !value.is_finite() {
            return Err(Fault::error(
                expression.place,
                format!("this is {value}, not a number"),
                "divided by zero, or too large",
            )
            .help("numbers are finite"));
        }
        // Minus zero is zero: it would be printed and read back as such.
        Ok(Value::Number(value + 0.0))
    }

    fn with_defaults(
        &self,
        signature: &Signature,
        mut bound: Vec<Bound>,
    ) -> Result<Vec<Bound>, Fault> {
        for (values, parameter) in bound.iter_mut().zip(&signature.parameters) {
            if let (true, Some(default)) = (values.is_empty(), &parameter.default) {
                values.push(self.value(default, &[])?);
            }
        }
        Ok(bound)
    }

    /// Adds the words of a call. Faults inside a macro are shown at the statement that a
    /// person wrote.
    fn lower(
        &mut self,
        statement: &Statement,
        callable: Callable<'d>,
        bound: &[Bound],
        sink: &mut Sink,
        depth: usize,
    ) -> Result<(), Fault> {
        match callable {
            Callable::Primitive(kind, form) => {
                let built = row::build(kind, &form.name, bound);
                let Some(word) = built else {
                    return Err(Fault::error(
                        sink.place,
                        format!("`{}` cannot be made from these arguments", statement.name),
                        "here",
                    )
                    .help(format!("it is written {form}")));
                };
                self.reject_twice(&word, statement, sink, depth)?;
                self.warn_in_place(&word, sink, depth);
                push(sink, Action::Word(word), 1)
            }
            Callable::Host(kind, form) => {
                let operation =
                    host::build(kind, &form.name, bound, self.drawing).map_err(|message| {
                        Fault::error(sink.place, message, "this statement")
                            .help(format!("it is written {form}"))
                    })?;
                match &operation {
                    super::Host::DrawBegin { target } => self.drawing = Some(*target),
                    super::Host::DrawEnd => self.drawing = None,
                    _ => {}
                }
                push(sink, Action::Host(operation), 1)
            }
            Callable::Macro(it) => {
                self.reject_aliases(it, bound, sink)?;
                let scope: Vec<(&str, Value)> = it
                    .signature
                    .parameters
                    .iter()
                    .zip(bound)
                    .filter_map(|(p, values)| Some((p.name.as_str(), values.first()?.clone())))
                    .collect();
                self.body(it, &it.body, &scope, sink, depth + 1)
            }
        }
    }

    fn body(
        &mut self,
        it: &'d Macro,
        body: &'d [macros::Item],
        scope: Scope<'_>,
        sink: &mut Sink,
        depth: usize,
    ) -> Result<(), Fault> {
        let outside = |fault: Fault, place: Place| Fault {
            place,
            label: format!("`{}`, in its body: {}", it.signature.name, fault.label),
            also: None,
            ..fault
        };
        for item in body {
            match item {
                macros::Item::Statement(inner) => {
                    let (callable, bound) = self
                        .call(inner, scope)
                        .map_err(|fault| outside(fault, sink.place))?;
                    self.lower(inner, callable, &bound, sink, depth)?;
                }
                macros::Item::Repeat { times, body } => {
                    let place = sink.place;
                    let times = match self.value(times, scope).map_err(|f| outside(f, place))? {
                        // Rounded down, and none below zero: macros count halves with it.
                        Value::Number(n) => n.floor().clamp(0.0, LONGEST as f64) as usize,
                        _ => 0,
                    };
                    let mut inner = Sink {
                        steps: Vec::new(),
                        ..*sink
                    };
                    if times > 0 {
                        self.body(it, body, scope, &mut inner, depth)?;
                    }
                    if it.host && times > 1 {
                        push(
                            sink,
                            Action::Repeat {
                                times: times as u32,
                                body: inner.steps,
                            },
                            0,
                        )?;
                        continue;
                    }
                    for _ in 0..times {
                        for step in &inner.steps {
                            push(sink, step.action.clone(), 1)?;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    fn reject_aliases(&self, it: &Macro, bound: &[Bound], sink: &Sink) -> Result<(), Fault> {
        let value = |name: &str| {
            let at = it
                .signature
                .parameters
                .iter()
                .position(|p| p.name == name)?;
            bound.get(at)?.first()
        };
        for distinct in &it.distinct {
            let (first, second) = (value(&distinct.first), value(&distinct.second));
            let (Some(first), Some(second)) = (first, second) else {
                continue;
            };
            if first == second {
                let name = cell(first).map_or_else(
                    || "the same source".to_owned(),
                    |cell| cell.name(self.device),
                );
                return Err(Fault::error(
                    sink.place,
                    format!(
                        "`{}` cannot have {name} as both {} and {}",
                        it.signature.name, distinct.first, distinct.second
                    ),
                    distinct.reason.clone(),
                )
                .help(format!(
                    "use another register for one of them, or copy it first; it is written {}",
                    it.signature
                )));
            }
        }
        Ok(())
    }

    /// A register that is selected twice on a bus is one connection.
    fn reject_twice(
        &self,
        word: &Primitive,
        statement: &Statement,
        sink: &Sink,
        depth: usize,
    ) -> Result<(), Fault> {
        let name = |source: &Source| self.device.source_name(*source);
        let (targets, sources) = match word {
            Primitive::Bus { targets, sources } => (targets.as_slice(), sources.as_slice()),
            Primitive::Square { sources } | Primitive::Where { sources } => {
                ([].as_slice(), sources.as_slice())
            }
            Primitive::Blur { target, source, .. } if target == source => {
                return Err(self.twice(
                    &self.device.analog_name(*target),
                    word,
                    statement,
                    sink,
                    depth,
                ));
            }
            Primitive::Blur { .. }
            | Primitive::Nop
            | Primitive::ResetPix
            | Primitive::All
            | Primitive::BlurSet
            | Primitive::Set { .. }
            | Primitive::Clear { .. }
            | Primitive::Or { .. }
            | Primitive::Nor { .. }
            | Primitive::WhereBit { .. }
            | Primitive::Dnews { .. }
            | Primitive::PropRead
            | Primitive::Prop { .. } => return Ok(()),
        };
        let targets = targets.iter().map(|target| match target {
            Target::Register(register) => Source::Register(*register),
            Target::Neighbour(direction) => Source::Neighbour(*direction),
        });
        let mut seen: Vec<Source> = Vec::new();
        for source in targets.chain(sources.iter().copied()) {
            if seen.contains(&source) {
                return Err(self.twice(&name(&source), word, statement, sink, depth));
            }
            seen.push(source);
        }
        Ok(())
    }

    fn twice(
        &self,
        register: &str,
        word: &Primitive,
        statement: &Statement,
        sink: &Sink,
        depth: usize,
    ) -> Fault {
        let word = word.text(self.device);
        let (message, help) = if depth == 0 {
            (
                format!("{register} is twice on one bus"),
                format!(
                    "`{}` needs registers that differ; copy one first: `mov(y, {register});`",
                    statement.name
                ),
            )
        } else {
            (
                format!("{register} is twice on one bus: this becomes `{word}`"),
                format!("use another register; `{register}` may be scratch of the macro itself"),
            )
        };
        Fault::error(
            sink.place,
            message,
            "a register twice on a bus is one connection",
        )
        .help(help)
    }

    /// One word that reads and writes the same one-bit register.
    fn warn_in_place(&mut self, word: &Primitive, sink: &Sink, depth: usize) {
        let (Primitive::Or { target, sources } | Primitive::Nor { target, sources }) = word else {
            return;
        };
        if depth > 0 || !sources.contains(&Bit::Register(*target)) {
            return;
        }
        let name = self.device.digital_name(*target);
        self.faults.push(
            Fault::warning(
                sink.place,
                format!("{name} is read and written in one word"),
                "the chip takes two words for this",
            )
            .help(format!("write it in place: `OR({name}, x);`, `NOR({name}, x);`, `NOT({name});`, `REFRESH({name});`")),
        );
    }

    /// An operand that the macro itself uses as scratch.
    fn warn_of_scratch(&mut self, statement: &Statement, callable: Callable<'_>, bound: &[Bound]) {
        let Callable::Macro(it) = callable else {
            return;
        };
        let scratch = it.scratch(self.device);
        let scratch: Vec<Cell> = scratch
            .iter()
            .filter(|name| !it.gives.contains(name))
            .filter_map(|name| cell(&self.device.value_of(name)?))
            .collect();
        let mut warnings = Vec::new();
        for (parameter, values) in it.signature.parameters.iter().zip(bound) {
            let by_default = parameter.mode == Mode::Trash && parameter.default.is_some();
            if by_default
                || !matches!(
                    parameter.operand,
                    Operand::Areg | Operand::Source | Operand::Dreg | Operand::Bit
                )
            {
                continue;
            }
            for used in values
                .iter()
                .filter_map(cell)
                .filter(|c| scratch.contains(c))
            {
                let name = used.name(self.device);
                warnings.push(
                    Fault::warning(
                        statement.place,
                        format!("`{}` uses {name} as scratch itself", statement.name),
                        format!("{name} is its {} here", parameter.name),
                    )
                    .help("the chip would give what the sequence of words gives; use another register"),
                );
            }
        }
        self.faults.extend(warnings);
    }
}

fn push(sink: &mut Sink, action: Action, length: usize) -> Result<(), Fault> {
    sink.length += length;
    if sink.length > LONGEST {
        return Err(Fault::error(
            sink.place,
            format!("this statement is longer than {LONGEST} words"),
            "no kernel store holds it",
        )
        .help("repeat less often, or use `repeat N { … }`, which is stored once"));
    }
    let line = sink.line;
    sink.steps.push(Step { action, line });
    Ok(())
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
