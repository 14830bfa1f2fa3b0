//! The waterfall from the float sensor to the chip: its classes part every packet; a step that
//! is switched off, or cannot matter, changes nothing; a loss that is put in lands on its own
//! step and on no other; both ends are the sensors that they are called, made anew; the answer
//! does not depend on the number of threads. Over frame rate: what the causes take and what is
//! kept add up to 1; on a sensor that is looked at whole the ends are those of the steps; a
//! perfect chip loses nothing of its own at any rate; noise makes more events the more decisions
//! there are; tiles stand for the whole. And the verb `waterfall` from outside.

mod common;

use amacrine::{
    array::Arithmetic,
    compare::{Pair, fate::Fate, matching},
    compile::{DriveMemory, Effort},
    event::readout::{Ideal, Readout, Scan, scan::Order},
    isa::{Device, Errors, Figure},
    kernel::{
        Kernel,
        quantise::{Quantiser, Sum},
    },
    number::Format,
    reference::MemoryRule,
    rig,
    scene::{self, OpenOptions, Scene},
    sensor::Sensor,
    study::{
        StudyError,
        design::{Design, DesignError},
        quantisation,
        together::Together,
        waterfall::{
            Cause, Choice, Fall, How, Question, Rates, Step, Waterfall, WaterfallError, ask,
            steps_together,
        },
    },
    unit::{Micros, Picos},
};

/// Blobs that drift; light of 51 to 204, which the program of a small kernel holds.
const SCENE: &str = "pattern:noise?width=48&height=32&frames=10&grain=3&speed=400";

fn scene() -> Box<dyn Scene> {
    scene::open(SCENE, &OpenOptions::default()).unwrap()
}

