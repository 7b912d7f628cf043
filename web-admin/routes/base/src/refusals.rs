//! Logs refused requests: who asked, for what, from where.
//!
//! An object of another school or cohort is answered like one that does not exist, and both cases
//! are logged: neither the response nor its timing discloses which of the two it was.

use std::collections::BTreeMap;
use std::fmt;
use std::net::IpAddr;
use std::num::NonZeroU32;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use acts::stations::CallingStation;
use axum::extract::{MatchedPath, Request};
use axum::http::Method;
use axum::response::Response;
use governor::{DefaultKeyedRateLimiter, RateLimiter};
use model::CurrentPerson;
use model::ids::{PersonId, StationId};
use platform::rate_limit_log::quota;
use uuid::Uuid;

use crate::error::Denied;

/// Number of refusals logged individually per asker, and the interval for further ones, so that no
/// client can flood the log.
const NOTE_BURST: NonZeroU32 = NonZeroU32::new(20).unwrap();
const NOTE_PERIOD: Duration = Duration::from_secs(30);

/// The client of a refused request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Asker {
    /// A person, by id.
    Person(PersonId),
    /// A training station, by id.
    Station(StationId),
    /// A caller with an invalid or expired token.
    Stranger(IpAddr),
}

impl fmt::Display for Asker {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Person(id) => id.fmt(f),
            Self::Station(id) => id.fmt(f),
            Self::Stranger(_) => f.write_str("stranger"),
        }
    }
}

/// An asker with their role.
#[derive(Clone, Copy, Debug)]
pub struct KnownAsker {
    who: Asker,
    role: &'static str,
}

impl From<&CurrentPerson> for KnownAsker {
    fn from(person: &CurrentPerson) -> Self {
        Self { who: Asker::Person(person.id), role: person.role.as_str() }
    }
}

impl From<&CallingStation> for KnownAsker {
    fn from(station: &CallingStation) -> Self {
        Self { who: Asker::Station(station.id), role: "station" }
    }
}

/// The request, and the address of its client.
#[derive(Debug)]
pub struct RequestFacts {
    method: Method,
    /// The route's pattern with parameter names in place of ids; `None` if no route matches.
    route: Option<MatchedPath>,
    /// The last id in the address.
    object: Option<Uuid>,
    from: IpAddr,
}

impl RequestFacts {
    /// Returns the facts of a request before it is handled.
    pub fn by(request: &Request, from: IpAddr) -> Self {
        let parts = request.uri().path().rsplit('/');
        Self {
            method: request.method().clone(),
            route: request.extensions().get::<MatchedPath>().cloned(),
            object: parts.filter_map(|part| part.parse().ok()).next(),
            from,
        }
    }
}

/// Logs refusals, rate-limited per asker.
#[derive(Debug)]
pub struct RefusalLog {
    pace: DefaultKeyedRateLimiter<Asker>,
    untold: Mutex<BTreeMap<Asker, u64>>,
}

impl Default for RefusalLog {
    fn default() -> Self {
        Self { pace: RateLimiter::keyed(quota(NOTE_PERIOD, NOTE_BURST)), untold: Mutex::default() }
    }
}

impl RefusalLog {
    /// Logs a refusal, if the response is one.
    pub fn note(&self, asker: KnownAsker, asked: &RequestFacts, answer: &Response) {
        // A path without a route is no object that could be refused.
        if answer.extensions().get::<Denied>().is_some() && asked.route.is_some() {
            self.write(asker, asked, answer.status().as_u16());
        }
    }

    /// Logs that an invalid or expired token was used.
    pub fn note_token(&self, asked: &RequestFacts) {
        self.write(KnownAsker { who: Asker::Stranger(asked.from), role: "none" }, asked, 401);
    }

    fn write(&self, KnownAsker { who, role }: KnownAsker, asked: &RequestFacts, status: u16) {
        if self.pace.check_key(&who).is_err() {
            *self.untold.lock().unwrap_or_else(PoisonError::into_inner).entry(who).or_default() += 1;
            return;
        }
        let RequestFacts { method, route, object, from } = asked;
        let route = route.as_ref().map_or("none", MatchedPath::as_str);
        let object = object.map(|id| id.to_string()).unwrap_or_default();
        tracing::warn!(%who, role, %method, route, object, status, %from, "request refused: no access, or not found");
    }

    /// Logs the number of refusals that were not logged individually, and forgets askers without
    /// recent ones.
    pub fn tidy(&self) {
        let untold = std::mem::take(&mut *self.untold.lock().unwrap_or_else(PoisonError::into_inner));
        for (who, count) in untold {
            tracing::warn!(%who, count, "many refused requests; only counted from here on");
        }
        self.pace.retain_recent();
        self.pace.shrink_to_fit();
    }
}
