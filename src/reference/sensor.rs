//! The sensor as a whole: its state, and how it watches a frame.

use std::{convert::Infallible, ops::Range};

use crate::{
    event::Packet,
    kernel::Kernel,
    limit::ARRAY_SIDE,
    mosaic::Mosaic,
    number::{F64, Number, Real},
    parallel::{self, Job},
    plane::{Plane, Size},
    scene::Frame,
    sensor::{Overflowed, Sensor, SensorError, Silence, check_time},
    unit::Micros,
};

use super::{
    any_format::{AnyReference, Sinks},
    band::{Band, IntervalInput, Plan},
    description::Description,
    drive::differences,
    list::{Buffers, EventList, Limit},
    low_pass::LowPass,
    report::Report,
    sheets::Sheets,
    signal::{Light, Padded, Photoreceptors},
    train::{Interval, Sink},
};

/// With fewer pixels, threads cost more than they save.
const SMALL: usize = 1 << 13;

/// Rows of a band: few enough that a band's working memory stays in cache, enough to be worth a
/// task. Events do not depend on it.
const BAND_ROWS: usize = 32;

/// Into how many bands, at most as many threads, a sensor of this size is cut.
#[must_use]
pub const fn bands_of(size: Size) -> usize {
    size.height.div_ceil(band_rows(size))
}

/// The float model of one sensor, in one number format.
#[derive(Clone, Debug)]
pub struct Reference<N: Number = F64> {
    plan: Plan<N>,
    size: Size,
    pub(super) limit: Limit,
    photoreceptors: Photoreceptors<N>,
    low_pass: Option<LowPass>,
    sheets: Option<Sheets>,
    /// Rows and columns that the kernels reach beyond a pixel.
    reach: (usize, usize),
    /// For each channel, or once for all that share it, a pixel memory, or the signal's distance
    /// from it; none otherwise.
    pixels: Vec<Padded<N::Held>>,
    cut: Vec<Range<usize>>,
    bands: Vec<Band<N>>,
    /// Working memory for the lists of [`Sensor::watch`].
    buffers: Buffers,
    /// Times of the first frame and of the last, in seconds.
    seen: Option<(f64, f64)>,
    intervals: u64,
    /// Those in which no cell can fire.
    muted: u64,
    /// Pixels' distances from their memory that the number format does not hold.
    overflowed: Overflowed,
    /// Whether the last frame stopped half-way: some cells are past it, others are not.
    is_halfway: bool,
}

impl Reference<F64> {
    /// A sensor of `size` as `description` says, in double precision; `seed` chooses its
    /// mismatch and noise.
    ///
    /// # Errors
    /// When the size is empty, or larger than sensors are; when there can be no such sensor
    /// ([`Description::check`]).
    pub fn new(description: Description, size: Size, seed: u64) -> Result<Self, SensorError> {
        Self::with_number(F64, description, size, seed)
    }
}

impl<N: Number> Reference<N> {
    /// A sensor whose signals, weights and memory are held in this number format.
    ///
    /// # Errors
    /// As [`Reference::new`].
    pub fn with_number(
        number: N,
        description: Description,
        size: Size,
        seed: u64,
    ) -> Result<Self, SensorError> {
        Self::in_bands(number, description, (size, None), seed, band_rows(size))
    }

    /// The sensor on some tiles of it: it watches mosaics, and gives the cells of a tile the
    /// mismatch and noise that they have in the whole sensor. Tiles whose halo is what their cells
    /// depend on have the events of the whole sensor, to the bit, where corners, side and halo of
    /// tiles are even; resistor sheets depend on all of it.
    ///
    /// # Errors
    /// As [`Reference::new`].
    pub fn on_tiles(
        number: N,
        description: Description,
        mosaic: &Mosaic,
        seed: u64,
    ) -> Result<Self, SensorError> {
        let size = mosaic.size();
        let rows = band_rows(size);
        Self::in_bands(number, description, (size, Some(mosaic)), seed, rows)
    }

