//! `--kernel`, `--threshold`, `--sigma` and `--rate`: a sensor file with other receptive fields,
//! thresholds, or with thresholds for a rate of events.

use miette::WrapErr;

use super::{event_rate::event_rate, heading};
use crate::{
    cli::{input::kernels, output::files::Named},
    kernel::Kernel,
    number::Format,
    reference::{Description, Threshold},
    rig::guard::Warning,
    scene::Reopen,
    study::rate::{self, ThresholdFactor},
};

/// What is other than in the sensor file.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Changes {
    /// Kernels in place of the file's, one for each kind of cell
    ///
    /// Files (.toml, or .npy of shape (k,k), (K,k,k) or (K,1,k,k)) or names of built-in kernels,
    /// separated by commas.
    #[arg(long, value_delimiter = ',', value_name = "KERNELS", help_heading = heading::SENSOR)]
    kernel: Vec<Named>,
    /// Threshold of all kinds in place of the file's: one for both signs, or ON,OFF
    ///
    /// (`compile` and other verbs take one threshold for each kind instead.) The spread from cell
    /// to cell (`sigma`) stays as in the file, in the threshold's unit; --sigma sets another.
    /// Excludes --rate.
    #[arg(long, value_name = "ON[,OFF]", conflicts_with = "rate", value_parser = on_and_off, help_heading = heading::SENSOR)]
    threshold: Option<[f64; 2]>,
    /// Standard deviation of thresholds from cell to cell, in place of the file's
    ///
    /// In the threshold's unit. With 0 all cells are alike. Excludes --rate.
    #[arg(long, value_name = "SIGMA", conflicts_with = "rate", help_heading = heading::SENSOR)]
    sigma: Option<f64>,
    /// Events per pixel and second to reach, all kinds together
    ///
    /// The program multiplies all thresholds of the file, and their spreads, by one factor. It
    /// prints the rate reached, mostly within 3 %. Excludes --threshold and --sigma.
    #[arg(long, value_name = "EVENTS", value_parser = event_rate, help_heading = heading::SENSOR)]
    rate: Option<f64>,
}

impl Changes {
    /// The sensor with the kernels, thresholds and spreads that are asked for.
    ///
    /// # Errors
    /// When a kernel cannot be read, or a threshold is not above 0.
    pub(in crate::cli) fn set(&self, mut sensor: Description) -> miette::Result<Description> {
        if !self.kernel.is_empty() {
            sensor = sensor.with_kernels(self.kernels()?, &named(&self.kernel))?;
        }
        Ok(sensor.with_thresholds(self.threshold, self.sigma)?)
    }

    /// The sensor with thresholds for the rate that is asked for, and which were found: of what
    /// runs, with all that is set and without what is left out.
    ///
    /// # Errors
    /// When no threshold gives the rate.
    pub(in crate::cli) fn rated(
        &self,
        sensor: Description,
        (seed, format): (u64, Format),
        open: &Reopen<'_>,
    ) -> miette::Result<(Description, Option<Found>)> {
        let Some(asked) = self.rate else {
            return Ok((sensor, None));
        };
        let rated = rate::factor(&sensor, asked, seed, open).wrap_err("--rate")?;
        let sensor = rate::times(&sensor, rated.factor);
        let all = sensor.channels.iter().flat_map(|kind| &kind.thresholds);
        let found = Found {
            asked,
            rated,
            format,
            thresholds: all.copied().collect(),
        };
        Ok((sensor, Some(found)))
    }

    /// How `--threshold` was read, and what it leaves of the file, where that matters: of the sensor as
    /// it is asked for.
    pub(in crate::cli) fn line(&self, sensor: &Description) -> Option<String> {
        let signs = self.threshold.filter(|[on, off]| on != off);
        let signs = signs
            .filter(|_| sensor.channels.len() > 1)
            .map(|[on, off]| {
                format!(
                    "threshold {on} for ON and {off} for OFF, of all {} kinds\n",
                    sensor.channels.len()
                )
            });
        match (signs, self.sigma_line(sensor)) {
            (None, None) => None,
            (signs, sigma) => Some([signs, sigma].into_iter().flatten().collect()),
        }
    }

