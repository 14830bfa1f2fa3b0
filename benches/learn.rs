//! How fast the float model is there and back, as a trainer uses it.
//!
//! `cargo bench --bench learn` (a minute or two), or with `-- --quick` (seconds, rougher). One clip of
//! 26 frames of 256x256, one thread, 5x5 kernels of which no two weights are equal, a refractory period
//! of 1 ms; every figure is the median over repetitions, with half the distance of its quartiles. Bytes
//! are counted: what goes in, what comes out, what is kept for the way back and what that works on.
//!
//! The plain version, measured in the same run, is the released simulator's own order of work: each
//! operation a pass over whole planes in double precision, all of them kept. Both must give the same
//! gradient.

#[path = "learn/plain.rs"]
mod plain;
#[expect(dead_code, reason = "another bench takes more of it")]
#[path = "reference/scene.rs"]
mod scene;
#[path = "common/timed.rs"]
mod timed;

use std::time::Duration;

use amacrine::{
    gradient::{Ask, Clips, Float, Gradient, Model, Rule},
    number::Real,
    plane::Size,
    reference::Description,
};

use crate::{plain::Plain, scene::Clip, timed::Timed};

const SIZE: Size = Size::new(256, 256);
const FRAMES: usize = 26;
const PAIRS: f64 = (FRAMES - 1) as f64;

/// Pairs a second that are to be reached, for one kind of cell.
const GOAL: f64 = 1140.0;

struct Bench {
    /// Light of all frames, 0 to 255, and their times.
    light: Vec<f64>,
    times: Vec<f64>,
    quick: bool,
    plain: Option<(f64, Vec<f64>)>,
}

fn describe(kinds: usize, rule: &str) -> Description {
    let weight = |k: usize, n: usize| {
        let centre = if n == 12 { 1.0 } else { 0.0 };
        centre - (1.0 + (n as f64 - 12.0) * 1e-3 * (k + 1) as f64) / 24.0
    };
    let channel = |k: usize| {
        let row = |y: usize| {
            let row: Vec<_> = (0..5).map(|x| weight(k, 5 * y + x).to_string()).collect();
            format!("[{}]", row.join(", "))
        };
        let rows: Vec<_> = (0..5).map(row).collect();
        format!(
            "[[channel]]\nkernel = [{}]\nthreshold = {{ on = {t}, off = {t} }}\n",
            rows.join(", "),
            t = scene::THRESHOLD
        )
    };
    let text = format!(
        "response = {{ linear = 255 }}\nmemory = \"filtered-step\"\nrefractory = {{ us = 1000, rule = \"{rule}\" }}\n{}",
        (0..kinds).map(channel).collect::<String>()
    );
    let none = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    Description::parse("bench.toml", &text, &none).expect("the bench's own sensors are valid")
}

