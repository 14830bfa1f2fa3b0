//! What the compiler predicts of the silicon, against runs as silicon; what the choice by it is
//! worth; and that more registers never cost words.

#[path = "../examples/survival/filters.rs"]
mod filters;

use amacrine::{
    compile::{
        CellKind, CompileError, DriveMemory, Effort, Objective, Request, SensorProgram, Signal,
        bound,
    },
    isa::Device,
    kernel::{
        Kernel,
        quantise::{Quantiser, Sum},
    },
    rng::Hash,
};
use filters::{correlations, filters};

const EFFORT: Effort = Effort::states(20_000);

/// Words that other compilers need.
const PEER: [(&str, usize); 6] = [
    ("Sobel x", 10),
    ("Sobel pair", 18),
    ("Gauss 3x3 / 16", 32),
    ("Gauss 5x5 / 256", 54),
    ("box 3x3", 12),
    ("box 5x5", 18),
];

fn named(name: &str) -> Vec<Kernel> {
    let found = filters().into_iter().find(|(own, _)| own == name);
    found.unwrap().1
}

/// At the amplitude at which the prediction is best, and at the others where something is left,
/// within 5 %.
#[test]
fn silicon_does_as_predicted() {
    let device = Device::scamp5();
    for (name, kernels) in filters() {
        let mut request = Request::new(&kernels, &device).unwrap();
        request.effort = EFFORT;
        let filter = request.filter().unwrap();
        assert!(filter.words.len() < 200, "{name}");
        let said = filter.best_forecast(&device, &kernels);
        let got = correlations(&filter, &request, said[0].amplitude, 3);
        for (said, got) in said.iter().zip(got) {
            let words = filter.words.len();
            println!(
                "{name:<22}{words:>4} words, ±{:<3} {:.3} said, {got:.3} got",
                said.amplitude, said.correlation
            );
            assert!(got > 0.95, "{name}: {got}");
            assert!(
                (got / said.correlation - 1.0).abs() < 0.05,
                "{name}: {got} {said:?}"
            );
        }
    }
}

/// Weights of many digits make sums that saturate: without a range too a filter is halved where that is
/// what lets it come out, in no more words than its kernel over a power of two by hand.
#[test]
fn large_weights_are_halved_on_the_way() {
    let device = Device::scamp5();
    let eight: [&[f64]; 3] = [
        &[90.0, -13.0, 44.0],
        &[58.0, -105.0, 31.0],
        &[-27.0, 71.0, 119.0],
    ];
    let rows = |by: f64| eight.map(|row| row.iter().map(|w| w / by).collect::<Vec<_>>());
    let chosen = |by: f64, objective| {
        let kernels = [Kernel::from_rows(&rows(by)).unwrap()];
        let mut request = Request::new(&kernels, &device).unwrap();
        request.effort = EFFORT;
        request.objective = objective;
        let filter = request.filter().unwrap();
        let said = filter.best_forecast(&device, &kernels)[0];
        let got = correlations(&filter, &request, said.amplitude, 1)[0];
        (filter.words.len(), filter.prescale, got)
    };
    let (words, bits, got) = chosen(1.0, Objective::Silicon);
    assert_eq!(bits, 6);
    assert!(got > 0.99, "{got}");
    assert_eq!(chosen(64.0, Objective::Silicon), (words, 0, got));
    // Who asks for the fewest words, or for exact ones, asks for them of this kernel.
    for objective in [Objective::Words, Objective::Exact] {
        assert_eq!(chosen(1.0, objective).1, 0);
    }
}

