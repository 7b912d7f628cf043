//! `/api/v1/uploads`: tus 1.0.0 with creation, creation-with-upload, checksum, expiration and
//! termination.
//!
//! <https://tus.io/protocols/resumable-upload>

use acts::error::Error;
use acts::recordings::checksum::Checksum;
use acts::recordings::uploads;
use acts::recordings::uploads::{Announced, UploadPiece};
use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::header::{CONTENT_LENGTH, CONTENT_TYPE, LOCATION};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode};
use axum::middleware::{Next, from_fn, from_fn_with_state};
use axum::response::{IntoResponse, Response};
use axum::routing::{options, post};
use data_encoding::BASE64;
use model::Moment;
use model::ids::UploadId;
use routes_base::error::{ApiError, ProblemDocument};
use routes_base::{AppState, Routes};
use store::recordings::uploads::Upload;
use time::format_description::BorrowedFormatItem;
use time::macros::format_description;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::ApiId;
use crate::caller::{Caller, require_caller};
use crate::recordings::cors;
use crate::recordings::upload::{read_clock_ahead, receive_recording};

const VERSION: &str = "1.0.0";
const EXTENSIONS: &str = "creation,creation-with-upload,checksum,expiration,termination";
/// Media type of a piece.
const PIECE: &str = "application/offset+octet-stream";
/// An HTTP date (RFC 9110, 5.6.7).
const HTTP_DATE: &[BorrowedFormatItem<'_>] =
    format_description!("[weekday repr:short], [day] [month repr:short] [year] [hour]:[minute]:[second] GMT");

const RESUMABLE: HeaderName = HeaderName::from_static("tus-resumable");
const SPOKEN: HeaderName = HeaderName::from_static("tus-version");
const OFFSET: HeaderName = HeaderName::from_static("upload-offset");
const LENGTH: HeaderName = HeaderName::from_static("upload-length");
const METADATA: HeaderName = HeaderName::from_static("upload-metadata");
const CONCAT: HeaderName = HeaderName::from_static("upload-concat");
const EXPIRES: HeaderName = HeaderName::from_static("upload-expires");
const CHECKSUM: HeaderName = HeaderName::from_static("upload-checksum");
const OVERRIDE: HeaderName = HeaderName::from_static("x-http-method-override");
/// Not part of tus: the attempt created from a complete upload. Without this header, no recording
/// has been acknowledged.
const SESSION: HeaderName = HeaderName::from_static("stylet-session");

/// Maximum size of `Upload-Metadata`, in bytes; it is stored with the upload.
const MOST_METADATA_BYTES: usize = 4096;

/// Returns the endpoints that require a token.
pub(crate) fn caller_endpoints() -> OpenApiRouter<AppState> {
    OpenApiRouter::default().routes(routes!(create_upload)).routes(routes!(show_upload, append_piece, terminate_upload))
}

/// Returns the public endpoints. The capabilities of the server are public, and clients query them
/// before they authenticate.
pub(crate) fn open_endpoints() -> OpenApiRouter<AppState> {
    OpenApiRouter::default().routes(routes!(describe_server))
}

/// Returns the routes of tus. Authentication precedes the check of the version.
pub(crate) fn upload_routes(state: &AppState) -> Routes {
    // Aliases under another method or path are described at the endpoint that they call.
    let with_token =
        Routes::described(caller_endpoints()).route("/uploads/{id}", post(override_method)).around(|routes| {
            routes.layer(from_fn(require_tus_version)).layer(from_fn_with_state(state.clone(), require_caller))
        });
    with_token.merge(Routes::described(open_endpoints())).route("/uploads/{id}", options(describe_server)).around(
        |routes| {
            routes.layer(from_fn(answer_with_version)).layer(from_fn_with_state(state.clone(), cors::share_with_origin))
        },
    )
}

/// Adds the version of tus to every response.
async fn answer_with_version(request: Request, next: Next) -> Response {
    let mut response = next.run(request).await;
    response.headers_mut().insert(RESUMABLE, HeaderValue::from_static(VERSION));
    // tus requires it with 412, which refuses another version.
    if response.status() == StatusCode::PRECONDITION_FAILED {
        response.headers_mut().insert(SPOKEN, HeaderValue::from_static(VERSION));
    }
    response
}

async fn require_tus_version(request: Request, next: Next) -> Result<Response, ApiError> {
    if request.headers().get(RESUMABLE).is_none_or(|version| version != VERSION) {
        return Err(Error::WrongVersion("Tus-Resumable: only 1.0.0 is supported").into());
    }
    Ok(next.run(request).await)
}

/// Describes the supported version, extensions and limits of tus.
#[utoipa::path(options, path = "/uploads", tag = "tus", operation_id = "describe_uploads", security(()),
    responses((status = 204, description = "Tus-Version, Tus-Extension, Tus-Max-Size, Tus-Checksum-Algorithm")))]
