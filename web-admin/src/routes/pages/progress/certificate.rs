//! A certificate that a course was mastered.

use axum::extract::{Path, State};
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::response::{IntoResponse, Response};
use serde_json::json;
use uuid::Uuid;

use crate::AppState;
use crate::certificates::{self, Certificate, Statement};
use crate::domain::CurrentPerson;
use crate::domain::progress::{Course, Progress, StepState};
use crate::error::{Error, PageError};
use crate::routes::auth::{CsrfForm, NoFields};
use crate::storage::audit::Entry;
use crate::storage::curricula::{self, Curriculum};
use crate::storage::reports::{self, Named};
use crate::storage::{practice, schools};
use crate::views::{format, trainee::rule_in_words};

/// What a certificate does not say.
const SCOPE: &str = "Simulated performance only; no statement about competence with patients.";

/// Issues a certificate where the whole course is mastered.
pub(super) async fn issue(
    State(state): State<AppState>,
    person: CurrentPerson,
    Path((id, course)): Path<(String, String)>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Response, PageError> {
    let id: Uuid = id.parse().map_err(|_| Error::NotFound)?;
    let trainee = reports::trainee(state.db.reader(), &person, id).await?.ok_or(Error::NotFound)?;
    let taught = curricula::taught(state.db.reader(), person.school_id).await?;
    let curriculum = taught.into_iter().find(|c| c.curriculum_id == course).ok_or(Error::NotFound)?;
    let statement = statement(&state, &person, (&trainee, &curriculum)).await?;
    let certificate = certificates::sign(&state.config.data_dir, &statement)?;
    note(&state, &person, (&trainee, &curriculum)).await?;
    Ok(download(&certificate, &curriculum.curriculum_id)?)
}

async fn statement(
    state: &AppState,
    person: &CurrentPerson,
    (trainee, curriculum): (&Named, &Curriculum),
) -> Result<Statement, Error> {
    let (reader, school) = (state.db.reader(), person.school_id);
    let course = curricula::course(reader, school, curriculum).await?;
    let attempts = practice::of_trainee(reader, school, trainee.id).await?;
    let now = state.clock.now();
    let progress = Progress::of(&course, &attempts, now.to_utc());
    if !progress.complete() {
        return Err(Error::Conflict(
            tr!("a certificate is issued when every exercise of the course is mastered").to_owned(),
        ));
    }
    Ok(Statement {
        format: Statement::FORMAT,
        school: schools::name(reader, school).await?,
        trainee: trainee.name.clone(),
        curriculum_id: curriculum.curriculum_id.clone(),
        course: curriculum.title.clone(),
        curriculum_sha256: curriculum.sha256.clone(),
        rule: rule_in_words(&course.rule),
        exercises: exercises(&course, &progress),
        issued_at: now.to_string(),
        scope: SCOPE.to_owned(),
    })
}

fn exercises(course: &Course, progress: &Progress) -> Vec<(String, String)> {
    let mastered = course.steps.iter().zip(&progress.steps).filter_map(|(step, done)| match done.state {
        StepState::Mastered { on } => Some((step.title.clone(), format::machine_time(on))),
        _ => None,
    });
    mastered.collect()
}

async fn note(
    state: &AppState,
    person: &CurrentPerson,
    (trainee, curriculum): (&Named, &Curriculum),
) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    Entry::by(person, "certificate.issued", trainee.id)
        .with(json!({ "curriculum_id": curriculum.curriculum_id, "sha256": curriculum.sha256 }))
        .append(&mut tx, state.clock.now())
        .await?;
    Ok(tx.commit().await?)
}

fn download(certificate: &Certificate, course: &str) -> anyhow::Result<Response> {
    let body = serde_json::to_string_pretty(certificate)?;
    let disposition = format!("attachment; filename=\"certificate-{course}.json\"");
    Ok(([(CONTENT_TYPE, "application/json".to_owned()), (CONTENT_DISPOSITION, disposition)], body).into_response())
}
