//! `/sessions/{id}/exam-files`: freezes an attempt for an exam board, and sends its exam files.

use acts::error::Error;
use acts::scoring::exam_files;
use acts::scoring::exam_files::{ExamWords, OpenedExamFile};
use axum::body::Body;
use axum::extract::{Path, State};
use axum::http::{HeaderValue, header};
use axum::response::{Redirect, Response};
use model::ids::{ExamFileId, SessionId};
use model::training::progress::Mastery;
use pages::training::trainee::{needed_in_words, rule_in_words};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{CsrfForm, NoFields, Teacher};
use routes_base::error::PageError;
use routes_base::export::attach_file;
use store::recordings::sessions;
use words::Language;

use crate::scoring::review::find_scored;

/// The manifest is in English, because programs read it.
const WORDS: ExamWords = ExamWords { rule: english_rule, needed: |needed| within_english(|| needed_in_words(needed)) };

fn english_rule(rule: &Mastery) -> String {
    within_english(|| rule_in_words(rule))
}

fn within_english<T>(words: impl FnOnce() -> T) -> T {
    words::within(Language::ENGLISH, words)
}

/// Freezes an attempt.
pub(crate) async fn freeze(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<SessionId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    let session = find_scored(&state, &person, id).await?;
    exam_files::freeze_attempt(&state, &person, &session, WORDS).await?;
    Ok(Redirect::to(&format!("/sessions/{id}#exam-files")))
}

/// Sends an exam file.
pub(crate) async fn download(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    Path((id, file)): Path<(String, String)>,
) -> Result<Response, PageError> {
    let id: SessionId = id.parse().map_err(|_| Error::NotFound)?;
    let file: ExamFileId = file.parse().map_err(|_| Error::NotFound)?;
    let session = sessions::find_visible_session(state.db.reader(), &person, id).await?.ok_or(Error::NotFound)?;
    let OpenedExamFile { bytes, chunks } = exam_files::open_exam_file(&state, &person, &session, file).await?;
    let mut response = attach_file("application/x-tar", &format!("exam-{file}.tar"), Body::from_stream(chunks));
    response.headers_mut().insert(header::CONTENT_LENGTH, HeaderValue::from(bytes));
    Ok(response)
}
