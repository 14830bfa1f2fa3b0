//! The float model: every memory rule and refractory rule, in every format, against whole
//! numbers of thresholds and times that are known exactly.

use amacrine::{
    event::Packet,
    number::{F16, F32, F64, Format, Number},
    plane::{Plane, Size},
    reference::{
        AnyReference, Counts, Description, EventList, Limit, Reference, Sinks, Tally, WhenFull,
    },
    sensor::{Sensor, SensorError},
};

use crate::{
    bound::Bounds as _,
    light::{exact_dot, frame},
    page::{Table, Worst, decades},
};

const ONE: Size = Size::new(1, 1);

/// Every rule: its name, and what a sensor file says of it.
const RULES: [(&str, &str); 5] = [
    ("`raw-snap`", "memory = \"raw-snap\""),
    ("`filtered-snap`", "memory = \"filtered-snap\""),
    ("`filtered-step`", "memory = \"filtered-step\""),
    (
        "`filtered-step`, `authors`",
        "memory = \"filtered-step\"\nrefractory = { us = 0, rule = \"authors\" }",
    ),
    ("`authors-pixel-step`", "memory = \"authors-pixel-step\""),
];

fn parse(rules: &str, channel: &str) -> Result<Description, String> {
    let text = format!("{rules}\n[[channel]]\n{channel}\n");
    Description::parse("sensor.toml", &text, &|_| unreachable!()).map_err(|e| e.to_string())
}

/// One kernel and one threshold for ON and OFF.
fn sensor(rule: &str, response: &str, kernel: &str, threshold: f64) -> Description {
    let memory = if rule.contains("pixel-step") {
        "\nmemory-kernel = [[1]]"
    } else {
        ""
    };
    let channel = format!(
        "kernel = {kernel}{memory}\nthreshold = {{ on = {threshold:e}, off = {threshold:e} }}"
    );
    parse(&format!("response = {response}\n{rule}"), &channel).unwrap()
}

/// The pixel alone.
fn pixel(rule: &str, threshold: f64) -> Description {
    sensor(rule, "\"identity\"", "[[1]]", threshold)
}

/// One pixel that is `light` at the given times.
fn watch(
    format: Format,
    description: Description,
    light: &[(f64, f64)],
    sinks: &mut Sinks<'_, '_>,
) -> Result<Box<dyn AnyReference>, SensorError> {
    let mut reference = Reference::in_format(format, description, ONE, 0)?;
    for (n, (seconds, light)) in light.iter().enumerate() {
        let light = Plane::from_elem((1, 1), *light);
        let sinks = Sinks {
            tally: sinks.tally.as_deref_mut(),
            list: sinks.list.as_deref_mut(),
            counts: sinks.counts.as_deref_mut(),
            ..Sinks::default()
        };
        reference.watch_into_sinks(&frame(n as u64, *seconds, light), sinks)?;
    }
    Ok(reference)
}

/// How many events of the pixel there are.
fn tally(
    format: Format,
    description: Description,
    light: &[(f64, f64)],
) -> Result<(Box<dyn AnyReference>, u64), SensorError> {
    let mut tally = Tally::new(1);
    let mut sinks = Sinks {
        tally: Some(&mut tally),
        ..Sinks::default()
    };
    let reference = watch(format, description, light, &mut sinks)?;
    Ok((reference, tally.total()))
}

/// The signed events of the pixel from one light to another.
fn events(
    format: Format,
    description: Description,
    from: f64,
    to: f64,
) -> Result<f64, SensorError> {
    let mut counts = Counts::new(ONE, 1);
    let mut sinks = Sinks {
        counts: Some(&mut counts),
        ..Sinks::default()
    };
    watch(format, description, &[(0.0, from), (1.0, to)], &mut sinks)?;
    Ok(counts.planes()[0][[0, 0]].into())
}

