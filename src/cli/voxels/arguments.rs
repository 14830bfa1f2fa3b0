//! What `voxels` is asked to do, and which options each form of array has.

use clap::builder::RangedU64ValueParser;
use miette::{Diagnostic as _, miette};

use crate::{
    cli::{
        arguments::{heading, recording::Recording},
        output::{
            content::Content,
            files::{Input, Output},
        },
    },
    event::tensor::{Alignment, Decay, Fill, MOST_BINS, Normalise, Precision, Share, Sides},
    unit::Micros,
};

const AFTER_HELP: &str = "Examples:
  amacrine voxels events.npy -o voxels.npy --window 50ms
  amacrine voxels events.npy -o voxels.npz --window 100ms --every 50ms --bins 9 --polarity split --half
  amacrine voxels events.npy -o voxels.h5 --window 50ms --normalise std --align centred
  amacrine voxels events.npy -o surfaces.npy --as surfaces --every 10ms --tau 50ms
  amacrine voxels events.npy -o frames.npy --as frames --count 20000

Voxels have the shape (windows, kinds, sides, bins, H, W), surfaces (times, kinds, sides, H, W), frames (frames, kinds, sides, H, W); sides is 1, or with --polarity split OFF and then ON. A window has the events after its start and up to its end; the first window also has those at its start. An event at the time of a frame is thus in the window that ends with it. Files of any length are read block by block; only windows that overlap, one surface or one frame are in memory.";

/// What `voxels` is asked to do.
#[derive(Debug, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Event file
    pub file: Input,
    #[command(flatten)]
    pub recording: Recording,
    /// Write the array: .npy, .npz (with the names of the kinds) or .h5
    #[arg(short, long, value_name = "ARRAY", value_parser = Content::Tensor)]
    pub output: Output,
    /// Form of the array [default: voxels]
    #[arg(long = "as", value_enum, value_name = "FORM")]
    pub form: Option<Form>,
    /// Number of bins in a window [default: 5]
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=MOST_BINS as u64), help_heading = heading::VOXELS)]
    pub bins: Option<usize>,
    /// Length of a window
    #[arg(long, value_name = "TIME", required_unless_present = "form", required_if_eq("form", "voxels"), help_heading = heading::VOXELS)]
    pub window: Option<Micros>,
    /// Time from which windows are counted
    ///
    /// The first window ends, and the first surface is, one --every later; with --align centred
    /// the first window has its middle there. Default: the last multiple of --every before or at
    /// the start of the recording.
    #[arg(long, value_name = "TIME")]
    pub from: Option<Micros>,
    /// Time from one window or surface to the next [default: the length of a window]
    #[arg(long, value_name = "TIME", required_if_eq("form", "surfaces"))]
    pub every: Option<Micros>,
    /// Position of a window about its time: causal or centred [default: causal]
    ///
    /// `causal` ends at that time. `centred` has its middle there, with half of --window before and
    /// after it, each end to the nearest microsecond.
    #[arg(long, value_name = "WHERE", value_parser = parsed::<Alignment>, help_heading = heading::VOXELS)]
    pub align: Option<Alignment>,
    /// Polarity: signed or split [default: signed; of surfaces split]
    ///
    /// `signed` adds ON and subtracts OFF; a surface is below 0 where the last event was OFF.
    /// `split` has a plane for each, OFF first.
    #[arg(long, value_name = "HOW", value_parser = parsed::<Sides>)]
    pub polarity: Option<Sides>,
    /// Weights of an event: bilinear or whole [default: bilinear]
    ///
    /// `bilinear` shares an event between the two nearest bins; the middle of the first bin is at
    /// the start of the window, that of the last at its end. `whole` divides the window into bins
    /// of equal length, and counts an event in the bin that it falls in; an event at the end of a
    /// bin belongs to that bin.
    #[arg(long, value_name = "HOW", value_parser = parsed::<Share>, help_heading = heading::VOXELS)]
    pub share: Option<Share>,
    /// Normalisation of a window, for each kind: none, std or max [default: none]
    ///
    /// `std` is that of E2VID: voxels that are not 0 get a mean of 0 and a deviation of 1; where
    /// these are all equal, or only one, they become 0. `max` divides by the largest magnitude.
    #[arg(long, value_name = "HOW", value_parser = parsed::<Normalise>, help_heading = heading::VOXELS)]
    pub normalise: Option<Normalise>,
    /// Time constant of a surface
    #[arg(long, value_name = "TIME", required_if_eq("form", "surfaces"), help_heading = heading::SURFACES)]
    pub tau: Option<Micros>,
    /// Decay of a surface: exponential or linear [default: exponential]
    ///
    /// `exponential` is exp(-age/tau), `linear` 1 - age/tau down to 0.
    #[arg(long, value_name = "HOW", value_parser = parsed::<Decay>, help_heading = heading::SURFACES)]
    pub decay: Option<Decay>,
    /// Number of events in a frame; the last frame has what is left
    ///
    /// For frames of equal time take voxels: --bins 1 --share whole.
    #[arg(long, value_name = "N", required_if_eq("form", "frames"), value_parser = RangedU64ValueParser::<usize>::new().range(1..=i32::MAX as u64), help_heading = heading::FRAMES)]
    pub count: Option<usize>,
    /// Value of a pixel in a frame: count or last [default: count]
    ///
    /// `count` is the number of its events, ON less OFF where they are signed; `last` its last
    /// event, 1 or -1 (1 where they are split).
    #[arg(long, value_name = "HOW", value_parser = parsed::<Fill>, help_heading = heading::FRAMES)]
    pub fill: Option<Fill>,
    /// Write numbers of 16 bits in place of 32
    #[arg(long)]
    pub half: bool,
    /// Print JSON in place of text
    #[arg(long)]
    pub json: bool,
}

