//! Proves that the silicon domain errs as the chip does: against the only public measurement
//! of it (B. Guillard, "CNNs on FPSPs", noise accumulation, MIT: the identity
//! `diva(A,E,F); mov(F,A); add(A,A,F)` repeated on uniform planes), and by what each macro is
//! known to cancel.

use amacrine::{
    array::{Array, Chip, Layout, Settings, Silicon},
    event::Packet,
    isa::{Analog, Bit, Device, Digital, Errors, Figure, Primitive, Source, Target},
    plane::{Plane, Size},
    program::{Action, Code, Host, Step},
    unit::Micros,
};

const A: Analog = Analog(0);
const E: Analog = Analog(4);
const F: Analog = Analog(5);
const T: Analog = Analog(6);

const SIZE: Size = Size::new(96, 96);

/// Read once; its files are the same for all.
fn device() -> &'static Device {
    static DEVICE: std::sync::LazyLock<Device> = std::sync::LazyLock::new(Device::scamp5);
    &DEVICE
}

fn bus(targets: &[Analog], sources: &[Source]) -> Primitive {
    Primitive::Bus {
        targets: targets.iter().map(|r| Target::Register(*r)).collect(),
        sources: sources.to_vec(),
    }
}

fn r(register: Analog) -> Source {
    Source::Register(register)
}

fn diva(y0: Analog, y1: Analog, y2: Analog) -> Vec<Primitive> {
    vec![
        bus(&[y1, y2], &[r(y0)]),
        bus(&[T], &[r(y1), r(y0)]),
        bus(&[y0], &[r(T), r(y2)]),
        bus(&[y1, y2], &[r(y0)]),
        bus(&[y0], &[r(y1)]),
    ]
}

fn mov(y: Analog, x: Analog) -> Vec<Primitive> {
    vec![bus(&[T], &[r(x)]), bus(&[y], &[r(T)])]
}

fn identity() -> Vec<Primitive> {
    let mut words = diva(A, E, F);
    words.extend(mov(F, A));
    words.extend([bus(&[T], &[r(A), r(F)]), bus(&[A], &[r(T)])]);
    words
}

fn errors() -> Errors {
    Errors::from_device(device())
}

fn chip(errors: Errors, seed: u64, program: &[Primitive], input: f64) -> Chip<Silicon> {
    let device = device();
    let layout = Layout::new(device, SIZE);
    let word = |word: &Primitive| Step {
        action: Action::Word(word.clone()),
        line: 1,
        origin: None,
    };
    let code = Code {
        init: vec![Step {
            action: Action::Host(Host::LoadIn { value: input }),
            line: 1,
            origin: None,
        }],
        frame: program.iter().map(word).collect(),
    };
    let domain = Silicon::new(errors, seed, &layout);
    let settings = Settings::from_device(device);
    let mut chip = Chip::new("test", domain, &code, device, SIZE, settings).unwrap();
    chip.run_init(Micros(0), &mut Packet::new(SIZE, 1)).unwrap();
    chip
}

fn run(chip: &mut Chip<Silicon>) {
    chip.run_frame(Micros(0), &mut Packet::new(SIZE, 1))
        .unwrap();
}

/// Mean, and spread over the pixels.
fn moments(plane: &Plane<f64>) -> (f64, f64) {
    (plane.mean().unwrap(), plane.std(0.0))
}

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}

#[test]
fn the_identity_loop_drifts_and_spreads_as_on_the_chip() {
    // (input, [(n, bias)], [(n, spread)]) in LSB; n = 1 is left out, its analysis wrapped.
    #[rustfmt::skip]
    let measured: [(f64, [f64; 5], [f64; 4]); 4] = [
        (0.0, [6.19, 12.21, 22.54, 37.42, 54.98], [2.20, 4.79, 9.05, 18.14]),
        (10.0, [7.28, 14.59, 26.68, 44.00, 63.78], [2.01, 4.82, 8.71, 17.61]),
        (60.0, [13.65, 24.23, 43.17, 73.03, 105.49], [2.37, 4.70, 7.97, 14.82]),
        (120.0, [17.42, 33.29, 61.88, 100.09, 148.94], [3.49, 8.77, 8.42, 12.79]),
    ];
    for seed in [0, 1, 7] {
        let (mut biases, mut spreads) = (Vec::new(), Vec::new());
        for (input, bias, spread) in measured {
            let loops = repeated(seed, input);
            for (n, measured) in [2, 4, 8, 16, 32].iter().zip(bias) {
                biases.push(loops[n - 1].0 - measured);
            }
            for (n, measured) in [2, 8, 16, 32].iter().zip(spread) {
                spreads.push(loops[n - 1].1 - measured);
            }
        }
        assert!(rms(&biases) < 1.5, "{seed}: {} {biases:.2?}", rms(&biases));
        assert!(
            rms(&spreads) < 1.0,
            "{seed}: {} {spreads:.2?}",
            rms(&spreads)
        );
    }
}

