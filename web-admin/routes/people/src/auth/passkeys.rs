//! `/account/second-factor/passkeys`: adds, renames and removes the visitor's own passkeys.

use acts::auth::passkeys;
use acts::auth::passkeys::PasskeyAnswer;
use acts::error::Error;
use axum::extract::State;
use axum::response::IntoResponse;
use model::CurrentPerson;
use model::ids::PasskeyId;
use pages::auth::passkeys::{MakePasskeyPage, PasskeyPage, PasskeyRow};
use pages::auth::reauthentication::FactorRefused;
use pages::auth::second_factor::SecondFactorPage;
use pages::form::FilledForm;
use pages::{NavPlace, Shell};
use routes_base::addresses::PathId;
use routes_base::auth::{Browser, CsrfForm, Visitor};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use routes_base::{AppState, Routes, get, post};
use serde::Deserialize;
use store::auth::passkeys::KeptPasskey;
use store::auth::{passkeys as stored, second_factors};

use crate::auth::proving::{ShownFactor, hold_question, take_held_question};
use crate::auth::second_factor::{
    FactorCredentials, PAGE, allow_factor_change, answer_enrolled, is_factor_asked, make_factor_page, proof_to_ask,
    show_factor_again,
};

/// Returns the routes of the visitor's own passkeys.
pub(super) fn passkey_routes() -> Routes {
    Routes::new()
        .route("/account/second-factor/passkeys", post(begin_passkey))
        .route("/account/second-factor/passkeys/confirm", post(confirm_passkey))
        .route("/account/second-factor/passkeys/{id}", get(show_passkey))
        .route("/account/second-factor/passkeys/{id}/rename", post(rename_passkey))
        .route("/account/second-factor/passkeys/{id}/remove", post(remove_passkey))
}

/// Returns the row of a passkey in a list.
pub(super) fn make_passkey_row(kept: KeptPasskey) -> PasskeyRow {
    PasskeyRow {
        href: format!("{PAGE}/passkeys/{}", kept.id),
        name: kept.name,
        made: kept.made_at.to_utc(),
        used: kept.last_used_at.map(|at| at.to_utc()),
    }
}

#[derive(Deserialize)]
struct NewPasskeyForm {
    name: String,
    #[serde(default)]
    password: String,
    #[serde(flatten)]
    shown: ShownFactor,
}

/// Starts the creation of a passkey and renders the challenge directly: with a redirect it would
/// have to be stored until it is shown.
async fn begin_passkey(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    browser: Browser,
    CsrfForm(form): CsrfForm<NewPasskeyForm>,
) -> Result<FormAnswer<SecondFactorPage>, PageError> {
    let asked = match allow_factor_change(
        &state,
        &person,
        &browser,
        FactorCredentials { password: &form.password, shown: &form.shown },
    )
    .await?
    {
        Ok(()) => passkeys::ask_to_make(&state, &person, &form.name).await,
        Err(refused) => return refuse_new_passkey(&state, &person, &browser, form.name, refused).await,
    };
    match split_refusal(asked)? {
        Ok(question) => {
            hold_question(&browser.session, &question).await?;
            let shell = Shell::new(&person, browser.csrf.token(), nav_place(&state, &person).await?);
            Ok(FormAnswer::Answered(MakePasskeyPage { shell, question }.into_response()))
        }
        Err(why) => refuse_new_passkey(&state, &person, &browser, form.name, FactorRefused::Other(why)).await,
    }
}

/// Returns the navigation: while a required second factor is missing, only its setup.
async fn nav_place(state: &AppState, person: &CurrentPerson) -> Result<NavPlace, Error> {
    let owed = second_factors::is_second_factor_owed(state.db.reader(), person.into()).await?;
    Ok(if owed { NavPlace::Enrolment } else { NavPlace::Account })
}

