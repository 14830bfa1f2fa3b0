//! From how far a word reads, and what it must not have overwritten by then.

use crate::isa::{Analog, Bit, Digital, Direction, Primitive, Source, Target};

/// A register, of either kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Register {
    Analog(Analog),
    Digital(Digital),
}

/// How many rows away a word reads from the cell that it writes.
pub(super) fn reach(word: &Primitive) -> usize {
    reaches(word)[0]
}

/// How many rows, and how many columns, away a word reads from the cell that it writes.
pub(super) fn reaches(word: &Primitive) -> [usize; 2] {
    let along = |axis: usize| {
        let step = |direction: &Direction| <[isize; 2]>::from(direction.step())[axis];
        match word {
            Primitive::Bus { targets, sources } => {
                let to = targets.iter().map(|target| match target {
                    Target::Register(_) => 0,
                    Target::Neighbour(direction) => step(direction),
                });
                // The driver itself, and what it reads.
                let from = || beside(sources).map(|direction| step(&direction)).chain([0]);
                let far = to.flat_map(|to| from().map(move |from| (from - to).unsigned_abs()));
                far.max().unwrap_or(0)
            }
            Primitive::Square { sources } | Primitive::Where { sources } => {
                let far = beside(sources).map(|direction| step(&direction).unsigned_abs());
                far.max().unwrap_or(0)
            }
            Primitive::Blur {
                horizontal,
                vertical,
                ..
            } => usize::from([*vertical, *horizontal][axis]),
            Primitive::Dnews { .. } => 1,
            Primitive::Nop
            | Primitive::ResetPix
            | Primitive::All
            | Primitive::BlurSet
            | Primitive::Set { .. }
            | Primitive::Clear { .. }
            | Primitive::Or { .. }
            | Primitive::Nor { .. }
            | Primitive::WhereBit { .. }
            | Primitive::PropRead => 0,
            // As far as it goes.
            Primitive::Prop { .. } => usize::MAX,
        }
    };
    [along(0), along(1)]
}

/// The neighbours whose NEWS is among the sources.
pub(super) fn beside(sources: &[Source]) -> impl Iterator<Item = Direction> {
    sources.iter().filter_map(|source| match source {
        Source::Neighbour(direction) => Some(*direction),
        Source::Register(_) | Source::Pix | Source::In => None,
    })
}

/// The register that a word reads in one pixel after it has written it in another: it must
/// read a copy, made before.
pub(super) fn copied(word: &Primitive, news: Analog) -> Option<Register> {
    let reads = |sources: &[Source]| {
        sources.iter().any(|source| match source {
            Source::Register(register) => *register == news,
            Source::Neighbour(_) => true,
            Source::Pix | Source::In => false,
        })
    };
    match word {
        Primitive::Bus { targets, sources } => {
            let drives = targets.iter().any(|target| match target {
                Target::Register(register) => *register == news,
                Target::Neighbour(_) => true,
            });
            (drives && reads(sources)).then_some(Register::Analog(news))
        }
        Primitive::Square { sources } => reads(sources).then_some(Register::Analog(news)),
        Primitive::Blur { target, source, .. } => {
            (target == source).then_some(Register::Analog(*source))
        }
        Primitive::Dnews { target, source, .. } => {
            (*source == Bit::Register(*target)).then_some(Register::Digital(*target))
        }
        Primitive::Nop
        | Primitive::ResetPix
        | Primitive::Where { .. }
        | Primitive::All
        | Primitive::BlurSet
        | Primitive::Set { .. }
        | Primitive::Clear { .. }
        | Primitive::Or { .. }
        | Primitive::Nor { .. }
        | Primitive::WhereBit { .. }
        | Primitive::PropRead
        | Primitive::Prop { .. } => None,
    }
}
