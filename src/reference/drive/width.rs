//! Wide number formats, which allow sums to be reordered.

use crate::number::{Format, Number};

/// Whether a product is one instruction, and a sum of a few pixels cannot overflow.
pub(super) fn is_wide<N: Number>(number: &N) -> bool {
    matches!(number.format(), Format::F32 | Format::F64)
}
