//! `amacrine mesh show`: a sheet in pictures.

use miette::miette;
use ndarray::s;

use super::{constants::Constants, fit::formula, solve};
use crate::{
    cli::{
        input::kernels,
        output::{
            content::Content,
            files::{Named, Output},
        },
        say,
    },
    elementary,
    kernel::Kernel,
    mesh::{Fitting, MeshError, Sheet, Steady, fit},
    picture::{SurroundShow, surround, write_png},
    plane::{Plane, Size},
    unit::counted,
};

/// What `mesh show` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  amacrine mesh show --lambda 3 --output mesh.png\n  amacrine mesh show --kernel csdvs-5 --output fit.png\n\nWith --kernel the sheets are those that fit it best.",
    group = clap::ArgGroup::new("sheet").required(true)
)]
pub struct Arguments {
    /// Space constant in pixels, 0 or more
    ///
    /// Excludes --kernel.
    #[arg(long, value_name = "L", group = "sheet")]
    lambda: Option<f64>,
    /// Space constant down the columns, if it is another [default: --lambda]
    #[arg(long, value_name = "L", requires = "lambda", conflicts_with = "kernel")]
    lambda_y: Option<f64>,
    /// Kernel to fit: a file (.toml or .npy) or the name of a built-in one
    ///
    /// Excludes --lambda.
    #[arg(long, group = "sheet")]
    kernel: Option<Named>,
    /// Largest number of sheets of the fit, 1 to 3, with --kernel
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=3), conflicts_with = "lambda")]
    sheets: u8,
    /// Signal whose voltages are drawn: a picture or .npy (H,W) [default: a spot and an edge]
    #[arg(short, long, value_name = "FILE")]
    input: Option<Named>,
    /// Write the picture to this file
    #[arg(short, long, value_name = "FILE.png", value_parser = Content::Picture)]
    output: Output,
}

/// A sensor of resistors: the pixel's gain, and the sheets with theirs.
struct Shown {
    title: String,
    /// The sum that was fitted.
    formula: Option<String>,
    centre: f64,
    sheets: Vec<(f64, Sheet)>,
    target: Option<Kernel>,
}

/// Points of a curve, less one.
const POINTS: usize = 256;
/// Half the side of a field, and of a landscape, in pixels.
const FIELD: usize = 8;
const LAND: usize = 16;

/// Runs the verb.
///
/// # Errors
/// When an input cannot be read or solved for, or the picture not be written.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let shown = Shown::new(arguments)?;
    let lights = if let Some(path) = &arguments.input {
        vec![("the input", solve::read(path)?)]
    } else {
        let side = 2 * LAND + 1;
        let mut lights = vec![("a spot", spot(side)), ("an edge", edge(side))];
        if !shown.turns() {
            lights.push(("an edge along a row", edge(side).reversed_axes()));
        }
        lights
    };
    let mut reliefs = Vec::new();
    for (name, light) in &lights {
        let (drive, surround) = shown.answer(light)?;
        reliefs.push((format!("{name}: {}", shown.surround()), surround));
        reliefs.push((format!("{name}: drive"), drive));
    }
    let show = SurroundShow {
        title: shown.title.clone(),
        fields: shown.fields()?,
        responses: shown.responses(),
        reliefs,
    };
    let captions = show.fields.iter().map(|(caption, _)| caption);
    let texts = [&show.title].into_iter().chain(captions);
    arguments.output.warn_of_letters(texts.map(String::as_str));
    let page = surround(&show);
    write_png(&arguments.output, &page)?;
    let formula = shown.formula.map_or(String::new(), |it| format!("{it}\n"));
    say(&format!(
        "{}  {}\n{formula}",
        arguments.output.display(),
        shown.title
    ));
    Ok(())
}

impl Shown {
    fn new(arguments: &Arguments) -> miette::Result<Self> {
        let Some(name) = &arguments.kernel else {
            let lambda = arguments.lambda.unwrap_or(1.0);
            let lambda_y = arguments.lambda_y;
            let sheet = Constants { lambda, lambda_y }.sheet()?;
            let (down, across) = sheet.lambdas();
            return Ok(Self {
                title: if down == across {
                    format!("P - H, space constant {across} pixels")
                } else {
                    format!("P - H, space constants {across} across and {down} down")
                },
                formula: None,
                centre: 1.0,
                sheets: vec![(-1.0, sheet)],
                target: None,
            });
        };
        let (found, _) = kernels::read(name)?;
        let [kernel] = &found[..] else {
            return Err(miette!(
                help = "give an array of shape (k,k)",
                "{name} holds {} kernels",
                found.len()
            ));
        };
        let how = Fitting {
            sheets: arguments.sheets.into(),
            anisotropic: false,
            ridge: 1e-4,
        };
        let fitted = fit(kernel, how)?;
        let sheets = fitted.sheets.iter().map(|sheet| {
            let constants = Sheet::anisotropic(sheet.lambda_y, sheet.lambda_x)?;
            Ok((sheet.gain, constants))
        });
        Ok(Self {
            title: format!(
                "{name} by {}: error {:.3}, of which {:.3} no equal resistors can have",
                counted(fitted.sheets.len(), "sheet"),
                fitted.error,
                fitted.turned
            ),
            formula: Some(formula(&fitted)),
            centre: fitted.centre,
            sheets: sheets.collect::<Result<_, MeshError>>()?,
            target: Some(kernel.clone()),
        })
    }

