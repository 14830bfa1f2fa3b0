//! The float model against a slow twin that was written from its documentation: pixel by pixel,
//! event by event, in double precision; every memory rule with every polarity, refractory rule
//! and border, one to three kinds of cells, 2x2 patterns.
//!
//! Counts are equal, times are equal to the microsecond next to it (halves may be rounded
//! either way), voxels and memory within 1e-9.
//!
//! And the formats: against a per-pixel twin that computes with the same `Number`, counts are
//! equal, up to millions a pair; f32 stays within two thresholds of f64, and makes as many
//! events within 1 %.

use amacrine::{
    event::{Event, Packet, Polarity},
    number::{Bf16, F16, F32, F64, Format, Number, Q, Real},
    plane::{Plane, Size},
    reference::{
        Border, Channel, Counts, Description, EventList, Limit, MemoryRule, PolarityRule,
        Reference, RefractoryRule, Threshold, VoxelGrid,
    },
    scene::Frame,
    unit::Micros,
};
use proptest::prelude::*;

/// One kind of cell, slowly.
struct Twin<'a> {
    description: &'a Description,
    channel: &'a Channel,
    number: usize,
    /// At the last frame.
    seconds: f64,
    drive: Plane<f64>,
    /// What the memory was at the first frame, or when it last snapped.
    base: Plane<f64>,
    /// Steps up and steps down since the first frame.
    steps: Plane<(f64, f64)>,
    /// The signal when the cell last fired.
    pixel: Plane<f64>,
    fired: Plane<f64>,
    events: Vec<Event>,
    /// Of the current pair.
    counts: Plane<i32>,
    /// All bins so far.
    voxels: Vec<Plane<f64>>,
    without_sign: u64,
    lost: u64,
}

impl<'a> Twin<'a> {
    fn new(description: &'a Description, number: usize, first: &Frame) -> Self {
        let channel = &description.channels[number];
        let size = Size::of(&first.light).shape();
        let signal = first
            .light
            .mapv(|light| description.response.apply(light).unwrap());
        let mut drive = Self::filtered(description, channel, &signal);
        if channel.log_temporal {
            drive.mapv_inplace(|s| (s.max(0.0) + 1.0).ln());
        }
        let holds_pixels = matches!(
            description.memory,
            MemoryRule::RawSnap | MemoryRule::AuthorsPixelStep
        );
        Self {
            description,
            channel,
            number,
            seconds: first.seconds,
            base: if holds_pixels {
                signal.clone()
            } else {
                drive.clone()
            },
            drive,
            steps: Plane::from_elem(size, (0.0, 0.0)),
            pixel: signal,
            fired: Plane::from_elem(size, f64::NEG_INFINITY),
            events: Vec::new(),
            counts: Plane::zeros(size),
            voxels: vec![Plane::zeros(size)],
            without_sign: 0,
            lost: 0,
        }
    }

    /// `sum over d of W(d) u(p + d)`
    fn filtered(description: &Description, channel: &Channel, u: &Plane<f64>) -> Plane<f64> {
        Plane::from_shape_fn(u.dim(), |(y, x)| {
            let four = 2 * (y % 2) + x % 2;
            let kernel = &channel.kernels[four % channel.kernels.len()];
            weighted(kernel.weights(), description.border, u, y, x)
        })
    }

    fn threshold(&self, y: usize, x: usize) -> Threshold {
        self.channel.thresholds[(2 * (y % 2) + x % 2) % self.channel.thresholds.len()]
    }

    fn memory(&self, y: usize, x: usize) -> f64 {
        let (up, down) = self.steps[[y, x]];
        let threshold = self.threshold(y, x);
        self.base[[y, x]] + up * threshold.on - down * threshold.off
    }

