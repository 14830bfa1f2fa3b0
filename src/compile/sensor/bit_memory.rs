//! Memories in one-bit registers: the range of the drive in equal steps, and which thresholds they
//! serve on the chip.
//!
//! A drive that stays is remembered as the middle of its step. It may be half a step away from that,
//! and a cell whose threshold is less fires in every frame, in exact arithmetic too: such a memory
//! is refused. On the chip the drive is found in one sum of levels and recalled as another. What the
//! stores of both lose, what the cells of a pixel are off by and noise come on top, and grow with the
//! bits. How many cells then fire while the picture stays is predicted here, from the words that
//! [`SensorProgram`](crate::compile::SensorProgram) writes: `scamp5_in` for a level, `add` for each
//! bit that is set.
//!
//! A level is absolute, so a constant of the filter does not drop out, and it is another one near the
//! border of the array ([`dark_offset`](crate::compile::silicon::dark_offset)): a drive beyond the
//! last level fires for ever. Where more cells are quiet so, levels are farther apart and reach as far
//! as the drives of a chip.

use std::f64::consts::{PI, SQRT_2};

use super::cell_kind::{CellKind, DriveMemory};
use crate::{
    compile::{
        error::{CompileError, largest_of_both_signs, most_threshold},
        silicon::dark_offset::Place,
    },
    elementary,
    isa::{self, Device, Errors, StoreTerms},
};

/// A memory in one-bit registers: the range of the drive in equal steps.
#[derive(Clone, Debug, PartialEq)]
pub struct BitMemory {
    /// The lowest drive that light of 0 to 255 can give, on the chip too where that serves better, LSB.
    pub low: f64,
    /// The size of a step, LSB.
    pub step: f64,
    /// The one-bit registers, the lowest bit first.
    pub registers: Vec<String>,
    /// What is wrong with it on the chip, if anything.
    pub restless: Option<Restless>,
}

/// A memory with which more than one in a thousand cells is predicted to fire in a frame of a picture
/// that stays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Restless {
    /// The part of all cells that fires in a frame.
    pub firing: f64,
    /// The lower of its thresholds from which on it does not, LSB; none where the chip can set none
    /// that is high enough.
    pub least: Option<f64>,
    /// The fewest bits of a memory of each kind with which none does at these thresholds.
    pub bits: Option<u8>,
}

/// The part of the cells that may fire in a frame of a picture that stays.
const FIRING: f64 = 1e-3;

/// What a product rounds is no reason to refuse.
const ROUNDED: f64 = 1e-12;

/// A kind whose drive is remembered in bits, on a chip.
pub(super) struct InBits<'a> {
    kind: &'a CellKind,
    errors: Errors,
    /// LSB for each unit of kernel times light.
    scale: f64,
    /// The largest constant that the host can set, LSB.
    largest: f64,
    /// The largest threshold, LSB.
    most: f64,
    /// What the filter's result differs by from frame to frame, LSB.
    noise: f64,
    /// What it is in the dark, all over the array.
    places: Vec<Place>,
}

/// Levels of a memory: where the first begins, and how far they lie apart, LSB.
#[derive(Clone, Copy)]
struct Levels {
    low: f64,
    step: f64,
}

impl<'a> InBits<'a> {
    /// A kind with the scale and the noise of its filter, and what that leaves in the dark.
    pub(super) fn new(
        kind: &'a CellKind,
        device: &Device,
        (scale, noise): (f64, f64),
        places: Vec<Place>,
    ) -> Self {
        Self {
            kind,
            errors: Errors::from_device(device),
            scale,
            largest: largest_of_both_signs(device),
            most: most_threshold(device),
            noise,
            places,
        }
    }

    /// Its memory in these registers.
    fn memory(&self, registers: &[String]) -> BitMemory {
        let Levels { low, step } = self.quietest(registers.len() as u8, 1.0).0;
        BitMemory {
            low,
            step,
            registers: registers.to_vec(),
            restless: None,
        }
    }

    /// The lowest and the highest drive of light from 0 to 255 in a place, LSB, without what it is in
    /// the dark.
    fn ends(&self, place: Place) -> [f64; 2] {
        [-1.0, 1.0].map(|sign: f64| {
            let weights = place.on_the_array(&self.kind.kernel);
            weights.filter(|w| *w * sign > 0.0).sum::<f64>() * 255.0 * self.scale
        })
    }

