//! The school as a station sees it while somebody practises: who sits here, what is due, what is asked, and where attempts go.
//!
//! Nothing here keeps a person waiting: each call to the service has a thread of its own, and the window reads what came of it.

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

/// Who sits at the station.
#[derive(Clone, Debug, Deserialize)]
pub struct SignedIn {
    /// The pseudonym that recordings carry.
    pub trainee: String,
    /// For the screen, never for a recording.
    pub display_name: String,
    /// The code of the language that they have chosen at their school. A service of before does not say.
    #[serde(default)]
    language: Option<String>,
    /// They take part in a study, and do nothing else here. A service of before does not say.
    #[serde(default)]
    pub guest: bool,
    /// What there is to train, what is due first.
    pub exercises: Vec<Listed>,
    /// What the school asks after attempts.
    #[serde(default, deserialize_with = "readable")]
    pub surveys: Vec<Arc<AskedSurvey>>,
}

/// What a guest of a study has to agree to before they practise.
#[derive(Clone, Debug, Deserialize)]
pub struct StudyTerms {
    /// Title of the study.
    pub study: String,
    /// What its participants agree to, as whoever runs it has written it.
    pub consent: String,
    /// Who answers for the data.
    pub controller: String,
    /// Whom to ask.
    pub contact: String,
    /// How long its data are kept after it has ended, in months.
    pub kept_months: u32,
    /// By what the school knows which text it was.
    pub revision: String,
}

/// What the school says to somebody's code.
#[derive(Clone, Debug)]
pub enum DeskReply {
    /// They sit here now.
    SignedIn(SignedIn),
    /// A guest, who has to agree first: nobody is signed in, and the code is as good as before.
    ConsentAsked(StudyTerms),
}

/// A code that somebody has typed.
#[derive(Clone, Debug, Default)]
pub struct CodeEntry {
    /// The code.
    pub code: String,
    /// The revision of what a guest has read and agreed to.
    pub agreed: Option<String>,
}

/// An exercise of the school.
#[derive(Clone, Debug, Deserialize)]
pub struct Listed {
    /// Its identifier.
    pub exercise_id: String,
    /// The trainee may train it now.
    pub due: bool,
    /// The trainee has mastered it. A service of before does not say.
    #[serde(default)]
    pub mastered: bool,
    /// Until when an instructor wants it done, on the school's clock.
    #[serde(default)]
    due_at: Option<String>,
}

impl Listed {
    /// Until when an instructor wants it done, on the school's clock.
    pub fn due_at(&self) -> Option<OffsetDateTime> {
        OffsetDateTime::parse(self.due_at.as_deref()?, &Rfc3339).ok()
    }
}

/// A survey that the school asks after attempts.
#[derive(Debug, Deserialize)]
#[serde(try_from = "ToldSurvey")]
pub struct AskedSurvey {
    /// Its id.
    pub id: Uuid,
    /// Its title.
    pub title: String,
    /// Answers lead to nobody: only the secret finds them again.
    pub anonymous: bool,
    /// By language, paragraph by paragraph: what somebody is told before they agree.
    pub terms: BTreeMap<String, Vec<String>>,
    /// What is asked.
    pub instrument: Instrument,
    /// After which exercises; none: after all.
    exercises: Vec<String>,
    /// A study asks it: here, however long it takes.
    study: bool,
    /// From the how-manieth attempt at those exercises on, counted from the sign-in.
    from_attempt: usize,
}

impl AskedSurvey {
    fn is_after(&self, exercise: &str) -> bool {
        self.exercises.is_empty() || self.exercises.iter().any(|id| id == exercise)
    }
}

/// A survey as the service tells it. One of before knows no studies.
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

/// The surveys that this program can ask. One that is newer than the program is asked on the school's pages only.
fn readable<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Arc<AskedSurvey>>, D::Error> {
    let told = Vec::<serde_json::Value>::deserialize(from)?;
    Ok(told.into_iter().filter_map(|told| serde_json::from_value(told).ok().map(Arc::new)).collect())
}

