//! What is measured of a clip.

use crate::record::Row;

/// A measure of quality.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Metric {
    /// Peak signal over noise.
    Psnr,
    /// Structural similarity.
    Ssim,
    /// End-point error.
    Epe,
    /// The part of the pixels more than a pixel off.
    OffBy1,
    /// The part of the pixels more than three pixels off.
    OffBy3,
}

impl Metric {
    /// All, the headline of each goal first.
    pub const ALL: [Self; 5] = [
        Self::Psnr,
        Self::Ssim,
        Self::Epe,
        Self::OffBy1,
        Self::OffBy3,
    ];

    /// How it is called.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Psnr => "PSNR",
            Self::Ssim => "SSIM",
            Self::Epe => "EPE",
            Self::OffBy1 => "1PE",
            Self::OffBy3 => "3PE",
        }
    }

    /// Its unit; empty for a number without one.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Psnr => "dB",
            Self::Epe => "px/frame",
            Self::Ssim => "",
            Self::OffBy1 | Self::OffBy3 => "% over the clip",
        }
    }

    /// What it is, where its name alone does not say it: what stands above a plot.
    #[must_use]
    pub const fn title(self) -> &'static str {
        match self {
            Self::Psnr | Self::Ssim => self.name(),
            Self::Epe => "EPE, px a frame",
            Self::OffBy1 => "1PE, more than 1 px off over the clip",
            Self::OffBy3 => "3PE, more than 3 px off over the clip",
        }
    }

    /// Name and unit.
    #[must_use]
    pub fn label(self) -> String {
        format!("{} {}", self.name(), self.unit())
            .trim_end()
            .to_owned()
    }

    /// Digits behind the point that say something.
    #[must_use]
    pub const fn digits(self) -> usize {
        match self {
            Self::Psnr => 2,
            Self::Ssim => 4,
            Self::Epe => 3,
            Self::OffBy1 | Self::OffBy3 => 1,
        }
    }

    /// 1 where more is better, else -1.
    #[must_use]
    pub const fn sign(self) -> f64 {
        match self {
            Self::Psnr | Self::Ssim => 1.0,
            Self::Epe | Self::OffBy1 | Self::OffBy3 => -1.0,
        }
    }

    /// What was measured of a row, in the unit; `None` where it was not.
    #[must_use]
    pub fn of(self, row: &Row) -> Option<f64> {
        match self {
            Self::Psnr => row.psnr,
            Self::Ssim => row.ssim,
            Self::Epe => row.epe,
            Self::OffBy1 => row.off_by_1.map(|part| 100.0 * part),
            Self::OffBy3 => row.off_by_3.map(|part| 100.0 * part),
        }
    }
}
