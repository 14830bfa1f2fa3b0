//! Kernels in few values: the nearest there are, with what holds between them; what the compiler
//! makes of them.

use amacrine::{
    array::{Input, Settings, taps},
    compile::Effort,
    isa::Device,
    plane::{Plane, Size},
    program::{Overrides, Program},
    rng::Hash,
};
use amacrine_learn::{
    arm::{self, Few, Shape},
    levels::{Chip, Levels, LevelsError, Projected, Symmetry, search},
    scene::{Clips, Photographs},
    task::Task,
    train::{State, Trainee},
};

fn levels(name: &str) -> Levels {
    name.parse().unwrap()
}

/// Weights from -1 to 1.
fn drawn(seed: u64, side: usize) -> Plane<f64> {
    Plane::from_shape_fn((side, side), |(y, x)| {
        2.0 * Hash::new(seed).with((y * side + x) as u64).uniform() - 1.0
    })
}

/// The residual at the best scale.
fn residual(latent: &Plane<f64>, levels: &Plane<f64>) -> f64 {
    let both = (latent * levels).sum();
    let own = (levels * levels).sum();
    let gain = if both > 0.0 { both * both / own } else { 0.0 };
    (latent * latent).sum() - gain
}

/// The orbit of each place, told apart from the library's own by hand.
fn orbit(symmetry: Symmetry, side: usize, (y, x): (usize, usize)) -> (usize, usize) {
    let last = side - 1;
    let all: Vec<(usize, usize)> = match symmetry {
        Symmetry::None => vec![(y, x)],
        Symmetry::Mirror => vec![(y, x), (y, last - x)],
        Symmetry::Square => {
            let turns = [(y, x), (x, last - y), (last - y, last - x), (last - x, y)];
            turns
                .into_iter()
                .flat_map(|(a, b)| [(a, b), (a, last - b)])
                .collect()
        }
    };
    all.into_iter().min().unwrap()
}

/// Every kernel of levels up to `most` that the symmetry allows, with a sum of 0 where asked.
fn every(symmetry: Symmetry, side: usize, most: i32, zero: bool, see: &mut dyn FnMut(&Plane<f64>)) {
    let places = || (0..side).flat_map(|y| (0..side).map(move |x| (y, x)));
    let mut orbits: Vec<(usize, usize)> = places().map(|at| orbit(symmetry, side, at)).collect();
    orbits.sort_unstable();
    orbits.dedup();
    let base = 2 * most as usize + 1;
    let number = Plane::from_shape_fn((side, side), |at| {
        orbits.binary_search(&orbit(symmetry, side, at)).unwrap() as u32
    });
    for code in 0..base.pow(orbits.len() as u32) {
        let plane = Plane::from_shape_fn((side, side), |at| {
            f64::from((code / base.pow(number[at]) % base) as i32 - most)
        });
        if plane.iter().any(|l| *l != 0.0) && (!zero || plane.sum() == 0.0) {
            see(&plane);
        }
    }
}

#[test]
fn ternary_is_the_nearest_of_all() {
    let cases = [
        ("ternary", Symmetry::None, 3),
        ("ternary:zero", Symmetry::None, 3),
        ("ternary:mirror", Symmetry::Mirror, 3),
        ("ternary:zero:mirror", Symmetry::Mirror, 3),
        ("ternary:d4", Symmetry::Square, 5),
        ("ternary:zero:d4", Symmetry::Square, 5),
    ];
    for (name, symmetry, side) in cases {
        for seed in 0..6 {
            let latent = drawn(seed, side);
            let own = levels(name).project(&latent).unwrap();
            let mut best = f64::INFINITY;
            every(symmetry, side, 1, name.contains("zero"), &mut |plane| {
                best = best.min(residual(&latent, plane));
            });
            let got = residual(&latent, &own.levels);
            assert!(
                got <= best + 1e-9,
                "{name}, {seed}: {got} for {best}\n{}",
                own.levels
            );
            let scale = (&latent * &own.levels).sum() / (&own.levels * &own.levels).sum();
            assert!(
                (own.scale - scale).abs() < 1e-12,
                "{name}: {} for {scale}",
                own.scale
            );
            if name.contains("zero") {
                assert_eq!(own.levels.sum(), 0.0, "{name}");
            }
        }
    }
}

