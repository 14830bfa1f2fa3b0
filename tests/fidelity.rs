//! The pilot: tiles have the events of the whole sensor, to the bit; over random scenes and
//! sensors the true change exceeds the limit in at most 5 % of cases; rules that need no
//! measurement are true; and what depends on all of a sensor is not offered.

mod common;

use std::fmt::Write;

use amacrine::{
    compare::Pair,
    event::{Event, Packet, readout::settings},
    mosaic::Mosaic,
    number::Format,
    plane::{At, Plane},
    reference::{Description, Effect, Limit},
    rng::Hash,
    scene::{Frame, OpenOptions, Scene, held::Held, kept::Kept, open},
    study::pilot::{
        Change, ChangeEstimate, Choice, Family, Floats, Grid, History, Look, Model, Plan,
        PlanError, Question, change, draw,
        plan::{BUDGET, plan},
        rule,
    },
    unit::Micros,
};
use proptest::prelude::*;

fn read(text: &str) -> Description {
    Description::parse("fidelity.toml", text, &|_| unreachable!())
        .unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn kept(scene: &mut dyn Scene) -> Kept {
    Kept::new(scene, 1 << 28).unwrap().unwrap()
}

fn pattern(spec: &str) -> Kept {
    kept(&mut *open(spec, &OpenOptions::default()).unwrap())
}

/// Numbers from a seed, one after the other.
struct Chance(Hash, u64);

impl Chance {
    fn new(seed: u64) -> Self {
        Self(Hash::new(seed), 0)
    }

    fn next(&mut self) -> f64 {
        self.1 += 1;
        self.0.nth(self.1).uniform()
    }

    fn below(&mut self, end: usize) -> usize {
        ((self.next() * end as f64) as usize).min(end - 1)
    }

    fn of<T: Clone>(&mut self, list: &[T]) -> T {
        list[self.below(list.len())].clone()
    }
}

/// Scenes of all kinds: what moves everywhere and what moves in a corner, bursts, edges, scenes
/// that hardly change, light that reaches the ends of a range, whole numbers and others.
fn scene(chance: &mut Chance, height: usize, width: usize, frames: u64) -> Kept {
    let kind = chance.of(&[
        "walk", "part", "burst", "edge", "spot", "flash", "slow", "stripes", "ends",
    ]);
    let whole = chance.next() < 0.5;
    let step = 2.0 + 60.0 * chance.next().powi(2);
    let speed = 0.2 + 3.0 * chance.next();
    let burst = 1 + chance.below(frames as usize - 2) as u64;
    let (top, left) = (chance.below(height), chance.below(width));
    let mut light = Plane::from_shape_simple_fn((height, width), || 40.0 + 150.0 * chance.next());
    let mut all = Vec::new();
    let mut seconds = 0.0;
    for index in 0..frames {
        let at = speed * index as f64;
        for ((y, x), light) in light.indexed_iter_mut() {
            let near = y.abs_diff(top) < height / 4 && x.abs_diff(left) < width / 4;
            let walk = step * (chance.next() - 0.5);
            match kind {
                "walk" => *light += walk,
                "part" if near => *light += walk,
                "burst" if index == burst => *light += 4.0 * walk,
                "burst" => *light += 0.1 * walk,
                "edge" => {
                    *light = if (x as f64) < at % width as f64 {
                        30.0
                    } else {
                        200.0
                    }
                }
                "spot" => {
                    let (dy, dx) = (y as f64 - top as f64, x as f64 - at % width as f64);
                    *light = 60.0 + 150.0 * (-(dy * dy + dx * dx) / 18.0).exp();
                }
                "flash" if near && index == burst => *light = 250.0,
                "flash" if near && index == burst + 1 => *light = 60.0,
                "slow" => *light += 0.05 * walk,
                "stripes" => *light = 120.0 + 100.0 * ((x as f64 - at) * 0.7).sin(),
                "ends" => *light += 3.0 * walk,
                _ => {}
            }
            *light = light.clamp(0.0, 255.0);
            if whole {
                *light = light.round();
            }
        }
        all.push(Frame {
            index,
            seconds,
            light: light.clone().into(),
        });
        seconds += if chance.next() < 0.1 { 4e-3 } else { 1e-3 };
    }
    let size = amacrine::plane::Size::new(height, width);
    kept(&mut Held::new(all, size, 1000.0))
}

/// Whole sensors, all of whose parts vary; only those that have tiles.
fn sensor(chance: &mut Chance) -> Description {
    let response = chance.of(&[
        "{ linear = 255 }",
        "{ linear = 255 }",
        "{ lin-log = { knee = 20 } }",
        "{ log = { white = 255, offset = 1e-3 } }",
        "\"identity\"",
        "{ linear = { white = 255, round = \"f32\" } }",
    ]);
    let memory = chance.of(&[
        "memory = \"filtered-step\"",
        "memory = \"filtered-step\"\nrefractory = { us = 300 }",
        "memory = \"filtered-step\"\nrefractory = { us = 2500 }",
        "memory = \"filtered-step\"\nborder = \"zero\"",
        "memory = \"filtered-snap\"",
        "memory = \"filtered-snap\"\npolarity = \"pixel\"\nrefractory = { us = 1500 }",
        "memory = \"raw-snap\"",
        "memory = \"authors-pixel-step\"",
        "memory = \"filtered-step\"\nrefractory = { us = 300, rule = \"authors\" }",
    ]);
    let pixels = memory.contains("raw-snap") || memory.contains("authors-pixel");
    let mut noise: Vec<&str> = Vec::new();
    for key in [
        "shot-hz = 3\nshot-at-white = 0.25",
        "hot-fraction = 0.02\nhot-hz = 50",
        "jitter-us = 60",
        "cutoff-hz = 200",
        "leak-hz = 5\nleak-spread = 0.2",
    ] {
        let leaks = key.starts_with("leak") && (pixels || memory.contains("authors"));
        if chance.next() < 0.25 && !leaks {
            noise.push(key);
        }
    }
    let scale = if response == "\"identity\"" {
        255.0
    } else {
        1.0
    };
    let mut text = format!(
        "response = {response}\n{memory}\n[noise]\n{}\n",
        noise.join("\n")
    );
    for _ in 0..=chance.below(2) {
        let channel = chance.of(&[
            "kernel = \"csdvs-3\"",
            "kernel = \"csdvs-5\"",
            "kernel = \"dvs\"",
            "kernel = \"dvs\"\nlog-temporal = true",
            "kernel = [[0, -0.3, 0.1], [0.2, 1, -1], [0.3, -0.7, 0.4]]",
            "pattern = \"2x2\"\nkernel = [\"dvs\", \"sobel-x\", \"csdvs-3\", \"sobel-y\"]",
        ]);
        let logarithmic = response.contains("log =");
        let channel = if pixels || (memory.contains("zero") && logarithmic) {
            "kernel = \"dvs\""
        } else {
            channel
        };
        let channel = if memory.contains("authors-pixel") {
            "kernel = \"dvs\"\nmemory-kernel = \"dvs\""
        } else {
            channel
        };
        let on = chance.of(&[0.02, 0.05, 0.1, 0.2]) * scale;
        let off = on * chance.of(&[1.0, 1.0, 0.7, 1.3]);
        let sigma = on * chance.of(&[0.0, 0.0, 0.01, 0.1]);
        let one = format!("{{ on = {on}, off = {off}, sigma = {sigma} }}");
        let thresholds = if channel.contains("pattern") {
            format!(
                "[{one}, {one}, {{ on = {}, off = {off} }}, {one}]",
                2.0 * on
            )
        } else {
            one
        };
        let _ = writeln!(text, "[[channel]]\n{channel}\nthreshold = {thresholds}");
    }
    if memory.contains("zero") {
        text = text.replace("{ lin-log = { knee = 20 } }", "{ linear = 255 }");
        text = text.replace(
            "{ log = { white = 255, offset = 1e-3 } }",
            "{ linear = 255 }",
        );
    }
    read(&text)
}

/// A random model that leaves something out.
fn plainer(chance: &mut Chance, description: &Description, inserts: bool) -> Choice {
    let there: Vec<Effect> = Effect::ALL
        .iter()
        .copied()
        .filter(|effect| effect.is_in(description, inserts))
        .collect();
    let format = |name: &str| -> Format { name.parse().unwrap() };
    if there.is_empty() || chance.next() < 0.5 {
        let names = [
            "f32", "f16", "bf16", "q8.8", "q16.16", "q10.6", "q4.12", "q1.15", "q2.6",
        ];
        return Choice {
            format: format(chance.of(&names)),
            without: Vec::new(),
        };
    }
    Choice::full().and_without(chance.of(&there))
}

fn question(description: &Description, seed: u64) -> Question<'_> {
    Question {
        description,
        seed,
        tolerance: 0.01,
        within: Micros(100),
        formats: &[Format::F32],
        upsample: None,
        readout: None,
        crop: false,
        looks_anyway: false,
        budget: BUDGET,
        tiles: None,
    }
}

