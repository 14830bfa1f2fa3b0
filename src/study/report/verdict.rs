//! The verdict: the questions that architects ask, answered in a line each, the same as a
//! paragraph, and how its words were chosen.

use std::fmt::Write as _;

use maud::{Markup, html};

use super::{
    fall, number,
    part::{Part, Place, part},
};
use crate::{
    isa::Evidence,
    study::{
        feasibility::{
            Feasibility, Fit,
            tornado::{Turn, decisive},
        },
        quantisation::{Outcome, Row},
        waterfall::{Rates, Share},
    },
};

/// A question, and the answer in a line.
struct Line {
    question: &'static str,
    /// The part of the page that has the whole answer.
    part: &'static str,
    answer: String,
    /// Its number; none where there is none.
    number: Option<Markup>,
    evidence: Option<Evidence>,
}

/// The table, then the paragraph.
pub(super) fn section(all: &Feasibility, place: &Place) -> Part {
    let verdict = &all.verdict;
    part(
        "verdict",
        "Verdict",
        html! {
            p.headline { strong { (verdict.headline) } }
            (table(&lines(all), place))
            p.verdict { (verdict.paragraph()) }
        },
    )
}

fn table(lines: &[Line], place: &Place) -> Markup {
    html! {
        table.answers {
            caption { "The questions, and where on this page each answer comes from" }
            thead { tr {
                th scope="col" { "Question" }
                th scope="col" { "Answer" }
                th scope="col" { "Number" }
                th scope="col" { "Evidence" }
            } }
            tbody {
                @for line in lines {
                    tr {
                        th scope="row" { a href=(place.link(line.part)) { (line.question) } }
                        td.answer { (line.answer) }
                        td.n { (line.number.clone().unwrap_or_else(number::none)) }
                        td { @if let Some(evidence) = line.evidence { (number::evidence(evidence)) } @else { (number::none()) } }
                    }
                }
            }
        }
    }
}

fn lines(all: &Feasibility) -> [Line; 7] {
    [
        task(all),
        emit(all),
        trade_offs(all),
        fits(all),
        fast(all),
        power(all),
        decides(all),
    ]
}

/// The word of a finding.
fn word(all: &Feasibility, about: &str) -> Option<&'static str> {
    let mut findings = all.verdict.findings.iter();
    findings
        .find(|finding| finding.about == about)
        .map(|finding| finding.word)
}

/// The row of the kernel as it was chosen, with its place in the JSON.
fn chosen(all: &Feasibility) -> Option<(usize, &Row)> {
    let mut rows = all.quantisation.iter().enumerate();
    rows.find(|(_, row)| row.to == all.chosen.to)
}

fn task(all: &Feasibility) -> Line {
    let answer = match word(all, "fidelity") {
        Some(word) => format!(
            "{} in {}: its events are {word}",
            all.kernel.name, all.chosen.to
        ),
        None => format!("Not {}: there is no program", all.kernel.name),
    };
    let kept = chosen(all).and_then(|(i, row)| match &row.outcome {
        Outcome::OnChip(chip) if chip.silicon.is_judged() => Some((i, row.headline?, chip.silicon)),
        Outcome::OnChip(_) | Outcome::Refused(_) => None,
    });
    Line {
        question: "Which task belongs on the sensor?",
        part: "task",
        answer,
        number: kept.map(|(i, headline, silicon)| {
            let at = |key: &str| format!("/quantisation/{i}/{key}");
            html! {
                "kept " (number::fixed_or_none(&at("kept"), headline.kept, 3))
                @if headline.threshold_equivalent_percent.is_some() {
                    ", as a threshold "
                    (number::equivalent(&at("threshold_equivalent_percent"), headline.threshold_equivalent_percent, silicon.threshold_equivalent_is_least))
                    " higher"
                }
                span.of {
                    "within " (number::scaled(&at("window_us"), headline.window_us.0 as f64, 1e-3)) " ms, at "
                    (number::plain(&at("fps"), headline.fps)) " frames/s"
                }
                (over_chips(all))
            }
        }),
        evidence: kept.map(|_| all.over_chips.chips_evidence.unwrap_or(Evidence::Modelled)),
    }
}

