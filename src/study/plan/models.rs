//! Models: the plainer ones that have to be followed, so that every choice has its bound.
//!
//! What perturbs is put into a ladder, the least first. For each number format there is one
//! model for each rung: it leaves out everything up to there, and so bounds whatever leaves out
//! less.

use crate::{
    number::Format,
    reference::{Description, Threshold},
};

use super::{
    chance,
    effect::{Effect, Present},
    perturbation::Perturbation,
    survey::Light,
};

/// A perturbation that can be as large a part of a threshold says nothing about events.
const HOPELESS: f64 = 0.25;

/// What the models are that have to be followed.
#[derive(Clone, Debug)]
pub(super) struct Models {
    /// What perturbs, the least first.
    pub(super) ladder: Vec<Effect>,
    /// A format, and how much of the ladder is left out with it.
    pub(super) which: Vec<(Format, usize)>,
    pub(super) off: Vec<Perturbation>,
}

impl Models {
    pub(super) fn of(
        present: Present,
        description: &Description,
        light: &Light,
        formats: &[Format],
        upsampled: bool,
    ) -> Self {
        let mut none = Self {
            ladder: Vec::new(),
            which: Vec::new(),
            off: Vec::new(),
        };
        if !present.followed || present.v2e {
            return none;
        }
        let cells = light.size.pixels() as f64 * description.channels.len() as f64;
        let sheets = description
            .channels
            .iter()
            .filter_map(|c| c.surrounds.as_ref());
        let sheets = sheets.map(|s| s.sheets.len()).sum::<usize>() as f64;
        let draws = cells * sheets * light.frames as f64;
        let mut steps = Vec::new();
        if present.low_pass {
            let off = Perturbation::of_signal(description, light.low_pass);
            steps.push((Effect::LowPass, off));
        }
        if present.settling {
            let off = Perturbation::of_settling(description, light);
            steps.push((Effect::Settling, off));
        }
        if present.sheet_noise {
            let sigmas = chance::sigmas(2.0 * draws);
            let off = Perturbation::of_sheet_noise(description, sigmas);
            steps.push((Effect::SheetNoise, off));
        }
        if present.mismatch {
            let part = |t: &Threshold| {
                // A cell's own threshold is at least a twentieth of the nominal one.
                let part = t.sigma * chance::MOST_SIGMAS / t.on.min(t.off);
                if part < 0.95 {
                    part / (1.0 - part)
                } else {
                    19.0
                }
            };
            let thresholds = description.channels.iter().flat_map(|c| &c.thresholds);
            let part = thresholds.map(part).fold(0.0, f64::max);
            let off = Perturbation::of_mismatch(description.channels.len(), part);
            steps.push((Effect::Mismatch, off));
        }
        steps.sort_by(|a, b| a.1.size(description).total_cmp(&b.1.size(description)));
        if upsampled {
            let off = Perturbation::of_upsampling(description, light);
            steps.insert(0, (Effect::Upsampling, off));
        }
        for format in std::iter::once(&Format::F64).chain(formats) {
            let mut off = Perturbation::of_format(*format, description, light);
            for left_out in 0..=steps.len() {
                if let Some((_, more)) = left_out.checked_sub(1).and_then(|n| steps.get(n)) {
                    off = off + more.clone();
                }
                let own = *format == Format::F64 && left_out == 0;
                let finer = upsampled && left_out == 0;
                let hopeless = off.size(description) >= HOPELESS || off.most <= 0.0;
                if !own && !finer && !hopeless && !none.which.contains(&(*format, left_out)) {
                    none.which.push((*format, left_out));
                    none.off.push(off.clone());
                }
            }
        }
        none.ladder = steps.into_iter().map(|(effect, _)| effect).collect();
        none
    }
}
