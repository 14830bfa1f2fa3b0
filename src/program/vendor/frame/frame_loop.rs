//! The loop over the frames: its first iteration, and what every later iteration does.

use std::collections::BTreeSet;

use super::light::{capture, light};
use crate::{
    config::{Fault, Place},
    program::{
        syntax::{Item, Kernel, Node},
        vendor::{
            analysis::effects,
            host::statement::RECORDING,
            interpreter::{
                machine::{Flow, Machine},
                reason::Reason,
                value::Value,
            },
            syntax::{
                tree::{Expr, ExprNode, Stmt, Word, last},
                walk::{Part, values},
            },
        },
    },
};

/// Where the loop over the frames stands inside another one that begins again.
const AGAIN: &str = "`exec` runs it, with the host beside the array. Here every frame must have the same instruction words: put what is done once before one infinite loop";

/// What becomes of frames before the loop.
const EARLIER: &str =
    "what follows happens a frame or more earlier here: `exec --host` runs each in its own frame";

/// What was asked up to the end of the first iteration of a loop over the frames.
struct Begun {
    /// Frames before the loop.
    early: Vec<Vec<Item>>,
    /// What was asked since, before the loop.
    before: Vec<Item>,
    /// The first iteration, cut where frames begin.
    first: Vec<Vec<Item>>,
}

/// Turns after which what still changes is called unknown.
const TURNS: usize = 24;

