//! `/lti/register`: a learning platform asks to be registered, and an administrator decides.

use acts::auth::lti::registration;
use acts::auth::lti::registration::AskingPlatform;
use acts::error::Error;
use axum::extract::{Query, State};
use axum::http::header::CONTENT_SECURITY_POLICY;
use axum::http::{HeaderMap, HeaderName};
use axum::response::{IntoResponse, Response};
use model::auth::lti::web_origin;
use model::auth::platform_registration::RegistrationInitiation;
use model::{CurrentPerson, Role};
use pages::auth::platform_registration::{
    AskedRegistration, OpenRegistrationPage, RegisterPlatformPage, RegisteredPlatformPage, SignInToRegisterPage,
};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::auth::{Administrator, Csrf, CsrfForm, Visit, person_of};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use serde::Deserialize;
use tower_sessions::Session;

use super::launching::{allow_framing, is_framed};

/// Keeps the connection to the platform's window, which the last page asks to close this one.
const OPENER_POLICY: (HeaderName, &str) = (HeaderName::from_static("cross-origin-opener-policy"), "unsafe-none");

pub(super) async fn show_registration(
    State(state): State<AppState>,
    session: Session,
    csrf: Csrf,
    headers: HeaderMap,
    Query(asked): Query<RegistrationInitiation>,
) -> Result<Response, PageError> {
    if is_framed(&headers) {
        // In a frame the browser sends no cookie of a session.
        let ancestors = web_origin(&asked.openid_configuration);
        let policy = [(CONTENT_SECURITY_POLICY, allow_framing(ancestors))];
        return Ok((policy, OpenRegistrationPage { asked }).into_response());
    }
    let answer = match person_of(&state, &session).await? {
        None => SignInToRegisterPage {}.into_response(),
        Some(person) if person.role == Role::Administrator => {
            answer_page(&state, Visit::new(&person, &csrf), asked, None).await?
        }
        Some(_) => return Err(Error::Forbidden(tr!("this page is for administrators")).into()),
    };
    Ok(([OPENER_POLICY], answer).into_response())
}

/// Shows what will be stored, or why it cannot be.
async fn answer_page(
    state: &AppState,
    visit: Visit<'_>,
    asked: RegistrationInitiation,
    refused: Option<String>,
) -> Result<Response, Error> {
    let read = split_refusal(registration::read_configuration(state, visit.person, &asked).await)?;
    let (platform, unreadable) = match read {
        Ok(platform) => (Some(describe(platform)), None),
        Err(why) => (None, Some(why)),
    };
    let refused = unreadable.or(refused);
    let shell = make_shell(visit.person, visit.csrf);
    let page = RegisterPlatformPage { shell, asked, platform, refused };
    Ok(if page.refused.is_some() { FormAnswer::Refused(page).into_response() } else { page.into_response() })
}

fn make_shell(person: &CurrentPerson, csrf: &Csrf) -> Shell {
    Shell::new(person, csrf.token(), NavPlace::Administration)
}

fn describe(asking: AskingPlatform) -> AskedRegistration {
    let settings = asking.configuration.settings("");
    AskedRegistration { registration_url: asking.configuration.registration_endpoint, digest: asking.digest, settings }
}

#[derive(Deserialize)]
pub(super) struct RegistrationForm {
    #[serde(flatten)]
    asked: RegistrationInitiation,
    #[serde(default)]
    digest: String,
}

pub(super) async fn register_platform(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    CsrfForm(RegistrationForm { asked, digest }): CsrfForm<RegistrationForm>,
) -> Result<Response, PageError> {
    let registered = split_refusal(registration::register_platform(&state, &person, &asked, &digest).await)?;
    let answer = match registered {
        Ok(id) => RegisteredPlatformPage { href: format!("/admin/platforms/{id}") }.into_response(),
        Err(why) => answer_page(&state, Visit::new(&person, &csrf), asked, Some(why)).await?,
    };
    Ok(([OPENER_POLICY], answer).into_response())
}
