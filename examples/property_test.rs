//! A design of one's own against the float model, as a property: on whatever scene, the program
//! says what the sensor says. Here once where it holds, and once where it does not.
//!
//! `cargo run --release --features proptest --example property_test`

use std::panic::catch_unwind;

use amacrine::{
    program::Program,
    property::{Tolerance, assert_agrees},
    reference::Description,
};

/// Light halved, minus the memory, against ±threshold.
const DESIGN: &str = include_str!("../programs/dvs/snap.scamp");

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let none = |name: &str| Err(std::io::Error::other(format!("{name} is not needed")));
    let float = |threshold: f64| {
        let text = format!(
            "name = \"DVS\"\nresponse = \"identity\"\nmemory = \"filtered-snap\"\n[[channel]]\nkernel = [[1]]\nthreshold = {{ on = {threshold:?}, off = {threshold:?} }}\n"
        );
        Description::parse("dvs", &text, &none)
    };
    let program = Program::parse("snap.scamp", DESIGN)?;

    assert_agrees(&program, &float(20.0)?, &Tolerance::default());
    println!("snap.scamp says what a DVS of 20 levels says, event by event");

    let (wrong, tolerance) = (float(22.0)?, Tolerance::default());
    std::panic::set_hook(Box::new(|_| {}));
    let found = catch_unwind(|| assert_agrees(&program, &wrong, &tolerance));
    if let Err(panic) = found {
        let why = panic.downcast::<String>().map_err(|_| "another panic")?;
        println!("\nbut not what one of 22 levels says; the smallest scene that shows it:\n{why}");
    }
    Ok(())
}
