//! The type of an expression, as far as its text and the variables in it say: without running it.

use crate::program::vendor::{
    interpreter::{
        machine::{Location, Machine},
        scope::foreign,
        value::Value,
    },
    syntax::tree::{Expr, ExprNode, Kind, LIMIT, Width, last},
};

impl Kind {
    /// What a number becomes in arithmetic.
    const fn promoted(self) -> Self {
        match self {
            Self::Flag | Self::Bits(8 | 16, _) => Self::INT,
            other => other,
        }
    }

    /// What two numbers become between which an operator stands.
    fn common(self, other: Self) -> Self {
        if self == other && !matches!(self, Self::Analog | Self::Digital | Self::Parameter(_)) {
            return self;
        }
        match (self.promoted(), other.promoted()) {
            (Self::Bits(a, one), Self::Bits(b, two)) => {
                let bits = a.max(b);
                let signed = |of, signed| signed || of < bits;
                Self::Bits(bits, signed(a, one) && signed(b, two))
            }
            (Self::Real, Self::Bits(..) | Self::Float | Self::Real)
            | (Self::Bits(..) | Self::Float, Self::Real) => Self::Real,
            (Self::Float, Self::Bits(..) | Self::Float) | (Self::Bits(..), Self::Float) => {
                Self::Float
            }
            _ => Self::Any,
        }
    }
}

impl Machine<'_> {
    /// The type of the number that an expression gives; `Any` where that is not known so.
    pub(in crate::program::vendor) fn kind_of(&self, it: &Expr) -> Kind {
        self.looks(1);
        match &it.node {
            ExprNode::Whole(_) => Kind::INT,
            ExprNode::Wide(_, Width::Unsigned) => Kind::Bits(32, false),
            ExprNode::Wide(_, Width::Long) => Kind::Bits(64, true),
            ExprNode::Wide(_, Width::UnsignedLong) | ExprNode::SizeOf(_) => Kind::Bits(64, false),
            ExprNode::Real(_) => Kind::Real,
            ExprNode::Convert(kind, _) => self.resolved(*kind),
            ExprNode::Unary("!", _)
            | ExprNode::Binary("<" | ">" | "<=" | ">=" | "==" | "!=" | "&&" | "||", ..) => {
                Kind::Flag
            }
            ExprNode::Binary(",", _, of) => self.kind_of(of),
            ExprNode::Unary("-" | "+" | "~", of) | ExprNode::Binary("<<" | ">>", of, _) => {
                self.kind_of(of).promoted()
            }
            ExprNode::Binary(_, a, b) => self
                .kind_of(a)
                .promoted()
                .common(self.kind_of(b).promoted()),
            ExprNode::Choose(_, a, b) => self.kind_of(a).common(self.kind_of(b)),
            ExprNode::Assign(_, to, _) | ExprNode::Step(to, ..) => self.kind_of(to),
            ExprNode::Call(callee, given) => match (&callee.node, &given[..]) {
                (ExprNode::Name(name), [limit, of]) if &**name == LIMIT => match &limit.node {
                    ExprNode::Text(limit) if limit.starts_with("is_") => Kind::Flag,
                    ExprNode::Text(limit) if limit.starts_with("digits") => Kind::INT,
                    _ => self.kind_of(of),
                },
                // Of the type that both have.
                (ExprNode::Name(name), [a, b])
                    if foreign(name) && matches!(last(name), "max" | "min") =>
                {
                    let kind = self.kind_of(a);
                    if kind == self.kind_of(b) {
                        kind
                    } else {
                        Kind::Any
                    }
                }
                _ => self.kind_given(callee, given.len()),
            },
            ExprNode::Index(of, _) | ExprNode::Unary("*", of) if self.is_text(of) => {
                Kind::CHARACTER
            }
            ExprNode::Name(_)
            | ExprNode::Member(..)
            | ExprNode::Index(..)
            | ExprNode::Unary("*", _) => self.lies(it).map_or(Kind::Any, |(slot, path)| match self
                .kind_at(slot, &path)
            {
                Kind::Any => self.peek(slot, &path).map_or(Kind::Any, Value::kind),
                kind => kind,
            }),
            _ => Kind::Any,
        }
    }

    /// Whether an expression is a text, or a place in one.
    fn is_text(&self, it: &Expr) -> bool {
        if let ExprNode::Binary("+", a, b) = &it.node {
            return self.is_text(a) || self.is_text(b);
        }
        let held = || {
            let (slot, path) = self.led_to(it)?;
            Some(matches!(self.peek(slot, &path)?, Value::Text(_)))
        };
        matches!(it.node, ExprNode::Text(_)) || held().unwrap_or(false)
    }

    /// The type of the number that a function of the file gives back, where all of its name agree.
    fn kind_given(&self, callee: &Expr, given: usize) -> Kind {
        let all = match &callee.node {
            ExprNode::Name(name) => self.functions.get(last(name)).cloned().unwrap_or_default(),
            ExprNode::Member(of, name) => {
                let object = self.led_to(of).and_then(|(slot, path)| {
                    let Value::Record(layout, _) = self.peek(slot, &path)? else {
                        return None;
                    };
                    Some(self.own_functions(layout, name, given))
                });
                object.unwrap_or_default()
            }
            _ => return Kind::Any,
        };
        let mut kinds = all.iter().map(|it| it.returns);
        match kinds.next() {
            Some(Kind::Parameter(_)) | None => Kind::Any,
            Some(first) if kinds.all(|it| it == first) => first,
            Some(_) => Kind::Any,
        }
    }

    /// Where the value of an expression lies, or another element of the same array.
    pub(in crate::program::vendor) fn lies(&self, it: &Expr) -> Option<Location> {
        match &it.node {
            ExprNode::Name(name) => self.named_location(name),
            ExprNode::Unary("*", of) | ExprNode::Index(of, _) => {
                let (slot, mut path) = self.led_to(of)?;
                match self.peek(slot, &path)? {
                    Value::List(_) => path.push(0),
                    // A class of its own may say what an element is.
                    Value::Record(..) | Value::Text(_) => return None,
                    _ => {}
                }
                Some((slot, path))
            }
            ExprNode::Member(of, name) => {
                let (slot, mut path) = self.led_to(of)?;
                let Value::Record(layout, _) = self.peek(slot, &path)? else {
                    return None;
                };
                path.push(layout.members.iter().position(|it| it.name == *name)?);
                Some((slot, path))
            }
            _ => None,
        }
    }

    /// Where a pointer leads that lies somewhere, or what is no pointer.
    fn led_to(&self, it: &Expr) -> Option<Location> {
        let (slot, path) = self.lies(it)?;
        match self.peek(slot, &path)? {
            Value::Pointer(slot, path, _) => Some((*slot, path.clone())),
            _ => Some((slot, path)),
        }
    }
}
