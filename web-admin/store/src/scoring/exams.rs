//! Exams at one station: candidates, their sittings and attempts, and the second ratings.

use assessment::questionnaire::Answer;
use model::ids::{CohortId, ExamId, PersonId, RevisionId, RoundId, SchoolId, SessionId, SittingId};
use model::scoring::exam::SittingTimes;
use model::titles::StoredTitle;
use model::{CurrentPerson, Moment, PersonKey, Role};
use sqlx::FromRow;

use crate::{Connection, Executor, Json, Result};

/// An exam to be created.
#[derive(Clone, Debug)]
pub struct NewExam {
    /// Title.
    pub title: String,
    /// Cohort of the candidates.
    pub cohort_id: CohortId,
    /// Exercise.
    pub exercise_id: String,
    /// Revision of the instrument.
    pub revision_id: RevisionId,
    /// Time limit, in min.
    pub limit_min: u32,
    /// Second rater.
    pub second_rater_id: Option<PersonId>,
}

/// An exam.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Exam {
    /// Id.
    pub id: ExamId,
    /// School.
    pub school_id: SchoolId,
    /// Title.
    pub title: String,
    /// Cohort of the candidates.
    pub cohort_id: CohortId,
    /// Its name.
    pub cohort: String,
    /// Exercise.
    pub exercise_id: String,
    /// Title of the exercise, or its id.
    #[sqlx(try_from = "StoredTitle")]
    pub exercise: String,
    /// Revision of the instrument.
    pub revision_id: RevisionId,
    /// Title of the instrument.
    #[sqlx(try_from = "StoredTitle")]
    pub instrument: String,
    /// Time limit, in min.
    #[sqlx(try_from = "i64")]
    pub limit_min: u32,
    /// Second rater.
    pub second_rater_id: Option<PersonId>,
    /// Name of the second rater.
    pub second_rater: Option<String>,
    /// Round of the second ratings, unless it was withdrawn.
    pub round_id: Option<RoundId>,
    /// Time of creation.
    pub made_at: Moment,
    /// Time at which it was closed.
    pub closed_at: Option<Moment>,
    /// Number of candidates who have begun.
    #[sqlx(try_from = "i64")]
    pub begun: u32,
    /// Number of finished sittings.
    #[sqlx(try_from = "i64")]
    pub finished: u32,
}

/// A candidate's sitting, with the attempt and the second rating that belong to it.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct Sitting {
    /// Id.
    pub id: SittingId,
    /// Exam.
    pub exam_id: ExamId,
    /// Title of the exam.
    pub exam: String,
    /// Revision of the instrument.
    pub revision_id: RevisionId,
    /// Time limit, in min.
    #[sqlx(try_from = "i64")]
    pub limit_min: u32,
    /// Candidate.
    pub person_id: PersonId,
    /// Name of the candidate.
    pub name: String,
    /// Examiner.
    pub examiner_id: PersonId,
    /// Name of the examiner.
    pub examiner: String,
    /// Begin.
    pub begun_at: Moment,
    /// When the examiner finished the form.
    pub finished_at: Option<Moment>,
    /// The examiner's answers, in the order of the instrument's items.
    pub answers: Json<Vec<Option<Answer>>>,
    /// The candidate's attempt.
    pub session_id: Option<SessionId>,
    /// Whether the attempt is scored.
    pub is_scored: bool,
    /// Whether a station signed the attempt, so that its start is certain.
    pub is_signed: bool,
    /// Whether a second rating was requested.
    pub is_sent: bool,
    /// Answers of the second rater; empty until they are finished.
    pub second_answers: Json<Vec<Option<Answer>>>,
    /// When the second rating was finished.
    pub second_finished_at: Option<Moment>,
    /// Second rater of the exam.
    pub second_rater_id: Option<PersonId>,
}

impl Sitting {
    /// Returns its times.
    #[must_use]
    pub const fn times(&self) -> SittingTimes {
        SittingTimes { begun_at: self.begun_at, finished_at: self.finished_at, limit_min: self.limit_min }
    }

    /// Whether it is finished and its attempt waits for a request for a second rating.
    #[must_use]
    pub const fn waits_for_request(&self) -> bool {
        self.finished_at.is_some() && self.is_scored && !self.is_sent
    }
}

/// Creates an exam.
///
/// # Errors
/// If the cohort, the exercise, the revision or the second rater does not belong to the school, or
/// the database fails.
pub async fn add_exam(writer: &mut Connection, by: &CurrentPerson, new: &NewExam, now: Moment) -> Result<ExamId> {
    sqlx::query_scalar(
        "INSERT INTO exams (id, school_id, title, cohort_id, exercise_id, revision_id, limit_min, second_rater_id, made_by,
           made_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10) RETURNING id",
    )
    .bind(ExamId::made_at(now))
    .bind(by.school_id)
    .bind(&new.title)
    .bind(new.cohort_id)
    .bind(&new.exercise_id)
    .bind(new.revision_id)
    .bind(i64::from(new.limit_min))
    .bind(new.second_rater_id)
    .bind(by.id)
    .bind(now)
    .fetch_one(writer)
    .await
}

