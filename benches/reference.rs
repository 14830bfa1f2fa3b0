//! How fast the float model is, and how far from what the machine could do.
//!
//! `cargo bench --bench reference` (a quarter of an hour); with `-- --quick`, rougher and without
//! the two larger sizes (a minute or two); `-- ratios` prints the ratios alone.
//! Every figure is the median over repetitions, with half the distance of its quartiles. The scene
//! is made beforehand: 17 frames of a moving texture of 8 bits, held as bytes, watched to and fro;
//! about 0.8 events per cell and pair.
//!
//! The plain version, measured in the same run, is the obvious loop over pixels in double
//! precision; both must make the same number of events. The machine's limits are measured too:
//! multiplications and additions from registers, and bytes read and written over a working set
//! of the same size. The floor of a pair is the longer of the two, as they could overlap.

#[path = "reference/cost.rs"]
mod cost;
#[path = "reference/plain.rs"]
mod plain;
#[path = "reference/probe.rs"]
mod probe;
#[path = "reference/scene.rs"]
mod scene;
#[path = "common/timed.rs"]
mod timed;
#[path = "reference/timing.rs"]
mod timing;

use amacrine::{
    event::Packet,
    number::{Bf16, F16, F32, F64, Number, Q},
    plane::Size,
    reference::{Counts, Description, Reference, VoxelGrid},
    sensor::Sensor,
};

use crate::{cost::Cost, probe::Machine, scene::Clip, timed::Timed, timing::Timing};

const SIZES: [Size; 4] = [
    Size::new(256, 256),
    Size::new(260, 346),
    Size::new(480, 640),
    Size::new(720, 1280),
];

/// What is asked of the sensor.
#[derive(Clone, Copy)]
enum Ask {
    List,
    Counts,
    Voxels,
}

impl Ask {
    const ALL: [Self; 3] = [Self::List, Self::Counts, Self::Voxels];

    const fn name(self) -> &'static str {
        match self {
            Self::List => "list",
            Self::Counts => "counts",
            Self::Voxels => "voxels",
        }
    }
}

/// One line of a table.
struct Line {
    label: String,
    ask: Ask,
    kinds: usize,
    threads: usize,
    pixels: usize,
    events: f64,
    time: Timed,
    cost: Cost,
}

struct Bench {
    timing: Timing,
    machine: Machine,
    pools: [rayon::ThreadPool; 2],
}

impl Bench {
    /// Times the sensor that `text` describes on a clip.
    fn line<N: Number>(
        &self,
        number: N,
        text: &str,
        clip: &mut Clip,
        ask: Ask,
        threads: usize,
    ) -> Line {
        let description = describe(text);
        let kinds = description.channels.len();
        let size = clip.size;
        let cost = Cost::of(&number, &description, size);
        let mut reference = Reference::with_number(number, description, size, 1)
            .expect("the sensor has a size that can be addressed");
        let (events, time) = self.pools[threads - 1].install(|| {
            let mut packet = Packet::new(size, kinds as u8);
            let mut counts = Counts::new(size, kinds);
            let mut grid = VoxelGrid::new(size, kinds);
            clip.rewind();
            let mut next = |reference: &mut Reference<N>| {
                let frame = clip.advance();
                match ask {
                    Ask::List => {
                        packet.events.clear();
                        reference.watch(frame, &mut packet)
                    }
                    Ask::Counts => reference.watch_into(frame, &mut counts),
                    Ask::Voxels => {
                        let watched = reference.watch_into(frame, &mut grid);
                        grid.advance();
                        watched
                    }
                }
                .expect("the scene is finite and in order");
            };
            // Once to and fro before anything is timed: the state settles.
            for _ in 0..=Clip::ROUND {
                next(&mut reference);
            }
            let before = reference.report().events;
            for _ in 0..Clip::ROUND {
                next(&mut reference);
            }
            let events = (reference.report().events - before) as f64 / Clip::ROUND as f64;
            (events, self.timing.time(|| next(&mut reference)))
        });
        Line {
            label: number.format().to_string(),
            ask,
            kinds,
            threads,
            pixels: size.pixels(),
            events,
            time,
            cost,
        }
    }

