//! Blinded ratings: several raters rate the same attempts without seeing the trainee, the score or
//! each other's ratings. Creates and withdraws rounds, saves and finishes ratings.

use assessment::questionnaire::{Answer, Refused};
use documents::Instrument;
use documents::instrument::ScaleKind;
use model::CurrentPerson;
use model::ids::{RatingId, RoundId};
use model::surveys::given::GivenAnswers;
use serde_json::json;
use store::audit::AuditEntry;
use store::recordings::sessions;
use store::recordings::sessions::Session;
use store::scoring::ratings;
use store::scoring::ratings::{NewRound, Rating, Round};

use crate::error::Error;
use crate::letters::notices;
use crate::letters::notices::News;
use crate::service::Service;
use crate::surveys;
use crate::surveys::answering::read_answers_to_items;

fn finished() -> Error {
    Error::Conflict(tr!("this rating is finished; it can no longer be changed").to_owned())
}

/// Creates a rating round.
///
/// # Errors
/// Fails if an attempt, a rater or the instrument does not belong to the school, or the database
/// fails.
pub async fn make(state: &Service, by: &CurrentPerson, new: &NewRound) -> Result<RoundId, Error> {
    let now = state.clock.now();
    let mut tx = state.db.write().await?;
    let id = ratings::add(&mut tx, by, new, now).await?;
    let told = json!({ "revision": new.revision_id, "attempts": new.sessions, "raters": new.raters });
    AuditEntry::by(by, "ratings.asked", id).with(told).append(&mut tx, state.clock.now()).await?;
    tx.commit().await?;
    Ok(id)
}

/// Withdraws a round.
pub async fn withdraw(state: &Service, by: &CurrentPerson, round: &Round) -> Result<(), Error> {
    let mut tx = state.db.write().await?;
    ratings::withdraw(&mut tx, round, state.clock.now()).await?;
    AuditEntry::by(by, "ratings.withdrawn", round.id).append(&mut tx, state.clock.now()).await?;
    Ok(tx.commit().await?)
}

/// A rating, with the instrument that it uses.
#[derive(Clone, Debug)]
pub struct Rated {
    /// The rating so far.
    pub rating: Rating,
    /// Its round, as the rater sees it.
    pub round: Round,
    /// The instrument.
    pub instrument: Instrument,
}

/// Returns a rating assigned to a person.
///
/// # Errors
/// Returns [`Error::NotFound`] if the rating does not exist or is not assigned to this person.
pub async fn open(state: &Service, rater: &CurrentPerson, id: RatingId) -> Result<Rated, Error> {
    let reader = state.db.reader();
    let mut rating = ratings::rating(reader, rater, id).await?.ok_or(Error::NotFound)?;
    let round = ratings::find(reader, rater, rating.round_id).await?.ok_or(Error::NotFound)?;
    let instrument = surveys::revision(state, round.school_id, round.revision_id).await?.ok_or(Error::NotFound)?;
    rating.answers.resize(instrument.items.len(), None);
    Ok(Rated { rating, round, instrument })
}

/// Returns the attempt that a person is to rate.
///
/// # Errors
/// Returns [`Error::NotFound`] if the rating does not exist or is not assigned to this person.
pub async fn attempt(state: &Service, rater: &CurrentPerson, id: RatingId) -> Result<Session, Error> {
    let rating = ratings::rating(state.db.reader(), rater, id).await?.ok_or(Error::NotFound)?;
    sessions::find_session(state.db.reader(), rating.school_id, rating.session_id).await?.ok_or(Error::NotFound)
}

/// Reads the answers to all items from form fields. Returns the rejected ones, by item index.
pub(super) fn read_all_answers(
    instrument: &Instrument,
    given: &GivenAnswers,
    answers: &mut [Option<Answer>],
) -> Vec<(usize, Refused)> {
    let all: Vec<usize> = (0..instrument.items.len()).collect();
    read_answers_to_items(instrument, &all, given, answers)
}

/// Returns the indices of the items that are neither answered nor explicitly skipped, so that no
/// rating is finished by oversight. Texts may stay empty.
pub(super) fn list_unanswered(instrument: &Instrument, given: &GivenAnswers, answers: &[Option<Answer>]) -> Vec<usize> {
    let items = instrument.items.iter().enumerate();
    items
        .filter(|(at, item)| {
            let is_text = matches!(instrument.scale(item), Some(ScaleKind::Text { .. }) | None);
            answers[*at].is_none() && !is_text && !given.is_left_out(item)
        })
        .map(|(at, _)| at)
        .collect()
}

impl Rated {
    /// Reads answers from form fields. Returns the rejected ones, by item index.
    pub fn read(&mut self, given: &GivenAnswers) -> Vec<(usize, Refused)> {
        read_all_answers(&self.instrument, given, &mut self.rating.answers)
    }

    /// Returns the indices of the items that are neither answered nor explicitly skipped.
    #[must_use]
    pub fn unanswered(&self, given: &GivenAnswers) -> Vec<usize> {
        list_unanswered(&self.instrument, given, &self.rating.answers)
    }

    /// Saves the answers so far.
    ///
    /// # Errors
    /// Returns [`Error::Conflict`] if the rating is already finished.
    pub async fn save(&self, state: &Service) -> Result<(), Error> {
        let mut tx = state.db.write().await?;
        if !ratings::put(&mut tx, &self.rating, None).await? {
            return Err(finished());
        }
        Ok(tx.commit().await?)
    }

    /// Saves the answers and finishes the rating.
    ///
    /// # Errors
    /// Returns [`Error::Conflict`] if the rating is already finished.
    pub async fn finish(&self, state: &Service, rater: &CurrentPerson) -> Result<(), Error> {
        let mut tx = state.db.write().await?;
        if !ratings::put(&mut tx, &self.rating, Some(state.clock.now())).await? {
            return Err(finished());
        }
        // Names the rating, not the attempt: raters can export their own entries and must stay
        // blinded.
        let told = json!({ "round": self.rating.round_id });
        AuditEntry::by(rater, "rating.finished", self.rating.id).with(told).append(&mut tx, state.clock.now()).await?;
        notices::tell(&mut tx, rater, News::Rated(self.rating.round_id), state.clock.now()).await?;
        Ok(tx.commit().await?)
    }
}