/// Levels of sum 0 that are tied are the nearest at their scale, and the scale the best for them.
#[test]
fn whole_levels_are_the_nearest_at_their_scale() {
    for (name, most, side) in [("int-3:zero:d4", 3, 5), ("int-3:zero:mirror", 3, 3)] {
        for seed in 0..4 {
            let latent = drawn(seed, side);
            let own = levels(name).project(&latent).unwrap();
            let symmetry = levels(name).symmetry;
            let far = |plane: &Plane<f64>| (&latent - &(plane * own.scale)).mapv(|v| v * v).sum();
            let mut best = f64::INFINITY;
            every(symmetry, side, most, true, &mut |plane| {
                best = best.min(far(plane));
            });
            assert!(far(&own.levels) <= best + 1e-9, "{name}, {seed}");
            assert_eq!(own.levels.sum(), 0.0);
            let scale = (&latent * &own.levels).sum() / (&own.levels * &own.levels).sum();
            assert!((own.scale - scale).abs() < 1e-9, "{name}, {seed}");
        }
    }
    let five = levels("int-5").project(&drawn(1, 5)).unwrap();
    assert!(
        five.levels
            .iter()
            .all(|l| l.fract() == 0.0 && l.abs() <= 15.0)
    );
    let powers = levels("po2-3:zero").project(&drawn(2, 3)).unwrap();
    assert!(
        powers
            .levels
            .iter()
            .all(|l| [0.0, 1.0, 2.0, 4.0].contains(&l.abs()))
    );
    assert_eq!(powers.levels.sum(), 0.0);
}

/// Ties fall by place: the same levels every time.
#[test]
fn equal_weights_are_told_apart_by_place() {
    let flat = Plane::from_elem((3, 3), 0.5);
    let zero = levels("ternary:zero");
    let mut delta = flat.clone();
    delta[(1, 1)] = 1.0;
    let own = zero.project(&delta).unwrap();
    assert_eq!(own.levels, zero.project(&delta).unwrap().levels);
    assert_eq!(own.levels[(1, 1)], 1.0);
    assert!(matches!(zero.project(&flat), Err(LevelsError::Empty)));
}

/// Weights that are drawn to their levels arrive there, whichever levels they are.
#[test]
fn drawn_weights_arrive_at_their_levels() {
    for (name, seed) in [
        ("ternary", 1),
        ("ternary:zero", 2),
        ("int-3:zero:d4", 3),
        ("int-5", 4),
    ] {
        let mut cells = arm::named("ternary").unwrap().cells().unwrap().clone();
        cells.few = Some(Few {
            levels: levels(name),
            drawn: true,
        });
        let mut shape = Shape::new(&cells, 1);
        shape.parameters = drawn(seed, 5).into_iter().collect();
        shape.settle();
        let latent = |shape: &Shape| shape.apply(false).unwrap().latent()[0].clone();
        let far = |shape: &Shape| {
            let near = levels(name).project(&latent(shape)).unwrap();
            residual(&latent(shape), &near.levels)
        };
        let mut before = far(&shape);
        for _ in 0..20 {
            shape.draw(0.3).unwrap();
            let now = far(&shape);
            assert!(now < before.max(1e-12), "{name}: {before} and then {now}");
            before = now;
        }
        assert!(before < 1e-5, "{name}: {before}");
        // Then they are levels, and stay the same levels.
        shape.draw(1.0).unwrap();
        let held = shape.apply(true).unwrap();
        let unit = held.few()[0].unit();
        let off = (&unit - &latent(&shape)).mapv(f64::abs);
        assert!(off.iter().all(|v| *v < 1e-12), "{name}");
    }
}

