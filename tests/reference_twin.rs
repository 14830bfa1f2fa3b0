//! The float model against `reference::model`, one cell and one pair of frames at a time, to the
//! bit: every memory rule (of pixels also shared by all kinds) with every polarity, refractory rule
//! and border, one to three kinds of cells, 2x2 patterns, mismatch, leak, noise events, slow
//! photoreceptors, in every number format.
//!
//! What the sensor's rows tell is compared train by train (sign, count, place of the first,
//! spacing), with the memory after each frame and what the report counts. Of events, voxels and
//! counts made from the trains: counts are equal, times are equal to the microsecond next to it
//! (halves may be rounded either way), voxels within 1e-9.
//!
//! And f32 stays within two thresholds of f64, and makes as many events within 1 %.

use std::ops::Range;

use amacrine::{
    elementary,
    event::{Event, Packet},
    kernel::Kernel,
    number::{Bf16, F16, F32, F64, Format, Number, Q, Real},
    plane::{Plane, Size},
    reference::{
        BandSink, Border, Counts, Description, EventList, Interval, Limit, MemoryRule, Reference,
        Sink, Train, TrainRow, VoxelGrid,
        model::{
            self, Cell, FilteredSnap, FilteredStep, MemoryModel, Pixel, PixelStep, RawSnap, Seen,
            Setting,
        },
    },
    scene::Frame,
    sensor::SensorError,
    unit::Micros,
};
use proptest::prelude::*;

type At = (usize, usize);

/// A sink that keeps the trains of a pair.
#[derive(Default)]
struct Told {
    bands: Vec<Vec<One>>,
}

#[derive(Clone)]
struct One {
    channel: usize,
    at: At,
    /// From a row that was told again: noise has made it.
    stray: bool,
    train: Train,
}

struct ToldBand<'a>(&'a mut Vec<One>, Option<At>);

impl Told {
    /// The trains of a channel, pixel by pixel.
    fn of(&self, channel: usize) -> Vec<(At, Train)> {
        let all = self.bands.iter().flatten();
        let own = all.filter(|one| one.channel == channel);
        let mut told: Vec<_> = own.map(|one| (one.at, one.train)).collect();
        told.sort_by_key(|told| told.0);
        told
    }

    /// The stray events of a channel, those of a pixel in order of time.
    fn strays(&self, channel: usize) -> Vec<(At, Train)> {
        let all = self.bands.iter().flatten();
        let strays = all.filter(|one| one.stray && one.channel == channel);
        strays.map(|one| (one.at, one.train)).collect()
    }
}

impl Sink for Told {
    type Band<'a> = ToldBand<'a>;

    fn wants_times(&self) -> bool {
        true
    }

    fn begin(&mut self, _: Interval, bands: &[Range<usize>]) -> Vec<ToldBand<'_>> {
        self.bands = vec![Vec::new(); bands.len()];
        self.bands
            .iter_mut()
            .map(|band| ToldBand(band, None))
            .collect()
    }

    fn end(&mut self) -> Result<(), SensorError> {
        Ok(())
    }
}

impl BandSink for ToldBand<'_> {
    fn row<R: Real>(&mut self, row: &TrainRow<R>) -> Result<(), SensorError> {
        let (channel, y) = (row.channel, row.y);
        let stray = self.1.replace((channel, y)) == Some((channel, y));
        self.0.extend(row.trains().map(|(x, train)| One {
            channel,
            at: (y, x),
            stray,
            train,
        }));
        Ok(())
    }
}

/// What is drawn for the cells of a channel, as the sensor says.
struct Drawn {
    on: Plane<f64>,
    off: Plane<f64>,
    leak: Plane<f64>,
    /// At the first frame.
    memory: Plane<f64>,
    /// The stray events of each pair, heard or not.
    strays: Vec<Vec<(At, Train)>>,
}

/// What the cells of a channel say.
struct Run {
    /// Of each pair.
    trains: Vec<Vec<(At, Train)>>,
    /// After each frame.
    memory: Vec<Plane<f64>>,
    lost: u64,
    without_sign: u64,
}

