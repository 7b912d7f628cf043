//! `/cohorts` and `/cohorts/{id}`.

use acts::error::Error;
use axum::extract::{Query, State};
use model::ids::CohortId;
use model::{CurrentPerson, Role, count_u32};
use pages::cohort::{CohortLine, CohortPage, CohortsPage, CourseShare};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::{PathId, encode_in_query};
use routes_base::auth::{Csrf, Teacher, Visitor};
use routes_base::error::PageError;
use serde::Deserialize;
use store::reports;
use store::reports::NamedItem;

use super::standing::TaughtCourse;
use super::{gradebook, standing};

/// Cohorts per page.
const PER_PAGE: usize = 50;

/// Returns the address of a cohort's page.
pub(crate) fn cohort_href(cohort: &NamedItem<CohortId>) -> String {
    format!("/cohorts/{}", cohort.id)
}

/// Returns a page of the cohorts that a person may see, and the name after which the next page
/// begins.
pub(crate) async fn list_cohorts_in_short(
    state: &AppState,
    person: &CurrentPerson,
    after: &str,
    most: usize,
) -> Result<(Vec<CohortLine>, Option<String>), Error> {
    let limit = count_u32(most + 1);
    let mut found = reports::cohorts_in_short(state.db.reader(), person, after, limit).await?;
    let more = found.len() > most;
    found.truncate(most);
    let next = found.last().filter(|_| more).map(|last| last.name.clone());
    Ok((found.into_iter().map(CohortLine::new).collect(), next))
}

#[derive(Deserialize)]
pub(crate) struct AfterQuery {
    #[serde(default)]
    after: String,
}

pub(crate) async fn list_cohorts(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    csrf: Csrf,
    Query(AfterQuery { after }): Query<AfterQuery>,
) -> Result<CohortsPage, PageError> {
    let (cohorts, next) = list_cohorts_in_short(&state, &person, &after, PER_PAGE).await?;
    Ok(CohortsPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Cohorts),
        cohorts,
        later: !after.is_empty(),
        next: next.map(|last| format!("/cohorts?after={}", encode_in_query(&last))),
    })
}

pub(crate) async fn show_cohort(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<CohortId>,
    csrf: Csrf,
) -> Result<CohortPage, PageError> {
    let (reader, school) = (state.db.reader(), person.school_id);
    let cohort = reports::cohort(reader, &person, id).await?.ok_or(Error::NotFound)?;
    let courses = standing::taught_courses(&state, school).await?;
    let practised = standing::practice_of_cohort(&state, school, cohort).await?;
    let taught = standing::judged_courses(&courses);
    let standing = practised.standing(&taught, state.clock.now());
    let assigned = standing.assignments(&state, school).await?;
    let cohort = &practised.cohort;
    let instructors = reports::members(reader, school, id, Role::Instructor).await?;
    let share = |(i, taught): (usize, &TaughtCourse)| CourseShare::new(&taught.facts(None), &standing.in_course(i));
    let (begun, others): (Vec<CourseShare>, Vec<CourseShare>) =
        courses.iter().enumerate().map(share).partition(CourseShare::is_begun);
    Ok(CohortPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Cohorts),
        href: cohort_href(cohort),
        due_lines: gradebook::list_assignments_of_cohort(&assigned, &cohort.name),
        name: cohort.name.clone(),
        instructors: instructors.into_iter().map(|i| i.name).collect(),
        courses: begun,
        others: others.into_iter().map(|course| course.title).collect(),
        trainees: standing.rows(&courses, |_| true),
        now: state.clock.now().to_utc(),
    })
}
