//! What a school's things are known by: a type for each kind of them, so that none is taken for another.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use uuid::{NoContext, Timestamp, Uuid};

use crate::Moment;

/// A fresh id that sorts by the moment it was made, for a row that nobody asks for by it.
#[must_use]
pub fn new_id(now: Moment) -> Uuid {
    let (seconds, rest_us) = (now.micros().div_euclid(1_000_000), now.micros().rem_euclid(1_000_000));
    let nanoseconds = (rest_us * 1000) as u32;
    Uuid::new_v7(Timestamp::from_unix(NoContext, seconds.max(0).unsigned_abs(), nanoseconds))
}

/// Types of ids. Each reads and writes what a bare id would: in a database, in JSON, in an address, in a log.
macro_rules! ids {
    ($($(#[$said:meta])+ $name:ident;)+) => {$(
        $(#[$said])+
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
        #[cfg_attr(feature = "sqlx", sqlx(transparent))]
        #[serde(transparent)]
        pub struct $name(Uuid);

        impl $name {
            /// A fresh id that sorts by the moment it was made.
            #[must_use]
            pub fn made_at(now: Moment) -> Self {
                Self(new_id(now))
            }

            /// A fresh id that tells nothing of when it was made.
            #[must_use]
            pub fn random() -> Self {
                Self(Uuid::new_v4())
            }

            /// The id of nothing.
            #[must_use]
            pub const fn nil() -> Self {
                Self(Uuid::nil())
            }

            /// The id with a number.
            #[must_use]
            pub const fn from_u128(number: u128) -> Self {
                Self(Uuid::from_u128(number))
            }

            /// The id that a recording or another program has given it.
            #[must_use]
            pub const fn from_uuid(id: Uuid) -> Self {
                Self(id)
            }

            /// The bare id, for a recording or another program.
            #[must_use]
            pub const fn uuid(self) -> Uuid {
                self.0
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                fmt::Display::fmt(&self.0, f)
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                fmt::Debug::fmt(&self.0, f)
            }
        }

        impl From<$name> for String {
            fn from(id: $name) -> Self {
                id.0.into()
            }
        }

        impl FromStr for $name {
            type Err = uuid::Error;

            fn from_str(text: &str) -> Result<Self, Self::Err> {
                text.parse().map(Self)
            }
        }
    )+};
}

ids! {
    /// A school.
    SchoolId;
    /// A person of a school.
    PersonId;
    /// A cohort of a school.
    CohortId;
    /// An attempt.
    SessionId;
    /// A score that was computed of an attempt.
    ScoreId;
    /// A score that somebody gave an attempt in place of the computed one.
    OverrideId;
    /// What somebody said about an attempt, or answered.
    CommentId;
    /// A document as it was published: an exercise, a course or an instrument.
    RevisionId;
    /// A document that somebody is writing.
    DraftId;
    /// What instructors have assigned.
    AssignmentId;
    /// A task to mark pops in attempts of others.
    TaskId;
    /// An attempt whose pops are to be marked.
    TraceId;
    /// What has a due date: an assignment or a task.
    DatedId;
    /// A validation study.
    StudyId;
    /// A survey.
    SurveyId;
    /// What somebody answered to a survey.
    ResponseId;
    /// A round in which several people rate the same attempts.
    RoundId;
    /// How one person rates one attempt in a round.
    RatingId;
    /// Attempts that are judged again by another rubric.
    RegradingId;
    /// An upload in pieces.
    UploadId;
    /// A list of people that is looked at before it is taken over.
    RosterId;
    /// Something that is new for somebody.
    NoticeId;
    /// A backup that was made, or was not.
    BackupId;
    /// A letter that waits to be sent.
    LetterId;
    /// A token of a person or a station.
    TokenId;
    /// A training station, by its token.
    StationId;
    /// A passkey of a person.
    PasskeyId;
    /// A passkey that somebody is asked to make or to show.
    CeremonyId;
    /// A process that is at work on the database.
    ReplicaId;
    /// Somebody who reads bytes that came at once.
    ReaderId;
}

impl From<AssignmentId> for DatedId {
    fn from(id: AssignmentId) -> Self {
        Self(id.0)
    }
}

impl From<TaskId> for DatedId {
    fn from(id: TaskId) -> Self {
        Self(id.0)
    }
}

impl From<TokenId> for StationId {
    fn from(id: TokenId) -> Self {
        Self(id.0)
    }
}

#[cfg(test)]
mod tests {
    //! An id that is written otherwise than a bare one names nothing that was kept before.

    use super::*;

    #[test]
    fn an_id_is_written_and_read_as_a_bare_one() {
        let bare = Uuid::from_u128(0x018f_5e2a_77aa_7c3e_9c55_7b1d_2f3a_4b5c);
        let id = SchoolId::from_uuid(bare);
        assert_eq!((id.to_string(), String::from(id), id.uuid()), (bare.to_string(), bare.to_string(), bare));
        assert_eq!(format!("{id:?}"), format!("{bare:?}"));
        assert_eq!(serde_json::to_value(id).unwrap(), serde_json::to_value(bare).unwrap());
        assert_eq!(serde_json::from_value::<SchoolId>(bare.to_string().into()).unwrap(), id);
        assert_eq!(bare.simple().to_string().parse::<SchoolId>(), Ok(id));
        assert!("018f5e2a".parse::<SchoolId>().is_err());
    }

    #[test]
    fn ids_sort_by_the_moment_they_were_made() {
        let at = |ms: i64| SessionId::made_at(Moment::from_micros(1_772_668_800_000_000 + 1000 * ms));
        let made = [0, 1, 1000, 86_400_000].map(at);
        assert!(made.is_sorted(), "{made:?}");
    }
}
