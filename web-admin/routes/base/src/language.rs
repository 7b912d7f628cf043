//! The language of a page: chosen by the person, else by a cookie or the browser, else English.

use acts::error::Error;
use axum::extract::Request;
use axum::http::header::{ACCEPT_LANGUAGE, CONTENT_LANGUAGE, CONTENT_TYPE, COOKIE, VARY};
use axum::http::{HeaderMap, HeaderValue};
use axum::middleware::Next;
use axum::response::Response;
use tower_sessions::cookie::Cookie;
use words::Language;

/// Name of the cookie with the chosen language.
pub const LANGUAGE_COOKIE: &str = "stylet_language";

/// Sets the language of the cookie or, without one, of the browser.
pub async fn settle_language(request: Request, next: Next) -> Response {
    let language = wanted_language(request.headers());
    let mut response = answer_in_language(language, request, next).await;
    response.headers_mut().append(VARY, HeaderValue::from_static("accept-language, cookie"));
    response
}

/// Sets the language of a request, and declares it on the page.
pub async fn answer_in_language(language: Language, request: Request, next: Next) -> Response {
    let mut response = words::speaking(language, next.run(request)).await;
    let headers = response.headers_mut();
    let is_page = headers.get(CONTENT_TYPE).is_some_and(|kind| kind.as_bytes().starts_with(b"text/html"));
    if is_page && !headers.contains_key(CONTENT_LANGUAGE) {
        headers.insert(CONTENT_LANGUAGE, HeaderValue::from_static(language.code()));
    }
    response
}

fn wanted_language(headers: &HeaderMap) -> Language {
    let accepted = || Language::preferred(headers.get(ACCEPT_LANGUAGE)?.to_str().ok()?);
    language_cookie(headers).or_else(accepted).unwrap_or(Language::ENGLISH)
}

fn language_cookie(headers: &HeaderMap) -> Option<Language> {
    let all = headers.get_all(COOKIE).iter().filter_map(|header| header.to_str().ok());
    let mut cookies = all.flat_map(Cookie::split_parse).flatten();
    cookies.find(|cookie| cookie.name() == LANGUAGE_COOKIE).and_then(|cookie| Language::named(cookie.value()))
}

/// Returns the error for an unknown language code.
#[must_use]
pub fn refuse_language(code: &str) -> Error {
    let all: Vec<&str> = Language::all().map(Language::code).collect();
    Error::BadRequest(tr!("language: “{code}”; allowed: {all}", code = code, all = all.join(", ")))
}
