//! What a comparison of two recordings is warned of.

use super::{About, Guard, Warning};
use crate::{compare::window::can_judge, event::Packet, unit::Micros};

impl Warning {
    /// What a comparison of two recordings warns of, in which chance scores `floor` within `window`.
    #[must_use]
    pub fn of_comparison(
        [reference, judged]: [&Packet; 2],
        window: Micros,
        floor: f64,
    ) -> Vec<Self> {
        let mut guard = Guard::new();
        guard.recording("the reference", reference);
        guard.recording("the judged", judged);
        let speak = !reference.events.is_empty() && !judged.events.is_empty();
        let window = Self::window(window, floor).filter(|_| speak);
        guard.extend(Self::names(&reference.names, &judged.names));
        guard.extend(window);
        guard.warnings()
    }

    /// Recordings whose kinds of cells, which are compared by their numbers, have other names.
    #[must_use]
    pub fn names(reference: &[String], judged: &[String]) -> Option<Self> {
        let mut pairs = reference.iter().zip(judged).enumerate();
        let (kind, (one, other)) = pairs.find(|(_, (one, other))| one != other)?;
        Some(Self::new(
            About::Names,
            "the judged",
            format!("kind {kind} is `{other}`, but `{one}` in the reference"),
            "kinds are compared by number, not by name",
            "if their order differs, compare one kind at a time: `amacrine convert --kind` writes one",
        ))
    }

    /// A window within which chance scores this much; none where a score still says something
    /// ([`can_judge`]).
    #[must_use]
    pub fn window(within: Micros, floor: f64) -> Option<Self> {
        (!can_judge(floor)).then(|| {
            Self::new(
                About::Window,
                "what is kept",
                format!("within {within}, chance alone scores {floor:.3} of 1"),
                "the recording is little longer than the window, or cells fire more than once per window",
                "take a shorter window (--within, in a study `within`), or a longer scene",
            )
        })
    }

    /// Two packets without an event, which differ in nothing.
    #[must_use]
    pub fn nothing_to_compare(subject: &str) -> Self {
        Self::new(
            About::NoEvents,
            subject,
            "nothing to compare: neither sensor has an event",
            "the threshold is above every change in the scene",
            "lower the thresholds, show a scene that moves, or leave such points out",
        )
    }
}
