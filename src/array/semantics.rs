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
//!
//! A word is executed on some rows of the array: which rows when is the business of a
//! [`Schedule`](super::Schedule). What reaches a row from its neighbours is at most `reach`
//! rows away.

use std::ops::Range;

use super::{
    BitPlane, Domain, Place, Propagation, Settings, Share, State, Undecided,
    band::{Band, Constants, Copies},
    bits,
    rows::{self, Bus, Link, Links, Store},
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
    if let Primitive::Prop { boundary } = word {
        propagate(state, settings.propagation, *boundary);
        return Ok(());
    }
    let news = state.layout.news;
    let mut copies = Copies::default();
    make_copies(&mut copies, state, copied(word, news));
    let constants = Constants::of(state);
    let mut band = Band::whole(state, &mut copies, &constants);
    let rows = band.rows.clone();
    let issued = Issued {
        word,
        step,
        input: 0,
        copied: copied(word, news).is_some(),
    };
    if let Some(register) = copied(word, news) {
        copy(&mut band, register, rows.clone());
    }
    Array { domain, settings }.execute(&mut band, issued, rows)
}

/// A word as it is given to the array.
#[derive(Clone, Copy, Debug)]
pub(super) struct Issued<'a> {
    pub(super) word: &'a Primitive,
    /// Its number since power-on.
    pub(super) step: u64,
    /// Which of the band's inputs the global input holds.
    pub(super) input: usize,
    /// Whether it reads the copy of a register: see [`copied`].
    pub(super) copied: bool,
}

/// A register, of either kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Register {
    Analog(Analog),
    Digital(Digital),
}

/// How many rows away a word reads from the cell that it writes.
pub(super) fn reach(word: &Primitive) -> usize {
    reaches(word)[0]
}

/// How many rows, and how many columns, away a word reads from the cell that it writes.
pub(super) fn reaches(word: &Primitive) -> [usize; 2] {
    let along = |axis: usize| {
        let step = |direction: &Direction| <[isize; 2]>::from(direction.step())[axis];
        match word {
            Primitive::Bus { targets, sources } => {
                let to = targets.iter().map(|target| match target {
                    Target::Register(_) => 0,
                    Target::Neighbour(direction) => step(direction),
                });
                // The driver itself, and what it reads.
                let from = || beside(sources).map(|direction| step(&direction)).chain([0]);
                let far = to.flat_map(|to| from().map(move |from| (from - to).unsigned_abs()));
                far.max().unwrap_or(0)
            }
            Primitive::Square { sources } | Primitive::Where { sources } => {
                let far = beside(sources).map(|direction| step(&direction).unsigned_abs());
                far.max().unwrap_or(0)
            }
            Primitive::Blur {
                horizontal,
                vertical,
                ..
            } => usize::from([*vertical, *horizontal][axis]),
            Primitive::Dnews { .. } => 1,
            Primitive::Nop
            | Primitive::ResetPix
            | Primitive::All
            | Primitive::BlurSet
            | Primitive::Set { .. }
            | Primitive::Clear { .. }
            | Primitive::Or { .. }
            | Primitive::Nor { .. }
            | Primitive::WhereBit { .. }
            | Primitive::PropRead => 0,
            // As far as it goes.
            Primitive::Prop { .. } => usize::MAX,
        }
    };
    [along(0), along(1)]
}

/// The neighbours whose NEWS is among the sources.
pub(super) fn beside(sources: &[Source]) -> impl Iterator<Item = Direction> {
    sources.iter().filter_map(|source| match source {
        Source::Neighbour(direction) => Some(*direction),
        Source::Register(_) | Source::Pix | Source::In => None,
    })
}

/// The register that a word reads in one pixel after it has written it in another: it must
/// read a copy, made before.
pub(super) fn copied(word: &Primitive, news: Analog) -> Option<Register> {
    let reads = |sources: &[Source]| {
        sources.iter().any(|source| match source {
            Source::Register(register) => *register == news,
            Source::Neighbour(_) => true,
            Source::Pix | Source::In => false,
        })
    };
    match word {
        Primitive::Bus { targets, sources } => {
            let drives = targets.iter().any(|target| match target {
                Target::Register(register) => *register == news,
                Target::Neighbour(_) => true,
            });
            (drives && reads(sources)).then_some(Register::Analog(news))
        }
        Primitive::Square { sources } => reads(sources).then_some(Register::Analog(news)),
        Primitive::Blur { target, source, .. } => {
            (target == source).then_some(Register::Analog(*source))
        }
        Primitive::Dnews { target, source, .. } => {
            (*source == Bit::Register(*target)).then_some(Register::Digital(*target))
        }
        Primitive::Nop
        | Primitive::ResetPix
        | Primitive::Where { .. }
        | Primitive::All
        | Primitive::BlurSet
        | Primitive::Set { .. }
        | Primitive::Clear { .. }
        | Primitive::Or { .. }
        | Primitive::Nor { .. }
        | Primitive::WhereBit { .. }
        | Primitive::PropRead
        | Primitive::Prop { .. } => None,
    }
}