impl SignedIn {
    /// The language that they have chosen at their school, where the window speaks it.
    pub fn language(&self) -> Option<Language> {
        Language::named(self.language.as_deref()?)
    }

    /// What is asked at the station after the last of the exercises practised since the sign-in: what a study asks, and of the
    /// school's own surveys one of a minute at most. Longer ones wait on the school's pages.
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

/// What has come of a call so far.
#[derive(Clone, Debug)]
pub enum DeskAnswer<T> {
    /// Nothing yet.
    Waiting,
    /// This.
    Came(T),
    /// Nothing, and why, in words for whatever language the window speaks.
    Refused(Phrase),
}

/// A call that is under way.
pub type Call<T> = Arc<Mutex<DeskAnswer<T>>>;

/// What a call has come to.
pub fn read<T: Clone>(call: &Call<T>) -> DeskAnswer<T> {
    call.lock().unwrap_or_else(PoisonError::into_inner).clone()
}

/// Asks in a thread of its own.
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

/// Signs somebody in by the code from their own page, or a guest by that of a study.
pub fn sign_in(pairing: Pairing, entry: CodeEntry) -> Call<DeskReply> {
    ask(move || {
        let address = format!("{}/api/v1/stations/sign-in", pairing.server);
        let token = service::bearer_header(&pairing.token)
            .ok_or_else(|| phrase!("the station's token is spoilt: pair it again"))?;
        let request =
            service::http_agent().post(&address).header("Authorization", token).content_type("application/json");
        let mut asked = json!({ "code": entry.code });
        if let Some(agreed) = entry.agreed {
            asked["consent"] = agreed.into();
        }
        let reply = ask_service(&address, request.send(asked.to_string()))
            .map_err(|trouble| phrase!("the school does not answer: {why}", why = trouble.detail))?;
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

/// Why nobody was signed in. What a service says in words of its own is said as it says it.
fn explain_refusal(reply: &Reply) -> Phrase {
    match reply.status {
        401 => phrase!("the school does not know this station any more: pair it again"),
        403 => phrase!("this is nobody's sign-in code; the page of one's account makes one"),
        429 => phrase!("too many wrong codes were entered here: the station is locked for up to an hour"),
        _ => Phrase::data(reply.words()),
    }
}

/// Keeps a recording in the outbox and sends what is due; says in words what has become of it.
///
/// # Errors
/// When the outbox refuses it: it stays where it is.
pub fn deliver(outbox: &Outbox, recording: &Path, pairing: Pairing) -> Result<Call<Phrase>, Failure> {
    let kept = outbox.keep_own(recording, &pairing.server)?;
    Ok(send(outbox.clone(), kept.id, pairing))
}

/// Keeps answers in the outbox and sends what is due; says in words what has become of them.
///
/// # Errors
/// When the outbox refuses them: they stay as they were saved.
pub fn hand_in(outbox: &Outbox, sheet: &AnswerSheet, pairing: Pairing) -> Result<Call<Phrase>, Failure> {
    let kept = outbox.keep_answers(sheet, &pairing.server)?;
    Ok(send(outbox.clone(), kept.id, pairing))
}

fn send(outbox: Outbox, id: String, pairing: Pairing) -> Call<Phrase> {
    /// The outbox tries again later, so the first try need not be patient.
    const PATIENCE: Patience = Patience { retries: 2, first_wait: Duration::from_secs(1) };
    ask(move || {
        let access = Access::new(None, Some(&pairing));
        let deliveries = outbox.send_due(&access, PATIENCE).map_err(Phrase::data)?;
        match deliveries.iter().find(|delivery| delivery.id == id) {
            Some(delivery) if delivery.delivered => Ok(phrase!("delivered to {school}", school = &pairing.school)),
            Some(delivery) if delivery.is_removed() => Err(phrase!("removed here: {why}", why = &delivery.detail)),
            Some(delivery) => Err(phrase!("waits in the outbox: {why}", why = &delivery.detail)),
            None => Err(phrase!("waits in the outbox")),
        }
    })
}
