//! Words taken apart: which planes lie on the bus of each pixel, and what is stored where.

use std::ops::Range;

use super::{
    super::{Layout, Share},
    instruction::Word,
    liveness::{Known, Live},
    planes,
};
use crate::{
    isa::{Analog, Bit, Cell, Primitive, Source, Target},
    plane::Size,
};

/// A cell on the bus of every pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct BusInput {
    /// Which plane of a [`Slab`]; beyond them, which of its inputs.
    pub(super) plane: usize,
    /// Where the cell lies, seen from the pixel whose bus it is.
    pub(super) beside: (isize, isize),
}

impl BusInput {
    /// In place of one that is not there.
    pub(super) const NONE: Self = Self {
        plane: 0,
        beside: (0, 0),
    };
}

/// So many rows and columns at each border of the array where a cell is written from what lies
/// off the array.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Border {
    pub(super) above: usize,
    pub(super) below: usize,
    pub(super) left: usize,
    pub(super) right: usize,
}

impl Border {
    /// Of cells that lie `beside` the pixel whose bus they get.
    fn new(bus_inputs: &[BusInput], beside: (isize, isize)) -> Self {
        let mut border = Self::default();
        // The pixel itself, and each cell on its bus, as seen from the cell that is written.
        for (dy, dx) in bus_inputs
            .iter()
            .map(|bus_input| bus_input.beside)
            .chain([(0, 0)])
        {
            let (dy, dx) = (dy - beside.0, dx - beside.1);
            border.above = border.above.max((-dy).max(0) as usize);
            border.below = border.below.max(dy.max(0) as usize);
            border.left = border.left.max((-dx).max(0) as usize);
            border.right = border.right.max(dx.max(0) as usize);
        }
        border
    }

    /// The rows that lie between, if the columns leave anything.
    pub(super) fn inside(self, size: Size, rows: &Range<usize>) -> Range<usize> {
        let first = rows.start.max(self.above).min(rows.end);
        let last = rows.end.min(size.height.saturating_sub(self.below));
        if size.width <= self.left + self.right {
            return first..first;
        }
        first..last.max(first)
    }
}

/// A register that stores its share of the bus.
#[derive(Clone, Debug)]
pub(super) struct Store {
    /// Of the bus inputs of all operations.
    pub(super) bus_inputs: Range<usize>,
    pub(super) register: Analog,
    pub(super) share: Share,
    /// Where the cell lies, seen from the pixel whose bus it stores.
    pub(super) beside: (isize, isize),
    pub(super) border: Border,
    /// Whether FLAG is known to be 1 in all pixels.
    pub(super) whole: bool,
    /// Whether, besides, one to three registers are on the bus, and nothing else: then rows that
    /// lie inside the array need no choice for any cell.
    pub(super) interior: bool,
    /// Counted from the first word of all: see [`Constants::first`](super::constants::Constants).
    pub(super) step: u64,
}

impl Store {
    /// Whether it is [interior](Store::interior), and all that these rows need lies in `all` rows that
    /// there are: also what the cells at the left and right border take from the ends of the
    /// rows before and after, as they are stored with the others and put right afterwards.
    #[inline]
    pub(super) fn is_interior(&self, rows: &Range<usize>, all: &Range<usize>, size: Size) -> bool {
        let Border {
            above,
            below,
            left,
            right,
        } = self.border;
        self.interior
            && rows.start >= above
            && rows.end + below <= size.height
            && left + right < size.width
            && (left == 0 || rows.start > all.start + above)
            && (right == 0 || rows.end + below < all.end)
    }
}

/// Two stores, one after the other, of which the second has what the first put into its cell on
/// its bus, and nobody else reads it: the usual way to move a value, since each store inverts.
#[derive(Clone, Debug)]
pub(super) struct FusedStore {
    pub(super) first: Store,
    pub(super) second: Store,
    /// What else is on the second bus.
    pub(super) extra: Option<BusInput>,
    /// Whether the second cell is on the first bus.
    pub(super) own: bool,
    /// Whether both are [interior](Store::interior).
    pub(super) interior: bool,
}