impl Machine<'_> {
    /// Whether a loop is that over the frames.
    pub(in crate::program::vendor) fn endless(
        &mut self,
        condition: Option<&Expr>,
        step: Option<&Expr>,
        body: &Stmt,
    ) -> bool {
        let constant = condition.is_none_or(always);
        if constant {
            return !effects::breaks(body) || effects::syncs(self, body);
        }
        // `while (vs_…())`: as long as the box is on.
        condition.is_some_and(|it| {
            matches!(it.node, ExprNode::Call(..)) && effects::syncs(self, body)
                || step.is_none() && !effects::ends(body) && self.stays(it, body)
        })
    }

    /// Whether a condition holds and nothing in the loop changes it. One that only waits, for what
    /// never comes, is told of.
    fn stays(&mut self, condition: &Expr, body: &Stmt) -> bool {
        let (mut slots, mut plain) = (BTreeSet::new(), true);
        let mut named = None;
        values(condition, &mut |part| match part {
            Part::Expr(Expr {
                node: ExprNode::Name(name),
                ..
            }) => {
                slots.extend(self.find(name));
                named = Some(name.clone());
            }
            Part::Expr(it) => {
                plain &= matches!(
                    it.node,
                    ExprNode::Whole(_)
                        | ExprNode::Unary("!", _)
                        | ExprNode::Binary(..)
                        | ExprNode::Convert(..)
                );
            }
            Part::Stmt(_) => plain = false,
        });
        // Inside a kernel there are no frames.
        plain &= self.recording.is_none() && !slots.is_empty();
        let Some(named) = named.filter(|_| plain) else {
            return false;
        };
        if effects::may_assign(self, body, &slots) || self.condition(condition).truth() != Ok(true)
        {
            return false;
        }
        if effects::changes(self, body) || effects::syncs(self, body) {
            return true;
        }
        if !effects::reads(self, body) && !effects::shows(self, body) {
            self.error(
                condition.place,
                format!("this loop waits, but nothing in it changes `{named}`"),
                "it never ends",
                &format!("`--const {named}=VALUE` ends it"),
            );
        }
        false
    }

    pub(in crate::program::vendor) fn frame_loop(
        &mut self,
        body: &Stmt,
        step: Option<&Expr>,
    ) -> Flow {
        if self.looped {
            return Flow::End;
        }
        let start = self.snapshot();
        let recorded = self.recorded.clone();
        let mut begun = match self.begin(body, step) {
            Ok(begun) => begun,
            Err(flow) => return flow,
        };
        // Variables that go on changing are not known; the steady iteration must do without them, or
        // with the one value that they were given from outside.
        let mut known = self.snapshot();
        if self.fix(&start, &known) {
            // Variables that are made once are made again.
            self.lasting.retain(|_, slot| *slot < start.len());
            self.slots = start;
            self.recorded = recorded;
            for slot in self.fixed.clone() {
                if let Some(value) = self.word(slot).and_then(|name| self.set(&name)) {
                    self.slots[slot] = value.converted(self.kind_at(slot, &[]));
                }
            }
            (self.frames, self.items) = (begun.early, begun.before);
            begun = match self.begin(body, step) {
                Ok(begun) => begun,
                Err(flow) => return flow,
            };
            known = self.snapshot();
        }
        let (mut steady, _) = self.iteration(body, step);
        let why: Reason = "a value that changes from frame to frame".into();
        for _ in 0..TURNS {
            if self.done() || self.looped {
                break;
            }
            let after = self.snapshot();
            let mut changed = false;
            for (slot, (old, new)) in known.iter_mut().zip(&after).enumerate() {
                if differs(old, new) {
                    let why = self.named(slot).unwrap_or_else(|| why.clone());
                    unknown_where_other(old, new, &why);
                    changed = true;
                }
            }
            // Variables that are made once, and were not made before this turn.
            let last = self.lasting.values().copied().max();
            if let Some(last) = last.filter(|it| *it >= known.len()) {
                known.resize(last + 1, Value::Unknown(why.clone()));
                changed = true;
            }
            if !changed {
                break;
            }
            self.slots.truncate(known.len());
            self.slots.clone_from(&known);
            (steady, _) = self.iteration(body, step);
        }
        if std::mem::replace(&mut self.looped, true) {
            self.undecided(
                Fault::error(
                    body.place,
                    "the frame loop begins in a later iteration of this loop",
                    "this loop",
                )
                .help(AGAIN),
            );
        }
        self.lay(begun, &steady, body);
        Flow::End
    }

    /// The first iteration, and what came before it.
    ///
    /// # Errors
    /// With what comes then, where there is no second one: a loop inside is that over the frames, and
    /// has laid them out, or the first iteration leaves this loop.
    fn begin(&mut self, body: &Stmt, step: Option<&Expr>) -> Result<Begun, Flow> {
        let (waited, asked) = (self.frames.len(), self.items.len());
        self.ends = false;
        let (mut early, flow) = self.iteration(body, step);
        if self.looped {
            if self.ends {
                self.undecided(
                    Fault::error(
                        body.place,
                        "this loop starts again when the frame loop inside it ends",
                        "this loop",
                    )
                    .help(AGAIN),
                );
            }
            self.go_on_behind(early);
            return Err(Flow::End);
        }
        if let Flow::Break | Flow::Return(_) = flow {
            self.go_on_behind(early);
            return Err(match flow {
                Flow::Break => Flow::Next,
                left => left,
            });
        }
        // What came before the first frame belongs to it, unless it took frames of its own.
        let mut first = early.split_off(waited.min(early.len().saturating_sub(1)));
        let before = match first.first_mut() {
            Some(all) => all.drain(..asked.min(all.len())).collect(),
            None => Vec::new(),
        };
        Ok(Begun {
            early,
            before,
            first,
        })
    }

    /// What was asked, the last of it in the frame that goes on.
    fn go_on_behind(&mut self, mut asked: Vec<Vec<Item>>) {
        self.items = asked.pop().unwrap_or_default();
        self.frames = asked;
    }

    /// Takes variables that an iteration changes, and that have a value from outside, for fixed; whether
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
        Some(last(names.find(|(_, it)| **it == slot)?.0).into())
    }

    /// The name of a variable that changes, as a reason.
    fn named(&self, slot: usize) -> Option<Reason> {
        let name = self.word(slot)?;
        Some(format!("`{name}`, which changes from frame to frame").into())
    }

    fn snapshot(&self) -> Vec<Value> {
        self.slots.clone()
    }

    /// One iteration: what it asks, cut where frames begin, and how it ends.
    fn iteration(&mut self, body: &Stmt, step: Option<&Expr>) -> (Vec<Vec<Item>>, Flow) {
        self.maybe = None;
        self.dark = false;
        let left = self.left;
        let flow = self.scoped(body);
        let may_end = self.maybe.take().is_some() && self.left > left;
        self.ends |= may_end || matches!(flow, Flow::Break | Flow::Return(_));
        if matches!(flow, Flow::Next | Flow::Continue)
            && let Some(step) = step
        {
            self.value(step);
        }
        let mut all = std::mem::take(&mut self.frames);
        all.push(std::mem::take(&mut self.items));
        (all, flow)
    }

    /// Lays the frames out: what is done once, as `init`, and the steady one. A frame is what is
    /// asked between two waits.
    fn lay(&mut self, begun: Begun, steady: &[Vec<Item>], body: &Stmt) {
        let Begun {
            early,
            before,
            first,
        } = begun;
        if steady.len() > 2 {
            self.undecided(
                Fault::error(
                    body.place,
                    format!("{} frames in one iteration of this loop", steady.len() - 1),
                    "this loop",
                )
                .help("every frame must be the same: wait for one frame per iteration"),
            );
        }
        let own = !early.is_empty();
        let (frame, mut once) = match steady {
            // Before the frame is waited for, and after.
            [ahead, behind @ ..] if !behind.is_empty() => {
                let mut once = early;
                once.push([before, first[0].clone()].concat());
                once.extend(first[1..].iter().cloned());
                if let Some(last) = once.last_mut() {
                    last.extend(ahead.iter().cloned());
                }
                ([behind.concat(), ahead.clone()].concat(), once)
            }
            _ => {
                let mut once = early;
                once.extend([before, first.concat()]);
                (steady.concat(), once)
            }
        };
        // Waiting ends the iteration: the first iteration is a frame like the others.
        let ends = steady.len() == 2
            && matches!(&first[..], [all, none] if !all.is_empty() && none.is_empty());
        if once.last() == Some(&frame) {
            let rest = &once[..once.len() - 1];
            // What it captures before the loop belongs to a moment of its own; what else it does
            // there belongs to the first frame.
            if own || ends || rest.iter().any(|it| light(it)) {
                once.pop();
            }
        }
        self.one_frame(&once, body.place, &first.concat(), &steady.concat());
        let start = once.concat();
        self.bare = start == frame;
        self.items = frame;
        self.frames = vec![start];
    }

    /// What is done once is one frame, in which the light falls once.
    fn one_frame(
        &mut self,
        once: &[Vec<Item>],
        place: Place,
        first_turn: &[Item],
        steady: &[Item],
    ) {
        let mut captures = once.iter().filter_map(|it| capture(it));
        let (Some(first), Some(second)) = (captures.next(), captures.next()) else {
            self.several_frames(once, place);
            return;
        };
        if let Some(fault) = self.recorded_alone(first_turn, steady) {
            self.undecided(fault);
            return;
        }
        let count = 2 + captures.count();
        let line = self.line(first);
        self.undecided(
            Fault::error(
                second,
                format!("{count} frames are captured before the frame loop, but a program has room for only one there, `init`"),
                format!("the first is captured in {line}"),
            )
            .help("capture once before the loop; or calibrate with a separate program, save its registers with `exec --dump`, and load them with `--set REGISTER=FILE.npy`"),
        );
    }

    /// A fault, where what tells the first turn from the others is a call of the host in a kernel that
    /// is recorded then.
    fn recorded_alone(&self, first: &[Item], steady: &[Item]) -> Option<Fault> {
        let same = |(a, b): &(&Item, &Item)| a == b;
        let alike = first.iter().zip(steady).take_while(same).count();
        let it = first.get(alike)?;
        let Node::Statement(statement) = &it.node else {
            return None;
        };
        let told =
            |fault: &&Fault| fault.label == RECORDING && self.files.own(fault.place).is(it.place);
        let inside = self.faults.iter().find(told)?;
        let message = format!(
            "`{}` runs only in the first iteration of this loop, while the kernel is recorded, and a frame is captured before the loop, too",
            statement.name
        );
        let fault = Fault::error(inside.place, message, "later frames lack it");
        Some(fault.help("put it before `scamp5_kernel_begin();`, so that every frame runs it"))
    }

    /// Warns of what is done once and takes several frames: here they are one.
    fn several_frames(&mut self, once: &[Vec<Item>], place: Place) {
        // The first frame is there from the beginning: it goes on behind a wait before which no
        // light was taken in.
        let joined = once
            .first()
            .is_some_and(|it| !light(it) && capture(it).is_none());
        let count = once.len() - usize::from(joined && once.len() > 1);
        if count > 1 {
            let last = once.last().filter(|it| !it.is_empty());
            self.fault(
                Fault::warning(
                    last.map_or(place, |it| place_of(it)),
                    format!(
                        "{count} frames before the frame loop are merged into one here, `init`"
                    ),
                    "the last of them",
                )
                .help(EARLIER),
            );
        }
    }

    /// The frames of a program that ends: one, or one again and again.
    pub(in crate::program::vendor) fn ended(&mut self, mut frames: Vec<Vec<Item>>) -> Vec<Item> {
        let waited = frames.len() > 1;
        if waited && frames.first().is_some_and(Vec::is_empty) {
            frames.remove(0);
        }
        if frames.last().is_some_and(Vec::is_empty) {
            frames.pop();
        }
        let [first, rest @ ..] = &frames[..] else {
            return Vec::new();
        };
        let alike = rest.iter().all(|it| it == first);
        let done = rest.iter().filter(|it| !it.is_empty()).count();
        if alike && done > 0 {
            self.fault(
                Fault::warning(
                    place_of(first),
                    format!(
                        "this program ends after {}",
                        crate::unit::counted(frames.len(), "frame")
                    ),
                    "it is repeated for every frame",
                )
                .help("`exec --frames` sets how often it runs"),
            );
            return first.clone();
        }
        let captured = frames.iter().filter(|it| capture(it).is_some()).count();
        if done > 1 || captured > 1 {
            let second = frames[1..].iter().find(|it| !it.is_empty());
            self.undecided(
                Fault::error(
                    second.map_or_else(Place::default, |it| place_of(it)),
                    format!("{} frames that differ", 1 + done),
                    "the second one",
                )
                .help("every frame must be the same: put what is done once before the first wait, and the rest into `while (1) { vs_frame_loop_control(); … }`"),
            );
        }
        frames.concat()
    }
}

