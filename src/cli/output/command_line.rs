//! Words of a shell's command line.

use std::fmt;

/// A word as a shell takes it, or Windows's command prompt.
pub fn quoted(word: &str) -> String {
    let own = if cfg!(windows) { "\\" } else { "" };
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,:=@%+".contains(c) || own.contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else if cfg!(windows) {
        // A backslash before a quote stands for itself where there are two.
        let ends = word.len() - word.trim_end_matches('\\').len();
        format!("\"{}{}\"", word.replace('"', "\\\""), "\\".repeat(ends))
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// A command that is printed, to be given to a shell.
#[derive(Clone, Debug)]
pub struct CommandLine(String);

impl CommandLine {
    /// The program and its verb.
    pub fn new(verb: &str) -> Self {
        Self(format!("amacrine {verb}"))
    }

    /// What comes next.
    pub fn word(&mut self, word: &str) {
        self.0 += " ";
        self.0 += &quoted(word);
    }

    /// An option with its value.
    pub fn option(&mut self, name: &str, value: &str) {
        self.0 += " --";
        self.0 += name;
        self.word(value);
    }

    /// Several of them.
    pub fn options(&mut self, options: impl IntoIterator<Item = (&'static str, String)>) {
        for (name, value) in options {
            self.option(name, &value);
        }
    }
}

impl fmt::Display for CommandLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}
