//! What each instruction word does: one `match`, any domain.
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

use super::{
    BitPlane, Domain, Place, Propagation, Settings, Share, State, Undecided,
    rows::{self, Bus, Operand, Store, When},
};
use crate::{
    isa::{Analog, Bit, Digital, Direction, Primitive, Source, Target},
    plane::Size,
};

/// Executes one instruction word on all pixels. `step` numbers the words since power-on.
///
/// # Errors
/// Only in domains that are not numbers, where a result depends on what they do not know.
///
/// # Panics
/// When the word names registers that the array does not have; [`check`](super::check) says so
/// beforehand.
pub fn execute<D: Domain>(
    domain: &D,
    settings: &Settings,
    state: &mut State<D::Cell>,
    word: &Primitive,
    step: u64,
) -> Result<(), Undecided> {
    let array = Array {
        domain,
        settings,
        step,
    };
    match word {
        Primitive::Nop | Primitive::BlurSet | Primitive::PropRead => {}
        Primitive::ResetPix => {
            let level = domain.hold(settings.reset_level);
            state.pix.fill(level);
        }
        Primitive::Bus { targets, sources } => array.bus(state, targets, sources),
        Primitive::Square { sources } => array.square(state, sources)?,
        Primitive::Where { sources } => array.set_flag(state, sources)?,
        Primitive::All => state.flag.fill(true),
        Primitive::Blur {
            target,
            source,
            horizontal,
            vertical,
        } => array.blur(state, *target, *source, *horizontal, *vertical),
        Primitive::Set { targets } => fill(state, targets, true),
        Primitive::Clear { targets } => fill(state, targets, false),
        Primitive::Or { target, sources } => logic(state, *target, sources, false),
        Primitive::Nor { target, sources } => logic(state, *target, sources, true),
        Primitive::WhereBit { sources } => {
            let mut flag = state.flag.take();
            flag.set_any(
                &others(state, sources, Bit::Flag),
                kept(sources, Bit::Flag),
                false,
            );
            state.flag = flag;
        }
        Primitive::Dnews {
            target,
            source,
            boundary,
        } => {
            let result = from_enabled(state, state.bits(*source), *boundary);
            write(state, *target, &result);
        }
        Primitive::Prop { boundary } => propagate(state, settings.propagation, *boundary),
    }
    Ok(())
}

/// The analogue half.
struct Array<'a, D> {
    domain: &'a D,
    settings: &'a Settings,
    step: u64,
}

