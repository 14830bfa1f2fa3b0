//! Proves that the order in which the array is walked does not matter: every schedule, on any
//! number of threads, agrees with the plain one to the bit, in every domain, frame after frame:
//! registers, FLAG, events, readings and ledger, over random programs, sizes and lights.

use amacrine::{
    array::{Arithmetic, Array, Ledger, Reading, Schedule, Settings},
    event::{Event, Packet, Polarity, readout::scan::Order},
    isa::{Analog, Bit, Digital, Direction, Primitive, Source, Target},
    plane::{Plane, Size},
    program::{Action, Area, Code, Host, Pattern, Step, SumOver},
    unit::Micros,
};
use proptest::prelude::*;
use words::{device, digital, value, word};

mod words;

/// Words, now and then something for the host or a loop; or only what
/// leaves the array as it is.
fn steps(words: usize, all: bool) -> impl Strategy<Value = Vec<Step>> {
    let analog = || (0u8..7).prop_map(Analog);
    let scan = (digital(), any::<bool>(), 0u32..300).prop_map(|(source, on, slots)| {
        let polarity = if on { Polarity::On } else { Polarity::Off };
        Host::ScanEvents {
            source,
            polarity,
            channel: 1,
            slots,
            order: Order::default(),
            by_rows: false,
        }
    });
    let area = prop_oneof![
        (0u16..40, 0u16..40).prop_map(|(row, column)| Area::Point { row, column }),
        (0u16..40, 0u16..8).prop_map(|(column, ignored)| Area::Column { column, ignored }),
        (0u16..8, 0u16..8).prop_map(|(row, column)| {
            Area::Pattern(Pattern {
                row,
                column,
                row_ignored: 255 - 3,
                column_ignored: 255 - 5,
            })
        }),
    ];
    let rare = u32::from(all);
    let host = prop_oneof![
        3 => (-120.0..120.0).prop_map(|value: f64| Host::LoadIn { value: value.round() }),
        2 => scan,
        1 => analog().prop_map(|source| Host::ReadAnalog { source }),
        1 => digital().prop_map(|source| Host::ScanBoundingBox { source }),
        1 => analog().prop_map(|source| Host::GlobalSum { source, over: SumOver::Whole }),
        rare => (digital(), area.clone()).prop_map(|(target, area)| Host::Load { target, area }),
        rare => area.prop_map(|area| Host::Select { area }),
    ];
    let step = |action| Step {
        action,
        line: 3,
        origin: None,
    };
    let once = prop_oneof![
        // PROP, which goes over the whole array, seldom.
        12 => word().prop_filter("PROP", |word| !matches!(word, Primitive::Prop { .. }))
            .prop_map(Action::Word),
        rare => word().prop_map(Action::Word),
        1 => host.prop_map(Action::Host),
    ]
    .prop_map(step);
    let body = prop::collection::vec(once.clone(), 1..6);
    let repeat =
        (0u32..4, body).prop_map(move |(times, body)| step(Action::Repeat { times, body }));
    prop::collection::vec(prop_oneof![9 => once, 1 => repeat], 1..words)
}

/// Words as macros make them: values go by way of NEWS, FLAG is 1 everywhere more often than
/// not, and much of what is stored is never read.
fn moves() -> impl Strategy<Value = Vec<Step>> {
    const NEWS: Analog = Analog(6);
    let register = || (0u8..6).prop_map(Analog);
    let sources = || {
        let all: Vec<_> = (0u8..6).map(|r| Source::Register(Analog(r))).collect();
        prop::sample::subsequence(all, 0..=3)
    };
    let to_news = prop_oneof![
        3 => Just(Target::Register(NEWS)),
        2 => prop::sample::select(Direction::ALL.to_vec()).prop_map(Target::Neighbour),
    ];
    let extra = prop_oneof![
        3 => Just(None),
        3 => register().prop_map(|r| Some(Source::Register(r))),
        1 => prop::sample::select(vec![Source::Pix, Source::In]).prop_map(Some),
    ];
    let movement =
        (to_news, sources(), register(), extra).prop_map(|(target, sources, to, extra)| {
            let to_itself = extra == Some(Source::Register(to));
            let extra = extra.filter(|_| !to_itself);
            let first = Primitive::Bus {
                targets: vec![target],
                sources,
            };
            let second = Primitive::Bus {
                targets: vec![Target::Register(to)],
                sources: [Source::Register(NEWS)].into_iter().chain(extra).collect(),
            };
            vec![first, second]
        });
    let halves = (register(), register()).prop_filter_map("distinct", |(to, from)| {
        let targets = vec![Target::Register(to), Target::Register(NEWS)];
        let sources = vec![Source::Register(from)];
        (to != from).then(|| vec![Primitive::Bus { targets, sources }])
    });
    let masked = register().prop_map(|r| {
        let sources = vec![Source::Register(r)];
        vec![Primitive::Where { sources }]
    });
    let words = prop_oneof![
        8 => movement,
        1 => halves,
        1 => masked,
        2 => Just(vec![Primitive::All]),
    ];
    prop::collection::vec(words, 1..20).prop_map(|words| {
        let step = |word| Step {
            action: Action::Word(word),
            line: 3,
            origin: None,
        };
        words.into_iter().flatten().map(step).collect()
    })
}

