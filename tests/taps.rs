//! Proves that the kernel read back from a program is the kernel it computes: against the exact
//! chip on random programs and pictures, and against what the shipped programs say of
//! themselves.

mod straight;

use std::{fs, path::Path};

use amacrine::{
    array::{
        Input, Settings,
        taps::{self, Taps, TapsError, Why},
    },
    isa::{Analog, Primitive, Source, Target},
    number::Dyadic,
    plane::Plane,
    program::{Action, Overrides, Program},
};
use proptest::prelude::*;
use straight::{MIDDLE, device, noise, ran, steps};

fn applied(taps: &Taps, light: &Plane<f64>, registers: &[Plane<f64>]) -> f64 {
    let tap = |((input, dy, dx), weight): (&(Input, isize, isize), &Dyadic)| {
        let at = (
            MIDDLE.0.wrapping_add_signed(*dy),
            MIDDLE.1.wrapping_add_signed(*dx),
        );
        weight.to_f64()
            * match input {
                Input::Light => light[at],
                Input::Register(Analog(r)) => registers[usize::from(*r)][at],
            }
    };
    taps.constant.to_f64() + taps.taps.iter().map(tap).sum::<f64>()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn the_kernel_applied_is_the_program_run(
        actions in prop::collection::vec(
            prop_oneof![8 => straight::bus(&[1, 1, 2, 4]), 1 => straight::load(),
                1 => Just(Action::Word(Primitive::ResetPix))],
            1..8
        ),
        edge in prop::sample::select(vec![0.0, 50.0]),
        seed: u64,
    ) {
        let steps = steps(actions);
        let settings = Settings { edge, ..Settings::from_device(device()) };
        let light = noise(seed, 0, 255);
        let registers: Vec<_> = (1..8).map(|k| noise(seed ^ k << 40, -128, 127)).collect();
        let values = ran(&steps, settings, &light, &registers);
        for (r, value) in (0..).zip(values) {
            let taps = taps::read(&steps, device(), settings, Analog(r)).unwrap();
            prop_assert_eq!(applied(&taps, &light, &registers), value, "register {}: {:?}", r, taps);
        }
    }
}

/// The register of `computes`; where there are events, the drive is in A when the frame ends.
#[test]
fn shipped_programs_compute_what_they_say() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("programs");
    let mut read = 0;
    for folder in fs::read_dir(root).unwrap() {
        for file in fs::read_dir(folder.unwrap().path()).unwrap() {
            let path = file.unwrap().path();
            let text = fs::read_to_string(&path).unwrap();
            let program = Program::parse(&path.display().to_string(), &text).unwrap();
            let Some(computes) = program.settings.computes.clone() else {
                continue;
            };
            let code = program
                .expand(device(), &Overrides::default())
                .unwrap()
                .code;
            let name = computes.register.as_deref().unwrap_or("A");
            let names = &device().registers().analog;
            let register = Analog(names.iter().position(|n| n == name).unwrap() as u8);
            let settings = Settings::from_device(device());
            let taps = taps::read(&code.frame, device(), settings, register).unwrap();
            let kernel = taps.kernel(Input::Light) / computes.scale;
            let rows: Vec<Vec<f64>> = kernel.rows().into_iter().map(|r| r.to_vec()).collect();
            assert_eq!(rows, computes.kernel, "{}", path.display());
            let others = taps
                .taps
                .keys()
                .filter(|(input, _, _)| *input != Input::Light);
            assert_eq!(others.count(), 0, "{}", path.display());
            read += 1;
        }
    }
    assert!(read >= 4, "{read}");
}

fn kernel_of(text: &str, register: u8) -> Result<Taps, TapsError> {
    let program = Program::parse("test", text).unwrap();
    let code = program
        .expand(device(), &Overrides::default())
        .unwrap()
        .code;
    taps::read(
        &code.frame,
        device(),
        Settings::from_device(device()),
        Analog(register),
    )
}

#[test]
fn a_kernel_is_read_in_fractions() {
    // Two stores, a neighbour each way, half.
    let taps = kernel_of(
        "movx(B, A, west);\nmovx(C, A, east);\nsub(B, B, C);\ndivq(D, B);",
        3,
    );
    let taps = taps.unwrap();
    let input = Input::Register(Analog(0));
    let half = Dyadic::from_f64(0.5).unwrap();
    let expected = [
        ((input, 0, -1), half),
        ((input, 0, 1), Dyadic::from_f64(-0.5).unwrap()),
    ];
    assert_eq!(taps.taps, expected.into());
    assert_eq!(half.to_string(), "1/2");
    assert!(taps.constant.is_zero());
}

#[test]
fn what_is_not_linear_is_told_by_line() {
    let why = |text, register| match kernel_of(text, register) {
        Err(TapsError::NoTaps(no)) => (no.line, no.why, no.what),
        other => panic!("{other:?}"),
    };
    let thirds = Primitive::Bus {
        targets: (0..3).map(|r| Target::Register(Analog(r))).collect(),
        sources: vec![Source::Register(Analog(4))],
    };
    let steps = steps(vec![Action::Word(thirds)]);
    let error =
        taps::read(&steps, device(), Settings::from_device(device()), Analog(1)).unwrap_err();
    let TapsError::NoTaps(error) = error else {
        panic!("{error}")
    };
    assert_eq!((error.line, error.why), (1, Why::Parts));

    let (line, reason, what) = why("mov(B, A);\nsq(A);\nbus(D, NEWS);", 3);
    assert_eq!((line, reason), (2, Why::Square), "{what}");
    let (line, reason, _) = why("where(A);\nmov(B, A);\nall();", 1);
    assert_eq!((line, reason), (2, Why::Flag));
    // What was not touched meanwhile is still known.
    assert!(kernel_of("where(A);\nmov(B, A);\nall();\nmov(C, D);", 2).is_ok());
}
