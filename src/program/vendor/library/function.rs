//! Functions of the language's library and of the vendor's host.

use crate::{
    config::{Fault, Place},
    program::vendor::{
        frame::beside::Companion,
        host,
        interpreter::{
            lvalue::{Reach, base_name},
            machine::{GAIN, Machine},
            shape,
            value::Value,
        },
        syntax::tree::{Expr, ExprNode, Kind},
    },
};

impl Machine<'_> {
    /// `static_assert(condition, "why")`
    pub(in crate::program::vendor) fn asserted(&mut self, given: &[Expr], place: Place) -> Value {
        let holds = given.first().map(|it| self.value(it));
        let why = match given.get(1).map(|it| &it.node) {
            Some(ExprNode::Text(text)) => format!(": {text}"),
            _ => String::new(),
        };
        match holds.as_ref().map(Value::number) {
            Some(Some(value)) if value != 0.0 => {}
            Some(Some(_)) => self.error(
                place,
                format!("`static_assert` failed{why}"),
                "this condition is false",
                "correct what it checks",
            ),
            _ => self.error(
                place,
                "`static_assert` needs a compile-time constant".to_owned(),
                "this condition",
                "give it a compile-time constant, or remove it",
            ),
        }
        Value::Whole(0)
    }

    /// `std::vector name(length, value)`, `std::vector<type>(length)`
    pub(in crate::program::vendor) fn filled(&mut self, given: &[Expr], place: Place) -> Value {
        let all: Vec<Value> = given.iter().map(|it| self.value(it)).collect();
        match &all[..] {
            [copied @ Value::List(_)] => return copied.clone(),
            [from @ Value::Pointer(..), to @ Value::Pointer(..)] => {
                let rows = match from {
                    Value::Pointer(slot, path, _) => {
                        let characters = matches!(self.kind_at(*slot, path), Kind::Bits(8, _));
                        characters && !self.is_library(*slot, path)
                    }
                    _ => false,
                };
                let copied = self.copied_range(from, to);
                let copied = if rows { copied.map(spelled) } else { copied };
                return copied.unwrap_or_else(|| Value::Unknown("what an array copies".into()));
            }
            _ => {}
        }
        let Some(length) = all.first().map_or(Some(0), Value::whole) else {
            return Value::Unknown("an array whose length is known only at run time".into());
        };
        let value = all.get(1).unwrap_or(&Value::Whole(0));
        match usize::try_from(length) {
            Ok(length) if self.fits(length.saturating_mul(value.size()), place) => {
                Value::List(vec![value.clone(); length])
            }
            Ok(_) => Value::Whole(0),
            Err(_) => {
                let message = format!("an array of {length} elements");
                self.error(
                    place,
                    message,
                    "this length",
                    "give it a length of 0 or more",
                );
                Value::Whole(0)
            }
        }
    }

    /// `std::max({a, b, c})`
    pub(in crate::program::vendor) fn extreme(
        &mut self,
        name: &str,
        of: &Expr,
        place: Place,
    ) -> Value {
        let listed = self.value(of);
        let listed = match listed {
            Value::Unknown(why) => return Value::Unknown(why),
            Value::List(all) => all,
            other => vec![other],
        };
        let mut best: Option<(f64, Value)> = None;
        for it in listed {
            let number = match (&it, it.number()) {
                (Value::Unknown(_), _) => return it,
                (_, Some(number)) => number,
                (_, None) => {
                    let message = format!("`{name}` of {}", it.describe());
                    self.error(place, message, "this call", "give it numbers in braces");
                    return Value::Whole(0);
                }
            };
            let better = |(known, _): &(f64, Value)| match name {
                "max" => number > *known,
                _ => number < *known,
            };
            if best.as_ref().is_none_or(better) {
                best = Some((number, it));
            }
        }
        best.map_or(Value::Whole(0), |it| it.1)
    }

    /// `std::swap(a, b)`
    pub(in crate::program::vendor) fn swapped(&mut self, a: &Expr, b: &Expr) -> Value {
        let (first, second) = (self.reach(a), self.reach(b));
        let raw = |reached: &Reach| match reached {
            Reach::Location(slot, path) => Some(self.at(*slot, path)),
            _ => None,
        };
        let (one, other) = match (raw(&first), raw(&second)) {
            (Some(one), Some(other)) => (one, other),
            _ => (self.load(&first, a), self.load(&second, b)),
        };
        self.store(&first, other, a);
        self.store(&second, one, b);
        Value::Whole(0)
    }

    pub(in crate::program::vendor) fn number(
        &mut self,
        name: &str,
        given: &[Expr],
        place: Place,
    ) -> Value {
        let values: Vec<Value> = given.iter().map(|it| self.value(it)).collect();
        if let Some(Value::Unknown(why)) = values.iter().find(|it| matches!(it, Value::Unknown(_)))
        {
            return Value::Unknown(why.clone());
        }
        let numbers: Vec<f64> = values.iter().filter_map(Value::number).collect();
        let whole = values
            .iter()
            .all(|it| matches!(it, Value::Whole(_) | Value::Wide(..)));
        let Some(result) = host::number(name, &numbers) else {
            self.error(
                place,
                format!("`{name}` of a number that is not known"),
                "this call",
                "give it known numbers; for other functions of the math library, write the value itself",
            );
            return Value::Whole(0);
        };
        match (name, &values[..]) {
            ("abs" | "min" | "max" | "clamp", [first, ..]) if whole => {
                Value::from_number(result).converted(first.kind())
            }
            (
                "lround" | "lroundf" | "llround" | "lrint" | "lrintf" | "llrint" | "labs" | "llabs",
                _,
            ) => Value::Real(result).converted(Kind::Bits(64, true)),
            ("isnan" | "isinf" | "isfinite" | "signbit", _) => Value::Whole(result as i64),
            // `sqrtf` and its kin, and what is chosen of numbers of 32 bits.
            ("abs" | "fabs" | "min" | "max" | "clamp", [first, ..]) => {
                let narrow = values.iter().all(|it| matches!(it, Value::Single(_)));
                if narrow {
                    Value::Real(result).converted(first.kind())
                } else {
                    Value::Real(result)
                }
            }
            _ if name.ends_with('f')
                && host::number(&name[..name.len() - 1], &numbers).is_some() =>
            {
                Value::Real(result).converted(Kind::Float)
            }
            _ => Value::Real(result),
        }
    }

    /// What a function of the library is given. Callbacks run when somebody moves a slider.
    fn given_to(&mut self, name: &str, given: &[Expr], place: Place) -> Vec<Value> {
        let mut values = Vec::new();
        for it in given {
            if matches!(it.node, ExprNode::Lambda(_)) {
                continue;
            }
            let mut value = self.raw(it);
            self.keeps_register(name, &value, place);
            if let (Value::Symbol(held), true) = (&value, writes(name))
                && !self.known(held)
            {
                value = self.unheard(&held.clone(), it.place);
            }
            values.push(value);
        }
        values
    }

    /// The GUI and the box. Sliders and switches are settings, with their defaults.
    pub(in crate::program::vendor) fn library(
        &mut self,
        name: &str,
        given: &[Expr],
        place: Place,
    ) -> Value {
        let naming = self.naming.take();
        let slider = match name {
            "vs_gui_add_slider" | "vs_gui_add_slider_latched" => Some((3, 4)),
            "vs_gui_add_switch" => Some((1, 2)),
            _ => None,
        };
        if let Some((at, target)) = slider {
            let default = given.get(at).map(|it| self.value(it));
            let pointed = { given.get(target) }.map(|it| (self.setting(it), self.value(it)));
            let name = match (&pointed, naming) {
                (Some((name, _)), _) => name.clone(),
                (None, Some(name)) => name.to_string(),
                (None, None) => String::new(),
            };
            let set = self.set(&name);
            if let (3, Some(set)) = (at, &set) {
                self.slider_range(&name, set, given, place);
            }
            let kind = match &pointed {
                Some((_, Value::Pointer(slot, path, _))) => self.kind_at(*slot, path),
                _ => Kind::Any,
            };
            // A variable of its own name was told of where it is declared.
            let declared =
                matches!(&pointed, Some((_, Value::Pointer(_, path, _))) if path.is_empty());
            if let (Some(set), false) = (&set, declared) {
                self.set_within(&name, (set, kind), place);
            }
            let fixed = self.companion.is_some() && set.is_some();
            let value = set.or(default).unwrap_or(Value::Whole(0));
            let value = value.converted(kind);
            if let (false, Some(number)) = (name.is_empty(), value.number()) {
                self.constants.insert(name, number);
            }
            // A handle leads to what the slider writes, or to a number of its own.
            let (slot, path) = match pointed {
                Some((_, Value::Pointer(slot, path, _))) => {
                    self.put(slot, &path, value);
                    (slot, path)
                }
                _ => (self.hold(value, kind), Vec::new()),
            };
            if fixed && path.is_empty() {
                self.fixed.insert(slot);
            }
            return Value::Pointer(slot, path, "a slider".into());
        }
        let values = self.given_to(name, given, place);
        self.requested(name, &values, place);
        if let Some(found) = self.of_text(name, &values, place) {
            return found;
        }
        if written(name) {
            self.written_by(name, &values);
        }
        match name {
            "vs_post_text" | "printf" | "puts" => {
                self.post(&values, place);
                Value::Whole(0)
            }
            "scamp5_output_bitstack_begin" => {
                self.stack = values.first().cloned();
                Value::Whole(0)
            }
            "vs_gui_add_display" => match values.into_iter().next() {
                Some(Value::Text(text)) => Value::Text(text),
                _ => Value::Text("".into()),
            },
            "vs_gui_read_slider" => {
                self.slider = given.first().map_or_else(String::new, base_name);
                self.read_slider(values)
            }
            "vs_gui_move_slider" | "vs_gui_set_slider" => {
                self.move_slider(&values);
                Value::Whole(0)
            }
            "vs_loop_counter_get" => self.loop_counter(),
            "vs_loop_counter_reset" => {
                if let Some(companion) = &mut self.companion {
                    companion.counted = 0;
                }
                Value::Whole(0)
            }
            "vs_loop_counter_inc" => {
                self.count_turn();
                Value::Whole(0)
            }
            "vs_frame_trigger_set" | "vs_enable_frame_trigger" | "vs_disable_frame_trigger" => {
                self.triggers(name, &values);
                Value::Whole(0)
            }
            "vs_wait" => {
                self.waits(&values);
                Value::Whole(0)
            }
            "to_string" => as_text(&values),
            // Nothing that was asked for is on its way.
            "vs_gui_is_on" | "vs_gui_request_done" => Value::Whole(1),
            "rand" if self.companion.is_some() => {
                Value::Whole(self.companion.as_mut().map_or(0, Companion::random))
            }
            _ => Value::Unknown(format!("`{name}`").into()),
        }
    }

    /// Tells of a picture or a file that the GUI is asked for.
    fn requested(&mut self, name: &str, given: &[Value], place: Place) {
        let (what, help) = match name {
            "vs_gui_request_image" => (
                "picture",
                "give the picture as the scene (`exec --image FILE`) and read it with `get_image(A);`, or remove this call and load a register with `exec --set REGISTER=FILE.npy`",
            ),
            "vs_gui_request_file" => (
                "file",
                "put its contents into a source file in the same folder, as an array of constants",
            ),
            _ => return,
        };
        let file = match given.first() {
            Some(Value::Text(file)) => format!(", `{file}`,"),
            _ => ",".to_owned(),
        };
        let message = format!("`{name}` asks the GUI for a {what}{file} but there is no GUI here");
        self.error(place, message, "this call", help);
    }

    /// The slider of the gain, which every program has.
    fn frame_gain(&mut self) -> Value {
        let set = self.set("frame_gain");
        let value = set.unwrap_or_else(|| self.at(GAIN, &[]));
        let number = value.number().unwrap_or(1.0);
        self.constants.insert("frame_gain".to_owned(), number);
        value
    }

    fn read_slider(&mut self, values: Vec<Value>) -> Value {
        match values.into_iter().next() {
            Some(Value::Pointer(slot, path, _)) => self.at(slot, &path),
            Some(Value::Symbol(gain)) if &*gain == "VS_GUI_FRAME_GAIN" => self.frame_gain(),
            _ => Value::Unknown("a slider of the GUI".into()),
        }
    }

    /// A program moves a slider itself.
    fn move_slider(&mut self, values: &[Value]) {
        match values {
            [Value::Pointer(slot, path, _), value, ..] => {
                let kind = self.kind_at(*slot, path);
                self.put(*slot, path, value.clone().converted(kind));
            }
            [Value::Symbol(gain), value, ..] if &**gain == "VS_GUI_FRAME_GAIN" => {
                self.put(GAIN, &[], value.clone());
            }
            _ => {}
        }
    }

    /// What is only there where the vendor simulates the chip: here the chip is meant, but for the
    /// pictures that are saved.
    pub(in crate::program::vendor) fn simulated(
        &mut self,
        name: &str,
        given: &[Expr],
        place: Place,
    ) -> Value {
        match name {
            "save_image" => self.show(name, given, place),
            "is_simulation" => {
                let value = self.set(name).unwrap_or(Value::Whole(0));
                let number = value.number().unwrap_or_default();
                self.constants.insert(name.to_owned(), number);
                value
            }
            "pix_integrate" => {
                self.fault(
                    Fault::warning(
                        place,
                        "`pix_integrate` does nothing: the light comes from the scene",
                        "this call",
                    )
                    .help("give the scene with `exec --image`"),
                );
                Value::Whole(0)
            }
            _ => self.library(name, given, place),
        }
    }

    /// The name that a slider's variable is set by: `name`, `name[0]`, `name.member`.
    fn setting(&mut self, it: &Expr) -> String {
        match &it.node {
            ExprNode::Unary(_, of) | ExprNode::Convert(_, of) | ExprNode::Recast(_, of) => {
                self.setting(of)
            }
            ExprNode::Member(of, member) => format!("{}.{member}", self.setting(of)),
            ExprNode::Index(of, at) => match self.value(at).whole() {
                Some(at) => format!("{}[{at}]", self.setting(of)),
                None => self.setting(of),
            },
            _ => base_name(it),
        }
    }

    /// A slider that is set beyond its ends, which the GUI would not do.
    fn slider_range(&mut self, name: &str, set: &Value, given: &[Expr], place: Place) {
        let mut ends = given
            .iter()
            .skip(1)
            .take(2)
            .map(|it| self.value(it).number());
        let (Some(Some(low)), Some(Some(high))) = (ends.next(), ends.next()) else {
            return;
        };
        let Some(value) = set.number().filter(|it| !(low..=high).contains(it)) else {
            return;
        };
        self.fault(
            Fault::warning(
                place,
                format!("`{name}` is set to {value}, but its slider goes from {low} to {high}"),
                "this slider",
            )
            .help(format!("give `{name}` a value from {low} to {high}")),
        );
    }
}

