//! What single kernels keep on the chip: for several kernels, quantisers and thresholds on clips, the
//! program that no light saturates (`exact`) beside the default, in exact arithmetic and as silicon.
//!
//! ```text
//! cargo run --release --example kept                            # the bundled clip
//! cargo run --release --example kept -- a.y4m b.y4m --every 2
//! ```

use std::error::Error;

use amacrine::{
    compile::{CellKind, DriveMemory, Effort, Objective, Request, SensorProgram},
    isa::Device,
    kernel::{
        Kernel,
        quantise::{Quantiser, Sum},
    },
    plane::{Plane, Size},
    reference::MemoryRule,
    rng::Hash,
    scene::{Frame, OpenOptions, Scene, bundled, held::Held, open},
    study::{
        design::{Compiled, Design},
        together,
    },
    unit::Micros,
};

/// Rows and columns that are shown, from the middle of each clip, and frames.
const SIDE: usize = 128;
const FRAMES: usize = 12;

/// Thresholds, in parts of a kernel's length.
const THRESHOLDS: [f64; 2] = [25.0, 10.0];

const QUANTISERS: [&str; 5] = ["ternary", "int-3", "int-5", "q2.3", "binary"];

/// Kernels by name: of the crate, and random ones of -1, 0 and 1.
fn kernels() -> Vec<(String, Kernel)> {
    let built_in = ["rgc-5x5", "csdvs-5", "dog", "oblique-45"];
    let known =
        { built_in.into_iter() }.filter_map(|name| Some((name.to_owned(), Kernel::builtin(name)?)));
    let random = [(3, 11), (5, 12), (5, 13), (7, 14)].into_iter();
    let random = random.filter_map(|(side, seed)| {
        let key = Hash::raw(seed);
        let draw = |at: usize| (3.0 * key.nth(at as u64 + 1).uniform()).floor() - 1.0;
        let rows: Vec<Vec<f64>> = (0..side)
            .map(|y| (0..side).map(|x| draw(y * side + x)).collect())
            .collect();
        Some((
            format!("ternary {side}x{side}, {seed}"),
            Kernel::from_rows(&rows).ok()?,
        ))
    });
    known.chain(random).collect()
}

/// The middle of every so many frames.
fn clip(mut scene: Box<dyn Scene>, every: usize) -> Result<Held, Box<dyn Error>> {
    let fps = scene.fps() / every as f64;
    let mut frames = Vec::new();
    for number in 0.. {
        let Some(frame) = scene.next_frame()? else {
            break;
        };
        if number % every != 0 || frames.len() == FRAMES {
            continue;
        }
        let (rows, columns) = frame.light.dim();
        let light = Plane::from_shape_fn((SIDE, SIDE), |(y, x)| {
            frame.light[((rows - SIDE) / 2 + y, (columns - SIDE) / 2 + x)]
        });
        let index = frames.len() as u64;
        frames.push(Frame {
            index,
            seconds: index as f64 / fps,
            light: light.into(),
        });
    }
    Ok(Held::new(frames, Size::new(SIDE, SIDE), fps))
}

fn main() -> Result<(), Box<dyn Error>> {
    let device = Device::scamp5();
    let mut paths: Vec<String> = std::env::args().skip(1).collect();
    let mut every = 1;
    if let Some(at) = paths.iter().position(|path| path == "--every") {
        every = paths
            .get(at + 1)
            .and_then(|n| n.parse().ok())
            .unwrap_or(1)
            .max(1);
        paths.truncate(at);
    }
    let mut clips = Vec::new();
    for path in &paths {
        clips.push((
            path.clone(),
            clip(open(path, &OpenOptions::default())?, every)?,
        ));
    }
    if clips.is_empty() {
        clips.push(("bundled".to_owned(), clip(bundled()?, every)?));
    }
    println!("kept in exact arithmetic and as silicon: of `exact`, then of the default");
    println!(
        "| clip | kernel | values | threshold | words | exact | silicon | words | exact | silicon |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    let (mut sums, mut worst, mut count) = ([0.0; 4], [f64::INFINITY; 2], 0.0);
    for (name, kernel) in kernels() {
        let squares: f64 = kernel.weights().iter().map(|w| w * w).sum();
        for to in QUANTISERS {
            for part in THRESHOLDS {
                let float = Design {
                    kernel: &kernel,
                    threshold: part * squares.sqrt(),
                    device: &device,
                    effort: Effort::default(),
                    seed: 0,
                };
                // A kernel whose weights are of these values already is one of them.
                if name.starts_with("ternary") && matches!(to, "int-3" | "q2.3" | "binary") {
                    continue;
                }
                let Ok(quantised) = float.quantise(to.parse::<Quantiser>()?, Sum::Free) else {
                    continue;
                };
                let levels = float.in_levels(&quantised);
                let kinds = [CellKind {
                    name: None,
                    kernel: levels.kernel.clone(),
                    on: levels.threshold,
                    off: levels.threshold,
                }];
                let mut both = Vec::new();
                for objective in [Objective::Exact, Objective::Silicon] {
                    let mut request = Request::new(std::slice::from_ref(levels.kernel), &device)?;
                    request.objective = objective;
                    let memory = DriveMemory::Analogue;
                    if let Ok(made) = SensorProgram::new(&kinds, memory, "one", &request) {
                        both.push(Compiled::from_program("one", made, &device)?);
                    }
                }
                let [exact, chosen] = &both[..] else { continue };
                for (path, clip) in &clips {
                    let judged = together::judge(
                        &[exact, chosen],
                        &float.description(MemoryRule::FilteredSnap)?,
                        (Micros(100_000), 0, 1),
                        &mut clip.again(),
                        |_| (),
                    );
                    let Ok(judged) = judged else { continue };
                    let [a, b] = [&judged.programs[0][0], &judged.programs[1][0]];
                    let all = [a.exact, a.silicon, b.exact, b.silicon];
                    let all = all.map(|likeness| likeness.kept.unwrap_or(0.0));
                    println!(
                        "| {} | {name} | {to} | {:.0} | {} | {:.3} | {:.3} | {} | {:.3} | {:.3} |",
                        path.rsplit('/').next().unwrap_or(path),
                        float.threshold,
                        exact.cost.words.0,
                        all[0],
                        all[1],
                        chosen.cost.words.0,
                        all[2],
                        all[3],
                    );
                    for (sum, own) in sums.iter_mut().zip(all) {
                        *sum += own;
                    }
                    worst = [worst[0].min(all[2] - all[0]), worst[1].min(all[3] - all[1])];
                    count += 1.0;
                }
            }
        }
    }
    let [a, b, c, d] = sums.map(|sum| sum / count);
    println!(
        "\n{count} rows; mean {a:.3} and {b:.3}, then {c:.3} and {d:.3}; the largest loss {:.3} and {:.3}",
        worst[0], worst[1]
    );
    Ok(())
}
