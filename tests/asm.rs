//! Proves what `asm` and `disasm` show: words that read back as the same words, what a what-if
//! chip changes, and one message for a program that cannot be read, whichever verb reads it.

mod common;

use std::{fs, path::Path};

use common::{amacrine, good, json, refused};
use tempfile::TempDir;

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn stdout(arguments: &[&str]) -> String {
    good(here(), arguments)
}

/// The message as it is printed.
fn stderr(arguments: &[&str]) -> String {
    let output = amacrine(here(), arguments)
        .assert()
        .code(2)
        .get_output()
        .clone();
    assert!(output.stdout.is_empty());
    String::from_utf8(output.stderr).unwrap()
}

fn programs() -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("programs");
    let folders = fs::read_dir(root).unwrap().map(|f| f.unwrap().path());
    let files = folders.flat_map(|f| fs::read_dir(f).unwrap());
    files
        .map(|f| f.unwrap().path().display().to_string())
        .collect()
}

fn kept(folder: &TempDir, name: &str, text: &str) -> String {
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    path.display().to_string()
}

/// Without its chip the text would be of other registers.
#[test]
fn what_is_disassembled_keeps_its_chip() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("w.scamp").display().to_string();
    let line = "compile csdvs-3 --to int-4 --threshold 20 --chip scamp5-wide --memory shared --effort 0.01 -o";
    let ask: Vec<&str> = line.split(' ').chain([path.as_str()]).collect();
    stdout(&ask);
    let words = stdout(&["disasm", &path]);
    assert!(words.starts_with("//! chip = \"scamp5-wide\"\n"), "{words}");
    let again = kept(&folder, "words.scamp", &words);
    assert_eq!(stdout(&["disasm", &again]), words);
    let moved = kept(&folder, "plain.scamp", "mov(A, B);\n");
    let words = stdout(&["disasm", &moved, "--chip", "scamp5-wide"]);
    assert!(words.starts_with("//! chip = "), "{words}");
}

#[test]
fn what_is_disassembled_reads_back_as_the_same_words() {
    let folder = tempfile::tempdir().unwrap();
    for program in programs() {
        let words = stdout(&["disasm", &program]);
        assert_eq!(words, stdout(&["asm", &program, "--disasm"]));
        let again = kept(&folder, "words.scamp", &words);
        assert_eq!(stdout(&["disasm", &again]), words, "{program}");
        let said = amacrine(here(), &["asm", &again]).output().unwrap();
        let said = String::from_utf8(said.stderr).unwrap();
        // Of what a macro makes in two words nothing is to be mended.
        assert!(!said.contains("read and written in one word"), "{said}");
    }
}

#[test]
fn a_program_that_cannot_be_read_has_one_message() {
    let of = |verb: &str, file: &str| stderr(&[verb, file]);
    let missing = of("asm", "none.scamp");
    assert!(
        missing.contains("cannot read none.scamp") && missing.contains("amacrine list programs")
    );
    for verb in ["exec", "disasm"] {
        assert_eq!(of(verb, "none.scamp"), missing);
    }
    let folder = tempfile::tempdir().unwrap();
    // The byte order mark of an editor takes no column.
    let marked = kept(&folder, "m.scamp", "\u{feff}add(A B);\n");
    let marked = of("asm", &marked);
    assert_eq!(marked.matches(":1:7").count(), 2, "{marked}");
    let wrong = kept(&folder, "p.scamp", "mov(A B);\nadd(A, Q, C);\n");
    let both = of("asm", &wrong);
    assert!(
        both.contains("1:7") && both.contains("unknown name `Q`"),
        "{both}"
    );
    for verb in ["exec", "disasm"] {
        assert_eq!(
            of(verb, &wrong),
            both,
            "all mistakes at once, from {verb} too"
        );
    }
}