    /// A sensor with bands of so many rows.
    fn in_bands(
        number: N,
        description: Description,
        (size, mosaic): (Size, Option<&Mosaic>),
        seed: u64,
        rows: usize,
    ) -> Result<Self, SensorError> {
        let addresses = 1..=ARRAY_SIDE;
        let is_possible = match mosaic {
            None => size.is_possible(),
            // Halos count twice.
            Some(_) => addresses.contains(&size.width) && addresses.contains(&size.height),
        };
        if !is_possible {
            return Err(SensorError::Addresses { size });
        }
        description.check()?;
        description.check_countable(&number)?;
        let reach = description
            .channels
            .iter()
            .flat_map(|channel| channel.kernels.iter().chain(&channel.memory_kernel))
            .map(Kernel::reach)
            .fold((0, 0), |a, b| (a.0.max(b.0), a.1.max(b.1)));
        let held_pixels = description.memory.holds_pixels();
        Ok(Self {
            size,
            limit: Limit::default(),
            photoreceptors: Photoreceptors::new(number, description.response),
            low_pass: (description.noise.cutoff_hz > 0.0).then(|| LowPass::new(size)),
            sheets: Sheets::new(
                &description.name,
                description.channels.iter().map(|c| c.surrounds.as_ref()),
                size,
                seed,
            ),
            pixels: if held_pixels {
                let whole = Padded::new(size, 0..size.height, reach, N::ZERO);
                let memories = if description.shared {
                    1
                } else {
                    description.channels.len()
                };
                vec![whole; memories]
            } else {
                Vec::new()
            },
            reach,
            cut: bands(size.height, rows.max(1)),
            bands: Vec::new(),
            buffers: Buffers::default(),
            seen: None,
            intervals: 0,
            muted: 0,
            overflowed: Overflowed::default(),
            is_halfway: false,
            plan: Plan::new(number, description, size, seed, mosaic),
        })
    }

    /// The description of this sensor.
    #[must_use]
    pub const fn description(&self) -> &Description {
        &self.plan.description
    }

    /// Bytes of its cells that must last to the next frame.
    #[cfg(test)]
    pub(super) fn kept(&self) -> usize {
        self.bands.iter().map(Band::kept).sum()
    }

    /// Counters of the run so far.
    #[must_use]
    pub fn report(&self) -> Report {
        let mut all = Report {
            muted_pairs: self.muted,
            overflowed: self.overflowed,
            ..Report::default()
        };
        for Band { report, .. } in &self.bands {
            all.events += report.events;
            all.lost_to_refractory += report.lost_to_refractory;
            all.livelocked += report.livelocked;
            all.without_sign += report.without_sign;
            all.overflowed += report.overflowed;
        }
        all
    }

    /// The memory of a channel, `[y, x]`, in the unit of the drive (or of the signal, for
    /// pixel memories); `None` before the first frame, or for a channel that is not there.
    #[must_use]
    pub fn memory(&self, channel: usize) -> Option<Plane<f64>> {
        if channel >= self.plan.weights.len() || self.bands.is_empty() {
            return None;
        }
        let mut plane = Plane::zeros(self.size.shape());
        let mut held = vec![N::ZERO; self.size.width];
        for band in &self.bands {
            for y in band.rows.clone() {
                band.memory_row(&self.plan, channel, y, &mut held);
                for (to, held) in plane.row_mut(y).iter_mut().zip(&held) {
                    *to = self.plan.number.value(*held);
                }
            }
        }
        Some(plane)
    }

    /// The ON and OFF thresholds of every cell of a channel, `[y, x]`, mismatch included, in the
    /// unit of the drive; `None` for a channel that is not there.
    #[must_use]
    pub fn thresholds(&self, channel: usize) -> Option<[Plane<f64>; 2]> {
        let thresholds = self.plan.thresholds.get(channel)?;
        let shape = self.size.shape();
        Some([
            Plane::from_shape_fn(shape, |(y, x)| thresholds.row(y).0[x].to_f64()),
            Plane::from_shape_fn(shape, |(y, x)| thresholds.row(y).1[x].to_f64()),
        ])
    }

    /// How far the leak lowers the memory of every cell of a channel in a second, `[y, x]`, in the
    /// unit of the drive; `None` before the first frame, or for a channel that is not there.
    #[must_use]
    pub fn leak(&self, channel: usize) -> Option<Plane<f64>> {
        if channel >= self.plan.weights.len() || self.bands.is_empty() {
            return None;
        }
        let mut plane = Plane::zeros(self.size.shape());
        for band in &self.bands {
            for y in band.rows.clone() {
                for (to, leak) in plane.row_mut(y).iter_mut().zip(band.leak_row(channel, y)) {
                    *to = leak.to_f64();
                }
            }
        }
        Some(plane)
    }