impl<D: Domain> Array<'_, D> {
    fn bus(&self, state: &mut State<D::Cell>, targets: &[Target], sources: &[Source]) {
        let news = state.layout.news;
        // Where each NEWS cell lies, seen from the pixels that drive it.
        let mut driven = Vec::new();
        let mut own = Vec::new();
        for (part, target) in targets.iter().enumerate() {
            let share = Share::of(targets.len(), part);
            match target {
                Target::Register(register) if *register == news => driven.push(((0, 0), share)),
                Target::Register(register) => own.push((*register, share)),
                Target::Neighbour(direction) => driven.push((direction.step(), share)),
            }
        }
        // All reads come before all writes: NEWS, the one register that can be read and
        // written, is written beside.
        let mut planes: Vec<Vec<D::Cell>> = own
            .iter()
            .map(|(register, _)| std::mem::take(state.analog_mut(*register)))
            .collect();
        let mut driven_plane = match driven[..] {
            [] => None,
            [_] if !reads(sources, news) => Some(std::mem::take(state.analog_mut(news))),
            _ => Some(state.analog(news).to_vec()),
        };
        let outside = vec![state.edge.clone(); state.layout.size.width];
        let input = vec![state.input.clone(); state.layout.size.width];
        let bus = bus_of(state, sources, &outside, &input);
        let mut stores = Vec::with_capacity(targets.len());
        for ((register, share), cells) in own.iter().zip(&mut planes) {
            stores.push(Store {
                cells,
                register: *register,
                share: *share,
                beside: (0, 0),
            });
        }
        match (&driven[..], &mut driven_plane) {
            ([(beside, share)], Some(cells)) => stores.push(Store {
                cells,
                register: news,
                share: *share,
                beside: *beside,
            }),
            (several, Some(cells)) => self.drive(&bus, cells, several, &state.flag, news),
            (_, None) => {}
        }
        let when = When {
            flag: &state.flag,
            clip: self.settings.clip,
            step: self.step,
        };
        rows::store(self.domain, &bus, &mut stores, when);
        if let ([(beside, share)], Some(cells)) = (&driven[..], &mut driven_plane) {
            self.drive_from_outside(&bus, cells, *beside, *share, news);
        }
        for ((register, _), plane) in own.iter().zip(planes) {
            *state.analog_mut(*register) = plane;
        }
        if let Some(plane) = driven_plane {
            *state.analog_mut(news) = plane;
        }
    }

    /// NEWS cells that several pixels drive: each holds the sum of what they put in.
    fn drive(
        &self,
        bus: &Bus<'_, D::Cell>,
        cells: &mut [D::Cell],
        driven: &[((isize, isize), Share)],
        flag: &BitPlane,
        news: Analog,
    ) {
        let Size { height, width } = bus.size;
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let mut total = self.domain.nothing();
            let mut any = None;
            for ((dy, dx), share) in driven {
                let (y, x) = (y.wrapping_add_signed(-dy), x.wrapping_add_signed(-dx));
                let inside = y < height && x < width;
                if inside && !flag.get(y, x) {
                    continue;
                }
                let sum = if inside {
                    bus.sum(self.domain, y, x)
                } else {
                    self.outside(bus)
                };
                self.domain.join(&mut total, &sum);
                any = Some(*share);
            }
            if let Some(share) = any {
                cells[y * width + x] = self.cell(&total, share, news, y, x);
            }
        }
    }

    /// What the bus of a pixel off the array carries.
    fn outside(&self, bus: &Bus<'_, D::Cell>) -> D::Sum {
        let mut sum = self.domain.nothing();
        for _ in &bus.operands {
            self.domain.add(&mut sum, &bus.outside[0], 1);
        }
        sum
    }

    #[inline]
    fn cell(&self, sum: &D::Sum, share: Share, register: Analog, y: usize, x: usize) -> D::Cell {
        let place = Place {
            y,
            x,
            register,
            step: self.step,
        };
        self.limit(self.domain.store(sum, share, place))
    }

    #[inline]
    fn limit(&self, cell: D::Cell) -> D::Cell {
        if self.settings.clip {
            self.domain.limit(cell)
        } else {
            cell
        }
    }

    /// The NEWS cells at the border whose driver lies off the array.
    fn drive_from_outside(
        &self,
        bus: &Bus<'_, D::Cell>,
        cells: &mut [D::Cell],
        beside: (isize, isize),
        share: Share,
        news: Analog,
    ) {
        let Size { height, width } = bus.size;
        let sum = self.outside(bus);
        let (ys, xs) = match beside {
            (1, _) => (0..1, 0..width),
            (-1, _) => (height - 1..height, 0..width),
            (_, 1) => (0..height, 0..1),
            (_, -1) => (0..height, width - 1..width),
            _ => return,
        };
        for y in ys {
            for x in xs.clone() {
                cells[y * width + x] = self.cell(&sum, share, news, y, x);
            }
        }
    }

    fn square(&self, state: &mut State<D::Cell>, sources: &[Source]) -> Result<(), Undecided> {
        let news = state.layout.news;
        let Size { height, width } = state.layout.size;
        let outside = vec![state.edge.clone(); width];
        let input = vec![state.input.clone(); width];
        let bus = bus_of(state, sources, &outside, &input);
        let mut squares = state.analog(news).to_vec();
        for y in 0..height {
            for x in 0..width {
                let place = Place {
                    y,
                    x,
                    register: news,
                    step: self.step,
                };
                let sum = bus.sum(self.domain, y, x);
                let square = self.domain.square(&sum, self.settings.square_gain, place);
                let cell = square.ok_or(Undecided { operation: "sq" })?;
                if state.flag.get(y, x) {
                    squares[y * width + x] = self.limit(cell);
                }
            }
        }
        *state.analog_mut(news) = squares;
        Ok(())
    }

    fn set_flag(&self, state: &mut State<D::Cell>, sources: &[Source]) -> Result<(), Undecided> {
        let outside = vec![state.edge.clone(); state.layout.size.width];
        let input = vec![state.input.clone(); state.layout.size.width];
        let mut flag = state.flag.clone();
        let bus = bus_of(state, sources, &outside, &input);
        rows::positive(self.domain, &bus, &mut flag)?;
        state.flag = flag;
        Ok(())
    }

    /// One explicit step of diffusion. A link conducts where the gates of both its pixels are
    /// open: R1 along columns, R2 along rows. Nothing flows over the border.
    fn blur(
        &self,
        state: &mut State<D::Cell>,
        target: Analog,
        source: Analog,
        horizontal: bool,
        vertical: bool,
    ) {
        let (height, width) = state.layout.size.shape();
        let parts = i32::from(self.settings.diffusion.max(4));
        let share = Share {
            by: parts as u32,
            part: None,
        };
        let roles = state.layout.roles;
        let before = state.analog(source).to_vec();
        for y in 0..height {
            for x in 0..width {
                let mut links = 0;
                let mut sum = self.domain.nothing();
                for direction in Direction::ALL {
                    let (along, gate) = match direction {
                        Direction::North | Direction::South => {
                            (vertical, roles.enables(Direction::South))
                        }
                        Direction::East | Direction::West => {
                            (horizontal, roles.enables(Direction::West))
                        }
                    };
                    let (dy, dx) = direction.step();
                    let (to_y, to_x) = (y.wrapping_add_signed(dy), x.wrapping_add_signed(dx));
                    let gates = state.digital(gate);
                    if along
                        && to_y < height
                        && to_x < width
                        && gates.get(y, x)
                        && gates.get(to_y, to_x)
                    {
                        links += 1;
                        self.domain.add(&mut sum, &before[to_y * width + to_x], 1);
                    }
                }
                self.domain
                    .add(&mut sum, &before[y * width + x], parts - links);
                if state.flag.get(y, x) {
                    let cell = self.cell(&sum, share, target, y, x);
                    state.analog_mut(target)[y * width + x] = cell;
                }
            }
        }
    }
}

