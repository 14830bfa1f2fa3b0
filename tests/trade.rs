//! Proves that a trade's front is what nothing beats, that its commands run the models that it
//! names, that its limits hold on the whole scene, and that what is left out by hand is left out.
//! Against: the definition of domination, the verbs `run` and `exec`, the whole scene.
#![cfg(feature = "cli")]

mod common;

use std::{fs, path::Path};

use common::{good, json, refused, refused_untouched};
use ndarray::Array3;
use serde_json::Value;

const SCENE: &str = "pattern:noise?width=96&height=80&frames=14&fps=100&speed=40";

fn sensor(folder: &Path) -> String {
    let text =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("sensors/dvs-v2e.toml"));
    fs::write(folder.join("sensor.toml"), text.unwrap()).unwrap();
    "sensor.toml".to_owned()
}

const PROGRAM: &str = "//! channels = 1\ninit { get_image(A); neg(C, A); }\nframe { get_image(A); scamp5_in(D, -12); bus(NEWS); bus(B, NEWS, A, C); where(B, D); MOV(R6, FLAG); all(); where(A, C, D); MOV(R5, FLAG); WHERE(R5, R6); neg(C, A); all(); scamp5_scan_events(R5, on, 4000); scamp5_scan_events(R6, off, 4000); }\n";

