//! The text of a sensor file, and what points into it.

use std::ops::Range;

use super::{DescriptionError, ReadFile};

/// The file being read: knows how to point into it.
pub(super) struct Door<'a> {
    pub(super) file: &'a str,
    pub(super) text: &'a str,
    pub(super) read: &'a ReadFile<'a>,
}

/// What is missing, and how it might read.
const EXAMPLES: [(&str, &str); 6] = [
    ("response", "response = { linear = 255 }"),
    ("memory", "memory = \"filtered-step\""),
    ("threshold", "threshold = { on = 0.2, off = 0.2 }"),
    ("on", "on = 0.2"),
    ("off", "off = 0.2, a positive magnitude"),
    ("us", "us = 1000"),
];

impl Door<'_> {
    /// The text is not TOML.
    pub(super) fn syntax(&self, e: &toml::de::Error) -> DescriptionError {
        self.wrong(
            e.span().unwrap_or(0..0),
            &format!("not TOML: {}", e.message().trim()),
            "write key = value; words go in quotes, as in memory = \"filtered-step\"",
        )
    }

    /// The text is TOML, and a key is missing, unknown, or of another kind.
    pub(super) fn key(&self, e: &toml::de::Error) -> DescriptionError {
        let message = e.message().trim();
        let missing = message.strip_prefix("missing field `");
        let example = missing.and_then(|rest| {
            let (_, example) = EXAMPLES
                .iter()
                .find(|(key, _)| rest.strip_suffix('`') == Some(key))?;
            Some(format!("add it, such as {example}"))
        });
        let message = message
            .replace("missing field", "missing key")
            .replace("unknown field", "unknown key")
            .replace("unknown variant", "unknown value");
        let advice = example.unwrap_or("docs/reference.md lists every key of a sensor file".into());
        self.wrong(e.span().unwrap_or(0..0), &message, &advice)
    }

    /// Where `key` is given a value, from `start` on; there if it is not found.
    pub(super) fn place_of(&self, key: &str, start: usize) -> Range<usize> {
        let rest = self.text.get(start..).unwrap_or("");
        let given = |at: &usize| rest[at + key.len()..].trim_start().starts_with('=');
        let found = rest.match_indices(key).map(|(at, _)| at).find(given);
        found.map_or(start..start, |at| start + at..start + at + key.len())
    }

    pub(super) fn wrong(
        &self,
        span: Range<usize>,
        message: &str,
        advice: &str,
    ) -> DescriptionError {
        let before = self.text.get(..span.start).unwrap_or(self.text);
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        DescriptionError {
            file: self.file.to_owned(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            message: message.to_owned(),
            advice: Some(advice.to_owned()),
            source_code: miette::NamedSource::new(self.file, self.text.to_owned()).into(),
            span: (span.start, span.end.saturating_sub(span.start)).into(),
        }
    }
}