/// Selects exams of school `$1` whose cohort person `$2` teaches, or all if `$3`.
macro_rules! exams {
    ($rest:literal) => {
        concat!(
            "SELECT e.id, e.school_id, e.title, e.cohort_id, c.name AS cohort, e.exercise_id,
               coalesce(x.title, e.exercise_id) AS exercise, e.revision_id, i.title AS instrument, e.limit_min,
               e.second_rater_id, p.display_name AS second_rater, o.id AS round_id, e.made_at, e.closed_at,
               (SELECT count(*) FROM exam_sittings t WHERE t.school_id = e.school_id AND t.exam_id = e.id) AS begun,
               (SELECT count(t.finished_at) FROM exam_sittings t
                  WHERE t.school_id = e.school_id AND t.exam_id = e.id) AS finished
             FROM exams e
             JOIN cohorts c ON c.school_id = e.school_id AND c.id = e.cohort_id
             JOIN instrument_revisions i ON i.id = e.revision_id
             LEFT JOIN people p ON p.school_id = e.school_id AND p.id = e.second_rater_id
             LEFT JOIN rating_rounds o ON o.id = e.round_id AND o.withdrawn_at IS NULL
             LEFT JOIN exercises k ON k.school_id = e.school_id AND k.exercise_id = e.exercise_id
             LEFT JOIN exercise_revisions x ON x.id = k.revision_id
             WHERE e.school_id = $1 AND ($3 OR EXISTS (SELECT 1 FROM cohort_members m
               WHERE m.cohort_id = e.cohort_id AND m.person_id = $2 AND m.role = 'instructor')) ",
            $rest,
            ""
        )
    };
}

/// Returns the exams of the cohorts that a person teaches, for an administrator of all; latest
/// first, at most 100.
pub async fn list_exams(executor: impl Executor<'_>, viewer: &CurrentPerson) -> Result<Vec<Exam>> {
    sqlx::query_as(exams!("ORDER BY e.made_at DESC, e.id DESC LIMIT 100"))
        .bind(viewer.school_id)
        .bind(viewer.id)
        .bind(viewer.role == Role::Administrator)
        .fetch_all(executor)
        .await
}

/// Returns an exam, as for [`list_exams`].
pub async fn find_exam(executor: impl Executor<'_>, viewer: &CurrentPerson, id: ExamId) -> Result<Option<Exam>> {
    sqlx::query_as(exams!("AND e.id = $4"))
        .bind(viewer.school_id)
        .bind(viewer.id)
        .bind(viewer.role == Role::Administrator)
        .bind(id)
        .fetch_optional(executor)
        .await
}

/// Selects sittings of school `$1`. The attempt of a sitting is the candidate's first one at the
/// exercise that counts and began from the begin of the sitting to its finish, at the latest at the
/// end of the time limit. Once a second rating of it is requested, a later arrival does not replace it.
macro_rules! sittings {
    ($rest:literal) => {
        concat!(
            "SELECT t.id, t.exam_id, e.title AS exam, e.revision_id, e.limit_min, t.person_id, p.display_name AS name,
               t.examiner_id, x.display_name AS examiner, t.begun_at, t.finished_at, t.answers, s.id AS session_id,
               coalesce(s.state = 'scored', FALSE) AS is_scored, s.signed_by IS NOT NULL AS is_signed,
               r.id IS NOT NULL AS is_sent,
               CASE WHEN r.finished_at IS NULL THEN '[]' ELSE r.answers END AS second_answers,
               r.finished_at AS second_finished_at, e.second_rater_id
             FROM exam_sittings t
             JOIN exams e ON e.school_id = t.school_id AND e.id = t.exam_id
             JOIN people p ON p.school_id = t.school_id AND p.id = t.person_id
             JOIN people x ON x.school_id = t.school_id AND x.id = t.examiner_id
             LEFT JOIN rating_rounds o ON o.id = e.round_id AND o.withdrawn_at IS NULL
             LEFT JOIN ratings r ON r.round_id = o.id AND EXISTS (SELECT 1 FROM sessions own
               WHERE own.school_id = r.school_id AND own.id = r.session_id AND own.trainee_id = t.person_id)
             LEFT JOIN sessions s ON s.school_id = t.school_id AND s.id = coalesce(r.session_id, (
               SELECT n.id FROM sessions n
               WHERE n.school_id = t.school_id AND n.trainee_id = t.person_id AND n.exercise_id = e.exercise_id
                 AND n.started_at BETWEEN t.begun_at AND t.begun_at + e.limit_min * 60000000
                 AND (t.finished_at IS NULL OR n.started_at <= t.finished_at)
                 AND n.state <> 'refused' AND n.uncounted IS NULL ORDER BY n.started_at, n.id LIMIT 1))
             WHERE t.school_id = $1 ",
            $rest,
            ""
        )
    };
}

