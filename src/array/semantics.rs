//! What each instruction word does: one cell, any arithmetic, one `match`.
//!
//! ```text
//! bus       each target := -(sum of sources) / (number of targets)     where FLAG
//! square    NEWS := gain · (sum of sources)²                           where FLAG
//! where     FLAG := (sum of sources) > 0
//! blur      target := -((8 - links) · own + sum over linked) / 8       where FLAG
//! OR, NOR   target := [not] any source                                 FLAG does not matter
//! DNEWS     target := any enabled direction's source
//! PROP      R12 := R12 or any enabled neighbour's R12                  where R0, again and again
//! ```
//!
//! - All reads come before all writes.
//! - A store into a neighbour's NEWS is masked by the FLAG of the pixel that drives; a store
//!   into a register of its own by its own FLAG. Pixels off the array drive too: their FLAG is
//!   1 and every register of theirs holds the edge value. A NEWS cell that nobody drives keeps
//!   its value; one that several drive holds the sum of what each puts in.
//! - R12 is written only where R0 was 1 before the word.
//!
//! This is the meaning. `array/engine/` does the same on rows, many pixels at once, where
//! `row_form` says how, and is held to it to the bit by `tests/array.rs`; where it says
//! nothing, the engine executes the meaning.

use smallvec::{SmallVec, smallvec};

use super::{Domain, Place, Propagation, Settings, Share, State, Undecided};
use crate::{
    isa::{Analog, Bit, Digital, Direction, Primitive, Source, Target, operands::Unit},
    plane::Size,
};

/// Row and column of a pixel, which may lie off the array.
type Point = (isize, isize);

const fn beside((y, x): Point, direction: Direction) -> Point {
    let (dy, dx) = direction.step();
    (y + dy, x + dx)
}

/// What a word leaves in one cell of a pixel.
#[derive(Clone, Debug)]
enum Left<C> {
    Analog(Analog, C),
    Pix(C),
    Digital(Digital, bool),
    Flag(bool),
}

/// What a word leaves in a pixel: its other cells stay as they are.
type Lefts<C> = SmallVec<[Left<C>; 4]>;

/// The array before a word, as the pixels see it.
struct Before<'a, D: Domain> {
    domain: &'a D,
    settings: &'a Settings,
    state: &'a State<D::Cell>,
    /// What the global input holds.
    input: &'a D::Cell,
    /// Words since power-on.
    step: u64,
}

