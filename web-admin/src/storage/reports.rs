//! What pages show: one query each.
