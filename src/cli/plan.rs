//! `amacrine plan`: what a model may leave out of a scene, and what a pilot measured of it.

use std::{
    fmt::Write as _,
    time::{Duration, Instant},
};

use miette::{IntoDiagnostic, WrapErr, miette};
use serde_json::{Value, json};

use super::{
    arguments::{
        budget,
        clip::GivenScene,
        fidelity::{KeptOrUnread, chosen, line, make, percent},
        heading, light,
        quantiser::number_format,
        readout,
    },
    output::{files::Input, progress::Progress},
    run::read_sensor,
};
use crate::{
    event::Packet,
    number::Format,
    reference::{Description, Limit, Reference},
    rig::guard::Warning,
    scene::{Observation, kept::Kept},
    study::pilot::{Change, Choice, Plan, Question, change::share, model::Model, plan::BUDGET},
    unit::{Micros, counted},
};

/// What `plan` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example: amacrine plan --scene bundled --sensor dvs-v2e --tolerance 1% --verify"
)]
pub struct Arguments {
    #[command(flatten)]
    given: GivenScene,
    /// Sensor file, or a name that `amacrine list sensors` prints
    #[arg(long)]
    sensor: Input,
    /// Insert frames, as `amacrine run` does
    #[arg(long, value_name = "CONTRAST", value_parser = light::contrast, help_heading = heading::SCENE)]
    upsample: Option<f64>,
    /// Seed of mismatch and noise
    #[arg(long, default_value_t = 0, help_heading = heading::MODELS)]
    seed: u64,
    #[command(flatten)]
    asked: Asked,
    #[command(flatten)]
    readout: readout::Choice,
    /// Run the planned model
    #[arg(long)]
    run: bool,
    /// Run both models, and show what every omission really changes beside its limit
    #[arg(long)]
    verify: bool,
    /// Largest number of events in a list, with --run or --verify
    ///
    /// Default: 100000000, or as many as fit into memory.
    #[arg(long, help_heading = heading::MODELS)]
    max_events: Option<usize>,
    /// Print JSON in place of text
    #[arg(long)]
    json: bool,
}

/// How much may change.
#[derive(Clone, Debug, clap::Args)]
struct Asked {
    /// Share of the full model's events that may change, such as 1%
    #[arg(long, default_value = "1%", value_name = "PERCENT", value_parser = percent, allow_hyphen_values = true)]
    tolerance: f64,
    /// Largest shift in time of an event that does not count as changed
    #[arg(long, default_value = "100us", value_name = "TIME", help_heading = heading::MODELS)]
    within: Micros,
    #[arg(
        long,
        help = format!("Number formats to try in place of f64: {}", Format::names()),
        default_value = "f32",
        value_delimiter = ',',
        value_name = "FORMATS",
        value_parser = number_format,
        help_heading = heading::MODELS,
    )]
    formats: Vec<Format>,
}

impl Arguments {
    /// Refuses a bound of lists where none is made.
    fn check_list(&self) -> miette::Result<()> {
        match self.max_events {
            Some(most) if !self.run && !self.verify => Err(miette!(
                help = "add --run or --verify, or leave --max-events out",
                "--max-events {most} needs --run or --verify: it limits their lists of events"
            )),
            _ => Ok(()),
        }
    }
}

/// A model that was run.
struct Ran {
    packet: Packet,
    time: Duration,
}

/// What everything really changes.
struct Verified {
    full: Ran,
    change: Change,
    offers: Vec<Change>,
}

