//! What `design` prints: the thresholds, the candidates, the one that is taken.

use std::fmt::Write as _;

use super::{Arguments, Exploration};
use crate::{
    compare::metric::Short,
    study::{
        equivalent::kept,
        exploration::{Candidate, NEARLY, Refused},
    },
    unit::{counted, frame_rate},
};

/// All of it.
pub(super) fn text(
    arguments: &Arguments,
    found: &Exploration,
    picked: usize,
    light: &str,
) -> String {
    let mut text = format!(
        "scene    {}, {} at {} frames/s\n{light}",
        arguments.clip.name(),
        counted(found.frames, "frame"),
        frame_rate(found.fps)
    );
    for rated in &found.rated {
        let thresholds: Vec<String> = rated.thresholds.iter().map(f64::to_string).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "rate     {:.4} events per pixel and second{}, with a memory of the {}: threshold {}",
            rated.rate,
            if rated.rates.len() > 1 {
                let each = rated.rates.iter().map(|rate| format!("{rate:.3}"));
                let each: Vec<String> = each.collect();
                format!(", all kinds together ({})", each.join(", "))
            } else {
                String::new()
            },
            rated.memory,
            thresholds.join(", ")
        );
    }
    let _ = writeln!(
        text,
        "\n{:>3}  {:<8} {:<38} {:>6} {:>6} {:>6} {:>6} {:>9}  {:<8} readout",
        "", "to", "remembers", "kept", "least", "words", "store", "frames/s", "front"
    );
    for (i, candidate) in found.candidates.iter().enumerate() {
        let mark = match candidate.on_front {
            _ if found.knee == Some(i) => "knee",
            true => "front",
            false => "",
        };
        let _ = writeln!(
            text,
            "{:>3}{} {:<8} {:<38} {:>6} {:>6} {:>6} {:>6} {:>9.0}  {:<8} {}",
            i + 1,
            if i == picked { ">" } else { " " },
            candidate.to.to_string(),
            candidate.memory,
            kept(candidate.kept, 3),
            kept(candidate.least_kept, 3),
            candidate.words,
            candidate.stored_words,
            candidate.frames_s[0],
            mark,
            candidate.readout.in_words()
        );
    }
    text += &refusals(found);
    if found.knee.is_none() {
        text += "no knee: no row keeps more than chance does\n";
    }
    let candidate = &found.candidates[picked];
    let _ = writeln!(
        text,
        "\ntaken    {}: {}, {}; {}, {} of {} that the chip carries",
        picked + 1,
        candidate.to,
        candidate.memory,
        counted(candidate.words, "word"),
        candidate.kinds.len(),
        counted(candidate.carried, "kind")
    );
    let width = { candidate.kinds.iter() }
        .map(|kind| kind.name.chars().count())
        .max()
        .unwrap_or(0);
    let _ = writeln!(
        text,
        "         {:<width$} {:>10} {:>8} {:>7} {:>7} {:>9}",
        "kind", "threshold", "LSB", "exact", "kept", "as much"
    );
    for kind in &candidate.kinds {
        let _ = writeln!(
            text,
            "         {:<width$} {:>10} {:>8.2} {:>7} {:>7} {:>9}",
            kind.name,
            kind.threshold,
            kind.threshold_lsb,
            kept(kind.exact.kept, 3),
            kept(kind.silicon.kept, 3),
            kind.silicon.equivalent()
        );
    }
    text + &reading(found, candidate)
}

/// How the table is read.
fn reading(found: &Exploration, candidate: &Candidate) -> String {
    let kinds = candidate.kinds.len();
    let mean = if kinds == candidate.kept_kinds {
        "the kinds".to_owned()
    } else {
        // The others have no event to keep.
        format!("{} of {kinds} kinds", candidate.kept_kinds)
    };
    format!(
        "kept: the part of F1 above chance with the chip's errors, mean over {mean}, within {}; least: of the\nkind that keeps least; exact: without the errors, within the range of registers (exec --domain exact --clip on);\nas much: the change of threshold that costs as much; frames/s: at least, with the cheapest readout that loses no\nevent of this scene. The knee is the shortest program on the front that keeps at least {:.0} % of the most kept.\n",
        Short(found.window_us),
        100.0 * NEARLY
    )
}

/// What there is no program for, quantisers that are refused for the same reason together.
fn refusals(found: &Exploration) -> String {
    let mut all: Vec<(String, &Refused)> = Vec::new();
    for refused in &found.refused {
        let alike = |(_, other): &&mut (String, &Refused)| {
            (&other.memory, &other.why) == (&refused.memory, &refused.why)
        };
        match all.iter_mut().find(alike) {
            Some((names, _)) => {
                names.push_str(", ");
                names.push_str(&refused.to);
            }
            None => all.push((refused.to.clone(), refused)),
        }
    }
    let lines = all.iter().map(|(to, refused)| match &refused.memory {
        Some(memory) => format!("  -  {to} with {memory}: {}\n", refused.why),
        None => format!("  -  {to}: {}\n", refused.why),
    });
    lines.collect()
}