pub fn table() -> Table {
    let mut table = Table::default();
    for (name, rule) in RULES {
        if rule.contains("snap") {
            snaps(name, rule, &mut table);
        } else {
            steps(name, rule, &mut table);
        }
    }
    for format in ["f32", "f16", "bf16", "q8.8", "q16.16", "q8.24"] {
        formats(format, &mut table);
    }
    responses(&mut table);
    stillness(&mut table);
    memories(&mut table);
    cancellation(&mut table);
    times(&mut table);
    silences(&mut table);
    refusals(&mut table);
    table
}

/// Pairs of lights over fifteen decades, up and down.
fn pairs() -> impl Iterator<Item = (f64, f64)> {
    let lights = || {
        [0.0]
            .into_iter()
            .chain(decades(-6, 9).map(|light| light / 3.0))
    };
    lights().flat_map(move |from| lights().map(move |to| (from, to)))
}

fn snaps(name: &str, rule: &str, table: &mut Table) {
    let mut worst = Worst::default();
    for threshold in decades(-6, 6) {
        for (from, to) in pairs() {
            let got = events(Format::F64, pixel(rule, threshold), from, to).unwrap();
            let want = if (to - from).abs() > threshold {
                (to - from).signum()
            } else {
                0.0
            };
            worst.see(
                (got - want).abs(),
                0.0,
                format_args!("{name}: {from:e} to {to:e}"),
            );
        }
    }
    let happens = format!("{} decisions, all right", worst.cases());
    let to = "light 0 and 1e-6 to 1e9, thresholds 1e-6 to 1e6";
    table.within(name, to, &happens, "none is wrong", worst);
}

/// What a count is off by: how far so many thresholds lie beyond the distance, or one more of
/// them below it.
fn off(count: f64, threshold: f64, distance: f64) -> f64 {
    let (beyond, rest) = exact_dot([(count, threshold), (-1.0, distance)]);
    let (below, more) = exact_dot([(1.0, distance), (-1.0 - count, threshold)]);
    (beyond + rest).max(below + more).max(0.0)
}

fn steps(name: &str, rule: &str, table: &mut Table) {
    let mut worst = Worst::default();
    let mut refused = 0;
    // The released rule adds 1e-9 to every distance.
    let authors = rule.contains("authors");
    let (more, tie) = if authors {
        (1e-9, 8.0 * f64::EPSILON)
    } else {
        (0.0, 4096.0 * f64::EPSILON)
    };
    for threshold in decades(-6, 6) {
        for (from, to) in pairs() {
            let distance = (to - from).abs() + if to == from { 0.0 } else { more };
            match events(Format::F64, pixel(rule, threshold), from, to) {
                Ok(count) => {
                    assert!(count == 0.0 || count.signum() == (to - from).signum());
                    let error = off(count.abs(), threshold, distance);
                    let what = format_args!("{name}: {from:e} to {to:e} by {threshold:e}");
                    worst.see(error, tie * distance, what);
                }
                Err(error) => {
                    assert!(matches!(error, SensorError::Uncountable { .. }), "{error}");
                    assert!(distance / threshold > f64::from((1 << 30) - 1));
                    refused += 1;
                }
            }
        }
    }
    let happens = format!(
        "{} counts are whole thresholds, {refused} are refused",
        worst.cases()
    );
    let to = "light 0 and 1e-6 to 1e9, thresholds 1e-6 to 1e6";
    let bound = if authors {
        "8 units in the last place of the distance"
    } else {
        "ties: 9.1e-13 of the distance"
    };
    table.within(name, to, &happens, bound, worst);
}