/// Adds to `links` what a word is in a chain; `false` where it can be in none.
pub(super) fn link(issued: Issued<'_>, links: &mut Vec<Link>) -> bool {
    let Primitive::Bus { targets, sources } = issued.word else {
        return false;
    };
    let register = |source: &Source| match source {
        Source::Register(register) => Some(*register),
        Source::Pix | Source::In | Source::Neighbour(_) => None,
    };
    let (one, two) = match &sources[..] {
        [one] => (register(one), None),
        [one, two] => (register(one), register(two)),
        _ => return false,
    };
    let two_registers = two.is_some();
    let (Some(one), true) = (one, two_registers || sources.len() == 1) else {
        return false;
    };
    if issued.copied || targets.len() > 2 {
        return false;
    }
    let before = links.len();
    for (part, target) in targets.iter().enumerate() {
        let Target::Register(target) = target else {
            links.truncate(before);
            return false;
        };
        links.push(Link {
            target: *target,
            share: Share::of(targets.len(), part),
            sources: [one, two.unwrap_or(one)],
            two: two_registers,
            step: issued.step,
        });
    }
    true
}

/// Makes room for the copy of a register.
pub(super) fn make_copies<C: Clone>(
    copies: &mut Copies<C>,
    state: &State<C>,
    register: Option<Register>,
) {
    match register {
        None => {}
        Some(Register::Analog(_)) => {
            let pixels = state.layout.size.pixels();
            copies.analog.resize(pixels, state.edge.clone());
        }
        Some(Register::Digital(_)) => copies.bits.resize(state.flag.words().len(), 0),
    }
}

/// Copies rows of a register, for [`copied`].
pub(super) fn copy<C: Clone>(band: &mut Band<'_, C>, register: Register, rows: Range<usize>) {
    match register {
        Register::Analog(register) => band.copy(register, rows),
        Register::Digital(register) => band.copy_bits(register, rows),
    }
}

/// What words mean, in one domain.
pub(super) struct Array<'a, D> {
    pub(super) domain: &'a D,
    pub(super) settings: &'a Settings,
}

impl<D> Clone for Array<'_, D> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<D> Copy for Array<'_, D> {}

