//! The distribution of a cohort's latest attempts at an exercise.

use acts::error::Error;
use assessment::statistics::summary;
use axum::extract::{Path, State};
use axum::response::Response;
use futures::stream;
use model::ids::{CohortId, PersonId, SessionId};
use model::training::progress::ScoredAttempt;
use model::{CurrentPerson, Role};
use pages::training::addresses::exercise_href;
use pages::training::progress::{MetricSpreadRow, MetricsPage, ScoredRow, SpreadTheme};
use pages::{NavPlace, Shell, format, metric};
use routes_base::AppState;
use routes_base::auth::{Csrf, Visitor};
use routes_base::authoring::exercises::published_bundle;
use routes_base::error::PageError;
use routes_base::export::{CsvCell, stream_csv, trainee_cells};
use store::authoring::exercises;
use store::scoring::scores;
use store::scoring::scores::{FoundMetric, MetricOfMany};
use store::training::reports::NamedItem;
use store::training::{practice, reports};

use crate::training::{cohorts, standing};

/// The data of both the page and its file.
struct CohortMetrics {
    cohort: NamedItem<CohortId>,
    /// Title of the exercise.
    title: String,
    /// The latest attempt of each trainee.
    latest: Vec<(NamedItem<PersonId>, ScoredAttempt)>,
    metrics: Vec<MetricOfMany>,
}

async fn find_cohort_metrics(
    state: &AppState,
    person: &CurrentPerson,
    id: &str,
    exercise: &str,
) -> Result<CohortMetrics, Error> {
    let id: CohortId = id.parse().map_err(|_| Error::NotFound)?;
    let (reader, school) = (state.db.reader(), person.school_id);
    let cohort = reports::cohort(reader, person, id).await?.ok_or(Error::NotFound)?;
    let courses = standing::taught_courses(state, school).await?;
    let mut steps = courses.iter().flat_map(|taught| &taught.course.steps);
    let title = steps.find(|step| step.exercise == exercise).map(|step| step.title.clone()).ok_or(Error::NotFound)?;
    let mut practised = practice::of_cohort_at(reader, school, id, exercise).await?;
    let last = |trainee: NamedItem<PersonId>| Some((practised.remove(&trainee.id)?.pop()?, trainee));
    let members = reports::members(reader, school, id, Role::Trainee).await?;
    let latest: Vec<_> = members.into_iter().filter_map(last).map(|(attempt, trainee)| (trainee, attempt)).collect();
    let sessions: Vec<SessionId> = latest.iter().map(|(_, attempt)| attempt.session).collect();
    let metrics = scores::metrics_of_many(reader, school, &sessions).await?;
    Ok(CohortMetrics { cohort, title, latest, metrics })
}

pub(super) async fn show_cohort_metrics(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    Path((id, exercise)): Path<(String, String)>,
    csrf: Csrf,
) -> Result<MetricsPage, PageError> {
    let CohortMetrics { cohort, title, latest, metrics } = find_cohort_metrics(&state, &person, &id, &exercise).await?;
    let judged = metrics_of_rubric(&state, &person, &exercise).await?;
    let scores: Vec<f64> = latest.iter().map(|(_, attempt)| attempt.score).collect();
    Ok(MetricsPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Cohorts),
        cohort: (cohort.name.clone(), cohorts::cohort_href(&cohort)),
        scores: summary(&scores).ok(),
        themes: SpreadTheme::sort_metrics(
            metrics
                .iter()
                .filter(|metric| is_newest(metric, &metrics))
                .filter_map(|metric| Some((metric.id.clone(), distribution_of_metric(metric)?)))
                .collect(),
            &judged.iter().map(String::as_str).collect::<Vec<_>>(),
        ),
        scored: latest.iter().map(|(trainee, attempt)| make_scored_row(trainee, attempt, &title)).collect(),
        exercise: (title, exercise_href(&exercise)),
    })
}

/// Returns the metrics in the current rubric of the exercise.
async fn metrics_of_rubric(state: &AppState, person: &CurrentPerson, exercise: &str) -> Result<Vec<String>, Error> {
    let school = person.school_id;
    let current = exercises::find_current_revision(state.db.reader(), school, exercise).await?;
    let Some(current) = current else { return Ok(Vec::new()) };
    let bundle = published_bundle(state, school, current.id).await?;
    Ok(bundle.map_or_else(Vec::new, |bundle| bundle.exercise.rubric.into_iter().map(|line| line.metric).collect()))
}

/// If a metric was measured by several versions of its definition, the page shows the newest; the
/// file contains all.
fn is_newest(metric: &MetricOfMany, all: &[MetricOfMany]) -> bool {
    all.iter().all(|other| other.id != metric.id || other.version <= metric.version)
}

/// Returns the distribution of a metric; `None` if it applies to no attempt.
fn distribution_of_metric(metric: &MetricOfMany) -> Option<MetricSpreadRow> {
    let values: Vec<f64> = metric.found.iter().filter_map(FoundMetric::value).collect();
    let five = summary(&values).ok()?;
    Some(MetricSpreadRow { label: metric::label_of(&metric.id, &metric.label), unit: metric.unit.clone(), five })
}

pub(super) fn make_scored_row(trainee: &NamedItem<PersonId>, attempt: &ScoredAttempt, exercise: &str) -> ScoredRow {
    ScoredRow {
        name: trainee.name.clone(),
        exercise: exercise.to_owned(),
        href: format!("/sessions/{}", attempt.session),
        at: attempt.at,
        score: attempt.score,
        passed: attempt.passed,
    }
}

const NAMES: [&str; 12] = [
    "trainee",
    "session",
    "started_at",
    "score",
    "passed",
    "metric",
    "version",
    "value",
    "unit",
    "not_applicable",
    "trainee_id",
    "pseudonym",
];

/// Exports a row for each trainee and metric, streamed: for ten thousand trainees the file has a
/// hundred megabytes.
pub(super) async fn export_cohort_metrics(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    Path((id, exercise)): Path<(String, String)>,
) -> Result<Response, PageError> {
    let CohortMetrics { cohort, latest, metrics, .. } = find_cohort_metrics(&state, &person, &id, &exercise).await?;
    let pseudonyms = reports::pseudonyms(state.db.reader(), person.school_id, cohort.id).await?;
    let rows = latest.into_iter().enumerate().map(move |(place, (trainee, attempt))| {
        let own = |metric: &MetricOfMany| {
            let found = metric.found.iter().find(|found| found.0 == place)?;
            Some([metric_cells(&trainee, &attempt, metric, found), trainee_cells(trainee.id, &pseudonyms)].concat())
        };
        Ok(metrics.iter().filter_map(own).collect())
    });
    Ok(stream_csv(&format!("metrics-{exercise}"), &NAMES, stream::iter(rows))?)
}

fn metric_cells(
    trainee: &NamedItem<PersonId>,
    attempt: &ScoredAttempt,
    metric: &MetricOfMany,
    found: &FoundMetric,
) -> Vec<CsvCell> {
    vec![
        CsvCell::from(trainee.name.clone()),
        CsvCell::from(attempt.session.to_string()),
        CsvCell::from(format::format_machine_time(attempt.at)),
        CsvCell::Number(attempt.score),
        CsvCell::from(attempt.passed),
        CsvCell::from(metric.id.clone()),
        CsvCell::Number(f64::from(metric.version)),
        CsvCell::from(found.value()),
        CsvCell::from(metric.unit.clone()),
        found.absent().map_or(CsvCell::Empty, |absent| CsvCell::from(absent.words())),
    ]
}
