//! Proves that the range of a program contains every run of the exact chip, is reached where
//! the program is linear, and says where a store can leave the scale.

mod straight;

use amacrine::{
    array::{
        Input, Settings,
        range::{self, Inputs, Interval},
        taps,
    },
    isa::{Analog, Primitive},
    plane::Plane,
    program::{Action, Overrides, Program},
};
use proptest::prelude::*;
use straight::{MIDDLE, SIZE, device, noise, ran, sources, steps};

fn anything() -> impl Strategy<Value = Action> {
    prop_oneof![
        8 => straight::bus(&[1, 1, 2, 3]),
        1 => straight::load(),
        1 => Just(Action::Word(Primitive::ResetPix)),
        1 => sources().prop_map(|sources| Action::Word(Primitive::Square { sources })),
        2 => sources().prop_map(|sources| Action::Word(Primitive::Where { sources })),
        1 => Just(Action::Word(Primitive::All)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn every_run_stays_within(
        actions in prop::collection::vec(anything(), 1..8), clip: bool, seed: u64,
        (dark, span) in (0i64..200, 0i64..56),
    ) {
        let steps = steps(actions);
        let settings = Settings { clip, square_gain: 1.0 / 128.0, ..Settings::from_device(device()) };
        let inputs = Inputs {
            light: Interval::new(dark as f64, (dark + span) as f64),
            registers: Interval::new(-20.0, 30.0),
        };
        let ranges = range::of(&steps, device(), settings, inputs).unwrap();
        for seed in (0..8).map(|k| seed ^ k << 50) {
            let light = noise(seed, dark, dark + span);
            let registers: Vec<_> = (1..8).map(|k| noise(seed ^ k << 40, -20, 30)).collect();
            for (r, value) in ran(&steps, settings, &light, &registers).into_iter().enumerate() {
                let range = ranges.registers[r];
                prop_assert!(range.contains(value), "register {}: {} in {:?}", r, value, range);
            }
        }
    }

    #[test]
    fn both_ends_of_a_linear_program_are_reached(
        actions in prop::collection::vec(
            prop_oneof![8 => straight::bus(&[1, 2]), 1 => straight::load()], 1..8
        ),
        which in 0u8..7,
    ) {
        let steps = steps(actions);
        let settings = Settings::from_device(device());
        let inputs = Inputs::from_device(device());
        let ranges = range::of(&steps, device(), settings, inputs).unwrap();
        let taps = taps::read(&steps, device(), settings, Analog(which)).unwrap();
        for high in [false, true] {
            let mut light = Plane::from_elem(SIZE.shape(), 0.0);
            let mut registers = vec![light.clone(); 7];
            for ((input, dy, dx), weight) in &taps.taps {
                let at = (MIDDLE.0.wrapping_add_signed(*dy), MIDDLE.1.wrapping_add_signed(*dx));
                let (plane, interval) = match input {
                    Input::Light => (&mut light, inputs.light),
                    Input::Register(Analog(r)) => (&mut registers[usize::from(*r)], inputs.registers),
                };
                let up = (weight.to_f64() > 0.0) == high;
                plane[at] = if up { interval.high } else { interval.low };
            }
            let value = ran(&steps, settings, &light, &registers)[usize::from(which)];
            let range = ranges.registers[usize::from(which)];
            prop_assert_eq!(value, if high { range.high } else { range.low });
        }
    }
}

#[test]
fn a_sum_that_can_leave_the_scale_is_named() {
    let text = "get_image(A);\nmov(B, A);\nadd(B, B, A);\nsub(C, B, A);\nsub(D, B, B);";
    let program = Program::parse("test", text).unwrap();
    let code = program
        .expand(device(), &Overrides::default())
        .unwrap()
        .code;
    let settings = Settings::from_device(device());
    let range = |light| {
        let inputs = Inputs {
            light: Interval::new(0.0, light),
            ..Inputs::from_device(device())
        };
        range::of(&code.frame, device(), settings, inputs).unwrap()
    };
    let bright = range(254.0);
    assert_eq!(bright.registers[0], Interval::new(0.0, 127.0));
    assert_eq!(bright.registers[1], Interval::new(0.0, 254.0));
    // Correlations are kept: twice it less once it, and it less itself.
    assert_eq!(bright.registers[2], Interval::new(0.0, 127.0));
    assert_eq!(bright.registers[3], Interval::new(0.0, 0.0));
    let lines: Vec<_> = bright
        .saturations
        .iter()
        .map(|s| (s.line, s.register))
        .collect();
    assert!(lines.contains(&(3, Analog(1))), "{lines:?}");
    assert!(lines.iter().all(|(line, _)| *line >= 3), "{lines:?}");
    assert_eq!(range(100.0).saturations, []);
}

/// Whether a store happens that depends on a neighbour is open, however short the way.
#[test]
fn a_decision_by_a_neighbour_is_open() {
    let program = Program::parse("test", "scamp5_in(A, 1);\nwhere(XE, A);\nbus(B);").unwrap();
    let code = program
        .expand(device(), &Overrides::default())
        .unwrap()
        .code;
    let settings = Settings::from_device(device());
    let ranges = range::of(
        &code.frame,
        device(),
        settings,
        Inputs::from_device(device()),
    )
    .unwrap();
    let held = ranges.registers[1];
    assert!(held.contains(0.0) && held.contains(-12.0), "{held:?}");
}
