//! Proves that the walk-throughs of `isa/README.md` and `docs/extending.md` add an instruction, an
//! event format, a metric, a quantiser and a chip: followed to the letter in a copy of the
//! sources, it builds, stores obey the FLAG that the new word clears, and the rest is there.

mod walk;

use std::{fs, path::PathBuf, process::Command};

#[test]
#[ignore = "builds the program once more"]
fn the_walk_throughs_add_what_they_say() {
    // In one place, so that what was built before is found again.
    let tree = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("new-word");
    let _ = fs::remove_dir_all(&tree);
    walk::copy(walk::root(), &tree);
    // Another version is built beside this one, not in its place: the list of chips, which
    // `build.rs` makes, would be taken for that of these sources.
    let manifest = fs::read_to_string(tree.join("Cargo.toml")).unwrap();
    let version = format!("version = \"{}\"", env!("CARGO_PKG_VERSION"));
    let other = format!("version = \"{}-copy\"", env!("CARGO_PKG_VERSION"));
    assert!(manifest.contains(&version));
    let manifest = manifest.replacen(&version, &other, 1);
    fs::write(tree.join("Cargo.toml"), manifest).unwrap();
    let word = walk::blocks("isa/README.md", "### From the row to the last schedule");
    assert_eq!(word.len(), 12);
    let lists = walk::blocks("docs/extending.md", "## An event format");
    assert_eq!(lists.len(), 13);
    for block in word.iter().chain(&lists) {
        block.follow(&tree);
    }
    for example in ["nowhere", "extended"] {
        // The dependencies are those of the tests; an example needs no program besides. As it is
        // compiled once and runs for a moment, it is not optimised.
        let ran = Command::new(env!("CARGO"))
            .args(["run", "--release", "--all-features", "--offline"])
            .args(["--config", "profile.release.package.amacrine.opt-level=0"])
            .args(["--example", example])
            .current_dir(&tree)
            .env("CARGO_TARGET_DIR", walk::root().join("target"))
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&ran.stderr);
        assert!(ran.status.success(), "{said}");
    }
}
