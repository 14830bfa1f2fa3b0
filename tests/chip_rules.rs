//! A chip of one's own: what its data change, what they are refused for, and how well a result is
//! known that is made of them.

#![cfg(feature = "cli")]

mod common;

use std::{fs, path::Path};

use common::{chip, good, json, refused};
use serde_json::Value;
use tempfile::TempDir;

/// A line of `device.toml`.
fn figure(key: &str, value: f64, unit: &str, rest: &str) -> String {
    format!("{key} = {{ value = {value:?}, unit = \"{unit}\", source = \"test\", {rest} }}\n")
}

/// A chip whose row of the bus has these forms, words and evidence.
fn bus(folder: &Path, name: &str, forms: &[&str], words: u64, evidence: &str) {
    chip(folder, name, "");
    let row = format!(
        "[[primitive]]\nname = \"bus\"\nforms = {forms:?}\nequation = \"test\"\nwords = {words}\nclock = \"analog\"\nsource = \"test\"\nevidence = \"{evidence}\"\n"
    );
    fs::write(folder.join(name).join("primitives.toml"), row).unwrap();
}

const ONE: &str = "bus(out y: target, x: source * 0..4)";
const TWO: &str = "bus2(out y: target, out z: target, x: source * 0..2)";

/// Rows beyond the 256th: the shipped scamp5-wide has 512.
#[test]
fn what_a_program_leaves_out_goes_as_far_as_the_array() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let text = "where(A);\nMOV(R5, FLAG);\nall();\nscamp5_global_or(R5);\nscamp5_scan_dreg(R5, buffer);\nscamp5_global_sum_sparse(A);\nscamp5_output_image(R5);\n";
    fs::write(folder.join("p.scamp"), text).unwrap();
    for (chip, side) in [("scamp5", 256), ("scamp5-wide", 512)] {
        let told = json(folder, &["asm", "p.scamp", "--chip", chip]);
        let told = told.to_string();
        let last = side - 1;
        for line in [
            format!("scamp5_global_or(R5, 0, 0, {last}, {last})"),
            format!("scamp5_scan_dreg(R5, buffer, 0, {last})"),
            format!("scamp5_global_sum_sparse(A, 2, 2, {0}, {0})", last - 1),
        ] {
            assert!(told.contains(&line), "no {line} in {told}");
        }
    }
}

/// A `uint8_t` would not reach their rows: there C++ is taken at its word.
#[test]
fn rows_of_larger_arrays_have_more_than_eight_bits() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let text = "int main() { while (1) { vs_frame_loop_control(); scamp5_load_point(R6, 300, -1); scamp5_draw_begin(R5); scamp5_draw_pixel(300, 5); scamp5_draw_end(); } }";
    fs::write(folder.join("p.cpp"), text).unwrap();
    for (chip, row) in [("scamp5", 44), ("scamp5-wide", 300)] {
        let told = json(folder, &["asm", "p.cpp", "--chip", chip]).to_string();
        for line in [
            format!("scamp5_load_point(R6, {row}, 255)"),
            format!("scamp5_draw_pixel({row}, 5)"),
        ] {
            assert!(told.contains(&line), "no {line} in {told}");
        }
        let of_300 = told.contains("C++ passes 44 instead of 300");
        assert_eq!(of_300, chip == "scamp5", "{told}");
    }
}

/// A row of 512 bits takes as long as two of 256, whoever stated the time; and so does its interval.
#[test]
fn a_row_of_bits_takes_as_long_as_it_has_bytes() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    fs::write(
        folder.join("p.scamp"),
        "scamp5_scan_dreg(R5, buffer, 0, 99);\n",
    )
    .unwrap();
    let us = |chip: &str| {
        let told = json(folder, &["asm", "p.scamp", "--chip", chip]);
        told["cost"]["program"]["host_us"].as_f64().unwrap()
    };
    let rest = "evidence = \"quoted\"";
    let px = |columns| figure("width", columns, "px", rest);
    chip(folder, "narrow", &format!("[figure.array]\n{}", px(60.0)));
    for (chip, factor) in [("scamp5", 1.0), ("scamp5-wide", 2.0), ("./narrow", 0.25)] {
        assert_eq!(us(chip), 100.0 * factor, "{chip}");
    }
}