impl<D: Domain> Before<'_, D> {
    /// Where a pixel lies in its planes; `None` off the array.
    fn index(&self, (y, x): Point) -> Option<usize> {
        let Size { height, width } = self.state.layout.size;
        let inside = (0..height as isize).contains(&y) && (0..width as isize).contains(&x);
        inside.then(|| y as usize * width + x as usize)
    }

    fn analog(&self, at: Point, register: Analog) -> &D::Cell {
        let index = self.index(at);
        index.map_or(&self.state.edge, |i| &self.state.analog(register)[i])
    }

    fn source(&self, at: Point, source: Source) -> &D::Cell {
        let Some(index) = self.index(at) else {
            return &self.state.edge;
        };
        match source {
            Source::Register(register) => self.analog(at, register),
            Source::Pix => &self.state.pix[index],
            Source::In => self.input,
            Source::Neighbour(direction) => {
                self.analog(beside(at, direction), self.state.layout.news)
            }
        }
    }

    /// The bus of a pixel.
    fn sum(&self, at: Point, sources: &[Source]) -> D::Sum {
        let mut sum = self.domain.nothing();
        for source in sources {
            self.domain.add(&mut sum, self.source(at, *source), 1);
        }
        sum
    }

    fn bit(&self, (y, x): Point, bit: Bit, off_array: bool) -> bool {
        let inside = self.index((y, x)).is_some();
        if inside {
            self.state.bits(bit).get(y as usize, x as usize)
        } else {
            off_array
        }
    }

    fn any(&self, at: Point, bits: &[Bit]) -> bool {
        bits.iter().any(|bit| self.bit(at, *bit, false))
    }

    fn flag(&self, at: Point) -> bool {
        self.bit(at, Bit::Flag, true)
    }

    /// Whether the register that enables reading from a direction is 1.
    fn enabled(&self, at: Point, direction: Direction) -> bool {
        let enable = self.state.layout.roles.enables(direction);
        self.bit(at, Bit::Register(enable), false)
    }

    fn place(&self, (y, x): Point, register: Analog) -> Place {
        Place {
            y: y as usize,
            x: x as usize,
            register,
            step: self.step,
        }
    }

    fn stored(&self, sum: &D::Sum, share: Share, at: Point, register: Analog) -> Left<D::Cell> {
        let cell = self.domain.store(sum, share, self.place(at, register));
        Left::Analog(register, self.domain.limited(cell, self.settings.limits()))
    }

    /// A one-bit register is written; R12 only where R0 is 1.
    fn write(&self, at: Point, target: Digital, value: bool) -> Lefts<D::Cell> {
        let roles = self.state.layout.roles;
        let open = target != roles.propagated || self.bit(at, Bit::Register(roles.mask), false);
        open.then_some(Left::Digital(target, value))
            .into_iter()
            .collect()
    }

    /// What a bus leaves: in each register of the pixel the pixel's own bus, in NEWS those of all
    /// pixels that drive it.
    fn bus(&self, targets: &[Target], sources: &[Source], at: Point) -> Lefts<D::Cell> {
        let news = self.state.layout.news;
        let mut lefts = smallvec![];
        let mut driven: SmallVec<[(Point, Share); 4]> = smallvec![];
        for (part, target) in targets.iter().enumerate() {
            let share = Share::new(targets.len(), part);
            match target {
                Target::Register(register) if *register != news => {
                    if self.flag(at) {
                        let sum = self.sum(at, sources);
                        lefts.push(self.stored(&sum, share, at, *register));
                    }
                }
                Target::Register(_) => driven.push((at, share)),
                Target::Neighbour(direction) => {
                    driven.push((beside(at, direction.opposite()), share));
                }
            }
        }
        let several = driven.len() > 1;
        driven.retain(|(driver, _)| self.flag(*driver));
        if let Some((driver, share)) = driven.last() {
            let mut sum = self.sum(*driver, sources);
            if several {
                sum = self.domain.nothing();
                for (driver, _) in &driven {
                    self.domain.join(&mut sum, &self.sum(*driver, sources));
                }
            }
            lefts.push(self.stored(&sum, *share, at, news));
        }
        lefts
    }

    /// What the word leaves in the pixel at `at`. Of PROP, one clock: one pixel further.
    ///
    /// # Errors
    /// In domains that are not numbers, where it depends on what they do not know.
    fn word(&self, word: &Primitive, at: Point) -> Result<Lefts<D::Cell>, Undecided> {
        let (domain, news) = (self.domain, self.state.layout.news);
        Ok(match word {
            Primitive::Nop | Primitive::BlurSet | Primitive::PropRead => smallvec![],
            Primitive::ResetPix => smallvec![Left::Pix(domain.hold(self.settings.reset_level))],
            Primitive::Bus { targets, sources } => self.bus(targets, sources, at),
            Primitive::Square { sources } => {
                let gain = self.settings.square_gain;
                let place = self.place(at, news);
                let square = domain.square(&self.sum(at, sources), gain, place);
                let square = square.ok_or(Undecided { operation: "sq" })?;
                let square = domain.limited(square, self.settings.limits());
                let flag = self.flag(at);
                flag.then_some(Left::Analog(news, square))
                    .into_iter()
                    .collect()
            }
            Primitive::Where { sources } => {
                let positive = domain.positive(&self.sum(at, sources));
                let positive = positive.ok_or(Undecided { operation: "where" })?;
                smallvec![Left::Flag(positive)]
            }
            Primitive::All => smallvec![Left::Flag(true)],
            Primitive::Blur {
                target,
                source,
                horizontal,
                vertical,
            } => {
                let parts: i32 = self.settings.diffusion.into();
                let (mut sum, mut own) = (domain.nothing(), parts);
                for direction in Direction::ALL {
                    let wanted = match direction {
                        Direction::North | Direction::South => *vertical,
                        Direction::East | Direction::West => *horizontal,
                    };
                    let gate = Bit::Register(self.state.layout.roles.links(direction));
                    let there = beside(at, direction);
                    if wanted && self.bit(at, gate, false) && self.bit(there, gate, false) {
                        domain.add(&mut sum, self.analog(there, *source), 1);
                        own -= 1;
                    }
                }
                domain.add(&mut sum, self.analog(at, *source), own);
                let share = Share {
                    by: parts as u32,
                    part: None,
                };
                let flag = self.flag(at);
                flag.then(|| self.stored(&sum, share, at, *target))
                    .into_iter()
                    .collect()
            }
            Primitive::Set { targets } => {
                let each = targets
                    .iter()
                    .flat_map(|target| self.write(at, *target, true));
                each.collect()
            }
            Primitive::Clear { targets } => {
                let each = targets
                    .iter()
                    .flat_map(|target| self.write(at, *target, false));
                each.collect()
            }
            Primitive::Or { target, sources } => self.write(at, *target, self.any(at, sources)),
            Primitive::Nor { target, sources } => self.write(at, *target, !self.any(at, sources)),
            Primitive::WhereBit { sources } => smallvec![Left::Flag(self.any(at, sources))],
            Primitive::Dnews {
                target,
                source,
                boundary,
            } => {
                let seen = |direction: &Direction| {
                    self.enabled(at, *direction)
                        && self.bit(beside(at, *direction), *source, *boundary)
                };
                self.write(at, *target, Direction::ALL.iter().any(seen))
            }
            Primitive::Prop { boundary } => {
                let spreads = self.state.layout.roles.propagated;
                let bit = Bit::Register(spreads);
                let seen = |direction: &Direction| {
                    self.enabled(at, *direction) && self.bit(beside(at, *direction), bit, *boundary)
                };
                let value = self.bit(at, bit, false) || Direction::ALL.iter().any(seen);
                self.write(at, spreads, value)
            }
        })
    }
}

