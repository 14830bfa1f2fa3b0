//! The gradient of the float model: its way forward is the reference's; its way back is the
//! derivative of a smooth stand-in, of which each rule states one; and what these are worth is
//! measured against differences averaged over the phase of the memory, where events are smooth.

use std::fmt::Write as _;

use amacrine::{
    elementary,
    gradient::{
        Ask, Clips, ConstantRate, Float, Forward, Gradient, GradientError, Model, Rule, Slope,
        rate_threshold,
    },
    plane::{Plane, Size},
    reference::{Counts, Description, Reference, VoxelGrid},
    rng::Hash,
    scene::Frame,
};

const FPS: f64 = 240.0;

fn describe(text: &str) -> Description {
    Description::parse("cell.toml", text, &|_| {
        Err(std::io::ErrorKind::NotFound.into())
    })
    .unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// A number from -1 to 1 for a place.
fn random(seed: u64, place: u64) -> f64 {
    2.0 * Hash::new(seed).with(place).uniform() - 1.0
}

/// Rows of a kernel: a centre and its surround, no two weights equal.
fn kernel(side: usize, seed: u64) -> String {
    let weight = |n: usize| {
        let own = if n == side * side / 2 { 1.0 } else { -0.03 };
        own + 0.05 * random(seed, n as u64)
    };
    let row = |y: usize| {
        let row: Vec<_> = (0..side)
            .map(|x| format!("{:?}", weight(y * side + x)))
            .collect();
        format!("[{}]", row.join(", "))
    };
    let rows: Vec<_> = (0..side).map(row).collect();
    format!("[{}]", rows.join(", "))
}

fn channel(side: usize, seed: u64, more: &str) -> String {
    let kernel = kernel(side, seed);
    format!("[[channel]]\nkernel = {kernel}\nthreshold = {{ on = 0.05, off = 0.07 }}\n{more}\n")
}

/// Smooth light of two sizes, 0 to 1, at any place.
fn texture(x: f64, y: f64) -> f64 {
    let layer = |x: f64, y: f64, seed: u64| {
        let at = |x: f64, y: f64| {
            let place = ((x as i64 as u64) << 32) ^ (y as i64 as u64 & 0xffff_ffff);
            0.5 + 0.5 * random(seed, place)
        };
        let (left, top) = (x.floor(), y.floor());
        let (u, v) = (x - left, y - top);
        let row = |y| at(left, y) * (1.0 - u) + at(left + 1.0, y) * u;
        row(top) * (1.0 - v) + row(top + 1.0) * v
    };
    0.55 * layer(x / 5.0, y / 5.0, 1) + 0.45 * layer(x / 2.0, y / 2.0, 2)
}

/// Clips of a texture that moves on, each its own way; light 0 to `white`.
fn pan<R: Float>(clips: usize, frames: usize, size: Size, white: f64) -> Vec<R> {
    let mut light = Vec::new();
    for clip in 0..clips {
        let (dx, dy) = [(0.9, 0.3), (-0.4, 0.7), (0.2, -1.1)][clip % 3];
        for n in 0..frames {
            for y in 0..size.height {
                for x in 0..size.width {
                    let (x, y) = (x as f64 + dx * n as f64, y as f64 + dy * n as f64);
                    let value = white * texture(x + 40.0 * clip as f64, y);
                    light.push(R::from_f64(value));
                }
            }
        }
    }
    light
}

fn times(frames: usize) -> Vec<f64> {
    (0..frames).map(|n| n as f64 / FPS).collect()
}

/// A loss: random weights on all that comes out.
fn weights<R: Float>(seed: u64, count: usize) -> Vec<R> {
    (0..count as u64)
        .map(|n| R::from_f64(random(seed, n)))
        .collect()
}

const SENSORS: [(&str, &str, bool); 9] = [
    ("step", "memory = \"filtered-step\"", false),
    (
        "dead time",
        "memory = \"filtered-step\"\nrefractory = { us = 1000 }",
        false,
    ),
    (
        "authors' rule",
        "memory = \"filtered-step\"\nrefractory = { us = 1000, rule = \"authors\" }",
        false,
    ),
    (
        "authors' rule without a period",
        "memory = \"filtered-step\"\nrefractory = { us = 0, rule = \"authors\" }",
        false,
    ),
    ("snap", "memory = \"filtered-snap\"", false),
    (
        "snap and rest",
        "memory = \"filtered-snap\"\nrefractory = { us = 6000 }",
        false,
    ),
    (
        "zero border",
        "memory = \"filtered-step\"\nborder = \"zero\"",
        false,
    ),
    (
        "pattern",
        "memory = \"filtered-step\"\nrefractory = { us = 500 }",
        true,
    ),
    ("logarithm", "memory = \"filtered-step\"", false),
];

fn sensor((name, rules, pattern): (&str, &str, bool), response: &str, channels: usize) -> String {
    let mut text = format!("response = {response}\n{rules}\n");
    for k in 0..channels as u64 {
        if pattern {
            let kernels: Vec<_> = (0..4)
                .map(|n| kernel(3 + 2 * (n % 2), 10 * k + n as u64))
                .collect();
            let thresholds = "{ on = 0.05, off = 0.07 }, { on = 0.06, off = 0.06 }, { on = 0.08, off = 0.04 }, { on = 0.05, off = 0.05, sigma = 0.01 }";
            let kernels = kernels.join(", ");
            let _ = writeln!(
                text,
                "[[channel]]\npattern = \"2x2\"\nkernel = [{kernels}]\nthreshold = [{thresholds}]"
            );
        } else {
            let more = if name == "logarithm" {
                "log-temporal = true"
            } else {
                ""
            };
            text += &channel(5, 10 * k, more);
        }
    }
    text
}

/// Counts and voxels are those of the reference, to the bit.
fn is_the_reference<R: Float>(text: &str, white: f64, clips: usize, size: Size) {
    const FRAMES: usize = 7;
    let light = pan::<R>(clips, FRAMES, size, white);
    let times = times(FRAMES);
    let model = Model::<R>::new(describe(text), size, 3).unwrap();
    let seen = model
        .forward(Clips::new(&light, &times, size).unwrap())
        .unwrap();
    let [_, frames, channels, ..] = seen.shape();
    assert!(seen.events() > 100, "{} events\n{text}", seen.events());
    let planes = |clip: usize, n: usize, each: usize| {
        let start = (clip * each + n) * channels * size.pixels();
        start..start + channels * size.pixels()
    };
    for (clip, light) in light.chunks(frames * size.pixels()).enumerate() {
        let mut reference = Reference::with_number(R::NUMBER, describe(text), size, 3).unwrap();
        let mut counts = Counts::new(size, channels);
        let mut grid = VoxelGrid::new(size, channels);
        for n in 0..frames {
            let light = light[n * size.pixels()..].iter().map(|v| v.to_f64());
            let light = light.take(size.pixels()).collect();
            let frame = Frame {
                index: n as u64,
                seconds: times[n],
                light: Plane::from_shape_vec(size.shape(), light).unwrap().into(),
            };
            reference
                .watch_into(&frame, &mut (&mut counts, &mut grid))
                .unwrap();
            if n == 0 {
                continue;
            }
            let own = &seen.counts()[planes(clip, n - 1, frames - 1)];
            let theirs: Vec<i32> = counts.planes().iter().flatten().copied().collect();
            assert_eq!(own, theirs, "clip {clip}, pair {}\n{text}", n - 1);
            let own = &seen.voxels()[planes(clip, n - 1, frames)];
            let theirs = grid.earlier().iter().flatten().map(|v| R::from_f64(*v));
            for (own, theirs) in own.iter().zip(theirs) {
                assert_eq!(
                    own.to_f64(),
                    theirs.to_f64(),
                    "clip {clip}, bin {}\n{text}",
                    n - 1
                );
            }
            grid.advance();
        }
    }
}

#[test]
fn forward_is_the_reference() {
    for which in SENSORS {
        let text = sensor(which, "\"identity\"", 2);
        is_the_reference::<f64>(&text, 1.0, 2, Size::new(37, 19));
        is_the_reference::<f32>(&text, 1.0, 2, Size::new(37, 19));
    }
    for response in [
        "{ linear = 255 }",
        "{ log = { white = 255, offset = 1e-2 } }",
        "{ lin-log = { knee = 20 } }",
        "{ linear = { white = 255, round = \"f32\" } }",
    ] {
        let text = sensor(SENSORS[1], response, 1);
        is_the_reference::<f64>(&text, 255.0, 1, Size::new(9, 33));
        is_the_reference::<f32>(&text, 255.0, 1, Size::new(9, 33));
    }
    is_the_reference::<f32>(
        &sensor(SENSORS[2], "\"identity\"", 16),
        1.0,
        1,
        Size::new(6, 7),
    );
}

/// One cell that sees its own pixel alone, and a smooth stand-in for it: what counts whole events
/// moves with the drive, as the rule says; all else is as it is.
struct StandIn {
    kind: &'static str,
    rule: Rule,
    silence: f64,
    /// For each pair, at the point where the derivative is taken.
    base: Vec<Point>,
}

#[derive(Clone, Debug, Default)]
struct Point {
    seen: f64,
    memory: f64,
    sign: f64,
    on: bool,
    r: f64,
    whole: f64,
    kept: f64,
    skip: f64,
    stride: f64,
    ready: f64,
    wait: f64,
    alpha: f64,
    spacing: f64,
    before: f64,
}

impl StandIn {
    const DT: f64 = 1.0 / FPS;

    /// The way forward of the cell itself, event by event.
    fn new(kind: &'static str, rule: Rule, silence: f64, drive: &[f64], theta: [f64; 2]) -> Self {
        let (mut memory, mut fired) = (drive[0], f64::NEG_INFINITY);
        let mut base = Vec::new();
        for n in 1..drive.len() {
            let (from, to) = ((n - 1) as f64 * Self::DT, n as f64 * Self::DT);
            let (d, e) = (drive[n] - memory, drive[n - 1] - memory);
            let on = d >= 0.0;
            let sign = if on { 1.0 } else { -1.0 };
            let theta = theta[usize::from(!on)];
            let mut point = Point {
                seen: drive[n],
                memory,
                sign,
                on,
                r: d.abs() / theta,
                stride: 1.0,
                ready: 1.0,
                ..Point::default()
            };
            match kind {
                "authors" => {
                    point.alpha = Self::DT * theta / (d.abs() + 1e-9);
                    point.spacing = ((silence / point.alpha).floor() + 1.0) * point.alpha;
                    point.wait = (silence - (from - fired)).max(0.0);
                    point.before = (point.wait / point.alpha).floor() * point.alpha;
                    let left = Self::DT - point.before;
                    if point.spacing <= left {
                        point.kept = (left / point.spacing).floor();
                        fired = from + point.before + point.kept * point.spacing;
                    }
                    point.whole = point.kept;
                    memory += sign * point.kept * theta;
                }
                "snap" => {
                    point.whole = if d.abs() > theta { 1.0 } else { 0.0 };
                    let ready = to - fired >= silence * (1.0 - 1e-9);
                    point.ready = if ready { 1.0 } else { 0.0 };
                    point.kept = point.whole * point.ready;
                    if point.whole > 0.0 {
                        memory = drive[n];
                    }
                    if point.kept > 0.0 {
                        fired = to;
                    }
                }
                _ => {
                    point.whole = (point.r + 1e-12).floor();
                    let rise = sign * (d - e);
                    let at = |i: f64| from + (i * theta - sign * e) / rise * Self::DT;
                    let mut kept = Vec::new();
                    for i in 0..point.whole as usize {
                        let time = at(i as f64 + 1.0);
                        if time - fired >= silence * (1.0 - 1e-9) {
                            kept.push(i as f64);
                            fired = time;
                        }
                    }
                    point.kept = kept.len() as f64;
                    point.skip = kept.first().copied().unwrap_or(0.0);
                    let stride = (silence * (1.0 - 1e-9) / (theta / rise * Self::DT)).ceil();
                    point.stride = stride.max(1.0);
                    let ready = to - fired >= silence * (1.0 - 1e-9);
                    point.ready = if ready { 1.0 } else { 0.0 };
                    memory += sign * point.whole * theta;
                }
            }
            base.push(point);
        }
        Self {
            kind,
            rule,
            silence,
            base,
        }
    }

    /// The loss of a play: a memory half a threshold behind, at the mean of all phases.
    fn mean(&self, drive: &[f64], theta: [f64; 2], ask: (&[f64], &[f64], f64)) -> f64 {
        let (voxels, counts, events) = ask;
        let (mut memory, mut loss) = (drive[0], 0.0);
        for n in 1..drive.len() {
            let (from, to) = (drive[n - 1], drive[n]);
            let up = to - theta[0] / 2.0 > memory;
            let down = to + theta[1] / 2.0 < memory;
            if !up && !down {
                continue;
            }
            let (sign, theta) = if up {
                (1.0, theta[0])
            } else {
                (-1.0, theta[1])
            };
            let start = memory + sign * theta / 2.0;
            // Where the drive goes at even speed, the mean of the time of an event.
            let stride =
                (self.silence * (1.0 - 1e-9) / Self::DT * (to - from).abs() / theta).ceil();
            let count = (to - start) / theta / stride.max(1.0);
            let middle = f64::midpoint((start - from) / (to - from), 1.0);
            loss += count * (voxels[n - 1] * (1.0 - middle) + voxels[n] * middle);
            loss += count * counts[n - 1] + events * count.abs();
            memory = to - sign * theta / 2.0;
        }
        loss
    }

    /// The loss of the stand-in, near the point. `ask` has voxels, counts, and events.
    fn loss(&self, drive: &[f64], theta: [f64; 2], ask: (&[f64], &[f64], f64)) -> f64 {
        if self.rule == Rule::Mean {
            return self.mean(drive, theta, ask);
        }
        let mut memory = drive[0];
        let mut loss = 0.0;
        for (n, point) in self.base.iter().enumerate() {
            let (d, e) = (drive[n + 1] - memory, drive[n] - memory);
            let theta = theta[usize::from(!point.on)];
            let sign = point.sign;
            let r = sign * d / theta;
            let alpha = Self::DT * theta / (sign * d + 1e-9);
            // What moves with the drive in place of the count.
            let more = if self.kind == "authors" {
                let count = |alpha: f64| (Self::DT - point.wait) / (self.silence + alpha + 1e-9);
                count(alpha) - count(point.alpha)
            } else {
                r - point.r
            };
            let (kept, later) = match self.kind {
                "authors" if point.kept > 0.0 => {
                    let kept = point.kept + more;
                    let spacing = point.spacing + alpha - point.alpha;
                    let triangle = kept * (kept + 1.0) / 2.0;
                    (kept, (point.before * kept + spacing * triangle) / Self::DT)
                }
                "step" if point.kept > 0.0 => {
                    let kept = point.kept + more / point.stride;
                    let rise = sign * (d - e);
                    let first = ((1.0 + point.skip) * theta - sign * e) / rise;
                    let spacing = point.stride * theta / rise;
                    (kept, kept * first + spacing * kept * (kept - 1.0) / 2.0)
                }
                _ => {
                    let kept = point.kept + point.ready * more;
                    (kept, kept)
                }
            };
            let (voxels, counts, events) = ask;
            loss += sign * (voxels[n] * (kept - later) + voxels[n + 1] * later);
            loss += sign * counts[n] * kept + events * kept;
            let moved = match self.rule {
                Rule::Through => 1.0,
                Rule::Reset if point.whole > 0.0 => 1.0,
                _ => 0.0,
            };
            let next = self.base.get(n + 1).map_or(0.0, |next| next.memory);
            memory = if self.rule == Rule::Authors {
                next + drive[0] - self.base[0].memory
            } else if self.kind == "snap" {
                next + moved * (drive[n + 1] - point.seen) + (1.0 - moved) * (memory - point.memory)
            } else {
                memory + sign * (point.whole + moved * more) * theta
            };
        }
        loss
    }
}

/// Light that goes up and down by several thresholds, and by parts of one.
fn wander(seed: u64, frames: usize) -> Vec<f64> {
    let mut light = vec![1.0];
    for n in 1..frames {
        let size = if random(seed, 3 * n as u64) > 0.0 {
            0.9
        } else {
            0.25
        };
        light.push(light[n - 1] + size * random(seed, 3 * n as u64 + 1));
    }
    light
}

#[test]
fn each_rule_is_the_derivative_of_its_stand_in() {
    const FRAMES: usize = 14;
    const THETA: [f64; 2] = [0.21, 0.17];
    let (mut events, mut silent, mut cases) = (0, 0, 0);
    for (kind, memory, us) in [
        ("step", "filtered-step", 0.0),
        ("step", "filtered-step", 1100.0),
        ("step", "filtered-step", 5000.0),
        ("snap", "filtered-snap", 0.0),
        ("snap", "filtered-snap", 5000.0),
        ("authors", "filtered-step", 0.0),
        ("authors", "filtered-step", 1100.0),
    ] {
        let word = if kind == "authors" {
            "authors"
        } else {
            "dead-time"
        };
        let text = |gain: f64| {
            format!(
                "response = \"identity\"\nmemory = \"{memory}\"\nrefractory = {{ us = {us:?}, rule = \"{word}\" }}\n[[channel]]\nkernel = [[{gain:?}]]\nthreshold = {{ on = {:?}, off = {:?} }}",
                THETA[0], THETA[1]
            )
        };
        for rule in [Rule::Authors, Rule::Reset, Rule::Through, Rule::Mean] {
            if rule == Rule::Mean && kind != "step" {
                continue;
            }
            if kind == "authors" && rule == Rule::Authors {
                // The released surrogates are no derivative of anything: `gradient_oracle.rs`.
                continue;
            }
            for seed in 0..12 {
                let light = wander(seed, FRAMES);
                let size = Size::new(1, 1);
                let model = Model::<f64>::new(describe(&text(1.0)), size, 0).unwrap();
                let times = times(FRAMES);
                let clips = Clips::new(&light, &times, size).unwrap();
                let seen = model.forward(clips).unwrap();
                let (voxels, counts) = (weights(seed + 50, FRAMES), weights(seed + 90, FRAMES - 1));
                let ask = Ask {
                    voxels: Some(&voxels),
                    counts: Some(&counts),
                    events: 0.3,
                    slope: Slope::All,
                    light: true,
                };
                let gradient = model.backward(&seen, &ask, rule).unwrap();
                let us = us * 1e-6;
                let stand_in = StandIn::new(kind, rule, us, &light, THETA);
                let counted: Vec<i32> = stand_in
                    .base
                    .iter()
                    .map(|p| (p.sign * p.kept) as i32)
                    .collect();
                assert_eq!(seen.counts(), counted, "{kind}, {us}, {rule:?}, {seed}");
                events += seen.events();
                silent += counted.iter().filter(|n| **n == 0).count();
                let ask = (&voxels[..], &counts[..], 0.3);
                let step = 1e-6;
                let near = |what: &str, own: f64, loss: &dyn Fn(f64) -> f64| {
                    // Of fourth order, so that the step may be larger than rounding.
                    let central = |h: f64| (loss(h) - loss(-h)) / (2.0 * h);
                    let difference = (4.0 * central(step) - central(2.0 * step)) / 3.0;
                    assert!(
                        (own - difference).abs() <= 1e-6 * difference.abs().max(1.0),
                        "{kind}, {us} s, {rule:?}, seed {seed}: {what} is {own}, not {difference}"
                    );
                };
                for n in 0..FRAMES {
                    near(
                        &format!("light {n}"),
                        gradient.light.as_ref().unwrap()[n],
                        &|h| {
                            let mut light = light.clone();
                            light[n] += h;
                            stand_in.loss(&light, THETA, ask)
                        },
                    );
                }
                let own = &gradient.channels[0];
                near("the kernel", own.kernels[0][[0, 0]], &|h| {
                    let drive: Vec<f64> = light.iter().map(|l| l * (1.0 + h)).collect();
                    stand_in.loss(&drive, THETA, ask)
                });
                near("the ON threshold", own.on[0], &|h| {
                    stand_in.loss(&light, [THETA[0] + h, THETA[1]], ask)
                });
                near("the OFF threshold", own.off[0], &|h| {
                    stand_in.loss(&light, [THETA[0], THETA[1] + h], ask)
                });
                cases += 1;
            }
        }
    }
    assert!(
        cases > 230 && events > 2000 && silent > 1000,
        "{cases} {events} {silent}"
    );
}

/// The gradient is linear in what the loss asks, and the light's is that of the kernel turned round:
/// `<h, δW * u>` and `<h, W * δu>` by the definition of a correlation, at 1e-12.
#[test]
fn kernel_and_light_are_adjoint() {
    for which in SENSORS {
        if which.0 == "logarithm" {
            continue;
        }
        let size = Size::new(39, 21);
        let text = sensor(which, "\"identity\"", 2);
        let description = describe(&text);
        let light = pan::<f64>(2, 4, size, 1.0);
        let (times, model) = (
            times(4),
            Model::<f64>::new(description.clone(), size, 0).unwrap(),
        );
        let seen = model
            .forward(Clips::new(&light, &times, size).unwrap())
            .unwrap();
        let voxels = weights(5, seen.voxels().len());
        let ask = Ask {
            voxels: Some(&voxels),
            light: true,
            ..Ask::default()
        };
        let gradient = model.backward(&seen, &ask, model.rule()).unwrap();
        // S is bilinear in W and u, so <W, dL/dW> = <S, h> = <u, dL/du>.
        let by_kernel: f64 = description
            .channels
            .iter()
            .zip(&gradient.channels)
            .flat_map(|(channel, own)| channel.kernels.iter().zip(&own.kernels))
            .map(|(kernel, own)| (kernel.weights() * own).sum())
            .sum();
        let pairs = || light.iter().zip(gradient.light.as_ref().unwrap());
        let by_light: f64 = pairs().map(|(u, g)| u * g).sum();
        let size: f64 = pairs().map(|(u, g)| (u * g).abs()).sum();
        assert!(
            (by_kernel - by_light).abs() <= 1e-12 * size,
            "{}: {by_kernel}, {by_light}",
            which.0
        );
    }
}

/// Of the kernels and thresholds of all channels, one after the other.
fn flat<R>(gradient: &Gradient<R>) -> Vec<f64> {
    let channels = gradient.channels.iter();
    channels
        .flat_map(|c| {
            c.kernels
                .iter()
                .flatten()
                .chain(&c.on)
                .chain(&c.off)
                .copied()
        })
        .collect()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let most = b.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
        / most
}

fn batch<R: Float>(text: &str, size: Size, clips: usize) -> (Model<R>, Forward<R>, Vec<R>) {
    let light = pan::<R>(clips, 6, size, 1.0);
    let model = Model::<R>::new(describe(text), size, 0).unwrap();
    let seen = model
        .forward(Clips::new(&light, &times(6), size).unwrap())
        .unwrap();
    let voxels = weights(5, seen.voxels().len());
    (model, seen, voxels)
}

/// Kernels and thresholds scaled together, mismatch with them, change no event.
#[test]
fn scaling_all_changes_nothing() {
    let size = Size::new(40, 24);
    for rules in [
        "filtered-step\"",
        "filtered-step\"\nrefractory = { us = 1000 }",
        "filtered-snap\"",
    ] {
        // A third of the thresholds of the last lie at the twentieth that is the least.
        for sigma in [0.0, 0.01, 0.2] {
            let text = format!(
                "response = \"identity\"\nmemory = \"{rules}\n[[channel]]\nkernel = {}\nthreshold = {{ on = 0.05, off = 0.07, sigma = {sigma} }}\n",
                kernel(5, 3)
            );
            let light = pan::<f64>(2, 6, size, 1.0);
            let model = Model::new(describe(&text), size, 0).unwrap();
            let model = model.with_phase(7, 0.3);
            let seen = model
                .forward(Clips::new(&light, &times(6), size).unwrap())
                .unwrap();
            let voxels = weights(5, seen.voxels().len());
            for rule in [Rule::Through, Rule::Reset, Rule::Mean] {
                if rules.contains("snap") && rule != Rule::Reset {
                    continue;
                }
                let ask = Ask {
                    voxels: Some(&voxels),
                    events: 0.3,
                    ..Ask::default()
                };
                let gradient = model.backward(&seen, &ask, rule).unwrap();
                let own = &gradient.channels[0];
                let weights = model.description().channels[0].kernels[0].weights();
                let by_kernel: f64 = own.kernels[0].iter().zip(weights).map(|(g, w)| g * w).sum();
                let by_threshold = 0.05 * own.on[0] + 0.07 * own.off[0] + sigma * own.sigma[0];
                assert!(by_kernel.abs() > 1.0, "{rules} {rule:?}: {by_kernel}");
                let apart = (by_kernel + by_threshold).abs() / by_kernel.abs();
                assert!(
                    apart < 1e-9,
                    "{rules} {sigma} {rule:?}: {by_kernel} {by_threshold}"
                );
            }
        }
    }
}

#[test]
fn single_precision_is_near_to_double() {
    let (size, mut others) = (Size::new(40, 24), 0);
    for which in SENSORS {
        let text = sensor(which, "\"identity\"", 2);
        let (single, seen, voxels) = batch::<f32>(&text, size, 2);
        let ask = Ask {
            voxels: Some(&voxels),
            ..Ask::default()
        };
        let own = single.backward(&seen, &ask, single.rule()).unwrap();
        let counts = seen.counts().to_vec();
        // The same clips, as single precision holds them.
        let light: Vec<f64> = pan::<f32>(2, 6, size, 1.0)
            .into_iter()
            .map(f64::from)
            .collect();
        let double = Model::<f64>::new(describe(&text), size, 0).unwrap();
        let seen = double
            .forward(Clips::new(&light, &times(6), size).unwrap())
            .unwrap();
        let voxels: Vec<f64> = voxels.into_iter().map(f64::from).collect();
        let ask = Ask {
            voxels: Some(&voxels),
            ..Ask::default()
        };
        let theirs = double.backward(&seen, &ask, double.rule()).unwrap();
        let apart = distance(&flat(&own), &flat(&theirs));
        let counts = counts.iter().zip(seen.counts());
        let other = counts.filter(|(a, b)| a != b).count();
        // One cell in twenty thousand may lie within rounding of a threshold.
        let most = if other == 0 { 1e-4 } else { 1e-2 };
        others += other;
        assert!(
            apart < most,
            "{}: {other} counts differ, {apart:e}",
            which.0
        );
    }
    assert!(others <= 2, "{others} counts differ");
}

#[test]
fn threads_change_no_bit() {
    let text = sensor(SENSORS[1], "\"identity\"", 2);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let (model, seen, voxels) = batch::<f32>(&text, Size::new(70, 24), 3);
            let ask = Ask {
                voxels: Some(&voxels),
                light: true,
                ..Ask::default()
            };
            let own = model.backward(&seen, &ask, Rule::Through).unwrap();
            let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            let kernels: Vec<u64> = flat(&own).into_iter().map(f64::to_bits).collect();
            (bits(seen.voxels()), kernels, bits(&own.light.unwrap()))
        })
    };
    let one = run(1);
    assert_eq!(run(2), one);
    assert_eq!(run(5), one);
}

