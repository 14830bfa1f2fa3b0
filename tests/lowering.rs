//! A loop is what its body written out is: registers, events, readings and words, wherever the
//! ends of basic blocks fall.

use amacrine::{
    array::{Arithmetic, Ledger, Schedule, Settings},
    event::Packet,
    isa::{Analog, Bit, Device, Digital, Direction, Primitive, Source, Target},
    plane::{Plane, Size},
    program::{Action, Code, Host, Step},
    unit::Micros,
};
use proptest::prelude::*;

fn device() -> &'static Device {
    static DEVICE: std::sync::LazyLock<Device> = std::sync::LazyLock::new(Device::scamp5);
    &DEVICE
}

fn step(action: Action) -> Step {
    Step {
        action,
        line: 1,
        origin: None,
    }
}

/// What a word may sum that stores in `target`.
fn others(mut sources: Vec<Source>, target: u8) -> Vec<Source> {
    sources.retain(|source| *source != Source::Register(Analog(target)));
    sources
}

/// Words that leave something else behind each time that they run, and what stands between
/// blocks.
fn item() -> impl Strategy<Value = Action> {
    let source = prop_oneof![
        4 => (0u8..6).prop_map(|k| Source::Register(Analog(k))),
        2 => Just(Source::In),
        1 => Just(Source::Pix),
    ];
    // A cell is on a bus once.
    let sources = prop::collection::vec(source, 1..3).prop_map(|mut sources: Vec<Source>| {
        sources.dedup();
        sources
    });
    prop_oneof![
        8 => ((0u8..6), sources.clone()).prop_map(|(target, sources)| Action::Word(Primitive::Bus {
            targets: vec![Target::Register(Analog(target))],
            sources: others(sources, target),
        })),
        1 => sources.prop_map(|sources| Action::Word(Primitive::Where { sources })),
        1 => Just(Action::Word(Primitive::All)),
        1 => Just(Action::Word(Primitive::Bus {
            targets: vec![Target::Neighbour(Direction::North)],
            sources: vec![Source::Register(Analog(2))],
        })),
        1 => Just(Action::Word(Primitive::Nor {
            target: Digital(7),
            sources: vec![Bit::Flag],
        })),
        1 => Just(Action::Word(Primitive::Prop { boundary: false })),
        3 => (-90i8..90).prop_map(|value| Action::Host(Host::LoadIn { value: value.into() })),
        1 => (0u8..6).prop_map(|k| Action::Host(Host::ReadAnalog { source: Analog(k) })),
    ]
}

/// Bodies with loops in loops.
fn body() -> impl Strategy<Value = Vec<Step>> {
    let leaf = prop::collection::vec(item().prop_map(step), 0..6);
    leaf.prop_recursive(3, 24, 4, |inner| {
        let repeat = (0u32..12, inner.clone())
            .prop_map(|(times, body)| vec![step(Action::Repeat { times, body })]);
        prop::collection::vec(prop_oneof![inner, repeat], 1..4).prop_map(|parts| parts.concat())
    })
}

/// A body without its loops.
fn written_out(body: &[Step], all: &mut Vec<Step>) {
    for step in body {
        if let Action::Repeat { times, body } = &step.action {
            for _ in 0..*times {
                written_out(body, all);
            }
        } else {
            all.push(step.clone());
        }
    }
}

/// What can be seen of a chip after three frames.
type Seen = (Vec<Plane<f64>>, Vec<Plane<bool>>, Vec<String>, Ledger);

fn ran(domain: &str, frame: Vec<Step>, size: Size, schedule: Schedule) -> Seen {
    let arithmetic: Arithmetic = domain.parse().expect("a domain");
    let code = Code {
        init: vec![],
        frame,
    };
    let settings = Settings {
        schedule: Some(schedule),
        threads: Some(2),
        ..Settings::from_device(device())
    };
    let mut chip = arithmetic
        .chip("loops", &code, device(), size, settings)
        .expect("a legal program");
    let mut packet = Packet::new(size, 1);
    let mut readings = Vec::new();
    for frame in 0..3 {
        let light = Plane::from_shape_fn(size.shape(), |(y, x)| {
            ((7 * y + 13 * x + 29 * frame) % 255) as f64
        });
        chip.expose(&light).expect("its size");
        chip.run_frame(Micros(0), &mut packet).expect("numbers");
        readings.push(format!("{:?}", chip.readings()));
    }
    // A loop launches its kernel each time.
    let ledger = Ledger {
        launches: 0,
        ..chip.ledger()
    };
    let analog = (0..7).map(|k| chip.analog(Analog(k))).collect();
    let digital = (0..13).map(|k| chip.digital(Digital(k))).collect();
    (analog, digital, readings, ledger)
}

fn agree(body: &[Step]) {
    let mut flat = Vec::new();
    written_out(body, &mut flat);
    for (size, schedule) in [
        (Size::new(9, 7), Schedule::Plain),
        (Size::new(21, 70), Schedule::Plain),
        (Size::new(21, 70), Schedule::Tiled { rows: 2 }),
    ] {
        for domain in ["q8.8", "silicon"] {
            let looped = ran(domain, body.to_vec(), size, schedule);
            assert!(
                looped == ran(domain, flat.clone(), size, schedule),
                "{domain} {schedule} {size}: {body:?}"
            );
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn a_loop_is_its_body_written_out(body in body()) {
        agree(&body);
    }
}

/// A block holds 1024 words: loops of which so many, one fewer or one more are in a block, and
/// bodies that are longer than one.
#[test]
fn loops_end_anywhere_in_a_block() {
    let add = |k: usize| {
        let register = |k: usize| Analog((k % 5) as u8);
        step(Action::Word(Primitive::Bus {
            targets: vec![Target::Register(register(k))],
            sources: vec![Source::Register(register(k + 1)), Source::In],
        }))
    };
    let load = |value: f64| step(Action::Host(Host::LoadIn { value }));
    for (before, body, times) in [
        (0, 1, 1023),
        (0, 1, 1024),
        (0, 1, 1025),
        (3, 7, 146),
        (1020, 5, 2),
        (0, 600, 3),
        (10, 1030, 2),
    ] {
        let mut steps: Vec<_> = (0..before).map(add).collect();
        let body = (0..body).flat_map(|k| {
            let value = (k % 5) as f64 - 2.0;
            [add(k)]
                .into_iter()
                .chain((k % 3 == 0).then(|| load(value)))
        });
        steps.push(step(Action::Repeat {
            times,
            body: body.collect(),
        }));
        steps.push(add(3));
        agree(&steps);
    }
}
