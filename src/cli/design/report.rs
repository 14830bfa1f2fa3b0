//! The feasibility report of the candidate that is taken.

use std::{fmt::Write as _, path::Path};

use super::{
    super::{quoted::quoted, readout::Choice},
    Arguments, Candidate, Question,
};
use crate::{
    compare::window,
    photoreceptor::Response,
    rig::guard::Warning,
    scene::Observation,
    study::{
        feasibility::{self, readout::ReadoutOrder},
        report,
    },
};

/// Energy of a bit on the link, pJ: the least and the most, as `feasibility` has it.
const LINK: [f64; 2] = [1.0, 20.0];

/// The page.
pub(super) fn page(
    arguments: &Arguments,
    candidate: &Candidate,
    sensor: &Path,
    question: &Question<'_>,
    fps: f64,
) -> miette::Result<String> {
    let command = command(arguments, candidate, sensor);
    let candidates = [candidate.to];
    let readout = Choice::default().open_compiled()?.readout()?;
    let kinds = candidate.kinds.iter().zip(question.kernels);
    let questions: Vec<_> = kinds
        .map(|(kind, kernel)| feasibility::Question {
            name: &kind.name,
            kernel,
            threshold: kind.threshold,
            to: Some(candidate.to),
            candidates: &candidates,
            sum: question.sum,
            device: question.device,
            memory: Some(candidate.remembers),
            exposure: None,
            order: ReadoutOrder::Overlapped,
            link: LINK,
            effort: question.effort,
            seed: question.seed,
            readout,
            within: question.within.unwrap_or_else(|| window::headline(fps)),
            chips: arguments.chips(),
            scene: arguments.clip.name(),
            command: &command,
        })
        .collect();
    let observation = Observation::new();
    let open = || arguments.clip.open(&observation);
    let mut reply = feasibility::ask(&questions, &open, |_| ())?;
    let warnings = Warning::of_scene(&observation, Response::IDENTITY);
    reply.saw(&warnings, observation.words().as_deref());
    Ok(report::page(&reply))
}

/// The command that gives the same page again.
fn command(arguments: &Arguments, candidate: &Candidate, sensor: &Path) -> String {
    let mut text = format!(
        "amacrine feasibility {}",
        quoted(&sensor.display().to_string())
    );
    let mut add = |name: &str, value: &str| {
        // Writing to a string cannot fail.
        let _ = write!(text, " --{name} {}", quoted(value));
    };
    for (name, value) in arguments.clip.written() {
        add(name, &value);
    }
    add("to", &candidate.to.to_string());
    add("candidates", &candidate.to.to_string());
    add("sum", arguments.sum.name());
    add("memory", &candidate.remembers.to_string());
    add("chip", &arguments.chip);
    let [least, most] = LINK;
    add("link-energy", &format!("{least}..{most}"));
    add("readout", ReadoutOrder::Overlapped.name());
    add("chips", &arguments.chips().to_string());
    if let Some(within) = arguments.window.within {
        add("within", &format!("{}us", within.0));
    }
    add("effort", &arguments.effort.to_string());
    add("seed", &arguments.seed.to_string());
    text + " -o report.html"
}
