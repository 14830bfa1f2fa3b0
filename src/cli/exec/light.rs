//! What falls on the photodiodes.

use std::{
    cell::{Cell, RefCell},
    path::Path,
};

use miette::miette;

use super::arguments::Arguments;
use crate::{
    cli::{arguments::clip::goes_on, output::files},
    limit::FRAMES,
    plane::{Plane, Size},
    program::{Exposure, Program},
    scene::{
        ASSUMED_FPS, Frame, Image, Observation, Outline, Scene, SceneError, kept::Kept, part::First,
    },
    unit::counted,
};

/// The light, as it is asked for.
pub struct Light {
    pub scene: Option<Box<dyn Scene>>,
    frames: Option<u64>,
    stated: Option<Stated>,
    fps: f64,
}

/// How many frames the program says, where it is not asked what is shown.
#[derive(Clone, Copy, Debug)]
enum Stated {
    /// A clip that was asked for is shown instead.
    Clip(u64),
    /// So many of a pattern that was asked for are shown; it has more.
    Pattern(u64),
}

impl Stated {
    /// What is to be said of it after so many frames.
    fn note(self, frames: u64) -> Option<String> {
        match self {
            Self::Clip(says) if says == frames => None,
            Self::Clip(says) => {
                let whole = format!("the whole clip was run, not the program's frames = {says}");
                Some(if says < frames {
                    format!("{whole}: --frames {says} limits it")
                } else {
                    whole
                })
            }
            Self::Pattern(says) => Some(format!(
                "the pattern was run for the program's frames = {says}: --frames N runs more"
            )),
        }
    }
}

/// What is to be said of how long the light lasts.
#[derive(Debug, Default)]
pub struct Said {
    stated: Cell<Option<Stated>>,
    /// Frames that the clip had, and those that were asked for.
    ended: Cell<Option<(u64, u64)>>,
    /// Words of the shortest and of the longest frame, where the host decides what runs.
    pub words: Cell<Option<(u64, u64)>>,
    /// What is done with the photodiodes.
    pub exposure: Cell<Exposure>,
    /// Whether the program ended before its light did.
    pub left: Cell<bool>,
    /// Whether the debugger was left before the last frame's end.
    pub stopped: Cell<bool>,
    /// What there is to warn of in the text of a program whose host decides.
    pub source: RefCell<Vec<String>>,
    /// What that host wrote, and in which frame.
    pub posts: RefCell<Vec<(u64, String)>>,
}

impl Said {
    /// After a run.
    pub fn set(&self, light: &Lasting) {
        self.stated.set(light.light.stated);
        self.ended.set(light.ended);
    }

    /// Whole sentences.
    pub fn notes(&self, frames: u64) -> Vec<String> {
        let stopped = self.stopped.get();
        let stated = { self.stated.get() }.filter(|_| !stopped);
        let stated = stated.and_then(|stated| stated.note(frames));
        let ended = self.ended.get();
        let ended = ended.map(|(had, asked)| {
            let more = asked - had;
            format!(
                "the clip ends after {}; its last picture was shown for {more} more",
                counted(had, "frame")
            )
        });
        let words = self.words.get().map(|(least, most)| {
            let words = if least == most {
                format!("{} in every frame", counted(least, "word"))
            } else {
                format!("{least} to {most} words in a frame")
            };
            format!("the host decides what runs: {words}")
        });
        let adds = (frames > 1 && self.exposure.get().adds_up()).then(|| {
            "frames read the photodiodes without a reset: on the chip light adds up over them, here each frame is one exposure".to_owned()
        });
        let left = self.left.get().then(|| {
            format!(
                "the program ended after {}, before its light did",
                counted(frames, "frame")
            )
        });
        let stopped = stopped.then(|| {
            format!(
                "the debugger was left in frame {}, before its end",
                frames.saturating_sub(1)
            )
        });
        { stated.into_iter() }
            .chain(ended)
            .chain(stopped)
            .chain(left)
            .chain(adds)
            .chain(words)
            .collect()
    }
}

