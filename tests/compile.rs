//! Compiled kernels: the program that comes out computes the kernel that went in, exactly, as
//! read back from its text (`Taps`), whatever the kernel, the registers and the effort; it never
//! costs more than a naive snake, nor more than was once reached; and a whole compiled sensor
//! emits the packets of the float reference.

use std::{
    fmt::Write as _,
    sync::atomic::{AtomicBool, Ordering},
};

use amacrine::{
    array::{Arithmetic, Chip, Exact, Input, Settings, range, taps},
    compile::{
        BitMemory, CellKind, CompileError, DriveMemory, Effort, Filter, Objective, Request,
        SensorProgram, leaves, naive_cost,
    },
    event::{Packet, Polarity},
    isa::{Analog, Device, Figure},
    kernel::{
        Kernel,
        quantise::{Quantiser, Sum},
    },
    number::Format,
    plane::{Plane, Size},
    program::{Cost, Overrides, Program},
    reference::{Description, Reference},
    scene::{Frame, bundled},
    sensor::Sensor,
    stop::Stop,
    study::design::Design,
    unit::Micros,
};
use proptest::prelude::*;

fn kernel(rows: &[Vec<f64>]) -> Kernel {
    Kernel::from_rows(rows).unwrap()
}

fn outer(down: &[f64], across: &[f64], scale: f64) -> Kernel {
    let row = |y: &f64| across.iter().map(|x| x * y * scale).collect();
    kernel(&down.iter().map(row).collect::<Vec<_>>())
}

/// As [`compiled`], into these registers; the input is in A.
fn compiled_into(kernels: &[Kernel], into: &[u8], states: u64) -> usize {
    let device = Device::scamp5();
    let mut request = Request::new(kernels, &device).unwrap();
    request.effort = Effort::states(states);
    request.objective = Objective::Words;
    request.into = into.iter().map(|register| Analog(*register)).collect();
    let filter = request.filter().unwrap();
    for (kernel, found) in kernels.iter().zip(read_back(&filter, &request)) {
        assert_eq!(kernel.weights(), found, "{into:?}");
    }
    filter.words.len()
}

/// The kernels that the text of a filter computes from A, framed as the asked-for ones.
fn read_back(filter: &Filter, request: &Request<'_>) -> Vec<Plane<f64>> {
    let device = request.device;
    let text = filter.text(device, 0);
    let program = Program::parse("filter", &text).unwrap();
    let expansion = program.expand(device, &Overrides::default()).unwrap();
    let steps = &expansion.code.frame;
    assert_eq!(Cost::of(steps, device).words.0, filter.words.len() as u64);
    let read = |(kernel, register): (&Kernel, &Analog)| {
        let taps = taps::read(steps, device, Settings::from_device(device), *register).unwrap();
        assert!(
            taps.taps
                .keys()
                .all(|(input, ..)| *input == Input::Register(request.input))
        );
        let (height, width) = kernel.weights().dim();
        let centre = (height as isize / 2, width as isize / 2);
        let mut plane = Plane::zeros((height, width));
        for ((_, dy, dx), weight) in &taps.taps {
            let at = (centre.0 + dy, centre.1 + dx);
            plane[(at.0 as usize, at.1 as usize)] = weight.to_f64();
        }
        plane
    };
    request
        .kernels
        .iter()
        .zip(&request.into)
        .map(read)
        .collect()
}

fn compiled(kernels: &[Kernel], states: u64) -> usize {
    let device = Device::scamp5();
    let mut request = Request::new(kernels, &device).unwrap();
    request.effort = Effort::states(states);
    request.objective = Objective::Words;
    let filter = request.filter().unwrap();
    for (kernel, found) in kernels.iter().zip(read_back(&filter, &request)) {
        assert_eq!(kernel.weights(), found);
    }
    assert!(filter.words.len() as u64 <= naive_cost(kernels).unwrap());
    filter.words.len()
}

/// Words that were reached once, at this effort.
#[test]
fn words_do_not_grow() {
    let binomial = [1.0, 2.0, 1.0];
    let five = [1.0, 4.0, 6.0, 4.0, 1.0];
    let slope = [-1.0, 0.0, 1.0];
    let flat = [1.0; 3];
    let cross = [
        vec![0.0, 1.0, 0.0],
        vec![1.0, -4.0, 1.0],
        vec![0.0, 1.0, 0.0],
    ];
    let table: Vec<(&str, Vec<Kernel>, usize)> = vec![
        ("identity", vec![outer(&[1.0], &[1.0], 1.0)], 0),
        ("Sobel", vec![outer(&binomial, &slope, 1.0)], 6),
        (
            "both Sobels",
            vec![outer(&binomial, &slope, 1.0), outer(&slope, &binomial, 1.0)],
            11,
        ),
        ("Prewitt", vec![outer(&flat, &slope, 1.0)], 4),
        ("box 3x3", vec![outer(&flat, &flat, 1.0)], 4),
        ("Laplacian", vec![kernel(&cross)], 7),
        (
            "binomial 3x3 / 16",
            vec![outer(&binomial, &binomial, 1.0 / 16.0)],
            6,
        ),
        (
            "binomial 5x5 / 256",
            vec![outer(&five, &five, 1.0 / 256.0)],
            12,
        ),
    ];
    for (name, kernels, most) in table {
        let words = compiled(&kernels, 300_000);
        println!(
            "{name:<20}{words:>4} words, snake {}",
            naive_cost(&kernels).unwrap()
        );
        assert!(words <= most, "{name}: {words} words, {most} were reached");
    }
}

