//! The thresholds at which a sensor says so many events: a designer knows what a link carries,
//! and seldom which threshold that asks for.

use std::{fmt, ops::ControlFlow};

use rayon::prelude::*;

use crate::{
    elementary,
    kernel::Kernel,
    reference::{Alone, AnyReference, Channel, Description, Effect, Reference, Sinks, Tally},
    rig,
    scene::{Reopen, Scene, SceneError},
    sensor::SensorError,
    study::pilot::Choice,
};

/// What thresholds are to be multiplied by, and what comes of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThresholdFactor {
    /// All thresholds and their deviations times this.
    pub factor: f64,
    /// Events per pixel and second of all kinds together, as counted over the scene.
    pub rate: f64,
}

/// Why there are no such thresholds.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum RateError {
    /// The scene cannot be shown.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// The sensor cannot be made, or cannot go on.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Sensor(#[from] SensorError),
    /// Nothing that can be reached.
    #[error("{0} events per pixel and second")]
    #[diagnostic(help("give a finite number above 0"))]
    Rate(f64),
    /// One frame has no duration.
    #[error("the scene has one frame, or none: there is no rate")]
    #[diagnostic(help("give a scene of two frames at least"))]
    Still,
    /// Nothing changes for the sensor.
    #[error(
        "{0} events per pixel and second: this scene gives no event at any threshold tried, down to 1/4096 of the first"
    )]
    #[diagnostic(help(
        "give a scene that moves, and a kernel whose weights are not all 0; rule = \"authors\" needs frames further apart than the refractory period, and polarity = \"pixel\" a kernel that weighs the cell's own pixel"
    ))]
    Silent(f64),
    /// Beyond what any threshold gives.
    #[error(
        "{asked} events per pixel and second: this scene gives {} to {}, with thresholds from 4096 times as high to 1/4096",
        up(*least),
        down(*most)
    )]
    #[diagnostic(help("{bound}"))]
    Unreachable {
        /// The rate that was asked for.
        asked: f64,
        /// With thresholds 4096 times as high.
        least: f64,
        /// With thresholds of a 4096th.
        most: f64,
        /// What keeps it out of reach.
        bound: Bound,
    },
}

/// What keeps a rate out of reach; as text, what to do about it.
#[derive(Clone, Debug, PartialEq)]
pub enum Bound {
    /// Noise alone is more: so many events per pixel and second.
    Noise {
        /// Of all noise together.
        alone: f64,
        /// What makes them.
        effects: Vec<Effect>,
    },
    /// The cells are silent for so many microseconds after each event.
    DeadTime(f64),
    /// The memory takes what is there, so that a cell fires once a frame at most.
    Snap,
    /// The light itself.
    Light,
}

impl Bound {
    /// Of a rate that is too low, with the rates of the highest thresholds, with and without noise.
    fn below(description: &Description, asked: f64, [least, quiet]: [f64; 2]) -> Self {
        if quiet < asked {
            Self::Noise {
                alone: least - quiet,
                effects: alone(description).collect(),
            }
        } else {
            Self::Light
        }
    }

    /// Of a rate that is too high for so many kinds of cells at so many frames a second.
    fn above(description: &Description, asked: f64, (kinds, fps): (usize, f64)) -> Self {
        let each = asked / kinds as f64;
        let us = description.refractory.us;
        if each * us > 1e6 {
            Self::DeadTime(us)
        } else if each > fps && !description.memory.steps() {
            Self::Snap
        } else {
            Self::Light
        }
    }
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Noise { alone, effects } => {
                let keys: Vec<_> = effects.iter().map(|effect| effect.word()).collect();
                write!(
                    f,
                    "noise alone makes {}, whatever the thresholds: give a higher rate, or leave it out (--without {})",
                    up(*alone),
                    keys.join(",")
                )
            }
            Self::DeadTime(us) => write!(
                f,
                "a cell is silent for {us} us after each event (refractory): give a lower rate, or leave the dead time out (--without {})",
                Effect::DeadTime.word()
            ),
            Self::Snap => f.write_str(
                "with this memory a cell fires at most once per frame: give a lower rate, show more frames, or use memory = \"filtered-step\"",
            ),
            Self::Light => f.write_str(
                "give a rate between them; if they are far off, check the scale of the light (--scale)",
            ),
        }
    }
}

