//! A folder of pictures, in the order in which a person would count them.

use std::{
    cmp::Ordering,
    collections::VecDeque,
    ffi::{OsStr, OsString},
    fs,
    path::{Path, PathBuf},
};

use super::still;
use crate::{
    limit::PICTURES,
    order::Order,
    plane::Size,
    scene::{
        Frame, Gap, OpenOptions, Outline, Scene, SceneError,
        checks::{self, MemoryLimit},
        light::conversion::Source,
        time::frame_rate::{Rate, check_rate},
    },
    source,
};

/// Extensions of the pictures that are read.
pub(super) const ENDINGS: [&str; 4] = ["png", "pgm", "ppm", "pnm"];

/// A folder being read.
struct Folder {
    path: PathBuf,
    /// Names of the pictures still to be read, in order.
    left: VecDeque<OsString>,
    room: MemoryLimit,
    count: u64,
    next: u64,
    size: Size,
    /// The first picture, read early for its size.
    first: Option<Frame>,
    rate: Rate,
    gap: Option<Gap>,
}

/// Opens a folder. What is said about its samples is what the first picture says.
pub(in crate::scene) fn open(
    path: &Path,
    options: OpenOptions,
) -> Result<(impl Scene + use<>, Source), SceneError> {
    let unreadable = |cause| SceneError::unreadable(path, cause);
    let mut pictures = Vec::new();
    for entry in fs::read_dir(path).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?.path();
        let name = entry.file_name().unwrap_or_default().to_string_lossy();
        if name.starts_with('.') {
            continue;
        }
        let ending = entry.extension().unwrap_or_default().to_ascii_lowercase();
        if entry.is_dir() || !ENDINGS.iter().any(|known| ending == *known) {
            let fps = stated_rate(&entry);
            return Err(SceneError::NotAPicture { path: entry, fps });
        }
        if pictures.len() == PICTURES {
            return Err(SceneError::TooManyFrames {
                path: path.into(),
                most: PICTURES as u64,
            });
        }
        pictures.extend(entry.file_name().map(OsStr::to_owned));
    }
    let gap = put_in_order(&mut pictures);
    let room = MemoryLimit::new(options);
    let mut left = VecDeque::from(pictures);
    let count = left.len() as u64;
    let Some(first) = left.pop_front() else {
        return Err(SceneError::Empty {
            path: path.into(),
            missing: "picture",
        });
    };
    let (light, source) = still::read_with_source(&path.join(first), 0, room)?;
    let folder = Folder {
        path: path.into(),
        room,
        left,
        count,
        next: 1,
        size: light.size(),
        first: Some(Frame {
            index: 0,
            seconds: 0.0,
            light,
        }),
        rate: Rate::asked_or_assumed(options.fps),
        gap,
    };
    Ok((folder, source))
}

impl Scene for Folder {
    fn outline(&self) -> Outline {
        // Names are kept: some tens of bytes each.
        let names = 96 * u128::from(self.count);
        let pixel = still::MOST_CODED + checks::PIXEL_BYTES_HELD;
        Outline {
            frames: Some(self.count),
            gap: self.gap,
            bytes: names + pixel * self.size.pixels() as u128,
            ..Outline::at(self.rate, self.size)
        }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        if let Some(first) = self.first.take() {
            return Ok(Some(first));
        }
        let Some(name) = self.left.pop_front() else {
            return Ok(None);
        };
        let path = self.path.join(name);
        let index = self.next;
        let light = still::read(&path, index, self.room)?;
        if light.size() != self.size {
            return Err(SceneError::OddSize {
                path,
                frame: index,
                got: light.size(),
                want: self.size,
            });
        }
        self.next += 1;
        Ok(Some(Frame {
            index,
            seconds: self.rate.seconds(index),
            light,
        }))
    }
}

/// The frames per second that vid2e's `fps.txt` says; none of any other file.
fn stated_rate(path: &Path) -> Option<f64> {
    if path.file_name() != Some(OsStr::new("fps.txt")) {
        return None;
    }
    let text = source::text(path, "").ok()?;
    let fps = text.split_whitespace().next()?.parse().ok()?;
    check_rate(fps).is_ok().then_some(fps)
}

/// Puts pictures in their order; what is missing among their numbers.
fn put_in_order(pictures: &mut [OsString]) -> Option<Gap> {
    let names = pictures.iter().map(|name| name.to_string_lossy());
    if are_decimal(&names.collect::<Vec<_>>()) {
        // Times, which need not be evenly spaced.
        pictures.order_by(|a, b| decimal(&a.to_string_lossy(), &b.to_string_lossy()));
        return None;
    }
    pictures.order_by(|a, b| natural(&a.to_string_lossy(), &b.to_string_lossy()));
    let numbers: Option<Vec<u64>> = pictures
        .iter()
        .map(|name| number(&name.to_string_lossy()))
        .collect();
    numbers.and_then(|numbers| Gap::find(&numbers))
}

/// A name before its ending.
fn stem(name: &str) -> &str {
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}

/// The digits before and behind the point of a name that is a decimal number: `0.15.png`.
fn parts(name: &str) -> Option<(&str, &str)> {
    let are_digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let (whole, part) = stem(name).split_once('.')?;
    (are_digits(whole) && are_digits(part)).then_some((whole, part))
}

