//! The fidelity plan: over random scenes and sensors, whatever may be left out changes no more
//! events of the full model than its bound says, the choice is the cheapest that fits, and what
//! is looked at beforehand is what the reference then does. Measured with the ruler, against
//! the models themselves.

mod common;

use std::fmt::Write;

use amacrine::{
    event::readout::settings,
    number::Format,
    plane::Plane,
    reference::{Description, Limit, Reference},
    scene::{Frame, OpenOptions, Scene, SceneError, open},
    sensor::Sensor,
    study::plan::{Bounds, Change, Choice, Costs, Effect, Model, PlanError, Question, plan},
    unit::Micros,
};
use proptest::prelude::*;

/// Frames that were made beforehand.
#[derive(Clone, Debug)]
struct Clip {
    frames: Vec<Frame>,
    next: usize,
}

impl Scene for Clip {
    fn size(&self) -> amacrine::plane::Size {
        amacrine::plane::Size::of(&self.frames[0].light)
    }

    fn fps(&self) -> f64 {
        1000.0
    }

    fn frames(&self) -> Option<u64> {
        Some(self.frames.len() as u64)
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        self.next += 1;
        Ok(self.frames.get(self.next - 1).cloned())
    }
}

/// Where light comes from.
#[derive(Clone, Debug)]
enum Source {
    Pattern(String),
    Clip(Clip),
}

impl Source {
    fn open(&self) -> Result<Box<dyn Scene>, SceneError> {
        match self {
            Self::Pattern(spec) => open(spec, &OpenOptions::default()),
            Self::Clip(clip) => Ok(Box::new(clip.clone())),
        }
    }
}

/// Patterns that move at any speed and contrast, in steps of 8-bit light or not.
fn patterns() -> impl Strategy<Value = Source> {
    let names = [
        "bar", "edge", "grating", "checker", "disc", "spot", "noise", "rotate", "zoom", "flicker",
    ];
    (
        proptest::sample::select(names.to_vec()),
        1usize..40,
        1usize..30,
        0.0f64..3000.0,
        (0.0f64..200.0, 0.0f64..255.0),
        proptest::sample::select(vec![120.0, 1000.0, 20_000.0]),
        0u64..100,
    )
        .prop_map(|(name, width, height, speed, (low, high), fps, seed)| {
            let own = match name {
                "flicker" => "&frequency=37".to_owned(),
                "rotate" => format!("&turn={}&seed={seed}", speed.max(1.0)),
                "zoom" => format!("&growth=3&seed={seed}"),
                "noise" => format!("&speed={speed}&seed={seed}"),
                _ => format!("&speed={speed}"),
            };
            let high = low + high;
            Source::Pattern(format!(
                "pattern:{name}?width={width}&height={height}&frames=24&fps={fps}&low={low}&high={high}{own}"
            ))
        })
}

/// Light that walks at random in every pixel, or in a part of them; whole numbers hit
/// thresholds exactly. Frames are not equally far apart.
fn clips() -> impl Strategy<Value = Source> {
    (
        2usize..14,
        2usize..14,
        any::<u64>(),
        any::<bool>(),
        any::<bool>(),
        1.0f64..60.0,
    )
        .prop_map(|(height, width, seed, whole, part, step)| {
            let mut state = seed;
            let mut chance = move || {
                state = amacrine::rng::mix(state.wrapping_add(amacrine::rng::GOLDEN));
                amacrine::rng::uniform(state)
            };
            let mut light = Plane::from_shape_simple_fn((height, width), || 255.0 * chance());
            let mut frames = Vec::new();
            let mut seconds = 0.0;
            for index in 0..20 {
                light.indexed_iter_mut().for_each(|((y, x), light)| {
                    let still = part && (y > height / 3 || x > width / 3);
                    if !still || index == 0 {
                        *light = (*light + step * (chance() - 0.5)).clamp(0.0, 255.0);
                    }
                    if whole {
                        *light = light.round();
                    }
                });
                frames.push(Frame {
                    index,
                    seconds,
                    light: light.clone(),
                });
                seconds += 1e-4 + 4e-3 * chance();
            }
            Source::Clip(Clip { frames, next: 0 })
        })
}

fn scenes() -> impl Strategy<Value = Source> {
    prop_oneof![patterns(), clips()]
}

