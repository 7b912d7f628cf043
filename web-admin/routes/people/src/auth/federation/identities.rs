//! `/account/identities`: the accounts of other systems that open the visitor's account.

use acts::auth::federation::flows::{self, NewFlow};
use acts::auth::federation::identities as joined;
use acts::error::Error;
use axum::extract::{Query, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use model::auth::federation::FlowPurpose;
use model::ids::{IdentityId, ProviderId};
use model::{CurrentPerson, PersonKey};
use pages::auth::federation::{IdentitiesPage, IdentityRow, ProviderChoice};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Browser, BrowserToken, Csrf, CsrfForm, NoFields, Visit, Visitor, start_session};
use routes_base::error::PageError;
use routes_base::forms::FormAnswer;
use serde::Deserialize;
use store::auth::federation::{identities, providers};
use store::people;

use super::entering::leave_for_provider;
use crate::auth::login::own_path;

const PAGE: &str = "/account/identities";

pub(super) async fn show_identities(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    csrf: Csrf,
    Query(query): Query<ProofForm>,
) -> Result<IdentitiesPage, PageError> {
    let page = make_page(&state, Visit::new(&person, &csrf), None).await?;
    Ok(IdentitiesPage { next: query.next, ..page })
}

/// Shows the page with the reason why nothing was changed.
pub(super) async fn show_conflict(state: &AppState, visit: Visit<'_>, why: String) -> Result<Response, PageError> {
    let page = make_page(state, visit, Some(why)).await?;
    Ok((StatusCode::CONFLICT, page).into_response())
}

async fn make_page(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    refused: Option<String>,
) -> Result<IdentitiesPage, Error> {
    let reader = state.db.reader();
    let row = |identity: identities::Identity| IdentityRow {
        remove_href: format!("{PAGE}/{}/remove", identity.id),
        provider: identity.provider.unwrap_or(identity.issuer),
        subject: identity.subject,
        how: identity.how,
        made: identity.made_at.to_utc(),
        used: identity.last_used_at.map(|at| at.to_utc()),
    };
    let offered = providers::list_providers(reader, person.school_id).await?;
    let offered = offered.into_iter().filter(|provider| provider.disabled_at.is_none());
    Ok(IdentitiesPage {
        shell: Shell::new(person, csrf.token(), NavPlace::Account),
        rows: identities::list_identities(reader, person.into()).await?.into_iter().map(row).collect(),
        providers: offered.map(|offered| ProviderChoice { id: offered.id, name: offered.settings.name }).collect(),
        next: String::new(),
        refused,
    })
}

pub(super) async fn begin_joining(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    token: BrowserToken,
    PathId(id): PathId<ProviderId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Response, PageError> {
    let new =
        NewFlow { browser_token: token.text(), purpose: FlowPurpose::Join, person_id: Some(person.id), next: PAGE };
    leave(&state, &person, id, new).await
}

#[derive(Deserialize)]
pub(super) struct ProofForm {
    #[serde(default)]
    next: String,
}

pub(super) async fn begin_proof(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    token: BrowserToken,
    PathId(id): PathId<ProviderId>,
    CsrfForm(form): CsrfForm<ProofForm>,
) -> Result<Response, PageError> {
    let next = if form.next.is_empty() { "/account" } else { own_path(&form.next) };
    let new = NewFlow { browser_token: token.text(), purpose: FlowPurpose::Prove, person_id: Some(person.id), next };
    leave(&state, &person, id, new).await
}

async fn leave(
    state: &AppState,
    person: &CurrentPerson,
    id: ProviderId,
    new: NewFlow<'_>,
) -> Result<Response, PageError> {
    let provider = flows::find_provider(state, id).await?;
    if provider.school_id != person.school_id {
        return Err(Error::NotFound.into());
    }
    leave_for_provider(state, &provider, new).await
}

pub(super) async fn remove_identity(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    browser: Browser,
    PathId(id): PathId<IdentityId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Response, PageError> {
    match joined::remove_identity(&state, &person, id).await {
        Ok(()) => {
            let key = PersonKey::from(&person);
            let known = people::find_person(state.db.reader(), key.person_id).await?.ok_or(Error::NotFound)?;
            start_session(&browser.session, known.id, known.credential_version, state.clock.now()).await?;
            Ok(FormAnswer::<IdentitiesPage>::lead_to(PAGE).into_response())
        }
        Err(Error::Conflict(why)) => show_conflict(&state, Visit::new(&person, &browser.csrf), why).await,
        Err(error) => Err(error.into()),
    }
}
