//! What becomes of it on the chips that the public data allow.

use maud::{Markup, html};

use super::{
    number,
    part::{Part, cards, part},
};
use crate::{
    isa::Evidence,
    study::{
        feasibility::{Feasibility, named::FigureSummary},
        spread::Spread,
    },
};

/// The headlines over the chips, and the numbers that were drawn; nothing where none were.
pub(super) fn section(all: &Feasibility) -> Option<Part> {
    let over = &all.over_chips;
    let evidence = over.chips_evidence?;
    over.ranges.as_ref()?;
    Some(part(
        "chips",
        "On which chips? What the public data allow",
        html! {
            p { "Numbers of the chip that nobody states are not fixed at one value: they were drawn, " (number::plain("/chips", over.chips as f64)) " times, from the interval that the public data leave, with mismatch of each chip\u{2019}s own. "
                (feasible(all))
                @if let Some(stretch) = over.stretch.filter(|stretch| stretch.frames < stretch.of_frames) {
                    " They watched the first " (number::plain("/stretch/frames", stretch.frames as f64)) " of " (number::plain("/stretch/of_frames", stretch.of_frames as f64)) " frames."
                }
            }
            (cards("Headlines over the chips", &html! {
                table {
                    caption { "What 10 to 90 % of the chips have, and half of them" }
                    (number::head())
                    tbody { (ranges(all, evidence)) }
                }
            }))
            @if all.figures.iter().any(|figure| figure.why.is_some()) {
                (cards("Numbers that were drawn", &html! {
                    table {
                        caption { "The numbers that were drawn, and why they are not less and not more" }
                        (number::head())
                        tbody {
                            @for (i, figure) in all.figures.iter().enumerate() { (drawn(i, figure)) }
                        }
                    }
                }))
            }
        },
    ))
}

fn feasible(all: &Feasibility) -> Markup {
    let over = &all.over_chips;
    let percent = |at: &str, share: f64| html! { (number::scaled(at, share, 100.0)) " %" };
    html! {
        @match (over.chips_feasible, over.chips_feasible_with_loss) {
            (Some(clean), Some(with_loss)) => {
                "It is feasible on " (percent("/chips_feasible", clean)) " of them, with loss or without on " (percent("/chips_feasible_with_loss", with_loss)) "."
            }
            _ => "This scene cannot judge them."
        }
    }
}

fn ranges(all: &Feasibility, evidence: Evidence) -> Markup {
    let Some(ranges) = &all.over_chips.ranges else {
        return html! {};
    };
    let rows = [
        (
            "Kept",
            "of the float kernel\u{2019}s events, above chance",
            "kept",
            ranges.kept,
            "",
        ),
        (
            "As a threshold higher by",
            "the change of the float sensor\u{2019}s threshold that costs as much",
            "threshold_equivalent_percent",
            ranges.threshold_equivalent_percent,
            "%",
        ),
        (
            "Events",
            "for each of the float kernel\u{2019}s",
            "event_ratio",
            ranges.event_ratio,
            "",
        ),
        (
            "Frame rate, at most",
            "with a readout sized to what each chip says",
            "frames_s",
            Some(ranges.frames_s),
            "frames/s",
        ),
        (
            "Power of the array, busy",
            "at the frame rate of the scene",
            "power_busy_mw",
            Some(ranges.power_busy_mw),
            "mW",
        ),
    ];
    html! {
        @if let Some(why) = all.over_chips.unjudged() {
            tr {
                th scope="row" { "Kept" }
                td { (why) }
                td {}
            }
        }
        @for (what, from, key, spread, unit) in rows {
            @if let Some(spread) = spread {
                tr {
                    th scope="row" { (what) span.source { (from) } }
                    td.n { (between(&format!("/ranges/{key}"), &spread, unit)) }
                    td { (number::evidence(evidence)) }
                }
            }
        }
    }
}

fn between(at: &str, spread: &Spread, unit: &str) -> Markup {
    let one = |key: &str, value: f64| number::plain(&format!("{at}/{key}"), value);
    html! {
        (one("p10", spread.p10)) " to " (one("p90", spread.p90)) @if !unit.is_empty() { " " (unit) }
        span.source { "half below " (one("median", spread.median)) }
    }
}

fn drawn(i: usize, figure: &FigureSummary) -> Markup {
    let Some(why) = &figure.why else {
        return html! {};
    };
    let at = |key: &str| format!("/figures/{i}/{key}");
    html! {
        tr {
            th scope="row" { (figure.figure) span.source { (why) } }
            td.n {
                (number::plain(&at("low"), figure.low)) " to " (number::plain(&at("high"), figure.high))
                @if figure.unit != "1" { " " (number::unit(figure.unit)) }
            }
            td { (number::evidence(figure.interval_evidence)) }
        }
    }
}
