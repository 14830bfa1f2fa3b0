//! Proves what `asm` and `disasm` show: words that read back as the same words, what a what-if
//! chip changes, and one message for a program that cannot be read, whichever verb reads it.

mod common;

use std::{fs, path::Path};

use common::{amacrine, good};
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

#[test]
fn what_is_disassembled_reads_back_as_the_same_words() {
    let folder = tempfile::tempdir().unwrap();
    for program in programs() {
        let words = stdout(&["disasm", &program]);
        assert_eq!(words, stdout(&["asm", &program, "--disasm"]));
        let again = kept(&folder, "words.scamp", &words);
        assert_eq!(stdout(&["disasm", &again]), words, "{program}");
    }
}

#[test]
fn a_program_that_cannot_be_read_has_one_message() {
    let of = |verb: &str, file: &str| stderr(&[verb, file]);
    let missing = of("asm", "none.scamp");
    assert!(missing.contains("cannot read none.scamp") && missing.contains("programs/"));
    for verb in ["exec", "disasm"] {
        assert_eq!(of(verb, "none.scamp"), missing);
    }
    let folder = tempfile::tempdir().unwrap();
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