/// A rate with four decimals that is no less than it.
pub(super) fn up(rate: f64) -> String {
    format!("{:.4}", (rate * 1e4).ceil() / 1e4)
}

/// A rate with four decimals that is no more than it.
pub(super) fn down(rate: f64) -> String {
    format!("{:.4}", (rate * 1e4).floor() / 1e4)
}

/// Thresholds are tried from a 4096th of the description's own to 4096 times them.
const OCTAVES: f64 = 12.0;

/// Times that the range is divided by four: to 3 % of a threshold.
const ROUNDS: u32 = 5;

/// A threshold from which one for a rate is looked for, of the float sensor of a kernel: 64 where the
/// weights' magnitudes add up to about 1, and by steps of 4096 with them, so that light from 0 to 255
/// crosses the lowest that are tried.
#[must_use]
pub fn start(kernel: &Kernel) -> f64 {
    const ORDINARY: f64 = 64.0;
    let magnitude = kernel.magnitude();
    if magnitude <= 0.0 {
        return ORDINARY;
    }
    let steps = (elementary::log2(magnitude) / OCTAVES).round();
    ORDINARY * elementary::pow(2.0, OCTAVES * steps)
}

/// Finds by what to multiply the thresholds of a sensor so that it says `rate` events per pixel
/// and second, all kinds together, over the scene that `open` opens. The scene is shown seven
/// times, to three sensors at most.
///
/// # Errors
/// When no factor from 1/4096 to 4096 gives the rate; when scene or sensor cannot go on.
pub fn factor(
    description: &Description,
    rate: f64,
    seed: u64,
    open: &Reopen<'_>,
) -> Result<ThresholdFactor, RateError> {
    let found = search(description, (rate, Share::Together), seed, open)?;
    found.first().copied().ok_or(RateError::Still)
}

/// As [`factor`], for each kind of cell by itself: `rate` events per pixel and second of each, in
/// the same seven shows. Kinds that share a memory are not by themselves: of those it is a start
/// ([`balanced`](super::balance::balanced)).
///
/// # Errors
/// As [`factor`].
pub fn factors(
    description: &Description,
    rate: f64,
    seed: u64,
    open: &Reopen<'_>,
) -> Result<Vec<ThresholdFactor>, RateError> {
    search(description, (rate, Share::Each), seed, open)
}

/// Whose events are counted, and whose thresholds have one factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Share {
    /// All kinds as one.
    Together,
    /// Each kind for itself.
    Each,
}

impl Share {
    const fn groups(self, kinds: usize) -> usize {
        match self {
            Self::Together => 1,
            Self::Each => kinds,
        }
    }

    const fn of(self, kind: usize) -> usize {
        match self {
            Self::Together => 0,
            Self::Each => kind,
        }
    }
}

/// Where a group's thresholds are looked for: an octave, and the rate there.
type Point = (f64, f64);

