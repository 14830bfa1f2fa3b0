//! From a frame to the signal that the kernels read: response, number format, padding.

use std::ops::Range;

use multiversion::multiversion;

use crate::{
    aligned::{Aligned, LINE},
    number::{Number, Real},
    photoreceptor::{Curve, Response},
    plane::{Plane, Size},
    scene::{Codes, Frame, Image, Levels},
    sensor::{SensorError, light_error},
};

use super::{description::Border, low_pass::LowPass, rounding::TWO_52};

/// Some rows of a plane, padded by a rim so that a kernel can be applied to every pixel; row after
/// row.
#[derive(Clone, Debug)]
pub(crate) struct Padded<H> {
    values: Aligned<H>,
    size: Size,
    /// The rows of the plane.
    rows: Range<usize>,
    /// Size of the rim: rows above and below, columns left and right.
    rim: (usize, usize),
    /// Distance from one row to the next: the columns, both rims, and room for a whole block at the
    /// end.
    stride: usize,
    /// Offset in a row of the first pixel of the plane: at the beginning of a cache line.
    left: usize,
}

/// The most pixels that are worked on at a time.
pub(crate) const BLOCK: usize = 64;

impl<H: Copy> Padded<H> {
    /// Room for these rows of planes of `size` under kernels that reach `rim` (rows, columns).
    pub(crate) fn new(size: Size, rows: Range<usize>, rim: (usize, usize), zero: H) -> Self {
        let line = LINE / size_of::<H>();
        let left = rim.1.next_multiple_of(line);
        let stride = (left + size.width.next_multiple_of(BLOCK) + rim.1).next_multiple_of(line);
        let values = Aligned::new(6, zero, (rows.len() + 2 * rim.0) * stride);
        Self {
            values,
            size,
            rows,
            rim,
            stride,
            left,
        }
    }

    /// Whether it has this room.
    pub(crate) fn is_for(&self, size: Size, rows: &Range<usize>, rim: (usize, usize)) -> bool {
        (self.size, &self.rows, self.rim) == (size, rows, rim)
    }

    /// The size of the planes.
    pub(crate) const fn size(&self) -> Size {
        self.size
    }

    /// Index of row `y`.
    fn start(&self, y: usize) -> usize {
        (y + self.rim.0 - self.rows.start) * self.stride
    }

    /// Row `y` of the plane without its rim.
    pub(crate) fn inner(&self, y: usize) -> &[H] {
        let start = self.start(y) + self.left;
        &self.values[start..start + self.size.width]
    }

    /// The rows of the plane.
    pub(super) fn rows(&self) -> Range<usize> {
        self.rows.clone()
    }

    /// The values from `reach` rows above and columns left of the first pixel of row `y` on, and
    /// the stride. Each row of a kernel of that reach finds whole blocks there.
    pub(crate) fn from(&self, y: usize, reach: (usize, usize)) -> (&[H], usize) {
        (&self.values[self.place(y, reach)..], self.stride)
    }

    /// The index of that place.
    pub(super) fn place(&self, y: usize, reach: (usize, usize)) -> usize {
        self.start(y) - reach.0 * self.stride + self.left - reach.1
    }

    /// From one row to the next.
    pub(super) const fn stride(&self) -> usize {
        self.stride
    }

    /// All values, the rim included.
    pub(crate) fn all(&self) -> &[H] {
        &self.values
    }

    /// The rows of the plane that are needed: these rows, and those of the rim.
    pub(super) fn needed(&self) -> Range<usize> {
        let above = self.rim.0;
        self.rows.start.saturating_sub(above)..(self.rows.end + above).min(self.size.height)
    }

