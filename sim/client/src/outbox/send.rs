//! Sending from the outbox: to which service, with which token, how patiently, and what came of it.

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

/// The services that this call has a token for.
#[derive(Default)]
pub struct Access(Vec<Service>);

impl Access {
    /// The service that the call names, before the one that this station is paired with.
    ///
    /// # Errors
    /// When the pairing cannot be read.
    pub fn new(named: Option<Service>, pairing: Option<&Pairing>) -> Self {
        let paired = pairing.and_then(|p| Some(Service::new(&p.server, service::bearer_header(&p.token)?)));
        Self(named.into_iter().chain(paired).collect())
    }

    /// The service for an attempt: a token is only ever sent to the service that gave it.
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

/// How long the service may keep an upload to a connection that has died: half a minute of silence, and some more.
const HELD_FOR: Duration = Duration::from_secs(40);
/// Longest wait meanwhile.
const HELD_WAIT: Duration = Duration::from_secs(5);
/// HTTP's word for it.
const LOCKED: u16 = 423;

/// HTTP status of a recording that must not be kept.
const UNWANTED: u16 = 451;

/// How often one call tries, and how long it waits.
#[derive(Clone, Copy, Debug)]
pub struct Patience {
    /// Tries after the first that bring nothing. One that brings the upload forward is not counted.
    pub retries: u32,
    /// Wait before the first of them; it doubles with each.
    pub first_wait: Duration,
}

/// What became of an attempt.
#[derive(Debug, Serialize)]
pub struct Delivery {
    /// The file, as the call named it or as it was called when it was kept.
    pub recording: String,
    /// Its id in the outbox.
    pub id: String,
    /// The service has it on its disk.
    pub delivered: bool,
    /// The session it has become.
    pub session_id: Option<String>,
    /// It will never be taken.
    pub refused: bool,
    /// The last HTTP status of a refusal; absent when there was no answer.
    pub status: Option<u16>,
    /// How often it was tried.
    pub tries: u32,
    /// What was said, in words.
    pub detail: String,
}

impl Delivery {
    /// The recording was deleted because the service refuses to have it kept.
    pub fn is_removed(&self) -> bool {
        self.status == Some(UNWANTED)
    }
}

/// Sends attempts, one after the other, while no other program does.
pub struct Post<'a> {
    access: &'a Access,
    patience: Patience,
    _alone: std::fs::File,
}

impl<'a> Post<'a> {
    /// Begins to send from an outbox; waits until nobody else does.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn open(outbox: &Outbox, access: &'a Access, patience: Patience) -> Result<Self, Failure> {
        Ok(Self { access, patience, _alone: outbox.alone()? })
    }

    /// Sends an attempt and takes it out of the outbox, or notes there why not.
    ///
    /// # Errors
    /// When the outbox cannot be written to. What was delivered then is delivered again, which the service notices.
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
            // Our own last connection may hold the upload still: that passes, and is no failure of the service.
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
    /// Sends every attempt that is due; what came of each.
    ///
    /// # Errors
    /// When the outbox cannot be read or written to.
    pub fn send_due(&self, access: &Access, patience: Patience) -> Result<Vec<Delivery>, Failure> {
        let post = Post::open(self, access, patience)?;
        let now = clock::now();
        self.entries()?.iter_mut().filter(|entry| entry.is_due(now)).map(|entry| post.send(entry)).collect()
    }
}
