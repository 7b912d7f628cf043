//! What pages show: read-only queries, each limited to what the visitor may see.

mod attempts;
mod groups;
mod school;

pub use attempts::{
    AttemptRecord, ListedAttempt, Stretch, attempts_at, attempts_of, count_attempts, latest_at, latest_taught,
    records_after,
};
pub use groups::{Named, cohort, cohorts, cohorts_in_short, members, pseudonyms, trainee};
pub use school::{Counts, ExerciseInShort, FailingJob, counts, exercises, failing_jobs};
