//! One clip, five frame rates, three sensors: which figure depends on the rate, and which does
//! not. Prints the table of `docs/ruler.md`.
//!
//! ```text
//! cargo run --release --example frame_rates
//! ```
//!
//! The light is the same at every rate: frames are inserted evenly, and between two frames of the
//! clip each pixel's light is a straight line.

use amacrine::{
    compare::{
        Pair,
        window::{self, headline},
    },
    compile::Effort,
    isa::Device,
    kernel::{
        Kernel,
        quantise::{Quantiser, Sum},
    },
    number::Format,
    reference::MemoryRule,
    rig,
    scene::{Scene, bundled, resample::Resampled},
    study::{
        design::Design,
        equivalent::{self, Ladder, Likeness, RUNGS},
    },
    unit::{Micros, frame_rate},
};
use miette::{IntoDiagnostic, miette};

/// Frames for each of the clip's.
const TIMES: [f64; 5] = [1.0, 3.0, 10.0, 30.0, 50.0];

/// The memory of a chip's program.
const MEMORY: MemoryRule = MemoryRule::FilteredSnap;

/// The window that asks for the frame.
const SHORT: Micros = Micros(1_000);

fn main() -> miette::Result<()> {
    let kernel = Kernel::builtin("rgc-5x5").ok_or_else(|| miette!("no kernel"))?;
    let device = Device::scamp5();
    let float = Design {
        kernel: &kernel,
        threshold: 128.0,
        device: &device,
        effort: Effort::states(1),
        seed: 0,
    };
    let levels = float.quantise(Quantiser::TERNARY, Sum::Kept)?;
    let designs = [
        float.in_levels(&levels),
        higher(&float, 1.1),
        higher(&float, 1.25),
    ];
    println!(
        "| frames/s | ternary: F1 1 ms | kept 100 ms | threshold | +10 %: F1 1 ms | kept 100 ms | threshold | +25 %: F1 1 ms | kept 100 ms | threshold |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for times in TIMES {
        let clip = bundled()?;
        let fps = clip.fps() * times;
        let mut scene = Resampled::new(clip, fps)?;
        let rate = frame_rate(scene.fps());
        let rows = judged(&float, &designs, &mut scene)?;
        let cells: Vec<String> = { rows.iter() }
            .map(|(f1, judged)| {
                format!(
                    "{f1:.3} | {} | {}",
                    equivalent::kept(judged.kept, 3),
                    judged.equivalent()
                )
            })
            .collect();
        println!("| {rate} | {} |", cells.join(" | "));
    }
    Ok(())
}

/// The same cell with a higher threshold.
fn higher<'a>(design: &Design<'a>, part: f64) -> Design<'a> {
    Design {
        threshold: design.threshold * part,
        ..*design
    }
}

/// F1 within the short window and the headline of each design, against the float sensor.
fn judged(
    float: &Design<'_>,
    designs: &[Design<'_>],
    scene: &mut dyn Scene,
) -> miette::Result<Vec<(f64, Likeness)>> {
    let (size, fps) = (scene.size(), scene.fps());
    let mut sensors = vec![float.reference(size, MEMORY, Format::F64)?];
    sensors.extend(equivalent::sensors(float, size, MEMORY)?);
    for design in designs {
        sensors.push(design.reference(size, MEMORY, Format::F64)?);
    }
    let mut packets = rig::watch(scene, &mut rig::each(&mut sensors), |_| ())?;
    let judged = packets.split_off(1 + RUNGS.len());
    let rungs = packets.split_off(1);
    let truth = packets.pop().ok_or_else(|| miette!("no packet"))?;
    let ladder = Ladder::new(truth, &rungs, headline(fps), fps, 0)?;
    { judged.iter() }
        .map(|packet| {
            let pair = Pair::new(ladder.reference(), packet)?;
            let likeness = ladder.judge(packet)?;
            Ok((window::f1(&pair, SHORT), likeness))
        })
        .collect::<Result<_, amacrine::compare::CompareError>>()
        .into_diagnostic()
}
