//! Loops: their iterations, and what of them becomes a repetition on the array.

use super::{
    machine::{Flow, Machine},
    reason::Reason,
};
use crate::{
    config::Place,
    isa::text::{Expression, Term},
    program::{
        syntax::{Item, Node},
        vendor::{
            analysis::effects,
            frame::frame_loop::always,
            host::request::item,
            syntax::tree::{Expr, Stmt},
        },
    },
};

impl Machine<'_> {
    /// A loop: the frames where it has no end, else iteration by iteration.
    pub(super) fn iterations(
        &mut self,
        it: &Stmt,
        condition: Option<&Expr>,
        step: Option<&Expr>,
        body: &Stmt,
        body_first: bool,
    ) -> Flow {
        let beside = self.companion.is_some();
        let ran = self.ran_beside();
        let endless = self.endless(condition, step, body);
        if endless && !beside {
            return self.frame_loop(body, step);
        }
        // Where nothing in it waits, an iteration is a frame.
        let frame = endless && !effects::syncs(self, body) && effects::changes(self, body);
        let outer = self.maybe.clone();
        let mut all: Vec<Vec<Item>> = Vec::new();
        let before = self.items.len();
        let frames = self.frames.len();
        let mut first = body_first;
        let mut flow = Flow::Next;
        while !self.done() {
            self.work(it.place);
            if frame {
                self.next_frame();
            }
            let holds = match condition {
                Some(condition) if !first => {
                    let value = self.condition(condition);
                    match value.truth() {
                        Ok(holds) => holds,
                        Err(why) => {
                            self.open_ended(it, Some(condition), step, body, &why);
                            false
                        }
                    }
                }
                _ => true,
            };
            first = false;
            if !holds {
                break;
            }
            let (start, left) = (self.items.len(), self.left);
            let one = self.scoped(body);
            if beside {
                self.give_up();
            }
            if self.frames.len() == frames
                && self.ran_beside() == ran
                && self.recording.is_none()
                && start <= self.items.len()
            {
                all.push(self.items[start..].to_vec());
            }
            match one {
                Flow::Next | Flow::Continue => {}
                Flow::Break => break,
                other => {
                    flow = other;
                    break;
                }
            }
            // Nothing but what the run decides ends it.
            if let Some(why) = self.maybe.clone()
                && self.left > left
                && condition.is_none_or(always)
            {
                self.open_ended(it, condition, step, body, &why);
                break;
            }
            if let Some(step) = step {
                self.value(step);
            }
        }
        if let Some(why) = self.maybe.clone() {
            // How often it ran is not known, nor what it left.
            effects::forget(self, body, &why);
        }
        // A `return` ends more than the loop.
        let ended = self.maybe.take().filter(|_| effects::returns(body));
        self.maybe = outer.or(ended);
        if flow == Flow::Next && self.frames.len() == frames && self.ran_beside() == ran {
            self.folded(before, &all, it.place);
        }
        flow
    }

    /// A loop of which only the run knows when it ends.
    fn open_ended(
        &mut self,
        it: &Stmt,
        condition: Option<&Expr>,
        step: Option<&Expr>,
        body: &Stmt,
        why: &Reason,
    ) {
        let step = step.map(effects::statement);
        let decides = condition.map(effects::statement);
        let each = [Some(body), step.as_ref(), decides.as_ref()];
        if each.iter().flatten().any(|it| effects::changes(self, it)) {
            let message = format!("how often this loop runs depends on {why}");
            self.unknown(it.place, message, why, condition);
        } else if each.iter().flatten().any(|it| effects::reads(self, it)) {
            self.unread(it.place, "how often this is read out", why);
        } else if each.iter().flatten().any(|it| effects::shows(self, it)) {
            self.shown(it.place, "how often this is shown", why);
        } else if self.companion.is_some() && effects::posts(self, body) {
            self.unread(it.place, "how often this is posted", why);
        }
        effects::forget(self, body, why);
        if self.companion.is_some() {
            effects::show(self, body);
        }
        for part in each.into_iter().flatten() {
            effects::forget(self, part, why);
        }
    }

    /// Turns that asked the same of the array become one `repeat`, which is stored once.
    fn folded(&mut self, before: usize, all: &[Vec<Item>], place: Place) {
        let Some((first, rest)) = all.split_first() else {
            return;
        };
        let iterations = all.iter().map(Vec::len).sum::<usize>();
        let whole = self.items.len() == before + iterations;
        if rest.is_empty() || first.is_empty() || self.recording.is_some() || !whole {
            return;
        }
        if rest.iter().any(|iteration| iteration != first) {
            return;
        }
        self.items.truncate(before);
        let place = self.files.own(place);
        let term = Term::Number(all.len() as f64);
        let node = Node::Repeat {
            times: Expression { term, place },
            body: first.clone(),
        };
        self.items.push(item(node, place));
    }
}
