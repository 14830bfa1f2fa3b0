//! Bus words as the cells that they store and read, and where these lie.

use crate::isa::{Device, Direction, Primitive, Source, Target};

/// The words of a filter as cells and places.
pub(in crate::compile) struct Wired {
    pub(in crate::compile) targets: Vec<(usize, (i32, i32))>,
    pub(in crate::compile) sources: Vec<(usize, (i32, i32))>,
}

/// The box round a pixel in which places lie: the northmost, southmost, westmost and eastmost. At
/// first the pixel alone.
#[derive(Clone, Copy, Default)]
pub(in crate::compile) struct Extent([i32; 4]);

impl Extent {
    pub(in crate::compile) const fn moved(self, (y, x): (i32, i32)) -> Self {
        let [top, bottom, left, right] = self.0;
        Self([top + y, bottom + y, left + x, right + x])
    }

    pub(in crate::compile) fn joined(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Self([
            a[0].min(b[0]),
            a[1].max(b[1]),
            a[2].min(b[2]),
            a[3].max(b[3]),
        ])
    }

    /// How far from the pixel they come.
    pub(in crate::compile) fn farthest(self) -> i32 {
        self.0.iter().fold(0, |most, end| most.max(end.abs()))
    }
}

fn place(direction: Direction) -> (i32, i32) {
    let (y, x) = direction.step();
    (y as i32, x as i32)
}

/// The bus words of a filter, of which other words are none.
pub(in crate::compile) fn wired(words: &[Primitive], device: &Device) -> Vec<Wired> {
    let news = usize::from(device.news().0);
    let mut all = Vec::new();
    for word in words {
        let Some((targets, sources)) = word.as_bus() else {
            continue;
        };
        let target = |target: &Target| match target {
            Target::Register(register) => (usize::from(register.0), (0, 0)),
            Target::Neighbour(direction) => (news, place(*direction)),
        };
        let source = |source: &Source| match source {
            Source::Register(register) => Some((usize::from(register.0), (0, 0))),
            Source::Neighbour(direction) => Some((news, place(*direction))),
            Source::Pix | Source::In => None,
        };
        all.push(Wired {
            targets: targets.iter().map(target).collect(),
            sources: sources.iter().filter_map(source).collect(),
        });
    }
    all
}
