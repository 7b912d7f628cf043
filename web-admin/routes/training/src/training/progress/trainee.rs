//! One exercise of one trainee.

use acts::error::Error;
use assessment::statistics::{summary, wilson};
use axum::extract::{Path, State};
use axum::response::Response;
use model::ids::{PersonId, SchoolId};
use model::training::progress::{CurveRule, Mastery, Progress, ScoredAttempt, StepProgress, StepState};
use model::{CurrentPerson, Role};
use pages::training::addresses::exercise_href;
use pages::training::progress::{Comparison, CurveFacts, CurveRow, LearningPage};
use pages::training::trainee::{rule_in_words, score_points};
use pages::{NavPlace, Shell, StatusWord, charts};
use routes_base::AppState;
use routes_base::auth::{Csrf, Visitor};
use routes_base::error::PageError;
use routes_base::export::{CsvCell, download_csv};
use store::operations::schools;
use store::training::reports::{ListStretch, NamedItem};
use store::training::{cohorts, practice, reports};

use crate::training::standing::TaughtCourse;
use crate::training::{standing, trainees};

/// Attempts in which recurring deductions are looked for.
const RECENT: ListStretch = ListStretch { limit: 20, offset: 0 };
/// A comparison with fewer others would disclose individual scores.
const MORE_OTHERS_THAN: usize = 5;

/// The data of both the page and its file.
struct TraineeStep {
    trainee: NamedItem<PersonId>,
    taught: TaughtCourse,
    index: usize,
    /// Contains the curve of the course's rule, or else that of an example.
    step: StepProgress,
}

async fn find_trainee_step(
    state: &AppState,
    person: &CurrentPerson,
    id: &str,
    exercise: &str,
) -> Result<TraineeStep, Error> {
    let id: PersonId = id.parse().map_err(|_| Error::NotFound)?;
    let (reader, school) = (state.db.reader(), person.school_id);
    let trainee = reports::trainee(reader, person, id).await?.ok_or(Error::NotFound)?;
    let courses = standing::taught_courses(state, school).await?;
    let place = |taught: &TaughtCourse| taught.course.steps.iter().position(|step| step.exercise == exercise);
    let found = courses.into_iter().find_map(|taught| place(&taught).map(|index| (taught, index)));
    let (taught, index) = found.ok_or(Error::NotFound)?;
    let attempts = practice::list_trainee_practice(reader, school, id).await?;
    let mut progress = Progress::of(&taught.course, &attempts);
    let mut step = progress.steps.swap_remove(index);
    step.curve = step.curve.take().or_else(|| CurveRule::example().map(|rule| rule.over(&step.passed())));
    Ok(TraineeStep { trainee, taught, index, step })
}

/// The learning curve that decides in the course, or one by an example, which decides nothing, for those who teach.
fn draw_curves(
    viewer: &CurrentPerson,
    taught: &TaughtCourse,
    step: &StepProgress,
    title: &str,
) -> [Option<CurveFacts>; 2] {
    match taught.course.rule {
        Mastery::Curve(rule) => [CurveFacts::new(step, rule, title), None],
        Mastery::Passes { .. } if viewer.role == Role::Trainee => [None, None],
        Mastery::Passes { .. } => [None, CurveRule::example().and_then(|rule| CurveFacts::new(step, rule, title))],
    }
}

