//! How a cohort's latest attempts at an exercise are distributed.

use assessment::Metric;
use assessment::statistics::summary;
use axum::extract::{Path, State};
use axum::response::Response;
use uuid::Uuid;

use super::cohort::{self, Found};
use crate::AppState;
use crate::domain::CurrentPerson;
use crate::domain::progress::Attempt;
use crate::error::{Error, PageError};
use crate::export::{self, Cell};
use crate::routes::auth::Csrf;
use crate::routes::pages::cohorts;
use crate::storage::reports::Named;
use crate::storage::scores;
use crate::views::progress::{LatestRow, MetricRow, MetricsPage};
use crate::views::trainee::exercise_href;
use crate::views::{Place, Shell, format, metric};

/// A trainee's latest attempt at an exercise, with its metrics.
struct Latest {
    trainee: Named,
    attempt: Attempt,
    metrics: Vec<Metric>,
}

/// Cohort, title of the exercise, and everybody's latest attempt at it.
async fn find(
    state: &AppState,
    person: &CurrentPerson,
    (id, exercise): (&str, &str),
) -> Result<(Named, String, Vec<Latest>), Error> {
    let id: Uuid = id.parse().map_err(|_| Error::NotFound)?;
    let Found { cohort, courses, trainees } = cohort::find(state, person, id).await?;
    let mut steps = courses.iter().flat_map(|taught| &taught.course.steps);
    let title = steps.find(|step| step.exercise == exercise).map(|step| step.title.clone()).ok_or(Error::NotFound)?;
    let mut last = Vec::new();
    for (trainee, attempts) in trainees {
        let at_it = attempts.into_iter().filter(|attempt| attempt.exercise == exercise);
        let Some(attempt) = at_it.max_by_key(|attempt| attempt.at) else { continue };
        let session: Uuid = attempt.session.parse().map_err(anyhow::Error::from)?;
        last.push((trainee, attempt, session));
    }
    let sessions: Vec<Uuid> = last.iter().map(|(.., session)| *session).collect();
    let mut metrics = scores::metrics_of_all(state.db.reader(), person.school_id, &sessions).await?;
    let latest = last.into_iter().map(|(trainee, attempt, session)| {
        let metrics = metrics.remove(&session).unwrap_or_default();
        Latest { trainee, attempt, metrics }
    });
    Ok((cohort, title, latest.collect()))
}

pub(super) async fn show(
    State(state): State<AppState>,
    person: CurrentPerson,
    Path((id, exercise)): Path<(String, String)>,
    csrf: Csrf,
) -> Result<MetricsPage, PageError> {
    let (cohort, title, latest) = find(&state, &person, (&id, &exercise)).await?;
    let scores: Vec<f64> = latest.iter().map(|l| l.attempt.score).collect();
    Ok(MetricsPage {
        shell: Shell::new(&person, csrf.token(), Place::Cohorts),
        cohort: (cohort.name.clone(), cohorts::href(&cohort)),
        exercise: (title, exercise_href(&exercise)),
        scores: summary(&scores).ok(),
        metrics: distributions(&latest),
        latest: latest.iter().map(latest_row).collect(),
    })
}

/// Every metric that applies to somebody, in the catalogue's order.
fn distributions(latest: &[Latest]) -> Vec<MetricRow> {
    let mut known: Vec<&Metric> = Vec::new();
    for metric in latest.iter().flat_map(|l| &l.metrics) {
        if !known.iter().any(|k| k.id == metric.id && k.version == metric.version) {
            known.push(metric);
        }
    }
    let row = |of: &Metric| {
        let same = latest.iter().flat_map(|l| &l.metrics).filter(|m| m.id == of.id && m.version == of.version);
        let values: Vec<f64> = same.filter_map(|m| m.value).collect();
        let five = summary(&values).ok()?;
        Some(MetricRow { label: metric::label_of(of), unit: of.unit.clone(), five })
    };
    known.into_iter().filter_map(row).collect()
}

fn latest_row(Latest { trainee, attempt, .. }: &Latest) -> LatestRow {
    LatestRow {
        name: trainee.name.clone(),
        href: format!("/sessions/{}", attempt.session),
        at: attempt.at,
        score: attempt.score,
        passed: attempt.passed,
    }
}

pub(super) async fn export(
    State(state): State<AppState>,
    person: CurrentPerson,
    Path((id, exercise)): Path<(String, String)>,
) -> Result<Response, PageError> {
    let (_, _, latest) = find(&state, &person, (&id, &exercise)).await?;
    let rows: Vec<Vec<Cell>> = latest.iter().flat_map(|l| l.metrics.iter().map(|m| cells(l, m))).collect();
    let names =
        ["trainee", "session", "started_at", "score", "passed", "metric", "version", "value", "unit", "not_applicable"];
    Ok(export::download(&format!("metrics-{exercise}"), &names, &rows)?)
}

fn cells(Latest { trainee, attempt, .. }: &Latest, metric: &Metric) -> Vec<Cell> {
    vec![
        Cell::from(trainee.name.clone()),
        Cell::from(attempt.session.clone()),
        Cell::from(format::machine_time(attempt.at)),
        Cell::Number(attempt.score),
        Cell::from(attempt.passed),
        Cell::from(metric.id.clone()),
        Cell::Number(f64::from(metric.version)),
        Cell::from(metric.value),
        Cell::from(metric.unit.clone()),
        Cell::from(metric.absent.clone()),
    ]
}
