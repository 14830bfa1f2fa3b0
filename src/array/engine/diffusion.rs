//! Rows of the diffusion network, in vectors.

use std::ops::Range;

use multiversion::multiversion;

use super::{
    super::{Place, RowOps, Settings, Share, bits},
    operation::Diffusion,
    runs::{Run, Runs, merge},
    slab::Slab,
};
use crate::{isa::Direction, plane::Size};

/// One explicit step of diffusion. A link conducts where the gates of both its pixels are
/// open: R1 along columns, R2 along rows. Nothing flows over the border.
#[inline(never)]
pub(super) fn diffuse<D: RowOps>(
    domain: &D,
    settings: &Settings,
    slab: &mut Slab<'_, D::Cell>,
    word: &Diffusion,
    rows: Range<usize>,
) {
    let Diffusion { target, source, .. } = *word;
    let (parts, clip) = (settings.diffusion.into(), settings.limits());
    let step = slab.first() + word.step;
    let mut conducting = Conducting::new(word, slab.bits.words());
    let cells = slab.take(target);
    let mut room = std::mem::take(&mut slab.room);
    for y in rows {
        let beside = conducting.row(slab, y);
        let row = |y: usize| slab.row_cells(y..y + 1);
        let from = slab.analog(source, source == target);
        let links = Links {
            own: &from[row(y)],
            beside: beside.map(|y| &from[row(y)]),
            linked: conducting.linked.each_ref().map(Vec::as_slice),
            parts,
        };
        let place = Place {
            y,
            x: 0,
            register: target,
            step,
        };
        let flags = &slab.bits.flag()[slab.bits.row_words(y..y + 1)];
        let cells = &mut cells[row(y)];
        diffuse_row(domain, &links, flags, place, clip, cells, &mut room);
    }
    slab.put(target, cells);
    slab.room = room;
}

/// Which links of a row conduct.
struct Conducting {
    /// Whether each direction is wanted.
    wanted: [bool; 4],
    /// In the order of the directions.
    linked: [Vec<u64>; 4],
}

impl Conducting {
    fn new(word: &Diffusion, words: usize) -> Self {
        Self {
            wanted: Direction::ALL.map(|direction| match direction {
                Direction::North | Direction::South => word.vertical,
                Direction::East | Direction::West => word.horizontal,
            }),
            linked: [const { Vec::new() }; 4].map(|_: Vec<u64>| vec![0; words]),
        }
    }

    /// Looks at the row `y`; the rows beside it, or itself where no link leads there.
    fn row<C>(&mut self, slab: &Slab<'_, C>, y: usize) -> [usize; 4] {
        let Size { height, width } = slab.layout.size;
        let mut beside = [y; 4];
        for (k, direction) in Direction::ALL.into_iter().enumerate() {
            let to = y.wrapping_add_signed(direction.step().0);
            self.linked[k].fill(0);
            if self.wanted[k] && to < height {
                beside[k] = to;
                let gates = slab.bits.digital(slab.layout.roles.links(direction));
                let (own, there) = (
                    &gates[slab.bits.row_words(y..y + 1)],
                    &gates[slab.bits.row_words(to..to + 1)],
                );
                for (i, word) in self.linked[k].iter_mut().enumerate() {
                    *word = own[i] & bits::seen(there, i, direction, width, false);
                }
            }
        }
        beside
    }
}

/// A row of the diffusion network.
struct Links<'a, C> {
    /// What each pixel holds, and what its neighbours hold, in the order of the directions;
    /// beyond the border anything.
    own: &'a [C],
    beside: [&'a [C]; 4],
    /// Where the link to each neighbour conducts.
    linked: [&'a [u64]; 4],
    /// A pixel's own cell against one link.
    parts: i32,
}

/// Stores one step of diffusion along the row `place`, where FLAG is 1.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn diffuse_row<D: RowOps>(
    domain: &D,
    links: &Links<'_, D::Cell>,
    flags: &[u64],
    place: Place,
    clip: Option<(f64, f64)>,
    cells: &mut [D::Cell],
    block: &mut [D::Cell],
) {
    let share = Share {
        by: links.parts as u32,
        part: None,
    };
    let width = cells.len();
    let mut runs = Runs::new(flags, 0, width);
    while let Some(Run { from, to, all }) = runs.next() {
        let cells = &mut cells[from..to];
        let new = if all {
            &mut *cells
        } else {
            &mut block[..to - from]
        };
        for (i, cell) in (from..).zip(new) {
            let mut sum = domain.nothing();
            let mut own = links.parts;
            for (k, linked) in links.linked.iter().enumerate() {
                if linked[i / 64] >> (i % 64) & 1 == 1 {
                    // East and west are rows that begin one later or earlier.
                    let at = match k {
                        1 => (i + 1).min(width - 1),
                        3 => i.saturating_sub(1),
                        _ => i,
                    };
                    domain.add(&mut sum, &links.beside[k][at], 1);
                    own -= 1;
                }
            }
            domain.add(&mut sum, &links.own[i], own);
            let stored = domain.store(&sum, share, Place { x: i, ..place });
            *cell = domain.limited(stored, clip);
        }
        if !all {
            merge(domain, cells, &mut block[..to - from], runs.words());
        }
    }
}