/// Whole sensors, all of whose parts vary.
fn sensors() -> impl Strategy<Value = String> {
    let response = proptest::sample::select(vec![
        "{ linear = 255 }",
        "{ lin-log = { knee = 20 } }",
        "{ log = { white = 255, offset = 1e-3 } }",
        "\"identity\"",
        "{ linear = { white = 255, round = \"f32\" } }",
    ]);
    let memory = proptest::sample::select(vec![
        "memory = \"filtered-step\"",
        "memory = \"filtered-step\"",
        "memory = \"filtered-step\"\nrefractory = { us = 300 }",
        "memory = \"filtered-step\"\nrefractory = { us = 2500 }",
        "memory = \"filtered-step\"\nborder = \"zero\"",
        "memory = \"filtered-snap\"",
        "memory = \"raw-snap\"\npolarity = \"pixel\"",
        "memory = \"filtered-step\"\nrefractory = { us = 300, rule = \"authors\" }",
    ]);
    let noise = proptest::collection::vec(
        proptest::sample::select(vec![
            "shot-hz = 0.5",
            "shot-at-white = 0.25",
            "hot-fraction = 0.02\nhot-hz = 5",
            "jitter-us = 5",
            "jitter-us = 60",
            "cutoff-hz = 200",
            "cutoff-hz = 90000",
        ]),
        0..4,
    );
    let channel = proptest::sample::select(vec![
        "kernel = \"dvs\"",
        "kernel = \"csdvs-3\"",
        "kernel = \"csdvs-5\"",
        "kernel = \"sobel-x\"\ngain = -0.25",
        "kernel = [[0, -0.3, 0.1], [0.2, 1, -1], [0.3, -0.7, 0.4]]",
        "kernel = \"dvs\"\nlog-temporal = true",
        "mesh = { lambda = 2 }",
        "mesh = { lambda = 3, tau-us = 400 }",
        "mesh = { lambda = 1, noise = 0.0001 }",
        "mesh = { centre = 0, sheets = [{ gain = 1, lambda = 0.7 }, { gain = -1, lambda = 4, tau-us = 90 }] }",
    ]);
    let threshold = (
        proptest::sample::select(vec![0.02, 0.1, 0.2, 0.2]),
        proptest::sample::select(vec![1.0, 1.0, 0.7, 1.3]),
        proptest::sample::select(vec![0.0, 0.0, 0.0, 1e-4, 0.03]),
    );
    let channels = proptest::collection::vec((channel, threshold), 1..3);
    (response, memory, noise, channels).prop_map(|(response, memory, noise, channels)| {
        let scale = if response == "\"identity\"" {
            255.0
        } else {
            1.0
        };
        let mut noise = noise;
        noise.sort_unstable();
        noise.dedup_by_key(|key| key.split(' ').next());
        let mut text = format!(
            "response = {response}\n{memory}\n[noise]\n{}\n",
            noise.join("\n")
        );
        for (channel, (on, ratio, sigma)) in channels {
            let mesh = channel.contains("mesh") && !memory.contains("filtered");
            let channel = if mesh || (channel.contains("mesh") && memory.contains("zero")) {
                "kernel = \"dvs\""
            } else {
                channel
            };
            let _ = writeln!(
                text,
                "[[channel]]\n{channel}\nthreshold = {{ on = {}, off = {}, sigma = {} }}",
                on * scale,
                on * ratio * scale,
                sigma * scale * on
            );
        }
        text
    })
}

fn read(text: &str) -> Description {
    Description::parse("fidelity.toml", text, &|_| unreachable!())
        .unwrap_or_else(|e| panic!("{e}\n{text}"))
}

const FORMATS: [Format; 3] = [Format::F32, Format::F16, Format::Bf16];

fn question(description: &Description, seed: u64) -> Question<'_> {
    Question {
        description,
        seed,
        tolerance: 0.01,
        within: Micros(100),
        formats: &FORMATS,
        upsample: None,
        readout: None,
        crop: true,
    }
}