/// Asks `feasibility` of a disc that moves, on a chip.
fn feasibility(folder: &Path, chip: &str, more: &[&str]) -> String {
    let ask = [
        "feasibility",
        "sobel-x",
        "--to",
        "ternary",
        "--candidates",
        "ternary",
        "--threshold",
        "40",
        "--scene",
        "pattern:disc?width=32&height=24&frames=100&speed=60",
        "--within",
        "5ms",
        "--chips",
        "4",
        "--effort",
        "0.1",
        "-o",
        "r.html",
        "--chip",
        chip,
    ];
    good(folder, &[&ask[..], more].concat())
}

fn asked(folder: &Path, chip: &str) -> Value {
    serde_json::from_str(&feasibility(folder, chip, &["--json"])).unwrap()
}

fn headline(told: &Value) -> &str {
    told["verdict"]["headline"].as_str().unwrap()
}

/// A guess that says whether there is room, on both sides of the limit.
#[test]
fn a_verdict_on_room_names_the_guess_that_it_rests_on() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let guess = "evidence = \"guess\"";
    let words = |words, rest| format!("[figure.store]\n{}", figure("words", words, "words", rest));
    chip(folder, "little", &words(20.0, guess));
    chip(folder, "enough", &words(900.0, guess));
    let wide = figure("width", 28.0, "px", guess);
    chip(folder, "slim", &format!("[figure.array]\n{wide}"));
    for (chip, name) in [
        ("little", "store.words"),
        ("enough", "store.words"),
        ("slim", "array.width"),
    ] {
        let told = asked(folder, chip);
        let expected = format!("Not known: it rests on guesses ({name})");
        assert!(
            headline(&told).starts_with(&expected),
            "{chip}: {}",
            headline(&told)
        );
    }
    let quoted = "evidence = \"quoted\"";
    chip(folder, "small", &words(20.0, quoted));
    assert_eq!(headline(&asked(folder, "small")), "Does not fit");
    // An interval beyond what is needed settles it; one that what is needed lies in does not.
    let interval = "evidence = \"guess\", low = 500, high = 900, why = \"test\"";
    chip(folder, "settled", &words(700.0, interval));
    assert!(headline(&asked(folder, "settled")).starts_with("Feasible"));
    let open = "evidence = \"guess\", low = 15, high = 900, why = \"test\"";
    chip(folder, "open", &words(700.0, open));
    let told = asked(folder, "open");
    assert!(
        headline(&told).contains("(store.words)"),
        "{}",
        headline(&told)
    );
}

/// What is counted is drawn in whole numbers, and its draws are chips.
#[test]
fn intervals_of_counts_are_drawn_in_whole_numbers() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let around = |low: f64, high: f64| {
        format!("evidence = \"guess\", low = {low}, high = {high}, why = \"test\"")
    };
    let lines = [
        "[figure.array]\n",
        &figure("height", 300.0, "px", &around(256.0, 512.0)),
        "[figure.store]\n",
        &figure("words", 5000.0, "words", &around(4000.0, 6000.0)),
        "[figure.converter]\n",
        &figure("adc_codes", 128.0, "codes", &around(64.0, 256.0)),
        "[figure.diffusion]\n",
        &figure("parts", 8.0, "1", &around(4.0, 12.0)),
        "[figure.propagation]\n",
        &figure("travel", 128.0, "px", &around(1.0, 256.0)),
    ]
    .concat();
    chip(folder, "counted", &lines);
    let told = asked(folder, "counted");
    assert!(
        headline(&told).starts_with("Feasible"),
        "{}",
        headline(&told)
    );
}

