//! `/drafts`: documents being edited.

use acts::authoring;
use acts::authoring::drafting::{Checked, SaveOutcome};
use acts::authoring::{NewDocument, SeenDraft, drafting};
use acts::error::Error;
use acts::surveys::list_titled_instruments;
use acts::training::course_changes;
use axum::extract::{Path, Query, State};
use axum::http::StatusCode;
use axum::http::header::RETRY_AFTER;
use axum::response::{IntoResponse, Redirect, Response};
use documents::metrics::SceneNames;
use model::CurrentPerson;
use model::authoring::EditedDocument;
use model::authoring::draft::{CourseChange, DraftVerdict};
use model::ids::{DraftId, SchoolId};
use pages::authoring::diff::compare_lines;
use pages::authoring::document_forms::{
    CourseContext, CourseExercise, DocumentForm, ExerciseContext, make_course_form, make_exercise_form,
    make_instrument_form, place_id,
};
use pages::authoring::draft::{
    DraftPage, DraftRow, DraftsPage, NewDraftForm, NewDraftKind, VerdictPart, verdict_of_course, verdict_of_refused,
    verdict_while_waiting,
};
use pages::form::{FilledForm, SelectOption};
use pages::surveys::instrument::verdict_of_instrument;
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, CsrfForm, NoFields, Teacher};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use serde::Deserialize;
use store::authoring::drafts::{DocumentDraft, DraftKind, Texts};
use store::authoring::{drafts, exercises};

use super::draft_pictures;
use super::instrument_drafts::{list_originals, list_seen_languages, questions_href};
use super::writing::{DraftAct, DraftView, SentDraft, ShownFor};

/// The course to which an exercise is added, or in which an instrument is asked.
#[derive(Debug, Deserialize)]
pub(super) struct CourseForm {
    pub(super) course: String,
}

/// The requested view of a draft.
#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct ViewQuery {
    #[serde(default)]
    view: DraftView,
}

/// The version of a draft that the visitor has seen.
#[derive(Debug, Deserialize)]
pub(super) struct SeenForm {
    seen: i64,
}

pub(super) async fn list_drafts(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
) -> Result<DraftsPage, PageError> {
    Ok(make_drafts_page(&state, &person, &csrf, FilledForm::default()).await?)
}

async fn make_drafts_page(
    state: &AppState,
    person: &CurrentPerson,
    csrf: &Csrf,
    form: FilledForm<NewDraftForm>,
) -> Result<DraftsPage, Error> {
    let (reader, school) = (state.db.reader(), person.school_id);
    Ok(DraftsPage {
        shell: Shell::new(person, csrf.token(), NavPlace::Curricula),
        drafts: drafts::list_drafts(reader, school).await?.iter().map(make_draft_row).collect(),
        exercises: list_exercise_options(state, school, &form.typed.exercise).await?,
        instruments: list_originals(state, school, &form.typed.instrument).await?,
        form,
    })
}

/// Returns the exercises of a school as options.
async fn list_exercise_options(state: &AppState, school: SchoolId, chosen: &str) -> Result<Vec<SelectOption>, Error> {
    let exercises = exercises::list_current_exercises(state.db.reader(), school).await?;
    let option = |exercise: exercises::Revision| SelectOption {
        chosen: exercise.exercise_id == chosen,
        value: exercise.exercise_id,
        label: exercise.title,
    };
    Ok(exercises.into_iter().map(option).collect())
}

/// Creates a draft as a copy of an exercise, a new course, or an instrument, new or copied.
pub(super) async fn begin_draft(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
    CsrfForm(typed): CsrfForm<NewDraftForm>,
) -> Result<FormAnswer<DraftsPage>, PageError> {
    let new = NewDocument { title: &typed.title, id: &typed.id };
    let begun = match typed.kind {
        NewDraftKind::Exercise => authoring::copy_exercise(&state, &person, &typed.exercise, new).await,
        NewDraftKind::Course => authoring::begin_course(&state, &person, new).await,
        NewDraftKind::Instrument => {
            let original = Some(typed.instrument.as_str()).filter(|id| !id.is_empty());
            authoring::begin_instrument(&state, &person, original, new).await
        }
    };
    match split_refusal(begun)? {
        Ok(draft) => Ok(FormAnswer::lead_to(&format!("/drafts/{draft}"))),
        Err(why) => {
            let form = FilledForm::refused(typed, why);
            Ok(FormAnswer::Refused(make_drafts_page(&state, &person, &csrf, form).await?))
        }
    }
}

