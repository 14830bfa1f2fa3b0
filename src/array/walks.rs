//! Walks that were made before: a program runs the same words in every frame.

use super::{
    Layout,
    live::{self, Live},
    segment::{Piece, Segment},
    tiled::Walk,
};
use crate::{isa::Primitive, plane::Size};

/// As many segments are kept at most.
const KEPT: usize = 256;

/// The walks of segments.
#[derive(Clone, Debug, Default)]
pub(super) struct Walks {
    kept: Vec<Kept>,
}

/// What a schedule and a domain make of words.
#[derive(Clone, Copy, Debug)]
pub(super) struct How {
    /// Also what nobody reads is stored.
    pub(super) stores_all: bool,
    /// Two stores may be one.
    pub(super) pairs: bool,
}

/// The walks of one segment, and what they depend on.
#[derive(Clone, Debug)]
struct Kept {
    words: Vec<Word>,
    size: Size,
    whole: bool,
    rows: usize,
    walks: Vec<Walk>,
}

/// A word of a program, by the place where it lies: it stays there as long as the chip does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Word {
    address: usize,
    step: u64,
    input: usize,
}

impl Word {
    fn of(piece: &Piece<'_>) -> Option<Self> {
        match piece {
            Piece::Word { issued, .. } => Some(Self {
                address: std::ptr::from_ref::<Primitive>(issued.word).addr(),
                step: issued.step,
                input: issued.input,
            }),
            // The next word says whether it is there.
            Piece::Copy(_) => None,
        }
    }
}

impl Walks {
    /// Words may lie where others lay before.
    pub(super) fn forget(&mut self) {
        self.kept.clear();
    }

    /// Those of a segment; `whole`: FLAG is 1 in all pixels before it; `how` must be the same
    /// every time.
    pub(super) fn of<C: Clone>(
        &mut self,
        segment: &Segment<'_, C>,
        whole: bool,
        layout: &Layout,
        rows: usize,
        how: How,
    ) -> &[Walk] {
        let pieces = segment.pieces();
        let same = |kept: &Kept| {
            (kept.size, kept.whole, kept.rows) == (layout.size, whole, rows)
                && pieces
                    .iter()
                    .filter_map(Word::of)
                    .eq(kept.words.iter().copied())
        };
        let at = self.kept.iter().position(same).unwrap_or_else(|| {
            if self.kept.len() == KEPT {
                self.kept.clear();
            }
            self.kept.push(Kept {
                words: pieces.iter().filter_map(Word::of).collect(),
                size: layout.size,
                whole,
                rows,
                walks: walks(pieces, whole, layout, rows, how),
            });
            self.kept.len() - 1
        });
        &self.kept[at].walks
    }
}

/// New ones.
fn walks(
    mut pieces: &[Piece<'_>],
    whole: bool,
    layout: &Layout,
    rows: usize,
    how: How,
) -> Vec<Walk> {
    let mut known = live::known(pieces, whole, layout);
    if how.stores_all {
        for known in &mut known {
            known.live = Live::ALL;
        }
    }
    let mut known = &known[..];
    let mut walks = Vec::new();
    while !pieces.is_empty() {
        let walk = Walk::new(pieces, known, layout, rows, how.pairs);
        (pieces, known) = (&pieces[walk.len()..], &known[walk.len()..]);
        walks.push(walk);
    }
    walks
}
