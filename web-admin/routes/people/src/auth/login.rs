//! The sign-in page, and signing out.

use std::net::IpAddr;
use std::thread;

use acts::auth::rate_limits;
use acts::auth::signing_in::{note_refused_sign_in, note_way_in};
use acts::error::Error;
use acts::people::accounts;
use axum::extract::{Query, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Redirect, Response};
use pages::auth::login::LoginPage;
use platform::secret;
use routes_base::auth::{
    CheckedForm, ClientAddress, Csrf, CsrfForm, NoFields, SignInStanding, Visitor, person_of, refuse_form, standing_of,
};
use routes_base::error::{PageError, finish_answer, status_of};
use routes_base::{AppState, Routes, get, post};
use serde::Deserialize;
use store::auth::federation::providers;
use store::people::{self, Credentials};
use tower_sessions::Session;

use crate::auth::federation::{self, Buttons};
use crate::auth::half::{self, FirstFactor};
use crate::auth::join;

/// Returns the public routes of `/login` and of password recovery.
#[must_use]
pub fn sign_in_routes() -> Routes {
    Routes::new()
        .route("/login", get(show_sign_in).merge(post(sign_in)))
        .merge(half::code_routes())
        .merge(join::password_routes())
}

/// Returns the route of `/logout`, for signed-in people.
#[must_use]
pub fn signed_in_routes() -> Routes {
    Routes::new().route("/logout", post(sign_out_browser))
}

#[derive(Deserialize)]
struct NextQuery {
    #[serde(default)]
    next: String,
    school: Option<String>,
}

async fn show_sign_in(
    State(state): State<AppState>,
    session: Session,
    csrf: Csrf,
    Query(query): Query<NextQuery>,
) -> Result<Response, PageError> {
    if !matches!(standing_of(&state, &session).await?, SignInStanding::Stranger) {
        return Ok(Redirect::to(own_path(&query.next)).into_response());
    }
    let Buttons { providers, folded } = federation::list_buttons(&state, query.school.as_deref()).await?;
    let (csrf, next) = (csrf.token().to_owned(), own_path(&query.next).to_owned());
    let school = query.school.unwrap_or_default();
    Ok(LoginPage { error: None, email: String::new(), school, csrf, next, providers, folded }.into_response())
}

#[derive(Deserialize)]
pub(super) struct LoginForm {
    pub email: String,
    pub password: String,
    #[serde(default)]
    next: String,
    /// Name of the school whose account is meant; empty if any with the address may be.
    #[serde(default)]
    pub school: String,
}

impl LoginForm {
    fn school(&self) -> Option<&str> {
        Some(&*self.school).filter(|school| !school.is_empty())
    }
}

async fn sign_in(
    State(state): State<AppState>,
    session: Session,
    csrf: Csrf,
    ClientAddress(address): ClientAddress,
    CheckedForm { form, is_genuine }: CheckedForm<LoginForm>,
) -> Result<Response, PageError> {
    if !is_genuine {
        return leave_stale_form(&state, &session, &csrf, &form).await;
    }
    let known = match check_credentials(&state, address, &form).await {
        Err(why @ (Error::Unauthorized | Error::TooMany { .. } | Error::Crowded { .. })) => {
            return show_sign_in_again(&state, &csrf, &form, why).await;
        }
        checked => checked?,
    };
    rate_limits::welcome(&state, address, known.id).await?;
    let person = people::find_person(state.db.reader(), known.id).await?.ok_or(Error::NotFound)?;
    if !providers::find_local_passwords(state.db.reader(), person.school_id).await?.allow(person.role) {
        let why = tr!("your school asks you to sign in with its own account").to_owned();
        return show_sign_in_again(&state, &csrf, &form, Error::Conflict(why)).await;
    }
    let to = match known.initial_until {
        Some(until) if until <= state.clock.now() => {
            return show_sign_in_again(&state, &csrf, &form, refuse_outworn_password()).await;
        }
        Some(_) => accounts::use_initial_password(&state, &person).await?,
        None => half::enter_session(&state, &session, &person, &form.next, FirstFactor::Password).await?,
    };
    Ok(Redirect::to(&to).into_response())
}

/// Answers a stale sign-in form: redirects if the same person has signed in in another tab, and
/// shows the form again to anonymous visitors. If another person is signed in, the session may have
/// been planted, so it is not entered silently.
async fn leave_stale_form(
    state: &AppState,
    session: &Session,
    csrf: &Csrf,
    form: &LoginForm,
) -> Result<Response, PageError> {
    if let Some(person) = person_of(state, session).await? {
        let named = people::find_member_by_email(state.db.reader(), person.school_id, &form.email).await?;
        let is_theirs = named.is_some_and(|named| named.id == person.id);
        return if is_theirs {
            Ok(Redirect::to(own_path(&form.next)).into_response())
        } else {
            Err(refuse_form().into())
        };
    }
    let why = tr!("Not signed in: the form was out of date. Enter your address and password again.");
    let page = make_login_page(state, csrf, form, why.to_owned()).await?;
    Ok((StatusCode::FORBIDDEN, page).into_response())
}

