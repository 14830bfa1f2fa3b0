//! Proves that an arithmetic whose numbers have the digits that a program needs computes as the
//! exact one does, to the bit: registers, one-bit registers and events, over random programs and
//! those that come with amacrine, in random 8-bit light, at the array's border too.

use amacrine::{
    array::{Arithmetic, Digits, Layout, Settings, range::Interval},
    bundled::{self, Kind},
    event::Packet,
    isa::{Analog, Device, Digital, operands::Unit},
    number::Format,
    plane::{Plane, Size},
    program::{Action, Code, Host, Overrides, Program, Step},
    rng::Hash,
    unit::Micros,
};
use proptest::prelude::*;
use words::word;

mod words;

const FORMATS: [&str; 8] = [
    "f32", "f16", "bf16", "q8.8", "q9.7", "q12.4", "q16.16", "q4.12",
];

const EIGHT_BITS: Interval = Interval::new(0.0, 255.0);

fn formats() -> impl Iterator<Item = Format> {
    FORMATS.iter().map(|name| name.parse().unwrap())
}

/// All that an array holds after each of some frames, and its events.
fn seen(
    code: &Code,
    settings: Settings,
    format: Format,
    size: Size,
    seed: u64,
) -> Option<Vec<String>> {
    let device = Device::scamp5();
    let mut chip = Arithmetic::Number(format)
        .chip("digits", code, &device, size, settings)
        .ok()?;
    let mut all = Vec::new();
    let Layout {
        analog, digital, ..
    } = chip.layout();
    for frame in 0..6 {
        let hash = Hash::new(seed).with(frame);
        // Black and white among them.
        let light = |(y, x): (usize, usize)| {
            let one = hash.with((y * size.width + x) as u64).uniform();
            (one * 300.0 - 20.0).clamp(0.0, 255.0).round()
        };
        chip.expose(&Plane::from_shape_fn(size.shape(), light))
            .unwrap();
        let (mut packet, t) = (Packet::new(size, chip.channels()), Micros(1000 * frame));
        if frame == 0 {
            chip.run_init(t, &mut packet).ok()?;
        } else {
            chip.run_frame(t, &mut packet).ok()?;
        }
        // 0 and -0 are one number.
        let held = (0..analog).map(|r| chip.analog(Analog(r)).mapv(|value| value + 0.0));
        let bits = (0..digital).map(|r| chip.digital(Digital(r)));
        let (held, bits): (Vec<_>, Vec<_>) = (held.collect(), bits.collect());
        let flag = chip.flag();
        all.push(format!("{held:?} {bits:?} {flag:?} {:?}", packet.events));
    }
    Some(all)
}

fn body(words: usize) -> impl Strategy<Value = Vec<Step>> {
    let step = |action| Step { action, line: 1 };
    let device = Device::scamp5();
    let value = prop::sample::select(vec![-100.0, -7.0, -0.5, 0.0, 0.375, 3.0, 60.0, 0.1]);
    let one = prop_oneof![
        9 => word()
            .prop_filter("of these nothing is said", move |word| {
                matches!(device.operands(word).unit, Unit::Bus | Unit::Logic)
            })
            .prop_map(Action::Word),
        1 => value.prop_map(|value| Action::Host(Host::LoadIn { value })),
    ];
    prop::collection::vec(one.prop_map(step), 1..words)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]
    #[test]
    fn formats_with_enough_digits_compute_the_same(
        init in body(4),
        frame in body(12),
        clip: bool,
        edge in prop::sample::select(vec![0.0, 0.0, -3.0, 0.25]),
        (height, width) in (1usize..5, 1usize..7),
        seed in 0u64..1000,
    ) {
        let device = Device::scamp5();
        let code = Code { init, frame };
        let settings = Settings { clip, edge, ..Settings::from_device(&device) };
        let size = Size::new(height, width);
        let Some(digits) = Digits::of(&code, &device, settings, EIGHT_BITS) else {
            return Ok(());
        };
        let exact = seen(&code, settings, Format::F64, size, seed);
        for format in formats().filter(|format| digits.fit(*format)) {
            prop_assert_eq!(&seen(&code, settings, format, size, seed), &exact, "{}", format);
        }
    }
}

/// Of the programs that come with amacrine most compute in q8.8 what they compute exactly.
#[test]
fn bundled_programs_have_few_digits() {
    let device = Device::scamp5();
    let settings = Settings::from_device(&device);
    let size = Size::new(9, 13);
    let (mut programs, mut fit) = (0, Vec::new());
    for file in bundled::all(Kind::Program) {
        let program = Program::parse(file.name, file.text).unwrap();
        let Ok(expansion) = program.expand(&device, &Overrides::new()) else {
            continue;
        };
        programs += 1;
        let code = &expansion.code;
        let Some(digits) = Digits::of(code, &device, settings, EIGHT_BITS) else {
            continue;
        };
        let exact = seen(code, settings, Format::F64, size, 7);
        for format in formats().filter(|format| digits.fit(*format)) {
            fit.push((file.name, format.to_string()));
            assert_eq!(
                seen(code, settings, format, size, 7),
                exact,
                "{}",
                file.name
            );
        }
    }
    let of = |name: &str| fit.iter().filter(|(_, format)| format == name).count();
    assert!(programs >= 20, "{programs}");
    assert!(of("q8.8") >= 8 && of("f32") > of("bf16"), "{fit:?}");
    assert!(fit.contains(&("dvs/snap", "q8.8".into())), "{fit:?}");
    assert!(!fit.contains(&("dvs/snap", "q4.12".into())), "{fit:?}");
}