/// Also of plans that pile up errors until nothing is left.
#[test]
fn what_is_lost_is_predicted_too() {
    let device = Device::scamp5();
    for name in [
        "Gauss 3x3",
        "box 3x3",
        "box 5x5",
        "Sobel x",
        "Gauss 3x3 / 16",
    ] {
        let kernels = named(name);
        let mut request = Request::new(&kernels, &device).unwrap();
        request.effort = EFFORT;
        request.objective = Objective::Words;
        let filter = request.filter().unwrap();
        for amplitude in [20.0, 3.0] {
            let signal = Signal::around_zero(amplitude);
            let said = filter.forecast(&device, &kernels, signal)[0].correlation;
            let all = (0..4).map(|seed| correlations(&filter, &request, amplitude, seed)[0]);
            let got = all.sum::<f64>() / 4.0;
            println!("{name} ±{amplitude}: {said:.3} said, {got:.3} got");
            assert!(
                (got - said).abs() < 0.06,
                "{name} ±{amplitude}: {said} {got}"
            );
        }
    }
}

#[test]
fn no_more_words_than_others_need() {
    let device = Device::scamp5();
    for (name, most) in PEER {
        let kernels = named(name);
        let mut request = Request::new(&kernels, &device).unwrap();
        request.effort = Effort::states(100_000);
        let words = request.filter().unwrap().words.len();
        assert!(words <= most, "{name}: {words} words of {most}");
    }
}

/// The choice by what comes out is better at it than the choice by words, and a front lists both.
#[test]
fn a_front_goes_up_with_words() {
    let device = Device::scamp5();
    let kernels = named("box 5x5");
    let mut request = Request::new(&kernels, &device).unwrap();
    request.effort = EFFORT;
    let correlation =
        |filter: &amacrine::compile::Filter| filter.best_forecast(&device, &kernels)[0].correlation;
    let front = request.front().unwrap();
    assert!(front.len() > 1);
    for pair in front.windows(2) {
        assert!(pair[0].words.len() < pair[1].words.len());
        assert!(correlation(&pair[0]) < correlation(&pair[1]));
    }
    let chosen = request.filter().unwrap();
    request.objective = Objective::Words;
    let shortest = request.filter().unwrap();
    assert!(shortest.words.len() <= chosen.words.len());
    assert!(correlation(&chosen) > correlation(&shortest) + 0.2);
}

/// What the other objectives find is never shorter: halvings inside a plan may take fewer words than
/// all of them in front of it.
#[test]
fn the_fewest_words_are_the_fewest() {
    let device = Device::scamp5();
    let rows = |rows: &[&[f64]]| {
        Kernel::from_rows(&rows.iter().map(|row| row.to_vec()).collect::<Vec<_>>()).unwrap()
    };
    let six_bits = rows(&[&[12.0, -10.0, 0.0], &[14.0, 11.0, 6.0], &[4.0, -14.0, 7.0]]);
    let ternary = rows(&[
        &[-1.0, -1.0, 1.0, 1.0, -1.0],
        &[0.0, 1.0, -1.0, 1.0, -1.0],
        &[0.0, 1.0, -1.0, 0.0, -1.0],
        &[1.0, -1.0, 1.0, 0.0, 0.0],
        &[0.0, 0.0, 0.0, 0.0, 1.0],
    ]);
    for (kernel, range) in [(six_bits, Some((-64.0, 63.0))), (ternary, None)] {
        let kernels = [kernel];
        let words = |objective| {
            let mut request = Request::new(&kernels, &device).unwrap();
            request.range = range;
            request.objective = objective;
            let filter = request.filter().unwrap();
            assert!(range.is_none() || filter.holds);
            filter.words.len()
        };
        let fewest = words(Objective::Words);
        for objective in [Objective::Silicon, Objective::Exact] {
            let other = words(objective);
            assert!(fewest <= other, "{fewest} words, {other} for {objective:?}");
        }
    }
}