/// What a loss might ask of each voxel.
fn asked<R: Real>(count: usize) -> Vec<R> {
    let one = |n: u64| {
        let mixed = (n + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        (mixed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    (0..count as u64).map(|n| R::from_f64(one(n))).collect()
}

fn flat<R>(gradient: &Gradient<R>) -> Vec<f64> {
    let channels = gradient.channels.iter();
    channels
        .flat_map(|c| c.kernels.iter().flatten().copied())
        .collect()
}

impl Bench {
    fn time(&self, call: impl FnMut()) -> Timed {
        let (repetitions, enough) = if self.quick { (3, 200) } else { (9, 2000) };
        Timed::new(repetitions, Duration::from_millis(enough), call)
    }

    fn line<R: Float>(&mut self, name: &str, kinds: usize, (word, rule): (&str, Rule)) {
        let description = describe(kinds, word);
        let model = Model::<R>::new(description, SIZE, 0).expect("it can be differentiated");
        let light: Vec<R> = self.light.iter().map(|v| R::from_f64(*v)).collect();
        let clips = Clips::new(&light, &self.times, SIZE).expect("frames in order");
        let seen = model.forward(clips).expect("finite light");
        let voxels = asked::<R>(seen.voxels().len());
        let ask = Ask {
            voxels: Some(&voxels),
            ..Ask::default()
        };
        let own = model.backward(&seen, &ask, rule).expect("finite gradients");
        let mut again = seen.clone();
        let forward = self.time(|| {
            model.forward_into(clips, &mut again).expect("as before");
            std::hint::black_box(again.voxels().len());
        });
        let both = self.time(|| {
            model.forward_into(clips, &mut again).expect("as before");
            let own = model.backward(&again, &ask, rule).expect("as before");
            std::hint::black_box(own.channels.len());
        });
        let held = seen.bytes() + size_of_val(&light[..]) + size_of_val(&voxels[..]);
        let rate = PAIRS / both.median;
        let goal = GOAL / kinds as f64;
        println!(
            "{:<22} {:>2} {:>10.2} {:>9.0} {:>9.0} {:>5} {:>8.0} {:>8.1}",
            format!("{name} {word}, {rule:?}"),
            kinds,
            seen.rate() / kinds as f64,
            PAIRS / forward.median,
            rate,
            both.plus_minus(),
            held as f64 * 1e-6,
            rate / goal,
        );
        if let (Some((pace, theirs)), "authors", Rule::Authors) = (&self.plain, word, rule)
            && theirs.len() == flat(&own).len()
        {
            let most = theirs.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            let own = flat(&own);
            let apart = own.iter().zip(theirs).map(|(a, b)| (a - b).abs());
            let apart = apart.fold(0.0, f64::max) / most;
            println!(
                "{:<22}    {:.1} times the plain version's {pace:.0} pairs/s; gradients {apart:.0e} apart",
                "",
                rate / pace
            );
            // In single precision some counts are others.
            let most = if size_of::<R>() > 4 { 1e-9 } else { 5e-2 };
            assert!(apart < most, "the plain version has another gradient");
        }
    }
}

fn main() {
    let quick = std::env::args().any(|arg| arg == "--quick");
    let mut clip = Clip::new(SIZE);
    let mut bench = Bench {
        light: Vec::new(),
        times: Vec::new(),
        quick,
        plain: None,
    };
    for _ in 0..FRAMES {
        let frame = clip.advance();
        bench.light.extend(frame.light.iter());
        bench.times.push(frame.seconds);
    }
    println!("{}", timed::cpu());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = pool.expect("a pool of threads");
    pool.install(|| {
        for kinds in [1, 4] {
            let voxels = asked::<f64>(FRAMES * kinds * SIZE.pixels());
            let plain = Plain::new(&describe(kinds, "authors"), SIZE);
            let mut kernels = Vec::new();
            let time = Timed::new(if quick { 1 } else { 3 }, Duration::ZERO, || {
                kernels = plain.run(&bench.light, &bench.times, &voxels);
            });
            let pace = PAIRS / time.median;
            println!(
                "\nplain version, f64, K = {kinds}: {pace:.1} pairs/s there and back {}, {:.0} MB",
                time.plus_minus(),
                plain.bytes(FRAMES) as f64 * 1e-6
            );
            bench.plain = Some((pace, kernels));
            println!(
                "{:<22} {:>2} {:>10} {:>9} {:>9} {:>5} {:>8} {:>8}",
                "", "K", "ev/px/pair", "forward/s", "both/s", "", "MB", "of goal"
            );
            bench.line::<f32>("f32", kinds, ("dead-time", Rule::Through));
            bench.line::<f32>("f32", kinds, ("dead-time", Rule::Mean));
            bench.line::<f64>("f64", kinds, ("dead-time", Rule::Through));
            bench.line::<f32>("f32", kinds, ("authors", Rule::Through));
            bench.line::<f32>("f32", kinds, ("authors", Rule::Authors));
            bench.line::<f64>("f64", kinds, ("authors", Rule::Authors));
        }
    });
}
