//! Traces and metrics for an OTLP collector, if the environment names one by the variables of the
//! OpenTelemetry specification (`OTEL_EXPORTER_OTLP_ENDPOINT` and related ones). The metrics are
//! those of `/metrics`. The span of a request contains its route's pattern, and never the user, the
//! client's address or an identifier.

#[cfg_attr(not(feature = "replicas"), path = "no_collector.rs")]
mod collector;

pub(crate) use collector::Telemetry;

/// Variables of which at least one must name a collector.
const ENDPOINTS: [&str; 3] =
    ["OTEL_EXPORTER_OTLP_ENDPOINT", "OTEL_EXPORTER_OTLP_TRACES_ENDPOINT", "OTEL_EXPORTER_OTLP_METRICS_ENDPOINT"];

/// Returns the variables that name a collector, with their values.
fn name_collectors() -> Vec<String> {
    let value = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
    ENDPOINTS.into_iter().filter_map(|name| Some(format!("{name}={}", value(name)?))).collect()
}
