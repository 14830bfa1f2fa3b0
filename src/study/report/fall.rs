//! Where the events went, step by step.

use maud::{Markup, html};

use super::{
    image, number,
    part::{Part, part, wide},
};
use crate::study::{
    feasibility::Feasibility,
    waterfall::{Shares, Step, Waterfall},
};

/// The waterfall as a picture and as a table; nothing where there is none.
pub(super) fn section(all: &Feasibility) -> Option<Part> {
    let waterfall = all.waterfall.as_ref()?;
    let inside = content(all, waterfall);
    Some(part(
        "decides",
        "What decides? Where the events went",
        inside,
    ))
}

fn content(all: &Feasibility, waterfall: &Waterfall) -> Markup {
    let title = format!("Where the events of {} went", all.kernel.name);
    let alt = format!(
        "{title}: a bar for each step from the float sensor to the chip; the table below has its numbers."
    );
    html! {
        p { "From the float sensor, with the times of its crossings (" (number::plain("/waterfall/float_events", waterfall.float_events as f64))
            " events), to what leaves the chip (" (number::plain("/waterfall/chip_events", waterfall.chip_events as f64))
            "): each step is a sensor that was run, and changes events of the step before it. In order, a step comes after those above it; alone, with all others on. Where the two differ, steps interact." }
        (wide("Picture of the waterfall", &image::drawing(&waterfall.drawing(&title), &alt)))
        (wide("Waterfall", &html! {
            table {
                caption { "Events that each step changes, for each event of the float sensor" }
                thead {
                    tr {
                        th scope="col" rowspan="2" { "Step" }
                        th.group scope="colgroup" colspan="4" { "In order" }
                        th.group scope="colgroup" colspan="2" { "Alone" }
                    }
                    tr {
                        th.n scope="col" { "mistimed" } th.n scope="col" { "wrong sign" }
                        th.n scope="col" { "lost" } th.n scope="col" { "extra" }
                        th.n scope="col" { "lost" } th.n scope="col" { "extra" }
                    }
                }
                tbody { @for (i, step) in waterfall.steps.iter().enumerate() { (row(i, step)) } }
            }
        }))
    }
}

fn row(i: usize, step: &Step) -> Markup {
    let share = |order: &str, key: &str, value: f64| {
        let at = format!("/waterfall/steps/{i}/{order}_share/{key}");
        number::fixed(&at, value, 3)
    };
    let forward = |key: &str, value: f64| share("forward", key, value);
    let backward = |key: &str, of: fn(&Shares) -> f64| {
        let value = step.backward_share.as_ref().map(of);
        value.map_or_else(number::none, |value| share("backward", key, value))
    };
    let Shares {
        mistimed,
        wrong_sign,
        lost,
        extra,
    } = step.forward_share;
    html! {
        tr {
            th scope="row" { (step.name) }
            td.n { (forward("mistimed", mistimed)) }
            td.n { (forward("wrong_sign", wrong_sign)) }
            td.n { (forward("lost", lost)) }
            td.n { (forward("extra", extra)) }
            td.n { (backward("lost", |shares| shares.lost)) }
            td.n { (backward("extra", |shares| shares.extra)) }
        }
    }
}
