//! `/exercises/{id}/regrade` and `/regradings/{id}`: grades every attempt at an exercise by another
//! rubric.

use acts::error::Error;
use acts::scoring::regrading::exercise as regrading;
use axum::extract::{Path, Query, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Redirect};
use model::Role;
use model::ids::{RegradingId, RevisionId, SessionId};
use model::scoring::regrading::RegradingState as Standing;
use pages::form::{FilledForm, SelectOption};
use pages::scoring::regrading as views;
use pages::scoring::regrading::{ChooseRubricPage, EarlierRegrading, RegradingFilter, RegradingPage};
use pages::training::addresses::exercise_href;
use pages::{NavPlace, Shell, format};
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, CsrfForm, NoFields, Teacher, Visit};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use routes_base::{AppState, Routes, get, post};
use serde::Deserialize;
use store::authoring::exercises;
use store::scoring::regradings;
use store::scoring::regradings::Regrading;

/// Attempts per page.
const PER_PAGE: u32 = 50;

pub(crate) fn regrading_routes() -> Routes {
    Routes::new()
        .route("/exercises/{id}/regrade", get(choose_rubric).merge(post(look_at_regrading)))
        .route("/regradings/{id}", get(show_regrading).merge(post(confirm_regrading)))
        .route("/regradings/{id}/forget", post(forget_regrading))
}

async fn choose_rubric(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    Path(id): Path<String>,
    csrf: Csrf,
) -> Result<ChooseRubricPage, PageError> {
    let reader = state.db.reader();
    let current = exercises::find_current_revision(reader, person.school_id, &id).await?.ok_or(Error::NotFound)?;
    let revisions = exercises::list_exercise_revisions(reader, person.school_id, &id).await?.into_iter();
    let earlier = regradings::of_exercise(reader, &person, &id).await?.into_iter();
    Ok(ChooseRubricPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Curricula),
        revisions: revisions.map(|revision| rubric_option(&revision, current.id)).collect(),
        exercise: (current.title, exercise_href(&id)),
        earlier: earlier.map(make_regrading_row).collect(),
        whole_school: person.role == Role::Administrator,
    })
}

fn rubric_option(revision: &exercises::Revision, current: RevisionId) -> SelectOption {
    let (date, hash) =
        (format::format_date_time(revision.published_at.to_utc()), format::shorten_hash(&revision.exercise_sha256));
    let chosen = revision.id == current;
    let label = match chosen {
        true => tr!("{date}, {hash}, current for trainees", date = date, hash = hash),
        false => format!("{date}, {hash}"),
    };
    SelectOption { value: revision.id.to_string(), label, chosen }
}

fn make_regrading_row(regrading: Regrading) -> EarlierRegrading {
    EarlierRegrading {
        href: regrading_href(regrading.id),
        at: regrading.made_at.to_utc(),
        by: regrading.by,
        state: regrading.state,
        reason: regrading.reason,
    }
}

fn regrading_href(regrading: RegradingId) -> String {
    format!("/regradings/{regrading}")
}

#[derive(Deserialize)]
struct LookForm {
    #[serde(default)]
    revision: String,
}

async fn look_at_regrading(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    Path(id): Path<String>,
    CsrfForm(form): CsrfForm<LookForm>,
) -> Result<Redirect, PageError> {
    let revision = form.revision.parse().map_err(|_| Error::NotFound)?;
    let id = regrading::look(&state, &person, &id, revision).await?;
    Ok(Redirect::to(&regrading_href(id)))
}

/// Filter of the listed attempts, and the attempt after which the page begins.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(default)]
struct RegradingLinesQuery {
    show: RegradingFilter,
    after: Option<SessionId>,
}

async fn show_regrading(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<RegradingId>,
    csrf: Csrf,
    Query(query): Query<RegradingLinesQuery>,
) -> Result<RegradingPage, PageError> {
    Ok(make_regrading_page(&state, Visit::new(&person, &csrf), id, query).await?)
}

async fn make_regrading_page(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    id: RegradingId,
    query: RegradingLinesQuery,
) -> Result<RegradingPage, Error> {
    let reader = state.db.reader();
    let regrading = regrading::find(state, person, id).await?;
    let exercise = exercises::find_current_revision(reader, person.school_id, &regrading.exercise_id)
        .await?
        .ok_or(Error::NotFound)?;
    let after = query.after.unwrap_or(SessionId::nil());
    let mut lines = regradings::lines(reader, &regrading, query.show.outcomes(), after, PER_PAGE + 1).await?;
    let more = lines.len() > PER_PAGE as usize;
    lines.truncate(PER_PAGE as usize);
    let hash = format::shorten_hash(&regrading.exercise_sha256).to_owned();
    Ok(RegradingPage {
        shell: Shell::new(person, csrf.token(), NavPlace::Curricula),
        id,
        exercise: (exercise.title, exercise_href(&regrading.exercise_id)),
        revision: (regrading.published_at.to_utc(), hash),
        state: regrading.state,
        progress: progress_of_regrading(state, &regrading).await?,
        counts: regrading.counts.0,
        shown: query.show,
        next: lines.last().filter(|_| more).map(|line| line.session_id),
        further: query.after.is_some(),
        lines,
        digest: regrading.shown_sha256.unwrap_or_default(),
        own: regrading.made_by == person.id,
        stale: false,
        confirmation: FilledForm::default(),
        looked: (regrading.by, regrading.made_at.to_utc()),
        reason: regrading.reason,
        ended_at: regrading.ended_at.map(|at| at.to_utc()),
    })
}

/// Returns the completed and total work: attempts evaluated, or scores added.
async fn progress_of_regrading(state: &AppState, regrading: &Regrading) -> Result<(i64, i64), Error> {
    let reader = state.db.reader();
    match regrading.state {
        Standing::Looking => Ok(regradings::looked_at(reader, regrading.id).await?),
        Standing::Grading => {
            let graded = views::count_graded(&regrading.counts);
            Ok((graded - regradings::left(reader, regrading.id).await?, graded))
        }
        Standing::Shown | Standing::Done => Ok((0, 0)),
    }
}

/// Confirmation of a previewed re-grading, with its reason.
#[derive(Deserialize)]
struct ConfirmRegradingForm {
    #[serde(default)]
    digest: String,
    #[serde(default)]
    reason: String,
}

async fn confirm_regrading(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<RegradingId>,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<ConfirmRegradingForm>,
) -> Result<FormAnswer<RegradingPage>, PageError> {
    let again =
        async || make_regrading_page(&state, Visit::new(&person, &csrf), id, RegradingLinesQuery::default()).await;
    match split_refusal(regrading::confirm(&state, &person, id, &form.digest, &form.reason).await)? {
        Ok(true) => Ok(FormAnswer::lead_to(&regrading_href(id))),
        Ok(false) => {
            let page = RegradingPage { stale: true, ..again().await? };
            Ok(FormAnswer::Answered((StatusCode::CONFLICT, page).into_response()))
        }
        Err(why) => {
            let confirmation = FilledForm::refused(form.reason, why);
            Ok(FormAnswer::Refused(RegradingPage { confirmation, ..again().await? }))
        }
    }
}

async fn forget_regrading(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<RegradingId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    let exercise = regrading::forget(&state, &person, id).await?;
    Ok(Redirect::to(&format!("{}/regrade", exercise_href(&exercise))))
}
