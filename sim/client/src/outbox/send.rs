//! Sends entries of the outbox: chooses the service and its token, retries, and reports the
//! results.

use std::time::Duration;

use serde::Serialize;

use super::deliver::Try;
use super::{Entry, Outbox};
use crate::exit::Failure;
use crate::service::{Outlook, Service, Trouble};
use crate::station::Pairing;
use crate::{clock, service};

/// Longest wait between two tries of one call.
const LONGEST_WAIT: Duration = Duration::from_secs(60);

/// The services for which this call has a token.
#[derive(Default)]
pub struct Access(Vec<Service>);

impl Access {
    /// The service named on the command line, followed by the one with which this station is
    /// paired. A pairing with an invalid token is left out.
    pub fn new(named: Option<Service>, pairing: Option<&Pairing>) -> Self {
        let paired = pairing.and_then(|p| Some(Service::new(&p.server, service::bearer_header(&p.token)?)));
        Self(named.into_iter().chain(paired).collect())
    }

    /// Returns the service for an entry: a token is sent only to the service that issued it.
    fn for_entry(&self, entry: &Entry) -> Result<&Service, Trouble> {
        let found = match &entry.note.server {
            Some(server) => self.0.iter().find(|service| service.address == *server),
            None => self.0.first(),
        };
        let place = entry.note.server.as_deref().unwrap_or("any service");
        let missing = format!("no token for {place}: pair this station (stylet pair --server URL)");
        found.ok_or_else(|| Trouble::new(Outlook::Later, missing))
    }
}

/// Time for which the service may hold an upload for a dead connection: half a minute of silence,
/// and a margin.
const HELD_FOR: Duration = Duration::from_secs(40);
/// Longest wait in that time.
const HELD_WAIT: Duration = Duration::from_secs(5);
/// HTTP status of an upload that is held.
const LOCKED: u16 = 423;

/// HTTP status of a recording that must not be kept.
const UNWANTED: u16 = 451;

/// Number of retries of one call, and the wait between them.
#[derive(Clone, Copy, Debug)]
pub struct Patience {
    /// Number of retries without progress. A try with progress resets the count.
    pub retries: u32,
    /// Wait before the first retry; doubled each time.
    pub first_wait: Duration,
}

/// The result of sending an entry.
#[derive(Debug, Serialize)]
pub struct Delivery {
    /// Name of the recording's file when it was added; for answers, a description.
    pub recording: String,
    /// Its id in the outbox.
    pub id: String,
    /// Whether the service has stored it.
    pub delivered: bool,
    /// Id of the session that it became; for answers, of the session that they are about.
    pub session_id: Option<String>,
    /// Whether the service has rejected it permanently.
    pub refused: bool,
    /// HTTP status of the last error; `None` without a response.
    pub status: Option<u16>,
    /// Number of tries.
    pub tries: u32,
    /// The result or error, for the user.
    pub detail: String,
}

impl Delivery {
    /// Whether the recording was deleted because the service answered that it must not be kept.
    pub fn is_removed(&self) -> bool {
        self.status == Some(UNWANTED)
    }
}

/// Sends entries, one after the other, while it holds the outbox's lock.
pub struct Post<'a> {
    access: &'a Access,
    patience: Patience,
    _alone: std::fs::File,
}

impl<'a> Post<'a> {
    /// Starts sending from an outbox; waits until no other process does.
    ///
    /// # Errors
    /// If the outbox cannot be locked.
    pub fn open(outbox: &Outbox, access: &'a Access, patience: Patience) -> Result<Self, Failure> {
        Ok(Self { access, patience, _alone: outbox.alone()? })
    }

    /// Sends an entry and deletes it from the outbox, or notes the error there.
    ///
    /// # Errors
    /// If the outbox cannot be written to. A delivered entry is then sent again, which the service
    /// detects.
    pub fn send(&self, entry: &mut Entry) -> Result<Delivery, Failure> {
        let (tries, sent) = self.persevere(entry);
        let noted = match &sent {
            Ok(_) => entry.remove(),
            Err(trouble) if trouble.outlook == Outlook::Unwanted => entry.remove_everywhere(),
            Err(trouble) => entry.failed(trouble),
        };
        noted.map_err(|error| Failure::work(format_args!("{}: {error}", entry.file.display())))?;
        let (session_id, status, refused, detail) = match sent {
            Ok(session) if entry.is_answers() => (Some(session), None, false, "taken".to_owned()),
            Ok(session) => (Some(session.clone()), None, false, format!("session {session}")),
            Err(trouble) => {
                let refused = matches!(trouble.outlook, Outlook::Never | Outlook::Unwanted);
                (None, trouble.status, refused, trouble.detail)
            }
        };
        let detail = if tries > 1 { format!("{detail} (after {tries} tries)") } else { detail };
        let (recording, id) = (entry.note.name.clone(), entry.id.clone());
        Ok(Delivery { recording, id, delivered: session_id.is_some(), session_id, refused, status, tries, detail })
    }

    fn persevere(&self, entry: &mut Entry) -> (u32, Result<String, Trouble>) {
        let service = match self.access.for_entry(entry) {
            Ok(service) => service,
            Err(trouble) => return (0, Err(trouble)),
        };
        let begun = clock::instant();
        let (mut tries, mut left, mut wait, mut reached) = (0, self.patience.retries, self.patience.first_wait, 0);
        loop {
            tries += 1;
            let mut attempt = Try::new(service, entry);
            let trouble = match attempt.deliver() {
                Ok(session) => return (tries, Ok(session)),
                Err(trouble) => trouble,
            };
            if attempt.reached > reached {
                (reached, left, wait) = (attempt.reached, self.patience.retries, self.patience.first_wait);
            }
            if trouble.outlook != Outlook::Soon || left == 0 {
                return (tries, Err(trouble));
            }
            // A dead connection of our own may still hold the upload. That ends by itself and uses
            // up no retry.
            let is_held = trouble.status == Some(LOCKED) && begun.elapsed() < HELD_FOR;
            if is_held {
                wait = wait.min(HELD_WAIT);
            } else {
                left -= 1;
            }
            std::thread::sleep(wait);
            wait = (wait * 2).min(LONGEST_WAIT);
        }
    }
}

impl Outbox {
    /// Sends every due entry; returns the results.
    ///
    /// # Errors
    /// If the outbox cannot be read or written to.
    pub fn send_due(&self, access: &Access, patience: Patience) -> Result<Vec<Delivery>, Failure> {
        let post = Post::open(self, access, patience)?;
        let now = clock::now();
        self.entries()?.iter_mut().filter(|entry| entry.is_due(now)).map(|entry| post.send(entry)).collect()
    }
}