/// Results in memory that held another sensor's, of another size, are those in fresh memory.
#[test]
fn memory_is_used_again() {
    let sizes = [Size::new(70, 24), Size::new(40, 31), Size::new(9, 90)];
    let mut again = Forward::<f32>::default();
    for (n, which) in SENSORS
        .into_iter()
        .cycle()
        .take(3 * SENSORS.len())
        .enumerate()
    {
        let text = sensor(which, "\"identity\"", 1 + n % 3);
        let (size, clips) = (sizes[n % 3], 1 + n % 2);
        let (model, seen, voxels) = batch::<f32>(&text, size, clips);
        let (light, times) = (pan::<f32>(clips, 6, size, 1.0), times(6));
        let light = Clips::new(&light, &times, size).unwrap();
        for _ in 0..2 {
            model.forward_into(light, &mut again).unwrap();
            let bits = |seen: &Forward<f32>| {
                let voxels = seen.voxels().iter().map(|v| v.to_bits());
                (seen.shape(), voxels.collect::<Vec<_>>())
            };
            assert_eq!(bits(&again), bits(&seen), "{}", which.0);
            assert_eq!(again.counts(), seen.counts(), "{}", which.0);
            let ask = Ask {
                voxels: Some(&voxels),
                ..Ask::default()
            };
            let back = |seen| flat(&model.backward(seen, &ask, model.rule()).unwrap());
            assert_eq!(back(&again), back(&seen), "{}", which.0);
        }
        if n % 4 == 3 {
            let other = Clips::new(&[0.0; 8], &[0.0, 1.0], Size::new(2, 2)).unwrap();
            assert!(model.forward_into(other, &mut again).is_err());
            assert!(again.voxels().is_empty() && again.bytes() == 0);
        }
    }
}

