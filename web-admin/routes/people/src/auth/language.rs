//! `/language`: the choice of a language before signing in.

use axum::extract::State;
use axum::http::HeaderValue;
use axum::http::header::SET_COOKIE;
use axum::response::{IntoResponse, Redirect, Response};
use routes_base::AppState;
use routes_base::auth::CsrfForm;
use routes_base::error::PageError;
use routes_base::language::{LANGUAGE_COOKIE, refuse_language};
use serde::Deserialize;
use tower_sessions::cookie::{Cookie, SameSite};
use words::Language;

use crate::auth::login::own_path;

/// Lifetime of the cookie with the choice.
const KEPT: time::Duration = time::Duration::days(365);

#[derive(Deserialize)]
pub(super) struct LanguageChoice {
    language: String,
    #[serde(default)]
    next: String,
}

pub(super) async fn choose_language(
    State(state): State<AppState>,
    CsrfForm(choice): CsrfForm<LanguageChoice>,
) -> Result<Response, PageError> {
    let language: Language = choice.language.parse().map_err(|_| refuse_language(&choice.language))?;
    let cookie = Cookie::build((LANGUAGE_COOKIE, language.code()))
        .path("/")
        .http_only(true)
        .same_site(SameSite::Lax)
        .secure(state.config.behind_tls)
        .max_age(KEPT);
    let cookie = HeaderValue::from_str(&cookie.to_string()).map_err(anyhow::Error::from)?;
    Ok(([(SET_COOKIE, cookie)], Redirect::to(&format!("/login?next={}", own_path(&choice.next)))).into_response())
}
