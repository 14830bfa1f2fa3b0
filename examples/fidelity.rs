//! What `--fidelity auto` is worth: ordinary runs and upsampled ones, the full model beside what a
//! pilot chooses, as the table of `docs/fidelity.md`.
//!
//! ```text
//! cargo run --release --example fidelity            # all of it, minutes
//! cargo run --release --example fidelity -- dvs     # runs whose sensor is called so
//! ```
//!
//! Times are those of the wall, the reading of the scene included, each the median of five, the
//! full and the chosen model in turn. The last column says whether the chosen one is slower than
//! 1.05 times the full one and a tenth of a second.

use std::{path::Path, time::Instant};

use amacrine::{
    event::Packet,
    number::Format,
    reference::{Description, Limit},
    scene::{OpenOptions, Scene, bundled_with, kept::Kept, open},
    study::pilot::{
        Change, Model, Plan, Question,
        plan::{BUDGET, KEPT, plan},
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

/// Full and chosen models in turn, so that both meet the same machine.
const PAIRS: usize = 5;

/// Seconds of a run, and what came of it.
fn timed<T>(run: impl FnOnce() -> Result<T, Error>) -> Result<(f64, T), Error> {
    let start = Instant::now();
    let came = run()?;
    Ok((start.elapsed().as_secs_f64(), came))
}

fn median(mut seconds: Vec<f64>) -> f64 {
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
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
        looks_anyway: false,
        budget: BUDGET,
        tiles: None,
    };
    let run_full = || {
        let model = Model::full(&question, Limit::default());
        Ok(model.run(light(clip)?, || ())?)
    };
    let (mut full_s, mut auto_s) = (Vec::new(), Vec::new());
    let (_, mut full) = timed(run_full)?;
    let (_, (mut plan, mut plain)) = timed(|| auto(&question, clip))?;
    for _ in 0..PAIRS {
        let seconds;
        (seconds, full) = timed(run_full)?;
        full_s.push(seconds);
        let seconds;
        (seconds, (plan, plain)) = timed(|| auto(&question, clip))?;
        auto_s.push(seconds);
    }
    let (full_s, auto_s) = (median(full_s), median(auto_s));
    let change = Change::between(&full, &plain, question.within)?;
    let limit = match plan.change.and_then(|change| change.limit) {
        Some(limit) => format!("{:.3} %", 100.0 * limit),
        None if plan.free.is_empty() => "-".to_owned(),
        None => "free".to_owned(),
    };
    let clip = clip.split('?').next().unwrap_or(clip);
    println!(
        "| {clip} | {name} | {full_s:.2} s | {auto_s:.2} s | {:.2} | {:.4} % | {limit} | {} | {} |",
        full_s / auto_s,
        100.0 * change.share,
        plan.choice,
        if auto_s > 1.05 * full_s + 0.1 {
            "slower"
        } else {
            "held"
        }
    );
    Ok(())
}

fn main() -> Result<(), Error> {
    let asked = std::env::args().nth(1);
    let is_asked = |name: &str| asked.as_deref().is_none_or(|asked| asked == name);
    println!(
        "| scene | sensor | full | auto | times as fast | change | limit | what ran | 1.05 times |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
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