/// Opens the draft of a course with an exercise added to it.
pub(super) async fn add_to_course(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    Path(id): Path<String>,
    CsrfForm(CourseForm { course }): CsrfForm<CourseForm>,
) -> Result<Redirect, PageError> {
    let added = authoring::add_to_course(&state, &person, &course, &id).await?;
    let place = place_id(&format!("exercise[{}]", added.row));
    Ok(Redirect::to(&format!("/drafts/{}#{place}", added.draft)))
}

/// Opens the draft of an exercise.
pub(super) async fn draft_exercise(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    Path(id): Path<String>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    let draft = drafting::open_exercise(&state, &person, &id).await?;
    Ok(Redirect::to(&format!("/drafts/{draft}")))
}

/// Opens the draft of a course.
pub(super) async fn draft_course(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    Path(id): Path<String>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    let draft = drafting::open_course(&state, &person, &id).await?;
    Ok(Redirect::to(&format!("/drafts/{draft}")))
}

pub(super) async fn show_draft(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<DraftId>,
    Query(asked): Query<ViewQuery>,
    csrf: Csrf,
) -> Result<Response, PageError> {
    let draft = drafts::find_draft(state.db.reader(), person.school_id, id).await?.ok_or(Error::NotFound)?;
    let checked = drafting::check(&state, person.school_id, &draft).await?;
    let shell = Shell::new(&person, csrf.token(), NavPlace::Curricula);
    let page =
        show_as(&state, asked.view.of(person.school_id), &draft.clone(), make_draft_page(shell, draft, &checked))
            .await?;
    Ok(answer_with_draft(&checked, page))
}

/// Returns the page of a draft as a form, if that view is requested and the text can be parsed;
/// else as text.
pub(super) async fn show_as(
    state: &AppState,
    ShownFor { school, view }: ShownFor,
    draft: &DocumentDraft,
    page: DraftPage,
) -> Result<DraftPage, Error> {
    if view == DraftView::Toml {
        return Ok(page);
    }
    let texts = Texts { document: page.document.clone(), scene: page.scene.clone().unwrap_or_default() };
    let scene = EditedDocument::from_text(&texts.scene).map(|scene| scene.written_at("title"));
    let form = make_form(state, school, &DocumentDraft { texts, ..draft.clone() }, &page.verdict).await?;
    let scenes = match (draft.kind, form.is_some()) {
        (DraftKind::Exercise, true) => list_exercise_options(state, school, "").await?,
        _ => Vec::new(),
    };
    Ok(DraftPage { unreadable: form.is_none(), form, scenes, scene_title: scene.unwrap_or_default(), ..page })
}

/// Returns a draft as a form; `None` if its text is not valid TOML.
async fn make_form(
    state: &AppState,
    school: SchoolId,
    draft: &DocumentDraft,
    verdict: &DraftVerdict,
) -> Result<Option<DocumentForm>, Error> {
    let Some(document) = EditedDocument::from_text(&draft.texts.document) else { return Ok(None) };
    let remarks = [verdict.problems.as_slice(), &verdict.advice].concat();
    Ok(Some(match draft.kind {
        DraftKind::Exercise => {
            let pictures = draft_pictures::list_at_hand(state, school, draft.id).await?;
            let context = ExerciseContext { scene: SceneNames::from_text(&draft.texts.scene), pictures };
            make_exercise_form(&document, &remarks, &context)
        }
        DraftKind::Course => {
            make_course_form(&document, &remarks, &find_course_context(state, school, &draft.document_id).await?)
        }
        DraftKind::Instrument => make_instrument_form(&document, &remarks),
    }))
}

/// Returns the exercises, instruments and files that a course can refer to.
async fn find_course_context(state: &AppState, school: SchoolId, course_id: &str) -> Result<CourseContext, Error> {
    let reader = state.db.reader();
    let exercises = exercises::list_current_exercises(reader, school).await?;
    let instruments = list_titled_instruments(state, school).await?;
    let named = |exercise: exercises::Revision| CourseExercise { id: exercise.exercise_id, title: exercise.title };
    Ok(CourseContext {
        exercises: exercises.into_iter().map(named).collect(),
        instruments: instruments.into_iter().map(|known| (known.instrument_id, known.title)).collect(),
        files: drafting::find_course_files(state, school, course_id).await?,
    })
}

