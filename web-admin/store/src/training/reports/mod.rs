//! Read-only queries for pages, each limited to data that the viewer may see.

mod attempts;
mod groups;
mod school;

pub use attempts::{
    AttemptRecord, ListStretch, ListedAttempt, attempts_at, attempts_of, count_attempts, latest_at, latest_taught,
    records_after,
};
pub use groups::{NamedItem, cohort, cohorts, cohorts_in_short, members, pseudonyms, registrar_ids, trainee};
pub use school::{ExerciseInShort, FailingJob, SchoolCounts, counts, exercises, failing_jobs};
