//! Rounds of ratings: who is asked to rate which attempts, and what they have said.

mod candidates;
mod results;

use assessment::questionnaire::Answer;
pub use candidates::{RateableAttempt, Rater, of_assignment, raters};
use model::ids::{PersonId, RatingId, RevisionId, RoundId, SchoolId, SessionId};
use model::titles::StoredTitle;
use model::{CurrentPerson, Moment, Role, count_u32};
pub use results::{FinishedRating, RatingCell, cells, finished_of};
use sqlx::FromRow;

use super::{Connection, Executor, Json, Result};

/// A round of ratings.
#[derive(Clone, Debug, PartialEq, Eq, FromRow)]
pub struct Round {
    /// Id.
    pub id: RoundId,
    /// Its school.
    pub school_id: SchoolId,
    /// The revision of the instrument that it asks.
    pub revision_id: RevisionId,
    /// The instrument's title, in the reader's language.
    #[sqlx(try_from = "StoredTitle")]
    pub instrument: String,
    /// Title.
    pub title: String,
    /// The ratings were made by a program.
    pub generated: bool,
    /// Who asked for it.
    pub made_by: PersonId,
    /// Their name.
    pub by: String,
    /// When.
    pub made_at: Moment,
    /// Ratings of all raters.
    #[sqlx(try_from = "i64")]
    pub ratings: u32,
    /// How many of them are finished.
    #[sqlx(try_from = "i64")]
    pub finished: u32,
    /// The viewer's own ratings.
    #[sqlx(try_from = "i64")]
    pub own: u32,
    /// How many of them are not finished.
    #[sqlx(try_from = "i64")]
    pub own_open: u32,
}

/// A round to be made.
#[derive(Clone, Debug)]
pub struct NewRound {
    /// The revision of the instrument that it asks.
    pub revision_id: RevisionId,
    /// Title.
    pub title: String,
    /// The ratings are made by a program.
    pub generated: bool,
    /// Attempts.
    pub sessions: Vec<SessionId>,
    /// Raters.
    pub raters: Vec<PersonId>,
}

/// A rating of the one who asks.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct Rating {
    /// Id: random.
    pub id: RatingId,
    /// Its school.
    pub school_id: SchoolId,
    /// Its round.
    pub round_id: RoundId,
    /// The attempt.
    pub session_id: SessionId,
    /// In the order of the instrument's items.
    pub answers: Json<Vec<Option<Answer>>>,
    /// When it was finished.
    pub finished_at: Option<Moment>,
}

/// Makes a round with a rating for every attempt and rater.
///
/// # Errors
/// When an attempt, rater or revision is not of the school, or the database fails.
pub async fn add(writer: &mut Connection, by: &CurrentPerson, new: &NewRound, now: Moment) -> Result<RoundId> {
    let round: RoundId = sqlx::query_scalar(
        "INSERT INTO rating_rounds (id, school_id, revision_id, title, generated, made_by, made_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7) RETURNING id",
    )
    .bind(RoundId::made_at(now))
    .bind(by.school_id)
    .bind(new.revision_id)
    .bind(&new.title)
    .bind(new.generated)
    .bind(by.id)
    .bind(now)
    .fetch_one(&mut *writer)
    .await?;
    for session in &new.sessions {
        for rater in &new.raters {
            add_rating(writer, by.school_id, round, *session, *rater).await?;
        }
    }
    Ok(round)
}

async fn add_rating(
    writer: &mut Connection,
    school: SchoolId,
    round: RoundId,
    session: SessionId,
    rater: PersonId,
) -> Result<()> {
    // A sorted id would tell which rating of another rater is of the same attempt.
    let id = RatingId::random();
    sqlx::query(
        "INSERT INTO ratings (id, school_id, round_id, session_id, rater_id, answers) VALUES ($1, $2, $3, $4, $5, '[]')",
    )
    .bind(id)
    .bind(school)
    .bind(round)
    .bind(session)
    .bind(rater)
    .execute(&mut *writer)
    .await?;
    mark_knowledge(writer, school, id).await
}

/// Marks a rating whose rater can see the attempt elsewhere: the rater teaches the trainee, is an administrator, made the round, or runs a
/// study with the trainee. A mark is never removed.
async fn mark_knowledge(writer: &mut Connection, school: SchoolId, id: RatingId) -> Result<()> {
    sqlx::query(
        "UPDATE ratings SET may_know = TRUE WHERE school_id = $1 AND id = $2 AND finished_at IS NULL AND (
           EXISTS (SELECT 1 FROM people p WHERE p.id = ratings.rater_id AND p.role = 'administrator')
           OR EXISTS (SELECT 1 FROM rating_rounds o WHERE o.id = ratings.round_id AND o.made_by = ratings.rater_id)
           OR EXISTS (SELECT 1 FROM sessions s
             JOIN taught_trainees taught ON taught.trainee_id = s.trainee_id
             WHERE s.school_id = $1 AND s.id = ratings.session_id AND taught.teacher_id = ratings.rater_id)
           OR EXISTS (SELECT 1 FROM sessions s
             JOIN study_participants t ON t.school_id = s.school_id AND t.person_id = s.trainee_id
             JOIN studies u ON u.school_id = t.school_id AND u.id = t.study_id
             WHERE s.school_id = $1 AND s.id = ratings.session_id AND u.owner_id = ratings.rater_id))",
    )
    .bind(school)
    .bind(id)
    .execute(writer)
    .await
    .map(drop)
}

