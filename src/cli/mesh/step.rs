//! `amacrine mesh step`: the surround of a scene over time.

use std::ops::ControlFlow;

use miette::{WrapErr, miette};

use super::{
    constants::Constants,
    output::{Show, say_json},
};
use crate::{
    cli::{
        arguments::{budget, clip::GivenScene, light},
        output::{content::Content, files::Output},
        say,
    },
    memory::Need,
    mesh::{Between, Euler, Flow, MeshError, Sheet},
    npy,
    photoreceptor::{Curve, Response},
    plane::{Plane, Size},
    rig::{self, guard::Warning},
    save::save,
    scene::{Frame, Observation, Scene, part::First},
    study::WithLight,
    unit::{Picos, counted},
};

/// What `mesh step` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    mut_arg("scene", |scene| scene.short('s')),
    after_help = "Example: amacrine mesh step --lambda 10 --tau 1ms --scene clip.mp4 --output H.npy\n\nThe sheet starts settled to the first frame. --rule v2e steps it as v2e does, for comparison."
)]
pub struct Arguments {
    #[command(flatten)]
    constants: Constants,
    /// Time constant C/g, such as 20ns, 0.5us or 1ms
    ///
    /// With 0us the sheet settles at once.
    #[arg(long, value_name = "TIME")]
    tau: Picos,
    #[command(flatten)]
    given: GivenScene,
    /// Conversion of light to the signal, as in a sensor file
    ///
    /// Such as identity, or { log = { white = 255, offset = 1e-5 } }.
    #[arg(long, default_value = "identity", value_parser = response)]
    response: Response,
    /// Course of the signal between two frames
    #[arg(long, value_enum, default_value = "ramp")]
    rule: Rule,
    /// Quantity to write
    #[arg(long, value_enum, default_value = "surround")]
    show: Show,
    /// Largest number of frames
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..))]
    frames: Option<u64>,
    /// Write a .npy of shape (T,H,W), float64
    #[arg(short, long, value_name = "FILE.npy", value_parser = Content::Array)]
    output: Output,
    /// Print JSON in place of text
    #[arg(long)]
    json: bool,
}

#[derive(serde::Serialize)]
struct Json {
    lambda_y: f64,
    lambda_x: f64,
    tau_s: f64,
    size: Size,
    frames: u64,
    /// Of v2e's rule.
    euler_steps: Option<u64>,
}

/// How a sheet is moved on.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Rule {
    /// A straight line, solved exactly
    Ramp,
    /// A jump to the later frame right after the earlier one, solved exactly
    Step,
    /// The Euler steps of v2e, for comparison
    V2e,
}

/// A response as it stands in a sensor file; a name needs no quotes.
fn response(text: &str) -> Result<Response, String> {
    let is_name = text.starts_with(|c: char| c.is_ascii_alphabetic())
        && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '-');
    let read = if is_name {
        Response::parse(&format!("\"{text}\""))
    } else {
        Response::parse(text)
    };
    read.map_err(|fault| match fault.message {
        told if told.contains("identity") => told,
        told => format!("{told}; write identity, or a table such as {{ linear = 255 }}"),
    })
}

/// A sheet that is moved on by one of the rules.
enum Moved {
    Exact(Box<Flow>, Between),
    V2e(Euler),
}

impl Moved {
    fn begin(sheet: Sheet, tau: f64, rule: Rule, signal: &Plane<f64>) -> Result<Self, MeshError> {
        let exact = |between| {
            let flow = Flow::settled(sheet, tau, signal)?;
            Ok(Self::Exact(Box::new(flow), between))
        };
        match rule {
            Rule::Ramp => exact(Between::Ramp),
            Rule::Step => exact(Between::Step),
            Rule::V2e => Ok(Self::V2e(Euler::begin(sheet, tau, signal)?)),
        }
    }

    fn advance(&mut self, signal: &Plane<f64>, seconds: f64) -> Result<(), MeshError> {
        match self {
            Self::Exact(flow, between) => flow.advance(signal, seconds, *between),
            Self::V2e(euler) => euler.advance(signal, seconds),
        }
    }

    fn surround(&self) -> &Plane<f64> {
        match self {
            Self::Exact(flow, _) => flow.surround(),
            Self::V2e(euler) => euler.surround(),
        }
    }
}

