//! `run --kernel`, `--threshold` and `--rate` are what a sensor file with other kernels and
//! thresholds is. Against: such files, and the number of events that comes of them.

mod common;

use std::fs;

use common::{good, json, refused};
use ndarray::Array3;

const SCENE: &str = "pattern:noise?width=40&height=30&frames=12&fps=50&speed=40";

fn sensor(kernel: &str, threshold: &str) -> String {
    format!(
        "response = {{ linear = 255 }}\nmemory = \"filtered-step\"\n[[channel]]\nkernel = {kernel}\nthreshold = {{ on = {threshold}, off = {threshold} }}\n"
    )
}

#[test]
fn other_kernels_and_thresholds_are_another_file() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("a.toml"), sensor("[[1]]", "0.3")).unwrap();
    fs::write(folder.join("b.toml"), sensor("\"sobel-x\"", "0.7")).unwrap();
    let run = |sensor: &str, more: &[&str]| {
        let asked = ["run", "--scene", SCENE, "--sensor", sensor, "--events"];
        good(folder, &[&asked[..], &["e.npy"], more].concat());
        fs::read(folder.join("e.npy")).unwrap()
    };
    let changed = run("a.toml", &["--kernel", "sobel-x", "--threshold", "0.7"]);
    assert!(changed.len() > 2000);
    assert_eq!(changed, run("b.toml", &[]));
    let kernels = Array3::from_shape_fn((2, 3, 3), |(k, y, x)| (k + y) as f64 - x as f64);
    ndarray_npy::write_npy(folder.join("k.npy"), &kernels).unwrap();
    let asked = [
        "run", "--scene", SCENE, "--sensor", "a.toml", "--kernel", "k.npy",
    ];
    let two = json(folder, &asked);
    assert_eq!(two["channels"], 2, "{two}");
    // Kinds are called as `design` calls them: by the file or the name of each kernel.
    let names = |said: &serde_json::Value| -> Vec<String> {
        let kinds = said["kinds"].as_array().unwrap();
        kinds
            .iter()
            .map(|kind| kind["name"].as_str().unwrap().to_owned())
            .collect()
    };
    assert_eq!(names(&two), ["k.npy[0]", "k.npy[1]"]);
    let three = [&asked[..], &["--kernel", "sobel-x"]].concat();
    assert_eq!(
        names(&json(folder, &three)),
        ["k.npy[0]", "k.npy[1]", "sobel-x"]
    );
    // Where the file has names, every verb tells them.
    good(folder, &[&three[..], &["-o", "three.npy"]].concat());
    let said = json(folder, &["packets", "three.npy"]);
    assert_eq!(names(&said), ["k.npy[0]", "k.npy[1]", "sobel-x"]);
    let table = good(folder, &["packets", "three.npy"]);
    assert!(table.contains("\n2 sobel-x "), "{table}");
    let compare = ["compare", "three.npy", "three.npy"];
    let table = good(folder, &compare);
    assert!(table.contains("\n  channel 2 sobel-x ON "), "{table}");
    let said = json(folder, &compare);
    assert_eq!(said["reference"]["names"][2], "sobel-x");
}

#[test]
fn a_rate_is_reached() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let asked = ["run", "--scene", SCENE, "--sensor", "rgc-4", "--rate", "12"];
    let said = json(folder, &asked);
    let (pixels, seconds) = (40.0 * 30.0, 11.0 / 50.0);
    let rate = said["events"].as_f64().unwrap() / pixels / seconds;
    assert!((rate / 12.0 - 1.0).abs() < 0.05, "{rate}: {said}");
    assert_eq!(said["rate"]["asked"], 12.0);
    assert!(said["rate"]["factor"].as_f64().unwrap() > 0.0);
    assert_eq!(said["rate"]["thresholds"].as_array().unwrap().len(), 4);
    assert_eq!(said["rate"]["off"].as_array().unwrap().len(), 4);
    assert_eq!(said["rate"]["sigma"].as_array().unwrap().len(), 4);
    assert!(good(folder, &asked).contains("asked for: threshold"));
    // Of the sensor that runs, whose thresholds are scaled with their spread.
    let plain = [
        "run",
        "--scene",
        SCENE,
        "--sensor",
        "rgc",
        "--rate",
        "8",
        "--without",
        "mismatch",
    ];
    let without = json(folder, &plain);
    let with = json(folder, &plain[..7]);
    assert_ne!(without["rate"]["thresholds"], with["rate"]["thresholds"]);
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let factor = number(&with["rate"]["factor"]);
    assert!((number(&with["rate"]["sigma"][0]) / factor - 0.03).abs() < 1e-12);
    assert_eq!(without["rate"]["sigma"][0], 0.0);
    let two = sensor("[[1]]", "0.3").replace("off = 0.3", "off = 0.15");
    fs::write(folder.join("two.toml"), two).unwrap();
    let two = [
        "run", "--scene", SCENE, "--sensor", "two.toml", "--rate", "8",
    ];
    let two = &json(folder, &two)["rate"];
    let half = number(&two["off"][0]) / number(&two["thresholds"][0]);
    assert!((half - 0.5).abs() < 1e-12, "{two}");
    let rate = without["events"].as_f64().unwrap() / pixels / seconds;
    let told = good(folder, &plain);
    let told = told.lines().next().unwrap();
    assert!(
        told.ends_with(&format!("gives {rate:.4}")),
        "{rate}: {told}"
    );
    assert!(good(folder, &plain[..7]).contains("(sigma too)"));
    // With its unit, and the events by the short name of their option.
    let unit = [
        "run", "--scene", SCENE, "--sensor", "rgc-4", "--rate", "12/px/s",
    ];
    assert_eq!(json(folder, &unit), said);
    good(folder, &[&asked[..], &["--events", "long.npy"]].concat());
    good(folder, &[&unit[..], &["-o", "short.npy"]].concat());
    let [long, short] = ["long.npy", "short.npy"].map(|name| fs::read(folder.join(name)).unwrap());
    assert_eq!(long, short);
}

