//! Pixels of decoded pictures: colour to gray (Rec. 601), and alpha.

/// The samples of one pixel of a decoded picture.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct Layout {
    /// 1 gray, 2 gray and alpha, 3 RGB, 4 RGB and alpha.
    pub channels: usize,
    /// How a sample is stored.
    pub depth: Depth,
}

/// The type of a sample; its whole range is used.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) enum Depth {
    Eight,
    /// Two bytes, read so.
    Sixteen(fn([u8; 2]) -> u16),
}

impl Depth {
    const fn bytes(self) -> usize {
        match self {
            Self::Eight => 1,
            Self::Sixteen(_) => 2,
        }
    }

    /// The sample value of full light.
    const fn full_scale(self) -> f64 {
        match self {
            Self::Eight => 255.0,
            Self::Sixteen(_) => 65535.0,
        }
    }

    fn sample(self, bytes: &[u8]) -> f64 {
        match (self, bytes) {
            (Self::Sixteen(read), &[a, b]) => read([a, b]).into(),
            (_, bytes) => bytes.first().copied().unwrap_or(0).into(),
        }
    }
}

/// A pixel: its light on black (0 to 255, premultiplied by alpha), and its alpha, how much it
/// covers what is behind it (0 to 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::scene) struct Pixel {
    pub light: f64,
    pub alpha: f64,
}

/// Pixels from samples in row order.
///
/// Colour is weighed by Rec. 601; the thousandths are summed before they are divided, so
/// that a gray written as RGB gives exactly the gray.
pub(in crate::scene) fn pixels(layout: Layout, samples: &[u8]) -> impl Iterator<Item = Pixel> {
    let Layout { channels, depth } = layout;
    let (wide, full_scale) = (depth.bytes(), depth.full_scale());
    samples
        .chunks_exact(channels.max(1) * wide)
        .map(move |pixel| {
            let at = |n: usize| depth.sample(&pixel[n * wide..(n + 1) * wide]);
            let (gray, alpha) = match channels {
                1 => (at(0), full_scale),
                2 => (at(0), at(1)),
                3 => (luma(at(0), at(1), at(2)), full_scale),
                4 => (luma(at(0), at(1), at(2)), at(3)),
                _ => (0.0, 0.0),
            };
            let alpha = alpha / full_scale;
            Pixel {
                light: gray * 255.0 / full_scale * alpha,
                alpha,
            }
        })
}

fn luma(r: f64, g: f64, b: f64) -> f64 {
    (299.0 * r + 587.0 * g + 114.0 * b) / 1000.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lights(channels: usize, samples: &[u8]) -> Vec<f64> {
        let depth = Depth::Eight;
        let pixels = pixels(Layout { channels, depth }, samples);
        pixels.map(|p| p.light).collect()
    }

    fn wide(channels: usize, samples: &[u16]) -> Vec<f64> {
        let bytes: Vec<u8> = samples.iter().flat_map(|v| v.to_be_bytes()).collect();
        let depth = Depth::Sixteen(u16::from_be_bytes);
        let pixels = pixels(Layout { channels, depth }, &bytes);
        pixels.map(|p| p.light).collect()
    }

    #[test]
    fn gray_is_the_same_in_every_layout() {
        for v in 0..=255 {
            let light = f64::from(v);
            assert_eq!(lights(1, &[v]), [light]);
            assert_eq!(lights(2, &[v, 255]), [light]);
            assert_eq!(lights(3, &[v, v, v]), [light]);
            assert_eq!(lights(4, &[v, v, v, 255]), [light]);
            assert_eq!(wide(1, &[u16::from(v) * 257]), [light]);
            assert_eq!(wide(3, &[u16::from(v) * 257; 3]), [light]);
        }
    }

    #[test]
    fn colour_is_weighed_and_transparency_lies_on_black() {
        assert_eq!(
            lights(3, &[255, 0, 0, 0, 255, 0, 0, 0, 255]),
            [76.245, 149.685, 29.07]
        );
        assert_eq!(lights(2, &[200, 51]), [40.0]);
    }
}