/// Planes of numbers that a sheet in time holds: modes, steps, and the signal.
const PLANES: u128 = 14;

/// Runs the verb.
///
/// # Errors
/// When the scene cannot be read or solved for, or the output not be written.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let sheet = arguments.constants.sheet()?;
    let observation = Observation::new();
    let scene = arguments.given.open(&observation)?;
    let size = scene.size();
    let layers = asked(arguments, &*scene);
    let need = budget::of_scene(&*scene);
    check(need.clone(), size, layers.unwrap_or(0))?;
    let mut scene = First::new(scene, arguments.frames.map_or(u64::MAX, u64::from));
    let mut sheet_now: Option<(f64, Moved)> = None;
    let mut written: Vec<f64> = Vec::new();
    let frames = rig::play(&mut scene, |frame| {
        if layers.is_none() {
            check(need.clone(), size, frame.index + 1)?;
        }
        let in_frame = || format!("frame {} of {}", frame.index, arguments.given.scene);
        let signal = signal(arguments.response, &frame).wrap_err_with(in_frame)?;
        let moved = match sheet_now.take() {
            None => Moved::begin(sheet, arguments.tau.seconds(), arguments.rule, &signal),
            Some((before, mut moved)) => moved
                .advance(&signal, frame.seconds - before)
                .map(|()| moved),
        };
        let moved = moved.map_err(miette::Report::new).wrap_err_with(in_frame)?;
        match arguments.show {
            Show::Surround => written.extend(moved.surround()),
            Show::Difference => written.extend(&(&signal - moved.surround())),
        }
        sheet_now = Some((frame.seconds, moved));
        Ok::<_, miette::Report>(ControlFlow::Continue(()))
    })?;
    let shape = [frames as usize, size.height, size.width];
    save(&arguments.output, |out| {
        npy::write(out, &shape, written.iter().copied())
    })?;
    // Steps and signals in volts are what a sheet is tried with.
    if arguments.response.curve != Curve::Identity {
        light::warn(&Warning::of_scene(&observation, arguments.response));
    }
    let euler_steps = match &sheet_now {
        Some((_, Moved::V2e(euler))) => Some(euler.steps()),
        _ => None,
    };
    tell(arguments, (size, frames, euler_steps), &observation)
}

/// What was written.
fn tell(
    arguments: &Arguments,
    (size, frames, euler_steps): (Size, u64, Option<u64>),
    observation: &Observation,
) -> miette::Result<()> {
    if arguments.json {
        let (lambda_y, lambda_x) = arguments.constants.sheet()?.lambdas();
        let json = Json {
            lambda_y,
            lambda_x,
            tau_s: arguments.tau.seconds(),
            size,
            frames,
            euler_steps,
        };
        return say_json(&WithLight::new(&json, observation));
    }
    let steps = euler_steps.map_or(String::new(), |steps| {
        format!(", {}", counted(steps, "Euler step"))
    });
    say(&format!(
        "{}  {} of {size}{steps}\n{}",
        arguments.output.display(),
        counted(frames, "frame"),
        light::line(observation)
    ));
    Ok(())
}

/// How many frames will be written, where that is known.
fn asked(arguments: &Arguments, scene: &dyn Scene) -> Option<u64> {
    let most = arguments.frames.unwrap_or(u64::MAX);
    scene.frames().map(|frames| frames.min(most))
}

/// Refuses more frames than there is room for: they are written all at once.
fn check(scene: Need, size: Size, layers: u64) -> miette::Result<()> {
    let pixels = size.pixels() as u128;
    let need = scene.and("the sheet", PLANES * 8 * pixels).and(
        format!("{layers} frames to write"),
        8 * pixels * u128::from(layers),
    );
    let what = format!("a sheet of {size} over time");
    budget::check(&need, &what, "take fewer --frames or a smaller scene")
}

/// A frame as the photoreceptors give it.
fn signal(response: Response, frame: &Frame) -> miette::Result<Plane<f64>> {
    let mut signal = Plane::zeros(Size::of(&frame.light).shape());
    for (((y, x), light), to) in frame.light.indexed_iter().zip(&mut signal) {
        let value = response.apply(*light);
        *to = value.map_err(|cause| miette!("the pixel at x = {x}, y = {y}: {cause}"))?;
    }
    Ok(signal)
}