impl<D: Domain> Array<'_, D> {
    /// Executes a word on some rows: those are the rows that it writes. What it reads beside
    /// them must lie in the band, or off the array. PROP has no rows: see [`propagate`].
    pub(super) fn execute(
        self,
        band: &mut Band<'_, D::Cell>,
        issued: Issued<'_>,
        rows: Range<usize>,
    ) -> Result<(), Undecided> {
        match issued.word {
            Primitive::Nop | Primitive::BlurSet | Primitive::PropRead | Primitive::Prop { .. } => {}
            Primitive::ResetPix => {
                let level = self.domain.hold(self.settings.reset_level);
                let cells = band.row_cells(rows);
                band.pix[cells].fill(level);
            }
            Primitive::Bus { targets, sources } => {
                self.bus(band, issued, targets, sources, &rows);
            }
            Primitive::Square { sources } => self.square(band, issued, sources, rows)?,
            Primitive::Where { sources } => {
                let top = band.rows.start;
                let flag = band.take_flag();
                let operands = band.operands(sources, issued.input, false);
                let result = rows::positive(self.domain, band.bus(&operands), flag, top, rows);
                drop(operands);
                band.put_flag(flag);
                result?;
            }
            Primitive::All => {
                let size = band.layout.size;
                let words = band.row_words(rows);
                let flag = band.take_flag();
                bits::fill(&mut flag[words], size.width, true);
                band.put_flag(flag);
            }
            Primitive::Blur {
                target,
                source,
                horizontal,
                vertical,
            } => {
                let step = issued.step;
                self.blur(band, *target, *source, (*horizontal, *vertical), step, rows);
            }
            Primitive::Set { targets } => fill(band, targets, true, rows),
            Primitive::Clear { targets } => fill(band, targets, false, rows),
            Primitive::Or { target, sources } => logic(band, *target, sources, false, rows),
            Primitive::Nor { target, sources } => logic(band, *target, sources, true, rows),
            Primitive::WhereBit { sources } => {
                let words = band.row_words(rows);
                let kept = sources.contains(&Bit::Flag);
                let flag = band.take_flag();
                any(
                    band,
                    &mut flag[words.clone()],
                    words,
                    sources,
                    Bit::Flag,
                    (kept, false),
                );
                band.put_flag(flag);
            }
            Primitive::Dnews {
                target,
                source,
                boundary,
            } => dnews(band, *target, *source, *boundary, rows),
        }
        Ok(())
    }

    /// Executes the words of a chain on some rows; `false`, and nothing done, where FLAG is not
    /// 1 in all of their pixels, or the words of bits do not tell.
    pub(super) fn chain(
        self,
        band: &mut Band<'_, D::Cell>,
        links: &[Link],
        rows: Range<usize>,
    ) -> bool {
        let flags = &band.flag()[band.row_words(rows.clone())];
        if !band.layout.size.width.is_multiple_of(64)
            || flags.iter().fold(!0, |all, word| all & word) != !0
        {
            return false;
        }
        let place = Place {
            y: rows.start,
            x: 0,
            register: band.layout.news,
            step: 0,
        };
        let cells = band.row_cells(rows);
        let clip = self.settings.clip;
        rows::chain(self.domain, band.registers(), links, cells, place, clip);
        true
    }

    fn bus(
        self,
        band: &mut Band<'_, D::Cell>,
        issued: Issued<'_>,
        targets: &[Target],
        sources: &[Source],
        rows: &Range<usize>,
    ) {
        let news = band.layout.news;
        let copied = issued.copied;
        let place = |target: &Target| match target {
            Target::Register(register) => (*register, (0, 0)),
            Target::Neighbour(direction) => (news, direction.step()),
        };
        let drivers = targets.iter().filter(|target| place(target).0 == news);
        let several = drivers.count() > 1;
        for (part, target) in targets.iter().enumerate() {
            let (register, beside) = place(target);
            if several && register == news {
                continue;
            }
            let (cells, mut block) = (band.take(register), std::mem::take(&mut band.cells));
            let operands = band.operands(sources, issued.input, copied);
            let mut store = Store {
                cells: &mut *cells,
                flag: band.flag(),
                top: band.rows.start,
                register,
                share: Share::of(targets.len(), part),
                beside,
                clip: self.settings.clip,
                step: issued.step,
            };
            let bus = band.bus(&operands);
            rows::store(self.domain, bus, &mut store, rows.clone(), &mut block);
            drop(operands);
            band.put(register, cells);
            band.cells = block;
        }
        if several {
            let driven = targets.iter().enumerate().filter_map(|(part, target)| {
                let (register, beside) = place(target);
                (register == news).then_some((beside, Share::of(targets.len(), part)))
            });
            let cells = band.take(news);
            let operands = band.operands(sources, issued.input, copied);
            let driven: Vec<_> = driven.collect();
            let from = (band.rows.start, issued.step);
            self.drive(&band.bus(&operands), cells, &driven, band, from, rows);
            drop(operands);
            band.put(news, cells);
        }
    }

    /// NEWS cells that several pixels drive: each holds the sum of what they put in.
    fn drive(
        self,
        bus: &Bus<'_, D::Cell>,
        cells: &mut [D::Cell],
        driven: &[((isize, isize), Share)],
        band: &Band<'_, D::Cell>,
        (top, step): (usize, u64),
        rows: &Range<usize>,
    ) {
        let Size { height, width } = bus.size;
        for (y, x) in rows.clone().flat_map(|y| (0..width).map(move |x| (y, x))) {
            let mut total = self.domain.nothing();
            let mut any = None;
            for ((dy, dx), share) in driven {
                let (y, x) = (y.wrapping_add_signed(-dy), x.wrapping_add_signed(-dx));
                let inside = y < height && x < width;
                if inside && band.flag()[(y - top) * band.words() + x / 64] >> (x % 64) & 1 == 0 {
                    continue;
                }
                self.domain.join(&mut total, &bus.sum(self.domain, y, x));
                any = Some(*share);
            }
            if let Some(share) = any {
                let place = Place {
                    y,
                    x,
                    register: band.layout.news,
                    step,
                };
                let stored = self.domain.store(&total, share, place);
                cells[(y - top) * width + x] = self.domain.limited(stored, self.settings.clip);
            }
        }
    }

    fn square(
        self,
        band: &mut Band<'_, D::Cell>,
        issued: Issued<'_>,
        sources: &[Source],
        rows: Range<usize>,
    ) -> Result<(), Undecided> {
        let news = band.layout.news;
        let copied = issued.copied;
        let cells = band.take(news);
        let operands = band.operands(sources, issued.input, copied);
        let mut store = Store {
            cells: &mut *cells,
            flag: band.flag(),
            top: band.rows.start,
            register: news,
            share: Share::of(1, 0),
            beside: (0, 0),
            clip: self.settings.clip,
            step: issued.step,
        };
        let gain = self.settings.square_gain;
        let result = rows::square(self.domain, band.bus(&operands), &mut store, gain, rows);
        drop(operands);
        band.put(news, cells);
        result
    }

    /// One explicit step of diffusion. A link conducts where the gates of both its pixels are
    /// open: R1 along columns, R2 along rows. Nothing flows over the border.
    fn blur(
        self,
        band: &mut Band<'_, D::Cell>,
        target: Analog,
        source: Analog,
        (horizontal, vertical): (bool, bool),
        step: u64,
        rows: Range<usize>,
    ) {
        let Size { height, width } = band.layout.size;
        let words = band.words();
        let gates = Direction::ALL.map(|direction| match direction {
            Direction::North | Direction::South => {
                vertical.then(|| band.layout.roles.enables(Direction::South))
            }
            Direction::East | Direction::West => {
                horizontal.then(|| band.layout.roles.enables(Direction::West))
            }
        });
        let mut linked = [const { Vec::new() }; 4].map(|_: Vec<u64>| vec![0; words]);
        let top = band.rows.start;
        let cells = band.take(target);
        let mut block = std::mem::take(&mut band.cells);
        for y in rows {
            let row = |y: usize| band.row_cells(y..y + 1);
            let mut beside = [y; 4];
            for (k, direction) in Direction::ALL.into_iter().enumerate() {
                let to = y.wrapping_add_signed(direction.step().0);
                linked[k].fill(0);
                if let (Some(gate), true) = (gates[k], to < height) {
                    beside[k] = to;
                    let gates = band.digital(gate);
                    let (own, there) = (
                        &gates[band.row_words(y..y + 1)],
                        &gates[band.row_words(to..to + 1)],
                    );
                    for (i, word) in linked[k].iter_mut().enumerate() {
                        *word = own[i] & bits::seen(there, i, direction, width, false);
                    }
                }
            }
            let from = band.analog(source, source == target);
            let links = Links {
                own: &from[row(y)],
                beside: beside.map(|y| &from[row(y)]),
                linked: linked.each_ref().map(Vec::as_slice),
                parts: self.settings.diffusion.max(4).into(),
            };
            let place = Place {
                y,
                x: 0,
                register: target,
                step,
            };
            let flags = &band.flag()[band.row_words(y..y + 1)];
            let cells = &mut cells[(y - top) * width..][..width];
            let clip = self.settings.clip;
            rows::diffuse(self.domain, &links, flags, place, clip, cells, &mut block);
        }
        band.put(target, cells);
        band.cells = block;
    }
}

