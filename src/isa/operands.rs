//! Operands: what an instruction word reads and writes, and what it does to FLAG. This is the only
//! place that says so.
//!
//! Liveness, halos, basic blocks, the rules of expansion and the checks of programs are folds
//! over [`Primitive::operands`]. What a word computes is in `array/semantics.rs`.

use smallvec::{SmallVec, smallvec};

use super::{Analog, Bit, Digital, Direction, Primitive, Roles, Source, Target};

/// A storage cell of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Cell {
    /// An analogue register.
    Analog(Analog),
    /// A one-bit register.
    Digital(Digital),
    /// The activity flag.
    Flag,
}

/// What a word can be connected to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Terminal {
    /// A storage cell.
    Cell(Cell),
    /// The photodiode.
    Pix,
    /// The global input (DAC).
    In,
    /// The address decoder's line, plain or with the enable bits of a rectangle.
    Select,
}

/// How a word uses a terminal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// As an operand of the computation.
    Read,
    /// As a switch that decides what is connected.
    Gate,
    /// As a mask that decides in which pixels the result is stored.
    Mask,
    /// As a destination.
    Write,
}

/// One connection of a word, seen from the pixel that executes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Access {
    /// What is connected.
    pub terminal: Terminal,
    /// Rows and columns to the pixel that has it: (0, 0) for its own.
    pub offset: (isize, isize),
    /// What is done with it.
    pub how: Use,
}

impl Access {
    /// The storage cell, if it is one.
    #[must_use]
    pub const fn cell(&self) -> Option<Cell> {
        match self.terminal {
            Terminal::Cell(cell) => Some(cell),
            Terminal::Pix | Terminal::In | Terminal::Select => None,
        }
    }

    /// The analogue register, if it is one.
    #[must_use]
    pub const fn analog(&self) -> Option<Analog> {
        match self.cell() {
            Some(Cell::Analog(register)) => Some(register),
            Some(Cell::Digital(_) | Cell::Flag) | None => None,
        }
    }

    /// The one-bit register, if it is one.
    #[must_use]
    pub const fn digital(&self) -> Option<Digital> {
        match self.cell() {
            Some(Cell::Digital(register)) => Some(register),
            Some(Cell::Analog(_) | Cell::Flag) | None => None,
        }
    }

    /// Whether an analogue bus can have it.
    const fn is_on_bus(&self) -> bool {
        matches!(
            self.terminal,
            Terminal::Cell(Cell::Analog(_)) | Terminal::Pix | Terminal::In
        )
    }
}

/// The effect of a word on FLAG.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlagEffect {
    /// Leaves it as it is.
    Keeps,
    /// Makes it 1 in all pixels.
    Sets,
    /// Writes it; it may be 0 somewhere afterwards.
    May,
}

/// The functional unit of the pixel that executes a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// None that a program can see: waiting, or making a network ready.
    Idle,
    /// The photodiode.
    Photodiode,
    /// The analogue summing bus.
    Bus,
    /// The squarer, which reads a bus.
    Squarer,
    /// The diffusion network.
    Diffusion,
    /// One-bit logic of the pixel alone.
    Logic,
    /// One-bit logic over the four neighbours.
    Neighbours,
    /// The propagation network: as far as a bit gets within one word.
    Propagation,
}

/// The operands of a word: all that must be known to reorder, mask, tile or drop it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Operands {
    /// Its connections: writes first.
    pub accesses: SmallVec<[Access; 8]>,
    /// What it does to FLAG.
    pub flag: FlagEffect,
    /// Which part of the pixel does it.
    pub unit: Unit,
}

impl Operands {
    fn new(unit: Unit) -> Self {
        Self {
            accesses: smallvec![],
            flag: FlagEffect::Keeps,
            unit,
        }
    }

    fn and(mut self, how: Use, terminal: Terminal, offset: (isize, isize)) -> Self {
        self.accesses.push(Access {
            terminal,
            offset,
            how,
        });
        self
    }

    fn own(self, how: Use, cell: Cell) -> Self {
        self.and(how, Terminal::Cell(cell), (0, 0))
    }

