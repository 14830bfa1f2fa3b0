//! `--fidelity auto` of `amacrine run`, and how plans are made and told.

use std::{fmt::Write as _, time::Instant};

use miette::{IntoDiagnostic, miette};
use serde_json::Value;

use crate::{
    event::readout::Readout,
    number::Format,
    reference::Description,
    scene::{Scene, SceneError, kept::Kept},
    study::pilot::{
        ChangeEstimate, Offer, Plan, Question,
        change::share,
        plan::{self, BUDGET, Free, KEPT},
    },
    unit::Micros,
};

use super::{budget, heading};

/// `--fidelity` of `amacrine run`.
#[derive(Clone, Debug, clap::Args)]
pub struct Fidelity {
    /// Model: full, or one that leaves out what hardly matters [default: full]
    ///
    /// With `auto` a pilot measures on a sample of tiles what each omission changes in this scene.
    /// The program prints what it leaves out.
    #[arg(long, value_enum, help_heading = heading::MODELS)]
    fidelity: Option<How>,
    /// Share of events that may change with --fidelity auto [default: 1%]
    #[arg(long, value_name = "PERCENT", value_parser = percent, allow_hyphen_values = true, requires = "fidelity", help_heading = heading::MODELS)]
    tolerance: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, clap::ValueEnum)]
enum How {
    /// All effects that the sensor file or the chip has
    Full,
    /// The effects that remain when those within the tolerance are left out
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
        // 3 may mean 3 % or 300 %: it is asked for, not guessed.
        None if text
            .trim()
            .parse::<f64>()
            .is_ok_and(|n| (0.0..=100.0).contains(&n)) =>
        {
            Err(format!(
                "`{text}` has no percent sign: for {text} per cent write {}%",
                text.trim()
            ))
        }
        None => Err(format!(
            "`{text}` is not a percentage: write a number and a percent sign, such as 1% or 0.1%"
        )),
        Some(percent) if (0.0..=100.0).contains(&percent) => Ok(percent / 100.0),
        Some(percent) if !percent.is_finite() => Err(format!(
            "`{text}` is not a percentage from 0% (the full model) to 100%"
        )),
        Some(percent) => Err(format!(
            "{percent} % of the events cannot be tolerated: give 0% (the full model) to 100%"
        )),
    }
}

impl Fidelity {
    /// The share of events that may change.
    #[must_use]
    pub fn tolerance(&self) -> f64 {
        self.tolerance.unwrap_or(0.01)
    }

    /// Refuses a tolerance of which nothing would be used.
    ///
    /// # Errors
    /// When one is given, and no plan is asked for.
    pub fn check(&self) -> miette::Result<()> {
        match self.tolerance {
            Some(tolerance) if !self.is_auto() => Err(miette!(
                help = "give --fidelity auto, or leave --tolerance out",
                "--tolerance {} with --fidelity full, which leaves nothing out",
                share(tolerance)
            )),
            _ => Ok(()),
        }
    }

    /// Refuses what is left out by hand beside a plan; `told` is what, after the model.
    ///
    /// # Errors
    /// When both are given.
    pub fn check_without(&self, told: &str) -> miette::Result<()> {
        if !self.is_auto() || told.is_empty() {
            return Ok(());
        }
        Err(miette!(
            help = "leave --without out, or choose the rest by hand as well",
            "--fidelity auto{told}: it chooses what is left out"
        ))
    }

    /// Whether a plan is asked for.
    #[must_use]
    pub fn is_auto(&self) -> bool {
        self.fidelity == Some(How::Auto)
    }