/// Whether all names are decimal numbers, as 0.0, 0.05, 0.1, and not counted in two parts, as 1.9,
/// 1.10: a decimal of so many digits as it needs does not end in 0.
fn are_decimal(names: &[impl AsRef<str>]) -> bool {
    let parts: Option<Vec<_>> = names.iter().map(|name| parts(name.as_ref())).collect();
    parts.is_some_and(|parts| {
        let digits = parts.first().map(|(_, part)| part.len());
        let are_even = parts.iter().all(|(_, part)| Some(part.len()) == digits);
        are_even || !{ parts.iter() }.any(|(_, part)| part.len() > 1 && part.ends_with('0'))
    })
}

/// By their values; names of one value as text.
fn decimal(a: &str, b: &str) -> Ordering {
    let value = |name| {
        let (whole, part) = parts(name)?;
        let whole = whole.trim_start_matches('0');
        // Behind the point, text order is the order of values.
        Some((whole.len(), whole, part.trim_end_matches('0')))
    };
    value(a).cmp(&value(b)).then_with(|| a.cmp(b))
}

/// The number of a picture: the last digits of its name before its ending.
fn number(name: &str) -> Option<u64> {
    let stem = stem(name);
    let end = stem.trim_end_matches(|c: char| !c.is_ascii_digit());
    let start = end.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    end[start..].parse().ok()
}

/// Text order, but runs of digits by their value: `f2` before `f10`.
fn natural(a: &str, b: &str) -> Ordering {
    let (mut left, mut right) = (a, b);
    loop {
        let (x, rest_x) = word(left);
        let (y, rest_y) = word(right);
        let order = match (digits(x), digits(y)) {
            // Without leading zeros, the longer run is the larger number.
            (Some(m), Some(n)) => m.len().cmp(&n.len()).then_with(|| m.cmp(n)),
            _ => x.cmp(y),
        };
        if order.is_ne() {
            return order;
        }
        if x.is_empty() {
            // `1.png` and `01.png` are one number: the text decides.
            return a.cmp(b);
        }
        (left, right) = (rest_x, rest_y);
    }
}

/// Splits off the first run of digits, or of anything but digits.
fn word(text: &str) -> (&str, &str) {
    let is_digit = |c: char| c.is_ascii_digit();
    let first = text.starts_with(is_digit);
    let end = text.find(|c| is_digit(c) != first).unwrap_or(text.len());
    text.split_at(end)
}

/// A run of digits without its leading zeros.
fn digits(word: &str) -> Option<&str> {
    word.starts_with(|c: char| c.is_ascii_digit())
        .then(|| word.trim_start_matches('0'))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn numbers_are_counted() {
        let mut names = [
            "f10",
            "f9",
            "f1b",
            "f1a2",
            "f1a10",
            "g",
            "f",
            "f009x",
            "f99999999999999999999",
        ];
        names.order_by(|a, b| natural(a, b));
        assert_eq!(
            names,
            [
                "f",
                "f1a2",
                "f1a10",
                "f1b",
                "f9",
                "f009x",
                "f10",
                "f99999999999999999999",
                "g"
            ]
        );
    }

    #[test]
    fn decimals_go_by_their_values() {
        let order = |names: &[&str]| {
            let mut names: Vec<OsString> = names.iter().map(OsString::from).collect();
            put_in_order(&mut names);
            let names = names.iter().map(|name| name.to_string_lossy().into_owned());
            names.collect::<Vec<_>>()
        };
        let times = [
            "0.0.png",
            "0.05.png",
            "0.1.png",
            "0.15.png",
            "0.15000000000000002.png",
            "0.2.png",
            "0.25.png",
            "1.0.png",
            "1.05.png",
            "10.0.png",
        ];
        let mut turned = times;
        turned.reverse();
        assert_eq!(order(&turned), times);
        assert_eq!(order(&["1.50.png", "1.05.png"]), ["1.05.png", "1.50.png"]);
        // Part and number, and names with anything else.
        let counted = ["1.1.png", "1.2.png", "1.9.png", "1.10.png", "1.11.png"];
        assert_eq!(order(&counted), counted);
        let mixed = ["0.5.png", "0.10.png", "f.png"];
        assert_eq!(order(&mixed), mixed);
    }

    #[test]
    fn missing_numbers_are_found() {
        let gap = |names: &[&str]| {
            let numbers: Option<Vec<u64>> = names.iter().map(|name| number(name)).collect();
            let gap = numbers.and_then(|numbers| Gap::find(&numbers));
            gap.map(|gap| (gap.before, gap.after, gap.missing))
        };
        let names = [
            "f002", "f003", "f004", "f008", "f009", "f010", "f012", "f013", "f014",
        ];
        assert_eq!(gap(&names), Some((4, 8, 4)));
        assert_eq!(
            gap(&["2_4a.png", "2_8a.png", "2_12a.png", "2_16a.png"]),
            None
        );
        assert_eq!(gap(&["a0", "a2", "a4", "a6", "a10"]), Some((6, 10, 1)));
        // Times, names, one number twice, one picture.
        assert_eq!(gap(&["100", "133", "167", "200", "290"]), None);
        assert_eq!(gap(&["a", "b"]), None);
        assert_eq!(gap(&["1", "1b", "2", "9"]), None);
        assert_eq!(gap(&["7"]), None);
    }

    proptest! {
        #[test]
        fn it_is_an_order(a in "[a01.é]{0,6}", b in "[a01.é]{0,6}", c in "[a01.é]{0,6}") {
            prop_assert_eq!(natural(&a, &b), natural(&b, &a).reverse());
            prop_assert_eq!(natural(&a, &b).is_eq(), a == b);
            if natural(&a, &b).is_le() && natural(&b, &c).is_le() {
                prop_assert!(natural(&a, &c).is_le());
            }
        }
    }
}