#[test]
fn a_batch_is_its_clips() {
    let (text, size) = (sensor(SENSORS[7], "\"identity\"", 2), Size::new(40, 24));
    let (model, seen, voxels) = batch::<f64>(&text, size, 3);
    let ask = |voxels| Ask {
        voxels: Some(voxels),
        ..Ask::default()
    };
    let all = model.backward(&seen, &ask(&voxels), Rule::Through).unwrap();
    let light = pan::<f64>(3, 6, size, 1.0);
    let part = voxels.len() / 3;
    let mut sum = vec![0.0; flat(&all).len()];
    for (n, light) in light.chunks(6 * size.pixels()).enumerate() {
        let own = model
            .forward(Clips::new(light, &times(6), size).unwrap())
            .unwrap();
        assert_eq!(own.voxels(), &seen.voxels()[n * part..][..part]);
        let own = model
            .backward(&own, &ask(&voxels[n * part..][..part]), Rule::Through)
            .unwrap();
        for (sum, own) in sum.iter_mut().zip(flat(&own)) {
            *sum += own;
        }
    }
    assert!(distance(&sum, &flat(&all)) < 1e-12);
}

/// As many kinds as there may be: each has the gradient that it has alone.
#[test]
fn sixteen_kinds_are_each_their_own() {
    const KINDS: usize = 16;
    let size = Size::new(40, 24);
    for rule in [Rule::Mean, Rule::Through] {
        let (model, seen, voxels) =
            batch::<f64>(&sensor(SENSORS[1], "\"identity\"", KINDS), size, 2);
        let ask = Ask {
            voxels: Some(&voxels),
            ..Ask::default()
        };
        let all = model.backward(&seen, &ask, rule).unwrap();
        assert_eq!(all.channels.len(), KINDS);
        for (k, own) in all.channels.iter().enumerate() {
            let cell = channel(5, 10 * k as u64, "");
            let text = format!("response = \"identity\"\n{}\n{cell}", SENSORS[1].1);
            let (alone, seen, _) = batch::<f64>(&text, size, 2);
            // Of (clips, frames, kinds, rows, columns), its own.
            let planes = voxels.chunks(size.pixels()).skip(k).step_by(KINDS);
            let voxels: Vec<f64> = planes.flatten().copied().collect();
            let ask = Ask {
                voxels: Some(&voxels),
                ..Ask::default()
            };
            let alone = alone.backward(&seen, &ask, rule).unwrap();
            let own = Gradient::<f64> {
                channels: vec![own.clone()],
                light: None,
            };
            let (own, alone) = (flat(&own), flat(&alone));
            assert!(alone.iter().any(|v| v.abs() > 1e-3), "{rule:?}, kind {k}");
            assert!(distance(&own, &alone) < 1e-12, "{rule:?}, kind {k}");
        }
    }
}