/// A model on the whole sensor; none where its numbers cannot hold the scene.
fn whole(question: &Question<'_>, choice: &Choice, kept: &Kept) -> Option<Packet> {
    let model = Model {
        choice: choice.clone(),
        ..Model::full(question, Limit::default())
    };
    model.run(kept.scene(), || ()).ok()
}

/// All tiles of a sensor as one mosaic.
fn all_tiles(kept: &Kept, side: usize, halo: usize, across: usize) -> Mosaic {
    let grid = Grid {
        size: kept.size(),
        side,
    };
    let corners = (0..grid.tiles()).map(|tile| grid.corner(tile)).collect();
    let tile = amacrine::plane::Size::new(side, side);
    Mosaic::new(grid.size, tile, halo, corners, across)
}

/// The events of the tiles at their places in the whole sensor, in one order.
fn at_home(mosaic: &Mosaic, packet: &Packet) -> Vec<(u64, u16, u16, u8, u8)> {
    let own = |event: &&Event| mosaic.tile(event.y.into(), event.x.into()).is_some();
    let home = |event: &Event| {
        let At { y, x } = mosaic.home(event.y.into(), event.x.into());
        (
            event.t.0,
            y as u16,
            x as u16,
            event.channel,
            event.polarity.bit(),
        )
    };
    let mut events: Vec<_> = packet.events.iter().filter(own).map(home).collect();
    events.sort_unstable();
    events
}

fn sorted(packet: &Packet) -> Vec<(u64, u16, u16, u8, u8)> {
    let key = |e: &Event| (e.t.0, e.y, e.x, e.channel, e.polarity.bit());
    let mut events: Vec<_> = packet.events.iter().map(key).collect();
    events.sort_unstable();
    events
}

/// A case that was found.
#[test]
fn a_case_of_tiles() {
    let seed = 8_345_838_846_371_720_426;
    tiles_are_the_sensor(seed, 1, false).unwrap();
}

/// What a model says on tiles.
fn watched_on(family: &Floats<'_>, choice: &Choice, mosaic: &Mosaic, kept: &Kept) -> Packet {
    let mut tiles = family.on_tiles(choice, mosaic).unwrap();
    let mut packet = Packet::new(tiles.size(), tiles.channels());
    let mut scene = kept.scene();
    while let Some(frame) = scene.next_frame().unwrap() {
        let light = mosaic.shown(&frame.light, family.outside()).into();
        tiles.watch(&Frame { light, ..frame }, &mut packet).unwrap();
    }
    packet
}

