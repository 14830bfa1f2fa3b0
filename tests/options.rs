//! Options that would change nothing are refused, and what is advised can be done. Against: the
//! commands without them, and the commands with what is advised.

#![cfg(feature = "cli")]

mod common;
mod verbs;

use std::{collections::BTreeSet, fs};

use common::{good, line, refused};
use verbs::CASES;

const EVENTS: &str = "t,x,y,p\n1000,3,5,1\n2000,9,2,0\n30000,4,4,1\n";

const SCENE: &str = "pattern:bar?width=24&height=24&frames=5";

/// A clip is cut by other words here than in other programs: they are named, where the verb has them.
#[test]
fn how_a_clip_is_cut_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let run = ["run", "--scene", SCENE, "--sensor", "dvs"];
    let with = |more: &[&'static str]| [&run[..], more].concat();
    let words = ["unexpected argument '--frames'", "'--slice ..100' shows"];
    let said = refused(folder.path(), &with(&["--frames", "3"]), &words);
    assert!(!said.contains("--rate"), "{said}");
    let words = ["'--resize 128x96' shows"];
    refused(folder.path(), &with(&["--width=9"]), &words);
    good(
        folder.path(),
        &with(&["--slice", "..3", "--resize", "12x12"]),
    );
    let asm = ["asm", "p.scamp", "--frames", "3"];
    let said = refused(folder.path(), &asm, &[]);
    assert!(!said.contains("--slice"), "{said}");
}

#[test]
fn options_without_effect_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("e.csv"), EVENTS).unwrap();
    fs::write(at.join("p.scamp"), "mov(B, A);\n").unwrap();
    let show = "show e.csv -o";
    for (command, words) in [
        (
            "asm p.scamp --format --const x=3".to_owned(),
            ["--const has no effect with --format", "leave --const out"],
        ),
        (
            "asm p.scamp --format --chip scamp5".to_owned(),
            ["--chip has no effect with --format", "leave --chip out"],
        ),
        (
            "asm p.scamp --format --input 0..3".to_owned(),
            ["'--format' cannot be used with", "--input <LO..HI>"],
        ),
        (
            "asm p.scamp --disasm --input 0..3".to_owned(),
            ["'--disasm' cannot be used with", "--input <LO..HI>"],
        ),
        (
            format!("{show} a.png --hold 30ms"),
            ["--hold has no effect for a.png", ".gif or .apng"],
        ),
        (
            format!("{show} a.mcap --hold 30ms"),
            ["--hold has no effect for a.mcap", ".gif or .apng"],
        ),
        (
            format!("{show} a.gif --at 5ms"),
            ["--at has no effect for a.gif", ".png or .svg"],
        ),
        (
            format!("{show} a.mcap --title x"),
            ["--title has no effect for a.mcap", "leave --title out"],
        ),
        (
            format!("{show} a.gif --view overview"),
            ["an overview has all views on one page", "leave --view out"],
        ),
        (
            format!("{show} a.svg --view rate --at 5ms"),
            ["--at has no effect for this view", "--from and --to"],
        ),
        (
            format!("{show} a.svg --view cloud --window 5ms"),
            ["--window has no effect for this view", "--from and --to"],
        ),
        (
            "show sensor rgc --size 3x3".to_owned(),
            ["cannot be used with", "--size <WxH>"],
        ),
        (
            "show sensor rgc --stream 1".to_owned(),
            ["cannot be used with", "--stream <N>"],
        ),
        (
            "compile sobel-x --filter-only --fps 3".to_owned(),
            ["cannot be used with", "--fps <FPS>"],
        ),
        (
            "compile sobel-x --filter-only --front --as cpp".to_owned(),
            ["cannot be used with", "--as <LANGUAGE>"],
        ),
        (
            "quantise sobel-x --to int-3 --seed 4".to_owned(),
            [
                "--seed has no effect without stochastic rounding",
                "leave --seed out",
            ],
        ),
        (
            "sweep --schema formats -o sw".to_owned(),
            ["'--schema' cannot be used with", "sweep"],
        ),
        (
            format!("plan --scene {SCENE} --sensor dvs --max-events 5"),
            ["--max-events 5 needs --run or --verify", "add --run"],
        ),
    ] {
        let arguments: Vec<&str> = command.split(' ').collect();
        common::refused_untouched(at, &arguments, &words);
    }
    // With effect they are taken.
    for command in [
        "asm p.scamp --format",
        "show e.csv -o a.gif --hold 30ms --title x --window 5ms",
        "show e.csv -o a.png --at 5ms --window 5ms --title x",
        "show e.csv -o b.png --view rate --from 1ms",
        "quantise sobel-x --to q3.4:stochastic --sum free --seed 4",
        "quantise sobel-x --to int-3",
    ] {
        good(at, &command.split(' ').collect::<Vec<_>>());
    }
}

