//! `/curricula` and `/exercises/{id}`.

use acts::error::Error;
use axum::extract::{Path, Query, State};
use documents::ExerciseBundle;
use dossier::compare_scene;
use model::training::progress::{CourseStep, Progress, StepState};
use model::{CurrentPerson, Role};
use pages::authoring::exercise::{Context, ExerciseFacts, ExercisePage, ExerciseTeaching};
use pages::authoring::measured::{draw_scene_curve, list_measured_lines};
use pages::form::SelectOption;
use pages::training::addresses::exercise_href;
use pages::training::curricula::{CourseCard, CurriculaPage, ExerciseLine};
use pages::training::trainee::{rule_in_words, score_points};
use pages::{NavPlace, Shell, StatusWord, charts};
use routes_base::AppState;
use routes_base::auth::{Csrf, Visitor};
use routes_base::authoring::exercises::published_bundle;
use routes_base::authoring::pictures;
use routes_base::error::PageError;
use routes_base::forms::PublishedQuery;
use store::authoring::exercises;
use store::training::{practice, reports};

use super::standing::TaughtCourse;
use super::{rows, standing};

/// A course, with the visitor's progress if they are a trainee.
type VisitedExercise = (TaughtCourse, Option<Progress>);

pub(super) async fn show_curricula(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    Query(shown): Query<PublishedQuery>,
    csrf: Csrf,
) -> Result<CurriculaPage, PageError> {
    let courses = visited_exercise(&state, &person).await?;
    let published = courses.iter().find(|(taught, _)| Some(&taught.id) == shown.published.as_ref());
    let published = published.map(|(taught, _)| taught.title.clone());
    let shell = Shell::new(&person, csrf.token(), NavPlace::Curricula);
    let staff = person.role != Role::Trainee;
    Ok(CurriculaPage { shell, staff, published, courses: courses.iter().map(make_course_card).collect() })
}

pub(super) async fn show_exercise(
    State(state): State<AppState>,
    Visitor(person): Visitor,
    Path(id): Path<String>,
    Query(shown): Query<PublishedQuery>,
    csrf: Csrf,
) -> Result<ExercisePage, PageError> {
    let current =
        exercises::find_current_revision(state.db.reader(), person.school_id, &id).await?.ok_or(Error::NotFound)?;
    let bundle = published_bundle(&state, person.school_id, current.id).await?.ok_or(Error::NotFound)?;
    let at_hand = pictures::list_at_hand(&state, person.school_id, &current).await?;
    let courses = visited_exercise(&state, &person).await?;
    let listed = reports::latest_at(state.db.reader(), &person, &id).await?;
    let own = person.role == Role::Trainee;
    let teaching = if own { None } else { Some(measure_scene(&bundle).await?) };
    Ok(ExercisePage {
        shell: Shell::new(&person, csrf.token(), NavPlace::Curricula),
        contexts: courses.iter().filter_map(|visited| context_in_course(visited, &id)).collect(),
        attempts: if own { rows::own_rows(listed) } else { rows::mixed_rows(listed) },
        chart: draw_own_scores(&courses, &bundle),
        exercise: ExerciseFacts::new(&bundle, &at_hand),
        teaching: teaching.map(|compared| ExerciseTeaching {
            published: shown.published.is_some(),
            courses: courses.iter().filter_map(|(taught, _)| course_without(taught, &id)).collect(),
            ..compared
        }),
        own,
    })
}

/// Compares the exercise's scene with published measurements and draws its force, by simulating some
/// insertions: off the threads that answer.
async fn measure_scene(bundle: &ExerciseBundle) -> Result<ExerciseTeaching, Error> {
    let (scene, language) = (bundle.scene.clone(), words::current());
    let compare = move || {
        let lines = compare_scene(&scene);
        ExerciseTeaching {
            measured: list_measured_lines(&lines),
            classes: scene.count_classes(),
            curve: draw_scene_curve(&scene, &lines),
            ..ExerciseTeaching::default()
        }
    };
    Ok(tokio::task::spawn_blocking(move || words::within(language, compare)).await?)
}

