//! What `exec` is asked to do.

use std::path::PathBuf;

use crate::{
    array::Arithmetic,
    cli::{
        arguments::{
            chip_figure::figure, fidelity::Fidelity, heading, light::Samples, without::Terms,
        },
        input::opened_program::Source,
        output::{
            content::Content,
            files::{Named, Output},
        },
    },
    event::file::Format,
    isa::Figure,
};

/// What `exec` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example: amacrine exec sobel.scamp --set A=a.npy --domain q8.8 --dump out/registers"
)]
pub struct Arguments {
    #[command(flatten)]
    pub(super) source: Source,
    /// Set a register, a number of the chip, or a constant or slider; may be repeated
    ///
    /// A register takes a .npy of shape (H,W), before the program runs (A=a.npy). A number of the
    /// chip (error.noise=0.1), a constant or a slider of the program (threshold=20) takes a number.
    #[arg(long = "set", value_name = "NAME=FILE.npy|NUMBER", value_parser = assignment)]
    pub(super) sets: Vec<Assignment>,
    /// Light on the array: a picture, a clip, or pattern:NAME?key=value
    ///
    /// A still picture is shown in every frame. Default: as the program's settings say.
    #[arg(long, visible_alias = "scene")]
    pub(super) image: Option<Named>,
    #[command(flatten)]
    pub(super) samples: Samples,
    /// Number of frames to run: the first runs `init`, all others `frame`
    ///
    /// Default: the whole clip if --image names one, else as many as the program's settings say.
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..))]
    pub(super) frames: Option<u64>,
    #[arg(long, help = format!("Arithmetic of the cells: {} [default: as the program says, else exact]", Arithmetic::names()))]
    pub(super) domain: Option<String>,
    /// Clip every store to the chip's range
    ///
    /// Default: as the program says, else as the chip's data say.
    #[arg(long, value_enum, help_heading = heading::CHIP)]
    pub(super) clip: Option<Switch>,
    /// Value of registers beyond the border, in LSB
    ///
    /// Default: as the program says, else as the chip's data say.
    #[arg(long, help_heading = heading::CHIP)]
    pub(super) edge: Option<f64>,
    /// Rise of PIX for one level of light, in LSB [default: as the chip's data say]
    #[arg(long, help_heading = heading::CHIP)]
    pub(super) gain: Option<f64>,
    /// Seed of the silicon: the chip that is drawn, and its noise [default: 0]
    #[arg(long, help_heading = heading::CHIP)]
    pub(super) seed: Option<u64>,
    #[command(flatten)]
    pub(super) fidelity: Fidelity,
    #[command(flatten)]
    pub(super) without: Terms,
    #[arg(short = 'o', long, help = format!("Write the events that are read out; the extension names the format ({})", Format::names()), value_parser = Content::Events)]
    pub(super) events: Option<Output>,
    /// Write every register to this folder, as .npy and .png
    #[arg(long, value_parser = Content::Folder, help_heading = heading::OUTPUT)]
    pub(super) dump: Option<Output>,
    /// Write the pictures that the program shows (`scamp5_output_image`) to this folder
    ///
    /// One .png for each such line and each frame.
    #[arg(long, value_name = "FOLDER", value_parser = Content::Folder, help_heading = heading::OUTPUT)]
    pub(super) displays: Option<Output>,
    /// Write one picture of the registers after each line of the last frame, side by side
    #[arg(long, value_name = "FILE.png", value_parser = Content::Picture, help_heading = heading::OUTPUT)]
    pub(super) strip: Option<Output>,
    /// Write a page for a browser that steps through the words of the last frames
    ///
    /// It steps forwards and backwards, and shows every register as a picture: on the chip and,
    /// beside it, in exact arithmetic. The chip is `silicon`, unless --domain names another
    /// arithmetic that has errors. The page marks the first pixel that differs, and switches noise
    /// on and off.
    #[arg(long, value_name = "PAGE.html", value_parser = Content::Page, help_heading = heading::OUTPUT)]
    pub(super) trace: Option<Output>,
    /// Number of runs, with this seed and those that follow; prints mean and spread
    ///
    /// Excludes --events, --dump, --displays, --strip, --trace and --debug.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..), conflicts_with_all = ["dump", "events", "strip", "debug", "displays", "trace"], help_heading = heading::CHIP)]
    pub(super) repeat: Option<u64>,
    /// Run the host code of vendor C++ statement by statement, beside the array
    ///
    /// This shows what it posts (`vs_post_text`, `printf`). It is always done if the host decides
    /// by what it reads; this option does it for a host that asks the same of the array in every
    /// frame, too.
    #[arg(long)]
    pub(super) host: bool,
    /// Step through the program; type `help` for the commands
    ///
    /// Commands are read from standard input. Excludes --json, --strip, --trace and --repeat.
    #[arg(long, conflicts_with_all = ["json", "strip", "trace"])]
    pub(super) debug: bool,
    /// Order of the work on the array: plain or tiled; it changes only the speed
    #[arg(long, help_heading = heading::RESOURCES)]
    pub(super) schedule: Option<String>,
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