fn points(trade: &Value) -> &Vec<Value> {
    trade["points"].as_array().unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// Words of a command without its program; patterns stand in quotes.
fn words(command: &str) -> Vec<String> {
    let mut words = Vec::new();
    for (n, part) in command.split('\'').enumerate() {
        if n % 2 == 1 {
            words.push(part.to_owned());
        } else {
            words.extend(part.split_whitespace().map(str::to_owned));
        }
    }
    assert_eq!(words.remove(0), "amacrine");
    words
}

/// The front and its knee, by their definitions: seconds whose ranges overlap tell nothing apart.
#[track_caller]
fn check_front(trade: &Value) {
    let at = |point: &Value| {
        let planning = number(&point["planning_seconds"]);
        let error = point["error"].as_f64()?;
        let [least, most] = [0, 1].map(|end| planning + number(&point["seconds_range"][end]));
        let seconds = number(&point["seconds"]) + planning;
        assert!((least..=most).contains(&seconds), "{point}");
        Some((seconds, error, [least, most]))
    };
    let placed: Vec<_> = { points(trade).iter() }
        .filter_map(|point| Some((point, at(point)?)))
        .collect();
    assert!(placed.len() > 4);
    let full = placed
        .iter()
        .find(|(point, _)| point["name"] == "the full model");
    let (_, (whole, ..)) = full.expect("the full model");
    let overlap = |a: &[f64; 2], b: &[f64; 2]| a[0] <= b[1] && b[0] <= a[1];
    let mut front = Vec::new();
    for (point, (x, y, range)) in &placed {
        let beaten = placed.iter().any(|(_, (a, b, other))| {
            a <= x && b <= y && (b < y || (a < x && !overlap(range, other)))
        });
        assert_eq!(point["on_front"], !beaten, "{point}");
        if !beaten {
            front.push((*point, (*x, *y, *range)));
        }
    }
    let least = { front.iter() }.fold(f64::INFINITY, |least, (_, (x, ..))| least.min(*x));
    let away = |(x, y): (f64, f64)| ((x - least) / whole).hypot(y);
    let nearest = { front.iter() }
        .min_by(|(_, a), (_, b)| away((a.0, a.1)).total_cmp(&away((b.0, b.1))))
        .unwrap();
    let knee = { front.iter() }.find(|(point, _)| point["is_knee"] == true);
    assert_eq!(
        trade["knee"],
        knee.map_or(Value::Null, |(point, _)| point["name"].clone())
    );
    let is_full = |point: &Value| point["name"] == "the full model";
    let (point, (x, error, range)) = knee.expect("a front has a knee");
    assert_eq!(trade["no_knee"], Value::Null);
    // What is hardly faster than the full model is none, unless it has beaten that: then it changes
    // nothing.
    if *whole < 1.05 * x && !is_full(point) {
        assert!(*error == 0.0 && !front.iter().any(|(point, _)| is_full(point)));
        return;
    }
    if is_full(point) {
        return;
    }
    let (_, (_, own, of_nearest)) = nearest;
    assert!(error <= own && overlap(range, of_nearest), "{point}");
    let better = front
        .iter()
        .find(|(_, (_, other, range))| other < error && overlap(range, of_nearest));
    assert!(better.is_none(), "{better:?}");
}

#[test]
fn a_sensor_s_trade_has_its_front_and_commands_that_run() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let sensor = sensor(at);
    let ask = [
        "trade",
        "--scene",
        SCENE,
        "--sensor",
        &sensor,
        "--sample",
        "30%",
        "--verify",
        "-o",
        "trade.svg",
    ];
    let trade = json(at, &ask);
    check_front(&trade);
    assert_eq!(trade["times"], "whole");
    assert_eq!(trade["f1_within_us"], trade["within_us"]);
    assert_eq!(trade["kept_within_us"], 100_000);
    // Chance scores the same of all, which are measured against one model.
    for known in ["sampled", "whole"] {
        let floors = points(&trade)
            .iter()
            .filter_map(|it| it[known]["floor"].as_f64());
        let floors: Vec<f64> = floors.collect();
        assert!(floors.len() > 3 && floors[0] > 0.0, "{known}: {floors:?}");
        assert!(
            floors.iter().all(|floor| *floor == floors[0]),
            "{known}: {floors:?}"
        );
    }
    // Limits hold together but for one case in twenty; these are always the same.
    for point in points(&trade) {
        let limit = point["sampled"]["change"]["limit"].as_f64();
        let share = number(&point["whole"]["change"]["share"]);
        assert!(limit.is_none_or(|limit| share <= limit), "{point}");
    }
    let names: Vec<&str> = { points(&trade).iter() }
        .map(|point| point["name"].as_str().unwrap())
        .collect();
    for name in [
        "the full model",
        "f32",
        "q8.8",
        "f64, without dead time",
        "f64, without bandwidth",
    ] {
        assert!(names.contains(&name), "{name} in {names:?}");
    }
    assert!(
        names.iter().any(|name| name.matches(',').count() > 1),
        "{names:?}"
    );
    // Each command runs the model: as many events as the whole scene had.
    let full = events(at, find(&trade, "the full model"));
    for name in [
        "f32",
        "f64, without leak",
        "f64, without threshold mismatch",
    ] {
        let point = find(&trade, name);
        let change = &point["whole"]["change"];
        assert_eq!(number(&change["events"]), full);
        let off = (events(at, point) - full).abs();
        assert!(off <= number(&change["changes"]), "{name}: {off}");
        if name != "f32" {
            assert!(off > 0.0, "{name} changes the number of events");
        }
    }
    let svg = fs::read_to_string(at.join("trade.svg")).unwrap();
    for words in [
        "events that change, %",
        "knee: ",
        "bf16",
        "amacrine run",
        "changed",
        "squares: measured",
    ] {
        assert!(svg.contains(words), "{words}");
    }
    let text = good(
        at,
        &[&ask[..7], &["--runs", "1000", "--formats", "f32"]].concat(),
    );
    for words in [
        "the full model",
        "stretched from these tiles",
        "shared by 1000 runs",
        "knee     ",
        "amacrine run --scene",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    assert!(!text.contains("bf16"));
}

#[track_caller]
fn find<'a>(trade: &'a Value, name: &str) -> &'a Value {
    let found = points(trade).iter().find(|point| point["name"] == name);
    found.unwrap_or_else(|| panic!("no {name}"))
}

/// Events of the run that a point's command starts.
#[track_caller]
fn events(at: &Path, point: &Value) -> f64 {
    let words = words(point["command"].as_str().unwrap());
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    number(&json(at, &words)["events"])
}

#[test]
fn a_program_s_trade_has_domains_errors_and_schedules() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("dvs.scamp"), PROGRAM).unwrap();
    let scene = "pattern:disc?width=64&height=64&frames=12&fps=100&speed=200&low=20&high=220";
    let trade = json(
        at,
        &[
            "trade",
            "--scene",
            scene,
            "--program",
            "dvs.scamp",
            "--sample",
            "40%",
            "--runs",
            "100",
        ],
    );
    check_front(&trade);
    let plain = find(&trade, "silicon, plain");
    assert_eq!(number(&plain["error"]), 0.0);
    assert!(plain["free"].is_string());
    for name in [
        "exact",
        "q8.8",
        "silicon without mismatch",
        "silicon without temporal noise",
    ] {
        find(&trade, name);
    }
    let full = events(at, find(&trade, "the full model"));
    let mismatch = find(&trade, "silicon without mismatch");
    assert!(
        mismatch["command"]
            .as_str()
            .unwrap()
            .contains("--without mismatch")
    );
    assert_ne!(events(at, mismatch), full);
    assert_eq!(events(at, plain), full);
}

