//! Footprints: the copies of the input that a tour holds, each as it is seen from another place, and
//! the words that make them.

use std::collections::BTreeSet;

use super::direction;
use crate::compile::{
    construction::plan_builder::PlanBuilder,
    intermediate::{linear_form::NEWS_CELLS, plan::Value, signed_digit::Place},
};

/// The input, halved or negated, as it is seen from some place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Copy {
    pub(super) place: Place,
    pub(super) halved: usize,
    pub(super) negative: bool,
}

/// A word that makes a copy, or one that readies NEWS for it.
#[derive(Clone, Copy, Debug)]
enum Making {
    /// A copy in NEWS, to be seen from another pixel.
    Sent { of: usize, cell: usize },
    /// NEWS, or that of a neighbour, into a register.
    Read { made: usize, cell: usize },
    /// A copy stored again: halved, negated.
    Halved { of: usize, made: usize },
}

/// The copies of the input that are held, the input itself first.
#[derive(Clone, Debug)]
pub(super) struct Footprint {
    pub(super) copies: Vec<Copy>,
    /// In the order in which they run.
    making: Vec<Making>,
    /// One that two words make anew from another.
    remade: Option<[Making; 2]>,
    /// Exponents of digits that one visit adds.
    pub(super) exponents: usize,
}

impl Footprint {
    /// All of at most `most` copies whose places are connected, of so many exponents at most.
    pub(super) fn all(most: usize, exponents: usize) -> Vec<Self> {
        let mut all = Vec::new();
        for exponents in 1..=exponents.min(most) {
            let shapes = shapes(most / exponents);
            all.extend({ shapes.iter() }.filter_map(|shape| Self::new(shape, exponents)));
        }
        all
    }

    /// The copies at these places, the first of which is the pixel itself.
    fn new(places: &[Place], exponents: usize) -> Option<Self> {
        let copies: Vec<Copy> = (0..exponents)
            .flat_map(|halved| {
                let copy = move |place: &Place| Copy {
                    place: *place,
                    halved,
                    // Every halving negates.
                    negative: halved % 2 == 1,
                };
                places.iter().map(copy)
            })
            .collect();
        let making = fewest(&copies)?;
        let remade = (1..copies.len()).find_map(|made| {
            (0..copies.len()).filter(|of| *of != made).find_map(|of| {
                let centres = (0..NEWS_CELLS.len()).map(|cell| (cell, sent(copies[of], cell)));
                let mut seen = centres.filter_map(|(cell, centre)| {
                    view(&copies[made], &centre).map(|view| (cell, view))
                });
                let (cell, view) = seen.next()?;
                Some([Making::Sent { of, cell }, Making::Read { made, cell: view }])
            })
        });
        Some(Self {
            copies,
            making,
            remade,
            exponents,
        })
    }

    /// Words that make all copies.
    pub(super) fn words(&self) -> usize {
        self.making.len()
    }

    /// Whether a register can be had for some words, by [`remade`](Self::remake).
    pub(super) fn can_remake(&self) -> bool {
        self.remade.is_some()
    }

    /// Adds the words that make all copies; their values.
    pub(super) fn make(&self, builder: &mut PlanBuilder) -> Vec<Value> {
        let mut values = vec![0; self.copies.len()];
        for word in &self.making {
            word.add(builder, &mut values);
        }
        values
    }

    /// Adds the two words that make one of them anew, whose register was free before.
    pub(super) fn remake(&self, builder: &mut PlanBuilder, values: &mut [Value]) {
        for word in self.remade.iter().flatten() {
            word.add(builder, values);
        }
    }
}

impl Making {
    fn add(self, builder: &mut PlanBuilder, values: &mut [Value]) {
        match self {
            Self::Sent { of, cell } => builder.news(direction(cell), vec![values[of]]),
            Self::Read { made, cell } => {
                values[made] = builder.register(vec![direction(cell)], vec![], false);
            }
            Self::Halved { of, made } => {
                values[made] = builder.register(vec![], vec![values[of]], true);
            }
        }
    }
}

/// A copy as it is seen in the pixel's own NEWS cell once it was sent to a neighbour.
fn sent(copy: Copy, cell: usize) -> Copy {
    let (y, x) = NEWS_CELLS[cell];
    Copy {
        place: (copy.place.0 + y, copy.place.1 + x),
        ..copy
    }
}

/// The NEWS cell in which a copy is seen that was [`sent`].
fn view(copy: &Copy, sent: &Copy) -> Option<usize> {
    let alike = (copy.halved, copy.negative) == (sent.halved, sent.negative);
    let apart = (copy.place.0 - sent.place.0, copy.place.1 - sent.place.1);
    NEWS_CELLS.iter().position(|cell| alike && *cell == apart)
}

/// The fewest words that make all copies of the first: the cheapest way through the sets of them.
fn fewest(copies: &[Copy]) -> Option<Vec<Making>> {
    let full = (1usize << copies.len()) - 1;
    let mut best: Vec<Option<Vec<Making>>> = vec![None; full + 1];
    best[1] = Some(Vec::new());
    // A set grows by every step, so that it is final once all smaller numbers are done.
    for held in 1..full {
        let Some(words) = best[held].clone() else {
            continue;
        };
        let mut reach = |more: usize, step: Vec<Making>| {
            let known = &mut best[held | more];
            let count = words.len() + step.len();
            if known.as_ref().is_none_or(|known| count < known.len()) {
                *known = Some(words.iter().copied().chain(step).collect());
            }
        };
        let missing = || (0..copies.len()).filter(|copy| held >> copy & 1 == 0);
        for of in (0..copies.len()).filter(|of| held >> of & 1 == 1) {
            for made in missing() {
                let (from, to) = (copies[of], copies[made]);
                if from.place == to.place && to.halved == from.halved + 1 {
                    reach(1 << made, vec![Making::Halved { of, made }]);
                }
            }
            for cell in 0..NEWS_CELLS.len() {
                let centre = sent(copies[of], cell);
                let seen = missing().filter_map(|made| {
                    let cell = view(&copies[made], &centre)?;
                    Some(Making::Read { made, cell })
                });
                let seen: Vec<Making> = seen.collect();
                for some in 1usize..1 << seen.len() {
                    let mut more = 0;
                    let mut step = vec![Making::Sent { of, cell }];
                    for (i, read) in seen.iter().enumerate() {
                        if let (1, Making::Read { made, .. }) = (some >> i & 1, read) {
                            more |= 1 << made;
                            step.push(*read);
                        }
                    }
                    reach(more, step);
                }
            }
        }
    }
    best.pop().flatten()
}

/// Connected sets of up to `most` places (fixed polyominoes) with the pixel itself as the first.
fn shapes(most: usize) -> Vec<Vec<Place>> {
    let home = vec![(0, 0)];
    let mut last = BTreeSet::from([home]);
    let mut all: Vec<_> = last.iter().cloned().collect();
    for _ in 1..most {
        let mut next = BTreeSet::new();
        for shape in &last {
            for (y, x) in shape {
                for (dy, dx) in &NEWS_CELLS[1..] {
                    let place = (y + dy, x + dx);
                    if !shape.contains(&place) {
                        let mut shape = shape.clone();
                        shape.push(place);
                        shape[1..].sort_unstable();
                        next.insert(shape);
                    }
                }
            }
        }
        all.extend(next.iter().cloned());
        last = next;
    }
    all
}
