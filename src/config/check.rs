//! Values against the description of their keys.

use super::{
    Absent, Fault, Kind, Node, Place, Read, Section, Table, choice, enough, kind::listed,
    suggestion_or, unknown_key,
};

/// A value being checked: all that is wrong with it goes into `faults`.
pub(super) struct Check<'a> {
    /// What to do where nothing better can be said.
    pub see: &'a str,
    pub faults: Vec<Fault>,
}

impl Check<'_> {
    fn wrong(&mut self, place: Place, message: impl Into<String>, help: impl Into<String>) {
        self.faults
            .push(Fault::error(place, message, "here").help(help));
    }

    /// Checks the value of a key; `path` is the key as messages name it.
    pub fn value(&mut self, kind: &Kind, node: Node<'_>, path: &str, what: &str) {
        let place = node.place();
        let text = node.as_text();
        match (kind, text) {
            (Kind::Name, Some("")) => {
                self.wrong(place, format!("`{path}` is empty"), give(kind, what));
            }
            (Kind::Text | Kind::Name, Some(_)) => {}
            (Kind::Choice(words), Some(word)) => {
                if let Err(fault) = choice(word, words, place, self.see) {
                    self.faults.push(fault);
                }
            }
            (Kind::Spelled(spelling), Some(word)) => {
                if !(spelling.holds)(word) {
                    let message = format!("`{path}` cannot be \"{word}\"");
                    self.wrong(place, message, give(kind, what));
                }
            }
            (Kind::Flag, _) if node.as_flag().is_some() => {}
            (Kind::Number(range), _) if node.as_number().is_some() => {
                let number = node.as_number().unwrap_or_default();
                if !range.holds(number) {
                    self.wrong(place, format!("`{path}` is {number}"), give(kind, what));
                }
            }
            (Kind::Whole { least, most }, _) if node.as_whole().is_some() => {
                let number = node.as_whole().unwrap_or_default();
                if !(*least..=*most).contains(&number) {
                    self.wrong(place, format!("`{path}` is {number}"), give(kind, what));
                }
            }
            (Kind::Whole { .. }, _) if node.as_number().is_some_and(f64::is_finite) => {
                let number = node.as_number().unwrap_or_default();
                self.wrong(place, format!("`{path}` is {number}"), give(kind, what));
            }
            (Kind::List { of, least, most }, _) if node.as_list().is_some() => {
                let list = node.as_list().unwrap_or_default();
                if list.len() < *least || list.len() > *most {
                    let beyond = list.get(*most).map_or(place, |item| item.place());
                    let many = if *most == usize::MAX {
                        format!("at least {least}")
                    } else {
                        format!("{least} to {most}")
                    };
                    let message = format!("`{path}` has {} entries", list.len());
                    self.wrong(beyond, message, format!("give {many}"));
                    return;
                }
                // The place of a table says which of the list it is.
                let tables = matches!(of, Kind::Table(_) | Kind::Cases { .. });
                for item in list {
                    if enough(&self.faults) {
                        return;
                    }
                    let is_told = tables && item.as_table().is_some();
                    self.value(of, item, if is_told { "" } else { path }, what);
                }
            }
            (Kind::Table(table), _) if node.as_table().is_some() => self.table(table, node, path),
            (Kind::Map(of), _) if node.as_table().is_some() => {
                for (name, value) in node.as_table().unwrap_or_default() {
                    if enough(&self.faults) {
                        return;
                    }
                    self.value(of, value, &join(path, name.text), what);
                }
            }
            (Kind::Either { ways, .. }, _) => self.either(kind, ways, node, path, what),
            (Kind::Cases { tag, cases }, _) if node.as_table().is_some() => {
                self.cases(tag, cases, node, path);
            }
            _ => {
                let message = format!("`{path}` takes {}, this is {}", kind.words(), node.found());
                match kind {
                    Kind::List {
                        of: Kind::Table(_) | Kind::Cases { .. },
                        ..
                    } if node.as_table().is_some() => {
                        let help =
                            format!("write [[{path}]], in two brackets, once for each of them");
                        self.wrong(place, message, help);
                    }
                    _ => self.wrong(place, message, self.see),
                }
            }
        }
    }

    /// A way that takes values of this sort says best what is wrong; where several do, all are
    /// named.
    fn either(&mut self, kind: &Kind, ways: &[Kind], node: Node<'_>, path: &str, what: &str) {
        let fits: Vec<&Kind> = ways.iter().filter(|way| takes(way, node)).collect();
        let mut tried = Vec::new();
        for way in &fits {
            let mut check = Check {
                see: self.see,
                faults: Vec::new(),
            };
            check.value(way, node, path, what);
            if check.faults.is_empty() {
                return;
            }
            tried.push(check.faults);
        }
        match (fits.as_slice(), tried.pop()) {
            ([Kind::Choice(words)], _) => {
                let word = node.as_text().unwrap_or_default();
                let message = format!("unknown value `{word}`, expected {}", kind.words());
                let help = suggestion_or(word, words.iter().copied(), self.see);
                self.wrong(node.place(), message, help);
            }
            ([_], Some(faults)) => self.faults.extend(faults),
            ([Kind::Number(_), ..], _) if node.as_number().is_some() => {
                let number = node.as_number().unwrap_or_default();
                let message = format!("`{path}` is {number}");
                self.wrong(node.place(), message, give(kind, what));
            }
            _ => {
                let message = format!("`{path}` takes {}", kind.words());
                self.wrong(node.place(), message, self.see);
            }
        }
    }

    /// Checks the keys of a table.
    pub fn table(&mut self, table: &'static Table, node: Node<'_>, path: &str) {
        let section = Section::new(node, table);
        let given = node.as_table().unwrap_or_default();
        let mut unknown = false;
        for (name, value) in &given {
            if enough(&self.faults) {
                return;
            }
            if let Some(key) = table.key(name.text) {
                self.value(&key.kind, *value, &join(path, key.name), key.what);
            } else {
                let fault = unknown_key(*name, table.names(), self.see);
                self.faults.push(fault);
                unknown = true;
            }
        }
        // What is missing is most likely what was misspelled.
        if unknown {
            return;
        }
        for key in table.keys {
            if key.absent == Absent::Required
                && let Err(fault) = section.need(key.name)
            {
                self.faults.push(fault);
            }
        }
        let chosen = given.iter().filter(|(n, _)| table.one_of.contains(&n.text));
        let names: Vec<String> = table.one_of.iter().map(|n| format!("`{n}`")).collect();
        let names = names.join(", ");
        match chosen.count() {
            0 if !table.one_of.is_empty() => {
                let mut examples = table.one_of.iter().filter_map(|name| table.key(name));
                let example = examples.next().map_or("", |key| key.example);
                let help = format!("add one of them, such as {example}");
                self.wrong(node.place(), format!("missing key {names}"), help);
            }
            0 | 1 => {}
            _ => {
                let message = format!("only one of {names} can be given");
                let last = { given.iter() }
                    .filter(|(n, _)| table.one_of.contains(&n.text))
                    .map(|(n, _)| n.place)
                    .max_by_key(|place| place.start);
                let at = last.unwrap_or(node.place());
                self.wrong(at, message, "leave the others out");
            }
        }
    }

    fn cases(
        &mut self,
        tag: &str,
        cases: &'static [(&'static str, &'static Table)],
        node: Node<'_>,
        path: &str,
    ) {
        let words: Vec<&str> = cases.iter().map(|(word, _)| *word).collect();
        let Some(given) = node.get(tag) else {
            let message = format!("missing key `{tag}`");
            let help = format!("add it: {}", listed(words));
            return self.wrong(node.place(), message, help);
        };
        let Some(word) = given.as_text() else {
            let message = format!("`{tag}` takes {}, this is {}", listed(words), given.found());
            return self.wrong(given.place(), message, self.see);
        };
        match choice(word, &words, given.place(), self.see) {
            Err(fault) => self.faults.push(fault),
            Ok(at) => self.table(cases[at].1, node, path),
        }
    }
}

