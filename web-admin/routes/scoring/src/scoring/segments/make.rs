//! Creates tasks to mark pops: attempts, a cohort, a date.

use acts::error::Error;
use acts::scoring::segments;
use axum::extract::{Query, State};
use model::ids::{CohortId, SessionId};
use model::training::due;
use model::{CurrentPerson, Moment, single_line_text};
use pages::form::{FilledForm, SelectOption};
use pages::scoring::segments::{NewTaskForm, NewTaskPage, attempt_label};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::auth::{Csrf, CsrfForm, Teacher, Visit};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use serde::Deserialize;
use store::operations::schools;
use store::recordings::sessions;
use store::scoring::scores;
use store::scoring::segments::NewTask;
use store::training::reports;
use store::training::reports::ListedAttempt;

use crate::recordings::sessions::title_of_exercise;

/// Maximum number of traces in a task.
const MOST_TRACES: usize = 20;

#[derive(Deserialize)]
pub(super) struct NewTaskQuery {
    /// A preselected attempt.
    session: Option<String>,
}

pub(super) async fn show_new_task(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
    Query(from): Query<NewTaskQuery>,
) -> Result<NewTaskPage, PageError> {
    let form = NewTaskForm { attempts: from.session.into_iter().collect(), ..NewTaskForm::default() };
    Ok(make_new_task_page(&state, Visit::new(&person, &csrf), FilledForm::new(form)).await?)
}

/// Returns the distinct chosen attempts.
fn chosen_attempts(form: &NewTaskForm) -> Vec<&str> {
    let mut chosen: Vec<&str> = Vec::new();
    for attempt in &form.attempts {
        if !chosen.contains(&attempt.as_str()) {
            chosen.push(attempt);
        }
    }
    chosen
}

async fn make_new_task_page(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    form: FilledForm<NewTaskForm>,
) -> Result<NewTaskPage, Error> {
    let reader = state.db.reader();
    let cohorts = reports::cohorts(reader, person).await?;
    let cohort = |cohort: reports::NamedItem<CohortId>| {
        let value = cohort.id.to_string();
        SelectOption { chosen: value == form.typed.cohort, value, label: cohort.name }
    };
    Ok(NewTaskPage {
        shell: Shell::new(person, csrf.token(), NavPlace::Assignments),
        time_zone: schools::find_time_zone(reader, person.school_id).await?,
        cohorts: cohorts.into_iter().map(cohort).collect(),
        attempts: offered_attempts(state, person, &form.typed).await?,
        form,
    })
}

/// Returns the preselected attempt, followed by the latest scored attempts that the visitor may
/// see.
async fn offered_attempts(
    state: &AppState,
    person: &CurrentPerson,
    form: &NewTaskForm,
) -> Result<Vec<SelectOption>, Error> {
    let chosen = chosen_attempts(form);
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
            let exercise = title_of_exercise(state, &session).await?;
            let label = attempt_label(&name, &exercise, session.started_at.to_utc());
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
) -> Result<FormAnswer<NewTaskPage>, PageError> {
    match split_refusal(read_new_task(&state, &person, &form).await)? {
        Ok(new) => {
            let id = segments::make(&state, &person, &new).await?;
            Ok(FormAnswer::lead_to(&format!("/segments/{id}")))
        }
        Err(why) => {
            let form = FilledForm::refused(form, why);
            Ok(FormAnswer::Refused(make_new_task_page(&state, Visit::new(&person, &csrf), form).await?))
        }
    }
}

/// Parses the form. Cohorts and attempts that the visitor may not see are answered with 404.
async fn read_new_task(state: &AppState, person: &CurrentPerson, form: &NewTaskForm) -> Result<NewTask, Error> {
    let reader = state.db.reader();
    let title = single_line_text::title(&form.title).map_err(Error::Unprocessable)?.to_owned();
    let time_zone = schools::find_time_zone(reader, person.school_id).await?;
    let due = read_due_date(&form.due, &time_zone, state.clock.now())?;
    let cohort: CohortId = form.cohort.parse().map_err(|_| Error::NotFound)?;
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
        return Err(Error::Unprocessable(tr!("the due date is in the past").to_owned()));
    }
    Ok(Some((due.local, due.at)))
}

async fn read_attempts(state: &AppState, person: &CurrentPerson, form: &NewTaskForm) -> Result<Vec<SessionId>, Error> {
    let chosen = chosen_attempts(form);
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
