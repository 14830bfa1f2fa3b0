//! Words and keys that are not known, and what is near to them.

use super::{
    document::Name,
    fault::{Fault, Read},
    kind::listed,
    nearest::suggestion_or,
    place::Place,
};

/// Which of these words it is.
///
/// # Errors
/// When it is none; `see` is said where no word is near.
pub fn choice(word: &str, words: &[&str], place: Place, see: &str) -> Read<usize> {
    words
        .iter()
        .position(|known| *known == word)
        .ok_or_else(|| {
            let message = format!(
                "unknown value `{word}`, expected {}",
                listed(words.iter().copied())
            );
            let help = suggestion_or(word, words.iter().copied(), see);
            Fault::error(place, message, "not known here").help(help)
        })
}

/// The fault of a key that is none of the known ones; `see` is said where none is near.
pub fn unknown_key(
    name: Name<'_>,
    known: impl Iterator<Item = &'static str> + Clone,
    see: &str,
) -> Fault {
    let message = format!(
        "unknown key `{}`, expected {}",
        name.text,
        listed(known.clone())
    );
    let help = suggestion_or(name.text, known, see);
    Fault::error(name.place, message, "not known here").help(help)
}
