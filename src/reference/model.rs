//! The model of one cell, from its drive to its train, in the order of the paper (So &
//! Wetzstein, *Neural Ganglion Sensors*, arXiv 2504.13457).
//!
//! It is the definition: one cell, one interval, one operation after the other. The
//! other files of this folder compute the same for whole rows, and `tests/reference_twin.rs`
//! holds them to it, to the bit, in every number format.
//!
//! With `u = R(I)` the signal, `W` the kernel, `θ` the threshold (`θ_on` for `d ≥ 0`, `θ_off`
//! below), `p = ±1` the sign, `N` the number of events, and `Δ` the time between two frames:
//!
//! ```text
//! drive       (1)  S(x) = sum over k of W(k) u(x + k)
//!
//! distance    (2)  d = W * (u - M)                raw-snap             Eq. 2 of the paper
//!                  d = S - M                      filtered-snap, filtered-step
//!                  d = S - W_m * M                authors-pixel-step
//!
//! fire, once  (3)  N = 1 if |d| > θ               a memory that snaps: at the later frame
//! or often    (4)  N = floor(|d| / θ)             a memory that steps, ties included
//!             (5)  u_i = (i θ - p d0) / (p (d - d0))     where the line from d0 to d meets i θ
//!
//! memory      (6)  M := u or S                    snaps                Eq. 4 of the paper
//!                  M := u, for all kinds of x     snaps, shared: when any kind of x fires
//!             (7)  M := M + p N θ                 steps                the released code, v2e
//!
//! polarity    (8)  p = sign(d), or sign(u - u')   u' when it last fired; Eq. 3 of the paper
//!
//! dead time   (9)  an event at t silences [t, t + r)
//! or authors' (10) α   = Δ θ / (|d| + 1e-9)
//!             (11) α_r = (floor(r / α) + 1) α
//!             (12) β_r = max(0, floor((r - (t0 - t')) / α) α)       t' when it last fired
//!             (13) N   = floor((Δ - β_r) / α_r) if α_r ≤ Δ - β_r, else 0; at t0 + β_r + i α_r
//! ```
//!
//! In (4) a crossing by equality fires, whatever rounding does to it ([`Real::TIE`]); (5) is
//! ESIM's rule (Rebecq et al., `CoRL` 2018); (10) to (13) are the paper's supplement as its
//! released code computes it.
//!
//! A shared memory makes one [`Pixel`] of the cells that lie at one place, one of each kind: all see
//! the memory as it was before the frame, and (6) follows when all have decided.
//!
//! The cell is given its drive (1): the sum over pixels is a step of its own. Drives, memories
//! and their differences are held in the number format and rounded once an operation; (3) to
//! (5) are computed in its [`Number::Real`], times in double precision. Noise events, and
//! the jitter of a train, are not part of it.
//!
//! ```
//! use amacrine::number::F64;
//! use amacrine::reference::{Interval, PolarityRule, Refractory, RefractoryRule};
//! use amacrine::reference::model::{Cell, FilteredStep, Seen, Setting};
//!
//! let setting = Setting {
//!     number: F64,
//!     on: 0.2,
//!     off: 0.1,
//!     leak: 0.0,
//!     polarity: PolarityRule::Filtered,
//!     refractory: Refractory { us: 0.0, rule: RefractoryRule::DeadTime },
//! };
//! let seen = |drive| Seen { signal: drive, drive, memory: 0.0 };
//! let mut cell = Cell::<_, FilteredStep>::new(setting, 0.0, seen(0.0), 0.0);
//! let interval = Interval { index: 0, from: 0.0, to: 0.01 };
//! let train = cell.see(seen(0.8), interval).unwrap();
//! assert_eq!((train.count, train.first, train.spacing), (4, 0.25, 0.25));
//! assert_eq!(cell.memory(), 0.8);
//! ```

use std::marker::PhantomData;

use crate::{
    event::Polarity,
    number::{Number, Real},
};

use super::{
    description::{PolarityRule, Refractory, RefractoryRule},
    train::{Interval, Train},
};

/// What a cell sees in one frame, in the unit of the signal.
#[derive(Clone, Copy, Debug)]
pub struct Seen<N: Number> {
    /// `u(x)`: the signal of its own pixel.
    pub signal: N::Held,
    /// (1): what the kernel makes of the signal; for [`RawSnap`] of the signal less the
    /// memory, `u - M`.
    pub drive: N::Held,
    /// What the memory's own kernel gives of the memory; only for [`PixelStep`].
    pub memory: N::Held,
}

