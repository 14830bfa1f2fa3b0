//! What an instruction word costs on a 256x256 array: the minimum over many repetitions, on
//! one thread, next to the plain per-pixel loop, the memory of this machine and the real chip.
//!
//! `AMACRINE_BENCH=quick` takes seconds.

use std::{hint::black_box, time::Instant};

use amacrine::{
    array::{Arithmetic, Domain, Exact, Fixed, Place, Settings, Share, Single},
    event::Packet,
    isa::{Analog, Bit, Device, Digital, Direction, Primitive, Source, Target},
    number::Q,
    plane::{Plane, Size},
    program::{Action, Code, Step},
    unit::Micros,
};

const SIZE: Size = Size::new(256, 256);

/// The chip's own time for a word (10 MHz, quoted), in ns.
const CHIP: f64 = 100.0;

fn main() {
    let repetitions = match std::env::var("AMACRINE_BENCH").as_deref() {
        Ok("quick") => 10,
        _ => 200,
    };
    println!("256x256, one thread, ns per instruction word, minimum of {repetitions}");
    println!(
        "{:<8} {:<18} {:>9} {:>8} {:>7} {:>7} {:>8} {:>9}",
        "domain", "words", "ns", "KiB", "GB/s", "copy", "chip", "obvious"
    );
    for (name, bytes) in [("exact", 8), ("f32", 4), ("q8.8", 2), ("silicon", 4), ("f16", 2), ("bf16", 2)] {
        let probe = copy_bandwidth(SIZE.pixels() * bytes, repetitions);
        for (title, words) in sequences() {
            let ns = measured(name, &words, repetitions);
            let moved: f64 =
                words.iter().map(|word| moved(word, bytes)).sum::<f64>() / words.len() as f64;
            let obvious = match name {
                "exact" => obvious(&Exact, &words, repetitions),
                "f32" => obvious(&Single, &words, repetitions),
                "q8.8" => obvious(&Fixed::new(Q::<i16>::new(8)), &words, repetitions),
                _ => None,
            };
            println!(
                "{name:<8} {title:<18} {ns:>9.0} {:>8.0} {:>7.1} {:>6.0}% {:>7.3}x {:>9}",
                moved / 1024.0,
                moved / ns,
                100.0 * moved / ns / probe,
                CHIP / ns,
                obvious.map_or("-".into(), |slow| format!("{:.0}x", slow / ns)),
            );
        }
    }
}

fn r(register: u8) -> Source {
    Source::Register(Analog(register))
}

fn bus(targets: &[u8], sources: &[Source]) -> Primitive {
    Primitive::Bus {
        targets: targets
            .iter()
            .map(|t| Target::Register(Analog(*t)))
            .collect(),
        sources: sources.to_vec(),
    }
}

fn drive(direction: Direction, source: u8) -> Primitive {
    Primitive::Bus {
        targets: vec![Target::Neighbour(direction)],
        sources: vec![r(source)],
    }
}

fn or(target: u8, sources: &[u8]) -> Primitive {
    Primitive::Or {
        target: Digital(target),
        sources: sources.iter().map(|s| Bit::Register(Digital(*s))).collect(),
    }
}

fn positive(sources: &[u8]) -> Primitive {
    Primitive::Where {
        sources: sources.iter().map(|s| r(*s)).collect(),
    }
}

const NEWS: u8 = 6;

/// Words that are measured together. Register F is positive in half of the pixels.
fn sequences() -> Vec<(&'static str, Vec<Primitive>)> {
    let movx = vec![drive(Direction::East, 0), bus(&[1], &[r(NEWS)])];
    let movy = vec![drive(Direction::South, 1), bus(&[2], &[r(NEWS)])];
    let divq = vec![bus(&[1, NEWS], &[r(0)]), bus(&[1], &[r(NEWS)])];
    let sum = bus(&[2], &[r(0), r(1)]);
    let mut mixed = [movx.clone(), movy, divq.clone()].concat();
    mixed.extend([
        sum.clone(),
        bus(&[3], &[r(2), r(0)]),
        drive(Direction::North, 3),
        bus(&[4], &[r(NEWS), r(1)]),
        bus(&[0], &[r(4), Source::Neighbour(Direction::West)]),
        positive(&[5]),
        bus(&[1], &[r(2), r(3)]),
        bus(&[2], &[r(1)]),
        or(5, &[6, 7]),
        or(6, &[5, 8]),
        Primitive::All,
        Primitive::Nor {
            target: Digital(7),
            sources: vec![Bit::Register(Digital(6))],
        },
        or(8, &[7, 5]),
        bus(&[3], &[r(1)]),
    ]);
    assert_eq!(mixed.len(), 20);
    vec![
        ("OR of two", vec![or(5, &[6, 7])]),
        ("bus, 1 source", vec![bus(&[2], &[r(0)])]),
        ("bus, 2 sources", vec![sum.clone()]),
        (
            "where, masked add",
            vec![positive(&[5]), sum, Primitive::All],
        ),
        ("where", vec![positive(&[5])]),
        ("movx", movx),
        ("divq", divq),
        ("mixed, 20 words", mixed),
    ]
}

