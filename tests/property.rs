//! The public property tests find what is wrong and nothing else: programs that are the float
//! model agree with it, broken ones are caught on a small scene, and the strategies give what
//! they promise.

use std::panic::{AssertUnwindSafe, catch_unwind};

use amacrine::{
    array::{Arithmetic, Chip, Exact, Settings},
    compile::{CellKind, DriveMemory, Effort, Objective, Request, SensorProgram},
    isa::Device,
    kernel::Kernel,
    number::Format,
    plane::{Plane, Size},
    program::{Overrides, Program},
    property::{
        Clip, Disagreement, Tolerance, agree, assert_agrees, assert_sensors_agree, clips, devices,
        formats, kernels, programs,
    },
    reference::{Description, Reference},
    rig,
};
use proptest::{prelude::*, strategy::ValueTree, test_runner::TestRunner};

const SNAP: &str = include_str!("../programs/dvs/snap.scamp");

fn float(kernel: &Kernel, threshold: f64) -> Description {
    let rows: Vec<Vec<f64>> = (kernel.weights().rows().into_iter())
        .map(|row| row.to_vec())
        .collect();
    let text = format!(
        "name = \"float\"\nresponse = \"identity\"\nmemory = \"filtered-snap\"\nborder = \"zero\"\n\
         [[channel]]\nkernel = {rows:?}\nthreshold = {{ on = {threshold:?}, off = {threshold:?} }}\n"
    );
    Description::parse("float", &text, &|_| unreachable!()).unwrap()
}

fn pixel() -> Kernel {
    Kernel::from_rows(&[vec![1.0]]).unwrap()
}

fn caught(program: &Program, float: &Description, tolerance: &Tolerance) -> String {
    let tried = AssertUnwindSafe(|| assert_agrees(program, float, tolerance));
    let panic = catch_unwind(tried).expect_err("nothing was found");
    *panic.downcast::<String>().unwrap()
}

#[test]
fn a_program_that_is_the_float_model_agrees() {
    let program = Program::parse("snap", SNAP).unwrap();
    assert_agrees(&program, &float(&pixel(), 20.0), &Tolerance::default());
}

/// Another threshold by a quarter of a level: only a difference of just the threshold shows it,
/// and the scene that is shown has little else.
#[test]
fn a_threshold_that_is_wrong_is_caught() {
    let program = Program::parse("snap", SNAP).unwrap();
    let tolerance = Tolerance {
        size: Size::new(3, 2),
        cases: 5000,
        ..Tolerance::default()
    };
    let said = caught(&program, &float(&pixel(), 19.75), &tolerance);
    assert!(said.contains("snap does not agree with float"), "{said}");
    // Shrunk to next to nothing.
    let few = (0..=3).map(|n| format!(" {n} events of the float model"));
    assert!(few.into_iter().any(|few| said.contains(&few)), "{said}");
}

#[test]
fn a_program_that_does_not_run_is_named() {
    let program = Program::parse("wrong", "frame {\n    mov(A, Q);\n}\n").unwrap();
    let clip = Clip {
        frames: vec![Plane::zeros((2, 2))],
        fps: 1.0,
    };
    let error = agree(
        &program,
        &float(&pixel(), 20.0),
        &clip,
        &Tolerance::default(),
    );
    assert!(matches!(error, Err(Disagreement::Broken { what, .. }) if what == "wrong"));
}