/// ON and OFF each have their threshold; the file's sigma stays and is told, `--sigma` takes its
/// place, and what `--rate` finds is found again by the options that it prints.
/// All cells that change do so by the same amount: they fire together, or not at all.
#[test]
fn a_rate_that_no_threshold_gives_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let light = Array3::from_shape_fn((20, 30, 40), |(n, y, x)| {
        let lit = n % 2 == 1 && (10..20).contains(&y) && (10..30).contains(&x);
        if lit { 200_u8 } else { 40 }
    });
    ndarray_npy::write_npy(folder.join("blink.npy"), &light).unwrap();
    let text = sensor("[[1]]", "0.3").replace("filtered-step", "filtered-snap");
    fs::write(folder.join("a.toml"), text).unwrap();
    let rate = |asked: &str| {
        let arguments = [
            "run",
            "--scene",
            "blink.npy",
            "--fps",
            "30",
            "--sensor",
            "a.toml",
        ];
        let said = json(folder, &[&arguments[..], &["--rate", asked]].concat());
        let all = said["warnings"].as_array().unwrap().clone();
        let told = all.iter().any(|warning| warning["about"] == "rate");
        (said["rate"]["in_f64"].as_f64().unwrap(), told)
    };
    // A sixth of the cells in each of 30 intervals a second.
    let (found, told) = rate("2");
    assert!((found - 5.0).abs() < 1e-9 && told, "{found}");
    let (found, told) = rate("4.9");
    assert!((found - 5.0).abs() < 1e-9 && !told, "{found}");
}

/// No other option puts back what is left out, and a share of any size is one short number.
#[test]
fn what_is_left_out_stays_out() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("a.toml"), sensor("[[1]]", "0.3")).unwrap();
    let events = |more: &[&str]| {
        let asked = ["run", "--scene", SCENE, "--sensor", "a.toml", "-o", "e.npy"];
        good(folder, &[&asked[..], more].concat());
        fs::read(folder.join("e.npy")).unwrap()
    };
    let plain = events(&[]);
    assert_ne!(plain, events(&["--sigma", "0.09"]));
    let without = ["--without", "mismatch"];
    assert_eq!(
        plain,
        events(&[&["--sigma", "0.09"], &without[..]].concat())
    );
    let twice = [
        "run",
        "--scene",
        SCENE,
        "--sensor",
        "dvs-v2e",
        "--without",
        "leak,leak",
    ];
    let said = good(folder, &twice);
    assert!(said.contains("(1 channel, f64, without leak)"), "{said}");
    let tiny = [
        "run",
        "--scene",
        SCENE,
        "--sensor",
        "rgc",
        "--threshold",
        "1e-300",
    ];
    let said = common::amacrine(folder, &tiny).output().unwrap();
    let said = common::line(&said.stdout);
    assert!(said.contains("3.0e300 % of the threshold"), "{said}");
}