/// Levels of -1, 0 and 1 already.
fn ternary() -> Kernel {
    Kernel::from_rows(&[[0.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vec::from))
        .unwrap()
}

/// A chip without errors, but for these numbers.
fn perfect(but: &[(Figure, f64)]) -> Device {
    let none = [
        Figure::TransferError,
        Figure::StoreLoss,
        Figure::DivisionError,
        Figure::GainMismatch,
        Figure::OffsetMismatch,
        Figure::DivisionMismatch,
        Figure::StoreNoise,
        Figure::AnalogueDecay,
    ];
    let none = none.map(|figure| (figure, 0.0));
    none.iter()
        .chain(but)
        .fold(Device::scamp5(), |device, (figure, value)| {
            device.what_if(*figure, *value).unwrap()
        })
}

fn design<'a>(kernel: &'a Kernel, device: &'a Device, threshold: f64) -> Design<'a> {
    Design {
        kernel,
        threshold,
        device,
        effort: Effort::states(4_000),
        seed: 1,
    }
}

/// As silicon, ideally read out.
fn question(design: Design<'_>) -> Question<'_> {
    Question {
        design,
        to: Quantiser::TERNARY,
        sum: Sum::Free,
        arithmetic: Arithmetic::Silicon { seed: 1 },
        readout: Readout::Ideal(Ideal),
        within: Micros(100),
    }
}

fn fall(question: &Question<'_>) -> Waterfall {
    ask(question, &mut scene(), |_| ()).unwrap()
}

/// The steps that change anything, in either order.
fn culprits(waterfall: &Waterfall) -> Vec<Cause> {
    let changes = |step: &&Step| {
        let backward = step.backward.map_or(0, Fate::changed);
        step.forward.changed() + backward > 0
    };
    waterfall
        .steps
        .iter()
        .filter(changes)
        .map(|step| step.cause)
        .collect()
}

fn step(waterfall: &Waterfall, cause: Cause) -> &Step {
    waterfall
        .steps
        .iter()
        .find(|step| step.cause == cause)
        .unwrap()
}

/// The chip as its data have it, a threshold that its converter cannot set, a kernel that is
/// not ternary, and few slots: everything happens.
fn everything(device: &Device, run: impl FnOnce(&Question<'_>)) {
    let kernel = Kernel::builtin("csdvs-5").unwrap();
    let readout = Readout::Scan(Scan {
        slots: 40,
        slot: Picos(910_000),
        period: Micros(0),
        order: Order::default(),
    });
    run(&Question {
        to: "int-4".parse().unwrap(),
        readout,
        ..question(design(&kernel, device, 12.3))
    });
}

#[test]
fn the_classes_part_every_packet() {
    everything(&Device::scamp5(), |question| {
        let all = fall(question);
        let causes: Vec<_> = all.steps.iter().map(|step| step.cause).collect();
        assert_eq!(causes, Cause::SILICON);
        let mut events = all.float_events;
        for Step { forward, cause, .. } in &all.steps {
            assert_eq!(forward.before(), events, "{cause:?}");
            events = forward.after();
        }
        assert_eq!(events, all.chip_events);
        // The first line is of another float sensor, with events of its own.
        let ratio = all.chip_events as f64 / all.reference_events as f64;
        assert_eq!(all.likeness.event_ratio, Some(ratio));
        assert_ne!(all.reference_events, all.float_events);
        assert_eq!(all.ends.before(), all.float_events);
        assert_eq!(all.ends.after(), all.chip_events);
        // The float model's steps end in one sensor, the chip's in another.
        let float = step(&all, Cause::Kernel).forward.after();
        for Step {
            backward, cause, ..
        } in &all.steps
        {
            let end = if cause.is_float() {
                float
            } else {
                all.chip_events
            };
            if let Some(backward) = backward {
                assert_eq!(backward.after(), end, "{cause:?}");
            }
        }
        let none = |cause| step(&all, cause).backward.is_none();
        assert!(none(Cause::Frames) && none(Cause::Format) && !none(Cause::Memory));
        // Added last, a step does the same in order and alone.
        let readout = step(&all, Cause::Readout);
        assert_eq!(readout.backward, Some(readout.forward));
        assert!(readout.forward.lost > 0 && readout.forward.extra == 0);
        let changed: Vec<_> = culprits(&all);
        for cause in [
            Cause::Frames,
            Cause::Kernel,
            Cause::Converter,
            Cause::Mismatch,
        ] {
            assert!(changed.contains(&cause), "{cause:?} changed nothing");
        }
    });
}

/// Both ends made anew, without the waterfall; and what can be said of the way between them
/// from the ends alone.
#[test]
fn the_ends_are_the_sensors_that_they_are_called() {
    let device = Device::scamp5();
    everything(&device, |question| {
        let all = fall(question);
        let design = question.design;
        let quantised = design.quantise(question.to, question.sum).unwrap();
        let program = design.in_levels(&quantised).compile("end").unwrap();
        let mut scene = scene();
        let size = scene.size();
        let mut float = design
            .reference(size, MemoryRule::FilteredStep, Format::F64)
            .unwrap();
        let mut chip = program
            .silicon(Errors::from_device(&device), 1, size, program.settings())
            .unwrap();
        let mut sensors: [&mut (dyn Sensor + Send); 2] = [&mut float, &mut chip];
        let packets = rig::watch(&mut scene, &mut sensors, |_| ()).unwrap();
        let last = question.readout.read(&packets[1]).packet;
        let pair = Pair::new(&packets[0], &last).unwrap();
        assert_eq!(Fate::from_pair(&pair, all.windows), all.ends);
        assert_eq!(last.events.len() as u64, all.chip_events);

        // Net change adds up; what is lost on the way may be made up for by something extra,
        // so that the steps' sum is a bound: an event that no step lost or turned is still
        // there, no further away than a wide window for each step.
        let sum = |class: fn(Fate) -> u64| -> u64 {
            all.steps.iter().map(|step| class(step.forward)).sum()
        };
        let (lost, extra) = (sum(|f| f.lost), sum(|f| f.extra));
        assert_eq!(all.float_events + extra, all.chip_events + lost);
        let far = Micros(all.windows.wide.0 * all.steps.len() as u64);
        let survived = matching::matched(&pair, far);
        assert!(all.float_events - survived <= lost + sum(|f| f.wrong_sign));
        assert!(all.chip_events - survived <= extra + sum(|f| f.wrong_sign));
    });
}

/// A ternary kernel, a whole threshold, registers that hold it, a perfect chip: only the two
/// steps of the float model that are always there change anything, and none of the chip does
/// so to the last event.
#[test]
fn what_cannot_matter_changes_nothing() {
    let (kernel, device) = (ternary(), perfect(&[]));
    let plain = question(design(&kernel, &device, 32.0));
    let all = fall(&plain);
    assert_eq!(all.program.threshold_lsb.fract(), 0.0, "{:?}", all.program);
    assert!(all.float_events > 1000, "{}", all.float_events);
    assert_eq!(culprits(&all), [Cause::Frames, Cause::Memory]);
    // The same in numbers; there the float model is the same, and no cell is analogue.
    let numbers = Question {
        arithmetic: Arithmetic::Number("q8.24".parse().unwrap()),
        ..plain
    };
    let in_numbers = fall(&numbers);
    let causes: Vec<_> = in_numbers.steps.iter().map(|step| step.cause).collect();
    assert_eq!(causes, Cause::NUMBERS);
    assert_eq!(culprits(&in_numbers), [Cause::Frames, Cause::Memory]);
    assert_eq!(in_numbers.ends, all.ends);
    assert_eq!(in_numbers.steps[..3], all.steps[..3]);
}

#[test]
fn a_loss_that_is_put_in_lands_on_its_own_step() {
    let (kernel, pixel) = (ternary(), Kernel::from_rows(&[vec![1.0]]).unwrap());
    let float = [Cause::Frames, Cause::Memory];
    let only = |question: &Question<'_>, cause: Cause| {
        let all = fall(question);
        let found = culprits(&all);
        let own: Vec<_> = found.iter().filter(|c| !float.contains(c)).collect();
        assert_eq!(own, [&cause]);
        // Alone as in order: nothing else of the chip is there for it to meet.
        let step = step(&all, cause);
        assert_eq!(
            step.backward.unwrap_or(step.forward),
            step.forward,
            "{cause:?}"
        );
    };
    for (figure, value, cause) in [
        (Figure::StoreNoise, 4.0, Cause::Noise),
        (Figure::OffsetMismatch, 4.0, Cause::Mismatch),
        (Figure::StoreLoss, 0.1, Cause::Transfer),
        (Figure::AnalogueDecay, 2000.0, Cause::Decay),
        (Figure::Lowest, -40.0, Cause::Saturation),
    ] {
        let device = perfect(&[(Figure::Headroom, 0.0), (figure, value)]);
        // Against these a program of sums lets strong light saturate, which is a loss of its own.
        let kernel = match cause {
            Cause::Noise | Cause::Mismatch | Cause::Transfer => &pixel,
            _ => &kernel,
        };
        only(&question(design(kernel, &device, 32.0)), cause);
    }
    let device = perfect(&[]);
    let plain = question(design(&kernel, &device, 32.0));
    only(&question(design(&kernel, &device, 33.0)), Cause::Converter);
    let slots = Scan {
        slots: 3,
        slot: Picos(0),
        period: Micros(0),
        order: Order::default(),
    };
    let few = Question {
        readout: Readout::Scan(slots),
        ..plain
    };
    only(&few, Cause::Readout);
    let coarse = Question {
        arithmetic: Arithmetic::Number("q8.0".parse().unwrap()),
        ..plain
    };
    only(&coarse, Cause::Format);
    // As large, and of a scale that the threshold takes in: in few values it is another.
    let uneven =
        Kernel::from_rows(&[[0.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 0.6]].map(Vec::from))
            .unwrap();
    let quantised = Quantiser::TERNARY.quantise(&uneven, Sum::Free, 1).unwrap();
    let device = perfect(&[]);
    only(
        &question(design(&uneven, &device, 32.0 * quantised.scale)),
        Cause::Kernel,
    );
}

#[test]
fn one_thread_or_four() {
    everything(&Device::scamp5(), |question| {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap().install(|| fall(question))
        };
        assert_eq!(on(1), on(4));
    });
}

/// Mean, spread and noise come from the seed: another chip, another answer, the float model's
/// steps the same.
#[test]
fn another_seed_is_another_chip() {
    everything(&Device::scamp5(), |question| {
        let (one, other) = (
            fall(question),
            fall(&Question {
                arithmetic: Arithmetic::Silicon { seed: 2 },
                ..*question
            }),
        );
        // Up to the errors that all cells share; a step alone meets the other chip's.
        let shared = |all: &Waterfall| all.steps[..7].iter().map(|s| s.forward).collect::<Vec<_>>();
        assert_eq!(shared(&one), shared(&other));
        assert_ne!(step(&one, Cause::Mismatch), step(&other, Cause::Mismatch));
    });
}

#[test]
fn what_does_not_fit_is_said() {
    let (kernel, device) = (ternary(), Device::scamp5());
    let asked = |question: &Question<'_>| ask(question, &mut scene(), |_| ()).unwrap_err();
    let plain = question(design(&kernel, &device, 32.0));
    let dense = Kernel::new(ndarray::Array2::from_shape_fn((15, 15), |(y, x)| {
        ((y * 37 + x * 101) % 89) as f64 / 89.0 - 0.4
    }))
    .unwrap();
    let large = Question {
        design: design(&dense, &device, 40.0),
        to: "q1.7".parse().unwrap(),
        ..plain
    };
    let error = asked(&large);
    assert!(
        matches!(&error, WaterfallError::Study(StudyError::Design(design)) if design.is_refusal()),
        "{error}"
    );
    assert!(error.to_string().contains("words"), "{error}");
    let nothing = Question {
        design: design(&kernel, &device, 0.0),
        ..plain
    };
    let error = asked(&nothing);
    assert!(matches!(
        error,
        WaterfallError::Study(StudyError::Design(DesignError::Threshold(0.0)))
    ));
    let silent = Question {
        arithmetic: Arithmetic::Number(Format::F64),
        design: design(&kernel, &device, 250.0),
        ..plain
    };
    let scene = "pattern:static?width=16&height=16&frames=3";
    let mut scene = scene::open(scene, &OpenOptions::default()).unwrap();
    let error = ask(&silent, &mut scene, |_| ()).unwrap_err();
    assert!(matches!(error, WaterfallError::Silent { .. }), "{error}");
}

/// Kinds that share a memory are one program: what is told of each is what that program keeps of the
/// float sensor that shares it too, and no cause of it is a program of its own.
#[test]
fn kinds_of_one_program_fall_together() {
    let device = Device::scamp5();
    let kernels = [
        ternary(),
        Kernel::builtin("laplacian").unwrap(),
        Kernel::builtin("sobel-x").unwrap(),
    ];
    let designs = kernels
        .each_ref()
        .map(|kernel| design(kernel, &device, 40.0));
    let asked = Question {
        within: WITHIN,
        ..question(designs[0])
    };
    let falls = Fall::all(&designs, asked, None).unwrap();
    assert_eq!(falls[0].remembered(), Some(DriveMemory::Shared));
    let all = steps_together(&falls, &mut *scene(), |_| ()).unwrap();
    let quantised = designs.map(|own| own.quantise(asked.to, asked.sum).unwrap());
    let levels: Vec<Design<'_>> = { designs.iter().zip(&quantised) }
        .map(|(own, quantised)| own.in_levels(quantised))
        .collect();
    let program = Together::compile(&levels, "three", None).unwrap().unwrap();
    let (judged, ..) = program
        .judge(&designs, (WITHIN, 1), &mut *scene(), |_| ())
        .unwrap();
    assert_eq!(all.len(), 3);
    for (told, judged) in all.iter().zip(&judged) {
        assert_eq!(told.chip_events, judged.packet.events.len() as u64);
        assert_eq!(told.likeness.kept, judged.silicon.kept);
        assert_eq!(told.program.words, program.compiled.cost.words.0);
    }
    // Another kind's events renew the memory: alone, the first says something else.
    let alone = fall(&asked);
    assert_ne!(alone.chip_events, all[0].chip_events);
    assert_eq!(alone.float_events, all[0].float_events);
    // Over frame rate, all that is kept and taken is all.
    let open = || scene::open(SCENE, &OpenOptions::default());
    let two = Choice {
        within: Some(WITHIN),
        ..choice(&[240.0], 2)
    };
    let rates = falls[1].rates(&two, &open, &|| {}).unwrap();
    for rate in &rates.rates {
        let taken: f64 = rate.causes.iter().map(|cause| cause.share.unwrap()).sum();
        assert!((taken + rate.headline.kept.unwrap() - 1.0).abs() < 1e-9);
    }
}

/// Everything that is at most this far apart matches; two frames of the scene are closer.
const WITHIN: Micros = Micros(10_000);

fn over(question: &Question<'_>, choice: &Choice) -> Rates {
    over_scene(question, choice, SCENE)
}

fn over_scene(question: &Question<'_>, choice: &Choice, scene: &str) -> Rates {
    let open = || scene::open(scene, &OpenOptions::default());
    let fall = Fall::new(Question {
        within: WITHIN,
        ..*question
    });
    let choice = Choice {
        within: Some(WITHIN),
        ..choice.clone()
    };
    fall.unwrap().rates(&choice, &open, &|| {}).unwrap()
}

/// Within a window that covers the clip chance scores all there is.
#[test]
fn where_chance_scores_all_nothing_is_told() {
    let (kernel, device) = (ternary(), Device::scamp5());
    let within = Micros(10_000_000);
    let open = || scene::open(SCENE, &OpenOptions::default());
    let fall = Fall::new(Question {
        within,
        ..question(design(&kernel, &device, 32.0))
    });
    let choice = Choice {
        within: Some(within),
        ..choice(&[240.0, 480.0], 2)
    };
    let all = fall.unwrap().rates(&choice, &open, &|| {}).unwrap();
    for rate in &all.rates {
        let told = (
            rate.headline.kept,
            rate.headline.threshold_equivalent_percent,
        );
        assert_eq!(told, (None, None));
        assert_eq!(rate.kept_10_90, None);
        for share in &rate.causes {
            assert_eq!((share.share, share.share_10_90), (None, None), "{share:?}");
        }
    }
    assert_eq!(all.costliest(), None);
    let drawing = all.drawing("nothing");
    let dashes = drawing.texts().filter(|text| *text == "-").count();
    assert_eq!(dashes, 2, "one for each rate, beside `kept`");
    let why = "-: chance alone scores 1 there";
    assert!(drawing.texts().any(|text| text.starts_with(why)));
}

fn choice(rates: &[f64], chips: u64) -> Choice {
    Choice {
        rates: rates.to_vec(),
        chips,
        ..Choice::default()
    }
}

/// What a cause takes at each rate.
fn taken(rates: &Rates, cause: Cause) -> Vec<f64> {
    let share = |rate: &amacrine::study::waterfall::Rate| {
        let own = rate.causes.iter().find(|share| share.cause == cause);
        own.unwrap().share.unwrap()
    };
    rates.rates.iter().map(share).collect()
}

/// Efficiency, on sensors that run: in either arithmetic, with all causes at work.
#[test]
fn what_is_kept_and_what_the_causes_take_is_all() {
    everything(&Device::scamp5(), |question| {
        let numbers = Question {
            arithmetic: Arithmetic::Number("q8.0".parse().unwrap()),
            ..*question
        };
        for (question, causes, chips) in [
            (question, Cause::SILICON, 3),
            (&numbers, &Cause::NUMBERS[..], 1),
        ] {
            let all = over(question, &choice(&[240.0, 480.0], 3));
            assert_eq!((all.rates.len(), all.chips), (2, chips));
            for rate in &all.rates {
                let found: Vec<_> = rate.causes.iter().map(|share| share.cause).collect();
                assert_eq!(found, causes);
                let sum: f64 = rate.causes.iter().map(|share| share.share.unwrap()).sum();
                let kept = rate.headline.kept.unwrap();
                assert!((sum + kept - 1.0).abs() < 1e-9, "{sum} {kept}");
                assert!(kept < 0.9, "nothing was lost: {kept}");
                let [low, high] = rate.kept_10_90.unwrap();
                assert!(low <= kept + 1e-12 && kept <= high + 1e-12);
                assert!(rate.headline.threshold_equivalent_percent > Some(0.0));
                assert_eq!(rate.headline.window_us, WITHIN);
                for share in &rate.causes {
                    let own = share.share.unwrap();
                    let [low, high] = share.share_10_90.unwrap();
                    assert!(low <= own + 1e-12 && own <= high + 1e-12);
                    let how = match share.cause {
                        Cause::Readout => How::Last,
                        Cause::Format if chips == 1 => How::Shapley,
                        cause if cause <= Cause::Format => How::InOrder,
                        _ => How::Shapley,
                    };
                    assert_eq!(share.how, how, "{:?}", share.cause);
                }
            }
            assert!(taken(&all, Cause::Readout)[0] > 0.0);
        }
    });
}

/// The whole sensor, all frames, one chip: the ends, and the causes that come in order, are
/// those of the steps, which are told on another way.
#[test]
fn rates_and_steps_agree_where_they_ask_the_same() {
    everything(&Device::scamp5(), |question| {
        let question = Question {
            within: WITHIN,
            ..*question
        };
        let steps = fall(&question);
        let all = over(&question, &choice(&[240.0], 1));
        assert_eq!(all.sample.pixels, 48 * 32);
        assert_eq!(all.sample.source_frames, 10);
        let [rate] = &all.rates[..] else {
            panic!("one rate was asked for");
        };
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} {b}");
        let mut before = 1.0;
        for (step, share) in steps.steps.iter().zip(&rate.causes).take(4) {
            assert_eq!(step.cause, share.cause);
            near(share.share.unwrap(), before - step.likeness.kept.unwrap());
            before = step.likeness.kept.unwrap();
        }
        let last = steps.steps.last().unwrap().likeness;
        near(rate.headline.kept.unwrap(), last.kept.unwrap());
        near(
            rate.headline.threshold_equivalent_percent.unwrap(),
            last.threshold_equivalent_percent.unwrap(),
        );
        let readout = &steps.steps[steps.steps.len() - 2..];
        near(
            taken(&all, Cause::Readout)[0],
            readout[0].likeness.kept.unwrap() - readout[1].likeness.kept.unwrap(),
        );
    });
}

