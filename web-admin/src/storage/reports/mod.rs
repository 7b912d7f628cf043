//! What pages show: read-only queries, each limited to what the visitor may see.

mod attempts;
mod groups;
mod school;

pub use attempts::{ListedAttempt, Stretch, attempts_at, attempts_of, count_attempts, latest_at, latest_taught};
pub use groups::{Named, cohorts, members, trainee};
pub use school::{
    Counts, ExerciseInShort, FailingJob, ListedPerson, counts, exercises, failing_jobs, memberships, people,
};