pub(crate) async fn describe_server(State(state): State<AppState>) -> impl IntoResponse {
    let headers = [
        ("tus-version", VERSION.to_owned()),
        ("tus-extension", EXTENSIONS.to_owned()),
        ("tus-max-size", state.config.max_upload_bytes.to_string()),
        ("tus-checksum-algorithm", Checksum::ALGORITHMS.to_owned()),
    ];
    (StatusCode::NO_CONTENT, headers)
}

/// Creates an upload, with its first piece if the request has a body.
#[utoipa::path(post, path = "/uploads", tag = "tus", operation_id = "begin_upload",
    params(("Tus-Resumable" = String, Header), ("Upload-Length" = u64, Header, description = "In bytes"),
           ("Upload-Metadata" = Option<String>, Header),
           ("Stylet-Clock" = Option<String>, Header, description = "The sender's time, RFC 3339, used to correct a wrong clock"),
           ("Upload-Checksum" = Option<String>, Header)),
    responses((status = 201, description = "Location, Upload-Expires"), (status = 400, body = ProblemDocument),
              (status = 401, body = ProblemDocument), (status = 412, body = ProblemDocument), (status = 413, body = ProblemDocument),
              (status = 415, body = ProblemDocument), (status = 422, body = ProblemDocument),
              (status = 429, body = ProblemDocument, description = "Too many unfinished uploads"), (status = 507, body = ProblemDocument)))]
pub(crate) async fn create_upload(
    State(state): State<AppState>,
    caller: Caller,
    headers: HeaderMap,
    body: Body,
) -> Result<Response, ApiError> {
    if headers.contains_key(CONCAT) {
        let why = format!("{CONCAT}: uploads cannot be concatenated here; allowed extensions are {EXTENSIONS}");
        return Err(Error::BadRequest(why).into());
    }
    let length = header_number(&headers, &LENGTH)?;
    match length {
        0 => return Err(Error::Unprocessable("Upload-Length: 0; a recording was expected".to_owned()).into()),
        length if length > state.config.max_upload_bytes => {
            return Err(Error::TooLarge { limit_bytes: state.config.max_upload_bytes }.into());
        }
        _ => {}
    }
    let (metadata, ahead_us) = (parse_metadata(&headers)?, read_clock_ahead(&headers, state.clock.now())?);
    let first = if headers.contains_key(CONTENT_TYPE) { Some(receive_piece(&headers, 0, body)?) } else { None };
    let mut upload = uploads::begin(&state, caller.owner(), Announced { length, metadata, ahead_us }).await?;
    let brings = first.is_some();
    if let Some(first) = first {
        upload = uploads::append(&state, caller.owner(), upload.id, first).await?;
    }
    let mut response = tell_offset(StatusCode::CREATED, &upload)?;
    if !brings {
        response.headers_mut().remove(OFFSET);
    }
    put_header(&mut response, LOCATION, &format!("/api/v1/uploads/{}", upload.id))?;
    Ok(response)
}

