//! Samples of a decoded picture to light.

/// What one pixel of a decoded picture is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layout {
    /// 1 gray, 2 gray and alpha, 3 RGB, 4 RGB and alpha.
    pub channels: usize,
    /// The value of full light: 255 or 65535.
    pub most: f64,
}

/// A pixel: its light on black (0 to 255, already times its cover), and how much it covers
/// what is behind it (0 to 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pixel {
    pub light: f64,
    pub cover: f64,
}

/// Pixels from samples in row order.
///
/// Colour is weighed by Rec. 601; the thousandths are summed before they are divided, so
/// that a gray written as RGB gives exactly the gray.
pub(super) fn pixels(layout: Layout, samples: &[f64]) -> impl Iterator<Item = Pixel> {
    samples.chunks_exact(layout.channels.max(1)).map(move |s| {
        let (gray, alpha) = match *s {
            [v] => (v, layout.most),
            [v, alpha] => (v, alpha),
            [r, g, b] => (luma(r, g, b), layout.most),
            [r, g, b, alpha] => (luma(r, g, b), alpha),
            _ => (0.0, 0.0),
        };
        let cover = alpha / layout.most;
        Pixel {
            light: gray * 255.0 / layout.most * cover,
            cover,
        }
    })
}

fn luma(r: f64, g: f64, b: f64) -> f64 {
    (299.0 * r + 587.0 * g + 114.0 * b) / 1000.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lights(channels: usize, most: f64, samples: &[f64]) -> Vec<f64> {
        pixels(Layout { channels, most }, samples)
            .map(|p| p.light)
            .collect()
    }

    #[test]
    fn gray_is_the_same_in_every_layout() {
        for v in 0..=255 {
            let v = f64::from(v);
            assert_eq!(lights(1, 255.0, &[v]), [v]);
            assert_eq!(lights(2, 255.0, &[v, 255.0]), [v]);
            assert_eq!(lights(3, 255.0, &[v, v, v]), [v]);
            assert_eq!(lights(4, 255.0, &[v, v, v, 255.0]), [v]);
            assert_eq!(lights(1, 65535.0, &[v * 257.0]), [v]);
            assert_eq!(lights(3, 65535.0, &[v * 257.0; 3]), [v]);
        }
    }

    #[test]
    fn colour_is_weighed_and_transparency_lies_on_black() {
        assert_eq!(
            lights(
                3,
                255.0,
                &[255.0, 0.0, 0.0, 0.0, 255.0, 0.0, 0.0, 0.0, 255.0]
            ),
            [76.245, 149.685, 29.07]
        );
        assert_eq!(lights(2, 255.0, &[200.0, 51.0]), [40.0]);
    }
}
