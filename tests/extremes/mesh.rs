//! The resistor sheet: settled, in time, as a network of unequal parts, with laterals that bend,
//! and by v2e's rule; against its modes, whose answer is known, and against an elimination that
//! subtracts nothing.

use amacrine::{
    mesh::{Between, Euler, Float, Flow, Laterals, MeshError, Mismatch, Network, Sheet, Steady},
    number::Format,
    plane::{Plane, Size},
};

use crate::{
    bound::Bounds as _,
    light::draw,
    page::{Table, Worst, decades},
};

/// A level and some modes of a sheet: waves that fit, of so many half cycles down and across.
pub struct Waves {
    size: Size,
    level: f64,
    modes: Vec<(usize, usize, f64)>,
}

impl Waves {
    /// Some of a sheet of this size, slow ones and fast ones, by chance.
    pub fn new(size: Size, level: f64, amplitude: f64, seed: u64) -> Self {
        let Size { height, width } = size;
        let slow = |n: usize| 1.min(n - 1);
        let places = [
            (slow(height), slow(width)),
            (0, slow(width)),
            (height - 1, width - 1),
            (height / 3, 0),
            (height / 5, width / 2),
        ];
        let places = places.into_iter().filter(|place| *place != (0, 0));
        let modes = places.enumerate().map(|(i, (ky, kx))| {
            let size = 0.5 + 0.5 * draw(seed, i).abs();
            (ky, kx, amplitude * size.copysign(draw(seed, i + 50)))
        });
        Self {
            size,
            level,
            modes: modes.collect(),
        }
    }

    /// Each mode times what `gain` says for its cycles a pixel, down and across.
    pub fn through(&self, gain: impl Fn(f64, f64) -> f64) -> Plane<f64> {
        let Size { height, width } = self.size;
        // Turned back in whole numbers, so that no digit of the angle is lost.
        let wave = |k: usize, n: usize| -> Vec<f64> {
            let angle = |i: usize| std::f64::consts::PI * (k * (2 * i + 1) % (4 * n)) as f64;
            (0..n).map(|i| (angle(i) / (2 * n) as f64).cos()).collect()
        };
        let mut plane = Plane::from_elem(self.size.shape(), self.level);
        for (ky, kx, amplitude) in &self.modes {
            let cycles = |k: usize, n: usize| k as f64 / (2 * n) as f64;
            let through = amplitude * gain(cycles(*ky, height), cycles(*kx, width));
            let (down, across) = (wave(*ky, height), wave(*kx, width));
            for (mut row, down) in plane.rows_mut().into_iter().zip(&down) {
                for (value, across) in row.iter_mut().zip(&across) {
                    *value += through * down * across;
                }
            }
        }
        plane
    }

    pub fn signal(&self) -> Plane<f64> {
        self.through(|_, _| 1.0)
    }

    /// From the darkest to the brightest that these waves can make.
    pub fn range(&self) -> f64 {
        let sizes = self.modes.iter().map(|(_, _, amplitude)| amplitude.abs());
        2.0 * sizes.sum::<f64>()
    }
}

pub fn furthest<T: Float>(got: &Plane<T>, want: &Plane<f64>) -> f64 {
    let each = got.iter().zip(want).map(|(a, b)| (a.to_f64() - b).abs());
    // Not `max` alone, which passes over what is no number.
    each.fold(
        0.0,
        |most: f64, error| if error <= most { most } else { error },
    )
}

pub fn sheet(lambda: f64) -> Sheet {
    Sheet::new(lambda).unwrap()
}

/// What is claimed of an answer, as a part of the light's range.
pub const DOUBLE: f64 = 1e-14;
pub const SINGLE: f64 = 3e-6;

pub fn table() -> Table {
    let mut table = Table::default();
    settled::<f64>("f64", DOUBLE, &mut table);
    settled::<f32>("f32", SINGLE, &mut table);
    condition(&mut table);
    largest(&mut table);
    moving::<f64>("f64", DOUBLE, &mut table);
    moving::<f32>("f32", SINGLE, &mut table);
    a_day(&mut table);
    unequal(&mut table);
    bending(&mut table);
    network_in_time(&mut table);
    v2e(&mut table);
    refusals(&mut table);
    table
}

const SIZES: [(usize, usize); 6] = [(1, 1), (1, 64), (64, 1), (13, 7), (63, 65), (128, 128)];

