//! Making a task: attempts, a cohort, a date.

use axum::extract::{Query, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Redirect, Response};
use serde::Deserialize;

use crate::AppState;
use crate::error::PageError;
use crate::routes::auth::{Csrf, CsrfForm, Teacher, Visit};
use acts::error::Error;
use acts::segments;
use model::ids::{CohortId, SessionId};
use model::{CurrentPerson, Moment, due, line};
use pages::people::SelectOption;
use pages::segments::{NewTaskPage, attempt_label};
use pages::{NavPlace, Shell};
use store::reports::{self, ListedAttempt};
use store::segments::NewTask;
use store::{schools, scores, sessions};

/// Most traces of a task.
const MOST_TRACES: usize = 20;

#[derive(Deserialize)]
pub(super) struct NewTaskQuery {
    /// An attempt to begin with.
    session: Option<String>,
}

pub(super) async fn show_new_task(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
    Query(from): Query<NewTaskQuery>,
) -> Result<NewTaskPage, PageError> {
    let form = NewTaskForm(from.session.map(|id| ("attempt".to_owned(), id)).into_iter().collect());
    Ok(make_new_task_page(&state, Visit::new(&person, &csrf), &form, None).await?)
}

/// The form as it was sent; attempts come several times.
#[derive(Deserialize)]
#[serde(transparent)]
pub(super) struct NewTaskForm(Vec<(String, String)>);

impl NewTaskForm {
    fn field(&self, name: &str) -> &str {
        self.0.iter().find(|(key, _)| key == name).map_or("", |(_, value)| value.trim())
    }

    fn attempts(&self) -> Vec<&str> {
        let mut chosen: Vec<&str> = Vec::new();
        for (_, value) in self.0.iter().filter(|(key, _)| key == "attempt") {
            if !chosen.contains(&value.as_str()) {
                chosen.push(value);
            }
        }
        chosen
    }
}

async fn make_new_task_page(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    form: &NewTaskForm,
    refused: Option<String>,
) -> Result<NewTaskPage, Error> {
    let reader = state.db.reader();
    let cohorts = reports::cohorts(reader, person).await?;
    let cohort = |cohort: reports::NamedItem<CohortId>| {
        let value = cohort.id.to_string();
        SelectOption { chosen: value == form.field("cohort"), value, label: cohort.name }
    };
    Ok(NewTaskPage {
        shell: Shell::new(person, csrf.token(), NavPlace::Assignments),
        title: form.field("title").to_owned(),
        due: form.field("due").to_owned(),
        time_zone: schools::find_time_zone(reader, person.school_id).await?,
        cohorts: cohorts.into_iter().map(cohort).collect(),
        attempts: offered_attempts(state, person, form).await?,
        refused,
    })
}

/// The attempt that was asked for, then the latest that the visitor may see and that were scored.
async fn offered_attempts(
    state: &AppState,
    person: &CurrentPerson,
    form: &NewTaskForm,
) -> Result<Vec<SelectOption>, Error> {
    let chosen = form.attempts();
    let choice = |listed: ListedAttempt| {
        let value = listed.id.to_string();
        let label = attempt_label(&listed.trainee, &listed.exercise, listed.started_at.to_utc());
        SelectOption { chosen: chosen.contains(&value.as_str()), value, label }
    };
    let latest = reports::latest_taught(state.db.reader(), person).await?;
    let scored = latest.into_iter().filter(|listed| listed.score.is_some());
    let mut choices: Vec<SelectOption> = scored.map(choice).collect();
    for id in chosen.iter().filter(|id| !choices.iter().any(|choice| choice.value == **id)).copied().collect::<Vec<_>>()
    {
        let Ok(session) = id.parse() else { continue };
        if let Some(session) = sessions::find_visible_session(state.db.reader(), person, session).await? {
            let trainee = reports::trainee(state.db.reader(), person, session.trainee_id).await?;
            let name = trainee.map_or_else(String::new, |trainee| trainee.name);
            let label = attempt_label(&name, &session.exercise_id, session.started_at.to_utc());
            choices.insert(0, SelectOption { value: id.to_owned(), label, chosen: true });
        }
    }
    Ok(choices)
}

pub(super) async fn make_task(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<NewTaskForm>,
) -> Result<Response, PageError> {
    match read_new_task(&state, &person, &form).await {
        Ok(new) => {
            let id = segments::make(&state, &person, &new).await?;
            Ok(Redirect::to(&format!("/segments/{id}")).into_response())
        }
        Err(Error::Unprocessable(why)) => {
            let page = make_new_task_page(&state, Visit::new(&person, &csrf), &form, Some(why)).await?;
            Ok((StatusCode::UNPROCESSABLE_ENTITY, page).into_response())
        }
        Err(other) => Err(other.into()),
    }
}

/// What the form asks for. A cohort or an attempt that the visitor may not see is none: 404.
async fn read_new_task(state: &AppState, person: &CurrentPerson, form: &NewTaskForm) -> Result<NewTask, Error> {
    let reader = state.db.reader();
    let title = line::title(form.field("title")).map_err(Error::Unprocessable)?.to_owned();
    let time_zone = schools::find_time_zone(reader, person.school_id).await?;
    let due = read_due_date(form.field("due"), &time_zone, state.clock.now())?;
    let cohort: CohortId = form.field("cohort").parse().map_err(|_| Error::NotFound)?;
    reports::cohort(reader, person, cohort).await?.ok_or(Error::NotFound)?;
    let sessions = read_attempts(state, person, form).await?;
    Ok(NewTask { title, cohort_id: cohort, due, time_zone, sessions })
}

fn read_due_date(said: &str, time_zone: &str, now: Moment) -> Result<Option<(String, Moment)>, Error> {
    if said.is_empty() {
        return Ok(None);
    }
    let due = due::read(said, time_zone).map_err(|refused| Error::Unprocessable(refused.to_string()))?;
    if due.at < now {
        return Err(Error::Unprocessable(tr!("the due date is over already").to_owned()));
    }
    Ok(Some((due.local, due.at)))
}

async fn read_attempts(state: &AppState, person: &CurrentPerson, form: &NewTaskForm) -> Result<Vec<SessionId>, Error> {
    let chosen = form.attempts();
    if !(1..=MOST_TRACES).contains(&chosen.len()) {
        return Err(Error::Unprocessable(tr!(
            "attempts: {count}; allowed: 1 to {most}",
            count = chosen.len(),
            most = MOST_TRACES
        )));
    }
    let mut attempts = Vec::new();
    for id in chosen {
        let id: SessionId = id.parse().map_err(|_| Error::NotFound)?;
        let session = sessions::find_visible_session(state.db.reader(), person, id).await?.ok_or(Error::NotFound)?;
        scores::find_curve(state.db.reader(), session.key()).await?.ok_or(Error::NotFound)?;
        attempts.push(id);
    }
    Ok(attempts)
}
