//! Warnings before the erasure of inactive people. Unlike other mails, they stay in the queue until
//! they are known to have been sent: a second warning is better than an erasure without one.

use acts::error::Error;
use acts::letters::mailing;
use acts::replicas::{self, Duty};
use model::letters::mail::RetentionLetter;
use pages::letters;
use platform::mailer::Letter;
use routes_base::AppState;
use store::privacy::retention;
use words::Language;

use super::{BATCH, until_database_answers};

/// Sends all due warnings.
///
/// # Errors
/// Fails if the database fails; a mail that cannot be sent is retried later.
pub(super) async fn work_off_retention_letters(state: &AppState) -> Result<(), Error> {
    loop {
        let due = retention::list_due_warnings(state.db.reader(), state.clock.now(), BATCH).await?;
        if due.is_empty() {
            return Ok(());
        }
        for letter in due {
            // This replica may have been suspended and declared dead; then another one sends the
            // mails.
            if !replicas::is_on_duty(state, Duty::Letters).await? {
                return Ok(());
            }
            deliver_retention_letter(state, &letter).await?;
        }
    }
}

async fn deliver_retention_letter(state: &AppState, letter: &RetentionLetter) -> Result<(), Error> {
    let _in_hand = state.letter_in_hand.lock().await;
    let sent = send_retention_letter(state, letter).await.map_err(|error| format!("{error:#}"));
    until_database_answers(state, || mailing::note_retention_letter(state, letter, &sent)).await
}

async fn send_retention_letter(state: &AppState, letter: &RetentionLetter) -> anyhow::Result<()> {
    // The school has removed its retention policy; the next evaluation withdraws the warning.
    let Some(months) = letter.months else { return Ok(()) };
    let language = letter.language.as_deref().and_then(Language::named).unwrap_or(Language::ENGLISH);
    let link = format!("{}/login", state.config.address());
    let (subject, body) =
        words::speaking(language, async { letters::write_retention_letter(letter, months, &link) }).await;
    let (name, email) = (letter.name.clone(), letter.email.clone());
    state.mailer.send(Letter { id: letter.id, name, email, subject, body }, state.clock.now()).await
}
