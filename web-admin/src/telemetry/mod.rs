//! Traces and metrics for an OTLP collector, if the environment names one by the variables of the
//! OpenTelemetry specification (`OTEL_EXPORTER_OTLP_ENDPOINT` and related ones). The metrics are
//! those of `/metrics`. The span of a request contains its route's pattern, and never the user, the
//! client's address or an identifier.

#[cfg_attr(not(feature = "replicas"), path = "no_collector.rs")]
mod collector;

pub(crate) use collector::Telemetry;
use platform::config;

/// Returns the variables that name a collector, with their values.
fn name_collectors() -> Vec<String> {
    config::name_collectors().into_iter().map(|(name, value)| format!("{name}={value}")).collect()
}
