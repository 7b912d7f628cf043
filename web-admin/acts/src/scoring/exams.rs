//! Exams at one station: creates and closes them, begins and finishes sittings, and requests the
//! blinded second ratings.

use assessment::questionnaire::Refused;
use documents::Instrument;
use documents::instrument::ScaleKind;
use model::ids::{ExamId, PersonId};
use model::surveys::given::GivenAnswers;
use model::{CurrentPerson, PersonKey, Role, SessionKey};
use serde_json::json;
use store::audit::AuditEntry;
use store::scoring::exams::{Exam, NewExam, Sitting};
use store::scoring::ratings::NewRound;
use store::scoring::{exams, ratings as rounds};
use store::training::reports;

use crate::error::Error;
use crate::scoring::ratings::{list_unanswered, read_all_answers};
use crate::service::Service;
use crate::surveys;

/// Returns whether an instrument suits an exam: it has a score, so that ratings can be compared, and
/// no question is answered in free text, so that a sitting contains no texts to redact.
#[must_use]
pub fn suits_exams(instrument: &Instrument) -> bool {
    let is_text = |scale: &ScaleKind| matches!(scale, ScaleKind::Text { .. });
    !instrument.scores.is_empty() && !instrument.items.iter().filter_map(|item| instrument.scale(item)).any(is_text)
}

/// Creates an exam.
///
/// # Errors
/// Fails if a part does not belong to the school, or the database fails.
pub async fn make(state: &Service, by: &CurrentPerson, new: &NewExam) -> Result<ExamId, Error> {
    let now = state.clock.now();
    let mut tx = state.db.write().await?;
    let id = exams::add_exam(&mut tx, by, new, now).await?;
    let told = json!({ "cohort": new.cohort_id, "exercise": new.exercise_id, "second_rater": new.second_rater_id });
    AuditEntry::by(by, "exam.made", id).with(told).append(&mut tx, now).await?;
    tx.commit().await?;
    Ok(id)
}

/// Returns an exam of a cohort that a person teaches.
///
/// # Errors
/// Returns [`Error::NotFound`] if it does not exist or is not theirs to see.
pub async fn find(state: &Service, by: &CurrentPerson, id: ExamId) -> Result<Exam, Error> {
    exams::find_exam(state.db.reader(), by, id).await?.ok_or(Error::NotFound)
}

/// Returns the name of a candidate, who is a trainee of the cohort or has a sitting, and the sitting.
///
/// # Errors
/// Returns [`Error::NotFound`] if the person is neither.
pub async fn find_candidate(
    state: &Service,
    exam: &Exam,
    person_id: PersonId,
) -> Result<(String, Option<Sitting>), Error> {
    let reader = state.db.reader();
    let key = PersonKey { school_id: exam.school_id, person_id };
    if let Some(sitting) = exams::find_sitting(reader, exam.id, key).await? {
        return Ok((sitting.name.clone(), Some(sitting)));
    }
    let members = reports::members(reader, exam.school_id, exam.cohort_id, Role::Trainee).await?;
    let member = members.into_iter().find(|member| member.id == person_id).ok_or(Error::NotFound)?;
    Ok((member.name, None))
}

/// The second rater does not examine, so that they see no candidate and no first rating.
fn refuse_second_rater(exam: &Exam, by: &CurrentPerson) -> Result<(), Error> {
    match exam.second_rater_id == Some(by.id) {
        true => Err(Error::Forbidden(tr!("the second rater of an exam does not examine in it"))),
        false => Ok(()),
    }
}

/// Begins a candidate's sitting at the service's time, once.
///
/// # Errors
/// Returns [`Error::Conflict`] if the exam is closed or the sitting has begun, [`Error::Forbidden`]
/// for the second rater and for the candidate, [`Error::NotFound`] if the person is no candidate.
pub async fn begin(state: &Service, by: &CurrentPerson, exam: &Exam, candidate: PersonId) -> Result<(), Error> {
    refuse_second_rater(exam, by)?;
    if by.id == candidate || exam.second_rater_id == Some(candidate) {
        return Err(Error::Forbidden(tr!("nobody rates their own sitting")));
    }
    find_candidate(state, exam, candidate).await?;
    let now = state.clock.now();
    let mut tx = state.db.write().await?;
    // Read within the transaction: another examiner may have closed it.
    let exam = exams::find_exam(&mut *tx, by, exam.id).await?.ok_or(Error::NotFound)?;
    if exam.closed_at.is_some() {
        return Err(Error::Conflict(tr!("this exam is closed").to_owned()));
    }
    let begun = exams::add_sitting(&mut tx, &exam, candidate, by.id, now).await?;
    let id = begun.ok_or_else(|| Error::Conflict(tr!("this sitting has already begun").to_owned()))?;
    let told = json!({ "exam": exam.id, "candidate": candidate });
    AuditEntry::by(by, "exam.begun", id).with(told).append(&mut tx, now).await?;
    Ok(tx.commit().await?)
}

/// A sitting whose form its examiner fills in.
#[derive(Clone, Debug)]
pub struct OpenSitting {
    /// The exam.
    pub exam: Exam,
    /// The sitting so far.
    pub sitting: Sitting,
    /// The instrument.
    pub instrument: Instrument,
}