/// The signal of each frame, with its time in seconds.
fn signals<N: Number>(
    number: &N,
    description: &Description,
    frames: &[Frame],
) -> Vec<(f64, Plane<N::Held>)> {
    let noise = description.noise;
    let mut signals = Vec::new();
    // The frame before, what it says, and what the low-pass makes of it.
    let mut last: Option<(&Frame, Plane<f64>, Plane<f64>)> = None;
    for frame in frames {
        let said = frame
            .light
            .mapv(|light| description.response.apply(light).unwrap());
        let mut u = said.clone();
        if noise.cutoff_hz > 0.0 {
            if let Some((before, earlier, state)) = &last {
                let dt = frame.seconds - before.seconds;
                for (at, u) in u.indexed_iter_mut() {
                    let (earlier, state) = (earlier[at], state[at]);
                    let (nears, joins) = noise.low_pass((before.light[at], frame.light[at]), dt);
                    *u = state + (nears * (earlier - state) + joins * (*u - earlier));
                }
            }
            last = Some((frame, said, u.clone()));
        }
        signals.push((frame.seconds, u.mapv(|u| number.hold(u))));
    }
    signals
}

/// What every cell of a channel sees.
fn look<N: Number>(
    number: &N,
    description: &Description,
    channel: usize,
    (u, memory): (&Plane<N::Held>, &Plane<N::Held>),
    floor: f64,
) -> Plane<Seen<N>> {
    let (channel, border) = (&description.channels[channel], description.border);
    let lines = |kernel| Lines::new(number, kernel);
    let kernels: Vec<_> = channel.kernels.iter().map(lines).collect();
    let memory_kernel = channel.memory_kernel.as_ref().map(lines);
    let change = |at| number.sub(u[at], memory[at]);
    let watched = if description.memory == MemoryRule::RawSnap {
        Plane::from_shape_fn(u.dim(), change)
    } else {
        u.clone()
    };
    Plane::from_shape_fn(u.dim(), |(y, x)| {
        let at = (y, x);
        let drive = kernels[(2 * (y % 2) + x % 2) % kernels.len()].at(number, &watched, border, at);
        Seen {
            signal: u[[y, x]],
            drive: if channel.log_temporal {
                number.hold(elementary::ln(number.value(drive).max(floor) + 1.0))
            } else {
                drive
            },
            memory: match &memory_kernel {
                Some(kernel) => kernel.at(number, memory, border, at),
                None => N::ZERO,
            },
        }
    })
}

/// A kernel as it is summed: row by row; in f32 and f64 rows that are equal are added first.
struct Lines<H> {
    /// Which rows, and their weights.
    lines: Vec<(Vec<usize>, Vec<H>)>,
    reach: At,
}

impl<H: Copy + PartialEq> Lines<H> {
    fn new<N: Number<Held = H>>(number: &N, kernel: &Kernel) -> Self {
        let together = matches!(number.format(), Format::F32 | Format::F64);
        let mut lines: Vec<(Vec<usize>, Vec<H>)> = Vec::new();
        for (row, weights) in kernel.weights().rows().into_iter().enumerate() {
            let weights: Vec<_> = weights.iter().map(|w| number.hold(*w)).collect();
            match lines.iter_mut().find(|line| line.1 == weights) {
                Some(line) if together => line.0.push(row),
                _ => lines.push((vec![row], weights)),
            }
        }
        let reach = kernel.reach();
        Self { lines, reach }
    }

    /// What the kernel makes of a plane at a pixel.
    fn at<N: Number<Held = H>>(
        &self,
        number: &N,
        plane: &Plane<H>,
        border: Border,
        (y, x): At,
    ) -> H {
        let mut sum = N::ZERO;
        for (rows, weights) in &self.lines {
            for (column, weight) in weights.iter().enumerate() {
                let seen = rows
                    .iter()
                    .map(|row| near::<N>(plane, border, (y + row, x + column), self.reach));
                let seen = seen.reduce(|a, b| number.add(a, b)).unwrap();
                sum = number.add(sum, number.mul(*weight, seen));
            }
        }
        sum
    }
}

