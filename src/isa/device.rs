//! A chip: its registers, its numbers, its instructions.

use std::sync::Arc;

use super::{
    Analog, Bit, Digital, Direction, Evidence, Figure, HostKind, HostRow, Kind, Macro, Operands,
    Primitive, PrimitiveRow, Quantity, Signature, Source, Target, Value, row::neighbour_name,
};

/// A chip, read from `isa/<name>/` and checked.
#[derive(Clone, Debug)]
pub struct Device {
    pub(super) name: String,
    pub(super) title: String,
    pub(super) registers: Registers,
    /// In the order of [`Figure::ALL`].
    pub(super) figures: Vec<Quantity>,
    pub(super) primitives: Vec<PrimitiveRow>,
    pub(super) hosts: Vec<HostRow>,
    pub(super) macros: Vec<Macro>,
    /// What it extends.
    pub(super) base: Option<Arc<Device>>,
}

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
        if self.figure.domain().holds(self.value) {
            return "the low end of the range lies below the high one".to_owned();
        }
        format!("give {}", self.figure.domain().instead_of(self.value))
    }
}

/// The registers of a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Registers {
    /// Names of the analogue ones; [`Analog`] is an index into them.
    pub analog: Vec<String>,
    /// The one that neighbours can reach.
    pub news: Analog,
    /// Names of the one-bit ones; [`Digital`] is an index into them.
    pub digital: Vec<String>,
    /// Other names of one-bit registers.
    pub aliases: Vec<(String, Digital)>,
    /// What the hardware uses some of them for.
    pub roles: Roles,
}

/// One-bit registers that the hardware itself reads or writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Roles {
    /// `propagated` is written, and propagation passes, only where this is 1.
    pub mask: Digital,
    /// The one that propagation spreads.
    pub propagated: Digital,
    /// Where these are 1, the neighbour in this direction is read: north, east, south, west.
    pub enable: [Digital; 4],
}

impl Roles {
    /// The register that enables reading from this direction.
    #[must_use]
    pub const fn enables(&self, direction: Direction) -> Digital {
        let [north, east, south, west] = self.enable;
        match direction {
            Direction::North => north,
            Direction::East => east,
            Direction::South => south,
            Direction::West => west,
        }
    }

    /// The register that opens the links of the diffusion network to this neighbour and to the
    /// one opposite: R1 along columns, R2 along rows.
    #[must_use]
    pub const fn links(&self, direction: Direction) -> Digital {
        match direction {
            Direction::North | Direction::South => self.enables(Direction::South),
            Direction::East | Direction::West => self.enables(Direction::West),
        }
    }
}

