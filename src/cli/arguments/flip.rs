//! `--flip`: columns, rows or both in the other direction.

use std::str::FromStr;

use crate::{event::Event, plane::Size};

/// Which coordinates are counted from the other side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flip {
    columns: bool,
    rows: bool,
}

impl FromStr for Flip {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (columns, rows) = match text {
            "x" => (true, false),
            "y" => (false, true),
            "xy" => (true, true),
            _ => return Err("give x (columns), y (rows) or xy (both: half a turn)".into()),
        };
        Ok(Self { columns, rows })
    }
}

impl Flip {
    /// An event of a sensor of this size, which has a pixel for it.
    pub const fn of(self, event: Event, size: Size) -> Event {
        let mut flipped = event;
        if self.columns {
            flipped.x = (size.width - 1) as u16 - event.x;
        }
        if self.rows {
            flipped.y = (size.height - 1) as u16 - event.y;
        }
        flipped
    }
}
