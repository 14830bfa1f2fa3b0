//! Which number formats are wide: that changes how a sum is taken.

use crate::number::{Format, Number};

/// Whether a product is one instruction, and a sum of a few pixels stays in range.
pub(super) fn is_wide<N: Number>(number: &N) -> bool {
    matches!(number.format(), Format::F32 | Format::F64)
}