#[test]
fn thresholds_for_on_and_off_and_their_spread() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let file = |on: f64, off: f64, sigma: f64| {
        let text = sensor("\"dvs\"", "1");
        let own = format!("threshold = {{ on = {on}, off = {off}, sigma = {sigma} }}");
        text.replace("threshold = { on = 1, off = 1 }", &own)
    };
    let events = |sensor: &str, more: &[&str]| {
        let asked = ["run", "--scene", SCENE, "--sensor", sensor, "-o", "e.npy"];
        let said = good(folder, &[&asked[..], more].concat());
        (said, fs::read(folder.join("e.npy")).unwrap())
    };
    fs::write(folder.join("a.toml"), file(0.2, 0.2, 0.02)).unwrap();
    fs::write(folder.join("b.toml"), file(0.3, 0.1, 0.02)).unwrap();
    fs::write(folder.join("c.toml"), file(0.3, 0.1, 0.01)).unwrap();
    let (said, both) = events("a.toml", &["--threshold", "0.3,0.1"]);
    assert_eq!(both, events("b.toml", &[]).1);
    assert!(
        said.starts_with("sigma    0.02, the file's, 20 % of the"),
        "{said}"
    );
    let (said, narrow) = events("a.toml", &["--threshold", "0.3,0.1", "--sigma", "0.01"]);
    assert_eq!(narrow, events("c.toml", &[]).1);
    assert!(!said.starts_with("sigma") && narrow != both, "{said}");
    let (said, _) = events("a.toml", &["--threshold", "0.3", "--without", "mismatch"]);
    assert!(!said.starts_with("sigma"), "{said}");
    // What a rate finds.
    let (said, rated) = events("b.toml", &["--rate", "9"]);
    let (_, options) = said.split_once("the same without a search: ").unwrap();
    let options: Vec<&str> = options.lines().next().unwrap().split(' ').collect();
    assert_eq!(options.len(), 4, "{options:?}");
    assert_eq!(events("b.toml", &options).1, rated);
    // A spread that decides.
    let run = [
        "run",
        "--scene",
        SCENE,
        "--sensor",
        "a.toml",
        "--threshold",
        "0.05",
    ];
    let about = |sigma: &str| {
        let said = json(folder, &[&run[..], &["--sigma", sigma]].concat());
        let all = said["warnings"].as_array().unwrap().iter();
        all.filter(|one| one["about"] == "spread").count()
    };
    assert_eq!((about("0.016"), about("0.017")), (0, 1));
    for wrong in ["-1", "NaN", "inf"] {
        let sigma = format!("--sigma={wrong}");
        refused(
            folder,
            &[&run[..], &[&*sigma]].concat(),
            &["is no spread", "0 or more"],
        );
    }
    let odd = [&run[..5], &["--threshold", "0.1,two"]].concat();
    refused(folder, &odd, &["two for ON,OFF, such as"]);
    let odd = [&run[..5], &["--threshold", "0.1,0"]].concat();
    refused(folder, &odd, &["--threshold 0", "above 0"]);
}

#[test]
fn what_cannot_be_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let run = ["run", "--scene", SCENE, "--sensor", "dvs"];
    let with = |more: &[&'static str]| [&run[..], more].concat();
    refused(
        folder,
        &with(&["--rate", "1e9"]),
        &["--rate", "4096 times as high"],
    );
    let noisy = ["run", "--scene", SCENE, "--sensor", "dvs-noisy"];
    let low = [&noisy[..], &["--rate", "0.5"]].concat();
    let noise = ["noise alone makes", "--without noise-events,leak"];
    let message = refused(folder, &low, &noise);
    assert!(!message.contains("--scale"), "{message}");
    good(
        folder,
        &[&low[..], &["--without", "noise-events,leak"]].concat(),
    );
    refused(folder, &with(&["--rate", "2/s"]), &["2/px/s"]);
    refused(
        folder,
        &with(&["--threshold", "0"]),
        &["--threshold 0", "above 0"],
    );
    refused(
        folder,
        &with(&["--kernel", "nothing"]),
        &["cannot read the kernel nothing"],
    );
    let mesh = [
        "run",
        "--scene",
        SCENE,
        "--sensor",
        "csdvs-mesh",
        "--kernel",
        "dvs",
    ];
    refused(folder, &mesh, &["has a mesh or a pattern"]);
}

#[test]
fn a_report_is_asked_for_by_rate() {
    let folder = tempfile::tempdir().unwrap();
    let scene = "pattern:noise?width=48&height=40&frames=10&fps=100&speed=60";
    let asked = [
        "feasibility",
        "--kernel",
        "csdvs-3",
        "--rate",
        "9",
        "--scene",
        scene,
        "--chips",
        "1",
        "--candidates",
        "ternary",
        "--to",
        "ternary",
        "--effort",
        "0.05",
    ];
    let said = json(folder.path(), &asked);
    let rate = said["streams"]["float"]["per_pixel_s"].as_f64().unwrap();
    assert!((rate / 9.0 - 1.0).abs() < 0.05, "{rate}");
    assert!(
        said["command"].as_str().unwrap().contains("--rate 9"),
        "{}",
        said["command"]
    );
}
