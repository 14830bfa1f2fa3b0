//! Predecessors of a state: the words that may have led to it.
//!
//! The search runs backwards, so "before" a word means after it in the order of the search. A
//! predecessor is found by choosing which held value the last word stored, and which sources could
//! have made it.

use std::rc::Rc;

use super::{
    super::linear_form::{LinearForm, NEWS_CELLS, Tap},
    EXPANDED, Item, Out, SOURCES, SOURCES_SPLIT, Search, State, Step,
    score::{parts, weight},
    view,
};
use crate::isa::Direction;

impl Search<'_> {
    /// Expands a state: adds all states from which one word leads to it.
    pub(super) fn expand(&mut self, state: &State, out: &mut Out<'_>) {
        if let Some(news) = &state.news {
            self.before_news(state, news, out);
        }
        let mut order: Vec<usize> = (0..state.live.len()).collect();
        order.sort_by(|a, b| {
            let cost = |at: &usize| self.cost(&state.live[*at]);
            cost(b).total_cmp(&cost(a)).then(a.cmp(b))
        });
        let mut done: Vec<u64> = Vec::new();
        for at in order {
            let item = &state.live[at];
            let single = state.live.iter().filter(|i| i.hash == item.hash).count() == 1;
            if item.hash == self.input.hash && single || done.contains(&item.hash) {
                continue;
            }
            done.push(item.hash);
            match &state.news {
                // A value that is cheap to make can as well be made by an earlier word: only the
                // two costliest are expanded.
                None if done.len() > EXPANDED => break,
                None => self.before_register(state, at, out),
                Some(news) => self.before_reread(state, at, news, out),
            }
        }
    }

    /// Predecessors by the word that stored `news` in NEWS.
    pub(super) fn before_news(&mut self, state: &State, news: &Rc<Item>, out: &mut Out<'_>) {
        for (i, place) in NEWS_CELLS.into_iter().enumerate() {
            // Stored into the neighbour's NEWS cell: the form as seen from the other pixel.
            let to = view(i).map(Direction::opposite);
            let stored = news.form.shifted((-place.0, -place.1));
            if self.task.border && !stored.is_outward(place) {
                continue;
            }
            for (sum, halved, room) in stores_of(&stored) {
                let base = Step {
                    stored: None,
                    news: Some(to),
                    views: 0,
                    values: Vec::new(),
                    halved,
                };
                self.sums(state, None, &sum, &base, room, out);
                if halved {
                    let twin = state.live.iter().position(|item| item.form == stored);
                    if let Some(at) = twin
                        && state.live[at].hash != self.input.hash
                    {
                        let base = Step {
                            stored: Some(state.live[at].clone()),
                            halved: false,
                            ..base
                        };
                        self.sums(state, Some(at), &sum, &base, room, out);
                    }
                }
            }
        }
    }

    /// Ways to make `sum` as a bus sum of values in registers alone.
    pub(super) fn sums(
        &mut self,
        state: &State,
        at: Option<usize>,
        sum: &LinearForm,
        base: &Step,
        room: usize,
        out: &mut Out<'_>,
    ) {
        let direct = self.find(state, sum.clone());
        self.child(state, at, base, vec![direct], None, out);
        if room < 2 {
            return;
        }
        let mut firsts: Vec<Rc<Item>> = Vec::new();
        for item in state.live.iter().chain([&self.input]) {
            let own = at.is_some_and(|at| state.live[at].hash == item.hash);
            if !own && !firsts.iter().any(|known| known.hash == item.hash) {
                firsts.push(item.clone());
            }
        }
        let old = firsts.len();
        // Candidates that are not held yet: single taps near by that the sum needs in any case.
        for place in NEWS_CELLS {
            let weight = sum.at(place);
            if weight != 0 && sum.taps().len() > 1 {
                let tap = Tap {
                    y: place.0,
                    x: place.1,
                    weight,
                };
                let form = LinearForm::new(vec![tap]);
                if !firsts.iter().any(|known| known.form == form) {
                    firsts.push(self.item(form));
                }
            }
        }
        let size = weight(sum);
        for (i, first) in firsts.iter().enumerate() {
            let rest = sum.plus(&first.form, -1);
            if rest.is_zero() || weight(&rest) > size {
                continue;
            }
            let second = self.find(state, rest.clone());
            self.child(state, at, base, vec![first.clone(), second], None, out);
            if room > 2 && i < old {
                for other in &firsts[i + 1..] {
                    let rest = rest.plus(&other.form, -1);
                    if weight(&rest) >= size {
                        continue;
                    }
                    let values = if rest.is_zero() {
                        vec![first.clone(), other.clone()]
                    } else {
                        let third = self.find(state, rest);
                        vec![first.clone(), other.clone(), third]
                    };
                    self.child(state, at, base, values, None, out);
                }
            }
        }
        if let Some(half) = sum.half()
            && sum
                .taps()
                .iter()
                .any(|tap| tap.weight.abs() > self.task.unit)
        {
            let half = self.find(state, half);
            self.child(state, at, base, vec![half.clone(), half], None, out);
        }
        if self.heuristic.split && room >= 2 && sum.taps().len() > 3 {
            for part in parts(sum) {
                let rest = sum.plus(&part, -1);
                if part.is_zero() || rest.is_zero() {
                    continue;
                }
                let values = vec![self.find(state, part), self.find(state, rest)];
                self.child(state, at, base, values, None, out);
            }
        }
    }

    /// Predecessors by the word that stored value `at` in a register, where NEWS is free before.
    pub(super) fn before_register(&mut self, state: &State, at: usize, out: &mut Out<'_>) {
        let item = state.live[at].clone();
        for (sum, halved, room) in stores_of(&item.form) {
            let base = Step::into_register(&item, halved);
            if sum.is_zero() {
                self.child(state, Some(at), &base, Vec::new(), None, out);
                return;
            }
            // From registers alone.
            self.sums(state, Some(at), &sum, &base, room, out);
            // With NEWS cells: what the word read from registers besides, if anything.
            let mut others: Vec<Vec<Rc<Item>>> = vec![Vec::new()];
            for other in state.live.iter().chain([&self.input]) {
                if other.hash != item.hash
                    && !others
                        .iter()
                        .any(|o| matches!(&o[..], [one] if one.hash == other.hash))
                {
                    others.push(vec![other.clone()]);
                }
            }
            let old = others.len();
            for place in NEWS_CELLS {
                let weight = sum.at(place);
                let form = LinearForm::new(vec![Tap {
                    y: place.0,
                    x: place.1,
                    weight,
                }]);
                let known = |o: &Vec<Rc<Item>>| matches!(&o[..], [one] if one.form == form);
                if weight != 0 && sum.taps().len() > 1 && !others.iter().any(known) {
                    let new = self.item(form);
                    others.push(vec![new]);
                }
            }
            if room > 2 && self.heuristic.split {
                for i in 1..old {
                    for j in i + 1..old {
                        let pair = [&others[i][0], &others[j][0]].map(Rc::clone);
                        others.push(pair.to_vec());
                    }
                }
            }
            let size = weight(&sum);
            for other in others {
                if other.len() >= room {
                    continue;
                }
                let taken = other
                    .iter()
                    .fold(sum.clone(), |sum, one| sum.plus(&one.form, -1));
                if taken.is_zero() || weight(&taken) > size + 4 * self.task.unit {
                    continue;
                }
                for which in 0..self.shapes.len() {
                    let (mask, places) = &self.shapes[which];
                    if other.len() + places.len() > room {
                        continue;
                    }
                    let Some(news) = taken.divided(places) else {
                        continue;
                    };
                    let base = Step {
                        views: *mask,
                        ..base.clone()
                    };
                    self.child(state, Some(at), &base, other.clone(), Some(news), out);
                }
            }
            // The largest form that the NEWS cells have in common is read from them, the rest from
            // registers.
            for which in 0..self.shapes.len() {
                let (mask, places) = &self.shapes[which];
                if places.len() < 2 || places.len() + 1 > room {
                    continue;
                }
                let mask = *mask;
                let news = sum.common(places);
                if news.is_zero() {
                    continue;
                }
                let mut rest = sum.clone();
                for place in places {
                    rest = rest.plus(&news.shifted(*place), -1);
                }
                if rest.is_zero() || news.taps().len() < 2 {
                    continue;
                }
                let rest = self.find(state, rest);
                let base = Step {
                    views: mask,
                    ..base.clone()
                };
                self.child(state, Some(at), &base, vec![rest], Some(news), out);
            }
        }
    }

    /// Predecessors by a word that stored value `at` from a NEWS cell that a later word reads
    /// again.
    pub(super) fn before_reread(
        &mut self,
        state: &State,
        at: usize,
        news: &Rc<Item>,
        out: &mut Out<'_>,
    ) {
        let item = state.live[at].clone();
        for (sum, halved, room) in stores_of(&item.form) {
            let base = Step::into_register(&item, halved);
            let size = weight(&sum);
            for which in 0..self.shapes.len() {
                let (mask, places) = &self.shapes[which];
                if places.len() > room {
                    continue;
                }
                let mask = *mask;
                let mut rest = sum.clone();
                for place in places {
                    rest = rest.plus(&news.form.shifted(*place), -1);
                }
                let left = weight(&rest);
                let mut values = Vec::new();
                if !rest.is_zero() {
                    if places.len() == room {
                        continue;
                    }
                    let rest = self.find(state, rest);
                    let free = rest.hash == self.input.hash
                        || state.live.iter().any(|i| i.hash == rest.hash);
                    if !free && left >= size {
                        continue;
                    }
                    values.push(rest);
                }
                let base = Step {
                    views: mask,
                    ..base.clone()
                };
                let news = news.form.clone();
                self.child(state, Some(at), &base, values, Some(news), out);
            }
            if !halved {
                let other = self.find(state, sum);
                self.child(
                    state,
                    Some(at),
                    &base,
                    vec![other],
                    Some(news.form.clone()),
                    out,
                );
            }
        }
    }
}

/// The bus sums that store a form, whole or halved, each with the number of sources that a word can
/// have for it.
pub(super) fn stores_of(stored: &LinearForm) -> impl Iterator<Item = (LinearForm, bool, usize)> {
    let whole = (stored.times(-1), false, SOURCES);
    let halved = (stored.times(-2), true, SOURCES_SPLIT);
    [whole, halved]
        .into_iter()
        .filter(|(sum, ..)| sum.is_bounded())
}