/// A threshold that the halvings leave nothing of makes any change fire: a program that keeps it is
/// taken where there is one.
#[test]
fn halvings_leave_a_threshold() {
    let device = Device::scamp5();
    let kernels = [Kernel::from_rows(&[
        vec![12.0, -10.0, 0.0],
        vec![14.0, 11.0, 6.0],
        vec![4.0, -14.0, 7.0],
    ])
    .unwrap()];
    let kinds = [CellKind {
        name: None,
        kernel: kernels[0].clone(),
        on: 300.0,
        off: 300.0,
    }];
    let mut request = Request::new(&kernels, &device).unwrap();
    request.objective = Objective::Exact;
    let sensor = SensorProgram::new(&kinds, DriveMemory::Analogue, "a", &request).unwrap();
    let left = 150.0 * sensor.filter.scale();
    assert!(left >= 1.0, "{left} LSB of the threshold");
}

#[test]
fn more_registers_never_cost_words() {
    let wide: Device = Device::find("scamp5-wide").unwrap();
    let device = Device::scamp5();
    for objective in [Objective::Silicon, Objective::Words] {
        for name in ["6 bits 5x5, 0", "ternary 5x5, 1", "quad", "Gauss 5x5 / 256"] {
            let kernels = named(name);
            let words = |device: &Device| {
                let mut request = Request::new(&kernels, device).unwrap();
                request.effort = Effort::states(5000);
                request.objective = objective;
                request.filter().unwrap().words.len()
            };
            let (few, many) = (words(&device), words(&wide));
            assert!(
                many <= few,
                "{name}: {many} words, {few} with fewer registers"
            );
        }
    }
}

/// Random kernels in 3 to 8 registers: with one more there are no more words. Each count is the
/// wide chip's, the others kept.
#[test]
fn one_register_more_never_costs_words() {
    let wide: Device = Device::find("scamp5-wide").unwrap();
    let registers: Vec<_> = "ABCDEFGHIJKL".chars().map(String::from).collect();
    let registers: Vec<_> = { registers.iter() }
        .map(|name| wide.value_of(name).and_then(|it| it.analog()).unwrap())
        .collect();
    for seed in 0..4u64 {
        let side = if seed % 2 == 0 { 3 } else { 5 };
        let weight = |at: usize| {
            let draw = Hash::raw(seed).nth(at as u64).bits() >> 40;
            f64::from((draw % if seed % 3 == 0 { 3 } else { 15 }) as u32)
                - if seed % 3 == 0 { 1.0 } else { 7.0 }
        };
        let row = |y: usize| (0..side).map(|x| weight(y * side + x)).collect();
        let rows: Vec<Vec<f64>> = (0..side).map(row).collect();
        let kernels = [Kernel::from_rows(&rows).unwrap()];
        let words = |count: usize| {
            let mut request = Request::new(&kernels, &wide).unwrap();
            request.effort = Effort::states(1500);
            request.objective = Objective::Words;
            request.keep = registers[count..].to_vec();
            request.filter().unwrap().words.len()
        };
        let all: Vec<usize> = (3..=8).map(words).collect();
        assert!(
            all.is_sorted_by(|few, more| few >= more),
            "{rows:?}: {all:?}"
        );
    }
}

/// SCAMP-5 with so few analogue registers.
fn narrow(registers: usize) -> Device {
    let parent = tempfile::tempdir().unwrap();
    let folder = parent.path().join("x");
    std::fs::create_dir(&folder).unwrap();
    let names: Vec<&str> = { ["A", "B", "C", "D", "E"][..registers].iter().copied() }
        .chain(["NEWS"])
        .collect();
    let text = format!(
        "name = \"x\"\ntitle = \"x\"\nextends = \"scamp5\"\n[registers]\nanalogue = {names:?}\n"
    );
    std::fs::write(folder.join("device.toml"), text).unwrap();
    Device::load(&folder).unwrap()
}