#[test]
fn a_what_if_chip_shows_what_it_changes() {
    let text = stdout(&[
        "asm",
        "programs/convolve/sobel.scamp",
        "--chip",
        "scamp5-wide",
    ]);
    for line in [
        "against scamp5",
        "more registers: G H I J K L",
        "array.height: 512 px instead of 256",
        "store.words: 4096 words instead of 1024",
        "the program costs the same",
    ] {
        assert!(text.contains(line), "{line:?} in {text}");
    }
    assert!(!stdout(&["asm", "programs/convolve/sobel.scamp"]).contains("against"));

    let folder = tempfile::tempdir().unwrap();
    let chip = folder.path().join("slow");
    fs::create_dir(&chip).unwrap();
    fs::write(
        chip.join("device.toml"),
        "name = \"slow\"\ntitle = \"slow\"\nextends = \"scamp5-wide\"\n[figure.clock]\n\
         rate = { value = 5, unit = \"MHz\", source = \"what if\", evidence = \"guess\" }\n\
         [figure.error]\n\
         gain_mismatch = { value = 0.001, unit = \"1\", source = \"what if\", evidence = \"guess\" }\n",
    )
    .unwrap();
    fs::write(
        chip.join("macros.scamp"),
        "/// y := x\nmacro mov(out y: areg, x: source) {\n    nop();\n    bus(NEWS, x);\n    bus(y, NEWS);\n}\n\
         /// y := 3 x\nmacro three(out y: areg, x: areg) {\n    mov(y, x);\n    nop();\n}\n",
    )
    .unwrap();
    let chip = chip.display().to_string();
    let program = kept(&folder, "p.scamp", "mov(A, B);");
    let text = stdout(&["asm", &program, "--chip", &chip]);
    for line in [
        "against scamp5-wide",
        "clock.rate: 5 MHz instead of 10",
        "error.gain_mismatch: 0.001 instead of 0.0034",
        "another body: mov(y, x)",
        "new macro: three(y, x)",
        "3 words instead of 2, 0.6 us instead of 0.2, 3 words stored instead of 2",
    ] {
        assert!(text.contains(line), "{line:?} in {text}");
    }
    let json = stdout(&["asm", &program, "--chip", &chip, "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["changes"]["base"], "scamp5-wide");
    assert_eq!(json["changes"]["cost"]["words"], 3);
    assert_eq!(json["changes"]["base_cost"]["words"], 2);
    // What needs the new registers does not run on the old chip, and this is said.
    let program = kept(&folder, "g.scamp", "mov(G, A);");
    let text = stdout(&["asm", &program, "--chip", "scamp5-wide"]);
    assert!(
        text.contains("does not run there: ") && text.contains("unknown name `G`"),
        "{text}"
    );
}

/// What is below `computes`.
fn proof(arguments: &[&str]) -> Vec<String> {
    let text = stdout(arguments);
    let (_, below) = text
        .split_once("\ncomputes\n")
        .unwrap_or_else(|| panic!("{text}"));
    below.lines().map(str::to_owned).collect()
}

#[test]
fn the_kernel_of_any_program_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let text = "sub(B, A, C);\nmovx(D, B, east);\nadd(D, B, D);\ndivq(E, D);\nscamp5_in(F, 3);\nabs(C, A);\n";
    for (name, text) in [
        ("p.scamp", text.to_owned()),
        (
            "p.cpp",
            format!(
                "int main() {{\n scamp5_kernel_begin();\n{}scamp5_kernel_end();\n}}\n",
                text.replace(
                    "scamp5_in(F, 3);",
                    "scamp5_kernel_end(); scamp5_in(F, 3); scamp5_kernel_begin();"
                )
            ),
        ),
    ] {
        let file = kept(&folder, name, &text);
        let lines = proof(&["asm", &file]);
        let expected = [
            "  B    = A",
            "       - C",
            "  C    no linear map: line ",
            "  D    = A under",
            "         0 1 1",
            "       + C under",
            "          0 -1 -1",
            "  E    = 1/2 A under",
            "         0 1 1",
            "       + 1/2 C under",
            "          0 -1 -1",
            "  F    = 3 LSB",
        ];
        for (line, expected) in lines.iter().zip(expected) {
            assert!(line.starts_with(expected), "{line:?}, not {expected:?}");
        }
        let said = json(here(), &["asm", &file, "--json"]);
        assert_eq!(
            said["proof"]["registers"][0]["computes"]["inputs"][1]["input"],
            "C"
        );
        assert_eq!(
            said["proof"]["registers"][3]["computes"]["inputs"][0]["scale"],
            0.5
        );
        assert!(said["proof"]["registers"][1]["not_linear"]["line"].as_u64() >= Some(6));
    }
}

/// A count makes an analogue register of bits, and of nothing else.
#[test]
fn a_count_spoils_one_register_alone() {
    let folder = tempfile::tempdir().unwrap();
    let text = "get_image(A);\nmovx(C, A, east);\nwhere(A);\nMOV(R5, FLAG);\nall();\nscamp5_global_count(R5, B);\n";
    let file = kept(&folder, "count.scamp", text);
    let said = json(here(), &["asm", &file, "--input", "0..255"]);
    let registers = said["proof"]["registers"].as_array().unwrap();
    let of = |name: &str| registers.iter().find(|it| it["register"] == name);
    // What the count made of its bits is no result.
    assert!(of("B").is_none(), "{said}");
    for (name, kernel) in [
        ("A", serde_json::json!([[1.0]])),
        ("C", serde_json::json!([[0.0, 0.0, 1.0]])),
    ] {
        let computes = &of(name).unwrap()["computes"]["inputs"][0];
        assert_eq!(
            (&computes["kernel"], &computes["scale"]),
            (&kernel, &0.5.into())
        );
    }
}

/// A threshold in `[computes]` is that of events since the cell's last event.
#[test]
fn what_fires_and_is_remembered_is_held_to_the_threshold() {
    let folder = tempfile::tempdir().unwrap();
    let refuse = |name: &str, text: String, words: &[&str]| {
        let file = kept(&folder, name, &text);
        refused(here(), &["asm", &file], words);
    };
    let remembers = "WHERE(R5, R6); mov(F, A); all();";
    let events_of = |threshold: &str, first: &str, frame: &str, then: &str| {
        format!(
            "//! channels = 1\n//! [computes]\n//! kernel = [[0, 1, -1]]\n//! scale = 0.5\n//! threshold = \"{threshold}\"\n\
             const level = 5;\nconst slots = 2000;\ninit {{ get_image(A); movx(B, A, east); {first} mov(F, A); }}\n\
             frame {{ get_image(A); movx(B, A, east); sub(A, A, B); sub(B, A, F); scamp5_in(E, -level); {frame}\n\
             MOV(R5, FLAG); all(); neg(C, B); where(C, E); MOV(R6, FLAG); all(); {then}\n\
             scamp5_scan_events(R5, on, slots); scamp5_scan_events(R6, off, slots); }}\n"
        )
    };
    let events =
        |threshold: &str, first: &str, frame: &str| events_of(threshold, first, frame, remembers);
    let fires = "where(B, E);";
    let file = kept(
        &folder,
        "fires.scamp",
        &events("level", "sub(A, A, B);", fires),
    );
    stdout(&["asm", &file]);
    let false_ones = [
        ("nosuch", "sub(A, A, B);", fires, "which is no constant"),
        ("slots", "sub(A, A, B);", fires, "the program fires"),
        (
            "level",
            "mov(A, B);",
            fires,
            "the drive is compared with 5 LSB",
        ),
        (
            "level",
            "sub(A, A, B);",
            "where(A, E);",
            "the drive is compared with 5 LSB",
        ),
    ];
    for (threshold, first, frame, why) in false_ones {
        let text = events(threshold, first, frame);
        refuse("events.scamp", text, &["[computes]", why]);
    }
    // A memory that keeps the first drive, that only ON renews, or that every frame does.
    for then in ["", "WHERE(R5); mov(F, A); all();", "mov(F, A);"] {
        let text = events_of("level", "sub(A, A, B);", fires, then);
        refuse(
            "memory.scamp",
            text,
            &["[computes] is false", "its memory is not what"],
        );
    }
}

/// Neither few slots, nor a wide kernel, nor a sign that never fires hides a wrong threshold.
#[test]
fn a_threshold_is_held_to_whatever_the_readout() {
    let folder = tempfile::tempdir().unwrap();
    let program = |level: f64, frame: &str, scans: &str| {
        format!(
            "//! channels = 1\n//! [computes]\n//! kernel = [[0, 1, -1]]\n//! scale = 0.5\n//! threshold = \"level\"\n\
             const level = 5;\nconst slots = 10;\ninit {{ get_image(A); movx(B, A, east); sub(A, A, B); mov(F, A); }}\n\
             frame {{ get_image(A); movx(B, A, east); sub(A, A, B); sub(B, A, F); scamp5_in(E, -{level}); where(B, E);\n\
             MOV(R5, FLAG); all(); neg(C, B); where(C, E); MOV(R6, FLAG); all(); {frame}\n\
             WHERE(R5, R6); mov(F, A); all(); {scans} }}\n"
        )
    };
    let scans = "scamp5_scan_events(R5, on, slots); scamp5_scan_events(R6, off, slots);";
    let kept = |name: &str, text: &str| kept(&folder, name, text);
    stdout(&["asm", &kept("good.scamp", &program(5.0, "", scans))]);
    let twice = format!("{scans} scamp5_scan_events(R5, on, slots);");
    let false_ones = [
        (program(5.5, "", scans), "LSB"),
        (program(5.0, "CLR(R6);", scans), "does not fire"),
        (program(5.0, "", &twice), "fires more than once"),
    ];
    for (text, why) in &false_ones {
        let file = kept("false.scamp", text);
        refused(here(), &["asm", &file], &["[computes] is false", why]);
    }
    let weights = format!("{}0.5", "0, ".repeat(28));
    let wide = |level: &str| {
        let moved = "movx(B, A, east); mov(A, B);".repeat(14);
        let fires = "MOV(R5, FLAG); all(); neg(C, B); where(C, E); MOV(R6, FLAG); all();";
        format!(
            "//! channels = 1\n//! [computes]\n//! kernel = [[{weights}]]\n//! scale = 1\n//! threshold = \"level\"\n\
             const level = 5;\nconst slots = 10;\ninit {{ get_image(A); {moved} mov(F, A); }}\n\
             frame {{ get_image(A); {moved} sub(B, A, F); scamp5_in(E, -{level}); where(B, E);\n\
             {fires} WHERE(R5, R6); mov(F, A); all(); {scans} }}\n"
        )
    };
    stdout(&["asm", &kept("wide.scamp", &wide("level"))]);
    let file = kept("wide.scamp", &wide("10"));
    refused(here(), &["asm", &file], &["[computes] is false", "LSB"]);
}

/// A memory of few bits is what `compile` says that it is.
#[test]
fn a_memory_of_levels_is_true_within_half_a_level() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("bits.scamp").display().to_string();
    let compiled = [
        "compile",
        "sobel-x",
        "--threshold",
        "100",
        "--memory",
        "bits:4",
        "--effort",
        "0.1",
        "-o",
        &out,
    ];
    stdout(&compiled);
    stdout(&["asm", &out]);
    let text = fs::read_to_string(&out).unwrap();
    assert!(text.contains("//! step = "), "{text}");
    let high = text.replace("const threshold = ", "const threshold = 9");
    let file = kept(&folder, "high.scamp", &high.replace("-threshold", "-6.25"));
    refused(here(), &["asm", &file], &["[computes] is false"]);
}