/// Returns the sitting of a candidate for its examiner.
///
/// # Errors
/// Returns [`Error::NotFound`] if it has not begun, [`Error::Forbidden`] for another person than the
/// examiner.
pub async fn open(state: &Service, by: &CurrentPerson, exam: Exam, candidate: PersonId) -> Result<OpenSitting, Error> {
    let (_, sitting) = find_candidate(state, &exam, candidate).await?;
    let mut sitting = sitting.ok_or(Error::NotFound)?;
    if sitting.examiner_id != by.id {
        return Err(Error::Forbidden(tr!("only the examiner who began a sitting fills in its form")));
    }
    let instrument = surveys::revision(state, exam.school_id, exam.revision_id).await?.ok_or(Error::NotFound)?;
    sitting.answers.resize(instrument.items.len(), None);
    Ok(OpenSitting { exam, sitting, instrument })
}

impl OpenSitting {
    /// Reads answers from form fields. Returns the rejected ones, by item index.
    pub fn read(&mut self, given: &GivenAnswers) -> Vec<(usize, Refused)> {
        read_all_answers(&self.instrument, given, &mut self.sitting.answers)
    }

    /// Returns the indices of the items that are neither answered nor explicitly skipped.
    #[must_use]
    pub fn unanswered(&self, given: &GivenAnswers) -> Vec<usize> {
        list_unanswered(&self.instrument, given, &self.sitting.answers)
    }

    fn refuse_change() -> Error {
        Error::Conflict(tr!("this sitting is finished, or the exam is closed; it can no longer be changed").to_owned())
    }

    /// Saves the answers so far.
    ///
    /// # Errors
    /// Returns [`Error::Conflict`] if the sitting is finished or the exam is closed.
    pub async fn save(&self, state: &Service) -> Result<(), Error> {
        let mut tx = state.db.write().await?;
        if !exams::put_answers(&mut tx, self.exam.school_id, &self.sitting, None).await? {
            return Err(Self::refuse_change());
        }
        Ok(tx.commit().await?)
    }

    /// Saves the answers and finishes the sitting, also after its time limit; the time is stored.
    ///
    /// # Errors
    /// Returns [`Error::Conflict`] if the sitting is finished or the exam is closed.
    pub async fn finish(&self, state: &Service, by: &CurrentPerson) -> Result<(), Error> {
        let now = state.clock.now();
        let mut tx = state.db.write().await?;
        if !exams::put_answers(&mut tx, self.exam.school_id, &self.sitting, Some(now)).await? {
            return Err(Self::refuse_change());
        }
        let told = json!({ "exam": self.exam.id, "candidate": self.sitting.person_id });
        AuditEntry::by(by, "exam.finished", self.sitting.id).with(told).append(&mut tx, now).await?;
        Ok(tx.commit().await?)
    }
}

/// Requests second ratings of the attempts that wait for it, in the exam's blinded round. Returns
/// their number.
///
/// # Errors
/// Returns [`Error::Forbidden`] for the second rater, [`Error::Conflict`] if the exam has none.
pub async fn request_second_ratings(state: &Service, by: &CurrentPerson, exam: &Exam) -> Result<usize, Error> {
    refuse_second_rater(exam, by)?;
    let rater = exam.second_rater_id;
    let rater = rater.ok_or_else(|| Error::Conflict(tr!("this exam has no second rater").to_owned()))?;
    let now = state.clock.now();
    let mut tx = state.db.write().await?;
    // Read within the transaction: another examiner may have requested them.
    let exam = exams::find_exam(&mut *tx, by, exam.id).await?.ok_or(Error::NotFound)?;
    let sittings = exams::list_sittings(&mut *tx, exam.school_id, exam.id).await?;
    let waiting = sittings.iter().filter(|sitting| sitting.waits_for_request());
    let sessions: Vec<_> = waiting.filter_map(|sitting| sitting.session_id).collect();
    if sessions.is_empty() {
        return Ok(0);
    }
    let round = match exam.round_id {
        Some(round) => {
            for session in &sessions {
                let key = SessionKey { school_id: exam.school_id, id: *session };
                rounds::add_rating(&mut tx, key, round, rater).await?;
            }
            round
        }
        None => {
            let new = NewRound {
                revision_id: exam.revision_id,
                title: exam.title.clone(),
                generated: false,
                sessions: sessions.clone(),
                raters: vec![rater],
            };
            let round = rounds::add(&mut tx, by, &new, now).await?;
            exams::set_round(&mut tx, &exam, round).await?;
            round
        }
    };
    let told = json!({ "revision": exam.revision_id, "attempts": sessions, "raters": [rater] });
    AuditEntry::by(by, "ratings.asked", round).with(told).append(&mut tx, now).await?;
    tx.commit().await?;
    Ok(sessions.len())
}

/// Closes an exam: no sitting begins or is finished any more, and candidates see their results.
///
/// # Errors
/// Returns [`Error::Forbidden`] for the second rater, [`Error::Conflict`] if it is closed already.
pub async fn close(state: &Service, by: &CurrentPerson, exam: &Exam) -> Result<(), Error> {
    refuse_second_rater(exam, by)?;
    let now = state.clock.now();
    let mut tx = state.db.write().await?;
    if !exams::close_exam(&mut tx, exam, now).await? {
        return Err(Error::Conflict(tr!("this exam is closed").to_owned()));
    }
    AuditEntry::by(by, "exam.closed", exam.id).append(&mut tx, now).await?;
    Ok(tx.commit().await?)
}
