//! Noise: what disturbs a cell. Each is off by default; each is a hash of
//! (seed, reason, channel, pixel, interval), so the same seed gives the same events in any order
//! of work.
//!
//! | key of `[noise]` | unit | what it does | rate on a still scene |
//! |---|---|---|---|
//! | `leak-hz` | events/s | the memory falls by `leak-hz θ_on` each second (junction leakage of the reset switch; Nozaki & Delbruck, IEEE TED 64:3239, 2017) | `leak-hz` ON events per cell |
//! | `leak-spread` | decades | each cell's own leak: log-normal with this standard deviation, median `leak-hz` | `leak-hz exp((ln 10 leak-spread)² / 2)` |
//! | `shot-hz` | events/s | noise events in the dark, half ON half OFF, a Poisson process in each cell | `shot-hz` |
//! | `shot-at-white` | - | the share of it that is left at light 255; a straight line between, constant above; the light of the later frame of a pair | `shot-hz (1 + (shot-at-white - 1) I / 255)` |
//! | `hot-fraction`, `hot-hz` | -, events/s | this share of the cells fires ON at this rate instead, a Poisson process, whatever it sees | `hot-fraction hot-hz` per cell |
//! | `jitter-us` | us | the events of a cell in an interval move together by a normal draw, reflected at the interval's ends | |
//! | `cutoff-hz` | Hz | the photoreceptor is a first-order low-pass whose bandwidth grows with light, `cutoff-hz (I + 20) / 275` (v2e's law) | |
//! | `cutoff-rule` | - | what light does between frames, as the low-pass sees it: `ramp` or `step` | |
//!
//! The threshold's own mismatch is `sigma` of a channel's `threshold`.
//!
//! **Leak.** Cells do not start in step: each has leaked for a part of its first interval
//! already, uniformly drawn, as in a sensor that has been on for long. The mean count in a
//! time `T` is then exactly the cell's leak times `T`.
//!
//! **Shot noise and hot pixels** leave the memory alone. Under a dead time a cell is deaf to
//! them for that time after each of its events, and they give way to an event of the scene
//! that follows within it in the same interval.
//!
//! **Low-pass.** The exact filter of a signal that is a straight line between frames (`cutoff-rule`
//! `ramp`), so light that moves on lags by `1 / 2π f` at any frame rate; or of one that steps to
//! the later frame at once (`step`), as v2e's. It starts settled.
//!
//! v2e's rules are known to be faulty in places, and are not copied: its shot events reset the
//! memory to the photoreceptor's value even where the memory holds something else, come at
//! most once a frame and are stamped with the frame's end; its leak starts in step in all
//! cells; its low-pass is an Euler step that has to be clipped.

use crate::{
    config::{Key, Kind, Node, Range, Read, Section, Table},
    elementary,
    mesh::Between,
};

use super::{
    reason::{Place, Reason},
    train::Train,
};

/// The noise of a sensor's cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// ON events a second that leakage makes in a cell.
    pub leak_hz: f64,
    /// Standard deviation of the cells' leak rates, in decades.
    pub leak_spread: f64,
    /// Shot noise events a second in a cell in the dark, ON and OFF together.
    pub shot_hz: f64,
    /// The share of them that is left at light 255, 0 to 1.
    pub shot_at_white: f64,
    /// Share of cells that are hot, 0 to 1.
    pub hot_fraction: f64,
    /// Events a second of a hot cell.
    pub hot_hz: f64,
    /// Standard deviation of the events' times, in microseconds.
    pub jitter_us: f64,
    /// Bandwidth of the photoreceptor at light 255, in hertz; 0 for no limit.
    pub cutoff_hz: f64,
    /// What the light does between two frames, as the photoreceptor sees it.
    pub cutoff_rule: Between,
}

impl Default for Noise {
    fn default() -> Self {
        Self::NONE
    }
}

/// The light at which `shot-at-white` holds: white in 8-bit video.
const WHITE: f64 = 255.0;

/// The highest rate of events in hertz: times have microseconds.
const FASTEST: f64 = 1e6;

/// A key of `[noise]`: a number from 0 on.
const fn rate(
    name: &'static str,
    most: f64,
    default: &'static str,
    what: &'static str,
    unit: &'static str,
) -> Key {
    let range = Range::between(0.0, most);
    Key::with_default(name, Kind::Number(range), default, what).unit(unit)
}

impl Noise {
    /// No noise.
    pub const NONE: Self = Self {
        leak_hz: 0.0,
        leak_spread: 0.0,
        shot_hz: 0.0,
        shot_at_white: 1.0,
        hot_fraction: 0.0,
        hot_hz: 0.0,
        jitter_us: 0.0,
        cutoff_hz: 0.0,
        cutoff_rule: Between::Ramp,
    };