/// The pixel so far below and right of `reach` pixels off the first.
fn near<N: Number>(plane: &Plane<N::Held>, border: Border, (y, x): At, reach: At) -> N::Held {
    let (height, width) = plane.dim();
    let inside =
        (reach.0..height + reach.0).contains(&y) && (reach.1..width + reach.1).contains(&x);
    if inside || border == Border::Replicate {
        let (y, x) = (y.saturating_sub(reach.0), x.saturating_sub(reach.1));
        plane[[y.min(height - 1), x.min(width - 1)]]
    } else {
        N::ZERO
    }
}

/// The model of every cell of a channel.
fn run<N: Number, M: model::MemoryModel>(
    number: &N,
    description: &Description,
    channel: usize,
    signals: &[(f64, Plane<N::Held>)],
    drawn: &Drawn,
) -> Result<Run, TestCaseError> {
    let (mut from, first) = (signals[0].0, &signals[0].1);
    let seen = look(number, description, channel, (first, first), 0.0);
    let start = |(at, seen): (At, &Seen<N>)| {
        let setting = Setting {
            number: *number,
            on: drawn.on[at],
            off: drawn.off[at],
            leak: drawn.leak[at],
            polarity: description.polarity,
            refractory: description.refractory,
        };
        let memory = if description.noise.leak_hz > 0.0 {
            number.hold(drawn.memory[at])
        } else {
            M::stored(seen)
        };
        Cell::<N, M>::new(setting, from, *seen, memory)
    };
    let mut cells: Vec<_> = seen.indexed_iter().map(start).collect();
    let mut run = Run {
        trains: Vec::new(),
        memory: Vec::new(),
        lost: 0,
        without_sign: 0,
    };
    let held = |cells: &[Cell<N, M>]| {
        let held = cells.iter().map(Cell::memory).collect();
        Plane::from_shape_vec(first.dim(), held).unwrap()
    };
    run.memory.push(held(&cells).mapv(|m| number.value(m)));
    if description.noise.leak_hz > 0.0 {
        for ((at, seen), memory) in seen.indexed_iter().zip(&drawn.memory) {
            // Less than a threshold has leaked before.
            let fallen = number.value(M::stored(seen)) - memory;
            prop_assert!(
                (-0.02..drawn.on[at] * 1.01 + 0.02).contains(&fallen),
                "{}",
                fallen
            );
        }
    }
    for (index, (to, u)) in signals[1..].iter().enumerate() {
        let (index, to) = (index as u64, *to);
        let pair = Interval { index, from, to };
        from = to;
        let memory = held(&cells);
        let seen = look(number, description, channel, (u, &memory), 1e-8);
        let cells_seen = cells.iter_mut().zip(seen.indexed_iter());
        let mut trains = Vec::new();
        for (cell, (at, seen)) in cells_seen {
            let own = cell.see(*seen, pair);
            trains.extend(own.map(|train| (at, train)));
            let strays = drawn.strays[index as usize].iter();
            for (_, stray) in strays.filter(|stray| stray.0 == at) {
                if cell.hears(stray.first, own.as_ref(), pair) {
                    let first = N::Real::from_f64(stray.first).to_f64();
                    trains.push((at, Train { first, ..*stray }));
                }
            }
        }
        run.trains.push(trains);
        run.memory.push(held(&cells).mapv(|m| number.value(m)));
    }
    run.lost = cells.iter().map(|cell| cell.lost).sum();
    run.without_sign = cells.iter().map(|cell| cell.without_sign).sum();
    Ok(run)
}

