//! What the samples of a scene mean, the same options for every verb that shows one; what is
//! said of the light, and the warnings.

use std::fmt::Write as _;

use miette::miette;
use serde_json::{Value, json};

use super::{budget, heading, recording};
use crate::{
    cli::complain,
    plane::Size,
    rig::guard::Warning,
    scene::{
        Coding, Crop, Observation, Observed, OpenOptions, Range, Scene, SceneError, Slice,
        Transfer, View, bundled_with, open,
    },
};

/// How a scene is read: its rate, what its samples mean, and which part of it is shown.
#[derive(Clone, Debug, clap::Args)]
pub struct Samples {
    /// Frames per second, in place of what the scene says
    #[arg(long, help_heading = heading::SCENE)]
    fps: Option<f64>,
    /// Sample values of black and white
    #[arg(long, value_enum, default_value = "auto", help_heading = heading::SCENE)]
    range: Asked,
    /// Transfer curve (gamma) to undo before the photoreceptor
    #[arg(long, value_enum, default_value = "as-coded", help_heading = heading::SCENE)]
    transfer: Undo,
    /// Factor for the numbers of a .npy: 255 if they are 0 to 1
    #[arg(long, value_name = "FACTOR", help_heading = heading::SCENE)]
    scale: Option<f64>,
    /// Part of the clip to show, in times or frames: 2s..5s, 500ms.., ..100
    #[arg(long, value_name = "FROM..TO", help_heading = heading::SCENE)]
    slice: Option<Slice>,
    /// Part of the picture to show: its middle, or +X+Y from its left and its top
    #[arg(long, value_name = "WxH[+X+Y]", help_heading = heading::SCENE)]
    crop: Option<Crop>,
    /// Size to which the picture is reduced
    ///
    /// Each of the larger pixels has the mean of the light that falls on it.
    #[arg(long, value_name = "WxH", value_parser = recording::size, help_heading = heading::SCENE)]
    resize: Option<Size>,
}

#[derive(Clone, Copy, Debug, PartialEq, clap::ValueEnum)]
enum Asked {
    /// As the file says; if it does not: limited for mp4 and y4m with colour, full for all others
    Auto,
    /// Black is 16 and white 235, of 255; values outside are clipped
    Limited,
    /// Black is 0 and white 255
    Full,
}

#[derive(Clone, Copy, Debug, PartialEq, clap::ValueEnum)]
enum Undo {
    /// The curve that the file names (mp4: colr or VUI; png: cICP, sRGB or gAMA); as-coded if it
    /// names none
    Auto,
    /// Undo nothing, as v2e and ESIM do
    AsCoded,
    /// Undo nothing: the samples are linear light already
    Linear,
    /// IEC 61966-2-1 (sRGB), the curve of most pictures
    Srgb,
    /// ITU-R BT.709
    Bt709,
    /// Power of 2.2: analogue video of 525 lines
    Gamma22,
    /// Power of 2.8: analogue video of 625 lines
    Gamma28,
    /// SMPTE ST 240: early high-definition video
    Smpte240m,
}

impl Samples {
    /// As it is asked for.
    fn coding(&self) -> Coding {
        Coding {
            range: match self.range {
                Asked::Auto => None,
                Asked::Limited => Some(Range::Limited),
                Asked::Full => Some(Range::Full),
            },
            transfer: match self.transfer {
                Undo::Auto => None,
                Undo::AsCoded => Some(Transfer::AsCoded),
                Undo::Linear => Some(Transfer::Linear),
                Undo::Srgb => Some(Transfer::Srgb),
                Undo::Bt709 => Some(Transfer::Bt709),
                Undo::Gamma22 => Some(Transfer::Gamma22),
                Undo::Gamma28 => Some(Transfer::Gamma28),
                Undo::Smpte240m => Some(Transfer::Smpte240m),
            },
            scale: self.scale,
        }
    }

    /// Frames per second, where they are said.
    pub const fn fps(&self) -> Option<f64> {
        self.fps
    }

