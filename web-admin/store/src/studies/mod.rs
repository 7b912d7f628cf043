//! Validation studies: what they ask of whom, who takes part, and what they have done.

mod keeping;
mod participants;

pub use keeping::{announce_study_erasure, call_off_study_erasure, list_kept_studies, mark_study_erased};
use model::ids::{PersonId, RevisionId, SchoolId, StudyId};
use model::survey::Survey;
use model::{CurrentPerson, Moment, PersonKey, Role};
pub use participants::{
    NewParticipant, StudyAttempt, StudyParticipant, add_participant, count_open_attempts, count_participants,
    find_participant, list_participants, list_studied_exercises, list_study_attempts, note_consent,
    withdraw_participant,
};
use sqlx::FromRow;

use super::surveys::survey;
use super::{Connection, Executor, Json, Result};
use model::titles::StoredTitle;

/// A study.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct Study {
    /// Id.
    pub id: StudyId,
    /// Its school.
    pub school_id: SchoolId,
    /// Title.
    pub title: String,
    /// Whoever runs it.
    pub owner_id: PersonId,
    /// Their name.
    pub owner: String,
    /// Attempts asked of each participant at each exercise.
    #[sqlx(try_from = "i64")]
    pub attempts: u32,
    /// Names of the groups, from the least experienced to the experts.
    pub groups: Json<Vec<String>>,
    /// What is asked of each participant.
    pub questions: Json<Vec<String>>,
    /// What they agree to.
    pub consent: String,
    /// Who answers for the data.
    pub controller: String,
    /// Whom to ask.
    pub contact: String,
    /// How long its data are kept after its end, in months.
    #[sqlx(try_from = "i64")]
    pub kept_months: u32,
    /// The participants are a program's.
    pub generated: bool,
    /// When it was made.
    pub created_at: Moment,
    /// When it ended.
    pub closed_at: Option<Moment>,
    /// When the end of its data was announced.
    pub told_at: Option<Moment>,
    /// How long the service had run then, in s.
    pub told_observed_s: Option<i64>,
    /// When its data were erased.
    pub erased_at: Option<Moment>,
}

/// A study to be added.
#[derive(Clone, Copy, Debug)]
pub struct NewStudy<'a> {
    /// Its school.
    pub school_id: SchoolId,
    /// Title.
    pub title: &'a str,
    /// Whoever runs it.
    pub owner_id: PersonId,
    /// Attempts asked of each participant at each exercise.
    pub attempts: u32,
    /// Names of the groups, from the least experienced to the experts.
    pub groups: &'a [String],
    /// What is asked of each participant.
    pub questions: &'a [String],
    /// What they agree to.
    pub consent: &'a str,
    /// Who answers for the data.
    pub controller: &'a str,
    /// Whom to ask.
    pub contact: &'a str,
    /// How long its data are kept after its end, in months.
    pub kept_months: u32,
    /// The participants are a program's.
    pub generated: bool,
}

/// An exercise of a study, in the revision that is studied.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct StudyExercise {
    /// The revision.
    pub revision_id: RevisionId,
    /// The exercise's id.
    pub exercise_id: String,
    /// Its title.
    #[sqlx(try_from = "StoredTitle")]
    pub title: String,
}

macro_rules! study {
    ($rest:literal) => {
        concat!(
            "SELECT u.id, u.school_id, u.title, u.owner_id, p.display_name AS owner, u.attempts, u.groups, u.questions,
               u.consent, u.controller, u.contact, u.kept_months, u.generated, u.created_at, u.closed_at,
               u.told_at, u.told_observed_s, u.erased_at
             FROM studies u JOIN people p ON p.school_id = u.school_id AND p.id = u.owner_id ",
            $rest
        )
    };
}

use study;

