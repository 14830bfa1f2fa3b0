//! What a piece adds up on its way back, channel by channel.

use crate::{
    plane::Plane,
    reference::{Threshold, thresholds::least},
};

use super::{backward::ChannelGradient, float::Float, kernel_sum::KernelSum, model::Model};

/// The sums of one channel.
#[derive(Clone, Debug)]
pub(super) struct ChannelSum<R> {
    /// One, or four in a 2x2 pattern.
    pub(super) kernels: Vec<KernelSum<R>>,
    /// For each parity of the row, ON and OFF thresholds column by column.
    pub(super) columns: [[Vec<R>; 2]; 2],
    /// The same for each place of a 2x2 pattern, ON and OFF.
    pub(super) thresholds: [[f64; 2]; 4],
    /// By the deviation of the mismatch, at each place of a pattern.
    pub(super) sigma: [f64; 4],
    /// Gains of the signal and of the memory.
    pub(super) gains: [f64; 2],
}

impl<R: Float> ChannelSum<R> {
    pub(super) fn new(model: &Model<R>, channel: usize) -> Self {
        let row = || vec![R::ZERO; model.size.width];
        let both = || [row(), row()];
        let kernels = model.kernels[channel].iter();
        Self {
            kernels: kernels.map(|kernel| KernelSum::new(kernel.dim())).collect(),
            columns: [both(), both()],
            thresholds: [[0.0; 2]; 4],
            sigma: [0.0; 4],
            gains: [0.0; 2],
        }
    }

    /// Folds partial sums into double precision.
    pub(super) fn fold(&mut self) {
        self.kernels.iter_mut().for_each(KernelSum::fold);
        for (parity, signs) in self.columns.iter_mut().enumerate() {
            for (sign, columns) in signs.iter_mut().enumerate() {
                for (x, value) in columns.iter_mut().enumerate() {
                    self.thresholds[2 * parity + x % 2][sign] += value.to_f64();
                    *value = R::ZERO;
                }
            }
        }
    }

    /// Adds a row's gradients of its cells' own thresholds `theta`, and leaves `of` at 0. A cell's
    /// threshold is the nominal one plus its share of the deviation, and no less than
    /// [`least`] of the nominal one.
    pub(super) fn add_row(
        &mut self,
        y: usize,
        of: &mut [Vec<R>; 2],
        theta: (&[R], &[R]),
        nominal: &[Threshold],
    ) {
        for (sign, (of, theta)) in of.iter_mut().zip([theta.0, theta.1]).enumerate() {
            let columns = &mut self.columns[y % 2][sign];
            for (x, (of, theta)) in of.iter_mut().zip(theta).enumerate() {
                let place = 2 * (y % 2) + x % 2;
                let own = match nominal {
                    [one] => one,
                    four => &four[place],
                };
                let mean = [own.on, own.off][sign];
                let gradient = std::mem::replace(of, R::ZERO);
                if *theta > R::from_f64(least(mean)) {
                    columns[x] = columns[x] + gradient;
                    if own.sigma > 0.0 {
                        let share = (theta.to_f64() - mean) / own.sigma;
                        self.sigma[place] += gradient.to_f64() * share;
                    }
                } else {
                    columns[x] = columns[x] + gradient * R::from_f64(least(1.0));
                }
            }
        }
    }

    /// Adds what another piece has summed.
    pub(super) fn add(&mut self, other: &Self) {
        for (kernel, other) in self.kernels.iter_mut().zip(&other.kernels) {
            for (sum, other) in kernel.total.iter_mut().zip(&other.total) {
                *sum += other;
            }
        }
        for (sums, other) in self.thresholds.iter_mut().zip(&other.thresholds) {
            sums[0] += other[0];
            sums[1] += other[1];
        }
        for (sum, other) in self.sigma.iter_mut().zip(&other.sigma) {
            *sum += other;
        }
        self.gains[0] += other.gains[0];
        self.gains[1] += other.gains[1];
    }

    /// The gradient of the channel.
    pub(super) fn gradient(&self, model: &Model<R>, channel: usize) -> ChannelGradient {
        let planes = self.kernels.iter().zip(&model.kernels[channel]);
        let each = |of: [f64; 4]| match model.description.channels[channel].thresholds.len() {
            1 => vec![of.iter().sum()],
            _ => of.to_vec(),
        };
        let sides = |side: usize| each(self.thresholds.map(|signs| signs[side]));
        ChannelGradient {
            kernels: planes
                .map(|(sum, kernel)| {
                    let mut plane = Plane::zeros(kernel.dim());
                    for (to, total) in plane.iter_mut().zip(&sum.total) {
                        *to = *total;
                    }
                    plane
                })
                .collect(),
            on: sides(0),
            off: sides(1),
            sigma: each(self.sigma),
            gains: self.gains,
        }
    }
}
