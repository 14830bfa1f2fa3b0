//! Parts of the page, and their tables.

use maud::{Markup, html};

/// A part of the page.
pub(super) fn part(id: &str, heading: &str, inside: &Markup) -> Markup {
    html! {
        section aria-labelledby=(id) {
            h2 id=(id) { (heading) }
            (inside)
        }
    }
}

/// A table that scrolls by itself where the screen is narrower.
pub(super) fn wide(label: &str, table: &Markup) -> Markup {
    html! {
        div.wide role="region" aria-label=(label) tabindex="0" { (table) }
    }
}
