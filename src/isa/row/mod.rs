//! Rows of the tables: what a primitive or a host operation is called, what it takes, what
//! it means, what it costs.

mod form;
mod table;

pub use self::{
    form::{build, neighbour_name},
    table::{Clock, HostKind, HostRow, Kind, PrimitiveRow},
};
