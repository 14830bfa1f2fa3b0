//! Noise against its analytic rates: each kind within 4 standard deviations of what its
//! distribution says, at more than one seed (the failing one is printed) and, where a rate is
//! physical, at more than one frame rate. And the same seed gives the same events on one
//! thread and on two.

use std::{collections::BTreeMap, iter};

use amacrine::{
    event::{Event, Packet, Polarity},
    plane::{Plane, Size},
    reference::{Counts, Description, EventList, Limit, Reference, Tally},
    scene::Frame,
    sensor::Sensor,
};

const SEEDS: [u64; 3] = [1, 2, 20_261_121];

/// A sensor that sees each pixel alone, as it is, with some noise and a threshold.
fn plain(rules: &str, noise: &str, threshold: &str) -> Description {
    let text = format!(
        "response = \"identity\"\nmemory = \"filtered-step\"\n{rules}\n[noise]\n{noise}\n[[channel]]\nkernel = [[1]]\nthreshold = {threshold}\n"
    );
    Description::parse("noise.toml", &text, &|_| unreachable!()).unwrap_or_else(|e| panic!("{e}"))
}

/// Frames of light that is a function of time, and the same everywhere.
fn uniform(size: Size, times: &[f64], light: impl Fn(f64) -> f64) -> Vec<Frame> {
    let frame = |(index, &seconds)| Frame {
        index: index as u64,
        seconds,
        light: Plane::from_elem(size.shape(), light(seconds)).into(),
    };
    times.iter().enumerate().map(frame).collect()
}

/// A scene at rest for some time.
fn still(size: Size, seconds: f64, fps: f64) -> Vec<Frame> {
    let mut times: Vec<_> = (0..(seconds * fps).ceil() as u64)
        .map(|n| n as f64 / fps)
        .collect();
    times.push(seconds);
    uniform(size, &times, |_| 100.0)
}

fn events(description: &Description, frames: &[Frame], seed: u64) -> Vec<Event> {
    let size = Size::of(&frames[0].light);
    let mut reference = Reference::new(description.clone(), size, seed).unwrap();
    let mut packet = Packet::new(size, description.channels.len() as u8);
    for frame in frames {
        reference.watch(frame, &mut packet).unwrap();
    }
    assert!(packet.events.is_sorted_by_key(|e| e.t));
    packet.events
}

/// The times of each cell's events, in microseconds.
fn by_cell(events: &[Event]) -> BTreeMap<(u16, u16), Vec<u64>> {
    let mut cells: BTreeMap<_, Vec<u64>> = BTreeMap::new();
    for event in events {
        cells.entry((event.y, event.x)).or_default().push(event.t.0);
    }
    cells
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len() as f64;
    values.sum::<f64>() / n
}

/// Mean and standard deviation.
fn moments(values: &[f64]) -> (f64, f64) {
    let middle = mean(values.iter().copied());
    let variance = mean(values.iter().map(|v| (v - middle).powi(2)));
    (middle, variance.sqrt())
}

/// `got` within 4 `sigma` of `want`.
#[track_caller]
fn near(seed: u64, what: &str, got: f64, want: f64, sigma: f64) {
    let off = (got - want).abs() / sigma;
    assert!(
        off < 4.0,
        "seed {seed}: {what} is {got}, not {want}: {off:.1} sigma"
    );
}

/// The thresholds of all cells, seen from how many a large step crosses.
fn thresholds(description: &Description, size: Size, seed: u64, step: f64) -> Vec<f64> {
    let mut reference = Reference::new(description.clone(), size, seed).unwrap();
    let mut counts = Counts::new(size, 1);
    for frame in uniform(size, &[0.0, 1.0], |t| step * t) {
        reference.watch_into(&frame, &mut counts).unwrap();
    }
    let crossed = counts.planes()[0].iter();
    crossed
        .map(|n| step.abs() / (f64::from(n.abs()) + 0.5))
        .collect()
}