/// No light beyond that of pictures is shown to a memory in steps, which has levels for no more; what
/// its constants do is held to high thresholds all the same.
#[test]
fn a_memory_of_levels_is_true_for_high_thresholds() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("bits.scamp").display().to_string();
    for (kernel, threshold) in [
        ("dvs", "60"),
        ("dvs", "80"),
        ("dvs", "220"),
        ("csdvs-3", "120"),
        ("sobel-x", "400"),
        ("sobel-x", "700"),
        ("binary-vertical", "300"),
        ("laplacian", "500"),
    ] {
        for memory in ["bits:2", "bits:3", "bits:4"] {
            let compile = [
                "compile",
                kernel,
                "--threshold",
                threshold,
                "--memory",
                memory,
            ];
            stdout(&[&compile[..], &["--effort", "0.02", "-o", &out]].concat());
            let said = json(here(), &["asm", &out, "--json"]);
            let threshold = &said["proof"]["stated_threshold"];
            let signs = ["on", "off"].map(|sign| threshold[sign].as_str().unwrap());
            assert_eq!(signs, ["held"; 2], "{kernel} {threshold} {memory}");
            let text = fs::read_to_string(&out).unwrap();
            // The first level of the memory, at a quarter.
            let (head, tail) = text.split_once("scamp5_in(E, -").unwrap();
            let (level, rest) = tail.split_once(')').unwrap();
            let level = level.parse::<f64>().unwrap() / 4.0;
            let false_one = format!("{head}scamp5_in(E, -{level}){rest}");
            let file = kept(&folder, "false.scamp", &false_one);
            refused(here(), &["asm", &file], &["[computes] is false"]);
        }
    }
}

