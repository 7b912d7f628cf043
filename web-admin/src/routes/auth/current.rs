//! Who is signed in, settled before anything else of a request is read.

use axum::extract::{FromRequestParts, Request, State};
use axum::http::Method;
use axum::http::request::Parts;
use axum::middleware::Next;
use axum::response::{IntoResponse, Redirect, Response};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use tower_sessions::Session;
use uuid::Uuid;

use super::csrf;
use crate::AppState;
use crate::domain::{CurrentPerson, Moment};
use crate::error::{Error, PageError};
use crate::routes::language;
use crate::storage::people;

const KEY: &str = "person";

/// What a signed-in session holds.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct SignedIn {
    /// Who.
    pub person_id: Uuid,
    /// With which password; a newer one ends the session.
    pub credential_version: i64,
    /// When it ends, whatever is done meanwhile. Sessions of before have none.
    #[serde(default)]
    pub until: Option<Moment>,
}

/// How long somebody stays signed in, in s.
const SIGNED_IN_S: i64 = 12 * 3600;

impl SignedIn {
    /// Makes a session a signed-in one, under a new id: whoever planted the old one gains nothing.
    pub(crate) async fn start(
        session: &Session,
        (person_id, credential_version): (Uuid, i64),
        now: Moment,
    ) -> Result<(), Error> {
        session.clear().await;
        session.cycle_id().await?;
        csrf::begin(session).await?;
        let until = Some(now.plus_s(SIGNED_IN_S));
        Ok(session.insert(KEY, Self { person_id, credential_version, until }).await?)
    }
}

/// When a session ends that holds this: somebody's when it was said that it would, one that nobody is signed in to (they were made
/// once) half an hour after it was last written.
#[must_use]
#[expect(clippy::disallowed_types, reason = "tower-sessions keeps them so; one key is looked up")]
pub fn session_end(data: &std::collections::HashMap<String, Value>, now: Moment) -> Moment {
    const STRANGER_S: i64 = 30 * 60;
    let signed_in = data.get(KEY).and_then(|held| SignedIn::deserialize(held).ok());
    signed_in.and_then(|held| held.until).unwrap_or(now.plus_s(STRANGER_S))
}

/// The person of a browser's session, if somebody is signed in and may still be.
pub(crate) async fn person_of(state: &AppState, session: &Session) -> Result<Option<CurrentPerson>, Error> {
    let Some(signed_in) = session.get::<SignedIn>(KEY).await? else { return Ok(None) };
    if signed_in.until.is_none_or(|until| until <= state.clock.now()) {
        return Ok(None);
    }
    let person = people::by_id(state.db.reader(), signed_in.person_id).await?;
    Ok(person.filter(|p| p.credential_version == signed_in.credential_version).and_then(people::Person::into_current))
}

/// Lets the signed-in pass, and sends everybody else to the sign-in page.
///
/// # Errors
/// When the session cannot be read.
pub async fn require_person(
    State(state): State<AppState>,
    session: Session,
    mut request: Request,
    next: Next,
) -> Result<Response, PageError> {
    match person_of(&state, &session).await? {
        Some(person) => {
            let chosen = person.language;
            request.extensions_mut().insert(person);
            Ok(match chosen {
                Some(language) => language::spoken(language, request, next).await,
                None => next.run(request).await,
            })
        }
        None => Ok(to_sign_in(&request)),
    }
}

fn to_sign_in(request: &Request) -> Response {
    let path = request.uri().path();
    // A form cannot be sent again after signing in, so only a page is come back to.
    let plain = path.bytes().all(|b| b.is_ascii_alphanumeric() || b"/-_.~".contains(&b));
    if request.method() == Method::GET && path != "/" && plain {
        return Redirect::to(&format!("/login?next={path}")).into_response();
    }
    Redirect::to("/login").into_response()
}

impl<S: Send + Sync> FromRequestParts<S> for CurrentPerson {
    type Rejection = Response;

    /// What [`require_person`] found. A handler outside that layer has nobody, and sends to the sign-in page.
    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Self::Rejection> {
        parts.extensions.get::<Self>().cloned().ok_or_else(|| Redirect::to("/login").into_response())
    }
}
