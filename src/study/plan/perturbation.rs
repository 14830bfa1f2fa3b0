//! Perturbation: by how much a cell of the plainer model can be off.
//!
//! With `S` the drive, `M` the memory, `a` and `b` the ON and OFF steps since the first frame,
//! `d = S - M + fall` the distance and `θ` a threshold, a cell of the plainer model that has
//! taken the same steps has a distance within `E` of `d`, and counts `q' = d' / θ'` thresholds:
//!
//! ```text
//! E        = drive + relative (|M| + |d| + 2 fall) + steps (a θ_on + b (θ_on + θ_off))
//! |q' - q| ≤ (E / θ + threshold q) / (1 - threshold)
//! ```
//!
//! All parts are bounds that hold for every cell and frame, so those of several things that
//! are left out add up. `docs/fidelity.md` derives them.

use std::ops::Add;

use crate::{
    elementary,
    kernel::Kernel,
    number::{Format, Real as _},
    reference::{Channel, Description},
};

use super::{chance::MOST_SIGMAS, survey::Light};

/// What second-order terms of roundings can add to first-order bounds, as a factor: bfloat16,
/// the coarsest, has a unit roundoff of 2^-9.
const SECOND_ORDER: f64 = 1.05;

/// What a cosine transform and its way back can be off, as a part of the largest signal: ten
/// thousand times what double precision rounds. Measured errors are a hundred times smaller
/// (`docs/mesh.md`).
const TRANSFORM: f64 = 1e-12;

/// By how much each cell can be off.
#[derive(Clone, Debug, PartialEq)]
pub struct Perturbation {
    /// For each channel: the drive and the first drive together, in the unit of the drive.
    pub drive: Vec<f64>,
    /// Part of memory and distance.
    pub relative: f64,
    /// Part of the way that the memory has gone, up and down.
    pub steps: f64,
    /// Part of a threshold.
    pub threshold: f64,
    /// The relative difference that counts as a tie.
    pub tie: f64,
    /// Part of the time between two frames by which an event's time is rounded.
    pub time: f64,
    /// The largest memory or distance that is held.
    pub most: f64,
}

impl Perturbation {
    /// Nothing is off.
    #[must_use]
    pub fn none(channels: usize) -> Self {
        Self {
            drive: vec![0.0; channels],
            relative: 0.0,
            steps: 0.0,
            threshold: 0.0,
            tie: f64::TIE,
            time: 0.0,
            most: f64::MAX,
        }
    }

    /// What a number format does, compared with double precision, whose own roundings are in it.
    #[must_use]
    pub fn of_format(format: Format, description: &Description, light: &Light) -> Self {
        let channels = description.channels.len();
        if format == Format::F64 {
            return Self::none(channels);
        }
        rounded(format, description, light) + rounded(Format::F64, description, light)
    }

    /// Frames in between that the same light is computed for in double precision.
    #[must_use]
    pub fn of_upsampling(description: &Description, light: &Light) -> Self {
        let mut all = rounded(Format::F64, description, light);
        // The light in between is interpolated: a subtraction, a product, a sum, a quotient.
        for (drive, channel) in all.drive.iter_mut().zip(&description.channels) {
            *drive += 16.0 * f64::EPSILON * gain(channel) * light.signal;
        }
        all
    }

    /// A signal that may be off by so much, in the signal's unit, but for the first frame's.
    #[must_use]
    pub fn of_signal(description: &Description, off: f64) -> Self {
        let mut all = Self::none(description.channels.len());
        for (drive, channel) in all.drive.iter_mut().zip(&description.channels) {
            *drive = off * gain(channel);
        }
        all
    }

    /// Sheets that settle at once, in place of those that take their time.
    #[must_use]
    pub fn of_settling(description: &Description, light: &Light) -> Self {
        let mut all = Self::none(description.channels.len());
        for (drive, channel) in all.drive.iter_mut().zip(&description.channels) {
            let sheets = channel.surrounds.iter().flat_map(|s| &s.sheets);
            let slow = sheets.filter(|sheet| sheet.tau > 0.0);
            let gains: f64 = slow.map(|sheet| sheet.gain.abs()).sum();
            *drive = gains * (light.settling + 4.0 * TRANSFORM * light.signal);
        }
        all
    }

    /// Sheets whose nodes' noise is never more than `sigmas` standard deviations.
    #[must_use]
    pub fn of_sheet_noise(description: &Description, sigmas: f64) -> Self {
        let mut all = Self::none(description.channels.len());
        for (drive, channel) in all.drive.iter_mut().zip(&description.channels) {
            let sheets = channel.surrounds.iter().flat_map(|s| &s.sheets);
            let noise: f64 = sheets.map(|sheet| sheet.gain.abs() * sheet.noise).sum();
            *drive = 2.0 * sigmas * noise;
        }
        all
    }