/// Returns the offset of an upload, and the session created from it. A request that is still
/// writing to it is interrupted.
#[utoipa::path(head, path = "/uploads/{id}", tag = "tus", operation_id = "show_upload", params(("id" = Uuid, Path), ("Tus-Resumable" = String, Header)),
    responses((status = 200, description = "Upload-Offset, Upload-Length, Upload-Metadata, Upload-Expires; \
                                            Stylet-Session once it is an attempt"),
              (status = 404), (status = 410), (status = 412)))]
pub(crate) async fn show_upload(
    State(state): State<AppState>,
    caller: Caller,
    ApiId(id): ApiId<UploadId>,
) -> Result<Response, ApiError> {
    let upload = uploads::find(&state, caller.owner(), id).await?;
    let mut response = tell_offset(StatusCode::OK, &upload)?;
    put_header(&mut response, LENGTH, &upload.length.to_string())?;
    if !upload.metadata.is_empty() {
        put_header(&mut response, METADATA, &upload.metadata)?;
    }
    Ok(response)
}

/// Appends a piece. The last one turns the upload into an attempt, exactly once, named by
/// `Stylet-Session`.
#[utoipa::path(patch, path = "/uploads/{id}", tag = "tus", operation_id = "append_upload", request_body(content_type = "application/offset+octet-stream"),
    params(("id" = Uuid, Path), ("Tus-Resumable" = String, Header),
           ("Upload-Offset" = u64, Header, description = "Offset of the chunk, in bytes"),
           ("Upload-Checksum" = Option<String>, Header, description = "sha256 or sha1, a space, the hash in base64")),
    responses((status = 204, description = "Upload-Offset, Upload-Expires; Stylet-Session once it is an attempt"),
              (status = 400, body = ProblemDocument), (status = 404, body = ProblemDocument),
              (status = 409, body = ProblemDocument, description = "A different offset, another request has taken over, or a different recording of this session"),
              (status = 410, body = ProblemDocument), (status = 412, body = ProblemDocument), (status = 413, body = ProblemDocument),
              (status = 415, body = ProblemDocument), (status = 422, body = ProblemDocument),
              (status = 423, body = ProblemDocument, description = "The upload is being accepted"),
              (status = 460, body = ProblemDocument, description = "The chunk does not match its checksum"),
              (status = 503, body = ProblemDocument, description = "The queue is full, the reader crashed, or the scanner or the store is unavailable; see Retry-After")))]
pub(crate) async fn append_piece(
    State(state): State<AppState>,
    caller: Caller,
    ApiId(id): ApiId<UploadId>,
    headers: HeaderMap,
    body: Body,
) -> Result<Response, ApiError> {
    let piece = receive_piece(&headers, header_number(&headers, &OFFSET)?, body)?;
    let upload = uploads::append(&state, caller.owner(), id, piece).await?;
    Ok(tell_offset(StatusCode::NO_CONTENT, &upload)?)
}

/// Terminates an upload. The attempt created from it remains.
#[utoipa::path(delete, path = "/uploads/{id}", tag = "tus", operation_id = "end_upload", params(("id" = Uuid, Path), ("Tus-Resumable" = String, Header)),
    responses((status = 204), (status = 404, body = ProblemDocument), (status = 410, body = ProblemDocument),
              (status = 412, body = ProblemDocument), (status = 423, body = ProblemDocument)))]
