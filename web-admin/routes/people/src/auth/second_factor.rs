//! `/account/second-factor`: the visitor's own second factor. Administrators reset a colleague's,
//! and set which roles must have one.

use acts::auth::second_factor::{Enrolled, TypedCode};
use acts::auth::{rate_limits, second_factor};
use acts::error::Error;
use axum::extract::State;
use axum::http::header;
use axum::response::{IntoResponse, Redirect, Response};
use model::ids::PersonId;
use model::{CurrentPerson, FactorRule, PersonKey};
use pages::auth::reauthentication::{FactorRefused, OwnPassword, ProofAsked};
use pages::auth::second_factor::{FactorState, RecoveryCodesPage, SecondFactorPage};
use pages::form::FilledForm;
use pages::training::qr;
use pages::{NavPlace, Shell};
use routes_base::addresses::PathId;
use routes_base::auth::{Administrator, Browser, Csrf, CsrfForm, NoFields, Visitor, start_session};
use routes_base::error::PageError;
use routes_base::forms::FormAnswer;
use routes_base::{AppState, Routes, get, post};
use serde::Deserialize;
use store::audit::Actor;
use store::auth::{passkeys as stored, second_factors};
use store::operations::schools;
use store::people;
use store::people::directory;
use tower_sessions::Session;

use crate::auth::proving::{FactorQuestion, ShownFactor};
use crate::auth::{passkeys, proving};

/// Path of the page.
pub(super) const PAGE: &str = "/account/second-factor";

/// Returns the routes of the visitor's own factor, a colleague's, and the school's rule.
pub(super) fn second_factor_routes() -> Routes {
    Routes::new()
        .route("/account/second-factor", get(show_second_factor).merge(post(begin_second_factor)))
        .route("/account/second-factor/qr.svg", get(show_qr_code))
        .route("/account/second-factor/confirm", post(confirm_second_factor))
        .route("/account/second-factor/recovery-codes", post(remake_recovery_codes))
        .route("/account/second-factor/off", post(turn_factor_off))
        .route("/people/{id}/second-factor/reset", post(reset_factor))
        .route("/admin/second-factor", post(set_factor_rule))
}

async fn show_second_factor(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    browser: Browser,
) -> Result<SecondFactorPage, PageError> {
    Ok(make_factor_page(&state, &person, &browser).await?)
}

/// Builds the page, and starts a passkey challenge in this session.
pub(super) async fn make_factor_page(
    state: &AppState,
    person: &CurrentPerson,
    browser: &Browser,
) -> Result<SecondFactorPage, Error> {
    let (reader, key) = (state.db.reader(), PersonKey::from(person));
    let factor = match second_factors::find_second_factor(reader, key).await? {
        None => FactorState::Off,
        Some(found) => match found.confirmed_at {
            Some(since) => FactorState::On { since: since.to_utc() },
            None => offered_factor(state, person).await?,
        },
    };
    let proof = proof_to_ask(state, person, &browser.session).await?;
    let codes_left = if proof.on { Some(second_factors::recovery_codes_left(reader, key).await?) } else { None };
    let asked = is_factor_asked(state, person).await?;
    let owed = asked && !proof.on;
    let place = if owed { NavPlace::Enrolment } else { NavPlace::Account };
    Ok(SecondFactorPage {
        shell: Shell::new(person, browser.csrf.token(), place),
        factor,
        passkeys: stored::list_passkeys(reader, key).await?.into_iter().map(passkeys::make_passkey_row).collect(),
        codes_left,
        proof,
        can_add: state.relying_party.is_some(),
        form: FilledForm::default(),
        asked,
        owed,
    })
}

/// Whether the school requires a second factor from a person.
pub(super) async fn is_factor_asked(state: &AppState, person: &CurrentPerson) -> Result<bool, Error> {
    let rule = second_factors::find_factor_rule(state.db.reader(), person.school_id).await?;
    Ok(rule.asks(person.role))
}

/// Returns the credentials that a person must present to change a second factor; starts a passkey
/// challenge in this session.
pub(super) async fn proof_to_ask(
    state: &AppState,
    person: &CurrentPerson,
    session: &Session,
) -> Result<ProofAsked, Error> {
    let (reader, key) = (state.db.reader(), PersonKey::from(person));
    let app =
        second_factors::find_second_factor(reader, key).await?.is_some_and(|factor| factor.confirmed_at.is_some());
    let question = FactorQuestion { state, session, key }.question().await?;
    let own_password = proving::find_own_password(state, person, session).await?;
    Ok(ProofAsked { own_password, on: second_factors::is_second_factor_on(reader, key).await?, app, question })
}

