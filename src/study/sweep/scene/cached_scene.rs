//! Scenes that many points watch: read once, kept in memory while they are small enough.

use std::{
    fmt::Write as _,
    ops::{ControlFlow, Range},
    path::Path,
    sync::{Arc, OnceLock},
};

use sha2::{Digest, Sha256};

use super::stamp::Stamp;
use crate::{
    photoreceptor::Response,
    plane::{Plane, Size},
    rig::{self, guard::Warning},
    rng::Hash,
    scene::{
        Coding, Frame, Image, Observation, Observed, OpenOptions, SceneError, View, bundled_with,
        held::Held, kept::Kept, open, part::First, upsample,
    },
};

/// A scene as a study names it.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::study::sweep) struct Wanted {
    /// `bundled`, or what `scene::open` takes.
    pub spec: String,
    pub fps: Option<f64>,
    pub frames: Option<u64>,
    pub coding: Coding,
    pub view: View,
    pub upsample: Option<f64>,
}

/// A scene that can be watched again and again.
#[derive(Debug)]
pub(in crate::study::sweep) struct CachedScene {
    wanted: Wanted,
    /// The name under which it is opened.
    spec: String,
    /// The files that it was made of.
    stamp: Stamp,
    pub size: Size,
    /// Frames, those that were inserted among them.
    pub frames: u64,
    /// Frames a second of the source.
    pub fps: f64,
    /// From the first frame to the last.
    pub seconds: f64,
    /// How much changes from each frame to the next.
    changes: Vec<f64>,
    /// A digest of its light: two files of the same pictures are one scene.
    pub digest: String,
    /// Whether all light is whole numbers from 0 to 255.
    pub is_eight_bit: bool,
    observation: Observation,
    held: Option<Arc<Vec<Frame>>>,
    /// Kept for pilots, a byte a pixel.
    kept: OnceLock<Kept>,
}

/// The most memory that one scene may take, bytes.
const HELD: usize = 512 << 20;

impl CachedScene {
    /// Opens a scene; files are looked for in `folder`. It is watched once, for its digest.
    pub fn open(wanted: &Wanted, folder: &Path) -> Result<Self, SceneError> {
        let spec = located(&wanted.spec, folder)?;
        let stamp = Stamp::of(&spec);
        let mut digest = Sha256::new();
        let mut held = Some(Vec::new());
        let (mut frames, mut size) = (0, Size::new(0, 0));
        let mut bytes = Vec::new();
        let mut is_eight_bit = true;
        let (mut begin, mut end) = (None, 0.0);
        let mut before: Option<Image> = None;
        let mut changes = Vec::new();
        // `as` saturates.
        let is_byte = |light: &f64| f64::from(*light as u8).to_bits() == light.to_bits();
        let observation = Observation::new();
        let fps = play(&spec, wanted, &observation, &mut |frame| {
            size = frame.light.size();
            // What is held has no numbers beside its codes until somebody looks at them.
            let light = frame.light.clone();
            bytes.clear();
            bytes.extend(frame.seconds.to_le_bytes());
            bytes.extend(light.iter().flat_map(|light| light.to_le_bytes()));
            digest.update(&bytes);
            is_eight_bit = is_eight_bit && light.iter().all(is_byte);
            end = frame.seconds;
            begin.get_or_insert(end);
            changes.extend(before.as_ref().map(|before| change(before, &light)));
            before = Some(light);
            frames += 1;
            let room = HELD / (size.pixels() * size_of::<f64>()).max(1);
            held = held.take().filter(|held| held.len() < room);
            if let Some(held) = &mut held {
                held.push(frame);
            }
            Ok::<(), SceneError>(())
        })?;
        stamp.check(&spec)?;
        digest.update(size.height.to_le_bytes());
        digest.update(size.width.to_le_bytes());
        Ok(Self {
            wanted: wanted.clone(),
            spec,
            stamp,
            size,
            frames,
            fps,
            seconds: end - begin.unwrap_or(end),
            changes,
            digest: hex(&digest.finalize()),
            is_eight_bit,
            observation,
            held: held.map(Arc::new),
            kept: OnceLock::new(),
        })
    }

    /// As the study names it.
    pub fn name(&self) -> &str {
        &self.wanted.spec
    }

    /// Bytes of the frames that are kept.
    pub fn bytes(&self) -> u128 {
        let frames = self.held.as_ref().map_or(0, |held| held.len());
        (frames * self.size.pixels() * size_of::<f64>()) as u128
    }

    /// What the scene warns of, under its own name.
    pub fn warnings(&self) -> Vec<Warning> {
        let mut warnings = Warning::of_scene(&self.observation, Response::IDENTITY);
        warnings.extend(Warning::assumed_rate(&self.observation, "the key `fps`"));
        warnings.extend(Warning::short(&self.observation, self.wanted.frames));
        for warning in &mut warnings {
            warning.subjects = vec![self.wanted.spec.clone()];
        }
        warnings
    }

