//! Every number format, domain of the array, solver of the mesh and rule of the reference driven
//! to its edge: what happens there, which bound holds and how much of it is used, what is refused
//! and with which words. Against closed forms, exact sums and eliminations that lose no digit.
//!
//! The tables of `docs/extremes.md` are made of what is measured here. A row that comes out
//! otherwise fails; `AMACRINE_BLESS=1 cargo test --release --test extremes` writes the page.

#[path = "extremes/array.rs"]
mod array;
#[path = "extremes/bound.rs"]
mod bound;
#[path = "extremes/light.rs"]
mod light;
#[path = "extremes/mesh.rs"]
mod mesh;
#[path = "extremes/number.rs"]
mod number;
#[path = "extremes/page.rs"]
mod page;
#[path = "extremes/reference.rs"]
mod reference;
#[path = "extremes/sizes.rs"]
mod sizes;

#[test]
fn numbers() {
    number::table().check("numbers");
}

#[test]
fn the_array() {
    array::table().check("array");
}

#[test]
fn the_mesh() {
    mesh::table().check("mesh");
}

#[test]
fn the_reference() {
    reference::table().check("reference");
}

#[test]
fn sizes() {
    sizes::table().check("sizes");
}
