//! Programs as the vendor of the chip has them: C++ with a `main` and a loop over the frames.
//!
//! The part of C++ that such programs are made of is *run* here, before the program is: what the
//! micro-controller knows beforehand, constants, sliders with their defaults, loop counters, is
//! computed; what it asks of the array becomes the statements of a [`Syntax`](super::Syntax), the
//! same that a program's own language has. The words mean what they mean there; only those
//! that take in light are known here by name, for warnings.
//!
//! - [`lexer`]: text to tokens; `#include`, `#define`, `#if`.
//! - [`syntax`]: tokens to the tree.
//! - [`analysis`]: what a text says without being run.
//! - [`interpreter`]: the tree, run. [`Value::Unknown`](interpreter::value::Value::Unknown) is what
//!   only the run of the program knows; nothing that changes the array may depend on it.
//! - [`library`]: the language's own library; [`host`]: the vendor's.
//! - [`frame`]: kernels, the loop over the frames, and the host that runs beside the array instead.
//! - [`write`]: the other way, from a program to C++.
//!
//! Text whose statements end with their lines, as an open simulator takes it, is read as well.

mod analysis;
mod frame;
mod host;
mod interpreter;
mod lexer;
mod library;
mod syntax;
mod write;

pub(super) use self::frame::beside::in_cpp;
pub use self::{
    frame::beside::{Answer, Beside},
    lexer::{
        includes::{included, included_files},
        source_map::{Includes, Lying},
    },
    write::{WriteError, cpp},
};

use std::collections::{BTreeMap, BTreeSet};

use self::{
    analysis::{effects, unreachable},
    frame::beside::Companion,
    host::{chip, request::item},
    interpreter::machine::Machine,
    lexer::{preprocessor, source_map::Files},
    syntax::{
        parser,
        tree::{Function, Stmt, StmtNode},
    },
};
use crate::{
    config::{Fault, Place, Severity},
    isa::Device,
    program::{
        Overrides,
        syntax::{Item, Node},
    },
};

/// What a text becomes.
#[derive(Debug, Default)]
pub(super) struct Read {
    pub items: Vec<Item>,
    /// What can be set from outside, with its value.
    pub constants: BTreeMap<String, f64>,
    pub faults: Vec<Fault>,
    /// What only a run beside the array decides: faults too, where the program has to be known.
    pub undecided: Vec<Fault>,
    /// Titles of what is shown, by line.
    pub titles: BTreeMap<String, BTreeSet<String>>,
    /// Whether it has a loop over the frames.
    pub loops: bool,
    /// In how many places it writes texts for people.
    pub posts: usize,
}

/// Endings of files that are C++.
const ENDINGS: [&str; 8] = ["cpp", "cc", "cxx", "c", "hpp", "hh", "hxx", "h"];

/// Whether a file of this name is C++.
#[must_use]
pub fn is_cpp(file: &str) -> bool {
    ENDINGS.contains(&ending(file).as_str())
}

/// What a file's name ends in, in small letters.
pub(super) fn ending(file: &str) -> String {
    file.rsplit_once('.')
        .map_or_else(String::new, |it| it.1.to_ascii_lowercase())
}

/// Whether a text that is no program of the frame language was meant as C++.
pub(super) fn looks_like_cpp(text: &str) -> bool {
    const BEGINNINGS: [&str; 22] = [
        "#include",
        "#define",
        "#if",
        "#pragma",
        "using ",
        "int ",
        "void ",
        "inline ",
        "static ",
        "auto ",
        "for(",
        "for (",
        "while(",
        "while (",
        "if(",
        "if (",
        "const int ",
        "const areg_t ",
        "const dreg_t ",
        "areg_t ",
        "dreg_t ",
        "switch",
    ];
    let mut lines = text.lines().map(str::trim_start);
    lines.any(|line| BEGINNINGS.iter().any(|begin| line.starts_with(begin)))
}

/// Whether bare statements of the frame language are the vendor's, or a kernel compiler's: they have
/// a kernel or a name that the language itself has not, and none of its blocks and constants.
pub(super) fn has_its_words(items: &[Item]) -> bool {
    let device = Device::scamp5();
    let plain = |it: &Item| matches!(it.node, Node::Statement(_) | Node::Comment(_));
    let its = |it: &Item| matches!(&it.node, Node::Statement(it) if chip::has_alone(&device, it));
    items.iter().all(plain) && items.iter().any(its)
}

/// Whether a text parses, without running it.
pub(super) fn parses(text: &str) -> bool {
    let mut files = Files::new("", text.len());
    let read = preprocessor::preprocess(text, &Includes::new(), &Overrides::new(), &mut files);
    let said = parser::parse(&read.tokens, text.len());
    read.faults.is_empty() && said.faults.is_empty()
}

/// Reads a text.
pub(super) fn read(
    (file, text): (&str, &str),
    includes: &Includes,
    overrides: &Overrides,
    device: &Device,
) -> Read {
    let mut files = Files::new(file, text.len());
    let first = preprocessor::preprocess(text, includes, overrides, &mut files);
    let said = parser::parse(&first.tokens, text.len());
    let mut machine = Machine::new(text, &files, device, overrides);
    machine.constants = first.numbers;
    machine.enumerations = said.enumerations;
    machine.faults = first.faults;
    machine.missing = first.missing;
    let broken = !said.faults.is_empty();
    machine.faults.extend(said.faults);
    machine.faults.extend(said.words);
    run_file(&mut machine, &said.statements);
    if !broken && !machine.faults.iter().any(Fault::is_error) {
        unreachable::tell(&mut machine, &said.statements);
    }
    let items = laid_out(&mut machine, broken);
    let placed = |all: Vec<Fault>| all.into_iter().map(|it| files.fault(it)).collect();
    Read {
        items,
        constants: machine.constants,
        faults: placed(machine.faults),
        undecided: placed(machine.undecided),
        titles: machine.titles,
        loops: machine.looped,
        posts: machine.unshown.len(),
    }
}