/// Columns of a round as a viewer ($2) sees it, whatever limits the list.
macro_rules! listed {
    ($rest:literal) => {
        concat!(
            "SELECT o.id, o.school_id, o.revision_id, i.title AS instrument, o.title, o.generated, o.made_by,
               p.display_name AS \"by\", o.made_at,
               (SELECT count(*) FROM ratings r WHERE r.round_id = o.id) AS ratings,
               (SELECT count(r.finished_at) FROM ratings r WHERE r.round_id = o.id) AS finished,
               (SELECT count(*) FROM ratings r WHERE r.school_id = o.school_id AND r.rater_id = $2
                  AND r.round_id = o.id) AS own,
               (SELECT count(*) FROM ratings r WHERE r.school_id = o.school_id AND r.rater_id = $2
                  AND r.round_id = o.id AND r.finished_at IS NULL) AS own_open
             FROM rating_rounds o
             JOIN instrument_revisions i ON i.id = o.revision_id
             JOIN people p ON p.school_id = o.school_id AND p.id = o.made_by ",
            $rest,
            ""
        )
    };
}

/// A round that a person asked for or takes part in; any of the school's for an administrator.
pub async fn find(executor: impl Executor<'_>, viewer: &CurrentPerson, id: RoundId) -> Result<Option<Round>> {
    sqlx::query_as(listed!(
        "WHERE o.school_id = $1 AND o.id = $4 AND o.withdrawn_at IS NULL AND ($3 OR o.made_by = $2 OR EXISTS (
           SELECT 1 FROM ratings r WHERE r.school_id = $1 AND r.rater_id = $2 AND r.round_id = o.id))"
    ))
    .bind(viewer.school_id)
    .bind(viewer.id)
    .bind(viewer.role == Role::Administrator)
    .bind(id)
    .fetch_optional(executor)
    .await
}

/// The rounds that [`find`] finds, the latest first, at most 100.
pub async fn all(executor: impl Executor<'_>, viewer: &CurrentPerson) -> Result<Vec<Round>> {
    sqlx::query_as(listed!(
        "WHERE o.school_id = $1 AND o.withdrawn_at IS NULL AND ($3 OR o.made_by = $2 OR o.id IN (
           SELECT r.round_id FROM ratings r WHERE r.school_id = $1 AND r.rater_id = $2))
         ORDER BY o.made_at DESC, o.id DESC LIMIT 100"
    ))
    .bind(viewer.school_id)
    .bind(viewer.id)
    .bind(viewer.role == Role::Administrator)
    .fetch_all(executor)
    .await
}

/// How many ratings wait for somebody.
pub async fn count_open(executor: impl Executor<'_>, rater: &CurrentPerson) -> Result<u32> {
    sqlx::query_scalar(
        "SELECT count(*) FROM ratings r JOIN rating_rounds o ON o.id = r.round_id AND o.withdrawn_at IS NULL
         WHERE r.school_id = $1 AND r.rater_id = $2 AND r.finished_at IS NULL",
    )
    .bind(rater.school_id)
    .bind(rater.id)
    .fetch_one(executor)
    .await
    .map(count_u32::<i64>)
}

/// A rater's own ratings of a round, in the order in which they see them.
pub async fn own(executor: impl Executor<'_>, rater: &CurrentPerson, round: RoundId) -> Result<Vec<Rating>> {
    sqlx::query_as(
        "SELECT id, school_id, round_id, session_id, answers, finished_at FROM ratings
         WHERE school_id = $1 AND rater_id = $2 AND round_id = $3 ORDER BY id",
    )
    .bind(rater.school_id)
    .bind(rater.id)
    .bind(round)
    .fetch_all(executor)
    .await
}

/// A rating that a person is asked for. Nobody else's, whoever asks.
pub async fn rating(executor: impl Executor<'_>, rater: &CurrentPerson, id: RatingId) -> Result<Option<Rating>> {
    sqlx::query_as(
        "SELECT r.id, r.school_id, r.round_id, r.session_id, r.answers, r.finished_at FROM ratings r
         JOIN rating_rounds o ON o.id = r.round_id AND o.withdrawn_at IS NULL
         WHERE r.id = $1 AND r.school_id = $2 AND r.rater_id = $3",
    )
    .bind(id)
    .bind(rater.school_id)
    .bind(rater.id)
    .fetch_optional(executor)
    .await
}

/// Stores the answers so far, and, with a moment, that they are finished. False where they are already.
pub async fn put(writer: &mut Connection, rating: &Rating, finished_at: Option<Moment>) -> Result<bool> {
    mark_knowledge(writer, rating.school_id, rating.id).await?;
    sqlx::query(
        "UPDATE ratings SET answers = $3, finished_at = $4 WHERE school_id = $1 AND id = $2 AND finished_at IS NULL",
    )
    .bind(rating.school_id)
    .bind(rating.id)
    .bind(&rating.answers)
    .bind(finished_at)
    .execute(writer)
    .await
    .map(|done| done.rows_affected() == 1)
}

/// Takes a round back: nobody is asked any more, and its ratings are shown nowhere.
pub async fn withdraw(writer: &mut Connection, round: &Round, now: Moment) -> Result<()> {
    sqlx::query("UPDATE rating_rounds SET withdrawn_at = $3 WHERE school_id = $1 AND id = $2")
        .bind(round.school_id)
        .bind(round.id)
        .bind(now)
        .execute(writer)
        .await
        .map(drop)
}