/// The model of every pixel whose kinds share a memory, for all channels.
fn run_shared<N: Number>(
    number: &N,
    description: &Description,
    signals: &[(f64, Plane<N::Held>)],
    drawn: &[Drawn],
) -> Vec<Run> {
    let (mut from, first) = (signals[0].0, &signals[0].1);
    let seen_by_all = |u: &Plane<N::Held>, memory: &Plane<N::Held>, floor: f64| {
        let each = 0..drawn.len();
        each.map(|channel| look(number, description, channel, (u, memory), floor))
            .collect::<Vec<_>>()
    };
    let seen = seen_by_all(first, first, 0.0);
    let pixel = |at: At| {
        let cell = |(drawn, seen): (&Drawn, &Plane<Seen<N>>)| {
            let setting = Setting {
                number: *number,
                on: drawn.on[at],
                off: drawn.off[at],
                leak: 0.0,
                polarity: description.polarity,
                refractory: description.refractory,
            };
            Cell::<N, RawSnap>::new(setting, from, seen[at], RawSnap::stored(&seen[at]))
        };
        Pixel::new(drawn.iter().zip(&seen).map(cell).collect())
    };
    let mut pixels: Vec<(At, Pixel<N>)> = first
        .indexed_iter()
        .map(|(at, _)| (at, pixel(at)))
        .collect();
    let held = |pixels: &[(At, Pixel<N>)]| {
        let held = pixels.iter().map(|(_, pixel)| pixel.memory()).collect();
        Plane::from_shape_vec(first.dim(), held).unwrap()
    };
    let values = held(&pixels).mapv(|m| number.value(m));
    let start = || Run {
        trains: Vec::new(),
        memory: vec![values.clone()],
        lost: 0,
        without_sign: 0,
    };
    let mut runs: Vec<Run> = drawn.iter().map(|_| start()).collect();
    for (index, (to, u)) in signals[1..].iter().enumerate() {
        let (pair, to) = (index, *to);
        let index = index as u64;
        let interval = Interval { index, from, to };
        from = to;
        let memory = held(&pixels);
        let seen = seen_by_all(u, &memory, 1e-8);
        let mut trains = vec![Vec::new(); drawn.len()];
        for (at, pixel) in &mut pixels {
            let own: Vec<_> = seen.iter().map(|seen| seen[*at]).collect();
            let told = pixel.see(&own, interval);
            let cells = pixel.cells_mut().iter_mut().zip(drawn);
            for ((told, (cell, drawn)), trains) in told.iter().zip(cells).zip(&mut trains) {
                trains.extend(told.map(|train| (*at, train)));
                let strays = drawn.strays[pair].iter();
                for (_, stray) in strays.filter(|stray| stray.0 == *at) {
                    if cell.hears(stray.first, told.as_ref(), interval) {
                        let first = N::Real::from_f64(stray.first).to_f64();
                        trains.push((*at, Train { first, ..*stray }));
                    }
                }
            }
        }
        let values = held(&pixels).mapv(|m| number.value(m));
        for (run, trains) in runs.iter_mut().zip(trains) {
            run.trains.push(trains);
            run.memory.push(values.clone());
        }
    }
    for (channel, run) in runs.iter_mut().enumerate() {
        let cells = pixels
            .iter_mut()
            .map(|(_, pixel)| &pixel.cells_mut()[channel]);
        for cell in cells {
            run.lost += cell.lost;
            run.without_sign += cell.without_sign;
        }
    }
    runs
}

