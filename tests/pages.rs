//! Proves that what the pages show is what the commands above it print. Against: `README.md`
//! and `docs/`, word for word but for times of this machine.

#![cfg(feature = "cli")]

mod common;

use std::{fs, path::Path};

use common::good;
use tempfile::TempDir;

/// A page of the repository.
fn page(name: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(name)).unwrap()
}

/// The fenced block of a page that comes after the one which holds a command.
#[track_caller]
fn after<'a>(page: &'a str, command: &str) -> Vec<&'a str> {
    let mut blocks = page.split("\n```").skip(1).step_by(2);
    assert!(blocks.any(|block| block.contains(command)), "no {command}");
    let shown = blocks.next().expect("a block that shows what is printed");
    shown.lines().skip(1).collect()
}

/// What the command prints, run in a folder of its own that has the repository's studies.
#[track_caller]
fn printed(folder: &TempDir, command: &str) -> String {
    let words = command.replace('"', "");
    let words: Vec<_> = words.split(' ').collect();
    assert_eq!(words[0], "amacrine");
    good(folder.path(), &words[1..])
}

/// The folder in which the commands of the pages run.
fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    let studies = folder.path().join("studies");
    fs::create_dir(&studies).unwrap();
    fs::create_dir(folder.path().join("docs")).unwrap();
    fs::write(studies.join("formats.toml"), page("studies/formats.toml")).unwrap();
    folder
}

/// A line of the demo without the speed of the machine that printed it.
fn steady(line: &str) -> &str {
    match line.rsplitn(3, ' ').collect::<Vec<_>>()[..] {
        ["f/s", _, rest] => rest.trim_end(),
        _ => line.trim_end(),
    }
}

/// The sensors of a report with their errors, bits and words, in any order: that, like who is
/// on the front, is a matter of time.
fn sensors(text: &str) -> Vec<String> {
    let row = |line: &str| {
        // A sentence may have milliseconds too.
        let sensor = line.starts_with("  ");
        let (before, after) = line.split_once(" ms ").filter(|_| sensor)?;
        let (sensor, _) = before.rsplit_once(' ')?;
        let counts: Vec<_> = after.split_whitespace().take(2).collect();
        Some(format!("{} {}", sensor.trim_end(), counts.join(" ")))
    };
    let mut rows: Vec<_> = text.lines().filter_map(row).collect();
    rows.sort();
    rows
}

#[test]
fn the_table_and_the_picture_of_the_demo() {
    let (folder, page) = (folder(), page("README.md"));
    let said = printed(&folder, "amacrine demo");
    let pixels = |path: &Path| image::open(path).unwrap().to_rgb8();
    let ours = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/demo.png");
    assert!(pixels(&ours) == pixels(&folder.path().join("out/row.png")));
    let said: Vec<_> = said.lines().map(steady).collect();
    let shown = after(&page, "cargo run --release").into_iter().map(steady);
    let shown: Vec<_> = shown.collect();
    assert!(shown.iter().any(|line| line.contains(" silicon ")));
    assert_eq!(said[said.len() - shown.len()..], shown);
    for file in [
        "reference.csv",
        "reference.npy",
        "row.png",
        "sheet.png",
        "watch.gif",
    ] {
        let bytes = fs::metadata(folder.path().join("out").join(file));
        assert!(bytes.unwrap().len() > 0, "{file}");
    }
    // The table says how it is read, in lines of a terminal; F1 is no column of it.
    let text = said.join("\n");
    for words in [
        "at 10 frames/s, the clip's own",
        "at 50 frames/s, which the chip can run",
        "How to read it",
        "as threshold",
        "F1 within 1 ms is not shown",
        "So rgc-5x5 runs in the pixels",
    ] {
        assert!(text.contains(words), "no {words}: {text}");
    }
    for line in said.iter().filter(|line| !line.starts_with("verbs: ")) {
        assert!(line.chars().count() <= 130, "{line}");
    }
    let mut heads = said.iter().filter(|line| line.contains("kept  as"));
    assert_eq!(heads.clone().count(), 2);
    assert!(heads.all(|head| !head.contains("F1")));
}

