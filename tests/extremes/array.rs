//! The array: every domain, what it does with light, sums, halves and memories, and what taps,
//! range and the check before a run refuse.

use amacrine::{
    array::{Array, Settings, range, taps},
    event::Packet,
    isa::{Analog, Device, Digital, Direction, Primitive, Source, Target},
    number::Format,
    plane::{Plane, Size},
    program::{Action, Code, Cost, Overrides, Program, Step},
    sensor::Sensor,
    unit::Micros,
};

use crate::{
    bound::{Bounds as _, gamma},
    light::{draw, exact_dot, frame},
    page::{Table, Worst, decades},
};

pub const A: Analog = Analog(0);
pub const B: Analog = Analog(1);
pub const C: Analog = Analog(2);
pub const E: Analog = Analog(4);
pub const F: Analog = Analog(5);
pub const T: Analog = Analog(6);

const DOMAINS: [&str; 9] = [
    "exact",
    "f32",
    "f16",
    "bf16",
    "q1.7",
    "q8.0",
    "q8.8",
    "q8.8-wrap",
    "q8.24",
];

/// Read once; its files are the same for all.
pub fn device() -> &'static Device {
    static DEVICE: std::sync::LazyLock<Device> = std::sync::LazyLock::new(Device::scamp5);
    &DEVICE
}

pub fn bus(targets: &[Analog], sources: &[Analog]) -> Primitive {
    Primitive::Bus {
        targets: targets.iter().map(|r| Target::Register(*r)).collect(),
        sources: sources.iter().map(|r| Source::Register(*r)).collect(),
    }
}

fn pix(target: Analog, more: &[Analog]) -> Primitive {
    let more = more.iter().map(|r| Source::Register(*r));
    Primitive::Bus {
        targets: vec![Target::Register(target)],
        sources: std::iter::once(Source::Pix).chain(more).collect(),
    }
}

/// `target := light / 2`, by way of NEWS.
pub fn get_image(target: Analog) -> Vec<Primitive> {
    let reset = Primitive::ResetPix;
    vec![pix(T, &[]), reset.clone(), reset, pix(target, &[T])]
}

/// `target := source` of the neighbour.
pub fn movx(target: Analog, source: Analog, from: Direction) -> Vec<Primitive> {
    let drive = Primitive::Bus {
        targets: vec![Target::Neighbour(from.opposite())],
        sources: vec![Source::Register(source)],
    };
    vec![drive, bus(&[target], &[T])]
}

pub fn step(action: Action) -> Step {
    Step {
        action,
        line: 1,
        origin: None,
    }
}

pub fn words(words: impl IntoIterator<Item = Primitive>) -> Vec<Step> {
    let word = |word| step(Action::Word(word));
    words.into_iter().map(word).collect()
}

fn repeat(times: u32, body: Vec<Primitive>) -> Vec<Step> {
    let body = words(body);
    vec![step(Action::Repeat { times, body })]
}

fn settings() -> Settings {
    Settings::from_device(device())
}

/// A chip that runs `frame` for every frame, the first one too.
pub fn chip(domain: &str, size: Size, frame: Vec<Step>) -> Box<dyn Array + Send> {
    let init = frame.clone();
    let arithmetic: amacrine::array::Arithmetic = domain.parse().unwrap();
    arithmetic
        .chip(
            "extremes",
            &Code { init, frame },
            device(),
            size,
            settings(),
        )
        .unwrap()
}

fn run(chip: &mut dyn Array) {
    let size = chip.layout().size;
    chip.run_frame(Micros(0), &mut Packet::new(size, 1))
        .unwrap();
}

pub fn table() -> Table {
    let mut table = Table::default();
    for domain in DOMAINS {
        stores(domain, &mut table);
        halves(domain, &mut table);
        light(domain, &mut table);
        memory(domain, &mut table);
    }
    silicon(&mut table);
    not_a_number(&mut table);
    kernels(&mut table);
    ranges(&mut table);
    refusals(&mut table);
    table
}

/// The format of the cells, and the unit roundoff of the bus.
fn arithmetic(domain: &str) -> (Format, f64) {
    let format: Format = domain.parse().unwrap();
    let bus = match format {
        Format::F64 => Format::F64.unit_roundoff(),
        Format::F32 | Format::F16 | Format::Bf16 => Format::F32.unit_roundoff(),
        Format::Fixed(_) => 0.0,
    };
    (format, bus)
}

