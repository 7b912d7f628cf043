//! `/sign-in/join`: a user whom a provider or a learning platform has confirmed, and whose identity
//! belongs to no account, joins an account or creates one.

use acts::auth::federation::sources::{IdentitySource, IdentitySourceId};
use acts::auth::federation::{identities, sources};
use acts::auth::rate_limits;
use acts::error::Error;
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Redirect, Response};
use model::auth::federation::ProvenIdentity;
use model::{Moment, PersonKey};
use pages::auth::federation::UnknownPersonPage;
use pages::form::FilledForm;
use routes_base::AppState;
use routes_base::auth::{Browser, CsrfForm, NoFields, begin_token};
use routes_base::error::{PageError, finish_answer, status_of};
use serde::{Deserialize, Serialize};
use store::operations::schools;
use tower_sessions::Session;

use super::entering::enter_joined;
use crate::auth::login::{LoginForm, check_credentials};

const KEY: &str = "confirmed_identity";
/// Name of the link of the launch that has confirmed the identity, in the session.
pub(in crate::auth) const HELD_LINK: &str = "launched_link";
/// Time to join an account, in s.
const WAIT_S: i64 = 10 * 60;

/// An identity that a provider or a learning platform has confirmed in this session, and that
/// belongs to no account yet.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct HeldIdentity {
    source_id: IdentitySourceId,
    /// The identity.
    pub identity: ProvenIdentity,
    until: Moment,
    /// Path to open after signing in.
    pub next: String,
}

/// Stores an identity in a new session.
pub(in crate::auth) async fn hold_identity(
    state: &AppState,
    session: &Session,
    source: &IdentitySource,
    identity: ProvenIdentity,
    next: &str,
) -> Result<(), Error> {
    session.clear().await;
    session.cycle_id().await?;
    let until = state.clock.now().plus_s(WAIT_S);
    let held = HeldIdentity { source_id: source.id, identity, until, next: next.to_owned() };
    session.insert(KEY, held).await?;
    begin_token(session).await
}

/// Returns the identity of a session and its source, if it has not expired.
async fn held_identity(state: &AppState, session: &Session) -> Result<Option<(HeldIdentity, IdentitySource)>, Error> {
    let Some(held) = session.get::<HeldIdentity>(KEY).await? else { return Ok(None) };
    if held.until <= state.clock.now() {
        return Ok(None);
    }
    let source = sources::find_source(state, held.source_id).await?;
    Ok((!source.is_disabled).then_some((held, source)))
}

fn make_page(
    browser: &Browser,
    held: &HeldIdentity,
    source: &IdentitySource,
    form: FilledForm<String>,
) -> UnknownPersonPage {
    UnknownPersonPage {
        csrf: browser.csrf.token().to_owned(),
        provider: source.name.clone(),
        name: held.identity.name.clone(),
        email: form.typed,
        creates: source.creates_trainees,
        error: form.refused,
    }
}

pub(super) async fn show_unknown_person(
    State(state): State<AppState>,
    browser: Browser,
) -> Result<Response, PageError> {
    Ok(match held_identity(&state, &browser.session).await? {
        Some((held, source)) => {
            let email = held.identity.email.clone().unwrap_or_default();
            make_page(&browser, &held, &source, FilledForm::new(email)).into_response()
        }
        None => Redirect::to("/login").into_response(),
    })
}

/// Joins the identity to the account of an address and its password.
pub(super) async fn join_by_password(
    State(state): State<AppState>,
    browser: Browser,
    CsrfForm(mut form): CsrfForm<LoginForm>,
) -> Result<Response, PageError> {
    let Some((held, source)) = held_identity(&state, &browser.session).await? else {
        return Ok(Redirect::to("/login").into_response());
    };
    form.school = schools::find_school_name(state.db.reader(), source.school_id).await?;
    let known = match check_credentials(&state, browser.from, &form).await {
        Ok(known) if known.initial_until.is_none() => known,
        Ok(_) | Err(Error::Unauthorized) => {
            let why = tr!("The address or the password is wrong.").to_owned();
            let page = make_page(&browser, &held, &source, FilledForm::refused(form.email, why));
            return Ok((StatusCode::UNAUTHORIZED, page).into_response());
        }
        Err(error @ (Error::TooMany { .. } | Error::Crowded { .. })) => {
            let why = tr!("Not signed in: {why}.", why = error.said());
            let page = make_page(&browser, &held, &source, FilledForm::refused(form.email, why));
            return Ok(finish_answer(&error, (status_of(&error), page).into_response()));
        }
        Err(error) => return Err(error.into()),
    };
    rate_limits::welcome(&state, browser.from, known.id).await?;
    identities::join_account(&state, &source, &held.identity, known.id).await?;
    enter_joined(&state, &browser, PersonKey { school_id: source.school_id, person_id: known.id }, &held).await
}

/// Begins a new account for the identity.
pub(super) async fn begin_account(
    State(state): State<AppState>,
    browser: Browser,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Response, PageError> {
    let Some((held, source)) = held_identity(&state, &browser.session).await? else {
        return Ok(Redirect::to("/login").into_response());
    };
    let person = identities::begin_account(&state, &source, &held.identity).await?;
    enter_joined(&state, &browser, PersonKey { school_id: person.school_id, person_id: person.id }, &held).await
}
