//! What the members of a class begin with, as the parser keeps it for what stands behind the class.

use super::super::tree::{Declared, Expr, Word};

/// What the members of a class begin with, for each of its constructors, those behind it too.
#[derive(Clone)]
pub(super) struct MemberInitialisers {
    /// The namespace of what belongs to the class.
    pub space: Word,
    pub base: Option<Word>,
    pub data: Vec<Declared>,
    /// What a member begins with that may change from object to object.
    pub values: Vec<Option<Expr>>,
    /// Whether a member is an object that a constructor makes.
    pub made: Vec<bool>,
}