/// The worst that a kernel can be: all weights different, five bits each.
/// Where the first result replaces the input, which is also a result, or is found last.
#[test]
fn an_order_of_results_costs_no_more_than_moves() {
    let binomial = [1.0, 2.0, 1.0];
    let five = [1.0, 4.0, 6.0, 4.0, 1.0];
    let kernels = [
        outer(&five, &five, 1.0 / 256.0),
        outer(&binomial, &binomial, 1.0 / 16.0),
        outer(&[1.0], &[1.0], 1.0),
    ];
    let orders = [
        [2, 1, 0],
        [2, 0, 1],
        [1, 2, 0],
        [1, 0, 2],
        [0, 1, 2],
        [0, 2, 1],
    ];
    let words = orders.map(|into| compiled_into(&kernels, &into, 100_000));
    let least = words.iter().min().unwrap();
    println!("{words:?}");
    // Two of three results that lie elsewhere, two words each.
    assert!(words.iter().all(|it| *it <= least + 4), "{words:?}");
}

#[test]
fn dense_kernels_cost_two_words_a_place() {
    let weight = |y: i32, x: i32| f64::from((7 * y * y + 11 * x + 3 * x * y) % 31 - 15) / 16.0;
    let rows = |side: i32| -> Vec<Vec<f64>> {
        let row = |y| (0..side).map(|x| weight(y, x)).collect();
        (0..side).map(row).collect()
    };
    for (side, most) in [(3, 24), (5, 64)] {
        let words = compiled(&[kernel(&rows(side))], 0);
        println!("{side}x{side}: {words} words");
        assert!(words <= most, "{words} words, {most} were reached");
    }
    // Too long to be read back as forms; the compiler checks each plan itself.
    let device = Device::scamp5();
    let kernels = [kernel(&rows(11))];
    let mut request = Request::new(&kernels, &device).unwrap();
    request.effort = Effort::states(0);
    let words = request.filter().unwrap().words.len();
    println!("11x11: {words} words");
    assert!(words <= 310, "{words} words, 310 were reached");
}

/// A single weight has the shortest snake of all.
#[test]
fn no_weight_costs_more_than_its_snake() {
    for weight in -80..=80 {
        for scale in [1.0, 0.5, 0.125] {
            compiled(&[outer(&[f64::from(weight)], &[scale], 1.0)], 0);
        }
    }
}

/// Noise and mismatch as they are predicted, against the array as silicon.
#[test]
fn silicon_errs_as_predicted() {
    let device = Device::scamp5();
    let five = [1.0, 4.0, 6.0, 4.0, 1.0];
    let kernels = [
        Kernel::builtin("rgc-5x5-ternary").unwrap(),
        outer(&five, &five, 1.0 / 256.0),
        outer(&[1.0, 2.0, 1.0], &[-1.0, 0.0, 1.0], 0.25),
    ];
    for (seed, kernel) in kernels.into_iter().enumerate() {
        let kernels = [kernel];
        let mut request = Request::new(&kernels, &device).unwrap();
        request.effort = Effort::states(3000);
        request.range = Some((0.0, 32.0));
        let filter = request.filter().unwrap();
        let level = 24.0;
        let said = filter.noise(&device, level)[0];
        let text = filter.text(&device, 0);
        let program = Program::parse("filter", &text).unwrap();
        let code = program.expand(&device, &Overrides::default()).unwrap().code;
        let silicon = Arithmetic::Silicon { seed: seed as u64 };
        let size = Size::new(256, 256);
        let settings = Settings::from_device(&device);
        let mut chip = silicon
            .chip("filter", &code, &device, size, settings)
            .unwrap();
        let mut result = || {
            let flat = Plane::from_elem((256, 256), level);
            chip.set_analog(request.input, &flat).unwrap();
            chip.run_frame(Micros(0), &mut Packet::new(size, 1))
                .unwrap();
            let inner = chip.analog(request.into[0]);
            inner.slice(ndarray::s![16..240, 16..240]).to_owned()
        };
        let (first, second) = (result(), result());
        let temporal = (&first - &second).var(0.0) / 2.0;
        let fixed = (first.var(0.0) - temporal).sqrt();
        let temporal = temporal.sqrt();
        println!(
            "temporal {temporal:.4} said {:.4}; fixed {fixed:.4} said {:.4}",
            said.temporal, said.fixed
        );
        assert!(
            (temporal / said.temporal - 1.0).abs() < 0.03,
            "{temporal} {said:?}"
        );
        assert!((fixed / said.fixed - 1.0).abs() < 0.05, "{fixed} {said:?}");
    }
}

