//! The fate of each event: kept, mistimed, of the wrong sign, lost; and what is extra.
//!
//! Events of the reference and of the judged packet are paired within one site (pixel and kind),
//! each at most once, in three rounds, the nearest in time first:
//!
//! 1. same sign, times differ by at most the narrow window: **kept**
//! 2. opposite sign, at most the narrow window: **wrong sign**
//! 3. same sign, at most the wide window: **mistimed**
//!
//! What is left of the reference is **lost**, what is left of the judged packet **extra**. So
//! the classes part both packets:
//!
//! ```text
//! reference = kept + wrong sign + mistimed + lost
//! judged    = kept + wrong sign + mistimed + extra
//! ```
//!
//! Each round pairs greedily in order of time, which makes as many pairs as can be of what the
//! rounds before have left ([`matching`](super::matching) has the proof).

use serde::{Deserialize, Serialize};

use super::{Pair, Signed};
use crate::{event::Polarity, unit::Micros};

/// The matching windows: how far apart in time two events may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Windows {
    /// For kept events and wrong signs.
    pub narrow: Micros,
    /// For mistimed events; less than the narrow one is as much as that.
    pub wide: Micros,
}

/// How many events of each class.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fate {
    /// There before and after, within the narrow window.
    pub kept: u64,
    /// There before and after, within the wide window only.
    pub mistimed: u64,
    /// There before and after, with the opposite sign, within the narrow window.
    pub wrong_sign: u64,
    /// There before, not after.
    pub lost: u64,
    /// There after, not before.
    pub extra: u64,
}

impl Fate {
    /// What the judged packet of a pair made of the reference.
    #[must_use]
    pub fn from_pair(pair: &Pair, windows: Windows) -> Self {
        let part = pair.fold_sites(
            Part::default,
            |part, reference, judged| part.add(reference, judged, windows),
            |a, b| Part {
                fate: a.fate.plus(b.fate),
                ..a
            },
        );
        part.fate
    }

    /// Events of the reference.
    #[must_use]
    pub const fn before(self) -> u64 {
        self.kept + self.mistimed + self.wrong_sign + self.lost
    }

    /// Events of the judged packet.
    #[must_use]
    pub const fn after(self) -> u64 {
        self.kept + self.mistimed + self.wrong_sign + self.extra
    }

    /// All that is not kept, of either packet.
    #[must_use]
    pub const fn changed(self) -> u64 {
        self.mistimed + self.wrong_sign + self.lost + self.extra
    }

    const fn plus(self, other: Self) -> Self {
        Self {
            kept: self.kept + other.kept,
            mistimed: self.mistimed + other.mistimed,
            wrong_sign: self.wrong_sign + other.wrong_sign,
            lost: self.lost + other.lost,
            extra: self.extra + other.extra,
        }
    }
}

/// Working memory for a piece of the sites.
#[derive(Default)]
struct Part {
    fate: Fate,
    reference: [Vec<u64>; 2],
    judged: [Vec<u64>; 2],
}

impl Part {
    fn add(&mut self, reference: Signed<'_>, judged: Signed<'_>, windows: Windows) {
        let Self {
            fate,
            reference: [off, on],
            judged: [judged_off, judged_on],
        } = self;
        times(reference, off, on);
        times(judged, judged_off, judged_on);
        let Windows { narrow, wide } = windows;
        fate.kept += paired(off, judged_off, narrow) + paired(on, judged_on, narrow);
        fate.wrong_sign += paired(off, judged_on, narrow) + paired(on, judged_off, narrow);
        let wide = wide.max(narrow);
        fate.mistimed += paired(off, judged_off, wide) + paired(on, judged_on, wide);
        fate.lost += (off.len() + on.len()) as u64;
        fate.extra += (judged_off.len() + judged_on.len()) as u64;
    }
}

/// The times of each sign, ascending.
fn times(events: Signed<'_>, off: &mut Vec<u64>, on: &mut Vec<u64>) {
    off.clear();
    on.clear();
    for (t, polarity) in events.iter() {
        match polarity {
            Polarity::Off => off.push(t),
            Polarity::On => on.push(t),
        }
    }
}

