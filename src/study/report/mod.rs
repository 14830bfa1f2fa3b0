//! The feasibility report: one HTML file that needs nothing else.
//!
//! No script, no network, no font: text, tables and pictures in one file, made to be read on a
//! phone, printed and forwarded. Every number is the one of [`Feasibility`]: it stands in a
//! `<data>` element with its place in the JSON (`data-at`, a JSON pointer) and its full value.
//! A pointer inside an element with `data-root` begins there: a page of [`Several`] kernels has
//! a chapter for each.

mod bars;
mod chip;
mod chips;
mod events;
mod fall;
pub mod image;
mod mesh;
mod number;
mod part;
mod power;
mod quantisation;
mod reproduce;
mod shared;
mod snapshot;
mod tornado;
mod verdict;
mod warnings;
mod weights;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use self::part::Place;
use super::feasibility::{Feasibility, Reply, Several, Snapshot};

/// How it looks, on a screen and on paper.
const STYLE: &str = include_str!("style.css");

/// What a browser may load for it: nothing but what is in it.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'";

/// The whole page.
#[must_use]
pub fn page(reply: &Reply) -> String {
    match reply {
        Reply::One(one, snapshot) => page_of_one(one, snapshot),
        Reply::Several(several, snapshots) => page_of_several(several, snapshots),
    }
}

fn page_of_one(all: &Feasibility, snapshot: &Snapshot) -> String {
    let place = Place::default();
    let reproduce = reproduce::section(all.amacrine, &all.command, all.seed);
    whole(
        all.amacrine,
        &format!("{} on {}", all.kernel.name, all.chip.name),
        &asked(all),
        &html! {
            (parts(all, snapshot, &place))
            (reproduce.at(&place))
        },
    )
}

/// The page of several kernels: all of them in one program, then a chapter for each.
fn page_of_several(all: &Several, snapshots: &[Snapshot]) -> String {
    let names: Vec<&str> = all
        .kernels
        .iter()
        .map(|one| one.kernel.name.as_str())
        .collect();
    let chip = all.kernels.first().map_or("", |one| one.chip.name.as_str());
    let place = Place::default();
    let reproduce = reproduce::section(all.amacrine, &all.command, all.seed);
    whole(
        all.amacrine,
        &format!("{} on {chip}", names.join(", ")),
        &html! {
            p.lead {
                @if names.len() == 1 {
                    "Can a pixel of " (chip) " compute this receptive field with the memory that was asked for, and what is left of its events? First that program, then a chapter about the kernel with a memory in an analogue register."
                } @else {
                    "Can a pixel of " (chip) " compute all of these receptive fields at once, and what is left of the events of each? First all of them together, then a chapter for each."
                }
            }
        },
        &html! {
            (shared::section(all).at(&place))
            @for (i, (one, snapshot)) in all.kernels.iter().zip(snapshots).enumerate() {
                article data-root=(format!("/kernels/{i}")) {
                    h2 { (one.kernel.name) }
                    (asked(one))
                    (parts(one, snapshot, &Place::chapter(i + 1)))
                }
            }
            (reproduce.at(&place))
        },
    )
}

/// All parts about one kernel.
fn parts(all: &Feasibility, snapshot: &Snapshot, place: &Place) -> Markup {
    let parts = [
        Some(verdict::section(all, place)),
        warnings::section(all),
        Some(snapshot::section(all, snapshot)),
        Some(events::right(all)),
        Some(events::emitted(all)),
        Some(quantisation::section(all)),
        Some(chip::section(all)),
        chips::section(all),
        Some(power::section(all)),
        fall::section(all),
        Some(mesh::section(all)),
        Some(verdict::rules(all)),
        Some(reproduce::assumptions(all)),
    ];
    html! { @for part in parts.iter().flatten() { (part.at(place)) } }
}

/// A page with its head and its foot.
fn whole(amacrine: &str, heading: &str, lead: &Markup, main: &Markup) -> String {
    let whole = html! {
        (DOCTYPE)
        html lang="en-GB" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="generator" content={ "amacrine " (amacrine) };
                title { "Feasibility of " (heading) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    p.kind { "Feasibility report" }
                    h1 { (heading) }
                    (lead)
                }
                main { (main) }
                footer {
                    p { "Made by amacrine " (amacrine) ". Every number about hardware carries its evidence: "
                        strong { "measured" } " on the chip, "
                        strong { "quoted" } " from whoever made it, "
                        strong { "modelled" } " from what is known, or a "
                        strong { "guess" } "." }
                }
            }
        }
    };
    whole.into_string()
}

/// What was asked, in a sentence.
fn asked(all: &Feasibility) -> Markup {
    let scene = &all.scene;
    html! {
        p.lead {
            "Can a pixel of " (all.chip.name) " (" (all.chip.title) ") compute this receptive field, and what is left of its events? "
            "Asked of " (scene.name) " ("
            (number::plain("/scene/width", scene.width as f64)) "x" (number::plain("/scene/height", scene.height as f64))
            " pixels, " (number::plain("/scene/frames", scene.frames as f64)) @if scene.frames == 1 { " frame at " } @else { " frames at " }
            (number::plain("/scene/fps", scene.fps)) " frames/s"
            @if scene.fps_is_assumed { ", which was assumed" }
            "), with an event where kernel times light, 0 to 255, has moved by more than "
            (number::plain("/threshold", all.threshold)) "."
        }
        p.note { "Light: " (scene.light) "." }
    }
}