pub(crate) async fn terminate_upload(
    State(state): State<AppState>,
    caller: Caller,
    ApiId(id): ApiId<UploadId>,
) -> Result<StatusCode, ApiError> {
    let upload = uploads::find(&state, caller.owner(), id).await?;
    uploads::terminate(&state, &upload).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// Handles method overrides, for clients whose network allows only GET and POST.
async fn override_method(
    state: State<AppState>,
    caller: Caller,
    id: ApiId<UploadId>,
    headers: HeaderMap,
    body: Body,
) -> Result<Response, ApiError> {
    match header_text(&headers, &OVERRIDE) {
        Some("PATCH") => append_piece(state, caller, id, headers, body).await,
        Some("DELETE") => Ok(terminate_upload(state, caller, id).await?.into_response()),
        Some("HEAD") => show_upload(state, caller, id).await,
        _ => Err(Error::BadRequest("X-HTTP-Method-Override: HEAD, PATCH and DELETE are allowed".to_owned()).into()),
    }
}

/// Returns a piece as described by the headers.
fn receive_piece(headers: &HeaderMap, offset: u64, body: Body) -> Result<UploadPiece, Error> {
    if header_text(headers, &CONTENT_TYPE) != Some(PIECE) {
        return Err(Error::UnsupportedMedia("Content-Type: only application/offset+octet-stream is allowed"));
    }
    let checksum = match headers.get(CHECKSUM) {
        Some(header) => Some(Checksum::parse(header.to_str().unwrap_or_default())?),
        None => None,
    };
    let announced = header_text(headers, &CONTENT_LENGTH).and_then(|length| length.parse().ok());
    Ok(UploadPiece { offset, checksum, announced, body: receive_recording(body).chunks })
}

/// Validates `Upload-Metadata`: empty, or unique keys without spaces and commas, each with a base64
/// value or none.
fn parse_metadata(headers: &HeaderMap) -> Result<String, Error> {
    let Some(header) = headers.get(METADATA) else { return Ok(String::new()) };
    let refused = || {
        let allowed = "allowed: pairs of a key and its value in base64, separated by commas; each key once";
        Error::BadRequest(format!("Upload-Metadata: {allowed}"))
    };
    let header = header.to_str().map_err(|_| refused())?;
    if header.len() > MOST_METADATA_BYTES {
        let length = header.len();
        return Err(Error::BadRequest(format!(
            "Upload-Metadata: {length} bytes; at most {MOST_METADATA_BYTES} are allowed"
        )));
    }
    // Clients without metadata send an empty header.
    if header.trim().is_empty() {
        return Ok(String::new());
    }
    let mut keys = Vec::new();
    for pair in header.split(',') {
        let (key, value) = pair.trim().split_once(' ').unwrap_or((pair.trim(), ""));
        if key.is_empty() || keys.contains(&key) || BASE64.decode(value.as_bytes()).is_err() {
            return Err(refused());
        }
        keys.push(key);
    }
    Ok(header.to_owned())
}

fn header_text<'a>(headers: &'a HeaderMap, name: &HeaderName) -> Option<&'a str> {
    headers.get(name)?.to_str().ok()
}

fn header_number(headers: &HeaderMap, name: &HeaderName) -> Result<u64, Error> {
    let given = header_text(headers, name).unwrap_or_default();
    // `parse` alone would accept a plus sign.
    let digits = given.bytes().all(|byte| byte.is_ascii_digit());
    let parsed = given.parse().ok().filter(|_| digits);
    parsed.ok_or_else(|| Error::BadRequest(format!("{name}: \"{given}\"; allowed: a number of bytes")))
}

/// Returns a response with the offset and expiry of an upload, and its session once there is one.
fn tell_offset(status: StatusCode, upload: &Upload) -> Result<Response, Error> {
    let mut response = status.into_response();
    put_header(&mut response, OFFSET, &upload.received.to_string())?;
    put_header(&mut response, EXPIRES, &format_http_date(upload.expires_at)?)?;
    if let Some(session) = upload.session_id {
        put_header(&mut response, SESSION, &session.to_string())?;
    }
    Ok(response)
}

fn put_header(response: &mut Response, name: HeaderName, value: &str) -> Result<(), Error> {
    response.headers_mut().insert(name, HeaderValue::from_str(value).map_err(anyhow::Error::from)?);
    Ok(())
}

fn format_http_date(moment: Moment) -> Result<String, Error> {
    Ok(moment.to_utc().format(HTTP_DATE).map_err(anyhow::Error::from)?)
}