fn tiles_are_the_sensor(seed: u64, across: usize, fine: bool) -> Result<(), TestCaseError> {
    let chance = &mut Chance::new(seed);
    let (height, width) = (5 + chance.below(26), 5 + chance.below(34));
    let kept = scene(chance, height, width, 8);
    let description = sensor(chance);
    let choice = if fine {
        Choice::full()
    } else {
        plainer(chance, &description, false)
    };
    let question = question(&description, seed);
    let base = Choice::full();
    let family = Floats {
        description: &description,
        seed,
        base: &base,
    };
    let halo = family.halo().unwrap();
    let mosaic = all_tiles(&kept, 2 * (1 + chance.below(4)), halo, across);
    if let Some(full) = whole(&question, &choice, &kept) {
        let packet = watched_on(&family, &choice, &mosaic, &kept);
        let (some, all) = (at_home(&mosaic, &packet), sorted(&full));
        let first = some.iter().zip(&all).find(|(a, b)| a != b);
        prop_assert!(
            some == all,
            "{choice}: first {first:?} of {} and {}\n{description:?}",
            some.len(),
            all.len()
        );
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// The events of all tiles, each with its halo, are those of the whole sensor: at the border
    /// and inside, with all noise, for any number of tiles in a row of the mosaic.
    #[test]
    fn tiles_have_the_events_of_the_whole_sensor(seed: u64, across in 1usize..9, fine: bool) {
        tiles_are_the_sensor(seed, across, fine)?;
    }
}

/// What a halo is for: half of it is not enough.
#[test]
fn a_smaller_halo_shows() {
    let description = read(
        "response = { linear = 255 }\nmemory = \"filtered-step\"\n[[channel]]\nkernel = \"csdvs-5\"\nthreshold = { on = 0.02, off = 0.02 }",
    );
    let base = Choice::full();
    let family = Floats {
        description: &description,
        seed: 1,
        base: &base,
    };
    let kept = scene(&mut Chance::new(5), 24, 24, 8);
    let full = whole(&question(&description, 1), &base, &kept).unwrap();
    assert_eq!(family.halo(), Ok(2));
    let same = |halo| {
        let mosaic = all_tiles(&kept, 4, halo, 3);
        let packet = watched_on(&family, &base, &mosaic, &kept);
        at_home(&mosaic, &packet) == sorted(&full)
    };
    assert!(!full.events.is_empty() && same(2) && !same(0));
}

/// One case of the coverage: the share that changes, and the limit of a sample.
struct Case {
    name: String,
    truth: f64,
    estimate: ChangeEstimate,
}

/// What a pilot of so many tiles would say; the tiles' events are those of the whole sensor, so
/// they are taken from it.
fn sampled(
    (full, plain): (&Packet, &Packet),
    kept: &Kept,
    family: &Floats<'_>,
    (choice, side, count, seed): (&Choice, usize, usize, u64),
) -> ChangeEstimate {
    let look = Look::new(
        kept,
        Grid {
            size: kept.size(),
            side,
        },
        family.is_relative(),
    );
    let mut activity = look.seen_from(family.halo().unwrap());
    if family.fires_alone() {
        for tile in &mut activity {
            *tile = tile.max(0.0);
        }
    }
    let drawn = draw::draw(&activity, &look.extremes, count, seed);
    let grid = look.grid;
    // The whole sensor as a mosaic of one row of tiles after the other.
    let mut probabilities = vec![f64::NAN; grid.tiles()];
    for one in &drawn {
        probabilities[one.tile] = one.probability;
    }
    let across = grid.size.width.div_ceil(side);
    let mosaic = all_tiles(kept, side, 0, across);
    let pair = Pair::new(full, plain).unwrap();
    let tiles = change::of_pair(&mosaic, &probabilities, &pair, Micros(100));
    let tiles: Vec<_> = tiles
        .into_iter()
        .filter(|tile| !tile.probability.is_nan())
        .collect();
    ChangeEstimate::new(&tiles, family.unseen(choice, &look), 0.05)
}

/// The heart of it: 320 random cases of the float model, each with a sample of its own; more than
/// one in twenty above its limit would fail. Where the sample says nothing, there is nothing to
/// hold.
#[test]
fn limits_hold_in_nineteen_of_twenty_cases() {
    let mut cases = Vec::new();
    for seed in 0..320 {
        let chance = &mut Chance::new(1000 + seed);
        let (height, width) = (40 + 4 * chance.below(9), 40 + 4 * chance.below(12));
        let kept = scene(chance, height, width, 16);
        let description = sensor(chance);
        let inserts = chance.next() < 0.25;
        let choice = plainer(chance, &description, inserts);
        let mut question = question(&description, seed);
        question.upsample = inserts.then_some(0.3);
        let Some(full) = whole(&question, &Choice::full(), &kept) else {
            continue;
        };
        let Some(plain) = whole(&question, &choice, &kept) else {
            continue;
        };
        let base = Choice::full();
        let family = Floats {
            description: &description,
            seed,
            base: &base,
        };
        let side = chance.of(&[4, 8]);
        let count = 12 + chance.below(30);
        let truth = Change::between(&full, &plain, Micros(100)).unwrap().share;
        let how = (&choice, side, count, seed);
        cases.push(Case {
            name: format!("{seed}: {choice} {}x{}", kept.size(), side),
            truth,
            estimate: sampled((&full, &plain), &kept, &family, how),
        });
    }
    let with: Vec<&Case> = cases
        .iter()
        .filter(|case| case.estimate.limit.is_some())
        .collect();
    let above = |case: &&&Case| case.truth > case.estimate.limit.unwrap();
    let failed: Vec<_> = with.iter().filter(above).collect();
    for case in &failed {
        println!("{}: {:.5}, {:?}", case.name, case.truth, case.estimate);
    }
    let changed = with.iter().filter(|case| case.truth > 0.0).count();
    let mut looseness: Vec<f64> = with
        .iter()
        .filter(|case| case.truth > 0.0)
        .map(|case| case.estimate.limit.unwrap() / case.truth)
        .collect();
    looseness.sort_by(f64::total_cmp);
    println!(
        "{} cases, {} with a limit, {changed} with a change, {} above; the median limit is {:.2} times the change",
        cases.len(),
        with.len(),
        failed.len(),
        looseness[looseness.len() / 2]
    );
    assert!(with.len() >= 250, "{}", with.len());
    assert!(
        20 * failed.len() <= with.len(),
        "{} of {}",
        failed.len(),
        with.len()
    );
    // No empty words: of those that change, none would be a test.
    assert!(changed >= 100 && looseness[looseness.len() / 2] < 4.0);
}

/// Rules that need no measurement are true.
#[test]
fn what_is_free_changes_nothing() {
    let mut frames = 0;
    for seed in 0..300 {
        let chance = &mut Chance::new(90_000 + seed);
        let kept = scene(chance, 16, 20, 8);
        let mut description = sensor(chance);
        if seed % 2 == 0 {
            description.noise = amacrine::reference::Noise::NONE;
        }
        let mut asked = question(&description, seed);
        asked.upsample = Some(0.2);
        let change = |effect| {
            let full = whole(&asked, &Choice::full(), &kept)?;
            let plain = whole(&asked, &Choice::full().and_without(effect), &kept)?;
            Some(Change::between(&full, &plain, Micros(100)).unwrap())
        };
        if rule::needs_no_inserted_frames(&description).is_some()
            && let Some(change) = change(Effect::InsertedFrames)
        {
            frames += usize::from(change.events > 0);
            assert!(change.share < 2e-3, "{seed}: {change:?}");
        }
    }
    assert!(frames > 10, "{frames}");
}

/// As is the rule of the dead time, up to its end: with a little longer one, some events change.
#[test]
fn no_crossings_are_closer_than_the_rule_says() {
    let (mut free, mut events, mut close) = (0, 0, 0);
    for seed in 0..200 {
        let chance = &mut Chance::new(50_000 + seed);
        let kept = scene(chance, 12, 14, 10);
        let kernel = chance.of(&["dvs", "csdvs-3"]);
        let (on, off) = (0.02 + 0.1 * chance.next(), 0.02 + 0.1 * chance.next());
        let text = |us: f64| {
            format!(
                "response = {{ linear = 255 }}\nmemory = \"filtered-step\"\nrefractory = {{ us = {us} }}\n[[channel]]\nkernel = \"{kernel}\"\nthreshold = {{ on = {on}, off = {off} }}"
            )
        };
        let look = Look::new(
            &kept,
            Grid {
                size: kept.size(),
                side: 4,
            },
            false,
        );
        let is_free = |us: f64| rule::has_no_close_crossings(&read(&text(us)), &look);
        // The longest dead time that is free, by halves.
        let (mut least, mut most) = (0.0, 1e5);
        for _ in 0..30 {
            let middle = f64::midpoint(least, most);
            if is_free(middle) {
                least = middle;
            } else {
                most = middle;
            }
        }
        for (us, is_free) in [(least, true), (20.0 * least, false)] {
            let description = read(&text(us));
            let asked = question(&description, seed);
            let full = whole(&asked, &Choice::full(), &kept).unwrap();
            let plain =
                whole(&asked, &Choice::full().and_without(Effect::DeadTime), &kept).unwrap();
            let change = Change::between(&full, &plain, Micros(0)).unwrap();
            if is_free {
                assert_eq!(change.share, 0.0, "{seed}: {us} us, {change:?}");
                (free, events) = (free + usize::from(us > 0.0), events + change.events);
            } else {
                close += usize::from(change.share > 0.0);
            }
        }
    }
    assert!(
        free > 100 && events > 10_000 && close > 20,
        "{free} {events} {close}"
    );
}

/// A scene that never reaches the ends of a format's range does not saturate it.
#[test]
fn what_cannot_saturate_does_not() {
    let description = read(
        "response = \"identity\"\nmemory = \"filtered-step\"\n[[channel]]\nkernel = \"csdvs-3\"\nthreshold = { on = 5, off = 5 }",
    );
    let unequal = read(
        "response = \"identity\"\nmemory = \"filtered-step\"\n[[channel]]\nkernel = \"csdvs-3\"\nthreshold = { on = 5, off = 4 }",
    );
    for (high, may) in [(25, false), (250, true)] {
        let kept = pattern(&format!(
            "pattern:edge?width=32&height=16&frames=20&fps=1000&speed=500&low=1&high={high}"
        ));
        let look = Look::new(
            &kept,
            Grid {
                size: kept.size(),
                side: 4,
            },
            false,
        );
        let format: Format = "q8.8".parse().unwrap();
        // csdvs-3 is 1 and eight of -1/8: a drive of at most twice the light, a distance of twice
        // that.
        assert_eq!(rule::may_saturate(format, &description, &look), may);
        assert!(!rule::may_saturate(Format::F32, &description, &look));
        // Steps of two sizes are counted, and their sums may go anywhere.
        assert!(rule::may_saturate(format, &unequal, &look));
        assert!(!rule::may_saturate(Format::F32, &unequal, &look));
        let question = question(&description, 0);
        let choice = Choice {
            format,
            without: Vec::new(),
        };
        let full = whole(&question, &Choice::full(), &kept).unwrap();
        let plain = whole(&question, &choice, &kept).unwrap();
        let change = Change::between(&full, &plain, Micros(100)).unwrap();
        assert!(
            change.events > 100 && (may || change.share < 0.5),
            "{change:?}"
        );
    }
}

fn planned(question: &Question<'_>, kept: &Kept) -> Plan {
    let start = std::time::Instant::now();
    plan(question, Some(kept), &|| start.elapsed().as_secs_f64()).unwrap()
}

#[test]
fn no_tolerance_is_the_full_model() {
    let description = read(
        "response = { linear = 255 }\nmemory = \"filtered-step\"\n[[channel]]\nkernel = \"dvs\"\nthreshold = { on = 0.1, off = 0.1 }",
    );
    let kept = pattern("pattern:disc?width=40&height=40&frames=9&radius=4");
    let mut asked = question(&description, 0);
    asked.tolerance = 0.0;
    assert_eq!(planned(&asked, &kept).choice, Choice::full());
    for tolerance in [-0.1, 1.1, f64::NAN] {
        asked.tolerance = tolerance;
        assert!(matches!(
            plan(&asked, Some(&kept), &|| 0.0),
            Err(PlanError::Tolerance(_))
        ));
    }
}

/// With so many tiles as make the sample the sensor, the plan leaves out what changes nothing,
/// and keeps what does.
#[test]
fn a_plan_keeps_what_matters() {
    let text = |keys: &str| {
        format!(
            "response = {{ lin-log = {{ knee = 20 }} }}\nmemory = \"filtered-step\"\n{keys}\n[[channel]]\nkernel = \"csdvs-3\"\nthreshold = {{ on = 0.02, off = 0.02 }}"
        )
    };
    let kept = pattern("pattern:noise?width=64&height=64&frames=24&fps=1000&speed=300");
    for (keys, effect) in [
        ("refractory = { us = 5000 }", Effect::DeadTime),
        ("noise = { shot-hz = 200 }", Effect::NoiseEvents),
    ] {
        let description = read(&text(keys));
        let mut asked = question(&description, 3);
        asked.tiles = Some(60);
        let plan = planned(&asked, &kept);
        assert!(!plan.choice.leaves_out(effect), "{plan:?}");
        let offer = plan
            .offers
            .iter()
            .find(|offer| offer.model.leaves_out(effect))
            .unwrap();
        assert!(
            offer.change.is_some_and(|change| change.share > 0.02),
            "{offer:?}"
        );
        let digits = plan
            .offers
            .iter()
            .find(|offer| offer.model.format == Format::F32)
            .unwrap();
        assert!(
            digits.change.is_some_and(|change| change.is_within(0.01)),
            "{digits:?}"
        );
    }
}

/// A pilot spends what it may, by its own clock, and hands over to the full model when there is
/// nothing to win.
#[test]
fn a_pilot_stops_when_it_does_not_pay() {
    let description = read(
        "response = { linear = 255 }\nmemory = \"filtered-step\"\n[[channel]]\nkernel = \"dvs\"\nthreshold = { on = 0.1, off = 0.1 }",
    );
    let kept = pattern("pattern:noise?width=64&height=64&frames=24&fps=1000&speed=300");
    let asked = question(&description, 0);
    // A clock on which every model takes as long as every other.
    let ticks = std::sync::atomic::AtomicU64::new(0);
    let clock = || ticks.fetch_add(1, std::sync::atomic::Ordering::Relaxed) as f64;
    let without_time = plan(&asked, Some(&kept), &clock).unwrap();
    let why = &without_time.why;
    assert!(
        why.contains("is too short for a look at the scene"),
        "{why}"
    );
    let mut asked = asked;
    asked.budget = (0.0, 1e9);
    let with_time = plan(&asked, Some(&kept), &clock).unwrap();
    let why = &with_time.why;
    assert!(why.contains("nothing to win"), "{why}");
    for plan in [without_time, with_time] {
        assert_eq!(plan.choice, Choice::full());
        let mut offers = plan.offers.iter();
        assert!(offers.all(|offer| offer.change.is_none() && !offer.left_out));
    }
}

/// What is within the tolerance and no quicker than the full model is not chosen, also where so many
/// tiles are asked for that nothing is dropped on the way.
#[test]
fn no_slower_model_is_chosen() {
    let description = read(
        "response = { lin-log = { knee = 20 } }\nmemory = \"filtered-step\"\n[[channel]]\nkernel = \"csdvs-3\"\nthreshold = { on = 0.02, off = 0.02 }",
    );
    let kept = pattern("pattern:noise?width=64&height=64&frames=24&fps=1000&speed=300");
    let mut asked = question(&description, 3);
    asked.tiles = Some(60);
    // A clock on which all takes as long.
    let plan = plan(&asked, Some(&kept), &|| 0.0).unwrap();
    assert!(plan.offers[0].change.unwrap().is_within(0.01), "{plan:?}");
    assert_eq!((plan.choice, plan.change), (Choice::full(), None));
    assert!(!plan.offers[0].left_out);
    assert!(plan.why.contains("saves enough"), "{}", plan.why);
}

/// Noise, and a square of few levels in it, whose steps are exactly the threshold: rounding decides
/// there, and nowhere else.
fn drawn_square(chance: &mut Chance, side: usize) -> Kept {
    const SIZE: usize = 64;
    let corner = [0, 1].map(|_| chance.below(SIZE - side));
    let mut noise = Plane::from_shape_simple_fn((SIZE, SIZE), || 30.0 + 190.0 * chance.next());
    let mut step = Plane::from_shape_simple_fn((side, side), || 1.0 + chance.below(4) as f64);
    let frames = (0..60).map(|index| {
        for light in &mut noise {
            if chance.next() < 0.06 {
                *light = 10.0 + 235.0 * chance.next();
            }
        }
        for step in &mut step {
            if chance.next() < 0.09 {
                let up = if chance.next() < 0.5 { 1.0 } else { -1.0 };
                *step += if (1.0..=4.0).contains(&(*step + up)) {
                    up
                } else {
                    -up
                };
            }
        }
        let mut light = noise.mapv(f64::round);
        for ((y, x), step) in step.indexed_iter() {
            light[(corner[0] + y, corner[1] + x)] = 51.0 * step;
        }
        // The darkest and the brightest light, and the largest change, lie elsewhere.
        light[(0, 0)] = 0.0;
        light[(0, 5)] = if index % 2 == 0 { 255.0 } else { 0.0 };
        Frame {
            index,
            seconds: index as f64 / 100.0,
            light: light.into(),
        }
    });
    let size = amacrine::plane::Size::new(SIZE, SIZE);
    kept(&mut Held::new(frames.collect(), size, 100.0))
}

/// Also where only a drawn square of 2 to 6 % of the picture changes.
#[test]
fn limits_hold_where_rounding_decides_in_one_place() {
    let description = read(
        "response = { linear = 255 }\nmemory = \"filtered-snap\"\n[[channel]]\nkernel = \"dvs\"\nthreshold = { on = 0.2, off = 0.2 }",
    );
    let base = Choice::full();
    let (mut above, mut cases) = (0, 0);
    for seed in 0..40 {
        let chance = &mut Chance::new(7_000 + seed);
        let side = 9 + chance.below(8);
        let kept = drawn_square(chance, side);
        let asked = question(&description, seed);
        let full = whole(&asked, &base, &kept).unwrap();
        let family = Floats {
            description: &description,
            seed,
            base: &base,
        };
        let format = chance.of(&["f32", "f16", "q16.16"]).parse().unwrap();
        let choice = Choice {
            format,
            without: Vec::new(),
        };
        let plain = whole(&asked, &choice, &kept).unwrap();
        let truth = Change::between(&full, &plain, Micros(100)).unwrap().share;
        assert!(truth > 0.005, "{truth}");
        let how = (&choice, 4, 38, seed);
        let estimate = sampled((&full, &plain), &kept, &family, how);
        cases += 1;
        if truth > estimate.limit.unwrap() {
            println!("{seed}: {format} {truth:.4}, {estimate:?}");
            above += 1;
        }
    }
    println!("{above} of {cases}");
    assert!(20 * above <= cases, "{above} of {cases}");
}

/// What depends on all of the sensor is not offered.
#[test]
fn what_has_no_tiles_is_the_full_model() {
    let kept = pattern("pattern:noise?width=64&height=64&frames=24&fps=1000&speed=300");
    let text = |memory: &str, channel: &str| {
        format!(
            "response = {{ linear = 255 }}\nmemory = \"{memory}\"\n[[channel]]\n{channel}\nthreshold = {{ on = 0.1, off = 0.1 }}"
        )
    };
    for (memory, channel) in [
        ("filtered-step", "mesh = { lambda = 3 }"),
        ("raw-snap", "kernel = \"csdvs-3\""),
        ("raw-snap\"\nshared = true # \"", "kernel = \"csdvs-3\""),
    ] {
        let description = read(&text(memory, channel));
        let mut asked = question(&description, 0);
        asked.tiles = Some(60);
        let plan = planned(&asked, &kept);
        assert_eq!(plan.choice, Choice::full());
        assert!(plan.offers.iter().all(|offer| offer.change.is_none()));
        assert!(!asked.looks());
    }
    let description = read(&text("filtered-step", "kernel = \"dvs\""));
    let mut asked = question(&description, 0);
    let mut arbiter = settings::Description::shipped("arbiter").unwrap();
    arbiter.set("link", "20ns").unwrap();
    asked.readout = Some(arbiter.readout().unwrap());
    assert_eq!(planned(&asked, &kept).choice, Choice::full());
}

fn data(name: &str) -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/fidelity")
        .join(name)
}