#[test]
fn thresholds_have_their_mean_and_spread_and_stay() {
    let size = Size::new(100, 100);
    let description = plain("", "", "{ on = 0.2, off = 0.3, sigma = 0.03 }");
    for seed in SEEDS {
        let n = size.pixels() as f64;
        let on = thresholds(&description, size, seed, 1000.0);
        let off = thresholds(&description, size, seed, -1000.0);
        for (what, drawn, want) in [("on", &on, 0.2), ("off", &off, 0.3)] {
            let (middle, spread) = moments(drawn);
            near(seed, what, middle, want, 0.03 / n.sqrt());
            near(seed, what, spread, 0.03, 0.03 / (2.0 * n).sqrt());
        }
        // ON and OFF are drawn apart, and so are neighbours.
        let product = |a: &[f64], b: &[f64]| {
            mean(a.iter().zip(b).map(|(a, b)| (a - 0.2) * (b - 0.3))) / 0.0009
        };
        near(
            seed,
            "on against off",
            product(&on, &off),
            0.0,
            1.0 / n.sqrt(),
        );
        let shifted: Vec<_> = on[1..].iter().map(|v| v + 0.1).collect();
        near(
            seed,
            "neighbours",
            product(&on[..on.len() - 1], &shifted),
            0.0,
            1.0 / n.sqrt(),
        );
        // The same cells in another clip; others under another seed.
        let again = thresholds(&description, size, seed, 700.0);
        assert!(
            on.iter()
                .zip(&again)
                .all(|(a, b)| (a / b - 1.0).abs() < 2e-3),
            "seed {seed}"
        );
        let other = thresholds(&description, size, seed + 1, 1000.0);
        near(
            seed,
            "another seed",
            product(&on, &other.iter().map(|v| v + 0.1).collect::<Vec<_>>()),
            0.0,
            1.0 / n.sqrt(),
        );
    }
}

#[test]
fn a_threshold_is_a_fixed_pattern_from_frame_to_frame() {
    let size = Size::new(40, 40);
    let description = plain("", "", "{ on = 0.2, off = 0.2, sigma = 0.05 }");
    let times: Vec<_> = (0..9).map(f64::from).collect();
    let frames = uniform(
        size,
        &times,
        |t| if t as u64 % 2 == 1 { 300.0 } else { 0.0 },
    );
    let mut reference = Reference::new(description, size, 5).unwrap();
    let mut counts = Counts::new(size, 1);
    let mut ups: Vec<Plane<i32>> = Vec::new();
    for frame in &frames {
        reference.watch_into(frame, &mut counts).unwrap();
        if frame.index % 2 == 1 {
            ups.push(counts.planes()[0].clone());
        }
    }
    // Cells differ by far more than frames do.
    let (least, most) = (ups[0].iter().min().unwrap(), ups[0].iter().max().unwrap());
    assert!(*least > 500 && most - least > 200, "{least} to {most}");
    // What the step down left may move a count by the ratio of the two thresholds.
    for later in &ups[1..] {
        assert!((later - &ups[0]).iter().all(|d| d.abs() <= 12));
    }
}

#[test]
fn leak_has_its_rate_at_any_frame_rate() {
    let size = Size::new(50, 50);
    let (hertz, seconds) = (3.0, 20.5 / 3.0);
    let description = plain("", "leak-hz = 3", "{ on = 0.2, off = 0.2, sigma = 0.03 }");
    for seed in SEEDS {
        let n = size.pixels() as f64;
        let slow = events(&description, &still(size, seconds, 10.0), seed);
        assert!(slow.iter().all(|e| e.polarity == Polarity::On));
        // floor(20 1/2 + phase): a coin for each cell.
        near(
            seed,
            "leak",
            slow.len() as f64,
            n * hertz * seconds,
            0.5 * n.sqrt(),
        );
        let first: Vec<_> = by_cell(&slow)
            .values()
            .map(|t| t[0] as f64 * 1e-6)
            .collect();
        let (middle, spread) = moments(&first);
        near(
            seed,
            "first",
            middle,
            0.5 / hertz,
            1.0 / hertz / (12.0 * n).sqrt(),
        );
        near(
            seed,
            "spread of the first",
            spread,
            1.0 / hertz / 12f64.sqrt(),
            1.0 / hertz / (12.0 * n).sqrt(),
        );
        // The same events at another frame rate, but for the rounding to microseconds.
        let fast = events(&description, &still(size, seconds, 97.0), seed);
        let (slow, fast) = (by_cell(&slow), by_cell(&fast));
        assert!(slow.keys().eq(fast.keys()));
        for (slow, fast) in slow.values().zip(fast.values()) {
            assert_eq!(slow.len(), fast.len(), "seed {seed}");
            assert!(
                slow.iter().zip(fast).all(|(a, b)| a.abs_diff(*b) <= 1),
                "seed {seed}"
            );
        }
    }
}

