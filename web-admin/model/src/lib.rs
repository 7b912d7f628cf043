//! Domain model of the service, independent of storage and pages.

#[macro_use(tr)]
extern crate words;

pub mod auth;
pub mod authoring;
pub mod count;
pub mod ids;
pub mod letters;
pub mod limits;
pub mod moment;
pub mod people;
pub mod privacy;
pub mod recordings;
pub mod scoring;
pub mod search_key;
pub mod sending;
pub mod single_line_text;
pub mod studies;
pub mod surveys;
pub mod titles;
pub mod training;

pub use auth::second_factor::{FactorRule, TotpSecret};
pub use count::{count_i64, count_u32};
pub use ids::new_id;
pub use moment::Moment;
pub use people::person::{CurrentPerson, PersonKey, Role};
pub use recordings::attempt_key::SessionKey;
pub use recordings::cursor::AttemptPlace;
pub use recordings::proof::{Needed, Proof, Uncounted};
pub use recordings::replay::Replay;