fn sizes() -> impl Strategy<Value = Size> {
    prop_oneof![
        4 => (1usize..8, 1usize..8),
        2 => (1usize..4, 60usize..70),
        6 => (1usize..=70, 1usize..=130),
        2 => (20usize..=70, prop::sample::select(vec![64usize, 128])),
    ]
    .prop_map(|(height, width)| Size::new(height, width))
}

/// What light falls in each frame: some frames are like the one before, in some only a spot
/// has changed.
fn lights(size: Size, seed: u64) -> Vec<Plane<f64>> {
    let pixel = |y: usize, x: usize| (y * size.width + x) as u64;
    let mut light = Plane::from_shape_fn(size.shape(), |(y, x)| {
        value(seed, pixel(y, x)).abs().round()
    });
    (0..9)
        .map(|frame| {
            let spot = (
                seed as usize % size.height,
                (seed >> 20) as usize % size.width,
            );
            match (seed >> (3 * frame)) % 8 {
                0..3 => {}
                3 => {
                    let changed =
                        |(y, x): (usize, usize)| value(seed ^ frame, pixel(y, x)).abs().round();
                    light = Plane::from_shape_fn(size.shape(), changed);
                }
                _ => light[spot] = (light[spot] + 17.0 * (1 + frame) as f64) % 255.0,
            }
            light.clone()
        })
        .collect()
}

/// A textured still life, in which now and then small rectangles change.
fn spots(size: Size, seed: u64) -> Vec<Plane<f64>> {
    let pixel = |y: usize, x: usize| (y * size.width + x) as u64;
    let mut light = Plane::from_shape_fn(size.shape(), |(y, x)| {
        value(seed, pixel(y, x)).abs().round()
    });
    (0..9u64)
        .map(|frame| {
            let chance = |k: u64| value(seed ^ 0xABCD, 16 * frame + k).abs() as usize;
            for k in 0..chance(0) as u64 % 4 {
                let (top, left) = (chance(4 * k + 1) * 31, chance(4 * k + 2) * 37);
                let (rows, columns) = (1 + chance(4 * k + 3) % 19, 1 + chance(4 * k + 4) % 23);
                for (dy, dx) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
                    let at = ((top + dy) % size.height, (left + dx) % size.width);
                    light[at] = (light[at] + 61.0) % 255.0;
                }
            }
            light.clone()
        })
        .collect()
}

/// All that can be seen after a frame.
#[derive(Debug, PartialEq)]
struct Seen {
    analog: Vec<Vec<u64>>,
    bits: Vec<Plane<bool>>,
    events: Vec<Event>,
    dropped: u64,
    readings: Vec<Reading>,
    ledger: Ledger,
}

fn seen(chip: &dyn Array, packet: &Packet) -> Seen {
    let analog = |r| {
        let plane = chip.analog(Analog(r));
        plane.iter().map(|v| v.to_bits()).collect()
    };
    let bits = (0..13).map(|r| chip.digital(Digital(r)));
    Seen {
        analog: (0..7).map(analog).collect(),
        bits: bits.chain([chip.flag()]).collect(),
        events: packet.events.clone(),
        dropped: packet.dropped.no_slot,
        readings: chip.readings().to_vec(),
        ledger: chip.ledger(),
    }
}