#[test]
fn leak_spreads_log_normally() {
    let size = Size::new(40, 50);
    let description = plain(
        "",
        "leak-hz = 3\nleak-spread = 0.2",
        "{ on = 0.2, off = 0.2 }",
    );
    for seed in SEEDS {
        let n = size.pixels() as f64;
        let seen = by_cell(&events(&description, &still(size, 100.0, 1.0), seed));
        assert_eq!(seen.len(), size.pixels());
        let rates: Vec<_> = seen
            .values()
            .map(|t| (t.len() as f64 / 100.0).log10())
            .collect();
        let (middle, spread) = moments(&rates);
        near(seed, "log rate", middle, 3f64.log10(), 0.2 / n.sqrt());
        near(seed, "its spread", spread, 0.2, 0.2 / (2.0 * n).sqrt());
        // `leak-hz` is the median of a log-normal; its mean is larger.
        let variance = (0.2 * 10f64.ln()).powi(2);
        let want = 3.0 * (variance / 2.0).exp();
        let got = mean(seen.values().map(|t| t.len() as f64 / 100.0));
        let sigma = want * (variance.exp_m1() / n).sqrt();
        near(seed, "mean rate", got, want, sigma);
    }
}

#[test]
fn a_snapping_memory_leaks_in_whole_frames() {
    let size = Size::new(20, 20);
    let text = "response = \"identity\"\nmemory = \"filtered-snap\"\nnoise = { leak-hz = 3 }\n[[channel]]\nkernel = [[1]]\nthreshold = { on = 0.2, off = 0.2 }\n";
    let description = Description::parse("snap.toml", text, &|_| unreachable!()).unwrap();
    let (seconds, fps) = (20.0, 50.0);
    let seen = by_cell(&events(&description, &still(size, seconds, fps), 1));
    assert_eq!(seen.len(), size.pixels());
    // Fires at the first frame at which more than a threshold has leaked.
    let frames = (fps / 3.0).floor() as u64 + 1;
    for times in seen.values() {
        for pair in times.windows(2) {
            assert_eq!(pair[1] - pair[0], frames * 20_000);
        }
    }
}

