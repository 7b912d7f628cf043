//! `/admin/provisioning`: tokens of the school's directories.

use acts::auth::rate_limits;
use acts::error::Error;
use acts::people::provisioning::tokens;
use axum::extract::State;
use axum::response::{IntoResponse, Redirect};
use model::CurrentPerson;
use model::ids::ProvisioningTokenId;
use pages::form::FilledForm;
use pages::people::provisioning::{DirectoryTokenForm, DirectoryTokenRow, ProvisioningPage};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Administrator, Browser, CsrfForm, NoFields};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use serde::Deserialize;
use store::people::provisioning as stored;

use crate::auth::proving;

const PAGE: &str = "/admin/provisioning";

pub(super) async fn show_provisioning(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    browser: Browser,
) -> Result<ProvisioningPage, PageError> {
    Ok(make_page(&state, &person, &browser, FilledForm::default()).await?)
}

async fn make_page(
    state: &AppState,
    person: &CurrentPerson,
    browser: &Browser,
    form: FilledForm<DirectoryTokenForm>,
) -> Result<ProvisioningPage, Error> {
    let row = |token: stored::ProvisioningToken| DirectoryTokenRow {
        revoke_href: format!("{PAGE}/{}/revoke", token.id),
        name: token.name,
        made: token.made_at.to_utc(),
        used: token.last_used_at.map(|at| at.to_utc()),
        expires: token.expires_at.to_utc(),
        may_disable_staff: token.may_disable_staff,
    };
    let tokens = stored::list_tokens(state.db.reader(), person.school_id).await?;
    Ok(ProvisioningPage {
        shell: Shell::new(person, browser.csrf.token(), NavPlace::Administration),
        address: format!("{}/scim/v2", state.config.address()),
        rows: tokens.into_iter().map(row).collect(),
        form,
        own_password: proving::find_own_password(state, person, &browser.session).await?,
        made: None,
    })
}

/// The form of a new token, with the administrator's password.
#[derive(Deserialize)]
pub(super) struct SentToken {
    #[serde(flatten)]
    fields: DirectoryTokenForm,
    #[serde(default)]
    password: String,
}

/// Creates a token and renders it directly: with a redirect it would have to be stored until it is
/// shown.
pub(super) async fn make_token(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    browser: Browser,
    CsrfForm(SentToken { fields, password }): CsrfForm<SentToken>,
) -> Result<FormAnswer<ProvisioningPage>, PageError> {
    rate_limits::take_own(&state, person.id).await?;
    let made = match proving::check_proof(&state, &person, &browser.session, &password).await? {
        Ok(()) => tokens::make_token(&state, &person, &fields.name, fields.may_disable_staff).await,
        Err(own) => Err(Error::Unprocessable(proving::explain_missing_proof(own))),
    };
    match split_refusal(made)? {
        Ok(token) => {
            let page = make_page(&state, &person, &browser, FilledForm::default()).await?;
            let page = ProvisioningPage { made: Some(token), ..page };
            Ok(FormAnswer::Answered(page.into_response()))
        }
        Err(why) => {
            let form = FilledForm::refused(fields, why);
            Ok(FormAnswer::Refused(make_page(&state, &person, &browser, form).await?))
        }
    }
}

pub(super) async fn revoke_token(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    PathId(id): PathId<ProvisioningTokenId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    tokens::revoke_token(&state, &person, id).await?;
    Ok(Redirect::to(PAGE))
}
