//! Attempts: what was uploaded, by whom, and who may see it.

use model::ids::{PersonId, RevisionId, SchoolId, SessionId, StationId};
use model::{AttemptPlace, CurrentPerson, Moment, PersonKey, Role, SessionKey, Uncounted};
use serde::{Deserialize, Serialize};
use sqlx::FromRow;

use super::engine::twin;
use super::{Connection, Executor, Result};

/// What became of an uploaded recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, sqlx::Type, utoipa::ToSchema)]
#[serde(rename_all = "lowercase")]
#[sqlx(type_name = "text", rename_all = "lowercase")]
pub enum SessionState {
    /// On disk, waiting to be scored.
    Pending,
    /// Scored.
    Scored,
    /// Read, but not to be scored; the reason stands beside it.
    Refused,
}

impl SessionState {
    /// As the API and the database say it.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Pending => "pending",
            Self::Scored => "scored",
            Self::Refused => "refused",
        }
    }
}

/// An attempt.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct Session {
    /// Id, made by the client.
    pub id: SessionId,
    /// School.
    pub school_id: SchoolId,
    /// Who tried.
    pub trainee_id: PersonId,
    /// Exercise id.
    pub exercise_id: String,
    /// SHA-256 of the exercise document.
    pub exercise_sha256: String,
    /// SHA-256 of the scene document.
    pub scene_sha256: String,
    /// The published revision; absent when this school never published the recording's exercise.
    pub revision_id: Option<RevisionId>,
    /// When the attempt began, as far as its recording is believed.
    pub started_at: Moment,
    /// When it began by what the recording says, where that is not believed.
    pub claimed_started_at: Option<Moment>,
    /// When the upload was acknowledged.
    pub received_at: Moment,
    /// Length, in s.
    pub duration_s: f64,
    /// The recording has its end; a cut one has not.
    pub complete: bool,
    /// Device.
    pub device: String,
    /// Version of the simulator.
    pub simulator_version: String,
    /// Seed, unsigned 64-bit, in decimal.
    pub seed: String,
    /// What became of it.
    pub state: SessionState,
    /// Why it was refused.
    pub refusal: Option<String>,
    /// The file, relative to the recordings folder.
    pub recording_path: String,
    /// SHA-256 of the file.
    pub recording_sha256: String,
    /// Size of the file, in bytes.
    pub recording_size: i64,
    /// Largest deviation of the server's re-simulation, in N.
    pub verify_deviation_n: Option<f64>,
    /// Events that differ in the server's re-simulation.
    pub verify_event_differences: Option<i64>,
    /// The re-simulation differs.
    pub verify_flagged: Option<bool>,
    /// Why it counts nowhere; absent where it counts.
    pub uncounted: Option<Uncounted>,
    /// SHA-256 of what the hand did; absent without samples.
    pub motion_sha256: Option<String>,
    /// The attempt whose motion it repeats.
    pub repeats: Option<SessionId>,
    /// The paired station that has signed it.
    pub signed_by: Option<StationId>,
    /// Since when its recording is gone, with whoever made it.
    pub recording_erased_at: Option<Moment>,
}

impl Session {
    /// What its rows elsewhere are found by.
    #[must_use]
    pub const fn key(&self) -> SessionKey {
        SessionKey { school_id: self.school_id, id: self.id }
    }
}

/// A number that may be infinite or none, which JSON does not have, as its words.
mod any_number {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    pub(super) fn serialize<S: Serializer>(number: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(number)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(D::Error::custom)
    }
}

/// The server's re-simulation of an attempt.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verified {
    /// Largest deviation of any force, in N.
    #[serde(with = "any_number")]
    pub deviation_n: f64,
    /// Events that differ.
    pub event_differences: i64,
    /// The very same forces, depths and events.
    pub exact: bool,
}

impl Verified {
    /// Anything but the very same.
    #[must_use]
    pub fn flagged(self) -> bool {
        !self.exact
    }
}

/// Where a recording lies and what its bytes must hash to.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct RecordingFile {
    /// Session.
    pub id: SessionId,
    /// The file, relative to the recordings folder.
    pub recording_path: String,
    /// SHA-256 of the file.
    pub recording_sha256: String,
    /// Size of the file, in bytes.
    pub recording_size: i64,
}

