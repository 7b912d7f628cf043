//! `/`: the home page of each role.

use acts::error::Error;
use acts::training::risks;
use axum::extract::{Query, State};
use axum::response::{IntoResponse, Response};
use model::{CurrentPerson, Role};
use pages::training::cohort::{CohortCard, CohortPage};
use pages::training::instructor::InstructorPage;
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::auth::{Csrf, Visitor};
use routes_base::error::PageError;
use store::training::reports;
use store::training::reports::NamedItem;
use store::training::risks::RiskScope;

use crate::operations::admin;
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
    let (mut help, mut due, mut helped) = (Vec::new(), Vec::new(), 0);
    let at_risk = risks::list_people_at_risk(state, person, RiskScope::Teacher(person.id)).await?;
    for practised in standing::practice_of_cohorts(state, person).await? {
        let (cohort, now) = (&practised.cohort, state.clock.now());
        let standing = practised.standing(&taught, now);
        let assigned = standing.assignments(state, person.school_id).await?;
        due.extend(gradebook::list_pressing_assignments(&assigned, &cohort.name, now));
        let everybody = standing.concerned(&at_risk);
        let need_help = standing::sort_help(&everybody);
        helped += need_help.len();
        cards.push(CohortCard {
            complete: standing.count_complete(courses.len()),
            help: need_help.len(),
            ..CohortCard::new(cohorts::cohort_href(cohort), cohort.name.clone(), standing.main())
        });
        let shown = need_help.into_iter().take(CohortPage::HELP_SHOWN).filter_map(|one| one.row(&courses, None));
        help.extend(shown.map(|row| (cohort.name.clone(), row)));
    }
    let more_help = helped - help.len();
    let recent = rows::mixed_rows(reports::latest_taught(reader, person).await?);
    let news = news::list_news(state, person).await?;
    let now = state.clock.now().to_utc();
    Ok(InstructorPage { shell, news, cohorts: cards, help, more_help, due_lines: due, recent, now })
}