fn settled<T: Float>(name: &str, claim: f64, table: &mut Table) {
    let mut worst = Worst::default();
    for (height, width) in SIZES {
        let size = Size::new(height, width);
        for lambda in decades(-6, 6).chain([0.0, 0.77, 7.7, 77.0, 777.0]) {
            let mut steady = Steady::<T>::new(sheet(lambda), size).unwrap();
            for amplitude in [1e-6, 1.0, 1e9] {
                let waves = Waves::new(size, 3.0 * amplitude, amplitude, 1);
                let got = steady.solve(&waves.signal().mapv(T::nearest)).unwrap();
                let want = waves.through(|fy, fx| sheet(lambda).gain(fy, fx));
                // The signal itself is rounded, level and all.
                let bound = claim * (waves.range() + 3.0 * amplitude);
                let what = format_args!("{size}, λ {lambda:e}, light {amplitude:e}");
                worst.see(furthest(&got, &want), bound, what);
            }
        }
    }
    table.within(
        &format!("settled, {name}: 1x1 to 128x128"),
        "λ 0 and 1e-6 to 1e6, light 1e-6 to 1e9",
        "its error",
        &format!("{claim:.0e} of the brightest light"),
        worst,
    );
}

/// How much of what a backward stable solver may lose is lost.
fn condition(table: &mut Table) {
    let size = Size::new(63, 65);
    let u = Format::F64.unit_roundoff();
    for lambda in [1e-6, 1.0, 1e3, 1e6] {
        let waves = Waves::new(size, 0.0, 1.0, 2);
        let mut steady = Steady::new(sheet(lambda), size).unwrap();
        let got = steady.solve(&waves.signal()).unwrap();
        let want = waves.through(|fy, fx| sheet(lambda).gain(fy, fx));
        let mut worst = Worst::default();
        let bound = 16.0 * u * (1.0 + 8.0 * lambda * lambda) * waves.range();
        worst.see(furthest(&got, &want), bound, lambda);
        table.within(
            "settled, f64, against its condition",
            &format!("λ {lambda:.0e}"),
            "what a stable solver may lose",
            "16 u (1 + 8 λ²) of the range",
            worst,
        );
    }
}

/// The largest space constants: only the mean is left.
fn largest(table: &mut Table) {
    let size = Size::new(9, 8);
    let mut worst = Worst::default();
    for amplitude in [1e-300, 1e-6, 1e9, 1e280] {
        let waves = Waves::new(size, 0.0, amplitude, 3);
        let got = Steady::new(sheet(1e150), size)
            .unwrap()
            .solve(&waves.signal());
        let error = furthest(&got.unwrap(), &Plane::zeros(size.shape()));
        worst.see(error, DOUBLE * waves.range(), amplitude);
    }
    table.within(
        "settled, f64",
        "λ 1e150, light 1e-300 to 1e280",
        "the mean",
        "1e-14 of the range",
        worst,
    );
    let mut worst = Worst::default();
    for amplitude in [1e-20, 1e-6, 1e9, 1e28] {
        let waves = Waves::new(size, 0.0, amplitude, 3);
        let mut steady = Steady::<f32>::new(sheet(1e15), size).unwrap();
        let got = steady.solve(&waves.signal().mapv(|v| v as f32)).unwrap();
        let error = furthest(&got, &Plane::zeros(size.shape()));
        worst.see(error, SINGLE * waves.range(), amplitude);
    }
    table.within(
        "settled, f32",
        "λ 1e15, light 1e-20 to 1e28",
        "the mean",
        "3e-6 of the range",
        worst,
    );
}

