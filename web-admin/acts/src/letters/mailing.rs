//! The mail queue: claiming, retries, and the links in mails. The pages module writes the texts;
//! the sender records the result here.

use model::letters::mail::{Mail, RetentionLetter, SurveyLetter};
use model::surveys::{Identity, PROFESSIONAL, Survey};
use model::{Moment, PersonKey};
use platform::secret;
use store::auth::account_links::Purpose;
use store::letters::mails;
use store::privacy::retention;
use store::surveys;
use store::surveys::{NewResponse, letters};

use crate::error::Error;
use crate::people::accounts;
use crate::service::Service;
use crate::surveys::link_expiry;

/// Delays before the retries, in s; after the last one a mail is given up.
const AGAIN_S: [i64; 6] = [60, 300, 1800, 7200, 21_600, 86_400];

/// Result of sending a mail: the reason if it failed.
pub type LetterResult = Result<(), String>;

/// Returns the time of the next retry after `tries` earlier retries; `None` after the last.
fn next_try(state: &Service, tries: i64) -> Option<Moment> {
    let wait_s = usize::try_from(tries).ok().and_then(|tries| AGAIN_S.get(tries));
    wait_s.map(|wait_s| state.clock.now().plus_s(*wait_s))
}

/// Claims a mail before it is sent, so that a service that crashes while sending does not send it
/// twice. Returns false if another replica has claimed it.
pub async fn claim_mail(state: &Service, mail: &Mail) -> Result<bool, Error> {
    let mut tx = state.db.write().await?;
    let claimed = mails::claim_mail(&mut tx, mail.id).await?;
    tx.commit().await?;
    Ok(claimed)
}

/// Records the result of sending a mail; a failed one is scheduled for a retry or given up.
pub async fn note_mail(state: &Service, mail: &Mail, sent: &LetterResult) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    match sent {
        Ok(()) => mails::mark_mail_sent(&mut tx, mail.id, state.clock.now()).await?,
        Err(error) => {
            tracing::warn!(mail = %mail.id, tries = mail.tries + 1, cause = error, "email not sent");
            mails::mark_mail_failed(&mut tx, mail.id, error, next_try(state, mail.tries)).await?;
        }
    }
    Ok(tx.commit().await?)
}

/// Removes an obsolete mail from the queue.
pub async fn withdraw_mail(state: &Service, mail: &Mail) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    mails::withdraw_mail(&mut tx, mail.id).await?;
    Ok(tx.commit().await?)
}

/// Postpones the reminders of a person that are due.
pub async fn postpone_reminders(state: &Service, whom: PersonKey, until: Moment) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    mails::postpone_reminders(&mut tx, whom, state.clock.now(), until).await?;
    Ok(tx.commit().await?)
}

/// Creates the link in a mail and returns its address.
pub async fn make_link(state: &Service, mail: &Mail, purpose: Purpose) -> Result<String, Error> {
    accounts::make_link(state, PersonKey { school_id: mail.school_id, person_id: mail.person_id }, purpose).await
}

/// Claims a survey invitation, as [`claim_mail`] does, and returns the secret of its link. Returns
/// `None` if another replica has claimed it.
pub async fn claim_survey_letter(
    state: &Service,
    letter: &SurveyLetter,
    survey: &Survey,
) -> Result<Option<String>, Error> {
    let token = secret::random_hex()?;
    let token_sha256 = secret::token_sha256(&token);
    let mut tx = state.db.write().await?;
    let response = match letter.response_id {
        Some(response) => {
            surveys::set_token(&mut tx, survey.school_id, response, &token_sha256).await?;
            response
        }
        None => {
            let named = survey.identity == Identity::Named;
            let label = if letter.name.is_empty() { &letter.email } else { &letter.name };
            let new = NewResponse {
                school_id: survey.school_id,
                survey_id: survey.id,
                token_sha256,
                role: PROFESSIONAL,
                label: named.then_some(label),
                person_id: None,
                session_id: None,
                language: "en",
                consented_at: None,
                expires_at: Some(link_expiry(survey, state.clock.now())),
            };
            surveys::add(&mut tx, &new).await?
        }
    };
    if !letters::claim_survey_letter(&mut tx, letter, response).await? {
        return Ok(None);
    }
    tx.commit().await?;
    Ok(Some(token))
}

/// Gives up a survey invitation because the survey is over.
pub async fn give_up_survey_letter(state: &Service, letter: &SurveyLetter, why: &str) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    letters::mark_letter_failed(&mut tx, letter, why, None).await?;
    Ok(tx.commit().await?)
}

/// Records the result of sending a survey invitation; a failed one is scheduled for a retry or
/// given up.
pub async fn note_survey_letter(state: &Service, letter: &SurveyLetter, sent: &LetterResult) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    match sent {
        Ok(()) => letters::mark_letter_sent(&mut tx, letter, state.clock.now()).await?,
        Err(error) => {
            tracing::warn!(letter = %letter.id, tries = letter.tries + 1, cause = error, "email not sent");
            letters::mark_letter_failed(&mut tx, letter, error, next_try(state, letter.tries)).await?;
        }
    }
    Ok(tx.commit().await?)
}

/// Records the result of sending an erasure warning; a failed one is scheduled for a retry or given
/// up.
pub async fn note_retention_letter(
    state: &Service,
    letter: &RetentionLetter,
    sent: &LetterResult,
) -> Result<(), Error> {
    let again = sent.as_ref().err().and_then(|_| next_try(state, letter.tries));
    if let Err(error) = sent {
        tracing::warn!(letter = %letter.id, tries = letter.tries + 1, cause = error, "email not sent");
    }
    let mut tx = state.db.write().await?;
    let error = sent.as_ref().err().map(String::as_str);
    retention::note_warning_letter(&mut tx, letter.id, error, again, state.clock.now()).await?;
    Ok(tx.commit().await?)
}