    /// Fills row `y` of those needed by `fill`, then its rim, and what lies off the array next to
    /// it.
    pub(crate) fn fill<E>(
        &mut self,
        y: usize,
        border: Border,
        zero: H,
        fill: impl FnOnce(&mut [H]) -> Result<(), E>,
    ) -> Result<(), E> {
        let (start, stride) = (self.start(y), self.stride);
        let (left, width) = (self.left, self.size.width);
        let row = &mut self.values[start..start + stride];
        fill(&mut row[left..left + width])?;
        let (west, east) = match border {
            Border::Replicate => (row[left], row[left + width - 1]),
            Border::Zero => (zero, zero),
        };
        row[..left].fill(west);
        row[left + width..].fill(east);
        let above = if y == 0 { 0..start } else { 0..0 };
        let below = if y + 1 == self.size.height {
            start + stride..self.values.len()
        } else {
            0..0
        };
        for to in above.chain(below).step_by(stride) {
            match border {
                Border::Replicate => self.values.copy_within(start..start + stride, to),
                Border::Zero => self.values[to..to + stride].fill(zero),
            }
        }
        Ok(())
    }
}

/// A frame and the photoreceptors that see it.
#[derive(Debug)]
pub(super) struct Light<'a, N: Number> {
    pub(super) photoreceptors: &'a Photoreceptors<N>,
    pub(super) frame: &'a Frame,
    /// Their low-pass filters, where they have some.
    pub(super) low_pass: Option<&'a LowPass>,
}

/// Implemented by hand: derived, it would require `N: Copy`.
impl<N: Number> Copy for Light<'_, N> {}

#[expect(clippy::expl_impl_clone_on_copy, reason = "as above")]
impl<N: Number> Clone for Light<'_, N> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<N: Number> Light<'_, N> {
    /// Row `y` of the signal.
    pub(super) fn row(&self, y: usize, out: &mut [N::Held]) -> Result<(), SensorError> {
        let Some(low_pass) = self.low_pass else {
            return self.photoreceptors.row(self.frame, y, out);
        };
        for (to, value) in out.iter_mut().zip(low_pass.row(y)) {
            *to = self.photoreceptors.number.hold(*value);
        }
        Ok(())
    }
}

/// The photoreceptors: from light to signal.
#[derive(Clone, Debug)]
pub(super) struct Photoreceptors<N: Number> {
    number: N,
    response: Response,
    /// The signal of each 8-bit light level.
    table: [N::Held; 256],
    /// Two parts of a factor that replaces the division for 8-bit light.
    slope: Option<(N::Real, N::Real)>,
    /// The levels of the frame that was seen last, and the signal of each; no signals where the
    /// response is not defined for all of them.
    levels: Option<(Levels, Vec<N::Held>)>,
}

impl<N: Number> Photoreceptors<N> {
    pub(super) fn new(number: N, response: Response) -> Self {
        let signal = |light: usize| response.apply(light as f64).unwrap_or(0.0);
        let table = std::array::from_fn(|light| number.hold(signal(light)));
        let slope = match response.curve {
            Curve::Linear { white } => Some(slope(white)),
            Curve::Identity | Curve::Log { .. } | Curve::LinLog { .. } => None,
        };
        let agrees = |slope: &(N::Real, N::Real)| {
            let mut lights = table.iter().enumerate();
            lights.all(|(light, held)| {
                number.hold_real(product(N::Real::from_f64(light as f64), *slope)) == *held
            })
        };
        Self {
            number,
            response,
            table,
            slope: slope.filter(agrees),
            levels: None,
        }
    }

    /// Makes the signals of the codes of a frame, whose rows are to be asked for.
    pub(super) fn see(&mut self, frame: &Frame) {
        let Some(coded) = frame.light.coded() else {
            return;
        };
        let levels = coded.levels();
        if matches!(&self.levels, Some((known, _)) if known.same(levels)) {
            return;
        }
        let signal = |light: &f64| self.response.apply(*light).map(|u| self.number.hold(u));
        let signals: Result<_, _> = levels.light().iter().map(signal).collect();
        self.levels = Some((levels.clone(), signals.unwrap_or_default()));
    }

