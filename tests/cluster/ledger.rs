//! What clients were told: every act that was acknowledged, and how often they had to ask.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::client::Outcome;

/// Something that was to be done once.
#[derive(Clone, Debug)]
pub struct Entry {
    /// What tells it from all others: a hash, an address, a sentence.
    pub mark: String,
    /// The session that it is about; empty where it is about none.
    pub session: String,
    /// Whose it is.
    pub token: String,
    /// Whether it was acknowledged.
    pub acknowledged: bool,
    /// How often it was sent that may have been done unheard.
    pub unheard: u64,
}

/// Kinds of entries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Act {
    /// A recording, sent whole.
    Upload,
    /// A recording, sent in pieces.
    UploadInPieces,
    /// A comment.
    Comment,
    /// A score by the rubric of today.
    Regrade,
    /// A person added, who is mailed an invitation.
    Person,
}

/// How requests of a kind went.
#[derive(Clone, Debug, Default)]
pub struct RequestTally {
    /// How many ended in an answer, by the tries that came before it.
    pub by_retries: BTreeMap<u32, usize>,
    /// Answers by status, with the longest wait for one, in s; 0: no service took the connection; 1: it broke.
    pub by_status: BTreeMap<u16, StatusTally>,
    /// How many were told to come again, and not when.
    pub without_time: usize,
    /// The latest that did not go well, in words.
    pub latest: String,
}

/// Answers of one status.
#[derive(Clone, Copy, Debug, Default)]
pub struct StatusTally {
    /// How many.
    pub count: usize,
    /// The longest wait for one, in s.
    pub longest_s: f64,
}

/// In place of a status where no service took the connection.
pub const REFUSED: u16 = 0;
/// In place of a status where the connection broke.
pub const BROKEN: u16 = 1;

#[derive(Debug, Default)]
struct Pages {
    entries: BTreeMap<Act, Vec<Entry>>,
    tallies: BTreeMap<&'static str, RequestTally>,
}

/// The ledger of all clients.
#[derive(Debug, Default)]
pub struct Ledger(Mutex<Pages>);

impl Ledger {
    fn open(&self) -> MutexGuard<'_, Pages> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Enters what is about to be done, or what has become of it since.
    pub fn note(&self, act: Act, entry: &Entry) {
        let mut pages = self.open();
        let entries = pages.entries.entry(act).or_default();
        match entries.iter_mut().find(|known| known.mark == entry.mark) {
            Some(known) => known.clone_from(entry),
            None => entries.push(entry.clone()),
        }
    }

    /// Everything of a kind.
    pub fn entries(&self, act: Act) -> Vec<Entry> {
        self.open().entries.get(&act).cloned().unwrap_or_default()
    }

    /// How requests went, by what was asked.
    pub fn tallies(&self) -> BTreeMap<&'static str, RequestTally> {
        self.open().tallies.clone()
    }

    /// Forgets how requests went so far; how they did.
    pub fn turn_page(&self) -> BTreeMap<&'static str, RequestTally> {
        std::mem::take(&mut self.open().tallies)
    }

    pub(crate) fn note_retries(&self, what: &'static str, retries: u32) {
        *self.open().tallies.entry(what).or_default().by_retries.entry(retries).or_default() += 1;
    }

    pub(crate) fn note_outcome(&self, what: &'static str, outcome: &Outcome) {
        let (status, seconds, words) = match outcome {
            Outcome::Answered(answer) => (answer.status, answer.seconds, answer.text()),
            Outcome::Refused => (REFUSED, 0.0, "no service took the connection".to_owned()),
            Outcome::Broken { why, seconds } => (BROKEN, *seconds, why.clone()),
        };
        let mut pages = self.open();
        let tally = pages.tallies.entry(what).or_default();
        let of_status = tally.by_status.entry(status).or_default();
        of_status.count += 1;
        let is_told = matches!(outcome, Outcome::Answered(answer) if answer.status != 503 || !answer.header("retry-after").is_empty());
        of_status.longest_s = of_status.longest_s.max(seconds);
        tally.without_time += usize::from(status == 503 && !is_told);
        if !matches!(status, 200..400) {
            tally.latest = format!("{status}: {}", words.chars().take(600).collect::<String>());
        }
    }

    /// The latest that did not go well, in words.
    pub fn latest(&self, what: &str) -> String {
        self.open().tallies.get(what).map(|tally| tally.latest.clone()).unwrap_or_default()
    }
}
