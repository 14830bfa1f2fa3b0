//! What a readout is warned of.

use super::{About, Warning};
use crate::unit::counted;

impl Warning {
    /// A readout that lost events.
    #[must_use]
    pub fn slots(subject: &str, lost: u64, kept: u64) -> Self {
        let share = share_lost(lost, kept);
        Self::new(
            About::Slots,
            subject,
            format!("the readout's slots were full: {share} are lost"),
            "more cells fired in a frame than were asked for",
            "ask for more slots, raise the threshold, or read whole bit planes",
        )
    }

    /// A program whose events were all counted, and whose own readout loses some of them.
    #[must_use]
    pub fn own_slots(subject: &str, lost: u64, all: u64) -> Self {
        let share = share_lost(lost, all.saturating_sub(lost));
        Self::new(
            About::Slots,
            subject,
            format!("all slots of the program would lose {share}; what is told counts them"),
            "more cells fire in a frame than one scan delivers",
            "have the program read whole bit planes (amacrine compile --readout planes), or raise the threshold",
        )
    }

    /// A readout whose queue lost events.
    #[must_use]
    pub fn queue(subject: &str, lost: u64, kept: u64) -> Self {
        let share = share_lost(lost, kept);
        Self::new(
            About::Queue,
            subject,
            format!("the readout's queue was full: {share} are lost"),
            "events came faster than the link sends them, and more than the queue holds",
            "give a longer queue (fifo, or fifo=unlimited) or a faster link, let the arbiter wait (when-full=stall, with requests=all so that a cell's events do not merge meanwhile), or raise the threshold",
        )
    }

    /// A readout that scans some rows only, and lost events in others.
    #[must_use]
    pub fn rows(subject: &str, lost: u64, kept: u64) -> Self {
        let share = share_lost(lost, kept);
        Self::new(
            About::Rows,
            subject,
            format!("the readout scans some rows only: {share} lie in others and are lost"),
            "cells fired in rows that the program does not read",
            "compile it for this scene (--scene), read all rows (compile --readout planes, or slots), or leave it so where only these rows are wanted",
        )
    }

    /// A readout without an event, since all of them lie in rows that it does not scan.
    #[must_use]
    pub fn no_events_in_rows(subject: &str, frames: u64, lost: u64) -> Self {
        Self::new(
            About::NoEvents,
            subject,
            format!("no event at all in {}", counted(frames, "frame")),
            format!(
                "its cells made {}, in rows that the program does not scan",
                counted(lost, "event")
            ),
            "scan the rows in which they lie",
        )
    }

    /// A readout of which this stage cannot keep up.
    #[must_use]
    pub fn late(subject: &str, stage: &str) -> Self {
        Self::new(
            About::Late,
            subject,
            format!("the {stage} of the readout is busy all the time and cannot keep up"),
            "events are lost or leave later and later; what a scan reads keeps the time of its frame, so that no figure tells how late it is",
            "take fewer slots, a faster readout, or a lower frame rate",
        )
    }
}

/// How many of all events were lost.
fn share_lost(lost: u64, kept: u64) -> String {
    let all = lost.saturating_add(kept);
    let share = 100.0 * lost as f64 / all as f64;
    format!("{lost} of {all} events ({share:.1} %)")
}