fn of_file(scene: &str, sensor: &str, fps: f64) -> (Kept, Description) {
    let options = OpenOptions {
        fps: Some(fps),
        ..OpenOptions::default()
    };
    let path = data(scene).display().to_string();
    let text = std::fs::read_to_string(data(sensor)).unwrap();
    (kept(&mut *open(&path, &options).unwrap()), read(&text))
}

/// A slow arbiter with a short queue: derived bounds once said 0 %, and 78 % changed.
#[test]
fn a_queue_that_overflows_is_left_alone() {
    let (kept, description) = of_file("arb.npy", "id.toml", 10.0);
    let mut arbiter = settings::Description::shipped("arbiter").unwrap();
    for (key, value) in [
        ("link", "10us"),
        ("fifo", "100"),
        ("when-full", "drop-newest"),
        ("row", "0ns"),
        ("event", "1ns"),
    ] {
        arbiter.set(key, value).unwrap();
    }
    let mut asked = question(&description, 0);
    (asked.within, asked.readout) = (Micros(10_000), Some(arbiter.readout().unwrap()));
    (asked.tolerance, asked.crop) = (1.0, true);
    let plan = planned(&asked, &kept);
    let full = Model::full(&asked, Limit::default())
        .run(kept.scene(), || ())
        .unwrap();
    let plain = Model::planned(&asked, &plan, Limit::default())
        .run(kept.scene(), || ())
        .unwrap();
    assert!(full.events.len() > 50);
    assert_eq!(full.events, plain.events);
}

