//! Whether frames are evenly spaced in time.

use std::path::Path;

use crate::scene::SceneError;

/// Containers that count in milliseconds (Matroska) round times to them, and whoever copies a clip
/// from one to another keeps what was rounded.
const ROUNDED: f64 = 1e-3;

/// The part of a step from frame to frame that rounding may take.
const PART: f64 = 0.125;

/// Checks the times of frames, in seconds, which rise from 0 and are rounded to `unit`: even, or
/// even but for rounding to milliseconds, of which the rate is then given back.
///
/// # Errors
/// [`SceneError::Uneven`], of the frame whose distance from the one before is furthest from the
/// usual one.
pub(super) fn check(path: &Path, times: &[f64], unit: f64) -> Result<Option<f64>, SceneError> {
    let (Some(last), steps) = (times.last(), times.len().saturating_sub(1)) else {
        return Ok(None);
    };
    if steps == 0 || *last <= 0.0 {
        return Ok(None);
    }
    let step = last / steps as f64;
    // Each time may be off by half a unit, and so may the ends.
    if off(times, step) <= unit + 1e-9 {
        return Ok(None);
    }
    if unit < ROUNDED && ROUNDED <= PART * step && off(times, step) <= ROUNDED + unit {
        return Ok(Some(usual_rate(times, step, unit)));
    }
    let gaps: Vec<f64> = times.windows(2).map(|two| two[1] - two[0]).collect();
    let mut sorted = gaps.clone();
    sorted.sort_by(f64::total_cmp);
    let usual = Some(sorted[sorted.len() / 2]).filter(|usual| *usual > 0.0);
    let usual = usual.unwrap_or(step);
    let far = |gap: f64| (gap - usual).abs();
    let worst =
        (0..gaps.len()).max_by(|a, b| far(gaps[*a]).total_cmp(&far(gaps[*b])).then(b.cmp(a)));
    let worst = worst.unwrap_or(0);
    Err(SceneError::Uneven {
        path: path.into(),
        frame: worst as u64 + 1,
        seconds: times[worst + 1],
        gap: gaps[worst],
        usual,
    })
}

/// How far any time is from its place on a grid of such steps.
fn off(times: &[f64], step: f64) -> f64 {
    let each = times.iter().enumerate();
    each.map(|(n, time)| (time - n as f64 * step).abs())
        .fold(0.0, f64::max)
}

/// The rate that was rounded: a whole number, or that of NTSC (1000/1001 of one), where the times
/// allow it.
fn usual_rate(times: &[f64], step: f64, unit: f64) -> f64 {
    let found = step.recip();
    let usual = [found.round(), (found * 1.001).round() / 1.001];
    let near = |fps: f64| off(times, fps.recip()) <= ROUNDED + unit;
    let fits = usual.into_iter().filter(|fps| *fps >= 1.0 && near(*fps));
    fits.min_by(|a, b| off(times, a.recip()).total_cmp(&off(times, b.recip())))
        .unwrap_or(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times of 60 frames, rounded to milliseconds.
    fn milliseconds(fps: f64) -> Vec<f64> {
        (0..60)
            .map(|n| (f64::from(n) * 1e3 / fps).round() / 1e3)
            .collect()
    }

    fn checked(times: &[f64]) -> Result<Option<f64>, (u64, f64, f64)> {
        check(Path::new("a"), times, 1e-5).map_err(|error| match error {
            SceneError::Uneven {
                frame, gap, usual, ..
            } => (frame, gap, usual),
            error => panic!("{error}"),
        })
    }

    #[test]
    fn rounding_to_milliseconds_is_seen_through() {
        for fps in [24.0, 30.0, 60.0, 30.0 / 1.001, 24.0 / 1.001, 120.0] {
            assert_eq!(checked(&milliseconds(fps)), Ok(Some(fps)), "{fps}");
        }
        // To the unit of the times there is nothing to see through.
        assert_eq!(checked(&milliseconds(25.0)), Ok(None));
        // An eighth of a frame is more than rounding may take.
        assert!(checked(&milliseconds(240.0)).is_err());
    }

    #[test]
    fn the_frame_behind_a_gap_is_named() {
        let times: Vec<f64> = (0..40)
            .filter(|n| !(5..10).contains(n))
            .map(|n| f64::from(n) / 10.0)
            .collect();
        let (frame, gap, usual) = checked(&times).unwrap_err();
        assert_eq!(frame, 5);
        assert!((gap - 0.6).abs() < 1e-9 && (usual - 0.1).abs() < 1e-9);
        assert_eq!(checked(&[0.0]), Ok(None));
        assert_eq!(checked(&[0.0, 0.0, 0.0]), Ok(None));
    }
}