/// What is said to be held is what was looked at: a sign that is not read out was not.
#[test]
fn what_was_held_of_a_threshold_is_told() {
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let out = path("both.scamp");
    let compile = |more: &[&str]| {
        let compile = ["compile", "dvs", "--threshold", "20", "--effort", "0.02"];
        stdout(&[&compile[..], more].concat())
    };
    compile(&["-o", &out]);
    let said = |file: &str| {
        let output = amacrine(here(), &["asm", file]).output().unwrap();
        assert!(output.status.success());
        let warned = common::line(&output.stderr);
        (proof(&["asm", file])[1].clone(), warned)
    };
    let fires = "fire where it says on 4 random pictures";
    let (line, warned) = said(&out);
    assert_eq!(
        line,
        format!("  its threshold of 5 LSB: ON and OFF {fires}")
    );
    assert!(!warned.contains("warning"), "{warned}");
    let text = fs::read_to_string(&out).unwrap();
    let without = |statement: &str, text: &str| {
        assert!(text.contains(statement), "{text}");
        text.replace(statement, "")
    };
    let on = without("scamp5_scan_events(R6, off, slots);", &text);
    let none = without("scamp5_scan_events(R5, on, slots);", &on);
    let (line, warned) = said(&kept(&folder, "on.scamp", &on));
    assert_eq!(
        line,
        format!(
            "  its threshold of 5 LSB: ON {fires}; OFF not read out as events, and so not held"
        )
    );
    assert!(
        warned.contains("its OFF events are not read out"),
        "{warned}"
    );
    let (line, warned) = said(&kept(&folder, "none.scamp", &none));
    assert!(
        line.ends_with("5 LSB: ON and OFF not read out as events, and so not held"),
        "{line}"
    );
    assert!(
        warned.contains("its ON and OFF events are not read out"),
        "{warned}"
    );
    // A summary is read on purpose.
    let boxes = path("boxes.scamp");
    compile(&["--readout", "box", "-o", &boxes]);
    let (line, warned) = said(&boxes);
    assert!(
        line.contains("not held") && !warned.contains("warning"),
        "{warned}"
    );
}