/// A format that saturates. Thresholds that are far apart once ran away in a format that holds
/// light and thresholds: derived bounds said 2.6 %, and 24 % changed.
#[test]
fn a_format_that_saturates_is_seen() {
    let (kept, description) = of_file("fx2.npy", "fx.toml", 10.0);
    let formats: [Format; 2] = ["q4.4", "q8.8"].map(|name| name.parse().unwrap());
    let mut asked = question(&description, 0);
    (asked.within, asked.formats) = (Micros(10_000), &formats[..1]);
    // On a busy machine a look may seem too dear.
    asked.looks_anyway = true;
    let full = whole(&asked, &Choice::full(), &kept).unwrap();
    let [choice, wide] = formats.map(|format| Choice {
        format,
        without: Vec::new(),
    });
    let truth = |choice: &Choice| {
        let plain = whole(&asked, choice, &kept).unwrap();
        Change::between(&full, &plain, asked.within).unwrap().share
    };
    let [narrow, held] = [&choice, &wide].map(truth);
    assert!(narrow > 0.2 && held < 0.01, "{narrow} {held}");
    for tiles in [None, Some(12), Some(1000)] {
        asked.tiles = tiles;
        let plan = planned(&asked, &kept);
        assert_eq!(plan.choice, Choice::full(), "{plan:?}");
        let limit = plan.offers[0].change.and_then(|change| change.limit);
        assert!(limit.is_none_or(|limit| limit > 0.2), "{plan:?}");
    }
    let look = Look::new(
        &kept,
        Grid {
            size: kept.size(),
            side: 4,
        },
        false,
    );
    let base = Choice::full();
    let family = Floats {
        description: &description,
        seed: 0,
        base: &base,
    };
    assert_eq!(family.unseen(&choice, &look), History::Tile.into());
}