    /// The keys of `[noise]`.
    pub const TABLE: Table = Table::new(&[
        rate(
            "leak-hz",
            FASTEST,
            "0",
            "ON events that leakage makes in a cell",
            "events/s",
        ),
        rate(
            "leak-spread",
            3.0,
            "0",
            "standard deviation of the cells' leak rates",
            "decades",
        ),
        rate(
            "shot-hz",
            FASTEST,
            "0",
            "noise events of a cell in the dark, ON and OFF together",
            "events/s",
        ),
        rate(
            "shot-at-white",
            1.0,
            "1",
            "the share of them that is left at light 255",
            "",
        ),
        rate(
            "hot-fraction",
            1.0,
            "0",
            "share of the cells that are hot",
            "",
        ),
        rate("hot-hz", FASTEST, "0", "events of a hot cell", "events/s"),
        rate(
            "jitter-us",
            f64::INFINITY,
            "0",
            "standard deviation of the events' times",
            "us",
        ),
        rate(
            "cutoff-hz",
            f64::INFINITY,
            "0",
            "bandwidth of the photoreceptor at light 255; 0 for no limit",
            "Hz",
        ),
        Key::with_default(
            "cutoff-rule",
            Kind::Choice(Between::WORDS),
            "\"ramp\"",
            "what the light does between two frames, as the photoreceptor sees it: a straight line, or a step to the later frame at once, as in v2e",
        ),
    ]);

    /// Its numbers with their keys, in the order of the file; `cutoff-rule` is a word.
    #[must_use]
    pub const fn numbers(&self) -> [(&'static str, f64); 8] {
        let Self {
            leak_hz,
            leak_spread,
            shot_hz,
            shot_at_white,
            hot_fraction,
            hot_hz,
            jitter_us,
            cutoff_hz,
            cutoff_rule: _,
        } = *self;
        [
            ("leak-hz", leak_hz),
            ("leak-spread", leak_spread),
            ("shot-hz", shot_hz),
            ("shot-at-white", shot_at_white),
            ("hot-fraction", hot_fraction),
            ("hot-hz", hot_hz),
            ("jitter-us", jitter_us),
            ("cutoff-hz", cutoff_hz),
        ]
    }

    /// The noise that a checked table states.
    ///
    /// # Errors
    /// Never, when it was checked.
    pub fn stated(node: Node<'_>) -> Read<Self> {
        let noise = Section::new(node, &Self::TABLE);
        Ok(Self {
            leak_hz: noise.number("leak-hz")?,
            leak_spread: noise.number("leak-spread")?,
            shot_hz: noise.number("shot-hz")?,
            shot_at_white: noise.number("shot-at-white")?,
            hot_fraction: noise.number("hot-fraction")?,
            hot_hz: noise.number("hot-hz")?,
            jitter_us: noise.number("jitter-us")?,
            cutoff_hz: noise.number("cutoff-hz")?,
            cutoff_rule: noise.word("cutoff-rule", Between::ALL)?.unwrap_or_default(),
        })
    }

    /// Whether there is shot noise, or a hot cell. A leak goes by way of the memory.
    #[must_use]
    pub fn fires(&self) -> bool {
        self.shot_hz > 0.0 || (self.hot_hz > 0.0 && self.hot_fraction > 0.0)
    }

    /// How far the leak lowers the memory of a cell in a second, in the unit of its threshold.
    pub(super) fn leak(&self, place: Place, threshold: f64) -> f64 {
        let spread = if self.leak_spread > 0.0 {
            elementary::pow(10f64, self.leak_spread * place.normal(Reason::LeakRate, 0))
        } else {
            1.0
        };
        self.leak_hz * spread * threshold
    }

    /// How far, in thresholds, a cell's memory has leaked before its first frame.
    pub(super) fn leaked(place: Place) -> f64 {
        place.uniform(Reason::LeakPhase, 0)
    }

    /// The share of shot noise that is left in this light, 0 to 1; linear up to light 255.
    #[must_use]
    pub fn shot_share(&self, light: f64) -> f64 {
        1.0 + (self.shot_at_white - 1.0) * (light / WHITE).clamp(0.0, 1.0)
    }

    /// Moves a train by the cell's jitter, reflected so that it stays within the interval.
    pub(super) fn jitter(&self, train: Train, place: Place, interval: u64, dt: f64) -> Train {
        let shift = self.jitter_us * 1e-6 / dt * place.normal(Reason::Jitter, interval);
        let room = 1.0 - (train.last() - train.first);
        let first = if room > 0.0 {
            let folded = (train.first + shift).rem_euclid(2.0 * room);
            folded.min(2.0 * room - folded)
        } else {
            0.0
        };
        Train { first, ..train }
    }

    /// The step of the low-pass over `dt` seconds, in which the light goes from the earlier of
    /// two frames to the later: the share, 0 to 1, by which the filter nears the earlier signal,
    /// and the share of the signal's change that it takes on. Exact for the first-order filter
    /// with v2e's bandwidth, `cutoff-hz (light + 20) / 275`, at the light's mean; where the light
    /// steps, at the later frame's.
    #[must_use]
    pub fn low_pass(&self, (earlier, later): (f64, f64), dt: f64) -> (f64, f64) {
        let light = match self.cutoff_rule {
            Between::Ramp => 0.5 * (earlier.max(0.0) + later.max(0.0)),
            Between::Step => later.max(0.0),
        };
        let bandwidth = self.cutoff_hz * (light + 20.0) / 275.0;
        let steps = std::f64::consts::TAU * bandwidth * dt;
        let nears = -elementary::exp_m1(-steps);
        match self.cutoff_rule {
            Between::Step => (nears, nears),
            Between::Ramp if steps > 0.0 => (nears, 1.0 - nears / steps),
            Between::Ramp => (0.0, 0.0),
        }
    }
}