/// The constants of a cell.
#[derive(Clone, Copy, Debug)]
pub struct Setting<N: Number> {
    /// The number format.
    pub number: N,
    /// `θ_on`, above 0, in the unit of the drive; with the cell's mismatch.
    pub on: f64,
    /// `θ_off`, a positive magnitude.
    pub off: f64,
    /// How far the leak lowers the memory, in the unit of the drive per second; 0 without leak.
    pub leak: f64,
    /// Where the sign of an event comes from.
    pub polarity: PolarityRule,
    /// How long the cell is silent after an event.
    pub refractory: Refractory,
}

/// A memory rule: what is stored, what it is compared with, and what an event does to it.
pub trait MemoryModel {
    /// What an event does: it stores what is seen (3, 6), or moves what is stored (4, 7).
    type Event: EventRule;

    /// What is stored in a frame: the signal or the drive.
    fn stored<N: Number>(seen: &Seen<N>) -> N::Held;

    /// The distance (2) of what is seen from the memory.
    fn distance<N: Number>(number: &N, seen: &Seen<N>, memory: N::Held) -> N::Held;
}

/// The paper's rule: pixels are stored, and a cell that fires stores its own.
#[derive(Clone, Copy, Debug)]
pub struct RawSnap;

/// The drive is stored.
#[derive(Clone, Copy, Debug)]
pub struct Filtered<E>(PhantomData<E>);

/// The drive is stored anew when the cell fires: one shot a frame on a chip.
pub type FilteredSnap = Filtered<Snap>;

/// The drive is stored, and each event moves it by a threshold: the released code, v2e.
pub type FilteredStep = Filtered<Step>;

/// Pixels are stored, and are moved by thresholds of the drive: the released code's old rule.
#[derive(Clone, Copy, Debug)]
pub struct PixelStep;

impl MemoryModel for RawSnap {
    type Event = Snap;

    fn stored<N: Number>(seen: &Seen<N>) -> N::Held {
        seen.signal
    }
    fn distance<N: Number>(_: &N, seen: &Seen<N>, _: N::Held) -> N::Held {
        seen.drive
    }
}

impl<E: EventRule> MemoryModel for Filtered<E> {
    type Event = E;

    fn stored<N: Number>(seen: &Seen<N>) -> N::Held {
        seen.drive
    }
    fn distance<N: Number>(number: &N, seen: &Seen<N>, memory: N::Held) -> N::Held {
        number.sub(seen.drive, memory)
    }
}

impl MemoryModel for PixelStep {
    type Event = Step;

    fn stored<N: Number>(seen: &Seen<N>) -> N::Held {
        seen.signal
    }
    fn distance<N: Number>(number: &N, seen: &Seen<N>, _: N::Held) -> N::Held {
        number.sub(seen.drive, seen.memory)
    }
}

/// An event rule: when a cell fires, and what that does to its memory.
pub trait EventRule {
    /// The crossings on the line from distance `d0` to `d`, if there are any.
    fn fires<R: Real>(d0: R, d: R, on: R, off: R) -> Option<Train>;

    /// Moves the memory by these events, where `now` is what it would store.
    fn moves<H>(memory: &mut Memory<H>, events: &Train, now: H);
}

/// The memory becomes what is seen (it snaps).
#[derive(Clone, Copy, Debug)]
pub struct Snap;

/// The memory moves by whole thresholds (it steps).
#[derive(Clone, Copy, Debug)]
pub struct Step;

/// A memory: what was stored, and how many thresholds it has moved up and down since.
#[derive(Clone, Copy, Debug)]
pub struct Memory<H> {
    base: H,
    ups: f64,
    downs: f64,
}

impl<H> Memory<H> {
    const fn new(base: H) -> Self {
        let (ups, downs) = (0.0, 0.0);
        Self { base, ups, downs }
    }
}

impl EventRule for Snap {
    /// (3)
    fn fires<R: Real>(_: R, d: R, on: R, off: R) -> Option<Train> {
        let count = if d > on || -d > off { R::ONE } else { R::ZERO };
        train(d, count, R::ONE, R::ZERO)
    }
    /// (6)
    fn moves<H>(memory: &mut Memory<H>, _: &Train, now: H) {
        *memory = Memory::new(now);
    }
}

impl EventRule for Step {
    /// (4), and (5) as `u_1` and the spacing `θ / (p (d - d0))`.
    fn fires<R: Real>(d0: R, d: R, on: R, off: R) -> Option<Train> {
        let theta = if d >= R::ZERO { on } else { off };
        let levels = d.abs() * (R::ONE / theta);
        let (tolerance, half) = (levels * R::TIE, R::from_f64(0.5));
        let count = (levels + if tolerance < half { tolerance } else { half }).floor();
        let start = d0.mul_sign(d);
        let rise = d.abs() - start;
        let per = R::ONE / rise;
        if rise > R::ZERO {
            train(d, count, (theta - start) * per, theta * per)
        } else {
            // The leak made the crossing: it is placed at the later frame.
            train(d, count, R::ONE, R::ZERO)
        }
    }
    /// (7)
    fn moves<H>(memory: &mut Memory<H>, events: &Train, _: H) {
        match events.polarity {
            Polarity::On => memory.ups += events.count as f64,
            Polarity::Off => memory.downs += events.count as f64,
        }
    }
}

