//! `amacrine plan`: what a model may leave out of a scene, and the bound that allows it.

use std::{
    fmt::Write as _,
    time::{Duration, Instant},
};

use miette::{IntoDiagnostic, WrapErr, miette};
use serde_json::{Value, json};

use crate::{
    event::Packet,
    number::Format,
    reference::{Description, Limit, Reference},
    scene::{Observation, OpenOptions, Scene as _, open},
    study::plan::{Change, Choice, Model, Plan, Question},
    unit::Micros,
};

use super::{
    budget,
    fidelity::{allowed, chosen, line, make, percent, share},
    files::{Input, Named},
    light::{self, Samples},
    progress::Progress,
    readout,
    run::read_sensor,
};

/// What `plan` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example: amacrine plan --scene clips/vtest_256x256.apng --sensor sensors/dvs-v2e.toml --tolerance 1% --verify"
)]
pub struct Arguments {
    /// The scene, as for `amacrine run`
    #[arg(long)]
    scene: Named,
    /// The sensor file
    #[arg(long)]
    sensor: Input,
    /// Frames per second, instead of what the scene says
    #[arg(long)]
    fps: Option<f64>,
    #[command(flatten)]
    samples: Samples,
    /// Insert frames, as for `amacrine run`
    #[arg(long, value_name = "CONTRAST")]
    upsample: Option<f64>,
    /// Chooses mismatch and noise
    #[arg(long, default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    asked: Asked,
    #[command(flatten)]
    readout: readout::Choice,
    /// Run the planned model
    #[arg(long)]
    run: bool,
    /// Run it and the full model, and show what every step really changes beside its bound
    #[arg(long)]
    verify: bool,
    /// The most events a list may hold [default: 100000000, or what there is memory for]
    #[arg(long)]
    max_events: Option<usize>,
    /// Print one JSON object instead of the table
    #[arg(long)]
    json: bool,
}

/// How much may change.
#[derive(Clone, Debug, clap::Args)]
struct Asked {
    /// The share of the full model's events that may change, such as 1%
    #[arg(long, default_value = "1%", value_name = "PERCENT", value_parser = percent, allow_hyphen_values = true)]
    tolerance: f64,
    /// An event that is moved by more than this is changed
    #[arg(long, default_value = "100us", value_name = "TIME")]
    within: Micros,
    /// Number formats that may be taken in place of f64
    #[arg(
        long,
        default_value = "f32",
        value_delimiter = ',',
        value_name = "FORMATS"
    )]
    formats: Vec<Format>,
}

/// A model that was run.
struct Ran {
    packet: Packet,
    time: Duration,
}

/// What every step really changes.
struct Verified {
    full: Ran,
    change: Change,
    steps: Vec<Option<Change>>,
}

/// Runs the verb.
///
/// # Errors
/// When the scene or the sensor file is not what it should be, or a bound did not hold.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let description = read_sensor(&arguments.sensor)?;
    let readout = arguments.readout.open()?.map(|d| d.readout()).transpose()?;
    let question = Question {
        description: &description,
        seed: arguments.seed,
        tolerance: arguments.asked.tolerance,
        within: arguments.asked.within,
        formats: &arguments.asked.formats,
        upsample: arguments.upsample,
        readout,
        crop: true,
    };
    let options = arguments.samples.opening(arguments.fps);
    let events = events(arguments, &description)?;
    let observation = Observation::new();
    // Only to be asked how its samples become light.
    drop(
        arguments
            .samples
            .open(Some(&arguments.scene), arguments.fps, &observation)?,
    );
    let start = Instant::now();
    let plan = make(&question, &arguments.scene, &options)
        .wrap_err_with(|| format!("{} seen by {}", arguments.scene, arguments.sensor.display()))?;
    let planning = start.elapsed();
    let limit = Limit {
        events,
        ..Limit::default()
    };
    let ran = |model: Model, what| ran(model, what, &arguments.scene, &options);
    let planned = if arguments.run || arguments.verify {
        Some(ran(Model::planned(&question, &plan, limit), "planned")?)
    } else {
        None
    };
    let verified = match &planned {
        Some(planned) if arguments.verify => {
            let full = ran(Model::full(&question, limit), "full")?;
            let mut steps = Vec::new();
            for offer in &plan.offers {
                let step = |model: &Choice| {
                    let model = Model::chosen(&question, model, plan.window.clone(), limit);
                    let step = ran(model, "one step")?;
                    let change = Change::between(&full.packet, &step.packet, question.within);
                    change.into_diagnostic()
                };
                steps.push(offer.model.as_ref().map(step).transpose()?);
            }
            Some(Verified {
                change: Change::between(&full.packet, &planned.packet, question.within)?,
                full,
                steps,
            })
        }
        _ => None,
    };
    if arguments.json {
        let mut json = as_json(
            arguments,
            &plan,
            planning,
            planned.as_ref(),
            verified.as_ref(),
        )?;
        json["light"] = light::json(&observation);
        super::say(&format!("{json}\n"));
    } else {
        let text = as_text(
            arguments,
            &plan,
            planning,
            planned.as_ref(),
            verified.as_ref(),
        );
        super::say(&(text + &light::line(&observation)));
    }
    verified.map_or(Ok(()), |verified| verified.held(&plan))
}

