//! `/exercises/{id}/pictures/{number}`: the pictures of a briefing, for everyone who may read it.

use acts::error::Error;
use axum::extract::{Path, Query, State};
use axum::http::HeaderMap;
use axum::http::header::{CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, ETAG};
use axum::response::{IntoResponse, Response};
use documents::picture::PictureKind;
use model::ids::SchoolId;
use pages::authoring::pictures::{PictureAtHand, picture_address, picture_version};
use pages::training::addresses::exercise_href;
use serde::Deserialize;
use store::authoring::exercises::Revision;
use store::authoring::pictures;
use store::authoring::pictures::{PictureBytes, StoredPicture};

use crate::AppState;
use crate::auth::Visitor;
use crate::caching::answer_not_modified;
use crate::error::PageError;

/// A picture whose address contains its hash never changes; under any other address it is
/// revalidated. It belongs to a school, so shared caches must not store it.
const FOREVER: &str = "private, max-age=31536000, immutable";
const ASK_AGAIN: &str = "private, no-cache";
/// A picture loads nothing, runs nothing and cannot act as a page of the service.
const NOTHING_ELSE: &str = "default-src 'none'; sandbox";

/// The version in the address of a picture.
#[derive(Debug, Default, Deserialize)]
pub struct PictureQuery {
    v: Option<String>,
}

/// Serves a picture of an exercise's briefing.
///
/// # Errors
/// When the picture does not exist.
pub async fn serve_exercise_picture(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    Path((id, number)): Path<(String, String)>,
    Query(asked): Query<PictureQuery>,
    headers: HeaderMap,
) -> Result<Response, PageError> {
    Ok(answer_picture(&find_picture(&state, person.school_id, &id, &number).await?, &asked, &headers)?)
}

/// Returns a picture of the current revision, by its number from 1. A malformed number is answered
/// like an unknown one.
pub async fn find_picture(
    state: &AppState,
    school: SchoolId,
    exercise_id: &str,
    number: &str,
) -> Result<PictureBytes, Error> {
    let number: u8 = number.parse().map_err(|_| Error::NotFound)?;
    let position = i64::from(number) - 1;
    let found = pictures::read_current_picture(state.db.reader(), school, exercise_id, position).await?;
    found.ok_or(Error::NotFound)
}

/// Returns a picture as a response, or 304 if the browser has the current one. Its media type
/// follows from its file name, which matches the decoded format.
pub fn answer_picture(picture: &PictureBytes, asked: &PictureQuery, headers: &HeaderMap) -> Result<Response, Error> {
    let tag = format!("\"{}\"", picture.sha256);
    let is_named = asked.v.as_deref() == Some(picture_version(&picture.sha256));
    let caching = if is_named { FOREVER } else { ASK_AGAIN };
    if let Some(answer) = answer_not_modified(headers, &tag, caching) {
        return Ok(answer);
    }
    let kind = PictureKind::of_name(&picture.name)
        .ok_or_else(|| Error::Internal(anyhow::anyhow!("a picture is called {}", picture.name)))?;
    let headers = [
        (CONTENT_TYPE, kind.media_type()),
        (CONTENT_SECURITY_POLICY, NOTHING_ELSE),
        (ETAG, tag.as_str()),
        (CACHE_CONTROL, caching),
    ];
    Ok((headers, picture.bytes.clone()).into_response())
}

/// Returns the pictures of a revision as its page shows them.
pub async fn list_at_hand(
    state: &AppState,
    school: SchoolId,
    revision: &Revision,
) -> Result<Vec<PictureAtHand>, Error> {
    let stored = pictures::list_revision_pictures(state.db.reader(), school, revision.id).await?;
    let page = exercise_href(&revision.exercise_id);
    let numbered = stored.into_iter().zip(1_u32..);
    Ok(numbered.map(|(picture, number)| place_picture(&page, &number.to_string(), picture)).collect())
}

/// Returns a picture with its address below that of a page.
pub fn place_picture(page: &str, place: &str, picture: StoredPicture) -> PictureAtHand {
    let src = picture_address(page, place, &picture.sha256);
    PictureAtHand { src, name: picture.name, size: [picture.width, picture.height] }
}
