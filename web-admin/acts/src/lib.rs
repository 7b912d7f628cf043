//! Everything that changes something: one function an act, which opens the transaction, checks, writes and notes it in the audit
//! log. Nothing else opens a write transaction.

#[macro_use(tr)]
extern crate words;

pub mod accounts;
pub mod anchoring;
pub mod assignments;
pub mod backup;
pub mod brakes;
pub mod certificates;
pub mod clock;
pub mod config;
pub mod deadlines;
pub mod drafting;
pub mod erasing;
pub mod erasures;
pub mod error;
pub mod intake;
pub mod judging;
pub mod keys;
pub mod killpoints;
pub mod lines;
pub mod locks;
pub mod mailer;
pub mod mailing;
pub mod motions;
pub mod passkeys;
pub mod passwords;
pub mod previews;
pub mod publishing;
pub mod ratings;
pub mod recordings;
pub mod regrading;
pub mod replays;
pub mod retention;
pub mod roster_import;
pub mod scanning;
pub mod scoring;
pub mod sealing;
pub mod second_factor;
pub mod secret;
pub mod segments;
pub mod service;
pub mod shares;
pub mod stations;
pub mod surveys;
pub mod tokens;
pub mod uploads;
pub mod verification;
pub mod web_sessions;

pub use error::Error;
pub use service::Service;