    /// The same with this rate, where none is said.
    pub fn or_fps(&self, fps: Option<f64>) -> Self {
        Self {
            fps: self.fps.or(fps),
            ..self.clone()
        }
    }

    /// Whether it is said which frames are shown.
    pub const fn has_slice(&self) -> bool {
        self.slice.is_some()
    }

    /// The scene, or the bundled clip, within what may be held; what is seen of it is noted.
    ///
    /// # Errors
    /// When it cannot be opened.
    pub fn open(
        &self,
        scene: Option<&str>,
        observation: &Observation,
    ) -> Result<Box<dyn Scene>, SceneError> {
        let options = OpenOptions {
            coding: self.coding(),
            view: View {
                slice: self.slice,
                crop: self.crop,
                resize: self.resize,
            },
            ..budget::opening(self.fps)
        };
        let scene = match scene {
            Some(scene) => open(scene, &options)?,
            None => bundled_with(&options)?,
        };
        Ok(Box::new(Observed::new(scene, observation)))
    }

    /// The options that are not what they are when left out, as they are written.
    pub fn written(&self) -> Vec<(&'static str, String)> {
        // Each is named here, so that none is forgotten.
        let Self {
            fps,
            range: _,
            transfer: _,
            scale,
            slice,
            crop,
            resize,
        } = self;
        let Coding {
            range, transfer, ..
        } = self.coding();
        let transfer = match transfer {
            None => Some("auto"),
            Some(Transfer::AsCoded) => None,
            Some(transfer) => Some(transfer.word()),
        };
        let all = [
            ("fps", fps.map(|fps| fps.to_string())),
            ("range", range.map(|range| range.word().to_owned())),
            ("transfer", transfer.map(str::to_owned)),
            ("scale", scale.map(|scale| scale.to_string())),
            ("slice", slice.map(|slice| slice.to_string())),
            ("crop", crop.map(|crop| crop.to_string())),
            ("resize", resize.map(|size| size.to_string())),
        ];
        all.into_iter()
            .filter_map(|(name, value)| Some((name, value?)))
            .collect()
    }
}

/// How much light may change from frame to frame, in ln units.
pub fn contrast(text: &str) -> Result<f64, String> {
    let contrast = text.parse().ok();
    contrast
        .filter(|contrast: &f64| contrast.is_finite() && *contrast > 0.0)
        .ok_or_else(|| "give a number above 0, such as 0.1, which suits 8-bit video".to_owned())
}

/// What is said of the light in a line, and in another of a frame rate that nobody said; nothing
/// where there is no scene.
pub fn line(observation: &Observation) -> String {
    let Some(words) = observation.words() else {
        return String::new();
    };
    let mut line = format!("light    {words}\n");
    if let Some(fps) = observation.assumed_fps() {
        let _ = writeln!(
            line,
            "fps      {fps} frames/s (assumed; --fps says otherwise)"
        );
    }
    line
}

/// The same for machines.
pub fn json(observation: &Observation) -> Value {
    json!(observation.seen_light())
}

/// Refuses a scene of no frame.
pub fn check_frames(frames: u64) -> miette::Result<()> {
    if frames > 0 {
        return Ok(());
    }
    Err(miette!(
        help = "give a scene with at least one frame",
        "the scene has no frames"
    ))
}

/// Says each warning beside the output.
pub fn warn(warnings: &[Warning]) {
    warn_of(None, warnings);
}

/// Says each warning beside the output that was not told before.
pub fn warn_besides(told: &[Warning], warnings: &[Warning]) {
    for warning in warnings.iter().filter(|it| !told.contains(it)) {
        warn(std::slice::from_ref(warning));
    }
}

/// Says each warning beside the output, and of which of several kernels it is.
pub fn warn_of(kernel: Option<&String>, warnings: &[Warning]) {
    let of = kernel.map_or(String::new(), |name| format!("{name}: "));
    for warning in warnings {
        complain(&format!("warning: {of}{warning}\n"));
    }
}
