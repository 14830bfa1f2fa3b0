//! `amacrine plan`: what a model may leave out of a scene, and the bound that allows it; also
//! `--fidelity auto` of `amacrine run`.

use std::{
    fmt::Write as _,
    path::PathBuf,
    time::{Duration, Instant},
};

use miette::{IntoDiagnostic, WrapErr, miette};
use serde_json::{Value, json};

use crate::{
    event::{Packet, readout::Readout},
    number::Format,
    reference::{Description, Limit},
    scene::{OpenOptions, open},
    study::plan::{self, Change, Choice, Model, Offer, Plan, Question},
    unit::Micros,
};

use super::{progress::Progress, readout, run::read_sensor};

/// What `plan` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example: amacrine plan --scene clips/vtest_256x256.apng --sensor sensors/dvs-v2e.toml --tolerance 1% --verify"
)]
pub struct Arguments {
    /// The scene, as for `amacrine run`
    #[arg(long)]
    scene: String,
    /// The sensor file
    #[arg(long)]
    sensor: PathBuf,
    /// Frames per second, instead of what the scene says
    #[arg(long)]
    fps: Option<f64>,
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
    /// The most events a list may hold
    #[arg(long, default_value_t = Limit::default().events)]
    max_events: usize,
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

/// `--fidelity` of `amacrine run`.
#[derive(Clone, Debug, clap::Args)]
pub struct Fidelity {
    /// `auto` leaves out what cannot matter in this scene, and says what and why
    #[arg(long, value_enum)]
    fidelity: Option<How>,
    /// The share of events that may change under `--fidelity auto`, such as 1% (the default)
    #[arg(long, value_name = "PERCENT", value_parser = percent, allow_hyphen_values = true, requires = "fidelity")]
    tolerance: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, clap::ValueEnum)]
enum How {
    /// All that the sensor file says
    Full,
    /// What is left of it within the tolerance
    Auto,
}

/// An event that is moved by more is changed, where nothing else is said.
const WITHIN: Micros = Micros(100);

/// `1%`, as a share.
fn percent(text: &str) -> Result<f64, String> {
    let number = text.trim().strip_suffix('%').map(str::trim);
    let share = number.and_then(|number| number.parse::<f64>().ok());
    match share {
        None => Err(format!(
            "`{text}` is not a percentage: write a number and a percent sign, such as 1% or 0.1%"
        )),
        Some(percent) if (0.0..=100.0).contains(&percent) => Ok(percent / 100.0),
        Some(percent) => Err(format!(
            "{percent} % of the events cannot be tolerated: give 0% (the full model) to 100%"
        )),
    }
}

impl Fidelity {
    fn tolerance(&self) -> f64 {
        self.tolerance.unwrap_or(0.01)
    }

    /// Whether a plan is asked for.
    #[must_use]
    pub fn is_auto(&self) -> bool {
        self.fidelity == Some(How::Auto)
    }

    /// The plan of a run; arrays that are written are whole, so that it is not cut.
    ///
    /// # Errors
    /// When the scene or the sensor cannot go on.
    pub fn plan(
        &self,
        scene: &str,
        options: &OpenOptions,
        (description, seed): (&Description, u64),
        upsample: Option<f64>,
        readout: Option<Readout>,
    ) -> miette::Result<Plan> {
        let question = Question {
            description,
            seed,
            tolerance: self.tolerance(),
            within: WITHIN,
            formats: &[Format::F32],
            upsample,
            readout,
            crop: false,
        };
        make(&question, scene, options)
    }

    /// What the plan left out, for people.
    #[must_use]
    pub fn lines(&self, plan: &Plan) -> String {
        format!(
            "plan     {}\n{}",
            chosen(&plan.choice),
            allowed(plan, self.tolerance())
        ) + &left_out(plan)
    }