    fn show(&mut self, line: &Line) {
        let floor = line.cost.floor(line.threads, &mut self.machine);
        println!(
            "{:<22} {:>2} {:>7} {:>2} {:>9.0} {:>5} {:>9.1} {:>7.2} {:>7.2} {:>8.2} {:>9.0} {:>5.0} %",
            line.label,
            line.kinds,
            line.ask.name(),
            line.threads,
            1.0 / line.time.median,
            line.time.plus_minus(),
            line.events / line.time.median * 1e-6,
            line.events / (line.pixels * line.kinds) as f64,
            line.time.median * 1e9 / (line.pixels * line.kinds) as f64,
            line.cost.bytes as f64 * 1e-6,
            1.0 / floor,
            100.0 * floor / line.time.median,
        );
    }
}

/// What a sensor takes for a pair, as a multiple of what another does: the median of `times` pairs
/// of measurements, each of one after the other, and half the distance of the quartiles.
fn ratio(times: usize, mut one: impl FnMut() -> Line, mut other: impl FnMut() -> Line) -> Timed {
    let ratios = (0..times).map(|_| one().time.median / other().time.median);
    Timed::from_seconds(ratios.collect())
}

fn heading(title: &str) {
    println!("\n{title}");
    println!(
        "{:<22} {:>2} {:>7} {:>2} {:>9} {:>5} {:>9} {:>7} {:>7} {:>8} {:>9} {:>7}",
        "",
        "K",
        "asked",
        "th",
        "pairs/s",
        "",
        "Mev/s",
        "ev/cell",
        "ns/cell",
        "MB/pair",
        "floor/s",
        "reached"
    );
}

fn describe(text: &str) -> Description {
    Description::parse("bench.toml", text, &|_| {
        Err(std::io::ErrorKind::NotFound.into())
    })
    .expect("the bench's own sensors are valid")
}

/// A sensor with `kinds` channels of one 5x5 kernel, a centre and its surround.
fn sensor(kinds: usize, more: &str) -> String {
    described(kinds, "\"csdvs-5\"", more)
}

/// One channel of a square kernel of which no two weights are equal, much like that.
fn uneven_sensor(side: usize) -> String {
    let middle = side * side / 2;
    let weight = |k: usize| {
        let centre = if k == middle { 1.0 } else { 0.0 };
        centre - (1.0 + (k as f64 - middle as f64) * 1e-3) / (2 * middle) as f64
    };
    let row = |y: usize| {
        let weights: Vec<_> = (0..side)
            .map(|x| weight(side * y + x).to_string())
            .collect();
        format!("[{}]", weights.join(", "))
    };
    let rows: Vec<_> = (0..side).map(row).collect();
    described(1, &format!("[{}]", rows.join(", ")), "")
}

fn described(kinds: usize, kernel: &str, more: &str) -> String {
    let channel = format!(
        "[[channel]]\nkernel = {kernel}\nthreshold = {{ on = {t}, off = {t} }}\n",
        t = scene::THRESHOLD
    );
    format!(
        "response = {{ linear = 255 }}\nmemory = \"filtered-step\"\n{more}\n{}",
        channel.repeat(kinds)
    )
}

/// The names of rules that make a cell rest, and what stands for them in a sensor file.
const REFRACTORY: [(&str, &str); 2] = [
    ("dead-time 1 ms", "refractory = { us = 1000 }"),
    (
        "authors 1 ms",
        "refractory = { us = 1000, rule = \"authors\" }",
    ),
];

/// Prints a ratio.
fn say(name: &str, ask: Ask, ratio: Timed, of: &str) {
    println!(
        "{name:<16} {:>7} {:>6.2} {:>5} times {of}",
        ask.name(),
        ratio.median,
        ratio.plus_minus()
    );
}

