//! Assignments: creates and withdraws them, and reports progress.

use std::collections::BTreeSet;

use model::ids::{AssignmentId, CohortId, PersonId, SchoolId};
use model::training::assignment::{
    Assigned, AssignmentStanding, AssignmentTask, AttemptHistory, SupervisedSessions, TaughtCourse, sort,
};
use model::training::progress::Course;
use model::{CurrentPerson, PersonKey, Role};
use serde_json::json;
use store::audit::AuditEntry;
use store::letters::notices as stored;
use store::scoring::supervisions;
use store::training::assignments::{ManagedAssignment, NewAssignment};
use store::training::curricula::TaughtCurriculum;
use store::training::deadlines::{CohortExtension, DeadlineKey, DeadlineKind};
use store::training::practice::ByTrainee;
use store::training::reports::NamedItem;
use store::training::{assignments, curricula, deadlines, practice, reports};

use crate::error::Error;
use crate::letters::notices;
use crate::letters::notices::News;
use crate::service::Service;
use crate::training::deadlines::Dated;

/// Creates an assignment.
///
/// # Errors
/// Returns [`Error::Unprocessable`] if the same task is already assigned to the same cohort or
/// person and is not over.
pub async fn make(state: &Service, by: &CurrentPerson, new: &NewAssignment) -> Result<AssignmentId, Error> {
    let mut tx = state.db.write().await?;
    if assignments::find_same_assignment(&mut *tx, by.school_id, new, state.clock.now()).await?.is_some() {
        let why = tr!("this is already assigned to them: change or withdraw that assignment first");
        return Err(Error::Unprocessable(why.to_owned()));
    }
    let id = assignments::add_assignment(&mut tx, by, new, state.clock.now()).await?;
    let told =
        json!({ "cohort": new.cohort_id, "person": new.person_id, "due": new.due.as_ref().map(|(local, _)| local) });
    AuditEntry::by(by, "assignment.made", id).with(told).append(&mut tx, state.clock.now()).await?;
    notices::tell(&mut tx, by, News::Assigned(id), state.clock.now()).await?;
    tx.commit().await?;
    Ok(id)
}

/// Returns the deadline of an assignment in the form in which deadlines are extended.
#[must_use]
pub fn dated(assignment: &ManagedAssignment) -> Dated<'_> {
    Dated {
        kind: DeadlineKind::Assignment,
        id: assignment.id.into(),
        due_local: assignment.due_local.as_deref(),
        time_zone: &assignment.time_zone,
    }
}

/// Withdraws an assignment and deletes its notices.
pub async fn withdraw(state: &Service, by: &CurrentPerson, assignment: AssignmentId) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    assignments::withdraw_assignment(&mut tx, by.school_id, assignment, state.clock.now()).await?;
    stored::forget_assignment_notices(&mut tx, by.school_id, assignment).await?;
    AuditEntry::by(by, "assignment.withdrawn", assignment).append(&mut tx, state.clock.now()).await?;
    Ok(tx.commit().await?)
}

/// Lists the curricula that a school teaches, each with its course.
pub async fn taught_curricula(state: &Service, school: SchoolId) -> Result<Vec<(TaughtCurriculum, Course)>, Error> {
    let reader = state.db.reader();
    let curricula = curricula::list_taught_curricula(reader, school).await?;
    let mut steps = curricula::list_course_steps(reader, school).await?;
    let replaced = curricula::list_replaced_curricula(reader, school).await?;
    let with_course = |curriculum: TaughtCurriculum| {
        let course = curriculum.take_course(&mut steps, &replaced);
        (curriculum, course)
    };
    Ok(curricula.into_iter().map(with_course).collect())
}

/// A curriculum that a school teaches, with its course.
///
/// # Errors
/// [`Error::NotFound`] when the school does not teach it.
pub async fn find_taught_curriculum(
    state: &Service,
    school: SchoolId,
    id: &str,
) -> Result<(TaughtCurriculum, Course), Error> {
    let taught = taught_curricula(state, school).await?;
    taught.into_iter().find(|(curriculum, _)| curriculum.curriculum_id == id).ok_or(Error::NotFound)
}

