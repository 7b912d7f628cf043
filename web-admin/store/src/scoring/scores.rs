//! Metrics, scores and curves computed from recordings.

use std::collections::BTreeMap;

use assessment::{Absent, Assessment, Deduction, Direction, HardFailure, Metric};
use attempt::AttemptCurve;
use model::ids::{SchoolId, ScoreId, SessionId};
use model::{Moment, SessionKey};
use serde::Deserialize;
use sqlx::FromRow;

use crate::engine::TableColumns;
use crate::{Connection, ExactNumber, Executor, Json, Result, engine};

/// A computed score of an attempt.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct Score {
    /// Id.
    pub id: ScoreId,
    /// Score, 0–100.
    pub score: f64,
    /// The score reaches the pass mark, and there is no hard fail.
    pub passed: bool,
    /// Id of the exercise whose rubric was applied.
    pub rubric_id: String,
    /// SHA-256 of the rubric.
    pub rubric_sha256: String,
    /// Deductions, by line of the rubric.
    pub deductions: Json<Vec<Deduction>>,
    /// Reasons for failing regardless of the score.
    pub hard_fails: Json<Vec<HardFailure>>,
    /// Version of the simulator that recorded the attempt.
    pub simulator_version: String,
    /// Time of the computation.
    pub computed_at: Moment,
}

#[derive(FromRow)]
struct MetricRow {
    id: String,
    #[sqlx(try_from = "i64")]
    version: u32,
    value: Option<f64>,
    unit: String,
    direction: String,
    applies: bool,
    label: String,
    absent: String,
}

impl TryFrom<MetricRow> for Metric {
    type Error = crate::Error;

    fn try_from(row: MetricRow) -> Result<Self> {
        let direction = match row.direction.as_str() {
            "higher" => Direction::Higher,
            "lower" => Direction::Lower,
            "range" => Direction::Range,
            other => return Err(crate::Error::Decode(format!("metrics.direction: {other:?}").into())),
        };
        let MetricRow { id, version, value, unit, applies, label, absent, .. } = row;
        let absent = Absent::from_stored(&absent);
        Ok(Self { id, version, value, unit, direction, applies, label, absent })
    }
}

const fn direction_word(direction: Direction) -> &'static str {
    match direction {
        Direction::Lower => "lower",
        Direction::Higher => "higher",
        Direction::Range => "range",
    }
}

/// Adds a score and keeps earlier ones. Returns its id.
pub async fn add_score(
    writer: &mut Connection,
    session: SessionKey,
    assessment: &Assessment,
    now: Moment,
) -> Result<ScoreId> {
    add_metrics(writer, session, &assessment.metrics).await?;
    let id = ScoreId::made_at(now);
    sqlx::query(
        "INSERT INTO scores (id, school_id, session_id, score, passed, rubric_id, rubric_sha256, deductions,
         hard_fails, simulator_version, computed_at) VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11)",
    )
    .bind(id)
    .bind(session.school_id)
    .bind(session.id)
    .bind(assessment.score)
    .bind(assessment.passed)
    .bind(&assessment.rubric.id)
    .bind(&assessment.rubric.sha256)
    .bind(Json(&assessment.deductions))
    .bind(Json(&assessment.hard_fails))
    .bind(&assessment.simulator_version)
    .bind(now)
    .execute(writer)
    .await?;
    Ok(id)
}

/// Adds metrics in order, except those that the attempt already has. It uses one statement, because
/// all other writers wait for this transaction.
async fn add_metrics(writer: &mut Connection, session: SessionKey, metrics: &[Metric]) -> Result<()> {
    const METRICS: TableColumns = TableColumns {
        table: "metrics",
        columns: &[
            "school_id",
            "session_id",
            "position",
            "id",
            "version",
            "value",
            "unit",
            "direction",
            "applies",
            "label",
            "absent",
        ],
    };
    let placed: Vec<(i64, &Metric)> = (0..).zip(metrics).collect();
    engine::add_missing_rows(writer, &METRICS, &placed, |mut row, (position, metric)| {
        row.push_bind(session.school_id)
            .push_bind(session.id)
            .push_bind(*position)
            .push_bind(&metric.id)
            .push_bind(i64::from(metric.version))
            .push_bind(metric.value)
            .push_bind(&metric.unit)
            .push_bind(direction_word(metric.direction))
            .push_bind(metric.applies)
            .push_bind(&metric.label)
            .push_bind(metric.absent.map_or("", Absent::code));
    })
    .await
}

/// Returns all computed scores of an attempt in the order of insertion, which does not depend on
/// the clock.
pub async fn list_scores(executor: impl Executor<'_>, session: SessionKey) -> Result<Vec<Score>> {
    sqlx::query_as(
        "SELECT id, score, passed, rubric_id, rubric_sha256, deductions, hard_fails, simulator_version, computed_at
         FROM scores WHERE school_id = $1 AND session_id = $2 ORDER BY rowid",
    )
    .bind(session.school_id)
    .bind(session.id)
    .fetch_all(executor)
    .await
}

/// Returns the computed scores (0–100) of all attempts, each in the order of insertion.
pub async fn count_added_scores(executor: impl Executor<'_>) -> Result<BTreeMap<SessionId, Vec<f64>>> {
    let rows: Vec<(SessionId, f64)> =
        sqlx::query_as("SELECT session_id, score FROM scores ORDER BY rowid").fetch_all(executor).await?;
    let mut added: BTreeMap<SessionId, Vec<f64>> = BTreeMap::new();
    for (session, score) in rows {
        added.entry(session).or_default().push(score);
    }
    Ok(added)
}

