//! The search for a tour: a beam over words, forwards, from the first sum to the pixel itself.

use std::collections::HashSet;

use super::{direction, footprint::Footprint};
use crate::{
    compile::{
        construction::plan_builder::{PlanBuilder, Sum},
        intermediate::{
            linear_form::NEWS_CELLS,
            plan::{Plan, SOURCES, Value},
            signed_digit::{Digit, Place},
        },
    },
    rng::GOLDEN,
};

/// Digits that are added before the sum is halved, or of another goal.
#[derive(Clone, Debug)]
pub(super) struct Stage {
    pub(super) goal: usize,
    pub(super) digits: Vec<PlacedDigit>,
    /// Whether the sum is a goal once they are added.
    pub(super) ends: bool,
}

/// A digit, and where it is added.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedDigit {
    pub(super) place: Place,
    pub(super) digit: Digit,
}

/// What becomes of a sum once all its digits are added.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scaled {
    /// Doublings, and halvings.
    pub(super) up: usize,
    pub(super) down: usize,
    /// Whether it is doubled step by step, which takes words instead of a register.
    pub(super) steps: bool,
}

impl Scaled {
    /// Whether the scaling negates: every store does.
    const fn turns(self) -> bool {
        let doubled = if self.up > 0 && !self.steps {
            self.up + 1
        } else {
            0
        };
        (doubled + self.down) % 2 == 1
    }
}

/// What is to be done, and in how many registers.
#[derive(Clone, Debug)]
pub(super) struct Task {
    pub(super) stages: Vec<Stage>,
    /// For each goal, in the order of the stages.
    pub(super) scaled: Vec<Scaled>,
    /// The place of each in the plan's list of goals.
    pub(super) order: Vec<usize>,
    pub(super) registers: usize,
    /// Whether the last goal ends in the register of the input.
    pub(super) over_input: bool,
}

/// Digits of a stage that are left to add.
type Left = [u64; 4];

/// The most digits of a stage.
pub(super) const MOST_DIGITS: usize = 256;

/// Where the running sum is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum At {
    Nowhere,
    News,
    Register,
}

#[derive(Clone, Copy, Debug)]
struct State {
    /// The place of the kernel to which the input belongs if it is added now.
    cursor: Place,
    at: At,
    /// Whether the negated sum is held.
    negative: bool,
    stage: u16,
    left: Left,
}

/// What a word does with the sum.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// Into a NEWS cell.
    Sent(usize),
    /// From a NEWS cell into a register.
    Read(usize),
    /// Into another register.
    Stored,
    /// Halved, as often as the footprint has exponents.
    Halved,
}

#[derive(Clone, Copy, Debug)]
struct Step {
    kind: Kind,
    /// The copies that it adds, as a mask.
    adds: u16,
    /// Whether it begins a sum.
    begins: bool,
}

struct Node {
    state: State,
    /// The words and the number of the node before it.
    parent: (u32, u32),
    step: Option<Step>,
}

/// A search of one footprint.
pub(super) struct Search<'a> {
    task: &'a Task,
    footprint: &'a Footprint,
    /// The place of the first entry of a table, and its rows and columns.
    first: Place,
    size: (usize, usize),
    /// For each stage, cursor and copy the digit that it adds there.
    table: Vec<u16>,
    /// Digits of the stages behind each.
    behind: Vec<u32>,
    /// Nodes looked at.
    pub(super) seen: u64,
}

/// Digits of a stage whose stops are estimated one by one.
const CLOSELY: usize = 64;

/// No digit.
const NONE: u16 = u16::MAX;

impl<'a> Search<'a> {
    pub(super) fn new(task: &'a Task, footprint: &'a Footprint) -> Self {
        let all = || task.stages.iter().flat_map(|stage| &stage.digits);
        let copies = &footprint.copies;
        let range = |axis: fn(&Place) -> i16| {
            let places = || all().map(|placed| axis(&placed.place));
            let own = || copies.iter().map(|copy| axis(&copy.place));
            let low = places().min().unwrap_or(0).min(0) - own().max().unwrap_or(0) - 1;
            let high = places().max().unwrap_or(0).max(0) - own().min().unwrap_or(0) + 1;
            (low, (high - low + 1) as usize)
        };
        let ((top, rows), (left, columns)) = (range(|place| place.0), range(|place| place.1));
        let mut search = Self {
            task,
            footprint,
            first: (top, left),
            size: (rows, columns),
            table: vec![NONE; task.stages.len() * rows * columns * copies.len()],
            behind: Vec::new(),
            seen: 0,
        };
        for (number, stage) in task.stages.iter().enumerate() {
            for (i, PlacedDigit { place, digit }) in stage.digits.iter().enumerate() {
                for (c, copy) in copies.iter().enumerate() {
                    let cursor = (place.0 - copy.place.0, place.1 - copy.place.1);
                    if copy.halved == digit.halved
                        && let Some(at) = search.row(number, cursor)
                    {
                        search.table[at + c] = i as u16;
                    }
                }
            }
            let later = task.stages[number + 1..].iter();
            let behind = later.map(|stage| stage.digits.len() as u32).sum();
            search.behind.push(behind);
        }
        search
    }