/// Returns the error for an expired one-time password.
fn refuse_outworn_password() -> Error {
    let why = tr!(
        "this password was created for a single sign-in and has expired: request a link below, and choose your own password"
    );
    Error::Expired(why.to_owned())
}

/// Returns the credentials if address and password match; counts the attempt, and records a refused
/// one.
///
/// # Errors
/// Returns [`Error::Unauthorized`] if they do not match, [`Error::TooMany`] or [`Error::Crowded`]
/// after too many attempts.
pub(super) async fn check_credentials(
    state: &AppState,
    address: IpAddr,
    form: &LoginForm,
) -> Result<Credentials, Error> {
    let accounts = people::list_credentials(state.db.reader(), &form.email, form.school()).await?;
    let ids = accounts.iter().map(|account| account.id).collect();
    let reach = match rate_limits::take_sign_in(state, address, &form.email, ids).await {
        Err(refused) => {
            if matches!(refused, Error::TooMany { .. }) && state.rate_limit_log.is_worth_noting(address) {
                note_refused_sign_in(state, &form.email, address, "sign_in.blocked").await?;
            }
            return Err(refused);
        }
        Ok(reach) => reach,
    };
    let accounts = accounts.into_iter().filter(|account| reach.accounts.contains(&account.id)).collect();
    match find_fitting(state, accounts, &form.password, reach.is_known).await? {
        Some(known) => Ok(known),
        None => {
            note_refused_sign_in(state, &form.email, address, "sign_in.failed").await?;
            Err(Error::Unauthorized)
        }
    }
}

/// Returns the account that a password fits. Takes the same time for an unknown address as for a wrong password;
/// the passwords of several accounts are compared at once, so that the time does not give their number.
async fn find_fitting(
    state: &AppState,
    accounts: Vec<Credentials>,
    password: &str,
    is_known: bool,
) -> Result<Option<Credentials>, Error> {
    let (password, cost) = (password.to_owned(), state.config.password_cost);
    let check = move || -> anyhow::Result<Option<Credentials>> {
        if accounts.iter().all(|account| account.password_hash.is_none()) {
            return secret::hash_password(&password, cost).map(|_| None);
        }
        let fits = |account: &Credentials| {
            account.password_hash.as_deref().is_some_and(|hash| secret::password_fits(&password, hash))
        };
        let fitting: Vec<bool> = thread::scope(|scope| {
            let checks: Vec<_> = accounts.iter().map(|account| scope.spawn(|| fits(account))).collect();
            checks.into_iter().map(|check| check.join().is_ok_and(|fits| fits)).collect()
        });
        let mut fitting = accounts.into_iter().zip(fitting).filter(|(_, fits)| *fits).map(|(account, _)| account);
        Ok(fitting.find(|account| account.disabled_at.is_none()))
    };
    Ok(match is_known {
        true => state.hash(check).await??,
        false => state.hash_for_stranger(check).await??,
    })
}

/// Shows the sign-in page again with the reason for the refusal.
async fn show_sign_in_again(
    state: &AppState,
    csrf: &Csrf,
    form: &LoginForm,
    why: Error,
) -> Result<Response, PageError> {
    let words = match &why {
        Error::Unauthorized => tr!("The address or the password is wrong.").to_owned(),
        other => tr!("Not signed in: {why}.", why = other.said()),
    };
    let page = make_login_page(state, csrf, form, words).await?;
    Ok(finish_answer(&why, (status_of(&why), page).into_response()))
}

async fn make_login_page(state: &AppState, csrf: &Csrf, form: &LoginForm, error: String) -> Result<LoginPage, Error> {
    let Buttons { providers, folded } = federation::list_buttons(state, form.school()).await?;
    Ok(LoginPage {
        error: Some(error),
        email: form.email.clone(),
        school: form.school.clone(),
        csrf: csrf.token().to_owned(),
        next: own_path(&form.next).to_owned(),
        providers,
        folded,
    })
}

/// Signs out: deletes the session on the server and in the browser.
async fn sign_out_browser(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    session: Session,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    session.flush().await?;
    note_way_in(&state, person.id, "person.signed_out").await?;
    Ok(Redirect::to("/login"))
}

/// Maximum length of a path to open after signing in, in bytes: longer than any of this site.
const LONGEST_PATH: usize = 500;

/// Returns `next` if it is a path of this site, else `/`: browsers resolve `//host` and `/\host`
/// to other sites.
pub(crate) fn own_path(next: &str) -> &str {
    let is_short = next.len() <= LONGEST_PATH;
    let plain = is_short && next.bytes().all(|b| b.is_ascii_alphanumeric() || b"/-_.~".contains(&b));
    if plain && next.starts_with('/') && !next.starts_with("//") { next } else { "/" }
}

#[cfg(test)]
mod tests {
    use super::own_path;

    #[test]
    fn nobody_is_sent_elsewhere() {
        assert_eq!(own_path("/sessions/1"), "/sessions/1");
        for elsewhere in ["//evil.example", "/\\evil.example", "https://evil.example", "", "evil", "/a?b=//c"] {
            assert_eq!(own_path(elsewhere), "/", "{elsewhere}");
        }
    }
}
