//! `/assignments`: a trainee's own assignments; for teachers, assignments and their completion.

use std::collections::BTreeMap;

use acts::error::Error;
use acts::letters::notices;
use acts::training::assignments::LockedTrainees;
use acts::training::{assignments as teaching, deadlines};
use axum::extract::{Query, State};
use axum::response::{IntoResponse, Redirect, Response};
use model::ids::{AssignmentId, CohortId, PersonId, SchoolId};
use model::letters::notice::NoticePlace;
use model::training::assignment::{AssignmentTally, AssignmentTask};
use model::training::due;
use model::training::due::local;
use model::{CurrentPerson, Role};
use pages::form::{FilledForm, SelectOption, read_ticked_box};
use pages::people::listed::ListPart;
use pages::training::assignments::{
    AssignForm, AssignmentPage, AssignmentRow, ManagedAssignmentsPage, ManagedRow, OwnAssignmentsPage, task_href,
};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, CsrfForm, NoFields, Teacher, Visitor};
use routes_base::error::PageError;
use routes_base::forms::{ExtensionForm, FormAnswer, split_refusal};
use serde::Deserialize;
use store::authoring::exercises;
use store::operations::schools;
use store::people;
use store::training::assignments::{ManagedAssignment, NewAssignment};
use store::training::reports::NamedItem;
use store::training::{assignments, curricula, reports};

use super::gradebook;
use super::rows::PeopleOnPage;

/// Assignments on the page of those who make them.
const LATEST: u32 = 100;

/// The preselected task of a new assignment.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct ChosenTask {
    task: String,
}

pub(super) async fn list_assignments(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    Query(chosen): Query<ChosenTask>,
    csrf: Csrf,
) -> Result<Response, PageError> {
    let person = notices::note_read(&state, person, NoticePlace::Assignments).await?;
    let shell = Shell::new(&person, csrf.token(), NavPlace::Assignments);
    if person.role == Role::Trainee {
        let standings = teaching::standings(&state, person.school_id, person.id).await?;
        let rows = standings.into_iter().map(AssignmentRow::own).collect();
        return Ok(OwnAssignmentsPage { shell, rows }.into_response());
    }
    let begun = TypedAssignment { task: chosen.task, ..TypedAssignment::default() };
    Ok(managed_page(&state, shell, &person, FilledForm::new(begun)).await?.into_response())
}

async fn managed_page(
    state: &AppState,
    shell: Shell,
    person: &CurrentPerson,
    FilledForm { typed, refused }: FilledForm<TypedAssignment>,
) -> Result<ManagedAssignmentsPage, Error> {
    let rows = assignments::list_managed_assignments(state.db.reader(), person, None, LATEST).await?;
    let cohorts = reports::cohorts(state.db.reader(), person).await?;
    let cohort = |c: NamedItem<CohortId>| {
        let value = c.id.to_string();
        SelectOption { chosen: value == typed.cohort, value, label: c.name }
    };
    let form = AssignForm {
        tasks: task_options(state, person.school_id, &typed.task).await?,
        cohorts: cohorts.into_iter().map(cohort).collect(),
        email: typed.email,
        due: typed.due,
        limit: typed.limit,
        supervised: typed.supervised,
        since_only: typed.since_only,
        locked: typed.despite_locks,
        despite_locks: typed.despite_locks,
        mailed: typed.mailed,
        time_zone: schools::find_time_zone(state.db.reader(), person.school_id).await?,
    };
    let mut tallies = match person.role {
        Role::Instructor => gradebook::tally_assignments(state, person).await?,
        _ => BTreeMap::new(),
    };
    let row = |listed: ManagedAssignment| {
        let tally = tallies.remove(&listed.id);
        ManagedRow { tally, ..make_managed_row(listed) }
    };
    let rows = rows.into_iter().map(row).collect();
    Ok(ManagedAssignmentsPage { shell, rows, form: FilledForm { typed: form, refused } })
}

/// Each course with its exercises in order, then the exercises of no course; one of them chosen.
async fn task_options(state: &AppState, school: SchoolId, chosen: &str) -> Result<Vec<SelectOption>, Error> {
    let choice = |value: String, label: String| SelectOption { chosen: value == chosen, value, label };
    let exercise = |id: &str, title: &str| choice(format!("exercise:{id}"), title.to_owned());
    let mut options: Vec<SelectOption> = Vec::new();
    for (curriculum, course) in teaching::taught_curricula(state, school).await? {
        let title = tr!("Course: {title}", title = curriculum.title);
        options.push(choice(format!("course:{}", curriculum.curriculum_id), title));
        for step in &course.steps {
            let option = exercise(&step.exercise, &step.title);
            if !options.contains(&option) {
                options.push(option);
            }
        }
    }
    for alone in exercises::list_current_exercises(state.db.reader(), school).await? {
        let option = exercise(&alone.exercise_id, &alone.title);
        if !options.contains(&option) {
            options.push(option);
        }
    }
    Ok(options)
}