/// Which tensor, and where in it.
#[test]
fn what_is_not_finite_is_named() {
    let (text, size) = (sensor(SENSORS[1], "\"identity\"", 2), Size::new(5, 4));
    let (model, seen, voxels) = batch::<f32>(&text, size, 2);
    let said = |ask: &Ask<'_, f32>| {
        model
            .backward(&seen, ask, Rule::Through)
            .unwrap_err()
            .to_string()
    };
    let [_, frames, channels, ..] = seen.shape();
    let mut bad = voxels.clone();
    bad[((frames + 2) * channels + 1) * 20 + 2 * 4 + 3] = f32::NAN;
    let ask = Ask {
        voxels: Some(&bad),
        ..Ask::default()
    };
    let want = "the gradient of the voxels (clips, frames, channels, rows, columns) has NaN at [1, 2, 1, 2, 3]";
    assert_eq!(said(&ask), want);
    let mut bad = weights::<f32>(1, seen.counts().len());
    bad[3] = f32::NEG_INFINITY;
    let ask = Ask {
        counts: Some(&bad),
        ..Ask::default()
    };
    let want = "the gradient of the counts (clips, pairs, channels, rows, columns) has -inf at [0, 0, 0, 0, 3]";
    assert_eq!(said(&ask), want);
    for (events, want) in [(f64::INFINITY, "inf"), (f64::NAN, "NaN")] {
        let ask = Ask {
            events,
            ..Ask::default()
        };
        let want = format!("the gradient of the number of events is {want}");
        assert_eq!(said(&ask), want);
    }
    let large = vec![3e38; voxels.len()];
    let ask = Ask {
        voxels: Some(&large),
        ..Ask::default()
    };
    assert!(
        said(&ask).starts_with("the gradient of the kernel of channel 0 has "),
        "{}",
        said(&ask)
    );
    let ask = Ask {
        voxels: Some(&voxels[1..]),
        ..Ask::default()
    };
    assert!(
        said(&ask).contains("has 479 values, and 480, [2, 6, 2, 5, 4], were expected"),
        "{}",
        said(&ask)
    );

    let mut light = pan::<f32>(2, 6, size, 1.0);
    light[(6 + 4) * 20 + 4 + 2] = f32::NAN;
    let said = model
        .forward(Clips::new(&light, &times(6), size).unwrap())
        .unwrap_err();
    let want = "the light (clips, frames, rows, columns): clip 1, frame 4, y = 1, x = 2: the light is NaN, which is not finite";
    assert_eq!(said.to_string(), want);
    let short = Clips::new(&light[1..], &times(6), size).unwrap_err();
    assert!(matches!(short, GradientError::Shape { .. }), "{short}");
    for times in [&[0.0][..], &[0.0, 0.0], &[f64::NAN, 0.0], &[]] {
        assert!(matches!(
            Clips::new(&light, times, size),
            Err(GradientError::Time { .. })
        ));
    }
}

