//! `/exercises/{id}/pictures/{number}`: the pictures of a briefing, for whoever may read it.

use acts::error::Error;
use axum::extract::{Path, Query, State};
use axum::http::header::{CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, ETAG, IF_NONE_MATCH};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use documents::picture::PictureKind;
use model::ids::SchoolId;
use pages::addresses::exercise_href;
use pages::pictures::{PictureAtHand, picture_address, picture_version};
use serde::Deserialize;
use store::exercises::Revision;
use store::pictures::{self, PictureBytes, StoredPicture};

use crate::AppState;
use crate::auth::Visitor;
use crate::error::PageError;

/// Under the address that holds its hash a picture never changes; under any other it is asked for again. It is the school's: no cache that
/// others share may keep it.
const FOREVER: &str = "private, max-age=31536000, immutable";
const ASK_AGAIN: &str = "private, no-cache";
/// A picture brings nothing with it, runs nothing and is nobody's page.
const NOTHING_ELSE: &str = "default-src 'none'; sandbox";

/// Which version of a picture is asked for.
#[derive(Debug, Default, Deserialize)]
pub struct PictureQuery {
    v: Option<String>,
}

/// Answers with a picture of an exercise's briefing.
///
/// # Errors
/// When there is no such picture.
pub async fn serve_exercise_picture(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    Path((id, number)): Path<(String, String)>,
    Query(asked): Query<PictureQuery>,
    headers: HeaderMap,
) -> Result<Response, PageError> {
    Ok(answer_picture(&find_picture(&state, person.school_id, &id, &number).await?, &asked, &headers)?)
}

/// A picture of the revision that trainees are given, by its number from 1. What is no number names nothing.
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

/// A picture as an answer, or 304 where the browser has it. Its type is that which was decoded.
pub fn answer_picture(picture: &PictureBytes, asked: &PictureQuery, headers: &HeaderMap) -> Result<Response, Error> {
    let tag = format!("\"{}\"", picture.sha256);
    let is_named = asked.v.as_deref() == Some(picture_version(&picture.sha256));
    let caching = if is_named { FOREVER } else { ASK_AGAIN };
    if headers.get(IF_NONE_MATCH).is_some_and(|known| known.as_bytes() == tag.as_bytes()) {
        return Ok((StatusCode::NOT_MODIFIED, [(ETAG, tag.as_str()), (CACHE_CONTROL, caching)]).into_response());
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

/// The pictures of a revision as its page shows them.
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

/// A picture at an address among those of a page.
pub fn place_picture(page: &str, place: &str, picture: StoredPicture) -> PictureAtHand {
    let src = picture_address(page, place, &picture.sha256);
    PictureAtHand { src, name: picture.name, size: [picture.width, picture.height] }
}
