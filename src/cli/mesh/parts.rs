//! Parts of a sheet that are not equal, as silicon has them.

use crate::{
    cli::arguments::heading,
    mesh::{Laterals, MeshError, Mismatch, Network, Settled, Sheet},
    plane::{Plane, Size},
};

/// Parts that differ, as they are asked for.
#[derive(Debug, clap::Args)]
pub(super) struct Parts {
    /// Mismatch of the lateral resistors of one chip, such as 1%
    ///
    /// It is the standard deviation of the logarithm of the resistance.
    #[arg(long, value_name = "PERCENT", value_parser = spread, allow_hyphen_values = true, help_heading = heading::PARTS)]
    lateral_mismatch: Option<f64>,
    /// Mismatch of the transverse resistors, such as 10%
    #[arg(long, value_name = "PERCENT", value_parser = spread, allow_hyphen_values = true, help_heading = heading::PARTS)]
    transverse_mismatch: Option<f64>,
    /// Seed of the chip whose parts are drawn [default: 0]
    #[arg(long, help_heading = heading::PARTS)]
    seed: Option<u64>,
    /// Transistors in place of lateral resistors: saturating:V or opening:V
    ///
    /// At a voltage v the current of `saturating` is V tanh(v / V), that of `opening` V sinh(v /
    /// V). V is in the unit of the signal.
    #[arg(long, value_name = "LAW:V", value_parser = laterals, help_heading = heading::PARTS)]
    laterals: Option<Laterals>,
}

/// What one chip's parts make of a surround.
#[derive(Debug, serde::Serialize)]
pub(super) struct Chip {
    lateral_mismatch: f64,
    transverse_mismatch: f64,
    seed: u64,
    /// The law of the laterals, as it was asked for; none of resistors.
    laterals: Option<String>,
    /// Root mean square of its difference from the surround of equal resistors, in the signal's unit.
    pub differs_rms: f64,
    /// The largest difference.
    pub differs_most: f64,
    /// Bound on the error of a node's voltage.
    error: f64,
}

impl Parts {
    /// Whether all parts are equal, and laterals are resistors.
    pub(super) fn are_equal(&self) -> bool {
        self.laterals.is_none() && self.mismatch() == Mismatch::default()
    }

    /// Whether a chip is chosen of which no part is drawn.
    pub(super) fn has_idle_seed(&self) -> bool {
        self.seed.is_some() && self.mismatch() == Mismatch::default()
    }

    fn mismatch(&self) -> Mismatch {
        Mismatch {
            lateral: self.lateral_mismatch.unwrap_or_default(),
            transverse: self.transverse_mismatch.unwrap_or_default(),
            // Of no effect on a settled state.
            capacitance: 0.0,
        }
    }

    /// The surround of such a sheet, and how it differs from `equal`, that of equal parts.
    pub(super) fn settled(
        &self,
        sheet: Sheet,
        signal: &Plane<f64>,
        equal: &Plane<f64>,
    ) -> Result<(Plane<f64>, Chip), MeshError> {
        let (mismatch, seed) = (self.mismatch(), self.seed.unwrap_or_default());
        let network = Network::uniform(sheet, Size::of(signal))?
            .with_mismatch(mismatch, seed)
            .with_laterals(self.laterals.unwrap_or_default())?;
        let Settled {
            surround, error, ..
        } = network.settle(signal)?;
        let differences = surround.iter().zip(equal).map(|(own, equal)| own - equal);
        let (mut squares, mut most) = (0.0, 0.0_f64);
        for difference in differences {
            squares += difference * difference;
            most = most.max(difference.abs());
        }
        let chip = Chip {
            lateral_mismatch: mismatch.lateral,
            transverse_mismatch: mismatch.transverse,
            seed,
            laterals: self.laterals.and_then(written),
            differs_rms: (squares / surround.len() as f64).sqrt(),
            differs_most: most,
            error,
        };
        Ok((surround, chip))
    }
}

/// The standard deviation of the logarithm of a part.
fn spread(text: &str) -> Result<f64, String> {
    let number = text.trim().strip_suffix('%').map(str::trim);
    let number = number.and_then(|number| number.parse::<f64>().ok());
    let spread = number.filter(|number| (0.0..=100.0).contains(number));
    spread.map(|number| number / 100.0).ok_or_else(|| {
        format!("`{text}` is no mismatch: give 0% to 100%, with the percent sign, such as 1%")
    })
}

fn written(law: Laterals) -> Option<String> {
    match law {
        Laterals::Linear => None,
        Laterals::Saturating { scale } => Some(format!("saturating:{scale}")),
        Laterals::Opening { scale } => Some(format!("opening:{scale}")),
    }
}

fn laterals(text: &str) -> Result<Laterals, String> {
    let scale = |number: &str| number.parse::<f64>().ok().filter(|scale| *scale > 0.0);
    let of = text.split_once(':');
    match of.and_then(|(law, number)| Some((law, scale(number)?))) {
        Some(("saturating", scale)) => Ok(Laterals::Saturating { scale }),
        Some(("opening", scale)) => Ok(Laterals::Opening { scale }),
        _ => Err(
            "give saturating:V or opening:V, V above 0 in the signal's unit, such as saturating:30"
                .to_owned(),
        ),
    }
}
