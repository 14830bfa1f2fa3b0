//! Statements, run one after the other.

use std::sync::Arc;

use super::{
    evaluate::Reach,
    look,
    machine::{Flow, Machine, item},
    shape::{self, Leaf},
    tree::{Declared, Expr, Kind, Stmt, StmtNode, last},
    value::{Layout, Member, Value, unassigned},
};
use crate::{
    config::Place,
    isa::text::{Expression, Term},
    program::syntax::{Item, Node},
};

impl Machine<'_> {
    /// Runs statements in a scope of their own.
    pub(super) fn block(&mut self, statements: &[Stmt]) -> Flow {
        self.scopes.push(std::collections::BTreeMap::new());
        let flow = self.statements(statements);
        self.scopes.pop();
        flow
    }

    pub(super) fn statements(&mut self, statements: &[Stmt]) -> Flow {
        for statement in statements {
            if self.done() {
                return Flow::End;
            }
            match self.statement(statement) {
                Flow::Next => {}
                other => return other,
            }
        }
        Flow::Next
    }

    fn statement(&mut self, it: &Stmt) -> Flow {
        self.work(it.place);
        match &it.node {
            StmtNode::Block(inner) | StmtNode::Namespace(_, inner) => return self.block(inner),
            StmtNode::Declare(all) => {
                for declared in all {
                    self.declare(declared);
                }
            }
            StmtNode::Expr(value) => {
                self.value(value);
                if self.looped {
                    return Flow::End;
                }
            }
            StmtNode::If(condition, yes, no) => return self.branch(condition, yes, no.as_deref()),
            StmtNode::For(start, condition, step, body) => {
                self.scopes.push(std::collections::BTreeMap::new());
                if let Some(start) = start {
                    self.statement(start);
                }
                let flow = self.turns(it, condition.as_ref(), step.as_ref(), body, false);
                self.scopes.pop();
                return flow;
            }
            StmtNode::Each(it, list, body) => return self.each(it, list, body),
            StmtNode::While(condition, body) => {
                return self.turns(it, Some(condition), None, body, false);
            }
            StmtNode::DoWhile(body, condition) => {
                return self.turns(it, Some(condition), None, body, true);
            }
            StmtNode::Switch(on, body) => return self.switch(on, body),
            StmtNode::Prototype(function) => self.announce(function),
            StmtNode::Case(_) | StmtNode::Nothing => {}
            StmtNode::Break => return Flow::Break,
            StmtNode::Continue => return Flow::Continue,
            StmtNode::Return(value) => {
                let value = value.as_ref().map_or(Value::Whole(0), |it| self.value(it));
                return Flow::Return(value);
            }
            StmtNode::Function(function) => self.state(function),
            StmtNode::Struct(it) => self.class(it),
            StmtNode::Class(members) => {
                self.state_members(members);
                self.check_members(members);
            }
        }
        Flow::Next
    }

    /// A function is announced, with its default arguments.
    pub(super) fn announce(&mut self, function: &std::rc::Rc<super::tree::Function>) {
        let known = self.prototypes.entry(function.name.clone()).or_default();
        if !known.contains(function) {
            known.push(std::rc::Rc::clone(function));
        }
    }

    /// A function is stated.
    pub(super) fn state(&mut self, function: &std::rc::Rc<super::tree::Function>) {
        let known = self.functions.entry(function.name.clone()).or_default();
        if known.contains(function) {
            return;
        }
        let alike = known.iter().find(|it| it.same_form(function));
        let alike = alike.map(|it| it.place);
        known.push(std::rc::Rc::clone(function));
        if let Some(before) = alike {
            self.stated_twice(&function.name, before, function.place);
        }
    }

    /// Files are read as one here: a name of one is a name of all.
    fn stated_twice(&mut self, name: &str, before: Place, place: Place) {
        if self.files.name(before) == self.files.name(place) {
            return;
        }
        let message = format!("`{name}` is stated in {} as well", self.line(before));
        let help = "files are read as one here: give one of the two another name";
        self.error(place, message, "stated again", help);
    }

    /// The functions of a class.
    pub(super) fn state_members(&mut self, members: &[std::rc::Rc<super::tree::Function>]) {
        for function in members {
            let known = self.members.entry(function.name.clone()).or_default();
            if !known.contains(function) {
                known.push(std::rc::Rc::clone(function));
            }
        }
    }

    /// Objects are made and ended without a call that could be refused: what does that must leave
    /// the array alone.
    fn check_members(&mut self, members: &[std::rc::Rc<super::tree::Function>]) {
        for function in members.iter().filter(|it| it.hidden) {
            if function.body.iter().any(|it| look::changes(self, it)) {
                self.error(
                    function.place,
                    format!(
                        "`{}` runs words of the array where no call of it is written",
                        function.name
                    ),
                    "a constructor, a destructor or an operator",
                    "make it a function outside of the class, and call that",
                );
            }
        }
    }

    pub(super) fn declare(&mut self, it: &Declared) {
        if it.value.is_none() && !it.lasting && self.home(&it.name).is_some() {
            // `extern`: the variable is there.
            return;
        }
        if it.outside && it.value.is_none() {
            let why = format!("`{}`, which is stated nowhere,", it.name);
            self.make(&it.name, Value::Unknown(why.into()), Kind::Any);
            return;
        }
        if it.lasting
            && let Some(slot) = self.lasting.get(&it.place.start)
        {
            let slot = *slot;
            self.bind(&it.name, slot);
            return;
        }
        self.naming = Some(it.name.clone());
        let stated = match &it.value {
            // Another name for the same variable, or for an element.
            Some(value) if it.reference => match self.reach(value) {
                Reach::Spot(slot, path) => {
                    self.naming = None;
                    self.refer(&it.name, (slot, path));
                    return;
                }
                reached => Some(self.load(&reached, value)),
            },
            Some(value) => Some(self.value(value)),
            None => None,
        };
        self.naming = None;
        let set = match stated {
            // Registers, arrays and texts are not set from outside.
            None | Some(Value::Whole(_) | Value::Wide(..) | Value::Real(_) | Value::Unknown(_))
                if it.lengths.is_empty() =>
            {
                self.set(&it.name)
            }
            _ => None,
        };
        let fixed = self.companion.is_some() && set.is_some();
        if let Some(set) = &set {
            self.set_within(&it.name, (set, self.resolved(it.kind)), it.place);
        }
        let value = match (set, stated) {
            (Some(value), _) | (None, Some(value)) => value,
            (None, None) if it.lengths.is_empty() => {
                let name = &it.name;
                // A variable of the file begins at 0; others hold what was there before.
                let empty = if self.scopes.len() == 1 || it.lasting {
                    Value::Whole(0)
                } else {
                    Value::Unknown(unassigned(name))
                };
                match self.layouts.get(&it.of) {
                    Some(layout) if !it.pointer => shape::fresh(layout, &empty),
                    _ if last(&it.of) == "string" && !it.pointer => Value::Text("".into()),
                    _ => empty,
                }
            }
            (None, None) => self.objects(it).unwrap_or(Value::List(Vec::new())),
        };
        let value = self.shaped(it, value);
        self.settle(it, &value);
        if let (true, Some(number)) = (it.constant, value.number()) {
            self.constants.entry(it.name.to_string()).or_insert(number);
        }
        let copied = it.library && matches!(value, Value::List(_));
        let kind = self.resolved(it.kind);
        let slot = self.make(&it.name, value, kind);
        if fixed {
            self.fixed.insert(slot);
        }
        if copied {
            self.copied.insert(slot);
        }
        if it.lasting {
            self.lasting.insert(it.place.start, slot);
        }
    }

    /// What an array of objects begins with, where a constructor makes each.
    fn objects(&mut self, it: &Declared) -> Option<Value> {
        let layout = self
            .layouts
            .get(&it.of)
            .filter(|it| it.constructs())?
            .clone();
        let lengths: Option<Vec<usize>> = self.lengths(it).into_iter().collect();
        let count: usize = lengths?.into_iter().product();
        let mut all = Vec::new();
        while !it.pointer && all.len() < count && !self.done() {
            self.work(it.place);
            all.push(self.constructed(&layout, &[], it.place));
        }
        (!it.pointer).then_some(Value::List(all))
    }

    /// Where a variable of the file is stated, if that is where control is.
    fn home(&self, name: &str) -> Option<Place> {
        let outside = self.scopes.len() == 1;
        let full = format!("{}::{name}", self.space);
        self.homes.get(&*full).copied().filter(|_| outside)
    }

    /// A variable of the file is stated: one that only its own file should know keeps others of its
    /// name away.
    fn settle(&mut self, it: &Declared, value: &Value) {
        if self.scopes.len() > 1 {
            return;
        }
        let own = it.lasting || it.constant;
        if let (true, Some(before)) = (own, self.home(&it.name)) {
            let held = self.find(&it.name).map(|slot| &self.slots[slot]);
            if it.lasting && it.value.is_none() || held != Some(value) {
                self.stated_twice(&it.name, before, it.place);
            }
        }
        let full = format!("{}::{}", self.space, it.name);
        self.homes.insert(full.into(), it.place);
    }

    /// A value with the lengths and the type of what holds it.
    pub(super) fn shaped(&mut self, it: &Declared, value: Value) -> Value {
        let lengths = self.lengths(it);
        let value = match value {
            // An array of the language's library is copied.
            Value::Pointer(slot, path, _) if it.library => self.at(slot, &path),
            value => value,
        };
        let layout = self.layouts.get(&it.of).filter(|_| !it.pointer).cloned();
        let leaf = Leaf {
            kind: self.resolved(it.kind),
            layout: layout.as_ref(),
            library: it.library,
        };
        shape::shaped(value, &lengths, leaf).unwrap_or_else(|message| {
            self.error(
                it.place,
                format!("`{}`: {message}", it.name),
                "this declaration",
                "give as many values as it holds, or fewer",
            );
            Value::Whole(0)
        })
    }

    /// A class is stated.
    fn class(&mut self, it: &super::tree::Struct) {
        let mut members = Vec::new();
        for member in &it.members {
            let layout = self.layouts.get(&member.of).filter(|_| !member.pointer);
            let layout = layout.cloned();
            let lengths = self.lengths(member);
            let stated = member.value.as_ref().map(|value| self.value(value));
            members.push(Member {
                name: member.name.clone(),
                kind: member.kind,
                default: stated.map(|value| self.shaped(member, value)),
                lengths,
                layout,
            });
        }
        let name = it.name.clone();
        let functions = it.functions.clone();
        let layout = Layout {
            name,
            members,
            functions,
        };
        self.layouts.insert(it.name.clone(), layout.into());
    }

    /// The lengths of an array; none is known where it is too large.
    fn lengths(&mut self, it: &Declared) -> Vec<Option<usize>> {
        let mut lengths = Vec::new();
        for length in &it.lengths {
            let value = length.as_ref().map(|length| self.value(length));
            let whole = value.as_ref().and_then(Value::whole);
            lengths.push(whole.and_then(|n| usize::try_from(n).ok()));
        }
        let layout = self.layouts.get(&it.of).filter(|_| !it.pointer);
        let one = layout.map_or(1, |it| it.size());
        if !self.fits(shape::count(one, &lengths), it.place) {
            lengths.fill(None);
        }
        lengths
    }

    /// The value of a condition.
    pub(super) fn condition(&mut self, it: &Expr) -> Value {
        match self.value(it) {
            Value::Symbol(name) if self.device.value_of(&name).is_none() => {
                if ["VS_", "vs_", "SCAMP"]
                    .iter()
                    .any(|begin| name.starts_with(begin))
                {
                    return Value::Unknown(format!("`{name}`").into());
                }
                self.unstated(&name, it.place);
                Value::Whole(0)
            }
            value if self.no_number(&value, it.place) => Value::Whole(0),
            value => value,
        }
    }

    fn branch(&mut self, condition: &Expr, yes: &Stmt, no: Option<&Stmt>) -> Flow {
        let (mut condition, mut yes, mut no) = (condition, yes, no);
        loop {
            let value = self.condition(condition);
            match (value.truth(), no) {
                (Ok(true), _) => return self.scoped(yes),
                (Ok(false), None) => return Flow::Next,
                (Ok(false), Some(other)) => {
                    // `else if` is no deeper than the `if` before it.
                    let StmtNode::If(next, then, otherwise) = &other.node else {
                        return self.scoped(other);
                    };
                    self.work(other.place);
                    (condition, yes, no) = (next, then, otherwise.as_deref());
                }
                (Err(why), no) => {
                    let parts: Vec<&Stmt> = [Some(yes), no].into_iter().flatten().collect();
                    return self.either(condition, &parts, &why);
                }
            }
        }
    }

    /// Branches of which only the run knows which is taken. What they show is shown beside the array
    /// alone; what they compute is forgotten; that they change the array is a fault.
    pub(super) fn either(&mut self, on: &Expr, parts: &[&Stmt], why: &Arc<str>) -> Flow {
        let changes = parts.iter().any(|part| look::changes(self, part));
        if changes {
            let message = format!("whether this kernel runs, {why} decides");
            self.unknown(on.place, message, Some(on));
        } else if parts.iter().any(|part| look::reads(self, part)) {
            self.unread(on.place, "whether this is read out", why);
        } else if parts.iter().any(|part| look::shows(self, part)) {
            self.unread(on.place, "whether this is shown", why);
        }
        for part in parts {
            look::forget(self, part, why);
            if changes {
                // For the faults that are in it.
                self.scoped(part);
            } else if self.companion.is_some() {
                look::show(self, part);
            }
            look::forget(self, part, why);
            if look::leaves(part) {
                self.maybe = Some(Arc::clone(why));
            }
        }
        Flow::Next
    }

    pub(super) fn scoped(&mut self, it: &Stmt) -> Flow {
        match &it.node {
            StmtNode::Block(inner) => self.block(inner),
            _ => self.block(std::slice::from_ref(it)),
        }
    }

    fn switch(&mut self, on: &Expr, body: &[Stmt]) -> Flow {
        let value = self.value(on);
        if let Value::Unknown(why) = &value {
            let why = Arc::clone(why);
            let parts: Vec<&Stmt> = body.iter().collect();
            // A `break` in it ends the switch, and nothing more.
            let maybe = self.maybe.clone();
            self.either(on, &parts, &why);
            self.maybe = maybe;
            return Flow::Next;
        }
        let mut start = None;
        for (i, statement) in body.iter().enumerate() {
            match &statement.node {
                StmtNode::Case(Some(case)) if self.value(case).number() == value.number() => {
                    start = Some(i);
                    break;
                }
                StmtNode::Case(None) => start = start.or(Some(i)),
                _ => {}
            }
        }
        // `default` counts only where no case does.
        let Some(start) = start else {
            return Flow::Next;
        };
        match self.block(&body[start..]) {
            Flow::Break => Flow::Next,
            other => other,
        }
    }

    fn each(&mut self, it: &Declared, list: &Expr, body: &Stmt) -> Flow {
        let reached = self.reach(list);
        let (spot, listed) = match &reached {
            Reach::Spot(slot, path) => match self.at(*slot, path) {
                Value::Pointer(slot, path, _) => {
                    let listed = self.at(slot, &path);
                    (Some((slot, path)), listed)
                }
                listed => (Some((*slot, path.clone())), listed),
            },
            other => (None, self.load(other, list)),
        };
        let Value::List(all) = listed else {
            self.error(
                list.place,
                "this is no list of known values".to_owned(),
                "the loop goes over it",
                "state the values in the file: `int all[] = {1, 2, 3};`",
            );
            return Flow::Next;
        };
        for (i, value) in all.into_iter().enumerate() {
            self.scopes.push(std::collections::BTreeMap::new());
            match &spot {
                Some((slot, path)) if it.reference => {
                    let path = [&path[..], &[i]].concat();
                    self.refer(&it.name, (*slot, path));
                }
                _ => {
                    let kind = self.resolved(it.kind);
                    self.make(&it.name, value.converted(kind), kind);
                }
            }
            let flow = self.scoped(body);
            self.scopes.pop();
            match flow {
                Flow::Next | Flow::Continue => {}
                Flow::Break => break,
                other => return other,
            }
        }
        Flow::Next
    }

    /// A loop: the frames where it has no end, else turn by turn.
    fn turns(
        &mut self,
        it: &Stmt,
        condition: Option<&Expr>,
        step: Option<&Expr>,
        body: &Stmt,
        body_first: bool,
    ) -> Flow {
        let beside = self.companion.is_some();
        let endless = self.endless(condition, body);
        if endless && !beside {
            return self.frame_loop(body, step);
        }
        // Where nothing in it waits, a turn is a frame.
        let frame = endless && !look::syncs(self, body) && look::changes(self, body);
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
                            self.open_ended(it, condition, step, body, &why);
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
            let start = self.items.len();
            let one = self.scoped(body);
            if beside {
                self.give_up();
            } else if self.frames.len() == frames
                && self.kernel.is_none()
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
            if let Some(step) = step {
                self.value(step);
            }
        }
        if let Some(why) = self.maybe.clone() {
            // How often it ran is not known, nor what it left.
            look::forget(self, body, &why);
        }
        self.maybe = outer;
        if flow == Flow::Next && self.frames.len() == frames {
            self.folded(before, &all, it.place);
        }
        flow
    }

    /// A loop of which only the run knows when it ends.
    fn open_ended(
        &mut self,
        it: &Stmt,
        condition: &Expr,
        step: Option<&Expr>,
        body: &Stmt,
        why: &Arc<str>,
    ) {
        let step = step.map(look::statement);
        let each = [Some(body), step.as_ref(), Some(&look::statement(condition))];
        if each.iter().flatten().any(|it| look::changes(self, it)) {
            let message = format!("how often this loop runs, {why} decides");
            self.unknown(it.place, message, Some(condition));
        } else if each.iter().flatten().any(|it| look::reads(self, it)) {
            self.unread(it.place, "how often this is read out", why);
        } else if each.iter().flatten().any(|it| look::shows(self, it)) {
            self.unread(it.place, "how often this is shown", why);
        }
        look::forget(self, body, why);
        if self.companion.is_some() {
            look::show(self, body);
        }
        for part in each.into_iter().flatten() {
            look::forget(self, part, why);
        }
    }

    /// Turns that asked the same of the array become one `repeat`, which is stored once.
    fn folded(&mut self, before: usize, all: &[Vec<Item>], place: Place) {
        let Some((first, rest)) = all.split_first() else {
            return;
        };
        let turns = all.iter().map(Vec::len).sum::<usize>();
        let whole = self.items.len() == before + turns;
        if rest.is_empty() || first.is_empty() || self.kernel.is_some() || !whole {
            return;
        }
        if rest.iter().any(|turn| turn != first) {
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
