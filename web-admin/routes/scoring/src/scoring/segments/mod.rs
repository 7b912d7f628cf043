//! `/segments`: tasks to mark pops, and their results.

use acts::error::Error;
use acts::scoring::segments;
use acts::training::deadlines;
use axum::extract::State;
use axum::response::{IntoResponse, Redirect, Response};
use model::ids::{PersonId, TaskId};
use model::scoring::segments::TraceOutcome;
use model::training::due;
use model::training::due::local;
use model::{CurrentPerson, Role};
use pages::scoring::segments::{OwnTaskPage, ResultRow, SegmentsPage, TaskPage, TaskRow};
use pages::{NavPlace, Shell};
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, CsrfForm, NoFields, Teacher, Visitor};
use routes_base::error::PageError;
use routes_base::export::{CsvCell, trainee_cells};
use routes_base::forms::ExtensionForm;
use routes_base::{AppState, Routes, export, get, post};
use store::scoring::segments as stored;
use store::scoring::segments::{SegmentTask, Trace};
use store::training::reports;
use store::training::reports::NamedItem;

mod make;
mod trace;

pub(crate) fn segment_routes() -> Routes {
    Routes::new()
        .route("/segments", get(list_tasks).merge(post(make::make_task)))
        .route("/segments/new", get(make::show_new_task))
        .route("/segments/{id}", get(show_task))
        .route("/segments/{id}/results.csv", get(export_task))
        .route("/segments/{id}/extend", post(extend_task))
        .route("/segments/{id}/withdraw", post(withdraw_task))
        .route("/segments/traces/{id}", get(trace::show_trace).merge(post(trace::mark_trace)))
}

async fn list_tasks(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    csrf: Csrf,
) -> Result<SegmentsPage, PageError> {
    let reader = state.db.reader();
    let teaches = person.role != Role::Trainee;
    let tasks = match teaches {
        true => stored::list_managed_tasks(reader, &person, None).await?,
        false => stored::list_trainee_tasks(reader, person.school_id, person.id).await?,
    };
    let shell = Shell::new(&person, csrf.token(), NavPlace::Assignments);
    Ok(SegmentsPage { shell, tasks: tasks.iter().map(|task| make_task_row(&state, task)).collect(), teaches })
}

fn make_task_row(state: &AppState, task: &SegmentTask) -> TaskRow {
    TaskRow {
        href: format!("/segments/{}", task.id),
        title: task.title.clone(),
        cohort: task.cohort.clone(),
        due: task.due_at.map(|at| local(at, &task.time_zone)),
        late: task.sent < task.traces && task.due_at.is_some_and(|due| due::is_past(due, state.clock.now())),
        extended_days: task.extended_days,
        traces: task.traces,
        sent: task.sent,
    }
}

fn trace_href(trace: &Trace) -> String {
    format!("/segments/traces/{}", trace.id)
}

/// Returns the traces that a person can mark, in order, each with whether its marks were submitted.
/// Trainees do not mark their own attempts.
async fn list_own_traces(state: &AppState, person: &CurrentPerson, task: TaskId) -> Result<Vec<(Trace, bool)>, Error> {
    let reader = state.db.reader();
    let marks = stored::find_marks(reader, person.school_id, task).await?;
    let sent = |trace: &Trace| {
        let own = marks.iter().find(|marks| marks.person_id == person.id && marks.trace_id == trace.id);
        own.is_some_and(|own| own.sent_at.is_some())
    };
    let traces = stored::list_traces(reader, person.school_id, task).await?;
    let shown = traces.into_iter().filter(|trace| person.role != Role::Trainee || trace.trainee_id != person.id);
    Ok(shown
        .map(|trace| {
            let sent = sent(&trace);
            (trace, sent)
        })
        .collect())
}

