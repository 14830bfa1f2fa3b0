//! Agreement with the authors' released simulator, on every stable file of `tests/oracle/`:
//! counts identical pixel by pixel and pair by pair, voxels within 1e-6 max(1, |v|), memory
//! within 1e-12. Against: reference outputs computed with the released code (README there).
//!
//! The released code rounds what a pair gives to a bin to single precision before it adds the
//! next pair's share. Ours are kept in double precision; the test holds them to the stored
//! values within what that rounding can do (half an ulp of each share), and holds the shares
//! themselves, added as the released code adds them, to 1e-6 max(1, |v|).

mod npz;

use std::{ops::Range, path::Path};

use amacrine::{
    number::Real,
    plane::Size,
    reference::{
        BandSink, Counts, Description, Interval, Reference, Sink, TrainRow, VoxelGrid, bins,
    },
    scene::Frame,
    sensor::SensorError,
};
use ndarray::{Array2, Array3, Array4, Array5};
use npz::oracle::{Oracle, files};

#[test]
fn every_stable_file_agrees() {
    let files = files();
    assert!(files.len() > 80, "only {} files", files.len());
    let mut events = 0;
    for path in files {
        events += agree(&path);
    }
    assert!(events > 500_000, "only {events} events were compared");
}

/// Compares one file, returns the number of events in it.
fn agree(path: &Path) -> u64 {
    let mut oracle = Oracle::open(path);
    let text = oracle.sensor();
    let description = Description::parse(&oracle.name, &text, &|_| unreachable!())
        .unwrap_or_else(|e| panic!("{}: {e}\n{text}", oracle.name));
    let input: Array3<f32> = oracle.arrays.array("input");
    let times = oracle.f64("t");
    let expected: Array4<i16> = oracle.arrays.array("N");
    let voxels: Array5<f32> = oracle.arrays.array("events");
    let size = Size::new(input.shape()[1], input.shape()[2]);
    let (pairs, channels) = (expected.shape()[0], expected.shape()[1]);

    let mut reference = Reference::new(description, size, 0).unwrap();
    let mut counts = Counts::new(size, channels);
    let mut grid = VoxelGrid::new(size, channels);
    let mut exact = Vec::new();
    let mut shares = Shares {
        earlier: vec![],
        later: vec![],
        channels,
        size,
    };
    for (n, light) in input.outer_iter().take(pairs + 1).enumerate() {
        let frame = Frame {
            index: n as u64,
            seconds: times[n],
            light: light.mapv(f64::from).into(),
        };
        reference
            .watch_into(&frame, &mut (&mut counts, (&mut grid, &mut shares)))
            .unwrap();
        if n == 0 {
            compare_memory(&mut oracle, &reference, "mem_first");
            continue;
        }
        exact.push(grid.earlier().to_vec());
        grid.advance();
        for (channel, plane) in counts.planes().iter().enumerate() {
            for ((y, x), &count) in plane.indexed_iter() {
                assert_eq!(
                    count,
                    i32::from(expected[[n - 1, channel, y, x]]),
                    "{}: pair {}, channel {channel}, y {y}, x {x}",
                    oracle.name,
                    n - 1
                );
            }
        }
    }
    exact.push(grid.earlier().to_vec());
    compare_memory(&mut oracle, &reference, "mem_final");
    assert_eq!(
        reference.report().events as f64,
        *oracle.f64("total").first().unwrap(),
        "{}",
        oracle.name
    );

    // The stored tensor holds each bin twice, as the later of one pair and the earlier of the next.
    let summed: Vec<_> = (0..=pairs).map(|bin| shares.bin(bin)).collect();
    let scale = if oracle.is("norm") {
        mean_and_deviation(&summed, pairs)
    } else {
        (0.0, 1.0 - 1e-8)
    };
    for ((pair, channel, side, y, x), &stored) in voxels.indexed_iter() {
        let bin = pair + side;
        let raw = f64::from(summed[bin][channel][[y, x]]);
        let normalised = if raw == 0.0 {
            0.0
        } else {
            (raw - scale.0) / (scale.1 + 1e-8)
        };
        let stored = f64::from(stored);
        let place = format!(
            "{}: pair {pair}, side {side}, channel {channel}, y {y}, x {x}",
            oracle.name
        );
        assert!(
            (normalised - stored).abs() <= 1e-6 * stored.abs().max(1.0),
            "{place}: {normalised}, not {stored}"
        );
        let rounding = f64::from(f32::EPSILON) * shares.magnitude(bin, channel, y, x);
        let ours = exact[bin][channel][[y, x]];
        assert!(
            (ours - raw).abs() <= rounding,
            "{place}: {ours} in double, {raw} in single precision"
        );
    }
    reference.report().events
}

