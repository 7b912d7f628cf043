//! What raters have said.

use assessment::questionnaire::Answer;
use model::ids::{PersonId, RevisionId, RoundId, SessionId};
use model::{CurrentPerson, Moment, Role, SessionKey};
use sqlx::FromRow;

use crate::ratings::Round;
use crate::{Executor, Json, Result};
use model::titles::StoredTitle;

/// A rating as whoever asked for it sees it.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct RatingCell {
    /// The attempt.
    pub session_id: SessionId,
    /// When it began.
    pub started_at: Moment,
    /// Who tried, where the viewer may see the attempt.
    pub trainee: Option<String>,
    /// Their id, under the same condition.
    pub trainee_id: Option<PersonId>,
    /// Their pseudonym, under the same condition.
    pub pseudonym: Option<String>,
    /// Title of the exercise, or its id.
    #[sqlx(try_from = "StoredTitle")]
    pub exercise: String,
    /// The rater.
    pub rater_id: PersonId,
    /// Their name.
    pub rater: String,
    /// In the order of the instrument's items.
    pub answers: Json<Vec<Option<Answer>>>,
    /// When it was finished.
    pub finished_at: Option<Moment>,
    /// The rater may know otherwise whose attempt it is.
    pub may_know: bool,
}

/// Every rating of a round, by attempt and rater.
pub async fn cells(executor: impl Executor<'_>, viewer: &CurrentPerson, round: &Round) -> Result<Vec<RatingCell>> {
    sqlx::query_as(
        "SELECT r.session_id, s.started_at, t.display_name AS trainee, t.id AS trainee_id, t.pseudonym,
           coalesce(x.title, s.exercise_id) AS exercise, r.rater_id, p.display_name AS rater, r.answers, r.finished_at,
           r.may_know
         FROM rating_rounds o
         CROSS JOIN ratings r
         JOIN sessions s ON s.school_id = o.school_id AND s.id = r.session_id
         LEFT JOIN people t ON t.school_id = s.school_id AND t.id = s.trainee_id AND ($3 OR EXISTS (
           SELECT 1 FROM taught_trainees taught WHERE taught.teacher_id = $4 AND taught.trainee_id = s.trainee_id))
         JOIN people p ON p.school_id = o.school_id AND p.id = r.rater_id
         LEFT JOIN exercise_revisions x ON x.id = s.revision_id
         WHERE r.round_id = o.id AND o.school_id = $1 AND o.id = $2
         ORDER BY s.started_at, s.id, p.display_name, p.id",
    )
    .bind(round.school_id)
    .bind(round.id)
    .bind(viewer.role == Role::Administrator)
    .bind(viewer.id)
    .fetch_all(executor)
    .await
}

/// A finished rating of one attempt.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct FinishedRating {
    /// Its round.
    pub round_id: RoundId,
    /// Title of the round.
    pub title: String,
    /// The revision of the instrument.
    pub revision_id: RevisionId,
    /// The ratings were made by a program.
    pub generated: bool,
    /// In the order of the instrument's items.
    pub answers: Json<Vec<Option<Answer>>>,
}

/// The finished ratings of an attempt, by round; without the rounds in which the viewer has yet to rate.
pub async fn finished_of(
    executor: impl Executor<'_>,
    session: SessionKey,
    viewer: PersonId,
) -> Result<Vec<FinishedRating>> {
    sqlx::query_as(
        "SELECT r.round_id, o.title, o.revision_id, o.generated, r.answers
         FROM ratings r JOIN rating_rounds o ON o.id = r.round_id AND o.withdrawn_at IS NULL
         WHERE r.school_id = $1 AND r.session_id = $2 AND r.finished_at IS NOT NULL AND NOT EXISTS (
           SELECT 1 FROM ratings own WHERE own.school_id = $1 AND own.rater_id = $3 AND own.round_id = r.round_id
             AND own.finished_at IS NULL)
         ORDER BY o.made_at, o.id, r.id",
    )
    .bind(session.school_id)
    .bind(session.id)
    .bind(viewer)
    .fetch_all(executor)
    .await
}
