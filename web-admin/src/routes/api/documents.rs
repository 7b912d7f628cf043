//! What to train, and the documents to train it with.

use assessment::learning::Standing;
use axum::Json;
use axum::extract::{Path, State};
use serde::Serialize;
use utoipa::ToSchema;
use uuid::Uuid;

use super::caller::Caller;
use crate::AppState;
use crate::domain::Moment;
use crate::domain::progress::{Course, Mastery, Progress, StepProgress, StepState};
use crate::error::{ApiError, Error, Problem};
use crate::storage::curricula::{self, Curriculum};
use crate::storage::exercises::{self, Revision, RevisionBytes};
use crate::storage::practice;

/// What the caller may train now.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct Assignments {
    /// Exercises that are not mastered and whose prerequisites are, course by course.
    assignments: Vec<Assignment>,
}

/// An exercise to train.
#[derive(Debug, Serialize, ToSchema)]
struct Assignment {
    curriculum_id: String,
    curriculum_title: String,
    exercise_id: String,
    title: String,
    /// The one to do first in its course.
    next: bool,
    /// Passes among the last attempts that the mastery rule looks at; 0 where it is a learning curve.
    passes: u32,
    /// Passes needed …
    passes_needed: u32,
    /// … of how many of the last attempts. Where the rule is a learning curve, both are the straight successes still
    /// needed.
    of: u32,
    /// `competent`, `not_yet` or `regressing`, where the mastery rule is a learning curve.
    #[schema(value_type = Option<String>)]
    standing: Option<Standing>,
}

/// What the caller may train now: not yet mastered, prerequisites honoured.
#[utoipa::path(get, path = "/me/assignments",
    responses((status = 200, body = Assignments), (status = 401, body = Problem)))]
pub(super) async fn assignments(State(state): State<AppState>, caller: Caller) -> Result<Json<Assignments>, ApiError> {
    let person = caller.person()?;
    Ok(Json(Assignments { assignments: due(&state, person.school_id, person.id).await? }))
}

/// What a person may train now, course by course.
async fn due(state: &AppState, school: Uuid, person: Uuid) -> Result<Vec<Assignment>, Error> {
    let reader = state.db.reader();
    let attempts = practice::of_trainee(reader, school, person).await?;
    let mut assignments = Vec::new();
    for curriculum in curricula::taught(reader, school).await? {
        let course = curricula::course(reader, school, &curriculum).await?;
        let progress = Progress::of(&course, &attempts, state.clock.now().to_utc());
        assignments.extend(open(&curriculum, &course, &progress));
    }
    Ok(assignments)
}

fn open(curriculum: &Curriculum, course: &Course, progress: &Progress) -> Vec<Assignment> {
    let steps = course.steps.iter().zip(&progress.steps).enumerate();
    let assigned = steps.filter_map(|(index, (step, done))| {
        if !matches!(done.state, StepState::Open { .. } | StepState::Regressing { .. }) {
            return None;
        }
        let (passes, passes_needed, of) = passes(&course.rule, done);
        Some(Assignment {
            curriculum_id: curriculum.curriculum_id.clone(),
            curriculum_title: curriculum.title.clone(),
            exercise_id: step.exercise.clone(),
            title: step.title.clone(),
            next: progress.next == Some(index),
            passes,
            passes_needed,
            of,
            standing: done.curve.as_ref().map(|curve| curve.standing),
        })
    });
    assigned.collect()
}

/// Passes so far, passes needed, and among how many attempts.
fn passes(rule: &Mastery, done: &StepProgress) -> (u32, u32, u32) {
    let so_far = if let StepState::Open { passes } = done.state { passes } else { 0 };
    match (rule, &done.curve) {
        (_, Some(curve)) => (0, curve.successes_needed, curve.successes_needed),
        (Mastery::Passes { passes, of }, _) => (so_far, *passes, *of),
        (Mastery::Curve(_), None) => (0, 0, 0),
    }
}

