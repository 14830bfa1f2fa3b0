//! Beam search: from the goals back to the input, word by word.
//!
//! A state is the set of values that must be held before the words found so far: in registers, and
//! perhaps one in NEWS. A step removes the last word: the value that it stored is replaced by those
//! that it read. The beam keeps the states whose estimated cost is lowest; the search ends at the
//! state "the input alone".

mod before;
mod score;

use std::{cell::OnceCell, collections::HashSet, rc::Rc};

use crate::{
    compile::intermediate::{
        linear_form::{LinearForm, NEWS_CELLS},
        plan::{Plan, SOURCES, Store, Value, Word, values_made},
    },
    isa::Direction,
    rng::GOLDEN,
    stop::Stop,
};

/// The task of one search.
#[derive(Clone, Debug)]
pub(super) struct Task {
    /// What must be held in the end.
    pub(super) goals: Vec<LinearForm>,
    /// The input, in units.
    pub(super) unit: i64,
    /// Ordinary registers that may be used, that of the input included.
    pub(super) registers: usize,
    /// Index of the goal that ends in the register in which the input begins, if one does.
    pub(super) over_input: Option<usize>,
    /// Whether every value must be right up to the border.
    pub(super) border: bool,
    /// Whether to give up.
    pub(super) stop: Stop,
}

/// The estimated costs that order the beam, and its width.
#[derive(Clone, Copy, Debug)]
pub(super) struct Heuristic {
    /// States kept at each depth.
    pub(super) width: usize,
    /// Estimated words for each digit of a weight beyond the first.
    pub(super) digit: f32,
    /// Estimated words for each place of the kernel.
    pub(super) place: f32,
    /// Estimated words for each halving level.
    pub(super) level: f32,
    /// Estimated words for each further value.
    pub(super) value: f32,
    /// Whether the estimate allows for values made from each other.
    pub(super) related: bool,
    /// Whether parts of a sum are tried as new values.
    pub(super) split: bool,
}

/// How many values of a state are tried as the one that was stored last.
const EXPANDED: usize = 2;

/// A value that must be held.
#[derive(Debug)]
struct Item {
    form: LinearForm,
    hash: u64,
    /// Estimated words to make it from the input alone, once computed.
    cost: OnceCell<f32>,
}

/// The values that must be held before the words found so far.
#[derive(Clone, Debug)]
struct State {
    live: Vec<Rc<Item>>,
    news: Option<Rc<Item>>,
    /// The goal over the input is still to be written.
    open: bool,
}

/// One bus word, found backwards.
#[derive(Clone, Debug)]
struct Step {
    /// The value that it stored in a register, if any.
    stored: Option<Rc<Item>>,
    /// Whether it stored in NEWS, and whose.
    #[expect(
        clippy::option_option,
        reason = "none of the neighbours is the pixel itself"
    )]
    news: Option<Option<Direction>>,
    /// The NEWS cells that it read, as a bit mask over [`NEWS_CELLS`].
    views: u8,
    values: Vec<Rc<Item>>,
    halved: bool,
}

impl Step {
    /// A word that stored in a register alone, its sources still to be added.
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

/// The direction of an entry of [`NEWS_CELLS`].
const fn view(i: usize) -> Option<Direction> {
    match i {
        0 => None,
        i => Some(Direction::ALL[i - 1]),
    }
}

/// Searches for a plan of fewer than `below` words; looks at `budget` states at most.
pub(super) fn search(task: &Task, heuristic: Heuristic, below: usize, budget: u64) -> Found {
    let mut search = Search::new(task, heuristic);
    let plan = search.run(below, budget);
    Found {
        plan,
        seen: search.seen,
    }
}

struct Search<'a> {
    task: &'a Task,
    heuristic: Heuristic,
    input: Rc<Item>,
    /// The negated input.
    minus: Rc<Item>,
    /// Whether all goals are multiples of the input.
    at_home: bool,
    /// The goal that ends in the register of the input.
    over: Option<LinearForm>,
    /// Hashes of the states seen before.
    visited: HashSet<u64>,
    seen: u64,
    /// The sets of NEWS cells that a word can read, each as a mask and its offsets.
    shapes: Vec<(u8, Vec<(i16, i16)>)>,
}

impl<'a> Search<'a> {
    fn new(task: &'a Task, heuristic: Heuristic) -> Self {
        let shape = |mask: u8| {
            let places = (0..5).filter(|i| mask >> i & 1 == 1).map(|i| NEWS_CELLS[i]);
            (mask, places.collect::<Vec<_>>())
        };
        let none = Rc::new(Item {
            form: LinearForm::unit(task.unit),
            hash: 0,
            cost: OnceCell::new(),
        });
        let mut taps = task.goals.iter().flat_map(LinearForm::taps);
        let mut search = Self {
            task,
            heuristic,
            input: none.clone(),
            minus: none,
            at_home: taps.all(|tap| (tap.y, tap.x) == (0, 0)),
            over: task
                .over_input
                .and_then(|goal| task.goals.get(goal).cloned()),
            visited: HashSet::new(),
            seen: 0,
            shapes: (1u8..32)
                .map(shape)
                .filter(|(_, places)| places.len() <= SOURCES)
                .collect(),
        };
        search.input = search.item(LinearForm::unit(task.unit));
        search.minus = search.item(LinearForm::unit(-task.unit));
        search
    }