/// Runs the verb.
///
/// # Errors
/// When the scene or the sensor file is not what it should be.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    arguments.check_list()?;
    let description = read_sensor(&arguments.sensor)?;
    let readout = arguments.readout.open()?.map(|d| d.readout()).transpose()?;
    let mut formats = Vec::new();
    for format in &arguments.asked.formats {
        if !formats.contains(format) {
            formats.push(*format);
        }
    }
    let question = Question {
        description: &description,
        seed: arguments.seed,
        tolerance: arguments.asked.tolerance,
        within: arguments.asked.within,
        formats: &formats,
        upsample: arguments.upsample,
        readout,
        crop: true,
        looks_anyway: true,
        budget: BUDGET,
        tiles: None,
    };
    let observation = Observation::new();
    let open = || arguments.given.open(&observation);
    let source = KeptOrUnread::new(true, open)?;
    let KeptOrUnread::Kept(kept) = source else {
        return Err(miette!(
            help = "take a shorter or smaller scene; amacrine run --fidelity auto takes it, by rules that need no measurement",
            "{} is too long to be kept in memory, and a pilot looks at all of it",
            arguments.given.scene
        ));
    };
    light::check_frames(kept.len() as u64)?;
    let events = events(arguments, &description, &kept)?;
    let plan = make(&question, Some(&kept))
        .wrap_err_with(|| arguments.given.seen_by(&arguments.sensor))?;
    let limit = Limit {
        events,
        ..Limit::default()
    };
    let ran = |model: Model<'_>, what| ran(&model, what, &kept);
    let planned = if arguments.run || arguments.verify {
        Some(ran(Model::planned(&question, &plan, limit), "planned")?)
    } else {
        None
    };
    let verified = match &planned {
        Some(planned) if arguments.verify => {
            let full = ran(Model::full(&question, limit), "full")?;
            let mut offers = Vec::new();
            for offer in &plan.offers {
                let model = Model {
                    choice: offer.model.clone(),
                    ..Model::planned(&question, &plan, limit)
                };
                let plain = ran(model, "one offer")?;
                offers.push(Change::between(
                    &full.packet,
                    &plain.packet,
                    question.within,
                )?);
            }
            Some(Verified {
                change: Change::between(&full.packet, &planned.packet, question.within)?,
                full,
                offers,
            })
        }
        _ => None,
    };
    let told = Told {
        arguments,
        plan: &plan,
        kept: &kept,
        planned: planned.as_ref(),
        verified: verified.as_ref(),
    };
    let mut warnings = Warning::of_scene(&observation, description.response);
    if planned
        .as_ref()
        .is_some_and(|ran| ran.packet.events.is_empty())
    {
        let frames = kept.len() as u64;
        warnings.push(Warning::no_events(&description.name, Some(frames)));
    }
    light::warn(&warnings);
    if arguments.json {
        let mut json = told.json()?;
        json["light"] = light::json(&observation);
        super::say(&format!("{json}\n"));
    } else {
        super::say(&(told.text() + &light::line(&observation)));
    }
    Ok(())
}

/// How many events a list may hold beside the scene, the model and its tiles.
fn events(arguments: &Arguments, description: &Description, kept: &Kept) -> miette::Result<usize> {
    let size = kept.size();
    let model = <Reference>::bytes(description, size);
    let need = budget::of_scene(&kept.scene()).and("the model and its tiles", 2 * model);
    let what = format!("a plan for {size}");
    let lists = 1 + u128::from(arguments.run) + 2 * u128::from(arguments.verify);
    let help = "take a smaller scene";
    budget::events(
        &need,
        arguments.max_events,
        lists * budget::MADE,
        &what,
        help,
    )
}

fn ran(model: &Model<'_>, what: &'static str, kept: &Kept) -> miette::Result<Ran> {
    let progress = Progress::new(what, Some(kept.len() as u64));
    let start = Instant::now();
    let packet = model.run(kept.scene(), || progress.tick())?;
    let time = start.elapsed();
    progress.finish();
    Ok(Ran { packet, time })
}

/// What there is to tell.
struct Told<'a> {
    arguments: &'a Arguments,
    plan: &'a Plan,
    kept: &'a Kept,
    planned: Option<&'a Ran>,
    verified: Option<&'a Verified>,
}