/// Returns a course as an option if it does not contain the exercise yet.
fn course_without(taught: &TaughtCourse, exercise: &str) -> Option<SelectOption> {
    let has = taught.course.steps.iter().any(|step| step.exercise == exercise);
    (!has).then(|| SelectOption { value: taught.id.clone(), label: taught.title.clone(), chosen: false })
}

async fn visited_exercise(state: &AppState, person: &CurrentPerson) -> Result<Vec<VisitedExercise>, Error> {
    let courses = standing::taught_courses(state, person.school_id).await?;
    if person.role != Role::Trainee {
        return Ok(courses.into_iter().map(|taught| (taught, None)).collect());
    }
    let attempts = practice::list_trainee_practice(state.db.reader(), person.school_id, person.id).await?;
    let judged = |taught: TaughtCourse| {
        let progress = Progress::of(&taught.course, &attempts);
        (taught, Some(progress))
    };
    Ok(courses.into_iter().map(judged).collect())
}

fn make_course_card((taught, progress): &VisitedExercise) -> CourseCard {
    let line = |(i, step): (usize, &CourseStep)| ExerciseLine {
        href: exercise_href(&step.exercise),
        title: step.title.clone(),
        difficulty: taught.difficulties[i],
        prerequisites: exercise_links(taught, |other| step.prerequisites.contains(&other.exercise))
            .map(|(t, _)| t)
            .collect(),
        status: progress.as_ref().map(|p| status_in_course(p, i)),
    };
    CourseCard {
        id: taught.id.clone(),
        title: taught.title.clone(),
        description: taught.description.clone(),
        rule: rule_in_words(&taught.course.rule),
        exercises: taught.course.steps.iter().enumerate().map(line).collect(),
    }
}

/// Returns title and address of the steps that satisfy a condition.
fn exercise_links(
    taught: &TaughtCourse,
    wanted: impl Fn(&CourseStep) -> bool,
) -> impl Iterator<Item = (String, String)> {
    let steps = taught.course.steps.iter().filter(move |step| wanted(step));
    steps.map(|step| (step.title.clone(), exercise_href(&step.exercise)))
}

fn status_in_course(progress: &Progress, index: usize) -> StatusWord {
    match progress.steps[index].state {
        StepState::Mastered { .. } => StatusWord::Mastered,
        StepState::Open { .. } if progress.next == Some(index) => StatusWord::Current,
        StepState::Open { .. } => StatusWord::Open,
        StepState::Locked { .. } => StatusWord::Locked,
        StepState::Regressing { .. } => StatusWord::Regressing,
    }
}

fn context_in_course((taught, progress): &VisitedExercise, id: &str) -> Option<Context> {
    let steps = &taught.course.steps;
    let index = steps.iter().position(|step| step.exercise == id)?;
    Some(Context {
        course: taught.title.clone(),
        place: (index + 1, steps.len()),
        rule: rule_in_words(&taught.course.rule),
        prerequisites: exercise_links(taught, |step| steps[index].prerequisites.contains(&step.exercise)).collect(),
        opens: exercise_links(taught, |step| step.prerequisites.iter().any(|p| p == id)).collect(),
        status: progress.as_ref().map(|p| status_in_course(p, index)),
    })
}

/// Draws the visitor's own scores over time, if they have any.
fn draw_own_scores(courses: &[VisitedExercise], bundle: &ExerciseBundle) -> Option<String> {
    let exercise = &bundle.exercise;
    let attempts = courses.iter().find_map(|(taught, progress)| {
        let index = taught.course.steps.iter().position(|step| step.exercise == exercise.id)?;
        progress.as_ref().map(|p| &p.steps[index].attempts)
    })?;
    let drawn = || charts::draw_scores(&score_points(attempts), exercise.pass_mark, "own", tr!("Score over time"));
    (!attempts.is_empty()).then(drawn)
}
