//! A chip as data: its registers, figures and instructions.

use std::{cmp::Reverse, sync::Arc};

use crate::order::Order as _;

use super::{
    Analog, Evidence, Figure, HostKind, HostRow, Interval, LeftOut, Macro, Operands, Primitive,
    PrimitiveKind, PrimitiveRow, Quantity, Registers, Signature,
};

/// A number about the chip that makes no sense.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error, miette::Diagnostic)]
#[error("{}.{} cannot be {}", figure.key().0, figure.key().1, figure.shown(*value))]
#[diagnostic(help("{}", self.help()))]
pub struct FigureError {
    /// Which number.
    pub figure: Figure,
    /// The value that was given.
    pub value: f64,
}

impl FigureError {
    fn help(&self) -> String {
        if self.figure.range().holds(self.value) {
            return "the low end of the range lies below the high one, and the range holds 0"
                .to_owned();
        }
        format!("give {}", self.figure.range().instead_of(self.value))
    }
}

/// A chip, read from `isa/<name>/` and checked. Copies share its lists: a sample of an array is many
/// small arrays of one chip.
#[derive(Clone, Debug)]
pub struct Device {
    pub(super) name: String,
    pub(super) title: String,
    pub(super) registers: Registers,
    /// In the order of [`Figure::ALL`].
    pub(super) figures: Arc<Vec<Quantity>>,
    pub(super) primitives: Arc<Vec<PrimitiveRow>>,
    pub(super) hosts: Arc<Vec<HostRow>>,
    pub(super) macros: Arc<Vec<Macro>>,
    pub(super) left_out: Arc<Vec<LeftOut>>,
    /// The chip that it extends.
    pub(super) base: Option<Arc<Device>>,
}

/// One meaning of a statement.
#[derive(Clone, Copy, Debug)]
pub enum Callable<'a> {
    /// An instruction word.
    Primitive(PrimitiveKind, &'a Signature),
    /// A sequence of statements.
    Macro(&'a Macro),
    /// Something that the host does.
    Host(HostKind, &'a Signature),
}

impl<'a> Callable<'a> {
    /// Its form: name and parameters.
    #[must_use]
    pub const fn signature(&self) -> &'a Signature {
        match self {
            Self::Primitive(_, signature) | Self::Host(_, signature) => signature,
            Self::Macro(it) => &it.signature,
        }
    }
}

impl Device {
    /// Name of the chip.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The chip in a few words.
    #[must_use]
    pub fn title(&self) -> &str {
        &self.title
    }

    /// The chip that it extends.
    #[must_use]
    pub fn base(&self) -> Option<&Self> {
        self.base.as_deref()
    }

    /// The registers of a pixel.
    #[must_use]
    pub const fn registers(&self) -> &Registers {
        &self.registers
    }

    /// A number about the chip.
    #[must_use]
    pub fn figure(&self, figure: Figure) -> &Quantity {
        // Loading fills the list in the order of the enum.
        &self.figures[figure as usize]
    }

    /// The value of a number about the chip.
    #[must_use]
    pub fn value(&self, figure: Figure) -> f64 {
        self.figure(figure).value
    }

    /// The lowest and the highest value of an analogue register, LSB: what the host's converters set,
    /// too.
    #[must_use]
    pub fn register_range(&self) -> (f64, f64) {
        (self.value(Figure::Lowest), self.value(Figure::Highest))
    }

    /// Between which values a number about the chip may lie; none where that was not stated.
    #[must_use]
    pub fn interval(&self, figure: Figure) -> Option<&Interval> {
        self.figure(figure).interval.as_ref()
    }

    /// The same chip with another value of a number, which is then that and no other: what if.
    ///
    /// # Errors
    /// When the value makes no sense for it.
    pub fn what_if(mut self, figure: Figure, value: f64) -> Result<Self, FigureError> {
        if !figure.range().holds(value) {
            return Err(FigureError { figure, value });
        }
        // Loading fills the list in the order of the enum.
        let quantity = &mut Arc::make_mut(&mut self.figures)[figure as usize];
        quantity.value = value;
        "set for this run".clone_into(&mut quantity.source);
        quantity.evidence = Evidence::Guess;
        quantity.note = None;
        quantity.interval = None;
        let (low, high) = self.register_range();
        if low >= high || low > 0.0 || high < 0.0 {
            return Err(FigureError { figure, value });
        }
        Ok(self)
    }

    /// The operands of a word: what it reads, writes and does to FLAG on this chip.
    #[must_use]
    pub fn operands(&self, word: &Primitive) -> Operands {
        word.operands(self.registers.news, self.registers.roles)
    }

    /// The rows of `primitives.toml`.
    #[must_use]
    pub fn primitives(&self) -> &[PrimitiveRow] {
        &self.primitives
    }

    /// The rows of the host's operations.
    #[must_use]
    pub fn hosts(&self) -> &[HostRow] {
        &self.hosts
    }

    /// The macros: those of the chip's own file first, each file in its order.
    #[must_use]
    pub fn macros(&self) -> &[Macro] {
        &self.macros
    }

    /// The row of a primitive.
    #[must_use]
    pub fn row(&self, kind: PrimitiveKind) -> &PrimitiveRow {
        // Loading sorts the rows by kind and checks that none is missing.
        &self.primitives[kind as usize]
    }

    /// The row of a host operation.
    #[must_use]
    pub fn host(&self, kind: HostKind) -> &HostRow {
        &self.hosts[kind as usize]
    }

    /// Instruction words that a primitive takes.
    #[must_use]
    pub fn words(&self, primitive: &Primitive) -> u64 {
        self.row(primitive.kind()).words()
    }

    /// NEWS, the analogue register that neighbours can reach.
    #[must_use]
    pub const fn news(&self) -> Analog {
        self.registers.news
    }

    /// All that a statement of this name can be.
    #[must_use]
    pub fn callables(&self, name: &str) -> Vec<Callable<'_>> {
        self.all_callables()
            .filter(|c| c.signature().name == name)
            .collect()
    }

    /// The same, in the order in which they are tried: the first that takes a statement's arguments
    /// is meant. A form for a number comes before those for any.
    #[must_use]
    pub fn tried(&self, name: &str) -> Vec<Callable<'_>> {
        let mut all = self.callables(name);
        all.order_by_key(|it| Reverse(it.signature().literals()));
        all
    }

    /// All that a statement can be.
    pub fn all_callables(&self) -> impl Iterator<Item = Callable<'_>> {
        let primitives = self.primitives.iter().flat_map(|row| {
            let form = |f| Callable::Primitive(row.kind, f);
            row.forms.iter().map(form)
        });
        let hosts = self.hosts.iter().flat_map(|row| {
            let form = |f| Callable::Host(row.kind, f);
            row.forms.iter().map(form)
        });
        primitives
            .chain(self.macros.iter().map(Callable::Macro))
            .chain(hosts)
    }

    /// The figures about the chip whose evidence is `evidence`.
    pub fn figures_of(&self, evidence: Evidence) -> impl Iterator<Item = Figure> {
        Figure::ALL
            .iter()
            .copied()
            .filter(move |f| self.figure(*f).evidence == evidence)
    }
}