/// Holds the sensor to the model, train by train and bit by bit; what the model said.
fn judge<N: Number>(
    number: N,
    description: &Description,
    frames: &[Frame],
    seed: u64,
) -> Result<Vec<Run>, TestCaseError> {
    let (size, kinds) = (Size::of(&frames[0].light), description.channels.len());
    let sensor = || Reference::with_number(number, description.clone(), size, seed).unwrap();
    let (mut sensor, mut counting) = (sensor(), sensor());
    let mut told = Told::default();
    sensor.watch_into(&frames[0], &mut told).unwrap();
    let nominal = |channel: usize, (y, x): At| {
        let thresholds = &description.channels[channel].thresholds;
        thresholds[(2 * (y % 2) + x % 2) % thresholds.len()]
    };
    let signals = signals(&number, description, frames);
    // A sensor that never rests hears all strays; in f64 their times are as they were drawn.
    let mut restless = description.clone();
    restless.refractory.us = 0.0;
    let mut restless = Reference::new(restless, size, seed).unwrap();
    let mut strays = vec![Vec::new(); kinds];
    for (n, frame) in frames.iter().enumerate() {
        let mut told = Told::default();
        restless.watch_into(frame, &mut told).unwrap();
        for (channel, strays) in strays.iter_mut().enumerate().filter(|_| n > 0) {
            strays.push(told.strays(channel));
        }
    }
    let mut all_drawn = Vec::new();
    for (channel, strays) in strays.into_iter().enumerate() {
        let [on, off] = sensor.thresholds(channel).unwrap();
        let leak = sensor.leak(channel).unwrap();
        let memory = sensor.memory(channel).unwrap();
        for (at, on) in on.indexed_iter() {
            // Where nothing is drawn, it is what is written.
            let nominal = nominal(channel, at);
            let held = |theta| N::Real::from_f64(theta).to_f64();
            if nominal.sigma == 0.0 {
                prop_assert_eq!([*on, off[at]], [held(nominal.on), held(nominal.off)]);
            }
            if description.noise.leak_spread == 0.0 {
                prop_assert_eq!(leak[at], held(description.noise.leak_hz * on));
            }
        }
        let drawn = Drawn {
            on,
            off,
            leak,
            memory,
            strays,
        };
        all_drawn.push(drawn);
    }
    let run = match description.memory {
        MemoryRule::RawSnap => run::<N, RawSnap>,
        MemoryRule::FilteredSnap => run::<N, FilteredSnap>,
        MemoryRule::FilteredStep => run::<N, FilteredStep>,
        MemoryRule::AuthorsPixelStep => run::<N, PixelStep>,
    };
    let runs: Vec<Run> = if description.shared {
        run_shared(&number, description, &signals, &all_drawn)
    } else {
        let each = all_drawn.iter().enumerate();
        each.map(|(channel, drawn)| run(&number, description, channel, &signals, drawn))
            .collect::<Result<_, _>>()?
    };

    let mut counts = Counts::new(size, kinds);
    for (n, frame) in frames.iter().enumerate() {
        if n > 0 {
            sensor.watch_into(frame, &mut told).unwrap();
        }
        counting.watch_into(frame, &mut counts).unwrap();
        for (channel, run) in runs.iter().enumerate() {
            prop_assert_eq!(&sensor.memory(channel).unwrap(), &run.memory[n]);
            let Some(pair) = n.checked_sub(1) else {
                continue;
            };
            let told = told.of(channel);
            let said = &run.trains[pair];
            for (told, said) in told.iter().zip(said) {
                let bits = |t: &Train| (t.first.to_bits(), t.spacing.to_bits());
                prop_assert_eq!(told, said, "pair {}, channel {}", pair, channel);
                prop_assert_eq!(bits(&told.1), bits(&said.1));
            }
            prop_assert_eq!(told.len(), said.len());
            prop_assert_eq!(&counts.planes()[channel], &counted(said, size));
        }
    }
    let report = sensor.report();
    let trains = runs.iter().flat_map(|run| run.trains.iter().flatten());
    prop_assert_eq!(
        report.events,
        trains.map(|(_, train)| train.count).sum::<u64>()
    );
    prop_assert_eq!(
        report.without_sign,
        runs.iter().map(|run| run.without_sign).sum::<u64>()
    );
    prop_assert_eq!(
        report.lost_to_refractory,
        runs.iter().map(|run| run.lost).sum::<u64>()
    );
    Ok(runs)
}

/// ON events less OFF events.
fn counted(trains: &[(At, Train)], size: Size) -> Plane<i32> {
    let mut counts = Plane::zeros(size.shape());
    for (at, train) in trains {
        counts[*at] += train.polarity.sign() * train.count as i32;
    }
    counts
}

