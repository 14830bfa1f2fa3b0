//! The options of the command line in the words of Python.

use amacrine::rig::guard::Warning;
use pyo3::prelude::*;

/// What the library says of options that have no argument of their own here, and what is said
/// instead.
const PHRASES: [(&str, &str); 28] = [
    (
        "the limit (--max-events, and --max-memory where there is no room for more); \
         `amacrine run` also has --counts and --voxels instead of --events, and --when-full drop",
        "the limit (max_events), or take counts, or voxels without bins, which need no list",
    ),
    ("`amacrine convert` also takes --format", "or give format"),
    (
        "or tell `amacrine convert` what it writes: --format NAME",
        "or give format",
    ),
    (
        "or tell `amacrine convert` what it reads: --from NAME",
        "or give format",
    ),
    (
        "or one kind with `convert --kind N`, or one file a kind with `convert --each-kind`",
        "or one kind: events[events['channel'] == 0][['t', 'x', 'y', 'p']]",
    ),
    (
        "say which with `amacrine convert --from NAME`",
        "say which: format=NAME",
    ),
    ("(or `--from`)", "(or format)"),
    (
        "--clip on or --domain silicon",
        "clip=True or domain=\"silicon\"",
    ),
    (
        "(`convert --from-zero`), and cut what is longer (`--slice`)",
        "(events['t'] - events['t'].min()), and cut what is longer",
    ),
    ("(`--upsample`, or `upsample` in a study)", "(upsample)"),
    (
        "(--slice, or `slice` in a study, in frames of the clip)",
        "(slice of load, and of a study, in frames of the clip)",
    ),
    (", or `slice` in a study", " of load, and of a study"),
    ("(--slice)", "(slice of load)"),
    (
        "(in the sensor file, or run --sigma)",
        "(in thresholds, or the sensor file)",
    ),
    (
        "--stream N, in Python read(path, stream=N)",
        "read(path, stream=N)",
    ),
    (
        "; a sensor beside a packet needs a scene (`--scene`) of the packet's size",
        "",
    ),
    ("; --objective words compiles it as it is", ""),
    (
        "raise --max-memory, or lower --jobs: points share it",
        "lower jobs: points share the memory",
    ),
    (
        "; --space lists them",
        "; `amacrine sweep --space` lists them",
    ),
    ("--shard of a search", "shards of a search"),
    (
        "leave --shard out, or sweep the whole grid on several machines",
        "leave client out, or take the whole grid",
    ),
    ("(--readout overlapped)", "(overlapped=True)"),
    ("(--readout sequential)", "(overlapped=False)"),
    ("--verify measures them", "verify=True measures them"),
    ("--runs N shares them", "runs=N shares them"),
    ("--threshold", "thresholds"),
    ("--kernel ", "kernels "),
    ("--const ", "constants "),
];

/// Arguments of Python that are called as the option is, with underscores for dashes. Those that
/// are true take a word; behind the others a word goes on with the sentence.
const ARGUMENTS: [(&str, bool); 36] = [
    ("bins", false),
    ("candidates", false),
    ("chip", true),
    ("chips", false),
    ("compression", true),
    ("crop", true),
    ("domain", true),
    ("effort", false),
    ("events-per-frame", false),
    ("exposure", false),
    ("format", true),
    ("fps", false),
    ("jobs", false),
    ("link-energy", false),
    ("max-events", false),
    ("max-seconds-per-point", false),
    ("memory", true),
    ("objective", true),
    ("output", false),
    ("rate", false),
    ("resize", true),
    ("range", true),
    ("sample", false),
    ("scale", false),
    ("seed", false),
    ("sensor", false),
    ("sigma", false),
    ("size", false),
    ("slice", true),
    ("stream", false),
    ("sum", true),
    ("to", true),
    ("transfer", true),
    ("upsample", false),
    ("within", false),
    ("without", true),
];

/// What a message of too much memory ends with: there is no such argument.
const MORE_MEMORY: &str = ", or allow more with --max-memory";

