//! Proves what each instruction word of the array does, against a slow twin that goes pixel by
//! pixel through the table of instructions, in every domain, on random programs and sizes; and
//! against equations written by hand, for borders, FLAG, clipping, scan order and cost.

use amacrine::{
    array::{
        Address, Arithmetic, Array, Chip, Domain, Exact, Fixed, Halves, Place, Propagation,
        Settings, Share, Single,
    },
    event::{Packet, Polarity},
    isa::{Analog, Bit, Device, Digital, Direction, Primitive, Source, Target},
    number::{Overflow, Q},
    plane::{At, Plane, Size},
    program::{Action, Code, Cost, Host, Step},
    unit::Micros,
};
use half::{bf16, f16};
use proptest::prelude::*;
use words::word;

mod words;

// ---------------------------------------------------------------- the slow twin

#[derive(Clone)]
struct Pixel<C> {
    analog: Vec<C>,
    pix: C,
    digital: Vec<bool>,
    flag: bool,
}

/// One pixel after the other, each from the whole array as it was before the word.
struct Twin<D: Domain> {
    domain: D,
    settings: Settings,
    size: Size,
    pixels: Vec<Pixel<D::Cell>>,
    input: D::Cell,
}

const NEWS: usize = 6;

type Point = (isize, isize);

fn beside((y, x): Point, direction: Direction) -> Point {
    let (dy, dx) = direction.step();
    (y + dy, x + dx)
}

impl<D: Domain> Twin<D> {
    fn at(&self, (y, x): Point) -> Option<&Pixel<D::Cell>> {
        let inside =
            y >= 0 && x >= 0 && y < self.size.height as isize && x < self.size.width as isize;
        inside.then(|| &self.pixels[y as usize * self.size.width + x as usize])
    }

    fn edge(&self) -> D::Cell {
        self.domain.hold(self.settings.edge)
    }

    fn flag(&self, at: Point) -> bool {
        self.at(at).is_none_or(|pixel| pixel.flag)
    }

    fn source(&self, at: Point, source: Source) -> D::Cell {
        let Some(pixel) = self.at(at) else {
            return self.edge();
        };
        match source {
            Source::Register(Analog(r)) => pixel.analog[usize::from(r)].clone(),
            Source::Pix => pixel.pix.clone(),
            Source::In => self.input.clone(),
            Source::Neighbour(direction) => self
                .at(beside(at, direction))
                .map_or(self.edge(), |pixel| pixel.analog[NEWS].clone()),
        }
    }

    fn sum(&self, at: Point, sources: &[Source]) -> D::Sum {
        let mut sum = self.domain.nothing();
        for source in sources {
            self.domain.add(&mut sum, &self.source(at, *source), 1);
        }
        sum
    }

    fn stored(&self, sum: &D::Sum, by: usize) -> D::Cell {
        let place = Place {
            y: 0,
            x: 0,
            register: Analog(0),
            step: 0,
        };
        self.limited(self.domain.store(
            sum,
            Share {
                by: by as u32,
                part: None,
            },
            place,
        ))
    }

    fn limited(&self, cell: D::Cell) -> D::Cell {
        if self.settings.clip {
            self.domain.limit(cell)
        } else {
            cell
        }
    }

    fn bit(&self, at: Point, bit: Bit, outside: bool) -> bool {
        self.at(at).map_or(outside, |pixel| match bit {
            Bit::Register(Digital(r)) => pixel.digital[usize::from(r)],
            Bit::Flag => pixel.flag,
            Bit::Select | Bit::Rect => false,
        })
    }

    fn enabled(&self, at: Point, direction: Direction) -> bool {
        let register = match direction {
            Direction::South => 1,
            Direction::West => 2,
            Direction::North => 3,
            Direction::East => 4,
        };
        self.bit(at, Bit::Register(Digital(register)), false)
    }

