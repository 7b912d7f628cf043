//! The mail queue. A mail is composed when it is sent, so that no link is stored in the database.
//! Each is sent at most once: it is claimed before it is handed to the mail server. If the sender
//! crashes in between, it is unknown whether the mail was sent; the pages show this.

use acts::error::{Error, error_chain};
use acts::letters::mailing;
use acts::people::accounts;
use acts::replicas::{self, Duty};
use model::PersonKey;
use model::letters::mail::{Mail, MailKind};
use pages::letters;
use pages::letters::news::NewsItem;
use platform::mailer::Letter;
use routes_base::AppState;
use store::auth::account_links::Purpose;
use store::letters::{mails, notices};
use store::training::support_notes;
use words::Language;

mod reminders;
mod retention;
mod surveys;

/// Maximum number of notices listed in a mail.
const SHOWN_NEWS: u32 = 20;
/// Number of mails read from the queue at once.
pub(super) const BATCH: u32 = 50;
/// Sends due mails periodically and when notified.
pub async fn run_outbox(state: AppState) {
    loop {
        if let Err(error) = replicas::do_duty(&state, Duty::Letters, work_off_letters(&state)).await {
            tracing::warn!(cause = error_chain(&error), "failed to send emails");
        }
        tokio::select! {
            () = state.mails.notified() => {}
            () = tokio::time::sleep(state.db.listening_period()) => {}
        }
    }
}

/// Sends all due mails.
///
/// # Errors
/// Fails if the database fails; a mail that cannot be sent is retried later.
pub async fn work_off_letters(state: &AppState) -> Result<(), Error> {
    accounts::answer_asked(state).await?;
    loop {
        let due = mails::list_due_mails(state.db.reader(), state.clock.now(), BATCH).await?;
        if due.is_empty() {
            surveys::work_off_survey_letters(state).await?;
            return retention::work_off_retention_letters(state).await;
        }
        for mail in due {
            deliver_letter(state, &mail).await?;
        }
    }
}

async fn deliver_letter(state: &AppState, mail: &Mail) -> Result<(), Error> {
    if mail.kind == MailKind::Reminder && mail.enabled {
        return reminders::deliver_reminders(state, mail).await;
    }
    let language = mail.language.as_deref().and_then(Language::named).unwrap_or(Language::ENGLISH);
    let letter = words::speaking(language, compose_letter(state, mail)).await?;
    let Some(letter) = letter else { return mailing::withdraw_mail(state, mail).await };
    let _in_hand = state.letter_in_hand.lock().await;
    // This replica may have been suspended and declared dead; then another one sends the mails.
    if !mailing::claim_mail(state, mail).await? {
        return Ok(());
    }
    let sent = state.mailer.send(letter, state.clock.now()).await.map_err(|error| format!("{error:#}"));
    until_database_answers(state, || mailing::note_mail(state, mail, &sent)).await
}

/// Records a result, retrying while the database is unavailable: no other process knows it.
async fn until_database_answers<F: Future<Output = Result<(), Error>>>(
    state: &AppState,
    note: impl Fn() -> F,
) -> Result<(), Error> {
    loop {
        match note().await {
            Err(Error::DatabaseUnavailable(_)) => tokio::time::sleep(state.db.listening_period()).await,
            noted => return noted,
        }
    }
}

/// Composes a mail; returns `None` if it is obsolete.
async fn compose_letter(state: &AppState, mail: &Mail) -> Result<Option<Letter>, Error> {
    if !mail.enabled {
        return Ok(None);
    }
    let (subject, body) = match mail.kind {
        MailKind::Invitation => {
            letters::write_invitation(mail, &mailing::make_link(state, mail, Purpose::Invitation).await?)
        }
        MailKind::Reset => letters::write_reset_letter(mail, &mailing::make_link(state, mail, Purpose::Reset).await?),
        MailKind::SecondFactorOff => {
            letters::write_factor_off_letter(mail, &format!("{}/account/second-factor", state.config.address()))
        }
        MailKind::IdentityJoined => {
            letters::write_identity_letter(mail, &format!("{}/account/identities", state.config.address()))
        }
        MailKind::News => match compose_news_letter(state, mail).await? {
            Some(parts) => parts,
            None => return Ok(None),
        },
        MailKind::Message => match compose_message(state, mail).await? {
            Some(parts) => parts,
            None => return Ok(None),
        },
        // Reminders go together, in one letter.
        MailKind::Reminder => return Ok(None),
    };
    Ok(Some(Letter { id: mail.id, name: mail.name.clone(), email: mail.email.clone(), subject, body }))
}

/// Composes a mail about unread notices; returns `None` if all have been read.
async fn compose_news_letter(state: &AppState, mail: &Mail) -> Result<Option<(String, String)>, Error> {
    let whom = PersonKey { school_id: mail.school_id, person_id: mail.person_id };
    let unread = notices::list_unread_notices(state.db.reader(), whom, SHOWN_NEWS).await?;
    let items = NewsItem::list(&unread);
    Ok((!items.is_empty()).then(|| letters::write_news_letter(mail, &items, &state.config.address())))
}

/// Composes a teacher's message; returns `None` if it was erased.
async fn compose_message(state: &AppState, mail: &Mail) -> Result<Option<(String, String)>, Error> {
    let Some(id) = mail.note_id else { return Ok(None) };
    let whom = PersonKey { school_id: mail.school_id, person_id: mail.person_id };
    let note = support_notes::find_support_note(state.db.reader(), whom, id).await?;
    Ok(note.map(|note| letters::write_message(mail, &note)))
}
