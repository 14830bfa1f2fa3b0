//! What a program loses without an error, and is told of: events in rows that it does not scan, sums
//! beyond the range of a register in the middle of a frame.

mod common;

use std::fs;

use common::{amacrine, good, json, line};
use ndarray::Array3;
use ndarray_npy::write_npy;
use serde_json::Value;
use tempfile::TempDir;

/// What `exec` of a program warns of, as text and as JSON, with a clip of 5x4 pixels that are bright
/// to the right.
fn warned(program: &str, more: &[&str]) -> (String, Value) {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("p.scamp"), program).unwrap();
    let clip = Array3::from_shape_fn((3, 4, 5), |(_, _, x)| 50.0 * x as f64);
    write_npy(folder.path().join("clip.npy"), &clip).unwrap();
    let shown = ["exec", "p.scamp", "--image", "clip.npy", "--fps", "100"];
    let all = [&shown[..], more].concat();
    let ran = amacrine(folder.path(), &all).output().unwrap();
    assert!(ran.status.success(), "{}", line(&ran.stderr));
    let told = json(folder.path(), &[&all[..], &["--json"]].concat());
    (line(&ran.stderr), told)
}

fn abouts(told: &Value) -> Vec<&str> {
    let all = told["warnings"].as_array().unwrap().iter();
    all.map(|it| it["about"].as_str().unwrap()).collect()
}

/// Two frames of 20 set pixels each, of which some rows are scanned.
#[test]
fn events_in_rows_that_are_not_scanned_are_counted_and_told() {
    let set = |scans: &str| format!("init {{ CLR(R5); }}\nframe {{\n SET(R5);\n {scans}\n}}");
    let (text, told) = warned(&set("scamp5_scan_dreg(R5, on, 1, 2);"), &[]);
    assert_eq!(
        (&told["events"], &told["dropped"]["unscanned"]),
        (&20.into(), &20.into())
    );
    assert_eq!(told["dropped"]["no_slot"], 0);
    assert!(
        text.contains("20 of 40 events (50.0 %) are lost in rows that the readout does not scan")
            && text.contains("--readout planes"),
        "{text}"
    );
    assert!(abouts(&told).contains(&"rows"), "{told}");
    // Two scans of one frame are one readout of all rows.
    let both = "scamp5_scan_dreg(R5, on, 0, 1);\n scamp5_scan_dreg(R5, on, 2, 3);";
    let (_, told) = warned(&set(both), &[]);
    assert_eq!(
        (&told["events"], &told["dropped"]["unscanned"]),
        (&40.into(), &0.into())
    );
    assert!(!abouts(&told).contains(&"rows"), "{told}");
}

/// Where nothing comes out, that is said, and why.
#[test]
fn no_event_at_all_is_told_of_rows_too() {
    let row = "init { CLR(R5); }\nframe {\n scamp5_load_point(R5, 0, 0);\n";
    let (text, told) = warned(&format!("{row} scamp5_scan_dreg(R5, on, 2, 3);\n}}"), &[]);
    assert_eq!(
        (&told["events"], &told["dropped"]["unscanned"]),
        (&0.into(), &2.into())
    );
    assert_eq!(abouts(&told), ["no-events", "rows"]);
    assert!(
        text.contains("no event at all in 3 frames: cells fired 2 events in rows that"),
        "{text}"
    );
    // A readout of rows is warned of as one of slots is.
    let silent = "init { CLR(R5); }\nframe { CLR(R5); scamp5_scan_dreg(R5, on, 0, 3); }";
    let (_, told) = warned(silent, &[]);
    assert_eq!(abouts(&told), ["no-events"]);
}

/// Four times the light, and a quarter of that: at the end of the frame nothing tells of it.
const MIDDLE: &str = "get_image(A);\nmov(B, A); add(A, A, B);\nmov(B, A); add(A, A, B);\ndivq(B, A); divq(A, B); res(B);\n";

#[test]
fn a_sum_beyond_the_range_is_told_where_it_happens() {
    for (more, how) in [
        (&[][..], "lie beyond the range of a register, -128 to 127"),
        (&["--domain", "exact"], "lie beyond the range of a register"),
        (
            &["--clip", "on"],
            "lie at the end of its range, -128 to 127",
        ),
        (&["--domain", "silicon"], "lie at the end of its range"),
    ] {
        let (text, told) = warned(MIDDLE, more);
        assert_eq!(abouts(&told), ["saturation"], "{more:?}");
        // 2 x 100 and 2 x 75 in the first sum; a chip's errors may move some off the end.
        let counted = if more.contains(&"silicon") {
            "of 20 values"
        } else {
            "8 of 20 values (40 %)"
        };
        let place = "in NEWS after line 2, `bus(NEWS, A, B)`, of frame 0 (1 frame was looked at word by word)";
        assert!(
            text.contains(counted)
                && text.contains(place)
                && text.contains(how)
                && text.matches("warning: ").count() == 1,
            "{more:?}: {text}"
        );
    }
}

