//! The style sheets, scripts and pictures.

use acts::error::Error;
use axum::extract::{Path, RawQuery};
use axum::http::HeaderMap;
use axum::http::header::{CACHE_CONTROL, CONTENT_TYPE, ETAG};
use axum::response::{IntoResponse, Response};
use pages::assets;
use routes_base::caching::answer_not_modified;
use routes_base::error::PageError;

/// An asset whose address contains its hash never changes; under any other address it is
/// revalidated.
const FOREVER: &str = "public, max-age=31536000, immutable";
const ASK_AGAIN: &str = "public, no-cache";

/// Returns an asset, or 304 if the browser has the current one.
pub(super) async fn serve_asset(
    Path(name): Path<String>,
    RawQuery(query): RawQuery,
    asked: HeaderMap,
) -> Result<Response, PageError> {
    let (file, hash) = assets::find_asset(&name).ok_or(PageError(Error::NotFound))?;
    let tag = format!("\"{hash}\"");
    let named = query.as_deref().and_then(|q| q.strip_prefix("v=")) == Some(hash.as_str());
    let caching = if named { FOREVER } else { ASK_AGAIN };
    if let Some(answer) = answer_not_modified(&asked, &tag, caching) {
        return Ok(answer);
    }
    let media_type = file.metadata.mimetype().to_owned();
    let headers = [(CONTENT_TYPE, media_type.as_str()), (ETAG, &tag), (CACHE_CONTROL, caching)];
    Ok((headers, file.data.into_owned()).into_response())
}
