//! `/lti`: leaving for a learning platform, and coming back from it.

use std::net::IpAddr;

use acts::auth::federation::identities;
use acts::auth::federation::sources::IdentitySource;
use acts::auth::lti::launches::{self, ConfirmedLaunch, LAUNCH_S, LaunchAnswer, LaunchOutcome};
use acts::auth::rate_limits;
use acts::error::Error;
use axum::extract::{Query, State};
use axum::http::header::{CONTENT_SECURITY_POLICY, COOKIE, SET_COOKIE};
use axum::http::{HeaderMap, HeaderValue};
use axum::response::{IntoResponse, Redirect, Response};
use model::PersonKey;
use model::auth::lti::LoginInitiation;
use pages::auth::lti::OpenWindowPage;
use routes_base::AppState;
use routes_base::auth::{ClientAddress, OpenForm};
use routes_base::error::PageError;
use serde::Deserialize;
use store::auth::lti::platforms::Platform;
use tower_sessions::Session;
use tower_sessions::cookie::{Cookie, SameSite};

use crate::auth::federation::{HELD_LINK, answer_refused, hold_identity, leave_for};
use crate::auth::half;

pub(super) async fn begin_by_link(
    State(state): State<AppState>,
    ClientAddress(from): ClientAddress,
    headers: HeaderMap,
    Query(asked): Query<LoginInitiation>,
) -> Result<Response, PageError> {
    begin_launch(&state, from, &headers, asked).await
}

pub(super) async fn begin_by_form(
    State(state): State<AppState>,
    ClientAddress(from): ClientAddress,
    headers: HeaderMap,
    OpenForm(asked): OpenForm<LoginInitiation>,
) -> Result<Response, PageError> {
    begin_launch(&state, from, &headers, asked).await
}

async fn begin_launch(
    state: &AppState,
    from: IpAddr,
    headers: &HeaderMap,
    asked: LoginInitiation,
) -> Result<Response, PageError> {
    let platform = match launches::find_initiator(state, &asked).await? {
        Ok(platform) => platform,
        Err(reason) => return Ok(answer_refused(reason)),
    };
    if is_framed(headers) {
        return Ok(answer_in_frame(platform, asked));
    }
    rate_limits::take_launch_start(state, from).await?;
    match launches::begin_launch(state, &platform, &asked).await? {
        Ok(start) => {
            let mut response = leave_for(&platform.settings.name, start.address);
            set_cookie(&mut response, &start.state, &start.browser_token, LAUNCH_S);
            Ok(response)
        }
        Err(reason) => Ok(answer_refused(reason)),
    }
}

/// Whether the response is shown in a frame, where browsers may block cookies.
pub(super) fn is_framed(headers: &HeaderMap) -> bool {
    headers.get("sec-fetch-dest").is_some_and(|target| ["iframe", "frame"].iter().any(|frame| target == frame))
}

/// Returns the policy of a page that another origin may show in a frame.
pub(super) fn allow_framing(origin: Option<String>) -> String {
    let ancestors = origin.unwrap_or_else(|| "'none'".to_owned());
    format!(
        "default-src 'none'; style-src 'self'; script-src 'self'; img-src 'self' data:; form-action 'self'; \
         frame-ancestors {ancestors}; base-uri 'none'"
    )
}

/// Shows the page that opens a window, the only one that the platform may show in a frame.
fn answer_in_frame(platform: Platform, asked: LoginInitiation) -> Response {
    let policy = allow_framing(platform.settings.frame_origin());
    let page = OpenWindowPage { platform: platform.settings.name, asked };
    ([(CONTENT_SECURITY_POLICY, policy)], page).into_response()
}

/// Returns the name of the cookie of a launch: several may be under way in one browser.
fn cookie_name(state: &str) -> String {
    format!("__Host-lti-{}", state.get(..8).unwrap_or_default())
}

/// Sets the cookie of a launch. The platform's form comes from another site, so the cookie cannot be
/// `SameSite=Lax`.
fn set_cookie(response: &mut Response, state: &str, token: &str, seconds: i64) {
    let cookie = Cookie::build((cookie_name(state), token))
        .path("/")
        .http_only(true)
        .secure(true)
        .same_site(SameSite::None)
        .partitioned(true)
        .max_age(time::Duration::seconds(seconds));
    if let Ok(cookie) = HeaderValue::from_str(&cookie.to_string()) {
        response.headers_mut().append(SET_COOKIE, cookie);
    }
}

fn sent_token(headers: &HeaderMap, state: &str) -> Option<String> {
    let name = cookie_name(state);
    let all = headers.get_all(COOKIE).iter().filter_map(|header| header.to_str().ok());
    let mut cookies = all.flat_map(Cookie::split_parse).flatten();
    Some(cookies.find(|cookie| cookie.name() == name)?.value().to_owned())
}

#[derive(Deserialize)]
pub(super) struct LaunchForm {
    #[serde(default)]
    state: String,
    id_token: Option<String>,
    error: Option<String>,
}

pub(super) async fn finish_launch(
    State(state): State<AppState>,
    session: Session,
    ClientAddress(from): ClientAddress,
    headers: HeaderMap,
    OpenForm(form): OpenForm<LaunchForm>,
) -> Result<Response, PageError> {
    // In a frame the session's cookie would be lost, too.
    let browser_token = sent_token(&headers, &form.state).filter(|_| !is_framed(&headers));
    let answer = LaunchAnswer {
        state: &form.state,
        id_token: form.id_token.as_deref(),
        error: form.error.as_deref(),
        browser_token: browser_token.as_deref(),
        from,
    };
    let mut response = match launches::finish_launch(&state, answer).await? {
        Ok(LaunchOutcome::Confirmed(confirmed)) => enter(&state, &session, *confirmed).await?,
        Ok(LaunchOutcome::Again(again)) => {
            let (platform, asked) = *again;
            answer_in_frame(platform, asked)
        }
        Err(reason) => answer_refused(reason),
    };
    if browser_token.is_some() {
        set_cookie(&mut response, &form.state, "", 0);
    }
    Ok(response)
}

/// Signs in the user whom a platform has confirmed, or lets them join an account.
async fn enter(state: &AppState, session: &Session, confirmed: ConfirmedLaunch) -> Result<Response, PageError> {
    let ConfirmedLaunch { platform, identity, page, link } = confirmed;
    let source = IdentitySource::from(&platform);
    match identities::find_owner(state, &source, &identity).await? {
        Err(reason) => Ok(answer_refused(reason)),
        Ok(None) => {
            hold_identity(state, session, &source, identity, &page).await?;
            session.insert(HELD_LINK, link).await.map_err(Error::from)?;
            Ok(Redirect::to("/sign-in/join").into_response())
        }
        Ok(Some(person)) => {
            if let Some(link) = link {
                let key = PersonKey { school_id: person.school_id, person_id: person.id };
                launches::note_user(state, link, key, &identity.subject).await?;
            }
            let factor = half::FirstFactor::Provider { is_second_too: false };
            let to = half::enter_session(state, session, &person, &page, factor).await?;
            Ok(Redirect::to(&to).into_response())
        }
    }
}
