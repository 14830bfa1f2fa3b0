//! Power of the array and of the link, as intervals.

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
                        (number::plain("/power/busy", power.busy)) " of the time. What the chip takes while it waits is not public, so its power is an interval: from that share of full power to full power all the time. Neither end is a measurement of this program." }
                    (array(power))
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

fn array(power: &Power) -> Markup {
    cards(
        "Power of the array",
        &html! {
            table {
                caption { "Power and energy of the array" }
                (number::head())
                tbody {
                    (number::row("Power", "/power/array", &power.array))
                    (number::row("Power, doubted twofold", "/power/array_doubtful", &power.array_doubtful))
                    (number::row("Energy a frame", "/power/frame", &power.frame))
                    @if let Some(event) = &power.event {
                        (number::row("Energy an event", "/power/event", event))
                    }
                }
            }
        },
    )
}
