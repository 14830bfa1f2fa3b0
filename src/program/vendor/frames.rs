//! The loop over the frames: its first turn, and what every later turn does.

use std::sync::Arc;

use super::{
    look,
    machine::{Flow, Machine},
    tree::{Expr, ExprNode, Stmt, Word},
    value::Value,
};
use crate::{
    config::Fault,
    program::syntax::{Item, Node},
};

/// Turns after which what still changes is called unknown.
const TURNS: usize = 24;

impl Machine<'_> {
    /// Whether a loop is that over the frames.
    pub(super) fn endless(&mut self, condition: Option<&Expr>, body: &Stmt) -> bool {
        let constant = condition.is_none_or(always);
        if constant {
            return !look::breaks(body) || look::syncs(self, body);
        }
        // `while (vs_…())`: as long as the box is on.
        condition.is_some_and(|it| matches!(it.node, ExprNode::Call(..))) && look::syncs(self, body)
    }

    pub(super) fn frame_loop(&mut self, body: &Stmt, step: Option<&Expr>) -> Flow {
        if self.looped {
            return Flow::End;
        }
        // What came before the first frame belongs to it, unless it took frames of its own.
        let before = std::mem::take(&mut self.items);
        let early = std::mem::take(&mut self.frames);
        let synced = look::syncs(self, body);
        let start = self.snapshot();
        let mut first = self.turn(body, step);
        // Variables that go on changing are not known; the steady turn must do without them, or
        // with the one value that they were given from outside.
        let mut known = self.snapshot();
        if self.fix(&start, &known) {
            self.slots = start;
            for slot in self.fixed.clone() {
                if let Some(value) = self.word(slot).and_then(|name| self.set(&name)) {
                    self.slots[slot] = value.converted(self.kind_at(slot, &[]));
                }
            }
            first = self.turn(body, step);
            known = self.snapshot();
        }
        let mut steady = self.turn(body, step);
        let why: Arc<str> = "a value that changes from frame to frame".into();
        for _ in 0..TURNS {
            if self.done() {
                break;
            }
            let after = self.snapshot();
            let mut changed = false;
            for (slot, (old, new)) in known.iter_mut().zip(&after).enumerate() {
                if old != new && !matches!(old, Value::Unknown(_)) {
                    *old = Value::Unknown(self.named(slot).unwrap_or_else(|| Arc::clone(&why)));
                    changed = true;
                }
            }
            if !changed {
                break;
            }
            self.slots.truncate(known.len());
            self.slots.clone_from(&known);
            steady = self.turn(body, step);
        }
        self.looped = true;
        self.lay(before, &early, &first, &steady, synced, body);
        Flow::End
    }

    /// Takes variables that a turn changes, and that have a value from outside, for fixed; whether
    /// there are any.
    fn fix(&mut self, before: &[Value], after: &[Value]) -> bool {
        for (slot, (before, after)) in before.iter().zip(after).enumerate() {
            let name = self.word(slot);
            let set = name.is_some_and(|name| self.overrides.contains_key(&*name));
            if before != after && set {
                self.fixed.insert(slot);
            }
        }
        !self.fixed.is_empty()
    }

    /// The name of a variable.
    fn word(&self, slot: usize) -> Option<Word> {
        let scopes = self.scopes.iter().rev();
        let mut names = scopes.flat_map(|scope| scope.iter());
        Some(names.find(|(_, it)| **it == slot)?.0.clone())
    }

    /// The name of a variable that changes, as a reason.
    fn named(&self, slot: usize) -> Option<Arc<str>> {
        let name = self.word(slot)?;
        Some(format!("`{name}`, which changes from frame to frame,").into())
    }

    fn snapshot(&self) -> Vec<Value> {
        self.slots.clone()
    }

    /// One turn: what it asks, cut where frames begin.
    fn turn(&mut self, body: &Stmt, step: Option<&Expr>) -> Vec<Vec<Item>> {
        self.maybe = None;
        let flow = self.scoped(body);
        self.maybe = None;
        if matches!(flow, Flow::Next | Flow::Continue)
            && let Some(step) = step
        {
            self.value(step);
        }
        let mut all = std::mem::take(&mut self.frames);
        all.push(std::mem::take(&mut self.items));
        all
    }

    /// Lays the frames out: the first, and the steady one.
    fn lay(
        &mut self,
        before: Vec<Item>,
        early: &[Vec<Item>],
        first: &[Vec<Item>],
        steady: &[Vec<Item>],
        synced: bool,
        body: &Stmt,
    ) {
        let parts = |all: &[Vec<Item>]| match all {
            // Before the frame is waited for, and after.
            [a, b] => (a.clone(), b.clone()),
            [a, rest @ ..] => (a.clone(), rest.concat()),
            [] => (Vec::new(), Vec::new()),
        };
        if steady.len() > 2 {
            self.fault(
                Fault::error(
                    body.place,
                    format!("{} frames in one turn of this loop", steady.len() - 1),
                    "this loop",
                )
                .help("a program does the same in every frame: wait for one frame in a turn"),
            );
        }
        let ((a0, b0), (a1, b1)) = (parts(first), parts(steady));
        let cat = |parts: [&[Item]; 2]| parts.concat();
        let own = !early.is_empty();
        let mut start = early.concat();
        let frame = if synced {
            cat([&b1, &a1])
        } else {
            cat([&a1, &b1])
        };
        if own {
            // It took frames of its own before the loop.
            start.extend(before);
            if synced {
                start.extend(a0);
            } else {
                start.extend(cat([&a0, &b0]));
            }
        } else if synced && a0.is_empty() && light(&before) && b0 == frame {
            // What it captures before the loop belongs to a moment of its own.
            start = before;
        } else {
            start = before;
            if synced && !a0.is_empty() && b0.is_empty() {
                start.extend(a0);
            } else {
                start.extend(a0);
                start.extend(b0);
                if synced {
                    start.extend(a1);
                }
            }
        }
        self.bare = start == frame;
        self.items = frame;
        self.frames = vec![start];
    }
}

/// Whether a condition is written as one that always holds.
fn always(it: &Expr) -> bool {
    match &it.node {
        ExprNode::Whole(value) => *value != 0,
        ExprNode::Convert(_, of) => always(of),
        _ => false,
    }
}

/// Whether something captures light, or resets the photodiodes.
fn light(items: &[Item]) -> bool {
    items.iter().any(|it| match &it.node {
        Node::Kernel(body) | Node::Repeat { body, .. } => light(body),
        Node::Statement(statement) => {
            let captures = ["get_image", "getpix", "respix", "rpix", "scamp5_get_image"];
            captures.contains(&statement.name.as_str())
                || statement.arguments.iter().any(|it| it.to_string() == "PIX")
        }
        _ => false,
    })
}
