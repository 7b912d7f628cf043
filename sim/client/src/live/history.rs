//! Earlier attempts at this station: its recordings, judged one after the other in a background
//! thread.
//!
//! Without a school a trainee sees the same progress as a school would show: attempts are judged
//! the same way, void ones are not counted, and mastery follows the same rule.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use assessment::Assessment;
use recording::{Recording, Session};
use time::OffsetDateTime;
use uuid::Uuid;

/// Maximum number of recordings read, the latest ones: a folder may hold years.
const MOST: usize = 1000;

/// Results of a trainee's attempts at an exercise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Whether each judged attempt passed, in order of time.
    pub passed: Vec<bool>,
    /// The best score, 0 to 100; 0 without attempts.
    pub best: f64,
}

/// An attempt that was judged.
#[derive(Clone, Copy, Debug, PartialEq)]
struct JudgedTry {
    at: OffsetDateTime,
    session: Uuid,
    passed: bool,
    score: f64,
}

/// Judged attempts of one pseudonym by exercise id, as far as they have been read.
#[derive(Clone, Default)]
pub struct History {
    trainee: String,
    tried: Arc<Mutex<BTreeMap<String, Vec<JudgedTry>>>>,
}

impl History {
    /// Starts reading the attempts of a pseudonym in a folder.
    #[must_use]
    pub fn of_folder(folder: PathBuf, trainee: String) -> Self {
        let history = Self { trainee, ..Self::default() };
        let theirs = history.clone();
        // If no thread can be started, there is no history; practising is still possible.
        let _ = thread::Builder::new().name("history".to_owned()).spawn(move || theirs.look_through(&folder));
        history
    }

    fn look_through(&self, folder: &Path) {
        let listed = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
        let mut paths: Vec<PathBuf> =
            listed.filter(|path| path.extension().is_some_and(|extension| extension == "mcap")).collect();
        // File names are UUIDv7 identifiers, which begin with the start time of the attempt.
        paths.sort();
        for path in paths.iter().rev().take(MOST) {
            let read = File::open(path).ok().and_then(|file| Recording::read(BufReader::new(file)).ok());
            let Some(recording) = read.filter(|recording| recording.session.trainee == self.trainee) else { continue };
            // Attempts that are void or cannot be judged are not counted.
            let judged = assessment::own_exercise(&recording).and_then(|own| assessment::assess(&recording, &own));
            if let Ok(assessment) = judged {
                self.add(&recording.session, &assessment);
            }
        }
    }

    /// Adds an attempt, unless it is another trainee's or already known.
    pub fn add(&self, session: &Session, assessment: &Assessment) {
        if session.trainee != self.trainee {
            return;
        }
        let tried = JudgedTry {
            at: session.started_at,
            session: session.session_id,
            passed: assessment.passed,
            score: assessment.score,
        };
        let mut all = self.tried.lock().unwrap_or_else(PoisonError::into_inner);
        let here = all.entry(session.exercise_id.clone()).or_default();
        if here.iter().all(|known| known.session != tried.session) {
            here.insert(here.partition_point(|known| known.at <= tried.at), tried);
        }
    }

    /// Returns the results of the attempts at an exercise.
    #[must_use]
    pub fn tally(&self, exercise: &str) -> Tally {
        let all = self.tried.lock().unwrap_or_else(PoisonError::into_inner);
        let here = all.get(exercise).map_or(&[][..], Vec::as_slice);
        Tally {
            passed: here.iter().map(|tried| tried.passed).collect(),
            best: here.iter().map(|tried| tried.score).fold(0.0, f64::max),
        }
    }
}

#[cfg(test)]
pub mod tests {
    //! Fails if an attempt counts that is void or another trainee's, or if one counts twice: the
    //! station would show a mastery that the school does not.

    use haptics::devices::scripted::Fault;
    use recording::EventKind;

    use super::*;
    use crate::live::tests::recorded;

    /// A history of one exercise: `P` for an attempt that passed, `F` for one that did not.
    pub fn of(exercise: &str, attempts: &str) -> History {
        let folder = tempfile::tempdir().expect("a folder");
        let (recording, bundle) = recorded(Fault::None, None, folder.path());
        let judged = assessment::assess(&recording, &bundle).expect("judged");
        let history = History::default();
        // Added in reverse order of time.
        for (minute, outcome) in attempts.chars().enumerate().collect::<Vec<_>>().into_iter().rev() {
            let session = Session {
                session_id: Uuid::new_v4(),
                exercise_id: exercise.to_owned(),
                started_at: OffsetDateTime::UNIX_EPOCH + time::Duration::minutes(minute as i64),
                ..recording.session.clone()
            };
            history.add(&session, &Assessment { passed: outcome == 'P', ..judged.clone() });
        }
        history
    }

    #[test]
    fn void_attempts_and_those_of_others_count_nowhere() {
        let folder = tempfile::tempdir().expect("a folder");
        let (good, _) = recorded(Fault::None, None, folder.path());
        fs::rename(folder.path().join("attempt.mcap"), folder.path().join("good.mcap")).expect("renamed");
        let (void, _) = recorded(Fault::Disconnect, None, folder.path());
        assert!(void.events.iter().any(|event| event.kind == EventKind::Interrupted));
        let history = History::default();
        history.look_through(folder.path());
        history.look_through(folder.path());
        assert_eq!(history.tally(&good.session.exercise_id).passed, [false], "the one that can be judged, once");
        let other = History { trainee: "other".to_owned(), ..History::default() };
        other.look_through(folder.path());
        assert!(other.tally(&good.session.exercise_id).passed.is_empty());
    }

    #[test]
    fn attempts_are_told_in_order_of_time() {
        assert_eq!(of("x", "PFFP").tally("x").passed, [true, false, false, true]);
    }
}
