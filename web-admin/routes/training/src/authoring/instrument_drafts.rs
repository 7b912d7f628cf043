//! Drafts of instruments: how they begin, their preview for respondents, and how a course comes to
//! include one.

use acts::authoring::drafting;
use acts::authoring::drafting::Checked;
use acts::error::Error;
use acts::surveys::list_titled_instruments;
use axum::extract::{Path, Query, State};
use axum::response::{IntoResponse, Redirect, Response};
use model::authoring::EditedDocument;
use model::ids::{DraftId, SchoolId};
use pages::form::SelectOption;
use pages::surveys::form::{FormPage, respond_in_language};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{CsrfForm, NoFields, Teacher};
use routes_base::error::PageError;
use serde::Deserialize;
use store::authoring::drafts;
use store::authoring::drafts::{DocumentDraft, DraftKind};
use store::surveys::instruments;

use super::drafts::CourseForm;

/// Language and page of the previewed questions.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct QuestionsQuery {
    lang: String,
    page: usize,
}

/// Returns the address of the preview of a draft's questions.
pub(super) fn questions_href(draft: DraftId, language: &str) -> String {
    format!("/drafts/{draft}/questions?lang={language}")
}

/// Returns the instruments of a school as options to copy, preceded by an empty one.
pub(super) async fn list_originals(
    state: &AppState,
    school: SchoolId,
    chosen: &str,
) -> Result<Vec<SelectOption>, Error> {
    let known = list_titled_instruments(state, school).await?;
    let none = SelectOption {
        value: String::new(),
        label: tr!("None: without questions").to_owned(),
        chosen: chosen.is_empty(),
    };
    let option = |known: instruments::InstrumentRevision| SelectOption {
        chosen: known.instrument_id == chosen,
        value: known.instrument_id,
        label: known.title,
    };
    Ok(std::iter::once(none).chain(known.into_iter().map(option)).collect())
}

/// Returns the languages in which the draft of an instrument can be previewed.
pub(super) fn list_seen_languages(draft: &DocumentDraft) -> Vec<String> {
    match draft.kind {
        DraftKind::Instrument => {
            EditedDocument::from_text(&draft.texts.document).map(|text| text.languages()).unwrap_or_default()
        }
        DraftKind::Exercise | DraftKind::Course => Vec::new(),
    }
}

/// Opens the draft of an instrument.
pub(super) async fn draft_instrument(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    Path(id): Path<String>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    let draft = drafting::open_instrument(&state, &person, &id).await?;
    Ok(Redirect::to(&format!("/drafts/{draft}")))
}

/// Opens the draft of a course, in which an instrument is chosen for its exercises.
pub(super) async fn ask_in_course(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    Path(id): Path<String>,
    CsrfForm(CourseForm { course }): CsrfForm<CourseForm>,
) -> Result<Redirect, PageError> {
    instruments::find_current_instrument(state.db.reader(), person.school_id, &id).await?.ok_or(Error::NotFound)?;
    let draft = drafting::open_course(&state, &person, &course).await?;
    Ok(Redirect::to(&format!("/drafts/{draft}#f-exercise")))
}

/// Shows the questions of a draft as respondents see them; redirects to the draft if it could not
/// be published.
pub(super) async fn show_questions(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<DraftId>,
    Query(asked): Query<QuestionsQuery>,
) -> Result<Response, PageError> {
    let draft = drafts::find_draft(state.db.reader(), person.school_id, id).await?.ok_or(Error::NotFound)?;
    let href = format!("/drafts/{id}");
    if draft.kind != DraftKind::Instrument {
        return Err(Error::NotFound.into());
    }
    match drafting::check(&state, person.school_id, &draft).await? {
        Checked::Instrument(instrument) => {
            let language = instrument.language_for(&asked.lang);
            Ok(respond_in_language(language, FormPage::of_draft(&instrument, &href, language, asked.page)))
        }
        _ => Ok(Redirect::to(&href).into_response()),
    }
}
