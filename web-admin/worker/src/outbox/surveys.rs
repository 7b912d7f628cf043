//! Mails with survey links.

use acts::error::Error;
use acts::letters::mailing;
use acts::surveys::{instrument_of, link_expiry};
use model::letters::mail::SurveyLetter;
use pages::letters;
use platform::mailer::Letter;
use routes_base::AppState;
use store::surveys;

use super::{BATCH, until_database_answers};

/// Sends all due mails.
///
/// # Errors
/// Fails if the database fails; a mail that cannot be sent is retried later.
pub(super) async fn work_off_survey_letters(state: &AppState) -> Result<(), Error> {
    loop {
        let due = surveys::letters::list_due_survey_letters(state.db.reader(), state.clock.now(), BATCH).await?;
        if due.is_empty() {
            return Ok(());
        }
        for letter in due {
            deliver_survey_letter(state, &letter).await?;
        }
    }
}

async fn deliver_survey_letter(state: &AppState, letter: &SurveyLetter) -> Result<(), Error> {
    let now = state.clock.now();
    let survey = surveys::find(state.db.reader(), letter.school_id, letter.survey_id).await?.ok_or(Error::NotFound)?;
    if !survey.is_open(now) {
        return mailing::give_up_survey_letter(state, letter, "the survey was not open").await;
    }
    let minutes = instrument_of(state, &survey).await?.duration_min;
    let _in_hand = state.letter_in_hand.lock().await;
    let Some(token) = mailing::claim_survey_letter(state, letter, &survey).await? else { return Ok(()) };
    let link = format!("{}/survey/{token}", state.config.address());
    let (subject, body) = letters::write_survey_letter(letter, &survey, &link, minutes, link_expiry(&survey, now));
    let (name, email) = (letter.name.clone(), letter.email.clone());
    let sent = state.mailer.send(Letter { id: letter.id, name, email, subject, body }, now).await;
    let sent = sent.map_err(|error| format!("{error:#}"));
    until_database_answers(state, || mailing::note_survey_letter(state, letter, &sent)).await
}
