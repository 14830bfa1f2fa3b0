//! Kernels: C++ is run while their words are recorded, and what is launched are the words.
//!
//! The vendor's macros make a `static` kernel of what stands between `scamp5_kernel_begin` and
//! `_end`: its block is run at the first launch alone, which records it. That of a dynamic kernel is
//! run at each launch.

use std::rc::Rc;

use super::frame_loop::differs;
use crate::{
    config::{Fault, Place},
    program::{
        syntax::{Kept, Kernel as Launched, Node},
        vendor::{
            analysis::{free_variables, unreachable},
            interpreter::{
                machine::{Flow, Machine, Recording},
                value::Value,
            },
            syntax::tree::{Kernel, Read, Stmt, Words},
        },
    },
};

/// How a kernel is recorded at each launch.
const ANEW: &str = "begin it with `scamp5_dynamic_kernel_begin();` and end it with `scamp5_dynamic_kernel_end();`: then it is recorded at each launch";

impl Machine<'_> {
    /// A kernel: records its words, where they are not kept, and launches them.
    pub(in crate::program::vendor) fn kernel(&mut self, it: &Kernel) -> Flow {
        self.ran.insert(unreachable::key(it));
        let words = if it.fixed {
            self.recorded_once(it)
        } else {
            self.recorded_now(it)
        };
        match words {
            Ok(words) => {
                self.launched(&words, (it.begin, it.ordinal));
                Flow::Next
            }
            Err(flow) => flow,
        }
    }

    /// The words of a kernel that is `static`; how control goes on where its block is left.
    fn recorded_once(&mut self, it: &Kernel) -> Result<Words, Flow> {
        let made = self.instance(it.begin, "kernel");
        let key = (it.begin.start, it.ordinal, made);
        if let Some(known) = self.recorded.get(&key).cloned() {
            self.tell_changed(&known, it.begin, ANEW);
            let launches = self.may_launch(&known, it.begin);
            return Ok(if launches { known } else { Words::default() });
        }
        let read = self.read_with_values(&it.body);
        let mut words = self.recorded_now(it)?;
        words.read = Some(self.keep_read(read));
        self.recorded.insert(key, words.clone());
        Ok(words)
    }

    /// Keeps what was read while words were recorded, with the values that it had; where.
    pub(super) fn keep_read(&mut self, read: Vec<(Read, Value)>) -> usize {
        if let Some(same) = self.read.iter().position(|it| **it == *read) {
            return same;
        }
        self.read.push(read.into());
        self.read.len() - 1
    }

    /// Runs the block of a kernel; the words that it asks for.
    fn recorded_now(&mut self, it: &Kernel) -> Result<Words, Flow> {
        let outer = self.begin_recording(it.begin);
        let flow = self.block(&it.body);
        let mut words = self.end_recording();
        if !it.fixed && words.kept == Kept::Store {
            words.kept = Kept::Launch;
        }
        self.recording = outer;
        if flow == Flow::Next || self.done() {
            return Ok(words);
        }
        self.error(
            it.begin,
            "this kernel is left before its end".to_owned(),
            "the chip would record what follows, too",
            "`break`, `continue`, `return` and the frame loop belong outside a kernel",
        );
        Err(flow)
    }

    /// From here on words are recorded; what was recorded before.
    pub(super) fn begin_recording(&mut self, place: Place) -> Option<Recording> {
        if let Some(outer) = &self.recording {
            let fault = Fault::error(place, "a kernel inside a kernel", "begins here")
                .also(outer.place, "the first one")
                .help("end the first one before this one begins");
            self.fault(fault);
        }
        self.kernels = true;
        self.recording.replace(Recording {
            place,
            words: Vec::new(),
            heap: false,
        })
    }

    /// `move_to_heap(true)`: the words of this kernel are not in the chip's store.
    pub(in crate::program::vendor) fn moves_to_heap(&mut self, moved: bool, place: Place) {
        match &mut self.recording {
            Some(recording) => recording.heap = moved,
            None => self.error(
                place,
                "`move_to_heap` outside of a kernel".to_owned(),
                "no kernel is open here",
                "put it between `scamp5_kernel_begin();` and `scamp5_kernel_end();`",
            ),
        }
    }

    /// The words that were recorded.
    pub(super) fn end_recording(&mut self) -> Words {
        let recording = self.recording.take();
        recording.map_or_else(Words::default, |it| Words {
            items: it.words.into(),
            kept: if it.heap { Kept::Heap } else { Kept::Store },
            read: None,
        })
    }

    /// Whether there is room for the words of a kernel once more; tells where only the run knows
    /// whether it is launched.
    pub(super) fn may_launch(&mut self, words: &Words, place: Place) -> bool {
        if let (Some(why), false) = (self.maybe.clone(), words.items.is_empty()) {
            let message = format!("whether this kernel runs depends on {why}");
            self.unknown(place, message, &why, None);
        }
        self.passes(words.items.len());
        self.asks(words.items.len(), place)
    }

    /// Launches the words of a kernel that begins here.
    pub(super) fn launched(&mut self, words: &Words, (begin, ordinal): (Place, usize)) {
        if !words.items.is_empty() {
            let kernel = Launched {
                begins: (begin.start, ordinal),
                kept: words.kept,
                body: words.items.to_vec(),
            };
            self.push(Node::Kernel(kernel), self.files.own(begin));
        }
    }

    /// Warns of a variable that was read while these words were recorded, where it has another value
    /// now.
    pub(super) fn tell_changed(&mut self, words: &Words, place: Place, help: &str) {
        let Some(all) = words.read.map(|at| Rc::clone(&self.read[at])) else {
            return;
        };
        let changed = all.iter().find(|(read, before)| {
            let now = self.read_value(read);
            now.is_some_and(|now| differs(before, &now))
        });
        if let Some((read, _)) = changed {
            let message = format!(
                "this kernel is recorded only at its first launch, but `{}` has changed since",
                read.spelled()
            );
            let fault = Fault::warning(place, message, "the chip keeps the first recording");
            self.fault(fault.help(help));
        }
    }

    /// What the block of a kernel reads of the variables around it, with the values of now.
    pub(super) fn read_with_values(&mut self, body: &[Stmt]) -> Vec<(Read, Value)> {
        let all = free_variables::around(self, body);
        let values = all.into_iter().filter_map(|read| {
            let value = self.read_value(&read)?;
            Some((read, value))
        });
        values.collect()
    }

    /// The value of now of what a block reads.
    fn read_value(&mut self, read: &Read) -> Option<Value> {
        let outer = read.space.clone().map(|space| {
            let base = std::mem::replace(&mut self.base, self.scopes.len());
            (base, std::mem::replace(&mut self.space, space))
        });
        let value = self.lies(&read.of).map(|(slot, path)| {
            match self.at(slot, &path) {
                // Where it leads, and the array that it leads into.
                Value::Pointer(slot, path, _) => match self.array_of(slot, &path) {
                    Some((array, first, _)) => {
                        let first = Value::Whole(first as i64);
                        Value::List(vec![first, self.at(slot, array)])
                    }
                    None => self.at(slot, &path),
                },
                value => value,
            }
        });
        if let Some((base, space)) = outer {
            (self.base, self.space) = (base, space);
        }
        value
    }
}
