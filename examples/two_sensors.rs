//! The library in a few lines: one scene, two sensors, their packets compared.
//!
//! `cargo run --release --example two_sensors`

use amacrine::{
    compare::Pair,
    reference::{Description, Reference},
    rig,
    scene::{OpenOptions, open},
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = open(
        "pattern:disc?width=64&height=48&frames=30",
        &OpenOptions::default(),
    )?;
    let size = scene.size();
    let mut one = Reference::new(Description::open("dvs-clean")?, size, 0)?;
    let mut other = Reference::new(Description::open("dvs-noisy")?, size, 0)?;
    let packets = rig::watch(&mut *scene, &mut [&mut one, &mut other], |_| ())?;
    let [clean, noisy] = Pair::new(&packets[0], &packets[1])?.events();
    println!("{clean} events, {noisy} with noise");
    amacrine::event::file::write("out/noisy.npy".as_ref(), &packets[1])?;
    Ok(())
}
