//! Exports spans and metrics to a collector named in the environment.

use std::sync::{Arc, PoisonError, RwLock};
use std::time::Duration;

use acts::SPANS;
use acts::error::error_chain;
use anyhow::Context;
use opentelemetry::KeyValue;
use opentelemetry::metrics::{AsyncInstrument, Meter, MeterProvider};
use opentelemetry::trace::TracerProvider;
use opentelemetry_otlp::{MetricExporter, Protocol, SpanExporter, WithExportConfig};
use opentelemetry_sdk::Resource;
use opentelemetry_sdk::metrics::SdkMeterProvider;
use opentelemetry_sdk::trace::SdkTracerProvider;
use routes_base::operations::monitoring::{MetricFamily, MetricFigure, MetricKind};
use tracing::Subscriber;
use tracing_subscriber::Layer;
use tracing_subscriber::filter::filter_fn;
use tracing_subscriber::registry::LookupSpan;

use super::name_collectors;
use crate::AppState;
use crate::routes::health::list_families;

/// Service name if `OTEL_SERVICE_NAME` is not set.
const NAME: &str = "web-admin";
/// Interval at which metrics are collected; they are sent every minute, unless
/// `OTEL_METRIC_EXPORT_INTERVAL` sets another interval.
const FIGURES_EVERY: Duration = Duration::from_secs(10);

/// The exporters of spans and metrics.
pub(crate) struct Telemetry {
    spans: SdkTracerProvider,
    figures: SdkMeterProvider,
}

impl Telemetry {
    /// Returns the exporters to the collector named in the environment; `None` if no collector is
    /// named.
    ///
    /// # Errors
    /// When a variable is invalid.
    pub(crate) fn of_environment() -> anyhow::Result<Option<Self>> {
        let named = name_collectors();
        if named.is_empty() {
            return Ok(None);
        }
        platform::settle_tls();
        let which =
            || format!("{}: allowed: the address of a collector, such as http://collector:4318", named.join(", "));
        let spans = SpanExporter::builder().with_http().with_protocol(Protocol::HttpBinary).build();
        let figures = MetricExporter::builder().with_http().with_protocol(Protocol::HttpBinary).build();
        let resource = resource();
        Ok(Some(Self {
            spans: SdkTracerProvider::builder()
                .with_resource(resource.clone())
                .with_batch_exporter(spans.with_context(which)?)
                .build(),
            figures: SdkMeterProvider::builder()
                .with_resource(resource)
                .with_periodic_exporter(figures.with_context(which)?)
                .build(),
        }))
    }

    /// Returns the layer that exports the program's spans.
    pub(crate) fn layer<S: Subscriber + for<'span> LookupSpan<'span>>(&self) -> impl Layer<S> + use<S> {
        let spans = filter_fn(|metadata| metadata.is_span() && metadata.target() == SPANS);
        tracing_opentelemetry::layer().with_tracer(self.spans.tracer(NAME)).with_filter(spans)
    }

    /// Collects the metrics of `/metrics` periodically, for as long as the future is polled.
    pub(crate) fn send_figures(&self, state: AppState) -> impl Future<Output = ()> + Send + use<> {
        let meter = self.figures.meter(NAME);
        async move {
            let latest: Arc<RwLock<Vec<MetricFamily>>> = Arc::default();
            let mut are_known = false;
            let mut ticks = tokio::time::interval(FIGURES_EVERY);
            loop {
                ticks.tick().await;
                match list_families(&state).await {
                    Ok(families) => *latest.write().unwrap_or_else(PoisonError::into_inner) = families,
                    Err(error) => {
                        tracing::warn!(cause = error_chain(&error), "failed to read the metrics of the service")
                    }
                }
                are_known = are_known || register_families(&meter, &latest);
            }
        }
    }

    /// Sends the remaining spans and metrics. Blocks.
    pub(crate) fn end(self) {
        for (what, ended) in [("spans", self.spans.shutdown()), ("figures", self.figures.shutdown())] {
            if let Err(error) = ended {
                tracing::warn!(cause = error_chain(&error), "failed to send the last {what}");
            }
        }
    }
}

/// Returns the resource attributes: service name and version.
fn resource() -> Resource {
    let builder = match std::env::var("OTEL_SERVICE_NAME") {
        Ok(name) if !name.is_empty() => Resource::builder(),
        _ => Resource::builder().with_service_name(NAME),
    };
    builder.with_attribute(KeyValue::new("service.version", env!("CARGO_PKG_VERSION"))).build()
}

/// Creates an observable instrument for each metric; returns whether there are any metrics.
fn register_families(meter: &Meter, latest: &Arc<RwLock<Vec<MetricFamily>>>) -> bool {
    let families = latest.read().unwrap_or_else(PoisonError::into_inner);
    for family in families.iter() {
        let mut suffixes: Vec<&'static str> = family.figures.iter().map(|figure| figure.suffix).collect();
        suffixes.dedup();
        for suffix in suffixes {
            let (name, latest) = (family.name, Arc::clone(latest));
            let observe = move |to: &dyn AsyncInstrument<f64>| {
                let families = latest.read().unwrap_or_else(PoisonError::into_inner);
                let own = families.iter().filter(|family| family.name == name).flat_map(|family| &family.figures);
                own.filter(|figure| figure.suffix == suffix)
                    .for_each(|figure| to.observe(figure.value, &labels(figure)));
            };
            let full_name = format!("{name}{suffix}");
            match family.kind {
                MetricKind::Gauge => {
                    let gauge = meter.f64_observable_gauge(full_name).with_description(family.help);
                    gauge.with_callback(observe).build();
                }
                MetricKind::Counter | MetricKind::Histogram => {
                    let counter = meter.f64_observable_counter(full_name).with_description(family.help);
                    counter.with_callback(observe).build();
                }
            }
        }
    }
    !families.is_empty()
}

fn labels(figure: &MetricFigure) -> Vec<KeyValue> {
    figure.label.iter().map(|(name, value)| KeyValue::new(*name, value.clone())).collect()
}
