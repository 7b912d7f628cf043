//! Answering surveys: anyone with the URL of a response can edit it until it is sent, and can
//! withdraw it.
//!
//! The URL is the only credential: it contains a random secret, of which only a hash is stored, and
//! needs no account. Signed-in people get one, too, so that there is a single form and a single way
//! to save. Drafts leave no trace in the audit log; sending and withdrawing are recorded, without a
//! name.

use assessment::questionnaire::{Answer, Refused, asked_pages, is_asked, read_answer};
use documents::Instrument;
use model::ids::SessionId;
use model::surveys::given::GivenAnswers;
use model::surveys::{ResponseState, Survey};
use model::{CurrentPerson, Moment};
use platform::secret;
use store::audit::{Actor, AuditEntry};
use store::surveys::{NewResponse, Submission, SurveyResponse};
use store::{Connection, surveys};

use crate::error::Error;
use crate::service::Service;

pub(super) const ANSWERED: &str = "these answers were already sent; they can be withdrawn, but not changed";

/// A response with its survey.
#[derive(Clone, Debug)]
pub struct Answering {
    /// The response so far.
    pub response: SurveyResponse,
    /// Its survey.
    pub survey: Survey,
    /// The survey's instrument.
    pub instrument: Instrument,
}

/// Returns the response of a secret.
///
/// # Errors
/// Returns [`Error::NotFound`] if the secret is unknown, and [`Error::Gone`] if the response can no
/// longer be edited because its link has expired or the survey is not open.
pub async fn open(state: &Service, token: &str) -> Result<Answering, Error> {
    let reader = state.db.reader();
    let found = surveys::by_token(reader, &secret::token_sha256(token)).await?.ok_or(Error::NotFound)?;
    let survey = surveys::find(reader, found.school_id, found.survey_id).await?.ok_or(Error::NotFound)?;
    let now = state.clock.now();
    let open = matches!(found.state, ResponseState::Invited | ResponseState::Begun);
    if open && found.expires_at.is_some_and(|expires| expires <= now) {
        return Err(Error::Gone(tr!("this link has expired; ask the sender for a new one")));
    }
    if open && !survey.is_open(now) {
        return Err(Error::Gone(tr!("this survey is not open; ask the person who sent you the link")));
    }
    let instrument = super::instrument_of(state, &survey).await?;
    let mut response = found;
    response.answers.0.resize(instrument.items.len(), None);
    Ok(Answering { response, survey, instrument })
}

impl Answering {
    /// Returns the indices of the pages that apply, given the answers so far.
    #[must_use]
    pub fn asked_pages(&self) -> Vec<usize> {
        asked_pages(&self.instrument, &self.response.answers).into_iter().map(|(page, _)| page).collect()
    }

    /// Returns whether an item on an applicable page applies, given the answers so far.
    #[must_use]
    pub fn asks(&self, item: usize) -> bool {
        is_asked(&self.instrument, self.instrument.items[item].when.as_ref(), &self.response.answers)
    }

    /// Drops answers to items that no longer apply.
    pub(super) fn drop_unasked(&mut self) {
        let asked: Vec<usize> =
            asked_pages(&self.instrument, &self.response.answers).into_iter().flat_map(|(_, items)| items).collect();
        for (at, answer) in self.response.answers.0.iter_mut().enumerate() {
            if !asked.contains(&at) {
                *answer = None;
            }
        }
    }

    /// Reads the answers of a page from form fields. Returns the rejected ones, by item index.
    pub fn read_page(&mut self, page: usize, given: &GivenAnswers) -> Vec<(usize, Refused)> {
        let pages = self.instrument.pages();
        let Some((_, items)) = pages.get(page) else { return Vec::new() };
        read_answers_to_items(&self.instrument, items, given, &mut self.response.answers)
    }

    /// Saves the answers so far, and with the first of them the consent.
    ///
    /// # Errors
    /// Returns [`Error::Conflict`] if they have been sent already.
    pub async fn save(&mut self, state: &Service) -> Result<(), Error> {
        self.drop_unasked();
        let mut tx = state.db.write().await?;
        self.store(&mut tx, state.clock.now()).await?;
        Ok(tx.commit().await?)
    }

    pub(super) async fn store(&self, writer: &mut Connection, now: Moment) -> Result<(), Error> {
        match surveys::put_answers(writer, &self.response, now).await? {
            true => Ok(()),
            false => Err(Error::Conflict(ANSWERED.to_owned())),
        }
    }