/// A window of the array holds all events, to the bit, mismatch and jitter included.
#[test]
fn still_surroundings_go_without_a_trace() {
    let description = read(
        "response = { lin-log = { knee = 20 } }\nmemory = \"raw-snap\"\nnoise = { jitter-us = 50 }\n[[channel]]\npattern = \"2x2\"\nkernel = [\"csdvs-5\", \"sobel-x\", \"csdvs-3\", \"dog\"]\nthreshold = [{ on = 0.1, off = 0.1, sigma = 0.02 }, { on = 0.2, off = 0.1 }, { on = 0.05, off = 0.1 }, { on = 0.1, off = 0.3 }]",
    );
    let frames: Vec<Frame> = (0..8_u64)
        .map(|index| {
            let light = |(y, x): (usize, usize)| {
                let moves = (33..36).contains(&y) && (41..47).contains(&x);
                let more = if moves {
                    (index * 30) as f64 % 90.0
                } else {
                    0.0
                };
                100.0 + (7 * y + 3 * x) as f64 % 50.0 + more
            };
            Frame {
                index,
                seconds: index as f64 * 1e-3,
                light: Plane::from_shape_fn((70, 80), light).into(),
            }
        })
        .collect();
    let kept = kept(&mut Held::new(
        frames,
        amacrine::plane::Size::new(70, 80),
        1000.0,
    ));
    let mut asked = question(&description, 4);
    (asked.within, asked.crop) = (Micros(0), true);
    // On a busy machine a look may seem too dear.
    asked.looks_anyway = true;
    let plan = planned(&asked, &kept);
    assert_eq!(
        plan.choice,
        Choice::full().and_without(Effect::Surroundings)
    );
    let full = Model::full(&asked, Limit::default())
        .run(kept.scene(), || ())
        .unwrap();
    let plain = Model::planned(&asked, &plan, Limit::default())
        .run(kept.scene(), || ())
        .unwrap();
    assert!(full.events.len() > 50, "{}", full.events.len());
    assert_eq!(full.events, plain.events);
    assert_eq!((full.size, full.channels), (plain.size, plain.channels));
}