/// Runs are warned of as one run is, in the same words and places, each thing once; what they lost
/// has a mean and a deviation.
#[test]
fn repeated_runs_tell_what_one_run_tells() {
    let set = |scan: &str| format!("init {{ CLR(R5); }}\nframe {{\n SET(R5);\n {scan}\n}}");
    let silent = "init { CLR(R5); }\nframe { CLR(R5); scamp5_scan_dreg(R5, on, 0, 3); }";
    let infinite = "get_image(A);\nrepeat 1100 { mov(B, A); add(A, A, B); }\n".to_owned();
    for (program, about) in [
        (set("scamp5_scan_dreg(R5, on, 1, 2);"), "rows"),
        (set("scamp5_scan_events(R5, on, 5);"), "slots"),
        (silent.to_owned(), "no-events"),
        (MIDDLE.to_owned(), "saturation"),
        (infinite, "saturation"),
    ] {
        let (text, told) = warned(&program, &[]);
        let (of_runs, runs) = warned(&program, &["--repeat", "3"]);
        assert!(abouts(&runs).contains(&about), "{about}: {runs}");
        assert_eq!(runs["warnings"], told["warnings"], "{about}");
        assert_eq!(of_runs, text, "{about}");
        for (reason, lost) in told["dropped"].as_object().unwrap() {
            let of_runs = &runs["dropped"][reason];
            assert_eq!(of_runs["mean"].as_f64(), lost.as_f64(), "{about}, {reason}");
            assert_eq!(of_runs["sd"], 0.0, "{about}, {reason}");
        }
    }
    // Chips that err in other ways say it of the first.
    let (text, runs) = warned(MIDDLE, &["--domain", "silicon", "--repeat", "3"]);
    let (_, first) = warned(MIDDLE, &["--domain", "silicon"]);
    assert_eq!(runs["warnings"], first["warnings"]);
    assert_eq!(text.matches("warning: ").count(), 1, "{text}");
    let folder = TempDir::new().unwrap();
    let program = set("scamp5_scan_events(R5, on, 5);");
    fs::write(folder.path().join("p.scamp"), program).unwrap();
    let scene = "pattern:disc?width=5&height=4&frames=3";
    let runs = ["exec", "p.scamp", "--image", scene, "--repeat", "2"];
    let table = good(folder.path(), &runs);
    assert!(
        table.contains("\ndropped  30.0 a run, sd 0.0000: no slot\n"),
        "{table}"
    );
}

/// What is compared alone keeps its sign, and what is halved as it is summed is never stored.
#[test]
fn sums_that_lose_nothing_are_not_told() {
    for program in [
        "get_image(A);\nmov(B, A); add(C, A, B);\nwhere(C); MOV(R5, FLAG); all();\nres(C);\n",
        "get_image(A);\nmov(B, A);\nbus2(C, D, A, B);\nmov(A, C);\nres(C); res(D);\n",
    ] {
        let (text, told) = warned(program, &["--clip", "on"]);
        assert!(abouts(&told).is_empty(), "{program}: {text}");
    }
}

/// What a run gives does not depend on which frames are looked at: one after the other, nine frames have
/// three that are, and their noise is that of a run which is never looked at.
#[test]
fn who_looks_changes_nothing() {
    let folder = TempDir::new().unwrap();
    let clip = Array3::from_shape_fn((10, 4, 5), |(n, y, x)| {
        ((n * 37 + y * 11 + x * 50) % 256) as f64
    });
    write_npy(folder.path().join("clip.npy"), &clip).unwrap();
    let body = "get_image(B);\nmov(C, B); add(D, B, C);\nsub(E, D, A);\nscamp5_in(F, 5); sub(E, E, F);\nwhere(E); MOV(R5, FLAG); all();\nscamp5_scan_events(R5, on, 100);\nmov(A, D);\n";
    // A host's reading of the frame is one of the things that must not be doubled.
    let steps = format!("init {{ get_image(A); }}\nframe {{\n{body}scamp5_global_sum_16(A);\n}}");
    fs::write(folder.path().join("p.scamp"), steps).unwrap();
    let shown = [
        "exec", "p.scamp", "--image", "clip.npy", "--fps", "100", "--domain", "silicon",
    ];
    let told = json(
        folder.path(),
        &[&shown[..], &["--json", "--events", "looked.csv"]].concat(),
    );
    let mut stepped = amacrine(
        folder.path(),
        &[&shown[..], &["--debug", "--events", "plain.csv"]].concat(),
    );
    let stepped = stepped.write_stdin("continue\nquit\n").output().unwrap();
    assert!(stepped.status.success());
    let [looked, plain] =
        ["looked.csv", "plain.csv"].map(|name| fs::read(folder.path().join(name)).unwrap());
    assert!(looked.len() > 100 && looked == plain);
    let words = told["words"].as_u64().unwrap();
    let frames = told["words_per_frame"].as_u64().unwrap();
    assert!(words > 9 * frames && words < 10 * frames, "{told}");
    assert_eq!(told["readings"].as_array().unwrap().len(), 1);
}
