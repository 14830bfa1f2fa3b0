//! Event files and pictures.

use std::path::{Path, PathBuf};

use crate::{
    event::{Packet, file},
    picture::{Moment, Show, contact_sheet, write_animation, write_png},
    scene::Frame,
    unit::Micros,
};

use super::{
    cell::is_shown,
    choice::{CHOSEN, DOMAINS},
    showing::{Row, Showing},
};

/// A picture for every tenth of a second: the frame at its end, the events in it.
#[derive(Default)]
pub(super) struct Moments {
    pub kept: Vec<Moment>,
    from: f64,
}

impl Moments {
    pub fn see(&mut self, frame: &Frame) {
        // The clip's own frames are a tenth of a second apart, to the last bit but one.
        if frame.seconds + 1e-9 < self.from + 0.1 {
            return;
        }
        let light = frame.light.clone().into_plane();
        self.kept.push(Moment {
            from: Micros::from_seconds(self.from),
            to: Micros::from_seconds(frame.seconds),
            frame: light,
        });
        self.from = frame.seconds;
    }
}

/// The event files: the float sensor's first.
pub(super) fn events(out: &Path) -> Vec<[PathBuf; 2]> {
    let names = std::iter::once("reference").chain(DOMAINS.iter().map(|(domain, _)| *domain));
    names
        .map(|name| ["csv", "npy"].map(|kind| out.join(format!("{name}.{kind}"))))
        .collect()
}

/// The pictures.
pub(super) fn pictures(out: &Path) -> [PathBuf; 3] {
    ["row.png", "sheet.png", "watch.gif"].map(|name| out.join(name))
}

/// Writes events and pictures of the kernel that the chip can carry; returns what was written.
pub(super) fn write(
    out: &Path,
    showing: &Showing<'_>,
    moments: &[Moment],
) -> miette::Result<Vec<PathBuf>> {
    let mut written = Vec::new();
    let rows: Vec<&Row<'_>> = showing
        .reference()
        .into_iter()
        .chain(showing.chosen())
        .collect();
    for (paths, row) in events(out).into_iter().zip(&rows) {
        for path in paths {
            file::write(&path, &row.packet)?;
            written.push(path);
        }
    }
    let shown = rows.iter().find(|row| is_shown(row.domain()));
    let (Some(reference), Some(shown)) = (rows.first(), shown) else {
        return Ok(written);
    };
    let title = format!(
        "A clip at {} frames/s, seen by ganglion cells: the float model, and its program on a SCAMP-5 array",
        showing.fps
    );
    let device = format!("array in {CHOSEN}, with its errors");
    let show = Show {
        title: &title,
        reference: ("float reference", &reference.packet),
        device: (&device, &shown.packet),
    };
    let [row, sheet, animation] = pictures(out);
    let busiest = busiest(moments, &reference.packet);
    let first = busiest.get(..1).unwrap_or_default();
    write_png(&row, &contact_sheet(&show, first)?)?;
    write_png(&sheet, &contact_sheet(&show, &busiest)?)?;
    write_animation(&animation, &show, moments, 0.1)?;
    written.extend([row, sheet, animation]);
    Ok(written)
}

/// The four moments with most events, in order of time.
fn busiest(moments: &[Moment], truth: &Packet) -> Vec<Moment> {
    let events = |moment: &Moment| {
        let inside = |t: Micros| moment.from < t && t <= moment.to;
        truth.events.iter().filter(|event| inside(event.t)).count()
    };
    let mut busiest = moments.to_vec();
    busiest.sort_by_cached_key(|moment| std::cmp::Reverse(events(moment)));
    busiest.truncate(4);
    busiest.sort_by_key(|moment| moment.from);
    busiest
}