/// Rows of characters as the texts that they hold: nothing else is made of them.
fn spelled(copied: Value) -> Value {
    let Value::List(all) = copied else {
        return copied;
    };
    let row = |it: Value| match it {
        Value::List(codes) => {
            let ends = |it: &Value| it.whole() == Some(0);
            let length = codes.iter().position(ends).unwrap_or(codes.len());
            let numbers = codes.iter().all(|it| matches!(it, Value::Whole(_)));
            if numbers {
                shape::text(Value::List(codes[..length].to_vec()))
            } else {
                Value::List(codes)
            }
        }
        it => it,
    };
    Value::List(all.into_iter().map(row).collect())
}

/// `std::to_string(number)`
fn as_text(given: &[Value]) -> Value {
    match given {
        [value @ (Value::Whole(_) | Value::Wide(..))] => Value::Text(value.written().into()),
        [value @ (Value::Real(_) | Value::Single(_))] => {
            let value = value.number().unwrap_or_default();
            Value::Text(format!("{value:.6}").into())
        }
        _ => Value::Unknown("a number as text".into()),
    }
}

/// Whether a function of the library writes what it is given the place of.
fn written(name: &str) -> bool {
    !name.starts_with("vs_post")
        && !name.starts_with("vs_gui")
        && !name.starts_with("vs_on_")
        && !name.starts_with("scamp5_display")
        && name != "printf"
}

/// Whether a function of the library writes the values that it is given.
fn writes(name: &str) -> bool {
    matches!(
        name,
        "vs_post_text" | "printf" | "puts" | "sprintf" | "snprintf"
    )
}
