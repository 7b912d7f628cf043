//! Signs that a trainee is at risk, and the school's rules. Each query reads only the trainees to
//! whom its rule applies, by an index.

use model::ids::{CohortId, PersonId, SchoolId};
use model::titles::StoredTitle;
use model::training::risk::{
    CONSIDERED_DAYS, Concern, RiskRule, RiskRules, RuleSetting, TraineeAddress, TraineeConcern,
};
use model::{Moment, count_u32};
use sqlx::FromRow;
use uuid::Uuid;

use crate::engine::AnswerRow;
use crate::{Connection, Executor, Pool, Result};

const DAY_S: i64 = 86_400;

/// Whose concerns are listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RiskScope {
    /// All trainees of the school.
    School,
    /// The trainees of the cohorts that a person teaches.
    Teacher(PersonId),
    /// The trainees of a cohort.
    Cohort(CohortId),
    /// A trainee.
    Trainee(PersonId),
}

impl RiskScope {
    fn id(self) -> Option<Uuid> {
        match self {
            Self::School => None,
            Self::Teacher(id) | Self::Trainee(id) => Some(id.uuid()),
            Self::Cohort(id) => Some(id.uuid()),
        }
    }
}

/// Returns the rules of a school.
pub async fn find_rules(executor: impl Executor<'_>, school: SchoolId) -> Result<RiskRules> {
    let stored: Vec<RuleSetting> =
        sqlx::query_as("SELECT rule, applies, number, weight FROM risk_rules WHERE school_id = $1")
            .bind(school)
            .fetch_all(executor)
            .await?;
    Ok(RiskRules::of(&stored))
}

/// Stores the rules of a school.
pub async fn put_rules(writer: &mut Connection, school: SchoolId, rules: &RiskRules) -> Result<()> {
    for RuleSetting { rule, applies, number, weight } in rules.settings() {
        sqlx::query(
            "INSERT INTO risk_rules (school_id, rule, applies, number, weight) VALUES ($1, $2, $3, $4, $5)
             ON CONFLICT (school_id, rule) DO UPDATE SET applies = excluded.applies, number = excluded.number,
             weight = excluded.weight",
        )
        .bind(school)
        .bind(rule)
        .bind(applies)
        .bind(i64::from(*number))
        .bind(i64::from(*weight))
        .execute(&mut *writer)
        .await?;
    }
    Ok(())
}

/// Returns every concern about the trainees of a scope, by the rules of the school, in no order.
/// Attempts and due dates of more than twelve weeks ago are not considered.
pub async fn list_concerns(
    reader: &Pool,
    school: SchoolId,
    scope: RiskScope,
    rules: &RiskRules,
    now: Moment,
) -> Result<Vec<TraineeConcern>> {
    let asked = Asked { reader, school, scope, now, since: now.plus_s(-CONSIDERED_DAYS * DAY_S) };
    let mut found = Vec::new();
    if let Some(days) = rules.number(RiskRule::NotBegun) {
        found.extend(asked.not_begun(days).await?);
    }
    if let Some(fails) = rules.number(RiskRule::Failing) {
        found.extend(asked.failing(fails).await?);
    }
    if let Some(points) = rules.number(RiskRule::Falling) {
        found.extend(asked.falling(points).await?);
    }
    if let Some(weeks) = rules.number(RiskRule::Inactive) {
        found.extend(asked.inactive(weeks).await?);
    }
    Ok(found)
}

