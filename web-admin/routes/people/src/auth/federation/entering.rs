//! `/sign-in`: leaving for a provider, and coming back from it.

use acts::auth::federation::flows::{self, FinishedFlow, NewFlow, ProviderAnswer};
use acts::auth::federation::{identities, sources};
use acts::auth::lti::launches;
use acts::auth::rate_limits;
use acts::error::Error;
use axum::extract::{Query, State};
use axum::http::{HeaderName, StatusCode, header};
use axum::response::{IntoResponse, Redirect, Response};
use model::auth::federation::{FlowPurpose, LocalPasswords};
use model::auth::sign_in_refusal::SignInRefusal;
use model::ids::{PlatformLinkId, ProviderId};
use model::{CurrentPerson, PersonKey, Role};
use pages::auth::federation::{ClaimsPage, LeavePage, ProviderButton, SignInRefusedPage};
use pages::school_time::on_school_clock;
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Browser, BrowserToken, CsrfForm, Visit, find_signed_in};
use routes_base::error::PageError;
use serde::Deserialize;
use store::auth::federation::providers;
use store::auth::federation::providers::SignInProvider;
use store::people;

use super::{identities as own_identities, joining};
use crate::auth::half;
use crate::auth::login::own_path;
use crate::auth::proving;

/// Maximum number of buttons on the sign-in page; with more schools, `?school=` selects one.
const MOST_BUTTONS: u32 = 20;

/// The buttons of the sign-in page.
pub(in crate::auth) struct Buttons {
    /// The buttons.
    pub providers: Vec<ProviderButton>,
    /// Whether passwords are for administrators only at every school with a button.
    pub folded: bool,
}

/// Returns the buttons of all schools, or of the one with a name.
pub(in crate::auth) async fn list_buttons(state: &AppState, school: Option<&str>) -> Result<Buttons, Error> {
    let offered = providers::list_offered_providers(state.db.reader(), school, MOST_BUTTONS).await?;
    let is_one_school = offered.windows(2).all(|pair| pair[0].school == pair[1].school);
    let is_folded = |rule: LocalPasswords| !rule.allow(Role::Trainee);
    Ok(Buttons {
        folded: is_one_school && offered.first().is_some_and(|first| is_folded(first.local_passwords)),
        providers: offered
            .into_iter()
            .map(|offered| ProviderButton {
                href: format!("/sign-in/{}", offered.id),
                name: offered.name,
                school: Some(offered.school).filter(|_| !is_one_school),
            })
            .collect(),
    })
}

#[derive(Deserialize)]
pub(super) struct NextForm {
    #[serde(default)]
    next: String,
}

pub(super) async fn begin_sign_in(
    State(state): State<AppState>,
    browser: Browser,
    token: BrowserToken,
    PathId(id): PathId<ProviderId>,
    CsrfForm(form): CsrfForm<NextForm>,
) -> Result<Response, PageError> {
    rate_limits::take_provider_sign_in(&state, browser.from).await?;
    let provider = flows::find_provider(&state, id).await?;
    let new = NewFlow {
        browser_token: token.text(),
        purpose: FlowPurpose::Enter,
        person_id: None,
        next: own_path(&form.next),
    };
    leave_for_provider(&state, &provider, new).await
}

/// Begins a sign-in and sends the browser to the provider.
pub(super) async fn leave_for_provider(
    state: &AppState,
    provider: &SignInProvider,
    new: NewFlow<'_>,
) -> Result<Response, PageError> {
    Ok(match flows::begin_flow(state, provider, new).await? {
        Ok(address) => leave_for(&provider.settings.name, address),
        Err(reason) => answer_refused(reason),
    })
}

/// Sends the browser to another system: by a page that refreshes itself, because browsers apply the
/// `form-action` of the policy to redirects after a form.
pub(in crate::auth) fn leave_for(name: &str, address: String) -> Response {
    const REFRESH: HeaderName = HeaderName::from_static("refresh");
    let rest = address.split_once("://").map_or("", |(_, rest)| rest);
    let host = rest.split(['/', '?']).next().unwrap_or_default().to_owned();
    let refresh = format!("0; url={address}");
    let page = LeavePage { provider: name.to_owned(), host, address };
    ([(REFRESH, refresh), (header::REFERRER_POLICY, "no-referrer".to_owned())], page).into_response()
}

/// Shows why a sign-in was refused.
pub(in crate::auth) fn answer_refused(reason: SignInRefusal) -> Response {
    let status = match reason {
        SignInRefusal::Unreachable => StatusCode::SERVICE_UNAVAILABLE,
        _ => StatusCode::FORBIDDEN,
    };
    (status, SignInRefusedPage { reason }).into_response()
}

#[derive(Deserialize)]
pub(super) struct AnswerQuery {
    #[serde(default)]
    state: String,
    code: Option<String>,
    iss: Option<String>,
    error: Option<String>,
}