/// By how much one store of so many sources, whose sizes are `size` together, can be off in each
/// of `targets` cells: the bus sums and divides, the store rounds.
fn store_bound(domain: &str, sources: usize, targets: usize, size: f64) -> f64 {
    let (format, bus) = arithmetic(domain);
    let on_the_bus = gamma(sources, bus);
    let stored = (on_the_bus + format.unit_roundoff() * (1.0 + on_the_bus)) * size;
    let bound = stored / targets as f64 + format.half_step();
    let (low, high) = format.limits();
    if size / targets as f64 + bound <= high.min(-low) {
        bound
    } else {
        f64::INFINITY
    }
}

fn stores(domain: &str, table: &mut Table) {
    let mut worst = Worst::default();
    let size = Size::new(8, 9);
    for (sources, targets) in [(1, 1), (2, 1), (4, 1), (1, 2), (4, 2), (1, 3), (4, 3)] {
        let from: Vec<_> = (0..sources).map(Analog).collect();
        let to: Vec<_> = (4..4 + targets).map(Analog).collect();
        let mut chip = chip(domain, size, words([bus(&to, &from)]));
        for scale in decades(-6, 6) {
            for register in &from {
                let seed = u64::from(register.0);
                let value = |(y, x)| scale * draw(seed, y * size.width + x);
                let plane = Plane::from_shape_fn(size.shape(), value);
                chip.set_analog(*register, &plane).unwrap();
            }
            let held: Vec<_> = from.iter().map(|r| chip.analog(*r)).collect();
            run(&mut *chip);
            for register in &to {
                for (at, got) in chip.analog(*register).indexed_iter() {
                    let (sum, rest) = exact_dot(held.iter().map(|plane| (-1.0, plane[at])));
                    let sizes: f64 = held.iter().map(|plane| plane[at].abs()).sum();
                    let by = f64::from(targets);
                    let error = ((got * by - sum) - rest).abs() / by;
                    let bound = store_bound(domain, sources.into(), targets.into(), sizes);
                    if bound < f64::INFINITY {
                        let what = format_args!("{domain}: {sources} to {targets}, {scale:e}");
                        worst.see(error, bound, what);
                    }
                }
            }
        }
    }
    let bound = match arithmetic(domain).0 {
        Format::Fixed(_) => "half an LSB",
        _ => "(γ(n) of the bus + u of the cell) Σ|x| / targets, half a subnormal",
    };
    table.within(
        &format!("`{domain}`: a store of 1 to 4 sources in 1 to 3 targets"),
        "1e-6 to 1e6 LSB",
        "its error",
        bound,
        worst,
    );
}

/// Halved by a bus with two targets, twenty-four times over.
fn halves(domain: &str, table: &mut Table) {
    let (format, _) = arithmetic(domain);
    let size = Size::new(16, 16);
    let body = [bus(&[B, C], &[A]), bus(&[A, E], &[B])];
    let mut chip = chip(domain, size, words(body));
    let most = format.limits().1.min(127.0);
    let first = Plane::from_shape_fn(size.shape(), |(y, x)| most * draw(7, y * 16 + x));
    chip.set_analog(A, &first).unwrap();
    let first = chip.analog(A);
    let (mut once, mut all) = (Worst::default(), Worst::default());
    for times in 1..=12 {
        run(&mut *chip);
        let scale = 2f64.powi(2 * times);
        for (at, got) in chip.analog(A).indexed_iter() {
            let error = (got - first[at] / scale).abs();
            all.see(error, 2.0 * format.half_step(), domain);
            if times == 1 {
                let half = chip.analog(B)[at];
                once.see((half + first[at] / 2.0).abs(), format.half_step(), domain);
            }
        }
    }
    let end = match format {
        Format::Fixed(_) => ("half an LSB", "an LSB: half of it, a quarter, …"),
        _ => ("half a subnormal", "two of these"),
    };
    let what = format!("`{domain}`: a value halved");
    table.within(&what, "once", "its error", end.0, once);
    table.within(
        &what,
        "24 times, one after the other",
        "its error",
        end.1,
        all,
    );
}

