//! What takes the place of the derivative of a whole number of events.

use crate::reference::MemoryRule;

/// What flows back through the memory. The first three take `dN = dr` in what a pair of frames gives to
/// its voxels, `r = |d| / θ`; `docs/learning.md` derives and compares them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// The released simulator's: the memory is the first frame's, whatever the events did to it. With
    /// `refractory = { rule = "authors" }` also its own derivatives of times and signs, so that its
    /// gradients are met; it points far off the true gradient where a scene moves on.
    Authors,
    /// The memory follows where a cell fired: exact almost everywhere for a memory that snaps.
    Reset,
    /// Straight through all frames: the memory moves by `N θ`, and `N` by `r`, whether a cell fired
    /// or not. Without a refractory period by the authors' rule it telescopes: an event's gradient
    /// meets the difference of two neighbouring frames.
    Through,
    /// The exact gradient of the events averaged over the phase of the memory, whose mean is a play
    /// (backlash) of the drive. For a memory that steps, with no dead time or one that costs few
    /// events. It points right also where events are few, and does not depend on which cells
    /// happened to fire.
    Mean,
}

impl Rule {
    /// [`Rule::Through`] where the memory steps, [`Rule::Reset`] where it snaps.
    #[must_use]
    pub const fn of(memory: MemoryRule) -> Self {
        match memory {
            MemoryRule::FilteredStep | MemoryRule::AuthorsPixelStep => Self::Through,
            MemoryRule::FilteredSnap | MemoryRule::RawSnap => Self::Reset,
        }
    }
}

/// Which cells feel a loss on the number of events.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Slope {
    /// All of them: a silent cell is nearer to its event when its drive moves. Its length is right
    /// where phases are random.
    #[default]
    All,
    /// Those that fired: what the absolute value of a count gives, whose slope at 0 is 0.
    Fired,
}
