//! What the words of a filter leave in the dark, at every distance from the border: each store on the
//! array adds its transfer error, while registers off it hold the edge value, whatever is run.

use crate::{
    compile::{
        codegen::bus_word::{Wired, wired},
        intermediate::plan::StoreErrors,
    },
    isa::{self, Analog, Device, Errors, Figure, Primitive},
    kernel::Kernel,
};

/// Cells that lie alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::compile) struct Place {
    /// Cells between them and the border: above, below, left and right, as far as a filter reaches.
    room: [i32; 4],
    /// Their part of all cells.
    pub(in crate::compile) share: f64,
    /// What the result is in the dark, LSB.
    pub(in crate::compile) constant: f64,
}

impl Place {
    /// Far from the border.
    pub(in crate::compile) const MIDDLE: Self = Self {
        room: [i32::MAX; 4],
        share: 1.0,
        constant: 0.0,
    };

    /// The weights of a kernel that lie on the array.
    pub(in crate::compile) fn on_the_array(self, kernel: &Kernel) -> impl Iterator<Item = f64> {
        let (rows, columns) = kernel.reach();
        let [above, below, left, right] = self.room;
        let weights = kernel.weights().indexed_iter();
        weights.filter_map(move |((row, column), weight)| {
            let (y, x) = (row as i32 - rows as i32, column as i32 - columns as i32);
            let is_on = -above <= y && y <= below && -left <= x && x <= right;
            is_on.then_some(*weight)
        })
    }
}

/// The places of each result of a filter whose results reach `far`.
pub(in crate::compile) fn places(
    words: &[Primitive],
    results: &[Analog],
    device: &Device,
    far: usize,
) -> Vec<Vec<Place>> {
    let array = Array {
        side: 2 * far as i32 + 1,
        edge: device.value(Figure::Edge),
        errors: Errors::from_device(device),
    };
    let mut held = vec![vec![0.0; array.cells()]; device.registers().analog.len()];
    for word in wired(words, device) {
        array.run(&word, &mut held);
    }
    let far = far as i32;
    // Those in the middle stand for all that are as far from the border.
    let part = |at: i32, side: Figure| {
        let side = device.value(side);
        let same = if at == far {
            (side - 2.0 * f64::from(far)).max(1.0)
        } else {
            1.0
        };
        same / side
    };
    let all = |held: &Vec<f64>| {
        let place = |(at, constant): (usize, &f64)| {
            let (y, x) = (at as i32 / array.side, at as i32 % array.side);
            let last = array.side - 1;
            Place {
                room: [y, last - y, x, last - x],
                share: part(y, Figure::Height) * part(x, Figure::Width),
                constant: *constant,
            }
        };
        held.iter().enumerate().map(place).collect()
    };
    let registers = results.iter().map(|it| &held[usize::from(it.0)]);
    registers.map(all).collect()
}

/// A square of cells as large as a filter sees of it.
struct Array {
    side: i32,
    edge: f64,
    errors: Errors,
}

impl Array {
    const fn cells(&self) -> usize {
        (self.side * self.side) as usize
    }

    /// The cell at a place, where that is on the array.
    fn at(&self, (y, x): (i32, i32)) -> Option<usize> {
        let on = 0..self.side;
        (on.contains(&y) && on.contains(&x)).then(|| (y * self.side + x) as usize)
    }

    /// What a pixel of this sum stores.
    fn stored(&self, sum: f64, word: &Wired) -> f64 {
        let count = word.targets.len();
        let errors = self.errors;
        let added = StoreErrors::of(&errors).added(count > 1);
        let (low, high) = errors.range;
        isa::stored(sum / count as f64, errors.gain(0.0), added).clamp(low, high)
    }

    fn run(&self, word: &Wired, held: &mut [Vec<f64>]) {
        let moved = |at: usize, (y, x): (i32, i32)| {
            let at = at as i32;
            self.at((at / self.side + y, at % self.side + x))
        };
        let sum = |at: usize| {
            let read = word.sources.iter();
            read.map(|(cell, by)| moved(at, *by).map_or(self.edge, |at| held[*cell][at]))
                .sum()
        };
        let outside = self.stored(self.edge * word.sources.len() as f64, word);
        let all: Vec<f64> = { 0..self.cells() }
            .map(|at| self.stored(sum(at), word))
            .collect();
        for (cell, (y, x)) in &word.targets {
            held[*cell] = { 0..self.cells() }
                .map(|at| moved(at, (-y, -x)).map_or(outside, |from| all[from]))
                .collect();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::isa::{Direction, Source, Target};

    /// What is read from beyond the border has no transfer error in it, which elsewhere is taken back.
    #[test]
    fn the_rim_has_another_constant() {
        let device = Device::scamp5();
        let a = Analog(0);
        let bus = |target, source| Primitive::Bus {
            targets: vec![target],
            sources: vec![source],
        };
        let words = [
            bus(Target::Register(device.news()), Source::Register(a)),
            bus(Target::Register(a), Source::Neighbour(Direction::East)),
        ];
        let places = places(&words, &[a], &device, 1).remove(0);
        assert_eq!(places.len(), 9);
        let all: f64 = places.iter().map(|place| place.share).sum();
        assert!((all - 1.0).abs() < 1e-12, "{all}");
        let transfer = device.value(Figure::TransferError);
        let kernel = Kernel::from_rows(&[vec![1.0, 2.0, 4.0]]).unwrap();
        for place in places {
            let is_last = place.room[3] == 0;
            let one = if is_last { transfer } else { 0.0 };
            assert!((place.constant - one).abs() < 0.5, "{place:?}");
            let on: f64 = place.on_the_array(&kernel).sum();
            let is_first = place.room[2] == 0;
            let off = 4.0 * f64::from(u8::from(is_last)) + f64::from(u8::from(is_first));
            assert_eq!(on, 7.0 - off, "{place:?}");
        }
    }
}
