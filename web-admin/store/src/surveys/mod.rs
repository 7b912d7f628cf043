//! Surveys, whom they are for, and what they were answered.

pub mod letters;
mod links;
mod responses;
mod results;

pub use links::{
    Practised, add_cohort, add_exercise, add_tag, after_attempt, answered, asked_by_courses, close, cohort_names,
    exercises, of_course, of_person, remove_tag,
};
use model::Moment;
use model::ids::{PersonId, RevisionId, SchoolId, StudyId, SurveyId};
use model::survey::{Identity, Survey};
pub use responses::{
    NewResponse, Submission, SurveyResponse, add, by_token, draft_of, put_answers, reset, set_token, submit, withdraw,
};
pub use results::{ResponseCounts, ResponseMetric, SubmittedResponse, Tag, attempts, counts, submitted, tags};

use super::{Connection, Executor, Result};

/// The study that asks a survey of its participants.
#[derive(Clone, Copy, Debug)]
pub struct StudyOccasion {
    /// The study.
    pub id: StudyId,
    /// After the last attempt, not after each.
    pub at_end: bool,
}

/// A survey to be added.
#[derive(Clone, Copy, Debug)]
pub struct NewSurvey<'a> {
    /// Its school.
    pub school_id: SchoolId,
    /// The revision that it asks.
    pub revision_id: RevisionId,
    /// Title.
    pub title: &'a str,
    /// Whose it is; none: the administrators'.
    pub owner_id: Option<PersonId>,
    /// Whether answers lead to who gave them.
    pub identity: Identity,
    /// Asked after each attempt.
    pub after_attempts: bool,
    /// For how many hours after it; none: as long as the survey is open.
    pub fresh_hours: Option<u32>,
    /// The study that asks it; none: the school does.
    pub study: Option<StudyOccasion>,
    /// The answers are made by a program.
    pub generated: bool,
    /// From when on it can be answered.
    pub opens_at: Moment,
    /// Until when.
    pub closes_at: Option<Moment>,
}

/// Adds a survey.
///
/// # Errors
/// When there is no such revision, or the database fails.
pub async fn insert(writer: &mut Connection, new: &NewSurvey<'_>, now: Moment) -> Result<SurveyId> {
    sqlx::query_scalar(
        "INSERT INTO surveys (id, school_id, revision_id, title, owner_id, identity, after_attempts, generated,
           opens_at, closes_at, created_at, study_id, at_end, fresh_hours)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14) RETURNING id",
    )
    .bind(SurveyId::made_at(now))
    .bind(new.school_id)
    .bind(new.revision_id)
    .bind(new.title)
    .bind(new.owner_id)
    .bind(new.identity)
    .bind(new.after_attempts)
    .bind(new.generated)
    .bind(new.opens_at)
    .bind(new.closes_at)
    .bind(now)
    .bind(new.study.map(|study| study.id))
    .bind(new.study.is_some_and(|study| study.at_end))
    .bind(new.fresh_hours.map(i64::from))
    .fetch_one(writer)
    .await
}

/// Columns of a survey, whatever limits the list.
macro_rules! survey {
    ($rest:literal) => {
        concat!(
            "SELECT s.id, s.school_id, s.revision_id, r.title AS instrument, s.title, s.owner_id, s.identity,
               s.after_attempts, s.fresh_hours, s.study_id, s.at_end, s.generated, s.opens_at, s.closes_at, s.created_at
             FROM surveys s JOIN instrument_revisions r ON r.school_id = s.school_id AND r.id = s.revision_id ",
            $rest
        )
    };
}
pub(crate) use survey;

/// A survey of a school.
pub async fn find(executor: impl Executor<'_>, school: SchoolId, id: SurveyId) -> Result<Option<Survey>> {
    sqlx::query_as(survey!("WHERE s.school_id = $1 AND s.id = $2")).bind(school).bind(id).fetch_optional(executor).await
}

/// Every survey of a school, newest first, at most 200.
pub async fn all(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<Survey>> {
    sqlx::query_as(survey!("WHERE s.school_id = $1 ORDER BY s.created_at DESC, s.id DESC LIMIT 200"))
        .bind(school)
        .fetch_all(executor)
        .await
}
