//! `/join/{token}`: a password is chosen by a link. `/forgotten`: such a link is asked for.

use acts::error::Error;
use acts::{accounts, brakes, passwords};
use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use model::password_refused::PasswordRefused;
use pages::account::{DeadLinkPage, ForgottenPage, JoinPage};
use routes_base::auth::{ClientAddress, Csrf, CsrfForm};
use routes_base::error::PageError;
use routes_base::forms::FormAnswer;
use routes_base::{AppState, Routes, get, post};
use serde::Deserialize;
use store::account_links::{AccountLink, Purpose};
use store::people;
use tower_sessions::Session;

use super::half;

/// The ways to a password, for anybody.
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

/// Not 410: a link that never was is answered the same.
fn answer_dead_link() -> Response {
    (StatusCode::NOT_FOUND, DeadLinkPage).into_response()
}

#[derive(Deserialize)]
struct FirstPasswordForm {
    password: String,
    again: String,
}

/// Sets the password and signs in, by a code where there is a second factor.
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
    if accounts::is_initial_password(&state, &link.email, &form.password).await? {
        return Ok(FormAnswer::Refused(make_join_page(&csrf, token, link, Some(PasswordRefused::Initial))));
    }
    if !accounts::set_password_by_link(&state, &token, &form.password).await? {
        return Ok(FormAnswer::Answered(answer_dead_link()));
    }
    let person = people::find_person(state.db.reader(), person).await?.ok_or(Error::NotFound)?;
    // Whoever reads somebody's mail has their password now, and not their app.
    Ok(FormAnswer::lead_to(&half::enter_session(&state, &session, &person, "/").await?))
}

async fn ask_for_link(csrf: Csrf) -> ForgottenPage {
    ForgottenPage { csrf: csrf.token().to_owned(), asked: false }
}

#[derive(Deserialize)]
struct EmailForm {
    email: String,
}

/// Queues the question. Neither what is answered nor when tells whether somebody has the address.
async fn send_link(
    State(state): State<AppState>,
    ClientAddress(address): ClientAddress,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<EmailForm>,
) -> Result<ForgottenPage, PageError> {
    let email = form.email.trim();
    brakes::take_sign_in(&state, address, email).await?;
    accounts::ask_for_link(&state, email).await?;
    Ok(ForgottenPage { csrf: csrf.token().to_owned(), asked: true })
}