#[test]
fn shot_noise_is_a_poisson_process_at_any_frame_rate() {
    let size = Size::new(50, 50);
    let (hertz, seconds) = (5.0, 4.0);
    let description = plain("", "shot-hz = 5", "{ on = 0.2, off = 0.2 }");
    let n = size.pixels() as f64;
    for (seed, fps) in iter::zip(SEEDS, [1.0, 30.0, 800.0]) {
        let seen = events(&description, &still(size, seconds, fps), seed);
        let all = seen.len() as f64;
        let want = n * hertz * seconds;
        near(seed, "shot", all, want, want.sqrt());
        let on = seen.iter().filter(|e| e.polarity == Polarity::On).count() as f64;
        near(seed, "ON", on, all / 2.0, all.sqrt() / 2.0);
        // Times are uniform in the whole and within a pair.
        let phases = |period: f64| -> Vec<f64> {
            seen.iter().map(|e| e.t.seconds() / period % 1.0).collect()
        };
        for period in [seconds, 1.0 / fps] {
            let (middle, spread) = moments(&phases(period));
            let sigma = 1.0 / (12.0 * all).sqrt();
            near(seed, "phase", middle, 0.5, sigma);
            near(seed, "its spread", spread, 1.0 / 12f64.sqrt(), sigma);
        }
        // Counts vary as their mean, waiting times are exponential.
        let cells = by_cell(&seen);
        let counts: Vec<_> = cells.values().map(|t| t.len() as f64).collect();
        let (middle, spread) = moments(&counts);
        near(
            seed,
            "variance",
            spread * spread,
            middle,
            middle * (2.0 / n).sqrt(),
        );
        let waits = cells
            .values()
            .flat_map(|t| t.windows(2).map(|w| w[1] - w[0]));
        let waits: Vec<_> = waits.map(|w| w as f64 * 1e-6).collect();
        let short = waits.iter().filter(|w| **w < 0.05).count() as f64;
        let m = waits.len() as f64;
        // Long waits are cut off by the end of the run, so short ones are a little too many.
        let share = 1.0 - (-0.05 * hertz).exp();
        let cut = |t: f64| 1.0 - (1.0 - (-t * hertz).exp()) / (t * hertz);
        assert!(
            short / m > share - 4.0 * (share / m).sqrt()
                && short / m < share * (1.0 + 2.0 * (1.0 - cut(seconds))),
            "seed {seed}: {short} of {m} waits are short"
        );
    }
}

/// The light of a pair of frames is that of the later.
#[test]
fn shot_noise_sees_the_later_frame() {
    let size = Size::new(40, 40);
    let text = "response = \"identity\"\nmemory = \"filtered-step\"\nnoise = { shot-hz = 100, shot-at-white = 0.25 }\n[[channel]]\nkernel = \"csdvs-3\"\nthreshold = { on = 0.2, off = 0.2 }\n";
    let description = Description::parse("shot.toml", text, &|_| unreachable!()).unwrap();
    for seed in SEEDS {
        for (from, to, share) in [(0.0, 255.0, 0.25), (255.0, 0.0, 1.0)] {
            let light = |seconds| if seconds > 0.0 { to } else { from };
            let seen = events(&description, &uniform(size, &[0.0, 1.0], light), seed);
            let want = size.pixels() as f64 * 100.0 * share;
            near(seed, "shot", seen.len() as f64, want, want.sqrt());
        }
    }
}

#[test]
fn shot_noise_falls_with_light() {
    let size = Size::new(60, 60);
    let text = |response: &str| {
        format!(
            "response = {response}\nmemory = \"filtered-step\"\nnoise = {{ shot-hz = 8, shot-at-white = 0.25 }}\n[[channel]]\nkernel = \"csdvs-3\"\nthreshold = {{ on = 0.2, off = 0.2 }}\n"
        )
    };
    let light = Plane::from_shape_fn(size.shape(), |(_, x)| {
        [0.0, 127.5, 255.0, 1000.0][x * 4 / 60]
    });
    let seconds = 10.0;
    let frames: Vec<_> = (0..=20)
        .map(|index| Frame {
            index,
            seconds: index as f64 * seconds / 20.0,
            light: light.clone().into(),
        })
        .collect();
    let responses = [
        "{ log = { white = 255, offset = 1e-3 } }",
        "{ lin-log = { knee = 20 } }",
        "{ linear = 100 }",
    ];
    for (seed, response) in iter::zip(SEEDS, responses) {
        let description =
            Description::parse("shot.toml", &text(response), &|_| unreachable!()).unwrap();
        let seen = events(&description, &frames, seed);
        for (quarter, share) in [1.0, 0.625, 0.25, 0.25].into_iter().enumerate() {
            let got = seen
                .iter()
                .filter(|e| e.x as usize * 4 / 60 == quarter)
                .count() as f64;
            let want = size.pixels() as f64 / 4.0 * 8.0 * share * seconds;
            near(
                seed,
                &format!("{response}, quarter {quarter}"),
                got,
                want,
                want.sqrt(),
            );
        }
    }
}

