//! Several kernels: each in few values, and all of them in one program.

use std::fmt::Write as _;

use miette::miette;

use super::{Arguments, Row, drawn, erased, short, table};
use crate::{
    cli::{
        arguments::{budget, light},
        input::kernels::Kinds,
        output::progress::Progress,
    },
    isa::Device,
    limit::KERNELS,
    photoreceptor::Response,
    rig::guard::{Guard, Warning},
    scene::{Observation, Scene as _},
    study::{
        design::Design,
        equivalent::{self, Likeness, RUNGS},
        joint::{Joint, JointOutcome},
    },
    unit::frame_rate,
};

/// One kernel in few values.
#[derive(serde::Serialize)]
struct Kind {
    name: String,
    kernel: Vec<Vec<f64>>,
    sum: f64,
    quantised: Vec<Row>,
}

#[derive(serde::Serialize)]
struct Json {
    kernels: Vec<Kind>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    together: Vec<Joint>,
    #[serde(skip_serializing_if = "Option::is_none")]
    light: Option<serde_json::Value>,
    warnings: Vec<Warning>,
}

/// Prints each kernel in few values, and with thresholds what all of them are in one program.
///
/// # Errors
/// When a kernel is not to be had in any of the ways that were asked for, or the scene cannot be
/// read.
pub(super) fn run(
    arguments: &Arguments,
    kinds: &Kinds,
    thresholds: Option<&[f64]>,
) -> miette::Result<()> {
    if arguments.output.is_some() || arguments.picture.is_some() {
        return Err(miette!(
            help = "give one of them, an array of shape (k,k), for --output and --picture",
            "{} holds {} kernels",
            arguments.kernels,
            kinds.kernels.len()
        ));
    }
    let (mut all, mut warnings) = (Vec::new(), Vec::new());
    for (name, kernel) in kinds.names.iter().zip(&kinds.kernels) {
        let tried = arguments.quantised(name, kernel)?;
        warnings.extend(erased(Some(name), kernel, &tried));
        let rows = { tried.iter() }.map(|(to, few)| Row::new(*to, kernel, few.as_ref()));
        all.push(Kind {
            name: name.clone(),
            kernel: kernel.rows(),
            sum: kernel.sum(),
            quantised: rows.collect(),
        });
    }
    light::warn(&warnings);
    let observation = Observation::new();
    let mut programs = Vec::new();
    if let Some(thresholds) = thresholds {
        programs = together(arguments, (kinds, thresholds), &observation, &mut warnings)?;
    }
    if arguments.json {
        let json = Json {
            light: (!programs.is_empty()).then(|| light::json(&observation)),
            kernels: all,
            together: programs,
            warnings,
        };
        let json = serde_json::to_string(&json).map_err(|e| miette!("{e}"))?;
        crate::cli::say(&format!("{json}\n"));
        return Ok(());
    }
    let mut text = String::new();
    for (kind, kernel) in all.iter().zip(&kinds.kernels) {
        let _ = writeln!(text, "{}, sum {}", kind.name, short(kernel.dc()));
        text += &drawn(kernel);
        text += &table(&kind.quantised);
        text.push('\n');
    }
    if !programs.is_empty() {
        text += &program_table(arguments, &programs, kinds.kernels.len());
        text += &light::line(&observation);
    }
    crate::cli::say(&text);
    Ok(())
}

/// All kernels in one program, for each quantiser, run beside the float sensor.
fn together(
    arguments: &Arguments,
    (kinds, thresholds): (&Kinds, &[f64]),
    observation: &Observation,
    warnings: &mut Vec<Warning>,
) -> miette::Result<Vec<Joint>> {
    let device = Device::find(arguments.chip())?;
    let scene = arguments.clip.open(observation)?;
    arguments.clip.check_fits(&*scene, &device)?;
    budget::check_study(&*scene, (RUNGS.len() + 1) * kinds.kernels.len() + 2)?;
    let (frames, fps) = (scene.frames(), scene.fps());
    drop(scene);
    let search = (arguments.effort(), arguments.seed());
    let floats = Design::each(&kinds.kernels, thresholds, &device, search);
    let shows = arguments.to.len() as u64;
    let progress = Progress::new("watching", frames.map(|frames| shows * frames));
    let mut guard = Guard::new();
    let mut programs = Vec::new();
    for to in &arguments.to {
        let mut scene = arguments.clip.open(observation)?;
        programs.push(Joint::new(
            &kinds.names,
            &floats,
            (*to, arguments.sum.into(), kinds.memory),
            (arguments.window.at(fps), &mut *scene),
            &mut guard,
            || progress.tick(),
        )?);
    }
    progress.finish();
    let of_scene = Warning::of_scene(observation, Response::IDENTITY);
    let own = guard.warnings();
    light::warn(&of_scene);
    light::warn(&own);
    warnings.splice(0..0, of_scene);
    warnings.extend(own);
    Ok(programs)
}

/// A line for each program, and one for each of its kinds.
fn program_table(arguments: &Arguments, programs: &[Joint], kinds: usize) -> String {
    let mut text = format!(
        "all {kinds} kernels in one program on {}, on {}\n{:<16} {:>6} {:>6} {:>6} {:>9} {:>9} {:>8}  memory\n",
        arguments.chip(),
        arguments.clip.name(),
        "quantiser",
        "words",
        "store",
        "us",
        "frames/s",
        "computed",
        "carries",
    );
    for program in programs {
        let _ = match &program.outcome {
            JointOutcome::Refused(why) => writeln!(text, "{:<16} {}", program.to, why.join(". ")),
            JointOutcome::OnChip(chip) => writeln!(
                text,
                "{:<16} {:>6} {:>6} {:>6.1} {:>9.0} {:>9.0} {:>8}  {}",
                program.to,
                chip.words,
                chip.stored_words,
                chip.array_us,
                chip.frames_per_s,
                chip.frames_per_s_of_compute,
                chip.carried,
                chip.memory
            ),
        };
    }
    for program in programs {
        let JointOutcome::OnChip(chip) = &program.outcome else {
            continue;
        };
        let _ = writeln!(
            text,
            "\n{}, against {}\n{:<22} {:>6} {:>6} {:>7}  {:>6} {:>6} {:>7} {:>9}",
            program.to,
            chip.against,
            "exact, then silicon",
            "F1",
            "kept",
            "events",
            "F1",
            "kept",
            "events",
            "threshold"
        );
        for kind in &chip.kinds {
            let score = |score: &Likeness| {
                let ratio = score.event_ratio;
                let ratio = ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.3}"));
                let kept = equivalent::kept(score.kept, 3);
                let f1 =
                    { score.event_ratio }.map_or("-".to_owned(), |_| format!("{:.3}", score.f1));
                format!("{f1:>6} {kept:>6} {ratio:>7}")
            };
            let _ = writeln!(
                text,
                "{:<22} {}  {} {:>9}",
                kind.name,
                score(&kind.exact),
                score(&kind.silicon),
                kind.silicon.equivalent()
            );
        }
    }
    let fps = { programs.iter() }.find_map(|program| match &program.outcome {
        JointOutcome::OnChip(chip) => chip.kinds.first().map(|kind| kind.exact),
        JointOutcome::Refused(_) => None,
    });
    if let Some(score) = fps {
        let _ = writeln!(
            text,
            "\nmatched within {} at {} frames/s. kept: the part of F1 above chance. us: on the array; frames/s with all slots of the\nreadout, computed: without it. carries: kinds like these that the chip has registers and words for,\n{KERNELS} at most in one program.",
            crate::compare::metric::Short(score.window_us),
            frame_rate(score.fps)
        );
    }
    text
}
