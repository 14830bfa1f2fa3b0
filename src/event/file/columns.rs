//! Events as columns side by side, as HDF5 and Parquet hold them.

use super::{
    Place,
    about::About,
    fault::{Fault, Stop},
    gate::{Raw, hold_kinds},
};

/// The columns; the last one is there where a packet has several kinds.
pub const COLUMNS: [&str; 5] = ["t", "x", "y", "p", "channel"];

/// The remark of a file that has other columns.
pub const OTHERS: &str = "other columns than t, x, y, p and channel are left out";

/// What the file says of the whole packet, where it says it; `columns` is how many it has.
pub fn about(comment: Option<&str>, columns: usize) -> Result<About, Stop> {
    let about = comment.map_or(Ok(None), About::parse);
    about
        .and_then(|about| {
            hold_kinds(about.as_ref(), columns == COLUMNS.len())?;
            Ok(about.unwrap_or_default())
        })
        .map_err(|fault| Stop::Fault(Place::Byte(0), fault))
}

/// An event from what each of the [`COLUMNS`] has of it; 0 where there is no such column.
pub fn raw(value: impl Fn(usize) -> Result<i128, Fault>) -> Result<Raw, Fault> {
    Ok(Raw {
        t: value(0)?,
        x: value(1)?,
        y: value(2)?,
        p: value(3)?,
        channel: value(4)?,
    })
}
