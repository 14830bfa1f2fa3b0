//! In which order words and pixels are worked on. The result is the same to the bit.

use std::{fmt, str::FromStr};

use super::{
    Domain, State, Undecided,
    band::Copies,
    segment::{Piece, Segment},
    semantics,
    sweep::{self, Array},
    tiled,
    walks::{How, Walks},
};
use crate::plane::Size;

/// How the array is walked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Schedule {
    /// One word after the other, each on the whole array, on one thread.
    Plain,
    /// A band of rows through many words while it is in the cache, bands moving up by the
    /// reach of each word; each thread has rows of its own. Two stores of which the second
    /// reads the first are one, and a store that is overwritten before anything can read it
    /// is left out.
    Tiled {
        /// Rows of a band; 0 chooses by the size of a row.
        rows: usize,
    },
    /// Only the pixels whose light or registers, as far as the body reaches, are not what they
    /// were one frame ago. Bodies that propagate bits, or in which the host changes the array,
    /// and domains in which chance or time plays a part, are run as if tiled.
    Active,
}

/// No such schedule.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("unknown schedule `{name}`")]
#[diagnostic(help("known are plain, tiled and active"))]
pub struct ScheduleError {
    /// What was given.
    pub name: String,
}

impl Schedule {
    /// The best for an array of this size.
    #[must_use]
    pub const fn of(size: Size) -> Self {
        if size.pixels() < 64 * 64 {
            Self::Plain
        } else {
            Self::Tiled { rows: 0 }
        }
    }
}

impl FromStr for Schedule {
    type Err = ScheduleError;

    fn from_str(name: &str) -> Result<Self, ScheduleError> {
        match name {
            "plain" => Ok(Self::Plain),
            "tiled" => Ok(Self::Tiled { rows: 0 }),
            "active" => Ok(Self::Active),
            _ => Err(ScheduleError { name: name.into() }),
        }
    }
}

impl fmt::Display for Schedule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Plain => "plain",
            Self::Tiled { .. } => "tiled",
            Self::Active => "active",
        })
    }
}

/// A schedule, the threads that it may use, and what it keeps between words.
#[derive(Clone, Debug)]
pub(super) struct Plan<C> {
    schedule: Schedule,
    threads: usize,
    copies: Copies<C>,
    walks: Walks,
}

impl<C: Clone + Send + Sync> Plan<C> {
    pub(super) fn new(schedule: Schedule, threads: usize) -> Self {
        Self {
            schedule,
            threads: threads.max(1),
            copies: Copies::default(),
            walks: Walks::default(),
        }
    }

    /// Words may lie where others lay before.
    pub(super) fn forget(&mut self) {
        self.walks.forget();
    }

    pub(super) const fn schedule(&self) -> Schedule {
        self.schedule
    }

    /// Runs the words of a segment on the whole array.
    ///
    /// # Errors
    /// The line of a word that has no answer in this domain.
    pub(super) fn run<D: Domain<Cell = C>>(
        &mut self,
        array: Array<'_, D>,
        state: &mut State<C>,
        segment: &Segment<'_, C>,
    ) -> Result<(), (u32, Undecided)> {
        let size = state.layout.size;
        if self.schedule == Schedule::Plain && size.pixels() <= CELLS {
            return cell_by_cell(array, state, segment);
        }
        for register in segment.copied() {
            sweep::make_copies(&mut self.copies, state, Some(register));
        }
        let (rows, threads) = match self.schedule {
            Schedule::Plain => (size.height, 1),
            Schedule::Tiled { rows: rows @ 1.. } => (rows, self.threads),
            // Bits are so few that all of them stay in the cache.
            _ if segment.pieces().iter().all(Piece::is_bits) => (size.height, 1),
            Schedule::Tiled { .. } | Schedule::Active => {
                (tiled::rows(size, size_of::<C>()), self.threads)
            }
        };
        let whole = state.flag.is_full();
        // Word after word, all of each.
        let how = How {
            stores_all: self.schedule == Schedule::Plain,
            pairs: array.domain.pairs(),
        };
        let walks = self.walks.of(segment, whole, &state.layout, rows, how);
        let (copies, constants) = (&mut self.copies, segment.constants());
        let mut run = || {
            let mut walks = walks.iter();
            walks.try_for_each(|walk| walk.run(array, threads, state, copies, constants))
        };
        if threads > 1 {
            // Among the threads, so that they need not be woken for every walk.
            rayon::scope(|_| run())
        } else {
            run()
        }
    }
}

/// Arrays of so many pixels are plainly run cell by cell: a row is no gain.
const CELLS: usize = 256;

/// Word after word, pixel after pixel, as [`semantics`] says.
fn cell_by_cell<D: Domain>(
    array: Array<'_, D>,
    state: &mut State<D::Cell>,
    segment: &Segment<'_, D::Cell>,
) -> Result<(), (u32, Undecided)> {
    let constants = segment.constants();
    for piece in segment.pieces() {
        if let Piece::Word { issued, line, .. } = piece {
            let input = &constants.inputs[issued.input][0];
            let step = constants.first + issued.step;
            let (domain, settings) = (array.domain, array.settings);
            let ran = semantics::execute(domain, settings, state, issued.word, input, step);
            ran.map_err(|undecided| (*line, undecided))?;
        }
    }
    Ok(())
}
