//! Everything that the array remembers.

use super::{BitPlane, Domain, Layout};
use crate::{
    aligned::Aligned,
    isa::{Analog, Bit, Digital},
    plane::{Plane, Size},
};

/// Every register of every pixel, and the global input.
#[derive(Clone, Debug, PartialEq)]
pub struct State<C> {
    /// Size and registers.
    pub layout: Layout,
    /// Analogue registers, each row by row.
    pub(super) analog: Vec<Aligned<C>>,
    /// The photodiodes, row by row.
    pub(super) pix: Aligned<C>,
    /// The global input (DAC).
    pub(super) input: C,
    /// What lies off the array.
    pub(super) edge: C,
    pub(super) digital: Vec<BitPlane>,
    pub(super) flag: BitPlane,
    pub(super) select: BitPlane,
    pub(super) rect: BitPlane,
}

impl<C: Clone> State<C> {
    /// As switched on: every register 0, FLAG 1 everywhere.
    pub fn new<D: Domain<Cell = C>>(domain: &D, layout: Layout, edge: f64) -> Self {
        let zero = domain.hold(0.0);
        let plane = |k: u8| Aligned::new(k.into(), zero.clone(), layout.size.pixels());
        Self {
            layout,
            analog: (0..layout.analog).map(plane).collect(),
            pix: plane(layout.analog),
            input: zero.clone(),
            edge: domain.hold(edge),
            digital: (0..layout.digital)
                .map(|k| BitPlane::apart(layout.size, k.into()))
                .collect(),
            flag: BitPlane::ones(layout.size),
            select: BitPlane::zeros(layout.size),
            rect: BitPlane::zeros(layout.size),
        }
    }

    /// An analogue register, row by row.
    ///
    /// # Panics
    /// When the array has no such register.
    #[must_use]
    pub fn analog(&self, register: Analog) -> &[C] {
        &self.analog[usize::from(register.0)]
    }

    /// A one-bit operand.
    ///
    /// # Panics
    /// When the array has no such register.
    #[must_use]
    pub fn bits(&self, bit: Bit) -> &BitPlane {
        match bit {
            Bit::Register(register) => self.digital(register),
            Bit::Flag => &self.flag,
            Bit::Select => &self.select,
            Bit::Rect => &self.rect,
        }
    }

    /// A one-bit register.
    ///
    /// # Panics
    /// When the array has no such register.
    #[must_use]
    pub fn digital(&self, register: Digital) -> &BitPlane {
        &self.digital[usize::from(register.0)]
    }

    /// Sets an analogue register to the nearest to these values, in LSB.
    ///
    /// # Panics
    /// When the array has no such register, or the plane another size.
    pub fn set_analog<D: Domain<Cell = C>>(
        &mut self,
        domain: &D,
        register: Analog,
        values: &Plane<f64>,
    ) {
        self.check_size(values);
        for (cell, value) in self.analog_mut(register).iter_mut().zip(values) {
            *cell = domain.hold(*value);
        }
    }

    /// Sets the photodiodes to the nearest to these values, in LSB.
    ///
    /// # Panics
    /// When the plane has another size.
    pub fn set_light<D: Domain<Cell = C>>(&mut self, domain: &D, values: &Plane<f64>) {
        self.check_size(values);
        for (cell, value) in self.pix.iter_mut().zip(values) {
            *cell = domain.hold(*value);
        }
    }

    /// Sets a one-bit register, whatever R0 is.
    ///
    /// # Panics
    /// When the array has no such register, or the plane another size.
    pub fn set_digital(&mut self, register: Digital, bits: &Plane<bool>) {
        self.check_size(bits);
        let words = self.digital_mut(register).words_mut();
        words.copy_from_slice(BitPlane::from_plane(bits).words());
    }

    /// A plane of another size would be shifted, or a part of it.
    fn check_size<T>(&self, plane: &Plane<T>) {
        let (got, want) = (Size::of(plane), self.layout.size);
        assert!(got == want, "the plane is {got}, and the array {want}");
    }

    pub(super) fn analog_mut(&mut self, register: Analog) -> &mut Aligned<C> {
        &mut self.analog[usize::from(register.0)]
    }

    pub(super) fn digital_mut(&mut self, register: Digital) -> &mut BitPlane {
        &mut self.digital[usize::from(register.0)]
    }

    /// Clears the bits of a register that do not hold.
    pub(super) fn fade(&mut self, register: Digital, holds: impl Fn(usize) -> bool) {
        let (height, width) = self.layout.size.shape();
        let bits = self.digital_mut(register);
        for y in 0..height {
            let words = bits.row_mut(y).iter_mut();
            for (word, x) in words.zip((y * width..).step_by(64)) {
                // Registers that are not in use are 0 all over.
                let mut left = *word;
                while left != 0 {
                    let bit = left.trailing_zeros();
                    if !holds(x + bit as usize) {
                        *word &= !(1 << bit);
                    }
                    left &= left - 1;
                }
            }
        }
    }

    /// The values of an analogue register, in LSB.
    pub fn values<D: Domain<Cell = C>>(&self, domain: &D, register: Analog) -> Plane<f64> {
        self.plane(domain, self.analog(register))
    }

    /// The photodiodes, in LSB.
    pub(super) fn light<D: Domain<Cell = C>>(&self, domain: &D) -> Plane<f64> {
        self.plane(domain, &self.pix)
    }

    fn plane<D: Domain<Cell = C>>(&self, domain: &D, cells: &[C]) -> Plane<f64> {
        let width = self.layout.size.width;
        Plane::from_shape_fn(self.layout.size.shape(), |(y, x)| {
            domain.value(&cells[y * width + x])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{array::Exact, isa::Device};

    fn state() -> State<<Exact as Domain>::Cell> {
        let size = Size::new(3, 4);
        State::new(&Exact, Layout::new(&Device::scamp5(), size), 0.0)
    }

    #[test]
    #[should_panic(expected = "the plane is 3x4, and the array 4x3")]
    fn a_register_of_another_size() {
        state().set_analog(&Exact, Analog(0), &Plane::zeros((4, 3)));
    }

    #[test]
    #[should_panic(expected = "the plane is 4x2, and the array 4x3")]
    fn light_of_another_size() {
        state().set_light(&Exact, &Plane::zeros((2, 4)));
    }

    #[test]
    #[should_panic(expected = "the plane is 5x3, and the array 4x3")]
    fn bits_of_another_size() {
        state().set_digital(Digital(0), &Plane::from_elem((3, 5), true));
    }
}
