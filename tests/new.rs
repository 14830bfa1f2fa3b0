//! What `new` writes is a file that the other verbs take, from an empty folder, with a schema that
//! holds it; nothing that is there is overwritten. Completions and manual pages name every verb.
//! Against: the verbs themselves, a JSON Schema validator.

mod common;

use std::fs;

use common::{good, refused};

#[test]
fn each_kind_begins_with_a_file_that_works() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for kind in ["sensor", "kernel", "study", "readout", "program", "chip"] {
        good(folder, &["new", kind, &format!("my-{kind}")]);
    }
    let scene = "pattern:bar?width=40&height=30&frames=6";
    good(
        folder,
        &[
            "run",
            "--scene",
            scene,
            "--sensor",
            "my-sensor.toml",
            "--readout",
            "my-readout.toml",
            "--events",
            "e.npy",
        ],
    );
    good(
        folder,
        &[
            "compile",
            "my-kernel.toml",
            "--to",
            "ternary",
            "--filter-only",
        ],
    );
    good(folder, &["asm", "my-program.scamp", "--chip", "my-chip"]);
    good(folder, &["new", "chip", "wider", "--from", "scamp5-wide"]);
    // Between the chip's name and what it differs from.
    let listing = |chip: &str| {
        let said = good(folder, &["asm", "my-program.scamp", "--chip", chip]);
        let rest = said.split_once("\ninit").unwrap().1;
        let (costs, rest) = rest.split_once("\nagainst").unwrap();
        [costs, rest.split_once("\ncomputes").unwrap().1].concat()
    };
    assert_eq!(listing("wider"), listing("scamp5-wide"));
    let device = fs::read_to_string(folder.join("wider/device.toml")).unwrap();
    assert!(device.contains("name = \"wider\"\n"), "{device}");
    assert!(device.contains("extends = \"scamp5-wide\"\n"), "{device}");
    good(folder, &["sweep", "my-study.toml", "frames=2", "--space"]);
    good(
        folder,
        &["new", "sensor", "deep/in/four.toml", "--from", "rgc-4"],
    );
    assert!(folder.join("deep/in/sensor.schema.json").exists());
    // Each says its own name, and is told of where the ending is left out.
    let has = |file: &str, line: &str| {
        let text = fs::read_to_string(folder.join(file)).unwrap();
        assert!(text.lines().any(|own| own == line), "{text}");
    };
    has("my-chip/device.toml", "name = \"my-chip\"");
    has("my-study.toml", "title = \"my-study\"");
    has("my-sensor.toml", "name = \"my-sensor\"");
    has("my-sensor.toml", "name = \"centre-on\"");
    refused(
        folder,
        &["run", "--scene", scene, "--sensor", "my-sensor"],
        &["there is my-sensor.toml"],
    );
}

#[test]
fn the_schema_beside_it_holds_and_the_comments_are_keys() {
    let folder = tempfile::tempdir().unwrap();
    let mut commented = 0;
    for kind in ["sensor", "kernel", "study", "readout"] {
        good(folder.path(), &["new", kind, kind]);
        let read = |file: String| fs::read_to_string(folder.path().join(file)).unwrap();
        let text = read(format!("{kind}.toml"));
        let first = format!("#:schema ./{kind}.schema.json\n");
        assert!(text.starts_with(&first), "{text}");
        let schema = serde_json::from_str(&read(format!("{kind}.schema.json"))).unwrap();
        let holds = |text: &str| {
            let file: toml::Table = text.parse().unwrap_or_else(|e| panic!("{e}\n{text}"));
            let file = serde_json::to_value(file).unwrap();
            let wrong = jsonschema::validate(&schema, &file);
            assert!(wrong.is_ok(), "{kind}: {wrong:?}\n{text}");
        };
        holds(&text);
        // Each comment with a value is a line that may stand there; those of a table stand there
        // together.
        let mut table = None;
        for line in text.lines().filter_map(|line| line.strip_prefix("# ")) {
            if line.starts_with('[') {
                table = Some(line);
            }
            let Some((key, rest)) = line.split_once(" = ") else {
                continue;
            };
            let (value, says) = rest.split_once("    # ").unwrap_or((rest, ""));
            if value == "…" || key.contains(' ') {
                continue;
            }
            commented += 1;
            let mut with = text.replace(&format!("# {line}"), &format!("{key} = {value}"));
            if let Some(table) = table {
                let (before, keys) = text.split_once(table).unwrap();
                let keys = keys.split("\n\n").next().unwrap();
                let before = before.strip_suffix("# ").unwrap();
                with = format!("{before}{table}{}", keys.replace("\n# ", "\n"));
            }
            if let Some((other, _)) = says
                .strip_prefix("in place of ")
                .and_then(|it| it.split_once(": "))
            {
                with = without(&with, other);
            }
            holds(&with);
        }
    }
    // Of sensors, kernels and studies; also of what a channel and a table may have.
    assert!(commented > 30, "{commented}");
    let sensor = fs::read_to_string(folder.path().join("sensor.toml")).unwrap();
    for key in [
        "mesh",
        "pattern",
        "gain",
        "memory-kernel",
        "log-temporal",
        "leak-hz",
    ] {
        assert!(sensor.contains(&format!("\n# {key} = ")), "{key}: {sensor}");
    }
}

