//! The numbers in words, by rules that are stated beside them.
//!
//! Every finding names what it is about, the word, the sentence, and the rule that chose the
//! word. Nothing else goes into the verdict.

use super::{Feasibility, Fit, Stream, chip::OnChip, stream::Judged, time::Binds};
use crate::study::{quantisation::Outcome, waterfall::Step};

/// The verdict: a headline, and a sentence for each finding.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Verdict {
    /// In a few words.
    pub headline: String,
    /// How the headline was chosen.
    pub rule: String,
    /// What it rests on.
    pub findings: Vec<Finding>,
}

/// One thing that the numbers say.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Finding {
    /// What it is about.
    pub about: &'static str,
    /// The word that was chosen.
    pub word: &'static str,
    /// The sentence.
    pub says: String,
    /// How the word is chosen.
    pub rule: String,
}

/// From which share of the way between floor and ceiling events count as kept, as mostly kept,
/// and as half kept.
const KEPT: [f64; 3] = [0.95, 0.80, 0.50];
/// From which ratio of the ceiling to the frame rate there is room to spare.
const ROOM: f64 = 2.0;
/// Which ratios of events count as about as many.
const ABOUT: [f64; 2] = [0.8, 1.25];
/// From how many standard deviations of noise a threshold is clear of it, and well clear.
const CLEAR: [f64; 2] = [3.0, 5.0];
/// Up to which error of its weights a mesh carries a kernel, and comes near it.
const CARRIED: [f64; 2] = [0.05, 0.20];
/// The word on fidelity where there is nothing to keep.
const SILENT: &str = "nothing to keep";
/// Below which loss of F1 nothing is to be blamed for it.
const LITTLE: f64 = 0.05;

impl Verdict {
    /// Of all the numbers.
    pub(super) fn new(all: &Feasibility) -> Self {
        let mut findings = vec![room(all)];
        let mut speed_word = "";
        let mut kept_word = "";
        if let Fit::OnChip(chip) = &all.fit {
            let speed = speed(chip, all.scene.fps);
            speed_word = speed.word;
            findings.push(speed);
        }
        if let Some(judged) = all.streams.silicon.as_ref().and_then(|s| s.judged) {
            let kept = kept(&judged, all.streams.float.events);
            kept_word = kept.word;
            findings.push(kept);
            if kept_word != SILENT
                && let Some(exact) = all.streams.exact.as_ref().and_then(|s| s.judged)
            {
                findings.push(limit(&exact, &judged, all));
            }
        }
        if let Some(chip) = &all.streams.silicon {
            findings.push(against_dvs(chip, &all.streams.dvs));
        }
        if let Fit::OnChip(chip) = &all.fit {
            findings.extend(noise(chip));
        }
        findings.extend(mesh(all));
        let fits = findings.first().is_some_and(|room| room.word == "fits");
        let headline = match (fits, speed_word, kept_word) {
            (false, ..) => "Does not fit",
            (true, "too slow", _) => "Fits, but is too slow",
            (true, _, SILENT) => "Fits, but this scene cannot judge it",
            (true, _, "kept" | "mostly kept") => "Feasible",
            (true, _, "half kept") => "Feasible, with loss",
            (true, ..) => "Runs, but what comes out is mostly not what the kernel says",
        };
        Self {
            headline: headline.to_owned(),
            rule: "\u{201c}Does not fit\u{201d} where there is no program or the scene is larger than the array; else \u{201c}too slow\u{201d} where that is the word on speed; else by the word on fidelity: kept and mostly kept are feasible, half kept is feasible with loss; without an event to keep the scene cannot judge.".to_owned(),
            findings,
        }
    }

    /// The sentences, one after the other.
    #[must_use]
    pub fn paragraph(&self) -> String {
        let all: Vec<&str> = self.findings.iter().map(|f| f.says.as_str()).collect();
        all.join(" ")
    }
}

fn percent(part: f64) -> String {
    format!("{:.0} %", 100.0 * part)
}

/// How often one goes into another.
fn times(ratio: f64) -> String {
    if ratio < ROOM {
        percent(ratio)
    } else {
        format!("{ratio:.1} times")
    }
}

