//! The feasibility report of the candidate that is taken.

use std::path::Path;

use super::{Arguments, Question};
use crate::{
    cli::{arguments::readout::Choice, output::command_line::CommandLine},
    compare::window,
    photoreceptor::Response,
    rig::guard::Warning,
    scene::Observation,
    study::{
        exploration::Candidate,
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
    let mut line = CommandLine::new("feasibility");
    line.word(&sensor.display().to_string());
    line.options(arguments.clip.written());
    line.option("to", &candidate.to.to_string());
    line.option("candidates", &candidate.to.to_string());
    line.option("sum", arguments.sum.name());
    line.option("memory", &candidate.remembers.to_string());
    line.option("chip", &arguments.chip);
    let [least, most] = LINK;
    line.option("link-energy", &format!("{least}..{most}"));
    line.option("readout", ReadoutOrder::Overlapped.name());
    line.option("chips", &arguments.chips().to_string());
    if let Some(within) = arguments.window.within {
        line.option("within", &format!("{}us", within.0));
    }
    line.option("effort", &arguments.effort.to_string());
    line.option("seed", &arguments.seed.to_string());
    format!("{line} -o report.html")
}
