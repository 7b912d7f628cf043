//! Comments on an attempt.

use acts::error::Error;
use acts::training::comments as said;
use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use model::ids::{CommentId, SessionId};
use model::training::comment::{Comment, TypedComment};
use routes_base::AppState;
use routes_base::error::{ApiError, ProblemDocument};
use serde::{Deserialize, Serialize};
use store::training::comments;
use store::training::comments::CommentRecord;
use utoipa::ToSchema;

use crate::caller::Caller;
use crate::recordings::sessions::find_session;
use crate::{ApiId, ApiJson};

/// Comments in the order of their moments, each followed by its answers in the order of their time.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct Comments {
    comments: Vec<CommentRecord>,
}

/// Lists the comments on an attempt.
#[utoipa::path(get, path = "/sessions/{id}/comments", tag = "comments", operation_id = "list_comments", params(("id" = Uuid, Path)),
    responses((status = 200, body = Comments), (status = 404, body = ProblemDocument)))]
pub(crate) async fn list_comments(
    State(state): State<AppState>,
    caller: Caller,
    ApiId(id): ApiId<SessionId>,
) -> Result<Json<Comments>, ApiError> {
    let session = find_session(&state, &caller, id).await?;
    Ok(Json(Comments { comments: comments::list_session_comments(state.db.reader(), session.key()).await? }))
}

/// A comment on a moment, or on an interval.
#[derive(Debug, Deserialize, ToSchema)]
pub(crate) struct NewComment {
    /// praise, error, question or teaching.
    kind: String,
    /// The moment, or the start of the interval, in s since the start of the attempt.
    from_s: f64,
    /// The end of the interval, in s.
    to_s: Option<f64>,
    /// Text of the comment.
    body: String,
}

/// The comment that was added.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct Added {
    #[schema(value_type = Uuid)]
    id: CommentId,
}

/// Adds a comment.
#[utoipa::path(post, path = "/sessions/{id}/comments", tag = "comments", operation_id = "add_comment", params(("id" = Uuid, Path)), request_body = NewComment,
    responses((status = 201, body = Added), (status = 404, body = ProblemDocument), (status = 422, body = ProblemDocument)))]
pub(crate) async fn add_comment(
    State(state): State<AppState>,
    caller: Caller,
    ApiId(id): ApiId<SessionId>,
    ApiJson(new): ApiJson<NewComment>,
) -> Result<(StatusCode, Json<Added>), ApiError> {
    let session = find_session(&state, &caller, id).await?;
    let to_s = new.to_s.map_or_else(String::new, |to_s| to_s.to_string());
    let typed = TypedComment { kind: new.kind, from_s: new.from_s.to_string(), to_s, body: new.body };
    let comment = Comment::parse(&typed, session.duration_s);
    let comment = comment.map_err(|refused| Error::Unprocessable(refused.to_string()))?;
    let id = said::add_comment(&state, caller.person()?, &session, &comment).await?;
    Ok((StatusCode::CREATED, Json(Added { id })))
}
