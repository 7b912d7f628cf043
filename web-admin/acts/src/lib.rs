//! All operations that change data: one function per operation, which opens the transaction,
//! checks, writes, and appends to the audit log. Nothing else opens a write transaction.
//!
//! Every function that uses the database can fail with a database error; `# Errors` sections list
//! the other errors.

#[macro_use(tr)]
extern crate words;

pub mod accounts;
pub mod anchoring;
pub mod asking;
pub mod assignments;
pub mod authoring;
pub mod backup;
pub mod brake_notes;
pub mod brakes;
pub mod bucket_address;
pub mod bulk;
pub mod certificates;
pub mod checksum;
pub mod clock;
pub mod cohorts;
pub mod comments;
pub mod config;
pub mod consents;
mod copying;
pub mod course_changes;
pub mod deadlines;
pub mod drafting;
pub mod erasing;
pub mod erasure_store;
pub mod erasures;
pub mod error;
pub mod generating;
pub mod helper;
mod holds;
pub mod importing;
pub mod inspection;
pub mod intake;
pub mod judging;
pub mod key_files;
pub mod keys;
pub mod killpoints;
pub mod lines;
pub mod locks;
pub mod mailer;
pub mod mailing;
pub mod motions;
pub mod moving;
pub mod notices;
pub mod passkeys;
pub mod passwords;
pub mod picturing;
pub mod previews;
pub mod publishing;
pub mod ratings;
pub mod recording_files;
pub mod recording_links;
pub mod recording_store;
pub mod recordings;
pub mod registry;
pub mod regrading;
pub mod relying_party;
mod removing;
pub mod replay_files;
pub mod replays;
pub mod replicas;
pub mod researching;
pub mod retention;
pub mod reviewing;
pub mod room;
pub mod roster_import;
pub mod scanning;
pub mod schools;
pub mod scoring;
pub mod sealing;
pub mod second_factor;
pub mod secret;
pub mod segments;
pub mod service;
pub mod shares;
pub mod signing_in;
pub mod statement_store;
pub mod stations;
pub mod studies;
pub mod study_consents;
pub mod study_keeping;
pub mod surveys;
pub mod tokens;
pub mod turns;
pub mod upkeep;
pub mod uploads;
pub mod verification;
pub mod web_sessions;
mod webauthn_challenges;

pub use error::Error;
pub use service::Service;

/// Target of the spans exported to a collector; the log omits them.
pub const SPANS: &str = "spans";

/// Sets the default TLS crypto provider, for dependencies that do not choose one.
#[cfg(feature = "replicas")]
pub fn settle_tls() {
    // Fails only if a provider has been set already, which is fine.
    let _ = rustls::crypto::ring::default_provider().install_default();
}