fn search(
    description: &Description,
    (rate, share): (f64, Share),
    seed: u64,
    open: &Reopen<'_>,
) -> Result<Vec<ThresholdFactor>, RateError> {
    check(rate)?;
    let groups = share.groups(description.channels.len());
    // For each octave that is tried the rate of each group, which may try another one each.
    let count = |tries: &[Vec<f64>]| rates(description, (tries, share), seed, open);
    let [lowest, highest] = [-OCTAVES, OCTAVES].map(|octaves| vec![octaves; groups]);
    let ends = count(&[lowest, highest.clone()])?;
    let mut within: Vec<[Point; 2]> = Vec::new();
    for (group, (most, least)) in ends[0].iter().zip(&ends[1]).enumerate() {
        let (most, least) = (*most, *least);
        if most == 0.0 {
            return Err(RateError::Silent(rate));
        }
        if rate <= least || rate > most {
            let bound = if rate > most {
                let kinds = description.channels.len() / groups;
                Bound::above(description, rate, (kinds, pairs_per_second(open)?))
            } else {
                let tries = (&[highest][..], share);
                let quiet = rates(&without_noise(description), tries, seed, open)?;
                Bound::below(description, rate, [least, quiet[0][group]])
            };
            return Err(RateError::Unreachable {
                asked: rate,
                least,
                most,
                bound,
            });
        }
        within.push([(-OCTAVES, most), (OCTAVES, least)]);
    }
    // Events do not grow with the threshold, so that one of four parts has the rate.
    for _ in 0..ROUNDS {
        let at = |k: f64| -> Vec<f64> {
            let quarter = |[(low, _), (high, _)]: &[Point; 2]| low + (high - low) * k / 4.0;
            within.iter().map(quarter).collect()
        };
        let between = [1.0, 2.0, 3.0].map(at);
        let counted = count(&between)?;
        for (group, own) in within.iter_mut().enumerate() {
            let inner = between.iter().zip(&counted);
            let mut points = vec![own[0]];
            points.extend(inner.map(|(octaves, rates)| (octaves[group], rates[group])));
            points.push(own[1]);
            let last = points.iter().rposition(|(_, own)| *own >= rate);
            let last = last.unwrap_or(0).min(points.len() - 2);
            *own = [points[last], points[last + 1]];
        }
    }
    // A straight line of the logarithms between the two.
    let line = |[(low, most), (high, least)]: &[Point; 2]| {
        let steep = elementary::ln(most / least.max(f64::MIN_POSITIVE));
        let part = if steep > 0.0 && steep.is_finite() {
            (elementary::ln(most / rate) / steep).clamp(0.0, 1.0)
        } else {
            0.0
        };
        low + part * (high - low)
    };
    let octaves: Vec<f64> = within.iter().map(line).collect();
    let counted = count(std::slice::from_ref(&octaves))?;
    let counted = counted.first().map_or(&[][..], Vec::as_slice);
    // Where many cells change by the same amount the rate jumps, and an end may be nearer.
    let far = |(_, own): &Point| elementary::ln(own / rate).abs();
    let nearest = |((ends, octave), own): ((&[Point; 2], &f64), &f64)| {
        let line = (*octave, *own);
        let end = ends
            .iter()
            .copied()
            .min_by(|a, b| far(a).total_cmp(&far(b)));
        end.filter(|end| far(end) < far(&line)).unwrap_or(line)
    };
    let found = within.iter().zip(&octaves).zip(counted).map(nearest);
    let (octaves, rates): (Vec<f64>, Vec<f64>) = found.unzip();
    Ok(rated(&octaves, &rates))
}

/// Its effects that make events which no light causes, whatever the thresholds.
fn alone(description: &Description) -> impl Iterator<Item = Effect> {
    let effects = description.effects().into_iter();
    effects.filter(|effect| effect.influence().alone == Alone::AtAnyThreshold)
}

/// The same sensor without events that no light causes.
fn without_noise(description: &Description) -> Description {
    let choice = alone(description).fold(Choice::full(), Choice::and_without);
    choice.plainer(description)
}

/// How many frames a scene of two or more has after its first, a second.
fn pairs_per_second(open: &Reopen<'_>) -> Result<f64, RateError> {
    let (mut frames, mut first, mut last) = (0_u64, None, 0.0);
    rig::play(&mut *open()?, |frame| {
        frames += 1;
        first.get_or_insert(frame.seconds);
        last = frame.seconds;
        Ok::<_, RateError>(ControlFlow::Continue(()))
    })?;
    Ok(frames.saturating_sub(1) as f64 / (last - first.unwrap_or(last)))
}

pub(super) fn check(rate: f64) -> Result<(), RateError> {
    if rate > 0.0 && rate.is_finite() {
        Ok(())
    } else {
        Err(RateError::Rate(rate))
    }
}

/// Octaves that thresholds are moved by, and the rates there.
pub(super) fn rated(octaves: &[f64], rates: &[f64]) -> Vec<ThresholdFactor> {
    let rated = octaves
        .iter()
        .zip(rates)
        .map(|(octave, rate)| ThresholdFactor {
            factor: elementary::pow(2.0, *octave),
            rate: *rate,
        });
    rated.collect()
}