/// One thing that a statement can be.
#[derive(Clone, Copy, Debug)]
pub enum Callable<'a> {
    /// An instruction word.
    Primitive(Kind, &'a Signature),
    /// A sequence of statements.
    Macro(&'a Macro),
    /// Something that the host does.
    Host(HostKind, &'a Signature),
}

impl<'a> Callable<'a> {
    /// What it takes.
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

    /// The same chip with another value of a number: what if.
    ///
    /// # Errors
    /// When the value makes no sense for it.
    pub fn what_if(mut self, figure: Figure, value: f64) -> Result<Self, FigureError> {
        if !figure.domain().holds(value) {
            return Err(FigureError { figure, value });
        }
        // Loading fills the list in the order of the enum.
        let quantity = &mut self.figures[figure as usize];
        quantity.value = value;
        "set for this run".clone_into(&mut quantity.source);
        quantity.evidence = Evidence::Guess;
        quantity.note = None;
        let (low, high) = (self.value(Figure::Lowest), self.value(Figure::Highest));
        if low >= high {
            return Err(FigureError { figure, value });
        }
        Ok(self)
    }

    /// What a word reads, writes and does to FLAG on this chip.
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

    /// The macros, in the order of the file.
    #[must_use]
    pub fn macros(&self) -> &[Macro] {
        &self.macros
    }

    /// The row of a primitive.
    #[must_use]
    pub fn row(&self, kind: Kind) -> &PrimitiveRow {
        // Loading sorts the rows by kind and checks that none is missing.
        &self.primitives[kind as usize]
    }

    /// The row of a host operation.
    #[must_use]
    pub fn host(&self, kind: HostKind) -> &HostRow {
        &self.hosts[kind as usize]
    }

    /// Instruction words of a primitive.
    #[must_use]
    pub fn words(&self, primitive: &Primitive) -> u64 {
        self.row(primitive.kind()).words
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

    /// What a name means on this chip.
    #[must_use]
    pub fn value_of(&self, name: &str) -> Option<Value> {
        let Registers {
            analog,
            digital,
            aliases,
            ..
        } = &self.registers;
        if let Some(at) = analog.iter().position(|n| n == name) {
            return Some(Value::Source(Source::Register(Analog(at as u8))));
        }
        if let Some(at) = digital.iter().position(|n| n == name) {
            return Some(Value::Bit(Bit::Register(Digital(at as u8))));
        }
        if let Some((_, register)) = aliases.iter().find(|(alias, _)| alias == name) {
            return Some(Value::Bit(Bit::Register(*register)));
        }
        FIXED_NAMES
            .iter()
            .find(|(fixed, _)| *fixed == name)
            .map(|(_, value)| value())
    }

    /// All names that mean something on this chip.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        let registers = &self.registers;
        registers
            .analog
            .iter()
            .chain(&registers.digital)
            .chain(registers.aliases.iter().map(|(alias, _)| alias))
            .map(String::as_str)
            .chain(FIXED_NAMES.iter().map(|(name, _)| *name))
    }

    /// Name of an analogue register.
    #[must_use]
    pub fn analog_name(&self, register: Analog) -> String {
        let name = self.registers.analog.get(usize::from(register.0));
        name.cloned()
            .unwrap_or_else(|| format!("<analogue {}>", register.0))
    }

    /// Name of a one-bit register.
    #[must_use]
    pub fn digital_name(&self, register: Digital) -> String {
        let name = self.registers.digital.get(usize::from(register.0));
        name.cloned()
            .unwrap_or_else(|| format!("<digital {}>", register.0))
    }

    /// Name of an analogue source.
    #[must_use]
    pub fn source_name(&self, source: Source) -> String {
        match source {
            Source::Register(register) => self.analog_name(register),
            Source::Pix => "PIX".to_owned(),
            Source::In => "IN".to_owned(),
            Source::Neighbour(direction) => neighbour_name(direction).to_owned(),
        }
    }

    /// Name of an analogue target.
    #[must_use]
    pub fn target_name(&self, target: Target) -> String {
        match target {
            Target::Register(register) => self.analog_name(register),
            Target::Neighbour(direction) => neighbour_name(direction).to_owned(),
        }
    }

    /// Name of a one-bit source.
    #[must_use]
    pub fn bit_name(&self, bit: Bit) -> String {
        match bit {
            Bit::Register(register) => self.digital_name(register),
            Bit::Flag => "FLAG".to_owned(),
            Bit::Select => "SELECT".to_owned(),
            Bit::Rect => "RECT".to_owned(),
        }
    }

    /// How much of what is known about the chip is a guess: the figures of this evidence.
    pub fn figures_of(&self, evidence: Evidence) -> impl Iterator<Item = Figure> {
        Figure::ALL
            .iter()
            .copied()
            .filter(move |f| self.figure(*f).evidence == evidence)
    }
}

type FixedName = (&'static str, fn() -> Value);

/// Names that mean the same on every chip.
const FIXED_NAMES: &[FixedName] = &[
    ("PIX", || Value::Source(Source::Pix)),
    ("IN", || Value::Source(Source::In)),
    ("XN", || Value::Source(Source::Neighbour(Direction::North))),
    ("XE", || Value::Source(Source::Neighbour(Direction::East))),
    ("XS", || Value::Source(Source::Neighbour(Direction::South))),
    ("XW", || Value::Source(Source::Neighbour(Direction::West))),
    ("FLAG", || Value::Bit(Bit::Flag)),
    ("SELECT", || Value::Bit(Bit::Select)),
    ("RECT", || Value::Bit(Bit::Rect)),
    ("north", || Value::Directions(vec![Direction::North])),
    ("east", || Value::Directions(vec![Direction::East])),
    ("south", || Value::Directions(vec![Direction::South])),
    ("west", || Value::Directions(vec![Direction::West])),
    ("alldir", || Value::Directions(Direction::ALL.to_vec())),
    ("true", || Value::Number(1.0)),
    ("false", || Value::Number(0.0)),
];