#[test]
fn hot_pixels_are_a_share_of_the_cells_and_stay_hot() {
    let size = Size::new(200, 200);
    let (fraction, hertz, seconds) = (0.02, 50.0, 2.0);
    let description = plain(
        "",
        "hot-fraction = 0.02\nhot-hz = 50",
        "{ on = 0.2, off = 0.2 }",
    );
    for seed in SEEDS {
        let seen = events(&description, &still(size, seconds, 10.0), seed);
        assert!(seen.iter().all(|e| e.polarity == Polarity::On));
        let hot = by_cell(&seen);
        let (n, cells) = (size.pixels() as f64, hot.len() as f64);
        near(
            seed,
            "hot cells",
            cells,
            n * fraction,
            (n * fraction * (1.0 - fraction)).sqrt(),
        );
        let want = cells * hertz * seconds;
        near(seed, "their events", seen.len() as f64, want, want.sqrt());
        // At another frame rate, other events of the same cells.
        let again = by_cell(&events(&description, &still(size, seconds, 3.0), seed));
        assert!(hot.keys().eq(again.keys()), "seed {seed}");
    }
    // Beside shot noise, the cells that are not hot have theirs.
    let both = plain(
        "",
        "hot-fraction = 0.02\nhot-hz = 50\nshot-hz = 2",
        "{ on = 0.2, off = 0.2 }",
    );
    let seen = events(&both, &still(size, seconds, 10.0), 1).len() as f64;
    let cells = size.pixels() as f64;
    let want = cells * seconds * (fraction * hertz + (1.0 - fraction) * 2.0);
    // The number of hot cells is drawn too.
    let variance = want + cells * fraction * (1.0 - fraction) * (hertz * seconds).powi(2);
    near(1, "both", seen, want, variance.sqrt());
}

#[test]
fn jitter_moves_events_and_keeps_them_in_their_pair() {
    let size = Size::new(60, 60);
    let frames = uniform(size, &[0.0, 0.02], |t| t / 0.02);
    // The line reaches 0.5 half-way.
    let threshold = "{ on = 0.5001, off = 1 }";
    for seed in SEEDS {
        let sharp = events(&plain("", "", threshold), &frames, seed);
        let moved = events(&plain("", "jitter-us = 500", threshold), &frames, seed);
        assert_eq!(sharp.len(), size.pixels());
        assert_eq!(moved.len(), size.pixels());
        let times: Vec<_> = moved.iter().map(|e| e.t.0 as f64).collect();
        let (middle, spread) = moments(&times);
        let n = times.len() as f64;
        near(seed, "mean", middle, 10_002.0, 500.0 / n.sqrt());
        near(seed, "jitter", spread, 500.0, 500.0 / (2.0 * n).sqrt());
        // Far more jitter than room: reflected until it is anywhere in the pair.
        let wild = events(&plain("", "jitter-us = 1000000", threshold), &frames, seed);
        assert!(wild.iter().all(|e| e.t.0 <= 20_000));
        let times: Vec<_> = wild.iter().map(|e| e.t.0 as f64).collect();
        near(
            seed,
            "reflected",
            moments(&times).0,
            10_000.0,
            20_000.0 / (12.0 * n).sqrt(),
        );
        assert!(
            times
                .iter()
                .filter(|t| **t == 0.0 || **t == 20_000.0)
                .count()
                < 5
        );
    }
}

#[test]
fn jitter_changes_no_counts() {
    let size = Size::new(9, 9);
    let times: Vec<_> = (0..30).map(|n| f64::from(n) / 240.0).collect();
    let frames = uniform(size, &times, |t| (t * 77.0).sin() * 3.0);
    let of = |noise| {
        let seen = events(
            &plain("", noise, "{ on = 0.2, off = 0.3, sigma = 0.02 }"),
            &frames,
            3,
        );
        let mut pairs: Vec<_> = seen.iter().map(|e| (e.y, e.x, e.polarity)).collect();
        pairs.sort_unstable();
        pairs
    };
    assert!(of("").len() > 1000);
    assert_eq!(of(""), of("jitter-us = 300"));
}