impl Light {
    pub fn open(
        arguments: &Arguments,
        program: &Program,
        observation: &Observation,
    ) -> miette::Result<Self> {
        let own = program.settings.image.as_ref().map(|image| {
            if image.starts_with("pattern:") {
                return image.clone();
            }
            arguments.source.folder().join(image).display().to_string()
        });
        let samples = arguments.samples.or_fps(program.settings.fps);
        let image = arguments.image.as_deref().or(own.as_deref());
        if let (None, Some(image)) = (&arguments.image, image) {
            files::reads(Path::new(image))?;
        }
        let scene = image
            .map(|spec| samples.open(Some(spec), observation))
            .transpose()?;
        // A program has a rate without light, too.
        let mut changes = samples.written().into_iter();
        let change = changes.find(|(option, _)| *option != "fps");
        if let (None, Some((option, value))) = (&scene, change) {
            return Err(miette!(
                help = "show a scene (--image SCENE); registers are set to the numbers that a file has",
                "--{option} {value}: there is no scene whose light it could change"
            ));
        }
        let found = scene.as_deref().map_or(ASSUMED_FPS, <dyn Scene>::fps);
        let own = program.settings.frames;
        // A clip that was asked for is shown as it is, whatever the program says of its own; a pattern
        // is one where it is said how many frames it has.
        let is_endless = image.is_some_and(goes_on) && !samples.has_slice();
        let clip = arguments.image.is_some()
            && scene
                .as_deref()
                .is_some_and(|scene| !is_endless && scene.frames() != Some(1));
        let is_pattern = arguments.image.is_some() && is_endless;
        let stated = own.filter(|_| arguments.frames.is_none());
        let stated = stated.and_then(|says| match (clip, is_pattern) {
            (true, _) => Some(Stated::Clip(says)),
            (false, true) => Some(Stated::Pattern(says)),
            (false, false) => None,
        });
        let frames = arguments.frames.or(own.filter(|_| !clip));
        if frames == Some(0) {
            return Err(miette!(
                help = "the first frame runs `init`, every later one `frame`",
                "--frames 0: nothing would run"
            ));
        }
        if let Some(asked) = frames.filter(|asked| *asked > FRAMES) {
            return Err(miette!(
                help = "run fewer frames, or a clip of your own in parts",
                "{asked} frames; {FRAMES} frames at most"
            ));
        }
        Ok(Self {
            scene,
            frames,
            stated,
            fps: samples.fps().unwrap_or(found),
        })
    }

    /// Reads its scene, so far as it is shown, into memory, and shows it from there; none where that
    /// takes more than so many bytes.
    pub fn keep(&mut self, most: usize) -> miette::Result<Option<Kept>> {
        let Some(scene) = self.scene.take() else {
            return Ok(None);
        };
        let mut shown = First::new(scene, self.frames.unwrap_or(u64::MAX));
        let kept = Kept::new(&mut shown, most)?;
        self.scene = kept.as_ref().map(|kept| Box::new(kept.scene()) as _);
        Ok(kept)
    }
}

/// The light as a scene. What ends, a still picture or the dark, is there as long as it is asked
/// for; the dark has the size of the array.
pub struct Lasting {
    light: Light,
    /// Frames that the clip had, and those that were asked for.
    ended: Option<(u64, u64)>,
    size: Size,
    /// Frames in all, where the scene has fewer.
    enough: u64,
    given: u64,
    /// The light that goes on when the scene ends, kept only if it may end too soon.
    last: Option<Image>,
}

impl Lasting {
    /// At least so many frames, unless others are asked for.
    pub fn new(light: Light, size: Size, least: u64) -> Self {
        Self {
            size,
            ended: None,
            enough: light.frames.unwrap_or(least),
            light,
            given: 0,
            last: None,
        }
    }

    /// Whether so many frames are enough: then nothing is shown again.
    pub fn lasts(&self, frames: usize) -> bool {
        frames as u64 >= self.enough
    }
}

impl Scene for Lasting {
    fn outline(&self) -> Outline {
        Outline {
            frames: self.light.frames,
            ..Outline::new(self.size, self.light.fps)
        }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        if self.light.frames.is_some_and(|asked| self.given >= asked) {
            return Ok(None);
        }
        let scene = self.light.scene.as_mut();
        let too_short = scene
            .as_ref()
            .is_none_or(|scene| scene.frames().is_none_or(|all| all < self.enough));
        let next = match scene {
            Some(scene) => scene.next_frame()?,
            None => None,
        };
        let index = self.given;
        // Of a still picture nobody needs to be told where no frames are asked for.
        if let (None, true, true, 1..) = (
            &next,
            self.light.scene.is_some(),
            self.light.frames.is_some(),
            index,
        ) && index < self.enough
            && self.ended.is_none()
        {
            self.ended = Some((index, self.enough));
        }
        let frame = match next {
            Some(frame) => frame,
            None if index >= self.enough => return Ok(None),
            None => Frame {
                index,
                seconds: index as f64 / self.light.fps,
                light: { self.last.take() }
                    .unwrap_or_else(|| Plane::zeros(self.size.shape()).into()),
            },
        };
        self.given += 1;
        if too_short && self.given < self.enough {
            self.last = Some(frame.light.clone());
        }
        Ok(Some(frame))
    }
}
