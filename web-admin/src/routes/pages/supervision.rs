//! `/sessions/{id}/supervision`: somebody who teaches says that they were there during an attempt.

use axum::extract::State;
use axum::response::Redirect;
use serde::Deserialize;
use uuid::Uuid;

use super::Id;
use super::review::find_scored;
use crate::AppState;
use crate::error::PageError;
use crate::routes::auth::{CsrfForm, Visitor};
use acts::error::Error;
use store::audit::Entry;
use store::supervisions;

#[derive(Debug, Deserialize)]
pub(super) struct SupervisionForm {
    #[serde(default)]
    confirm: String,
    /// The assignment from whose page it was sent.
    assignment: Option<Uuid>,
}

/// Confirms it, or takes that back.
pub(super) async fn confirm(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    Id(id): Id,
    CsrfForm(form): CsrfForm<SupervisionForm>,
) -> Result<Redirect, PageError> {
    let session = find_scored(&state, &person, id).await?;
    if session.trainee_id == person.id {
        return Err(Error::Forbidden(tr!("nobody confirms their own attempt")).into());
    }
    let (now, mut tx) = (state.clock.now(), state.db.write().await?);
    let (changed, action) = match form.confirm.as_str() {
        "yes" => (supervisions::confirm(&mut tx, &session, person.id, now).await?, "session.supervised"),
        "no" => (supervisions::withdraw(&mut tx, session.key()).await?, "session.supervision_withdrawn"),
        other => {
            return Err(Error::BadRequest(format!("confirm: \"{other}\"; allowed are yes and no")).into());
        }
    };
    if changed {
        Entry::by(&person, action, id).append(&mut tx, now).await?;
    }
    tx.commit().await.map_err(Error::from)?;
    Ok(match form.assignment {
        Some(assignment) => Redirect::to(&format!("/assignments/{assignment}")),
        None => Redirect::to(&format!("/sessions/{id}/grade")),
    })
}
