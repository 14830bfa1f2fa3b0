//! The verdict, its key figures, and how its words were chosen.

use maud::{Markup, html};

use super::{number, part::part};
use crate::study::feasibility::{Feasibility, Fit};

/// The verdict in a paragraph, and the figures that one looks for first.
pub(super) fn section(all: &Feasibility) -> Markup {
    let verdict = &all.verdict;
    part(
        "verdict",
        "Verdict",
        &html! {
            p.verdict { strong { (verdict.headline) ". " } (verdict.paragraph()) }
            dl.figures {
                @if let Fit::OnChip(chip) = &all.fit {
                    (figure("Program store", &html! {
                        (number::plain("/fit/on_chip/stored_words", chip.stored_words as f64))
                        span.of { " of " (number::plain("/fit/on_chip/store/low", chip.store.low)) " words" }
                    }))
                    (figure("Frame rate, at most", &html! {
                        (number::fixed("/fit/on_chip/time/ceiling/low", chip.time.ceiling.low, 0))
                        span.of { " frames/s" }
                    }))
                }
                @if let Some(share) = all.over_chips.chips_feasible {
                    (figure("Chips on which it is feasible", &html! {
                        (number::plain("/chips_feasible", share))
                        span.of { " of " (number::plain("/chips", all.over_chips.chips as f64)) " that the public data allow" }
                    }))
                }
                @if let Some(silicon) = &all.streams.silicon {
                    @if let Some(judged) = &silicon.judged {
                        (figure("Kept of the float kernel's events", &html! {
                            (number::fixed("/streams/silicon/judged/kept", judged.headline.kept, 3))
                            span.of { ", as a threshold " (judged.likeness.equivalent()) " higher" }
                        }))
                    }
                    (figure("Events", &html! {
                        (number::plain("/streams/silicon/events", silicon.events as f64))
                        span.of { " for " (number::plain("/streams/dvs/events", all.streams.dvs.events as f64)) " of a plain DVS" }
                    }))
                } @else {
                    (figure("Events of the float kernel", &html! {
                        (number::plain("/streams/float/events", all.streams.float.events as f64))
                        span.of { " for " (number::plain("/streams/dvs/events", all.streams.dvs.events as f64)) " of a plain DVS" }
                    }))
                }
                @if let Some(power) = &all.power {
                    (figure("Power that is known", &html! {
                        (number::known("/power/known", &power.known))
                        span.of { ", " (power.known.evidence.word()) }
                    }))
                }
            }
        },
    )
}

fn figure(name: &str, value: &Markup) -> Markup {
    html! { div { dt { (name) } dd { (value) } } }
}

/// Which rule chose which word.
pub(super) fn rules(all: &Feasibility) -> Markup {
    let verdict = &all.verdict;
    part(
        "rules",
        "How the words of the verdict were chosen",
        &html! {
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
