//! The station's session with the school: the signed-in user, due exercises, surveys, and delivery
//! of attempts.
//!
//! No call blocks the window: each runs in its own thread, and the window polls its result.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use documents::{DocumentError, Instrument};
use phrase::{Phrase, phrase};
use serde::{Deserialize, Deserializer};
use serde_json::json;
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;
use uuid::Uuid;
use words::Language;

use crate::exit::Failure;
use crate::outbox::{Access, AnswerSheet, Outbox, Patience};
use crate::service::{self, Reply, ask_service};
use crate::station::Pairing;

/// The signed-in user, as returned by the service.
#[derive(Clone, Debug, Deserialize)]
pub struct SignedIn {
    /// Pseudonym stored in recordings.
    pub trainee: String,
    /// Name for the screen, never stored in a recording.
    pub display_name: String,
    /// Code of the language that the user has chosen at their school. Older services omit it.
    #[serde(default)]
    language: Option<String>,
    /// Whether the user is a guest, who takes part in a study and cannot use the station for
    /// anything else. Older services omit it.
    #[serde(default)]
    pub guest: bool,
    /// The exercises to train, due ones first.
    pub exercises: Vec<Listed>,
    /// The school's surveys after attempts.
    #[serde(default, deserialize_with = "readable")]
    pub surveys: Vec<Arc<AskedSurvey>>,
}

/// The terms of a study that a guest must agree to before practising.
#[derive(Clone, Debug, Deserialize)]
pub struct StudyTerms {
    /// Title of the study.
    pub study: String,
    /// The consent text, as written by the study's investigators.
    pub consent: String,
    /// The controller of the data.
    pub controller: String,
    /// Contact for questions.
    pub contact: String,
    /// Retention of the data after the end of the study, in months.
    pub kept_months: u32,
    /// Revision of the consent text, sent back with the consent.
    pub revision: String,
}

/// The service's response to a sign-in code.
#[derive(Clone, Debug)]
pub enum DeskReply {
    /// The user is signed in.
    SignedIn(SignedIn),
    /// The code belongs to a guest, who must agree first: no user is signed in, and the code
    /// remains valid.
    ConsentAsked(StudyTerms),
}

/// A sign-in code as entered.
#[derive(Clone, Debug, Default)]
pub struct CodeEntry {
    /// The code.
    pub code: String,
    /// Revision of the consent text that a guest has agreed to.
    pub agreed: Option<String>,
}

/// An exercise in the school's list.
#[derive(Clone, Debug, Deserialize)]
pub struct Listed {
    /// Its identifier.
    pub exercise_id: String,
    /// Whether the trainee may train it now.
    pub due: bool,
    /// Whether the trainee has mastered it. Older services omit it.
    #[serde(default)]
    pub mastered: bool,
    /// Deadline set by an instructor, in RFC 3339 with the school's UTC offset.
    #[serde(default)]
    due_at: Option<String>,
}

impl Listed {
    /// Returns the deadline set by an instructor, in the school's time zone.
    pub fn due_at(&self) -> Option<OffsetDateTime> {
        OffsetDateTime::parse(self.due_at.as_deref()?, &Rfc3339).ok()
    }
}

/// A survey of the school after attempts.
#[derive(Debug, Deserialize)]
#[serde(try_from = "ToldSurvey")]
pub struct AskedSurvey {
    /// Its id.
    pub id: Uuid,
    /// Its title.
    pub title: String,
    /// Whether answers are stored without identity: only the secret finds them again.
    pub anonymous: bool,
    /// Information shown before the consent: paragraphs by language code.
    pub terms: BTreeMap<String, Vec<String>>,
    /// The questions.
    pub instrument: Instrument,
    /// Ids of the exercises after which it is shown; empty for all.
    exercises: Vec<String>,
    /// Whether it belongs to a study: it is then shown at the station regardless of its duration.
    study: bool,
    /// Number of attempts at those exercises since the sign-in from which on a study's survey is
    /// shown.
    from_attempt: usize,
}

impl AskedSurvey {
    fn is_after(&self, exercise: &str) -> bool {
        self.exercises.is_empty() || self.exercises.iter().any(|id| id == exercise)
    }
}

/// A survey as the service returns it. Older services have no studies.
#[derive(Deserialize)]
struct ToldSurvey {
    survey_id: Uuid,
    title: String,
    identity: String,
    terms: BTreeMap<String, Vec<String>>,
    instrument_toml: String,
    exercises: Vec<String>,
    #[serde(default)]
    study: bool,
    #[serde(default)]
    from_attempt: usize,
}

impl TryFrom<ToldSurvey> for AskedSurvey {
    type Error = DocumentError;

    fn try_from(told: ToldSurvey) -> Result<Self, DocumentError> {
        let instrument = Instrument::from_bytes("survey", told.instrument_toml.as_bytes())?;
        let anonymous = told.identity == "anonymous";
        let ToldSurvey { survey_id: id, title, terms, exercises, study, from_attempt, .. } = told;
        Ok(Self { id, title, anonymous, terms, instrument, exercises, study, from_attempt })
    }
}

/// Deserializes the surveys that this version supports. Newer ones are skipped: they are shown on
/// the school's pages only.
fn readable<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Arc<AskedSurvey>>, D::Error> {
    let told = Vec::<serde_json::Value>::deserialize(from)?;
    Ok(told.into_iter().filter_map(|told| serde_json::from_value(told).ok().map(Arc::new)).collect())
}

impl SignedIn {
    /// Returns the language that the user has chosen at their school, if the window supports it.
    pub fn language(&self) -> Option<Language> {
        Language::named(self.language.as_deref()?)
    }

