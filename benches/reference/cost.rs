//! What a pair of frames must cost: bytes that have to move, operations that have to be done.

use amacrine::{
    number::Number,
    plane::{Plane, Size},
    reference::Description,
};

use crate::probe::Machine;

pub struct Cost {
    /// Bytes of state and light that a pair reads or writes.
    pub bytes: usize,
    /// Bytes that hold them: the working set.
    set: usize,
    /// Multiplications and additions of the kernels.
    operations: f64,
    real: usize,
}

/// Of a kernel for a pixel: rows that are equal are added first, one addition each.
fn operations(weights: &Plane<f64>) -> usize {
    let mut different = Vec::new();
    for row in weights.rows() {
        if !different.contains(&row) {
            different.push(row);
        }
    }
    2 * different.len() * weights.ncols() + weights.nrows() - different.len()
}

impl Cost {
    /// For a memory that steps: base (read), steps and the last drive (read and written) of
    /// each cell; the signal, written once and read once; the light, read.
    pub fn of<N: Number>(_: &N, description: &Description, size: Size) -> Self {
        let (held, cells) = (
            size_of::<N::Held>(),
            size.pixels() * description.channels.len(),
        );
        let operations: usize = description
            .channels
            .iter()
            .map(|channel| operations(channel.kernels[0].weights()))
            .sum();
        let light = size.pixels() * 8;
        Self {
            bytes: light + 2 * size.pixels() * held + cells * (3 * held + 2 * 4),
            set: light + size.pixels() * held + cells * (2 * held + 4),
            operations: (operations * size.pixels()) as f64,
            real: size_of::<N::Real>(),
        }
    }

    /// Seconds of a pair on so many threads if nothing else had to be done.
    pub fn floor(&self, threads: usize, machine: &mut Machine) -> f64 {
        let share = self.set / threads;
        let moving = self.bytes as f64 / machine.bandwidth(share);
        let computing = self.operations / machine.operations(self.real);
        moving.max(computing) / threads as f64
    }
}