    /// The same on a chip, all over the array, and what is without a chip's errors.
    fn ends_on_chip(&self) -> [f64; 2] {
        let exact = self.ends(Place::MIDDLE);
        { self.places.iter() }.fold(exact, |[low, high], place| {
            let own = self.ends(*place).map(|end| end + place.constant);
            [low.min(own[0]), high.max(own[1])]
        })
    }

    /// So many bits from one end to the other: levels a whole number of LSB apart where the range is
    /// wide enough, as the host can set no others.
    fn levels(&self, [low, high]: [f64; 2], bits: u8) -> Levels {
        let bits = i32::from(bits);
        let step = (high - low) / 2f64.powi(bits);
        let step = if step > 1.0 {
            // The largest constant that is added must lie within the host's range.
            step.ceil().min(self.largest / 2f64.powi(bits - 1))
        } else {
            // The next power of two; of a kernel of zeros, any.
            2f64.powi(elementary::log2(step).ceil().max(-16.0) as i32)
        };
        // As far as the host can set it.
        Levels {
            low: low.floor().max(-self.largest),
            step,
        }
    }

    /// The distance of levels that reach as far as drives without a chip's errors.
    fn step(&self, bits: u8) -> f64 {
        self.levels(self.ends(Place::MIDDLE), bits).step
    }

    /// The levels with which the fewest cells fire, of those with which none does without errors; those
    /// as far as drives without errors where that is few enough. And how many then fire.
    fn quietest(&self, bits: u8, times: f64) -> (Levels, f64) {
        let firing = |levels: Levels| (levels, self.firing(levels, bits, times));
        let exact = firing(self.levels(self.ends(Place::MIDDLE), bits));
        if exact.1 <= FIRING {
            return exact;
        }
        let wide = self.levels(self.ends_on_chip(), bits);
        if !self.is_silent(wide.step, times) {
            return exact;
        }
        let wide = firing(wide);
        if wide.1 < exact.1 { wide } else { exact }
    }

    /// Both thresholds as the chip gets them, taken so many times, LSB.
    fn thresholds(&self, times: f64) -> [f64; 2] {
        [self.kind.on, self.kind.off].map(|it| self.errors.held(it * self.scale * times))
    }

    /// The lower of them.
    fn least(&self, times: f64) -> f64 {
        let [on, off] = self.thresholds(times);
        on.min(off)
    }

    /// Whether drives that stay are silent without errors: half a step away from what is remembered.
    fn is_silent(&self, step: f64, times: f64) -> bool {
        step / 2.0 <= self.least(times) * (1.0 + ROUNDED)
    }

    /// Whether they are on the chip.
    fn serves(&self, bits: u8, times: f64) -> bool {
        self.is_silent(self.step(bits), times) && self.quietest(bits, times).1 <= FIRING
    }

    /// How many times as high its thresholds must be at least for so many bits; none where the chip
    /// can set none that serve.
    fn times(&self, bits: u8) -> Option<f64> {
        let most = self.most / self.kind.on.max(self.kind.off) / self.scale;
        if self.serves(bits, 1.0) {
            return Some(1.0);
        }
        if !self.serves(bits, most) {
            return None;
        }
        let mut ends = (1.0, most);
        while ends.1 - ends.0 > ends.1 * f64::EPSILON {
            let middle = f64::midpoint(ends.0, ends.1);
            // The converter makes the same of most.
            let same = |other| self.thresholds(middle) == self.thresholds(other);
            if same(ends.1) || !same(ends.0) && self.serves(bits, middle) {
                ends.1 = middle;
            } else {
                ends.0 = middle;
            }
        }
        Some(ends.1)
    }

    /// The part of the cells that fires in a frame of a picture that stays, as predicted, with light
    /// that is independent from pixel to pixel and uniform from 0 to 255.
    fn firing(&self, levels: Levels, bits: u8, times: f64) -> f64 {
        let recall = Recall::new(self, levels, bits, times);
        let mut edges = Vec::new();
        for code in 0..1u32 << bits {
            for sign in [Sign::On, Sign::Off] {
                if let Some(edge) = recall.edge(code, sign) {
                    let (clear, by) = recall.clear(edge, (code, sign));
                    edges.push((recall.at(&AVERAGE, edge).0, beyond(clear, by)));
                }
            }
        }
        let places = self.places.iter();
        let firing = places.map(|place| place.share * self.firing_in(*place, &recall, &edges));
        firing.sum::<f64>().min(1.0)
    }

