//! A chip of one's own: what is said of programs and scenes goes by its data, not by SCAMP-5's.

#![cfg(feature = "cli")]

mod common;

use std::{fs, path::Path};

use common::{good, json};
use tempfile::TempDir;

/// A line of `device.toml`.
fn figure(key: &str, value: f64, unit: &str, evidence: &str) -> String {
    format!(
        "{key} = {{ value = {value:?}, unit = \"{unit}\", source = \"test\", evidence = \"{evidence}\" }}\n"
    )
}

/// A chip that extends SCAMP-5 by these lines, in a folder of its name.
fn chip(folder: &Path, name: &str, lines: &str) {
    fs::create_dir(folder.join(name)).unwrap();
    let text = format!("name = \"{name}\"\ntitle = \"{name}\"\nextends = \"scamp5\"\n{lines}");
    fs::write(folder.join(name).join("device.toml"), text).unwrap();
}

/// Chips whose registers hold from `low` to `high` LSB, without headroom, their photodiodes within
/// it.
fn ranged(folder: &Path, name: &str, low: f64, high: f64) {
    let lsb = |key, value| figure(key, value, "LSB", "measured");
    let lines = [
        "[figure.range]\n".to_owned(),
        lsb("low", low),
        lsb("high", high),
        "[figure.error]\n".to_owned(),
        lsb("headroom", 0.0),
        lsb("transfer", 1.0),
        "[figure.light]\n".to_owned(),
        lsb("reset", -high),
    ];
    chip(folder, name, &lines.concat());
}

#[test]
fn what_saturates_goes_by_the_chip_s_range() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    ranged(folder, "narrow", -32.0, 31.0);
    let on = |arguments: &[&str]| good(folder, &[arguments, &["--chip", "narrow"]].concat());
    let whole = on(&[
        "compile",
        "sobel-x",
        "--threshold",
        "40",
        "--objective",
        "exact",
        "--effort",
        "0.1",
    ]);
    assert!(
        whole.contains("nothing saturates for light up to 62 of 255"),
        "{whole}"
    );
    assert!(
        whole.contains("no sum leaves the range for\n//! # light up to 62 of 255"),
        "{whole}"
    );
    // Eight inputs in a sum.
    let filter = ["compile", "sobel-x", "--filter-only", "--effort", "0.1"];
    assert!(on(&filter).contains("inputs within ±3.88 LSB"), "{}", on(&filter));
    let told = json(folder, &[&filter[..], &["--chip", "narrow"]].concat());
    assert_eq!(told["largest_input_lsb"], 31.0 / 8.0);
    fs::write(folder.join("two.scamp"), "bus(B, A);\nbus(C, B);\n").unwrap();
    let asm = on(&["asm", "two.scamp", "--input=0..100"]);
    assert!(asm.contains("line 1 can saturate: B from -100 to 0 LSB"), "{asm}");
    let asm = on(&["asm", "two.scamp", "--input=0..31"]);
    assert!(asm.contains("no store can saturate"), "{asm}");
}

#[test]
fn a_capture_that_saturates_is_named() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let lsb = |key, value| figure(key, value, "LSB", "measured");
    let lines = ["[figure.range]\n", &lsb("low", -32.0), &lsb("high", 31.0)].concat();
    chip(folder, "dark", &lines);
    let asked = ["compile", "csdvs-3", "--threshold", "10", "--objective", "exact"];
    let told = good(folder, &[&asked[..], &["--effort", "0.1", "--chip", "dark"]].concat());
    assert!(!told.contains("nothing saturates"), "{told}");
    assert!(told.contains("can saturate: the capture stores"), "{told}");
}

#[test]
fn a_wide_range_is_used() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    ranged(folder, "wide", -512.0, 511.0);
    let wide = ["--chip", "wide"];
    let filter = ["compile", "sobel-x", "--filter-only", "--input=-60..60", "--effort", "0.1"];
    let told = good(folder, &[&filter[..], &wide].concat());
    assert!(told.contains("nothing saturates"), "{told}");
    fs::write(folder.join("sum.scamp"), "bus(B, A);\nbus(C, A, A);\nbus(D, A);\nbus(E, B, D);\n").unwrap();
    let asm = ["asm", "sum.scamp", "--input=-200..200"];
    let told = good(folder, &[&asm[..], &wide].concat());
    assert!(told.contains("no store can saturate"), "{told}");
}

#[test]
fn stores_clip_at_the_chip_s_range() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    ranged(folder, "narrow", -32.0, 31.0);
    ranged(folder, "wide", -512.0, 511.0);
    fs::write(folder.join("set.scamp"), "bus(B, A);\nbus(C, B);\n").unwrap();
    for (name, domain, least, most) in [
        ("narrow", "exact", -32.0, 31.0),
        ("narrow", "q8.8", -32.0, 31.0),
        ("narrow", "f16", -32.0, 31.0),
        ("wide", "exact", -300.0, 300.0),
        ("wide", "f32", -300.0, 300.0),
    ] {
        let picture = ndarray::arr2(&[[300.0, -300.0]]);
        ndarray_npy::write_npy(folder.join("a.npy"), &picture).unwrap();
        let asked = ["exec", "set.scamp", "--set", "A=a.npy", "--clip", "on"];
        good(
            folder,
            &[&asked[..], &["--chip", name, "--domain", domain, "--dump", "out"]].concat(),
        );
        let b: ndarray::Array2<f64> = ndarray_npy::read_npy(folder.join("out/B.npy")).unwrap();
        assert_eq!(b, ndarray::arr2(&[[least, most]]), "{name} {domain}");
    }
}
