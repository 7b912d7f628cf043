//! `/account/second-factor`: one's own second factor. An administrator resets a colleague's, and says of whom the school asks
//! for one.

use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Redirect, Response};
use axum::routing::{get, post};
use serde::Deserialize;
use serde_json::json;
use tower_sessions::Session;

use super::Id;
use super::admin::administrators_only;
use crate::AppState;
use crate::accounts;
use crate::domain::{CurrentPerson, FactorRule};
use crate::error::{Error, PageError};
use crate::routes::Routes;
use crate::routes::auth::{ClientAddress, Csrf, CsrfForm, NoFields, SignedIn};
use crate::second_factor::{self, Typed};
use crate::storage::audit::{Actor, Entry};
use crate::storage::second_factors::{self, PersonKey};
use crate::storage::{directory, people, schools};
use crate::views::qr;
use crate::views::second_factor::{FactorRefused, FactorState, RecoveryCodesPage, SecondFactorPage};
use crate::views::{Place, Shell};

/// One's own, a colleague's and the school's.
pub(super) fn router() -> Routes {
    Routes::new()
        .route("/account/second-factor", get(show).post(begin))
        .route("/account/second-factor/qr.svg", get(picture))
        .route("/account/second-factor/confirm", post(confirm))
        .route("/account/second-factor/recovery-codes", post(remake_codes))
        .route("/account/second-factor/off", post(turn_off))
        .route("/people/{id}/second-factor/reset", post(reset))
        .route("/admin/second-factor", post(set_rule))
}

async fn show(State(state): State<AppState>, person: CurrentPerson, csrf: Csrf) -> Result<SecondFactorPage, PageError> {
    Ok(page(&state, &person, &csrf).await?)
}

async fn page(state: &AppState, person: &CurrentPerson, csrf: &Csrf) -> Result<SecondFactorPage, Error> {
    let (reader, key) = (state.db.reader(), PersonKey::from(person));
    let factor = match second_factors::find(reader, key).await? {
        None => FactorState::Off,
        Some(found) => match found.confirmed_at {
            Some(since) => {
                let codes_left = second_factors::recovery_codes_left(reader, key).await?;
                FactorState::On { since: since.to_utc(), codes_left }
            }
            None => offered(state, person).await?,
        },
    };
    let rule = second_factors::rule(reader, person.school_id).await?;
    let asked = rule.asks(person.role);
    let owed = asked && !matches!(factor, FactorState::On { .. });
    let place = if owed { Place::Enrolment } else { Place::Account };
    Ok(SecondFactorPage { shell: Shell::new(person, csrf.token(), place), factor, asked, owed, refused: None })
}

/// What is offered; nothing where its seal does not open any more.
async fn offered(state: &AppState, person: &CurrentPerson) -> Result<FactorState, Error> {
    let Ok(Some(secret)) = second_factor::offered(state, person.into()).await else { return Ok(FactorState::Off) };
    let address = address(state, person).await?.unwrap_or_default();
    Ok(FactorState::Offered { secret: second_factor::in_groups(&secret.text()), address })
}

/// The offered secret as apps read it.
async fn address(state: &AppState, person: &CurrentPerson) -> Result<Option<String>, Error> {
    let Some(secret) = second_factor::offered(state, person.into()).await? else { return Ok(None) };
    let reader = state.db.reader();
    let school = schools::name(reader, person.school_id).await?;
    let known = people::by_id(reader, person.id).await?.ok_or(Error::NotFound)?;
    Ok(Some(secret.address(&format!("Stylet, {school}"), &known.email)))
}

/// The page once more, saying why nothing was changed.
async fn again(
    state: &AppState,
    person: &CurrentPerson,
    csrf: &Csrf,
    why: FactorRefused,
) -> Result<Response, PageError> {
    let page = SecondFactorPage { refused: Some(why), ..page(state, person, csrf).await? };
    Ok((StatusCode::UNPROCESSABLE_ENTITY, page).into_response())
}

#[derive(Deserialize)]
struct PasswordForm {
    password: String,
}

/// Offers a secret to whoever knows the password: not to a browser that was left open.
async fn begin(
    State(state): State<AppState>,
    person: CurrentPerson,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<PasswordForm>,
) -> Result<Response, PageError> {
    state.logins.take_own(person.id)?;
    if !accounts::is_own_password(&state, &person, &form.password).await? {
        return again(&state, &person, &csrf, FactorRefused::Password).await;
    }
    second_factor::offer(&state, &person).await?;
    Ok(Redirect::to("/account/second-factor").into_response())
}

/// The offered secret as a picture, for as long as it is offered.
async fn picture(State(state): State<AppState>, person: CurrentPerson) -> Result<Response, PageError> {
    let picture = address(&state, &person).await?.and_then(|address| qr::svg(&address));
    Ok(([(header::CONTENT_TYPE, "image/svg+xml")], picture.ok_or(Error::NotFound)?).into_response())
}

