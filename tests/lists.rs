//! Proves that pages and helps say of each list exactly what its table says: event formats,
//! metrics, quantisers, number formats, chips and verbs. Against: the tables of the library.
#![cfg(feature = "cli")]

mod common;

use std::{fmt::Write as _, fs, path::Path};

use amacrine::{
    compare::metric::{ENTRIES, IN_STUDIES, Scale},
    event::file::Format,
    isa::Device,
    kernel::quantise,
    number::{FIXED, Format as Number},
    scene::{
        Transfer,
        pattern::{PARAMETERS, PATTERNS, Pattern},
    },
};
use common::good;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn help(verb: &str) -> String {
    let text = good(root(), &[verb, "--help"]);
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The page has this table, row by row, and no row more.
#[track_caller]
fn has_table(page: &str, head: &str, rows: &[String]) {
    let text = fs::read_to_string(root().join(page)).unwrap();
    let at = text.find(head);
    let at = at.unwrap_or_else(|| panic!("{page}: no `{head}`"));
    let shown: Vec<_> = text[at..]
        .lines()
        .skip(2)
        .take_while(|line| line.starts_with('|'))
        .collect();
    assert!(
        shown == rows,
        "{page} should have behind `{head}`:\n{}",
        rows.join("\n")
    );
}

/// A number one below a power of two, as that power.
fn power(most: u64) -> String {
    let power = u128::from(most) + 1;
    assert!(power.is_power_of_two());
    format!("2^{} us", power.trailing_zeros())
}

#[test]
fn event_formats() {
    let row = |format: &Format| {
        let limits = format.limits();
        let mut latest = power(limits.t);
        if limits.silence != u64::MAX {
            let _ = write!(latest, ", no silence above {}", power(limits.silence));
        }
        format!(
            "| `{format}` | .{} | {}x{} | {latest} | {} | {} | `{}` |",
            format.extension(),
            u32::from(limits.x) + 1,
            u32::from(limits.y) + 1,
            if limits.channels { "kept" } else { "refused" },
            format.readers(),
            format.python()
        )
    };
    let rows: Vec<_> = Format::ALL.iter().map(row).collect();
    has_table("docs/formats.md", "| `--format` | extension |", &rows);
    let names = Format::names();
    assert_eq!(names.split(' ').count(), Format::ALL.len());
    for verb in ["run", "exec", "convert"] {
        assert!(help(verb).contains(&names), "{verb}: {names}");
    }
}

#[test]
fn metrics() {
    let rows: Vec<_> = ENTRIES
        .iter()
        .map(|entry| {
            let scaled = entry.scale != Scale::None;
            format!(
                "| `{}{}` | {}{} | {} | {} | {} |",
                entry.key,
                if scaled { "_*" } else { "" },
                entry.title.trim(),
                if scaled { " *" } else { "" },
                entry
                    .study
                    .map_or(String::new(), |(name, _)| format!("`{name}`")),
                if entry.symmetric { "yes" } else { "no" },
                entry.blind_to
            )
        })
        .collect();
    has_table("docs/ruler.md", "| key in `--json` |", &rows);
    let study = |(name, what): &(&str, &str)| format!("| `{name}` | {what} |");
    let rows: Vec<_> = IN_STUDIES.iter().map(study).collect();
    has_table("docs/sweeps.md", "| metric | what it is |", &rows);
}

#[test]
fn quantisers() {
    let rows: Vec<_> = quantise::ENTRIES
        .iter()
        .map(|entry| {
            let [form, numbers] = [entry.form, entry.numbers];
            let [levels, scale, quality] = [entry.levels, entry.scale, entry.quality];
            format!("| `{form}` | {numbers} | {levels} | {scale} | {quality} |")
        })
        .collect();
    let page = "docs/guides/from-kernel-to-chip.md";
    has_table(page, "| quantiser | numbers |", &rows);
    assert!(help("quantise").contains(&quantise::known()));
}

#[test]
fn number_formats() {
    for name in ["f64", "f32", "f16", "bf16", "q8.8", "q4.12-wrap"] {
        let format: Number = name.parse().unwrap();
        assert_eq!(format.to_string(), name);
    }
    let error = "f8".parse::<Number>().unwrap_err();
    let known = miette::Diagnostic::help(&error).unwrap().to_string();
    let (floats, _) = known.split_once(", and qM.N").unwrap();
    let floats = floats.trim_start_matches("known are ");
    assert_eq!(floats.split(", ").count(), 4, "{floats}");
    for verb in ["run", "exec", "plan", "trade", "waterfall"] {
        assert!(help(verb).contains(FIXED), "{verb}");
    }
    let (run, exec) = (help("run"), help("exec"));
    for names in floats.split(", ") {
        let names: Vec<_> = names.split([' ', '(', ')']).collect();
        for text in [&run, &exec] {
            let listed = names.iter().any(|name| text.contains(&format!("{name}, ")));
            assert!(listed, "{names:?} in: {text}");
        }
    }
}

#[test]
fn chips() {
    let folders = fs::read_dir(root().join("isa")).unwrap();
    let mut chips: Vec<_> = folders
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.join("device.toml").is_file())
        .map(|path| path.file_name().unwrap().to_str().unwrap().to_owned())
        .collect();
    chips.sort();
    assert!(
        chips
            .iter()
            .eq(Device::shipped().collect::<Vec<_>>().iter())
    );
    let page = fs::read_to_string(root().join("isa/README.md")).unwrap();
    for chip in chips {
        assert_eq!(Device::find(&chip).unwrap().name(), chip);
        assert!(
            page.contains(&format!("`{chip}/`")),
            "isa/README.md: {chip}"
        );
    }
}