/// Selects the assignments without an attempt of school `$1`, due between `$2` and `$3`, and the
/// trainees.
macro_rules! not_begun {
    ($rest:literal) => {
        concat!(
            "SELECT p.id, p.display_name AS name, p.email NOT LIKE '%@no-address.invalid' AS has_address,
               coalesce(r.title, c.title, '') AS title, coalesce(x.due_at, a.due_at) AS due_at
             FROM (SELECT b.id, b.school_id, b.exercise_id, b.curriculum_id, b.since_only, b.made_at, b.due_at,
                     m.person_id AS trainee_id
                   FROM assignments b JOIN cohort_members m ON m.cohort_id = b.cohort_id
                   WHERE b.school_id = $1 AND m.role = 'trainee' AND b.withdrawn_at IS NULL AND b.due_at <= $3
                     AND (b.due_at >= $2 OR EXISTS (SELECT 1 FROM assignment_extensions y WHERE y.assignment_id = b.id))
                   UNION ALL
                   SELECT b.id, b.school_id, b.exercise_id, b.curriculum_id, b.since_only, b.made_at, b.due_at, b.person_id
                   FROM assignments b
                   WHERE b.school_id = $1 AND b.person_id IS NOT NULL AND b.withdrawn_at IS NULL AND b.due_at <= $3
                     AND (b.due_at >= $2 OR EXISTS (SELECT 1 FROM assignment_extensions y WHERE y.assignment_id = b.id))) a
             CROSS JOIN people p
             LEFT JOIN assignment_extensions x ON x.assignment_id = a.id AND x.person_id = a.trainee_id
             LEFT JOIN exercises e ON e.school_id = a.school_id AND e.exercise_id = a.exercise_id
             LEFT JOIN exercise_revisions r ON r.id = e.revision_id
             LEFT JOIN curricula u ON u.school_id = a.school_id AND u.curriculum_id = a.curriculum_id
             LEFT JOIN curriculum_revisions c ON c.id = u.revision_id
             WHERE p.school_id = a.school_id AND p.id = a.trainee_id AND p.role = 'trainee' AND p.disabled_at IS NULL
               AND coalesce(x.due_at, a.due_at) >= $2 AND coalesce(x.due_at, a.due_at) <= $3
               AND NOT EXISTS (SELECT 1 FROM practice_signs s
                 WHERE s.school_id = a.school_id AND s.trainee_id = a.trainee_id
                   AND (NOT a.since_only OR s.last_at >= a.made_at)
                   AND (s.exercise_id = a.exercise_id OR EXISTS (SELECT 1 FROM curriculum_entries t
                     WHERE t.revision_id = u.revision_id AND t.exercise_id = s.exercise_id))) ",
            $rest
        )
    };
}

/// Selects the signs of school `$1` since `$2` and their trainees. Adding 0 to the time keeps SQLite
/// from reading the school's signs by time where it looks for those of a few trainees.
macro_rules! practice_signs {
    ($signs:literal, $rest:literal) => {
        concat!(
            "SELECT p.id, p.display_name AS name, p.email NOT LIKE '%@no-address.invalid' AS has_address, s.exercise_id,
               coalesce(r.title, s.exercise_id) AS title, s.fails, s.last_score, s.last_mean, s.falls
             FROM practice_signs s
             CROSS JOIN people p
             LEFT JOIN exercises e ON e.school_id = s.school_id AND e.exercise_id = s.exercise_id
             LEFT JOIN exercise_revisions r ON r.id = e.revision_id
             WHERE p.school_id = s.school_id AND p.id = s.trainee_id AND p.role = 'trainee' AND p.disabled_at IS NULL
               AND s.school_id = $1 AND ",
            $signs,
            $rest
        )
    };
}

/// Selects the trainees of school `$1` whose latest attempt was between `$2` and `$3`, and who have
/// begun a course without passing all of its exercises.
macro_rules! inactive {
    ($rest:literal) => {
        concat!(
            "SELECT p.id, p.display_name AS name, p.email NOT LIKE '%@no-address.invalid' AS has_address, p.practised_at
             FROM people p WHERE p.school_id = $1 AND p.practised_at >= $2 AND p.practised_at <= $3
               AND p.role = 'trainee' AND p.disabled_at IS NULL
               AND EXISTS (SELECT 1 FROM curricula u WHERE u.school_id = $1
                 AND EXISTS (SELECT 1 FROM curriculum_entries t CROSS JOIN practice_signs s
                   WHERE s.school_id = $1 AND s.trainee_id = p.id AND s.exercise_id = t.exercise_id
                     AND t.revision_id = u.revision_id)
                 AND EXISTS (SELECT 1 FROM curriculum_entries t WHERE t.revision_id = u.revision_id
                   AND NOT EXISTS (SELECT 1 FROM practice_signs s WHERE s.school_id = $1 AND s.trainee_id = p.id
                     AND s.exercise_id = t.exercise_id AND s.passes > 0))) ",
            $rest
        )
    };
}

#[derive(FromRow)]
struct NotBegunRow {
    #[sqlx(flatten)]
    trainee: TraineeAddress,
    #[sqlx(try_from = "StoredTitle")]
    title: String,
    due_at: Moment,
}

#[derive(FromRow)]
struct SignRow {
    #[sqlx(flatten)]
    trainee: TraineeAddress,
    exercise_id: String,
    #[sqlx(try_from = "StoredTitle")]
    title: String,
    fails: i64,
    last_score: f64,
    last_mean: Option<f64>,
    falls: Option<f64>,
}

#[derive(FromRow)]
struct InactiveRow {
    #[sqlx(flatten)]
    trainee: TraineeAddress,
    practised_at: Moment,
}

/// What the queries have in common.
struct Asked<'a> {
    reader: &'a Pool,
    school: SchoolId,
    scope: RiskScope,
    now: Moment,
    since: Moment,
}

