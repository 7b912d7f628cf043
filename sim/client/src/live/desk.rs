//! The school as a station sees it while somebody practises: who sits here, what is due, and where attempts go.
//!
//! Nothing here keeps a person waiting: each call to the service has a thread of its own, and the window reads what came of it.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use serde::Deserialize;
use serde_json::json;

use crate::exit::Failure;
use crate::outbox::{Access, Outbox, Patience};
use crate::service::{self, answer};
use crate::station::Pairing;

/// Who sits at the station.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq)]
pub struct SignedIn {
    /// The pseudonym that recordings carry.
    pub trainee: String,
    /// For the screen, never for a recording.
    pub display_name: String,
    /// What there is to train, what is due first.
    pub exercises: Vec<Listed>,
}

/// An exercise of the school.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq)]
pub struct Listed {
    /// Its identifier.
    pub exercise_id: String,
    /// The trainee may train it now.
    pub due: bool,
}

/// What has come of a call so far.
#[derive(Clone, Debug)]
pub enum Answer<T> {
    /// Nothing yet.
    Waiting,
    /// This.
    Came(T),
    /// Nothing, and why.
    Refused(String),
}

/// A call that is under way.
pub type Call<T> = Arc<Mutex<Answer<T>>>;

/// What a call has come to.
pub fn read<T: Clone>(call: &Call<T>) -> Answer<T> {
    call.lock().unwrap_or_else(PoisonError::into_inner).clone()
}

/// Asks in a thread of its own.
fn ask<T: Send + 'static>(work: impl FnOnce() -> Result<T, String> + Send + 'static) -> Call<T> {
    let call = Arc::new(Mutex::new(Answer::Waiting));
    let theirs = Arc::clone(&call);
    let started = thread::Builder::new().name("desk".to_owned()).spawn(move || {
        let answer = work().map_or_else(Answer::Refused, Answer::Came);
        *theirs.lock().unwrap_or_else(PoisonError::into_inner) = answer;
    });
    if let Err(error) = started {
        *call.lock().unwrap_or_else(PoisonError::into_inner) = Answer::Refused(error.to_string());
    }
    call
}

/// Signs a trainee in by the code from their own page.
pub fn sign_in(pairing: Pairing, code: String) -> Call<SignedIn> {
    ask(move || {
        let address = format!("{}/api/v1/stations/sign-in", pairing.server);
        let token = service::bearer(&pairing.token).ok_or("the station's token is spoilt: pair it again")?;
        let request = service::agent().post(&address).header("Authorization", token).content_type("application/json");
        let reply =
            answer(&address, request.send(json!({ "code": code }).to_string())).map_err(|trouble| trouble.detail)?;
        let signed_in = reply.json().filter(|_| reply.status == 200).and_then(|said| serde_json::from_value(said).ok());
        signed_in.ok_or_else(|| reply.words())
    })
}

/// Keeps a recording in the outbox and sends what is due; says in words what has become of it.
///
/// # Errors
/// When the outbox refuses it: it stays where it is.
pub fn deliver(recording: &Path, pairing: Pairing) -> Result<Call<String>, Failure> {
    /// The outbox tries again later, so the first try need not be patient.
    const PATIENCE: Patience = Patience { retries: 2, first_wait: Duration::from_secs(1) };
    let outbox = Outbox::open(None)?;
    let kept = outbox.keep(recording, Some(&pairing.server))?;
    Ok(ask(move || {
        let access = Access::new(None, Some(&pairing));
        let deliveries = outbox.send_due(&access, PATIENCE).map_err(|failure| failure.to_string())?;
        match deliveries.iter().find(|delivery| delivery.id == kept.id) {
            Some(delivery) if delivery.delivered => Ok(format!("delivered to {}", pairing.school)),
            Some(delivery) => Err(format!("waits in the outbox: {}", delivery.detail)),
            None => Err("waits in the outbox".to_owned()),
        }
    }))
}
