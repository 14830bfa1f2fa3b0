//! Parquet, a column each for t, x, y, p (and channel): `pyarrow.parquet.read_table(path)`.
//!
//! t is a 64-bit integer, x and y 16 and p and channel 8 bits without a sign; a million
//! events a row group, pages compressed by Zstandard. Size, channels, time watched and drops
//! are a key of the file, `amacrine`. Read with columns of 32 or 64 bits or booleans, in any
//! order, beside others; a row group at a time. While a file is written it waits as a
//! temporary file. Source: <https://parquet.apache.org/docs/file-format/>.

#[cfg(feature = "parquet")]
mod kind;
#[cfg(feature = "parquet")]
mod streams;

use super::entry::{Entry, Limits, Sign, Streams};

#[cfg(feature = "parquet")]
const STREAMS: Option<Streams> = Some(Streams {
    source: |origin, _| Ok(Box::new(streams::source(origin)?)),
    sink: |head, _| Ok(Box::new(streams::sink(head))),
});

#[cfg(not(feature = "parquet"))]
const STREAMS: Option<Streams> = None;

/// The format's entry in the list of formats.
pub(super) const ENTRY: Entry = Entry {
    name: "parquet",
    extension: "parquet",
    limits: Limits::WIDE,
    readers: "pyarrow, polars, pandas",
    module: "pyarrow.parquet",
    python: "pyarrow.parquet.read_table(path)",
    sign: Sign::Bytes(b"PAR1"),
    index_at_end: true,
    streams: STREAMS,
    rewinds: false,
    ..Entry::PLAIN
};