/// How many events a list may hold beside the model, its probe and what is followed of each cell.
fn events(arguments: &Arguments, description: &Description) -> miette::Result<usize> {
    let scene = open(&arguments.scene, &arguments.samples.opening(arguments.fps))?;
    let size = scene.size();
    let model = <Reference>::bytes(description, size);
    let cells = (size.pixels() * description.channels.len()) as u128;
    let need = budget::of_scene(&*scene)
        .and("the model and its probe", 3 * model)
        .and("what is followed of each cell", FOLLOWED * cells);
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

/// Bytes of what is followed of a cell.
const FOLLOWED: u128 = 200;

impl Verified {
    /// Whether every bound held.
    fn held(&self, plan: &Plan) -> miette::Result<()> {
        let steps = plan.offers.iter().zip(&self.steps);
        let mut broken = steps.filter_map(|(offer, change)| {
            let (bound, change) = (offer.bound?, (*change)?);
            above(&change, bound.events).then(|| offer.what.clone())
        });
        let plan = above(&self.change, plan.bound.events).then(|| "the plan".to_owned());
        match plan.or_else(|| broken.next()) {
            None => Ok(()),
            Some(what) => Err(miette!(
                help = "this is a fault of amacrine: please report the scene, the sensor file and the seed",
                "{what} changes more events than its bound allows"
            )),
        }
    }
}

/// Whether more changed than a bound allows.
fn above(change: &Change, bound: f64) -> bool {
    (change.missing + change.extra) as f64 > bound
}

fn ran(
    model: Model,
    what: &'static str,
    scene: &str,
    options: &OpenOptions,
) -> miette::Result<Ran> {
    let progress = Progress::new(what, open(scene, options)?.frames());
    let start = Instant::now();
    let packet = model.run(&mut || open(scene, options), || progress.tick())?;
    let time = start.elapsed();
    progress.finish();
    Ok(Ran { packet, time })
}

fn as_json(
    arguments: &Arguments,
    plan: &Plan,
    planning: Duration,
    planned: Option<&Ran>,
    verified: Option<&Verified>,
) -> miette::Result<Value> {
    let mut json = serde_json::to_value(plan).into_diagnostic()?;
    json["scene"] = (*arguments.scene).into();
    json["sensor"] = arguments.sensor.display().to_string().into();
    json["tolerance"] = arguments.asked.tolerance.into();
    json["within_us"] = arguments.asked.within.0.into();
    json["planning_seconds"] = planning.as_secs_f64().into();
    json["planned"] = planned.map_or(
        Value::Null,
        |ran| json!({"events": ran.packet.events.len(), "seconds": ran.time.as_secs_f64()}),
    );
    json["verified"] = verified.map_or(Value::Null, |verified| {
        json!({
            "full": {"events": verified.full.packet.events.len(), "seconds": verified.full.time.as_secs_f64()},
            "change": verified.change,
            "steps": verified.steps,
            "held": verified.held(plan).is_ok(),
        })
    });
    Ok(json)
}

fn as_text(
    arguments: &Arguments,
    plan: &Plan,
    planning: Duration,
    planned: Option<&Ran>,
    verified: Option<&Verified>,
) -> String {
    let light = &plan.light;
    let mut text = format!(
        "scene    {}, {}, {} frames in {:.6} s\n         light {:.4} to {:.4}, {:.3} ln units a pixel and second, {} of the tiles change\n         root mean square frequency {:.3} cycles/pixel, {:.2} Hz\nfull     at least {:.0} events\n\n",
        arguments.scene,
        light.size,
        light.frames,
        light.seconds,
        light.range.0,
        light.range.1,
        light.contrast_per_second,
        share(light.active_tiles),
        light.spatial_frequency,
        light.temporal_frequency,
        plan.events,
    );
    let measured = if verified.is_some() {
        "   measured"
    } else {
        ""
    };
    let _ = writeln!(text, "{:<28} {:>10}{measured}", "without", "at most");
    for (n, offer) in plan.offers.iter().enumerate() {
        let measured = verified.map(|verified| match verified.steps.get(n) {
            Some(Some(change)) => share(change.share),
            _ => String::new(),
        });
        text += &line(offer, measured);
    }
    let _ = write!(
        text,
        "\nplan     {}\n{}",
        chosen(&plan.choice),
        allowed(plan, arguments.asked.tolerance)
    );
    let [full, cheapest] = plan.seconds;
    let _ = writeln!(
        text,
        "time     {:.3} ms a core for the sensor, {:.3} ms for the full one (modelled); the plan took {:.3} ms",
        cheapest * 1e3,
        full * 1e3,
        planning.as_secs_f64() * 1e3
    );
    if let Some(ran) = planned {
        let _ = writeln!(
            text,
            "run      {} events in {:.3} ms, the scene's own time included",
            ran.packet.events.len(),
            ran.time.as_secs_f64() * 1e3
        );
    }
    if let (Some(verified), Some(ran)) = (verified, planned) {
        let Change {
            missing,
            extra,
            share: changed,
            ..
        } = verified.change;
        let _ = writeln!(
            text,
            "verified {} events in {:.3} ms by the full model: {missing} missing, {extra} extra, {} changed; the plan is {:.2} times as fast",
            verified.full.packet.events.len(),
            verified.full.time.as_secs_f64() * 1e3,
            share(changed),
            verified.full.time.as_secs_f64() / ran.time.as_secs_f64().max(1e-9)
        );
        let held = if verified.held(plan).is_ok() {
            "every bound held"
        } else {
            "a bound did not hold"
        };
        let _ = writeln!(text, "         {held}");
    }
    text
}
