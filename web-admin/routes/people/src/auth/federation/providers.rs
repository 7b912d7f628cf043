//! `/admin/sign-in`: the providers of the school.

use acts::auth::federation::client_keys;
use acts::auth::federation::flows::{self, NewFlow};
use acts::auth::federation::providers as settling;
use acts::error::Error;
use axum::extract::State;
use axum::response::{Redirect, Response};
use model::CurrentPerson;
use model::auth::federation::{FlowPurpose, LocalPasswords};
use model::ids::ProviderId;
use pages::auth::federation::{ProviderForm, ProviderPage, ProviderRow, ProvidersPage};
use pages::form::FilledForm;
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Administrator, BrowserToken, Csrf, CsrfForm, NoFields, Visit};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use serde::Deserialize;
use store::auth::federation::providers;
use store::auth::federation::providers::SignInProvider;

use super::entering::leave_for_provider;

const PAGE: &str = "/admin/sign-in";

pub(super) async fn show_providers(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
) -> Result<ProvidersPage, PageError> {
    Ok(make_page(&state, Visit::new(&person, &csrf), FilledForm::default()).await?)
}

async fn make_page(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    form: FilledForm<ProviderForm>,
) -> Result<ProvidersPage, Error> {
    let reader = state.db.reader();
    let row = |provider: SignInProvider| ProviderRow {
        href: format!("{PAGE}/{}", provider.id),
        name: provider.settings.name,
        issuer: provider.settings.issuer,
        disabled: provider.disabled_at.is_some(),
    };
    Ok(ProvidersPage {
        shell: Shell::new(person, csrf.token(), NavPlace::Administration),
        rows: providers::list_providers(reader, person.school_id).await?.into_iter().map(row).collect(),
        form,
        redirect_uri: flows::redirect_uri(state),
        keys_uri: client_keys::keys_uri(state),
        local: providers::find_local_passwords(reader, person.school_id).await?,
        local_refused: None,
    })
}

/// The form of a provider, with the secret, which is never shown again.
#[derive(Deserialize)]
pub(super) struct SentProvider {
    #[serde(flatten)]
    fields: ProviderForm,
    #[serde(default)]
    client_secret: String,
}

pub(super) async fn add_provider(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    CsrfForm(SentProvider { fields, client_secret }): CsrfForm<SentProvider>,
) -> Result<FormAnswer<ProvidersPage>, PageError> {
    let added = match fields.read() {
        Ok(settings) => split_refusal(settling::add_provider(&state, &person, &settings, &client_secret).await)?,
        Err(why) => Err(why),
    };
    match added {
        Ok(_) => Ok(FormAnswer::lead_to(PAGE)),
        Err(why) => {
            let form = FilledForm::refused(fields, why);
            Ok(FormAnswer::Refused(make_page(&state, Visit::new(&person, &csrf), form).await?))
        }
    }
}

async fn find(state: &AppState, person: &CurrentPerson, id: ProviderId) -> Result<SignInProvider, Error> {
    providers::find_provider(state.db.reader(), person.school_id, id).await?.ok_or(Error::NotFound)
}

fn make_provider_page(
    state: &AppState,
    visit: Visit<'_>,
    known: &SignInProvider,
    form: FilledForm<ProviderForm>,
) -> ProviderPage {
    ProviderPage {
        shell: Shell::new(visit.person, visit.csrf.token(), NavPlace::Administration),
        title: known.settings.name.clone(),
        href: format!("{PAGE}/{}", known.id),
        form,
        keys_uri: client_keys::keys_uri(state),
    }
}

pub(super) async fn show_provider(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    PathId(id): PathId<ProviderId>,
) -> Result<ProviderPage, PageError> {
    let visit = Visit::new(&person, &csrf);
    let known = find(&state, &person, id).await?;
    let form = FilledForm::new(ProviderForm::from(&known.settings));
    Ok(make_provider_page(&state, visit, &known, form))
}

pub(super) async fn change_provider(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    PathId(id): PathId<ProviderId>,
    CsrfForm(SentProvider { fields, client_secret }): CsrfForm<SentProvider>,
) -> Result<FormAnswer<ProviderPage>, PageError> {
    let visit = Visit::new(&person, &csrf);
    let known = find(&state, &person, id).await?;
    let changed = match fields.read() {
        Ok(settings) => {
            split_refusal(settling::change_provider(&state, &person, &known, &settings, &client_secret).await)?
        }
        Err(why) => Err(why),
    };
    match changed {
        Ok(()) => Ok(FormAnswer::lead_to(PAGE)),
        Err(why) => {
            Ok(FormAnswer::Refused(make_provider_page(&state, visit, &known, FilledForm::refused(fields, why))))
        }
    }
}

/// Shows what the provider says of the administrator, without signing anybody in.
pub(super) async fn try_provider(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    token: BrowserToken,
    PathId(id): PathId<ProviderId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Response, PageError> {
    let known = find(&state, &person, id).await?;
    let new =
        NewFlow { browser_token: token.text(), purpose: FlowPurpose::Try, person_id: Some(person.id), next: PAGE };
    leave_for_provider(&state, &known, new).await
}

pub(super) async fn disable_provider(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    PathId(id): PathId<ProviderId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    settling::set_disabled(&state, &person, id, true).await?;
    Ok(Redirect::to(PAGE))
}

pub(super) async fn enable_provider(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    PathId(id): PathId<ProviderId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    settling::set_disabled(&state, &person, id, false).await?;
    Ok(Redirect::to(PAGE))
}

#[derive(Deserialize)]
pub(super) struct LocalForm {
    local: String,
}

pub(super) async fn set_local_passwords(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<LocalForm>,
) -> Result<FormAnswer<ProvidersPage>, PageError> {
    let rule = LocalPasswords::of_word(&form.local).ok_or_else(|| {
        let allowed = LocalPasswords::ALL.map(LocalPasswords::word).join(", ");
        Error::BadRequest(format!("local: \"{}\"; allowed: {allowed}", form.local))
    })?;
    match split_refusal(settling::set_local_passwords(&state, &person, rule).await)? {
        Ok(()) => Ok(FormAnswer::lead_to(PAGE)),
        Err(why) => {
            let page = make_page(&state, Visit::new(&person, &csrf), FilledForm::default()).await?;
            Ok(FormAnswer::Refused(ProvidersPage { local_refused: Some(why), ..page }))
        }
    }
}