impl FusedStore {
    /// `None` where they cannot be one.
    fn new(first: &Store, second: &Store, bus_inputs: &[BusInput]) -> Option<Self> {
        let (one, two) = (
            &bus_inputs[first.bus_inputs.clone()],
            &bus_inputs[second.bus_inputs.clone()],
        );
        let between = BusInput {
            plane: first.register.0.into(),
            beside: (0, 0),
        };
        let target = usize::from(second.register.0);
        let mut extra = two.iter().filter(|bus_input| **bus_input != between);
        let (other, more) = (extra.next().copied(), extra.next());
        let joined = two.len() == 1 + usize::from(other.is_some()) && more.is_none();
        let straight = other.is_none_or(|bus_input| bus_input.beside == (0, 0));
        let own = one
            .iter()
            .filter(|bus_input| bus_input.plane == target)
            .count();
        let unmoved =
            first.beside == (0, 0) && one.iter().all(|bus_input| bus_input.beside == (0, 0));
        let fits = joined
            && straight
            && one.len() <= 2
            && (unmoved || own == 0)
            && first.register != second.register
            && second.beside == (0, 0)
            && first.whole
            && second.whole
            && first.share.by <= 2
            && second.share.by == 1;
        fits.then(|| Self {
            first: first.clone(),
            second: second.clone(),
            extra: other,
            own: own > 0,
            interior: first.interior && second.interior && own <= 1,
        })
    }
}

/// One bit of each pixel: `target := [not] (others, or itself)`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Logic {
    /// Planes of bits of a [`Slab`].
    pub(super) target: usize,
    pub(super) others: [usize; 4],
    /// How many they are.
    pub(super) count: usize,
    /// Whether the target is among the sources.
    pub(super) kept: bool,
    pub(super) not: bool,
}

impl Logic {
    /// `None` where a mask or more sources are in play.
    fn new(target: Bit, sources: &[Bit], not: bool, layout: &Layout) -> Option<Self> {
        let plane = |bit: Bit| match bit {
            Bit::Register(register) => Some(usize::from(register.0)),
            Bit::Flag => Some(planes::flag(layout)),
            Bit::Select | Bit::Rect => None,
        };
        if target == Bit::Register(layout.roles.propagated) {
            return None;
        }
        let mut logic = Self {
            target: plane(target)?,
            kept: sources.contains(&target),
            not,
            ..Self::default()
        };
        for source in sources.iter().filter(|source| **source != target) {
            *logic.others.get_mut(logic.count)? = plane(*source)?;
            logic.count += 1;
        }
        Some(logic)
    }
}

/// What there is to do on some rows.
#[derive(Clone, Debug)]
pub(super) enum Operation {
    /// One target of a bus.
    Store(Store),
    Fused(Box<FusedStore>),
    /// NEWS cells that several pixels drive: where each lies, and its share.
    Drive {
        bus_inputs: Range<usize>,
        driven: Vec<((isize, isize), Share)>,
        step: u64,
    },
    /// FLAG := the bus is above zero.
    Sign {
        bus_inputs: Range<usize>,
        border: Border,
    },
    /// NEWS := the square of the bus.
    Square {
        bus_inputs: Range<usize>,
        step: u64,
    },
    Logic(Logic),
    /// Any other word that has no bus.
    Word {
        word: Box<Primitive>,
        step: u64,
    },
    /// A register into its copy.
    Copy(Cell),
}

/// Words taken apart, in order.
#[derive(Clone, Debug, Default)]
pub(super) struct Operations {
    pub(super) operations: Vec<Operation>,
    pub(super) bus_inputs: Vec<BusInput>,
}

impl Operations {
    /// One more word.
    pub(super) fn word(&mut self, word: &Word, copied: bool, layout: &Layout, known: Known) {
        match &word.primitive {
            Primitive::Bus { targets, sources } => {
                let bus_inputs = self.bus_inputs(sources, word, copied, layout);
                self.bus(targets, &bus_inputs, word.step, layout, known);
            }
            Primitive::Square { sources } => {
                let bus_inputs = self.bus_inputs(sources, word, copied, layout);
                let step = word.step;
                self.operations.push(Operation::Square { bus_inputs, step });
            }
            Primitive::Where { sources } => {
                let bus_inputs = self.bus_inputs(sources, word, copied, layout);
                let border = Border::new(&self.bus_inputs[bus_inputs.clone()], (0, 0));
                self.operations.push(Operation::Sign { bus_inputs, border });
            }
            Primitive::Or { target, sources } => {
                self.logic(Bit::Register(*target), sources, false, word, layout);
            }
            Primitive::Nor { target, sources } => {
                self.logic(Bit::Register(*target), sources, true, word, layout);
            }
            Primitive::WhereBit { sources } => {
                self.logic(Bit::Flag, sources, false, word, layout);
            }
            Primitive::Nop
            | Primitive::ResetPix
            | Primitive::All
            | Primitive::BlurSet
            | Primitive::Blur { .. }
            | Primitive::Set { .. }
            | Primitive::Clear { .. }
            | Primitive::Dnews { .. }
            | Primitive::PropRead
            | Primitive::Prop { .. } => self.other(word),
        }
    }