/// The time and the energy of a frame are no better known than the words of its instructions.
#[test]
fn times_are_as_well_known_as_the_words_of_instructions() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    bus(folder, "three", &[ONE, TWO], 3, "guess");
    let clock = [
        "[figure.clock]\n",
        &figure("rate", 10.0, "MHz", "evidence = \"measured\""),
        &figure("launch", 0.0, "us", "evidence = \"measured\""),
        &figure("power", 1.0, "W", "evidence = \"measured\""),
    ]
    .concat();
    let path = folder.join("three/device.toml");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text + &clock).unwrap();
    let compile = ["compile", "csdvs-3", "--threshold", "16", "--effort", "0"];
    let told = json(folder, &[&compile[..], &["--chip", "three"]].concat());
    assert_eq!(told["evidence"]["array_us"], "guess");
    assert_eq!(told["evidence"]["energy_uj"], "guess");
    let told = asked(folder, "three");
    assert!(headline(&told).contains("bus.words"), "{}", headline(&told));
    for name in ["array_us", "power.busy"] {
        let chain = feasibility(folder, "three", &["--explain", name]);
        let line = chain.lines().find(|line| line.contains("bus.words"));
        assert!(line.is_some_and(|line| line.contains("guess")), "{chain}");
    }
    // Of SCAMP-5 the words are quoted, and nothing more is told.
    let chain = feasibility(folder, "scamp5", &["--explain", "array_us"]);
    assert!(!chain.contains(".words"), "{chain}");
}

/// Words of the filter are instruction words; the bound, too.
#[test]
fn the_words_of_a_filter_are_counted_as_the_chip_counts_them() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    bus(folder, "three", &[ONE, TWO], 3, "quoted");
    let filter = ["compile", "sobel-x", "--filter-only", "--effort", "0"];
    let plain = json(folder, &filter);
    let told = json(folder, &[&filter[..], &["--chip", "three"]].concat());
    for pointer in [
        "/words",
        "/filter_words",
        "/snake_words",
        "/bounds/lower",
        "/bounds/upper",
    ] {
        let of = |told: &Value| told.pointer(pointer).unwrap().as_u64().unwrap();
        assert_eq!(of(&told), 3 * of(&plain), "{pointer}");
    }
}

/// The proofs of optimality are of buses of four sources, and of two where the sum is split.
#[test]
fn no_program_is_called_optimal_where_the_bus_takes_more() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    bus(
        folder,
        "six",
        &["bus(out y: target, x: source * 0..6)", TWO],
        1,
        "quoted",
    );
    let split = "bus2(out y: target, out z: target, x: source * 0..3)";
    bus(folder, "split", &[ONE, split], 1, "quoted");
    let plus = ndarray::arr2(&[[0.0, 1.0, 0.0], [1.0, 1.0, 1.0], [0.0, 1.0, 0.0]]);
    ndarray_npy::write_npy(folder.join("k.npy"), &plus).unwrap();
    let filter = ["compile", "k.npy", "--filter-only", "--effort", "0.1"];
    assert!(good(folder, &filter).contains("no program of fewer"));
    for chip in ["six", "split"] {
        let asked = [&filter[..], &["--chip", chip]].concat();
        let told = good(folder, &asked);
        assert!(
            told.contains("whether fewer compute this kernel was not asked (--objective words)"),
            "{told}"
        );
        let asked = [&asked[..], &["--objective", "words"]].concat();
        let told = good(folder, &asked);
        assert!(
            told.contains("whether fewer compute this kernel is not known"),
            "{told}"
        );
        assert_eq!(json(folder, &asked)["bounds"]["is_optimal"], false);
    }
}

/// A form says what its word writes.
#[test]
fn a_form_whose_out_is_not_what_it_writes_is_refused() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let four = "bus4(out y: target, out z: target, out w: target, out v: target, x: source)";
    bus(folder, "four", &[ONE, TWO, four], 1, "quoted");
    bus(
        folder,
        "silent",
        &["bus(y: target, x: source * 0..4)", TWO],
        1,
        "quoted",
    );
    fs::write(folder.join("p.scamp"), "bus(B, A);\n").unwrap();
    for (chip, what) in [
        ("four", "`bus4` writes 1 register, and `z` is an `out`"),
        ("silent", "`bus` writes `y`, which is no `out`"),
    ] {
        let place = format!("{chip}/primitives.toml:3");
        refused(folder, &["asm", "p.scamp", "--chip", chip], &[what, &place]);
    }
}

