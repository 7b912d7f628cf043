//! A form with a file, from a page of ours.

use std::collections::BTreeMap;

use acts::error::Error;
use axum::extract::multipart::MultipartError;
use axum::extract::{FromRequest, Multipart, Request};
use axum::response::{IntoResponse, Response};
use serde::de::DeserializeOwned;
use serde::de::value::{Error as FieldError, MapDeserializer};
use tower_sessions::Session;

use super::csrf;
use crate::error::PageError;

/// A form with a file, whose field `csrf` holds the session's token; anything else is refused with 403. The token comes
/// before the file, so that nothing of a stranger's file is read.
#[derive(Clone, Debug)]
pub struct CsrfUpload<T> {
    /// The fields beside the file.
    pub form: T,
    /// The file.
    pub file: SentFile,
}

/// A file that was sent.
#[derive(Clone, Debug, Default)]
pub struct SentFile {
    /// What it was called.
    pub name: String,
    /// What is in it.
    pub bytes: Vec<u8>,
}

impl<T: DeserializeOwned, S: Send + Sync> FromRequest<S> for CsrfUpload<T> {
    type Rejection = Response;

    async fn from_request(request: Request, state: &S) -> Result<Self, Self::Rejection> {
        let session = request.extensions().get::<Session>().cloned();
        let parts = Multipart::from_request(request, state).await;
        let parts = parts.map_err(|e| PageError(Error::BadRequest(e.body_text())).into_response())?;
        read_upload(parts, session).await.map_err(|error| PageError(error).into_response())
    }
}

async fn read_upload<T: DeserializeOwned>(
    mut parts: Multipart,
    session: Option<Session>,
) -> Result<CsrfUpload<T>, Error> {
    let (mut fields, mut file) = (BTreeMap::new(), SentFile::default());
    let (mut genuine, mut read) = (false, 0);
    while let Some(part) = parts.next_field().await.map_err(refuse_upload)? {
        read += 1;
        if read > csrf::MOST_FIELDS {
            return Err(csrf::too_many_fields());
        }
        let name = part.name().unwrap_or_default().to_owned();
        match part.file_name().map(str::to_owned) {
            Some(_) if !genuine => break,
            Some(name) => file = SentFile { name, bytes: part.bytes().await.map_err(refuse_upload)?.to_vec() },
            None => {
                let text = part.text().await.map_err(refuse_upload)?;
                if name == "csrf" {
                    genuine = csrf::is_genuine(session.as_ref(), &text).await?;
                }
                fields.insert(name, text);
            }
        }
    }
    if !genuine {
        return Err(csrf::refuse_form());
    }
    let form = T::deserialize(MapDeserializer::<_, FieldError>::new(fields.into_iter()));
    Ok(CsrfUpload { form: form.map_err(|refused| Error::BadRequest(refused.to_string()))?, file })
}

fn refuse_upload(error: MultipartError) -> Error {
    match error.status() {
        axum::http::StatusCode::PAYLOAD_TOO_LARGE => {
            Error::Unprocessable(tr!("the file is larger than 8 MB: send it in parts").to_owned())
        }
        _ => Error::BadRequest(error.body_text()),
    }
}