    /// The same of the cells of a place; `edges`: where steps begin, and over what length of drives a
    /// cell fires there.
    fn firing_in(&self, place: Place, recall: &Recall<'_>, edges: &[(f64, f64)]) -> f64 {
        let light = 255.0 * self.scale;
        let (mut sum, mut squares) = (0.0, 0.0);
        for weight in place.on_the_array(&self.kind.kernel) {
            sum += weight;
            squares += weight * weight;
        }
        let mean = sum * light / 2.0 + place.constant;
        let spread = (squares / 12.0).sqrt() * light;
        if spread <= 0.0 {
            return 0.0;
        }
        let near = |at: f64, length: f64| length * density((at - mean) / spread) / spread;
        let mut firing: f64 = edges.iter().map(|(at, length)| near(*at, *length)).sum();
        let [low, high] = self.ends(place).map(|end| end + place.constant);
        let last = (1u32 << recall.bits) - 1;
        for (end, step) in [(low, (0, Sign::Off)), (high, (last, Sign::On))] {
            let (clear, by) = recall.clear(Edge::At(end), step);
            firing += if clear >= 0.0 {
                near(end, beyond(clear, by))
            } else {
                // From where it is short of its threshold no longer up to the end.
                let (clear, by) = recall.clear(Edge::At(mean), step);
                let over = above(clear / elementary::hypot(spread, by));
                (over - above((end - mean).abs() / spread)).max(0.0)
            };
        }
        firing.min(1.0)
    }
}

/// The part of a normal distribution above this.
fn above(z: f64) -> f64 {
    0.5 * libm::erfc(z / SQRT_2)
}

/// The normal density.
fn density(z: f64) -> f64 {
    elementary::exp(-z * z / 2.0) / (2.0 * PI).sqrt()
}

/// Over what length of drives a cell fires at one edge of a step, where its threshold is clear of
/// the edge itself by so much, with this standard deviation.
fn beyond(clear: f64, by: f64) -> f64 {
    if by <= 0.0 {
        return (-clear).max(0.0);
    }
    let z = clear / by;
    by * (density(z) - z * above(z))
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Sign {
    On,
    Off,
}

/// Where a drive lies.
#[derive(Clone, Copy)]
enum Edge {
    /// Where a step begins: at the least drive that is remembered as this code.
    From(u32),
    /// At this drive, LSB.
    At(f64),
}

/// The cells of a pixel that take part.
#[derive(Clone, Copy)]
enum Cell {
    News,
    Memory,
    Level,
    Difference,
}

/// By how many standard deviations the gain and the offset of each cell of a pixel are off.
type Own = [[f64; 2]; 4];

/// An average pixel.
const AVERAGE: Own = [[0.0; 2]; 4];

/// What is remembered in so many bits, store by store.
struct Recall<'a> {
    errors: &'a Errors,
    bits: u8,
    low: f64,
    step: f64,
    thresholds: [f64; 2],
    noise: f64,
}

impl<'a> Recall<'a> {
    fn new(of: &'a InBits<'_>, Levels { low, step }: Levels, bits: u8, times: f64) -> Self {
        Self {
            errors: &of.errors,
            bits,
            low,
            step,
            thresholds: of.thresholds(times),
            noise: of.noise,
        }
    }

    fn store(&self, own: &Own, cell: Cell, current: f64) -> f64 {
        let [gain, offset] = own[cell as usize];
        let (gain, offset) = (self.errors.gain(gain), self.errors.offset(gain, offset));
        isa::stored(current, gain, offset)
    }

    /// Two stores, through NEWS, as in `scamp5_in` and `add`.
    fn moved(&self, own: &Own, cell: Cell, current: f64) -> f64 {
        self.store(own, cell, self.store(own, Cell::News, current))
    }

    fn set(&self, own: &Own, cell: Cell, lsb: f64) -> f64 {
        self.moved(own, cell, self.errors.calibrated(self.errors.held(lsb)))
    }

    /// Minus the sum of levels from `from` on, and the stores that it takes.
    fn sum(&self, own: &Own, from: f64, bits: impl Iterator<Item = u8>) -> (f64, u32) {
        let first = self.set(own, Cell::Memory, -from);
        bits.fold((first, 2), |(sum, stores), bit| {
            let level = self.set(own, Cell::Level, -self.level(bit));
            (self.moved(own, Cell::Memory, sum + level), stores + 4)
        })
    }

    fn level(&self, bit: u8) -> f64 {
        self.step * 2f64.powi(i32::from(bit))
    }