fn chip() -> Chip {
    Chip::new(Device::scamp5(), Effort::states(3_000), 0)
}

/// What is projected is what the compiler makes: the kernel read back from the program's words.
#[test]
fn the_program_computes_what_was_projected() {
    let chip = chip();
    for name in ["ternary:zero:d4", "ternary", "int-3:zero:mirror"] {
        let own = levels(name).project(&drawn(4, 3)).unwrap();
        let made = chip.compile(std::slice::from_ref(&own), 20.0).unwrap();
        let on = 12.0 / made.scale;
        let text = made.program(&[[on, on]], "learned", &chip);
        let program = Program::parse("learned", &text).unwrap();
        let code = program
            .expand(chip.device(), &Overrides::default())
            .unwrap()
            .code;
        let filter = made.sensor();
        let text = filter.filter.text(chip.device(), 0);
        let alone = Program::parse("filter", &text).unwrap();
        let alone = alone
            .expand(chip.device(), &Overrides::default())
            .unwrap()
            .code;
        assert_eq!(alone.frame.len(), made.words);
        assert!(code.frame.len() > made.words);
        let settings = Settings::from_device(chip.device());
        let taps = taps::read(&alone.frame, chip.device(), settings, filter.drives[0]).unwrap();
        let (_, power) = own.kernel().unwrap();
        let mut read = Plane::<f64>::zeros((3, 3));
        for ((input, dy, dx), weight) in &taps.taps {
            assert!(matches!(input, Input::Register(_)));
            read[((1 + dy) as usize, (1 + dx) as usize)] = weight.to_f64();
        }
        let back = read.mapv(|w| w * power * f64::from(1 << made.halvings) + 0.0);
        assert_eq!(back, own.levels, "{name}");
    }
    assert_eq!(chip.compiled(), 3);
}

#[test]
fn a_chip_says_what_it_leaves() {
    let chip = chip();
    let own = levels("ternary:zero:d4").project(&drawn(4, 3)).unwrap();
    let one = chip.compile(std::slice::from_ref(&own), 20.0).unwrap();
    let again = chip.compile(std::slice::from_ref(&own), 20.0).unwrap();
    assert!(std::sync::Arc::ptr_eq(&one, &again), "compiled once");
    // Thresholds near each other share a program, others have their own.
    let near = chip.compile(std::slice::from_ref(&own), 20.5).unwrap();
    let far = chip.compile(std::slice::from_ref(&own), 80.0).unwrap();
    assert!(std::sync::Arc::ptr_eq(&one, &near) && !std::sync::Arc::ptr_eq(&one, &far));
    assert_eq!(chip.compiled(), 2);
    // Whole steps, one at least.
    let step = 1.0 / one.scale;
    assert_eq!(one.threshold(0.0), step);
    assert!((one.threshold(7.4 * step) - 7.0 * step).abs() < 1e-9 * step);
    assert!(one.noise[0].temporal > 0.0 && one.noise[0].fixed > 0.0);
    // White noise of that size leaves the drive's temporal noise after kernel and scale.
    let norm = one.kernels[0]
        .weights()
        .iter()
        .map(|w| w * w)
        .sum::<f64>()
        .sqrt();
    let left = one.light_noise(0) * norm * one.scale;
    assert!((left - one.noise[0].temporal).abs() < 1e-12);
}