/// One question, one answer.
#[test]
fn its_headline_is_that_of_quantise() {
    let (kernel, device) = (Kernel::builtin("csdvs-5").unwrap(), Device::scamp5());
    let to = "int-4".parse().unwrap();
    let question = Question {
        to,
        within: WITHIN,
        ..question(design(&kernel, &device, 12.3))
    };
    let own = fall(&question).likeness;
    let asked = quantisation::Question {
        design: question.design,
        quantisers: &[to],
        sum: question.sum,
        within: WITHIN,
    };
    let open = || scene::open(SCENE, &OpenOptions::default());
    let answer = quantisation::ask(&asked, &open, |_| ()).unwrap();
    let quantised = answer.rows[0].headline.unwrap();
    assert_eq!(quantised, own.into());
    assert!(own.kept.unwrap() < 0.999, "{}", own.kept.unwrap());
}

/// Only the float model's steps lose anything, and less the more often the chip decides.
#[test]
fn a_perfect_chip_loses_nothing_of_its_own_at_any_rate() {
    let (kernel, device) = (ternary(), perfect(&[]));
    let plain = question(design(&kernel, &device, 32.0));
    let all = over(&plain, &choice(&[240.0, 960.0, 3840.0], 2));
    let losses = [Cause::Frames, Cause::Memory];
    for rate in &all.rates {
        for share in rate.causes.iter().filter(|s| !losses.contains(&s.cause)) {
            assert!(share.share.unwrap().abs() < 1e-9, "{share:?}");
        }
        assert_eq!(rate.noise.unwrap().events_per_second, 0.0);
    }
    let kept: Vec<f64> = all
        .rates
        .iter()
        .map(|rate| rate.headline.kept.unwrap())
        .collect();
    assert!(kept[0] < kept[1] && kept[1] < kept[2], "{kept:?}");
    assert!(kept[2] > 0.6, "{kept:?}");
    assert_eq!(all.noise.unwrap().sigmas, None);
    assert_eq!(all.noise.unwrap().fps_below, None);
}

