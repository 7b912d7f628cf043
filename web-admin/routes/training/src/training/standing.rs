//! Progress of trainees in the courses of their school.

use std::collections::BTreeMap;

use acts::error::Error;
use acts::training::assignments as teaching;
use acts::training::assignments::{CohortStandings, PractisedTrainee};
use acts::training::badges;
use model::ids::{CohortId, PersonId, SchoolId};
use model::training::assignment::{AttemptHistory, TaughtCourse as JudgedCourse};
use model::training::progress::{Course, Progress, ScoredAttempt};
use model::training::risk::{Concern, PersonAtRisk};
use model::{CurrentPerson, Moment, Needed, PersonKey, Role};
use pages::training::cohort::{NamedTrainee, TraineeRow};
use pages::training::trainee::CourseFacts;
use routes_base::AppState;
use store::operations::schools;
use store::training::curricula::TaughtCurriculum;
use store::training::practice::ByTrainee;
use store::training::reports::{ExerciseInShort, NamedItem};
use store::training::{practice, reports};

/// A course with the data that its pages show.
pub(crate) struct TaughtCourse {
    /// Id in its document.
    pub id: String,
    /// Title.
    pub title: String,
    /// Description of its content.
    pub description: String,
    /// SHA-256 of its current revision.
    pub sha256: String,
    /// Exercises and rule.
    pub course: Course,
    /// The pass mark of each exercise, 0–100, in the course's order.
    pub pass_marks: Vec<f64>,
    /// The difficulty of each exercise, 1–5, in the course's order.
    pub difficulties: Vec<u8>,
}

impl TaughtCourse {
    /// Returns the facts for the views; with the trainee's page if the view is about one trainee.
    pub fn facts<'a>(&'a self, trainee: Option<&'a str>) -> CourseFacts<'a> {
        CourseFacts { trainee, id: &self.id, title: &self.title, course: &self.course, pass_marks: &self.pass_marks }
    }
}

/// Returns the courses of a school.
pub(crate) async fn taught_courses(state: &AppState, school: SchoolId) -> Result<Vec<TaughtCourse>, Error> {
    let exercises = reports::exercises(state.db.reader(), school).await?;
    let taught = teaching::taught_curricula(state, school).await?.into_iter();
    Ok(taught.map(|(curriculum, course)| taught_course(curriculum, course, &exercises)).collect())
}

fn taught_course(curriculum: TaughtCurriculum, course: Course, exercises: &[ExerciseInShort]) -> TaughtCourse {
    let TaughtCurriculum { curriculum_id: id, title, description, sha256, .. } = curriculum;
    let known = |id: &str| exercises.iter().find(|e| e.exercise_id == id);
    let of_each = || course.steps.iter().map(|step| known(&step.exercise));
    let pass_marks = of_each().map(|e| e.map_or(0.0, |e| e.pass_mark)).collect();
    let difficulties = of_each().map(|e| e.map_or(1, |e| e.difficulty)).collect();
    TaughtCourse { id, title, description, sha256, course, pass_marks, difficulties }
}

/// Returns the part of each course that attempts are evaluated by.
pub(crate) fn judged_courses(courses: &[TaughtCourse]) -> Vec<JudgedCourse> {
    courses.iter().map(|taught| JudgedCourse { id: taught.id.clone(), course: taught.course.clone() }).collect()
}

/// Returns a trainee's progress in every course, most recently practised first, each with the
/// course's index.
pub(crate) fn progress_in_courses(courses: &[TaughtCourse], attempts: &[ScoredAttempt]) -> Vec<(usize, Progress)> {
    let mut progress: Vec<(usize, Progress)> =
        courses.iter().enumerate().map(|(i, taught)| (i, Progress::of(&taught.course, attempts))).collect();
    progress.sort_by_key(|(i, p)| (std::cmp::Reverse(p.last_at), *i));
    progress
}

/// Returns the evidence that a school requires for certificates, and those of a trainee's attempts
/// that have it.
pub(crate) async fn proved_attempts(
    state: &AppState,
    school: SchoolId,
    trainee: PersonId,
    attempts: &[ScoredAttempt],
) -> Result<(Needed, Vec<ScoredAttempt>), Error> {
    let needed = schools::certificate_needs(state.db.reader(), school).await?;
    let key = PersonKey { school_id: school, person_id: trainee };
    Ok((needed, badges::list_proved_attempts(state, key, needed, attempts).await?))
}

/// A cohort and all attempts of its trainees.
pub(crate) struct PractisedCohort {
    /// The cohort.
    pub cohort: NamedItem<CohortId>,
    trainees: Vec<NamedItem<PersonId>>,
    practised: ByTrainee,
}

