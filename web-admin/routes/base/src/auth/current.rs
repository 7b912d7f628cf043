//! Determines the signed-in person before anything else of a request is read.

use acts::auth::web_sessions::{SIGNED_IN_KEY, SignedInSession};
use acts::error::Error;
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

use super::{asked_by, csrf};
use crate::error::PageError;
use crate::refusals::KnownAsker;
use crate::{AppState, language};

/// Lifetime of a signed-in session, in s.
const SIGNED_IN_S: i64 = 12 * 3600;

/// Signs a session in, under a new id, which prevents session fixation.
pub async fn start_session(
    session: &Session,
    person_id: PersonId,
    credential_version: i64,
    now: Moment,
) -> Result<(), Error> {
    let until = Some(now.plus_s(SIGNED_IN_S));
    begin_session(session, SignedInSession { person_id, credential_version, until, has_factor_elsewhere: false }).await
}

/// Signs a session in, as [`start_session`] does, after a second factor that a trusted provider has
/// seen.
pub async fn start_factored_session(
    session: &Session,
    person_id: PersonId,
    credential_version: i64,
    now: Moment,
) -> Result<(), Error> {
    let until = Some(now.plus_s(SIGNED_IN_S));
    begin_session(session, SignedInSession { person_id, credential_version, until, has_factor_elsewhere: true }).await
}

async fn begin_session(session: &Session, signed_in: SignedInSession) -> Result<(), Error> {
    session.clear().await;
    session.cycle_id().await?;
    csrf::begin_token(session).await?;
    Ok(session.insert(SIGNED_IN_KEY, signed_in).await?)
}

/// Sign-in state of a browser's session.
#[derive(Debug)]
pub enum SignInStanding {
    /// Not signed in.
    Stranger,
    /// Signed in, but must set up a required second factor before anything else.
    OwesFactor(SignedInPerson),
    /// Signed in.
    SignedIn(SignedInPerson),
}

/// The person of a browser's session.
#[derive(Debug)]
pub struct SignedInPerson {
    /// The person.
    pub person: CurrentPerson,
    /// Time zone of their school.
    pub time_zone: String,
}

/// Returns the sign-in state of a browser's session, with its person.
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
    let owes_factor = owes_factor && !signed_in.has_factor_elsewhere;
    let signed_in = SignedInPerson { person, time_zone };
    Ok(if owes_factor { SignInStanding::OwesFactor(signed_in) } else { SignInStanding::SignedIn(signed_in) })
}

/// Returns the person of a browser's session with their time zone, if they are signed in, their
/// account is active, and no second factor is due.
pub async fn find_signed_in(state: &AppState, session: &Session) -> Result<Option<SignedInPerson>, Error> {
    Ok(match standing_of(state, session).await? {
        SignInStanding::SignedIn(signed_in) => Some(signed_in),
        SignInStanding::Stranger | SignInStanding::OwesFactor(_) => None,
    })
}

/// Returns the person of a browser's session, as [`find_signed_in`] does.
pub async fn person_of(state: &AppState, session: &Session) -> Result<Option<CurrentPerson>, Error> {
    Ok(find_signed_in(state, session).await?.map(|signed_in| signed_in.person))
}

/// Page to set up a second factor.
const ENROLMENT: &str = "/account/second-factor";

/// Whether a person without a required second factor may open a path: its setup, signing out, and
/// the choice of the language.
fn may_while_owing(path: &str) -> bool {
    let enrolment = path.strip_prefix(ENROLMENT).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'));
    enrolment || ["/logout", "/account/language"].contains(&path)
}

/// Admits signed-in people, redirects those without a required second factor to its setup, and all
/// others to the sign-in page.
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
    // Only pages are returned to after signing in: a form cannot be sent again.
    let plain = path.bytes().all(|b| b.is_ascii_alphanumeric() || b"/-_.~".contains(&b));
    if request.method() == Method::GET && path != "/" && plain {
        return Redirect::to(&format!("/login?next={path}")).into_response();
    }
    Redirect::to("/login").into_response()
}

/// A signed-in person of any role.
#[derive(Clone, Debug)]
pub struct Visitor(pub CurrentPerson);

impl<S: Send + Sync> FromRequestParts<S> for Visitor {
    type Rejection = Response;

    /// Takes the person found by [`require_person`]. Outside that layer there is none, which
    /// redirects to the sign-in page.
    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Self::Rejection> {
        parts.extensions.get().cloned().map(Self).ok_or_else(|| Redirect::to("/login").into_response())
    }
}

/// A signed-in instructor or administrator.
#[derive(Clone, Debug)]
pub struct Teacher(pub CurrentPerson);

impl<S: Send + Sync> FromRequestParts<S> for Teacher {
    type Rejection = Response;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Self::Rejection> {
        let Visitor(person) = Visitor::from_request_parts(parts, state).await?;
        match person.role {
            Role::Instructor | Role::Administrator => Ok(Self(person)),
            Role::Trainee | Role::Guest => Err(refuse_role(tr!("this page is for instructors"))),
        }
    }
}

/// A signed-in administrator.
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