/// Arrays of one form have no use for what another form is asked for, and each has what it needs.
#[test]
fn options_of_another_form_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("e.csv"), EVENTS).unwrap();
    for (command, words) in [
        (
            "a.npy --window 5ms --tau 5ms",
            [
                "--tau has no effect with --as voxels",
                "leave --tau out, or take --as surfaces",
            ],
        ),
        (
            "a.npy --as surfaces --every 5ms --tau 5ms --window 5ms",
            [
                "--window has no effect with --as surfaces",
                "--tau says how long a cell remembers",
            ],
        ),
        (
            "a.npy --as frames --count 5 --every 5ms",
            [
                "--every has no effect with --as frames",
                "--as voxels --bins 1 --share whole",
            ],
        ),
        (
            "a.npy --as frames --count 5 --normalise max",
            [
                "--normalise has no effect with --as frames",
                "leave --normalise out, or take --as voxels",
            ],
        ),
        (
            "a.npy --as surfaces --every 5ms",
            ["required arguments were not provided", "--tau <TIME>"],
        ),
        (
            "a.npy --as voxels",
            ["required arguments were not provided", "--window <TIME>"],
        ),
        (
            "a.npy",
            ["required arguments were not provided", "--window <TIME>"],
        ),
        (
            "a.npy --as frames",
            ["required arguments were not provided", "--count <N>"],
        ),
    ] {
        let command = format!("voxels e.csv -o {command}");
        let arguments: Vec<&str> = command.split(' ').collect();
        common::refused_untouched(at, &arguments, &words);
    }
    for command in [
        "--window 5ms --bins 2 --align centred --polarity split --share whole --normalise max",
        "--as surfaces --every 5ms --from 1ms --tau 5ms --decay linear --polarity signed",
        "--as frames --count 2 --fill last --polarity split --half",
    ] {
        let command = format!("voxels e.csv -o a.npy {command}");
        good(at, &command.split(' ').collect::<Vec<_>>());
    }
}

/// Of two values of one setting neither is taken in silence.
#[test]
fn a_setting_is_given_once() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("e.csv"), EVENTS).unwrap();
    for (command, words) in [
        (
            "packets e.csv --readout arbiter --with fifo=1 --with fifo=5",
            ["--with fifo is given twice", "each setting once"],
        ),
        (
            "exec dvs/snap --set error.noise=1 --set error.noise=5",
            ["--set error.noise is given twice", "each name once"],
        ),
        (
            "exec dvs/snap --image bundled --const threshold=5 --const threshold=40",
            [
                "the constant `threshold` is set twice",
                "each constant once",
            ],
        ),
        (
            "exec dvs/snap --image bundled --set threshold=5 --const threshold=40",
            [
                "the constant `threshold` is set twice",
                "each constant once",
            ],
        ),
        (
            "asm dvs/snap --const threshold=5 --const threshold=9",
            [
                "the constant `threshold` is set twice",
                "each constant once",
            ],
        ),
    ] {
        let arguments: Vec<&str> = command.split(' ').collect();
        common::refused_untouched(at, &arguments, &words);
    }
}

