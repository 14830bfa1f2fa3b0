//! The thresholds at which a sensor says so many events: a designer knows what a link carries,
//! and seldom which threshold that asks for.

use std::ops::ControlFlow;

use rayon::prelude::*;

use crate::{
    elementary,
    reference::{Description, Reference, Tally},
    rig,
    scene::{Scene, SceneError},
    sensor::SensorError,
};

/// What thresholds are to be multiplied by, and what comes of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rated {
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
    /// Beyond what any threshold gives.
    #[error(
        "{asked} events per pixel and second: this scene gives {least:.3} to {most:.3} at any threshold"
    )]
    #[diagnostic(help("give a rate between them"))]
    Unreachable {
        /// The rate that was asked for.
        asked: f64,
        /// With thresholds 4096 times as high.
        least: f64,
        /// With thresholds of a 4096th.
        most: f64,
    },
}

/// Thresholds are tried from a 4096th of the description's own to 4096 times them.
const OCTAVES: f64 = 12.0;

/// Times that the range is divided by four: to 3 % of a threshold.
const ROUNDS: u32 = 5;

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
    open: &dyn Fn() -> Result<Box<dyn Scene>, SceneError>,
) -> Result<Rated, RateError> {
    if !(rate > 0.0 && rate.is_finite()) {
        return Err(RateError::Rate(rate));
    }
    let count = |octaves: &[f64]| {
        let factors: Vec<f64> = octaves
            .iter()
            .map(|octave| elementary::pow(2.0, *octave))
            .collect();
        rates(description, &factors, seed, open)
    };
    let ends = count(&[-OCTAVES, OCTAVES])?;
    if !(ends[1] < rate && rate <= ends[0]) {
        return Err(RateError::Unreachable {
            asked: rate,
            least: ends[1],
            most: ends[0],
        });
    }
    // Events do not grow with the threshold, so that one of four parts has the rate.
    let mut within = [(-OCTAVES, ends[0]), (OCTAVES, ends[1])];
    for _ in 0..ROUNDS {
        let [(low, most), (high, least)] = within;
        let quarter = |k: f64| low + (high - low) * k / 4.0;
        let between = [1.0, 2.0, 3.0].map(quarter);
        let counted = count(&between)?;
        let mut points = vec![(low, most)];
        points.extend(between.into_iter().zip(counted));
        points.push((high, least));
        let last = points
            .iter()
            .rposition(|(_, own)| *own >= rate)
            .unwrap_or(0);
        let last = last.min(points.len() - 2);
        within = [points[last], points[last + 1]];
    }
    // A straight line of the logarithms between the two.
    let [(low, most), (high, least)] = within;
    let steep = elementary::ln(most / least.max(f64::MIN_POSITIVE));
    let part = if steep > 0.0 && steep.is_finite() {
        (elementary::ln(most / rate) / steep).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let octave = low + part * (high - low);
    let counted = count(&[octave])?;
    Ok(Rated {
        factor: elementary::pow(2.0, octave),
        rate: counted.first().copied().unwrap_or(0.0),
    })
}

/// Events per pixel and second with all thresholds times each factor.
fn rates(
    description: &Description,
    factors: &[f64],
    seed: u64,
    open: &dyn Fn() -> Result<Box<dyn Scene>, SceneError>,
) -> Result<Vec<f64>, RateError> {
    let mut scene = open()?;
    let size = scene.size();
    let made = factors.iter().map(|factor| {
        let description = times(description, *factor);
        let tally = Tally::new(description.channels.len());
        Ok((Reference::new(description, size, seed)?, tally))
    });
    let mut sensors = made.collect::<Result<Vec<_>, SensorError>>()?;
    let (mut first, mut last) = (None, 0.0);
    rig::play(&mut *scene, |frame| {
        first.get_or_insert(frame.seconds);
        last = frame.seconds;
        let watched = sensors.par_iter_mut();
        watched.try_for_each(|(sensor, tally)| sensor.watch_into(&frame, tally))?;
        Ok::<_, RateError>(ControlFlow::Continue(()))
    })?;
    let seconds = last - first.unwrap_or(last);
    if seconds <= 0.0 {
        return Err(RateError::Still);
    }
    let cells = size.pixels() as f64 * seconds;
    let rate = |(_, tally): &(_, Tally)| tally.total() as f64 / cells;
    Ok(sensors.iter().map(rate).collect())
}

/// A sensor with all its thresholds times a factor.
#[must_use]
pub fn times(description: &Description, factor: f64) -> Description {
    let mut description = description.clone();
    for channel in &mut description.channels {
        for threshold in &mut channel.thresholds {
            threshold.on *= factor;
            threshold.off *= factor;
            threshold.sigma *= factor;
        }
    }
    description
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{OpenOptions, open};

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
            let again = rates(&times(&sensor, found.factor), &[1.0], 3, &scene).unwrap();
            assert_eq!(again, [found.rate]);
        }
    }

    #[test]
    fn what_no_threshold_gives_is_said() {
        let sensor = Description::open("dvs").unwrap();
        let found = factor(&sensor, 1e9, 0, &scene);
        assert!(
            matches!(found, Err(RateError::Unreachable { .. })),
            "{found:?}"
        );
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