/// Bytes that a word cannot help reading and writing.
fn moved(word: &Primitive, bytes: usize) -> f64 {
    let (plane, bits) = (SIZE.pixels() * bytes, SIZE.pixels() / 8);
    let moved = match word {
        Primitive::Bus { targets, sources } => (targets.len() + sources.len()) * plane + bits,
        Primitive::Where { sources } => sources.len() * plane + bits,
        Primitive::Or { sources, .. } | Primitive::Nor { sources, .. } => {
            (sources.len() + 1) * bits
        }
        _ => bits,
    };
    moved as f64
}

fn light(register: u8) -> Plane<f64> {
    Plane::from_shape_fn(SIZE.shape(), |(y, x)| {
        ((y * 7 + x * 13 + usize::from(register) * 31) % 64) as f64 - 31.5
    })
}

/// The fewest ns in which `work` is done, divided by `parts`.
fn minimum(repetitions: usize, parts: usize, mut work: impl FnMut()) -> f64 {
    let one = |()| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64() * 1e9 / parts as f64
    };
    std::iter::repeat_n((), repetitions)
        .map(one)
        .fold(f64::INFINITY, f64::min)
}

fn measured(domain: &str, words: &[Primitive], repetitions: usize) -> f64 {
    let times = 20;
    let step = |word: &Primitive| Step {
        action: Action::Word(word.clone()),
        line: 1,
    };
    let body = words.iter().map(step).collect();
    let code = Code {
        init: vec![],
        frame: vec![Step {
            action: Action::Repeat { times, body },
            line: 1,
        }],
    };
    let device = Device::scamp5();
    let settings = Settings {
        clip: true,
        ..Settings::of(&device)
    };
    let arithmetic: Arithmetic = domain.parse().expect("a domain");
    let mut chip = arithmetic
        .chip("bench", code, &device, SIZE, settings)
        .expect("a legal program");
    if let Ok(schedule) = std::env::var("SCHEDULE") {
        let rows = std::env::var("ROWS").map_or(0, |r| r.parse().unwrap());
        let threads = std::env::var("THREADS").map_or(1, |r| r.parse().unwrap());
        let schedule = match schedule.as_str() { "plain" => amacrine::array::Schedule::Plain, _ => amacrine::array::Schedule::Tiled { rows } };
        chip.set_schedule(schedule, threads);
    }
    for register in 0..7 {
        chip.set_analog(Analog(register), &light(register))
            .expect("its size");
    }
    let mut packet = Packet::new(SIZE, 1);
    minimum(repetitions, times as usize * words.len(), || {
        chip.run_frame(Micros(0), &mut packet).expect("numbers");
    })
}

/// Bytes read and written in a ns, copying planes of this size, eight in turn as registers are.
fn copy_bandwidth(bytes: usize, repetitions: usize) -> f64 {
    let mut planes = vec![vec![1u8; bytes]; 8];
    let ns = minimum(repetitions, 8, || {
        for i in 0..8 {
            let from = std::mem::take(&mut planes[(i + 1) % 8]);
            planes[i].copy_from_slice(black_box(&from));
            planes[(i + 1) % 8] = from;
        }
    });
    2.0 * bytes as f64 / ns
}

/// The same words as one would first write them, pixel by pixel; only for words of one bus
/// between registers of the same pixel, without a mask.
fn obvious<D: Domain>(domain: &D, words: &[Primitive], repetitions: usize) -> Option<f64> {
    let [Primitive::Bus { targets, sources }] = words else {
        return None;
    };
    let plane =
        |register| -> Vec<D::Cell> { light(register).iter().map(|v| domain.hold(*v)).collect() };
    let mut registers: Vec<_> = (0..7).map(plane).collect();
    let flag = black_box(vec![true; SIZE.pixels()]);
    let share = Share::of(targets.len(), 0);
    let ns = minimum(repetitions.div_ceil(10), 1, || {
        for pixel in 0..SIZE.pixels() {
            if !flag[pixel] {
                continue;
            }
            let mut sum = domain.nothing();
            for source in sources {
                if let Source::Register(Analog(r)) = source {
                    domain.add(&mut sum, &registers[usize::from(*r)][pixel], 1);
                }
            }
            for target in targets {
                if let Target::Register(register) = target {
                    let place = Place {
                        y: pixel / SIZE.width,
                        x: pixel % SIZE.width,
                        register: *register,
                        step: 0,
                    };
                    let cell = domain.limit(domain.store(&sum, share, place));
                    registers[usize::from(register.0)][pixel] = cell;
                }
            }
        }
        black_box(&mut registers);
    });
    Some(ns)
}