/// Stores a new attempt.
///
/// # Errors
/// When the id is taken, or the database fails.
pub async fn insert_session(writer: &mut Connection, session: &Session) -> Result<()> {
    sqlx::query(
        "INSERT INTO sessions (id, school_id, trainee_id, exercise_id, exercise_sha256, scene_sha256, revision_id,
         started_at, received_at, duration_s, complete, device, simulator_version, seed, state, recording_path,
         recording_sha256, recording_size, claimed_started_at, uncounted, motion_sha256, repeats, signed_by)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, $16, $17, $18, $19, $20, $21, $22, $23)",
    )
    .bind(session.id)
    .bind(session.school_id)
    .bind(session.trainee_id)
    .bind(&session.exercise_id)
    .bind(&session.exercise_sha256)
    .bind(&session.scene_sha256)
    .bind(session.revision_id)
    .bind(session.started_at)
    .bind(session.received_at)
    .bind(session.duration_s)
    .bind(session.complete)
    .bind(&session.device)
    .bind(&session.simulator_version)
    .bind(&session.seed)
    .bind(session.state)
    .bind(&session.recording_path)
    .bind(&session.recording_sha256)
    .bind(session.recording_size)
    .bind(session.claimed_started_at)
    .bind(session.uncounted)
    .bind(&session.motion_sha256)
    .bind(session.repeats)
    .bind(session.signed_by)
    .execute(writer)
    .await
    .map(drop)
}

/// The attempt of a school that counts and whose hand did just this.
pub async fn find_session_of_motion(
    executor: impl Executor<'_>,
    school: SchoolId,
    motion_sha256: &str,
) -> Result<Option<SessionId>> {
    sqlx::query_scalar("SELECT id FROM sessions WHERE school_id = $1 AND motion_sha256 = $2 AND uncounted IS NULL")
        .bind(school)
        .bind(motion_sha256)
        .fetch_optional(executor)
        .await
}

/// Number and size of a person's recordings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, FromRow)]
pub struct KeptRecordings {
    /// How many have come since a moment.
    pub today: i64,
    /// Bytes of all that were not erased.
    pub bytes: i64,
}

/// Counts a person's recordings that came since a moment, and the bytes of all.
pub async fn sum_kept_recordings(
    executor: impl Executor<'_>,
    whose: PersonKey,
    since: Moment,
) -> Result<KeptRecordings> {
    sqlx::query_as(
        "SELECT CAST(coalesce(sum(CASE WHEN received_at > $3 THEN 1 ELSE 0 END), 0) AS BIGINT) AS today,
                CAST(coalesce(sum(CASE WHEN recording_erased_at IS NULL THEN recording_size ELSE 0 END), 0) AS BIGINT) AS bytes
         FROM sessions WHERE school_id = $1 AND trainee_id = $2",
    )
    .bind(whose.school_id)
    .bind(whose.person_id)
    .bind(since)
    .fetch_one(executor)
    .await
}

/// An attempt of a school, whoever asks.
pub async fn find_session(executor: impl Executor<'_>, school: SchoolId, id: SessionId) -> Result<Option<Session>> {
    sqlx::query_as("SELECT * FROM sessions WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .fetch_optional(executor)
        .await
}

/// An attempt that a person may see: a trainee their own, an instructor also those of the cohorts they teach, an
/// administrator the school's.
pub async fn find_visible_session(
    executor: impl Executor<'_>,
    viewer: &CurrentPerson,
    id: SessionId,
) -> Result<Option<Session>> {
    sqlx::query_as(
        "SELECT * FROM sessions s WHERE s.school_id = $1 AND s.id = $2 AND (s.trainee_id = $3 OR $4 OR EXISTS (
           SELECT 1 FROM taught_trainees taught WHERE taught.teacher_id = $3 AND taught.trainee_id = s.trainee_id))",
    )
    .bind(viewer.school_id)
    .bind(id)
    .bind(viewer.id)
    .bind(viewer.role == Role::Administrator)
    .fetch_optional(executor)
    .await
}