/// Whether there is a program, and whether the scene fits the array.
fn room(all: &Feasibility) -> Finding {
    let (scene, chip) = (&all.scene, &all.chip);
    let too_large = scene.width as u64 > chip.width || scene.height as u64 > chip.height;
    let (word, says) = match &all.fit {
        Fit::Refused(why) => (
            "does not fit",
            format!(
                "{} as {} does not fit {}: {why}.",
                all.kernel.name, all.chosen.to, chip.name
            ),
        ),
        Fit::OnChip(_) if too_large => (
            "does not fit",
            format!(
                "The scene has {}x{} pixels and {} has {}x{}: what is said below is of an array as large as the scene.",
                scene.width, scene.height, chip.name, chip.width, chip.height
            ),
        ),
        Fit::OnChip(it) => (
            "fits",
            format!(
                "{} as {} fits {}: {} words of the {} in its store, {} of {} analogue registers, {:.1} \u{b5}s of the array's time a frame.",
                all.kernel.name,
                all.chosen.to,
                chip.name,
                it.stored_words,
                it.store.low,
                it.registers,
                it.registers_of,
                it.time.array.high
            ),
        ),
    };
    Finding {
        about: "room",
        word,
        says,
        rule: "fits: the compiler has a program that the store and the registers hold, and the array has at least the scene's rows and columns.".to_owned(),
    }
}

fn speed(chip: &OnChip, fps: f64) -> Finding {
    let ceiling = chip.time.ceiling.low;
    let (word, opinion) = if ceiling < fps {
        ("too slow", "which is too slow")
    } else if ceiling < ROOM * fps {
        ("just fast enough", "which is just enough")
    } else {
        ("fast enough", "with room to spare")
    };
    let binds = match chip.time.binds {
        Binds::Array => "the array's words bind",
        Binds::Readout => "the readout binds, not the computing",
        Binds::Exposure => "the exposure binds",
    };
    Finding {
        about: "speed",
        word,
        says: format!(
            "It reaches {ceiling:.0} frames/s for the {fps} that the scene asks for, {opinion}; {binds}."
        ),
        rule: format!(
            "too slow: ceiling below the frame rate; just fast enough: below {ROOM} times it; else fast enough. What takes longest of array, exposure and readout binds."
        ),
    }
}

fn kept(judged: &Judged, float_events: u64) -> Finding {
    let [all, most, half] = KEPT;
    let f1 = judged.f1;
    let word = if float_events == 0 {
        SILENT
    } else if f1.kept >= all {
        "kept"
    } else if f1.kept >= most {
        "mostly kept"
    } else if f1.kept >= half {
        "half kept"
    } else {
        "mostly lost"
    };
    let says = if word == SILENT {
        "The float kernel has no event on this scene, so nothing can be said of fidelity."
            .to_owned()
    } else {
        format!(
            "With the chip's errors the float kernel's events are {word}: F1 is {:.3}, where accident gives {:.3} and perfection {:.0}.",
            f1.value, f1.floor, f1.ceiling
        )
    };
    Finding {
        about: "fidelity",
        word,
        says,
        rule: format!(
            "share of the way from floor to ceiling that F1 has gone; kept: from {all}; mostly kept: from {most}; half kept: from {half}; else mostly lost. Nothing to keep: the float kernel has no event."
        ),
    }
}

/// Few values, or the chip.
fn limit(exact: &Judged, silicon: &Judged, all: &Feasibility) -> Finding {
    let few = exact.f1.ceiling - exact.f1.value;
    let chip = exact.f1.value - silicon.f1.value;
    let (word, says) = if few.max(chip) < LITTLE {
        (
            "little",
            "Neither the few values nor the chip's errors cost much.".to_owned(),
        )
    } else if few >= chip {
        (
            "few values",
            format!(
                "Most of the loss is the kernel's few values ({few:.3} of F1; the chip's errors take {chip:.3})."
            ),
        )
    } else {
        let better = all.quantisation.iter().filter(|row| match &row.outcome {
            Outcome::OnChip(other) => other.silicon.f1 > silicon.f1.value + LITTLE,
            Outcome::Refused(_) => false,
        });
        let others: Vec<&str> = better.map(|row| row.to.as_str()).collect();
        let advice = if others.is_empty() {
            String::new()
        } else {
            format!(" In other values it keeps more: {}.", others.join(", "))
        };
        (
            "the chip's errors",
            format!(
                "Most of the loss is the chip's errors ({chip:.3} of F1; the kernel's few values take {few:.3}){}.{advice}",
                largest(all)
            ),
        )
    };
    Finding {
        about: "what limits",
        word,
        says,
        rule: format!(
            "F1 lost from the float kernel to the program without errors, and from there to the chip; the larger is named, where it is at least {LITTLE}. Above all: the step of the chip that changes most events in the waterfall."
        ),
    }
}