/// The words that stand below a program are those that it has, on its own chip.
#[test]
fn a_false_foot_is_told() {
    let folder = TempDir::new().unwrap();
    let program = |init: u64, frame: u64| {
        let text = format!(
            "init {{\n    mov(A, B);\n}}\n\nframe {{\n    mov(C, A);\n    mov(D, A);\n}}\n\n//= [words]\n//= init = {init}\n//= frame = {frame}\n"
        );
        kept(&folder, "p.scamp", &text)
    };
    let said = |arguments: &[&str]| {
        let output = amacrine(here(), arguments).output().unwrap();
        assert!(output.status.success());
        common::line(&output.stderr)
    };
    assert_eq!(said(&["asm", &program(2, 4)]), "");
    let warned = said(&["asm", &program(2, 3)]);
    assert!(
        warned
            .contains("`frame = 3` stands below it, and its frame has 4 words; write `frame = 4`"),
        "{warned}"
    );
    assert!(!warned.contains("init"), "{warned}");
    let both = said(&["asm", &program(1, 5)]);
    assert!(
        both.contains("`init = 1`") && both.contains("`frame = 5`"),
        "{both}"
    );
    // What it is on another chip is not what is written below it.
    assert_eq!(said(&["asm", &program(2, 3), "--chip", "scamp5-wide"]), "");
}

