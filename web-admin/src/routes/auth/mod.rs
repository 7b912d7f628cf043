//! Signing in and out, and who is asking.

mod address;
mod csrf;
mod current;
mod limits;
mod login;

pub(crate) use address::ClientAddress;
pub use csrf::{Csrf, CsrfForm, NoFields};
pub(crate) use current::person_of;
pub use current::require_person;
pub use limits::{LoginLimits, PairingLimits};
pub use login::{STRANGER_SESSION, router, signed_in};
