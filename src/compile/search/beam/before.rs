//! Predecessors of a state: the words that may have led to it.
//!
//! The search runs backwards in the order of the program: the state before a word is found after
//! the one behind it. A predecessor is a choice of the held value that the last word stored, and of
//! the sources that could have made it.

use std::rc::Rc;

use super::{
    EXPANDED, Item, Out, Search, State, Step,
    score::{parts, weight},
    view,
};
use crate::{
    compile::intermediate::{
        linear_form::{LinearForm, NEWS_CELLS, Tap},
        plan::{SOURCES, SOURCES_SPLIT},
    },
    isa::Direction,
};

/// A word whose destination is chosen, and whose sources are not.
struct OpenWord<'a> {
    /// The state after it.
    state: &'a State,
    /// Index of the value that it stores in a register, if any.
    at: Option<usize>,
    /// What its sources must sum to.
    sum: &'a LinearForm,
    /// The word so far.
    base: Step,
    /// The most sources that it can have.
    room: usize,
}

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
    fn before_news(&mut self, state: &State, news: &Rc<Item>, out: &mut Out<'_>) {
        for (i, place) in NEWS_CELLS.into_iter().enumerate() {
            // Stored into the neighbour's NEWS cell: the form as seen from the other pixel.
            let to = view(i).map(Direction::opposite);
            let stored = news.form.shifted((-place.0, -place.1));
            if self.task.border && !stored.is_outward(place) {
                continue;
            }
            for (sum, halved, room) in stores_of(&stored) {
                let word = OpenWord {
                    state,
                    at: None,
                    sum: &sum,
                    base: Step {
                        stored: None,
                        news: Some(to),
                        views: 0,
                        values: Vec::new(),
                        halved,
                    },
                    room,
                };
                self.sums(&word, out);
                // The other half can go to a register, where a value like it is held anyway.
                let twin = state.live.iter().position(|item| item.form == stored);
                if halved
                    && let Some(at) = twin
                    && state.live[at].hash != self.input.hash
                {
                    let base = Step {
                        stored: Some(state.live[at].clone()),
                        halved: false,
                        ..word.base
                    };
                    let at = Some(at);
                    self.sums(&OpenWord { at, base, ..word }, out);
                }
            }
        }
    }

    /// Ways to make the sum of `word` from values in registers alone.
    fn sums(&mut self, word: &OpenWord<'_>, out: &mut Out<'_>) {
        // A copy of one value.
        let direct = self.find(word.state, word.sum.clone());
        self.choose(word, vec![direct], out);
        if word.room < 2 {
            return;
        }
        self.sums_of_held(word, out);
        // Twice the same value.
        let taps = word.sum.taps();
        if let Some(half) = word.sum.half()
            && taps.iter().any(|tap| tap.weight.abs() > self.task.unit)
        {
            let half = self.find(word.state, half);
            self.choose(word, vec![half.clone(), half], out);
        }
        // A part that may be a common subexpression, and the rest.
        if self.heuristic.split && taps.len() > 3 {
            for part in parts(word.sum) {
                let rest = word.sum.plus(&part, -1);
                if part.is_zero() || rest.is_zero() {
                    continue;
                }
                let values = vec![self.find(word.state, part), self.find(word.state, rest)];
                self.choose(word, values, out);
            }
        }
    }

    /// The sum as one or two of its [`addends`](Self::addends), and a value for the rest.
    fn sums_of_held(&mut self, word: &OpenWord<'_>, out: &mut Out<'_>) {
        let (addends, held) = self.addends(word);
        let size = weight(word.sum);
        for (i, first) in addends.iter().enumerate() {
            let rest = word.sum.plus(&first.form, -1);
            // What is left must not be larger than the sum, or the search would not come nearer.
            if rest.is_zero() || weight(&rest) > size {
                continue;
            }
            let second = self.find(word.state, rest.clone());
            self.choose(word, vec![first.clone(), second], out);
            if word.room <= 2 || i >= held {
                continue;
            }
            for other in &addends[i + 1..] {
                let rest = rest.plus(&other.form, -1);
                if weight(&rest) >= size {
                    continue;
                }
                let mut values = vec![first.clone(), other.clone()];
                if !rest.is_zero() {
                    values.push(self.find(word.state, rest));
                }
                self.choose(word, values, out);
            }
        }
    }

    /// Values that may be one of the sources of `word`: those held and the input, without the one
    /// that it stores; then single taps near by that the sum needs in any case, or the negated input
    /// where all is at the pixel itself. The number is that of the former.
    fn addends(&self, word: &OpenWord<'_>) -> (Vec<Rc<Item>>, usize) {
        let stored = word.at.map(|at| word.state.live[at].hash);
        let mut addends: Vec<Rc<Item>> = Vec::new();
        for item in word.state.live.iter().chain([&self.input]) {
            let is_known = addends.iter().any(|known| known.hash == item.hash);
            if stored != Some(item.hash) && !is_known {
                addends.push(item.clone());
            }
        }
        let held = addends.len();
        for (y, x) in NEWS_CELLS {
            let weight = word.sum.at((y, x));
            if weight != 0 && word.sum.taps().len() > 1 {
                let form = LinearForm::new(vec![Tap { y, x, weight }]);
                if !addends.iter().any(|known| known.form == form) {
                    addends.push(self.item(form));
                }
            }
        }
        if self.at_home && !addends.iter().any(|known| known.form == self.minus.form) {
            addends.push(self.minus.clone());
        }
        (addends, held)
    }

    /// Adds the predecessor in which `word` has read these registers.
    fn choose(&mut self, word: &OpenWord<'_>, values: Vec<Rc<Item>>, out: &mut Out<'_>) {
        self.child(word.state, word.at, &word.base, values, None, out);
    }

    /// Predecessors by the word that stored value `at` in a register, where NEWS is free before.
    fn before_register(&mut self, state: &State, at: usize, out: &mut Out<'_>) {
        let item = state.live[at].clone();
        for (sum, halved, room) in stores_of(&item.form) {
            let word = OpenWord {
                state,
                at: Some(at),
                sum: &sum,
                base: Step::into_register(&item, halved),
                room,
            };
            if sum.is_zero() {
                self.choose(&word, Vec::new(), out);
                return;
            }
            self.sums(&word, out);
            self.sums_with_news(&word, out);
            self.sums_with_common_news(&word, out);
        }
    }

    /// Ways to make the sum from NEWS cells and at most two registers. For each choice of registers
    /// and of NEWS cells, what NEWS held must be the rest divided by that sum of shifts.
    fn sums_with_news(&mut self, word: &OpenWord<'_>, out: &mut Out<'_>) {
        let (addends, held) = self.addends(word);
        let mut others: Vec<Vec<Rc<Item>>> = vec![Vec::new()];
        others.extend(addends.iter().map(|one| vec![one.clone()]));
        if word.room > 2 && self.heuristic.split {
            for (i, first) in addends[..held].iter().enumerate() {
                for second in &addends[i + 1..held] {
                    others.push(vec![first.clone(), second.clone()]);
                }
            }
        }
        let size = weight(word.sum);
        for other in others {
            if other.len() >= word.room {
                continue;
            }
            let taken = other
                .iter()
                .fold(word.sum.clone(), |sum, one| sum.plus(&one.form, -1));
            if taken.is_zero() || weight(&taken) > size + 4 * self.task.unit {
                continue;
            }
            for which in 0..self.shapes.len() {
                let (mask, places) = &self.shapes[which];
                if other.len() + places.len() > word.room {
                    continue;
                }
                let Some(news) = taken.divided(places) else {
                    continue;
                };
                let base = Step {
                    views: *mask,
                    ..word.base.clone()
                };
                self.child(word.state, word.at, &base, other.clone(), Some(news), out);
            }
        }
    }

    /// Ways to make the sum from several NEWS cells and a register: NEWS held the largest form that
    /// the cells have in common, the register the rest.
    fn sums_with_common_news(&mut self, word: &OpenWord<'_>, out: &mut Out<'_>) {
        for which in 0..self.shapes.len() {
            let (mask, places) = &self.shapes[which];
            if places.len() < 2 || places.len() + 1 > word.room {
                continue;
            }
            let mask = *mask;
            let news = word.sum.common(places);
            if news.is_zero() {
                continue;
            }
            let mut rest = word.sum.clone();
            for place in places {
                rest = rest.plus(&news.shifted(*place), -1);
            }
            if rest.is_zero() || news.taps().len() < 2 {
                continue;
            }
            let rest = self.find(word.state, rest);
            let base = Step {
                views: mask,
                ..word.base.clone()
            };
            self.child(word.state, word.at, &base, vec![rest], Some(news), out);
        }
    }

    /// Predecessors by a word that stored value `at` from a NEWS cell that a later word reads
    /// again.
    fn before_reread(&mut self, state: &State, at: usize, news: &Rc<Item>, out: &mut Out<'_>) {
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
fn stores_of(stored: &LinearForm) -> impl Iterator<Item = (LinearForm, bool, usize)> {
    let whole = (stored.times(-1), false, SOURCES);
    let halved = (stored.times(-2), true, SOURCES_SPLIT);
    [whole, halved]
        .into_iter()
        .filter(|(sum, ..)| sum.is_bounded())
}
