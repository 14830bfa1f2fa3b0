//! The ruler against streams whose answer is known (identical, jittered, thinned, delayed,
//! permuted, empty), against slow and obvious twins (a largest matching found by augmenting
//! paths, sorted lists, dense counts), and the verb `compare` from outside.

use amacrine::{
    compare::{Comparison, compare, equality::Side},
    event::{Event, Packet, Polarity},
    plane::Size,
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
    assert_eq!((c.precision, c.recall, c.f1), (1.0, 1.0, 1.0));
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
    assert_eq!((c.precision, c.recall), (1.0, 0.9));
    assert!((c.f1 - 2.0 * 0.9 / 1.9).abs() < 1e-15);
    assert_eq!(c.cells.l1, 2_000);
    let d = c.first_divergence.unwrap();
    assert_eq!((d.t, d.only_in), (a.events[3].t, Side::Reference));
    // The other way round the two shares change places.
    let back = judge(&b, &a);
    assert_eq!((back.precision, back.recall, back.f1), (0.9, 1.0, c.f1));
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
    assert_eq!((c.precision, c.recall, c.f1), (1.0, 1.0, 1.0));
    assert_eq!((c.time_error_us, c.cells.pearson), (None, None));
    let c = judge(&empty, &full);
    assert_eq!((c.precision, c.recall, c.f1), (0.0, 1.0, 0.0));
    let c = judge(&full, &empty);
    assert_eq!((c.precision, c.recall, c.f1), (1.0, 0.0, 0.0));
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
    use amacrine::event::file;
    use assert_cmd::Command;

    fn amacrine(arguments: &[&str]) -> Command {
        let mut command = Command::cargo_bin("amacrine").unwrap();
        command.arg("compare").args(arguments);
        command
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
        assert_eq!(json["judged"]["size"]["width"], 20);
        for key in ["on", "off", "f1", "kinds", "cells", "dropped"] {
            assert!(!json[key].is_null(), "{key}");
        }
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
        ] {
            let out = amacrine(&arguments).assert().code(2);
            let said = String::from_utf8_lossy(&out.get_output().stderr).into_owned();
            assert!(said.contains(says), "{said}");
            assert!(out.get_output().stdout.is_empty());
        }
    }
}