/// Returns the response of a draft, with `Retry-After` while its check is still waiting.
fn answer_with_draft(checked: &Checked, body: impl IntoResponse) -> Response {
    match checked {
        Checked::Waiting(retry_after_s) => {
            (StatusCode::SERVICE_UNAVAILABLE, [(RETRY_AFTER, retry_after_s.to_string())], body).into_response()
        }
        _ => body.into_response(),
    }
}

/// Saves what was written, and publishes it when that is asked for and nothing is wrong; where there is advice, or people have begun the
/// course, once its author has seen it and insists.
pub(super) async fn write_draft(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<DraftId>,
    csrf: Csrf,
    CsrfForm(fields): CsrfForm<Vec<(String, String)>>,
) -> Result<FormAnswer<DraftPage>, PageError> {
    let sent = SentDraft::from_fields(fields)?;
    let shell = Shell::new(&person, csrf.token(), NavPlace::Curricula);
    let seen = SeenDraft { id, version: sent.seen };
    let saved = match &sent.act {
        DraftAct::TakeScene(exercise) => {
            authoring::take_scene(&state, &person, seen, &sent.texts.document, exercise).await?
        }
        _ => drafting::save_draft(&state, &person, id, sent.seen, &sent.texts).await?,
    };
    let draft = match saved {
        SaveOutcome::Kept(draft) => draft,
        SaveOutcome::Elsewhere(theirs) => {
            let draft = theirs.clone();
            let page =
                show_as(&state, sent.view.of(person.school_id), &draft, answer_conflict(shell, theirs, sent.texts))
                    .await?;
            return Ok(FormAnswer::Answered((StatusCode::CONFLICT, page).into_response()));
        }
    };
    if let DraftAct::Show(view) = sent.act {
        return Ok(FormAnswer::lead_to(&format!("/drafts/{id}{}", view.query())));
    }
    let changed = match &sent.act {
        DraftAct::Changed(place) => Some(place.as_str()),
        DraftAct::TakeScene(_) => Some("f-scene"),
        _ => None,
    };
    if let Some(place) = changed {
        return Ok(FormAnswer::lead_to(&format!("/drafts/{id}#{place}")));
    }
    let checked = drafting::check(&state, person.school_id, &draft).await?;
    if let (DraftAct::Look(language), Checked::Instrument(_)) = (&sent.act, &checked) {
        return Ok(FormAnswer::lead_to(&questions_href(id, language)));
    }
    let is_save = matches!(sent.act, DraftAct::Save | DraftAct::Look(_));
    let change = match (&sent.act, &checked) {
        (DraftAct::Publish, Checked::Course(course)) => {
            course_changes::find_course_change(&state, person.school_id, course).await?
        }
        _ => CourseChange::default(),
    };
    if is_save || !change.is_empty() || is_held(&sent.act, &checked) {
        let page =
            show_as(&state, sent.view.of(person.school_id), &draft.clone(), make_draft_page(shell, draft, &checked))
                .await?;
        return Ok(answer_held(&checked, DraftPage { refused: !is_save, saved: is_save, change, ..page }));
    }
    match drafting::publish(&state, &person, &draft, &checked).await? {
        true => Ok(FormAnswer::lead_to(&published_moment(&draft))),
        false => Ok(FormAnswer::lead_to(&format!("/drafts/{id}"))),
    }
}

/// Whether a draft is not published because of what it comes to.
fn is_held(act: &DraftAct, checked: &Checked) -> bool {
    match (act, checked) {
        (_, Checked::Refused(_) | Checked::Waiting(_)) => true,
        (_, Checked::Exercise(verdict)) if !verdict.problems.is_empty() => true,
        (DraftAct::Publish, Checked::Exercise(verdict)) => !verdict.advice.is_empty(),
        _ => false,
    }
}

/// The page of a draft that was saved and not published.
fn answer_held(checked: &Checked, page: DraftPage) -> FormAnswer<DraftPage> {
    match checked {
        Checked::Waiting(_) => FormAnswer::Answered(answer_with_draft(checked, page)),
        _ if page.saved => FormAnswer::Answered(page.into_response()),
        _ => FormAnswer::Refused(page),
    }
}