/// `filtered-step` in another format: light and memory are rounded, thresholds and quotients are
/// those of its float.
fn formats(name: &str, table: &mut Table) {
    let format: Format = name.parse().unwrap();
    let rule = RULES[2].1;
    let mut worst = Worst::default();
    let mut refused = [0, 0];
    let narrow = Format::F32.unit_roundoff();
    let (u, tie) = match format {
        Format::Fixed(_) => (0.0, 4096.0 * f64::EPSILON),
        _ => (format.unit_roundoff() + 3.0 * narrow, 64.0 * narrow),
    };
    let mut saturated = 0;
    for threshold in decades(-6, 6) {
        let description = pixel(rule, threshold);
        for (from, to) in pairs() {
            let distance = (to - from).abs();
            match events(format, description.clone(), from, to) {
                Ok(count) => {
                    let held = format.hold_bound(from) + format.hold_bound(to);
                    let bound = held + (u + tie) * (distance + held) + format.half_step();
                    if held == f64::INFINITY || distance > format.limits().1 {
                        assert!(
                            matches!(format, Format::Fixed(_)),
                            "{name}: {from:e} to {to:e}"
                        );
                        saturated += 1;
                        continue;
                    }
                    let what = format_args!("{name}: {from:e} to {to:e} by {threshold:e}");
                    worst.see(off(count.abs(), threshold, distance), bound, what);
                }
                Err(SensorError::Uncountable { .. }) => refused[0] += 1,
                Err(SensorError::Overflow { .. }) => refused[1] += 1,
                Err(error) => panic!("{error}"),
            }
        }
    }
    let mut happens = format!("{} counts, {} cannot be counted", worst.cases(), refused[0]);
    if refused[1] > 0 {
        let left = refused[1];
        happens = format!("{happens}, in {left} the format is left, and they are refused");
    }
    if saturated > 0 {
        happens = format!("{happens}, in {saturated} the light saturates");
    }
    table.within(
        &format!("`filtered-step`, {name}"),
        "light 0 and 1e-6 to 1e9, thresholds 1e-6 to 1e6",
        &happens,
        "rounding of both lights and of their difference, ties",
        worst,
    );
}

/// The curves of the photoreceptor.
fn responses(table: &mut Table) {
    for (name, response) in [
        ("log", "{ log = { white = 255, offset = 1e-5 } }"),
        ("lin-log", "{ lin-log = { knee = 20 } }"),
        ("linear", "{ linear = 255 }"),
    ] {
        let mut worst = Worst::default();
        let threshold = 0.01;
        for (from, to) in pairs() {
            let description = sensor(RULES[2].1, response, "[[1]]", threshold);
            // Apart from the code: what each curve is.
            let curve = |light: f64| match name {
                "log" => (light / 255.0 + 1e-5).ln(),
                "lin-log" if light <= 20.0 => light * 20f64.ln() / 20.0,
                "lin-log" => light.ln(),
                _ => light / 255.0,
            };
            let distance = (curve(to) - curve(from)).abs();
            let Ok(count) = events(Format::F64, description, from, to) else {
                assert!(distance / threshold > f64::from((1 << 30) - 1));
                continue;
            };
            let bound = 4096.0 * f64::EPSILON * distance + 1e-14 * curve(to).abs().max(12.0);
            let what = format_args!("{name}: {from:e} to {to:e}");
            worst.see(off(count.abs(), threshold, distance), bound, what);
        }
        table.within(
            &format!("response `{name}`"),
            "light 0 and 1e-6 to 1e9",
            &format!("{} counts are whole thresholds of 0.01", worst.cases()),
            "ties, and 1e-14 of the curve",
            worst,
        );
    }
}

/// Nothing moves, so nothing fires, whatever the light and however small the threshold.
fn stillness(table: &mut Table) {
    let still = |format, rule, scale: f64| -> Option<u64> {
        let kernel = "[[0.3, -0.7, 0.1], [0.9, 1.7, -0.3], [0.2, 0.6, -1.3]]";
        let description = sensor(rule, "\"identity\"", kernel, 1e-6);
        let size = Size::new(5, 4);
        let mut reference = Reference::in_format(format, description, size, 0).unwrap();
        let light = Plane::from_shape_fn(size.shape(), |(y, x)| scale * (y * 3 + x) as f64);
        let mut tally = Tally::new(1);
        for n in 0..20u32 {
            let still = frame(n.into(), f64::from(n) * 4320.0, light.clone());
            let sinks = Sinks {
                tally: Some(&mut tally),
                ..Sinks::default()
            };
            match reference.watch_into_sinks(&still, sinks) {
                Ok(()) => {}
                Err(SensorError::Overflow { .. }) => return None,
                Err(error) => panic!("{error}"),
            }
        }
        Some(tally.total())
    };
    let (mut worst, mut refused) = (Worst::default(), 0);
    for (name, rule) in RULES {
        for format in ["f64", "f32", "f16", "bf16", "q8.8", "q8.8-wrap", "q8.24"] {
            for scale in decades(-6, 9) {
                // The rule that may run away takes no such kernel.
                if rule.contains("pixel-step") {
                    continue;
                }
                let format: Format = format.parse().unwrap();
                match still(format, rule, scale) {
                    Some(fired) => worst.see(fired as f64, 0.0, format_args!("{name} {scale:e}")),
                    None => refused += 1,
                }
            }
        }
    }
    table.within(
        "a still scene, four rules, seven formats, threshold 1e-6",
        "light 1e-6 to 1e9, a day",
        &format!(
            "{} are silent, {refused} leave the format and are refused",
            worst.cases()
        ),
        "no event",
        worst,
    );
}

