//! The kernel in few values: which, and what others would cost and lose.

use maud::{Markup, html};

use super::{
    number,
    part::{Part, broad, part},
    weights,
};
use crate::study::{
    equivalent::Likeness,
    feasibility::{ALIKE, Feasibility},
    quantisation::{OnChip, Outcome, Row},
};

/// The kernel and its levels as pictures, and the table.
pub(super) fn section(all: &Feasibility) -> Part {
    let chosen = &all.chosen;
    let most = weights::most(&all.kernel.weights);
    let most_level = weights::most(&chosen.levels.weights);
    let (height, width) = (
        all.kernel.weights.len(),
        all.kernel.weights.first().map_or(0, Vec::len),
    );
    let alt = |what: &str| {
        format!(
            "{what}, {} of {}; blue above zero, orange below.",
            crate::unit::counted(height, "row"),
            crate::unit::counted(width, "weight")
        )
    };
    part(
        "trade-offs",
        "What are the trade-offs? The kernel in few values",
        html! {
            p {
                "The chip adds, subtracts, halves and shifts; it does not multiply. The kernel became " strong { (chosen.to) }
                ", " (why(all)) ": levels and one scale, " (number::plain("/chosen/scale", chosen.scale))
                ", by which the threshold is divided. None of these levels is above 1: they are those of " code { "amacrine quantise" } " divided by a power of two, and the scale is that one's times the same power, so a threshold is divided by one of the two scales, with its own levels. Its relative error is " (number::fixed("/chosen/relative_error", chosen.relative_error, 4)) "."
            }
            div.panels.kernels {
                figure {
                    (weights::picture(&all.kernel.weights, 1.0, most, &alt(&format!("The kernel {}", all.kernel.name))))
                    figcaption { "The kernel, sum " (number::plain("/kernel/sum", all.kernel.sum)) (weights::told_in(&all.kernel.weights, most)) }
                }
                figure {
                    (weights::picture(&chosen.levels.weights, chosen.scale, most, &alt(&format!("The kernel in {}, times its scale", chosen.to))))
                    figcaption { "In " (chosen.to) ", times the scale" (weights::told_in(&chosen.levels.weights, most)) }
                }
                figure {
                    (weights::picture(&chosen.levels.weights, 1.0, most_level, &alt("The levels that the chip computes with")))
                    figcaption { "The levels, sum " (number::plain("/chosen/levels/sum", chosen.levels.sum)) (weights::told_in(&chosen.levels.weights, most_level)) }
                }
            }
            (broad("Quantisers", &html! {
                table {
                    caption { "Each compiled, and run on this scene beside the float kernel" }
                    thead {
                        tr {
                            th scope="col" rowspan="2" { "Values" }
                            th.n scope="col" rowspan="2" { "Relative error" }
                            th.n scope="col" rowspan="2" { "Words a frame" }
                            th.n scope="col" rowspan="2" { "\u{b5}s a frame" }
                            th.n scope="col" rowspan="2" { "Registers" }
                            th.group scope="colgroup" colspan="3" { "No errors" }
                            th.group scope="colgroup" colspan="3" { "On the chip" }
                        }
                        tr {
                            th.n scope="col" { "kept" } th.n scope="col" { "as threshold" } th.n scope="col" { "events" }
                            th.n scope="col" { "kept" } th.n scope="col" { "as threshold" } th.n scope="col" { "events" }
                        }
                    }
                    tbody {
                        @for (i, row) in all.quantisation.iter().enumerate() {
                            (self::row(i, row, row.to == chosen.to))
                        }
                    }
                }
            }))
            p.note { "Events are for each of the float kernel's. Microseconds are those of the array, without readout; registers those of the filter that are live at a time. Words, times and scores are emulated (modelled)." }
        },
    )
}

/// Why the kernel has these few values.
fn why(all: &Feasibility) -> String {
    if all.chosen.asked_for {
        return "as asked for".to_owned();
    }
    let programs = || {
        all.quantisation
            .iter()
            .filter_map(|row| match &row.outcome {
                Outcome::OnChip(chip) => Some((&row.to, chip)),
                Outcome::Refused(_) => None,
            })
    };
    let Some((_, own)) = programs().find(|(to, _)| **to == all.chosen.to) else {
        return "the first of the table in which the kernel can be written, since none of them has a program"
            .to_owned();
    };
    let f1 = programs().map(|(_, chip)| chip.silicon.f1);
    let is_best = own.silicon.f1 >= f1.fold(0.0, f64::max);
    match (own.silicon.is_judged(), is_best) {
        (true, true) => "which keeps most events on this scene of those in the table".to_owned(),
        (true, false) => format!(
            "the shortest program of those in the table whose F1 on this scene is within {ALIKE} of the highest"
        ),
        (false, _) => format!(
            "the shortest program of those in the table whose F1 is within {ALIKE} of the highest, since this scene cannot tell what they keep"
        ),
    }
}

fn row(i: usize, row: &Row, chosen: bool) -> Markup {
    let at = |key: &str| format!("/quantisation/{i}/{key}");
    html! {
        tr class=[chosen.then_some("chosen")] {
            th scope="row" { (row.to) @if chosen { span.source { "chosen" } } }
            td.n { (number::maybe(&at("relative_error"), row.relative_error)) }
            @match &row.outcome {
                Outcome::Refused(why) => { td colspan="9" { (why) } }
                Outcome::OnChip(chip) => { (on_chip(&at("on_chip"), chip)) }
            }
        }
    }
}

fn on_chip(at: &str, chip: &OnChip) -> Markup {
    let score = |key: &str, score: &Likeness| {
        html! {
            td.n { (number::fixed_or_none(&format!("{at}/{key}/kept"), score.kept, 3)) }
            td.n {
                (number::equivalent(
                    &format!("{at}/{key}/threshold_equivalent_percent"),
                    score.threshold_equivalent_percent,
                    score.threshold_equivalent_is_least,
                ))
            }
            td.n { (number::maybe(&format!("{at}/{key}/event_ratio"), score.event_ratio)) }
        }
    };
    html! {
        td.n { (number::plain(&format!("{at}/words"), chip.words as f64)) }
        td.n { (number::plain(&format!("{at}/array_us"), chip.array_us)) }
        td.n { (number::plain(&format!("{at}/registers"), chip.registers as f64)) }
        (score("exact", &chip.exact))
        (score("silicon", &chip.silicon))
    }
}