/// What the chips that the public data allow keep, and on how many of them it is feasible.
fn over_chips(all: &Feasibility) -> Markup {
    let over = &all.over_chips;
    let judged = over.chips_feasible.zip(over.ranges.as_ref());
    html! {
        @if let Some((share, ranges)) = judged {
            span.line {
                @if let Some(kept) = ranges.kept {
                    (number::fixed("/ranges/kept/p10", kept.p10, 3)) " to "
                    (number::fixed("/ranges/kept/p90", kept.p90, 3))
                }
                span.of {
                    "on 10 to 90 % of " (number::plain("/chips", over.chips as f64))
                    " chips that the public data allow; feasible on "
                    (number::scaled("/chips_feasible", share, 100.0)) " %"
                    @if let Some([least, most]) = over.chips_feasible_95 {
                        " (" (number::scaled("/chips_feasible_95/0", least, 100.0)) " to "
                        (number::scaled("/chips_feasible_95/1", most, 100.0)) " % of all such, with 95 %)"
                    }
                }
            }
        }
    }
}

fn emit(all: &Feasibility) -> Line {
    // The chip's events, where there are any, and what does not depend on them.
    let rows = all.link.rows.iter().enumerate();
    let ways = || {
        rows.clone().filter(|(_, row)| {
            let other = ["events of the plain DVS", "events of the float sensor"];
            !other.contains(&row.what.as_str())
        })
    };
    let by_bits = |a: &f64, b: &f64| a.total_cmp(b);
    let least = ways().min_by(|a, b| by_bits(&a.1.kbit_s, &b.1.kbit_s));
    let most = ways().max_by(|a, b| by_bits(&a.1.kbit_s, &b.1.kbit_s));
    Line {
        question: "What should it emit?",
        part: "emit",
        answer: least.map_or("Nothing was sent".to_owned(), |(_, row)| {
            format!("Fewest bits: {}", row.what)
        }),
        number: least.zip(most).map(|((i, least), (k, most))| {
            html! {
                (number::plain(&format!("/link/rows/{i}/kbit_s"), least.kbit_s))
                " of " (number::plain(&format!("/link/rows/{k}/kbit_s"), most.kbit_s)) " kbit/s"
            }
        }),
        evidence: least.map(|_| Evidence::Modelled),
    }
}

fn trade_offs(all: &Feasibility) -> Line {
    let rows = || {
        let rows = all.quantisation.iter().enumerate();
        rows.filter_map(|(i, row)| match &row.outcome {
            Outcome::OnChip(chip) if chip.silicon.is_judged() => {
                Some((i, row, row.headline?.kept?, chip.words))
            }
            Outcome::OnChip(_) | Outcome::Refused(_) => None,
        })
    };
    let fewest = rows().min_by_key(|(.., words)| *words);
    let most = rows().max_by(|a, b| a.2.total_cmp(&b.2));
    Line {
        question: "What are the trade-offs?",
        part: "trade-offs",
        answer: match fewest.zip(most) {
            None if all.quantisation.iter().any(|row| words(row).is_some()) => {
                "This scene cannot tell what they keep".to_owned()
            }
            None => "No candidate has a program".to_owned(),
            Some((a, b)) if a.0 == b.0 => {
                format!("{} has the fewest words and keeps most", a.1.to)
            }
            Some((a, b)) => format!("Fewest words: {}; keeps most: {}", a.1.to, b.1.to),
        },
        number: fewest.zip(most).map(|(a, b)| {
            let row = |(i, _, kept, words): (usize, &Row, f64, u64)| {
                html! {
                    (number::plain(&format!("/quantisation/{i}/on_chip/words"), words as f64))
                    " words keep " (number::fixed(&format!("/quantisation/{i}/kept"), kept, 3))
                }
            };
            html! { (row(a)) @if a.0 != b.0 { span.line { (row(b)) } } }
        }),
        evidence: fewest.map(|_| Evidence::Modelled),
    }
}

/// Instruction words a frame, of a row that has a program.
fn words(row: &Row) -> Option<u64> {
    match &row.outcome {
        Outcome::OnChip(chip) => Some(chip.words),
        Outcome::Refused(_) => None,
    }
}

fn fits(all: &Feasibility) -> Line {
    let chip = match &all.fit {
        Fit::OnChip(chip) => Some(chip),
        Fit::Refused(_) => None,
    };
    Line {
        question: "Does it fit?",
        part: "chip",
        answer: word(all, "room").unwrap_or("does not fit").to_owned(),
        number: chip.map(|chip| {
            html! {
                (number::plain("/fit/on_chip/stored_words", chip.stored_words as f64))
                " of " (number::plain("/fit/on_chip/store/low", chip.store.low)) " words"
                span.line {
                    (number::plain("/fit/on_chip/registers", chip.registers as f64))
                    " of " (number::plain("/fit/on_chip/registers_of", chip.registers_of as f64)) " registers"
                }
            }
        }),
        evidence: chip.map(|chip| chip.store.evidence),
    }
}