#[test]
fn what_has_no_gradient_is_refused() {
    for (more, want) in [
        ("memory = \"raw-snap\"", "its memory holds pixels"),
        (
            "memory = \"filtered-snap\"\npolarity = \"pixel\"",
            "the pixel's own change",
        ),
        (
            "memory = \"filtered-step\"\nnoise = { leak-hz = 1 }",
            "it has noise",
        ),
    ] {
        let text = format!("response = \"identity\"\n{more}\n{}", channel(3, 0, ""));
        let said = Model::<f32>::new(describe(&text), Size::new(4, 4), 0).unwrap_err();
        assert!(said.to_string().contains(want), "{said}");
    }
    let text = "response = \"identity\"\nmemory = \"filtered-step\"\n[[channel]]\nmesh = { lambda = 2 }\nthreshold = { on = 1, off = 1 }";
    let said = Model::<f32>::new(describe(text), Size::new(4, 4), 0).unwrap_err();
    assert!(said.to_string().contains("sees through a mesh"), "{said}");
    let help = miette::Diagnostic::help(&said).unwrap().to_string();
    assert!(
        help.contains("`amacrine mesh solve --show difference`"),
        "{help}"
    );
}

/// A last batch may have no clip.
#[test]
fn of_no_clip_there_is_nothing() {
    let (text, size) = (sensor(SENSORS[1], "\"identity\"", 2), Size::new(5, 4));
    let model = Model::<f32>::new(describe(&text), size, 0).unwrap();
    let seen = model
        .forward(Clips::new(&[], &times(6), size).unwrap())
        .unwrap();
    assert_eq!(seen.shape(), [0, 6, 2, 5, 4]);
    assert!(seen.voxels().is_empty() && seen.counts().is_empty());
    let ask = Ask {
        voxels: Some(&[]),
        events: 1.0,
        light: true,
        ..Ask::default()
    };
    let back = model.backward(&seen, &ask, Rule::Through).unwrap();
    assert_eq!(back.light.as_deref(), Some(&[][..]));
    let kernels = back.channels.iter().flat_map(|kind| &kind.kernels);
    assert!(kernels.flat_map(|it| it.iter()).all(|w| *w == 0.0));
}

