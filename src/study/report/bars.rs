//! Small bars beside numbers; the numbers say the same, so bars are hidden from screen readers.

use maud::{Markup, html};

/// A bar as long as `part` of the whole.
pub(super) fn bar(part: f64) -> Markup {
    let width = 100.0 * part.clamp(0.0, 1.0);
    html! {
        svg.bar viewBox="0 0 100 6" preserveAspectRatio="none" aria-hidden="true" focusable="false" {
            rect.ground width="100" height="6" {}
            rect.value width=(format!("{width:.2}")) height="6" {}
        }
    }
}

/// A score on its way from the floor, hatched up to there, to the ceiling.
pub(super) fn score(value: f64, floor: f64) -> Markup {
    let at = |part: f64| format!("{:.2}", 100.0 * part.clamp(0.0, 1.0));
    html! {
        svg.bar viewBox="0 0 100 6" preserveAspectRatio="none" aria-hidden="true" focusable="false" {
            rect.ground width="100" height="6" {}
            rect.value width=(at(value)) height="6" {}
            rect.floor x=(at(floor)) width="0.8" height="6" {}
        }
    }
}
