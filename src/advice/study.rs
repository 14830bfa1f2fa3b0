//! Messages in the words of a study.

use std::fmt::Write as _;

use super::{InPython, InStudy, OPTIONS, is_command};

/// Words around options, and what a study says instead.
const PHRASES: [(&str, &str); 8] = [
    ("; --objective words compiles it as it is", ""),
    ("(--slice, or `slice` in a study", "(`slice`"),
    ("(--within, in a study `within`)", "(`within`)"),
    ("(`--upsample`, or `upsample` in a study)", "(`upsample`)"),
    ("programs and --chip then", "programs and `chip` then"),
    ("leave --range out", "leave `range` out"),
    ("--transfer undoes it", "`transfer` undoes it"),
    (
        "search longer (--effort)",
        "search longer (`amacrine compile --effort`)",
    ),
];

/// Advice in the words of a study: `memory = "bits:5"` in place of `--memory bits:5`. Options for which
/// a study has no key, and commands in backticks, are left as they are.
#[must_use]
pub fn in_study(text: &str) -> String {
    let mut text = text.to_owned();
    for (option, key) in PHRASES {
        text = text.replace(option, key);
    }
    let parts = text.split('`').enumerate().map(|(n, part)| {
        if is_command(n, part) {
            part.to_owned()
        } else {
            in_keys(part)
        }
    });
    parts.collect::<Vec<_>>().join("`")
}

/// The key of an option, and whether it takes a word.
fn key(option: &str) -> Option<(&'static str, bool)> {
    let option = option.strip_prefix("--")?;
    let advised = OPTIONS.iter().find(|advised| advised.option == option)?;
    match advised.study {
        InStudy::Key(key) => Some((key, advised.python == InPython::Word)),
        InStudy::None => None,
    }
}

/// What stands between backticks, or in them.
fn in_keys(text: &str) -> String {
    let mut said = String::new();
    let mut words = text.split(' ').peekable();
    let mut is_first = true;
    while let Some(word) = words.next() {
        if !is_first {
            said.push(' ');
        }
        is_first = false;
        let bare = word.trim_matches(['(', ')', ',', ';', ':', '.']);
        let Some((key, takes_word)) = key(bare) else {
            said += word;
            continue;
        };
        said += &word.replace(bare, key);
        // Behind a comma or a bracket the sentence goes on.
        let bare_of = |next: &str| next.trim_end_matches([',', ')', ';', '.']).len();
        let stands_for_one = |next: &str| {
            let name = &next[..bare_of(next)];
            !name.is_empty() && name.chars().all(|c| c.is_ascii_uppercase())
        };
        let begins = |c: char| c.is_ascii_digit() || takes_word && c.is_ascii_alphabetic();
        let is_value = |next: &&str| {
            word.ends_with(bare) && (next.starts_with(begins) || stands_for_one(next))
        };
        if let Some(next) = words.next_if(is_value) {
            let (value, rest) = next.split_at(bare_of(next));
            let is_number = value.parse::<f64>().is_ok() || stands_for_one(value);
            let quote = if is_number { "" } else { "\"" };
            let _ = write!(said, " = {quote}{value}{quote}{rest}");
        }
    }
    said
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_of_compile_become_keys_of_a_study() {
        for (help, told) in [
            (
                "give all kinds one memory (--memory shared, which is `raw-snap`); or hold them in registers (--memory bits:5)",
                "give all kinds one memory (memory = \"shared\", which is `raw-snap`); or hold them in registers (memory = \"bits:5\")",
            ),
            (
                "quantise the kernel with --to (ternary, po2-3), or try --chip scamp5-wide",
                "quantise the kernel with quantise (ternary, po2-3), or try chip = \"scamp5-wide\"",
            ),
            ("ask for 5 kinds", "ask for 5 kinds"),
            ("say it: --fps N", "say it: fps = N"),
            (
                "as in --fps 240, or --slice 2s..5s.",
                "as in fps = 240, or slice = \"2s..5s\".",
            ),
            (
                "leave the sum free (--sum free), or search longer (--effort); `exec --fps 9`",
                "leave the sum free (sum = \"free\"), or search longer (`amacrine compile --effort`); `exec --fps 9`",
            ),
            (
                "use fewer digits (--to), or another chip (--chip)",
                "use fewer digits (quantise), or another chip (chip)",
            ),
        ] {
            assert_eq!(in_study(help), told);
        }
    }
}
