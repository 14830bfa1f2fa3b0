//! The pilot on the array: tiles of a program have the events of the whole array, to the bit, errors
//! of the chip included, and limits hold.

use std::sync::{
    LazyLock,
    atomic::{AtomicU64, Ordering},
};

use amacrine::{
    array::{Arithmetic, Settings},
    compile::Effort,
    event::{Event, Packet},
    isa::Device,
    kernel::{
        Kernel,
        quantise::{Quantiser, Sum},
    },
    mosaic::{Mosaic, Outside},
    number::Format,
    plane::{At, Plane, Size},
    program::{Overrides, Program},
    rng::Hash,
    scene::{Frame, Scene, held::Held, kept::Kept},
    study::{
        design::{Compiled, Design},
        pilot::{
            Change, ChangeEstimate, Chips, ErrorTerm, Family, Grid, Look, Machine, Measure, change,
            draw,
        },
    },
    unit::Micros,
};
use proptest::prelude::*;

/// Programs of some kernels.
static PROGRAMS: LazyLock<Vec<Compiled>> = LazyLock::new(|| {
    let device = Device::scamp5();
    let compiled = |(name, threshold): (&str, f64)| {
        let kernel = Kernel::builtin(name).unwrap();
        let float = Design {
            kernel: &kernel,
            threshold,
            device: &device,
            effort: Effort::states(2_000),
            seed: 0,
        };
        let quantised = float.quantise(Quantiser::TERNARY, Sum::Free).unwrap();
        float.in_levels(&quantised).compile(name).unwrap()
    };
    [("dvs", 20.0), ("csdvs-3", 12.0), ("sobel-x", 40.0)]
        .map(compiled)
        .into()
});

fn kept(seed: u64, height: usize, width: usize, frames: u64) -> Kept {
    let chance = |n: u64| Hash::new(seed).with(n).uniform();
    let (speed, size) = (0.5 + 3.0 * chance(0), 2.0 + 4.0 * chance(1));
    let texture = 20.0 * chance(2);
    let frame = |index: u64| Frame {
        index,
        seconds: index as f64 / 200.0,
        light: Plane::from_shape_fn((height, width), |(y, x)| {
            let (dy, dx) = (
                y as f64 - height as f64 / 2.0,
                x as f64 - speed * index as f64,
            );
            let spot = 130.0 * (-(dy * dy + dx * dx) / (2.0 * size * size)).exp();
            let grain = texture * chance(1000 + (y * width + x) as u64 + (index / 3) * 100_000);
            (60.0 + spot + grain).clamp(0.0, 255.0)
        })
        .into(),
    };
    let frames = (0..frames).map(frame).collect();
    let mut scene = Held::new(frames, Size::new(height, width), 200.0);
    Kept::new(&mut scene, 1 << 26).unwrap().unwrap()
}

fn chips(compiled: &Compiled, arithmetic: Arithmetic) -> Chips<'_> {
    let silicon = matches!(arithmetic, Arithmetic::Silicon { .. });
    Chips {
        name: "chip",
        code: &compiled.code,
        device: &compiled.device,
        settings: Settings {
            clip: !silicon,
            ..compiled.settings()
        },
        arithmetic,
    }
}

fn whole(chips: &Chips<'_>, machine: &Machine, kept: &Kept) -> Packet {
    let size = kept.size();
    let mut chip = chips
        .chip(machine, size, (At { y: 0, x: 0 }, size.width))
        .unwrap();
    let mut packet = Packet::new(size, chip.channels());
    let mut scene = kept.scene();
    while let Some(frame) = scene.next_frame().unwrap() {
        chip.watch(&frame, &mut packet).unwrap();
    }
    assert_eq!(packet.dropped.no_slot, 0);
    packet
}

fn all_tiles(kept: &Kept, side: usize, halo: usize, across: usize) -> Mosaic {
    let grid = Grid {
        size: kept.size(),
        side,
    };
    let corners = (0..grid.tiles()).map(|tile| grid.corner(tile)).collect();
    Mosaic::new(grid.size, Size::new(side, side), halo, corners, across)
}