/// A train with the sign of `d`, if it has events.
fn train<R: Real>(d: R, count: R, first: R, spacing: R) -> Option<Train> {
    (count > R::ZERO).then(|| Train {
        polarity: polarity(d),
        count: count.to_f64() as u64,
        first: first.to_f64().clamp(0.0, 1.0),
        spacing: spacing.to_f64(),
    })
}

fn polarity<R: Real>(d: R) -> Polarity {
    Polarity::of(d > R::ZERO)
}

/// One cell.
#[derive(Clone, Copy, Debug)]
pub struct Cell<N: Number, M> {
    setting: Setting<N>,
    /// When its first frame was, in seconds.
    start: f64,
    memory: Memory<N::Held>,
    /// What it saw in the frame before.
    before: Seen<N>,
    /// `u'`: the signal of its pixel when it last fired, or in the first frame.
    pixel: N::Held,
    /// `t'`: when it last fired, in seconds.
    fired: f64,
    /// When it last fired before the last interval, or by a noise event in it.
    rested: f64,
    /// Whether it fired in the last interval, whatever became of its events.
    crossed: bool,
    /// Crossings and noise events lost to the refractory period so far.
    pub lost: u64,
    /// How often it fired without a sign of its own (8), and so made no event.
    pub without_sign: u64,
    rule: PhantomData<M>,
}

impl<N: Number, M: MemoryModel> Cell<N, M> {
    /// A cell that sees its first frame at `seconds`, and has never fired. Its memory is
    /// `memory`: what it stores of that frame, less what has leaked before.
    #[must_use]
    pub const fn new(setting: Setting<N>, seconds: f64, first: Seen<N>, memory: N::Held) -> Self {
        Self {
            setting,
            start: seconds,
            memory: Memory::new(memory),
            before: first,
            pixel: first.signal,
            fired: f64::NEG_INFINITY,
            rested: f64::NEG_INFINITY,
            crossed: false,
            lost: 0,
            without_sign: 0,
            rule: PhantomData,
        }
    }

    /// `M`, without what has leaked since it was stored: `base + n_on θ_on - n_off θ_off`.
    pub fn memory(&self) -> N::Held {
        let Memory { base, ups, downs } = self.memory;
        let ([on, off], number) = (self.thresholds(), &self.setting.number);
        super::memory::apart(number, base, (ups, downs), on, off)
    }

    /// Sees the later frame of an interval; returns the train in the interval, if it fires.
    ///
    /// Unlike the sensor, which refuses what it cannot count, it does not look at how many
    /// events there are, nor at whether a distance is a number.
    pub fn see(&mut self, seen: Seen<N>, interval: Interval) -> Option<Train> {
        let (Setting { number, leak, .. }, [on, off]) = (self.setting, self.thresholds());
        let elapsed = interval.to - self.start;
        let memory = self.memory();
        let fallen = |elapsed: f64| N::Real::from_f64(leak) * N::Real::from_f64(elapsed);
        let distance = |seen| number.real(M::distance(&number, seen, memory));
        let d0 = distance(&self.before) + fallen(elapsed - interval.duration());
        let d = distance(&seen) + fallen(elapsed);
        (self.before, self.rested, self.crossed) = (seen, self.fired, false);
        let authors = self.setting.refractory.rule == RefractoryRule::Authors;
        let events = if authors {
            self.authors(d.to_f64(), interval)?
        } else {
            M::Event::fires(d0, d, on, off)?
        };
        self.crossed = true;
        let now = number.hold_real(number.real(M::stored(&seen)) + fallen(elapsed));
        M::Event::moves(&mut self.memory, &events, now);
        let events = self.signed(events, seen.signal)?;
        let kept = if authors {
            events
        } else {
            self.awake(events, interval)?
        };
        self.fired = interval.from + kept.last() * interval.duration();
        Some(Train {
            first: N::Real::from_f64(kept.first).to_f64(),
            spacing: N::Real::from_f64(kept.spacing).to_f64(),
            ..kept
        })
    }