/// Far up and down, and further than is counted.
fn memories(table: &mut Table) {
    // Its memory is in its own numbers.
    fn swing<N: Number>(number: N, steps: f64, swings: u32) -> (f64, u64) {
        let (theta, start) = (0.2, 0.1);
        let description = pixel(RULES[2].1, theta);
        let mut reference = Reference::with_number(number, description, ONE, 0).unwrap();
        let mut tally = Tally::new(1);
        for n in 0..=swings {
            let light = if n % 2 == 1 { steps * theta } else { start };
            let light = Plane::from_elem((1, 1), light);
            let seen = frame(n.into(), f64::from(n), light);
            reference.watch_into(&seen, &mut tally).unwrap();
        }
        let first = number.value(number.hold(start));
        let drift = reference.memory(0).unwrap()[[0, 0]] - first;
        (drift.abs(), tally.total())
    }
    for (format, steps, swings) in [("f64", 1e9, 10), ("f32", 4e6, 1000), ("f16", 1e3, 1000)] {
        let which: Format = format.parse().unwrap();
        let (drift, fired) = match which {
            Format::F64 => swing(F64, steps, swings),
            Format::F32 => swing(F32, steps, swings),
            _ => swing(F16, steps, swings),
        };
        let mut worst = Worst::default();
        // In 11 bits the memory itself is a step or less beside where it is counted to be, each
        // time anew.
        let (bound, words) = if format == "f16" {
            let far = 0.2 * steps;
            (
                0.2 + 2.0 * which.hold_bound(far),
                "a threshold, and rounding at the far end",
            )
        } else {
            (0.0, "no drift")
        };
        worst.see(drift, bound, format);
        table.within(
            &format!("`filtered-step`, {format}: a memory up and down"),
            &format!("{swings} times {steps:.0e} steps"),
            &format!(
                "{:.1e} events; how far it is from where it began",
                fired as f64
            ),
            words,
            worst,
        );
    }
    let beyond = |light| events(Format::F64, pixel(RULES[2].1, 1.0), 0.0, light);
    assert_eq!(beyond(1_073_741_823.0).unwrap(), 1_073_741_823.0);
    let error = beyond(1_073_741_824.0).unwrap_err();
    table.refused("`filtered-step`: steps of a memory", "2^30", error);
}