/// Runs every choice that has a bound, and says how much of each bound was used:
/// (changed, bound, events).
fn hold(question: &Question<'_>, source: &Source) -> Result<Vec<(f64, f64, f64)>, TestCaseError> {
    let mut open = || source.open();
    let bounds = Bounds::find(question, &mut open, || ()).unwrap();
    let full = Model::full(question, Limit::default());
    let full = full.run(&mut open, || ()).unwrap();
    let least = bounds.events();
    prop_assert!(
        least <= full.events.len() as f64 + 1e-6,
        "{least} of {}",
        full.events.len()
    );
    let mut used = Vec::new();
    for (choice, bound) in bounds.choices(question.formats) {
        let model = Model::chosen(question, &choice, bounds.window(), Limit::default());
        let plain = model.run(&mut open, || ()).unwrap();
        let change = Change::between(&full, &plain, question.within).unwrap();
        let changed = (change.missing + change.extra) as f64;
        prop_assert!(
            changed <= bound.events,
            "{choice:?}: {changed} of {} events changed, at most {} were to\n{source:?}",
            change.events,
            bound.events
        );
        prop_assert!(change.share <= bound.share || changed == 0.0);
        used.push((changed, bound.events, full.events.len() as f64));
    }
    Ok(used)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// The heart of it.
    #[test]
    fn nothing_changes_more_than_its_bound(scene in scenes(), sensor in sensors(), seed in 0u64..1000, fine: bool) {
        let description = read(&sensor);
        let mut question = question(&description, seed);
        if fine {
            question.upsample = Some(0.3);
        }
        hold(&question, &scene)?;
    }

    /// What is followed beforehand are the reference's own events.
    #[test]
    fn cells_are_followed_as_the_reference_has_them(scene in scenes(), sensor in sensors(), seed in 0u64..1000) {
        let description = read(&sensor);
        prop_assume!(!description.noise.fires());
        let bounds = Bounds::find(&question(&description, seed), &mut || scene.open(), || ()).unwrap();
        let full = Model::full(&question(&description, seed), Limit::default());
        let full = full.run(&mut || scene.open(), || ()).unwrap();
        if description.memory == amacrine::reference::MemoryRule::FilteredStep
            && description.refractory.rule == amacrine::reference::RefractoryRule::DeadTime
        {
            prop_assert_eq!(bounds.events(), full.events.len() as f64);
        }
    }

    /// The plan is the cheapest of all that fit, found here by trying every one.
    #[test]
    fn the_plan_is_the_cheapest(scene in clips(), sensor in sensors(), percent in 0.0f64..20.0) {
        let description = read(&sensor);
        let question = Question { tolerance: percent / 100.0, ..question(&description, 3) };
        let plan = plan(&question, &mut || scene.open(), || ()).unwrap();
        let bounds = Bounds::find(&question, &mut || scene.open(), || ()).unwrap();
        let costs = Costs::shipped().unwrap();
        let mut best = costs.seconds(&bounds, &Choice::full());
        for format in [Format::F64, Format::F32, Format::F16, Format::Bf16] {
            for set in 0..1 << Effect::ALL.len() {
                let without = (0..Effect::ALL.len()).filter(|n| set >> n & 1 == 1);
                let without = without.map(|n| Effect::ALL[n]).collect();
                let choice = Choice { format, without };
                let fits = bounds.of(&choice).is_some_and(|b| b.share <= question.tolerance);
                if fits {
                    best = best.min(costs.seconds(&bounds, &choice));
                }
            }
        }
        prop_assert_eq!(plan.seconds[1], best);
        prop_assert!(plan.bound.share <= question.tolerance);
        prop_assert_eq!(bounds.of(&plan.choice).map(|b| b.events), Some(plan.bound.events));
    }
}

