//! Ids, with one type per kind of object, so that they cannot be confused.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use uuid::{NoContext, Timestamp, Uuid};

use crate::Moment;

/// Returns a new id that sorts by time of creation (UUIDv7), for rows without an id type.
#[must_use]
pub fn new_id(now: Moment) -> Uuid {
    let (seconds, rest_us) = (now.micros().div_euclid(1_000_000), now.micros().rem_euclid(1_000_000));
    let nanoseconds = (rest_us * 1000) as u32;
    Uuid::new_v7(Timestamp::from_unix(NoContext, seconds.max(0).unsigned_abs(), nanoseconds))
}

/// Defines id types. They are represented like a UUID in the database, in JSON, in URLs and in
/// logs.
macro_rules! ids {
    ($($(#[$said:meta])+ $name:ident;)+) => {$(
        $(#[$said])+
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[cfg_attr(feature = "sqlx", derive(sqlx::Type))]
        #[cfg_attr(feature = "sqlx", sqlx(transparent))]
        #[serde(transparent)]
        pub struct $name(Uuid);

        impl $name {
            /// Returns a new id that sorts by time of creation (UUIDv7).
            #[must_use]
            pub fn made_at(now: Moment) -> Self {
                Self(new_id(now))
            }

            /// Returns a new random id that does not reveal its time of creation (UUIDv4).
            #[must_use]
            pub fn random() -> Self {
                Self(Uuid::new_v4())
            }

            /// Returns the nil UUID, which belongs to no object.
            #[must_use]
            pub const fn nil() -> Self {
                Self(Uuid::nil())
            }

            /// Returns the id with this number.
            #[must_use]
            pub const fn from_u128(number: u128) -> Self {
                Self(Uuid::from_u128(number))
            }

            /// Wraps the UUID assigned by a recording or another program.
            #[must_use]
            pub const fn from_uuid(id: Uuid) -> Self {
                Self(id)
            }

            /// Returns the UUID, for a recording or another program.
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
    /// A computed score of an attempt.
    ScoreId;
    /// An override of a computed score.
    OverrideId;
    /// A comment on an attempt, or a reply.
    CommentId;
    /// An attempt that was frozen for an exam board.
    ExamFileId;
    /// A published revision of an exercise, a course or an instrument.
    RevisionId;
    /// A draft of a document.
    DraftId;
    /// An assignment.
    AssignmentId;
    /// A task to mark pops in attempts of others.
    TaskId;
    /// An attempt in a task to mark pops.
    TraceId;
    /// An assignment, task, survey, round of ratings or study of which people are reminded.
    DatedId;
    /// An outcome of training, such as an entrustable professional activity.
    OutcomeId;
    /// A decision on the level of an outcome entrusted to a person.
    EntrustmentId;
    /// A validation study.
    StudyId;
    /// A survey.
    SurveyId;
    /// A response to a survey.
    ResponseId;
    /// A round in which several people rate the same attempts.
    RoundId;
    /// One person's rating of one attempt in a round.
    RatingId;
    /// An exam at one station.
    ExamId;
    /// A candidate's sitting of an exam.
    SittingId;
    /// A re-grading of attempts with another rubric.
    RegradingId;
    /// A resumable upload.
    UploadId;
    /// An uploaded roster waiting for confirmation.
    RosterId;
    /// A notice of a new event for a person.
    NoticeId;
    /// A term of a school.
    TermId;
    /// A record of what was done for a person.
    SupportNoteId;
    /// A backup run.
    BackupId;
    /// A letter to be sent.
    LetterId;
    /// A token of a person or a station.
    TokenId;
    /// A training station, by its token.
    StationId;
    /// A passkey of a person.
    PasskeyId;
    /// A pending WebAuthn challenge.
    CeremonyId;
    /// An OpenID provider that signs the people of a school in.
    ProviderId;
    /// A learning platform from which the people of a school launch this service.
    PlatformId;
    /// A course of a learning platform.
    PlatformContextId;
    /// A link of a learning platform to this service.
    PlatformLinkId;
    /// A choice of content for a course of a learning platform.
    ContentChoiceId;
    /// The grade of a user of such a link, to be sent to the platform.
    DeliveryId;
    /// An account at a provider that belongs to a person.
    IdentityId;
    /// A token of a directory that provisions people.
    ProvisioningTokenId;
    /// A badge for a mastered course.
    BadgeId;
    /// A learning record store of a school.
    RecordStoreId;
    /// A replica: a process that serves the database.
    ReplicaId;
    /// An attempt to parse a recording uploaded in one request.
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

impl From<SurveyId> for DatedId {
    fn from(id: SurveyId) -> Self {
        Self(id.0)
    }
}

impl From<StudyId> for DatedId {
    fn from(id: StudyId) -> Self {
        Self(id.0)
    }
}

impl From<RoundId> for DatedId {
    fn from(id: RoundId) -> Self {
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
    //! Checks that ids are represented like UUIDs, so that stored ids stay valid.

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
