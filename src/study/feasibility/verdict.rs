//! The numbers in words, by rules that are stated beside them.
//!
//! Every finding names what it is about, the word, the sentence, and the rule that chose the
//! word. Nothing else goes into the verdict.

use super::{
    Estimate, Feasibility, Fit, Stream,
    chip::OnChip,
    chips::{HALF, MOSTLY, OverChips},
    estimate::short,
    named::Named,
    stream::Judged,
    time::Binds,
    tornado::{LITTLE, Turn, decisive},
};
use crate::{
    compare::{metric::Short, window::CLEAR_FLOOR},
    rig::guard::Warning,
    study::{
        quantisation::Outcome,
        waterfall::{Cause, Rates, Share},
    },
    unit::counted,
};

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
const KEPT: [f64; 3] = [0.95, MOSTLY, HALF];
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
/// From which share of the chips it is one of nearly all of them, and up to which one of hardly
/// any.
const SHARES: [f64; 2] = [0.9, 0.1];

impl Verdict {
    /// Of all the numbers.
    pub(super) fn new(all: &Feasibility) -> Self {
        let mut findings = vec![room(all)];
        let mut speed_word = "";
        let mut kept_word = "";
        let mut chips_word = "";
        if let Fit::OnChip(chip) = &all.fit {
            let speed = speed(chip, &all.over_chips, all.scene.fps);
            speed_word = speed.word;
            findings.push(speed);
        }
        if let Some(chips) = over_chips(all) {
            chips_word = chips.word;
            findings.push(chips);
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
        findings.extend(guessed(all));
        let fits = findings.first().is_some_and(|room| room.word == "fits");
        let headline = match (fits, speed_word, kept_word, chips_word) {
            (false, ..) => "Does not fit",
            (true, "too slow", ..) => "Fits, but is too slow",
            (true, _, SILENT, _) => "Fits, but this scene cannot judge it",
            // The stretch that the chips watched may be still where the scene is not.
            (true, _, "kept" | "mostly kept", "") | (true, _, _, FEASIBLE) => "Feasible",
            (true, _, "half kept", "") | (true, _, _, WITH_LOSS) => "Feasible, with loss",
            (true, _, _, IN_SOME) => some_of(&all.over_chips),
            (true, ..) => "Runs, but keeps little of the kernel's events",
        };
        // What is drawn is in the headline only where it decided it.
        let share = if fits && speed_word != "too slow" && kept_word != SILENT {
            share(all)
        } else {
            String::new()
        };
        let [nearly, hardly] = SHARES.map(percent);
        let guesses = &all.chip.guessed_values;
        let decide: Vec<&str> = { guesses.iter().map(String::as_str) }
            .filter(|name| fits || Named::is_of_room(name))
            .collect();
        let is_open = headline == "Does not fit" || headline.starts_with("Feasible");
        let headline = if is_open && !decide.is_empty() {
            format!("Not known: it rests on guesses ({})", decide.join(", "))
        } else {
            headline.to_owned()
        };
        Self {
            headline: format!("{headline}{share}"),
            rule: format!(
                "\u{201c}Does not fit\u{201d} where there is no program or the scene is larger than the array; else \u{201c}too slow\u{201d} where that is the word on speed; without an event to keep, or where chance alone scores nearly 1, the scene cannot judge; else by the chips that the public data allow: feasible where {nearly} of them are, with loss where {nearly} are with loss or without, on some where more than {hardly} are. Not known instead, where a number that it rests on is a guess without an interval in the chip's data, or whether it fits lies within the interval of such a number."
            ),
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

/// The numbers that nobody knows, and of which none was drawn elsewhere.
fn guessed(all: &Feasibility) -> Option<Finding> {
    let guesses = &all.chip.guessed_values;
    (!guesses.is_empty()).then(|| Finding {
        about: "guesses",
        word: "not known",
        says: format!(
            "In the data of {} {} guessed without an interval. All chips then have the same value, or it stays open whether the program fits: the verdict holds if the guess is right. State an interval (low, high, why), or measure it.",
            all.chip.name,
            match &guesses[..] {
                [one] => format!("{one} is"),
                all => format!("{} are", all.join(", ")),
            }
        ),
        rule: "not known: a number on which events, time or room rest is a guess, and no interval is stated; or what is needed lies within the interval of such a number of the room.".to_owned(),
    })
}

/// The headline where it is feasible on some of the chips, whether or not without loss.
fn some_of(over: &OverChips) -> &'static str {
    match over.chips_feasible {
        Some(clean) if over.count(clean) > 0 => {
            "Feasible on some of the chips that the public data allow"
        }
        _ => "Feasible, with loss, on some of the chips that the public data allow",
    }
}

/// On how many of the chips it is feasible, for the headline.
fn share(all: &Feasibility) -> String {
    let over = &all.over_chips;
    let (Some(clean), Some(with_loss)) = (over.chips_feasible, over.chips_feasible_with_loss)
    else {
        return String::new();
    };
    let [clean, with_loss] = [clean, with_loss].map(|share| over.count(share));
    let events = all.streams.float.events;
    let few = Warning::few_events(events).map_or(String::new(), |_| {
        format!(", judged by no more than {}", counted(events, "event"))
    });
    let lossy = if with_loss > clean {
        format!(", with loss or without on {with_loss}")
    } else {
        String::new()
    };
    format!(
        " (without loss on {clean} of {} chips{lossy}{few})",
        over.chips
    )
}

/// The words on the chips.
const FEASIBLE: &str = "nearly all";
const WITH_LOSS: &str = "nearly all, with loss";
const IN_SOME: &str = "some";

/// The number that changes most of what is kept, and those that change nearly as much.
fn decides(tornado: &[Turn]) -> String {
    let Some((first, others)) = decisive(tornado).split_first() else {
        return String::new();
    };
    let told = |turn: &Turn| {
        let [at_low, at_high, _] = turn.kept()?;
        let [low, high] = [turn.low, turn.high].map(short);
        Some(format!(
            "{}: {low} to {high} {} keep {at_low:.2} to {at_high:.2}",
            turn.figure, turn.unit,
        ))
    };
    let alike: Vec<String> = others.iter().filter_map(told).collect();
    let alike = if alike.is_empty() {
        String::new()
    } else {
        format!(" Nearly as much does {}.", alike.join("; "))
    };
    let Some(first) = told(first) else {
        return String::new();
    };
    format!(" What decides is {first}, all else as stated.{alike}")
}

/// On how many of the chips that the public data allow it is feasible, and what decides.
fn over_chips(all: &Feasibility) -> Option<Finding> {
    let over = &all.over_chips;
    let (clean, with_loss) = (over.chips_feasible?, over.chips_feasible_with_loss?);
    let ranges = over.ranges.as_ref()?;
    let [nearly, hardly] = SHARES;
    let word = if clean >= nearly {
        FEASIBLE
    } else if with_loss >= nearly {
        WITH_LOSS
    } else if with_loss > hardly {
        IN_SOME
    } else {
        "hardly any"
    };
    let decides = decides(&over.tornado);
    let stretch = { over.stretch.as_ref() }
        .filter(|stretch| stretch.frames < stretch.of_frames)
        .map_or(String::new(), |stretch| {
            format!(
                " They were shown the first {} of {} frames.",
                stretch.frames, stretch.of_frames
            )
        });
    let of_such = over
        .chips_feasible_95
        .map_or(String::new(), |[least, most]| {
            format!(
                " ({} to {} of all such, with 95 %)",
                percent(least),
                percent(most)
            )
        });
    let keep = ranges.kept.map_or(String::new(), |kept| {
        format!(
            "; they keep {:.2} to {:.2} (10 to 90 % of them)",
            kept.p10, kept.p90
        )
    });
    Some(Finding {
        about: "chips",
        word,
        says: format!(
            "It is feasible on {} of {} chips that the public data allow{of_such}, with loss or without on {}{keep}.{decides}{stretch}",
            over.count(clean),
            over.chips,
            over.count(with_loss),
        ),
        rule: format!(
            "feasible: keeps at least {MOSTLY} and reaches the scene's frame rate; with loss: at least {HALF}. Nearly all: {} of the chips; some: more than {}. What decides is the number that changes most of what is kept from one end of its interval to the other, where that is at least {LITTLE}.",
            percent(nearly),
            percent(hardly)
        ),
    })
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
                "The scene has {}x{} pixels and {} has {}x{}: all below is for an array as large as the scene.",
                scene.width, scene.height, chip.name, chip.width, chip.height
            ),
        ),
        Fit::OnChip(it) => (
            "fits",
            format!(
                "{} as {} fits {}: it takes {} of the {} in its store, uses {} of {} analogue registers, and takes {} of the array's time a frame.",
                all.kernel.name,
                all.chosen.to,
                chip.name,
                crate::unit::counted(it.stored_words, "word"),
                it.store.low,
                it.registers,
                it.registers_of,
                micros(&it.time.array)
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

/// A time as people write it.
fn micros(time: &Estimate) -> String {
    time.to_string().replace(" us", " \u{b5}s")
}

fn speed(chip: &OnChip, over: &OverChips, fps: f64) -> Finding {
    // What a drawn chip says beside the chip of the seed, above all noise, is read out too.
    let mut ceiling = chip.time.ceiling.clone();
    let drawn = over.drawn.iter().map(|chip| chip.frames_s);
    let slowest = drawn.clone().fold(f64::INFINITY, f64::min);
    let is_drawn = slowest < ceiling.low;
    ceiling.low = ceiling.low.min(slowest);
    // Which readout is the cheapest depends on the chip: the one that is told is that of the
    // longest times.
    let lossless = chip.time.plans.iter().filter(|plan| plan.lost <= 0.0);
    let fastest = lossless.max_by(|a, b| a.frames_s.high.total_cmp(&b.frames_s.high));
    let fastest = fastest.filter(|plan| plan.frames_s.high > ceiling.high);
    if let Some(plan) = fastest {
        ceiling = ceiling.with(&plan.frames_s);
        ceiling.high = plan.frames_s.high;
    }
    ceiling.high = drawn.fold(ceiling.high, f64::max);
    let [least, most] = ceiling.ends();
    let (word, opinion) = if most < fps {
        ("too slow", "which is too slow")
    } else if least < fps {
        ("in doubt", "which may be too slow")
    } else if least < ROOM * fps {
        ("just fast enough", "which is just enough")
    } else {
        ("fast enough", "with room to spare")
    };
    let binds = match chip.time.binds {
        Binds::Array => "the array's words are the bottleneck",
        Binds::Readout => "the readout is the bottleneck, not the computation",
        Binds::Exposure => "the exposure is the bottleneck",
    };
    Finding {
        about: "speed",
        word,
        says: format!(
            "It reaches {ceiling} for the {fps} that the scene asks for, {opinion}; {binds} ({}, {}).{}{}",
            chip.time.plan.in_words(),
            chip.time.order.name(),
            if is_drawn {
                " The lowest is that of a drawn chip, which has more events to read out than the chip of the seed."
            } else {
                ""
            },
            fastest.map_or(String::new(), |plan| {
                format!(
                    " The highest is that of another readout ({}), on a chip where that is the cheaper one.",
                    plan.plan.in_words()
                )
            }),
        ),
        rule: format!(
            "too slow: the highest ceiling that the public data allow, by any readout that loses nothing, is below the frame rate; in doubt: the lowest is, which is that of the slowest drawn chip where the events that it has make it slower than all that the times of the data allow; just fast enough: the lowest is below {ROOM} times it; else fast enough. The longest of array, exposure and readout is the bottleneck."
        ),
    }
}

fn kept(judged: &Judged, float_events: u64) -> Finding {
    let [all, most, half] = KEPT;
    let likeness = &judged.likeness;
    let kept = likeness.kept.unwrap_or(0.0);
    let word = if !likeness.is_judged() {
        SILENT
    } else if kept >= all {
        "kept"
    } else if kept >= most {
        "mostly kept"
    } else if kept >= half {
        "half kept"
    } else {
        "mostly lost"
    };
    let says = if float_events == 0 {
        "The float kernel has no event on this scene, so nothing can be said of fidelity."
            .to_owned()
    } else if word == SILENT {
        format!(
            "Within {} chance alone gives an F1 of {:.3}: the scene is too short for this window, so nothing can be said of fidelity. Give a shorter one (--within), or a longer scene.",
            Short(likeness.window_us),
            likeness.floor
        )
    } else {
        let few = Warning::few_events(float_events).map_or(String::new(), |few| {
            format!(" But {}: {}.", few.seen, few.why)
        });
        format!(
            "With the chip's errors, each at the value of the chip's data, the float kernel's events are {word}: {likeness}. F1 is {:.3}; chance gives {:.3}, a perfect match 1.{few}",
            likeness.f1, likeness.floor
        )
    };
    Finding {
        about: "fidelity",
        word,
        says,
        rule: format!(
            "(F1 - floor) / (1 - floor); kept: from {all}; mostly kept: from {most}; half kept: from {half}; else mostly lost. Nothing to keep: the float kernel has no event, or the floor is above {CLEAR_FLOOR}. The threshold equivalent is the change of the float sensor's threshold that costs as much."
        ),
    }
}

/// Few values, or the chip.
fn limit(exact: &Judged, silicon: &Judged, all: &Feasibility) -> Finding {
    let [exact, silicon] = [exact, silicon].map(|judged| judged.headline.kept);
    let (few, chip) = match (exact, silicon) {
        (Some(exact), Some(silicon)) => (1.0 - exact, exact - silicon),
        _ => (0.0, 0.0),
    };
    let (word, says) = if exact.is_none() || silicon.is_none() {
        (
            SILENT,
            "There is nothing to keep here, so no loss can be attributed.".to_owned(),
        )
    } else if few.max(chip) < LITTLE {
        (
            "little",
            "Neither the few values nor the chip's errors cost much.".to_owned(),
        )
    } else if few >= chip
        && let Some(share) = without_errors(all)
    {
        (
            share.name,
            format!(
                "Most of the loss is {} ({few:.3} of all that could be kept is lost without the chip's errors, which cost {chip:.3}).",
                share.name
            ),
        )
    } else if few >= chip {
        (
            "few values",
            format!(
                "Most of the loss is the kernel's few values ({few:.3} of all that could be kept; the chip's errors cost {chip:.3})."
            ),
        )
    } else {
        let better = all.quantisation.iter().filter(|row| match &row.outcome {
            Outcome::OnChip(other) => { other.silicon.kept.zip(silicon) }
                .is_some_and(|(other, this)| other > this + LITTLE),
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
                "Most of the loss is the chip's errors ({chip:.3} of all that could be kept; the kernel's few values cost {few:.3}){}.{advice}",
                largest(all)
            ),
        )
    };
    Finding {
        about: "what limits",
        word,
        says,
        rule: format!(
            "The loss from the float kernel to the program without errors, and from there to the chip; the larger is named if it is at least {LITTLE}. Above all: the step of the chip with the largest loss in the waterfall over frame rate, at the scene's own rate."
        ),
    }
}

/// What takes more than the kernel's few values of a program without errors, in the waterfall.
fn without_errors(all: &Feasibility) -> Option<&Share> {
    let causes = &all.over_rates.as_ref()?.rates.first()?.causes;
    let others = [Cause::Format, Cause::Converter, Cause::Saturation];
    let of = |cause| causes.iter().find(|share| share.cause == cause);
    let taken = |share: &Share| share.share.unwrap_or(0.0);
    let kernel = of(Cause::Kernel).map_or(0.0, taken);
    { others.into_iter().filter_map(of) }
        .filter(|share| taken(share) > kernel.max(0.0))
        .max_by(|a, b| taken(a).total_cmp(&taken(b)))
}

/// The step of the chip that takes most of what there is to keep.
fn largest(all: &Feasibility) -> String {
    let largest = all.over_rates.as_ref().and_then(Rates::costliest);
    largest.map_or(String::new(), |(_, share)| {
        format!(", above all {}", share.name)
    })
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
        None => "A plain DVS at the same threshold has no event in this scene.".to_owned(),
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
        dropped => format!(
            "{says} With all slots of the program {dropped} of them would be lost; the readout stated here loses none."
        ),
    };
    Finding {
        about: "events",
        word,
        says,
        rule: format!(
            "events of the chip per event of the DVS; fewer: below {few}; more: above {many}; else about as many. The DVS applies the threshold to light: kernels with larger weights send more."
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
            "The threshold of {:.2} LSB is {says}: {margin:.1} standard deviations of the noise between two frames{} ({}).",
            chip.noise.threshold_lsb,
            chip.noise
                .least_margin
                .filter(|least| *least < margin)
                .map_or(String::new(), |least| format!(
                    ", {least:.1} at the most noise that the public data allow"
                )),
            chip.noise.temporal.evidence.word()
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
        ("comes near", "would approximate this kernel")
    } else {
        ("cannot", "cannot carry this kernel")
    };
    Some(Finding {
        about: "mesh",
        word,
        says: format!(
            "A resistor mesh of {} {says}: {} of it is left over. {}",
            match best.sheets.len() {
                0 => "no sheet, the pixel alone,".to_owned(),
                1 => "one sheet".to_owned(),
                n => format!("{n} sheets"),
            },
            percent(best.error),
            if best.turned <= 0.005 {
                "It is symmetric under rotation and reflection, as a mesh of equal resistors is."
                    .to_owned()
            } else {
                format!(
                    "Any mesh of equal resistors would leave {}: the kernel is not symmetric under rotation and reflection.",
                    percent(best.turned)
                )
            }
        ),
        rule: format!(
            "relative error of the better of one sheet and two; carries: up to {carried}; comes near: up to {near}; else cannot."
        ),
    })
}