/// What events become.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Form {
    /// Bins over windows of time
    Voxels,
    /// Time surfaces: how long ago each cell fired
    Surfaces,
    /// Event frames: pictures of so many events each
    Frames,
}

impl Form {
    /// Its name, on the command line and of the array in a file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Voxels => "voxels",
            Self::Surfaces => "surfaces",
            Self::Frames => "frames",
        }
    }
}

/// A name, for the command line, which shows no help beside a message.
fn parsed<T>(text: &str) -> Result<T, String>
where
    T: std::str::FromStr,
    T::Err: miette::Diagnostic,
{
    text.parse().map_err(|error: T::Err| {
        let known = error
            .help()
            .map_or(String::new(), |help| format!(": {help}"));
        format!("{error}{known}")
    })
}

impl Arguments {
    pub fn form(&self) -> Form {
        self.form.unwrap_or(Form::Voxels)
    }

    pub const fn precision(&self) -> Precision {
        if self.half {
            Precision::Half
        } else {
            Precision::Single
        }
    }

    /// Refuses options that change nothing of this form.
    pub fn check_options(&self) -> miette::Result<()> {
        use Form::{Frames, Surfaces, Voxels};
        let form = self.form();
        let options: [(&str, bool, &[Form]); 10] = [
            ("bins", self.bins.is_some(), &[Voxels]),
            ("window", self.window.is_some(), &[Voxels]),
            ("from", self.from.is_some(), &[Voxels, Surfaces]),
            ("every", self.every.is_some(), &[Voxels, Surfaces]),
            ("align", self.align.is_some(), &[Voxels]),
            ("share", self.share.is_some(), &[Voxels]),
            ("normalise", self.normalise.is_some(), &[Voxels]),
            ("tau", self.tau.is_some(), &[Surfaces]),
            ("decay", self.decay.is_some(), &[Surfaces]),
            ("count", self.count.is_some(), &[Frames]),
        ];
        let fill = ("fill", self.fill.is_some(), &[Frames][..]);
        let mut all = options.into_iter().chain([fill]);
        let idle = all.find(|(_, given, forms)| *given && !forms.contains(&form));
        let Some((option, _, forms)) = idle else {
            return Ok(());
        };
        let help = match (option, form) {
            ("window", Surfaces) => "leave --window out; --tau says how long a cell remembers",
            ("window" | "every", Frames) => {
                "leave it out; for frames of equal time: --as voxels --bins 1 --share whole"
            }
            _ => &format!("leave --{option} out, or take --as {}", forms[0].name()),
        };
        Err(miette!(
            help = help.to_owned(),
            "--{option} has no effect with --as {}",
            form.name()
        ))
    }
}
