//! CSRF protection: each form contains a token that is also stored in the session or, for anonymous
//! visitors, in a cookie.

use acts::error::Error;
use axum::body::{Body, Bytes};
use axum::extract::{FromRequest, FromRequestParts, RawForm, Request};
use axum::http::request::Parts;
use axum::response::{IntoResponse, Response};
use axum_extra::extract::Form;
use platform::secret;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use tower_sessions::Session;

use super::StrangerToken;
use crate::error::PageError;

const KEY: &str = "csrf";

/// Stores a new token in a session that was just signed in.
///
/// # Errors
/// When the session cannot be written, or the operating system's random source fails.
pub async fn begin_token(session: &Session) -> Result<(), Error> {
    Ok(session.insert(KEY, secret::random_hex()?).await?)
}

/// The CSRF token for the hidden field `csrf` of every form: the token of the session or of the
/// anonymous visitor, masked.
#[derive(Clone, Debug)]
pub struct Csrf(String);

impl Csrf {
    /// Returns the token.
    #[must_use]
    pub fn token(&self) -> &str {
        &self.0
    }

    /// Returns the token of a session that was just signed in.
    ///
    /// # Errors
    /// When the session cannot be read.
    pub async fn of_session(session: &Session) -> Result<Self, Error> {
        Self::of(session, &StrangerToken::default()).await
    }

    async fn of(session: &Session, stranger: &StrangerToken) -> Result<Self, Error> {
        match session.get::<String>(KEY).await? {
            Some(token) => Ok(Self(secret::mask(&token)?)),
            None => Ok(Self(secret::mask(&stranger.token()?)?)),
        }
    }
}

impl<S: Send + Sync> FromRequestParts<S> for Csrf {
    type Rejection = PageError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Self::Rejection> {
        Ok(Self::of(&session_of(parts, state).await?, &stranger_of_request(parts)).await?)
    }
}

