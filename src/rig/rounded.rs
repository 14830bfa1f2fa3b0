//! The warning of a kernel that is another one in a number format.

use super::guard::{About, Warning};
use crate::kernel::Loss;

impl Warning {
    /// A sensor of so many kinds of cells, of which a number format makes another by rounding the
    /// weights of a kind.
    #[must_use]
    pub fn rounded(subject: &str, kinds: usize, (kind, loss): (usize, Loss)) -> Self {
        let seen = if kinds > 1 {
            format!("kind {kind}: {loss}")
        } else {
            loss.to_string()
        };
        Self::new(About::Rounded, subject, seen, loss.why(), loss.change())
    }
}

/// Why no cell fires whose kernel a format leaves little of, and what to change.
pub(super) fn reason(loss: &Loss) -> [String; 2] {
    [
        format!("{loss}: hardly anything of the kernel is left"),
        loss.change().to_owned(),
    ]
}