/// What a schedule leaves after the program's `init` and after each frame.
fn watched(
    case: &Case,
    code: &Code,
    schedule: Schedule,
    threads: usize,
    lights: &[Plane<f64>],
) -> Vec<Seen> {
    let Case {
        domain,
        size,
        settings,
        seed,
    } = *case;
    let arithmetic: Arithmetic = domain.parse().unwrap();
    let arithmetic = arithmetic.with_seed(seed);
    let settings = Settings {
        schedule: Some(schedule),
        threads: Some(threads),
        ..settings
    };
    let mut chip = arithmetic
        .chip("test", code, device(), size, settings)
        .unwrap();
    let planes = (0..20).map(|k| {
        let at = |(y, x)| value(seed, k * 100_000 + (y * size.width + x) as u64);
        Plane::from_shape_fn(size.shape(), at)
    });
    for (r, plane) in (0..).zip(planes) {
        if r < 7 {
            chip.set_analog(Analog(r), &plane).unwrap();
        } else {
            let bits = plane.mapv(|v| v > 0.0);
            chip.set_digital(Digital(r - 7), &bits).unwrap();
        }
    }
    let mut packet = Packet::new(size, 2);
    let mut all = Vec::new();
    for (i, light) in (0..).zip(lights) {
        chip.expose(light).unwrap();
        if i == 0 {
            chip.run_init(Micros(i), &mut packet).unwrap();
        } else {
            chip.run_frame(Micros(i), &mut packet).unwrap();
        }
        all.push(seen(&*chip, &packet));
    }
    all
}

#[derive(Clone, Copy, Debug)]
struct Case {
    domain: &'static str,
    size: Size,
    settings: Settings,
    seed: u64,
}

fn cases(domain: &'static str) -> impl Strategy<Value = Case> {
    (sizes(), any::<bool>(), 0u64..1 << 40).prop_map(move |(size, clip, seed)| {
        let edge = [0.0, 3.0, -100.0][seed as usize % 3];
        let settings = Settings {
            clip,
            edge,
            square_gain: 1.0 / 128.0,
            ..Settings::from_device(device())
        };
        Case {
            domain,
            size,
            settings,
            seed,
        }
    })
}

fn agree(
    case: &Case,
    code: &Code,
    schedule: Schedule,
    threads: usize,
) -> Result<(), TestCaseError> {
    agree_in(&lights(case.size, case.seed), case, code, schedule, threads)
}

fn agree_in(
    lights: &[Plane<f64>],
    case: &Case,
    code: &Code,
    schedule: Schedule,
    threads: usize,
) -> Result<(), TestCaseError> {
    let plain = watched(case, code, Schedule::Plain, 1, lights);
    let other = watched(case, code, schedule, threads, lights);
    for (frame, (plain, other)) in plain.iter().zip(&other).enumerate() {
        for (r, (plain, other)) in plain.analog.iter().zip(&other.analog).enumerate() {
            let first = plain.iter().zip(other).position(|(a, b)| a != b);
            prop_assert_eq!(first, None, "register {} in frame {}", r, frame);
        }
        for (r, (plain, other)) in plain.bits.iter().zip(&other.bits).enumerate() {
            prop_assert!(plain == other, "R{} in frame {}", r, frame);
        }
        prop_assert!(
            plain == other,
            "events, readings or ledger in frame {frame}"
        );
    }
    Ok(())
}

macro_rules! every_domain {
    ($($name:ident: $domain:literal;)*) => {
        /// Random programs, tiled.
        mod tiled {
            use super::*;
            proptest! {
                #![proptest_config(ProptestConfig::with_cases(96))]
                $(#[test]
                fn $name(
                    case in cases($domain), init in steps(8, true), frame in steps(25, true),
                    rows in 0usize..9, threads in 1usize..=4
                ) {
                    let code = Code { init, frame };
                    agree(&case, &code, Schedule::Tiled { rows }, threads)?;
                })*
            }
        }

        /// Values on their way from register to register, tiled.
        mod moving {
            use super::*;
            proptest! {
                #![proptest_config(ProptestConfig::with_cases(96))]
                $(#[test]
                fn $name(
                    case in cases($domain), frame in moves(), rows in 0usize..9, threads in 1usize..=4
                ) {
                    let code = Code { init: vec![], frame };
                    agree(&case, &code, Schedule::Tiled { rows }, threads)?;
                })*
            }
        }
    };
}

every_domain! {
    exact: "exact";
    single: "f32";
    half: "f16";
    brain: "bf16";
    q8_8: "q8.8";
    q4_12_wrap: "q4.12-wrap";
    q8_0: "q8.0";
    q16_16: "q16.16";
    silicon: "silicon";
}