/// Weights that sum to 0 leave nothing of uniform light but what rounding makes.
fn cancellation(table: &mut Table) {
    for name in ["f64", "f32", "bf16"] {
        let format: Format = name.parse().unwrap();
        let (mut worst, mut refused) = (Worst::default(), 0);
        for size in decades(-6, 6) {
            let row = |centre: bool| {
                let weight = |x| if centre && x == 2 { size } else { -size / 24.0 };
                let row: Vec<_> = (0..5).map(|x| format!("{:e}", weight(x))).collect();
                format!("[{}]", row.join(", "))
            };
            let rows: Vec<_> = (0..5).map(|y| row(y == 2)).collect();
            let kernel = format!("[{}]", rows.join(", "));
            let threshold = 1e-3;
            let description = sensor(RULES[2].1, "\"identity\"", &kernel, threshold);
            for light in decades(-6, 9).map(|light| light / 3.0) {
                let flash = [(0.0, 0.0), (1.0, light)];
                match tally(format, description.clone(), &flash) {
                    Ok((_, count)) => {
                        let all = 2.0 * size * light;
                        let bound = 1.1 * format.dot_bound(28, all) + 1e-30;
                        let what = format_args!("{name}: ±{size:e} under {light:e}");
                        worst.see(count as f64 * threshold, bound, what);
                    }
                    Err(SensorError::Uncountable { .. }) => refused += 1,
                    Err(error) => panic!("{error}"),
                }
            }
        }
        table.within(
            &format!(
                "`filtered-step`, {name}: 5x5 weights ±1e-6 to ±1e6 that sum to 0, threshold 1e-3"
            ),
            "uniform light from 0 to 1e9",
            &format!(
                "{} flashes give only what rounding makes, {refused} cannot be counted",
                worst.cases()
            ),
            "γ(28) Σ|w u|",
            worst,
        );
    }
}

/// Times of events against whole numbers.
fn times(table: &mut Table) {
    const DAY: u64 = 86_400_000_000;
    // The furthest that an event is from where it should be, in microseconds.
    let furthest = |format, start: u64, length: u64, count: u64| -> f64 {
        let mut packet = Packet::new(ONE, 1);
        let seconds = |micros: u64| micros as f64 / 1e6;
        // Thresholds of 1 on the way from 0 to count and a half.
        let light = [
            (seconds(start), 0.0),
            (seconds(start + length), count as f64 + 0.5),
        ];
        let mut list = EventList::new(&mut packet, Limit::default());
        let mut sinks = Sinks {
            list: Some(&mut list),
            ..Sinks::default()
        };
        watch(format, pixel(RULES[2].1, 1.0), &light, &mut sinks).unwrap();
        assert_eq!(packet.events.len() as u64, count);
        let each = packet.events.iter().zip(1u128..).map(|(event, i)| {
            // In parts of a microsecond: start + length i / (count + 1/2).
            let parts = 2 * u128::from(count) + 1;
            let want = u128::from(start) * parts + 2 * u128::from(length) * i;
            (u128::from(event.t.0) * parts).abs_diff(want) as f64 / parts as f64
        });
        each.fold(0.0, f64::max)
    };
    for name in ["f64", "f32"] {
        let format: Format = name.parse().unwrap();
        let mut worst = Worst::default();
        for start in [0, 1, DAY, 365 * DAY, 70 * 365 * DAY] {
            for length in [1, 17, 1000, 4_166, 1_000_000, 3_600_000_000, DAY] {
                for count in [1, 2, 10, 999, 100_000] {
                    let error = furthest(format, start, length, count);
                    // In single precision the place in the pair has 24 bits.
                    let narrow = if name == "f32" {
                        4.0 * format.unit_roundoff()
                    } else {
                        0.0
                    };
                    let what = format_args!("{name}: {count} in {length} us from {start} us");
                    worst.see(error, 1.0 + narrow * length as f64, what);
                }
            }
        }
        table.within(
            &format!("times of events, {name}"),
            "up to 70 years from the start, pairs of 1 µs to a day, 1e5 events in a pair",
            "their error",
            if name == "f32" {
                "1 µs, and 4 u of the pair"
            } else {
                "1 µs"
            },
            worst,
        );
    }
}

/// Refractory periods from nothing to longer than the clip.
fn silences(table: &mut Table) {
    // Twenty frames, a millisecond apart, ten thresholds in each.
    let light: Vec<_> = (0..20)
        .map(|n| (f64::from(n) * 1e-3, f64::from(n) * 10.0))
        .collect();
    for rule in ["dead-time", "authors"] {
        for us in [0.0, 1e-9, 99.0, 101.0, 5e3, 1e9, 1e300] {
            let rules = format!(
                "memory = \"filtered-step\"\nrefractory = {{ us = {us:e}, rule = \"{rule}\" }}"
            );
            let (reference, fired) = tally(Format::F64, pixel(&rules, 1.0), &light).unwrap();
            let report = reference.report();
            assert_eq!(report.events, fired);
            if rule == "dead-time" {
                assert_eq!(report.events + report.lost_to_refractory, 190);
            }
            let happens = format!("{} events", report.events);
            let to = format!("{us:e} µs, a clip of 19 ms with 190 crossings");
            table.happens(&format!("refractory period, `{rule}`"), &to, &happens);
        }
    }
}

