//! `amacrine voxels`: an event file as the arrays that networks take.

mod arguments;
mod extent;
mod maker;
mod plan;

use serde_json::json;

pub use self::arguments::Arguments;
use self::{arguments::Form, extent::Extent, maker::Maker, plan::Plan};
use super::{arguments::recording, output::progress::Progress};
use crate::{
    event::{
        Event,
        file::Reader,
        tensor::{Container, Layers, TensorFile},
    },
    unit::{counted, exact_seconds},
};

/// Runs the verb.
///
/// # Errors
/// When the file cannot be read, the settings are none, or the array cannot be written.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    arguments.check_options()?;
    let container = match arguments.output.ending() {
        "npz" => Container::Npz,
        "h5" | "hdf5" => Container::Hdf5,
        _ => Container::Npy,
    };
    // Once for the size, the kinds and the end, where the file does not say them.
    let about = Extent::of(arguments)?;
    let plan = Plan::new(arguments, &about)?;
    plan.check_memory(arguments, &about)?;
    plan.check_disk(arguments, &about, container)?;
    let layers = Layers {
        name: arguments.form().name(),
        shape: plan.shape(&about),
        precision: arguments.precision(),
        kinds: about.names.clone(),
    };
    let mut file = TensorFile::create(&arguments.output, container, layers)?;
    let mut maker = Maker::new(&plan, &about, arguments.precision())?;
    let mut reader = Reader::open(&arguments.file, &arguments.recording.opening(None))?;
    let progress = Progress::new(layer_name(arguments.form()), Some(plan.count(&about)));
    let mut block: Vec<Event> = Vec::new();
    let mut write = |layer: &[f32]| {
        progress.tick();
        file.push(layer).map_err(miette::Report::from)
    };
    while reader.next_block(&mut block)? {
        maker.pass(&block, &mut write)?;
    }
    maker.finish(about.end, &mut write)?;
    let count = file.finish()?;
    progress.finish();
    warn_between(arguments, maker.between());
    let text = if arguments.json {
        json(arguments, &about, &plan, &maker, count)
    } else {
        text(arguments, &about, &plan, &maker, count)
    };
    super::say(&text);
    Ok(())
}

/// What a layer is, in the plural.
const fn layer_name(form: Form) -> &'static str {
    match form {
        Form::Voxels => "windows",
        Form::Surfaces => "times",
        Form::Frames => "frames",
    }
}

fn warn_between(arguments: &Arguments, between: u64) {
    if between == 0 {
        return;
    }
    let window = arguments.window.unwrap_or_default();
    super::complain(&format!(
        "warning: {} lie{} between windows, in none of them: --every {} is longer than --window {window}\n",
        counted(between, "event"),
        if between == 1 { "s" } else { "" },
        arguments.every.unwrap_or(window),
    ));
}

fn json(arguments: &Arguments, about: &Extent, plan: &Plan, maker: &Maker, count: u64) -> String {
    let mut shape = vec![count];
    shape.extend(plan.shape(about).iter().map(|n| *n as u64));
    let mut said = json!({
        "file": arguments.file,
        "output": arguments.output,
        "as": arguments.form().name(),
        "shape": shape,
        "dtype": if arguments.half { "float16" } else { "float32" },
        "kinds": about.names,
        "size_known": about.size_known,
    });
    match arguments.form() {
        Form::Voxels => {
            said["from_us"] = json!(plan.first());
            said["between_windows"] = json!(maker.between());
        }
        Form::Surfaces => said["first_us"] = json!(plan.first()),
        Form::Frames => said["events_left_over"] = json!(maker.left_over().unwrap_or(0)),
    }
    format!("{said}\n")
}

fn text(arguments: &Arguments, about: &Extent, plan: &Plan, maker: &Maker, count: u64) -> String {
    let shape = plan.shape(about);
    let shape: Vec<String> = shape.iter().map(usize::to_string).collect();
    let form = arguments.form();
    let bins = if form == Form::Voxels { "bins, " } else { "" };
    let first = plan.first().unwrap_or_default();
    let more = match (form, maker.left_over()) {
        (Form::Voxels, _) if first != 0 => {
            format!("; the first window begins at {} s", exact_seconds(first))
        }
        (Form::Surfaces, _) => format!("; the first is of {} s", exact_seconds(first)),
        (Form::Frames, Some(events)) => {
            format!("; the last has {}", counted(events as u64, "event"))
        }
        _ => String::new(),
    };
    format!(
        "wrote    {}: ({count}, {}): {}, kinds, sides, {bins}rows, columns{more}{}\n",
        arguments.output.display(),
        shape.join(", "),
        layer_name(form),
        recording::guessed(about.size_known)
    )
}