fn make_managed_row(listed: ManagedAssignment) -> ManagedRow {
    ManagedRow {
        href: format!("/assignments/{}", listed.id),
        title: listed.title,
        to: listed.to,
        due: listed.due_at.map(|at| local(at, &listed.time_zone)),
        limit: listed.attempt_limit,
        supervised: listed.supervised,
        since_only: listed.since_only,
        tally: None,
    }
}

/// The submitted form of an assignment.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct TypedAssignment {
    task: String,
    cohort: String,
    email: String,
    due: String,
    limit: String,
    #[serde(deserialize_with = "read_ticked_box")]
    supervised: bool,
    #[serde(deserialize_with = "read_ticked_box")]
    since_only: bool,
    #[serde(deserialize_with = "read_ticked_box")]
    despite_locks: bool,
    #[serde(deserialize_with = "read_ticked_box")]
    mailed: bool,
}

pub(super) async fn make_assignment(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
    CsrfForm(typed): CsrfForm<TypedAssignment>,
) -> Result<FormAnswer<ManagedAssignmentsPage>, PageError> {
    let read = split_refusal(read_assignment(&state, &person, &typed).await)?;
    let locks = match &read {
        Ok(new) if !typed.despite_locks => teaching::find_locked_trainees(&state, person.school_id, new).await?,
        _ => None,
    };
    let (made, locked) = match (read, locks) {
        (Ok(_), Some(locks)) => (Err(say_locks(&locks)), true),
        (Ok(new), None) => (split_refusal(teaching::make(&state, &person, &new).await)?, false),
        (Err(why), _) => (Err(why), false),
    };
    match made {
        Ok(id) => {
            if typed.mailed {
                notices::mail_assignees(&state, &person, id).await?;
            }
            Ok(FormAnswer::lead_to(&format!("/assignments/{id}")))
        }
        Err(why) => {
            let shell = Shell::new(&person, csrf.token(), NavPlace::Assignments);
            let mut page = managed_page(&state, shell, &person, FilledForm::refused(typed, why)).await?;
            page.form.typed.locked |= locked;
            Ok(FormAnswer::Refused(page))
        }
    }
}

/// Explains how many trainees cannot start yet, and which exercises they must master first.
fn say_locks(locks: &LockedTrainees) -> String {
    let missing = locks.missing.iter().map(String::as_str).collect::<Vec<_>>().join(", ");
    trn!(
        "it is locked for {n} trainee of {of}, who must first master {missing}; tick “Assign anyway”, or assign that first",
        "it is locked for {n} trainees of {of}, who must first master {missing}; tick “Assign anyway”, or assign that first",
        locks.locked,
        of = locks.of,
        missing = missing
    )
}

/// Parses the form. A cohort, trainee, exercise or course that the visitor may not see is answered
/// with 404.
async fn read_assignment(
    state: &AppState,
    person: &CurrentPerson,
    typed: &TypedAssignment,
) -> Result<NewAssignment, Error> {
    let time_zone = schools::find_time_zone(state.db.reader(), person.school_id).await?;
    let task = read_task(state, person.school_id, &typed.task).await?;
    let (cohort_id, person_id) = read_assignee(state, person, typed).await?;
    let due = match typed.due.trim() {
        "" => None,
        said => {
            let due = due::read(said, &time_zone).map_err(|refused| Error::Unprocessable(refused.to_string()))?;
            if due.at < state.clock.now() {
                return Err(Error::Unprocessable(tr!("the due date is in the past").to_owned()));
            }
            Some((due.local, due.at))
        }
    };
    let attempt_limit = match (typed.limit.trim(), &task) {
        ("", _) | (_, AssignmentTask::Course(_)) => None,
        (said, AssignmentTask::Exercise(_)) => Some(read_attempt_limit(said)?),
    };
    Ok(NewAssignment {
        task,
        cohort_id,
        person_id,
        supervised: typed.supervised,
        since_only: typed.since_only,
        attempt_limit,
        due,
        time_zone,
    })
}

fn read_attempt_limit(said: &str) -> Result<u32, Error> {
    let number = said.parse().ok().filter(|number| (1..=100).contains(number));
    number.ok_or_else(|| Error::Unprocessable(tr!("attempts that count: “{said}”; allowed: 1 to 100", said = said)))
}

async fn read_task(state: &AppState, school: SchoolId, said: &str) -> Result<AssignmentTask, Error> {
    let reader = state.db.reader();
    match said.split_once(':') {
        Some(("exercise", id)) if exercises::find_current_revision(reader, school, id).await?.is_some() => {
            Ok(AssignmentTask::Exercise(id.to_owned()))
        }
        Some(("course", id))
            if curricula::list_taught_curricula(reader, school).await?.iter().any(|c| c.curriculum_id == id) =>
        {
            Ok(AssignmentTask::Course(id.to_owned()))
        }
        _ => Err(Error::NotFound),
    }
}