/// How the engine does a word on rows, many pixels at once: said of a word beside its meaning.
#[derive(Clone, Copy, Debug)]
pub(super) enum RowForm<'a> {
    /// Nothing that a program can see.
    Nothing,
    /// The photodiodes := the reset level.
    Reset,
    /// Each target := its share of the bus.
    Bus {
        targets: &'a [Target],
        sources: &'a [Source],
    },
    /// NEWS := the square of the bus.
    Square { sources: &'a [Source] },
    /// FLAG := the bus is above zero.
    Sign { sources: &'a [Source] },
    /// Target := the source, diffused.
    Diffusion {
        target: Analog,
        source: Analog,
        horizontal: bool,
        vertical: bool,
    },
    /// Each target := the value.
    Constant { targets: &'a [Digital], value: bool },
    /// Target := [not] any source.
    Logic {
        target: Bit,
        sources: &'a [Bit],
        not: bool,
    },
    /// Target := any enabled direction's source.
    Neighbours {
        target: Digital,
        source: Bit,
        boundary: bool,
    },
}

/// The row form of a word. `None` is right for every word: the engine then executes its meaning,
/// pixel by pixel.
pub(super) fn row_form(word: &Primitive) -> Option<RowForm<'_>> {
    Some(match word {
        Primitive::Nop | Primitive::BlurSet | Primitive::PropRead => RowForm::Nothing,
        Primitive::ResetPix => RowForm::Reset,
        Primitive::Bus { targets, sources } => RowForm::Bus { targets, sources },
        Primitive::Square { sources } => RowForm::Square { sources },
        Primitive::Where { sources } => RowForm::Sign { sources },
        Primitive::All => RowForm::Logic {
            target: Bit::Flag,
            sources: &[],
            not: true,
        },
        Primitive::Blur {
            target,
            source,
            horizontal,
            vertical,
        } => RowForm::Diffusion {
            target: *target,
            source: *source,
            horizontal: *horizontal,
            vertical: *vertical,
        },
        Primitive::Set { targets } => RowForm::Constant {
            targets,
            value: true,
        },
        Primitive::Clear { targets } => RowForm::Constant {
            targets,
            value: false,
        },
        Primitive::Or { target, sources } => RowForm::Logic {
            target: Bit::Register(*target),
            sources,
            not: false,
        },
        Primitive::Nor { target, sources } => RowForm::Logic {
            target: Bit::Register(*target),
            sources,
            not: true,
        },
        Primitive::WhereBit { sources } => RowForm::Logic {
            target: Bit::Flag,
            sources,
            not: false,
        },
        Primitive::Dnews {
            target,
            source,
            boundary,
        } => RowForm::Neighbours {
            target: *target,
            source: *source,
            boundary: *boundary,
        },
        // A wave over the whole array, between two blocks: see `propagate`.
        Primitive::Prop { .. } => return None,
    })
}

/// Executes one instruction word on all pixels, one after the other. `input`: what the global
/// input holds; `step` numbers the words since power-on.
///
/// # Errors
/// Only in domains that are not numbers, where a result depends on what they do not know;
/// nothing has changed then.
///
/// # Panics
/// When the word names registers that the array does not have; [`check`](super::check) says so
/// beforehand.
pub fn execute<D: Domain>(
    domain: &D,
    settings: &Settings,
    state: &mut State<D::Cell>,
    word: &Primitive,
    input: &D::Cell,
    step: u64,
) -> Result<(), Undecided> {
    let size = state.layout.size;
    let clocks = match (state.layout.operands(word).unit, settings.propagation) {
        (Unit::Propagation, Propagation::Steps(steps)) => steps,
        // As far as there are pixels.
        (Unit::Propagation, Propagation::Settled) => size.pixels() as u32,
        _ => 1,
    };
    for _ in 0..clocks {
        let before = Before {
            domain,
            settings,
            state,
            input,
            step,
        };
        let Size { height, width } = size;
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (y, x)));
        let mut all = Vec::new();
        for (y, x) in pixels {
            let lefts = before.word(word, (y as isize, x as isize))?;
            all.extend(lefts.into_iter().map(|left| ((y, x), left)));
        }
        let mut changed = false;
        for ((y, x), left) in all {
            changed |= state.leave(y, x, left);
        }
        if !changed {
            break;
        }
    }
    Ok(())
}

impl<C: Clone + PartialEq> State<C> {
    /// Writes one cell; whether a bit has changed.
    fn leave(&mut self, y: usize, x: usize, left: Left<C>) -> bool {
        let index = y * self.layout.size.width + x;
        match left {
            Left::Analog(register, cell) => self.analog_mut(register)[index] = cell,
            Left::Pix(cell) => self.pix[index] = cell,
            Left::Digital(register, value) => {
                let bits = self.digital_mut(register);
                let old = bits.get(y, x);
                bits.set(y, x, value);
                return old != value;
            }
            Left::Flag(value) => self.flag.set(y, x, value),
        }
        false
    }
}