/// The data has two more inputs, which nothing was fitted to.
#[test]
fn inputs_that_were_not_fitted_drift_as_on_the_chip() {
    let measured: [(f64, [f64; 5]); 2] = [
        (5.0, [6.99, 13.39, 24.62, 40.51, 59.51]),
        (100.0, [14.45, 28.13, 51.74, 89.44, 133.47]),
    ];
    for seed in [0, 1, 7] {
        let mut biases = Vec::new();
        for (input, bias) in measured {
            let loops = repeated(seed, input);
            for (n, measured) in [2, 4, 8, 16, 32].iter().zip(bias) {
                biases.push(loops[n - 1].0 - measured);
            }
        }
        assert!(rms(&biases) < 1.5, "{seed}: {} {biases:.2?}", rms(&biases));
    }
}

/// Bias and spread of the identity after 1 to 32 turns.
fn repeated(seed: u64, input: f64) -> Vec<(f64, f64)> {
    let mut chip = chip(errors(), seed, &identity(), 0.0);
    chip.set_analog(A, &Plane::from_elem(SIZE.shape(), input))
        .unwrap();
    let mut turn = || {
        run(&mut chip);
        let (mean, deviation) = moments(&chip.analog(A));
        (input - mean, deviation)
    };
    (0..32).map(|_| turn()).collect()
}

/// Between the inputs that were fitted: the map is one and affine, so that the
/// bias goes straight from input to input, and the spread without a bump.
#[test]
fn inputs_that_were_not_measured_lie_between_those_that_were() {
    let at = |input| repeated(7, input);
    let (low, high) = (at(0.0), at(120.0));
    let mut before = low.clone();
    for input in [5.0, 10.0, 30.0, 60.0, 80.0, 100.0] {
        let here = at(input);
        for n in [2, 4, 8, 16, 32] {
            let part = input / 120.0;
            let straight = low[n - 1].0 * (1.0 - part) + high[n - 1].0 * part;
            let (bias, spread) = here[n - 1];
            assert!(
                (bias - straight).abs() < 0.3,
                "{input}, {n}: {bias} {straight}"
            );
            let change = spread - before[n - 1].1;
            assert!(
                change.abs() < 3.0,
                "{input}, {n}: spread changes by {change}"
            );
        }
        before = here;
    }
}

#[test]
fn two_stores_cancel_what_one_adds() {
    let mut program = vec![bus(&[E], &[r(A)])];
    program.extend(mov(F, A));
    let mut chip = chip(errors(), 1, &program, 0.0);
    chip.set_analog(A, &Plane::from_elem(SIZE.shape(), 30.0))
        .unwrap();
    run(&mut chip);
    let (once, _) = moments(&chip.analog(E));
    let (twice, spread) = moments(&chip.analog(F));
    assert!((once - (-30.0 + 20.0)).abs() < 0.5, "{once}");
    assert!((twice - 30.0).abs() < 0.5, "{twice}");
    assert!(spread > 0.05 && spread < 0.5, "{spread}");
}

#[test]
fn adding_the_halves_again_corrects_an_uneven_split() {
    let errors = Errors {
        division_mismatch: 0.05,
        gain_mismatch: 0.0,
        offset_mismatch: 0.0,
        noise: 0.0,
        ..self::errors()
    };
    // divq(E, A) against diva(A, E, F).
    let once = {
        let mut chip = chip(errors, 3, &[bus(&[E, T], &[r(A)]), bus(&[E], &[r(T)])], 0.0);
        chip.set_analog(A, &Plane::from_elem(SIZE.shape(), 100.0))
            .unwrap();
        run(&mut chip);
        moments(&chip.analog(E)).1
    };
    let corrected = {
        let mut chip = chip(errors, 3, &diva(A, E, F), 0.0);
        chip.set_analog(A, &Plane::from_elem(SIZE.shape(), 100.0))
            .unwrap();
        run(&mut chip);
        moments(&chip.analog(A)).1
    };
    assert!((once - 2.5).abs() < 0.1, "5 % of 50: {once}");
    assert!(corrected < 0.5, "5 % of 5 % of 100: {corrected}");
}

