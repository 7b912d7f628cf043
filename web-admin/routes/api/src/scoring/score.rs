//! The score of an attempt.

use acts::error::Error;
use assessment::{Assessment, RubricRef};
use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use model::ids::SessionId;
use model::{Moment, Proof, Uncounted};
use routes_base::AppState;
use routes_base::error::{ApiError, ProblemDocument};
use serde::Serialize;
use store::recordings::proofs;
use store::recordings::sessions::SessionState;
use store::scoring::{grades, scores};
use utoipa::ToSchema;

use crate::ApiId;
use crate::caller::Caller;
use crate::recordings::sessions::find_session;

/// State of the score while there is none.
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Waiting)]
struct WaitingDocument {
    state: SessionState,
}

/// A computed score, and the override that replaces it.
#[derive(Serialize, ToSchema)]
#[schema(as = Graded)]
struct GradedDocument {
    #[serde(flatten)]
    #[schema(value_type = ScoreDocument)]
    computed: Assessment,
    /// The score that counts instead of the computed one; absent unless the score was overridden.
    #[serde(rename = "override", skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    overridden: Option<OverrideView>,
    /// Reason why the attempt does not count; absent if it counts.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    uncounted: Option<Uncounted>,
    /// Evidence for the authenticity of the attempt.
    proof: Proof,
}

/// A score in the format of `stylet score --json`.
#[derive(ToSchema)]
#[expect(dead_code, reason = "describes `Assessment`, whose crate knows of no API; a test holds answers against it")]
struct ScoreDocument {
    /// 0–100.
    score: f64,
    /// At or above the pass mark, without a hard fail.
    passed: bool,
    /// Every metric of the catalogue.
    metrics: Vec<MetricDocument>,
    /// Points lost, one entry per line of the rubric.
    deductions: Vec<DeductionDocument>,
    /// Reasons why the attempt failed regardless of its points.
    hard_fails: Vec<FailureDocument>,
    rubric: RubricDocument,
    /// Version of the simulator that recorded the attempt.
    simulator_version: String,
}

/// A metric's value in an attempt.
#[derive(ToSchema)]
#[expect(dead_code, reason = "as `ScoreDocument`")]
struct MetricDocument {
    /// For example `depth_error_mm` or `peak_force_layer_n.skin`.
    id: String,
    /// Version of its definition.
    version: u32,
    /// In `unit`; absent outside the metric's domain.
    #[schema(required)]
    value: Option<f64>,
    /// `count` for a count, `1` for a pure number.
    unit: String,
    /// Which values are better: `lower`, `higher`, or near 0 in a `range`.
    direction: String,
    /// Whether the metric applies to this attempt.
    applies: bool,
    /// Display name.
    label: String,
    /// Why it does not apply: `untouched`, `not_inside`, `layer_not_reached`, `no_rupture`,
    /// `never_stopped`, `no_ledger`, `too_short`, `not_finite` or `of_another_version`; absent if
    /// it applies.
    #[schema(nullable = false)]
    absent: Option<String>,
}

/// Points lost on a line of the rubric.
#[derive(ToSchema)]
#[expect(dead_code, reason = "as `ScoreDocument`")]
struct DeductionDocument {
    /// The metric's id.
    metric: String,
    /// Version of the metric's definition that the rubric requires.
    version: u32,
    /// Points lost, out of 100.
    points: f64,
    cause: DeductionCauseDocument,
    /// The cause in English.
    why: String,
}

/// Why points were lost or kept.
#[derive(ToSchema)]
#[schema(as = DeductionCause)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[expect(dead_code, reason = "as `ScoreDocument`")]
enum DeductionCauseDocument {
    /// The metric has a value: no points are lost at `full`, all points are lost at `zero`. All in
    /// the metric's unit.
    Measured { value: f64, full: f64, zero: f64 },
    /// The metric has no value; the reason as in a metric's `absent`.
    Absent { reason: String },
    /// No points are earned, because a requirement was not met: `reached`, `within`, `confirmed` or
    /// `withdrawn`.
    Required { unmet: String },
    /// The scene has no such metric.
    NoSuchMetric,
    /// Stored before causes were recorded as data: the text that was stored.
    Worded { words: String },
}

/// Why an attempt failed regardless of its points.
#[derive(ToSchema)]
#[expect(dead_code, reason = "as `ScoreDocument`")]
struct FailureDocument {
    cause: FailureCauseDocument,
    /// The cause in English.
    why: String,
}

/// Why an attempt failed.
#[derive(ToSchema)]
#[schema(as = FailureCause)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[expect(dead_code, reason = "as `ScoreDocument`")]
enum FailureCauseDocument {
    /// A requirement was not met: `reached`, `within`, `confirmed` or `withdrawn`.
    Required { unmet: String },
    /// A metric exceeds its limit; `words` is the author's explanation. Both numbers are in the
    /// metric's unit.
    Limit { words: String, metric: String, version: u32, value: f64, limit: f64 },
    /// Stored before causes were recorded as data: the text that was stored.
    Worded { words: String },
}

/// The rubric that was applied.
#[derive(ToSchema)]
#[expect(dead_code, reason = "as `ScoreDocument`")]
struct RubricDocument {
    /// The exercise's id.
    id: String,
    sha256: String,
}

/// An override of the computed score.
#[derive(Serialize, ToSchema)]
struct OverrideView {
    /// 0–100.
    score: f64,
    passed: bool,
    reason: String,
    #[schema(value_type = String, format = DateTime)]
    made_at: Moment,
}

impl OverrideView {
    fn of(made: grades::OverrideRecord) -> Option<Self> {
        let (score, passed) = made.score.zip(made.passed)?;
        Some(Self { score, passed, reason: made.reason, made_at: made.made_at })
    }
}

/// Returns the newest computed score, in the format of `stylet score --json`; if the score was
/// overridden, `override` contains the score that counts. 202 while the recording waits to be
/// scored.
#[utoipa::path(get, path = "/sessions/{id}/score", tag = "score", operation_id = "show_score", params(("id" = Uuid, Path)),
    responses((status = 200, body = GradedDocument), (status = 202, body = WaitingDocument),
              (status = 404, body = ProblemDocument, description = "No such attempt, or one that cannot be scored")))]
pub(crate) async fn show_score(
    State(state): State<AppState>,
    caller: Caller,
    ApiId(id): ApiId<SessionId>,
) -> Result<Response, ApiError> {
    let session = find_session(&state, &caller, id).await?;
    let key = session.key();
    let Some(score) = scores::find_newest_score(state.db.reader(), key).await? else {
        return match session.state {
            SessionState::Refused => Err(Error::Unscored(session.refusal.unwrap_or_default()).into()),
            waiting => Ok((StatusCode::ACCEPTED, Json(WaitingDocument { state: waiting })).into_response()),
        };
    };
    let metrics = scores::list_score_metrics(state.db.reader(), key).await?;
    let computed = Assessment {
        score: score.score,
        passed: score.passed,
        metrics,
        deductions: score.deductions.0,
        hard_fails: score.hard_fails.0,
        rubric: RubricRef { id: score.rubric_id, sha256: score.rubric_sha256 },
        simulator_version: score.simulator_version,
    };
    let overridden = grades::list_overrides(state.db.reader(), key).await?.pop().and_then(OverrideView::of);
    let (uncounted, proof) = (session.uncounted, proofs::find_proof(state.db.reader(), key).await?);
    Ok(Json(GradedDocument { computed, overridden, uncounted, proof }).into_response())
}
