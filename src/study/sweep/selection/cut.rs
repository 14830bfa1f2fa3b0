//! Points on parts of their scenes: what a rung of a search looks at.
//!
//! A part of a scene is some frames of it, and the square of the array in which most changes there.
//! A hash draws the frame that it begins with, in proportion to how much changes in the part; and it
//! lasts long enough that what matches is more than chance. A scene that is too small for that is
//! looked at whole beside the parts of others.

use std::sync::Arc;

use serde_json::json;
use sha2::{Digest, Sha256};

use crate::{
    rng::Hash,
    study::sweep::{
        points::plan::{Entry, Plan},
        results::error::{Kept, StoreError},
        scene::cached_scene::{CachedScene, Part, hex},
        study_file::study::Settings,
    },
    unit::Micros,
};

/// More of a scene than this is no part of it, and a rung that sees more of all of them is left
/// out: it saves too little.
const MUCH: f64 = 0.5;

/// The fewest frames of a part, and the fewest rows and columns.
const LEAST_FRAMES: u64 = 5;
const LEAST_SIDE: usize = 24;

/// The least time of a part, in windows of matches: within one, any event matches any other of its
/// cell, and nothing is more than chance.
const LEAST_WINDOWS: f64 = 2.0;

/// The fewest frames of a part of a scene whose events are matched within a window.
fn least_frames(scene: &CachedScene, within: Micros) -> u64 {
    let steps = scene.frames.saturating_sub(1) as f64;
    let windows = LEAST_WINDOWS * within.0 as f64 / 1e6;
    // Two windows of ten frames are twenty, however they are rounded; `as` saturates, also where a
    // scene has no length.
    let frames = (windows / scene.seconds * steps - 1e-6).ceil() as u64;
    frames.saturating_add(1).max(LEAST_FRAMES)
}

/// How much of a scene is looked at.
#[derive(Clone, Copy, Debug)]
struct Extent {
    frames: u64,
    /// Rows and columns.
    size: (usize, usize),
    /// As a share of all frames and the whole array.
    share: f64,
}

impl Extent {
    /// Of about a part of a scene, and of so many frames at least; `whole_array`: of its frames
    /// alone. All of it where that would be much.
    fn new(scene: &CachedScene, part: f64, least: u64, whole_array: bool) -> Self {
        let each = if whole_array { part } else { part.sqrt() };
        let all = scene.frames;
        let frames = ((each * all as f64).ceil() as u64).max(least).min(all);
        let space = if whole_array {
            1.0
        } else {
            (part * all as f64 / frames as f64).min(1.0).sqrt()
        };
        let side = |length: usize| {
            let side = (space * length as f64).ceil() as usize;
            // An even number: patterns of sensors are 2x2.
            side.max(LEAST_SIDE).next_multiple_of(2).min(length)
        };
        let size = (side(scene.size.height), side(scene.size.width));
        let pixels = scene.size.pixels() as f64;
        let share = frames as f64 / all as f64 * (size.0 * size.1) as f64 / pixels;
        if share > MUCH {
            return Self {
                frames: all,
                size: (scene.size.height, scene.size.width),
                share: 1.0,
            };
        }
        Self {
            frames,
            size,
            share,
        }
    }

    fn is_whole(self) -> bool {
        self.share >= 1.0
    }
}

/// What is shown of a scene.
#[derive(Clone, Debug)]
struct Shown {
    extent: Extent,
    scene: Arc<CachedScene>,
}

impl Shown {
    /// Of a scene, from a frame on that the hash draws.
    fn new(scene: &Arc<CachedScene>, extent: Extent, hash: Hash) -> Kept<Self> {
        if extent.is_whole() {
            let scene = Arc::clone(scene);
            return Ok(Self { extent, scene });
        }
        let Extent { frames, size, .. } = extent;
        let first = scene.start(frames, hash);
        let part = Part {
            frames: first..first + frames,
            size,
        };
        let cut = scene.cut(&part).map_err(|cause| StoreError::Scene {
            scene: scene.name().to_owned(),
            cause: Box::new(cause),
        })?;
        let scene = Arc::new(cut);
        Ok(Self { extent, scene })
    }
}

