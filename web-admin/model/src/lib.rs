//! Domain model of the service, independent of storage and pages.

#[macro_use(tr)]
extern crate words;

pub mod assignment;
pub mod attempt_key;
pub mod attempt_place;
pub mod authoring;
pub mod began;
pub mod certificate;
pub mod certificate_note;
pub mod cohort;
pub mod comment;
pub mod corridor;
pub mod count;
pub mod directory;
pub mod draft;
pub mod due;
pub mod email;
pub mod expert_way;
pub mod folding;
pub mod ids;
pub mod judgement;
pub mod limits;
pub mod line;
pub mod mail;
pub mod membership;
pub mod moment;
pub mod notice;
pub mod passkey;
pub mod password_refused;
pub mod person;
pub mod progress;
pub mod proof;
pub mod rating;
pub mod regrading;
pub mod replay;
pub mod retention;
pub mod review;
pub mod roster;
pub mod second_factor;
pub mod segments;
pub mod series;
pub mod study;
pub mod survey;
pub mod texts;
pub mod titles;

pub use attempt_key::SessionKey;
pub use attempt_place::AttemptPlace;
pub use count::{count_i64, count_u32};
pub use ids::new_id;
pub use moment::Moment;
pub use person::{CurrentPerson, PersonKey, Role};
pub use proof::{Needed, Proof, Uncounted};
pub use replay::Replay;
pub use second_factor::{FactorRule, TotpSecret};
