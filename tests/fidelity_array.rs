//! The pilot on the array: tiles of a program have the events of the whole array, to the bit, errors
//! of the chip included, and limits hold.

use std::{
    collections::HashMap,
    sync::{
        LazyLock,
        atomic::{AtomicU64, Ordering},
    },
};

use amacrine::{
    array::{Arithmetic, Schedule, Settings},
    compare::Pair,
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
    program::{Code, Overrides, Program},
    rng::Hash,
    scene::{Frame, Scene, held::Held, kept::Kept},
    stop::Stop,
    study::{
        design::{Compiled, Design},
        pilot::{
            Change, ChangeEstimate, Chips, ErrorTerm, Family, Grid, History, Look, Machine,
            Measure, Survey, change, draw, estimate::Tile,
        },
        trade::{Ask, Programs, Setup, trade},
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
    shown(Size::new(height, width), frames, |index, y, x| {
        let (dy, dx) = (
            y as f64 - height as f64 / 2.0,
            x as f64 - speed * index as f64,
        );
        let spot = 130.0 * (-(dy * dy + dx * dx) / (2.0 * size * size)).exp();
        let grain = texture * chance(1000 + (y * width + x) as u64 + (index / 3) * 100_000);
        (60.0 + spot + grain).clamp(0.0, 255.0)
    })
}

/// A scene of the light of each frame, row and column.
fn shown(size: Size, frames: u64, light: impl Fn(u64, usize, usize) -> f64) -> Kept {
    let frame = |index: u64| Frame {
        index,
        seconds: index as f64 / 200.0,
        light: Plane::from_shape_fn(size.shape(), |(y, x)| light(index, y, x)).into(),
    };
    let frames = (0..frames).map(frame).collect();
    let mut scene = Held::new(frames, size, 200.0);
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
        reads_all: false,
    }
}

fn whole(chips: &Chips<'_>, machine: &Machine, kept: &Kept) -> Packet {
    let packet = read(chips, machine, kept);
    assert_eq!(packet.dropped.no_slot, 0);
    packet
}

/// What is read of the whole array.
fn read<F: Family>(family: &F, model: &F::Model, kept: &Kept) -> Packet {
    let mut sensor = family.whole(model, kept.size()).unwrap();
    let mut packet = Packet::new(kept.size(), sensor.channels());
    let mut scene = kept.scene();
    while let Some(frame) = scene.next_frame().unwrap() {
        sensor.watch(&frame, &mut packet).unwrap();
    }
    packet
}

/// A program of one kind whose cells fire where light moves by more than a threshold, with so many
/// slots for each sign.
fn snap(slots: usize) -> (Code, Device) {
    let text = format!(
        "//! channels = 1\ninit {{ get_image(A); neg(C, A); }}\nframe {{ get_image(A); scamp5_in(D, -12); bus(NEWS); bus(B, NEWS, A, C); where(B, D); MOV(R6, FLAG); all(); where(A, C, D); MOV(R5, FLAG); WHERE(R5, R6); neg(C, A); all(); scamp5_scan_events(R5, on, {slots}); scamp5_scan_events(R6, off, {slots}); }}"
    );
    let device = Device::scamp5();
    let program = Program::parse("snap", &text).unwrap();
    let code = program.expand(&device, &Overrides::default()).unwrap().code;
    (code, device)
}

fn silicon((code, device): &(Code, Device), reads_all: bool) -> Chips<'_> {
    Chips {
        name: "snap",
        code,
        device,
        settings: Settings::from_device(device),
        arithmetic: Arithmetic::Silicon { seed: 0 },
        reads_all,
    }
}

