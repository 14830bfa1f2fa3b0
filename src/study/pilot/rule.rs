//! Rules that need no measurement: they come first and are free.

use super::look::Look;
use crate::{
    kernel::Kernel,
    number::Format,
    photoreceptor::Curve,
    reference::{Channel, Description, InBetween, Refractory, RefractoryRule, SheetRule},
};

/// The most steps of a memory that are counted.
const MOST_STEPS: f64 = (1 << 30) as f64;

/// What a signal is of light: the white of a linear response; none where it is not straight.
fn white(description: &Description) -> Option<f64> {
    if description.response.round_f32 {
        return None;
    }
    match description.response.curve {
        Curve::Identity => Some(1.0),
        Curve::Linear { white } => Some(white),
        Curve::Log { .. } | Curve::LinLog { .. } => None,
    }
}

/// Why inserted frames say nothing new: between two frames of the scene the drive of a cell is a
/// straight line with them and without, and a memory that steps crosses the same levels of it at
/// the same times. None where that is not so.
///
/// A dead time is decided crossing by crossing, and rounding may tip it: with one, inserted frames
/// are measured.
#[must_use]
pub fn needs_no_inserted_frames(description: &Description) -> Option<&'static str> {
    let is_straight = |channel: &Channel| {
        let sheets = channel.surrounds.iter();
        let settled = |rule, tau| rule != SheetRule::V2e && tau <= 0.0;
        let mut sheets = sheets.flat_map(|s| s.sheets.iter().map(|sheet| (s.rule, sheet)));
        !channel.log_temporal && sheets.all(|(rule, s)| settled(rule, s.tau))
    };
    let is_other = description.is_influenced(|it| it.between != InBetween::Same);
    (white(description).is_some()
        && crosses_levels(description)
        && !is_other
        && description.channels.iter().all(is_straight))
        .then_some("between two frames the drive is a straight line, and the memory steps: frames in between say nothing new, but for rounding")
}

/// Whether cells fire where the drive crosses levels on its line between two frames.
fn crosses_levels(description: &Description) -> bool {
    let Refractory { us: _, rule } = description.refractory;
    description.memory.crosses_levels() && rule == RefractoryRule::DeadTime
}

/// Whether no two crossings of a cell are as close as the dead time: a memory that steps crosses
/// levels that are a threshold apart, and the drive goes no faster than the light.
#[must_use]
pub fn has_no_close_crossings(description: &Description, look: &Look) -> bool {
    let is_other =
        description.fires_alone() || description.is_influenced(|it| it.between == InBetween::Bent);
    let follows = crosses_levels(description) && !is_other;
    let Some(white) = white(description).filter(|_| follows) else {
        return false;
    };
    let dead = description.refractory.us * 1e-6;
    description.channels.iter().all(|channel| {
        let thresholds = channel.thresholds.iter().map(|threshold| {
            let least = threshold.on.min(threshold.off);
            // A cell's own is at least a twentieth of the nominal one.
            if threshold.sigma > 0.0 {
                least / 20.0
            } else {
                least
            }
        });
        let least = thresholds.fold(f64::INFINITY, f64::min);
        let speed = look.steepest / white * gain(&channel.kernels);
        channel.surrounds.is_none()
            && !channel.log_temporal
            // With room for the rounding of times to microseconds.
            && (speed <= 0.0 || least / speed > dead * (1.0 + 1e-6) + 2e-6)
    })
}

/// Whether what cells hold may reach an end of a format's range in this light: a scene that never
/// does cannot saturate it. The memory lies between drives, and a distance is at most two of them;
/// but where a memory steps by thresholds of two sizes, steps are counted, and what they come to on
/// the way may be anything up to the most that are counted.
#[must_use]
pub fn may_saturate(format: Format, description: &Description, look: &Look) -> bool {
    let (least, most) = format.limits();
    let room = most.min(-least);
    let (low, high) = look.range;
    let signal = |light: f64| {
        description
            .response
            .apply(light)
            .map_or(f64::INFINITY, f64::abs)
    };
    // Responses do not turn, so the largest signal is at an end.
    let signal = signal(low).max(signal(high));
    let whole = |channel: &Channel| {
        let thresholds = channel
            .thresholds
            .iter()
            .map(|t| t.on.max(t.off) + 9.0 * t.sigma);
        let threshold = thresholds.fold(0.0, f64::max);
        let whole = 2.0 * (signal * gain(&channel.kernels) * 1.01 + threshold);
        let equal = channel
            .thresholds
            .iter()
            .all(|t| t.on == t.off && t.sigma <= 0.0);
        if description.memory.steps() && !equal {
            whole + threshold * MOST_STEPS
        } else {
            whole
        }
    };
    let mut channels = description.channels.iter();
    description.is_influenced(|it| it.moves_memory)
        || channels.any(|channel| {
            channel.log_temporal || channel.surrounds.is_some() || whole(channel) >= room
        })
}

/// The largest drive that a signal of 1 can make.
fn gain(kernels: &[Kernel]) -> f64 {
    kernels.iter().map(Kernel::magnitude).fold(0.0, f64::max)
}