impl Kind {
    /// A value, if this kind takes it; messages call it `name`, and say `see` where nothing
    /// better can be said.
    ///
    /// # Errors
    /// The first thing that is wrong with it.
    pub fn check<'a>(&self, node: Node<'a>, name: &str, see: &str) -> Read<Node<'a>> {
        let mut check = Check {
            see,
            faults: Vec::new(),
        };
        check.value(self, node, name, "");
        check.faults.into_iter().next().map_or(Ok(node), Err)
    }
}

/// Whether a kind takes values of this sort, right or wrong.
fn takes(kind: &Kind, node: Node<'_>) -> bool {
    match kind {
        Kind::Text | Kind::Name | Kind::Choice(_) | Kind::Spelled(_) => node.as_text().is_some(),
        Kind::Flag => node.as_flag().is_some(),
        Kind::Number(_) | Kind::Whole { .. } => node.as_number().is_some(),
        Kind::List { .. } => node.as_list().is_some(),
        Kind::Table(_) | Kind::Map(_) | Kind::Cases { .. } => node.as_table().is_some(),
        Kind::Either { ways, .. } => ways.iter().any(|way| takes(way, node)),
    }
}

fn give(kind: &Kind, what: &str) -> String {
    match what {
        "" => format!("give {}", kind.words()),
        what => format!("give {}: {what}", kind.words()),
    }
}

