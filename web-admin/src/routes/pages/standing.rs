//! Where trainees stand in the courses of their school.

use std::collections::BTreeMap;

use uuid::Uuid;

use crate::AppState;
use crate::domain::progress::{Attempt, Course, Progress};
use crate::error::Error;
use crate::storage::curricula::{self, Curriculum};
use crate::storage::practice;
use crate::storage::reports::{self, ExerciseInShort};
use crate::views::cohort::TraineeRow;
use crate::views::trainee::CourseFacts;

/// A course with what its pages tell.
pub(super) struct Taught {
    /// Id in its document.
    pub id: String,
    /// Title.
    pub title: String,
    /// What it teaches.
    pub description: String,
    /// Exercises and rule.
    pub course: Course,
    /// The pass mark of each exercise, 0–100, in the course's order.
    pub pass_marks: Vec<f64>,
    /// The difficulty of each exercise, 1–5, in the course's order.
    pub difficulties: Vec<u8>,
}

impl Taught {
    /// What the views need; with the trainee's page where they are for one trainee.
    pub fn facts<'a>(&'a self, trainee: Option<&'a str>) -> CourseFacts<'a> {
        CourseFacts { trainee, id: &self.id, title: &self.title, course: &self.course, pass_marks: &self.pass_marks }
    }
}

/// The courses of a school.
pub(super) async fn courses(state: &AppState, school: Uuid) -> Result<Vec<Taught>, Error> {
    let reader = state.db.reader();
    let exercises = reports::exercises(reader, school).await?;
    let mut courses = Vec::new();
    for curriculum in curricula::taught(reader, school).await? {
        let course = curricula::course(reader, school, &curriculum).await?;
        courses.push(taught(curriculum, course, &exercises));
    }
    Ok(courses)
}

fn taught(curriculum: Curriculum, course: Course, exercises: &[ExerciseInShort]) -> Taught {
    let Curriculum { curriculum_id: id, title, description, .. } = curriculum;
    let known = |id: &str| exercises.iter().find(|e| e.exercise_id == id);
    let of_each = || course.steps.iter().map(|step| known(&step.exercise));
    let pass_marks = of_each().map(|e| e.map_or(0.0, |e| e.pass_mark)).collect();
    let difficulties = of_each().map(|e| e.map_or(1, |e| e.difficulty)).collect();
    Taught { id, title, description, course, pass_marks, difficulties }
}

/// A trainee's progress in every course, the one tried last first, each with the course's index.
pub(super) fn progress(courses: &[Taught], attempts: &[Attempt], state: &AppState) -> Vec<(usize, Progress)> {
    let now = state.clock.now().to_utc();
    let mut progress: Vec<(usize, Progress)> =
        courses.iter().enumerate().map(|(i, taught)| (i, Progress::of(&taught.course, attempts, now))).collect();
    progress.sort_by_key(|(i, p)| (std::cmp::Reverse(p.last_at), *i));
    progress
}

/// A cohort: each trainee's row, and their progress in every course in the courses' order.
pub(super) struct CohortStanding {
    /// Rows by name.
    pub rows: Vec<TraineeRow>,
    /// Name and progress of each trainee, by course.
    pub by_course: Vec<Vec<(String, Progress)>>,
}

/// Where a cohort's trainees stand.
pub(super) async fn cohort(
    state: &AppState,
    school: Uuid,
    cohort: Uuid,
    courses: &[Taught],
) -> Result<CohortStanding, Error> {
    let reader = state.db.reader();
    let trainees = reports::members(reader, school, cohort, crate::domain::Role::Trainee).await?;
    let mut practised: BTreeMap<Uuid, Vec<Attempt>> = BTreeMap::new();
    for (trainee, attempt) in practice::of_cohort(reader, school, cohort).await? {
        practised.entry(trainee).or_default().push(attempt);
    }
    let mut standing = CohortStanding { rows: Vec::new(), by_course: courses.iter().map(|_| Vec::new()).collect() };
    for trainee in trainees {
        let own = practised.remove(&trainee.id).unwrap_or_default();
        let progress = progress(courses, &own, state);
        if let Some((i, main)) = progress.first() {
            let link = (format!("/trainees/{}", trainee.id), trainee.name.clone());
            standing.rows.push(TraineeRow::new(link, &courses[*i].facts(None), main));
        }
        for (i, progress) in progress {
            standing.by_course[i].push((trainee.name.clone(), progress));
        }
    }
    Ok(standing)
}