    fn sources(self, sources: &[Source], news: Analog) -> Self {
        sources.iter().fold(self, |operands, source| {
            let own = (0, 0);
            let (terminal, offset) = match source {
                Source::Register(register) => (Terminal::Cell(Cell::Analog(*register)), own),
                Source::Pix => (Terminal::Pix, own),
                Source::In => (Terminal::In, own),
                Source::Neighbour(direction) => {
                    (Terminal::Cell(Cell::Analog(news)), direction.step())
                }
            };
            operands.and(Use::Read, terminal, offset)
        })
    }

    fn bits(self, bits: &[Bit]) -> Self {
        bits.iter()
            .fold(self, |operands, bit| operands.bit(*bit, (0, 0)))
    }

    fn bit(self, bit: Bit, offset: (isize, isize)) -> Self {
        let terminal = match bit {
            Bit::Register(register) => Terminal::Cell(Cell::Digital(register)),
            Bit::Flag => Terminal::Cell(Cell::Flag),
            Bit::Select | Bit::Rect => Terminal::Select,
        };
        self.and(Use::Read, terminal, offset)
    }

    /// Adds one-bit destinations; `propagated` has a mask of its own.
    fn targets(self, targets: &[Digital], roles: Roles) -> Self {
        targets.iter().fold(self, |operands, target| {
            let operands = operands.own(Use::Write, Cell::Digital(*target));
            if *target == roles.propagated {
                operands.own(Use::Mask, Cell::Digital(roles.mask))
            } else {
                operands
            }
        })
    }

    /// Masks its stores by FLAG.
    fn masked(self) -> Self {
        self.own(Use::Mask, Cell::Flag)
    }

    /// It writes FLAG.
    fn flag(self, flag: FlagEffect) -> Self {
        Self { flag, ..self }.own(Use::Write, Cell::Flag)
    }

    /// Its operands in the computation.
    pub fn reads(&self) -> impl Iterator<Item = &Access> {
        self.accesses.iter().filter(|a| a.how == Use::Read)
    }

    /// Whether it reads the photodiode.
    #[must_use]
    pub fn reads_light(&self) -> bool {
        self.reads().any(|it| it.terminal == Terminal::Pix)
    }

    /// Its destinations.
    pub fn writes(&self) -> impl Iterator<Item = &Access> {
        self.accesses.iter().filter(|a| a.how == Use::Write)
    }

    /// The storage cells whose content matters to it, FLAG and other masks included.
    pub fn cells_read(&self) -> impl Iterator<Item = Cell> {
        let read = self.accesses.iter().filter(|a| a.how != Use::Write);
        read.filter_map(Access::cell)
    }

    /// The storage cells that it writes.
    pub fn cells_written(&self) -> impl Iterator<Item = Cell> {
        self.writes().filter_map(Access::cell)
    }

    /// Whether its stores replace the old content in all pixels, so that the old content is dead:
    /// no mask keeps any. `whole`: FLAG is 1 in all pixels.
    #[must_use]
    pub fn replaces(&self, whole: bool) -> bool {
        let mut masks = self.accesses.iter().filter(|a| a.how == Use::Mask);
        masks.all(|mask| whole && mask.cell() == Some(Cell::Flag))
    }

    /// The halo: how far, in rows and in columns, the cells that it reads lie from those that it
    /// writes. `usize::MAX` where there is no bound.
    #[must_use]
    pub fn halo(&self) -> [usize; 2] {
        if self.unit == Unit::Propagation {
            return [usize::MAX; 2];
        }
        let mut halo = [0, 0];
        for write in self.writes() {
            for read in self.accesses.iter().filter(|a| a.how != Use::Write) {
                halo[0] = halo[0].max((read.offset.0 - write.offset.0).unsigned_abs());
                halo[1] = halo[1].max((read.offset.1 - write.offset.1).unsigned_abs());
            }
        }
        halo
    }

    /// The register that must be copied before the word: it is read in one pixel after it may have
    /// been written for another. On an analogue bus only NEWS can be both; propagation makes its
    /// own copy.
    #[must_use]
    pub fn copied(&self) -> Option<Cell> {
        if self.unit == Unit::Propagation {
            return None;
        }
        let reads_again = |cell: &Cell| {
            self.reads().any(|read| {
                let far = read.offset != (0, 0) || matches!(cell, Cell::Analog(_));
                far && read.cell() == Some(*cell)
            })
        };
        let mut written = self.cells_written().filter(|cell| *cell != Cell::Flag);
        written.find(reads_again)
    }

