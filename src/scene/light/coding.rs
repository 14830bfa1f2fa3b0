//! What the samples of a clip mean: which of them are black and white, how light was coded, and
//! who says so.
//!
//! Range comes first, then the scale of an array, then the transfer; what is left is light from
//! 0 to 255, which the photoreceptor takes.

use std::{fmt, path::PathBuf, str::FromStr};

use crate::{
    config::{UnknownWord, listed},
    elementary,
    scene::SceneError,
};

listed! {
/// Which samples are black and white.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Range = "range" {
    /// 16 is black and 235 white, in 8 bits: most video. Foot- and headroom lie outside.
    Limited = "limited",
    /// All values are used: pictures, and video that says so.
    Full = "full",
}
}

listed! {
/// How light was coded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Transfer = "transfer" {
    /// Not known, not undone: the coded value is taken for light, as v2e and ESIM do.
    #[default]
    AsCoded = "as-coded",
    /// The samples are light. The numbers are those of [`AsCoded`](Self::AsCoded).
    Linear = "linear",
    /// IEC 61966-2-1, which most pictures are coded in.
    Srgb = "srgb",
    /// What cameras do by ITU-R BT.709; BT.601 and BT.2020 have the same curve.
    Bt709 = "bt709",
    /// A power of 2.2: analogue video of 525 lines, and PNGs of gamma 0.45455.
    Gamma22 = "gamma22",
    /// A power of 2.8: analogue video of 625 lines.
    Gamma28 = "gamma28",
    /// SMPTE ST 240, early video of high definition.
    Smpte240m = "smpte240m",
}
}

/// What a word asks for; nothing where it leaves that to the file: `auto`.
///
/// # Errors
/// When there is no such word.
pub fn word_or_auto<T: FromStr<Err = UnknownWord>>(word: &str) -> Result<Option<T>, UnknownWord> {
    if word == "auto" {
        return Ok(None);
    }
    word.parse().map(Some).map_err(|unknown: UnknownWord| {
        let words = unknown.help.trim_start_matches("give ");
        UnknownWord {
            help: format!("give auto, {words}"),
            ..unknown
        }
    })
}

impl Transfer {
    /// The light, 0 to 255, that was coded as `value`, 0 to 255. 0 and 255 stay what they are.
    #[must_use]
    pub fn light(self, value: f64) -> f64 {
        let v = value / 255.0;
        match self {
            Self::AsCoded | Self::Linear => value,
            Self::Srgb if v <= 0.04045 => value / 12.92,
            Self::Srgb => 255.0 * elementary::pow((v + 0.055) / 1.055, 2.4),
            Self::Bt709 if v < 0.081 => value / 4.5,
            Self::Bt709 => 255.0 * elementary::pow((v + 0.099) / 1.099, 1.0 / 0.45),
            Self::Gamma22 => 255.0 * elementary::pow(v, 2.2),
            Self::Gamma28 => 255.0 * elementary::pow(v, 2.8),
            Self::Smpte240m if v < 0.0912 => value / 4.0,
            Self::Smpte240m => 255.0 * elementary::pow((v + 0.1115) / 1.1115, 1.0 / 0.45),
        }
    }

    /// The value, 0 to 255, that codes `light`, 0 to 255: the inverse of
    /// [`light`](Self::light), but for rounding.
    #[must_use]
    pub fn coded(self, light: f64) -> f64 {
        let l = light / 255.0;
        match self {
            Self::AsCoded | Self::Linear => light,
            Self::Srgb if l <= 0.003_130_8 => light * 12.92,
            Self::Srgb => 255.0 * (1.055 * elementary::pow(l, 1.0 / 2.4) - 0.055),
            Self::Bt709 if l < 0.018 => light * 4.5,
            Self::Bt709 => 255.0 * (1.099 * elementary::pow(l, 0.45) - 0.099),
            Self::Gamma22 => 255.0 * elementary::pow(l, 1.0 / 2.2),
            Self::Gamma28 => 255.0 * elementary::pow(l, 1.0 / 2.8),
            Self::Smpte240m if l < 0.0228 => light * 4.0,
            Self::Smpte240m => 255.0 * (1.1115 * elementary::pow(l, 0.45) - 0.1115),
        }
    }
}