/// From one picture to another, over any part of the time constant.
fn moving<T: Float>(name: &str, claim: f64, table: &mut Table) {
    let size = Size::new(21, 32);
    let mut worst = Worst::default();
    for lambda in decades(-6, 6).step_by(2) {
        for parts in [0.0, 1e-9, 1e-6, 1e-3, 0.3, 1.0, 30.0, 1e3, 1e9] {
            for between in [Between::Step, Between::Ramp] {
                let tau = 1e-3;
                let waves = Waves::new(size, 0.7, 1.0, 4);
                let dark = Plane::from_elem(size.shape(), T::nearest(0.7));
                let mut flow = Flow::<T>::settled(sheet(lambda), tau, &dark).unwrap();
                let signal = waves.signal().mapv(T::nearest);
                flow.advance(&signal, parts * tau, between).unwrap();
                let want = waves.through(|fy, fx| {
                    let gain = sheet(lambda).gain(fy, fx);
                    let z = parts / gain;
                    let come = -(-z).exp_m1();
                    gain * match between {
                        Between::Step => come,
                        Between::Ramp if z == 0.0 => 0.0,
                        Between::Ramp => 1.0 - come / z,
                    }
                });
                let what = format_args!("λ {lambda:e}, {parts:e} τ, {between:?}");
                worst.see(
                    furthest(flow.surround(), &want),
                    claim * waves.range(),
                    what,
                );
            }
        }
    }
    table.within(
        &format!("in time, {name}, 32x21"),
        "λ 1e-6 to 1e6, a frame of 0 to 1e9 τ",
        "its error",
        &format!("{claim:.0e} of the range"),
        worst,
    );
}

/// A hundred thousand frames: what is lost in one is forgotten in the next.
fn a_day(table: &mut Table) {
    let size = Size::new(6, 7);
    let (lambda, tau, frames) = (3.0, 1.0, 100_000);
    let waves = [Waves::new(size, 0.0, 1.0, 5), Waves::new(size, 0.0, 1.0, 6)];
    let signals = waves.each_ref().map(Waves::signal);
    let mut flow = Flow::settled(sheet(lambda), tau, &signals[0]).unwrap();
    let seconds = 86_400.0 / f64::from(frames);
    for n in 1..=frames {
        flow.advance(&signals[n as usize % 2], seconds, Between::Step)
            .unwrap();
    }
    // By then it swings between two states: x = E y + (1 - E) a, y = E x + (1 - E) b.
    let share = |fy, fx, own: bool| {
        let gain = sheet(lambda).gain(fy, fx);
        let left = (-seconds / (tau * gain)).exp();
        let own = if own { 1.0 } else { left };
        gain * (1.0 - left) * own / (1.0 - left * left)
    };
    let want = waves[0].through(|fy, fx| share(fy, fx, true))
        + waves[1].through(|fy, fx| share(fy, fx, false));
    let mut worst = Worst::default();
    let range = waves[0].range() + waves[1].range();
    worst.see(furthest(flow.surround(), &want), DOUBLE * range, "a day");
    table.within(
        "in time, f64",
        "a day in 1e5 frames",
        "its error at the end",
        "1e-14 of the range",
        worst,
    );
}

/// Node after node is eliminated, star to mesh: conductances only ever grow by products of
/// others, so no digit is lost.
fn eliminated(network: &Network, signal: &Plane<f64>) -> Plane<f64> {
    let (height, width) = signal.dim();
    let n = height * width;
    let mut own: Vec<f64> = network.transverse().iter().copied().collect();
    let mut pull: Vec<f64> = own.iter().zip(signal).map(|(g, p)| g * p).collect();
    let mut tie = vec![vec![0.0; n]; n];
    let (down, across) = network.lateral();
    for ((y, x), (down, across)) in signal
        .indexed_iter()
        .map(|(at, _)| (at, (down[at], across[at])))
    {
        let i = y * width + x;
        let beside = [
            (i + width, down, y + 1 < height),
            (i + 1, across, x + 1 < width),
        ];
        for (j, conductance, there) in beside {
            if there {
                (tie[i][j], tie[j][i]) = (conductance, conductance);
            }
        }
    }
    let mut pivots = vec![0.0; n];
    for k in 0..n {
        pivots[k] = own[k] + tie[k][k + 1..].iter().sum::<f64>();
        let through = tie[k].clone();
        for i in k + 1..n {
            let share = tie[i][k] / pivots[k];
            own[i] += share * own[k];
            pull[i] += share * pull[k];
            for j in (k + 1..n).filter(|j| *j != i) {
                tie[i][j] += share * through[j];
            }
        }
    }
    let mut settled = vec![0.0; n];
    for k in (0..n).rev() {
        let others: f64 = (k + 1..n).map(|j| tie[k][j] * settled[j]).sum();
        settled[k] = (pull[k] + others) / pivots[k];
    }
    Plane::from_shape_vec((height, width), settled).unwrap()
}