fn channels() -> impl Strategy<Value = Vec<String>> {
    let kernel = proptest::sample::select(vec![
        "\"dvs\"",
        "\"csdvs-3\"",
        "\"csdvs-5\"",
        "\"laplacian\"",
        "\"sobel-x\"",
        "[[0.5, 1, -0.25, 0.125, 3]]",
        "[[1], [-0.5], [0.25]]",
    ]);
    let sigma = proptest::sample::select(vec!["", "", ", sigma = 0.02"]);
    let threshold = (1u32..40, 1u32..40, sigma).prop_map(|(on, off, sigma)| {
        let (on, off) = (f64::from(on) * 0.01, f64::from(off) * 0.01);
        format!("{{ on = {on:?}, off = {off:?}{sigma} }}")
    });
    let four = |one: &[String]| format!("[{}]", one.join(", "));
    let channel = (
        proptest::collection::vec((kernel, threshold), 4),
        any::<bool>(),
        any::<bool>(),
    );
    let text = channel.prop_map(move |(pairs, pattern, equal)| {
        let (kernels, mut thresholds): (Vec<_>, Vec<_>) =
            pairs.into_iter().map(|(k, t)| (k.to_owned(), t)).unzip();
        if equal {
            thresholds.fill("{ on = 0.1, off = 0.1 }".to_owned());
        }
        if pattern {
            let (kernels, thresholds) = (four(&kernels), four(&thresholds));
            format!("pattern = \"2x2\"\nkernel = {kernels}\nthreshold = {thresholds}")
        } else {
            format!("kernel = {}\nthreshold = {}", kernels[0], thresholds[0])
        }
    });
    proptest::collection::vec(text, 1..=3)
}

/// Every rule that a sensor file may combine.
fn sensors() -> impl Strategy<Value = String> {
    let memory = proptest::sample::select(vec![
        ("raw-snap", "filtered", "dead-time"),
        ("raw-snap", "pixel", "dead-time"),
        ("raw-snap\"\nshared = true # \"", "filtered", "dead-time"),
        ("raw-snap\"\nshared = true # \"", "pixel", "dead-time"),
        ("filtered-snap", "filtered", "dead-time"),
        ("filtered-snap", "pixel", "dead-time"),
        ("filtered-step", "filtered", "dead-time"),
        ("filtered-step", "filtered", "authors"),
        ("authors-pixel-step", "filtered", "authors"),
    ]);
    let refractory = proptest::sample::select(vec![0, 0, 300, 1000, 2500, 7000]);
    let border = proptest::sample::select(vec!["replicate", "zero"]);
    let noise = proptest::sample::select(vec![
        ("", false),
        ("", false),
        ("cutoff-hz = 900", false),
        ("cutoff-hz = 900, cutoff-rule = \"step\"", false),
        ("shot-hz = 200, hot-fraction = 0.1, hot-hz = 900", false),
        ("leak-hz = 150", true),
        ("leak-hz = 20, shot-hz = 300", true),
        ("leak-hz = 30, leak-spread = 0.4, cutoff-hz = 2000", true),
    ]);
    (memory, refractory, border, noise, channels(), any::<bool>()).prop_map(
        |((memory, polarity, rule), us, border, (noise, leaks), channels, log)| {
            let can_leak = memory.starts_with("filtered") && rule == "dead-time";
            let noise = if leaks && !can_leak { "" } else { noise };
            let mut text = format!(
                "response = \"identity\"\nmemory = \"{memory}\"\npolarity = \"{polarity}\"\nborder = \"{border}\"\nrefractory = {{ us = {us}, rule = \"{rule}\" }}\nnoise = {{ {noise} }}\n"
            );
            for channel in channels {
                text.extend(["[[channel]]\n", &channel, "\n"]);
                if memory == "authors-pixel-step" {
                    text += "memory-kernel = \"csdvs-3\"\n";
                }
                if log && memory == "filtered-step" {
                    text += "log-temporal = true\n";
                }
            }
            text
        },
    )
}

/// A scene to be made: small, so that a failure can be read.
#[derive(Clone, Copy, Debug)]
struct Noise {
    size: (usize, usize),
    frames: u64,
    seed: u64,
}

