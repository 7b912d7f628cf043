//! `/`: the home page of each role.

use acts::error::Error;
use axum::extract::{Query, State};
use axum::response::{IntoResponse, Response};
use model::{CurrentPerson, Role};
use pages::cohort::CohortCard;
use pages::instructor::InstructorPage;
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::auth::{Csrf, Visitor};
use routes_base::error::PageError;
use store::reports;
use store::reports::NamedItem;

use super::admin;
use crate::training::trainees::TraineePageQuery;
use crate::training::{cohorts, gradebook, news, rows, standing, trainees};

pub(super) async fn show_home(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    csrf: Csrf,
    Query(query): Query<TraineePageQuery>,
) -> Result<Response, PageError> {
    let shell = Shell::new(&person, csrf.token(), NavPlace::Home);
    Ok(match person.role {
        Role::Trainee | Role::Guest => {
            let own = NamedItem { id: person.id, name: person.display_name.clone() };
            trainees::make_trainee_page(&state, shell, &person, own, query).await?.into_response()
        }
        Role::Instructor => make_instructor_home(&state, shell, &person).await?.into_response(),
        Role::Administrator => admin::make_admin_home(&state, shell, &person).await?.into_response(),
    })
}

async fn make_instructor_home(state: &AppState, shell: Shell, person: &CurrentPerson) -> Result<InstructorPage, Error> {
    let reader = state.db.reader();
    let courses = standing::taught_courses(state, person.school_id).await?;
    let taught = standing::judged_courses(&courses);
    let mut cards = Vec::new();
    let (mut help, mut due) = (Vec::new(), Vec::new());
    for practised in standing::practice_of_cohorts(state, person).await? {
        let (cohort, standing) = (&practised.cohort, practised.standing(&taught, state.clock.now()));
        let assigned = standing.assignments(state, person.school_id).await?;
        due.extend(gradebook::list_pressing_assignments(&assigned, &cohort.name, state.clock.now()));
        cards.push(CohortCard::new(cohorts::cohort_href(cohort), cohort.name.clone(), standing.main()));
        let rows = standing.rows(&courses, |progress| !progress.concerns.is_empty());
        help.extend(rows.into_iter().map(|row| (cohort.name.clone(), row)));
    }
    let recent = rows::mixed_rows(reports::latest_taught(reader, person).await?);
    let news = news::list_news(state, person).await?;
    let now = state.clock.now().to_utc();
    Ok(InstructorPage { shell, news, cohorts: cards, help, due_lines: due, recent, now })
}