/// The cosine between a rule's gradient of the kernel and the differences of the loss, both averaged
/// over the phase of the memory, and their ratio of lengths.
fn phase_averaged((rules, more): (&str, &str), theta: f64, want: &[Rule]) -> Vec<(f64, f64)> {
    const PHASES: usize = 64;
    const FRAMES: usize = 9;
    let size = Size::new(10, 10);
    let text = format!("response = \"identity\"\n{rules}\n{}", channel(5, 4, more));
    let mut base = describe(&text);
    for threshold in base.channels.iter_mut().flat_map(|c| &mut c.thresholds) {
        (threshold.on, threshold.off) = (theta, theta);
    }
    let light = pan::<f64>(1, FRAMES, size, 1.0);
    let times = times(FRAMES);
    let clips = Clips::new(&light, &times, size).unwrap();
    let phased = |description: &Description, n: usize| {
        let model = Model::<f64>::new(description.clone(), size, 0).unwrap();
        model.with_phase(7, n as f64 / PHASES as f64)
    };
    let first = phased(&base, 0).forward(clips).unwrap();
    let asked = weights::<f64>(11, first.voxels().len());
    let loss = |description: &Description| -> f64 {
        let one = |n| {
            let seen = phased(description, n).forward(clips).unwrap();
            seen.voxels()
                .iter()
                .zip(&asked)
                .map(|(v, w)| v * w)
                .sum::<f64>()
        };
        (0..PHASES).map(one).sum::<f64>() / PHASES as f64
    };
    // So large that each cell crosses a good part of its phases.
    let step = 0.04;
    let mut differences = Vec::new();
    for n in 0..25 {
        let moved = |by: f64| {
            let mut description = base.clone();
            let kernel = &mut description.channels[0].kernels[0];
            let mut weights = kernel.weights().clone();
            weights[[n / 5, n % 5]] += by;
            *kernel = amacrine::kernel::Kernel::new(weights).unwrap();
            loss(&description)
        };
        differences.push((moved(step) - moved(-step)) / (2.0 * step));
    }
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut found = Vec::new();
    for &rule in want {
        let mut mean = vec![0.0; 25];
        for n in 0..PHASES {
            let model = phased(&base, n);
            let seen = model.forward(clips).unwrap();
            let ask = Ask {
                voxels: Some(&asked),
                ..Ask::default()
            };
            let own = model.backward(&seen, &ask, rule).unwrap();
            for (mean, own) in mean.iter_mut().zip(&own.channels[0].kernels[0]) {
                *mean += own / PHASES as f64;
            }
        }
        let lengths = (
            dot(&mean, &mean).sqrt(),
            dot(&differences, &differences).sqrt(),
        );
        found.push((
            dot(&mean, &differences) / (lengths.0 * lengths.1),
            lengths.0 / lengths.1,
        ));
    }
    println!(
        "{rules} {more}, threshold {theta}, {:.2} events a pixel and pair: {want:?}: (cosine, length) {found:.3?}",
        first.rate()
    );
    found
}

