//! Exercises to train, and the documents needed for them.

use std::collections::BTreeSet;

use acts::error::Error;
use acts::training::assignments as teaching;
use assessment::learning::Standing;
use axum::Json;
use axum::extract::{Path, State};
use axum::http::header::CONTENT_TYPE;
use axum::http::{HeaderMap, HeaderValue};
use axum::response::Response;
use model::ids::{AssignmentId, PersonId, SchoolId};
use model::training::assignment;
use model::training::assignment::{AssignmentStage, AssignmentTask};
use model::training::due::local;
use model::training::progress::{Course, Mastery, Progress, StepProgress, StepState};
use model::{Moment, PersonKey};
use routes_base::AppState;
use routes_base::authoring::pictures::{PictureQuery, answer_picture, find_picture};
use routes_base::error::{ApiError, ProblemDocument};
use serde::Serialize;
use store::authoring::exercises::{Revision, RevisionBytes};
use store::authoring::pictures::StoredPicture;
use store::authoring::{exercises, pictures};
use store::studies;
use store::training::curricula::TaughtCurriculum;
use store::training::practice;
use utoipa::ToSchema;

use crate::caller::Caller;

/// The exercises that the caller may train now.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct Assignments {
    /// Exercises that are not mastered and whose prerequisites are: assigned ones first, by due
    /// date, then course by course.
    assignments: Vec<Assignment>,
}

/// An exercise to train.
#[derive(Debug, Serialize, ToSchema)]
struct Assignment {
    curriculum_id: String,
    curriculum_title: String,
    exercise_id: String,
    title: String,
    /// Whether it is the first one to do in its course.
    next: bool,
    /// Passes among the most recent attempts that the mastery rule considers; 0 if the rule is a
    /// learning curve.
    passes: u32,
    /// Passes needed …
    passes_needed: u32,
    /// … out of this many most recent attempts. If the rule is a learning curve, both are the
    /// number of consecutive successes still needed.
    of: u32,
    /// `competent`, `not_yet` or `regressing`, if the mastery rule is a learning curve.
    #[schema(value_type = Option<String>)]
    standing: Option<Standing>,
    /// The assignment of this exercise, if there is one.
    assigned: Option<AssignedView>,
}

/// An assignment by an instructor.
#[derive(Clone, Debug, Serialize, ToSchema)]
struct AssignedView {
    #[schema(value_type = Uuid)]
    assignment_id: AssignmentId,
    /// Due date, with the UTC offset of the school's time zone.
    due_at: Option<String>,
    overdue: bool,
    /// Maximum number of attempts that count.
    attempt_limit: Option<u32>,
    /// Number of those attempts that are left.
    attempts_left: Option<u32>,
    /// Whether attempts must be supervised by an instructor.
    supervised: bool,
}

impl AssignedView {
    fn new(standing: &assignment::AssignmentStanding) -> Self {
        let assigned = &standing.assigned;
        let left = if let AssignmentStage::Open { left, .. } = standing.stage { left } else { None };
        Self {
            assignment_id: assigned.id,
            due_at: assigned.due_at.map(|at| local(at, &assigned.time_zone).machine),
            overdue: standing.overdue,
            attempt_limit: assigned.attempt_limit,
            attempts_left: left,
            supervised: assigned.supervised,
        }
    }
}

/// Adds the assignments of the exercises, and sorts assigned exercises first, by due date.
fn assigned_views(mut open: Vec<Assignment>, standings: &[assignment::AssignmentStanding]) -> Vec<Assignment> {
    let place = |of: &Assignment| {
        standings.iter().position(|standing| match &standing.assigned.task {
            AssignmentTask::Exercise(id) => {
                *id == of.exercise_id && matches!(standing.stage, AssignmentStage::Open { .. })
            }
            AssignmentTask::Course(id) => {
                *id == of.curriculum_id && matches!(standing.stage, AssignmentStage::Open { .. })
            }
        })
    };
    for exercise in &mut open {
        exercise.assigned = place(exercise).map(|at| AssignedView::new(&standings[at]));
    }
    open.extend(standings.iter().filter_map(|standing| mastered_before(standing, &open)).collect::<Vec<_>>());
    open.sort_by_key(|exercise| place(exercise).unwrap_or(usize::MAX));
    open
}

/// Returns an assigned exercise that no course lists now: it was mastered before it was assigned,
/// or belongs to no course.
fn mastered_before(standing: &assignment::AssignmentStanding, open: &[Assignment]) -> Option<Assignment> {
    let AssignmentTask::Exercise(exercise_id) = &standing.assigned.task else { return None };
    let listed = open.iter().any(|assignment| assignment.exercise_id == *exercise_id);
    let wanted = matches!(standing.stage, AssignmentStage::Open { .. }) && !listed;
    wanted.then(|| Assignment {
        curriculum_id: String::new(),
        curriculum_title: String::new(),
        exercise_id: exercise_id.clone(),
        title: standing.assigned.title.clone(),
        next: false,
        passes: 0,
        passes_needed: 1,
        of: 1,
        standing: None,
        assigned: Some(AssignedView::new(standing)),
    })
}