    /// Whether the response is defined for all light of a frame that was seen: the first pixel, row
    /// by row, for which it is not.
    pub(super) fn check(&self, frame: &Frame) -> Result<(), SensorError> {
        if let (Some(coded), Some((levels, signals))) = (frame.light.coded(), &self.levels)
            && levels.same(coded.levels())
            && !signals.is_empty()
        {
            return Ok(());
        }
        let least = match self.response.curve {
            Curve::Identity => f64::MIN,
            Curve::Linear { .. } | Curve::Log { .. } | Curve::LinLog { .. } => 0.0,
        };
        let light: &Plane<f64> = &frame.light;
        if light
            .as_slice_memory_order()
            .is_some_and(|light| all_within(light, least))
        {
            return Ok(());
        }
        let wrong = |light: f64| self.response.apply(light).err();
        if light.iter().any(|light| wrong(*light).is_some()) {
            return Err(light_error(frame, wrong));
        }
        Ok(())
    }

    /// `u = R(I)` for row `y` of a frame.
    pub(super) fn row(
        &self,
        frame: &Frame,
        y: usize,
        out: &mut [N::Held],
    ) -> Result<(), SensorError> {
        if self.of_codes(&frame.light, y, out) {
            return Ok(());
        }
        let row = frame.light.row(y);
        if let Some(light) = row.as_slice() {
            let bytes = |slope| multiply(&self.number, slope, light, out);
            if self.slope.is_some_and(bytes)
                || self.straight(light, out)
                || from_table(&self.table, light, out)
            {
                return Ok(());
            }
        }
        for (x, (out, light)) in out.iter_mut().zip(&row).enumerate() {
            let signal = self.response.apply(*light);
            let index = frame.index;
            *out = self.number.hold(signal.map_err(|cause| SensorError::Light {
                index,
                y,
                x,
                cause,
            })?);
        }
        Ok(())
    }

    /// The signals of a row of codes, where they were made.
    fn of_codes(&self, light: &Image, y: usize, out: &mut [N::Held]) -> bool {
        let (Some(coded), Some((levels, signals))) = (light.coded(), &self.levels) else {
            return false;
        };
        if !levels.same(coded.levels()) {
            return false;
        }
        let width = coded.size().width;
        let row = y * width..(y + 1) * width;
        match (coded.codes(), self.slope, signals.first_chunk()) {
            (Codes::Bytes(codes), Some(slope), _) if levels.are_codes() => {
                multiply_bytes(&self.number, slope, &codes[row], out);
            }
            (Codes::Bytes(codes), _, Some(signals)) => look_up(signals, &codes[row], out),
            (Codes::Words(codes), ..) => {
                let Some(signals) = signals.first_chunk() else {
                    return false;
                };
                look_up_words(signals, &codes[row], out);
            }
            _ => return false,
        }
        true
    }

    /// Linear responses, for a row at once; returns whether this is one, and all light is in its
    /// domain.
    fn straight(&self, light: &[f64], out: &mut [N::Held]) -> bool {
        let Response { curve, round_f32 } = self.response;
        let (least, white) = match curve {
            Curve::Identity => (f64::MIN, 1.0),
            Curve::Linear { white } => (0.0, white),
            Curve::Log { .. } | Curve::LinLog { .. } => return false,
        };
        divide(&self.number, (least, white, round_f32), light, out)
    }
}

/// The reciprocal of `white` in two parts, the first so short that its product with 8 bits is
/// exact. The sum of both products is then rounded as the quotient is, but for rare ties.
fn slope<R: Real>(white: f64) -> (R, R) {
    let inverse = R::from_f64(1.0 / white);
    // Veltkamp's splitting (Dekker 1971, doi:10.1007/BF01397083), by eight bits.
    let longer = inverse * R::from_f64(257.0);
    let long = longer - (longer - inverse);
    (long, R::from_f64((1.0 - long.to_f64() * white) / white))
}

