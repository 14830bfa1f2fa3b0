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

use super::{BitPlane, Domain, Place, Propagation, Settings, Share, State, Undecided};
use crate::isa::{Analog, Bit, Digital, Direction, Primitive, Source, Target};

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
        Primitive::Or { target, sources } => {
            let result = any(state, sources);
            write(state, *target, &result);
        }
        Primitive::Nor { target, sources } => {
            let mut result = any(state, sources);
            result.not();
            write(state, *target, &result);
        }
        Primitive::WhereBit { sources } => state.flag = any(state, sources),
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
        // Which way from each NEWS cell the pixels lie that drive it.
        let mut drivers = Vec::new();
        let mut own = Vec::new();
        for (part, target) in targets.iter().enumerate() {
            let share = Share::of(targets.len(), part);
            match target {
                Target::Register(register) if *register == news => drivers.push((None, share)),
                Target::Register(register) => own.push((*register, share)),
                Target::Neighbour(direction) => {
                    drivers.push((Some(direction.opposite()), share));
                }
            }
        }
        let reads_news = sources.iter().any(|source| match source {
            Source::Register(register) => *register == news,
            Source::Neighbour(_) => true,
            Source::Pix | Source::In => false,
        });
        if drivers.len() > 1 || (reads_news && !drivers.is_empty()) {
            self.bus_at_once(state, &own, &drivers, sources);
            return;
        }
        // Nothing that is written is read in another row: row by row.
        let mut sums = Vec::new();
        for y in 0..state.layout.size.height {
            self.sum_row(state, sources, y, &mut sums);
            for (register, share) in &own {
                self.store_row(state, *register, y, &sums, *share);
            }
            if let [(driver, share)] = drivers[..] {
                self.drive_row(state, driver, y, &sums, share);
            }
        }
        if let [(Some(direction), share)] = drivers[..] {
            self.drive_from_outside(state, direction, sources.len(), share);
        }
    }

    /// The bus of every pixel first, then all stores.
    fn bus_at_once(
        &self,
        state: &mut State<D::Cell>,
        own: &[(Analog, Share)],
        drivers: &[(Option<Direction>, Share)],
        sources: &[Source],
    ) {
        let size = state.layout.size;
        let news = state.layout.news;
        let rows: Vec<Vec<D::Sum>> = (0..size.height)
            .map(|y| {
                let mut sums = Vec::new();
                self.sum_row(state, sources, y, &mut sums);
                sums
            })
            .collect();
        let outside = self.outside(state, sources.len());
        for (y, sums) in rows.iter().enumerate() {
            for (register, share) in own {
                self.store_row(state, *register, y, sums, *share);
            }
            for x in 0..size.width {
                let mut total = self.domain.nothing();
                let mut driven = None;
                for (driver, share) in drivers {
                    let (dy, dx) = driver.map_or((0, 0), Direction::step);
                    let (y, x) = (y.wrapping_add_signed(dy), x.wrapping_add_signed(dx));
                    let sum = match rows.get(y).and_then(|row| row.get(x)) {
                        Some(sum) if state.flag.get(y, x) => sum,
                        Some(_) => continue,
                        None => &outside,
                    };
                    self.domain.join(&mut total, sum);
                    driven = Some(*share);
                }
                if let Some(share) = driven {
                    let cell = self.cell(&total, share, news, y, x);
                    state.analog_mut(news)[y * size.width + x] = cell;
                }
            }
        }
    }

    /// The bus of every pixel of row `y`.
    fn sum_row(
        &self,
        state: &State<D::Cell>,
        sources: &[Source],
        y: usize,
        sums: &mut Vec<D::Sum>,
    ) {
        let domain = self.domain;
        let width = state.layout.size.width;
        sums.clear();
        sums.resize(width, domain.nothing());
        let add = |sums: &mut [D::Sum], cells: &[D::Cell]| {
            for (sum, cell) in sums.iter_mut().zip(cells) {
                domain.add(sum, cell, 1);
            }
        };
        let add_one = |sums: &mut [D::Sum], cell: &D::Cell| {
            for sum in sums {
                domain.add(sum, cell, 1);
            }
        };
        for source in sources {
            match source {
                Source::Register(register) => {
                    add(sums, state.row(state.analog(*register), y));
                }
                Source::Pix => add(sums, state.row(&state.pix, y)),
                Source::In => add_one(sums, &state.input),
                Source::Neighbour(direction) => {
                    let news = state.analog(state.layout.news);
                    match direction {
                        Direction::North if y > 0 => add(sums, state.row(news, y - 1)),
                        Direction::South if y + 1 < state.layout.size.height => {
                            add(sums, state.row(news, y + 1));
                        }
                        Direction::North | Direction::South => add_one(sums, &state.edge),
                        Direction::West => {
                            add_one(&mut sums[..1], &state.edge);
                            add(&mut sums[1..], state.row(news, y));
                        }
                        Direction::East => {
                            add(&mut sums[..width - 1], &state.row(news, y)[1..]);
                            add_one(&mut sums[width - 1..], &state.edge);
                        }
                    }
                }
            }
        }
    }

    /// What the bus of a pixel off the array carries.
    fn outside(&self, state: &State<D::Cell>, sources: usize) -> D::Sum {
        let mut sum = self.domain.nothing();
        for _ in 0..sources {
            self.domain.add(&mut sum, &state.edge, 1);
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

    /// Stores row `y` of the bus in a register of the same pixels, where FLAG is 1.
    fn store_row(
        &self,
        state: &mut State<D::Cell>,
        register: Analog,
        y: usize,
        sums: &[D::Sum],
        share: Share,
    ) {
        self.store_beside(state, register, (0, 0), y, sums, share);
    }

    /// Stores row `y` of the bus in the NEWS cells that it drives, where FLAG is 1.
    /// `driver` is where the driving pixel lies, seen from the NEWS cell.
    fn drive_row(
        &self,
        state: &mut State<D::Cell>,
        driver: Option<Direction>,
        y: usize,
        sums: &[D::Sum],
        share: Share,
    ) {
        let step = driver.map_or((0, 0), |direction| direction.opposite().step());
        self.store_beside(state, state.layout.news, step, y, sums, share);
    }

    /// Stores row `y` of the bus `(dy, dx)` beside, where the FLAG of row `y` is 1.
    fn store_beside(
        &self,
        state: &mut State<D::Cell>,
        register: Analog,
        (dy, dx): (isize, isize),
        y: usize,
        sums: &[D::Sum],
        share: Share,
    ) {
        let (height, width) = state.layout.size.shape();
        let to_y = y.wrapping_add_signed(dy);
        if to_y >= height {
            return;
        }
        let cells = &mut state.analog[usize::from(register.0)][to_y * width..][..width];
        // Where on the row the driving pixels lie whose target is on the array.
        let (start, end) = (usize::from(dx < 0), width - usize::from(dx > 0));
        for (k, flags) in state.flag.row(y).iter().enumerate() {
            let (from, to) = ((64 * k).max(start), (64 * k + 64).min(end));
            if from >= to || *flags == 0 {
                continue;
            }
            let first = from.wrapping_add_signed(dx);
            let cells = cells[first..][..to - from].iter_mut().zip(&sums[from..to]);
            let cells = (first..).zip(cells);
            let flags = flags >> (from % 64);
            let all = !0 >> (64 - (to - from));
            if flags & all == all {
                // The common case has no branch inside, so that it runs in wide registers.
                for (x, (cell, sum)) in cells {
                    *cell = self.cell(sum, share, register, to_y, x);
                }
            } else {
                for (i, (x, (cell, sum))) in cells.enumerate() {
                    if flags >> i & 1 == 1 {
                        *cell = self.cell(sum, share, register, to_y, x);
                    }
                }
            }
        }
    }

    /// The NEWS cells at the border whose driver lies off the array.
    fn drive_from_outside(
        &self,
        state: &mut State<D::Cell>,
        driver: Direction,
        sources: usize,
        share: Share,
    ) {
        let news = state.layout.news;
        let (height, width) = state.layout.size.shape();
        let sum = self.outside(state, sources);
        let (ys, xs) = match driver {
            Direction::North => (0..1, 0..width),
            Direction::South => (height - 1..height, 0..width),
            Direction::West => (0..height, 0..1),
            Direction::East => (0..height, width - 1..width),
        };
        for y in ys {
            for x in xs.clone() {
                let cell = self.cell(&sum, share, news, y, x);
                state.analog_mut(news)[y * width + x] = cell;
            }
        }
    }

    fn square(&self, state: &mut State<D::Cell>, sources: &[Source]) -> Result<(), Undecided> {
        let news = state.layout.news;
        let (height, width) = state.layout.size.shape();
        let mut sums = Vec::new();
        let mut squares = Vec::with_capacity(height * width);
        for y in 0..height {
            self.sum_row(state, sources, y, &mut sums);
            for (x, sum) in sums.iter().enumerate() {
                let place = Place {
                    y,
                    x,
                    register: news,
                    step: self.step,
                };
                let square = self.domain.square(sum, self.settings.square_gain, place);
                let cell = square.ok_or(Undecided { operation: "sq" })?;
                squares.push(self.limit(cell));
            }
        }
        for (i, square) in squares.into_iter().enumerate() {
            if state.flag.get(i / width, i % width) {
                state.analog_mut(news)[i] = square;
            }
        }
        Ok(())
    }

    fn set_flag(&self, state: &mut State<D::Cell>, sources: &[Source]) -> Result<(), Undecided> {
        let mut sums = Vec::new();
        for y in 0..state.layout.size.height {
            self.sum_row(state, sources, y, &mut sums);
            for (sums, flags) in sums.chunks(64).zip(state.flag.row_mut(y)) {
                *flags = 0;
                for (i, sum) in sums.iter().enumerate() {
                    let positive = self.domain.positive(sum);
                    let positive = positive.ok_or(Undecided { operation: "where" })?;
                    *flags |= u64::from(positive) << i;
                }
            }
        }
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

/// OR of the sources.
fn any<C: Clone>(state: &State<C>, sources: &[Bit]) -> BitPlane {
    let planes: Vec<_> = sources.iter().map(|bit| state.bits(*bit)).collect();
    let mut result = BitPlane::zeros(state.layout.size);
    result.or(&planes);
    result
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
    let mut constant = BitPlane::zeros(state.layout.size);
    constant.fill(value);
    // R12 first: it goes by R0 as it was before this word.
    let spreads = state.layout.roles.propagated;
    if targets.contains(&spreads) {
        write(state, spreads, &constant);
    }
    for target in targets.iter().filter(|target| **target != spreads) {
        write(state, *target, &constant);
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
