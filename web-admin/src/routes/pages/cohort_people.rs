//! Who is in a cohort: made, filled and emptied by its instructors and by administrators.

use axum::extract::rejection::PathRejection;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Redirect, Response};
use serde::Deserialize;
use serde_json::json;
use uuid::Uuid;

use super::Id;
use crate::AppState;
use crate::domain::roster::is_name;
use crate::domain::{CurrentPerson, Role};
use crate::error::{Error, PageError};
use crate::routes::auth::{Csrf, CsrfForm, NoFields};
use crate::storage::audit::Entry;
use crate::storage::cohorts::{self, Membership};
use crate::storage::people;
use crate::storage::reports::{self, Named};
use crate::views::people::CohortPeoplePage;
use crate::views::{Place, Shell};

#[derive(Deserialize)]
pub(super) struct CohortForm {
    name: String,
}

/// Makes a cohort; an instructor teaches what they have made.
pub(super) async fn make(
    State(state): State<AppState>,
    person: CurrentPerson,
    CsrfForm(form): CsrfForm<CohortForm>,
) -> Result<Redirect, PageError> {
    if person.role == Role::Trainee {
        return Err(PageError(Error::Forbidden(tr!("cohorts are made by those who teach them"))));
    }
    let name = form.name.trim();
    if !is_name(name) {
        let why = tr!(
            "the cohort's name: “{name}”; allowed are 1 to 120 characters, not beginning with = + - or @",
            name = name
        );
        return Err(Error::Unprocessable(why).into());
    }
    let school_id = person.school_id;
    let mut tx = state.db.write().await?;
    let before = cohorts::all(&mut *tx, school_id).await?;
    if before.iter().any(|cohort| cohort.name == name) {
        return Err(Error::Conflict(tr!("there is a cohort “{name}” already", name = name)).into());
    }
    let cohort = cohorts::find_or_create(&mut tx, school_id, name, state.clock.now()).await?;
    if person.role == Role::Instructor {
        let own = Membership { school_id, cohort_id: cohort.id, person_id: person.id, role: Role::Instructor };
        cohorts::join(&mut tx, own).await?;
    }
    Entry::by(&person, "cohort.made", cohort.id).append(&mut tx, state.clock.now()).await?;
    tx.commit().await?;
    Ok(Redirect::to(&format!("/cohorts/{}/people", cohort.id)))
}

/// A cohort that the visitor may change.
async fn find(state: &AppState, person: &CurrentPerson, id: Uuid) -> Result<Named, Error> {
    let cohorts = reports::cohorts(state.db.reader(), person).await?;
    cohorts.into_iter().find(|cohort| cohort.id == id).ok_or(Error::NotFound)
}

pub(super) async fn show(
    State(state): State<AppState>,
    person: CurrentPerson,
    Id(id): Id,
    csrf: Csrf,
) -> Result<CohortPeoplePage, PageError> {
    let cohort = find(&state, &person, id).await?;
    Ok(page(&state, Shell::new(&person, csrf.token(), Place::Cohorts), person.school_id, cohort).await?)
}

async fn page(state: &AppState, shell: Shell, school: Uuid, cohort: Named) -> Result<CohortPeoplePage, Error> {
    let mut members = Vec::new();
    for role in [Role::Instructor, Role::Trainee] {
        let named = reports::members(state.db.reader(), school, cohort.id, role).await?;
        members.extend(named.into_iter().map(|person| (person.id.to_string(), person.name, role)));
    }
    let href = format!("/cohorts/{}", cohort.id);
    Ok(CohortPeoplePage { shell, href, name: cohort.name, members, email: String::new(), unknown: false })
}

#[derive(Deserialize)]
pub(super) struct MemberForm {
    email: String,
}

/// Adds somebody of the school. Whoever is of another school is answered like nobody.
pub(super) async fn add(
    State(state): State<AppState>,
    person: CurrentPerson,
    Id(id): Id,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<MemberForm>,
) -> Result<Response, PageError> {
    let cohort = find(&state, &person, id).await?;
    let mut tx = state.db.write().await?;
    let known = people::by_email(&mut *tx, form.email.trim()).await?;
    let fits = |known: &people::Person| known.school_id == person.school_id && known.role != Role::Administrator;
    let Some(known) = known.filter(fits) else {
        let page = page(&state, Shell::new(&person, csrf.token(), Place::Cohorts), person.school_id, cohort).await?;
        let page = CohortPeoplePage { email: form.email, unknown: true, ..page };
        return Ok((StatusCode::UNPROCESSABLE_ENTITY, page).into_response());
    };
    let membership = Membership { school_id: person.school_id, cohort_id: id, person_id: known.id, role: known.role };
    cohorts::join(&mut tx, membership).await?;
    Entry::by(&person, "cohort.joined", known.id)
        .with(json!({ "cohort": id }))
        .append(&mut tx, state.clock.now())
        .await?;
    tx.commit().await?;
    Ok(Redirect::to(&format!("/cohorts/{id}/people")).into_response())
}

pub(super) async fn remove(
    State(state): State<AppState>,
    person: CurrentPerson,
    path: Result<Path<(Uuid, Uuid)>, PathRejection>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    let Path((id, member)) = path.map_err(|_| Error::NotFound)?;
    find(&state, &person, id).await?;
    let mut tx = state.db.write().await?;
    if !cohorts::leave(&mut tx, person.school_id, id, member).await? {
        return Err(Error::NotFound.into());
    }
    Entry::by(&person, "cohort.left", member).with(json!({ "cohort": id })).append(&mut tx, state.clock.now()).await?;
    tx.commit().await?;
    Ok(Redirect::to(&format!("/cohorts/{id}/people")))
}
