//! Proves that rows of the array do what `array::semantics` says of one cell, to the bit, in every
//! domain, on random programs and sizes; and that both follow equations written by hand, for
//! borders, FLAG, clipping, scan order and cost.

use amacrine::{
    array::{
        Arithmetic, Array, Bfloat, Chip, Domain, Exact, Fixed, Half, Layout, Propagation, Schedule,
        Settings, Silicon, Single, State, semantics,
    },
    event::{
        Packet, Polarity,
        readout::scan::{Address, Order},
    },
    isa::{Analog, Bit, Digital, Direction, Errors, Primitive, Source, Target},
    number::{Overflow, Q},
    plane::{At, Plane, Size},
    program::{Action, Code, Cost, Host, Step},
    unit::Micros,
};
use proptest::prelude::*;
use words::{device, value, word};

mod words;

// ---------------------------------------------------------------- random programs

fn defaults() -> Settings {
    Settings::from_device(device())
}

fn sizes() -> impl Strategy<Value = Size> {
    prop_oneof![
        12 => (1usize..8, 1usize..8),
        3 => (1usize..4, 60usize..70),
        1 => (1usize..=50, 1usize..=70),
    ]
    .prop_map(|(height, width)| Size::new(height, width))
}

fn settings() -> impl Strategy<Value = Settings> {
    let far = prop_oneof![
        Just(Propagation::Settled),
        (0u32..5).prop_map(Propagation::Steps)
    ];
    let edge = prop::sample::select(vec![0.0, 3.0, -200.0]);
    (any::<bool>(), edge, far, 4u8..10).prop_map(|(clip, edge, propagation, diffusion)| Settings {
        clip,
        edge,
        propagation,
        diffusion,
        square_gain: 1.0 / 128.0,
        ..defaults()
    })
}

fn words(code: &[Primitive]) -> Vec<Step> {
    let step = |word: &Primitive| Step {
        action: Action::Word(word.clone()),
        line: 1,
        origin: None,
    };
    code.iter().map(step).collect()
}

/// Runs a program on rows and, word by word, by the semantics of one cell.
fn agrees<D: Domain>(
    domain: &D,
    size: Size,
    settings: Settings,
    seed: u64,
    program: &[Primitive],
) -> Result<(), TestCaseError> {
    let planes: Vec<Plane<f64>> = (0..21)
        .map(|k| {
            let at = |(y, x)| value(seed, k * 100_000 + (y * size.width + x) as u64);
            Plane::from_shape_fn(size.shape(), at)
        })
        .collect();
    let (analog, rest) = planes.split_at(7);
    let (digital, light) = rest.split_at(13);
    let light = light[0].mapv(f64::abs);

    let mut judge = State::new(domain, Layout::new(device(), size), settings.edge);
    for (r, plane) in (0..).zip(analog) {
        judge.set_analog(domain, Analog(r), plane);
    }
    for (r, plane) in (0..).zip(digital) {
        judge.set_digital(Digital(r), &plane.mapv(|v| v > 0.0));
    }
    let charged = light.mapv(|light| settings.reset_level + settings.gain * light);
    judge.set_light(domain, &charged);
    let input = domain.input(5.5, true);
    for (step, word) in (0..).zip(program) {
        semantics::execute(domain, &settings, &mut judge, word, &input, step).unwrap();
    }

    // By name, as it is given on the command line.
    let arithmetic: Arithmetic = domain.name().parse().unwrap();
    for schedule in [Schedule::Plain, Schedule::Tiled { rows: 0 }] {
        let code = Code {
            init: vec![Step {
                action: Action::Host(Host::LoadIn { value: 5.5 }),
                line: 1,
                origin: None,
            }],
            frame: words(program),
        };
        let settings = Settings {
            schedule: Some(schedule),
            threads: Some(1),
            ..settings
        };
        let mut chip = arithmetic
            .chip("test", &code, device(), size, settings)
            .unwrap();
        for (r, plane) in (0..).zip(analog) {
            chip.set_analog(Analog(r), plane).unwrap();
        }
        for (r, plane) in (0..).zip(digital) {
            chip.set_digital(Digital(r), &plane.mapv(|v| v > 0.0))
                .unwrap();
        }
        chip.expose(&light).unwrap();
        let mut packet = Packet::new(size, 1);
        chip.run_init(Micros(0), &mut packet).unwrap();
        chip.run_frame(Micros(0), &mut packet).unwrap();
        for r in (0..7).map(Analog) {
            let (ours, theirs) = (chip.analog(r), judge.values(domain, r));
            for ((at, ours), theirs) in ours.indexed_iter().zip(&theirs) {
                let same = ours.to_bits() == theirs.to_bits();
                prop_assert!(same, "{schedule}: {r:?} at {at:?}: {ours} {theirs}");
            }
        }
        for r in (0..13).map(Digital) {
            let bits = judge.digital(r).to_plane();
            prop_assert_eq!(chip.digital(r), bits, "{}: {:?}", schedule, r);
        }
        let flag = judge.bits(Bit::Flag).to_plane();
        prop_assert_eq!(chip.flag(), flag, "{}: FLAG", schedule);
    }
    Ok(())
}

