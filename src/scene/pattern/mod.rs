//! Drawn scenes whose motion is known exactly.
//!
//! `pattern:NAME?key=value&key=value`. Light is a function of place and time, averaged over
//! the area of each pixel where that has a closed form, so that motion by a fraction of a
//! pixel is smooth; textures have the light at its centre. A picture becomes light (range and
//! transfer) before it moves. x is to the right, y down, angles turn from right (0) to down (90).
//!
//! [`PATTERNS`] lists the patterns, [`PARAMETERS`] what they take. Every pattern takes these (defaults in
//! brackets):
//! `width` and `height` in pixels (128; that of `image` where there is one), `frames` (240),
//! `fps` (240), `low` and `high` light (51 and 204; not with an `image`, which brings its
//! own), and, where something moves straight, `speed` in pixels per second (60) and `angle`
//! in degrees (0). `border` goes with an `image`, `grain` and `seed` with blobs.

mod draw;
mod motif;
mod parameters;
mod texture;
pub mod told;

pub use parameters::{PARAMETERS, PATTERNS};

use std::path::{Path, PathBuf};

use self::{motif::Motif, parameters::Parameters};
use super::{
    Frame, Light, OpenOptions, Outline, Samples, Scene, SceneError,
    checks::{self, MemoryLimit},
    light::conversion::Source,
    time::frame_rate::{Rate, check_rate},
};
use crate::plane::{Plane, Size};

/// A pattern, drawn frame by frame.
#[derive(Debug)]
pub struct Pattern {
    motif: Motif,
    size: Size,
    rate: Rate,
    frames: u64,
    next: u64,
    /// What became of the samples of the picture, or that there are none.
    coding: Light,
    /// Bytes of the picture and of a frame.
    held: u128,
}

/// Optical flow: how fast what is seen at each pixel moves.
///
/// Where the light is uniform, flow cannot be seen; the planes then say how the pattern as
/// a whole moves.
#[derive(Clone, Debug, PartialEq)]
pub struct Flow {
    /// To the right, `[y, x]`, in pixels per second.
    pub dx: Plane<f64>,
    /// Down, `[y, x]`, in pixels per second.
    pub dy: Plane<f64>,
}

impl Pattern {
    /// Reads `NAME?key=value&key=value`; `fps` is taken instead of the parameter.
    ///
    /// # Errors
    /// When the name or a key is not known, a value or `fps` is out of range, or `image`
    /// cannot be read.
    pub fn parse(text: &str, fps: Option<f64>) -> Result<Self, SceneError> {
        let options = OpenOptions {
            fps,
            ..OpenOptions::default()
        };
        Self::with_options(text, options)
    }

    /// The names of the parameters that a pattern takes without an image.
    ///
    /// # Errors
    /// When the name is not known.
    pub fn parameters(name: &str) -> Result<Vec<String>, SceneError> {
        Ok(Self::taken(name, OpenOptions::default())?.1)
    }

    /// The same with the options that every scene takes.
    pub(super) fn with_options(text: &str, options: OpenOptions) -> Result<Self, SceneError> {
        Ok(Self::taken(text, options)?.0)
    }

    /// The same, and the names of its parameters.
    fn taken(text: &str, options: OpenOptions) -> Result<(Self, Vec<String>), SceneError> {
        let (fps, room) = (options.fps, MemoryLimit::new(options));
        fps.map(check_rate).transpose()?;
        let (name, rest) = text.split_once('?').unwrap_or((text, ""));
        let mut given = Parameters::parse(name, rest)?;
        let named = { given.takes_image() }.then(|| given.text("image", ""));
        let (image, coding) = if let Some(path) = named.flatten() {
            let (picture, coding) = picture(Path::new(&path), &options, room)?;
            (Some(picture), coding)
        } else {
            options.coding.check_drawn(&format!("pattern:{text}"))?;
            (None, Light::DRAWN)
        };
        let natural = image.as_ref().map_or(Size::new(128, 128), Size::of);
        let width = given.whole("width", natural.width as u64, 1..=1 << 16)?;
        let height = given.whole("height", natural.height as u64, 1..=1 << 16)?;
        let path = PathBuf::from(format!("pattern:{name}"));
        let size = checks::checked_size(&path, height as usize, width as usize)?;
        let frames = given.whole("frames", 240, 1..=crate::limit::FRAMES)?;
        checks::check_drawn(&path, size, frames)?;
        let drawn = image.as_ref().map_or(0, ndarray::ArrayBase::len);
        let held = checks::PIXEL_BYTES * (drawn + 2 * size.pixels()) as u128;
        room.check(&path, size, held)?;
        let own = given.real("fps", 240.0, 1e-6..=1e9)?;
        let rate = Rate {
            fps: fps.unwrap_or(own),
            assumed: false,
        };
        let middle = rate.seconds(frames - 1) / 2.0;
        let motif = Motif::take(&mut given, image, middle)?;
        let known = given.finish()?;
        let pattern = Self {
            motif,
            size,
            rate,
            frames,
            next: 0,
            coding,
            held,
        };
        Ok((pattern, known))
    }