/// What rests, kinds, formats, sizes and kernels cost, as multiples of what is plainer.
fn ratios(bench: &Bench, clip: &mut Clip, quick: bool) {
    let times = if quick { 3 } else { 9 };
    println!(
        "\nRatios, f32, one thread, pairs of measurements\n\n{}",
        clip.size
    );
    let shared = std::cell::RefCell::new(&mut *clip);
    let time = |text: &str, ask| bench.line(F32, text, &mut shared.borrow_mut(), ask, 1);
    for (name, more) in REFRACTORY {
        for ask in [Ask::List, Ask::Counts] {
            let resting = || time(&sensor(1, more), ask);
            let ratio = ratio(times, resting, || time(&sensor(1, ""), ask));
            say(name, ask, ratio, "a plain one");
        }
    }
    of_formats(bench, clip, times);
    of_kernels(bench, clip, times);
    of_kinds(bench, clip, times);
    if quick {
        return;
    }
    // There one kind's state does not stay in the cache either.
    of_kinds(bench, &mut Clip::new(SIZES[3]), times);
    of_size(bench, clip, times);
}

/// What number formats cost, as multiples of f32.
fn of_formats(bench: &Bench, clip: &mut Clip, times: usize) {
    println!("\n{}, formats", clip.size);
    let text = sensor(1, "");
    let clip = std::cell::RefCell::new(clip);
    for ask in [Ask::List, Ask::Counts] {
        let plain = || bench.line(F32, &text, &mut clip.borrow_mut(), ask, 1);
        macro_rules! formats {
            ($($number:expr),*) => {$({
                let number = $number;
                let other = || bench.line(number, &text, &mut clip.borrow_mut(), ask, 1);
                let name = number.format().to_string();
                say(&name, ask, ratio(times, other, plain), "f32");
            })*};
        }
        formats!(F64, F16, Bf16, Q::<i16>::new(12), Q::<i32>::new(16));
    }
}

/// What larger kernels cost, as multiples of 5x5; no two of their weights are equal.
fn of_kernels(bench: &Bench, clip: &mut Clip, times: usize) {
    println!("\n{}, kernels without equal weights", clip.size);
    let clip = std::cell::RefCell::new(clip);
    for side in [7, 9, 11, 13, 15] {
        let time = |side| {
            let text = uneven_sensor(side);
            bench.line(F32, &text, &mut clip.borrow_mut(), Ask::Counts, 1)
        };
        let ratio = ratio(times, || time(side), || time(5));
        let weights = (side * side) as f64 / 25.0;
        let of = format!("5x5, for {weights:.2} times the weights");
        say(&format!("{side}x{side}"), Ask::Counts, ratio, &of);
    }
}

/// What a pixel of a large sensor costs, as a multiple of one of a small sensor.
fn of_size(bench: &Bench, small: &mut Clip, times: usize) {
    const LARGE: Size = Size::new(2048, 2048);
    println!("\n{LARGE}, for each pixel");
    let text = sensor(1, "");
    let mut large = Clip::new(LARGE);
    let pixels = (LARGE.pixels() / small.size.pixels()) as f64;
    for ask in Ask::ALL {
        let ratio = ratio(
            times,
            || bench.line(F32, &text, &mut large, ask, 1),
            || bench.line(F32, &text, small, ask, 1),
        );
        let median = ratio.median / pixels;
        let of = small.size.to_string();
        say("", ask, Timed { median, ..ratio }, &of);
    }
}

/// What several kinds cost, as multiples of what one does.
fn of_kinds(bench: &Bench, clip: &mut Clip, times: usize) {
    let size = clip.size;
    println!("\n{size}");
    let clip = std::cell::RefCell::new(clip);
    for kinds in [4, 16] {
        for ask in Ask::ALL {
            let time = |kinds| bench.line(F32, &sensor(kinds, ""), &mut clip.borrow_mut(), ask, 1);
            let ratio = ratio(times, || time(kinds), || time(1));
            say(&format!("{kinds} kinds"), ask, ratio, "one kind");
        }
    }
}