/// Counts the matches within the window, and removes the matched events from both.
fn paired(reference: &mut Vec<u64>, judged: &mut Vec<u64>, within: Micros) -> u64 {
    let (mut a, mut b) = (0, 0);
    let (mut alone_a, mut alone_b) = (0, 0);
    let mut pairs = 0;
    while let (Some(&ta), Some(&tb)) = (reference.get(a), judged.get(b)) {
        if ta.abs_diff(tb) <= within.0 {
            pairs += 1;
            (a, b) = (a + 1, b + 1);
        } else if ta < tb {
            reference[alone_a] = ta;
            (a, alone_a) = (a + 1, alone_a + 1);
        } else {
            judged[alone_b] = tb;
            (b, alone_b) = (b + 1, alone_b + 1);
        }
    }
    reference.drain(alone_a..a);
    judged.drain(alone_b..b);
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        event::{Event, Packet},
        plane::Size,
    };
    use proptest::prelude::*;

    const WINDOWS: Windows = Windows {
        narrow: Micros(10),
        wide: Micros(100),
    };

    fn packet(events: &[(u64, u16, bool)]) -> Packet {
        let mut packet = Packet::new(Size::new(1, 3), 1);
        packet.events = events
            .iter()
            .map(|&(t, x, on)| Event {
                t: Micros(t),
                x,
                y: 0,
                polarity: Polarity::of(on),
                channel: 0,
            })
            .collect();
        packet
    }

    fn fate(reference: &[(u64, u16, bool)], judged: &[(u64, u16, bool)]) -> Fate {
        let pair = Pair::new(&packet(reference), &packet(judged)).unwrap();
        Fate::from_pair(&pair, WINDOWS)
    }

    /// Time, column and sign.
    type Short = (u64, u16, bool);

    fn stream() -> impl Strategy<Value = Vec<Short>> {
        prop::collection::vec((0..1500_u64, 0..3_u16, any::<bool>()), 0..40)
    }

    #[test]
    fn known_changes_have_their_class() {
        let all: Vec<_> = (0..60)
            .map(|i| (i * 1000, (i % 3) as u16, i % 2 == 0))
            .collect();
        let changed = |change: fn(Short) -> Option<Short>| {
            let judged: Vec<_> = all.iter().filter_map(|e| change(*e)).collect();
            fate(&all, &judged)
        };
        let none = Fate::default();
        assert_eq!(changed(Some), Fate { kept: 60, ..none });
        assert_eq!(changed(|_| None), Fate { lost: 60, ..none });
        assert_eq!(fate(&[], &all), Fate { extra: 60, ..none });
        // Late by as much as each window, and by one more.
        for (late, is) in [
            (10, Fate { kept: 60, ..none }),
            (
                11,
                Fate {
                    mistimed: 60,
                    ..none
                },
            ),
            (
                100,
                Fate {
                    mistimed: 60,
                    ..none
                },
            ),
            (
                101,
                Fate {
                    lost: 60,
                    extra: 60,
                    ..none
                },
            ),
        ] {
            let judged: Vec<_> = all.iter().map(|(t, x, on)| (t + late, *x, *on)).collect();
            assert_eq!(fate(&all, &judged), is, "{late}");
        }
        assert_eq!(
            changed(|(t, x, on)| Some((t, x, !on))),
            Fate {
                wrong_sign: 60,
                ..none
            }
        );
        // Of another pixel; every third left out.
        let moved = changed(|(t, x, on)| Some((t, (x + 1) % 3, on)));
        assert_eq!(
            moved,
            Fate {
                lost: 60,
                extra: 60,
                ..none
            }
        );
        let thinned = changed(|(t, x, on)| (x > 0).then_some((t, x, on)));
        assert_eq!(
            thinned,
            Fate {
                kept: 40,
                lost: 20,
                ..none
            }
        );
    }

    #[test]
    fn the_nearest_round_has_the_first_choice() {
        // An OFF at the very time beats an ON in the wide window.
        let told = fate(&[(500, 0, true)], &[(505, 0, false), (560, 0, true)]);
        assert_eq!(
            told,
            Fate {
                wrong_sign: 1,
                extra: 1,
                ..Fate::default()
            }
        );
        // A pair within the narrow window is never broken for one in the wide window.
        let told = fate(&[(500, 0, true), (590, 0, true)], &[(590, 0, true)]);
        assert_eq!(
            told,
            Fate {
                kept: 1,
                lost: 1,
                ..Fate::default()
            }
        );
    }

    /// Pairs of a largest matching, found by augmenting paths.
    fn largest(a: &[u64], b: &[u64], within: u64) -> u64 {
        fn place(
            i: usize,
            near: &[Vec<usize>],
            seen: &mut [bool],
            taken: &mut [Option<usize>],
        ) -> bool {
            for &j in &near[i] {
                if !std::mem::replace(&mut seen[j], true)
                    && taken[j].is_none_or(|k| place(k, near, seen, taken))
                {
                    taken[j] = Some(i);
                    return true;
                }
            }
            false
        }
        let near: Vec<Vec<usize>> = a
            .iter()
            .map(|t| {
                (0..b.len())
                    .filter(|j| t.abs_diff(b[*j]) <= within)
                    .collect()
            })
            .collect();
        let mut taken = vec![None; b.len()];
        (0..a.len())
            .filter(|i| place(*i, &near, &mut vec![false; b.len()], &mut taken))
            .count() as u64
    }

    /// The rounds as they are told: earliest with earliest, over and over, in lists.
    fn slow(reference: &[(u64, u16, bool)], judged: &[(u64, u16, bool)]) -> Fate {
        let (mut a, mut b) = (reference.to_vec(), judged.to_vec());
        let mut round = |flip: bool, within: Micros| {
            let mut found = 0;
            loop {
                let mut best: Option<(u64, u64, usize, usize)> = None;
                for (i, (ta, xa, on)) in a.iter().enumerate() {
                    for (j, (tb, xb, other)) in b.iter().enumerate() {
                        if xa == xb && (*on != *other) == flip && ta.abs_diff(*tb) <= within.0 {
                            let this = (*ta, *tb, i, j);
                            if best.is_none_or(|best| (this.0, this.1) < (best.0, best.1)) {
                                best = Some(this);
                            }
                        }
                    }
                }
                let Some((_, _, i, j)) = best else {
                    return found;
                };
                a.remove(i);
                b.remove(j);
                found += 1;
            }
        };
        let kept = round(false, WINDOWS.narrow);
        let wrong_sign = round(true, WINDOWS.narrow);
        let mistimed = round(false, WINDOWS.wide);
        Fate {
            kept,
            mistimed,
            wrong_sign,
            lost: a.len() as u64,
            extra: b.len() as u64,
        }
    }

    proptest! {
        #[test]
        fn the_walk_is_what_the_rounds_say(a in stream(), b in stream()) {
            let told = fate(&a, &b);
            prop_assert_eq!(told, slow(&a, &b));
            prop_assert_eq!(told.before(), a.len() as u64);
            prop_assert_eq!(told.after(), b.len() as u64);
        }

        #[test]
        fn the_first_round_finds_as_many_as_can_be(a in stream(), b in stream()) {
            let kept: u64 = (0..3)
                .flat_map(|x| [(x, true), (x, false)])
                .map(|cell| {
                    let of = |events: &[(u64, u16, bool)]| -> Vec<u64> {
                        let own = events.iter().filter(|e| (e.1, e.2) == cell);
                        own.map(|e| e.0).collect()
                    };
                    largest(&of(&a), &of(&b), WINDOWS.narrow.0)
                })
                .sum();
            prop_assert_eq!(fate(&a, &b).kept, kept);
        }

        /// Taken back, what was lost is extra and the other way round.
        #[test]
        fn the_other_way_round_lost_and_extra_change_places(a in stream(), b in stream()) {
            let (there, back) = (fate(&a, &b), fate(&b, &a));
            prop_assert_eq!(there, Fate { lost: back.extra, extra: back.lost, ..back });
        }
    }
}