    /// The light at a time.
    #[must_use]
    pub fn light(&self, seconds: f64) -> Plane<f64> {
        let motif = self.motif.at(seconds);
        Plane::from_shape_fn(self.size.shape(), |at| motif(self.place(at)))
    }

    /// The optical flow: exact, not estimated, and the same at all times, because every
    /// motion here is steady.
    #[must_use]
    pub fn flow(&self) -> Flow {
        let flow = |at| self.motif.flow(self.place(at));
        Flow {
            dx: Plane::from_shape_fn(self.size.shape(), |at| flow(at).0),
            dy: Plane::from_shape_fn(self.size.shape(), |at| flow(at).1),
        }
    }

    /// The centre of a pixel, `(x, y)` from the middle of the picture.
    fn place(&self, (y, x): (usize, usize)) -> (f64, f64) {
        (
            x as f64 - (self.size.width - 1) as f64 / 2.0,
            y as f64 - (self.size.height - 1) as f64 / 2.0,
        )
    }
}

/// A picture as light, and what became of its samples. It moves as light: means of pixels are means
/// of light.
fn picture(
    path: &Path,
    options: &OpenOptions,
    room: MemoryLimit,
) -> Result<(Plane<f64>, Light), SceneError> {
    let (coded, source) = super::decoder::still::read_with_source(path, 0, room)?;
    let source = Source {
        samples: Samples::Moved,
        ..source
    };
    let (light, coding) = source.decode_one(coded, path, options)?;
    Ok((light.into_plane(), coding))
}