/// The shipped sensors on scenes that move: what is used of the bounds, and that they are not
/// empty words: most of these sensors get a bound below 1 % for something that takes time.
#[test]
fn bounds_are_not_vacuous() {
    let scenes = [
        "pattern:noise?width=48&height=40&frames=40&fps=1000&speed=200",
        "pattern:disc?width=48&height=40&frames=40&fps=1000&speed=400&low=20&high=220",
    ];
    let sensors = [
        "dvs",
        "dvs-clean",
        "csdvs",
        "dog",
        "rgc",
        "rgc-4",
        "orientation",
        "csdvs-mesh",
        "surrounds",
        "mosaic",
        "laplacian",
    ];
    let (mut helped, mut ratios) = (0, Vec::new());
    for sensor in sensors {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("sensors");
        let text = std::fs::read_to_string(folder.join(format!("{sensor}.toml"))).unwrap();
        let description =
            Description::parse(sensor, &text, &|name| std::fs::read(folder.join(name))).unwrap();
        for scene in scenes {
            let source = Source::Pattern(scene.to_owned());
            let question = question(&description, 5);
            let used = hold(&question, &source).unwrap();
            let (_, bound, events) = used[0];
            assert!(
                bound == 0.0 && events > 0.0,
                "{sensor}: the full model is one of them"
            );
            let small = used
                .iter()
                .filter(|(_, bound, events)| *bound > 0.0 && bound / events < 0.01);
            ratios.extend(small.clone().map(|(changed, bound, _)| changed / bound));
            let plan = plan(&question, &mut || source.open(), || ()).unwrap();
            helped += usize::from(plan.choice != Choice::full());
        }
    }
    ratios.sort_by(f64::total_cmp);
    println!(
        "{helped} of {} plans leave something out; of {} bounds below 1 % the median is used to {:.4}, the most to {:.4}",
        2 * sensors.len(),
        ratios.len(),
        ratios[ratios.len() / 2],
        ratios[ratios.len() - 1]
    );
    assert!(2 * helped > 2 * sensors.len(), "{helped}");
    assert!(ratios.len() > 10);
}

#[test]
fn no_tolerance_is_the_full_model() {
    let description = read(
        "response = { linear = 255 }\nmemory = \"filtered-step\"\n[[channel]]\nkernel = \"dvs\"\nthreshold = { on = 0.1, off = 0.1 }",
    );
    let source = Source::Pattern("pattern:disc?width=40&height=40&frames=9&radius=4".to_owned());
    let ask = |tolerance| {
        let question = Question {
            tolerance,
            ..question(&description, 0)
        };
        plan(&question, &mut || source.open(), || ())
    };
    let none = ask(0.0).unwrap();
    assert_eq!(none.choice, Choice::full());
    assert_eq!(none.seconds[0], none.seconds[1]);
    assert_ne!(ask(0.01).unwrap().choice, Choice::full());
    for tolerance in [-0.1, 1.1, f64::NAN] {
        assert!(matches!(ask(tolerance), Err(PlanError::Tolerance(_))));
    }
}

/// Where the drive is a straight line between two frames, the frames in between go, and with
/// them most of the work; the change is measured against the run that has them.
#[test]
fn inserted_frames_go_where_they_say_nothing_new() {
    let source =
        Source::Pattern("pattern:noise?width=32&height=32&frames=12&fps=100&speed=300".to_owned());
    let kernel = "kernel = \"csdvs-3\"";
    for (response, channel, goes) in [
        ("{ linear = 255 }", kernel, true),
        ("{ lin-log = { knee = 20 } }", kernel, false),
        ("{ linear = 255 }", "mesh = { lambda = 1 }", true),
        (
            "{ linear = 255 }",
            "mesh = { lambda = 1, noise = 0.0001 }",
            false,
        ),
    ] {
        let description = read(&format!(
            "response = {response}\nmemory = \"filtered-step\"\nrefractory = {{ us = 700 }}\n[[channel]]\n{channel}\nthreshold = {{ on = 0.031, off = 0.031 }}"
        ));
        let question = Question {
            upsample: Some(0.02),
            ..question(&description, 0)
        };
        let plan = plan(&question, &mut || source.open(), || ()).unwrap();
        assert_eq!(plan.choice.leaves_out(Effect::Upsampling), goes);
        let used = hold(&question, &source).unwrap();
        assert!(used[0].2 > 1000.0);
    }
}

/// A mesh that is much faster than the scene is taken as settled, a slow one is not.
#[test]
fn a_quick_mesh_is_taken_as_settled() {
    let source =
        Source::Pattern("pattern:noise?width=40&height=32&frames=12&fps=100&speed=60".to_owned());
    for (tau, goes) in [(1, true), (20_000, false)] {
        let description = read(&format!(
            "response = {{ linear = 255 }}\nmemory = \"filtered-step\"\n[[channel]]\nmesh = {{ lambda = 3, tau-us = {tau} }}\nthreshold = {{ on = 0.05, off = 0.05 }}"
        ));
        let question = Question {
            tolerance: 0.05,
            ..question(&description, 0)
        };
        let plan = plan(&question, &mut || source.open(), || ()).unwrap();
        assert_eq!(plan.choice.leaves_out(Effect::Settling), goes, "{tau} us");
        let used = hold(&question, &source).unwrap();
        assert!(used[0].2 > 1000.0);
    }
}

