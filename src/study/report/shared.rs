//! Several kernels in one program.

use maud::{Markup, html};

use super::{
    chip::halved,
    number,
    part::{Part, Place, cards, part, wide},
};
use crate::study::feasibility::{Several, SharedFit, SharedKind, SharedProgram};

/// Whether they fit together, what that takes, and what each of them keeps.
pub(super) fn section(all: &Several) -> Part {
    let together = &all.together;
    part(
        "together",
        if together.kinds.len() == 1 {
            "The program with this memory"
        } else {
            "All of them in one program"
        },
        html! {
            p.headline { strong { (together.headline) } }
            (wide("Kernels", &html! {
                table {
                    caption { "Each kernel, in this program and in one of its own, with the chip\u{2019}s errors" }
                    thead { tr {
                        th scope="col" { "Kernel" }
                        th scope="col" { "Values" }
                        th scope="col" { "On its own" }
                        th.n scope="col" { "kept on its own" }
                        th.n scope="col" { "kept together" }
                        th.n scope="col" { "as threshold" }
                    } }
                    tbody {
                        @for (i, kind) in together.kinds.iter().enumerate() {
                            (row(i, kind, &all.kernels[i].verdict.headline))
                        }
                    }
                }
            }))
            p.verdict { (together.says) }
            @if let SharedFit::OnChip(program) = &together.fit { (program_table(program)) }
        },
    )
}

fn row(i: usize, kind: &SharedKind, headline: &str) -> Markup {
    let at = |key: &str| format!("/together/kinds/{i}/{key}");
    let kept = kind.headline.and_then(|headline| headline.kept);
    html! {
        tr {
            th scope="row" { a href=(Place::chapter(i + 1).link("verdict")) { (kind.name) } }
            td { (kind.to) }
            td { (headline) }
            td.n { (number::maybe(&at("kept_apart"), kind.kept_apart)) }
            td.n { (number::maybe(&at("kept"), kept)) }
            td.n {
                @if let Some(silicon) = &kind.silicon {
                    (number::equivalent(
                        &at("silicon/threshold_equivalent_percent"),
                        silicon.threshold_equivalent_percent,
                        silicon.threshold_equivalent_is_least,
                    ))
                } @else { (number::none()) }
            }
        }
    }
}

/// Those of each filter, with commas between.
fn halvings(program: &SharedProgram) -> Markup {
    html! {
        @for (i, bits) in program.halvings.iter().enumerate() {
            @if i > 0 { ", " }
            (number::plain(&format!("/together/fit/on_chip/halvings/{i}"), f64::from(*bits)))
        }
    }
}

fn program_table(program: &SharedProgram) -> Markup {
    let at = |key: &str| format!("/together/fit/on_chip/{key}");
    let time = &program.time;
    cards(
        "This program",
        &html! {
            table {
                caption { "One program, with " (program.memory) }
                (number::head())
                tbody {
                    (number::counted("Kinds that the chip carries", "like these, in that way", &number::plain(&at("carried"), program.carried as f64)))
                    (number::counted("Words of the filters", "what they have in common is computed once, unless they share a memory", &number::plain(&at("filter_words"), program.filter_words as f64)))
                    (number::counted("Words a frame", "filters, comparisons, memories, readout", &number::plain(&at("frame_words"), program.frame_words as f64)))
                    (number::counted("Words a frame, apart", "of the programs of each, added up", &number::maybe(&at("frame_words_apart"), program.frame_words_apart.map(|words| words as f64))))
                    (number::counted("Words stored", "with those of the first frame", &number::plain(&at("stored_words"), program.stored_words as f64)))
                    (number::row("Program store", &at("store"), &program.store))
                    (number::counted("Analogue registers", "of those that a pixel has", &html! {
                        (number::plain(&at("registers"), program.registers as f64)) " of " (number::plain(&at("registers_of"), program.registers_of as f64))
                    }))
                    (number::counted(
                        if program.halvings.len() > 1 { "Halvings of the change, kind by kind" } else { "Halvings of the light" },
                        halved(program.halved_for, program.holds),
                        &halvings(program),
                    ))
                    (number::row("Time on the array", &at("time/array"), &time.array))
                    (number::row(&format!("Readout, {}", time.plan.in_words()), &at("time/readout"), &time.readout))
                    (number::row("Frame rate, at most", &at("time/ceiling"), &time.ceiling))
                }
            }
        },
    )
}