fn main() {
    let quick = std::env::args().any(|arg| arg == "--quick");
    let pool = |threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("a pool of threads")
    };
    let timing = Timing::new(quick);
    let mut bench = Bench {
        timing,
        machine: Machine::new(timing),
        pools: [pool(1), pool(2)],
    };
    println!("{}", timed::cpu());
    let mut clip = Clip::new(SIZES[0]);
    ratios(&bench, &mut clip, quick);
    if std::env::args().any(|arg| arg == "ratios") {
        return;
    }
    bench.machine.show();

    let plain_sensor = sensor(1, "");
    let plain = plain::pace(&describe(&plain_sensor), &mut clip, timing);

    heading("256x256, one 5x5 kernel, filtered-step");
    let mut main_seconds = f64::INFINITY;
    for threads in [1, 2] {
        for ask in Ask::ALL {
            let single = bench.line(F32, &plain_sensor, &mut clip, ask, threads);
            let double = bench.line(F64, &plain_sensor, &mut clip, ask, threads);
            if let (Ask::List, 1) = (ask, threads) {
                main_seconds = single.time.median;
                assert_eq!(
                    double.events, plain.events,
                    "the plain loop counts otherwise"
                );
            }
            bench.show(&single);
            bench.show(&double);
        }
    }
    println!(
        "plain loop over pixels, f64, list: {:.0} pairs/s, {:.1} Mev/s; f32 on one thread is {:.1} times as fast",
        1.0 / plain.seconds,
        plain.events / plain.seconds * 1e-6,
        plain.seconds / main_seconds,
    );

    heading("256x256, other sensors and formats, one thread");
    let noise = (
        "shot 5 Hz, leak 0.1 Hz",
        "noise = { shot-hz = 5, leak-hz = 0.1 }",
    );
    for (name, more) in REFRACTORY.into_iter().chain([noise]) {
        let label = format!("f32 {name}");
        let line = bench.line(F32, &sensor(1, more), &mut clip, Ask::List, 1);
        bench.show(&Line { label, ..line });
    }
    for ask in Ask::ALL {
        let line = bench.line(F32, &uneven_sensor(5), &mut clip, ask, 1);
        bench.show(&Line {
            label: "f32 25 weights".to_owned(),
            ..line
        });
    }
    let mut numbers = clip.as_numbers();
    for ask in [Ask::Counts, Ask::List] {
        let line = bench.line(F32, &plain_sensor, &mut numbers, ask, 1);
        bench.show(&Line {
            label: "f32 8 bits as f64".to_owned(),
            ..line
        });
    }
    let mut fine = clip.not_whole();
    let line = bench.line(F32, &plain_sensor, &mut fine, Ask::List, 1);
    bench.show(&Line {
        label: "f32 fractions of light".to_owned(),
        ..line
    });
    let line = bench.line(F16, &plain_sensor, &mut clip, Ask::Counts, 1);
    bench.show(&line);
    let line = bench.line(Bf16, &plain_sensor, &mut clip, Ask::Counts, 1);
    bench.show(&line);
    let line = bench.line(Q::<i16>::new(12), &plain_sensor, &mut clip, Ask::Counts, 1);
    bench.show(&line);

    heading("Growth with size, kinds and threads, f32");
    let kinds: &[usize] = if quick { &[1, 4] } else { &[1, 2, 4, 16] };
    let sizes = if quick { &SIZES[..2] } else { &SIZES };
    for &size in sizes {
        let mut clip = Clip::new(size);
        for &kinds in kinds {
            for threads in [1, 2] {
                for ask in Ask::ALL {
                    let line = bench.line(F32, &sensor(kinds, ""), &mut clip, ask, threads);
                    bench.show(&Line {
                        label: size.to_string(),
                        ..line
                    });
                }
            }
        }
    }
}
