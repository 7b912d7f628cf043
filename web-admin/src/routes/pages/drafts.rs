//! `/drafts`: documents being written.

use acts::drafting;
use acts::drafting::{Checked, SaveOutcome};
use acts::error::Error;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::http::header::RETRY_AFTER;
use axum::response::{IntoResponse, Redirect, Response};
use model::draft::DraftVerdict;
use model::ids::DraftId;
use pages::diff::compare_lines;
use pages::draft::{
    DraftPage, DraftRow, DraftsPage, VerdictPart, verdict_of_course, verdict_of_refused, verdict_while_waiting,
};
use pages::{NavPlace, Shell};
use serde::Deserialize;
use store::drafts::{DocumentDraft, DraftKind, Texts};
use store::{drafts, exercises};

use super::{PathId, unix_lines};
use crate::AppState;
use crate::error::PageError;
use crate::routes::auth::{Csrf, CsrfForm, NoFields, Teacher};
use crate::routes::forms::FormAnswer;

/// A copy to be begun.
#[derive(Debug, Deserialize)]
pub(super) struct CopyForm {
    /// Id of the exercise that is copied.
    exercise: String,
    /// Id of the copy.
    id: String,
}

/// What was written.
#[derive(Debug, Deserialize)]
pub(super) struct DraftForm {
    /// The version that was seen.
    seen: i64,
    document: String,
    #[serde(default)]
    scene: String,
    act: DraftAct,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum DraftAct {
    Save,
    Publish,
    /// Publish what an author should change, too.
    Insist,
}

/// What is being typed.
#[derive(Debug, Deserialize)]
pub(super) struct TypedForm {
    document: String,
    #[serde(default)]
    scene: String,
}

/// A draft in the version that was seen.
#[derive(Debug, Deserialize)]
pub(super) struct SeenForm {
    seen: i64,
}

pub(super) async fn list_drafts(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
) -> Result<DraftsPage, PageError> {
    let (reader, school) = (state.db.reader(), person.school_id);
    let exercises = exercises::list_current_exercises(reader, school).await?;
    Ok(DraftsPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Curricula),
        drafts: drafts::list_drafts(reader, school).await?.iter().map(make_draft_row).collect(),
        exercises: exercises.into_iter().map(|exercise| (exercise.exercise_id, exercise.title)).collect(),
    })
}

/// Begins a copy of an exercise.
pub(super) async fn copy_draft(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    CsrfForm(CopyForm { exercise, id }): CsrfForm<CopyForm>,
) -> Result<Redirect, PageError> {
    let draft = drafting::exercise(&state, &person, &exercise, Some(id.trim())).await?;
    Ok(Redirect::to(&format!("/drafts/{draft}")))
}

/// Opens the draft of an exercise.
pub(super) async fn draft_exercise(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    Path(id): Path<String>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    let draft = drafting::exercise(&state, &person, &id, None).await?;
    Ok(Redirect::to(&format!("/drafts/{draft}")))
}

/// Opens the draft of a course.
pub(super) async fn draft_course(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    Path(id): Path<String>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    let draft = drafting::course(&state, &person, &id).await?;
    Ok(Redirect::to(&format!("/drafts/{draft}")))
}

pub(super) async fn show_draft(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<DraftId>,
    csrf: Csrf,
) -> Result<Response, PageError> {
    let draft = drafts::find_draft(state.db.reader(), person.school_id, id).await?.ok_or(Error::NotFound)?;
    let checked = drafting::check(&state, person.school_id, &draft).await?;
    Ok(answer_with_draft(
        &checked,
        make_draft_page(Shell::new(&person, csrf.token(), NavPlace::Curricula), draft, &checked),
    ))
}

/// An answer that says when to ask again where nobody knows yet what the draft comes to.
fn answer_with_draft(checked: &Checked, body: impl IntoResponse) -> Response {
    match checked {
        Checked::Waiting(retry_after_s) => {
            (StatusCode::SERVICE_UNAVAILABLE, [(RETRY_AFTER, retry_after_s.to_string())], body).into_response()
        }
        _ => body.into_response(),
    }
}

