//! `/cohorts` and `/cohorts/{id}`.

use acts::error::Error;
use acts::training::risks;
use axum::extract::{Query, State};
use model::ids::CohortId;
use model::training::progress::Progress;
use model::{CurrentPerson, Role, count_u32};
use pages::form::SelectOption;
use pages::people::listed::{ListPart, ListQuery};
use pages::training::cohort::{CohortFigures, CohortLine, CohortPage, CohortsPage, CourseShare};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::{PathId, encode_in_query};
use routes_base::auth::{Csrf, Teacher, Visitor};
use routes_base::error::PageError;
use serde::Deserialize;
use store::training::reports;
use store::training::reports::NamedItem;
use store::training::risks::RiskScope;

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

/// What of a cohort is to be shown.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(crate) struct CohortQuery {
    /// A course, by its id.
    course: String,
    q: String,
    page: Option<u32>,
}

impl CohortQuery {
    /// What is looked for among its people.
    fn into_list(self, course: &str) -> ListQuery {
        let Self { q, page, .. } = self;
        let kept = [("course", course.to_owned())];
        ListQuery { q, page, kept: kept.into_iter().filter(|(_, value)| !value.is_empty()).collect() }
    }
}

pub(crate) async fn show_cohort(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<CohortId>,
    Query(query): Query<CohortQuery>,
    csrf: Csrf,
) -> Result<CohortPage, PageError> {
    let (reader, school) = (state.db.reader(), person.school_id);
    let cohort = reports::cohort(reader, &person, id).await?.ok_or(Error::NotFound)?;
    let courses = standing::taught_courses(&state, school).await?;
    let practised = standing::practice_of_cohort(&state, school, cohort).await?;
    let taught = standing::judged_courses(&courses);
    let now = state.clock.now();
    let standing = practised.standing(&taught, now);
    let assigned = standing.assignments(&state, school).await?;
    let cohort = &practised.cohort;
    let instructors = reports::members(reader, school, id, Role::Instructor).await?;
    let at_risk = risks::list_people_at_risk(&state, &person, RiskScope::Cohort(id)).await?;
    let everybody = standing.concerned(&at_risk);
    let help = standing::sort_help(&everybody);
    let asked = courses.iter().position(|taught| taught.id == query.course);
    let chosen = asked.or_else(|| standing.find_begun_course(courses.len()));
    let in_course = chosen.map(|course| standing.in_course(course)).unwrap_or_default();
    let progress: Vec<&Progress> = in_course.iter().map(|(_, progress)| *progress).collect();
    let figures = CohortFigures { trainees: everybody.len(), ..CohortFigures::new(&progress, help.len()) };
    let course_id = chosen.map_or("", |course| courses[course].id.as_str());
    let (listed, list) = ListPart::of(query.into_list(course_id), everybody.iter().collect(), |one| one.name());
    let shown = help.iter().take(CohortPage::HELP_SHOWN);
    Ok(CohortPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Cohorts),
        href: cohort_href(cohort),
        risk_href: format!("/at-risk?cohort={id}"),
        due_lines: gradebook::list_assignments_of_cohort(&assigned, &cohort.name),
        name: cohort.name.clone(),
        instructors: instructors.into_iter().map(|i| i.name).collect(),
        figures,
        help: shown.filter_map(|one| one.row(&courses, None)).collect(),
        courses: list_course_options(&courses, chosen),
        course: chosen.map(|course| CourseShare::new(&courses[course].facts(None), &in_course)),
        trainees: listed.into_iter().filter_map(|one| one.row(&courses, chosen)).collect(),
        list,
        now: now.to_utc(),
    })
}

/// The courses of a school to choose from.
pub(super) fn list_course_options(courses: &[TaughtCourse], chosen: Option<usize>) -> Vec<SelectOption> {
    let option = |(at, taught): (usize, &TaughtCourse)| SelectOption {
        value: taught.id.clone(),
        label: taught.title.clone(),
        chosen: chosen == Some(at),
    };
    courses.iter().enumerate().map(option).collect()
}