/// Points on parts of their scenes.
pub(super) struct Cut {
    pub plan: Plan,
    /// What each point sees, and of how many frames.
    seen: Vec<(Extent, u64)>,
    /// Whether some see a part and some the whole.
    is_mixed: bool,
}

impl Cut {
    /// Of these points of a plan; none where that would be much of all that they would see whole.
    ///
    /// # Errors
    /// When a scene cannot be read any more.
    pub fn new(plan: &Plan, left: &[usize], (part, hash): (f64, Hash)) -> Kept<Option<Self>> {
        let points = left.iter().filter_map(|i| plan.entries.get(*i));
        let points: Vec<(&Entry, Extent)> = points
            .map(|entry| {
                // Slots are the whole array's.
                let whole_array = entry.point.word("readout") == Some("chip");
                let within = plan.study.settings.headline(entry.scene.fps);
                let least = least_frames(&entry.scene, within);
                (entry, Extent::new(&entry.scene, part, least, whole_array))
            })
            .collect();
        let sum = |frames: &dyn Fn(Extent) -> f64| -> f64 {
            let each = points.iter();
            each.map(|(entry, extent)| frames(*extent) * entry.scene.frames as f64)
                .sum()
        };
        if sum(&|extent| extent.share) > MUCH * sum(&|_| 1.0) {
            return Ok(None);
        }
        let mut scenes: Vec<(&str, (usize, usize), u64, Shown)> = Vec::new();
        let mut entries = Vec::new();
        let mut seen = Vec::new();
        for (entry, extent) in points {
            let digest = &*entry.scene.digest;
            let found = scenes.iter().find(|(known, size, frames, _)| {
                *known == digest && (*size, *frames) == (extent.size, extent.frames)
            });
            let shown = if let Some((.., shown)) = found {
                shown.clone()
            } else {
                let shown = Shown::new(&entry.scene, extent, hash)?;
                scenes.push((digest, extent.size, extent.frames, shown.clone()));
                shown
            };
            let scene = shown.scene;
            seen.push((shown.extent, entry.scene.frames));
            entries.push(Entry {
                id: identity(entry, &scene, &plan.study.settings),
                task: format!("{} {}", entry.task, scene.digest),
                scene,
                ..entry.clone()
            });
        }
        let mut study = plan.study.clone();
        study.settings = Settings {
            threshold_equivalent: false,
            tolerance: None,
            ..study.settings
        };
        let named = entries.len() as u64;
        let whole = seen.iter().filter(|(extent, _)| extent.is_whole()).count();
        Ok(Some(Self {
            plan: Plan {
                study,
                entries,
                named,
            },
            is_mixed: (1..seen.len()).contains(&whole),
            seen,
        }))
    }

    /// What each point sees, by its identity here, in frames of the whole sensor.
    pub fn looks(&self) -> impl Iterator<Item = (&str, f64)> {
        let looks = self.plan.entries.iter().zip(&self.seen);
        looks.map(|(entry, (extent, frames))| (&*entry.id, extent.share * *frames as f64))
    }

    /// Whether a point sees the whole of its scene.
    pub fn is_whole(&self, point: usize) -> bool {
        let seen = self.seen.get(point);
        seen.is_some_and(|(extent, _)| extent.is_whole())
    }

    /// How many do.
    pub fn whole(&self) -> usize {
        let seen = self.seen.iter();
        seen.filter(|(extent, _)| extent.is_whole()).count()
    }

    /// By how much a cost of a point is multiplied: where parts stand beside whole scenes, costs
    /// that grow with what is seen are counted up to the whole.
    pub fn counted_up(&self, point: usize, cost: &str) -> f64 {
        let (Some((extent, frames)), true) = (self.seen.get(point), self.is_mixed) else {
            return 1.0;
        };
        let time = extent.frames as f64 / *frames as f64;
        match cost {
            "bits" => 1.0 / extent.share,
            "seconds_per_frame" | "state_memory_bytes" => time / extent.share,
            _ => 1.0,
        }
    }
}

fn identity(entry: &Entry, scene: &CachedScene, settings: &Settings) -> String {
    let all = json!(["rung", entry.id, scene.digest, settings.measured()]);
    hex(&Sha256::digest(all.to_string().as_bytes())[..16])
}

#[cfg(test)]
mod tests {
    use std::{fs, path::Path};

