//! Assignments: made, taken back, judged.

use std::collections::BTreeSet;

use model::assignment::{
    Assigned, AssignmentStanding, AssignmentTask, AttemptHistory, SupervisedSessions, TaughtCourse, sort,
};
use model::ids::{AssignmentId, CohortId, PersonId, SchoolId};
use model::progress::Course;
use model::{CurrentPerson, PersonKey, Role};
use serde_json::json;
use store::assignments::{ManagedAssignment, NewAssignment};
use store::audit::AuditEntry;
use store::curricula::TaughtCurriculum;
use store::deadlines::{CohortExtension, DeadlineKey, DeadlineKind};
use store::practice::ByTrainee;
use store::reports::NamedItem;
use store::{assignments, curricula, deadlines, notices as stored, practice, reports, supervisions};

use crate::deadlines::Dated;
use crate::error::Error;
use crate::notices::{self, News};
use crate::service::Service;

/// Makes an assignment.
///
/// # Errors
/// [`Error::Unprocessable`] where the same was assigned to the same, and is not over.
pub async fn make(state: &Service, by: &CurrentPerson, new: &NewAssignment) -> Result<AssignmentId, Error> {
    let mut tx = state.db.write().await?;
    if assignments::find_same_assignment(&mut *tx, by.school_id, new, state.clock.now()).await?.is_some() {
        let why = tr!("this is assigned to them already: change that assignment, or take it back first");
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

/// What is put off when an assignment is.
#[must_use]
pub fn dated(assignment: &ManagedAssignment) -> Dated<'_> {
    Dated {
        kind: DeadlineKind::Assignment,
        id: assignment.id.into(),
        due_local: assignment.due_local.as_deref(),
        time_zone: &assignment.time_zone,
    }
}

/// Takes an assignment back.
pub async fn withdraw(state: &Service, by: &CurrentPerson, assignment: AssignmentId) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    assignments::withdraw_assignment(&mut tx, by.school_id, assignment, state.clock.now()).await?;
    stored::forget_assignment_notices(&mut tx, by.school_id, assignment).await?;
    AuditEntry::by(by, "assignment.withdrawn", assignment).append(&mut tx, state.clock.now()).await?;
    Ok(tx.commit().await?)
}

/// The curricula that a school teaches, each with its course.
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

/// What is assigned to a trainee and how far they have come, what is due first before.
pub async fn standings(state: &Service, school: SchoolId, person: PersonId) -> Result<Vec<AssignmentStanding>, Error> {
    let taught = taught(state, school).await?;
    let attempts = practice::list_trainee_practice(state.db.reader(), school, person).await?;
    let tried = AttemptHistory::new(&taught, &attempts, state.clock.now());
    standings_by(state, PersonKey { school_id: school, person_id: person }, &tried).await
}

/// The same of a trainee whose attempts are known.
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

/// What is assigned in a cohort, and how far everybody has come with it.
#[derive(Clone, Debug)]
pub struct CohortStandings {
    /// What is assigned to the whole cohort, the earliest first.
    pub assigned: Vec<Assigned>,
    /// Every trainee.
    pub trainees: Vec<TraineeStandings>,
}

/// How far a trainee has come.
#[derive(Clone, Debug)]
pub struct TraineeStandings {
    /// Who.
    pub trainee: NamedItem<PersonId>,
    /// With what is assigned to the cohort, in its order.
    pub with_cohort: Vec<AssignmentStanding>,
    /// With what is assigned to them alone.
    pub alone: Vec<AssignmentStanding>,
}

/// A trainee and what they have practised.
#[derive(Debug)]
pub struct PractisedTrainee<'a> {
    /// Who.
    pub trainee: &'a NamedItem<PersonId>,
    /// Their attempts, and their progress by them.
    pub history: AttemptHistory<'a>,
}

/// How far the trainees of a cohort have come with everything that is assigned in it.
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

/// Who of those to whom an exercise is to be assigned cannot do it yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LockedTrainees {
    /// How many they are.
    pub locked: usize,
    /// Of how many.
    pub of: usize,
    /// Titles of what any of them must master first.
    pub missing: BTreeSet<String>,
}

/// Who would have to master something else before what is to be assigned; none of a course, which begins at its beginning.
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

/// How far those have come to whom something was assigned, in the order of `people`, who are some of them.
///
/// # Errors
/// [`Error::NotFound`] when it was taken back.
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
