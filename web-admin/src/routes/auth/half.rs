//! Between the password and the code: such a session opens nothing but the page that asks for the code.

use axum::extract::State;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Redirect, Response};
use axum::routing::get;
use serde::{Deserialize, Serialize};
use tower_sessions::Session;
use uuid::Uuid;

use super::address::ClientAddress;
use super::csrf::{self, Csrf, CsrfForm};
use super::current::SignedIn;
use super::login::own_path;
use crate::AppState;
use crate::domain::Moment;
use crate::error::{Error, PageError};
use crate::routes::Routes;
use crate::second_factor::{self, Typed};
use crate::storage::people::{self, Person};
use crate::storage::second_factors::{self, PersonKey};
use crate::views::login::CodePage;

const KEY: &str = "half";
/// How long the code is waited for, in s.
const WAIT_S: i64 = 10 * 60;

/// What a session holds whose password was right and whose code is still asked for.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Half {
    person_id: Uuid,
    credential_version: i64,
    until: Moment,
    /// Where to go afterwards.
    next: String,
}

/// `/login/code`, for anybody.
pub(super) fn router() -> Routes {
    Routes::new().route("/login/code", get(show).post(check))
}

/// Lets somebody in whose password is right, or asks for the code; says where to go now.
pub(super) async fn enter(state: &AppState, session: &Session, person: &Person, next: &str) -> Result<String, Error> {
    let key = PersonKey { school_id: person.school_id, person_id: person.id };
    let now = state.clock.now();
    if !second_factors::is_on(state.db.reader(), key).await? {
        SignedIn::start(session, (person.id, person.credential_version), now).await?;
        second_factor::note_sign_in(state, key, None).await?;
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
    csrf::begin(session).await?;
    Ok("/login/code".to_owned())
}

/// Who is half signed in, and may still be.
async fn waiting(state: &AppState, session: &Session) -> Result<Option<(Half, Person)>, Error> {
    let Some(half) = session.get::<Half>(KEY).await? else { return Ok(None) };
    if half.until <= state.clock.now() {
        return Ok(None);
    }
    let person = people::by_id(state.db.reader(), half.person_id).await?;
    let person = person.filter(|p| p.disabled_at.is_none() && p.credential_version == half.credential_version);
    Ok(person.map(|person| (half, person)))
}

async fn show(State(state): State<AppState>, session: Session, csrf: Csrf) -> Result<Response, PageError> {
    if waiting(&state, &session).await?.is_none() {
        return Ok(Redirect::to("/login").into_response());
    }
    Ok(page(&csrf, None).into_response())
}

fn page(csrf: &Csrf, error: Option<String>) -> CodePage {
    CodePage { csrf: csrf.token().to_owned(), error }
}

#[derive(Deserialize)]
struct CodeForm {
    code: String,
}

async fn check(
    State(state): State<AppState>,
    (session, csrf): (Session, Csrf),
    ClientAddress(from): ClientAddress,
    CsrfForm(form): CsrfForm<CodeForm>,
) -> Result<Response, PageError> {
    let Some((half, person)) = waiting(&state, &session).await? else {
        return Ok(Redirect::to("/login").into_response());
    };
    let key = PersonKey { school_id: person.school_id, person_id: person.id };
    let checked = second_factor::check(&state, key, Typed { code: &form.code, from }).await;
    let proof = match checked {
        Ok(Some(proof)) => proof,
        Ok(None) => {
            let why = tr!("This code is wrong, was used before, or is too old.").to_owned();
            return Ok((StatusCode::UNAUTHORIZED, page(&csrf, Some(why))).into_response());
        }
        Err(why) => {
            let words = tr!("Not signed in: {why}.", why = why.said());
            let page = page(&csrf, Some(words));
            return Ok(why.dress((why.status(), page).into_response()));
        }
    };
    SignedIn::start(&session, (person.id, person.credential_version), state.clock.now()).await?;
    second_factor::note_sign_in(&state, key, Some(proof)).await?;
    Ok(Redirect::to(own_path(&half.next)).into_response())
}
