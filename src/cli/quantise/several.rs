//! Several kernels: each in few values, and all of them in one program.

use std::fmt::Write as _;

use super::{Arguments, drawn, short, table};
use crate::{
    kernel::Kernel,
    limit::KERNELS,
    study::{
        equivalent::{self, Likeness},
        joint::{Joint, JointOutcome},
        quantised::Several,
    },
    unit::frame_rate,
};

/// What is said of each kernel in few values, and of what all of them are in one program.
pub(super) fn text(arguments: &Arguments, kernels: &[Kernel], all: &Several) -> String {
    let mut text = String::new();
    for (kind, kernel) in all.kernels.iter().zip(kernels) {
        let name = kind.name.as_deref().unwrap_or_default();
        let _ = writeln!(text, "{name}, sum {}", short(kernel.dc()));
        text += &drawn(kernel);
        text += &table(&kind.quantised);
        text.push('\n');
    }
    if !all.together.is_empty() {
        text += &program_table(arguments, &all.together, kernels.len());
    }
    text
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
