//! A file and what it includes, as one space of places: those of the file itself first.

use std::{collections::BTreeMap, sync::Arc};

use crate::config::{Fault, Place, line_column};

/// Texts by the names with which `#include "…"` asks for them.
pub type Includes = BTreeMap<String, Lying>;

/// A text that lies beside a program.
#[derive(Clone, Debug)]
pub struct Lying {
    pub(super) text: Arc<str>,
    /// The file that it was read from, for messages, where that is known.
    pub(super) file: Option<Arc<str>>,
}

impl Lying {
    /// The text of a file, by the name that messages have for it.
    #[must_use]
    pub fn read(text: &str, file: &str) -> Self {
        Self {
            text: text.into(),
            file: Some(file.into()),
        }
    }
}

impl From<Arc<str>> for Lying {
    fn from(text: Arc<str>) -> Self {
        Self { text, file: None }
    }
}

impl From<&str> for Lying {
    fn from(text: &str) -> Self {
        Arc::<str>::from(text).into()
    }
}

impl From<String> for Lying {
    fn from(text: String) -> Self {
        Arc::<str>::from(text).into()
    }
}

/// The files that may hold the bodies of what a header declares.
pub(super) fn bodies(header: &str) -> Vec<String> {
    match header.rsplit_once('.') {
        Some((stem, "hpp" | "hh" | "hxx" | "h")) => named(stem).to_vec(),
        _ => Vec::new(),
    }
}

/// The files that may hold what has this name.
pub(super) fn named(stem: &str) -> [String; 4] {
    ["cpp", "cc", "cxx", "c"].map(|it| format!("{stem}.{it}"))
}

/// A file's name without the folders before it.
pub(super) fn plain(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

/// The line around a byte of a text, without the space around it; of a long one the beginning.
fn line_of(text: &str, at: usize) -> String {
    const LONGEST: usize = 80;
    let (line, _) = line_column(text, at);
    let line = text
        .lines()
        .nth(line as usize - 1)
        .unwrap_or_default()
        .trim();
    match line.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{} …", &line[..end]),
        None => line.to_owned(),
    }
}

/// The texts, one behind the other.
#[derive(Clone, Debug)]
pub(in crate::program::vendor) struct Files {
    /// The name of the file itself, and its bytes.
    own: String,
    length: usize,
    included: Vec<Included>,
    /// The first free byte.
    end: usize,
}

#[derive(Clone, Debug)]
struct Included {
    name: String,
    text: Arc<str>,
    start: usize,
    /// Where it was asked for.
    asked: Place,
}

impl Files {
    pub(in crate::program::vendor) fn new(name: &str, length: usize) -> Self {
        Self {
            own: name.to_owned(),
            length,
            included: Vec::new(),
            end: length + 1,
        }
    }

    /// Adds a text that is asked for; the byte at which it begins.
    pub(super) fn add(&mut self, name: &str, text: &Arc<str>, asked: Place) -> usize {
        let start = self.end;
        self.end += text.len() + 1;
        let asked = self.own(asked);
        self.included.push(Included {
            name: name.to_owned(),
            text: Arc::clone(text),
            start,
            asked,
        });
        start
    }

    fn of(&self, place: Place) -> Option<&Included> {
        if place.start <= self.length {
            return None;
        }
        let after = self.included.partition_point(|it| it.start <= place.start);
        self.included.get(after.checked_sub(1)?)
    }

    /// The name of the file that a place lies in; nothing for the file itself.
    pub(in crate::program::vendor) fn name(&self, place: Place) -> Option<&str> {
        self.of(place).map(|it| &*it.name)
    }

    /// The file that a place lies in, and its line there.
    pub(super) fn stands(&self, text: &str, place: Place) -> (&str, u32) {
        match self.of(place) {
            None => (&self.own, line_column(text, place.start).0),
            Some(it) => (&it.name, line_column(&it.text, place.start - it.start).0),
        }
    }

    /// What is written at a place; `text` is that of the file itself.
    pub(in crate::program::vendor) fn written<'t>(
        &'t self,
        text: &'t str,
        place: Place,
    ) -> &'t str {
        let (text, start) = match self.of(place) {
            None => (text, 0),
            Some(it) => (&*it.text, it.start),
        };
        let [start, end] = [place.start, place.end].map(|at| at.saturating_sub(start));
        text.get(start..end).unwrap_or_default()
    }

    /// A place of the file itself: for what is included, where it is asked for.
    pub(in crate::program::vendor) fn own(&self, place: Place) -> Place {
        self.of(place).map_or(place, |it| it.asked)
    }

    /// A place in what is included: `file:line:column`.
    pub(in crate::program::vendor) fn origin(&self, place: Place) -> Option<String> {
        let it = self.of(place)?;
        let (line, column) = line_column(&it.text, place.start - it.start);
        Some(format!("{}:{line}:{column}", it.name))
    }

    /// The line of a place in its own file, with the file's name where that is another.
    pub(in crate::program::vendor) fn line(&self, text: &str, place: Place) -> String {
        let (name, line) = self.stands(text, place);
        match self.of(place) {
            None => format!("line {line}"),
            Some(_) => format!("{name}:{line}"),
        }
    }

    /// A fault with a place of the file itself; one in what is included says where it is.
    pub(in crate::program::vendor) fn fault(&self, fault: Fault) -> Fault {
        let also = fault.also.map(|also| Box::new((self.own(also.0), also.1)));
        match self.of(fault.place) {
            None => Fault { also, ..fault },
            Some(it) => {
                let origin = self.origin(fault.place).unwrap_or_default();
                Fault {
                    message: format!("{origin}: {}", fault.message),
                    place: it.asked,
                    label: format!(
                        "{} is asked for here, and its line is `{}`",
                        it.name,
                        line_of(&it.text, fault.place.start - it.start)
                    ),
                    also,
                    ..fault
                }
            }
        }
    }
}
