//! Voxel grids compared: events put into bins of time, as networks are fed.
//!
//! The time from the first to the last event of either packet is given to `bins` bin centres,
//! the first centre at the first event, the last at the last. An event at `t` adds to the two
//! nearest centres, linearly by nearness, together 1 (bilinear; Zhu et al., CVPR 2019). With
//! `d` the difference of the two grids, judged less reference, per pixel, kind and bin:
//!
//! - L1 is `sum |d|` divided by the events of both packets: 0 to 1. ON adds and OFF takes
//!   away, so that the two cancel, as in the field's grids.
//! - L1 with signs apart is the same where ON and OFF have grids of their own.
//! - RMSE is the root of the mean of `d^2` over all voxels, silent ones too, in events.
//!
//! Blind to shifts far below a bin and to ON and OFF that come together (the second to the
//! former alone). Sums are whole numbers, so identical packets give exactly 0.

pub use super::bins::Bins;

use super::{
    Pair,
    entry::{Entry, Measured, Scale},
};
use crate::{event::Polarity, unit::Micros};

/// L1 of voxel grids per event, ON less OFF.
pub static L1: Entry = Entry {
    key: "voxel_l1",
    title: "voxel L1",
    scale: Scale::None,
    study: Some((
        "voxel-l1",
        "L1 of voxel grids of 8 bins per event, ON less OFF",
    )),
    blind_to: "ON with OFF in one bin",
    knows_a_redraw: true,
    symmetric: true,
    value: |of, _| Some(of.voxels().l1),
};

/// L1 of voxel grids per event, ON and OFF apart.
pub static L1_SIGNS_APART: Entry = Entry {
    key: "voxel_l1_signs_apart",
    title: "voxel L1, signs apart",
    scale: Scale::None,
    study: None,
    blind_to: "",
    knows_a_redraw: true,
    symmetric: true,
    value: |of, _| Some(of.voxels().l1_signs_apart),
};

/// Root of the mean square of voxels, in events.
pub static RMSE: Entry = Entry {
    key: "voxel_rmse",
    title: "voxel RMSE, events",
    scale: Scale::None,
    study: Some(("voxel-rmse", "root of the mean square of voxels, in events")),
    blind_to: "ON with OFF in one bin",
    knows_a_redraw: true,
    symmetric: true,
    value: |of, _| Some(of.voxels().rmse),
};

impl Measured<'_> {
    /// How the voxel grids differ.
    #[must_use]
    pub fn voxels(&self) -> Voxels {
        self.shared(Micros(0), || voxels(self.pair, self.bins))
    }
}

/// How two grids differ.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Voxels {
    /// L1 per event, ON less OFF; 0 to 1.
    pub l1: f64,
    /// L1 per event, ON and OFF apart; 0 to 1.
    pub l1_signs_apart: f64,
    /// Root of the mean square over all voxels, ON less OFF, in events.
    pub rmse: f64,
}

#[derive(Clone, Default)]
struct Sums {
    l1: u128,
    apart: u128,
    squares: f64,
    /// Grids of one pixel, [OFF, ON]; between two pixels all 0.
    grids: [Vec<i128>; 2],
}

/// Compares the grids of a pair.
#[must_use]
pub fn voxels(pair: &Pair, bins: Bins) -> Voxels {
    let unit = bins.unit() as f64;
    let start = || Sums {
        grids: [vec![0; bins.bins], vec![0; bins.bins]],
        ..Sums::default()
    };
    let sums = pair.fold_sites(
        start,
        |sums, reference, judged| {
            for (side, sign) in [(reference, -1), (judged, 1)] {
                for (t, polarity) in side.iter() {
                    let grid = &mut sums.grids[usize::from(polarity == Polarity::On)];
                    let (bin, after) = bins.place(t);
                    if let Some(voxel) = grid.get_mut(bin) {
                        *voxel += sign * (i128::from(bins.unit()) - after);
                    }
                    // The last bin has none after it, and gives it nothing.
                    if let Some(voxel) = grid.get_mut(bin + 1) {
                        *voxel += sign * after;
                    }
                }
            }
            let [off, on] = &mut sums.grids;
            for (off, on) in off.iter_mut().zip(on) {
                let (off, on) = (std::mem::take(off), std::mem::take(on));
                sums.l1 += (on - off).unsigned_abs();
                sums.apart += on.unsigned_abs() + off.unsigned_abs();
                let d = (on - off) as f64 / unit;
                sums.squares += d * d;
            }
        },
        |a, b| Sums {
            l1: a.l1 + b.l1,
            apart: a.apart + b.apart,
            squares: a.squares + b.squares,
            ..a
        },
    );
    let all = pair.site_count().unwrap_or(i128::MAX) as f64 * bins.bins as f64;
    // Half, since it is per event of both packets together, not of their mean.
    let share = |sum: u128| pair.per_event(sum as f64 / unit / 2.0);
    Voxels {
        l1: share(sums.l1),
        l1_signs_apart: share(sums.apart),
        rmse: (sums.squares / f64::max(all, 1.0)).sqrt(),
    }
}
