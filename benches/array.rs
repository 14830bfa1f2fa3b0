//! What an instruction word costs on a 256x256 array, the median over many repetitions, in
//! several schedules and on one or two threads, next to the plain per-pixel loop, the memory
//! of this machine and the real chip.
//!
//! `AMACRINE_BENCH=quick` takes seconds. Further arguments choose rows by their text.

#[path = "common/timed.rs"]
mod timed;

use std::{hint::black_box, time::Duration};

use amacrine::{
    array::{Arithmetic, Domain, Exact, Fixed, Place, Schedule, Settings, Share, Silicon, Single},
    event::Packet,
    isa::{Analog, Bit, Device, Digital, Direction, Primitive, Source, Target},
    number::Q,
    plane::{Plane, Size},
    program::{Action, Code, Step},
    unit::Micros,
};
use multiversion::multiversion;

use crate::timed::Timed;

const SIZE: Size = Size::new(256, 256);

/// The chip's own time for a word (10 MHz, quoted), in ns.
const CHIP: f64 = 100.0;

const TILED: Schedule = Schedule::Tiled { rows: 0 };

fn main() {
    let repetitions = match std::env::var("AMACRINE_BENCH").as_deref() {
        Ok("quick") => 5,
        _ => 200,
    };
    let wanted: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| !argument.starts_with('-'))
        .collect();
    println!("{}", timed::cpu());
    println!("256x256, ns per instruction word, median of {repetitions} or more, and spread");
    println!(
        "copy: bytes a word cannot help moving, against those of a copy of planes in a ns, one thread"
    );
    println!(
        "L1: what the stores of a word, as written, take from the cache next to one core, against ns;"
    );
    println!("    more than 100 % where threads share, or stores that nobody reads are left out");
    println!("chip: its 100 ns a word; obvious: a plain loop over pixels, one thread");
    println!(
        "{:<8} {:<18} {:<6} {:>7} {:>9} {:>5} {:>6} {:>7} {:>6} {:>6} {:>8} {:>8}",
        "domain",
        "words",
        "order",
        "threads",
        "ns",
        "",
        "KiB",
        "GB/s",
        "copy",
        "L1",
        "chip",
        "obvious"
    );
    for (domain, bytes) in [
        ("q8.8", 2),
        ("f32", 4),
        ("exact", 8),
        ("f16", 2),
        ("bf16", 2),
        ("silicon", 4),
    ] {
        let probe = copy_bandwidth(SIZE.pixels() * bytes, repetitions);
        let store = store_bandwidth(repetitions);
        for Sequence { title, words, runs } in sequences() {
            let mut obvious = None;
            for (schedule, threads) in runs {
                let row = format!("{domain:<8} {title:<18} {schedule:<6}");
                if !wanted.iter().all(|part| row.contains(part.as_str())) {
                    continue;
                }
                let (ns, spread) = measured(domain, &words, *schedule, *threads, repetitions);
                let obvious =
                    *obvious.get_or_insert_with(|| obvious_ns(domain, &words, repetitions));
                let moved: f64 =
                    words.iter().map(|word| moved(word, bytes)).sum::<f64>() / words.len() as f64;
                let stores: f64 =
                    words.iter().map(|word| stored(word, bytes)).sum::<f64>() / words.len() as f64;
                println!(
                    "{row} {threads:>7} {ns:>9.0} {spread:>5} {:>6.0} {:>7.1} {:>5.0}% {:>5.0}% {:>7.3}x {:>7.0}x",
                    moved / 1024.0,
                    moved / ns,
                    100.0 * moved / ns / probe,
                    100.0 * stores / ns / store,
                    CHIP / ns,
                    obvious / ns,
                );
            }
        }
    }
}

