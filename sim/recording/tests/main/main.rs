//! The recording as others rely on it: what is written is read, to the bit; what is damaged is noticed; what is cut is
//! saved. Each module says why it could fail.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on says why and stops")]
#![expect(clippy::float_cmp, reason = "what is written and re-simulated must return to the bit")]

mod budget;
mod damage;
/// The messages of viewers as this crate writes them.
#[expect(clippy::enum_variant_names, reason = "the schema names them so")]
mod foxglove {
    include!("../../src/generated/foxglove.rs");
}
mod format;
mod handbook;
mod recover;
mod rewritten;
mod round_trip;
mod support;
mod tables;
