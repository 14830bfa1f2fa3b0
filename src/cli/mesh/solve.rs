//! `amacrine mesh solve`: the settled surround of one signal.

use std::path::Path;

use miette::{WrapErr, miette};

use super::{
    constants::Constants,
    output::{Show, extremes, say_json, write},
    parts::{Chip, Parts},
};
use crate::{
    cli::{
        arguments::budget,
        input::npy,
        output::{
            content::Content,
            files::{Named, Output},
        },
        say,
    },
    memory::Need,
    mesh::{MeshError, Steady},
    plane::{Plane, Size},
    scene::{SceneError, open},
    unit::fixed,
};

/// What `mesh solve` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  amacrine mesh solve --lambda 10 --input P.npy --output H.npy\n  amacrine mesh solve --lambda 3 --input photo.png --show difference --output edges.png\n  amacrine mesh solve --lambda 3 --input photo.png --transverse-mismatch 10% --seed 7 --output chip-7.png"
)]
pub struct Arguments {
    #[command(flatten)]
    constants: Constants,
    #[command(flatten)]
    parts: Parts,
    /// Signal P: a .npy of shape (H,W), or a picture
    #[arg(short, long, value_name = "FILE")]
    input: Named,
    /// Write the result to this file
    ///
    /// A .npy is float64 and has the shape of P; a .png is gray, from the least value to the
    /// largest.
    #[arg(short, long, value_name = "FILE", value_parser = Content::Plane)]
    output: Output,
    /// Quantity to write
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
    /// Where the parts are not equal.
    #[serde(skip_serializing_if = "Option::is_none")]
    chip: Option<Chip>,
}

/// Planes of numbers that are held at once.
const PLANES: u128 = 5;

/// Of them and of those that a network of unequal parts holds while it settles.
const PLANES_OF_UNEQUAL: u128 = 32;

/// Runs the verb.
///
/// # Errors
/// When the signal cannot be read or solved for, or the output not be written.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let (sheet, parts) = (arguments.constants.sheet()?, &arguments.parts);
    if parts.has_idle_seed() {
        return Err(miette!(
            help = "give --lateral-mismatch or --transverse-mismatch, or leave --seed out",
            "--seed draws the parts of a chip, and all parts are equal"
        ));
    }
    let signal = read(&arguments.input)?;
    let size = Size::of(&signal);
    // The signal, the surround, the settled sheet on its way to it, and a picture.
    let planes = if parts.are_equal() {
        PLANES
    } else {
        PLANES_OF_UNEQUAL
    };
    let need = Need::new().and("planes of the sheet", planes * 8 * size.pixels() as u128);
    let help = "take a smaller signal";
    budget::check(&need, &format!("a sheet of {size}"), help)?;
    let settle = || {
        let equal = Steady::new(sheet, size)?.solve(&signal)?;
        if parts.are_equal() {
            return Ok((equal, None));
        }
        let (surround, chip) = parts.settled(sheet, &signal, &equal)?;
        Ok((surround, Some(chip)))
    };
    let (surround, chip) = settle()
        .map_err(|error: MeshError| miette::Report::new(error))
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
            chip,
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
    if let Some(chip) = chip {
        let differences = [chip.differs_rms, chip.differs_most];
        let [rms, most] = differences.map(|value| brief(value, chip.differs_most));
        say(&format!(
            "its surround differs from that of equal resistors by {rms} (root mean square), at most {most}\n"
        ));
    }
    Ok(())
}

/// A value of a plane whose largest in size is `scale`: five digits of that.
fn brief(value: f64, scale: f64) -> String {
    let (mut decimals, mut step) = (0_usize, scale);
    while step > 0.0 && step < 1e4 && decimals < 300 {
        step *= 10.0;
        decimals += 1;
    }
    fixed(value, decimals)
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
