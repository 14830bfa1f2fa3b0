//! Why a point has no result.

use std::fmt::Write as _;

use miette::Diagnostic;

/// Why a point has no figures.
#[derive(Clone, Debug)]
pub(in crate::study::sweep) enum Refusal {
    /// It cannot be, here or elsewhere.
    Cannot(String),
    /// It was given up: with more time or memory it may be.
    GivenUp(String),
}

impl Refusal {
    /// Of what may be mended until the next run.
    pub fn given_up(error: &impl Diagnostic) -> Self {
        let help = error.help().map(|help| format!(" ({help})"));
        Self::GivenUp(format!("{error}{}", help.unwrap_or_default()))
    }
}

impl<E: Diagnostic> From<E> for Refusal {
    fn from(error: E) -> Self {
        let help = error
            .help()
            .map(|help| format!(" ({})", in_keys(&help.to_string())));
        Self::Cannot(format!("{error}{}", help.unwrap_or_default()))
    }
}

/// Options of `compile` that errors advise, and the keys of a study that ask for the same.
const KEYS: [(&str, &str); 4] = [
    ("--memory", "memory"),
    ("--to", "quantise"),
    ("--chip", "chip"),
    ("--threshold", "threshold"),
];

/// Advice in the words of a study: `memory = "bits:5"` in place of `--memory bits:5`.
fn in_keys(help: &str) -> String {
    let mut said = String::new();
    let mut words = help.split(' ').peekable();
    while let Some(word) = words.next() {
        if !said.is_empty() {
            said.push(' ');
        }
        let bare = word.trim_start_matches('(');
        let Some((_, key)) = KEYS.iter().find(|(option, _)| *option == bare) else {
            said += word;
            continue;
        };
        said += &word.replace(bare, key);
        let is_value = |next: &&str| next.starts_with(|c: char| c.is_ascii_alphanumeric());
        if let Some(next) = words.next_if(is_value) {
            let value = next.trim_end_matches([',', ')', ';']);
            let _ = write!(said, " = \"{value}\"{}", &next[value.len()..]);
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
        ] {
            assert_eq!(in_keys(help), told);
        }
    }
}