/// Returns the browser's session.
pub(super) async fn session_of<S: Send + Sync>(parts: &mut Parts, state: &S) -> Result<Session, PageError> {
    let missing = |(_, why): (_, &'static str)| PageError(Error::Internal(anyhow::anyhow!(why)));
    Session::from_request_parts(parts, state).await.map_err(missing)
}

fn stranger_of_request(parts: &Parts) -> StrangerToken {
    parts.extensions.get::<StrangerToken>().cloned().unwrap_or_default()
}

/// A form whose field `csrf` contains the token of the session or of the anonymous visitor; all
/// others are refused with 403.
#[derive(Clone, Debug)]
pub struct CsrfForm<T>(pub T);

/// U+0000 in a form, which terminates a text in SQLite and cannot be typed in a browser.
const NUL: &[u8] = b"%00";

/// Maximum number of fields in a form: some pages have one per person of a large cohort. Limited
/// because fields are compared with each other.
pub(super) const MOST_FIELDS: usize = 5000;

/// Returns the error for a form with too many fields.
pub(super) fn too_many_fields() -> Error {
    Error::BadRequest(tr!("The form has more than {most} fields, the most allowed.", most = MOST_FIELDS))
}

/// Returns the error for a form that contains U+0000.
pub fn refuse_nul() -> Error {
    Error::BadRequest(tr!("The form contains the character U+0000, which is not allowed.").to_owned())
}

/// Whether a token is that of the session.
pub(super) async fn is_genuine(session: Option<&Session>, sent: &str) -> Result<bool, Error> {
    let Some(session) = session else { return Ok(false) };
    let known = session.get::<String>(KEY).await?;
    Ok(known.zip(secret::unmask(sent)).is_some_and(|(known, sent)| secret::same(&sent, &known)))
}

/// Whether a token is that of the session or, if the session has none, that of the anonymous
/// visitor.
async fn is_ours(session: &Session, stranger: &StrangerToken, sent: &str) -> Result<bool, Error> {
    match session.get::<String>(KEY).await? {
        Some(_) => is_genuine(Some(session), sent).await,
        None => Ok(secret::unmask(sent).is_some_and(|sent| stranger.is(&sent))),
    }
}

/// Returns the error for a form without a valid token.
#[must_use]
pub fn refuse_form() -> Error {
    Error::Forbidden(tr!(
        "This form is out of date or was sent from another site. Go back, reload the page and send it again."
    ))
}

/// A form without fields of its own.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct NoFields {}

#[derive(Deserialize)]
struct TokenField {
    #[serde(default)]
    csrf: String,
}

impl<T: DeserializeOwned, S: Send + Sync> FromRequest<S> for CsrfForm<T> {
    type Rejection = Response;

    async fn from_request(request: Request, state: &S) -> Result<Self, Self::Rejection> {
        let SentForm { parts, bytes, is_genuine } = SentForm::read(request, state).await?;
        if !is_genuine {
            return Err(PageError(refuse_form()).into_response());
        }
        read_fields(&parts, bytes, state).await.map(Self)
    }
}

/// A form, and whether its field `csrf` contains a valid token, for handlers that can answer an
/// invalid one better than with 403.
#[derive(Clone, Debug)]
pub struct CheckedForm<T> {
    /// Its fields.
    pub form: T,
    /// Whether its token is valid.
    pub is_genuine: bool,
}

impl<T: DeserializeOwned, S: Send + Sync> FromRequest<S> for CheckedForm<T> {
    type Rejection = Response;

    async fn from_request(request: Request, state: &S) -> Result<Self, Self::Rejection> {
        let SentForm { parts, bytes, is_genuine } = SentForm::read(request, state).await?;
        Ok(Self { form: read_fields(&parts, bytes, state).await?, is_genuine })
    }
}

/// A form whose fields are not parsed yet.
struct SentForm {
    parts: Parts,
    bytes: Bytes,
    is_genuine: bool,
}

impl SentForm {
    async fn read<S: Send + Sync>(request: Request, state: &S) -> Result<Self, Response> {
        let (mut parts, body) = request.into_parts();
        let session = session_of(&mut parts, state).await.map_err(IntoResponse::into_response)?;
        let again = |body| Request::from_parts(parts.clone(), body);
        let bytes = read_form_bytes(again(body), state).await?;
        let sent = Form::<TokenField>::from_request(again(Body::from(bytes.clone())), state).await;
        let sent = sent.map(|Form(field)| field.csrf).unwrap_or_default();
        let is_ours = is_ours(&session, &stranger_of_request(&parts), &sent).await;
        let is_genuine = is_ours.map_err(|error| PageError(error).into_response())?;
        Ok(Self { parts, bytes, is_genuine })
    }
}

/// A form without a token, for addresses that are secrets themselves.
#[derive(Clone, Debug)]
pub struct OpenForm<T>(pub T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequest<S> for OpenForm<T> {
    type Rejection = Response;

    async fn from_request(request: Request, state: &S) -> Result<Self, Self::Rejection> {
        let (parts, body) = request.into_parts();
        let bytes = read_form_bytes(Request::from_parts(parts.clone(), body), state).await?;
        read_fields(&parts, bytes, state).await.map(Self)
    }
}

/// Reads the bytes of a form, and refuses it if it has too many fields, before anything is searched
/// in them.
async fn read_form_bytes<S: Send + Sync>(request: Request, state: &S) -> Result<Bytes, Response> {
    let RawForm(bytes) = RawForm::from_request(request, state).await.map_err(IntoResponse::into_response)?;
    let fields = bytes.iter().filter(|&&byte| byte == b'&').count();
    if fields >= MOST_FIELDS { Err(PageError(too_many_fields()).into_response()) } else { Ok(bytes) }
}

/// Parses the fields of a form from its bytes.
async fn read_fields<T: DeserializeOwned, S: Send + Sync>(
    parts: &Parts,
    bytes: Bytes,
    state: &S,
) -> Result<T, Response> {
    if bytes.windows(NUL.len()).any(|part| part == NUL) || bytes.contains(&0) {
        return Err(PageError(refuse_nul()).into_response());
    }
    let form = Form::<T>::from_request(Request::from_parts(parts.clone(), Body::from(bytes)), state).await;
    form.map(|Form(fields)| fields).map_err(|e| PageError(Error::BadRequest(e.body_text())).into_response())
}