    use super::*;
    use crate::study::sweep::Study;

    fn plan(scenes: &str, folder: &Path) -> Plan {
        let text = format!(
            "scene = {scenes}\nfps = 100\nkernel = \"dvs\"\nthreshold = 8\n[[side]]\nside = \"reference\"\nformat = [\"f64\", \"f32\"]\n"
        );
        let study = Study::parse("study.toml", &text).unwrap();
        Plan::new(study, folder).unwrap()
    }

    const LARGE: &str = "pattern:noise?width=64&height=64&frames=64";
    const SMALL: &str = "pattern:noise?width=24&height=24&frames=6";

    fn cut(plan: &Plan) -> Option<Cut> {
        let all: Vec<usize> = (0..plan.entries.len()).collect();
        Cut::new(plan, &all, (1.0 / 32.0, Hash::new(0))).unwrap()
    }

    #[test]
    fn a_scene_too_small_for_parts_is_looked_at_whole_beside_parts_of_others() {
        let mixed = plan(&format!("[\"{LARGE}\", \"{SMALL}\"]"), Path::new(""));
        let rung = cut(&mixed).unwrap();
        let whole: Vec<bool> = (0..4).map(|point| rung.is_whole(point)).collect();
        let is_small = |entry: &Entry| entry.scene.frames == 6;
        let small: Vec<bool> = mixed.entries.iter().map(is_small).collect();
        assert_eq!((&whole, rung.whole()), (&small, 2));
        for (point, (own, shown)) in mixed.entries.iter().zip(&rung.plan.entries).enumerate() {
            let (_, frames) = rung.looks().nth(point).unwrap();
            let pixels = shown.scene.size.pixels() as f64 / own.scene.size.pixels() as f64;
            assert_eq!(frames, shown.scene.frames as f64 * pixels);
            // What parts cost is counted up to whole scenes.
            let time = shown.scene.frames as f64 / own.scene.frames as f64;
            let up = |cost| rung.counted_up(point, cost);
            assert!((up("bits") * time * pixels - 1.0).abs() < 1e-12);
            assert!((up("state_memory_bytes") * pixels - 1.0).abs() < 1e-12);
            assert_eq!(up("words"), 1.0);
        }
        // All are cut, or none is: costs are compared as they are.
        let large = cut(&plan(&format!("\"{LARGE}\""), Path::new(""))).unwrap();
        assert_eq!((large.whole(), large.counted_up(0, "bits")), (0, 1.0));
        assert!(cut(&plan(&format!("\"{SMALL}\""), Path::new(""))).is_none());
    }

    /// What is longer has less of the array.
    #[test]
    fn parts_last_two_windows_where_the_scene_does() {
        for (frames, seen, side) in [(12, 12, 24), (64, 21, 40), (400, 71, 54)] {
            let scene = format!("\"pattern:noise?width=128&height=128&frames={frames}\"");
            let rung = cut(&plan(&scene, Path::new(""))).unwrap();
            let shown = &rung.plan.entries[0].scene;
            assert_eq!(shown.frames, seen);
            assert_eq!(shown.size.width, side);
            assert!(frames == 12 || shown.seconds > 0.2 - 1e-9);
        }
    }

    /// A scene that is too long to be kept is read again.
    #[test]
    fn a_scene_that_is_gone_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let clip = folder.path().join("clip");
        fs::create_dir(&clip).unwrap();
        for frame in 0..40_u8 {
            let mut picture = b"P5 48 48 255\n".to_vec();
            picture.extend([frame; 48 * 48]);
            fs::write(clip.join(format!("{frame:02}.pgm")), picture).unwrap();
        }
        let mut plan = plan("\"clip\"", folder.path());
        let scene = Arc::new(plan.entries[0].scene.as_if_too_long());
        for entry in &mut plan.entries {
            entry.scene = Arc::clone(&scene);
        }
        assert!(cut(&plan).is_some());
        fs::remove_dir_all(&clip).unwrap();
        let told = Cut::new(&plan, &[0, 1], (1.0 / 32.0, Hash::new(0)));
        let Err(StoreError::Scene { scene, .. }) = told else {
            panic!("a scene that is not there is cut");
        };
        assert_eq!(scene, "clip");
    }
}
