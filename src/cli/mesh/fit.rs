//! `amacrine mesh fit`: what a mesh makes of kernels.

use std::fmt::Write;

use miette::WrapErr;

use super::output::say_json;
use crate::{
    cli::{input::kernels, output::files::Named, say},
    kernel::Kernel,
    mesh::{Fit, Fitting, fit},
};

/// What `mesh fit` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example: amacrine mesh fit dvs csdvs-5 laplacian dog sobel-x --sheets 2\n\nParts of a kernel that are out of reach: odd (no resistors have it), mirrored (no sheet has it), turned (no sheet of equal resistors has it). The error is that of the whole plane, not of the kernel's window. The gain multiplies noise and offsets of the parts."
)]
pub struct Arguments {
    /// Kernels: files (.toml or .npy) or names of built-in ones
    #[arg(required = true)]
    kernels: Vec<Named>,
    /// Largest number of sheets, 1 to 3
    ///
    /// Each number of sheets up to it has a row, as long as another sheet helps.
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=3))]
    sheets: u8,
    /// Let the resistors down the columns differ from those across
    #[arg(long)]
    anisotropic: bool,
    /// Penalty that holds the gains down
    ///
    /// The fit minimises the squared relative error plus this number times the sum of the squared
    /// gains, with gains relative to the norm of the kernel. Where two sheets would become one,
    /// the fit takes the least larger power of ten that keeps them apart, and prints it; if none does,
    /// it has one sheet less.
    #[arg(long, default_value_t = 1e-4)]
    ridge: f64,
    /// Print JSON in place of text
    #[arg(long)]
    json: bool,
}

#[derive(serde::Serialize)]
struct Row {
    kernel: String,
    #[serde(flatten)]
    fit: Fit,
}

/// Runs the verb.
///
/// # Errors
/// When a kernel cannot be read or fitted.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    if !(arguments.ridge >= 0.0 && arguments.ridge.is_finite()) {
        return Err(miette::miette!(
            help = "give 0 or a small positive number, such as 1e-4",
            "--ridge is {}",
            arguments.ridge
        ));
    }
    let mut rows = Vec::new();
    for name in &arguments.kernels {
        let (found, _) = kernels::read(name)?;
        let many = found.len() > 1;
        for (i, kernel) in found.iter().enumerate() {
            let shown = if many {
                format!("{name}[{i}]")
            } else {
                name.to_string()
            };
            for sheets in 1..=usize::from(arguments.sheets) {
                let fit = fitted(arguments, kernel, sheets).wrap_err_with(|| shown.clone())?;
                // Where fewer are as good, more of them change nothing.
                let enough = fit.sheets.len() < sheets;
                if !enough || sheets == 1 {
                    rows.push(Row {
                        kernel: shown.clone(),
                        fit,
                    });
                }
                if enough {
                    break;
                }
            }
        }
    }
    if arguments.json {
        return say_json(&rows);
    }
    say(&table(&rows, arguments.ridge));
    Ok(())
}

fn fitted(arguments: &Arguments, kernel: &Kernel, sheets: usize) -> miette::Result<Fit> {
    let how = Fitting {
        sheets,
        anisotropic: arguments.anisotropic,
        ridge: arguments.ridge,
    };
    Ok(fit(kernel, how)?)
}

fn table(rows: &[Row], ridge: f64) -> String {
    let mut text = format!(
        "{:<20} {:>6} {:>8} {:>6}  {:>6} {:>6} {:>6} {:>6} {:>7}  {}\n",
        "", "odd", "mirrored", "turned", "sheets", "error", "gain", "tail", "uniform", "the sensor"
    );
    let mut before = "";
    for Row { kernel, fit } in rows {
        // What cannot be reached stands first, once for each kernel.
        let same = before == kernel;
        before = kernel;
        let _ = if same {
            write!(text, "{:<20} {:>6} {:>8} {:>6}", "", "", "", "")
        } else {
            write!(
                text,
                "{kernel:<20} {:>6.3} {:>8.3} {:>6.3}",
                fit.odd, fit.mirrored, fit.turned
            )
        };
        let _ = writeln!(
            text,
            "  {:>6} {:>6.3} {:>6.2} {:>6.3} {:>7.3}  {}{}",
            fit.sheets.len(),
            fit.error,
            fit.gain,
            fit.tail,
            fit.uniform,
            formula(fit),
            raised(fit, ridge)
        );
    }
    text + "\nodd, mirrored, turned: parts of the kernel that no resistors, no sheet, no sheet of equal resistors can have.\n\
        error: what is not reached, on the whole plane, over the kernel. gain: sum of the gains in size over the kernel's norm.\n\
        tail: what of the field lies outside the kernel's window, over the field. uniform: the answer to uniform light.\n"
}

/// That a fit took another ridge than was asked for.
fn raised(fit: &Fit, asked: f64) -> String {
    if fit.ridge == asked {
        return String::new();
    }
    format!(
        ", with a ridge of {:e}: with less, two sheets become one with gains that grow for ever",
        fit.ridge
    )
}

/// `1.15 P - 1.45 H(1.89)`.
pub(super) fn formula(fit: &Fit) -> String {
    if fit.gain == 0.0 {
        return "nothing: it is all unreachable".into();
    }
    let mut text = format!("{:.3} P", fit.centre);
    if fit.sheets.is_empty() {
        text.push_str(": a pixel alone, no sheet");
    }
    for sheet in &fit.sheets {
        let sign = if sheet.gain < 0.0 { '-' } else { '+' };
        let _ = write!(
            text,
            " {sign} {:.3} H({:.2}",
            sheet.gain.abs(),
            sheet.lambda_y
        );
        if sheet.lambda_y != sheet.lambda_x {
            let _ = write!(text, " down, {:.2} across", sheet.lambda_x);
        }
        text.push(')');
    }
    text
}