pub(super) async fn finish_sign_in(
    State(state): State<AppState>,
    browser: Browser,
    token: BrowserToken,
    Query(query): Query<AnswerQuery>,
) -> Result<Response, PageError> {
    let answer = ProviderAnswer {
        state: &query.state,
        code: query.code.as_deref(),
        iss: query.iss.as_deref(),
        error: query.error.as_deref(),
        browser_token: token.sent(),
        from: browser.from,
    };
    match flows::finish_flow(&state, answer).await? {
        Err(reason) => Ok(answer_refused(reason)),
        Ok(finished) if finished.purpose == FlowPurpose::Enter => enter(&state, &browser, finished).await,
        Ok(finished) => {
            let signed_in = find_signed_in(&state, &browser.session).await?;
            let asking = signed_in.filter(|signed_in| Some(signed_in.person.id) == finished.person_id);
            let (person, zone) = asking.map(|asking| (asking.person, asking.time_zone)).unzip();
            on_school_clock(&zone.unwrap_or_default(), end_flow(&state, &browser, finished, person)).await
        }
    }
}

/// Ends a flow that was begun by a signed-in person: `person`, if they are still signed in in this
/// browser.
async fn end_flow(
    state: &AppState,
    browser: &Browser,
    finished: FinishedFlow,
    person: Option<CurrentPerson>,
) -> Result<Response, PageError> {
    match finished.purpose {
        FlowPurpose::Enter => enter(state, browser, finished).await,
        FlowPurpose::Join => join(state, browser, finished, person).await,
        FlowPurpose::Prove => prove(state, browser, finished, person).await,
        FlowPurpose::Try => show_claims(browser, finished, person),
    }
}

async fn enter(state: &AppState, browser: &Browser, finished: FinishedFlow) -> Result<Response, PageError> {
    let FinishedFlow { provider, identity, next, .. } = finished;
    match identities::find_owner(state, &(&provider).into(), &identity).await? {
        Err(reason) => Ok(answer_refused(reason)),
        Ok(None) => {
            joining::hold_identity(state, &browser.session, &(&provider).into(), identity, &next).await?;
            Ok(Redirect::to("/sign-in/join").into_response())
        }
        Ok(Some(person)) => {
            let factor = half::FirstFactor::Provider { is_second_too: identity.has_second_factor };
            let to = half::enter_session(state, &browser.session, &person, &next, factor).await?;
            Ok(Redirect::to(&to).into_response())
        }
    }
}

/// Adds the identity to the account that has asked for it.
async fn join(
    state: &AppState,
    browser: &Browser,
    finished: FinishedFlow,
    person: Option<CurrentPerson>,
) -> Result<Response, PageError> {
    let FinishedFlow { provider, identity, .. } = finished;
    let Some(person) = person else {
        sources::note_refusal(state, &(&provider).into(), SignInRefusal::NoFlow).await?;
        return Ok(answer_refused(SignInRefusal::NoFlow));
    };
    match identities::join_account(state, &(&provider).into(), &identity, person.id).await {
        Ok(()) => Ok(Redirect::to("/account/identities").into_response()),
        Err(Error::Conflict(why)) => {
            own_identities::show_conflict(state, Visit::new(&person, &browser.csrf), why).await
        }
        Err(error) => Err(error.into()),
    }
}

/// Records in the session that the person has confirmed who they are.
async fn prove(
    state: &AppState,
    browser: &Browser,
    finished: FinishedFlow,
    person: Option<CurrentPerson>,
) -> Result<Response, PageError> {
    let FinishedFlow { provider, identity, next, .. } = finished;
    let is_theirs = match person {
        Some(person) => match identities::find_owner(state, &(&provider).into(), &identity).await? {
            Ok(Some(owner)) => owner.id == person.id,
            Ok(None) | Err(_) => false,
        },
        None => false,
    };
    if !is_theirs {
        sources::note_refusal(state, &(&provider).into(), SignInRefusal::Subject).await?;
        return Ok(answer_refused(SignInRefusal::Subject));
    }
    proving::hold_proof(state, &browser.session).await?;
    Ok(Redirect::to(own_path(&next)).into_response())
}

fn show_claims(
    browser: &Browser,
    finished: FinishedFlow,
    person: Option<CurrentPerson>,
) -> Result<Response, PageError> {
    let FinishedFlow { provider, identity, claims, .. } = finished;
    let person = person.ok_or(Error::NotFound)?;
    let visit = Visit::new(&person, &browser.csrf);
    let page = ClaimsPage {
        shell: Shell::new(visit.person, visit.csrf.token(), NavPlace::Administration),
        provider: provider.settings.name,
        identity,
        claims: claims.0.into_iter().map(|(name, value)| (name, value.to_string())).collect(),
    };
    Ok(page.into_response())
}

/// Signs a person in whom a provider has confirmed, after their identity was joined.
pub(super) async fn enter_joined(
    state: &AppState,
    browser: &Browser,
    person: PersonKey,
    held: &joining::HeldIdentity,
) -> Result<Response, PageError> {
    let link = browser.session.get::<Option<PlatformLinkId>>(joining::HELD_LINK).await.map_err(Error::from)?;
    if let Some(link) = link.flatten() {
        launches::note_user(state, link, person, &held.identity.subject).await?;
    }
    let person = people::find_person(state.db.reader(), person.person_id).await?.ok_or(Error::NotFound)?;
    let factor = half::FirstFactor::Provider { is_second_too: held.identity.has_second_factor };
    let to = half::enter_session(state, &browser.session, &person, &held.next, factor).await?;
    Ok(Redirect::to(&to).into_response())
}