/// The step of the chip that changes most.
fn largest(all: &Feasibility) -> String {
    let steps = all.waterfall.iter().flat_map(|w| &w.steps);
    let chip = steps.filter(|step| !step.cause.is_float());
    let largest = chip.max_by(|a, b| {
        let changed = |step: &Step| step.forward_share.changed();
        changed(a).total_cmp(&changed(b))
    });
    largest.map_or(String::new(), |step| format!(", above all {}", step.name))
}

fn against_dvs(chip: &Stream, dvs: &Stream) -> Finding {
    let ratio = (dvs.events > 0).then(|| chip.events as f64 / dvs.events as f64);
    let [few, many] = ABOUT;
    let word = match ratio {
        None => "no comparison",
        Some(ratio) if ratio < few => "fewer",
        Some(ratio) if ratio > many => "more",
        Some(_) => "about as many",
    };
    let says = match ratio {
        None => "A plain DVS at the same threshold says nothing in this scene.".to_owned(),
        Some(ratio) => format!(
            "It sends {word} events {} a plain DVS at the same threshold: {} the number, and the bits.",
            if word == "about as many" {
                "as"
            } else {
                "than"
            },
            times(ratio)
        ),
    };
    let says = match chip.dropped {
        0 => says,
        dropped => format!("{says} Besides, {dropped} found no slot in the readout."),
    };
    Finding {
        about: "events",
        word,
        says,
        rule: format!(
            "events of the chip for each of the DVS's; fewer: below {few}; more: above {many}; else about as many."
        ),
    }
}

fn noise(chip: &OnChip) -> Option<Finding> {
    let margin = chip.noise.margin?;
    let [least, well] = CLEAR;
    let (word, says) = if margin >= well {
        ("clear of noise", "well clear of the noise of the chip")
    } else if margin >= least {
        (
            "near the noise",
            "clear of the noise of the chip, but not by much",
        )
    } else {
        (
            "in the noise",
            "within the noise of the chip: a still scene would fire",
        )
    };
    Some(Finding {
        about: "noise",
        word,
        says: format!(
            "The threshold of {:.2} LSB is {says}: {margin:.1} standard deviations of what two frames differ by (modelled, in part a guess).",
            chip.noise.threshold_lsb
        ),
        rule: format!(
            "threshold over the predicted temporal noise of a difference; clear: from {well}; near: from {least}; else in the noise."
        ),
    })
}

fn mesh(all: &Feasibility) -> Option<Finding> {
    let best = all.mesh.iter().min_by(|a, b| a.error.total_cmp(&b.error))?;
    let [carried, near] = CARRIED;
    let (word, says) = if best.error <= carried {
        ("carries it", "would carry this kernel")
    } else if best.error <= near {
        ("comes near", "would come near this kernel")
    } else {
        ("cannot", "cannot carry this kernel")
    };
    Some(Finding {
        about: "mesh",
        word,
        says: format!(
            "A resistor mesh of {} {says}: {} of it is left over. {}",
            match best.sheets.len() {
                1 => "one sheet".to_owned(),
                n => format!("{n} sheets"),
            },
            percent(best.error),
            if best.turned <= 0.005 {
                "Turned or mirrored it is the same, as equal resistors make it.".to_owned()
            } else {
                format!(
                    "Any mesh of equal resistors would leave {}: turned or mirrored, the kernel is another.",
                    percent(best.turned)
                )
            }
        ),
        rule: format!(
            "relative error of the better of one sheet and two; carries: up to {carried}; comes near: up to {near}; else cannot."
        ),
    })
}