/// Registers go by what the chip calls them, and by which it has.
#[test]
fn whole_programs_are_made_of_the_registers_that_there_are() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let names = [
        "M", "N1", "E1", "S1", "W1", "P", "Q0", "Q1", "Q2", "Q3", "Q4", "Q5", "Q6",
    ];
    let roles = "[registers.roles]\nmask = \"M\"\npropagated = \"P\"\nnorth = \"N1\"\neast = \"E1\"\nsouth = \"S1\"\nwest = \"W1\"\n";
    chip(
        folder,
        "renamed",
        &format!("[registers]\ndigital = {names:?}\n{roles}"),
    );
    let few = ["R0", "R1", "R2", "R3", "R4", "R12"];
    chip(folder, "few", &format!("[registers]\ndigital = {few:?}\n"));
    // Its own macros, as those of SCAMP-5 name NEWS.
    let analogue = "[registers]\nanalogue = [\"A\", \"B\", \"C\", \"D\", \"E\", \"F\", \"MESH\"]\nnews = \"MESH\"\n";
    chip(folder, "mesh", analogue);
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("isa/scamp5");
    let macros = fs::read_to_string(shipped.join("macros.scamp")).unwrap();
    let macros = macros.replace("NEWS", "MESH").replace("DMESH", "DNEWS");
    fs::write(folder.join("mesh/macros.scamp"), macros).unwrap();
    let asked = [
        "compile",
        "csdvs-3",
        "--threshold",
        "16",
        "--effort",
        "0",
        "--chip",
    ];
    for (chip, memory, parts) in [
        (
            "renamed",
            "analogue",
            ["MOV(Q0, FLAG);", "scamp5_scan_events(Q1, off"],
        ),
        ("renamed", "shared", ["OR(Q6, Q0, Q1);", "WHERE(Q6);"]),
        (
            "few",
            "analogue",
            ["MOV(R1, FLAG);", "scamp5_scan_events(R2, off"],
        ),
        ("few", "shared", ["OR(R3, R1, R2);", "WHERE(R3);"]),
        ("mesh", "analogue", ["bus(MESH);", "MOV(R5, FLAG);"]),
        ("mesh", "shared", ["bus(MESH, PIX);", "WHERE(R11);"]),
    ] {
        let text = good(folder, &[&asked[..], &[chip, "--memory", memory]].concat());
        for part in parts {
            assert!(text.contains(part), "no {part} on {chip}: {text}");
        }
    }
    // As high as one bit of memory needs.
    let asked = ["compile", "csdvs-3", "--threshold", "130", "--effort", "0"];
    let bits = ["--memory", "bits:1", "--readout", "counts", "--chip", "few"];
    let told = good(folder, &[asked, bits].concat());
    assert!(told.contains("MUX(R4, R1, R3, R4)"), "{told}");
}

/// More kinds than pairs of one-bit registers are read out in turn, with the light held meanwhile.
#[test]
fn kinds_are_read_out_as_many_at_a_time_as_there_are_registers() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let few = ["R0", "R1", "R2", "R3", "R4", "R12"];
    chip(folder, "few", &format!("[registers]\ndigital = {few:?}\n"));
    let asked = [
        "compile",
        "csdvs-3",
        "sobel-x",
        "--threshold",
        "16",
        "--effort",
        "0",
    ];
    let more = ["--memory", "shared", "--chip", "few"];
    let text = good(folder, &[&asked[..], &more].concat());
    assert!(text.contains("the light, through all readouts"), "{text}");
    let first = text.find("scamp5_scan_events(R1, on0").unwrap();
    assert!(first < text.find("// kind 1").unwrap(), "{text}");
}