    /// Watches one frame and passes the trains since the frame before to `sink`.
    ///
    /// The first frame sets the memory and makes no event.
    ///
    /// # Errors
    /// When the frame has another size, is not later than the last, or holds light that the
    /// response is not defined for, and when the sink is for a sensor of another shape: the sensor
    /// then is as it was, and may be shown another frame in its place. When the sink cannot take
    /// more, a number format cannot hold what a cell sees, or a resistor sheet does not settle:
    /// some cells are then past the frame and others are not, and every later call is
    /// [`SensorError::Halfway`].
    pub fn watch_into<S: Sink>(&mut self, frame: &Frame, sink: &mut S) -> Result<(), SensorError> {
        self.check(frame, sink)?;
        self.is_halfway = true;
        self.take(frame, sink)?;
        self.is_halfway = false;
        Ok(())
    }

    /// All that can be told before anything moves.
    fn check<S: Sink>(&mut self, frame: &Frame, sink: &S) -> Result<(), SensorError> {
        if self.is_halfway {
            return Err(SensorError::Halfway {
                sensor: self.plan.description.name.clone(),
            });
        }
        let index = frame.index;
        let got = frame.light.size();
        if got != self.size {
            return Err(SensorError::Size {
                index,
                got,
                want: self.size,
            });
        }
        sink.check(self.size, self.plan.weights.len())?;
        check_time(frame, self.seen.map(|(_, last)| last))?;
        self.photoreceptors.see(frame);
        self.photoreceptors.check(frame)
    }

    /// Takes a frame that was checked.
    fn take<S: Sink>(&mut self, frame: &Frame, sink: &mut S) -> Result<(), SensorError> {
        let seconds = frame.seconds;
        if let Some(low_pass) = &mut self.low_pass {
            let passed = self.seen.map(|(_, last)| seconds - last);
            low_pass.see(&self.plan.description, frame, passed)?;
        }
        if let Some(sheets) = &mut self.sheets {
            let light = Light {
                photoreceptors: &self.photoreceptors,
                frame,
                low_pass: self.low_pass.as_ref(),
            };
            sheets.see(&self.plan.number, light)?;
        }
        let Some((start, from)) = self.seen else {
            self.seen = Some((seconds, seconds));
            return self.settle(frame);
        };
        self.seen = Some((start, seconds));
        let interval = Interval {
            index: self.intervals,
            from,
            to: seconds,
        };
        self.intervals += 1;
        let refractory = &self.plan.description.refractory;
        self.muted += u64::from(refractory.mutes(from, seconds));
        self.advance(frame, interval, seconds - start, sink)
    }

    /// Takes the first frame.
    fn settle(&mut self, frame: &Frame) -> Result<(), SensorError> {
        let Self {
            plan, size, reach, ..
        } = self;
        let light = Light {
            photoreceptors: &self.photoreceptors,
            frame,
            low_pass: self.low_pass.as_ref(),
        };
        let settle = |rows: &Range<usize>| {
            let signal = Padded::new(*size, rows.clone(), *reach, N::ZERO);
            Band::settle(plan, signal, rows.clone(), light, self.sheets.as_ref())
        };
        let mut bands: Vec<Option<Band<N>>> = self.cut.iter().map(|_| None).collect();
        let jobs = self
            .cut
            .iter()
            .zip(&mut bands)
            .map(|(rows, band)| -> Job<'_, _> {
                Box::new(|| {
                    *band = Some(settle(rows)?);
                    Ok(())
                })
            });
        parallel::all(jobs)?;
        self.bands = bands.into_iter().flatten().collect();
        Ok(())
    }

    fn advance<S: Sink>(
        &mut self,
        frame: &Frame,
        interval: Interval,
        elapsed: f64,
        sink: &mut S,
    ) -> Result<(), SensorError> {
        let light = Light {
            photoreceptors: &self.photoreceptors,
            frame,
            low_pass: self.low_pass.as_ref(),
        };
        let (plan, bands) = (&self.plan, &mut self.bands);
        let holds_pixels = !self.pixels.is_empty();
        if holds_pixels {
            // Kernels read the pixel memory of cells beyond their band.
            let jobs = { bands.iter_mut() }
                .map(|band| -> Job<'_, _> { Box::new(move || band.see(plan, light)) });
            parallel::all(jobs)?;
            self.overflowed += lay_out_pixels(plan, bands, &mut self.pixels);
        }
        let input = IntervalInput {
            light: (!holds_pixels).then_some(light),
            pixels: &self.pixels,
            sheets: self.sheets.as_ref(),
            interval,
            elapsed,
            times: sink.wants_times(),
        };
        let mut parts = sink.begin(interval, &self.cut);
        let one = |(band, part): (&mut Band<N>, &mut S::Band<'_>)| band.advance(plan, input, part);
        let advanced = if bands.len() == 1 || rayon::current_num_threads() == 1 {
            bands.iter_mut().zip(&mut parts).try_for_each(one)
        } else {
            let jobs = { bands.iter_mut().zip(&mut parts) }.map(|(band, part)| -> Job<'_, _> {
                Box::new(move || one((&mut *band, &mut *part)))
            });
            parallel::all(jobs)
        };
        drop(parts);
        advanced?;
        sink.end()
    }
}

