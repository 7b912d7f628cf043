//! What drafts of exercises come to, computed where it harms nobody: in the process that judges, within a budget, ended when nobody waits
//! any more, in a line of its own for each school. What is known is told again at once.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use uuid::Uuid;

use crate::error::Error;
use crate::judging::{self, Answer, DraftQuestion, Question};
use crate::lines::{Lines, Place};
use crate::service::Service;
use model::draft::Verdict;

/// Longest wait for one's turn.
const PATIENCE: Duration = Duration::from_secs(5);
/// Most answers that are kept.
const MOST: usize = 64;

/// The lines, and what is known.
#[derive(Debug)]
pub struct Previews {
    lines: Lines,
    known: Mutex<BTreeMap<[u8; 32], Verdict>>,
}

impl Default for Previews {
    /// As many at once as there are cores, two at least: one school's must leave room for another's.
    fn default() -> Self {
        let cores = thread::available_parallelism().map_or(1, Into::into);
        Self { lines: Lines::new(cores.max(2), 1), known: Mutex::default() }
    }
}

impl Previews {
    /// A place to look what a draft comes to, of the few that a school has.
    ///
    /// # Errors
    /// [`Error::Busy`] when the school's turn does not come in time.
    pub async fn enter(&self, school: Uuid) -> Result<Place, Error> {
        let place = self.lines.enter(school, PATIENCE).await;
        place.ok_or(Error::Busy { retry_after_s: PATIENCE.as_secs() })
    }

    fn told(&self, key: &[u8; 32]) -> Option<Verdict> {
        self.known().get(key).cloned()
    }

    fn keep(&self, key: [u8; 32], verdict: &Verdict) {
        let mut known = self.known();
        if known.len() >= MOST {
            known.clear();
        }
        known.insert(key, verdict.clone());
    }

    /// Whoever panicked has left nothing half-written here.
    fn known(&self) -> MutexGuard<'_, BTreeMap<[u8; 32], Verdict>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What a draft of an exercise comes to. Dropped, the work on it ends.
///
/// # Errors
/// [`Error::Busy`] when its school's turn does not come in time; else when nobody can be asked.
pub async fn examine(state: &Service, school: Uuid, question: DraftQuestion) -> Result<Verdict, Error> {
    let (previews, key) = (&state.previews, question.sha256());
    if let Some(told) = previews.told(&key) {
        return Ok(told);
    }
    let _place = previews.enter(school).await?;
    // Whoever was before may have asked the same.
    if let Some(told) = previews.told(&key) {
        return Ok(told);
    }
    match judging::ask(state, Question::Draft(Box::new(question))).await? {
        Answer::Examined(verdict) => {
            previews.keep(key, &verdict);
            Ok(*verdict)
        }
        Answer::Died(how) => {
            tracing::warn!(%school, how, "a draft costs more than a preview may");
            Ok(too_costly(state))
        }
        other => Err(anyhow::anyhow!("a draft was to be looked at, and this came: {other:?}").into()),
    }
}

/// What is said of a draft that costs more than it may.
fn too_costly(state: &Service) -> Verdict {
    let budget_s = state.config.preview_time.as_secs();
    let memory_mb = state.config.helper.as_ref().map_or(0, |helper| helper.memory_mb);
    let what = tr!(
        "to find out what it comes to takes more than {seconds} s or {memory} MB; allowed: what takes less. A larger \
         tissue.tolerance, fewer layers and a shorter time limit cost less",
        seconds = budget_s,
        memory = memory_mb
    );
    Verdict { problems: vec![(tr!("Too costly").to_owned(), what)], ..Verdict::default() }
}