/// The courses of a school, for judging.
pub async fn taught(state: &Service, school: SchoolId) -> Result<Vec<TaughtCourse>, Error> {
    let taught = taught_curricula(state, school).await?.into_iter();
    Ok(taught.map(|(curriculum, course)| TaughtCourse { id: curriculum.curriculum_id, course }).collect())
}

/// Returns a trainee's assignments with their progress, earliest deadline first.
pub async fn standings(state: &Service, school: SchoolId, person: PersonId) -> Result<Vec<AssignmentStanding>, Error> {
    let taught = taught(state, school).await?;
    let attempts = practice::list_trainee_practice(state.db.reader(), school, person).await?;
    let tried = AttemptHistory::new(&taught, &attempts, state.clock.now());
    standings_by(state, PersonKey { school_id: school, person_id: person }, &tried).await
}

/// Like [`standings`], for a trainee whose attempts have already been read.
pub async fn standings_by(
    state: &Service,
    PersonKey { school_id: school, person_id: person }: PersonKey,
    tried: &AttemptHistory<'_>,
) -> Result<Vec<AssignmentStanding>, Error> {
    let reader = state.db.reader();
    let assigned: Vec<Assigned> = assignments::list_trainee_assignments(reader, school, person).await?;
    let supervised = match assigned.iter().any(|assigned| assigned.supervised) {
        true => supervisions::list_trainee_supervisions(reader, school, person).await?,
        false => Vec::new(),
    };
    let supervised = supervised.into_iter().collect();
    let mut standings: Vec<AssignmentStanding> =
        assigned.into_iter().map(|assigned| AssignmentStanding::of(assigned, tried, &supervised)).collect();
    sort(&mut standings);
    Ok(standings)
}

/// The assignments of a cohort and the progress of each trainee.
#[derive(Clone, Debug)]
pub struct CohortStandings {
    /// Assignments to the whole cohort, earliest first.
    pub assigned: Vec<Assigned>,
    /// Progress of each trainee.
    pub trainees: Vec<TraineeStandings>,
}

/// Progress of one trainee.
#[derive(Clone, Debug)]
pub struct TraineeStandings {
    /// The trainee.
    pub trainee: NamedItem<PersonId>,
    /// Progress on the assignments to the cohort, in their order.
    pub with_cohort: Vec<AssignmentStanding>,
    /// Progress on the assignments to this trainee alone.
    pub alone: Vec<AssignmentStanding>,
}

/// A trainee and their practice.
#[derive(Debug)]
pub struct PractisedTrainee<'a> {
    /// The trainee.
    pub trainee: &'a NamedItem<PersonId>,
    /// Their attempts and the progress computed from them.
    pub history: AttemptHistory<'a>,
}

/// Computes the progress of the trainees of a cohort on all its assignments, personal extensions
/// included.
pub async fn cohort_standings(
    state: &Service,
    school: SchoolId,
    cohort: CohortId,
    trainees: &[PractisedTrainee<'_>],
) -> Result<CohortStandings, Error> {
    let reader = state.db.reader();
    let (alone, assigned): (Vec<Assigned>, Vec<Assigned>) =
        assignments::list_cohort_assignments(reader, school, cohort)
            .await?
            .into_iter()
            .partition(|assigned| assigned.person_id.is_some());
    let (longer, supervised) = if assigned.is_empty() && alone.is_empty() {
        (Vec::new(), SupervisedSessions::new())
    } else {
        let longer = deadlines::list_cohort_extensions(reader, school, cohort).await?;
        (longer, supervisions::list_cohort_supervisions(reader, school, cohort).await?.into_iter().collect())
    };
    let standing = |assigned: &Assigned, of: &PractisedTrainee<'_>| {
        let mut own = assigned.clone();
        let is_theirs = |x: &&CohortExtension| x.assignment_id == own.id && x.extension.person_id == of.trainee.id;
        if let Some(CohortExtension { extension, .. }) = longer.iter().find(is_theirs) {
            (own.due_at, own.extended_days) = (Some(extension.due_at), extension.days);
        }
        AssignmentStanding::of(own, &of.history, &supervised)
    };
    let of_trainee = |of: &PractisedTrainee<'_>| TraineeStandings {
        with_cohort: assigned.iter().map(|assigned| standing(assigned, of)).collect(),
        alone: alone
            .iter()
            .filter(|assigned| assigned.person_id == Some(of.trainee.id))
            .map(|assigned| standing(assigned, of))
            .collect(),
        trainee: of.trainee.clone(),
    };
    let trainees = trainees.iter().map(of_trainee).collect();
    Ok(CohortStandings { assigned, trainees })
}