/// Of a bus to two, three or four registers each gets what the others do, as far off in every place,
/// and all together get what there is.
#[test]
fn every_target_of_a_bus_is_as_uneven_and_all_get_what_there_is() {
    let errors = Errors {
        division_mismatch: 0.05,
        gain_mismatch: 0.0,
        offset_mismatch: 0.0,
        noise: 0.0,
        loss: 0.0,
        transfer: 0.0,
        division: 0.0,
        ..self::errors()
    };
    let all: Vec<Analog> = (1..=5).map(Analog).collect();
    for count in 2..=all.len() {
        let targets = &all[..count];
        let mut chip = chip(errors, 3, &[bus(targets, &[r(A)])], 0.0);
        chip.set_analog(A, &Plane::from_elem(SIZE.shape(), 100.0))
            .unwrap();
        run(&mut chip);
        let mut sum = Plane::zeros(SIZE.shape());
        for target in targets {
            let share = chip.analog(*target) / (-100.0 / count as f64);
            let (mean, spread) = moments(&share);
            assert!((mean - 1.0).abs() < 0.003, "{target:?} of {count}: {mean}");
            assert!(
                (spread - 0.05).abs() < 0.002,
                "{target:?} of {count}: {spread}"
            );
            sum = sum + share / count as f64;
        }
        let (mean, spread) = moments(&sum);
        assert!(
            (mean - 1.0).abs() < 1e-5 && spread < 1e-5,
            "all of {count}: {mean}, {spread}"
        );
    }
}

#[test]
fn a_loaded_value_arrives_and_saturates_like_any_other() {
    let load = [bus(&[T], &[Source::In]), bus(&[A], &[r(T)])];
    for value in [-100.0, 0.0, 5.0, 60.0, 120.0] {
        let mut chip = chip(errors(), 2, &load, value);
        run(&mut chip);
        let (mean, spread) = moments(&chip.analog(A));
        assert!((mean - value).abs() < 0.1, "{value} {mean}");
        assert!(spread < 1.6, "{spread}");
    }
    let mut chip = chip(errors(), 2, &[bus(&[T], &[r(A), r(E)])], 0.0);
    for register in [A, E] {
        chip.set_analog(register, &Plane::from_elem(SIZE.shape(), 120.0))
            .unwrap();
    }
    run(&mut chip);
    assert_eq!(moments(&chip.analog(T)), (-148.0, 0.0));
}

#[test]
fn a_seed_is_a_chip() {
    let of = |seed, frames| {
        let mut chip = chip(errors(), seed, &mov(E, A), 0.0);
        for _ in 0..frames {
            run(&mut chip);
        }
        chip.analog(E)
    };
    assert_eq!(of(1, 1), of(1, 1));
    assert_ne!(of(1, 1), of(2, 1));
    // The noise is new every time, the pattern stays.
    let apart = &of(1, 1) - &of(1, 2);
    assert!(
        moments(&apart).1 > 0.05 && moments(&apart).1 < 0.12,
        "{}",
        moments(&apart).1
    );
    assert!(moments(&of(1, 1)).1 > moments(&apart).1);
}

#[test]
fn a_raw_code_is_finer_than_the_host_s_table() {
    let load = [bus(&[T], &[Source::In]), bus(&[A], &[r(T)])];
    let mut chip = chip(errors(), 2, &load, 0.0);
    let mut mean = |host: Host| {
        let steps = [Step {
            action: Action::Host(host),
            line: 1,
            origin: None,
        }];
        chip.run_steps(&steps, Micros(0), &mut Packet::new(SIZE, 1))
            .unwrap();
        run(&mut chip);
        moments(&chip.analog(A)).0
    };
    let (half, whole) = (
        mean(Host::LoadDac { code: 2048 + 8 }),
        mean(Host::LoadDac { code: 2048 + 16 }),
    );
    assert!((whole - half - 0.5).abs() < 0.05, "{half} {whole}");
    let (half, whole) = (
        mean(Host::LoadInRaw { value: 1.5 }),
        mean(Host::LoadInRaw { value: 2.0 }),
    );
    assert!(
        (whole - half).abs() < 0.05,
        "halves to even: {half} {whole}"
    );
}

