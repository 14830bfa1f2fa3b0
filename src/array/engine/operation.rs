//! What there is to do on rows: which planes lie on the bus of each pixel, and what is stored
//! where. Words become operations in [`select`](super::select).

use std::ops::Range;

use super::{
    super::{Layout, Share},
    planes,
};
use crate::{
    isa::{Analog, Bit, Cell, Digital},
    plane::Size,
};

/// A cell on the bus of every pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct BusInput {
    /// Which plane of a [`Slab`](super::slab::Slab); beyond them, which of its inputs.
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
    pub(super) fn new(bus_inputs: &[BusInput], beside: (isize, isize)) -> Self {
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
    pub(super) fn new(first: &Store, second: &Store, bus_inputs: &[BusInput]) -> Option<Self> {
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
#[derive(Clone, Copy, Debug)]
pub(super) struct Logic {
    /// Planes of bits of a [`BitSlab`](super::bit_slab::BitSlab).
    pub(super) target: usize,
    others: [usize; 4],
    /// How many they are.
    count: usize,
    /// Whether the target is among the sources.
    pub(super) kept: bool,
    pub(super) not: bool,
}

impl Logic {
    /// `None` where a mask, what the host has selected, or more sources are in play.
    pub(super) fn new(target: Bit, sources: &[Bit], not: bool, layout: &Layout) -> Option<Self> {
        if target == Bit::Register(layout.roles.propagated) {
            return None;
        }
        let mut logic = Self {
            target: planes::bit(layout, target)?,
            others: [0; 4],
            count: 0,
            kept: sources.contains(&target),
            not,
        };
        for source in sources.iter().filter(|source| **source != target) {
            *logic.others.get_mut(logic.count)? = planes::bit(layout, *source)?;
            logic.count += 1;
        }
        Some(logic)
    }

    /// The planes of the sources that are not the target.
    pub(super) fn others(&self) -> &[usize] {
        &self.others[..self.count]
    }
}

/// The same of any sources, into any register.
#[derive(Clone, Debug)]
pub(super) struct MaskedLogic {
    pub(super) target: usize,
    /// The target is written only where this is 1.
    pub(super) mask: Option<Digital>,
    /// The sources that are not the target.
    pub(super) others: Vec<Bit>,
    pub(super) kept: bool,
    pub(super) not: bool,
}

impl MaskedLogic {
    /// `None` where no word can write the target.
    pub(super) fn new(target: Bit, sources: &[Bit], not: bool, layout: &Layout) -> Option<Self> {
        let roles = layout.roles;
        let others = sources.iter().filter(|source| **source != target);
        Some(Self {
            target: planes::bit(layout, target)?,
            mask: (target == Bit::Register(roles.propagated)).then_some(roles.mask),
            others: others.copied().collect(),
            kept: sources.contains(&target),
            not,
        })
    }
}

/// One bit of each pixel, from its neighbours: see [`Primitive::Dnews`](crate::isa::Primitive).
#[derive(Clone, Copy, Debug)]
pub(super) struct Neighbours {
    pub(super) target: Digital,
    pub(super) source: Bit,
    pub(super) boundary: bool,
}

/// One step of the diffusion network: see [`Primitive::Blur`](crate::isa::Primitive).
#[derive(Clone, Copy, Debug)]
pub(super) struct Diffusion {
    pub(super) target: Analog,
    pub(super) source: Analog,
    pub(super) horizontal: bool,
    pub(super) vertical: bool,
    pub(super) step: u64,
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
    /// The photodiodes := the reset level.
    Reset,
    Diffusion(Diffusion),
    Logic(Logic),
    MaskedLogic(MaskedLogic),
    Neighbours(Neighbours),
    /// A register into its copy.
    Copy(Cell),
}
