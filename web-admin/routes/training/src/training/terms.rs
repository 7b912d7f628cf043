//! `/admin/terms`: the terms of a school; `/cohorts/{id}/programme`: a cohort compared with the year
//! before.

use acts::error::Error;
use acts::training::terms as acting;
use axum::extract::{Query, State};
use axum::response::Redirect;
use model::ids::{CohortId, SchoolId, TermId};
use model::training::term::{CohortTerm, MOST_WEEKS, TermFigures, TermSpan, USUAL_PAUSE_WEEKS};
use model::{CurrentPerson, Role};
use pages::form::{FilledForm, SelectOption};
use pages::training::programme::{CohortComparison, ComparedCohort, ProgrammePage, TermForm, TermsPage};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Administrator, Csrf, CsrfForm, NoFields, Teacher, Visit};
use routes_base::error::PageError;
use routes_base::forms::{FormAnswer, split_refusal};
use serde::Deserialize;
use store::training::reports::NamedItem;
use store::training::{practice, reports, terms};

use super::cohorts::{cohort_href, list_course_options};
use super::standing;
use super::standing::TaughtCourse;

/// Weeks without practice that may be called a pause.
const PAUSES: std::ops::RangeInclusive<u32> = 1..=12;

pub(super) async fn show_terms(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
) -> Result<TermsPage, PageError> {
    Ok(make_terms_page(&state, Visit::new(&person, &csrf), FilledForm::default()).await?)
}

async fn make_terms_page(
    state: &AppState,
    Visit { person, csrf }: Visit<'_>,
    form: FilledForm<TermForm>,
) -> Result<TermsPage, Error> {
    let shell = Shell::new(person, csrf.token(), NavPlace::Administration);
    Ok(TermsPage { shell, terms: terms::list_terms(state.db.reader(), person.school_id).await?, form })
}

pub(super) async fn add_term(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    csrf: Csrf,
    CsrfForm(form): CsrfForm<TermForm>,
) -> Result<FormAnswer<TermsPage>, PageError> {
    match split_refusal(acting::add_term(&state, &person, &form.name, &form.starts_on).await)? {
        Ok(()) => Ok(FormAnswer::lead_to("/admin/terms")),
        Err(why) => {
            let form = FilledForm::refused(form, why);
            Ok(FormAnswer::Refused(make_terms_page(&state, Visit::new(&person, &csrf), form).await?))
        }
    }
}

pub(super) async fn remove_term(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    PathId(id): PathId<TermId>,
    CsrfForm(NoFields {}): CsrfForm<NoFields>,
) -> Result<Redirect, PageError> {
    acting::remove_term(&state, &person, id).await?;
    Ok(Redirect::to("/admin/terms"))
}

#[derive(Deserialize)]
pub(super) struct CohortTermForm {
    /// Id of the term; empty for none.
    term: String,
}

pub(super) async fn set_cohort_term(
    State(state): State<AppState>,
    Administrator(person): Administrator,
    PathId(id): PathId<CohortId>,
    CsrfForm(form): CsrfForm<CohortTermForm>,
) -> Result<Redirect, PageError> {
    let cohort = reports::cohort(state.db.reader(), &person, id).await.map_err(Error::from)?;
    cohort.ok_or(Error::NotFound)?;
    let term = match form.term.as_str() {
        "" => None,
        id => Some(id.parse::<TermId>().map_err(|_| Error::NotFound)?),
    };
    acting::set_cohort_term(&state, &person, id, term).await?;
    Ok(Redirect::to(&format!("/cohorts/{id}/programme")))
}

/// The requested comparison.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct ProgrammeQuery {
    /// Id of the course.
    course: String,
    /// Id of the other cohort; empty for that of the year before.
    with: String,
    /// Weeks without practice that are a pause.
    pause: String,
}