#[test]
fn patterns() {
    let takes = |name: &str, key: &str| {
        let keys = Pattern::parameters(name).unwrap();
        let has = |key: &str| keys.iter().any(|known| known == key);
        has(key) || key == "border" && has("image")
    };
    let rows: Vec<_> = { PATTERNS.iter() }
        .map(|(name, what)| format!("| `{name}` | {what} |"))
        .collect();
    has_table("docs/scenes.md", "| pattern | what |", &rows);
    let row = |(key, default, what): &(&str, &str, &str)| {
        let names = PATTERNS.iter().map(|(name, _)| *name);
        let of: Vec<_> = names.filter(|name| takes(name, key)).collect();
        let of = if of.len() == PATTERNS.len() {
            "all".to_owned()
        } else {
            of.join(", ")
        };
        format!("| `{key}` | {default} | {of} | {what} |")
    };
    let rows: Vec<_> = PARAMETERS.iter().map(row).collect();
    has_table("docs/scenes.md", "| parameter | default | of |", &rows);
    let told = good(root(), &["list", "patterns"]);
    for (key, default, what) in PARAMETERS {
        assert!(told.contains(&format!("{key}={default} ")), "{key}: {told}");
        assert!(told.contains(what), "{what}: {told}");
    }
}

#[test]
fn verbs() {
    let help = good(root(), &["help"]);
    let (_, list) = help.split_once("Commands:\n").unwrap();
    let verbs: Vec<_> = list
        .lines()
        .take_while(|line| line.starts_with("  "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|verb| *verb != "help")
        .collect();
    assert!(verbs.len() > 15);
    let page = fs::read_to_string(root().join("README.md")).unwrap();
    for verb in &verbs {
        let example = format!("amacrine {verb}");
        let shown = help.contains(&format!("  {example} ")) || *verb == "demo";
        assert!(shown, "no example of {verb} in the help");
        // Verbs of one family share a row.
        let row = page.contains(&format!("| `{example}")) || page.contains(&format!(", `{verb}`"));
        assert!(row, "README.md: {verb}");
    }
    let list = format!("verbs: {};", verbs.join(", "));
    assert!(page.contains(&list), "README.md: {list}");
}

/// Who may name a transfer: the command line and studies.
#[test]
fn transfers() {
    let help = good(root(), &["run", "--help"]);
    let schema = good(root(), &["schema", "study"]);
    for word in Transfer::WORDS {
        assert!(help.contains(&format!("- {word}:")), "run --help: {word}");
        assert!(schema.contains(&format!("\"{word}\"")), "study: {word}");
    }
}

fn is_rust(name: &str) -> bool {
    Path::new(name)
        .extension()
        .is_some_and(|ending| ending == "rs")
}

/// Each file of tests has its row in `tests/README.md`, in order, and no row is of a file that is gone.
#[test]
fn tests_are_listed() {
    let folder = root().join("tests");
    let mut files: Vec<String> = fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| is_rust(name))
        .collect();
    files.sort();
    let page = fs::read_to_string(folder.join("README.md")).unwrap();
    let rows = page.lines().filter_map(|line| line.strip_prefix("| `"));
    let names = rows.filter_map(|row| row.split_once('`'));
    let listed: Vec<&str> = names
        .map(|(name, _)| name)
        .filter(|name| is_rust(name))
        .collect();
    assert_eq!(listed, files);
}
