//! Assignments: made, extended, taken back, judged, and reminded of.

use std::time::Duration;

use serde_json::json;
use uuid::Uuid;

use crate::AppState;
use crate::domain::assignment::{Assigned, Standing, Taught, Tried, sort};
use crate::domain::{CurrentPerson, due};
use crate::error::Error;
use crate::storage::assignments::{self, Listed, NewAssignment};
use crate::storage::audit::Entry;
use crate::storage::curricula;
use crate::storage::mails::{self, MailKind, NewMail};
use crate::storage::{practice, supervisions};

/// How long before it is due somebody is reminded, in s.
const REMIND_S: i64 = 48 * 3600;
/// How often it is looked who is to be reminded.
const EVERY: Duration = Duration::from_secs(600);

/// Makes an assignment.
///
/// # Errors
/// When the database fails.
pub async fn make(state: &AppState, by: &CurrentPerson, new: &NewAssignment) -> Result<Uuid, Error> {
    let mut tx = state.db.write().await?;
    let id = assignments::add(&mut tx, by, new, state.clock.now()).await?;
    let told =
        json!({ "cohort": new.cohort_id, "person": new.person_id, "due": new.due.as_ref().map(|(local, _)| local) });
    Entry::by(by, "assignment.made", id).with(told).append(&mut tx, state.clock.now()).await?;
    tx.commit().await?;
    Ok(id)
}

/// Lets one trainee have so many calendar days longer; as long as everybody with 0.
///
/// # Errors
/// When it has no due date, or the database fails.
pub async fn extend(
    state: &AppState,
    by: &CurrentPerson,
    assignment: &Listed,
    (person, days): (Uuid, i64),
) -> Result<(), Error> {
    let Some(local) = &assignment.due_local else {
        return Err(Error::Conflict(tr!("what has no due date is not extended").to_owned()));
    };
    let later = due::extended(local, &assignment.time_zone, days);
    let later = later.map_err(|refused| Error::Unprocessable(refused.to_string()))?;
    let mut tx = state.db.write().await?;
    let longer = (days > 0).then_some((days, later));
    assignments::extend(&mut tx, by.school_id, (assignment.id, person), longer).await?;
    let told = json!({ "person": person, "days": days });
    Entry::by(by, "assignment.extended", assignment.id).with(told).append(&mut tx, state.clock.now()).await?;
    Ok(tx.commit().await?)
}

/// Takes an assignment back.
///
/// # Errors
/// When the database fails.
pub async fn withdraw(state: &AppState, by: &CurrentPerson, assignment: Uuid) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    assignments::withdraw(&mut tx, by.school_id, assignment, state.clock.now()).await?;
    Entry::by(by, "assignment.withdrawn", assignment).append(&mut tx, state.clock.now()).await?;
    Ok(tx.commit().await?)
}

/// The courses of a school, for judging.
///
/// # Errors
/// When the database fails.
pub async fn taught(state: &AppState, school: Uuid) -> Result<Vec<Taught>, Error> {
    let reader = state.db.reader();
    let mut taught = Vec::new();
    for curriculum in curricula::taught(reader, school).await? {
        let course = curricula::course(reader, school, &curriculum).await?;
        taught.push(Taught { id: curriculum.curriculum_id, course });
    }
    Ok(taught)
}

/// What is assigned to a trainee and how far they have come, what is due first before.
///
/// # Errors
/// When the database fails.
pub async fn standings(state: &AppState, school: Uuid, person: Uuid) -> Result<Vec<Standing>, Error> {
    standings_in(state, &taught(state, school).await?, school, person).await
}

/// [`standings`], where the courses are known.
///
/// # Errors
/// When the database fails.
pub async fn standings_in(
    state: &AppState,
    taught: &[Taught],
    school: Uuid,
    person: Uuid,
) -> Result<Vec<Standing>, Error> {
    let reader = state.db.reader();
    let assigned: Vec<Assigned> = assignments::of_trainee(reader, school, person).await?;
    if assigned.is_empty() {
        return Ok(Vec::new());
    }
    let attempts = practice::of_trainee(reader, school, person).await?;
    let supervised = match assigned.iter().any(|assigned| assigned.supervised) {
        true => supervisions::of_trainee(reader, school, person).await?,
        false => Vec::new(),
    };
    let supervised = supervised.iter().map(Uuid::to_string).collect();
    let (now, tried) = (state.clock.now(), Tried { attempts: &attempts, supervised: &supervised });
    let mut standings: Vec<Standing> =
        assigned.into_iter().map(|assigned| Standing::of(assigned, taught, &tried, now)).collect();
    sort(&mut standings);
    Ok(standings)
}

/// Queues reminders, now and then.
pub async fn run(state: AppState) {
    loop {
        if let Err(error) = remind(&state).await {
            tracing::warn!(cause = %error, "reminders could not be queued");
        }
        tokio::time::sleep(EVERY).await;
    }
}

/// Queues a reminder for whatever is due soon; each once.
///
/// # Errors
/// When the database fails.
pub async fn remind(state: &AppState) -> Result<(), Error> {
    let now = state.clock.now();
    let due = assignments::to_remind(state.db.reader(), now, now.plus_s(REMIND_S)).await?;
    if due.is_empty() {
        return Ok(());
    }
    let mut tx = state.db.write().await?;
    for (school_id, person_id, assignment) in due {
        let mail = NewMail { school_id, person_id, kind: MailKind::Reminder, assignment_id: Some(assignment) };
        mails::queue(&mut tx, mail, now).await?;
    }
    tx.commit().await?;
    state.mails.notify_one();
    Ok(())
}