/// A window of the array holds all events, to the bit.
#[test]
fn still_surroundings_go_without_a_trace() {
    let description = read(
        "response = { lin-log = { knee = 20 } }\nmemory = \"raw-snap\"\n[[channel]]\npattern = \"2x2\"\nkernel = [\"csdvs-5\", \"sobel-x\", \"csdvs-3\", \"dog\"]\nthreshold = [{ on = 0.1, off = 0.1 }, { on = 0.2, off = 0.1 }, { on = 0.05, off = 0.1 }, { on = 0.1, off = 0.3 }]",
    );
    let mut clip = Vec::new();
    for index in 0..8_u64 {
        let light = |(y, x): (usize, usize)| {
            let moves = (33..36).contains(&y) && (41..47).contains(&x);
            100.0
                + (7 * y + 3 * x) as f64 % 50.0
                + if moves {
                    (index * 30) as f64 % 90.0
                } else {
                    0.0
                }
        };
        clip.push(Frame {
            index,
            seconds: index as f64 * 1e-3,
            light: Plane::from_shape_fn((70, 80), light),
        });
    }
    let source = Source::Clip(Clip {
        frames: clip,
        next: 0,
    });
    let question = Question {
        within: Micros(0),
        ..question(&description, 0)
    };
    let mut open = || source.open();
    let plan = plan(&question, &mut open, || ()).unwrap();
    assert!(plan.choice.leaves_out(Effect::Surroundings));
    let full = Model::full(&question, Limit::default())
        .run(&mut open, || ())
        .unwrap();
    let plain = Model::planned(&question, &plan, Limit::default())
        .run(&mut open, || ())
        .unwrap();
    assert!(full.events.len() > 100);
    assert_eq!(full.events, plain.events);
    assert_eq!((full.size, full.channels), (plain.size, plain.channels));
}

/// Stray events and jitter, over many seeds: the bounds hold for each.
#[test]
fn noise_stays_within_its_bound_whatever_the_seed() {
    let description = read(
        "response = { linear = 255 }\nmemory = \"filtered-step\"\nrefractory = { us = 3000 }\n[noise]\nshot-hz = 3\nhot-fraction = 0.01\nhot-hz = 40\njitter-us = 40\n[[channel]]\nkernel = \"dvs\"\nthreshold = { on = 0.02, off = 0.02 }",
    );
    let source =
        Source::Pattern("pattern:noise?width=20&height=20&frames=30&fps=500&speed=300".to_owned());
    let mut most = 0.0_f64;
    for seed in 0..30 {
        for (changed, bound, _) in hold(&question(&description, seed), &source).unwrap() {
            most = most.max(if bound > 0.0 { changed / bound } else { 0.0 });
        }
    }
    assert!(most > 0.02, "nothing happened: {most}");
}

/// An arbiter that keeps up goes; one that does not stays, and its bound says so.
#[test]
fn a_readout_goes_where_no_event_waits_long() {
    let description = read(
        "response = { linear = 255 }\nmemory = \"filtered-step\"\nrefractory = { us = 500 }\n[[channel]]\nkernel = \"dvs\"\nthreshold = { on = 0.2, off = 0.2 }",
    );
    let source =
        Source::Pattern("pattern:disc?width=40&height=40&frames=60&fps=1000&speed=100".to_owned());
    for (link, goes) in [("20ns", true), ("40us", false)] {
        let mut arbiter = settings::Description::shipped("arbiter").unwrap();
        arbiter.set("link", link).unwrap();
        let readout = Some(arbiter.readout().unwrap());
        let question = Question {
            readout,
            ..question(&description, 0)
        };
        let plan = plan(&question, &mut || source.open(), || ()).unwrap();
        assert_eq!(plan.choice.leaves_out(Effect::Readout), goes, "{link}");
        hold(&question, &source).unwrap();
    }
    // Its frames merge events by rule: no bound.
    let readout = Some(
        settings::Description::shipped("frame")
            .unwrap()
            .readout()
            .unwrap(),
    );
    let question = Question {
        readout,
        ..question(&description, 0)
    };
    let plan = plan(&question, &mut || source.open(), || ()).unwrap();
    assert_eq!(plan.choice.format, Format::F64);
    assert!(!plan.choice.leaves_out(Effect::Refractory));
}

