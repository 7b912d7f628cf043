//! A cohort's progress.

use std::collections::BTreeMap;

use acts::error::Error;
use acts::training::risks;
use assessment::statistics::wilson;
use axum::extract::{Query, State};
use axum::response::Response;
use model::ids::{CohortId, PersonId};
use model::training::progress::{Progress, ScoredAttempt};
use model::training::risk::{Concern, PersonAtRisk};
use model::{CurrentPerson, Role};
use pages::school_time::to_school_time;
use pages::training::concern::say_concern;
use pages::training::progress::{CohortProgressPage, CourseHeat, Hardness, HeatRow, ScoredRow, Worry, make_heat_cell};
use pages::{NavPlace, Shell};
use routes_base::AppState;
use routes_base::addresses::PathId;
use routes_base::auth::{Csrf, Visitor};
use routes_base::error::PageError;
use routes_base::export::{CsvCell, download_csv, trainee_cells};
use serde::Deserialize;
use store::training::reports::NamedItem;
use store::training::risks::RiskScope;
use store::training::{practice, reports};
use time::format_description::well_known::Iso8601;
use time::{Date, Duration};

use crate::training::progress::metrics::make_scored_row;
use crate::training::standing::TaughtCourse;
use crate::training::{cohorts, standing};

/// Days on the chart.
const DAYS: i64 = 28;
/// Minimum number of attempts for an exercise to be called the hardest.
const LEAST_ATTEMPTS: usize = 5;

/// The data of both the page and its file.
struct CohortProgress {
    cohort: NamedItem<CohortId>,
    courses: Vec<TaughtCourse>,
    trainees: Vec<(NamedItem<PersonId>, Vec<ScoredAttempt>)>,
}

/// Returns a cohort that the visitor may see, with all attempts of its trainees.
async fn find_cohort_progress(state: &AppState, person: &CurrentPerson, id: CohortId) -> Result<CohortProgress, Error> {
    let (reader, school) = (state.db.reader(), person.school_id);
    let cohort = reports::cohort(reader, person, id).await?.ok_or(Error::NotFound)?;
    let mut practised = practice::list_cohort_practice(reader, school, id).await?;
    let members = reports::members(reader, school, id, Role::Trainee).await?;
    let with_attempts = |trainee: NamedItem<PersonId>| {
        let attempts = practised.remove(&trainee.id).unwrap_or_default();
        (trainee, attempts)
    };
    let trainees = members.into_iter().map(with_attempts).collect();
    Ok(CohortProgress { cohort, courses: standing::taught_courses(state, school).await?, trainees })
}

/// A trainee's progress in one course.
type JudgedTrainee<'a> = (&'a NamedItem<PersonId>, Progress);

impl CohortProgress {
    fn judged(&self, taught: &TaughtCourse) -> Vec<JudgedTrainee<'_>> {
        self.trainees.iter().map(|(trainee, attempts)| (trainee, Progress::of(&taught.course, attempts))).collect()
    }

    /// Returns the courses that at least one trainee has begun.
    fn begun(&self) -> Vec<(&TaughtCourse, Vec<JudgedTrainee<'_>>)> {
        let judged = self.courses.iter().map(|taught| (taught, self.judged(taught)));
        judged.filter(|(_, judged)| judged.iter().any(|(_, p)| p.attempts() > 0)).collect()
    }
}

fn curve_href(trainee: &NamedItem<PersonId>, exercise: &str) -> String {
    format!("/trainees/{}/exercises/{exercise}", trainee.id)
}

pub(super) async fn show_cohort_progress(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<CohortId>,
    csrf: Csrf,
    Query(query): Query<DayQuery>,
) -> Result<CohortProgressPage, PageError> {
    let found = find_cohort_progress(&state, &person, id).await?;
    let day = Date::parse(&query.day, &Iso8601::DATE).ok();
    let begun = found.begun();
    let at_risk = risks::list_people_at_risk(&state, &person, RiskScope::Cohort(id)).await?;
    let today = to_school_time(state.clock.now().to_utc()).date();
    Ok(CohortProgressPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Cohorts),
        cohort: (found.cohort.name.clone(), cohorts::cohort_href(&found.cohort)),
        courses: begun.iter().map(|(taught, judged)| heat_of_course(&found.cohort, taught, judged)).collect(),
        worries: at_risk.iter().flat_map(list_worries).collect(),
        days: count_by_day(&found, today),
        day: day.map(|date| (date, attempts_on(&found, date))),
    })
}

/// The selected day, as YYYY-MM-DD; any other text selects none.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct DayQuery {
    day: String,
}

/// Returns the attempts of a day, in order of time.
fn attempts_on(found: &CohortProgress, date: Date) -> Vec<ScoredRow> {
    let steps = || found.courses.iter().flat_map(|taught| &taught.course.steps);
    let title = |id: &str| steps().find(|step| step.exercise == id).map_or_else(|| id.to_owned(), |s| s.title.clone());
    let all = found.trainees.iter().flat_map(|(trainee, attempts)| attempts.iter().map(move |a| (trainee, a)));
    let then = all.filter(|(_, attempt)| to_school_time(attempt.at).date() == date);
    let mut rows: Vec<ScoredRow> = then.map(|(who, a)| make_scored_row(who, a, &title(&a.exercise))).collect();
    rows.sort_by_key(|row| row.at);
    rows
}