fn join(path: &str, key: &str) -> String {
    if path.is_empty() {
        key.to_owned()
    } else {
        format!("{path}.{key}")
    }
}

#[cfg(test)]
mod tests {
    use super::super::{File, Key, Range};
    use super::*;

    const INNER: Table = Table {
        one_of: &["one", "other"],
        keys: &[
            Key::optional("one", Kind::Flag, "a flag").example("one = true"),
            Key::optional("other", Kind::Number(Range::POSITIVE), "a number"),
        ],
    };

    const FILE: File = File {
        title: "a test",
        kind: Kind::Table(&Table::new(&[
            Key::required("kind", Kind::Choice(&["round", "square"]), "its shape"),
            Key::with_default("size", Kind::Whole { least: 1, most: 9 }, "3", "its size"),
            Key::optional("inner", Kind::Table(&INNER), "what is inside"),
            Key::optional(
                "way",
                Kind::Either {
                    ways: &[Kind::Number(Range::POSITIVE), Kind::Table(&INNER)],
                    expected: "a number or a table",
                },
                "a way",
            ),
        ])),
        see: "look it up",
    };

    /// Line, column, message and help of all that is wrong.
    fn said(text: &str) -> Vec<String> {
        let wrong = FILE.read("t", text, |_| Ok(())).unwrap_err();
        let line = |it: &super::super::Located| {
            format!("{it} | {}", it.fault.help.as_deref().unwrap_or(""))
        };
        wrong.faults.iter().map(line).collect()
    }

    #[test]
    fn every_fault_has_its_place_and_its_help() {
        assert!(FILE.read("t", "kind = \"round\"", |_| Ok(())).is_ok());
        for (text, want) in [
            ("", "t:1:1: missing key `kind` | add it: its shape"),
            (
                "knd = 1",
                "t:1:1: unknown key `knd`, expected one of `kind`, `size`, `inner`, `way` | did you mean `kind`?",
            ),
            (
                "kind = \"circle\"",
                "t:1:8: unknown value `circle`, expected `round` or `square` | look it up",
            ),
            (
                "kind = \"round\"\nsize = 12",
                "t:2:8: `size` is 12 | give a whole number from 1 to 9: its size",
            ),
            (
                "kind = \"round\"\nsize = \"12\"",
                "t:2:8: `size` takes a whole number from 1 to 9, this is a text | look it up",
            ),
            (
                "kind = \"round\"\ninner = {}",
                "t:2:9: missing key `one`, `other` | add one of them, such as one = true",
            ),
            (
                "kind = \"round\"\ninner = { one = true, other = 1 }",
                "t:2:23: only one of `one`, `other` can be given | leave the others out",
            ),
            (
                "kind = \"round\"\nway = { other = -1 }",
                "t:2:17: `way.other` is -1 | give a number above 0: a number",
            ),
            (
                "kind = \"round\"\nway = { other = 1e400 }",
                "t:2:17: `way.other` takes a number above 0, this is infinite: beyond the largest number of 64 bits | look it up",
            ),
            (
                "kind = \"round\"\nway = []",
                "t:2:7: `way` takes a number or a table | look it up",
            ),
            (
                "kind = ",
                "t:1:8: not TOML: string values must be quoted, expected literal string | write key = value; words go in quotes, as in name = \"word\"",
            ),
        ] {
            assert_eq!(said(text), [want], "{text}");
        }
        assert_eq!(said("kind = 3\nsize = 0").len(), 2, "all at once");
    }
}