/// A program that is said to hold does not saturate as silicon: events of the exact and of the
/// erring array are of one order, for kernels whose shortest plans pile up transfer
/// errors.
#[test]
fn what_holds_works_as_silicon() {
    let device = Device::scamp5();
    let weights = Kernel::builtin("rgc-5x5").unwrap();
    for to in ["ternary", "int-3", "int-5"] {
        let to: Quantiser = to.parse().unwrap();
        let quantised = to.quantise(&weights, Sum::Zero, 0).unwrap().within_one();
        let threshold = 256.0 / quantised.scale;
        let kinds = [CellKind {
            name: None,
            kernel: quantised.levels.clone(),
            on: threshold,
            off: threshold,
        }];
        let kernels = [quantised.levels];
        let mut request = Request::new(&kernels, &device).unwrap();
        request.effort = Effort::states(20_000);
        request.objective = Objective::Exact;
        let sensor = SensorProgram::new(&kinds, DriveMemory::Analogue, "holds", &request).unwrap();
        assert!(sensor.filter.holds, "{to}");
        let program = Program::parse("holds", &sensor.text).unwrap();
        let code = program.expand(&device, &Overrides::default()).unwrap().code;
        let clip = clip(5);
        let size = Size::of(&clip[0]);
        let settings = Settings {
            clip: true,
            ..Settings::from_device(&device)
        };
        let events = |arithmetic: Arithmetic| {
            let chip = arithmetic.chip("holds", &code, &device, size, settings);
            watch(&mut chip.unwrap(), &clip).events.len() as f64
        };
        let exact = events("exact".parse().unwrap());
        let silicon = events(Arithmetic::Silicon { seed: 1 });
        println!(
            "{to}: {} words, {exact} events exact, {silicon} as silicon",
            sensor.filter.words.len()
        );
        assert!(
            exact > 50.0 && (0.4..2.5).contains(&(silicon / exact)),
            "{to}: {exact} {silicon}"
        );
    }
}

#[test]
fn the_same_seed_gives_the_same_program() {
    let device = Device::scamp5();
    let kernels = [Kernel::builtin("rgc-5x5-ternary").unwrap()];
    let mut request = Request::new(&kernels, &device).unwrap();
    request.effort = Effort::states(30_000);
    let first = request.filter().unwrap();
    assert_eq!(first.words, request.filter().unwrap().words);
}

#[test]
fn what_cannot_be_is_said() {
    let device = Device::scamp5();
    let third = [kernel(&[vec![0.5, 1.0 / 3.0, 0.0]])];
    let error = Request::new(&third, &device).unwrap().filter().unwrap_err();
    assert!(matches!(
        error,
        CompileError::NotDyadic {
            row: 0,
            column: 1,
            ..
        }
    ));
    assert!(error.to_string().starts_with("kernel 0, row 0"), "{error}");
    let named = error.of_kernel("edges.toml").to_string();
    assert!(
        named.starts_with("edges.toml, row 0, column 1: "),
        "{named}"
    );
    let kinds = vec![
        CellKind {
            name: None,
            kernel: outer(&[1.0], &[1.0], 1.0),
            on: 1.0,
            off: 1.0
        };
        3
    ];
    let ones = [outer(&[1.0], &[1.0], 1.0)];
    let request = Request::new(&ones, &device).unwrap();
    let error = SensorProgram::new(&kinds, DriveMemory::Analogue, "three", &request).unwrap_err();
    assert!(error.to_string().ends_with("2 too few"), "{error}");
    // Each way out that is named was compiled.
    let CompileError::Kinds { advice, .. } = error else {
        panic!("{error}")
    };
    for way in ["--memory shared", "the first 2", "--chip scamp5-wide"] {
        assert!(advice.contains(way), "{advice}");
    }
    assert!(!advice.contains("bits"), "{advice}");
}

/// One-bit memories only with as many levels as the threshold needs.
#[test]
fn levels_are_as_close_as_the_threshold_needs() {
    let device = Device::scamp5();
    let kernels = [outer(&[1.0], &[1.0], 1.0)];
    let mut request = Request::new(&kernels, &device).unwrap();
    request.effort = Effort::states(0);
    // Light in half LSB: a range of 127.5.
    let kinds = |count, on: f64| {
        let kind = CellKind {
            name: None,
            kernel: kernels[0].clone(),
            on,
            off: 1.5 * on,
        };
        vec![kind; count]
    };
    let program = |count, on, bits| {
        SensorProgram::new(&kinds(count, on), DriveMemory::Bits(bits), "bits", &request)
    };
    // A threshold of 10 LSB.
    for bits in [1, 2] {
        let Err(CompileError::Levels { needed, advice, .. }) = program(1, 20.0, bits) else {
            panic!("{bits} bits")
        };
        assert_eq!(needed, Some(4));
        assert!(advice.contains("bits:4"), "{advice}");
    }
    let [three, four] = [3, 4].map(|bits| program(1, 20.0, bits).unwrap().steps.remove(0));
    assert!(four.step / 2.0 <= 10.0);
    assert_eq!(four.restless, None);
    // Half a step of 8 LSB would do without the chip's errors.
    let restless = three.restless.unwrap();
    assert!((1e-3..1e-2).contains(&restless.firing), "{restless:?}");
    assert_eq!(restless.bits, Some(4));
    assert!(
        (10.5..14.0).contains(&restless.least.unwrap()),
        "{restless:?}"
    );
    // Of 2 LSB: without errors five bits do, on the chip none.
    for bits in [2, 4] {
        let Err(CompileError::Levels { needed, advice, .. }) = program(1, 4.0, bits) else {
            panic!("{bits} bits")
        };
        assert_eq!(needed, None);
        assert!(!advice.contains("bits:"), "{advice}");
    }
    let five = program(1, 4.0, 5).unwrap();
    assert!(five.steps[0].step / 2.0 <= 2.0);
    assert!(five.steps[0].restless.is_some());
    // Three kinds have not four bits each: no number of bits is suggested.
    for refused in [program(2, 4.0, 4), program(3, 20.0, 2)] {
        let Err(CompileError::Levels { advice, .. }) = refused else {
            panic!("several kinds")
        };
        assert!(
            advice.contains("--memory shared") && !advice.contains("bits:"),
            "{advice}"
        );
    }
}