/// The reference, watched as `run` watches it, has the events of the full model.
#[test]
fn the_full_model_is_the_reference() {
    let description = read(
        "response = { linear = 255 }\nmemory = \"filtered-step\"\n[[channel]]\nkernel = \"dvs\"\nthreshold = { on = 0.1, off = 0.1, sigma = 0.01 }",
    );
    let source = Source::Pattern("pattern:disc?width=30&height=20&frames=9".to_owned());
    let full = Model::full(&question(&description, 9), Limit::default());
    let full = full.run(&mut || source.open(), || ()).unwrap();
    let mut scene = source.open().unwrap();
    let mut reference = Reference::new(description, scene.size(), 9).unwrap();
    let mut packet = amacrine::event::Packet::new(scene.size(), 1);
    while let Some(frame) = scene.next_frame().unwrap() {
        reference.watch(&frame, &mut packet).unwrap();
    }
    assert_eq!(full, packet);
}

mod command {
    use std::path::Path;

    fn amacrine(arguments: &str) -> (Option<i32>, String, String) {
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        let words: Vec<_> = arguments.split_whitespace().collect();
        let output = crate::common::amacrine(here, &words).output().unwrap();
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        (
            output.status.code(),
            text(output.stdout),
            text(output.stderr),
        )
    }

    const SCENE: &str = "--scene pattern:disc?width=40&height=30&frames=20&fps=1000&speed=300 --sensor sensors/dvs-v2e.toml";

    #[test]
    fn a_plan_is_printed_run_and_verified() {
        let sensor = SCENE.replace("dvs-v2e", "csdvs");
        let (code, text, error) = amacrine(&format!("plan {sensor} --verify"));
        assert_eq!(code, Some(0), "{error}");
        for part in [
            "scene",
            "full",
            "dead time",
            "plan ",
            "tolerated",
            "verified",
            "every bound held",
        ] {
            assert!(text.contains(part), "{part} is not in\n{text}");
        }
        let (_, text, _) = amacrine(&format!("plan {sensor} --verify --json"));
        let json: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(json["verified"]["held"], true);
        assert_eq!(json["choice"]["format"], "f32");
        let (bound, change) = (
            &json["bound"]["share"],
            &json["verified"]["change"]["share"],
        );
        assert!(change.as_f64().unwrap() <= bound.as_f64().unwrap());
    }

    #[test]
    fn a_run_says_what_it_left_out() {
        let sensor = SCENE.replace("dvs-v2e", "csdvs");
        let (_, full, _) = amacrine(&format!("run {sensor} --json"));
        let (code, auto, error) = amacrine(&format!(
            "run {sensor} --json --fidelity auto --tolerance 1%"
        ));
        assert_eq!(code, Some(0), "{error}");
        let read = |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap();
        let (full, auto) = (read(&full), read(&auto));
        assert!(full["fidelity"].is_null());
        assert_eq!(auto["fidelity"]["tolerance"], 0.01);
        let off = full["events"].as_f64().unwrap() - auto["events"].as_f64().unwrap();
        assert!(off.abs() <= auto["fidelity"]["bound"]["events"].as_f64().unwrap());
        let (_, text, _) = amacrine(&format!("run {sensor} --fidelity auto"));
        assert!(
            text.contains("* dead time") && text.contains("at most"),
            "{text}"
        );
    }

    #[test]
    fn bad_input_is_told() {
        for (arguments, told) in [
            ("plan {} --tolerance 1", "percent sign"),
            ("plan {} --tolerance -1%", "cannot be tolerated"),
            ("plan {} --tolerance 101%", "cannot be tolerated"),
            ("plan {} --tolerance nan%", "0% (the full model) to 100%"),
            ("plan {} --formats f31", "unknown number format"),
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
            let (code, _, error) = amacrine(&arguments.replace("{}", SCENE));
            assert_eq!(code, Some(2), "{arguments}\n{error}");
            assert!(
                error.contains(told),
                "{arguments}: {told} is not in\n{error}"
            );
        }
    }
}