/// `words := [kept words or] any of the sources`, `own` excepted.
fn any<C>(
    band: &Band<'_, C>,
    words: &mut [u64],
    rows: Range<usize>,
    sources: &[Bit],
    own: Bit,
    (kept, not): (bool, bool),
) {
    let mut others = sources
        .iter()
        .filter(|bit| **bit != own)
        .map(|bit| &band.bits(*bit, false)[rows.clone()]);
    let few: [Option<&[u64]>; 4] = std::array::from_fn(|_| others.next());
    bits::or(words, few, kept, not);
    for more in others {
        // Not of all is not of each and of each.
        if not {
            bits::clear_where(words, more);
        } else {
            bits::or(words, [Some(more), None, None, None], true, false);
        }
    }
    if not {
        bits::cut(words, band.layout.size.width);
    }
}

/// `target := [not] any source`.
fn logic<C>(
    band: &mut Band<'_, C>,
    target: Digital,
    sources: &[Bit],
    not: bool,
    rows: Range<usize>,
) {
    let own = Bit::Register(target);
    let kept = sources.contains(&own);
    let words = band.row_words(rows.clone());
    let bits = band.take_bits(target);
    if target == band.layout.roles.propagated {
        // A row at a time, by way of a row of its own.
        let mut new = std::mem::take(&mut band.bits);
        for y in rows {
            let words = band.row_words(y..y + 1);
            let old = &mut bits[words.clone()];
            new.copy_from_slice(old);
            any(band, &mut new, words.clone(), sources, own, (kept, not));
            bits::assign_where(old, &new, &band.digital(band.layout.roles.mask)[words]);
        }
        band.bits = new;
    } else {
        any(
            band,
            &mut bits[words.clone()],
            words,
            sources,
            own,
            (kept, not),
        );
    }
    band.put_bits(target, bits);
}

