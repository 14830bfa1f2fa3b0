//! Video as it is: no flow is known, so it teaches interpolation only.

use std::{path::PathBuf, sync::Arc};

use amacrine::{
    memory::Budget,
    plane::{Plane, Size},
    scene::{OpenOptions, open},
};
use ndarray::{Array3, s};
use sha2::{Digest, Sha256};

use super::{
    clip::Clip,
    error::SceneError,
    motion::{Draw, Reason},
};

/// One frame of so many is held out: those at the end.
const HELD_OUT: usize = 5;

/// Consecutive frames.
#[derive(Clone, Debug)]
pub struct Video {
    frames: Arc<[Plane<u8>]>,
    /// The first frame, and how many.
    part: (usize, usize),
    path: PathBuf,
}

impl Video {
    /// All frames of whatever the library opens as a scene: a file, a folder of frames, a pattern; within
    /// what may be held.
    ///
    /// # Errors
    /// As those of [`amacrine::scene::open`].
    pub fn open(spec: &str, memory: Budget) -> Result<Self, SceneError> {
        let options = OpenOptions {
            memory: Some(memory),
            ..OpenOptions::default()
        };
        let mut scene = open(spec, &options)?;
        let mut frames = Vec::new();
        while let Some(frame) = scene.next_frame()? {
            frames.push(frame.light.mapv(|v| v.round().clamp(0.0, 255.0) as u8));
        }
        Ok(Self {
            part: (0, frames.len()),
            frames: frames.into(),
            path: PathBuf::from(spec),
        })
    }

    /// SHA-256 of all pixels: what a run was trained with.
    #[must_use]
    pub fn checksum(&self) -> String {
        let mut sum = Sha256::new();
        for frame in self.frames.iter() {
            let (height, width) = frame.dim();
            sum.update((height as u64).to_le_bytes());
            sum.update((width as u64).to_le_bytes());
            sum.update(frame.iter().copied().collect::<Vec<u8>>());
        }
        format!("video {}", super::hex(&sum.finalize()))
    }

    /// The first four fifths, and the rest, which is held out.
    #[must_use]
    pub fn split(&self) -> (Self, Self) {
        let (first, count) = self.part;
        let held = count / HELD_OUT;
        let part = |part| Self {
            part,
            ..self.clone()
        };
        (
            part((first, count - held)),
            part((first + count - held, held)),
        )
    }

    /// Whether clips fit.
    pub(super) fn check(&self, crop: Size, frames: usize) -> Result<(), SceneError> {
        if self.part.1 < frames {
            return Err(SceneError::Short {
                path: self.path.clone(),
                got: self.frames.len(),
                want: frames,
            });
        }
        let own = Size::of(&self.frames[0]);
        if own.height < crop.height || own.width < crop.width {
            return Err(SceneError::SmallVideo {
                path: self.path.clone(),
                own,
                crop,
            });
        }
        Ok(())
    }

    /// Any place, any time.
    pub(super) fn piece(&self, draw: Draw, size: Size, frames: usize) -> Clip {
        let (height, width) = self.frames[0].dim();
        let first = self.part.0 + draw.one_of(Reason::Frame, self.part.1 - frames + 1);
        let top = draw.one_of(Reason::CropY, height - size.height + 1);
        let left = draw.one_of(Reason::CropX, width - size.width + 1);
        let mut light = Array3::zeros((frames, size.height, size.width));
        for (n, mut frame) in light.outer_iter_mut().enumerate() {
            let own =
                self.frames[first + n].slice(s![top..top + size.height, left..left + size.width]);
            frame.zip_mut_with(&own, |to, from| *to = f32::from(*from));
        }
        let name = self.path.file_name().unwrap_or(self.path.as_os_str());
        Clip {
            light,
            flow: None,
            name: name.to_string_lossy().into(),
        }
    }
}