    /// Thresholds that differ from the cells' own by at most this part of them.
    #[must_use]
    pub fn of_mismatch(channels: usize, part: f64) -> Self {
        Self {
            steps: part,
            threshold: part,
            ..Self::none(channels)
        }
    }

    /// The largest part of a threshold that a cell of `description` can be off at its first
    /// step: for putting several into order.
    #[must_use]
    pub fn size(&self, description: &Description) -> f64 {
        let channel = |(drive, channel): (&f64, &Channel)| {
            let thresholds = channel.thresholds.iter().flat_map(|t| [t.on, t.off]);
            drive / thresholds.fold(f64::INFINITY, f64::min)
        };
        let drives = self.drive.iter().zip(&description.channels).map(channel);
        drives.fold(0.0, f64::max) + self.threshold + self.steps + self.relative
    }
}

impl Add for Perturbation {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        for (drive, more) in self.drive.iter_mut().zip(&other.drive) {
            *drive += more;
        }
        Self {
            drive: self.drive,
            relative: self.relative + other.relative,
            steps: self.steps + other.steps,
            threshold: self.threshold + other.threshold,
            tie: self.tie.max(other.tie),
            time: self.time + other.time,
            most: self.most.min(other.most),
        }
    }
}

/// The largest drive that a signal of 1 can make.
pub(super) fn gain(channel: &Channel) -> f64 {
    if let Some(surrounds) = &channel.surrounds {
        let sheets = surrounds.sheets.iter().map(|sheet| sheet.gain.abs());
        return surrounds.centre.abs() + sheets.sum::<f64>();
    }
    let one = |kernel: &Kernel| kernel.weights().iter().map(|w| w.abs()).sum();
    channel.kernels.iter().map(one).fold(0.0, f64::max)
}

/// What the roundings of a format do, compared with real numbers.
fn rounded(format: Format, description: &Description, light: &Light) -> Perturbation {
    let narrow = match format {
        Format::F64 => false,
        Format::Fixed(q) => q.bits() <= 16,
        _ => true,
    };
    let (unit, tie) = if narrow {
        (f64::from(f32::EPSILON) / 2.0, f64::from(f32::TIE))
    } else {
        (f64::EPSILON / 2.0, f64::TIE)
    };
    let held = format.unit_roundoff();
    let step = format.half_step();
    let mut most = f64::INFINITY;
    let mut drives = Vec::new();
    for channel in &description.channels {
        let (error, size) = drive(format, channel, light);
        let top = channel.thresholds.iter();
        let top = top.map(|t| t.on.max(t.off) + MOST_SIGMAS * t.sigma);
        let top = top.fold(0.0, f64::max);
        // What has leaked before the first frame is taken off the memory.
        let leaked = if description.noise.leak_hz > 0.0 {
            (unit + held) * (size + top) + 4.0 * unit * top + step
        } else {
            0.0
        };
        drives.push(SECOND_ORDER * (2.0 * error + leaked + 3.0 * step));
        // A distance is the difference of two drives and a threshold.
        let high = format.limits().1;
        if 2.0 * (size + error + top) > high {
            most = 0.0;
        }
        most = most.min(high / 2.0);
    }
    if format.wraps() {
        // Within `most` it does not.
        most = most.min(format.limits().1 / 2.0);
    }
    Perturbation {
        drive: drives,
        relative: SECOND_ORDER * 2.0 * (held + unit),
        steps: SECOND_ORDER * (8.0 * unit + held),
        threshold: SECOND_ORDER * 4.0 * unit,
        tie,
        time: 16.0 * unit,
        most,
    }
}

/// How far the drive of a channel is off in a format, and how large it can be.
fn drive(format: Format, channel: &Channel, light: &Light) -> (f64, f64) {
    let off = format.hold_bound(light.signal);
    let (mut error, mut size) = if channel.surrounds.is_some() {
        let gain = gain(channel);
        let size = gain * (light.signal + off);
        let computed = gain * off + TRANSFORM * size;
        (computed + format.hold_bound(size + computed), size)
    } else {
        let one = |kernel: &Kernel| {
            let (mut terms, mut size, mut moved) = (0, 0.0, 0.0);
            for weight in kernel.weights().iter().filter(|w| **w != 0.0) {
                let own = format.hold_bound(*weight);
                terms += 1;
                size += (weight.abs() + own) * (light.signal + off);
                moved += weight.abs() * off + own * light.signal + own * off;
            }
            (moved + format.dot_bound(terms, size), size)
        };
        let kernels = channel.kernels.iter().map(one);
        kernels.fold((0.0, 0.0), |(e, s): (f64, f64), (error, size)| {
            (e.max(error), s.max(size))
        })
    };
    if channel.log_temporal {
        // ln(S + 1) of what is not below 0 changes by no more than S.
        error += format.hold_bound(elementary::ln(size + 1.0));
        size = size.max(elementary::ln(size + 1.0));
    }
    (error, size)
}