/// What a frame of a program does: values on their way, masks, bits, and a host that looks in
/// between; FLAG is 1 everywhere in the end, or it is not.
fn small_frames() -> impl Strategy<Value = Vec<Step>> {
    let bits = word().prop_filter("one-bit logic", |word| {
        matches!(
            word,
            Primitive::Or { .. }
                | Primitive::Nor { .. }
                | Primitive::WhereBit { .. }
                | Primitive::Set { .. }
                | Primitive::Clear { .. }
                | Primitive::Dnews { .. }
                | Primitive::Blur { .. }
                | Primitive::ResetPix
        )
    });
    let host = prop_oneof![
        (-120.0..120.0).prop_map(|value: f64| Host::LoadIn {
            value: value.round()
        }),
        (digital(), 0u32..4000).prop_map(|(source, slots)| Host::ScanEvents {
            source,
            polarity: Polarity::On,
            channel: 1,
            slots,
            order: Order::default(),
            by_rows: false,
        }),
        (0u8..7).prop_map(|source| Host::ReadAnalog {
            source: Analog(source)
        }),
        (0u8..7).prop_map(|source| Host::GlobalSum {
            source: Analog(source),
            over: SumOver::Whole
        }),
    ];
    let from_light = (0u8..6).prop_map(|target| Primitive::Bus {
        targets: vec![Target::Register(Analog(target))],
        sources: vec![Source::Pix, Source::In],
    });
    let step = |action| {
        vec![Step {
            action,
            line: 3,
            origin: None,
        }]
    };
    let part = prop_oneof![
        4 => moves().prop_map(|steps| steps.into_iter().take(7).collect()),
        2 => from_light.prop_map(move |word| step(Action::Word(word))),
        2 => bits.prop_map(move |word| step(Action::Word(word))),
        1 => Just(step(Action::Word(Primitive::All))),
        1 => host.prop_map(move |host| step(Action::Host(host))),
    ];
    let last = prop_oneof![
        3 => Just(Primitive::All),
        1 => (0u8..6).prop_map(|register| Primitive::Where {
            sources: vec![Source::Register(Analog(register))],
        }),
        1 => Just(Primitive::Nop),
    ];
    (prop::collection::vec(part, 1..7), last).prop_map(move |(parts, last)| {
        let mut steps = parts.concat();
        steps.extend(step(Action::Word(last)));
        steps
    })
}

/// Arrays so large that what changes is a small part.
fn large_cases(domain: &'static str) -> impl Strategy<Value = Case> {
    let size = (100usize..190, 100usize..270).prop_map(|(height, width)| Size::new(height, width));
    (cases(domain), size).prop_map(|(case, size)| Case { size, ..case })
}

/// Large arrays on which little changes.
mod spots {
    use super::*;
    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]
        #[test]
        fn exact(case in large_cases("exact"), frame in small_frames(), threads in 1usize..=3) {
            agree_in(&spots(case.size, case.seed), &case, &frame_alone(frame), Schedule::Tiled { rows: 0 }, threads)?;
        }
        #[test]
        fn single(case in large_cases("f32"), frame in small_frames(), threads in 1usize..=3) {
            agree_in(&spots(case.size, case.seed), &case, &frame_alone(frame), Schedule::Tiled { rows: 0 }, threads)?;
        }
        #[test]
        fn q8_8(case in large_cases("q8.8"), frame in small_frames(), threads in 1usize..=3) {
            agree_in(&spots(case.size, case.seed), &case, &frame_alone(frame), Schedule::Tiled { rows: 0 }, threads)?;
        }
        #[test]
        fn silicon(case in large_cases("silicon"), frame in small_frames(), threads in 1usize..=3) {
            agree_in(&spots(case.size, case.seed), &case, &frame_alone(frame), Schedule::Tiled { rows: 0 }, threads)?;
        }
    }

    fn frame_alone(frame: Vec<Step>) -> Code {
        Code {
            init: vec![],
            frame,
        }
    }
}

/// FLAG as one frame leaves it masks the next, whose light is the same.
#[test]
fn flag_that_is_left_off_reaches_the_next_frame() {
    let step = |action| Step {
        action,
        line: 1,
        origin: None,
    };
    let word = |word| step(Action::Word(word));
    let settings = Settings::from_device(device());
    // Above zero where the light is above 100.
    let value = -(settings.reset_level + 100.0 * settings.gain);
    let frame = vec![
        step(Action::Host(Host::LoadIn { value })),
        word(Primitive::Bus {
            targets: vec![Target::Register(Analog(1))],
            sources: vec![Source::Pix],
        }),
        word(Primitive::Where {
            sources: vec![Source::Pix, Source::In],
        }),
    ];
    let code = Code {
        init: vec![],
        frame,
    };
    let size = Size::new(150, 200);
    let spot = |frame: usize| {
        // Two frames each.
        let (top, left) = (40 + 5 * (frame / 2), 97 + 9 * (frame / 2));
        Plane::from_shape_fn(size.shape(), |(y, x)| {
            let inside = (top..top + 13).contains(&y) && (left..left + 11).contains(&x);
            if inside { 200.0 } else { 20.0 }
        })
    };
    let lights: Vec<_> = (0..9).map(spot).collect();
    for domain in ["f32", "q8.8"] {
        let case = Case {
            domain,
            size,
            settings,
            seed: 3,
        };
        let plain = watched(&case, &code, Schedule::Plain, 1, &lights);
        assert!(plain[4].analog != plain[5].analog, "not from light alone");
        assert!(plain == watched(&case, &code, Schedule::Tiled { rows: 0 }, 1, &lights));
    }
}