fn refusals(table: &mut Table) {
    for (name, rule) in RULES {
        let description = pixel(rule, 1.0);
        let error = events(Format::F16, description, 0.0, 1e9).unwrap_err();
        table.refused(&format!("{name}, f16"), "light 1e9", error);
    }
    let huge = sensor(RULES[1].1, "\"identity\"", "[[1e300, 1e300, -1e300]]", 1.0);
    let error = events(Format::F64, huge, 0.0, 1e9).unwrap_err();
    table.refused("`filtered-snap`, f64: weights of 1e300", "light 1e9", error);
    for threshold in ["0", "-0.2", "nan", "inf", "1e-400"] {
        let channel = format!("kernel = [[1]]\nthreshold = {{ on = {threshold}, off = 0.2 }}");
        let error = parse("response = \"identity\"\nmemory = \"raw-snap\"", &channel).unwrap_err();
        table.refused("threshold", threshold, error);
    }
    let runs_away = "kernel = [[1]]\nmemory-kernel = [[3]]\nthreshold = { on = 1, off = 1 }";
    let rules = "response = \"identity\"\nmemory = \"authors-pixel-step\"";
    let error = parse(rules, runs_away).unwrap_err();
    table.refused("`authors-pixel-step`", "a memory kernel of [[3]]", error);
    for (response, light) in [
        ("\"identity\"", f64::NAN),
        ("\"identity\"", f64::INFINITY),
        ("{ linear = 255 }", -1e-9),
    ] {
        let description = sensor(RULES[2].1, response, "[[1]]", 1.0);
        let error = events(Format::F64, description, 0.0, light).unwrap_err();
        table.refused(
            &format!("response `{}`", response.replace('"', "")),
            &format!("light {light:e}"),
            error,
        );
    }
    let at = |seconds| {
        let light = [(1.0, 0.0), (seconds, 5.0)];
        tally(Format::F64, pixel(RULES[2].1, 1.0), &light).map(|_| ())
    };
    at(1.0 + f64::EPSILON).unwrap();
    table.refused(
        "a frame",
        "the time of the one before",
        at(1.0).unwrap_err(),
    );
    table.refused("a frame", "1e10 s", at(1e10).unwrap_err());
    for (height, width) in [(0, 5), (65_537, 1)] {
        let size = Size::new(height, width);
        let error = Reference::new(pixel(RULES[2].1, 1.0), size, 0).unwrap_err();
        table.refused("a sensor", &size.to_string(), error);
    }
    let mut packet = Packet::new(ONE, 1);
    let mut list = |when_full| {
        let limit = Limit {
            when_full,
            ..Limit::default()
        };
        let light = [(0.0, 0.0), (1.0, 1e9)];
        let mut list = EventList::new(&mut packet, limit);
        let mut sinks = Sinks {
            list: Some(&mut list),
            ..Sinks::default()
        };
        watch(Format::F64, pixel(RULES[2].1, 1.0), &light, &mut sinks).map(|_| ())
    };
    table.refused(
        "a list of events",
        "1e9 events in one pair",
        list(WhenFull::Stop).unwrap_err(),
    );
    list(WhenFull::Drop).unwrap();
    assert!(packet.events.is_empty());
    let happens = format!("{} are dropped and counted", packet.dropped.over_limit);
    table.happens(
        "a list of events, `--when-full drop`",
        "1e9 events in one pair",
        &happens,
    );
    let mut sensor = Reference::new(pixel(RULES[2].1, 1.0), ONE, 0).unwrap();
    let wrong = frame(0, 0.0, Plane::zeros((2, 1)));
    table.refused(
        "a frame",
        "another size",
        sensor.watch(&wrong, &mut packet).unwrap_err(),
    );
}