    /// The scene for a pilot to look at; none where it is too long to be kept.
    pub fn kept(&self) -> Result<Option<Kept>, SceneError> {
        if let Some(kept) = self.kept.get() {
            return Ok(Some(kept.clone()));
        }
        let mut frames = Vec::new();
        let least = self.frames as usize * self.size.pixels();
        if least > HELD {
            return Ok(None);
        }
        self.play(|frame| {
            frames.push(frame.clone());
            Ok::<(), SceneError>(())
        })?;
        let kept = Kept::new(&mut Held::new(frames, self.size, self.fps), HELD)?;
        if let Some(kept) = kept.as_ref().filter(|_| self.is_eight_bit) {
            self.kept.get_or_init(|| kept.clone());
        }
        Ok(kept)
    }

    /// The frame that a part of so many frames begins with, drawn by the hash in proportion to how
    /// much changes in the part: where all changes evenly, or nothing does, any is as likely.
    pub fn start(&self, frames: u64, hash: Hash) -> u64 {
        let starts = self.frames.saturating_sub(frames) + 1;
        let mut ends = vec![0.0];
        let mut sum = 0.0;
        for change in &self.changes {
            sum += change;
            ends.push(sum);
        }
        let far = frames.saturating_sub(1) as usize;
        let in_part = |first: u64| {
            let at = |frame: usize| ends.get(frame).copied().unwrap_or(sum);
            at(first as usize + far) - at(first as usize)
        };
        let all: f64 = (0..starts).map(in_part).sum();
        if !(all > 0.0 && all.is_finite()) {
            return (hash.uniform() * starts as f64) as u64;
        }
        let mut left = hash.uniform() * all;
        let mut last = 0;
        for first in 0..starts {
            let own = in_part(first);
            if own > 0.0 {
                last = first;
            }
            left -= own;
            if left < 0.0 {
                break;
            }
        }
        last
    }

    /// Some frames, and of the array the window in which most changes in them.
    pub fn cut(&self, part: &Part) -> Result<Self, SceneError> {
        let (height, width) = part.size;
        let mut frames: Vec<Frame> = Vec::new();
        let mut number = 0;
        self.play(|frame| {
            if part.frames.contains(&number) {
                frames.push(frame.clone());
            }
            number += 1;
            Ok::<(), SceneError>(())
        })?;
        let mut moved = Plane::zeros(self.size.shape());
        for pair in frames.windows(2) {
            if let [a, b] = pair {
                ndarray::Zip::from(&mut moved)
                    .and(&*a.light)
                    .and(&*b.light)
                    .for_each(|sum, a, b| *sum += (b - a).abs());
            }
        }
        let (top, left) = busiest(&moved, height, width);
        let mut digest = Sha256::new();
        digest.update(&self.digest);
        digest.update(format!("{part:?} {top} {left}"));
        for frame in &mut frames {
            let rows = ndarray::s![top..top + height, left..left + width];
            frame.light = frame.light.slice(rows).to_owned().into();
        }
        let mut moments = frames.iter().map(|frame| frame.seconds);
        let first = moments.next().unwrap_or_default();
        Ok(Self {
            wanted: self.wanted.clone(),
            spec: self.spec.clone(),
            stamp: self.stamp.clone(),
            size: Size::new(height, width),
            frames: frames.len() as u64,
            fps: self.fps,
            seconds: moments.last().unwrap_or(first) - first,
            // Of the whole array: a part is not cut again.
            changes: Vec::new(),
            digest: hex(&digest.finalize()),
            is_eight_bit: self.is_eight_bit,
            observation: Observation::new(),
            held: Some(Arc::new(frames)),
            kept: OnceLock::new(),
        })
    }

    /// The same frames with other planes in the place of light, under another digest.
    pub fn with_planes(&self, frames: Vec<Frame>, digest: String) -> Self {
        Self {
            wanted: self.wanted.clone(),
            spec: self.spec.clone(),
            stamp: self.stamp.clone(),
            size: self.size,
            frames: self.frames,
            fps: self.fps,
            seconds: self.seconds,
            changes: self.changes.clone(),
            digest,
            is_eight_bit: false,
            observation: Observation::new(),
            held: Some(Arc::new(frames)),
            kept: OnceLock::new(),
        }
    }

    /// The same scene, none of whose frames are kept.
    #[cfg(test)]
    pub fn as_if_too_long(&self) -> Self {
        Self {
            held: None,
            ..self.with_planes(Vec::new(), self.digest.clone())
        }
    }

    /// Shows every frame; of a scene that is read again, whose files may be others by now, the
    /// frames are of no use before its end.
    ///
    /// # Errors
    /// When the scene cannot be read, or is not what it was, and what `see` says.
    pub fn play<E: From<SceneError>>(
        &self,
        mut see: impl FnMut(&Frame) -> Result<(), E>,
    ) -> Result<(), E> {
        if let Some(held) = &self.held {
            return held.iter().try_for_each(see);
        }
        self.stamp.check(&self.spec)?;
        let see = &mut |frame: Frame| see(&frame);
        let played = play(&self.spec, &self.wanted, &self.observation, see);
        self.stamp.check(&self.spec)?;
        played.map(|_| ())
    }
}