/// Returns the newest computed score, which the grade refers to. [`crate::scoring::grades::find_grade`]
/// returns whether it is overridden.
pub async fn find_newest_score(executor: impl Executor<'_>, session: SessionKey) -> Result<Option<Score>> {
    sqlx::query_as(
        "SELECT id, score, passed, rubric_id, rubric_sha256, deductions, hard_fails, simulator_version, computed_at
         FROM scores WHERE id = (SELECT score_id FROM grades WHERE school_id = $1 AND session_id = $2)",
    )
    .bind(session.school_id)
    .bind(session.id)
    .fetch_optional(executor)
    .await
}

/// Returns the metrics of an attempt, in the order of the catalogue.
pub async fn list_score_metrics(executor: impl Executor<'_>, session: SessionKey) -> Result<Vec<Metric>> {
    let rows: Vec<MetricRow> = sqlx::query_as(
        "SELECT id, version, value, unit, direction, applies, label, absent FROM metrics
         WHERE school_id = $1 AND session_id = $2 ORDER BY position, version",
    )
    .bind(session.school_id)
    .bind(session.id)
    .fetch_all(executor)
    .await?;
    rows.into_iter().map(Metric::try_from).collect()
}

/// One metric of several attempts.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct MetricOfMany {
    /// Id.
    pub id: String,
    /// Version.
    #[sqlx(try_from = "i64")]
    pub version: u32,
    /// Unit.
    pub unit: String,
    /// Name.
    pub label: String,
    /// Values, in no particular order.
    pub found: Json<Vec<FoundMetric>>,
}

/// A metric of one of several attempts: index of the attempt, value, and code of the reason if it
/// is absent.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct FoundMetric(pub usize, ExactNumber, pub String);

impl FoundMetric {
    /// Returns the value, in the metric's unit.
    #[must_use]
    pub const fn value(&self) -> Option<f64> {
        self.1.0
    }

    /// Returns the reason why there is no value.
    #[must_use]
    pub fn absent(&self) -> Option<Absent> {
        Absent::from_stored(&self.2)
    }
}

/// Returns the metrics of several attempts of a school, in the order of the catalogue.
///
/// Each metric is one row with a JSON array, because SQLite's cost grows with the number of cells:
/// thirty attempts have twenty thousand.
pub async fn metrics_of_many(
    executor: impl Executor<'_>,
    school: SchoolId,
    sessions: &[SessionId],
) -> Result<Vec<MetricOfMany>> {
    // The cross join fixes the order of the join: from the given attempts to their metrics.
    sqlx::query_as(
        "SELECT m.id, m.version, min(m.unit) AS unit, min(m.label) AS label,
           json_group_array(json_array(asked.key, iif(m.value IS NULL, NULL, printf('%!.17g', m.value)), m.absent)) AS found
         FROM json_each($2) asked CROSS JOIN metrics m
         WHERE m.school_id = $1 AND m.session_id = unhex(asked.value, '-')
         GROUP BY m.id, m.version ORDER BY min(m.position), m.version",
    )
    .bind(school)
    .bind(Json(sessions))
    .fetch_all(executor)
    .await
}

/// A value of one of several attempts: index of the attempt, id and version of the metric, value in
/// its unit.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct ValueOfMany(pub usize, pub String, pub u32, pub f64);

/// Returns the values of several attempts of a school in no particular order, with 15 digits. This
/// is enough for quartiles that are shown with three.
///
/// All values are in one cell: grouping them by metric takes SQLite twice as long.
pub async fn list_values_of_many(
    executor: impl Executor<'_>,
    school: SchoolId,
    sessions: &[SessionId],
) -> Result<Vec<ValueOfMany>> {
    // The cross join fixes the order of the join: from the given attempts to their metrics.
    let found: Json<Vec<ValueOfMany>> = sqlx::query_scalar(
        "SELECT json_group_array(json_array(asked.key, m.id, m.version, m.value))
         FROM json_each($2) asked CROSS JOIN metrics m
         WHERE m.school_id = $1 AND m.session_id = unhex(asked.value, '-') AND m.value IS NOT NULL",
    )
    .bind(school)
    .bind(Json(sessions))
    .fetch_one(executor)
    .await?;
    Ok(found.0)
}

/// Stores the curve of an attempt, which pages draw.
pub async fn put_curve(writer: &mut Connection, session: SessionKey, curve: &AttemptCurve) -> Result<()> {
    sqlx::query(
        "INSERT INTO session_curves (school_id, session_id, body) VALUES ($1, $2, $3)
         ON CONFLICT (school_id, session_id) DO UPDATE SET body = excluded.body",
    )
    .bind(session.school_id)
    .bind(session.id)
    .bind(Json(curve))
    .execute(writer)
    .await
    .map(drop)
}

/// Returns the curve of an attempt, which pages draw.
pub async fn find_curve(executor: impl Executor<'_>, session: SessionKey) -> Result<Option<AttemptCurve>> {
    let body: Option<Json<AttemptCurve>> =
        sqlx::query_scalar("SELECT body FROM session_curves WHERE school_id = $1 AND session_id = $2")
            .bind(session.school_id)
            .bind(session.id)
            .fetch_optional(executor)
            .await?;
    Ok(body.map(|json| json.0))
}
