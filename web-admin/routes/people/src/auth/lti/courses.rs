//! `/admin/platforms/{id}/courses`: the courses of a learning platform, and their members.

use acts::error::Error;
use acts::people::course_rosters;
use axum::extract::State;
use model::CurrentPerson;
use model::ids::{PlatformContextId, PlatformId};
use pages::auth::lti::{CourseForm, CourseRow, PlatformForm, PlatformPage};
use pages::form::{FilledForm, SelectOption};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Administrator, Csrf, CsrfForm, Visit};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use serde::Deserialize;
use store::auth::lti::courses;
use store::auth::lti::courses::{CourseKey, PlatformCourse};
use store::training::cohorts;

use super::platforms::{self, PAGE};

/// Courses on the page of a platform.
const MOST_COURSES: u32 = 200;

/// Returns the courses of a learning platform, each with the cohorts of the school.
pub(super) async fn list_courses(
    state: &AppState,
    person: &CurrentPerson,
    platform: PlatformId,
) -> Result<Vec<CourseRow>, Error> {
    let reader = state.db.reader();
    let known = cohorts::list_cohorts(reader, person.school_id).await?;
    let row = |course: PlatformCourse| CourseRow {
        href: format!("{PAGE}/{platform}/courses/{}", course.id),
        title: course.title.unwrap_or(course.context_id),
        seen: course.seen_at.to_utc(),
        cohorts: known
            .iter()
            .map(|cohort| SelectOption {
                value: cohort.id.to_string(),
                label: cohort.name.clone(),
                chosen: course.cohort_id == Some(cohort.id),
            })
            .collect(),
        has_members: course.members_url.is_some(),
        checked: course.checked_at.map(|at| at.to_utc()),
        differences: course.differences,
    };
    Ok(courses::list_courses(reader, person.school_id, platform, MOST_COURSES).await?.into_iter().map(row).collect())
}

#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct CoursePath {
    id: PlatformId,
    course: PlatformContextId,
}

pub(super) async fn change_course(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    PathId(path): PathId<CoursePath>,
    CsrfForm(form): CsrfForm<CourseForm>,
) -> Result<FormAnswer<PlatformPage>, PageError> {
    let key = CourseKey { school_id: person.school_id, platform_id: path.id, course_id: path.course };
    let cohort = match form.cohort.as_str() {
        "" => None,
        id => Some(id.parse().map_err(|_| Error::NotFound)?),
    };
    course_rosters::tie_course(&state, &person, key, cohort).await?;
    if !form.read {
        return Ok(FormAnswer::lead_to(&format!("{PAGE}/{}", path.id)));
    }
    match split_refusal(course_rosters::read_course(&state, &person, key, form.remove_missing).await)? {
        Ok(roster) => Ok(FormAnswer::lead_to(&format!("/people/rosters/{roster}"))),
        Err(why) => {
            let known = platforms::find(&state, &person, path.id).await?;
            let form = FilledForm::new(PlatformForm::from(&known.settings));
            let page = platforms::make_platform_page(&state, Visit::new(&person, &csrf), &known, form).await?;
            Ok(FormAnswer::Refused(PlatformPage { course_refused: Some(why), ..page }))
        }
    }
}
