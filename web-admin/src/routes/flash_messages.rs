//! Flash messages: the page after a submitted form confirms it. A cookie carries the form's number
//! from the redirect to the next page and no further; it contains no user input.

use axum::extract::{MatchedPath, Request, State};
use axum::http::header::{CONTENT_TYPE, COOKIE, SET_COOKIE};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode};
use axum::middleware::Next;
use axum::response::Response;
use pages::flash_message::{FlashMessage, with_flash_message};
use routes_base::AppState;
use tower_sessions::cookie::{Cookie, SameSite};

const NAME: &str = "stylet_done";

/// Lifetime of the cookie, in s.
const KEPT_S: i64 = 60;

/// Sets the flash cookie when a form was accepted, and shows the message on the next page.
pub async fn show_flash_messages(State(state): State<AppState>, request: Request, next: Next) -> Response {
    let asked = request.extensions().get::<MatchedPath>().filter(|_| request.method() == Method::POST);
    let asked = asked.and_then(|path| FlashMessage::of_route(path.as_str()));
    let done = flash_message_of_cookie(request.headers()).filter(|_| request.method() == Method::GET);
    let mut response = match done {
        Some(done) => with_flash_message(done, next.run(request)).await,
        None => next.run(request).await,
    };
    let is_page = response.headers().get(CONTENT_TYPE).is_some_and(|kind| kind.as_bytes().starts_with(b"text/html"));
    if done.is_some() && is_page {
        set_cookie(&mut response, &state, "", 0);
    }
    if let Some(deed) = asked.filter(|_| response.status() == StatusCode::SEE_OTHER) {
        set_cookie(&mut response, &state, &deed.number().to_string(), KEPT_S);
    }
    response
}

fn flash_message_of_cookie(headers: &HeaderMap) -> Option<FlashMessage> {
    let all = headers.get_all(COOKIE).iter().filter_map(|header| header.to_str().ok());
    let mut cookies = all.flat_map(Cookie::split_parse).flatten();
    cookies
        .find(|cookie| cookie.name() == NAME)
        .and_then(|cookie| FlashMessage::of_number(cookie.value().parse().ok()?))
}

fn set_cookie(response: &mut Response, state: &AppState, value: &str, seconds: i64) {
    let cookie = Cookie::build((NAME, value))
        .path("/")
        .http_only(true)
        .same_site(SameSite::Lax)
        .secure(state.config.behind_tls)
        .max_age(time::Duration::seconds(seconds));
    if let Ok(cookie) = HeaderValue::from_str(&cookie.to_string()) {
        response.headers_mut().append(SET_COOKIE, cookie);
    }
}