#[test]
fn what_is_stated_is_proved_or_refused_with_what_is_so() {
    let lines = proof(&["asm", "programs/convolve/sobel.scamp"]);
    assert_eq!(
        lines[0],
        "  the kernel that its [computes] says: its words were read back as linear forms"
    );
    let folder = tempfile::tempdir().unwrap();
    let head = |kernel: &str, more: &str| {
        format!("//! [computes]\n//! kernel = {kernel}\n//! scale = 0.5\n{more}\n")
    };
    let body = "get_image(A);\nmovx(B, A, east);\nsub(C, A, B);\nabs(D, C);\n";
    let refuse = |name: &str, text: String, words: &[&str]| {
        let file = kept(&folder, name, &text);
        refused(here(), &["asm", &file], words);
        refused(here(), &["asm", &file, "--json"], words);
    };
    let register = |name: &str| format!("//! register = \"{name}\"");
    let good_head = head("[[0, 1, -1]]", &register("C"));
    stdout(&["asm", &kept(&folder, "good.scamp", &(good_head + body))]);
    refuse(
        "turned.scamp",
        head("[[-1, 1, 0]]", &register("C")) + body,
        &[
            "[computes] is false",
            "under [[-1, 1, 0]]",
            "computes [[0, 1, -1]]",
            "turned.scamp",
        ],
    );
    refuse(
        "nonlinear.scamp",
        head("[[1]]", &register("D")) + body,
        &["no linear map", "line 8"],
    );
    refuse(
        "none.scamp",
        head("[[1]]", &register("Q")) + body,
        &["register Q"],
    );
    refuse(
        "memory.scamp",
        head("[[1]]", &register("E")) + "get_image(A);\nsub(E, A, F);\n",
        &["depends on what F held"],
    );
    // The same of vendor C++.
    let cpp = "int main() {\n while (1) {\n vs_frame_loop_control();\n scamp5_kernel_begin();\n get_image(A);\n scamp5_kernel_end();\n }\n}\n";
    stdout(&[
        "asm",
        &kept(&folder, "good.cpp", &(head("[[1]]", "") + cpp)),
    ]);
    refuse("bad.cpp", head("[[2]]", "") + cpp, &["computes [[1]]"]);
    // Reaching too far to be read back, it is seen by its response to an impulse.
    let far = "get_image(A);\nrepeat 300 {\n movx(B, A, east);\n movx(A, B, west);\n}\nmovx(C, A, east);\n";
    let file = kept(
        &folder,
        "far.scamp",
        &(head("[[0, 0, 1]]", &register("C")) + far),
    );
    assert!(proof(&["asm", &file])[0].contains("its [computes] says"));
    // What only bright light shows to be no linear map.
    let bent = far.replace(
        "movx(C, A, east);",
        "scamp5_in(B, -50); where(A, B); mov(A, B); all(); movx(C, A, east);",
    );
    refuse(
        "far-bent.scamp",
        head("[[0, 0, 1]]", &register("C")) + &bent,
        &["no linear map", "under random light"],
    );
    refuse(
        "far-bad.scamp",
        head("[[1, 0, 0]]", &register("C")) + far,
        &["computes [[0, 0, 1]]"],
    );
}

