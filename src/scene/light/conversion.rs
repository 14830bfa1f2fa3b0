//! Samples become light: the one place where range, scale and transfer are applied.

use std::path::Path;

use super::coding::Origin;
use crate::scene::{
    Frame, Image, Levels, Light, OpenOptions, Outline, Range, Samples, Scene, SceneError, Transfer,
};

/// What a reader says about its samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::scene) struct Source {
    pub samples: Samples,
    /// Black and white of limited range in the unit in which the reader gives light; none for
    /// numbers that cannot have it.
    pub limits: Option<(f64, f64)>,
    /// White of full range in that unit, where it is not 255: of whole numbers of 16 bits.
    pub white: Option<f64>,
    /// The range that the file states.
    pub range: Option<Range>,
    /// The range of its kind where it states none.
    pub usual: Range,
    /// The transfer that the file states.
    pub transfer: Option<Transfer>,
    /// What the transfer that it states is called, where nothing undoes it.
    pub not_undone: Option<&'static str>,
}

impl Source {
    /// Video of so many bits, given as 0 to 255.
    pub fn video(bits: u32, usual: Range) -> Self {
        Self {
            samples: Samples::Video,
            limits: Some(limits(bits, 255.0 / largest(bits))),
            white: None,
            range: None,
            usual,
            transfer: None,
            not_undone: None,
        }
    }

    /// The same, of a file that states a transfer by its number of ITU-T H.273, table 3.
    pub fn stating(self, number: Option<u8>) -> Self {
        let not_undone = |name| (None, Some(name));
        let (transfer, not_undone) = match number {
            // BT.709, BT.601 and BT.2020 in 10 and 12 bits; xvYCC and BT.1361, which have this
            // curve from black to white.
            Some(1 | 6 | 11 | 12 | 14 | 15) => (Some(Transfer::Bt709), None),
            Some(4) => (Some(Transfer::Gamma22), None),
            Some(5) => (Some(Transfer::Gamma28), None),
            Some(7) => (Some(Transfer::Smpte240m), None),
            Some(8) => (Some(Transfer::Linear), None),
            Some(9 | 10) => not_undone("a logarithm"),
            Some(13) => (Some(Transfer::Srgb), None),
            Some(16) => not_undone("PQ"),
            Some(17) => not_undone("SMPTE ST 428-1"),
            Some(18) => not_undone("HLG"),
            // 2: not known to whoever wrote the file.
            None | Some(0 | 2) => (None, None),
            Some(_) => not_undone("a transfer without a name"),
        };
        Self {
            transfer,
            not_undone,
            ..self
        }
    }

    /// Pictures of so many bits, given as 0 to 255.
    pub fn pictures(bits: u32) -> Self {
        Self {
            samples: Samples::Pictures,
            ..Self::video(bits, Range::Full)
        }
    }

    /// Whole numbers of an array, given as they are; those of 8 or 16 bits may be limited.
    pub fn integers(bits: Option<u32>) -> Self {
        Self {
            samples: Samples::Integers,
            limits: bits.map(|bits| limits(bits, 1.0)),
            white: bits.filter(|bits| *bits > 8).map(largest),
            ..Self::video(8, Range::Full)
        }
    }

    /// Real numbers of an array.
    pub fn floats() -> Self {
        Self {
            samples: Samples::Floats,
            limits: None,
            ..Self::video(8, Range::Full)
        }
    }