/// The attempts that a person may see, newest first, after one of them; at most `limit`.
pub async fn visible_after(
    executor: impl Executor<'_>,
    viewer: &CurrentPerson,
    after: AttemptPlace,
    limit: u32,
) -> Result<Vec<Session>> {
    let statement = match viewer.role {
        Role::Administrator => {
            "SELECT * FROM sessions WHERE school_id = $1 AND (started_at, id) < ($3, $4)
             ORDER BY started_at DESC, id DESC LIMIT $5"
        }
        // From whoever is seen to the newest of each, and from these to the newest of all.
        Role::Instructor | Role::Trainee | Role::Guest => twin!(
            executor,
            "SELECT s.* FROM (SELECT n.id FROM (SELECT trainee_id AS person_id FROM taught_trainees WHERE teacher_id = $2 UNION SELECT $2) seen
               CROSS JOIN sessions n
               WHERE n.school_id = $1 AND n.id IN (
                 SELECT l.id FROM sessions l WHERE l.school_id = $1 AND l.trainee_id = seen.person_id
                   AND (l.started_at, l.id) < ($3, $4) ORDER BY l.started_at DESC, l.id DESC LIMIT $5)
               ORDER BY n.started_at DESC, n.id DESC LIMIT $5) chosen
             CROSS JOIN sessions s WHERE s.school_id = $1 AND s.id = chosen.id ORDER BY s.started_at DESC, s.id DESC",
            "SELECT s.* FROM (SELECT n.id FROM (SELECT trainee_id AS person_id FROM taught_trainees WHERE teacher_id = $2 UNION SELECT $2) seen
               CROSS JOIN LATERAL (
                 SELECT l.id, l.started_at FROM sessions l WHERE l.school_id = $1 AND l.trainee_id = seen.person_id
                   AND (l.started_at, l.id) < ($3, $4) ORDER BY l.started_at DESC, l.id DESC LIMIT $5) n
               ORDER BY n.started_at DESC, n.id DESC LIMIT $5) chosen
             CROSS JOIN sessions s WHERE s.school_id = $1 AND s.id = chosen.id ORDER BY s.started_at DESC, s.id DESC",
        ),
    };
    sqlx::query_as(statement)
        .bind(viewer.school_id)
        .bind(viewer.id)
        .bind(after.started_at)
        .bind(after.id)
        .bind(i64::from(limit))
        .fetch_all(executor)
        .await
}

/// Ends the wait for a score.
pub async fn mark_scored(writer: &mut Connection, school: SchoolId, id: SessionId, verified: Verified) -> Result<()> {
    sqlx::query(
        "UPDATE sessions SET state = 'scored', refusal = NULL, verify_deviation_n = $3,
         verify_event_differences = $4, verify_flagged = $5 WHERE school_id = $1 AND id = $2",
    )
    .bind(school)
    .bind(id)
    .bind(verified.deviation_n)
    .bind(verified.event_differences)
    .bind(verified.flagged())
    .execute(writer)
    .await
    .map(drop)
}

/// Ends the wait for a score that will never come, with the reason.
pub async fn mark_refused(writer: &mut Connection, school: SchoolId, id: SessionId, why: &str) -> Result<()> {
    sqlx::query("UPDATE sessions SET state = 'refused', refusal = $3 WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(id)
        .bind(why)
        .execute(writer)
        .await
        .map(drop)
}

/// The scored attempts of a school at an exercise that count, oldest first: for a re-grading.
pub async fn list_scored_sessions(
    executor: impl Executor<'_>,
    school: SchoolId,
    exercise: &str,
) -> Result<Vec<Session>> {
    sqlx::query_as(
        "SELECT * FROM sessions WHERE school_id = $1 AND exercise_id = $2 AND state = 'scored' AND uncounted IS NULL
         ORDER BY started_at, id",
    )
    .bind(school)
    .bind(exercise)
    .fetch_all(executor)
    .await
}

/// Asks for every recording of every school that was not erased.
pub(crate) const RECORDINGS: &str = "SELECT id, recording_path, recording_sha256, recording_size FROM sessions
     WHERE recording_erased_at IS NULL ORDER BY school_id, id";

/// Every recording of every school that was not erased: for `verify`.
pub async fn list_recordings(executor: impl Executor<'_>) -> Result<Vec<RecordingFile>> {
    sqlx::query_as(RECORDINGS).fetch_all(executor).await
}
