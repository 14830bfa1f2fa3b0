//! What is drawn, and how it moves.

use super::{
    draw,
    parameters::Parameters,
    texture::{Border, Texture},
};
use crate::{
    elementary,
    plane::Plane,
    scene::{Alias, SceneError},
};

/// A figure and its motion. Places are `(x, y)` in pixels from the middle of the picture.
#[derive(Debug)]
pub(super) struct Motif {
    figure: Figure,
    motion: Motion,
    low: f64,
    high: f64,
}

/// A figure: a light pattern from 0 (low light) to 1 (high light); a picture has its own light.
#[derive(Debug)]
enum Figure {
    Bar { thickness: f64, along: Direction },
    Edge { along: Direction },
    Grating { period: f64, along: Direction },
    Checker { square: f64 },
    Disc { radius: f64 },
    Spot { sigma: f64 },
    Texture(Texture),
    Flicker { frequency: f64, wave: Wave },
}

/// How the figure moves.
#[derive(Clone, Copy, Debug)]
enum Motion {
    /// A translation: in the middle at `middle` seconds, with a velocity of `x`, `y` pixels a
    /// second.
    Straight {
        x: f64,
        y: f64,
        middle: f64,
    },
    /// A rotation, in radians per second from right to down.
    Turn(f64),
    /// An expansion: sizes grow by the factor `e` to this power each second.
    Grow(f64),
    Rest,
}

/// The picture if there is one, else blobs.
fn texture(given: &mut Parameters, image: Option<Plane<f64>>) -> Result<Texture, SceneError> {
    let words = [("replicate", Border::Replicate), ("wrap", Border::Wrap)];
    if let Some(picture) = image {
        let border = given.choice("border", words)?;
        return Ok(Texture::Picture { picture, border });
    }
    Ok(Texture::Blobs {
        grain: given.real("grain", 4.0, 1e-3..=1e6)?,
        seed: given.whole("seed", 1, 0..=u64::MAX)?,
    })
}

/// A unit vector.
#[derive(Clone, Copy, Debug)]
struct Direction {
    x: f64,
    y: f64,
}

impl Direction {
    /// Sine and cosine are exact for quarter turns, so that a pattern along a row is the same in
    /// every row.
    fn degrees(angle: f64) -> Self {
        let quarter = (angle / 90.0).round();
        let (sin, cos) = elementary::sin_cos((angle - quarter * 90.0).to_radians());
        let (x, y) = match quarter.rem_euclid(4.0) {
            0.0 => (cos, sin),
            1.0 => (-sin, cos),
            2.0 => (-cos, -sin),
            _ => (sin, -cos),
        };
        Self { x, y }
    }

    /// The coordinate of a place along this direction, in pixels (dot product).
    fn project(self, (x, y): (f64, f64)) -> f64 {
        x * self.x + y * self.y
    }
}

#[derive(Clone, Copy, Debug)]
enum Wave {
    Sine,
    Square,
}

impl Motif {
    /// Takes the parameters that the named pattern has; `middle` is its half time, seconds.
    pub fn take(
        given: &mut Parameters,
        image: Option<Plane<f64>>,
        middle: f64,
    ) -> Result<Self, SceneError> {
        // A picture brings its own light: as it is from 0 to 1.
        let (low, high) = match &image {
            Some(_) => (0.0, 1.0),
            None => (
                given.real("low", 51.0, 0.0..=1e9)?,
                given.real("high", 204.0, 0.0..=1e9)?,
            ),
        };
        let name = given.pattern.clone();
        let mut along = Direction::degrees(0.0);
        let motion = match name.as_str() {
            "flicker" | "static" => Motion::Rest,
            "rotate" => Motion::Turn(given.real("turn", 90.0, -1e6..=1e6)?.to_radians()),
            "zoom" => Motion::Grow(given.real("growth", 0.5, -100.0..=100.0)?),
            _ => {
                let speed = given.real("speed", 60.0, -1e9..=1e9)?;
                along = Direction::degrees(given.real("angle", 0.0, -360.0..=360.0)?);
                Motion::Straight {
                    x: speed * along.x,
                    y: speed * along.y,
                    middle,
                }
            }
        };
        let mut length = |key, default| given.real(key, default, 1e-3..=1e6);
        let figure = match name.as_str() {
            "bar" => Figure::Bar {
                thickness: length("thickness", 10.0)?,
                along,
            },
            "edge" => Figure::Edge { along },
            "grating" => Figure::Grating {
                period: length("period", 20.0)?,
                along,
            },
            "checker" => Figure::Checker {
                // Below a pixel the mean over a pixel would need more than two squares.
                square: given.real("square", 16.0, 1.0..=1e6)?,
            },
            "disc" => Figure::Disc {
                radius: length("radius", 16.0)?,
            },
            "spot" => Figure::Spot {
                sigma: length("sigma", 8.0)?,
            },
            "flicker" => Figure::Flicker {
                frequency: given.real("frequency", 10.0, 0.0..=1e9)?,
                wave: given.choice("wave", [("sine", Wave::Sine), ("square", Wave::Square)])?,
            },
            _ => Figure::Texture(texture(given, image)?),
        };
        Ok(Self {
            figure,
            motion,
            low,
            high,
        })
    }

