//! The ways to read a frame's events, as a small table.

use std::fmt::Write as _;

use crate::program::readout::Way;

/// One way to read a frame's events.
pub(in crate::cli) struct Row {
    pub(in crate::cli) way: Way,
    pub(in crate::cli) slots: Option<u64>,
    /// The least and the most, us.
    pub(in crate::cli) us: [f64; 2],
    /// The least and the most frames a second.
    pub(in crate::cli) frames_s: [f64; 2],
    /// Share of the expected events that do not leave the chip; none where nobody says how many
    /// there are.
    pub(in crate::cli) lost: Option<f64>,
    pub(in crate::cli) is_chosen: bool,
}

/// A line for each way, the chosen one marked.
pub(in crate::cli) fn table(rows: impl Iterator<Item = Row>) -> String {
    let mut text = format!(
        "{:<37} {:>16} {:>16}   what comes out\n",
        "a frame's readout", "us", "frames/s"
    );
    for row in rows {
        let mark = if row.is_chosen { "* " } else { "  " };
        let mut carries = row.way.carries().to_owned();
        if let Some(slots) = row.slots {
            carries = format!("events, up to {slots} of each sign and kind");
        }
        match row.lost {
            Some(lost) if lost > 0.0 && !row.way.is_summary() => {
                let _ = write!(carries, "; {:.2} % are lost", 100.0 * lost);
            }
            _ => {}
        }
        let _ = writeln!(
            text,
            "{:<37} {:>16} {:>16}   {carries}",
            format!("{mark}{}", row.way.in_words()),
            between(row.us, 1),
            between(row.frames_s, 0),
        );
    }
    text
}

/// One number, or two where they differ as they are written.
pub(in crate::cli) fn between([low, high]: [f64; 2], decimals: usize) -> String {
    let (low, high) = (format!("{low:.decimals$}"), format!("{high:.decimals$}"));
    if low == high {
        low
    } else {
        format!("{low} to {high}")
    }
}