async fn show_task(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<TaskId>,
    csrf: Csrf,
) -> Result<Response, PageError> {
    let task = segments::task(&state, &person, id).await?;
    let shell = Shell::new(&person, csrf.token(), NavPlace::Assignments);
    if person.role == Role::Trainee {
        let outcomes = segments::outcomes(&state, person.school_id, &task, &[person.id]).await?;
        let traces = list_own_traces(&state, &person, id).await?;
        let traces = traces.iter().map(|(trace, sent)| (trace_href(trace), *sent)).collect();
        let outcome = outcomes.into_iter().next().unwrap_or_default();
        return Ok(OwnTaskPage { shell, task: make_task_row(&state, &task), traces, outcome }.into_response());
    }
    let mut traces = Vec::new();
    for trace in stored::list_traces(state.db.reader(), person.school_id, id).await? {
        let pops = segments::truth(&state, person.school_id, &trace).await?;
        traces.push((trace_href(&trace), format!("/sessions/{}/replay", trace.session_id), pops.len()));
    }
    let rows = results_of_task(&state, &person, &task).await?;
    Ok(TaskPage { shell, task: make_task_row(&state, &task), traces, rows }.into_response())
}

async fn trainees_of_task(
    state: &AppState,
    person: &CurrentPerson,
    task: &SegmentTask,
) -> Result<Vec<NamedItem<PersonId>>, Error> {
    Ok(reports::members(state.db.reader(), person.school_id, task.cohort_id, Role::Trainee).await?)
}

/// Returns the results of every trainee of the cohort, by name.
async fn results_of_task(
    state: &AppState,
    person: &CurrentPerson,
    task: &SegmentTask,
) -> Result<Vec<ResultRow>, Error> {
    let trainees = trainees_of_task(state, person, task).await?;
    let ids: Vec<PersonId> = trainees.iter().map(|trainee| trainee.id).collect();
    let outcomes = segments::outcomes(state, person.school_id, task, &ids).await?;
    let named = trainees.into_iter().zip(outcomes);
    let row = |(trainee, outcome): (NamedItem<PersonId>, TraceOutcome)| ResultRow {
        id: trainee.id,
        name: trainee.name,
        due: outcome.due_at.map(|at| local(at, &task.time_zone)),
        outcome,
    };
    Ok(named.map(row).collect())
}

async fn export_task(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<TaskId>,
) -> Result<Response, PageError> {
    let task = segments::task(&state, &person, id).await?;
    let pseudonyms = reports::pseudonyms(state.db.reader(), person.school_id, task.cohort_id).await?;
    let row = |row: ResultRow| {
        let identity = trainee_cells(row.id, &pseudonyms);
        [line_of_mark(row), identity].concat()
    };
    let rows: Vec<Vec<CsvCell>> = results_of_task(&state, &person, &task).await?.into_iter().map(row).collect();
    Ok(export::download_csv(&task.title, &COLUMNS, &rows).map_err(Error::from)?)
}

/// Columns of the table of results.
const COLUMNS: [&str; 12] = [
    "trainee",
    "traces",
    "sent",
    "late",
    "pops",
    "found",
    "missed",
    "false_marks",
    "mean_error_ms",
    "largest_error_ms",
    "trainee_id",
    "pseudonym",
];

fn line_of_mark(row: ResultRow) -> Vec<CsvCell> {
    let ResultRow { name, outcome, .. } = row;
    let count = |n: usize| CsvCell::Number(n as f64);
    let counted = |n: usize| if outcome.sent > 0 { count(n) } else { CsvCell::Empty };
    let verdict = &outcome.verdict;
    vec![
        CsvCell::from(name),
        count(outcome.traces),
        count(outcome.sent),
        CsvCell::from(outcome.late),
        counted(verdict.pops()),
        counted(verdict.hits.len()),
        counted(verdict.missed.len()),
        counted(verdict.false_marks.len()),
        CsvCell::from(verdict.mean_error_ms()),
        CsvCell::from(verdict.largest_error_ms()),
    ]
}

async fn extend_task(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<TaskId>,
    CsrfForm(form): CsrfForm<ExtensionForm>,
) -> Result<Redirect, PageError> {
    let task = segments::task(&state, &person, id).await?;
    if !trainees_of_task(&state, &person, &task).await?.iter().any(|trainee| trainee.id == form.person) {
        return Err(Error::NotFound.into());
    }
    deadlines::extend(&state, &person, segments::dated(&task), form.person, form.days).await?;
    Ok(Redirect::to(&format!("/segments/{id}")))
}

async fn withdraw_task(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<TaskId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Response, PageError> {
    segments::task(&state, &person, id).await?;
    segments::withdraw(&state, &person, id).await?;
    Ok(Redirect::to("/segments").into_response())
}