#[test]
fn the_sensors_of_the_worked_sweep() {
    let (folder, page) = (folder(), page("docs/sweeps.md"));
    let sweep = "amacrine sweep studies/formats.toml --output out/formats";
    let report = "amacrine report out/formats -o front.svg";
    printed(&folder, sweep);
    let said = printed(&folder, report);
    assert_eq!(sensors(&said).len(), 18);
    assert_eq!(sensors(&said), sensors(&page));
}

/// What a waterfall prints, and its picture.
#[track_caller]
fn waterfall(command: &str, picture: &str) {
    let (folder, page_text) = (folder(), page("docs/waterfall.md"));
    let said = printed(&folder, command);
    let said: Vec<_> = said.lines().map(str::trim_end).collect();
    let shown = after(&page_text, command);
    assert!(shown.len() > 10);
    assert_eq!(said[..shown.len()], shown);
    let drawn = fs::read_to_string(folder.path().join(picture)).unwrap();
    assert!(drawn == page(picture), "{picture}");
}

#[test]
fn the_waterfall_and_its_picture() {
    let command = "amacrine waterfall rgc-5x5 --to int-5 --threshold 128 \
                   -o docs/waterfall.svg";
    waterfall(command, "docs/waterfall.svg");
}

#[test]
fn the_steps_of_the_waterfall_and_their_picture() {
    let command = "amacrine waterfall rgc-5x5 --to int-5 --threshold 128 \
                   --steps -o docs/waterfall-steps.svg";
    waterfall(command, "docs/waterfall-steps.svg");
}

#[test]
fn the_feasibility_of_a_disc() {
    let command = "amacrine feasibility rgc-5x5 --threshold 128 \
                   --scene \"pattern:disc?width=64&height=48&frames=8\" --fps 100 \
                   --within 10ms";
    let page = page("docs/feasibility.md");
    let said = printed(&folder(), command);
    let said: Vec<_> = said.trim().lines().map(str::trim_end).collect();
    assert_eq!(said, after(&page, command));
}

/// Every command of the guide, in the order in which they stand there; searches and scenes are
/// made short.
#[test]
fn every_step_of_the_guide() {
    let folder = folder();
    let sensors = folder.path().join("sensors");
    fs::create_dir(&sensors).unwrap();
    let sensor = "sensors/rgc-4-on-chip.toml";
    fs::write(folder.path().join(sensor), page(sensor)).unwrap();
    let guide = page("docs/guides/from-kernel-to-chip.md");
    let mut steps = Vec::new();
    // Blocks without a language are commands; what they print, and what is refused, is text.
    for block in guide.split("\n```").skip(1).step_by(2) {
        let commands = block.strip_prefix('\n').unwrap_or_default();
        steps.extend(
            commands
                .lines()
                .filter(|line| line.starts_with("amacrine ")),
        );
    }
    assert!(steps.len() >= 10, "{steps:?}");
    for step in steps {
        let mut step = step.to_owned();
        if step.contains("amacrine compile") || step.contains("quantise") && step.contains(',') {
            step += " --effort 0.02";
        }
        if step.contains("amacrine quantise") && step.contains(',') {
            step += " --scene pattern:disc?width=40&height=32&frames=6";
        }
        // A reader's own clip.
        let step = step.replace("clip.mp4", "pattern:disc?width=40&height=32&frames=6");
        let said = printed(&folder, &step);
        assert!(!said.is_empty(), "{step}");
    }
    // The four kernels have become a program, and events.
    for file in ["four.scamp", "four.csv", "silicon.csv"] {
        assert!(folder.path().join(file).exists(), "{file}");
    }
}

/// The library's few lines are those of an example, which is compiled.
#[test]
fn the_lines_of_the_library() {
    let example = page("examples/two_sensors.rs");
    let code = &example[example.find("use amacrine").unwrap()..];
    assert!(page("README.md").contains(&format!("```rust\n{}\n```", code.trim_end())));
}