/// `get_image` leaves half the light.
fn light(domain: &str, table: &mut Table) {
    let (format, _) = arithmetic(domain);
    let size = Size::new(1, 1);
    let mut worst = Worst::default();
    let mut good = 0.0;
    let mut at_most = String::new();
    for (n, scale) in decades(-6, 9).enumerate() {
        let mut chip = chip(domain, size, words(get_image(A)));
        let light = frame(0, 0.0, Plane::from_elem((1, 1), scale));
        let watched = chip.watch(&light, &mut Packet::new(size, 1));
        if let Err(error) = watched {
            at_most = format!("beyond, refused: *{error}*");
            break;
        }
        let got = chip.analog(A)[[0, 0]];
        // PIX, NEWS, and the difference from the reset level.
        let pix = scale / 2.0 + 127.0;
        let stores = store_bound(domain, 1, 1, pix) + store_bound(domain, 2, 1, pix + 127.0);
        let bound = format.hold_bound(pix) + stores;
        // A sum of the two is in range if their difference is: the bus is wider.
        let in_range = pix - 254.0 <= format.limits().1 && scale / 2.0 <= format.limits().1;
        let bound = match format {
            Format::Fixed(_) if in_range => 3.0 * format.half_step(),
            _ => bound,
        };
        if bound < f64::INFINITY && format.limits().0 <= -127.0 {
            worst.see(
                (got - scale / 2.0).abs(),
                bound,
                format_args!("{domain}, {scale:e}"),
            );
            good = scale;
        } else {
            at_most = format!("light {scale:.0e} gives {got}");
        }
        assert!(n < 16);
    }
    let happens = if at_most.is_empty() {
        "half the light".to_owned()
    } else {
        at_most
    };
    let what = format!("`{domain}`: `get_image`");
    if worst.cases() == 0 {
        table.happens(&what, "light 1e-6 to 1e9", &happens);
    } else {
        let to = format!("light 1e-6 to 1e9, good to {good:.0e}");
        table.within(
            &what,
            &to,
            &happens,
            "what holding PIX and two stores can do",
            worst,
        );
    }
}

/// A register to which a threshold is added again and again, two words each time.
fn memory(domain: &str, table: &mut Table) {
    let (format, _) = arithmetic(domain);
    let steps = 100_000u32;
    let add = vec![bus(&[T], &[A, B]), bus(&[A], &[T])];
    let size = Size::new(1, 1);
    let mut chip = chip(domain, size, repeat(steps, add));
    chip.set_analog(B, &Plane::from_elem((1, 1), 0.2)).unwrap();
    let theta = chip.analog(B)[[0, 0]];
    run(&mut *chip);
    let got = chip.analog(A)[[0, 0]];
    let exact = f64::from(steps) * theta;
    let what = format!("`{domain}`: `add(A, A, B)` with B = 0.2 LSB");
    let bound = gamma(4 * steps as usize, format.unit_roundoff()) * exact;
    if theta == 0.0 {
        table.happens(&what, "1e5 times", "0.2 is held as 0");
    } else if bound < f64::INFINITY && exact <= format.limits().1 {
        let mut worst = Worst::default();
        worst.see((got - exact).abs(), bound, domain);
        let happens = format!("{:.6} of what it should be", got / exact);
        table.within(&what, "1e5 times", &happens, "γ(4 n) n θ", worst);
    } else {
        let happens = format!("it stands at {got}, not at {exact:.0}");
        table.happens(&what, "1e5 times", &happens);
    }
}

/// The real chip's errors at the ends of its range, and its bits after a day.
fn silicon(table: &mut Table) {
    let size = Size::new(16, 16);
    let mut packet = Packet::new(size, 1);
    for light in [1e-6, 1e9] {
        let lit = frame(0, 0.0, Plane::from_elem(size.shape(), light));
        let mut chip = chip("silicon", size, words(get_image(A)));
        chip.watch(&lit, &mut packet).unwrap();
        let got = chip.analog(A);
        let (low, high) = got
            .iter()
            .fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
        let happens = format!("{low:.0} to {high:.0} LSB over the array");
        assert!(low >= -148.0 && high <= 147.0);
        table.happens(
            "`silicon`: `get_image`",
            &format!("light {light:.0e}"),
            &happens,
        );
    }
    let kept = |domain: &str| {
        let mut chip = chip(domain, size, Vec::new());
        let ones = Plane::from_elem(size.shape(), true);
        chip.set_digital(Digital(5), &ones).unwrap();
        chip.wait(86_400.0);
        chip.digital(Digital(5)).iter().filter(|bit| **bit).count()
    };
    for domain in ["exact", "silicon"] {
        let happens = format!("{} of {} are still set", kept(domain), size.pixels());
        table.happens(&format!("`{domain}`: one-bit registers"), "a day", &happens);
    }
}

