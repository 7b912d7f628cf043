//! The queue of mails: each is made when it is sent, so that no link lies in the database.

use std::time::Duration;

use crate::AppState;
use crate::accounts;
use crate::assignments;
use crate::domain::assignment::{Stage, Standing};
use crate::error::Error;
use crate::mail::{Letter, retention, surveys};
use crate::storage::account_links::Purpose;
use crate::storage::mails::{self, Mail, MailKind};
use crate::storage::segments;
use crate::views::letters::{self, Reminded};
use crate::words::{self, Language};

/// How often the queue is looked at where nobody rings.
const EVERY: Duration = Duration::from_secs(60);
/// Mails of one look.
pub(super) const BATCH: u32 = 50;
/// Waits before the tries after the first, in s; after the last the mail is given up.
pub(super) const AGAIN_S: [i64; 6] = [60, 300, 1800, 7200, 21_600, 86_400];

/// Sends what is due, now and then and when rung.
pub async fn run(state: AppState) {
    loop {
        if let Err(error) = work_off(&state).await {
            tracing::warn!(cause = %error, "mails could not be sent");
        }
        tokio::select! {
            () = state.mails.notified() => {}
            () = tokio::time::sleep(EVERY) => {}
        }
    }
}

/// Sends what is due.
///
/// # Errors
/// When the database fails; a mail that cannot be sent waits for its next try.
pub async fn work_off(state: &AppState) -> Result<(), Error> {
    accounts::answer_asked(state).await?;
    loop {
        let due = mails::due(state.db.reader(), state.clock.now(), BATCH).await?;
        if due.is_empty() {
            surveys::work_off(state).await?;
            return retention::work_off(state).await;
        }
        for mail in due {
            deliver(state, &mail).await?;
        }
    }
}

async fn deliver(state: &AppState, mail: &Mail) -> Result<(), Error> {
    let language = mail.language.as_deref().and_then(Language::named).unwrap_or(Language::ENGLISH);
    let letter = words::speaking(language, compose(state, mail)).await?;
    let sent = match letter {
        Some(letter) => state.mailer.send(letter, state.clock.now()).await,
        None => {
            let mut tx = state.db.write().await?;
            mails::withdraw(&mut tx, mail.id).await?;
            return Ok(tx.commit().await?);
        }
    };
    let mut tx = state.db.write().await?;
    match sent {
        Ok(()) => mails::sent(&mut tx, mail.id, state.clock.now()).await?,
        Err(error) => {
            let wait_s = usize::try_from(mail.tries).ok().and_then(|tries| AGAIN_S.get(tries));
            let again = wait_s.map(|wait_s| state.clock.now().plus_s(*wait_s));
            tracing::warn!(mail = %mail.id, tries = mail.tries + 1, cause = format!("{error:#}"), "a mail was not sent");
            mails::failed(&mut tx, mail.id, &format!("{error:#}"), again).await?;
        }
    }
    Ok(tx.commit().await?)
}

/// The letter of a mail; none where it is not wanted any more.
async fn compose(state: &AppState, mail: &Mail) -> Result<Option<Letter>, Error> {
    if !mail.enabled {
        return Ok(None);
    }
    let (subject, body) = match mail.kind {
        MailKind::Invitation => letters::invitation(mail, &link(state, mail, Purpose::Invitation).await?),
        MailKind::Reset => letters::reset(mail, &link(state, mail, Purpose::Reset).await?),
        MailKind::SecondFactorOff => {
            letters::second_factor_off(mail, &format!("{}/account/second-factor", state.config.address()))
        }
        MailKind::Reminder => match reminder(state, mail).await? {
            Some(parts) => parts,
            None => return Ok(None),
        },
    };
    Ok(Some(Letter { id: mail.id, name: mail.name.clone(), email: mail.email.clone(), subject, body }))
}

/// A reminder of what is still to be done: an assignment, or a task to mark pops.
async fn reminder(state: &AppState, mail: &Mail) -> Result<Option<(String, String)>, Error> {
    let (is_meant, address) = (|id| Some(id) == mail.assignment_id, &state.config.address());
    let standings = assignments::standings(state, mail.school_id, mail.person_id).await?;
    if let Some(Standing { assigned, stage, .. }) = standings.iter().find(|s| is_meant(s.assigned.id) && s.is_open()) {
        let remind = |due_at| {
            let of = Reminded { title: &assigned.title, due_at, time_zone: &assigned.time_zone, stage };
            letters::reminder(mail, of, &format!("{address}/assignments"))
        };
        return Ok(assigned.due_at.map(remind));
    }
    let tasks = segments::of_trainee(state.db.reader(), mail.school_id, mail.person_id).await?;
    let still = tasks.iter().find(|task| is_meant(task.id) && task.sent < task.traces);
    let remind = |(task, due_at): (&segments::Task, _)| {
        let stage = &Stage::Open { left: None };
        let of = Reminded { title: &task.title, due_at, time_zone: &task.time_zone, stage };
        letters::reminder(mail, of, &format!("{address}/segments/{}", task.id))
    };
    Ok(still.and_then(|task| Some((task, task.due_at?))).map(remind))
}

async fn link(state: &AppState, mail: &Mail, purpose: Purpose) -> Result<String, Error> {
    let mut tx = state.db.write().await?;
    let address = accounts::make_link(&mut tx, state, (mail.school_id, mail.person_id), purpose).await?;
    tx.commit().await?;
    Ok(address)
}