impl Noise {
    /// Frames at uneven times, of light that often moves by whole hundredths.
    fn frames(self) -> Vec<Frame> {
        let mut seconds = 0.0;
        let frame = |n: u64| {
            let hash = |y: usize, x: usize| {
                let mut h = self.seed << 48 ^ n << 32 ^ (y as u64) << 16 ^ x as u64;
                for _ in 0..3 {
                    h = (h ^ h >> 29).wrapping_mul(0x9E37_79B9_7F4A_7C15);
                }
                h >> 32
            };
            seconds += (500 + hash(999, 0) % 5000) as f64 * 1e-6;
            let shift = (hash(999, 1) % 3) as f64 * 0.003;
            Frame {
                index: n,
                seconds,
                light: Plane::from_shape_fn(self.size, |(y, x)| {
                    (hash(y, x) % 100) as f64 * 0.01 + shift
                })
                .into(),
            }
        };
        (0..self.frames).map(frame).collect()
    }

    /// The same as 8-bit video.
    fn bytes(self) -> Vec<Frame> {
        let mut frames = self.frames();
        for frame in &mut frames {
            frame.light.mapv_inplace(|light| (light * 255.0).floor());
        }
        frames
    }
}

fn scenes() -> impl Strategy<Value = Noise> {
    ((1usize..12, 1usize..80), 2u64..6, 0u64..1 << 16).prop_map(|(size, frames, seed)| Noise {
        size,
        frames,
        seed,
    })
}

fn parse(text: &str) -> Description {
    Description::parse("twin.toml", text, &|_| unreachable!()).unwrap()
}

/// Holds the sensor to the model in the number format of a test case.
fn judge_in(which: usize, sensor: &Description, frames: &[Frame]) -> Result<(), TestCaseError> {
    let runs = match which {
        0 => judge(F32, sensor, frames, 3),
        1 => judge(F16, sensor, frames, 3),
        2 => judge(Bf16, sensor, frames, 3),
        3 => judge(Q::<i8>::new(5), sensor, frames, 3),
        4 => judge(Q::<i16>::new(8), sensor, frames, 3),
        _ => judge(Q::<i32>::new(16), sensor, frames, 3),
    };
    runs.map(|_| ())
}

proptest! {
    #[test]
    fn the_model_says_the_same(text in sensors(), scene in scenes(), which in 0usize..6) {
        let frames = scene.frames();
        let description = parse(&text);
        let runs = judge(F64, &description, &frames, 3)?;
        judge_in(which, &description, &frames)?;

        // What is made of the trains.
        let size = Size::of(&frames[0].light);
        let kinds = description.channels.len();
        // What noise adds to a row comes after it.
        let strays = description.noise.fires();
        let mut reference = Reference::new(description, size, 3).unwrap();
        let mut packet = Packet::new(size, kinds as u8);
        let mut counts = Counts::new(size, kinds);
        let mut grid = VoxelGrid::new(size, kinds);
        let mut slow = Vec::new();
        let mut later = vec![Plane::<f64>::zeros(size.shape()); kinds];
        for (n, frame) in frames.iter().enumerate() {
            let told = packet.events.len();
            let mut list = EventList::new(&mut packet, Limit::default());
            reference.watch_into(frame, &mut (&mut list, (&mut counts, &mut grid))).unwrap();
            let order = |e: &Event| (e.t, e.y, e.channel, if strays { 0 } else { e.x });
            prop_assert!(packet.events[told..].is_sorted_by_key(order));
            if n == 0 {
                continue;
            }
            let (from, to) = (frames[n - 1].seconds, frame.seconds);
            for (channel, run) in runs.iter().enumerate() {
                let mut earlier = std::mem::replace(&mut later[channel], Plane::zeros(size.shape()));
                for ((y, x), train) in &run.trains[n - 1] {
                    for place in (0..train.count).map(|i| train.at(i)) {
                        let sign = f64::from(train.polarity.sign());
                        earlier[[*y, *x]] += sign * (1.0 - place);
                        later[channel][[*y, *x]] += sign * place;
                        slow.push(Event {
                            t: Micros::from_seconds(from + place * (to - from)),
                            x: *x as u16,
                            y: *y as u16,
                            polarity: train.polarity,
                            channel: channel as u8,
                        });
                    }
                }
                prop_assert_eq!(&counted(&run.trains[n - 1], size), &counts.planes()[channel]);
                near_by(&grid.earlier()[channel], &earlier)?;
            }
            grid.advance();
        }
        for (channel, later) in later.iter().enumerate() {
            near_by(&grid.earlier()[channel], later)?;
        }

        prop_assert!(packet.events.is_sorted_by_key(|e| e.t));
        let by_cell = |e: &Event| (e.channel, e.y, e.x, e.polarity, e.t);
        let mut fast = packet.events;
        fast.sort_by_key(by_cell);
        slow.sort_by_key(by_cell);
        prop_assert_eq!(fast.len(), slow.len());
        for (fast, slow) in fast.iter().zip(&slow) {
            prop_assert!(fast.t.0.abs_diff(slow.t.0) <= 1, "{:?} {:?}", fast, slow);
            prop_assert_eq!(Event { t: slow.t, ..*fast }, *slow);
        }
        prop_assert_eq!(reference.report().events, slow.len() as u64);
    }
}

