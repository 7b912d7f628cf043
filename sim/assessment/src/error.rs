//! Why an attempt cannot be judged.

use crate::void::Void;

/// An attempt that cannot be judged.
#[derive(Debug, thiserror::Error)]
pub enum AssessError {
    /// The recording holds no samples.
    #[error("the recording holds no usable samples: there is nothing to score")]
    NoSamples,
    /// The recording's times span more than an attempt can last.
    #[error("the recording spans {duration_s} s; at most {longest_s} s are scored")]
    TooLong {
        /// Time from the first sample to the last, in s.
        duration_s: f64,
        /// Longest allowed, in s.
        longest_s: f64,
    },
    /// It tells nothing of whoever made it, and counts nowhere.
    #[error("void: {0}")]
    Void(Void),
    /// The exercise or scene inside is missing or refused.
    #[error("{0}")]
    Document(String),
}
