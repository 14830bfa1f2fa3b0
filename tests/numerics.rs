//! Numbers at the extremes, as `docs/numerics.md` lists them: days of time, 10^9 steps of a
//! memory, light and thresholds over fifteen decades, bounds on counts and lists, arrays of one
//! pixel, kernels larger than the array, time that does not advance, and a sensor that would
//! fire for ever.

use amacrine::{
    event::{Packet, Polarity},
    number::{F32, F64, Format, Number, Q},
    plane::{Plane, Size},
    reference::{
        Counts, Description, EventList, Limit, Reference, Sink, Tally, VoxelGrid, WhenFull,
    },
    scene::{Frame, OpenOptions, Scene, open},
    sensor::{Sensor, SensorError},
};
use proptest::prelude::*;

const ONE: Size = Size::new(1, 1);

fn sensor(rules: &str, channel: &str) -> Description {
    let text = format!("{rules}\n[[channel]]\n{channel}\n");
    Description::parse("numerics.toml", &text, &|_| unreachable!())
        .unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// Each pixel alone, with one threshold for ON and OFF.
fn plain(response: &str, threshold: f64) -> Description {
    sensor(
        &format!("response = {response}\nmemory = \"filtered-step\""),
        &format!("kernel = [[1]]\nthreshold = {{ on = {threshold:e}, off = {threshold:e} }}"),
    )
}

fn frame(index: u64, seconds: f64, light: Plane<f64>) -> Frame {
    Frame {
        index,
        seconds,
        light: light.into(),
    }
}

/// One pixel that is `light` at the given times.
fn pixel<N: Number>(
    number: N,
    description: Description,
    light: &[(f64, f64)],
    sink: &mut impl Sink,
) -> Result<Reference<N>, SensorError> {
    let mut reference = Reference::with_number(number, description, ONE, 0)?;
    for (n, (seconds, light)) in light.iter().enumerate() {
        let light = Plane::from_elem((1, 1), *light);
        reference.watch_into(&frame(n as u64, *seconds, light), sink)?;
    }
    Ok(reference)
}

/// The signed events of the pixel from the first light to the second.
fn step<N: Number>(
    number: N,
    description: Description,
    from: f64,
    to: f64,
) -> Result<i32, SensorError> {
    let mut counts = Counts::new(ONE, 1);
    pixel(number, description, &[(0.0, from), (1.0, to)], &mut counts)?;
    Ok(counts.planes()[0][[0, 0]])
}

#[test]
fn time_does_not_drift_over_a_day() {
    // The frames of a scene: from their number, at a rate that no binary fraction holds.
    let mut scene = open(
        "pattern:flicker?width=1&height=1&frames=5000&fps=3333.3",
        &OpenOptions::default(),
    )
    .unwrap();
    let mut last = 0.0;
    while let Some(frame) = scene.next_frame().unwrap() {
        assert_eq!(frame.seconds, frame.index as f64 / 3333.3);
        last = frame.seconds;
    }
    assert_eq!(last, 4999.0 / 3333.3);
    // A crossing half-way between two frames a day, and a year, after the first.
    for fps in [1e3, 3333.3, 1e4] {
        for seconds in [86_400.0, 365.0 * 86_400.0] {
            let n = (seconds * fps) as u64;
            let at = |n: u64| n as f64 / fps;
            let mut packet = Packet::new(ONE, 1);
            let light = [(0.0, 0.0), (at(n), 0.0), (at(n + 1), 2.0)];
            let limit = Limit::default();
            pixel(
                F64,
                plain("\"identity\"", 1.0),
                &light,
                &mut EventList::new(&mut packet, limit),
            )
            .unwrap();
            // In whole numbers: (2 n + 1) / (2 fps), to the microsecond.
            let want = (2 * n as u128 + 1) * 1_000_000_000 / (2.0 * fps * 1e3).round() as u128;
            assert_eq!(packet.events.len(), 2);
            let got = u128::from(packet.events[0].t.0);
            assert!(
                got.abs_diff(want) <= 1,
                "{fps} frames/s after {seconds} s: {got} us, not {want}"
            );
        }
    }
}

#[test]
fn a_memory_does_not_drift_after_a_thousand_million_steps() {
    let theta = 0.2;
    let far = 0.999e9 * theta;
    let mut tally = Tally::new(1);
    let up_and_down: Vec<_> = (0..7u32)
        .map(|n| (f64::from(n), if n % 2 == 1 { far } else { 0.5 * theta }))
        .collect();
    let reference = pixel(F64, plain("\"identity\"", theta), &up_and_down, &mut tally).unwrap();
    assert!(tally.total() > 5_900_000_000);
    assert_eq!(reference.memory(0).unwrap()[[0, 0]], 0.5 * theta);
    // And through many small pairs.
    let mut reference = Reference::new(plain("\"identity\"", theta), ONE, 0).unwrap();
    let mut tally = Tally::new(1);
    for n in 0..200_000u64 {
        let light = if n % 2 == 1 { 1000.0 * theta } else { 0.0 };
        reference
            .watch_into(
                &frame(n, n as f64, Plane::from_elem((1, 1), light)),
                &mut tally,
            )
            .unwrap();
    }
    assert_eq!(tally.total(), 199_999 * 1000);
    assert_eq!(reference.memory(0).unwrap()[[0, 0]], 1000.0 * theta);
}

/// Light that goes up by few large steps and down by many small ones: what the memory holds is
/// what is left of the two, in every format.
#[test]
fn unequal_thresholds_run_away_in_no_format() {
    let flicker = |format: &str, (on, off): (f64, f64), frames: u64| {
        let text = format!("kernel = [[1]]\nthreshold = {{ on = {on}, off = {off} }}");
        let rules = "response = \"identity\"\nmemory = \"filtered-step\"";
        let format: Format = format.parse().unwrap();
        let mut reference = Reference::in_format(format, sensor(rules, &text), ONE, 0).unwrap();
        let mut packet = Packet::new(ONE, 1);
        for n in 0..frames {
            let light = if n % 2 == 1 { 60.0 } else { 4.0 };
            let frame = frame(n, n as f64, Plane::from_elem((1, 1), light));
            reference.watch(&frame, &mut packet).unwrap();
        }
        let ons = { packet.events.iter() }.filter(|e| e.polarity == Polarity::On);
        (ons.count() as u64, packet.events.len() as u64)
    };
    // 56 of light are 7 steps up and 14 down.
    for format in ["f64", "f32", "f16", "bf16", "q8.8", "q16.16"] {
        let (ons, all) = flicker(format, (8.0, 4.0), 3001);
        assert_eq!((ons, all), (1500 * 7, 1500 * 21), "{format}");
    }
    // Thresholds that no format holds: as many events in all of them, but for rounding.
    let (_, exact) = flicker("f64", (0.4, 0.1), 2001);
    for format in ["f32", "f16", "bf16", "q8.8"] {
        let (_, all) = flicker(format, (0.4, 0.1), 2001);
        let part = all as f64 / exact as f64;
        assert!((0.8..1.25).contains(&part), "{format}: {all} of {exact}");
    }
}

#[test]
fn a_memory_stops_with_an_error_beyond_what_it_counts() {
    let too_far = |steps: f64| step(F64, plain("\"identity\"", 1.0), 0.0, steps);
    assert_eq!(too_far(1_073_741_823.0).unwrap(), (1 << 30) - 1);
    let error = too_far(1_073_741_824.0).unwrap_err();
    assert!(matches!(error, SensorError::Uncountable { .. }));
    assert!(
        error.to_string().contains("2^30 thresholds or more"),
        "{error}"
    );
    // Twice the limit would wrap around.
    let twice = [(0.0, 0.0), (1.0, 1_073_741_824.0), (2.0, 2_147_483_648.0)];
    let mut tally = Tally::new(1);
    assert!(pixel(F64, plain("\"identity\"", 1.0), &twice, &mut tally).is_err());
}

#[test]
fn thresholds_too_small_to_count_in_are_refused() {
    let refused = |format: &str, threshold: f64, sigma: f64| {
        let rules = "response = \"identity\"\nmemory = \"filtered-step\"";
        let text = format!(
            "kernel = [[1]]\nthreshold = {{ on = {threshold:e}, off = 1, sigma = {sigma:e} }}"
        );
        let sensor = sensor(rules, &text);
        let made = Reference::in_format(format.parse().unwrap(), sensor, ONE, 0);
        made.err().map(|error| {
            let help = miette::Diagnostic::help(&error).unwrap().to_string();
            (error.to_string(), help)
        })
    };
    let (error, help) = refused("f32", 1e-39, 0.0).unwrap();
    assert!(
        error.contains("1e-39, too small for the format f32"),
        "{error}"
    );
    assert!(help.contains("give 3e-39 or more"), "{help}");
    assert_eq!(refused("f32", 3e-39, 0.0), None);
    assert_eq!(refused("f64", 1e-39, 0.0), None);
    let (error, help) = refused("f64", 1e-309, 0.0).unwrap();
    assert!(error.contains("format f64"), "{error}");
    assert!(help.contains("give 6e-309 or more"), "{help}");
    assert_eq!(refused("q8.8", 1e-39, 0.0), None);
    // Mismatch may leave a twentieth.
    let (_, help) = refused("f16", 1e-38, 1e-40).unwrap();
    assert!(help.contains("give 6e-38 or more"), "{help}");
}

/// Drives, and their distances from any memory, that fixed point does not hold.
#[test]
fn what_fixed_point_does_not_hold_is_counted() {
    let counted = |format: &str, memory: &str, weights: &str, light: &[f64]| {
        let rules = format!("response = \"identity\"\nmemory = \"{memory}\"");
        let text = format!("kernel = [[{weights}]]\nthreshold = {{ on = 9, off = 9 }}");
        let sensor = sensor(&rules, &text);
        let mut reference = Reference::in_format(format.parse().unwrap(), sensor, ONE, 0).unwrap();
        let mut packet = Packet::new(ONE, 1);
        for (n, light) in (0..).zip(light) {
            let frame = frame(n, n as f64, Plane::from_elem((1, 1), *light));
            reference.watch(&frame, &mut packet).unwrap();
        }
        let overflowed = reference.overflowed();
        assert_eq!(overflowed, reference.report().overflowed);
        (overflowed.at, overflowed.of)
    };
    for memory in ["filtered-step", "filtered-snap", "raw-snap"] {
        // A drive or a distance of 50, then of 200.
        for format in ["q8.8", "q8.8-wrap"] {
            let at = |weights: &str, light: &[f64]| counted(format, memory, weights, light).0;
            assert_eq!(at("1", &[0.0, 50.0, -70.0]), 0, "{format} {memory}");
            let beyond = at("2", &[0.0, 100.0]);
            assert!(beyond > 0, "{format} {memory}");
            assert_eq!(at("1", &[-100.0, 100.0]), 1, "{format} {memory}");
        }
        // The sum of two is cut off, and the third brings it back.
        assert!(counted("q8.8", memory, "100, 100, -100", &[0.0, 1.0]).0 > 0);
        for format in ["f64", "f32", "f16", "bf16"] {
            assert_eq!(counted(format, memory, "2", &[0.0, 100.0]), (0, 0));
        }
    }
}

#[test]
fn a_million_thresholds_in_one_pair_are_counted() {
    for theta in [1e-6, 0.2, 1.0, 3.7, 1e6] {
        for sign in [1.0, -1.0] {
            let got = step(F64, plain("\"identity\"", theta), 0.0, sign * 1e6 * theta).unwrap();
            assert_eq!(got, sign as i32 * 1_000_000, "threshold {theta}");
        }
    }
    // Binned in closed form, listed one by one.
    let light = [(0.0, 0.0), (1.0, 1e6)];
    let mut grid = VoxelGrid::new(ONE, 1);
    pixel(F64, plain("\"identity\"", 1.0), &light, &mut grid).unwrap();
    grid.advance();
    let later = grid.earlier()[0].sum();
    assert!((later - 500_000.5).abs() < 1e-3, "{later}");
    let mut packet = Packet::new(ONE, 1);
    pixel(
        F64,
        plain("\"identity\"", 1.0),
        &light,
        &mut EventList::new(&mut packet, Limit::default()),
    )
    .unwrap();
    assert_eq!(packet.events.len(), 1_000_000);
    assert!(
        packet
            .events
            .iter()
            .enumerate()
            .all(|(i, e)| e.t.0 == i as u64 + 1)
    );
}

proptest! {
    /// Counts are whole thresholds, for thresholds and light over twelve decades and more.
    #[test]
    fn counts_are_whole_thresholds(threshold in -6.0f64..6.0, from in -6.0f64..9.0, steps in 0.0f64..1e6, down: bool) {
        let theta = 10f64.powf(threshold);
        let (a, b) = (10f64.powf(from), 10f64.powf(from) + steps * theta);
        let (a, b) = if down { (b, a) } else { (a, b) };
        let exact = (b - a) / theta;
        // Light itself is rounded to a double; a step of a hair more or less is a tie.
        let hair = 1e-12 * exact.abs() + f64::EPSILON * a.max(b) / theta;
        let got = f64::from(step(F64, plain("\"identity\"", theta), a, b).unwrap());
        prop_assert!(got.abs() <= exact.abs() + hair && got.abs() + 1.0 > exact.abs() - hair, "{got}, not {exact}");
        prop_assert!(got == 0.0 || (got > 0.0) == (exact > 0.0));
    }

    /// Every response takes light of 0 and from 1e-6 to 1e9, and stays finite.
    #[test]
    fn responses_take_any_light(from in -6.0f64..9.0, to in -6.0f64..9.0, dark: bool) {
        let light = |exponent: f64| if dark { 0.0 } else { 10f64.powf(exponent) };
        let logs = ["{ log = { white = 255, offset = 1e-5 } }", "{ lin-log = { knee = 20 } }"];
        for response in logs {
            let (a, b) = (light(from), 10f64.powf(to));
            let description = plain(response, 0.01);
            let want = description.response.apply(b).unwrap() - description.response.apply(a).unwrap();
            let got = f64::from(step(F64, description, a, b).unwrap());
            prop_assert!((got * 0.01 - want).abs() < 0.0101, "{response}: {got} for {want}");
        }
        // Linear: an answer, or an error that says why not.
        match step(F64, plain("{ linear = 255 }", 1e-6), light(from), 10f64.powf(to)) {
            Ok(count) => prop_assert!(count.unsigned_abs() <= 1 << 30),
            Err(e) => prop_assert!(matches!(e, SensorError::Uncountable { .. }), "{}", e),
        }
    }
}

#[test]
fn black_and_what_is_below_it_have_an_answer() {
    // log(0): the offset.
    let log = plain("{ log = { white = 255, offset = 1e-5 } }", 0.1);
    let want = ((1.0f64 + 1e-5) / 1e-5).ln() / 0.1;
    assert_eq!(step(F64, log, 0.0, 255.0).unwrap(), want as i32);
    let lin_log = plain("{ lin-log = { knee = 20 } }", 0.1);
    assert_eq!(
        step(F64, lin_log, 0.0, 20.0).unwrap(),
        (20f64.ln() / 0.1) as i32
    );
    // A filtered signal below zero under log-temporal: the floor, ln(1e-8 + 1).
    let rules = "response = \"identity\"\nmemory = \"filtered-step\"";
    let channel = "kernel = [[-1]]\nlog-temporal = true\nthreshold = { on = 0.1, off = 0.1 }";
    let description = sensor(rules, channel);
    assert_eq!(step(F64, description.clone(), 1e9, 0.0).unwrap(), 0);
    assert_eq!(
        step(F64, description.clone(), 5.0, -1e9).unwrap(),
        (1e9f64.ln() / 0.1) as i32
    );
    // Negative, infinite and undefined light is refused where the response does not take it.
    for (response, light) in [
        ("{ linear = 255 }", -1.0),
        ("{ lin-log = { knee = 20 } }", -1e-9),
        ("\"identity\"", f64::NAN),
        ("\"identity\"", f64::INFINITY),
    ] {
        let error = step(F64, plain(response, 1.0), 0.0, light).unwrap_err();
        assert!(
            matches!(
                error,
                SensorError::Light {
                    index: 1,
                    y: 0,
                    x: 0,
                    ..
                }
            ),
            "{error}"
        );
    }
}

#[test]
fn lists_stop_or_drop_at_their_bound() {
    let light = [(0.0, 0.0), (1.0, 60.0), (2.0, 200.0), (3.0, 230.0)];
    let list = |when_full, packet: &mut Packet| {
        let limit = Limit {
            events: 100,
            when_full,
        };
        pixel(
            F64,
            plain("\"identity\"", 1.0),
            &light,
            &mut EventList::new(packet, limit),
        )
        .map(|r| r.report().events)
    };
    let mut packet = Packet::new(ONE, 1);
    let error = list(WhenFull::Stop, &mut packet).unwrap_err();
    assert!(matches!(error, SensorError::ListFull { limit: 100 }));
    let mut packet = Packet::new(ONE, 1);
    // 140 do not fit and are dropped whole; the 30 after them do.
    assert_eq!(list(WhenFull::Drop, &mut packet).unwrap(), 230);
    assert_eq!((packet.events.len(), packet.dropped.over_limit), (90, 140));
}

/// A ring that answers to its surround alone: firing does not help a cell.
fn ring() -> Description {
    let kernel =
        "[[0, 0, 1, 0, 0], [0, 0, 0, 0, 0], [1, 0, 0, 0, 1], [0, 0, 0, 0, 0], [0, 0, 1, 0, 0]]";
    sensor(
        "response = { linear = 255 }\nmemory = \"raw-snap\"",
        &format!("kernel = {kernel}\nthreshold = {{ on = 0.05, off = 0.1 }}"),
    )
}

/// Soft texture that has moved by half a pixel, then stands still.
fn texture(index: u64) -> Frame {
    let moved = if index == 0 { 0.0 } else { 0.5 };
    let wave = |y: f64, x: f64| (0.9 * x).sin() * (0.7 * y).cos() + 0.5 * (0.31 * x * y).sin();
    let light = Plane::from_shape_fn((40, 48), |(y, x)| {
        128.0 + 80.0 * wave(y as f64, x as f64 + moved)
    });
    frame(index, index as f64 / 240.0, light)
}

#[test]
fn a_snapping_pixel_memory_that_fires_for_ever_is_reported_and_ends() {
    let size = Size::new(40, 48);
    let watch = |description: Description| {
        let mut reference = Reference::new(description, size, 0).unwrap();
        let mut tally = Tally::new(1);
        let mut reports = Vec::new();
        for index in 0..40 {
            reference.watch_into(&texture(index), &mut tally).unwrap();
            reports.push(reference.report());
        }
        reports
    };
    let reports = watch(ring());
    let rate = reports[39].events - reports[38].events;
    assert!(rate > 0, "the ring does not fire for ever here");
    // From some frame on, the same cells at each, all of them reported.
    for pair in reports[20..].windows(2) {
        assert_eq!(pair[1].events - pair[0].events, rate);
        assert_eq!(pair[1].livelocked - pair[0].livelocked, rate);
    }
    // A pixel alone cannot, and no stepping memory can.
    let mut alone = ring();
    alone.channels[0].kernels = plain("\"identity\"", 1.0).channels[0].kernels.clone();
    let reports = watch(alone);
    assert!(reports[39].events > 0);
    assert_eq!(
        (reports[39].livelocked, reports[39].events),
        (0, reports[2].events)
    );
    let mut steps = ring();
    steps.memory = amacrine::reference::MemoryRule::FilteredStep;
    let reports = watch(steps);
    assert_eq!(reports[39].events, reports[1].events);
}

#[test]
fn time_must_advance() {
    for (first, second) in [
        (1.0, 1.0),
        (1.0, 0.5),
        (0.0, f64::NAN),
        (0.0, f64::INFINITY),
        (f64::NAN, 1.0),
    ] {
        let mut tally = Tally::new(1);
        let light = [(first, 0.0), (second, 5.0)];
        let error = pixel(F64, plain("\"identity\"", 1.0), &light, &mut tally).unwrap_err();
        assert!(matches!(error, SensorError::Time { .. }), "{error}");
        assert_eq!(tally.total(), 0);
    }
    // The shortest pair there is.
    let mut tally = Tally::new(1);
    let light = [(1.0, 0.0), (1.0 + f64::EPSILON, 5.0)];
    pixel(F64, plain("\"identity\"", 1.0), &light, &mut tally).unwrap();
    assert_eq!(tally.total(), 5);
}

#[test]
fn one_pixel_and_kernels_larger_than_the_array() {
    for (border, weight) in [("replicate", 225.0), ("zero", 1.0)] {
        let row = format!("[{}]", ["1"; 15].join(", "));
        let kernel = format!("[{}]", vec![row; 15].join(", "));
        let rules =
            format!("response = \"identity\"\nmemory = \"filtered-step\"\nborder = \"{border}\"");
        let description = sensor(
            &rules,
            &format!("kernel = {kernel}\nthreshold = {{ on = 1, off = 1 }}"),
        );
        assert_eq!(
            step(F64, description.clone(), 0.0, 3.0).unwrap(),
            3 * weight as i32
        );
        // A row, a column, and something smaller than the kernel.
        for (height, width) in [(1, 7), (7, 1), (3, 2)] {
            let size = Size::new(height, width);
            let mut reference = Reference::new(description.clone(), size, 0).unwrap();
            let mut counts = Counts::new(size, 1);
            for (n, light) in [0.0, 2.0].into_iter().enumerate() {
                let light = Plane::from_elem(size.shape(), light);
                reference
                    .watch_into(&frame(n as u64, n as f64, light), &mut counts)
                    .unwrap();
            }
            // All of it lies within the kernel's reach of every pixel.
            let want = if border == "zero" {
                2 * size.pixels() as i32
            } else {
                450
            };
            assert!(counts.planes()[0].iter().all(|c| *c == want));
        }
    }
}

#[test]
fn sizes_that_cannot_be_addressed_are_refused() {
    for (height, width) in [(0, 5), (5, 0), (0, 0), (1, 65_537)] {
        let error =
            Reference::new(plain("\"identity\"", 1.0), Size::new(height, width), 0).unwrap_err();
        assert!(matches!(error, SensorError::Addresses { .. }), "{error}");
    }
    let mut reference = Reference::new(plain("\"identity\"", 1.0), ONE, 0).unwrap();
    let mut packet = Packet::new(ONE, 1);
    let error = reference
        .watch(&frame(0, 0.0, Plane::zeros((2, 1))), &mut packet)
        .unwrap_err();
    assert!(matches!(error, SensorError::Size { .. }), "{error}");
}

#[test]
fn narrow_numbers_say_what_they_can_hold() {
    // f32: a million thresholds are within its 24 bits.
    assert_eq!(
        step(F32, plain("\"identity\"", 1.0), 0.0, 1e6).unwrap(),
        1_000_000
    );
    // q8.8 saturates at 127.99...: 127 whole thresholds, not a wrap-around.
    assert_eq!(
        step(Q::<i16>::new(8), plain("\"identity\"", 1.0), 0.0, 1e6).unwrap(),
        127
    );
    assert_eq!(
        step(Q::<i16>::new(8), plain("\"identity\"", 1.0), 0.0, -1e6).unwrap(),
        -128
    );
}

#[test]
fn a_leak_is_good_while_the_format_holds_it() {
    let rules = "response = \"identity\"\nmemory = \"filtered-step\"\nnoise = { leak-hz = 1 }";
    let description = sensor(rules, "kernel = [[1]]\nthreshold = { on = 1, off = 1 }");
    let still: Vec<_> = (0..=100).map(|t| (f64::from(t), 0.0)).collect();
    let leaked = |tally: &Tally| (100..=101).contains(&tally.total());
    let mut tally = Tally::new(1);
    pixel(F64, description.clone(), &still, &mut tally).unwrap();
    assert!(leaked(&tally), "{}", tally.total());
    let mut tally = Tally::new(1);
    pixel(F32, description.clone(), &still, &mut tally).unwrap();
    assert!(leaked(&tally), "{}", tally.total());
    let mut tally = Tally::new(1);
    pixel(Q::<i16>::new(8), description, &still, &mut tally).unwrap();
    assert!(leaked(&tally), "{}", tally.total());
}

#[test]
fn ties_fire_in_every_float() {
    for n in 1..=50 {
        let light = f64::from(n) * 0.1;
        assert_eq!(
            step(F64, plain("\"identity\"", 0.1), 0.0, light).unwrap(),
            n
        );
        assert_eq!(
            step(F32, plain("\"identity\"", 0.1), 0.0, light).unwrap(),
            n
        );
    }
    // The last event of a tie is at the later frame, not beyond it.
    let mut packet = Packet::new(ONE, 1);
    let light = [(0.0, 0.0), (0.001, 0.6)];
    pixel(
        F64,
        plain("\"identity\"", 0.2),
        &light,
        &mut EventList::new(&mut packet, Limit::default()),
    )
    .unwrap();
    assert_eq!(
        packet.events.iter().map(|e| e.t.0).collect::<Vec<_>>(),
        [333, 667, 1000]
    );
    assert!(packet.events.iter().all(|e| e.polarity == Polarity::On));
}

/// The memory holds the drive and what has leaked; where that is too much the counts mean nothing,
/// and are told of.
#[test]
fn a_leak_that_the_format_does_not_hold_is_counted() {
    let q8_8 = Q::<i16>::new(8);
    for memory in ["filtered-step", "filtered-snap"] {
        let rules =
            format!("response = \"identity\"\nmemory = \"{memory}\"\nnoise = {{ leak-hz = 1 }}");
        let description = sensor(&rules, "kernel = [[1]]\nthreshold = { on = 1, off = 1 }");
        let overflowed = |light: f64| {
            let still: Vec<_> = (0..=50).map(|t| (f64::from(t), light)).collect();
            let mut tally = Tally::new(1);
            let reference = pixel(q8_8, description.clone(), &still, &mut tally).unwrap();
            reference.report().overflowed.at
        };
        assert_eq!(overflowed(70.0), 0, "{memory}");
        assert!(overflowed(100.0) > 10, "{memory}");
    }
}