    /// What becomes of them under these options.
    pub fn light(&self, path: &Path, options: &OpenOptions) -> Result<Light, SceneError> {
        let asked = options.coding;
        let refused = |what: String, help: &'static str| SceneError::Coding {
            path: path.into(),
            what,
            help,
        };
        let (range, range_from) = match (asked.range, self.range) {
            (Some(range), _) => (range, Origin::Asked),
            (None, Some(range)) => (range, Origin::File),
            (None, None) => (self.usual, Origin::Assumed),
        };
        if range == Range::Limited && self.limits.is_none() {
            return Err(refused(
                "numbers of this type have no limited range".into(),
                "limited range is one of whole numbers of 8 or 16 bits; leave --range out",
            ));
        }
        let (transfer, transfer_from) = match (asked.transfer, self.transfer) {
            (Some(transfer), _) if transfer != Transfer::AsCoded => (transfer, Origin::Asked),
            (None, Some(transfer)) => (transfer, Origin::File),
            _ => (Transfer::AsCoded, Origin::Assumed),
        };
        // Numbers are as given unless their range is asked for.
        let is_full = asked.range == Some(Range::Full) && self.white.is_some();
        let is_array = matches!(self.samples, Samples::Integers | Samples::Floats);
        if let Some(scale) = asked.scale {
            if !is_array {
                return Err(refused(
                    format!("--scale {scale}: only the numbers of an array have no scale"),
                    "video and pictures are 0 to 255; leave --scale out",
                ));
            }
            if !(scale.is_finite() && scale > 0.0) {
                return Err(refused(
                    format!("--scale {scale}: no scale"),
                    "give a number above 0, such as 255 for light from 0 to 1",
                ));
            }
        }
        Ok(Light {
            samples: self.samples,
            range: (!is_array || range == Range::Limited || is_full).then_some(range),
            range_from,
            transfer,
            transfer_from,
            stated_transfer: self.transfer,
            not_undone: self.not_undone,
            scale: asked.scale.unwrap_or(1.0),
        })
    }

    /// The scene with its samples as light.
    pub fn decode<'a>(
        self,
        scene: impl Scene + 'a,
        path: &Path,
        options: &OpenOptions,
    ) -> Result<Box<dyn Scene + 'a>, SceneError> {
        Ok(Box::new(self.decoder(scene, path, options)?))
    }

    /// One picture with its samples as light, and what became of them.
    pub fn decode_one(
        self,
        mut image: Image,
        path: &Path,
        options: &OpenOptions,
    ) -> Result<(Image, Light), SceneError> {
        let mut decoder = self.decoder((), path, options)?;
        decoder.decode(&mut image);
        Ok((image, decoder.light))
    }

    fn decoder<S>(
        self,
        scene: S,
        path: &Path,
        options: &OpenOptions,
    ) -> Result<Decoded<S>, SceneError> {
        let light = self.light(path, options)?;
        let limits = match light.range {
            Some(Range::Limited) => self.limits,
            Some(Range::Full) => self.white.map(|white| (0.0, white)),
            None => None,
        };
        Ok(Decoded {
            scene,
            light,
            limits,
            levels: None,
        })
    }
}

/// The largest sample of so many bits.
fn largest(bits: u32) -> f64 {
    f64::from((1_u32 << bits) - 1)
}

/// Black and white of so many bits, times `unit`.
fn limits(bits: u32, unit: f64) -> (f64, f64) {
    let one = f64::from(1_u32 << bits.saturating_sub(8));
    (16.0 * one * unit, 235.0 * one * unit)
}

/// A scene whose samples become light.
struct Decoded<S> {
    scene: S,
    light: Light,
    /// Black and white, where they are not 0 and 255.
    limits: Option<(f64, f64)>,
    /// The levels that came last, and what becomes of them.
    levels: Option<(Levels, Levels)>,
}

impl<S> Decoded<S> {
    fn decode(&mut self, image: &mut Image) {
        let Light {
            scale, transfer, ..
        } = self.light;
        let limits = self.limits;
        let codes =
            { Some(transfer) }.filter(|t| !matches!(t, Transfer::AsCoded | Transfer::Linear));
        if limits.is_none() && scale == 1.0 && codes.is_none() {
            return;
        }
        let light = |mut v: f64| {
            if let Some((black, white)) = limits {
                v = ((v - black) * 255.0 / (white - black)).clamp(0.0, 255.0);
            }
            if scale != 1.0 {
                v *= scale;
            }
            codes.map_or(v, |transfer| transfer.light(v))
        };
        let Some(coded) = image.coded() else {
            image.mapv_inplace(light);
            return;
        };
        let known = { self.levels.take() }.filter(|(from, _)| from.same(coded.levels()));
        let (from, to) = known.unwrap_or_else(|| {
            let from = coded.levels().clone();
            let to = from.map(light);
            (from, to)
        });
        if let Some(decoded) = image.under(&to) {
            *image = decoded;
        }
        self.levels = Some((from, to));
    }
}

impl<S: Scene> Scene for Decoded<S> {
    fn outline(&self) -> Outline {
        Outline {
            coding: self.light,
            ..self.scene.outline()
        }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        let mut next = self.scene.next_frame()?;
        if let Some(frame) = &mut next {
            self.decode(&mut frame.light);
        }
        Ok(next)
    }
}