impl Scene for Pattern {
    fn outline(&self) -> Outline {
        Outline {
            frames: Some(self.frames),
            coding: self.coding,
            alias: self
                .motif
                .alias(self.rate.fps, self.rate.seconds(self.frames - 1)),
            bytes: self.held,
            ..Outline::new(self.size, self.rate.fps)
        }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        if self.next == self.frames {
            return Ok(None);
        }
        let index = self.next;
        self.next += 1;
        let seconds = self.rate.seconds(index);
        Ok(Some(Frame {
            index,
            seconds,
            light: self.light(seconds).into(),
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pattern(text: &str) -> Pattern {
        Pattern::parse(text, None).unwrap()
    }

    /// Light at a place between pixels, by cubic interpolation inside the picture.
    fn between(light: &Plane<f64>, y: f64, x: f64) -> Option<f64> {
        let (top, left) = (y.floor(), x.floor());
        let weights = |f: f64| {
            [
                ((-0.5 * f + 1.0) * f - 0.5) * f,
                (1.5 * f - 2.5) * f * f + 1.0,
                ((-1.5 * f + 2.0) * f + 0.5) * f,
                (0.5 * f - 0.5) * f * f,
            ]
        };
        let (wy, wx) = (weights(y - top), weights(x - left));
        let mut sum = 0.0;
        for (j, wy) in wy.into_iter().enumerate() {
            for (i, wx) in wx.into_iter().enumerate() {
                let (y, x) = (
                    top as isize + j as isize - 1,
                    left as isize + i as isize - 1,
                );
                if y < 0 || x < 0 {
                    return None;
                }
                sum += wy * wx * light.get((y as usize, x as usize))?;
            }
        }
        Some(sum)
    }

    /// The mean of |frame k+1 - frame k moved along the flow|, and of |frame k+1 - frame k|.
    fn errors(pattern: &Pattern, sign: f64) -> (f64, f64) {
        let fps = pattern.fps();
        let (mut moved, mut still, mut count) = (0.0, 0.0, 0.0);
        for k in [10, 28, 47] {
            let (now, then) = (k as f64 / fps, (k + 1) as f64 / fps);
            let (before, after) = (pattern.light(now), pattern.light(then));
            let flow = pattern.flow();
            for ((y, x), light) in after.indexed_iter() {
                let from_y = y as f64 - sign * flow.dy[(y, x)] / fps;
                let from_x = x as f64 - sign * flow.dx[(y, x)] / fps;
                if let Some(was) = between(&before, from_y, from_x) {
                    moved += (light - was).abs();
                    still += (light - before[(y, x)]).abs();
                    count += 1.0;
                }
            }
        }
        (moved / count, still / count)
    }

    #[test]
    fn moving_a_frame_along_the_flow_gives_the_next() {
        for text in [
            "bar?speed=100&angle=30",
            "edge?speed=110&angle=200",
            "grating?speed=77&angle=-40",
            "checker?speed=90&angle=65",
            "disc?speed=100&angle=12",
            "spot?speed=100&angle=300",
            "noise?speed=100&angle=111&grain=5",
            "pan?speed=100&angle=111",
            "rotate?turn=80",
            "zoom?growth=0.6",
            "zoom?growth=-0.6",
        ] {
            let pattern = pattern(&format!("{text}&frames=60&fps=60"));
            let (moved, still) = errors(&pattern, 1.0);
            let (against, _) = errors(&pattern, -1.0);
            assert!(still > 0.05, "{text}: nothing moves: {still}");
            assert!(moved < 0.25 * still, "{text}: {moved} of {still}");
            assert!(
                against > 1.5 * still,
                "{text}: the test is blind: {against} of {still}"
            );
        }
    }

    #[test]
    fn what_rests_does_not_flow_and_flicker_is_uniform() {
        for text in ["static", "flicker"] {
            let flow = pattern(text).flow();
            assert!(flow.dx.iter().chain(&flow.dy).all(|v| *v == 0.0));
        }
        assert_eq!(pattern("static").light(0.0), pattern("static").light(1.0));
        let flicker = pattern("flicker?frequency=10");
        let at = |seconds| flicker.light(seconds)[(5, 7)];
        assert!((at(0.0) - 127.5).abs() < 1e-9 && (at(0.025) - 204.0).abs() < 1e-9);
        assert!((at(0.075) - 51.0).abs() < 1e-9);
        let square = pattern("flicker?wave=square&frequency=10");
        assert_eq!(
            (square.light(0.01)[(0, 0)], square.light(0.06)[(0, 0)]),
            (204.0, 51.0)
        );
    }

    #[test]
    fn light_stays_between_low_and_high() {
        for (name, _) in PATTERNS {
            let light = pattern(&format!("{name}?low=10&high=20&width=33&height=17")).light(0.3);
            assert!(
                light
                    .iter()
                    .all(|v| (10.0 - 1e-9..=20.0 + 1e-9).contains(v)),
                "{name}"
            );
            assert_eq!(Size::of(&light), Size::new(17, 33));
        }
    }

    #[test]
    fn an_edge_is_in_the_middle_at_half_time() {
        let edge = pattern("edge?width=5&height=1&frames=3&fps=1&speed=1&low=0&high=100");
        // Bright comes from the left; the middle of the middle pixel is crossed at 1 s.
        assert_eq!(
            edge.light(1.0).as_slice().unwrap(),
            [100.0, 100.0, 50.0, 0.0, 0.0]
        );
        assert_eq!(
            edge.light(1.25).as_slice().unwrap(),
            [100.0, 100.0, 75.0, 0.0, 0.0]
        );
    }

    #[test]
    fn time_is_counted_not_added_up() {
        let mut scene = pattern("static?width=1&height=1&frames=1000&fps=30");
        let mut last = None;
        while let Some(frame) = scene.next_frame().unwrap() {
            last = Some(frame);
        }
        assert_eq!(last.unwrap().seconds, 999.0 / 30.0);
        assert_eq!(Pattern::parse("static", Some(77.0)).unwrap().fps(), 77.0);
        assert!(Pattern::parse("static", Some(f64::NAN)).is_err());
    }

    #[test]
    fn the_list_of_patterns_is_the_list_of_patterns() {
        for (name, text) in PATTERNS {
            let mut known = pattern_error(&format!("{name}?nonsense=1"));
            if text.contains("image=") {
                let image = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/scene/still.pgm");
                known += &pattern_error(&format!("{name}?image={image}&nonsense=1"));
            }
            for word in text.split([' ', ';', ',']).filter(|w| w.contains('=')) {
                let key = word.split('=').next().unwrap();
                assert!(known.contains(key), "{name} has no {key}: {known}");
            }
        }
    }

    #[test]
    fn parameters_are_those_that_patterns_take() {
        let mut taken = std::collections::BTreeSet::from(["border".to_owned()]);
        for (name, _) in PATTERNS {
            let known = pattern_error(&format!("{name}?nonsense=1"));
            for key in Pattern::parameters(name).unwrap() {
                let told = PARAMETERS.iter().find(|(known, ..)| *known == key);
                let (_, default, _) = told.unwrap_or_else(|| panic!("{name}: {key}"));
                assert!(known.contains(&format!("{key}={default}")), "{known}");
                taken.insert(key);
            }
        }
        assert_eq!(taken.len(), PARAMETERS.len());
        assert!(Pattern::parameters("bra").is_err());
    }

    fn pattern_error(text: &str) -> String {
        let error = Pattern::parse(text, None).unwrap_err();
        let help = miette::Diagnostic::help(&error).unwrap().to_string();
        format!("{error}; {help}")
    }

    #[test]
    fn what_is_not_known_is_refused() {
        for (text, words) in [
            ("bra", ["\"bra\"", "bar, edge, grating"]),
            ("bar?sped=1", ["\"sped\"", "speed=60"]),
            ("bar?grain=1", ["\"grain\"", "thickness=10"]),
            ("bar?speed=fast", ["speed=fast", "a number"]),
            ("bar?width=0", ["width=0", "from 1 to 65536"]),
            ("bar?speed=1&speed=2", ["speed=2", "once"]),
            ("bar?low=-1", ["low=-1", "from 0 to"]),
            ("bar?high=NaN", ["high=NaN", "a number"]),
            ("bar?speed", ["speed=", "a value"]),
            ("flicker?wave=saw", ["wave=saw", "sine or square"]),
            ("pan?border=wrap", ["\"border\"", "image="]),
            ("pan?image=missing.png", ["missing.png", "exists"]),
        ] {
            let message = pattern_error(text);
            for word in words {
                assert!(message.contains(word), "{text}: {message}");
            }
        }
    }
}