    fn sigma_line(&self, sensor: &Description) -> Option<String> {
        let [on, off] = self.threshold.filter(|_| self.sigma.is_none())?;
        let all = sensor.channels.iter().flat_map(|kind| &kind.thresholds);
        let sigma = all.map(|own| own.sigma).fold(0.0, f64::max);
        let share = 100.0 * sigma / on.min(off);
        let share = if share < 1e6 {
            format!("{share:.0}")
        } else {
            format!("{share:.1e}")
        };
        (sigma > 0.0).then(|| {
            format!(
                "sigma    {sigma}, the file's, {share} % of the threshold: --sigma says another, and --rate scales it with the threshold\n"
            )
        })
    }

    /// The kernels of all files, one after the other, and what each is called.
    fn kernels(&self) -> miette::Result<Vec<(String, Kernel)>> {
        let mut all = Vec::new();
        for file in &self.kernel {
            let own = kernels::read(file)?.0;
            all.extend(kernels::names(file, own.len()).into_iter().zip(own));
        }
        kernels::check_number(all.len())?;
        Ok(all)
    }
}

/// The thresholds for a rate.
pub struct Found {
    asked: f64,
    rated: ThresholdFactor,
    /// What the sensor runs in; the thresholds are found in f64.
    format: Format,
    thresholds: Vec<Threshold>,
}

impl Found {
    pub fn line(&self) -> String {
        let each = self.thresholds.iter().map(|own| {
            if own.on == own.off {
                format!("{:.5}", own.on)
            } else {
                format!("{:.5} ON and {:.5} OFF", own.on, own.off)
            }
        });
        let thresholds: Vec<String> = each.collect();
        let spreads = self.thresholds.iter().any(|own| own.sigma > 0.0);
        let sigma = if spreads { " (sigma too)" } else { "" };
        let other = match self.format {
            Format::F64 => String::new(),
            format => format!(" in f64; {format} may give another"),
        };
        let again = self.options().map_or(String::new(), |options| {
            format!("         the same without a search: {options}\n")
        });
        format!(
            "rate     {} events per pixel and second asked for: threshold {}, the file's times {:.5}{sigma}, gives {:.4}{other}\n{again}",
            self.asked,
            thresholds.join(", "),
            self.rated.factor,
            self.rated.rate
        )
    }

    /// Where no threshold gives what was asked for.
    pub fn warning(&self, sensor: &str) -> Option<Warning> {
        Warning::rate(sensor, self.asked, self.rated.rate)
    }

    /// The options that give these very thresholds, where all kinds have the same.
    fn options(&self) -> Option<String> {
        let (first, others) = self.thresholds.split_first()?;
        let Threshold { on, off, sigma } = first;
        let spread = if *sigma > 0.0 {
            format!(" --sigma {sigma}")
        } else {
            String::new()
        };
        let same = others.iter().all(|own| own == first);
        same.then(|| format!("--threshold {on},{off}{spread}"))
    }

    pub fn json(&self) -> serde_json::Value {
        let each = |of: fn(&Threshold) -> f64| self.thresholds.iter().map(of).collect::<Vec<f64>>();
        serde_json::json!({
            "asked": self.asked,
            "thresholds": each(|own| own.on),
            "off": each(|own| own.off),
            "sigma": each(|own| own.sigma),
            "factor": self.rated.factor,
            "in_f64": self.rated.rate,
            "options": self.options(),
        })
    }
}

/// A threshold for both, or one for ON and one for OFF.
fn on_and_off(text: &str) -> Result<[f64; 2], String> {
    let number = |text: &str| text.trim().parse::<f64>();
    let (on, off) = text.split_once(',').unwrap_or((text, text));
    let both = number(on).and_then(|on| Ok([on, number(off)?]));
    both.map_err(|_| "give a number, or two for ON,OFF, such as 0.3,0.2".to_owned())
}

/// As they were given.
fn named(kernels: &[Named]) -> String {
    let names: Vec<&str> = kernels.iter().map(|name| &**name).collect();
    names.join(",")
}
