//! Scores of so few events that one of them decides.

use super::guard::{About, Warning};
use crate::unit::counted;

/// Of fewer events than this, what is kept is told with a caution: by chance alone the half of a
/// hundred is 0.4 to 0.6.
const FEW: u64 = 100;

impl Warning {
    /// That what is kept is told of so few events of the reference; none where there are enough, and
    /// where there is none, which is told elsewhere.
    #[must_use]
    pub fn few_events(events: u64) -> Option<Self> {
        Self::few("what is kept", events)
    }

    /// The same of one of several kinds of cells.
    #[must_use]
    pub fn few_events_of(kind: &str, events: u64) -> Option<Self> {
        Self::few(&format!("what is kept of {kind}"), events)
    }

    fn few(subject: &str, events: u64) -> Option<Self> {
        (1..FEW).contains(&events).then(|| {
            Self::new(
                About::FewEvents,
                subject,
                format!(
                    "the float sensor has only {}, each worth {:.3} of the result",
                    counted(events, "event"),
                    1.0 / events as f64
                ),
                "with so few, noise and a chip's mismatch decide",
                "show a longer scene or one with more movement, or lower the threshold",
            )
        })
    }
}