fn weights(side: usize, bits: u32, most: i32) -> impl Strategy<Value = Kernel> {
    let row = proptest::collection::vec(-most..=most, side);
    proptest::collection::vec(row, side).prop_map(move |rows| {
        let scale = 2f64.powi(-(bits as i32));
        let row = |row: &Vec<i32>| row.iter().map(|w| f64::from(*w) * scale).collect();
        kernel(&rows.iter().map(row).collect::<Vec<_>>())
    })
}

fn kernels() -> impl Strategy<Value = Kernel> {
    (0usize..3, 0u32..4, 1i32..12)
        .prop_flat_map(|(half, bits, most)| weights(2 * half + 1, bits, most))
}

/// Registers are kept, results lie where they were asked for, and nothing saturates.
fn keeps_to_registers_and_range(device: &Device, kernel: Kernel, keep: usize, into: u8, high: i32) {
    let kernels = [kernel];
    let mut request = Request::new(&kernels, device).unwrap();
    request.into = vec![Analog(into)];
    request.keep = (0..keep).map(|i| Analog(5 - i as u8)).collect();
    request.effort = Effort::states(2000);
    request.range = Some((0.0, f64::from(high)));
    let filter = match request.filter() {
        // Of an input of few LSB a dense kernel may leave nothing.
        Err(CompileError::Nothing { .. }) => {
            request.objective = Objective::Words;
            request.filter().unwrap()
        }
        other => other.unwrap(),
    };
    let text = filter.text(device, 0);
    let program = Program::parse("filter", &text).unwrap();
    let code = program.expand(device, &Overrides::default()).unwrap().code;
    let settings = Settings::from_device(device);
    let inputs = range::Inputs {
        registers: range::Interval::new(0.0, f64::from(high)),
        ..range::Inputs::from_device(device)
    };
    let ranges = range::of(&code.frame, device, settings, inputs).unwrap();
    assert_eq!(ranges.saturations, vec![]);
    for register in &request.keep {
        let taps = taps::read(&code.frame, device, settings, *register).unwrap();
        assert_eq!(taps.taps.len(), 1);
    }
    let scale = 2f64.powi(filter.prescale as i32);
    let found = read_back(&filter, &request);
    assert_eq!(&found[0].mapv(|w| w * scale + 0.0), kernels[0].weights());
}

/// Here the chip's transfer errors alone would have kept a sum of -128.25 in range.
#[test]
fn errors_of_the_chip_are_no_help_against_saturation() {
    let weights = [[-3, -1, -2], [-3, 0, 0], [-3, -2, -4]];
    let rows = weights.map(|row| row.map(f64::from).to_vec());
    keeps_to_registers_and_range(&Device::scamp5(), kernel(&rows), 0, 0, 114);
}

/// What fits is what the chip's own registers hold.
#[test]
fn nothing_saturates_where_registers_hold_less() {
    let narrow = Device::scamp5().what_if(Figure::Highest, 31.0).unwrap();
    let narrow = narrow.what_if(Figure::Lowest, -32.0).unwrap();
    let rows = [
        vec![1.0, 2.0, 1.0],
        vec![2.0, 4.0, 2.0],
        vec![1.0, 2.0, 1.0],
    ];
    keeps_to_registers_and_range(&narrow, kernel(&rows), 0, 0, 31);
    let kernels = [kernel(&rows)];
    let mut request = Request::new(&kernels, &narrow).unwrap();
    request.range = Some((0.0, 100.0));
    let error = request.filter().unwrap_err().to_string();
    assert!(
        error.ends_with("does not fit into -32…31, halved or not"),
        "{error}"
    );
}