macro_rules! every_domain {
    ($($name:ident: $domain:expr;)*) => {
        /// Random programs do on rows what the semantics of one cell says, to the bit.
        mod cells {
            use super::*;
            proptest! {
                #![proptest_config(ProptestConfig::with_cases(256))]
                $(#[test]
                fn $name(
                    size in sizes(), settings in settings(), seed: u64,
                    program in prop::collection::vec(word(), 1..20)
                ) {
                    agrees(&$domain, size, settings, seed, &program)?;
                })*
            }
        }
    };
}

every_domain! {
    exact: Exact;
    single: Single;
    half: Half;
    brain: Bfloat;
    q8_8: Fixed::new(Q::<i16>::new(8));
    q8_8_wrap: Fixed::new(Q::<i16>::new(8).with_overflow(Overflow::Wrap));
    q8_0: Fixed::new(Q::<i8>::new(0));
    q1_7: Fixed::new(Q::<i8>::new(7));
    q16_16: Fixed::new(Q::<i32>::new(16));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// The silicon's errors are those of the cell that is written and of the word, not of how
    /// many cells are written at once.
    #[test]
    fn silicon_errs_the_same_in_cells_and_rows(
        size in sizes(), settings in settings(), seed: u64,
        program in prop::collection::vec(word(), 1..20)
    ) {
        let silicon = Silicon::new(Errors::from_device(device()), 0, &Layout::new(device(), size));
        agrees(&silicon, size, settings, seed, &program)?;
    }
}

// ---------------------------------------------------------------- equations by hand

const A: Analog = Analog(0);
const B: Analog = Analog(1);
const C: Analog = Analog(2);
const T: Analog = Analog(6);

fn bus(target: Analog, sources: &[Analog]) -> Primitive {
    Primitive::Bus {
        targets: vec![Target::Register(target)],
        sources: sources.iter().map(|r| Source::Register(*r)).collect(),
    }
}

fn mov(y: Analog, x: Analog) -> Vec<Primitive> {
    vec![bus(T, &[x]), bus(y, &[T])]
}

fn sub(y: Analog, a: Analog, b: Analog) -> Vec<Primitive> {
    vec![bus(T, &[a]), bus(y, &[T, b])]
}

/// `y := x` of the neighbour: it drives my NEWS, then I store it.
fn movx(y: Analog, x: Analog, from: Direction) -> Vec<Primitive> {
    let drive = Primitive::Bus {
        targets: vec![Target::Neighbour(from.opposite())],
        sources: vec![Source::Register(x)],
    };
    vec![drive, bus(y, &[T])]
}

fn get_image(y: Analog) -> Vec<Primitive> {
    let pix = |target, more: &[Source]| Primitive::Bus {
        targets: vec![Target::Register(target)],
        sources: [&[Source::Pix], more].concat(),
    };
    vec![
        pix(T, &[]),
        Primitive::ResetPix,
        Primitive::ResetPix,
        Primitive::Nop,
        pix(y, &[Source::Register(T)]),
    ]
}

fn on(settings: Settings, size: Size, program: &[Primitive]) -> Chip<Exact> {
    let code = Code {
        init: vec![],
        frame: words(program),
    };
    Chip::new("test", Exact, &code, device(), size, settings).unwrap()
}

fn run(chip: &mut Chip<Exact>) -> Packet {
    let mut packet = Packet::new(chip.layout().size, 1);
    chip.run_frame(Micros(7), &mut packet).unwrap();
    packet
}

