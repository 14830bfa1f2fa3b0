//! What is made of a recording: its settings, and what they take.

use miette::miette;

use super::{
    arguments::{Arguments, Form},
    extent::Extent,
};
use crate::{
    cli::arguments::budget,
    event::tensor::{Alignment, Container, Fill, Share, Sides, TimeSurface, Voxels, Windows},
    memory::{Bytes, Need},
    unit::exact_seconds,
};

/// The settings of a form.
#[derive(Clone, Copy, Debug)]
pub enum Plan {
    Voxels(Voxels),
    /// Surfaces, one at the end of each window.
    Surfaces(TimeSurface, Windows),
    Frames {
        each: usize,
        sides: Sides,
        fill: Fill,
    },
}

impl Plan {
    pub fn new(arguments: &Arguments, about: &Extent) -> miette::Result<Self> {
        let sides = arguments.polarity;
        match arguments.form() {
            Form::Voxels => {
                let length = arguments.window.unwrap_or_default();
                let every = arguments.every.unwrap_or(length);
                let align = arguments.align.unwrap_or_default();
                let windows = Windows::new(length.seconds(), every.seconds(), align)?;
                let windows = begun(windows, arguments, about)?;
                let mut how = Voxels::new(arguments.bins.unwrap_or(5), windows)?;
                how.share = arguments.share.unwrap_or_default();
                how.sides = sides.unwrap_or_default();
                how.normalise = arguments.normalise.unwrap_or_default();
                Ok(Self::Voxels(how))
            }
            Form::Surfaces => {
                let every = arguments.every.unwrap_or_default().seconds();
                let windows = Windows::new(every, every, Alignment::Causal)?;
                let mut how = TimeSurface::new(arguments.tau.unwrap_or_default().seconds())?;
                how.decay = arguments.decay.unwrap_or_default();
                how.sides = sides.unwrap_or(Sides::Split);
                Ok(Self::Surfaces(how, begun(windows, arguments, about)?))
            }
            Form::Frames => Ok(Self::Frames {
                each: arguments.count.unwrap_or(1),
                sides: sides.unwrap_or_default(),
                fill: arguments.fill.unwrap_or_default(),
            }),
        }
    }

    /// The shape of a layer.
    pub fn shape(&self, about: &Extent) -> Vec<usize> {
        let (size, channels) = (about.size, about.channels);
        match self {
            Self::Voxels(how) => how.shape(size, channels).to_vec(),
            Self::Surfaces(how, _) => how.shape(size, channels).to_vec(),
            Self::Frames { sides, .. } => {
                vec![channels.into(), sides.count(), size.height, size.width]
            }
        }
    }

    /// How many layers there will be.
    pub fn count(&self, about: &Extent) -> u64 {
        match self {
            Self::Voxels(how) => how.windows.count(about.end),
            Self::Surfaces(_, windows) => windows.count(about.end),
            Self::Frames { each, .. } => about.events.div_ceil(*each as u64),
        }
    }

    /// Where the first window begins, or when the first surface is, in microseconds; none of frames.
    pub fn first(&self) -> Option<i64> {
        match self {
            Self::Voxels(how) => Some(how.windows.bounds(0).0),
            Self::Surfaces(_, windows) => Some(windows.bounds(0).1),
            Self::Frames { .. } => None,
        }
    }

    /// Refuses what there is no room for in memory.
    pub fn check_memory(&self, arguments: &Arguments, about: &Extent) -> miette::Result<()> {
        let values = values(&self.shape(about));
        // One more as it is written.
        let (what, bytes, help) = match self {
            Self::Voxels(how) => {
                let length = arguments.window.unwrap_or_default();
                let every = arguments.every.unwrap_or(length);
                let overlap = u128::from(length.0.div_ceil(every.0.max(1)) + 1);
                // Sums of shares may need 64 bits.
                let sum = match how.share {
                    Share::Bilinear if how.bins() > 1 => 8,
                    _ => 4,
                };
                (
                    "windows that overlap",
                    values.saturating_mul(sum * overlap + 4),
                    "take fewer bins, or windows that overlap less",
                )
            }
            Self::Surfaces(how, _) => (
                "times of the last events",
                how.held(about.size, about.channels, 2),
                FEWER_KINDS,
            ),
            Self::Frames { .. } => ("a frame", values.saturating_mul(12), FEWER_KINDS),
        };
        budget::check(
            &Need::new().and(what, bytes),
            &format!("{} of {}", arguments.form().name(), about.size),
            help,
        )
    }

    /// Refuses an array for which there is no room on its disk.
    pub fn check_disk(
        &self,
        arguments: &Arguments,
        about: &Extent,
        container: Container,
    ) -> miette::Result<()> {
        let temporary = std::env::temp_dir().join("voxels");
        let place: &std::path::Path = match container {
            Container::Npy if arguments.output.is_node() => &temporary,
            Container::Npy => &arguments.output,
            // Whole before it is packed.
            Container::Npz => &temporary,
            // Packed chunk by chunk: nobody knows how small that gets.
            Container::Hdf5 => return Ok(()),
        };
        let (layers, help) = match self {
            Self::Voxels(_) => (
                "windows",
                "take longer windows, fewer of them (--every), fewer bins, or 16 bits (--half)",
            ),
            Self::Surfaces(..) => (
                "surfaces",
                "take fewer of them (--every), or 16 bits (--half)",
            ),
            Self::Frames { .. } => (
                "frames",
                "take more events a frame (--count), or 16 bits (--half)",
            ),
        };
        let count = self.count(about);
        let each = values(&self.shape(about)).saturating_mul(arguments.precision().bytes());
        budget::check_disk(
            place,
            u128::from(count).saturating_mul(each),
            &format!("{count} {layers} of {}", Bytes(each)),
            help,
        )
    }
}

const FEWER_KINDS: &str = "take one kind of cells: amacrine convert A B --kind N";

/// Values of a layer.
fn values(shape: &[usize]) -> u128 {
    shape
        .iter()
        .fold(1, |n: u128, side| n.saturating_mul(*side as u128))
}

/// Windows from where they are asked to begin.
fn begun(windows: Windows, arguments: &Arguments, about: &Extent) -> miette::Result<Windows> {
    match arguments.from {
        Some(from) if from > about.end => Err(miette!(
            help = "give a time before its end, or leave --from out",
            "--from {} s: {} ends at {} s",
            exact_seconds(from.0),
            arguments.file.display(),
            exact_seconds(about.end.0)
        )),
        Some(from) => Ok(windows.from(from)),
        None => Ok(windows.reaching(about.start)),
    }
}
