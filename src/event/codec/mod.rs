//! The codings of address events.
