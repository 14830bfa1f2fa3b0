//! The interpreter: the tree, run as the micro-controller would run it.
//!
//! - [`machine`]: the state of the micro-controller, and the budget of its work.
//! - [`run`], [`loops`], [`declare`]: statements; [`evaluate`], [`operator`]: expressions.
//! - [`call`]: calls of functions, and which of several is meant.
//! - [`scope`]: from names to variables; [`variable`]: what they hold; [`lvalue`]: where expressions
//!   lead, and what is loaded from and stored there.
//! - [`value`]: values, known or not; [`reason`]: why one is not known.
//! - [`layout`]: the members of classes; [`shape`]: values as arrays and objects hold them.
//! - [`undefined_type`]: objects of types that the text does not define.

pub(super) mod call;
mod declare;
mod evaluate;
pub(super) mod layout;
mod loops;
pub(super) mod lvalue;
pub(super) mod machine;
pub(super) mod operator;
pub(super) mod reason;
mod run;
pub(super) mod scope;
pub(super) mod shape;
mod undefined_type;
pub(super) mod value;
mod variable;