fn ramp(size: Size) -> Plane<f64> {
    Plane::from_shape_fn(size.shape(), |(y, x)| (10 * y + x + 1) as f64)
}

#[test]
fn a_move_reads_from_the_neighbour_it_names_and_the_edge_beyond() {
    let size = Size::new(4, 5);
    for edge in [0.0, 50.0] {
        for direction in Direction::ALL {
            let settings = Settings { edge, ..defaults() };
            let mut chip = on(settings, size, &movx(B, A, direction));
            let light = ramp(size);
            chip.set_analog(A, &light).unwrap();
            run(&mut chip);
            let (dy, dx) = direction.step();
            let expected = Plane::from_shape_fn(size.shape(), |(y, x)| {
                let at = (y.wrapping_add_signed(dy), x.wrapping_add_signed(dx));
                light.get(at).copied().unwrap_or(edge)
            });
            assert_eq!(chip.analog(B), expected, "{direction:?}");
        }
    }
}

#[test]
fn a_transfer_needs_the_driver_first_and_the_reader_then() {
    // FLAG is 1 in the left column only.
    let size = Size::new(1, 3);
    let mut program = vec![Primitive::Where {
        sources: vec![Source::Register(C)],
    }];
    program.extend(movx(B, A, Direction::West));
    let mut chip = on(defaults(), size, &program);
    chip.set_analog(A, &ramp(size)).unwrap();
    chip.set_analog(T, &Plane::from_elem((1, 3), -70.0))
        .unwrap();
    chip.set_analog(
        C,
        &Plane::from_shape_vec((1, 3), vec![1.0, 0.0, -1.0]).unwrap(),
    )
    .unwrap();
    run(&mut chip);
    // Off the array drives the left NEWS with -edge, the left pixel drives the middle one;
    // the middle pixel does not drive, so the right NEWS keeps what it had.
    assert_eq!(
        chip.analog(T).into_raw_vec_and_offset().0,
        [0.0, -1.0, -70.0]
    );
    // Only the left pixel stores.
    assert_eq!(chip.analog(B).into_raw_vec_and_offset().0, [0.0, 0.0, 0.0]);
    let flag = chip.flag().into_raw_vec_and_offset().0;
    assert_eq!(
        flag,
        [true, false, false],
        "exactly nought is not above nought"
    );
}

#[test]
fn the_same_register_added_to_itself_by_way_of_news() {
    let size = Size::new(2, 2);
    let mut chip = on(defaults(), size, &sub(B, A, A));
    chip.set_analog(A, &ramp(size)).unwrap();
    run(&mut chip);
    assert_eq!(chip.analog(B), Plane::from_elem((2, 2), 0.0));
}

#[test]
fn an_image_is_half_the_light() {
    let size = Size::new(2, 3);
    let light = Plane::from_shape_fn((2, 3), |(y, x)| (y * 3 + x) as f64 * 51.0);
    let mut chip = on(
        Settings {
            clip: true,
            ..defaults()
        },
        size,
        &get_image(A),
    );
    chip.expose(&light).unwrap();
    run(&mut chip);
    assert_eq!(chip.analog(A), light.mapv(|l| (l / 2.0).min(127.0)));
    // The light is gone: a second look sees only the reset level.
    run(&mut chip);
    assert_eq!(chip.analog(A), Plane::from_elem((2, 3), 0.0));
}

#[test]
fn clipping_limits_stores_but_not_what_is_set() {
    let size = Size::new(1, 2);
    for (clip, expected) in [(true, [127.0, -128.0]), (false, [300.0, -300.0])] {
        let mut chip = on(Settings { clip, ..defaults() }, size, &[bus(T, &[A])]);
        chip.set_analog(
            A,
            &Plane::from_shape_vec((1, 2), vec![-300.0, 300.0]).unwrap(),
        )
        .unwrap();
        run(&mut chip);
        assert_eq!(chip.analog(T).into_raw_vec_and_offset().0, expected);
        assert_eq!(chip.analog(A)[[0, 0]], -300.0);
    }
}

