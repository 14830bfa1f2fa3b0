//! `--fidelity auto` of `amacrine exec`: what the array may leave out.

use std::{fmt::Write as _, time::Instant};

use miette::{IntoDiagnostic, miette};
use serde_json::{Value, json};

use super::{
    arguments::Arguments,
    bench::Bench,
    light::{Lasting, Light},
};
use crate::{
    cli::{
        arguments::fidelity::{WITHIN, line, room, told},
        complain,
    },
    number::Format,
    scene::{Scene as _, kept::Kept},
    study::pilot::{
        Answer, Machine, Measure, Quicker, order,
        plan::{BUDGET, TOO_LONG},
    },
    unit::Micros,
};

/// Domains that may be taken in place of the one that was asked for, beside `exact`.
const FORMATS: [&str; 2] = ["f32", "q8.8"];

/// What is left out of a run, and the order in which the array is worked on.
pub struct Planned {
    pub answer: Answer<Machine>,
    full: Machine,
    /// A quicker schedule than the usual one, if there is one and none was asked for.
    pub quicker: Option<Quicker>,
    /// The clip, which was read for it.
    pub read: Option<Kept>,
}

/// Asks a pilot what may be left out of a run.
///
/// # Errors
/// When more than events is asked for, or the light or the array cannot go on.
pub fn plan(bench: &Bench<'_>) -> miette::Result<Planned> {
    let arguments = bench.arguments;
    let pictures = arguments.strip.is_some() || arguments.trace.is_some();
    let registers = arguments.dump.is_some() || pictures || arguments.debug;
    if registers || arguments.repeat.is_some() {
        return Err(miette!(
            help = "leave --dump, --strip, --trace, --debug and --repeat out, or --fidelity",
            "--fidelity auto keeps events, and registers are looked at"
        ));
    }
    let opened = &bench.opened;
    if opened.expansion.bare {
        return Err(miette!(
            help = "give a program with `init` and `frame`, or run it without --fidelity",
            "--fidelity auto: {} is bare statements: it says no events",
            opened.program.file
        ));
    }
    if !bench.planes.is_empty() {
        return Err(miette!(
            help = "leave --set of registers out, or run it without --fidelity",
            "--fidelity auto with registers that are set: a pilot shows nothing but light"
        ));
    }
    let mut light = Light::open(arguments, &opened.program, &bench.observation)?;
    let (lit, most) = (light.scene.is_some(), room());
    let read = light.keep(most)?;
    let mut light = Lasting::new(light, bench.size, 2);
    let family = bench.execution().chips();
    let kept = match &read {
        None if lit => None,
        // It is the light as it is: no second copy.
        Some(read) if light.lasts(read.len()) => Some(read.clone()),
        _ => Kept::new(&mut light, most - read.as_ref().map_or(0, Kept::bytes))?,
    };
    let Some(kept) = kept else {
        return Ok(Planned::unmeasured(family.machine()));
    };
    let formats = FORMATS.iter().filter_map(|name| name.parse().ok());
    let formats: Vec<Format> = formats.chain([Format::F64]).collect();
    let start = Instant::now();
    let clock = || start.elapsed().as_secs_f64();
    // An event that the full model loses is a change of its own frame.
    let within = WITHIN.min(Micros::from_seconds(0.5 / kept.scene().fps()));
    let measure = Measure {
        kept: &kept,
        upsample: None,
        tolerance: arguments.fidelity.tolerance(),
        within,
        seed: arguments.seed(),
        clock: &clock,
        budget: BUDGET,
        tiles: None,
        look: None,
        limits_only: false,
    };
    let answer = measure.ask(&family, &family.candidates(&formats))?;
    // A schedule that was asked for stays.
    let left = (BUDGET.0, BUDGET.1 - answer.seconds);
    let quicker = match arguments.schedule {
        Some(_) => None,
        None => order::quicker(&family, &answer.choice, &kept, left, &clock),
    };
    Ok(Planned {
        answer,
        full: family.machine(),
        quicker,
        read,
    })
}

impl Planned {
    /// The full model, since there is no room for the light.
    fn unmeasured(full: Machine) -> Self {
        let answer = Answer {
            choice: full.clone(),
            change: None,
            offers: Vec::new(),
            why: TOO_LONG.to_owned(),
            seconds: 0.0,
            expected: None,
        };
        Self {
            answer,
            full,
            quicker: None,
            read: None,
        }
    }

    /// Whether anything is left out that may change an event.
    pub fn leaves_out(&self) -> bool {
        self.answer.offers.iter().any(|offer| offer.left_out)
    }

    /// Takes the full model, and warns. A readout whose slots are full loses events for others,
    /// wherever they are: then the pilot's limit is none.
    pub fn give_up(&mut self) {
        let why = "slots of the readout were full: which events are lost depends on the whole array, and a pilot has no limit on what its changes do to that";
        complain(&format!("warning: {why}: the full model ran\n"));
        let Answer {
            choice,
            change,
            offers,
            why: ended,
            expected,
            ..
        } = &mut self.answer;
        choice.clone_from(&self.full);
        *change = None;
        *expected = expected.map(|[full, _]| [full, full]);
        why.clone_into(ended);
        for offer in offers.iter_mut().filter(|offer| offer.left_out) {
            offer.left_out = false;
            "slots of the readout were full".clone_into(&mut offer.why);
        }
    }
}

/// What is left out, for machines.
///
/// # Errors
/// When it cannot be written as JSON, which is a fault of amacrine.
pub fn json(plan: &Planned, arguments: &Arguments) -> miette::Result<Value> {
    let mut json = serde_json::to_value(&plan.answer).into_diagnostic()?;
    if let Some(Quicker { schedule, seconds }) = plan.quicker {
        json["schedule"] = json!({ "quicker": schedule.to_string(), "seconds_per_frame": seconds });
    }
    json["tolerance"] = arguments.fidelity.tolerance().into();
    Ok(json)
}

/// What is left out, for people.
pub fn lines(plan: &Planned, arguments: &Arguments) -> String {
    let Planned {
        answer: plan,
        quicker,
        ..
    } = plan;
    let choice = plan.choice.to_string();
    let mut text = told(
        (&choice, &plan.why),
        plan.change,
        arguments.fidelity.tolerance(),
    );
    for offer in plan.offers.iter().filter(|offer| offer.left_out) {
        text += &line(offer, None);
    }
    if let Some(Quicker { schedule, seconds }) = quicker {
        let [asked, quicker] = seconds.map(|seconds| 1e3 * seconds);
        let what = format!("schedule {schedule}");
        let _ = writeln!(
            text,
            "* {what:<26} free: it changes no event; {quicker:.2} ms a frame in place of {asked:.2}"
        );
    }
    text
}
