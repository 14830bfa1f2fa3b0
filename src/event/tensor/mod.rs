//! Events as networks are fed: voxels over windows of time, time surfaces, event frames.
//!
//! All of them are row after row, `[…][channel][side][y, x]`, where a side is OFF and then ON
//! ([`Sides::Split`]), or the two are one ([`Sides::Signed`]).

mod error;
mod file;
mod frame;
mod frame_stream;
mod hdf5;
mod last_event;
mod normalise;
mod period;
mod sides;
mod stream;
mod sums;
mod surface;
mod surface_stream;
mod voxels;
mod windows;

pub use error::{MOST_BINS, TensorError};
pub use file::{Container, Layers, Precision, TensorFile};
pub use frame::{Fill, frames};
pub use frame_stream::FrameStream;
pub use normalise::Normalise;
pub use sides::Sides;
pub use stream::VoxelStream;
pub use surface::{Decay, TimeSurface};
pub use surface_stream::SurfaceStream;
pub use voxels::{Share, Voxels};
pub use windows::{Alignment, Windows};

use super::Event;

/// Events in the order of their times; copied only where they are not.
fn sorted(events: &[Event]) -> std::borrow::Cow<'_, [Event]> {
    if events.is_sorted_by_key(|event| event.t) {
        return events.into();
    }
    let mut events = events.to_vec();
    events.sort_by_key(|event| event.t);
    events.into()
}
