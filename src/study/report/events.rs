//! Which events are right, and what they cost, against the float kernel and a plain DVS.

use maud::{Markup, html};

use super::{
    bars, number,
    part::{Part, broad, part, wide},
    power,
};
use crate::study::{
    equivalent::Likeness,
    feasibility::{Feasibility, Stream, stream::Scored},
};

/// A sensor that watched: what it is called, where it is in the JSON, what it said.
type Watched<'a> = (&'static str, &'static str, &'a Stream);

fn watched(all: &Feasibility) -> Vec<Watched<'_>> {
    let streams = &all.streams;
    [
        ("Plain DVS", "/streams/dvs", Some(&streams.dvs)),
        ("Float kernel", "/streams/float", Some(&streams.float)),
        (
            "Program, no errors",
            "/streams/exact",
            streams.exact.as_ref(),
        ),
        (
            "Program on the chip",
            "/streams/silicon",
            streams.silicon.as_ref(),
        ),
    ]
    .into_iter()
    .filter_map(|(name, at, stream)| Some((name, at, stream?)))
    .collect()
}

/// How much each sensor says, and what a link would take for it.
pub(super) fn emitted(all: &Feasibility) -> Part {
    let rows = watched(all);
    let most = rows
        .iter()
        .map(|(.., s)| s.events)
        .max()
        .unwrap_or(0)
        .max(1);
    part(
        "emit",
        "What should it emit?",
        html! {
            p { "All sensors decide once a frame, at the same threshold. The plain DVS sees each pixel alone; an event costs one address word of row, column and sign." }
            (wide("Events and bits", &html! {
                table {
                    caption { "How many events each sensor sends" }
                    thead { tr {
                        th scope="col" { "Sensor" }
                        th.n scope="col" { "Events" }
                        th.n scope="col" { "a pixel and s" }
                        th.n scope="col" { "kbit/s" }
                        th.n scope="col" { "kbit/s, busiest frame" }
                        th.n scope="col" { "beyond all slots" }
                    } }
                    tbody {
                        @for (name, at, stream) in &rows {
                            tr {
                                th scope="row" { (name) (bars::bar(stream.events as f64 / most as f64)) }
                                td.n { (number::plain(&format!("{at}/events"), stream.events as f64)) }
                                td.n { (number::maybe(&format!("{at}/per_pixel_s"), stream.per_pixel_s)) }
                                td.n { (number::maybe(&format!("{at}/mean_kbit_s"), stream.mean_kbit_s)) }
                                td.n { (number::plain(&format!("{at}/peak_kbit_s"), stream.peak_kbit_s)) }
                                td.n { (number::plain(&format!("{at}/dropped"), stream.dropped as f64)) }
                            }
                        }
                    }
                }
            }))
            (power::link(all))
        },
    )
}

/// How much of what each sensor says is right.
pub(super) fn right(all: &Feasibility) -> Part {
    let rows = watched(all);
    part(
        "task",
        "Which task belongs on the sensor?",
        html! {
            p { "One for which the chip sends the events of the float kernel, and a plain DVS does not. An event is right where the float kernel has one of the same pixel and sign within "
                (number::scaled("/within_us", all.within_us.0 as f64, 1e-3)) " ms. The floor is what chance alone scores: the float kernel's own events at other cells' times, or at other pixels, whichever scores more. The ceiling is 1." }
            @if all.streams.float.events == 0 {
                p { "The float kernel has no event on this scene: there is nothing to keep." }
            } @else { (broad("Scores", &html! {
                table {
                    caption { "Scores against the float kernel, each with its floor" }
                    thead { tr {
                        th scope="col" { "Sensor" }
                        th.n scope="col" { "Precision" }
                        th.n scope="col" { "Recall" }
                        th.n scope="col" { "F1" }
                        th.n scope="col" { "Floor of F1" }
                        th.n scope="col" { "F1, a frame apart" }
                        th.n scope="col" { "kept" }
                        th.n scope="col" { "as threshold" }
                        th.n scope="col" { "kept, at equal events" }
                    } }
                    tbody {
                        @for (name, at, stream) in &rows {
                            @if let Some(judged) = &stream.judged {
                                @let at = format!("{at}/judged");
                                tr {
                                    th scope="row" { (name) (bars::score(judged.f1.value, judged.f1.floor)) }
                                    (scored(&format!("{at}/precision"), &judged.precision))
                                    (scored(&format!("{at}/recall"), &judged.recall))
                                    (scored(&format!("{at}/f1"), &judged.f1))
                                    td.n { (number::fixed(&format!("{at}/f1/floor"), judged.f1.floor, 3)) }
                                    (scored(&format!("{at}/f1_a_frame_apart"), &judged.f1_a_frame_apart))
                                    (kept(&at, &judged.likeness))
                                }
                            }
                        }
                    }
                }
            })) }
            @if all.streams.float.events > 0 { p.note { "The mark in each bar is the floor. In the column for a frame apart, an event may be a frame early or late: what is above F1 there are right events at the wrong time. "
                "Kept is the part of F1 above that of a redraw of the float kernel\u{2019}s events; the threshold is the change of the float sensor\u{2019}s threshold that costs as much; at equal events its threshold was set so that it sends as many events, which leaves differences of shape and removes those of gain." } }
        },
    )
}

/// What is kept, the threshold equivalent, and what is kept of a float sensor of as many events.
fn kept(at: &str, likeness: &Likeness) -> Markup {
    let tuned = likeness.tuned.as_ref();
    html! {
        td.n { (number::fixed_or_none(&format!("{at}/kept"), likeness.kept, 3)) }
        td.n { (number::equivalent(
            &format!("{at}/threshold_equivalent_percent"),
            likeness.judged_equivalent(),
            likeness.threshold_equivalent_is_least,
        )) }
        td.n {
            (number::fixed_or_none(
                &format!("{at}/likeness/tuned/kept"),
                tuned.and_then(|tuned| tuned.kept),
                3,
            ))
        }
    }
}

fn scored(at: &str, score: &Scored) -> Markup {
    html! { td.n { (number::fixed(&format!("{at}/value"), score.value, 3)) } }
}