    /// Whether a noise event at `u` in the interval (0 at the earlier frame, 1 at the later)
    /// survives beside the cell's own `train`. It must lie a refractory period from all events of
    /// the cell; noise events must be passed in order of time.
    pub fn hears(&mut self, u: f64, train: Option<&Train>, interval: Interval) -> bool {
        let dt = interval.duration();
        let r = self.setting.refractory.us * 1e-6 / dt * (1.0 - 1e-9);
        let own = |train: &Train| (0..train.count).all(|i| (train.at(i) - u).abs() >= r);
        let heard = u - (self.rested - interval.from) / dt >= r && train.is_none_or(own);
        if heard {
            self.rested = interval.from + u * dt;
            self.fired = self.fired.max(self.rested);
        } else {
            self.lost += 1;
        }
        heard
    }

    fn thresholds(&self) -> [N::Real; 2] {
        [self.setting.on, self.setting.off].map(N::Real::from_f64)
    }

    /// (8)
    fn signed(&mut self, events: Train, signal: N::Held) -> Option<Train> {
        let number = self.setting.number;
        let own = number.real(number.sub(signal, self.pixel));
        self.pixel = signal;
        if self.setting.polarity == PolarityRule::Filtered {
            return Some(events);
        }
        self.without_sign += u64::from(own == N::Real::ZERO);
        let polarity = polarity(own);
        (own != N::Real::ZERO).then_some(Train { polarity, ..events })
    }

    /// The dead time (9), one crossing after the other; all times in units of the interval.
    fn awake(&mut self, events: Train, interval: Interval) -> Option<Train> {
        let dt = interval.duration();
        // The tolerance keeps a crossing that rounding puts just before the end of the dead time.
        let r = self.setting.refractory.us * 1e-6 / dt * (1.0 - 1e-9);
        if r == 0.0 {
            return Some(events);
        }
        let rested = (interval.from - self.fired) / dt;
        let mut kept = Vec::new();
        for i in (0..events.count).map(|i| i as f64) {
            let since = match kept.last() {
                None => rested + events.first + events.spacing * i,
                Some(last) => events.spacing * (i - last),
            };
            if since >= r {
                kept.push(i);
            }
        }
        self.lost += events.count - kept.len() as u64;
        let stride = kept.get(1).map_or(0.0, |second| second - kept[0]);
        Some(Train {
            count: kept.len() as u64,
            first: events.first + events.spacing * kept.first()?,
            spacing: events.spacing * stride,
            ..events
        })
    }

    /// The authors' rule (10) to (13), with the operations in the order of the released code.
    fn authors(&self, d: f64, interval: Interval) -> Option<Train> {
        let (dt, r) = (interval.duration(), self.setting.refractory.us * 1e-6);
        let theta = self.thresholds()[usize::from(d < 0.0)].to_f64();
        let alpha = dt / ((d.abs() + 1e-9) / theta);
        let alpha_r = ((r / alpha).floor() + 1.0) * alpha;
        let beta_r = ((r - (interval.from - self.fired)) / alpha).floor() * alpha;
        let beta_r = beta_r.max(0.0);
        (d != 0.0 && alpha_r <= dt - beta_r).then(|| Train {
            polarity: polarity(d),
            count: ((dt - beta_r) / alpha_r).floor() as u64,
            first: (beta_r + alpha_r) / dt,
            spacing: alpha_r / dt,
        })
    }
}

/// The cells of one pixel, one of each kind, which share one memory of it.
#[derive(Clone, Debug)]
pub struct Pixel<N: Number> {
    cells: Vec<Cell<N, RawSnap>>,
}

impl<N: Number> Pixel<N> {
    /// A pixel of these cells, which have seen their first frame and hold the same memory.
    #[must_use]
    pub const fn new(cells: Vec<Cell<N, RawSnap>>) -> Self {
        Self { cells }
    }

    /// `M`: the signal of the pixel when any of its cells last fired.
    ///
    /// # Panics
    /// When the pixel has no cells.
    #[must_use]
    pub fn memory(&self) -> N::Held {
        self.cells[0].memory()
    }

    /// The cells, in the order of their kinds.
    pub fn cells_mut(&mut self) -> &mut [Cell<N, RawSnap>] {
        &mut self.cells
    }

    /// Sees the later frame of an interval with every kind; returns their trains. The drives are
    /// what each kernel makes of the signal less the memory before the frame.
    pub fn see(&mut self, seen: &[Seen<N>], interval: Interval) -> Vec<Option<Train>> {
        let cells = self.cells.iter_mut().zip(seen);
        let trains = cells.map(|(cell, seen)| cell.see(*seen, interval));
        let trains = trains.collect();
        if self.cells.iter().any(|cell| cell.crossed) {
            // (6), also in the cells that did not fire.
            for (cell, seen) in self.cells.iter_mut().zip(seen) {
                cell.memory = Memory::new(seen.signal);
                cell.pixel = seen.signal;
            }
        }
        trains
    }
}
