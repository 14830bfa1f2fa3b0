//! Statements of the chip, and the kernels that they stand in.

use super::{
    Role,
    chip::{self, Given},
    request::term,
    vendors,
};
use crate::{
    config::{Fault, Place, suggestion},
    isa::text::Term,
    program::vendor::{
        host,
        interpreter::{lvalue::base_name, machine::Machine, reason::Reason, value::Value},
        syntax::tree::Expr,
    },
    unit::counted,
};

/// What is told of a call of the host between the begin of a kernel and its end.
pub(in crate::program::vendor) const RECORDING: &str =
    "the host runs this once, while the kernel is recorded, before the kernel's instructions";

/// A readout takes about as long as copying so many values.
const READOUT: usize = 1 << 13;

impl Machine<'_> {
    /// What the micro-controller does is no part of a kernel.
    pub(in crate::program::vendor) fn in_kernel(&mut self, name: &str, place: Place) {
        if self.recording.is_some() {
            self.fault(
                Fault::warning(place, format!("`{name}` inside a kernel"), RECORDING)
                    .help("end the kernel before it, and begin another one after it"),
            );
        }
    }

    /// Warns of a word that no kernel holds, where there are kernels.
    fn outside_of_kernels(&mut self, name: &str, place: Place) {
        if !self.kernels || self.recording.is_some() || self.device.callables(name).is_empty() {
            return;
        }
        self.fault(
            Fault::warning(
                place,
                format!("`{name}` outside of a kernel"),
                "no kernel is open here",
            )
            .help("put it between `scamp5_kernel_begin();` and `scamp5_kernel_end();`: it runs here, but the vendor does not document what happens outside"),
        );
    }

    /// A register is shown: as a picture of what it holds now.
    pub(in crate::program::vendor) fn show(
        &mut self,
        name: &str,
        given: &[Expr],
        place: Place,
    ) -> Value {
        let values: Vec<Value> = given.iter().map(|it| self.value(it)).collect();
        let stack = self.stack.clone().filter(|_| name.contains("bitstack"));
        if let Some(Value::Text(title)) = stack.as_ref().or(values.get(1)) {
            self.titles
                .entry(self.files.line(self.text, place))
                .or_default()
                .insert(title.to_string());
        }
        let Some(register) = values.first() else {
            return Value::Whole(0);
        };
        let divisor = values.get(2).and_then(Value::number).unwrap_or(1.0);
        if name == "scamp5_output_areg" && divisor > 1.0 {
            let samples = divisor * divisor;
            self.fault(
                Fault::warning(
                    place,
                    format!(
                        "the whole register is read here, {samples} times as many samples as on the chip"
                    ),
                    "this call asks for fewer samples",
                )
                .help("`scamp5_scan_areg` with the same steps gives the time of the fewer samples"),
            );
        }
        match term(register) {
            Some(term) => {
                self.in_kernel(name, place);
                // What is shown changes nothing: it may run or not.
                let maybe = self.maybe.take();
                self.ask("scamp5_output_image", vec![term], place);
                self.maybe = maybe;
            }
            None => self.no_argument(name, register, place, given.first()),
        }
        Value::Whole(0)
    }

    fn no_argument(&mut self, name: &str, value: &Value, place: Place, of: Option<&Expr>) {
        match value {
            Value::Unknown(why) => {
                let message = format!("`{name}` takes a value that depends on {why}");
                self.unknown(place, message, why, of);
            }
            other => {
                let message = format!("`{name}` does not take {}", other.describe());
                self.error(
                    place,
                    message,
                    "this call",
                    "it takes registers, directions and numbers",
                );
            }
        }
    }

    /// Warns where light is read a second time in a frame: it is that of one exposure.
    fn light(&mut self, name: &str, place: Place) {
        let captures = matches!(name, "get_image" | "scamp5_get_image" | "getpix");
        if captures && self.dark {
            self.fault(
                Fault::warning(
                    place,
                    format!("`{name}` reads no light: the photodiodes were reset in this frame"),
                    "there is one exposure per frame here",
                )
                .help("put each exposure into its own frame, with `vs_frame_loop_control();`"),
            );
        }
        self.dark |= captures && name != "getpix" || name == "respix";
    }

    /// Where a function is declared whose body is nowhere, and that is nothing of the chip's.
    fn declared_in(&self, name: &str) -> Option<String> {
        let place = self.prototypes.get(name)?.first()?.place;
        let known = !self.device.callables(name).is_empty();
        (!known).then(|| self.line(place))
    }

    /// Tells of a function of the file that takes another number of arguments, where it is nothing of
    /// the chip's.
    fn wrong_number(&mut self, name: &str, given: usize, place: Place) -> bool {
        let all = self.functions.get(name).cloned().unwrap_or_default();
        let own = self.device.callables(name).is_empty() && !name.starts_with("scamp5_");
        let Some(last) = all.last().filter(|_| own) else {
            return false;
        };
        let most = last.parameters.len();
        let least = (0..most)
            .filter(|i| self.default(last, *i).is_none())
            .count();
        let takes = match (&all[..], least == most) {
            ([_], true) => counted(most, "argument"),
            ([_], false) => format!("{least} to {}", counted(most, "argument")),
            _ => "another number of arguments".to_owned(),
        };
        let message = format!("`{name}` takes {takes}, not {given}");
        let help = format!("it is defined in {}", self.line(last.place));
        self.error(place, message, "this call", &help);
        true
    }

    /// Tells of a constant that is declared elsewhere, and not where it is named; whether there is one.
    fn out_of_scope(&mut self, values: &[Given]) -> bool {
        let names = values.iter().filter_map(|(value, place, _)| match value {
            Value::Symbol(name) if self.device.value_of(name).is_none() => Some((name, *place)),
            _ => None,
        });
        let mut declared = names.filter(|(name, _)| self.constants.contains_key(&***name));
        let Some((name, place)) = declared.next() else {
            return false;
        };
        self.undeclared(&name.clone(), place);
        true
    }

    /// A kernel object that is launched.
    fn launched_object(&mut self, given: Option<&Given>, place: Place) -> Value {
        if let Some((Value::Lambda(function), ..)) = given {
            return self.launch(function, place);
        }
        self.error(
            place,
            "this kernel is not defined".to_owned(),
            "what it does is not known",
            "define it before: `kernel([] { … });`",
        );
        Value::Whole(0)
    }

    /// Tells of a function that stands outside of kernels and that neither a file nor the chip has.
    fn nobodys(&mut self, name: &str, place: Place) -> bool {
        let known = !self.device.callables(name).is_empty()
            || self.device.why_no_statement(name, None).is_some();
        let host = self.functions.contains_key("main") && self.recording.is_none();
        if known || !host || vendors(name) {
            return false;
        }
        // A word of the chip that is spelt wrong is told of with the others.
        let words = self.device.all_callables();
        if suggestion(name, words.map(|it| it.signature().name.as_str())).is_some() {
            return false;
        }
        let missing: Vec<String> = { self.missing.iter() }
            .map(|it| format!("`{it}`"))
            .collect();
        let help = match &missing[..] {
            [] => "define it, or `#include` the file that does; a call that serves the host alone can be removed".to_owned(),
            all => format!("it may be declared in {}, which was not found: put that into the same folder as this file", all.join(" or ")),
        };
        let message = format!("the function `{name}` is not defined in any file here");
        self.error(place, message, "this call", &help);
        true
    }

    /// What a call is given; `None` where a buffer holds other numbers than what is read.
    fn passed(&mut self, name: &str, given: &[Expr]) -> Option<Vec<Given>> {
        let reads = host::role(name, given.len()) == Role::Read;
        let value = |it: &Expr| {
            let value = if reads {
                self.buffer(name, it)?
            } else {
                self.value(it)
            };
            Some((value, it.place, base_name(it)))
        };
        given.iter().map(value).collect()
    }

    /// A word, a macro or an operation of the host.
    pub(in crate::program::vendor) fn chip(
        &mut self,
        name: &str,
        given: &[Expr],
        place: Place,
    ) -> Value {
        let Some(values) = self.passed(name, given) else {
            return Value::Whole(0);
        };
        if self.out_of_scope(&values) {
            return Value::Whole(0);
        }
        if name == "scamp5_launch_kernel" {
            return self.launched_object(values.first(), place);
        }
        if let Some(groups) = Self::groups(&values) {
            self.ask_groups(name, groups, place);
            return Value::Whole(0);
        }
        let mut targets = Vec::new();
        // What is shown is written into memory as well.
        if let ("scamp5_output_boundingbox", Some((Value::Pointer(slot, path, _), ..))) =
            (name, values.get(2))
        {
            targets.push((*slot, path.clone()));
        }
        if let Some(file) = self.declared_in(name) {
            self.error(
                place,
                format!("`{name}` is declared in {file}, but not defined in any file here"),
                "this call",
                "`#include` the file that defines it, or define it here",
            );
            return Value::Whole(0);
        }
        if self.wrong_number(name, given.len(), place) {
            return Value::Whole(0);
        }
        self.light(name, place);
        let Some((name, values)) = chip::rewritten(self, name, values, place) else {
            return Value::Whole(0);
        };
        if self.nobodys(&name, place) {
            return Value::Whole(0);
        }
        if name == "DNEWS"
            && let Some(directions) = chip::joined(&values)
        {
            chip::neighbours(self, &values, &directions, place);
            return Value::Whole(0);
        }
        if self.is_host(&name) {
            self.in_kernel(&name, place);
        } else {
            self.outside_of_kernels(&name, place);
        }
        // Only what is read goes into memory; words that are not known are named for that.
        let buffers = host::role(&name, values.len()) == Role::Read
            || self.device.callables(&name).is_empty();
        let mut terms = Vec::new();
        for (i, (value, _, buffer)) in values.iter().enumerate() {
            let term = match value {
                Value::Pointer(..) | Value::Text(_) | Value::List(_) if !buffers => None,
                Value::Pointer(slot, path, _) => {
                    targets.push((*slot, path.clone()));
                    Some(Term::Name(chip::buffer_name(buffer)))
                }
                Value::Text(_) => Some(Term::Name(chip::buffer_name(buffer))),
                other => term(other),
            };
            if let Some(term) = term {
                terms.push(term);
            } else {
                let value = value.clone();
                self.no_argument(&name, &value, place, given.get(i));
                return Value::Whole(0);
            }
        }
        if let ("scamp5_scan_events" | "scamp5_scan_events_rc", Some((_, at, buffer))) =
            (&*name, values.get(1))
        {
            self.scanned_twice(buffer, *at);
        }
        self.ask(&name, terms, place);
        let why: Reason = format!("what `{name}` reads in {}", self.line(place)).into();
        // The count destroys a register, and is read none the less.
        let read = host::role(&name, values.len()) == Role::Read || name == "scamp5_global_count";
        if read && self.companion.is_some() {
            // The array is looked through.
            self.passes(READOUT);
        }
        let answer = { read.then(|| self.run_asked()) }
            .flatten()
            .unwrap_or_default();
        for target in &targets {
            match &answer.memory {
                Some(memory) => self.fill(target, memory, &name, place),
                None => self.forget_from(target.0, &target.1, &why),
            }
        }
        if let Some(value) = answer.value {
            return Value::Whole(value);
        }
        chip::draws_point(self, &name, &values).unwrap_or(Value::Unknown(why))
    }

    /// Two buffers of one sign and channel: their events cannot be told apart.
    fn scanned_twice(&mut self, buffer: &str, at: Place) {
        let known = self.scanned.entry(chip::buffer_name(buffer));
        let first = known.or_insert_with(|| buffer.to_owned());
        if first == buffer {
            return;
        }
        let message = format!("the events of `{first}` and `{buffer}` are taken as one kind");
        self.fault(Fault::warning(at, message, "it has the same sign").help(
            "a buffer holds OFF events if a word of its name is `off`, `neg`, `negative`, `minus` or `falling`, otherwise ON events; `on1` and `off1` are a separate kind",
        ));
    }

    /// `bus({A, B}, {C})`: arguments in braces.
    fn groups(values: &[(Value, Place, String)]) -> Option<Vec<Vec<Term>>> {
        if values.is_empty() {
            return None;
        }
        let lists = values.iter().map(|(value, ..)| match value {
            Value::List(all) => all.iter().map(term).collect(),
            _ => None,
        });
        lists.collect()
    }
}