/// Credentials presented to change a second factor.
#[derive(Clone, Copy)]
pub(super) struct FactorCredentials<'a> {
    /// The password.
    pub password: &'a str,
    /// The second factor.
    pub shown: &'a ShownFactor,
}

/// Whether a person may change a second factor: they must know the password and present one of the
/// active factors, so that an unattended browser is not enough.
pub(super) async fn allow_factor_change(
    state: &AppState,
    person: &CurrentPerson,
    browser: &Browser,
    credentials: FactorCredentials<'_>,
) -> Result<Result<(), FactorRefused>, Error> {
    rate_limits::take_own(state, person.id).await?;
    if let Err(own) = proving::check_proof(state, person, &browser.session, credentials.password).await? {
        return Ok(Err(match own {
            OwnPassword::Known => FactorRefused::Password,
            _ => FactorRefused::Other(proving::explain_missing_proof(own)),
        }));
    }
    let key = PersonKey::from(person);
    if !second_factors::is_second_factor_on(state.db.reader(), key).await? {
        return Ok(Ok(()));
    }
    let asked = FactorQuestion { state, session: &browser.session, key };
    Ok(asked.prove(credentials.shown, browser.from).await?.map(drop))
}

/// Returns the offered secret; `FactorState::Off` if it cannot be decrypted any more.
async fn offered_factor(state: &AppState, person: &CurrentPerson) -> Result<FactorState, Error> {
    let Ok(Some(secret)) = second_factor::offered(state, person.into()).await else { return Ok(FactorState::Off) };
    let address = address_of_secret(state, person).await?.unwrap_or_default();
    Ok(FactorState::Offered { secret: second_factor::in_groups(&secret.text()), address })
}

/// Returns the `otpauth` address of the offered secret, for authenticator apps.
async fn address_of_secret(state: &AppState, person: &CurrentPerson) -> Result<Option<String>, Error> {
    let Some(secret) = second_factor::offered(state, person.into()).await? else { return Ok(None) };
    let reader = state.db.reader();
    let school = schools::find_school_name(reader, person.school_id).await?;
    let known = people::find_person(reader, person.id).await?.ok_or(Error::NotFound)?;
    Ok(Some(secret.address(&format!("Stylet, {school}"), &known.email)))
}

/// Shows the page again with the reason why nothing was changed.
pub(super) async fn show_factor_again(
    state: &AppState,
    person: &CurrentPerson,
    browser: &Browser,
    why: FactorRefused,
) -> Result<FormAnswer<SecondFactorPage>, PageError> {
    let form = FilledForm::refused(String::new(), why);
    Ok(FormAnswer::Refused(SecondFactorPage { form, ..make_factor_page(state, person, browser).await? }))
}

#[derive(Deserialize)]
struct FactorChangeForm {
    #[serde(default)]
    password: String,
    #[serde(flatten)]
    shown: ShownFactor,
}

impl FactorChangeForm {
    fn credentials(&self) -> FactorCredentials<'_> {
        FactorCredentials { password: &self.password, shown: &self.shown }
    }
}

/// Offers a secret, after checking the credentials.
async fn begin_second_factor(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    browser: Browser,
    CsrfForm(form): CsrfForm<FactorChangeForm>,
) -> Result<FormAnswer<SecondFactorPage>, PageError> {
    if let Err(refused) = allow_factor_change(&state, &person, &browser, form.credentials()).await? {
        return show_factor_again(&state, &person, &browser, refused).await;
    }
    second_factor::offer(&state, &person).await?;
    Ok(FormAnswer::lead_to(PAGE))
}

/// Returns the QR code of the offered secret, while it is offered.
async fn show_qr_code(State(state): State<AppState>, Visitor(person): Visitor) -> Result<Response, PageError> {
    let picture = address_of_secret(&state, &person).await?.and_then(|address| qr::draw_qr_code(&address));
    Ok(([(header::CONTENT_TYPE, "image/svg+xml")], picture.ok_or(Error::NotFound)?).into_response())
}

#[derive(Deserialize)]
struct CodeForm {
    code: String,
}