fn picture(size: Size, amplitude: f64, seed: u64) -> Plane<f64> {
    let value = |(y, x)| amplitude * draw(seed, y * size.width + x);
    Plane::from_shape_fn(size.shape(), value)
}

/// Parts that differ, by conjugate gradients.
fn unequal(table: &mut Table) {
    let size = Size::new(8, 9);
    for sigma in [0.2, 1.0, 3.0] {
        let mut worst = Worst::default();
        let mut refused = 0;
        for (seed, lambda) in decades(-6, 6).enumerate() {
            for amplitude in [1e-6, 1.0, 1e9] {
                let mismatch = Mismatch {
                    lateral: sigma,
                    transverse: sigma,
                    capacitance: sigma,
                };
                let network = Network::uniform(sheet(lambda), size).unwrap();
                let network = network.with_mismatch(mismatch, seed as u64);
                let signal = picture(size, amplitude, seed as u64);
                match network.settle(&signal) {
                    Ok(settled) => worst.see(
                        furthest(&settled.surround, &eliminated(&network, &signal)),
                        1e-10 * 2.0 * amplitude,
                        format_args!("λ {lambda:e}, light {amplitude:e}"),
                    ),
                    Err(MeshError::Unsettled { .. }) => refused += 1,
                    Err(error) => panic!("{error}"),
                }
            }
        }
        table.within(
            &format!("network, parts spread by a factor e^{sigma}"),
            "λ 1e-6 to 1e6, light 1e-6 to 1e9",
            &format!("{} settle, {refused} are refused", worst.cases()),
            "1e-10 of the range",
            worst,
        );
    }
    let network = |part: f64| {
        let one = Plane::ones((3, 3));
        let mut own = one.clone();
        own[[1, 1]] = part;
        let (down, across) = (Plane::ones((2, 3)), Plane::ones((3, 2)));
        Network::new(&own, &(down / part), &across, &one)
    };
    let signal = picture(Size::new(3, 3), 1.0, 9);
    assert!(network(1e-200).unwrap().settle(&signal).is_ok());
    let error = network(1e-303).unwrap().settle(&signal).unwrap_err();
    table.refused("network", "parts 1e303 apart", error);
    table.refused("network", "a conductance of 0", network(0.0).unwrap_err());
    let wild = Mismatch {
        lateral: 1e4,
        ..Mismatch::default()
    };
    let wild = Network::uniform(sheet(1.0), size)
        .unwrap()
        .with_mismatch(wild, 1);
    let error = wild.settle(&picture(size, 1.0, 9)).unwrap_err();
    table.refused("network", "parts spread by a factor e^10000", error);
}

type Kind = fn(f64) -> Laterals;

/// Laterals that bend: the currents that are left bound the error, since each node is tied to
/// its signal by a conductance of 1.
fn bending(table: &mut Table) {
    let size = Size::new(8, 9);
    let kinds: [(&str, Kind); 2] = [
        ("saturating laterals", |scale| Laterals::Saturating {
            scale,
        }),
        ("opening laterals", |scale| Laterals::Opening { scale }),
    ];
    for (name, kind) in kinds {
        let mut worst = Worst::default();
        let mut refused = Vec::new();
        for scale in decades(-6, 6) {
            for lambda in [0.1, 1.0, 10.0] {
                let network = Network::uniform(sheet(lambda), size).unwrap();
                let network = network.with_laterals(kind(scale)).unwrap();
                let signal = picture(size, 1.0, 11);
                match network.settle(&signal) {
                    Ok(settled) => {
                        let left = network.currents(&signal, &settled.surround).unwrap();
                        let left = furthest(&left, &Plane::zeros(size.shape()));
                        worst.see(left, 2e-10, format_args!("{name}, {scale:e}, λ {lambda}"));
                    }
                    Err(error) => refused.push((scale, error)),
                }
            }
        }
        table.within(
            name,
            "bending at 1e-6 to 1e6 of the light, λ 0.1 to 10",
            &format!("{} settle, {} are refused", worst.cases(), refused.len()),
            "1e-10 of the range",
            worst,
        );
        if let Some((scale, error)) = refused.first() {
            table.refused(name, &format!("bending at {scale:.0e} of the light"), error);
        }
    }
}

