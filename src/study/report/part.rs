//! The parts of a page: a heading that can be linked to, and what stands below it.

use maud::{Markup, html};

/// A part of the page.
pub(super) struct Part {
    id: &'static str,
    heading: &'static str,
    inside: Markup,
}

/// A part by its heading.
pub(super) fn part(id: &'static str, heading: &'static str, inside: Markup) -> Part {
    Part {
        id,
        heading,
        inside,
    }
}

/// Where parts stand: on a page of one kernel, or in a chapter of a page of several.
#[derive(Clone, Debug, Default)]
pub(super) struct Place {
    /// Of the chapter, from 1.
    chapter: Option<usize>,
}

impl Place {
    /// A chapter, from 1.
    pub const fn chapter(number: usize) -> Self {
        Self {
            chapter: Some(number),
        }
    }

    /// The id of a part here.
    pub fn id(&self, id: &str) -> String {
        match self.chapter {
            None => id.to_owned(),
            Some(number) => format!("kernel-{number}-{id}"),
        }
    }

    /// Where a link to a part leads.
    pub fn link(&self, id: &str) -> String {
        format!("#{}", self.id(id))
    }
}

impl Part {
    /// The part as it stands somewhere.
    pub fn at(&self, place: &Place) -> Markup {
        let id = place.id(self.id);
        html! {
            section aria-labelledby=(id) {
                @if place.chapter.is_some() {
                    h3 id=(id) { (self.heading) }
                } @else {
                    h2 id=(id) { (self.heading) }
                }
                (self.inside)
            }
        }
    }
}

/// A table of many columns, which may be wider than the screen: it scrolls by itself there, and
/// says so.
pub(super) fn wide(label: &str, table: &Markup) -> Markup {
    scrolling("scrolls", label, table)
}

/// A drawing, as large as its letters want: wider than the column of the text where it can, on
/// paper across a page.
pub(super) fn drawn(label: &str, drawing: &Markup) -> Markup {
    scrolling("drawn", label, drawing)
}

/// A table of so many columns that it takes more than the column of the text where it can.
pub(super) fn broad(label: &str, table: &Markup) -> Markup {
    scrolling("broad", label, table)
}

fn scrolling(class: &str, label: &str, inside: &Markup) -> Markup {
    html! {
        p class={ "hint " (class) } aria-hidden="true" { "Wider than the screen: scroll it sideways \u{2192}" }
        div class={ "wide " (class) } role="region" aria-label=(label) tabindex="0" { (inside) }
    }
}

/// A table of numbers about hardware, each with its evidence: on a phone a card for each row.
pub(super) fn cards(label: &str, table: &Markup) -> Markup {
    html! {
        div.wide.cards role="region" aria-label=(label) tabindex="0" { (table) }
    }
}