    /// Sends the answers, which makes them final.
    ///
    /// # Errors
    /// Returns [`Error::Conflict`] if they have been sent already.
    pub async fn send(&mut self, state: &Service) -> Result<(), Error> {
        let now = state.clock.now();
        self.drop_unasked();
        let mut tx = state.db.write().await?;
        self.store(&mut tx, now).await?;
        self.submit(&mut tx, now).await?;
        Ok(tx.commit().await?)
    }

    /// Marks the stored answers as sent.
    pub(super) async fn submit(&self, writer: &mut Connection, now: Moment) -> Result<(), Error> {
        let submission = Submission { response: &self.response, identity: self.survey.identity, at: now };
        match surveys::submit(writer, submission).await? {
            true => self.note(writer, "survey.answered", now).await,
            false => Err(Error::Conflict(ANSWERED.to_owned())),
        }
    }

    /// Deletes the draft.
    pub async fn discard(&self, state: &Service) -> Result<(), Error> {
        let mut tx = state.db.write().await?;
        surveys::reset(&mut tx, &self.response).await?;
        Ok(tx.commit().await?)
    }

    /// Withdraws sent answers.
    ///
    /// # Errors
    /// Returns [`Error::Conflict`] if no answers have been sent.
    pub async fn withdraw(&self, state: &Service) -> Result<(), Error> {
        let mut tx = state.db.write().await?;
        if !surveys::withdraw(&mut tx, &self.response).await? {
            return Err(Error::Conflict(tr!("there are no submitted answers to withdraw").to_owned()));
        }
        self.note(&mut tx, "survey.withdrawn", state.clock.now()).await?;
        Ok(tx.commit().await?)
    }

    /// Records an event in the audit log without the respondent, who must stay anonymous to its
    /// readers.
    async fn note(&self, writer: &mut Connection, action: &str, now: Moment) -> Result<(), Error> {
        Ok(AuditEntry::new(self.survey.school_id, Actor::Respondent, action, self.survey.id)
            .append(writer, now)
            .await?)
    }
}

/// Reads the answers to some items, given by index, from form fields into `answers`. Returns the
/// rejected ones, whose previous answers are kept.
pub fn read_answers_to_items(
    instrument: &Instrument,
    items: &[usize],
    given: &GivenAnswers,
    answers: &mut [Option<Answer>],
) -> Vec<(usize, Refused)> {
    let mut refused = Vec::new();
    for &at in items {
        let item = &instrument.items[at];
        let Some(scale) = instrument.scale(item) else { continue };
        match read_answer(item, scale, &given.texts_for(item)) {
            Ok(answer) => answers[at] = answer,
            Err(why) => refused.push((at, why)),
        }
    }
    refused
}

/// What a response is about: a survey, and possibly an attempt.
#[derive(Clone, Copy, Debug)]
pub struct SurveyOccasion<'a> {
    /// The survey.
    pub survey: &'a Survey,
    /// The attempt, if the survey follows one.
    pub session: Option<SessionId>,
    /// Language code.
    pub language: &'a str,
}

/// Begins a response of a person who has consented, or continues their draft. Returns the secret of
/// its URL.
///
/// # Errors
/// Returns [`Error::Conflict`] if they have already answered.
pub async fn begin(state: &Service, person: &CurrentPerson, asked: SurveyOccasion<'_>) -> Result<String, Error> {
    let SurveyOccasion { survey, session, language } = asked;
    let token = secret::random_hex()?;
    let token_sha256 = secret::token_sha256(&token);
    let mut tx = state.db.write().await?;
    if let Some(begun) = surveys::draft_of(&mut *tx, survey.school_id, survey.id, person.id, session).await? {
        surveys::set_token(&mut tx, begun.school_id, begun.id, &token_sha256).await?;
        tx.commit().await?;
        return Ok(token);
    }
    if surveys::answered(&mut *tx, survey, person.id, session).await? {
        return Err(Error::Conflict(ANSWERED.to_owned()));
    }
    let new = NewResponse {
        school_id: survey.school_id,
        survey_id: survey.id,
        token_sha256,
        role: person.role.as_str(),
        label: None,
        person_id: Some(person.id),
        session_id: session,
        language,
        consented_at: Some(state.clock.now()),
        expires_at: None,
    };
    surveys::add(&mut tx, &new).await?;
    tx.commit().await?;
    Ok(token)
}