fn fast(all: &Feasibility) -> Line {
    let time = match &all.fit {
        Fit::OnChip(chip) => Some(&chip.time),
        Fit::Refused(_) => None,
    };
    Line {
        question: "How fast?",
        part: "chip",
        answer: word(all, "speed").unwrap_or("there is no program").to_owned(),
        number: time.map(|time| {
            html! {
                "at most " (number::known("/fit/on_chip/time/ceiling", &time.ceiling))
                span.of {
                    (number::plain("/scene/fps", all.scene.fps)) " asked for; "
                    (number::known("/fit/on_chip/time/ceiling_as_programmed", &time.ceiling_as_programmed))
                    " with all slots of the program"
                }
            }
        }),
        evidence: time.map(|time| time.ceiling.evidence),
    }
}

fn power(all: &Feasibility) -> Line {
    let power = all.power.as_ref();
    Line {
        question: "How much power?",
        part: "power",
        answer: match power {
            Some(power) => {
                let parts = power.parts();
                let unknown = parts.iter().filter(|part| part.power.is_none());
                let unknown: Vec<_> = unknown.map(|part| part.what).collect();
                format!(
                    "Of what is known, at the scene\u{2019}s frame rate; not known: {}",
                    unknown.join(", ")
                )
            }
            None => "There is no program".to_owned(),
        },
        number: power.map(|power| {
            html! {
                (number::known("/power/known", &power.known))
                span.of { (number::known("/power/frame", &power.frame)) " a frame" }
            }
        }),
        evidence: power.map(|power| power.known.evidence),
    }
}

fn decides(all: &Feasibility) -> Line {
    let largest = all.over_rates.as_ref().and_then(Rates::costliest);
    let turn = fall::deciding(all).next();
    let answer = match word(all, "what limits") {
        Some(limit) => {
            let mut answer = format!("It loses most to: {limit}");
            if let Some((_, share)) = largest {
                let _ = write!(
                    answer,
                    "; of the chip\u{2019}s steps {} takes most",
                    share.name
                );
            }
            if let Some((_, turn)) = turn {
                let alike = decisive(&all.over_chips.tornado).iter();
                let names: Vec<&str> = alike.map(|turn| turn.figure.as_str()).collect();
                let names = match &names[..] {
                    [] => turn.figure.clone(),
                    names => names.join(" and "),
                };
                let _ = write!(answer, "; of what nobody states exactly {names}");
            }
            answer
        }
        None => "Nothing: there is no program, or nothing to keep".to_owned(),
    };
    let number = turn.and_then(|(i, turn)| moved(i, turn));
    Line {
        question: "What decides?",
        part: if fall::is_there(all) {
            "decides"
        } else {
            "trade-offs"
        },
        answer,
        number: number.or_else(|| largest.and_then(|(i, share)| taken(i, share))),
        evidence: match (turn, largest) {
            (Some((_, turn)), _) => Some(turn.evidence),
            (None, largest) => largest.map(|_| Evidence::Modelled),
        },
    }
}

/// From what to what one number moves what is kept.
fn moved(i: usize, turn: &Turn) -> Option<Markup> {
    let at = |key: &str| format!("/tornado/{i}/{key}");
    let [at_low, at_high, _] = turn.kept()?;
    Some(html! {
        "kept " (number::fixed(&at("kept_at_low"), at_low, 3)) " to "
        (number::fixed(&at("kept_at_high"), at_high, 3))
        span.of {
            (turn.figure) " from " (number::plain(&at("low"), turn.low)) " to "
            (number::plain(&at("high"), turn.high))
            @if turn.unit != "1" { " " (number::unit(turn.unit)) }
        }
    })
}

/// What one step takes at the clip's own frame rate.
fn taken(i: usize, share: &Share) -> Option<Markup> {
    let at = format!("/over_rates/rates/0/causes/{i}/share");
    Some(html! {
        (number::fixed(&at, share.share?, 3))
        span.of { "of what there is to keep" }
    })
}

/// Which rule chose which word.
pub(super) fn rules(all: &Feasibility) -> Part {
    let verdict = &all.verdict;
    part(
        "rules",
        "How the words of the verdict were chosen",
        html! {
            p { "Each word follows from the numbers above by a rule; nothing else is in the verdict." }
            table.rules {
                caption { "Words of the verdict and their rules" }
                thead { tr { th scope="col" { "About" } th scope="col" { "Word" } th scope="col" { "Rule" } } }
                tbody {
                    tr { th scope="row" { "headline" } td { (verdict.headline) } td { (verdict.rule) } }
                    @for finding in &verdict.findings {
                        tr { th scope="row" { (finding.about) } td { (finding.word) } td { (finding.rule) } }
                    }
                }
            }
        },
    )
}