/// `light` times a slope in two parts.
#[inline]
fn product<R: Real>(light: R, (long, rest): (R, R)) -> R {
    light * long + light * rest
}

/// Which of 0, 1, … 255 a light is: the first result. The second is 0 if it is one of them.
#[inline]
fn byte(light: f64) -> (u64, u64) {
    // Added to 2^52, an integer stands in the lowest bits, and comes back unchanged.
    let sum = light + TWO_52;
    (
        sum.to_bits() ^ TWO_52.to_bits(),
        (sum - TWO_52).to_bits() ^ light.to_bits(),
    )
}

/// Multiplies light that is 0, 1, … 255, as in 8-bit video; returns whether all of it was.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn multiply<N: Number>(
    number: &N,
    slope: (N::Real, N::Real),
    light: &[f64],
    out: &mut [N::Held],
) -> bool {
    let (mut all, mut wrong) = (0, 0);
    for (out, &light) in out.iter_mut().zip(light) {
        let (place, rest) = byte(light);
        all |= place;
        wrong |= rest;
        *out = number.hold_real(product(N::Real::from_f64(light), slope));
    }
    all <= 0xff && wrong == 0
}

/// Multiplies codes of 8 bits, which are the light.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn multiply_bytes<N: Number>(
    number: &N,
    slope: (N::Real, N::Real),
    light: &[u8],
    out: &mut [N::Held],
) {
    for (out, &light) in out.iter_mut().zip(light) {
        *out = number.hold_real(product(N::Real::from_i32(light.into()), slope));
    }
}

/// The signals of codes of 8 bits.
fn look_up<H: Copy>(signals: &[H; 1 << 8], codes: &[u8], out: &mut [H]) {
    for (out, &code) in out.iter_mut().zip(codes) {
        *out = signals[usize::from(code)];
    }
}

/// The signals of codes of 16 bits.
fn look_up_words<H: Copy>(signals: &[H; 1 << 16], codes: &[u16], out: &mut [H]) {
    for (out, &code) in out.iter_mut().zip(codes) {
        *out = signals[usize::from(code)];
    }
}

/// Looks up light that is 0, 1, … 255; returns whether all of it was.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn from_table<H: Copy>(table: &[H; 256], light: &[f64], out: &mut [H]) -> bool {
    for (light, out) in light.chunks(BLOCK).zip(out.chunks_mut(BLOCK)) {
        let mut places = [0; BLOCK];
        let (mut all, mut wrong) = (0, 0);
        for (place, &light) in places.iter_mut().zip(light) {
            let rest;
            (*place, rest) = byte(light);
            all |= *place;
            wrong |= rest;
        }
        if all > 0xff || wrong != 0 {
            return false;
        }
        for (out, place) in out.iter_mut().zip(&places) {
            *out = table[*place as usize & 0xff];
        }
    }
    true
}

/// Whether all light is finite and at least `least`.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn all_within(light: &[f64], least: f64) -> bool {
    let mut within = true;
    for &light in light {
        within &= light >= least && light <= f64::MAX;
    }
    within
}

