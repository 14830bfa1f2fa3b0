//! What was assumed, and how to get the same page again.

use maud::{Markup, html};

use super::{number, part::part};
use crate::study::feasibility::Feasibility;

/// Everything that was taken as given.
pub(super) fn assumptions(all: &Feasibility) -> Markup {
    part(
        "assumptions",
        "What was assumed",
        &html! {
            ul.assumptions {
                @for assumption in &all.assumptions {
                    li { (number::evidence(assumption.evidence)) " " (assumption.what) }
                }
            }
            @if !all.chip.guesses.is_empty() {
                p.note { "Numbers of " (all.chip.name) " that are guesses in its data: " (all.chip.guesses.join(", ")) "." }
            }
        },
    )
}

/// The command, the seed, the version.
pub(super) fn section(all: &Feasibility) -> Markup {
    part(
        "reproduce",
        "How to reproduce it",
        &html! {
            p { "With amacrine " (all.amacrine) " and the same files this command gives this page again, to the byte (seed " (all.seed) "); with " code { "--json" } " it prints every number." }
            pre { code { (all.command) } }
        },
    )
}
