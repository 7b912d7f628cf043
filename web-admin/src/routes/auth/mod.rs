//! Signing in and out, and who is asking.

mod csrf;
mod current;
mod limits;
mod login;

pub use csrf::{Csrf, CsrfForm};
pub(crate) use current::person_of;
pub use current::require_person;
pub use limits::LoginLimits;
pub use login::{STRANGER_SESSION, router, signed_in};