/// On chips of three to five registers: where no more comes out, there are no more words.
#[test]
fn one_register_more_never_costs_words_of_the_same_signal() {
    for name in ["authors-csdvs-5", "csdvs-3", "csdvs-5", "oblique-45"] {
        let float = Kernel::builtin(name).unwrap();
        let few = "int-4".parse::<Quantiser>().unwrap();
        let kernels = [few.quantise(&float, Sum::Free, 0).unwrap().levels];
        let found = |registers: usize| {
            let device = narrow(registers);
            let mut request = Request::new(&kernels, &device).unwrap();
            request.effort = Effort::states(20_000);
            let filter = request.filter().unwrap();
            let forecast = filter.best_forecast(&device, &kernels)[0];
            ((forecast.snr_db() / 0.25).round(), filter.words.len())
        };
        let all: Vec<_> = (3..=5).map(found).collect();
        assert!(
            all.is_sorted_by(|few, more| more.0 > few.0 || more.1 <= few.1),
            "{name}: {all:?}"
        );
    }
}

/// On SCAMP-5, against a chip that has one register less: a ternary and a five-bit kernel of which a
/// search in six registers finds the longer plan, of more noise.
#[test]
fn scamp5_has_no_longer_filter_than_a_chip_of_five_registers() {
    let ternary = [
        &[0, 0, 0, 1, 0][..],
        &[1, 1, -1, 1, 0],
        &[1, 0, -1, 1, -1],
        &[-1, -1, 0, 0, 0],
        &[1, 1, 0, -1, 1],
    ];
    let of_five_bits = [&[-15, 5, -5][..], &[5, 3, 7], &[-4, 4, -12]];
    let rows = |rows: &[&[i8]]| -> Vec<Vec<f64>> {
        { rows.iter() }
            .map(|row| row.iter().copied().map(f64::from).collect())
            .collect()
    };
    for rows in [rows(&ternary), rows(&of_five_bits)] {
        let kernels = [Kernel::from_rows(&rows).unwrap()];
        let found = |device: &Device| {
            let request = Request::new(&kernels, device).unwrap();
            let filter = request.filter().unwrap();
            let forecast = filter.best_forecast(device, &kernels)[0];
            (filter.words.len(), forecast.snr_db())
        };
        let (few, many) = (found(&narrow(5)), found(&Device::scamp5()));
        assert!(many.0 <= few.0 || many.1 > few.1, "{many:?} {few:?}");
    }
}

/// A longer search has met many plans that are right at the border, all of them longer than what a
/// short one finds.
#[test]
fn a_longer_search_keeps_the_shorter_plans() {
    const ROWS: [[i8; 7]; 7] = [
        [1, 0, 1, -1, 0, -1, 0],
        [0, 0, 1, 0, 1, -1, 1],
        [0, 1, 0, -1, 1, 1, 0],
        [1, -1, 0, 1, -1, 1, -1],
        [0, 1, 0, 0, 1, -1, 0],
        [1, 0, 0, 0, 1, 1, 1],
        [1, 1, 0, -1, 1, 1, 0],
    ];
    let rows = ROWS.map(|row| row.map(f64::from).to_vec());
    let kernels = [Kernel::from_rows(&rows).unwrap()];
    let device = narrow(4);
    let found = |states: u64, objective: Objective| {
        let mut request = Request::new(&kernels, &device).unwrap();
        request.effort = Effort::states(states);
        request.objective = objective;
        let filter = request.filter().unwrap();
        let forecast = filter.best_forecast(&device, &kernels)[0];
        (filter.words.len(), forecast.snr_db())
    };
    let (fewest, db) = found(400_000, Objective::Words);
    for states in [40_000, 400_000] {
        let (words, own) = found(states, Objective::Silicon);
        println!("{states}: {words} words, {own:.1} dB; the fewest {fewest}, {db:.1} dB");
        assert!(words <= fewest + fewest / 4 && own >= db - 0.5);
    }
}