/// Lists the exercises that the caller may train now: not mastered yet, with all prerequisites
/// mastered.
#[utoipa::path(get, path = "/me/assignments", tag = "documents", operation_id = "list_assignments",
    responses((status = 200, body = Assignments), (status = 401, body = ProblemDocument)))]
pub(crate) async fn list_assignments(
    State(state): State<AppState>,
    caller: Caller,
) -> Result<Json<Assignments>, ApiError> {
    let person = caller.person()?;
    Ok(Json(Assignments { assignments: due_of_exercise(&state, person.school_id, person.id).await? }))
}

/// Returns the exercises that a person may train now, course by course.
async fn due_of_exercise(state: &AppState, school: SchoolId, person: PersonId) -> Result<Vec<Assignment>, Error> {
    let mut assignments = Vec::new();
    for (curriculum, course, progress) in courses_of_person(state, school, person).await? {
        assignments.extend(open_exercises(&curriculum, &course, &progress));
    }
    Ok(assigned_views(assignments, &teaching::standings(state, school, person).await?))
}

/// Returns the ids of the exercises that a person has mastered.
async fn mastered_exercises(state: &AppState, school: SchoolId, person: PersonId) -> Result<BTreeSet<String>, Error> {
    let courses = courses_of_person(state, school, person).await?;
    let steps = courses.iter().flat_map(|(_, course, progress)| course.steps.iter().zip(&progress.steps));
    let mastered = steps.filter(|(_, done)| matches!(done.state, StepState::Mastered { .. }));
    Ok(mastered.map(|(step, _)| step.exercise.clone()).collect())
}

/// Returns every course that is taught, with the person's progress in it.
async fn courses_of_person(
    state: &AppState,
    school: SchoolId,
    person: PersonId,
) -> Result<Vec<(TaughtCurriculum, Course, Progress)>, Error> {
    let reader = state.db.reader();
    let attempts = practice::list_trainee_practice(reader, school, person).await?;
    let judged = |(curriculum, course)| {
        let progress = Progress::of(&course, &attempts);
        (curriculum, course, progress)
    };
    Ok(teaching::taught_curricula(state, school).await?.into_iter().map(judged).collect())
}

fn open_exercises(curriculum: &TaughtCurriculum, course: &Course, progress: &Progress) -> Vec<Assignment> {
    let steps = course.steps.iter().zip(&progress.steps).enumerate();
    let assigned = steps.filter_map(|(index, (step, done))| {
        if !matches!(done.state, StepState::Open { .. } | StepState::Regressing { .. }) {
            return None;
        }
        let (passes, passes_needed, of) = count_passes(&course.rule, done);
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
            assigned: None,
        })
    });
    assigned.collect()
}

/// Returns the passes so far, the passes needed, and the number of attempts considered.
fn count_passes(rule: &Mastery, done: &StepProgress) -> (u32, u32, u32) {
    let so_far = if let StepState::Open { passes } = done.state { passes } else { 0 };
    match (rule, &done.curve) {
        (_, Some(curve)) => (0, curve.successes_needed, curve.successes_needed),
        (Mastery::Passes { passes, of }, _) => (so_far, *passes, *of),
        (Mastery::Curve(_), None) => (0, 0, 0),
    }
}

/// The exercises of the school, those due first.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct ExerciseList {
    exercises: Vec<ListedExercise>,
}

/// An exercise in a list.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct ListedExercise {
    exercise_id: String,
    title: String,
    /// 1–5.
    difficulty: u8,
    exercise_sha256: String,
    scene_sha256: String,
    /// Whether the trainee may train it now: it is not mastered, and its prerequisites are.
    due: bool,
    /// Whether the trainee has mastered it in a course that is taught.
    mastered: bool,
    /// Whether it is the first one to do in its course.
    next: bool,
    /// Whether an instructor has assigned it.
    assigned: bool,
    /// Due date of the assignment, with the UTC offset of the school's time zone.
    due_at: Option<String>,
}

/// Lists the school's exercises in their current revisions, in the order in which the caller is to
/// do them. For a station, which acts for no particular person, no exercise is due.
#[utoipa::path(get, path = "/exercises", tag = "documents", operation_id = "list_exercises",
    responses((status = 200, body = ExerciseList), (status = 401, body = ProblemDocument)))]
pub(crate) async fn list_exercises(
    State(state): State<AppState>,
    caller: Caller,
) -> Result<Json<ExerciseList>, ApiError> {
    let person = caller.person().ok().map(|person| person.id);
    Ok(Json(ExerciseList { exercises: listed_exercises(&state, caller.school_id(), person).await? }))
}

