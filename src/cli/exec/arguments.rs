//! What `exec` is asked to do.

use std::path::PathBuf;

use super::super::{
    content::Content,
    fidelity::Fidelity,
    figure::figure,
    files::{Named, Output},
    light::Samples,
    opened::Source,
    without::Terms,
};
use crate::{array::Arithmetic, event::file::Format, isa::Figure};

/// What `exec` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example: amacrine exec sobel.scamp --set A=a.npy --domain q8.8 --dump out/registers"
)]
pub struct Arguments {
    #[command(flatten)]
    pub(super) source: Source,
    /// Set a register before the program runs (a .npy of shape (H,W)), a number of the chip
    /// (error.noise=0.1), or a constant or slider of the program (threshold=20); can be given
    /// more than once
    #[arg(long = "set", value_name = "NAME=FILE.npy|NUMBER", value_parser = assignment)]
    pub(super) sets: Vec<Assignment>,
    /// The light: a picture, a clip, or pattern:NAME?key=value; a still picture is shown again and again
    #[arg(long, visible_alias = "scene")]
    pub(super) image: Option<Named>,
    #[command(flatten)]
    pub(super) samples: Samples,
    /// How many frames to run; the first one runs `init`, the others `frame`
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..))]
    pub(super) frames: Option<u64>,
    /// Frames per second, instead of what the scene says
    #[arg(long)]
    pub(super) fps: Option<f64>,
    #[arg(long, help = format!("The arithmetic: {}", Arithmetic::names()))]
    pub(super) domain: Option<String>,
    /// Limit every store to the chip's range
    #[arg(long, value_enum)]
    pub(super) clip: Option<Switch>,
    /// What registers off the array hold, in LSB [default: what the program says, else what the chip has]
    #[arg(long)]
    pub(super) edge: Option<f64>,
    /// LSB that PIX rises by for one level of light [default: what the chip's data say]
    #[arg(long)]
    pub(super) gain: Option<f64>,
    /// Which chip of the silicon domain, and which noise [default: 0]
    #[arg(long)]
    pub(super) seed: Option<u64>,
    /// In which order the array is worked on, which changes only the speed: plain, tiled
    #[arg(long)]
    pub(super) schedule: Option<String>,
    #[command(flatten)]
    pub(super) fidelity: Fidelity,
    #[command(flatten)]
    pub(super) without: Terms,
    #[arg(short = 'o', long, help = format!("Write the events that were read out; the extension names the format ({})", Format::names()), value_parser = Content::Events)]
    pub(super) events: Option<Output>,
    /// Write every register into this folder, as .npy and .png
    #[arg(long, value_parser = Content::Folder)]
    pub(super) dump: Option<Output>,
    /// Write what the program shows (`scamp5_output_image`) into this folder: a .png for each line
    /// and frame
    #[arg(long, value_name = "FOLDER", value_parser = Content::Folder)]
    pub(super) displays: Option<Output>,
    /// Write what registers hold after each line of the last frame, side by side (.png)
    #[arg(long, value_name = "FILE.png", value_parser = Content::Picture)]
    pub(super) strip: Option<Output>,
    /// Write a page for a browser that steps through the words of the last frames, forwards and
    /// backwards: every register as a picture, on the chip (silicon, where --domain names no
    /// other arithmetic that errs) and in exact arithmetic beside, the first pixel that parts, noise
    /// on and off
    #[arg(long, value_name = "PAGE.html", value_parser = Content::Page)]
    pub(super) trace: Option<Output>,
    /// Run so many times, with this seed and those that follow; print mean and spread
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..), conflicts_with_all = ["dump", "events", "strip", "debug", "displays", "trace"])]
    pub(super) repeat: Option<u64>,
    /// Run the host of vendor C++ beside the array, statement by statement, also where it asks the
    /// same of it in every frame: what it posts (`vs_post_text`, `printf`) is shown. A host that
    /// decides by what it reads is always run so
    #[arg(long)]
    pub(super) host: bool,
    /// Step through the program; commands are read from standard input, `help` lists them
    #[arg(long, conflicts_with_all = ["json", "strip", "trace"])]
    pub(super) debug: bool,
    /// Print JSON in place of text
    #[arg(long)]
    pub(super) json: bool,
}

impl Arguments {
    pub(super) fn seed(&self) -> u64 {
        self.seed.unwrap_or(0)
    }

    /// Whether a frame is run step by step, and looked at.
    pub(super) fn looks(&self) -> bool {
        self.strip.is_some() || self.trace.is_some() || self.debug
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Switch {
    On,
    Off,
}

/// What one `--set` asks for.
#[derive(Clone, Debug)]
pub enum Assignment {
    /// A register is read from a file.
    Register(String, PathBuf),
    /// A number of the chip is another.
    Figure(Figure, f64),
    /// A constant of the program is another.
    Constant(String, f64),
}

impl Assignment {
    /// What is set, as it is written.
    pub fn name(&self) -> String {
        match self {
            Self::Register(name, _) | Self::Constant(name, _) => name.clone(),
            Self::Figure(figure, _) => {
                let (section, key) = figure.key();
                format!("{section}.{key}")
            }
        }
    }
}

/// `name=file` or `section.key=number`, for the command line.
fn assignment(text: &str) -> Result<Assignment, String> {
    let (name, value) = match text.split_once('=') {
        Some((name, value)) if !name.is_empty() && !value.is_empty() => (name, value),
        _ => {
            return Err(format!(
                "`{text}` is not REGISTER=FILE.npy or FIGURE=NUMBER"
            ));
        }
    };
    if !name.contains('.') {
        if let Ok(value) = value.parse() {
            return Ok(Assignment::Constant(name.to_owned(), value));
        }
        return Ok(Assignment::Register(name.to_owned(), value.into()));
    }
    figure(name, value).map(|(figure, number)| Assignment::Figure(figure, number))
}
