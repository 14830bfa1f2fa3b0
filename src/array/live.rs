//! What is read of what a word stores: what nobody reads need not be stored.

use super::{Layout, reach::Register, segment::Piece, wire::Known};
use crate::isa::{Analog, Primitive, Source, Target};

/// A set of analogue registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Live(u64);

impl Live {
    /// All of them: what the host can see.
    pub(super) const ALL: Self = Self(!0);

    /// Registers beyond the sixty-fourth are always in it.
    fn bit(register: Analog) -> u64 {
        1u64.checked_shl(register.0.into()).unwrap_or(0)
    }

    pub(super) fn has(self, register: Analog) -> bool {
        let bit = Self::bit(register);
        bit == 0 || self.0 & bit != 0
    }

    fn insert(&mut self, register: Analog) {
        self.0 |= Self::bit(register);
    }

    fn remove(&mut self, register: Analog) {
        self.0 &= !Self::bit(register);
    }

    /// As it is before a word, if it is `self` after it; `whole`: FLAG is 1 in all pixels.
    fn before(mut self, word: &Primitive, whole: bool, news: Analog) -> Self {
        match word {
            Primitive::Bus { targets, sources } => {
                let stored = |target: &Target| match target {
                    Target::Register(register) => *register,
                    // All cells: those at the border are driven from off the array.
                    Target::Neighbour(_) => news,
                };
                let lost = whole && !targets.iter().any(|target| self.has(stored(target)));
                if lost {
                    // Nobody reads what it reads, either.
                    return self;
                }
                for target in targets.iter().filter(|_| whole) {
                    self.remove(stored(target));
                }
                self.read(sources, news);
            }
            Primitive::Square { sources } => {
                if whole {
                    self.remove(news);
                }
                self.read(sources, news);
            }
            Primitive::Where { sources } => self.read(sources, news),
            Primitive::Blur { target, source, .. } => {
                if whole {
                    self.remove(*target);
                }
                self.insert(*source);
            }
            Primitive::Nop
            | Primitive::ResetPix
            | Primitive::All
            | Primitive::BlurSet
            | Primitive::Set { .. }
            | Primitive::Clear { .. }
            | Primitive::Or { .. }
            | Primitive::Nor { .. }
            | Primitive::WhereBit { .. }
            | Primitive::Dnews { .. }
            | Primitive::PropRead
            | Primitive::Prop { .. } => {}
        }
        self
    }

    fn read(&mut self, sources: &[Source], news: Analog) {
        for source in sources {
            match source {
                Source::Register(register) => self.insert(*register),
                Source::Neighbour(_) => self.insert(news),
                Source::Pix | Source::In => {}
            }
        }
    }
}

/// What is known about each piece; after the last the host looks. `whole`: FLAG is 1 in all
/// pixels before the first.
pub(super) fn known(pieces: &[Piece<'_>], mut whole: bool, layout: &Layout) -> Vec<Known> {
    let mut all = Vec::with_capacity(pieces.len());
    for piece in pieces {
        all.push(Known {
            whole,
            ..Known::NOTHING
        });
        if let Piece::Word { issued, .. } = piece {
            match issued.word {
                Primitive::All => whole = true,
                Primitive::Where { .. } | Primitive::WhereBit { .. } => whole = false,
                _ => {}
            }
        }
    }
    let mut live = Live::ALL;
    for (piece, known) in pieces.iter().zip(&mut all).rev() {
        known.live = live;
        match piece {
            Piece::Word { issued, .. } => {
                live = live.before(issued.word, known.whole, layout.news);
            }
            Piece::Copy(Register::Analog(register)) => live.insert(*register),
            Piece::Copy(Register::Digital(_)) => {}
        }
    }
    all
}