fn heat_of_course(cohort: &NamedItem<CohortId>, taught: &TaughtCourse, judged: &[JudgedTrainee<'_>]) -> CourseHeat {
    let row = |(trainee, progress): &JudgedTrainee<'_>| {
        let cells = taught.course.steps.iter().zip(&progress.steps).zip(&taught.pass_marks);
        HeatRow {
            name: trainee.name.clone(),
            href: format!("/trainees/{}", trainee.id),
            cells: cells
                .map(|((of, step), mark)| make_heat_cell(curve_href(trainee, &of.exercise), step, *mark))
                .collect(),
        }
    };
    let mut exercises: Vec<Hardness> =
        (0..taught.course.steps.len()).map(|index| hardness_of_step(cohort, taught, judged, index)).collect();
    let share = |e: &Hardness| e.passed.filter(|p| p.n >= LEAST_ATTEMPTS).map(|p| p.value);
    let least = exercises.iter().filter_map(share).fold(1.0, f64::min);
    let hardest = exercises.iter().position(|e| share(e).is_some_and(|s| s <= least && s < 1.0));
    if let Some(exercise) = hardest.and_then(|at| exercises.get_mut(at)) {
        exercise.hardest = true;
    }
    CourseHeat { title: taught.title.clone(), exercises, rows: judged.iter().map(row).collect() }
}

fn hardness_of_step(
    cohort: &NamedItem<CohortId>,
    taught: &TaughtCourse,
    judged: &[JudgedTrainee<'_>],
    index: usize,
) -> Hardness {
    let of = &taught.course.steps[index];
    let steps = || judged.iter().map(|(_, progress)| &progress.steps[index]);
    let (passes, attempts) = steps().fold((0, 0), |(p, a), step| (p + step.passes(), a + step.attempts.len()));
    Hardness {
        title: of.title.clone(),
        href: format!("{}/exercises/{}", cohorts::cohort_href(cohort), of.exercise),
        tried: steps().filter(|step| !step.attempts.is_empty()).count(),
        mastered: steps().filter(|step| step.mastered()).count(),
        passed: wilson(passes, attempts).ok(),
        hardest: false,
    }
}

/// Returns the concerns about a trainee that come from attempts, each with the page of these.
fn list_worries(of: &PersonAtRisk) -> Vec<Worry> {
    let (name, id) = (&of.trainee.name, of.trainee.id);
    let worry = |concern: &Concern| {
        let href = format!("/trainees/{id}/exercises/{}", concern.exercise()?);
        Some(Worry { name: name.clone(), href, concern: say_concern(concern) })
    };
    of.concerns.iter().filter_map(worry).collect()
}

/// Returns the numbers of passed and failed attempts on each of the last days.
fn count_by_day(found: &CohortProgress, today: Date) -> Vec<(Date, usize, usize)> {
    let mut counts: BTreeMap<Date, (usize, usize)> = BTreeMap::new();
    for attempt in found.trainees.iter().flat_map(|(_, attempts)| attempts) {
        let count = counts.entry(to_school_time(attempt.at).date()).or_default();
        if attempt.passed { count.0 += 1 } else { count.1 += 1 }
    }
    let day = |back: i64| {
        let date = today - Duration::days(back);
        let (passed, failed) = counts.get(&date).copied().unwrap_or_default();
        (date, passed, failed)
    };
    (0..DAYS).rev().map(day).collect()
}

pub(super) async fn export_cohort_progress(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    PathId(id): PathId<CohortId>,
) -> Result<Response, PageError> {
    let found = find_cohort_progress(&state, &person, id).await?;
    let pseudonyms = reports::pseudonyms(state.db.reader(), person.school_id, id).await?;
    let mut rows = Vec::new();
    for (taught, judged) in found.begun() {
        for (trainee, progress) in &judged {
            let identity = trainee_cells(trainee.id, &pseudonyms);
            let steps = 0..progress.steps.len();
            rows.extend(
                steps.map(|index| [progress_cells(taught, trainee, progress, index), identity.clone()].concat()),
            );
        }
    }
    let names = [
        "trainee",
        "course",
        "exercise",
        "state",
        "attempts",
        "passed",
        "best_score",
        "mean_of_last_3",
        "last_attempt_at",
        "trainee_id",
        "pseudonym",
    ];
    Ok(download_csv(&format!("progress-{}", found.cohort.name), &names, &rows)?)
}

fn progress_cells(
    taught: &TaughtCourse,
    trainee: &NamedItem<PersonId>,
    progress: &Progress,
    index: usize,
) -> Vec<CsvCell> {
    let (of, step) = (&taught.course.steps[index], &progress.steps[index]);
    let cell = make_heat_cell(String::new(), step, taught.pass_marks.get(index).copied().unwrap_or(0.0));
    let last_at = step.attempts.last().map(|a| pages::format::format_machine_time(a.at));
    vec![
        CsvCell::from(trainee.name.clone()),
        CsvCell::from(taught.title.clone()),
        CsvCell::from(of.title.clone()),
        CsvCell::from(crate::training::progress::trainee::status_of_step(&step.state).word()),
        CsvCell::Number(cell.attempts as f64),
        CsvCell::Number(cell.passes as f64),
        CsvCell::from(cell.best),
        CsvCell::from(cell.mean),
        last_at.map_or(CsvCell::Empty, CsvCell::Text),
    ]
}