/// Returns the chosen cohort or trainee.
async fn read_assignee(
    state: &AppState,
    person: &CurrentPerson,
    typed: &TypedAssignment,
) -> Result<(Option<CohortId>, Option<PersonId>), Error> {
    match (typed.cohort.trim(), typed.email.trim()) {
        ("", "") => Err(Error::Unprocessable(tr!("choose a cohort, or enter a trainee’s address").to_owned())),
        (cohort, "") => {
            let id: CohortId = cohort.parse().map_err(|_| Error::NotFound)?;
            reports::cohort(state.db.reader(), person, id).await?.ok_or(Error::NotFound)?;
            Ok((Some(id), None))
        }
        ("", email) => {
            let known = people::find_member_by_email(state.db.reader(), person.school_id, email)
                .await?
                .filter(|known| known.role == Role::Trainee);
            let seen = match known {
                Some(known) => reports::trainee(state.db.reader(), person, known.id).await?,
                None => None,
            };
            let nobody = || {
                Error::Unprocessable(tr!(
                    "the trainee: “{email}”; none of your trainees has this address",
                    email = email
                ))
            };
            seen.map(|trainee| (None, Some(trainee.id))).ok_or_else(nobody)
        }
        _ => Err(Error::Unprocessable(tr!("choose a cohort or enter a trainee’s address, not both").to_owned())),
    }
}

/// Returns an assignment that the visitor manages.
async fn find_assignment(
    state: &AppState,
    person: &CurrentPerson,
    id: AssignmentId,
) -> Result<ManagedAssignment, Error> {
    if person.role == Role::Trainee {
        return Err(Error::NotFound);
    }
    let found = assignments::list_managed_assignments(state.db.reader(), person, Some(id), 1).await?;
    found.into_iter().next().ok_or(Error::NotFound)
}

pub(super) async fn show_assignment(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<AssignmentId>,
    Query(query): Query<PeopleOnPage>,
    csrf: Csrf,
) -> Result<Response, PageError> {
    if person.role == Role::Trainee {
        return Ok(lead_to_task(&state, &person, id).await?.into_response());
    }
    let listed = find_assignment(&state, &person, id).await?;
    let trainees = trainees_of_assignment(&state, &person, &listed).await?;
    let ids: Vec<PersonId> = trainees.iter().map(|trainee| trainee.id).collect();
    let standings = teaching::standings_at(&state, person.school_id, id, &ids).await?;
    let tally = AssignmentTally::of(standings.iter());
    let row_of = |(trainee, standing): (NamedItem<PersonId>, _)| {
        let href = format!("/trainees/{}", trainee.id);
        AssignmentRow::new(standing, trainee.name, href, trainee.id.to_string())
    };
    let mut rows: Vec<AssignmentRow> = trainees.into_iter().zip(standings).map(row_of).collect();
    rows.sort_by_key(|row| !row.overdue);
    let (rows, list) = ListPart::of(query.into(), rows, |row| &row.title);
    let shell = Shell::new(&person, csrf.token(), NavPlace::Assignments);
    let gradebook = listed.cohort_id.map(|cohort| format!("/cohorts/{cohort}/gradebook"));
    let assignment = make_managed_row(listed);
    Ok(AssignmentPage { shell, id, assignment, tally, rows, list, gradebook }.into_response())
}

/// Leads a trainee from a link to an assignment of theirs to what is to be done.
async fn lead_to_task(state: &AppState, person: &CurrentPerson, id: AssignmentId) -> Result<Redirect, Error> {
    let own = assignments::list_trainee_assignments(state.db.reader(), person.school_id, person.id).await?;
    let assigned = own.into_iter().find(|assigned| assigned.id == id).ok_or(Error::NotFound)?;
    Ok(Redirect::to(&task_href(&assigned.task)))
}

async fn trainees_of_assignment(
    state: &AppState,
    person: &CurrentPerson,
    listed: &ManagedAssignment,
) -> Result<Vec<NamedItem<PersonId>>, Error> {
    let reader = state.db.reader();
    Ok(match (listed.cohort_id, listed.person_id) {
        (Some(cohort), _) => reports::members(reader, person.school_id, cohort, Role::Trainee).await?,
        (None, Some(trainee)) => reports::trainee(reader, person, trainee).await?.into_iter().collect(),
        (None, None) => Vec::new(),
    })
}

pub(super) async fn extend_assignment(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<AssignmentId>,
    CsrfForm(form): CsrfForm<ExtensionForm>,
) -> Result<Redirect, PageError> {
    let listed = find_assignment(&state, &person, id).await?;
    let trainees = trainees_of_assignment(&state, &person, &listed).await?;
    if !trainees.iter().any(|trainee| trainee.id == form.person) {
        return Err(Error::NotFound.into());
    }
    deadlines::extend(&state, &person, teaching::dated(&listed), form.person, form.days).await?;
    Ok(Redirect::to(&format!("/assignments/{id}")))
}

pub(super) async fn withdraw_assignment(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<AssignmentId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    find_assignment(&state, &person, id).await?;
    teaching::withdraw(&state, &person, id).await?;
    Ok(Redirect::to("/assignments"))
}
