//! An attempt as others rely on it: what is simulated says what the law says, and re-simulates to the bit. Each module says why it
//! could fail.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on says why and stops")]
#![expect(clippy::float_cmp, reason = "what is written and re-simulated must return to the bit")]

mod field;
mod fluoroscopy;
mod simulated;
mod support;
