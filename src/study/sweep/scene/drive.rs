//! Points behind the same resistor sheets: what the sheets make of a scene is computed once, and the
//! cells of each point, of the f64 sensor and of a pilot's tiles are shown it in place of light.

use std::sync::Arc;

use super::cached_scene::{CachedScene, Drive};
use crate::{
    number::Format,
    reference::{Description, SheetDrive},
    scene::Frame,
    study::sweep::measurement::{
        limits::{Limits, Stop},
        memo::Shared,
    },
};

/// The most memory that the drive of a scene may take, bytes.
const HELD: usize = 128 << 20;

/// Cells that are shown the drive of sheets.
pub(in crate::study::sweep) struct Driven {
    /// The drive.
    pub scene: Arc<CachedScene>,
    pub description: Description,
    /// Seconds of computing the drive.
    pub seconds: f64,
}

/// The cells of a sensor behind its sheets; none where it has none, or the drive is not all they see,
/// or is too large to be kept.
pub(in crate::study::sweep) fn driven(
    scene: &CachedScene,
    (description, seed, format): (&Description, u64, Format),
    shared: &Shared,
    limits: Limits<'_>,
) -> Option<Driven> {
    if format != Format::F64 && !scene.is_eight_bit {
        return None;
    }
    let cells = description.behind_sheets(format)?;
    let bytes = scene.frames as usize * scene.size.pixels() * size_of::<f64>();
    let may = limits
        .bytes
        .map_or(HELD, |bytes| HELD.min(bytes as usize / 8));
    if bytes > may {
        return None;
    }
    let sheets = description.sheets(seed)?;
    let key = format!("{} {sheets}", scene.digest);
    let made = shared.drive(&key, || {
        let drive = SheetDrive::new(sheets, scene.size);
        computed(scene, drive, key.clone(), limits).ok()
    });
    // What cannot be computed is told by the sensor itself.
    let drive = made.get()?.as_ref()?;
    Some(Driven {
        scene: Arc::clone(&drive.scene),
        description: cells,
        seconds: drive.seconds,
    })
}

fn computed(
    scene: &CachedScene,
    mut drive: SheetDrive,
    digest: String,
    limits: Limits<'_>,
) -> Result<Drive, Stop> {
    let mut frames = Vec::new();
    let mut seconds = 0.0;
    scene.play(|frame| {
        let start = (limits.clock)();
        let light = drive.see(frame)?;
        seconds += (limits.clock)() - start;
        limits.hold(seconds, (scene.size, 1), 0)?;
        let light = light.into();
        frames.push(Frame { light, ..*frame });
        Ok::<(), Stop>(())
    })?;
    Ok(Drive {
        scene: Arc::new(scene.with_planes(frames, digest)),
        seconds,
    })
}
