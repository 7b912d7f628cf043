//! Request metrics, and the probe of database writes, for operators.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use acts::Service;
use acts::error::error_chain;
use axum::http::StatusCode;
use model::Moment;
use tokio::sync::Mutex;

/// Upper bounds of the histogram buckets of response times, in µs.
const TIMES_US: [u64; 8] = [5_000, 10_000, 25_000, 50_000, 150_000, 500_000, 2_000_000, 10_000_000];

/// Requests answered since the start, by the first digit of their status and by their duration.
#[derive(Debug, Default)]
pub struct Counters {
    by_class: [AtomicU64; 5],
    by_time: [AtomicU64; TIMES_US.len()],
    answered: AtomicU64,
    total_us: AtomicU64,
}

impl Counters {
    /// Counts a response by its status and duration.
    pub fn count(&self, status: StatusCode, took_us: u64) {
        let class = usize::from(status.as_u16() / 100).saturating_sub(1);
        if let Some(counter) = self.by_class.get(class) {
            counter.fetch_add(1, Ordering::Relaxed);
        }
        // Prometheus buckets are cumulative.
        for (_, counter) in TIMES_US.iter().zip(&self.by_time).filter(|(end, _)| took_us <= **end) {
            counter.fetch_add(1, Ordering::Relaxed);
        }
        self.answered.fetch_add(1, Ordering::Relaxed);
        self.total_us.fetch_add(took_us, Ordering::Relaxed);
    }

    /// Returns the counters as metric families.
    #[must_use]
    pub fn list_families(&self) -> Vec<MetricFamily> {
        let now = |counter: &AtomicU64| counter.load(Ordering::Relaxed) as f64;
        let seconds = |us: f64| us / 1e6;
        let statuses = self.by_class.iter().enumerate();
        let statuses = statuses.map(|(i, n)| MetricFigure::labelled("status", format!("{}xx", i + 1), now(n)));
        let bucket = |end: String, n| MetricFigure { suffix: "_bucket", ..MetricFigure::labelled("le", end, n) };
        let times = TIMES_US.iter().zip(&self.by_time).map(|(end, n)| bucket(seconds(*end as f64).to_string(), now(n)));
        let answered = now(&self.answered);
        let rest = [
            bucket("+Inf".to_owned(), answered),
            MetricFigure { suffix: "_sum", label: None, value: seconds(now(&self.total_us)) },
            MetricFigure { suffix: "_count", label: None, value: answered },
        ];
        vec![
            MetricFamily {
                name: "stylet_http_requests_total",
                kind: MetricKind::Counter,
                help: "Requests answered.",
                figures: statuses.collect(),
            },
            MetricFamily {
                name: "stylet_http_request_seconds",
                kind: MetricKind::Histogram,
                help: "Time to answer a request, in s.",
                figures: times.chain(rest).collect(),
            },
        ]
    }
}

/// Maximum duration of a test write, ...
const LONGEST_BEAT: Duration = Duration::from_secs(4);
/// ... and minimum time between two of them, in µs.
const BEAT_EVERY_US: i64 = 5_000_000;

/// Whether the database accepted the last test write. It is repeated at most once per
/// [`BEAT_EVERY_US`], however often it is queried.
#[derive(Debug, Default)]
pub struct Pulse(Mutex<Option<(Moment, bool)>>);

impl Pulse {
    /// Whether the database accepts a write now, or did at the last test.
    pub async fn is_beating(&self, state: &Service) -> bool {
        // Held during the test write, so that concurrent probes share its result.
        let mut last = self.0.lock().await;
        let now = state.clock.now();
        match *last {
            Some((at, beats)) if (0..BEAT_EVERY_US).contains(&now.micros().saturating_sub(at.micros())) => beats,
            _ => {
                let beats = beat(state).await;
                *last = Some((now, beats));
                beats
            }
        }
    }
}

/// Whether the database accepts a write in time.
async fn beat(state: &Service) -> bool {
    match tokio::time::timeout(LONGEST_BEAT, state.db.beat(state.clock.now())).await {
        Ok(Ok(())) => return true,
        Ok(Err(error)) => tracing::warn!(cause = error_chain(&error), "database is not writable"),
        Err(_silent) => tracing::warn!("the database does not respond"),
    }
    false
}

/// Kind of a metric: gauges go up and down, the others only grow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MetricKind {
    /// Goes up and down.
    Gauge,
    /// Only grows.
    Counter,
    /// Cumulative buckets, which only grow.
    Histogram,
}

/// A sample of a family.
#[derive(Clone, Debug, PartialEq)]
pub struct MetricFigure {
    /// Suffix of the family's name.
    pub suffix: &'static str,
    /// Name and value of its label.
    pub label: Option<(&'static str, String)>,
    /// In the family's unit.
    pub value: f64,
}

impl MetricFigure {
    /// Returns a sample with a label.
    #[must_use]
    pub fn labelled(label: &'static str, named: String, value: f64) -> Self {
        Self { suffix: "", label: Some((label, named)), value }
    }
}

/// Samples of one metric.
#[derive(Clone, Debug, PartialEq)]
pub struct MetricFamily {
    /// Name of the family.
    pub name: &'static str,
    /// Kind of the metric.
    pub kind: MetricKind,
    /// Help text, one sentence.
    pub help: &'static str,
    /// Its samples.
    pub figures: Vec<MetricFigure>,
}

impl MetricFamily {
    /// Returns a family of gauges.
    #[must_use]
    pub fn gauges(name: &'static str, help: &'static str, figures: Vec<MetricFigure>) -> Self {
        Self { name, kind: MetricKind::Gauge, help, figures }
    }

    /// Returns a family with a single gauge without a label.
    #[must_use]
    pub fn gauge(name: &'static str, help: &'static str, value: f64) -> Self {
        Self::gauges(name, help, vec![MetricFigure { suffix: "", label: None, value }])
    }

    /// Formats the family in the text format of Prometheus.
    #[must_use]
    pub fn write(&self) -> String {
        let Self { name, kind, help, figures } = self;
        let kind = match kind {
            MetricKind::Gauge => "gauge",
            MetricKind::Counter => "counter",
            MetricKind::Histogram => "histogram",
        };
        let line = |MetricFigure { suffix, label, value }: &MetricFigure| {
            let label = label.as_ref().map_or_else(String::new, |(label, named)| format!("{{{label}=\"{named}\"}}"));
            format!("{name}{suffix}{label} {value}\n")
        };
        let lines: String = figures.iter().map(line).collect();
        format!("# HELP {name} {help}\n# TYPE {name} {kind}\n{lines}")
    }
}