pub(super) async fn show_programme(
    State(state): State<AppState>,
    Teacher(person): Teacher,
    PathId(id): PathId<CohortId>,
    csrf: Csrf,
    Query(query): Query<ProgrammeQuery>,
) -> Result<ProgrammePage, PageError> {
    let (reader, school) = (state.db.reader(), person.school_id);
    let cohort = reports::cohort(reader, &person, id).await.map_err(Error::from)?.ok_or(Error::NotFound)?;
    let courses = standing::taught_courses(&state, school).await?;
    let course = match courses.iter().position(|of| of.id == query.course) {
        Some(asked) => Some(asked),
        None => find_begun_course(&state, school, &cohort, &courses).await?,
    };
    let mut in_terms = terms::list_cohort_terms(reader, school).await.map_err(Error::from)?;
    let own = in_terms.iter().position(|of| of.cohort_id == id).map(|at| in_terms.remove(at));
    let asked = query.with.parse::<CohortId>().ok();
    let other = in_terms.iter().find(|of| Some(of.cohort_id) == asked);
    let other = other.or_else(|| own.as_ref()?.find_year_before(&in_terms));
    let pause_weeks = query.pause.parse().ok().filter(|weeks| PAUSES.contains(weeks)).unwrap_or(USUAL_PAUSE_WEEKS);
    let comparison = match own.as_ref().zip(course) {
        Some((own, course)) => {
            let asked = Asked { state: &state, by: &person, course: &courses[course], pause_weeks };
            Some(asked.compare(own, other).await?)
        }
        None => None,
    };
    Ok(ProgrammePage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Cohorts),
        href: cohort_href(&cohort),
        name: cohort.name,
        terms: list_term_options(&state, &person, own.as_ref()).await?,
        courses: list_course_options(&courses, course),
        others: in_terms.iter().map(|of| other_option(of, other)).collect(),
        pause_weeks,
        comparison,
    })
}

/// Returns the course that most trainees of a cohort have begun, the first if none has.
async fn find_begun_course(
    state: &AppState,
    school: SchoolId,
    cohort: &NamedItem<CohortId>,
    courses: &[TaughtCourse],
) -> Result<Option<usize>, Error> {
    let practised = standing::practice_of_cohort(state, school, cohort.clone()).await?;
    let judged = standing::judged_courses(courses);
    Ok(practised.standing(&judged, state.clock.now()).find_begun_course(courses.len()))
}

fn label_cohort(of: &CohortTerm) -> String {
    format!("{} · {}", of.cohort, of.term)
}

fn other_option(of: &CohortTerm, chosen: Option<&CohortTerm>) -> SelectOption {
    let chosen = chosen.is_some_and(|chosen| chosen.cohort_id == of.cohort_id);
    SelectOption { value: of.cohort_id.to_string(), label: label_cohort(of), chosen }
}

/// Returns the terms that an administrator can choose for a cohort, none of them first.
async fn list_term_options(
    state: &AppState,
    by: &CurrentPerson,
    own: Option<&CohortTerm>,
) -> Result<Vec<SelectOption>, Error> {
    if by.role != Role::Administrator {
        return Ok(Vec::new());
    }
    let known = terms::list_terms(state.db.reader(), by.school_id).await?;
    if known.is_empty() {
        return Ok(Vec::new());
    }
    let option = |of: model::training::term::Term| SelectOption {
        chosen: own.is_some_and(|own| own.term_id == of.id),
        value: of.id.to_string(),
        label: of.name,
    };
    let none = SelectOption { value: String::new(), label: tr!("no term").to_owned(), chosen: own.is_none() };
    Ok(std::iter::once(none).chain(known.into_iter().map(option)).collect())
}

/// A comparison and its reader.
struct Asked<'a> {
    state: &'a AppState,
    by: &'a CurrentPerson,
    course: &'a TaughtCourse,
    pause_weeks: u32,
}

impl Asked<'_> {
    async fn compare(&self, own: &CohortTerm, other: Option<&CohortTerm>) -> Result<CohortComparison, Error> {
        let now = self.state.clock.now();
        let week = own.week(now);
        let mut cohorts = vec![self.figures(own, week).await?];
        if let Some(other) = other {
            cohorts.push(self.figures(other, week).await?);
        }
        let exercises = self.course.course.steps.iter().map(|step| step.title.clone()).collect();
        Ok(CohortComparison { week, exercises, cohorts })
    }

    /// Returns the figures of a cohort up to a week; the curve goes on to the present week of its
    /// own term.
    async fn figures(&self, of: &CohortTerm, week: u32) -> Result<ComparedCohort, Error> {
        let (reader, school) = (self.state.db.reader(), self.by.school_id);
        let sees_people = reports::cohort(reader, self.by, of.cohort_id).await?.is_some();
        let trainees = terms::list_cohort_trainees(reader, school, of.cohort_id).await?;
        let practised = practice::list_cohort_practice(reader, school, of.cohort_id).await?;
        let attempts = || trainees.iter().map(|id| practised.get(id).map_or(&[][..], Vec::as_slice));
        let span = |weeks| TermSpan { starts_at: of.starts_at.to_utc(), weeks, pause_weeks: self.pause_weeks };
        let figures = |weeks| {
            let found = TermFigures::of(&self.course.course, attempts(), span(weeks));
            if sees_people { found } else { found.without_small_groups() }
        };
        let weeks = of.week(self.state.clock.now()).min(MOST_WEEKS);
        Ok(ComparedCohort { label: label_cohort(of), now: figures(week), shares: figures(weeks).shares })
    }
}