/// The most events of a sign at one time.
fn busiest(packet: &Packet) -> usize {
    let mut counts = HashMap::new();
    for event in &packet.events {
        *counts.entry((event.t, event.polarity.bit())).or_insert(0) += 1;
    }
    counts.into_values().max().unwrap_or(0)
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
        let pair = Pair::new(&a, &b).unwrap();
        let tiles = change::of_pair(&mosaic, &probabilities, &pair, Micros(100));
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
            reads_all: false,
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

/// Bursts late in a clip, in one frame alone, in one corner alone; slots that are just enough, or one
/// too few.
#[test]
fn a_trade_is_not_fooled_by_slots_that_are_full_in_some_frame() {
    let size = Size::new(60, 72);
    let spot = |index: u64, y: usize, x: usize| {
        let across = (20 + index as usize) % 72;
        60.0 + 90.0 * f64::from(u8::from(y / 6 == 3 && x.abs_diff(across) < 4))
    };
    let spread = Hash::new(3);
    let step = |is_late: bool, is_lit: bool| 45.0 * f64::from(u8::from(is_late && is_lit));
    let late = shown(size, 16, |t, y, x| spot(t, y, x) + step(t >= 12, true));
    let corner = shown(size, 16, |t, y, x| {
        spot(t, y, x) + step(t >= 14, y >= 48 && x >= 60)
    });
    let alone = shown(size, 16, |t, y, x| {
        let lit = spread.with((y * 72 + x) as u64).uniform() < 0.06;
        spot(t, y, x) + step(t == 13, lit)
    });
    let (mut full, mut fitting) = (0, 0);
    for (name, kept) in [("late", late), ("corner", corner), ("alone", alone)] {
        let roomy = snap(4000);
        let roomy = silicon(&roomy, true);
        let most = busiest(&read(&roomy, &roomy.machine(), &kept)).min(4000);
        for slots in [most - 1, most, most / 2] {
            let code = snap(slots);
            let family = Programs {
                chips: silicon(&code, false),
                schedule: Schedule::Plain,
            };
            let survey = Survey {
                kept: &kept,
                upsample: None,
                within: Micros(100),
                seed: 0,
                clock: &|| 0.0,
                sample: 0.3,
                stop: Stop::NEVER,
            };
            let ask = Ask {
                survey,
                models: family.models(&[Format::F32]),
                alternative: &|setup: &Setup| family.alternative(setup),
                free: &|setup: &Setup, _: &_| family.free(setup),
                verify: false,
                runs: 1,
                begin: &|_| (),
            };
            let trade = trade(&family, &ask).unwrap();
            let own = read(&family, &family.full(), &kept);
            assert_eq!(trade.without_slot, own.dropped.no_slot, "{name}, {slots}");
            full += usize::from(trade.without_slot > 0);
            fitting += usize::from(trade.without_slot == 0);
            for point in &trade.points {
                let plain = read(&family, &point.model, &kept);
                let truth = Change::between(&own, &plain, Micros(100)).unwrap().share;
                let limit = point.error();
                assert!(
                    limit.is_none_or(|limit| truth <= limit),
                    "{name}, {slots} slots: {}: {truth}, {limit:?}",
                    point.name
                );
            }
        }
    }
    assert!(full >= 6 && fitting > 0, "{full} {fitting}");
}

/// Where a plainer model just fits into the slots, the full one may lose an event for each change.
#[test]
fn limits_hold_behind_slots() {
    let (mut lost, mut more) = (0, 0);
    let roomy = snap(4000);
    for seed in 0..40u64 {
        let kept = kept(seed, 36, 40, 10);
        let all = silicon(&roomy, true);
        let term = ErrorTerm::ALL[seed as usize % ErrorTerm::ALL.len()];
        let plain = Machine {
            format: (seed % 3 == 0).then_some(Format::F32),
            without: if seed % 3 == 0 { vec![] } else { vec![term] },
        };
        let [a, b] = [all.machine(), plain].map(|machine| whole(&all, &machine, &kept));
        let Change {
            events,
            missing,
            extra,
            share,
        } = Change::between(&a, &b, Micros(100)).unwrap();
        let tile = Tile {
            probability: 1.0,
            events,
            changes: missing + extra,
            ..Tile::default()
        };
        let estimate = ChangeEstimate::new(&[tile], History::Cell.into(), 0.05);
        assert_eq!(estimate.limit, Some(share));
        // As many as the plainer one needs.
        let code = snap(busiest(&b));
        let few = silicon(&code, false);
        let own = read(&few, &few.machine(), &kept);
        let truth = Change::between(&own, &b, Micros(100)).unwrap().share;
        let limit = estimate.behind_slots().limit.unwrap();
        assert!(truth <= limit, "{seed}: {truth} {limit}");
        lost += usize::from(own.dropped.no_slot > 0);
        more += usize::from(truth > share);
    }
    println!("{lost} lose events, {more} change more than before the readout");
    assert!(lost > 5 && more > 2, "{lost} {more}");
}

/// What a pilot says before a run has room for what slots may lose, and says nothing where they are
/// full in a tile.
#[test]
fn a_pilot_counts_what_slots_may_lose() {
    let kept = kept(5, 72, 80, 10);
    let asked = |slots, reads_all| {
        let code = snap(slots);
        let family = silicon(&code, reads_all);
        let measure = Measure {
            kept: &kept,
            upsample: None,
            tolerance: 0.2,
            within: Micros(100),
            seed: 0,
            clock: &|| 0.0,
            budget: (0.0, 0.0),
            tiles: Some(30),
            look: None,
            limits_only: true,
        };
        measure
            .ask(&family, &family.candidates(&[Format::F32]))
            .unwrap()
    };
    let [before, behind] = [true, false].map(|reads_all| asked(4000, reads_all));
    let mut counted = 0;
    for (before, behind) in before.offers.iter().zip(&behind.offers) {
        let want = before.change.map(ChangeEstimate::behind_slots);
        assert_eq!(behind.change, want, "{}", before.what);
        counted += usize::from(want.is_some_and(|change| change.limit > Some(0.0)));
    }
    assert!(counted > 1, "{:?}", before.offers);
    let full = asked(3, false);
    assert!(full.why.contains("full in a tile"), "{}", full.why);
    assert!(full.offers.iter().all(|offer| offer.change.is_none()));
}
