//! The search: from the goals back to the input, word by word.
//!
//! A state is what must be held before the words found so far: values in registers, and perhaps
//! one in NEWS. A step takes the last word away: whatever it stored is given up for what it
//! read. The search keeps the states that look nearest to "the input alone".

use std::{cell::OnceCell, collections::HashSet, rc::Rc};

use super::{
    field::{Field, Tap, VIEWS},
    plan::{Plan, Store, Value, Word},
};
use crate::{isa::Direction, number::signed_digits};

/// What to search for.
#[derive(Clone, Debug)]
pub(super) struct Task {
    /// What must be held in the end.
    pub(super) goals: Vec<Field>,
    /// The input, in units.
    pub(super) unit: i64,
    /// Ordinary registers, that of the input included.
    pub(super) registers: usize,
    /// The goal that ends in the register in which the input begins.
    pub(super) over_input: Option<usize>,
    /// Every value is right up to the border.
    pub(super) border: bool,
}

/// How to search.
#[derive(Clone, Copy, Debug)]
pub(super) struct Taste {
    /// States kept at each depth.
    pub(super) width: usize,
    /// What a digit of a weight beyond the first is thought to cost.
    pub(super) digit: f32,
    /// What a place is thought to cost.
    pub(super) place: f32,
    /// What a halving is thought to cost.
    pub(super) level: f32,
    /// What a value is thought to cost besides.
    pub(super) value: f32,
    /// Values are thought to be made from each other.
    pub(super) related: bool,
    /// New values that are parts of others are tried.
    pub(super) split: bool,
}

/// Sources that one word takes, and that one word takes which stores in two parts: the
/// vendor's `bus` and `bus2`.
pub(super) const SOURCES: usize = 4;
const SOURCES_SPLIT: usize = 2;

/// Values of a state that are tried as the last one stored.
const EXPANDED: usize = 2;

#[derive(Debug)]
struct Item {
    field: Field,
    hash: u64,
    /// What it is thought to cost by itself.
    cost: OnceCell<f32>,
}

#[derive(Clone, Debug)]
struct State {
    live: Vec<Rc<Item>>,
    news: Option<Rc<Item>>,
    /// The goal over the input is still to be written.
    open: bool,
}

#[derive(Clone, Debug)]
struct Step {
    stored: Option<Rc<Item>>,
    /// Whether it stored in NEWS, and whose.
    #[expect(
        clippy::option_option,
        reason = "none of the neighbours is the pixel itself"
    )]
    news: Option<Option<Direction>>,
    views: u8,
    values: Vec<Rc<Item>>,
    halved: bool,
}

impl Step {
    /// A word that stored in a register alone; what it read is not said yet.
    fn into_register(stored: &Rc<Item>, halved: bool) -> Self {
        Self {
            stored: Some(stored.clone()),
            news: None,
            views: 0,
            values: Vec::new(),
            halved,
        }
    }
}

struct Node {
    state: State,
    parent: u32,
    step: Option<Step>,
}

struct Child {
    score: f32,
    node: Node,
}

/// What a search found, and how many states it looked at.
pub(super) struct Found {
    pub(super) plan: Option<Plan>,
    pub(super) seen: u64,
}

/// Of a place of [`VIEWS`].
const fn view(i: usize) -> Option<Direction> {
    match i {
        0 => None,
        i => Some(Direction::ALL[i - 1]),
    }
}

/// Searches for a plan of fewer than `below` words; looks at `budget` states at most.
pub(super) fn search(task: &Task, taste: Taste, below: usize, budget: u64) -> Found {
    let mut search = Search::new(task, taste);
    let plan = search.run(below, budget);
    Found {
        plan,
        seen: search.seen,
    }
}

struct Search<'a> {
    task: &'a Task,
    taste: Taste,
    input: Rc<Item>,
    over: Option<Field>,
    known: HashSet<u64>,
    seen: u64,
    /// The sets of NEWS cells that a word can read.
    shapes: Vec<(u8, Vec<(i16, i16)>)>,
}

impl<'a> Search<'a> {
    fn new(task: &'a Task, taste: Taste) -> Self {
        let shape = |mask: u8| {
            let places = (0..5).filter(|i| mask >> i & 1 == 1).map(|i| VIEWS[i]);
            (mask, places.collect::<Vec<_>>())
        };
        let mut search = Self {
            task,
            taste,
            input: Rc::new(Item {
                field: Field::unit(task.unit),
                hash: 0,
                cost: OnceCell::new(),
            }),
            over: task
                .over_input
                .and_then(|goal| task.goals.get(goal).cloned()),
            known: HashSet::new(),
            seen: 0,
            shapes: (1u8..32)
                .map(shape)
                .filter(|(_, places)| places.len() <= SOURCES)
                .collect(),
        };
        search.input = search.item(Field::unit(task.unit));
        search
    }