/// Previews a draft while it is being edited; nothing is saved.
pub(super) async fn preview_draft(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<DraftId>,
    CsrfForm(fields): CsrfForm<Vec<(String, String)>>,
) -> Result<Response, PageError> {
    let sent = SentDraft::from_fields(fields)?;
    let draft = drafts::find_draft(state.db.reader(), person.school_id, id).await?.ok_or(Error::NotFound)?;
    let draft = DocumentDraft { texts: sent.texts, ..draft };
    let checked = drafting::check(&state, person.school_id, &draft).await?;
    let verdict = verdict_of_draft(&checked);
    let form = match sent.view {
        DraftView::Form => make_form(&state, person.school_id, &draft, &verdict).await?,
        DraftView::Toml => None,
    };
    Ok(answer_with_draft(&checked, VerdictPart { verdict, form }))
}

/// Deletes a draft.
pub(super) async fn discard_draft(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<DraftId>,
    CsrfForm(SeenForm { seen }): CsrfForm<SeenForm>,
) -> Result<Redirect, PageError> {
    match drafting::discard(&state, &person, id, seen).await? {
        true => Ok(Redirect::to("/drafts")),
        false => {
            let why = tr!("another person has saved this draft since you opened it; look at it before you discard it");
            Err(Error::Conflict(why.to_owned()).into())
        }
    }
}

fn published_moment(draft: &DocumentDraft) -> String {
    match draft.kind {
        DraftKind::Exercise => format!("/exercises/{}?published=yes", draft.document_id),
        DraftKind::Course => format!("/curricula?published={}", draft.document_id),
        DraftKind::Instrument => format!("/surveys/instruments/{}?published=yes", draft.document_id),
    }
}

fn make_draft_row(draft: &DocumentDraft) -> DraftRow {
    DraftRow {
        href: format!("/drafts/{}", draft.id),
        kind: match draft.kind {
            DraftKind::Exercise => tr!("Exercise"),
            DraftKind::Course => tr!("Course"),
            DraftKind::Instrument => tr!("Questionnaire"),
        },
        title: EditedDocument::from_text(&draft.texts.document)
            .map(|text| text.title_in(words::current().code()))
            .unwrap_or_default(),
        document_id: draft.document_id.clone(),
        saved_by: draft.saved_by.clone(),
        saved_at: draft.saved_at.to_utc(),
    }
}

fn verdict_of_draft(checked: &Checked) -> DraftVerdict {
    match checked {
        Checked::Exercise(verdict) => (**verdict).clone(),
        Checked::Course(checked) => verdict_of_course(&checked.course, &checked.mastery, &checked.titles),
        Checked::Instrument(instrument) => verdict_of_instrument(instrument),
        Checked::Refused(issues) => verdict_of_refused(issues),
        Checked::Waiting(retry_after_s) => verdict_while_waiting(*retry_after_s),
    }
}

pub(super) fn make_draft_page(shell: Shell, draft: DocumentDraft, checked: &Checked) -> DraftPage {
    let is_instrument = draft.kind == DraftKind::Instrument;
    let place = if is_instrument { NavPlace::Surveys } else { NavPlace::Curricula };
    DraftPage {
        shell: Shell { place, ..shell },
        draft: make_draft_row(&draft),
        is_instrument,
        languages: list_seen_languages(&draft),
        scene: (draft.kind == DraftKind::Exercise).then_some(draft.texts.scene),
        document: draft.texts.document,
        seen: draft.version,
        conflict: None,
        refused: false,
        change: CourseChange::default(),
        verdict: verdict_of_draft(checked),
        form: None,
        scenes: Vec::new(),
        scene_title: String::new(),
        unreadable: false,
        saved: false,
        picture_refused: None,
    }
}

/// Returns the page that keeps the input and compares it with the version saved by another person.
pub(super) fn answer_conflict(shell: Shell, theirs: DocumentDraft, typed: Texts) -> DraftPage {
    let mut lines = compare_lines(&theirs.texts.document, &typed.document);
    lines.extend(compare_lines(&theirs.texts.scene, &typed.scene));
    let page = make_draft_page(shell, DocumentDraft { texts: typed, ..theirs }, &Checked::Refused(Vec::new()));
    DraftPage { conflict: Some(lines), ..page }
}