#[test]
fn noise_alone_fires_the_more_the_more_often_the_chip_decides() {
    let kernel = ternary();
    let told = |noise| {
        let device = perfect(&[(Figure::StoreNoise, noise)]);
        let plain = question(design(&kernel, &device, 32.0));
        over(&plain, &choice(&[240.0, 960.0], 4))
    };
    let all = told(4.0);
    let events = |all: &Rates, i: usize| all.rates[i].noise.unwrap().events_per_second;
    assert!(events(&all, 0) > 0.0);
    assert!(events(&all, 1) > 2.0 * events(&all, 0));
    let share = all.rates[1].noise.unwrap().share;
    assert_eq!(share, events(&all, 1) / all.reference_events_per_second);
    assert!(taken(&all, Cause::Noise)[1] > taken(&all, Cause::Noise)[0]);
    // What helps: fewer decisions, more sigmas.
    let noise = all.noise.unwrap();
    assert!(share > noise.limit, "{share}");
    assert!(noise.fps_below.unwrap() < 960.0);
    assert!(noise.threshold_for_fastest.unwrap() > 32.0);
    let quiet = told(2.0);
    let (loud, quiet) = (noise.sigmas.unwrap(), quiet.noise.unwrap().sigmas.unwrap());
    assert!((quiet / loud - 2.0).abs() < 1e-9, "{loud} {quiet}");
    let advice = all.advice().join("\n");
    assert!(advice.contains("sigmas") && advice.contains("raise the threshold"));
}