/// What the caller says about the samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coding {
    /// Black and white; `None`: what the file says, else what its kind usually has.
    pub range: Option<Range>,
    /// How light was coded; `None`: what the file says, else as coded.
    pub transfer: Option<Transfer>,
    /// What the numbers of an array are multiplied by to be light from 0 to 255.
    pub scale: Option<f64>,
}

impl Default for Coding {
    /// The file's range, no transfer undone, no scale.
    fn default() -> Self {
        Self {
            range: None,
            transfer: Some(Transfer::AsCoded),
            scale: None,
        }
    }
}

impl Coding {
    /// Refuses what a pattern has no samples for.
    pub(in crate::scene) fn check_drawn(self, spec: &str) -> Result<(), SceneError> {
        let what = match self {
            Self {
                scale: Some(scale), ..
            } => format!("--scale {scale}"),
            Self {
                range: Some(Range::Limited),
                ..
            } => "--range limited".to_owned(),
            Self {
                transfer: None | Some(Transfer::AsCoded | Transfer::Linear),
                ..
            } => return Ok(()),
            Self {
                transfer: Some(transfer),
                ..
            } => format!("--transfer {}", transfer.word()),
        };
        Err(SceneError::Coding {
            path: PathBuf::from(spec),
            what: format!("{what}: a pattern is drawn as light"),
            help: "patterns have the light that their parameters say; leave it out",
        })
    }
}

/// Who says so.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Origin {
    /// The caller.
    Asked,
    /// The file.
    File,
    /// Nobody: what its kind of file usually has.
    Assumed,
}

/// What the samples come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Samples {
    /// The luma of video.
    Video,
    /// Pictures, and animations made of them.
    Pictures,
    /// Whole numbers of an array.
    Integers,
    /// Real numbers of an array.
    Floats,
    /// A picture that a pattern moves.
    Moved,
    /// A pattern, or what a program made: light from the start.
    Drawn,
}

impl Samples {
    /// Whether a pattern made the frames, so that nothing was cut or filmed.
    #[must_use]
    pub const fn are_of_a_pattern(self) -> bool {
        matches!(self, Self::Moved | Self::Drawn)
    }
}

/// How samples became light, and who said so.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Light {
    /// What there was.
    pub samples: Samples,
    /// Black and white; none for numbers that have no range.
    pub range: Option<Range>,
    /// Who said so.
    pub range_from: Origin,
    /// The transfer that was undone.
    pub transfer: Transfer,
    /// Who said so.
    pub transfer_from: Origin,
    /// The transfer that the file states, whether it was undone or not.
    pub stated_transfer: Option<Transfer>,
    /// A transfer that the file states and that nothing here undoes: what it is called.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_undone: Option<&'static str>,
    /// What the numbers of an array were multiplied by.
    pub scale: f64,
}

impl Light {
    /// Light that is drawn, and was never coded.
    pub const DRAWN: Self = Self {
        samples: Samples::Drawn,
        range: None,
        range_from: Origin::Assumed,
        transfer: Transfer::Linear,
        transfer_from: Origin::Assumed,
        stated_transfer: None,
        not_undone: None,
        scale: 1.0,
    };

    /// Whether the numbers have no scale of their own, so that only their maker knows what is
    /// white.
    #[must_use]
    pub const fn has_free_scale(&self) -> bool {
        matches!(self.samples, Samples::Floats | Samples::Integers)
    }

    /// Whether it is known to rise evenly with the light of the scene: it was drawn, its transfer
    /// was undone, or whoever made or gave it says that there is none.
    #[must_use]
    pub fn is_linear(&self) -> bool {
        self.transfer != Transfer::AsCoded || self.stated_transfer == Some(Transfer::Linear)
    }
}

