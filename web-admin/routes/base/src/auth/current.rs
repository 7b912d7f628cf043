//! Who is signed in, settled before anything else of a request is read.

use acts::error::Error;
use acts::web_sessions::{SIGNED_IN_KEY, SignedInSession};
use axum::extract::{FromRequestParts, Request, State};
use axum::http::Method;
use axum::http::request::Parts;
use axum::middleware::Next;
use axum::response::{IntoResponse, Redirect, Response};
use model::ids::PersonId;
use model::{CurrentPerson, Moment, Role};
use pages::school_time;
use store::people::{self, BrowsingPerson};
use tower_sessions::Session;

use super::asked_by;
use super::csrf;
use crate::error::PageError;
use crate::refusals::KnownAsker;
use crate::{AppState, language};

/// How long somebody stays signed in, in s.
const SIGNED_IN_S: i64 = 12 * 3600;

/// Makes a session a signed-in one, under a new id: whoever planted the old one gains nothing.
pub async fn start_session(
    session: &Session,
    person_id: PersonId,
    credential_version: i64,
    now: Moment,
) -> Result<(), Error> {
    session.clear().await;
    session.cycle_id().await?;
    csrf::begin_token(session).await?;
    let until = Some(now.plus_s(SIGNED_IN_S));
    Ok(session.insert(SIGNED_IN_KEY, SignedInSession { person_id, credential_version, until }).await?)
}

/// How a browser's session stands.
#[derive(Debug)]
pub enum SignInStanding {
    /// Nobody is signed in.
    Stranger,
    /// A person who must have a second factor before anything else.
    OwesFactor(SignedInPerson),
    /// A person is signed in.
    SignedIn(SignedInPerson),
}

/// The person of a browser's session.
#[derive(Debug)]
pub struct SignedInPerson {
    person: CurrentPerson,
    /// Time zone of their school.
    time_zone: String,
}

/// How a browser's session stands, and with whom.
pub async fn standing_of(state: &AppState, session: &Session) -> Result<SignInStanding, Error> {
    let Some(signed_in) = session.get::<SignedInSession>(SIGNED_IN_KEY).await? else {
        return Ok(SignInStanding::Stranger);
    };
    if signed_in.until.is_none_or(|until| until <= state.clock.now()) {
        return Ok(SignInStanding::Stranger);
    }
    let found = people::find_browsing_person(state.db.reader(), signed_in.person_id).await?;
    let found = found.filter(|found| found.person.credential_version == signed_in.credential_version);
    let Some(BrowsingPerson { person, time_zone, owes_factor }) = found else { return Ok(SignInStanding::Stranger) };
    let Some(person) = person.into_current() else { return Ok(SignInStanding::Stranger) };
    let signed_in = SignedInPerson { person, time_zone };
    Ok(if owes_factor { SignInStanding::OwesFactor(signed_in) } else { SignInStanding::SignedIn(signed_in) })
}

/// The person of a browser's session, if somebody is signed in, may still be, and owes nothing.
pub async fn person_of(state: &AppState, session: &Session) -> Result<Option<CurrentPerson>, Error> {
    Ok(match standing_of(state, session).await? {
        SignInStanding::SignedIn(SignedInPerson { person, .. }) => Some(person),
        SignInStanding::Stranger | SignInStanding::OwesFactor(_) => None,
    })
}

/// Where a second factor is made.
const ENROLMENT: &str = "/account/second-factor";

/// What whoever owes a second factor may ask for: the way to it, and the way out.
fn may_while_owing(path: &str) -> bool {
    let enrolment = path.strip_prefix(ENROLMENT).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'));
    enrolment || ["/logout", "/account/language"].contains(&path)
}

/// Lets the signed-in pass, leads those to their second factor who must have one and have none, and sends everybody else to
/// the sign-in page.
///
/// # Errors
/// When the session cannot be read.
pub async fn require_person(
    State(state): State<AppState>,
    session: Session,
    mut request: Request,
    next: Next,
) -> Result<Response, PageError> {
    let SignedInPerson { person, time_zone } = match standing_of(&state, &session).await? {
        SignInStanding::Stranger => return Ok(to_sign_in(&request)),
        SignInStanding::OwesFactor(_) if !may_while_owing(request.uri().path()) => {
            return Ok(Redirect::to(ENROLMENT).into_response());
        }
        SignInStanding::OwesFactor(signed_in) | SignInStanding::SignedIn(signed_in) => signed_in,
    };
    let (chosen, asker, asked) = (person.language, KnownAsker::from(&person), asked_by(&state, &request));
    request.extensions_mut().insert(person);
    let answer = school_time::on_school_clock(&time_zone, async {
        match chosen {
            Some(language) => language::answer_in_language(language, request, next).await,
            None => next.run(request).await,
        }
    })
    .await;
    state.refusals.note(asker, &asked, &answer);
    Ok(answer)
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

/// Whoever is signed in, whatever they may do.
#[derive(Clone, Debug)]
pub struct Visitor(pub CurrentPerson);

impl<S: Send + Sync> FromRequestParts<S> for Visitor {
    type Rejection = Response;

    /// What [`require_person`] found. A handler outside that layer has nobody, and sends to the sign-in page.
    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Self::Rejection> {
        parts.extensions.get().cloned().map(Self).ok_or_else(|| Redirect::to("/login").into_response())
    }
}

/// Whoever is signed in and teaches, or administers the school.
#[derive(Clone, Debug)]
pub struct Teacher(pub CurrentPerson);

impl<S: Send + Sync> FromRequestParts<S> for Teacher {
    type Rejection = Response;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Self::Rejection> {
        let Visitor(person) = Visitor::from_request_parts(parts, state).await?;
        match person.role {
            Role::Instructor | Role::Administrator => Ok(Self(person)),
            Role::Trainee | Role::Guest => Err(refuse_role(tr!("this page is for those who teach"))),
        }
    }
}

/// Whoever is signed in and administers the school.
#[derive(Clone, Debug)]
pub struct Administrator(pub CurrentPerson);

impl<S: Send + Sync> FromRequestParts<S> for Administrator {
    type Rejection = Response;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Self::Rejection> {
        let Visitor(person) = Visitor::from_request_parts(parts, state).await?;
        match person.role {
            Role::Administrator => Ok(Self(person)),
            Role::Instructor | Role::Trainee | Role::Guest => Err(refuse_role(tr!("this page is for administrators"))),
        }
    }
}

fn refuse_role(why: &'static str) -> Response {
    PageError(Error::Forbidden(why)).into_response()
}
