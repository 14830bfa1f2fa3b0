//! Proves that `docs/scamp5.md` is what `isa/` says, and says something of every statement.
//! `AMACRINE_BLESS=1 cargo test --test instructions` writes it anew.

use std::{fs, path::Path};

use amacrine::{
    isa::{Device, Figure},
    program::reference,
};

#[test]
fn the_page_is_what_the_files_say() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/scamp5.md");
    let text = reference(&Device::scamp5());
    if std::env::var_os("AMACRINE_BLESS").is_some() {
        fs::write(&path, &text).unwrap();
    }
    let written = fs::read_to_string(&path).unwrap_or_default();
    for (number, (a, b)) in (1..).zip(written.lines().zip(text.lines())) {
        assert_eq!(a, b, "docs/scamp5.md:{number}: bless it");
    }
    assert_eq!(written, text, "docs/scamp5.md: bless it");
}

#[test]
fn every_statement_has_equation_operands_aliases_destroys_words_and_evidence() {
    let device = Device::scamp5();
    let text = reference(&device);
    let entries: Vec<&str> = text.split("\n### ").skip(1).collect();
    for callable in device.all_callables() {
        let name = &callable.signature().name;
        let entry = entries
            .iter()
            .find(|entry| entry.contains(&format!("{name}(")));
        let entry = entry.unwrap_or_else(|| panic!("{name} is missing"));
        for part in ["- aliases: ", "- destroys: ", "- words: "] {
            assert!(entry.contains(part), "{name}: {part}");
        }
        let known = ["measured", "quoted", "modelled", "guess"];
        assert!(known.iter().any(|e| entry.contains(e)), "{name}: evidence");
    }
    for figure in Figure::ALL {
        let (section, key) = figure.key();
        assert!(text.contains(&format!("`{section}.{key}`")));
    }
}

/// What is said of some macros whose rules are known from the vendor's tables.
#[test]
fn what_the_tables_say_is_on_the_page() {
    let text = reference(&Device::scamp5());
    let entry = |heading: &str| {
        let (_, rest) = text.split_once(&format!("### `{heading}`")).unwrap();
        rest.split_once("\n### ").map_or(rest, |(entry, _)| entry)
    };
    let sub = entry("sub(out y: areg, x0: source, x1: source)");
    assert!(sub.contains("illegal: y = x1") && sub.contains("- destroys: NEWS\n- words: 2\n"));
    let xor = entry("XORX(out l: dreg, trash x: dreg, y: bit)");
    assert!(xor.contains("- destroys: R0, x\n- words: 6\n"), "{xor}");
    let abs = entry("abs(out y: areg, x: source)");
    assert!(
        abs.contains("- destroys: NEWS, FLAG\n- words: 6\n"),
        "{abs}"
    );
    let gauss = entry("gauss(out y: areg, x: areg, n: int[1..65535] = 3)");
    assert!(
        gauss.contains("3 for n = 1; 2 more for each step of n"),
        "{gauss}"
    );
    let two = entry("mov2x(out y: areg, x: source, d1: dir, d2: dir)");
    assert!(two.contains("- FLAG: must be 1 everywhere"));
}
