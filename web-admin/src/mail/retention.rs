//! Letters to whoever is to be erased because they do nothing any more.

use super::outbox::{AGAIN_S, BATCH};
use crate::AppState;
use crate::error::Error;
use crate::mail;
use crate::storage::retention::{self, Letter};
use crate::views::letters;
use crate::words::{self, Language};

/// Sends the letters that are due.
///
/// # Errors
/// When the database fails; a letter that cannot be sent waits for its next try.
pub(super) async fn work_off(state: &AppState) -> Result<(), Error> {
    loop {
        let due = retention::due_letters(state.db.reader(), state.clock.now(), BATCH).await?;
        if due.is_empty() {
            return Ok(());
        }
        for letter in due {
            deliver(state, &letter).await?;
        }
    }
}

async fn deliver(state: &AppState, letter: &Letter) -> Result<(), Error> {
    let now = state.clock.now();
    let (error, again) = match send(state, letter).await {
        Ok(()) => (None, None),
        Err(error) => {
            let wait_s = usize::try_from(letter.tries).ok().and_then(|tries| AGAIN_S.get(tries));
            tracing::warn!(letter = %letter.id, tries = letter.tries + 1, cause = format!("{error:#}"), "a letter was not sent");
            (Some(format!("{error:#}")), wait_s.map(|wait_s| now.plus_s(*wait_s)))
        }
    };
    let mut tx = state.db.write().await?;
    retention::note_letter(&mut tx, letter.id, (error.as_deref(), again), now).await?;
    Ok(tx.commit().await?)
}

async fn send(state: &AppState, letter: &Letter) -> anyhow::Result<()> {
    // Whoever set the rule has taken it back: the next look calls the warning off.
    let Some(months) = letter.months else { return Ok(()) };
    let language = letter.language.as_deref().and_then(Language::named).unwrap_or(Language::ENGLISH);
    let link = format!("{}/login", state.config.address());
    let (subject, body) = words::speaking(language, async { letters::retention(letter, months, &link) }).await;
    let (name, email) = (letter.name.clone(), letter.email.clone());
    state.mailer.send(mail::Letter { id: letter.id, name, email, subject, body }, state.clock.now()).await
}
