//! Which words a chip has, and whether what was compiled keeps to them.

use crate::{
    compile::{
        error::CompileError,
        intermediate::plan::{Plan, SOURCES, SOURCES_SPLIT, Store, Word},
    },
    config::Place,
    isa::{
        Device, Direction, PrimitiveKind, Signature, Source, Value,
        signature::{Given, Mode},
    },
    program::Program,
};

/// The bus words of a chip that filters are made of: to one target and to two, from so many sources.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::compile) struct Buses([[bool; SOURCES + 1]; 2]);

impl Buses {
    /// As the chip's forms have them.
    pub(in crate::compile) fn from_device(device: &Device) -> Self {
        let has = |name: &str, arguments: usize| {
            let neighbour = Value::Source(Source::Neighbour(Direction::North));
            let given = vec![
                Given {
                    values: vec![neighbour],
                    group: false,
                    place: Place::default(),
                };
                arguments
            ];
            let callables = device.callables(name);
            { callables.iter() }.any(|it| it.signature().bind(&given).is_ok())
        };
        let of = |name, targets| std::array::from_fn(|sources| has(name, targets + sources));
        Self([of("bus", 1), of("bus2", 2)])
    }

    /// The form of a word that is not there, as `primitives.toml` has it: a split before others,
    /// which filters can do without.
    pub(in crate::compile) fn missing(&self) -> Option<&'static str> {
        let Self([one, two]) = self;
        if two[1..=SOURCES_SPLIT].contains(&false) {
            return Some("bus2(out y: target, out z: target, x: source * 1..2)");
        }
        let all_there = !one[..=SOURCES].contains(&false);
        (!all_there).then_some("bus(out y: target, x: source * 0..4)")
    }

    /// Whether there is a word that halves one source.
    pub(in crate::compile) const fn halve(&self) -> bool {
        self.0[1][1]
    }

    /// Whether any word splits a sum.
    pub(in crate::compile) fn split(&self) -> bool {
        self.0[1].contains(&true)
    }

    /// Whether all words of a plan are there.
    pub(in crate::compile) fn have(&self, plan: &Plan) -> bool {
        let one = |word: &Word| {
            let sources = word.views.len() + word.values.len();
            let targets = match word.store {
                Store::Both(_) => 2,
                Store::Register | Store::News(_) => 1 + usize::from(word.halved),
            };
            self.0[targets - 1].get(sources) == Some(&true)
        };
        plan.words.iter().all(one)
    }
}

/// Whether a bus of the chip to one target, or to two, takes more sources than filters make use of.
pub(in crate::compile) fn has_wider_bus(device: &Device) -> bool {
    let forms = &device.row(PrimitiveKind::Bus).forms;
    let plain = { forms.iter() }.filter(|form| form.parameters.iter().all(|it| !it.group));
    let wider = |form: &Signature| {
        let (targets, sources): (Vec<_>, Vec<_>) =
            { form.parameters.iter() }.partition(|it| it.mode == Mode::Out);
        let sources: usize = sources.iter().map(|it| it.count.1).sum();
        match targets.len() {
            1 => sources > SOURCES,
            2 => sources > SOURCES_SPLIT,
            _ => false,
        }
    };
    plain.into_iter().any(wider)
}

/// Checks that a chip has every word of a program; how many of them it holds is another question.
///
/// # Errors
/// When it does not: the first that is missing.
pub fn check_words(text: &str, device: &Device) -> Result<(), CompileError> {
    let fault = match Program::parse("compiled", text) {
        Ok(program) => program.refused(device),
        Err(faults) => faults.faults.into_iter().next().map(|first| first.fault),
    };
    fault.map_or(Ok(()), |fault| {
        let statement = text.get(fault.place.start..fault.place.end);
        Err(CompileError::Missing {
            chip: device.name().to_owned(),
            why: match statement {
                Some(statement) if statement.contains('(') => {
                    let statement = statement.trim_end_matches(';');
                    format!("{}: the program needs `{statement}`", fault.message)
                }
                _ => fault.message,
            },
        })
    })
}
