//! Signing in and out, and who is asking.

mod address;
mod browser;
mod csrf;
mod current;
mod half;
mod join;
mod login;
mod proving;
mod stranger;
mod upload;

pub(crate) use address::{ClientAddress, asked_by};
pub(crate) use browser::{Browser, PageHead, Visit};
pub(super) use csrf::refuse_nul;
pub use csrf::{Csrf, CsrfForm, NoFields, OpenForm};
pub use current::{Administrator, Teacher, Visitor, require_person};
pub(crate) use current::{person_of, start_session};
pub(crate) use login::own_path;
pub use login::{sign_in_routes, signed_in_routes};
pub(crate) use proving::{FactorQuestion, ShownFactor, hold_question, take_held_question};
pub use stranger::{StrangerToken, settle_stranger};
pub use upload::{CsrfFileForm, CsrfUpload, SentFile};
