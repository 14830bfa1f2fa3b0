//! What `--fidelity auto` is worth: ordinary runs and upsampled ones, the full model beside what a
//! pilot chooses, as the table of `docs/fidelity.md`.
//!
//! ```text
//! cargo run --release --example fidelity            # all of it, minutes
//! cargo run --release --example fidelity -- dvs     # runs whose sensor is called so
//! ```
//!
//! Times are those of the wall, the reading of the scene included, each the least of three.

use std::{path::Path, time::Instant};

use amacrine::{
    event::Packet,
    number::Format,
    reference::{Description, Limit},
    scene::{OpenOptions, Scene, bundled_with, kept::Kept, open},
    study::pilot::{
        Change, Plan, Question,
        plan::{BUDGET, KEPT, Model, plan},
    },
    unit::Micros,
};

const PATTERN: &str = "pattern:noise?width=256&height=256&frames=400&fps=1000&speed=300";
const SENSORS: [&str; 8] = [
    "dvs",
    "dvs-v2e",
    "csdvs",
    "dog",
    "rgc",
    "rgc-4",
    "orientation",
    "csdvs-mesh",
];
/// Of three sensors with inserted frames: two of a linear response, one of another.
const UPSAMPLED: [&str; 3] = ["laplacian", "csdvs", "dvs-v2e"];
const CONTRAST: f64 = 0.2;

type Error = Box<dyn std::error::Error>;

fn light(clip: &str) -> Result<Box<dyn Scene>, Error> {
    let options = OpenOptions::default();
    Ok(if clip == "bundled" {
        bundled_with(&options)?
    } else {
        open(clip, &options)?
    })
}

/// The least seconds of three, and what came of the last.
fn least<T>(mut run: impl FnMut() -> Result<T, Error>) -> Result<(f64, T), Error> {
    let mut least = f64::INFINITY;
    loop {
        let mut last = None;
        for _ in 0..3 {
            let start = Instant::now();
            last = Some(run()?);
            least = least.min(start.elapsed().as_secs_f64());
        }
        if let Some(last) = last {
            return Ok((least, last));
        }
    }
}

fn auto(question: &Question<'_>, clip: &str) -> Result<(Plan, Packet), Error> {
    let start = Instant::now();
    let clock = || start.elapsed().as_secs_f64();
    let mut scene = light(clip)?;
    let kept = if question.looks() {
        Kept::new(&mut *scene, KEPT)?
    } else {
        None
    };
    let plan = plan(question, kept.as_ref(), &clock)?;
    let model = Model::planned(question, &plan, Limit::default());
    let packet = match &kept {
        Some(kept) => model.run(kept.scene(), || ())?,
        None => model.run(scene, || ())?,
    };
    Ok((plan, packet))
}

fn row(clip: &str, name: &str, upsample: Option<f64>) -> Result<(), Error> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("sensors");
    let text = std::fs::read_to_string(folder.join(format!("{name}.toml")))?;
    let description = Description::parse(name, &text, &|file| std::fs::read(folder.join(file)))?;
    let question = Question {
        description: &description,
        seed: 0,
        tolerance: 0.01,
        within: Micros(100),
        formats: &[Format::F32],
        upsample,
        readout: None,
        crop: false,
        budget: BUDGET,
        tiles: None,
    };
    let (full_s, full) = least(|| {
        let model = Model::full(&question, Limit::default());
        Ok(model.run(light(clip)?, || ())?)
    })?;
    let (auto_s, (plan, plain)) = least(|| auto(&question, clip))?;
    let change = Change::between(&full, &plain, question.within)?;
    let limit = match plan.change.and_then(|change| change.limit) {
        Some(limit) => format!("{:.3} %", 100.0 * limit),
        None if plan.free.is_empty() => "-".to_owned(),
        None => "free".to_owned(),
    };
    let clip = clip.split('?').next().unwrap_or(clip);
    println!(
        "| {clip} | {name} | {full_s:.2} s | {auto_s:.2} s | {:.2} | {:.4} % | {limit} | {} |",
        full_s / auto_s,
        100.0 * change.share,
        plan.choice
    );
    Ok(())
}

fn main() -> Result<(), Error> {
    let asked = std::env::args().nth(1);
    let is_asked = |name: &str| asked.as_deref().is_none_or(|asked| asked == name);
    println!("| scene | sensor | full | auto | times as fast | change | limit | what ran |");
    println!("|---|---|---|---|---|---|---|---|");
    for clip in ["bundled", PATTERN] {
        for name in SENSORS.into_iter().filter(|name| is_asked(name)) {
            row(clip, name, None)?;
        }
    }
    for name in UPSAMPLED.into_iter().filter(|name| is_asked(name)) {
        row("bundled", name, Some(CONTRAST))?;
    }
    Ok(())
}
