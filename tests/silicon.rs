//! Proves that the silicon domain errs as the chip does: against the only public measurement
//! of it (B. Guillard, "CNNs on FPSPs", noise accumulation, MIT: the identity
//! `diva(A,E,F); mov(F,A); add(A,A,F)` repeated on uniform planes), and by what each macro is
//! known to cancel.

use amacrine::{
    array::{Array, Chip, Errors, Layout, Settings, Silicon},
    event::Packet,
    isa::{Analog, Device, Primitive, Source, Target},
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

fn chip(errors: Errors, seed: u64, program: &[Primitive], input: f64) -> Chip<Silicon> {
    let device = device();
    let layout = Layout::of(device, SIZE);
    let word = |word: &Primitive| Step {
        action: Action::Word(word.clone()),
        line: 1,
    };
    let code = Code {
        init: vec![Step {
            action: Action::Host(Host::LoadIn { value: input }),
            line: 1,
        }],
        frame: program.iter().map(word).collect(),
    };
    let domain = Silicon::new(errors, seed, &layout);
    let settings = Settings::of(device);
    let mut chip = Chip::new("test", domain, code, device, SIZE, settings).unwrap();
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
    let (mut biases, mut spreads) = (Vec::new(), Vec::new());
    for (input, bias, spread) in measured {
        let mut chip = chip(Errors::default(), 7, &identity(), 0.0);
        chip.set_analog(A, &Plane::from_elem(SIZE.shape(), input))
            .unwrap();
        for n in 1..=32 {
            run(&mut chip);
            let (mean, deviation) = moments(&chip.analog(A));
            if let Some(i) = [2, 4, 8, 16, 32].iter().position(|m| *m == n) {
                biases.push(input - mean - bias[i]);
            }
            if let Some(i) = [2, 8, 16, 32].iter().position(|m| *m == n) {
                spreads.push(deviation - spread[i]);
            }
        }
    }
    assert!(rms(&biases) < 1.3, "{} {biases:.2?}", rms(&biases));
    assert!(rms(&spreads) < 0.95, "{} {spreads:.2?}", rms(&spreads));
}

#[test]
fn two_stores_cancel_what_one_adds() {
    let mut program = vec![bus(&[E], &[r(A)])];
    program.extend(mov(F, A));
    let mut chip = chip(Errors::default(), 1, &program, 0.0);
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
        ..Errors::default()
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

#[test]
fn a_loaded_value_arrives_and_saturates_like_any_other() {
    let load = [bus(&[T], &[Source::In]), bus(&[A], &[r(T)])];
    for value in [-100.0, 0.0, 5.0, 60.0, 120.0] {
        let mut chip = chip(Errors::default(), 2, &load, value);
        run(&mut chip);
        let (mean, spread) = moments(&chip.analog(A));
        assert!((mean - value).abs() < 0.1, "{value} {mean}");
        assert!(spread < 1.6, "{spread}");
    }
    let mut chip = chip(Errors::default(), 2, &[bus(&[T], &[r(A), r(E)])], 0.0);
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
        let mut chip = chip(Errors::default(), seed, &mov(E, A), 0.0);
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
