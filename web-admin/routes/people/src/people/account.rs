//! `/account`: the visitor's own details, password and data.

use acts::auth::{passwords, rate_limits};
use acts::error::Error;
use acts::people::accounts;
use axum::extract::State;
use axum::response::{Redirect, Response};
use model::auth::password_refused::PasswordRefused;
use model::{CurrentPerson, Moment};
use pages::auth::account::AccountPage;
use pages::auth::reauthentication::OwnPassword;
use pages::{NavPlace, Shell};
use routes_base::auth::{Browser, CsrfForm, Visitor, start_session};
use routes_base::error::PageError;
use routes_base::export::attach_file;
use routes_base::forms::FormAnswer;
use routes_base::{AppState, language};
use serde::Deserialize;
use store::auth::second_factors;
use store::letters::notices;
use store::operations::schools;
use store::people::directory;
use store::privacy::exports;
use store::stations::sign_in_codes;
use store::training::cohorts;
use store::{people, studies};
use words::Language;

use crate::auth::proving;

pub(super) async fn show_account(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    browser: Browser,
) -> Result<AccountPage, PageError> {
    Ok(make_account_page(&state, &person, &browser).await?)
}

async fn make_account_page(state: &AppState, person: &CurrentPerson, browser: &Browser) -> Result<AccountPage, Error> {
    let reader = state.db.reader();
    let known = directory::find_directory_entry(reader, person.school_id, person.id).await?.ok_or(Error::NotFound)?;
    Ok(AccountPage {
        shell: Shell::new(person, browser.csrf.token(), NavPlace::Account),
        school: schools::find_school_name(reader, person.school_id).await?,
        email: known.email,
        pseudonym: known.pseudonym,
        cohorts: known.cohorts,
        requests: cohorts::list_membership_requests(reader, person.school_id, None, Some(person.id)).await?,
        acts: cohorts::list_membership_acts(reader, person.school_id, person.id).await?,
        language: person.language,
        mailed: notices::wants_news_letters(reader, person.into()).await?,
        study_requests: studies::list_study_requests(reader, person.into()).await?.len(),
        second_factor: second_factors::is_second_factor_on(reader, person.into()).await?,
        practice: format!("/trainees/{}", person.id),
        sign_in_code: sign_in_codes::find_code_time(reader, person.school_id, person.id).await?.map(Moment::to_utc),
        own_password: proving::find_own_password(state, person, &browser.session).await?,
        refused: None,
    })
}

#[derive(Deserialize)]
pub(super) struct OwnPasswordForm {
    #[serde(default)]
    old: String,
    password: String,
    again: String,
}

/// Sets a new password, which ends every other session.
pub(super) async fn set_own_password(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    browser: Browser,
    CsrfForm(form): CsrfForm<OwnPasswordForm>,
) -> Result<FormAnswer<AccountPage>, PageError> {
    rate_limits::take_own(&state, person.id).await?;
    let shown = make_account_page(&state, &person, &browser).await?;
    let own = [person.display_name.as_str(), &shown.email, &shown.school];
    let refused = match passwords::check_typed(&form.password, &form.again, &own) {
        Err(refused) => refused,
        Ok(()) => match proving::check_proof(&state, &person, &browser.session, &form.old).await? {
            Ok(()) => {
                accounts::set_own_password(&state, &person, &form.password).await?;
                let known = people::find_person(state.db.reader(), person.id).await?.ok_or(Error::NotFound)?;
                start_session(&browser.session, known.id, known.credential_version, state.clock.now()).await?;
                return Ok(FormAnswer::lead_to("/account"));
            }
            Err(OwnPassword::Known) => PasswordRefused::WrongOld,
            Err(OwnPassword::Proved | OwnPassword::Unproved) => PasswordRefused::Unproved,
        },
    };
    Ok(FormAnswer::Refused(AccountPage { refused: Some(refused), ..shown }))
}

#[derive(Deserialize)]
pub(super) struct LanguageForm {
    language: String,
}

/// Sets the visitor's language; an empty choice follows their browser.
pub(super) async fn set_own_language(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    CsrfForm(form): CsrfForm<LanguageForm>,
) -> Result<Redirect, PageError> {
    let code = form.language.as_str();
    let chosen = Some(code).filter(|code| !code.is_empty());
    let chosen = chosen.map(|code| Language::named(code).ok_or_else(|| language::refuse_language(code))).transpose()?;
    accounts::set_language(&state, &person, chosen).await?;
    Ok(Redirect::to("/account"))
}

/// Exports all data about the visitor, as a file.
pub(super) async fn export_own_data(
    State(state): State<AppState>,
    Visitor(person): Visitor,
) -> Result<Response, PageError> {
    let held = exports::of_person(state.db.reader(), person.school_id, person.id).await?.ok_or(Error::NotFound)?;
    let body = serde_json::to_string_pretty(&held).map_err(anyhow::Error::from)?;
    Ok(attach_file("application/json", "stylet-my-data.json", body))
}
