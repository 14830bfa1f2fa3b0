//! Words that stand for the variants of an enum.

/// A word that stands for nothing in a list.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("`{word}` is no {what}")]
#[diagnostic(help("{help}"))]
pub struct UnknownWord {
    /// What was given.
    pub word: String,
    /// What it should be.
    pub what: &'static str,
    /// The words that there are.
    pub help: String,
}

/// The variant that a word stands for.
///
/// # Errors
/// When it stands for none.
pub fn variant<T: Copy>(
    word: &str,
    what: &'static str,
    (all, words): (&[T], &[&str]),
) -> Result<T, UnknownWord> {
    let mut pairs = all.iter().zip(words);
    let found = pairs.find(|(_, known)| **known == word);
    found.map(|(one, _)| *one).ok_or_else(|| UnknownWord {
        word: word.to_owned(),
        what,
        help: match words {
            [first @ .., last] if !first.is_empty() => {
                format!("give {} or {last}", first.join(", "))
            }
            words => format!("give {}", words.join(", ")),
        },
    })
}

/// An enum, the list of its variants and how each is written, from one list; with `= what` behind its
/// name, it is read from a word, too.
macro_rules! listed {
    ($(#[$outer:meta])* pub enum $name:ident = $what:literal { $($rest:tt)* }) => {
        $crate::config::listed! { $(#[$outer])* pub enum $name { $($rest)* } }

        impl std::str::FromStr for $name {
            type Err = $crate::config::UnknownWord;

            fn from_str(word: &str) -> Result<Self, Self::Err> {
                $crate::config::variant(word, $what, (Self::ALL, Self::WORDS))
            }
        }
    };
    ($(#[$outer:meta])* pub enum $name:ident { $($(#[$doc:meta])* $variant:ident = $word:literal,)* }) => {
        $(#[$outer])*
        pub enum $name { $($(#[$doc])* $variant,)* }

        impl $name {
            /// All of them, in order.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// How they are written, in the same order.
            pub const WORDS: &'static [&'static str] = &[$($word),*];

            /// How it is written.
            #[must_use]
            pub const fn word(self) -> &'static str {
                match self { $(Self::$variant => $word,)* }
            }
        }
    };
}

pub(crate) use listed;

#[cfg(test)]
mod tests {
    use std::{fmt::Debug, str::FromStr};

    use super::UnknownWord;
    use crate::{
        compile::Objective,
        kernel::quantise::Sum,
        scene::{Range, Transfer},
    };

    fn reads<T: Copy + Debug + PartialEq + FromStr<Err = UnknownWord>>(
        (all, words): (&[T], &[&str]),
        told: &str,
    ) {
        for (one, word) in all.iter().zip(words) {
            assert_eq!(word.parse::<T>(), Ok(*one));
        }
        let unknown = "nothing".parse::<T>().unwrap_err();
        assert_eq!(format!("{unknown}: {}", unknown.help), told);
    }

    #[test]
    fn words_are_read() {
        reads(
            (Sum::ALL, Sum::WORDS),
            "`nothing` is no sum: give free, zero or kept",
        );
        reads(
            (Objective::ALL, Objective::WORDS),
            "`nothing` is no objective: give silicon, events, exact or words",
        );
        reads(
            (Range::ALL, Range::WORDS),
            "`nothing` is no range: give limited or full",
        );
        reads(
            (Transfer::ALL, Transfer::WORDS),
            "`nothing` is no transfer: give as-coded, linear, srgb, bt709, gamma22, gamma28 or smpte240m",
        );
    }
}
