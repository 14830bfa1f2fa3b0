//! Opening a scene: the format follows from the name, and the first bytes must agree.

use std::{io::Read, path::Path};

use super::{
    checks,
    decoder::{animation, bundled::bundled_with, folder, mp4, npy, still, y4m},
    error::SceneError,
    frame::Scene,
    light::conversion::Source,
    options::OpenOptions,
    pattern::Pattern,
    shown::shown,
    time::frame_rate::check_rate,
};

/// What opens a scene, as often as a study shows it.
pub type Reopen<'a> = dyn Fn() -> Result<Box<dyn Scene>, SceneError> + 'a;

/// The name of the clip that comes with the library.
const BUNDLED: &str = "bundled";

/// Opens the scene that `spec` names: a file, a folder, `pattern:NAME?key=value&key=value`, or
/// `bundled` for [`bundled`](super::bundled()), where no file is called so.
///
/// A file's kind is what its name says; its first bytes must agree.
///
/// # Errors
/// When the scene cannot be opened, is of an unknown kind, or its header makes no sense.
///
/// # Examples
/// ```
/// use amacrine::scene::{OpenOptions, Scene, open};
///
/// let mut scene = open("pattern:bar?width=32&height=24&frames=3", &OpenOptions::default())?;
/// assert_eq!(scene.size().to_string(), "32x24");
/// while let Some(frame) = scene.next_frame()? {
///     assert_eq!(frame.seconds, frame.index as f64 / scene.fps());
/// }
/// # Ok::<(), amacrine::scene::SceneError>(())
/// ```
pub fn open(spec: &str, options: &OpenOptions) -> Result<Box<dyn Scene>, SceneError> {
    if spec == BUNDLED && !Path::new(spec).exists() {
        return bundled_with(options);
    }
    shown(options.view, whole(spec, options)?)
}

/// The picture that a pattern shows, where it names one: `pattern:pan?image=FILE`.
#[must_use]
pub fn image_of_pattern(spec: &str) -> Option<&str> {
    let (_, keys) = spec.strip_prefix("pattern:")?.split_once('?')?;
    keys.split('&').find_map(|key| key.strip_prefix("image="))
}

/// All of it.
fn whole(spec: &str, options: &OpenOptions) -> Result<Box<dyn Scene>, SceneError> {
    let asked = options.fps;
    asked.map(check_rate).transpose()?;
    if let Some(pattern) = spec.strip_prefix("pattern:") {
        return Ok(Box::new(Pattern::with_options(pattern, *options)?));
    }
    let path = Path::new(spec);
    if spec == "-" {
        return Err(SceneError::NoFile { path: path.into() });
    }
    if spec.contains(['*', '%']) && !path.exists() {
        return Err(SceneError::NoPattern { path: path.into() });
    }
    let data = path
        .metadata()
        .map_err(|cause| SceneError::unreadable(path, cause))?;
    if data.is_dir() {
        let (scene, source) = folder::open(path, *options)?;
        return source.decode(scene, path, options);
    }
    if !data.is_file() {
        return Err(SceneError::NoFile { path: path.into() });
    }
    let kind = FileKind::from_path(path)?;
    kind.check_content(path)?;
    let (scene, source) = match kind {
        FileKind::Y4m => made(y4m::open(path, *options)?),
        FileKind::Npy => made(npy::open(path, *options)?),
        FileKind::Gif => made(animation::open_gif(path, *options)?),
        FileKind::Png if animation::is_apng(path)? => made(animation::open_apng(path, *options)?),
        FileKind::Png | FileKind::Pnm => made(still::open(path, *options)?),
        FileKind::Mp4 => mp4::open(path, *options)?,
    };
    source.decode(scene, path, options)
}

/// A reader, and what it says about its samples.
fn made<S: Scene + 'static>((scene, source): (S, Source)) -> (Box<dyn Scene>, Source) {
    (Box::new(scene), source)
}

/// The formats of files, by extension and by first bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum FileKind {
    Y4m,
    Npy,
    Gif,
    Png,
    Pnm,
    Mp4,
}

impl FileKind {
    const ALL: [Self; 6] = [
        Self::Y4m,
        Self::Npy,
        Self::Gif,
        Self::Png,
        Self::Pnm,
        Self::Mp4,
    ];

    fn from_path(path: &Path) -> Result<Self, SceneError> {
        let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
        match ending.to_string_lossy().as_ref() {
            "y4m" => Ok(Self::Y4m),
            "npy" => Ok(Self::Npy),
            "gif" => Ok(Self::Gif),
            "png" | "apng" => Ok(Self::Png),
            "pgm" | "ppm" | "pnm" => Ok(Self::Pnm),
            "mp4" | "m4v" | "mov" => Ok(Self::Mp4),
            _ => Err(SceneError::UnknownKind { path: path.into() }),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Y4m => "y4m video",
            Self::Npy => "an npy array",
            Self::Gif => "a GIF",
            Self::Png => "a PNG",
            Self::Pnm => "a PGM, PPM or PNM picture",
            Self::Mp4 => "an mp4",
        }
    }

    /// Whether a file of this format can begin with `start`.
    fn begins(self, start: &[u8]) -> bool {
        match self {
            Self::Y4m => start.starts_with(y4m::MAGIC),
            Self::Npy => start.starts_with(crate::npy::MAGIC),
            Self::Gif => start.starts_with(b"GIF8"),
            Self::Png => start.starts_with(b"\x89PNG"),
            Self::Pnm => {
                matches!(start, [b'P', b'1'..=b'7', space, ..] if space.is_ascii_whitespace())
            }
            Self::Mp4 => matches!(start, [_, _, _, _, b'f', b't', b'y', b'p', ..]),
        }
    }

    /// Checks that the first bytes agree with the name.
    fn check_content(self, path: &Path) -> Result<(), SceneError> {
        let mut start = Vec::new();
        checks::open_file(path)?
            .take(16)
            .read_to_end(&mut start)
            .map_err(|cause| SceneError::unreadable(path, cause))?;
        if start.is_empty() {
            return Err(SceneError::Empty {
                path: path.into(),
                missing: "byte",
            });
        }
        if self.begins(&start) {
            return Ok(());
        }
        let found = Self::ALL.into_iter().find(|kind| kind.begins(&start));
        Err(SceneError::Disguised {
            path: path.into(),
            stated: self.name(),
            found: found.map_or("something else", Self::name),
        })
    }
}
