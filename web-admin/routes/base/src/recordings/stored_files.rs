//! Serves files, whole or as byte ranges, from the local disk or streamed from an object store.

use std::ops::Range;
use std::path::Path;

use acts::error::Error;
use axum::body::Body;
use axum::extract::Request;
use axum::http::{HeaderMap, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use platform::recording_store::{StoredFile, StoredObject};
use tower::ServiceExt;
use tower_http::services::ServeFile;

/// Serves a stored file, whole or as a byte range.
pub async fn serve_stored(file: StoredFile, request: Request) -> Result<Response, Error> {
    match file {
        StoredFile::Local(path) => Ok(serve_file(&path, request).await),
        StoredFile::Remote(object) => {
            let asked = asked_range(request.headers(), object.size);
            serve_object(&object, asked, request.method() == Method::HEAD).await
        }
    }
}

/// Serves a local file, whole or as a byte range; the file is open when this returns.
pub async fn serve_file(path: &Path, request: Request) -> Response {
    let Ok(found) = ServeFile::new(path).oneshot(request).await;
    found.into_response()
}

/// Streams an object, whole or as a byte range, without buffering it; sends only the headers for
/// HEAD.
async fn serve_object(object: &StoredObject, asked: AskedRange, head_only: bool) -> Result<Response, Error> {
    let size = object.size;
    let (status, range) = match asked {
        AskedRange::Whole => (StatusCode::OK, 0..size),
        AskedRange::Part(range) => (StatusCode::PARTIAL_CONTENT, range),
        AskedRange::Nowhere => {
            let told = [(header::CONTENT_RANGE, format!("bytes */{size}"))];
            return Ok((StatusCode::RANGE_NOT_SATISFIABLE, told).into_response());
        }
    };
    let body = match head_only {
        true => Body::empty(),
        false => Body::from_stream(object.read(range.clone()).await?),
    };
    let told =
        [(header::ACCEPT_RANGES, "bytes".to_owned()), (header::CONTENT_LENGTH, (range.end - range.start).to_string())];
    let mut response = (status, told, body).into_response();
    if status == StatusCode::PARTIAL_CONTENT {
        let place = format!("bytes {}-{}/{size}", range.start, range.end - 1);
        response.headers_mut().insert(header::CONTENT_RANGE, place.parse().map_err(anyhow::Error::from)?);
    }
    Ok(response)
}

/// The requested byte range.
#[derive(Debug, PartialEq, Eq)]
enum AskedRange {
    Whole,
    Part(Range<u64>),
    /// Not satisfiable, malformed, or several ranges, which are not supported.
    Nowhere,
}

/// Returns the byte range that a request asks for (RFC 9110, 14.2) in an object of `size` bytes.
fn asked_range(headers: &HeaderMap, size: u64) -> AskedRange {
    let Some(asked) = headers.get(header::RANGE) else { return AskedRange::Whole };
    let range = asked.to_str().ok().and_then(|asked| asked.trim().strip_prefix("bytes=")).and_then(|asked| {
        let (first, last) = asked.split_once('-')?;
        match (first.trim(), last.trim()) {
            ("", last) => Some(size.saturating_sub(last.parse().ok()?)..size),
            (first, "") => Some(first.parse().ok()?..size),
            (first, last) => Some(first.parse().ok()?..last.parse::<u64>().ok()?.saturating_add(1).min(size)),
        }
    });
    range.filter(|range| !range.is_empty()).map_or(AskedRange::Nowhere, AskedRange::Part)
}

#[cfg(test)]
mod tests {
    //! Fails when a viewer receives other bytes than requested.

    use axum::http::HeaderValue;

    use super::*;

    #[test]
    fn one_range_is_served_and_what_is_none_is_told() {
        let asked = |text| asked_range(&HeaderMap::from_iter([(header::RANGE, HeaderValue::from_static(text))]), 10);
        for (text, range) in [
            ("bytes=0-0", 0..1),
            ("bytes=2-5", 2..6),
            ("bytes=2-", 2..10),
            ("bytes=-3", 7..10),
            ("bytes=-30", 0..10),
            ("bytes=9-99", 9..10),
            ("bytes=0-18446744073709551615", 0..10),
        ] {
            assert_eq!(asked(text), AskedRange::Part(range), "{text}");
        }
        for nowhere in ["bytes=10-", "bytes=-0", "bytes=5-2", "bytes=0-1,3-4", "lines=0-1", "bytes=x-", "bytes=-", ""] {
            assert_eq!(asked(nowhere), AskedRange::Nowhere, "{nowhere}");
        }
        assert_eq!(asked_range(&HeaderMap::new(), 10), AskedRange::Whole);
    }
}
