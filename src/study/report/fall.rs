//! What decides: where the events went, over frame rate and step by step, and which of the numbers
//! that nobody states exactly matters.

use maud::{Markup, html};

use super::{
    image, number,
    part::{Part, drawn, part, wide},
    tornado::{self, Bar, Tornado},
};
use crate::study::{
    feasibility::{Feasibility, tornado::Turn},
    waterfall::{Rates, Shares, Step, Waterfall},
};

/// Whether there is anything to tell.
pub(super) fn is_there(all: &Feasibility) -> bool {
    all.waterfall.is_some() || all.over_rates.is_some() || deciding(all).next().is_some()
}

/// The waterfall over frame rate, what decides, and the steps; nothing where there is none.
pub(super) fn section(all: &Feasibility) -> Option<Part> {
    is_there(all).then(|| {
        part(
            "decides",
            "What decides? Where the events went",
            html! {
                @if let Some(rates) = &all.over_rates { (over_rates(all, rates)) }
                (turned(all))
                @if let Some(waterfall) = &all.waterfall { (steps(all, waterfall)) }
            },
        )
    })
}

/// The numbers that move what is kept, the strongest first, with their places; none where the
/// scene cannot judge.
pub(super) fn deciding(all: &Feasibility) -> impl Iterator<Item = (usize, &Turn)> {
    let turns = all.over_chips.tornado.iter().enumerate();
    turns.filter(|(_, turn)| turn.swing() > 0.0)
}

fn turned(all: &Feasibility) -> Markup {
    let first = deciding(all).next();
    let Some((first, [.., nominal])) = first.and_then(|(i, turn)| Some((i, turn.kept()?))) else {
        return html! {};
    };
    let between: Vec<String> = deciding(all)
        .map(|(_, turn)| {
            let ends = [turn.low, turn.high].map(number::plain_text);
            let unit = match turn.unit {
                "1" => String::new(),
                unit => format!(" {}", number::unit(unit)),
            };
            format!("{} to {}{unit}, {}", ends[0], ends[1], turn.evidence.word())
        })
        .collect();
    let bars = deciding(all)
        .zip(&between)
        .filter_map(|((i, turn), between)| {
            let [at_low, at_high, _] = turn.kept()?;
            Some(Bar {
                name: &turn.figure,
                between: between.as_str(),
                ends: [at_low, at_high],
                at: ["kept_at_low", "kept_at_high"].map(|end| format!("/tornado/{i}/{end}")),
            })
        });
    html! {
        p { "Not all numbers of the chip are public. One of them at a time goes from the least to the most that the public data allow, with all others as stated:" }
        (tornado::chart(&Tornado {
            headline: "what is kept",
            nominal,
            at: &format!("/tornado/{first}/kept_nominal"),
            bars: bars.collect(),
        }))
    }
}

fn over_rates(all: &Feasibility, rates: &Rates) -> Markup {
    let title = format!("What is kept of the events of {}", all.kernel.name);
    let alt = format!(
        "{title}: a bar for each frame rate, of what is kept and what each cause takes; the table below has its numbers."
    );
    let first = rates.rates.first();
    let causes = first.map_or(&[][..], |rate| &rate.causes);
    let all_rates = || rates.rates.iter().enumerate();
    let cell = |at: &str, ends: &str, share: Option<f64>, spread: Option<[f64; 2]>| {
        html! {
            td.n {
                (number::fixed_or_none(at, share, 3))
                @if let Some([low, high]) = spread && high > low {
                    span.source { (number::fixed(&format!("{ends}/0"), low, 3)) " to " (number::fixed(&format!("{ends}/1"), high, 3)) }
                }
            }
        }
    };
    html! {
        p { "The same light at several frame rates, from the clip\u{2019}s own to what the chip allows with all slots of its program ("
            (number::plain("/over_rates/ceiling_fps", rates.ceiling_fps)) " frames/s by the nominal times of its data), on "
            (number::plain("/over_rates/chips", rates.chips as f64)) " chips. What is kept is of the float sensor\u{2019}s events at the times of their crossings; the rest is shared out among its causes, those of the chip by their Shapley values." }
        (drawn("Picture of the waterfall over frame rate", &image::drawing(&rates.drawing(&title), &alt)))
        (wide("Waterfall over frame rate", &html! {
            table {
                caption { "What is kept, and what each cause takes; below each, where a further chip on other tiles lies with 80 %" }
                thead { tr {
                    th scope="col" { "Part" }
                    @for (i, rate) in all_rates() {
                        th.n scope="col" { (number::plain(&format!("/over_rates/rates/{i}/fps"), rate.headline.fps)) " frames/s" }
                    }
                } }
                tbody {
                    tr {
                        th scope="row" { "kept" }
                        @for (i, rate) in all_rates() {
                            @let at = format!("/over_rates/rates/{i}");
                            (cell(&format!("{at}/kept"), &format!("{at}/kept_10_90"), rate.headline.kept, rate.kept_10_90))
                        }
                    }
                    @for (k, cause) in causes.iter().enumerate() {
                        tr {
                            th scope="row" { (cause.name) }
                            @for (i, rate) in all_rates() {
                                @if let Some(share) = rate.causes.get(k) {
                                    @let at = format!("/over_rates/rates/{i}/causes/{k}");
                                    (cell(&format!("{at}/share"), &format!("{at}/share_10_90"), share.share, share.share_10_90))
                                } @else { td.n { (number::none()) } }
                            }
                        }
                    }
                    tr {
                        th scope="row" { "as a threshold higher by" }
                        @for (i, rate) in all_rates() {
                            td.n {
                                (number::equivalent(
                                    &format!("/over_rates/rates/{i}/threshold_equivalent_percent"),
                                    rate.headline.threshold_equivalent_percent,
                                    rate.threshold_equivalent_is_least,
                                ))
                            }
                        }
                    }
                }
            }
        }))
        @if let Some(why) = rates.unjudged() { p { "None: " (why) } }
        @for line in rates.captions() { p.note { (line) "." } }
        @if !rates.advice().is_empty() {
            ul { @for line in rates.advice() { li { (line) } } }
        }
    }
}

fn steps(all: &Feasibility, waterfall: &Waterfall) -> Markup {
    let title = format!("Where the events of {} went", all.kernel.name);
    let alt = format!(
        "{title}: a bar for each step from the float sensor to the chip; the table below has its numbers."
    );
    html! {
        p { "Event by event at the clip\u{2019}s own rate, from the float sensor, with the times of its crossings (" (number::plain("/waterfall/float_events", waterfall.float_events as f64))
            " events), to what leaves the chip (" (number::plain("/waterfall/chip_events", waterfall.chip_events as f64))
            "): each step is a sensor that was run, and changes events of the step before it. In order, a step comes after those above it; alone, with all others on. Where the two differ, steps interact." }
        (drawn("Picture of the waterfall", &image::drawing(&waterfall.drawing(&title), &alt)))
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
