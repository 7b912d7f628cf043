//! `/`: a dashboard by role.

use axum::extract::{Query, State};
use axum::response::{IntoResponse, Response};

use super::standing::CohortStanding;
use super::trainees::PageQuery;
use super::{admin, cohorts, rows, trainees};
use crate::AppState;
use crate::domain::{CurrentPerson, Role};
use crate::error::{Error, PageError};
use crate::routes::auth::Csrf;
use crate::storage::reports::{self, Named};
use crate::views::cohort::CohortCard;
use crate::views::instructor::InstructorPage;
use crate::views::{Place, Shell};

pub(super) async fn show(
    State(state): State<AppState>,
    person: CurrentPerson,
    csrf: Csrf,
    Query(query): Query<PageQuery>,
) -> Result<Response, PageError> {
    let shell = Shell::new(&person, csrf.token(), Place::Home);
    Ok(match person.role {
        Role::Trainee => {
            let own = Named { id: person.id, name: person.display_name.clone() };
            trainees::page(&state, shell, &person, (own, query)).await?.into_response()
        }
        Role::Instructor => instructor(&state, shell, &person).await?.into_response(),
        Role::Administrator => admin::home(&state, shell, &person).await?.into_response(),
    })
}

async fn instructor(state: &AppState, shell: Shell, person: &CurrentPerson) -> Result<InstructorPage, Error> {
    let mut cards = Vec::new();
    let mut help = Vec::new();
    for (cohort, standing) in cohorts::standings(state, person).await? {
        cards.push(CohortCard::new((cohorts::href(&cohort), cohort.name.clone()), &standing.rows));
        let CohortStanding { rows, .. } = standing;
        help.extend(rows.into_iter().filter(|r| !r.concerns.is_empty()).map(|row| (cohort.name.clone(), row)));
    }
    let recent = rows::mixed(reports::latest_taught(state.db.reader(), person).await?);
    Ok(InstructorPage { shell, cohorts: cards, help, recent, now: state.clock.now().to_utc() })
}