/// Steps from outside the program, one after the other at the same place.
#[test]
fn steps_that_are_handed_in_are_not_taken_for_those_before() {
    let code = Code {
        init: vec![],
        frame: vec![],
    };
    let size = Size::new(64, 64);
    let arithmetic: Arithmetic = "exact".parse().expect("a domain");
    let mut chip = arithmetic
        .chip(
            "steps",
            &code,
            device(),
            size,
            Settings::from_device(device()),
        )
        .expect("a legal program");
    let mut packet = Packet::new(size, 1);
    let flat = |value: f64| Plane::from_shape_fn(size.shape(), |_| value);
    chip.set_analog(Analog(0), &flat(1.0)).expect("its size");
    for k in 0..20 {
        let (target, other) = (Analog(1 + k % 2), Analog(2 - k % 2));
        for register in [target, other] {
            chip.set_analog(register, &flat(5.0)).expect("its size");
        }
        let steps = vec![Step {
            action: Action::Word(Primitive::Bus {
                targets: vec![Target::Register(target)],
                sources: vec![Source::Register(Analog(0))],
            }),
            line: 1,
            origin: None,
        }];
        chip.run_steps(&steps, Micros(0), &mut packet)
            .expect("numbers");
        assert_eq!(chip.analog(target), flat(-1.0), "round {k}");
        assert_eq!(chip.analog(other), flat(5.0), "round {k}");
    }
}

/// Movement, where most of the picture stays as it is, through a program that remembers.
#[test]
fn a_large_array_agrees_too() {
    let bus = |target, sources: &[Source]| {
        let word = Primitive::Bus {
            targets: vec![target],
            sources: sources.to_vec(),
        };
        Step {
            action: Action::Word(word),
            line: 1,
            origin: None,
        }
    };
    let to = |r| Target::Register(Analog(r));
    let from = |r| Source::Register(Analog(r));
    let word = |word| Step {
        action: Action::Word(word),
        line: 1,
        origin: None,
    };
    // B: the light less its neighbours; events where it differs from C, which follows.
    let frame = vec![
        bus(to(6), &[Source::Pix]),
        bus(to(0), &[from(6)]),
        bus(Target::Neighbour(Direction::South), &[from(0)]),
        bus(to(1), &[from(6)]),
        bus(Target::Neighbour(Direction::East), &[from(1)]),
        bus(to(1), &[from(6), Source::Neighbour(Direction::North)]),
        bus(to(6), &[from(1)]),
        bus(to(3), &[from(6), from(2)]),
        word(Primitive::Where {
            sources: vec![from(3)],
        }),
        word(Primitive::Or {
            target: Digital(5),
            sources: vec![Bit::Flag],
        }),
        bus(to(2), &[from(6)]),
        word(Primitive::All),
        Step {
            action: Action::Host(Host::ScanEvents {
                source: Digital(5),
                polarity: Polarity::On,
                channel: 0,
                slots: 4000,
                order: Order::default(),
                by_rows: false,
            }),
            line: 2,
            origin: None,
        },
        word(Primitive::Clear {
            targets: vec![Digital(5)],
        }),
    ];
    let code = Code {
        init: vec![],
        frame,
    };
    let size = Size::new(1024, 700);
    let case = Case {
        domain: "q8.8",
        size,
        settings: Settings::from_device(device()),
        seed: 5,
    };
    let lights: Vec<_> = (0..6)
        .map(|frame: usize| {
            Plane::from_shape_fn(size.shape(), |(y, x)| {
                let spot = (y.abs_diff(500 + 3 * frame) < 20) && (x.abs_diff(650) < 30 + frame);
                if spot {
                    200.0
                } else {
                    ((x * 7 + y * 3) % 101) as f64
                }
            })
        })
        .collect();
    let plain = watched(&case, &code, Schedule::Plain, 1, &lights);
    assert!(plain[5].events.len() > 100);
    for (schedule, threads) in [
        (Schedule::Tiled { rows: 0 }, 1),
        (Schedule::Tiled { rows: 0 }, 2),
        (Schedule::Tiled { rows: 3 }, 4),
    ] {
        let other = watched(&case, &code, schedule, threads, &lights);
        assert!(plain == other, "{schedule} on {threads} threads");
    }
}