/// A sensor of 60 tiles, eight of them looked at.
#[test]
fn tiles_stand_for_the_whole_sensor() {
    let scene = "pattern:noise?width=176&height=112&frames=40&grain=3&speed=100";
    let (kernel, device) = (ternary(), Device::scamp5());
    let plain = question(design(&kernel, &device, 32.0));
    let told = |tiles| {
        let choice = Choice {
            tiles: Some(tiles),
            ..choice(&[240.0], 2)
        };
        over_scene(&plain, &choice, scene)
    };
    let (some, whole) = (told(8), told(1000));
    assert_eq!(some.sample.tiles.len(), 8);
    assert_eq!((some.sample.width, some.sample.halo), (16, 2));
    assert_eq!(whole.sample.pixels, 176 * 112);
    let [some, whole] = [&some.rates[0], &whole.rates[0]];
    let (a, b) = (some.headline.kept.unwrap(), whole.headline.kept.unwrap());
    assert!((a - b).abs() < 0.05, "{a} {b}");
    for (a, b) in some.causes.iter().zip(&whole.causes) {
        let (a, b) = (a.share.unwrap(), b.share.unwrap());
        assert!((a - b).abs() < 0.05, "{a} {b}");
    }
}

/// Where few blocks are active, a few tiles are off by much: there are a dozen at least, and the
/// ranges say how far off they may be.
#[test]
fn tiles_of_an_uneven_scene_say_how_far_off_they_may_be() {
    let (kernel, device) = (ternary(), Device::scamp5());
    let plain = question(design(&kernel, &device, 32.0));
    for scene in [
        "pattern:disc?width=176&height=112&frames=40&speed=100",
        "pattern:bar?width=176&height=112&frames=40&speed=100",
    ] {
        let told = |tiles| {
            let choice = Choice {
                tiles,
                ..choice(&[30.0], 1)
            };
            over_scene(&plain, &choice, scene)
        };
        let (some, whole) = (told(None), told(Some(1000)));
        let tiles = some.sample.tiles.len();
        assert!((12..=48).contains(&tiles), "{tiles}");
        let [some, whole] = [some, whole].map(|all| all.rates[0].clone());
        let (kept, truth) = (some.headline.kept.unwrap(), whole.headline.kept.unwrap());
        let [low, high] = some.kept_10_90.unwrap();
        assert!(high - low > 0.01, "one chip, many tiles: {low} to {high}");
        // Twice as far as 80 % lie: 2.6 deviations.
        let [below, above] = [2.0 * (kept - low), 2.0 * (high - kept)];
        let near = kept - below <= truth && truth <= kept + above;
        assert!(near, "{scene}: {kept} ({low} to {high}), in truth {truth}");
        // The parts add up in the middle of the ranges as well.
        let sum: f64 = some.causes.iter().map(|share| share.share.unwrap()).sum();
        assert!((sum + kept - 1.0).abs() < 1e-9);
    }
}

