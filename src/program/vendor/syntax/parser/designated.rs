//! Members that are given by their names: `{.x = 1, .y = 2}`.

use super::{Parsed, Parser, expression::unexpected};
use crate::program::vendor::syntax::tree::{Expr, ExprNode};

impl Parser<'_> {
    /// Behind an opening brace: members by name up to the brace that closes it, if they stand there.
    pub(in crate::program::vendor) fn designated(&mut self) -> Parsed<Option<ExprNode>> {
        const HELP: &str =
            "members are given by name as `{.x = 1, .y = 2}`, or by place as `{1, 2}`";
        let mut all: Vec<(_, Expr)> = Vec::new();
        while self.sees(".") && !self.word(1).is_empty() {
            self.at += 1;
            let name = self.name(HELP)?;
            if !self.take("=") && !self.sees("{") {
                return Err(unexpected(self.peek(0), self.place(), "`=`", HELP));
            }
            all.push((name, self.assignment()?));
            if !self.take(",") && !self.sees("}") {
                return Err(unexpected(self.peek(0), self.place(), "`,` or `}`", HELP));
            }
        }
        if all.is_empty() {
            return Ok(None);
        }
        self.expect("}", HELP)?;
        Ok(Some(ExprNode::Designated(all)))
    }
}