/// On chips of few registers a short search for the fewest words is no shorter than another.
#[test]
fn the_fewest_words_in_few_registers_are_the_fewest() {
    const ROWS: [[i8; 7]; 7] = [
        [0, 0, -1, 0, 1, 0, 0],
        [0, 0, 0, 1, -1, 1, -1],
        [0, -1, -1, 1, 0, 1, 1],
        [1, -1, 0, -1, 1, -1, 1],
        [0, 0, 1, -1, 0, 0, 0],
        [1, 1, -1, 1, 0, 0, 1],
        [0, -1, 1, -1, -1, 1, 0],
    ];
    let rows = ROWS.map(|row| row.map(f64::from).to_vec());
    let kernels = [Kernel::from_rows(&rows).unwrap()];
    let device = narrow(4);
    let words = |objective| {
        let mut request = Request::new(&kernels, &device).unwrap();
        request.effort = Effort::states(40_000);
        request.objective = objective;
        request.filter().unwrap().words.len()
    };
    let fewest = words(Objective::Words);
    for objective in [Objective::Silicon, Objective::Exact] {
        let other = words(objective);
        assert!(fewest <= other, "{fewest} words, {other} for {objective:?}");
    }
}

/// A kernel whose result is far below one LSB leaves nothing.
#[test]
fn what_leaves_nothing_is_refused() {
    let device = Device::scamp5();
    let kernels = [Kernel::from_rows(&[vec![1.0 / 4096.0]]).unwrap()];
    let mut request = Request::new(&kernels, &device).unwrap();
    request.effort = EFFORT;
    request.range = Some((0.0, 1.0));
    let refused = request.filter().unwrap_err();
    assert!(matches!(refused, CompileError::Nothing { .. }), "{refused}");
    request.objective = Objective::Words;
    assert!(request.filter().is_ok());
}

/// A whole sensor: nothing saturates, and no more is halved than by the shortest program.
#[test]
fn sensors_keep_more_of_the_signal() {
    let device = Device::scamp5();
    let kernels = named("rgc-5x5 ternary");
    let kinds = [CellKind {
        name: None,
        kernel: kernels[0].clone(),
        on: 40.0,
        off: 40.0,
    }];
    let of = |objective| {
        let mut request = Request::new(&kernels, &device).unwrap();
        request.effort = EFFORT;
        request.objective = objective;
        let sensor = SensorProgram::new(&kinds, DriveMemory::Analogue, "a", &request).unwrap();
        assert!(sensor.filter.holds);
        let light = Signal::from_range((0.0, 127.0));
        let said = sensor.filter.forecast(&device, &kernels, light)[0];
        println!(
            "{objective:?}: {} words, {said:?}",
            sensor.filter.words.len()
        );
        said.correlation
    };
    assert!(of(Objective::Exact) >= of(Objective::Words));
}

/// Rows of the atlas, chosen by a hash, are what the compiler gives today.
#[test]
fn the_atlas_is_up_to_date() {
    let device = Device::scamp5();
    let atlas = include_str!("../docs/atlas.csv");
    let rows: Vec<&str> = atlas.lines().skip(1).collect();
    assert_eq!(rows.len(), bound::classes().count());
    for i in 0..5 {
        let row = rows[(Hash::new(22).with(i).bits() % rows.len() as u64) as usize];
        let fields: Vec<&str> = row.split(',').collect();
        let class: u16 = fields[0].parse().unwrap();
        let weights = bound::weights(class).map(|row| row.map(f64::from).to_vec());
        let kernels = [Kernel::from_rows(&weights).unwrap()];
        let mut found = vec![bound::LowerBound::new(&kernels).words.to_string()];
        for objective in [Objective::Words, Objective::Silicon] {
            let mut request = Request::new(&kernels, &device).unwrap();
            request.effort = Effort::states(12_000);
            request.objective = objective;
            let filter = request.filter().unwrap();
            let said = filter.best_forecast(&device, &kernels);
            found.push(filter.words.len().to_string());
            found.push(format!("{:.4}", said[0].correlation));
        }
        assert_eq!(found, fields[3..], "class {class}");
    }
}
