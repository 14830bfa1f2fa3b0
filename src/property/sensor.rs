//! Sensors of the float model at random: every rule, every effect, every way to see.

use proptest::{collection::vec, prelude::*, sample::select};

use crate::{
    kernel::Kernel,
    mesh::{Between, Sheet},
    photoreceptor::{Curve, Response},
    plane::Plane,
    reference::{
        Border, Channel, Description, MemoryRule, Noise, PolarityRule, Refractory, RefractoryRule,
        SheetRule, Surround, Surrounds, Threshold,
    },
};

/// Sensors that a file can state, of one to three kinds of cells, which fire in light from 0 to 255:
/// any memory with what it can have, and each effect in some of them.
pub fn sensors() -> impl Strategy<Value = Description> {
    select(MemoryRule::ALL).prop_flat_map(|memory| {
        (responses(), refractories(memory)).prop_flat_map(move |(response, refractory)| {
            let [dark, bright] = [0.0, 255.0].map(|light| response.apply(light).unwrap_or(0.0));
            let rules = (
                names(),
                any::<bool>(),
                select(PolarityRule::ALL),
                select(Border::ALL),
            );
            let leaks = !memory.holds_pixels() && refractory.rule != RefractoryRule::Authors;
            let kinds = vec(channels(memory, bright - dark), 1..=3);
            (rules, noises(leaks), kinds).prop_map(move |(rules, noise, channels)| {
                let (name, shared, polarity, border) = rules;
                let polarity = if memory.steps() {
                    PolarityRule::Filtered
                } else {
                    polarity
                };
                Description {
                    name: name.to_owned(),
                    response,
                    memory,
                    shared: shared && memory.may_be_shared(),
                    polarity,
                    border,
                    refractory,
                    noise,
                    channels,
                }
            })
        })
    })
}

fn names() -> impl Strategy<Value = &'static str> {
    select(&["a", "", "\"two\" words\\\n[[channel]]", "\u{7f}\u{e9}"][..])
}

/// 0, or a number of the range.
fn or_zero(range: std::ops::Range<f64>) -> impl Strategy<Value = f64> + Clone {
    prop_oneof![2 => Just(0.0), 1 => range]
}

fn responses() -> impl Strategy<Value = Response> {
    let white = || 100.0..300.0;
    let straight = prop_oneof![
        white().prop_map(|white| Curve::Linear { white }),
        (white(), 1e-3..0.1).prop_map(|(white, offset)| Curve::Log { white, offset }),
    ];
    prop_oneof![
        Just(Response::IDENTITY),
        (1.5..100.0).prop_map(|knee| Response::new(Curve::LinLog { knee })),
        (straight, any::<bool>()).prop_map(|(curve, round_f32)| Response { curve, round_f32 }),
    ]
}

fn refractories(memory: MemoryRule) -> impl Strategy<Value = Refractory> {
    (or_zero(50.0..30_000.0), select(memory.refractory_rules()))
        .prop_map(|(us, rule)| Refractory { us, rule })
}

fn noises(leaks: bool) -> impl Strategy<Value = Noise> {
    let leak = (or_zero(0.1..20.0), or_zero(0.0..0.5));
    let fires = (
        or_zero(1.0..50.0),
        0.0..=1.0,
        or_zero(0.01..0.3),
        or_zero(1.0..90.0),
    );
    let others = (or_zero(1.0..3000.0), or_zero(1.0..300.0));
    (leak, fires, others, select(Between::ALL)).prop_map(
        move |(leak, fires, others, cutoff_rule)| {
            let (leak_hz, leak_spread) = leak;
            let (shot_hz, shot_at_white, hot_fraction, hot_hz) = fires;
            let (jitter_us, cutoff_hz) = others;
            Noise {
                leak_hz: if leaks { leak_hz } else { 0.0 },
                leak_spread,
                shot_hz,
                shot_at_white,
                hot_fraction,
                hot_hz,
                jitter_us,
                cutoff_hz,
                cutoff_rule,
            }
        },
    )
}

/// What a kind of cells sees through.
#[derive(Clone, Debug)]
enum Field {
    Kernels(Vec<Kernel>),
    Mesh(Surrounds),
}

fn channels(memory: MemoryRule, span: f64) -> impl Strategy<Value = Channel> {
    let field = prop_oneof![
        3 => kernel().prop_map(|kernel| Field::Kernels(vec![kernel])),
        1 => vec(kernel(), 4).prop_map(Field::Kernels),
        1 => meshes().prop_map(Field::Mesh),
    ];
    let field = field.prop_filter("a mesh before a memory of pixels", move |field| {
        matches!(field, Field::Kernels(_)) || !memory.holds_pixels()
    });
    let name = proptest::option::of(names());
    let held = pixel(0.3..1.0);
    let rest = (name, held, any::<bool>(), pixel(1.0..1.0 + f64::EPSILON));
    (field, vec(threshold(span), 4), rest).prop_map(move |(field, mut thresholds, rest)| {
        let (name, held, log_temporal, one) = rest;
        let is_mesh = matches!(field, Field::Mesh(_));
        let (kernels, surrounds) = match field {
            Field::Kernels(kernels) => (kernels, None),
            Field::Mesh(surrounds) => (vec![one], Some(surrounds)),
        };
        thresholds.truncate(kernels.len());
        Channel {
            name: name.map(str::to_owned),
            kernels,
            surrounds,
            thresholds,
            memory_kernel: memory.has_kernel().then_some(held),
            log_temporal: log_temporal && !is_mesh && !memory.holds_pixels(),
        }
    })
}

fn threshold(span: f64) -> impl Strategy<Value = Threshold> {
    (0.02..0.3, 0.02..0.3, or_zero(0.001..0.05)).prop_map(move |(on, off, sigma)| Threshold {
        on: on * span,
        off: off * span,
        sigma: sigma * span,
    })
}

/// A kernel of one weight.
fn pixel(weights: std::ops::Range<f64>) -> impl Strategy<Value = Kernel> {
    weights.prop_filter_map("a weight that is none", |weight| {
        Kernel::new(Plane::from_elem((1, 1), weight)).ok()
    })
}

fn kernel() -> impl Strategy<Value = Kernel> {
    select(&[(1, 1), (3, 3), (1, 3), (5, 1)][..]).prop_flat_map(|(height, width)| {
        vec(-1.0..1.5, height * width).prop_filter_map("weights that are none", move |weights| {
            Kernel::new(Plane::from_shape_vec((height, width), weights).ok()?).ok()
        })
    })
}

fn meshes() -> impl Strategy<Value = Surrounds> {
    let sheet = (
        -2.0..2.0,
        (0.3..6.0, 0.3..6.0),
        or_zero(1.0..20_000.0),
        or_zero(1e-4..0.1),
    );
    (select(SheetRule::ALL), -1.0..1.0, vec(sheet, 1..=2)).prop_filter_map(
        "a space constant that is none",
        |(rule, centre, sheets)| {
            let is_v2e = rule == SheetRule::V2e;
            let sheets = sheets.into_iter().map(|(gain, (down, across), us, noise)| {
                Some(Surround {
                    gain,
                    sheet: Sheet::anisotropic(if is_v2e { across } else { down }, across).ok()?,
                    // As a file states it.
                    tau: us * 1e-6,
                    noise: if is_v2e { 0.0 } else { noise },
                })
            });
            Some(Surrounds {
                centre,
                sheets: sheets.collect::<Option<_>>()?,
                rule,
            })
        },
    )
}