#[test]
fn a_search_finds_what_is_worth_more() {
    let chip = chip();
    let ternary = levels("int-3:d4");
    let latent = drawn(4, 3);
    let start = ternary.project(&latent).unwrap();
    // Words alone: fewer of them, and never more.
    let before = chip
        .compile(std::slice::from_ref(&start), 20.0)
        .unwrap()
        .words;
    let mut judged = Vec::new();
    let found = search(
        &ternary,
        (&start, &latent),
        (&chip, 20.0),
        12,
        |kernel, made| {
            judged.push(kernel.levels.clone());
            made.words as f64
        },
    )
    .unwrap();
    assert!(
        found.chip.words < before,
        "{} of {before}",
        found.chip.words
    );
    assert!(found.judged <= 12 && found.judged == judged.len());
    for (n, one) in judged.iter().enumerate() {
        assert!(!judged[..n].contains(one), "judged twice");
        assert!(
            one.indexed_iter()
                .all(|(at, l)| *l == one[orbit(Symmetry::Square, 3, at)])
        );
    }
    // Nothing is worth more: the start stays.
    let same = search(
        &ternary,
        (&start, &latent),
        (&chip, 20.0),
        12,
        |kernel, _| f64::from(kernel.levels != start.levels),
    );
    assert_eq!(same.unwrap().kernel.levels, start.levels);
    // A sum of 0 is kept on the way.
    let zero = levels("ternary:zero:mirror");
    let start = zero.project(&latent).unwrap();
    let found = search(
        &zero,
        (&start, &latent),
        (&chip, 20.0),
        6,
        |kernel: &Projected, made| {
            assert_eq!(kernel.levels.sum(), 0.0);
            made.words as f64
        },
    );
    assert!(found.is_ok());
}

#[test]
fn names_and_kernels_that_make_no_levels() {
    for name in [
        "",
        "tern",
        "int-1x",
        "int-99",
        "po2-0",
        "ternary:",
        "ternary:odd",
    ] {
        let error = name.parse::<Levels>().unwrap_err().to_string();
        assert_eq!(error, format!("`{name}` stands for no levels"));
    }
    for name in ["ternary", "int-5:zero", "po2-2:mirror", "int-8:zero:d4"] {
        assert_eq!(levels(name).to_string(), name);
    }
    let project =
        |name: &str, plane: Plane<f64>| levels(name).project(&plane).unwrap_err().to_string();
    let empty = "few values leave nothing of the kernel: all its levels would be 0";
    for name in ["ternary", "int-5:zero", "ternary:zero:d4", "int-3:zero:d4"] {
        assert_eq!(project(name, Plane::zeros((3, 3))), empty, "{name}");
    }
    assert!(project("ternary:d4", Plane::ones((3, 5))).contains("3x5 weights is not square"));
    assert!(project("ternary", Plane::from_elem((3, 3), f64::NAN)).contains("NaN"));
}

/// Where words are dear, training goes on from a neighbour of fewer words.
#[test]
fn dear_words_make_short_programs() {
    let trained = |price: &str| -> State {
        let text = format!(
            "goal = \"interpolation\"\narms = [\"ternary\"]\nsteps = 12\nbatch = 2\ncrop = 16\n\
            targets = [0.05]\nseeds = [1]\n[network]\nwidths = [4, 6]\nconvolutions = 1\n\
            [scenes]\npan = 1\n{price}"
        );
        let task = Task::parse("small.toml", &text).unwrap_or_else(|faults| panic!("{faults}"));
        let (training, _) = Photographs::bundled().unwrap().split();
        let motion = &task.scenes.motion;
        let clips = Clips::new(&training, motion, Size::new(16, 16), 9, 1).unwrap();
        let mut trainee = Trainee::new((&task, &task.arms[0]), (0.05, 1), &clips).unwrap();
        for _ in 1..task.steps / 2 {
            trainee.step(&clips).unwrap();
        }
        // The point, and weights far off, which take words.
        for (place, weight) in trainee.state.kernel.0.iter_mut().enumerate() {
            *weight = [0.0, 1.0][usize::from([0, 9, 12, 19].contains(&place))];
        }
        // The first search is due after half of the steps.
        trainee.step(&clips).unwrap();
        trainee.state
    };
    let cheap = trained("");
    let dear = trained("[price]\nwords = 10");
    let words = |state: &State| state.words.unwrap();
    assert!(
        words(&dear) < words(&cheap),
        "{} of {}",
        words(&dear),
        words(&cheap)
    );
}