const STEP: &str = "memory = \"filtered-step\"";
const DEAD: &str = "memory = \"filtered-step\"\nrefractory = { us = 1000 }";
const LONG: &str = "memory = \"filtered-step\"\nrefractory = { us = 4000 }";
const AUTHORS: &str = "memory = \"filtered-step\"\nrefractory = { us = 0, rule = \"authors\" }";

#[test]
fn through_points_where_the_loss_falls_and_authors_does_not() {
    let rules = [Rule::Authors, Rule::Reset, Rule::Through, Rule::Mean];
    for (memory, rules) in [(STEP, &rules[..]), (AUTHORS, &rules[..3])] {
        let found = phase_averaged((memory, ""), 0.012, rules);
        assert!(found[2].0 >= 0.9, "through has a cosine of {}", found[2].0);
        assert!(found[0].0 < 0.9, "authors has a cosine of {}", found[0].0);
    }
}

/// Where events are few, a cell's turns count: `through` takes a cell that has turned for one that
/// follows, `mean` does not.
/// The logarithm after the kernel: where events are many, its gradient is the difference.
#[test]
fn a_logarithm_points_where_the_loss_falls() {
    let found = phase_averaged((STEP, "log-temporal = true"), 0.01, &[Rule::Through]);
    let (cosine, length) = found[0];
    assert!(cosine > 0.9 && (0.7..1.4).contains(&length), "{found:?}");
}