/// Some frames of a scene, and the rows and columns of a window.
#[derive(Clone, Debug)]
pub(in crate::study::sweep) struct Part {
    pub frames: Range<u64>,
    pub size: (usize, usize),
}

/// How much changes from one picture to the next: squares, so that noise of all pixels weighs
/// little beside what moves in a few.
fn change(before: &Image, after: &Image) -> f64 {
    let pairs = before.iter().zip(after.iter());
    pairs.map(|(a, b)| (b - a) * (b - a)).sum()
}

/// Steps in which a window is moved, as a part of its side.
const STEPS: usize = 4;

/// The upper left corner of the window with the largest sum, from even places on.
fn busiest(plane: &Plane<f64>, height: usize, width: usize) -> (usize, usize) {
    let (rows, columns) = plane.dim();
    let places = |side: usize, length: usize| {
        let step = (side / STEPS).next_multiple_of(2).max(2);
        let last = (length - side) & !1;
        (0..last).step_by(step).chain([last])
    };
    let mut best = (f64::NEG_INFINITY, (0, 0));
    for top in places(height, rows) {
        for left in places(width, columns) {
            let window = ndarray::s![top..top + height, left..left + width];
            let sum = plane.slice(window).sum();
            if sum > best.0 {
                best = (sum, (top, left));
            }
        }
    }
    best.1
}

/// Files are beside the study.
fn located(spec: &str, folder: &Path) -> Result<String, SceneError> {
    if spec == "bundled" || spec.starts_with("pattern:") {
        return Ok(spec.to_owned());
    }
    let path = folder.join(spec).into_os_string().into_string();
    path.map_err(|path| SceneError::NotUtf8 { path: path.into() })
}

/// Plays a scene from its start; its frames a second.
fn play<E: From<SceneError>>(
    spec: &str,
    wanted: &Wanted,
    observation: &Observation,
    see: &mut dyn FnMut(Frame) -> Result<(), E>,
) -> Result<f64, E> {
    let options = OpenOptions {
        fps: wanted.fps,
        coding: wanted.coding,
        view: wanted.view,
        ..OpenOptions::default()
    };
    let scene = if spec == "bundled" {
        bundled_with(&options)?
    } else {
        open(spec, &options)?
    };
    let observed = Observed::new(scene, observation);
    let read = First::new(observed, wanted.frames.unwrap_or(u64::MAX));
    let mut scene = upsample::by_contrast(read, wanted.upsample)?;
    let fps = scene.fps();
    rig::play(&mut scene, |frame| {
        see(frame).map(|()| ControlFlow::Continue(()))
    })?;
    Ok(fps)
}

/// Bytes as text.
pub(in crate::study::sweep) fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// The drive of sheets over a scene.
#[derive(Debug)]
pub(in crate::study::sweep) struct Drive {
    pub scene: Arc<CachedScene>,
    /// Seconds of computing it.
    pub seconds: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(changes: Vec<f64>) -> CachedScene {
        let wanted = Wanted {
            spec: "pattern:disc?width=24&height=24&frames=40".to_owned(),
            fps: None,
            frames: None,
            coding: Coding::default(),
            view: View::default(),
            upsample: None,
        };
        let opened = CachedScene::open(&wanted, Path::new("")).unwrap();
        assert_eq!(opened.changes.len(), changes.len());
        assert!((opened.seconds - 39.0 / opened.fps).abs() < 1e-9);
        CachedScene { changes, ..opened }
    }

    #[test]
    fn parts_are_drawn_in_proportion_to_what_changes_in_them() {
        // Of 11 frames: 30 of them.
        let starts = |changes: Vec<f64>| {
            let scene = scene(changes);
            let mut drawn = [0; 30];
            for seed in 0..6000 {
                drawn[scene.start(11, Hash::new(seed)) as usize] += 1;
            }
            drawn
        };
        let near =
            |drawn: i32, expected: f64| (f64::from(drawn) - expected).abs() < 5.0 * expected.sqrt();
        for changes in [vec![3.0; 39], vec![0.0; 39], vec![f64::NAN; 39]] {
            let drawn = starts(changes);
            assert!(drawn.iter().all(|drawn| near(*drawn, 200.0)), "{drawn:?}");
        }
        // Between frames 25 and 28: three steps, the first of them seen from frame 15 on.
        let mut burst = vec![0.0; 39];
        burst[25..28].fill(7.0);
        for (start, drawn) in starts(burst).into_iter().enumerate() {
            let seen = (25..28).filter(|step| (start..start + 10).contains(step));
            let expected = 6000.0 / 33.0 * seen.count() as f64;
            assert!(
                near(drawn, expected) || drawn == 0 && expected == 0.0,
                "{start}: {drawn}"
            );
        }
        let whole = scene(vec![1.0; 39]);
        assert_eq!(whole.start(40, Hash::new(1)), 0);
    }
}