/// A message of the library, with arguments in place of options. Commands in backticks are typed in
/// a terminal: they are left as they are, but for the name of the program.
pub fn in_python(text: &str) -> String {
    let mut text = text.to_owned();
    if let Some(at) = text.find(MORE_MEMORY) {
        let end = text[at..].find('\n').map_or(text.len(), |line| at + line);
        text.replace_range(at..end, "");
    }
    for (option, argument) in PHRASES {
        text = text.replace(option, argument);
    }
    let parts = text.split('`').enumerate().map(|(n, part)| {
        let is_command = n % 2 == 1 && !part.starts_with("--");
        if is_command && is_of_verb(part) {
            format!("amacrine {part}")
        } else if is_command {
            part.to_owned()
        } else {
            renamed(part)
        }
    });
    parts.collect::<Vec<_>>().join("`")
}

/// The same for texts that come as JSON.
#[pyfunction]
#[pyo3(name = "in_python")]
pub fn in_words(text: &str) -> String {
    in_python(text)
}

/// Warns whoever called the function of Python that called.
pub fn caution(py: Python<'_>, warning: &Warning) -> PyResult<()> {
    note(py, &warning.to_string())
}

/// The same of what the command line notes.
pub fn note(py: Python<'_>, text: &str) -> PyResult<()> {
    let words = in_python(text);
    py.import("amacrine.caution")?
        .call_method1("caution", (words,))?;
    Ok(())
}

/// Whether a command begins with a verb of the program: `exec --set …`.
fn is_of_verb(command: &str) -> bool {
    let verb = command.split_once(" --").map_or("", |(verb, _)| verb);
    !verb.is_empty() && verb.bytes().all(|letter| letter.is_ascii_lowercase())
}

/// What stands between backticks, or in them.
fn renamed(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(at) = rest.find("--") {
        let (before, found) = rest.split_at(at);
        out.push_str(before);
        let name = &found[2..];
        let end = name
            .find(|c: char| !(c.is_ascii_lowercase() || c == '-'))
            .unwrap_or(name.len());
        let (name, after) = name.split_at(end);
        if let Some((call, behind)) = of_sensor(&out, name, after) {
            out += &call;
            rest = behind;
            continue;
        }
        let Some((_, is_word)) = ARGUMENTS.iter().find(|(known, _)| *known == name) else {
            out.push_str("--");
            out.push_str(name);
            rest = after;
            continue;
        };
        out.push_str(&name.replace('-', "_"));
        rest = after;
        if let Some(value) = value(after, *is_word) {
            out.push('=');
            let quote = if *is_word && !is_placeholder(value) {
                "\""
            } else {
                ""
            };
            out.extend([quote, value, quote]);
            rest = &after[1 + value.len()..];
        }
    }
    out.push_str(rest);
    out
}

/// `(--without leak,mismatch)`, which of a sensor is a call of its own, and what stands behind it.
fn of_sensor<'a>(before: &str, name: &str, after: &'a str) -> Option<(String, &'a str)> {
    if name != "without" || !before.ends_with('(') {
        return None;
    }
    let (effects, _) = after.strip_prefix(' ')?.split_once(')')?;
    let each: Vec<_> = effects.split(',').map(|one| format!("\"{one}\"")).collect();
    let behind = &after[1 + effects.len()..];
    Some((format!("sensor.without({})", each.join(", ")), behind))
}

/// What an option is given: a number, a placeholder, or a word where it takes one.
fn value(after: &str, is_word: bool) -> Option<&str> {
    let after = after.strip_prefix(' ')?;
    let end = after
        .find(|c: char| !(c.is_ascii_alphanumeric() || matches!(c, '-' | ':' | '.')))
        .unwrap_or(after.len());
    // Of a slice the points are a part.
    let value = match &after[..end] {
        slice if slice.ends_with("..") => slice,
        word => word.trim_end_matches(['.', ':']),
    };
    let is_number = value.parse::<f64>().is_ok();
    (!value.is_empty() && (is_number || is_word || is_placeholder(value))).then_some(value)
}

fn is_placeholder(value: &str) -> bool {
    value.chars().all(|c| c.is_ascii_uppercase())
}
