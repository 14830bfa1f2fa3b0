//! What makes the figures mean something else than they seem to.

use maud::html;

use super::part::{Part, part};
use crate::study::feasibility::Feasibility;

/// The warnings that the program prints beside its output; nothing where there are none.
pub(super) fn section(all: &Feasibility) -> Option<Part> {
    (!all.warnings.is_empty()).then(|| {
        part(
            "warnings",
            "Before you read the figures",
            html! {
                ul.warnings {
                    @for warning in &all.warnings { li { (warning) } }
                }
            },
        )
    })
}
