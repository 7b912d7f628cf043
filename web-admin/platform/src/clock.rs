//! The only place that reads the clock. All other code is passed the time, so that tests can set
//! it.

use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
use std::time::Instant;

use model::Moment;
use time::OffsetDateTime;

/// Returns monotonic time, to measure how long another process has run.
#[must_use]
#[expect(clippy::disallowed_methods, reason = "this is the one place that reads the clock")]
pub fn instant() -> Instant {
    Instant::now()
}

/// Wall-clock time: the system's, or a fixed one in tests.
#[derive(Clone, Debug, Default)]
pub struct Clock {
    fixed_us: Option<Arc<AtomicI64>>,
}

impl Clock {
    /// Returns the system clock.
    #[must_use]
    pub fn system() -> Self {
        Self::default()
    }

    /// Returns a clock that stands still until it is advanced.
    #[must_use]
    pub fn fixed(at: Moment) -> Self {
        Self { fixed_us: Some(Arc::new(AtomicI64::new(at.micros()))) }
    }

    /// Moves a fixed clock forward by `seconds`; has no effect on the system clock.
    pub fn advance(&self, seconds: i64) {
        if let Some(us) = &self.fixed_us {
            us.fetch_add(seconds * 1_000_000, Ordering::SeqCst);
        }
    }

    /// Returns the current time.
    #[must_use]
    #[expect(clippy::disallowed_methods, reason = "this is the one place that reads the clock")]
    pub fn now(&self) -> Moment {
        match &self.fixed_us {
            Some(us) => Moment::from_micros(us.load(Ordering::SeqCst)),
            None => Moment::from(OffsetDateTime::now_utc()),
        }
    }
}
