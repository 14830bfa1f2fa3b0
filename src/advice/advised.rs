//! An option that messages name.

/// An option that messages name, and how others say it.
#[derive(Clone, Copy, Debug)]
pub struct Advised {
    /// Without its dashes.
    pub option: &'static str,
    /// How a function of Python says it.
    pub python: InPython,
    /// How a study says it.
    pub study: InStudy,
    /// Words around it, and what Python says instead of all of them.
    pub phrases: &'static [(&'static str, &'static str)],
}

/// How a function of Python says an option.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InPython {
    /// An argument that is called as the option is, with underscores for dashes, and takes a word.
    Word,
    /// The same, of a number: words behind it go on with the sentence.
    Number,
    /// In other words, which its phrases have.
    Phrases,
    /// Not at all: who says it, and is not called from Python.
    Typed(&'static str),
}

/// How a study says an option.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InStudy {
    /// A key.
    Key(&'static str),
    /// It has none: what is advised is a run of another verb, or of `sweep` itself.
    None,
}

impl Advised {
    pub(super) const fn word(option: &'static str) -> Self {
        Self::new(option, InPython::Word)
    }

    pub(super) const fn number(option: &'static str) -> Self {
        Self::new(option, InPython::Number)
    }

    pub(super) const fn typed(option: &'static str, who: &'static str) -> Self {
        Self::new(option, InPython::Typed(who))
    }

    pub(super) const fn phrases(
        option: &'static str,
        phrases: &'static [(&'static str, &'static str)],
    ) -> Self {
        Self::new(option, InPython::Phrases).said(phrases)
    }

    const fn new(option: &'static str, python: InPython) -> Self {
        Self {
            option,
            python,
            study: InStudy::None,
            phrases: &[],
        }
    }

    /// The same, said in these words where they stand.
    pub(super) const fn said(self, phrases: &'static [(&'static str, &'static str)]) -> Self {
        Self { phrases, ..self }
    }

    /// The same, a key of a study.
    pub(super) const fn key(self, key: &'static str) -> Self {
        Self {
            study: InStudy::Key(key),
            ..self
        }
    }
}