type Key = (u64, usize, usize, u8, u8);

fn sorted(events: impl Iterator<Item = (At, Event)>) -> Vec<Key> {
    let key = |(at, e): (At, Event)| (e.t.0, at.y, at.x, e.channel, e.polarity.bit());
    let mut events: Vec<Key> = events.map(key).collect();
    events.sort_unstable();
    events
}

fn machine(arithmetic: &str) -> (Arithmetic, Machine) {
    let arithmetic: Arithmetic = arithmetic.parse().unwrap();
    let format = match arithmetic {
        Arithmetic::Number(format) => Some(format),
        Arithmetic::Silicon { .. } => None,
    };
    (
        arithmetic,
        Machine {
            format,
            without: Vec::new(),
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn tiles_have_the_events_of_the_whole_array(
        seed in 0u64..1000,
        (height, width) in (9usize..30, 9usize..34),
        program in 0usize..3,
        arithmetic in proptest::sample::select(vec!["silicon", "silicon", "f32", "q8.8"]),
        side in 1usize..5,
        across in 1usize..6,
    ) {
        let (arithmetic, machine) = machine(arithmetic);
        let chips = chips(&PROGRAMS[program], arithmetic.with_seed(seed));
        let kept = kept(seed, height, width, 6);
        let full = whole(&chips, &machine, &kept);
        let halo = chips.halo().unwrap();
        let mosaic = all_tiles(&kept, 2 * side, halo, across);
        let mut tiles = chips.on_tiles(&machine, &mosaic).unwrap();
        let mut packet = Packet::new(tiles.size(), tiles.channels());
        let mut scene = kept.scene();
        while let Some(frame) = scene.next_frame().unwrap() {
            let light = mosaic.shown(&frame.light, Outside::Nearest);
            tiles.watch(&Frame { light: light.into(), ..frame }, &mut packet).unwrap();
        }
        let at = |e: &Event| (At { y: e.y.into(), x: e.x.into() }, *e);
        let own = packet.events.iter().filter(|e| mosaic.tile(e.y.into(), e.x.into()).is_some());
        let home = own.map(|e| (mosaic.home(e.y.into(), e.x.into()), *e));
        prop_assert_eq!(sorted(home), sorted(full.events.iter().map(at)));
        prop_assert!(program > 0 || halo == 0);
    }
}

/// Random programs, scenes and machines: at most one in twenty above its limit.
#[test]
fn limits_hold_on_the_array() {
    let (mut with, mut above, mut changed) = (0, 0, 0);
    for seed in 0..48u64 {
        let chance = |n: u64| Hash::new(seed).with(7).with(n).uniform();
        let below = |n: u64, end: usize| ((chance(n) * end as f64) as usize).min(end - 1);
        let kept = kept(seed, 36 + 4 * below(0, 4), 36 + 4 * below(1, 5), 10);
        let arithmetic = ["silicon", "silicon", "exact", "f32"][below(2, 4)];
        let (arithmetic, full) = machine(arithmetic);
        let chips = chips(&PROGRAMS[below(3, 3)], arithmetic.with_seed(seed));
        let plain = if full.format.is_none() && chance(4) < 0.7 {
            Machine {
                format: None,
                without: vec![ErrorTerm::ALL[below(5, ErrorTerm::ALL.len())]],
            }
        } else {
            let formats = ["q8.8", "f16", "q8.0", "bf16"];
            let format: Format = formats[below(6, 4)].parse().unwrap();
            Machine {
                format: Some(format),
                without: Vec::new(),
            }
        };
        let (a, b) = (whole(&chips, &full, &kept), whole(&chips, &plain, &kept));
        let truth = Change::between(&a, &b, Micros(100)).unwrap().share;
        let grid = Grid {
            size: kept.size(),
            side: [4, 8][below(7, 2)],
        };
        let look = Look::new(&kept, grid, false);
        let mut activity = look.seen_from(chips.halo().unwrap());
        if chips.fires_alone() {
            for tile in &mut activity {
                *tile = tile.max(0.0);
            }
        }
        let drawn = draw::draw(&activity, &look.extremes, 12 + below(8, 20), seed);
        let mut probabilities = vec![f64::NAN; grid.tiles()];
        for one in &drawn {
            probabilities[one.tile] = one.probability;
        }
        let across = grid.size.width.div_ceil(grid.side);
        let mosaic = all_tiles(&kept, grid.side, 0, across);
        let tiles = change::of_tiles(&mosaic, &probabilities, (&a, &b), Micros(100)).unwrap();
        let tiles: Vec<_> = tiles
            .into_iter()
            .filter(|tile| !tile.probability.is_nan())
            .collect();
        let estimate = ChangeEstimate::new(&tiles, chips.unseen(&plain, &look), 0.05);
        let Some(limit) = estimate.limit else {
            continue;
        };
        with += 1;
        changed += usize::from(truth > 0.0);
        if truth > limit {
            above += 1;
            println!("{seed}: {full} for {plain}: {truth:.5}, {estimate:?}");
        }
    }
    println!("{with} with a limit, {changed} with a change, {above} above");
    assert!(
        with > 30 && changed > 15 && 20 * above <= with,
        "{above} of {with}"
    );
}

/// Programs on small arrays take longer to be tried than to run: trials end with the pilot's time.
#[test]
fn a_pilot_on_a_small_array_keeps_its_time() {
    let kept = kept(0, 64, 64, 12);
    let (arithmetic, full) = machine("silicon");
    let chips = chips(&PROGRAMS[0], arithmetic);
    // A clock on which every step takes a second.
    let ticks = AtomicU64::new(0);
    let clock = || ticks.fetch_add(1, Ordering::Relaxed) as f64;
    let measure = Measure {
        kept: &kept,
        upsample: None,
        tolerance: 0.01,
        within: Micros(100),
        seed: 0,
        clock: &clock,
        budget: (0.0, 60.0),
        tiles: None,
        look: None,
        limits_only: false,
    };
    let candidates = chips.candidates(&[Format::F32, Format::F64]);
    let answer = measure.ask(&chips, &candidates).unwrap();
    assert_eq!(answer.choice, full);
    assert!(answer.why.contains("too short"), "{}", answer.why);
    assert!((60.0..70.0).contains(&answer.seconds), "{}", answer.seconds);
}

/// What propagates, what is moved on with every frame, and what is addressed has no tiles.
#[test]
fn programs_without_tiles_are_left_alone() {
    let device = Device::scamp5();
    for (text, why) in [
        (
            "init { }\nframe { get_image(A); movx(B, B, east); add(B, B, A); where(B); MOV(R5, FLAG); all(); scamp5_scan_events(R5, on, 100); }",
            "further away",
        ),
        (
            "init { }\nframe { get_image(A); where(A); MOV(R5, FLAG); all(); scamp5_load_rect(R6, 1, 1, 9, 9); AND(R5, R5, R6); scamp5_scan_events(R5, on, 100); }",
            "places of the array",
        ),
    ] {
        let program = Program::parse("none", text).unwrap();
        let code = program.expand(&device, &Overrides::default()).unwrap().code;
        let chips = Chips {
            name: "none",
            code: &code,
            device: &device,
            settings: Settings::from_device(&device),
            arithmetic: Arithmetic::Silicon { seed: 0 },
        };
        let told = chips.halo().unwrap_err();
        assert!(told.contains(why), "{told}");
        let kept = kept(1, 64, 64, 6);
        let measure = Measure {
            kept: &kept,
            upsample: None,
            tolerance: 0.5,
            within: Micros(100),
            seed: 0,
            clock: &|| 0.0,
            budget: (0.04, 0.05),
            tiles: Some(30),
            look: None,
            limits_only: false,
        };
        let answer = measure
            .ask(&chips, &chips.candidates(&[Format::F32]))
            .unwrap();
        assert_eq!(answer.choice, chips.machine());
        assert!(answer.why.contains(why) && answer.offers.iter().all(|o| o.change.is_none()));
    }
}