    /// Where the digits of a cursor are in the table.
    fn row(&self, stage: usize, cursor: Place) -> Option<usize> {
        let (rows, columns) = self.size;
        let y = usize::try_from(cursor.0 - self.first.0).ok()?;
        let x = usize::try_from(cursor.1 - self.first.1).ok()?;
        let inside = y < rows && x < columns;
        inside.then_some(((stage * rows + y) * columns + x) * self.footprint.copies.len())
    }

    /// The words of a tour at least: its copies, and a stop for so many digits as there are copies.
    pub(super) fn estimate(&self) -> usize {
        let copies = self.footprint.copies.len();
        let mut words = self.footprint.words();
        for (number, stage) in self.task.stages.iter().enumerate() {
            if stage.digits.len() > CLOSELY {
                words += 2 * stage.digits.len().div_ceil(copies);
                continue;
            }
            // Greedily: each stop where most is left to add.
            let mut left = all_of(stage);
            while left != [0; 4] {
                let (rows, columns) = self.size;
                let cells = 0..rows * columns;
                let most = cells.map(|cell| {
                    let at = (number * rows * columns + cell) * copies;
                    let mut taken = [0; 4];
                    for digit in &self.table[at..at + copies] {
                        if *digit != NONE && has(&left, *digit) {
                            put(&mut taken, *digit);
                        }
                    }
                    taken
                });
                let Some(taken) = most.max_by_key(count) else {
                    break;
                };
                for (left, taken) in left.iter_mut().zip(taken) {
                    *left &= !taken;
                }
                words += 2;
            }
        }
        words
    }

    /// The shortest tour of fewer than `below` words, its scaling not counted, among the `width`
    /// states that look best after each word.
    pub(super) fn run(&mut self, width: usize, below: usize) -> Option<(usize, Plan)> {
        let mut levels: Vec<Vec<Node>> = Vec::new();
        let mut open: Vec<Vec<(u32, Node)>> = Vec::new();
        let mut visited: HashSet<u64> = HashSet::new();
        let begin = State {
            cursor: (0, 0),
            at: At::Nowhere,
            negative: false,
            stage: 0,
            left: all_of(self.task.stages.first()?),
        };
        levels.push(vec![Node {
            state: begin,
            parent: (0, 0),
            step: None,
        }]);
        let made = self.footprint.words();
        loop {
            let words = levels.len() - 1;
            let level = levels.last()?;
            let done = level.iter().position(|node| self.is_done(&node.state));
            if let Some(at) = done {
                return Some((made + words, self.plan(&levels, at)));
            }
            if made + words + 1 >= below {
                return None;
            }
            for (number, node) in level.iter().enumerate() {
                self.expand(&node.state, &mut |state, step, cost| {
                    let at = words + cost;
                    if open.len() <= at {
                        open.resize_with(at + 1, Vec::new);
                    }
                    let node = Node {
                        state,
                        parent: (words as u32, number as u32),
                        step: Some(step),
                    };
                    open[at].push((self.score(&state), node));
                });
            }
            // Nothing leads here, nor behind: no tour.
            let last = open.iter().rposition(|some| !some.is_empty())?;
            if last <= words {
                return None;
            }
            let mut next = std::mem::take(&mut open[words + 1]);
            self.seen += next.len() as u64;
            next.sort_by_key(|(score, _)| *score);
            let mut kept = Vec::new();
            for (_, node) in next {
                if kept.len() == width {
                    break;
                }
                if visited.insert(hash(&node.state)) {
                    kept.push(node);
                }
            }
            levels.push(kept);
        }
    }

    /// What is left to do: digits, and the way home.
    fn score(&self, state: &State) -> u32 {
        let stage = usize::from(state.stage);
        let digits = count(&state.left) + self.behind[stage];
        let way = state.cursor.0.unsigned_abs() + state.cursor.1.unsigned_abs();
        64 * digits + 3 * u32::from(way)
    }

