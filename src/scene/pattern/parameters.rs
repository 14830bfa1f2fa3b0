//! The parameters of a pattern: each is taken once, and those left over are errors.

use std::{collections::BTreeMap, ops::RangeInclusive};

use crate::{config::asked, scene::SceneError};

/// The patterns: name, and what it is with the parameters that are its own.
pub const PATTERNS: [(&str, &str); 12] = [
    (
        "bar",
        "a bright bar, its middle in the middle at half time; thickness=10 px",
    ),
    (
        "edge",
        "a bright half-plane that comes in, its edge in the middle at half time",
    ),
    ("grating", "a sinusoid; period=20 px"),
    ("checker", "squares; square=16 px"),
    ("disc", "a bright disc with a sharp rim; radius=16 px"),
    ("spot", "a bright Gaussian; sigma=8 px"),
    ("noise", "random blobs that drift; grain=4 px, seed=1"),
    (
        "pan",
        "image=FILE drifts; border=replicate or wrap; without image as noise",
    ),
    (
        "rotate",
        "image=FILE or blobs turn about the middle; turn=90 degrees/s, clockwise",
    ),
    (
        "zoom",
        "image=FILE or blobs grow from the middle; growth=0.5 per second (exponent)",
    ),
    (
        "flicker",
        "uniform light that goes up and down; frequency=10 Hz, wave=sine or square",
    ),
    ("static", "image=FILE or blobs, at rest"),
];

/// The parameters of patterns: name, default, and what each is, with its unit.
pub const PARAMETERS: [(&str, &str, &str); 21] = [
    (
        "width",
        "128",
        "pixels; with an image, its own are the default",
    ),
    (
        "height",
        "128",
        "pixels; with an image, its own are the default",
    ),
    ("frames", "240", "how many there are"),
    ("fps", "240", "frames/s; --fps goes first"),
    (
        "low",
        "51",
        "the least light, of 0 to 255; not with an image",
    ),
    (
        "high",
        "204",
        "the most light, of 0 to 255; not with an image",
    ),
    ("speed", "60", "pixels/s"),
    ("angle", "0", "degrees, where to: 0 is right, 90 down"),
    ("thickness", "10", "pixels"),
    ("period", "20", "pixels"),
    ("square", "16", "pixels, the side of a square"),
    ("radius", "16", "pixels"),
    ("sigma", "8", "pixels, the standard deviation"),
    (
        "grain",
        "4",
        "pixels, the size of a blob; not with an image",
    ),
    ("seed", "1", "which blobs there are; not with an image"),
    (
        "image",
        "",
        "a PNG or PNM file that is shown instead of blobs",
    ),
    (
        "border",
        "replicate",
        "what is beyond the image: its border (replicate) or it again (wrap)",
    ),
    ("turn", "90", "degrees/s, clockwise"),
    ("growth", "0.5", "per second: sizes grow by e to this power"),
    ("frequency", "10", "hertz"),
    ("wave", "sine", "sine or square"),
];

/// The parameters given, and the names of those asked for so far.
pub(super) struct Parameters {
    /// The name of the pattern.
    pub pattern: String,
    given: BTreeMap<String, String>,
    /// `key=default` of all that were asked for.
    known: Vec<String>,
}

impl Parameters {
    /// Reads `key=value&key=value` for a pattern that must exist.
    pub fn parse(pattern: &str, text: &str) -> Result<Self, SceneError> {
        if !PATTERNS.iter().any(|(name, _)| *name == pattern) {
            let names: Vec<_> = PATTERNS.iter().map(|(name, _)| *name).collect();
            return Err(SceneError::UnknownPattern {
                got: pattern.into(),
                known: names.join(", "),
                near: asked(pattern, names),
            });
        }
        let wrong = |key: &str, got: &str, want: &str| SceneError::Parameter {
            pattern: pattern.into(),
            given: format!("{key}={got}"),
            want: want.into(),
            default: "leave a key out for its default".into(),
        };
        let mut given = BTreeMap::new();
        for word in text.split('&').filter(|word| !word.is_empty()) {
            let (key, value) = word.split_once('=').unwrap_or((word, ""));
            if value.is_empty() {
                return Err(wrong(key, value, "a value"));
            }
            if given.insert(key.to_owned(), value.to_owned()).is_some() {
                return Err(wrong(key, value, "each key once"));
            }
        }
        Ok(Self {
            pattern: pattern.into(),
            given,
            known: Vec::new(),
        })
    }

    /// Whether this pattern can show a picture.
    pub fn takes_image(&self) -> bool {
        matches!(self.pattern.as_str(), "pan" | "rotate" | "zoom" | "static")
    }

    /// A text, if given.
    pub fn text(&mut self, key: &str, default: &str) -> Option<String> {
        self.known.push(format!("{key}={default}"));
        self.given.remove(key)
    }

    /// One of a few words.
    pub fn choice<T: Copy>(&mut self, key: &str, words: [(&str, T); 2]) -> Result<T, SceneError> {
        let [(first, default), (second, other)] = words;
        match self.text(key, first) {
            None => Ok(default),
            Some(word) if word == first => Ok(default),
            Some(word) if word == second => Ok(other),
            Some(word) => Err(self.wrong(key, &word, format!("{first} or {second}"), first)),
        }
    }

    /// A real number in a range.
    pub fn real(
        &mut self,
        key: &str,
        default: f64,
        range: RangeInclusive<f64>,
    ) -> Result<f64, SceneError> {
        let Some(word) = self.text(key, &default.to_string()) else {
            return Ok(default);
        };
        match word.parse() {
            Ok(number) if range.contains(&number) => Ok(number),
            _ => {
                let want = format!("a number from {} to {}", range.start(), range.end());
                Err(self.wrong(key, &word, want, &default.to_string()))
            }
        }
    }

    /// A whole number in a range.
    pub fn whole(
        &mut self,
        key: &str,
        default: u64,
        range: RangeInclusive<u64>,
    ) -> Result<u64, SceneError> {
        let Some(word) = self.text(key, &default.to_string()) else {
            return Ok(default);
        };
        match word.parse() {
            Ok(number) if range.contains(&number) => Ok(number),
            _ => {
                let want = format!("a whole number from {} to {}", range.start(), range.end());
                Err(self.wrong(key, &word, want, &default.to_string()))
            }
        }
    }

    /// Refuses parameters that the pattern has not asked for; the names of those that it has.
    pub fn finish(self) -> Result<Vec<String>, SceneError> {
        match self.given.into_keys().next() {
            None => {
                let name = |known: &String| known.split('=').next().map(str::to_owned);
                Ok(self.known.iter().filter_map(name).collect())
            }
            Some(got) => Err(SceneError::UnknownParameter {
                pattern: self.pattern,
                near: asked(
                    &got,
                    self.known.iter().filter_map(|it| it.split('=').next()),
                ),
                known: self.known.join(", "),
                got,
            }),
        }
    }

    fn wrong(&self, key: &str, got: &str, want: String, default: &str) -> SceneError {
        SceneError::Parameter {
            pattern: self.pattern.clone(),
            given: format!("{key}={got}"),
            want,
            default: format!("the default is {key}={default}"),
        }
    }
}