/// Nor does it where the dead time loses noise events for crossings, whatever is asked for.
#[test]
fn jitter_changes_no_counts_of_noise() {
    let size = Size::new(16, 16);
    let times: Vec<_> = (0..20).map(|n| f64::from(n) / 100.0).collect();
    let frames = uniform(size, &times, |t| (t * 77.0).sin() * 3.0);
    let dead = "refractory = { us = 2000 }\n";
    let of = |noise: &str, timed: bool| {
        let description = plain(dead, noise, "{ on = 0.2, off = 0.3, sigma = 0.02 }");
        let mut reference = Reference::new(description, size, 3).unwrap();
        let (mut tally, mut packet) = (Tally::new(1), Packet::new(size, 1));
        for frame in &frames {
            let mut list = EventList::new(&mut packet, Limit::default());
            let list = timed.then_some(&mut list);
            reference
                .watch_into(frame, &mut (&mut tally, list))
                .unwrap();
        }
        (tally.total(), reference.report())
    };
    let plain = of("shot-hz = 200", false);
    assert!(plain.1.lost_to_refractory > 100);
    for timed in [false, true] {
        assert_eq!(of("shot-hz = 200\njitter-us = 500", timed), plain);
    }
}

#[test]
fn the_photoreceptor_follows_a_held_step_exponentially() {
    let size = Size::new(1, 1);
    let noise = "cutoff-hz = 30\ncutoff-rule = \"step\"";
    let description = plain("", noise, "{ on = 1e-5, off = 1e-5 }");
    for light in [0.0, 51.0, 255.0, 2000.0] {
        let bandwidth = 30.0 * (light + 20.0) / 275.0;
        for fps in [100.0, 1000.0, 7919.0] {
            let mut reference = Reference::new(description.clone(), size, 0).unwrap();
            let mut tally = Tally::new(1);
            for n in 0..40u32 {
                let seconds = f64::from(n) / fps;
                let step = if n == 0 { 100.0 } else { light };
                let frame = Frame {
                    index: n.into(),
                    seconds,
                    light: Plane::from_elem((1, 1), step).into(),
                };
                reference.watch_into(&frame, &mut tally).unwrap();
                let got = reference.memory(0).unwrap()[[0, 0]];
                let want =
                    light + (100.0 - light) * (-std::f64::consts::TAU * bandwidth * seconds).exp();
                assert!(
                    (got - want).abs() < 1.1e-5,
                    "light {light}, {fps} frames/s, frame {n}: {got}, not {want}"
                );
            }
        }
    }
}

/// Light that moves on lags by the same time whatever the frame rate; where each frame counts as
/// held since the one before, it does not.
#[test]
fn the_photoreceptor_lags_alike_at_any_frame_rate() {
    let (size, seconds) = (Size::new(1, 1), 1.0);
    let light = |t: f64| 100.0 + 40.0 * t + if t > 0.5 { 300.0 * (t - 0.5) } else { 0.0 };
    let mut want = light(0.0);
    let steps = 1_000_000;
    for n in 0..steps {
        let t = (f64::from(n) + 0.5) / f64::from(steps) * seconds;
        let rate = std::f64::consts::TAU * 30.0 * (light(t) + 20.0) / 275.0;
        want += rate * (light(t) - want) * seconds / f64::from(steps);
    }
    let lag = light(seconds) - want;
    assert!(lag > 1.0, "{lag}");
    let wrong_by = |rule: &str, fps: u32| {
        let noise = format!("cutoff-hz = 30\ncutoff-rule = \"{rule}\"");
        let description = plain("", &noise, "{ on = 1e-5, off = 1e-5 }");
        let times: Vec<_> = (0..=fps).map(|n| f64::from(n) / f64::from(fps)).collect();
        let mut reference = Reference::new(description, size, 0).unwrap();
        for frame in uniform(size, &times, light) {
            reference.watch_into(&frame, &mut Tally::new(1)).unwrap();
        }
        (reference.memory(0).unwrap()[[0, 0]] - want).abs() / lag
    };
    for fps in [10, 24, 100, 1000] {
        let by = wrong_by("ramp", fps);
        // The bandwidth is that of the mean light: half a frame's change of it is in doubt.
        let doubt = 340.0 / f64::from(2 * fps) / (light(seconds) + 20.0);
        assert!(
            by < doubt + 0.003,
            "{fps} frames/s: the lag is wrong by {by} of it"
        );
    }
    assert!(wrong_by("step", 10) > 0.9);
    assert!(wrong_by("step", 100) > 0.3);
    assert!(wrong_by("step", 1000) < 0.15);
}

