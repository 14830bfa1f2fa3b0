//! What a run has measured, a row for each.
