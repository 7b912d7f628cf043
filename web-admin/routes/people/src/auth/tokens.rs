//! `/account/tokens`: the visitor's own tokens for programs.

use acts::auth::tokens::TokenRequest;
use acts::auth::{rate_limits, tokens};
use acts::error::Error;
use axum::extract::State;
use axum::response::{IntoResponse, Redirect};
use model::CurrentPerson;
use model::ids::TokenId;
use pages::auth::tokens::{MadeTokenPage, TokenFields, TokenRow, TokensPage};
use pages::form::FilledForm;
use pages::{NavPlace, Shell};
use routes_base::addresses::PathId;
use routes_base::auth::{Browser, CsrfForm, NoFields, Visitor};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use routes_base::{AppState, Routes, get, post};
use serde::Deserialize;
use store::auth::tokens as stored;

use crate::auth::proving;

/// Preselected lifetime of a token, in days.
const DEFAULT_DAYS: i64 = 90;

pub(super) fn token_routes() -> Routes {
    Routes::new()
        .route("/account/tokens", get(show_tokens).merge(post(make_token)))
        .route("/account/tokens/{id}/revoke", post(revoke_token))
}

async fn show_tokens(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    browser: Browser,
) -> Result<TokensPage, PageError> {
    let blank = FilledForm::new(TokenFields { name: String::new(), days: DEFAULT_DAYS });
    Ok(make_tokens_page(&state, &person, &browser, blank).await?)
}

async fn make_tokens_page(
    state: &AppState,
    person: &CurrentPerson,
    browser: &Browser,
    form: FilledForm<TokenFields>,
) -> Result<TokensPage, Error> {
    let now = state.clock.now();
    let row = |token: stored::OwnToken| TokenRow {
        name: token.name,
        made: token.created_at.to_utc(),
        used: token.last_seen_at.map(|at| at.to_utc()),
        expires: token.expires_at.map(|at| at.to_utc()),
        ended: token.expires_at.is_some_and(|end| end <= now),
        revoke_href: format!("/account/tokens/{}/revoke", token.id),
    };
    let tokens = stored::list_tokens_of_person(state.db.reader(), person.into()).await?;
    Ok(TokensPage {
        shell: Shell::new(person, browser.csrf.token(), NavPlace::Account),
        rows: tokens.into_iter().map(row).collect(),
        form,
        own_password: proving::find_own_password(state, person, &browser.session).await?,
    })
}

#[derive(Deserialize)]
struct TokenForm {
    name: String,
    days: i64,
    #[serde(default)]
    password: String,
}

/// Creates a token and renders it directly: with a redirect it would have to be stored until it is
/// shown.
async fn make_token(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    browser: Browser,
    CsrfForm(form): CsrfForm<TokenForm>,
) -> Result<FormAnswer<TokensPage>, PageError> {
    rate_limits::take_own(&state, person.id).await?;
    let made = match proving::check_proof(&state, &person, &browser.session, &form.password).await? {
        Ok(()) => tokens::make(&state, &person, TokenRequest { name: &form.name, days: form.days }).await,
        Err(own) => Err(Error::Unprocessable(proving::explain_missing_proof(own))),
    };
    match split_refusal(made)? {
        Ok(made) => {
            let shell = Shell::new(&person, browser.csrf.token(), NavPlace::Account);
            let expires = made.expires_at.to_utc();
            let page = MadeTokenPage { shell, name: made.name, token: made.token, expires };
            Ok(FormAnswer::Answered(page.into_response()))
        }
        Err(why) => {
            let form = FilledForm::refused(TokenFields { name: form.name, days: form.days }, why);
            Ok(FormAnswer::Refused(make_tokens_page(&state, &person, &browser, form).await?))
        }
    }
}

async fn revoke_token(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<TokenId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    match tokens::revoke(&state, &person, id).await? {
        true => Ok(Redirect::to("/account/tokens")),
        false => Err(Error::NotFound.into()),
    }
}
