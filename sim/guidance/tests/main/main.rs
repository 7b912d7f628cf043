//! Fluoroscopy against closed forms and against parry3d.

#![expect(clippy::float_cmp, reason = "a ray beside a needle meets no steel at all")]

#[cfg(test)]
mod paths;
#[cfg(test)]
mod pictures;