/// Events per pixel and second of each group, with its thresholds at each octave that is tried.
pub(super) fn rates(
    description: &Description,
    (tries, share): (&[Vec<f64>], Share),
    seed: u64,
    open: &Reopen<'_>,
) -> Result<Vec<Vec<f64>>, RateError> {
    let mut scene = open()?;
    let size = scene.size();
    let made = tries.iter().map(|octaves| {
        let mut description = description.clone();
        for (kind, channel) in description.channels.iter_mut().enumerate() {
            times_kind(channel, elementary::pow(2.0, octaves[share.of(kind)]));
        }
        let tally = Tally::new(description.channels.len());
        Ok((Reference::new(description, size, seed)?, tally))
    });
    let mut sensors = made.collect::<Result<Vec<_>, SensorError>>()?;
    let (mut first, mut last) = (None, 0.0);
    rig::play(&mut *scene, |frame| {
        first.get_or_insert(frame.seconds);
        last = frame.seconds;
        let watched = sensors.par_iter_mut();
        watched.try_for_each(|(sensor, tally)| {
            let sinks = Sinks {
                tally: Some(tally),
                ..Sinks::default()
            };
            sensor.watch_into_sinks(&frame, sinks)
        })?;
        Ok::<_, RateError>(ControlFlow::Continue(()))
    })?;
    let seconds = last - first.unwrap_or(last);
    if seconds <= 0.0 {
        return Err(RateError::Still);
    }
    let cells = size.pixels() as f64 * seconds;
    let of_groups = |(_, tally): &(_, Tally)| {
        let mut events = vec![0; share.groups(tally.kinds().len())];
        for (kind, (on, off)) in tally.kinds().iter().enumerate() {
            events[share.of(kind)] += on + off;
        }
        events.iter().map(|events| *events as f64 / cells).collect()
    };
    Ok(sensors.iter().map(of_groups).collect())
}

/// A threshold in four digits, which is finer than any rate asks for; never a higher one.
///
/// Light comes in whole steps, so what changes does too, and many cells change by the same round
/// number. None of them fires where the threshold is rounded up to it.
#[must_use]
pub fn four_digits(threshold: f64) -> f64 {
    let digits = (3 - elementary::log10(threshold).floor() as i32).clamp(0, 300);
    let rounded = |threshold: f64| {
        let text = format!("{threshold:.*}", digits as usize);
        text.parse().unwrap_or(threshold)
    };
    let near = rounded(threshold);
    if near <= threshold {
        near
    } else {
        rounded(near - elementary::pow(10.0, f64::from(-digits)))
    }
}

/// A sensor with all its thresholds times a factor.
#[must_use]
pub fn times(description: &Description, factor: f64) -> Description {
    let mut description = description.clone();
    for channel in &mut description.channels {
        times_kind(channel, factor);
    }
    description
}

