//! What the program takes of the chip.

use maud::{Markup, html};

use super::{
    number,
    part::{Part, cards, part},
};
use crate::{
    isa::Evidence,
    study::feasibility::{
        Feasibility, Fit,
        chip::{HalvedFor, OnChip},
        time::Binds,
    },
};

/// Words, registers, time, noise; or why there is no program.
pub(super) fn section(all: &Feasibility) -> Part {
    let inside = match &all.fit {
        Fit::Refused(why) => html! {
            p { "There is no program for " (all.chip.title) ": " (why) "." }
        },
        Fit::OnChip(chip) => html! {
            p { "The program captures, filters, compares with its memory and reads out, every frame; its kernel was found by the compiler. "
                (binds(chip)) }
            (cards("Program and time", &html! {
                table {
                    caption { "The program on " (all.chip.title) }
                    (number::head())
                    tbody { (room(chip)) (time(chip)) (noise(all, chip)) }
                }
            }))
            p.note { "Sources go by the short names of the chip's data (isa/" (all.chip.name) "/device.toml, or that of the chip that it extends), which explains them." }
            (remarks(chip))
        },
    };
    part("chip", "Does it fit, and how fast?", inside)
}

fn binds(chip: &OnChip) -> &'static str {
    match chip.time.binds {
        Binds::Array => "The array's words take longest.",
        Binds::Readout => "Reading events out takes longest, far more than computing them.",
        Binds::Exposure => "Exposure takes longest.",
    }
}

fn room(chip: &OnChip) -> Markup {
    let at = |key: &str| format!("/fit/on_chip/{key}");
    html! {
        (number::counted("Words of the filter", "bus words found by the compiler", &number::plain(&at("filter_words"), chip.filter_words as f64)))
        (number::counted("Words a frame", "filter, comparison, memory, readout", &number::plain(&at("frame_words"), chip.frame_words as f64)))
        (number::counted("Words stored", "with those of the first frame", &number::plain(&at("stored_words"), chip.stored_words as f64)))
        (number::row("Program store", &at("store"), &chip.store))
        (number::counted("Analogue registers", "of those that a pixel has", &html! {
            (number::plain(&at("registers"), chip.registers as f64)) " of " (number::plain(&at("registers_of"), chip.registers_of as f64))
        }))
        (number::counted("Halvings of the light", halved(chip.halved_for, chip.holds), &number::plain(&at("prescale_bits"), f64::from(chip.prescale_bits))))
    }
}

/// What a bit was given for.
pub(super) const fn halved(halved_for: HalvedFor, holds: bool) -> &'static str {
    match (halved_for, holds) {
        (HalvedFor::Range, _) => "a bit of it each, so that no sum leaves the range",
        (HalvedFor::Events, true) => {
            "a bit of it each, for the most events on the chip; no sum leaves the range"
        }
        (HalvedFor::Events, false) => {
            "a bit of it each, for the most events on the chip: large sums may leave the range"
        }
    }
}

fn time(chip: &OnChip) -> Markup {
    let at = |key: &str| format!("/fit/on_chip/time/{key}");
    let time = &chip.time;
    html! {
        (number::row("Time on the array", &at("array"), &time.array))
        (number::row(&format!("Readout, {}", time.plan.in_words()), &at("readout"), &time.readout))
        @for (i, plan) in time.plans.iter().enumerate().filter(|(_, plan)| !plan.is_chosen) {
            (number::row(&format!("Readout, {}", plan.plan.in_words()), &at(&format!("plans/{i}/time")), &plan.time))
        }
        @if let Some(exposure) = &time.exposure {
            (number::row("Exposure", &at("exposure"), exposure))
        }
        (number::row("Frame rate, at most", &at("ceiling"), &time.ceiling))
        (number::row("Frame rate, all slots of the program", &at("ceiling_as_programmed"), &time.ceiling_as_programmed))
        (number::counted("Longest exposure", "that leaves the scene's frame rate", &html! {
            (number::maybe(&at("longest_exposure_us"), time.longest_exposure_us)) " \u{b5}s"
        }))
    }
}

fn noise(all: &Feasibility, chip: &OnChip) -> Markup {
    let at = |key: &str| format!("/fit/on_chip/noise/{key}");
    let noise = &chip.noise;
    // The threshold is one of light, which the chip scales.
    let scale = all.figures.iter().find(|it| it.figure == "light.scale");
    let scale = scale.map_or(Evidence::Modelled, |scale| scale.interval_evidence);
    html! {
        (number::row("Noise of a result, frame to frame", &at("temporal"), &noise.temporal))
        (number::row("Mismatch of a result, pixel to pixel", &at("fixed"), &noise.fixed))
        (number::worked_out("Threshold, where it is compared", "the threshold in LSB of the chip", &html! {
            (number::plain(&at("threshold_lsb"), noise.threshold_lsb)) " LSB"
        }, scale))
        (number::worked_out(
            "Threshold over noise",
            "in standard deviations of a difference of two frames",
            &number::maybe(&at("margin"), noise.margin),
            Evidence::weakest([scale, noise.temporal.evidence]),
        ))
    }
}

fn remarks(chip: &OnChip) -> Markup {
    html! {
        ul {
            li { "Noise and mismatch are predicted for a uniform light of " (number::plain("/fit/on_chip/noise/at_lsb", chip.noise.at_lsb)) " LSB. Mismatch is the same in every frame; in a difference of two frames what is left of it is an error of gain." }
            li { (number::plain("/fit/on_chip/noise/offset_stores", chip.noise.offset_stores)) " transfer errors of one store stay in a result; they are in the memory as well and drop out of the difference." }
            li {
                @match (chip.holds, chip.halved_for) {
                    (true, _) => "No sum leaves the range, the chip's transfer errors included.",
                    (false, HalvedFor::Events) => "Large sums may leave the range: the light is halved for the most events on the chip.",
                    (false, HalvedFor::Range) => "With the chip's transfer errors some sums may leave the range: no plan was found that holds them all.",
                }
            }
            li { @if chip.border { "Results are right up to the border, with zeros beyond it." } @else { "Results are not right at the border, where the kernel leaves the array." } }
        }
    }
}