#[test]
fn mean_points_where_the_loss_falls_when_events_are_few() {
    let rules = [Rule::Authors, Rule::Reset, Rule::Through, Rule::Mean];
    for theta in [0.05, 0.15] {
        let found = phase_averaged((STEP, ""), theta, &rules);
        assert!(found[3].0 >= 0.9, "mean has a cosine of {}", found[3].0);
        for (other, rule) in found[..3].iter().zip(rules) {
            assert!(other.0 < found[3].0, "{rule:?} has a cosine of {}", other.0);
        }
    }
    // One crossing in a few is lost to the dead time: on average, which is what `mean` takes it for.
    let found = phase_averaged((DEAD, ""), 0.05, &rules);
    assert!(found[3].0 >= 0.9, "mean has a cosine of {}", found[3].0);
    // Most are lost: how many changes with the drive, and the rule takes that number for fixed.
    let found = phase_averaged((LONG, ""), 0.02, &rules);
    assert!(found[3].0 < 0.8, "mean has a cosine of {}", found[3].0);
}

#[test]
fn a_rate_is_met_and_held() {
    let size = Size::new(24, 32);
    let text = sensor(SENSORS[1], "\"identity\"", 2);
    let light = pan::<f64>(3, 9, size, 1.0);
    let times = times(9);
    let clips = Clips::new(&light, &times, size).unwrap();
    for target in [0.02, 0.3] {
        let rated = rate_threshold(&describe(&text), clips, 0, target).unwrap();
        assert!(
            (rated.rate / target - 1.0).abs() < 0.02,
            "{target}: {}",
            rated.rate
        );
        let model = Model::<f64>::new(rated.description, size, 0).unwrap();
        assert_eq!(model.forward(clips).unwrap().rate(), rated.rate);
    }
    let still = vec![0.5; light.len()];
    let still = Clips::new(&still, &times, size).unwrap();
    let said = rate_threshold(&describe(&text), still, 0, 0.02).unwrap_err();
    assert!(
        said.to_string().contains("no thresholds make 0.02 events"),
        "{said}"
    );
    assert!(rate_threshold(&describe(&text), clips, 0, 0.0).is_err());

    // A step along the surface keeps the rate, where a step along the gradient does not.
    let rated = rate_threshold(&describe(&text), clips, 0, 0.3).unwrap();
    let model = Model::<f64>::new(rated.description.clone(), size, 0).unwrap();
    let seen = model.forward(clips).unwrap();
    let voxels = weights(3, seen.voxels().len());
    let back = |ask: &Ask<'_, f64>| model.backward(&seen, ask, Rule::Through).unwrap();
    let loss = back(&Ask {
        voxels: Some(&voxels),
        ..Ask::default()
    });
    let events = back(&Ask {
        events: 1.0,
        ..Ask::default()
    });
    let own = ConstantRate::new(&rated.description, &events, &events).unwrap();
    assert!((own.price - 1.0).abs() < 1e-12);
    assert!(
        own.kernels
            .iter()
            .flatten()
            .flatten()
            .all(|v| v.abs() < 1e-9 * own.events.abs())
    );
    let along = ConstantRate::new(&rated.description, &loss, &events).unwrap();
    let dot = |a: &Plane<f64>, b: &Plane<f64>| (a * b).sum();
    let step = 0.02 / dot(&along.kernels[0][0], &along.kernels[0][0]).sqrt();
    let moved = |scale: bool| {
        let mut description = rated.description.clone();
        let mut more = 0.0;
        for (k, channel) in description.channels.iter_mut().enumerate() {
            let by = &along.kernels[k][0] * -step;
            more += dot(&by, &events.channels[k].kernels[0]);
            let weights = channel.kernels[0].weights() + &by;
            channel.kernels[0] = amacrine::kernel::Kernel::new(weights).unwrap();
        }
        let scale = if scale {
            elementary::exp(-more / along.events)
        } else {
            1.0
        };
        for threshold in description
            .channels
            .iter_mut()
            .flat_map(|c| &mut c.thresholds)
        {
            threshold.on *= scale;
            threshold.off *= scale;
        }
        let model = Model::<f64>::new(description, size, 0).unwrap();
        (model.forward(clips).unwrap().rate() / rated.rate - 1.0).abs()
    };
    println!(
        "rate moves by {} with the thresholds held, {} along",
        moved(false),
        moved(true)
    );
    assert!(moved(true) < 0.03);
}
