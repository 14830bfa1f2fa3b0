//! Random programs without a bit in them, and a chip to run them on: for the tests of what can
//! be told about a program before it runs.

use amacrine::{
    array::{Array, Chip, Exact, Settings},
    event::Packet,
    isa::{Analog, Device, Direction, Primitive, Source, Target},
    plane::{Plane, Size},
    program::{Action, Code, Host, Step},
    unit::Micros,
};
use proptest::prelude::*;

/// Read once; its files are the same for all.
pub fn device() -> &'static Device {
    static DEVICE: std::sync::LazyLock<Device> = std::sync::LazyLock::new(Device::scamp5);
    &DEVICE
}

/// Large enough for the pixel in the middle not to see the border.
pub const SIZE: Size = Size::new(33, 33);
pub const MIDDLE: (usize, usize) = (16, 16);

pub fn sources() -> impl Strategy<Value = Vec<Source>> {
    let mut all: Vec<Source> = (0..7).map(|r| Source::Register(Analog(r))).collect();
    all.extend(Direction::ALL.map(Source::Neighbour));
    all.extend([Source::Pix, Source::In]);
    proptest::sample::subsequence(all, 0..=3).prop_shuffle()
}

/// A bus with one of so many targets.
pub fn bus(counts: &'static [usize]) -> impl Strategy<Value = Action> {
    let mut all: Vec<Target> = (0..7).map(|r| Target::Register(Analog(r))).collect();
    all.extend(Direction::ALL.map(Target::Neighbour));
    let targets = proptest::sample::select(counts)
        .prop_flat_map(move |n| proptest::sample::subsequence(all.clone(), n));
    (targets, sources()).prop_map(|(targets, sources)| {
        let own = |source: &Source| match source {
            Source::Register(register) => targets.contains(&Target::Register(*register)),
            Source::Neighbour(direction) => targets.contains(&Target::Neighbour(*direction)),
            Source::Pix | Source::In => false,
        };
        let sources = sources.iter().filter(|source| !own(source)).copied();
        Action::Word(Primitive::Bus {
            sources: sources.collect(),
            targets: targets.clone(),
        })
    })
}

pub fn load() -> impl Strategy<Value = Action> {
    (-8i32..8).prop_map(|value| {
        Action::Host(Host::LoadIn {
            value: f64::from(value),
        })
    })
}

/// Each action on a line of its own.
pub fn steps(actions: Vec<Action>) -> Vec<Step> {
    let step = |(action, line)| Step {
        action,
        line,
        origin: None,
    };
    actions.into_iter().zip(1..).map(step).collect()
}

/// What each register holds in the middle after the steps, in exact arithmetic.
pub fn ran(
    steps: &[Step],
    settings: Settings,
    light: &Plane<f64>,
    registers: &[Plane<f64>],
) -> Vec<f64> {
    let code = Code {
        init: vec![],
        frame: steps.to_vec(),
    };
    let mut chip = Chip::new("test", Exact, &code, device(), SIZE, settings).unwrap();
    for (r, plane) in (0..).zip(registers) {
        chip.set_analog(Analog(r), plane).unwrap();
    }
    chip.expose(light).unwrap();
    chip.run_frame(Micros(0), &mut Packet::new(SIZE, 1))
        .unwrap();
    (0..7).map(|r| chip.analog(Analog(r))[MIDDLE]).collect()
}

/// Whole numbers of some interval, by a hash.
pub fn noise(seed: u64, low: i64, high: i64) -> Plane<f64> {
    Plane::from_shape_fn(SIZE.shape(), |(y, x)| {
        let hash = (seed ^ (y * 40 + x) as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let hash = (hash ^ hash >> 29).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 33;
        (low + (hash % (high - low + 1) as u64) as i64) as f64
    })
}
