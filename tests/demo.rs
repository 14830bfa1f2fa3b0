//! The verb `demo` from outside: what it shows as the kernel that the chip can carry is what
//! `feasibility` chooses; its rows agree with `quantise`, and say at which rate and within which
//! window they were judged. `tests/pages.rs` looks at its table.
#![cfg(feature = "cli")]

mod common;

use std::sync::OnceLock;

use amacrine::{
    compile::Effort,
    isa::Device,
    kernel::{
        Kernel,
        quantise::{Quantiser, Sum},
    },
    scene::bundled,
    study::{
        defaults::CANDIDATES,
        design::Design,
        feasibility::Question,
        quantisation::{self, Outcome, Row},
    },
    unit::Micros,
};
use common::json;
use serde_json::Value;
use tempfile::TempDir;

/// The demo, shown once for all tests.
fn demo() -> &'static Value {
    static DEMO: OnceLock<Value> = OnceLock::new();
    DEMO.get_or_init(|| json(TempDir::new().unwrap().path(), &["demo", "--output", "o"]))
}

/// Rows on the array, at the clip's own rate or at the other.
fn rows(own: bool) -> Vec<&'static Value> {
    let rows = demo()["rows"].as_array().unwrap().iter();
    rows.filter(|row| (row["fps"] == 10.0) == own && !row["kept"].is_null())
        .collect()
}

#[track_caller]
fn row(own: bool, to: &str, domain: &str) -> &'static Value {
    let found =
        |row: &&&Value| row["cell"] == "rgc-5x5" && row["to"] == to && row["domain"] == domain;
    rows(own).iter().find(found).unwrap()
}

fn number(of: &Value, key: &str) -> f64 {
    of[key].as_f64().unwrap_or_else(|| panic!("no {key}: {of}"))
}

/// The table from which `feasibility` chooses, for the demo's kernel, threshold and clip.
fn candidates() -> Vec<(Quantiser, Row)> {
    let (kernel, device) = (Kernel::builtin("rgc-5x5").unwrap(), Device::scamp5());
    let quantisers: Vec<Quantiser> = { CANDIDATES.split(',') }
        .map(|name| name.parse().unwrap())
        .collect();
    let asked = quantisation::Question {
        design: Design {
            kernel: &kernel,
            threshold: number(demo(), "threshold"),
            device: &device,
            effort: Effort::seconds(1.0),
            seed: 0,
        },
        quantisers: &quantisers,
        sum: Sum::Kept,
        within: Micros(100_000),
    };
    let answer = quantisation::ask(&asked, &bundled, |_| {}).unwrap();
    quantisers.into_iter().zip(answer.rows).collect()
}

#[test]
fn what_the_chip_can_carry_is_what_feasibility_chooses() {
    let table = candidates();
    let best = Question::best(&table).unwrap().to_string();
    assert_eq!(demo()["chosen"], best.as_str());
    // One question, one answer.
    for to in [best.as_str(), "ternary"] {
        let (_, of) = table.iter().find(|(own, _)| own.to_string() == to).unwrap();
        let Outcome::OnChip(chip) = &of.outcome else {
            panic!("{to} has no program");
        };
        for (domain, likeness) in [("exact", &chip.exact), ("silicon", &chip.silicon)] {
            let shown = row(true, to, domain);
            assert_eq!(Some(number(shown, "kept")), likeness.kept, "{to} {domain}");
            let percent = number(shown, "threshold_equivalent_percent");
            assert_eq!(Some(percent), likeness.threshold_equivalent_percent);
            assert_eq!(number(shown, "words"), chip.words as f64);
        }
    }
}

#[test]
fn every_row_says_how_it_was_judged() {
    let (own, faster) = (rows(true), rows(false));
    assert_eq!((own.len(), faster.len()), (7, 7));
    for row in own.iter().chain(&faster) {
        let [f1, floor, kept] = ["f1", "floor", "kept"].map(|key| number(row, key));
        assert!((kept - (f1 - floor) / (1.0 - floor)).abs() < 1e-12);
        assert_eq!(row["window_us"], 100_000);
        assert!(number(row, "threshold_equivalent_percent") >= 0.0);
        // The chip keeps up with what it is shown.
        assert!(number(row, "fps") <= number(row, "frames_per_s"), "{row}");
    }
    assert_eq!(
        (&own[0]["frames"], &own[0]["fps"]),
        (&72.into(), &10.0.into())
    );
    let (frames, fps) = (number(faster[0], "frames"), number(faster[0], "fps"));
    assert!((frames - 1.0 - 7.1 * fps).abs() < 1e-6);
}

/// The chip is not broken, and the tool is not: without errors a plain DVS is exact but where
/// light saturates, and the kernel in its chosen values nearly, at either rate.
#[test]
fn what_is_without_errors_keeps_all() {
    for own in [true, false] {
        let dvs = |domain: &str| {
            let mut all = rows(own).into_iter();
            all.find(|row| row["cell"] == "plain DVS" && row["domain"] == domain)
                .unwrap()
        };
        // The brightest light, 255, is 127.5 LSB: half of one above the range.
        let exact = number(dvs("exact"), "kept");
        assert!((0.999..=1.0).contains(&exact), "{exact}");
        assert!(number(dvs("silicon"), "kept") > 0.9);
        let chosen = demo()["chosen"].as_str().unwrap();
        assert!(number(row(own, chosen, "exact"), "kept") > 0.95);
        assert!(
            number(row(own, "ternary", "exact"), "kept")
                < number(row(own, chosen, "exact"), "kept")
        );
    }
}

/// Keys that scripts may use stay, of the kernel that the chip can carry.
#[test]
fn the_devices_are_those_of_the_files() {
    let demo = demo();
    let devices = demo["devices"].as_array().unwrap();
    let domains: Vec<_> = devices
        .iter()
        .map(|d| d["domain"].as_str().unwrap())
        .collect();
    assert_eq!(domains, ["exact", "q8.8", "silicon"]);
    for device in devices {
        assert_eq!(device["to"], demo["chosen"]);
        assert_eq!(device["fps"], demo["fps"]);
        assert_eq!(device["frames_per_s"], demo["frames_per_s"]);
    }
    assert_eq!(number(demo, "frames") - 72.0, number(demo, "inserted"));
    let written: Vec<_> = demo["written"].as_array().unwrap().iter().collect();
    assert_eq!(written.len(), 11);
}
