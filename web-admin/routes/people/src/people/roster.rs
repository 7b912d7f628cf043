//! `/people/roster`: uploads a list of people, previews and confirms its import.

use acts::error::Error;
use acts::people::roster_import;
use acts::people::roster_import::{RosterColumnsLook, RosterPreview};
use axum::extract::{Query, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Redirect, Response};
use model::CurrentPerson;
use model::ids::{RosterId, SchoolId};
use model::people::email::is_domain;
use model::people::roster::{RosterDifference, RosterMapping, RosterRequest, is_name};
use model::single_line_text::tidy;
use pages::form::{FilledForm, read_ticked_box};
use pages::people::roster::{
    ColumnsRefused, RosterColumnsForm, RosterColumnsPage, RosterFilter, RosterForm, RosterPage, RosterPreviewPage,
};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Administrator, Csrf, CsrfForm, CsrfUpload, SentFile, Visit};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use serde::Deserialize;
use store::training::cohorts;

use crate::operations::settings::find_mail_way;

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

/// Stores the uploaded roster for its preview.
async fn keep_sent_roster(
    state: &AppState,
    person: &CurrentPerson,
    form: &RosterForm,
    file: &SentFile,
) -> Result<RosterId, Error> {
    let cohort = Some(tidy(&form.cohort)).filter(|cohort| !cohort.is_empty());
    if let Some(cohort) = cohort.as_ref().filter(|cohort| !is_name(cohort)) {
        return Err(Error::Unprocessable(tr!("“{cohort}” is not allowed as the name of a cohort", cohort = cohort)));
    }
    let wanted = RosterRequest { cohort, remove_missing: form.remove_missing, ..RosterRequest::default() };
    roster_import::keep(state, person, shorten_file_name(&file.name), &file.bytes, &wanted).await
}

/// Shortens a file name to fit a heading.
fn shorten_file_name(name: &str) -> &str {
    let end = name.char_indices().nth(80).map_or(name.len(), |(end, _)| end);
    if name.is_empty() { "the roster" } else { &name[..end] }
}

/// Filter and page of the previewed lines.
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
) -> Result<Response, PageError> {
    let shell = Shell::new(&person, csrf.token(), NavPlace::People);
    Ok(match make_preview_page(&state, shell, person.school_id, id, query).await? {
        Some(page) => page.into_response(),
        None => Redirect::to(&format!("/people/rosters/{id}/columns")).into_response(),
    })
}

async fn make_preview_page(
    state: &AppState,
    shell: Shell,
    school: SchoolId,
    id: RosterId,
    query: RosterLinesQuery,
) -> Result<Option<RosterPreviewPage>, Error> {
    let Some(preview) = roster_import::preview(state, school, id).await? else { return Ok(None) };
    let RosterPreview { file_name, headings, mapping, ignored, difference, digest, is_course } = preview;
    let (lines, pages) = RosterPreviewPage::lines(&difference, query.show, query.page);
    let mapped = mapping.columns.iter().filter_map(|(column, at)| Some((headings.get(*at)?.clone(), *column)));
    Ok(Some(RosterPreviewPage {
        shell,
        id,
        mail_way: find_mail_way(state),
        file_name,
        mapped: mapped.collect(),
        ignored,
        counts: difference.counts(),
        empty: difference.is_empty(),
        shown: query.show,
        lines,
        pages,
        leaving: difference.leaving,
        digest,
        stale: false,
        is_course,
    }))
}

/// Number of lines shown as a preview of the chosen columns.
const FIRST_LINES: usize = 6;

pub(super) async fn show_roster_columns(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    PathId(id): PathId<RosterId>,
    csrf: Csrf,
) -> Result<RosterColumnsPage, PageError> {
    let look = roster_import::look_at_columns(&state, person.school_id, id).await?;
    let form = FilledForm::new(RosterColumnsForm::of_mapping(&look.mapping));
    let shell = Shell::new(&person, csrf.token(), NavPlace::People);
    Ok(make_columns_page(shell, id, look, form))
}

fn make_columns_page(
    shell: Shell,
    id: RosterId,
    look: RosterColumnsLook,
    form: FilledForm<RosterColumnsForm, ColumnsRefused>,
) -> RosterColumnsPage {
    let RosterColumnsLook { file_name, table, doubts, .. } = look;
    let head = table.head(FIRST_LINES).people(&form.typed.mapping());
    let lines = RosterDifference::of(&head, &[], &RosterRequest::default()).lines;
    let column = |(index, heading): (usize, &String)| (heading.clone(), table.sample_of(index).map(str::to_owned));
    let columns = table.headings.iter().enumerate().map(column).collect();
    RosterColumnsPage { shell, id, file_name, columns, doubts, form, lines }
}

/// Checks the chosen columns, and returns the reason if they are refused.
fn refusal_of_mapping(mapping: &RosterMapping) -> Option<ColumnsRefused> {
    if !mapping.names() {
        return Some(ColumnsRefused::NoName);
    }
    if !mapping.addresses() {
        return Some(ColumnsRefused::NoEmail);
    }
    if !mapping.fits(usize::MAX) {
        return Some(ColumnsRefused::Twice);
    }
    mapping.domain.as_deref().is_some_and(|domain| !is_domain(domain)).then_some(ColumnsRefused::Domain)
}

pub(super) async fn assign_roster_columns(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    PathId(id): PathId<RosterId>,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<RosterColumnsForm>,
) -> Result<FormAnswer<RosterColumnsPage>, PageError> {
    let shell = Shell::new(&person, csrf.token(), NavPlace::People);
    let mapping = form.mapping();
    let look = roster_import::look_at_columns(&state, person.school_id, id).await?;
    if let Some(refused) = refusal_of_mapping(&mapping) {
        return Ok(FormAnswer::Refused(make_columns_page(shell, id, look, FilledForm::refused(form, refused))));
    }
    if !form.look.is_empty() {
        let page = make_columns_page(shell, id, look, FilledForm::new(form));
        return Ok(FormAnswer::Answered(page.into_response()));
    }
    roster_import::assign_columns(&state, &person, id, &mapping).await?;
    Ok(FormAnswer::lead_to(&format!("/people/rosters/{id}")))
}

/// Confirmation of a previewed import.
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
            Ok(match page {
                Some(page) => (StatusCode::CONFLICT, RosterPreviewPage { stale: true, ..page }).into_response(),
                None => Redirect::to(&format!("/people/rosters/{id}/columns")).into_response(),
            })
        }
    }
}