pub(super) async fn show_trainee_step(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    Path((id, exercise)): Path<(String, String)>,
    csrf: Csrf,
) -> Result<LearningPage, PageError> {
    let found = find_trainee_step(&state, &person, &id, &exercise).await?;
    let (school, trainee) = (person.school_id, found.trainee.id);
    let latest = reports::attempts_at(state.db.reader(), school, trainee, &exercise, RECENT).await?;
    let comparison = match schools::sees_others(state.db.reader(), &person).await.map_err(Error::from)? {
        true => compare_with_others(&state, school, &found).await?,
        false => None,
    };
    let TraineeStep { trainee, taught, index, step } = found;
    let step_of = &taught.course.steps[index];
    let [curve, beside] = draw_curves(&person, &taught, &step, &step_of.title);
    Ok(LearningPage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Elsewhere),
        own: person.id == trainee.id,
        trainee: (trainee.name, format!("/trainees/{}", trainee.id)),
        exercise: (step_of.title.clone(), exercise_href(&step_of.exercise)),
        course: (taught.title.clone(), rule_in_words(&taught.course.rule)),
        status: status_of_step(&step.state),
        scores: charts::draw_scores(
            &score_points(&step.attempts),
            taught.pass_marks.get(index).copied().unwrap_or(0.0),
            "own",
            &step_of.title,
        ),
        curve,
        beside,
        mixed: step.mixes_revisions(),
        passed: wilson(step.passes(), step.attempts.len()).ok(),
        habits: trainees::habits_of_attempts(&latest),
        comparison,
        rows: CurveRow::all(&step),
    })
}

/// Returns the status of a step, regardless of its prerequisites.
pub(super) fn status_of_step(state: &StepState) -> StatusWord {
    match state {
        StepState::Mastered { .. } => StatusWord::Mastered,
        StepState::Regressing { .. } => StatusWord::Regressing,
        StepState::Open { .. } => StatusWord::Open,
        StepState::Locked { .. } => StatusWord::Locked,
    }
}

/// Compares with the best scores of the others in the trainee's first cohort.
async fn compare_with_others(
    state: &AppState,
    school: SchoolId,
    found: &TraineeStep,
) -> Result<Option<Comparison>, Error> {
    let reader = state.db.reader();
    let Some(own) = found.step.best() else { return Ok(None) };
    let joined = cohorts::list_cohorts_of_person(reader, school, found.trainee.id, Role::Trainee).await?;
    let Some(cohort) = joined.into_iter().next() else { return Ok(None) };
    let exercise = &found.taught.course.steps[found.index].exercise;
    let mut practised = practice::of_cohort_at(reader, school, cohort.id, exercise).await?;
    practised.remove(&found.trainee.id);
    let best = |attempts: &Vec<ScoredAttempt>| attempts.iter().map(|a| a.score).fold(0.0, f64::max);
    let bests: Vec<f64> = practised.values().map(best).collect();
    let enough = bests.len() > MORE_OTHERS_THAN;
    let others = summary(&bests).ok().filter(|_| enough);
    Ok(others.map(|others| Comparison { cohort: cohort.name, own, others }))
}

pub(super) async fn export_trainee_step(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    Path((id, exercise)): Path<(String, String)>,
) -> Result<Response, PageError> {
    let found = find_trainee_step(&state, &person, &id, &exercise).await?;
    let rows: Vec<Vec<CsvCell>> =
        CurveRow::all(&found.step).into_iter().rev().map(|row| step_cells(&found, &row)).collect();
    let names = ["number", "session", "started_at", "exercise", "score", "passed", "curve", "curve_sum", "standing"];
    Ok(download_csv(&format!("attempts-{exercise}"), &names, &rows)?)
}

fn step_cells(found: &TraineeStep, row: &CurveRow) -> Vec<CsvCell> {
    let at = row.number - 1;
    let attempt = &found.step.attempts[at];
    let point = found.step.curve.as_ref().and_then(|curve| curve.points.get(at));
    let standing = point.map(|p| match p.standing {
        assessment::learning::Standing::NotYet => "not_yet",
        assessment::learning::Standing::Competent => "competent",
        assessment::learning::Standing::Regressing => "regressing",
    });
    vec![
        CsvCell::Number(row.number as f64),
        CsvCell::from(attempt.session.to_string()),
        CsvCell::from(pages::format::format_machine_time(row.at)),
        CsvCell::from(&*attempt.exercise),
        CsvCell::Number(row.score),
        CsvCell::from(row.passed),
        CsvCell::from(point.map_or("", |p| if p.learning { "lc-cusum" } else { "cusum" })),
        CsvCell::from(row.value),
        CsvCell::from(standing.unwrap_or_default()),
    ]
}
