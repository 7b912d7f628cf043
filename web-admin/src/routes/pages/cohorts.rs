//! `/cohorts` and `/cohorts/{id}`.

use axum::extract::State;

use super::Id;
use super::standing::{self, CohortStanding};
use crate::AppState;
use crate::domain::{CurrentPerson, Role};
use crate::error::{Error, PageError};
use crate::routes::auth::Csrf;
use crate::storage::reports::{self, Named};
use crate::views::cohort::{CohortCard, CohortPage, CohortsPage, CourseShare};
use crate::views::{Place, Shell};

/// The page of a cohort.
pub(super) fn href(cohort: &Named) -> String {
    format!("/cohorts/{}", cohort.id)
}

/// Every cohort that a person may see, with its standing.
pub(super) async fn standings(state: &AppState, person: &CurrentPerson) -> Result<Vec<(Named, CohortStanding)>, Error> {
    let courses = standing::courses(state, person.school_id).await?;
    let mut standings = Vec::new();
    for cohort in reports::cohorts(state.db.reader(), person).await? {
        let standing = standing::cohort(state, person.school_id, cohort.id, &courses).await?;
        standings.push((cohort, standing));
    }
    Ok(standings)
}

/// Every cohort that a person may see, in short.
pub(super) async fn cards(state: &AppState, person: &CurrentPerson) -> Result<Vec<CohortCard>, Error> {
    let standings = standings(state, person).await?;
    Ok(standings.iter().map(|(c, s)| CohortCard::new((href(c), c.name.clone()), &s.rows)).collect())
}

pub(super) async fn list(
    State(state): State<AppState>,
    person: CurrentPerson,
    csrf: Csrf,
) -> Result<CohortsPage, PageError> {
    if person.role == Role::Trainee {
        return Err(PageError(Error::Forbidden("cohorts are shown to those who teach them")));
    }
    let cohorts = cards(&state, &person).await?;
    Ok(CohortsPage { shell: Shell::new(&person, csrf.token(), Place::Cohorts), cohorts })
}

pub(super) async fn show(
    State(state): State<AppState>,
    person: CurrentPerson,
    Id(id): Id,
    csrf: Csrf,
) -> Result<CohortPage, PageError> {
    let (reader, school) = (state.db.reader(), person.school_id);
    let cohort = reports::cohorts(reader, &person).await?.into_iter().find(|c| c.id == id).ok_or(Error::NotFound)?;
    let courses = standing::courses(&state, school).await?;
    let standing = standing::cohort(&state, school, id, &courses).await?;
    let instructors = reports::members(reader, school, id, Role::Instructor).await?;
    let shares = courses.iter().zip(&standing.by_course);
    Ok(CohortPage {
        shell: Shell::new(&person, csrf.token(), Place::Cohorts),
        href: href(&cohort),
        name: cohort.name,
        instructors: instructors.into_iter().map(|i| i.name).collect(),
        courses: shares.map(|(taught, trainees)| CourseShare::new(&taught.facts(None), trainees)).collect(),
        trainees: standing.rows,
        now: state.clock.now().to_utc(),
    })
}
