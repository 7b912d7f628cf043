//! Forms with a file, protected by a CSRF token.

use std::collections::BTreeMap;

use acts::error::Error;
use axum::extract::multipart::{Field, MultipartError};
use axum::extract::{FromRequest, Multipart, Request};
use axum::response::{IntoResponse, Response};
use serde::de::DeserializeOwned;
use serde::de::value::{Error as FieldError, MapDeserializer};
use tower_sessions::Session;

use super::csrf;
use crate::error::PageError;

/// Maximum size of all fields together, without the file, in bytes: the same as for a form without
/// a file.
const MOST_TEXT_BYTES: usize = 2 * 1024 * 1024;

/// A form with a file, whose field `csrf` contains the session's token; all others are refused with
/// 403. The token must precede the file, so that no file is read without a valid token.
#[derive(Clone, Debug)]
pub struct CsrfUpload<T> {
    /// The fields other than the file.
    pub form: T,
    /// The file.
    pub file: SentFile,
}

/// An uploaded file.
#[derive(Clone, Debug, Default)]
pub struct SentFile {
    /// Its file name.
    pub name: String,
    /// Its content; empty if `is_cut`.
    pub bytes: Vec<u8>,
    /// Whether it exceeded the size limit, so that its content was dropped.
    pub is_cut: bool,
}

/// A form with a file among its fields, which are kept in order and may repeat. A file that is too
/// large is read to its end, so that no field after it is lost.
#[derive(Clone, Debug)]
pub struct CsrfFileForm<const MOST_BYTES: usize> {
    /// The fields other than the file.
    pub fields: Vec<(String, String)>,
    /// The file.
    pub file: SentFile,
}

/// The parsed parts of a form with a file.
struct SentParts {
    fields: Vec<(String, String)>,
    file: SentFile,
}

impl<T: DeserializeOwned, S: Send + Sync> FromRequest<S> for CsrfUpload<T> {
    type Rejection = Response;

    async fn from_request(request: Request, state: &S) -> Result<Self, Self::Rejection> {
        let SentParts { fields, file } = read_request(request, state, usize::MAX).await?;
        let fields: BTreeMap<String, String> = fields.into_iter().collect();
        let form = T::deserialize(MapDeserializer::<_, FieldError>::new(fields.into_iter()));
        let form = form.map_err(|refused| PageError(Error::BadRequest(refused.to_string())).into_response())?;
        Ok(Self { form, file })
    }
}

impl<const MOST_BYTES: usize, S: Send + Sync> FromRequest<S> for CsrfFileForm<MOST_BYTES> {
    type Rejection = Response;

    async fn from_request(request: Request, state: &S) -> Result<Self, Self::Rejection> {
        let SentParts { fields, file } = read_request(request, state, MOST_BYTES).await?;
        if fields.iter().any(|(_, typed)| typed.contains('\0')) {
            return Err(PageError(csrf::refuse_nul()).into_response());
        }
        Ok(Self { fields, file })
    }
}

async fn read_request<S: Send + Sync>(request: Request, state: &S, most_bytes: usize) -> Result<SentParts, Response> {
    let session = request.extensions().get::<Session>().cloned();
    let parts = Multipart::from_request(request, state).await;
    let parts = parts.map_err(|e| PageError(Error::BadRequest(e.body_text())).into_response())?;
    read_parts(parts, session, most_bytes).await.map_err(|error| PageError(error).into_response())
}

async fn read_parts(mut parts: Multipart, session: Option<Session>, most_bytes: usize) -> Result<SentParts, Error> {
    let (mut fields, mut file) = (Vec::new(), SentFile::default());
    let (mut genuine, mut read, mut left_bytes) = (false, 0, MOST_TEXT_BYTES);
    while let Some(part) = parts.next_field().await.map_err(refuse_upload)? {
        read += 1;
        if read > csrf::MOST_FIELDS {
            return Err(csrf::too_many_fields());
        }
        let name = part.name().unwrap_or_default().to_owned();
        match part.file_name().map(str::to_owned) {
            Some(_) if !genuine => break,
            Some(name) => file = read_file(part, name, most_bytes).await?,
            None => {
                let text = read_text(part, &mut left_bytes).await?;
                if name == "csrf" {
                    genuine = csrf::is_genuine(session.as_ref(), &text).await?;
                }
                fields.push((name, text));
            }
        }
    }
    if genuine { Ok(SentParts { fields, file }) } else { Err(csrf::refuse_form()) }
}

/// Reads the text of a field, and subtracts its size from the bytes left for all fields.
async fn read_text(mut part: Field<'_>, left_bytes: &mut usize) -> Result<String, Error> {
    let mut text = Vec::new();
    while let Some(piece) = part.chunk().await.map_err(refuse_upload)? {
        *left_bytes = left_bytes.checked_sub(piece.len()).ok_or_else(too_much_text)?;
        text.extend_from_slice(&piece);
    }
    Ok(String::from_utf8_lossy(&text).into_owned())
}

fn too_much_text() -> Error {
    Error::Unprocessable(
        tr!("The form fields contain more than 2 MB of text, the most allowed in addition to a file.").to_owned(),
    )
}

/// Reads a file to its end; the content of one that exceeds `most_bytes` is dropped.
async fn read_file(mut part: Field<'_>, name: String, most_bytes: usize) -> Result<SentFile, Error> {
    let mut file = SentFile { name, ..SentFile::default() };
    while let Some(piece) = part.chunk().await.map_err(refuse_upload)? {
        file.is_cut |= file.bytes.len() + piece.len() > most_bytes;
        if file.is_cut {
            file.bytes.clear();
        } else {
            file.bytes.extend(piece);
        }
    }
    Ok(file)
}

fn refuse_upload(error: MultipartError) -> Error {
    match error.status() {
        axum::http::StatusCode::PAYLOAD_TOO_LARGE => {
            Error::Unprocessable(tr!("the file is larger than 8 MB: send it in parts").to_owned())
        }
        _ => Error::BadRequest(error.body_text()),
    }
}