    /// What the plan left out, for machines.
    ///
    /// # Errors
    /// When it cannot be written as JSON, which is a fault of amacrine.
    pub fn json(&self, plan: &Plan) -> miette::Result<Value> {
        let mut json = serde_json::to_value(plan).into_diagnostic()?;
        json["tolerance"] = self.tolerance().into();
        Ok(json)
    }
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
    let options = OpenOptions { fps: arguments.fps };
    let start = Instant::now();
    let plan = make(&question, &arguments.scene, &options)
        .wrap_err_with(|| format!("{} seen by {}", arguments.scene, arguments.sensor.display()))?;
    let planning = start.elapsed();
    let limit = Limit {
        events: arguments.max_events,
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
        let json = as_json(
            arguments,
            &plan,
            planning,
            planned.as_ref(),
            verified.as_ref(),
        )?;
        super::say(&format!("{json}\n"));
    } else {
        let text = as_text(
            arguments,
            &plan,
            planning,
            planned.as_ref(),
            verified.as_ref(),
        );
        super::say(&text);
    }
    verified.map_or(Ok(()), |verified| verified.held(&plan))
}

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

/// Makes the plan, with a bar.
fn make(question: &Question<'_>, scene: &str, options: &OpenOptions) -> miette::Result<Plan> {
    let frames = open(scene, options)?.frames();
    let progress = Progress::new("looking", frames.map(|frames| 2 * frames));
    let plan = plan::plan(question, &mut || open(scene, options), || progress.tick());
    progress.finish();
    Ok(plan?)
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
    json["scene"] = arguments.scene.clone().into();
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

/// One thing that could be left out.
fn line(offer: &Offer, measured: Option<String>) -> String {
    let bound = offer
        .bound
        .map_or("no bound".to_owned(), |b| share(b.share));
    let mark = if offer.left_out { '*' } else { ' ' };
    let mut line = format!("{mark} {:<26} {bound:>10}", offer.what);
    if let Some(measured) = measured {
        let _ = write!(line, " {measured:>10}");
    }
    let _ = write!(line, "   {}", offer.why);
    if !offer.with.is_empty() {
        let names: Vec<_> = offer.with.iter().map(ToString::to_string).collect();
        let _ = write!(line, " (also without {})", names.join(", "));
    }
    line + "\n"
}

/// What is left out, with the reasons.
fn left_out(plan: &Plan) -> String {
    let left_out = plan.offers.iter().filter(|offer| offer.left_out);
    left_out.map(|offer| line(offer, None)).collect()
}

fn chosen(choice: &Choice) -> String {
    let without: Vec<_> = choice.without.iter().map(ToString::to_string).collect();
    if choice == &Choice::full() {
        "the full model: nothing is left out".to_owned()
    } else if without.is_empty() {
        choice.format.to_string()
    } else {
        format!("{}, without {}", choice.format, without.join(", "))
    }
}

fn allowed(plan: &Plan, tolerance: f64) -> String {
    format!(
        "         at most {} of the events change ({:.0} without a partner); {} are tolerated\n",
        share(plan.bound.share),
        plan.bound.events,
        share(tolerance)
    )
}

/// A share in percent, with three figures.
fn share(share: f64) -> String {
    let percent = 100.0 * share;
    if percent == 0.0 {
        "0 %".to_owned()
    } else if percent > 100.0 || percent.is_nan() {
        "over 100 %".to_owned()
    } else if percent < 0.01 {
        format!("{percent:.1e} %")
    } else if percent < 10.0 {
        format!("{percent:.3} %")
    } else {
        format!("{percent:.1} %")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentages_are_read() {
        assert_eq!(percent("1%"), Ok(0.01));
        assert_eq!(percent(" 0.5 % "), Ok(0.005));
        assert_eq!(percent("0%"), Ok(0.0));
        for wrong in ["1", "0.01", "%", "-1%", "101%", "nan%", "inf%", "one%", ""] {
            assert!(percent(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn shares_have_three_figures() {
        let shown = [0.0, 1e-7, 0.000_447, 0.0123, 0.5, 9.7, f64::INFINITY].map(share);
        let want = [
            "0 %",
            "1.0e-5 %",
            "0.045 %",
            "1.230 %",
            "50.0 %",
            "over 100 %",
            "over 100 %",
        ];
        assert_eq!(shown, want);
    }
}
