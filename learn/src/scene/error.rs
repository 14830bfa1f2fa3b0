//! Photographs and videos that make no clips.

use std::path::PathBuf;

use amacrine::plane::Size;

use super::photographs::FEWEST;

/// Photographs or a video that make no clips.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum SceneError {
    /// A folder that cannot be read.
    #[error("{}: {cause}", path.display())]
    #[diagnostic(help("give a folder of photographs, PNG or JPEG"))]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Why not.
        cause: std::io::Error,
    },
    /// A folder without photographs.
    #[error("{}: no photographs in it", path.display())]
    #[diagnostic(help("put at least {FEWEST} files there whose names end in .png, .jpg or .jpeg"))]
    Empty {
        /// The folder.
        path: PathBuf,
    },
    /// Too few photographs.
    #[error("{}: {count} photographs, at least {FEWEST} are needed", path.display())]
    #[diagnostic(help(
        "add {} more: a fifth is held out for the verdict, the rest is trained with",
        FEWEST.saturating_sub(*count)
    ))]
    Few {
        /// The folder.
        path: PathBuf,
        /// How many there are.
        count: usize,
    },
    /// A file that is no picture.
    #[error("{}: no picture that can be read: {cause}", path.display())]
    #[diagnostic(help("remove the file, or save it as PNG or JPEG"))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why not.
        cause: image::ImageError,
    },
    /// A photograph without room for a crop.
    #[error("{}: {own}, smaller than a crop of {crop}", path.display())]
    #[diagnostic(help("remove the photograph, or take a smaller crop"))]
    Small {
        /// The file.
        path: PathBuf,
        /// Its size.
        own: Size,
        /// That of a crop.
        crop: Size,
    },
    /// A video without room for a crop.
    #[error("{}: frames of {own}, smaller than a crop of {crop}", path.display())]
    #[diagnostic(help("take a larger video, or a smaller `crop`; [test] has one of its own"))]
    SmallVideo {
        /// The video.
        path: PathBuf,
        /// The size of its frames.
        own: Size,
        /// That of a crop.
        crop: Size,
    },
    /// Too few frames for a middle one between two others.
    #[error("a clip of {frames} frames has no frame between two others; at least 3 are needed")]
    Frames {
        /// How many were asked for.
        frames: usize,
    },
    /// A crop without pixels.
    #[error("a crop of {crop} has no pixels; a side is at least 1")]
    Crop {
        /// What was asked for.
        crop: Size,
    },
    /// A video that the library cannot open.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Video(#[from] amacrine::scene::SceneError),
    /// A video too short to be split into two parts.
    #[error("{}: {got} frames; a fifth of them is held out, and each part needs {want}", path.display())]
    #[diagnostic(help("give a longer video, or shorter clips"))]
    Short {
        /// The video.
        path: PathBuf,
        /// Its frames.
        got: usize,
        /// Frames of a clip.
        want: usize,
    },
}
