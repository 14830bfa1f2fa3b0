//! Events as a list, in order of time; those of one microsecond row by row, then by channel, then
//! by column.

mod block;
mod buffers;
mod events;
mod limit;
mod packed_event;
mod part;
mod sorted;
mod time_quantiser;

pub(super) use self::buffers::Buffers;
pub use self::{
    events::{EventList, ListBand},
    limit::{Limit, WhenFull},
};