mod command {
    use std::path::Path;

    use crate::common;

    fn here() -> &'static Path {
        Path::new(env!("CARGO_MANIFEST_DIR"))
    }

    const SCENE: &str = "--scene pattern:disc?width=40&height=30&frames=20&fps=1000&speed=300 --sensor sensors/dvs-v2e.toml";

    fn words(text: &str) -> Vec<&str> {
        text.split_whitespace().collect()
    }

    #[test]
    fn a_plan_is_printed_run_and_verified() {
        let sensor = SCENE.replace("dvs-v2e", "csdvs");
        let text = common::good(here(), &words(&format!("plan {sensor} --verify")));
        for part in [
            "scene",
            "without",
            "at most",
            "dead time",
            "plan ",
            "the scene's frames and the readout included",
            "verified",
            "nothing is left out",
        ] {
            assert!(text.contains(part), "{part} is not in\n{text}");
        }
        let json = common::json(here(), &words(&format!("plan {sensor} --verify")));
        assert_eq!(json["verified"]["held"], true);
        assert!(json["choice"]["format"].is_string() && json["offers"].is_array());
    }

    /// Two runs of one model say nothing of speed.
    #[test]
    fn a_plan_that_leaves_nothing_out_is_no_faster() {
        let ask = format!("plan {SCENE} --tolerance 0%");
        let choice = &common::json(here(), &words(&ask))["choice"];
        assert_eq!(choice, &serde_json::json!({"format": "f64", "without": []}));
        let text = common::good(here(), &words(&format!("{ask} --verify")));
        assert!(
            text.contains("nothing is left out, so that there are no times"),
            "{text}"
        );
        assert!(!text.contains("times as fast"), "{text}");
    }

    #[test]
    fn a_run_says_what_it_left_out() {
        let run = "run --scene pattern:noise?width=48&height=40&frames=12&fps=100&speed=300 --sensor sensors/laplacian.toml --upsample 0.05";
        let full = common::json(here(), &words(run));
        let auto = format!("{run} --fidelity auto --tolerance 1%");
        let auto = common::json(here(), &words(&auto));
        assert!(full["fidelity"].is_null());
        assert_eq!(auto["fidelity"]["tolerance"], 0.01);
        let events = |json: &serde_json::Value| json["events"].as_f64().unwrap();
        assert!((events(&full) - events(&auto)).abs() <= 0.01 * events(&full));
        assert!(auto["frames"].as_u64() <= full["frames"].as_u64());
        let text = common::good(here(), &words(&format!("{run} --fidelity auto")));
        assert!(text.contains("plan "), "{text}");
    }

    /// The events of the rows and columns that are left are those of the whole, in their places.
    #[test]
    fn a_run_is_cut_to_where_something_changes() {
        let folder = tempfile::tempdir().unwrap();
        let here = folder.path();
        let clip = ndarray::Array3::from_shape_fn((9, 90, 120), |(t, y, x)| {
            let moves = (60..75).contains(&y) && (81..99).contains(&x);
            let step = if moves { 31 * t } else { 0 };
            ((7 * y + 13 * x + step) % 200) as f64
        });
        ndarray_npy::write_npy(here.join("c.npy"), &clip).unwrap();
        // By cell, each in the order of its times.
        let events = |path: &str| {
            let read = amacrine::event::file::read(&here.join(path)).unwrap();
            let mut events = read.packet.events;
            events.sort_by_key(|it| (it.y, it.x, it.channel, it.t));
            events
        };
        for sensor in ["rgc-4", "orientation", "dvs"] {
            let run = format!("run --scene c.npy --fps 100 --sensor {sensor}");
            common::good(here, &words(&format!("{run} --events full.npy")));
            // So little that no sample allows more than what is free.
            let planned = format!("{run} --fidelity auto --tolerance 0.001%");
            let listed = format!("{planned} --events auto.npy");
            // On a busy machine a look may seem too dear.
            let cut = (0..9).find_map(|_| {
                let told = common::json(here, &words(&listed));
                (!told["fidelity"]["window"].is_null()).then_some(told)
            });
            let told = cut.unwrap();
            let (rows, columns) = (
                &told["fidelity"]["window"][0],
                &told["fidelity"]["window"][1],
            );
            assert!(rows["start"].as_u64().unwrap() >= 48, "{rows}");
            assert!(columns["end"].as_u64().unwrap() <= 111, "{columns}");
            let (full, auto) = (events("full.npy"), events("auto.npy"));
            assert!(!full.is_empty());
            assert_eq!(auto.len(), full.len(), "{sensor}");
            // Where all tiles are in the sample, f32 may be known to move events by less.
            for (auto, full) in auto.iter().zip(&full) {
                let place = |it: &amacrine::event::Event| (it.y, it.x, it.channel, it.polarity);
                assert_eq!(place(auto), place(full), "{sensor}");
                assert!(
                    auto.t.0.abs_diff(full.t.0) <= 100,
                    "{sensor}: {auto:?} {full:?}"
                );
            }
            let text = common::good(here, &words(&planned));
            assert!(text.contains("plan "), "{text}");
            // Arrays are whole.
            let whole = common::json(here, &words(&format!("{planned} --counts n.npy")));
            assert!(whole["fidelity"]["window"].is_null(), "{whole}");
        }
        // What is planned is timed as it is run.
        let told = common::json(here, &words("plan --scene c.npy --fps 100 --sensor rgc-4"));
        assert!(!told["window"].is_null(), "{told}");
    }

    #[test]
    fn voxels_are_made_where_they_are_asked_for() {
        let folder = tempfile::tempdir().unwrap();
        let voxels = folder.path().join("v.npy");
        let text = format!("run {SCENE}");
        let mut run = words(&text);
        let plain = common::json(here(), &run);
        assert!(plain["paper_events_per_bin"].is_null(), "{plain}");
        run.extend(["--voxels", voxels.to_str().unwrap()]);
        let binned = common::json(here(), &run);
        assert!(binned["paper_events_per_bin"].as_f64().unwrap() > 0.0);
        assert_eq!(plain["events"], binned["events"]);
    }

    #[test]
    fn bad_input_is_told() {
        for (arguments, told) in [
            ("plan {} --tolerance 1", "percent sign"),
            ("plan {} --tolerance -1%", "cannot be tolerated"),
            ("plan {} --tolerance 101%", "cannot be tolerated"),
            ("plan {} --tolerance nan%", "0% (the full model) to 100%"),
            ("plan {} --tolerance nan", "such as 1% or 0.1%"),
            (
                "run {} --fidelity auto --without leak",
                "without leak: it chooses what is left out",
            ),
            (
                "plan {} --formats f31",
                "unknown number format `f31`; known are exact (f64)",
            ),
            (
                "run {} --format q88",
                "unknown number format `q88`; known are exact (f64)",
            ),
            (
                "run --image pattern:disc --sensor missing.toml",
                "missing.toml",
            ),
            ("plan {} --within 3", "not a duration"),
            (
                "plan --scene missing.mp4 --sensor sensors/dvs.toml",
                "missing.mp4",
            ),
            (
                "plan --scene pattern:disc --sensor missing.toml",
                "missing.toml",
            ),
            ("plan --sensor sensors/dvs.toml", "--scene"),
            ("run {} --tolerance 1%", "--fidelity"),
            ("run {} --fidelity auto --format f32", "chooses the format"),
        ] {
            common::refused(here(), &words(&arguments.replace("{}", SCENE)), &[told]);
        }
    }
}
