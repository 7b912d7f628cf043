//! The step between the password and the second factor: such a session opens only the page that
//! asks for the factor.

use acts::auth::second_factor;
use acts::auth::second_factor::SignInProof;
use acts::error::Error;
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Redirect, Response};
use model::ids::PersonId;
use model::{Moment, PersonKey};
use pages::auth::login::CodePage;
use pages::auth::reauthentication::FactorRefused;
use routes_base::auth::{Browser, CsrfForm, begin_token, start_factored_session, start_session};
use routes_base::error::{PageError, finish_answer, status_of};
use routes_base::{AppState, Routes, get, post};
use serde::{Deserialize, Serialize};
use store::auth::second_factors;
use store::people::{self, Person};
use tower_sessions::Session;

use crate::auth::login::own_path;
use crate::auth::proving::{FactorQuestion, ShownFactor};

const KEY: &str = "half";
/// Time to present the second factor, in s.
const WAIT_S: i64 = 10 * 60;

/// Session state after a correct password while the second factor is pending.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Half {
    person_id: PersonId,
    credential_version: i64,
    until: Moment,
    /// Path to open after signing in.
    next: String,
}

/// Returns the public routes of `/login/code`.
pub(super) fn code_routes() -> Routes {
    Routes::new().route("/login/code", get(show_code_page).merge(post(check_code)))
}

/// How a person has shown who they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FirstFactor {
    /// By the password of this service.
    Password,
    /// By a provider, whose second factor may replace the one of this service.
    Provider { is_second_too: bool },
}

/// Signs in a person who has shown a first factor, or starts the second-factor step; returns the
/// path to open next.
pub(super) async fn enter_session(
    state: &AppState,
    session: &Session,
    person: &Person,
    next: &str,
    shown: FirstFactor,
) -> Result<String, Error> {
    let key = key_of_person(person);
    let now = state.clock.now();
    let is_second_too = shown == FirstFactor::Provider { is_second_too: true };
    if is_second_too || !second_factors::is_second_factor_on(state.db.reader(), key).await? {
        if is_second_too {
            start_factored_session(session, person.id, person.credential_version, now).await?;
        } else {
            start_session(session, person.id, person.credential_version, now).await?;
        }
        // A provider that has seen no second factor proves none.
        let proof = is_second_too.then_some(SignInProof::Provider);
        second_factor::note_sign_in(state, key, proof).await?;
        return Ok(own_path(next).to_owned());
    }
    session.clear().await;
    session.cycle_id().await?;
    let half = Half {
        person_id: person.id,
        credential_version: person.credential_version,
        until: now.plus_s(WAIT_S),
        next: own_path(next).to_owned(),
    };
    session.insert(KEY, half).await?;
    begin_token(session).await?;
    Ok("/login/code".to_owned())
}

/// Returns the person of a pending second-factor step, if it has not expired and the account is
/// still active.
async fn half_signed_in(state: &AppState, session: &Session) -> Result<Option<(Half, Person)>, Error> {
    let Some(half) = session.get::<Half>(KEY).await? else { return Ok(None) };
    if half.until <= state.clock.now() {
        return Ok(None);
    }
    let person = people::find_person(state.db.reader(), half.person_id).await?;
    let person = person.filter(|p| p.disabled_at.is_none() && p.credential_version == half.credential_version);
    Ok(person.map(|person| (half, person)))
}

async fn show_code_page(State(state): State<AppState>, browser: Browser) -> Result<Response, PageError> {
    let Some((_, person)) = half_signed_in(&state, &browser.session).await? else {
        return Ok(Redirect::to("/login").into_response());
    };
    Ok(make_code_page(&state, &browser, &person, None).await?.into_response())
}

/// Builds the page, and starts a passkey challenge in this session.
async fn make_code_page(
    state: &AppState,
    browser: &Browser,
    person: &Person,
    error: Option<String>,
) -> Result<CodePage, Error> {
    let key = key_of_person(person);
    let app = second_factors::find_second_factor(state.db.reader(), key)
        .await?
        .is_some_and(|factor| factor.confirmed_at.is_some());
    let question = FactorQuestion { state, session: &browser.session, key }.question().await?;
    Ok(CodePage { csrf: browser.csrf.token().to_owned(), app, question, error })
}

const fn key_of_person(person: &Person) -> PersonKey {
    PersonKey { school_id: person.school_id, person_id: person.id }
}

/// Signs in by a code, or by the response of a passkey.
async fn check_code(
    State(state): State<AppState>,
    browser: Browser,
    CsrfForm(shown): CsrfForm<ShownFactor>,
) -> Result<Response, PageError> {
    let Some((half, person)) = half_signed_in(&state, &browser.session).await? else {
        return Ok(Redirect::to("/login").into_response());
    };
    let key = key_of_person(&person);
    let proof =
        match (FactorQuestion { state: &state, session: &browser.session, key }).prove(&shown, browser.from).await {
            Ok(Ok(proof)) => proof,
            Ok(Err(refused)) => {
                let words = match refused {
                    FactorRefused::Code => tr!("This code is wrong, already used or expired.").to_owned(),
                    other => other.said(),
                };
                let page = make_code_page(&state, &browser, &person, Some(words)).await?;
                return Ok((StatusCode::UNAUTHORIZED, page).into_response());
            }
            Err(why) => {
                let words = tr!("Not signed in: {why}.", why = why.said());
                let page = make_code_page(&state, &browser, &person, Some(words)).await?;
                return Ok(finish_answer(&why, (status_of(&why), page).into_response()));
            }
        };
    start_session(&browser.session, person.id, person.credential_version, state.clock.now()).await?;
    second_factor::note_sign_in(&state, key, Some(proof)).await?;
    Ok(Redirect::to(own_path(&half.next)).into_response())
}
