//! Membership of cohorts: administrators decide; instructors send requests, which the trainee or an
//! administrator answers.

use acts::error::Error;
use acts::training::cohorts as membership;
use acts::training::cohorts::RequestKey;
use axum::extract::rejection::PathRejection;
use axum::extract::{Path, Query, State};
use axum::response::Redirect;
use model::ids::{CohortId, PersonId, SchoolId};
use model::people::roster::is_name;
use model::{CurrentPerson, Role};
use pages::form::FilledForm;
use pages::people::listed::ListPart;
use pages::people::{CohortMember, CohortPeoplePage, UnknownAddress};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, CsrfForm, NoFields, Teacher, Visitor};
use routes_base::error::PageError;
use routes_base::forms::FormAnswer;
use serde::Deserialize;
use store::training::reports::NamedItem;
use store::training::{cohorts, reports};

use super::rows::PeopleOnPage;

#[derive(Deserialize)]
pub(super) struct CohortForm {
    name: String,
}

/// Creates a cohort; an instructor teaches the cohorts that they create.
pub(super) async fn make_cohort(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    CsrfForm(form): CsrfForm<CohortForm>,
) -> Result<Redirect, PageError> {
    let name = form.name.trim();
    if !is_name(name) {
        let why = tr!(
            "the cohort’s name: “{name}”; allowed: 1 to 120 characters, not beginning with = + - or @",
            name = name
        );
        return Err(Error::Unprocessable(why).into());
    }
    let cohort = membership::make_cohort(&state, &person, name).await?;
    Ok(Redirect::to(&format!("/cohorts/{}/people", cohort.id)))
}

/// Returns a cohort that the visitor may change.
async fn find_taught_cohort(
    state: &AppState,
    person: &CurrentPerson,
    id: CohortId,
) -> Result<NamedItem<CohortId>, Error> {
    let cohorts = reports::cohorts(state.db.reader(), person).await?;
    cohorts.into_iter().find(|cohort| cohort.id == id).ok_or(Error::NotFound)
}

pub(super) async fn show_cohort_people(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<CohortId>,
    Query(query): Query<PeopleOnPage>,
    csrf: Csrf,
) -> Result<CohortPeoplePage, PageError> {
    let cohort = find_taught_cohort(&state, &person, id).await?;
    let shell = Shell::new(&person, csrf.token(), NavPlace::Cohorts);
    Ok(make_people_page(&state, shell, ShownCohort { school: person.school_id, cohort }, query).await?)
}

/// A cohort of a school.
struct ShownCohort {
    school: SchoolId,
    cohort: NamedItem<CohortId>,
}

async fn make_people_page(
    state: &AppState,
    shell: Shell,
    ShownCohort { school, cohort }: ShownCohort,
    query: PeopleOnPage,
) -> Result<CohortPeoplePage, Error> {
    let mut members = Vec::new();
    for role in [Role::Instructor, Role::Trainee] {
        let named = reports::members(state.db.reader(), school, cohort.id, role).await?;
        let member = |person: NamedItem<PersonId>| CohortMember { id: person.id.to_string(), name: person.name, role };
        members.extend(named.into_iter().map(member));
    }
    let (members, list) = ListPart::of(query.into(), members, |one| &one.name);
    let href = format!("/cohorts/{}", cohort.id);
    let requests = cohorts::list_membership_requests(state.db.reader(), school, Some(cohort.id), None).await?;
    Ok(CohortPeoplePage { shell, href, name: cohort.name, members, list, requests, email: FilledForm::default() })
}

#[derive(Deserialize)]
pub(super) struct MemberForm {
    email: String,
}

/// Adds a person of the school, if an administrator does it; else sends a request. A person of
/// another school is answered like an unknown one.
pub(super) async fn add_to_cohort(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<CohortId>,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<MemberForm>,
) -> Result<FormAnswer<CohortPeoplePage>, PageError> {
    let cohort = find_taught_cohort(&state, &person, id).await?;
    if !membership::add_member(&state, &person, id, form.email.trim()).await? {
        let shell = Shell::new(&person, csrf.token(), NavPlace::Cohorts);
        let shown = ShownCohort { school: person.school_id, cohort };
        let page = make_people_page(&state, shell, shown, PeopleOnPage::default()).await?;
        let email = FilledForm::refused(form.email, UnknownAddress);
        return Ok(FormAnswer::Refused(CohortPeoplePage { email, ..page }));
    }
    Ok(FormAnswer::lead_to(&format!("/cohorts/{id}/people")))
}

#[derive(Deserialize)]
pub(super) struct RequestAnswerForm {
    answer: String,
}

impl RequestAnswerForm {
    fn joins(&self) -> Result<bool, Error> {
        match self.answer.as_str() {
            "yes" => Ok(true),
            "no" => Ok(false),
            other => Err(Error::BadRequest(format!("answer: \"{other}\"; allowed: yes, no"))),
        }
    }
}

/// Answers a request as an administrator; the cohort's teachers may withdraw it.
pub(super) async fn answer_request(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    path: Result<Path<(CohortId, PersonId)>, PathRejection>,
    CsrfForm(form): CsrfForm<RequestAnswerForm>,
) -> Result<Redirect, PageError> {
    let Path((id, asked)) = path.map_err(|_| Error::NotFound)?;
    find_taught_cohort(&state, &person, id).await?;
    if form.answer == "yes" && person.role != Role::Administrator {
        return Err(Error::Forbidden(tr!("only the trainee or an administrator can agree")).into());
    }
    let request = RequestKey { cohort_id: id, person_id: asked };
    membership::answer_request(&state, &person, request, form.joins()?).await?;
    Ok(Redirect::to(&format!("/cohorts/{id}/people")))
}

/// Answers a request as the trainee.
pub(super) async fn answer_own_request(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(cohort): PathId<CohortId>,
    CsrfForm(form): CsrfForm<RequestAnswerForm>,
) -> Result<Redirect, PageError> {
    // Teaching a cohort gives access to its trainees' data, so instructors cannot accept that
    // themselves.
    if form.answer == "yes" && person.role != Role::Trainee {
        return Err(Error::Forbidden(tr!("an administrator decides who teaches a cohort")).into());
    }
    let request = RequestKey { cohort_id: cohort, person_id: person.id };
    membership::answer_request(&state, &person, request, form.joins()?).await?;
    Ok(Redirect::to("/account#cohorts"))
}

pub(super) async fn remove_from_cohort(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    path: Result<Path<(CohortId, PersonId)>, PathRejection>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    let Path((id, member)) = path.map_err(|_| Error::NotFound)?;
    find_taught_cohort(&state, &person, id).await?;
    membership::remove_member(&state, &person, id, member).await?;
    Ok(Redirect::to(&format!("/cohorts/{id}/people")))
}
