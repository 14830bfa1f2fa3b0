//! What there is to warn of where sensors are chosen from.

use super::{
    super::{design::DesignError, feasibility::chips::HALF},
    Aim, Candidate, Exploration, ExplorationError, Question, RatedThresholds,
};
use crate::rig::guard::{Guard, Warning};

impl Exploration {
    /// What there is to warn of all that was found, and of what is picked.
    ///
    /// # Errors
    /// When the kernels are not to be had in the few values of what is picked.
    pub fn doubts(
        &self,
        question: &Question<'_>,
        picked: &Candidate,
    ) -> Result<Vec<Warning>, ExplorationError> {
        let mut all = self.missed(question);
        all.extend(self.by_chance());
        all.extend(self.few(question));
        all.extend(self.silent(picked));
        let little = |kept| Warning::kept(&picked.to.to_string(), kept, HALF);
        all.extend(picked.kept.and_then(little));
        all.extend(question.erased(picked)?);
        Ok(all)
    }

    /// What no threshold gives: with either memory.
    fn missed(&self, question: &Question<'_>) -> Vec<Warning> {
        let Aim::Rate(asked) = question.aim else {
            return Vec::new();
        };
        let subject = |it: &RatedThresholds| format!("a memory of the {}", it.memory);
        { self.rated.iter() }
            .filter_map(|it| Warning::rate(&subject(it), asked, it.rate))
            .collect()
    }

    /// Kinds of which chance scores as much as any program.
    fn by_chance(&self) -> Vec<Warning> {
        let mut guard = Guard::new();
        let kinds = self.candidates.iter().flat_map(|it| &it.kinds);
        guard.extend(kinds.filter_map(|kind| kind.exact.warning(&kind.name)));
        guard.warnings()
    }

    /// Kinds of which few events decide what comes before what.
    fn few(&self, question: &Question<'_>) -> Vec<Warning> {
        let mut guard = Guard::new();
        for rated in &self.rated {
            let kinds = question.names.iter().zip(&rated.events);
            guard.extend(kinds.filter_map(|(name, events)| match question.names {
                [_] => Warning::few_events(*events),
                _ => Warning::few_events_of(name, *events),
            }));
        }
        guard.warnings()
    }

    /// Kinds of what is picked without an event: of the float sensor, or of the program alone.
    fn silent(&self, picked: &Candidate) -> Vec<Warning> {
        let mut guard = Guard::new();
        for kind in &picked.kinds {
            let who = match kind.silicon.event_ratio {
                None => "the float sensor".to_owned(),
                Some(0.0) => format!("{} silicon", picked.to),
                Some(_) => continue,
            };
            guard.warn(Warning::no_events(
                &format!("{who}, {}", kind.name),
                Some(self.frames),
            ));
        }
        guard.warnings()
    }
}

impl Question<'_> {
    /// What the few values of what is picked have taken from its kernels.
    fn erased(&self, picked: &Candidate) -> Result<Vec<Warning>, ExplorationError> {
        let mut guard = Guard::new();
        for (name, kernel) in self.names.iter().zip(self.kernels) {
            let levels = picked.to.quantise(kernel, self.sum, self.seed);
            let levels = levels.map_err(DesignError::from)?;
            let own = format!("{name} in {}", picked.to);
            let erasures = levels.erasures(kernel).into_iter();
            guard.extend(erasures.map(|erasure| Warning::erased(&own, erasure)));
        }
        Ok(guard.warnings())
    }
}