    /// What the word leaves in the pixel at `at`.
    #[allow(clippy::too_many_lines)] // One table, one function.
    fn after(&self, at: Point, word: &Primitive) -> Pixel<D::Cell> {
        let before = self.at(at).unwrap();
        let mut after = before.clone();
        let set = |after: &mut Pixel<_>, Digital(register): Digital, value: bool| {
            if register != 12 || before.digital[0] {
                after.digital[usize::from(register)] = value;
            }
        };
        match word {
            Primitive::Nop | Primitive::BlurSet | Primitive::PropRead => {}
            Primitive::ResetPix => after.pix = self.domain.hold(self.settings.reset_level),
            Primitive::Bus { targets, sources } => {
                let mut news: Option<D::Sum> = None;
                for target in targets {
                    let driver = match target {
                        Target::Register(Analog(6)) => at,
                        Target::Register(Analog(r)) => {
                            if before.flag {
                                let stored = self.stored(&self.sum(at, sources), targets.len());
                                after.analog[usize::from(*r)] = stored;
                            }
                            continue;
                        }
                        Target::Neighbour(direction) => beside(at, direction.opposite()),
                    };
                    if self.flag(driver) {
                        let sum = self.sum(driver, sources);
                        match &mut news {
                            None => {
                                let mut first = self.domain.nothing();
                                self.domain.join(&mut first, &sum);
                                news = Some(first);
                            }
                            Some(news) => self.domain.join(news, &sum),
                        }
                    }
                }
                if let Some(sum) = news {
                    after.analog[NEWS] = self.stored(&sum, targets.len());
                }
            }
            Primitive::Square { sources } => {
                if before.flag {
                    let sum = self.sum(at, sources);
                    let place = Place {
                        y: 0,
                        x: 0,
                        register: Analog(6),
                        step: 0,
                    };
                    let square = self.domain.square(&sum, self.settings.square_gain, place);
                    after.analog[NEWS] = self.limited(square.unwrap());
                }
            }
            Primitive::Where { sources } => {
                after.flag = self.domain.positive(&self.sum(at, sources)).unwrap();
            }
            Primitive::All => after.flag = true,
            Primitive::Blur {
                target,
                source,
                horizontal,
                vertical,
            } => {
                let mut sum = self.domain.nothing();
                let mut own = i32::from(self.settings.diffusion);
                for direction in Direction::ALL {
                    let sideways = matches!(direction, Direction::East | Direction::West);
                    let gate = Bit::Register(Digital(if sideways { 2 } else { 1 }));
                    let wanted = if sideways { *horizontal } else { *vertical };
                    let there = beside(at, direction);
                    if wanted && self.bit(at, gate, false) && self.bit(there, gate, false) {
                        let cell = &self.at(there).unwrap().analog[usize::from(source.0)];
                        self.domain.add(&mut sum, cell, 1);
                        own -= 1;
                    }
                }
                let cell = &before.analog[usize::from(source.0)];
                self.domain.add(&mut sum, cell, own);
                if before.flag {
                    let stored = self.stored(&sum, self.settings.diffusion.into());
                    after.analog[usize::from(target.0)] = stored;
                }
            }
            Primitive::Set { targets } => targets.iter().for_each(|r| set(&mut after, *r, true)),
            Primitive::Clear { targets } => targets.iter().for_each(|r| set(&mut after, *r, false)),
            Primitive::Or { target, sources } => {
                let any = sources.iter().any(|bit| self.bit(at, *bit, false));
                set(&mut after, *target, any);
            }
            Primitive::Nor { target, sources } => {
                let any = sources.iter().any(|bit| self.bit(at, *bit, false));
                set(&mut after, *target, !any);
            }
            Primitive::WhereBit { sources } => {
                after.flag = sources.iter().any(|bit| self.bit(at, *bit, false));
            }
            Primitive::Dnews {
                target,
                source,
                boundary,
            } => {
                let seen = Direction::ALL.iter().any(|direction| {
                    self.enabled(at, *direction)
                        && self.bit(beside(at, *direction), *source, *boundary)
                });
                set(&mut after, *target, seen);
            }
            // One pixel further; the whole word repeats it.
            Primitive::Prop { boundary } => {
                let r12 = Bit::Register(Digital(12));
                let seen = Direction::ALL.iter().any(|direction| {
                    self.enabled(at, *direction) && self.bit(beside(at, *direction), r12, *boundary)
                });
                let value = before.digital[12] || seen;
                set(&mut after, Digital(12), value);
            }
        }
        after
    }

    fn execute(&mut self, word: &Primitive) {
        let times = match (word, self.settings.propagation) {
            (Primitive::Prop { .. }, Propagation::Settled) => self.size.pixels() as u32,
            (Primitive::Prop { .. }, Propagation::Steps(steps)) => steps,
            _ => 1,
        };
        for _ in 0..times {
            let points = (0..self.size.pixels()).map(|i| {
                (
                    (i / self.size.width) as isize,
                    (i % self.size.width) as isize,
                )
            });
            let after: Vec<_> = points.map(|at| self.after(at, word)).collect();
            let settled = matches!(word, Primitive::Prop { .. })
                && after
                    .iter()
                    .zip(&self.pixels)
                    .all(|(a, b)| a.digital == b.digital);
            self.pixels = after;
            if settled {
                break;
            }
        }
    }
}

// ---------------------------------------------------------------- random programs

/// Read once; its files are the same for all.
fn device() -> &'static Device {
    static DEVICE: std::sync::LazyLock<Device> = std::sync::LazyLock::new(Device::scamp5);
    &DEVICE
}

