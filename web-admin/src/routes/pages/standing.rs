//! Where trainees stand in the courses of their school.

use acts::assignments::{self as teaching, CohortPractice, CohortStandings};
use acts::error::Error;
use model::ids::{CohortId, PersonId, SchoolId};
use model::progress::{Course, Progress, ScoredAttempt};
use model::{Needed, Role, assignment};
use pages::cohort::TraineeRow;
use pages::trainee::CourseFacts;
use store::curricula::TaughtCurriculum;
use store::practice::ByTrainee;
use store::reports::{ExerciseInShort, NamedItem};
use store::{curricula, practice, proofs, reports, schools};

use crate::AppState;

/// A course with what its pages tell.
pub(super) struct TaughtCourse {
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

impl TaughtCourse {
    /// What the views need; with the trainee's page where they are for one trainee.
    pub fn facts<'a>(&'a self, trainee: Option<&'a str>) -> CourseFacts<'a> {
        CourseFacts { trainee, id: &self.id, title: &self.title, course: &self.course, pass_marks: &self.pass_marks }
    }
}

/// The courses of a school.
pub(super) async fn taught_courses(state: &AppState, school: SchoolId) -> Result<Vec<TaughtCourse>, Error> {
    let reader = state.db.reader();
    let exercises = reports::exercises(reader, school).await?;
    let mut courses = Vec::new();
    for curriculum in curricula::list_taught_curricula(reader, school).await? {
        let course = curricula::find_course(reader, school, &curriculum).await?;
        courses.push(taught_course(curriculum, course, &exercises));
    }
    Ok(courses)
}

fn taught_course(curriculum: TaughtCurriculum, course: Course, exercises: &[ExerciseInShort]) -> TaughtCourse {
    let TaughtCurriculum { curriculum_id: id, title, description, .. } = curriculum;
    let known = |id: &str| exercises.iter().find(|e| e.exercise_id == id);
    let of_each = || course.steps.iter().map(|step| known(&step.exercise));
    let pass_marks = of_each().map(|e| e.map_or(0.0, |e| e.pass_mark)).collect();
    let difficulties = of_each().map(|e| e.map_or(1, |e| e.difficulty)).collect();
    TaughtCourse { id, title, description, course, pass_marks, difficulties }
}

/// A trainee's progress in every course, the one tried last first, each with the course's index.
pub(super) fn progress_in_courses(
    courses: &[TaughtCourse],
    attempts: &[ScoredAttempt],
    state: &AppState,
) -> Vec<(usize, Progress)> {
    let now = state.clock.now().to_utc();
    let mut progress: Vec<(usize, Progress)> =
        courses.iter().enumerate().map(|(i, taught)| (i, Progress::of(&taught.course, attempts, now))).collect();
    progress.sort_by_key(|(i, p)| (std::cmp::Reverse(p.last_at), *i));
    progress
}

/// What a school asks to be proved of an attempt that certifies, and those of a trainee's attempts of which it is.
pub(super) async fn proved_attempts(
    state: &AppState,
    school: SchoolId,
    trainee: PersonId,
    attempts: &[ScoredAttempt],
) -> Result<(Needed, Vec<ScoredAttempt>), Error> {
    let needed = schools::certificate_needs(state.db.reader(), school).await?;
    let enough = proofs::list_proved_sessions(state.db.reader(), school, trainee, needed).await?;
    Ok((needed, attempts.iter().filter(|attempt| enough.contains(&attempt.session)).cloned().collect()))
}

/// A trainee with their progress in every course, the one tried last first, and the course's index.
type TraineeStanding = (NamedItem<PersonId>, Vec<(usize, Progress)>);

/// The trainees of a cohort by name.
pub(super) struct CohortStanding(Vec<TraineeStanding>);

impl CohortStanding {
    /// Everybody's progress in the course that they are on.
    pub fn main(&self) -> impl Iterator<Item = &Progress> {
        self.0.iter().filter_map(|(_, progress)| progress.first()).map(|(_, main)| main)
    }

    /// Name and progress of everybody in a course.
    pub fn in_course(&self, course: usize) -> Vec<(&str, &Progress)> {
        let of_all = self.0.iter().flat_map(|(trainee, progress)| progress.iter().map(move |(i, p)| (*i, trainee, p)));
        of_all.filter(|(i, ..)| *i == course).map(|(_, trainee, progress)| (trainee.name.as_str(), progress)).collect()
    }

    /// The rows of those whose progress in the course that they are on is wanted.
    pub fn rows(&self, courses: &[TaughtCourse], wanted: impl Fn(&Progress) -> bool) -> Vec<TraineeRow> {
        let row = |(trainee, progress): &TraineeStanding| {
            let (course, main) = progress.first().filter(|(_, main)| wanted(main))?;
            let href = format!("/trainees/{}", trainee.id);
            Some(TraineeRow::new(href, trainee.name.clone(), &courses[*course].facts(None), main))
        };
        self.0.iter().filter_map(row).collect()
    }
}

/// A cohort and everything that its trainees have practised.
pub(super) struct PractisedCohort {
    /// The cohort.
    pub cohort: NamedItem<CohortId>,
    trainees: Vec<NamedItem<PersonId>>,
    practised: ByTrainee,
}

/// What a cohort's trainees have practised.
pub(super) async fn practice_of_cohort(
    state: &AppState,
    school: SchoolId,
    cohort: NamedItem<CohortId>,
) -> Result<PractisedCohort, Error> {
    let reader = state.db.reader();
    let trainees = reports::members(reader, school, cohort.id, Role::Trainee).await?;
    let practised = practice::list_cohort_practice(reader, school, cohort.id).await?;
    Ok(PractisedCohort { cohort, trainees, practised })
}

impl PractisedCohort {
    /// Where its trainees stand in the courses.
    pub fn standing(&self, courses: &[TaughtCourse], state: &AppState) -> CohortStanding {
        let standing = |trainee: &NamedItem<PersonId>| {
            let own = self.practised.get(&trainee.id).map_or(&[][..], Vec::as_slice);
            (trainee.clone(), progress_in_courses(courses, own, state))
        };
        CohortStanding(self.trainees.iter().map(standing).collect())
    }

    /// How far they have come with what is assigned to them.
    pub async fn assignments(
        &self,
        courses: &[TaughtCourse],
        state: &AppState,
        school: SchoolId,
    ) -> Result<CohortStandings, Error> {
        let judged =
            |taught: &TaughtCourse| assignment::TaughtCourse { id: taught.id.clone(), course: taught.course.clone() };
        let taught: Vec<assignment::TaughtCourse> = courses.iter().map(judged).collect();
        let of = CohortPractice { trainees: &self.trainees, practised: &self.practised, taught: &taught };
        teaching::cohort_standings(state, school, self.cohort.id, of).await
    }
}
