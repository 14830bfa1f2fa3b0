//! What was assumed, and how to get the same page again.

use maud::html;

use super::{
    number,
    part::{Part, part},
};
use crate::study::feasibility::Feasibility;

/// Everything that was taken as given.
pub(super) fn assumptions(all: &Feasibility) -> Part {
    part(
        "assumptions",
        "What was assumed",
        html! {
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

/// The version, the command and the seed.
pub(super) fn section(amacrine: &str, command: &str, seed: u64) -> Part {
    part(
        "reproduce",
        "How to reproduce it",
        html! {
            p { "With amacrine " (amacrine) " and the same files this command gives this page again, to the byte (seed " (seed) "); with " code { "--json" } " it prints every number." }
            pre { code { (command) } }
        },
    )
}
