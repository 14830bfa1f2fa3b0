//! The patterns and their parameters, as text.

use std::fmt::Write as _;

use super::{PARAMETERS, PATTERNS, Pattern};
use crate::scene::SceneError;

/// All patterns, and all parameters, as text.
#[must_use]
pub fn all() -> String {
    let mut text = String::new();
    for (name, what) in PATTERNS {
        let _ = writeln!(text, "{name:<10}{what}");
    }
    text += "\nParameters, given as pattern:NAME?key=value&key=value; `amacrine list patterns NAME` has those of one:\n\n";
    for parameter in PARAMETERS {
        line(&mut text, parameter);
    }
    text
}

/// One pattern, and what it takes, as text.
///
/// # Errors
/// When there is none of this name.
pub fn one(name: &str) -> Result<String, SceneError> {
    let mut keys = Pattern::parameters(name)?;
    if keys.iter().any(|key| key == "image") {
        keys.push("border".to_owned());
    }
    let what = PATTERNS.iter().find(|(known, _)| *known == name);
    let mut text = format!("pattern:{name}: {}\n\n", what.map_or("", |(_, what)| what));
    for parameter in PARAMETERS {
        if keys.iter().any(|key| key == parameter.0) {
            line(&mut text, parameter);
        }
    }
    Ok(text)
}

fn line(text: &mut String, (key, default, what): (&str, &str, &str)) {
    let given = format!("{key}={default}");
    let _ = writeln!(text, "{given:<18}{what}");
}