/// Activates the codes of an app.
async fn confirm_second_factor(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    browser: Browser,
    CsrfForm(form): CsrfForm<CodeForm>,
) -> Result<FormAnswer<SecondFactorPage>, PageError> {
    let typed = TypedCode { code: &form.code, from: browser.from };
    match second_factor::confirm(&state, &person, typed).await? {
        Some(made) => Ok(FormAnswer::Answered(answer_enrolled(&state, &person, &browser.session, made).await?)),
        None => show_factor_again(&state, &person, &browser, FactorRefused::Code).await,
    }
}

/// Keeps a person signed in who has set up a second factor, and shows the recovery codes of the
/// first one directly: with a redirect they would have to be stored until they are shown.
pub(super) async fn answer_enrolled(
    state: &AppState,
    person: &CurrentPerson,
    session: &Session,
    made: Enrolled,
) -> Result<Response, Error> {
    let known = people::find_person(state.db.reader(), person.id).await?.ok_or(Error::NotFound)?;
    start_session(session, known.id, known.credential_version, state.clock.now()).await?;
    let Enrolled::First(codes) = made else { return Ok(Redirect::to(PAGE).into_response()) };
    let csrf = Csrf::of_session(session).await?;
    let shell = Shell::new(person, csrf.token(), NavPlace::Account);
    Ok(RecoveryCodesPage { shell, codes, first: true }.into_response())
}

/// Returns the person's key if they have a second factor, for forms that require one.
async fn key_with_factor(state: &AppState, person: &CurrentPerson) -> Result<PersonKey, Error> {
    let key = PersonKey::from(person);
    let on = second_factors::is_second_factor_on(state.db.reader(), key).await?;
    if on { Ok(key) } else { Err(second_factor::nothing_on()) }
}

async fn remake_recovery_codes(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    browser: Browser,
    CsrfForm(shown): CsrfForm<ShownFactor>,
) -> Result<FormAnswer<SecondFactorPage>, PageError> {
    let key = key_with_factor(&state, &person).await?;
    let proved = FactorQuestion { state: &state, session: &browser.session, key }.prove(&shown, browser.from).await?;
    if let Err(refused) = proved {
        return show_factor_again(&state, &person, &browser, refused).await;
    }
    let codes = second_factor::remake_codes(&state, &person).await?;
    let shell = Shell::new(&person, browser.csrf.token(), NavPlace::Account);
    let page = RecoveryCodesPage { shell, codes, first: false };
    Ok(FormAnswer::Answered(page.into_response()))
}

/// Deactivates the codes of an app.
async fn turn_factor_off(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    browser: Browser,
    CsrfForm(form): CsrfForm<FactorChangeForm>,
) -> Result<FormAnswer<SecondFactorPage>, PageError> {
    key_with_factor(&state, &person).await?;
    if let Err(refused) = allow_factor_change(&state, &person, &browser, form.credentials()).await? {
        return show_factor_again(&state, &person, &browser, refused).await;
    }
    if !second_factor::turn_off(&state, &person).await? {
        return Err(second_factor::nothing_on().into());
    }
    Ok(FormAnswer::lead_to(PAGE))
}

/// Removes the second factor of a person who has lost it.
async fn reset_factor(
    State(state): State<AppState>,
    Administrator(visitor): Administrator,
    PathId(id): PathId<PersonId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    let person =
        directory::find_directory_entry(state.db.reader(), visitor.school_id, id).await?.ok_or(Error::NotFound)?;
    if person.id == visitor.id {
        let why = tr!("turn off your own second factor on your account page, with a code");
        return Err(Error::Conflict(why.to_owned()).into());
    }
    let key = PersonKey { school_id: visitor.school_id, person_id: person.id };
    if !second_factor::reset(&state, key, Actor::Person(visitor.id)).await? {
        return Err(second_factor::nothing_on().into());
    }
    Ok(Redirect::to(&format!("/people/{id}?done=unfactored")))
}

#[derive(Deserialize)]
struct FactorRuleForm {
    rule: String,
}

/// Sets which roles must have a second factor.
async fn set_factor_rule(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    CsrfForm(form): CsrfForm<FactorRuleForm>,
) -> Result<Redirect, PageError> {
    let rule = FactorRule::of_word(&form.rule).ok_or_else(|| {
        let allowed = FactorRule::ALL.map(FactorRule::word).join(", ");
        Error::BadRequest(format!("rule: \"{}\"; allowed: {allowed}", form.rule))
    })?;
    acts::operations::schools::set_second_factor_rule(&state, &person, rule).await?;
    Ok(Redirect::to("/admin/settings?saved=true#second-factor"))
}
