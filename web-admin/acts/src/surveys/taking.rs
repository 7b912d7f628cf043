//! Survey answers sent by programs for an attempt: a station in its debriefing, possibly long after
//! they were given.
//!
//! The program chooses the secret of the response, so that sending the same answers twice creates
//! one response. Until they are final, they may be sent again with changes.

use std::collections::BTreeMap;

use assessment::questionnaire::{Answer, read_answer};
use documents::Instrument;
use model::Moment;
use model::ids::SurveyId;
use model::surveys::{ResponseState, Survey};
use platform::secret;
use store::recordings::sessions::Session;
use store::surveys::{NewResponse, Practised, SurveyResponse};
use store::{Connection, Json, people, surveys};

use super::answering::{ANSWERED, Answering};
use crate::error::Error;
use crate::service::Service;

/// Length of a secret, in hexadecimal digits: 256 bits, as for secrets created by the service.
const SECRET_DIGITS: usize = 64;

/// Answers to a survey after an attempt.
#[derive(Clone, Copy, Debug)]
pub struct AnsweredSheet<'a> {
    /// The attempt.
    pub session: &'a Session,
    /// The survey.
    pub survey: SurveyId,
    /// The secret of the response, chosen by the sender.
    pub secret: &'a str,
    /// Language code.
    pub language: &'a str,
    /// Answers by item id, as form fields.
    pub answers: &'a BTreeMap<String, Vec<String>>,
    /// Whether they are final.
    pub sent: bool,
}

/// Stores answers and returns the state of the response. Final answers are not changed.
///
/// # Errors
/// Fails if the survey does not belong to the attempt, an answer is not allowed, or the person has
/// already answered otherwise.
pub async fn take(state: &Service, sheet: &AnsweredSheet<'_>) -> Result<ResponseState, Error> {
    if sheet.secret.len() != SECRET_DIGITS || !sheet.secret.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return Err(Error::Unprocessable(format!("secret: allowed: {SECRET_DIGITS} hexadecimal digits")));
    }
    let now = state.clock.now();
    let survey = asked(state, sheet, now).await?;
    let instrument = super::instrument_of(state, &survey).await?;
    let language = instrument.language_for(sheet.language).to_owned();
    let answers = Json(read(&instrument, sheet.answers)?);
    let mut tx = state.db.write().await?;
    let response = response(&mut tx, sheet, &survey, now).await?;
    if matches!(response.state, ResponseState::Submitted | ResponseState::Withdrawn) {
        return Ok(response.state);
    }
    let mut answering = Answering { response: SurveyResponse { language, answers, ..response }, survey, instrument };
    answering.drop_unasked();
    answering.store(&mut tx, now).await?;
    if sheet.sent {
        answering.submit(&mut tx, now).await?;
    }
    tx.commit().await?;
    Ok(if sheet.sent { ResponseState::Submitted } else { ResponseState::Begun })
}

/// Returns the survey if it is offered after the attempt now, or was when the attempt was made:
/// answers may have been waiting at a station.
async fn asked(state: &Service, sheet: &AnsweredSheet<'_>, now: Moment) -> Result<Survey, Error> {
    let (reader, session) = (state.db.reader(), sheet.session);
    let survey = surveys::find(reader, session.school_id, sheet.survey).await?.ok_or(Error::NotFound)?;
    for at in [now, session.started_at] {
        let open = surveys::after_attempt(reader, Practised::by(session), at).await?;
        if open.iter().any(|open| open.id == survey.id) {
            return Ok(survey);
        }
    }
    Err(Error::Gone("this survey does not follow this attempt, or was not open"))
}

fn read(instrument: &Instrument, given: &BTreeMap<String, Vec<String>>) -> Result<Vec<Option<Answer>>, Error> {
    if let Some(unknown) = given.keys().find(|id| instrument.item(id).is_none()) {
        let items: Vec<&str> = instrument.items.iter().map(|item| item.id.as_str()).collect();
        return Err(Error::Unprocessable(format!("answers.{unknown}: no such item; allowed: {}", items.join(", "))));
    }
    let answer = |item: &documents::instrument::Item| {
        let (Some(said), Some(scale)) = (given.get(&item.id), instrument.scale(item)) else { return Ok(None) };
        let said: Vec<&str> = said.iter().map(String::as_str).collect();
        read_answer(item, scale, &said).map_err(|why| Error::Unprocessable(format!("answers.{}: {why}", item.id)))
    };
    instrument.items.iter().map(answer).collect()
}

/// Returns the response with the sheet's secret, creating it if it does not exist.
async fn response(
    writer: &mut Connection,
    sheet: &AnsweredSheet<'_>,
    survey: &Survey,
    now: Moment,
) -> Result<SurveyResponse, Error> {
    let (session, token_sha256) = (sheet.session, secret::token_sha256(sheet.secret));
    if let Some(known) = surveys::by_token(&mut *writer, &token_sha256).await? {
        let own = known.survey_id == survey.id && known.session_id.is_none_or(|id| id == session.id);
        return if own { Ok(known) } else { Err(Error::Conflict("secret: it belongs to another response".to_owned())) };
    }
    let attempt = Some(session.id);
    let begun = surveys::draft_of(&mut *writer, survey.school_id, survey.id, session.trainee_id, attempt).await?;
    if let Some(link) = begun.as_ref().filter(|begun| begun.state == ResponseState::Invited) {
        // The study has created a link that has not been used: take over its response.
        surveys::set_token(writer, link.school_id, link.id, &token_sha256).await?;
        return surveys::by_token(writer, &token_sha256).await?.ok_or(Error::NotFound);
    }
    if begun.is_some() || surveys::answered(&mut *writer, survey, session.trainee_id, attempt).await? {
        return Err(Error::Conflict(ANSWERED.to_owned()));
    }
    let person = people::find_person(&mut *writer, session.trainee_id).await?.ok_or(Error::NotFound)?;
    let new = NewResponse {
        school_id: survey.school_id,
        survey_id: survey.id,
        token_sha256,
        role: person.role.as_str(),
        label: None,
        person_id: Some(person.id),
        session_id: attempt,
        language: sheet.language,
        consented_at: Some(now),
        expires_at: None,
    };
    surveys::add(writer, &new).await?;
    surveys::by_token(writer, &token_sha256).await?.ok_or(Error::NotFound)
}