proptest! {
    // Each takes seconds.
    #![proptest_config(ProptestConfig::with_cases(5))]

    /// Too long to be read back as forms; the compiler checks each plan itself.
    #[test]
    fn large_kernels_compile(kernel in weights(11, 3, 20)) {
        let device = Device::scamp5();
        let kernels = [kernel];
        let mut request = Request::new(&kernels, &device).unwrap();
        request.effort = Effort::states(0);
        let filter = request.filter().unwrap();
        prop_assert!(filter.words.len() as u64 <= naive_cost(&kernels).unwrap());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn any_kernel_compiles(kernel in kernels(), states in 0u64..3000) {
        compiled(&[kernel], states);
    }

    #[test]
    fn several_kernels_compile(list in proptest::collection::vec(weights(3, 1, 3), 2..5), states in 0u64..3000) {
        compiled(&list, states);
    }

    #[test]
    fn several_kernels_compile_into_any_registers(
        list in proptest::collection::vec(weights(3, 1, 1), 2..4),
        has_input: bool,
        into in Just(vec![0u8, 1, 2, 3]).prop_shuffle(),
        states in 0u64..3000,
    ) {
        let mut list = list;
        if has_input {
            list.push(outer(&[1.0], &[1.0], 1.0));
        }
        compiled_into(&list, &into[..list.len()], states);
    }

    #[test]
    fn within_registers_and_range(kernel in weights(3, 0, 4), keep in 0usize..3, into in 0u8..4, high in 1i32..128) {
        keeps_to_registers_and_range(&Device::scamp5(), kernel, keep, into, high);
    }

    /// Packets of the array and of the float model, up to the border.
    #[test]
    fn a_compiled_sensor_is_the_reference(kernel in weights(5, 2, 2), threshold in 1u32..200, seed: u64) {
        let device = Device::scamp5();
        let kernels = [kernel.clone()];
        let mut request = Request::new(&kernels, &device).unwrap();
        request.effort = Effort::states(3000);
        request.objective = Objective::Exact;
        let light = f64::from(threshold) / 4.0;
        let kinds = [CellKind { name: None, kernel: kernel.clone(), on: light, off: light }];
        let sensor = SensorProgram::new(&kinds, DriveMemory::Analogue, "random", &request).unwrap();
        prop_assert!(sensor.filter.border);
        let program = Program::parse("sensor", &sensor.text).unwrap();
        let code = program.expand(&device, &Overrides::default()).unwrap().code;
        let clip = clip(seed);
        let size = Size::of(&clip[0]);
        let settings = Settings { clip: true, ..Settings::from_device(&device) };
        let mut chip = Chip::new("chip", Exact, &code, &device, size, settings).unwrap();
        let rows: Vec<Vec<f64>> = kernel.weights().rows().into_iter().map(|row| row.to_vec()).collect();
        let text = format!(
            "response = \"identity\"\nmemory = \"filtered-snap\"\nborder = \"zero\"\n[[channel]]\n\
             kernel = {rows:?}\nthreshold = {{ on = {light:?}, off = {light:?} }}\n"
        );
        let description = Description::parse("sensor", &text, &|_| unreachable!()).unwrap();
        let mut reference = Reference::new(description, size, 0).unwrap();
        let [a, b] = [watch(&mut chip, &clip), watch(&mut reference, &clip)];
        prop_assert_eq!(a, b, "{}", sensor.text);
    }
}

/// A program of several kinds with one memory of the pixel, and the float model of it.
fn shared(kinds: &[CellKind], states: u64, objective: Objective) -> (SensorProgram, Description) {
    let device = Device::scamp5();
    let kernels = [kinds[0].kernel.clone()];
    let mut request = Request::new(&kernels, &device).unwrap();
    request.effort = Effort::states(states);
    request.objective = objective;
    let sensor = SensorProgram::new(kinds, DriveMemory::Shared, "shared", &request).unwrap();
    assert!(sensor.filters.iter().all(|filter| filter.border));
    let mut text =
        "response = \"identity\"\nmemory = \"raw-snap\"\nshared = true\nborder = \"zero\"\n"
            .to_owned();
    for CellKind {
        kernel, on, off, ..
    } in kinds
    {
        let rows: Vec<Vec<f64>> = { kernel.weights().rows().into_iter() }
            .map(|row| row.to_vec())
            .collect();
        let _ = write!(
            text,
            "[[channel]]\nkernel = {rows:?}\nthreshold = {{ on = {on:?}, off = {off:?} }}\n"
        );
    }
    let description = Description::parse("sensor", &text, &|_| unreachable!()).unwrap();
    (sensor, description)
}

/// The packet of a program, of registers of the chip's range.
fn run_on(sensor: &SensorProgram, arithmetic: Arithmetic, clip: &[Plane<f64>]) -> Packet {
    let device = Device::scamp5();
    let program = Program::parse("shared", &sensor.text).unwrap();
    let code = program.expand(&device, &Overrides::default()).unwrap().code;
    let size = Size::of(&clip[0]);
    let settings = Settings {
        clip: matches!(arithmetic, Arithmetic::Number(_)),
        ..Settings::from_device(&device)
    };
    let chip = arithmetic.chip("chip", &code, &device, size, settings);
    watch(&mut *chip.unwrap(), clip)
}

fn words(sensor: &SensorProgram) -> u64 {
    let device = Device::scamp5();
    let program = Program::parse("shared", &sensor.text).unwrap();
    let code = program.expand(&device, &Overrides::default()).unwrap().code;
    Cost::of(&code.frame, &device).words.0
}

/// A program that no light saturates and the float model: their packets are the same, event by
/// event. Returns the program's words a frame, and the number of events.
fn shared_is_the_reference(kinds: &[CellKind], states: u64, seed: u64) -> (u64, usize) {
    let (sensor, description) = shared(kinds, states, Objective::Exact);
    let clip = clip(seed);
    let mut reference = Reference::new(description, Size::of(&clip[0]), 0).unwrap();
    let a = run_on(&sensor, Arithmetic::Number(Format::F64), &clip);
    let b = watch(&mut reference, &clip);
    assert_eq!(a, b, "{}", sensor.text);
    (words(&sensor), a.events.len())
}

/// F1 of each kind's events against another packet's, of pixels so far from the border.
fn f1(packets: &[(Packet, Packet)], kind: u8, from: u16) -> f64 {
    let inner = from..leaves::SIDE as u16 - from;
    let events = |packet: &Packet| -> Vec<_> {
        let own = packet.events.iter().filter(|event| {
            event.channel == kind && inner.contains(&event.x) && inner.contains(&event.y)
        });
        own.copied().collect()
    };
    let (mut both, mut all) = (0, 0);
    for (one, other) in packets {
        let (one, other) = (events(one), events(other));
        both += one.iter().filter(|event| other.contains(event)).count();
        all += one.len() + other.len();
    }
    2.0 * both as f64 / all as f64
}

/// The plan that decides best on the chip: what is predicted of it is what a program does, it keeps
/// more than one that nothing saturates, and where nothing saturates it is exact.
#[test]
fn four_kinds_survive_the_silicon() {
    let kinds = four_kinds("ternary");
    let exact = Arithmetic::Number(Format::F64);
    let silicon = |seed| Arithmetic::Silicon { seed };
    let clip = |pair: usize, light: f64| leaves::pair(pair).map(|plane| plane * light).to_vec();
    let [(chosen, description), (strict, _)] =
        [Objective::Silicon, Objective::Exact].map(|aim| shared(&kinds, 20_000, aim));
    let reference = |clip: &[Plane<f64>]| {
        let mut reference = Reference::new(description.clone(), Size::of(&clip[0]), 0).unwrap();
        watch(&mut reference, clip)
    };
    let ran = |sensor: &SensorProgram, arithmetic: &dyn Fn(u64) -> Arithmetic| -> Vec<_> {
        (0..leaves::MOVES.len())
            .map(|pair| {
                let clip = clip(pair, 254.0);
                (
                    run_on(sensor, arithmetic(pair as u64), &clip),
                    reference(&clip),
                )
            })
            .collect()
    };
    let with_errors = ran(&chosen, &silicon);
    let without = ran(&chosen, &|_| exact);
    let strict_with = ran(&strict, &silicon);
    println!(
        "{} words, {} that nothing saturates",
        words(&chosen),
        words(&strict)
    );
    for (kind, filter) in (0..).zip(&chosen.filters) {
        let said = filter.decided.unwrap();
        let [chip, float, before] = [&with_errors, &without, &strict_with].map(|p| f1(p, kind, 4));
        let whole = f1(&with_errors, kind, 0);
        println!(
            "{said:?}: {chip:.3}, {whole:.3} with the border, exact {float:.3}; halved for all light {before:.3}"
        );
        // What lies off the array has none of the chip's constants, and the border does not fire.
        assert!(whole > chip - 0.03);
        assert!((chip - said.silicon).abs() < 0.04 && (float - said.exact).abs() < 0.04);
        assert!(chip > 0.85 && chip > before + 0.05);
    }
    // The changes that each kernel answers most, as large as it is exact for.
    let most = chosen.filter.exact_within / Device::scamp5().value(Figure::LightScale);
    let mut after = Plane::from_elem((40, 40), 127.0);
    for (i, kind) in kinds.iter().enumerate() {
        for ((y, x), weight) in kind.kernel.weights().indexed_iter() {
            if *weight != 0.0 {
                after[(3 + 9 * i + y, 17 + x)] += weight.signum() * most;
            }
        }
    }
    let small = [Plane::from_elem((40, 40), 127.0), after];
    let events = run_on(&chosen, exact, &small);
    assert_eq!(events, reference(&small));
    println!("{} events of changes up to {most:.1}", events.events.len());
    assert!(!events.events.is_empty());
}

/// The default keeps clearly more on the chip than what no light saturates, and without the chip's
/// errors hardly less: on a real clip, of kernels whose weights sum to zero and of one whose do not.
#[test]
fn one_kind_survives_the_silicon() {
    let device = Device::scamp5();
    let weights = Kernel::builtin("rgc-5x5").unwrap();
    let mut scene = bundled().unwrap();
    let mut frames = Vec::new();
    while let Some(frame) = scene.next_frame().unwrap()
        && frames.len() < 10
    {
        frames.push(
            frame
                .light
                .slice(ndarray::s![100..140, 100..140])
                .to_owned(),
        );
    }
    for (to, sum) in [("ternary", Sum::Kept), ("binary", Sum::Free)] {
        let to: Quantiser = to.parse().unwrap();
        let quantised = to.quantise(&weights, sum, 0).unwrap().within_one();
        let threshold = 48.0 / quantised.scale;
        let kinds = [CellKind {
            name: None,
            kernel: quantised.levels.clone(),
            on: threshold,
            off: threshold,
        }];
        let kernels = [quantised.levels];
        let [chosen, strict] = [Objective::Silicon, Objective::Exact].map(|objective| {
            let mut request = Request::new(&kernels, &device).unwrap();
            request.effort = Effort::states(100_000);
            request.objective = objective;
            SensorProgram::new(&kinds, DriveMemory::Analogue, "one", &request).unwrap()
        });
        assert!(strict.filter.holds && strict.filter.decided.is_none());
        let rows: Vec<Vec<f64>> = { kernels[0].weights().rows().into_iter() }
            .map(|row| row.to_vec())
            .collect();
        let text = format!(
            "response = \"identity\"\nmemory = \"filtered-snap\"\nborder = \"zero\"\n[[channel]]\n\
             kernel = {rows:?}\nthreshold = {{ on = {threshold:?}, off = {threshold:?} }}\n"
        );
        let float = Description::parse("float", &text, &|_| unreachable!()).unwrap();
        let mut reference = Reference::new(float, Size::of(&frames[0]), 0).unwrap();
        let reference = watch(&mut reference, &frames);
        let kept = |sensor: &SensorProgram, arithmetic| {
            f1(
                &[(run_on(sensor, arithmetic, &frames), reference.clone())],
                0,
                4,
            )
        };
        let exact = Arithmetic::Number(Format::F64);
        let silicon = Arithmetic::Silicon { seed: 7 };
        let [here, there] = [&chosen, &strict].map(|sensor| kept(sensor, silicon));
        let [exact, all] = [&chosen, &strict].map(|sensor| kept(sensor, exact));
        let said = chosen.filter.decided.unwrap();
        println!(
            "{to}: {here:.3} for {there:.3} on the chip, {exact:.3} for {all:.3} without errors; {said:?}"
        );
        assert!(all == 1.0 && exact > 0.98, "{to}");
        assert!(here > there + 0.1, "{to}");
    }
}

/// The kernels of the shipped sensor of four kinds, in few values.
fn four_kinds(to: &str) -> Vec<CellKind> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("sensors/rgc-4-on-chip.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let sensor = Description::parse("rgc-4", &text, &|_| unreachable!()).unwrap();
    assert!(sensor.shared);
    let to: Quantiser = to.parse().unwrap();
    let kind = |channel: &amacrine::reference::Channel| {
        let quantised = to
            .quantise(&channel.kernels[0], Sum::Free, 0)
            .unwrap()
            .within_one();
        let light = 255.0 / quantised.scale;
        CellKind {
            name: None,
            kernel: quantised.levels,
            on: channel.thresholds[0].on * light,
            off: channel.thresholds[0].off * light,
        }
    };
    sensor.channels.iter().map(kind).collect()
}

/// Four learned 5x5 kernels on six registers and 1024 words.
#[test]
fn four_kinds_fit_on_scamp5() {
    for (to, most) in [("ternary", 480), ("int-5", 1019)] {
        let (words, events) = shared_is_the_reference(&four_kinds(to), 20_000, 7);
        println!("{to}: {words} words a frame, {events} events");
        assert!(
            words <= most && events > 100,
            "{to}: {words} words, {events} events"
        );
    }
}

/// A search that nobody waits for ends, and what it found so far is not kept for the next.
#[test]
fn a_search_can_be_given_up() {
    static FLAG: AtomicBool = AtomicBool::new(true);
    let device = Device::scamp5();
    let kernels = [Kernel::builtin("sobel-x").unwrap()];
    let mut request = Request::new(&kernels, &device).unwrap();
    // A seed that no other test has.
    request.seed = 0x57_0f;
    let with = |states| Effort {
        stop: Stop::when(&FLAG),
        ..Effort::states(states)
    };
    request.effort = with(u64::MAX);
    let given_up = request.filter().unwrap_err();
    assert!(matches!(given_up, CompileError::GivenUp), "{given_up}");
    FLAG.store(false, Ordering::Relaxed);
    request.effort = with(2000);
    let filter = request.filter().unwrap();
    request.effort = Effort::states(2000);
    assert_eq!(filter.words, request.filter().unwrap().words);
}

/// Kinds take turns in the registers that are scanned: each is read before the next is there.
#[test]
fn every_event_of_several_kinds_is_read() {
    let device = Device::scamp5();
    let kernels = [
        outer(&[1.0, 2.0, 1.0], &[-1.0, 0.0, 1.0], 0.25),
        outer(&[-1.0, 0.0, 1.0], &[1.0, 2.0, 1.0], 0.25),
    ];
    let [one, other] = kernels.each_ref().map(|kernel| Design {
        kernel,
        threshold: 40.0,
        device: &device,
        effort: Effort::states(1000),
        seed: 0,
    });
    let clip = clip(3);
    for memory in [DriveMemory::Analogue, DriveMemory::Shared] {
        let compiled = one.compile_with(&[other], memory, "two").unwrap();
        let chip = || {
            let exact = Arithmetic::Number(Format::F64);
            let chip = compiled.chip(exact, Size::of(&clip[0]), compiled.settings());
            chip.unwrap()
        };
        let scanned = delivered(&mut *chip(), &clip);
        let all = delivered(&mut compiled.all_events(chip()), &clip);
        assert_eq!(all, scanned, "in this order, too");
        for kind in 0..2 {
            assert!(all.events.iter().any(|event| event.channel == kind));
        }
    }
}

/// More kinds than one-bit registers wait for: the readout comes five at a time, and the light is
/// held; one of them has a filter without a word.
#[test]
fn seven_kinds_are_read_five_at_a_time() {
    let kernels = [
        outer(&[1.0], &[1.0], 1.0),
        outer(&[1.0, 2.0, 1.0], &[-1.0, 0.0, 1.0], 0.25),
        outer(&[-1.0, 0.0, 1.0], &[1.0, 2.0, 1.0], 0.25),
        outer(&[1.0, 1.0, 1.0], &[0.0, 1.0, 0.0], 0.25),
        outer(&[1.0], &[0.5], 1.0),
        outer(&[1.0, -2.0, 1.0], &[1.0, -2.0, 1.0], 0.125),
        outer(&[1.0], &[-0.5, 0.0, 0.5], 1.0),
    ];
    for count in [1, 2, 3, 5, 7] {
        let kinds: Vec<CellKind> = { kernels[..count].iter().enumerate() }
            .map(|(i, kernel)| CellKind {
                name: None,
                kernel: kernel.clone(),
                on: 40.0 + i as f64,
                off: 40.0,
            })
            .collect();
        let (_, events) = shared_is_the_reference(&kinds, 500, count as u64);
        assert!(events > 50, "{count} kinds: {events} events");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Any kinds, any thresholds, one memory.
    #[test]
    fn a_shared_memory_is_the_reference(
        kernels in proptest::collection::vec(weights(5, 2, 2), 1..5),
        thresholds in proptest::collection::vec((1u32..200, 1u32..200), 4),
        equal: bool,
        seed: u64,
    ) {
        let kind = |(kernel, (on, off)): (&Kernel, &(u32, u32))| CellKind {
            name: None,
            kernel: kernel.clone(),
            on: f64::from(*on) / 4.0,
            off: f64::from(if equal { *on } else { *off }) / 4.0,
        };
        let kinds: Vec<CellKind> = kernels.iter().zip(&thresholds).map(kind).collect();
        shared_is_the_reference(&kinds, 1000, seed);
    }
}

/// A memory in bits, pixel by pixel: the range in equal steps, each its middle.
fn in_bits(
    drives: &[Plane<f64>],
    steps: &BitMemory,
    threshold: f64,
) -> Vec<(u64, usize, usize, bool)> {
    let most = 2f64.powi(steps.registers.len() as i32) - 1.0;
    let middle = |drive: f64| {
        let code = ((drive - steps.low) / steps.step).ceil() - 1.0;
        steps.low + steps.step * (code.clamp(0.0, most) + 0.5)
    };
    let mut memory = drives[0].mapv(middle);
    let mut events = Vec::new();
    for (t, drive) in drives.iter().enumerate().skip(1) {
        for ((y, x), memory) in memory.indexed_iter_mut() {
            let change = drive[(y, x)] - *memory;
            if change.abs() > threshold {
                events.push((t as u64, x, y, change > 0.0));
                *memory = middle(drive[(y, x)]);
            }
        }
    }
    events
}

#[test]
fn a_memory_in_bits_is_its_twin() {
    let device = Device::scamp5();
    let weights = outer(&[1.0, 2.0, 1.0], &[-1.0, 0.0, 1.0], 0.25);
    let clip = clip(3);
    for (count, bits) in [(1, 3), (1, 4), (1, 8), (2, 4), (3, 2)] {
        // As low as the levels allow.
        let least = 14f64.max(256.0 / 2f64.powi(i32::from(bits)));
        let kinds: Vec<CellKind> = (0..count)
            .map(|i| CellKind {
                name: None,
                kernel: if i == 1 {
                    outer(&[1.0], &[0.5], 1.0)
                } else {
                    weights.clone()
                },
                on: least + f64::from(i),
                off: least + f64::from(i),
            })
            .collect();
        let kernels: Vec<Kernel> = kinds.iter().map(|kind| kind.kernel.clone()).collect();
        let mut request = Request::new(&kernels, &device).unwrap();
        request.effort = Effort::states(2000);
        let sensor = SensorProgram::new(&kinds, DriveMemory::Bits(bits), "bits", &request).unwrap();
        assert!(sensor.filter.border);
        let program = Program::parse("bits", &sensor.text).unwrap();
        let code = program.expand(&device, &Overrides::default()).unwrap().code;
        let size = Size::of(&clip[0]);
        let settings = Settings {
            clip: true,
            ..Settings::from_device(&device)
        };
        let mut chip = Chip::new("bits", Exact, &code, &device, size, settings).unwrap();
        let mut found = watch(&mut chip, &clip);
        found.events.sort_by_key(|e| (e.channel, e.t, e.y, e.x));
        for (i, (kind, steps)) in kinds.iter().zip(&sensor.steps).enumerate() {
            assert_eq!(steps.registers.len(), usize::from(bits));
            let drives: Vec<Plane<f64>> = clip
                .iter()
                .map(|light| zero_padded(kind.kernel.weights(), light).mapv(|d| d * sensor.scale()))
                .collect();
            let said = in_bits(&drives, steps, kind.on * sensor.scale());
            let own = found.events.iter().filter(|e| usize::from(e.channel) == i);
            let own: Vec<_> = own
                .map(|e| {
                    (
                        (e.t.0 as f64 * 240.0 / 1e6).round() as u64,
                        usize::from(e.x),
                        usize::from(e.y),
                        e.polarity == Polarity::On,
                    )
                })
                .collect();
            assert!(said.len() > 20, "{} events", said.len());
            assert_eq!(own, said, "{count} kinds, {bits} bits\n{}", sensor.text);
        }
    }
}

fn zero_padded(kernel: &Plane<f64>, light: &Plane<f64>) -> Plane<f64> {
    let (rows, columns) = kernel.dim();
    Plane::from_shape_fn(light.dim(), |(y, x)| {
        let tap = |((ky, kx), weight): ((usize, usize), &f64)| {
            let at = (
                (y + ky).checked_sub(rows / 2),
                (x + kx).checked_sub(columns / 2),
            );
            let (Some(y), Some(x)) = at else { return 0.0 };
            light.get((y, x)).map_or(0.0, |light| light * weight)
        };
        kernel.indexed_iter().map(tap).sum()
    })
}

/// Light in whole levels, some of it changing from frame to frame.
fn clip(seed: u64) -> Vec<Plane<f64>> {
    let mut state = seed;
    let mut next = move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        state >> 33
    };
    let mut light = Plane::from_shape_fn((9, 12), |_| (next() % 255) as f64);
    let mut clip = vec![light.clone()];
    for _ in 0..3 {
        light.mapv_inplace(|v| {
            if next() % 3 == 0 {
                (next() % 255) as f64
            } else {
                v
            }
        });
        clip.push(light.clone());
    }
    clip
}

fn watch(sensor: &mut dyn Sensor, clip: &[Plane<f64>]) -> Packet {
    let mut packet = delivered(sensor, clip);
    packet.events = packet.canonical();
    packet
}

/// Events in the order in which they come.
fn delivered(sensor: &mut dyn Sensor, clip: &[Plane<f64>]) -> Packet {
    let mut packet = Packet::new(sensor.size(), sensor.channels());
    for (index, light) in clip.iter().enumerate() {
        let frame = Frame {
            index: index as u64,
            seconds: index as f64 / 240.0,
            light: light.clone().into(),
        };
        sensor.watch(&frame, &mut packet).unwrap();
    }
    packet
}
