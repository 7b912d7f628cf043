//! `/people/roster`: a list of people is sent, looked at, and confirmed.

use acts::error::Error;
use acts::roster_import;
use acts::roster_import::RosterPreview;
use axum::extract::{Query, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Redirect, Response};
use model::CurrentPerson;
use model::ids::{RosterId, SchoolId};
use model::roster::{RosterRequest, is_name};
use pages::form::{FilledForm, read_ticked_box};
use pages::roster::{RosterFilter, RosterForm, RosterPage, RosterPreviewPage};
use pages::{NavPlace, Shell};
use serde::Deserialize;
use store::cohorts;

use super::PathId;
use crate::AppState;
use crate::error::PageError;
use crate::routes::auth::{Administrator, Csrf, CsrfForm, CsrfUpload, SentFile, Visit};
use crate::routes::forms::{FormAnswer, split_refusal};

/// Largest file taken, in bytes.
pub(super) const MAX_BYTES: usize = 8_000_000;

pub(super) async fn show_new_roster(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
) -> Result<RosterPage, PageError> {
    Ok(make_roster_page(&state, Visit::new(&person, &csrf), FilledForm::default()).await?)
}

async fn make_roster_page(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    form: FilledForm<RosterForm>,
) -> Result<RosterPage, Error> {
    let cohorts = cohorts::list_cohorts(state.db.reader(), person.school_id).await?;
    Ok(RosterPage {
        shell: Shell::new(person, csrf.token(), NavPlace::People),
        form,
        cohorts: cohorts.into_iter().map(|cohort| cohort.name).collect(),
    })
}

pub(super) async fn send_roster(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    CsrfUpload { form, file }: CsrfUpload<RosterForm>,
) -> Result<FormAnswer<RosterPage>, PageError> {
    match split_refusal(keep_sent_roster(&state, &person, &form, &file).await)? {
        Ok(id) => Ok(FormAnswer::lead_to(&format!("/people/rosters/{id}"))),
        Err(why) => {
            let form = FilledForm::refused(form, why);
            Ok(FormAnswer::Refused(make_roster_page(&state, Visit::new(&person, &csrf), form).await?))
        }
    }
}

/// Keeps what was sent, to be looked at.
async fn keep_sent_roster(
    state: &AppState,
    person: &CurrentPerson,
    form: &RosterForm,
    file: &SentFile,
) -> Result<RosterId, Error> {
    let cohort = Some(form.cohort.clone()).filter(|cohort| !cohort.is_empty());
    if let Some(cohort) = cohort.as_ref().filter(|cohort| !is_name(cohort)) {
        return Err(Error::Unprocessable(tr!("“{cohort}” cannot be the name of a cohort", cohort = cohort)));
    }
    let wanted = RosterRequest { cohort, remove_missing: form.remove_missing };
    roster_import::keep(state, person, shorten_file_name(&file.name), &file.bytes, &wanted).await
}

/// What a file is called, as much of it as fits a heading.
fn shorten_file_name(name: &str) -> &str {
    let end = name.char_indices().nth(80).map_or(name.len(), |(end, _)| end);
    if name.is_empty() { "the roster" } else { &name[..end] }
}

/// Which lines are looked at.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct RosterLinesQuery {
    show: RosterFilter,
    page: usize,
}

pub(super) async fn show_roster(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    PathId(id): PathId<RosterId>,
    csrf: Csrf,
    Query(query): Query<RosterLinesQuery>,
) -> Result<RosterPreviewPage, PageError> {
    let shell = Shell::new(&person, csrf.token(), NavPlace::People);
    Ok(make_preview_page(&state, shell, person.school_id, id, query).await?)
}

async fn make_preview_page(
    state: &AppState,
    shell: Shell,
    school: SchoolId,
    id: RosterId,
    query: RosterLinesQuery,
) -> Result<RosterPreviewPage, Error> {
    let RosterPreview { file_name, ignored, difference, digest } = roster_import::preview(state, school, id).await?;
    let (lines, pages) = RosterPreviewPage::lines(&difference, query.show, query.page);
    Ok(RosterPreviewPage {
        shell,
        id,
        file_name,
        ignored,
        counts: difference.counts(),
        empty: difference.is_empty(),
        shown: query.show,
        lines,
        pages,
        leaving: difference.leaving,
        digest,
        stale: false,
    })
}

/// What is confirmed.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct ConfirmRosterForm {
    digest: String,
    #[serde(default, deserialize_with = "read_ticked_box")]
    invite: bool,
}

pub(super) async fn confirm_roster(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    PathId(id): PathId<RosterId>,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<ConfirmRosterForm>,
) -> Result<Response, PageError> {
    match roster_import::confirm(&state, &person, id, &form.digest, form.invite).await? {
        Some(difference) => {
            let [added, changed, ..] = difference.counts();
            Ok(Redirect::to(&format!("/people?added={added}&changed={changed}")).into_response())
        }
        None => {
            let shell = Shell::new(&person, csrf.token(), NavPlace::People);
            let page = make_preview_page(&state, shell, person.school_id, id, RosterLinesQuery::default()).await?;
            Ok((StatusCode::CONFLICT, RosterPreviewPage { stale: true, ..page }).into_response())
        }
    }
}
