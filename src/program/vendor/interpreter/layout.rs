//! Classes: what their objects hold, what belongs to them, and which they are made from.

use std::rc::Rc;

use super::value::Value;
use crate::program::vendor::syntax::tree::{Bound, Function, Kind, Word};

/// A class: what its objects hold.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::program::vendor) struct Layout {
    pub name: Word,
    /// The namespace of its functions.
    pub space: Word,
    /// Those of its base come first.
    pub members: Vec<Member>,
    /// Its own functions.
    pub functions: Vec<Rc<Function>>,
    pub base: Option<Rc<Self>>,
    /// What each element is, where it is a map.
    pub entry: Option<Rc<Self>>,
    /// How many values an object holds.
    pub values: usize,
}

#[derive(Clone, Debug, PartialEq)]
pub(in crate::program::vendor) struct Member {
    pub name: Word,
    pub kind: Kind,
    pub lengths: Vec<Option<usize>>,
    /// Whether it is a pointer or a reference.
    pub leads: bool,
    /// Whether it is an array of the language's library.
    pub library: bool,
    /// Whether it is a text of the language's library, or an array of those.
    pub text: bool,
    /// The class of the member itself.
    pub layout: Option<Rc<Layout>>,
    /// What it begins with, where its declaration says so.
    pub default: Option<Value>,
}

/// Members without a class of their own: what stands in braces by name.
const NAMED: &str = "";

impl Layout {
    /// Of values that have names and types, and nothing else.
    pub(in crate::program::vendor) fn of_values(name: &str, members: Vec<(Word, Kind)>) -> Self {
        let members = members.into_iter().map(|(name, kind)| Member {
            name,
            kind,
            lengths: Vec::new(),
            leads: false,
            library: false,
            text: false,
            layout: None,
            default: None,
        });
        let members: Vec<Member> = members.collect();
        Self {
            name: name.into(),
            space: name.into(),
            values: 1 + members.len(),
            members,
            functions: Vec::new(),
            base: None,
            entry: None,
        }
    }

    /// Of what stands in braces by name.
    pub(super) fn designated(names: Vec<Word>) -> Self {
        let members = names.into_iter().map(|name| (name, Kind::Any));
        Self::of_values(NAMED, members.collect())
    }

    pub(super) fn is_designated(&self) -> bool {
        &*self.name == NAMED
    }

    /// Whether it is a pair or a tuple of the language's library.
    pub(in crate::program::vendor) fn is_tuple(&self) -> bool {
        let plain = self.functions.is_empty() && self.base.is_none();
        let named = |of: &str| {
            let rest = self.name.strip_prefix(of);
            rest.is_some_and(|it| it.is_empty() || it.starts_with('<'))
        };
        plain && (named("pair") || named("tuple"))
    }

    /// The class and those that it is made from, one after the other.
    pub(super) fn line(self: &Rc<Self>) -> impl Iterator<Item = &Rc<Self>> {
        std::iter::successors(Some(self), |it| it.base.as_ref())
    }

    /// Whether a member or a function has this name.
    pub(in crate::program::vendor) fn names(&self, name: &str) -> bool {
        let members = self.members.iter().map(|it| &it.name);
        let functions = self.functions.iter().map(|it| &it.name);
        members.chain(functions).any(|it| &**it == name)
            || self.base.as_ref().is_some_and(|it| it.names(name))
    }

    /// Whether an object of a class that is made from it may have another in place of this function.
    pub(super) fn is_virtual(&self, function: &Function) -> bool {
        let own = self.functions.iter();
        let mut own = own.filter(|it| it.overrides(function));
        own.any(|it| matches!(it.bound, Bound::Virtual | Bound::Pure))
            || self.base.as_ref().is_some_and(|it| it.is_virtual(function))
    }

    /// Whether its objects are made by a constructor.
    pub(in crate::program::vendor) fn constructs(&self) -> bool {
        self.functions
            .iter()
            .any(|it| it.name == self.name && !it.hidden)
    }
}