    #[expect(clippy::unused_self, reason = "as find, which does look")]
    fn item(&self, field: Field) -> Rc<Item> {
        Rc::new(Item {
            hash: field.fingerprint(),
            cost: OnceCell::new(),
            field,
        })
    }

    fn cost(&self, item: &Item) -> f32 {
        *item.cost.get_or_init(|| self.own(&item.field))
    }

    /// The item of a field: the one that is already live, or a new one.
    fn find(&self, state: &State, field: Field) -> Rc<Item> {
        if field == self.input.field {
            return self.input.clone();
        }
        let known = state.live.iter().find(|item| item.field == field);
        known.cloned().unwrap_or_else(|| self.item(field))
    }

    /// What a value is thought to cost by itself.
    fn own(&self, field: &Field) -> f32 {
        let taps = field.taps();
        if taps.is_empty() {
            return 1.0;
        }
        let unit = self.task.unit;
        if let [only] = taps
            && (only.y, only.x) == (0, 0)
            && only.weight.abs() == unit
        {
            return if only.weight == unit { 0.0 } else { 1.0 };
        }
        let digits: u32 = taps
            .iter()
            .map(|tap| signed_digits(tap.weight).saturating_sub(1))
            .sum();
        // From the unit down by halves, up by doubles, all weights of a value together.
        let one = i64::from(unit.trailing_zeros());
        let low = taps.iter().map(|tap| tap.weight.trailing_zeros()).min();
        let high = taps
            .iter()
            .map(|tap| tap.weight.unsigned_abs().ilog2())
            .max();
        let down = (one - i64::from(low.unwrap_or(0))).max(0);
        let up = (i64::from(high.unwrap_or(0)) - one).max(0);
        let levels = down as f32 + 2.5 * up as f32;
        self.taste.value
            + self.taste.digit * digits as f32
            + self.taste.place * spread(taps)
            + self.taste.level * levels
    }