    /// Returns the surveys to show at the station after the last of the exercises practised since
    /// the sign-in: every due survey of a study, and at most one of the school's own, of at most
    /// one minute. Longer ones are shown on the school's pages.
    pub fn asked_after(&self, practised: &[String]) -> Vec<Arc<AskedSurvey>> {
        const LONGEST_MIN: f64 = 1.0;
        let Some(last) = practised.last() else { return Vec::new() };
        let after = || self.surveys.iter().filter(|asked| asked.is_after(last));
        let due = |asked: &&Arc<AskedSurvey>| {
            asked.study && practised.iter().filter(|id| asked.is_after(id)).count() >= asked.from_attempt
        };
        let short = |asked: &&Arc<AskedSurvey>| !asked.study && asked.instrument.duration_min <= LONGEST_MIN;
        after().filter(due).chain(after().find(short)).cloned().collect()
    }
}

/// State of a call.
#[derive(Clone, Debug)]
pub enum DeskAnswer<T> {
    /// No response yet.
    Waiting,
    /// The response.
    Came(T),
    /// The reason for the failure, translatable.
    Refused(Phrase),
}

/// A call in progress.
pub type Call<T> = Arc<Mutex<DeskAnswer<T>>>;

/// Returns the current state of a call.
pub fn read<T: Clone>(call: &Call<T>) -> DeskAnswer<T> {
    call.lock().unwrap_or_else(PoisonError::into_inner).clone()
}

/// Runs a call in its own thread.
fn ask<T: Send + 'static>(work: impl FnOnce() -> Result<T, Phrase> + Send + 'static) -> Call<T> {
    let call = Arc::new(Mutex::new(DeskAnswer::Waiting));
    let theirs = Arc::clone(&call);
    let started = thread::Builder::new().name("desk".to_owned()).spawn(move || {
        let answer = work().map_or_else(DeskAnswer::Refused, DeskAnswer::Came);
        *theirs.lock().unwrap_or_else(PoisonError::into_inner) = answer;
    });
    if let Err(error) = started {
        *call.lock().unwrap_or_else(PoisonError::into_inner) = DeskAnswer::Refused(Phrase::data(error));
    }
    call
}

/// Signs a trainee in with the code from their own page, or a guest with the code of a study.
pub fn sign_in(pairing: Pairing, entry: CodeEntry) -> Call<DeskReply> {
    ask(move || {
        let address = format!("{}/api/v1/stations/sign-in", pairing.server);
        let token = service::bearer_header(&pairing.token)
            .ok_or_else(|| phrase!("the station's token is damaged: pair the station again"))?;
        let request =
            service::http_agent().post(&address).header("Authorization", token).content_type("application/json");
        let mut asked = json!({ "code": entry.code });
        if let Some(agreed) = entry.agreed {
            asked["consent"] = agreed.into();
        }
        let reply = ask_service(&address, request.send(asked.to_string()))
            .map_err(|trouble| phrase!("the school's service is not responding: {why}", why = trouble.detail))?;
        read_desk_reply(&reply).ok_or_else(|| explain_refusal(&reply))
    })
}

fn read_desk_reply(reply: &Reply) -> Option<DeskReply> {
    let said = reply.json()?;
    match reply.status {
        200 => serde_json::from_value(said).ok().map(DeskReply::SignedIn),
        202 => serde_json::from_value(said).ok().map(DeskReply::ConsentAsked),
        _ => None,
    }
}

/// Explains why the sign-in failed. For other statuses this is the service's own explanation.
fn explain_refusal(reply: &Reply) -> Phrase {
    match reply.status {
        401 => phrase!("the school no longer recognises this station: pair it again"),
        403 => phrase!("unknown sign-in code; create a new one on your account page"),
        429 => phrase!("too many wrong codes: this station is locked for up to an hour"),
        _ => Phrase::data(reply.words()),
    }
}

/// Adds a recording to the outbox and starts sending all due entries; the call returns the result
/// for this recording.
///
/// # Errors
/// If the outbox cannot store it; the recording stays where it is.
pub fn deliver(outbox: &Outbox, recording: &Path, pairing: Pairing) -> Result<Call<Phrase>, Failure> {
    let kept = outbox.keep_own(recording, &pairing.server)?;
    Ok(send(outbox.clone(), kept.id, pairing))
}

/// Adds answers to the outbox and starts sending all due entries; the call returns the result for
/// these answers.
///
/// # Errors
/// If the outbox cannot store them; the last saved draft is kept.
pub fn hand_in(outbox: &Outbox, sheet: &AnswerSheet, pairing: Pairing) -> Result<Call<Phrase>, Failure> {
    let kept = outbox.keep_answers(sheet, &pairing.server)?;
    Ok(send(outbox.clone(), kept.id, pairing))
}

fn send(outbox: Outbox, id: String, pairing: Pairing) -> Call<Phrase> {
    /// Few retries, since the outbox tries again later.
    const PATIENCE: Patience = Patience { retries: 2, first_wait: Duration::from_secs(1) };
    ask(move || {
        let access = Access::new(None, Some(&pairing));
        let deliveries = outbox.send_due(&access, PATIENCE).map_err(Phrase::data)?;
        match deliveries.iter().find(|delivery| delivery.id == id) {
            Some(delivery) if delivery.delivered => Ok(phrase!("delivered to {school}", school = &pairing.school)),
            Some(delivery) if delivery.is_removed() => {
                Err(phrase!("deleted from this station: {why}", why = &delivery.detail))
            }
            Some(delivery) => Err(phrase!("waiting in the outbox: {why}", why = &delivery.detail)),
            None => Err(phrase!("waiting in the outbox")),
        }
    })
}
