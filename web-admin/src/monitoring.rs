//! What is counted of requests, and whether the database takes writes: for whoever keeps the service running.

use std::sync::atomic::{AtomicU64, Ordering};

use acts::Service;
use axum::http::StatusCode;
use model::Moment;
use tokio::sync::Mutex;

/// Upper ends of the classes of answering times, in µs.
const TIMES_US: [u64; 8] = [5_000, 10_000, 25_000, 50_000, 150_000, 500_000, 2_000_000, 10_000_000];

/// Requests answered since the start, by the first digit of their status and by how long they took.
#[derive(Debug, Default)]
pub struct Counters {
    by_class: [AtomicU64; 5],
    by_time: [AtomicU64; TIMES_US.len()],
    answered: AtomicU64,
    total_us: AtomicU64,
}

impl Counters {
    pub(crate) fn count(&self, status: StatusCode, took_us: u64) {
        let class = usize::from(status.as_u16() / 100).saturating_sub(1);
        if let Some(counter) = self.by_class.get(class) {
            counter.fetch_add(1, Ordering::Relaxed);
        }
        // Prometheus counts each answer in every class that it fits.
        for (_, counter) in TIMES_US.iter().zip(&self.by_time).filter(|(end, _)| took_us <= **end) {
            counter.fetch_add(1, Ordering::Relaxed);
        }
        self.answered.fetch_add(1, Ordering::Relaxed);
        self.total_us.fetch_add(took_us, Ordering::Relaxed);
    }

    pub(crate) fn lines(&self) -> String {
        let now = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        let seconds = |us: u64| us as f64 / 1e6;
        let statuses = self.by_class.iter().enumerate();
        let statuses: Vec<_> = statuses.map(|(i, n)| (format!("{{status=\"{}xx\"}}", i + 1), now(n) as f64)).collect();
        let times = TIMES_US.iter().zip(&self.by_time);
        let times: Vec<_> =
            times.map(|(end, n)| (format!("_bucket{{le=\"{}\"}}", seconds(*end)), now(n) as f64)).collect();
        let answered = now(&self.answered) as f64;
        let rest = [
            ("_bucket{le=\"+Inf\"}".to_owned(), answered),
            ("_sum".to_owned(), seconds(now(&self.total_us))),
            ("_count".to_owned(), answered),
        ];
        write_metric_family("stylet_http_requests_total", "counter", "Requests answered.", &statuses)
            + &write_metric_family(
                "stylet_http_request_seconds",
                "histogram",
                "Time to answer a request, in s.",
                &[times, rest.to_vec()].concat(),
            )
    }
}

/// In µs.
const BEAT_EVERY_US: i64 = 5_000_000;

/// Whether the database took a write when that was last tried. However often somebody asks, it is tried once in
/// [`BEAT_EVERY_US`].
#[derive(Debug, Default)]
pub struct Pulse(Mutex<Option<(Moment, bool)>>);

impl Pulse {
    /// Whether it takes one now, or did a moment ago.
    pub(crate) async fn is_beating(&self, state: &Service) -> bool {
        let mut last = self.0.lock().await;
        let now = state.clock.now();
        match *last {
            Some((at, beats)) if (0..BEAT_EVERY_US).contains(&now.micros().saturating_sub(at.micros())) => beats,
            _ => {
                let beaten = state.db.beat(now).await;
                if let Err(error) = &beaten {
                    tracing::warn!(cause = %error, "the database takes nothing");
                }
                *last = Some((now, beaten.is_ok()));
                beaten.is_ok()
            }
        }
    }
}

/// A family of figures as Prometheus reads it: what it is, then each figure with its labels.
pub(crate) fn write_metric_family(name: &str, kind: &str, help: &str, figures: &[(String, f64)]) -> String {
    let lines: String = figures.iter().map(|(labels, value)| format!("{name}{labels} {value}\n")).collect();
    format!("# HELP {name} {help}\n# TYPE {name} {kind}\n{lines}")
}
