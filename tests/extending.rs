//! Proves that the walk-throughs of `docs/extending.md` for a chip and a macro, which need no
//! build, do what the page says. `new_word.rs` follows those that do.
#![cfg(feature = "cli")]

mod common;
mod walk;

use std::fs;

#[test]
fn a_chip_and_a_macro() {
    let folder = tempfile::tempdir().unwrap();
    let page = "docs/extending.md";
    for block in walk::blocks(page, "## A chip") {
        if block.file.starts_with("isa/") {
            block.follow(folder.path());
        }
    }
    let text = fs::read_to_string(walk::root().join(page)).unwrap();
    assert!(text.contains("takes 4 words, 0.2 us:"));
    let asm = |more: &[&str]| {
        let command = [&["asm", "isa/quick/sum.scamp"], more].concat();
        common::json(folder.path(), &command)
    };
    let said = asm(&["--chip", "isa/quick"]);
    assert_eq!(said["cost"]["program"]["words"], 4, "{said}");
    assert_eq!(said["cost"]["program"]["array_us"], 0.2, "{said}");
    assert_eq!(said["changes"]["base"], "scamp5");
    // The macro is that of the chip.
    common::refused(folder.path(), &["asm", "isa/quick/sum.scamp"], &["add3"]);
}
