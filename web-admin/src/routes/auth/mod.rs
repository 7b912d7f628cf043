//! Signing in and out, and who is asking.

mod address;
mod csrf;
mod current;
mod half;
mod join;
mod limits;
mod login;
mod proving;
mod refusals;
mod stranger;
mod upload;

pub(crate) use address::ClientAddress;
pub use csrf::{Csrf, CsrfForm, NoFields};
pub(crate) use current::{SignedIn, person_of};
pub use current::{require_person, session_end};
pub use limits::{LoginLimits, PairingLimits};
pub(crate) use login::own_path;
pub use login::{router, signed_in};
pub(crate) use proving::{Asked, Shown, held, hold};
pub use refusals::RefusalLog;
pub(crate) use refusals::{Known, RequestFacts};
pub use stranger::{StrangerToken, settle_stranger};
pub use upload::CsrfUpload;
