//! Deadlines of assignments and marking tasks: extensions for single trainees, and reminders.

use std::time::Duration;

use model::CurrentPerson;
use model::ids::{DatedId, PersonId};
use model::letters::mail::MailKind;
use model::training::due;
use serde_json::json;
use store::audit::AuditEntry;
use store::letters::mails;
use store::letters::mails::NewMail;
use store::training::deadlines;
use store::training::deadlines::{DeadlineKey, DeadlineKind};

use crate::error::{Error, error_chain};
use crate::replicas::{self, Duty};
use crate::service::Service;

/// How long before a deadline the reminder is sent, in s.
const REMIND_S: i64 = 48 * 3600;
/// Age of a request to rate or to join a study at which people are reminded, in s.
const REQUEST_WAITS_S: i64 = 7 * 24 * 3600;
/// Age of a request from which nobody is reminded any more, in s.
const OLDEST_REQUEST_S: i64 = 30 * 24 * 3600;
/// Interval between checks for due reminders.
const EVERY: Duration = Duration::from_secs(600);
/// Maximum extension, in calendar days.
const MAX_DAYS: i64 = 366;

/// An item with a deadline.
#[derive(Clone, Copy, Debug)]
pub struct Dated<'a> {
    /// Kind of the item.
    pub kind: DeadlineKind,
    /// Its id.
    pub id: DatedId,
    /// Common deadline as entered, in local time.
    pub due_local: Option<&'a str>,
    /// Time zone of `due_local`.
    pub time_zone: &'a str,
}

/// Extends the deadline for one trainee by `days` calendar days; 0 removes the extension.
///
/// # Errors
/// Fails if `days` is out of range, the item has no deadline, or the database fails.
pub async fn extend(
    state: &Service,
    by: &CurrentPerson,
    dated: Dated<'_>,
    person: PersonId,
    days: i64,
) -> Result<(), Error> {
    if !(0..=MAX_DAYS).contains(&days) {
        return Err(Error::Unprocessable(tr!("days: {days}; 0 to {most} are allowed", days = days, most = MAX_DAYS)));
    }
    let Some(local) = dated.due_local else {
        return Err(Error::Conflict(tr!("no due date is set, so there is nothing to extend").to_owned()));
    };
    let later = due::extended(local, dated.time_zone, days);
    let later = later.map_err(|refused| Error::Unprocessable(refused.to_string()))?;
    let longer = (days > 0).then_some((days, later));
    let action = match dated.kind {
        DeadlineKind::Assignment => "assignment.extended",
        DeadlineKind::Segments => "segments.extended",
    };
    let mut tx = state.db.write().await?;
    let deadline = DeadlineKey { school_id: by.school_id, kind: dated.kind, id: dated.id };
    deadlines::extend_deadline(&mut tx, deadline, person, longer).await?;
    let told = json!({ "person": person, "days": days });
    AuditEntry::by(by, action, dated.id).with(told).append(&mut tx, state.clock.now()).await?;
    Ok(tx.commit().await?)
}

/// Queues reminders periodically until the future is dropped.
pub async fn run(state: Service) {
    loop {
        if let Err(error) = replicas::do_duty(&state, Duty::Reminders, remind(&state)).await {
            tracing::warn!(cause = error_chain(&error), "failed to queue reminders");
        }
        tokio::time::sleep(EVERY).await;
    }
}

/// Queues a reminder for every deadline within the next 48 h, and for ratings and invitations to
/// studies that wait for a week, once each.
pub async fn remind(state: &Service) -> Result<(), Error> {
    let now = state.clock.now();
    let soon = now.plus_s(REMIND_S);
    let mut due = deadlines::list_due_reminders(state.db.reader(), DeadlineKind::Assignment, now, soon).await?;
    due.extend(deadlines::list_due_reminders(state.db.reader(), DeadlineKind::Segments, now, soon).await?);
    due.extend(deadlines::list_closing_surveys(state.db.reader(), now, soon).await?);
    let (first, last) = (now.plus_s(-OLDEST_REQUEST_S), now.plus_s(-REQUEST_WAITS_S));
    due.extend(deadlines::list_waiting_rounds(state.db.reader(), first, last).await?);
    due.extend(deadlines::list_waiting_invitations(state.db.reader(), first, last).await?);
    if due.is_empty() {
        return Ok(());
    }
    let mut tx = state.db.write().await?;
    for due in due {
        let (school_id, person_id) = (due.school_id, due.person_id);
        let mail = NewMail { school_id, person_id, kind: MailKind::Reminder, assignment_id: Some(due.id) };
        mails::queue_mail(&mut tx, mail, now).await?;
    }
    tx.commit().await?;
    state.mails.notify_one();
    Ok(())
}
