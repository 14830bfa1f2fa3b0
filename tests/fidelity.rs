//! The fidelity plan: over random scenes and sensors, whatever may be left out changes no more
//! events of the full model than its bound says, the choice is the cheapest that fits, and what
//! is looked at beforehand is what the reference then does. Measured with the ruler, against
//! the models themselves.

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
                state = amacrine::chance::mix(state.wrapping_add(amacrine::chance::GOLDEN));
                amacrine::chance::uniform(state)
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
            text += &format!(
                "[[channel]]\n{channel}\nthreshold = {{ on = {}, off = {}, sigma = {} }}\n",
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
