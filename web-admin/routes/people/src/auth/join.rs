//! `/join/{token}`: sets a password by a link. `/forgotten`: requests such a link.

use acts::auth::{passwords, rate_limits};
use acts::error::Error;
use acts::people::accounts;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use model::auth::password_refused::PasswordRefused;
use pages::auth::account::{DeadLinkPage, ForgottenPage, JoinPage};
use routes_base::auth::{ClientAddress, Csrf, CsrfForm};
use routes_base::error::PageError;
use routes_base::forms::FormAnswer;
use routes_base::{AppState, Routes, get, post};
use serde::Deserialize;
use store::auth::account_links::{AccountLink, Purpose};
use store::auth::federation::providers;
use store::people;
use tower_sessions::Session;

use crate::auth::half::{self, FirstFactor};

/// Returns the public routes to set or recover a password.
pub(super) fn password_routes() -> Routes {
    Routes::new()
        .route("/join/{token}", get(show_join_page).merge(post(set_first_password)))
        .route("/forgotten", get(ask_for_link).merge(post(send_link)))
}

async fn show_join_page(
    State(state): State<AppState>,
    Path(token): Path<String>,
    csrf: Csrf,
) -> Result<Response, PageError> {
    match accounts::link(&state, &token).await? {
        Some(link) => Ok(make_join_page(&csrf, token, link, None).into_response()),
        None => Ok(answer_dead_link()),
    }
}

fn make_join_page(csrf: &Csrf, token: String, link: AccountLink, refused: Option<PasswordRefused>) -> JoinPage {
    JoinPage {
        csrf: csrf.token().to_owned(),
        token,
        name: link.name,
        email: link.email,
        school: link.school,
        first: link.purpose == Purpose::Invitation,
        refused,
    }
}

/// 404 rather than 410: an expired link is answered like one that never existed.
fn answer_dead_link() -> Response {
    (StatusCode::NOT_FOUND, DeadLinkPage).into_response()
}

#[derive(Deserialize)]
struct FirstPasswordForm {
    password: String,
    again: String,
}

/// Sets the password and signs in, with the second factor if there is one.
async fn set_first_password(
    State(state): State<AppState>,
    Path(token): Path<String>,
    session: Session,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<FirstPasswordForm>,
) -> Result<FormAnswer<JoinPage>, PageError> {
    let Some(link) = accounts::link(&state, &token).await? else {
        return Ok(FormAnswer::Answered(answer_dead_link()));
    };
    let person = link.person_id;
    let own = [link.name.as_str(), &link.email, &link.school];
    if let Err(refused) = passwords::check_typed(&form.password, &form.again, &own) {
        return Ok(FormAnswer::Refused(make_join_page(&csrf, token, link, Some(refused))));
    }
    if accounts::is_initial_password(&state, person, &form.password).await? {
        return Ok(FormAnswer::Refused(make_join_page(&csrf, token, link, Some(PasswordRefused::Initial))));
    }
    if !accounts::set_password_by_link(&state, &token, &form.password).await? {
        return Ok(FormAnswer::Answered(answer_dead_link()));
    }
    let person = people::find_person(state.db.reader(), person).await?.ok_or(Error::NotFound)?;
    // With access to someone's mail an attacker can get this far, but does not have the second
    // factor.
    if !providers::find_local_passwords(state.db.reader(), person.school_id).await?.allow(person.role) {
        return Ok(FormAnswer::lead_to("/login"));
    }
    let to = half::enter_session(&state, &session, &person, "/", FirstFactor::Password).await?;
    Ok(FormAnswer::lead_to(&to))
}

async fn ask_for_link(csrf: Csrf) -> ForgottenPage {
    ForgottenPage { csrf: csrf.token().to_owned(), asked: false }
}

#[derive(Deserialize)]
struct EmailForm {
    email: String,
}

/// Queues the request. Neither the response nor its timing discloses whether the address has an
/// account.
async fn send_link(
    State(state): State<AppState>,
    ClientAddress(address): ClientAddress,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<EmailForm>,
) -> Result<ForgottenPage, PageError> {
    let email = form.email.trim();
    let people = people::list_people_by_email(state.db.reader(), email).await?;
    rate_limits::take_sign_in(&state, address, email, people.iter().map(|person| person.id).collect()).await?;
    accounts::ask_for_link(&state, email).await?;
    Ok(ForgottenPage { csrf: csrf.token().to_owned(), asked: true })
}
