//! Texts as configuration files have them.

/// A text of TOML on one line: one of JSON, which leaves DEL as it is.
#[must_use]
pub fn on_one_line(text: &str) -> String {
    let text = serde_json::Value::from(text).to_string();
    text.replace('\u{7f}', "\\u007f")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_text_is_read_as_it_was() {
        for text in [
            "",
            "a \"b\" \\",
            "cafe\u{301}",
            "\u{7f}\u{0}\n\t",
            "\u{1f441}",
        ] {
            let line = on_one_line(text);
            assert!(!line.contains('\n'));
            let read: toml::Table = format!("it = {line}").parse().unwrap();
            assert_eq!(read["it"].as_str(), Some(text), "{line}");
        }
    }
}