fn defaults() -> Settings {
    Settings::of(device())
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

/// Values that are spread, exact in most formats, and now and then beyond a limit.
fn value(seed: u64, i: u64) -> f64 {
    let hash = (seed ^ i.wrapping_mul(0x9E37_79B9_7F4A_7C15)).wrapping_mul(0xD6E8_FEB8_6659_FD93);
    let hash = (hash ^ hash >> 32).wrapping_mul(0xD6E8_FEB8_6659_FD93);
    ((hash >> 40) % 4000) as f64 / 16.0 - 125.0
}

fn words(code: &[Primitive]) -> Vec<Step> {
    let step = |word: &Primitive| Step {
        action: Action::Word(word.clone()),
        line: 1,
    };
    code.iter().map(step).collect()
}

fn agrees<D: Domain + Clone>(
    domain: &D,
    size: Size,
    settings: Settings,
    seed: u64,
    program: &[Primitive],
) -> Result<(), TestCaseError> {
    let code = Code {
        init: vec![Step {
            action: Action::Host(Host::LoadIn { value: 5.5 }),
            line: 1,
        }],
        frame: words(program),
    };
    // By name, as it is given on the command line.
    let arithmetic: Arithmetic = domain.name().parse().unwrap();
    let mut chip = arithmetic
        .chip("test", code, device(), size, settings)
        .unwrap();
    let planes: Vec<Plane<f64>> = (0..21)
        .map(|k| {
            let at = |(y, x)| value(seed, k * 100_000 + (y * size.width + x) as u64);
            Plane::from_shape_fn(size.shape(), at)
        })
        .collect();
    let (analog, rest) = planes.split_at(7);
    let (digital, light) = rest.split_at(13);
    for (r, plane) in (0..).zip(analog) {
        chip.set_analog(Analog(r), plane).unwrap();
    }
    for (r, plane) in (0..).zip(digital) {
        chip.set_digital(Digital(r), &plane.mapv(|v| v > 0.0))
            .unwrap();
    }
    chip.expose(&light[0]).unwrap();
    let mut packet = Packet::new(size, 1);
    chip.run_init(Micros(0), &mut packet).unwrap();

    let pixels = light[0].indexed_iter().map(|(at, light)| Pixel {
        analog: analog.iter().map(|plane| domain.hold(plane[at])).collect(),
        pix: domain.hold(settings.reset_level + settings.gain * light),
        digital: digital.iter().map(|plane| plane[at] > 0.0).collect(),
        flag: true,
    });
    let mut twin = Twin {
        pixels: pixels.collect(),
        domain: domain.clone(),
        settings,
        size,
        input: domain.hold(5.5),
    };

    chip.run_frame(Micros(0), &mut packet).unwrap();
    for word in program {
        twin.execute(word);
    }
    let at = |i: usize| (i / size.width, i % size.width);
    for r in 0..7u8 {
        let ours = chip.analog(Analog(r));
        for (i, pixel) in twin.pixels.iter().enumerate() {
            let theirs = domain.value(&pixel.analog[usize::from(r)]);
            let ours = ours[at(i)];
            prop_assert_eq!(
                ours.to_bits(),
                theirs.to_bits(),
                "register {} at {:?}: {} {}",
                r,
                at(i),
                ours,
                theirs
            );
        }
    }
    for r in 0..13u8 {
        let ours = chip.digital(Digital(r));
        for (i, pixel) in twin.pixels.iter().enumerate() {
            prop_assert_eq!(
                ours[at(i)],
                pixel.digital[usize::from(r)],
                "R{} at {:?}",
                r,
                at(i)
            );
        }
    }
    let flag = chip.flag();
    for (i, pixel) in twin.pixels.iter().enumerate() {
        prop_assert_eq!(flag[at(i)], pixel.flag, "FLAG at {:?}", at(i));
    }
    Ok(())
}

macro_rules! every_domain {
    ($($name:ident: $domain:expr;)*) => {
        /// Random programs agree with the slow twin to the bit.
        mod twin {
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
    half: Halves::<f16>::default();
    brain: Halves::<bf16>::default();
    q8_8: Fixed::new(Q::<i16>::new(8));
    q8_8_wrap: Fixed::new(Q::<i16>::new(8).with_overflow(Overflow::Wrap));
    q8_0: Fixed::new(Q::<i8>::new(0));
    q1_7: Fixed::new(Q::<i8>::new(7));
    q16_16: Fixed::new(Q::<i32>::new(16));
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
    Chip::new("test", Exact, code, device(), size, settings).unwrap()
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
        }),
        line: 3,
    };
    let code = Code {
        init: vec![],
        frame: vec![scan(4), scan(100)],
    };
    let mut chip = Chip::new("test", Exact, code, device(), size, defaults()).unwrap();
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
        Address::of(At { y: 2, x: 0 }, size),
        Address { column: 3, row: 2 }
    );
    for at in (0..3).flat_map(|y| (0..4).map(move |x| At { y, x })) {
        assert_eq!(Address::of(at, size).at(size), Some(at));
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
        let chip = Chip::new("test", Exact, code, device(), Size::new(1, 1), defaults());
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
        });
        let code = Code { init: vec![], frame };
        let device = device();
        let expected = Cost::of(&code.frame, device);
        let mut chip =
            Chip::new("test", Exact, code, device, Size::new(2, 3), defaults()).unwrap();
        run(&mut chip);
        let cost = chip.ledger().cost(device);
        prop_assert_eq!(cost.words, expected.words);
        prop_assert!((cost.array_us - expected.array_us).abs() < 1e-9);
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