/// A scene in which a lot happens, and every noise.
fn busy() -> (Description, Vec<Frame>) {
    let text = "response = { lin-log = { knee = 20 } }\nmemory = \"filtered-step\"\nrefractory = { us = 900 }\n\
        noise = { leak-hz = 2, leak-spread = 0.1, shot-hz = 20, shot-at-white = 0.25, hot-fraction = 0.01, hot-hz = 300, jitter-us = 100, cutoff-hz = 100 }\n\
        [[channel]]\nkernel = \"csdvs-5\"\nthreshold = { on = 0.2, off = 0.25, sigma = 0.03 }\n\
        [[channel]]\nkernel = \"sobel-x\"\nthreshold = { on = 0.3, off = 0.3, sigma = 0.03 }\n";
    let description = Description::parse("busy.toml", text, &|_| unreachable!()).unwrap();
    let frame = |index: u64| {
        let seconds = index as f64 / 500.0;
        let wave = |y: usize, x: usize| (x as f64 * 0.3 + y as f64 * 0.1 - seconds * 60.0).sin();
        Frame {
            index,
            seconds,
            light: Plane::from_shape_fn((130, 120), |(y, x)| 100.0 + 80.0 * wave(y, x)).into(),
        }
    };
    (description, (0..12).map(frame).collect())
}

#[test]
fn the_same_seed_gives_the_same_events_on_any_number_of_threads() {
    let (description, frames) = busy();
    let on = |threads, seed| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap()
            .install(|| events(&description, &frames, seed))
    };
    let one = on(1, 7);
    assert!(one.len() > 50_000, "only {} events", one.len());
    assert_eq!(one, on(2, 7));
    assert_eq!(one, on(3, 7));
    assert_ne!(one, on(1, 8));
}

#[test]
fn counts_tallies_and_lists_agree_about_noise() {
    let (mut description, frames) = busy();
    // Several stray events of a cell in one pair.
    description.noise.shot_hz = 1000.0;
    description.refractory.us = 0.0;
    let size = Size::of(&frames[0].light);
    let mut reference = Reference::new(description, size, 9).unwrap();
    let mut packet = Packet::new(size, 2);
    let (mut counts, mut tally) = (Counts::new(size, 2), Tally::new(2));
    let mut net = [0i64; 2];
    for frame in &frames {
        let mut list = EventList::new(&mut packet, Limit::default());
        let mut sinks = (&mut counts, (&mut tally, &mut list));
        reference.watch_into(frame, &mut sinks).unwrap();
        if frame.index > 0 {
            for (net, plane) in net.iter_mut().zip(counts.planes()) {
                *net += plane.iter().map(|c| i64::from(*c)).sum::<i64>();
            }
        }
    }
    assert_eq!(packet.events.len() as u64, reference.report().events);
    assert_eq!(tally.total(), reference.report().events);
    for channel in 0..2u8 {
        let signs = packet.events.iter().filter(|e| e.channel == channel);
        let listed: i64 = signs.map(|e| i64::from(e.polarity.sign())).sum();
        let (on, off) = tally.kinds()[channel as usize];
        assert_eq!(net[channel as usize], listed);
        assert_eq!(on as i64 - off as i64, listed);
    }
}