/// A network in time against the sheet of equal parts that it is.
fn network_in_time(table: &mut Table) {
    let size = Size::new(12, 13);
    let mut worst = Worst::default();
    for lambda in decades(-6, 6) {
        for seconds in [1e-6, 0.1, 1.0, 100.0, 86_400.0] {
            let network = Network::uniform(sheet(lambda), size).unwrap();
            let (a, b) = (picture(size, 1.0, 1), picture(size, 1.0, 2));
            let mut flow = Flow::settled(sheet(lambda), 1.0, &a).unwrap();
            let from = flow.surround().clone();
            flow.advance(&b, seconds, Between::Ramp).unwrap();
            let got = network.advance(&from, (&a, &b), seconds).unwrap();
            let u = Format::F64.unit_roundoff();
            // A short time is the difference of two long ways.
            let part = 1e-12 + u * (1.0 + 8.0 * lambda * lambda + 8.0 / seconds.min(1.0));
            let what = format_args!("λ {lambda:e}, {seconds} τ");
            worst.see(furthest(&got, flow.surround()), 2.0 * part, what);
        }
    }
    table.within(
        "network in time, 13x12",
        "λ 1e-6 to 1e6, a frame of 1e-6 to 86400 τ",
        "its error",
        "1e-12 + u (1 + 8 λ² + 8 τ / frame) of the range",
        worst,
    );
    // Its slowest mode takes a hundredth of τ, its fastest a millionth of that.
    let line = Size::new(1, 3000);
    let network = Network::uniform(sheet(1e4), line).unwrap();
    let (a, b) = (picture(line, 1.0, 1), picture(line, 1.0, 2));
    let error = network.advance(&a, (&a, &b), 0.01).unwrap_err();
    table.refused("network in time, 3000x1", "λ 1e4, a frame of 0.01 τ", error);
}

/// v2e's steps: they stop early, or there are too many of them.
fn v2e(table: &mut Table) {
    let size = Size::new(5, 6);
    let dark = Plane::zeros(size.shape());
    for (lambda, tau, light) in [
        (1e-6, 1e-3, 1.0),
        (1.0, 0.0, 1.0),
        (1e3, 0.0, 1.0),
        (1e6, 0.0, 1.0),
        (1e3, 0.0, 1e9),
        (1e6, 1e-3, 1e9),
        (1e150, 1e-3, 1.0),
    ] {
        let mut euler = Euler::begin(sheet(lambda), tau, &dark).unwrap();
        let lit = Plane::from_elem(size.shape(), light);
        let what = format!("v2e's rule, τ {tau:.0e} s");
        let to = format!("λ {lambda:.0e}, uniform light from 0 to {light:.0e} in 10 ms");
        match euler.advance(&lit, 1e-2) {
            Ok(()) => {
                let left = light - euler.surround()[[2, 2]];
                let happens = format!("{:.1e} of the step is left", left / light);
                table.happens(&what, &to, &happens);
            }
            Err(error) => {
                assert_eq!(euler.surround(), &dark, "it is not as it was");
                table.refused(&what, &to, error);
            }
        }
    }
}

fn refusals(table: &mut Table) {
    for lambda in [-1.0, f64::NAN, 1e151] {
        let error = Sheet::new(lambda).unwrap_err();
        table.refused("a sheet", &format!("λ {lambda:e}"), error);
    }
    let size = Size::new(4, 5);
    let error = Steady::<f32>::new(sheet(1e16), size).unwrap_err();
    table.refused("settled, f32", "λ 1e16", error);
    let error = Steady::<f64>::new(sheet(1.0), Size::new(0, 5)).unwrap_err();
    table.refused("settled", "5x0", error);
    for value in [f64::NAN, 1e300] {
        let mut signal = picture(size, 1.0, 1);
        signal[[2, 3]] = value;
        let mut steady = Steady::new(sheet(1.0), size).unwrap();
        table.refused(
            "settled",
            &format!("a signal of {value:e}"),
            steady.solve(&signal).unwrap_err(),
        );
    }
    let signal = picture(size, 1.0, 1);
    let error = Flow::settled(sheet(1.0), f64::NAN, &signal).unwrap_err();
    table.refused("in time", "τ NaN", error);
    let error = Network::uniform(sheet(1.0), size)
        .unwrap()
        .with_laterals(Laterals::Opening { scale: 0.0 })
        .unwrap_err();
    table.refused("laterals", "bending at 0", error);
}
