//! What comes with the program is found by name, from an empty folder; a file of that name goes
//! first. Against: the files of the sources, and the same commands with their paths.

mod common;

use std::{fs, path::Path};

use common::{good, json, refused};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

#[test]
fn names_stand_for_files() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let names = good(folder, &["list", "sensors"]);
    assert!(names.lines().any(|name| name == "rgc-4"), "{names}");
    assert!(names.lines().any(|name| name == "authors/dvs"), "{names}");
    for of in [
        "programs", "kernels", "studies", "readouts", "chips", "patterns",
    ] {
        assert!(good(folder, &["list", of]).lines().count() > 1, "{of}");
    }
    let text = good(folder, &["list", "sensors", "rgc-4"]);
    let file = Path::new(ROOT).join("sensors/rgc-4.toml");
    assert_eq!(text, fs::read_to_string(&file).unwrap());
    let run = |sensor: &str| {
        let scene = "pattern:bar?width=40&height=30&frames=6";
        json(folder, &["run", "--scene", scene, "--sensor", sensor])
    };
    let named = run("rgc-4");
    assert_eq!(named, run(file.to_str().unwrap()));
    good(folder, &["exec", "dvs/snap"]);
    good(folder, &["asm", "snap"]);
}

#[test]
fn a_pattern_tells_its_parameters() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let all = good(folder, &["list", "patterns"]);
    for words in [
        "disc      a bright disc",
        "wave=sine",
        "where to: 0 is right",
    ] {
        assert!(all.contains(words), "{all}");
    }
    let disc = good(folder, &["list", "patterns", "disc"]);
    assert!(disc.starts_with("pattern:disc: a bright disc"), "{disc}");
    assert!(
        disc.contains("radius=16 ") && disc.contains("pixels\n"),
        "{disc}"
    );
    assert!(
        !disc.contains("sigma=") && !disc.contains("border="),
        "{disc}"
    );
    let pan = good(folder, &["show", "pattern", "pan"]);
    assert!(
        pan.contains("image=") && pan.contains("border=replicate"),
        "{pan}"
    );
    refused(folder, &["list", "patterns", "dics"], &["\"dics\"", "disc"]);
    let run = ["run", "--scene", "bundled", "--sensor", "disc"];
    refused(folder, &run, &["--scene pattern:disc"]);
}

#[test]
fn the_bundled_clip_has_a_name() {
    let folder = tempfile::tempdir().unwrap();
    let run = ["run", "--scene", "bundled", "--sensor", "dvs"];
    assert_eq!(json(folder.path(), &run)["frames"], 72);
    let folder = folder.path();
    let told = good(folder, &["show", "scene", "bundled"]);
    for words in [
        "72 of 256x256 at 10 frames/s, 7.2 s",
        "vtest.avi",
        "--scene bundled",
    ] {
        assert!(told.contains(words), "{told}");
    }
    let bar = good(folder, &["show", "scene", "pattern:bar"]);
    assert_eq!(bar, good(folder, &["show", "pattern", "bar"]));
    refused(
        folder,
        &["show", "scene", "clip"],
        &["no scene", "bundled", "pattern:NAME"],
    );
    refused(
        folder,
        &["show", "scene"],
        &["which one is not said", "bundled"],
    );
}

#[test]
fn a_file_goes_before_a_name() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("dvs"), "memory = 3").unwrap();
    let scene = ["run", "--scene", "pattern:bar", "--sensor"];
    let with = |name| [&scene[..], &[name]].concat();
    refused(folder, &with("dvs"), &["dvs:1:"]);
    refused(folder, &with("dvss"), &["dvss", "amacrine list sensors"]);
    // A folder is no sensor.
    fs::create_dir(folder.join("rgc")).unwrap();
    good(folder, &with("rgc"));
    refused(
        folder,
        &["exec", "snapp"],
        &["snapp", "amacrine list programs"],
    );
    refused(
        folder,
        &["list", "sensors", "dvss"],
        &["there is no dvss", "rgc-4"],
    );
    refused(
        folder,
        &["list", "chips", "scamp6"],
        &["there is no scamp6", "scamp5-wide"],
    );
}

#[test]
fn a_sensor_of_a_name_is_asked_for_its_kernels() {
    let folder = tempfile::tempdir().unwrap();
    let text = good(
        folder.path(),
        &["quantise", "rgc-4-on-chip", "--to", "ternary"],
    );
    assert!(text.contains("falling diagonals"), "{text}");
}

#[test]
fn a_slip_of_the_pen_is_understood() {
    let folder = tempfile::tempdir().unwrap();
    for (line, meant) in [
        ("run --scene bundled --sensor dsv-clean", "dvs-clean"),
        ("run --scene pattern:disk --sensor dvs", "disc"),
        ("run --scene pattern:disc?widht=9 --sensor dvs", "width"),
        (
            "run --scene bundled --sensor dvs --kernel rgc-5x6",
            "rgc-5x5",
        ),
        ("exec dvs/snp", "dvs/snap"),
        ("exec dvs/snap --domain silicone", "silicon"),
        ("exec dvs/snap --chip scamp6", "scamp5"),
        ("quantise rgc-5x5 --to ternery", "ternary"),
        ("sweep fromats --output d", "formats"),
        ("list sensors dvs-claen", "dvs-clean"),
        ("new sensor mine --from dvs-claen", "dvs-clean"),
    ] {
        let words: Vec<&str> = line.split_whitespace().collect();
        refused(
            folder.path(),
            &words,
            &[&format!("did you mean `{meant}`?")],
        );
    }
    for scene in ["bundeld", "bundle", "Bundled"] {
        let words = ["run", "--scene", scene, "--sensor", "dvs"];
        refused(folder.path(), &words, &["did you mean `bundled`?"]);
    }
    refused(folder.path(), &["rn"], &["'rn'", "exists: 'run'"]);
    let names = std::fs::read_dir(folder.path()).unwrap();
    assert_eq!(names.count(), 0);
}

/// A name of another kind of thing is told, and how that is given.
#[test]
fn names_of_another_kind_are_known() {
    let folder = tempfile::tempdir().unwrap();
    for (line, told) in [
        (
            "compile rgc-4 --threshold 9",
            "rgc-4 is a sensor, given as --sensor rgc-4",
        ),
        (
            "run --scene bundled --sensor rgc-5x5",
            "rgc-5x5 is a kernel, given as --kernel rgc-5x5",
        ),
        (
            "run --scene bundled --sensor dvs/snap",
            "dvs/snap is a program, run by `amacrine exec dvs/snap`",
        ),
        (
            "exec formats",
            "formats is a study, computed by `amacrine sweep formats`",
        ),
        (
            "exec scamp5-wide",
            "scamp5-wide is a chip, given as --chip scamp5-wide",
        ),
    ] {
        let words: Vec<&str> = line.split_whitespace().collect();
        refused(folder.path(), &words, &[told]);
    }
}