/// Returns the exercises of a school in the order in which a person is to do them.
pub(crate) async fn listed_exercises(
    state: &AppState,
    school: SchoolId,
    person: Option<PersonId>,
) -> Result<Vec<ListedExercise>, Error> {
    let (due, mastered) = match person {
        Some(person) => {
            (due_of_exercise(state, school, person).await?, mastered_exercises(state, school, person).await?)
        }
        None => (Vec::new(), BTreeSet::new()),
    };
    let found = |id: &str| due.iter().find(|assignment| assignment.exercise_id == id);
    let view = |revision: Revision| ListedExercise {
        due: found(&revision.exercise_id).is_some(),
        mastered: mastered.contains(&revision.exercise_id),
        next: found(&revision.exercise_id).is_some_and(|assignment| assignment.next),
        assigned: found(&revision.exercise_id).is_some_and(|assignment| assignment.assigned.is_some()),
        due_at: found(&revision.exercise_id).and_then(|assignment| assignment.assigned.clone()?.due_at),
        exercise_id: revision.exercise_id,
        title: revision.title,
        difficulty: revision.difficulty,
        exercise_sha256: revision.exercise_sha256,
        scene_sha256: revision.scene_sha256,
    };
    let all = exercises::list_current_exercises(state.db.reader(), school).await?;
    let mut listed: Vec<ListedExercise> = all.into_iter().map(view).collect();
    let place =
        |exercise: &ListedExercise| due.iter().position(|assignment| assignment.exercise_id == exercise.exercise_id);
    listed.sort_by_key(|exercise| {
        (!exercise.assigned, place(exercise).filter(|_| exercise.assigned), !exercise.next, !exercise.due)
    });
    Ok(listed)
}

/// Returns the exercises of a guest's study, in the order of the school's list, all of them due.
pub(crate) async fn studied_exercises(
    state: &AppState,
    school: SchoolId,
    guest: PersonId,
) -> Result<Vec<ListedExercise>, Error> {
    let guest = PersonKey { school_id: school, person_id: guest };
    let studied = studies::list_studied_exercises(state.db.reader(), guest).await?;
    let mut listed = listed_exercises(state, school, None).await?;
    listed.retain(|exercise| studied.contains(&exercise.exercise_id));
    listed.iter_mut().for_each(|exercise| exercise.due = true);
    Ok(listed)
}

/// The current revision of an exercise.
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = ExerciseView)]
pub(crate) struct ExerciseDocument {
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
    /// The pictures of its briefing, in order.
    pictures: Vec<BriefingPicture>,
}

/// A picture of a briefing.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct BriefingPicture {
    /// Its file name in the exercise document, which also contains its description.
    file: String,
    /// Its address.
    href: String,
    sha256: String,
    /// In pixels.
    width: u32,
    /// In pixels.
    height: u32,
}

/// Returns the current revision of an exercise.
#[utoipa::path(get, path = "/exercises/{id}", tag = "documents", operation_id = "show_exercise", params(("id" = String, Path)),
    responses((status = 200, body = ExerciseDocument), (status = 404, body = ProblemDocument)))]
pub(crate) async fn show_exercise(
    State(state): State<AppState>,
    caller: Caller,
    Path(id): Path<String>,
) -> Result<Json<ExerciseDocument>, ApiError> {
    let (reader, school) = (state.db.reader(), caller.school_id());
    let revision = exercises::find_current_revision(reader, school, &id).await?.ok_or(Error::NotFound)?;
    let bytes = exercises::read_exercise_bytes(reader, school, revision.id).await?.ok_or(Error::NotFound)?;
    let RevisionBytes { exercise, scene, meshes } = bytes;
    let listed = pictures::list_revision_pictures(reader, school, revision.id).await?;
    let briefing = |(number, picture): (usize, StoredPicture)| BriefingPicture {
        href: format!("/api/v1/exercises/{}/pictures/{}", revision.exercise_id, number + 1),
        file: picture.name,
        sha256: picture.sha256,
        width: picture.width,
        height: picture.height,
    };
    let pictures = listed.into_iter().enumerate().map(briefing).collect();
    Ok(Json(ExerciseDocument {
        exercise_id: revision.exercise_id,
        title: revision.title,
        difficulty: revision.difficulty,
        pass_mark: revision.pass_mark,
        exercise_sha256: revision.exercise_sha256,
        scene_sha256: revision.scene_sha256,
        published_at: revision.published_at,
        // Published documents were parsed as TOML, so they are UTF-8.
        exercise_toml: String::from_utf8_lossy(&exercise).into_owned(),
        scene_toml: String::from_utf8_lossy(&scene).into_owned(),
        meshes: meshes.into_iter().map(|(name, _)| name).collect(),
        pictures,
    }))
}

/// Returns a picture of an exercise's briefing, by its number from 1: PNG or JPEG, according to its
/// file name in the exercise document.
#[utoipa::path(get, path = "/exercises/{id}/pictures/{number}", tag = "documents", operation_id = "show_picture",
    params(("id" = String, Path), ("number" = String, Path)),
    responses((status = 200, content_type = "application/octet-stream"), (status = 404, body = ProblemDocument)))]
pub(crate) async fn show_picture(
    State(state): State<AppState>,
    caller: Caller,
    Path((id, number)): Path<(String, String)>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let picture = find_picture(&state, caller.school_id(), &id, &number).await?;
    let mut answer = answer_picture(&picture, &PictureQuery::default(), &headers)?;
    answer.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static("application/octet-stream"));
    Ok(answer)
}
