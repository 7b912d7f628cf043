//! Retention of study data: erased after the period promised to the participants. The erasure is
//! announced on the study's page 30 days before, measured both by the clock and in service uptime,
//! so that a wrong clock erases nothing.

use model::ids::SchoolId;
use model::privacy::retention::{Now, RetentionAction, RetentionRule, Warned, step};
use serde_json::json;
use store::audit::{Actor, AuditEntry};
use store::people;
use store::people::directory;
use store::privacy::retention;
use store::studies::{self, Study};

use crate::error::Error;
use crate::privacy::erasing;
use crate::privacy::erasing::Eraser;
use crate::privacy::erasures::ErasureScope;
use crate::service::Service;

/// Time between the announcement and the erasure of a study's data, in days.
pub const ANNOUNCED_DAYS: u32 = 30;

/// Returns the pending step for the data of a study; `None` if it is open or nothing is due.
#[must_use]
pub fn plan_study(study: &Study, now: Now) -> Option<RetentionAction> {
    let rule = RetentionRule { months: study.kept_months, warn_days: ANNOUNCED_DAYS };
    let warned = study.told_at.zip(study.told_observed_s).map(|told| Warned { told: Some(told) });
    step(Some(rule), study.closed_at?, study.erased_at.is_some(), warned, now)
}

/// Carries out the pending announcements, cancellations and erasures of a school. Returns the
/// number of studies erased.
///
/// # Errors
/// Fails if the database, the erasure list or the disk fails; earlier steps remain done.
pub async fn keep_studies(state: &Service, school: SchoolId) -> Result<usize, Error> {
    let reader = state.db.reader();
    let observed_s = retention::service_time(reader).await?.observed_s;
    let now = Now { at: state.clock.now(), observed_s };
    let mut erased = 0;
    for study in studies::list_kept_studies(reader, school).await? {
        match plan_study(&study, now) {
            Some(RetentionAction::Warn) => announce(state, &study).await?,
            Some(RetentionAction::CallOff) => call_off(state, &study).await?,
            Some(RetentionAction::Erase) => {
                erase_study(state, &study).await?;
                erased += 1;
            }
            Some(RetentionAction::Sending | RetentionAction::Wait(_)) | None => {}
        }
    }
    Ok(erased)
}

async fn announce(state: &Service, study: &Study) -> Result<(), Error> {
    let now = state.clock.now();
    let mut tx = state.db.write().await?;
    studies::announce_study_erasure(&mut tx, study, now).await?;
    let told = json!({ "ended_at": study.closed_at, "months": study.kept_months, "days": ANNOUNCED_DAYS });
    entry(study, "study.erasure_announced").with(told).append(&mut tx, now).await?;
    Ok(tx.commit().await?)
}

async fn call_off(state: &Service, study: &Study) -> Result<(), Error> {
    let now = state.clock.now();
    let mut tx = state.db.write().await?;
    studies::call_off_study_erasure(&mut tx, study.school_id, study.id).await?;
    entry(study, "study.erasure_called_off").append(&mut tx, now).await?;
    Ok(tx.commit().await?)
}

fn entry<'a>(study: &Study, action: &'a str) -> AuditEntry<'a> {
    AuditEntry::new(study.school_id, Actor::Worker, action, study.id)
}

/// Deletes all participants' facts and answers for a study, and erases the guests with their
/// recordings. The attempts of members of the school are kept.
async fn erase_study(state: &Service, study: &Study) -> Result<(), Error> {
    let participants = studies::list_participants(state.db.reader(), study).await?;
    let everything = ErasureScope { written: true, about: true, recordings: true };
    for guest in participants.iter().filter(|participant| participant.name.is_none()) {
        let known = directory::find_anybody(state.db.reader(), study.school_id, guest.person_id).await?;
        if let Some(known) = known.filter(|known| known.state != model::people::directory::AccountState::Erased) {
            let by = Eraser { actor: Actor::Worker, why: Some(json!({ "study": study.id })) };
            erasing::erase(state, by, &known, study.school_id, everything).await?;
        }
    }
    let now = state.clock.now();
    let mut tx = state.db.write().await?;
    for participant in &participants {
        studies::withdraw_participant(&mut tx, study, participant.person_id, now).await?;
        if participant.name.is_none() {
            people::disable_person(&mut tx, participant.person_id, now).await?;
        }
    }
    studies::mark_study_erased(&mut tx, study, now).await?;
    let told = json!({ "participants": participants.len(), "months": study.kept_months });
    entry(study, "study.erased").with(told).append(&mut tx, now).await?;
    Ok(tx.commit().await?)
}
