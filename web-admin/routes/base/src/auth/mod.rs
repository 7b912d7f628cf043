//! Authentication of requests, and CSRF protection of forms.

mod address;
mod browser;
mod csrf;
mod current;
mod stranger;
mod upload;

pub use address::{ClientAddress, asked_by};
pub use browser::{Browser, PageHead, Visit};
pub use csrf::{CheckedForm, Csrf, CsrfForm, NoFields, OpenForm, begin_token, refuse_form, refuse_nul};
pub use current::{
    Administrator, SignInStanding, Teacher, Visitor, find_signed_in, person_of, require_person, standing_of,
    start_factored_session, start_session,
};
pub use stranger::{BrowserToken, StrangerToken, settle_stranger};
pub use upload::{CsrfFileForm, CsrfUpload, SentFile};