impl fmt::Display for Light {
    /// In a line: `limited range (said by the file) expanded to 0..255 …, transfer as coded`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.samples == Samples::Drawn {
            return f.write_str("drawn as light, nothing to undo");
        }
        let who = match (self.range_from, self.samples, self.range) {
            (Origin::Asked, ..) => "as asked",
            (Origin::File, ..) => "said by the file",
            (Origin::Assumed, Samples::Video, Some(Range::Limited)) => {
                "assumed, as FFmpeg does; --range full says otherwise"
            }
            (Origin::Assumed, Samples::Video, _) => "assumed; --range limited says otherwise",
            (Origin::Assumed, ..) => "as pictures have it",
        };
        match (self.range, self.samples) {
            (Some(Range::Limited), _) => write!(
                f,
                "limited range ({who}) expanded to 0..255, foot- and headroom clipped"
            )?,
            (Some(Range::Full), Samples::Integers) => {
                f.write_str("full range (as asked) of 16 bits: 65535 is 255")?;
            }
            (_, Samples::Integers | Samples::Floats) => f.write_str("numbers as given")?,
            _ => write!(f, "full range ({who})")?,
        }
        if self.scale != 1.0 {
            write!(f, " times {}", self.scale)?;
        }
        let name = match self.transfer {
            Transfer::AsCoded => "as coded",
            Transfer::Linear => "linear",
            Transfer::Srgb => "srgb undone",
            Transfer::Bt709 => "bt709 undone",
            Transfer::Gamma22 => "gamma22 undone",
            Transfer::Gamma28 => "gamma28 undone",
            Transfer::Smpte240m => "smpte240m undone",
        };
        write!(f, ", transfer {name}")?;
        if let Some(stated) = self.not_undone {
            return write!(f, " (the file says {stated}, which is not undone)");
        }
        match (self.stated_transfer, self.transfer_from) {
            (Some(stated), _) if stated != self.transfer => write!(
                f,
                " (the file says {}; --transfer auto undoes it)",
                stated.word()
            ),
            (Some(_), Origin::File) => f.write_str(" (said by the file)"),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn what_is_left_to_the_file_is_none() {
        assert_eq!(word_or_auto::<Range>("auto"), Ok(None));
        assert_eq!(word_or_auto("full"), Ok(Some(Range::Full)));
        let unknown = word_or_auto::<Range>("narrow").unwrap_err();
        assert_eq!(unknown.help, "give auto, limited or full");
    }

    #[test]
    fn black_and_white_stay() {
        for &transfer in Transfer::ALL {
            for end in [0.0, 255.0] {
                assert_eq!(transfer.light(end), end, "{transfer:?}");
                assert!((transfer.coded(end) - end).abs() < 1e-12, "{transfer:?}");
            }
        }
    }

    /// Values of the standards' own formulas, by hand.
    #[test]
    fn known_values() {
        // 188 codes half of white within a quarter of a step, in sRGB.
        assert!((Transfer::Srgb.light(188.0) / 255.0 - 0.5029).abs() < 1e-4);
        assert!((Transfer::Srgb.light(10.0) - 10.0 / 12.92).abs() < 1e-15);
        // BT.709: 0.5 codes 0.2597 (the power of its upper piece).
        assert!((Transfer::Bt709.light(127.5) / 255.0 - 0.259_589).abs() < 1e-5);
        assert!((Transfer::Bt709.light(9.0) - 2.0).abs() < 1e-15);
        // Half of the code: 0.5 to the power of 2.2 and of 2.8.
        assert!((Transfer::Gamma22.light(127.5) / 255.0 - 0.217_638).abs() < 1e-6);
        assert!((Transfer::Gamma28.light(127.5) / 255.0 - 0.143_587).abs() < 1e-6);
        // SMPTE 240M: 0.5 codes ((0.5 + 0.1115) / 1.1115)^(1 / 0.45).
        assert!((Transfer::Smpte240m.light(127.5) / 255.0 - 0.265_036).abs() < 1e-6);
        assert!((Transfer::Smpte240m.light(8.0) - 2.0).abs() < 1e-15);
    }

    proptest! {
        #[test]
        fn what_was_coded_comes_back(light in 0.0_f64..=255.0) {
            for &transfer in Transfer::ALL {
                let back = transfer.light(transfer.coded(light));
                // The two pieces of a curve meet within the digits that the standards print.
                prop_assert!((back - light).abs() < 1e-4 * light.max(0.1), "{:?}: {}", transfer, back);
            }
        }

        #[test]
        fn more_is_coded_as_more(low in 0.0_f64..254.0, step in 0.01_f64..1.0) {
            for &transfer in Transfer::ALL {
                prop_assert!(transfer.light(low + step) > transfer.light(low));
            }
        }
    }
}