/// Words that are measured together, and how.
struct Sequence {
    title: &'static str,
    words: Vec<Primitive>,
    runs: &'static [(Schedule, usize)],
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

/// Register F is positive in half of the pixels.
fn sequences() -> Vec<Sequence> {
    const PLAIN: &[(Schedule, usize)] = &[(Schedule::Plain, 1)];
    const BOTH: &[(Schedule, usize)] = &[(Schedule::Plain, 1), (TILED, 1)];
    const ALL: &[(Schedule, usize)] = &[(Schedule::Plain, 1), (TILED, 1), (TILED, 2)];
    // Each word's result is read by another, in the next round if not in this.
    let twice = |one: fn(u8, u8) -> [Primitive; 2]| [one(1, 0), one(0, 1)].concat();
    let movx = |to, from| [drive(Direction::East, from), bus(&[to], &[r(NEWS)])];
    let movy = |to, from| [drive(Direction::South, from), bus(&[to], &[r(NEWS)])];
    let divq = |to, from| [bus(&[to, NEWS], &[r(from)]), bus(&[to], &[r(NEWS)])];
    let sum = bus(&[2], &[r(0), r(1)]);
    let mut mixed = [movx(1, 0), movy(2, 2), divq(4, 0)].concat();
    mixed.extend([
        bus(&[0], &[r(4), r(1)]),
        bus(&[4], &[r(2), r(0)]),
        drive(Direction::North, 4),
        bus(&[1], &[r(NEWS), r(0)]),
        bus(&[4], &[r(1), Source::Neighbour(Direction::West)]),
        positive(&[5]),
        bus(&[3], &[r(4), r(1)]),
        bus(&[2], &[r(3)]),
        or(5, &[6, 7]),
        or(6, &[5, 8]),
        Primitive::All,
        Primitive::Nor {
            target: Digital(7),
            sources: vec![Bit::Register(Digital(6))],
        },
        or(8, &[7, 5]),
        bus(&[0], &[r(3)]),
    ]);
    assert_eq!(mixed.len(), 20);
    // No neighbours, no mask: add, subtract, negate.
    let pointwise = vec![
        bus(&[NEWS], &[r(0), r(1)]),
        bus(&[2], &[r(NEWS)]),
        bus(&[NEWS], &[r(1)]),
        bus(&[3], &[r(NEWS), r(0)]),
        bus(&[4], &[r(3)]),
        bus(&[NEWS], &[r(2), r(4)]),
        bus(&[1], &[r(NEWS)]),
        bus(&[0], &[r(2)]),
    ];
    let sequence = |title, words, runs| Sequence { title, words, runs };
    vec![
        sequence(
            "OR of two",
            vec![
                or(5, &[6, 7]),
                or(6, &[5, 8]),
                or(7, &[6, 5]),
                or(8, &[7, 5]),
            ],
            BOTH,
        ),
        sequence("bus, 1 source", vec![bus(&[2], &[r(0)])], PLAIN),
        sequence("bus, 2 sources", vec![sum.clone()], PLAIN),
        sequence(
            "where, masked add",
            vec![positive(&[5]), sum, Primitive::All],
            PLAIN,
        ),
        sequence("where", vec![positive(&[5])], PLAIN),
        sequence("movx", twice(movx), BOTH),
        sequence("divq", twice(divq), BOTH),
        sequence("pointwise, 8 words", pointwise, ALL),
        sequence("mixed, 20 words", mixed, ALL),
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

/// Bytes that a word stores.
fn stored(word: &Primitive, bytes: usize) -> f64 {
    let stored = match word {
        Primitive::Bus { targets, .. } => targets.len() * SIZE.pixels() * bytes,
        _ => SIZE.pixels() / 8,
    };
    stored as f64
}

fn light(register: u8) -> Plane<f64> {
    Plane::from_shape_fn(SIZE.shape(), |(y, x)| {
        ((y * 7 + x * 13 + usize::from(register) * 31) % 64) as f64 - 31.5
    })
}

/// The ns in which `work` is done, divided by `parts`.
fn nanoseconds(repetitions: usize, parts: usize, work: impl FnMut()) -> f64 {
    let time = Timed::new(repetitions, Duration::from_millis(50), work);
    time.median * 1e9 / parts as f64
}

fn measured(
    domain: &str,
    words: &[Primitive],
    schedule: Schedule,
    threads: usize,
    repetitions: usize,
) -> (f64, String) {
    let times = 20;
    let step = |word: &Primitive| Step {
        action: Action::Word(word.clone()),
        line: 1,
        origin: None,
    };
    let body = words.iter().map(step).collect();
    let code = Code {
        init: vec![],
        frame: vec![Step {
            action: Action::Repeat { times, body },
            line: 1,
            origin: None,
        }],
    };
    let device = Device::scamp5();
    let settings = Settings {
        schedule: Some(schedule),
        threads: Some(threads),
        ..Settings::from_device(&device)
    };
    let arithmetic: Arithmetic = domain.parse().expect("a domain");
    let mut chip = arithmetic
        .chip("bench", &code, &device, SIZE, settings)
        .expect("a legal program");
    for register in 0..7 {
        chip.set_analog(Analog(register), &light(register))
            .expect("its size");
    }
    let mut packet = Packet::new(SIZE, 1);
    // An operating system may take that long until threads have cores of their own.
    let lasting = Duration::from_millis(if threads > 1 { 1000 } else { 50 });
    let time = Timed::new(repetitions, lasting, || {
        chip.run_frame(Micros(0), &mut packet).expect("numbers");
    });
    let words = times as usize * words.len();
    (time.median * 1e9 / words as f64, time.plus_minus())
}

/// Bytes read and written in a ns, copying planes of this size, eight in turn as registers are.
fn copy_bandwidth(bytes: usize, repetitions: usize) -> f64 {
    let mut planes = vec![vec![1u8; bytes]; 8];
    let ns = nanoseconds(repetitions, 8, || {
        for i in 0..8 {
            let from = std::mem::take(&mut planes[(i + 1) % 8]);
            planes[i].copy_from_slice(black_box(&from));
            planes[(i + 1) % 8] = from;
        }
    });
    2.0 * bytes as f64 / ns
}

/// Bytes stored in a ns, where each is one difference of 16-bit numbers that lie, as it does, in
/// the cache next to a core: no word stores faster on one thread.
fn store_bandwidth(repetitions: usize) -> f64 {
    let from = vec![1i16; 2048];
    let mut to = vec![0i16; 2048];
    let ns = nanoseconds(10 * repetitions, 20, || {
        for _ in 0..20 {
            negate(black_box(&from), black_box(&mut to));
        }
    });
    2.0 * to.len() as f64 / ns
}

#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn negate(from: &[i16], to: &mut [i16]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = 0i16.saturating_sub(*from);
    }
}

/// The same words as one would first write them, pixel by pixel.
fn obvious_ns(domain: &str, words: &[Primitive], repetitions: usize) -> f64 {
    let device = Device::scamp5();
    let layout = amacrine::array::Layout::new(&device, SIZE);
    match domain {
        "exact" => Obvious::new(Exact).ns(words, repetitions),
        "q8.8" => Obvious::new(Fixed::new(Q::<i16>::new(8))).ns(words, repetitions),
        "silicon" => {
            let errors = amacrine::isa::Errors::from_device(&device);
            Obvious::new(Silicon::new(errors, 0, &layout)).ns(words, repetitions)
        }
        // The halves are no faster.
        _ => Obvious::new(Single).ns(words, repetitions),
    }
}

/// An array as one would first write it: a plane for every register, a loop over pixels.
struct Obvious<D: Domain> {
    domain: D,
    analog: Vec<Vec<D::Cell>>,
    digital: Vec<Vec<bool>>,
    flag: Vec<bool>,
}

impl<D: Domain> Obvious<D> {
    fn new(domain: D) -> Self {
        let plane = |register| -> Vec<D::Cell> {
            light(register).iter().map(|v| domain.hold(*v)).collect()
        };
        Self {
            analog: (0..7).map(plane).collect(),
            digital: vec![vec![false; SIZE.pixels()]; 13],
            flag: vec![true; SIZE.pixels()],
            domain,
        }
    }

