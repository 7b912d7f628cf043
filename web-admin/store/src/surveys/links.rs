//! Relations of a survey: cohorts, exercises, courses, tags of comments, and the people who are
//! asked.

use model::Moment;
use model::ids::{CohortId, PersonId, ResponseId, RevisionId, SchoolId, SessionId, SurveyId};
use model::surveys::Survey;
use model::titles::StoredTitle;

use super::survey;
use crate::recordings::sessions::Session;
use crate::{Connection, Executor, Result};

/// Sends a survey to a cohort.
///
/// # Errors
/// If one of them belongs to another school, or the database fails.
pub async fn add_cohort(writer: &mut Connection, school: SchoolId, survey: SurveyId, cohort: CohortId) -> Result<()> {
    sqlx::query("INSERT INTO survey_cohorts (school_id, survey_id, cohort_id) VALUES ($1, $2, $3)")
        .bind(school)
        .bind(survey)
        .bind(cohort)
        .execute(writer)
        .await
        .map(drop)
}

/// Returns the names of the cohorts that a survey was sent to, sorted.
pub async fn cohort_names(executor: impl Executor<'_>, school: SchoolId, survey: SurveyId) -> Result<Vec<String>> {
    sqlx::query_scalar(
        "SELECT c.name FROM survey_cohorts sc CROSS JOIN cohorts c
         WHERE c.school_id = sc.school_id AND c.id = sc.cohort_id AND sc.school_id = $1 AND sc.survey_id = $2 ORDER BY c.name",
    )
    .bind(school)
    .bind(survey)
    .fetch_all(executor)
    .await
}

/// Makes a survey appear after attempts at an exercise.
pub async fn add_exercise(writer: &mut Connection, school: SchoolId, survey: SurveyId, exercise: &str) -> Result<()> {
    sqlx::query(
        "INSERT INTO survey_exercises (school_id, survey_id, exercise_id) VALUES ($1, $2, $3)
         ON CONFLICT (survey_id, exercise_id) DO NOTHING",
    )
    .bind(school)
    .bind(survey)
    .bind(exercise)
    .execute(writer)
    .await
    .map(drop)
}

/// Returns the instruments that a school's courses use after exercises: current revision of the
/// instrument, its title, and the id of the exercise. Unpublished instruments are left out.
pub async fn asked_by_courses(
    executor: impl Executor<'_>,
    school: SchoolId,
) -> Result<Vec<(RevisionId, String, String)>> {
    let asked: Vec<(RevisionId, StoredTitle, String)> = sqlx::query_as(
        "SELECT r.id, r.title, e.exercise_id FROM curricula c
         JOIN curriculum_entries e ON e.revision_id = c.revision_id
         JOIN instruments i ON i.school_id = c.school_id AND i.instrument_id = e.survey
         JOIN instrument_revisions r ON r.school_id = i.school_id AND r.id = i.revision_id
         WHERE c.school_id = $1 ORDER BY r.id, e.exercise_id",
    )
    .bind(school)
    .fetch_all(executor)
    .await?;
    Ok(asked.into_iter().map(|(revision, title, exercise)| (revision, title.into(), exercise)).collect())
}

/// Returns the open surveys that were created for courses, which have no owner.
pub async fn of_course(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<Survey>> {
    sqlx::query_as(survey!(
        "WHERE s.school_id = $1 AND s.after_attempts = 1 AND s.owner_id IS NULL AND s.closes_at IS NULL"
    ))
    .bind(school)
    .fetch_all(executor)
    .await
}

/// Sets the closing time of a survey; `None` opens it without limit.
pub async fn close(writer: &mut Connection, school: SchoolId, survey: SurveyId, at: Option<Moment>) -> Result<()> {
    sqlx::query("UPDATE surveys SET closes_at = $3 WHERE school_id = $1 AND id = $2")
        .bind(school)
        .bind(survey)
        .bind(at)
        .execute(writer)
        .await
        .map(drop)
}

/// Returns the open one-time surveys of a person, through the cohorts to which they belong as a
/// trainee.
pub async fn of_person(
    executor: impl Executor<'_>,
    school: SchoolId,
    person: PersonId,
    now: Moment,
) -> Result<Vec<Survey>> {
    sqlx::query_as(survey!(
        "WHERE s.school_id = $1 AND s.after_attempts = 0 AND s.opens_at <= $3
           AND (s.closes_at IS NULL OR s.closes_at > $3) AND s.id IN (
             SELECT sc.survey_id FROM cohort_members m JOIN survey_cohorts sc ON sc.cohort_id = m.cohort_id
             WHERE m.person_id = $2 AND m.role = 'trainee')
         ORDER BY s.opens_at"
    ))
    .bind(school)
    .bind(person)
    .bind(now)
    .fetch_all(executor)
    .await
}

/// A finished attempt of a trainee, or future practice.
#[derive(Clone, Copy, Debug)]
pub struct Practised<'a> {
    /// School.
    pub school: SchoolId,
    /// Trainee.
    pub trainee: PersonId,
    /// Exercise; `None` means any.
    pub exercise: Option<&'a str>,
    /// End of the attempt; `None` if it has not been made yet.
    pub ended_at: Option<Moment>,
}