    /// Makes the last two operations one; whether it did. `live`: as after the last.
    pub(super) fn join(&mut self, live: Live) -> bool {
        let [.., Operation::Store(first), Operation::Store(second)] = &self.operations[..] else {
            return false;
        };
        if live.has(first.register) {
            return false;
        }
        let Some(pair) = FusedStore::new(first, second, &self.bus_inputs) else {
            return false;
        };
        self.operations.truncate(self.operations.len() - 2);
        self.operations.push(Operation::Fused(Box::new(pair)));
        true
    }

    fn logic(&mut self, target: Bit, sources: &[Bit], not: bool, word: &Word, layout: &Layout) {
        match Logic::new(target, sources, not, layout) {
            Some(logic) => self.operations.push(Operation::Logic(logic)),
            None => self.other(word),
        }
    }

    /// A word that is executed as it is.
    fn other(&mut self, word: &Word) {
        self.operations.push(Operation::Word {
            word: Box::new(word.primitive.clone()),
            step: word.step,
        });
    }

    fn bus(
        &mut self,
        targets: &[Target],
        bus_inputs: &Range<usize>,
        step: u64,
        layout: &Layout,
        known: Known,
    ) {
        let place = |target: &Target| match target {
            Target::Register(register) => (*register, (0, 0)),
            Target::Neighbour(direction) => (layout.news, direction.step()),
        };
        let to_news = |target: &&Target| place(target).0 == layout.news;
        let several = targets.iter().filter(to_news).count() > 1;
        let share = |part| Share::new(targets.len(), part);
        for (part, target) in targets.iter().enumerate() {
            let (register, beside) = place(target);
            let lost = known.whole && !known.live.has(register);
            if lost || (several && register == layout.news) {
                continue;
            }
            let bus = &self.bus_inputs[bus_inputs.clone()];
            let border = Border::new(bus, beside);
            let planes = planes::count(layout);
            self.operations.push(Operation::Store(Store {
                bus_inputs: bus_inputs.clone(),
                register,
                share: share(part),
                beside,
                interior: known.whole
                    && matches!(bus.len(), 1..=3)
                    && bus.iter().all(|bus_input| bus_input.plane < planes),
                border,
                whole: known.whole,
                step,
            }));
        }
        if several {
            let driven = targets
                .iter()
                .enumerate()
                .filter(|(_, target)| to_news(target))
                .map(|(part, target)| (place(target).1, share(part)));
            self.operations.push(Operation::Drive {
                bus_inputs: bus_inputs.clone(),
                driven: driven.collect(),
                step,
            });
        }
    }

    /// What the sources put on the bus.
    fn bus_inputs(
        &mut self,
        sources: &[Source],
        word: &Word,
        copied: bool,
        layout: &Layout,
    ) -> Range<usize> {
        let first = self.bus_inputs.len();
        let news = if copied {
            planes::copy(layout)
        } else {
            usize::from(layout.news.0)
        };
        self.bus_inputs.extend(sources.iter().map(|source| {
            let (plane, beside) = match source {
                Source::Register(register) if *register == layout.news => (news, (0, 0)),
                Source::Register(register) => (usize::from(register.0), (0, 0)),
                Source::Pix => (planes::light(layout), (0, 0)),
                Source::In => (planes::count(layout) + word.input, (0, 0)),
                Source::Neighbour(direction) => (news, direction.step()),
            };
            BusInput { plane, beside }
        }));
        first..self.bus_inputs.len()
    }
}