    fn ns(mut self, words: &[Primitive], repetitions: usize) -> f64 {
        nanoseconds(repetitions.div_ceil(20), words.len(), || {
            for word in words {
                for pixel in 0..SIZE.pixels() {
                    self.word(black_box(word), pixel);
                }
            }
        })
    }

    fn sum(&self, sources: &[Source], pixel: usize) -> D::Sum {
        let mut sum = self.domain.nothing();
        for source in sources {
            let cell = match source {
                Source::Register(register) => &self.analog[usize::from(register.0)][pixel],
                Source::Neighbour(direction) => {
                    let (dy, dx) = direction.step();
                    let to = pixel.wrapping_add_signed(dy * SIZE.width as isize + dx);
                    &self.analog[usize::from(NEWS)][to % SIZE.pixels()]
                }
                Source::Pix | Source::In => unreachable!("not in these words"),
            };
            self.domain.add(&mut sum, cell, 1);
        }
        sum
    }

    fn bit(&self, bit: Bit, pixel: usize) -> bool {
        match bit {
            Bit::Register(register) => self.digital[usize::from(register.0)][pixel],
            _ => self.flag[pixel],
        }
    }

    fn word(&mut self, word: &Primitive, pixel: usize) {
        match word {
            Primitive::Bus { targets, sources } if self.flag[pixel] => {
                let sum = self.sum(sources, pixel);
                for (part, target) in targets.iter().enumerate() {
                    let (register, to) = match target {
                        Target::Register(register) => (*register, pixel),
                        Target::Neighbour(direction) => {
                            let (dy, dx) = direction.step();
                            let to = pixel.wrapping_add_signed(dy * SIZE.width as isize + dx);
                            (Analog(NEWS), to % SIZE.pixels())
                        }
                    };
                    let place = Place {
                        y: to / SIZE.width,
                        x: to % SIZE.width,
                        register,
                        step: 0,
                    };
                    let share = Share::new(targets.len(), part);
                    self.analog[usize::from(register.0)][to] =
                        self.domain.store(&sum, share, place);
                }
            }
            Primitive::Where { sources } => {
                let sum = self.sum(sources, pixel);
                self.flag[pixel] = self.domain.positive(&sum) == Some(true);
            }
            Primitive::Or { target, sources } | Primitive::Nor { target, sources } => {
                let any = sources.iter().any(|bit| self.bit(*bit, pixel));
                self.digital[usize::from(target.0)][pixel] =
                    any != matches!(word, Primitive::Nor { .. });
            }
            Primitive::All => self.flag[pixel] = true,
            _ => {}
        }
    }
}
