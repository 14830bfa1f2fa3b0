//! The feasibility report: one HTML file that needs nothing else.
//!
//! No script, no network, no font: text, tables and pictures in one file, made to be read on a
//! phone, printed and forwarded. Every number is the one of [`Feasibility`]: it stands in a
//! `<data>` element with its place in the JSON (`data-at`, a JSON pointer) and its full value.

mod bars;
mod chip;
mod events;
mod fall;
mod image;
mod mesh;
mod number;
mod part;
mod power;
mod quantisation;
mod reproduce;
mod snapshot;
mod verdict;
mod weights;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::feasibility::{Feasibility, Snapshot};

/// How it looks, on a screen and on paper.
const STYLE: &str = include_str!("style.css");

/// What a browser may load for it: nothing but what is in it.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'";

/// The whole page.
#[must_use]
pub fn page(all: &Feasibility, snapshot: &Snapshot) -> String {
    let title = format!("Feasibility of {} on {}", all.kernel.name, all.chip.name);
    let whole = html! {
        (DOCTYPE)
        html lang="en-GB" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="generator" content={ "amacrine " (all.amacrine) };
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    p.kind { "Feasibility report" }
                    h1 { (all.kernel.name) " on " (all.chip.name) }
                    (asked(all))
                }
                main {
                    (verdict::section(all))
                    (snapshot::section(all, snapshot))
                    (events::section(all))
                    (fall::section(all))
                    (chip::section(all))
                    (quantisation::section(all))
                    (mesh::section(all))
                    (power::section(all))
                    (verdict::rules(all))
                    (reproduce::assumptions(all))
                    (reproduce::section(all))
                }
                footer {
                    p { "Made by amacrine " (all.amacrine) ". Every number about hardware carries its evidence: "
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
            " pixels, " (number::plain("/scene/frames", scene.frames as f64)) " frames at "
            (number::plain("/scene/fps", scene.fps)) " frames/s"
            @if scene.fps_is_assumed { ", which was assumed" }
            "), with an event where kernel times light, 0 to 255, has moved by more than "
            (number::plain("/threshold", all.threshold)) "."
        }
    }
}
