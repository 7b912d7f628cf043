//! Converts an attempt, live or recorded, to the plain data from which a picture is drawn.

mod align;
mod moment;
mod section;
#[cfg(test)]
mod shadows;
mod stage;

pub use align::Alignment;
use attempt::fluoroscopy::ImagedBody;
use guidance::ImagedNeedle;
pub use moment::{Look, Moment, Telling};
use render::frame::Frame;
pub use section::draw_section;
pub use stage::{build_stage, hide_what_is_withheld, stage_of_recording};

/// Returns the needle of a frame as X-rays show it.
pub fn image_needle(body: &ImagedBody, frame: &Frame) -> ImagedNeedle {
    body.image_needle(frame.tip_m.map(f64::from), frame.orientation.map(f64::from), frame.hub.open)
}