    fn watch(&mut self, frame: &Frame) {
        let response = self.description.response;
        let u = frame.light.mapv(|light| response.apply(light).unwrap());
        self.counts.fill(0);
        self.voxels.push(Plane::zeros(u.dim()));
        let mut drive = Self::filtered(self.description, self.channel, &u);
        if self.channel.log_temporal {
            drive.mapv_inplace(|s| (s.max(1e-8) + 1.0).ln());
        }
        let memory = Plane::from_shape_fn(u.dim(), |(y, x)| self.memory(y, x));
        let distance = match self.description.memory {
            MemoryRule::RawSnap => {
                Self::filtered(self.description, self.channel, &(&u - &self.base))
            }
            MemoryRule::AuthorsPixelStep => {
                let kernel = self.channel.memory_kernel.as_ref().unwrap().weights();
                let border = self.description.border;
                let seen = |(y, x)| weighted(kernel, border, &memory, y, x);
                &drive - &Plane::from_shape_fn(u.dim(), seen)
            }
            MemoryRule::FilteredSnap | MemoryRule::FilteredStep => &drive - &memory,
        };
        for ((y, x), &d) in distance.indexed_iter() {
            match self.description.memory {
                MemoryRule::RawSnap | MemoryRule::FilteredSnap => {
                    self.snap(frame.seconds, (y, x), d, drive[[y, x]], u[[y, x]]);
                }
                _ if self.description.refractory.rule == RefractoryRule::Authors => {
                    self.authors(frame.seconds, (y, x), d);
                }
                _ => {
                    let before = self.drive[[y, x]] - memory[[y, x]];
                    self.step(frame.seconds, (y, x), before, d);
                }
            }
        }
        self.drive = drive;
        self.seconds = frame.seconds;
    }

    /// Fires once, at the frame, when the distance is more than the threshold.
    fn snap(&mut self, now: f64, at: (usize, usize), d: f64, drive: f64, u: f64) {
        let threshold = self.threshold(at.0, at.1);
        if d <= threshold.on && -d <= threshold.off {
            return;
        }
        let own = u - self.pixel[at];
        self.pixel[at] = u;
        self.base[at] = match self.description.memory {
            MemoryRule::RawSnap => u,
            _ => drive,
        };
        let sign = match self.description.polarity {
            PolarityRule::Filtered => d,
            PolarityRule::Pixel => own,
        };
        if sign == 0.0 {
            self.without_sign += 1;
        } else {
            self.emit(now, at, sign, 1.0);
        }
    }

    /// Crosses one threshold after the other, and each moves the memory.
    fn step(&mut self, now: f64, at: (usize, usize), before: f64, d: f64) {
        let threshold = self.threshold(at.0, at.1);
        let (theta, p) = if d >= 0.0 {
            (threshold.on, 1.0)
        } else {
            (threshold.off, -1.0)
        };
        let count = (d.abs() / theta * (1.0 + f64::TIE)).floor();
        for i in 1..=count as u64 {
            let place = (i as f64 * theta - p * before) / (p * (d - before));
            self.emit(now, at, p, place.clamp(0.0, 1.0));
        }
        let steps = &mut self.steps[at];
        if p > 0.0 {
            steps.0 += count;
        } else {
            steps.1 += count;
        }
    }

    /// The supplement's refractory terms.
    fn authors(&mut self, now: f64, at: (usize, usize), d: f64) {
        let threshold = self.threshold(at.0, at.1);
        let theta = if d >= 0.0 {
            threshold.on
        } else {
            threshold.off
        };
        let (delta, r) = (now - self.seconds, self.description.refractory.us * 1e-6);
        if d == 0.0 {
            return;
        }
        let alpha = delta / ((d.abs() + 1e-9) / theta);
        let alpha_r = ((r / alpha).floor() + 1.0) * alpha;
        let wait = ((r - (self.seconds - self.fired[at])) / alpha).floor() * alpha;
        let beta_r = wait.max(0.0);
        if alpha_r > delta - beta_r {
            return;
        }
        let count = ((delta - beta_r) / alpha_r).floor();
        for i in 1..=count as u64 {
            let since = beta_r + i as f64 * alpha_r;
            self.put(at, d, since / delta, self.seconds + since);
            self.fired[at] = self.seconds + since;
        }
        let steps = &mut self.steps[at];
        if d > 0.0 {
            steps.0 += count;
        } else {
            steps.1 += count;
        }
    }

    /// An event, unless the cell still rests.
    fn emit(&mut self, now: f64, at: (usize, usize), sign: f64, place: f64) {
        let t = self.seconds + place * (now - self.seconds);
        let r = self.description.refractory.us * 1e-6;
        if t - self.fired[at] < r * (1.0 - 1e-9) {
            self.lost += 1;
            return;
        }
        self.fired[at] = t;
        self.put(at, sign, place, t);
    }