#[test]
fn registers_decay_towards_the_reset_level_and_no_further() {
    let errors = Errors {
        decay: 10.0,
        reset_level: -5.0,
        ..errors()
    };
    let mut chip = chip(errors, 1, &[], 0.0);
    for (register, value) in [(A, 20.0), (E, -12.0), (F, -60.0)] {
        chip.set_analog(register, &Plane::from_elem(SIZE.shape(), value))
            .unwrap();
    }
    let means = |chip: &Chip<Silicon>| [A, E, F].map(|r| moments(&chip.analog(r)).0);
    chip.wait(0.5);
    assert_eq!(means(&chip), [15.0, -7.0, -55.0]);
    chip.wait(3.0);
    assert_eq!(means(&chip), [-5.0, -5.0, -25.0]);
    // Not known of the real chip, so not by default.
    let mut still = self::chip(self::errors(), 1, &[], 0.0);
    still
        .set_analog(A, &Plane::from_elem(SIZE.shape(), 20.0))
        .unwrap();
    still.wait(100.0);
    assert_eq!(moments(&still.analog(A)).0, 20.0);
}

/// Part of the pixels whose bit is left.
fn left(chip: &Chip<Silicon>, register: u8) -> f64 {
    let bits = chip.digital(Digital(register));
    bits.iter().filter(|b| **b).count() as f64 / bits.len() as f64
}

#[test]
fn bits_hold_for_a_second_and_a_half_and_then_fade_unless_they_are_refreshed() {
    let refresh = Primitive::Or {
        target: Digital(5),
        sources: vec![Bit::Register(Digital(5))],
    };
    let mut chip = chip(errors(), 4, &[refresh], 0.0);
    for register in [5, 6] {
        chip.set_digital(Digital(register), &Plane::from_elem(SIZE.shape(), true))
            .unwrap();
    }
    let mut kept = 1.0;
    for half_seconds in 1..=8 {
        chip.wait(0.5);
        run(&mut chip);
        assert_eq!(left(&chip, 5), 1.0, "refreshed in every frame");
        let now = left(&chip, 6);
        match half_seconds {
            ..=3 => assert_eq!(now, 1.0, "within the quoted time"),
            _ => assert!(now < kept, "{half_seconds}: {now}"),
        }
        kept = now;
    }
    // 4 s are 1.5 (1 + 0.5 |normal|) for |normal| = 3.3.
    assert!(kept < 0.01, "{kept}");
    let again = |seed| {
        let mut chip = self::chip(errors(), seed, &[], 0.0);
        chip.set_digital(Digital(6), &Plane::from_elem(SIZE.shape(), true))
            .unwrap();
        chip.wait(2.0);
        chip.digital(Digital(6))
    };
    assert_eq!(again(4), again(4));
    assert_ne!(again(4), again(5));
}

#[test]
fn a_chip_with_other_numbers_errs_otherwise() {
    let perfect = [
        Figure::StoreLoss,
        Figure::DivisionError,
        Figure::GainMismatch,
        Figure::OffsetMismatch,
        Figure::DivisionMismatch,
        Figure::StoreNoise,
    ];
    let device = perfect
        .into_iter()
        .fold(device().clone(), |device, figure| {
            device.what_if(figure, 0.0).unwrap()
        });
    let mut chip = chip(Errors::from_device(&device), 1, &identity(), 0.0);
    chip.set_analog(A, &Plane::from_elem(SIZE.shape(), 60.0))
        .unwrap();
    run(&mut chip);
    let (mean, spread) = moments(&chip.analog(A));
    assert!(
        (mean - 60.0).abs() < 1e-4 && spread < 1e-4,
        "{mean} {spread}"
    );
    for (figure, value) in [
        (Figure::StoreLoss, 1.0),
        (Figure::MismatchCorrelation, -1.5),
        (Figure::StoreNoise, f64::NAN),
        (Figure::Lowest, 200.0),
    ] {
        let error = device.clone().what_if(figure, value).unwrap_err();
        assert!(error.to_string().contains(figure.key().1), "{error}");
    }
}
