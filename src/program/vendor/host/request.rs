//! What the micro-controller asks of the array.

use crate::{
    config::{Fault, Place},
    isa::{
        Callable,
        text::{Argument, Expression, Statement, Term},
    },
    program::{
        syntax::{Item, Node},
        vendor::{
            analysis::effects,
            interpreter::{machine::Machine, reason::Reason, value::Value},
            syntax::tree::{Expr, last},
        },
    },
};

/// Frames that are laid out one after the other, where no loop over the frames is.
const FRAMES: usize = 64;

/// Statements that may be asked of the array.
const ASKED: usize = crate::limit::EXPANDED_STEPS;

impl Machine<'_> {
    /// Whether the host does this, outside of kernels.
    pub(in crate::program::vendor) fn is_host(&self, name: &str) -> bool {
        let all = self.device.callables(name);
        all.iter().any(|it| match it {
            Callable::Host(..) => true,
            Callable::Macro(it) => it.host,
            Callable::Primitive(..) => false,
        })
    }

    pub(in crate::program::vendor) fn line(&self, place: Place) -> String {
        self.files.line(self.text, place)
    }

    /// Asks something of the array.
    pub(super) fn ask(&mut self, name: &str, arguments: Vec<Term>, place: Place) {
        if let Some(why) = self.maybe.clone() {
            let message = format!("whether `{name}` runs depends on {why}");
            self.unknown(place, message, &why, None);
        }
        if !self.asks(1, place) {
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

    /// Whether so many more statements may be asked; tells where they may not.
    pub(in crate::program::vendor) fn asks(&mut self, count: usize, place: Place) -> bool {
        self.asked += count;
        let fits = self.asked <= ASKED;
        if !fits && !self.full {
            self.full = true;
            self.error(
                place,
                format!("the program expands to more than {ASKED} statements"),
                "the limit is reached here",
                "loop less often, or give loops outside of kernels the same body in every iteration",
            );
        }
        fits
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

    /// While a kernel is recorded, what the host does is done at once, before the kernel's words.
    pub(in crate::program::vendor) fn push(&mut self, node: Node, place: Place) {
        let word = match &node {
            Node::Statement(statement) => !self.is_host(&statement.name),
            _ => false,
        };
        let items = match &mut self.recording {
            Some(recording) if word => &mut recording.words,
            _ => &mut self.items,
        };
        items.push(item(node, place));
    }

    /// A fault that something depends on what only the run knows.
    pub(in crate::program::vendor) fn unknown(
        &mut self,
        place: Place,
        message: String,
        why: &Reason,
        of: Option<&Expr>,
    ) {
        let name = of.and_then(|it| effects::unknown(self, it));
        let way = way(why, name.as_deref());
        let (label, help) = match (why, &self.companion) {
            (Reason::Never(_) | Reason::Started(_), _) => {
                ("not known", format!("{way}, or remove this"))
            }
            (Reason::Run(_), Some(_)) => ("not known here", format!("{way}, or remove this")),
            (Reason::Run(_), None) => (
                "known only at run time",
                format!(
                    "`exec` runs it, with the host beside the array. Here every frame must have the same instruction words: {way}, or remove this"
                ),
            ),
        };
        self.undecided(Fault::error(place, message, label).help(help));
    }

    /// Warns of a readout of which only the run knows: a program that has to be known before goes
    /// without it.
    pub(in crate::program::vendor) fn unread(&mut self, place: Place, what: &str, why: &Reason) {
        if self.companion.is_some() {
            let message = format!("{what} depends on {why}: it is left out");
            let fault = Fault::warning(place, message, "not known here");
            self.fault(fault.help(way(why, None)));
            return;
        }
        let message = format!("{what} depends on {why}: here it is left out");
        self.undecided(match why {
            Reason::Started(_) => Fault::warning(place, message, "not known").help(way(why, None)),
            _ => Fault::warning(place, message, "known only at run time")
                .help("`exec` runs it, with the host beside the array"),
        });
    }

    /// Warns of what is shown where only the run knows whether: beside the array it is, since nothing
    /// else hangs on it.
    pub(in crate::program::vendor) fn shown(&mut self, place: Place, what: &str, why: &Reason) {
        if self.companion.is_none() {
            self.unread(place, what, why);
            return;
        }
        let message = format!("{what} depends on {why}: it is shown");
        let fault = Fault::warning(place, message, "not known here");
        self.fault(fault.help(way(why, None)));
    }

    /// A new frame begins.
    pub(in crate::program::vendor) fn sync(&mut self, place: Place) {
        self.dark = false;
        if self.companion.is_some() {
            self.next_frame();
            return;
        }
        if self.frames.len() == FRAMES && !self.full {
            self.full = true;
            let message = format!("more than {FRAMES} frames in sequence");
            self.undecided(Fault::error(place, message, "one more begins here").help(
                "`exec` runs it, with the host beside the array. Here every frame must be the same: write one frame in a `while (1)` loop",
            ));
        }
        let items = std::mem::take(&mut self.items);
        self.frames.push(items);
    }
}

/// What to do about what is not known, with the variable that holds it.
fn way(why: &Reason, name: Option<&str>) -> String {
    // Only a variable can be given a value.
    let name = match (name, why) {
        (Some(name), _) => name,
        (None, Reason::Started(name)) => &**name,
        (None, _) => return "use only the C++ that docs/vendor-code.md lists".to_owned(),
    };
    format!("give the value with `--const {}=VALUE`", last(name))
}

pub(in crate::program::vendor) const fn item(node: Node, place: Place) -> Item {
    Item {
        node,
        blank_before: false,
        trailing: None,
        place,
    }
}

/// A value as an argument of a statement; `None` where it is none.
pub(super) fn term(value: &Value) -> Option<Term> {
    let place = Place::default();
    Some(match value {
        Value::Whole(_) | Value::Wide(..) | Value::Real(_) | Value::Single(_) => {
            let number = value.decimal()?;
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