    /// A terminal that is twice on its analogue bus, which would be one connection. The squarer's
    /// result is not on the bus that it reads.
    #[must_use]
    pub fn twice(&self) -> Option<Access> {
        let connected = |a: &&Access| match a.how {
            Use::Read => a.is_on_bus(),
            Use::Write => a.is_on_bus() && self.unit != Unit::Squarer,
            Use::Gate | Use::Mask => false,
        };
        let on_bus = || self.accesses.iter().filter(connected);
        let same = |a: &Access, b: &Access| (a.terminal, a.offset) == (b.terminal, b.offset);
        on_bus()
            .enumerate()
            .find(|(i, access)| on_bus().take(*i).any(|before| same(before, access)))
            .map(|(_, access)| *access)
    }
}

impl Primitive {
    /// Its operands on a chip where neighbours reach `news`.
    #[must_use]
    pub fn operands(&self, news: Analog, roles: Roles) -> Operands {
        let analog = Cell::Analog;
        match self {
            Self::Nop => Operands::new(Unit::Idle),
            Self::ResetPix => {
                Operands::new(Unit::Photodiode).and(Use::Write, Terminal::Pix, (0, 0))
            }
            Self::Bus { targets, sources } => {
                let bus = Operands::new(Unit::Bus);
                let stored = targets.iter().fold(bus, |bus, target| match target {
                    Target::Register(register) => bus.own(Use::Write, analog(*register)),
                    Target::Neighbour(direction) => {
                        bus.and(Use::Write, Terminal::Cell(analog(news)), direction.step())
                    }
                });
                stored.sources(sources, news).masked()
            }
            Self::Square { sources } => Operands::new(Unit::Squarer)
                .own(Use::Write, analog(news))
                .sources(sources, news)
                .masked(),
            Self::Where { sources } => Operands::new(Unit::Bus)
                .flag(FlagEffect::May)
                .sources(sources, news),
            Self::All => Operands::new(Unit::Logic).flag(FlagEffect::Sets),
            Self::BlurSet => Operands::new(Unit::Idle)
                .own(Use::Read, Cell::Digital(roles.links(Direction::South)))
                .own(Use::Read, Cell::Digital(roles.links(Direction::West))),
            Self::Blur {
                target,
                source,
                horizontal,
                vertical,
            } => {
                let blur = Operands::new(Unit::Diffusion)
                    .own(Use::Write, analog(*target))
                    .own(Use::Read, analog(*source))
                    .masked();
                let linked = |direction: &Direction| match direction {
                    Direction::North | Direction::South => *vertical,
                    Direction::East | Direction::West => *horizontal,
                };
                let linked = Direction::ALL.into_iter().filter(linked);
                linked.fold(blur, |blur, direction| {
                    let there = direction.step();
                    let gate = Cell::Digital(roles.links(direction));
                    blur.and(Use::Read, Terminal::Cell(analog(*source)), there)
                        .own(Use::Gate, gate)
                        .and(Use::Gate, Terminal::Cell(gate), there)
                })
            }
            Self::Set { targets } | Self::Clear { targets } => {
                Operands::new(Unit::Logic).targets(targets, roles)
            }
            Self::Or { target, sources } | Self::Nor { target, sources } => {
                Operands::new(Unit::Logic)
                    .targets(&[*target], roles)
                    .bits(sources)
            }
            Self::WhereBit { sources } => Operands::new(Unit::Logic)
                .flag(FlagEffect::May)
                .bits(sources),
            Self::Dnews { target, source, .. } => {
                let word = Operands::new(Unit::Neighbours).targets(&[*target], roles);
                Direction::ALL.into_iter().fold(word, |word, direction| {
                    let gate = Cell::Digital(roles.enables(direction));
                    word.bit(*source, direction.step()).own(Use::Gate, gate)
                })
            }
            Self::PropRead => {
                Operands::new(Unit::Idle).own(Use::Read, Cell::Digital(roles.propagated))
            }
            Self::Prop { .. } => {
                let word = Operands::new(Unit::Propagation).targets(&[roles.propagated], roles);
                let word = word.own(Use::Read, Cell::Digital(roles.propagated));
                let enables = roles.enable.into_iter().map(Cell::Digital);
                enables.fold(word, |word, enable| word.own(Use::Gate, enable))
            }
        }
    }
}
