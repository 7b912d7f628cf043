//! Uploads of whole recordings: acknowledged only after the file and its row are durably stored.

use acts::error::Error;
use acts::recordings::checksum::Checksum;
use acts::recordings::intake::{Bearer, RecordingReceipt};
use acts::recordings::{self, Arriving, intake, quotas};
use axum::Json;
use axum::body::{Body, HttpBody};
use axum::extract::State;
use axum::http::header::{CONTENT_LENGTH, CONTENT_TYPE};
use axum::http::{HeaderMap, StatusCode};
use futures::{StreamExt, TryStreamExt};
use model::{Moment, PersonKey};
use routes_base::AppState;
use routes_base::error::{ApiError, ProblemDocument};
use store::recordings::uploads::UploadOwner;
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use crate::caller::Caller;
use crate::recordings::sessions::SessionView;

/// Stores a recording. Uploading the same one again is acknowledged again; a different one with the
/// same id is refused, and so is one with the pseudonym of another person. A recording with
/// `uncounted` set is stored but does not count.
#[utoipa::path(post, path = "/sessions", tag = "upload", operation_id = "upload_recording", request_body(content_type = "application/octet-stream"),
    params(("Content-Digest" = Option<String>, Header, description = "sha-256=:HASH:, the hash in base64 (RFC 9530)"),
           ("Stylet-Clock" = Option<String>, Header, description = "The sender's time, RFC 3339, used to correct a wrong clock")),
    responses((status = 201, body = SessionView), (status = 200, body = SessionView), (status = 400, body = ProblemDocument),
              (status = 401, body = ProblemDocument),
              (status = 409, body = ProblemDocument, description = "A different recording of this session, or another person's attempt"),
              (status = 413, body = ProblemDocument), (status = 415, body = ProblemDocument),
              (status = 422, body = ProblemDocument, description = "Not a recording, or a scanner has found malware in it"),
              (status = 424, body = ProblemDocument, description = "Quarantined after crashing its reader twice; keep it until the operator releases it"),
              (status = 429, body = ProblemDocument, description = "Above the daily or the total limit of a person"),
              (status = 451, body = ProblemDocument, description = "The person was erased, has withdrawn, or never agreed; delete it"),
              (status = 507, body = ProblemDocument, description = "Only the disk reserve is left"),
              (status = 503, body = ProblemDocument, description = "The queue is full, the reader crashed, or the scanner or the store is unavailable; see Retry-After")))]
pub(crate) async fn upload_recording(
    State(state): State<AppState>,
    caller: Caller,
    headers: HeaderMap,
    body: Body,
) -> Result<(StatusCode, Json<SessionView>), ApiError> {
    check_upload_headers(&headers, state.config.max_upload_bytes)?;
    let ahead_us = read_clock_ahead(&headers, state.clock.now())?;
    let digest = content_digest(&headers)?;
    if let Some(person) = caller.owner().person_id {
        let whose = PersonKey { school_id: caller.owner().school_id, person_id: person };
        quotas::ensure_person_quota(state.db.reader(), &state, whose, body.size_hint().lower()).await?;
    }
    let received = recordings::receive(&state, receive_recording(body), digest).await?;
    let bearer = Bearer { ahead_us, ..bearer_of_caller(&caller) };
    // A separate task: the server drops a handler when its client disconnects, and a processing
    // attempt that was recorded as started must be recorded as finished.
    let taken = tokio::spawn(async move { intake::take_in(&state, &bearer, received).await });
    Ok(match taken.await?? {
        RecordingReceipt::Now(session) => (StatusCode::CREATED, Json(session.into())),
        RecordingReceipt::Before(session) => (StatusCode::OK, Json(session.into())),
    })
}

/// Converts a request body to the form expected by `acts`.
pub(crate) fn receive_recording(body: Body) -> Arriving {
    let announced_bytes = body.size_hint().lower();
    Arriving { announced_bytes, chunks: body.into_data_stream().map_err(anyhow::Error::from).boxed() }
}

/// Returns the expected hash of the body, if the sender states one.
fn content_digest(headers: &HeaderMap) -> Result<Option<Checksum>, Error> {
    let Some(header) = headers.get("content-digest") else { return Ok(None) };
    Checksum::of_content(header.to_str().unwrap_or_default())
}

fn bearer_of_caller(caller: &Caller) -> Bearer {
    let UploadOwner { school_id, person_id, station_id } = caller.owner();
    Bearer { school_id, trainee_id: person_id, station_id, actor: caller.actor(), ahead_us: None }
}

/// Returns how far the sender's clock is ahead of the server's, in µs, if the header is present.
pub(crate) fn read_clock_ahead(headers: &HeaderMap, now: Moment) -> Result<Option<i64>, Error> {
    let Some(told) = headers.get("stylet-clock") else { return Ok(None) };
    let told = told.to_str().unwrap_or_default();
    let clock = OffsetDateTime::parse(told, &Rfc3339)
        .map_err(|_| Error::BadRequest(format!("Stylet-Clock: \"{told}\"; allowed: a time as in RFC 3339")))?;
    Ok(Some(Moment::from(clock).micros().saturating_sub(now.micros())))
}

/// Performs all checks that need no byte of the body.
fn check_upload_headers(headers: &HeaderMap, limit_bytes: u64) -> Result<(), Error> {
    let text = |name| headers.get(name).and_then(|value| value.to_str().ok());
    let media_type = text(CONTENT_TYPE).unwrap_or_default().split(';').next().unwrap_or_default().trim();
    if !media_type.eq_ignore_ascii_case("application/octet-stream") {
        return Err(Error::UnsupportedMedia("Content-Type: only application/octet-stream is allowed"));
    }
    match text(CONTENT_LENGTH).and_then(|length| length.parse::<u64>().ok()) {
        Some(0) => Err(Error::Unprocessable("the body is empty: a recording was expected".to_owned())),
        Some(length) if length > limit_bytes => Err(Error::TooLarge { limit_bytes }),
        _ => Ok(()),
    }
}