/// Adds a study.
///
/// # Errors
/// When the owner is of another school, or the database fails.
pub async fn insert_study(writer: &mut Connection, new: &NewStudy<'_>, now: Moment) -> Result<StudyId> {
    sqlx::query_scalar(
        "INSERT INTO studies (id, school_id, title, owner_id, attempts, groups, questions, consent, controller, contact,
           kept_months, generated, created_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13) RETURNING id",
    )
    .bind(StudyId::made_at(now))
    .bind(new.school_id)
    .bind(new.title)
    .bind(new.owner_id)
    .bind(i64::from(new.attempts))
    .bind(Json(new.groups))
    .bind(Json(new.questions))
    .bind(new.consent)
    .bind(new.controller)
    .bind(new.contact)
    .bind(i64::from(new.kept_months))
    .bind(new.generated)
    .bind(now)
    .fetch_one(writer)
    .await
}

/// Adds an exercise to a study, in the revision that its school gives now. False where the school teaches no such exercise.
pub async fn add_study_exercise(
    writer: &mut Connection,
    school: SchoolId,
    study: StudyId,
    exercise: &str,
) -> Result<bool> {
    sqlx::query(
        "INSERT INTO study_exercises (school_id, study_id, position, revision_id)
         SELECT e.school_id, $2, (SELECT count(*) FROM study_exercises WHERE study_id = $2), e.revision_id
         FROM exercises e WHERE e.school_id = $1 AND e.exercise_id = $3",
    )
    .bind(school)
    .bind(study)
    .bind(exercise)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// The studies that somebody may see, newest first: an administrator those of the school, anybody else their own.
pub async fn list_studies(executor: impl Executor<'_>, viewer: &CurrentPerson) -> Result<Vec<Study>> {
    sqlx::query_as(study!(
        "WHERE u.school_id = $1 AND ($3 OR u.owner_id = $2) ORDER BY u.created_at DESC, u.id LIMIT 200"
    ))
    .bind(viewer.school_id)
    .bind(viewer.id)
    .bind(viewer.role == Role::Administrator)
    .fetch_all(executor)
    .await
}

/// One of [`list_studies`].
pub async fn find_visible_study(
    executor: impl Executor<'_>,
    viewer: &CurrentPerson,
    id: StudyId,
) -> Result<Option<Study>> {
    sqlx::query_as(study!("WHERE u.school_id = $1 AND u.id = $4 AND ($3 OR u.owner_id = $2)"))
        .bind(viewer.school_id)
        .bind(viewer.id)
        .bind(viewer.role == Role::Administrator)
        .bind(id)
        .fetch_optional(executor)
        .await
}

/// The open study that a guest takes part in.
pub async fn find_study_of_guest(
    executor: impl Executor<'_>,
    PersonKey { school_id: school, person_id: person }: PersonKey,
) -> Result<Option<Study>> {
    sqlx::query_as(study!(
        "JOIN study_participants t ON t.school_id = u.school_id AND t.study_id = u.id
         WHERE t.school_id = $1 AND t.person_id = $2 AND t.withdrawn_at IS NULL AND u.closed_at IS NULL
         ORDER BY t.added_at DESC, u.id LIMIT 1"
    ))
    .bind(school)
    .bind(person)
    .fetch_optional(executor)
    .await
}

/// The open studies that a person is asked to take part in, the latest first.
pub async fn list_study_requests(
    executor: impl Executor<'_>,
    PersonKey { school_id: school, person_id: person }: PersonKey,
) -> Result<Vec<Study>> {
    sqlx::query_as(study!(
        "JOIN study_participants t ON t.school_id = u.school_id AND t.study_id = u.id
         WHERE t.school_id = $1 AND t.person_id = $2 AND t.withdrawn_at IS NULL AND t.agreed_at IS NULL
           AND u.closed_at IS NULL
         ORDER BY t.added_at DESC, u.id"
    ))
    .bind(school)
    .bind(person)
    .fetch_all(executor)
    .await
}

/// The studies that a person has agreed to and whose data are kept, the latest first.
pub async fn list_joined_studies(
    executor: impl Executor<'_>,
    PersonKey { school_id: school, person_id: person }: PersonKey,
) -> Result<Vec<Study>> {
    sqlx::query_as(study!(
        "JOIN study_participants t ON t.school_id = u.school_id AND t.study_id = u.id
         WHERE t.school_id = $1 AND t.person_id = $2 AND t.withdrawn_at IS NULL AND t.agreed_at IS NOT NULL
           AND u.erased_at IS NULL
         ORDER BY t.added_at DESC, u.id"
    ))
    .bind(school)
    .bind(person)
    .fetch_all(executor)
    .await
}

/// The exercises of a study, in order.
pub async fn list_study_exercises(executor: impl Executor<'_>, study: &Study) -> Result<Vec<StudyExercise>> {
    sqlx::query_as(
        "SELECT e.revision_id, r.exercise_id, r.title FROM study_exercises e
         JOIN exercise_revisions r ON r.school_id = e.school_id AND r.id = e.revision_id
         WHERE e.school_id = $1 AND e.study_id = $2 ORDER BY e.position",
    )
    .bind(study.school_id)
    .bind(study.id)
    .fetch_all(executor)
    .await
}

/// What a study asks: after each attempt first, then at the end.
pub async fn list_study_surveys(executor: impl Executor<'_>, study: &Study) -> Result<Vec<Survey>> {
    sqlx::query_as(survey!("WHERE s.school_id = $1 AND s.study_id = $2 ORDER BY s.at_end, s.created_at, s.id"))
        .bind(study.school_id)
        .bind(study.id)
        .fetch_all(executor)
        .await
}

/// What may be changed of a study at any time.
#[derive(Clone, Copy, Debug)]
pub struct StudyLines<'a> {
    /// Title.
    pub title: &'a str,
    /// Whom to ask.
    pub contact: &'a str,
    /// How long its data are kept after its end, in months.
    pub kept_months: u32,
}

