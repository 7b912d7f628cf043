//! `/exams`: exams of a teacher's cohorts, and a trainee's own results.

mod exam;
mod make;
mod station;

use acts::error::Error;
use acts::scoring::exams;
use acts::surveys;
use axum::extract::State;
use axum::response::{IntoResponse, Redirect, Response};
use model::ids::{ExamId, SessionId};
use model::{CurrentPerson, PersonKey, Role};
use pages::form::FilledForm;
use pages::scoring::exams::{OwnExamsPage, OwnResult, SittingClock, list_answers, list_scores};
use pages::{NavPlace, Shell};
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, CsrfForm, NoFields, Teacher, Visit, Visitor};
use routes_base::error::PageError;
use routes_base::{AppState, Routes, get, post};
use store::scoring::exams as stored;

pub(crate) fn exam_routes() -> Routes {
    Routes::new()
        .route("/exams", get(list_exams).merge(post(make::make_exam)))
        .route("/exams/{id}", get(exam::show_exam))
        .route("/exams/{id}/exam.csv", get(exam::export_exam))
        .route("/exams/{id}/second-ratings", post(request_second_ratings))
        .route("/exams/{id}/close", post(close_exam))
        .route("/exams/{id}/candidates/{person}", get(station::show_station).merge(post(station::fill_in_form)))
        .route("/exams/{id}/candidates/{person}/begin", post(station::begin_sitting))
}

fn exam_href(id: ExamId) -> String {
    format!("/exams/{id}")
}

fn attempt_href(id: SessionId) -> String {
    format!("/sessions/{id}")
}

async fn list_exams(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    csrf: Csrf,
) -> Result<Response, PageError> {
    if person.role == Role::Trainee {
        let shell = Shell::new(&person, csrf.token(), NavPlace::Assignments);
        let results = list_own_results(&state, &person).await?;
        return Ok(OwnExamsPage { shell, results }.into_response());
    }
    Ok(make::make_list(&state, Visit::new(&person, &csrf), FilledForm::default()).await?.into_response())
}

/// Returns a trainee's results of closed exams.
async fn list_own_results(state: &AppState, person: &CurrentPerson) -> Result<Vec<OwnResult>, Error> {
    let own = PersonKey { school_id: person.school_id, person_id: person.id };
    let mut results = Vec::new();
    for sitting in stored::list_results(state.db.reader(), own).await? {
        let instrument = surveys::revision(state, person.school_id, sitting.revision_id).await?;
        let instrument = instrument.ok_or(Error::NotFound)?;
        results.push(OwnResult {
            clock: SittingClock::new(&sitting.times(), state.clock.now()),
            scores: list_scores(&instrument, &sitting.answers),
            answers: list_answers(&instrument, &sitting.answers),
            attempt: sitting.session_id.map(attempt_href),
            title: sitting.exam,
        });
    }
    Ok(results)
}

async fn request_second_ratings(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<ExamId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    let exam = exams::find(&state, &person, id).await?;
    exams::request_second_ratings(&state, &person, &exam).await?;
    Ok(Redirect::to(&exam_href(id)))
}

async fn close_exam(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<ExamId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    let exam = exams::find(&state, &person, id).await?;
    exams::close(&state, &person, &exam).await?;
    Ok(Redirect::to(&exam_href(id)))
}
