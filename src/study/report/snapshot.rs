//! What the sensors saw at the busiest moment.

use ::image::RgbImage;
use maud::{Markup, html};

use super::{
    image,
    part::{Part, part},
};
use crate::{
    event::{Event, Polarity},
    picture::{
        ink::{self, Ink},
        panel::{self, Difference},
    },
    plane::Size,
    study::feasibility::{Feasibility, Snapshot},
};

/// The frame, the events of both sensors, and how they differ.
pub(super) fn section(all: &Feasibility, snapshot: &Snapshot) -> Part {
    let finite = || snapshot.light.iter().copied().filter(|v| v.is_finite());
    let black = finite().fold(f64::INFINITY, f64::min);
    let white = finite().fold(f64::NEG_INFINITY, f64::max);
    let frame = panel::frame(&snapshot.light, black, white);
    let pale = panel::pale(&frame);
    let seconds = snapshot.at.seconds();
    let when = format!("{seconds:.3} s");
    let is_silent = all.streams.float.events == 0;
    part(
        "sight",
        if is_silent {
            "A moment of the scene"
        } else {
            "The busiest moment"
        },
        html! {
            p {
                @if is_silent {
                    "The first frame, at " (when) ", since the float kernel has no event on this scene; and what each sensor says of it."
                } @else {
                    "The frame at " (when) ", at which the float kernel has most events, and what each sensor says of it."
                }
            }
            div.panels {
                (figure(&frame, &format!("The scene at {when}."), "The scene"))
                (event_figure(&pale, &snapshot.float, "float kernel", "The float kernel"))
                @if let Some(chip) = &snapshot.chip {
                    (event_figure(&pale, chip, "chip", &format!("{}, with its errors", all.chip.name)))
                    (difference(snapshot, chip))
                }
            }
            (legend(snapshot.chip.is_some()))
        },
    )
}

fn figure(picture: &RgbImage, alt: &str, caption: &str) -> Markup {
    html! { figure { (image::pixels(picture, alt)) figcaption { (caption) } } }
}

fn event_figure(pale: &RgbImage, events: &[Event], who: &str, caption: &str) -> Markup {
    let on = events.iter().filter(|e| e.polarity == Polarity::On).count();
    let off = events.len() - on;
    let alt = format!(
        "Events of the {who}: {on} ON in blue and {off} OFF in orange, over the pale scene."
    );
    let caption = format!("{caption}: {on} ON, {off} OFF");
    figure(&panel::events(pale.clone(), events), &alt, &caption)
}

fn difference(snapshot: &Snapshot, chip: &[Event]) -> Markup {
    let difference = Difference::new(&snapshot.float, chip);
    let Difference {
        matched,
        missing,
        extra,
        ..
    } = difference;
    let alt = format!(
        "Where the two differ: {} in both, {missing} missing from the chip, {extra} extra.",
        crate::unit::counted(matched, "event")
    );
    let caption = format!("Difference: {matched} in both, {missing} missing, {extra} extra");
    figure(&difference.panel(Size::of(&snapshot.light)), &alt, &caption)
}

fn legend(with_difference: bool) -> Markup {
    let events = [(ink::ON, "ON event"), (ink::OFF, "OFF event")];
    let differences = [
        (ink::MATCHED, "in both"),
        (ink::MISSING, "missing from the chip"),
        (ink::EXTRA, "extra on the chip"),
        (ink::SWAPPED, "the other sign"),
    ];
    let shown = if with_difference {
        &differences[..]
    } else {
        &[]
    };
    html! {
        ul.legend aria-label="Colours" {
            @for (ink, what) in events.iter().chain(shown) {
                li { (patch(*ink)) (what) }
            }
        }
    }
}

fn patch(ink: Ink) -> Markup {
    html! {
        svg.patch viewBox="0 0 10 10" aria-hidden="true" focusable="false" {
            rect width="10" height="10" fill=(ink::hex(ink)) {}
        }
    }
}