#[test]
fn stray_events_are_added_to_what_the_scene_makes() {
    let size = Size::new(30, 30);
    let times: Vec<_> = (0..60).map(|n| f64::from(n) / 240.0).collect();
    let frames = uniform(size, &times, |t| (t * 40.0).sin());
    let threshold = "{ on = 0.2, off = 0.3, sigma = 0.02 }";
    let clean = events(&plain("", "", threshold), &frames, 3);
    let noisy = events(
        &plain(
            "",
            "shot-hz = 50\nhot-fraction = 0.1\nhot-hz = 100",
            threshold,
        ),
        &frames,
        3,
    );
    let mut rest = noisy.clone();
    rest.sort_unstable();
    for event in &clean {
        let at = rest
            .binary_search(event)
            .expect("an event of the scene is missing");
        rest.remove(at);
    }
    let want = size.pixels() as f64 * times[59] * (0.9 * 50.0 + 0.1 * 100.0);
    near(
        3,
        "strays",
        rest.len() as f64,
        want,
        (want + 900.0 * 0.09 * (50.0f64 * times[59]).powi(2)).sqrt(),
    );
}

#[test]
fn no_two_events_of_a_cell_are_closer_than_its_dead_time() {
    let size = Size::new(30, 30);
    let times: Vec<_> = (0..120).map(|n| f64::from(n) / 240.0).collect();
    let frames = uniform(size, &times, |t| (t * 40.0).sin());
    let noise = "shot-hz = 100\nhot-fraction = 0.1\nhot-hz = 1000\nleak-hz = 5";
    let rules = "refractory = { us = 3000 }";
    let description = plain(rules, noise, "{ on = 0.2, off = 0.3, sigma = 0.02 }");
    for seed in SEEDS {
        let cells = by_cell(&events(&description, &frames, seed));
        let gaps = cells
            .values()
            .flat_map(|t| t.windows(2).map(|w| w[1] - w[0]));
        let shortest = gaps.min().unwrap();
        assert!(
            (2999..3200).contains(&shortest),
            "seed {seed}: {shortest} us"
        );
    }
}

#[test]
fn dead_time_thins_shot_noise_as_a_renewal_process() {
    let size = Size::new(20, 20);
    let (rate, dead) = (50.0, 0.01);
    let description = plain(
        "refractory = { us = 10000 }",
        "shot-hz = 50",
        "{ on = 1, off = 1 }",
    );
    for (seed, fps) in iter::zip(SEEDS, [10.0, 60.0, 240.0]) {
        let seen = events(&description, &still(size, 11.0, fps), seed);
        let late = seen.iter().filter(|e| e.t.0 >= 1_000_000).count() as f64;
        let cycle: f64 = 1.0 / rate + dead;
        let n = size.pixels() as f64;
        let variance = n * 10.0 * (1.0 / rate).powi(2) / cycle.powi(3);
        near(seed, "thinned", late, n * 10.0 / cycle, variance.sqrt());
    }
}

#[test]
fn a_cell_is_ready_at_its_first_frame_whenever_that_is() {
    let size = Size::new(1, 1);
    for start in [-3.0, 0.0, 5.0] {
        for rule in ["dead-time", "authors"] {
            let rules = format!("refractory = {{ us = 50000, rule = \"{rule}\" }}");
            // Longer than many pairs; the authors' rule waits it out once, within a pair.
            let times = [start, start + if rule == "authors" { 0.2 } else { 0.001 }];
            let frames = uniform(size, &times, |t| if t > start { 1.5 } else { 0.0 });
            let mut reference =
                Reference::new(plain(&rules, "", "{ on = 1, off = 1 }"), size, 0).unwrap();
            let mut tally = Tally::new(1);
            for frame in &frames {
                reference.watch_into(frame, &mut tally).unwrap();
            }
            assert_eq!(tally.total(), 1, "{rule}, first frame at {start} s");
        }
    }
}
