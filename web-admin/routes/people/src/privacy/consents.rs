//! `/people/{id}/consent`: an administrator records that a teacher consents to the use of their
//! attempts in the experts' corridor, with the wording of the consent, or that they withdrew it.

use acts::error::Error;
use acts::privacy::consents;
use axum::extract::State;
use axum::response::{IntoResponse, Redirect, Response};
use model::ids::PersonId;
use model::people::directory::DirectoryEntry;
use model::scoring::corridor;
use model::{CurrentPerson, Moment, Role};
use pages::form::FilledForm;
use pages::privacy::consent::{ConsentOfExpertPage, DeclarationForm, Recorded};
use pages::{NavPlace, Shell, format};
use routes_base::addresses::PathId;
use routes_base::auth::{Administrator, Csrf, CsrfForm, NoFields, Visit};
use routes_base::error::PageError;
use routes_base::forms::FormAnswer;
use routes_base::{AppState, Routes, get, post};
use store::people::directory;
use store::privacy::experts;
use store::privacy::experts::NewDeclaration;
use time::format_description::well_known::Iso8601;
use time::{Date, Time};

/// Maximum length of the wording of the consent, and of the way it was given, in characters.
const MOST_WORDING: usize = 2000;
const MOST_HOW: usize = 300;

pub(super) fn consent_routes() -> Routes {
    Routes::new()
        .route("/people/{id}/consent", get(show_consent).merge(post(record_declaration)))
        .route("/people/{id}/consent/withdraw", post(withdraw_declaration))
}

/// Returns a person of the administrator's school who is not a trainee.
async fn find_expert(state: &AppState, visitor: &CurrentPerson, id: PersonId) -> Result<DirectoryEntry, PageError> {
    let person =
        directory::find_directory_entry(state.db.reader(), visitor.school_id, id).await.map_err(Error::from)?;
    let person = person.ok_or(Error::NotFound)?;
    if person.role == Role::Trainee {
        return Err(Error::Conflict(
            tr!("the experts’ corridor is for instructors; this person is a trainee").to_owned(),
        )
        .into());
    }
    Ok(person)
}

pub(super) async fn show_consent(
    State(state): State<AppState>,
    Administrator(visitor): Administrator,
    PathId(id): PathId<PersonId>,
    csrf: Csrf,
) -> Result<ConsentOfExpertPage, PageError> {
    let person = find_expert(&state, &visitor, id).await?;
    let today = format::format_machine_time(state.clock.now().to_utc()).chars().take(10).collect();
    let typed = DeclarationForm { wording: corridor::WORDING.to_owned(), how: String::new(), given: today };
    Ok(make_consent_page(&state, Visit::new(&visitor, &csrf), person, FilledForm::new(typed)).await?)
}

async fn make_consent_page(
    state: &AppState,
    Visit { person: visitor, csrf }: Visit<'_>,
    person: DirectoryEntry,
    form: FilledForm<DeclarationForm>,
) -> Result<ConsentOfExpertPage, Error> {
    let recorded = experts::declarations(state.db.reader(), visitor.school_id, person.id).await?;
    let row = |known: experts::Declaration| Recorded {
        wording: known.wording,
        how: known.how,
        given_at: known.given_at.to_utc(),
        recorded_by: known.recorded_by,
        withdrawn: known.withdrawn_at.map(Moment::to_utc).zip(known.withdrawn_by),
    };
    Ok(ConsentOfExpertPage {
        shell: Shell::new(visitor, csrf.token(), NavPlace::People),
        person: person.id,
        name: person.name,
        recorded: recorded.into_iter().map(row).collect(),
        form,
    })
}

pub(super) async fn record_declaration(
    State(state): State<AppState>,
    Administrator(visitor): Administrator,
    PathId(id): PathId<PersonId>,
    csrf: Csrf,
    CsrfForm(typed): CsrfForm<DeclarationForm>,
) -> Result<FormAnswer<ConsentOfExpertPage>, PageError> {
    let person = find_expert(&state, &visitor, id).await?;
    let new = match read_declaration(&typed, visitor.id, state.clock.now()) {
        Ok(new) => new,
        Err(why) => {
            let form = FilledForm::refused(typed, why);
            return Ok(FormAnswer::Refused(
                make_consent_page(&state, Visit::new(&visitor, &csrf), person, form).await?,
            ));
        }
    };
    consents::record_consent(&state, &visitor, id, new).await?;
    Ok(FormAnswer::Answered(redirect_to_consent(id)))
}

/// Parses the form as a consent; the error explains invalid input.
fn read_declaration(typed: &DeclarationForm, recorded_by: PersonId, now: Moment) -> Result<NewDeclaration<'_>, String> {
    let wording = read_words(tr!("consent text"), &typed.wording, MOST_WORDING)?;
    let how = read_words(tr!("how it was given"), &typed.how, MOST_HOW)?;
    let given_at = Date::parse(typed.given.trim(), &Iso8601::DATE)
        .map(|date| Moment::from(date.with_time(Time::MIDNIGHT).assume_utc()))
        .ok()
        .filter(|given| *given <= now);
    let given_at = given_at.ok_or_else(|| {
        tr!("day: “{day}”; allowed: a day like 2026-05-20 that is not in the future", day = typed.given)
    })?;
    Ok(NewDeclaration { wording, how, given_at, recorded_by })
}

fn read_words<'a>(field: &str, typed: &'a str, most: usize) -> Result<&'a str, String> {
    let typed = typed.trim();
    match typed.chars().count() {
        n if (1..=most).contains(&n) => Ok(typed),
        n => Err(tr!("{field}: {count} characters; allowed: 1 to {most}", field = field, count = n, most = most)),
    }
}

pub(super) async fn withdraw_declaration(
    State(state): State<AppState>,
    Administrator(visitor): Administrator,
    PathId(id): PathId<PersonId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Response, PageError> {
    find_expert(&state, &visitor, id).await?;
    consents::withdraw_consent(&state, &visitor, id).await?;
    Ok(redirect_to_consent(id))
}

fn redirect_to_consent(id: PersonId) -> Response {
    Redirect::to(&format!("/people/{id}/consent")).into_response()
}
