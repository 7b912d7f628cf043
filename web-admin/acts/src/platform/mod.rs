//! What knows no school: configuration, keys, files, queues, locks, mail.

pub mod bounded_queue;
pub mod bucket_address;
pub mod clock;
pub mod config;
pub mod fail_points;
pub mod fair_scheduler;
pub(crate) mod files;
pub mod helper;
pub mod keys;
pub mod locks;
pub mod mailer;
pub mod rate_limit_log;
pub mod recording_files;
pub mod recording_store;
pub mod relying_party;
pub mod replay_files;
pub mod scanning;
pub mod sealing;
pub mod secret;
pub mod upload_locks;