impl<'a> Practised<'a> {
    /// Makes the value for a finished attempt.
    #[must_use]
    pub fn by(session: &'a Session) -> Self {
        Self {
            school: session.school_id,
            trainee: session.trainee_id,
            exercise: Some(&session.exercise_id),
            ended_at: Some(session.started_at.plus_s(session.duration_s.ceil() as i64)),
        }
    }
}

/// Returns the open surveys that appear after an attempt. They concern the trainees of their
/// cohorts, all trainees if they have no cohorts, or the participants of their study.
pub async fn after_attempt(executor: impl Executor<'_>, practised: Practised<'_>, now: Moment) -> Result<Vec<Survey>> {
    sqlx::query_as(survey!(
        "WHERE s.school_id = $1 AND s.after_attempts = 1 AND s.opens_at <= $4
           AND (s.closes_at IS NULL OR s.closes_at > $4)
           AND ($5 IS NULL OR s.fresh_hours IS NULL OR $4 <= $5 + s.fresh_hours * 3600000000)
           AND ($3 IS NULL OR NOT EXISTS (SELECT 1 FROM survey_exercises e WHERE e.survey_id = s.id)
             OR EXISTS (SELECT 1 FROM survey_exercises e WHERE e.survey_id = s.id AND e.exercise_id = $3))
           AND CASE WHEN s.study_id IS NOT NULL THEN EXISTS (SELECT 1 FROM study_participants t
               WHERE t.study_id = s.study_id AND t.person_id = $2 AND t.agreed_at IS NOT NULL AND t.withdrawn_at IS NULL)
             WHEN EXISTS (SELECT 1 FROM survey_cohorts sc WHERE sc.survey_id = s.id) THEN
               EXISTS (SELECT 1 FROM survey_cohorts sc JOIN cohort_members m ON m.cohort_id = sc.cohort_id
               WHERE sc.survey_id = s.id AND m.person_id = $2 AND m.role = 'trainee')
             ELSE (SELECT role FROM people WHERE people.id = $2) = 'trainee' END
         ORDER BY s.at_end, s.created_at"
    ))
    .bind(practised.school)
    .bind(practised.trainee)
    .bind(practised.exercise)
    .bind(now)
    .bind(practised.ended_at)
    .fetch_all(executor)
    .await
}

/// Returns the exercises after which the surveys of a school appear, as pairs of survey and
/// exercise. A survey without exercises appears after all.
pub async fn exercises(executor: impl Executor<'_>, school: SchoolId) -> Result<Vec<(SurveyId, String)>> {
    sqlx::query_as(
        "SELECT e.survey_id, e.exercise_id FROM surveys s JOIN survey_exercises e ON e.survey_id = s.id
         WHERE s.school_id = $1 AND s.after_attempts = 1 ORDER BY e.survey_id, e.exercise_id",
    )
    .bind(school)
    .fetch_all(executor)
    .await
}

/// Returns whether a person has answered a survey, for one attempt or at all.
pub async fn answered(
    executor: impl Executor<'_>,
    survey: &Survey,
    person: PersonId,
    session: Option<SessionId>,
) -> Result<bool> {
    // The unary plus keeps SQLite from using an index by school.
    sqlx::query_scalar(
        "SELECT EXISTS (SELECT 1 FROM survey_participations WHERE +school_id = $1 AND survey_id = $2
           AND person_id = $3 AND session_id IS NOT DISTINCT FROM $4)",
    )
    .bind(survey.school_id)
    .bind(survey.id)
    .bind(person)
    .bind(session)
    .fetch_one(executor)
    .await
}

/// Adds a tag to a comment. Returns false if the survey has no such comment.
pub async fn add_tag(
    writer: &mut Connection,
    survey: &Survey,
    response: ResponseId,
    item: &str,
    tag: &str,
) -> Result<bool> {
    sqlx::query(
        "INSERT INTO survey_tags (school_id, survey_id, response_id, item_id, tag)
         SELECT school_id, survey_id, id, $4, $5 FROM survey_responses
         WHERE school_id = $1 AND survey_id = $2 AND id = $3 AND state = 'submitted'
         ON CONFLICT (response_id, item_id, tag) DO UPDATE SET tag = excluded.tag",
    )
    .bind(survey.school_id)
    .bind(survey.id)
    .bind(response)
    .bind(item)
    .bind(tag)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Removes a tag from a comment. Returns false if it was not there.
pub async fn remove_tag(
    writer: &mut Connection,
    survey: &Survey,
    response: ResponseId,
    item: &str,
    tag: &str,
) -> Result<bool> {
    sqlx::query(
        "DELETE FROM survey_tags WHERE school_id = $1 AND survey_id = $2 AND response_id = $3 AND item_id = $4
           AND tag = $5",
    )
    .bind(survey.school_id)
    .bind(survey.id)
    .bind(response)
    .bind(item)
    .bind(tag)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}
