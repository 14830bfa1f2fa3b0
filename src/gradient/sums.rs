//! What a piece adds up on its way back, channel by channel.

use crate::plane::Plane;

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
        self.gains[0] += other.gains[0];
        self.gains[1] += other.gains[1];
    }

    /// The gradient of the channel.
    pub(super) fn gradient(&self, model: &Model<R>, channel: usize) -> ChannelGradient {
        let planes = self.kernels.iter().zip(&model.kernels[channel]);
        let sides = |side: usize| {
            let each = self.thresholds.map(|signs| signs[side]);
            match model.description.channels[channel].thresholds.len() {
                1 => vec![each.iter().sum()],
                _ => each.to_vec(),
            }
        };
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
            gains: self.gains,
        }
    }
}
