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
            "more cells fired in one frame than the readout has slots",
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
            format!(
                "all slots of the program would lose {share}; the figures here still count them"
            ),
            "more cells fire in a frame than one scan delivers",
            "have the program read whole bit planes (`amacrine compile --readout planes`), or raise the threshold",
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
            "events came faster than the link sends them, and filled the queue",
            "use a longer queue (fifo, or fifo=unlimited) or a faster link, let the arbiter wait (when-full=stall, with requests=all so that no events of a cell merge), or raise the threshold",
        )
    }

    /// A readout that scans some rows only, and lost events in others.
    #[must_use]
    pub fn rows(subject: &str, lost: u64, kept: u64) -> Self {
        let share = share_lost(lost, kept);
        Self::new(
            About::Rows,
            subject,
            format!("{share} are lost in rows that the readout does not scan"),
            "the program reads only some rows, and cells fired in others",
            "compile it for this scene (--scene), read all rows (`compile --readout planes`, or slots), or ignore this if only those rows matter",
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
                "cells fired {} in rows that the program does not scan",
                counted(lost, "event")
            ),
            "scan those rows, too",
        )
    }

    /// A readout of which this stage cannot keep up.
    #[must_use]
    pub fn late(subject: &str, stage: &str) -> Self {
        Self::new(
            About::Late,
            subject,
            format!("the {stage} of the readout is busy all the time and cannot keep up"),
            "events are lost or delayed more and more; a scan gives events the time of their frame, so no figure shows the delay",
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
