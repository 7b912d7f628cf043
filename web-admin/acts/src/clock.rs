//! The only place that reads the clock. Everything else is given the time, so that a test can set it.

use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
use std::time::Instant;

use model::Moment;
use time::OffsetDateTime;

/// Monotonic time, to measure how long another process has run.
#[must_use]
#[expect(clippy::disallowed_methods, reason = "this is the one place that reads the clock")]
pub fn instant() -> Instant {
    Instant::now()
}

/// The time of day: the machine's, or a test's.
#[derive(Clone, Debug, Default)]
pub struct Clock {
    fixed_us: Option<Arc<AtomicI64>>,
}

impl Clock {
    /// The machine's clock.
    #[must_use]
    pub fn system() -> Self {
        Self::default()
    }

    /// A clock that stands still until it is moved.
    #[must_use]
    pub fn fixed(at: Moment) -> Self {
        Self { fixed_us: Some(Arc::new(AtomicI64::new(at.micros()))) }
    }

    /// Moves a fixed clock forward by `seconds`, in s; the machine's clock is left alone.
    pub fn advance(&self, seconds: i64) {
        if let Some(us) = &self.fixed_us {
            us.fetch_add(seconds * 1_000_000, Ordering::SeqCst);
        }
    }

    /// Now.
    #[must_use]
    #[expect(clippy::disallowed_methods, reason = "this is the one place that reads the clock")]
    pub fn now(&self) -> Moment {
        match &self.fixed_us {
            Some(us) => Moment::from_micros(us.load(Ordering::SeqCst)),
            None => Moment::from(OffsetDateTime::now_utc()),
        }
    }
}