/// Saves what was written, and publishes it when that is asked for and nothing is wrong; where there is advice, once its author has
/// seen it and insists.
pub(super) async fn write_draft(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<DraftId>,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<DraftForm>,
) -> Result<FormAnswer<DraftPage>, PageError> {
    let shell = Shell::new(&person, csrf.token(), NavPlace::Curricula);
    let texts = Texts { document: unix_lines(&form.document), scene: unix_lines(&form.scene) };
    let draft = match drafting::save(&state, &person, id, form.seen, &texts).await? {
        SaveOutcome::Kept(draft) => draft,
        SaveOutcome::Elsewhere(theirs) => {
            let page = answer_conflict(shell, theirs, texts);
            return Ok(FormAnswer::Answered((StatusCode::CONFLICT, page).into_response()));
        }
    };
    let checked = drafting::check(&state, person.school_id, &draft).await?;
    let is_held = match (form.act, &checked) {
        (DraftAct::Save, _) => {
            let page = make_draft_page(shell, draft, &checked);
            return Ok(FormAnswer::Answered(answer_with_draft(&checked, page)));
        }
        (_, Checked::Refused(_) | Checked::Waiting(_)) => true,
        (_, Checked::Exercise(verdict)) if !verdict.problems.is_empty() => true,
        (DraftAct::Publish, Checked::Exercise(verdict)) => !verdict.advice.is_empty(),
        (DraftAct::Publish | DraftAct::Insist, _) => false,
    };
    if is_held {
        let refused = DraftPage { refused: true, ..make_draft_page(shell, draft, &checked) };
        return Ok(match checked {
            Checked::Waiting(_) => FormAnswer::Answered(answer_with_draft(&checked, refused)),
            _ => FormAnswer::Refused(refused),
        });
    }
    match drafting::publish(&state, &person, &draft, &checked).await? {
        true => Ok(FormAnswer::lead_to(&published_moment(&draft))),
        false => Ok(FormAnswer::lead_to(&format!("/drafts/{id}"))),
    }
}

/// What a draft would come to as it is typed; nothing is saved.
pub(super) async fn preview_draft(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<DraftId>,
    CsrfForm(typed): CsrfForm<TypedForm>,
) -> Result<Response, PageError> {
    let draft = drafts::find_draft(state.db.reader(), person.school_id, id).await?.ok_or(Error::NotFound)?;
    let texts = Texts { document: unix_lines(&typed.document), scene: unix_lines(&typed.scene) };
    let checked = drafting::check(&state, person.school_id, &DocumentDraft { texts, ..draft }).await?;
    Ok(answer_with_draft(&checked, VerdictPart { verdict: verdict_of_draft(&checked) }))
}

/// Throws a draft away.
pub(super) async fn discard_draft(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<DraftId>,
    CsrfForm(SeenForm { seen }): CsrfForm<SeenForm>,
) -> Result<Redirect, PageError> {
    match drafting::discard(&state, &person, id, seen).await? {
        true => Ok(Redirect::to("/drafts")),
        false => {
            let why = tr!("somebody has saved this draft since you opened it; look at it before you throw it away");
            Err(Error::Conflict(why.to_owned()).into())
        }
    }
}

fn published_moment(draft: &DocumentDraft) -> String {
    match draft.kind {
        DraftKind::Exercise => format!("/exercises/{}/revisions", draft.document_id),
        DraftKind::Course => format!("/curricula/{}/revisions", draft.document_id),
    }
}

fn make_draft_row(draft: &DocumentDraft) -> DraftRow {
    DraftRow {
        href: format!("/drafts/{}", draft.id),
        kind: match draft.kind {
            DraftKind::Exercise => "exercise",
            DraftKind::Course => "course",
        },
        document_id: draft.document_id.clone(),
        saved_by: draft.saved_by.clone(),
        saved_at: draft.saved_at.to_utc(),
    }
}

fn verdict_of_draft(checked: &Checked) -> DraftVerdict {
    match checked {
        Checked::Exercise(verdict) => (**verdict).clone(),
        Checked::Course(course, mastery) => verdict_of_course(course, mastery),
        Checked::Refused(issues) => verdict_of_refused(issues),
        Checked::Waiting(retry_after_s) => verdict_while_waiting(*retry_after_s),
    }
}

fn make_draft_page(shell: Shell, draft: DocumentDraft, checked: &Checked) -> DraftPage {
    DraftPage {
        shell,
        draft: make_draft_row(&draft),
        scene: (draft.kind == DraftKind::Exercise).then_some(draft.texts.scene),
        document: draft.texts.document,
        seen: draft.version,
        conflict: None,
        refused: false,
        verdict: verdict_of_draft(checked),
    }
}

/// What was typed, kept, against what somebody else has saved.
fn answer_conflict(shell: Shell, theirs: DocumentDraft, typed: Texts) -> DraftPage {
    let mut lines = compare_lines(&theirs.texts.document, &typed.document);
    lines.extend(compare_lines(&theirs.texts.scene, &typed.scene));
    let page = make_draft_page(shell, DocumentDraft { texts: typed, ..theirs }, &Checked::Refused(Vec::new()));
    DraftPage { conflict: Some(lines), ..page }
}
