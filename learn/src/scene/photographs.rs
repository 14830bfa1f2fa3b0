//! Photographs: bundled or from a folder, split by the hash of their names.

use std::{
    io::Cursor,
    path::{Path, PathBuf},
    sync::Arc,
};

use amacrine::plane::{Plane, Size};
use image::{DynamicImage, ImageReader};
use sha2::{Digest, Sha256};

use super::error::SceneError;

/// The fewest photographs that a folder may have.
pub const FEWEST: usize = 8;

/// One photograph of so many is held out.
const HELD_OUT: usize = 5;

/// Photographs whose shorter side is at least twice this are halved.
const SIDE: usize = 400;

/// The endings of the files that are taken, in lower case.
const ENDINGS: [&str; 3] = ["png", "jpg", "jpeg"];

macro_rules! bundled {
    ($($name:literal),*) => {
        [$(($name, include_bytes!(concat!("../../photographs/", $name)).as_slice())),*]
    };
}

/// `learn/photographs/README.md` says where they come from.
const BUNDLED: [(&str, &[u8]); 10] = bundled![
    "astronaut.jpg",
    "brick.jpg",
    "camera.jpg",
    "chelsea.jpg",
    "clock.jpg",
    "coffee.jpg",
    "grass.jpg",
    "gravel.jpg",
    "rocket.jpg",
    "seeding.jpg"
];

/// A photograph.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Photograph {
    /// Its file name.
    pub name: Arc<str>,
    /// Where it is.
    path: PathBuf,
    /// Its light, 0 to 255, by Rec. 601.
    pub light: Plane<u8>,
}

/// Photographs in the order of their names.
#[derive(Clone, Debug)]
pub struct Photographs(Arc<[Photograph]>);

impl Photographs {
    /// Those that come with the program.
    ///
    /// # Errors
    /// Never, unless the program was built with a damaged file.
    pub fn bundled() -> Result<Self, SceneError> {
        let read = |(name, bytes): &(&str, &[u8])| {
            let path = Path::new("learn/photographs").join(name);
            decode(&path, bytes)
        };
        let all: Vec<_> = BUNDLED.iter().map(read).collect::<Result<_, _>>()?;
        Ok(Self(all.into()))
    }

    /// All PNG and JPEG files of a folder.
    ///
    /// # Errors
    /// When the folder cannot be read, has fewer than [`FEWEST`] photographs, or one of them cannot
    /// be read.
    pub fn folder(path: &Path) -> Result<Self, SceneError> {
        let folder = |cause| SceneError::Folder {
            path: path.to_owned(),
            cause,
        };
        let mut files: Vec<PathBuf> = Vec::new();
        for entry in path.read_dir().map_err(folder)? {
            let file = entry.map_err(folder)?.path();
            let ending = file.extension().and_then(|ending| ending.to_str());
            let taken =
                ending.is_some_and(|own| ENDINGS.iter().any(|e| own.eq_ignore_ascii_case(e)));
            if taken && file.is_file() {
                files.push(file);
            }
        }
        files.sort();
        match files.len() {
            0 => {
                return Err(SceneError::Empty {
                    path: path.to_owned(),
                });
            }
            count if count < FEWEST => {
                return Err(SceneError::Few {
                    path: path.to_owned(),
                    count,
                });
            }
            _ => {}
        }
        let read = |file: &PathBuf| {
            let bytes = std::fs::read(file).map_err(|cause| SceneError::Unreadable {
                path: file.clone(),
                cause: image::ImageError::IoError(cause),
            })?;
            decode(file, &bytes)
        };
        let all: Vec<_> = files.iter().map(read).collect::<Result<_, _>>()?;
        Ok(Self(all.into()))
    }

    /// Those to train with, and those that are held out: the fifth whose names have the least
    /// hashes (SHA-256), at least one.
    #[must_use]
    pub fn split(&self) -> (Self, Self) {
        let mut order: Vec<(Vec<u8>, usize)> = { self.0.iter().enumerate() }
            .map(|(i, one)| (Sha256::digest(one.name.as_bytes()).to_vec(), i))
            .collect();
        order.sort();
        let count = (order.len() / HELD_OUT).max(1);
        let held: Vec<usize> = order[..count.min(order.len())]
            .iter()
            .map(|(_, i)| *i)
            .collect();
        let part = |out: bool| -> Vec<Photograph> {
            let own = self
                .0
                .iter()
                .enumerate()
                .filter(|(i, _)| held.contains(i) == out);
            own.map(|(_, one)| one.clone()).collect()
        };
        (Self(part(false).into()), Self(part(true).into()))
    }

    /// The first of these that is one of the others too, and the other's name: pixel for pixel, whatever
    /// they are called.
    #[must_use]
    pub fn shared<'a>(&'a self, others: &'a Self) -> Option<(&'a str, &'a str)> {
        self.0.iter().find_map(|own| {
            let other = others.0.iter().find(|other| other.light == own.light)?;
            Some((&*own.name, &*other.name))
        })
    }

    /// In the order of their names.
    #[must_use]
    pub fn all(&self) -> &[Photograph] {
        &self.0
    }

    /// SHA-256 of all names and pixels: what a run was trained with.
    #[must_use]
    pub fn checksum(&self) -> String {
        let mut sum = Sha256::new();
        for one in self.0.iter() {
            sum.update((one.name.len() as u64).to_le_bytes());
            sum.update(one.name.as_bytes());
            let (height, width) = one.light.dim();
            sum.update((height as u64).to_le_bytes());
            sum.update((width as u64).to_le_bytes());
            sum.update(one.light.iter().copied().collect::<Vec<u8>>());
        }
        super::hex(&sum.finalize())
    }

    /// Whether a crop fits into each.
    pub(super) fn check_crop(&self, crop: Size) -> Result<(), SceneError> {
        let small = |one: &&Photograph| {
            let own = Size::of(&one.light);
            own.height < crop.height || own.width < crop.width
        };
        match self.0.iter().find(small) {
            Some(one) => Err(SceneError::Small {
                path: one.path.clone(),
                own: Size::of(&one.light),
                crop,
            }),
            None => Ok(()),
        }
    }
}

/// A photograph in gray, halved until it is no larger than needed.
fn decode(path: &Path, bytes: &[u8]) -> Result<Photograph, SceneError> {
    let unreadable = |cause| SceneError::Unreadable {
        path: path.to_owned(),
        cause,
    };
    let reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|cause| unreadable(image::ImageError::IoError(cause)))?;
    let mut light = gray(&reader.decode().map_err(unreadable)?);
    while light.dim().0.min(light.dim().1) >= 2 * SIDE {
        light = halved(&light);
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    Ok(Photograph {
        name: name.into(),
        path: path.to_owned(),
        light: light.mapv(|v| v.round() as u8),
    })
}

/// Luma by Rec. 601, as the library's scenes have it.
fn gray(image: &DynamicImage) -> Plane<f32> {
    let image = image.to_rgb8();
    let shape = (image.height() as usize, image.width() as usize);
    Plane::from_shape_fn(shape, |(y, x)| {
        let [r, g, b] = image.get_pixel(x as u32, y as u32).0.map(f32::from);
        0.299 * r + 0.587 * g + 0.114 * b
    })
}

/// The means of four pixels each.
fn halved(light: &Plane<f32>) -> Plane<f32> {
    let (height, width) = light.dim();
    Plane::from_shape_fn((height / 2, width / 2), |(y, x)| {
        let at = |j, i| light[(2 * y + j, 2 * x + i)];
        (at(0, 0) + at(0, 1) + at(1, 0) + at(1, 1)) / 4.0
    })
}
