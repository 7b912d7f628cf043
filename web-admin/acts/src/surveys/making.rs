//! Making a survey, its links, and closing it.

use model::ids::{CohortId, RevisionId, SchoolId, SurveyId};
use model::limits::LETTERS_AN_HOUR;
use model::survey::{Identity, PROFESSIONAL, Survey};
use model::{CurrentPerson, Moment};
use serde_json::json;
use store::audit::AuditEntry;
use store::surveys::{NewResponse, NewSurvey, letters};
use store::{Executor, surveys};

use crate::error::Error;
use crate::secret;
use crate::service::Service;

/// How long a link is good where the survey does not close before, in s.
pub const LINK_LIFETIME_S: i64 = 60 * 24 * 3600;

/// A survey as somebody wants it.
#[derive(Clone, Debug)]
pub struct SurveyRequest {
    /// The revision that it asks.
    pub revision_id: RevisionId,
    /// Title.
    pub title: String,
    /// Whether answers lead to who gave them.
    pub identity: Identity,
    /// Asked after each attempt.
    pub after_attempts: bool,
    /// For how many hours after it; none: as long as the survey is open.
    pub fresh_hours: Option<u32>,
    /// The answers are made by a program.
    pub generated: bool,
    /// From when on.
    pub opens_at: Moment,
    /// Until when.
    pub closes_at: Option<Moment>,
    /// For whom.
    pub cohorts: Vec<CohortId>,
}

/// Makes a survey that belongs to a person.
pub async fn make(state: &Service, person: &CurrentPerson, wanted: &SurveyRequest) -> Result<SurveyId, Error> {
    let now = state.clock.now();
    let new = NewSurvey {
        school_id: person.school_id,
        revision_id: wanted.revision_id,
        title: &wanted.title,
        owner_id: Some(person.id),
        identity: wanted.identity,
        after_attempts: wanted.after_attempts,
        fresh_hours: wanted.fresh_hours.filter(|_| wanted.after_attempts),
        study: None,
        generated: wanted.generated,
        opens_at: wanted.opens_at,
        closes_at: wanted.closes_at,
    };
    let mut tx = state.db.write().await?;
    let id = surveys::insert(&mut tx, &new, now).await?;
    for cohort in &wanted.cohorts {
        surveys::add_cohort(&mut tx, person.school_id, id, *cohort).await?;
    }
    let details = json!({ "revision": wanted.revision_id, "identity": wanted.identity, "cohorts": wanted.cohorts });
    AuditEntry::by(person, "survey.made", id).with(details).append(&mut tx, now).await?;
    tx.commit().await?;
    Ok(id)
}

/// A link that was made: shown once, for only its hash is kept.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SurveyLink {
    /// Whom it is for.
    pub label: String,
    /// The secret in its address.
    pub token: String,
}

/// Until when a link that is made now is good.
#[must_use]
pub fn link_expiry(survey: &Survey, now: Moment) -> Moment {
    let latest = now.plus_s(LINK_LIFETIME_S);
    survey.closes_at.map_or(latest, |closes| closes.min(latest))
}

/// How many letters with links a school may still send now.
pub async fn letters_left(executor: impl Executor<'_>, school: SchoolId, now: Moment) -> Result<usize, Error> {
    let queued = letters::queued_since(executor, school, now.plus_s(-3600)).await?;
    Ok(LETTERS_AN_HOUR.saturating_sub(queued as usize))
}

/// Queues a letter with a link to each name and address. Returns how many were queued: nobody is written to twice.
///
/// # Errors
/// When they are more than the school may send within the hour, or the database fails.
pub async fn mail_links(
    state: &Service,
    person: &CurrentPerson,
    survey: &Survey,
    addresses: &[(String, String)],
) -> Result<usize, Error> {
    let now = state.clock.now();
    let mut queued = 0;
    let mut tx = state.db.write().await?;
    let left = letters_left(&mut *tx, survey.school_id, now).await?;
    if addresses.len() > left {
        return Err(Error::Unprocessable(tr!(
            "{count} letters; {left} can go out now, at most {most} an hour from one school",
            count = addresses.len(),
            left = left,
            most = LETTERS_AN_HOUR
        )));
    }
    for (name, email) in addresses {
        queued += usize::from(letters::queue_survey_letter(&mut tx, survey, name, email, now).await?);
    }
    let details = json!({ "letters": queued });
    AuditEntry::by(person, "survey.letters_queued", survey.id).with(details).append(&mut tx, now).await?;
    tx.commit().await?;
    state.mails.notify_one();
    Ok(queued)
}

/// Makes a link for each label.
///
/// # Errors
/// When the random source or the database fails.
pub async fn make_links(
    state: &Service,
    person: &CurrentPerson,
    survey: &Survey,
    labels: &[String],
) -> Result<Vec<SurveyLink>, Error> {
    let now = state.clock.now();
    let expires_at = link_expiry(survey, now);
    let mut links = Vec::new();
    let mut tx = state.db.write().await?;
    for label in labels {
        let token = secret::random_hex()?;
        let new = NewResponse {
            school_id: survey.school_id,
            survey_id: survey.id,
            token_sha256: secret::token_sha256(&token),
            role: PROFESSIONAL,
            label: Some(label),
            person_id: None,
            session_id: None,
            language: "en",
            consented_at: None,
            expires_at: Some(expires_at),
        };
        surveys::add(&mut tx, &new).await?;
        links.push(SurveyLink { label: label.clone(), token });
    }
    AuditEntry::by(person, "survey.links_made", survey.id)
        .with(json!({ "links": labels.len() }))
        .append(&mut tx, now)
        .await?;
    tx.commit().await?;
    Ok(links)
}

/// Closes a survey now, or opens a closed one again.
pub async fn close(state: &Service, person: &CurrentPerson, survey: &Survey, closed: bool) -> Result<(), Error> {
    let now = state.clock.now();
    let mut tx = state.db.write().await?;
    surveys::close(&mut tx, survey.school_id, survey.id, closed.then_some(now)).await?;
    let action = if closed { "survey.closed" } else { "survey.opened" };
    AuditEntry::by(person, action, survey.id).append(&mut tx, now).await?;
    Ok(tx.commit().await?)
}
