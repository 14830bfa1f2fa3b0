//! Names and the variables that they mean.

use std::collections::BTreeSet;

use super::{
    machine::{Location, Machine},
    value::{Slot, Value},
};
use crate::{
    config::Place,
    program::vendor::syntax::tree::{Kind, Word, last, qualifier},
};

impl<'a> Machine<'a> {
    /// The variable of the file that has this name, with its namespace.
    fn of_file(&self, name: &str) -> Option<Slot> {
        let apart = || self.apart.get(&(self.file, name.into()));
        let own = if self.apart.is_empty() { None } else { apart() };
        own.or_else(|| self.scopes.first()?.get(name)).copied()
    }

    /// The name of a variable that this file has for itself.
    pub(super) fn own_name(&self, name: &Word) -> (Option<&'a str>, Word) {
        let space = Some(&*self.space).filter(|it| !it.is_empty());
        let full = space.map_or_else(|| name.clone(), |of| format!("{of}::{name}").into());
        (self.file, full)
    }

    pub(in crate::program::vendor) fn find(&self, name: &str) -> Option<Slot> {
        match qualifier(name) {
            Some("") => return self.of_file(last(name)),
            Some(_) if foreign(name) => return None,
            Some(_) => {
                let own = self.scopes.get(self.base.max(1)..).unwrap_or_default();
                if let Some(slot) = own.iter().rev().find_map(|scope| scope.get(name)) {
                    return Some(*slot);
                }
                let spaces = self.spaces().map(|space| format!("{space}::{name}"));
                let found = spaces
                    .chain([name.to_owned()])
                    .find_map(|it| self.of_file(&it));
                // A class or an enumeration, whose names are the file's.
                return found.or_else(|| self.find(last(name)));
            }
            None => {}
        }
        let own = self.scopes.get(self.base.max(1)..).unwrap_or_default();
        let found = own.iter().rev().find_map(|scope| scope.get(name));
        let space = || {
            let mut spaces = self.spaces().map(|space| format!("{space}::{name}"));
            spaces.find_map(|it| self.of_file(&it))
        };
        let found = found.copied().or_else(space);
        found.or_else(|| self.of_file(name))
    }

    /// The namespace that is worked in, and those around it.
    pub(super) fn spaces(&self) -> impl Iterator<Item = &str> {
        let first = Some(&*self.space).filter(|it| !it.is_empty());
        std::iter::successors(first, |it| qualifier(it))
    }

    /// The variables that a name means here or in some function.
    pub(in crate::program::vendor) fn find_all(&self, name: &str) -> BTreeSet<Slot> {
        let plain = last(name);
        let file = self.scopes.first().into_iter().flatten();
        let file = file.filter(|(it, _)| last(it) == plain);
        let apart = { self.apart.iter() }.filter(|(it, _)| last(&it.1) == plain);
        self.find(name)
            .into_iter()
            .chain(file.map(|it| *it.1))
            .chain(apart.map(|it| *it.1))
            .collect()
    }

    pub(super) fn bind(&mut self, name: &Word, slot: Slot) {
        if let ([file], false) = (&mut self.scopes[..], self.space.is_empty()) {
            file.insert(format!("{}::{name}", self.space).into(), slot);
            // Others may mean it without its namespace, unless there are several.
            if self.ambiguous.contains(name) {
                return;
            }
            match file.get(name).copied() {
                None => {
                    file.insert(name.clone(), slot);
                }
                Some(known) => {
                    let spaced = |it: &(&Word, &Slot)| *it.1 == known && qualifier(it.0).is_some();
                    // One of the file itself keeps its name.
                    if file.iter().any(|it| spaced(&it)) {
                        file.remove(name);
                        self.ambiguous.insert(name.clone());
                    }
                }
            }
            return;
        }
        if let Some(scope) = self.scopes.last_mut() {
            scope.insert(name.clone(), slot);
        }
    }

    /// Binds a name to a variable, or to an element of one.
    pub(super) fn refer(&mut self, name: &Word, (slot, path): Location) {
        if path.is_empty() {
            self.bind(name, slot);
        } else {
            self.make(name, Value::Reference(slot, path), Kind::Any);
        }
    }

    /// The value that is set from outside for this name, if it is.
    pub(in crate::program::vendor) fn set(&mut self, name: &str) -> Option<Value> {
        let value = *self.overrides.get(name)?;
        self.constants.insert(name.to_owned(), value);
        Some(Value::from_number(value))
    }

    /// What is set from outside must be a number that its variable can hold.
    pub(in crate::program::vendor) fn set_within(
        &mut self,
        name: &str,
        (set, kind): (&Value, Kind),
        place: Place,
    ) {
        let made = set.clone().converted(kind).number();
        if let (Some(asked), Some(made)) = (set.number(), made)
            && asked != made
            && !matches!(kind, Kind::Float)
        {
            self.error(
                place,
                format!("`{name}` is set to {asked}, which its type converts to {made}"),
                "its declaration",
                "give a number that its type can hold",
            );
        }
    }
}

/// Whether a name is written as the vendor's or the language's own.
pub(in crate::program::vendor) fn foreign(name: &str) -> bool {
    let space = qualifier(name).unwrap_or_default();
    matches!(space.trim_start_matches("::"), "std" | "SCAMP5_PE")
}