/// Copies the pixel memories (or the distances from them) into padded planes that kernels can read;
/// how many distances a fixed-point format does not hold.
fn lay_out_pixels<N: Number>(
    plan: &Plan<N>,
    bands: &[Band<N>],
    pixels: &mut [Padded<N::Held>],
) -> Overflowed {
    let mut overflowed = Overflowed::default();
    for (channel, pixels) in pixels.iter_mut().enumerate() {
        for band in bands {
            for y in band.rows.clone() {
                let row = |row: &mut [N::Held]| {
                    band.memory_row(plan, channel, y, row);
                    if plan.description.memory.is_seen_from_pixels() {
                        if 2.0 * band.most > plan.number.format().limits().1 {
                            overflowed += differences(&plan.number, band.signal.inner(y), row);
                        } else if !plan.exact.is_empty() {
                            overflowed.of += row.len() as u64;
                        }
                        for (held, now) in row.iter_mut().zip(band.signal.inner(y)) {
                            *held = plan.number.sub(*now, *held);
                        }
                    }
                    Ok::<(), Infallible>(())
                };
                let Ok(()) = pixels.fill(y, plan.description.border, N::ZERO, row);
            }
        }
    }
    overflowed
}

/// Rows of a band of a sensor of this size.
const fn band_rows(size: Size) -> usize {
    if size.pixels() >= SMALL {
        BAND_ROWS
    } else if size.height > 0 {
        size.height
    } else {
        1
    }
}

/// The rows of each band.
fn bands(height: usize, rows: usize) -> Vec<Range<usize>> {
    (0..height)
        .step_by(rows)
        .map(|top| top..(top + rows).min(height))
        .collect()
}

impl<N: Number> Sensor for Reference<N> {
    fn name(&self) -> &str {
        &self.plan.description.name
    }

    fn size(&self) -> Size {
        self.size
    }

    fn channels(&self) -> u8 {
        self.plan.weights.len() as u8
    }

    fn names(&self) -> Vec<String> {
        self.plan.description.names()
    }

    fn watch(&mut self, frame: &Frame, packet: &mut Packet) -> Result<(), SensorError> {
        let is_first = self.seen.is_none();
        let buffers = std::mem::take(&mut self.buffers);
        let mut list = EventList::with_buffers(packet, self.limit, buffers);
        // Through that door: no loops of its own for lists alone.
        let sinks = Sinks {
            list: Some(&mut list),
            ..Sinks::default()
        };
        let watched = self.watch_into_sinks(frame, sinks);
        self.buffers = list.into_buffers();
        watched?;
        let t = Micros::from_seconds(frame.seconds);
        if is_first {
            packet.span.0 = t;
        }
        packet.span.1 = t;
        Ok(())
    }

    fn silence(&self) -> Silence {
        let (description, report) = (&self.plan.description, self.report());
        Silence {
            response: description.response,
            reach: description.reach(),
            waits: description.refractory.waits(),
            muted_pairs: report.muted_pairs,
            without_sign: report.without_sign,
            lost: description.lost(self.plan.number.format()),
        }
    }