#[test]
fn what_has_no_tiles_is_run_whole() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let mesh = Path::new(env!("CARGO_MANIFEST_DIR")).join("sensors/csdvs-mesh.toml");
    let scene = "pattern:disc?width=24&height=20&frames=6&radius=6";
    let ask = [
        "trade",
        "--scene",
        scene,
        "--sensor",
        mesh.to_str().unwrap(),
        "--formats",
        "f32,bf16",
    ];
    let trade = json(at, &ask);
    assert_eq!(trade["times"], "whole");
    assert!(
        trade["no_tiles"]
            .as_str()
            .unwrap()
            .contains("resistor sheet")
    );
    assert!(good(at, &ask).contains("run on the whole scene, since there is no sample"));
}

/// A rule needs no tiles, so that they are no part of the price of what it allows.
#[test]
fn what_a_rule_allows_costs_no_tiles() {
    let folder = tempfile::tempdir().unwrap();
    let more = ["--sensor", "csdvs", "--upsample", "0.2"];
    let trade = json(
        folder.path(),
        &[&["trade", "--scene", SCENE][..], &more].concat(),
    );
    let (free, measured): (Vec<_>, Vec<_>) = { points(&trade).iter() }
        .filter(|point| point["planning_seconds"].is_number())
        .partition(|point| point["free"].is_string());
    assert!(!free.is_empty());
    assert!(
        free.iter()
            .all(|point| number(&point["planning_seconds"]) == 0.0)
    );
    assert!(
        measured
            .iter()
            .any(|point| number(&point["planning_seconds"]) > 0.0)
    );
}

#[test]
fn wrong_questions_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let sensor = sensor(at);
    fs::write(at.join("dvs.scamp"), PROGRAM).unwrap();
    fs::write(at.join("bare.scamp"), "add(A, B, C);\n").unwrap();
    let cases: [(&[&str], &[&str]); 9] = [
        (&[], &["--sensor", "--program"]),
        (
            &["--sensor", &sensor, "--program", "dvs.scamp"],
            &["cannot be used with"],
        ),
        (
            &["--sensor", &sensor, "--domain", "exact"],
            &["cannot be used with", "--domain"],
        ),
        (
            &["--sensor", &sensor, "--sample", "0%"],
            &["no part of a sensor"],
        ),
        (&["--sensor", &sensor, "--formats", "f31"], &["f31"]),
        (&["--sensor", &sensor, "-o", "trade.txt"], &[".svg or .png"]),
        (
            &["--program", "dvs.scamp", "--domain", "f31"],
            &["unknown domain `f31`"],
        ),
        (&["--program", "bare.scamp"], &["bare statements"]),
        (
            &["--program", "dvs.scamp", "--upsample", "0.1"],
            &["--upsample"],
        ),
    ];
    for (arguments, words) in cases {
        let all = [&["trade", "--scene", SCENE], arguments].concat();
        refused_untouched(at, &all, words);
    }
    let short = "pattern:disc?width=24&height=20&frames=2&radius=6";
    refused(
        at,
        &["trade", "--scene", short, "--sensor", &sensor],
        &["at least three frames"],
    );
}