impl Asked<'_> {
    /// Runs the statement for the whole school, or the other one for a part of it. `$3` is a limit.
    async fn rows<R>(&self, [whole, part]: [&'static str; 2], limit: i64) -> Result<Vec<R>>
    where
        R: for<'r> FromRow<'r, AnswerRow> + Send + Unpin,
    {
        let statement = if self.scope == RiskScope::School { whole } else { part };
        let query = sqlx::query_as(statement).bind(self.school).bind(self.since).bind(limit);
        match self.scope.id() {
            Some(id) => query.bind(id).fetch_all(self.reader).await,
            None => query.fetch_all(self.reader).await,
        }
    }

    async fn not_begun(&self, days: u32) -> Result<Vec<TraineeConcern>> {
        let statements = [
            not_begun!(""),
            not_begun!(
                "AND a.trainee_id IN (SELECT m.person_id FROM cohort_members m WHERE m.cohort_id = $4 AND m.role = 'trainee'
                   UNION SELECT t.trainee_id FROM taught_trainees t WHERE t.teacher_id = $4
                   UNION SELECT q.id FROM people q WHERE q.school_id = $1 AND q.id = $4)"
            ),
        ];
        let rows = self.rows(statements, self.now.plus_s(i64::from(days) * DAY_S).micros()).await?;
        let concern = |NotBegunRow { trainee, title, due_at }| {
            let concern = Concern::NotBegun { title, due_at };
            TraineeConcern { trainee, concern }
        };
        Ok(rows.into_iter().map(concern).collect())
    }

    async fn failing(&self, fails: u32) -> Result<Vec<TraineeConcern>> {
        let statements = [
            practice_signs!("s.last_at >= $2 AND s.fails >= 2 AND s.fails >= $3", ""),
            practice_signs!(
                "s.last_at + 0 >= $2 AND s.fails >= 2 AND s.fails >= $3",
                " AND s.trainee_id IN (SELECT m.person_id FROM cohort_members m WHERE m.cohort_id = $4 AND m.role = 'trainee'
                   UNION SELECT t.trainee_id FROM taught_trainees t WHERE t.teacher_id = $4
                   UNION SELECT q.id FROM people q WHERE q.school_id = $1 AND q.id = $4)"
            ),
        ];
        let concern = |row: SignRow| {
            let (exercise, title, fails) = (row.exercise_id, row.title, count_u32(row.fails));
            let concern = Concern::Failing { exercise, title, fails, last_score: row.last_score };
            TraineeConcern { trainee: row.trainee, concern }
        };
        Ok(self.rows(statements, i64::from(fails)).await?.into_iter().map(concern).collect())
    }

    async fn falling(&self, points: u32) -> Result<Vec<TraineeConcern>> {
        let statements = [
            practice_signs!("s.last_at >= $2 AND s.falls >= 1 AND s.falls >= $3", ""),
            practice_signs!(
                "s.last_at + 0 >= $2 AND s.falls >= 1 AND s.falls >= $3",
                " AND s.trainee_id IN (SELECT m.person_id FROM cohort_members m WHERE m.cohort_id = $4 AND m.role = 'trainee'
                   UNION SELECT t.trainee_id FROM taught_trainees t WHERE t.teacher_id = $4
                   UNION SELECT q.id FROM people q WHERE q.school_id = $1 AND q.id = $4)"
            ),
        ];
        let concern = |row: SignRow| {
            let to = row.last_mean.unwrap_or_default();
            let from = to + row.falls.unwrap_or_default();
            let concern = Concern::Falling { exercise: row.exercise_id, title: row.title, from, to };
            TraineeConcern { trainee: row.trainee, concern }
        };
        Ok(self.rows(statements, i64::from(points)).await?.into_iter().map(concern).collect())
    }

    async fn inactive(&self, weeks: u32) -> Result<Vec<TraineeConcern>> {
        let statements = [
            inactive!(""),
            inactive!(
                "AND p.id IN (SELECT m.person_id FROM cohort_members m WHERE m.cohort_id = $4 AND m.role = 'trainee'
                   UNION SELECT t.trainee_id FROM taught_trainees t WHERE t.teacher_id = $4
                   UNION SELECT q.id FROM people q WHERE q.school_id = $1 AND q.id = $4)"
            ),
        ];
        let until = self.now.plus_s(-i64::from(weeks) * 7 * DAY_S);
        let concern = |InactiveRow { trainee, practised_at }| {
            let days = (self.now.to_utc() - practised_at.to_utc()).whole_days();
            TraineeConcern { trainee, concern: Concern::Inactive { days } }
        };
        Ok(self.rows(statements, until.micros()).await?.into_iter().map(concern).collect())
    }
}
