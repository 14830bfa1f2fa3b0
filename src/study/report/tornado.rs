//! What decides: how far a headline moves when one number that is not well known goes from the
//! least to the most that it may be, all others as they are. The longest bars are on top.

use maud::{Markup, html};

use crate::order::Order;

use super::{number, part::wide};

/// A headline, and what moves it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tornado<'a> {
    /// What the headline is called, such as `kept`.
    pub headline: &'a str,
    /// Its value where every number is as the chip's data say.
    pub nominal: f64,
    /// Where that is in the JSON.
    pub at: &'a str,
    /// A bar for each number.
    pub bars: Vec<Bar<'a>>,
}

/// What one number does to the headline.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Bar<'a> {
    /// What the number is called.
    pub name: &'a str,
    /// The least and the most that it may be, with its unit.
    pub between: &'a str,
    /// The headline where it is the least, and where it is the most.
    pub ends: [f64; 2],
    /// Where these two are in the JSON.
    pub at: [String; 2],
}

impl Bar<'_> {
    /// How far the headline moves, from where it is otherwise or from end to end.
    fn swing(&self, nominal: f64) -> f64 {
        let [least, most] = self.ends;
        most.max(least).max(nominal) - most.min(least).min(nominal)
    }
}

/// The width of the drawing of a bar.
const WIDTH: f64 = 100.0;

/// The chart, a row of a table for each bar; nothing where there is no bar.
pub(super) fn chart(tornado: &Tornado<'_>) -> Markup {
    let mut bars: Vec<&Bar<'_>> = tornado.bars.iter().collect();
    let swing = |bar: &Bar<'_>| bar.swing(tornado.nominal);
    bars.order_by(|a, b| swing(b).total_cmp(&swing(a)));
    let all = || {
        bars.iter()
            .flat_map(|bar| bar.ends)
            .chain([tornado.nominal])
    };
    let low = all().fold(f64::INFINITY, f64::min);
    let high = all().fold(f64::NEG_INFINITY, f64::max);
    let room = (high - low).max(f64::MIN_POSITIVE);
    let x = |value: f64| WIDTH * (value - low) / room;
    if bars.is_empty() {
        return html! {};
    }
    html! {
        ul.legend aria-label="Colours" {
            @for (class, what) in [
                ("floor", "where the number is at its least"),
                ("value", "where it is at its most"),
                ("nominal", "as stated"),
            ] {
                li {
                    svg.patch viewBox="0 0 10 10" aria-hidden="true" focusable="false" {
                        rect class=(class) width="10" height="10" {}
                    }
                    (what)
                }
            }
        }
        (wide("What decides", &html! {
            table.tornado {
                caption {
                    "What moves " (tornado.headline) " from "
                    (number::plain(tornado.at, tornado.nominal))
                    " when one number goes from its least to its most"
                }
                thead { tr {
                    th scope="col" { "Number" }
                    th.n scope="col" { "at its least" }
                    th.n scope="col" { "at its most" }
                    th scope="col" { "from " (number::plain_text(low)) " to " (number::plain_text(high)) }
                } }
                tbody {
                    @for bar in &bars {
                        tr {
                            th scope="row" { (bar.name) span.source { (bar.between) } }
                            td.n { (number::plain(&bar.at[0], bar.ends[0])) }
                            td.n { (number::plain(&bar.at[1], bar.ends[1])) }
                            td { (drawn(bar.ends.map(x), x(tornado.nominal))) }
                        }
                    }
                }
            }
        }))
    }
}

/// From the nominal value to either end: what the least does in orange, the most in blue.
fn drawn(ends: [f64; 2], nominal: f64) -> Markup {
    let side = |end: f64| {
        let (from, to) = (end.min(nominal), end.max(nominal));
        [from, to - from].map(|v| format!("{v:.2}"))
    };
    let [least, most] = ends.map(side);
    html! {
        svg.bar.swing viewBox="-1 0 102 12" preserveAspectRatio="none" aria-hidden="true" focusable="false" {
            rect.ground width="100" height="12" {}
            rect.floor x=(least[0]) width=(least[1]) height="12" {}
            rect.value x=(most[0]) width=(most[1]) height="12" {}
            rect.nominal x=(format!("{:.2}", nominal - 0.4)) width="0.8" height="12" {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_bar_is_on_top_and_both_ends_are_told() {
        let bar = |name, ends: [f64; 2]| Bar {
            name,
            between: "0 to 1",
            ends,
            at: ["/least", "/most"].map(|end| format!("/tornado/{name}{end}")),
        };
        let tornado = Tornado {
            headline: "kept",
            nominal: 0.8,
            at: "/kept",
            bars: vec![bar("mismatch", [0.85, 0.75]), bar("noise", [0.9, 0.4])],
        };
        let page = chart(&tornado).into_string();
        let place = |what: &str| page.find(what).unwrap_or_else(|| panic!("no {what}"));
        assert!(place("noise") < place("mismatch"));
        for at in ["/tornado/noise/least", "/tornado/noise/most", "/kept"] {
            place(&format!("data-at=\"{at}\""));
        }
        for end in [
            "where the number is at its least",
            "where it is at its most",
        ] {
            place(end);
        }
        // From 0.4 to 0.9 is the whole width: 0.8 is at 80, the most of noise at 0.
        assert!(page.contains("x=\"80.00\" width=\"20.00\""));
        assert!(page.contains("x=\"0.00\" width=\"80.00\""));
        let none = Tornado {
            bars: Vec::new(),
            ..tornado
        };
        assert_eq!(chart(&none).into_string(), "");
    }
}