#[test]
fn what_is_left_out_by_hand_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let sensor = sensor(at);
    let run = |sensor: &str, more: &[&str]| {
        let all = ["run", "--scene", SCENE, "--sensor", sensor];
        let mut json = json(at, &[&all[..], more].concat());
        json["sensor"].take();
        json
    };
    let text = fs::read_to_string(at.join("sensor.toml")).unwrap();
    let leak = text
        .lines()
        .find(|line| line.trim_start().starts_with("leak-hz"));
    let without = text.replace(leak.expect("a leak"), "leak-hz = 0");
    fs::write(at.join("without.toml"), without).unwrap();
    let left_out = run(&sensor, &["--without", "leak"]);
    assert_eq!(left_out, run("without.toml", &[]));
    assert_ne!(left_out["events"], run(&sensor, &[])["events"]);
    let said = good(
        at,
        &[
            "run",
            "--scene",
            SCENE,
            "--sensor",
            &sensor,
            "--without",
            "leak",
        ],
    );
    assert!(said.contains("without leak"), "{said}");
    // The noise of a resistor mesh stands outside of [noise].
    for (name, noise) in [("mesh.toml", "noise = 0.1, "), ("quiet.toml", "")] {
        let text = format!(
            "response = {{ lin-log = {{ knee = 20 }} }}\nmemory = \"filtered-step\"\n[[channel]]\nmesh = {{ lambda = 2, {noise}tau-us = 500 }}\nthreshold = {{ on = 0.2, off = 0.2 }}\n"
        );
        fs::write(at.join(name), text).unwrap();
    }
    let quiet = run("quiet.toml", &[]);
    assert_eq!(run("mesh.toml", &["--without", "mesh-noise"]), quiet);
    assert_ne!(run("mesh.toml", &[])["events"], quiet["events"]);
    let trade = ["trade", "--scene", SCENE, "--sensor", "mesh.toml"];
    let said = good(at, &trade);
    assert!(said.contains("f64, without mesh noise"), "{said}");
    let base = ["run", "--scene", SCENE, "--sensor", &sensor, "--without"];
    for (what, words) in [
        ("laek", ["no effect of a sensor", "did you mean `leak`?"]),
        ("jitter", ["no jitter to leave out", "it has"]),
    ] {
        refused(at, &[&base[..], &[what]].concat(), &words);
    }
    refused(
        at,
        &[&base[..], &["leak", "--fidelity", "auto"]].concat(),
        &["it chooses what is left out", "leave --without out"],
    );
    fs::write(at.join("dvs.scamp"), PROGRAM).unwrap();
    let exec = [
        "exec",
        "dvs.scamp",
        "--image",
        SCENE,
        "--frames",
        "6",
        "--without",
    ];
    refused(
        at,
        &[&exec[..], &["noise"]].concat(),
        &["whose cells do not err", "--domain silicon"],
    );
    refused(
        at,
        &[&exec[..], &["nose", "--domain", "silicon"]].concat(),
        &["did you mean `noise`?"],
    );
    let said = good(
        at,
        &[&exec[..], &["noise,mismatch", "--domain", "silicon"]].concat(),
    );
    assert!(
        said.contains("silicon, without temporal noise, mismatch"),
        "{said}"
    );
}

/// A clip as short as the window of `kept`: all events are partners of all others.
#[test]
fn what_kept_does_not_say_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let scene = "pattern:bar?width=64&height=48&frames=20";
    let said = good(
        folder.path(),
        &["trade", "--scene", scene, "--sensor", "dvs-v2e"],
    );
    assert!(said.contains("kept says nothing here: within"), "{said}");
    assert!(said.contains("chance alone scores 1.000 of 1"), "{said}");
}

/// A number may overflow in a tile that is not in the sample.
#[test]
fn a_model_that_stops_on_the_whole_scene_is_told_beside_the_others() {
    let at = tempfile::tempdir().unwrap();
    let at = at.path();
    fs::write(
        at.join("bright.toml"),
        "response = { linear = 0.001 }\nmemory = \"filtered-step\"\n[[channel]]\nkernel = \"dvs\"\nthreshold = { on = 20000, off = 20000 }\n",
    )
    .unwrap();
    // 200 is 200,000 after the response, more than f16 holds; it stays, and is seldom drawn.
    let light = Array3::from_shape_fn((12, 64, 64), |(t, y, x)| match (y, x) {
        (40..44, 36..40) => 200u8,
        _ => ((t * 37 + y * 11 + x * 29 + t * y * x) % 50) as u8,
    });
    ndarray_npy::write_npy(at.join("s.npy"), &light).unwrap();
    let arguments = [
        "trade",
        "--scene",
        "s.npy",
        "--fps",
        "100",
        "--sensor",
        "bright.toml",
        "--verify",
    ];
    let trade = json(at, &arguments);
    let why = find(&trade, "f16")["why"].as_str().unwrap();
    assert!(why.contains("x = 36, y = 40 of channel 0"), "{why}");
    assert!(why.contains("largest number of the format f16"), "{why}");
    assert!(find(&trade, "f16")["error"].is_null());
    assert_eq!(find(&trade, "f32")["error"], 0.0);
}