/// Shows the page again with the name that was entered and the reason for the refusal.
async fn refuse_new_passkey(
    state: &AppState,
    person: &CurrentPerson,
    browser: &Browser,
    name: String,
    refused: FactorRefused,
) -> Result<FormAnswer<SecondFactorPage>, PageError> {
    let form = FilledForm::refused(name, refused);
    Ok(FormAnswer::Refused(SecondFactorPage { form, ..make_factor_page(state, person, browser).await? }))
}

#[derive(Deserialize)]
struct PasskeyAnswerForm {
    #[serde(default)]
    answer: String,
}

/// Stores the new passkey.
async fn confirm_passkey(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    browser: Browser,
    CsrfForm(form): CsrfForm<PasskeyAnswerForm>,
) -> Result<FormAnswer<SecondFactorPage>, PageError> {
    let answer =
        PasskeyAnswer { question: take_held_question(&browser.session).await?, json: &form.answer, from: browser.from };
    match passkeys::make(&state, &person, answer).await? {
        Some(made) => Ok(FormAnswer::Answered(answer_enrolled(&state, &person, &browser.session, made).await?)),
        None => show_factor_again(&state, &person, &browser, FactorRefused::NotMade).await,
    }
}

async fn show_passkey(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    browser: Browser,
    PathId(id): PathId<PasskeyId>,
) -> Result<PasskeyPage, PageError> {
    Ok(make_passkey_page(&state, &person, &browser, id).await?)
}

async fn make_passkey_page(
    state: &AppState,
    person: &CurrentPerson,
    browser: &Browser,
    id: PasskeyId,
) -> Result<PasskeyPage, Error> {
    let kept = passkeys::find(state, person, id).await?;
    let reader = state.db.reader();
    let proof = proof_to_ask(state, person, &browser.session).await?;
    let last = !proof.app && stored::list_passkeys(reader, person.into()).await?.len() == 1;
    Ok(PasskeyPage {
        shell: Shell::new(person, browser.csrf.token(), NavPlace::Account),
        row: make_passkey_row(kept),
        last,
        asked: is_factor_asked(state, person).await?,
        proof,
        refused: None,
    })
}

async fn refuse_passkey_change(
    state: &AppState,
    person: &CurrentPerson,
    browser: &Browser,
    id: PasskeyId,
    refused: FactorRefused,
) -> Result<FormAnswer<PasskeyPage>, PageError> {
    let page = make_passkey_page(state, person, browser, id).await?;
    Ok(FormAnswer::Refused(PasskeyPage { refused: Some(refused), ..page }))
}

#[derive(Deserialize)]
struct NameForm {
    name: String,
}

async fn rename_passkey(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    browser: Browser,
    PathId(id): PathId<PasskeyId>,
    CsrfForm(form): CsrfForm<NameForm>,
) -> Result<FormAnswer<PasskeyPage>, PageError> {
    match split_refusal(passkeys::rename(&state, &person, id, &form.name).await)? {
        Ok(()) => Ok(FormAnswer::lead_to(PAGE)),
        Err(why) => refuse_passkey_change(&state, &person, &browser, id, FactorRefused::Other(why)).await,
    }
}

#[derive(Deserialize)]
struct RemoveForm {
    #[serde(default)]
    password: String,
    #[serde(flatten)]
    shown: ShownFactor,
}

async fn remove_passkey(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    browser: Browser,
    PathId(id): PathId<PasskeyId>,
    CsrfForm(form): CsrfForm<RemoveForm>,
) -> Result<FormAnswer<PasskeyPage>, PageError> {
    passkeys::find(&state, &person, id).await?;
    if let Err(refused) = allow_factor_change(
        &state,
        &person,
        &browser,
        FactorCredentials { password: &form.password, shown: &form.shown },
    )
    .await?
    {
        return refuse_passkey_change(&state, &person, &browser, id, refused).await;
    }
    passkeys::remove(&state, &person, id).await?;
    Ok(FormAnswer::lead_to(PAGE))
}
