//! Who is in a cohort: administrators decide it; its instructors ask, and the trainee or an administrator answers.

use axum::extract::rejection::PathRejection;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Redirect, Response};
use serde::Deserialize;
use serde_json::json;
use uuid::Uuid;

use super::Id;
use crate::AppState;
use crate::error::PageError;
use crate::routes::auth::{Csrf, CsrfForm, NoFields, Visitor};
use acts::error::Error;
use model::roster::is_name;
use model::{CurrentPerson, Role};
use pages::people::CohortPeoplePage;
use pages::{Place, Shell};
use store::audit::Entry;
use store::cohorts::{self, Deed, Membership};
use store::people;
use store::reports::{self, Named};

#[derive(Deserialize)]
pub(super) struct CohortForm {
    name: String,
}

/// Makes a cohort; an instructor teaches what they have made.
pub(super) async fn make(
    State(state): State<AppState>,
    Visitor(person): Visitor,
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
        cohorts::join(&mut tx, own, deed(&state, &person)).await?;
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
    Visitor(person): Visitor,
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
    let requests = cohorts::requests(state.db.reader(), school, (Some(cohort.id), None)).await?;
    Ok(CohortPeoplePage { shell, href, name: cohort.name, members, requests, email: String::new(), unknown: false })
}

#[derive(Deserialize)]
pub(super) struct MemberForm {
    email: String,
}

/// Adds somebody of the school, where an administrator does it, else asks for them. Whoever is of another school is answered
/// like nobody.
pub(super) async fn add(
    State(state): State<AppState>,
    Visitor(person): Visitor,
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
    let (school_id, deed) = (person.school_id, deed(&state, &person));
    let (done, action) = match person.role {
        Role::Administrator => {
            let membership = Membership { school_id, cohort_id: id, person_id: known.id, role: known.role };
            cohorts::join(&mut tx, membership, deed).await?;
            (true, "cohort.joined")
        }
        _ => (cohorts::ask(&mut tx, (school_id, id, known.id), (person.id, deed.at)).await?, "cohort.asked"),
    };
    if done {
        Entry::by(&person, action, known.id).with(json!({ "cohort": id })).append(&mut tx, deed.at).await?;
    }
    tx.commit().await?;
    Ok(Redirect::to(&format!("/cohorts/{id}/people")).into_response())
}

fn deed(state: &AppState, by: &CurrentPerson) -> Deed {
    Deed { by: Some(by.id), at: state.clock.now() }
}

#[derive(Deserialize)]
pub(super) struct AnswerForm {
    answer: String,
}

/// An administrator's answer where somebody is asked for; whoever teaches the cohort may take the question back.
pub(super) async fn answer(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    path: Result<Path<(Uuid, Uuid)>, PathRejection>,
    CsrfForm(form): CsrfForm<AnswerForm>,
) -> Result<Redirect, PageError> {
    let Path((id, asked)) = path.map_err(|_| Error::NotFound)?;
    find(&state, &person, id).await?;
    if form.answer == "yes" && person.role != Role::Administrator {
        return Err(Error::Forbidden(tr!("only the trainee or an administrator says yes")).into());
    }
    settle(&state, &person, (id, asked), &form.answer).await?;
    Ok(Redirect::to(&format!("/cohorts/{id}/people")))
}

/// A trainee's own answer.
pub(super) async fn answer_for_oneself(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    Id(cohort): Id,
    CsrfForm(form): CsrfForm<AnswerForm>,
) -> Result<Redirect, PageError> {
    // Who teaches would see the trainees of others: that is not theirs to agree to.
    if form.answer == "yes" && person.role != Role::Trainee {
        return Err(Error::Forbidden(tr!("an administrator decides who teaches a cohort")).into());
    }
    settle(&state, &person, (cohort, person.id), &form.answer).await?;
    Ok(Redirect::to("/account#cohorts"))
}

/// Answers a request; there must be one.
async fn settle(
    state: &AppState,
    by: &CurrentPerson,
    (cohort_id, person_id): (Uuid, Uuid),
    answer: &str,
) -> Result<(), Error> {
    let (school_id, deed) = (by.school_id, deed(state, by));
    let mut tx = state.db.write().await?;
    let asked = cohorts::requests(&mut *tx, school_id, (Some(cohort_id), Some(person_id))).await?;
    let role = asked.first().ok_or(Error::NotFound)?.role;
    let action = match answer {
        "yes" => {
            cohorts::join(&mut tx, Membership { school_id, cohort_id, person_id, role }, deed).await?;
            "cohort.joined"
        }
        "no" => {
            cohorts::decline(&mut tx, (school_id, cohort_id, person_id), deed).await?;
            "cohort.declined"
        }
        other => return Err(Error::BadRequest(format!("answer: \"{other}\"; allowed are yes and no"))),
    };
    Entry::by(by, action, person_id).with(json!({ "cohort": cohort_id })).append(&mut tx, deed.at).await?;
    Ok(tx.commit().await?)
}

pub(super) async fn remove(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    path: Result<Path<(Uuid, Uuid)>, PathRejection>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    let Path((id, member)) = path.map_err(|_| Error::NotFound)?;
    find(&state, &person, id).await?;
    let mut tx = state.db.write().await?;
    if !cohorts::leave(&mut tx, (person.school_id, id, member), deed(&state, &person)).await? {
        return Err(Error::NotFound.into());
    }
    Entry::by(&person, "cohort.left", member).with(json!({ "cohort": id })).append(&mut tx, state.clock.now()).await?;
    tx.commit().await?;
    Ok(Redirect::to(&format!("/cohorts/{id}/people")))
}