/// Infinity and NaN on the bus of the floats.
fn not_a_number(table: &mut Table) {
    let body = || {
        let mut body = words([bus(&[T], &[A, B]), bus(&[C], &[T]), bus(&[E], &[T, C])]);
        body.extend(words([Primitive::Where {
            sources: vec![Source::Register(E)],
        }]));
        body
    };
    for (domain, clip) in [("f16", false), ("f16", true), ("exact", false)] {
        let size = Size::new(1, 1);
        let code = Code {
            init: Vec::new(),
            frame: body(),
        };
        let with = Settings { clip, ..settings() };
        let arithmetic: amacrine::array::Arithmetic = domain.parse().unwrap();
        let mut chip = arithmetic.chip("x", &code, device(), size, with).unwrap();
        for register in [A, B] {
            chip.set_analog(register, &Plane::from_elem((1, 1), 6e4))
                .unwrap();
        }
        run(&mut *chip);
        let (sum, difference) = (chip.analog(C)[[0, 0]], chip.analog(E)[[0, 0]]);
        let flag = u8::from(chip.flag()[[0, 0]]);
        let happens = format!("{sum}; less itself {difference}; `where` gives FLAG {flag}");
        let what = format!("`{domain}`{}: a sum", if clip { ", clipped" } else { "" });
        table.happens(&what, "6e4 + 6e4 LSB", &happens);
    }
}

/// Reading a program's kernel back.
fn kernels(table: &mut Table) {
    let read = |steps: &[Step]| taps::read(steps, device(), settings(), A);
    let double = |times| {
        repeat(
            times,
            vec![
                bus(&[T], &[A, B]),
                bus(&[A], &[T]),
                bus(&[C], &[A]),
                bus(&[B], &[C]),
            ],
        )
    };
    let start = || words([bus(&[C], &[A]), bus(&[B], &[C])]);
    for times in [60u32, 200] {
        let mut steps = start();
        steps.extend(double(times));
        let kernel = read(&steps)
            .unwrap()
            .kernel(amacrine::array::Input::Register(A));
        let want = 2f64.powi(times as i32);
        assert_eq!(kernel[[0, 0]], want);
        let happens = format!("the weight is {want:e}, exactly");
        table.happens(
            "`taps`: a register doubled",
            &format!("{times} times"),
            &happens,
        );
    }
    // The weight is then a sum of powers that lie far apart.
    let mut steps = words([
        bus(&[C], &[A]),
        bus(&[B], &[C]),
        bus(&[C], &[A]),
        bus(&[F], &[C]),
    ]);
    steps.extend(double(130));
    steps.extend(words([bus(&[T], &[A, F]), bus(&[A], &[T])]));
    table.refused(
        "`taps`: 2^130 + 1 of a register",
        "",
        read(&steps).unwrap_err(),
    );
    let far: Vec<_> = (0..201).flat_map(|_| movx(A, A, Direction::East)).collect();
    table.refused(
        "`taps`: as far away",
        "201 pixels",
        read(&words(far)).unwrap_err(),
    );
    let third = words([bus(&[A, C, E], &[B])]);
    table.refused("`taps`: a third", "", read(&third).unwrap_err());
    let square = Primitive::Square {
        sources: vec![Source::Register(A)],
    };
    let square = words([square, bus(&[A], &[T])]);
    table.refused("`taps`: a square", "", read(&square).unwrap_err());
}

