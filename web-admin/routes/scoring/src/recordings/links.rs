//! Recordings for external viewers: short-lived addresses, readable in ranges by pages of exactly
//! those viewers.

use acts::error::Error;
use acts::recordings;
use acts::recordings::links;
use acts::recordings::links::LINK_LIFETIME_S;
use axum::extract::{Path, Request, State};
use axum::http::{HeaderValue, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use model::ids::SessionId;
use pages::recordings::links::RecordingLinksPage;
use pages::{NavPlace, Shell};
use platform::secret;
use routes_base::AppState;
use routes_base::addresses::{PathId, encode_in_query, own_address};
use routes_base::auth::{CsrfForm, NoFields, PageHead, Visitor};
use routes_base::error::PageError;
use routes_base::recordings::stored_files::serve_stored;
use store::recordings::links::find_linked_session;
use store::recordings::sessions;

/// Viewers: name, origin, and the address that the recording's address is appended to.
const VIEWERS: [(&str, &str, &str); 3] = [
    ("Foxglove", "https://app.foxglove.dev", "https://app.foxglove.dev/~/view?ds=remote-file&ds.url="),
    (
        "Lichtblick",
        "https://lichtblick-suite.github.io",
        "https://lichtblick-suite.github.io/lichtblick/?ds=remote-file&ds.url=",
    ),
    ("Rerun", "https://app.rerun.io", "https://app.rerun.io/?url="),
];

/// Creates an address for the recording and renders the links to the viewers directly: with a
/// redirect it would have to be stored.
pub(crate) async fn make_link(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<SessionId>,
    head: PageHead,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<RecordingLinksPage, PageError> {
    let session = sessions::find_visible_session(state.db.reader(), &person, id).await?.ok_or(Error::NotFound)?;
    let token = links::make_recording_link(&state, &person, &session).await?;
    let recording = format!("{}/recordings/{token}/{id}.mcap", own_address(&state, &head.headers));
    let opened =
        |(name, _, address): (&'static str, _, &str)| (name, format!("{address}{}", encode_in_query(&recording)));
    Ok(RecordingLinksPage {
        shell: Shell::new(&person, head.csrf.token(), NavPlace::Elsewhere),
        session: id,
        viewers: VIEWERS.map(opened).to_vec(),
        recording,
        minutes: LINK_LIFETIME_S / 60,
    })
}

/// Serves the recording of a link, whole or as a byte range, also to the viewers' pages.
pub(crate) async fn open_link(
    State(state): State<AppState>,
    path: Result<Path<(String, String)>, axum::extract::rejection::PathRejection>,
    request: Request,
) -> Result<Response, PageError> {
    let origin = request.headers().get(header::ORIGIN).cloned();
    if request.method() == Method::OPTIONS {
        return Ok(share_with_viewers(StatusCode::NO_CONTENT.into_response(), origin.as_ref()));
    }
    let Path((token, _)) = path.map_err(|_| Error::NotFound)?;
    let found = find_linked_session(state.db.reader(), &secret::token_sha256(&token), state.clock.now()).await?;
    let session = found.ok_or(Error::NotFound)?;
    let mut response = serve_stored(recordings::find(&state, &session).await?, request).await?;
    response.headers_mut().insert(header::CONTENT_TYPE, HeaderValue::from_static("application/octet-stream"));
    Ok(share_with_viewers(response, origin.as_ref()))
}

/// Lets pages of the viewers read the response, and no other origin.
fn share_with_viewers(mut response: Response, origin: Option<&HeaderValue>) -> Response {
    let known = VIEWERS.iter().find(|(_, viewer, _)| origin.is_some_and(|origin| origin == viewer));
    let headers = response.headers_mut();
    headers.append(header::VARY, HeaderValue::from_static("origin"));
    if let Some((_, viewer, _)) = known {
        let texts = [
            (header::ACCESS_CONTROL_ALLOW_ORIGIN, *viewer),
            (header::ACCESS_CONTROL_ALLOW_METHODS, "GET, HEAD"),
            (header::ACCESS_CONTROL_ALLOW_HEADERS, "range"),
            (
                header::ACCESS_CONTROL_EXPOSE_HEADERS,
                "accept-ranges, content-length, content-range, etag, last-modified",
            ),
            (header::ACCESS_CONTROL_MAX_AGE, "600"),
        ];
        texts.into_iter().for_each(|(name, text)| {
            headers.insert(name, HeaderValue::from_static(text));
        });
    }
    response
}
