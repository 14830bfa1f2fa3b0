//! Random instruction words and values, and the chip that they are for.

#![allow(dead_code)] // Each test takes what it needs.

use amacrine::isa::{Analog, Bit, Device, Digital, Direction, Primitive, Source, Target};
use proptest::prelude::*;

/// Read once; its files are the same for all.
pub fn device() -> &'static Device {
    static DEVICE: std::sync::LazyLock<Device> = std::sync::LazyLock::new(Device::scamp5);
    &DEVICE
}

/// Values that are spread, exact in most formats, and now and then beyond a limit.
pub fn value(seed: u64, i: u64) -> f64 {
    let hash = (seed ^ i.wrapping_mul(0x9E37_79B9_7F4A_7C15)).wrapping_mul(0xD6E8_FEB8_6659_FD93);
    let hash = (hash ^ hash >> 32).wrapping_mul(0xD6E8_FEB8_6659_FD93);
    ((hash >> 40) % 4000) as f64 / 16.0 - 125.0
}

/// Of a bus: distinct, as the chip asks for.
pub fn operands() -> impl Strategy<Value = (Vec<Target>, Vec<Source>)> {
    let mut all: Vec<Source> = (0..7).map(|r| Source::Register(Analog(r))).collect();
    all.extend(Direction::ALL.map(Source::Neighbour));
    all.extend([Source::Pix, Source::In]);
    (Just(all).prop_shuffle(), 1usize..=3, 0usize..=4).prop_map(|(all, targets, sources)| {
        let to: Vec<Target> = all
            .iter()
            .filter_map(|operand| match operand {
                Source::Register(register) => Some(Target::Register(*register)),
                Source::Neighbour(direction) => Some(Target::Neighbour(*direction)),
                Source::Pix | Source::In => None,
            })
            .take(targets)
            .collect();
        let free = |source: &&Source| {
            !to.iter().any(|target| match (target, source) {
                (Target::Register(a), Source::Register(b)) => a == b,
                (Target::Neighbour(a), Source::Neighbour(b)) => a == b,
                _ => false,
            })
        };
        let from = all.iter().filter(free).take(sources).copied().collect();
        (to, from)
    })
}

/// A one-bit register.
pub fn digital() -> impl Strategy<Value = Digital> {
    // The registers with a part of their own more often.
    prop_oneof![Just(0u8), Just(12), 1u8..5, 0u8..13].prop_map(Digital)
}

/// What a one-bit word reads.
pub fn bits() -> impl Strategy<Value = Vec<Bit>> {
    let bit = prop_oneof![
        6 => digital().prop_map(Bit::Register),
        1 => Just(Bit::Flag),
        1 => Just(Bit::Select),
        1 => Just(Bit::Rect)
    ];
    prop::collection::vec(bit, 1..=4)
}

/// One word, legal on SCAMP-5.
pub fn word() -> impl Strategy<Value = Primitive> {
    let registers = || prop::collection::vec(digital(), 1..=4);
    let analog = || (0u8..7).prop_map(Analog);
    prop_oneof![
        8 => operands().prop_map(|(targets, sources)| Primitive::Bus { targets, sources }),
        2 => operands().prop_map(|(_, sources)| Primitive::Where { sources }),
        1 => operands().prop_map(|(_, sources)| Primitive::Square { sources }),
        1 => Just(Primitive::All),
        1 => prop::sample::select(vec![
            Primitive::Nop, Primitive::ResetPix, Primitive::BlurSet, Primitive::PropRead
        ]),
        1 => (analog(), analog(), any::<bool>(), any::<bool>()).prop_map(
            |(target, source, horizontal, vertical)| {
                Primitive::Blur { target, source, horizontal, vertical }
            }
        ),
        1 => registers().prop_map(|targets| Primitive::Set { targets }),
        1 => registers().prop_map(|targets| Primitive::Clear { targets }),
        2 => (digital(), bits()).prop_map(|(target, sources)| Primitive::Or { target, sources }),
        2 => (digital(), bits()).prop_map(|(target, sources)| Primitive::Nor { target, sources }),
        1 => bits().prop_map(|sources| Primitive::WhereBit { sources }),
        1 => (digital(), bits(), any::<bool>()).prop_map(|(target, sources, boundary)| {
            Primitive::Dnews { target, source: sources[0], boundary }
        }),
        1 => any::<bool>().prop_map(|boundary| Primitive::Prop { boundary }),
    ]
}
