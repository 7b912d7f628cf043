//! `/sessions/{id}/supervision`: a teacher confirms that they supervised an attempt.

use acts::error::Error;
use acts::scoring::reviewing;
use axum::extract::State;
use axum::response::Redirect;
use model::ids::{AssignmentId, SessionId};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{CsrfForm, Teacher};
use routes_base::error::PageError;
use serde::Deserialize;

use crate::scoring::review::find_scored;

#[derive(Debug, Deserialize)]
pub(crate) struct SupervisionForm {
    #[serde(default)]
    confirm: String,
    /// The assignment from whose page the form was sent.
    assignment: Option<AssignmentId>,
}

/// Confirms the supervision, or withdraws the confirmation.
pub(crate) async fn confirm_supervision(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<SessionId>,
    CsrfForm(form): CsrfForm<SupervisionForm>,
) -> Result<Redirect, PageError> {
    let session = find_scored(&state, &person, id).await?;
    let was_there = match form.confirm.as_str() {
        "yes" => true,
        "no" => false,
        other => {
            return Err(Error::BadRequest(format!("confirm: \"{other}\"; allowed: yes, no")).into());
        }
    };
    reviewing::set_supervised(&state, &person, &session, was_there).await?;
    Ok(match form.assignment {
        Some(assignment) => Redirect::to(&format!("/assignments/{assignment}")),
        None => Redirect::to(&format!("/sessions/{id}/grade")),
    })
}