#[test]
fn ranges_and_what_survives_follow_from_the_input() {
    let folder = tempfile::tempdir().unwrap();
    // Two stores cancel what one leaves: an offset, which does not count.
    let file = kept(
        &folder,
        "p.scamp",
        "mov(B, A);\nbus(C, A);\nmov(E, A);\nadd(D, A, B, E);\nwhere(A);\nMOV(R5, FLAG);\nall();\n",
    );
    let at =
        |input: &str| json(here(), &["asm", &file, "--json", "--input", input])["proof"].clone();
    let small = at("-20..20");
    let registers = small["registers"].as_array().unwrap();
    let of = |name: &str| registers.iter().find(|it| it["register"] == name).unwrap();
    assert_eq!(of("B")["range_lsb"], serde_json::json!([-20.0, 20.0]));
    assert_eq!(small["saturations"], serde_json::json!([]));
    assert_eq!(small["input_is_light"], false);
    let number = |it: &serde_json::Value, key: &str| it[key].as_f64().unwrap();
    assert!(number(of("B"), "correlation") > 0.999);
    assert!(number(of("C"), "correlation") < -0.999 || number(of("C"), "correlation") > 0.999);
    assert!(number(of("B"), "offset_lsb").abs() < 1.0, "{small}");
    assert!(
        (number(of("C"), "offset_lsb") - 20.0).abs() < 1.0,
        "{small}"
    );
    assert!(number(of("B"), "noise_lsb") > 0.05 && number(of("B"), "noise_lsb") < 1.0);
    assert!(number(of("R5"), "same") > 0.97);
    // Of one LSB less survives.
    let tiny = at("-0.2..0.2");
    assert!(number(&tiny["registers"][0], "correlation") < 0.9, "{tiny}");
    // Three times 100 is more than a register holds.
    let large = at("-100..100");
    assert!(!large["saturations"].as_array().unwrap().is_empty());
    // The same seed, the same numbers.
    assert_eq!(at("-20..20"), small);
    refused(here(), &["asm", &file, "--input", "3"], &["is not LO..HI"]);
    refused(here(), &["asm", &file, "--seed", "3"], &["--input"]);
}

/// Counts of one are in the singular.
#[test]
fn one_word_is_no_words() {
    let folder = TempDir::new().unwrap();
    let program = kept(&folder, "one.scamp", "nop();\n");
    let said = stdout(&["asm", &program]);
    for told in ["1 word   ", "1 word of 1024"] {
        assert!(said.contains(told), "{said}");
    }
}

/// Operands that a macro's own words overwrite before they are read: the words are what they are,
/// and it is said. What reads first and writes then has no warning.
#[test]
fn operands_that_are_lost_on_the_way_are_told() {
    let folder = TempDir::new().unwrap();
    let warned = |text: &str| {
        let file = kept(&folder, "p.scamp", text);
        let output = amacrine(here(), &["asm", &file]).output().unwrap();
        assert!(output.status.success(), "{text}: {output:?}");
        common::line(&output.stderr)
    };
    for (text, words) in [
        (
            "XORX(R5, R6, R5);",
            "`XORX` reads its y after it has written R5, which is l too",
        ),
        (
            "XOR(R5, R5, R6);",
            "reads its x after it has written R5, which is l too",
        ),
        (
            "sub(A, B, XE);",
            "`sub` reads its x1 after it has written NEWS",
        ),
        ("neg(A, XW);", "`neg` reads its x after it has written NEWS"),
        (
            "XORX(R12, R5, R6);",
            "`XORX` uses R0 as scratch, and R12 is written only where R0 is 1",
        ),
    ] {
        let said = warned(text);
        assert!(said.contains(words), "{text}: {said}");
    }
    for text in [
        "XORX(R5, R6, R7);",
        "add(A, A, B);",
        "sub(A, A, B);",
        "mov(A, XE);",
        "ANDX(R5, R6, R6);",
        "OR(R5, R5, R6);",
    ] {
        let said = warned(text);
        assert!(!said.contains("reads its"), "{text}: {said}");
    }
}