impl Verified {
    /// Whether the limit held: of twenty plans one may exceed it.
    fn held(&self, plan: &Plan) -> bool {
        // Rules leave rounding.
        self.change.share <= plan.limit().max(1e-3)
    }
}

impl Told<'_> {
    fn json(&self) -> miette::Result<Value> {
        let Self {
            arguments, plan, ..
        } = self;
        let mut json = serde_json::to_value(plan).into_diagnostic()?;
        json["scene"] = (*arguments.given.scene).into();
        json["sensor"] = arguments.sensor.display().to_string().into();
        json["tolerance"] = arguments.asked.tolerance.into();
        json["within_us"] = arguments.asked.within.0.into();
        json["planned"] = self.planned.map_or(
            Value::Null,
            |ran| json!({"events": ran.packet.events.len(), "seconds": ran.time.as_secs_f64()}),
        );
        json["verified"] = self.verified.map_or(Value::Null, |verified| {
            json!({
                "full": {"events": verified.full.packet.events.len(), "seconds": verified.full.time.as_secs_f64()},
                "change": verified.change,
                "offers": verified.offers,
                "held": verified.held(plan),
            })
        });
        Ok(json)
    }

    fn text(&self) -> String {
        let Self {
            arguments,
            plan,
            kept,
            ..
        } = self;
        let mut text = format!(
            "scene    {}, {}, {}\n\n",
            arguments.given.scene,
            kept.size(),
            counted(kept.len(), "frame")
        );
        let measured = if self.verified.is_some() {
            "   measured"
        } else {
            ""
        };
        let _ = writeln!(
            text,
            "{:<28} {:>10} {:>10} {:>7}{measured}",
            "without", "about", "at most", "time"
        );
        for free in &plan.free {
            let mark = if plan.choice.leaves_out(free.what) {
                '*'
            } else {
                ' '
            };
            let _ = writeln!(
                text,
                "{mark} {:<26} {:>10} {:>10} {:>7}   {}",
                free.what.name(),
                "0 %",
                "free",
                "",
                free.why
            );
        }
        for (n, offer) in plan.offers.iter().enumerate() {
            let measured = self.verified.map(|verified| {
                let change = verified.offers.get(n);
                change.map_or(String::new(), |change| share(change.share))
            });
            text += &line(offer, measured);
        }
        text += "\n";
        text += &chosen(plan, arguments.asked.tolerance);
        if let Some([full, plain]) = plan.expected {
            let _ = writeln!(
                text,
                "time     {plain:.3} s for the sensor where the full one{} takes {full:.3} s (expected); the pilot took {:.3} s",
                if plan.free.is_empty() {
                    ""
                } else {
                    ", without what is free,"
                },
                plan.seconds
            );
        }
        if let Some(ran) = self.planned {
            let _ = writeln!(
                text,
                "run      {} in {:.3} s, the scene's frames and the readout included",
                counted(ran.packet.events.len(), "event"),
                ran.time.as_secs_f64()
            );
        }
        if let (Some(verified), Some(ran)) = (self.verified, self.planned) {
            let Change {
                missing,
                extra,
                share: changed,
                ..
            } = verified.change;
            // Two runs of the same model differ by chance, and by which of them was the first.
            let times = if plan.choice == Choice::full() {
                "nothing is left out, so that there are no times to compare".to_owned()
            } else {
                let times = verified.full.time.as_secs_f64() / ran.time.as_secs_f64().max(1e-9);
                let held = if verified.held(plan) {
                    "held"
                } else {
                    "did not hold"
                };
                format!("the plan is {times:.2} times as fast, and its limit {held}")
            };
            let _ = writeln!(
                text,
                "verified {} in {:.3} s by the full model: {missing} missing, {extra} extra, {} changed; {times}",
                counted(verified.full.packet.events.len(), "event"),
                verified.full.time.as_secs_f64(),
                share(changed),
            );
        }
        text
    }
}