/// `light / white`; returns whether all light is finite and at least `least`.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn divide<N: Number>(
    number: &N,
    (least, white, round_f32): (f64, f64, bool),
    light: &[f64],
    out: &mut [N::Held],
) -> bool {
    let mut within = true;
    for (out, &light) in out.iter_mut().zip(light) {
        within &= light >= least && light <= f64::MAX;
        let signal = light / white;
        *out = number.hold(if round_f32 {
            f64::from(signal as f32)
        } else {
            signal
        });
    }
    within
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::{F16, F32, F64};
    use proptest::prelude::*;

    /// Or the short way would never be taken.
    #[test]
    fn bytes_need_no_division() {
        let response = Response::new(Curve::Linear { white: 255.0 });
        assert!(Photoreceptors::new(F32, response).slope.is_some());
        assert!(Photoreceptors::new(F64, response).slope.is_some());
    }

    proptest! {
        /// However it is computed, the signal is the response, rounded.
        #[test]
        fn rows_are_the_response(
            light in prop_oneof![
                proptest::collection::vec((0u8..=255).prop_map(f64::from), 1..200),
                proptest::collection::vec(prop_oneof![
                    (0u8..=255).prop_map(f64::from),
                    (0f32..1e9).prop_map(f64::from),
                    0f64..1e9,
                    Just(1e-45),
                    Just(-0.0),
                ], 1..70),
            ],
            white in prop_oneof![Just(255.0), Just(1.0), Just(3.0), 1e-3f64..1e9],
            round_f32: bool,
        ) {
            let response = Response { curve: Curve::Linear { white }, round_f32 };
            let width = light.len();
            let frame = Frame { index: 0, seconds: 0.0, light: crate::plane::Plane::from_shape_vec((1, width), light.clone()).unwrap().into() };
            let (mut single, mut double) = (vec![0f32; width], vec![0f64; width]);
            let mut half = vec![F16::ZERO; width];
            Photoreceptors::new(F32, response).row(&frame, 0, &mut single).unwrap();
            Photoreceptors::new(F64, response).row(&frame, 0, &mut double).unwrap();
            Photoreceptors::new(F16, response).row(&frame, 0, &mut half).unwrap();
            for (x, light) in light.iter().enumerate() {
                let signal = response.apply(*light).unwrap();
                prop_assert_eq!(F16.value(half[x]).to_bits(), F16.value(F16.hold(signal)).to_bits());
                prop_assert_eq!(single[x].to_bits(), (signal as f32).to_bits());
                prop_assert_eq!(double[x].to_bits(), signal.to_bits());
            }
        }

        /// Codes have the signals of their light, to the bit; a response that some level is not
        /// defined for says so where the level occurs.
        #[test]
        fn codes_have_the_signals_of_their_light(
            codes in proptest::collection::vec(any::<u16>(), 1..150),
            (by, less) in (prop_oneof![Just(1.0), 1e-3f64..4.0], prop_oneof![Just(0.0), 0f64..3.0]),
            curve in prop_oneof![
                Just(Curve::Identity),
                Just(Curve::Linear { white: 255.0 }),
                Just(Curve::Log { white: 255.0, offset: 1e-3 }),
                Just(Curve::LinLog { knee: 20.0 }),
            ],
            wide: bool,
        ) {
            fn rows<N: Number>(number: N, response: Response, frames: &[Frame; 2]) -> [Result<Vec<u64>, String>; 2] {
                let mut photoreceptors = Photoreceptors::new(number, response);
                [0, 1].map(|n| {
                    let mut row = vec![N::ZERO; frames[n].light.size().width];
                    photoreceptors.see(&frames[n]);
                    let seen = photoreceptors.row(&frames[n], 0, &mut row);
                    let bits = |held: &N::Held| number.value(*held).to_bits();
                    seen.map(|()| row.iter().map(bits).collect()).map_err(|e| e.to_string())
                })
            }
            let size = Size::new(1, codes.len());
            let level = |light: f64| light * by - less;
            let coded = if wide {
                Image::of_words(size, codes, Levels::words().map(level))
            } else {
                let codes = codes.iter().map(|code| *code as u8).collect();
                let levels = Levels::bytes();
                let plain = by == 1.0 && less == 0.0;
                Image::of_bytes(size, codes, if plain { levels } else { levels.map(level) })
            }
            .unwrap();
            let numbers: Image = coded.clone().into_plane().into();
            let frames = [coded, numbers].map(|light| Frame { index: 0, seconds: 0.0, light });
            let response = Response::new(curve);
            let [a, b] = rows(F64, response, &frames);
            prop_assert_eq!(a, b);
            let [a, b] = rows(F32, response, &frames);
            prop_assert_eq!(a, b);
            let [a, b] = rows(F16, response, &frames);
            prop_assert_eq!(a, b);
        }
    }
}
