//! Generates schools: the people of the demonstration, a crowd for measuring page times, and survey
//! responses.

use std::ops::Range;

use anyhow::Context;
use assessment::questionnaire::Answer;
use documents::Instrument;
use model::ids::{SchoolId, SurveyId};
use model::surveys::{Identity, ResponseState};
use model::{Moment, Role};
use platform::secret;
use serde_json::json;
use store::audit::{Actor, AuditEntry};
use store::operations::fixtures::GeneratedCrowd;
use store::operations::{fixtures, schools};
use store::people::directory::Details;
use store::people::{self, NewPerson, Person, directory};
use store::surveys::{NewResponse, NewSurvey, Submission, SurveyResponse, instruments};
use store::training::cohorts;
use store::training::cohorts::{Attribution, Membership};
use store::{Connection, Json, surveys as stored};

use crate::authoring::instruments::publish_text;
use crate::authoring::publishing::DocumentPublisher;
use crate::service::Service;

/// A person of a generated school.
#[derive(Clone, Debug)]
pub struct GeneratedPerson {
    /// Name.
    pub name: &'static str,
    /// Email address.
    pub email: String,
    /// Role.
    pub role: Role,
    /// Name of their cohort.
    pub cohort: Option<&'static str>,
    /// Id in the registrar's system.
    pub registrar_id: Option<String>,
}

/// Creates a school with its people in one transaction and returns the people in order. The
/// password is a regular one, not an initial one that must be changed.
///
/// # Errors
/// Fails if an address is in use, or the database fails.
pub async fn found_school(
    service: &Service,
    name: &str,
    people: &[GeneratedPerson],
    password: &str,
) -> anyhow::Result<Vec<Person>> {
    let hash = secret::hash_password(password, service.config.password_cost)?;
    let (now, mut tx) = (service.clock.now(), service.db.write().await?);
    let school_id = schools::find_or_create(&mut tx, name, now).await?.id;
    let mut founded = Vec::new();
    for person in people {
        founded.push(add_generated(&mut tx, school_id, person, &hash, now).await?);
    }
    tx.commit().await?;
    Ok(founded)
}

async fn add_generated(
    tx: &mut Connection,
    school_id: SchoolId,
    who: &GeneratedPerson,
    password_hash: &str,
    now: Moment,
) -> anyhow::Result<Person> {
    let new = NewPerson { school_id, role: who.role, email: &who.email, display_name: who.name, password_hash };
    let person = people::add_person(tx, &new, now).await?;
    if who.registrar_id.is_some() {
        let details = Details { name: who.name, email: &who.email, registrar_id: who.registrar_id.as_deref() };
        directory::change_details(tx, school_id, person.id, details).await?;
    }
    let entry = AuditEntry::new(school_id, Actor::CommandLine, "person.added", person.id);
    entry.with(json!({ "role": who.role })).append(tx, now).await?;
    if let Some(cohort) = who.cohort {
        let cohort_id = cohorts::find_or_create(tx, school_id, cohort, now).await?.id;
        let membership = Membership { school_id, cohort_id, person_id: person.id, role: who.role };
        cohorts::join_cohort(tx, membership, Attribution { by: None, at: now }).await?;
    }
    Ok(person)
}

/// Adds the people of a crowd.
pub async fn found_crowd(service: &Service, crowd: &GeneratedCrowd<'_>) -> anyhow::Result<()> {
    let mut tx = service.db.write().await?;
    fixtures::found(&mut tx, crowd).await?;
    Ok(tx.commit().await?)
}

/// Adds the attempts of some trainees of a crowd, and ten audit entries for each.
pub async fn practise_crowd(service: &Service, crowd: &GeneratedCrowd<'_>, trainees: Range<u32>) -> anyhow::Result<()> {
    const ENTRIES_EACH: u32 = 10;
    let (now, mut tx) = (service.clock.now(), service.db.write().await?);
    fixtures::practise(&mut tx, crowd, trainees.clone()).await?;
    for place in trainees.flat_map(|place| [place; ENTRIES_EACH as usize]) {
        AuditEntry::new(crowd.school_id, Actor::CommandLine, "session.generated", format!("generated-{place}"))
            .with(json!({ "attempts": crowd.attempts_each / ENTRIES_EACH }))
            .append(&mut tx, now)
            .await?;
    }
    Ok(tx.commit().await?)
}

/// Updates the database's aggregates for a crowd's attempts.
pub async fn conclude_crowd(service: &Service, crowd: &GeneratedCrowd<'_>) -> anyhow::Result<()> {
    let mut tx = service.db.write().await?;
    fixtures::conclude(&mut tx, crowd).await?;
    Ok(tx.commit().await?)
}

/// A survey with generated responses.
#[derive(Clone, Copy, Debug)]
pub struct GeneratedSurvey<'a> {
    /// Owner.
    pub owner: &'a Person,
    /// Title.
    pub title: &'a str,
    /// Document of its instrument.
    pub document: &'a str,
    /// Number of responses.
    pub responses: usize,
}

/// Adds a survey with responses, each item answered by a number from 1 to 5.
///
/// # Errors
/// Fails if the document is invalid, or the database fails.
pub async fn ask_nobody(service: &Service, survey: GeneratedSurvey<'_>) -> anyhow::Result<()> {
    let GeneratedSurvey { owner, title, document, responses } = survey;
    let (now, school_id, mut tx) = (service.clock.now(), owner.school_id, service.db.write().await?);
    let instrument = Instrument::from_bytes("generated", document.as_bytes())?;
    let publisher = DocumentPublisher { school: school_id, by: Actor::CommandLine, now };
    publish_text(&mut tx, &publisher, &instrument, document.as_bytes()).await?;
    let revision = instruments::find_current_instrument(&mut *tx, school_id, &instrument.id).await?;
    let new = NewSurvey {
        school_id,
        revision_id: revision.context("what was just published")?.id,
        title,
        owner_id: Some(owner.id),
        identity: Identity::Anonymous,
        after_attempts: false,
        fresh_hours: None,
        study: None,
        generated: true,
        opens_at: now,
        closes_at: None,
    };
    let asked = AskedSurvey { school_id, survey_id: stored::insert(&mut tx, &new, now).await?, now };
    for place in 0..responses {
        answer(&mut tx, asked, place, instrument.items.len()).await?;
    }
    Ok(tx.commit().await?)
}

/// The survey that is answered, and the time.
#[derive(Clone, Copy)]
struct AskedSurvey {
    school_id: SchoolId,
    survey_id: SurveyId,
    now: Moment,
}

async fn answer(tx: &mut Connection, asked: AskedSurvey, place: usize, items: usize) -> anyhow::Result<()> {
    let AskedSurvey { school_id, survey_id, now } = asked;
    let new = NewResponse {
        school_id,
        survey_id,
        token_sha256: secret::token_sha256(&format!("generated {place}")),
        role: if place.is_multiple_of(2) { "professional" } else { "trainee" },
        label: None,
        person_id: None,
        session_id: None,
        language: "en",
        consented_at: Some(now),
        expires_at: None,
    };
    let point = |item: usize| Some(Answer::Number(((place * 7 + item * place) % 5 + 1) as f64));
    let response = SurveyResponse {
        id: stored::add(tx, &new).await?,
        school_id,
        survey_id,
        state: ResponseState::Begun,
        person_id: None,
        session_id: None,
        language: "en".to_owned(),
        answers: Json((0..items).map(point).collect()),
        expires_at: None,
    };
    stored::put_answers(tx, &response, now).await?;
    stored::submit(tx, Submission { response: &response, identity: Identity::Anonymous, at: now }).await?;
    Ok(())
}