/// The bound of a list is explained by options of the verb at hand.
#[test]
fn a_full_list_is_told_by_every_verb() {
    let folder = tempfile::tempdir().unwrap();
    let plan = ["plan", "--scene", SCENE, "--sensor", "dvs"];
    let said = refused(
        folder.path(),
        &[&plan[..], &["--max-events", "5", "--run"]].concat(),
        &["more than 5 events", "`amacrine run` also has --counts"],
    );
    assert!(!line(said.as_bytes()).contains("ask for"), "{said}");
}

/// A threshold that is advised is one that some light passes.
#[test]
fn a_threshold_that_is_advised_can_fire() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let compile = [
        "compile",
        "sobel-x",
        "--effort",
        "0.05",
        "-o",
        "p.scamp",
        "--threshold",
    ];
    let told = refused(
        at,
        &[&compile[..], &["1e9"]].concat(),
        &[
            "more than the 128 that the host can set",
            "lower the threshold to 0.00000203 times",
        ],
    );
    assert!(told.contains("LSB"), "{told}");
    let asked = [&compile[..], &["2030"]].concat();
    let said = common::amacrine(at, &asked).output().unwrap();
    assert!(said.status.success(), "{said:?}");
    let said = line(&said.stderr);
    assert!(!said.contains("no light gives an event"), "{said}");
}

/// Where a file of a design cannot be written, none is: what was there stays.
#[cfg(target_os = "linux")]
#[test]
fn a_design_is_written_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::create_dir(at.join("d")).unwrap();
    fs::write(at.join("d/program.scamp"), "old").unwrap();
    std::os::unix::fs::symlink("/dev/full", at.join("d/report.html")).unwrap();
    let design = [
        "design",
        "csdvs-3",
        "--threshold",
        "8",
        "--effort",
        "0.05",
        "--to",
        "ternary",
        "--scene",
        SCENE,
        "--chips",
        "1",
        "-o",
        "d",
    ];
    refused(at, &design, &["d/report.html", "No space left"]);
    assert_eq!(fs::read(at.join("d/program.scamp")).unwrap(), b"old");
    assert_eq!(fs::read_dir(at.join("d")).unwrap().count(), 2);
}

/// What comes through a pipe has no name to rename, and what is not there yet neither.
#[cfg(unix)]
#[test]
fn pipes_and_outputs_are_not_to_be_renamed() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let mut packets = common::amacrine(at, &["packets", "/dev/stdin"]);
    let said = packets.write_stdin(EVENTS).output().unwrap();
    let said = common::refusal(&said, &["write it to a file first"]);
    assert!(!said.contains("rename"), "{said}");
    let run = [
        "run", "--scene", SCENE, "--sensor", "dvs", "--events", "o.foo",
    ];
    let said = refused(at, &run, &["give a name that ends in one of these"]);
    assert!(!said.contains("rename"), "{said}");
}

/// Some verbs print an object, some a list where several are asked for: all say the same of it.
#[test]
fn json_is_described_alike() {
    let folder = tempfile::tempdir().unwrap();
    let verbs: BTreeSet<Vec<&str>> = { CASES.iter() }
        .map(|case| {
            let words = if case.line.starts_with("mesh ") { 2 } else { 1 };
            case.line.split(' ').take(words).collect()
        })
        .collect();
    let mut described = 0;
    for verb in verbs {
        let help = good(folder.path(), &[&verb[..], &["--help"]].concat());
        let mut lines = help.lines().map(str::trim);
        let Some(line) = lines.find_map(|line| line.strip_prefix("--json")) else {
            continue;
        };
        // On the same line, or the next.
        let told = format!("{line} {}", lines.next().unwrap_or_default());
        assert!(
            told.trim().starts_with("Print JSON in place of text"),
            "{verb:?}: {told}"
        );
        described += 1;
    }
    assert!(described > 15, "{described}");
}
