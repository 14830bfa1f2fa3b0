//! `docs/guides/learn-a-kernel.md`, followed to the letter: its task, its lines of `amacrine-learn`, what they leave.

use std::{fs, path::Path, process::Command};

use amacrine::{kernel::Kernel, program::Program, reference::Description};

fn amacrine_learn(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_amacrine-learn"));
    command.current_dir(folder);
    command
}

/// The blocks of a page that begin with this line, without their fences.
fn blocks<'a>(page: &'a str, fence: &str) -> Vec<&'a str> {
    let fence = format!("```{fence}\n");
    let starts = page.match_indices(&fence).map(|(at, _)| at + fence.len());
    starts
        .map(|start| {
            let end = page[start..].find("```").unwrap();
            &page[start..start + end]
        })
        .collect()
}

/// The page.
fn page() -> String {
    let page = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../docs/guides/learn-a-kernel.md"
    );
    fs::read_to_string(page).unwrap()
}

/// Writes the page's task, and runs its lines of `amacrine-learn`.
fn follow(page: &str, folder: &Path) {
    let task = blocks(page, "toml small.toml");
    fs::write(folder.join("small.toml"), task[0]).unwrap();
    let mut ran = 0;
    for line in blocks(page, "sh").iter().flat_map(|block| block.lines()) {
        let Some(arguments) = line.strip_prefix("amacrine-learn ") else {
            continue;
        };
        works(line, amacrine_learn(folder).args(arguments.split(' ')));
        ran += 1;
    }
    assert_eq!(ran, 4);
}

fn works(line: &str, command: &mut Command) {
    let output = command.output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{line}: {errors}");
    assert!(!output.stdout.is_empty(), "{line}");
}

#[test]
fn the_guide_can_be_followed() {
    let folder = tempfile::tempdir().unwrap();
    follow(&page(), folder.path());
    let run = folder.path().join("run");
    assert!(
        fs::read_to_string(run.join("report.html"))
            .unwrap()
            .contains("ternary")
    );
    for arm in ["dvs-0.05-1", "rgc-0.05-1", "ternary-0.05-1"] {
        let arm = run.join("arms").join(arm);
        Description::open(arm.join("sensor.toml")).unwrap();
        Kernel::from_npy(&fs::read(arm.join("kernel-0.npy")).unwrap()).unwrap();
        let program = fs::read_to_string(arm.join("program.scamp")).unwrap();
        Program::parse("program.scamp", &program).unwrap();
    }
}

/// The lines of `amacrine`: what was learned runs as the page says.
#[test]
#[ignore = "needs the program beside amacrine-learn: cargo build --release --all-features"]
fn what_comes_out_runs_as_the_guide_says() {
    let program = Path::new(env!("CARGO_BIN_EXE_amacrine-learn")).with_file_name("amacrine");
    let folder = tempfile::tempdir().unwrap();
    let page = page();
    follow(&page, folder.path());
    let mut ran = 0;
    for line in blocks(&page, "text").iter().flat_map(|block| block.lines()) {
        let Some(arguments) = line.strip_prefix("amacrine ") else {
            continue;
        };
        let photographs = concat!(env!("CARGO_MANIFEST_DIR"), "/photographs");
        let arguments = arguments.replace(
            "-o run --photos ~/pictures",
            "-o other --dry-run --photos PICTURES",
        );
        let arguments = arguments
            .split(' ')
            .map(|it| if it == "PICTURES" { photographs } else { it });
        works(
            line,
            Command::new(&program).current_dir(&folder).args(arguments),
        );
        ran += 1;
    }
    assert_eq!(ran, 6);
    assert!(folder.path().join("page.html").exists());
}

#[test]
fn what_is_wrong_is_told_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(
        at.join("task.toml"),
        "goal = \"interpolation\"\ntargets = [0.05]\nseeds = [1]\narms = [\"dvs\"]\nsteps = 2\n",
    )
    .unwrap();
    fs::write(at.join("wrong.toml"), "goal = \"interpolashun\"\n").unwrap();
    fs::create_dir(at.join("empty")).unwrap();
    fs::create_dir(at.join("few")).unwrap();
    fs::create_dir(at.join("small")).unwrap();
    let photographs = Path::new(env!("CARGO_MANIFEST_DIR")).join("photographs");
    fs::copy(photographs.join("camera.jpg"), at.join("few/a.jpg")).unwrap();
    for n in 0..8 {
        image::GrayImage::new(30, 90)
            .save(at.join(format!("small/{n}.png")))
            .unwrap();
    }
    let text = fs::read_to_string(at.join("task.toml")).unwrap();
    let inside = format!("{text}[scenes]\nphotographs = \"empty\"\n");
    fs::write(at.join("inside.toml"), inside).unwrap();
    let film = format!("{text}[scenes]\nvideo = \"pattern:noise?width=16&height=16&frames=60\"\n");
    fs::write(at.join("film.toml"), film).unwrap();
    let bundled = format!("{text}crop = 300\n[scenes]\nvideo = \"bundled\"\n");
    fs::write(at.join("bundled.toml"), bundled).unwrap();
    fs::write(at.join("far.toml"), format!("{text}[scenes]\npan = 1e9\n")).unwrap();
    for (arguments, says) in [
        ("inside.toml -o r", "inside.toml:7: `photographs`"),
        ("inside.toml -o r", "no photographs"),
        ("task.toml -o r --arm dvss", "no arm `dvss` takes part"),
        ("none.toml -o r", "none.toml"),
        ("wrong.toml -o r", "interpolation"),
        ("task.toml -o r --photos empty", "no photographs"),
        ("task.toml -o r --photos few", "1 photographs"),
        ("task.toml -o r --photos small", "smaller than a crop"),
        ("task.toml -o r --photos nowhere", "nowhere"),
        ("report nowhere", "nowhere"),
        ("task.toml -o task.toml --resume --threads 1", "task.toml"),
        ("task.toml -o task.toml", "a file is in the way"),
        ("film.toml -o r", "a larger video"),
        (
            "bundled.toml -o r",
            "256x256, smaller than a crop of 300x300",
        ),
        (
            "far.toml -o r",
            "far.toml:7:7: a picture that moves by 1000000000 px",
        ),
    ] {
        let output = amacrine_learn(at)
            .args(arguments.split_whitespace())
            .output()
            .unwrap();
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success(), "{arguments}");
        // However lines are broken.
        let flat = errors.replace(|c: char| c.is_whitespace() || "│×╰─▶".contains(c), "");
        let says = says.replace(' ', "");
        assert!(flat.contains(&says), "{arguments}: {errors}");
        assert!(!errors.contains("panicked"), "{errors}");
    }
}
