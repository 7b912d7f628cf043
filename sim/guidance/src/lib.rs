//! What an imaging device shows: a pure function of the body, the needle and the state of the device.
//!
//! Fluoroscopy: a C-arm with a point source and a flat detector ([`CArm`]), the lengths of the rays in each tissue
//! ([`project`]), seven bins of energy ([`attenuation`]), the exposure control with its dose ([`Exposure`]) and the
//! picture with scatter and quantum noise ([`Radiograph`]).
//!
//! Pure: equal inputs give identical bits. No clock, thread, file or log. Everything is in SI units; the frame is that
//! of the body, +y towards the head and +z out of the back.

pub mod attenuation;
pub mod c_arm;
mod exposure;
mod needle;
mod noise;
mod paths;
mod radiograph;

pub use c_arm::{CArm, Detector};
pub use exposure::{Exposure, KermaLevel};
pub use needle::ImagedNeedle;
pub use paths::{OutOfReach, PathImage, project};
pub use radiograph::{BodyShadow, PIXELS, Pulse, Radiograph, mean_transmission};
