//! Power in parts, as intervals.

use maud::{Markup, html};

use super::{
    number,
    part::{Part, cards, part, wide},
};
use crate::study::feasibility::{Feasibility, power::Power};

/// Power of the array.
pub(super) fn section(all: &Feasibility) -> Part {
    part(
        "power",
        "How much power?",
        html! {
            @match &all.power {
                None => p { "Without a program there is no power to state." },
                Some(power) => {
                    p { "At " (number::plain("/scene/fps", all.scene.fps)) " frames/s the array runs words for "
                        (number::plain("/power/share/low", power.share.low)) " to " (number::plain("/power/share/high", power.share.high)) " of the time. What is not public stands alone and is in no sum." }
                    (parts(power))
                }
            }
        },
    )
}

/// What leaves the chip, and what a link takes for it.
pub(super) fn link(all: &Feasibility) -> Markup {
    let link = &all.link;
    wide(
        "Link",
        &html! {
            table {
                caption { "What leaves the chip, and what a link of " (number::known("/link/bit", &link.bit)) " a bit would take for it (" (number::evidence(link.bit.evidence)) ")" }
                thead { tr {
                    th scope="col" { "Sent" }
                    th.n scope="col" { "kbit/s" }
                    th.n scope="col" { "Link power" }
                    th scope="col" { "Evidence" }
                } }
                tbody {
                    @for (i, row) in link.rows.iter().enumerate() {
                        tr {
                            th scope="row" { (row.what) }
                            td.n { (number::plain(&format!("/link/rows/{i}/kbit_s"), row.kbit_s)) }
                            td.n { (number::known(&format!("/link/rows/{i}/power"), &row.power)) }
                            td { (number::evidence(row.power.evidence)) }
                        }
                    }
                }
            }
        },
    )
}

fn parts(power: &Power) -> Markup {
    let keys = ["busy", "idle", "readout", "link", "host"];
    cards(
        "Power in parts",
        &html! {
            table {
                caption { "Power and energy, part by part" }
                (number::head())
                tbody {
                    @for (part, key) in power.parts().into_iter().zip(keys) {
                        @if let Some(known) = &part.power {
                            (number::row(part.what, &format!("/power/{key}/power"), known))
                        } @else {
                            tr {
                                th scope="row" { (part.what) span.source { (part.says) } }
                                td.n {
                                    span.none { "not known" }
                                    @if let Some(most) = &part.at_most {
                                        ", at most " (number::plain(&format!("/power/{key}/at_most/high"), most.high)) " " (number::unit(most.unit))
                                    }
                                }
                                td { @if let Some(most) = &part.at_most { (number::evidence(most.evidence)) } }
                            }
                        }
                    }
                    (number::row("Known together", "/power/known", &power.known))
                    (number::row("Energy a frame, known", "/power/frame", &power.frame))
                    @if let Some(event) = &power.event {
                        (number::row("Energy an event, known", "/power/event", event))
                    }
                }
            }
        },
    )
}