    /// Whether the sum of a stage is a goal that only its scaling is left of.
    fn is_goal(&self, state: &State) -> bool {
        let stage = &self.task.stages[usize::from(state.stage)];
        stage.ends
            && state.at == At::Register
            && state.cursor == (0, 0)
            && state.left == [0; 4]
            && state.negative == self.task.scaled[stage.goal].turns()
    }

    fn is_done(&self, state: &State) -> bool {
        usize::from(state.stage) + 1 == self.task.stages.len() && self.is_goal(state)
    }

    /// Adds the states that one step leads to, with the words that it takes.
    fn expand(&self, state: &State, see: &mut dyn FnMut(State, Step, usize)) {
        let number = usize::from(state.stage);
        let stage = &self.task.stages[number];
        match state.at {
            At::Nowhere => self.begin(state.stage, see),
            At::News => {
                for (cell, step) in NEWS_CELLS.iter().enumerate() {
                    let cursor = (state.cursor.0 - step.0, state.cursor.1 - step.1);
                    let moved = State { cursor, ..*state };
                    self.add(&moved, Kind::Read(cell), SOURCES - 1, see);
                }
            }
            At::Register => {
                if self.is_goal(state) && number + 1 < self.task.stages.len() {
                    self.begin(state.stage + 1, see);
                }
                // Beside copies and finished goals.
                let spare = self
                    .task
                    .registers
                    .saturating_sub(self.footprint.copies.len() + stage.goal);
                if state.left == [0; 4] && !stage.ends {
                    let next = &self.task.stages[number + 1];
                    let times = self.footprint.exponents;
                    let after = State {
                        negative: state.negative != (times % 2 == 1),
                        stage: state.stage + 1,
                        left: all_of(next),
                        ..*state
                    };
                    let step = Step {
                        kind: Kind::Halved,
                        adds: 0,
                        begins: false,
                    };
                    if spare > 1 {
                        see(after, step, times);
                    } else if self.footprint.can_remake() {
                        see(after, step, times + 2);
                    }
                }
                if spare > 1 {
                    self.add(state, Kind::Stored, SOURCES - 1, see);
                }
                for cell in 0..NEWS_CELLS.len() {
                    self.add(state, Kind::Sent(cell), SOURCES - 1, see);
                }
            }
        }
    }

    /// The first words of a sum: at any place, of either sign.
    fn begin(&self, stage: u16, see: &mut dyn FnMut(State, Step, usize)) {
        let (rows, columns) = self.size;
        let left = all_of(&self.task.stages[usize::from(stage)]);
        for at in 0..rows * columns {
            let cursor = (
                self.first.0 + (at / columns) as i16,
                self.first.1 + (at % columns) as i16,
            );
            for negative in [false, true] {
                let state = State {
                    cursor,
                    at: At::Nowhere,
                    negative,
                    stage,
                    left,
                };
                self.add(&state, Kind::Stored, SOURCES, see);
                for cell in 0..NEWS_CELLS.len() {
                    self.add(&state, Kind::Sent(cell), SOURCES, see);
                }
            }
        }
    }

    /// Adds the state after a word that adds what it can.
    fn add(&self, state: &State, kind: Kind, room: usize, see: &mut dyn FnMut(State, Step, usize)) {
        let stage = &self.task.stages[usize::from(state.stage)];
        let Some(row) = self.row(usize::from(state.stage), state.cursor) else {
            return;
        };
        let copies = &self.footprint.copies;
        let mut can: u16 = 0;
        for (c, digit) in self.table[row..row + copies.len()].iter().enumerate() {
            if *digit != NONE && has(&state.left, *digit) {
                let minus = stage.digits[usize::from(*digit)].digit.negative != state.negative;
                can |= u16::from(minus == copies[c].negative) << c;
            }
        }
        let begins = state.at == At::Nowhere;
        if begins && can == 0 {
            return;
        }
        let mut see = |adds: u16| {
            let mut left = state.left;
            for (c, digit) in self.table[row..row + copies.len()].iter().enumerate() {
                if adds >> c & 1 == 1 {
                    left[usize::from(*digit / 64)] &= !(1 << (digit % 64));
                }
            }
            let cursor = match kind {
                Kind::Sent(cell) => {
                    let step = NEWS_CELLS[cell];
                    (state.cursor.0 - step.0, state.cursor.1 - step.1)
                }
                Kind::Read(_) | Kind::Stored | Kind::Halved => state.cursor,
            };
            let after = State {
                cursor,
                at: if matches!(kind, Kind::Sent(_)) {
                    At::News
                } else {
                    At::Register
                },
                negative: !state.negative,
                left,
                ..*state
            };
            let step = Step { kind, adds, begins };
            // What ends in the register of the input must not read it.
            let scaled = self.task.scaled[stage.goal];
            let over = self.task.over_input && adds & 1 == 1 && (scaled.up, scaled.down) == (0, 0);
            if !(over && self.is_done(&after)) {
                see(after, step, 1);
            }
            over && self.is_done(&after)
        };
        if can.count_ones() as usize <= room {
            if see(can) && !(begins && can == 1) {
                see(can & !1);
            }
            return;
        }
        see(some(can, room, true));
        see(some(can, room, false));
    }

