//! The layout of `event_utils`, which the networks of the E2VID family are trained on:
//! `events/{xs,ys,ts,ps}`.
//!
//! `ts` is in seconds where it is real, in microseconds where it is whole; `ps` is a truth value
//! or a sign. The attribute `sensor_resolution` is (height, width), `num_events` must be true.
//! `images` and `flow` are left out and counted. Source:
//! <https://github.com/TimoStoffregen/event_utils>, `lib/data_formats/event_packagers.py`.

use hdf5_pure::File;

use super::{
    super::fault::Stop,
    cameras::{Camera, Reading, Table},
    numbers::is_real,
    open::{attribute, column, length, unreadable, wrong},
};
use crate::plane::Size;

/// Where the times are.
pub const TIMES: &str = "events/ts";

/// Opens the stream of events.
pub fn source(file: &File) -> Result<Reading, Stop> {
    let mut events = None;
    let mut open = |path| -> Result<_, Stop> {
        let column = column(file, path)?;
        length(&column, path, &mut events)?;
        Ok((column, path))
    };
    let columns = vec![
        open("events/xs")?,
        open("events/ys")?,
        open(TIMES)?,
        open("events/ps")?,
    ];
    let seconds = is_real(&columns[2].0)?;
    let mut others = 0;
    for name in ["images", "flow"] {
        if let Ok(group) = file.group(name) {
            others += group.datasets().map_err(unreadable)?.len() as u64;
        }
    }
    let stated = attribute(file, "num_events")?;
    let camera = Camera {
        number: 0,
        path: TIMES,
        table: Table::Columns(columns),
        events: events.unwrap_or(0),
        stated: stated.and_then(|it| Some((*it.first()?, "num_events"))),
        size: size(file)?,
        others,
    };
    Ok(Reading::new(vec![camera], seconds))
}

/// The size of the sensor; of images with colours it may have a third number.
fn size(file: &File) -> Result<Option<Size>, Stop> {
    const NAME: &str = "sensor_resolution";
    let Some(sides) = attribute(file, NAME)? else {
        return Ok(None);
    };
    let side = |n: usize| usize::try_from(*sides.get(n)?).ok();
    match (side(0), side(1), sides.len()) {
        (Some(height), Some(width), 2 | 3) => Ok(Some(Size::new(height, width))),
        _ => Err(wrong(format!(
            "has an attribute `{NAME}` that is not (height, width)"
        ))),
    }
}