/// Trainees who cannot do an exercise yet because they have not mastered its prerequisites.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LockedTrainees {
    /// Number of locked trainees.
    pub locked: usize,
    /// Number of trainees to whom the exercise is to be assigned.
    pub of: usize,
    /// Titles of the prerequisites that any of them is missing.
    pub missing: BTreeSet<String>,
}

/// Finds the trainees who have not mastered the prerequisites of an exercise. Returns `None` if all
/// can do it, or if a course is to be assigned: its first exercise has no prerequisites.
pub async fn find_locked_trainees(
    state: &Service,
    school: SchoolId,
    new: &NewAssignment,
) -> Result<Option<LockedTrainees>, Error> {
    let AssignmentTask::Exercise(exercise) = &new.task else { return Ok(None) };
    let reader = state.db.reader();
    let trainees = match (new.cohort_id, new.person_id) {
        (Some(cohort), _) => {
            reports::members(reader, school, cohort, Role::Trainee).await?.into_iter().map(|t| t.id).collect()
        }
        (None, person) => person.into_iter().collect::<Vec<_>>(),
    };
    let taught = taught(state, school).await?;
    let mut practised = match new.cohort_id {
        Some(cohort) => practice::list_cohort_practice(reader, school, cohort).await?,
        None => ByTrainee::new(),
    };
    let mut found = LockedTrainees { locked: 0, of: trainees.len(), missing: BTreeSet::new() };
    for trainee in trainees {
        let attempts = match new.cohort_id {
            Some(_) => practised.remove(&trainee).unwrap_or_default(),
            None => practice::list_trainee_practice(reader, school, trainee).await?,
        };
        let missing = AttemptHistory::new(&taught, &attempts, state.clock.now()).missing_before(exercise);
        found.locked += usize::from(!missing.is_empty());
        found.missing.extend(missing);
    }
    Ok((found.locked > 0).then_some(found))
}

/// Returns the progress of `people`, a subset of the assignees, on one assignment, in their order.
///
/// # Errors
/// Returns [`Error::NotFound`] if the assignment does not exist or was withdrawn.
pub async fn standings_at(
    state: &Service,
    school: SchoolId,
    id: AssignmentId,
    people: &[PersonId],
) -> Result<Vec<AssignmentStanding>, Error> {
    let reader = state.db.reader();
    let assigned = assignments::find_assignment(reader, school, id).await?.ok_or(Error::NotFound)?;
    let taught = taught(state, school).await?;
    let practised = practice::of_assignment(reader, school, id).await?;
    let longer = deadlines::list_extensions(
        reader,
        DeadlineKey { school_id: school, kind: DeadlineKind::Assignment, id: id.into() },
    )
    .await?;
    let supervised = match assigned.supervised {
        true => supervisions::of_assignment(reader, school, id).await?.into_iter().collect(),
        false => SupervisedSessions::new(),
    };
    let now = state.clock.now();
    let of = |person: &PersonId| {
        let mut own = assigned.clone();
        if let Some(longer) = longer.iter().find(|extension| extension.person_id == *person) {
            (own.due_at, own.extended_days) = (Some(longer.due_at), longer.days);
        }
        let attempts = practised.get(person).map_or(&[][..], Vec::as_slice);
        AssignmentStanding::of(own, &AttemptHistory::new(&taught, attempts, now), &supervised)
    };
    Ok(people.iter().map(of).collect())
}
