//! The demo for machines.

use serde_json::{Value, json};

use super::{
    Demo,
    choice::{CHOSEN, KERNEL, THRESHOLD},
    showing::{Row, Showing},
};
use crate::{cli::arguments::light, event::address};

impl Demo<'_> {
    /// Every row, and beside them what the event files and pictures are of: the kernel that the
    /// chip can carry, at the rate that the chip would run.
    pub(super) fn json(&self) -> Value {
        let [own, faster] = &self.showings;
        let reference = faster.reference();
        let size = reference.map(|row| row.packet.size);
        let cost = { self.cells.iter() }
            .flat_map(|cell| &cell.programs)
            .find(|program| program.is_chosen())
            .map(|program| program.compiled.cost);
        let rows = self.showings.iter().flat_map(|showing| {
            let row = |row| row_json(row, showing);
            showing.rows.iter().map(row)
        });
        let span = reference.map(|row| row.packet.span);
        json!({
            "scene": "bundled",
            "width": size.map(|size| size.width),
            "height": size.map(|size| size.height),
            "seconds": span.map(|(from, to)| to.seconds() - from.seconds()),
            "kernel": KERNEL,
            "threshold": THRESHOLD,
            "chosen": CHOSEN,
            "rows": rows.collect::<Vec<_>>(),
            "frames": faster.frames,
            "inserted": faster.frames - own.frames,
            "fps": faster.fps,
            "within_us": faster.window.0,
            "words_per_frame": cost.map(|cost| cost.words.0),
            "us_per_frame": cost.map(|cost| cost.micros()),
            "frames_per_s": cost.map(|cost| cost.frames_per_second()),
            "reference": reference.map(|row| row_json(row, faster)),
            "devices": faster.chosen().map(|row| row_json(row, faster)).collect::<Vec<_>>(),
            "written": self.written,
            "light": light::json(&self.observation),
            "warnings": self.warnings,
        })
    }
}

fn row_json(row: &Row<'_>, showing: &Showing<'_>) -> Value {
    let mut json = json!({
        "cell": row.cell.name,
        "domain": row.runs_in(),
        "fps": showing.fps,
        "frames": showing.frames,
        "window_us": showing.window.0,
        "events": row.packet.events.len(),
        "events_per_pixel_per_second": row.per_pixel_second(),
        "bits": address::bits(&row.packet),
        "dropped": row.packet.dropped.total(),
        "emulated_frames_per_s": row.speed,
    });
    if let (Some(chip), Some(object)) = (&row.chip, json.as_object_mut()) {
        let likeness = &chip.likeness;
        let cost = &chip.program.compiled.cost;
        let more = json!({
            "to": chip.program.to,
            "relative_error": chip.program.relative_error,
            "f1": likeness.f1,
            "floor": likeness.floor,
            "kept": likeness.kept,
            "threshold_equivalent_percent": likeness.threshold_equivalent_percent,
            "threshold_equivalent_is_least": likeness.threshold_equivalent_is_least,
            "event_ratio": likeness.event_ratio,
            "words": cost.words.0,
            "us_per_frame": cost.micros(),
            "frames_per_s": cost.frames_per_second(),
        });
        if let Value::Object(more) = more {
            object.extend(more);
        }
    }
    json
}
