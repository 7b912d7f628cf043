//! Assignments: made, taken back, judged.

use std::collections::BTreeSet;

use model::CurrentPerson;
use model::assignment::{Assigned, AssignmentStanding, AttemptHistory, TaughtCourse, sort};
use model::ids::{AssignmentId, PersonId, SchoolId};
use serde_json::json;
use store::assignments::{ManagedAssignment, NewAssignment};
use store::audit::AuditEntry;
use store::deadlines::{DeadlineKey, DeadlineKind};
use store::{assignments, curricula, deadlines, notices as stored, practice, supervisions};

use crate::deadlines::Dated;
use crate::error::Error;
use crate::notices::{self, News};
use crate::service::Service;

/// Makes an assignment.
pub async fn make(state: &Service, by: &CurrentPerson, new: &NewAssignment) -> Result<AssignmentId, Error> {
    let mut tx = state.db.write().await?;
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

/// The courses of a school, for judging.
pub async fn taught(state: &Service, school: SchoolId) -> Result<Vec<TaughtCourse>, Error> {
    let reader = state.db.reader();
    let mut taught = Vec::new();
    for curriculum in curricula::list_taught_curricula(reader, school).await? {
        let course = curricula::find_course(reader, school, &curriculum).await?;
        taught.push(TaughtCourse { id: curriculum.curriculum_id, course });
    }
    Ok(taught)
}

/// What is assigned to a trainee and how far they have come, what is due first before.
pub async fn standings(state: &Service, school: SchoolId, person: PersonId) -> Result<Vec<AssignmentStanding>, Error> {
    let reader = state.db.reader();
    let assigned: Vec<Assigned> = assignments::list_trainee_assignments(reader, school, person).await?;
    if assigned.is_empty() {
        return Ok(Vec::new());
    }
    let taught = taught(state, school).await?;
    let attempts = practice::list_trainee_practice(reader, school, person).await?;
    let supervised = match assigned.iter().any(|assigned| assigned.supervised) {
        true => supervisions::list_trainee_supervisions(reader, school, person).await?,
        false => Vec::new(),
    };
    let supervised = supervised.into_iter().collect();
    let (now, tried) = (state.clock.now(), AttemptHistory { attempts: &attempts, supervised: &supervised });
    let mut standings: Vec<AssignmentStanding> =
        assigned.into_iter().map(|assigned| AssignmentStanding::of(assigned, &taught, &tried, now)).collect();
    sort(&mut standings);
    Ok(standings)
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
        false => BTreeSet::new(),
    };
    let now = state.clock.now();
    let of = |person: &PersonId| {
        let mut own = assigned.clone();
        if let Some(longer) = longer.iter().find(|extension| extension.person_id == *person) {
            (own.due_at, own.extended_days) = (Some(longer.due_at), longer.days);
        }
        let attempts = practised.get(person).map_or(&[][..], Vec::as_slice);
        AssignmentStanding::of(own, &taught, &AttemptHistory { attempts, supervised: &supervised }, now)
    };
    Ok(people.iter().map(of).collect())
}