    fn put(&mut self, (y, x): (usize, usize), sign: f64, place: f64, t: f64) {
        self.events.push(Event {
            t: Micros::from_seconds(t),
            x: x as u16,
            y: y as u16,
            polarity: if sign > 0.0 {
                Polarity::On
            } else {
                Polarity::Off
            },
            channel: self.number as u8,
        });
        self.counts[[y, x]] += sign.signum() as i32;
        let later = self.voxels.len() - 1;
        self.voxels[later - 1][[y, x]] += sign.signum() * (1.0 - place);
        self.voxels[later][[y, x]] += sign.signum() * place;
    }
}

/// The rows of a kernel, those with equal weights together.
fn lines(weights: &Plane<f64>) -> Vec<Vec<usize>> {
    let mut lines: Vec<Vec<usize>> = Vec::new();
    for row in 0..weights.nrows() {
        let equal = |line: &&mut Vec<usize>| weights.row(line[0]) == weights.row(row);
        match lines.iter_mut().find(equal) {
            Some(line) => line.push(row),
            None => lines.push(vec![row]),
        }
    }
    lines
}

/// What a kernel sees at a pixel, summed row by row; rows that are equal are added first.
fn weighted(weights: &Plane<f64>, border: Border, u: &Plane<f64>, y: usize, x: usize) -> f64 {
    let (height, width) = u.dim();
    let (reach_y, reach_x) = (weights.nrows() / 2, weights.ncols() / 2);
    let seen = |ky: usize, kx: usize| {
        let inside = (reach_y..height + reach_y).contains(&(y + ky))
            && (reach_x..width + reach_x).contains(&(x + kx));
        let near = [
            (y + ky).saturating_sub(reach_y).min(height - 1),
            (x + kx).saturating_sub(reach_x).min(width - 1),
        ];
        if inside || border == Border::Replicate {
            u[near]
        } else {
            0.0
        }
    };
    let mut sum = 0.0;
    for rows in lines(weights) {
        for kx in 0..weights.ncols() {
            let seen: f64 = rows.iter().map(|ky| seen(*ky, kx)).sum();
            sum += weights[[rows[0], kx]] * seen;
        }
    }
    sum
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
    let threshold = (1u32..40, 1u32..40).prop_map(|(on, off)| {
        let (on, off) = (f64::from(on) * 0.01, f64::from(off) * 0.01);
        format!("{{ on = {on:?}, off = {off:?} }}")
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
        ("filtered-snap", "filtered", "dead-time"),
        ("filtered-snap", "pixel", "dead-time"),
        ("filtered-step", "filtered", "dead-time"),
        ("filtered-step", "filtered", "authors"),
        ("authors-pixel-step", "filtered", "authors"),
    ]);
    let refractory = proptest::sample::select(vec![0, 0, 300, 1000, 2500, 7000]);
    let border = proptest::sample::select(vec!["replicate", "zero"]);
    (memory, refractory, border, channels(), any::<bool>()).prop_map(
        |((memory, polarity, rule), us, border, channels, log)| {
            let mut text = format!(
                "response = \"identity\"\nmemory = \"{memory}\"\npolarity = \"{polarity}\"\nborder = \"{border}\"\nrefractory = {{ us = {us}, rule = \"{rule}\" }}\n"
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
                }),
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

proptest! {
    #[test]
    fn the_slow_twin_says_the_same(text in sensors(), scene in scenes()) {
        let frames = scene.frames();
        let description = parse(&text);
        let size = Size::of(&frames[0].light);
        let kinds = description.channels.len();
        let mut twins: Vec<_> = (0..kinds).map(|n| Twin::new(&description, n, &frames[0])).collect();
        let mut reference = Reference::new(description.clone(), size, 0).unwrap();
        let mut packet = Packet::new(size, kinds as u8);
        let mut counts = Counts::new(size, kinds);
        let mut grid = VoxelGrid::new(size, kinds);
        let mut bins = Vec::new();
        for (n, frame) in frames.iter().enumerate() {
            let told = packet.events.len();
            let mut list = EventList::new(&mut packet, Limit::default());
            reference.watch_into(frame, &mut (&mut list, (&mut counts, &mut grid))).unwrap();
            let order = |e: &Event| (e.t, e.y, e.channel, e.x);
            prop_assert!(packet.events[told..].is_sorted_by_key(order));
            if n == 0 {
                continue;
            }
            bins.push(grid.earlier().to_vec());
            grid.advance();
            for (twin, counts) in twins.iter_mut().zip(counts.planes()) {
                twin.watch(frame);
                prop_assert_eq!(&twin.counts, counts);
            }
        }
        bins.push(grid.earlier().to_vec());

        prop_assert!(packet.events.is_sorted_by_key(|e| e.t));
        let by_cell = |e: &Event| (e.channel, e.y, e.x, e.t);
        let mut fast = packet.events;
        let mut slow: Vec<_> = twins.iter().flat_map(|twin| twin.events.clone()).collect();
        fast.sort_by_key(by_cell);
        slow.sort_by_key(by_cell);
        prop_assert_eq!(fast.len(), slow.len());
        for (fast, slow) in fast.iter().zip(&slow) {
            prop_assert!(fast.t.0.abs_diff(slow.t.0) <= 1, "{:?} {:?}", fast, slow);
            prop_assert_eq!(Event { t: slow.t, ..*fast }, *slow);
        }

        for (n, twin) in twins.iter().enumerate() {
            for (bin, slow) in twin.voxels.iter().enumerate() {
                for (fast, slow) in bins[bin][n].iter().zip(slow) {
                    prop_assert!((fast - slow).abs() <= 1e-9, "bin {}: {}, not {}", bin, fast, slow);
                }
            }
            for ((y, x), memory) in reference.memory(n).unwrap().indexed_iter() {
                prop_assert!((memory - twin.memory(y, x)).abs() <= 1e-9);
            }
        }
        let report = reference.report();
        prop_assert_eq!(report.events, slow.len() as u64);
        prop_assert_eq!(report.without_sign, twins.iter().map(|t| t.without_sign).sum::<u64>());
        if description.refractory.rule == RefractoryRule::DeadTime {
            prop_assert_eq!(report.lost_to_refractory, twins.iter().map(|t| t.lost).sum::<u64>());
        }
    }
}

/// `filtered-step` with one kernel and equal thresholds, pixel by pixel, in a number format:
/// the signed counts of each pair.
fn step_in<N: Number>(number: &N, description: &Description, frames: &[Frame]) -> Vec<Plane<i32>> {
    let kernel = description.channels[0].kernels[0].weights();
    let theta = N::Real::of(description.channels[0].thresholds[0].on);
    // In narrow formats each row on its own.
    let lines = match number.format() {
        Format::F32 | Format::F64 => lines(kernel),
        _ => (0..kernel.nrows()).map(|row| vec![row]).collect(),
    };
    let drive = |frame: &Frame| {
        let u = frame
            .light
            .mapv(|light| number.hold(description.response.apply(light).unwrap()));
        let (height, width) = u.dim();
        Plane::from_shape_fn(u.dim(), |(y, x)| {
            let mut sum = N::ZERO;
            for rows in &lines {
                for kx in 0..kernel.ncols() {
                    let x = (x + kx).saturating_sub(kernel.ncols() / 2).min(width - 1);
                    let seen = rows.iter().map(|ky| {
                        let y = (y + ky).saturating_sub(kernel.nrows() / 2).min(height - 1);
                        u[[y, x]]
                    });
                    let seen = seen.reduce(|a, b| number.add(a, b)).unwrap();
                    let weight = number.hold(kernel[[rows[0], kx]]);
                    sum = number.add(sum, number.mul(weight, seen));
                }
            }
            sum
        })
    };
    let base = drive(&frames[0]);
    let mut steps = Plane::<i32>::zeros(base.dim());
    let mut all = Vec::new();
    for frame in &frames[1..] {
        let seen = drive(frame);
        let counts = Plane::from_shape_fn(base.dim(), |at| {
            let moved = number.real(base[at]) + N::Real::of_i32(steps[at]) * theta;
            let d = number.real(number.sub(seen[at], number.hold_real(moved)));
            let quotient = d.abs() / theta;
            let (hair, half) = (quotient * N::Real::TIE, N::Real::of(0.5));
            let hair = if hair < half { hair } else { half };
            let whole = (quotient + hair).floor().to_i32();
            if d >= N::Real::ZERO { whole } else { -whole }
        });
        steps += &counts;
        all.push(counts);
    }
    all
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
    #[test]
    fn every_format_is_its_own_twin(scene in scenes(), whole: bool) {
        let description = parse(STEPPED);
        let mut frames = scene.bytes();
        if !whole {
            for frame in &mut frames {
                frame.light.mapv_inplace(|light| light * 0.7 + 0.3);
            }
        }
        macro_rules! same {
            ($($number:expr),*) => {$(
                let fast = watched($number, &description, &frames).0;
                prop_assert_eq!(fast, step_in(&$number, &description, &frames), "{}", $number.format());
            )*};
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