#[derive(Deserialize)]
struct CodeForm {
    code: String,
}

/// Turns the second factor on, and shows the recovery codes. Not by a redirect: they would have to be kept to be shown.
async fn confirm(
    State(state): State<AppState>,
    person: CurrentPerson,
    (session, csrf): (Session, Csrf),
    ClientAddress(from): ClientAddress,
    CsrfForm(form): CsrfForm<CodeForm>,
) -> Result<Response, PageError> {
    let typed = Typed { code: &form.code, from };
    let Some(codes) = second_factor::confirm(&state, &person, typed).await? else {
        return again(&state, &person, &csrf, FactorRefused::Code).await;
    };
    let known = people::by_id(state.db.reader(), person.id).await?.ok_or(Error::NotFound)?;
    SignedIn::start(&session, (known.id, known.credential_version), state.clock.now()).await?;
    let csrf = Csrf::of_session(&session).await?;
    let shell = Shell::new(&person, csrf.token(), Place::Account);
    Ok(RecoveryCodesPage { shell, codes, first: true }.into_response())
}

/// Who has a second factor, for forms that only make sense with one.
async fn with_factor(state: &AppState, person: &CurrentPerson) -> Result<PersonKey, Error> {
    let key = PersonKey::from(person);
    let on = second_factors::is_on(state.db.reader(), key).await?;
    if on { Ok(key) } else { Err(second_factor::nothing_on()) }
}

async fn remake_codes(
    State(state): State<AppState>,
    person: CurrentPerson,
    csrf: Csrf,
    ClientAddress(from): ClientAddress,
    CsrfForm(form): CsrfForm<CodeForm>,
) -> Result<Response, PageError> {
    let key = with_factor(&state, &person).await?;
    if second_factor::check(&state, key, Typed { code: &form.code, from }).await?.is_none() {
        return again(&state, &person, &csrf, FactorRefused::Code).await;
    }
    let codes = second_factor::remake_codes(&state, &person).await?;
    let shell = Shell::new(&person, csrf.token(), Place::Account);
    Ok(RecoveryCodesPage { shell, codes, first: false }.into_response())
}

#[derive(Deserialize)]
struct OffForm {
    password: String,
    code: String,
}

async fn turn_off(
    State(state): State<AppState>,
    person: CurrentPerson,
    csrf: Csrf,
    ClientAddress(from): ClientAddress,
    CsrfForm(form): CsrfForm<OffForm>,
) -> Result<Response, PageError> {
    let key = with_factor(&state, &person).await?;
    state.logins.take_own(person.id)?;
    if !accounts::is_own_password(&state, &person, &form.password).await? {
        return again(&state, &person, &csrf, FactorRefused::Password).await;
    }
    if second_factor::check(&state, key, Typed { code: &form.code, from }).await?.is_none() {
        return again(&state, &person, &csrf, FactorRefused::Code).await;
    }
    second_factor::turn_off(&state, &person).await?;
    Ok(Redirect::to("/account/second-factor").into_response())
}

/// Takes the second factor of somebody away who has lost it.
async fn reset(
    State(state): State<AppState>,
    visitor: CurrentPerson,
    Id(id): Id,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    administrators_only(&visitor)?;
    let person = directory::find(state.db.reader(), visitor.school_id, id).await?.ok_or(Error::NotFound)?;
    if person.id == visitor.id {
        let why = tr!("one's own second factor is turned off on one's own account's page, by a code");
        return Err(Error::Conflict(why.to_owned()).into());
    }
    let key = PersonKey { school_id: visitor.school_id, person_id: person.id };
    if !second_factor::reset(&state, key, Actor::Person(visitor.id)).await? {
        return Err(second_factor::nothing_on().into());
    }
    Ok(Redirect::to(&format!("/people/{id}?done=unfactored")))
}

#[derive(Deserialize)]
struct RuleForm {
    rule: String,
}

/// Sets of whom the school asks for a second factor.
async fn set_rule(
    State(state): State<AppState>,
    person: CurrentPerson,
    CsrfForm(form): CsrfForm<RuleForm>,
) -> Result<Redirect, PageError> {
    administrators_only(&person)?;
    let rule = FactorRule::of_word(&form.rule).ok_or_else(|| {
        let allowed = FactorRule::ALL.map(FactorRule::word).join(", ");
        Error::BadRequest(format!("rule: \"{}\"; allowed are {allowed}", form.rule))
    })?;
    let mut tx = state.db.write().await?;
    second_factors::set_rule(&mut tx, person.school_id, rule).await?;
    Entry::by(&person, "school.second_factor_set", person.school_id)
        .with(json!({ "asked_of": rule.word() }))
        .append(&mut tx, state.clock.now())
        .await?;
    tx.commit().await.map_err(Error::from)?;
    Ok(Redirect::to("/admin#second-factor"))
}
