//! The ruler against streams whose answer is known (identical, jittered, thinned, delayed,
//! permuted, redrawn, empty), against slow and obvious twins (a largest matching found by
//! augmenting paths, sorted lists, dense counts, double sums, the textbook's table, dense
//! grids), and the verb `compare` from outside.

mod common;

use amacrine::{
    compare::{
        Comparison, Pair, baseline, compare, counts,
        equality::Side,
        intervals, matching,
        metric::Metric,
        rates,
        score::{Scales, Score, measure, scores},
        van_rossum, victor_purpura,
        voxel::{self, Bins, voxels},
        window::{self, Redraws},
    },
    event::{Event, Packet, Polarity},
    plane::Size,
    stop::Stop,
    unit::Micros,
};
use proptest::prelude::*;

const WITHIN: Micros = Micros(1000);

/// A number that looks random, made of two others.
fn hash(a: u64, b: u64) -> u64 {
    let mut z = a.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ b.wrapping_mul(0xD1B5_4A32_D192_ED03);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// A stream of 20 events per second and cell, in order of time.
fn stream(seed: u64, events: u64) -> Packet {
    let size = Size::new(16, 20);
    let mut packet = Packet::new(size, 2);
    let cells = 16 * 20 * 2 * 2;
    let span = events * 1_000_000 / 20 / cells;
    packet.events = (0..events)
        .map(|i| {
            let h = hash(seed, i);
            Event {
                t: Micros(i * span / events + 100_000),
                x: (h % 20) as u16,
                y: (h / 20 % 16) as u16,
                polarity: sign(h / 320),
                channel: (h / 640 % 2) as u8,
            }
        })
        .collect();
    packet
}

fn sign(bit: u64) -> Polarity {
    if bit.is_multiple_of(2) {
        Polarity::Off
    } else {
        Polarity::On
    }
}

fn changed(packet: &Packet, change: impl FnMut((usize, &Event)) -> Option<Event>) -> Packet {
    let mut events: Vec<Event> = packet
        .events
        .iter()
        .enumerate()
        .filter_map(change)
        .collect();
    events.sort_by_key(|e| e.t);
    Packet {
        events,
        ..packet.clone()
    }
}

fn judge(a: &Packet, b: &Packet) -> Comparison {
    compare(a, b, WITHIN).unwrap()
}

#[test]
fn identical_streams_are_identical_in_any_order_within_a_time() {
    let mut a = stream(1, 20_000);
    for e in &mut a.events {
        e.t.0 /= 500;
    }
    let mut b = a.clone();
    for ties in b.events.chunk_by_mut(|a, b| a.t == b.t) {
        ties.reverse();
    }
    assert_ne!(a.events, b.events, "the readout order differs");
    let c = judge(&a, &b);
    assert!(c.equal && c.first_divergence.is_none());
    assert_eq!((c.precision, c.recall, c.f1), (Some(1.0), Some(1.0), 1.0));
    assert_eq!((c.cells.pearson, c.cells.l1), (Some(1.0), 0));
    let q = c.time_error_us.unwrap();
    assert_eq!((q.min, q.max), (0, 0));
    // 5 + 4 + 1 + 1 bits an event.
    assert_eq!((c.bits_per_event, c.bits), (11, [220_000, 220_000]));
    assert_eq!(c.events, [c.on[0] + c.off[0]; 2]);
}

#[test]
fn a_delay_within_the_window_moves_the_time_error_alone() {
    let a = stream(2, 20_000);
    let delayed = |by| {
        changed(&a, |(_, e)| {
            Some(Event {
                t: Micros(e.t.0 + by),
                ..*e
            })
        })
    };
    let c = judge(&a, &delayed(700));
    assert!(!c.equal);
    assert_eq!((c.matched, c.f1), (20_000, 1.0));
    assert_eq!(c.time_error_us.unwrap().p50, 700);
    assert_eq!(c.cells.l1, 0, "counts are blind to delay");
    let d = c.first_divergence.unwrap();
    assert_eq!((d.t, d.only_in), (a.events[0].t, Side::Reference));
    // Beyond the window only chance matches are left, in a stream this sparse few.
    assert!(judge(&a, &delayed(5000)).f1 < 0.1);
}

#[test]
fn jitter_within_half_the_window_loses_nothing() {
    let a = stream(3, 20_000);
    let b = changed(&a, |(i, e)| {
        Some(Event {
            t: Micros(e.t.0 + hash(7, i as u64) % 1001 - 500),
            ..*e
        })
    });
    let c = judge(&a, &b);
    assert_eq!(c.f1, 1.0);
    let q = c.time_error_us.unwrap();
    assert!(q.p05 < -400 && q.p95 > 400 && q.p50.abs() < 25, "{q:?}");
}

#[test]
fn ten_per_cent_lost_are_ten_per_cent_of_recall() {
    let a = stream(4, 20_000);
    let b = changed(&a, |(i, e)| (i % 10 != 3).then_some(*e));
    let c = judge(&a, &b);
    assert_eq!((c.precision, c.recall), (Some(1.0), Some(0.9)));
    assert!((c.f1 - 2.0 * 0.9 / 1.9).abs() < 1e-15);
    assert_eq!(c.cells.l1, 2_000);
    let d = c.first_divergence.unwrap();
    assert_eq!((d.t, d.only_in), (a.events[3].t, Side::Reference));
    // The other way round the two shares change places.
    let back = judge(&b, &a);
    assert_eq!(
        (back.precision, back.recall, back.f1),
        (Some(0.9), Some(1.0), c.f1)
    );
}

#[test]
fn wrong_pixels_signs_and_kinds_do_not_match() {
    let a = stream(5, 20_000);
    let permuted = changed(&a, |(_, e)| Some(Event { x: 19 - e.x, ..*e }));
    let flipped = changed(&a, |(_, e)| {
        let polarity = sign(u64::from(e.polarity.bit()) + 1);
        Some(Event { polarity, ..*e })
    });
    let other_kind = changed(&a, |(_, e)| {
        let channel = 1 - e.channel;
        Some(Event { channel, ..*e })
    });
    for b in [permuted, flipped, other_kind] {
        let c = judge(&a, &b);
        assert_eq!(c.events, [20_000; 2], "rates are blind to it");
        assert!(c.f1 < 0.1, "{}", c.f1);
        assert!(c.cells.pearson.unwrap().abs() < 0.2);
    }
}

#[test]
fn empty_streams_have_stated_values() {
    let full = stream(6, 100);
    let empty = Packet::new(full.size, full.channels);
    let c = judge(&empty, &empty);
    assert!(c.equal);
    assert_eq!((c.precision, c.recall, c.f1), (Some(1.0), Some(1.0), 1.0));
    assert_eq!((c.time_error_us, c.cells.pearson), (None, None));
    let c = judge(&empty, &full);
    assert_eq!((c.precision, c.recall, c.f1), (Some(0.0), None, 0.0));
    let c = judge(&full, &empty);
    assert_eq!((c.precision, c.recall, c.f1), (None, Some(0.0), 0.0));
}

#[test]
fn packets_of_different_sensors_are_refused() {
    let a = stream(7, 10);
    let wider = Packet {
        size: Size::new(16, 21),
        ..a.clone()
    };
    let kinder = Packet {
        channels: 3,
        ..a.clone()
    };
    let inconsistent = Packet {
        size: Size::new(1, 1),
        ..a.clone()
    };
    let said = |b: &Packet| compare(&a, b, WITHIN).unwrap_err().to_string();
    assert_eq!(
        said(&wider),
        "the reference is 20x16, the judged packet 21x16"
    );
    assert_eq!(
        said(&kinder),
        "the reference has 2 channels, the judged packet 3"
    );
    let outside = compare(&inconsistent, &inconsistent, WITHIN).unwrap_err();
    assert!(
        outside.to_string().contains("in a packet of 1x1"),
        "{outside}"
    );
}

/// Short streams on two cells, so that times crowd.
fn crowded() -> impl Strategy<Value = Packet> {
    prop::collection::vec((0..40_u64, 0..2_u16, any::<bool>()), 0..12).prop_map(|mut events| {
        events.sort_unstable();
        let mut packet = Packet::new(Size::new(1, 2), 1);
        packet.events = events
            .into_iter()
            .map(|(t, x, on)| Event {
                t: Micros(t),
                x,
                y: 0,
                polarity: sign(on.into()),
                channel: 0,
            })
            .collect();
        packet
    })
}

/// The largest matching, by augmenting paths: a pair may be any two events of one cell that
/// are close enough.
fn largest_matching(a: &[Event], b: &[Event], within: u64) -> u64 {
    fn augment(
        i: usize,
        may: &dyn Fn(usize, usize) -> bool,
        partner: &mut [Option<usize>],
        seen: &mut [bool],
    ) -> bool {
        for j in 0..partner.len() {
            if may(i, j) && !seen[j] {
                seen[j] = true;
                if partner[j].is_none_or(|other| augment(other, may, partner, seen)) {
                    partner[j] = Some(i);
                    return true;
                }
            }
        }
        false
    }
    let may = |i: usize, j: usize| {
        Event { t: b[j].t, ..a[i] } == b[j] && a[i].t.0.abs_diff(b[j].t.0) <= within
    };
    let mut partner = vec![None; b.len()];
    (0..a.len())
        .filter(|&i| augment(i, &may, &mut partner, &mut vec![false; b.len()]))
        .count() as u64
}

/// Removes from `a`, event by event, what `b` has.
fn without(a: &[Event], b: &[Event]) -> Vec<Event> {
    let mut b = b.to_vec();
    let mut rest = a.to_vec();
    rest.retain(|e| match b.iter().position(|other| other == e) {
        Some(at) => {
            b.swap_remove(at);
            false
        }
        None => true,
    });
    rest
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn greedy_in_time_order_is_a_largest_matching(a in crowded(), b in crowded(), within in 0..12_u64) {
        let c = compare(&a, &b, Micros(within)).unwrap();
        prop_assert_eq!(c.matched, largest_matching(&a.events, &b.events, within));
    }

    #[test]
    fn divergence_and_counts_agree_with_their_plain_twins(a in crowded(), b in crowded()) {
        let c = judge(&a, &b);
        prop_assert_eq!(c.equal, a.canonical() == b.canonical());
        let first = |events: Vec<Event>| {
            events.into_iter().min_by_key(|e| (e.t, e.y, e.x, e.channel, e.polarity))
        };
        let only_a = first(without(&a.events, &b.events)).map(|e| (e.t, e.y, e.x, e.polarity.bit(), 0));
        let only_b = first(without(&b.events, &a.events)).map(|e| (e.t, e.y, e.x, e.polarity.bit(), 1));
        let plain = only_a.into_iter().chain(only_b).min();
        let got = c.first_divergence.map(|d| (d.t, d.y, d.x, d.p, u8::from(d.only_in == Side::Judged)));
        prop_assert_eq!(got, plain);

        let count = |p: &Packet, cell: u16| {
            p.events.iter().filter(|e| e.x * 2 + u16::from(e.polarity.bit()) == cell).count() as f64
        };
        let pairs: Vec<(f64, f64)> = (0..4).map(|cell| (count(&a, cell), count(&b, cell))).collect();
        let l1: f64 = pairs.iter().map(|(a, b)| (a - b).abs()).sum();
        prop_assert_eq!(c.cells.l1 as f64, l1);
        let mean = |f: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(f).sum::<f64>() / 4.0;
        let (ma, mb) = (mean(&|p| p.0), mean(&|p| p.1));
        let cov = mean(&|p| (p.0 - ma) * (p.1 - mb));
        let (va, vb) = (mean(&|p| (p.0 - ma).powi(2)), mean(&|p| (p.1 - mb).powi(2)));
        match c.cells.pearson {
            Some(r) => prop_assert!((r - cov / (va * vb).sqrt()).abs() < 1e-9),
            None => prop_assert!(va == 0.0 || vb == 0.0),
        }
    }
}

mod scales {
    //! Every metric against its twin, and against streams whose answer is known.

    use std::{collections::BTreeMap, sync::atomic::AtomicBool};

    use super::*;

    fn pair(a: &Packet, b: &Packet) -> Pair {
        Pair::new(a, b).unwrap()
    }

    /// Small scales, as the packets are short.
    fn small() -> Scales {
        Scales {
            within: vec![Micros(1), Micros(6)],
            van_rossum: vec![Micros(3), Micros(20)],
            victor_purpura: vec![Micros(1), Micros(9)],
            bins: 4,
            seed: 5,
            ..Scales::default()
        }
    }

    /// A size that no file has: addresses end long before.
    #[test]
    fn a_size_beyond_all_addresses_is_compared() {
        let mut packet = Packet::new(Size::new(1 << 32, 1 << 32), 1);
        packet.events = vec![Event {
            t: Micros(5),
            x: 3,
            y: 7,
            polarity: Polarity::On,
            channel: 0,
        }];
        let scores = scores(&pair(&packet, &packet), &small());
        let own = |score: &&Score| score.value != score.identical;
        assert_eq!(scores.iter().find(own), None);
    }

    #[test]
    fn metrics_after_a_stop_have_no_value() {
        static STOP: AtomicBool = AtomicBool::new(true);
        let scales = Scales {
            stop: Stop::when(&STOP),
            ..small()
        };
        let packet = Packet::new(Size::new(3, 3), 1);
        let scores = scores(&pair(&packet, &packet), &scales);
        assert!(scores.iter().all(|score| score.value.is_none()));
    }

    fn measured(a: &Packet, b: &Packet) -> Vec<(Metric, Option<f64>)> {
        let pair = pair(a, b);
        let redraws = Redraws::new(&pair, small().seed);
        measure(&pair, &small(), Bins::over(&pair, 4), &redraws)
    }

    /// The times of every cell, ascending.
    fn cells(packet: &Packet) -> BTreeMap<(u16, u16, u8, Polarity), Vec<u64>> {
        let mut cells: BTreeMap<_, Vec<u64>> = BTreeMap::new();
        for e in packet.canonical() {
            let cell = (e.x, e.y, e.channel, e.polarity);
            cells.entry(cell).or_default().push(e.t.0);
        }
        cells
    }

    /// What `cost` gives for the two trains of each cell, per event.
    fn per_event(a: &Packet, b: &Packet, cost: impl Fn(&[u64], &[u64]) -> f64) -> f64 {
        let (ca, cb) = (cells(a), cells(b));
        let none = Vec::new();
        let all: std::collections::BTreeSet<_> = ca.keys().chain(cb.keys()).collect();
        let sum: f64 = all
            .iter()
            .map(|cell| cost(ca.get(cell).unwrap_or(&none), cb.get(cell).unwrap_or(&none)))
            .sum();
        let events = a.events.len() + b.events.len();
        if events == 0 {
            0.0
        } else {
            sum / (events as f64 / 2.0)
        }
    }

    /// The double sum of the definition.
    fn double_sum(a: &[u64], b: &[u64], tau: f64) -> f64 {
        let signed: Vec<(f64, f64)> = (a.iter().map(|t| (*t as f64, 1.0)))
            .chain(b.iter().map(|t| (*t as f64, -1.0)))
            .collect();
        let terms = signed.iter().flat_map(|(s, i)| {
            let term = move |(t, j): &(f64, f64)| i * j * (-(s - t).abs() / tau).exp();
            signed.iter().map(term)
        });
        terms.sum::<f64>() / 2.0
    }

    /// The textbook's table.
    fn table(a: &[u64], b: &[u64], q: f64) -> f64 {
        let mut row: Vec<f64> = (0..=b.len()).map(|j| j as f64).collect();
        for &ta in a {
            let mut next = vec![row[0] + 1.0];
            for (j, &tb) in b.iter().enumerate() {
                let shifted = row[j] + q * ta.abs_diff(tb) as f64;
                next.push(shifted.min(row[j + 1] + 1.0).min(next[j] + 1.0));
            }
            row = next;
        }
        row[b.len()]
    }

    /// The grids of the two pixels of a crowded packet, `[x][bin][OFF, ON]`.
    fn grid(packet: &Packet, first: u64, last: u64, bins: usize) -> Vec<f64> {
        let mut grid = vec![0.0; 2 * bins * 2];
        for e in &packet.events {
            let at = if last > first {
                (bins as f64 - 1.0) * (e.t.0 - first) as f64 / (last - first) as f64
            } else {
                0.0
            };
            for bin in 0..bins {
                let near = f64::max(0.0, 1.0 - (at - bin as f64).abs());
                let place = (usize::from(e.x) * bins + bin) * 2;
                grid[place + usize::from(e.polarity.bit())] += near;
            }
        }
        grid
    }

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() <= 1e-9 * (1.0 + a.abs())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(1500))]

        #[test]
        fn van_rossum_is_the_double_sum(a in crowded(), b in crowded(), tau in 1..50_u64) {
            let twin = per_event(&a, &b, |a, b| double_sum(a, b, tau as f64));
            let walked = van_rossum::distance(&pair(&a, &b), Micros(tau));
            prop_assert!(close(walked, twin), "{} {}", walked, twin);
        }

        #[test]
        fn victor_purpura_is_the_table(a in crowded(), b in crowded(), h in 1..50_u64) {
            let twin = per_event(&a, &b, |a, b| table(a, b, 1.0 / h as f64));
            let walked = victor_purpura::distance(&pair(&a, &b), Micros(h));
            prop_assert!(close(walked, twin), "{} {}", walked, twin);
        }

        #[test]
        fn voxels_are_the_dense_grids(a in crowded(), b in crowded(), bins in 1..7_usize) {
            let times = || a.events.iter().chain(&b.events).map(|e| e.t.0);
            let (first, last) = (times().min().unwrap_or(0), times().max().unwrap_or(0));
            let (ga, gb) = (grid(&a, first, last, bins), grid(&b, first, last, bins));
            let apart: Vec<f64> = ga.iter().zip(&gb).map(|(a, b)| b - a).collect();
            let signed: Vec<f64> = apart.chunks(2).map(|v| v[1] - v[0]).collect();
            let events = (a.events.len() + b.events.len()).max(1) as f64;
            let pair = pair(&a, &b);
            let got = voxels(&pair, Bins::over(&pair, bins));
            let l1 = |d: &[f64]| d.iter().map(|d| d.abs()).sum::<f64>() / events;
            prop_assert!(close(got.l1, l1(&signed)));
            prop_assert!(close(got.l1_signs_apart, l1(&apart)));
            let square: f64 = signed.iter().map(|d| d * d).sum();
            prop_assert!(close(got.rmse, (square / signed.len() as f64).sqrt()));
        }

        #[test]
        fn rate_maps_are_the_dense_counts(a in crowded(), b in crowded()) {
            let map = |p: &Packet, off: f64| -> Vec<f64> {
                let value = |e: &&Event| if e.polarity == Polarity::On { 1.0 } else { off };
                (0..2).map(|x| p.events.iter().filter(|e| e.x == x).map(|e| value(&e)).sum()).collect()
            };
            let events = (a.events.len() + b.events.len()).max(1) as f64;
            let got = rates::rates(&pair(&a, &b));
            for (off, got) in [(1.0, got.unsigned), (-1.0, got.signed)] {
                let (a, b) = (map(&a, off), map(&b, off));
                let l1 = (a[0] - b[0]).abs() + (a[1] - b[1]).abs();
                prop_assert!(close(got.l1, l1 / events));
                // Two points lie on a line: up, down, or level on one side.
                let slope = (a[0] - a[1]) * (b[0] - b[1]);
                prop_assert_eq!(got.pearson.is_none(), slope == 0.0);
                prop_assert!(got.pearson.is_none_or(|r| close(r, slope.signum())));
            }
        }

        #[test]
        fn the_divergence_of_intervals_is_that_of_their_histograms(a in crowded(), b in crowded()) {
            // In order of size: the bins from 0 to 40 us, by their upper ends.
            let ends = [0, 1, 2, 3, 4, 5, 6, 7, 9, 11, 13, 15, 19, 23, 27, 31, 39, 47];
            let histogram = |p: &Packet| {
                let mut counts = vec![0.0; ends.len()];
                for times in cells(p).values() {
                    for pair in times.windows(2) {
                        let interval = pair[1] - pair[0];
                        counts[ends.iter().position(|end| interval <= *end).unwrap()] += 1.0;
                    }
                }
                counts
            };
            let (ha, hb) = (histogram(&a), histogram(&b));
            let empty = |h: &[f64]| h.iter().all(|n| *n == 0.0);
            match intervals::divergence(&pair(&a, &b)) {
                None => prop_assert!(empty(&ha) || empty(&hb)),
                Some(got) => {
                    let used = |i: &usize| ha[*i] + hb[*i] > 0.0;
                    let first = (0..ends.len()).find(used).unwrap();
                    let last = (0..ends.len()).rfind(used).unwrap();
                    let shares = |h: &[f64]| -> Vec<f64> {
                        let all: f64 = h[first..=last].iter().map(|n| n + 0.5).sum();
                        h[first..=last].iter().map(|n| (n + 0.5) / all).collect()
                    };
                    let (p, q) = (shares(&ha), shares(&hb));
                    let kl = |p: &[f64], q: &[f64]| -> f64 {
                        p.iter().zip(q).map(|(p, q)| p * (p / q).ln()).sum()
                    };
                    prop_assert!(close(got.forward, kl(&p, &q)));
                    prop_assert!(close(got.back, kl(&q, &p)));
                }
            }
        }

        #[test]
        fn symmetric_metrics_do_not_care_who_is_judged(a in crowded(), b in crowded()) {
            for ((metric, one), (_, other)) in measured(&a, &b).into_iter().zip(measured(&b, &a)) {
                if metric.entry().symmetric {
                    let same = one.zip(other).map_or(one == other, |(a, b)| close(a, b));
                    prop_assert!(same, "{:?}: {:?} {:?}", metric, one, other);
                }
            }
        }

        #[test]
        fn the_order_among_ties_changes_nothing(a in crowded(), b in crowded()) {
            let mut turned = b.clone();
            for ties in turned.events.chunk_by_mut(|a, b| a.t == b.t) {
                ties.reverse();
            }
            prop_assert_eq!(measured(&a, &b), measured(&a, &turned));
        }

        #[test]
        fn identical_packets_score_exactly_perfect(a in crowded()) {
            for (metric, value) in measured(&a, &a) {
                let perfect = match metric.entry().key {
                    "kept" | "f1" | "precision" | "recall" => Some(1.0),
                    "count_pearson" | "rate_pearson" | "signed_rate_pearson" | "events_ratio" => value.and(Some(1.0)),
                    "interval_divergence" | "interval_divergence_back" => value.and(Some(0.0)),
                    "bits_sent" => Some(2.0 * a.events.len() as f64),
                    _ => Some(0.0),
                };
                prop_assert_eq!(value, perfect, "{:?}", metric);
            }
        }

        #[test]
        fn a_redraw_keeps_the_counts_and_takes_times_from_other_cells(a in crowded(), seed: u64) {
            let drawn = baseline::redraw(&pair(&a, &a), seed);
            let given = cells(&a);
            for (cell, reference, judged) in drawn.cells() {
                prop_assert_eq!(reference.len(), judged.len());
                let own = (cell.x(), cell.y(), cell.channel(), cell.polarity());
                for t in judged.iter() {
                    let elsewhere = given.iter().any(|(other, ts)| *other != own && ts.contains(&t));
                    let within = given[&own][0] <= t && t <= given[&own][given[&own].len() - 1];
                    prop_assert!(elsewhere || given.len() == 1 && within);
                }
            }
        }

        #[test]
        fn a_permutation_moves_whole_pixels(seed: u64, height in 1..9_usize, width in 1..9_usize) {
            // Each pixel says its own number, ON, and its number and 1000, OFF.
            let mut packet = Packet::new(Size::new(height, width), 1);
            for pixel in 0..height * width {
                for off in [false, true] {
                    packet.events.push(Event {
                        t: Micros(pixel as u64 + 1000 * u64::from(off)),
                        x: (pixel % width) as u16,
                        y: (pixel / width) as u16,
                        polarity: sign(u64::from(!off)),
                        channel: 0,
                    });
                }
            }
            let moved = baseline::permute(&pair(&packet, &packet), seed);
            let mut seen = Vec::new();
            let mut signs = BTreeMap::new();
            for (cell, reference, judged) in moved.cells() {
                prop_assert_eq!((reference.len(), judged.len()), (1, 1));
                for t in judged.iter() {
                    prop_assert_eq!(t >= 1000, cell.polarity() == Polarity::Off);
                    seen.push(t);
                    let pixel = signs.entry((cell.x(), cell.y())).or_insert(t % 1000);
                    prop_assert_eq!(*pixel, t % 1000);
                }
            }
            seen.sort_unstable();
            let mut all: Vec<u64> = packet.events.iter().map(|e| e.t.0).collect();
            all.sort_unstable();
            prop_assert_eq!(seen, all);
        }
    }

    const SIDE: u64 = 40;

    /// 20 events a second and cell for five seconds; intervals vary by half of themselves.
    fn firing(seed: u64) -> Packet {
        let mut packet = Packet::new(Size::new(40, 40), 1);
        for cell in 0..SIDE * SIDE {
            let uniform = |k: u64| (hash(hash(seed, cell), k) >> 11) as f64 / (1_u64 << 53) as f64;
            let mut t = uniform(0) * 50_000.0;
            let mut k = 1;
            while t < 5e6 {
                packet.events.push(Event {
                    t: Micros(t as u64),
                    x: (cell % SIDE) as u16,
                    y: (cell / SIDE) as u16,
                    polarity: Polarity::On,
                    channel: 0,
                });
                // A sum of four exponential waits.
                let waits: f64 = (k..k + 4).map(|k| -(1.0 - uniform(k)).ln()).sum();
                t += waits * 12_500.0;
                k += 4;
            }
        }
        packet.events.sort_by_key(|e| e.t);
        packet
    }

    /// Moves every event by a number that is distributed normally.
    fn jittered(packet: &Packet, sigma: f64) -> Packet {
        changed(packet, |(i, e)| {
            let uniform = |k| (hash(k, i as u64) >> 11) as f64 / (1_u64 << 53) as f64;
            let length = (-2.0 * (1.0 - uniform(21)).ln()).sqrt();
            let by = sigma * length * (std::f64::consts::TAU * uniform(22)).cos();
            let t = Micros((e.t.0 as f64 + by).max(0.0) as u64);
            Some(Event { t, ..*e })
        })
    }

    #[test]
    fn known_changes_have_known_sizes() {
        let a = firing(1);
        let delayed = changed(&a, |(_, e)| {
            Some(Event {
                t: Micros(e.t.0 + 5_000),
                ..*e
            })
        });
        let thinned = changed(&a, |(i, e)| {
            (!hash(31, i as u64).is_multiple_of(10)).then_some(*e)
        });
        let permuted = changed(&a, |(_, e)| {
            Some(Event {
                x: (u64::from(e.x) * 7 + u64::from(e.y) * 3 + 1).rem_euclid(SIDE) as u16,
                y: (e.y * 3 + 1) % 40,
                ..*e
            })
        });
        // Ratio of counts, divergence of intervals, van Rossum at 5 ms, Victor and Purpura at
        // 200 per second, as computed by another program on streams of its own.
        let cases = [
            (
                "jitter of 1 ms",
                jittered(&a, 1e3),
                [1.0, 0.001, 0.143, 0.162],
            ),
            (
                "jitter of 10 ms",
                jittered(&a, 1e4),
                [1.0, 0.043, 0.655, 1.22],
            ),
            ("10 % dropped", thinned, [0.9, 0.018, 0.053, 0.105]),
            ("pixels permuted", permuted, [1.0, 0.0, 0.806, 1.59]),
            ("delay of 5 ms", delayed, [1.0, 0.0, 0.625, 1.0]),
            ("another stream", firing(2), [1.0, 0.0024, 0.815, 1.61]),
        ];
        for (name, b, [ratio, divergence, rossum, purpura]) in cases {
            let pair = pair(&a, &b);
            let redraws = Redraws::new(&pair, 0);
            let all = measure(&pair, &Scales::default(), Bins::over(&pair, 8), &redraws);
            let value = |metric| all.iter().find(|(m, _)| *m == metric).unwrap().1.unwrap();
            println!(
                "| {name} | {:.3} | {:.4} | {:.3} | {:.3} | {:.3} | {:.3} | {:.3} |",
                value(counts::EVENTS.alone()),
                value(intervals::ENTRY.alone()),
                value(van_rossum::ENTRY.at(Micros(5_000))),
                value(victor_purpura::ENTRY.at(Micros(5_000))),
                value(matching::F1.at(Micros(1_000))),
                value(voxel::L1.alone()),
                value(rates::L1.alone()),
            );
            assert!(
                (value(counts::EVENTS.alone()) - ratio).abs() < 0.01,
                "{name}"
            );
            let got = value(intervals::ENTRY.alone());
            assert!((got - divergence).abs() < 0.005, "{name} {got}");
            let got = value(van_rossum::ENTRY.at(Micros(5_000)));
            assert!((got - rossum).abs() < 0.02, "{name} {got}");
            let got = value(victor_purpura::ENTRY.at(Micros(5_000)));
            assert!((got - purpura).abs() < 0.03, "{name} {got}");
        }
    }

    #[test]
    fn pieces_of_work_join_to_the_whole() {
        // 1280 cells, in two kinds: more than one piece, none of which parts a pixel's signs.
        let (a, b) = (stream(40, 3_000), stream(41, 3_000));
        let pair = pair(&a, &b);
        let twin = per_event(&a, &b, |a, b| double_sum(a, b, 700.0));
        assert!(close(van_rossum::distance(&pair, Micros(700)), twin));
        let twin = per_event(&a, &b, |a, b| table(a, b, 1.0 / 900.0));
        assert!(close(victor_purpura::distance(&pair, Micros(900)), twin));

        let mut net: BTreeMap<_, [i64; 2]> = BTreeMap::new();
        for (packet, sign) in [(&a, 1), (&b, -1)] {
            for e in &packet.events {
                let site = net.entry((e.x, e.y, e.channel)).or_default();
                site[0] += sign;
                site[1] += sign * i64::from(e.polarity.sign());
            }
        }
        let l1 = |map: usize| net.values().map(|d| d[map].abs()).sum::<i64>() as f64 / 6_000.0;
        let rates = rates::rates(&pair);
        assert_eq!((rates.unsigned.l1, rates.signed.l1), (l1(0), l1(1)));
        // One bin holds the whole count.
        assert_eq!(voxels(&pair, Bins::over(&pair, 1)).l1, l1(1));
    }

    /// By its definition, from the scores of F1; and it is 1 of the reference, 0 of redraws.
    #[test]
    fn what_is_kept_is_f1_above_that_of_redraws() {
        let (a, b) = (firing(1), firing(2));
        let thinned = changed(&a, |(i, e)| (i % 4 != 1).then_some(*e));
        for judged in [&a, &b, &thinned] {
            let all = scores(&pair(&a, judged), &Scales::default());
            let at = |metric| *all.iter().find(|s| s.metric == metric).unwrap();
            for within in Scales::default().within {
                let (f1, kept) = (at(matching::F1.at(within)), at(window::KEPT.at(within)));
                let floor = f1.redraw.unwrap();
                let wanted = (f1.value.unwrap() - floor) / (1.0 - floor);
                assert!((kept.value.unwrap() - wanted).abs() < 1e-12, "{kept:?}");
                assert_eq!(kept.identical, Some(1.0));
                assert!(kept.redraw.unwrap().abs() < 1e-12, "{kept:?}");
                let lost = kept.lost().unwrap();
                assert!((lost - (1.0 - kept.value.unwrap())).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn scores_have_what_is_known_beside_them() {
        let (a, b) = (firing(1), firing(2));
        let scales = Scales::default();
        for score in scores(&pair(&a, &a), &scales) {
            assert_eq!(score.value, score.identical, "{score:?}");
            assert!(score.lost().is_none_or(|lost| lost == 0.0), "{score:?}");
        }
        let other = scores(&pair(&a, &b), &scales);
        let at = |metric| *other.iter().find(|s| s.metric == metric).unwrap();
        for metric in [
            van_rossum::ENTRY.at(Micros(5_000)),
            victor_purpura::ENTRY.at(Micros(5_000)),
            matching::F1.at(Micros(1_000)),
        ] {
            // Nothing in common with the reference but the rate.
            let lost = at(metric).lost().unwrap();
            assert!((0.75..1.1).contains(&lost), "{:?}", at(metric));
        }
        for blind in [
            rates::L1.alone(),
            rates::SIGNED_L1.alone(),
            counts::L1.alone(),
            counts::BITS.alone(),
        ] {
            assert_eq!(at(blind).redraw, at(blind).identical, "{blind:?}");
            assert_eq!(at(blind).lost(), None);
        }
        assert_eq!(
            at(intervals::ENTRY.alone()).permuted,
            Some(0.0),
            "blind to wrong pixels"
        );
        assert!(at(rates::L1.alone()).permuted.unwrap() > 0.005);
        // The same seed draws the same streams, another one others.
        assert_eq!(other, scores(&pair(&a, &b), &scales));
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        let one_thread = alone.unwrap().install(|| scores(&pair(&a, &b), &scales));
        assert_eq!(other, one_thread, "the number of threads changes no digit");
        let reseeded = Scales { seed: 1, ..scales };
        assert_ne!(other, scores(&pair(&a, &b), &reseeded));
    }

    #[test]
    fn a_redraw_of_frames_stays_on_the_frames() {
        // All events are on one of ten frames, where they often meet by chance.
        let mut a = stream(42, 20_000);
        for (i, e) in a.events.iter_mut().enumerate() {
            e.t = Micros(hash(43, i as u64) % 10 * 40_000);
        }
        a.events.sort_by_key(|e| e.t);
        let all = scores(&pair(&a, &a), &Scales::default());
        let f1 = all.iter().find(|s| s.metric == matching::F1.at(Micros(1)));
        let redraw = f1.unwrap().redraw.unwrap();
        assert!(redraw > 0.5, "{redraw}");
    }

    #[test]
    fn packets_at_the_edges_have_finite_scores() {
        let empty = Packet::new(Size::new(4, 4), 1);
        // One event in a corner of the largest sensor, at the end of time.
        let mut lone = Packet::new(Size::new(65_536, 65_536), 255);
        lone.events.push(Event {
            t: Micros(u64::MAX),
            x: u16::MAX,
            y: u16::MAX,
            polarity: Polarity::On,
            channel: 254,
        });
        let nothing = Packet {
            events: Vec::new(),
            ..lone.clone()
        };
        for (a, b) in [
            (&empty, &empty),
            (&lone, &lone),
            (&lone, &nothing),
            (&nothing, &lone),
        ] {
            for score in scores(&pair(a, b), &Scales::default()) {
                for value in [score.value, score.identical, score.redraw, score.permuted] {
                    assert!(value.is_none_or(f64::is_finite), "{score:?}");
                }
            }
        }
    }
}

/// Seconds for streams of `events` each; not a test, since it depends on the machine.
#[test]
#[ignore = "a timing: cargo test --release --test compare -- --ignored --nocapture"]
fn ten_million_events() {
    let a = stream(8, 10_000_000);
    let b = changed(&a, |(i, e)| {
        Some(Event {
            t: Micros(e.t.0 + hash(9, i as u64) % 300),
            ..*e
        })
    });
    let start = std::time::Instant::now();
    let c = judge(&a, &b);
    println!("{:.2} s, F1 {}", start.elapsed().as_secs_f64(), c.f1);
    assert!(c.f1 > 0.99);
}

mod verb {
    //! `amacrine compare` as a person or a script meets it.

    use super::*;
    use crate::common;
    use amacrine::event::file;
    use assert_cmd::Command;
    use std::path::Path;

    fn amacrine(arguments: &[&str]) -> Command {
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        common::amacrine(here, &[&["compare"], arguments].concat())
    }

    #[test]
    fn json_is_one_object_with_the_promised_keys() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        let (a, b) = (path("a.npy"), path("b.csv"));
        let packet = stream(10, 5_000);
        let thinned = changed(&packet, |(i, e)| (i % 10 != 3).then_some(*e));
        file::write(a.as_ref(), &packet).unwrap();
        file::write(b.as_ref(), &thinned).unwrap();
        let out = amacrine(&[&a, &b, "--within", "100us", "--json"])
            .assert()
            .success();
        let json: serde_json::Value = serde_json::from_slice(&out.get_output().stdout).unwrap();
        assert_eq!(json["equal"], false);
        assert_eq!(json["first_divergence"]["t"], packet.events[3].t.0);
        assert_eq!(json["first_divergence"]["only_in"], "reference");
        assert_eq!(json["events"], serde_json::json!([5000, 4500]));
        assert_eq!(json["matched"], 4500);
        assert_eq!(json["precision"], 1.0);
        assert_eq!(json["recall"], 0.9);
        assert_eq!(json["within_us"], 100);
        assert_eq!(json["time_error_us"]["p50"], 0);
        assert_eq!(json["bits"], serde_json::json!([55000, 49500]));
        assert_eq!(json["reference"]["size_known"], true);
        assert_eq!(json["judged"]["size_known"], false);
        assert_eq!(json["judged"]["width"], 20);
        for key in ["on", "off", "f1", "kinds", "cells", "dropped"] {
            assert!(!json[key].is_null(), "{key}");
        }
        // Text does not say what is missing of it.
        assert_eq!(json["dropped"], serde_json::json!([0, null]));
    }

    /// Events on frames of 40 ms, of which the judged packet has some one frame late: within less
    /// than a frame it lost them, within a frame it has them all.
    #[test]
    fn the_headline_and_the_curve_know_the_frames() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        let (a, b) = (path("a.npy"), path("b.npy"));
        // Cells speak every twelfth frame, so that a frame late is no other event.
        let on_frames = |late: u64| {
            changed(&stream(21, 6_000), |(i, e)| {
                let frame = 12 * (i as u64 / 400) + u64::from(e.x + e.y) % 12;
                let late = if i % 3 == 0 { late } else { 0 };
                Some(Event {
                    t: Micros((frame + late) * 40_000),
                    ..*e
                })
            })
        };
        file::write(a.as_ref(), &on_frames(0)).unwrap();
        file::write(b.as_ref(), &on_frames(1)).unwrap();
        let json = |more: &[&str]| -> serde_json::Value {
            let arguments = [&[a.as_str(), &b, "--json"], more].concat();
            let out = amacrine(&arguments).assert().success();
            serde_json::from_slice(&out.get_output().stdout).unwrap()
        };
        let said = json(&[]);
        let headline = &said["headline"];
        assert_eq!(headline["frame_interval_us"], 40_000);
        assert_eq!(
            (&headline["window_us"], &said["within_us"]),
            (&100_000.into(), &100_000.into())
        );
        assert_eq!(
            (&headline["kept"], &headline["f1"]),
            (&1.0.into(), &1.0.into())
        );
        assert!(headline["fps"].is_null());
        let curve = said["curve"].as_array().unwrap();
        assert_eq!(curve.len(), 19);
        let mut before = 0.0;
        for point in curve {
            let window = point["window_us"].as_u64().unwrap();
            let number = |key: &str| point[key].as_f64().unwrap();
            let (f1, floor, kept) = (number("f1"), number("floor"), number("kept"));
            assert_eq!(point["below_frame_interval"], window < 40_000, "{window}");
            assert!((kept - (f1 - floor) / (1.0 - floor)).abs() < 1e-12);
            assert!(floor > 0.0 && f1 >= before, "{window}");
            assert_eq!(f1 < 0.7, window < 40_000, "{window}: {f1}");
            before = f1;
        }
        // Frames further apart than the usual window.
        let slow = json(&["--fps", "4"]);
        assert_eq!(slow["headline"]["window_us"], 250_000);
        assert_eq!(slow["headline"]["frame_interval_us"], 250_000);
        let asked = json(&["--within", "200ms"]);
        assert_eq!(asked["headline"]["window_us"], 200_000);
        assert_eq!(asked["headline"]["kept"], 1.0);

        let drawn = path("curve.svg");
        let out = amacrine(&[&a, &b, "-o", &drawn]).assert().success();
        let table = String::from_utf8_lossy(&out.get_output().stdout).into_owned();
        assert!(
            table.starts_with("kept 1.0000 within 100ms: F1 1.0000, by chance "),
            "{table}"
        );
        assert!(
            table.contains("; frame rate not said: by the events' times a frame every 40ms or a whole part of it (--fps says it)\n"),
            "{table}"
        );
        assert!(
            table.contains("     1us*    10us*   100us*     1ms*    10ms*    100ms       1s\n"),
            "{table}"
        );
        assert!(table.contains("says which frame, not when"), "{table}");
        let svg = std::fs::read_to_string(&drawn).unwrap();
        for text in ["b.npy against a.npy", "which frame, not when", "100 ms"] {
            assert!(svg.contains(text), "{text}");
        }
        for (arguments, says) in [
            (vec![a.as_str(), &b, "--fps", "0"], "0 frames"),
            (vec![&a, &b, "--scene", "pattern:disc"], "--sensor"),
            (vec![&a, &b, "--upsample", "0.1"], "--sensor"),
        ] {
            let out = amacrine(&arguments).assert().code(2);
            let said = String::from_utf8_lossy(&out.get_output().stderr).into_owned();
            assert!(said.contains(says), "{said}");
        }
    }

    /// The sensor of the reference at a threshold a fifth higher is told by that, and another
    /// sensor's events are refused.
    #[test]
    fn a_sensor_and_its_scene_tell_the_threshold_equivalent() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        let scene = "pattern:noise?width=48&height=40&frames=40&speed=90&fps=30";
        let made = |name: &str, threshold: f64| {
            let sensor = path(&format!("{name}.toml"));
            let text = format!(
                "response = \"identity\"\nmemory = \"filtered-snap\"\n[[channel]]\nkernel = \"csdvs-3\"\nthreshold = {{ on = {threshold}, off = {threshold} }}\n"
            );
            std::fs::write(&sensor, text).unwrap();
            let events = path(&format!("{name}.npy"));
            let here = Path::new(env!("CARGO_MANIFEST_DIR"));
            let run = [
                "run", "--scene", scene, "--sensor", &sensor, "--events", &events,
            ];
            common::amacrine(here, &run).assert().success();
            (sensor, events)
        };
        let (sensor, reference) = made("float", 6.0);
        let (other, higher) = made("higher", 6.0 * 1.2);
        let ask = [&reference, &higher, "--scene", scene, "--json", "--sensor"];
        let out = amacrine(&[&ask[..], &[&sensor]].concat())
            .assert()
            .success();
        let said: serde_json::Value = serde_json::from_slice(&out.get_output().stdout).unwrap();
        let headline = &said["headline"];
        let percent = headline["threshold_equivalent_percent"].as_f64().unwrap();
        assert!((percent - 20.0).abs() < 1e-6, "{percent}");
        assert_eq!(headline["threshold_equivalent_is_least"], false);
        assert!(headline["fps"].is_number());
        // A sensor with that threshold has as many events, and they are these.
        let tuned = &headline["tuned"];
        assert!((tuned["threshold_percent"].as_f64().unwrap() - 20.0).abs() < 1e-6);
        assert_eq!(tuned["kept"], 1.0);
        let out = amacrine(&[&ask[..], &[&other]].concat()).assert().code(2);
        let said = common::line(&out.get_output().stderr).replace(' ', "");
        assert!(said.contains("theypartat"), "{said}");
    }

    /// Three frames with events at uneven times are frames of the rate that is stated, and of one
    /// step of all pixels nothing is kept that chance does not keep.
    #[test]
    fn few_frames_are_frames_and_one_step_keeps_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        let text = "response = \"identity\"\nmemory = \"filtered-snap\"\n[[channel]]\nkernel = [[1.0]]\nthreshold = { on = 11.75, off = 11.75 }\n";
        std::fs::write(path("s.toml"), text).unwrap();
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        let (scene, mirrored) = (path("light.npy"), path("mirrored.npy"));
        let (a, b, sensor) = (path("a.npy"), path("b.npy"), path("s.toml"));
        let told = |changes: &[usize]| {
            let light = ndarray::Array3::from_shape_fn((30, 6, 6), |(t, y, x)| {
                let steps = changes.iter().filter(|at| **at <= t).count();
                30.0 + 10.0 * steps as f64 * (1.0 + 0.01 * (6 * y + x) as f64)
            });
            ndarray_npy::write_npy(&scene, &light).unwrap();
            let turned = light.slice(ndarray::s![.., ..;-1, ..;-1]).to_owned();
            ndarray_npy::write_npy(&mirrored, &turned).unwrap();
            for (scene, events) in [(&scene, &a), (&mirrored, &b)] {
                let run = ["run", "--sensor", &sensor, "--scene", scene, "--fps", "5"];
                let run = [&run[..], &["--events", events]].concat();
                common::amacrine(here, &run).assert().success();
            }
            let ask = [&a, &b, "--sensor", &sensor, "--scene", &scene];
            let ask = [&ask[..], &["--fps", "5", "--json"]].concat();
            let out = amacrine(&ask).assert().success();
            let said: serde_json::Value = serde_json::from_slice(&out.get_output().stdout).unwrap();
            said["headline"].clone()
        };
        let headline = told(&[4, 10, 17]);
        assert_eq!(headline["frame_interval_us"], 200_000, "{headline}");
        assert_eq!(headline["window_us"], 200_000);
        let headline = told(&[10]);
        let tuned = &headline["tuned"];
        assert!(tuned["threshold_percent"].is_number(), "{headline}");
        assert!(tuned["kept"].is_null() && tuned["threshold_equivalent_percent"].is_null());
    }

    /// Times of crossings are on no frames, whoever knows the frame rate of the scene.
    #[test]
    fn a_scene_makes_no_frames_of_crossing_times() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        let scene = "pattern:noise?width=24&height=20&frames=12&speed=90&fps=5";
        let [sensor, events] = ["dvs.toml", "events.npy"].map(path);
        let text = "response = { lin-log = { knee = 20 } }\nmemory = \"filtered-step\"\n[[channel]]\nkernel = \"dvs\"\nthreshold = { on = 0.2, off = 0.2 }\n";
        std::fs::write(&sensor, text).unwrap();
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        let run = [
            "run", "--scene", scene, "--sensor", &sensor, "--events", &events,
        ];
        common::amacrine(here, &run).assert().success();
        let said = |more: &[&str]| -> serde_json::Value {
            let arguments = [&[events.as_str(), &events, "--json"], more].concat();
            let out = amacrine(&arguments).assert().success();
            serde_json::from_slice(&out.get_output().stdout).unwrap()
        };
        let (alone, beside) = (said(&[]), said(&["--scene", scene, "--sensor", &sensor]));
        assert_eq!(beside["headline"]["window_us"], 100_000);
        assert!(beside["headline"]["frame_interval_us"].is_null());
        assert_eq!(alone["curve"], beside["curve"]);
    }

    #[test]
    fn json_holds_every_metric_beside_what_is_known() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        let (a, b) = (path("a.npy"), path("b.npy"));
        let packet = stream(13, 5_000);
        let thinned = changed(&packet, |(i, e)| (i % 10 != 3).then_some(*e));
        file::write(a.as_ref(), &packet).unwrap();
        file::write(b.as_ref(), &thinned).unwrap();
        let json = |more: &[&str]| -> serde_json::Value {
            let arguments = [&[a.as_str(), &b, "--json"], more].concat();
            let out = amacrine(&arguments).assert().success();
            serde_json::from_slice(&out.get_output().stdout).unwrap()
        };
        let ruler = &json(&["--within", "3ms", "--bins", "5", "--seed", "7"])["ruler"];
        assert_eq!((&ruler["bins"], &ruler["seed"]), (&5.into(), &7.into()));
        for within in ["1us", "100us", "1ms", "3ms", "10ms"] {
            assert_eq!(ruler[format!("recall_{within}")]["value"], 0.9);
            assert_eq!(ruler[format!("precision_{within}")]["value"], 1.0);
            assert_eq!(ruler[format!("f1_{within}")]["identical"], 1.0);
            assert!(ruler[format!("f1_{within}")]["redraw"].as_f64().unwrap() < 0.5);
        }
        for key in [
            "van_rossum_5ms",
            "van_rossum_50ms",
            "victor_purpura_5ms",
            "victor_purpura_50ms",
            "voxel_l1",
            "voxel_l1_signs_apart",
            "voxel_rmse",
            "count_l1",
            "rate_l1",
            "signed_rate_l1",
        ] {
            let score = &ruler[key];
            assert_eq!(score["identical"], 0.0, "{key}");
            assert!(score["value"].as_f64().unwrap() > 0.0, "{key}");
            assert!(score["redraw"].is_number() && score["permuted"].is_number());
            assert_eq!(score["symmetric"], true);
        }
        for key in ["count_pearson", "rate_pearson", "signed_rate_pearson"] {
            assert_eq!(ruler[key]["identical"], 1.0, "{key}");
            assert_eq!(ruler[key]["redraw"], 1.0, "{key}: blind to time");
            assert!(ruler[key]["lost"].is_null());
        }
        assert_eq!(ruler["events_ratio"]["value"], 0.9);
        assert_eq!(ruler["bits_sent"]["value"], 49_500.0);
        assert_eq!(ruler["bits_sent"]["identical"], 55_000.0);
        assert_eq!(ruler["interval_divergence"]["permuted"], 0.0);
        assert_eq!(
            ruler["interval_divergence"]["blind_to"],
            "wrong pixels, delay"
        );
        assert_eq!(ruler["interval_divergence"]["symmetric"], false);
        // The same seed gives the same text.
        assert_eq!(json(&[]), json(&["--seed", "0", "--bins", "8"]));
        assert_ne!(json(&[])["ruler"], json(&["--seed", "1"])["ruler"]);
    }

    #[test]
    fn the_table_says_who_is_judged_and_whether_the_size_is_known() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        let (a, b) = (path("a.npy"), path("b.txt"));
        let mut packet = stream(11, 50);
        packet.channels = 1;
        packet.events.retain(|e| e.channel == 0);
        file::write(a.as_ref(), &packet).unwrap();
        file::write(b.as_ref(), &packet).unwrap();
        let out = amacrine(&[&a, &b]).assert().success();
        let table = String::from_utf8_lossy(&out.get_output().stdout).into_owned();
        assert!(
            table.contains(&format!("reference  {a}, 20x16\n")),
            "{table}"
        );
        assert!(
            table.contains(&format!("judged     {b}, 20x16 (the file")),
            "{table}"
        );
        assert!(table.contains("identical"), "{table}");
        assert!(table.contains("F1 1.0000"), "{table}");
        for row in [
            "metric                         judged  identical     redraw   permuted   lost  blind to",
            "F1 within 1ms                       1          1",
            "van Rossum, 5ms                     0          0",
            "interval divergence",
            "never use it alone",
        ] {
            assert!(table.contains(row), "{row}:\n{table}");
        }
    }

    #[test]
    fn bad_input_is_one_message_and_exit_code_2() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        let (a, b) = (path("a.npy"), path("b.npy"));
        let packet = stream(12, 50);
        file::write(a.as_ref(), &packet).unwrap();
        let wider = Packet {
            size: Size::new(16, 21),
            ..packet
        };
        file::write(b.as_ref(), &wider).unwrap();
        for (arguments, says) in [
            (vec![a.as_str(), &b], "21x16"),
            (vec![&a, "nowhere.csv"], "nowhere.csv"),
            (vec![&a, "a.jpg"], "`jpg`"),
            (vec![&a, &a, "--within", "1 parsec"], "1 parsec"),
            (vec![&a, &a, "--bins", "0"], "--bins"),
        ] {
            let out = amacrine(&arguments).assert().code(2);
            let said = String::from_utf8_lossy(&out.get_output().stderr).into_owned();
            assert!(said.contains(says), "{said}");
            assert!(out.get_output().stdout.is_empty());
        }
    }
}
