//! Events to layers, block by block.

use miette::miette;

use super::{extent::Extent, plan::Plan};
use crate::{
    event::{
        Event,
        tensor::{FrameStream, Precision, SurfaceStream, VoxelStream},
    },
    unit::Micros,
};

/// What makes layers of the events that come.
pub enum Maker {
    Voxels(VoxelStream),
    Surfaces(SurfaceStream),
    Frames(Frames),
}

/// Frames, whose whole numbers become floats.
pub struct Frames {
    stream: FrameStream,
    precision: Precision,
}

impl Maker {
    /// No events yet.
    pub fn new(plan: &Plan, about: &Extent, precision: Precision) -> miette::Result<Self> {
        let (size, channels) = (about.size, about.channels);
        Ok(match *plan {
            Plan::Voxels(how) => Self::Voxels(VoxelStream::new(how, size, channels)),
            Plan::Surfaces(how, windows) => {
                Self::Surfaces(SurfaceStream::new(how, windows, size, channels)?)
            }
            Plan::Frames { each, sides, fill } => Self::Frames(Frames {
                stream: FrameStream::new(each, sides, fill, size, channels)?,
                precision,
            }),
        })
    }

    /// Takes in events, and writes the layers that are over.
    pub fn pass(
        &mut self,
        events: &[Event],
        mut write: impl FnMut(&[f32]) -> miette::Result<()>,
    ) -> miette::Result<()> {
        match self {
            Self::Voxels(stream) => stream.pass(events, write),
            Self::Surfaces(stream) => stream.pass(events, write),
            Self::Frames(Frames { stream, precision }) => {
                stream.pass(events, |frame| write(&floats(frame, *precision)?))
            }
        }
    }

    /// Writes the layers that are left of a recording that ends at `end`.
    pub fn finish(
        &mut self,
        end: Micros,
        mut write: impl FnMut(&[f32]) -> miette::Result<()>,
    ) -> miette::Result<()> {
        match self {
            Self::Voxels(stream) => {
                while let Some(window) = stream.next_left(end) {
                    write(&window)?;
                }
            }
            Self::Surfaces(stream) => {
                while let Some(surface) = stream.next_left(end) {
                    write(&surface)?;
                }
            }
            Self::Frames(Frames { stream, precision }) => {
                if let Some((frame, _)) = stream.rest() {
                    write(&floats(frame, *precision)?)?;
                }
            }
        }
        Ok(())
    }

    /// Events that lie between windows, in none of them.
    pub const fn between(&self) -> u64 {
        match self {
            Self::Voxels(stream) => stream.between(),
            _ => 0,
        }
    }

    /// Events of the last frame, where it has fewer than the others.
    pub fn left_over(&self) -> Option<usize> {
        match self {
            Self::Frames(frames) => frames.stream.rest().map(|(_, events)| events),
            _ => None,
        }
    }
}

/// A frame as floats, which must be the same numbers.
fn floats(frame: &[i32], precision: Precision) -> miette::Result<Vec<f32>> {
    // Up to here a float of so many bits has every whole number.
    let (bits, exact) = match precision {
        Precision::Single => (32, 1_u32 << 24),
        Precision::Half => (16, 1 << 11),
    };
    let most = frame.iter().map(|n| n.unsigned_abs()).max().unwrap_or(0);
    if most > exact {
        let help = match precision {
            Precision::Single => "take fewer events a frame (--count)",
            Precision::Half => "leave --half out, or take fewer events a frame (--count)",
        };
        return Err(miette!(
            help = help,
            "a pixel of a frame has {most} events, and {bits} bits hold whole numbers up to {exact}"
        ));
    }
    Ok(frame.iter().map(|n| *n as f32).collect())
}