/// Returns the sittings of an exam, in order of begin.
pub async fn list_sittings(executor: impl Executor<'_>, school: SchoolId, exam: ExamId) -> Result<Vec<Sitting>> {
    sqlx::query_as(sittings!("AND t.exam_id = $2 ORDER BY t.begun_at, t.id"))
        .bind(school)
        .bind(exam)
        .fetch_all(executor)
        .await
}

/// Returns the sitting of a candidate.
pub async fn find_sitting(executor: impl Executor<'_>, exam: ExamId, candidate: PersonKey) -> Result<Option<Sitting>> {
    sqlx::query_as(sittings!("AND t.exam_id = $2 AND t.person_id = $3"))
        .bind(candidate.school_id)
        .bind(exam)
        .bind(candidate.person_id)
        .fetch_optional(executor)
        .await
}

/// Returns a person's finished sittings of closed exams, latest first.
pub async fn list_results(executor: impl Executor<'_>, candidate: PersonKey) -> Result<Vec<Sitting>> {
    sqlx::query_as(sittings!(
        "AND t.person_id = $2 AND t.finished_at IS NOT NULL AND e.closed_at IS NOT NULL
         ORDER BY t.begun_at DESC, t.id"
    ))
    .bind(candidate.school_id)
    .bind(candidate.person_id)
    .fetch_all(executor)
    .await
}

/// Returns a candidate's finished sittings to which an attempt belongs, in order of begin.
pub async fn list_sittings_of_attempt(
    executor: impl Executor<'_>,
    candidate: PersonKey,
    session: SessionId,
) -> Result<Vec<Sitting>> {
    sqlx::query_as(sittings!(
        "AND t.person_id = $2 AND s.id = $3 AND t.finished_at IS NOT NULL ORDER BY t.begun_at, t.id"
    ))
    .bind(candidate.school_id)
    .bind(candidate.person_id)
    .bind(session)
    .fetch_all(executor)
    .await
}

/// Begins a candidate's sitting. Returns `None` if it has already begun.
pub async fn add_sitting(
    writer: &mut Connection,
    exam: &Exam,
    candidate: PersonId,
    examiner: PersonId,
    now: Moment,
) -> Result<Option<SittingId>> {
    sqlx::query_scalar(
        "INSERT INTO exam_sittings (id, school_id, exam_id, person_id, examiner_id, begun_at, answers)
         VALUES ($1, $2, $3, $4, $5, $6, '[]') ON CONFLICT (school_id, exam_id, person_id) DO NOTHING RETURNING id",
    )
    .bind(SittingId::made_at(now))
    .bind(exam.school_id)
    .bind(exam.id)
    .bind(candidate)
    .bind(examiner)
    .bind(now)
    .fetch_optional(writer)
    .await
}

/// Stores the examiner's answers, and finishes the sitting if a time is given. Returns false if it
/// is finished already, or the exam is closed.
pub async fn put_answers(
    writer: &mut Connection,
    school: SchoolId,
    sitting: &Sitting,
    finished_at: Option<Moment>,
) -> Result<bool> {
    sqlx::query(
        "UPDATE exam_sittings SET answers = $3, finished_at = $4 WHERE school_id = $1 AND id = $2 AND finished_at IS NULL
           AND EXISTS (SELECT 1 FROM exams e WHERE e.school_id = $1 AND e.id = exam_sittings.exam_id
             AND e.closed_at IS NULL)",
    )
    .bind(school)
    .bind(sitting.id)
    .bind(&sitting.answers)
    .bind(finished_at)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Sets the round of the second ratings.
pub async fn set_round(writer: &mut Connection, exam: &Exam, round: RoundId) -> Result<()> {
    sqlx::query("UPDATE exams SET round_id = $3 WHERE school_id = $1 AND id = $2")
        .bind(exam.school_id)
        .bind(exam.id)
        .bind(round)
        .execute(writer)
        .await
        .map(drop)
}

/// Closes an exam. Returns false if it is closed already.
pub async fn close_exam(writer: &mut Connection, exam: &Exam, now: Moment) -> Result<bool> {
    sqlx::query("UPDATE exams SET closed_at = $3 WHERE school_id = $1 AND id = $2 AND closed_at IS NULL")
        .bind(exam.school_id)
        .bind(exam.id)
        .bind(now)
        .execute(writer)
        .await
        .map(|done| done.rows_affected() == 1)
}
