//! Converts an attempt, live or recorded, to the plain data from which a picture is drawn.

mod align;
mod moment;
mod section;
#[cfg(test)]
mod shadows;
mod stage;

pub use align::Alignment;
pub use moment::{Look, Moment, Telling};
pub use section::draw_section;
pub use stage::{build_stage, hide_what_is_withheld, stage_of_recording};
