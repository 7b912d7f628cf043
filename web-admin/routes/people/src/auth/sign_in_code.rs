//! `/sign-in-code`: the code to sign in at a station. It is created by a form and shown on a page
//! that can be reloaded: the browser's session stores it for a while, encrypted, since the database
//! must not contain a readable code.

use acts::error::Error;
use acts::stations;
use axum::extract::State;
use axum::response::{IntoResponse, Redirect, Response};
use data_encoding::HEXLOWER;
use model::Moment;
use model::ids::PersonId;
use pages::training::trainee::SignInCodePage;
use pages::{NavPlace, Shell};
use platform::sealing;
use routes_base::AppState;
use routes_base::auth::{Csrf, CsrfForm, NoFields, Visitor};
use routes_base::error::PageError;
use serde::{Deserialize, Serialize};
use tower_sessions::Session;

/// Session key of the code.
const SHOWN_KEY: &str = "sign_in_code";
/// Time for which a code is shown, in min.
const SHOWN_MIN: i64 = 10;

/// A code that is being shown.
#[derive(Debug, Serialize, Deserialize)]
struct ShownCode {
    /// Its owner.
    person: PersonId,
    /// The encrypted code, in hexadecimal.
    sealed: String,
    /// Time until which it is shown.
    until: Moment,
}

/// Creates the visitor's sign-in code, which replaces the previous one.
pub(super) async fn make_sign_in_code(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    session: Session,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    let code = stations::make_sign_in_code(&state, &person).await?;
    let sealed = sealing::seal(&state.config.keys_dir, person.id.uuid().as_bytes(), code.as_bytes())?;
    let until = state.clock.now().plus_s(SHOWN_MIN * 60);
    let shown = ShownCode { person: person.id, sealed: HEXLOWER.encode(&sealed), until };
    session.insert(SHOWN_KEY, shown).await.map_err(Error::from)?;
    Ok(Redirect::to("/sign-in-code"))
}

/// Shows the code that was just created; without one, redirects to the page where it is created.
pub(super) async fn show_sign_in_code(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    session: Session,
    csrf: Csrf,
) -> Result<Response, PageError> {
    let shown: Option<ShownCode> = session.get(SHOWN_KEY).await.map_err(Error::from)?;
    let Some(shown) = shown.filter(|shown| shown.person == person.id && state.clock.now() < shown.until) else {
        return Ok(Redirect::to("/account").into_response());
    };
    let sealed = HEXLOWER.decode(shown.sealed.as_bytes()).map_err(anyhow::Error::from)?;
    let code = sealing::open(&state.config.keys_dir, person.id.uuid().as_bytes(), &sealed)?;
    let shell = Shell::new(&person, csrf.token(), NavPlace::Home);
    let code = String::from_utf8(code).map_err(anyhow::Error::from)?;
    Ok(SignInCodePage { shell, code, minutes: SHOWN_MIN }.into_response())
}
