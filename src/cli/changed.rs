//! `--kernel`, `--threshold` and `--rate`: a sensor file with other receptive fields, thresholds,
//! or with thresholds for a rate of events.

use miette::{WrapErr, miette};

use super::{event_rate::event_rate, files::Named, kernels};
use crate::{
    kernel::Kernel,
    number::Format,
    reference::{Channel, Description},
    rig::guard::Warning,
    scene::{Scene, SceneError},
    study::rate::{self, ThresholdFactor},
};

/// What is other than in the sensor file.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Changes {
    /// These kernels in place of the file's, a kind of cell for each: files (.toml, .npy of shape
    /// (k,k), (K,k,k) or (K,1,k,k)) or built-in ones
    #[arg(long, value_delimiter = ',', value_name = "KERNELS")]
    kernel: Vec<Named>,
    /// This threshold in place of the file's, for ON and OFF
    #[arg(long, value_name = "THRESHOLD", conflicts_with = "rate")]
    threshold: Option<f64>,
    /// Thresholds for so many events per pixel and second, all kinds together: the file's, all
    /// times the same number
    #[arg(long, value_name = "EVENTS", value_parser = event_rate)]
    rate: Option<f64>,
}

impl Changes {
    /// The sensor as it is asked for, and which thresholds were found.
    ///
    /// # Errors
    /// When a kernel cannot be read, a threshold is not above 0, or no threshold gives the rate.
    pub(super) fn of(
        &self,
        mut sensor: Description,
        (seed, format): (u64, Format),
        open: &dyn Fn() -> Result<Box<dyn Scene>, SceneError>,
    ) -> miette::Result<(Description, Option<Found>)> {
        if !self.kernel.is_empty() {
            let kernels = self.kernels()?;
            let Some(first) = sensor.channels.first().cloned() else {
                return Ok((sensor, None));
            };
            if first.surrounds.is_some() || first.thresholds.len() != 1 {
                return Err(miette!(
                    help =
                        "give a sensor file whose first kind has a kernel of its own, such as rgc",
                    "--kernel {}: the first kind of the sensor has a mesh or a pattern in place of a kernel",
                    named(&self.kernel)
                ));
            }
            let several = kernels.len() > 1;
            let kinds = kernels.into_iter().map(|(name, kernel)| Channel {
                name: several.then_some(name),
                kernels: vec![kernel],
                ..first.clone()
            });
            sensor.channels = kinds.collect();
        }
        if let Some(threshold) = self.threshold {
            if !(threshold > 0.0 && threshold.is_finite()) {
                return Err(miette!(
                    help = "give a finite number above 0, in units of the response",
                    "--threshold {threshold} is no threshold"
                ));
            }
            for own in sensor
                .channels
                .iter_mut()
                .flat_map(|kind| &mut kind.thresholds)
            {
                (own.on, own.off) = (threshold, threshold);
            }
        }
        let Some(asked) = self.rate else {
            return Ok((sensor, None));
        };
        let rated = rate::factor(&sensor, asked, seed, open).wrap_err("--rate")?;
        let sensor = rate::times(&sensor, rated.factor);
        let all = || sensor.channels.iter().flat_map(|kind| &kind.thresholds);
        let found = Found {
            asked,
            rated,
            format,
            thresholds: all().map(|own| own.on).collect(),
            spreads: all().any(|own| own.sigma > 0.0),
        };
        Ok((sensor, Some(found)))
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
    /// Those of ON events.
    thresholds: Vec<f64>,
    /// Whether any of them differs from cell to cell.
    spreads: bool,
}

impl Found {
    pub fn line(&self) -> String {
        let thresholds = self.thresholds.iter().map(|own| format!("{own:.5}"));
        let thresholds: Vec<String> = thresholds.collect();
        let sigma = if self.spreads { " (sigma too)" } else { "" };
        let other = match self.format {
            Format::F64 => String::new(),
            format => format!(" in f64; {format} may give another"),
        };
        format!(
            "rate     {} events per pixel and second asked for: threshold {}, the file's times {:.5}{sigma}, gives {:.4}{other}\n",
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

    pub fn json(&self) -> serde_json::Value {
        serde_json::json!({
            "asked": self.asked,
            "thresholds": self.thresholds,
            "factor": self.rated.factor,
            "in_f64": self.rated.rate,
        })
    }
}

/// As they were given.
fn named(kernels: &[Named]) -> String {
    let names: Vec<&str> = kernels.iter().map(|name| &**name).collect();
    names.join(",")
}