    /// What is asked of a run, whose array may be cut: `crop`.
    #[must_use]
    pub fn question<'a>(
        &self,
        (description, seed): (&'a Description, u64),
        upsample: Option<f64>,
        readout: Option<Readout>,
        crop: bool,
    ) -> Question<'a> {
        Question {
            description,
            seed,
            tolerance: self.tolerance(),
            within: WITHIN,
            formats: &[Format::F32],
            upsample,
            readout,
            crop,
            looks_anyway: false,
            budget: BUDGET,
            tiles: None,
        }
    }

    /// What the plan left out, for people.
    #[must_use]
    pub fn lines(&self, plan: &Plan) -> String {
        let mut text = chosen(plan, self.tolerance());
        for free in plan
            .free
            .iter()
            .filter(|free| plan.choice.leaves_out(free.what))
        {
            let _ = writeln!(text, "* {:<26} free: {}", free.what.name(), free.why);
        }
        for offer in plan.offers.iter().filter(|offer| offer.left_out) {
            text += &line(offer, None);
        }
        text
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

/// The most bytes of a scene that is kept for a pilot: a quarter of what may be held.
#[must_use]
pub fn room() -> usize {
    let most = budget::budget().bytes / 4;
    usize::try_from(most).unwrap_or(KEPT).min(KEPT)
}

/// A scene that is kept, or still to be read.
pub enum KeptOrUnread {
    /// It was read, and is in memory.
    Kept(Kept),
    /// It has not been read.
    Unread(Box<dyn Scene>),
}

impl KeptOrUnread {
    /// Reads a scene where a pilot wants to look at it and there is room; `open` opens it.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn new(
        looks: bool,
        open: impl Fn() -> Result<Box<dyn Scene>, SceneError>,
    ) -> Result<Self, SceneError> {
        if looks && let Some(kept) = Kept::new(&mut *open()?, room())? {
            return Ok(Self::Kept(kept));
        }
        Ok(Self::Unread(open()?))
    }

    /// What is kept.
    #[must_use]
    pub const fn kept(&self) -> Option<&Kept> {
        match self {
            Self::Kept(kept) => Some(kept),
            Self::Unread(_) => None,
        }
    }

    /// The scene from its beginning.
    #[must_use]
    pub fn scene(self) -> Box<dyn Scene> {
        match self {
            Self::Kept(kept) => kept.into_scene(),
            Self::Unread(scene) => scene,
        }
    }
}

/// Makes the plan.
///
/// # Errors
/// When the full model cannot be made.
pub fn make(question: &Question<'_>, kept: Option<&Kept>) -> miette::Result<Plan> {
    let start = Instant::now();
    let clock = || start.elapsed().as_secs_f64();
    Ok(plan::plan(question, kept, &clock)?)
}

/// One thing that could be left out.
#[must_use]
pub fn line(offer: &Offer<impl Sized>, measured: Option<String>) -> String {
    let told = |of: Option<f64>| of.map_or("-".to_owned(), share);
    let about = told(offer.change.map(|change| change.share));
    let limit = told(offer.change.and_then(|change| change.limit));
    let time = offer.seconds.map_or("-".to_owned(), |[plain, full]| {
        format!("{:.0} %", 100.0 * plain / full)
    });
    let mark = if offer.left_out { '*' } else { ' ' };
    let mut line = format!(
        "{mark} {:<26} {about:>10} {limit:>10} {time:>7}",
        offer.what
    );
    if let Some(measured) = measured {
        let _ = write!(line, " {measured:>10}");
    }
    let _ = writeln!(line, "   {}", offer.why);
    line
}

/// What the plan runs, and why it may.
#[must_use]
pub fn chosen(plan: &Plan, tolerance: f64) -> String {
    let ruled = |free: &Free| plan.choice.leaves_out(free.what);
    let only_rules = plan.offers.iter().all(|offer| !offer.left_out);
    let why = if only_rules && plan.free.iter().any(ruled) {
        format!("all of that is free; beyond it, {}", plan.why)
    } else {
        plan.why.clone()
    };
    told((&plan.choice.to_string(), &why), plan.change, tolerance)
}

/// The same of any choice: what it is, why, and what it changes.
#[must_use]
pub fn told((choice, why): (&str, &str), change: Option<ChangeEstimate>, tolerance: f64) -> String {
    let mut text = format!("plan     {choice}; {why}\n");
    if let Some(ChangeEstimate {
        share: about,
        limit: Some(limit),
        tiles,
        events,
        ..
    }) = change
    {
        let _ = writeln!(
            text,
            "         about {} of the events change, hardly more than {} ({} of {}); {} are tolerated",
            share(about),
            share(limit),
            crate::unit::counted(events, "event"),
            crate::unit::counted(tiles, "tile"),
            share(tolerance)
        );
    }
    text
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
        assert!(percent("3").unwrap_err().ends_with("write 3%"));
        for none in ["nan", "inf", "-1", "300"] {
            let told = percent(none).unwrap_err();
            assert!(told.ends_with("such as 1% or 0.1%"), "{told}");
        }
    }
}
