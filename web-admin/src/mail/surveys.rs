//! Letters with a survey's link. Each goes out at most once: it leaves the queue before it is handed over, so a service that
//! dies in between has written to nobody twice.

use super::outbox::{AGAIN_S, BATCH};
use crate::AppState;
use crate::domain::Moment;
use crate::domain::survey::{Identity, PROFESSIONAL};
use crate::error::Error;
use crate::mail;
use crate::secret;
use crate::storage::surveys::{self, Letter, NewResponse, Survey, letters};
use crate::surveys::{instrument_of, link_expiry};
use crate::views;

/// Sends the letters that are due.
///
/// # Errors
/// When the database fails; a letter that cannot be sent waits for its next try.
pub(super) async fn work_off(state: &AppState) -> Result<(), Error> {
    loop {
        let due = letters::due(state.db.reader(), state.clock.now(), BATCH).await?;
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
    let survey = surveys::find(state.db.reader(), letter.school_id, letter.survey_id).await?.ok_or(Error::NotFound)?;
    if !survey.is_open(now) {
        return note(state, letter, Err(("the survey was not open".to_owned(), None))).await;
    }
    let token = claim(state, letter, &survey).await?;
    let link = format!("{}/survey/{token}", state.config.address());
    let minutes = instrument_of(state, &survey).await?.duration_min;
    let (subject, body) = views::letters::survey(letter, &survey, (&link, minutes, link_expiry(&survey, now)));
    let (name, email) = (letter.name.clone(), letter.email.clone());
    let sent = state.mailer.send(mail::Letter { id: letter.id, name, email, subject, body }, now).await;
    let outcome = sent.map_err(|error| {
        let wait_s = usize::try_from(letter.tries).ok().and_then(|tries| AGAIN_S.get(tries));
        tracing::warn!(letter = %letter.id, tries = letter.tries + 1, cause = format!("{error:#}"), "a letter was not sent");
        (format!("{error:#}"), wait_s.map(|wait_s| now.plus_s(*wait_s)))
    });
    note(state, letter, outcome).await
}

/// Takes the letter from the queue, and makes its link; the secret.
async fn claim(state: &AppState, letter: &Letter, survey: &Survey) -> Result<String, Error> {
    let token = secret::random_hex()?;
    let token_sha256 = secret::token_sha256(&token);
    let mut tx = state.db.write().await?;
    let response = match letter.response_id {
        Some(response) => {
            surveys::set_token(&mut tx, (survey.school_id, response), &token_sha256).await?;
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
    letters::claim(&mut tx, letter, response).await?;
    tx.commit().await?;
    Ok(token)
}

async fn note(state: &AppState, letter: &Letter, outcome: Result<(), (String, Option<Moment>)>) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    match outcome {
        Ok(()) => letters::sent(&mut tx, letter, state.clock.now()).await?,
        Err((error, again)) => letters::failed(&mut tx, letter, &error, again).await?,
    }
    Ok(tx.commit().await?)
}
