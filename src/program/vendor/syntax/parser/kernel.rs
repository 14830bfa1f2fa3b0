//! Kernels: the vendor's macros, which open a block and close it.

use super::{Parsed, Parser, Until};
use crate::{
    config::Fault,
    program::vendor::{
        lexer::token::Token,
        syntax::tree::{Kernel, StmtNode},
    },
};

/// What opens the block of a kernel, and closes it.
const STATIC: [&str; 2] = ["scamp5_kernel_begin", "scamp5_kernel_end"];
const DYNAMIC: [&str; 2] = ["scamp5_dynamic_kernel_begin", "scamp5_dynamic_kernel_end"];
/// What is `static` too, and prints its words as it is recorded.
const PRINTED: &str = "scamp5_kernel_begin_print";

impl Parser<'_> {
    /// Whether a kernel begins here.
    pub(super) fn begins_kernel(&self) -> bool {
        let name = self.word(0);
        let begins = name == STATIC[0] || name == DYNAMIC[0] || name == PRINTED;
        begins && self.peek(1).is_some_and(|t| t.is("("))
    }

    /// Whether a kernel ends here.
    pub(super) fn ends_kernel(&self) -> bool {
        let name = self.word(0);
        let ends = name == STATIC[1] || name == DYNAMIC[1];
        ends && self.peek(1).is_some_and(|t| t.is("("))
    }

    /// What stands between `scamp5_kernel_begin();` and `scamp5_kernel_end();`, with both.
    pub(super) fn kernel(&mut self) -> Parsed<StmtNode> {
        let fixed = self.word(0) != DYNAMIC[0];
        let start = self.place();
        self.border()?;
        let begin = start.to(self.before());
        let ordinal = self.begun_before(start);
        self.inner += 1;
        let body = self.statements(Until::Kernel);
        self.inner -= 1;
        self.declared_twice(&body);
        let [opens, closes] = if fixed { STATIC } else { DYNAMIC };
        if self.begins_kernel() {
            return Err(
                Fault::error(self.place(), "a kernel inside a kernel", "begins here")
                    .also(begin, "the first one")
                    .help(format!("end the first one with `{closes}();`")),
            );
        }
        if !self.ends_kernel() {
            return Err(
                Fault::error(begin, "this kernel has no end", "begins here").help(format!(
                    "end it with `{closes}();`, in the block in which it begins"
                )),
            );
        }
        if self.word(0) != closes {
            return Err(
                Fault::error(self.place(), "this ends another sort of kernel", "here")
                    .also(begin, "the kernel begins here")
                    .help(format!("what `{opens}();` begins, `{closes}();` ends")),
            );
        }
        self.border()?;
        Ok(StmtNode::Kernel(Kernel {
            fixed,
            ordinal,
            body,
            begin,
        }))
    }

    /// Tells of the end of a kernel where none is open.
    pub(super) fn stray_end(&mut self) -> Fault {
        let place = self.place();
        let begin = self.peek(0).and_then(Token::name);
        let begin = if begin.is_some_and(|it| &**it == DYNAMIC[1]) {
            DYNAMIC[0]
        } else {
            STATIC[0]
        };
        Fault::error(place, "this ends no kernel", "none is open in this block")
            .help(format!("begin it with `{begin}();`, in the same block"))
    }

    /// `scamp5_kernel_begin()` and its kin, behind which a `;` may stand.
    fn border(&mut self) -> Parsed<()> {
        self.at += 2;
        self.expect(
            ")",
            "a kernel stands between `scamp5_kernel_begin();` and `scamp5_kernel_end();`",
        )?;
        Ok(())
    }

    /// How many kernels began at a place before this one: all those of a macro do at its call.
    fn begun_before(&mut self, place: crate::config::Place) -> usize {
        let count = self.begun.entry(place.start).or_default();
        *count += 1;
        *count - 1
    }
}