#[test]
fn events_leave_by_columns_from_the_top_right() {
    let size = Size::new(3, 4);
    let scan = |slots| Step {
        action: Action::Host(Host::ScanEvents {
            source: Digital(5),
            polarity: Polarity::On,
            channel: 2,
            slots,
            order: Order::default(),
            by_rows: false,
        }),
        line: 3,
        origin: None,
    };
    let code = Code {
        init: vec![],
        frame: vec![scan(4), scan(100)],
    };
    let mut chip = Chip::new("test", Exact, &code, device(), size, defaults()).unwrap();
    let bits = Plane::from_shape_fn((3, 4), |(y, x)| (x + y) % 2 == 1 || (y, x) == (2, 3));
    chip.set_digital(Digital(5), &bits).unwrap();
    let packet = run(&mut chip);
    let places: Vec<_> = packet.events.iter().map(|e| (e.x, e.y)).collect();
    let all = [(3, 0), (3, 2), (2, 1), (1, 0), (1, 2), (0, 1)];
    assert_eq!(places[..4], all[..4]);
    assert_eq!(places[4..], all, "the register is left as it was");
    assert_eq!(packet.dropped.no_slot, 2);
    assert_eq!(chip.ledger().ambiguous, 2, "the top right pixel, twice");
    assert!(
        packet
            .events
            .iter()
            .all(|e| e.t == Micros(7) && e.channel == 2)
    );
    assert_eq!(chip.ledger().slots, 104);
}

#[test]
fn addresses_convert_both_ways() {
    let size = Size::new(3, 4);
    assert_eq!(
        Address::from_pixel(At { y: 2, x: 0 }, size),
        Address { column: 3, row: 2 }
    );
    for at in (0..3).flat_map(|y| (0..4).map(move |x| At { y, x })) {
        assert_eq!(Address::from_pixel(at, size).at(size), Some(at));
    }
    assert_eq!(Address { column: 4, row: 0 }.at(size), None);
}

#[test]
fn illegal_operands_are_refused_before_anything_runs() {
    let refused = |word: Primitive| {
        let code = Code {
            init: vec![],
            frame: words(&[word]),
        };
        let chip = Chip::new("test", Exact, &code, device(), Size::new(1, 1), defaults());
        chip.unwrap_err().to_string()
    };
    assert!(refused(bus(A, &[B, B])).contains("twice"));
    assert!(refused(bus(A, &[A])).contains("twice"));
    assert!(refused(bus(A, &[Analog(7)])).contains("number 7"));
    assert!(
        refused(Primitive::Set {
            targets: vec![Digital(13)]
        })
        .contains("number 13")
    );
}

proptest! {
    #[test]
    fn the_ledger_of_a_run_is_the_fold_over_the_program(
        once in prop::collection::vec(word(), 0..12), times in 0u32..4
    ) {
        let mut frame = words(&once);
        frame.push(Step {
            action: Action::Repeat { times, body: words(&once) },
            line: 1,
            origin: None,
        });
        let code = Code { init: vec![], frame };
        let device = device();
        let expected = Cost::of(&code.frame, device);
        let mut chip =
            Chip::new("test", Exact, &code, device, Size::new(2, 3), defaults()).unwrap();
        run(&mut chip);
        let cost = chip.ledger().cost(device);
        prop_assert_eq!(cost.words, expected.words);
        // To the bit: times are those of counts.
        prop_assert_eq!(cost.array_us, expected.array_us);
        prop_assert!((cost.host_us - expected.host_us).abs() < 1e-9);
        prop_assert_eq!(expected.words.0, once.len() as u64 * (1 + u64::from(times)));
    }

    #[test]
    fn moves_there_and_back_are_nothing_inside(seed: u64) {
        let size = Size::new(6, 7);
        for direction in Direction::ALL {
            let mut program = movx(B, A, direction);
            program.extend(movx(B, B, direction.opposite()));
            program.extend(mov(C, B));
            let mut chip = on(defaults(), size, &program);
            let values = Plane::from_shape_fn(size.shape(), |(y, x)| value(seed, (y * 7 + x) as u64));
            chip.set_analog(A, &values).unwrap();
            run(&mut chip);
            for ((y, x), v) in chip.analog(C).indexed_iter() {
                if (1..5).contains(&y) && (1..6).contains(&x) {
                    prop_assert_eq!(*v, values[[y, x]]);
                }
            }
        }
    }
}