    fn score(&self, state: &State) -> f32 {
        let mut items: Vec<(f32, &Rc<Item>)> = state
            .live
            .iter()
            .map(|item| (self.cost(item), item))
            .collect();
        items.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.hash.cmp(&b.1.hash)));
        let mut total = 0.0;
        let mut base: Vec<&Field> = vec![&self.input.field];
        for (own, item) in items {
            let mut cost = own;
            if cost > 1.0 {
                for other in &base {
                    cost = cost.min(self.from(&item.field, other));
                }
            }
            total += cost;
            if item.hash != self.input.hash {
                base.push(&item.field);
            }
        }
        if let Some(news) = &state.news {
            let stored = |other: &&&Field| {
                VIEWS
                    .iter()
                    .any(|place| news.field.is_seen(other, *place, -1))
            };
            let mut least = if base.iter().any(|other| stored(&other)) {
                0.0
            } else {
                self.cost(news)
            };
            if least > 1.0 && self.taste.related {
                for other in &base[1..] {
                    least = least.min(self.from(&news.field, other));
                }
            }
            total += 1.0 + least;
        }
        total
    }

    /// What a value is thought to cost once another is there.
    fn from(&self, field: &Field, other: &Field) -> f32 {
        for place in VIEWS {
            let own = place == (0, 0);
            if field.is_seen(other, place, -1) {
                return if own { 1.0 } else { 2.0 };
            }
            if field.is_seen(other, place, 1) {
                return 2.0;
            }
        }
        if field.is_seen(other, (0, 0), 2) || field.is_seen(other, (0, 0), -2) {
            return 3.0;
        }
        let mut least = f32::INFINITY;
        if self.taste.related && other.taps().len() > 1 {
            for times in [1, -1] {
                let rest = field.plus(other, times);
                least = least.min(1.5 + self.own(&rest));
            }
        }
        least
    }

    fn run(&mut self, below: usize, budget: u64) -> Option<Plan> {
        let task = self.task;
        let mut live = Vec::new();
        for goal in &task.goals {
            let item = if *goal == self.input.field {
                self.input.clone()
            } else {
                self.item(goal.clone())
            };
            live.push(item);
        }
        let start = State {
            live,
            news: None,
            open: self.over.is_some(),
        };
        let mut levels = vec![vec![Node {
            state: start,
            parent: 0,
            step: None,
        }]];
        loop {
            let depth = levels.len() - 1;
            let level = levels.last()?;
            if let Some(at) = level.iter().position(|node| self.done(&node.state)) {
                return self.plan(&levels, at);
            }
            if depth + 1 >= below || level.is_empty() || self.seen > budget {
                return None;
            }
            let mut children = Vec::new();
            for (parent, node) in level.iter().enumerate() {
                let mut out = Out {
                    parent: parent as u32,
                    children: &mut children,
                };
                self.expand(&node.state, &mut out);
                if out.children.len() > 8 * self.taste.width + 4096 {
                    trim(out.children, self.taste.width);
                }
            }
            trim(&mut children, self.taste.width);
            levels.push(children.into_iter().map(|child| child.node).collect());
        }
    }

    fn done(&self, state: &State) -> bool {
        let only = |item: &Rc<Item>| item.hash == self.input.hash;
        let copy = state.live.len() <= 1 && state.live.iter().all(only);
        state.news.is_none()
            && copy
            && (!state.open || self.over.as_ref() == Some(&self.input.field))
    }

    /// All words that can have been the last one.
    fn expand(&mut self, state: &State, out: &mut Out<'_>) {
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
                // What is easily made can as well be made earlier.
                None if done.len() > EXPANDED => break,
                None => self.before_register(state, at, out),
                Some(news) => self.before_second(state, at, news, out),
            }
        }
    }

    /// The word that filled NEWS.
    fn before_news(&mut self, state: &State, news: &Rc<Item>, out: &mut Out<'_>) {
        for (i, place) in VIEWS.into_iter().enumerate() {
            // Stored into the neighbour in this direction: seen from the other side.
            let to = view(i).map(Direction::opposite);
            let stored = news.field.seen((-place.0, -place.1));
            if self.task.border && !stored.leads(place) {
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
                    let twin = state.live.iter().position(|item| item.field == stored);
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

    /// Ways to make a sum from values in registers alone.
    fn sums(
        &mut self,
        state: &State,
        at: Option<usize>,
        sum: &Field,
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
        // Single taps near by that this would need anyway.
        for place in VIEWS {
            let weight = sum.at(place);
            if weight != 0 && sum.taps().len() > 1 {
                let tap = Tap {
                    y: place.0,
                    x: place.1,
                    weight,
                };
                let field = Field::of(vec![tap]);
                if !firsts.iter().any(|known| known.field == field) {
                    firsts.push(self.item(field));
                }
            }
        }
        let size = weight(sum);
        for (i, first) in firsts.iter().enumerate() {
            let rest = sum.plus(&first.field, -1);
            if rest.is_zero() || weight(&rest) > size {
                continue;
            }
            let second = self.find(state, rest.clone());
            self.child(state, at, base, vec![first.clone(), second], None, out);
            if room > 2 && i < old {
                for other in &firsts[i + 1..] {
                    let rest = rest.plus(&other.field, -1);
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
        if self.taste.split && room >= 2 && sum.taps().len() > 3 {
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

    /// The word that stored a register, when NEWS is free to hold what it likes before.
    fn before_register(&mut self, state: &State, at: usize, out: &mut Out<'_>) {
        let item = state.live[at].clone();
        for (sum, halved, room) in stores_of(&item.field) {
            let base = Step::into_register(&item, halved);
            if sum.is_zero() {
                self.child(state, Some(at), &base, Vec::new(), None, out);
                return;
            }
            // From registers alone.
            self.sums(state, Some(at), &sum, &base, room, out);
            // With NEWS: what else the word read, if anything.
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
            for place in VIEWS {
                let weight = sum.at(place);
                let field = Field::of(vec![Tap {
                    y: place.0,
                    x: place.1,
                    weight,
                }]);
                let known = |o: &Vec<Rc<Item>>| matches!(&o[..], [one] if one.field == field);
                if weight != 0 && sum.taps().len() > 1 && !others.iter().any(known) {
                    let new = self.item(field);
                    others.push(vec![new]);
                }
            }
            if room > 2 && self.taste.split {
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
                    .fold(sum.clone(), |sum, one| sum.plus(&one.field, -1));
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
            // What several NEWS cells have in common, and the rest.
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
                    rest = rest.plus(&news.seen(*place), -1);
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

    /// A word that stored a register from a NEWS that is read again later.
    fn before_second(&mut self, state: &State, at: usize, news: &Rc<Item>, out: &mut Out<'_>) {
        let item = state.live[at].clone();
        for (sum, halved, room) in stores_of(&item.field) {
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
                    rest = rest.plus(&news.field.seen(*place), -1);
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
                let news = news.field.clone();
                self.child(state, Some(at), &base, values, Some(news), out);
            }
            if !halved {
                let other = self.find(state, sum);
                self.child(
                    state,
                    Some(at),
                    &base,
                    vec![other],
                    Some(news.field.clone()),
                    out,
                );
            }
        }
    }

    /// Adds a state before a word, if it is one.
    fn child(
        &mut self,
        state: &State,
        at: Option<usize>,
        base: &Step,
        values: Vec<Rc<Item>>,
        news: Option<Field>,
        out: &mut Out<'_>,
    ) {
        let mut live = state.live.clone();
        let mut open = state.open;
        if let Some(at) = at {
            let gone = live.remove(at);
            if self.over.as_ref() == Some(&gone.field) {
                open = false;
            }
        }
        for (i, value) in values.iter().enumerate() {
            let copies = 1 + values[..i].iter().filter(|v| v.hash == value.hash).count();
            if live.iter().filter(|v| v.hash == value.hash).count() < copies {
                live.push(value.clone());
            }
        }
        // Where the input lies, the goal that ends there cannot be yet.
        if state.open && live.iter().any(|item| item.hash == self.input.hash) {
            return;
        }
        // While the word runs, its target and the part that nobody reads are held as well.
        let spare = base.halved && (base.news.is_some() || base.views != 0 || state.news.is_some());
        let during = live.len() + usize::from(at.is_some()) + usize::from(spare);
        if during > self.task.registers {
            return;
        }
        if self.task.border
            && let Some(news) = &news
        {
            let mask = base.views;
            let outward = (0..5)
                .filter(|i| mask >> i & 1 == 1)
                .all(|i| news.leads(VIEWS[i]));
            if !outward {
                return;
            }
        }
        if news.as_ref().is_some_and(|news| !news.is_tame()) {
            return;
        }
        // Large fields take longer to look at.
        self.seen += 1 + live
            .iter()
            .map(|item| item.field.taps().len())
            .max()
            .unwrap_or(0) as u64
            / 16;
        let news = news.map(|field| match &state.news {
            Some(old) if old.field == field => old.clone(),
            _ => self.item(field),
        });
        let mut hash = u64::from(open);
        for item in &live {
            hash = hash.wrapping_add(item.hash.wrapping_mul(0x9E37_79B9_7F4A_7C15));
        }
        if let Some(news) = &news {
            hash = hash.wrapping_add(
                news.hash
                    .rotate_left(23)
                    .wrapping_mul(0xC2B2_AE3D_27D4_EB4F),
            );
        }
        if !self.known.insert(hash) {
            return;
        }
        let before = State { live, news, open };
        let score = self.score(&before);
        let step = Step {
            values,
            ..base.clone()
        };
        out.children.push(Child {
            score,
            node: Node {
                state: before,
                parent: out.parent,
                step: Some(step),
            },
        });
    }

    /// The words from a state that is the input alone to the goals.
    fn plan(&self, levels: &[Vec<Node>], at: usize) -> Option<Plan> {
        let mut plan = Plan::default();
        let mut held: Vec<(&Field, Value)> = vec![(&self.input.field, 0)];
        let mut node = levels.last()?.get(at)?;
        for level in levels.iter().rev().skip(1) {
            let step = node.step.as_ref()?;
            let mut values: Vec<Value> = Vec::new();
            for item in &step.values {
                let found = held
                    .iter()
                    .rev()
                    .find(|(field, value)| **field == item.field && !values.contains(value))?;
                values.push(found.1);
            }
            let store = match (&step.stored, step.news) {
                (Some(_), Some(to)) => Store::Both(to),
                (None, Some(to)) => Store::News(to),
                (_, None) => Store::Register,
            };
            plan.words.push(Word {
                store,
                views: (0..5)
                    .filter(|i| step.views >> i & 1 == 1)
                    .map(view)
                    .collect(),
                values,
                halved: step.halved,
            });
            let parent = level.get(node.parent as usize)?;
            if let Some(item) = &step.stored {
                let next = plan
                    .words
                    .iter()
                    .filter(|word| !matches!(word.store, Store::News(_)))
                    .count();
                held.push((&item.field, next));
            }
            // What nobody reads any more is forgotten, the oldest copies first.
            let mut kept = Vec::new();
            let mut wanted: Vec<&Field> = parent.state.live.iter().map(|i| &i.field).collect();
            for entry in held.into_iter().rev() {
                if let Some(i) = wanted.iter().position(|field| *field == entry.0) {
                    wanted.swap_remove(i);
                    kept.push(entry);
                }
            }
            kept.reverse();
            held = kept;
            node = parent;
        }
        for goal in &self.task.goals {
            let free = held
                .iter()
                .find(|(field, value)| *field == goal && !plan.goals.contains(value));
            plan.goals.push(free?.1);
        }
        Some(plan)
    }
}

struct Out<'a> {
    parent: u32,
    children: &'a mut Vec<Child>,
}

/// The sums of a bus that store a field, whole or halved, and how many sources each can have.
fn stores_of(stored: &Field) -> impl Iterator<Item = (Field, bool, usize)> {
    let whole = (stored.times(-1), false, SOURCES);
    let halved = (stored.times(-2), true, SOURCES_SPLIT);
    [whole, halved]
        .into_iter()
        .filter(|(sum, ..)| sum.is_tame())
}

/// Keeps the best, in an order that does not depend on anything else.
fn trim(children: &mut Vec<Child>, width: usize) {
    let better = |a: &Child, b: &Child| a.score.total_cmp(&b.score);
    if children.len() > width && width > 0 {
        children.select_nth_unstable_by(width - 1, better);
        children.truncate(width);
    }
    children.sort_by(better);
}

fn weight(field: &Field) -> i64 {
    field.taps().iter().map(|tap| tap.weight.abs()).sum()
}

/// How far one has to walk from the pixel to see all places, about: the shortest tree.
fn spread(taps: &[Tap]) -> f32 {
    let apart = |a: &Tap, b: &Tap| (a.y - b.y).abs() + (a.x - b.x).abs();
    if taps.len() > 40 {
        let near = taps.iter().map(|tap| tap.y.abs() + tap.x.abs()).min();
        return taps.len() as f32 + f32::from(near.unwrap_or(0));
    }
    let mut far: [i16; 40] = [0; 40];
    for (far, tap) in far.iter_mut().zip(taps) {
        *far = tap.y.abs() + tap.x.abs();
    }
    let mut left: Vec<usize> = (0..taps.len()).collect();
    let mut total = 0;
    while let Some((at, &i)) = left.iter().enumerate().min_by_key(|(_, i)| far[**i]) {
        total += far[i];
        left.swap_remove(at);
        for &j in &left {
            far[j] = far[j].min(apart(&taps[i], &taps[j]));
        }
    }
    f32::from(total)
}

/// Parts of a sum that may be worth a value of their own.
fn parts(sum: &Field) -> Vec<Field> {
    let some = |keep: &dyn Fn(&Tap) -> bool| {
        Field::of(sum.taps().iter().copied().filter(|tap| keep(tap)).collect())
    };
    let mut parts = vec![
        some(&|tap| tap.weight > 0),
        some(&|tap| tap.y == 0),
        some(&|tap| tap.x == 0),
        some(&|tap| tap.y < 0),
        some(&|tap| tap.x < 0),
    ];
    // The same weight everywhere, under what is left: a box and the difference to it.
    let least = sum.taps().iter().map(|tap| tap.weight.abs()).min();
    if let Some(least) = least {
        let flat = sum.taps().iter().map(|tap| Tap {
            weight: least * tap.weight.signum(),
            ..*tap
        });
        parts.push(Field::of(flat.collect()));
        for sign in [1, -1] {
            let rows = sum.taps().iter().map(|tap| tap.y.abs()).max().unwrap_or(0);
            let columns = sum.taps().iter().map(|tap| tap.x.abs()).max().unwrap_or(0);
            if (rows.max(columns)) <= 5 {
                let places = (-rows..=rows).flat_map(|y| (-columns..=columns).map(move |x| (y, x)));
                let commonest = places
                    .clone()
                    .map(|p| sum.at(p) * i64::from(sign))
                    .filter(|w| *w > 0);
                let mut weights: Vec<i64> = commonest.collect();
                weights.sort_unstable();
                if let Some(&middle) = weights.get(weights.len() / 2) {
                    let whole = places.map(|(y, x)| Tap {
                        y,
                        x,
                        weight: middle * i64::from(sign),
                    });
                    parts.push(Field::of(whole.collect()));
                }
            }
        }
    }
    parts.sort_unstable();
    parts.dedup();
    parts
}