/// Silicon is not exact, and not far from it.
#[test]
fn silicon_agrees_within_a_tolerance_only() {
    let program = Program::parse("snap", SNAP).unwrap();
    let silicon = Tolerance {
        arithmetic: "silicon".parse().unwrap(),
        size: Size::new(24, 24),
        cases: 16,
        ..Tolerance::default()
    };
    let said = caught(&program, &float(&pixel(), 20.0), &silicon);
    assert!(said.contains("F1 is 0."), "{said}");
    let loose = Tolerance {
        least_f1: 0.9,
        least_events: 200,
        ..silicon
    };
    assert_agrees(&program, &float(&pixel(), 20.0), &loose);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Five lines of a user's test: any kernel, compiled, is the float model with that kernel.
    #[test]
    fn compiled_kernels_agree(kernel in kernels(&[1, 3], -2..=2, 1), clip in clips(Size::new(8, 7), 2..=4)) {
        let device = Device::scamp5();
        let kinds = [CellKind { name: None, kernel: kernel.clone(), on: 30.0, off: 30.0 }];
        let kernels = [kernel.clone()];
        let mut request = Request::new(&kernels, &device).unwrap();
        request.effort = Effort::states(500);
        request.objective = Objective::Exact;
        let program = SensorProgram::new(&kinds, DriveMemory::Analogue, "any", &request).unwrap();
        prop_assume!(program.filter.border);
        let program = Program::parse("any", &program.text).unwrap();
        let agreed = agree(&program, &float(&kernel, 30.0), &clip, &Tolerance::default());
        prop_assert!(agreed.is_ok(), "{}", agreed.unwrap_err());
    }

    #[test]
    fn strategies_keep_their_word(
        kernel in kernels(&[3, 5], -3..=3, 2),
        clip in clips(Size::new(4, 5), 1..=3),
        arithmetic in formats(),
        device in devices(),
        text in programs(0..=12),
    ) {
        prop_assert!(kernel.weights().iter().all(|w| (w * 4.0).fract() == 0.0 && w.abs() <= 0.75));
        prop_assert!((1..=3).contains(&clip.frames.len()));
        for frame in &clip.frames {
            prop_assert_eq!(frame.dim(), (4, 5));
            prop_assert!(frame.iter().all(|l| (0.0..=254.0).contains(l) && l.fract() == 0.0));
        }
        let program = Program::parse("random", &text).unwrap();
        let code = program.expand(&device, &Overrides::default()).unwrap().code;
        let settings = Settings::from_device(&device);
        prop_assert!(arithmetic.chip("random", &code, &device, Size::new(5, 4), settings).is_ok());
        prop_assert!(Chip::new("random", Exact, &code, &device, Size::new(5, 4), settings).is_ok());
    }
}

/// Any two sensors, and a clip as a scene for whoever watches scenes.
#[test]
fn sensors_of_any_make_are_compared() {
    let size = Size::new(3, 2);
    let tolerance = Tolerance {
        size,
        cases: 2000,
        ..Tolerance::default()
    };
    let sensor = |threshold: f64| move |size| Reference::new(float(&pixel(), threshold), size, 0);
    assert_sensors_agree(sensor(20.0), sensor(20.0), &tolerance);
    let tried = AssertUnwindSafe(|| assert_sensors_agree(sensor(20.0), sensor(22.0), &tolerance));
    let panic = catch_unwind(tried).expect_err("nothing was found");
    let said = *panic.downcast::<String>().unwrap();
    assert!(said.contains("float does not agree with float"), "{said}");
    let clip = Clip {
        frames: vec![Plane::zeros((3, 2)), Plane::from_elem((3, 2), 90.0)],
        fps: 10.0,
    };
    let mut watching = sensor(20.0)(size).unwrap();
    let packets = rig::watch(&mut clip.scene(), &mut [&mut watching], |_| ()).unwrap();
    assert_eq!(packets[0].events.len(), 6);
    assert_eq!(packets[0].span.1.0, 100_000);
}

/// Each kind of number is drawn, and chips that err.
#[test]
fn all_kinds_of_arithmetic_are_drawn() {
    let mut runner = TestRunner::deterministic();
    let mut left: Vec<_> = Format::examples()
        .map(|it| std::mem::discriminant(&it))
        .collect();
    let mut silicon = false;
    for _ in 0..200 {
        match formats().new_tree(&mut runner).unwrap().current() {
            Arithmetic::Number(format) => left.retain(|it| *it != std::mem::discriminant(&format)),
            Arithmetic::Silicon { .. } => silicon = true,
        }
    }
    assert!(left.is_empty() && silicon, "{left:?}");
}
