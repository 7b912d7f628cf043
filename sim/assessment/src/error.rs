//! Errors of judging an attempt.

use phrase::{Phrase, phrase};

use crate::void::Void;

/// An attempt that cannot be judged.
#[derive(Debug, thiserror::Error)]
#[error("{}", self.phrase())]
pub enum AssessError {
    /// The recording holds no samples.
    NoSamples,
    /// The recording's times span more than an attempt can last.
    TooLong {
        /// Time from the first sample to the last, in s.
        duration_s: f64,
        /// Longest allowed, in s.
        longest_s: f64,
    },
    /// The attempt is void: it does not reflect the trainee's skill and is not counted.
    Void(Void),
    /// The attached exercise or scene is missing or refused.
    Document(String),
}

impl AssessError {
    /// Returns the translatable message.
    #[must_use]
    pub fn phrase(&self) -> Phrase {
        match self {
            Self::NoSamples => phrase!("the recording contains no usable samples, so it cannot be scored"),
            Self::TooLong { duration_s, longest_s } => phrase!(
                "the recording lasts {duration} s; at most {longest} s can be scored",
                duration = Phrase::Number(duration_s.to_string()),
                longest = Phrase::Number(longest_s.to_string())
            ),
            Self::Void(void) => phrase!("void: {why}", why = void.phrase()),
            Self::Document(why) => Phrase::data(why),
        }
    }
}
