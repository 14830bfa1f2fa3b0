//! What an effect of a sensor does to a run, from which bounds, crops, tiles and shared work follow: one
//! place to say it of an effect that is added.

use super::{Description, effect::Effect};

/// What an effect does to a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Influence {
    /// Whether cells fire by it where no light changes.
    pub alone: Alone,
    /// What it is between two frames.
    pub between: InBetween,
    /// Where it acts.
    pub stage: Stage,
    /// Whether it moves memories to where no drive has been.
    pub moves_memory: bool,
    /// What leaving it out may change where a sample does not show it.
    pub unseen: Region,
}

/// Whether cells fire where no light changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alone {
    /// They do not.
    Never,
    /// They do, where it exceeds the threshold.
    OverThreshold,
    /// They do, whatever the threshold.
    AtAnyThreshold,
}

/// What an effect is between two frames, and so what inserted frames change of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InBetween {
    /// The same as with frames in between: it does not depend on time, or evenly.
    Same,
    /// Drawn anew for each frame.
    Drawn,
    /// It bends the straight line of the drive.
    Bent,
    /// Decided crossing by crossing, which rounding may tip.
    Tipped,
}

/// Where an effect acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// In what the sensor is shown.
    Scene,
    /// At a photoreceptor, or by its signal: the drive alone does not say what happens.
    Pixel,
    /// In the resistor sheets.
    Sheet,
    /// In a cell, behind the drive.
    Cell,
}

/// What may change together where a sample does not show it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Region {
    /// Single cells, each by itself.
    Single,
    /// A whole place, by what the scene does there.
    Tile,
}

impl Effect {
    /// What it does to a run.
    #[must_use]
    pub const fn influence(self) -> Influence {
        use Alone::{AtAnyThreshold, Never, OverThreshold};
        use InBetween::{Bent, Drawn, Same, Tipped};
        use Region::{Single, Tile};
        use Stage::{Cell, Pixel, Scene, Sheet};
        let (alone, between, stage, moves_memory, unseen) = match self {
            Self::Surroundings => (Never, Same, Scene, false, Single),
            Self::InsertedFrames => (Never, Same, Scene, false, Tile),
            Self::DeadTime => (Never, Tipped, Cell, false, Tile),
            // Shot noise is less in bright light.
            Self::NoiseEvents => (AtAnyThreshold, Drawn, Pixel, false, Single),
            Self::Jitter => (Never, Drawn, Cell, false, Single),
            Self::Bandwidth => (Never, Bent, Pixel, false, Tile),
            Self::Leak => (AtAnyThreshold, Same, Cell, true, Single),
            Self::Mismatch => (Never, Same, Cell, false, Tile),
            Self::MeshNoise => (OverThreshold, Drawn, Sheet, false, Tile),
        };
        Influence {
            alone,
            between,
            stage,
            moves_memory,
            unseen,
        }
    }
}

impl Description {
    /// Whether an effect that it has does this.
    #[must_use]
    pub fn is_influenced(&self, so: impl Fn(Influence) -> bool) -> bool {
        self.effects().into_iter().map(Effect::influence).any(so)
    }

    /// Whether cells may fire that see nothing change: by an effect, or because the memory moves by
    /// itself.
    #[must_use]
    pub fn fires_alone(&self) -> bool {
        self.memory.moves_alone() || self.is_influenced(|it| it.alone != Alone::Never)
    }
}