fn times_kind(channel: &mut Channel, factor: f64) {
    for threshold in &mut channel.thresholds {
        threshold.on *= factor;
        threshold.off *= factor;
        threshold.sigma *= factor;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        reference::MemoryRule,
        scene::{OpenOptions, open},
    };

    #[test]
    fn four_digits_are_never_more() {
        for (threshold, digits) in [
            (39.999_87, 39.99),
            (40.0, 40.0),
            (40.004, 40.0),
            (3.936, 3.936),
            (3.935_999, 3.935),
            (0.012_349, 0.01234),
            (12_345.6, 12_345.0),
            (0.9999, 0.9999),
            (0.999_99, 0.9999),
            (3.936_71e-20, 3.936e-20),
        ] {
            assert_eq!(four_digits(threshold), digits, "{threshold}");
        }
    }

    fn scene() -> Result<Box<dyn Scene>, SceneError> {
        let pattern = "pattern:noise?width=48&height=40&frames=20&fps=100&speed=60";
        open(pattern, &OpenOptions::default())
    }

    #[test]
    fn the_rate_is_the_one_asked_for() {
        let sensor = Description::open("rgc-4").unwrap();
        for asked in [0.5, 5.0, 40.0] {
            let found = factor(&sensor, asked, 3, &scene).unwrap();
            assert!(
                (found.rate / asked - 1.0).abs() < 0.03,
                "{asked}: {found:?}"
            );
            let octaves = [vec![0.0]];
            let tried = (&octaves[..], Share::Together);
            let again = rates(&times(&sensor, found.factor), tried, 3, &scene).unwrap();
            assert_eq!(again, [[found.rate]]);
        }
    }

    /// Whatever the scale of its weights, and the same to the bit where that is ordinary.
    #[test]
    fn the_search_starts_where_a_kernel_can_fire() {
        let laplacian = [[0.0, 1.0, 0.0], [1.0, -4.0, 1.0], [0.0, 1.0, 0.0]];
        let scaled = |scale: f64| {
            let rows = laplacian.map(|row| row.map(|weight| weight * scale).to_vec());
            Kernel::from_rows(&rows).unwrap()
        };
        for scale in [1e-20, 1e-6, 1.0, 1e6, 1e20] {
            let start = start(&scaled(scale));
            let most = 255.0 * scaled(scale).magnitude();
            assert!((start / 4096.0..start * 4096.0).contains(&most), "{scale}");
            assert!(start / 4096.0 < most / 255.0, "{scale}: a step of light");
        }
        for scale in [0.01, 1.0, 7.0] {
            assert_eq!(start(&scaled(scale)), 64.0);
        }
        let nothing = Kernel::from_rows(&[vec![0.0]]).unwrap();
        assert_eq!(start(&nothing), 64.0);
    }

    #[test]
    fn each_kind_has_its_own_factor() {
        let sensor = Description::open("rgc-4").unwrap();
        let found = factors(&sensor, 4.0, 3, &scene).unwrap();
        assert_eq!(found.len(), 4);
        for (kind, found) in found.iter().enumerate() {
            assert!((found.rate / 4.0 - 1.0).abs() < 0.03, "{kind}: {found:?}");
            // Alone it says the same.
            let mut alone = sensor.clone();
            alone.channels = vec![alone.channels[kind].clone()];
            let one = factor(&alone, 4.0, 3, &scene).unwrap();
            assert_eq!(one.factor, found.factor);
        }
        assert_ne!(found[0].factor, found[2].factor);
    }

    /// Noise, a dead time and a memory that snaps bound the rate, and the light does.
    #[test]
    fn what_bounds_the_rate_is_said() {
        let bound = |name: &str, rate| {
            let sensor = Description::open(name).unwrap();
            match factor(&sensor, rate, 0, &scene) {
                Err(RateError::Unreachable { bound, .. }) => bound,
                other => panic!("{name}, {rate}: {other:?}"),
            }
        };
        // 5 events/s of shot noise in the dark, a quarter of it at white; 0.1 of leak.
        let noise = bound("dvs-noisy", 0.5);
        let Bound::Noise { alone, effects } = &noise else {
            panic!("{noise:?}");
        };
        assert!((1.3..5.2).contains(alone), "{alone}");
        assert_eq!(effects[..], [Effect::NoiseEvents, Effect::Leak]);
        assert!(noise.to_string().contains("--without noise-events,leak"));
        assert_eq!(bound("dvs", 1e9), Bound::DeadTime(500.0));
        let mut sensor = Description::open("dvs").unwrap();
        let mut above = |memory, us, rate| {
            (sensor.memory, sensor.refractory.us) = (memory, us);
            match factor(&sensor, rate, 0, &scene) {
                Err(RateError::Unreachable { bound, .. }) => bound,
                other => panic!("{rate}: {other:?}"),
            }
        };
        // 100 frames/s.
        assert_eq!(above(MemoryRule::FilteredSnap, 0.0, 101.0), Bound::Snap);
        assert_eq!(
            above(MemoryRule::FilteredStep, 1e4, 101.0),
            Bound::DeadTime(1e4)
        );
        assert_eq!(above(MemoryRule::FilteredStep, 0.0, 1e9), Bound::Light);
    }

    #[test]
    fn what_no_threshold_gives_is_said() {
        let sensor = Description::open("dvs").unwrap();
        assert!(matches!(
            factor(&sensor, -1.0, 0, &scene),
            Err(RateError::Rate(_))
        ));
        let still = || {
            open(
                "pattern:noise?width=8&height=8&frames=1",
                &OpenOptions::default(),
            )
        };
        assert!(matches!(
            factor(&sensor, 1.0, 0, &still),
            Err(RateError::Still)
        ));
    }
}
