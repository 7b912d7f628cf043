//! Fluoroscopy against closed forms and against parry3d.

#![expect(clippy::float_cmp, reason = "the length in steel of a ray outside the needle is exactly 0")]

#[cfg(test)]
mod paths;
#[cfg(test)]
mod pictures;