/// One name is one chip.
#[test]
fn a_chip_is_called_as_its_folder_and_as_no_shipped_one() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    fs::write(
        folder.join("p.scamp"),
        "//! chip = \"scamp5-wide\"\n\nbus(B, A);\n",
    )
    .unwrap();
    let asm = |chip: &'static str| ["asm", "p.scamp", "--chip", chip];
    good(folder, &asm("scamp5-wide"));
    chip(folder, "scamp5-wide", "");
    let place = "device.toml:1";
    let shipped = "`scamp5-wide` is the name of a shipped chip";
    refused(folder, &asm("./scamp5-wide"), &[shipped, place]);
    let both = "`scamp5-wide` is a shipped chip, and scamp5-wide is another one of that name";
    refused(folder, &asm("scamp5-wide"), &[both]);
    // Named by the program, it may lie beside that.
    fs::create_dir(folder.join("elsewhere")).unwrap();
    refused(folder, &["asm", "p.scamp"], &[both]);
    chip(folder, "mine", "");
    fs::rename(folder.join("mine"), folder.join("yours")).unwrap();
    let other = "the chip is called `mine`, and its folder `yours`";
    refused(folder, &asm("yours"), &[other, place]);
    fs::rename(folder.join("yours"), folder.join("mine")).unwrap();
    good(folder, &asm("mine"));
    // The sources of a shipped chip are that chip.
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("isa/scamp5");
    good(
        folder,
        &["asm", "p.scamp", "--chip", sources.to_str().unwrap()],
    );
}

/// What would make readouts free, and ranges without 0.
#[test]
fn rows_and_ranges_that_leave_something_out_are_refused() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let call = "call = { value = 1, unit = \"us\", source = \"test\", evidence = \"guess\" }\n";
    let form = "scamp5_scan_events(d: dreg, buffer: word, slots: int[1..4000] = 1000, h_dir: int[0..1] = 0, v_dir: int[0..1] = 0)";
    let row = format!(
        "[[host]]\nname = \"scan_events\"\nforms = [\"{form}\"]\nmeaning = \"test\"\n{call}"
    );
    chip(folder, "free", &row);
    let lsb = |key, value| figure(key, value, "LSB", "evidence = \"quoted\"");
    let range = |low, high| format!("[figure.range]\n{}{}", lsb("low", low), lsb("high", high));
    chip(folder, "beyond", &range(10.0, 127.0));
    chip(folder, "swapped", &range(127.0, -128.0));
    fs::write(folder.join("p.scamp"), "bus(B, A);\n").unwrap();
    for (chip, words) in [
        (
            "free",
            ["`scan_events` has no `item`", "free/device.toml:5"],
        ),
        ("beyond", ["0 is not in the range", "beyond/device.toml:5"]),
        (
            "swapped",
            ["is not below range.high", "swapped/device.toml:5"],
        ),
    ] {
        refused(folder, &["asm", "p.scamp", "--chip", chip], &words);
    }
    let asked = [
        "exec",
        "p.scamp",
        "--image",
        "pattern:disc?width=8&height=8",
    ];
    let set = ["--set", "range.low=10"];
    refused(
        folder,
        &[&asked[..], &set].concat(),
        &["range.low cannot be 10", "the range holds 0"],
    );
}

/// A macro of the chip's own that is not what its name says.
#[test]
fn a_capture_without_light_is_named() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    chip(folder, "blind", "");
    let text = "/// y := what is left of the light\nmacro get_image(out y: areg) {\n    rpix();\n    bus(y, PIX);\n}\n";
    fs::write(folder.join("blind/macros.scamp"), text).unwrap();
    let named = "the macro `get_image` of blind does not leave the light in its register";
    let asked = [
        "csdvs-3",
        "--threshold",
        "16",
        "--effort",
        "0",
        "--chip",
        "blind",
    ];
    refused(folder, &[&["compile"], &asked[..]].concat(), &[named]);
    let scene = [
        "--to",
        "ternary",
        "--scene",
        "pattern:disc?width=40&height=32&frames=4",
    ];
    refused(
        folder,
        &[&["waterfall"], &asked[..], &scene].concat(),
        &[named],
    );
}

/// Numbers that the help names are explained on every chip.
#[test]
fn figures_without_an_interval_are_explained() {
    let folder = TempDir::new().unwrap();
    let folder = folder.path();
    let noise = figure("noise", 0.01, "LSB", "evidence = \"measured\"");
    chip(folder, "still", &format!("[figure.error]\n{noise}"));
    for name in ["error.noise", "range.low"] {
        let chain = feasibility(folder, "still", &["--explain", name]);
        assert!(chain.starts_with(name), "{chain}");
    }
    let chain = feasibility(folder, "still", &["--explain", "noise.temporal"]);
    assert!(chain.contains("error.noise"), "{chain}");
}