/// Light that moves less than any threshold: what is not known says why, everywhere in the same
/// words, and a sample of every tile is no sample.
#[test]
fn no_limit_has_its_reason() {
    let at = tempfile::tempdir().unwrap();
    let at = at.path();
    let light = Array3::from_shape_fn((8, 180, 240), |(t, y, x)| 250 + ((t * (y + x)) % 2) as u8);
    ndarray_npy::write_npy(at.join("s.npy"), &light).unwrap();
    let ask = [
        "trade",
        "--scene",
        "s.npy",
        "--fps",
        "25",
        "--sensor",
        "centre-off",
        "--formats",
        "f32,f16",
    ];
    let why = "too few events to say anything";
    let trade = json(at, &ask);
    let f32 = find(&trade, "f32");
    assert!(f32["error"].is_null());
    assert_eq!(f32["no_limit"], why);
    assert_eq!(f32["sampled"]["change"]["no_limit"], why);
    let text = good(at, &[&ask[..], &["-o", "trade.svg"]].concat());
    let told = format!("{why}: take a larger --sample");
    assert_eq!(text.matches(&told).count(), 2, "{text}");
    assert!(
        text.contains("no event there: take a larger --sample, lower the thresholds"),
        "{text}"
    );
    let svg = fs::read_to_string(at.join("trade.svg")).unwrap();
    assert!(svg.contains("not drawn: `") && svg.contains(&told));
    let all = [&ask[..], &["--sample", "100%"]].concat();
    let trade = json(at, &all);
    for point in points(&trade) {
        assert_eq!(number(&point["error"]), 0.0, "{point}");
        assert!(point["no_limit"].is_null());
    }
    let moving = good(at, &all);
    let still = Array3::<u8>::from_elem((8, 180, 240), 250);
    ndarray_npy::write_npy(at.join("s.npy"), &still).unwrap();
    for text in [moving, good(at, &ask)] {
        let told = "so nothing that is left out changes anything: lower the thresholds";
        assert!(text.contains(told) && !text.contains("larger"), "{text}");
    }
}

/// Events that find no slot are counted in every frame, and every limit is of the whole scene.
#[test]
fn slots_that_are_full_are_counted_on_the_whole_scene() {
    let at = tempfile::tempdir().unwrap();
    let at = at.path();
    fs::write(at.join("few.scamp"), PROGRAM.replace("4000", "50")).unwrap();
    // Only the last frame has more than fifty events.
    let light = Array3::from_shape_fn((14, 64, 64), |(t, y, x)| {
        let spot = (4..8).contains(&y) && x / 4 == t;
        60 + 90 * u8::from(spot) + 60 * u8::from(t == 13 && y >= 40)
    });
    ndarray_npy::write_npy(at.join("s.npy"), &light).unwrap();
    let scene = ["s.npy", "--fps", "100"];
    let ask = ["--program", "few.scamp", "--formats", "f32", "--scene"];
    let ask = [&["trade"], &ask[..], &scene].concat();
    let trade = json(at, &ask);
    let run = ["exec", "few.scamp", "--domain", "silicon", "--image"];
    let run = json(at, &[&run[..], &scene].concat());
    let lost = run["dropped"]["no_slot"].as_u64().unwrap();
    assert!(lost > 1000, "{lost}");
    assert_eq!(trade["without_slot"], lost);
    assert!(trade["tiles"].is_null());
    let all = lost + run["events"].as_u64().unwrap();
    for point in points(&trade) {
        assert!(
            point["error"].is_number() && point["no_limit"].is_null(),
            "{point}"
        );
        assert_eq!(point["error"], point["whole"]["change"]["share"]);
    }
    let text = good(at, &ask);
    for words in [
        format!("slots of the readout are full: {lost} of the {all} events"),
        "no sample: the readout has fewer slots than the array has pixels".to_owned(),
    ] {
        assert!(text.contains(&words), "{words}: {text}");
    }
    assert!(!text.contains("larger --sample"), "{text}");
}