/// What each pair gives to its two bins, in single precision, as the released code keeps it.
struct Shares {
    earlier: Vec<Vec<Array2<f32>>>,
    later: Vec<Vec<Array2<f32>>>,
    channels: usize,
    size: Size,
}

impl Shares {
    fn of(
        list: &[Vec<Array2<f32>>],
        pair: Option<usize>,
        channel: usize,
        at: (usize, usize),
    ) -> f32 {
        pair.and_then(|pair| list.get(pair))
            .map_or(0.0, |planes| planes[channel][at])
    }

    fn both(&self, bin: usize, channel: usize, at: (usize, usize)) -> [f32; 2] {
        [
            Self::of(&self.later, bin.checked_sub(1), channel, at),
            Self::of(&self.earlier, Some(bin), channel, at),
        ]
    }

    fn bin(&self, bin: usize) -> Vec<Array2<f32>> {
        (0..self.channels)
            .map(|channel| {
                Array2::from_shape_fn(self.size.shape(), |at| {
                    self.both(bin, channel, at).iter().sum()
                })
            })
            .collect()
    }

    fn magnitude(&self, bin: usize, channel: usize, y: usize, x: usize) -> f64 {
        self.both(bin, channel, (y, x))
            .iter()
            .map(|v| f64::from(v.abs()))
            .sum()
    }
}

impl Sink for Shares {
    type Band<'a> = ShareBand<'a>;

    fn wants_times(&self) -> bool {
        true
    }

    /// The clips are small, so there is one band.
    fn begin(&mut self, _: Interval, bands: &[Range<usize>]) -> Vec<ShareBand<'_>> {
        assert_eq!(bands.len(), 1);
        let empty = vec![Array2::zeros(self.size.shape()); self.channels];
        self.earlier.push(empty.clone());
        self.later.push(empty);
        vec![ShareBand(self)]
    }

    fn end(&mut self) -> Result<(), SensorError> {
        Ok(())
    }
}

struct ShareBand<'a>(&'a mut Shares);

impl BandSink for ShareBand<'_> {
    fn row<R: Real>(&mut self, row: &TrainRow<R>) -> Result<(), SensorError> {
        let Shares { earlier, later, .. } = self.0;
        for (x, train) in row.trains() {
            let (e, l) = bins(&train);
            earlier.last_mut().unwrap()[row.channel][[row.y, x]] = e as f32;
            later.last_mut().unwrap()[row.channel][[row.y, x]] = l as f32;
        }
        Ok(())
    }
}

/// Over the entries of the stored tensor that are not zero, as the released code normalises.
fn mean_and_deviation(bins: &[Vec<Array2<f32>>], pairs: usize) -> (f64, f64) {
    let entries: Vec<f64> = (0..pairs)
        .flat_map(|pair| [pair, pair + 1])
        .flat_map(|bin| {
            bins[bin]
                .iter()
                .flat_map(|plane| plane.iter().map(|v| f64::from(*v)))
        })
        .filter(|v| *v != 0.0)
        .collect();
    let n = entries.len() as f64;
    let mean = entries.iter().sum::<f64>() / n;
    let variance = entries.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
    (mean, variance.sqrt())
}

fn compare_memory(oracle: &mut Oracle, reference: &Reference, key: &str) {
    let expected: Array3<f64> = oracle.f64(key).into_dimensionality().unwrap();
    for (channel, plane) in expected.outer_iter().enumerate() {
        let ours = reference.memory(channel).unwrap();
        for ((y, x), &value) in plane.indexed_iter() {
            let got = ours[[y, x]];
            assert!(
                (got - value).abs() <= 1e-12,
                "{}: {key}, channel {channel}, y {y}, x {x}: {got}, not {value}",
                oracle.name
            );
        }
    }
}
