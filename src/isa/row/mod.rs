//! Rows of a chip's tables: the name, parameters, meaning and cost of a primitive or a host
//! operation.

mod form;
mod table;

pub use self::{
    form::{build, neighbour_name},
    table::{Clock, HostKind, HostRow, PrimitiveKind, PrimitiveRow},
};