    fn overflowed(&self) -> Overflowed {
        let Report {
            overflowed, events, ..
        } = self.report();
        // Of a few distances of a fast edge nobody needs to hear.
        let is_few = overflowed.at <= events / 100;
        Overflowed {
            at: if is_few { 0 } else { overflowed.at },
            ..overflowed
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::{Counts, VoxelGrid};
    use proptest::prelude::*;

    fn sensors() -> impl Strategy<Value = String> {
        let memory = proptest::sample::select(vec![
            "memory = \"filtered-step\"",
            "memory = \"filtered-step\"\nrefractory = { us = 700 }",
            "memory = \"filtered-step\"\nrefractory = { us = 300, rule = \"authors\" }",
            "memory = \"filtered-snap\"\npolarity = \"pixel\"\nrefractory = { us = 1500 }",
            "memory = \"raw-snap\"",
            "memory = \"raw-snap\"\nshared = true\nrefractory = { us = 700 }",
            "memory = \"raw-snap\"\nshared = true\npolarity = \"pixel\"",
        ]);
        let noise = proptest::sample::select(vec![
            "",
            "noise = { shot-hz = 200, jitter-us = 100 }",
            "noise = { hot-fraction = 0.1, hot-hz = 900, cutoff-hz = 300 }",
        ]);
        let channels = proptest::sample::subsequence(
            vec![
                "kernel = \"csdvs-5\"\nthreshold = { on = 0.02, off = 0.03 }",
                "kernel = \"laplacian\"\nthreshold = { on = 0.05, off = 0.05, sigma = 0.01 }",
                "pattern = \"2x2\"\nkernel = [\"dvs\", \"sobel-x\", \"csdvs-3\", \"sobel-y\"]\nthreshold = [{ on = 0.1, off = 0.1 }, { on = 0.2, off = 0.1 }, { on = 0.05, off = 0.1 }, { on = 0.1, off = 0.3 }]",
            ],
            1..=3,
        );
        (memory, noise, channels).prop_map(|(memory, noise, channels)| {
            let channels: Vec<_> = channels
                .iter()
                .map(|c| format!("[[channel]]\n{c}\n"))
                .collect();
            format!(
                "response = {{ linear = 255 }}\n{memory}\n{noise}\n{}",
                channels.concat()
            )
        })
    }

    /// Everything that a run says.
    fn watch(text: &str, frames: &[Frame], threads: usize, rows: usize) -> (Packet, Vec<u8>) {
        let description = Description::parse("test.toml", text, &|_| unreachable!()).unwrap();
        let size = Size::of(&frames[0].light);
        let channels = description.channels.len();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let mut reference =
                Reference::in_bands(F64, description, (size, None), 5, rows).unwrap();
            let mut packet = Packet::new(size, channels as u8);
            let mut counts = Counts::new(size, channels);
            let mut grid = VoxelGrid::new(size, channels);
            let mut said = Vec::new();
            for frame in frames {
                let mut list = EventList::new(&mut packet, Limit::default());
                let mut sinks = (&mut list, (&mut counts, &mut grid));
                reference.watch_into(frame, &mut sinks).unwrap();
                for (plane, voxels) in counts.planes().iter().zip(grid.earlier()) {
                    said.extend(plane.iter().flat_map(|count| count.to_le_bytes()));
                    said.extend(voxels.iter().flat_map(|voxel| voxel.to_le_bytes()));
                }
                grid.advance();
            }
            said.extend(format!("{:?}", reference.report()).bytes());
            (packet, said)
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        /// Bit by bit.
        #[test]
        fn nothing_depends_on_bands_and_threads(
            text in sensors(),
            (height, width) in (1usize..40, 1usize..150),
            rows in 1usize..17,
            seed in 0u64..1000,
        ) {
            let frames: Vec<_> = (0..4u64).map(|n| Frame {
                index: n,
                seconds: n as f64 * 0.004 + 1.0,
                light: Plane::from_shape_fn((height, width), |(y, x)| {
                    let mixed = (seed ^ n << 40 ^ (y as u64) << 20 ^ x as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
                    ((mixed >> 40) % 256) as f64
                }).into(),
            }).collect();
            let one = watch(&text, &frames, 1, height);
            for (threads, rows) in [(1, rows), (2, rows), (5, 1)] {
                let other = watch(&text, &frames, threads, rows);
                prop_assert_eq!(&one.0, &other.0);
                prop_assert!(one.1 == other.1);
            }
        }
    }
}
