//! The canvas of an animation, on which each frame may draw only a part.
//!
//! The canvas holds the light that a viewer sees on a black background. Alpha compositing is linear
//! in that light, so no colours need to be kept.

use crate::{
    plane::{Plane, Size},
    scene::light::pixel::Pixel,
};

/// A canvas, black at first.
pub(super) struct Canvas {
    light: Plane<f64>,
    /// Area and disposal method of the last patch.
    disposal: Option<(Area, Disposal)>,
    /// The canvas before the last patch, kept where its disposal is [`Disposal::Previous`].
    before: Option<Plane<f64>>,
}

/// What happens to the area of a patch before the next one: the "disposal method" of both formats.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Disposal {
    /// It stays.
    Keep,
    /// Its area becomes black.
    Background,
    /// Its area becomes what it was before.
    Previous,
}

/// Where a patch is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Area {
    pub y: usize,
    pub x: usize,
    pub size: Size,
}

/// One frame of an animation: the pixels that it draws.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Patch {
    pub area: Area,
    /// In row order, as many as the area has.
    pub pixels: Vec<Pixel>,
    /// Whether it is alpha-blended over the canvas; else it replaces what is there.
    pub over: bool,
    pub disposal: Disposal,
    /// How long it is shown.
    pub delay: Delay,
}

/// A time in seconds, as a fraction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Delay {
    pub numerator: u16,
    pub denominator: u16,
}

impl Delay {
    pub fn seconds(self) -> f64 {
        f64::from(self.numerator) / f64::from(self.denominator)
    }
}

impl Canvas {
    pub fn new(size: Size) -> Self {
        Self {
            light: Plane::zeros(size.shape()),
            disposal: None,
            before: None,
        }
    }

    /// Draws a patch and returns the canvas; `None` when it does not fit.
    pub fn draw(&mut self, patch: &Patch) -> Option<&Plane<f64>> {
        match self.disposal.take() {
            None | Some((_, Disposal::Keep)) => {}
            Some((area, Disposal::Background)) => area.view_mut(&mut self.light)?.fill(0.0),
            Some((area, Disposal::Previous)) => {
                let before = area.view_mut(self.before.as_mut()?)?;
                area.view_mut(&mut self.light)?.assign(&before);
            }
        }
        if patch.disposal == Disposal::Previous {
            match &mut self.before {
                Some(before) => before.assign(&self.light),
                None => self.before = Some(self.light.clone()),
            }
        }
        let mut there = patch.area.view_mut(&mut self.light)?;
        if there.len() != patch.pixels.len() {
            return None;
        }
        for (there, pixel) in there.iter_mut().zip(&patch.pixels) {
            let kept = if patch.over { 1.0 - pixel.alpha } else { 0.0 };
            *there = pixel.light + *there * kept;
        }
        self.disposal = Some((patch.area, patch.disposal));
        Some(&self.light)
    }
}

impl Area {
    fn view_mut(self, plane: &mut Plane<f64>) -> Option<ndarray::ArrayViewMut2<'_, f64>> {
        let (height, width) = plane.dim();
        let bottom = self.y.checked_add(self.size.height)?;
        let right = self.x.checked_add(self.size.width)?;
        (bottom <= height && right <= width)
            .then(|| plane.slice_mut(ndarray::s![self.y..bottom, self.x..right]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patch(x: usize, light: f64, alpha: f64, over: bool, disposal: Disposal) -> Patch {
        let size = Size::new(1, 2);
        let pixels = vec![Pixel { light, alpha }; 2];
        let area = Area { y: 0, x, size };
        Patch {
            area,
            pixels,
            over,
            disposal,
            delay: Delay {
                numerator: 1,
                denominator: 10,
            },
        }
    }

    #[test]
    fn patches_stay_leave_and_cover() {
        let mut canvas = Canvas::new(Size::new(1, 4));
        let mut row = |patch: Patch| {
            canvas
                .draw(&patch)
                .unwrap()
                .iter()
                .copied()
                .collect::<Vec<_>>()
        };
        assert_eq!(
            row(patch(0, 8.0, 1.0, false, Disposal::Keep)),
            [8.0, 8.0, 0.0, 0.0]
        );
        assert_eq!(
            row(patch(1, 4.0, 0.5, true, Disposal::Previous)),
            [8.0, 8.0, 4.0, 0.0]
        );
        assert_eq!(
            row(patch(2, 1.0, 0.5, false, Disposal::Background)),
            [8.0, 8.0, 1.0, 1.0]
        );
        assert_eq!(
            row(patch(0, 0.0, 0.0, true, Disposal::Keep)),
            [8.0, 8.0, 0.0, 0.0]
        );
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let mut canvas = Canvas::new(Size::new(1, 4));
        assert_eq!(canvas.draw(&patch(3, 1.0, 1.0, true, Disposal::Keep)), None);
        assert_eq!(
            canvas.draw(&patch(usize::MAX, 1.0, 1.0, true, Disposal::Keep)),
            None
        );
    }
}
