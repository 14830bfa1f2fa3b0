//! The layout of v2e's `--dvs_h5` (Hu et al. 2021): `events`, one row an event: microseconds, x, y,
//! sign, of 32 bits without a sign.
//!
//! The size is that of the pictures, `frame`, which are there on request, are left out and counted.
//! Source: <https://github.com/SensorsINI/v2e>, `v2ecore/emulator.py`.

use hdf5_pure::File;

use super::{
    super::fault::Stop,
    cameras::{Camera, Reading, Table},
};

/// Where the events are.
pub const EVENTS: &str = "events";

/// Opens the stream of events.
pub fn source(file: &File) -> Result<Reading, Stop> {
    let (table, events) = Table::rows(file, EVENTS, [1, 2, 0, 3])?;
    let seconds = table.has_real_times()?;
    let mut camera = Camera {
        number: 0,
        path: EVENTS,
        table,
        events,
        stated: None,
        size: None,
        others: 0,
    };
    camera.leave_out(file, "frame")?;
    Ok(Reading::new(vec![camera], seconds))
}