    /// Where the step ends towards which a cell of this sign fires, if another follows.
    fn edge(&self, code: u32, sign: Sign) -> Option<Edge> {
        let from = match sign {
            Sign::Off => code,
            Sign::On => code + 1,
        };
        (1..1 << self.bits)
            .contains(&from)
            .then_some(Edge::From(from))
    }

    /// The drive at an edge, and the stores with which it is found.
    fn at(&self, own: &Own, edge: Edge) -> (f64, u32) {
        match edge {
            Edge::At(drive) => (drive, 0),
            Edge::From(code) => {
                // The highest bit first; the last that is set is not added any more.
                let last = code.trailing_zeros() as u8;
                let above = (last + 1..self.bits).rev();
                let (sum, stores) =
                    self.sum(own, self.low, above.filter(|bit| (code >> bit) & 1 == 1));
                let level = self.set(own, Cell::Level, -self.level(last));
                (-(sum + level), stores + 2)
            }
        }
    }

    /// By how much a drive that stays at an edge is short of its threshold, and the stores of all
    /// that is compared.
    fn short(&self, own: &Own, edge: Edge, (code, sign): (u32, Sign)) -> (f64, u32) {
        let (drive, found) = self.at(own, edge);
        let set = (0..self.bits).filter(|bit| (code >> bit) & 1 == 1);
        let (memory, recalled) = self.sum(own, self.low + self.step / 2.0, set);
        let threshold = self.set(own, Cell::Level, -self.thresholds[sign as usize]);
        let stores = found + recalled + 2;
        match sign {
            Sign::On => (-(drive + memory + threshold), stores),
            Sign::Off => {
                let news = self.store(own, Cell::News, 0.0);
                let difference = self.store(own, Cell::Difference, news + drive + memory);
                (-(difference + threshold), stores + 2)
            }
        }
    }

    /// The same of an average pixel, and its standard deviation, over pixels and frames.
    fn clear(&self, edge: Edge, step: (u32, Sign)) -> (f64, f64) {
        let (average, stores) = self.short(&AVERAGE, edge, step);
        let StoreTerms {
            noise,
            // In `Errors::gain` and `Errors::offset`.
            transfer: _,
            loss: _,
            gain_mismatch: _,
            offset_mismatch: _,
            mismatch_correlation: _,
            // No bus splits here.
            division: _,
            division_mismatch: _,
        } = self.errors.of_a_store();
        // Of the drive's noise that of the frame in which it was found, too.
        let mut variance = 2.0 * self.noise * self.noise + f64::from(stores) * noise * noise;
        for cell in 0..AVERAGE.len() {
            for of in 0..2 {
                let mut own = AVERAGE;
                own[cell][of] = 1.0;
                let by = self.short(&own, edge, step).0 - average;
                variance += by * by;
            }
        }
        (average, variance.sqrt())
    }
}

/// The memories of all kinds, each in so many of these registers.
///
/// # Errors
/// When drives that stay fire for ever, in exact arithmetic too.
pub(super) fn memories(
    kinds: &[InBits<'_>],
    bits: u8,
    registers: &[String],
) -> Result<Vec<BitMemory>, CompileError> {
    let short = |kind: &&InBits<'_>| !kind.is_silent(kind.step(bits), 1.0);
    // The fewest bits with which no kind fires.
    let fewest = || {
        let all = |bits: &u8| kinds.iter().all(|kind| kind.serves(*bits, 1.0));
        (1..=DriveMemory::MOST_BITS).find(all)
    };
    let far = |kind: &&InBits<'_>| kind.step(bits) / kind.least(1.0);
    if let Some(kind) = { kinds.iter().filter(short) }.max_by(|a, b| far(a).total_cmp(&far(b))) {
        let times = kinds.iter().map(|kind| kind.times(bits));
        return Err(CompileError::Levels {
            bits,
            needed: fewest(),
            step: kind.step(bits),
            threshold: kind.least(1.0),
            times: times.reduce(|a, b| Some(a?.max(b?))).flatten(),
            advice: String::new(),
        });
    }
    let own = |(kind, registers): (&InBits<'_>, &[String])| {
        let firing = kind.quietest(bits, 1.0).1;
        let restless = (firing > FIRING).then(|| Restless {
            firing,
            least: kind
                .times(bits)
                .map(|times| kind.kind.on.min(kind.kind.off) * kind.scale * times),
            bits: fewest(),
        });
        BitMemory {
            restless,
            ..kind.memory(registers)
        }
    };
    let registers = registers.chunks(usize::from(bits));
    Ok(kinds.iter().zip(registers).map(own).collect())
}