/// Runs a text whose host decides by what it reads, beside the array; its faults.
pub(super) fn run(
    (file, text): (&str, &str),
    includes: &Includes,
    overrides: &Overrides,
    device: &Device,
    array: &mut dyn Beside,
) -> Vec<Fault> {
    let mut files = Files::new(file, text.len());
    let first = preprocessor::preprocess(text, includes, overrides, &mut files);
    let parser::Said {
        statements,
        faults,
        words,
        enumerations,
    } = parser::parse(&first.tokens, text.len());
    let mut machine = Machine::new(text, &files, device, overrides);
    machine.enumerations = enumerations;
    machine.faults = [first.faults, faults, words].concat();
    machine.missing = first.missing;
    machine.companion = Some(Companion::new(array));
    run_file(&mut machine, &statements);
    machine.run_asked();
    // Without `main`, these are the statements of every frame.
    while !machine.functions.contains_key("main") && machine.another_frame() {
        run_file(&mut machine, &statements);
        machine.run_asked();
    }
    let (frames, steps) =
        { machine.companion }.map_or((1, Vec::new()), |it| (it.frames, it.faults));
    let placed = machine.faults.into_iter().map(|it| files.fault(it));
    let all = placed.chain(steps);
    all.map(|it| match it.severity {
        // The first frame is the one that is seen without a run, too.
        Severity::Error if frames > 1 => Fault {
            message: format!("{} (in frame {}, counted from 0)", it.message, frames - 1),
            ..it
        },
        _ => it,
    })
    .collect()
}

/// Runs what a file says.
fn run_file(machine: &mut Machine<'_>, statements: &[Stmt]) {
    define(machine, statements);
    top_level(machine, statements);
    let main = machine
        .functions
        .get("main")
        .and_then(|all| all.first())
        .cloned();
    if let Some(main) = main {
        machine.enter(&main, &[], main.place);
    } else if machine.items.is_empty() && machine.frames.is_empty() && !machine.has_run() {
        only_function(machine);
    }
    if let Some(kernel) = machine.recording.take() {
        machine.error(
            kernel.place,
            "this kernel has no end".to_owned(),
            "begins here",
            "end it with `end();` of the same object",
        );
    }
}

/// What it asked of the array, as a program.
fn laid_out(machine: &mut Machine<'_>, broken: bool) -> Vec<Item> {
    let place = Place::default();
    let items = std::mem::take(&mut machine.items);
    let mut frames = std::mem::take(&mut machine.frames);
    if machine.looped && !machine.bare {
        let init = frames.pop().unwrap_or_default();
        return vec![
            item(Node::Init(init), place),
            item(Node::Frame(items), place),
        ];
    }
    if machine.looped {
        return items;
    }
    frames.push(items);
    let all = machine.ended(frames);
    if all.is_empty() && machine.faults.is_empty() && machine.undecided.is_empty() && !broken {
        machine.error(
            place,
            "nothing in this file uses the array".to_owned(),
            "this file",
            "a program has statements, or a `main` with a loop over the frames",
        );
    }
    all
}

/// Defines every function, so that those below can be called from above.
fn define(machine: &mut Machine<'_>, statements: &[Stmt]) {
    for statement in statements {
        match &statement.node {
            StmtNode::Function(function) => machine.define(function),
            StmtNode::Prototype(function) => machine.declare_function(function),
            StmtNode::Class(members) => machine.define_members(members),
            StmtNode::Block(inner) | StmtNode::Namespace(_, inner) => define(machine, inner),
            _ => {}
        }
    }
}

/// Runs what stands outside of functions.
fn top_level(machine: &mut Machine<'_>, statements: &[Stmt]) {
    for statement in statements {
        match &statement.node {
            StmtNode::Block(inner) => top_level(machine, inner),
            StmtNode::Namespace(space, inner) => {
                let outer = std::mem::replace(&mut machine.space, space.clone());
                top_level(machine, inner);
                machine.space = outer;
            }
            _ => {
                machine.file = machine.files.name(statement.place);
                machine.statements(std::slice::from_ref(statement));
            }
        }
    }
}

/// A file of functions without `main`: its only one that no other calls.
fn only_function(machine: &mut Machine<'_>) {
    let all: Vec<std::rc::Rc<Function>> = machine.functions.values().flatten().cloned().collect();
    let roots: Vec<_> = all
        .iter()
        .filter(|it| {
            !all.iter()
                .any(|other| effects::calls_function(other, &it.name))
        })
        .filter(|it| it.body.iter().any(|part| effects::changes(machine, part)))
        .cloned()
        .collect();
    if let [one] = &roots[..]
        && one
            .parameters
            .iter()
            .all(|parameter| parameter.default.is_some())
    {
        machine.enter(one, &[], one.place);
        return;
    }
    let Some(first) = roots.first() else {
        return;
    };
    let names: Vec<String> = roots.iter().map(|it| format!("`{}`", it.name)).collect();
    machine.error(
        first.place,
        format!("there is no `main` to say which of {} runs", names.join(", ")),
        "the first of them",
        "write a file that includes this one and calls the function to run, such as `int main() { f(A); }`",
    );
}