    fn run(&mut self, below: usize, budget: u64) -> Option<Plan> {
        let task = self.task;
        let mut live = Vec::new();
        for goal in &task.goals {
            let item = if *goal == self.input.form {
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
            let is_over = self.seen > budget || task.stop.is_asked();
            if depth + 1 >= below || level.is_empty() || is_over {
                return None;
            }
            let mut children = Vec::new();
            for (parent, node) in level.iter().enumerate() {
                let mut out = Out {
                    parent: parent as u32,
                    children: &mut children,
                };
                self.expand(&node.state, &mut out);
                if out.children.len() > 8 * self.heuristic.width + 4096 {
                    trim(out.children, self.heuristic.width);
                }
            }
            trim(&mut children, self.heuristic.width);
            levels.push(children.into_iter().map(|child| child.node).collect());
        }
    }

    fn done(&self, state: &State) -> bool {
        let only = |item: &Rc<Item>| item.hash == self.input.hash;
        let copy = state.live.len() <= 1 && state.live.iter().all(only);
        state.news.is_none()
            && copy
            && (!state.open || self.over.as_ref() == Some(&self.input.form))
    }

    /// Adds the state before a word, unless it is impossible or was seen.
    fn child(
        &mut self,
        state: &State,
        at: Option<usize>,
        base: &Step,
        values: Vec<Rc<Item>>,
        news: Option<LinearForm>,
        out: &mut Out<'_>,
    ) {
        // Before the word its target is free, and its sources are held.
        let mut live = state.live.clone();
        let mut open = state.open;
        if let Some(at) = at {
            let gone = live.remove(at);
            if self.over.as_ref() == Some(&gone.form) {
                open = false;
            }
        }
        for (i, value) in values.iter().enumerate() {
            let copies = 1 + values[..i].iter().filter(|v| v.hash == value.hash).count();
            if live.iter().filter(|v| v.hash == value.hash).count() < copies {
                live.push(value.clone());
            }
        }
        // Where the input lies, the goal that ends there cannot be held yet.
        if state.open && live.iter().any(|item| item.hash == self.input.hash) {
            return;
        }
        // Register pressure: while the word runs, its target and an unread half are held as well.
        let spare = base.halved && (base.news.is_some() || base.views != 0 || state.news.is_some());
        let during = live.len() + usize::from(at.is_some()) + usize::from(spare);
        if during > self.task.registers {
            return;
        }
        // Right up to the border: a form may be read from a neighbour only where no tap points back
        // from beyond the array.
        if self.task.border
            && let Some(news) = &news
        {
            let mask = base.views;
            let outward = (0..5)
                .filter(|i| mask >> i & 1 == 1)
                .all(|i| news.is_outward(NEWS_CELLS[i]));
            if !outward {
                return;
            }
        }
        if news.as_ref().is_some_and(|news| !news.is_bounded()) {
            return;
        }
        // The budget counts large forms more than once, as they take longer to look at.
        self.seen += 1 + live
            .iter()
            .map(|item| item.form.taps().len())
            .max()
            .unwrap_or(0) as u64
            / 16;
        let news = news.map(|form| match &state.news {
            Some(old) if old.form == form => old.clone(),
            _ => self.item(form),
        });
        // A state that another order of words has led to is kept once.
        // The sum does not depend on the order of the values.
        let mut hash = u64::from(open);
        for item in &live {
            hash = hash.wrapping_add(item.hash.wrapping_mul(GOLDEN));
        }
        if let Some(news) = &news {
            hash = hash.wrapping_add(
                news.hash
                    .rotate_left(23)
                    .wrapping_mul(0xC2B2_AE3D_27D4_EB4F),
            );
        }
        if !self.visited.insert(hash) {
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
        let mut held: Vec<(&LinearForm, Value)> = vec![(&self.input.form, 0)];
        let mut node = levels.last()?.get(at)?;
        for level in levels.iter().rev().skip(1) {
            let step = node.step.as_ref()?;
            let mut values: Vec<Value> = Vec::new();
            for item in &step.values {
                let found = held
                    .iter()
                    .rev()
                    .find(|(form, value)| **form == item.form && !values.contains(value))?;
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
                held.push((&item.form, values_made(&plan.words)));
            }
            // Values that nobody reads any more are dropped, the oldest copies first.
            let mut kept = Vec::new();
            let mut wanted: Vec<&LinearForm> = parent.state.live.iter().map(|i| &i.form).collect();
            for entry in held.into_iter().rev() {
                if let Some(i) = wanted.iter().position(|form| *form == entry.0) {
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
                .find(|(form, value)| *form == goal && !plan.goals.contains(value));
            plan.goals.push(free?.1);
        }
        Some(plan)
    }
}

/// Collects the predecessors of a state.
struct Out<'a> {
    parent: u32,
    children: &'a mut Vec<Child>,
}

/// Keeps the `width` best; ties are broken by content, so that the result does not depend on the
/// order of work.
fn trim(children: &mut Vec<Child>, width: usize) {
    let better = |a: &Child, b: &Child| a.score.total_cmp(&b.score);
    if children.len() > width && width > 0 {
        children.select_nth_unstable_by(width - 1, better);
        children.truncate(width);
    }
    children.sort_by(better);
}
