//! Courses, assignments and progress.

pub mod addresses;
pub mod assignments;
pub mod badge;
pub mod calendar_feed;
pub mod certificate;
pub mod cohort;
pub mod concern;
pub mod curricula;
pub mod gradebook;
pub mod instructor;
pub mod learning_records;
pub mod outcomes;
pub mod paper;
pub mod programme;
pub mod progress;
pub mod qr;
pub mod risk;
pub mod trainee;
pub mod transcript;
