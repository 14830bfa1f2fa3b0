//! Whether a scene that is still from its first frame on fires.

use crate::{kernel::Kernel, reference::thresholds};

use super::{Border, Channel, Description};

/// What the released code adds to a distance before it divides by the threshold.
const TIE: f64 = 1e-9;

impl Description {
    /// Where a still scene fires without noise: how far what a cell sees may be from its memory at
    /// first, in light from 0 to 255, and the threshold that this reaches, in the unit of the drive.
    /// None where a still scene stays silent in such light; resistor sheets that settle late are not
    /// looked at.
    ///
    /// Only a memory of pixels that is seen through another kernel than the light is off at first, by
    /// `(W - W_m) * u`.
    #[must_use]
    pub fn still(&self) -> Option<[f64; 2]> {
        let [dark, bright] = [0.0, 255.0].map(|light| self.response.apply(light).ok());
        let signal = match self.border {
            Border::Replicate => [dark?, bright?],
            Border::Zero => [dark?.min(0.0), bright?.max(0.0)],
        };
        self.channels.iter().find_map(|kind| kind.still(signal))
    }
}

impl Channel {
    fn still(&self, signal: [f64; 2]) -> Option<[f64; 2]> {
        let memory = self.memory_kernel.as_ref()?;
        let cells = self.kernels.iter().zip(&self.thresholds);
        let mut reached = cells.flat_map(|(kernel, threshold)| {
            let [least, most] = first_distance([kernel, memory], signal);
            let held = |nominal| {
                if threshold.sigma > 0.0 {
                    thresholds::least(nominal)
                } else {
                    nominal
                }
            };
            [[most, held(threshold.on)], [-least, held(threshold.off)]]
        });
        reached.find(|[distance, threshold]| distance + TIE >= *threshold)
    }
}

/// The least and the most of `(W - W_m) * u` for signals `u` between two.
fn first_distance([kernel, memory]: [&Kernel; 2], [low, high]: [f64; 2]) -> [f64; 2] {
    let [rows, columns] = [kernel.reach(), memory.reach()]
        .map(|(y, x)| [y as isize, x as isize])
        .into_iter()
        .fold([0, 0], |a, b| [a[0].max(b[0]), a[1].max(b[1])]);
    let weight = |kernel: &Kernel, y: isize, x: isize| {
        let (reach_y, reach_x) = kernel.reach();
        let at = [y + reach_y as isize, x + reach_x as isize];
        let at = at.map(|it| usize::try_from(it).unwrap_or(usize::MAX));
        kernel.weights().get(at).copied().unwrap_or(0.0)
    };
    let mut ends = [0.0, 0.0];
    for y in -rows..=rows {
        for x in -columns..=columns {
            let differs = weight(kernel, y, x) - weight(memory, y, x);
            ends[0] += (differs * low).min(differs * high);
            ends[1] += (differs * low).max(differs * high);
        }
    }
    ends
}
