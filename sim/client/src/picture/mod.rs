//! From an attempt, live or recorded, to the plain data that a picture is drawn from.

mod align;
mod moment;
mod stage;

pub use align::Alignment;
pub use moment::{Look, Moment, Telling};
pub use stage::{build_stage, hide_what_is_withheld, stage_of_recording};
