//! A resistor mesh instead of a program.

use maud::{Markup, html};

use super::{
    number,
    part::{Part, part, wide},
};
use crate::{mesh::Fit, study::feasibility::Feasibility};

/// What one sheet and two make of the kernel.
pub(super) fn section(all: &Feasibility) -> Part {
    let inside = match all.mesh.first() {
        None => html! { p { "The kernel could not be fitted." } },
        Some(first) => html! {
            p {
                "A sheet of resistors between the pixels computes a smooth surround without a program, in the time that it takes to settle. The best that sheets of equal resistors can do for this kernel is fitted below, over the whole plane. "
                "Out of reach at any price: " (number::fixed("/mesh/0/odd", first.odd, 3)) " of the kernel for resistors of any kind (its odd part), "
                (number::fixed("/mesh/0/turned", first.turned, 3)) " for sheets of equal resistors."
            }
            (wide("Mesh fits", &html! {
                table {
                    caption { "The kernel as resistor sheets" }
                    thead { tr {
                        th scope="col" { "Sheets" }
                        th.n scope="col" { "Error" }
                        th.n scope="col" { "Space constants, px" }
                        th.n scope="col" { "Sum of gains" }
                        th.n scope="col" { "Outside the window" }
                        th.n scope="col" { "Answer to uniform light" }
                    } }
                    tbody { @for (i, fit) in all.mesh.iter().enumerate() { (row(i, fit)) } }
                }
            }))
            p.note { "Error: the difference from the kernel, relative to the kernel. Sum of gains: what noise and offsets of the parts are multiplied by. Outside the window: the part of the fitted field beyond the kernel's own rows and columns. All modelled, of ideal resistors." }
        },
    };
    part("mesh", "A resistor mesh instead", inside)
}

fn row(i: usize, fit: &Fit) -> Markup {
    let at = |key: &str| format!("/mesh/{i}/{key}");
    html! {
        tr {
            th scope="row" { @match fit.sheets.len() { 0 => "none", 1 => "one", _ => "two" } }
            td.n { (number::fixed(&at("error"), fit.error, 3)) }
            td.n {
                @if fit.sheets.is_empty() { (number::none()) }
                @for (k, sheet) in fit.sheets.iter().enumerate() {
                    @if k > 0 { ", " }
                    (number::plain(&format!("/mesh/{i}/sheets/{k}/lambda_x"), sheet.lambda_x))
                }
            }
            td.n { (number::plain(&at("gain"), fit.gain)) }
            td.n { (number::fixed(&at("tail"), fit.tail, 3)) }
            td.n { (number::plain(&at("uniform"), fit.uniform)) }
        }
    }
}