/// Voxels, up to what rounding does to their sum.
fn near_by(fast: &Plane<f64>, slow: &Plane<f64>) -> Result<(), TestCaseError> {
    for (fast, slow) in fast.iter().zip(slow) {
        prop_assert!((fast - slow).abs() <= 1e-9, "{}, not {}", fast, slow);
    }
    Ok(())
}

/// The counts of each pair and the memory at the end.
fn watched<N: Number>(
    number: N,
    description: &Description,
    frames: &[Frame],
) -> (Vec<Plane<i32>>, Plane<f64>) {
    let size = Size::of(&frames[0].light);
    let mut reference = Reference::with_number(number, description.clone(), size, 0).unwrap();
    let mut counts = Counts::new(size, 1);
    let mut all = Vec::new();
    for frame in frames {
        reference.watch_into(frame, &mut counts).unwrap();
        all.push(counts.planes()[0].clone());
    }
    all.remove(0);
    (all, reference.memory(0).unwrap())
}

const STEPPED: &str = "response = { linear = 255 }\nmemory = \"filtered-step\"\n[[channel]]\nkernel = \"csdvs-5\"\nthreshold = { on = 0.0625, off = 0.0625 }\n";

proptest! {
    /// Video, and whole numbers of thresholds or not.
    #[test]
    fn every_format_is_the_model(scene in scenes(), whole: bool) {
        let description = parse(STEPPED);
        let mut frames = scene.bytes();
        if !whole {
            for frame in &mut frames {
                frame.light.mapv_inplace(|light| light * 0.7 + 0.3);
            }
        }
        macro_rules! same {
            ($($number:expr),*) => {$( judge($number, &description, &frames, 0)?; )*};
        }
        same!(F64, F32, F16, Bf16, Q::<i16>::new(8), Q::<i32>::new(16), Q::<i8>::new(6));
        // Millions of thresholds at once, in some cells.
        for frame in &mut frames {
            frame.light.indexed_iter_mut().for_each(|((_, x), light)| *light *= if x % 7 == 3 { 1e6 } else { 1.0 });
        }
        same!(F64, F32, Bf16);
    }

    /// Both memories lie within a threshold of nearly the same drive.
    #[test]
    fn single_precision_stays_near_double(scene in scenes()) {
        let description = parse(STEPPED);
        let frames = scene.bytes();
        let (single, double) = (watched(F32, &description, &frames), watched(F64, &description, &frames));
        // 25 products and sums of signals up to 1.3, each rounded to 24 bits.
        let rounding = 50.0 * 1.3 * f64::from(f32::EPSILON);
        let within = 2.0 * 0.0625 + rounding;
        for (single, double) in single.1.iter().zip(&double.1) {
            prop_assert!((single - double).abs() <= within, "{} and {}", single, double);
        }
        let events = |pairs: &[Plane<i32>]| pairs.iter().flatten().map(|n| n.abs()).sum::<i32>();
        let (single, double) = (events(&single.0), events(&double.0));
        prop_assert!((single - double).abs() <= 2 + double / 100, "{} and {} events", single, double);
    }
}