/// Changes what may be changed of a study at any time.
pub async fn change_study_lines(writer: &mut Connection, study: &Study, lines: StudyLines<'_>) -> Result<()> {
    sqlx::query("UPDATE studies SET title = $3, contact = $4, kept_months = $5 WHERE school_id = $1 AND id = $2")
        .bind(study.school_id)
        .bind(study.id)
        .bind(lines.title)
        .bind(lines.contact)
        .bind(i64::from(lines.kept_months))
        .execute(writer)
        .await
        .map(drop)
}

/// What may be changed of a study while nobody takes part.
#[derive(Clone, Copy, Debug)]
pub struct StudyPlan<'a> {
    /// Attempts asked of each participant at each exercise.
    pub attempts: u32,
    /// Names of the groups, from the least experienced to the experts.
    pub groups: &'a [String],
    /// What is asked of each participant.
    pub questions: &'a [String],
    /// What they agree to.
    pub consent: &'a str,
    /// Who answers for the data.
    pub controller: &'a str,
}

/// Changes what may be changed of a study while nobody takes part.
pub async fn change_study_plan(writer: &mut Connection, study: &Study, plan: StudyPlan<'_>) -> Result<()> {
    sqlx::query(
        "UPDATE studies SET attempts = $3, groups = $4, questions = $5, consent = $6, controller = $7
         WHERE school_id = $1 AND id = $2",
    )
    .bind(study.school_id)
    .bind(study.id)
    .bind(i64::from(plan.attempts))
    .bind(Json(plan.groups))
    .bind(Json(plan.questions))
    .bind(plan.consent)
    .bind(plan.controller)
    .execute(writer)
    .await
    .map(drop)
}

/// Ends a study, or opens it again, and with it what it asks.
pub async fn close_study(writer: &mut Connection, school: SchoolId, study: StudyId, at: Option<Moment>) -> Result<()> {
    sqlx::query("UPDATE surveys SET closes_at = $3 WHERE school_id = $1 AND study_id = $2")
        .bind(school)
        .bind(study)
        .bind(at)
        .execute(&mut *writer)
        .await?;
    sqlx::query("UPDATE studies SET closed_at = $3 WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(study)
        .bind(at)
        .execute(writer)
        .await
        .map(drop)
}
