//! HDF5 laid out as the DSEC data set (Gehrig et al. 2021).
//!
//! `events/{t,x,y,p}` (and `channel`), `t_offset`, and `ms_to_idx`, the first event at or
//! after each millisecond. `t` counts from `t_offset`, so `t + t_offset` is absolute: 0 where
//! the first event comes in the first ten minutes, else its whole millisecond. t is `<i8`, where
//! DSEC has 32 bits without a sign; columns are deflated in chunks. Size, channels, time watched
//! and drops are an attribute. Read with integers of any width; what is compressed by other filters
//! (blosc) is refused. The layouts of `event_utils`, MVSEC and v2e are read too: a file of code
//! each. While a file is written it waits as a temporary file. Source:
//! <https://dsec.ifi.uzh.ch/data-format/>.

#[cfg(feature = "hdf5")]
mod cameras;
#[cfg(feature = "hdf5")]
mod event_utils;
#[cfg(feature = "hdf5")]
mod mvsec;
#[cfg(feature = "hdf5")]
mod numbers;
#[cfg(feature = "hdf5")]
mod open;
#[cfg(feature = "hdf5")]
mod streams;
#[cfg(feature = "hdf5")]
mod v2e;

use super::entry::{Entry, Limits, Sign, Streams};

#[cfg(feature = "hdf5")]
const STREAMS: Option<Streams> = Some(Streams {
    source: |origin, _| streams::source(origin),
    sink: |head, _| Ok(Box::new(streams::sink(head))),
});

#[cfg(not(feature = "hdf5"))]
const STREAMS: Option<Streams> = None;

/// The format's entry in the list of formats.
pub(super) const ENTRY: Entry = Entry {
    name: "hdf5",
    extension: "h5",
    // Its index has a number for each millisecond.
    limits: Limits {
        silence: u32::MAX as u64,
        ..Limits::WIDE
    },
    readers: "h5py, evlib (without `t_offset`)",
    module: "h5py",
    python: "(lambda f: [f['events/t'][:] + f['t_offset'][()], *(f['events/' + n][:] for n in 'xyp')])(h5py.File(path))",
    sign: Sign::Bytes(b"\x89HDF\r\n\x1a\n"),
    streams: STREAMS,
    also: &["hdf"],
    rewinds: false,
    clock_from_first: true,
    ..Entry::PLAIN
};
