//! `--fidelity auto` of `amacrine run`, and how plans are made and told.

use std::fmt::Write as _;

use miette::IntoDiagnostic;
use serde_json::Value;

use crate::{
    event::readout::Readout,
    number::Format,
    reference::Description,
    scene::{OpenOptions, open},
    study::plan::{self, Choice, Offer, Plan, Question},
    unit::Micros,
};

use super::progress::Progress;

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
pub const WITHIN: Micros = Micros(100);

/// `1%`, as a share.
///
/// # Errors
/// When it is not a percentage from 0 to 100.
pub fn percent(text: &str) -> Result<f64, String> {
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

/// Makes the plan, with a bar.
///
/// # Errors
/// When the scene or the sensor cannot go on.
pub fn make(question: &Question<'_>, scene: &str, options: &OpenOptions) -> miette::Result<Plan> {
    let frames = open(scene, options)?.frames();
    let progress = Progress::new("looking", frames.map(|frames| 2 * frames));
    let plan = plan::plan(question, &mut || open(scene, options), || progress.tick());
    progress.finish();
    Ok(plan?)
}

/// One thing that could be left out.
#[must_use]
pub fn line(offer: &Offer, measured: Option<String>) -> String {
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
#[must_use]
pub fn left_out(plan: &Plan) -> String {
    let left_out = plan.offers.iter().filter(|offer| offer.left_out);
    left_out.map(|offer| line(offer, None)).collect()
}

#[must_use]
pub fn chosen(choice: &Choice) -> String {
    let without: Vec<_> = choice.without.iter().map(ToString::to_string).collect();
    if choice == &Choice::full() {
        "the full model: nothing is left out".to_owned()
    } else if without.is_empty() {
        choice.format.to_string()
    } else {
        format!("{}, without {}", choice.format, without.join(", "))
    }
}

#[must_use]
pub fn allowed(plan: &Plan, tolerance: f64) -> String {
    format!(
        "         at most {} of the events change ({:.0} without a partner); {} are tolerated\n",
        share(plan.bound.share),
        plan.bound.events,
        share(tolerance)
    )
}

/// A share in percent, with three figures.
#[must_use]
pub fn share(share: f64) -> String {
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