/// Registers of other roles, and a word that is gone, are differences too.
#[test]
fn a_what_if_chip_shows_its_roles_and_what_it_has_not() {
    let folder = TempDir::new().unwrap();
    let chip = folder.path().join("other");
    fs::create_dir(&chip).unwrap();
    fs::write(
        chip.join("device.toml"),
        "name = \"other\"\ntitle = \"other\"\nextends = \"scamp5\"\n[registers.roles]\nmask = \"R12\"\npropagated = \"R0\"\nnorth = \"R3\"\neast = \"R4\"\nsouth = \"R1\"\nwest = \"R2\"\n",
    )
    .unwrap();
    let program = kept(&folder, "p.scamp", "add(A, B, C);");
    let text = stdout(&["asm", &program, "--chip", &chip.display().to_string()]);
    for line in ["mask: R12 instead of R0", "propagated: R0 instead of R12"] {
        assert!(text.contains(line), "{line:?} in {text}");
    }
    assert!(!text.contains("east: "), "{text}");
}

/// Stores under a fixed mask are told as what they are; words of an included file with its line.
#[test]
fn what_is_no_linear_map_has_its_file_and_line() {
    let folder = tempfile::tempdir().unwrap();
    let text =
        "scamp5_load_pattern(R5, 0, 0, 254, 254);\nget_image(A);\nWHERE(R5);\nres(A);\nall();\n";
    let told = |file: &str| -> String {
        let lines = proof(&["asm", file]);
        let mut found = lines.into_iter().filter(|it| it.starts_with("  A "));
        found.next().unwrap()
    };
    assert_eq!(
        told(&kept(&folder, "mask.scamp", text)),
        "  A    no linear map: line 4: `bus(NEWS)` stores as FLAG or other bits say"
    );
    let header = "inline void twice(areg_t x) {\n mov(x, B);\n mov(x, C);\n}\n\
                  inline void masked(areg_t x) {\n WHERE(R5);\n mov(x, B);\n all();\n}\n";
    kept(&folder, "words.hpp", header);
    let main = "#include \"words.hpp\"\nint main() { twice(D); for (int i = 0; i < 3; i++) twice(E); \
                scamp5_output_image(A); masked(A); twice(F); }\n";
    let file = kept(&folder, "main.cpp", main);
    assert_eq!(
        told(&file),
        "  A    no linear map: words.hpp:7: `bus(NEWS, B)` stores as FLAG or other bits say"
    );
    let said = json(here(), &["asm", &file, "--json"])["proof"]["registers"].to_string();
    assert!(said.contains("words.hpp:7: "), "{said}");
}

/// A bus in three parts has weights of thirds: linear, and not read as words.
#[test]
fn thirds_are_linear() {
    let folder = tempfile::tempdir().unwrap();
    let text = "get_image(A);\nbus3(B, C, D, A);\n";
    let lines = proof(&["asm", &kept(&folder, "p.scamp", text)]);
    let told = lines.iter().find(|it| it.starts_with("  B ")).unwrap();
    assert!(
        told.contains("weights that are not read: line 2") && !told.contains("no linear map"),
        "{told}"
    );
    // What is stated of them is proved by impulses.
    let head = "//! [computes]\n//! kernel = [[-1]]\n//! scale = 0.16666666666666666\n//! register = \"B\"\n";
    let lines = proof(&["asm", &kept(&folder, "q.scamp", &format!("{head}{text}"))]);
    assert!(
        lines[0].contains("the kernel that its [computes] says"),
        "{lines:?}"
    );
}

/// No host, no time of it: the sum of nothing has no sign.
#[test]
fn what_takes_no_time_takes_no_negative_time() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("p.scamp"), "mov(B, A);\n").unwrap();
    let asm = &json(folder.path(), &["asm", "p.scamp", "--json"])["cost"];
    let each = asm.as_object().unwrap().values();
    let mut ranges: Vec<_> = each.map(|cost| cost["host_us_range"].to_string()).collect();
    let compile = ["compile", "sobel-x", "--filter-only", "--effort", "0"];
    let compiled = json(folder.path(), &compile);
    ranges.push(compiled["host_us_range"].to_string());
    assert!(
        ranges.len() > 1 && ranges.iter().all(|it| it == "[0.0,0.0]"),
        "{ranges:?}"
    );
}
