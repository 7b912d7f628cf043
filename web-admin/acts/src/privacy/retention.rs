//! Retention policy: a person inactive for the period set by their school is warned and then
//! erased, exactly as by a manual erasure. A school without a policy keeps everyone.
//!
//! A wrong clock cannot erase anyone: the days between the warning and the erasure must also have
//! passed in service uptime.

use std::time::Duration;

use model::ids::{PersonId, SchoolId};
use model::people::directory::AccountState;
use model::privacy::retention::{Now, RetentionAction, step};
use model::{CurrentPerson, PersonKey, count_i64};
use platform::clock;
use serde_json::json;
use store::audit::{Actor, AuditEntry};
use store::operations::schools;
use store::people::directory;
use store::privacy::retention;
use store::privacy::retention::{Idle, Settings};

use crate::error::Error;
use crate::privacy::erasing::Eraser;
use crate::privacy::{erasing, study_retention};
use crate::replicas::{self, Duty};
use crate::service::Service;

/// Interval at which the uptime is stored.
const EVERY: Duration = Duration::from_secs(600);
/// Uptime between two evaluations of the policy, in s.
const LOOK_EVERY_S: i64 = 86_400;

/// A pending step of the policy for one person.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RetentionStep {
    /// The person.
    pub idle: Idle,
    /// The action.
    pub step: RetentionAction,
}

/// Result of applying the policy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RetentionResult {
    /// People warned.
    pub warned: usize,
    /// People whose warning was withdrawn.
    pub called_off: usize,
    /// People erased.
    pub erased: usize,
}

/// Returns a school's policy and its pending steps, without carrying them out.
pub async fn plan(state: &Service, school: SchoolId) -> Result<(Settings, Vec<RetentionStep>), Error> {
    let reader = state.db.reader();
    let settings = retention::find_retention_rule(reader, school).await?;
    let observed_s = retention::service_time(reader).await?.observed_s;
    let (now, rule) = (Now { at: state.clock.now(), observed_s }, settings.rule());
    let since = rule.map(|rule| rule.warned_since(now.at));
    let planned = retention::list_idle_people(reader, school, since).await?.into_iter().filter_map(|idle| {
        let step = step(rule, idle.active_at, idle.held_at.is_some(), idle.warned(), now)?;
        Some(RetentionStep { idle, step })
    });
    Ok((settings, planned.collect()))
}

/// Carries out the pending steps of a school: warns, withdraws warnings and erases.
///
/// # Errors
/// Fails if the database, the erasure list or the disk fails; earlier steps remain done.
pub async fn act(state: &Service, school: SchoolId) -> Result<RetentionResult, Error> {
    let (settings, planned) = plan(state, school).await?;
    let mut done = RetentionResult::default();
    let mut tx = state.db.write().await?;
    for RetentionStep { idle, step } in &planned {
        let now = state.clock.now();
        let told = json!({ "active_at": idle.active_at, "months": settings.months });
        match step {
            RetentionAction::Warn => {
                retention::warn_person(&mut tx, school, idle, now).await?;
                entry(school, "retention.warned", idle).with(told).append(&mut tx, now).await?;
                done.warned += 1;
            }
            RetentionAction::CallOff => {
                retention::forget_warning(&mut tx, idle.id).await?;
                entry(school, "retention.called_off", idle).with(told).append(&mut tx, now).await?;
                done.called_off += 1;
            }
            RetentionAction::Sending | RetentionAction::Wait(_) | RetentionAction::Erase => {}
        }
    }
    tx.commit().await?;
    state.mails.notify_one();
    let wish = erasing::wish_of_school(state, school, settings.texts, settings.texts).await?;
    for RetentionStep { idle, .. } in planned.iter().filter(|planned| planned.step == RetentionAction::Erase) {
        let person = directory::find_directory_entry(state.db.reader(), school, idle.id).await?;
        let Some(person) = person.filter(|person| person.state != AccountState::Erased) else { continue };
        let why = json!({ "active_at": idle.active_at, "told_at": idle.told_at, "months": settings.months });
        let by = Eraser { actor: Actor::Worker, why: Some(why) };
        erasing::erase(state, by, &person, school, wish).await?;
        done.erased += 1;
    }
    Ok(done)
}

fn entry<'a>(school: SchoolId, action: &'a str, idle: &Idle) -> AuditEntry<'a> {
    AuditEntry::new(school, Actor::Worker, action, idle.id)
}

/// Applies the policy once per day of uptime, until the future is dropped.
pub async fn run(state: Service) {
    let mut last = clock::instant();
    loop {
        tokio::time::sleep(EVERY).await;
        let now = clock::instant();
        let done = replicas::do_duty(&state, Duty::Retention, tick(&state, now.duration_since(last))).await;
        // After a failure too: uptime that is lost delays an erasure, uptime that counts twice hastens it.
        last = now;
        if let Err(error) = done {
            tracing::warn!(cause = format!("{error:?}"), "retention failed");
        }
    }
}

/// Adds to the stored uptime, and applies the policy if a day of uptime has passed since the last
/// time.
///
/// # Errors
/// Fails if the database, the erasure list or the disk fails.
pub async fn tick(state: &Service, elapsed: Duration) -> Result<(), Error> {
    let seconds = count_i64(elapsed.as_secs());
    let mut tx = state.db.write().await?;
    let time = retention::add_service_time(&mut tx, seconds).await?;
    tx.commit().await?;
    if time.looked_s.is_some_and(|looked_s| time.observed_s - looked_s < LOOK_EVERY_S) {
        return Ok(());
    }
    let mut failed = None;
    for school in schools::list_schools(state.db.reader()).await? {
        match act(state, school.id).await {
            Ok(done) if done == RetentionResult::default() => {}
            Ok(done) => tracing::info!(school = %school.id, ?done, "retention"),
            // A failure must not block the other schools.
            Err(error) => failed = Some(error),
        }
        match study_retention::keep_studies(state, school.id).await {
            Ok(0) => {}
            Ok(erased) => tracing::info!(school = %school.id, erased, "erased study data past the retention period"),
            Err(error) => failed = Some(error),
        }
    }
    if let Some(error) = failed {
        return Err(error);
    }
    let mut tx = state.db.write().await?;
    retention::note_look(&mut tx).await?;
    Ok(tx.commit().await?)
}

/// Places a person under legal hold, which exempts them from erasure, or ends the hold.
pub async fn set_held(state: &Service, by: &CurrentPerson, person: PersonId, held: bool) -> Result<(), Error> {
    let (now, mut tx) = (state.clock.now(), state.db.write().await?);
    let (since, action) = if held { (Some(now), "person.held") } else { (None, "person.released") };
    if retention::hold_person(&mut tx, PersonKey { school_id: by.school_id, person_id: person }, since).await? {
        AuditEntry::by(by, action, person).append(&mut tx, now).await?;
    }
    Ok(tx.commit().await?)
}