fn fill<C>(band: &mut Band<'_, C>, targets: &[Digital], value: bool, rows: Range<usize>) {
    let width = band.layout.size.width;
    let words = band.row_words(rows);
    let roles = band.layout.roles;
    // R12 first: it goes by R0 as it was before this word.
    if targets.contains(&roles.propagated) {
        let bits = band.take_bits(roles.propagated);
        let mask = &band.digital(roles.mask)[words.clone()];
        let old = &mut bits[words.clone()];
        if value {
            bits::or(old, [Some(mask), None, None, None], true, false);
        } else {
            bits::clear_where(old, mask);
        }
        band.put_bits(roles.propagated, bits);
    }
    for target in targets.iter().filter(|target| **target != roles.propagated) {
        let bits = band.take_bits(*target);
        bits::fill(&mut bits[words.clone()], width, value);
        band.put_bits(*target, bits);
    }
}

/// `target := OR over the directions that are enabled in the reading pixel`.
fn dnews<C>(
    band: &mut Band<'_, C>,
    target: Digital,
    source: Bit,
    boundary: bool,
    rows: Range<usize>,
) {
    let copied = source == Bit::Register(target);
    let mut new = std::mem::take(&mut band.bits);
    for y in rows {
        let words = band.row_words(y..y + 1);
        let Size { height, width } = band.layout.size;
        let source = band.bits(source, copied);
        new.fill(0);
        for direction in Direction::ALL {
            let to = y.wrapping_add_signed(direction.step().0);
            let there = (to < height).then(|| &source[band.row_words(to..to + 1)]);
            let enabled = &band.digital(band.layout.roles.enables(direction))[words.clone()];
            bits::or_seen(&mut new, there, direction, width, boundary, enabled);
        }
        let roles = band.layout.roles;
        let bits = band.take_bits(target);
        let old = &mut bits[words.clone()];
        if target == roles.propagated {
            bits::assign_where(old, &new, &band.digital(roles.mask)[words]);
        } else {
            old.copy_from_slice(&new);
        }
        band.put_bits(target, bits);
    }
    band.bits = new;
}

/// Writes a one-bit register; R12 only where R0 is 1.
pub(super) fn write<C: Clone>(state: &mut State<C>, target: Digital, new: &BitPlane) {
    if target == state.layout.roles.propagated {
        let [mask, spreads] = mask_and_spreads(state);
        bits::assign_where(spreads.words_mut(), new.words(), mask.words());
    } else {
        let words = state.digital_mut(target).words_mut();
        words.copy_from_slice(new.words());
    }
}

/// R0 and R12, to read the one while the other is written.
fn mask_and_spreads<C>(state: &mut State<C>) -> [&mut BitPlane; 2] {
    let roles = state.layout.roles;
    let both = [roles.mask, roles.propagated].map(|register| usize::from(register.0));
    // The check before the run refuses a chip where they are one.
    state.digital.get_disjoint_mut(both).expect("two registers")
}

/// R12 spreads, from row to row until nothing changes or it has gone as far as it can.
pub(super) fn propagate<C: Clone>(state: &mut State<C>, how_far: Propagation, boundary: bool) {
    let steps = match how_far {
        Propagation::Settled => u32::MAX,
        Propagation::Steps(steps) => steps,
    };
    let Size { height, width } = state.layout.size;
    let roles = state.layout.roles;
    let enabled = Direction::ALL.map(|direction| state.digital(roles.enables(direction)).clone());
    let mut seen = BitPlane::zeros(state.layout.size);
    // Only what lies beside a row that changed can change.
    let mut active = 0..height;
    for _ in 0..steps {
        let [mask, spreads] = mask_and_spreads(state);
        for y in active.clone() {
            let new = seen.row_mut(y);
            new.fill(0);
            for (direction, enabled) in Direction::ALL.into_iter().zip(&enabled) {
                let to = y.wrapping_add_signed(direction.step().0);
                let there = (to < height).then(|| spreads.row(to));
                bits::or_seen(new, there, direction, width, boundary, enabled.row(y));
            }
        }
        let mut changed: Option<Range<usize>> = None;
        for y in active {
            let (new, mask) = (seen.row(y), mask.row(y));
            let mut any = 0;
            for ((word, new), mask) in spreads.row_mut(y).iter_mut().zip(new).zip(mask) {
                let more = new & mask & !*word;
                any |= more;
                *word |= more;
            }
            if any != 0 {
                changed.get_or_insert(y..y).end = y + 1;
            }
        }
        let Some(changed) = changed else { break };
        active = changed.start.saturating_sub(1)..(changed.end + 1).min(height);
    }
}
