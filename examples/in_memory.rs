//! How fast a sensor is from frames in memory to events in memory, in f32: what
//! `python/examples/speed.py` holds the Python package to.
//!
//! `cargo run --release --example in_memory SCENE.npy SENSOR FPS RUNS` prints the events of a run and
//! the seconds of each.

use std::{error::Error, time::Instant};

use amacrine::{
    event::Packet,
    number::F32,
    plane::Plane,
    reference::{Description, Reference},
    scene::{
        Frame, OpenOptions,
        kept::{Kept, Pixels},
        open,
    },
    sensor::Sensor,
};

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [scene, sensor, fps, runs] = &words[..] else {
        return Err("give SCENE.npy SENSOR FPS RUNS".into());
    };
    let (fps, runs): (f64, usize) = (fps.parse()?, runs.parse()?);
    let options = OpenOptions {
        fps: Some(fps),
        ..OpenOptions::default()
    };
    let mut scene = open(scene, &options)?;
    let kept = Kept::new(&mut *scene, usize::MAX)?.ok_or("the scene is too long")?;
    let mut frame = Frame {
        index: 0,
        seconds: 0.0,
        light: Plane::zeros(kept.size().shape()).into(),
    };
    for _ in 0..runs {
        let start = Instant::now();
        let description = Description::open(sensor)?;
        let channels = description.channels.len() as u8;
        let mut reference = Reference::with_number(F32, description, kept.size(), 0)?;
        let mut packet = Packet::new(kept.size(), channels);
        for n in 0..kept.len() {
            frame.index = n as u64;
            frame.seconds = n as f64 / fps;
            if let (Some((.., Pixels::Bytes(bytes))), Some(light)) =
                (kept.frame(n), frame.light.as_slice_mut())
            {
                for (to, from) in light.iter_mut().zip(bytes) {
                    *to = f64::from(*from);
                }
            }
            reference.watch(&frame, &mut packet)?;
        }
        println!("{} {}", packet.events.len(), start.elapsed().as_secs_f64());
    }
    Ok(())
}
