//! The rules that a sensor chooses from: memory, polarity, border, refractory period.

use crate::config::listed;

listed! {
/// What an event does to the memory; `docs/reference.md` has the equations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemoryRule {
    /// The memory holds pixels; a pixel that fires stores its own signal (Eq. 2-4 of the paper).
    RawSnap = "raw-snap",
    /// The memory holds the filtered signal; a cell that fires stores it.
    FilteredSnap = "filtered-snap",
    /// The memory holds the filtered signal; each event moves it by one threshold.
    FilteredStep = "filtered-step",
    /// The released simulator's old rule: the memory holds pixels, and is moved by thresholds
    /// of the filtered difference. Only to agree with the released code.
    AuthorsPixelStep = "authors-pixel-step",
}
}

impl MemoryRule {
    /// Whether events move the memory by thresholds; else it takes what is there.
    #[must_use]
    pub const fn steps(self) -> bool {
        match self {
            Self::FilteredStep | Self::AuthorsPixelStep => true,
            Self::RawSnap | Self::FilteredSnap => false,
        }
    }

    /// Whether the memory holds pixels; else it holds the filtered signal.
    #[must_use]
    pub const fn holds_pixels(self) -> bool {
        match self {
            Self::RawSnap | Self::AuthorsPixelStep => true,
            Self::FilteredSnap | Self::FilteredStep => false,
        }
    }

    /// Whether cells fire where the drive crosses levels a threshold apart, on the straight line between
    /// two frames; else at the later frame, or along a line from their memory.
    #[must_use]
    pub const fn crosses_levels(self) -> bool {
        match self {
            Self::FilteredStep => true,
            Self::RawSnap | Self::FilteredSnap | Self::AuthorsPixelStep => false,
        }
    }

    /// Whether it may move in a cell whose own light does not change.
    #[must_use]
    pub const fn moves_alone(self) -> bool {
        match self {
            Self::AuthorsPixelStep => true,
            Self::RawSnap | Self::FilteredSnap | Self::FilteredStep => false,
        }
    }

    /// Whether kernels see how far pixels are from it; else pixels and it are seen apart.
    #[must_use]
    pub const fn is_seen_from_pixels(self) -> bool {
        match self {
            Self::RawSnap => true,
            Self::FilteredSnap | Self::FilteredStep | Self::AuthorsPixelStep => false,
        }
    }

    /// Whether it is the same for all kinds of cells of a pixel, so that they may share one.
    #[must_use]
    pub const fn may_be_shared(self) -> bool {
        match self {
            Self::RawSnap => true,
            Self::FilteredSnap | Self::FilteredStep | Self::AuthorsPixelStep => false,
        }
    }

    /// Whether it is seen through a kernel of its own.
    #[must_use]
    pub const fn has_kernel(self) -> bool {
        match self {
            Self::AuthorsPixelStep => true,
            Self::RawSnap | Self::FilteredSnap | Self::FilteredStep => false,
        }
    }

    /// The refractory rules that it can have; that of a sensor file that states none comes first.
    #[must_use]
    pub const fn refractory_rules(self) -> &'static [RefractoryRule] {
        use RefractoryRule::{Authors, DeadTime};
        match self {
            Self::RawSnap | Self::FilteredSnap => &[DeadTime],
            Self::FilteredStep => &[DeadTime, Authors],
            Self::AuthorsPixelStep => &[Authors],
        }
    }

    /// The refractory period of a sensor file that states none: not at all, by the rule that the memory
    /// has.
    #[must_use]
    pub const fn unstated_refractory(self) -> Refractory {
        let rule = self.refractory_rules()[0];
        Refractory { us: 0.0, rule }
    }
}

listed! {
/// Where an event's sign comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PolarityRule {
    /// The sign of the filtered difference (the released code).
    #[default]
    Filtered = "filtered",
    /// The sign of the pixel's own change since it last fired (Eq. 3 of the paper). A cell
    /// whose own pixel has not changed has no sign and emits nothing.
    Pixel = "pixel",
}
}

listed! {
/// What the kernel reads off the array.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Border {
    /// The nearest pixel of the array.
    #[default]
    Replicate = "replicate",
    /// Zero, after the response.
    Zero = "zero",
}
}

/// How long a cell is silent after an event; `docs/reference.md` has the equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refractory {
    /// How long a cell is silent after an event, in microseconds; 0 for not at all.
    pub us: f64,
    /// How the silence works.
    pub rule: RefractoryRule,
}

impl Refractory {
    /// Whether each event, a cell's first too, comes more than a refractory period after the frame
    /// before it: the authors' rule.
    #[must_use]
    pub fn waits(&self) -> bool {
        self.rule == RefractoryRule::Authors && self.us > 0.0
    }

    /// Whether no cell can fire between frames at these times, in seconds, because it waits for longer.
    /// Times of frames are rounded: frames a refractory period apart are not further apart than that.
    #[must_use]
    pub fn mutes(&self, from: f64, to: f64) -> bool {
        // Half a unit in the last place for each of the two times, and as much for their difference.
        let rounding = 2.0 * f64::EPSILON * from.abs().max(to.abs());
        self.waits() && to - from <= self.us * 1e-6 + rounding
    }
}

listed! {
/// How the silence after an event works.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RefractoryRule {
    /// A real dead time: crossings in it are lost, and the memory moves through them.
    #[default]
    DeadTime = "dead-time",
    /// The supplement's `α_r` and `β_r`, as in the released simulator.
    Authors = "authors",
}
}
