//! Authenticates the caller of the API before anything else of a request is read.

use acts::error::{Error, error_chain};
use acts::stations::CallingStation;
use axum::extract::{FromRequestParts, Request, State};
use axum::http::header::AUTHORIZATION;
use axum::http::request::Parts;
use axum::http::{HeaderMap, Method};
use axum::middleware::Next;
use axum::response::Response;
use model::CurrentPerson;
use model::ids::SchoolId;
use platform::secret;
use routes_base::AppState;
use routes_base::auth::{asked_by, person_of};
use routes_base::error::ApiError;
use routes_base::refusals::{KnownAsker, RequestFacts};
use store::audit::Actor;
use store::auth::tokens;
use store::auth::tokens::Token;
use store::people::{self, Person};
use store::recordings::uploads::UploadOwner;
use tower_sessions::Session;

/// The authenticated caller.
#[derive(Clone, Debug)]
pub(super) enum Caller {
    /// A person, by their own token or by a signed-in session.
    Person(CurrentPerson),
    /// A training station, which uploads for the trainee named in the recording.
    Station(CallingStation),
}

impl Caller {
    pub(super) const fn school_id(&self) -> SchoolId {
        match self {
            Self::Person(person) => person.school_id,
            Self::Station(station) => station.school_id,
        }
    }

    pub(super) fn actor(&self) -> Actor {
        match self {
            Self::Person(person) => Actor::Person(person.id),
            Self::Station(station) => Actor::Station(station.name.clone()),
        }
    }

    /// Returns the caller's identity for the log of refused requests.
    fn asker(&self) -> KnownAsker {
        match self {
            Self::Person(person) => person.into(),
            Self::Station(station) => station.into(),
        }
    }

    /// Returns the person; an error for a station, which acts for no particular person.
    pub(super) const fn person(&self) -> Result<&CurrentPerson, Error> {
        match self {
            Self::Person(person) => Ok(person),
            Self::Station(_) => Err(Error::Forbidden("a station's token can upload attempts, but not read them")),
        }
    }

    /// Returns the station; an error for a person.
    pub(super) const fn station(&self) -> Result<&CallingStation, Error> {
        match self {
            Self::Station(station) => Ok(station),
            Self::Person(_) => Err(Error::Forbidden("this requires the token of a training station")),
        }
    }

    /// Returns the caller as the owner of an upload in pieces.
    pub(super) fn owner(&self) -> UploadOwner {
        let (person_id, station_id) = match self {
            Self::Person(person) => (Some(person.id), None),
            Self::Station(station) => (None, Some(station.id)),
        };
        UploadOwner { school_id: self.school_id(), person_id, station_id }
    }
}

/// Admits callers with a valid token, and signed-in people for requests that change nothing:
/// browsers attach the cookie to every request, also to those forged by another site.
pub(super) async fn require_caller(
    State(state): State<AppState>,
    session: Session,
    mut request: Request,
    next: Next,
) -> Result<Response, ApiError> {
    let reads = matches!(*request.method(), Method::GET | Method::HEAD);
    let asked = asked_by(&state, &request);
    let caller = match bearer_token(request.headers()) {
        Some(token) => Some(caller_of_request(&state, token, &asked).await?),
        None if reads => person_of(&state, &session).await?.map(Caller::Person),
        None => None,
    };
    let caller = caller.ok_or(Error::Unauthorized)?;
    let asker = caller.asker();
    request.extensions_mut().insert(caller);
    let answer = next.run(request).await;
    state.refusals.note(asker, &asked, &answer);
    Ok(answer)
}

/// Returns the owner of a token. An unknown or expired token is logged.
async fn caller_of_request(state: &AppState, token: &str, asked: &RequestFacts) -> Result<Caller, Error> {
    let found = caller_of_token(state, token).await.and_then(|caller| caller.ok_or(Error::Unauthorized));
    if let Err(Error::Unauthorized | Error::Expired(_)) = &found {
        state.refusals.note_token(asked);
    }
    found
}

/// Returns the bearer token of a request.
#[must_use]
pub fn bearer_token(headers: &HeaderMap) -> Option<&str> {
    let (scheme, token) = headers.get(AUTHORIZATION)?.to_str().ok()?.split_once(' ')?;
    scheme.eq_ignore_ascii_case("bearer").then_some(token.trim())
}

async fn caller_of_token(state: &AppState, token: &str) -> Result<Option<Caller>, Error> {
    let Some(token) = tokens::find_token(state.db.reader(), &secret::token_sha256(token)).await? else {
        return Ok(None);
    };
    if let Some(end) = token.expires_at.filter(|end| *end <= state.clock.now()) {
        let why = format!("this token expired at {end}; create another on your account page, under \"Programs\"");
        return Err(Error::Expired(why));
    }
    if let Some(id) = token.person_id {
        // A disk that accepts no writes must not keep anyone from reading.
        if let Err(error) = acts::stations::note_token_use(state, &token).await {
            tracing::warn!(cause = error_chain(&error), "failed to record the use of a token");
        }
        let person = people::find_person(state.db.reader(), id).await?;
        return Ok(person.and_then(Person::into_current).map(Caller::Person));
    }
    acts::stations::note_station_sight(state, &token).await?;
    let Token { id, school_id, station, .. } = token;
    Ok(Some(Caller::Station(CallingStation { school_id, id: id.into(), name: station.unwrap_or_default() })))
}

impl<S: Send + Sync> FromRequestParts<S> for Caller {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Self::Rejection> {
        parts.extensions.get::<Self>().cloned().ok_or(ApiError(Error::Unauthorized))
    }
}
