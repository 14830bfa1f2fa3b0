//! `amacrine mesh solve`: the settled surround of one signal.

use std::path::Path;

use miette::{WrapErr, miette};

use super::{
    constants::Constants,
    output::{Show, extremes, say_json, write},
};
use crate::{
    cli::{
        budget,
        content::Content,
        files::{Named, Output},
        npy, say,
    },
    memory::Need,
    mesh::Steady,
    plane::{Plane, Size},
    scene::{SceneError, open},
};

/// What `mesh solve` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  amacrine mesh solve --lambda 10 --input P.npy --output H.npy\n  amacrine mesh solve --lambda 3 --input photo.png --show difference --output edges.png"
)]
pub struct Arguments {
    #[command(flatten)]
    constants: Constants,
    /// The signal P: a .npy of shape (H,W), or a picture
    #[arg(short, long, value_name = "FILE")]
    input: Named,
    /// Where to: .npy (float64, of P's shape), or .png (gray from least to most)
    #[arg(short, long, value_name = "FILE", value_parser = Content::Plane)]
    output: Output,
    /// What to write
    #[arg(long, value_enum, default_value = "surround")]
    show: Show,
    /// Print JSON in place of text
    #[arg(long)]
    json: bool,
}

#[derive(serde::Serialize)]
struct Json {
    lambda_y: f64,
    lambda_x: f64,
    size: Size,
    mean: f64,
    least: f64,
    most: f64,
}

/// Planes of numbers that are held at once.
const PLANES: u128 = 5;

/// Runs the verb.
///
/// # Errors
/// When the signal cannot be read or solved for, or the output not be written.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let sheet = arguments.constants.sheet()?;
    let signal = read(&arguments.input)?;
    let size = Size::of(&signal);
    // The signal, the surround, the settled sheet on its way to it, and a picture.
    let need = Need::new().and("planes of the sheet", PLANES * 8 * size.pixels() as u128);
    let help = "take a smaller signal";
    budget::check(&need, &format!("a sheet of {size}"), help)?;
    let surround = Steady::new(sheet, size)
        .and_then(|mut steady| steady.solve(&signal))
        .map_err(miette::Report::new)
        .wrap_err_with(|| format!("cannot solve {}", arguments.input))?;
    let shown = match arguments.show {
        Show::Surround => surround,
        Show::Difference => signal - surround,
    };
    write(&arguments.output, &shown)?;
    let (least, most) = extremes(&shown);
    let (lambda_y, lambda_x) = sheet.lambdas();
    let mean = shown.sum() / shown.len() as f64;
    if arguments.json {
        let json = Json {
            lambda_y,
            lambda_x,
            size,
            mean,
            least,
            most,
        };
        return say_json(&json);
    }
    let scale = least.abs().max(most.abs());
    let [mean, least, most] = [mean, least, most].map(|value| brief(value, scale));
    let grays = if arguments.output.ending() == "png" {
        format!("; black is {least}, white {most}")
    } else {
        String::new()
    };
    say(&format!(
        "{}  {size}, mean {mean}, from {least} to {most}{grays}\n",
        arguments.output.display()
    ));
    Ok(())
}

/// A value of a plane whose largest in size is `scale`: five digits of that.
fn brief(value: f64, scale: f64) -> String {
    let (mut decimals, mut step) = (0_usize, scale);
    while step > 0.0 && step < 1e4 && decimals < 300 {
        step *= 10.0;
        decimals += 1;
    }
    let text = format!("{value:.decimals$}");
    // No rounding leaves minus zero.
    match text.strip_prefix('-') {
        Some(plain) if !plain.contains(|digit| ('1'..='9').contains(&digit)) => plain.to_owned(),
        _ => text,
    }
}

/// A plane of numbers, or the light of one picture.
pub(super) fn read(name: &str) -> miette::Result<Plane<f64>> {
    let path = Path::new(name);
    if path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("npy"))
    {
        return npy::read(path);
    }
    let mut scene = open(name, &budget::opening(None)).map_err(|error| match error {
        SceneError::Unreadable { path, cause } => miette!(
            help = "give a picture or a .npy of shape (H,W) that exists and can be read, or `pattern:NAME`, whose first frame is taken",
            "{}: {cause}",
            path.display()
        ),
        other => other.into(),
    })?;
    let frame = scene.next_frame()?;
    let frame = frame.ok_or_else(|| miette!("{name} holds no picture"))?;
    Ok(frame.light.into_plane())
}