    /// The light at each place, at one time.
    pub fn at(&self, seconds: f64) -> impl Fn((f64, f64)) -> f64 {
        move |place| {
            let home = self.motion.home(seconds, place);
            self.low + (self.high - self.low) * self.figure.share(home, seconds)
        }
    }

    /// What is finer than pixels or faster than frames, at `fps` frames a second for so many
    /// seconds.
    pub fn alias(&self, fps: f64, seconds: f64) -> Option<Alias> {
        let (growth, pixels) = match self.motion {
            Motion::Grow(growth) => (growth, elementary::exp(-growth * seconds).max(1.0)),
            _ => (0.0, 1.0),
        };
        match &self.figure {
            Figure::Texture(Texture::Blobs { grain, .. }) if *grain < 2.0 => {
                Some(Alias::Fine { grain: *grain })
            }
            Figure::Texture(Texture::Blobs { grain, .. }) if *grain < 2.0 * pixels => {
                Some(Alias::Shrunk { growth, pixels })
            }
            Figure::Texture(Texture::Picture { .. }) if pixels > 2.0 => {
                Some(Alias::Shrunk { growth, pixels })
            }
            Figure::Flicker {
                frequency,
                wave: Wave::Sine,
            } if *frequency > 0.0 && 2.0 * frequency % fps == 0.0 => Some(Alias::Still {
                frequency: *frequency,
                fps,
            }),
            Figure::Flicker { frequency, .. } if 2.0 * frequency > fps => Some(Alias::Fast {
                frequency: *frequency,
                fps,
            }),
            _ => None,
        }
    }

    /// The velocity at a place: `(x, y)`, pixels per second.
    pub fn flow(&self, (x, y): (f64, f64)) -> (f64, f64) {
        match self.motion {
            Motion::Straight { x, y, middle: _ } => (x, y),
            Motion::Turn(rate) => (-rate * y, rate * x),
            Motion::Grow(rate) => (rate * x, rate * y),
            Motion::Rest => (0.0, 0.0),
        }
    }
}

impl Motion {
    /// The place in the figure's own coordinates that is seen at `(x, y)` at `seconds`.
    fn home(self, seconds: f64, (x, y): (f64, f64)) -> (f64, f64) {
        match self {
            Self::Straight {
                x: vx,
                y: vy,
                middle,
            } => {
                let t = seconds - middle;
                (x - vx * t, y - vy * t)
            }
            Self::Turn(rate) => {
                let (sin, cos) = elementary::sin_cos(rate * seconds);
                (cos * x + sin * y, cos * y - sin * x)
            }
            Self::Grow(rate) => {
                let scale = elementary::exp(-rate * seconds);
                (x * scale, y * scale)
            }
            Self::Rest => (x, y),
        }
    }
}

impl Figure {
    /// The share of high light, 0 to 1, in the pixel around a place.
    fn share(&self, place: (f64, f64), seconds: f64) -> f64 {
        match self {
            Self::Bar { thickness, along } => {
                let s = along.project(place);
                let within = |edge: f64| draw::half_plane(edge - s, along.x, along.y);
                within(thickness / 2.0) - within(-thickness / 2.0)
            }
            Self::Edge { along } => draw::half_plane(-along.project(place), along.x, along.y),
            Self::Grating { period, along } => {
                draw::grating(along.project(place), *period, along.x, along.y)
            }
            Self::Checker { square } => draw::checker(place, *square),
            Self::Disc { radius } => draw::disc(place, *radius),
            Self::Spot { sigma } => draw::spot(place, *sigma),
            Self::Texture(texture) => texture.at(place),
            Self::Flicker { frequency, wave } => {
                let turns = frequency * seconds;
                match wave {
                    Wave::Sine => 0.5 + 0.5 * elementary::sin(std::f64::consts::TAU * turns),
                    Wave::Square if turns.rem_euclid(1.0) < 0.5 => 1.0,
                    Wave::Square => 0.0,
                }
            }
        }
    }
}