/// A new chip names its schema, which stands beside its file; what is offered in comments holds, too.
#[test]
fn a_new_chip_has_its_schema() {
    let folder = tempfile::tempdir().unwrap();
    for (name, more) in [("plain", &[][..]), ("other", &["--from", "scamp5"])] {
        good(folder.path(), &[&["new", "chip", name], more].concat());
        let read = |file: &str| fs::read_to_string(folder.path().join(name).join(file)).unwrap();
        let text = read("device.toml");
        assert!(text.starts_with("#:schema ./chip.schema.json\n"), "{text}");
        let schema = serde_json::from_str(&read("chip.schema.json")).unwrap();
        let with = text.replace("\n# [", "\n[");
        let with = with.replace("\n# analogue", "\nanalogue");
        let with = with.replace("\n# height", "\nheight");
        let with = with.replace("\n# width", "\nwidth");
        for text in [&text, &with] {
            let file: toml::Table = text.parse().unwrap_or_else(|e| panic!("{e}\n{text}"));
            let file = serde_json::to_value(file).unwrap();
            let wrong = jsonschema::validate(&schema, &file);
            assert!(wrong.is_ok(), "{wrong:?}\n{text}");
        }
        let wrong = with.replacen("title", "tilte", 1).parse::<toml::Table>();
        let wrong = serde_json::to_value(wrong.unwrap()).unwrap();
        assert!(jsonschema::validate(&schema, &wrong).is_err());
    }
}

/// A file without a key, whose value may take several lines.
fn without(text: &str, key: &str) -> String {
    let at = text.find(&format!("\n{key} = ")).unwrap();
    let rest = &text[at + 1..];
    let ends = rest.match_indices('\n').map(|(end, _)| end);
    let whole = ends
        .map(|end| &rest[..end])
        .find(|part| part.parse::<toml::Table>().is_ok());
    text.replace(whole.unwrap(), "")
}

#[test]
fn nothing_is_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("mine.toml"), "my own").unwrap();
    refused(
        folder,
        &["new", "sensor", "mine"],
        &["mine.toml is there already"],
    );
    assert_eq!(
        fs::read_to_string(folder.join("mine.toml")).unwrap(),
        "my own"
    );
    assert_eq!(fs::read_dir(folder).unwrap().count(), 1);
    refused(
        folder,
        &["new", "sensor", "a", "--from", "nothing"],
        &["there is no nothing", "rgc-4"],
    );
    refused(
        folder,
        &["new", "chip", "a", "--from", "scamp6"],
        &["there is no scamp6", "scamp5-wide"],
    );
    for name in ["", "b/", ".."] {
        refused(folder, &["new", "sensor", name], &["is no name of a file"]);
    }
}

#[test]
fn shells_and_manuals_know_every_verb() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let text = good(folder, &["completions", shell]);
        assert!(
            text.contains("feasibility") && text.contains("fidelity"),
            "{shell}"
        );
    }
    good(folder, &["man", "-o", "man1"]);
    let page = fs::read_to_string(folder.join("man1/amacrine-run.1")).unwrap();
    assert!(
        page.contains("fidelity") && page.starts_with(".ie"),
        "{page}"
    );
    let verbs = fs::read_to_string(folder.join("man1/amacrine.1")).unwrap();
    for verb in ["feasibility", "quantise", "sweep"] {
        assert!(verbs.contains(verb), "{verb}");
        assert!(folder.join(format!("man1/amacrine-{verb}.1")).exists());
    }
}

/// Of every sensor and study that comes with the program: a key in a comment that has a value holds
/// where it stands; those that no side of a study takes are not offered.
#[test]
fn each_comment_with_a_value_holds_alone() {
    use amacrine::{
        bundled::{self, Kind},
        reference::Description,
        study::sweep::Study,
    };
    let folder = tempfile::tempdir().unwrap();
    let mut commented = 0;
    for (word, kind) in [("sensor", Kind::Sensor), ("study", Kind::Study)] {
        for (at, file) in bundled::all(kind).enumerate() {
            let name = format!("{word}-{at}");
            good(folder.path(), &["new", word, &name, "--from", file.name]);
            let text = fs::read_to_string(folder.path().join(format!("{name}.toml"))).unwrap();
            let (before, _) = text.split_once("\n# [").unwrap_or((&text, ""));
            for line in before.lines().filter(|line| line.starts_with("# ")) {
                let Some((key, says)) = line[2..].split_once("    # ") else {
                    continue;
                };
                if key.ends_with('…') || says.starts_with("in place of ") {
                    continue;
                }
                commented += 1;
                let with = text.replacen(&format!("\n{line}\n"), &format!("\n{key}\n"), 1);
                assert_ne!(with, text);
                let none = |_: &str| Err(std::io::ErrorKind::NotFound.into());
                let read = match kind {
                    Kind::Sensor => Description::parse("a", &with, &none).map(drop),
                    _ => Study::parse("a", &with).map(drop),
                };
                assert!(read.is_ok(), "{}: {key}: {:?}", file.name, read.err());
            }
        }
    }
    assert!(commented > 150, "{commented}");
}

/// Chips extend each other by name.
#[test]
fn a_chip_has_a_name_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    refused(
        folder.path(),
        &["new", "chip", "mine/scamp5", "--from", "scamp5"],
        &["`scamp5` is a shipped chip", "a name of its own"],
    );
    assert!(!folder.path().join("mine").exists());
}
