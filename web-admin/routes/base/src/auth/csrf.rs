//! A form must come from a page of ours: each carries a token that only the page and the session know, or, where nobody is signed in,
//! a cookie.

use acts::error::Error;
use acts::secret;
use axum::body::{Body, Bytes};
use axum::extract::{FromRequest, FromRequestParts, RawForm, Request};
use axum::http::request::Parts;
use axum::response::{IntoResponse, Response};
use axum_extra::extract::Form;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use tower_sessions::Session;

use super::StrangerToken;
use crate::error::PageError;

const KEY: &str = "csrf";

/// Gives a session that somebody signs in to its token.
///
/// # Errors
/// When the session cannot be written, or the operating system's random source fails.
pub async fn begin_token(session: &Session) -> Result<(), Error> {
    Ok(session.insert(KEY, secret::random_hex()?).await?)
}

/// The CSRF token, for the hidden field `csrf` of every form: the session's, or a stranger's, masked.
#[derive(Clone, Debug)]
pub struct Csrf(String);

impl Csrf {
    /// The token.
    #[must_use]
    pub fn token(&self) -> &str {
        &self.0
    }

    /// The token of a session that somebody has just signed in to.
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

/// The browser's session.
pub(super) async fn session_of<S: Send + Sync>(parts: &mut Parts, state: &S) -> Result<Session, PageError> {
    let missing = |(_, why): (_, &'static str)| PageError(Error::Internal(anyhow::anyhow!(why)));
    Session::from_request_parts(parts, state).await.map_err(missing)
}

fn stranger_of_request(parts: &Parts) -> StrangerToken {
    parts.extensions.get::<StrangerToken>().cloned().unwrap_or_default()
}

/// A form whose field `csrf` holds the session's token, or a stranger's; anything else is refused with 403.
#[derive(Clone, Debug)]
pub struct CsrfForm<T>(pub T);

/// U+0000 in a form, where a text ends for SQLite: no browser lets anybody type it.
const NUL: &[u8] = b"%00";

/// Most fields of a form: some pages have one for each person of a large cohort. Fields are compared with each other.
pub(super) const MOST_FIELDS: usize = 5000;

/// What a form of more fields is answered.
pub(super) fn too_many_fields() -> Error {
    Error::BadRequest(tr!("The form has more than {most} fields, the most allowed.", most = MOST_FIELDS))
}

/// What a form with U+0000 in it is answered.
pub fn refuse_nul() -> Error {
    Error::BadRequest(tr!("The form holds the character U+0000, which no text does.").to_owned())
}

/// Whether a token is the session's.
pub(super) async fn is_genuine(session: Option<&Session>, sent: &str) -> Result<bool, Error> {
    let Some(session) = session else { return Ok(false) };
    let known = session.get::<String>(KEY).await?;
    Ok(known.zip(secret::unmask(sent)).is_some_and(|(known, sent)| secret::same(&sent, &known)))
}

/// Whether a token is the session's, or, where the session has none, the stranger's.
async fn is_ours(session: &Session, stranger: &StrangerToken, sent: &str) -> Result<bool, Error> {
    match session.get::<String>(KEY).await? {
        Some(_) => is_genuine(Some(session), sent).await,
        None => Ok(secret::unmask(sent).is_some_and(|sent| stranger.is(&sent))),
    }
}

/// What a form without the token is answered.
#[must_use]
pub fn refuse_form() -> Error {
    Error::Forbidden(tr!("This form is stale or came from another site. Go back, reload the page and send it again."))
}

/// A form that says nothing but that it was sent.
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

/// A form, and whether its field `csrf` holds the session's token, or a stranger's: for whoever has a better answer than 403.
#[derive(Clone, Debug)]
pub struct CheckedForm<T> {
    /// Its fields.
    pub form: T,
    /// It comes from a page of this session.
    pub is_genuine: bool,
}

impl<T: DeserializeOwned, S: Send + Sync> FromRequest<S> for CheckedForm<T> {
    type Rejection = Response;

    async fn from_request(request: Request, state: &S) -> Result<Self, Self::Rejection> {
        let SentForm { parts, bytes, is_genuine } = SentForm::read(request, state).await?;
        Ok(Self { form: read_fields(&parts, bytes, state).await?, is_genuine })
    }
}

/// A form before its fields are read.
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

/// A form without a token, of whoever has an address that is a secret itself.
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

/// The bytes of a form that has no more fields than are allowed, before anything is looked for in them.
async fn read_form_bytes<S: Send + Sync>(request: Request, state: &S) -> Result<Bytes, Response> {
    let RawForm(bytes) = RawForm::from_request(request, state).await.map_err(IntoResponse::into_response)?;
    let fields = bytes.iter().filter(|&&byte| byte == b'&').count();
    if fields >= MOST_FIELDS { Err(PageError(too_many_fields()).into_response()) } else { Ok(bytes) }
}

/// Reads the fields of a form whose bytes are known.
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