/// Returns the attempts of the trainees of every cohort that a person teaches. Reading thousands of
/// attempts takes time, so each cohort is read in a task of its own.
pub(crate) async fn practice_of_cohorts(
    state: &AppState,
    person: &CurrentPerson,
) -> Result<Vec<PractisedCohort>, Error> {
    let school = person.school_id;
    let read = |cohort| {
        let state = state.clone();
        tokio::spawn(async move { practice_of_cohort(&state, school, cohort).await })
    };
    let reading: Vec<_> = reports::cohorts(state.db.reader(), person).await?.into_iter().map(read).collect();
    let mut practised = Vec::with_capacity(reading.len());
    for cohort in reading {
        practised.push(cohort.await??);
    }
    Ok(practised)
}

/// Returns the attempts of a cohort's trainees.
pub(crate) async fn practice_of_cohort(
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
    /// Evaluates the progress of its trainees in the courses.
    pub fn standing<'a>(&'a self, taught: &'a [JudgedCourse], now: Moment) -> CohortStanding<'a> {
        let of = |trainee: &'a NamedItem<PersonId>| {
            let attempts = self.practised.get(&trainee.id).map_or(&[][..], Vec::as_slice);
            PractisedTrainee { trainee, history: AttemptHistory::new(taught, attempts, now) }
        };
        CohortStanding { cohort: self.cohort.id, trainees: self.trainees.iter().map(of).collect() }
    }
}

/// The trainees of a cohort by name, with their progress.
pub(crate) struct CohortStanding<'a> {
    cohort: CohortId,
    trainees: Vec<PractisedTrainee<'a>>,
}

impl CohortStanding<'_> {
    /// Returns each trainee's progress in their current course.
    pub fn main(&self) -> impl Iterator<Item = &Progress> {
        self.trainees.iter().filter_map(|of| of.history.main_course().map(|course| of.history.in_course(course)))
    }

    /// Returns the trainees, by name.
    pub fn trainees(&self) -> impl Iterator<Item = &NamedItem<PersonId>> {
        self.trainees.iter().map(|of| of.trainee)
    }

    /// Returns name and progress of every trainee in a course.
    pub fn in_course(&self, course: usize) -> Vec<(&str, &Progress)> {
        self.trainees.iter().map(|of| (of.trainee.name.as_str(), of.history.in_course(course))).collect()
    }

    /// How many have mastered a course of the school.
    pub fn count_complete(&self, courses: usize) -> usize {
        let mastered = |of: &&PractisedTrainee<'_>| (0..courses).any(|course| of.history.in_course(course).complete());
        self.trainees.iter().filter(mastered).count()
    }

    /// The course that most have begun, the first where none is.
    pub fn find_begun_course(&self, courses: usize) -> Option<usize> {
        let begun =
            |course: &usize| self.trainees.iter().filter(|of| of.history.in_course(*course).attempts() > 0).count();
        (0..courses).min_by_key(|course| std::cmp::Reverse(begun(course)))
    }

    /// Everybody, with the reasons for which they are at risk.
    pub fn concerned<'b>(&'b self, at_risk: &'b [PersonAtRisk]) -> Vec<ConcernedTrainee<'b>> {
        let places: BTreeMap<PersonId, usize> =
            at_risk.iter().enumerate().map(|(place, of)| (of.trainee.id, place)).collect();
        let concerned = |of: &'b PractisedTrainee<'_>| {
            let place = places.get(&of.trainee.id).copied();
            ConcernedTrainee { of, place, concerns: place.map_or(&[], |place| &at_risk[place].concerns) }
        };
        self.trainees.iter().map(concerned).collect()
    }

    /// Returns the trainees' progress with their assignments.
    pub async fn assignments(&self, state: &AppState, school: SchoolId) -> Result<CohortStandings, Error> {
        teaching::cohort_standings(state, school, self.cohort, &self.trainees).await
    }
}

/// A trainee, and why they may need help.
pub(crate) struct ConcernedTrainee<'a> {
    of: &'a PractisedTrainee<'a>,
    /// Their place in the list of people at risk.
    place: Option<usize>,
    /// The most pressing first.
    concerns: &'a [Concern],
}

impl ConcernedTrainee<'_> {
    /// Their name.
    pub fn name(&self) -> &str {
        &self.of.trainee.name
    }

    /// Their row in a course, or in the one that they are on.
    pub fn row(&self, courses: &[TaughtCourse], course: Option<usize>) -> Option<TraineeRow> {
        let course = course.or_else(|| self.of.history.main_course())?;
        let who =
            NamedTrainee { href: format!("/trainees/{}", self.of.trainee.id), name: self.of.trainee.name.clone() };
        let progress = self.of.history.in_course(course);
        Some(TraineeRow::new(who, &courses[course].facts(None), progress, self.concerns))
    }
}

/// Those who are at risk, in the order of the list of people at risk.
pub(crate) fn sort_help<'a, 'b>(all: &'a [ConcernedTrainee<'b>]) -> Vec<&'a ConcernedTrainee<'b>> {
    let mut help: Vec<_> = all.iter().filter(|one| one.place.is_some()).collect();
    help.sort_by_key(|one| one.place);
    help
}
