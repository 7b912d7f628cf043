//! The data of a study go when the months are over that were promised to whoever took part: announced on its page a month before, by the
//! clock and by the time that the service has run, so that no clock erases anything.

use model::ids::SchoolId;
use model::retention::{Now, RetentionAction, RetentionRule, Warned, step};
use serde_json::json;
use store::audit::{Actor, AuditEntry};
use store::studies::{self, Study};
use store::{directory, people, retention};

use crate::erasing::{self, Eraser};
use crate::erasures::ErasureScope;
use crate::error::Error;
use crate::service::Service;

/// Days for which the end of a study's data is announced.
pub const ANNOUNCED_DAYS: u32 = 30;

/// What is to be done about the data of a study that has ended.
#[must_use]
pub fn plan_study(study: &Study, now: Now) -> Option<RetentionAction> {
    let rule = RetentionRule { months: study.kept_months, warn_days: ANNOUNCED_DAYS };
    let warned = study.told_at.zip(study.told_observed_s).map(|told| Warned { told: Some(told) });
    step(Some(rule), study.closed_at?, study.erased_at.is_some(), warned, now)
}

/// Announces, calls off and erases what is due in a school. How many studies were erased.
///
/// # Errors
/// When the database, the list of erasures or the disk fails; what is done until then stays done.
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

/// Takes away what everybody told and answered for a study, and the guests with their recordings. What people of the school did in it is
/// theirs, and stays with them.
async fn erase_study(state: &Service, study: &Study) -> Result<(), Error> {
    let participants = studies::list_participants(state.db.reader(), study).await?;
    let everything = ErasureScope { written: true, about: true, recordings: true };
    for guest in participants.iter().filter(|participant| participant.name.is_none()) {
        let known = directory::find_anybody(state.db.reader(), study.school_id, guest.person_id).await?;
        if let Some(known) = known.filter(|known| known.state != model::directory::AccountState::Erased) {
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