/// The bus of every pixel.
fn bus_of<'a, C: Clone>(
    state: &'a State<C>,
    sources: &[Source],
    outside: &'a [C],
    input: &'a [C],
) -> Bus<'a, C> {
    let size = state.layout.size;
    let plane = |cells, beside| Operand {
        cells,
        stride: size.width,
        beside,
    };
    let operand = |source: &Source| match source {
        Source::Register(register) => plane(state.analog(*register), (0, 0)),
        Source::Pix => plane(&state.pix, (0, 0)),
        Source::In => Operand {
            cells: input,
            stride: 0,
            beside: (0, 0),
        },
        Source::Neighbour(direction) => plane(state.analog(state.layout.news), direction.step()),
    };
    Bus {
        size,
        operands: sources.iter().map(operand).collect(),
        outside,
    }
}

/// Whether any of the sources is this pixel's or a neighbour's NEWS.
fn reads(sources: &[Source], news: Analog) -> bool {
    sources.iter().any(|source| match source {
        Source::Register(register) => *register == news,
        Source::Neighbour(_) => true,
        Source::Pix | Source::In => false,
    })
}

/// `target := [not] any source`, in place.
fn logic<C: Clone>(state: &mut State<C>, target: Digital, sources: &[Bit], not: bool) {
    if target == state.layout.roles.propagated {
        let mut result = BitPlane::zeros(state.layout.size);
        let planes: Vec<_> = sources.iter().map(|bit| state.bits(*bit)).collect();
        result.set_any(&planes, false, not);
        write(state, target, &result);
        return;
    }
    let own = Bit::Register(target);
    let mut plane = state.digital_mut(target).take();
    plane.set_any(&others(state, sources, own), kept(sources, own), not);
    *state.digital_mut(target) = plane;
}

/// Whether a word reads the operand that it writes.
fn kept(sources: &[Bit], own: Bit) -> bool {
    sources.contains(&own)
}

/// The operands that it does not write.
fn others<'a, C: Clone>(state: &'a State<C>, sources: &[Bit], own: Bit) -> Vec<&'a BitPlane> {
    let others = sources.iter().filter(|bit| **bit != own);
    others.map(|bit| state.bits(*bit)).collect()
}

/// Writes a one-bit register; R12 only where R0 is 1.
pub(super) fn write<C: Clone>(state: &mut State<C>, target: Digital, new: &BitPlane) {
    if target == state.layout.roles.propagated {
        let [mask, spreads] = mask_and_spreads(state);
        spreads.assign_where(new, mask);
    } else {
        state.digital_mut(target).clone_from(new);
    }
}

/// R0 and R12, to read the one while the other is written.
fn mask_and_spreads<C>(state: &mut State<C>) -> [&mut BitPlane; 2] {
    let roles = state.layout.roles;
    let both = [roles.mask, roles.propagated].map(|register| usize::from(register.0));
    // The check before the run refuses a chip where they are one.
    state.digital.get_disjoint_mut(both).expect("two registers")
}

fn fill<C: Clone>(state: &mut State<C>, targets: &[Digital], value: bool) {
    // R12 first: it goes by R0 as it was before this word.
    let spreads = state.layout.roles.propagated;
    if targets.contains(&spreads) {
        let mut constant = BitPlane::zeros(state.layout.size);
        constant.fill(value);
        write(state, spreads, &constant);
    }
    for target in targets.iter().filter(|target| **target != spreads) {
        state.digital_mut(*target).fill(value);
    }
}

/// OR over the directions that are enabled in the reading pixel.
fn from_enabled<C: Clone>(state: &State<C>, source: &BitPlane, boundary: bool) -> BitPlane {
    let mut result = BitPlane::zeros(state.layout.size);
    for direction in Direction::ALL {
        let enabled = state.digital(state.layout.roles.enables(direction));
        result.or_where(&source.seen(direction, boundary), enabled);
    }
    result
}

fn propagate<C: Clone>(state: &mut State<C>, how_far: Propagation, boundary: bool) {
    let steps = match how_far {
        Propagation::Settled => u32::MAX,
        Propagation::Steps(steps) => steps,
    };
    for _ in 0..steps {
        let seen = from_enabled(
            state,
            state.digital(state.layout.roles.propagated),
            boundary,
        );
        let [mask, spreads] = mask_and_spreads(state);
        let before = spreads.count();
        spreads.or_where(&seen, mask);
        if spreads.count() == before {
            break;
        }
    }
}