#[test]
fn rates_do_not_depend_on_threads_and_chips_differ() {
    let (kernel, device) = (ternary(), Device::scamp5());
    let plain = question(design(&kernel, &device, 30.5));
    let on = |threads, chips| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let choice = choice(&[240.0, 480.0], chips);
        pool.unwrap().install(|| over(&plain, &choice))
    };
    let all = on(1, 4);
    assert_eq!(all, on(3, 4));
    let [low, high] = all.rates[0].kept_10_90.unwrap();
    assert!(low < high);
    // One chip is its own spread, and it is the first of the four.
    let one = on(2, 1);
    let [low, high] = one.rates[0].kept_10_90.unwrap();
    assert_eq!([low, high], [one.rates[0].headline.kept.unwrap(); 2]);
}

#[test]
fn rates_that_show_nothing_are_refused() {
    let (kernel, device) = (ternary(), Device::scamp5());
    let fall = Fall::new(question(design(&kernel, &device, 32.0))).unwrap();
    let open = || scene::open(SCENE, &OpenOptions::default());
    for rate in [1.0, 1e9, 0.0, f64::NAN] {
        let error = fall.rates(&choice(&[rate], 1), &open, &|| {}).unwrap_err();
        let is_rate = matches!(error, WaterfallError::Rate { most: 4000, .. });
        let is_bad = matches!(error, WaterfallError::Study(StudyError::Scene(_)));
        assert!(if rate >= 1.0 { is_rate } else { is_bad }, "{error}");
        // The same is known before anything is compiled.
        let scene = open().unwrap();
        let early = choice(&[rate], 1).check(scene.frames().unwrap(), scene.fps());
        assert_eq!(early.unwrap_err().to_string(), error.to_string());
    }
}

#[cfg(feature = "cli")]
mod verb {
    use std::{fs, path::Path};

    use assert_cmd::Command;
    use serde_json::Value;
    use tempfile::TempDir;

    const SCENE: &str = "pattern:disc?width=32&height=24&frames=8&radius=6";

    fn amacrine(folder: &Path, arguments: &[&str]) -> Command {
        crate::common::amacrine(folder, &[&["waterfall"], arguments].concat())
    }