/// The school's exercises, what is due first.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct ExerciseList {
    exercises: Vec<ListedExercise>,
}

/// An exercise in a list.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct ListedExercise {
    exercise_id: String,
    title: String,
    /// 1–5.
    difficulty: u8,
    exercise_sha256: String,
    scene_sha256: String,
    /// The trainee may train it now: it is not mastered, and its prerequisites are.
    due: bool,
    /// The one to do first in its course.
    next: bool,
}

/// The school's exercises in the revisions that trainees are given: what the caller is to do first comes first. To a
/// station, which is nobody in particular, nothing is due.
#[utoipa::path(get, path = "/exercises",
    responses((status = 200, body = ExerciseList), (status = 401, body = Problem)))]
pub(super) async fn exercises(State(state): State<AppState>, caller: Caller) -> Result<Json<ExerciseList>, ApiError> {
    let person = caller.person().ok().map(|person| person.id);
    Ok(Json(ExerciseList { exercises: listed(&state, caller.school_id(), person).await? }))
}

/// The exercises of a school in the order in which a person is to do them.
pub(super) async fn listed(state: &AppState, school: Uuid, person: Option<Uuid>) -> Result<Vec<ListedExercise>, Error> {
    let due = match person {
        Some(person) => due(state, school, person).await?,
        None => Vec::new(),
    };
    let found = |id: &str| due.iter().find(|assignment| assignment.exercise_id == id);
    let view = |revision: Revision| ListedExercise {
        due: found(&revision.exercise_id).is_some(),
        next: found(&revision.exercise_id).is_some_and(|assignment| assignment.next),
        exercise_id: revision.exercise_id,
        title: revision.title,
        difficulty: revision.difficulty,
        exercise_sha256: revision.exercise_sha256,
        scene_sha256: revision.scene_sha256,
    };
    let all = exercises::all_current(state.db.reader(), school).await?;
    let mut listed: Vec<ListedExercise> = all.into_iter().map(view).collect();
    listed.sort_by_key(|exercise| (!exercise.next, !exercise.due));
    Ok(listed)
}

/// An exercise in the revision that trainees are given.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct ExerciseView {
    exercise_id: String,
    title: String,
    /// 1–5.
    difficulty: u8,
    /// 0–100.
    pass_mark: f64,
    exercise_sha256: String,
    scene_sha256: String,
    #[schema(value_type = String, format = DateTime)]
    published_at: Moment,
    /// The exercise document.
    exercise_toml: String,
    /// The scene document.
    scene_toml: String,
    /// Names of the scene's meshes.
    meshes: Vec<String>,
}

/// An exercise in the revision that trainees are given.
#[utoipa::path(get, path = "/exercises/{id}", params(("id" = String, Path)),
    responses((status = 200, body = ExerciseView), (status = 404, body = Problem)))]
pub(super) async fn exercise(
    State(state): State<AppState>,
    caller: Caller,
    Path(id): Path<String>,
) -> Result<Json<ExerciseView>, ApiError> {
    let (reader, school) = (state.db.reader(), caller.school_id());
    let revision = exercises::current(reader, school, &id).await?.ok_or(Error::NotFound)?;
    let bytes = exercises::bytes(reader, school, revision.id).await?.ok_or(Error::NotFound)?;
    let RevisionBytes { exercise, scene, meshes } = bytes;
    Ok(Json(ExerciseView {
        exercise_id: revision.exercise_id,
        title: revision.title,
        difficulty: revision.difficulty,
        pass_mark: revision.pass_mark,
        exercise_sha256: revision.exercise_sha256,
        scene_sha256: revision.scene_sha256,
        published_at: revision.published_at,
        // Only documents that were read as TOML are ever published, and TOML is UTF-8.
        exercise_toml: String::from_utf8_lossy(&exercise).into_owned(),
        scene_toml: String::from_utf8_lossy(&scene).into_owned(),
        meshes: meshes.into_iter().map(|(name, _)| name).collect(),
    }))
}
