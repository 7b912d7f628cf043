//! Traces and figures for a collector that speaks OTLP, where the environment names one by the variables of the OpenTelemetry specification
//! (`OTEL_EXPORTER_OTLP_ENDPOINT` and those beside it). The figures are those of `/metrics`. A span of a request tells its route's pattern and
//! never who asks, from where, or for what.

#[cfg_attr(not(feature = "replicas"), path = "no_collector.rs")]
mod collector;

pub(crate) use collector::Telemetry;

/// Variables of which one at least names a collector.
const ENDPOINTS: [&str; 3] =
    ["OTEL_EXPORTER_OTLP_ENDPOINT", "OTEL_EXPORTER_OTLP_TRACES_ENDPOINT", "OTEL_EXPORTER_OTLP_METRICS_ENDPOINT"];

/// The variables that name a collector, with their values.
fn name_collectors() -> Vec<String> {
    let value = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
    ENDPOINTS.into_iter().filter_map(|name| Some(format!("{name}={}", value(name)?))).collect()
}