    /// The words of the way to a node.
    fn plan(&self, levels: &[Vec<Node>], at: usize) -> Plan {
        let mut steps = Vec::new();
        let mut node = &levels[levels.len() - 1][at];
        while let Some(step) = node.step {
            steps.push((step, node.state));
            node = &levels[node.parent.0 as usize][node.parent.1 as usize];
        }
        steps.reverse();
        let mut builder = PlanBuilder::new(false, false);
        let mut copies = self.footprint.make(&mut builder);
        let mut goals = vec![0; self.task.order.len()];
        let mut sum: Option<Value> = None;
        let mut last = 0;
        for (step, after) in &steps {
            let stage = &self.task.stages[usize::from(after.stage)];
            if let (true, Some(done)) = (step.begins, sum) {
                goals[self.task.order[last]] = self.finish(&mut builder, done, last);
            }
            last = stage.goal;
            let mut values: Vec<Value> = Vec::new();
            if !step.begins {
                values.extend(sum);
            }
            let added = copies.iter().enumerate();
            values.extend(
                { added }
                    .filter(|(c, _)| step.adds >> c & 1 == 1)
                    .map(|(_, v)| *v),
            );
            sum = match step.kind {
                Kind::Sent(cell) => {
                    builder.news(direction(cell), values);
                    None
                }
                Kind::Read(cell) => Some(builder.register(vec![direction(cell)], values, false)),
                Kind::Stored => Some(builder.register(vec![], values, false)),
                Kind::Halved => {
                    for _ in 0..self.footprint.exponents {
                        values = vec![builder.register(vec![], values, true)];
                    }
                    if self.task.registers <= self.footprint.copies.len() + stage.goal + 1 {
                        self.footprint.remake(&mut builder, &mut copies);
                    }
                    values.first().copied()
                }
            };
        }
        if let Some(done) = sum {
            goals[self.task.order[last]] = self.finish(&mut builder, done, last);
        }
        Plan {
            goals,
            ..builder.plan
        }
    }

    /// Scales the sum of a goal.
    fn finish(&self, builder: &mut PlanBuilder, value: Value, goal: usize) -> Value {
        let scaled = self.task.scaled[goal];
        let mut sum = Sum {
            value,
            negative: scaled.turns(),
        };
        for _ in 0..scaled.down {
            sum = builder.halved(sum);
        }
        if scaled.steps {
            for _ in 0..scaled.up {
                sum = builder.doubled(sum, 1);
            }
            return sum.value;
        }
        builder.doubled(sum, scaled.up).value
    }
}

fn all_of(stage: &Stage) -> Left {
    let mut left = [0; 4];
    for digit in 0..stage.digits.len() {
        put(&mut left, digit as u16);
    }
    left
}

fn put(left: &mut Left, digit: u16) {
    left[usize::from(digit / 64)] |= 1 << (digit % 64);
}

fn has(left: &Left, digit: u16) -> bool {
    left[usize::from(digit / 64)] >> (digit % 64) & 1 == 1
}

fn count(left: &Left) -> u32 {
    left.iter().map(|word| word.count_ones()).sum()
}

/// So many of these copies: the first or the last ones.
fn some(mut all: u16, room: usize, first: bool) -> u16 {
    while all.count_ones() as usize > room {
        all &= if first { !(1 << all.ilog2()) } else { all - 1 };
    }
    all
}

fn hash(state: &State) -> u64 {
    let place = u64::from(state.cursor.0 as u16) << 32 | u64::from(state.cursor.1 as u16) << 16;
    let flags = u64::from(state.at == At::News) << 1 | u64::from(state.negative);
    let mut hash = place | flags << 48 | u64::from(state.stage);
    for word in state.left {
        hash = (hash ^ word).wrapping_mul(GOLDEN).rotate_left(29);
    }
    hash ^ hash >> 31
}