/// Where something begins that is asked.
fn place_of(items: &[Item]) -> Place {
    let Some(first) = items.first() else {
        return Place::default();
    };
    match &first.node {
        Node::Kernel(Kernel { body, .. }) | Node::Repeat { body, .. } if !body.is_empty() => {
            place_of(body)
        }
        _ => first.place,
    }
}

/// Whether a condition is written as one that always holds.
pub(in crate::program::vendor) fn always(it: &Expr) -> bool {
    written(it).is_some_and(|it| it.truth() == Ok(true))
}

/// The number that a value is written as, without names and calls.
fn written(it: &Expr) -> Option<Value> {
    let value = match &it.node {
        ExprNode::Whole(value) => Value::Whole(*value),
        ExprNode::Wide(value, width) => Value::Wide(*value, *width),
        ExprNode::Real(value) => Value::Real(*value),
        ExprNode::Convert(kind, of) => written(of)?.converted(*kind),
        ExprNode::Unary("!", of) => Value::flag(!written(of)?.truth().ok()?),
        ExprNode::Unary(operator @ ("-" | "+" | "~"), of) => written(of)?.signed(operator)?,
        ExprNode::Binary(operator, left, right) if *operator != "," => {
            Value::binary(operator, &written(left)?, &written(right)?).ok()?
        }
        _ => return None,
    };
    value.number().map(|_| value)
}

/// Whether something that is known has another value.
pub(super) fn differs(old: &Value, new: &Value) -> bool {
    match (old, new) {
        (Value::Unknown(_), _) => false,
        (Value::List(old), Value::List(new)) if old.len() == new.len() => {
            old.iter().zip(new).any(|(old, new)| differs(old, new))
        }
        (Value::Record(of, old), Value::Record(is, new))
            if of.name == is.name && old.len() == new.len() =>
        {
            old.iter().zip(new).any(|(old, new)| differs(old, new))
        }
        _ => old != new,
    }
}

/// What has another value is not known; arrays and objects stay such, of which some parts are not.
fn unknown_where_other(old: &mut Value, new: &Value, why: &Reason) {
    if !differs(old, new) {
        return;
    }
    match (old, new) {
        (Value::List(old), Value::List(new)) if old.len() == new.len() => {
            for (old, new) in old.iter_mut().zip(new) {
                unknown_where_other(old, new, why);
            }
        }
        (Value::Record(of, old), Value::Record(is, new))
            if of.name == is.name && old.len() == new.len() =>
        {
            for (old, new) in old.iter_mut().zip(new) {
                unknown_where_other(old, new, why);
            }
        }
        (old, _) => *old = Value::Unknown(why.clone()),
    }
}