    fn asked<'a>(more: &[&'a str]) -> Vec<&'a str> {
        let ask = [
            "csdvs-3",
            "--threshold",
            "20",
            "--scene",
            SCENE,
            "--effort",
            "0.01",
            "--within",
            "10ms",
        ];
        [&ask[..], more].concat()
    }

    #[test]
    fn it_prints_draws_and_tells_machines() {
        let folder = TempDir::new().unwrap();
        let at = folder.path();
        let more = ["--steps", "-o", "fall.svg"];
        let said = amacrine(at, &asked(&more)).assert().success();
        let text = String::from_utf8_lossy(&said.get_output().stdout).into_owned();
        for word in [
            "memory rule",
            "temporal noise",
            "first to last at once",
            "scan readout",
            "as a threshold",
        ] {
            assert!(text.contains(word), "no {word} in {text}");
        }
        let drawn = fs::read_to_string(at.join("fall.svg")).unwrap();
        assert!(drawn.starts_with("<svg") && drawn.contains("temporal noise"));
        let more = ["--json", "--steps", "-o", "fall.png"];
        let said = amacrine(at, &asked(&more)).assert().success();
        let json: Value = serde_json::from_slice(&said.get_output().stdout).unwrap();
        let steps = json["steps"].as_array().unwrap();
        assert_eq!(steps.len(), 11);
        assert_eq!(steps[10]["cause"], "readout");
        assert!(json["rates"].is_null());
        for row in steps.iter().chain([&json]) {
            for key in ["kept", "window_us", "fps", "threshold_equivalent_percent"] {
                assert!(row[key].is_number(), "{key} of {row}");
            }
        }
        assert!(steps[0]["backward"].is_null() && steps[1]["backward"]["kept"].is_u64());
        let events = json["float_events"].as_u64().unwrap();
        let lost = steps[2]["forward"]["lost"].as_u64().unwrap();
        let share = steps[2]["forward_share"]["lost"].as_f64().unwrap();
        assert_eq!(share, lost as f64 / events as f64);
        let picture = image::open(at.join("fall.png")).unwrap();
        assert!(picture.width() > 1000 && picture.height() > 800);
        // A format, a what-if, a readout.
        let more = ["--format", "q8.8", "--readout", "ideal", "--json"];
        let said = amacrine(at, &asked(&more)).assert().success();
        let json: Value = serde_json::from_slice(&said.get_output().stdout).unwrap();
        assert_eq!(json["steps"].as_array().unwrap().len(), 6);
        assert_eq!(json["steps"][5]["forward"]["lost"], 0);
        let more = ["--set", "error.analogue_decay=500", "--json"];
        let said = amacrine(at, &asked(&more)).assert().success();
        let json: Value = serde_json::from_slice(&said.get_output().stdout).unwrap();
        assert_eq!(json["steps"][9]["cause"], "decay");
        assert!(json["steps"][9]["forward"]["kept"] != json["steps"][8]["forward"]["kept"]);
    }

    #[test]
    fn an_error_that_is_set_where_cells_do_not_err_is_told_of() {
        let folder = TempDir::new().unwrap();
        for (format, set, told) in [
            ("q8.8", "error.noise=50", true),
            ("q8.8", "clock.rate=11", false),
            ("silicon", "error.noise=5", false),
        ] {
            let more = ["--format", format, "--set", set, "--steps"];
            let said = amacrine(folder.path(), &asked(&more)).assert().success();
            let text = String::from_utf8_lossy(&said.get_output().stderr).into_owned();
            let note = "note: error.noise changes nothing in the domain q8.8, whose cells do not err: --format silicon has errors";
            assert_eq!(text.contains(note), told, "{format} {set}: {text}");
        }
    }

    #[test]
    fn a_format_that_cannot_hold_the_light_is_told_of() {
        let folder = TempDir::new().unwrap();
        for (format, told) in [
            ("q4.12", true),
            ("q7.9", true),
            ("q8.8", false),
            ("silicon", false),
        ] {
            let more = ["--format", format, "--steps", "--json"];
            let said = amacrine(folder.path(), &asked(&more)).assert().success();
            let json: Value = serde_json::from_slice(&said.get_output().stdout).unwrap();
            let warnings = json["warnings"].as_array().unwrap();
            let is = |warning: &&Value| warning["about"] == "saturation";
            let found = warnings.iter().find(is);
            assert_eq!(found.is_some(), told, "{format}: {warnings:?}");
            if let Some(found) = found {
                let seen = found["seen"].as_str().unwrap();
                let holds = format!("{format} holds -");
                assert!(
                    seen.starts_with(&holds) && seen.contains("-127 LSB"),
                    "{seen}"
                );
                let change = found["change"].as_str().unwrap();
                let format = "take a format of 8 bits or more before the point, such as q8.8";
                assert_eq!(change, format);
            }
        }
    }

    #[test]
    fn rates_are_printed_drawn_and_told() {
        let folder = TempDir::new().unwrap();
        let at = folder.path();
        // Slow enough for the chip: 40 frames a second, and up to three times as many.
        let slow = "pattern:disc?width=32&height=24&frames=20&radius=6&speed=60&fps=40";
        let asked = |more: &[&str]| {
            let ask = [
                "csdvs-3",
                "--threshold",
                "20",
                "--scene",
                slow,
                "--effort",
                "0.01",
            ];
            let all = [&ask[..], &["--chips", "3"], more].concat();
            let said = amacrine(at, &all).assert().success();
            String::from_utf8_lossy(&said.get_output().stdout).into_owned()
        };
        let text = asked(&["-o", "fall.svg"]);
        for word in [
            "40 frames/s",
            "120 frames/s",
            "memory rule",
            "as a threshold higher by",
            "noise alone",
            "sigmas",
            "3 chips",
        ] {
            assert!(text.contains(word), "no {word} in {text}");
        }
        let drawn = fs::read_to_string(at.join("fall.svg")).unwrap();
        assert!(drawn.starts_with("<svg") && drawn.contains("120 frames/s"));
        assert!(drawn.contains("Where the events of csdvs-3 in ternary went: scamp5"));
        let json: Value = serde_json::from_str(&asked(&["--json"])).unwrap();
        assert_eq!(json["steps"].as_array().unwrap().len(), 11);
        assert!(json["ceiling_fps"].as_f64().unwrap() > 120.0);
        let rates = json["rates"].as_array().unwrap();
        let fps: Vec<f64> = rates.iter().map(|r| r["fps"].as_f64().unwrap()).collect();
        assert_eq!(fps, [40.0, 80.0, 120.0]);
        for rate in rates {
            for key in ["kept", "window_us", "fps", "threshold_equivalent_percent"] {
                assert!(rate[key].is_number(), "{key} of {rate}");
            }
            assert_eq!(rate["window_us"], 100_000);
            assert_eq!(rate["kept_10_90"].as_array().unwrap().len(), 2);
            let causes = rate["causes"].as_array().unwrap();
            assert_eq!(causes.len(), 11);
            let sum: f64 = causes.iter().map(|c| c["share"].as_f64().unwrap()).sum();
            assert!((sum + rate["kept"].as_f64().unwrap() - 1.0).abs() < 1e-9);
            assert_eq!(causes[8]["cause"], "noise");
            assert_eq!(causes[8]["how"], "shapley");
            assert!(rate["noise"]["events_per_second"].is_number());
        }
        let more = ["--rates", "20,40", "--json", "-o", "fall.png"];
        let json: Value = serde_json::from_str(&asked(&more)).unwrap();
        assert_eq!(json["rates"][0]["fps"], 20.0);
        let picture = image::open(at.join("fall.png")).unwrap();
        assert!(picture.width() > 1500 && picture.height() > 1000);
    }

    /// Of a scan no figure tells how late it is.
    #[test]
    fn what_cannot_keep_up_is_warned_of() {
        let folder = TempDir::new().unwrap();
        let told = |more: &[&str]| {
            let said = amacrine(folder.path(), &asked(more)).assert().success();
            let json: Value = serde_json::from_slice(&said.get_output().stdout).unwrap();
            let warnings = json["warnings"].as_array().unwrap().clone();
            let about = warnings.iter().map(|one| one["about"].clone());
            about.filter(|about| about == "late").count()
        };
        let steps = ["--steps", "--json"];
        let slow = [
            "--readout",
            "scan",
            "--with",
            "slots=4000",
            "--with",
            "slot=100us",
        ];
        assert_eq!(told(&steps), 0);
        assert_eq!(told(&[&steps[..], &slow].concat()), 1);
    }

    #[test]
    fn mistakes_are_named_and_leave_no_file() {
        let folder = TempDir::new().unwrap();
        let at = folder.path();
        let refused = |arguments: &[&str], words: &[&str]| {
            let said = amacrine(at, arguments).assert().code(2);
            let message = String::from_utf8_lossy(&said.get_output().stderr).into_owned();
            let message = message.replace('│', " ");
            let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
            for word in words {
                assert!(message.contains(word), "no {word:?} in: {message}");
            }
            assert!(!message.contains("panicked"), "{message}");
        };
        refused(&["nosuch", "--threshold", "9"], &["nosuch", "csdvs-3"]);
        refused(&["csdvs-3"], &["--threshold"]);
        refused(&asked(&["--to", "trinary"]), &["trinary", "ternary"]);
        refused(&asked(&["--format", "q9.9"]), &["q9.9", "qM.N"]);
        refused(&asked(&["--chip", "scamp9"]), &["scamp9", "scamp5"]);
        refused(&asked(&["--readout", "scam"]), &["scam", "arbiter"]);
        refused(
            &asked(&["--set", "error.nose=1"]),
            &["error.nose", "error.noise"],
        );
        refused(&asked(&["-o", "fall.pdf"]), &["fall.pdf", ".svg"]);
        refused(&asked(&["--rates", "10,0"]), &["0", "above 0"]);
        refused(&asked(&["--rates", "1e7"]), &["frames/s", "2 to 4000"]);
        refused(
            &asked(&["--steps", "--rates", "10"]),
            &["--steps", "--rates"],
        );
        for (threshold, said) in [("0", "threshold is 0"), ("-3", "threshold is -3")] {
            refused(
                &["csdvs-3", "--threshold", threshold, "-o", "fall.svg"],
                &[said, "positive"],
            );
        }
        refused(
            &[
                "csdvs-3",
                "--threshold",
                "9",
                "--scene",
                "pattern:static?width=16&height=16&frames=3",
                "-o",
                "fall.svg",
            ],
            &["no event", "lower the threshold"],
        );
        let dense: Vec<Vec<f64>> = (0..15)
            .map(|y| {
                (0..15)
                    .map(|x| f64::from((y * 37 + x * 101) % 89) / 89.0 - 0.4)
                    .collect()
            })
            .collect();
        let text = format!("name = \"dense\"\nsource = \"test\"\nweights = {dense:?}\n");
        fs::write(at.join("dense.toml"), text).unwrap();
        refused(
            &[
                "dense.toml",
                "--threshold",
                "40",
                "--to",
                "q1.7",
                "--effort",
                "0.01",
                "-o",
                "fall.svg",
            ],
            &[
                "no waterfall of dense.toml on scamp5",
                "instruction words",
                "use fewer digits",
            ],
        );
        assert_eq!(at.read_dir().unwrap().count(), 1, "files were left");
    }
}

/// Of several kernels one is drawn, as it falls in the program of all of them.
#[test]
#[cfg(feature = "cli")]
fn one_of_several_kernels_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let asked = [
        "waterfall",
        "sobel-x,laplacian",
        "--threshold",
        "40",
        "--steps",
        "--effort",
        "0.01",
    ];
    let asked = [&asked[..], &["--scene", SCENE, "-o", "w.svg"]].concat();
    let words = [
        "2 kernels, and --output draws one",
        "--kind N",
        "sobel-x, laplacian",
    ];
    common::refused(folder, &asked, &words);
    common::refused(
        folder,
        &[&asked[..], &["--kind", "2"]].concat(),
        &["--kind 2", "0 to 1"],
    );
    let drawn = |kind: &str| {
        common::good(folder, &[&asked[..], &["--kind", kind]].concat());
        std::fs::read_to_string(folder.join("w.svg")).unwrap()
    };
    let (named, numbered) = (drawn("laplacian"), drawn("1"));
    assert!(
        named.contains("laplacian, one of 2 in one program"),
        "{named}"
    );
    assert!(named == numbered && named != drawn("0"));
}