/// Which values are possible.
fn ranges(table: &mut Table) {
    let of = |steps: &[Step], most: f64| {
        let inputs = range::Inputs {
            light: range::Interval::new(1e-6, most),
            ..range::Inputs::from_device(device())
        };
        range::of(steps, device(), settings(), inputs).unwrap()
    };
    for most in [255.0, 1e9] {
        let ranges = of(&words(get_image(A)), most);
        let found = ranges.registers[usize::from(A.0)];
        let mut worst = Worst::default();
        for light in [1e-6, most] {
            let size = Size::new(1, 1);
            let mut chip = chip("exact", size, words(get_image(A)));
            chip.expose(&Plane::from_elem((1, 1), light)).unwrap();
            run(&mut *chip);
            let got = chip.analog(A)[[0, 0]];
            let end = if light < 1.0 { found.low } else { found.high };
            // The interval is exact, the run is in doubles.
            worst.see(
                (got - end).abs(),
                4.0 * f64::EPSILON * (got.abs() + 254.0),
                "an end",
            );
        }
        table.within(
            "`range`: `get_image`",
            &format!("light 1e-6 to {most}"),
            &format!("{} stores can leave the range", ranges.saturations.len()),
            "both ends are reached, to the last digits of f64",
            worst,
        );
    }
    let double = vec![
        bus(&[T], &[A, B]),
        bus(&[A], &[T]),
        bus(&[C], &[A]),
        bus(&[B], &[C]),
    ];
    for times in [30, 2000] {
        let ranges = of(&repeat(times, double.clone()), 255.0);
        let found = ranges.registers[usize::from(A.0)];
        assert!(!found.low.is_nan() && !found.high.is_nan());
        let happens = format!("{:.3e} to {:.3e} LSB", found.low, found.high);
        table.happens(
            "`range`: a register doubled",
            &format!("{times} times"),
            &happens,
        );
    }
}

fn refusals(table: &mut Table) {
    for (height, width) in [(0, 5), (1, 65_537)] {
        let size = Size::new(height, width);
        let arithmetic: amacrine::array::Arithmetic = "exact".parse().unwrap();
        let chip = arithmetic.chip("x", &Code::default(), device(), size, settings());
        let error = chip.map(|_| ()).unwrap_err();
        table.refused("an array", &size.to_string(), error);
    }
    let size = Size::new(1, 1);
    let mut packet = Packet::new(size, 1);
    let mut still = chip("exact", size, Vec::new());
    let mut watch = |index, seconds, light| {
        still.watch(
            &frame(index, seconds, Plane::from_elem((1, 1), light)),
            &mut packet,
        )
    };
    watch(0, 1.0, 5.0).unwrap();
    table.refused(
        "a frame",
        "the time of the one before",
        watch(1, 1.0, 5.0).unwrap_err(),
    );
    table.refused("a frame", "1e10 s", watch(2, 1e10, 5.0).unwrap_err());
    table.refused("light", "NaN", watch(3, 2.0, f64::NAN).unwrap_err());
    table.refused(
        "light",
        "infinite",
        watch(4, 2.0, f64::INFINITY).unwrap_err(),
    );
    let mut half = chip("f16", size, Vec::new());
    let dazzling = frame(0, 0.0, Plane::from_elem((1, 1), 1e9));
    let error = half.watch(&dazzling, &mut packet).unwrap_err();
    table.refused("`f16`: light", "1e9", error);
    let expand = |text: &str| {
        let program = Program::parse("x.scamp", text)?;
        program.expand(device(), &Overrides::new())
    };
    for (what, to, text) in [
        (
            "`repeat`",
            "1e10 times",
            "repeat 10000000000 { mov(A, B); }",
        ),
        ("`scamp5_in`", "1e999", "scamp5_in(A, 1e999);"),
        (
            "a readout",
            "4001 slots",
            "scamp5_scan_events(R5, on, 4001);",
        ),
    ] {
        match expand(&format!("frame {{ {text} }}")) {
            Err(faults) => table.refused(what, to, &faults.faults[0]),
            Ok(expansion) => {
                let arithmetic: amacrine::array::Arithmetic = "exact".parse().unwrap();
                let chip = arithmetic.chip("x", &expansion.code, device(), size, settings());
                table.refused(what, to, chip.map(|_| ()).unwrap_err());
            }
        }
    }
    let mut steps = words([Primitive::Nop]);
    for _ in 0..3 {
        let body = steps;
        steps = vec![step(Action::Repeat {
            times: u32::MAX,
            body,
        })];
    }
    let cost = Cost::of(&steps, device());
    assert_eq!(cost.words.0, u64::MAX);
    table.happens(
        "the cost of nested repetitions",
        "2^96 words",
        &format!(
            "{} words: the count stays at the most it holds",
            cost.words.0
        ),
    );
}