    /// Whether rows and columns are alike.
    fn turns(&self) -> bool {
        self.sheets.iter().all(|(_, sheet)| {
            let (down, across) = sheet.lambdas();
            down == across
        })
    }

    /// What is shown of the sheets.
    const fn surround(&self) -> &'static str {
        match self.sheets.len() {
            0 | 1 => "voltages H",
            _ => "all sheets, by their gains",
        }
    }

    /// What the sensor makes of light: its drive, and the voltages on its sheet; of several, their
    /// sum with the gains.
    fn answer(&self, light: &Plane<f64>) -> miette::Result<(Plane<f64>, Plane<f64>)> {
        let solved = self.sheets.iter().map(|(gain, sheet)| {
            let surround = Steady::new(*sheet, Size::of(light))?.solve(light)?;
            Ok((*gain, surround))
        });
        let solved = solved.collect::<Result<Vec<_>, MeshError>>()?;
        let mut sum = Plane::zeros(light.dim());
        for (gain, surround) in &solved {
            sum.scaled_add(*gain, surround);
        }
        let drive = light * self.centre + &sum;
        let shown = <[_; 1]>::try_from(solved).map_or(sum, |[(_, alone)]| alone);
        Ok((drive, shown))
    }

    /// The field of the sheets, that of the sensor, and the one that was wanted.
    fn fields(&self) -> miette::Result<Vec<(String, Plane<f64>)>> {
        let wide = 32 * FIELD + 1;
        let (drive, surround) = self.answer(&spot(wide))?;
        let (from, to) = (wide / 2 - FIELD, wide / 2 + FIELD + 1);
        let window = |plane: &Plane<f64>| plane.slice(s![from..to, from..to]).to_owned();
        let mut fields = vec![
            (format!("a point: {}", self.surround()), window(&surround)),
            ("field of the sensor".to_owned(), window(&drive)),
        ];
        if let Some(target) = &self.target {
            let (ry, rx) = target.reach();
            let reach = FIELD.max(ry).max(rx);
            let mut field = Plane::zeros((2 * reach + 1, 2 * reach + 1));
            for ((y, x), weight) in target.weights().indexed_iter() {
                field[[y + reach - ry, x + reach - rx]] = *weight;
            }
            fields.push(("the kernel itself".to_owned(), field));
        }
        Ok(fields)
    }

    /// Along the rows and along the diagonal, down the columns where those differ from rows, the
    /// kernel's beside them.
    fn responses(&self) -> Vec<(String, Vec<f64>)> {
        let curve = |gain: &dyn Fn(f64, f64) -> f64, (down, across): (f64, f64)| -> Vec<f64> {
            (0..=POINTS)
                .map(|k| {
                    let f = 0.5 * k as f64 / POINTS as f64;
                    gain(down * f, across * f)
                })
                .collect()
        };
        let (row, diagonal, column) = ((0.0, 1.0), (1.0, 1.0), (1.0, 0.0));
        let own = |fy: f64, fx: f64| {
            let sheets = self
                .sheets
                .iter()
                .map(|(gain, sheet)| gain * sheet.gain(fy, fx));
            self.centre + sheets.sum::<f64>()
        };
        let mut curves = vec![
            ("sensor, along a row".to_owned(), curve(&own, row)),
            ("sensor, on a diagonal".to_owned(), curve(&own, diagonal)),
        ];
        if !self.turns() {
            curves.push(("sensor, down a column".to_owned(), curve(&own, column)));
        }
        if let Some(target) = &self.target {
            let wanted = |fy: f64, fx: f64| {
                let (ry, rx) = target.reach();
                let weights = target.weights().indexed_iter();
                weights
                    .map(|((y, x), w)| {
                        let turns = fy * (y as f64 - ry as f64) + fx * (x as f64 - rx as f64);
                        w * elementary::cos(std::f64::consts::TAU * turns)
                    })
                    .sum()
            };
            curves.push(("kernel, along a row".to_owned(), curve(&wanted, row)));
            curves.push(("kernel, on a diagonal".to_owned(), curve(&wanted, diagonal)));
        }
        curves
    }
}

/// A point of light in the middle of the dark.
fn spot(side: usize) -> Plane<f64> {
    let mut plane = Plane::zeros((side, side));
    plane[[side / 2, side / 2]] = 1.0;
    plane
}

/// Dark on the left, light on the right.
fn edge(side: usize) -> Plane<f64> {
    Plane::from_shape_fn((side, side), |(_, x)| if x > side / 2 { 1.0 } else { 0.0 })
}
